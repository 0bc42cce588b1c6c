//! Actuators: the input matrix `B`, its frame and the limits of the inputs, for torques and for
//! forces.

use crate::numerics::cone;
use crate::{Matrix3, Vector3};
use nalgebra::{DMatrix, SMatrix};
use std::slice;
use thiserror::Error;

/// The axes in which the columns of `B`, the axes of the inputs `u`, are constant.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum AxisFrame {
    /// Body axes.
    Body,
    /// Axes of the reference frame. A torque of these axes is `τ = Rᵀ B u`, and a body-fixed force
    /// is `f = R B u`.
    Reference,
}

impl AxisFrame {
    /// Converts vectors (columns) from body axes to these axes, for a body in attitude `r`.
    #[inline(always)]
    pub fn of_body<const C: usize>(self, r: &Matrix3, vectors: &SMatrix<f64, 3, C>) -> SMatrix<f64, 3, C> {
        if self == Self::Body { *vectors } else { r * vectors }
    }

    /// Converts vectors (columns) from these axes to body axes, for a body in attitude `r`.
    #[inline(always)]
    pub fn to_body<const C: usize>(self, r: &Matrix3, vectors: &SMatrix<f64, 3, C>) -> SMatrix<f64, 3, C> {
        if self == Self::Body { *vectors } else { r.tr_mul(vectors) }
    }

    /// Converts vectors (columns) from the reference frame to these axes, for a body in attitude
    /// `r`.
    #[inline(always)]
    pub fn of_reference<const C: usize>(
        self,
        r: &Matrix3,
        vectors: &SMatrix<f64, 3, C>,
    ) -> SMatrix<f64, 3, C> {
        if self == Self::Reference { *vectors } else { r.tr_mul(vectors) }
    }

    /// Converts vectors (columns) from these axes to the reference frame, for a body in attitude
    /// `r`.
    #[inline(always)]
    pub fn to_reference<const C: usize>(
        self,
        r: &Matrix3,
        vectors: &SMatrix<f64, 3, C>,
    ) -> SMatrix<f64, 3, C> {
        if self == Self::Reference { *vectors } else { r * vectors }
    }
}

/// Singular value of `B`, relative to the largest one, below which the axes count as coplanar.
const RANK_TOLERANCE: f64 = 1e-6;

/// Inputs of one kind, torques or forces: the matrix `B` (3×m) of their axes, its frame, and the
/// limits of the inputs.
#[derive(Clone, Debug, PartialEq)]
pub struct ActuatorSet {
    axes: Vec<Vector3>,
    frame: AxisFrame,
    limits: Limits,
}

/// Limits of the inputs `u` of one set; `None` means that a quantity is not limited.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Limits {
    /// The largest `|u_i|` of each input [N·m or N].
    pub size: Option<Vec<f64>>,
    /// Whether inputs are one-sided, `0 ≤ u_i ≤ size`, as for thrusters. One-sided inputs need
    /// [`Limits::size`].
    pub one_sided: bool,
    /// The largest norm `|B u|` of the output [N·m or N].
    pub norm: Option<f64>,
    /// The largest rate of change `|du_i/dt|` of each input [N·m/s or N/s].
    pub rate: Option<Vec<f64>>,
    /// The minimum pulse width \[s\]. Each input is then either off or at [`Limits::size`], and is
    /// on for at least this time.
    pub shortest_pulse: Option<f64>,
}

impl Limits {
    /// Returns whether no limit of size, norm or rate is given.
    pub fn is_none(&self) -> bool {
        self.size.is_none() && self.norm.is_none() && self.rate.is_none()
    }
}

