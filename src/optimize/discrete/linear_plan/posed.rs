//! The linearised motion near a plan whose input axes rotate relative to the coordinates, or of a
//! body that translates. Forces and torques act along axes that are fixed in the body or in the
//! reference frame, and are held over the steps.
//!
//! ```text
//! z = [x − x*; γ − γ*; log(R*ᵀR); Π − Π*]  (N = 12),  or its last six numbers (N = 6)
//! ```
//!
//! The output of such an input depends on the attitude: `E = Rᵀ` for torques fixed in the reference
//! frame, `E = R` for forces fixed in the body. That adds `∂(E u)/∂q` to the gradient of a kick,
//! and the second derivatives `∂(λ·E u)/∂q²`, `∂(λ·E)/∂q` (`linear_plan::stage`).

use super::authority::Law;
use super::{MOST_STEPS, Parts, Stage, Unlinearised};
use crate::flight::Flight;
use crate::lie::{self, hat};
use crate::maneuver::duration::Duration;
use crate::maneuver::grid::{Grid, Scheme};
use crate::maneuver::problem::{Motion, Problem, State};
use crate::maneuver::solution::Trajectory;
use crate::mechanics::actuators::AxisFrame;
use crate::mechanics::environment::{Blocks, Pose, Wrench};
use crate::optimize::discrete::step::{Costate, Dynamics, Units};
use crate::{Matrix3, Vector3};
use nalgebra::{DMatrix, SMatrix, SVector};

/// Linearised motion near a plan, with 6 or 12 states.
#[derive(Clone, Debug)]
pub struct PosedPlan {
    pub(crate) units: Units,
    /// `J`, which maps rates in rad/s to scaled momenta.
    pub(crate) momentum_of_rate: Matrix3,
    pub(crate) stages: Stages,
    /// `W⁻¹Bᵀ` of the inputs that are not at their limits, for each step: it maps a scaled dual
    /// vector to inputs in SI units.
    pub(crate) to_inputs: Vec<DMatrix<f64>>,
}

/// Linearised steps: of the attitude alone (6 states), or of position and attitude (12 states).
#[derive(Clone, Debug)]
pub(crate) enum Stages {
    Attitude(Vec<Stage<6, 3>>),
    Pose(Vec<Stage<12, 6>>),
}

impl PosedPlan {
    /// Returns whether plans of `problem` need this type in place of `LinearPlan`: the body
    /// translates, or its torques are fixed in the reference frame.
    pub fn is_of(problem: &Problem) -> bool {
        problem.motion == Motion::RigidBody || problem.actuation.torque.frame() == AxisFrame::Reference
    }

    /// Linearises the motion about `plan`, a trajectory of `problem` on its own grid. The costates
    /// of the plan are used as the costates at its nodes.
    ///
    /// # Errors
    /// [`Unlinearised`] if the maneuver has wheels, or thrusters that exert force and torque at
    /// once, or if the trajectory does not fit the problem.
    pub fn new(problem: &Problem, plan: &Trajectory) -> Result<Self, Unlinearised> {
        Self::beside(problem, plan, false)
    }

    fn beside(problem: &Problem, plan: &Trajectory, beyond: bool) -> Result<Self, Unlinearised> {
        Self::fits(problem, plan)?;
        let duration = *plan.time.last().unwrap_or(&f64::NAN);
        let problem = &Problem { duration: Duration::Given(duration), ..problem.clone() };
        let count = plan.time.len() - 1;
        let scheme = if problem.switches() { Scheme::LieVerlet } else { problem.scheme };
        let units = Units::of(problem);
        let grid = if problem.switches() {
            let lengths: Vec<f64> = plan.time.windows(2).map(|ends| ends[1] - ends[0]).collect();
            let grid = Grid::of_lengths(scheme, &lengths).map_err(|_| Unlinearised::Step)?;
            grid.with_duration(duration / units.time)
        } else {
            Grid::uniform(scheme, duration / units.time, count)
        };
        let beside = Beside { dynamics: Dynamics::on(problem, grid), problem, plan, beyond };
        let mut to_inputs = Vec::with_capacity(count);
        let stages = match problem.motion {
            Motion::Attitude => Stages::Attitude(beside.stages(count, &mut to_inputs)?),
            Motion::RigidBody => Stages::Pose(beside.stages(count, &mut to_inputs)?),
        };
        let momentum_of_rate = beside.dynamics.j * units.time;
        Ok(Self { units, momentum_of_rate, stages, to_inputs })
    }

