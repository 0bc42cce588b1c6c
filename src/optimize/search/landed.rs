//! The plan that is written, made to land (`optimize::landing`), by the method that found it.

use super::cheapest::{SHARE, SHARP};
use super::constrained::along;
use super::context::Context;
use super::ladder::{Ask, Search};
use super::record;
use super::starts;
use crate::flight::{Excess, Flight};
use crate::maneuver::problem::{Motion, Problem};
use crate::maneuver::settings::Method as Road;
use crate::maneuver::solution::{Outcome, Solution, Trajectory};
use crate::optimize::candidate::Candidate;
use crate::optimize::landing::{Landed, land_chain, land_costate};
use crate::optimize::methods::driver::Report;
use crate::optimize::methods::method::{Attempt, Method, Swept};
use crate::optimize::methods::scp::ScpOptions;
use crate::optimize::methods::scp::model::Goal;
use crate::optimize::methods::scp::road::{ActiveSetNewton, Chain, ConvexIteration};
use crate::optimize::sweep::BoundaryValueProblem;
use nalgebra::{DVector, SVector};

/// Steps, as a multiple of those of the coarse grid, from whose sensitivity corrections begin.
const BEGUN_ON: usize = 2;

/// By what the share of the effort is raised where a plan of time or fuel does not settle for a shifted target.
const EASED: f64 = 0.1;

impl<const N: usize> Search<'_, '_, N> {
    /// An attempt on the requested grid, made to land; `None` where that is not asked for or cannot begin.
    pub(super) fn landed(&self, attempt: &Attempt) -> Option<Landed> {
        let candidate = &attempt.candidate;
        let ready = self.ask.lands && attempt.converged() && candidate.steps() == self.problem.steps;
        if !ready || self.stopped() {
            return None;
        }
        if candidate.provenance.method != Road::Scp {
            return self.costate_landed(attempt, &candidate.costate());
        }
        let mut chain = self.chain_of_given_duration(candidate.steps());
        let record = |chain: &Chain, attempt: &Attempt| {
            Some(record::chain(self.problem, &self.fine, chain, &attempt.candidate).ok()?.trajectory)
        };
        let options = &self.ask.last;
        land_chain(self.problem, &mut chain, attempt.clone(), record, |chain, attempt| {
            self.warm(chain, attempt, options)
        })
    }

    fn costate_landed(&self, attempt: &Attempt, costate: &SVector<f64, N>) -> Option<Landed> {
        let steps = (BEGUN_ON * self.coarse.dynamics.grid.steps()).min(self.problem.steps);
        let coarse = self.fine.on_steps(steps);
        let found = land_costate(self.problem, &self.fine, &coarse, costate, &|| self.stopped())?;
        let error = found.nodes.last()?.physical().minus(&found.target).to_vector::<N>();
        let swept = Swept {
            nodes: found.nodes,
            error: DVector::from_column_slice(error.as_slice()),
            cost: found.cost,
        };
        let candidate = Candidate {
            provenance: attempt.candidate.provenance.clone(),
            ..attempt.candidate.clone().with_costate(&found.costate)
        };
        let attempt = Attempt { candidate, cost: found.cost, swept: Some(swept), ..attempt.clone() };
        Some(Landed { attempt, target: found.state, landing: found.landing })
    }

    /// Solves again on a chain that is aimed a little elsewhere: by Newton on the active set or, where that does not settle, by
    /// the convex iteration.
    fn warm(&self, chain: &Chain, attempt: &Attempt, options: &ScpOptions) -> Option<Attempt> {
        let provenance = attempt.candidate.provenance.clone();
        let solved = |method: &dyn Fn(Candidate) -> Attempt| {
            let again = method(attempt.candidate.clone());
            again.converged().then(|| Attempt {
                candidate: Candidate { provenance: provenance.clone(), ..again.candidate },
                runs: attempt.runs.clone(),
                work: attempt.work,
                ..again
            })
        };
        let newton = ActiveSetNewton { chain, options };
        let convex = ConvexIteration { chain, options };
        self.context.within(|budget| {
            solved(&|candidate| newton.improve(candidate, budget))
                .or_else(|| solved(&|candidate| convex.improve(candidate, budget)))
        })
    }

