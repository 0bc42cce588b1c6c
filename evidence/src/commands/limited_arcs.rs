//! Counts how many minimum-time and minimum-fuel plans with further limits than torque limits have
//! arcs, and checks whether the arcs depend on the grid.
//!
//! `cargo run --release -p evidence -- limited_arcs [CASES [FIRST [KIND]]]`, 300 cases by default.
//! Every case is planned on 100 and on 400 steps. Kinds are `axis-rates`, `rate-norm`, `cones`,
//! `moving-cone`, `wheels`, `orbit` and `flight`, each for minimum time and for minimum fuel, and
//! `torque-rates` for minimum time only. Without a KIND all kinds are planned in turn. The law is
//! printed before the figures.
//!
//! The first-order gap of each plan in continuous time is printed relative to its cost, with or
//! without arcs. The plan on 100 steps also lands. `excess` is the relative excess of the landed
//! plan's cost over the cost in continuous time, which is the cost of the arcs or, without arcs,
//! extrapolated from both grids. The excess is compared with the gap and with the cost of the
//! constraints that landing tightens.
//!
//! `… -- limited_arcs spec NUMBER [KIND]` writes one of the maneuvers as a spec in JSON.

use evidence::words::Words;
use slewkit::maneuver::{
    Constraint, Direction, Duration, Fuel, Motion, Objective, Pointing, Problem, Rule, Settings, Side, State,
    Target,
};
use slewkit::mechanics::{Actuation, ActuatorSet, AxisFrame, Body, GravityGradient, Inertia, Limits, Wheels};
use slewkit::plan::{Plan, Silent, Status, plan};
use slewkit::{Matrix3, Vector3, lie};

use evidence::Random;
use slewkit_files::spec::SpecDocument;
use std::collections::BTreeMap;

const LAW: &str = "\
law: moments in a ratio up to 5 that bodies have, along the axes of three torques; their limits 0.4
     to 1.6; start of a uniform attitude, rotation by 30 to 180 deg about a uniform axis, from rest
     to rest. Shaped by a limit of each rate, of the norm of the rate (0.3 to 0.9 of the largest
     without it); one to three keep-out cones of 10 to 30 deg that hold neither end, the first of
     them on the way of a turn about the fixed axis; one such cone that turns by 20 deg in the time
     of the turn; three wheels that hold 0.3 to 0.9 of what they would be given; an orbit in a
     fiftieth to a fifth of which the turn is done, from rest to rest in its frame; three forces of
     0.4 to 1.6 fixed to the body of mass 1, over a way of 0.1 to 1; or torques, in one of two of
     wheels, that go from off to their limits in 3 to 30 % of the shortest duration. Least time, and
     but for these least fuel in 1.2 to 3 times the shortest duration";

/// The relative difference below which the durations on both grids count as equal.
const SAME: f64 = 1e-6;

const KINDS: [&str; 8] =
    ["axis-rates", "rate-norm", "cones", "moving-cone", "wheels", "orbit", "flight", "torque-rates"];

