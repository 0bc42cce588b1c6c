//! Random maneuvers within limits, with a free roll or a free attitude at the end, or between given
//! states of motion.
//!
//! The law. A bus of mean moment 40 kg·m² has principal moments as in [`crate::everyday`], and four
//! wheels of 0.1 N·m and 2 N·m·s about (±0.8, 0, 0.6) and (0, ±0.8, 0.6). It turns from rest by an
//! angle θ that is uniform in 25 … 150°, on 100 steps. The unit of time is t = √(θ 40 kg·m²/0.16
//! N·m). Minimum-effort and minimum-fuel plans have the duration 2.2 t, times a number that is
//! uniform in 1.3 … 2.
//!
//! Ends: a boresight rests at a fixed direction, with a free roll or a roll within 40° of a second
//! direction. Or the boresight points at a direction that moves at up to 0.1 θ/t, at rest or at the
//! rate of the direction. Or the body comes to rest at a free attitude, from rates of up to 0.02
//! rad/s about each axis.
//!
//! Inputs: the wheels alone; four pairs of one-sided thrusters of 0.1 N at 1 m; the wheels with a
//! limit on each rate of θ/t times a number uniform in 0.5 … 0.8; the wheels with a cone near the
//! path, of 8 … 20° and at most 0.3 θ; the wheels with three star trackers, two of which must stay
//! outside of a cone of 25° about the Sun.
//!
//! Motions: from rest to rest with a torque of 0.16 N·m about each axis that needs 0.1 … 0.4 t to
//! change from zero to its limit; between spins about random axes, with this torque but no limit on
//! its rate, on as many steps as a landed plan needs, where the body makes up to five turns while a
//! spin is stopped; with wheels that store up to half of their largest momentum at the start.

use crate::Random;
use slewkit::maneuver::{
    Aim, Alternatives, Constraint, Direction, Duration, Objective, Pointing, Problem, Rule, Side, State,
};
use slewkit::mechanics::{Actuation, ActuatorSet, AxisFrame, Body, Inertia, Limits, Wheels};
use slewkit::{Matrix3, Vector3, lie};
use std::f64::consts::TAU;

/// The terminal conditions with a free roll or attitude.
pub const ENDS: [&str; 5] = ["free roll", "roll in a band", "moving target", "matched rates", "any attitude"];
/// The inputs and limits that are combined with these terminal conditions.
pub const INPUTS: [&str; 5] = ["wheels", "thrusters", "rate limit", "cone", "two of three trackers"];
/// The kinds of motion between given states.
pub const MOTIONS: [&str; 3] = ["torque rates", "spins", "stored momentum"];
/// The objectives.
pub const OBJECTIVES: [&str; 3] = ["effort", "time", "fuel"];

/// The mean moment of inertia \[kg·m²\], the torque \[N·m\] and momentum [N·m·s] of a wheel, and
/// the torque of all wheels about one axis \[N·m\].
const MOMENT: f64 = 40.0;
const TORQUE: f64 = 0.1;
const MOMENTUM: f64 = 2.0;
const TOGETHER: f64 = 1.6 * TORQUE;

/// The randomly drawn properties of a case.
struct Drawn {
    random: Random,
    inertia: Inertia,
    angle: f64,
    unit: f64,
    duration: f64,
}

impl Drawn {
    fn of(seed: u64, number: usize) -> Self {
        let mut random = Random::of_case(seed, number);
        let (a, b) = (random.within(0.6, 1.4), random.within(0.6, 1.4));
        let c = random.within((1.1 * (a - b).abs()).max(0.5), (0.9 * (a + b)).min(1.5));
        let inertia = Inertia::diagonal(Vector3::new(a, b, c) * MOMENT).expect("the moments of a body");
        let angle = random.within(25.0, 150.0).to_radians();
        let unit = (angle * MOMENT / TOGETHER).sqrt();
        let duration = 2.2 * unit * random.within(1.3, 2.0);
        Self { random, inertia, angle, unit, duration }
    }

    /// Returns the maneuver between two states for an objective.
    fn problem(&self, start: State, end: State, objective: &str) -> Problem {
        let body = Body { inertia: self.inertia.clone(), mass: None };
        let problem = Problem::attitude(body, start, end, self.duration).with_steps(100);
        match objective {
            "time" => problem.with_objective(Objective::Time).with_duration(Duration::SOUGHT),
            "fuel" => problem.with_objective(Objective::Fuel(Default::default())),
            _ => problem,
        }
    }
}

fn wheels(momentum: Vec<f64>) -> Actuation {
    let axes = [(0.8, 0.0), (-0.8, 0.0), (0.0, 0.8), (0.0, -0.8)].map(|(x, y)| Vector3::new(x, y, 0.6));
    let wheels = Wheels { momentum, momentum_limit: vec![MOMENTUM; 4] };
    Actuation::of_wheels(axes.to_vec(), vec![TORQUE; 4], wheels).expect("four wheels about unit vectors")
}

fn thrusters() -> Actuation {
    let (x, y, z) = (Vector3::x(), Vector3::y(), Vector3::z());
    let couples =
        [(z, x), (x, y), (y, z)].map(|(arm, push)| [(arm, push), (arm, -push), (-arm, push), (-arm, -push)]);
    let (positions, directions) = couples.concat().into_iter().unzip();
    let limits = Limits { size: Some(vec![TORQUE; 12]), one_sided: true, ..Limits::default() };
    let thrusters = Actuation::of_thrusters(positions, directions, limits).expect("twelve thrusters");
    // The body rotates and does not translate, so only the torques of the thrusters count.
    Actuation::torques(thrusters.torque)
}

