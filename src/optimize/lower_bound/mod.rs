//! Global lower bounds on the cost of every maneuver of a free body, in any homotopy class.
//!
//! Shooting finds local minima. This module bounds the global minimum from below by a moment
//! relaxation of the discrete problem itself, in the same discretisation as the plan:
//! [`lower_bound`]. For a free body everything is quadratic in the rotations of the steps
//! (`src/optimize/lower_bound/chain.rs`), and the polynomial problem relaxes to a semidefinite
//! program (`src/optimize/lower_bound/relaxation.rs`). Its dual solution is corrected into a proof
//! (`src/optimize/lower_bound/certificate.rs`), so the returned number is a bound even if the
//! solver reached only a reduced accuracy.
//!
//! # What a bound covers
//!
//! The implicit equation of a step has solutions that do not correspond to any continuous motion.
//! Without an angle range the bound covers these too ([`Relaxation::Shor`]) and lies far below
//! every physical maneuver. With `tr F_k ≥ 1 + 2 cos θ`, `θ ≤ 90°`, only the physical branch is
//! covered. If the cost of a maneuver is known, every cheaper maneuver turns so little in a step
//! that the range shrinks without loss, and the bound rises. [`LowerBound::step_angles`] and
//! [`LowerBound::coverage`] report which maneuvers the bound covers.
//!
//! # How tight
//!
//! [`LowerBound::gap`] measures the tightness. With one free rotation the localised relaxation was
//! exact in every case of the reference and in nearly all random ones. On longer chains it mixes
//! the short way with the long way if their costs are close and the steps large: the gap is 10–20 %
//! for a turn of 170° in 4 to 8 steps. On finer grids, with a known cost, the angle ranges are
//! small and the gap closes: 1e-7 in 12 and 16 steps for 60°, 120° and 170°
//! (`cargo run --release -p evidence --features sdp -- global_bound 16`). If
//! [`LowerBound::rank_one_defect`] is near zero, the relaxation has found one maneuver, not a
//! mixture.
//!
//! Needs the cargo feature `sdp`.

mod certificate;
mod chain;
mod polynomial;
mod range;
mod relaxation;
#[cfg(test)]
mod tests;

use crate::maneuver::problem::{Motion, Problem, ProblemError, Scheme};
use crate::mechanics::actuators::AxisFrame;
use crate::mechanics::body::principal_moments;
use crate::mechanics::drift_equation;
use crate::optimize::convex::cone::{Answer, Cone, ConeSettings, ConeSolver};
use crate::{Matrix3, Vector3, lie};
use certificate::{prove, rank_one_defect, unpacked};
use chain::{Chain, ChainData};
use range::Ends;
use relaxation::MomentProgram;
use serde::Serialize;
use std::f64::consts::FRAC_PI_2;
use thiserror::Error;

/// Conditions that the relaxation keeps; each variant contains the conditions of the variants
/// before it.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum Relaxation {
    /// Order 1 in the rotations, without an angle range; the bound holds on every branch of the
    /// implicit equation.
    Shor,
    /// Order 1 with the angle range of each step.
    Branch,
    /// Order 1 with the angle range multiplied into the moments of each clique.
    #[default]
    Localized,
    /// Order 2, localised. Available only if one rotation is free: three steps of Lie–Euler, two of
    /// Lie–Verlet.
    SecondOrder,
}

/// Settings of [`lower_bound`].
#[derive(Clone, Debug, PartialEq)]
pub struct BoundSettings {
    /// Relaxation to solve. Default: localised.
    pub relaxation: Relaxation,
    /// Largest angle of one step that is covered \[rad\], in (0, π/2]. Default π/2: the whole
    /// physical branch. A smaller angle gives a higher bound that holds for fewer maneuvers. Not
    /// used by [`Relaxation::Shor`].
    pub max_step_angle: f64,
    /// Cost of a known maneuver that solves the problem, in the problem's unit of cost; `None` by
    /// default. With a known cost the angle range of each step shrinks to the range that a cheaper
    /// maneuver can use. The bound still covers the whole physical branch.
    pub known_cost: Option<f64>,
    /// Tolerance of the cone solver. Default 1e-9.
    pub tolerance: f64,
    /// Wall-clock limit of the cone solver \[s\]. Default: unlimited.
    pub time_limit: Option<f64>,
}

impl Default for BoundSettings {
    fn default() -> Self {
        Self {
            relaxation: Relaxation::default(),
            max_step_angle: FRAC_PI_2,
            known_cost: None,
            tolerance: 1e-9,
            time_limit: None,
        }
    }
}

