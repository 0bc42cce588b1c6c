//! Landing of an extremal of the shooting: Newton's method on the first costate, towards the end of
//! the true motion.
//!
//! The sweep from any `λ_{−1}` is an extremal for the target that it reaches. So the corrections
//! need no inner solve: the costate changes by `−H e`, with the miss `e` of the true motion and the
//! inverse `H` of the discrete sensitivity. The sensitivity of a coarser grid is accurate enough.
//! The target is the end of the last sweep. A correction takes one sweep and one integration of the
//! true motion. From the second correction on, Broyden's update improves `H` from the observed
//! changes.

use super::{Aim, LANDED, MOST_CORRECTIONS, SHRUNK, largest};
use crate::flight::Held;
use crate::maneuver::problem::{Problem, State};
use crate::maneuver::solution::Landing;
use crate::numerics::factor::Factor;
use crate::optimize::discrete::step::Point;
use crate::optimize::discrete::sweep::{BoundaryValueProblem, Node};
use crate::{Vector3, lie};
use nalgebra::{SMatrix, SVector};

/// Step of finite differences in a costate, relative to its largest component.
const DIFFERENCE: f64 = 1e-7;

/// Step fractions that are tried in turn if the full step does not reduce the miss enough.
const SHARES: [f64; 3] = [0.5, 0.25, 0.1];

/// Extremal whose true motion has the smallest miss that the corrections reached.
pub(crate) struct LandedCostate<const N: usize> {
    pub costate: SVector<f64, N>,
    /// Nodes of the sweep, scaled.
    pub nodes: Vec<Node>,
    pub cost: f64,
    /// End of the discrete motion: the target for which this is an extremal.
    pub target: Point,
    pub state: State,
    pub landing: Landing,
}

/// Result of one sweep and of the true motion under its inputs.
struct LandingTrial<const N: usize> {
    costate: SVector<f64, N>,
    nodes: Vec<Node>,
    cost: f64,
    miss: SVector<f64, N>,
    size: f64,
}

/// Lands the extremal whose first costate is `costate`; returns `None` if the first sweep or the
/// first true motion fails. If `stopped` returns true, the best result so far is returned.
pub(crate) fn land_costate<const N: usize>(
    problem: &Problem,
    bvp: &BoundaryValueProblem<N>,
    coarse: &BoundaryValueProblem<N>,
    costate: &SVector<f64, N>,
    stopped: &dyn Fn() -> bool,
) -> Option<LandedCostate<N>> {
    let mut aim = Aim::of(problem);
    let mut best = tried(&mut aim, bvp, *costate, Vec::new())?;
    let mut misses = vec![best.size];
    let mut slopes = Slope::ALL.into_iter();
    let mut inverse: Option<SMatrix<f64, N, N>> = None;
    // Miss at the point at which the derivative of the true motion was last computed.
    let mut differenced = f64::INFINITY;
    let mut spare = Vec::new();
    while best.size > LANDED && misses.len() <= MOST_CORRECTIONS && !stopped() {
        let h = match inverse {
            Some(h) => h,
            None => {
                // The miss is not smooth where an input reaches its limit. If the last derivative
                // reduced the miss, a new derivative may reduce it to zero.
                let nearer = best.size < differenced;
                let Some(slope) = slopes.next().or(nearer.then_some(Slope::True)) else { break };
                if matches!(slope, Slope::True) {
                    differenced = best.size;
                }
                let Some(h) = slope.inverse(&mut aim, bvp, coarse, &best) else { continue };
                h
            }
        };
        let step = -(h * best.miss);
        let whole = tried(&mut aim, bvp, best.costate + step, std::mem::take(&mut spare));
        let good = |next: &LandingTrial<N>| next.size <= SHRUNK * best.size;
        // Step fractions are tried only with the last kind of derivative.
        let found = whole.filter(good).or_else(|| {
            let mut shares = SHARES.into_iter().filter(|_| slopes.len() == 0);
            shares.find_map(|share| {
                let next = tried(&mut aim, bvp, best.costate + share * step, Vec::new())?;
                (next.size < (1.0 - 0.5 * share) * best.size).then_some(next)
            })
        });
        let Some(next) = found else {
            inverse = None;
            continue;
        };
        // Broyden's update of the inverse, `H += (s − H y) sᵀH/(sᵀ H y)`.
        let (s, y) = (next.costate - best.costate, next.miss - best.miss);
        let answer = h * y;
        let along = s.dot(&answer);
        let update = (s - answer) * (s.transpose() * h) / along;
        inverse = Some(if update.iter().all(|value| value.is_finite()) { h + update } else { h });
        spare = std::mem::replace(&mut best, next).nodes;
        misses.push(best.size);
    }
    let target = best.nodes.last()?.physical();
    let state = state_of(problem, bvp, &target);
    let landing =
        Landing { corrections: misses.len() - 1, misses, cost_before: f64::NAN, drawn_in: Vec::new() };
    let LandingTrial { costate, nodes, cost, .. } = best;
    Some(LandedCostate { costate, nodes, cost, target, state, landing })
}

