//! One search for free, limited and constrained maneuvers: the ladder, and the comparison of what it finds.
//!
//! Every rung improves candidates, most of them on a coarse grid; what it finds is carried to the requested
//! grid. Cheap rungs that nearly always work come first.

use super::coarse::{
    FEW_STEPS, FEWEST_FROM_REST, SHOOTING_FREE, SHOOTING_FROM_REST, SHOOTING_ONE_WAY, SHOOTING_UNEVEN,
    coarse_steps,
};
use super::context::Context;
use super::guess::Guess;
use super::record::{self, Recorded};
use super::starts;
use super::way::{Follower, Way};
use crate::Vector3;
use crate::lie;
use crate::maneuver::problem::{Motion, Path, Problem, Scheme};
use crate::maneuver::settings::Method as Road;
use crate::maneuver::solution::{ConvexWork, Optimality, Outcome, Rival, Rung, Sense, Solution, Trajectory};
use crate::numerics::factor::effective;
use crate::numerics::figures::{short, significant};
use crate::numerics::parallel;
use crate::optimize::candidate::Candidate;
use crate::optimize::methods::driver::Report;
use crate::optimize::methods::method::{Attempt, Method, Run, Watch};
use crate::optimize::methods::scp::model::{Goal, Model};
use crate::optimize::methods::scp::road::{body_rates, iterate, multipliers};
use crate::optimize::methods::scp::{ScpOptions, second_order::descents};
use crate::optimize::methods::shooting::Shooting;
use crate::optimize::methods::shooting::newton::outcome_of;
use crate::optimize::methods::shooting::refine::{CoarseToFine, polish};
use crate::optimize::second_order;
use crate::optimize::step::StepError;
use crate::optimize::sweep::BoundaryValueProblem;
use nalgebra::SVector;
use std::f64::consts::{PI, TAU};

/// Two extremals whose costates differ by less, relative, are one.
const SAME: f64 = 1e-6;
/// Steps from which a second thread takes less time than waking it.
const WORTH_A_THREAD: usize = 400;
/// Costs of one optimum of SCP differ by less, relative.
const SAME_COST: f64 = 1e-9;

/// An extremal of one grid that ends so near its target on another \[rad\] goes the same way there.
const NEAR: f64 = 0.2;

/// How much farther from a rotation that is given all paths of the other class are than those of its own: more turns than a
/// path has.
const OTHER_CLASS: f64 = 1e6;

/// What a search may do, and what it begins from.
#[derive(Clone)]
pub(super) struct Ask<'a> {
    /// Whether the shooting may be tried.
    pub shooting: bool,
    /// Whether SCP may be.
    pub convex: bool,
    pub guess: Option<&'a Guess>,
    /// A trajectory on the requested grid that SCP follows, instead of all other paths.
    pub along: Option<&'a Trajectory>,
    /// How SCP ends on the requested grid.
    pub last: ScpOptions,
    /// Whether a maneuver for which no plan is found is told the duration for which there is one.
    pub advise: bool,
    /// What SCP minimises in place of the effort (`cheapest`).
    pub goal: Option<Goal>,
}

impl Ask<'_> {
    /// What is asked of the same maneuver without limits.
    pub fn of_relaxed(&self) -> Self {
        Self { shooting: true, convex: false, guess: None, along: None, goal: None, ..self.clone() }
    }
}

