//! Actuators: the input matrix `B`, its frame and the limits of the inputs, for torques and for
//! forces.

use crate::numerics::cone;
use crate::{Matrix3, Vector3};
use nalgebra::{DMatrix, SMatrix};
use std::slice;
use thiserror::Error;

/// The axes in which the columns of `B` are fixed.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum AxisFrame {
    /// Fixed to the body.
    Body,
    /// Fixed to the reference frame: a torque is then `τ = Rᵀ B u`, a body-fixed force `f = R B u`.
    Reference,
}

impl AxisFrame {
    /// Converts vectors (columns) from body axes to these axes, at attitude `r`.
    #[inline(always)]
    pub fn of_body<const C: usize>(self, r: &Matrix3, vectors: &SMatrix<f64, 3, C>) -> SMatrix<f64, 3, C> {
        if self == Self::Body { *vectors } else { r * vectors }
    }

    /// Converts vectors from these axes to body axes.
    #[inline(always)]
    pub fn to_body<const C: usize>(self, r: &Matrix3, vectors: &SMatrix<f64, 3, C>) -> SMatrix<f64, 3, C> {
        if self == Self::Body { *vectors } else { r.tr_mul(vectors) }
    }

    /// Returns the vectors of the reference frame in these axes.
    #[inline(always)]
    pub fn of_reference<const C: usize>(
        self,
        r: &Matrix3,
        vectors: &SMatrix<f64, 3, C>,
    ) -> SMatrix<f64, 3, C> {
        if self == Self::Reference { *vectors } else { r.tr_mul(vectors) }
    }

    /// Returns the vectors of these axes in the reference frame.
    #[inline(always)]
    pub fn to_reference<const C: usize>(
        self,
        r: &Matrix3,
        vectors: &SMatrix<f64, 3, C>,
    ) -> SMatrix<f64, 3, C> {
        if self == Self::Reference { *vectors } else { r * vectors }
    }
}

/// Singular value of `B`, relative to the largest, below which its axes count as coplanar.
const RANK_TOLERANCE: f64 = 1e-6;

/// Inputs of one kind, torques or forces: `B` (3×m), its frame, and the limits of the inputs.
#[derive(Clone, Debug, PartialEq)]
pub struct ActuatorSet {
    axes: Vec<Vector3>,
    frame: AxisFrame,
    limits: Limits,
}

/// Limits of the inputs of one set. An absent limit does not exist.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Limits {
    /// The limits of `|u_i|`, one for each input [N·m or N].
    pub size: Option<Vec<f64>>,
    /// Whether inputs are never negative, `0 ≤ u_i ≤ size`, as for thrusters. One-sided inputs need
    /// a limit of size.
    pub one_sided: bool,
    /// The limit of `|B u|` [N·m or N].
    pub norm: Option<f64>,
    /// The limits of `|du_i/dt|`, one for each input [N·m/s or N/s].
    pub rate: Option<Vec<f64>>,
    /// The shortest pulse \[s\]. Inputs are then off or at their limit of size, each time for at
    /// least this long.
    pub shortest_pulse: Option<f64>,
}

impl Limits {
    /// Returns whether no limit exists.
    pub fn is_none(&self) -> bool {
        self.size.is_none() && self.norm.is_none() && self.rate.is_none()
    }
}

/// The reason for which axes and limits do not make a set of actuators.
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
        /// The number of the axis, from 1.
        index: usize,
    },
    /// Thrusters do not each have a position that is finite.
    #[error("{count} positions of thrusters: give one for each, with finite numbers")]
    Position {
        /// The number given.
        count: usize,
    },
    /// A limit is not positive and finite, or the number of limits is not the number of inputs.
    #[error("{what}: {count} inputs need as many limits, each positive and finite")]
    Limit {
        /// The name of the limit.
        what: &'static str,
        /// Number of inputs.
        count: usize,
    },
}

