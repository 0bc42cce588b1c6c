//! Hostile inputs: mutations of valid inputs of every kind that the program reads.
//!
//! A reader must either accept its input, or refuse it with a place, a reason and a remedy. It must
//! not panic, and must not take long.

use crate::Random;
use slewkit::mechanics::full_body::polyhedron::read_obj;
use slewkit::plan::{Silent, plan};
use slewkit::propagate::simulate::SimulationRow;
use slewkit_files::batch::{Batch, BatchError};
use slewkit_files::exchange::{Tables, read_attitudes};
use slewkit_files::export::{ExportError, PlanFile, read_guess};
use slewkit_files::formats;
use slewkit_files::spec::{self, Base, Diagnostics, Format, Loaded, Override, Severity, Spec};
use std::ops::ControlFlow;
use std::path::Path;
use std::{fs, io};

/// Texts that replace a number.
pub const NUMBERS: &[&str] = &[
    "nan",
    "-inf",
    "inf",
    "1e308",
    "-1e308",
    "1e-308",
    "5e-324",
    "1e999",
    "-1",
    "0",
    "-0.0",
    "0.5",
    "2",
    "1e6",
    "1e30",
    "1e-30",
    "99999999999999999999999",
    "9223372036854775807",
    "0xffffffffffffffffffff",
    "\"1\"",
    "true",
    "[]",
    "{}",
    "[[1]]",
    "1979-05-27",
    "'x'",
    "1e15",
    "360",
    "-720.5",
    "1e-9",
];
/// Words that are inserted at any place.
const WORDS: &[&str] = &[
    "=",
    "[",
    "]",
    "{",
    "}",
    ",",
    ".",
    "\"",
    "'",
    "\\u001b",
    "\\",
    "#",
    "\n",
    "\u{feff}",
    "é",
    "[[",
    "]]",
    "body",
    "attitude",
    "kind",
    "\"keep_in\"",
    "constraint",
    "points",
    "steps",
    "second_order",
    "uniform_gravity",
    "\"gravity_gradient\"",
    "null",
    "\t",
    "\r",
];
/// Keys of overrides, some of which do not exist.
const KEYS: &[&str] = &[
    "body.inertia_kg_m2",
    "end.attitude.euler_zyx_deg.1",
    "maneuver.steps",
    "maneuver.duration_s",
    "start",
    "environment.points.0.mass_kg",
    "end.position_m.2",
    "solver.tolerance",
    "expect.rivals",
    "a.b",
    "constraint.0.direction_inertial.ra_deg",
    "constraint.1.boresight_body.1.0",
    "bodies.0.shape.kind",
    "actuators.torque_limit_n_m",
    "bodies.1.shape.vertices_m.2.0",
    "bodies.1.shape.faces.0.1",
    "bodies.1.shape.obj",
    "simulation.integrator",
    "maneuver.path",
    "body.inertia_kg_m2.2",
    "solver",
    "simulation.step_s",
    "gravity.gravitational_constant_m3_kg_s2",
];

/// Returns `text` with up to three changes. `donor` is the source of lines that are inserted.
pub fn mutate(text: &str, donor: &str, random: &mut Random) -> Vec<u8> {
    let mut bytes = text.as_bytes().to_vec();
    for _ in 0..random.below(4) {
        let at = random.below(bytes.len());
        match random.below(8) {
            0 => bytes.truncate(at),
            1 if !bytes.is_empty() => bytes[at] = random.bits() as u8,
            2 if !bytes.is_empty() => bytes[at] = b' ' + (random.bits() % 95) as u8,
            3 => drop(bytes.splice(at..at, random.pick(WORDS).bytes())),
            4 => {
                // Replaces a number by another one.
                let digit = |byte: &u8| byte.is_ascii_digit();
                if let Some(start) = bytes.iter().skip(at).position(digit).map(|offset| at + offset) {
                    let part = |byte: &&u8| digit(byte) || **byte == b'.';
                    let length = bytes[start..].iter().take_while(part).count();
                    drop(bytes.splice(start..start + length, random.pick(NUMBERS).bytes()));
                }
            }
            5 => {
                // Duplicates or moves a line.
                let mut lines: Vec<Vec<u8>> =
                    bytes.split(|byte| *byte == b'\n').map(<[u8]>::to_vec).collect();
                let line = lines[random.below(lines.len())].clone();
                lines.insert(random.below(lines.len()), line);
                bytes = lines.join(&b'\n');
            }
            6 => {
                // Inserts a line of the other input.
                let lines: Vec<&str> = donor.lines().collect();
                if !lines.is_empty() {
                    let line = format!("\n{}\n", lines[random.below(lines.len())]);
                    let start = bytes[..at].iter().rposition(|byte| *byte == b'\n').unwrap_or(0);
                    drop(bytes.splice(start..start, line.into_bytes()));
                }
            }
            _ => {
                let end = (at + random.below(40)).min(bytes.len());
                bytes.drain(at..end);
            }
        }
    }
    bytes
}