    /// A plan of a chain with a goal, whose duration may be sought, made to land, and the share of the effort in its cost.
    pub(super) fn landed_with_goal(&self, found: &Attempt, share: f64) -> Option<(Landed, f64)> {
        if !self.ask.lands || !found.converged() || self.stopped() {
            return None;
        }
        let (problem, steps) = (self.problem, self.problem.steps);
        let goal = self.ask.goal.as_ref()?;
        let share = if goal.objective.switches() { share } else { goal.share };
        let goal = Goal { share, ..goal.clone() };
        let mut chain = Chain::with_goal(problem, steps, &goal);
        let record = |chain: &Chain, attempt: &Attempt| {
            let duration = problem.seconds() * attempt.candidate.grid.duration();
            let planned = problem.clone().lasting(duration);
            let given = chain.of_given_duration(attempt.clone(), &planned);
            let of_duration = match goal.in_given_duration() {
                None => Chain::new(&planned, steps),
                Some(goal) => Chain::with_goal(&planned, steps, &goal),
            };
            let bvp = BoundaryValueProblem::<N>::new(&planned, steps);
            Some(record::chain(&planned, &bvp, &of_duration, &given.candidate).ok()?.trajectory)
        };
        // Multipliers tell which inputs are off, the less clearly the smaller the share.
        let options = ScpOptions { cone_tolerance: SHARP, ..self.ask.last.clone() };
        let mut least = share;
        let solve = |chain: &Chain, attempt: &Attempt| {
            let sharp = self.warm(chain, attempt, &options);
            if sharp.is_some() || !goal.objective.switches() {
                return sharp;
            }
            // Other limits act for the new target: with more of the effort in the cost they are found, and with less again kept.
            let mut eased = goal.share;
            while eased < SHARE && !self.stopped() {
                eased = (eased / EASED).min(SHARE);
                let goal = Goal { share: eased, ..goal.clone() };
                let mut easier =
                    Chain { rows: chain.rows.clone(), ..Chain::with_goal(problem, steps, &goal) };
                easier.model.aim_with(&chain.model);
                if let Some(found) = self.warm(&easier, attempt, &options) {
                    return self.warm(chain, &found, &options).or_else(|| {
                        least = least.max(eased);
                        Some(found)
                    });
                }
            }
            None
        };
        let landed = land_chain(problem, &mut chain, found.clone(), record, solve);
        landed.map(|landed| (landed, least))
    }

    /// The answer of a search without limits, made to land: where its true motion then exceeds a constraint, by the convex
    /// iteration along its path.
    pub(super) fn answer_landed(&self, answer: Solution) -> Solution {
        if !self.ask.lands || answer.outcome != Outcome::Converged || self.stopped() {
            return answer;
        }
        let Ok(costate) = starts::given(self.problem, &self.fine, answer.costates_0(self.problem)) else {
            return answer;
        };
        let candidate = Candidate::of_costate(&answer.start, &self.fine.dynamics.grid, &costate);
        let report =
            Report { outcome: Outcome::Converged, iterations: answer.iterations, residuals: Vec::new() };
        let mut written = answer.clone();
        self.write(&mut written, &Attempt::of(candidate, report));
        written.iterations = answer.iterations;
        if let Some(landing) = &mut written.landing {
            landing.cost_before = answer.cost;
        }
        if written.landing.is_none() || !self.exceeds(&written.trajectory) {
            return written;
        }
        let steps = self.problem.steps;
        let chain = Chain::new(self.problem, steps);
        let path = chain.opened(&along(&answer.start, &answer.trajectory, &chain.model.dynamics));
        let convex = ConvexIteration { chain: &chain, options: &self.ask.last };
        let kept = self.context.within(|budget| convex.improve(path, budget));
        if kept.converged() {
            let mut kept_within = answer.clone();
            self.write(&mut kept_within, &kept);
            kept_within.iterations = answer.iterations;
            return kept_within;
        }
        written
    }

    /// Whether the true motion of a plan exceeds a constraint.
    fn exceeds(&self, plan: &Trajectory) -> bool {
        let Some(mut excess) = Excess::of(self.problem) else { return false };
        let steps = Flight::of_plan(self.problem, plan);
        let mut flight = Flight::new(self.problem);
        flight.settle(&steps);
        flight.fly(&steps, Some(&mut excess)).is_none() || excess.worst.iter().any(|worst| *worst > 0.0)
    }
}

/// A plan of least effort whose duration was sought, made to land in that duration.
pub(super) fn with_duration_found(problem: &Problem, solution: Solution, context: &Context) -> Solution {
    let Some(duration) = solution.trajectory.time.last().copied() else { return solution };
    if !context.lands() || solution.outcome != Outcome::Converged {
        return solution;
    }
    let given = problem.clone().lasting(duration);
    let ask = Ask { lands: true, ..Ask::of_goal(None, context.settings) };
    let priced = problem.objective.time_price() * duration;
    let (ladder, solve_time, stationarity) =
        (solution.ladder.clone(), solution.solve_time, solution.optimality.stationarity);
    let landed = match given.motion {
        Motion::Attitude => Search::<6>::new(&given, context, ask).answer_landed(solution),
        Motion::RigidBody => Search::<12>::new(&given, context, ask).answer_landed(solution),
    };
    let mut landed = Solution { ladder, solve_time, ..landed };
    if landed.landing.is_some() {
        landed.cost += priced;
        landed.optimality.stationarity = landed.optimality.stationarity.max(stationarity);
    }
    landed
}