/// The reason why axes and limits do not form a set of actuators.
#[derive(Clone, Debug, Error, PartialEq)]
pub enum ActuatorSetError {
    /// The number of axes is zero, or more than [`ActuatorSet::MAX_INPUTS`].
    #[error("{count} input axes: give from 1 to {}", ActuatorSet::MAX_INPUTS)]
    Count {
        /// The number of axes given.
        count: usize,
    },
    /// An axis is zero or not finite.
    #[error("input axis {index} is zero or not finite")]
    Axis {
        /// Index of the axis, from 1.
        index: usize,
    },
    /// The number of thruster positions differs from the number of thrusters, or a position is not
    /// finite.
    #[error("{count} positions of thrusters: give one for each, with finite numbers")]
    Position {
        /// The number of positions given.
        count: usize,
    },
    /// A limit is not positive and finite, or the number of limits differs from the number of
    /// inputs.
    #[error("{what}: {count} inputs need as many limits, each positive and finite")]
    Limit {
        /// The name of the limit.
        what: &'static str,
        /// Number of inputs.
        count: usize,
    },
}

impl ActuatorSet {
    /// The largest number of inputs of one kind.
    pub const MAX_INPUTS: usize = 64;

    /// Builds the inputs along `axes` (the columns of `B`), without limits.
    ///
    /// Returns an [`ActuatorSetError`] if the number of axes is out of range, or an axis is zero or
    /// not finite.
    pub fn new(axes: Vec<Vector3>, frame: AxisFrame) -> Result<Self, ActuatorSetError> {
        let count = axes.len();
        if count == 0 || count > Self::MAX_INPUTS {
            return Err(ActuatorSetError::Count { count });
        }
        for (index, axis) in axes.iter().enumerate() {
            let size = axis.amax();
            if !axis.iter().all(|value| value.is_finite()) || size == 0.0 {
                return Err(ActuatorSetError::Axis { index: index + 1 });
            }
        }
        Ok(Self { axes, frame, limits: Limits::default() })
    }

    /// Builds three unit inputs along the coordinate axes of `frame`.
    pub fn three_axes(frame: AxisFrame) -> Self {
        let axes = vec![Vector3::x(), Vector3::y(), Vector3::z()];
        Self { axes, frame, limits: Limits::default() }
    }

    /// Sets the limits of the inputs.
    ///
    /// # Errors
    /// Returns [`ActuatorSetError::Limit`] if a limit is not positive and finite, or if the number
    /// of limits differs from the number of inputs.
    pub fn with_limits(mut self, limits: Limits) -> Result<Self, ActuatorSetError> {
        let count = self.count();
        let usable = |value: &f64| *value > 0.0 && value.is_finite();
        let each = |values: &Option<Vec<f64>>| {
            values.as_ref().is_none_or(|values| values.len() == count && values.iter().all(usable))
        };
        let checks = [
            ("limit of size", each(&limits.size) && (limits.size.is_some() || !limits.one_sided)),
            ("limit of the norm", limits.norm.as_ref().is_none_or(usable)),
            ("limit of the rate of change", each(&limits.rate)),
        ];
        if let Some((what, _)) = checks.into_iter().find(|(_, fine)| !fine) {
            return Err(ActuatorSetError::Limit { what, count });
        }
        self.limits = limits;
        Ok(self)
    }

    /// Returns the limits of the inputs.
    pub fn limits(&self) -> &Limits {
        &self.limits
    }

    /// Returns the number of inputs m.
    pub fn count(&self) -> usize {
        self.axes.len()
    }

    /// Returns the axes of the inputs, which are the columns of `B`.
    pub fn axes(&self) -> &[Vector3] {
        &self.axes
    }

    /// Returns the frame in which the columns of `B` are fixed.
    pub fn frame(&self) -> AxisFrame {
        self.frame
    }

    /// Returns the output `B u` of the inputs `u`, in the axes of [`ActuatorSet::frame`].
    pub fn output(&self, inputs: &[f64]) -> Vector3 {
        self.axes.iter().zip(inputs).map(|(axis, input)| axis * *input).sum()
    }

    /// Builds the set in which the output of each input is `factor` times as large.
    pub(crate) fn scaled(&self, factor: f64) -> Self {
        Self { axes: self.axes.iter().map(|axis| axis * factor).collect(), ..self.clone() }
    }

