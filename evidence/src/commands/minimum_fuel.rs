//! Counts how many random minimum-fuel maneuvers are solved and verified, how large their gaps are,
//! how often the default search finds the plan of the thorough search, and how long it takes.
//!
//! `cargo run --release -p evidence -- minimum_fuel [COUNT [FAMILY [alone]]]`. `alone` omits the
//! thorough search, which takes most of the time.
//!
//! The law: the principal moments are the sides of a random triangle in [1, 10], about random axes.
//! The rotation vector has a uniform direction and an angle of up to π. Even cases are from rest to
//! rest; odd cases have rates of up to 0.3 rad in the unit of time. Limits are from 1 to 5, and the
//! duration is 1.3 to 4 times the shortest duration that is found. The families are `box` (three
//! torques of both signs along the body axes), `thrusters` (eight one-sided torques in random
//! directions, one in each octant) and `norm` (one torque of any direction and limited norm).
//! `box-sought` and `thruster-sought` have the same inputs and the best duration, where a second
//! costs 2 to 50 % of all inputs at their limits, log-uniform; every fourth maneuver has a bound on
//! the duration instead. `box-pulses` and `thruster-pulses` have the same inputs, off or at a
//! limit, with a minimum pulse width of 1 to 10 % of the duration, log-uniform; their additional
//! cost relative to plans without a minimum pulse width is printed.

use evidence::words::Words;
use slewkit::maneuver::{Duration, Fuel, Objective, Problem, Settings, State, Structure, Thoroughness};
use slewkit::mechanics::{Actuation, ActuatorSet, AxisFrame, Body, Inertia, Limits};
use slewkit::plan::{Plan, Silent, Status, plan};
use slewkit::{Matrix3, Vector3, lie};
use std::error::Error;
use std::f64::consts::PI;
use std::time::Instant;

use evidence::Random;

/// The relative gap, and the relative difference of costs, above which they count.
const SMALL: f64 = 1e-4;

/// The number of maneuvers with a minimum pulse width that the thorough search also plans.
const COMPARED: usize = 20;

/// The family of maneuvers, which determines the inputs and their limits.
#[derive(Clone, Copy, PartialEq)]
pub(super) enum Family {
    Box,
    Thrusters,
    Norm,
    BoxSought,
    ThrusterSought,
    BoxPulses,
    ThrusterPulses,
}

impl Family {
    pub(super) const ALL: [Self; 7] = [
        Self::Box,
        Self::Thrusters,
        Self::Norm,
        Self::BoxSought,
        Self::ThrusterSought,
        Self::BoxPulses,
        Self::ThrusterPulses,
    ];

    fn has_thrusters(self) -> bool {
        matches!(self, Self::Thrusters | Self::ThrusterSought | Self::ThrusterPulses)
    }

    fn seeks_duration(self) -> bool {
        matches!(self, Self::BoxSought | Self::ThrusterSought)
    }

    fn pulses(self) -> bool {
        matches!(self, Self::BoxPulses | Self::ThrusterPulses)
    }

    pub(super) fn name(self) -> &'static str {
        match self {
            Self::Box => "box",
            Self::Thrusters => "thrusters",
            Self::Norm => "norm",
            Self::BoxSought => "box-sought",
            Self::ThrusterSought => "thruster-sought",
            Self::BoxPulses => "box-pulses",
            Self::ThrusterPulses => "thruster-pulses",
        }
    }
}

pub fn run(words: &mut Words) -> Result<(), Box<dyn Error>> {
    let count: usize = words.number("number of cases", 1000)?;
    let only = words.one_of("family", &Family::ALL.map(Family::name))?;
    let alone = words.one_of("word", &["alone"])?.is_some();
    words.end()?;
    for family in Family::ALL {
        if only.as_ref().is_some_and(|only| only != family.name()) {
            continue;
        }
        let mut random = Random::new(2026);
        if family.pulses() {
            pulses(&mut random, family, count)?;
            continue;
        }
        let mut tally = Tally { alone, ..Tally::default() };
        for index in 0..count {
            let Some((mut problem, duration)) = case(&mut random, family, index % 2 == 1)? else {
                tally.cases += 1;
                println!("  case {index}: no shortest duration was found");
                continue;
            };
            if family.seeks_duration() {
                problem = sought(&mut random, problem, (index % 4 == 3).then_some(duration));
            }
            tally.take(index, &problem)?;
        }
        tally.report(family.name());
    }
    Ok(())
}

fn direction(random: &mut Random) -> Vector3 {
    // Draws a point uniform in the ball.
    loop {
        let vector = Vector3::from_fn(|_, _| random.uniform());
        if (0.01..1.0).contains(&vector.norm()) {
            return vector.normalize();
        }
    }
}