/// Set of maneuvers for which a bound holds.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum Coverage {
    /// Every solution of the discrete equations, on any branch of the implicit equation.
    AnyBranch,
    /// Every maneuver whose steps all turn by less than 90°: all maneuvers that the planner can
    /// return.
    PhysicalBranch,
    /// Only maneuvers whose steps stay within [`LowerBound::step_angles`].
    WithinAngles,
}

/// How the cone solver ended. The bound is proved however it ended.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum SolverEnd {
    /// The solver reached its tolerance.
    Solved,
    /// The solver reached only a reduced tolerance.
    AlmostSolved,
    /// The solver stopped early; its last dual vector was used.
    Stopped,
    /// The solver found the relaxation infeasible.
    Infeasible,
    /// The solver was not needed: the boundary conditions leave only one chain of rotations.
    NothingFree,
}

/// A proved lower bound of the discrete cost.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct LowerBound {
    /// Lower bound: no covered maneuver costs less. Unit of
    /// [`crate::maneuver::solution::Solution::cost`]. Infinite if it is proved that no covered
    /// maneuver exists.
    pub cost: f64,
    /// Dual objective of the solver, before the correction by its residuals.
    pub claimed: f64,
    /// Cost of a known maneuver, as in the settings; `None` if the settings contain no known cost.
    pub known_cost: Option<f64>,
    /// Gap relative to the known cost, `(known − bound)/known`; zero proves that the known maneuver
    /// is globally optimal. `None` without a known cost.
    pub gap: Option<f64>,
    /// Maneuvers that the bound covers.
    pub coverage: Coverage,
    /// Largest covered angle of each step of the grid \[rad\]; π if the step has no limit.
    pub step_angles: Vec<f64>,
    /// Largest ratio of the second largest to the largest eigenvalue among the moment matrices. The
    /// relaxation is exact if the ratio is near zero. `None` if the solver returned no point.
    pub rank_one_defect: Option<f64>,
    /// Relaxation that was solved.
    pub relaxation: Relaxation,
    /// How the cone solver ended.
    pub solver: SolverEnd,
    /// Number of solver iterations.
    pub iterations: u32,
    /// Number of moments, the variables of the semidefinite program.
    pub moments: usize,
    /// Wall-clock time in the cone solver \[s\].
    pub solve_time: f64,
}

