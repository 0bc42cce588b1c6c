//! Every law on some maneuver of every kind; thousands by
//! `cargo run --release -p evidence -- metamorphic COUNT`.

use evidence::Random;
use evidence::metamorphic::{LAWS, Planned, complaint};
use evidence::random_specs::{RandomSpec, random_spec, random_switching_spec};
use slewkit_files::spec::{Format, from_str};

#[test]
fn plans_keep_the_laws_between_maneuvers() {
    let kept = kept((0..26).map(random_spec));
    assert!(kept.iter().all(|pairs| *pairs > 0), "{kept:?}");
}

#[test]
fn plans_of_minimum_time_and_fuel_keep_them_too() {
    let kept = kept((0..40).map(random_switching_spec));
    for ((name, _), pairs) in LAWS.iter().zip(kept) {
        // They need limits.
        assert!(pairs > 0 || *name == "limits that do not act", "{name}");
    }
}

/// Holds two laws against each maneuver, so that each has its turn; how often.
fn kept(specs: impl Iterator<Item = RandomSpec>) -> [usize; LAWS.len()] {
    let mut kept = [0; LAWS.len()];
    for (index, spec) in specs.enumerate() {
        let loaded = from_str(&spec.text, "case", Format::Toml, &[]).unwrap();
        let planned = Planned::new(loaded.problem, loaded.settings).unwrap();
        let mut random = Random::new(index as u64);
        let turns = (0..LAWS.len()).map(|turn| (index + 5 * turn) % LAWS.len());
        let mut left = 2;
        for law in turns {
            if left == 0 {
                break;
            }
            let Ok(wrong) = complaint(&LAWS[law], &planned, &mut random) else { continue };
            assert_eq!(wrong, None, "{} № {index}, {}", spec.kind, LAWS[law].0);
            (left, kept[law]) = (left - 1, kept[law] + 1);
        }
    }
    kept
}