impl ActuatorSet {
    /// The most inputs of one kind.
    pub const MAX_INPUTS: usize = 64;

    /// Builds the inputs along `axes` (the columns of `B`), without limits.
    ///
    /// # Errors
    /// A [`ActuatorSetError`] when the axes are unusable.
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

    /// Puts limits on the inputs.
    ///
    /// # Errors
    /// Returns [`ActuatorSetError::Limit`] if a limit is not positive and finite, or if their
    /// number differs from the number of inputs.
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

    /// Returns the columns of `B`.
    pub fn axes(&self) -> &[Vector3] {
        &self.axes
    }

    /// Returns the frame in which the columns of `B` are fixed.
    pub fn frame(&self) -> AxisFrame {
        self.frame
    }

    /// Returns `B u`, in the axes of [`ActuatorSet::frame`].
    pub fn output(&self, inputs: &[f64]) -> Vector3 {
        self.axes.iter().zip(inputs).map(|(axis, input)| axis * *input).sum()
    }

    /// Builds the set with `factor` times the output of each input.
    pub(crate) fn scaled(&self, factor: f64) -> Self {
        Self { axes: self.axes.iter().map(|axis| axis * factor).collect(), ..self.clone() }
    }

    /// Returns the rank of `B`, from 1 to 3. For rank 2 it also returns the unit vector about which
    /// (along which, for forces) no input acts, and for rank 1 the unit vector about which all
    /// inputs act.
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
    /// Returns whether the inputs within their limits have an output in every direction: their axes
    /// have rank 3, and the axes of one-sided inputs are not all on one side of a plane.
    pub fn reaches_every_direction(&self) -> bool {
        self.rank().0 == 3 && (!self.limits.one_sided || cone::is_whole_space(&self.units()))
    }

    /// Returns whether the inputs can produce the opposite of every output that they can produce.
    pub fn reaches_both_senses(&self) -> bool {
        !self.limits.one_sided || cone::is_subspace(&self.units())
    }

    /// Returns the axes as columns, each in the unit of its largest component.
    fn units(&self) -> DMatrix<f64> {
        DMatrix::from_fn(3, self.count(), |row, input| self.axes[input][row] / self.axes[input].amax())
    }
}

/// Thrusters that push and turn the body at once: input j, in N, is the force of thruster j. It
/// acts along axis j of the forces, `d_j`. Axis j of the torques, in m, is its moment
/// `p_j × d_j`, which is zero if the thruster pushes through the mass center. One row of inputs
/// drives both sets, which are fixed to the body and have equal limits.
#[derive(Clone, Debug, PartialEq)]
pub struct Thrusters {
    /// The position `p_j` of each from the mass center, body axes \[m\].
    pub positions: Vec<Vector3>,
}

/// Reaction wheels that drive the torque inputs: input i is the torque that wheel i exerts on the
/// body about its axis, so the momentum of the wheel changes by `ḣ_i = −u_i`.
///
/// The spin axes are the axes of the torque inputs, which are fixed to the body. The body's
/// inertia contains the wheels, but not their spin. The total momentum in body axes is
/// `JΩ + Σ a_i h_i`.
#[derive(Clone, Debug, PartialEq)]
pub struct Wheels {
    /// Momentum `h_i` of each wheel about its axis at the start [N·m·s].
    pub momentum: Vec<f64>,
    /// The limit of `|h_i|` for each wheel [N·m·s]; infinite for no limit.
    pub momentum_limit: Vec<f64>,
}

/// The quantity that a limit of the actuators bounds.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum LimitKind {
    /// The size of each input, [`Limits::size`].
    Size,
    /// The norm of all inputs, [`Limits::norm`].
    Norm,
    /// The rate of change of each input, [`Limits::rate`].
    Rate,
    /// [`Wheels::momentum_limit`].
    WheelMomentum,
}