/// Draws a maneuver and its duration \[s\]; `None` if no shortest duration is found.
fn case(random: &mut Random, family: Family, moving: bool) -> Result<Option<(Problem, f64)>, Box<dyn Error>> {
    let frame = lie::exp(&(direction(random) * random.within(0.0, PI)));
    let (a, b) = (random.within(1.0, 10.0), random.within(1.0, 10.0));
    let c = random.within((a - b).abs().max(1.0), (a + b).min(10.0));
    let inertia = frame * Matrix3::from_diagonal(&Vector3::new(a, b, c)) * frame.transpose();
    let body = Body { inertia: Inertia::new(0.5 * (inertia + inertia.transpose()))?, mass: None };
    let turn = direction(random) * random.within(0.1, PI);
    let unit = (a * b * c).powf(1.0 / 6.0);
    let mut rate =
        || if moving { direction(random) * (0.3 * random.unit() / unit) } else { Vector3::zeros() };
    let (start, end) =
        (State::attitude(Matrix3::identity(), rate()), State::attitude(lie::exp(&turn), rate()));
    let axes: Vec<Vector3> = if family.has_thrusters() {
        let sign = |bit: bool| if bit { 1.0 } else { -1.0 };
        let octant = |k: u32| Vector3::new(sign(k & 1 > 0), sign(k & 2 > 0), sign(k & 4 > 0));
        let cant = |k: u32, random: &mut Random| {
            octant(k).component_mul(&Vector3::from_fn(|_, _| random.within(0.3, 1.0))).normalize()
        };
        (0..8).map(|k| cant(k, random)).collect()
    } else {
        vec![Vector3::x(), Vector3::y(), Vector3::z()]
    };
    let mut limit = || random.within(1.0, 5.0);
    let limits = match family {
        Family::Norm => Limits { norm: Some(limit()), ..Limits::default() },
        _ => Limits {
            size: Some(axes.iter().map(|_| limit()).collect()),
            one_sided: family.has_thrusters(),
            ..Limits::default()
        },
    };
    let torques = ActuatorSet::new(axes, AxisFrame::Body)?.with_limits(limits)?;
    let fastest = Problem::minimum_time(body, start, end).with_actuation(Actuation::torques(torques));
    let shortest = plan(&fastest, &Settings::default(), None, &mut Silent)?.solution.duration(&fastest);
    let duration = shortest * random.within(1.3, 4.0);
    let problem = fastest.with_objective(Objective::Fuel(Fuel::default())).with_duration(duration);
    Ok(duration.is_finite().then_some((problem, duration)))
}

/// Returns the maneuver with a free duration, which is bounded by `longest` \[s\] if given, or has
/// a price.
fn sought(random: &mut Random, problem: Problem, longest: Option<f64>) -> Problem {
    let price = 0.02 * 25.0_f64.powf(random.unit());
    if let Some(longest) = longest {
        return problem.with_duration_at_most(longest);
    }
    let sum: f64 = problem.actuation.torque.limits().size.iter().flatten().sum();
    let fuel = Fuel { time_price: Some(price * sum), ..Fuel::default() };
    problem.with_duration(Duration::SOUGHT).with_objective(Objective::Fuel(fuel))
}

/// Returns the maneuver with the minimum pulse width `shortest` \[s\].
fn pulsed(problem: &Problem, shortest: f64) -> Result<Problem, Box<dyn Error>> {
    let torque = problem.actuation.torque.clone();
    let limits = Limits { shortest_pulse: Some(shortest), ..torque.limits().clone() };
    Ok(problem.clone().with_actuation(Actuation::torques(torque.with_limits(limits)?)))
}

/// Draws the next maneuver of a family with a minimum pulse width; `None` if no shortest duration
/// is found.
pub(super) fn pulses_case(
    random: &mut Random,
    family: Family,
    moving: bool,
) -> Result<Option<Problem>, Box<dyn Error>> {
    let case = case(random, family, moving)?;
    let part = 0.01 * 10.0_f64.powf(random.within(0.0, 1.0));
    case.map(|(problem, duration)| pulsed(&problem, part * duration)).transpose()
}

