//! Checks the order of convergence of neighbouring gains in a force field, by plans from displaced
//! starts.
//!
//! `cargo run --release -p evidence -- gains [COUNT]`: COUNT (200 by default) random pendulums with
//! rates at both ends, minimum effort in 3 to 6 s on 60 and on 120 steps. The gain of the first
//! step is compared with central differences of the mean torque over that step, between plans whose
//! starts differ by 1e-4 in all six directions. Errors are relative to the largest gain.
//!
//! The gains belong to the motion under held torques, so they differ from the gains of the discrete
//! plans by the discretisation error, of second order in the step. The law is that the difference
//! decreases by a factor of at least 2^1.7 from 60 to 120 steps, or is below 1e-5. The command ends
//! with 1 if fewer than 99.5 % of the cases satisfy it.

use evidence::words::Words;
use evidence::{Random, median};
use slewkit::feedback::Gains;
use slewkit::maneuver::{Path, Settings};
use slewkit::mechanics::UniformGravity;
use slewkit::plan::{Plan, Silent, Status, plan};
use slewkit::{Body, Problem, State, Vector3, lie};
use std::error::Error;

const BESIDE: f64 = 1e-4;
const ORDER: f64 = 1.7;
const EXACT: f64 = 1e-5;

fn maneuver(index: usize) -> Result<Problem, Box<dyn Error>> {
    let mut random = Random::of_case(33, index);
    let body = Body { inertia: random.inertia(4.0), mass: None };
    let mut state = || State::attitude(random.uniform_rotation(), random.within_cube(0.3));
    let (start, end) = (state(), state());
    let field = UniformGravity::new(1.0, random.within(0.1, 0.6), -Vector3::z(), random.within_cube(0.6))?;
    Ok(Problem::attitude(body, start, end, random.within(3.0, 6.0)).with_environment(field))
}

fn planned(problem: &Problem) -> Result<Option<Plan>, Box<dyn Error>> {
    let found = plan(problem, &Settings::discrete(), None, &mut Silent)?;
    Ok((found.status == Status::Solved).then_some(found))
}

/// Returns the mean torque over the first step.
fn first(found: &Plan) -> Vector3 {
    let torque = &found.solution.trajectory.torque;
    0.5 * (torque[0] + torque[1])
}

/// Returns the relative difference between the gain of the first step and the central differences;
/// `None` if a neighbouring plan is on another path.
fn apart(problem: &Problem) -> Result<Option<f64>, Box<dyn Error>> {
    let Some(found) = planned(problem)? else { return Ok(None) };
    let gains =
        Gains::neighbouring(problem, &found.solution.trajectory).map_err(|error| error.to_string())?;
    let (mut off, mut largest) = (0.0_f64, 0.0_f64);
    for column in 0..6 {
        let moved = |by: f64| -> Result<Option<Vector3>, Box<dyn Error>> {
            let mut start = problem.start;
            let axis = Vector3::ith(column % 3, by);
            if column < 3 {
                start.attitude = lie::project_to_rotation(&(start.attitude * lie::exp(&axis)));
            } else {
                start.angular_velocity += problem.body.inertia.j_inverse() * axis;
            }
            let beside = planned(&Problem { start, ..problem.clone() })?;
            Ok(beside
                .filter(|beside| (beside.solution.cost / found.solution.cost - 1.0).abs() < 0.05)
                .map(|beside| first(&beside)))
        };
        let (Some(ahead), Some(behind)) = (moved(BESIDE)?, moved(-BESIDE)?) else { return Ok(None) };
        let expected = (behind - ahead) / (2.0 * BESIDE);
        for input in 0..3 {
            off = off.max((gains.row(0)[6 * input + column] - expected[input]).abs());
            largest = largest.max(expected[input].abs());
        }
    }
    Ok(Some(off / largest))
}

pub fn run(words: &mut Words) -> Result<(), Box<dyn Error>> {
    let count = words.number("number of maneuvers", 200)?;
    words.end()?;
    let (mut cases, mut good, mut orders, mut fine_ones) = (0, 0, Vec::new(), Vec::new());
    let mut index = 0;
    while cases < count {
        let problem = maneuver(index)?.with_path(Path::Best);
        index += 1;
        let [coarse, fine] = [60, 120].map(|steps| apart(&problem.clone().with_steps(steps)));
        let (Some(coarse), Some(fine)) = (coarse?, fine?) else { continue };
        cases += 1;
        let order = (coarse / fine).log2();
        if order >= ORDER || fine < EXACT {
            good += 1;
        } else {
            println!("  case {}: {coarse:.1e} and {fine:.1e} of the largest gain", index - 1);
        }
        orders.push(order);
        fine_ones.push(fine);
    }
    println!(
        "{good} of {cases} of second order; median order {:.2}, {:.1e} of the largest gain on 120 \
        steps; {} others without a plan beside",
        median(&mut orders),
        median(&mut fine_ones),
        index - cases
    );
    if (good as f64) < 0.995 * cases as f64 { Err("see above".into()) } else { Ok(()) }
}
