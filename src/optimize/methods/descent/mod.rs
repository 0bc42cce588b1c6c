//! Descent on paths: Newton on the poses of the inner nodes, which ends at minima only.
//!
//! Every path is feasible, because its inputs follow by inverse dynamics ([`path`]). So the cost
//! itself is the merit function and falls at every iteration, no implicit equation is solved,
//! nothing is integrated, and an unstable body is no harder than another. The Newton direction and
//! the inertia of the Hessian come from one backward sweep ([`riccati`]): where the Hessian is not
//! positive definite it is shifted until it is, and a stationary path that is a saddle is left
//! along a direction of negative curvature.
//!
//! The descent needs inputs about every axis. Where some are missing it works with a widened
//! authority ([`Dynamics::widened`]), whose minima bound the true ones of the same branch from
//! below.

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

/// Rows of configurations, or of momenta: ζ and δΠ, with δx and δγ before them where the body
/// translates.
type Half<const D: usize> = SVector<f64, D>;
/// A matrix between two of them.
type Block<const D: usize> = SMatrix<f64, D, D>;

/// Longest move of a node by a first trial \[rad, or unit lengths\].
const LONGEST: f64 = 1.5;
/// Halvings of an undamped step before a damped direction is taken instead.
const HALVINGS: usize = 6;
/// Halvings of a step at all.
const MOST_HALVINGS: usize = 20;
/// First shift of a Hessian that is not positive definite. The lowest mode of a clamped beam has
/// the curvature 4.73⁴ = 500 in the same units; the result hardly depends on it between 10 and 300.
const FIRST_SHIFT: f64 = 30.0;
/// Smallest shift, largest shift, and the factor between one and the next.
const LEAST_SHIFT: f64 = 3.0;
const MOST_SHIFT: f64 = 1e9;
const RAISE: f64 = 5.0;
/// A path whose cost the model would lower by less, relative, is stationary enough to ask whether
/// it is a saddle.
const NEARLY_STATIONARY: f64 = 1e-4;
/// Lengths tried along a direction of negative curvature \[rad, or unit lengths\].
const ESCAPES: [f64; 9] = [1.0, 0.3, 0.1, 0.03, 0.01, 3e-3, 1e-3, 3e-4, 1e-4];
/// A Newton step that is expected to end within this of the cost of a known minimum, relative, ...
const SAME_COST: f64 = 1e-4;
/// ... and ends within this of each of its nodes \[rad, or unit lengths\], leads to no other: two
/// minima as close differ in cost by the cube of that.
const SAME_PLACE: f64 = 3e-3;
/// Costs below this count as nothing: the unit is that of a turn by one radian.
const NO_COST: f64 = 1e-20;
/// Iterations of a descent cost a fraction of others, and narrow valleys take many: so many for
/// each that is granted.
const PATIENCE: usize = 4;
/// Fewest steps with an inner node on either side of an elimination.
pub(crate) const FEWEST_STEPS: usize = 6;

/// Descends from the poses of a candidate to a local minimum.
pub(crate) struct Descent<'a> {
    /// With inputs about every axis.
    pub dynamics: &'a Dynamics,
    pub start: &'a Point,
    pub target: &'a Point,
    /// Whether the body translates.
    pub translates: bool,
    /// Decrease of the cost that the model still promises at the end, relative.
    pub tolerance: f64,
    /// Minima that descents on the same dynamics have ended at: one that runs into them ends there.
    pub known: &'a [Attempt],
}

impl Method for Descent<'_> {
    /// The candidate comes back with states and costates of all nodes, stationary to the square
    /// root of the tolerance, and with the cost of its path.
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

    /// The path of a candidate; `None` where the grid is too coarse for it.
    fn path<const N: usize, const D: usize>(
        &self,
        candidate: &Candidate,
    ) -> Option<(Setting<'_, N, D>, Path<D>)> {
        let setting = Setting::new(self.dynamics, self.start, self.target).ok()?;
        let path = Path::of(&setting, candidate.states.iter().map(Point::pose).collect())?;
        Some((setting, path))
    }

    /// States and costates of all nodes of a path by inverse dynamics, for the lifted Newton.
    pub fn lifted(&self, candidate: Candidate) -> Option<Candidate> {
        if self.translates {
            self.path::<12, 6>(&candidate).map(|(setting, path)| path.into_candidate(&setting, candidate))
        } else {
            self.path::<6, 3>(&candidate).map(|(setting, path)| path.into_candidate(&setting, candidate))
        }
    }
}

