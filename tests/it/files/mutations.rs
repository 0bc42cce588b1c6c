//! No input makes the reader panic, hang, or fail without saying why.

use super::bad_inputs::files;
use super::{BASE, CONSTRAINED, ORBIT, SIMULATION, WHEELS};
use slewkit::files::spec::{self, Format, Override, Severity, Spec};
use slewkit::propagate::simulate::SimulationRow;
use std::ops::ControlFlow;
use std::path::Path;

/// PCG32, so that the stream is the same everywhere.
struct Random(u64);

impl Random {
    fn next(&mut self) -> u32 {
        self.0 = self.0.wrapping_mul(6364136223846793005).wrapping_add(1442695040888963407);
        let word = (((self.0 >> 18) ^ self.0) >> 27) as u32;
        word.rotate_right((self.0 >> 59) as u32)
    }

    fn below(&mut self, limit: usize) -> usize {
        self.next() as usize % limit.max(1)
    }

    fn pick<'a>(&mut self, from: &[&'a str]) -> &'a str {
        from[self.below(from.len())]
    }
}

const NUMBERS: &[&str] = &[
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

fn mutate(text: &str, random: &mut Random) -> Vec<u8> {
    let mut bytes = text.as_bytes().to_vec();
    for _ in 0..=random.below(3) {
        let at = random.below(bytes.len());
        match random.below(7) {
            0 => bytes.truncate(at),
            1 if !bytes.is_empty() => bytes[at] = random.next() as u8,
            2 if !bytes.is_empty() => bytes[at] = b' ' + (random.next() % 95) as u8,
            3 => drop(bytes.splice(at..at, random.pick(WORDS).bytes())),
            4 => {
                // Another number in place of one.
                let digit = |byte: &u8| byte.is_ascii_digit();
                if let Some(start) = bytes.iter().skip(at).position(digit).map(|offset| at + offset) {
                    let length =
                        bytes[start..].iter().take_while(|byte| digit(byte) || **byte == b'.').count();
                    drop(bytes.splice(start..start + length, random.pick(NUMBERS).bytes()));
                }
            }
            5 => {
                // A line twice, or moved.
                let lines: Vec<Vec<u8>> = bytes.split(|byte| *byte == b'\n').map(<[u8]>::to_vec).collect();
                let mut lines = lines;
                let line = lines[random.below(lines.len())].clone();
                lines.insert(random.below(lines.len()), line);
                bytes = lines.join(&b'\n');
            }
            _ => {
                let end = (at + random.below(40)).min(bytes.len());
                bytes.drain(at..end);
            }
        }
    }
    bytes
}

fn read(bytes: &[u8], format: Format, set: &[Override]) {
    // What is no text at all is the matter of `from_bytes`.
    let read = match std::str::from_utf8(bytes) {
        Ok(text) => spec::load_from_str(text, "x", Path::new("tests/bad_inputs"), format, set),
        Err(_) => spec::from_bytes(bytes, "x", format, set).map(|loaded| Spec::Maneuver(Box::new(loaded))),
    };
    match read {
        Ok(spec) => {
            assert!(spec.warnings().iter().all(|finding| finding.severity == Severity::Warning));
            match spec {
                Spec::Maneuver(loaded) => {
                    loaded.problem.check().unwrap();
                    loaded.settings.check().unwrap();
                }
                Spec::Simulation(loaded) => {
                    let mut simulation = loaded.simulation;
                    simulation.system.check(&simulation.start).unwrap();
                    simulation.duration = simulation.step();
                    simulation.steps = 1;
                    // It steps, or says why not.
                    drop(simulation.run(&mut |_: &SimulationRow| ControlFlow::Continue(())));
                }
            }
        }
        Err(errors) => {
            assert!(errors.0.iter().any(|finding| finding.severity == Severity::Error), "no reason given");
            let text = errors.render(false);
            assert!(text.chars().all(|c| c == '\n' || !c.is_control()), "{text:?}");
            for finding in &errors.0 {
                assert!(!finding.reason.is_empty() && !finding.remedy.is_empty(), "{text}");
            }
        }
    }
}

#[test]
fn twenty_thousand_mutations_are_read_or_refused() {
    const SEED: u64 = 20_261_121;
    let mut random = Random(SEED);
    let orbit = ORBIT.to_string();
    let pendulum = format!(
        "{BASE}\n[environment]\nkind = \"uniform_gravity\"\nmass_kg = 1\ngravity_m_s2 = 9.81\n\
         direction = [0, 0, 1]\npivot_to_mass_center_m = [0, 0, 0.3]\n"
    );
    let moon = orbit.replace("body = \"points\"", "body = \"second_order\"");
    let moon: String =
        moon.lines().filter(|line| !line.starts_with("points")).map(|line| format!("{line}\n")).collect();
    let json = r#"{ "format": 1, "body": { "inertia_kg_m2": [[2, 0.1, 0], [0.1, 3, 0], [0, 0, 4]] },
        "start": { "attitude": { "axis": [0, 0, 1], "angle_deg": 0 } },
        "end": { "attitude": { "euler_zyx_deg": [80, -25, 40] } }, "maneuver": { "duration_s": 6e1 } }"#;
    let good = [
        (BASE, Format::Toml),
        (&orbit, Format::Toml),
        (&pendulum, Format::Toml),
        (&moon, Format::Toml),
        (json, Format::Json),
        (CONSTRAINED, Format::Toml),
        (WHEELS, Format::Toml),
        (SIMULATION, Format::Toml),
    ];
    for (text, format) in good {
        spec::load_from_str(text, "x", Path::new(""), format, &[])
            .unwrap_or_else(|errors| panic!("{errors}"));
    }
    for round in 0..20_000 {
        let (text, format) = good[round % good.len()];
        let bytes = mutate(text, &mut random);
        let shown = bytes.clone();
        let outcome = std::panic::catch_unwind(|| read(&bytes, format, &[]));
        assert!(outcome.is_ok(), "seed {SEED} round {round}:\n{}", String::from_utf8_lossy(&shown));
    }
}