/// Prints how many maneuvers with a minimum pulse width are solved and verified, their additional
/// cost, and their time.
fn pulses(random: &mut Random, family: Family, count: usize) -> Result<(), Box<dyn Error>> {
    let (mut solved, mut matched, mut above, mut dearer) = (0, 0, Vec::new(), Vec::new());
    let (mut solve_ms, mut pulses) = (Vec::new(), Vec::new());
    for index in 0..count {
        let Some(problem) = pulses_case(random, family, index % 2 == 1)? else {
            println!("  case {index}: no shortest duration was found");
            continue;
        };
        let found = plan(&problem, &Settings::default(), None, &mut Silent)?;
        let thorough = Settings { search: Thoroughness::Thorough, ..Settings::default() };
        let best = if index < COMPARED { cost(&plan(&problem, &thorough, None, &mut Silent)?) } else { None };
        let switching = found.solution.switching.as_ref();
        match switching.and_then(|switching| switching.pulses.as_ref()).zip(cost(&found)) {
            Some((told, cost)) => {
                solved += 1;
                dearer.push(100.0 * (cost / told.cost_without - 1.0));
                pulses.push(told.count as f64);
                if let Some(best) = best {
                    let excess = cost / best - 1.0;
                    matched += usize::from(excess <= SMALL);
                    above.push(100.0 * excess);
                }
            }
            None => {
                println!("  case {index}: {}, {:?}", found.status.name(), found.solution.shortfall);
            }
        }
        solve_ms.push(found.solution.solve_time * 1e3);
    }
    let share = 100.0 * f64::from(solved) / count.max(1) as f64;
    println!("{}: {solved} of {count} solved and verified ({share:.1} %)", family.name());
    println!(
        "  the thorough search, of the first {}, finds nothing better by 1e-4 in {matched}",
        above.len()
    );
    for (what, figures) in [
        ("% above the thorough search", &mut above),
        ("% dearer than without a shortest pulse", &mut dearer),
        ("pulses", &mut pulses),
        ("ms", &mut solve_ms),
    ] {
        figures.sort_by(f64::total_cmp);
        let last = figures.len().saturating_sub(1);
        let at = |part: f64| figures.get((part * last as f64) as usize).copied().unwrap_or(f64::NAN);
        let [middle, most, all] = [0.5, 0.9, 1.0].map(at);
        println!("  {what}: median {middle:.2}, 90 % {most:.2}, at most {all:.2}");
    }
    Ok(())
}

#[derive(Default)]
struct Tally {
    /// True if the thorough search is omitted.
    alone: bool,
    cases: usize,
    solved: usize,
    exact: usize,
    small: usize,
    matched: usize,
    dearer: f64,
    solve_ms: Vec<f64>,
    whole_ms: Vec<f64>,
}

/// Returns the cost of the continuous extremal; `None` without one.
fn cost(plan: &Plan) -> Option<f64> {
    let solved = plan.status == Status::Solved;
    plan.solution.switching.as_ref().filter(|_| solved).map(|switching| switching.continuous_cost)
}

impl Tally {
    fn take(&mut self, index: usize, problem: &Problem) -> Result<(), Box<dyn Error>> {
        self.cases += 1;
        let began = Instant::now();
        let found = plan(problem, &Settings::default(), None, &mut Silent)?;
        self.whole_ms.push(began.elapsed().as_secs_f64() * 1e3);
        self.solve_ms.push(found.solution.solve_time * 1e3);
        let thorough = Settings { search: Thoroughness::Thorough, ..Settings::default() };
        let best = if self.alone { None } else { cost(&plan(problem, &thorough, None, &mut Silent)?) };
        let Some((own, switching)) = cost(&found).zip(found.solution.switching.as_ref()) else {
            println!("  case {index}: {}, {:?}", found.status.name(), found.solution.shortfall);
            return Ok(());
        };
        self.solved += 1;
        self.exact += usize::from(switching.structure == Structure::BangOffBang);
        self.small += usize::from(switching.gap <= SMALL * own);
        let excess = best.map_or(0.0, |best| own / best - 1.0);
        self.matched += usize::from(excess <= SMALL);
        self.dearer = self.dearer.max(excess);
        Ok(())
    }

    fn report(mut self, family: &str) {
        let share = |count: usize| 100.0 * count as f64 / self.cases.max(1) as f64;
        println!(
            "{family}: {} of {} solved and verified ({:.1} %)",
            self.solved,
            self.cases,
            share(self.solved)
        );
        println!(
            "  exact {:.1} %, gap at most 1e-4 of the cost {:.1} %",
            share(self.exact),
            share(self.small)
        );
        if !self.alone {
            println!(
                "  the thorough search finds nothing better by 1e-4 {:.1} %, at most by {:.1e}",
                share(self.matched),
                self.dearer
            );
        }
        for (what, times) in [("solve", &mut self.solve_ms), ("with witnesses", &mut self.whole_ms)] {
            times.sort_by(f64::total_cmp);
            let at = |part: f64| times.get((part * times.len() as f64) as usize).copied().unwrap_or(f64::NAN);
            println!("  {what}: median {:.1} ms, 90 % {:.1} ms, 99 % {:.1} ms", at(0.5), at(0.9), at(0.99));
        }
    }
}
