//! A table of the spec after the first pass, with its values by key. A value with an error is
//! absent; the first pass has reported the error.

use super::keys::Table;
use super::{Finding, Severity, Span, Spot, quantity as q};
use slewkit::{Matrix3, Vector3};
use std::cell::RefCell;
use std::fmt;
use std::rc::Rc;

/// Largest deviation from unit length of a vector that counts as a rounded unit vector.
const UNIT_ROUNDING: f64 = 1e-9;

/// Largest number of findings that are reported. A megabyte of invalid text could have a hundred
/// thousand findings.
pub(crate) const MAX_FINDINGS: usize = 100;

/// Returns the dotted path `path.name`.
pub(crate) fn join(path: &str, name: &str) -> String {
    if path.is_empty() { name.into() } else { format!("{path}.{name}") }
}

/// Stable code of a finding, such as `E0040` or `W0040`.
type Code = &'static str;

/// List of findings that all tables of a spec share.
#[derive(Clone, Debug, Default)]
pub(crate) struct Report(Rc<RefCell<Vec<Finding>>>);

impl Report {
    pub fn error(&self, code: Code, spot: Spot, reason: impl Into<String>, remedy: impl Into<String>) {
        self.push(Finding::error_at(code, spot, reason, remedy));
    }

    /// Adds an error to the report and returns `None`.
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

    /// Returns the value of a successful result. For an error, adds a finding to the report and
    /// returns `None`; its reason is the text of the error, and `told` supplies the code, the
    /// position and the remedy.
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

    /// Appends findings to the report.
    pub fn extend(&self, findings: Vec<Finding>) {
        self.0.borrow_mut().extend(findings);
    }

    /// Removes all findings from the report and returns them.
    pub fn take(&self) -> Vec<Finding> {
        self.0.take()
    }

    /// Returns true if the report contains an error, so that the spec cannot be used.
    pub fn failed(&self) -> bool {
        self.0.borrow().iter().any(|finding| finding.severity == Severity::Error)
    }
}

/// Value of a key after the first pass, according to the kind of the key.
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
    /// A single table, or the tables of a list.
    Tables(Vec<Section>),
}

/// Limits of several inputs: a common limit, or one limit for each input.
#[derive(Clone, Debug, PartialEq)]
pub(crate) enum Limits {
    All(f64),
    Each(Vec<f64>),
}

/// An angle as the user wrote it, with its key, which ends in the unit.
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

    /// Returns half a turn as text in the unit of the angle, for messages.
    pub fn half_turn(self) -> &'static str {
        if self.in_degrees() { "180 deg" } else { "π rad" }
    }
}

impl fmt::Display for Angle {
    fn fmt(&self, out: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(out, "{} {}", q::show(self.value), if self.in_degrees() { "deg" } else { "rad" })
    }
}

/// A table of the spec with its position.
#[derive(Clone, Debug)]
pub(crate) struct Section {
    pub span: Span,
    pub table: &'static Table,
    pub path: String,
    /// True if matrices and unit vectors are used to the last bit, without correction of rounding
    /// errors.
    pub keeps_rounding: bool,
    /// Report to which the errors and warnings of the table are added.
    pub report: Report,
    /// Keys and values of the table, in the order of the file.
    pub given: Vec<Given>,
}

/// A key of a table with its value. The key may be unknown.
#[derive(Clone, Debug)]
pub(crate) struct Given {
    pub name: String,
    /// Position of the value.
    pub span: Span,
    /// True if the value is the empty list `[]`.
    pub is_empty_list: bool,
    /// The value; `None` if the first pass has reported an error of the value.
    pub value: Option<Parsed>,
}

