//! Conjugate points under limits, from the inertia of the KKT matrix of the accessory problem.
//!
//! For variations that keep the inputs at their limits constant, the second variation is
//!
//! ```text
//! Σ ½|v_k|² + ½ z_kᵀ H_k z_k ,     z_{k+1} = A_k z_k + G_k v_k ,   z_0 = 0 ,  z_N = 0 ,   G Gᵀ = Q
//! ```
//!
//! with `Q = −h K_pp`, which limits make smaller. The matrix of its first-order conditions has as
//! many negative eigenvalues as there are constraints, plus the number of directions in which the
//! cost decreases. Eliminated node by node it needs one pivot block per node and a last one,
//!
//! ```text
//! M_k = [[X_k, −I], [−I, H_k]] ,     X_{k+1} = A_k (I − X_k H_k)⁻¹ X_k A_kᵀ − Q_k ,     X_N
//! ```
//!
//! and by Sylvester's law their negative eigenvalues add up. The recursion needs no inverse of
//! Ψ₁₂(k), which is rank-deficient as long as all inputs have been at their limits since the start.
//!
//! The null space of `X_N` has two parts. The directions that the inputs cannot reach, the null
//! space of `W_N` of `W_{k+1} = A_k W_k A_kᵀ + Q_k`, are not constraints. The remaining directions
//! are variations along which the cost is constant to second order. The sign of their eigenvalues
//! is round-off, so they count neither as decrease nor as increase.

use crate::numerics::factor::{Factor, RANK_TOLERANCE};
use crate::numerics::matrix_inertia::MatrixInertia;
use crate::optimize::discrete::step::{Linearization, Sensitivity};
use crate::optimize::discrete::sweep::{BoundaryValueProblem, Node};
use nalgebra::{DMatrix, SMatrix, SVector};

/// Counts the independent directions in which the cost decreases. Returns `None` if the sweep
/// fails, or if the cost decreases in no direction but is constant to second order in some
/// direction.
pub(super) fn conjugate_points<const N: usize>(
    bvp: &BoundaryValueProblem<N>,
    costate: &SVector<f64, N>,
) -> Option<usize> {
    let mut elimination = Elimination::new(bvp);
    let mut before: Option<Node> = None;
    let mut complete = true;
    bvp.sweep_observed(costate, |node| {
        match &before {
            None => elimination.open(&node),
            Some(before) => complete &= elimination.step(before, &node).is_some(),
        }
        before = Some(node);
    })
    .ok()?;
    if complete { elimination.close() } else { None }
}

struct Elimination<'a, const N: usize> {
    bvp: &'a BoundaryValueProblem<'a, N>,
    /// Pivot `X_k` of the elimination.
    x: SMatrix<f64, N, N>,
    /// Reachability matrix `W_k`.
    reached: SMatrix<f64, N, N>,
    /// Number of negative eigenvalues so far, less the number of constraints.
    surplus: isize,
}

impl<'a, const N: usize> Elimination<'a, N> {
    fn new(bvp: &'a BoundaryValueProblem<'a, N>) -> Self {
        Self { bvp, x: SMatrix::zeros(), reached: SMatrix::zeros(), surplus: 0 }
    }

    fn is_verlet(&self) -> bool {
        self.bvp.dynamics.grid.has_half_kicks()
    }

    /// Starts the elimination with the opening half kick of Lie–Verlet.
    fn open(&mut self, node: &Node) {
        if self.is_verlet() {
            let dynamics = &self.bvp.dynamics;
            let kick = dynamics.linear_kick::<N>(&node.point.pose(), &node.costate);
            self.reached = kick.authority() * dynamics.grid.kick(0);
            self.x = -self.reached;
        }
    }

    /// Eliminates the step between two nodes; returns `None` if it fails or yields non-finite
    /// numbers.
    fn step(&mut self, before: &Node, node: &Node) -> Option<()> {
        let dynamics = &self.bvp.dynamics;
        let costate = node.costate.to_vector::<N>();
        let mut linear = dynamics.transition::<N>(before.index, &before.point, &costate).ok()?.linear;
        if self.is_verlet() && node.index == dynamics.grid.steps() {
            linear = self.with_half_a_kick(node, linear);
        }
        let Linearization { a, h, q } = linear;
        let h = (h + h.transpose()) * 0.5;
        let pivot = DMatrix::from_fn(2 * N, 2 * N, |row, column| match (row < N, column < N) {
            (true, true) => self.x[(row, column)],
            (false, false) => h[(row - N, column - N)],
            _ => -f64::from(u8::from(row % N == column % N)),
        });
        self.surplus += MatrixInertia::of(pivot, 0.0).negative as isize - N as isize;
        let next =
            a * Factor::new(&(SMatrix::identity() - self.x * h)).solve_matrix(&self.x) * a.transpose() - q;
        self.x = (next + next.transpose()) * 0.5;
        self.reached = a * self.reached * a.transpose() + q;
        self.x.iter().all(|value| value.is_finite()).then_some(())
    }

    /// Halves the last kick of Lie–Verlet: its gradient, curvature and authority.
    fn with_half_a_kick(&self, node: &Node, linear: Linearization<N>) -> Linearization<N> {
        let dynamics = &self.bvp.dynamics;
        let kick = dynamics.linear_kick::<N>(&node.point.pose(), &node.costate);
        let weight = dynamics.grid.kick(node.index);
        let half = kick.gradient::<N>() * weight;
        // (I + 2κ K_pq)⁻¹ = I − 2κ K_pq: the kick moves the momenta alone.
        let drift = (SMatrix::identity() - half * 2.0) * linear.a;
        let curvature = kick.curvature(&Sensitivity::of_state()).costate();
        Linearization {
            a: (SMatrix::identity() + half) * drift,
            h: linear.h - drift.transpose() * curvature * drift * weight,
            q: linear.q * 0.5,
        }
    }

    /// Evaluates the last pivot, `X_N`, without the unreachable directions. Returns `None` if the
    /// cost decreases in no direction but is constant to second order in some direction.
    fn close(self) -> Option<usize> {
        let MatrixInertia { negative, zero } = inertia(&self.x);
        let unreached = inertia(&self.reached).zero.min(zero);
        let descents = usize::try_from(self.surplus + negative as isize - (N - unreached) as isize).ok()?;
        (descents > 0 || zero == unreached).then_some(descents)
    }
}

/// Computes the inertia of a symmetric matrix after scaling its rows and columns to equal size.
/// Rows that are round-off relative to the largest row are not scaled up.
fn inertia<const N: usize>(of: &SMatrix<f64, N, N>) -> MatrixInertia {
    let sizes: [f64; N] = std::array::from_fn(|index| of[(index, index)].abs().sqrt());
    let largest = sizes.iter().copied().fold(f64::MIN_POSITIVE, f64::max);
    let usable = |size: f64| if size > f64::EPSILON.sqrt() * largest { size } else { largest };
    let scaled = DMatrix::from_fn(N, N, |row, column| {
        of[(row, column)] / (usable(sizes[row]) * usable(sizes[column]))
    });
    MatrixInertia::of(scaled, RANK_TOLERANCE)
}
