//! Every law on some maneuver of every kind; thousands by `cargo run --release --example metamorphic -- COUNT`.

use crate::common::Random;
use crate::common::metamorphic::{LAWS, Planned, complaint};
use crate::common::random_specs::random_spec;
use slewkit::files::spec::{Format, from_str};

#[test]
fn plans_keep_the_laws_between_maneuvers() {
    let mut kept = [0; LAWS.len()];
    for index in 0..26 {
        let spec = random_spec(index);
        let loaded = from_str(&spec.text, "case", Format::Toml, &[]).unwrap();
        let planned = Planned::new(loaded.problem, loaded.settings).unwrap();
        let mut random = Random::new(index);
        // Two laws for each kind, so that each has its turn.
        let first = index as usize;
        let turns = (0..LAWS.len()).map(|turn| (first + 5 * turn) % LAWS.len());
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
    assert!(kept.iter().all(|pairs| *pairs > 0), "{kept:?}");
}
