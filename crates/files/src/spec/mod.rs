//! Spec files: a maneuver, a sequence or a simulation as a user writes it, in TOML or JSON.
//!
//! ```text
//! text ──▶ tree with places ──▶ --set ──▶ check of names, types, ranges ──▶ Problem, Settings
//!                                                                       └─▶ Simulation
//! ```
//!
//! A spec with `[simulation]` or `[[bodies]]` describes a simulation. Any other spec describes a
//! sequence if it has `[[stop]]`, and otherwise a single maneuver. [`load`] reads every kind of
//! spec, [`read`] only a single maneuver.
//!
//! The names of keys state their units; in the library all quantities are in SI units. All errors
//! of a spec are reported at once, each with its position, its reason and a remedy. [`schema()`]
//! returns the JSON Schema of the format, and [`template`] returns a starter spec. [`SpecDocument`]
//! writes a maneuver with the keys of specs.
//!
//! A maneuver has these defaults:
//!
//! - three body torques of weight 1, and three forces along the reference axes if `[start]` has a
//!   position;
//! - zero angular velocities, and the number of steps of [`default_steps`];
//! - a body without force fields, limits and constraints;
//! - `path = "best"`, or `"as_given"` with `rotation_from_start`.
//!
//! In `rotation_from_start`, a quaternion, a matrix, or two or more Euler angles stand for the
//! shortest rotation. Axis and angle, a rotation vector, or a single Euler angle keep the angle as
//! written.
//!
//! A simulation has these defaults: the scheme Lie–Verlet, a row for every step, bodies at rest
//! without mutual gravity, and for a body with a shape the inertia of the shape. The gravity of a
//! body without a shape is expanded to second order in its size.
//!
//! # Why is the reader of specs written by hand and not derived with serde?
//!
//! A derived reader stops at the first error, and loses the positions of `--set` values and nested
//! tables. This reader reports all errors at once, each with line, column, reason with its numbers,
//! and a remedy. TOML and JSON are parsed to one kind of tree, whose nodes carry their positions.
//! Tables of keys (`spec/keys.rs`) drive the check, the suggestions of similar keys, the writer and
//! the JSON Schema: a new key is one line in a table, below its description. Later checks report
//! errors at the keys of a table that has been read
//! (`section.refuse("E0054", "axis_body", reason, remedy)`). The reader is long because helpful
//! messages are long, not because parsing is.

mod actuators;
mod any_of;
mod assemble;
mod attitude;
mod base;
mod body;
mod boundary;
mod check;
mod closed_loop;
mod constraint;
mod diagnostic;
mod difference;
mod dispersion;
mod environment;
mod expect;
mod grid;
mod json_text;
mod keys;
mod maneuver;
mod names;
mod orbit;
mod overrides;
mod paths;
mod quantity;
mod schema;
mod section;
mod shape;
mod simulation;
mod sky;
mod source;
mod stops;
mod suggest;
mod text;
mod toml_text;
mod tree;
mod values;
mod write;

pub use base::Base;
pub use closed_loop::{Chance, ClosedLoop};
pub use diagnostic::{Diagnostic, Diagnostics, Severity, escape, escape_lines};
pub(crate) use diagnostic::{Finding, Spot, cut};
pub use difference::Difference;
pub use dispersion::{Dispersion, Distribution, Nominal, Varied};
pub use expect::{EndExpect, Expect, Oscillation, Precession, SimulationExpect, Toleranced};
pub(crate) use json_text::parse as parse_json;
pub use maneuver::default_steps;
pub use overrides::Override;
pub(crate) use overrides::typed;
pub(crate) use quantity::{short, show};
pub use schema::schema;
pub(crate) use section::{Angle, Limits, Report, Section};
pub use sky::{Heavens, Named};
pub use source::Origin;
pub(crate) use source::{Source, Span};
pub(crate) use tree::{Entry, Node, Value};
pub use write::{SpecDocument, Unwritable};

use crate::identity::Identity;
pub(crate) use keys::MOST_CASES;
use keys::{ROOT, SIMULATION_ROOT};
use slewkit::Vector3;
use slewkit::maneuver::{Problem, Settings};
use slewkit::mechanics::full_body::{Attractor, Dumbbell};
use slewkit::propagate::simulate::Simulation;
use slewkit::sequence::{Place, Sequence};
use std::io::Read;
use std::path::{Path, PathBuf};