/// A reader of the program that is tested.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Reader {
    Toml,
    Json,
    /// The reader of `--set`, applied to a valid spec.
    Set,
    PlanFile,
    Obj,
    /// The reader of a table of cases.
    Cases,
    /// The reader of AEM, in keywords or XML, and of tables of attitudes.
    Attitudes,
}

/// All readers.
pub const READERS: [Reader; 7] = [
    Reader::Toml,
    Reader::Json,
    Reader::Set,
    Reader::PlanFile,
    Reader::Obj,
    Reader::Cases,
    Reader::Attitudes,
];

/// The valid and invalid inputs that are mutated: files of the repository, and files that the
/// program writes.
pub struct Corpus {
    /// The reader of an input, whether the input is valid, and its text.
    seeds: Vec<(Reader, bool, String)>,
    /// Valid specs to which overrides are applied.
    specs: Vec<String>,
    base: Base,
    /// The folder for tables of cases, which are read from a file.
    folder: tempfile::TempDir,
}

/// The spec of a small maneuver, from whose plan the plan file and the tables are written.
const SMALL: &str = r#"
format = 1
epoch = "2026-11-21T07:00:00 UTC"
body = { inertia_kg_m2 = [[2, 0.1, 0], [0.1, 3, 0], [0, 0, 4]] }
start = { attitude = { axis = [0, 0, 1], angle_deg = 0 } }
end = { attitude = { euler_zyx_deg = [80, -25, 40] } }
maneuver = { duration_s = 60, steps = 6 }
[names]
object = "X"
reference_frame = "ICRF"
body_frame = "SC_BODY"
"#;

const CASES: &str = "name,maneuver.duration_s,end.attitude.euler_zyx_deg.1,body.inertia_kg_m2\nfirst,50,12,\n\
    second,,-3.5,\"[2, 3, 4]\"\n\n\"third, quoted\",61,1e1,\n";

