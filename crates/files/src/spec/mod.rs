//! Spec files: the maneuver or the simulation as a person writes it, in TOML or JSON.
//!
//! ```text
//! text ──▶ tree with places ──▶ --set ──▶ check of names, types, ranges ──▶ Problem, Settings
//!                                                                       └─▶ Simulation
//! ```
//!
//! A spec with `[simulation]` or `[[bodies]]` is simulated, any other planned: a maneuver, or a
//! sequence if it has `[[stop]]`. [`load`] reads every kind, [`read`] one maneuver.
//!
//! The keys state the units; inside the crate everything is SI. All errors of a spec are reported
//! at once, each with its place, its reason and a remedy. [`schema()`] returns the JSON Schema of
//! the format, [`template`] a first spec. [`SpecDocument`] writes a maneuver in these keys.
//!
//! The defaults of a maneuver are three body torques of weight 1, and three forces along the
//! reference axes if `[start]` has a position; angular velocities at rest; the number of steps of
//! [`default_steps`]; a free body; no limits and no constraints; `path = "best"`, or `"as_given"`
//! with `rotation_from_start`. With `rotation_from_start` a quaternion, a matrix, or two or more
//! Euler angles mean the shortest rotation; axis and angle, a rotation vector, or a single Euler
//! angle mean the angle as written.
//!
//! The defaults of a simulation are Lie–Verlet; a row for every step; bodies at rest without
//! mutual gravity; the inertia of a body with a shape. A body without a shape attracts to second
//! order in its size.
//!
//! # Why a hand-written reader of specs instead of serde derive?
//!
//! Derive stops at the first error and loses the place for `--set` and nested tables. This reader
//! reports all errors at once, each with line, column, reason with its numbers and a remedy. TOML
//! and JSON are parsed to one tree whose nodes carry spans, and tables of keys (`spec/keys.rs`)
//! drive the check, the nearest-key suggestions, the writer and the JSON Schema: a key is one
//! line there under its description. A table that has been read reports at its own keys
//! (`section.refuse("E0054", "axis_body", reason, remedy)`). Opinion: the reader is long because
//! helpful messages are long, not because parsing is.

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

/// The largest spec, in bytes.
pub const MAX_BYTES: usize = 1 << 20;

/// The notation of a spec.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Format {
    /// TOML, the default.
    Toml,
    /// JSON, strict.
    Json,
}

impl Format {
    /// Returns JSON for names that end in `.json`, and otherwise TOML.
    pub fn of(path: &Path) -> Self {
        let json = path.extension().is_some_and(|extension| extension.eq_ignore_ascii_case("json"));
        if json { Self::Json } else { Self::Toml }
    }
}

/// A spec that can be planned.
#[derive(Clone, Debug)]
pub struct Loaded {
    /// The maneuver, in SI units, checked.
    pub problem: Problem,
    /// The settings of the solver.
    pub settings: Settings,
    /// The required result of the plan, if the spec has one.
    pub expect: Option<Expect>,
    /// The names and the epoch for files of other programs.
    pub identity: Identity,
    /// The uncertain numbers, if the spec has any.
    pub dispersion: Option<Dispersion>,
    /// The directions of the named targets, if the spec has such targets.
    pub heavens: Option<Heavens>,
    /// The gains, the uncertainty and the plant.
    pub closed_loop: ClosedLoop,
    /// The files that it names, which no output may replace.
    pub files: Vec<PathBuf>,
    /// The warnings, in file order.
    pub warnings: Vec<Diagnostic>,
}

/// A spec with stops, which can be planned.
#[derive(Clone, Debug)]
pub struct LoadedSequence {
    /// The spacecraft, its start and its stops, in SI units, checked.
    pub sequence: Sequence,
    /// The settings of the solver.
    pub settings: Settings,
    /// The required result of the plan, if the spec has one.
    pub expect: Option<Expect>,
    /// The names and the epoch for files of other programs.
    pub identity: Identity,
    /// The files that it names, which no output may replace.
    pub files: Vec<PathBuf>,
    /// The warnings, in file order.
    pub warnings: Vec<Diagnostic>,
}

