//! Gains and covariances in a plan file.

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

/// Gains along a plan: `input = input* - K [ζ; δΩ]`, measured at the node at which a step begins
/// and held over that step.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct FeedbackRecord {
    /// "neighbouring", "tvlqr" or "switching".
    pub kind: String,
    /// The first step whose gains repeat the gains of the step before it.
    pub frozen_from: usize,
    /// The number of steps between measurements, over which a correction is held; their gains are
    /// equal. 1 if absent.
    #[serde(default = "one", skip_serializing_if = "is_one")]
    pub every_steps: usize,
    /// For each step a row for each torque input: three numbers by `ζ = log(R*ᵀR)`, body axes
    /// \[rad\], three by the deviation of the rate from the plan, body axes [rad/s]. Neighbouring
    /// gains of wheels have three more by the deviation of their momentum, body axes [N·m·s].
    /// Bodies that translate have a row for each input, forces first, with six numbers before
    /// these, by position \[m\] and velocity [m/s].
    ///
    /// The plan is here the true motion under the held inputs, with the attitude R*. That is the
    /// recorded one, but if the target is the discrete motion: then the discrete motion is
    /// recorded, and the true one follows by integration of the held inputs.
    pub gains: Vec<Vec<Vec<f64>>>,
    /// The derivatives of the lengths of arcs by the start, if it is corrected.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub arcs: Vec<ArcRecord>,
}

/// An arc of a plan whose inputs switch. From a start near the start of the plan its length is
/// `length_s + gain [ζ; δΩ]`.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct ArcRecord {
    /// Number of the first step of the arc.
    pub first_step: usize,
    /// The length of the arc in the plan \[s\].
    pub length_s: f64,
    /// Three numbers by `ζ = log(R*ᵀR)` at the start, body axes [s/rad], three by the rate
    /// [s/(rad/s)].
    pub gain: [f64; 6],
}

fn one() -> usize {
    1
}

fn is_one(steps: &usize) -> bool {
    *steps == 1
}

/// The uncertainty along a plan, to first order.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct UncertaintyRecord {
    /// The results without gains.
    #[serde(deserialize_with = "null_is_nan")]
    pub open_loop: LoopUncertainty,
    /// The results with the gains of the plan.
    #[serde(default, skip_serializing_if = "Option::is_none", deserialize_with = "null_is_nan")]
    pub closed_loop: Option<LoopUncertainty>,
    /// The margins of chance constraints, if the spec has any.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub margins: Option<MarginsRecord>,
}

/// The uncertainty of a loop.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct LoopUncertainty {
    /// One standard deviation of the attitude at the end, body axes \[deg\].
    pub end_attitude_sigma_deg: [f64; 3],
    /// The deviation of the angular velocity at the end [deg/s].
    pub end_rate_sigma_deg_s: [f64; 3],
    /// Half the extent of the attitude's ellipsoid at the end along the body axes \[deg\], if every
    /// error is anywhere within one deviation, without a distribution.
    pub end_attitude_bound_deg: [f64; 3],
    /// The part of each of these six variances that a parameter causes, for each parameter.
    pub shares: Vec<(String, [f64; 6])>,
    /// The pointing error of each boresight at the end.
    pub pointing: Vec<PointingRecord>,
    /// The chance of each constraint, then of each limit of the torques with gains.
    pub chances: Vec<ChanceRecord>,
    /// One standard deviation of the correction of each input, a row for each step; empty in
    /// open loop.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub input_sigma: Vec<Vec<f64>>,
    /// Covariance of `[ζ; δΠ]` at each node: 21 numbers, the upper triangle row after row [rad,
    /// N·m·s].
    pub covariance: Vec<Vec<f64>>,
}

/// The pointing error of a boresight.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct PointingRecord {
    /// The boresight, body axes.
    pub boresight_body: [f64; 3],
    /// Standard deviations along the axes of its ellipse on the sky \[deg\].
    pub sigma_deg: [f64; 2],
    /// The angle within which the boresight is with the probability 99.73 % \[deg\].
    pub within_9973_deg: f64,
}

