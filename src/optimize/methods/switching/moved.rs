//! Sensitivity of the arc lengths under held inputs to a displacement of the start.
//!
//! With lengths `d`, the end `e(d, z)` from a start displaced by `z`, prices `c` of the arcs and
//! the costates `(M, e_0)` of the maneuver, an extremal satisfies
//!
//! ```text
//! G_a = c_a + H_a(d, M, e_0, z) = 0  on every arc ,     e(d, z) = e(d*, 0)        (Σ d as given: G_a + κ = 0, Σ δd = 0)
//! ```
//!
//! with the Hamiltonian `H_a` under the torque of the arc, which is constant along the arc.
//! Differentiation gives the KKT equations of `min c·d`, with `ν` carried back to the start:
//!
//! ```text
//! [ ∇²_dd L  (∂e/∂d)ᵀ ; ∂e/∂d  0 ] [δd; δν] = −[ ∇²_dz L ; ∂e/∂z ] z
//! ```
//!
//! If there are as many arcs as conditions, the last rows alone determine the result:
//! `δd = −(∂e/∂d)⁻¹ ∂e/∂z z`. The costates make all `G_a` zero, or minimise them if the arcs are
//! those of a grid and not exactly an extremal; `δd` leads to the end to first order with any
//! costates.
//!
//! The matrix also distinguishes a minimum from a saddle. For length changes `v` that keep the end,
//! `vᵀ (∂G/∂d) v = vᵀ ∇²_dd L v`, because the costates at the start change `G` by `∂e/∂d` carried
//! back. If this is negative for some `v`, other lengths of the same arcs cost less (Agrachev,
//! Stefani and Zezza 2002; Maurer and Osmolovskii 2004).

use super::arcs::Arcs;
use super::extremal::{Extremal, TorqueLimit};
use super::flow::Node;
use super::grid_step::Torque;
use super::sequence::{Sequence, Step, free_lengths};
use super::tuning::{FINE, NOTHING, UNDETERMINED};
use crate::Vector3;
use crate::numerics::least_squares::shortest;
use nalgebra::{DMatrix, DVector};

/// An arc under a held torque, scaled.
#[derive(Clone, Copy, Debug)]
pub(crate) struct HeldArc {
    pub length: f64,
    pub torque: Vector3,
    /// Cost per unit of time on the arc, in a unit that all arcs share.
    pub price: f64,
}

/// Returns the matrix `K` in `δd = K z`, one row for each arc: the changes `δd` of the arc lengths
/// for a displacement `z = [ζ; δΠ]` of the start in attitude and momentum, scaled. `given` is true
/// if the duration is given. Returns `None` if the arcs do not determine `K`.
pub(crate) fn lengths_by_start(extremal: &Extremal, arcs: &[HeldArc], given: bool) -> Option<DMatrix<f64>> {
    let free = free_lengths(arcs.len(), given);
    let lengths: Vec<f64> = arcs.iter().map(|arc| arc.length).collect();
    let step = |(arc, held): (usize, &HeldArc)| {
        let law = Extremal::holding(&held.torque, held.price - extremal.time_price);
        Step { arc, part: 1.0, torque: Torque::Arc(law) }
    };
    let steps: Vec<Step> = arcs.iter().enumerate().map(step).collect();
    let at = |costates: &DVector<f64>, beside: [Vector3; 3]| {
        let [m, e] = [0, 3].map(|row| costates.fixed_rows::<3>(row).into_owned());
        let (nodes, longest) = ([Node::at_start(extremal, e)], Some(FINE));
        let sequence = Sequence { m: &m, lengths: &lengths, steps: &steps, nodes: &nodes, beside, longest };
        Some(sequence.swept(extremal)?.kkt.tied(&free))
    };
    // The residual is linear in the costates: at zero costates it is the prices.
    let none = at(&DVector::zeros(6), Sequence::AT_THE_NODE)?;
    // If the costates are not determined, the matrix is singular too.
    let costates = shortest(&none.by_multipliers().into_owned(), &-none.slope(), UNDETERMINED)?;
    let kkt = at(&costates, Sequence::AT_THE_NODE)?;
    let mut right = DMatrix::zeros(kkt.residual.len(), 6);
    for (column, mut right) in right.column_iter_mut().enumerate() {
        let mut beside = Sequence::AT_THE_NODE;
        beside[column / 3][column % 3] = 1.0;
        let moved = at(&costates, beside)?;
        right.copy_from(&(moved.residual - moved.carried));
    }
    let moved = solved(kkt.jacobian, &right)?;
    Some(free * moved.rows_range(6..))
}

/// Returns whether some change of the arc lengths keeps the end of an extremal and lowers its cost,
/// so that it is a saddle and not a minimum. False for arcs whose torque turns with the costate,
/// which are not tested.
pub(crate) fn is_saddle(extremal: &Extremal, arcs: &Arcs) -> bool {
    let lengths = arcs.lengths();
    // If inputs switch together, the arc between them can only become longer; the certificate tests
    // whether that lowers the cost.
    let free: Vec<usize> = (0..lengths.len()).filter(|arc| lengths[*arc] > NOTHING * arcs.duration).collect();
    let given = extremal.given_duration.is_some();
    if free.len() <= 6 + usize::from(given) || !matches!(extremal.law, TorqueLimit::Inputs(_)) {
        return false;
    }
    let of_free = DMatrix::from_fn(lengths.len(), free.len(), |arc, column| f64::from(arc == free[column]));
    let of_free = of_free * free_lengths(free.len(), given);
    arcs.swept(extremal, FINE).is_some_and(|(swept, _)| swept.kkt.tied(&of_free).falls(UNDETERMINED))
}

/// Solves a square system with rows scaled to equal size; `None` if the matrix is singular.
fn solved(mut matrix: DMatrix<f64>, right: &DMatrix<f64>) -> Option<DMatrix<f64>> {
    let mut right = right.clone();
    for (mut row, mut right) in matrix.row_iter_mut().zip(right.row_iter_mut()) {
        let size = row.amax();
        row /= size;
        right /= size;
    }
    if !matrix.iter().all(|value| value.is_finite()) {
        return None;
    }
    let values = matrix.singular_values();
    let found = (values.min() > UNDETERMINED * values.max()).then(|| matrix.lu().solve(&right))??;
    found.iter().all(|value| value.is_finite()).then_some(found)
}
