//! A table of the spec as the first pass has read it: values by name. A value is silently absent if
//! that pass has reported an error.

use super::keys::Table;
use super::{Finding, Severity, Span, Spot, quantity as q};
use slewkit::{Matrix3, Vector3};
use std::cell::RefCell;
use std::fmt;
use std::rc::Rc;

/// The largest deviation from 1 of the length of a unit vector by rounding.
const UNIT_ROUNDING: f64 = 1e-9;

/// The largest number of reported findings; a megabyte of nonsense could have a hundred thousand.
pub(crate) const MAX_FINDINGS: usize = 100;

/// Returns `path.name`.
pub(crate) fn join(path: &str, name: &str) -> String {
    if path.is_empty() { name.into() } else { format!("{path}.{name}") }
}

/// A stable code, `E0040` or `W0040`.
type Code = &'static str;

/// Collects findings; all tables of a spec share one.
#[derive(Clone, Debug, Default)]
pub(crate) struct Report(Rc<RefCell<Vec<Finding>>>);

impl Report {
    pub fn error(&self, code: Code, spot: Spot, reason: impl Into<String>, remedy: impl Into<String>) {
        self.push(Finding::error_at(code, spot, reason, remedy));
    }

    /// Reports an error and returns `None`.
    pub fn refuse<T>(
        &self,
        code: Code,
        spot: Spot,
        reason: impl Into<String>,
        remedy: impl Into<String>,
    ) -> Option<T> {
        self.error(code, spot, reason, remedy);
        None
    }

    /// Returns the value; or reports the error in its own words, with the code, the place and the
    /// remedy of `told`.
    pub fn accept<'r, T, E: fmt::Display>(
        &self,
        made: Result<T, E>,
        told: impl FnOnce(&E) -> (Code, Spot, &'r str),
    ) -> Option<T> {
        made.map_err(|error| {
            let (code, spot, remedy) = told(&error);
            self.error(code, spot, error.to_string(), remedy);
        })
        .ok()
    }

    pub fn warn(&self, code: Code, spot: Spot, reason: impl Into<String>, remedy: impl Into<String>) {
        let finding = Finding::error_at(code, spot, reason, remedy);
        self.push(Finding { severity: Severity::Warning, ..finding });
    }

    fn push(&self, finding: Finding) {
        let mut findings = self.0.borrow_mut();
        if findings.len() < 2 * MAX_FINDINGS {
            findings.push(finding);
        }
    }

    /// Adds findings from elsewhere.
    pub fn extend(&self, findings: Vec<Finding>) {
        self.0.borrow_mut().extend(findings);
    }

    /// Takes all findings out.
    pub fn take(&self) -> Vec<Finding> {
        self.0.take()
    }

    /// Returns whether the spec cannot be used.
    pub fn failed(&self) -> bool {
        self.0.borrow().iter().any(|finding| finding.severity == Severity::Error)
    }
}

/// The value of a key.
#[derive(Clone, Debug)]
pub(crate) enum Parsed {
    Number(f64),
    Whole(u64),
    Text(String),
    Texts(Vec<String>),
    Vector(Vector3),
    Vectors(Vec<Vector3>),
    Quaternion([f64; 4]),
    Matrix(Matrix3),
    Square(Vec<Vec<f64>>),
    Limits(Limits),
    Faces(Vec<[u32; 3]>),
    Flag(bool),
    /// A table, or the tables of a list.
    Tables(Vec<Section>),
}

/// One limit for all, or one for each.
#[derive(Clone, Debug, PartialEq)]
pub(crate) enum Limits {
    All(f64),
    Each(Vec<f64>),
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

    /// Returns half a turn in its unit, for messages.
    pub fn half_turn(self) -> &'static str {
        if self.in_degrees() { "180 deg" } else { "π rad" }
    }
}

impl fmt::Display for Angle {
    fn fmt(&self, out: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(out, "{} {}", q::show(self.value), if self.in_degrees() { "deg" } else { "rad" })
    }
}

/// A table of the spec and its place.
#[derive(Clone, Debug)]
pub(crate) struct Section {
    pub span: Span,
    pub table: &'static Table,
    pub path: String,
    /// Whether matrices and unit vectors keep every bit.
    pub keeps_rounding: bool,
    /// The report that receives the errors and warnings of the table.
    pub report: Report,
    /// Keys and values of the table, in the order of the file.
    pub given: Vec<Given>,
}

/// A key of a table with its value; unknown keys count too.
#[derive(Clone, Debug)]
pub(crate) struct Given {
    pub name: String,
    /// The place of the value.
    pub span: Span,
    /// Whether the value is `[]`.
    pub is_empty_list: bool,
    /// The value; `None` if the first pass has reported an error of the value.
    pub value: Option<Parsed>,
}

