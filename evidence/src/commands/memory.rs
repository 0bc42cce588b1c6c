//! Compares the memory estimate of `slew check` with the memory that plans need.
//!
//! `cargo run --release -p evidence -- memory [STEPS…]`, 1,000 and 10,000 by default, on Linux. A
//! separate process makes each plan of the table and reports its peak memory. The estimate `likely`
//! is compared with a default plan. For SCP, the estimate `most` is compared with the convex
//! iteration until convergence on the requested grid, as `slew compare` runs it.
//!
//! The command ends with 1 if a plan needs more than the larger figure, or less than a third of the
//! smaller figure.

use evidence::process::peak_memory;
use evidence::words::{Misuse, Words};
use slewkit::maneuver::Method;
use slewkit::plan::{PeakMemory, Silent, plan};
use slewkit_files::spec::{Override, read};
use slewkit_report::studies::methods::compare;
use std::env;
use std::process::Command;

/// Maneuvers of `problems/`, with the overrides for each.
const CASES: [(&str, &[&str]); 14] = [
    ("xte_20s", &[]),
    ("moving_ends", &[]),
    ("dumbbell_transfer", &[]),
    ("body_thrusters", &[]),
    ("limited_box", &[]),
    ("limited_norm", &[]),
    ("limited_rate", &[]),
    ("limited_rate_axes", &[]),
    ("limited_torque_rate", &[]),
    ("keep_out_small", &[]),
    ("wheels_pyramid", &[]),
    ("body_thrusters", &["actuators.force_limit_n=1000", "actuators.torque_limit_n_m=1000"]),
    ("limited_rate", &["solver.method=scp"]),
    ("wheels_pyramid", &["solver.method=scp"]),
];

pub fn run(words: &mut Words) -> Result<(), Box<dyn std::error::Error>> {
    // This part runs in the separate process, which is started below.
    for road in ["plan", "compare"] {
        if words.next_is(road) {
            let (case, steps) = (words.required("number of a case")?, words.required("number of steps")?);
            words.end()?;
            if case >= CASES.len() {
                return Err(Misuse::new(format!("the cases are 0 to {}", CASES.len() - 1)).into());
            }
            return taken(road == "compare", case, steps);
        }
    }
    let grids: Vec<usize> = words.numbers("number of steps")?;
    let grids = if grids.is_empty() { vec![1_000, 10_000] } else { grids };
    println!("{:<48} {:>8} {:>9} {:>9} {:>9} {:>9}   MB", "", "steps", "likely", "taken", "most", "convex");
    let mut wrong = 0;
    for steps in grids {
        for (case, (name, set)) in CASES.iter().enumerate() {
            let (problem, settings) = maneuver(case, steps)?;
            let PeakMemory { likely, most } = PeakMemory::of(&problem, &settings);
            let peak = |road: &str| -> Result<f64, Box<dyn std::error::Error>> {
                let arguments = ["memory", road, &case.to_string(), &steps.to_string()];
                let output = Command::new(env::current_exe()?).args(arguments).output()?;
                Ok(String::from_utf8(output.stdout)?.trim().parse()?)
            };
            let planned = peak("plan")?;
            // On more than some thousand steps the comparison takes minutes.
            let scp = settings.method == Method::Scp;
            let convex = if scp && steps <= 2_000 { Some(peak("compare")?) } else { None };
            let shown = |bytes: f64| format!("{:.1}", bytes / 1e6);
            println!(
                "{:<48} {steps:>8} {:>9} {:>9} {:>9} {:>9}",
                format!("{name} {}", set.first().unwrap_or(&"")),
                shown(likely),
                shown(planned),
                shown(most),
                convex.map_or("-".into(), shown)
            );
            let taken = convex.map_or(planned, |convex| convex.max(planned));
            wrong += u32::from(taken > most || likely > 3.0 * planned);
        }
    }
    println!("{wrong} outside of the bounds");
    if wrong > 0 { Err("see above".into()) } else { Ok(()) }
}

fn maneuver(
    case: usize,
    steps: usize,
) -> Result<(slewkit::maneuver::Problem, slewkit::maneuver::Settings), Box<dyn std::error::Error>> {
    let (name, set) = CASES[case];
    let set: Result<Vec<_>, _> = set.iter().map(|text| Override::parse(text)).collect();
    let path = format!("{}/problems/{name}.toml", evidence::ROOT);
    let loaded = read(path.as_ref(), &set?)?;
    Ok((loaded.problem.with_steps(steps), loaded.settings))
}

/// Plans the case, or compares its methods, and prints the peak memory of this process \[bytes\].
fn taken(comparing: bool, case: usize, steps: usize) -> Result<(), Box<dyn std::error::Error>> {
    let (problem, settings) = maneuver(case, steps)?;
    if comparing {
        compare(&problem, &settings, &mut Silent)?;
    } else {
        plan(&problem, &settings, None, &mut Silent)?;
    }
    println!("{}", peak_memory("self").ok_or("no peak")?);
    Ok(())
}
