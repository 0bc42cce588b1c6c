//! Descent on paths: Newton on the poses of the inner nodes, which converges only to minima.
//!
//! Every path is feasible, because its inputs follow by inverse dynamics ([`path`]). Therefore the
//! cost itself is the merit function and decreases at every iteration. No implicit equation is
//! solved and nothing is integrated, so that an unstable body is no harder than another. The Newton
//! direction and the inertia of the Hessian come from one backward sweep ([`riccati`]). If the
//! Hessian is not positive definite, it is shifted until it is. The descent leaves a saddle along a
//! direction of negative curvature.
//!
//! The descent needs inputs about every axis. If some are missing, it uses a widened authority
//! ([`Dynamics::widened`]), whose minima are lower bounds of the true minima of the same branch.

mod path;
mod riccati;

use crate::lie;
use crate::maneuver::solution::Outcome;
use crate::mechanics::environment::Pose;
use crate::numerics::compensated::Sum;
use crate::optimize::discrete::candidate::Candidate;
use crate::optimize::discrete::step::{Costate, Dynamics, Point};
use crate::optimize::methods::ARMIJO;
use crate::optimize::methods::driver::{Iteration, run};
use crate::optimize::methods::method::{Attempt, Budget, Method};
use nalgebra::{DVector, SMatrix, SVector};
use path::{Direction, Path, Setting};
use riccati::{Backward, Shift};
use std::f64::consts::SQRT_2;

/// Configuration rows or momentum rows of a vector: ζ or δΠ, preceded by δx or δγ if the body
/// translates.
type Half<const D: usize> = SVector<f64, D>;
/// Matrix between configuration or momentum rows.
type Block<const D: usize> = SMatrix<f64, D, D>;

/// Largest displacement of a node in the first trial of a line search \[rad, or unit lengths\].
const LONGEST: f64 = 1.5;
/// Largest number of halvings of an undamped step before a damped direction is used.
const HALVINGS: usize = 6;
/// Largest number of halvings of a damped step in a line search.
const MOST_HALVINGS: usize = 20;
/// First shift of a Hessian that is not positive definite. The lowest mode of a clamped beam has
/// the curvature 4.73⁴ = 500 in these units; the result hardly depends on the value between 10 and
/// 300.
const FIRST_SHIFT: f64 = 30.0;
/// Smallest shift of a Hessian that is not positive definite.
const LEAST_SHIFT: f64 = 3.0;
/// Largest shift of the Hessian; if it does not suffice, the descent ends.
const MOST_SHIFT: f64 = 1e9;
/// Factor from one shift of the Hessian to the next. A larger factor needs fewer sweeps and damps
/// more than necessary.
const RAISE: f64 = 5.0;
/// Predicted relative decrease of the cost below which a path is nearly stationary and is tested
/// for a saddle.
const NEARLY_STATIONARY: f64 = 1e-4;
/// Displacements that are tried along a direction of negative curvature \[rad, or unit lengths\].
const ESCAPES: [f64; 9] = [1.0, 0.3, 0.1, 0.03, 0.01, 3e-3, 1e-3, 3e-4, 1e-4];
/// Relative difference to the cost of a known minimum below which the cost predicted for a Newton
/// step may be the same minimum.
const SAME_COST: f64 = 1e-4;
/// Largest distance of a node from the known minimum, after an undamped Newton step, at which the
/// step leads to this minimum \[rad, or unit lengths\]. Two different minima at this distance
/// differ in cost by its cube.
const SAME_PLACE: f64 = 3e-3;
/// Cost below which a path counts as free of cost, in units of the cost of a turn by one radian.
const NO_COST: f64 = 1e-20;
/// Factor on the number of iterations that the settings allow: an iteration of a descent is cheap,
/// and narrow valleys take many.
const PATIENCE: usize = 4;
/// Smallest number of steps of a path on which a descent is possible: each side of the elimination
/// then has an inner node.
pub(crate) const FEWEST_STEPS: usize = 6;

/// Method that starts from the poses of a candidate and decreases the cost to a local minimum.
pub(crate) struct Descent<'a> {
    /// Dynamics with inputs about every axis.
    pub dynamics: &'a Dynamics,
    pub start: &'a Point,
    pub target: &'a Point,
    /// True if the body translates.
    pub translates: bool,
    /// Predicted relative decrease of the cost at which the descent ends.
    pub tolerance: f64,
    /// Minima that earlier descents with these dynamics reached; a descent that approaches one of
    /// them ends there.
    pub known: &'a [Attempt],
}

impl Method for Descent<'_> {
    /// Returns the candidate with states and costates of all nodes, stationary to the square root
    /// of the tolerance, and with the cost of its path.
    fn improve(&self, candidate: Candidate, budget: &Budget) -> Attempt {
        if self.translates {
            self.descend::<12, 6>(candidate, budget)
        } else {
            self.descend::<6, 3>(candidate, budget)
        }
    }
}