/// A search: what is asked, and what has been found so far.
pub(super) struct Search<'a, 'c, const N: usize> {
    pub problem: &'a Problem,
    pub context: &'a Context<'c>,
    pub ask: Ask<'a>,
    /// Turns to try, in order.
    pub turns: Vec<i32>,
    /// On the requested grid.
    pub fine: BoundaryValueProblem<'a, N>,
    /// Where the shooting searches.
    pub coarse: BoundaryValueProblem<'a, N>,
    /// Extremals of the coarse grid that wait for the requested one.
    pub pool: Vec<Attempt>,
    /// Extremals of the coarse grid that are too dear for the requested one.
    pub rivals: Vec<Attempt>,
    /// Minima, or extremals as paths, that no extremal of the requested grid was found near.
    pub lost: Vec<Attempt>,
    /// Whether descents have been tried.
    pub descended: bool,
    /// What converged.
    pub found: Vec<Attempt>,
    /// The nearest miss.
    pub failure: Option<Attempt>,
    /// Extremals already met on the coarse grid.
    met: Vec<SVector<f64, N>>,
    /// Starts that have led to an extremal, new or known.
    pub arrived: Vec<String>,
    /// What the convex subproblems of all seeds took.
    pub work: ConvexWork,
    /// The whole answer, where a rung has it: that of the maneuver without limits, which meets them all.
    pub answer: Option<Solution>,
    /// What is lacking, in words, where no plan was found.
    pub shortfall: Option<String>,
    /// The shortest duration that was found \[s\], where none was for the one asked for.
    pub shortest: Option<f64>,
}

/// A step of the ladder: a rung, or several that belong together.
struct Step<'a, 'c, const N: usize> {
    when: fn(&mut Search<'a, 'c, N>) -> bool,
    climb: fn(&mut Search<'a, 'c, N>),
}

impl<'a, 'c, const N: usize> Search<'a, 'c, N> {
    /// The ladder. Guess, saturated and limits work on the requested grid, the others on a coarse one first.
    const LADDER: [Step<'a, 'c, N>; 4] = [
        // guess
        Step { when: |search| search.ask.shooting, climb: Self::try_guess },
        // newton, descent and lifted
        Step { when: Self::is_free, climb: Self::extremals },
        // saturated, lifted and limits
        Step { when: Self::is_limited, climb: Self::saturated },
        // scp and polish
        Step { when: Self::needs_scp, climb: Self::scp },
    ];

    pub fn new(problem: &'a Problem, context: &'a Context<'c>, ask: Ask<'a>) -> Self {
        let turns = wanted_turns(problem);
        let most = turns.iter().copied().max_by_key(|turns| turns.abs()).unwrap_or(0);
        let fine = BoundaryValueProblem::new(problem, problem.steps);
        let coarse = fine.on_steps(search_grid(problem, most, fine.dynamics.is_even()));
        Self {
            problem,
            context,
            ask,
            turns,
            fine: fine.heard_by(context),
            coarse: coarse.heard_by(context),
            pool: Vec::new(),
            rivals: Vec::new(),
            lost: Vec::new(),
            descended: false,
            found: Vec::new(),
            failure: None,
            met: Vec::new(),
            arrived: Vec::new(),
            work: ConvexWork::default(),
            answer: None,
            shortfall: None,
            shortest: None,
        }
    }

    /// Climbs the ladder, and writes the solution with all that was tried.
    pub fn solve(mut self) -> Solution {
        let solution = self.climb_far();
        let mut solution = self.held_to_its_way(solution);
        if solution.method == Road::Scp {
            if self.ask.shooting {
                solution = self.confirm(solution);
            }
            if self.ask.last.polish {
                solution = held_to(self.context.settings.tolerance, solution);
            }
            if self.ask.advise {
                self.advise(&mut solution);
            }
        }
        Solution { ladder: self.context.ladder.take(), ..solution }
    }

    /// Whether a solution goes the way that was asked for, and no cheaper one is near it. A rotation that is given
    /// is taken as written: that may be a saddle. So may be what is not to be tested.
    pub fn satisfies(&self, solution: &Solution) -> bool {
        let untested = !self.context.settings.test_second_order;
        let minimal = untested || solution.optimality.conjugate_points == Some(0);
        let given = matches!(self.problem.path, Path::AsGiven(_));
        solution.outcome == Outcome::Converged && (minimal || given) && self.goes_as_asked(solution)
    }

    fn goes_as_asked(&self, solution: &Solution) -> bool {
        self.asked_sense().is_none_or(|sense| sense == solution.sense)
    }

