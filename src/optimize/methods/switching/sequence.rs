//! A sequence of arcs, over the continuous flow or over the steps of a grid: derivatives of the
//! terminal error and of the Hamiltonians with respect to costates and arc lengths.
//!
//! ```text
//! c(d, λ) = e(d) ,      ∂L/∂d_a = H_a      with the lengths d, the costates λ = (M, e_0) at the start
//! ```
//!
//! These are the KKT conditions of minimum cost ([`KktSystem`]). `H_a` is the Hamiltonian on arc a
//! of the flow, or the mean of the discrete Hamiltonians of its steps. It is linear in `λ` where
//! torques are held, and `∂c/∂λ` vanishes there.
//!
//! Every step may start from its own stored node. If Newton continues from a path, lanes carry from
//! node to node the derivatives with respect to costates, lengths and the gaps between steps. With
//! them the nodes are eliminated from the Newton step and updated afterwards, so that only
//! derivatives grow along the maneuver (Bock's condensing of multiple shooting).

#![expect(
    clippy::needless_range_loop,
    reason = "iterators are calls of their own, and narrow in widened code"
)]

use super::extremal::{ArcLaw, Extremal};
use super::flow::{Course, Lanes, Node};
use super::grid_step::{StepMap, Torque};
use super::tuning::arcs::MOST_STEPS;
use crate::numerics::three::{apply, apply_transposed, cross, product};
use crate::numerics::widest::widest;
use crate::optimize::nlp::kkt::KktSystem;
use crate::{Matrix3, Vector3, lie};
use nalgebra::{DMatrix, DMatrixView, DVector};
use std::f64::consts::TAU;

/// A step, which is a part of an arc.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Step {
    pub arc: usize,
    /// Length of the step, as a fraction of the arc's length.
    pub part: f64,
    pub torque: Torque,
}

/// Arcs in order of time, and the steps into which they are divided.
#[derive(Clone, Copy)]
pub(super) struct Sequence<'a> {
    pub m: &'a Vector3,
    /// Duration of each arc.
    pub lengths: &'a [f64],
    pub steps: &'a [Step],
    /// Initial nodes of the steps, and the end of the last step. A step without a stored node
    /// starts where the previous one ends.
    pub nodes: &'a [Node],
    /// Displacement of the start from the first node, as the blocks `η`, `δΠ`, `δe` of a
    /// disturbance.
    pub beside: [Vector3; 3],
    /// Longest integration step of the continuous flow, as a fraction of the duration; `None` for
    /// discrete steps on a grid.
    pub longest: Option<f64>,
}

/// Result of a sweep over arcs.
pub(super) struct SweptArcs {
    /// KKT system with the costates and the arc lengths as unknowns.
    pub kkt: KktSystem,
    /// Sum of the squares of the gaps between steps.
    pub gaps: f64,
    /// Torque held over each step.
    pub torques: Vec<Vector3>,
    /// Nodes at the ends of the steps: one more than steps.
    pub nodes: Vec<Node>,
    /// Derivatives of the nodes with respect to costates and lengths, and the displacement that
    /// closes the gaps.
    answers: Vec<DMatrix<f64>>,
}

/// Returns the derivatives of all arc lengths with respect to the free arc lengths. All are free
/// or, if the duration is `given`, all but the first.
pub(super) fn free_lengths(arcs: usize, given: bool) -> DMatrix<f64> {
    let mut all = DMatrix::identity(arcs, arcs);
    if given {
        all.row_mut(0).fill(-1.0);
        return all.remove_column(0);
    }
    all
}

