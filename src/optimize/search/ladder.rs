//! One search for free, limited and constrained maneuvers: the ladder, and what is found on it.
//!
//! Every rung improves candidates, most of them on a coarse grid; what it finds is carried to the requested
//! grid. Cheap rungs that nearly always work come first.

use super::coarse::search_grid;
use super::context::Context;
use super::guess::Guess;
use super::starts::{self, wanted_turns};
use crate::maneuver::problem::Problem;
use crate::maneuver::settings::Method as Road;
use crate::maneuver::shortfall::Shortfall;
use crate::maneuver::solution::{ConvexWork, Outcome, Rung, Solution, Trajectory};
use crate::numerics::factor::effective;
use crate::optimize::candidate::Candidate;
use crate::optimize::methods::driver::Report;
use crate::optimize::methods::method::{Attempt, Method, Run};
use crate::optimize::methods::scp::ScpOptions;
use crate::optimize::methods::scp::model::Goal;
use crate::optimize::methods::shooting::Shooting;
use crate::optimize::methods::shooting::refine::{CoarseToFine, polish};
use crate::optimize::sweep::BoundaryValueProblem;
use nalgebra::SVector;

/// Two extremals whose costates differ by less, relative, are one.
const SAME: f64 = 1e-6;
/// Costs of one optimum of SCP differ by less, relative.
pub(super) const SAME_COST: f64 = 1e-9;

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
    /// Whether what is written is made to land.
    pub lands: bool,
}

impl Ask<'_> {
    /// What is asked of the same maneuver without limits.
    pub fn of_relaxed(&self) -> Self {
        Self {
            shooting: true,
            convex: false,
            guess: None,
            along: None,
            goal: None,
            lands: false,
            ..self.clone()
        }
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
    /// What is missing, where no plan was found.
    pub shortfall: Option<Shortfall>,
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
    pub fn is_free(&mut self) -> bool {
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
    pub fn shoot_from(&mut self, costates: &[f64], start: &str) -> bool {
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
}

/// A solution that counts as converged only where its terminal error, replayed from the start, is within the
/// tolerance.
pub(super) fn held_to(tolerance: f64, mut solution: Solution) -> Solution {
    let met = solution.terminal.largest() <= tolerance;
    if solution.outcome == Outcome::Converged && !met {
        solution.outcome = Outcome::Stalled;
        solution.shortfall = Some(Shortfall::Missed { error: solution.terminal.largest(), tolerance });
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
