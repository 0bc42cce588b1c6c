//! Counts how many minimum-fuel and minimum-time maneuvers of a body that translates or is in a
//! force field are solved and verified, and measures what they save and their computing time.
//!
//! `cargo run --release -p evidence -- fuel_of_forces [COUNT [FAMILY]]`, 100 cases of each
//! family by default.
//!
//! The law: the principal moments are the sides of a random triangle in [1, 10], about random axes.
//! The turn has a uniform direction and an angle of up to π, from rest to rest. Every maneuver has
//! a plan by construction: each torque and force is limited to 1 to 3 times its largest value in
//! the minimum-effort plan without limits, which is therefore feasible. The found fuel and duration
//! must not exceed those of this plan. Minimum time is planned for all kinds except on an orbit,
//! where a spec cannot request it. The kinds are:
//!
//! - `flight`: a displacement by up to 3 m by forces along reference axes;
//! - `thrust`: a displacement by up to 3 m by forces along body axes;
//! - `thrusters`: a displacement by up to 3 m by twelve thrusters, whose pairs at a distance of 1 m
//!   also turn the body, and which share the forces and torques of the minimum-effort plan;
//! - `gravity gradient`: a turn on a circular orbit, up to a quarter of it;
//! - `orbit`: a transfer in central gravity, over up to a quarter of a circular orbit, to an end up
//!   to a tenth off the circle;
//! - `pendulum`: a turn by up to 1 rad about a pivot within 0.3 m of the mass center, in up to the
//!   duration of a swing.

use evidence::words::Words;
use slewkit::maneuver::{Duration, Fuel, Objective, Problem, Settings, State};
use slewkit::mechanics::{
    Actuation, ActuatorSet, AxisFrame, Body, GravityGradient, Inertia, Limits, SecondOrderGravity,
    UniformGravity,
};
use slewkit::plan::{Silent, Status, plan};
use slewkit::{Matrix3, Vector3, lie};
use std::collections::BTreeMap;
use std::error::Error;
use std::f64::consts::{FRAC_PI_2, PI};

use evidence::Random;

pub fn run(words: &mut Words) -> Result<(), Box<dyn Error>> {
    let count: usize = words.number("number of cases", 100)?;
    let families: [(&str, Family); 6] = [
        ("flight", |random| flight(random, AxisFrame::Reference)),
        ("thrust", |random| flight(random, AxisFrame::Body)),
        ("thrusters", |random| flight(random, AxisFrame::Body)),
        ("gravity gradient", on_orbit),
        ("orbit", transfer),
        ("pendulum", pendulum),
    ];
    let only = words.one_of("family", &families.map(|(name, _)| name))?;
    words.end()?;
    for (name, family) in families {
        if only.as_ref().is_some_and(|only| only != name) {
            continue;
        }
        let mut random = Random::new(2026);
        let (mut fuel, mut time, mut undrawn) = (Tally::default(), Tally::default(), 0);
        for index in 0..count {
            let by_thrusters = name == "thrusters";
            let Some((problem, burnt)) = limited(family(&mut random)?, by_thrusters, &mut random)? else {
                undrawn += 1;
                continue;
            };
            fuel.take(index, &problem, burnt)?;
            let fastest = problem.clone().with_objective(Objective::Time).with_duration(Duration::SOUGHT);
            if fastest.check().is_ok() {
                time.take(index, &fastest, problem.seconds())?;
            }
        }
        println!("{name}: {count} drawn, of {undrawn} there is no plan of least effort");
        fuel.report("fuel");
        time.report("time");
    }
    Ok(())
}

type Drawn = Result<Problem, Box<dyn Error>>;
type Family = fn(&mut Random) -> Drawn;

fn direction(random: &mut Random) -> Vector3 {
    // Draws a point uniform in the ball.
    loop {
        let vector = Vector3::from_fn(|_, _| random.uniform());
        if (0.01..1.0).contains(&vector.norm()) {
            return vector.normalize();
        }
    }
}

fn turn(random: &mut Random, most: f64) -> Matrix3 {
    lie::exp(&(direction(random) * random.within(0.1, most)))
}

fn body(random: &mut Random) -> Result<Body, Box<dyn Error>> {
    let frame = turn(random, PI);
    let (a, b) = (random.within(1.0, 10.0), random.within(1.0, 10.0));
    let c = random.within((a - b).abs().max(1.0), (a + b).min(10.0));
    let inertia = frame * Matrix3::from_diagonal(&Vector3::new(a, b, c)) * frame.transpose();
    Ok(Body {
        inertia: Inertia::new(0.5 * (inertia + inertia.transpose()))?,
        mass: Some(random.within(5.0, 50.0)),
    })
}