/// One limit of the actuators: of all inputs of a set, or of the wheels behind them.
#[derive(Clone, Copy, Debug)]
pub struct InputLimit<'a> {
    /// The limited quantity.
    pub kind: LimitKind,
    /// The name that reports use, see [`Actuation::limit_name`].
    pub name: &'static str,
    /// Whether the limit applies to forces; otherwise it applies to torques.
    pub of_force: bool,
    /// The inputs.
    pub set: &'a ActuatorSet,
    /// The index of the first limited input among all inputs.
    pub first: usize,
    /// The bounds, one number for each input or wheel, infinite for no limit; a single number for
    /// the norm.
    pub bounds: &'a [f64],
}

impl InputLimit<'_> {
    /// Returns the displayed unit of the bounds.
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

/// All actuators of the body: torques, and forces when the body also translates.
#[derive(Clone, Debug, PartialEq)]
pub struct Actuation {
    /// Torque inputs.
    pub torque: ActuatorSet,
    /// Force inputs; `None` on SO(3), or if no input pushes the body.
    pub force: Option<ActuatorSet>,
    /// The wheels that produce the torque inputs, if these are wheels.
    pub wheels: Option<Wheels>,
    /// The thrusters that produce forces and torques, if each produces both.
    pub thrusters: Option<Thrusters>,
}

impl Actuation {
    /// Builds an actuation that has torque inputs alone.
    pub fn torques(torque: ActuatorSet) -> Self {
        Self { torque, force: None, wheels: None, thrusters: None }
    }

    /// Builds an actuation whose torque inputs and force inputs are independent.
    pub fn torques_and_forces(torque: ActuatorSet, force: ActuatorSet) -> Self {
        Self { force: Some(force), ..Self::torques(torque) }
    }

    /// Builds the thrusters at `positions`, from the mass center \[m\], that push the body along
    /// `directions`, of length 1, both in body axes; an input is a force \[N\]. Only least time and
    /// least fuel accept thrusters, with `limits.one_sided`.
    ///
    /// # Errors
    /// An [`ActuatorSetError`] if the numbers of positions and directions differ, or if positions,
    /// directions or limits are unusable.
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

    /// Builds reaction wheels about `axes`, of length 1, body axes: wheel i produces up to
    /// `torque_limit[i]` [N·m], has stored `wheels.momentum[i]` at the start and stores up to
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
    /// // What the wheels store turns the body: from rest to rest they come back to where they were.
    /// let momenta = &plan.solution.trajectory.wheel_momentum;
    /// assert!(momenta.iter().any(|momentum| momentum.abs() > 0.1));
    /// assert!(momenta[momenta.len() - 4..].iter().all(|momentum| momentum.abs() < 1e-3));
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    ///
    /// # Errors
    /// An [`ActuatorSetError`] where axes or limits are unusable, or there is not one limit for
    /// each axis; that momenta fit is checked with the maneuver.
    pub fn of_wheels(
        axes: Vec<Vector3>,
        torque_limit: Vec<f64>,
        wheels: Wheels,
    ) -> Result<Self, ActuatorSetError> {
        let limits = Limits { size: Some(torque_limit), ..Limits::default() };
        let torque = ActuatorSet::new(axes, AxisFrame::Body)?.with_limits(limits)?;
        Ok(Self { wheels: Some(wheels), ..Self::torques(torque) })
    }

    /// Returns the number of inputs, forces first.
    pub fn count(&self) -> usize {
        self.first_torque() + self.torque.count()
    }

    /// Returns the index of the first torque input: forces come first. Thrusters are forces and
    /// torques, so their index is 0.
    pub fn first_torque(&self) -> usize {
        let forces = self.force.as_ref().filter(|_| self.thrusters.is_none());
        forces.map_or(0, ActuatorSet::count)
    }