    /// The sense that was asked for.
    pub(super) fn asked_sense(&self) -> Option<Sense> {
        match self.problem.path {
            Path::Best => None,
            Path::Shortest => Some(Sense::Short),
            Path::Long => Some(Sense::Long),
            Path::AsGiven(rotation) => {
                let mut path = Follower::new();
                let parts = (rotation.norm() / 0.1).ceil().max(1.0);
                for part in 0..=parts as usize {
                    let turned = lie::exp(&(rotation * (part as f64 / parts)));
                    path.node(&(self.problem.start.attitude * turned), Vector3::zeros(), 0.0);
                }
                path.way(&self.coarse).ok().map(|way| way.sense)
            }
        }
    }

    /// A solution that counts as converged only if it goes the way round that was asked for.
    fn held_to_its_way(&self, mut solution: Solution) -> Solution {
        if solution.outcome == Outcome::Converged && !self.goes_as_asked(&solution) {
            let way = if solution.sense == Sense::Short { "short" } else { "long" };
            let turned = solution.turned_deg;
            solution.outcome = Outcome::Stalled;
            solution.shortfall = Some(format!(
                "no optimum that goes round as asked was found; the nearest goes the {way} way and turns by \
                 {turned:.1}°"
            ));
        }
        solution
    }

    /// A solution that counts as converged only where it goes the way that was asked for, and ends where it should.
    pub fn held_to_all(&self, solution: Solution) -> Solution {
        held_to(self.context.settings.tolerance, self.held_to_its_way(solution))
    }

    /// Newton from the guess alone, on the requested grid, with no ladder behind it.
    pub fn polish(mut self) -> Solution {
        self.try_guess();
        Solution { ladder: self.context.ladder.take(), ..self.conclude() }
    }

    /// Climbs the ladder, and without limits looks further where that leads to a saddle or another way round.
    pub fn climb_far(&mut self) -> Solution {
        self.climb();
        let solution = self.conclude();
        if self.is_free() && !self.stopped() && !self.satisfies(&solution) {
            return self.look_further(solution);
        }
        solution
    }

    /// Climbs the ladder.
    fn climb(&mut self) {
        for Step { when, climb } in Self::LADDER {
            if when(self) {
                climb(self);
            }
        }
    }

    pub fn stopped(&self) -> bool {
        self.context.interrupt().is_some()
    }

    /// Whether a costate that was given has led to a plan: then nothing else is tried.
    fn is_guessed(&self) -> bool {
        self.found.first().is_some_and(|found| found.candidate.provenance.start == starts::GUESS)
    }

    /// Whether the shooting is to find its own starts, without limits.
    fn is_free(&mut self) -> bool {
        self.ask.shooting && !self.is_guessed() && !self.fine.dynamics.is_limited()
    }

    /// Whether it is to find them within limits.
    fn is_limited(&mut self) -> bool {
        self.ask.shooting && !self.is_guessed() && self.fine.dynamics.is_limited()
    }

    /// Whether SCP is the road, or the last resort.
    fn needs_scp(&mut self) -> bool {
        let rescue = self.ask.shooting && (!self.found.is_empty() || self.stopped());
        self.ask.convex && !rescue
    }

    /// Has a method improve a candidate, and notes how that went.
    pub fn attempt(&self, rung: Rung, method: &impl Method, candidate: Candidate) -> Attempt {
        self.noted(rung, self.tried(rung, method, candidate))
    }

    /// Has a method improve a candidate.
    pub fn tried(&self, rung: Rung, method: &impl Method, candidate: Candidate) -> Attempt {
        self.context.enter(rung, &candidate.provenance.start, candidate.steps());
        self.context.within(|budget| method.improve(candidate, budget))
    }

    /// Notes how a try went.
    pub fn noted(&self, rung: Rung, mut attempt: Attempt) -> Attempt {
        let Attempt { candidate, work, runs, .. } = &mut attempt;
        for Run { rung: own, steps, report } in runs {
            candidate.provenance.iterations += report.iterations;
            let start = &candidate.provenance.start;
            self.context.note(own.unwrap_or(rung), start, *steps, report.clone());
        }
        candidate.provenance.subproblems += work.subproblems;
        attempt
    }

