//! Laws that hold between plans, over thousands of random maneuvers: other units, other axes,
//! backwards in time, …
//!
//! `cargo run --release -p evidence -- metamorphic [COUNT [FIRST [switching]]]`, 1,000 by
//! default. Every case takes one of 26 kinds of random maneuvers, or of 8 of minimum time and
//! fuel, and draws one of the laws of `evidence::metamorphic` that apply. It plans the maneuver
//! and the one that the law makes of it, and compares: equal status, and costs equal to 1e-9, or
//! not above.
//!
//! Ends with 1 where a law is broken.

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
        // Now and then a draw puts an end into a cone.
        let Ok(loaded) = from_str(&text, "case", Format::Toml, &[]) else { continue };
        let Some(planned) = Planned::new(loaded.problem, loaded.settings) else { continue };
        let mut random = Random::new(index);
        // Laws that do not apply are skipped, in an order without preference.
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