    /// Returns the force inputs and the torque inputs of a row. For thrusters that produce both,
    /// each part is the whole row.
    pub fn split<'a>(&self, inputs: &'a [f64]) -> (&'a [f64], &'a [f64]) {
        if self.thrusters.is_some() {
            return (inputs, inputs);
        }
        inputs.split_at(inputs.len().saturating_sub(self.torque.count()))
    }

    /// Splits a row into force inputs and torque inputs by their costs: inputs of thrusters that
    /// produce both count once, as forces.
    pub fn split_costs<'a>(&self, inputs: &'a [f64]) -> (&'a [f64], &'a [f64]) {
        let (forces, torques) = self.split(inputs);
        (forces, if self.thrusters.is_some() { &[] } else { torques })
    }

    /// Returns whether the inputs within their limits can produce a torque in every direction and,
    /// if the body `moves`, a force and a torque in every direction together.
    pub fn reaches_every_direction(&self, moves: bool) -> bool {
        match self.wrenches(moves) {
            Some(wrenches) => cone::is_whole_space(&wrenches),
            None => self.torque.reaches_every_direction(),
        }
    }

    /// Returns whether the inputs within their limits can produce the opposite of every torque and,
    /// if the body `moves`, of every force and torque together.
    pub fn reaches_both_senses(&self, moves: bool) -> bool {
        match self.wrenches(moves) {
            Some(wrenches) => cone::is_subspace(&wrenches),
            None => self.torque.reaches_both_senses(),
        }
    }

    /// Returns force and torque of each thruster that pushes and turns a body that `moves`; the
    /// arms are in the unit of the longest arm.
    fn wrenches(&self, moves: bool) -> Option<DMatrix<f64>> {
        let (Some(force), Some(_), true) = (&self.force, &self.thrusters, moves) else { return None };
        let longest = self.torque.axes.iter().map(Vector3::amax).fold(0.0, f64::max);
        let unit = if longest > 0.0 { longest } else { 1.0 };
        Some(DMatrix::from_fn(6, self.count(), |row, input| match row {
            0..3 => force.axes[input][row],
            _ => self.torque.axes[input][row - 3] / unit,
        }))
    }

    /// Returns the momentum `Σ a_i h_i` that the wheels store at the start, axes of the torque
    /// inputs [N·m·s]; zero without wheels.
    pub fn stored_momentum(&self) -> Vector3 {
        self.wheels.as_ref().map_or_else(Vector3::zeros, |wheels| self.torque.output(&wheels.momentum))
    }

    /// Returns all limits: first the torque limits, then the limits of the wheels and of the
    /// forces. Limits of thrusters are limits of forces.
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

    /// Returns the name that reports use for a limit of the forces or of the torques: "torque
    /// limit", "torque norm limit", "torque rate limit", "wheel torque limit", "wheel torque rate
    /// limit", "wheel momentum limit", "force limit", "force norm limit", "force rate limit".
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

    /// Builds the actuators without limits, and without storage in wheels.
    #[doc(hidden)]
    pub fn without_limits(&self) -> Self {
        let free = |channel: &ActuatorSet| ActuatorSet { limits: Limits::default(), ..channel.clone() };
        // For thrusters this treats the force and the torque as independent.
        Self { force: self.force.as_ref().map(free), ..Self::torques(free(&self.torque)) }
    }

    /// Returns the actuators with inputs that may jump, without storage in wheels. A limit of
    /// each input, if given, replaces the limit of the norm.
    pub(crate) fn of_jumping_inputs(&self) -> Self {
        let jumping = |channel: &ActuatorSet| {
            let norm = channel.limits.norm.filter(|_| channel.limits.size.is_none());
            ActuatorSet { limits: Limits { rate: None, norm, ..channel.limits.clone() }, ..channel.clone() }
        };
        let force = self.force.as_ref().map(jumping);
        Self { torque: jumping(&self.torque), force, wheels: None, thrusters: self.thrusters.clone() }
    }

    /// Returns whether any input has a limit, or stores its momentum in a wheel.
    pub fn is_limited(&self) -> bool {
        self.wheels.is_some() || self.limits().next().is_some()
    }
}
