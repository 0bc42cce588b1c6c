//! Checks whether minimum-time and minimum-fuel plans within limits depend on the grid, for 50,
//! 100, 200, 400 and 800 steps.
//!
//! `cargo run --release -p evidence -- grids [COUNT [KIND [FIRST]]]`, 75 of each kind by
//! default (`all`), each grid planned afresh. The law is printed before the figures.
//!
//! On a uniform grid of `N` steps the cost differs from that in continuous time by `O(1/N²)`,
//! because inputs jump at nodes and limits hold there. A plan depends on its grid if its cost
//! exceeds the cost on another grid by more than the errors of both grids. The command prints one
//! line for each such maneuver, and for each maneuver that is not solved on every grid, with all
//! costs, times, and a cheaper rival of the plan. The summary counts them, and states the median
//! error of each grid relative to the finest grid, from which the constants of this rule were
//! chosen. Times are CPU times.

use evidence::process::own_cpu_seconds;
use evidence::words::{Misuse, Words};
use evidence::{Random, median};
use slewkit::maneuver::{Constraint, Direction, Pointing, Problem, Rule, Settings, Side, State};
use slewkit::mechanics::{Actuation, ActuatorSet, AxisFrame, Body, Inertia, Limits, Wheels};
use slewkit::plan::{Control, Observer, Progress, Status, plan};
use slewkit::{Matrix3, Vector3, lie};
use std::error::Error;

const LAW: &str = "\
law: moments in a ratio up to 5 that bodies have, along the axes of three torques; their limits 0.4
     to 1.6; start of a uniform attitude, rotation by 30 to 180 deg about a uniform axis, from rest
     to rest. cones: one to three keep-out cones of 10 to 30 deg that hold neither end, the first on
     the way of the turn about its axis, the others near it in one of two; rates: in turns a limit
     of each rate and of their norm, 0.3 to 0.9 of what that turn takes; torque-rates: from off to
     the limit in 3 to 30 % of its duration; wheels: limits of their momenta 0.4 to 1 of what it
     takes, the start 0 to 10 % of these in one of two. Least time, and least fuel in 1.5 to 4 times
     the duration of that turn within its limits. Each plan has 300 s of processor time.";

const GRIDS: [usize; 5] = [50, 100, 200, 400, 800];

/// The accepted relative error of the cost on N steps is the first number plus the square of the
/// second number over N.
const ERROR: (f64, f64) = (5e-4, 4.0);

/// The limit on the CPU time of a plan \[s\].
const LONGEST: f64 = 300.0;

/// An observer that stops a plan after `LONGEST`.
struct Patience {
    began: f64,
}

impl Observer for Patience {
    fn on_progress(&mut self, progress: &Progress) -> Control {
        let over = progress.elapsed > LONGEST && own_cpu_seconds() - self.began > LONGEST;
        if over { Control::Stop } else { Control::Continue }
    }
}

#[derive(Clone, Copy, PartialEq)]
pub(super) enum Limited {
    Cones,
    Rates,
    TorqueRates,
    Wheels,
}

pub(super) const KINDS: [(&str, Limited, bool); 8] = [
    ("time-cones", Limited::Cones, false),
    ("time-rates", Limited::Rates, false),
    ("time-torque-rates", Limited::TorqueRates, false),
    ("time-wheels", Limited::Wheels, false),
    ("fuel-cones", Limited::Cones, true),
    ("fuel-rates", Limited::Rates, true),
    ("fuel-torque-rates", Limited::TorqueRates, true),
    ("fuel-wheels", Limited::Wheels, true),
];

/// The results of one maneuver on all grids.
struct Compared {
    index: usize,
    costs: [Option<f64>; GRIDS.len()],
    /// The cost of the cheapest rival on each grid.
    rivals: [f64; GRIDS.len()],
    seconds: [f64; GRIDS.len()],
}

impl Compared {
    /// Returns the largest relative excess of one grid's cost over another's, minus the errors of
    /// both grids; 0 if none exceeds them.
    fn beyond(&self) -> f64 {
        let error = |steps: usize| ERROR.0 + (ERROR.1 / steps as f64).powi(2);
        let solved =
            || self.costs.iter().zip(GRIDS).filter_map(|(cost, steps)| Some(((*cost)?, error(steps))));
        let pairs = solved().flat_map(|a| solved().map(move |b| a.0 / b.0 - 1.0 - a.1 - b.1));
        pairs.fold(0.0, f64::max)
    }