impl Descent<'_> {
    fn descend<const N: usize, const D: usize>(&self, candidate: Candidate, budget: &Budget) -> Attempt {
        let enough = self.dynamics.grid.steps() >= FEWEST_STEPS;
        let started = self.path::<N, D>(&candidate).filter(|_| enough);
        let Some((setting, path)) = started else { return Attempt::failed(candidate, Outcome::StepTooLong) };
        let descending = Descending::new(&setting, path, self.tolerance, self.known);
        let (descending, report) = run(descending, PATIENCE * budget.iterations, budget.watch.interrupt);
        let residual = descending.residual();
        if let Some(known) = descending.met {
            let candidate = Candidate { provenance: candidate.provenance, ..known.candidate.clone() };
            return Attempt { cost: known.cost, residual, ..Attempt::of(candidate, report) };
        }
        let cost = descending.path.cost;
        let candidate = descending.path.into_candidate(&setting, candidate);
        Attempt { cost, residual, ..Attempt::of(candidate, report) }
    }

    /// Returns the path of a candidate; `None` if the grid is too coarse for the path.
    fn path<const N: usize, const D: usize>(
        &self,
        candidate: &Candidate,
    ) -> Option<(Setting<'_, N, D>, Path<D>)> {
        let setting = Setting::new(self.dynamics, self.start, self.target).ok()?;
        let path = Path::of(&setting, candidate.states.iter().map(Point::pose).collect())?;
        Some((setting, path))
    }

    /// Returns the candidate with states and costates of all nodes by inverse dynamics, for the
    /// lifted Newton method.
    pub fn lifted(&self, candidate: Candidate) -> Option<Candidate> {
        if self.translates {
            self.path::<12, 6>(&candidate).map(|(setting, path)| path.into_candidate(&setting, candidate))
        } else {
            self.path::<6, 3>(&candidate).map(|(setting, path)| path.into_candidate(&setting, candidate))
        }
    }
}

/// State of a descent: the path, its derivatives, and the direction.
struct Descending<'a, const N: usize, const D: usize> {
    setting: &'a Setting<'a, N, D>,
    path: Path<D>,
    /// Buffer for a trial path.
    trial: Path<D>,
    backward: Backward<D>,
    direction: Direction<D>,
    tolerance: f64,
    /// Shift of the Hessian in the last iteration that needed one.
    shift: f64,
    /// Last predicted decrease of the cost, relative to the cost.
    promised: f64,
    /// True if the current path is a local minimum.
    minimal: bool,
    known: &'a [Attempt],
    /// Known minimum that the descent approaches; `None` if it approaches none.
    met: Option<&'a Attempt>,
}

impl<'a, const N: usize, const D: usize> Descending<'a, N, D> {
    fn new(setting: &'a Setting<'a, N, D>, path: Path<D>, tolerance: f64, known: &'a [Attempt]) -> Self {
        let steps = setting.dynamics.grid.steps();
        Self {
            setting,
            trial: path.clone(),
            path,
            backward: Backward::new(steps),
            direction: Direction::new(steps),
            tolerance,
            shift: 0.0,
            // The whole cost, before the first prediction.
            promised: 1.0,
            minimal: false,
            known,
            met: None,
        }
    }

    /// Returns the known minimum to which the undamped Newton step leads; `None` if it leads to
    /// none of them.
    fn runs_into(&mut self) -> Option<&'a Attempt> {
        // If the cost is a parabola along a step, it decreases by half of the value that the slope
        // predicts.
        let expected = self.path.cost * (1.0 - 0.5 * self.promised);
        let known = self.known;
        let near = |known: &&Attempt| (known.cost - expected).abs() <= SAME_COST * known.cost;
        let mut near = known.iter().filter(near).peekable();
        near.peek()?;
        self.trial.moved(&self.path, &self.direction, 1.0);
        near.find(|known| {
            let nodes = self.trial.poses.iter().zip(&known.candidate.states);
            nodes.into_iter().all(|(pose, state)| {
                let shift = (pose.position - state.position.value).norm();
                // The angle θ between two attitudes follows from the chord: |R − R'| = 2√2
                // sin(θ/2).
                let chord = (pose.attitude - state.attitude.value).norm() / SQRT_2;
                shift <= SAME_PLACE && chord <= SAME_PLACE
            })
        })
    }

    /// Returns the reference cost for relative decreases.
    fn scale(&self) -> f64 {
        self.path.cost + NO_COST
    }

    /// Shifts the Hessian by `least` or more until it is positive definite; returns whether that
    /// succeeded.
    fn shifted(&mut self, least: f64) -> bool {
        let mut shift = least;
        while shift <= MOST_SHIFT {
            if self.backward.sweep(self.setting, &self.path, Shift(shift)).is_ok() {
                self.shift = shift;
                return true;
            }
            shift *= RAISE;
        }
        false
    }

    /// Halves the step until the cost decreases enough, at most `halvings` times; returns whether a
    /// step was accepted.
    fn search(&mut self, slope: f64, halvings: usize) -> bool {
        let mut fraction = (LONGEST / self.direction.largest()).min(1.0);
        for _ in 0..=halvings {
            self.trial.moved(&self.path, &self.direction, fraction);
            let enough = self.path.cost + ARMIJO * fraction * slope;
            if self.trial.evaluate(self.setting) && self.trial.cost <= enough {
                std::mem::swap(&mut self.path, &mut self.trial);
                return true;
            }
            fraction *= 0.5;
        }
        false
    }

    /// Leaves a saddle along the direction of negative curvature at `stage`, with either sign;
    /// returns whether the cost decreased.
    fn escape(&mut self, stage: usize) -> bool {
        self.backward.downward(self.setting, stage, &mut self.direction);
        let largest = self.direction.largest();
        let mut best = self.path.clone();
        for length in ESCAPES {
            for sign in [1.0, -1.0] {
                self.trial.moved(&self.path, &self.direction, sign * length / largest);
                if self.trial.evaluate(self.setting) && self.trial.cost < best.cost {
                    best.clone_from(&self.trial);
                }
            }
            if best.cost < self.path.cost {
                self.path = best;
                return true;
            }
        }
        false
    }
}