/// Draws the maneuver of a kind with this number; `None` if the draw has no plan without the
/// further limits.
pub(super) fn case(seed: usize, kind: &str, fuel: bool) -> Option<Problem> {
    let mut random = Random::of_case(39, seed);
    let moments = loop {
        let m = Vector3::from_fn(|_, _| 5.0_f64.powf(random.unit()));
        if m.x + m.y > 1.02 * m.z && m.y + m.z > 1.02 * m.x && m.z + m.x > 1.02 * m.y {
            break m;
        }
    };
    let body = Body { inertia: Inertia::diagonal(moments).ok()?, mass: Some(1.0) };
    let size: Vec<f64> = (0..3).map(|_| random.within(0.4, 1.6)).collect();
    let torques = ActuatorSet::three_axes(AxisFrame::Body);
    let torques = torques.with_limits(Limits { size: Some(size.clone()), ..Limits::default() }).ok()?;
    let start = lie::exp(&(random.direction() * random.within(0.0, 3.0)));
    let turn = random.direction() * random.within(30.0, 180.0).to_radians();
    let end = start * lie::exp(&turn);
    let free = Problem::attitude(body, State::at_rest(start), State::at_rest(end), 1.0);
    let free = free.with_actuation(Actuation::torques(torques.clone())).with_objective(Objective::Time);
    let mut free = free.with_duration(Duration::SOUGHT);
    free.name = format!("case {seed}: {kind}");
    let settings = Settings::discrete();
    let quickest = plan(&free, &settings, None, &mut Silent).ok()?.solution.trajectory;
    let (rates, shortest) = (&quickest.angular_velocity, *quickest.time.last()?);
    let peak = |of: &dyn Fn(&Vector3) -> f64| rates.iter().map(of).fold(0.0, f64::max);
    let share = random.within(0.3, 0.9);
    let mut limited = free;
    let rate_limit = |rule: Rule| Constraint { name: "rate".into(), rule };
    match kind {
        "axis-rates" => {
            let limits = Vector3::from_fn(|axis, _| share * peak(&|rate| rate[axis].abs()));
            limited = limited.with_constraint(rate_limit(Rule::RateAxes(limits)));
        }
        "rate-norm" => {
            limited = limited.with_constraint(rate_limit(Rule::RateNorm(share * peak(&|rate| rate.norm()))));
        }
        "cones" => {
            for index in 0..1 + random.below(3) {
                limited = with_cone(limited, index, &turn, &mut random, Vector3::zeros());
            }
        }
        "moving-cone" => {
            let rate = random.direction() * (20.0_f64.to_radians() / shortest);
            limited = with_cone(limited, 0, &turn, &mut random, rate);
        }
        "wheels" => {
            let held = |axis: usize| share * moments[axis] * peak(&|rate| rate[axis].abs());
            let wheels = Wheels { momentum: vec![0.0; 3], momentum_limit: (0..3).map(held).collect() };
            let axes = vec![Vector3::x(), Vector3::y(), Vector3::z()];
            limited = limited.with_actuation(Actuation::of_wheels(axes, size, wheels).ok()?);
        }
        "torque-rates" => {
            let ramp = random.within(0.03, 0.3) * shortest;
            let rate = Some(size.iter().map(|size| size / ramp).collect());
            let mut set = torques;
            if random.coin() {
                let wheels = Wheels { momentum: vec![0.0; 3], momentum_limit: vec![f64::INFINITY; 3] };
                let axes = vec![Vector3::x(), Vector3::y(), Vector3::z()];
                limited = limited.with_actuation(Actuation::of_wheels(axes, size.clone(), wheels).ok()?);
                set = limited.actuation.torque.clone();
            }
            let limits = Limits { size: Some(size), rate, ..Limits::default() };
            limited.actuation.torque = set.with_limits(limits).ok()?;
        }
        "orbit" => {
            let rate = std::f64::consts::TAU / shortest * random.within(0.02, 0.2);
            limited =
                limited.clone().with_environment(GravityGradient::new(rate, &limited.body.inertia).ok()?);
            for state in [&mut limited.start, &mut limited.end] {
                state.angular_velocity = state.attitude.tr_mul(&(rate * Vector3::y()));
            }
        }
        _ => {
            limited.motion = Motion::RigidBody;
            limited.end.position = random.direction() * random.within(0.1, 1.0);
            let size = (0..3).map(|_| random.within(0.4, 1.6)).collect();
            let limits = Limits { size: Some(size), ..Limits::default() };
            let forces = ActuatorSet::three_axes(AxisFrame::Body).with_limits(limits).ok()?;
            limited = limited.with_actuation(Actuation::torques_and_forces(torques, forces));
        }
    }
    if !fuel {
        return Some(limited);
    }
    let shortest = plan(&limited, &settings, None, &mut Silent).ok()?;
    let duration = random.within(1.2, 3.0) * *shortest.solution.trajectory.time.last()?;
    let fuel = Fuel::default();
    Some(limited.with_objective(Objective::Fuel(fuel)).with_duration(duration))
}

