//! Checks laws that relate the plans of two maneuvers (other units, other axes, backwards in time,
//! …) over thousands of random maneuvers.
//!
//! `cargo run --release -p evidence -- metamorphic [COUNT [FIRST [switching]]]`, 1,000 by default.
//! Every case draws a maneuver of one of 26 kinds (or of 8 minimum-time and minimum-fuel kinds),
//! and one of the laws of `evidence::metamorphic` that apply to it. Both the maneuver and the
//! maneuver that the law derives are planned. Their status must be equal, and their costs must
//! agree to 1e-9 or, for some laws, must not increase.
//!
//! The command ends with 1 if a law is broken.

use evidence::Random;
use evidence::metamorphic::{LAWS, Planned, complaint};
use evidence::words::Words;
use slewkit_files::spec::{Format, from_str};

pub fn run(words: &mut Words) -> Result<(), Box<dyn std::error::Error>> {
    let count: u64 = words.number("number of cases", 1_000)?;
    let first = words.number("number of the first case", 0)?;
    let drawn = match words.one_of("law", &["switching"])? {
        None => evidence::random_specs::random_spec,
        Some(_) => evidence::random_specs::random_switching_spec,
    };
    words.end()?;
    let mut kept = [[0; 2]; LAWS.len()];
    for index in first..first + count {
        let evidence::random_specs::RandomSpec { kind, text } = drawn(index);
        // A random draw may put an end into a cone, which the reader refuses.
        let Ok(loaded) = from_str(&text, "case", Format::Toml, &[]) else { continue };
        let Some(planned) = Planned::new(loaded.problem, loaded.settings) else { continue };
        let mut random = Random::new(index);
        // Laws that do not apply are skipped. The order is random, so that no law is preferred.
        let (start, stride) = (random.below(LAWS.len()), random.pick(&[1, 5, 7, 11]));
        for turn in 0..LAWS.len() {
            let law = (start + stride * turn) % LAWS.len();
            let Ok(wrong) = complaint(&LAWS[law], &planned, &mut random) else { continue };
            kept[law][usize::from(wrong.is_some())] += 1;
            if let Some(wrong) = wrong {
                println!("case {index}, {kind}, {}: {wrong}", LAWS[law].0);
            }
            break;
        }
    }
    for ((name, _), [kept, broken]) in LAWS.iter().zip(kept) {
        println!("{name:<32} kept {kept:>5}, broken {broken:>3}");
    }
    let broken: u64 = kept.iter().map(|[_, broken]| broken).sum();
    println!("{} pairs of plans, {broken} break a law", kept.iter().flatten().sum::<u64>());
    if broken > 0 { Err("see above".into()) } else { Ok(()) }
}
