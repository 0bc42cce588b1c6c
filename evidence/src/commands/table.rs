//! Compares slew-time tables with new plans of random turns: interpolation errors, lower bounds,
//! computing time, file size, look-up time.
//!
//! `cargo run --release -p evidence -- table [CRAFT [TURNS [DIVISIONS [STEPS]]]]` makes the table
//! of a craft, with DIVISIONS (0: the divisions that suit the symmetry) and STEPS (100). The craft
//! are `wheels` (the default: asymmetric, four wheels, 4°/s), `slow` (`wheels` within 1°/s),
//! `cube`, `xte` (a limit on each torque), `thrusters` (eight one-sided ones) and `effort` (no
//! limits, 60 s). It plans TURNS (1000) uniformly random turns, the short and the long way, and
//! compares the shorter plans with the table, and with turns about the fixed axis. It ends with 1 if
//! a lower bound is above a plan, or if a turn about the fixed axis is faster than the plan.

use evidence::words::Words;
use slewkit::maneuver::{Rule, fixed_axis_duration};
use slewkit::mechanics::Limits;
use slewkit::numerics::random::Stream;
use slewkit::sequence::{SlewTable, TableOptions};
use slewkit::{
    Actuation, ActuatorSet, AxisFrame, Body, Constraint, Inertia, Matrix3, Problem, Settings, State, Vector3,
    Wheels, lie,
};
use std::error::Error;
use std::hint::black_box;
use std::time::Instant;

/// The names of the spacecraft.
const CRAFT: [&str; 6] = ["wheels", "slow", "cube", "xte", "thrusters", "effort"];

pub fn run(words: &mut Words) -> Result<(), Box<dyn Error>> {
    let name = words.take().unwrap_or_else(|| "wheels".into());
    let count: usize = words.number("number of turns", 1000)?;
    let divisions: usize = words.number("number of divisions", 0)?;
    let steps: usize = words.number("number of steps", 100)?;
    words.end()?;
    let problem = craft(&name)?.with_steps(steps);
    let settings = Settings::default();
    let options = TableOptions {
        divisions: Some(divisions).filter(|divisions| *divisions > 0),
        checks: 0,
        ..TableOptions::default()
    };
    let began = Instant::now();
    let table = SlewTable::make(&problem, &settings, &options, &mut |_| true)?;
    let nodes = table.nodes();
    let mut file = Vec::new();
    slewkit_files::table::write_npz(&table, 0, &mut file)?;
    println!(
        "{name}: {} plans, symmetry {}, {:.0} s, {} bytes",
        nodes.planned,
        nodes.maps.len(),
        began.elapsed().as_secs_f64(),
        file.len()
    );

    let turns: Vec<Vector3> = (0..count).map(random_turn).collect();
    let back: Vec<Vector3> = turns.iter().map(|turn| -turn).collect();
    let planned = |turns: &[Vector3]| SlewTable::plan_legs(&problem, &settings, turns, None, &mut |_| true);
    let (there, back) = (planned(&turns)?, planned(&back)?);
    let mut errors = Vec::new();
    let (mut ratios, mut above) = (Vec::new(), 0);
    let (mut fixed, mut faster) = (Vec::new(), 0);
    let mut leg = problem.clone();
    for (turn, (there, back)) in turns.iter().zip(there.iter().zip(&back)) {
        let best = there.min(*back);
        let turn = lie::exp(turn);
        errors.push(table.value(&turn) / best - 1.0);
        let ratio = table.bound(&turn) / best;
        above += usize::from(ratio > 1.0);
        ratios.push(ratio);
        leg.end = State::at_rest(turn);
        if let Some(duration) = fixed_axis_duration(&leg).filter(|_| name != "effort") {
            faster += usize::from(duration < best * (1.0 - 1e-6));
            fixed.push(duration / best);
        }
    }
    fixed.sort_by(f64::total_cmp);
    errors.sort_by(f64::total_cmp);
    ratios.sort_by(f64::total_cmp);
    let mut sizes: Vec<f64> = errors.iter().map(|error| error.abs()).collect();
    sizes.sort_by(f64::total_cmp);
    let part = |limit: f64| 100.0 * sizes.iter().filter(|size| **size <= limit).count() as f64 / count as f64;
    let at = |values: &[f64], part: f64| values[(part * (values.len() - 1) as f64).round() as usize];
    println!(
        "  {count} random turns: median {:.1e}, 99 % {:.1e}, 99.9 % {:.1e}, worst {:+.1e} {:+.1e}",
        at(&sizes, 0.5),
        at(&sizes, 0.99),
        at(&sizes, 0.999),
        errors[0],
        errors[count - 1]
    );
    println!("  within 0.5 %: {:.2} %, within 1 %: {:.2} %", part(0.005), part(0.01));
    println!(
        "  lower bound over plan: {:.3} to {:.3}, median {:.3}; above the plan: {above}",
        ratios[0],
        ratios[count - 1],
        at(&ratios, 0.5)
    );
    if !fixed.is_empty() {
        let last = fixed.len() - 1;
        println!(
            "  turn about the fixed axis over plan: {:.3} to {:.3}, median {:.3}; below the plan: {faster}",
            fixed[0],
            fixed[last],
            at(&fixed, 0.5)
        );
    }
    let attitudes: Vec<[f64; 4]> =
        (0..1000).map(|turn| lie::quaternion_from_rotation(&lie::exp(&random_turn(turn)))).collect();
    let began = Instant::now();
    black_box(table.matrix(black_box(&attitudes)));
    println!("  look-up: {:.0} ns", began.elapsed().as_secs_f64() / 1e6 * 1e9);
    if above > 0 {
        return Err("a lower bound is above a plan".into());
    }
    if faster > 0 {
        return Err("a turn about a fixed axis is faster than a plan".into());
    }
    Ok(())
}