/// Why no lower bound was computed.
#[derive(Clone, Debug, Error, PartialEq)]
pub enum BoundError {
    /// The problem is not valid.
    #[error(transparent)]
    Problem(#[from] ProblemError),
    /// The relaxation does not cover problems of this kind; the text states the reason.
    #[error("no lower bound: {0}")]
    NotCovered(&'static str),
    /// The problem has more steps than the relaxation supports.
    #[error("no lower bound on {steps} steps: at most {limit}; bound a coarser grid of the same maneuver")]
    TooManySteps {
        /// Number of steps of the problem.
        steps: usize,
        /// Largest number of steps of this relaxation.
        limit: usize,
    },
    /// A setting is out of range.
    #[error("{name} is {value}: {reason}")]
    Setting {
        /// Name of the setting.
        name: &'static str,
        /// Value of the setting.
        value: f64,
        /// Allowed range of the setting.
        reason: &'static str,
    },
    /// The cone solver returned no usable dual vector.
    #[error("no lower bound: the cone solver ended without a dual vector ({0})")]
    Solver(String),
}

/// Largest number of steps of the relaxations of order 1.
pub const MAX_STEPS: usize = 60;

/// Computes a lower bound on the cost of every maneuver that solves `problem` on its own grid and
/// scheme.
///
/// The bound is available for free bodies with torques along at least three independent axes, and
/// for single-axis turns about a principal axis. Input limits and pointing constraints are ignored,
/// because they can only increase the cost.
///
/// # Errors
/// A [`BoundError`] if the problem is not covered, a setting is out of range, or the solver failed.
pub fn lower_bound(problem: &Problem, settings: &BoundSettings) -> Result<LowerBound, BoundError> {
    problem.check()?;
    settings.check()?;
    let setup = Setup::new(problem, settings)?;
    let chain = Chain::new(&setup.data);
    let mut bound = LowerBound {
        cost: f64::INFINITY,
        claimed: f64::INFINITY,
        known_cost: settings.known_cost,
        gap: None,
        coverage: setup.coverage,
        step_angles: setup.step_angles.clone(),
        rank_one_defect: None,
        relaxation: settings.relaxation,
        solver: SolverEnd::NothingFree,
        iterations: 0,
        moments: 0,
        solve_time: 0.0,
    };
    match relaxation::build(&chain, settings.relaxation) {
        Some(moments) => {
            bound.moments = moments.program.linear.len();
            bound.solve(&moments, settings)?;
        }
        None => {
            if chain.limits.iter().all(|limit| limit.polynomial.constant_term() >= -NEGLIGIBLE) {
                bound.claimed = chain.cost.constant_term();
                bound.cost = bound.claimed - 128.0 * f64::EPSILON * chain.cost_magnitude;
            }
            bound.rank_one_defect = Some(0.0);
        }
    }
    // Convert to the problem's unit. The cost is a sum of squares, so zero is also a lower bound.
    bound.claimed *= setup.unit;
    bound.cost = (bound.cost * setup.unit).max(0.0);
    if let Some(known) = settings.known_cost {
        // Maneuvers outside the reduced range cost more than the known one.
        bound.cost = bound.cost.min(known);
        bound.gap = Some(if known > 0.0 { (known - bound.cost) / known } else { 0.0 });
    }
    Ok(bound)
}

/// Checks whether [`lower_bound`] covers a problem on its grid, without solving anything.
///
/// # Errors
/// The [`BoundError`] that [`lower_bound`] would return.
pub fn covered(problem: &Problem) -> Result<(), BoundError> {
    problem.check()?;
    Setup::new(problem, &BoundSettings::default()).map(|_| ())
}

/// Regularisations of the cone solver, tried from the most to the least often successful. Every
/// dual vector proves some bound; the highest proved bound is returned.
const REGULARIZATIONS: [f64; 3] = [1e-7, 1e-6, 1e-8];

/// Relative threshold below which asymmetries and coefficients count as round-off.
const NEGLIGIBLE: f64 = 1e-12;

/// Acceptable difference between the dual objective and the proved bound, relative to the dual
/// objective. A smaller difference ends the attempts.
const GOOD_LOSS: f64 = 1e-6;

impl LowerBound {
    /// Solves the relaxation and keeps the highest proved bound, in the units of the chain.
    fn solve(&mut self, moments: &MomentProgram, settings: &BoundSettings) -> Result<(), BoundError> {
        let mut proved = false;
        let mut failure = String::new();
        for regularization in REGULARIZATIONS {
            let left = settings.time_limit.map_or(f64::INFINITY, |limit| limit - self.solve_time);
            if left <= 0.0 {
                break;
            }
            let cone_settings = ConeSettings {
                tolerance: settings.tolerance,
                time_limit: left,
                regularization,
                ..ConeSettings::default()
            };
            let mut solver = ConeSolver::new(moments.program.clone(), &cone_settings)
                .map_err(|error| BoundError::Solver(error.to_string()))?;
            let answer = solver.solve();
            self.iterations += solver.work().iterations;
            self.solve_time += solver.work().seconds;
            let (z, end) = match &answer {
                Answer::Solved(optimum) => (&optimum.z, SolverEnd::Solved),
                Answer::AlmostSolved(optimum) => (&optimum.z, SolverEnd::AlmostSolved),
                Answer::Infeasible(z) => (z, SolverEnd::Infeasible),
                Answer::Failed { z: Some(z), .. } => (z, SolverEnd::Stopped),
                Answer::Failed { reason, z: None } => {
                    failure = format!("{reason:?}");
                    continue;
                }
            };
            let with_cost = end != SolverEnd::Infeasible;
            let Some(proof) = prove(moments, z, with_cost) else {
                failure = "a dual vector that is not finite".into();
                continue;
            };
            if !with_cost {
                if proof.bound > 0.0 {
                    (self.cost, self.claimed, self.solver) = (f64::INFINITY, f64::INFINITY, end);
                    return Ok(());
                }
                failure = "a certificate of infeasibility that proves nothing".into();
                continue;
            }
            if !proved || proof.bound > self.cost {
                (self.cost, self.claimed, self.solver) = (proof.bound, proof.claimed, end);
                self.rank_one_defect = answer.step().map(|optimum| largest_defect(moments, &optimum.s));
                proved = true;
            }
            if proof.claimed - proof.bound <= GOOD_LOSS * proof.claimed.abs() {
                break;
            }
        }
        if proved { Ok(()) } else { Err(BoundError::Solver(failure)) }
    }
}

/// Returns the largest rank-one defect of the moment matrices of the cliques.
fn largest_defect(moments: &MomentProgram, slack: &[f64]) -> f64 {
    let matrices = moments.program.parts(slack).filter_map(|(cone, part)| match cone {
        Cone::Semidefinite(n) => Some(unpacked(part, n)),
        _ => None,
    });
    let defects = matrices.take(moments.moment_matrices).map(|matrix| rank_one_defect(&matrix));
    defects.fold(0.0, |worst, defect| if defect > worst || defect.is_nan() { defect } else { worst })
}

impl BoundSettings {
    fn check(&self) -> Result<(), BoundError> {
        let (angle, tolerance) = (self.max_step_angle, self.tolerance);
        // A setting that is not given passes the checks.
        let (known, limit) = (self.known_cost.unwrap_or(0.0), self.time_limit.unwrap_or(f64::INFINITY));
        let checks = [
            (angle > 0.0 && angle <= FRAC_PI_2, "max_step_angle", angle, "must be in (0, π/2]"),
            (tolerance > 0.0 && tolerance < 1e-2, "tolerance", tolerance, "must be in (0, 0.01)"),
            (known >= 0.0 && known.is_finite(), "known_cost", known, "must be finite and not negative"),
            (limit > 0.0, "time_limit", limit, "must be positive"),
        ];
        match checks.into_iter().find(|(passed, ..)| !passed) {
            Some((_, name, value, reason)) => Err(BoundError::Setting { name, value, reason }),
            None => Ok(()),
        }
    }
}

/// The chain of a problem, and the units in which its results are expressed.
struct Setup {
    data: ChainData,
    /// Unit of cost: `J_mean² g / T³`, with the unit `g` of the torque weight.
    unit: f64,
    coverage: Coverage,
    step_angles: Vec<f64>,
}

/// Weight of the torque in the cost: `G = g Ĝ`.
struct Weight {
    /// Unit `g` of the weight.
    unit: f64,
    /// Normalised weight `Ĝ`.
    matrix: Matrix3,
    /// Smallest eigenvalue of `Ĝ` on the torques that the actuators can produce.
    smallest: f64,
    /// Axis about which torque acts if there is only one; `None` otherwise.
    axis: Option<Vector3>,
}

impl Setup {
    fn new(problem: &Problem, settings: &BoundSettings) -> Result<Self, BoundError> {
        let field = !problem.environment.is_free() || problem.environment.frame_rate() != Vector3::zeros();
        let foreign = [
            (problem.motion == Motion::RigidBody, "the body translates; only attitude maneuvers are covered"),
            (problem.objective.switches(), "time or fuel is minimised; only effort is covered"),
            (problem.seeks_duration(), "the duration is sought; only given ones are covered"),
            (problem.ends_in_any_attitude(), "any attitude will do at the end; only given ones are covered"),
            (problem.aim().is_some(), "the end is on a target; only given ones are covered"),
            (field, "a field acts on the body; only free bodies are covered"),
            (
                problem.actuation.wheels.is_some(),
                "reaction wheels store momentum; only external torques are covered",
            ),
        ];
        if let Some((_, reason)) = foreign.into_iter().find(|(is_foreign, _)| *is_foreign) {
            return Err(BoundError::NotCovered(reason));
        }
        let (steps, inertia) = (problem.steps, &problem.body.inertia);
        let limit = match (settings.relaxation, problem.scheme) {
            (Relaxation::SecondOrder, Scheme::LieEuler) => 3,
            (Relaxation::SecondOrder, Scheme::LieVerlet) => 2,
            _ => MAX_STEPS,
        };
        if steps > limit {
            return Err(BoundError::TooManySteps { steps, limit });
        }
        let weight = Weight::new(problem)?;
        let (mean, duration) = (inertia.mean(), problem.seconds());
        let h = problem.step();
        let j = inertia.j() / mean;
        let [start, end] = [&problem.start, &problem.end]
            .map(|state| (lie::project_to_rotation(&state.attitude), j * state.angular_velocity));
        let whole = start.0.transpose() * end.0;
        // Factors of the half kicks of Lie–Verlet: see the header of chain.rs.
        let verlet = problem.scheme == Scheme::LieVerlet;
        let mut data = ChainData {
            j_d: inertia.j_d() / mean,
            weight: weight.matrix,
            factor: 0.5 * (steps as f64).powi(3),
            before: h * start.1,
            after: h * end.1,
            end_factor: if verlet { 2.0 } else { 1.0 },
            whole,
            angles: Vec::new(),
            planar: false,
        };
        let mut fixed = None;
        if !verlet {
            let c = drift_equation::solve(&j, &(inertia.j_inverse() * mean), &data.before)
                .ok_or(BoundError::NotCovered("the first step is too long for the rate at the start"))?;
            let first = lie::cayley(&c);
            data.before = first.transpose() * data.before;
            data.whole = first.transpose() * whole;
            fixed = Some(2.0 * c.norm().atan());
        }

        // Angle ranges of the steps.
        let ends = settings.known_cost.map(|known| Ends {
            momenta: [start.0 * start.1, end.0 * end.1],
            duration,
            budget: 2.0 * known / (weight.smallest * weight.unit * mean * mean),
        });
        let smallest_moment = match weight.axis {
            Some(axis) => (j * axis).norm(),
            None => inertia.principal()[0] / mean,
        };
        let mut coverage = Coverage::PhysicalBranch;
        let (mut step_angles, first_free) = (Vec::new(), usize::from(!verlet));
        step_angles.extend(fixed);
        for step in first_free..steps {
            let angle = if settings.relaxation == Relaxation::Shor {
                coverage = Coverage::AnyBranch;
                std::f64::consts::PI
            } else {
                let t = h * (step as f64 + if verlet { 0.5 } else { 0.0 });
                let needed = ends.as_ref().map_or(FRAC_PI_2, |ends| ends.angle(t, h, smallest_moment));
                if needed > settings.max_step_angle {
                    coverage = Coverage::WithinAngles;
                }
                // An angle range of zero width would leave no scale for the moments.
                needed.min(settings.max_step_angle).max(1e-6)
            };
            data.angles.push(angle);
            step_angles.push(angle);
        }
        if let Some(axis) = weight.axis {
            data.turn_to_z(&axis)?;
        }
        Ok(Self { data, unit: mean * mean * weight.unit / duration.powi(3), coverage, step_angles })
    }
}

impl Weight {
    fn new(problem: &Problem) -> Result<Self, BoundError> {
        let weights = problem.objective.weights();
        let torque = weights.torque(&problem.actuation);
        let authority = &torque.authority;
        let principal = principal_moments(authority);
        let [low, middle, high] = [principal[0], principal[1], principal[2]];
        if torque.set.frame() == AxisFrame::Reference && high - low > NEGLIGIBLE * high {
            return Err(BoundError::NotCovered(
                "torques of unequal price along axes fixed to the reference frame",
            ));
        }
        if middle <= NEGLIGIBLE * high {
            // B W⁻¹ Bᵀ = a e eᵀ
            let column = authority.column_iter().max_by(|a, b| a.norm().total_cmp(&b.norm()));
            let axis = Some(column.map(|column| column.normalize()).unwrap_or_else(Vector3::z));
            return Ok(Self { unit: 1.0 / high, matrix: Matrix3::identity(), smallest: 1.0, axis });
        }
        if low <= 1e-9 * high {
            return Err(BoundError::NotCovered(
                "torques about two axes only; three or a single one are covered",
            ));
        }
        let unit = 3.0 / authority.trace();
        let inverse = (authority * unit).try_inverse();
        let matrix = inverse.ok_or(BoundError::NotCovered("the torque axes are nearly dependent"))?;
        Ok(Self {
            unit,
            matrix: 0.5 * (matrix + matrix.transpose()),
            smallest: 1.0 / (high * unit),
            axis: None,
        })
    }
}

impl ChainData {
    /// Rotates the body axes so that the single axis of torque becomes z; fails unless the whole
    /// maneuver is about this axis.
    fn turn_to_z(&mut self, axis: &Vector3) -> Result<(), BoundError> {
        let other = if axis.x.abs() < 0.6 { Vector3::x() } else { Vector3::y() };
        let x = (other - axis * axis.dot(&other)).normalize();
        let c = Matrix3::from_rows(&[x.transpose(), axis.cross(&x).transpose(), axis.transpose()]);
        let j_d = c * self.j_d * c.transpose();
        let (before, after) = (c * self.before, c * self.after);
        let whole = c * self.whole * c.transpose();
        let off = |vector: &Vector3| vector.x.hypot(vector.y);
        let tilted = j_d[(0, 2)].hypot(j_d[(1, 2)]) > NEGLIGIBLE * j_d.norm()
            || off(&before) > NEGLIGIBLE * before.norm()
            || off(&after) > NEGLIGIBLE * after.norm()
            || off(&whole.column(2).into_owned()) > NEGLIGIBLE;
        if tilted {
            return Err(BoundError::NotCovered("one axis of torque, and a turn that is not about it"));
        }
        *self = Self { j_d, before, after, whole, planar: true, ..self.clone() };
        Ok(())
    }
}