fn torques(rate: Option<f64>) -> Actuation {
    let limits =
        Limits { size: Some(vec![TOGETHER; 3]), rate: rate.map(|rate| vec![rate; 3]), ..Limits::default() };
    let set = ActuatorSet::three_axes(AxisFrame::Body).with_limits(limits).expect("limits of three torques");
    Actuation::torques(set)
}

fn keep_out(name: &str, boresight: Vector3, direction: Vector3, half_angle: f64) -> Constraint {
    let pointing =
        Pointing::new(Side::KeepOut, vec![boresight], vec![Direction::Fixed(direction)], half_angle);
    Constraint { name: name.into(), rule: Rule::Pointing(pointing) }
}

/// Returns a maneuver to an end with a free roll or a free attitude.
pub fn to_end(end: &str, input: &str, objective: &str, number: usize) -> Problem {
    let seed = 67 + ENDS.iter().position(|known| *known == end).unwrap_or(0) as u64;
    let mut drawn = Drawn::of(seed, number);
    let random = &mut drawn.random;
    let boresight = random.direction();
    let axis = boresight.cross(&random.normal_direction()).normalize();
    let (turn, rate) = (axis * drawn.angle, random.within_cube(0.02));
    let direction = lie::exp(&turn) * boresight;
    let moves = random.within_cube(0.1 * drawn.angle / drawn.unit);
    let last = 8.0 * drawn.unit;
    let moving = Direction::along(0.0, last, last, 40, |time: f64| lie::exp(&(moves * time)) * direction)
        .expect("a unit vector does not vanish");
    let (second, towards) = (random.direction(), random.direction());
    let (speed, side, half) = (random.within(0.5, 0.8), random.direction(), random.within(8.0, 20.0));
    let limit = Vector3::repeat(drawn.angle / drawn.unit * speed);
    let trackers: Vec<Vector3> = (0..3).map(|_| random.direction()).collect();
    let sun = random.direction();
    let rest = State::at_rest(Matrix3::identity());
    let start = if end == "any attitude" { State::attitude(Matrix3::identity(), rate) } else { rest };
    let fixed = Aim::new(boresight, Direction::Fixed(direction)).at_rest();
    let problem = drawn.problem(start, rest, objective);
    let mut problem = match end {
        "roll in a band" => {
            let second = (second - boresight * second.dot(&boresight)).normalize();
            let aim = fixed.with_roll_towards(second, Direction::Fixed(towards), 40f64.to_radians());
            problem.with_aim_at_end(aim)
        }
        "moving target" => problem.with_aim_at_end(Aim::new(boresight, moving).at_rest()),
        "matched rates" => problem.with_aim_at_end(Aim::new(boresight, moving)),
        "any attitude" => problem.with_any_attitude_at_end(),
        _ => problem.with_aim_at_end(fixed),
    };
    problem = problem.with_actuation(if input == "thrusters" { thrusters() } else { wheels(vec![0.0; 4]) });
    problem.name = format!("{end}, {input}, {objective} {number}");
    match input {
        "rate limit" => {
            problem.with_constraint(Constraint { name: "rates".into(), rule: Rule::RateAxes(limit) })
        }
        "cone" => {
            // For a small turn the cone is smaller, so that it contains neither end of the turn.
            let half = half.to_radians().min(0.3 * drawn.angle);
            let passed = lie::exp(&(turn * 0.5)) * boresight;
            let beside = (side - passed * passed.dot(&side)).normalize() * (0.6 * half).tan();
            problem.with_constraint(keep_out("cone", boresight, (passed + beside).normalize(), half))
        }
        "two of three trackers" => {
            let names: Vec<String> = (1..=3).map(|number| format!("tracker {number}")).collect();
            // A constraint belongs to one set: each tracker has one constraint for each pair that
            // contains it.
            let pairs = [[0, 1], [1, 2], [2, 0]];
            let mut sets = Vec::new();
            for pair in pairs {
                let own = pair.map(|tracker| format!("{}, pair {}", names[tracker], sets.len() + 1));
                for (name, tracker) in own.iter().zip(pair) {
                    problem =
                        problem.with_constraint(keep_out(name, trackers[tracker], sun, 25f64.to_radians()));
                }
                sets.push(own.to_vec());
            }
            problem.with_alternatives(Alternatives { name: "sky".into(), sets })
        }
        _ => problem,
    }
}

/// Returns a maneuver between given states.
pub fn between(motion: &str, objective: &str, number: usize) -> Problem {
    let seed = 80 + MOTIONS.iter().position(|known| *known == motion).unwrap_or(0) as u64;
    let mut drawn = Drawn::of(seed, number);
    let random = &mut drawn.random;
    let turn = random.normal_direction() * drawn.angle;
    let mut ends = [State::at_rest(Matrix3::identity()), State::at_rest(lie::exp(&turn))];
    let actuation = match motion {
        "torque rates" => torques(Some(TOGETHER / (drawn.unit * random.within(0.1, 0.4)))),
        "spins" => {
            // While a rate is reduced to zero in the time t, the body turns by rate·t/2.
            for end in &mut ends {
                let most = (2.0 * TAU * random.within(0.0, 5.0) * TOGETHER / MOMENT).sqrt();
                end.angular_velocity = random.normal_direction() * most;
                drawn.duration += 1.5 * most * MOMENT / TOGETHER;
            }
            torques(None)
        }
        _ => wheels((0..4).map(|_| 0.5 * MOMENTUM * random.uniform()).collect()),
    };
    let [start, end] = ends;
    let mut problem = drawn.problem(start, end, objective).with_actuation(actuation);
    // A body that makes ten turns needs more steps than one that makes none.
    problem.chooses_steps = motion == "spins";
    problem.name = format!("{motion}, {objective} {number}");
    problem
}