/// Draws the rotation vector of a turn that is uniform on SO(3). It differs from the turns with
/// which the errors in a table file were measured.
fn random_turn(number: usize) -> Vector3 {
    let mut stream = Stream::new(72, number as u64, 0);
    lie::log(&lie::rotation_from_quaternion(&[(); 4].map(|()| stream.normal())))
}

fn craft(name: &str) -> Result<Problem, Box<dyn Error>> {
    let still = State::at_rest(Matrix3::identity());
    let body = |inertia: Matrix3| -> Result<Body, Box<dyn Error>> {
        Ok(Body { inertia: Inertia::new(inertia)?, mass: None })
    };
    let asymmetric = Matrix3::new(120.0, 4.0, -3.0, 4.0, 100.0, 2.0, -3.0, 2.0, 80.0);
    let boxed = |inertia: Matrix3, limit: f64| -> Result<Problem, Box<dyn Error>> {
        let limits = Limits { size: Some(vec![limit; 3]), ..Limits::default() };
        let torques = ActuatorSet::three_axes(AxisFrame::Body).with_limits(limits)?;
        Ok(Problem::minimum_time(body(inertia)?, still, still).with_actuation(Actuation::torques(torques)))
    };
    match name {
        "cube" => boxed(Matrix3::identity(), 1.0),
        "xte" => boxed(Matrix3::from_diagonal(&Vector3::new(5621.0, 4547.0, 2364.0)), 50.0),
        "wheels" | "slow" => {
            let axes =
                [(0.8, 0.0), (0.0, 0.8), (-0.8, 0.0), (0.0, -0.8)].map(|(x, y)| Vector3::new(x, y, 0.6));
            let wheels = Wheels { momentum: vec![0.0; 4], momentum_limit: vec![30.0; 4] };
            let rate = if name == "slow" { 1.0_f64 } else { 4.0 };
            let rule = Rule::RateNorm(rate.to_radians());
            Ok(Problem::minimum_time(body(asymmetric)?, still, still)
                .with_actuation(Actuation::of_wheels(axes.to_vec(), vec![0.5; 4], wheels)?)
                .with_constraint(Constraint { name: "rate".into(), rule }))
        }
        "thrusters" => {
            let corners = [(1.0, 1.0), (1.0, -1.0), (-1.0, 1.0), (-1.0, -1.0)];
            let torques = corners
                .into_iter()
                .flat_map(|(x, y)| [Vector3::new(x, y, 0.7 * x * y), Vector3::new(-x, -y, 0.7 * x * y)]);
            let limits = Limits { size: Some(vec![20.0; 8]), one_sided: true, ..Limits::default() };
            let set = ActuatorSet::new(torques.collect(), AxisFrame::Body)?.with_limits(limits)?;
            Ok(Problem::minimum_time(body(asymmetric)?, still, still).with_actuation(Actuation::torques(set)))
        }
        "effort" => Ok(Problem::attitude(body(asymmetric)?, still, still, 60.0)),
        _ => Err(evidence::words::Misuse::of("craft", name, &CRAFT).into()),
    }
}
