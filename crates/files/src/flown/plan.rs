//! Feedback gains and covariances along a plan, as plan files contain them.

use crate::export::nulls::null_is_nan;
use crate::spec::ClosedLoop;
use serde::{Deserialize, Serialize};
use slewkit::Vector3;
use slewkit::assured::{Beside, Margins, NotKnown};
use slewkit::closed_loop::Proportion;
use slewkit::feedback::{Arc, Gains, Kind};
use slewkit::maneuver::{Problem, Rule, Trajectory};
use slewkit::optimize::discrete::linear_plan::{Matrix6, PosedPlan, Vector6};
use slewkit::uncertainty::chance::{Chance, Quantity};
use slewkit::uncertainty::{Bounded, Covariance, Radius, Uncertainty};

/// Feedback gains K along a plan. The input is `input* - K [ζ; δΩ]`, with the planned input
/// `input*`, the attitude error ζ and the rate error δΩ. The errors are measured at the node at
/// which a step begins, and the input is held over this step.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct FeedbackRecord {
    /// Kind of the gains: "neighbouring", "tvlqr" or "switching".
    pub kind: String,
    /// Index of the first step with frozen gains. From this step on, each step has the gains of the
    /// step before it.
    pub frozen_from: usize,
    /// Number of steps between two measurements. A correction is held over these steps, which have
    /// equal gains. The value is 1 if the key is absent.
    #[serde(default = "one", skip_serializing_if = "is_one")]
    pub every_steps: usize,
    /// Gains for each step, with one row for each torque input. A row has three factors on the
    /// attitude error `ζ = log(R*ᵀR)` in body axes \[rad\] and three factors on the deviation of
    /// the rate from the plan in body axes \[rad/s\]. Neighbouring gains of a body with wheels have
    /// three more factors on the deviation of the wheel momentum in body axes \[N·m·s\]. If the
    /// body translates, there is a row for each input, forces before torques, which begins with
    /// three factors on the position \[m\] and three on the velocity \[m/s\].
    ///
    /// R* is the planned attitude in the continuous motion under the held inputs. This motion is
    /// recorded in the file, unless the discrete motion meets the target. In that case the discrete
    /// motion is recorded, and the continuous motion follows by integration of the held inputs.
    pub gains: Vec<Vec<Vec<f64>>>,
    /// Derivatives of the arc durations with respect to the initial state; empty unless the gains
    /// correct the switching times.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub arcs: Vec<ArcRecord>,
}

/// An arc of a plan with bang-bang inputs. If the initial state deviates slightly from the plan, by
/// the attitude error ζ and the rate error δΩ, the duration of the arc becomes
/// `length_s + gain [ζ; δΩ]`.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct ArcRecord {
    /// Index of the first step of the arc.
    pub first_step: usize,
    /// Planned duration of the arc \[s\].
    pub length_s: f64,
    /// Derivatives of the duration with respect to the initial errors in body axes: three for the
    /// attitude error `ζ = log(R*ᵀR)` \[s/rad\], then three for the rate error \[s/(rad/s)\].
    pub gain: [f64; 6],
}

fn one() -> usize {
    1
}

fn is_one(steps: &usize) -> bool {
    *steps == 1
}

/// Uncertainty along a plan, to first order in the errors.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct UncertaintyRecord {
    /// Uncertainty without feedback.
    #[serde(deserialize_with = "null_is_nan")]
    pub open_loop: LoopUncertainty,
    /// Uncertainty with the feedback gains of the plan; absent if the plan has no gains.
    #[serde(default, skip_serializing_if = "Option::is_none", deserialize_with = "null_is_nan")]
    pub closed_loop: Option<LoopUncertainty>,
    /// Margins that the chance constraints require; absent if the spec has no chance constraints.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub margins: Option<MarginsRecord>,
}