    /// Returns the rank of `B`, from 1 to 3, and a unit vector for ranks 1 and 2. For rank 2 no
    /// input acts about the vector (or along it, for forces); for rank 1 all inputs act about it.
    pub fn rank(&self) -> (usize, Option<Vector3>) {
        let longest = self.axes.iter().map(Vector3::amax).fold(0.0, f64::max);
        let units = self.axes.iter().map(|axis| axis / longest);
        let eigen = units.map(|axis| axis * axis.transpose()).sum::<Matrix3>().symmetric_eigen();
        let mut order = [0, 1, 2];
        order.sort_by(|a, b| eigen.eigenvalues[*b].total_cmp(&eigen.eigenvalues[*a]));
        let least = RANK_TOLERANCE.powi(2) * eigen.eigenvalues[order[0]];
        let rank = order.iter().filter(|index| eigen.eigenvalues[**index] > least).count();
        let direction = |index: usize| {
            let vector: Vector3 = eigen.eigenvectors.column(index).into_owned();
            vector * vector[vector.iamax()].signum()
        };
        match rank {
            1 => (1, Some(direction(order[0]))),
            2 => (2, Some(direction(order[2]))),
            _ => (rank, None),
        }
    }
}

impl ActuatorSet {
    /// Returns whether the inputs can produce an output in every direction: their axes have rank 3,
    /// and the axes of one-sided inputs are not all on one side of a plane.
    pub fn reaches_every_direction(&self) -> bool {
        self.rank().0 == 3 && (!self.limits.one_sided || cone::is_whole_space(&self.units()))
    }

    /// Returns whether the inputs can produce the opposite of every output that they can produce.
    pub fn reaches_both_senses(&self) -> bool {
        !self.limits.one_sided || cone::is_subspace(&self.units())
    }

    /// Returns the axes as columns, each divided by its largest component.
    fn units(&self) -> DMatrix<f64> {
        DMatrix::from_fn(3, self.count(), |row, input| self.axes[input][row] / self.axes[input].amax())
    }
}

/// Thrusters that each produce a force and a torque. Input j is the force of thruster j \[N\],
/// along axis j of the force inputs, `d_j`. Axis j of the torque inputs \[m\] is the moment arm
/// `p_j × d_j`, which is zero for a thruster through the mass centre. One row of inputs drives both
/// sets, which are fixed to the body and have equal limits.
#[derive(Clone, Debug, PartialEq)]
pub struct Thrusters {
    /// Position `p_j` of each thruster from the mass centre, body axes \[m\].
    pub positions: Vec<Vector3>,
}

/// Reaction wheels that produce the torque inputs. Input i is the torque that wheel i exerts on the
/// body about its axis, so the momentum of the wheel changes by `ḣ_i = −u_i`.
///
/// The spin axes are the axes of the torque inputs, which are fixed to the body. The inertia of the
/// body includes the wheels, but not their spin. The total momentum in body axes is
/// `JΩ + Σ a_i h_i`.
#[derive(Clone, Debug, PartialEq)]
pub struct Wheels {
    /// Momentum `h_i` of each wheel about its axis at the start [N·m·s].
    pub momentum: Vec<f64>,
    /// The largest `|h_i|` of each wheel [N·m·s]; infinite for no limit.
    pub momentum_limit: Vec<f64>,
}

/// The quantity that a limit of the actuators bounds.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum LimitKind {
    /// The size of each input, [`Limits::size`].
    Size,
    /// The norm of the output of all inputs, [`Limits::norm`].
    Norm,
    /// The rate of change of each input, [`Limits::rate`].
    Rate,
    /// The momentum of each wheel, [`Wheels::momentum_limit`].
    WheelMomentum,
}

/// One kind of limit on all inputs of a set of actuators, or on the wheels that produce the inputs.
#[derive(Clone, Copy, Debug)]
pub struct InputLimit<'a> {
    /// The limited quantity.
    pub kind: LimitKind,
    /// The name of the limit in reports, see [`Actuation::limit_name`].
    pub name: &'static str,
    /// Whether the limit applies to forces; otherwise it applies to torques.
    pub of_force: bool,
    /// The limited set of inputs.
    pub set: &'a ActuatorSet,
    /// Index of the first limited input among all inputs of the actuation.
    pub first: usize,
    /// The bounds: one number for each input or wheel, infinite for no limit; a single number for
    /// the norm.
    pub bounds: &'a [f64],
}

