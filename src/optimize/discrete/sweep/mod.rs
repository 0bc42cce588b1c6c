//! The forward sweep of state, costates and their sensitivities, which evaluates all necessary
//! conditions.
//!
//! ```text
//! λ_{−1} ─▶ drift, kick ─▶ λ_0, u_1, (R,Π)_1 ─▶ … ─▶ λ_{N−1}, u_N, (R,Π)_N
//! u_{k+1} = −W⁻¹ Bᵀ λ_k^Π ,     λ_{k−1} = A_kᵀ λ_k
//! ```
//!
//! `λ_{−1}` is the only unknown. For Lie–Verlet, the conjugate form of this sweep, half a kick
//! opens it and half a kick closes it; the discrete optimum then has `u_0 = −W⁻¹Bᵀλ_{−1}` by the
//! same formula and is of second order. The sweep allocates no memory.
//!
//! # How does Ctrl-C interrupt a sweep?
//!
//! A boundary value problem may have a `Listener`, which is polled every 4096 steps. If it requests
//! a stop, the sweep ends with `StepError::Stopped`, and the search knows whether a signal or the
//! clock was the reason. The best iterate is then recorded by a sweep without a listener, up to
//! 100,000 steps: beyond that, recording and writing alone would take longer than the answer may.
//! Stopping a solve never changes what it would have found.
//!
//! The cone solver accepts a closure with a static lifetime, which cannot hold a borrowed observer.
//! An observer may therefore provide a flag (`Observer::stop_flag`), which the solver reads between
//! its iterations. The solver reads it neither during its setup nor within an iteration, and on
//! fine grids one of these takes longer than an answer may. On such grids the solver runs on a
//! thread of its own, and the waiting thread polls the observer and the clock. After a stop that
//! thread is left behind. It owns all its data, reads its own flag, and ends with the current
//! iteration; the end of the process also ends it. While results are written only the writing can
//! be stopped: a signal then ends the program, and the file does not appear.

use crate::maneuver::grid::Grid;
use crate::maneuver::problem::{Problem, State};
use crate::mechanics::environment::{Pose, Wrench};
use crate::numerics::compensated::Sum;
use crate::numerics::widest::widest;
use crate::optimize::discrete::step::drift::Drift;
use crate::optimize::discrete::step::kick::Kick;
use crate::optimize::discrete::step::{Costate, Dynamics, Point, Sensitivity, StepError};
use crate::optimize::discrete::terminal::TerminalCondition;
use crate::{Matrix3, Vector3};
use nalgebra::{SMatrix, SVector};
use std::fmt;

/// Two-point boundary value problem of the necessary conditions, on one grid, in scaled units.
#[derive(Clone)]
pub struct BoundaryValueProblem<'a, const N: usize> {
    pub(crate) dynamics: Dynamics,
    pub(crate) start: Point,
    pub(crate) terminal: TerminalCondition,
    /// Listener that is polled during a sweep, since a million steps take longer than a user waits;
    /// `None` if sweeps cannot be stopped.
    listener: Option<&'a dyn Listener>,
}

/// Source of stop requests for a sweep.
pub(crate) trait Listener {
    /// Returns whether the user interrupted the work, or the time limit is reached.
    fn asks_to_stop(&self) -> bool;
}

/// Number of steps of a sweep between two checks for a stop request or the deadline. This many
/// steps take a few milliseconds.
const PATIENCE: usize = 4096;

/// Largest number of steps for which the best iterate is still swept and recorded after a stop
/// request.
const KEPT_AFTER_STOP: usize = 100_000;

/// Result at the end of a sweep.
#[derive(Clone, Copy, Debug)]
pub struct End<const N: usize> {
    /// Error of the terminal condition, in the order x, γ, ζ, Π, scaled: `[log(R_dᵀ R_N); Π_N −
    /// Π_d]` if the whole state of a rotation is given.
    pub error: SVector<f64, N>,
    /// Cost of the extremal, scaled.
    pub cost: f64,
}