/// Uncertainty along a plan in one loop, open or closed.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct LoopUncertainty {
    /// Standard deviation of the attitude error at the end, in body axes \[deg\].
    pub end_attitude_sigma_deg: [f64; 3],
    /// Standard deviation of the angular velocity error at the end, in body axes \[deg/s\].
    pub end_rate_sigma_deg_s: [f64; 3],
    /// Bound on the attitude error at the end about each body axis \[deg\]. It holds if every
    /// uncertain quantity deviates by at most one standard deviation, with any distribution.
    pub end_attitude_bound_deg: [f64; 3],
    /// Names of the uncertain parameters, each with the fraction that it contributes to the three
    /// attitude variances and the three rate variances at the end.
    pub shares: Vec<(String, [f64; 6])>,
    /// Pointing error of each boresight at the end.
    pub pointing: Vec<PointingRecord>,
    /// Probability of violating each constraint, followed, in closed loop, by the probability of
    /// exceeding each torque limit.
    pub chances: Vec<ChanceRecord>,
    /// Standard deviation of the correction to each input, with one row for each step; empty in
    /// open loop.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub input_sigma: Vec<Vec<f64>>,
    /// Covariance of the attitude error ζ \[rad\] and the angular momentum error δΠ \[N·m·s\] at
    /// each node. The 21 numbers are the upper triangle of the 6 × 6 matrix, row by row.
    pub covariance: Vec<Vec<f64>>,
}

/// Predicted pointing error of a boresight.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct PointingRecord {
    /// Boresight, as a unit vector in body axes.
    pub boresight_body: [f64; 3],
    /// Standard deviations of the pointing error along the two axes of its error ellipse \[deg\].
    pub sigma_deg: [f64; 2],
    /// Angle that the pointing error does not exceed with a probability of 99.73 % \[deg\].
    pub within_9973_deg: f64,
}

/// Probability of violating a constraint or exceeding a torque limit along a plan.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct ChanceRecord {
    /// Name of the constraint or torque limit.
    pub name: String,
    /// Largest probability at any node or in any step.
    pub largest: f64,
    /// Time at which the probability is largest \[s\].
    pub time_s: f64,
    /// Unit of `sigma` and `room`: deg for cones, deg/s for rates, N·m or N·m/s for torque limits.
    pub unit: String,
    /// Standard deviation of the limited quantity at the time `time_s`.
    pub sigma: f64,
    /// Distance of the planned value from the limit at the time `time_s`; margins are not
    /// subtracted.
    pub room: f64,
    /// Probability at each node of the plan, or in each of its steps.
    pub nodes: Vec<f64>,
}

impl ChanceRecord {
    /// Creates the record of a probability along a plan; `times` are the times of its nodes \[s\].
    fn new(chance: Chance, times: &[f64]) -> Self {
        let (unit, of) = unit(chance.quantity);
        let worst = chance.worst();
        Self {
            largest: worst.chance,
            time_s: times[worst.node],
            unit: unit.into(),
            sigma: worst.sigma / of,
            room: worst.room / of,
            name: chance.name,
            nodes: chance.nodes,
        }
    }
}

/// Returns the name of the unit in which files give a limited quantity, and its value in SI units.
pub fn unit(quantity: Quantity) -> (&'static str, f64) {
    match quantity {
        Quantity::Angle => ("deg", 1_f64.to_radians()),
        Quantity::Rate => ("deg/s", 1_f64.to_radians()),
        Quantity::Torque => ("N·m", 1.0),
        Quantity::TorqueRate => ("N·m/s", 1.0),
    }
}

/// Fraction of the cases with some property, and its 95 % confidence interval.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Part {
    /// Number of cases with the property.
    pub count: u64,
    /// Fraction of all cases.
    pub part: f64,
    /// Clopper–Pearson interval with a confidence of 95 %.
    pub interval: [f64; 2],
}

impl From<Proportion> for Part {
    fn from(of: Proportion) -> Self {
        Self { count: of.count, part: of.part(), interval: [of.low, of.high] }
    }
}

/// Margin that a plan keeps below a limit.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct HeldRecord {
    /// Name of the limit.
    pub name: String,
    /// Unit of the numbers in `held` and `limit`.
    pub unit: String,
    /// Margin to the limit: one number for a cone or a norm limit, otherwise one for each component
    /// or input.
    pub held: Vec<f64>,
    /// Limit of the spacecraft, without the margin; empty for a cone.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub limit: Vec<f64>,
}

