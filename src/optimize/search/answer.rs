//! The answer of a search: the best of what was found, written with all that is told of it.

use super::ladder::{SAME_COST, Search};
use super::record::{self, Recorded};
use super::way::Way;
use crate::lie;
use crate::maneuver::problem::State;
use crate::maneuver::settings::Method as Road;
use crate::maneuver::shortfall::Shortfall;
use crate::maneuver::solution::{ConvexWork, Landing, Optimality, Outcome, Rival, Solution, Trajectory};
use crate::numerics::parallel;
use crate::optimize::landing::Landed;
use crate::optimize::methods::method::{Attempt, Watch};
use crate::optimize::methods::scp::road::{iterate, multipliers};
use crate::optimize::methods::scp::second_order::descents;
use crate::optimize::methods::shooting::newton::outcome_of;
use crate::optimize::second_order;
use crate::optimize::step::StepError;
use crate::optimize::sweep::BoundaryValueProblem;

/// Steps from which a second thread takes less time than waking it.
const WORTH_A_THREAD: usize = 400;

impl<const N: usize> Search<'_, '_, N> {
    /// Chooses among what was found, and writes the solution.
    pub fn conclude(&mut self) -> Solution {
        let solve_time = self.context.began.elapsed().as_secs_f64();
        let mut solution = match self.answer.take() {
            Some(answer) => self.answer_landed(answer),
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

    /// Everything that is told of an attempt, which is made to land first where that is asked for.
    pub fn write(&self, solution: &mut Solution, attempt: &Attempt) {
        match self.landed(attempt) {
            Some(Landed { attempt: landed, target, landing }) => {
                self.write_aimed(solution, &landed, Some(&target), attempt);
                let cost_before = attempt.cost * self.fine.dynamics.units.cost;
                solution.landing = Some(Landing { cost_before, ..landing });
            }
            None => self.write_aimed(solution, attempt, None, attempt),
        }
    }

    /// Everything that is told of an attempt at a target other than the end of the maneuver.
    ///
    /// The optimality of an extremal of the shooting is that of `optimum`, the discrete optimum that it was before it was made
    /// to land: a shift by `O(h²)` takes a circle of equal minima apart into a minimum and a saddle, and neither is one of the
    /// maneuver.
    pub fn write_aimed(
        &self,
        solution: &mut Solution,
        attempt: &Attempt,
        target: Option<&State>,
        optimum: &Attempt,
    ) {
        let aimed = target.map(|target| self.fine.aimed(target));
        let fine = aimed.as_ref().unwrap_or(&self.fine);
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
        let chain = scp.then(|| {
            let mut chain = self.chain_of_given_duration(candidate.steps());
            if let Some(target) = target {
                chain.model.aim(target);
            }
            chain
        });
        let (recorded, optimality) = match &chain {
            Some(chain) => (record::chain(self.problem, fine, chain, candidate), None),
            None => self.recorded(fine, attempt, optimum),
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
        solution.cost = recorded.cost * fine.dynamics.units.cost;
        solution.terminal = recorded.terminal;
        solution.sense = recorded.way.sense;
        solution.turned_deg = recorded.way.turned_deg;
        // Of a maneuver to any attitude the target is where the discrete motion ends.
        let reached = recorded.trajectory.quaternion.last().filter(|_| self.problem.ends_in_any_attitude());
        let reached = reached.map(lie::rotation_from_quaternion);
        let target = target.map(|target| State { attitude: reached.unwrap_or(target.attitude), ..*target });
        solution.trajectory = Trajectory { target, ..recorded.trajectory };
        match &chain {
            None => {
                solution.active = recorded.active;
                solution.optimality = match optimality {
                    Some(optimality) => optimality,
                    None if self.context.settings.test_second_order => {
                        second_order::optimality(&self.fine, &optimum.candidate.costate())
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
    fn recorded(
        &self,
        fine: &BoundaryValueProblem<N>,
        attempt: &Attempt,
        optimum: &Attempt,
    ) -> (Result<Recorded, StepError>, Option<Optimality>) {
        let (problem, stopped) = (self.problem, self.stopped());
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
        let tested = optimum.candidate.costate();
        let test = || second_order::optimality(&self.fine, &tested);
        let (optimality, recorded) = parallel::both(test, record, || {
            self.stopped();
        });
        (recorded, Some(optimality))
    }

    /// Adds to an unsolved maneuver the duration for which a plan was found.
    pub fn advise(&self, solution: &mut Solution) {
        // A search that was cut short says nothing about the maneuver.
        let searched = !matches!(solution.outcome, Outcome::Converged | Outcome::IterationLimit);
        if searched
            && !self.stopped()
            && let Some(missing) = solution.shortfall.take()
        {
            solution.longer = self.longer();
            solution.shortest = self.shortest;
            solution.shortfall = Some(Shortfall::InOtherTime {
                missing: Box::new(missing),
                asked: self.problem.seconds(),
                shortest: self.shortest,
                longer: solution.longer,
            });
        }
    }

    /// The shooting's word on an answer of SCP, started from its duals: whether it is an extremal, and of which
    /// second order. Where its terminal error is above the tolerance, the shooting's own answer.
    pub fn confirm(&mut self, solution: Solution) -> Solution {
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