    /// Newton shooting on the coarse grid from one start. The cost of the extremal that it led to, new or known.
    pub fn shoot(&mut self, rung: Rung, start: Candidate) -> Option<f64> {
        let polish = polish(self.problem, self.coarse.dynamics.grid.steps());
        let attempt = self.attempt(rung, &Shooting::on_coarse_grid(&self.coarse, true, polish), start);
        if !attempt.converged() {
            return None;
        }
        let (cost, coarse) = (attempt.cost, &attempt.candidate);
        self.arrived.push(coarse.provenance.start.clone());
        let costate = coarse.costate::<N>();
        // Under a symmetry costates of one extremal differ by what has no effect: leave that out.
        let effective = coarse.sensitivity().map_or(costate, |psi| effective(&psi, &costate));
        let scale = effective.amax().max(1.0);
        if !self.met.iter().any(|met| (met - effective).amax() < SAME * scale) {
            self.met.push(effective);
            self.pool.push(attempt);
        }
        Some(cost)
    }

    /// Newton shooting on the requested grid. The cost of the extremal that it led to.
    pub fn shoot_fine(&mut self, rung: Rung, start: Candidate) -> Option<f64> {
        let shooting = Shooting::new(&self.fine, self.context.settings.tolerance);
        let attempt = self.attempt(rung, &shooting, start.on_grid(&self.fine.dynamics.grid));
        let cost = attempt.cost;
        self.keep(attempt).then_some(cost)
    }

    /// Carries a coarse extremal to the requested grid, and keeps what this leads to. Whether that is near it.
    pub fn finish(&mut self, coarse: Candidate, near: impl FnOnce(&Attempt) -> bool) -> bool {
        let (problem, tolerance) = (self.problem, self.context.settings.tolerance);
        let refinement = CoarseToFine { problem, fine: &self.fine, tolerance };
        let attempt = self.attempt(Rung::CoarseToFine, &refinement, coarse);
        let near = near(&attempt);
        self.keep(attempt) && near
    }

    /// Keeps what converged, once, or else the nearest miss. Whether it converged.
    pub fn keep(&mut self, attempt: Attempt) -> bool {
        self.add_work(&attempt);
        let converged = attempt.converged();
        if converged {
            if !self.found.iter().any(|other| same::<N>(other, &attempt)) {
                self.found.push(attempt);
            }
        } else if attempt.began()
            && self.failure.as_ref().is_none_or(|failure| attempt.residual < failure.residual)
        {
            self.failure = Some(attempt);
        }
        converged
    }

    /// Adds what an attempt took.
    pub fn add_work(&mut self, attempt: &Attempt) {
        self.work.all_subproblems += attempt.work.all_subproblems;
        self.work.cone_iterations += attempt.work.cone_iterations;
        self.work.cone_seconds += attempt.work.cone_seconds;
    }

    /// Newton from a costate guess, on the requested grid.
    fn try_guess(&mut self) {
        if let Some(guess) = self.ask.guess.filter(|guess| !guess.costates.is_empty()) {
            self.shoot_from(&guess.costates, starts::GUESS);
        }
    }

    /// Newton on the requested grid from costates as a solution gives them: SI units, `λ_0` for Lie–Euler,
    /// `λ_{−1}` for Lie–Verlet.
    fn shoot_from(&mut self, costates: &[f64], start: &str) -> bool {
        let steps = self.problem.steps;
        match starts::given(self.problem, &self.fine, costates) {
            Ok(costate) => {
                let guess = Candidate::of_costate(start, &self.fine.dynamics.grid, &costate);
                self.shoot_fine(Rung::Guess, guess).is_some()
            }
            Err(outcome) => {
                self.context.note(Rung::Guess, start, steps, Report::failed(outcome));
                false
            }
        }
    }