impl<const N: usize> End<N> {
    /// Returns the largest of the errors of attitude, momentum, position and linear momentum.
    pub(crate) fn residual(&self) -> f64 {
        let blocks = (0..N / 3).map(|block| self.error.fixed_rows::<3>(3 * block).norm());
        blocks.fold(0.0, f64::max)
    }
}

/// Costate and state at one node of the sweep, as passed to an observer.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Node {
    /// Index of the node, 0 … N.
    pub index: usize,
    /// State at the node, with the momenta of the integrator.
    pub point: Point,
    /// Force and moment of the kick at the node. The physical momenta contain a part of this kick
    /// whose weight is smaller by `ahead`.
    pub kick: (Vector3, Vector3),
    /// Weight of the part of this kick that the momenta of the integrator include and the physical
    /// momenta do not.
    pub ahead: f64,
    /// Costate `λ_{index−1}`.
    pub costate: Costate,
}

/// One step of a sweep with derivatives, as passed to an observer.
pub(crate) struct Step<'a, const N: usize> {
    /// Index of the node at the end of the step, 1 … N.
    pub index: usize,
    /// Weight of the full kick of the step.
    pub weight: f64,
    /// Pose at the end of the step.
    pub pose: Pose,
    pub drift: Drift,
    pub kick: Kick,
    /// Costate before the drift (`before`) and after the full kick (`after`).
    pub before: Costate,
    pub after: Costate,
    /// Derivatives of state and costate after the full kick.
    pub columns: &'a Sensitivity<N>,
}

impl<const N: usize> fmt::Debug for BoundaryValueProblem<'_, N> {
    fn fmt(&self, formatter: &mut fmt::Formatter) -> fmt::Result {
        let Self { dynamics, start, terminal, listener: _ } = self;
        let mut shown = formatter.debug_struct("BoundaryValueProblem");
        shown
            .field("dynamics", dynamics)
            .field("start", start)
            .field("terminal", terminal)
            .finish_non_exhaustive()
    }
}

impl<'a, const N: usize> BoundaryValueProblem<'a, N> {
    /// Builds the boundary value problem of `problem` on a uniform grid of `steps` steps.
    pub fn new(problem: &Problem, steps: usize) -> Self {
        Self::on(problem, Grid::uniform(problem.scheme, 1.0, steps))
    }

    /// Builds the boundary value problem of `problem` on a grid in the unit of time, which is the
    /// duration of the problem.
    pub(crate) fn on(problem: &Problem, grid: Grid) -> Self {
        let dynamics = Dynamics::on(problem, grid);
        let start = dynamics.point(&problem.start);
        let terminal = TerminalCondition::of(&problem.end_condition, dynamics.point(&problem.end));
        Self { dynamics, start, terminal, listener: None }
    }