/// Values of one kind by name.
macro_rules! values_by_name {
    ($($(#[$doc:meta])* $name:ident: $kind:ident => $type:ty;)*) => {
        $(
            $(#[$doc])*
            pub fn $name(&self, name: &str) -> Option<$type> {
                match self.value(name)? {
                    Parsed::$kind(value) => Some(value.clone()),
                    _ => None,
                }
            }
        )*
    };
}

impl Section {
    values_by_name! {
        number: Number => f64;
        /// A whole number.
        whole: Whole => u64;
        vector: Vector => Vector3;
        quaternion: Quaternion => [f64; 4];
        /// A rotation matrix or an inertia.
        matrix: Matrix => Matrix3;
        /// One limit for all, or one for each.
        limits: Limits => Limits;
        /// One vector or several: axes, boresights, vertices.
        vectors: Vectors => Vec<Vector3>;
        /// Triangles, vertices counted from 1.
        faces: Faces => Vec<[u32; 3]>;
        /// A square matrix, rows.
        square: Square => Vec<Vec<f64>>;
        texts: Texts => Vec<String>;
        /// True or false.
        flag: Flag => bool;
    }

    fn given(&self, name: &str) -> Option<&Given> {
        self.given.iter().find(|given| given.name == name)
    }

    fn value(&self, name: &str) -> Option<&Parsed> {
        debug_assert!(self.knows(name), "no key {name} in {}", self.path);
        self.given(name)?.value.as_ref()
    }

    /// Returns a whole number of items.
    pub fn count(&self, name: &str) -> Option<usize> {
        usize::try_from(self.whole(name)?).ok()
    }

    /// Returns a word of a choice, or a text.
    pub fn word(&self, name: &str) -> Option<&str> {
        match self.value(name)? {
            Parsed::Text(text) => Some(text),
            _ => None,
        }
    }

    /// Returns the tables under `name`: one table, the tables of a list, or no table if the key is
    /// absent. Returns `None` if it holds anything else.
    pub fn tables(&self, name: &str) -> Option<&[Section]> {
        match self.given(name) {
            None => Some(&[]),
            Some(Given { value: Some(Parsed::Tables(tables)), .. }) => Some(tables),
            Some(_) => None,
        }
    }

    /// Returns the table `name`, if it exists.
    pub fn section(&self, name: &str) -> Option<&Section> {
        self.tables(name)?.first()
    }

    /// Returns the tables of the list `name`.
    pub fn list(&self, name: &str) -> &[Section] {
        self.tables(name).unwrap_or(&[])
    }

    pub fn has(&self, name: &str) -> bool {
        self.given(name).is_some()
    }

    /// Returns whether `name` is given as `[]`.
    pub fn is_empty_list(&self, name: &str) -> bool {
        self.given(name).is_some_and(|given| given.is_empty_list)
    }

    /// Returns whether such a table may have this key.
    pub fn knows(&self, name: &str) -> bool {
        self.table.key(name).is_some()
    }

    /// Returns the value of `name`, or the table if the value is missing.
    pub fn spot(&self, name: &str) -> Spot {
        Spot { span: self.given(name).map_or(self.span, |given| given.span), key: join(&self.path, name) }
    }

    /// Returns the table itself.
    pub fn here(&self) -> Spot {
        Spot { span: self.span, key: self.path.clone() }
    }

    /// Records an error at the value of `name`.
    pub fn error(&self, code: Code, name: &str, reason: impl Into<String>, remedy: impl Into<String>) {
        self.report.error(code, self.spot(name), reason, remedy);
    }

    /// Records an error of the table.
    pub fn error_here(&self, code: Code, reason: impl Into<String>, remedy: impl Into<String>) {
        self.report.error(code, self.here(), reason, remedy);
    }

    /// Reports an error at the value of `name`, and returns `None`.
    pub fn refuse<T>(
        &self,
        code: Code,
        name: &str,
        reason: impl Into<String>,
        remedy: impl Into<String>,
    ) -> Option<T> {
        self.report.refuse(code, self.spot(name), reason, remedy)
    }

    /// Reports an error of the table, and returns `None`.
    pub fn refuse_here<T>(
        &self,
        code: Code,
        reason: impl Into<String>,
        remedy: impl Into<String>,
    ) -> Option<T> {
        self.report.refuse(code, self.here(), reason, remedy)
    }

    /// Records a warning at the value of `name`.
    pub fn warn(&self, code: Code, name: &str, reason: impl Into<String>, remedy: impl Into<String>) {
        self.report.warn(code, self.spot(name), reason, remedy);
    }

    /// Records a warning about the table.
    pub fn warn_here(&self, code: Code, reason: impl Into<String>, remedy: impl Into<String>) {
        self.report.warn(code, self.here(), reason, remedy);
    }

    /// Returns the angle under one of two keys, the one in degrees first.
    pub fn angle(&self, degrees: &'static str, radians: &'static str) -> Option<Angle> {
        let key = if self.has(degrees) { degrees } else { radians };
        Some(Angle { key, value: self.number(key)? })
    }

    /// Returns the vector scaled to length 1. It is unchanged if it has that length and the spec
    /// keeps its rounding.
    pub fn unit(&self, vector: Vector3) -> Vector3 {
        if self.keeps_rounding && (vector.norm() - 1.0).abs() <= UNIT_ROUNDING {
            return vector;
        }
        // Scaled first, so that the squares of very long or short vectors stay within range.
        (vector / vector.amax()).normalize()
    }
}
