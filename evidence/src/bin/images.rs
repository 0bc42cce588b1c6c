//! Whether a maneuver and its images have one answer: backwards, in three mirrors, in permuted body axes.
//!
//! `cargo run --release -p evidence --bin images [-- COUNT [KIND [FIRST]]]`, 100 of each kind by default. Nothing but the words
//! differs between images, so their costs should not. Each line tells of how many the costs lie within 1e-4 (or the gaps), of how
//! many the first is the best, by how much the worst of all is dearer than an image of it, how often some images are solved and
//! others are not, and how long plans take.
//!
//! The laws. All: a body of random principal axes in one of three maneuvers and along the axes of the torques otherwise;
//! rotation vector of uniform direction, angle up to π; 200 steps; where not said otherwise moments in a ratio up to 5 and rates up
//! to 0.3 in the unit of time in 40 % of them. `time`: three torques, limits from 0.4 to 1.6. `unequal`: moments in a ratio from 5
//! to 100, from rest to rest. `fuel`: the duration from 1.05 to 1000 times that of the turn about the axis, uniform in its
//! logarithm. `price`: a second costs from 2 to 200 % of what all inputs cost at their limits. `thrusters`, `thruster-fuel`:
//! 6 to 12 one-sided thrusters about random axes that reach every direction, from rest to rest; of fuel in 1.5 to 5 times that
//! duration. `long`: the long way round in least time, from rest to rest. `given`: rotations of 120 to 840° as written, the same.
//! `cones`, `cone-fuel`: past one to three cones on 60 steps.

use evidence::Random;
use evidence::metamorphic::images;
use slewkit::maneuver::{
    Constraint, Direction, Fuel, Objective, Path, Pointing, Problem, Rule, Settings, Side, State, Target,
};
use slewkit::mechanics::{Actuation, ActuatorSet, AxisFrame, Body, Inertia, Limits};
use slewkit::plan::{Plan, Silent, Status, plan};
use slewkit::{Matrix3, Vector3, lie};
use std::error::Error;
use std::f64::consts::PI;
use std::sync::Mutex;
use std::sync::atomic::{AtomicU64, Ordering};
use std::thread;
use std::time::Instant;

/// Costs that differ by this part are those of two answers.
const SAME: f64 = 1e-4;

/// The kinds of maneuvers, as they stand above.
#[derive(Clone, Copy, Debug, PartialEq)]
enum Kind {
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
}

const KINDS: [(&str, Kind); 10] = [
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
];