/// Margins with which a plan satisfies its chance constraints.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct MarginsRecord {
    /// Margin to each limit that has a chance constraint: the margin of a cone, or the reserve of a
    /// rate or torque limit.
    pub held: Vec<HeldRecord>,
    /// Cost of the plan without margins.
    pub cost_without: f64,
    /// Number of plans that were computed until margins and covariances were consistent.
    pub plans: usize,
    /// True if the margins and the covariances of the last plan are consistent.
    pub agreed: bool,
    /// For each probability over the whole motion: the name of the limit, or the names of the joint
    /// limits, and the fraction of the simulated flights that exceed it.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub counted: Vec<(String, Part)>,
}

impl MarginsRecord {
    /// Creates the record of the margins for the chance constraints of a spec.
    pub fn new(closed_loop: &ClosedLoop, margins: &Margins) -> Self {
        let counted = closed_loop.chances.iter().zip(&margins.counted);
        let held = margins.held.iter().map(|held| {
            let (unit, of) = unit(held.quantity);
            let told = |numbers: &[f64]| numbers.iter().map(|number| number / of).collect();
            let limit = if held.quantity == Quantity::Angle { Vec::new() } else { told(&held.bounds) };
            HeldRecord { name: held.name.clone(), unit: unit.into(), held: told(&held.parts), limit }
        });
        Self {
            counted: counted
                .filter_map(|(chance, counted)| Some((chance.limits.join(", "), (*counted)?.into())))
                .collect(),
            held: held.collect(),
            cost_without: margins.cost_without,
            plans: margins.plans,
            agreed: margins.agreed,
        }
    }
}

/// Returns the name of a kind of gains in files.
fn name(kind: &Kind) -> &'static str {
    match kind {
        Kind::Neighbouring { .. } => "neighbouring",
        Kind::Tvlqr(_) => "tvlqr",
        Kind::Switching(_) => "switching",
    }
}

impl FeedbackRecord {
    /// Creates the record of the gains in `beside`; `None` if the plan has no gains.
    pub fn new(problem: &Problem, beside: &Beside) -> Option<Self> {
        let arcs = beside.switching.iter().flat_map(|switching| {
            let gain = |arc: usize| of_rates(problem, switching.row(arc));
            let arc = move |(index, arc): (usize, &Arc)| ArcRecord {
                first_step: arc.first_step,
                length_s: arc.length,
                gain: std::array::from_fn(|column| gain(index)[column]),
            };
            switching.arcs.iter().enumerate().map(arc)
        });
        Some(Self { arcs: arcs.collect(), ..Self::of_gains(problem, beside.gains.as_ref()?) })
    }

    /// Creates the record of gains without corrections of switching times.
    pub fn of_gains(problem: &Problem, gains: &Gains) -> Self {
        let width = (gains.inputs * gains.states).max(1);
        let row = |row: &[f64]| of_rates(problem, row);
        let step = |step: &[f64]| step.chunks_exact(gains.states).map(row).collect();
        Self {
            kind: name(&gains.kind).into(),
            frozen_from: gains.frozen_from,
            every_steps: gains.every,
            gains: gains.rows.chunks_exact(width).map(step).collect(),
            arcs: Vec::new(),
        }
    }
}

/// Converts a row of gains on the errors of angular momentum Π and linear momentum γ to gains on
/// the errors of rate Ω and velocity v, which flight software measures: `K_Ω = K_Π J`,
/// `K_v = K_γ m`.
fn of_rates(problem: &Problem, row: &[f64]) -> Vec<f64> {
    let j = problem.body.inertia.j();
    let rotation = if row.len() == 12 { 6 } else { 0 };
    let by_rate = j * Vector3::from_column_slice(&row[rotation + 3..rotation + 6]);
    let mut out = row.to_vec();
    out[rotation + 3..rotation + 6].copy_from_slice(by_rate.as_slice());
    if let (6, Some(mass)) = (rotation, problem.body.mass) {
        out[3..6].iter_mut().for_each(|gain| *gain *= mass);
    }
    out
}