/// Adds a cone about a direction that turns at `rate`. The first cone lies on the path of the turn.
fn with_cone(problem: Problem, index: usize, turn: &Vector3, random: &mut Random, rate: Vector3) -> Problem {
    let (start, end) = (problem.start.attitude, problem.end.attitude);
    loop {
        let boresight = random.direction();
        let half_angle = random.within(10.0, 30.0).to_radians();
        let passed: Matrix3 = start * lie::exp(&(turn * random.within(0.3, 0.7)));
        let direction = if index == 0 { passed * boresight } else { random.direction() };
        let away = |r: &Matrix3| (r * boresight).angle(&direction) > half_angle + 0.02;
        if away(&start) && away(&end) {
            let direction = direction.normalize();
            let turning = || Direction::turning(direction, rate, 1e3).expect("a direction that turns");
            let still = rate == Vector3::zeros();
            let directions = vec![if still { Direction::Fixed(direction) } else { turning() }];
            let pointing = Pointing::new(Side::KeepOut, vec![boresight], directions, half_angle);
            let rule = Rule::Pointing(pointing);
            return problem.with_constraint(Constraint { name: format!("cone {index}"), rule });
        }
    }
}

/// The first-order gap, relative to the cost, below which a plan without arcs counts as near the
/// optimum.
const SMALL: f64 = 1e-3;

/// The numbers of steps of both grids.
const STEPS: [usize; 2] = [100, 400];

/// The figures of a plan that are printed.
struct Told {
    solved: bool,
    cost: f64,
    /// The cost of the continuous extremal and its gap; `None` if the plan has no arcs.
    arcs: Option<[f64; 2]>,
    /// The first-order gap in continuous time, and the first-order cost of the constraints that
    /// landing tightens, both relative to the cost.
    gap: Option<[f64; 2]>,
}

impl Told {
    fn of(found: &Plan) -> Self {
        let (solved, solution) = (found.status == Status::Solved, &found.solution);
        let arcs = solution.switching.as_ref().map(|told| [told.continuous_cost, told.gap]);
        let gap = solution.interior.as_ref().and_then(|work| work.continuous_gap.as_ref());
        let gap = gap.map(|told| [told.gap, told.drawn_in].map(|gap| gap / solution.cost));
        Self { solved, cost: solution.cost, arcs: arcs.filter(|_| solved), gap: gap.filter(|_| solved) }
    }

    /// Returns whether the plan has arcs, or a small gap.
    fn is_near(&self) -> bool {
        self.arcs.is_some() || self.gap.is_some_and(|[gap, _]| gap < SMALL)
    }

    fn in_words(&self) -> String {
        let gap = self.gap.map_or("no gap".into(), |[gap, _]| format!("{gap:.1e}"));
        match (self.solved, &self.arcs) {
            (true, Some([arcs, own])) => {
                format!("{:.6} arcs {arcs:.9} gap {own:.1e}, on the grid {gap}", self.cost)
            }
            (true, None) => format!("{:.6} no arcs, gap {gap}", self.cost),
            (false, _) => "not solved".into(),
        }
    }
}

/// Returns the kind of a case, and whether it minimises fuel. With `only`, all cases are of this
/// kind.
pub(super) fn kind_of(seed: usize, only: Option<&str>) -> (&str, bool) {
    let kind = only.unwrap_or(KINDS[seed / 2 % KINDS.len()]);
    (kind, seed % 2 == 1 && kind != "torque-rates")
}