/// Largest size of a spec \[bytes\].
pub const MAX_BYTES: usize = 1 << 20;

/// File format of a spec.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Format {
    /// TOML, the default.
    Toml,
    /// Strict JSON, without comments and trailing commas.
    Json,
}

impl Format {
    /// Returns JSON for file names that end in `.json`, and TOML for all others.
    pub fn of(path: &Path) -> Self {
        let json = path.extension().is_some_and(|extension| extension.eq_ignore_ascii_case("json"));
        if json { Self::Json } else { Self::Toml }
    }
}

/// A checked spec of a single maneuver, ready to be planned.
#[derive(Clone, Debug)]
pub struct Loaded {
    /// Maneuver that the spec describes, in SI units.
    pub problem: Problem,
    /// Settings of the solver.
    pub settings: Settings,
    /// Required result of the plan, if the spec has `[expect]`.
    pub expect: Option<Expect>,
    /// Names and epoch of the maneuver, for files of other programs.
    pub identity: Identity,
    /// Random quantities, if the spec has `[dispersion]`.
    pub dispersion: Option<Dispersion>,
    /// Named targets and the sky that determines their directions, if the spec has named targets.
    pub heavens: Option<Heavens>,
    /// Feedback, uncertainty and plant model for simulated flights of the plan.
    pub closed_loop: ClosedLoop,
    /// Files to which the spec refers; no output may replace them.
    pub files: Vec<PathBuf>,
    /// Warnings, in the order of the file.
    pub warnings: Vec<Diagnostic>,
}

/// A checked spec with stops, ready to be planned.
#[derive(Clone, Debug)]
pub struct LoadedSequence {
    /// The spacecraft, its start and its stops, in SI units.
    pub sequence: Sequence,
    /// Settings of the solver.
    pub settings: Settings,
    /// Required result of the plan, if the spec has `[expect]`.
    pub expect: Option<Expect>,
    /// Names and epoch of the sequence, for files of other programs.
    pub identity: Identity,
    /// Feedback, uncertainty and plant model for simulated flights of the whole sequence.
    pub closed_loop: ClosedLoop,
    /// Files to which the spec refers; no output may replace them.
    pub files: Vec<PathBuf>,
    /// Warnings, in the order of the file.
    pub warnings: Vec<Diagnostic>,
}

/// A checked spec of a simulation, ready to be run.
#[derive(Clone, Debug)]
pub struct LoadedSimulation {
    /// Bodies, integrator and duration, in SI units.
    pub simulation: Simulation,
    /// Shape of each body, in the order of the bodies; `None` for a body without a shape.
    pub shapes: Vec<Option<BodyShape>>,
    /// Solid of each body, in the order of the bodies; `None` for a body whose shape has no faces.
    pub solids: Vec<Option<Solid>>,
    /// Required result of the simulation, if the spec has `[expect]`.
    pub expect: Option<SimulationExpect>,
    /// Files to which the spec refers and which were read.
    pub files: Vec<PathBuf>,
    /// Warnings, in the order of the file.
    pub warnings: Vec<Diagnostic>,
}

/// A homogeneous solid whose faces are given in the spec or in a file.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Solid {
    /// Number of triangular faces of the solid.
    pub faces: usize,
    /// Volume of the solid \[m³\].
    pub volume: f64,
    /// Center of mass in the coordinates of the given vertices \[m\]. It becomes the origin of the
    /// body axes.
    pub mass_center: Vector3,
}

/// Shape of a body of a simulation.
#[derive(Clone, Debug)]
pub enum BodyShape {
    /// Two spheres, connected by a rod.
    Dumbbell(Dumbbell),
    /// Any other shape, given by its gravity field.
    Other(Box<Attractor>),
}

/// A checked spec of any kind.
#[derive(Clone, Debug)]
pub enum Spec {
    /// A single maneuver.
    Maneuver(Box<Loaded>),
    /// A sequence of maneuvers with stops.
    Sequence(Box<LoadedSequence>),
    /// A simulation.
    Simulation(Box<LoadedSimulation>),
}

impl LoadedSequence {
    /// Returns the boresight that points at the target of the stop named `stop`, as a unit vector
    /// in body axes. Returns `None` if no stop has this name, or if the stop is given by an
    /// attitude.
    pub fn boresight(&self, stop: &str) -> Option<Vector3> {
        match self.sequence.stops.iter().find(|other| other.name == stop)?.place {
            Place::Aim(ref aim) => Some(aim.boresight),
            Place::Attitude(_) => None,
        }
    }
}

