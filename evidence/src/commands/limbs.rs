//! Plans slews past the limb of the Earth on eccentric orbits, on which the disc of the Earth grows
//! or shrinks during every step.
//!
//! `cargo run --release -p evidence -- limbs [COUNT]`: COUNT (200 by default) random orbits of
//! eccentricity 0.02 to 0.2, whose perigee is 400 to 1,200 km high, at any anomaly. The slew is the
//! maneuver of `problems/earth_limb_tracker.toml` without its Sun. The cone about the limb is
//! active at some heights. It is planned on 100 and on 200 steps. Orbits on which an end of the
//! slew lies in the cone are replaced by others.
//!
//! The law is that both plans are verified and their costs agree within 0.4 %. The command ends
//! with 1 if fewer than 99.5 % of the cases satisfy it.

use evidence::Random;
use evidence::words::Words;
use slewkit::maneuver::{Settings, Target};
use slewkit::plan::{Silent, Status, plan};
use slewkit_files::spec::{Format, from_str};
use std::error::Error;

/// The largest relative difference between the costs on both grids.
const NEAR: f64 = 4e-3;
/// The relative increase of the cost above which the cone counts as active.
const ACTS: f64 = 1e-6;

fn spec(random: &mut Random) -> String {
    let eccentricity = random.within(0.02, 0.2);
    let perigee = 6_378e3 + random.within(4e5, 1.2e6);
    let axis = perigee / (1.0 - eccentricity);
    let [node, argument, anomaly] = [(); 3].map(|()| random.within(0.0, 360.0));
    let beyond = random.within(5.0, 12.0);
    format!(
        "format = 1\nepoch = \"2026-11-21T07:25:00 UTC\"\n[orbit]\nsemi_major_axis_m = {axis}\n\
        eccentricity = {eccentricity}\ninclination_deg = 98.43\nraan_deg = {node}\n\
        argument_of_perigee_deg = {argument}\ntrue_anomaly_deg = {anomaly}\n\
        [body]\ninertia_kg_m2 = [[120, 4, -3], [4, 100, 2], [-3, 2, 80]]\n\
        [start]\npoint = {{ boresight_body = [0, 0, 1], at = \"nadir\" }}\n\
        second = {{ axis_body = [1, 0, 0], at = \"along_track\" }}\n\
        [end]\npoint = {{ boresight_body = [0, 0, 1], at = \"orbit_vector\", orbit_vector = [0.03, -0.47, -0.88] }}\n\
        second = {{ axis_body = [1, 0, 0], at = \"orbit_vector\", orbit_vector = [0.13, -0.87, 0.47] }}\n\
        [maneuver]\nduration_s = 90\nsteps = 100\n[[constraint]]\nname = \"Earth\"\nkind = \"keep_out\"\n\
        boresight_body = [0, -0.966, 0.259]\nlimb_of = \"earth\"\nbeyond_limb_deg = {beyond}\n"
    )
}

pub fn run(words: &mut Words) -> Result<(), Box<dyn Error>> {
    let count = words.number("number of orbits", 200)?;
    words.end()?;
    let settings = Settings { target: Target::Motion, ..Settings::default() };
    let (mut cases, mut good, mut act, mut worst) = (0, 0, 0, 0.0_f64);
    let mut index = 0;
    while cases < count {
        let text = spec(&mut Random::of_case(69, index));
        index += 1;
        // The reader refuses a spec with an end in the cone.
        let Ok(loaded) = from_str(&text, "limb", Format::Toml, &[]) else { continue };
        let costs = [100, 200].map(|steps| {
            let problem = loaded.problem.clone().with_steps(steps);
            plan(&problem, &settings, None, &mut Silent).map(|found| (found.status, found.solution.cost))
        });
        let [(coarse, one), (fine, other)] = match costs {
            [Ok(coarse), Ok(fine)] => [coarse, fine],
            [Err(error), _] | [_, Err(error)] => {
                println!("  orbit {}: {error}", index - 1);
                continue;
            }
        };
        cases += 1;
        let mut free = loaded.problem.clone();
        free.constraints.clear();
        let free = plan(&free, &settings, None, &mut Silent)?;
        act += usize::from(one > free.solution.cost * (1.0 + ACTS));
        let apart = (one / other - 1.0).abs();
        let solved = coarse == Status::Solved && fine == Status::Solved;
        if solved && apart <= NEAR {
            good += 1;
        } else {
            println!("  orbit {}: {one:.6} {}, {other:.6} {}", index - 1, coarse.name(), fine.name());
        }
        if solved {
            worst = worst.max(apart);
        }
    }
    println!(
        "{good} of {cases} verified at one cost on both grids; the cone acts in {act}; apart by at most {:.3} %",
        100.0 * worst
    );
    if (good as f64) < 0.995 * cases as f64 { Err("see above".into()) } else { Ok(()) }
}
