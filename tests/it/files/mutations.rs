//! No input makes the reader panic, hang, or fail without saying why.

use super::bad_inputs::files;
use super::{BASE, CONSTRAINED, ORBIT, SIMULATION, WHEELS};
use evidence::Random;
use evidence::hostile::{Answer, Corpus, READERS, Reader, mutate, read_spec};
use slewkit_files::spec::{self, Format};
use std::panic::{AssertUnwindSafe, catch_unwind};
use std::path::Path;

#[test]
fn twenty_thousand_mutations_are_read_or_refused() {
    const SEED: u64 = 20_261_121;
    let mut random = Random::new(SEED);
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
        let donor = good[random.below(good.len())].0;
        let bytes = mutate(text, donor, &mut random);
        let outcome = catch_unwind(|| read_spec(&bytes, format, &[]));
        let fine = matches!(outcome, Ok(Ok(_)));
        assert!(fine, "seed {SEED} round {round}: {outcome:?}\n{}", String::from_utf8_lossy(&bytes));
    }
}

#[test]
fn mutated_bad_inputs_are_refused_or_read() {
    let mut random = Random::new(11);
    for path in files() {
        let Ok(text) = std::fs::read_to_string(&path) else { continue };
        for _ in 0..20 {
            let bytes = mutate(&text, BASE, &mut random);
            let outcome = catch_unwind(|| read_spec(&bytes, Format::of(&path), &[]));
            let fine = matches!(outcome, Ok(Ok(_)));
            assert!(fine, "{}: {outcome:?}\n{}", path.display(), String::from_utf8_lossy(&bytes));
        }
    }
}

/// Specs in both notations, overrides, plan files before the witnesses, surfaces, tables of cases,
/// AEM and tables of attitudes: a few thousand here, any number by
/// `cargo run --release -p evidence -- hostile COUNT`.
#[test]
fn hostile_inputs_of_every_kind_are_read_or_refused() {
    let corpus = Corpus::new().unwrap();
    let mut random = Random::new(15);
    for reader in READERS {
        let (mut read, mut refused) = (0, 0);
        // Reading an override is a matter of microseconds.
        let rounds = if reader == Reader::Set { 5000 } else { 1000 };
        for round in 0..rounds {
            let bytes = corpus.input(reader, &mut random);
            let outcome = catch_unwind(AssertUnwindSafe(|| corpus.read(reader, &bytes)));
            match outcome {
                Ok(Ok(Answer::Read)) => read += 1,
                Ok(Ok(Answer::Refused)) => refused += 1,
                wrong => panic!("{reader:?}, round {round}: {wrong:?}\n{}", String::from_utf8_lossy(&bytes)),
            }
        }
        assert!(read > 10 && refused > 100, "{reader:?}: {read} read, {refused} refused: no attack");
    }
}
