//! The second pass's view of a checked table: values by name, silently absent where the first pass
//! has already complained.

use super::check::{MAX_FINDINGS, join};
use super::diagnostic::{Finding, Severity, Spot};
use super::keys::{DIRECTION, Key, Kind, Table};
use super::quantity as q;
use super::tree::{Entry, Node, Value};
use super::values;
use crate::{Matrix3, Vector3};
use std::fmt;

/// How far the length of a unit vector may be from 1 by rounding.
const UNIT_ROUNDING: f64 = 1e-9;

/// Collects findings.
pub(crate) struct Report {
    pub findings: Vec<Finding>,
}

impl Report {
    pub fn error(&mut self, code: &'static str, spot: Spot, reason: String, remedy: impl Into<String>) {
        self.push(Severity::Error, code, spot, reason, remedy.into());
    }

    pub fn warn(&mut self, code: &'static str, spot: Spot, reason: String, remedy: impl Into<String>) {
        self.push(Severity::Warning, code, spot, reason, remedy.into());
    }

    fn push(&mut self, severity: Severity, code: &'static str, spot: Spot, reason: String, remedy: String) {
        if self.findings.len() < 2 * MAX_FINDINGS {
            self.findings.push(Finding { severity, code, spot, reason, remedy });
        }
    }

    /// Whether the spec cannot be used.
    pub fn failed(&self) -> bool {
        self.findings.iter().any(|finding| finding.severity == Severity::Error)
    }
}

/// An angle as written; the key ends in its unit.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Angle {
    pub key: &'static str,
    pub value: f64,
}

impl Angle {
    fn in_degrees(self) -> bool {
        self.key.ends_with("_deg")
    }

    pub fn degrees(self) -> f64 {
        if self.in_degrees() { self.value } else { self.value.to_degrees() }
    }

    pub fn radians(self) -> f64 {
        if self.in_degrees() { self.value.to_radians() } else { self.value }
    }

    /// Half a turn in its unit, for messages.
    pub fn half_turn(self) -> &'static str {
        if self.in_degrees() { "180 deg" } else { "π rad" }
    }
}

impl fmt::Display for Angle {
    fn fmt(&self, out: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(out, "{} {}", q::show(self.value), if self.in_degrees() { "deg" } else { "rad" })
    }
}

/// A table of the spec and where it is.
#[derive(Clone, Debug)]
pub(crate) struct Section<'a> {
    pub node: &'a Node,
    table: &'static Table,
    pub path: String,
    /// Whether matrices and unit vectors are taken to the last bit.
    pub keeps_rounding: bool,
}

impl<'a> Section<'a> {
    /// The whole spec.
    pub fn root(node: &'a Node, table: &'static Table) -> Self {
        let mut root = Self { node, table, path: String::new(), keeps_rounding: false };
        root.keeps_rounding = table.key("rounding").is_some() && root.word("rounding") == Some("keep");
        root
    }