    /// Linearises the motion about the flown motion: the true motion under the plan's inputs, held
    /// over the steps.
    ///
    /// # Errors
    /// The errors of [`PosedPlan::new`].
    pub fn flown(problem: &Problem, plan: &Trajectory) -> Result<Self, Unlinearised> {
        Self::fits(problem, plan)?;
        let recorded = Flight::recorded(problem, plan).ok_or(Unlinearised::Step)?;
        Self::beside(problem, &recorded, super::records_beyond_nodes(problem))
    }

    fn fits(problem: &Problem, plan: &Trajectory) -> Result<(), Unlinearised> {
        if problem.actuation.wheels.is_some() {
            return Err(Unlinearised::Wheels);
        }
        if problem.actuation.thrusters.is_some() {
            return Err(Unlinearised::Thrusters);
        }
        let count = plan.time.len().saturating_sub(1);
        let places = if problem.motion == Motion::RigidBody { count + 1 } else { 0 };
        let m = problem.actuation.count();
        let rows = if problem.switches() { count } else { problem.scheme.input_rows(count) };
        let fits = count > 0
            && plan.quaternion.len() == count + 1
            && plan.angular_velocity.len() == count + 1
            && plan.position.len() >= places
            && plan.velocity.len() >= places
            && plan.input_count == m
            && plan.input.len() >= rows * m;
        match (fits, count > MOST_STEPS) {
            (false, _) => Err(Unlinearised::Trajectory),
            (true, true) => Err(Unlinearised::Fine),
            (true, false) => Ok(()),
        }
    }

    /// Returns the number of steps.
    pub fn count(&self) -> usize {
        self.to_inputs.len()
    }

    /// Returns the number of components of `z`: 6 or 12.
    pub fn states(&self) -> usize {
        match &self.stages {
            Stages::Attitude(_) => 6,
            Stages::Pose(_) => 12,
        }
    }

    /// Returns the SI unit of component `row` of the state `z`.
    pub(crate) fn unit(&self, row: usize) -> f64 {
        let units = [self.units.length, self.units.linear_momentum(), 1.0, self.units.momentum()];
        units[(row + 12 - self.states()) / 3]
    }

    /// Returns `A_k`, the derivative of the next state with respect to the state; states are in m,
    /// N·s, rad and N·m·s.
    pub fn a(&self, step: usize) -> DMatrix<f64> {
        let scaled = match &self.stages {
            Stages::Attitude(stages) => DMatrix::from_column_slice(6, 6, stages[step].a.as_slice()),
            Stages::Pose(stages) => DMatrix::from_column_slice(12, 12, stages[step].a.as_slice()),
        };
        DMatrix::from_fn(self.states(), self.states(), |row, column| {
            scaled[(row, column)] * self.unit(row) / self.unit(column)
        })
    }

    /// Returns `B_k`, the derivative of the next state with respect to forces \[N\] and torques
    /// [N·m] along the axes of their actuator sets: N×6, or N×3 for torques alone.
    pub fn b(&self, step: usize) -> DMatrix<f64> {
        let scaled = match &self.stages {
            Stages::Attitude(stages) => DMatrix::from_column_slice(6, 3, stages[step].b.as_slice()),
            Stages::Pose(stages) => DMatrix::from_column_slice(12, 6, stages[step].b.as_slice()),
        };
        let forces = scaled.ncols() - 3;
        let unit = |column: usize| if column < forces { self.units.force() } else { self.units.torque() };
        DMatrix::from_fn(self.states(), scaled.ncols(), |row, column| {
            scaled[(row, column)] * self.unit(row) / unit(column)
        })
    }
}

/// A plan of a maneuver to be linearised.
struct Beside<'a> {
    dynamics: Dynamics,
    problem: &'a Problem,
    plan: &'a Trajectory,
    /// Whether the recorded costates are half a kick beyond the nodes.
    beyond: bool,
}