fn flight(random: &mut Random, frame: AxisFrame) -> Drawn {
    let start = State::at_rest(Matrix3::identity());
    let shift = direction(random) * random.within(0.1, 3.0);
    let end = State { position: shift, ..State::at_rest(turn(random, PI)) };
    let mut problem = Problem::rigid_body(body(random)?, start, end, random.within(2.0, 20.0));
    problem.actuation.force = Some(ActuatorSet::three_axes(frame));
    Ok(problem)
}

/// Draws a maneuver that is at rest relative to the orbit frame at both ends.
fn on_orbit(random: &mut Random) -> Drawn {
    let body = Body { mass: None, ..body(random)? };
    let rate = 1e-3;
    let field = GravityGradient::new(rate, &body.inertia)?;
    let (start, end) = (turn(random, PI), turn(random, PI));
    let at_rest = |attitude: Matrix3| State::attitude(attitude, Vector3::zeros());
    let duration = random.within(0.05, 1.0) * FRAC_PI_2 / rate;
    Ok(Problem::attitude(body, at_rest(start), at_rest(end), duration).with_environment(field))
}

fn transfer(random: &mut Random) -> Drawn {
    let mut body = body(random)?;
    // The radius of gyration becomes some tenths of the radius of the orbit.
    body.inertia = Inertia::new(body.inertia.j() * 0.1)?;
    let field = SecondOrderGravity::new(1.0, body.mass.unwrap_or(1.0), &body.inertia)?;
    let angle = random.within(0.2, 1.0) * FRAC_PI_2;
    let on_circle = |angle: f64, radius: f64, attitude: Matrix3| State {
        position: Vector3::new(angle.cos(), angle.sin(), 0.0) * radius,
        velocity: Vector3::new(-angle.sin(), angle.cos(), 0.0) / radius.sqrt(),
        ..State::at_rest(attitude)
    };
    let start = on_circle(0.0, 1.0, Matrix3::identity());
    let end = on_circle(angle, random.within(0.9, 1.1), turn(random, PI));
    Ok(Problem::rigid_body(body, start, end, angle).with_environment(field))
}

fn pendulum(random: &mut Random) -> Drawn {
    let body = body(random)?;
    let (mass, gravity) = (body.mass.unwrap_or(1.0), 9.81);
    let pivot = direction(random) * random.within(0.02, 0.3);
    let field = UniformGravity::new(mass, gravity, Vector3::z(), pivot)?;
    let swing = 2.0 * PI * (body.inertia.j().trace() / 3.0 / (mass * gravity * pivot.norm())).sqrt();
    let start = State::at_rest(turn(random, PI));
    let end = State::at_rest(start.attitude * turn(random, 1.0));
    let body = Body { mass: None, ..body };
    Ok(Problem::attitude(body, start, end, swing * random.within(0.2, 1.0)).with_environment(field))
}

/// Half the distance between the two thrusters that push in the same direction \[m\].
const ARM: f64 = 0.5;

/// Returns the outputs of twelve thrusters that together produce a force and a torque in body axes.
/// For each axis two thrusters push along it and two against it, side by side along the next axis.
fn shared(force: &Vector3, torque: &Vector3) -> Vec<f64> {
    let of_axis = |axis: usize| {
        // The thrusters at the two sides produce torques of opposite sign about the third axis.
        let (push, couple) = (0.5 * force[axis], 0.5 * torque[(axis + 2) % 3] / ARM);
        [(1.0, 1.0), (1.0, -1.0), (-1.0, 1.0), (-1.0, -1.0)]
            .map(|(way, beside)| (way * push).max(0.0) + (-way * beside * couple).max(0.0))
    };
    (0..3).flat_map(of_axis).collect()
}

fn thrusters(limits: Limits) -> Result<Actuation, Box<dyn Error>> {
    let ways = [(1.0, 1.0), (1.0, -1.0), (-1.0, 1.0), (-1.0, -1.0)];
    let all = (0..3).flat_map(|axis| ways.map(|(way, beside)| (axis, way, beside * ARM)));
    let positions = all
        .clone()
        .map(|(axis, way, beside)| Vector3::ith((axis + 1) % 3, beside) - Vector3::ith(axis, 0.6 * way));
    let directions = all.clone().map(|(axis, way, _)| Vector3::ith(axis, way));
    Ok(Actuation::of_thrusters(positions.collect(), directions.collect(), limits)?)
}

