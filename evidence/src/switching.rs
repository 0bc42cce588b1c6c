//! Random minimum-time and minimum-fuel maneuvers of twelve kinds.
//!
//! With probability ⅓ the body has random principal axes; otherwise its principal axes are the axes
//! of the torques. The rotation vector has a uniform direction and an angle up to π, and plans have
//! 200 steps. Unless stated otherwise, the moments have a ratio of up to 5, and 40 % of the
//! maneuvers have rates of up to 0.3 in the unit of time. The kinds are:
//!
//! - `time`: minimum time with three torques whose limits are 0.4 to 1.6;
//! - `unequal`: as `time`, from rest to rest, with moments in a ratio of 5 to 100;
//! - `fuel`: minimum fuel in 1.05 to 1000 times the duration of the turn about the axis,
//!   log-uniform;
//! - `price`: minimum fuel with a free duration; a second costs 2 to 200 % of the cost of all
//!   inputs at their limits;
//! - `thrusters`, `thruster-fuel`: minimum time and minimum fuel from rest to rest with 6 to 12
//!   one-sided thrusters about random axes that together act in every direction; fuel in 1.5 to 5
//!   times the duration of the turn about the axis;
//! - `long`: minimum time from rest to rest, the long way;
//! - `given`: minimum time from rest to rest, for prescribed rotations of 120 to 840°;
//! - `cones`, `cone-fuel`: minimum time and minimum fuel with one to three keep-out cones, on 60
//!   steps;
//! - `norm-fuel`: minimum fuel with one torque of any direction and limited norm, in 1.5 to 5 times
//!   the duration of the turn about the axis;
//! - `pulses`: minimum fuel with three torques that are off or at a limit, in such a duration, with
//!   a minimum pulse width of 1 to 10 % of it.

use crate::Random;
use slewkit::maneuver::{Constraint, Direction, Fuel, Objective, Path, Pointing, Problem, Rule, Side, State};
use slewkit::mechanics::{Actuation, ActuatorSet, AxisFrame, Body, Inertia, Limits};
use slewkit::plan::Plan;
use slewkit::{Matrix3, Vector3, lie};
use std::f64::consts::PI;

/// The kinds of maneuvers, as described above.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Kind {
    Time,
    Unequal,
    Fuel,
    Price,
    Thrusters,
    ThrusterFuel,
    Long,
    Given,
    Cones,
    ConeFuel,
    NormFuel,
    Pulses,
}

pub const KINDS: [(&str, Kind); 12] = [
    ("time", Kind::Time),
    ("unequal", Kind::Unequal),
    ("fuel", Kind::Fuel),
    ("price", Kind::Price),
    ("thrusters", Kind::Thrusters),
    ("thruster-fuel", Kind::ThrusterFuel),
    ("long", Kind::Long),
    ("given", Kind::Given),
    ("cones", Kind::Cones),
    ("cone-fuel", Kind::ConeFuel),
    ("norm-fuel", Kind::NormFuel),
    ("pulses", Kind::Pulses),
];

/// Returns the cost of a plan, and its gap relative to the cost. The cost is that of the continuous
/// extremal, because the arcs of symmetric maneuvers are placed on steps differently. If the plan
/// on the grid costs more by over a thousandth, which its steps do not explain, 0.999 of its cost
/// is returned instead.
pub fn cost_and_gap(plan: &Plan) -> (f64, f64) {
    let solution = &plan.solution;
    match &solution.switching {
        Some(switching) => {
            (switching.continuous_cost.max(0.999 * solution.cost), switching.gap / solution.cost)
        }
        None => (solution.cost, 0.0),
    }
}