/// A spec that can be simulated.
#[derive(Clone, Debug)]
pub struct LoadedSimulation {
    /// Bodies, method and duration, in SI units, checked.
    pub simulation: Simulation,
    /// Shapes of the bodies, in their order; `None` for bodies without a shape.
    pub shapes: Vec<Option<BodyShape>>,
    /// The solids of the bodies with faces, in their order.
    pub solids: Vec<Option<Solid>>,
    /// The required result of the motion, if the spec has one.
    pub expect: Option<SimulationExpect>,
    /// Files that the spec names and the reader has read.
    pub files: Vec<PathBuf>,
    /// The warnings, in file order.
    pub warnings: Vec<Diagnostic>,
}

/// A homogeneous solid within the faces of the spec or of its file.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Solid {
    /// Number of triangles.
    pub faces: usize,
    /// Volume \[m³\].
    pub volume: f64,
    /// The mass center in the coordinates of the given vertices \[m\]; the origin of the body moves
    /// to it.
    pub mass_center: Vector3,
}

/// Shape of a body.
#[derive(Clone, Debug)]
pub enum BodyShape {
    /// Two spheres on a rod.
    Dumbbell(Dumbbell),
    /// Any other.
    Other(Box<Attractor>),
}

/// A spec of any kind.
#[derive(Clone, Debug)]
pub enum Spec {
    /// A maneuver.
    Maneuver(Box<Loaded>),
    /// A maneuver with stops.
    Sequence(Box<LoadedSequence>),
    /// A simulation.
    Simulation(Box<LoadedSimulation>),
}

impl LoadedSequence {
    /// Returns the boresight that points at the stop of this name, body axes; `None` for a stop that
    /// is an attitude.
    pub fn boresight(&self, stop: &str) -> Option<Vector3> {
        match self.sequence.stops.iter().find(|other| other.name == stop)?.place {
            Place::Aim(ref aim) => Some(aim.boresight),
            Place::Attitude(_) => None,
        }
    }
}

impl Spec {
    /// Returns the maneuver, if it is one without stops.
    pub fn maneuver(self) -> Option<Loaded> {
        match self {
            Self::Maneuver(loaded) => Some(*loaded),
            Self::Sequence(_) | Self::Simulation(_) => None,
        }
    }

    /// Returns the warnings, in file order.
    pub fn warnings(&self) -> &[Diagnostic] {
        match self {
            Self::Maneuver(loaded) => &loaded.warnings,
            Self::Sequence(loaded) => &loaded.warnings,
            Self::Simulation(loaded) => &loaded.warnings,
        }
    }
}

/// Reads the spec of either kind at `path` in the given notation. Files that it names are relative
/// to its folder.
///
/// # Errors
/// All errors and warnings of the file.
pub fn load(path: &Path, format: Format, overrides: &[Override]) -> Result<Spec, Diagnostics> {
    let name = path.display().to_string();
    let bytes = text::from_file(path, &name)?;
    interpret(text::decode(&bytes, &name)?, &name, folder_of(path), format, overrides, Wanted::Any)
}

/// Reads a spec of either kind from a stream, such as the standard input, to its end or to the
/// size limit; messages use `name` for it. Files that it names are relative to the current
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

/// Reads the maneuver or the sequence at `path` in the given notation.
///
/// # Errors
/// Returns all errors of the file or its contents; a simulation is an error.
pub fn read_planned(path: &Path, format: Format, overrides: &[Override]) -> Result<Spec, Diagnostics> {
    let name = path.display().to_string();
    let bytes = text::from_file(path, &name)?;
    interpret(text::decode(&bytes, &name)?, &name, folder_of(path), format, overrides, Wanted::Planned)
}

/// Reads a maneuver or a sequence from a stream, such as the standard input.
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

/// Reads a spec of either kind from text; messages use `name` for it, and files that it names are
/// relative to `folder`.
///
/// # Errors
/// Every error of the spec, in file order, with the warnings among them.
pub fn load_from_str(
    text: &str,
    name: &str,
    folder: &Path,
    format: Format,
    overrides: &[Override],
) -> Result<Spec, Diagnostics> {
    interpret(text::decode(text.as_bytes(), name)?, name, folder, format, overrides, Wanted::Any)
}

