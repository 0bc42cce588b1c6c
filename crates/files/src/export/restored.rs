//! The plan that a plan file holds.

use super::{ExportError, PlanFile};
use slewkit::maneuver::{ConvexWork, Method, Proof, Solution};
use slewkit::plan::Plan;

impl PlanFile<'_> {
    /// The plan as it was written; the time inside the cone solver, which a file does not hold, is zero.
    ///
    /// # Errors
    /// [`ExportError::Scheme`].
    pub fn plan(&self) -> Result<Plan, ExportError> {
        let scheme = self.scheme().ok_or_else(|| ExportError::Scheme(self.scheme.clone()))?;
        let methods = [Method::Shooting, Method::Scp];
        let method = methods.into_iter().find(|method| method.name() == self.method).unwrap_or(Method::Auto);
        let proof = |reason: &String| Proof {
            reason: reason.clone(),
            duration_lower_bound: self.shortest_duration_s,
        };
        let solution = Solution {
            outcome: self.outcome,
            method,
            scheme,
            steps: self.steps,
            step: self.step_s,
            cost: self.cost,
            trajectory: self.trajectory.0.as_ref().clone(),
            terminal: self.terminal,
            landing: self.landing.clone(),
            chosen: self.chosen,
            optimality: self.optimality,
            sense: self.sense,
            start: self.start.clone(),
            turned_deg: self.turned_deg,
            iterations: self.iterations,
            ladder: self.ladder.clone(),
            convex: self.convex.as_ref().map(|work| ConvexWork {
                subproblems: work.subproblems,
                all_subproblems: work.all_subproblems,
                cone_iterations: work.cone_iterations,
                cone_seconds: 0.0,
                effort_share: work.effort_share,
            }),
            active: self.active.clone(),
            rivals: self.rivals.clone(),
            infeasible: self.obstruction.as_ref().map(proof),
            shortfall: self.shortfall.clone(),
            shortest: self.shortest_found_s,
            longer: self.longer_s,
            switching: self.switching.clone(),
            tolerance: self.tolerance,
            solve_time: self.solve_time_s,
        };
        Ok(Plan { solution, verification: self.verified.clone(), status: self.status })
    }
}