/// Computes feedback gains along a plan without a covariance, for a body that translates or whose
/// torques act about axes fixed in the reference frame. Returns `None` for other problems, whose
/// gains are in [`Beside`], and if the spec requests no gains.
pub fn gains_alone(
    problem: &Problem,
    plan: &Trajectory,
    closed_loop: &ClosedLoop,
) -> Option<Result<Gains, NotKnown>> {
    let feedback = closed_loop.feedback.filter(|_| PosedPlan::is_of(problem))?;
    Some(feedback.along_pose(problem, plan))
}

/// Returns true for plans that can have gains but no covariance: the body translates, or its
/// torques act about axes fixed in the reference frame.
pub fn is_posed(problem: &Problem) -> bool {
    PosedPlan::is_of(problem)
}

/// Returns the different boresights of the cones and of the end of a maneuver; the three body axes
/// if it has no boresight.
pub fn boresights(problem: &Problem) -> Vec<Vector3> {
    let mut all: Vec<Vector3> = problem.aim().map(|aim| aim.boresight).into_iter().collect();
    for constraint in &problem.constraints {
        if let Rule::Pointing(pointing) = &constraint.rule {
            all.extend(&pointing.boresights);
        }
    }
    let mut different: Vec<Vector3> = Vec::new();
    for boresight in all {
        if !different.contains(&boresight) {
            different.push(boresight);
        }
    }
    if different.is_empty() { vec![Vector3::x(), Vector3::y(), Vector3::z()] } else { different }
}

impl UncertaintyRecord {
    /// Creates the record of the uncertainty along a plan; `None` if the spec states no
    /// uncertainty.
    pub fn new(problem: &Problem, beside: &Beside, uncertainty: Option<&Uncertainty>) -> Option<Self> {
        let uncertainty = uncertainty?;
        let of = |covariance: &Covariance, gains: Option<&Gains>| {
            let bounded = Bounded::along(&beside.linear, gains, uncertainty);
            LoopUncertainty::new(problem, beside, covariance, &bounded, uncertainty)
        };
        let gains = beside.gains.as_ref();
        Some(Self {
            open_loop: of(beside.open.as_ref()?, None),
            closed_loop: beside.closed.as_ref().map(|covariance| of(covariance, gains)),
            margins: None,
        })
    }
}

fn of_three(vector: &Vector6, first: usize) -> [f64; 3] {
    [0, 1, 2].map(|row| vector[first + row].to_degrees())
}

impl LoopUncertainty {
    fn new(
        problem: &Problem,
        beside: &Beside,
        covariance: &Covariance,
        bounded: &Bounded,
        uncertainty: &Uncertainty,
    ) -> Self {
        let sigma = covariance.end_sigma();
        let of_attitude = covariance.end.fixed_view::<3, 3>(0, 0).into_owned();
        let pointing = boresights(problem).into_iter().map(|boresight| {
            let radius = Radius::of(&boresight, &of_attitude);
            PointingRecord {
                boresight_body: boresight.into(),
                sigma_deg: radius.sigma.map(f64::to_degrees),
                within_9973_deg: radius.within.to_degrees(),
            }
        });
        let mut chances = Chance::of_constraints(problem, &beside.linear, covariance);
        chances.extend(Chance::of_limits(problem, &beside.linear, covariance));
        let chances = chances.into_iter().map(|chance| ChanceRecord::new(chance, beside.linear.times()));
        Self {
            end_attitude_sigma_deg: of_three(&sigma, 0),
            end_rate_sigma_deg_s: of_three(&sigma, 3),
            end_attitude_bound_deg: [0, 1, 2].map(|axis| bounded.end[(axis, axis)].sqrt().to_degrees()),
            shares: covariance
                .shares(uncertainty)
                .into_iter()
                .map(|(name, share)| (name, share.into()))
                .collect(),
            pointing: pointing.collect(),
            chances: chances.collect(),
            input_sigma: covariance.inputs.clone(),
            covariance: covariance.states.iter().map(upper).collect(),
        }
    }
}

/// Returns the elements of the upper triangle of a matrix, row by row.
fn upper(matrix: &Matrix6) -> Vec<f64> {
    (0..6).flat_map(|row| (row..6).map(move |column| matrix[(row, column)])).collect()
}
