//! The lines of a file of results: a header, then one line a case.

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

/// The first line: which batch the results are of.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Header {
    /// Version of the format, [`Header::FORMAT`]; its key identifies the file.
    pub slew_results: u32,
    /// The program that plans.
    pub generator: String,
    /// The source of the cases.
    pub kind: Kind,
    /// File name of the spec, or name of the folder, without its path.
    pub spec: String,
    /// Number of cases of the whole batch.
    pub cases: u64,
    /// Keys that the cases set, in the order of their columns; empty for a folder.
    pub keys: Vec<String>,
    /// Hash of the spec, of all set values, and of the program.
    pub fingerprint: String,
    /// Lines hold wall times, which differ between runs.
    #[serde(default, skip_serializing_if = "std::ops::Not::not")]
    pub times: bool,
    /// The shard of the batch; absent if the batch is not divided.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub shard: Option<Shard>,
}

impl Header {
    /// The version written and read.
    pub const FORMAT: u32 = 1;
}

/// The result of one case.
///
/// All numbers equal the numbers of the plan file. A number that does not exist is absent: without
/// a plan, a result has neither a cost nor an error.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct CaseResult {
    /// Number of the case, from 1.
    pub case: u64,
    /// Name of the case: from the table's column `name`, or of the file in a folder.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub name: Option<String>,
    /// The keys that the case sets, with their values; texts as in `--set`.
    #[serde(default, skip_serializing_if = "Map::is_empty")]
    pub set: Map<String, Value>,
    /// "solved", "infeasible", …, "spec_invalid": the statuses of the exit codes.
    pub status: String,
    /// The exit code that `slew plan` ends with on this case.
    pub exit_code: u8,
    /// The error of the spec of the case.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub error: Option<CaseError>,
    /// The objective: "effort", "time" or "fuel". Costs of different objectives cannot be
    /// compared.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub objective: Option<String>,
    /// Cost of the plan, converged.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub cost: Option<f64>,
    /// The duration of the plan, or the requested one \[s\]; of a sequence with its holds.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub duration_s: Option<f64>,
    /// The stops of a sequence in the order in which they are visited.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub stops: Option<Vec<String>>,
    /// By how much the windows of a sequence are missed, in all \[s\].
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub late_s: Option<f64>,
    /// Number of steps, of all legs.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub steps: Option<usize>,
    /// "shooting", "scp" or "interior_point".
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub method: Option<String>,
    /// The outcome of the solve.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub outcome: Option<Outcome>,
    /// Newton iterations of the winning start.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub iterations: Option<usize>,
    /// The way round.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub sense: Option<Sense>,
    /// Total angle turned \[deg\].
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub turned_deg: Option<f64>,
    /// Discrete terminal error.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub terminal: Option<TerminalError>,
    /// The degree to which the plan is proved to be an optimum.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub proof: Option<Proved>,
    /// "minimum", "saddle", "undecided" or "not_tested".
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub second_order: Option<SecondOrder>,
    /// The cost that neighbouring plans can save, to first order, if inputs switch; such a plan has
    /// no second-order test.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub gap: Option<f64>,
    /// The results of the witnesses.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub verified: Option<Verdict>,
    /// The proof that no plan exists, if one was found.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub obstruction: Option<String>,
    /// A duration below which no plan exists \[s\], as proved.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub shortest_duration_s: Option<f64>,
    /// The remaining violations of the nearest iterate.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub shortfall: Option<String>,
    /// The wall time of the solve \[s\], if times are requested.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub solve_time_s: Option<f64>,
}

/// The first error of the spec of a case.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct CaseError {
    /// Stable code.
    pub code: String,
    /// Key path; empty when the error concerns no key.
    pub key: String,
    /// The reason, with the numbers.
    pub reason: String,
    /// The next thing to do.
    pub remedy: String,
    /// The number of further errors.
    pub more: usize,
}

/// The results of the witnesses for a plan.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Verdict {
    /// Whether every check holds.
    pub passed: bool,
    /// Names of the checks that do not hold.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub failed: Vec<String>,
    /// Attitude error of the discrete witness \[rad\]; absent if it did not reach the end.
    pub discrete_attitude_rad: Option<f64>,
    /// Attitude error of the continuous motion under the held torque \[deg\].
    pub continuous_attitude_deg: Option<f64>,
    /// Observed order of convergence; absent at round-off.
    pub order: Option<f64>,
    /// Largest norm of the torque at the nodes [N·m].
    pub peak_torque_n_m: Option<f64>,
    /// Largest norm of the angular velocity at the nodes [deg/s].
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
    /// Returns what holds for two parts of a sequence: the larger one of each error.
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
            // An order is of one motion.
            order: None,
            peak_torque_n_m: larger(self.peak_torque_n_m, other.peak_torque_n_m),
            peak_rate_deg_s: larger(self.peak_rate_deg_s, other.peak_rate_deg_s),
        }
    }
}

/// Returns the number if it is finite: JSON has no NaN.
fn finite(value: f64) -> Option<f64> {
    value.is_finite().then_some(value)
}

impl CaseResult {
    /// Builds a result that only identifies its case.
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

    /// Builds the result of a case with a wrong spec.
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

    /// Builds the result of a case that the planner refuses, although its spec is valid.
    pub(super) fn refused(case: &Case, code: &str, reason: String) -> Self {
        let remedy = "change the spec accordingly".into();
        let error = CaseError { code: code.into(), key: String::new(), reason, remedy, more: 0 };
        Self { error: Some(error), ..Self::of(case, "spec_invalid", 3) }
    }

    /// Builds the result of a sequence without a plan.
    pub(super) fn without_plan(case: &Case, status: Status, reason: String) -> Self {
        let is_proved = status == Status::Infeasible;
        let (obstruction, shortfall) = if is_proved { (Some(reason), None) } else { (None, Some(reason)) };
        Self { obstruction, shortfall, ..Self::of(case, status.name(), status.exit_code()) }
    }

    /// Builds the result of a sequence that was planned.
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

    /// Builds a case at which the program failed: a bug, which must not take the other cases with
    /// it.
    pub(super) fn panicked(case: &Case) -> Self {
        Self::of(case, "internal_error", 1)
    }

    /// Builds the result of a case that was planned.
    pub(super) fn planned(case: &Case, problem: &Problem, plan: &Plan, times: bool) -> Self {
        let solution = &plan.solution;
        let known = solution.outcome == Outcome::Converged;
        // A case that is proved infeasible was not searched for.
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

    /// Returns whether the result has a plan that the witnesses confirm.
    pub fn is_solved(&self) -> bool {
        self.exit_code == 0
    }

    /// Returns the `--set` values that plan the case alone: `key=value` for each key.
    pub fn settings(&self) -> impl Iterator<Item = String> {
        let text = |value: &Value| value.as_str().map_or_else(|| value.to_string(), String::from);
        self.set.iter().map(move |(key, value)| format!("{key}={}", text(value)))
    }
}

/// Returns a value for the next program: numbers and lists of numbers as such, other values as
/// written.
fn readable(value: &str) -> Value {
    fn numbers(value: &Value) -> bool {
        value.is_number() || value.as_array().is_some_and(|items| items.iter().all(numbers))
    }
    let read = serde_json::from_str(value).ok().filter(numbers);
    read.unwrap_or_else(|| Value::String(value.into()))
}