/// Returns a minimum-fuel maneuver with limits that its minimum-effort plan keeps, and the fuel of
/// that plan.
fn limited(
    problem: Problem,
    by_thrusters: bool,
    random: &mut Random,
) -> Result<Option<(Problem, f64)>, Box<dyn Error>> {
    let problem = problem.with_steps(50);
    let effort = plan(&problem, &Settings::default(), None, &mut Silent)?;
    if effort.status != Status::Solved {
        return Ok(None);
    }
    let trajectory = &effort.solution.trajectory;
    let given = |row: usize| {
        let inputs = trajectory.inputs(row);
        if by_thrusters {
            shared(&Vector3::from_column_slice(&inputs[..3]), &Vector3::from_column_slice(&inputs[3..]))
        } else {
            inputs.to_vec()
        }
    };
    let rows: Vec<Vec<f64>> = (0..trajectory.torque.len()).map(given).collect();
    let forces = problem.actuation.force.as_ref().map_or(0, ActuatorSet::count);
    let mut limits = |first: usize, count: usize| {
        let most = |input: usize| rows.iter().map(|row| row[input].abs()).fold(0.0, f64::max);
        let size =
            (first..first + count).map(|input| most(input).max(1e-3 * most(first)) * random.within(1.0, 3.0));
        Limits { size: Some(size.collect()), one_sided: by_thrusters, ..Limits::default() }
    };
    let mut actuation: Actuation = problem.actuation.clone();
    if by_thrusters {
        actuation = thrusters(limits(0, 12))?;
    } else {
        actuation.force = match actuation.force {
            Some(force) => Some(force.with_limits(limits(0, 3))?),
            None => None,
        };
        actuation.torque = actuation.torque.with_limits(limits(forces, 3))?;
    }
    let fuel = Fuel::default();
    let h = problem.step();
    let last = rows.len() - 1;
    let weight = |row: usize| if row == 0 || row == last { 0.5 * h } else { h };
    let burnt =
        rows.iter().enumerate().map(|(row, inputs)| weight(row) * fuel.rate(&actuation, inputs)).sum();
    Ok(Some((problem.with_actuation(actuation).with_objective(Objective::Fuel(fuel)), burnt)))
}

#[derive(Default)]
struct Tally {
    cases: usize,
    statuses: BTreeMap<&'static str, usize>,
    dearer: usize,
    savings: Vec<f64>,
    solve_ms: Vec<f64>,
}

impl Tally {
    /// Plans one maneuver, and compares the result with the fuel or duration of the known plan.
    fn take(&mut self, index: usize, problem: &Problem, known: f64) -> Result<(), Box<dyn Error>> {
        self.cases += 1;
        let found = plan(problem, &Settings::default(), None, &mut Silent)?;
        let (solution, what) = (&found.solution, problem.objective.name());
        *self.statuses.entry(found.status.name()).or_default() += 1;
        self.solve_ms.push(solution.solve_time * 1e3);
        if found.status != Status::Solved {
            let checks = found.verification.iter().flat_map(|verification| &verification.checks);
            let failed: Vec<&str> = checks.filter(|check| !check.passed).map(|check| &*check.name).collect();
            println!("  case {index}, {what}: {}, {:?} {failed:?}", found.status.name(), solution.shortfall);
            return Ok(());
        }
        self.savings.push(100.0 * (1.0 - solution.cost / known));
        if solution.cost > known * (1.0 + 1e-9) {
            self.dearer += 1;
            println!("  case {index}, {what}: {}, where {known} is known", solution.cost);
        }
        Ok(())
    }

    fn report(mut self, what: &str) {
        if self.cases == 0 {
            return;
        }
        let solved = self.statuses.get(Status::Solved.name()).copied().unwrap_or(0);
        println!("  least {what}: {solved} of {} solved and verified, {:?}", self.cases, self.statuses);
        self.savings.sort_by(f64::total_cmp);
        self.solve_ms.sort_by(f64::total_cmp);
        let at = |list: &[f64], part: f64| {
            list.get((part * list.len() as f64) as usize).copied().unwrap_or(f64::NAN)
        };
        println!(
            "    saved beside the plan of least effort: median {:.1} %; dearer than that {}",
            at(&self.savings, 0.5),
            self.dearer
        );
        println!(
            "    solve: median {:.0} ms, 90 % {:.0} ms",
            at(&self.solve_ms, 0.5),
            at(&self.solve_ms, 0.9)
        );
    }
}