    fn is_solved(&self) -> bool {
        self.costs.iter().all(Option::is_some)
    }

    fn told(&self, name: &str) -> String {
        let cost = |grid: usize| match self.costs[grid] {
            Some(cost) => {
                let known = self.rivals[grid];
                let known = if known < 0.999 * cost { format!("rival {known:.6}, ") } else { String::new() };
                format!("{cost:.6} ({known}{:.1} s)", self.seconds[grid])
            }
            None => format!("none ({:.1} s)", self.seconds[grid]),
        };
        let costs: Vec<String> = (0..GRIDS.len()).map(cost).collect();
        let mark = match self.beyond() {
            beyond if beyond > 0.0 => format!("  <- {:.2} %", 100.0 * beyond),
            _ => String::new(),
        };
        format!("  {name} {}: {}{mark}", self.index, costs.join(", "))
    }
}

pub fn run(words: &mut Words) -> Result<(), Box<dyn Error>> {
    let count: usize = words.number("number of cases", 75)?;
    let asked = words.take().filter(|word| word != "all");
    let first: usize = words.number("number of the first case", 0)?;
    words.end()?;
    let kinds = KINDS.map(|(name, ..)| name);
    if let Some(unknown) =
        asked.as_ref().filter(|asked| !kinds.iter().any(|name| name.contains(asked.as_str())))
    {
        return Err(Misuse::of("part of the name of a kind", unknown, &kinds).into());
    }
    println!("{LAW}");
    println!("error: {} + ({}/N)^2, of costs on {GRIDS:?} steps", ERROR.0, ERROR.1);
    let mut every = Vec::new();
    for (name, limited, fuel) in KINDS
        .into_iter()
        .filter(|(name, ..)| asked.as_ref().is_none_or(|asked| name.contains(asked.as_str())))
    {
        let mut all = Vec::new();
        for index in first..first + count {
            let Some(problem) = maneuver(limited, fuel, index) else { continue };
            let compared = compared(index, &problem);
            if !compared.is_solved() || compared.beyond() > 0.0 {
                println!("{}", compared.told(name));
            }
            all.push(compared);
        }
        summary(name, &all);
        every.append(&mut all);
    }
    summary("all", &every);
    Ok(())
}

fn summary(name: &str, all: &[Compared]) {
    let median_of = |values: &mut dyn Iterator<Item = f64>| median(&mut values.collect::<Vec<f64>>());
    let apart = all.iter().filter(|one| one.beyond() > 0.0).count();
    let worst = all.iter().map(Compared::beyond).fold(0.0, f64::max);
    let unsolved: usize = all.iter().map(|one| one.costs.iter().filter(|cost| cost.is_none()).count()).sum();
    let error = |grid: usize| {
        let beside = |one: &Compared| Some((one.costs[grid]? / one.costs[GRIDS.len() - 1]? - 1.0).abs());
        format!("{:.1e}", median_of(&mut all.iter().filter_map(beside)))
    };
    let errors: Vec<String> = (0..GRIDS.len() - 1).map(error).collect();
    let [on_100, on_800] = [1, GRIDS.len() - 1].map(|grid| move |one: &Compared| one.seconds[grid]);
    let total = |of: &dyn Fn(&Compared) -> f64| all.iter().map(of).sum::<f64>();
    let ratio = median_of(&mut all.iter().map(|one| on_800(one) / on_100(one)));
    println!(
        "{name:<18} {:>4} maneuvers: on another grid cheaper {apart}, worst {:.2} %; grids without a plan {unsolved}; \
         median error {}; median {:.2} s on 800 steps, ratio to 100 steps median {ratio:.1}, of sums {:.1}",
        all.len(),
        100.0 * worst,
        errors.join(" "),
        median_of(&mut all.iter().map(on_800)),
        total(&on_800) / total(&on_100),
    );
}

