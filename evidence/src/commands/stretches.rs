//! Checks that fuel times duration does not increase with the duration of rest-to-rest maneuvers. A
//! plan that is slowed down by a factor s needs 1/s² of the torques and 1/s of the fuel, so the
//! minimum of this product cannot increase.
//!
//! `cargo run --release -p evidence -- stretches [COUNT [KIND]]`: COUNT (200 by default) random
//! minimum-fuel maneuvers of each kind, by the laws of `evidence::switching`: one-sided thrusters,
//! three torques, and three torques past cones. Each is planned in four durations, and each plan is
//! compared with the slowed-down plans of all shorter durations. Costs may differ by 0.2 % and by
//! the gap of the plan.
//!
//! The command ends with 1 if more than 0.5 % of the maneuvers of a kind break the law, or have no
//! plan in a duration although they have one in a shorter duration.

use evidence::switching::{Kind, cost_and_gap, maneuver};
use evidence::words::Words;
use slewkit::maneuver::{Settings, Target};
use slewkit::plan::{Silent, Status, plan};
use std::error::Error;

const KINDS: [(&str, Kind); 3] =
    [("thrusters", Kind::ThrusterFuel), ("torques", Kind::Fuel), ("cones", Kind::ConeFuel)];
/// The four durations, relative to the first one.
const STRETCHES: [f64; 4] = [1.0, 1.13, 1.6, 3.0];
/// The largest accepted excess of a plan over a slowed-down plan, relative to the cost.
const NEAR: f64 = 2e-3;

pub fn run(words: &mut Words) -> Result<(), Box<dyn Error>> {
    let count: u64 = words.number("number of maneuvers", 200)?;
    let asked = words.one_of("kind", &KINDS.map(|(name, _)| name))?;
    words.end()?;
    let settings = Settings { target: Target::Discrete, ..Settings::default() };
    let mut missed = false;
    for (name, kind) in KINDS.into_iter().filter(|(name, _)| asked.as_ref().is_none_or(|asked| asked == name))
    {
        let (mut cases, mut wrong, mut worst, mut unsolved) = (0, 0, 0.0_f64, 0);
        // Maneuvers with rates at an end do not scale with time, and are replaced by others.
        let rests = |index: &u64| {
            maneuver(kind, *index).is_some_and(|problem| {
                problem.start.angular_velocity.norm() + problem.end.angular_velocity.norm() == 0.0
            })
        };
        for index in (0..).filter(rests).take(count as usize) {
            let problem = maneuver(kind, index).ok_or("no maneuver")?;
            cases += 1;
            // The smallest product of fuel and duration so far.
            let (mut least, mut excess, mut lost) = (f64::INFINITY, 0.0_f64, false);
            let mut told = Vec::new();
            for stretch in STRETCHES {
                let duration = stretch * problem.seconds();
                let found = plan(&problem.clone().with_duration(duration), &settings, None, &mut Silent)?;
                if found.status != Status::Solved {
                    lost |= least.is_finite();
                    told.push(format!("{duration:.2} s {}", found.status.name()));
                    continue;
                }
                let (cost, gap) = cost_and_gap(&found);
                let product = cost * duration;
                let apart = product / least - 1.0;
                if apart > NEAR + gap {
                    excess = excess.max(apart);
                }
                least = least.min(product);
                told.push(format!("{duration:.2} s {product:.5}"));
            }
            worst = worst.max(excess);
            unsolved += usize::from(lost);
            if lost || excess > 0.0 {
                wrong += 1;
                println!("  {name} {index}: fuel times duration in {}", told.join(", "));
            }
        }
        println!(
            "{name:<10} {} of {cases} never rise with the duration, worst {:.2} %; {unsolved} \
            without a plan in more time",
            cases - wrong,
            100.0 * worst
        );
        missed |= wrong as f64 > 0.005 * cases as f64;
    }
    if missed { Err("see above".into()) } else { Ok(()) }
}