impl InputLimit<'_> {
    /// Returns the unit of the bounds for display.
    pub fn unit(&self) -> &'static str {
        match (self.kind, self.of_force) {
            (LimitKind::WheelMomentum, _) => "N·m·s",
            (LimitKind::Rate, true) => "N/s",
            (LimitKind::Rate, false) => "N·m/s",
            (LimitKind::Size | LimitKind::Norm, true) => "N",
            (LimitKind::Size | LimitKind::Norm, false) => "N·m",
        }
    }
}

/// All actuators of the body: torque inputs, and force inputs if the body also translates.
#[derive(Clone, Debug, PartialEq)]
pub struct Actuation {
    /// Torque inputs.
    pub torque: ActuatorSet,
    /// Force inputs; `None` on SO(3), or if no input exerts a force.
    pub force: Option<ActuatorSet>,
    /// The reaction wheels that produce the torque inputs; `None` without wheels.
    pub wheels: Option<Wheels>,
    /// The thrusters, if each of them produces both a force and a torque.
    pub thrusters: Option<Thrusters>,
}

impl Actuation {
    /// Builds an actuation that has torque inputs only.
    pub fn torques(torque: ActuatorSet) -> Self {
        Self { torque, force: None, wheels: None, thrusters: None }
    }

    /// Builds an actuation whose torque inputs and force inputs are independent.
    pub fn torques_and_forces(torque: ActuatorSet, force: ActuatorSet) -> Self {
        Self { force: Some(force), ..Self::torques(torque) }
    }

    /// Builds an actuation by thrusters that each produce a force and a torque. They are at
    /// `positions` from the mass centre \[m\] and push the body along `directions` of length 1,
    /// both in body axes; an input is a force \[N\]. Thrusters need `limits.one_sided`, and minimum
    /// time or minimum fuel as the objective.
    ///
    /// # Errors
    /// Returns an [`ActuatorSetError`] if the numbers of positions and directions differ, or if
    /// positions, directions or limits are invalid.
    pub fn of_thrusters(
        positions: Vec<Vector3>,
        directions: Vec<Vector3>,
        limits: Limits,
    ) -> Result<Self, ActuatorSetError> {
        let count = positions.len();
        let force = ActuatorSet::new(directions, AxisFrame::Body)?.with_limits(limits)?;
        if count != force.count() || positions.iter().flatten().any(|value| !value.is_finite()) {
            return Err(ActuatorSetError::Position { count });
        }
        let arms = positions.iter().zip(&force.axes).map(|(position, direction)| position.cross(direction));
        let torque = ActuatorSet { axes: arms.collect(), ..force.clone() };
        Ok(Self { torque, force: Some(force), wheels: None, thrusters: Some(Thrusters { positions }) })
    }

