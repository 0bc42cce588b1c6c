//! Reconstruction of a plan from its file.

use super::{ExportError, PlanFile};
use slewkit::maneuver::Shortfall;
use slewkit::maneuver::{ConvexWork, Method, Proof, Solution};
use slewkit::plan::Plan;

impl PlanFile<'_> {
    /// Returns the plan as it was when the file was written. The time spent in the cone solver is
    /// not in the file and is set to zero.
    ///
    /// # Errors
    /// Returns [`ExportError::Scheme`] if the scheme is unknown.
    pub fn plan(&self) -> Result<Plan, ExportError> {
        let scheme = self.scheme().ok_or_else(|| ExportError::Scheme(self.scheme.clone()))?;
        let methods = [Method::Shooting, Method::Scp, Method::InteriorPoint];
        let method = methods.into_iter().find(|method| method.name() == self.method).unwrap_or(Method::Auto);
        let mut solution = Solution::unknown();
        solution.outcome = self.outcome;
        solution.method = method;
        solution.scheme = scheme;
        solution.steps = self.steps;
        solution.step = self.step_s;
        solution.cost = self.cost;
        solution.trajectory = self.trajectory.0.as_ref().clone();
        solution.terminal = self.terminal;
        solution.landing = self.landing.clone();
        solution.chosen = self.chosen;
        solution.optimality = self.optimality;
        solution.sense = self.sense;
        solution.start = self.start.clone();
        solution.turned_deg = self.turned_deg;
        solution.iterations = self.iterations;
        solution.ladder = self.ladder.clone();
        solution.convex = self.convex.as_ref().map(|work| {
            let mut convex = ConvexWork::default();
            convex.subproblems = work.subproblems;
            convex.all_subproblems = work.all_subproblems;
            convex.cone_iterations = work.cone_iterations;
            convex
        });
        solution.interior = self.interior_point.clone();
        solution.active = self.active.clone();
        solution.rivals = self.rivals.clone();
        solution.infeasible = self.obstruction.as_ref().map(|reason| {
            let mut proof = Proof::from(reason.clone());
            proof.duration_lower_bound = self.shortest_duration_s;
            proof
        });
        solution.shortfall = self.shortfall.clone().map(Shortfall::Told);
        solution.shortest = self.shortest_found_s;
        solution.longer = self.longer_s;
        solution.switching = self.switching.clone();
        solution.tolerance = self.tolerance;
        solution.solve_time = self.solve_time_s;
        Ok(Plan::new(solution, self.verified.clone(), self.status))
    }
}
