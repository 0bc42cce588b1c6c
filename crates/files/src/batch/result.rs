//! Lines of a file of results: a header, then one line for each case.

use super::{Case, Kind, Shard};
use crate::export::SequenceRecord;
use crate::spec::{Diagnostics, Severity};
use serde::{Deserialize, Serialize};
use serde_json::{Map, Value};
use slewkit::maneuver::Shortfall;
use slewkit::maneuver::{Outcome, Problem, Proved, SecondOrder, Sense, TerminalError};
use slewkit::plan::{Plan, Status};
use slewkit::sequence::SequencePlan;
use slewkit::verify::Verification;

/// First line of a file of results, which identifies the batch.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Header {
    /// Version of the file format, [`Header::FORMAT`]. The name of this key identifies a file of
    /// results.
    pub slew_results: u32,
    /// Name and version of the program that planned the cases.
    pub generator: String,
    /// Kind of the source of the cases.
    pub kind: Kind,
    /// File name of the spec, or name of the folder of specs, without the path.
    pub spec: String,
    /// Number of cases of the whole batch.
    pub cases: u64,
    /// Keys that the cases set, in the order of their columns; empty for a folder of specs.
    pub keys: Vec<String>,
    /// Hash of the spec, of all values that the cases set, and of the version of the program.
    pub fingerprint: String,
    /// True if the lines hold wall times, which differ between runs.
    #[serde(default, skip_serializing_if = "std::ops::Not::not")]
    pub times: bool,
    /// Shard of the batch to which the file belongs; absent if the batch is not divided.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub shard: Option<Shard>,
}

impl Header {
    /// Version of the format that this program writes and reads.
    pub const FORMAT: u32 = 1;
}

/// Result of one case.
///
/// All numbers equal the numbers in the plan file. A value that does not exist is absent: the
/// result of a case without a plan has neither a cost nor an error of the motion.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct CaseResult {
    /// Number of the case, counted from 1.
    pub case: u64,
    /// Name of the case: from the column `name` of the table, or the file name in a folder.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub name: Option<String>,
    /// Keys that the case sets, with their values; texts are written as in `--set`.
    #[serde(default, skip_serializing_if = "Map::is_empty")]
    pub set: Map<String, Value>,
    /// Status of the case, as for the exit codes of the program: "solved", "infeasible", …, or
    /// "spec_invalid".
    pub status: String,
    /// Exit code with which `slew plan` ends on this case.
    pub exit_code: u8,
    /// First error of the spec of the case.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub error: Option<CaseError>,
    /// Objective of the plan: "effort", "time" or "fuel". Costs of different objectives cannot be
    /// compared.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub objective: Option<String>,
    /// Cost of the plan, if the solver converged.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub cost: Option<f64>,
    /// Duration of the plan, or the requested duration if no plan was found \[s\]. For a sequence
    /// it includes the holds.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub duration_s: Option<f64>,
    /// Names of the stops of a sequence, in the order of the visit.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub stops: Option<Vec<String>>,
    /// Total delay of the stops of a sequence past the ends of their windows \[s\].
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub late_s: Option<f64>,
    /// Number of steps; for a sequence, the sum over all legs.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub steps: Option<usize>,
    /// Solution method: "shooting", "scp" or "interior_point".
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub method: Option<String>,
    /// Outcome of the solver.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub outcome: Option<Outcome>,
    /// Number of Newton iterations from the initial guess that led to the plan.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub iterations: Option<usize>,
    /// Direction of rotation: the short or the long way to the end attitude.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub sense: Option<Sense>,
    /// Total angle turned \[deg\].
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub turned_deg: Option<f64>,
    /// Error of the discrete motion at the end, relative to the target.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub terminal: Option<TerminalError>,
    /// Degree to which the plan is proved to be an optimum.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub proof: Option<Proved>,
    /// Result of the second-order test: "minimum", "saddle", "undecided" or "not_tested".
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub second_order: Option<SecondOrder>,
    /// Upper bound, to first order, on the cost that a neighbouring plan can save. Only plans with
    /// bang-bang inputs have this bound; they have no second-order test.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub gap: Option<f64>,
    /// Results of the independent checks of the plan by the witnesses.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub verified: Option<Verdict>,
    /// Statement that proves that no plan exists, if the program found such a proof.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub obstruction: Option<String>,
    /// Proved lower bound on the duration \[s\]: no plan is shorter.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub shortest_duration_s: Option<f64>,
    /// Constraint violations of the best iterate, if the solver found no plan.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub shortfall: Option<String>,
    /// Wall time of the solve \[s\]; absent unless the options request times.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub solve_time_s: Option<f64>,
}

