//! A plan file before the witnesses: the plan, and the figures that the file tells of it.

use super::{ExportError, PlanFile};
use crate::files::spec::{Difference, SpecDocument};
use crate::maneuver::{Problem, Settings};
use crate::verify::{self, Check, Verification};

/// What the witnesses found of a plan file.
#[derive(Clone, Debug)]
pub struct Judgement {
    /// The maneuver that it was judged by, on the grid of the plan.
    pub problem: Problem,
    /// What they found, with a check of every figure that the file tells.
    pub verification: Verification,
    /// Where the spec that the file holds is not the one that it was judged by: the file's value first.
    pub differences: Vec<Difference>,
}

/// Relative error that a recorded figure may have: that of sums in another order.
const RECORDED: f64 = 1e-9;

impl PlanFile<'_> {
    /// Has the witnesses judge the plan: whether it fulfils `problem`, to the tolerances of `settings`, on its own
    /// grid. They stop when `stop` says so, which is asked every few steps.
    ///
    /// # Errors
    /// Arrays that do not fit the maneuver.
    pub fn judge(
        &self,
        problem: &Problem,
        settings: &Settings,
        stop: &dyn Fn() -> bool,
    ) -> Result<Judgement, ExportError> {
        // The grid is the plan's own matter.
        let problem = self.on_grid(problem)?;
        let held = self.spec.as_ref();
        let judged_by = SpecDocument::new(&problem, settings).ok();
        let differences = held.zip(judged_by).map_or(Vec::new(), |(held, other)| held.differences(&other));
        let (trajectory, tolerance) = (&self.trajectory.0, settings.tolerance);
        let continuous = settings.continuous_tolerance;
        let mut verification = verify::verify_until(&problem, trajectory, tolerance, continuous, stop);
        // The tolerance that the plan was made to is its own matter, whatever another spec asks for.
        let cost = verify::cost(&problem, trajectory);
        let own = held.and_then(|held| held.read("the plan's spec", &[]).ok());
        let own = own.map(|own| (self.tolerance, own.settings.tolerance));
        // Where inputs switch the plan has its duration, and steps of which the mean is told.
        let switches = problem.switches();
        let last = trajectory.time.last().copied().unwrap_or(f64::NAN);
        let duration = if switches { last } else { problem.duration };
        let step = if switches { duration / problem.steps as f64 } else { problem.step() };
        let recorded = [
            ("recorded cost", Some((self.cost, cost))),
            ("recorded duration", Some((self.duration_s, duration))),
            ("recorded step", Some((self.step_s, step))),
            ("recorded turn", Some((self.turned_deg, verify::swept(trajectory).to_degrees()))),
            ("recorded tolerance", own),
        ];
        for (name, (told, found)) in recorded.into_iter().filter_map(|(name, pair)| Some((name, pair?))) {
            let value = (told - found).abs() / found.abs().max(f64::MIN_POSITIVE);
            let passed = told == found || value <= RECORDED;
            verification.checks.push(Check { name: name.into(), value, limit: RECORDED, passed });
        }
        Ok(Judgement { problem, verification, differences })
    }
}