    /// The grid that an extremal is told on: the coarse one, unless its costates lead elsewhere there.
    fn told_on(&self, candidate: &Candidate) -> &BoundaryValueProblem<'a, N> {
        let [coarse, fine] = [&self.coarse, &self.fine].map(|bvp| bvp.dynamics.grid.steps());
        let is_fine = candidate.steps() == fine && fine != coarse;
        let near = || {
            Follower::of(&self.coarse, &candidate.costate()).is_ok_and(|path| path.miss(&self.coarse) < NEAR)
        };
        if is_fine && !near() { &self.fine } else { &self.coarse }
    }

    /// How a candidate goes round.
    fn way(&self, candidate: &Candidate) -> Way {
        let way = match candidate.provenance.method {
            Road::Scp => {
                let mut path = Follower::new();
                let model = Model::new(self.problem, candidate.steps());
                for (attitude, rate) in body_rates(&model, candidate) {
                    path.node(&attitude, rate, model.h);
                }
                Ok(path.way_or_short(&self.fine))
            }
            _ => {
                let bvp = self.told_on(candidate);
                Follower::of(bvp, &candidate.costate()).map(|path| path.way_or_short(bvp))
            }
        };
        let (turned_deg, rotation) = (f64::NAN, Vector3::repeat(f64::NAN));
        way.unwrap_or(Way { sense: Sense::Short, turned_deg, rotation })
    }

    /// How far a path is from what was asked for: the wrong sense, or another rotation than the given.
    pub fn astray(&self, found: &Attempt) -> f64 {
        let way = || self.way(&found.candidate);
        match self.problem.path {
            Path::Best => 0.0,
            Path::Shortest => f64::from(u8::from(way().sense != Sense::Short)),
            Path::Long => f64::from(u8::from(way().sense != Sense::Long)),
            // In full turns, to a thousandth; a path of the other class is another way whatever it turns by.
            Path::AsGiven(rotation) => {
                let way = way();
                let other = self.asked_sense().is_some_and(|sense| sense != way.sense);
                f64::from(u8::from(other)) * OTHER_CLASS
                    + ((way.rotation - rotation).norm() / TAU * 1e3).round() / 1e3
            }
        }
    }

    /// The nearest to what was asked for first, of these the lowest cost.
    pub fn ranked(&self, found: Vec<Attempt>) -> Vec<Attempt> {
        let several = found.len() > 1;
        let mut keyed: Vec<(f64, Attempt)> =
            found.into_iter().map(|found| (if several { self.astray(&found) } else { 0.0 }, found)).collect();
        keyed.sort_by(|(a, x), (b, y)| a.total_cmp(b).then(x.cost.total_cmp(&y.cost)));
        keyed.into_iter().map(|(_, found)| found).collect()
    }

    /// Puts the winner first.
    pub fn rank(&mut self) {
        let found = std::mem::take(&mut self.found);
        self.found = self.ranked(found);
    }

    /// Chooses among what was found, and writes the solution.
    pub fn conclude(&mut self) -> Solution {
        let solve_time = self.context.began.elapsed().as_secs_f64();
        let mut solution = match self.answer.take() {
            Some(answer) => answer,
            None => self.chosen(),
        };
        solution.solve_time = solve_time;
        if let Some(stopped) = self.context.interrupt()
            && solution.outcome != Outcome::Converged
        {
            solution.outcome = stopped;
        }
        solution
    }

    /// The best of what was found, or the nearest miss, with its rivals.
    fn chosen(&mut self) -> Solution {
        let unsolved = Solution::unsolved(self.problem, self.context.settings.tolerance);
        // SCP has ranked what it found from its own seeds: its winner is on the requested grid, its rivals are not.
        let ranked = |found: &Attempt| found.candidate.provenance.method == Road::Scp;
        let elsewhere = |found: &Attempt| found.candidate.steps() != self.problem.steps;
        let own = !self.is_free() || self.found.iter().any(elsewhere);
        if !(own && self.found.iter().any(ranked)) {
            self.rank();
        }
        let rivals = self.found.iter().skip(1).chain(&self.rivals).map(|rival| self.rival(rival));
        // One that cannot be followed from its start is no plan.
        let rivals = rivals.filter(|rival| rival.turned_deg.is_finite() && rival.cost.is_finite()).collect();
        let shortfall = self.shortfall.clone();
        let method = if self.ask.shooting { Road::Shooting } else { Road::Scp };
        let mut solution = Solution { method, rivals, shortfall, ..unsolved };
        if let Some(chosen) = self.found.first().or(self.failure.as_ref()) {
            self.write(&mut solution, chosen);
        } else if self.context.ladder.borrow().iter().any(|rung| rung.outcome == Outcome::IterationLimit) {
            solution.outcome = Outcome::IterationLimit;
        }
        solution
    }

    /// What is told of another plan, with the cost that it has in the unit of the file.
    pub fn rival_of_cost(&self, rival: &Attempt, cost: f64) -> Rival {
        Rival { cost, ..self.rival(rival) }
    }

    fn rival(&self, rival: &Attempt) -> Rival {
        let candidate = &rival.candidate;
        let Way { sense, turned_deg, .. } = self.way(candidate);
        let conjugate_points = match candidate.provenance.method {
            _ if !self.context.settings.test_second_order => None,
            Road::Scp => None,
            _ => second_order::conjugate_points(self.told_on(candidate), &candidate.costate::<N>()),
        };
        let (start, cost) = (candidate.provenance.start.clone(), rival.cost * self.fine.dynamics.units.cost);
        Rival { start, sense, cost, conjugate_points, turned_deg }
    }

    /// Everything that is told of an attempt.
    pub fn write(&self, solution: &mut Solution, attempt: &Attempt) {
        let candidate = &attempt.candidate;
        let provenance = &candidate.provenance;
        solution.outcome = attempt.outcome;
        solution.method = provenance.method;
        solution.start = provenance.start.clone();
        solution.iterations = provenance.iterations;
        if let Some(shortfall) = &attempt.shortfall {
            solution.shortfall = Some(shortfall.clone());
        }
        if candidate.steps() != self.problem.steps {
            return;
        }
        let scp = provenance.method == Road::Scp;
        let chain = scp.then(|| self.chain_of_given_duration(candidate.steps()));
        let (recorded, optimality) = match &chain {
            Some(chain) => (record::chain(self.problem, &self.fine, chain, candidate), None),
            None => self.recorded(attempt),
        };
        let recorded = match recorded {
            Ok(recorded) => recorded,
            // What cannot be replayed is no plan, however well its conditions are met.
            Err(error) => {
                if attempt.converged() {
                    solution.outcome = outcome_of(error);
                }
                return;
            }
        };
        solution.cost = recorded.cost * self.fine.dynamics.units.cost;
        solution.terminal = recorded.terminal;
        solution.sense = recorded.way.sense;
        solution.turned_deg = recorded.way.turned_deg;
        solution.trajectory = recorded.trajectory;
        match &chain {
            None => {
                solution.active = recorded.active;
                solution.optimality = match optimality {
                    Some(optimality) => optimality,
                    None if self.context.settings.test_second_order => {
                        second_order::optimality(&self.fine, &candidate.costate())
                    }
                    None => Optimality::UNTESTED,
                };
            }
            Some(chain) if attempt.converged() => {
                solution.active = recorded.active;
                solution.convex = Some(ConvexWork { subproblems: provenance.subproblems, ..self.work });
                // The second order is that of the effort, in the duration found.
                let effort = self.ask.goal.as_ref().is_none_or(|goal| !goal.objective.switches());
                let tested = self.context.settings.test_second_order;
                solution.optimality = self.context.within(|budget| {
                    let (iterate, multipliers) = (iterate(candidate), multipliers(candidate));
                    let watch = Watch { deadline: None, ..budget.watch };
                    Optimality {
                        tested,
                        stationarity: attempt.stationarity,
                        conjugate_points: (effort && tested)
                            .then(|| descents(&chain.model, &chain.rows, &iterate, &multipliers, &watch))
                            .flatten(),
                        rank: chain.model.terminal_count(),
                        condition: f64::NAN,
                    }
                });
            }
            Some(_) => {}
        }
    }

    /// Records an extremal, and where that pays tests its second order meanwhile.
    fn recorded(&self, attempt: &Attempt) -> (Result<Recorded, StepError>, Option<Optimality>) {
        let (problem, fine, stopped) = (self.problem, &self.fine, self.stopped());
        let (costate, swept) = (attempt.candidate.costate(), attempt.swept.as_ref());
        if stopped || !fine.is_kept_after_stop() {
            // The best iterate is worth a moment more.
            let undisturbed = (stopped && fine.is_kept_after_stop()).then(|| fine.undisturbed());
            return (record::extremal(problem, undisturbed.as_ref().unwrap_or(fine), &costate, swept), None);
        }
        let pays = problem.steps >= WORTH_A_THREAD && parallel::threads() > 1;
        if !pays || !self.context.settings.test_second_order {
            return (record::extremal(problem, fine, &costate, swept), None);
        }
        let (dynamics, start, terminal) = fine.parts();
        let record = || {
            let fine = BoundaryValueProblem::<N>::of_parts(dynamics, start, terminal);
            record::extremal(problem, &fine, &costate, swept)
        };
        let test = || second_order::optimality(fine, &costate);
        let (optimality, recorded) = parallel::both(test, record, || {
            self.stopped();
        });
        (recorded, Some(optimality))
    }

    /// Adds to an unsolved maneuver the duration for which a plan was found.
    pub(super) fn advise(&self, solution: &mut Solution) {
        // A search that was cut short says nothing about the maneuver.
        let searched = !matches!(solution.outcome, Outcome::Converged | Outcome::IterationLimit);
        if searched
            && !self.stopped()
            && let Some(violated) = &mut solution.shortfall
        {
            solution.longer = self.longer();
            solution.shortest = self.shortest;
            match (self.shortest, solution.longer) {
                (Some(shortest), _) if shortest < self.problem.duration => {
                    let (asked, shortest) = (short(self.problem.duration), significant(shortest, 6));
                    violated.push_str(&format!(
                        "; no plan of {asked} s was found, though there is one of {shortest} s"
                    ));
                }
                (Some(shortest), _) => {
                    let (asked, shortest) = (short(self.problem.duration), significant(shortest, 6));
                    violated.push_str(&format!(
                        "; no plan of {asked} s was found, the shortest duration found is {shortest} s (locally minimal)"
                    ));
                }
                (None, Some(duration)) => violated.push_str(&format!("; a plan of {duration} s was found")),
                (None, None) => {
                    violated.push_str("; none was found for up to three times the duration either");
                }
            }
        }
    }

    /// The shooting's word on an answer of SCP, started from its duals: whether it is an extremal, and of which
    /// second order. Where its terminal error is above the tolerance, the shooting's own answer.
    fn confirm(&mut self, solution: Solution) -> Solution {
        if solution.outcome != Outcome::Converged || self.stopped() {
            return solution;
        }
        self.found.clear();
        let duals = solution.costates_0(self.problem).to_vec();
        if duals.is_empty() {
            return solution;
        }
        self.shoot_from(&duals, "duals");
        let Some(shot) = self.found.first() else { return solution };
        let unsolved = Solution::unsolved(self.problem, self.context.settings.tolerance);
        let mut confirmed = Solution { solve_time: self.context.began.elapsed().as_secs_f64(), ..unsolved };
        self.write(&mut confirmed, shot);
        if (confirmed.cost - solution.cost).abs() > SAME_COST * solution.cost.abs() {
            return solution;
        }
        if solution.terminal.largest() > self.context.settings.tolerance {
            return Solution { convex: solution.convex, rivals: solution.rivals, ..confirmed };
        }
        let stationarity = solution.optimality.stationarity.max(confirmed.optimality.stationarity);
        let optimality = Optimality { stationarity, ..confirmed.optimality };
        Solution { optimality, solve_time: confirmed.solve_time, ..solution }
    }
}