/// The motion that supplies the derivative of the miss with respect to the costate, from the
/// cheapest to the most costly. If steps with one derivative do not reduce the miss, the next is
/// used.
#[derive(Clone, Copy)]
enum Slope {
    /// Discrete motion on a coarser grid.
    Coarse,
    /// Discrete motion on the grid of the plan.
    Fine,
    /// True motion, by finite differences.
    True,
}

impl Slope {
    const ALL: [Self; 3] = [Self::Coarse, Self::Fine, Self::True];

    /// Computes the inverse of the derivative of the miss; `None` if it is not finite.
    fn inverse<const N: usize>(
        self,
        aim: &mut Aim,
        bvp: &BoundaryValueProblem<N>,
        coarse: &BoundaryValueProblem<N>,
        at: &LandingTrial<N>,
    ) -> Option<SMatrix<f64, N, N>> {
        let slope = match self {
            Self::Coarse => coarse.sweep_linearized(&at.costate).ok()?.1,
            Self::Fine => bvp.sweep_linearized(&at.costate).ok()?.1,
            Self::True => {
                let mut slope = SMatrix::<f64, N, N>::zeros();
                let size = DIFFERENCE * at.costate.amax().max(f64::MIN_POSITIVE);
                for column in 0..N {
                    let mut moved = at.costate;
                    moved[column] += size;
                    let there = tried(aim, bvp, moved, Vec::new())?;
                    slope.set_column(column, &((there.miss - at.miss) / size));
                }
                slope
            }
        };
        let usable = slope.iter().all(|value| value.is_finite());
        usable.then(|| Factor::new(&slope).solve_matrix(&SMatrix::identity()))
    }
}

/// Sweeps from `costate` and integrates the true motion under the resulting inputs; `None` if the
/// sweep or the integration fails.
fn tried<const N: usize>(
    aim: &mut Aim,
    bvp: &BoundaryValueProblem<N>,
    costate: SVector<f64, N>,
    mut nodes: Vec<Node>,
) -> Option<LandingTrial<N>> {
    nodes.clear();
    let cost = bvp.sweep_into(&costate, &mut nodes).ok()?.cost;
    let (flown, _) = aim.flown(&held(bvp, &nodes))?;
    let blocks = aim.miss(&flown, bvp.dynamics.units.time);
    let first = if N == 12 { 0 } else { 2 };
    let miss = SVector::from_fn(|row, _| blocks[first + row / 3][row % 3]);
    Some(LandingTrial { costate, nodes, cost, miss, size: largest(&blocks) })
}

/// Returns the held forces and torques of an extremal and the length of each step, in SI units. The
/// inputs are resolved in the axis frames of their actuator sets.
fn held<const N: usize>(bvp: &BoundaryValueProblem<N>, nodes: &[Node]) -> Vec<(Held, f64)> {
    let (dynamics, grid) = (&bvp.dynamics, &bvp.dynamics.grid);
    let units = &dynamics.units;
    let output = |node: &Node| {
        let (force, torque) = dynamics.outputs(&node.point.pose(), &node.costate);
        let (force, torque) = (force * units.force(), torque * units.torque());
        Held { force, torque, outside: Vector3::zeros() }
    };
    let first = grid.first_input();
    let mut before = (first == 0).then(|| output(&nodes[0]));
    (0..grid.steps())
        .map(|k| {
            let after = output(&nodes[k + 1]);
            let held = before.map_or(after, |before| before.mean(&after));
            before = (first == 0).then_some(after);
            (held, grid.step(k) * units.time)
        })
        .collect()
}

/// Converts a point of the sweep to a state in SI units.
fn state_of<const N: usize>(problem: &Problem, bvp: &BoundaryValueProblem<N>, point: &Point) -> State {
    let (dynamics, moves) = (&bvp.dynamics, N == 12);
    let units = &dynamics.units;
    let length = if moves { units.length } else { 0.0 };
    let rate: Vector3 = problem.body.inertia.j_inverse() * point.momentum.value;
    let attitude = lie::project_to_rotation(&point.attitude.value);
    State {
        position: point.position.value * length,
        velocity: point.linear_momentum.value * (length / units.time),
        attitude,
        angular_velocity: rate * units.momentum(),
    }
}