    /// Returns the problem on a uniform grid of `steps` steps, without a listener.
    pub(crate) fn on_steps(&self, steps: usize) -> BoundaryValueProblem<'static, N> {
        let dynamics = &self.dynamics;
        let dynamics =
            dynamics.on_grid(Grid::uniform(dynamics.grid.scheme(), dynamics.grid.duration(), steps));
        let (start, terminal) = (self.start, self.terminal);
        BoundaryValueProblem { dynamics, start, terminal, listener: None }
    }

    /// Returns the problem with a listener: its sweeps end with [`StepError::Stopped`] when
    /// `listener` requests a stop.
    pub(crate) fn heard_by(self, listener: &'a dyn Listener) -> Self {
        Self { listener: Some(listener), ..self }
    }

    /// Returns the problem with another end state of the maneuver.
    pub(crate) fn aimed(&self, end: &State) -> Self {
        Self { terminal: self.terminal.aimed(self.dynamics.point(end)), ..self.clone() }
    }

    /// Returns whether a sweep is short enough to record the best iterate after a stop.
    pub(crate) fn is_kept_after_stop(&self) -> bool {
        self.dynamics.grid.steps() <= KEPT_AFTER_STOP
    }

    /// Returns the problem without a listener, so that its sweeps are never stopped.
    pub(crate) fn undisturbed(&self) -> BoundaryValueProblem<'static, N> {
        let (dynamics, start, terminal) = self.parts();
        BoundaryValueProblem::of_parts(dynamics, start, terminal)
    }

    /// Returns the parts of the problem without the listener, which must stay on its thread.
    pub(crate) fn parts(&self) -> (&Dynamics, Point, TerminalCondition) {
        (&self.dynamics, self.start, self.terminal)
    }

    /// Assembles a problem without a listener from its parts.
    pub(crate) fn of_parts(dynamics: &Dynamics, start: Point, terminal: TerminalCondition) -> Self {
        Self { dynamics: dynamics.clone(), start, terminal, listener: None }
    }

    /// Sweeps from the first costate `λ_{−1} = costate` to the end of the maneuver.
    #[inline(never)]
    pub fn sweep(&self, costate: &SVector<f64, N>) -> Result<End<N>, StepError> {
        self.run_wide::<false>(costate, &mut Sensitivity::zero(), |_| {})
    }

    /// Sweeps from the first costate `λ_{−1} = costate` and appends every node to `nodes`.
    pub(crate) fn sweep_into(
        &self,
        costate: &SVector<f64, N>,
        nodes: &mut Vec<Node>,
    ) -> Result<End<N>, StepError> {
        self.run_wide::<false>(costate, &mut Sensitivity::zero(), |node| nodes.push(node))
    }

    /// Sweeps from the first costate `λ_{−1} = costate` and passes every node to `observe`.
    pub(crate) fn sweep_observed(
        &self,
        costate: &SVector<f64, N>,
        observe: impl FnMut(Node),
    ) -> Result<End<N>, StepError> {
        self.run::<false>(costate, &mut Sensitivity::zero(), observe, |_| {})
    }

    /// Sweeps from `λ_{−1} = costate` and computes the derivative of the terminal error, N×N; it is
    /// `Ψ₁₂ = ∂z_N/∂λ_{−1}` if the whole state is given.
    pub fn sweep_linearized(
        &self,
        costate: &SVector<f64, N>,
    ) -> Result<(End<N>, SMatrix<f64, N, N>), StepError> {
        let mut columns = Sensitivity::of_costate();
        let end = self.run_wide::<true>(costate, &mut columns, |_| {})?;
        self.with_slope(end, &columns)
    }

    /// Sweeps as [`BoundaryValueProblem::sweep_linearized`] does, and passes every step to `watch`.
    pub(crate) fn sweep_conjugate(
        &self,
        costate: &SVector<f64, N>,
        watch: impl FnMut(&Step<N>),
    ) -> Result<(End<N>, SMatrix<f64, N, N>), StepError> {
        let mut columns = Sensitivity::of_costate();
        let end = self.run::<true>(costate, &mut columns, |_| {}, watch)?;
        self.with_slope(end, &columns)
    }

    /// Combines the end of a sweep with the derivative of its terminal error.
    fn with_slope(
        &self,
        end: End<N>,
        columns: &Sensitivity<N>,
    ) -> Result<(End<N>, SMatrix<f64, N, N>), StepError> {
        let psi = self.terminal.slope(columns);
        if !psi.iter().all(|value| value.is_finite()) {
            return Err(StepError::NotFinite);
        }
        Ok((end, psi))
    }

    /// Runs the sweep; `DERIVE` decides whether the derivatives `columns` are propagated.
    #[inline(always)]
    fn run<const DERIVE: bool>(
        &self,
        costate: &SVector<f64, N>,
        columns: &mut Sensitivity<N>,
        observe: impl FnMut(Node),
        watch: impl FnMut(&Step<N>),
    ) -> Result<End<N>, StepError> {
        match (self.dynamics.is_limited(), self.dynamics.grid.is_uniform()) {
            (true, true) => self.run_of::<DERIVE, true, true>(costate, columns, observe, watch),
            (true, false) => self.run_of::<DERIVE, true, false>(costate, columns, observe, watch),
            (false, true) => self.run_of::<DERIVE, false, true>(costate, columns, observe, watch),
            (false, false) => self.run_of::<DERIVE, false, false>(costate, columns, observe, watch),
        }
    }

    /// Runs the sweep with the widest vector registers if inputs have no limits and the grid is
    /// uniform. It takes no `watch`: reading the columns between two steps would stall the loop.
    #[inline(always)]
    fn run_wide<const DERIVE: bool>(
        &self,
        costate: &SVector<f64, N>,
        columns: &mut Sensitivity<N>,
        observe: impl FnMut(Node),
    ) -> Result<End<N>, StepError> {
        if self.dynamics.is_limited() || !self.dynamics.grid.is_uniform() {
            return self.run::<DERIVE>(costate, columns, observe, |_| {});
        }
        widest(
            #[inline(always)]
            || self.steps_of::<DERIVE, false, true>(costate, columns, observe, |_| {}),
        )
    }

    /// Runs the sweep for limited or unlimited inputs, on a uniform or another grid; each variant
    /// compiles to its own loop.
    #[inline]
    fn run_of<const DERIVE: bool, const LIMITED: bool, const UNIFORM: bool>(
        &self,
        costate: &SVector<f64, N>,
        columns: &mut Sensitivity<N>,
        observe: impl FnMut(Node),
        watch: impl FnMut(&Step<N>),
    ) -> Result<End<N>, StepError> {
        self.steps_of::<DERIVE, LIMITED, UNIFORM>(costate, columns, observe, watch)
    }

    /// Runs all steps of the sweep, inlined so that it uses the registers of its caller.
    #[inline(always)]
    fn steps_of<const DERIVE: bool, const LIMITED: bool, const UNIFORM: bool>(
        &self,
        costate: &SVector<f64, N>,
        columns: &mut Sensitivity<N>,
        mut observe: impl FnMut(Node),
        mut watch: impl FnMut(&Step<N>),
    ) -> Result<End<N>, StepError> {
        let dynamics = &self.dynamics;
        let grid = &dynamics.grid;
        let (steps, half_kicks) = (grid.steps(), grid.has_half_kicks());
        // Read once if all steps have one length: a call in the loop would spill its registers.
        let (length, half_step) = (grid.full_kick(0), grid.ahead(0));
        let mut point = self.start;
        let mut costate = Costate::from_vector(costate);
        let mut effort = 0.0;
        let mut last_kick = (Vector3::zeros(), Vector3::zeros());
        if half_kicks {
            let half = grid.kick(0);
            let pose = point.pose();
            let kick = dynamics.kick_of::<N, LIMITED>(&pose, &costate);
            if DERIVE {
                dynamics.linear_kick::<N>(&pose, &costate).apply(columns, half, 0.0);
            }
            kick.apply::<N>(&mut point, &mut costate, half, 0.0);
            effort += 0.5 * (kick.effort * grid.share(0));
            last_kick = (kick.force, kick.moment);
        }
        observe(Node { index: 0, point, kick: last_kick, ahead: grid.ahead(0), costate });
        for index in 1..=steps {
            if index % PATIENCE == 0 && self.is_stopped() {
                return Err(StepError::Stopped);
            }
            let (h, share, ahead) = if UNIFORM {
                (length, 1.0, half_step)
            } else {
                (grid.full_kick(index), grid.share(index), grid.ahead(index))
            };
            let drift = dynamics.drift::<N>(index - 1, &mut point)?;
            let e = dynamics.drift_matrix(&drift);
            let before = costate;
            costate = drift.costate::<N>(&e, &before);
            let pose = point.pose();
            let kick = dynamics.kick_of::<N, LIMITED>(&pose, &costate);
            let last = half_kicks && index == steps;
            let mut kicked = point;
            if DERIVE {
                dynamics.linear_drift(&drift, &e, &costate).advance(columns);
                let linear = dynamics.linear_kick::<N>(&pose, &costate);
                kick.apply::<N>(&mut kicked, &mut costate, h, h);
                let watched =
                    |columns| Step { index, weight: h, pose, drift, kick, before, after: costate, columns };
                if last {
                    let mut full = *columns;
                    linear.apply(&mut full, h, h);
                    watch(&watched(&full));
                    linear.apply(columns, 0.5 * h, 0.5 * h);
                } else {
                    linear.apply(columns, h, h);
                    watch(&watched(columns));
                }
            } else {
                kick.apply::<N>(&mut kicked, &mut costate, h, h);
            }
            let part = kick.effort * share;
            effort += if last { 0.5 * part } else { part };
            if half_kicks {
                last_kick = (kick.force, kick.moment);
            }
            observe(Node { index, point: kicked, kick: last_kick, ahead, costate });
            if last {
                // The costate has received the whole kick. Half of it is undone, to obtain the
                // costate of the physical state.
                kick.apply::<N>(&mut point, &mut costate, 0.5 * h, -0.5 * h);
            } else {
                point = kicked;
            }
        }
        let error = self.terminal.value::<N>(&point, &costate);
        let cost = effort * grid.mean_step();
        if error.iter().all(|value| value.is_finite()) && cost.is_finite() {
            Ok(End { error, cost })
        } else {
            Err(StepError::NotFinite)
        }
    }

    /// Passes the attitudes of the motion without inputs to `observe`, node by node. If the body
    /// keeps its attitude, only the first is passed.
    pub(crate) fn coast(&self, mut observe: impl FnMut(&Matrix3)) -> Result<(), StepError> {
        let Self { dynamics, start, .. } = self;
        let (mut point, none) = (*start, Wrench::zero());
        observe(&point.attitude.value);
        if dynamics.stands(&point) {
            return Ok(());
        }
        dynamics.bare_kick::<N>(&mut point, dynamics.grid.kick(0), &none);
        for step in 0..dynamics.grid.steps() {
            if step % PATIENCE == PATIENCE - 1 && self.is_stopped() {
                return Err(StepError::Stopped);
            }
            dynamics.drift::<N>(step, &mut point)?;
            observe(&point.attitude.value);
            dynamics.bare_kick::<N>(&mut point, dynamics.grid.full_kick(step + 1), &none);
        }
        Ok(())
    }

    /// A function of its own, not inlined, so that it takes no registers of the loop of a sweep.
    #[cold]
    #[inline(never)]
    fn is_stopped(&self) -> bool {
        self.listener.is_some_and(Listener::asks_to_stop)
    }

    /// Returns the problem of the time-reversed motion: it starts at the target, with reversed
    /// momenta and reversed rotation of the reference frame.
    pub(crate) fn reversed(&self) -> Self {
        let back = |point: &Point| Point {
            momentum: Sum::new(-point.momentum.value),
            linear_momentum: Sum::new(-point.linear_momentum.value),
            ..*point
        };
        Self {
            dynamics: self.dynamics.reversed(),
            start: back(self.terminal.target()),
            terminal: TerminalCondition::State(back(&self.start)),
            listener: self.listener,
        }
    }

    /// Returns the problem with every limit of the inputs multiplied by `factor`.
    pub(crate) fn relaxed(&self, factor: f64) -> Self {
        Self { dynamics: self.dynamics.relaxed(factor), ..self.clone() }
    }

    /// Returns the largest ratio of an unlimited optimal input to its limit, over the extremal
    /// whose first costate is `costate`.
    pub(crate) fn demand(&self, costate: &SVector<f64, N>) -> Result<f64, StepError> {
        let mut largest = 0.0f64;
        self.sweep_observed(costate, |node| {
            // Lie–Euler has no input at the start.
            if node.index >= self.dynamics.grid.first_input() {
                largest = largest.max(self.dynamics.demand(&node.point.pose(), &node.costate));
            }
        })?;
        Ok(largest)
    }
}

impl Node {
    /// Returns the physical state: the momenta of the integrator without the part of the last kick
    /// by which they are ahead.
    pub fn physical(&self) -> Point {
        let mut point = self.point;
        point.linear_momentum.add(&(self.kick.0 * -self.ahead));
        point.momentum.add(&(self.kick.1 * -self.ahead));
        point
    }
}

#[cfg(test)]
mod tests;