/// A solution that counts as converged only where its terminal error, replayed from the start, is within the
/// tolerance.
fn held_to(tolerance: f64, mut solution: Solution) -> Solution {
    let met = solution.terminal.largest() <= tolerance;
    if solution.outcome == Outcome::Converged && !met {
        solution.outcome = Outcome::Stalled;
        solution.shortfall = Some(format!(
            "the conditions of the optimum are met, but the inputs replayed from the start miss the end by {:.1e}, \
             scaled; the tolerance is {tolerance:.1e}",
            solution.terminal.largest()
        ));
    }
    solution
}

/// Whether two attempts ended at the same plan.
pub(super) fn same<const N: usize>(a: &Attempt, b: &Attempt) -> bool {
    if b.candidate.provenance.method == Road::Scp {
        return (a.cost - b.cost).abs() <= SAME_COST * b.cost.abs().max(1e-12);
    }
    let (a, b) = (a.candidate.costate::<N>(), b.candidate.costate::<N>());
    (a - b).amax() < SAME * a.amax().max(1.0)
}

/// Turns to try, in order.
pub(super) fn wanted_turns(problem: &Problem) -> Vec<i32> {
    match problem.path {
        Path::Best => vec![0, -1],
        Path::Shortest => vec![0],
        Path::Long => vec![-1],
        Path::AsGiven(rotation) => vec![turns_as_given(problem, &rotation)],
    }
}