/// The chance of violating a constraint, or of exceeding a limit of the torques.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct ChanceRecord {
    /// The name of the constraint or limit.
    pub name: String,
    /// The largest of all nodes.
    pub largest: f64,
    /// The time of the largest chance \[s\].
    pub time_s: f64,
    /// The unit of the next two: deg of cones, deg/s of rates, N·m, N·m/s.
    pub unit: String,
    /// One standard deviation of the limited quantity at that time.
    pub sigma: f64,
    /// The distance of the plan from the limit at that time, without margin.
    pub room: f64,
    /// The chance at each node, or in each step.
    pub nodes: Vec<f64>,
}

impl ChanceRecord {
    /// Builds the record of a chance along a plan with these nodes \[s\].
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

/// Returns the unit of a limit in files, and its size in SI.
pub fn unit(quantity: Quantity) -> (&'static str, f64) {
    match quantity {
        Quantity::Angle => ("deg", 1_f64.to_radians()),
        Quantity::Rate => ("deg/s", 1_f64.to_radians()),
        Quantity::Torque => ("N·m", 1.0),
        Quantity::TorqueRate => ("N·m/s", 1.0),
    }
}

/// A part of the cases with its interval of 95 %.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Part {
    /// The number of cases.
    pub count: u64,
    /// The proportion.
    pub part: f64,
    /// The interval of Clopper and Pearson.
    pub interval: [f64; 2],
}

impl From<Proportion> for Part {
    fn from(of: Proportion) -> Self {
        Self { count: of.count, part: of.part(), interval: [of.low, of.high] }
    }
}

/// The part of a limit that a plan holds in reserve.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct HeldRecord {
    /// The name of the limit.
    pub name: String,
    /// The unit of the numbers.
    pub unit: String,
    /// One number for a cone or a norm, else one for each component or input.
    pub held: Vec<f64>,
    /// The limits of the craft; empty for a cone.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub limit: Vec<f64>,
}

/// The margins that chance constraints need.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct MarginsRecord {
    /// The margin or reserve of each limit with a chance: the margin of a cone, the reserve of a
    /// rate or a torque.
    pub held: Vec<HeldRecord>,
    /// Cost of the plan without margins.
    pub cost_without: f64,
    /// Plans until margins and covariances agreed.
    pub plans: usize,
    /// Whether they agreed.
    pub agreed: bool,
    /// For each chance over the whole motion: the limit, or the joint limits, and the proportion
    /// of flights of the plan that exceed it.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub counted: Vec<(String, Part)>,
}

impl MarginsRecord {
    /// Builds the record for the chances of a spec.
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

/// Returns the name of a kind of gains.
fn name(kind: &Kind) -> &'static str {
    match kind {
        Kind::Neighbouring { .. } => "neighbouring",
        Kind::Tvlqr(_) => "tvlqr",
        Kind::Switching(_) => "switching",
    }
}

impl FeedbackRecord {
    /// Builds the record of the gains along a plan; `None` without gains.
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

    /// Builds the record of gains alone.
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

/// Converts a row by momenta to one by rates, which flight software measures: `K_Ω = K_Π J`,
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

/// Designs gains along a plan without a covariance: for a body that translates, or torques fixed
/// in the reference frame. Returns `None` for other plans, whose gains are in [`Beside`].
pub fn gains_alone(
    problem: &Problem,
    plan: &Trajectory,
    closed_loop: &ClosedLoop,
) -> Option<Result<Gains, NotKnown>> {
    let feedback = closed_loop.feedback.filter(|_| PosedPlan::is_of(problem))?;
    Some(feedback.along_pose(problem, plan))
}

/// Returns whether a plan has gains alone: of a body that translates, or under torques fixed in the
/// reference frame.
pub fn is_posed(problem: &Problem) -> bool {
    PosedPlan::is_of(problem)
}

/// Returns the boresights of the cones and of the end of a maneuver; the body axes if it has no
/// boresight.
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
    /// Builds the record of the uncertainty along a plan; `None` without uncertainty.
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

/// Returns the upper triangle, row after row.
fn upper(matrix: &Matrix6) -> Vec<f64> {
    (0..6).flat_map(|row| (row..6).map(move |column| matrix[(row, column)])).collect()
}