impl Sequence<'_> {
    /// Displacement of zero: the sequence starts at the first node.
    pub const AT_THE_NODE: [Vector3; 3] = [Vector3::new(0.0, 0.0, 0.0); 3];

    /// Sweeps over the sequence with the smallest sufficient number of lanes. Returns `None` if a
    /// step has no solution, a number is not finite, there are more arcs than lanes, or a stop is
    /// requested.
    pub fn swept(&self, extremal: &Extremal) -> Option<SweptArcs> {
        match 7 + self.lengths.len() {
            ..=8 => self.sweep::<8>(extremal),
            9..=16 => self.sweep::<16>(extremal),
            17..=32 => self.sweep::<32>(extremal),
            33..=64 => self.sweep::<64>(extremal),
            _ => None,
        }
    }

    fn sweep<const L: usize>(&self, extremal: &Extremal) -> Option<SweptArcs> {
        let arcs = self.lengths.len();
        let (gap_lane, duration) = (6 + arcs, self.lengths.iter().sum());
        let (mut residual, mut slopes) = (DVector::zeros(6 + arcs), DMatrix::zeros(6 + arcs, 7 + arcs));
        let mut lanes = Lanes::<L>::of_costate();
        lanes.add(gap_lane, &self.beside, 1.0);
        let answer = |lanes: &Lanes<L>| DMatrix::from_fn(9, 7 + arcs, |row, lane| lanes.0[row][lane]);
        let (mut nodes, mut answers) = (vec![*self.nodes.first()?], vec![answer(&lanes)]);
        let (mut torques, mut gaps) = (Vec::with_capacity(self.steps.len()), 0.0);
        for (k, step) in self.steps.iter().enumerate() {
            if extremal.halt.is_raised_at(k) {
                return None;
            }
            let (node, next) = (nodes[k], self.nodes.get(k + 1));
            let (m, length) = (apply_transposed(&node.r, self.m), self.lengths[step.arc] * step.part);
            let done = match (self.longest, step.torque) {
                (Some(longest), Torque::Arc(law)) => {
                    extremal.flow_step(&m, &node, &law, (length, duration), longest)
                }
                _ => {
                    let expected = next.map_or(&node.e, |next| &next.e);
                    extremal.grid_step(&m, &node.pi, [&node.e, expected], length, step.torque)?
                }
            };
            let slope = widest(
                #[inline(always)]
                || carried(&done, self.m, &node, step, &mut lanes),
            );
            let row = 6 + step.arc;
            residual[row] += step.part * done.hamiltonian;
            for lane in 0..7 + arcs {
                slopes[(row, lane)] += step.part * slope[lane];
            }
            let reached = Node { r: product(&node.r, &done.f), pi: done.pi, e: done.e };
            if let Some(next) = next {
                let gap = reached.minus(next);
                gaps += gap.iter().map(|part| part.norm_squared()).sum::<f64>();
                lanes.add(gap_lane, &gap, 1.0);
            }
            nodes.push(next.copied().unwrap_or(reached));
            answers.push(answer(&lanes));
            torques.push(done.torque);
        }
        let miss = extremal.miss(nodes.last()?);
        let of_log = lie::left_jacobian_inverse(&miss.fixed_rows::<3>(0).into_owned());
        residual.rows_mut(0, 6).copy_from(&miss);
        for lane in 0..7 + arcs {
            slopes.view_mut((0, lane), (3, 1)).copy_from(&(of_log * lanes.block(0, lane)));
            slopes.view_mut((3, lane), (3, 1)).copy_from(&lanes.block(1, lane));
        }
        let carried = &residual + slopes.column(gap_lane);
        let finite = carried.iter().chain(slopes.iter()).all(|value| value.is_finite());
        let kkt = KktSystem { conditions: 6, residual, carried, jacobian: slopes.remove_column(gap_lane) };
        finite.then_some(SweptArcs { kkt, gaps, torques, nodes, answers })
    }
}

impl SweptArcs {
    /// Returns the derivatives of the costate `e` at a node with respect to costates and lengths;
    /// the last column is the displacement that closes the gaps.
    pub fn costate(&self, node: usize) -> DMatrixView<'_, f64> {
        let answer = &self.answers[node];
        answer.view((6, 0), (3, answer.ncols()))
    }

    /// Returns the disturbance of each node that results from a Newton step of costates and
    /// lengths.
    pub fn disturbances<'s>(&'s self, step: &DVector<f64>) -> impl Iterator<Item = [Vector3; 3]> + use<'s> {
        let change = step.clone().insert_row(step.len(), 1.0);
        self.answers.iter().map(move |answer| {
            let moved = answer * &change;
            [0, 3, 6].map(|row| Vector3::new(moved[row], moved[row + 1], moved[row + 2]))
        })
    }
}