/// How many turns the given rotation is away from the shortest one between the boundary attitudes. It only
/// names the start; which extremal is the given one is decided by its own rotation.
fn turns_as_given(problem: &Problem, rotation: &Vector3) -> i32 {
    let short = lie::minus(&problem.end.attitude, &problem.start.attitude);
    // A rotation by 370° is 10° and one turn; one by −350° about the same axis is 10° less one turn.
    let axis = if short.norm() > 1e-12 { short / short.norm() } else { Vector3::x() };
    let along = rotation.norm() * rotation.dot(&axis).signum();
    ((along - short.norm()) / TAU).round() as i32
}

/// Whether the best way from rest may be sought on a grid of very few steps: that of the first-order scheme is too coarse
/// to tell a rival's cost by, and so it is beside a requested grid on which the search would take place itself.
fn coarse_from_rest(problem: &Problem) -> bool {
    problem.scheme == Scheme::LieVerlet && problem.steps >= FEWEST_FROM_REST
}

/// The grid on which the shooting searches.
fn search_grid(problem: &Problem, turns: i32, even: bool) -> usize {
    // Where inputs meet their limits, costates on two grids have no expansion in the step.
    if problem.actuation.is_limited() {
        return problem.steps;
    }
    let short = lie::minus(&problem.end.attitude, &problem.start.attitude);
    let angle = (short.norm() + TAU * f64::from(turns)).abs();
    let ends = [&problem.start, &problem.end];
    let rests = ends.iter().all(|end| end.angular_velocity == Vector3::zeros());
    // A body that only turns, and about all axes alike, turns by hardly more than the angle of its way.
    let plain = problem.steps < FEW_STEPS && rests && even && problem.motion == Motion::Attitude;
    let rule = match problem.path {
        _ if !problem.environment.is_free() => SHOOTING_FREE,
        Path::Best if !even => SHOOTING_UNEVEN,
        Path::Best if plain && coarse_from_rest(problem) => SHOOTING_FROM_REST,
        Path::Best => SHOOTING_FREE,
        _ if plain => return coarse_steps(problem, angle, &SHOOTING_ONE_WAY),
        _ => SHOOTING_FREE,
    };
    // Other extremals may turn by half a turn and more.
    let angle = angle.max(PI);
    coarse_steps(problem, angle, &rule)
}
