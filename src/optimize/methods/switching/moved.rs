//! How the lengths of arcs under held inputs answer to a start beside that of the maneuver.
//!
//! With lengths `d`, the end `e(d, z)` from a start moved by `z`, prices `c` of the arcs and the costates `(M, e_0)` of the maneuver,
//! an extremal has
//!
//! ```text
//! G_a = c_a + H_a(d, M, e_0, z) = 0  on every arc ,     e(d, z) = e(d*, 0)        (Σ d as given: G_a + κ = 0, Σ δd = 0)
//! ```
//!
//! with `H_a` the Hamiltonian under the torque of the arc, constant along it. Differentiated, these are the equations of Karush,
//! Kuhn and Tucker of `min c·d` with `ν` carried back to the start:
//!
//! ```text
//! [ ∇²_dd L  (∂e/∂d)ᵀ ; ∂e/∂d  0 ] [δd; δν] = −[ ∇²_dz L ; ∂e/∂z ] z
//! ```
//!
//! Where there are as many arcs as conditions, the last rows alone decide: `δd = −(∂e/∂d)⁻¹ ∂e/∂z z`. The costates are those that make
//! all `G_a` zero, or least where the arcs are those of a grid and not quite an extremal's; `δd` leads to the end to first order
//! whatever they are.
//!
//! The same matrix tells a minimum from a saddle: on the lengths that leave the end where it is, `vᵀ (∂G/∂d) v = vᵀ ∇²_dd L v`, as the
//! costates at the start move `G` by `∂e/∂d` carried back. Where that falls along some `v`, other lengths of the same arcs cost less
//! (Agrachev, Stefani and Zezza 2002; Maurer and Osmolovskii 2004).

use super::arcs::{Arcs, over_arc};
use super::extremal::Extremal;
use super::flow::{Lanes, Node};
use super::tuning::{FINE, UNDETERMINED, VANISHED};
use crate::Vector3;
use crate::numerics::matrix_inertia::MatrixInertia;
use nalgebra::{DMatrix, DVector};

/// An arc under a torque that is held, scaled.
#[derive(Clone, Copy, Debug)]
pub(crate) struct HeldArc {
    pub length: f64,
    pub torque: Vector3,
    /// What a unit of time costs on it; the unit is of no matter.
    pub price: f64,
}

/// The first lanes: `M` and `e_0`; the attitude and the momentum of the start; then the length of each arc.
const START: usize = 6;
const LENGTHS: usize = 12;

/// The end and the Hamiltonians of all arcs, by the lanes.
struct Derivatives {
    /// Rows of the attitude, in reference axes, and of the momentum at the end.
    end: DMatrix<f64>,
    hamiltonians: DMatrix<f64>,
}

/// `δd = K z`, a row for each arc, `z = [ζ; δΠ]` scaled; `None` where the arcs do not determine it.
pub(crate) fn lengths_by_start(extremal: &Extremal, arcs: &[HeldArc], given: bool) -> Option<DMatrix<f64>> {
    let count = arcs.len();
    let prices = DVector::from_iterator(count, arcs.iter().map(|arc| arc.price));
    // Linear in the costates: their derivatives at none of them are all there is.
    let none = derivatives(extremal, arcs, &Vector3::zeros(), &Vector3::zeros())?;
    let unknown = START + usize::from(given);
    let shared =
        |row: usize, column: usize| if column < START { none.hamiltonians[(row, column)] } else { 1.0 };
    let costates = solved(&DMatrix::from_fn(count, unknown, shared), &-prices)?;
    let part = |row: usize| Vector3::new(costates[row], costates[row + 1], costates[row + 2]);
    let at = derivatives(extremal, arcs, &part(0), &part(3))?;
    let size = unknown + count;
    let mut matrix = DMatrix::zeros(size, size);
    let mut right = DMatrix::zeros(size, 6);
    let lane = |column: usize| if column < START { column } else { LENGTHS + column - START };
    for (rows, from) in [(0, &at.end), (START, &at.hamiltonians)] {
        for row in 0..from.nrows() {
            for column in 0..START + count {
                matrix[(rows + row, column)] = from[(row, lane(column))];
            }
            for column in 0..6 {
                right[(rows + row, column)] = -from[(row, START + column)];
            }
        }
    }
    if given {
        for arc in 0..count {
            (matrix[(START + arc, size - 1)], matrix[(size - 1, START + arc)]) = (1.0, 1.0);
        }
    }
    let moved = solved_for(matrix, &right)?;
    Some(moved.rows(START, count).into_owned())
}