/// Reads the maneuver at `path`, in TOML or, if its name ends in `.json`, in JSON.
///
/// # Errors
/// Returns all errors of the file or its contents; a simulation is an error.
pub fn read(path: &Path, overrides: &[Override]) -> Result<Loaded, Diagnostics> {
    read_as(path, Format::of(path), overrides)
}

/// Reads the maneuver at `path` in the given notation.
///
/// # Errors
/// Returns the errors of [`read`].
pub fn read_as(path: &Path, format: Format, overrides: &[Override]) -> Result<Loaded, Diagnostics> {
    let name = path.display().to_string();
    let bytes = text::from_file(path, &name)?;
    maneuver(text::decode(&bytes, &name)?, &name, folder_of(path), format, overrides)
}

/// Reads a maneuver from a stream, such as the standard input, to its end or to the size limit.
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

/// Reads a maneuver from bytes that messages call `name`.
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

/// Reads a maneuver from text that messages call `name`.
///
/// # Errors
/// Every error of the spec, in file order, with the warnings among them.
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
        // `interpret` has refused them.
        Spec::Sequence(_) | Spec::Simulation(_) => Err(Diagnostics(Vec::new())),
    }
}

fn folder_of(path: &Path) -> &Path {
    path.parent().unwrap_or_else(|| Path::new(""))
}

/// The accepted kind of spec.
#[derive(Clone, Copy, PartialEq, Eq)]
enum Wanted {
    Any,
    /// One that is planned: a maneuver or a sequence.
    Planned,
    Maneuver,
}

/// Reads a spec. Files that it names are relative to `folder`.
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

/// Interprets a tree, and adds the errors and warnings of its parsing.
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
            if let Some((stops, order)) = stops {
                let sequence = Sequence { craft: problem, stops, order };
                let files = base::files_named(root, folder);
                let warnings = Vec::new();
                let loaded = LoadedSequence { sequence, settings, expect, identity, files, warnings };
                return Spec::Sequence(Box::new(loaded));
            }
            let dispersion = dispersion::read(&section, root);
            let closed_loop = closed_loop::read(&section, root, &mut problem);
            let warnings = Vec::new();
            Spec::Maneuver(Box::new(Loaded {
                problem,
                settings,
                expect,
                identity,
                dispersion,
                heavens,
                closed_loop,
                files: base::files_named(root, folder),
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

/// Returns the key that makes a spec a simulation; `None` for a maneuver. If a spec has keys of
/// both, `[maneuver]` makes it a maneuver unless it has `[simulation]`.
fn is_simulation(root: &Node) -> Option<&tree::Entry> {
    let decided = || root.entry("bodies").or_else(|| root.entry("gravity"));
    root.entry("simulation").or_else(|| if root.entry("maneuver").is_some() { None } else { decided() })
}

/// Returns a commented spec to start from: a three-axis slew.
pub fn template() -> &'static str {
    include_str!("template.toml")
}

/// Returns a commented simulation to start from: two bodies that attract one another.
pub fn simulation_template() -> &'static str {
    include_str!("simulation_template.toml")
}

/// Returns the tree of the file.
fn parse(source: &Source, format: Format) -> Result<Node, Vec<Finding>> {
    let text = &source.text;
    let wrong = |code, (start, end), reason: &str, remedy: &str| {
        Err(vec![Finding::error(code, Span { source: 0, start, end }, reason, remedy)])
    };
    let first = text.len() - text.trim_start().len();
    let empty = || wrong("E0001", (0, 0), "the spec is empty", "`slew init` writes a first spec");
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

/// Returns the findings in file order, with their positions.
fn diagnostics(mut findings: Vec<Finding>, sources: &[Source]) -> Diagnostics {
    findings.sort_by_key(|finding| (finding.spot.span.source, finding.spot.span.start));
    findings.truncate(section::MAX_FINDINGS);
    Diagnostics(findings.into_iter().map(|finding| finding.resolve(sources)).collect())
}
