//! The judgement of a plan file by the witnesses: the plan, and the figures in the file.

use super::recorded;
use super::{ExportError, PlanFile, Seal};
use crate::identity::Identity;
use crate::spec::{ClosedLoop, Difference, Loaded, SpecDocument};
use slewkit::maneuver::{Problem, Settings};
use slewkit::numerics::figures::{scientific, told_apart};
use slewkit::plan::Status;
use slewkit::verify::{self, Check, Verification};

/// The results of the witnesses for a plan file.
#[derive(Clone, Debug)]
pub struct Judgement {
    /// The maneuver by which the file was judged, on the grid of the plan.
    pub problem: Problem,
    /// The results, with a check of every figure in the file.
    pub verification: Verification,
    /// The keys in which the spec in the file differs from the spec of the judgement: the file's
    /// value first.
    pub differences: Vec<Difference>,
    /// The recorded values that differ from the results: the value of the file first.
    pub recorded: Vec<Difference>,
    /// The items that are not judged, each a sentence without its point.
    pub not_judged: Vec<String>,
}

/// The items that no witness of a motion can judge.
const SEARCH: &str = "whether the plan is optimal (conjugate points, costates, rivals) and how it was found: \
    only `slew plan` determines this";
/// The item that is not judged for a smoothed law.
const SMOOTHED: &str =
    "the extremal of continuous time near the smoothed inputs: the file does not hold its arcs";
/// The items that are not judged if the plan was made for another spec, or its verification is
/// incomplete.
const FIGURES: &str =
    "the recorded figures of the witnesses: they belong to the plan's own spec, and to a complete run";

/// The name of the check that fails if a value of the file is not the one that was written.
const CHECKSUM: &str = "recorded checksum";
/// The items that are not judged if the checksum cannot be judged.
const UNSEALED: &str = "whether costates, gains, covariances or another figure of the search was changed in \
    the file: it has no checksum of this version, or no spec";

/// The allowed relative error of a recorded figure: the round-off of sums in another order.
const RECORDED: f64 = 1e-9;

impl PlanFile<'_> {
    /// Lets the witnesses judge whether the plan fulfils `problem`, to the tolerances of
    /// `settings`, on its own grid. They stop when `stop` returns true; it is called every few
    /// steps. `identity` and `closed_loop` change no verdict, but differences from the file are
    /// reported.
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
        // The plan chooses its grid, and the times at which each of several sets of cones holds.
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
        // An incomplete verification has no figures to compare.
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
        // The recorded tolerance must be the tolerance of the plan, even if another spec has a
        // different one.
        let cost = verify::cost(&problem, trajectory);
        let made_to = held.and_then(|held| held.read("the plan's spec", &[]).ok());
        let made_to = made_to.map(|own| (self.tolerance, own.settings.tolerance));
        // If inputs switch, the plan has its own duration, and the mean of its steps is reported.
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

    /// Returns the file with the verdict of the witnesses if it claims to be solved and verified,
    /// and the reason if they refuse that claim; `loaded` is the spec that the file holds.
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
                    None => "a witness refuses it".to_string(),
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

    /// Returns whether status, outcome, exit code and the claimed proof in the file agree.
    fn is_coherent(&self, problem: &Problem) -> bool {
        let proved = self.plan().ok().and_then(|plan| plan.solution.proved(problem));
        self.status.agrees_with(self.outcome, self.verified.as_ref())
            && self.exit_code == self.status.exit_code()
            && self.second_order == self.optimality.second_order()
            && self.proof == proved
    }
}