/// First error of the spec of a case.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct CaseError {
    /// Stable code of the error.
    pub code: String,
    /// Path of the key that has the error; empty if the error does not belong to a single key.
    pub key: String,
    /// Reason of the error, including the numbers concerned.
    pub reason: String,
    /// Remedy for the error.
    pub remedy: String,
    /// Number of further errors that the spec has.
    pub more: usize,
}

/// Results of the witnesses for a plan.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Verdict {
    /// True if every check is passed.
    pub passed: bool,
    /// Names of the failed checks.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub failed: Vec<String>,
    /// Terminal attitude error according to the discrete witness \[rad\]; absent if the witness
    /// could not propagate the motion to the end.
    pub discrete_attitude_rad: Option<f64>,
    /// Terminal attitude error of the continuous motion under the piecewise constant torque of the
    /// plan \[deg\].
    pub continuous_attitude_deg: Option<f64>,
    /// Observed order of convergence of the integration scheme; absent if the differences are at
    /// round-off level.
    pub order: Option<f64>,
    /// Largest norm of the torque at the nodes \[N·m\].
    pub peak_torque_n_m: Option<f64>,
    /// Largest norm of the angular velocity at the nodes \[deg/s\].
    pub peak_rate_deg_s: Option<f64>,
}

impl From<&Verification> for Verdict {
    fn from(found: &Verification) -> Self {
        let failed = found.checks.iter().filter(|check| !check.passed).map(|check| check.name.clone());
        Self {
            passed: found.passed(),
            failed: failed.collect(),
            discrete_attitude_rad: finite(found.discrete_attitude_rad),
            continuous_attitude_deg: finite(found.continuous_attitude_rad.to_degrees()),
            order: found.order.and_then(finite),
            peak_torque_n_m: finite(found.peak_torque_n_m),
            peak_rate_deg_s: finite(found.peak_rate_rad_s.to_degrees()),
        }
    }
}

impl Verdict {
    /// Combines the results for two parts of a sequence: the larger value of each error, and the
    /// failed checks of both parts.
    fn worse(self, other: Self) -> Self {
        let larger = |one: Option<f64>, other: Option<f64>| Some(one?.max(other?));
        let mut failed = self.failed;
        failed.extend(other.failed);
        failed.sort_unstable();
        failed.dedup();
        Self {
            passed: self.passed && other.passed,
            failed,
            discrete_attitude_rad: larger(self.discrete_attitude_rad, other.discrete_attitude_rad),
            continuous_attitude_deg: larger(self.continuous_attitude_deg, other.continuous_attitude_deg),
            // Orders of convergence of several legs cannot be combined.
            order: None,
            peak_torque_n_m: larger(self.peak_torque_n_m, other.peak_torque_n_m),
            peak_rate_deg_s: larger(self.peak_rate_deg_s, other.peak_rate_deg_s),
        }
    }
}

/// Returns the number if it is finite, otherwise `None`, because JSON has no NaN.
fn finite(value: f64) -> Option<f64> {
    value.is_finite().then_some(value)
}

impl CaseResult {
    /// Creates a result with only the identification of the case, the status and the exit code.
    fn of(case: &Case, status: &str, exit_code: u8) -> Self {
        let set = case.set.iter().map(|set| (set.path().to_string(), readable(set.value())));
        Self {
            case: case.number,
            name: case.name.clone(),
            set: set.collect(),
            status: status.into(),
            exit_code,
            ..Self::default()
        }
    }

    /// Creates the result of a case with an invalid spec.
    pub(super) fn invalid(case: &Case, found: &Diagnostics) -> Self {
        let errors = || found.0.iter().filter(|finding| finding.severity == Severity::Error);
        let error = errors().next().map(|first| CaseError {
            code: first.code.into(),
            key: first.key.clone(),
            reason: first.reason.clone(),
            remedy: first.remedy.clone(),
            more: errors().count() - 1,
        });
        let (status, exit_code) = if found.is_io() { ("file_error", 8) } else { ("spec_invalid", 3) };
        Self { error, ..Self::of(case, status, exit_code) }
    }