impl Extremal {
    /// Integrates an arc of the flow as one step, with attitudes relative to its start.
    pub(super) fn flow_step(
        &self,
        m: &Vector3,
        from: &Node,
        law: &ArcLaw,
        (length, duration): (f64, f64),
        longest: f64,
    ) -> StepMap {
        let first = Node { r: Matrix3::identity(), ..*from };
        // Parameters m, Π, e and the length.
        let mut lanes = Lanes::<12>::zero();
        for lane in 3..9 {
            lanes.0[lane][lane] = 1.0;
        }
        let torque = law.at(&first.e).torque;
        let [turn, pi_rate, e_rate] = self.rate(m, &first, &torque);
        let end = if length == 0.0 {
            first
        } else {
            over_arc(self, m, &first, law, (length, duration), longest, &mut lanes)
        };
        lanes.add(9, &self.rate(m, &end, &law.at(&end.e).torque), 1.0);
        // The Hamiltonian is constant along the arc: its derivatives with respect to m, Π, e are Ω,
        // −e', Π'.
        let of_hamiltonian =
            [turn.x, turn.y, turn.z, -e_rate.x, -e_rate.y, -e_rate.z, pi_rate.x, pi_rate.y, pi_rate.z, 0.0];
        StepMap {
            f: end.r,
            pi: end.pi,
            e: end.e,
            hamiltonian: self.hamiltonian(m, &first, first.e.dot(&torque) + law.running()),
            torque,
            jacobian: std::array::from_fn(|row| match lanes.0.get(row) {
                Some(lanes) => std::array::from_fn(|lane| lanes[lane]),
                None => of_hamiltonian,
            }),
        }
    }
}

/// Propagates the derivatives `lanes` over a step and returns the derivatives of the step's
/// Hamiltonian.
#[inline(always)]
fn carried<const L: usize>(
    done: &StepMap,
    m: &Vector3,
    node: &Node,
    step: &Step,
    lanes: &mut Lanes<L>,
) -> [f64; L] {
    // Parameters of the step: δm = Rᵀ(δM + M×η), δΠ, δe, δh.
    let mut given = [[0.0; L]; 10];
    for lane in 0..L {
        let unit = if lane < 3 { Vector3::ith(lane, 1.0) } else { Vector3::zeros() };
        let moved = apply_transposed(&node.r, &(unit + cross(m, &lanes.block(0, lane))));
        for axis in 0..3 {
            given[axis][lane] = moved[axis];
        }
    }
    given[3..9].copy_from_slice(&lanes.0[3..9]);
    given[9][6 + step.arc] = step.part;
    let mut out = [[0.0; L]; 10];
    for row in 0..10 {
        for column in 0..10 {
            let slope = done.jacobian[row][column];
            for lane in 0..L {
                out[row][lane] += slope * given[column][lane];
            }
        }
    }
    for lane in 0..L {
        let turn = apply(&node.r, &Vector3::new(out[0][lane], out[1][lane], out[2][lane]));
        for axis in 0..3 {
            lanes.0[axis][lane] += turn[axis];
        }
    }
    lanes.0[3..9].copy_from_slice(&out[3..9]);
    out[9]
}

/// Returns the number of integration steps for an arc. Each step covers at most the fraction
/// `longest` of the duration and of a revolution at the rate of the node `from`.
pub(super) fn steps(extremal: &Extremal, from: &Node, (length, duration): (f64, f64), longest: f64) -> usize {
    let turns = (extremal.j_inverse * from.pi).norm() * length / TAU;
    ((length / duration).max(turns) / longest).ceil().clamp(1.0, MOST_STEPS) as usize
}

/// Integrates one arc and propagates its derivatives, in steps of at most the fraction `longest` of
/// the duration and of a revolution at the initial rate.
pub(super) fn over_arc<const L: usize>(
    extremal: &Extremal,
    m: &Vector3,
    from: &Node,
    law: &ArcLaw,
    (length, duration): (f64, f64),
    longest: f64,
    lanes: &mut Lanes<L>,
) -> Node {
    let steps = steps(extremal, from, (length.abs(), duration), longest);
    let (course, step) = (Course::of(extremal, m), length / steps as f64);
    widest(
        #[inline(always)]
        || {
            let mut node = *from;
            for _ in 0..steps {
                node = course.carried(
                    &node,
                    step,
                    lanes,
                    #[inline(always)]
                    |_, e| law.at(e),
                );
            }
            node
        },
    )
}