    /// Builds reaction wheels along `axes`, of length 1, body axes. Wheel i produces up to
    /// `torque_limit[i]` [N·m], stores `wheels.momentum[i]` at the start and up to
    /// `wheels.momentum_limit[i]` [N·m·s].
    ///
    /// ```
    /// use slewkit::mechanics::{Actuation, Wheels};
    /// use slewkit::{Body, Inertia, Matrix3, Problem, Settings, Silent, State, Status, Vector3, lie, plan};
    ///
    /// // A pyramid of four, of which any three reach every direction.
    /// let axes = [(1.0, 1.0), (-1.0, 1.0), (-1.0, -1.0), (1.0, -1.0)];
    /// let axes = axes.map(|(x, y)| Vector3::new(x, y, 1.0).normalize()).to_vec();
    /// let wheels = Wheels { momentum: vec![0.0; 4], momentum_limit: vec![4.0; 4] };
    /// let body = Body { inertia: Inertia::diagonal(Vector3::new(12.0, 10.0, 8.0))?, mass: None };
    /// let end = State::at_rest(lie::exp(&Vector3::new(0.4, -0.8, 1.2)));
    /// let problem = Problem::attitude(body, State::at_rest(Matrix3::identity()), end, 40.0)
    ///     .with_actuation(Actuation::of_wheels(axes, vec![0.1; 4], wheels)?);
    /// let plan = plan(&problem, &Settings::default(), None, &mut Silent)?;
    /// assert_eq!(plan.status, Status::Solved);
    /// // From rest to rest the momenta of the wheels return to their initial values.
    /// let momenta = &plan.solution.trajectory.wheel_momentum;
    /// assert!(momenta.iter().any(|momentum| momentum.abs() > 0.1));
    /// assert!(momenta[momenta.len() - 4..].iter().all(|momentum| momentum.abs() < 1e-3));
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    ///
    /// # Errors
    /// Returns an [`ActuatorSetError`] if axes or limits are invalid, or if the number of torque
    /// limits differs from the number of axes. [`Problem::check`](crate::Problem::check) checks the
    /// momenta.
    pub fn of_wheels(
        axes: Vec<Vector3>,
        torque_limit: Vec<f64>,
        wheels: Wheels,
    ) -> Result<Self, ActuatorSetError> {
        let limits = Limits { size: Some(torque_limit), ..Limits::default() };
        let torque = ActuatorSet::new(axes, AxisFrame::Body)?.with_limits(limits)?;
        Ok(Self { wheels: Some(wheels), ..Self::torques(torque) })
    }

    /// Returns the total number of inputs.
    pub fn count(&self) -> usize {
        self.first_torque() + self.torque.count()
    }

    /// Returns the index of the first torque input, which is the number of force inputs: forces
    /// come first. Inputs of thrusters are forces and torques, so that the index is 0.
    pub fn first_torque(&self) -> usize {
        let forces = self.force.as_ref().filter(|_| self.thrusters.is_none());
        forces.map_or(0, ActuatorSet::count)
    }