impl Corpus {
    /// Reads the inputs from the repository, and writes the others.
    pub fn new() -> Result<Self, Box<dyn std::error::Error>> {
        let mut seeds = Vec::new();
        let root = Path::new(crate::ROOT);
        let mut folders =
            ["problems", "problems/published", "problems/shapes"].map(|one| root.join(one)).to_vec();
        let bad = root.join("tests/bad_inputs");
        // The wrong specs are in one folder for each table of the spec.
        for entry in fs::read_dir(&bad)? {
            folders.push(entry?.path());
        }
        for folder in folders {
            for entry in fs::read_dir(&folder)? {
                let path = entry?.path();
                let reader = match path.extension().and_then(|ending| ending.to_str()) {
                    Some("toml") => Reader::Toml,
                    Some("json") => Reader::Json,
                    Some("obj") => Reader::Obj,
                    _ => continue,
                };
                // Files that are not text are already wrong, so they are not mutated.
                if let Ok(text) = fs::read_to_string(&path) {
                    seeds.push((reader, !folder.starts_with(&bad), text));
                }
            }
        }
        // The order of files in a folder is arbitrary, so the inputs are sorted.
        seeds.sort_by(|a, b| a.2.cmp(&b.2));
        let specs = seeds.iter().filter(|seed| (seed.0, seed.1) == (Reader::Toml, true));
        let specs = specs.map(|seed| seed.2.clone()).collect();
        seeds.extend(
            KEYS.iter()
                .flat_map(|key| NUMBERS.iter().map(move |n| (Reader::Set, true, format!("{key}={n}")))),
        );
        seeds.push((Reader::Cases, true, CASES.into()));
        let Loaded { problem, settings, identity, .. } = spec::from_str(SMALL, "small", Format::Toml, &[])?;
        let plan = plan(&problem, &settings, None, &mut Silent)?;
        let file = PlanFile::new(&problem, &settings, &plan).with_identity(&identity);
        for (reader, name) in [
            (Reader::PlanFile, "json"),
            (Reader::Attitudes, "aem"),
            (Reader::Attitudes, "xml"),
            (Reader::Attitudes, "csv"),
        ] {
            let format = formats::Format::named(name).or(formats::Format::of_ending(name)).ok_or(name)?;
            let mut bytes = Vec::new();
            format.write(&file, &problem, &identity, Tables::default(), &mut bytes)?;
            let text = String::from_utf8(bytes)?;
            if reader == Reader::PlanFile {
                // The spec in the plan file serves as a JSON spec.
                let document: serde_json::Value = serde_json::from_str(&text)?;
                seeds.push((Reader::Json, true, serde_json::to_string_pretty(&document["spec"])?));
            }
            seeds.push((reader, true, text));
        }
        let base = Base::from_reader(SMALL.as_bytes(), "small", Format::Toml, &[])?;
        Ok(Self { seeds, specs, base, folder: tempfile::tempdir()? })
    }

    /// Returns a mutated input of a reader.
    pub fn input(&self, reader: Reader, random: &mut Random) -> Vec<u8> {
        let of_reader = || self.seeds.iter().filter(|seed| seed.0 == reader);
        let all: Vec<&str> = of_reader().map(|seed| seed.2.as_str()).collect();
        let good: Vec<&str> = of_reader().filter(|seed| seed.1).map(|seed| seed.2.as_str()).collect();
        // In an input that is already wrong, a mutation may have no effect, so most inputs are
        // valid.
        let text = if random.below(4) == 0 { random.pick(&all) } else { random.pick(&good) };
        let donor = random.pick(&all);
        mutate(text, donor, random)
    }

    /// Reads the input with its reader.
    ///
    /// # Errors
    /// Returns an error if a refusal lacks its place, reason or remedy; the error states which. The
    /// caller catches panics.
    pub fn read(&self, reader: Reader, bytes: &[u8]) -> Result<Answer, String> {
        match reader {
            Reader::Toml => read_spec(bytes, Format::Toml, &[]),
            Reader::Json => read_spec(bytes, Format::Json, &[]),
            Reader::Set => {
                let typed = String::from_utf8_lossy(bytes);
                match Override::parse(&typed) {
                    Ok(set) => {
                        let spec = &self.specs[bytes.len() % self.specs.len()];
                        read_spec(spec.as_bytes(), Format::Toml, &[set])
                    }
                    Err(reason) => said(!reason.is_empty(), || "no reason".into()),
                }
            }
            Reader::PlanFile => self.read_plan(bytes),
            Reader::Obj => match read_obj(io::Cursor::new(bytes), 1.0) {
                Ok(_) => Ok(Answer::Read),
                Err(error) => said(error.line > 0, || error.to_string()),
            },
            Reader::Cases => {
                let path = self.folder.path().join("cases.csv");
                fs::write(&path, bytes).map_err(|error| error.to_string())?;
                match Batch::of_table(self.base.clone(), &path) {
                    Ok(_) => Ok(Answer::Read),
                    Err(BatchError::Spec(errors)) => refused(&errors),
                    Err(
                        BatchError::Argument { reason, remedy, .. } | BatchError::File { reason, remedy, .. },
                    ) => said(!reason.is_empty() && !remedy.is_empty(), || reason),
                    Err(other) => Err(other.to_string()),
                }
            }
            Reader::Attitudes => match read_attitudes(bytes, "x") {
                Ok(attitudes) => {
                    let all = attitudes.evenly();
                    let finite = all.iter().flatten().all(|number| number.is_finite());
                    if finite { Ok(Answer::Read) } else { Err("a quaternion that is not finite".into()) }
                }
                Err(errors) => refused(&errors),
            },
        }
    }