/// Kick under held inputs: its wrench, its gradient with respect to the state, and its derivative
/// with respect to the inputs.
struct Held<const N: usize, const C: usize> {
    wrench: Wrench,
    gradient: SMatrix<f64, N, N>,
    inputs: SMatrix<f64, N, C>,
}

impl Beside<'_> {
    fn stages<const N: usize, const C: usize>(
        &self,
        count: usize,
        to_inputs: &mut Vec<DMatrix<f64>>,
    ) -> Result<Vec<Stage<N, C>>, Unlinearised> {
        let (problem, units) = (self.problem, &self.dynamics.units);
        let weights = problem.objective.weights();
        let switches = problem.switches();
        let of_torque = Law::of(problem, units);
        let of_force = weights.force(&problem.actuation).map(|weighted| {
            Law::of_set(&weighted, switches, units.cost, [units.linear_momentum(), units.force()])
        });
        let mut stages = Vec::with_capacity(count);
        for k in 0..count {
            let inputs = self.held(k);
            let (force, torque) = problem.actuation.split(&inputs);
            let mut authority = SMatrix::<f64, C, C>::zeros();
            let mut gain = DMatrix::zeros(inputs.len(), C);
            let (of_one, answer) = of_torque.at(torque);
            authority.view_mut((C - 3, C - 3), (3, 3)).copy_from(&of_one);
            gain.view_mut((force.len(), C - 3), (torque.len(), 3)).copy_from(&answer);
            if let (6, Some(law)) = (C, &of_force) {
                let (of_one, answer) = law.at(force);
                authority.view_mut((0, 0), (3, 3)).copy_from(&of_one);
                gain.view_mut((0, 0), (force.len(), 3)).copy_from(&answer);
            }
            let parts = self.parts(k, force, torque)?;
            stages.push(Stage::of(&parts, authority, self.dynamics.grid.step(k)));
            to_inputs.push(gain);
        }
        Ok(stages)
    }

    /// Returns the inputs that are held over step k.
    fn held(&self, k: usize) -> Vec<f64> {
        let first = self.problem.scheme.first_input();
        if first == 0 && !self.problem.switches() {
            let mean = |(a, b): (&f64, &f64)| 0.5 * (a + b);
            return self.plan.inputs(k).iter().zip(self.plan.inputs(k + 1)).map(mean).collect();
        }
        self.plan.inputs(k).to_vec()
    }

    fn state(&self, node: usize) -> State {
        let of = |places: &[Vector3], own: Vector3| places.get(node).copied().unwrap_or(own);
        State {
            position: of(&self.plan.position, self.problem.start.position),
            velocity: of(&self.plan.velocity, self.problem.start.velocity),
            attitude: lie::rotation_from_quaternion(&self.plan.quaternion[node]),
            angular_velocity: self.plan.angular_velocity[node],
        }
    }

    fn parts<const N: usize, const C: usize>(
        &self,
        k: usize,
        force: &[f64],
        torque: &[f64],
    ) -> Result<Parts<N, C>, Unlinearised> {
        let (dynamics, units, actuation) = (&self.dynamics, &self.dynamics.units, &self.problem.actuation);
        let half = 0.5 * dynamics.grid.step(k);
        let along = [
            actuation.force.as_ref().map_or_else(Vector3::zeros, |set| set.output(force) / units.force()),
            actuation.torque.output(torque) / units.torque(),
        ];
        let mut point = dynamics.point(&self.state(k));
        let poses = [point.pose(), dynamics.point(&self.state(k + 1)).pose()];
        let [first, last] = poses.each_ref().map(|pose| self.kicked::<N, C>(pose, &along));
        point.momentum.add(&(half * first.wrench.moment));
        point.linear_momentum.add(&(half * first.wrench.force));
        let kicks = [&first, &last].map(|held| SMatrix::identity() + held.gradient * half);
        let row = if self.problem.switches() { k + 1 } else { k + 1 - self.problem.scheme.first_input() };
        let recorded = self.plan.costates.get(N * row..N * (row + 1));
        let costate = recorded.map_or_else(SVector::<f64, N>::zeros, |row| {
            SVector::<f64, N>::from_column_slice(row).component_div(&units.costate::<N>())
        });
        // The held torques and forces of the steps before and after a node differ by a term of
        // first order in the step length.
        let costate = if self.beyond { kicks[1].tr_mul(&costate) } else { costate };
        let between = kicks[1].tr_mul(&costate);
        let drift = dynamics.drift::<N>(k, &mut point)?;
        let e = dynamics.drift_matrix(&drift);
        let [matrix, curvature] =
            dynamics.linear_drift(&drift, &e, &Costate::from_vector(&between)).matrices::<N>();
        let costates = [Costate::from_vector(&matrix.tr_mul(&between)), Costate::from_vector(&costate)];
        let bent = |end: usize| self.bent::<N, C>(&poses[end], &along, &costates[end]);
        let ((bend, mixed), (last_bend, last_mixed)) = (bent(0), bent(1));
        Ok(Parts {
            kicks,
            drift: matrix,
            curvature,
            inputs: [first.inputs * half, last.inputs * half],
            bends: [bend * half, last_bend * half],
            mixed: [mixed * half, last_mixed * half],
        })
    }

    fn frames(&self) -> (AxisFrame, AxisFrame) {
        let actuation = &self.problem.actuation;
        let force = actuation.force.as_ref().map_or(AxisFrame::Reference, |set| set.frame());
        (force, actuation.torque.frame())
    }

    /// Linearises a kick at a pose. `along` are the force and the torque, each in the axes of its
    /// actuator set.
    fn kicked<const N: usize, const C: usize>(&self, pose: &Pose, along: &[Vector3; 2]) -> Held<N, C> {
        let (of_force, of_torque) = self.frames();
        let (r, identity) = (&pose.attitude, Matrix3::identity());
        let input =
            Wrench { force: of_force.to_reference(r, &along[0]), moment: of_torque.to_body(r, &along[1]) };
        let (wrench, gradient) = self.dynamics.kick_of_inputs(pose, &input);
        let mut inputs = SMatrix::<f64, N, C>::zeros();
        inputs.view_mut((N - 3, C - 3), (3, 3)).copy_from(&of_torque.to_body(r, &identity));
        if N == 12 {
            inputs.view_mut((3, 0), (3, 3)).copy_from(&of_force.to_reference(r, &identity));
        }
        Held { wrench, gradient: placed(&gradient, 3), inputs }
    }

    /// Computes the curvature `K_qq` and the mixed derivative `M = ∂(λ·E)/∂q` of a kick.
    fn bent<const N: usize, const C: usize>(
        &self,
        pose: &Pose,
        along: &[Vector3; 2],
        costate: &Costate,
    ) -> (SMatrix<f64, N, N>, SMatrix<f64, N, C>) {
        let (of_force, of_torque) = self.frames();
        let r = &pose.attitude;
        let mut bend = self.dynamics.field_curvature(pose, costate);
        let mut mixed = SMatrix::<f64, N, C>::zeros();
        if of_torque == AxisFrame::Reference {
            // K_R = λ^Π × Rᵀτ.
            bend.rr += hat(&costate.pi) * hat(&r.tr_mul(&along[1]));
            mixed.view_mut((N - 6, C - 3), (3, 3)).copy_from(&(hat(&costate.pi) * r.transpose()));
        }
        if N == 12 && of_force == AxisFrame::Body {
            // K_R = f × Rᵀλ^γ.
            let rho = r.tr_mul(&costate.gamma);
            bend.rr += hat(&along[0]) * hat(&rho);
            mixed.view_mut((N - 6, 0), (3, 3)).copy_from(&-hat(&rho));
        }
        (placed(&bend, 0), mixed)
    }
}

/// Places blocks for position and attitude in a matrix. With `below = 3` the rows are those of the
/// momenta, with `below = 0` those of position and attitude.
fn placed<const N: usize>(blocks: &Blocks, below: usize) -> SMatrix<f64, N, N> {
    let mut out = SMatrix::<f64, N, N>::zeros();
    out.view_mut((N - 6 + below, N - 6), (3, 3)).copy_from(&blocks.rr);
    if N == 12 {
        out.view_mut((below, 0), (3, 3)).copy_from(&blocks.xx);
        out.view_mut((below, N - 6), (3, 3)).copy_from(&blocks.xr);
        out.view_mut((N - 6 + below, 0), (3, 3)).copy_from(&blocks.rx);
    }
    out
}
