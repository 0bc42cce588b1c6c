//! Arcs one after the other, over the flow or over the steps of a grid: how the end and the
//! Hamiltonians answer to costates and lengths.
//!
//! ```text
//! c(d, λ) = e(d) ,      ∂L/∂d_a = H_a      with the lengths d, the costates λ = (M, e_0) at the start
//! ```
//!
//! are the conditions of least cost ([`KktSystem`]): `H_a` is the Hamiltonian on arc a of the flow,
//! or the mean of the discrete Hamiltonians of its steps. It is linear in `λ` where torques are
//! held, and there `∂c/∂λ` vanishes.
//!
//! Every step may start from its own stored node. Of a path that Newton goes on from, lanes carry
//! from node to node how the motion answers to costates, lengths and the gaps between the steps;
//! with them the nodes drop out of the Newton step, and follow it afterwards: nothing grows along
//! the maneuver but derivatives (Bock's condensing of multiple shooting).

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

/// A part of an arc.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Step {
    pub arc: usize,
    /// Its length over that of the arc.
    pub part: f64,
    pub torque: Torque,
}

/// Arcs in order.
#[derive(Clone, Copy)]
pub(super) struct Sequence<'a> {
    pub m: &'a Vector3,
    /// Of the arcs.
    pub lengths: &'a [f64],
    pub steps: &'a [Step],
    /// Where steps start and the last one ends. Where there are no more of them, each starts where
    /// the one before ends.
    pub nodes: &'a [Node],
    /// By how much the start is beside the first node.
    pub beside: [Vector3; 3],
    /// Over the flow the longest step of its integration, as a part of the duration; none over the
    /// steps of a grid.
    pub longest: Option<f64>,
}

/// What a sweep over arcs finds.
pub(super) struct SweptArcs {
    /// In costates and lengths.
    pub kkt: KktSystem,
    /// Sum of the squares of the gaps.
    pub gaps: f64,
    /// Torques held over the steps.
    pub torques: Vec<Vector3>,
    /// One more than steps.
    pub nodes: Vec<Node>,
    /// How the nodes answer to costates, lengths, and to 1.
    answers: Vec<DMatrix<f64>>,
}

/// How lengths go with those that are free: all or, in a given duration, all but the first.
pub(super) fn free_lengths(arcs: usize, given: bool) -> DMatrix<f64> {
    let mut all = DMatrix::identity(arcs, arcs);
    if given {
        all.row_mut(0).fill(-1.0);
        return all.remove_column(0);
    }
    all
}

impl Sequence<'_> {
    /// The start is the first node.
    pub const AT_THE_NODE: [Vector3; 3] = [Vector3::new(0.0, 0.0, 0.0); 3];

    /// Sweeps with lanes enough; `None` where a step has no solution or a number is not finite, for
    /// more arcs than there are lanes, or where somebody asks to stop.
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
    /// How the costate `e` at a node answers to costates, lengths, and to 1.
    pub fn costate(&self, node: usize) -> DMatrixView<'_, f64> {
        let answer = &self.answers[node];
        answer.view((6, 0), (3, answer.ncols()))
    }

    /// The disturbances of the nodes that go with a step of costates and lengths.
    pub fn disturbances<'s>(&'s self, step: &DVector<f64>) -> impl Iterator<Item = [Vector3; 3]> + use<'s> {
        let change = step.clone().insert_row(step.len(), 1.0);
        self.answers.iter().map(move |answer| {
            let moved = answer * &change;
            [0, 3, 6].map(|row| Vector3::new(moved[row], moved[row + 1], moved[row + 2]))
        })
    }
}

impl Extremal {
    /// An arc of the flow as one step, in axes of the body at its start.
    pub(super) fn flow_step(
        &self,
        m: &Vector3,
        from: &Node,
        law: &ArcLaw,
        (length, duration): (f64, f64),
        longest: f64,
    ) -> StepMap {
        let first = Node { r: Matrix3::identity(), ..*from };
        // m, Π, e and the length.
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
        // Constant along the arc: H' by m, Π, e is Ω, −e', Π'.
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

/// Carries the lanes over a step and gives those of its Hamiltonian.
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

/// How many steps of at most a part of the duration, and of a revolution at the rate of a node,
/// cover a length.
pub(super) fn steps(extremal: &Extremal, from: &Node, (length, duration): (f64, f64), longest: f64) -> usize {
    let turns = (extremal.j_inverse * from.pi).norm() * length / TAU;
    ((length / duration).max(turns) / longest).ceil().clamp(1.0, MOST_STEPS) as usize
}

/// Integrates one arc in steps of at most a part `longest` of the duration each, and of a
/// revolution at the rate with which it begins.
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