    /// The table `name`, if it is there.
    pub fn section(&self, name: &str) -> Option<Section<'a>> {
        match self.kind(name) {
            Kind::Table(table) => {
                let (path, keeps_rounding) = (join(&self.path, name), self.keeps_rounding);
                Some(Section { node: self.node(name)?, table, path, keeps_rounding })
            }
            _ => None,
        }
    }

    /// The tables of the list `name`.
    pub fn list(&self, name: &str) -> Vec<Section<'a>> {
        let (Kind::List(table, _), Some(node)) = (self.kind(name), self.node(name)) else {
            return Vec::new();
        };
        let Value::Array(items) = &node.value else {
            return Vec::new();
        };
        self.items(items, table, &join(&self.path, name))
    }

    fn items(&self, items: &'a [Node], table: &'static Table, path: &str) -> Vec<Section<'a>> {
        let keeps_rounding = self.keeps_rounding;
        let section =
            |(index, node)| Section { node, table, path: format!("{path}.{index}"), keeps_rounding };
        items.iter().enumerate().map(section).collect()
    }

    pub fn entry(&self, name: &str) -> Option<&'a Entry> {
        self.node.entry(name)
    }

    pub fn has(&self, name: &str) -> bool {
        self.entry(name).is_some()
    }

    fn node(&self, name: &str) -> Option<&'a Node> {
        self.entry(name).map(|entry| &entry.node)
    }

    /// Whether such a table may have this key.
    pub fn knows(&self, name: &str) -> bool {
        self.key(name).is_some()
    }

    fn key(&self, name: &str) -> Option<&'static Key> {
        self.table.key(name)
    }

    /// What the tables say about `name`; a key that they do not have reads as absent.
    fn kind(&self, name: &str) -> Kind {
        debug_assert!(self.key(name).is_some(), "no key {name} in {}", self.path);
        self.key(name).map_or(Kind::Later(""), |key| key.kind)
    }

    /// The value of `name`, or the table where it is missing.
    pub fn spot(&self, name: &str) -> Spot {
        let span = self.node(name).map_or(self.node.span, |node| node.span);
        Spot { span, key: join(&self.path, name) }
    }

    /// The table itself.
    pub fn here(&self) -> Spot {
        Spot { span: self.node.span, key: self.path.clone() }
    }

    pub fn number(&self, name: &str) -> Option<f64> {
        match self.kind(name) {
            Kind::Number(quantity) => values::number(self.node(name)?, &quantity, &mut Vec::new()),
            Kind::Limit(quantity) => values::limit(self.node(name)?, &quantity, &mut Vec::new()),
            _ => None,
        }
    }

    /// The angle under one of two keys, the one in degrees first.
    pub fn angle(&self, degrees: &'static str, radians: &'static str) -> Option<Angle> {
        let key = if self.has(degrees) { degrees } else { radians };
        Some(Angle { key, value: self.number(key)? })
    }

    pub fn count(&self, name: &str) -> Option<usize> {
        match self.kind(name) {
            Kind::Count(least, most) => values::count(self.node(name)?, least, most, &mut Vec::new()),
            Kind::Steps => values::steps(self.node(name)?, &mut Vec::new()),
            _ => None,
        }
    }

    pub fn vector(&self, name: &str) -> Option<Vector3> {
        match self.kind(name) {
            Kind::Vector(quantity) => {
                values::vector(self.node(name)?, &quantity, &mut Vec::new()).map(Vector3::from)
            }
            _ => None,
        }
    }

    pub fn quaternion(&self, name: &str) -> Option<[f64; 4]> {
        values::quaternion(self.node(name)?, &q::ENTRY, &mut Vec::new())
    }

    /// A rotation matrix or an inertia.
    pub fn matrix(&self, name: &str) -> Option<Matrix3> {
        let node = self.node(name)?;
        let rows = match self.kind(name) {
            Kind::Inertia => values::inertia(node, &q::INERTIA, &mut Vec::new())?,
            _ => values::rows(node, &q::ENTRY, &mut Vec::new())?,
        };
        Some(Matrix3::from_fn(|row, column| rows[row][column]))
    }

    /// The number of steps of a simulation.
    pub fn long_steps(&self, name: &str) -> Option<u64> {
        values::long_steps(self.node(name)?, &mut Vec::new())
    }

    pub fn vertices(&self, name: &str) -> Option<Vec<Vector3>> {
        let vertices = values::vertices(self.node(name)?, &q::POSITION, &mut Vec::new())?;
        Some(vertices.into_iter().map(Vector3::from).collect())
    }

    /// Triangles, vertices counted from 1.
    pub fn faces(&self, name: &str) -> Option<Vec<[u32; 3]>> {
        values::faces(self.node(name)?, &mut Vec::new())
    }

    /// One limit for all, or one for each.
    pub fn limits(&self, name: &str) -> Option<values::Limits> {
        match self.kind(name) {
            Kind::Limits(quantity, count) => {
                values::limits(self.node(name)?, &quantity, count, &mut Vec::new())
            }
            _ => None,
        }
    }

    /// One vector or several, none of length zero.
    pub fn vectors(&self, name: &str) -> Option<Vec<Vector3>> {
        let vectors = values::vectors(self.node(name)?, &q::COMPONENT, &mut Vec::new())?;
        Some(vectors.into_iter().map(Vector3::from).collect())
    }

    /// The tables of a direction or of several, none where the key is absent; `None` if there is anything else.
    pub fn directions(&self, name: &str) -> Option<Vec<Section<'a>>> {
        let path = join(&self.path, name);
        let Some(node) = self.node(name) else { return Some(Vec::new()) };
        match &node.value {
            Value::Table(_) => {
                let keeps_rounding = self.keeps_rounding;
                Some(vec![Section { node, table: &DIRECTION, path, keeps_rounding }])
            }
            Value::Array(items) if items.iter().all(|item| matches!(item.value, Value::Table(_))) => (1
                ..=values::MAX_DIRECTIONS)
                .contains(&items.len())
                .then(|| self.items(items, &DIRECTION, &path)),
            _ => None,
        }
    }

    pub fn texts(&self, name: &str) -> Option<Vec<&'a str>> {
        values::texts(self.node(name)?, usize::MAX, &mut Vec::new())
    }

    pub fn axes(&self, name: &str) -> Option<Vec<Vector3>> {
        let axes = values::axes(self.node(name)?, &q::COMPONENT, &mut Vec::new())?;
        Some(axes.into_iter().map(Vector3::from).collect())
    }

    pub fn weight(&self, name: &str) -> Option<Vec<Vec<f64>>> {
        values::weight(self.node(name)?, &q::WEIGHT, &mut Vec::new())
    }

    /// The vector made of length 1; as it is where it has that length and the spec keeps its rounding.
    pub fn unit(&self, vector: Vector3) -> Vector3 {
        if self.keeps_rounding && (vector.norm() - 1.0).abs() <= UNIT_ROUNDING {
            return vector;
        }
        // Scaled first, so that the squares of very long or short vectors stay within range.
        (vector / vector.amax()).normalize()
    }

    /// A word of a choice, or a text.
    pub fn word(&self, name: &str) -> Option<&'a str> {
        let node = self.node(name)?;
        match self.kind(name) {
            Kind::Choice(now, later) => values::choice(node, now, later, &mut Vec::new()),
            Kind::Text(most) => values::text(node, most, &mut Vec::new()),
            _ => None,
        }
    }
}
