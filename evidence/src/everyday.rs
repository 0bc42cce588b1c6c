//! Everyday maneuvers: random rest-to-rest slews of a spacecraft with four reaction wheels, within
//! limits.
//!
//! The law. Each maneuver has one of three buses with equal probability, given by the mean moment
//! J, and the torque τ and momentum h of a wheel: (0.12 kg·m², 4 mN·m, 20 mN·m·s), (40, 0.1, 2) or
//! (900, 0.6, 25). The principal moments along the body axes are J·(a, b, c), with a and b uniform
//! in 0.6 … 1.4, and c between max(1.1 |a − b|, 0.5) and min(0.9 (a + b), 1.5). The wheels have the
//! axes (±0.8, 0, 0.6) and (0, ±0.8, 0.6), and no momentum at the start. The body turns from rest
//! to rest by an angle θ uniform in 25 … 170° about a uniform axis, on 100 steps.
//!
//! - `time`: minimum time.
//! - `rate`: minimum time with a limit on each rate of √(1.6 θτ/J) times a number uniform in 0.45 …
//!   0.8.
//! - `cone`: as `rate`, with up to three keep-out cones.
//! - `effort`: minimum effort with up to three keep-out cones, in a duration of 2.2 √(θJ/1.6τ)
//!   times a number uniform in 1.2 … 2.
//!
//! One, two or three cones are drawn for one uniform boresight, with half angles α uniform in 8 …
//! 25°. Each cone is placed near the direction of the boresight at a fraction, uniform in 25 … 75
//! %, of the turn about its axis; the axis of the cone is displaced from this direction by
//! tan(α·u), with u uniform in 0.2 … 1.1. A cone that contains an end of the turn, or is within 2°
//! of it, is left out.

use crate::Random;
use slewkit::maneuver::{Constraint, Direction, Duration, Objective, Pointing, Problem, Rule, Side, State};
use slewkit::mechanics::{Actuation, Body, Inertia, Wheels};
use slewkit::{Matrix3, Vector3, lie};

/// The objective and the limits of a maneuver.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Kind {
    /// Minimum time.
    Time,
    /// Minimum time with limited rates.
    Rate,
    /// Minimum time with limited rates and keep-out cones.
    Cone,
    /// Minimum effort with keep-out cones.
    Effort,
}

/// The names of the kinds.
pub const KINDS: [(&str, Kind); 4] =
    [("time", Kind::Time), ("rate", Kind::Rate), ("cone", Kind::Cone), ("effort", Kind::Effort)];

/// For each bus, the mean moment of inertia \[kg·m²\], and the torque \[N·m\] and momentum [N·m·s]
/// of a wheel.
const BUSES: [[f64; 3]; 3] = [[0.12, 4e-3, 0.02], [40.0, 0.1, 2.0], [900.0, 0.6, 25.0]];

/// The torque of all four wheels about one axis, relative to the torque of one wheel.
const TOGETHER: f64 = 1.6;

/// The smallest allowed angle between an end of the turn and the edge of a cone \[deg\].
const OUTSIDE_DEG: f64 = 2.0;

/// The number of steps of a maneuver.
pub const STEPS: usize = 100;

/// Returns the maneuver with this number, kind and seed.
pub fn maneuver(kind: Kind, seed: u64, number: usize) -> Problem {
    let mut random = Random::of_case((seed << 2) | kind as u64, number);
    let [mean, torque, momentum] = random.pick(&BUSES);
    let (a, b) = (random.within(0.6, 1.4), random.within(0.6, 1.4));
    let c = random.within((1.1 * (a - b).abs()).max(0.5), (0.9 * (a + b)).min(1.5));
    let inertia = Inertia::diagonal(Vector3::new(a, b, c) * mean).expect("the moments of a body");
    let (axis, angle) = (random.normal_direction(), random.within(25.0, 170.0).to_radians());
    let end = lie::exp(&(axis * angle));
    let axes = [(0.8, 0.0), (-0.8, 0.0), (0.0, 0.8), (0.0, -0.8)].map(|(x, y)| Vector3::new(x, y, 0.6));
    let wheels = Wheels { momentum: vec![0.0; 4], momentum_limit: vec![momentum; 4] };
    let actuation =
        Actuation::of_wheels(axes.to_vec(), vec![torque; 4], wheels).expect("four wheels about unit vectors");
    let (start, end_state) = (State::at_rest(Matrix3::identity()), State::at_rest(end));
    let mut problem = Problem::attitude(Body { inertia, mass: None }, start, end_state, 1.0)
        .with_actuation(actuation)
        .with_steps(STEPS);
    let (name, _) = KINDS[kind as usize];
    problem.name = format!("{name} {number}, seed {seed}");
    let unit = (angle * mean / (TOGETHER * torque)).sqrt();
    if kind == Kind::Effort {
        problem = problem.with_duration(2.2 * unit * random.within(1.2, 2.0));
    } else {
        problem = problem.with_objective(Objective::Time).with_duration(Duration::SOUGHT);
    }
    if matches!(kind, Kind::Rate | Kind::Cone) {
        let rate = angle / unit * random.within(0.45, 0.8);
        let rule = Rule::RateAxes(Vector3::repeat(rate));
        problem = problem.with_constraint(Constraint { name: "rates".into(), rule });
    }
    if matches!(kind, Kind::Cone | Kind::Effort) {
        problem = past_cones(problem, &(axis * angle), &mut random);
    }
    problem
}

/// Adds one to three keep-out cones to the maneuver, except cones that contain an end of the turn.
fn past_cones(mut problem: Problem, turn: &Vector3, random: &mut Random) -> Problem {
    let boresight = random.normal_direction();
    for number in 1..=1 + random.below(3) {
        let half_angle = random.within(8.0, 25.0).to_radians();
        let passed = lie::exp(&(turn * random.within(0.25, 0.75))) * boresight;
        let aside = passed.cross(&random.normal_direction()).normalize();
        let beside = (half_angle * random.within(0.2, 1.1)).tan();
        let direction = (passed + aside * beside).normalize();
        let least = half_angle + OUTSIDE_DEG.to_radians();
        let ends = [problem.start.attitude, problem.end.attitude];
        if ends.iter().all(|end| (end * boresight).angle(&direction) >= least) {
            let directions = vec![Direction::Fixed(direction)];
            let pointing = Pointing::new(Side::KeepOut, vec![boresight], directions, half_angle);
            let rule = Rule::Pointing(pointing);
            problem = problem.with_constraint(Constraint { name: format!("cone {number}"), rule });
        }
    }
    problem
}