impl Spec {
    /// Returns the maneuver if the spec is a single maneuver, otherwise `None`.
    pub fn maneuver(self) -> Option<Loaded> {
        match self {
            Self::Maneuver(loaded) => Some(*loaded),
            Self::Sequence(_) | Self::Simulation(_) => None,
        }
    }

    /// Returns the warnings, in the order of the file.
    pub fn warnings(&self) -> &[Diagnostic] {
        match self {
            Self::Maneuver(loaded) => &loaded.warnings,
            Self::Sequence(loaded) => &loaded.warnings,
            Self::Simulation(loaded) => &loaded.warnings,
        }
    }
}

/// Reads the spec at `path`, which may be of any kind, in the format `format`. Relative paths in
/// the spec refer to its folder.
///
/// # Errors
/// Returns all errors and warnings of the file.
pub fn load(path: &Path, format: Format, overrides: &[Override]) -> Result<Spec, Diagnostics> {
    let name = path.display().to_string();
    let bytes = text::from_file(path, &name)?;
    interpret(text::decode(&bytes, &name)?, &name, folder_of(path), format, overrides, Wanted::Any)
}

/// Reads a spec of any kind from a stream such as standard input, up to its end or the size limit.
/// `name` is the name of the stream in messages. Relative paths in the spec refer to the current
/// folder.
///
/// # Errors
/// Returns the errors of [`load`].
pub fn load_from_reader(
    reader: impl Read,
    name: &str,
    format: Format,
    overrides: &[Override],
) -> Result<Spec, Diagnostics> {
    let bytes = text::from_stream(reader, name, None)?;
    interpret(text::decode(&bytes, name)?, name, Path::new(""), format, overrides, Wanted::Any)
}

/// Reads the maneuver or the sequence at `path` in the format `format`.
///
/// # Errors
/// Returns all errors of the file and its contents. If the spec is a simulation, this is an error.
pub fn read_planned(path: &Path, format: Format, overrides: &[Override]) -> Result<Spec, Diagnostics> {
    let name = path.display().to_string();
    let bytes = text::from_file(path, &name)?;
    interpret(text::decode(&bytes, &name)?, &name, folder_of(path), format, overrides, Wanted::Planned)
}

/// Reads a maneuver or a sequence from a stream such as standard input.
///
/// # Errors
/// Returns the errors of [`read_planned`].
pub fn planned_from_reader(
    reader: impl Read,
    name: &str,
    format: Format,
    overrides: &[Override],
) -> Result<Spec, Diagnostics> {
    let bytes = text::from_stream(reader, name, None)?;
    interpret(text::decode(&bytes, name)?, name, Path::new(""), format, overrides, Wanted::Planned)
}

/// Reads a spec of any kind from a text. `name` is the name of the text in messages. Relative paths
/// in the spec refer to `folder`.
///
/// # Errors
/// Returns all errors and warnings of the spec, in the order of the file.
pub fn load_from_str(
    text: &str,
    name: &str,
    folder: &Path,
    format: Format,
    overrides: &[Override],
) -> Result<Spec, Diagnostics> {
    interpret(text::decode(text.as_bytes(), name)?, name, folder, format, overrides, Wanted::Any)
}

/// Reads the maneuver at `path`, as JSON if the file name ends in `.json`, otherwise as TOML.
///
/// # Errors
/// Returns all errors of the file and its contents. If the spec is a sequence or a simulation, this
/// is an error.
pub fn read(path: &Path, overrides: &[Override]) -> Result<Loaded, Diagnostics> {
    read_as(path, Format::of(path), overrides)
}

/// Reads the maneuver at `path` in the format `format`.
///
/// # Errors
/// Returns the errors of [`read`].
pub fn read_as(path: &Path, format: Format, overrides: &[Override]) -> Result<Loaded, Diagnostics> {
    let name = path.display().to_string();
    let bytes = text::from_file(path, &name)?;
    maneuver(text::decode(&bytes, &name)?, &name, folder_of(path), format, overrides)
}

/// Reads a maneuver from a stream such as standard input, up to its end or the size limit.
///
/// # Errors
/// Returns the errors of [`read`].
pub fn from_reader(
    reader: impl Read,
    name: &str,
    format: Format,
    overrides: &[Override],
) -> Result<Loaded, Diagnostics> {
    let bytes = text::from_stream(reader, name, None)?;
    from_bytes(&bytes, name, format, overrides)
}