    /// Creates the result of a case with a valid spec that the planner rejects.
    pub(super) fn refused(case: &Case, code: &str, reason: String) -> Self {
        let remedy = "change the spec accordingly".into();
        let error = CaseError { code: code.into(), key: String::new(), reason, remedy, more: 0 };
        Self { error: Some(error), ..Self::of(case, "spec_invalid", 3) }
    }

    /// Creates the result of a sequence without a plan.
    pub(super) fn without_plan(case: &Case, status: Status, reason: String) -> Self {
        let is_proved = status == Status::Infeasible;
        let (obstruction, shortfall) = if is_proved { (Some(reason), None) } else { (None, Some(reason)) };
        Self { obstruction, shortfall, ..Self::of(case, status.name(), status.exit_code()) }
    }

    /// Creates the result of a planned sequence.
    pub(super) fn of_sequence(case: &Case, record: &SequenceRecord, plan: &SequencePlan) -> Self {
        let solved = record.status == Status::Solved;
        let parts = plan
            .legs
            .iter()
            .flat_map(|leg| std::iter::once(&leg.plan).chain(leg.hold.as_ref().map(|hold| &hold.plan)));
        let verdicts: Option<Vec<Verdict>> =
            parts.map(|part| part.verification.as_ref().map(Verdict::from)).collect();
        Self {
            objective: Some(record.minimize.clone()),
            cost: finite(record.cost).filter(|_| solved),
            duration_s: finite(record.duration_s).filter(|_| solved),
            stops: Some(record.stops.iter().map(|stop| stop.name.clone()).collect()),
            late_s: finite(record.late_s),
            steps: Some(plan.legs.iter().map(|leg| leg.plan.solution.steps).sum()),
            verified: verdicts.and_then(|verdicts| verdicts.into_iter().reduce(Verdict::worse)),
            ..Self::of(case, record.status.name(), record.exit_code)
        }
    }

    /// Creates the result of a case in which the program panicked because of a bug; the batch
    /// continues.
    pub(super) fn panicked(case: &Case) -> Self {
        Self::of(case, "internal_error", 1)
    }

    /// Creates the result of a planned case.
    pub(super) fn planned(case: &Case, problem: &Problem, plan: &Plan, times: bool) -> Self {
        let solution = &plan.solution;
        let known = solution.outcome == Outcome::Converged;
        // For a case that is proved infeasible, no search took place.
        let searched = solution.outcome != Outcome::Infeasible;
        Self {
            objective: Some(problem.objective.name().into()),
            cost: finite(solution.cost).filter(|_| known),
            duration_s: finite(solution.duration(problem)),
            steps: searched.then_some(solution.steps),
            method: searched.then(|| solution.method.name().into()),
            outcome: Some(solution.outcome),
            iterations: searched.then_some(solution.iterations),
            sense: known.then_some(solution.sense),
            turned_deg: finite(solution.turned_deg).filter(|_| known),
            terminal: finite(solution.terminal.largest()).map(|_| solution.terminal),
            proof: solution.proved(problem),
            second_order: known.then(|| solution.optimality.second_order()),
            gap: solution.switching.as_ref().filter(|_| known).and_then(|switching| finite(switching.gap)),
            verified: plan.verification.as_ref().map(Verdict::from),
            obstruction: solution.infeasible.as_ref().map(|proof| proof.reason.clone()),
            shortest_duration_s: solution.infeasible.as_ref().and_then(|proof| proof.duration_lower_bound),
            shortfall: solution.shortfall.as_ref().map(Shortfall::to_string),
            solve_time_s: times.then_some(solution.solve_time),
            ..Self::of(case, plan.status.name(), plan.status.exit_code())
        }
    }

    /// Returns whether the result has a plan that the witnesses have verified.
    pub fn is_solved(&self) -> bool {
        self.exit_code == 0
    }

    /// Returns the arguments of `--set`, one text `key=value` for each key, with which `slew plan`
    /// plans this case alone.
    pub fn settings(&self) -> impl Iterator<Item = String> {
        let text = |value: &Value| value.as_str().map_or_else(|| value.to_string(), String::from);
        self.set.iter().map(move |(key, value)| format!("{key}={}", text(value)))
    }
}

/// Converts a value in the notation of a spec to JSON: numbers and lists of numbers remain numbers,
/// any other value becomes a text.
fn readable(value: &str) -> Value {
    fn numbers(value: &Value) -> bool {
        value.is_number() || value.as_array().is_some_and(|items| items.iter().all(numbers))
    }
    let read = serde_json::from_str(value).ok().filter(numbers);
    read.unwrap_or_else(|| Value::String(value.into()))
}
