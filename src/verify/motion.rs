//! The state of the body and the inputs of a plan step by step, as all witnesses use them.

use super::verification::WitnessError;
use crate::maneuver::grid::Grid;
use crate::maneuver::problem::{Motion, Problem, ProblemError, State};
use crate::maneuver::solution::TerminalError;
use crate::propagate::plant::{Output, Plant};
use crate::{Matrix3, Vector3, lie};

/// The state of the body in terms of momenta instead of velocities.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Phase {
    /// Position `x`, reference frame \[m\].
    pub position: Vector3,
    /// Linear momentum `γ = m ẋ`, reference frame [N·s].
    pub linear_momentum: Vector3,
    /// Attitude `R`, from body to reference.
    pub attitude: Matrix3,
    /// Angular momentum `Π = JΩ`, body axes [N·m·s].
    pub momentum: Vector3,
    /// Momentum `μ = Σ a_i h_i` that the wheels store, body axes [N·m·s]; zero without wheels.
    pub stored: Vector3,
}

impl Phase {
    /// Builds the phase for a boundary state of `problem`, with the initial momenta of the wheels.
    pub fn of(problem: &Problem, state: &State) -> Self {
        Self {
            position: state.position,
            linear_momentum: problem.body.mass.unwrap_or(0.0) * state.velocity,
            attitude: state.attitude,
            momentum: problem.body.inertia.j() * state.angular_velocity,
            stored: problem.actuation.stored_momentum(),
        }
    }

    /// Returns the angular velocity `Ω = J⁻¹Π`, body axes [rad/s].
    pub fn angular_velocity(&self, problem: &Problem) -> Vector3 {
        let inertia = &problem.body.inertia;
        angular_velocity(inertia.j(), inertia.j_inverse(), &self.momentum)
    }

    /// Returns the velocity `γ/m`, reference frame [m/s]; zero for a body without a mass.
    pub fn velocity(&self, problem: &Problem) -> Vector3 {
        problem.body.mass.map_or_else(Vector3::zeros, |mass| self.linear_momentum / mass)
    }

    pub(crate) fn is_finite(&self) -> bool {
        let vectors = [&self.position, &self.linear_momentum, &self.momentum, &self.stored];
        vectors.into_iter().flatten().chain(self.attitude.iter()).all(|value| value.is_finite())
    }
}

/// Returns the solution `Ω` of `JΩ = Π`, with one step of iterative refinement.
///
/// The plain product `J⁻¹Π` has a relative error of ε·cond(J). For a thin rod this error acts like
/// a gyroscopic torque `Π × Ω` about its axis, which does not exist and accelerates the spin by 1
/// rad/s².
pub(super) fn angular_velocity(j: &Matrix3, j_inverse: &Matrix3, momentum: &Vector3) -> Vector3 {
    let rate = j_inverse * momentum;
    rate + j_inverse * (momentum - j * rate)
}

/// Units of time, inertia, mass and length in which `T = 1`, the mean principal moment is 1, the
/// mass is 1, and lengths are of order 1.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Scale {
    pub(crate) time: f64,
    pub(crate) inertia: f64,
    pub(crate) mass: f64,
    pub(crate) length: f64,
}

impl Scale {
    pub(crate) fn of(problem: &Problem) -> Self {
        let time = problem.seconds();
        let ends = [&problem.start, &problem.end];
        let lengths = ends.map(|state| state.position.norm().max(time * state.velocity.norm()));
        let length = lengths[0].max(lengths[1]);
        Self {
            time,
            inertia: problem.body.inertia.mean(),
            mass: problem.body.mass.unwrap_or(1.0),
            length: if length > 0.0 { length } else { 1.0 },
        }
    }

    /// Returns the scale factors of torque [N·m] and force \[N\] in the nondimensional problem.
    pub(crate) fn loads(&self) -> (f64, f64) {
        let per_time = 1.0 / self.time;
        (self.inertia * per_time * per_time, self.mass * self.length * per_time * per_time)
    }

    /// Returns the difference between two phases in scaled units.
    pub(crate) fn distance(&self, a: &Phase, b: &Phase, motion: Motion) -> TerminalError {
        let moves = motion == Motion::RigidBody;
        let linear = self.mass * self.length / self.time;
        TerminalError {
            attitude_rad: lie::minus(&a.attitude, &b.attitude).norm(),
            momentum_relative: (a.momentum - b.momentum).norm() * self.time / self.inertia,
            position_relative: moves.then(|| (a.position - b.position).norm() / self.length),
            linear_momentum_relative: moves.then(|| (a.linear_momentum - b.linear_momentum).norm() / linear),
        }
    }
}

/// Returns the plant of `problem`. It is an error if the duration is unknown, or if a translating
/// body has a rotating reference frame, because the scheme lacks the Coriolis force.
pub(super) fn judgeable(problem: &Problem) -> Result<Plant<'_>, WitnessError> {
    if problem.duration.known().is_none() {
        return Err(ProblemError::Missing(
            "a motion needs a duration, and the duration of this maneuver is free",
        )
        .into());
    }
    let plant = Plant::new(problem);
    if plant.moves && plant.turns() { Err(WitnessError::TurningFrame) } else { Ok(plant) }
}