    /// Reads a plan file as `slew verify` and `--guess` read it, and lets the witnesses judge it.
    fn read_plan(&self, bytes: &[u8]) -> Result<Answer, String> {
        let _ = read_guess(bytes);
        let file = match PlanFile::read(bytes) {
            Ok(file) => file,
            Err(error) => return unusable(&error),
        };
        let Some(held) = &file.spec else { return unusable(&ExportError::NoSpec) };
        match held.read("x", &[]) {
            Ok(loaded) => match file.judge(
                &loaded.problem,
                &loaded.settings,
                &loaded.identity,
                &loaded.closed_loop,
                &|| false,
            ) {
                Ok(_) => Ok(Answer::Read),
                Err(error) => unusable(&error),
            },
            Err(errors) => refused(&errors),
        }
    }
}

/// The result of reading an input.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Answer {
    Read,
    Refused,
}

fn said(enough: bool, what: impl FnOnce() -> String) -> Result<Answer, String> {
    if enough { Ok(Answer::Refused) } else { Err(what()) }
}

fn unusable(error: &ExportError) -> Result<Answer, String> {
    said(!error.to_string().is_empty() && !error.remedy().is_empty(), || format!("{error:?}"))
}

/// Checks that every message has a place, a reason and a remedy, and contains no raw control
/// characters.
fn refused(errors: &Diagnostics) -> Result<Answer, String> {
    let placed =
        errors.0.iter().all(|finding| finding.line > 0 && finding.column > 0 && !finding.file.is_empty());
    let told = errors.0.iter().all(|finding| !finding.reason.is_empty() && !finding.remedy.is_empty());
    let text = errors.render(false);
    let clean = text.chars().all(|c| c == '\n' || !c.is_control());
    let reason = errors.0.iter().any(|finding| finding.severity == Severity::Error);
    said(placed && told && clean && reason, || format!("{text:?}"))
}

/// Reads the spec of a maneuver or a simulation. An accepted maneuver must be consistent. A
/// simulation must make a step or return a reason.
pub fn read_spec(bytes: &[u8], format: Format, set: &[Override]) -> Result<Answer, String> {
    // `from_bytes` handles input that is not text.
    let read = match std::str::from_utf8(bytes) {
        Ok(text) => spec::load_from_str(text, "x", Path::new("tests/bad_inputs/orbit"), format, set),
        Err(_) => spec::from_bytes(bytes, "x", format, set).map(|loaded| Spec::Maneuver(Box::new(loaded))),
    };
    let spec = match read {
        Ok(spec) => spec,
        Err(errors) => return refused(&errors),
    };
    if spec.warnings().iter().any(|finding| finding.severity != Severity::Warning) {
        return Err("an error among the warnings".into());
    }
    match spec {
        Spec::Maneuver(loaded) => {
            loaded.problem.check().map_err(|error| error.to_string())?;
            loaded.settings.check().map_err(|error| error.to_string())?;
        }
        Spec::Sequence(loaded) => {
            loaded.sequence.check().map_err(|error| error.to_string())?;
            loaded.settings.check().map_err(|error| error.to_string())?;
        }
        Spec::Simulation(loaded) => {
            let mut simulation = loaded.simulation;
            simulation.system.check(&simulation.start).map_err(|error| error.to_string())?;
            simulation.duration = simulation.step();
            simulation.steps = 1;
            drop(simulation.run(&mut |_: &SimulationRow| ControlFlow::Continue(())));
        }
    }
    Ok(Answer::Read)
}