impl<const N: usize, const D: usize> Iteration for Descending<'_, N, D> {
    fn residual(&self) -> f64 {
        self.promised
    }

    fn converged(&self) -> bool {
        self.minimal
    }

    fn advance(&mut self) -> Option<Outcome> {
        self.path.differentiate(self.setting);
        self.backward.renew();
        let failed = self.backward.sweep(self.setting, &self.path, Shift(0.0)).err();
        if failed.is_some() {
            let least = if self.shift > 0.0 { (self.shift / RAISE).max(LEAST_SHIFT) } else { FIRST_SHIFT };
            if !self.shifted(least) {
                return Some(Outcome::Singular);
            }
        }
        self.backward.forward(self.setting, &mut self.direction);
        let slope = self.path.slope(&self.direction);
        self.promised = -slope / self.scale();
        if !self.promised.is_finite() {
            return Some(Outcome::NotFinite);
        }
        match failed {
            None if self.promised <= self.tolerance => {
                // A minimum has been proved, and this step adds the last digit: the cost need not
                // decrease measurably.
                self.search(f64::INFINITY, 0);
                self.minimal = true;
                return Some(Outcome::Converged);
            }
            None => {
                self.met = self.runs_into();
                if self.met.is_some() {
                    return Some(Outcome::Converged);
                }
            }
            Some(stage) if self.promised < NEARLY_STATIONARY => {
                // The sweep up to the failing stage computes the gains that the direction needs.
                let _ = self.backward.sweep(self.setting, &self.path, Shift(0.0));
                if self.escape(stage) {
                    return None;
                }
                if self.promised <= self.tolerance {
                    return Some(Outcome::Stalled);
                }
                if !self.shifted(self.shift) {
                    return Some(Outcome::Singular);
                }
                self.backward.forward(self.setting, &mut self.direction);
            }
            _ => {}
        }
        let undamped = failed.is_none();
        if self.search(slope, if undamped { HALVINGS } else { MOST_HALVINGS }) {
            return None;
        }
        if undamped && self.shifted(FIRST_SHIFT) {
            self.backward.forward(self.setting, &mut self.direction);
            let slope = self.path.slope(&self.direction);
            if self.search(slope, MOST_HALVINGS) {
                return None;
            }
        }
        // At the level of round-off no step decreases the cost further.
        self.minimal = undamped && self.promised <= self.tolerance.sqrt() * ARMIJO;
        Some(if self.minimal { Outcome::Converged } else { Outcome::Stalled })
    }
}

/// Combines translation and rotation to configuration or momentum rows: first the translation, if
/// the body translates, then the rotation.
fn half<const D: usize>(translation: &nalgebra::Vector3<f64>, rotation: &nalgebra::Vector3<f64>) -> Half<D> {
    SVector::from_fn(|row, _| if row + 3 >= D { rotation[row + 3 - D] } else { translation[row] })
}

/// Splits configuration or momentum rows into translation (zero if the body does not translate) and
/// rotation.
fn parts<const D: usize>(half: &Half<D>) -> (nalgebra::Vector3<f64>, nalgebra::Vector3<f64>) {
    let part = |row: usize| nalgebra::Vector3::new(half[row], half[row + 1], half[row + 2]);
    (if D == 6 { part(0) } else { nalgebra::Vector3::zeros() }, part(D - 3))
}

/// Returns a pose displaced along the configuration rows of a tangent vector.
fn moved<const D: usize>(pose: &Pose, along: &Half<D>, fraction: f64) -> Pose {
    let (x, zeta) = parts(along);
    Pose { position: pose.position + x * fraction, attitude: pose.attitude * lie::exp(&(zeta * fraction)) }
}

/// Returns a point at a pose with the given momenta.
fn point(pose: &Pose, linear_momentum: nalgebra::Vector3<f64>, momentum: nalgebra::Vector3<f64>) -> Point {
    Point {
        position: Sum::new(pose.position),
        linear_momentum: Sum::new(linear_momentum),
        attitude: Sum::new(pose.attitude),
        momentum: Sum::new(momentum),
    }
}

/// Converts a costate to the form that a candidate stores.
fn stored<const N: usize>(costate: Costate) -> DVector<f64> {
    DVector::from_column_slice(costate.to_vector::<N>().as_slice())
}

#[cfg(test)]
mod tests;