#[test]
fn mutated_overrides_are_set_or_refused() {
    let mut random = Random(7);
    let keys = [
        "body.inertia_kg_m2",
        "end.attitude.euler_zyx_deg.1",
        "maneuver.steps",
        "maneuver.duration_s",
        "environment.points.0.mass_kg",
        "end.position_m.2",
        "start",
        "solver.tolerance",
        "expect.rivals",
        "constraint.0.direction_inertial.ra_deg",
        "constraint.1.boresight_body.1.0",
        "actuators.torque_limit_n_m",
        "a.b",
        "bodies.0.shape.kind",
        "bodies.1.shape.vertices_m.2.0",
        "bodies.1.shape.faces.0.1",
        "bodies.1.shape.obj",
        "simulation.integrator",
        "simulation.step_s",
        "gravity.gravitational_constant_m3_kg_s2",
    ];
    for round in 0..5_000 {
        let typed = format!("{}={}", random.pick(&keys), random.pick(NUMBERS));
        let typed = String::from_utf8_lossy(&mutate(&typed, &mut random)).into_owned();
        let Ok(set) = Override::parse(&typed) else { continue };
        let text = [BASE, ORBIT, CONSTRAINED, SIMULATION][round % 4];
        let outcome = std::panic::catch_unwind(|| read(text.as_bytes(), Format::Toml, &[set]));
        assert!(outcome.is_ok(), "round {round}: {typed:?}");
    }
}

#[test]
fn mutated_bad_inputs_are_refused_or_read() {
    let mut random = Random(11);
    for path in files() {
        let Ok(text) = std::fs::read_to_string(&path) else { continue };
        for _ in 0..20 {
            let bytes = mutate(&text, &mut random);
            let outcome = std::panic::catch_unwind(|| read(&bytes, Format::of(&path), &[]));
            assert!(outcome.is_ok(), "{}:\n{}", path.display(), String::from_utf8_lossy(&bytes));
        }
    }
}
