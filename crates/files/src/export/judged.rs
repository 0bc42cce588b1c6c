//! Verification of a plan file: the plan by the witnesses, and the recorded values by
//! recomputation.

use super::recorded;
use super::{ExportError, PlanFile, Seal};
use crate::identity::Identity;
use crate::spec::{ClosedLoop, Difference, Loaded, SpecDocument};
use slewkit::maneuver::{Problem, Settings};
use slewkit::numerics::figures::{scientific, told_apart};
use slewkit::plan::Status;
use slewkit::verify::{self, Check, Verification};

/// Results of the verification of a plan file.
#[derive(Clone, Debug)]
pub struct Judgement {
    /// The maneuver against which the plan was verified, on the grid of the plan.
    pub problem: Problem,
    /// Results of the witnesses, and the check of the recorded checksum.
    pub verification: Verification,
    /// Keys whose values differ between the spec of the file and the spec of the verification. In
    /// each difference, the value of the file is first.
    pub differences: Vec<Difference>,
    /// Recorded values that differ from the recomputed values. In each difference, the value of the
    /// file is first.
    pub recorded: Vec<Difference>,
    /// Properties that were not verified, one sentence each, without the final period.
    pub not_judged: Vec<String>,
}

/// Text for the properties that the witnesses cannot verify, because they do not follow from the
/// motion.
const SEARCH: &str = "whether the plan is optimal (conjugate points, costates, rivals) and how it was found: \
    only `slew plan` determines this";
/// Text for the property that is not verified if the inputs are smoothed.
const SMOOTHED: &str =
    "the extremal of continuous time near the smoothed inputs: the file does not hold its arcs";
/// Text for the recorded values that are not verified, because the plan was made for another spec
/// or its verification is incomplete.
const FIGURES: &str =
    "the recorded figures of the witnesses: they belong to the plan's own spec, and to a complete run";

/// Name of the check that fails if a value of the file was changed after it was written.
const CHECKSUM: &str = "recorded checksum";
/// Text for the recorded values that are not verified if the checksum cannot be checked.
const UNSEALED: &str = "whether costates, gains, covariances or another figure of the search was changed in \
    the file: it has no checksum of this version, or no spec";

/// Largest relative error of a recorded cost or step; it allows for round-off of sums in another
/// order.
const RECORDED: f64 = 1e-9;

impl PlanFile<'_> {
    /// Verifies with the witnesses that the plan solves `problem` to the tolerances of `settings`,
    /// on the grid of the plan. The witnesses call `stop` every few steps and end when it returns
    /// true. `identity` and `closed_loop` do not affect the verdict, but their differences from the
    /// contents of the file are reported.
    ///
    /// # Errors
    /// Returns an error if the lengths of the arrays do not fit the maneuver.
    pub fn judge(
        &self,
        problem: &Problem,
        settings: &Settings,
        identity: &Identity,
        closed_loop: &ClosedLoop,
        stop: &dyn Fn() -> bool,
    ) -> Result<Judgement, ExportError> {
        let held = self.spec.as_ref();
        // The grid is taken from the plan. The same applies to the times at which each of several
        // alternative sets of cones must hold.
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
        // Recorded values are not compared with the results of an incomplete verification.
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
        // The recorded tolerance must equal the tolerance in the spec of the file, even if the
        // tolerance in `settings` is different.
        let cost = verify::cost(&problem, trajectory);
        let made_to = held.and_then(|held| held.read("the plan's spec", &[]).ok());
        let made_to = made_to.map(|own| (self.tolerance, own.settings.tolerance));
        // If the inputs are bang-bang, the steps differ, and the recorded step is their mean.
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
        if matches!(self.seal, Seal::Foreign) {
            not_judged.push(UNSEALED.into());
        }
        let told = [
            ("recorded status", self.is_coherent(&problem)),
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
        if matches!(self.seal, Seal::Broken) {
            verification.checks.push(Check { name: CHECKSUM.into(), value: 1.0, limit: 0.0, passed: false });
        }
        Ok(Judgement { problem, verification, differences, recorded, not_judged })
    }

    /// Verifies a file whose status is solved and verified; `loaded` is the spec of the file.
    /// Returns the file. If the witnesses refute its status, the returned file has their verdict,
    /// and the reason is returned with it; otherwise the reason is `None`.
    pub fn settled(mut self, loaded: &Loaded) -> (Self, Option<String>) {
        if self.status != Status::Solved {
            return (self, None);
        }
        let Loaded { problem, settings, identity, closed_loop, .. } = loaded;
        let why = match self.judge(problem, settings, identity, closed_loop, &|| false) {
            Ok(judged) if judged.verification.passed() => return (self, None),
            Ok(Judgement { verification, .. }) => {
                let failed = verification.checks.iter().find(|check| !check.passed);
                let why = match failed {
                    None => "a witness rejects it".to_string(),
                    Some(check) if check.name == CHECKSUM => {
                        "its checksum shows that it was changed after it was written".to_string()
                    }
                    Some(Check { name, value, limit, .. }) => {
                        let [value, limit] = told_apart([*value, *limit], 2, scientific);
                        format!("{name} is {value}, at most {limit}")
                    }
                };
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

    /// Returns whether the status, the outcome, the exit code and the proof in the file are
    /// consistent.
    fn is_coherent(&self, problem: &Problem) -> bool {
        let proved = self.plan().ok().and_then(|plan| plan.solution.proved(problem));
        self.status.agrees_with(self.outcome, self.verified.as_ref())
            && self.exit_code == self.status.exit_code()
            && self.second_order == self.optimality.second_order()
            && self.proof == proved
    }
}