/// Returns the maneuver of this index and kind; `None` if it cannot be built.
pub fn maneuver(kind: Kind, index: u64) -> Option<Problem> {
    let mut random = Random::of_case(0x1a6e_5000 + kind as u64, index as usize);
    let log_uniform = |random: &mut Random, low: f64, high: f64| low * (high / low).powf(random.unit());
    let ratio =
        if kind == Kind::Unequal { log_uniform(&mut random, 5.0, 100.0) } else { random.within(1.0, 5.0) };
    // The moments must belong to a body: the largest is at most the sum of the other two.
    let (small, large) = (1.0, ratio);
    let middle = random.within((large - small).max(small), large);
    let mut moments = [small, middle, large];
    moments.rotate_left(random.below(3));
    let axes = if random.below(3) == 0 { lie::exp(&vector(&mut random, PI)) } else { Matrix3::identity() };
    let j = axes * Matrix3::from_diagonal(&Vector3::from(moments)) * axes.transpose();
    let inertia = Inertia::new(0.5 * (j + j.transpose())).ok()?;
    let body = Body { inertia, mass: None };
    let given = kind == Kind::Given;
    let angle = if given { random.within(120.0, 840.0).to_radians() } else { random.within(0.05, PI) };
    let turn = angle * direction(&mut random);
    let torques = match kind {
        Kind::Thrusters | Kind::ThrusterFuel => thrusters(&mut random)?,
        Kind::NormFuel => {
            let limits = Limits { norm: Some(random.within(0.4, 1.6)), ..Limits::default() };
            ActuatorSet::three_axes(AxisFrame::Body).with_limits(limits).ok()?
        }
        _ => {
            let limits = (0..3).map(|_| random.within(0.4, 1.6)).collect();
            ActuatorSet::three_axes(AxisFrame::Body)
                .with_limits(Limits { size: Some(limits), ..Limits::default() })
                .ok()?
        }
    };
    let limits = torques.limits().clone();
    let sizes = limits.size.clone().or_else(|| limits.norm.map(|norm| vec![norm]))?;
    let mean = sizes.iter().sum::<f64>() / sizes.len() as f64;
    // The duration of the turn about its axis, from rest to rest.
    let alone = 2.0 * (j.trace() / 3.0 * angle / mean).sqrt();
    let mut start = State::at_rest(lie::exp(&vector(&mut random, PI)));
    let mut end = State::at_rest(lie::project_to_rotation(&(start.attitude * lie::exp(&turn))));
    let moves = matches!(kind, Kind::Time | Kind::Fuel | Kind::Price) && random.unit() < 0.4;
    if moves {
        start.angular_velocity = vector(&mut random, 0.3 / alone.max(1.0));
        end.angular_velocity = vector(&mut random, 0.3 / alone.max(1.0));
    }
    let price = log_uniform(&mut random, 0.02, 2.0) * sizes.iter().sum::<f64>();
    let stretch = match kind {
        Kind::Fuel => log_uniform(&mut random, 1.05, 1000.0),
        Kind::ConeFuel => random.within(2.0, 4.0),
        _ => random.within(1.5, 5.0),
    };
    let priced = Objective::Fuel(Fuel { time_price: Some(price), ..Fuel::default() });
    let torques = match kind {
        Kind::Pulses => {
            let shortest_pulse = Some(log_uniform(&mut random, 0.01, 0.1) * stretch * alone);
            torques.with_limits(Limits { shortest_pulse, ..limits }).ok()?
        }
        _ => torques,
    };
    let problem = match kind {
        Kind::Fuel | Kind::ThrusterFuel | Kind::ConeFuel | Kind::NormFuel | Kind::Pulses => {
            Problem::minimum_fuel(body, start, end, stretch * alone)
        }
        Kind::Price => Problem::minimum_time(body, start, end).with_objective(priced),
        _ => Problem::minimum_time(body, start, end),
    };
    let path = match kind {
        Kind::Long => Path::Long,
        Kind::Given => Path::AsGiven(turn),
        _ => Path::Best,
    };
    let coned = matches!(kind, Kind::Cones | Kind::ConeFuel);
    let steps = if coned { 60 } else { 200 };
    let problem = problem.with_actuation(Actuation::torques(torques)).with_path(path).with_steps(steps);
    if coned { with_cones(problem, &turn, &mut random) } else { Some(problem) }
}

/// Adds one to three keep-out cones near the direction of a boresight in the middle of the turn;
/// `None` if none fits.
fn with_cones(mut problem: Problem, turn: &Vector3, random: &mut Random) -> Option<Problem> {
    for index in 0..1 + random.below(3) {
        let boresight = direction(random);
        let at = |part: f64| problem.start.attitude * lie::exp(&(part * turn)) * boresight;
        let aside = lie::exp(&vector(random, 0.3)) * at(random.within(0.3, 0.7));
        let clear = [0.0, 1.0].map(|part| aside.dot(&at(part)).clamp(-1.0, 1.0).acos());
        let angle = random.within(0.1, 0.5).min(0.8 * clear[0].min(clear[1]));
        let rule = Rule::Pointing(Pointing::new(
            Side::KeepOut,
            vec![boresight],
            vec![Direction::Fixed(aside)],
            angle,
        ));
        problem = problem.with_constraint(Constraint { name: format!("cone {index}"), rule });
    }
    Some(problem)
}

/// Draws six to twelve one-sided thrusters that together produce torques in every direction; `None`
/// if they do not.
fn thrusters(random: &mut Random) -> Option<ActuatorSet> {
    let count = 6 + random.below(7);
    for _ in 0..1000 {
        let axes: Vec<Vector3> = (0..count).map(|_| direction(random)).collect();
        // Checks on many directions that each of them has a thruster axis nearby.
        let reached =
            (0..200).map(|_| direction(random)).all(|to| axes.iter().any(|axis| axis.dot(&to) > 0.2));
        if reached {
            let size = (0..count).map(|_| random.within(0.4, 1.0)).collect();
            let limits = Limits { size: Some(size), one_sided: true, ..Limits::default() };
            return ActuatorSet::new(axes, AxisFrame::Body).ok()?.with_limits(limits).ok();
        }
    }
    None
}

fn direction(random: &mut Random) -> Vector3 {
    loop {
        let at = Vector3::from_fn(|_, _| random.uniform());
        if (0.1..1.0).contains(&at.norm()) {
            return at.normalize();
        }
    }
}

fn vector(random: &mut Random, size: f64) -> Vector3 {
    random.unit() * size * direction(random)
}