pub fn run(words: &mut Words) -> Result<(), Box<dyn std::error::Error>> {
    if words.next_is("spec") {
        let seed: usize = words.required("number of a case")?;
        let only = words.one_of("kind", &KINDS)?;
        words.end()?;
        let (kind, fuel) = kind_of(seed, only.as_deref());
        let problem = case(seed, kind, fuel).ok_or("no such maneuver")?;
        println!("{}", serde_json::to_string(&SpecDocument::new(&problem, &Settings::default())?)?);
        return Ok(());
    }
    let count: usize = words.number("number of cases", 300)?;
    let first: usize = words.number("number of the first case", 0)?;
    let only = words.one_of("kind", &KINDS)?;
    words.end()?;
    println!("{LAW}");
    let settings = Settings { target: Target::Discrete, ..Settings::default() };
    let mut tally = BTreeMap::<String, [usize; 6]>::new();
    let (mut near, mut bounded) = ([0; 2], [0; 2]);
    for seed in first..first + count {
        let (shape, fuel) = kind_of(seed, only.as_deref());
        let kind = format!("{}, {shape}", if fuel { "fuel" } else { "time" });
        let own = tally.entry(kind.clone()).or_default();
        let Some(problem) = case(seed, shape, fuel) else { continue };
        let mut told = Vec::new();
        for steps in STEPS {
            let problem = problem.clone().with_steps(steps);
            told.push(Told::of(&plan(&problem, &settings, None, &mut Silent)?));
        }
        let [coarse, fine] = [&told[0], &told[1]];
        own[0] += 1;
        own[1] += usize::from(coarse.solved);
        own[2] += usize::from(coarse.arcs.is_some());
        own[3] += usize::from(fine.arcs.is_some());
        let both = coarse.arcs.zip(fine.arcs);
        let apart = both.map(|([a, _], [b, _])| (a / b - 1.0).abs());
        own[4] += usize::from(apart.is_some_and(|apart| apart <= SAME));
        own[5] += usize::from(coarse.arcs.is_some_and(|[cost, gap]| gap <= SAME * cost));
        near.iter_mut().zip(&told).for_each(|(near, told)| *near += usize::from(told.is_near()));
        let landed = Settings { target: Target::Motion, ..settings.clone() };
        let landed = Told::of(&plan(&problem.with_steps(STEPS[0]), &landed, None, &mut Silent)?);
        let ratio = (STEPS[1] / STEPS[0]) as f64;
        let limit = fine.cost + (fine.cost - coarse.cost) / (ratio * ratio - 1.0);
        let truth = fine.arcs.or(coarse.arcs).map_or(limit, |[cost, _]| cost);
        let excess = landed.cost / truth - 1.0;
        let within = landed.gap.filter(|_| coarse.solved && fine.solved);
        if let Some([gap, drawn_in]) = within {
            bounded[0] += 1;
            bounded[1] += usize::from(excess <= gap + drawn_in);
        }
        let within = within.map_or("no gap".into(), |[gap, by]| format!("gap {gap:.1e}, drawn in {by:.1e}"));
        let apart = apart.map_or(String::new(), |apart| format!("{apart:.1e}"));
        let [coarse, fine] = [coarse.in_words(), fine.in_words()];
        println!("case {seed} {kind}: {coarse} | {fine} | {apart} | landed: excess {excess:.1e}, {within}");
    }
    println!(
        "of each kind: cases, solved on 100 steps, with arcs on 100, on 400, of one cost to {SAME:.0e}, with \
            a gap below {SAME:.0e}"
    );
    for (kind, own) in &tally {
        println!("  {kind:20} {own:?}");
    }
    let sum = |column: usize| tally.values().map(|own| own[column]).sum::<usize>();
    let all: Vec<usize> = (0..6).map(sum).collect();
    println!("  {:20} {all:?}", "all");
    println!(
        "excess of the landed plan within its gap and what is drawn in: {} of {}",
        bounded[1], bounded[0]
    );
    let [coarse, fine] = near;
    println!(
        "arcs, or a gap of first order below {SMALL:.0e}: {coarse} of {count} on 100 steps, {fine} on 400"
    );
    Ok(())
}