/// The iteration.
struct Descending<'a, const N: usize, const D: usize> {
    setting: &'a Setting<'a, N, D>,
    path: Path<D>,
    /// A path that is tried.
    trial: Path<D>,
    backward: Backward<D>,
    direction: Direction<D>,
    tolerance: f64,
    /// The shift that was needed last.
    shift: f64,
    /// What the model promised last, relative to the cost.
    promised: f64,
    /// Whether the path is a minimum.
    minimal: bool,
    known: &'a [Attempt],
    /// The known minimum that it runs into.
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
            // The whole cost, before anything is known.
            promised: 1.0,
            minimal: false,
            known,
            met: None,
        }
    }

    /// The known minimum that the undamped step leads to, where it does.
    fn runs_into(&mut self) -> Option<&'a Attempt> {
        // A step along which the cost is a parabola lowers it by half of what its slope promises.
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
                // By the chord: |R − R'| = 2√2 sin(θ/2).
                let chord = (pose.attitude - state.attitude.value).norm() / SQRT_2;
                shift <= SAME_PLACE && chord <= SAME_PLACE
            })
        })
    }

    /// The cost that a relative decrease is measured by.
    fn scale(&self) -> f64 {
        self.path.cost + NO_COST
    }

    /// Shifts the Hessian, at least as far as `least`, until it is positive definite.
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

    /// Moves to the first of the halved steps that lowers the cost enough.
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

    /// Leaves a saddle along the direction of negative curvature at `stage`, to either side.
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
                // The step is the last digit of what was proved a minimum: it need not show in the
                // cost.
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
                // The sweep up to the failing stage holds the gains that the direction needs.
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
        // At the floor of round-off no step lowers the cost any more.
        self.minimal = undamped && self.promised <= self.tolerance.sqrt() * ARMIJO;
        Some(if self.minimal { Outcome::Converged } else { Outcome::Stalled })
    }
}

/// Both halves of a vector of the crate's order from translation and rotation.
fn half<const D: usize>(translation: &nalgebra::Vector3<f64>, rotation: &nalgebra::Vector3<f64>) -> Half<D> {
    SVector::from_fn(|row, _| if row + 3 >= D { rotation[row + 3 - D] } else { translation[row] })
}

/// Translation and rotation of a half.
fn parts<const D: usize>(half: &Half<D>) -> (nalgebra::Vector3<f64>, nalgebra::Vector3<f64>) {
    let part = |row: usize| nalgebra::Vector3::new(half[row], half[row + 1], half[row + 2]);
    (if D == 6 { part(0) } else { nalgebra::Vector3::zeros() }, part(D - 3))
}

/// A pose moved along a half of a tangent vector.
fn moved<const D: usize>(pose: &Pose, along: &Half<D>, fraction: f64) -> Pose {
    let (x, zeta) = parts(along);
    Pose { position: pose.position + x * fraction, attitude: pose.attitude * lie::exp(&(zeta * fraction)) }
}

/// A point at a pose with given momenta.
fn point(pose: &Pose, linear_momentum: nalgebra::Vector3<f64>, momentum: nalgebra::Vector3<f64>) -> Point {
    Point {
        position: Sum::new(pose.position),
        linear_momentum: Sum::new(linear_momentum),
        attitude: Sum::new(pose.attitude),
        momentum: Sum::new(momentum),
    }
}

/// A costate as the candidate keeps it.
fn stored<const N: usize>(costate: Costate) -> DVector<f64> {
    DVector::from_column_slice(costate.to_vector::<N>().as_slice())
}

#[cfg(test)]
mod tests;