    /// Splits a row of inputs into force inputs and torque inputs. For thrusters that produce both,
    /// each part is the whole row.
    pub fn split<'a>(&self, inputs: &'a [f64]) -> (&'a [f64], &'a [f64]) {
        if self.thrusters.is_some() {
            return (inputs, inputs);
        }
        inputs.split_at(inputs.len().saturating_sub(self.torque.count()))
    }

    /// Splits a row of inputs for the cost into force inputs and torque inputs. Inputs of thrusters
    /// that produce both count once, as forces.
    pub fn split_costs<'a>(&self, inputs: &'a [f64]) -> (&'a [f64], &'a [f64]) {
        let (forces, torques) = self.split(inputs);
        (forces, if self.thrusters.is_some() { &[] } else { torques })
    }

    /// Returns whether the inputs can produce a torque in every direction and, if the body `moves`,
    /// every combination of force and torque.
    pub fn reaches_every_direction(&self, moves: bool) -> bool {
        match self.wrenches(moves) {
            Some(wrenches) => cone::is_whole_space(&wrenches),
            None => self.torque.reaches_every_direction(),
        }
    }

    /// Returns whether the inputs can produce the opposite of every torque that they can produce
    /// and, if the body `moves`, the opposite of every combination of force and torque.
    pub fn reaches_both_senses(&self, moves: bool) -> bool {
        match self.wrenches(moves) {
            Some(wrenches) => cone::is_subspace(&wrenches),
            None => self.torque.reaches_both_senses(),
        }
    }

    /// Returns force and torque of each thruster as columns, with moment arms divided by the
    /// longest arm; `None` if no thrusters produce both, or if the body does not translate.
    fn wrenches(&self, moves: bool) -> Option<DMatrix<f64>> {
        let (Some(force), Some(_), true) = (&self.force, &self.thrusters, moves) else { return None };
        let longest = self.torque.axes.iter().map(Vector3::amax).fold(0.0, f64::max);
        let unit = if longest > 0.0 { longest } else { 1.0 };
        Some(DMatrix::from_fn(6, self.count(), |row, input| match row {
            0..3 => force.axes[input][row],
            _ => self.torque.axes[input][row - 3] / unit,
        }))
    }

    /// Returns the momentum `Σ a_i h_i` that the wheels store at the start, in the axes of the
    /// torque inputs [N·m·s]; zero without wheels.
    pub fn stored_momentum(&self) -> Vector3 {
        self.wheels.as_ref().map_or_else(Vector3::zeros, |wheels| self.torque.output(&wheels.momentum))
    }

    /// Returns all limits: torque limits, limits of the wheels, then force limits. Limits of
    /// thrusters are force limits.
    pub fn limits(&self) -> impl Iterator<Item = InputLimit<'_>> {
        let torque = Some(&self.torque).filter(|_| self.thrusters.is_none());
        let sets = [(torque, self.first_torque(), false), (self.force.as_ref(), 0, true)];
        let momenta = self.wheels.as_ref().map(|wheels| &wheels.momentum_limit[..]);
        let momenta = momenta.filter(|limits| limits.iter().any(|limit| limit.is_finite()));
        sets.into_iter().filter_map(|(set, first, of_force)| Some((set?, first, of_force))).flat_map(
            move |(set, first, of_force)| {
                let Limits { size, norm, rate, one_sided: _, shortest_pulse: _ } = &set.limits;
                let given = [
                    (LimitKind::Size, size.as_deref()),
                    (LimitKind::Norm, norm.as_ref().map(slice::from_ref)),
                    (LimitKind::Rate, rate.as_deref()),
                    (LimitKind::WheelMomentum, momenta.filter(|_| !of_force)),
                ];
                given.into_iter().filter_map(move |(kind, bounds)| {
                    let name = self.limit_name(kind, of_force);
                    Some(InputLimit { kind, name, of_force, set, first, bounds: bounds? })
                })
            },
        )
    }

    /// Returns the name in reports of a limit of the forces or the torques: "torque limit", "torque
    /// norm limit", "torque rate limit", "wheel torque limit", "wheel torque rate limit", "wheel
    /// momentum limit", "force limit", "force norm limit", "force rate limit".
    pub fn limit_name(&self, kind: LimitKind, of_force: bool) -> &'static str {
        let wheels = self.wheels.is_some();
        match kind {
            LimitKind::Size if of_force => "force limit",
            LimitKind::Norm if of_force => "force norm limit",
            LimitKind::Rate if of_force => "force rate limit",
            LimitKind::Size if wheels => "wheel torque limit",
            LimitKind::Size => "torque limit",
            LimitKind::Norm => "torque norm limit",
            LimitKind::Rate if wheels => "wheel torque rate limit",
            LimitKind::Rate => "torque rate limit",
            LimitKind::WheelMomentum => "wheel momentum limit",
        }
    }

    /// Returns the actuators without limits, with torque inputs that no wheels produce.
    #[doc(hidden)]
    pub fn without_limits(&self) -> Self {
        let free = |channel: &ActuatorSet| ActuatorSet { limits: Limits::default(), ..channel.clone() };
        // Force and torque of thrusters are then independent.
        Self { force: self.force.as_ref().map(free), ..Self::torques(free(&self.torque)) }
    }

    /// Returns the actuators without rate limits and without wheels, so that inputs may jump. If
    /// each input has a limit, the norm limit is removed.
    pub(crate) fn of_jumping_inputs(&self) -> Self {
        let jumping = |channel: &ActuatorSet| {
            let norm = channel.limits.norm.filter(|_| channel.limits.size.is_none());
            ActuatorSet { limits: Limits { rate: None, norm, ..channel.limits.clone() }, ..channel.clone() }
        };
        let force = self.force.as_ref().map(jumping);
        Self { torque: jumping(&self.torque), force, wheels: None, thrusters: self.thrusters.clone() }
    }

    /// Returns whether any input has a limit, or is produced by a wheel.
    pub fn is_limited(&self) -> bool {
        self.wheels.is_some() || self.limits().next().is_some()
    }
}
