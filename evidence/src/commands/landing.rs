//! Counts how many plans of random maneuvers land, with the number of steps that the planner
//! chooses.
//!
//! `cargo run --release -p evidence -- landing [CASES [FIRST]]` plans CASES (1,000 by default) of
//! each of seven kinds. Each plan is propagated by independent equations of motion
//! (`evidence::held`), which share only the force field of the maneuver with planner and witnesses.
//! A plan lands if its true motion ends within 1e-6 rad of the target attitude, with a rate error
//! below 1e-6 rad per duration. It keeps its constraints if it exceeds none by more than 1e-6 rad,
//! or 1e-6 of the limit.
//!
//! The command ends with 1 if a plan that is reported as solved does not land, or exceeds a
//! constraint.

use evidence::held::{Flown, flown};
use evidence::random_specs::{RandomSpec, random_spec, random_switching_spec};
use evidence::words::Words;
use slewkit::plan::{Silent, Status, plan};
use slewkit_files::spec::{Format, from_str};
use std::time::Instant;

/// The largest terminal error of a plan that lands.
const MISSED: f64 = 1e-6;

/// A kind of maneuvers: its name, the function that draws specs, and the kinds of specs that belong
/// to it.
type Kind = (&'static str, fn(u64) -> RandomSpec, &'static [&'static str]);

const KINDS: [Kind; 7] = [
    (
        "effort",
        random_spec,
        &[
            "rest_to_rest",
            "moving_ends",
            "principal_axis",
            "winding",
            "two_torques",
            "redundant_axes",
            "reference_torques",
            "torque_limit",
            "torque_norm_limit",
            "torque_rate_limit",
        ],
    ),
    ("cones and rates", random_spec, &["rate_limit", "keep_out", "keep_in", "everything"]),
    ("wheels", random_spec, &["wheels"]),
    (
        "SE(3)",
        random_spec,
        &["free_flyer", "body_thrusters", "central_points", "central_second_order", "force_limits"],
    ),
    (
        "orbit and fields",
        random_spec,
        &["gravity_gradient", "cones_in_orbit", "pendulum", "pendulum_reference_torques", "limited_pendulum"],
    ),
    (
        "time",
        random_switching_spec,
        &["minimum_time", "minimum_time_redundant_axes", "minimum_time_norm", "minimum_time_thrusters"],
    ),
    (
        "fuel",
        random_switching_spec,
        &["minimum_fuel", "minimum_fuel_thrusters", "minimum_fuel_norm", "minimum_fuel_price_of_time"],
    ),
];

/// The keys that are removed from the specs, so that their defaults apply.
const LEFT_OUT: [&str; 5] =
    ["steps ", "step_s ", "tolerance ", "continuous_tolerance_deg ", "max_iterations "];

pub fn run(words: &mut Words) -> Result<(), Box<dyn std::error::Error>> {
    let count: usize = words.number("number of cases", 1_000)?;
    let first: u64 = words.number("number of the first case", 0)?;
    words.end()?;
    println!(
        "{:<17}{:>7}{:>8}{:>8}{:>8}{:>10}{:>10}{:>8}{:>8}{:>9}{:>9}",
        "kind", "plans", "solved", "land", "exceed", "missed", "exceeded", "steps", "most", "s", "most s"
    );
    let mut wrong = 0;
    for (name, draw, kinds) in KINDS {
        let (mut plans, mut solved, mut landed, mut exceeding) = (0, 0, 0, 0);
        let (mut worst, mut worst_exceeded) = (0.0_f64, f64::NEG_INFINITY);
        let (mut steps, mut seconds) = (Vec::new(), Vec::new());
        let mut told = Vec::new();
        let mut index = first;
        while plans < count && index < first + 100 * count as u64 {
            let RandomSpec { kind, text } = draw(index);
            index += 1;
            if !kinds.contains(&kind) {
                continue;
            }
            let given = |line: &&str| !LEFT_OUT.iter().any(|key| line.starts_with(key));
            let text = text.lines().filter(given).collect::<Vec<_>>().join("\n");
            // A random draw may put an end into a cone, which the reader refuses.
            let Ok(loaded) = from_str(&text, "case", Format::Toml, &[]) else { continue };
            let problem = loaded.problem;
            let began = Instant::now();
            let found = plan(&problem, &loaded.settings, None, &mut Silent)?;
            let took = began.elapsed().as_secs_f64();
            let has_plan = matches!(found.status, Status::Solved | Status::VerificationFailed);
            if !has_plan {
                // A maneuver without a plan cannot land. Other commands, such as `robustness`,
                // count these maneuvers.
                continue;
            }
            plans += 1;
            seconds.push(took);
            steps.push(found.solution.steps);
            let is_solved = found.status == Status::Solved;
            solved += usize::from(is_solved);
            let on_grid = found.solution.on_grid(&problem);
            let Some(Flown { attitude, rate, position, exceeded }) =
                flown(&on_grid, &found.solution.trajectory)
            else {
                told.push(format!("case {}, {kind}: its motion does not settle", index - 1));
                continue;
            };
            let missed = attitude.max(rate).max(position);
            let (lands, exceeds) = (missed <= MISSED, exceeded > MISSED);
            landed += usize::from(lands);
            exceeding += usize::from(exceeds && is_solved);
            worst = worst.max(if is_solved { missed } else { 0.0 });
            worst_exceeded = worst_exceeded.max(if is_solved { exceeded } else { f64::NEG_INFINITY });
            if !lands || exceeds {
                let verdict = if is_solved { "solved" } else { "not verified" };
                told.push(format!(
                    "case {}, {kind}, {verdict}: missed {missed:.1e}, exceeded {exceeded:.1e}, {} steps",
                    index - 1,
                    found.solution.steps
                ));
                wrong += usize::from(is_solved);
            }
        }
        steps.sort_unstable();
        seconds.sort_by(f64::total_cmp);
        let middle = steps.len() / 2;
        println!(
            "{name:<17}{plans:>7}{solved:>8}{landed:>8}{exceeding:>8}{worst:>10.1e}{worst_exceeded:>10.1e}{:>\
                8}{:>8}{:>9.3}{:>9.2}",
            steps.get(middle).unwrap_or(&0),
            steps.last().unwrap_or(&0),
            seconds.get(middle).unwrap_or(&0.0),
            seconds.last().unwrap_or(&0.0)
        );
        for line in told {
            println!("    {line}");
        }
    }
    if wrong > 0 {
        Err(format!("{wrong} plans that are called solved do not land, or exceed a constraint").into())
    } else {
        Ok(())
    }
}