/// The inputs of a plan and its steps.
///
/// For minimum time or fuel each step has one row, which is held over the step. Otherwise rows
/// belong to nodes.
#[derive(Clone, Debug)]
pub(crate) struct Inputs<'a> {
    pub(super) problem: &'a Problem,
    pub(super) grid: Grid,
    rows: &'a [f64],
    /// Whether the inputs switch, as [`Problem::switches`] returns it.
    switches: bool,
}

impl<'a> Inputs<'a> {
    /// Builds the inputs from `rows`, which must hold [`Scheme::input_rows`] rows of
    /// `problem.actuation.count()` numbers each.
    pub(crate) fn new(problem: &'a Problem, rows: &'a [f64]) -> Self {
        Self::on(problem, problem.grid(), rows)
    }

    /// Builds the inputs from `rows` on a given grid.
    pub(super) fn on(problem: &'a Problem, grid: Grid, rows: &'a [f64]) -> Self {
        Self { problem, grid, rows, switches: problem.switches() }
    }

    /// Builds the inputs after checking the number of rows.
    pub(crate) fn checked(problem: &'a Problem, rows: &'a [f64]) -> Result<Self, WitnessError> {
        let expected = problem.input_rows() * problem.actuation.count();
        if rows.len() != expected {
            return Err(WitnessError::Rows { what: "input numbers", found: rows.len(), expected });
        }
        Ok(Self::new(problem, rows))
    }

    /// Returns the inputs of a row.
    pub(crate) fn numbers(&self, index: usize) -> &'a [f64] {
        let count = self.problem.actuation.count();
        &self.rows[index * count..(index + 1) * count]
    }

    pub(crate) fn row(&self, index: usize) -> Output {
        Output::of(self.problem, self.numbers(index))
    }

    /// Returns the index of the input row at a node; `None` if the node has no inputs. Lie–Euler
    /// has no inputs at the start, and held inputs have none at the end.
    pub(super) fn row_at(&self, node: usize) -> Option<usize> {
        if self.switches {
            return Some(node).filter(|node| *node < self.problem.steps);
        }
        node.checked_sub(self.problem.scheme.first_input())
    }

    /// Returns the outputs at both ends of step k. Lie–Euler has no `u_0` and uses `u_1` in its
    /// place.
    pub(crate) fn ends(&self, k: usize) -> (Output, Output) {
        let (from, to) = self.end_rows(k);
        (self.row(from), self.row(to))
    }

    /// Returns the row indices of the outputs at both ends of step k.
    fn end_rows(&self, k: usize) -> (usize, usize) {
        if self.switches {
            return (k, k);
        }
        let first = self.problem.scheme.first_input();
        (k.saturating_sub(first), k + 1 - first)
    }

    /// Returns the indices of the rows whose mean the plan holds over step k: twice `u_{k+1}` for
    /// Lie–Euler, `u_k` and `u_{k+1}` for Lie–Verlet, or twice the row of the step for switching
    /// inputs.
    pub(super) fn held_rows(&self, k: usize) -> (usize, usize) {
        if self.switches {
            return (k, k);
        }
        (k, k + 1 - self.problem.scheme.first_input())
    }

    /// Returns the output that the plan holds over step k: `B u_{k+1}` for Lie–Euler,
    /// `½ B (u_k + u_{k+1})` for Lie–Verlet.
    pub(crate) fn held(&self, k: usize) -> Output {
        let (from, to) = self.held_rows(k);
        Output::between(&self.row(from), &self.row(to), 0.5)
    }
}

/// Access to the outputs step by step. Neighbouring steps share a row, so the last output is
/// cached.
pub(super) struct InOrder<'a> {
    inputs: &'a Inputs<'a>,
    last: Option<(usize, Output)>,
}

impl<'a> InOrder<'a> {
    pub(super) fn new(inputs: &'a Inputs<'a>) -> Self {
        Self { inputs, last: None }
    }

    /// Returns the output of a row, as [`Inputs::row`] does.
    pub(super) fn row(&mut self, index: usize) -> Output {
        match self.last {
            Some((last, output)) if last == index => output,
            _ => self.last.insert((index, self.inputs.row(index))).1,
        }
    }

    /// Returns the outputs at both ends of a step, as [`Inputs::ends`] does.
    pub(super) fn ends(&mut self, k: usize) -> (Output, Output) {
        let (from, to) = self.inputs.end_rows(k);
        (self.row(from), self.row(to))
    }

    /// Returns the held output of a step, as [`Inputs::held`] does.
    pub(super) fn held(&mut self, k: usize) -> Output {
        let (from, to) = self.inputs.held_rows(k);
        Output::between(&self.row(from), &self.row(to), 0.5)
    }
}