/// What images of one maneuver came to.
struct Compared {
    index: u64,
    costs: Vec<(&'static str, Option<f64>)>,
    gap: f64,
    seconds: Vec<f64>,
}

fn main() -> Result<(), Box<dyn Error>> {
    let words: Vec<String> = std::env::args().skip(1).collect();
    let count: u64 = words.first().map_or(Ok(100), |text| text.parse())?;
    let first: u64 = words.get(2).map_or(Ok(0), |text| text.parse())?;
    let asked = words.get(1).filter(|word| word.as_str() != "all");
    let kinds = KINDS.into_iter().filter(|(name, _)| asked.is_none_or(|asked| asked == name));
    for (name, kind) in kinds {
        let (next, all) = (AtomicU64::new(first), Mutex::new(Vec::new()));
        thread::scope(|scope| {
            for _ in 0..thread::available_parallelism().map_or(1, usize::from) {
                scope.spawn(|| {
                    loop {
                        let index = next.fetch_add(1, Ordering::Relaxed);
                        if index >= first + count {
                            break;
                        }
                        let found = maneuver(kind, index).map(|problem| compared(index, &problem));
                        all.lock().unwrap().extend(found);
                    }
                });
            }
        });
        let mut all = all.into_inner()?;
        all.sort_by_key(|one: &Compared| one.index);
        tell(name, &all);
    }
    Ok(())
}

fn tell(name: &str, all: &[Compared]) {
    let (mut same, mut best_first, mut partly, mut worst) = (0, 0, 0, 0.0_f64);
    let mut seconds: Vec<f64> = Vec::new();
    for Compared { index, costs, gap, seconds: taken } in all {
        seconds.extend(taken);
        let solved = costs.iter().filter_map(|(name, cost)| Some((name, (*cost)?)));
        let Some((of, least)) = solved.clone().min_by(|a, b| a.1.total_cmp(&b.1)) else { continue };
        let most = solved.map(|(_, cost)| cost).fold(0.0, f64::max);
        let apart = most / least - 1.0;
        let lacks = costs.iter().any(|(_, cost)| cost.is_none());
        let one = apart <= SAME.max(*gap) && !lacks;
        let first = costs[0].1.is_some_and(|cost| cost <= least * (1.0 + SAME.max(*gap)));
        same += usize::from(one);
        best_first += usize::from(first);
        partly += usize::from(lacks);
        worst = worst.max(apart);
        if !one {
            let told = costs.iter().map(|(name, cost)| match cost {
                Some(cost) => format!("{name} {cost:.6}"),
                None => format!("{name} none"),
            });
            println!("  {name} {index}: best {of}; {}", told.collect::<Vec<_>>().join(", "));
        }
    }
    seconds.sort_by(f64::total_cmp);
    let slowest = |one: &Compared| one.seconds.iter().copied().fold(0.0, f64::max);
    let slow = all.iter().max_by(|a, b| slowest(a).total_cmp(&slowest(b))).map_or(0, |one| one.index);
    let at = |part: f64| seconds[((seconds.len() - 1) as f64 * part) as usize];
    println!(
        "{name:<14} {:>5} maneuvers: one answer {same}, the first is the best {best_first}, solved in some images only {partly}, \
         worst {:.2} %; median {:.3} s, 99 % {:.2} s, most {:.2} s ({slow})",
        all.len(),
        100.0 * worst,
        at(0.5),
        at(0.99),
        at(1.0)
    );
}

fn compared(index: u64, problem: &Problem) -> Compared {
    let settings = Settings { target: Target::Discrete, ..Settings::default() };
    let (mut gap, mut seconds) = (0.0_f64, Vec::new());
    let mut cost_of = |problem: &Problem| {
        let began = Instant::now();
        let planned = plan(problem, &settings, None, &mut Silent).ok();
        seconds.push(began.elapsed().as_secs_f64());
        let planned = planned.filter(|plan| plan.status == Status::Solved)?;
        let (cost, of_plan) = cost_and_gap(&planned);
        gap = gap.max(of_plan);
        Some(cost)
    };
    let mut costs = vec![("itself", cost_of(problem))];
    costs.extend(images(problem).iter().map(|(name, image)| (*name, cost_of(image))));
    Compared { index, costs, gap, seconds }
}

/// The cost, and what its gap is of it: that of the extremal, as arcs of images are laid on steps in other ways, unless the grid is
/// dearer by more than a thousandth, which its steps do not account for.
fn cost_and_gap(plan: &Plan) -> (f64, f64) {
    let solution = &plan.solution;
    match &solution.switching {
        Some(switching) => {
            (switching.continuous_cost.max(0.999 * solution.cost), switching.gap / solution.cost)
        }
        None => (solution.cost, 0.0),
    }
}

/// The maneuver of this index among those of a kind; `None` where it cannot be built.
fn maneuver(kind: Kind, index: u64) -> Option<Problem> {
    let mut random = Random::of_case(0x1a6e_5000 + kind as u64, index as usize);
    let log_uniform = |random: &mut Random, low: f64, high: f64| low * (high / low).powf(random.unit());
    let ratio =
        if kind == Kind::Unequal { log_uniform(&mut random, 5.0, 100.0) } else { random.within(1.0, 5.0) };
    // Moments that a body can have: the largest is at most the sum of the others.
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
        _ => {
            let limits = (0..3).map(|_| random.within(0.4, 1.6)).collect();
            ActuatorSet::three_axes(AxisFrame::Body)
                .with_limits(Limits { size: Some(limits), ..Limits::default() })
                .ok()?
        }
    };
    let sizes = torques.limits().size.clone()?;
    let mean = sizes.iter().sum::<f64>() / sizes.len() as f64;
    // About the axis alone, from rest to rest.
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
    let problem = match kind {
        Kind::Fuel | Kind::ThrusterFuel | Kind::ConeFuel => {
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

/// One to three directions that a boresight is to be kept from, near the middle of the turn.
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

/// Six to twelve thrusters that push to one side each and together turn the body any way round.
fn thrusters(random: &mut Random) -> Option<ActuatorSet> {
    let count = 6 + random.below(7);
    for _ in 0..1000 {
        let axes: Vec<Vector3> = (0..count).map(|_| direction(random)).collect();
        // A direction that no axis is near to would be reached by none: seen on many.
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