/// Reads a maneuver from bytes; `name` is their name in messages.
///
/// # Errors
/// Returns the errors of [`read`].
pub fn from_bytes(
    bytes: &[u8],
    name: &str,
    format: Format,
    overrides: &[Override],
) -> Result<Loaded, Diagnostics> {
    let text = text::decode(bytes, name)?;
    from_str(text, name, format, overrides)
}

/// Reads a maneuver from a text; `name` is its name in messages.
///
/// # Errors
/// Returns all errors and warnings of the spec, in the order of the file.
pub fn from_str(
    text: &str,
    name: &str,
    format: Format,
    overrides: &[Override],
) -> Result<Loaded, Diagnostics> {
    maneuver(text::decode(text.as_bytes(), name)?, name, Path::new(""), format, overrides)
}

fn maneuver(
    text: &str,
    name: &str,
    folder: &Path,
    format: Format,
    overrides: &[Override],
) -> Result<Loaded, Diagnostics> {
    match interpret(text, name, folder, format, overrides, Wanted::Maneuver)? {
        Spec::Maneuver(loaded) => Ok(*loaded),
        // Unreachable: `interpret` rejects sequences and simulations if only a maneuver is
        // accepted.
        Spec::Sequence(_) | Spec::Simulation(_) => Err(Diagnostics(Vec::new())),
    }
}

fn folder_of(path: &Path) -> &Path {
    path.parent().unwrap_or_else(|| Path::new(""))
}

/// Kinds of spec that a caller accepts.
#[derive(Clone, Copy, PartialEq, Eq)]
enum Wanted {
    Any,
    /// A maneuver or a sequence.
    Planned,
    Maneuver,
}

/// Reads a spec of a kind that `wanted` accepts. Relative paths in the spec refer to `folder`.
fn interpret(
    text: &str,
    name: &str,
    folder: &Path,
    format: Format,
    overrides: &[Override],
    wanted: Wanted,
) -> Result<Spec, Diagnostics> {
    let mut sources = vec![Source::new(name, text)];
    let root = match parse(&sources[0], format) {
        Ok(root) => root,
        Err(findings) => return Err(diagnostics(findings, &sources)),
    };
    let (root, findings) = overrides::apply(root, overrides, &mut sources);
    understand(&root, findings, &sources, name, folder, wanted)
}

/// Checks a tree and builds the spec. The findings of the parser are added to the report.
fn understand(
    root: &Node,
    findings: Vec<Finding>,
    sources: &[Source],
    name: &str,
    folder: &Path,
    wanted: Wanted,
) -> Result<Spec, Diagnostics> {
    let simulated = is_simulation(root);
    if let Some(key) = simulated.filter(|_| wanted != Wanted::Any) {
        let spot = Spot { span: key.key_span, key: key.key.clone() };
        let reason = format!("`{}` makes this spec a simulation: it has no maneuver", key.key);
        let remedy = "run `slew simulate` on it; or write [body], [start], [end] and [maneuver]";
        return Err(diagnostics(vec![Finding::error_at("E0018", spot, reason, remedy)], sources));
    }
    if let Some(key) = root.entry("stop").filter(|_| simulated.is_none() && wanted == Wanted::Maneuver) {
        let spot = Spot { span: key.key_span, key: key.key.clone() };
        let reason = "`stop` makes this spec a sequence, and one maneuver is needed here";
        let remedy = "run `slew plan` on it; or remove the stops";
        return Err(diagnostics(vec![Finding::error_at("E0018", spot, reason, remedy)], sources));
    }
    let table = if simulated.is_some() { &SIMULATION_ROOT } else { &ROOT };
    let section = check::check(root, table, findings);
    let report = section.report.clone();
    let stem = Path::new(name).file_stem().map_or(name.into(), |stem| stem.to_string_lossy());
    let spec = if simulated.is_some() {
        simulation::assemble(&section, &stem, folder).map(|assembled| {
            let simulation::Assembled { simulation, shapes, solids, expect, files } = assembled;
            Spec::Simulation(Box::new(LoadedSimulation {
                simulation,
                shapes,
                solids,
                expect,
                files,
                warnings: Vec::new(),
            }))
        })
    } else {
        assemble::assemble(&section, &stem, folder).map(|assembled| {
            let assemble::Assembled { mut problem, settings, expect, identity, heavens, stops } = assembled;
            let closed_loop = closed_loop::read(&section, root, &mut problem);
            let (files, warnings) = (base::files_named(root, folder), Vec::new());
            if let Some((stops, order)) = stops {
                let sequence = Sequence { craft: problem, stops, order };
                return Spec::Sequence(Box::new(LoadedSequence {
                    sequence,
                    settings,
                    expect,
                    identity,
                    closed_loop,
                    files,
                    warnings,
                }));
            }
            let dispersion = dispersion::read(&section, root);
            Spec::Maneuver(Box::new(Loaded {
                problem,
                settings,
                expect,
                identity,
                dispersion,
                heavens,
                closed_loop,
                files,
                warnings,
            }))
        })
    };
    let failed = report.failed();
    let list = diagnostics(report.take(), sources);
    match spec {
        Some(mut spec) if !failed => {
            match &mut spec {
                Spec::Maneuver(loaded) => loaded.warnings = list.0,
                Spec::Sequence(loaded) => loaded.warnings = list.0,
                Spec::Simulation(loaded) => loaded.warnings = list.0,
            }
            Ok(spec)
        }
        _ => Err(list),
    }
}