/// Whether the cost falls from an extremal along some lengths of its arcs that lead to the same end: then it is no minimum. Not told of
/// arcs whose torque turns with the costate.
pub(crate) fn is_saddle(extremal: &Extremal, arcs: &Arcs) -> bool {
    let held = |(_, start, end, signs): &(Node, f64, f64, Vec<f64>)| {
        let torque = extremal.on_arc(signs).held()?.torque;
        Some(HeldArc { length: end - start, torque, price: f64::NAN })
    };
    let Some(held) = arcs.arcs().iter().map(held).collect::<Option<Vec<_>>>() else { return false };
    let given = extremal.given_duration.is_some();
    let conditions = START + usize::from(given);
    // Of inputs that switch together the arc between them can grow alone, which its certificate tells of.
    let free: Vec<usize> =
        (0..held.len()).filter(|arc| held[*arc].length > VANISHED * arcs.duration).collect();
    if free.len() <= conditions {
        return false;
    }
    let Some(at) = derivatives(extremal, &held, &arcs.m, &arcs.first.e) else { return false };
    let count = free.len();
    let mut matrix = DMatrix::zeros(count + conditions, count + conditions);
    for (column, arc) in free.iter().enumerate() {
        let lane = LENGTHS + arc;
        for (row, other) in free.iter().enumerate() {
            matrix[(row, column)] =
                0.5 * (at.hamiltonians[(*other, lane)] + at.hamiltonians[(*arc, LENGTHS + other)]);
        }
        for row in 0..conditions {
            let of = if row < START { at.end[(row, lane)] } else { 1.0 };
            (matrix[(count + row, column)], matrix[(column, count + row)]) = (of, of);
        }
    }
    let least = UNDETERMINED * matrix.amax();
    MatrixInertia::of(matrix, least).negative > conditions
}

/// The least-squares solution; `None` where it is not the only one.
fn solved(matrix: &DMatrix<f64>, right: &DVector<f64>) -> Option<DVector<f64>> {
    if matrix.nrows() < matrix.ncols() {
        return None;
    }
    let svd = matrix.clone().svd(true, true);
    let (least, largest) = (svd.singular_values.min(), svd.singular_values.max());
    (least > UNDETERMINED * largest).then(|| svd.solve(right, 0.0).ok())?
}

/// The solution of as many equations as unknowns, where there is one.
fn solved_for(mut matrix: DMatrix<f64>, right: &DMatrix<f64>) -> Option<DMatrix<f64>> {
    let mut right = right.clone();
    for row in 0..matrix.nrows() {
        let size = matrix.row(row).amax();
        if !(size > 0.0 && size.is_finite()) {
            return None;
        }
        matrix.row_mut(row).scale_mut(1.0 / size);
        right.row_mut(row).scale_mut(1.0 / size);
    }
    let values = matrix.singular_values();
    if values.min() <= UNDETERMINED * values.max() {
        return None;
    }
    let found = matrix.lu().solve(&right)?;
    found.iter().all(|value| value.is_finite()).then_some(found)
}

fn derivatives(extremal: &Extremal, arcs: &[HeldArc], m: &Vector3, e: &Vector3) -> Option<Derivatives> {
    match LENGTHS + arcs.len() {
        ..=32 => derived::<32>(extremal, arcs, m, e),
        33..=64 => derived::<64>(extremal, arcs, m, e),
        _ => None,
    }
}

fn derived<const L: usize>(
    extremal: &Extremal,
    arcs: &[HeldArc],
    m: &Vector3,
    e: &Vector3,
) -> Option<Derivatives> {
    let count = arcs.len();
    let lanes_used = LENGTHS + count;
    let duration: f64 = arcs.iter().map(|arc| arc.length).sum();
    let mut lanes = Lanes::<L>::of_costate();
    for axis in 0..3 {
        lanes.0[axis][START + axis] = 1.0;
        lanes.0[3 + axis][START + 3 + axis] = 1.0;
    }
    let mut node = Node::at_start(extremal, *e);
    let mut hamiltonians = DMatrix::zeros(count, lanes_used);
    for (index, arc) in arcs.iter().enumerate() {
        let law = Extremal::holding(&arc.torque);
        let [turning, pi_rate, e_rate] = extremal.rate(m, &node, &arc.torque);
        for lane in 0..lanes_used {
            // δH = Ω·δM + η·(Ω×M) + Π'·δe − e'·δΠ, Ω in reference axes.
            let of_m = if lane < 3 { turning[lane] } else { 0.0 };
            hamiltonians[(index, lane)] =
                of_m + lanes.block(0, lane).dot(&turning.cross(m)) + pi_rate.dot(&lanes.block(2, lane))
                    - e_rate.dot(&lanes.block(1, lane));
        }
        node = over_arc(extremal, m, &node, &law, (arc.length, duration), FINE, &mut lanes);
        let rate = extremal.rate(m, &node, &arc.torque);
        lanes.add(LENGTHS + index, &rate, 1.0);
    }
    let end = DMatrix::from_fn(6, lanes_used, |row, lane| lanes.0[row][lane]);
    let finite = end.iter().chain(hamiltonians.iter()).all(|value| value.is_finite());
    finite.then_some(Derivatives { end, hamiltonians })
}