/// Defines methods that return the value of a key if it has a given kind.
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
        /// Returns the integer under `name`.
        whole: Whole => u64;
        vector: Vector => Vector3;
        quaternion: Quaternion => [f64; 4];
        /// Returns the rotation matrix or the inertia under `name`.
        matrix: Matrix => Matrix3;
        /// Returns the common limit or the individual limits under `name`.
        limits: Limits => Limits;
        /// Returns the vectors under `name`: axes, boresights or vertices.
        vectors: Vectors => Vec<Vector3>;
        /// Returns the triangles under `name`, as vertex numbers counted from 1.
        faces: Faces => Vec<[u32; 3]>;
        /// Returns the square matrix under `name` as a list of rows.
        square: Square => Vec<Vec<f64>>;
        texts: Texts => Vec<String>;
        /// Returns the boolean under `name`.
        flag: Flag => bool;
    }

    fn given(&self, name: &str) -> Option<&Given> {
        self.given.iter().find(|given| given.name == name)
    }

    fn value(&self, name: &str) -> Option<&Parsed> {
        debug_assert!(self.knows(name), "no key {name} in {}", self.path);
        self.given(name)?.value.as_ref()
    }

    /// Returns the integer under `name` as a count.
    pub fn count(&self, name: &str) -> Option<usize> {
        usize::try_from(self.whole(name)?).ok()
    }

    /// Returns the text under `name`, which may be a word of a choice.
    pub fn word(&self, name: &str) -> Option<&str> {
        match self.value(name)? {
            Parsed::Text(text) => Some(text),
            _ => None,
        }
    }

    /// Returns the tables under `name`: a single table, the tables of a list, or no tables if the
    /// key is absent. Returns `None` if the value is not a table.
    pub fn tables(&self, name: &str) -> Option<&[Section]> {
        match self.given(name) {
            None => Some(&[]),
            Some(Given { value: Some(Parsed::Tables(tables)), .. }) => Some(tables),
            Some(_) => None,
        }
    }

    /// Returns the table under `name`, if it exists.
    pub fn section(&self, name: &str) -> Option<&Section> {
        self.tables(name)?.first()
    }

    /// Returns the tables of the list under `name`; an empty slice if the key is absent.
    pub fn list(&self, name: &str) -> &[Section] {
        self.tables(name).unwrap_or(&[])
    }

    pub fn has(&self, name: &str) -> bool {
        self.given(name).is_some()
    }

    /// Returns whether the value under `name` is `[]`.
    pub fn is_empty_list(&self, name: &str) -> bool {
        self.given(name).is_some_and(|given| given.is_empty_list)
    }

    /// Returns whether the key `name` is one of the keys that this table may have.
    pub fn knows(&self, name: &str) -> bool {
        self.table.key(name).is_some()
    }

    /// Returns the position of the value under `name`, or the position of the table if the key is
    /// absent.
    pub fn spot(&self, name: &str) -> Spot {
        Spot { span: self.given(name).map_or(self.span, |given| given.span), key: join(&self.path, name) }
    }

    /// Returns the position of the table.
    pub fn here(&self) -> Spot {
        Spot { span: self.span, key: self.path.clone() }
    }

    /// Reports an error at the value under `name`.
    pub fn error(&self, code: Code, name: &str, reason: impl Into<String>, remedy: impl Into<String>) {
        self.report.error(code, self.spot(name), reason, remedy);
    }

    /// Reports an error of the whole table.
    pub fn error_here(&self, code: Code, reason: impl Into<String>, remedy: impl Into<String>) {
        self.report.error(code, self.here(), reason, remedy);
    }

    /// Reports an error at the value under `name`, and returns `None`.
    pub fn refuse<T>(
        &self,
        code: Code,
        name: &str,
        reason: impl Into<String>,
        remedy: impl Into<String>,
    ) -> Option<T> {
        self.report.refuse(code, self.spot(name), reason, remedy)
    }

    /// Reports an error of the whole table, and returns `None`.
    pub fn refuse_here<T>(
        &self,
        code: Code,
        reason: impl Into<String>,
        remedy: impl Into<String>,
    ) -> Option<T> {
        self.report.refuse(code, self.here(), reason, remedy)
    }

    /// Reports a warning at the value under `name`.
    pub fn warn(&self, code: Code, name: &str, reason: impl Into<String>, remedy: impl Into<String>) {
        self.report.warn(code, self.spot(name), reason, remedy);
    }

    /// Reports a warning about the whole table.
    pub fn warn_here(&self, code: Code, reason: impl Into<String>, remedy: impl Into<String>) {
        self.report.warn(code, self.here(), reason, remedy);
    }

    /// Returns the angle under the key `degrees`; if this key is absent, the angle under the key
    /// `radians`.
    pub fn angle(&self, degrees: &'static str, radians: &'static str) -> Option<Angle> {
        let key = if self.has(degrees) { degrees } else { radians };
        Some(Angle { key, value: self.number(key)? })
    }

    /// Returns the vector scaled to unit length. If the spec keeps rounding, a vector of unit
    /// length is returned unchanged.
    pub fn unit(&self, vector: Vector3) -> Vector3 {
        if self.keeps_rounding && (vector.norm() - 1.0).abs() <= UNIT_ROUNDING {
            return vector;
        }
        // The vector is scaled first, so that squares of very large or small components neither
        // overflow nor underflow.
        (vector / vector.amax()).normalize()
    }
}