/// Returns the entry that makes the spec a simulation; `None` for a maneuver or a sequence. If a
/// spec has keys of both kinds, it is a simulation if it has `[simulation]`, otherwise a maneuver
/// if it has `[maneuver]`.
fn is_simulation(root: &Node) -> Option<&tree::Entry> {
    let decided = || root.entry("bodies").or_else(|| root.entry("gravity"));
    root.entry("simulation").or_else(|| if root.entry("maneuver").is_some() { None } else { decided() })
}

/// Returns a commented starter spec of a maneuver: a three-axis slew.
pub fn template() -> &'static str {
    include_str!("template.toml")
}

/// Returns a commented starter spec of a simulation: two bodies that attract each other.
pub fn simulation_template() -> &'static str {
    include_str!("simulation_template.toml")
}

/// Parses a text to a tree.
fn parse(source: &Source, format: Format) -> Result<Node, Vec<Finding>> {
    let text = &source.text;
    let wrong = |code, (start, end), reason: &str, remedy: &str| {
        Err(vec![Finding::error(code, Span { source: 0, start, end }, reason, remedy)])
    };
    let first = text.len() - text.trim_start().len();
    let empty = || wrong("E0001", (0, 0), "the spec is empty", "`slew init` writes a starter spec");
    if text[first..].is_empty() {
        return empty();
    }
    let braces = text[first..].starts_with('{');
    let root = match format {
        Format::Toml if braces => {
            let reason = "this looks like JSON, but is read as TOML";
            let remedy = "rename the file to .json, or use `--input json`";
            return wrong("E0013", (first, first + 1), reason, remedy);
        }
        Format::Toml => toml_text::parse(text)?,
        Format::Json => match json_text::parse(source) {
            Err(_) if !braces && toml_text::parse(text).is_ok() => {
                let reason = "this looks like TOML, but is read as JSON";
                let remedy = "rename the file to .toml, or use `--input toml`";
                return wrong("E0013", (first, first + 1), reason, remedy);
            }
            result => result?,
        },
    };
    match &root.value {
        Value::Table(entries) if entries.is_empty() => empty(),
        Value::Table(_) if root.entry("trajectory").is_some() && root.entry("exit_code").is_some() => {
            let reason = "this is a plan file, not a spec";
            let remedy =
                "`slew verify`, `slew report` and `slew export` read it; its key `spec` holds its spec";
            wrong("E0018", (first, first + 1), reason, remedy)
        }
        Value::Table(_) => Ok(root),
        other => {
            let reason = format!("a spec is an object, this is {}", other.kind());
            let place = (root.span.start, root.span.end);
            wrong("E0024", place, &reason, "write { \"format\": 1, … }")
        }
    }
}

/// Returns the findings as diagnostics with line and column, in the order of the file.
fn diagnostics(mut findings: Vec<Finding>, sources: &[Source]) -> Diagnostics {
    findings.sort_by_key(|finding| (finding.spot.span.source, finding.spot.span.start));
    findings.truncate(section::MAX_FINDINGS);
    Diagnostics(findings.into_iter().map(|finding| finding.resolve(sources)).collect())
}