fn compared(index: usize, problem: &Problem) -> Compared {
    let settings = Settings::discrete();
    let mut seconds = [0.0; GRIDS.len()];
    let mut rivals = [f64::INFINITY; GRIDS.len()];
    let mut costs = [None; GRIDS.len()];
    for (grid, steps) in GRIDS.into_iter().enumerate() {
        let began = own_cpu_seconds();
        let found = plan(&problem.clone().with_steps(steps), &settings, None, &mut Patience { began }).ok();
        seconds[grid] = own_cpu_seconds() - began;
        let Some(found) = found.filter(|found| found.status == Status::Solved) else { continue };
        let solution = found.solution;
        costs[grid] = Some(solution.cost);
        rivals[grid] = solution.rivals.iter().map(|rival| rival.cost).fold(f64::INFINITY, f64::min);
    }
    Compared { index, costs, rivals, seconds }
}

/// Returns the maneuver of this index and kind; `None` if it cannot be built.
pub(super) fn maneuver(limited: Limited, fuel: bool, index: usize) -> Option<Problem> {
    let mut random = Random::of_case(0x6a1d_5000 + limited as u64 + 16 * u64::from(fuel), index);
    let moments = random.mean_moments(5.0);
    let body = Body { inertia: Inertia::diagonal(moments).ok()?, mass: None };
    let sizes = Vector3::from_fn(|_, _| random.within(0.4, 1.6));
    let start = random.uniform_rotation();
    let (axis, angle) = (random.direction(), random.within(30.0, 180.0).to_radians());
    let turn = axis * angle;
    let end = start * lie::exp(&turn);
    // The angular acceleration of the turn about its axis that every torque allows. The torques
    // that hold the axis are ignored.
    let momentum = moments.component_mul(&axis);
    let acceleration = sizes.component_div(&momentum.abs()).min();
    let (mut lasts, peak) = (2.0 * (angle / acceleration).sqrt(), (angle * acceleration).sqrt());
    let slower = |share: f64| 0.5 * (share + 1.0 / share);
    let mut limits = Limits { size: Some(sizes.iter().copied().collect()), ..Limits::default() };
    let (mut constraints, mut wheels) = (Vec::new(), None);
    match limited {
        Limited::Cones => {
            for number in 0..1 + random.below(3) {
                let rule = Rule::Pointing(cone(&start, &turn, number, &mut random));
                constraints.push(Constraint { name: format!("cone {number}"), rule });
            }
        }
        Limited::Rates => {
            let share = random.within(0.3, 0.9);
            let rates = axis.map(|part| share * peak * part.abs());
            let rule = if random.coin() { Rule::RateAxes(rates) } else { Rule::RateNorm(share * peak) };
            constraints.push(Constraint { name: "rate".into(), rule });
            lasts *= slower(share);
        }
        Limited::TorqueRates => {
            let ramp = random.within(0.03, 0.3) * lasts;
            limits.rate = Some(sizes.iter().map(|size| size / ramp).collect());
            lasts += ramp;
        }
        Limited::Wheels => {
            let share = random.within(0.4, 1.0);
            let most = share * peak * momentum.map(f64::abs).max();
            let stored = if random.coin() { 0.1 } else { 0.0 };
            let momentum = (0..3).map(|_| stored * most * random.uniform()).collect();
            wheels = Some(Wheels { momentum, momentum_limit: vec![most; 3] });
            lasts *= slower(share);
        }
    }
    let torque = ActuatorSet::three_axes(AxisFrame::Body).with_limits(limits).ok()?;
    let (start, end) = (State::at_rest(start), State::at_rest(end));
    let problem = if fuel {
        Problem::minimum_fuel(body, start, end, random.within(1.5, 4.0) * lasts)
    } else {
        Problem::minimum_time(body, start, end)
    };
    let problem = problem.with_actuation(Actuation { wheels, ..Actuation::torques(torque) });
    Some(constraints.into_iter().fold(problem, Problem::with_constraint))
}

/// Draws a cone on the path of the turn or near it that contains neither end.
fn cone(start: &Matrix3, turn: &Vector3, number: usize, random: &mut Random) -> Pointing {
    let beside = number > 0 && random.coin();
    loop {
        let boresight = random.direction();
        let half_angle = random.within(10.0, 30.0).to_radians();
        let at = |part: f64| start * lie::exp(&(turn * part)) * boresight;
        let passed = at(random.within(0.3, 0.7));
        let direction = if beside { random.direction() } else { passed + 0.3 * random.vector() }.normalize();
        if [0.0, 1.0].iter().all(|end| at(*end).angle(&direction) > half_angle + 0.02) {
            return Pointing::new(
                Side::KeepOut,
                vec![boresight],
                vec![Direction::Fixed(direction)],
                half_angle,
            );
        }
    }
}
