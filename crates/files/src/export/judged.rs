//! A plan file before the witnesses: the plan, and the figures that the file tells of it.

use super::recorded;
use super::{ExportError, PlanFile};
use crate::identity::Identity;
use crate::spec::{ClosedLoop, Difference, Loaded, SpecDocument};
use slewkit::maneuver::{Problem, Settings};
use slewkit::numerics::figures::{scientific, told_apart};
use slewkit::plan::Status;
use slewkit::verify::{self, Check, Verification};

/// What the witnesses found of a plan file.
#[derive(Clone, Debug)]
pub struct Judgement {
    /// The maneuver that it was judged by, on the grid of the plan.
    pub problem: Problem,
    /// What they found, with a check of every figure that the file tells.
    pub verification: Verification,
    /// Where the spec that the file holds is not the one that it was judged by: the file's value first.
    pub differences: Vec<Difference>,
    /// Where what the file records is not what is found: the file's value first.
    pub recorded: Vec<Difference>,
    /// What is not judged, a sentence each without its point.
    pub not_judged: Vec<String>,
}

/// What no witness of a motion can judge.
const SEARCH: &str = "whether the plan is optimal (conjugate points, costates, rivals) and how it was found: `slew plan` finds that again";
/// Of a smoothed law.
const SMOOTHED: &str =
    "the extremal of continuous time beside the smoothed inputs: the file does not hold its arcs";
/// What is left out where the plan was made to another spec, or was not verified to the end.
const FIGURES: &str = "the figures of the witnesses that the file records: they are those of its own spec, and of a run to the end";

/// Relative error that a recorded figure may have: that of sums in another order.
const RECORDED: f64 = 1e-9;

impl PlanFile<'_> {
    /// Has the witnesses judge the plan: whether it fulfils `problem`, to the tolerances of `settings`, on its own
    /// grid. They stop when `stop` says so, which is asked every few steps. `identity` is what the maneuver is called, `closed_loop` what
    /// it is flown with: they change no verdict, but what differs is told.
    ///
    /// # Errors
    /// Arrays that do not fit the maneuver.
    pub fn judge(
        &self,
        problem: &Problem,
        settings: &Settings,
        identity: &Identity,
        closed_loop: &ClosedLoop,
        stop: &dyn Fn() -> bool,
    ) -> Result<Judgement, ExportError> {
        let held = self.spec.as_ref();
        // The grid is the plan's own matter, and so is which of several sets of cones holds when.
        let turned;
        let problem = if problem.alternatives.is_empty() {
            problem
        } else {
            let own = held.and_then(|held| held.read("the plan's spec", &[]).ok());
            turned = verify::in_turns(problem, own.as_ref().map(|own| &own.problem), &self.trajectory.0);
            &turned
        };
        let problem = self.on_grid(problem)?;
        let judged_by = SpecDocument::new(&problem, settings).ok();
        let judged_by = judged_by.map(|spec| spec.with_identity(identity).with_closed_loop(closed_loop));
        let differences = held.zip(judged_by).map_or(Vec::new(), |(held, other)| held.differences(&other));
        let (trajectory, tolerance) = (&self.trajectory.0, settings.tolerance);
        let continuous = settings.continuous_limit();
        let mut verification = verify::verify_until(&problem, trajectory, tolerance, continuous, stop);
        let own = held.is_some() && !differences.iter().any(|found| SpecDocument::is_asked(&found.key));
        // What was cut off tells nothing.
        let cut = verification.was_stopped() || self.verified.as_ref().is_some_and(Verification::was_stopped);
        let mut not_judged = vec![SEARCH.to_string()];
        let recorded = if own && !cut && self.verified.is_some() {
            recorded::differences(self, &verification, &problem, continuous)
        } else {
            not_judged.push(FIGURES.into());
            Vec::new()
        };
        if self.switching.as_ref().is_some_and(|told| told.smoothing.is_some()) {
            not_judged.push(SMOOTHED.into());
        }
        let sense = if own { verify::sense(&problem, trajectory, stop) } else { None };
        // The tolerance that the plan was made to is its own matter, whatever another spec asks for.
        let cost = verify::cost(&problem, trajectory);
        let made_to = held.and_then(|held| held.read("the plan's spec", &[]).ok());
        let made_to = made_to.map(|own| (self.tolerance, own.settings.tolerance));
        // Where inputs switch the plan has its duration, and steps of which the mean is told.
        let last = trajectory.time.last().copied().unwrap_or(f64::NAN);
        let duration = problem.duration.known().filter(|_| !problem.switches()).unwrap_or(last);
        let step = duration / problem.steps as f64;
        let figures = [
            ("recorded cost", Some((self.cost, cost))),
            ("recorded duration", Some((self.duration_s, duration))),
            ("recorded step", Some((self.step_s, step))),
            ("recorded turn", Some((self.turned_deg, verify::swept(trajectory).to_degrees()))),
            ("recorded tolerance", made_to),
        ];
        for (name, (told, found)) in figures.into_iter().filter_map(|(name, pair)| Some((name, pair?))) {
            let value = (told - found).abs() / found.abs().max(f64::MIN_POSITIVE);
            let passed = told == found || value <= RECORDED;
            verification.checks.push(Check { name: name.into(), value, limit: RECORDED, passed });
        }
        let told = [
            ("recorded status", self.is_coherent()),
            ("recorded findings", recorded.is_empty()),
            ("recorded sense", sense.is_none_or(|sense| sense == self.sense)),
        ];
        for (name, passed) in told {
            verification.checks.push(Check {
                name: name.into(),
                value: f64::from(u8::from(!passed)),
                limit: 0.0,
                passed,
            });
        }
        Ok(Judgement { problem, verification, differences, recorded, not_judged })
    }

    /// The file with the verdict that the witnesses find where it claims to be solved and verified, and in words why they refuse that, if
    /// they do; `loaded` is the spec that it holds.
    pub fn settled(mut self, loaded: &Loaded) -> (Self, Option<String>) {
        if self.status != Status::Solved {
            return (self, None);
        }
        let Loaded { problem, settings, identity, closed_loop, .. } = loaded;
        let why = match self.judge(problem, settings, identity, closed_loop, &|| false) {
            Ok(judged) if judged.verification.passed() => return (self, None),
            Ok(Judgement { verification, .. }) => {
                let failed = verification.checks.iter().find(|check| !check.passed);
                let why = failed.map_or_else(
                    || "a witness refuses it".to_string(),
                    |Check { name, value, limit, .. }| {
                        let [value, limit] = told_apart([*value, *limit], 2, scientific);
                        format!("{name} is {value}, at most {limit}")
                    },
                );
                self.verified = Some(verification);
                why
            }
            Err(error) => {
                self.verified = None;
                error.to_string()
            }
        };
        self.status = Status::VerificationFailed;
        self.exit_code = self.status.exit_code();
        (self, Some(why))
    }

    /// Whether what the file tells of how the plan ended goes together.
    fn is_coherent(&self) -> bool {
        self.status.agrees_with(self.outcome, self.verified.as_ref())
            && self.exit_code == self.status.exit_code()
            && self.second_order == self.optimality.second_order()
    }
}
