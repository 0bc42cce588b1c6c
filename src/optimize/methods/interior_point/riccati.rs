//! The linear system of one Newton step, by a Riccati recursion with borders.
//!
//! ```text
//! min Σ ½ zᵀHz + h·z      dx⁺ = [B A] dz + d ,   E dx_N + e = D dν ,   dx_0 = G dy          z = (u, x)
//! ```
//!
//! `H` has the rows' part `CᵀΣC` in it. Backward, with the columns `c`: 0, the main one, and one for each terminal equation,
//!
//! ```text
//! P_N = H_N + EᵀρE ,   p_N⁰ = h_N + Eᵀρe ,   p_N^j = E_j
//! H ← H + [B A]ᵀP[B A] ,   h^c ← h^c + [B A]ᵀ(p^c + P d)           (d in column 0 alone)
//! H_uu = UᵀU ,   W = U⁻ᵀH_ux ,   l^c = U⁻ᵀh_u^c ,   P ← H_xx − WᵀW ,   p^c ← h_x^c − Wᵀl^c
//! M_{jj'} −= l^j·l^j' ,   M_{j0} += d·p^j − l^j·l⁰
//! ```
//!
//! and then, with `N = −M + D/(1 − ρD)`, `g^c = Gᵀp_0^c`,
//!
//! ```text
//! −N ω + gᵀdy = −(M_{·0} + e) ,     GᵀP_0G dy + g ω = −(Gᵀλ_0 + g⁰) ,      dν = ω/(1 − ρD)
//! ```
//!
//! The inertia is right where all `U` exist, `N` is positive and so is what is left for `dy`. The term `ρ` changes no solution;
//! it makes the blocks `H_uu` positive where the program is convex on the terminal manifold alone. Forward:
//! `du = −U⁻¹(W dx + Σ l^c θ_c)`, `dλ = P dx + Σ p^c θ_c`.
//!
//! A further right-hand side costs a pass of vectors. Domahidi et al. 2012, Frison 2016 for the recursion; the borders are the
//! Schur complement of what couples all stages.

use super::program::{Derivatives, Increment, Shape};

/// What a terminal equation gives way by, and the term that makes the problem convex beside it.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct Yield {
    /// `D`.
    pub by: f64,
    /// `ρ`, at most `½/D`.
    pub rho: f64,
}

/// Shares of the Hessian that a factorisation takes.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Taken {
    /// Whether second derivatives of steps and rows are in it.
    pub curved: bool,
    /// What is added to the diagonal.
    pub shift: f64,
}

/// The right-hand side: gradients of the Lagrangian, and what equations lack.
#[derive(Clone, Debug, Default)]
pub(crate) struct Right {
    /// `m + n` for each stage.
    pub gradients: Vec<f64>,
    /// Of the last state.
    pub last: Vec<f64>,
    pub defects: Vec<f64>,
    pub terminal: Vec<f64>,
    /// `Gᵀλ_0`.
    pub start: Vec<f64>,
}

impl Right {
    pub fn of(shape: &Shape) -> Self {
        Self {
            gradients: vec![0.0; shape.z() * shape.stages],
            last: vec![0.0; shape.n],
            defects: vec![0.0; shape.n * shape.stages],
            terminal: vec![0.0; shape.terminal],
            start: vec![0.0; shape.starts],
        }
    }
}

/// The factors, and the space to find them in.
#[derive(Clone, Debug, Default)]
pub(crate) struct Riccati {
    n: usize,
    m: usize,
    stages: usize,
    terminal: usize,
    starts: usize,
    /// `P_k`, n×n each.
    p: Vec<f64>,
    /// `p_k^c`, n×(1 + terminal) each.
    columns: Vec<f64>,
    /// `U_k`, m×m each; `W_k`, m×n each; `l_k^c`, m×(1 + terminal) each.
    u: Vec<f64>,
    w: Vec<f64>,
    l: Vec<f64>,
    /// `N`, then its factor; `g`, starts×terminal; `N⁻¹gᵀ`; what is left for `dy`, then its factor.
    normal: Vec<f64>,
    by_start: Vec<f64>,
    solved: Vec<f64>,
    reduced: Vec<f64>,
    yields: Vec<Yield>,
    /// Space.
    h: Vec<f64>,
    product: Vec<f64>,
    turned: Vec<f64>,
    vector: Vec<f64>,
    omega: Vec<f64>,
    dy: Vec<f64>,
}

/// Least share of the largest diagonal element of `N` that is added to it: where a terminal equation follows from others.
const DEPENDENT: f64 = 1e-14;

impl Riccati {
    pub fn of(shape: &Shape) -> Self {
        let Shape { n, m, stages, terminal, starts, .. } = *shape;
        let (z, columns) = (n + m, 1 + terminal);
        Self {
            n,
            m,
            stages,
            terminal,
            starts,
            p: vec![0.0; (stages + 1) * n * n],
            columns: vec![0.0; (stages + 1) * n * columns],
            u: vec![0.0; stages * m * m],
            w: vec![0.0; stages * m * n],
            l: vec![0.0; stages * m * columns],
            normal: vec![0.0; terminal * terminal],
            by_start: vec![0.0; starts * terminal],
            solved: vec![0.0; starts * terminal],
            reduced: vec![0.0; starts * starts],
            yields: vec![Yield::default(); terminal],
            h: vec![0.0; z * z],
            product: vec![0.0; n * z],
            turned: vec![0.0; n * z],
            vector: vec![0.0; z],
            omega: vec![0.0; terminal],
            dy: vec![0.0; starts],
        }
    }

    /// Factors the system with the rows' `Σ`; `false` where its inertia is wrong.
    pub fn factor(
        &mut self,
        shape: &Shape,
        at: &Derivatives,
        sigma: &[f64],
        yields: &[Yield],
        taken: Taken,
    ) -> bool {
        let (n, m, terminal) = (self.n, self.m, self.terminal);
        let (z, columns) = (n + m, 1 + terminal);
        self.yields.copy_from_slice(yields);
        self.normal.fill(0.0);
        // The last state.
        let last = self.stages * n * n;
        let p = &mut self.p[last..];
        p.copy_from_slice(&at.last_hessian);
        if taken.curved {
            add(p, 1.0, &at.last_curvature);
        }
        for (slope, given) in at.terminal_slopes.chunks_exact(n).zip(yields) {
            for (column, by) in p.chunks_exact_mut(n).zip(slope) {
                if *by != 0.0 {
                    add(column, given.rho * by, slope);
                }
            }
        }
        (0..n).for_each(|i| p[i * n + i] += taken.shift);
        let ends = &mut self.columns[self.stages * n * columns..];
        ends[n..].copy_from_slice(&at.terminal_slopes);
        for stage in (0..self.stages).rev() {
            let step = &at.steps[stage * n * z..][..n * z];
            let (before, after) = self.p.split_at_mut((stage + 1) * n * n);
            let (before, after) = (&mut before[stage * n * n..], &after[..n * n]);
            let h = &mut self.h[..];
            h.copy_from_slice(&at.hessians[stage * z * z..][..z * z]);
            if taken.curved {
                add(h, 1.0, &at.curvatures[stage * z * z..][..z * z]);
            }
            for i in 0..z {
                h[i * z + i] += taken.shift;
            }
            for row in shape.rows_of(stage) {
                let slopes = shape.slopes_of(row);
                let (places, values) = (&shape.unknowns[slopes.clone()], &at.slopes[slopes]);
                for (index, (place, value)) in places.iter().zip(values).enumerate() {
                    let (column, scaled) = (usize::from(*place) * z, sigma[row] * value);
                    for (other, by) in places[..=index].iter().zip(values) {
                        h[column + usize::from(*other)] += scaled * by;
                    }
                }
            }
            // `P [B A]`, and the same turned: rows one after the other.
            self.product.fill(0.0);
            for (product, column) in self.product.chunks_exact_mut(n).zip(step.chunks_exact(n)) {
                for (p, value) in after.chunks_exact(n).zip(column) {
                    if *value != 0.0 {
                        add(product, *value, p);
                    }
                }
            }
            for (j, product) in self.product.chunks_exact(n).enumerate() {
                for (i, value) in product.iter().enumerate() {
                    self.turned[i * z + j] = *value;
                }
            }
            for (i, column) in step.chunks_exact(n).enumerate() {
                let h = &mut h[i * z..][..=i];
                for (turned, value) in self.turned.chunks_exact(z).zip(column) {
                    if *value != 0.0 {
                        add(h, *value, &turned[..=i]);
                    }
                }
            }
            // `U`, `W`, `P`.
            let (u, w) = (&mut self.u[stage * m * m..][..m * m], &mut self.w[stage * m * n..][..m * n]);
            for i in 0..m {
                for j in 0..i {
                    let dot: f64 = (0..j).map(|r| u[j * m + r] * u[i * m + r]).sum();
                    u[i * m + j] = (h[i * z + j] - dot) / u[j * m + j];
                }
                let pivot = h[i * z + i] - (0..i).map(|r| u[i * m + r] * u[i * m + r]).sum::<f64>();
                if !(pivot > 0.0 && pivot.is_finite()) {
                    return false;
                }
                u[i * m + i] = pivot.sqrt();
            }
            for (i, w) in w.chunks_exact_mut(m.max(1)).enumerate().take(n) {
                w.copy_from_slice(&h[(m + i) * z..][..m]);
                forward(u, w);
            }
            for i in 0..n {
                for j in 0..=i {
                    let value = h[(m + i) * z + m + j] - dot(&w[i * m..][..m], &w[j * m..][..m]);
                    before[i * n + j] = value;
                    before[j * n + i] = value;
                }
            }
            // The columns of the terminal equations.
            let (to, from) = self.columns.split_at_mut((stage + 1) * n * columns);
            let to = &mut to[stage * n * columns..];
            let l = &mut self.l[stage * m * columns..][..m * columns];
            for c in 1..columns {
                let from = &from[c * n..][..n];
                let l = &mut l[c * m..][..m];
                for (l, column) in l.iter_mut().zip(step.chunks_exact(n)) {
                    *l = dot(column, from);
                }
                forward(u, l);
                for (i, to) in to[c * n..][..n].iter_mut().enumerate() {
                    *to = dot(&step[(m + i) * n..][..n], from) - dot(&w[i * m..][..m], l);
                }
            }
            for c in 0..terminal {
                for d in 0..=c {
                    self.normal[c * terminal + d] += dot(&l[(c + 1) * m..][..m], &l[(d + 1) * m..][..m]);
                }
            }
        }
        self.close(at)
    }

    /// The factors of what couples all stages; `false` where the inertia is wrong.
    fn close(&mut self, at: &Derivatives) -> bool {
        let (n, terminal, starts) = (self.n, self.terminal, self.starts);
        let largest = (0..terminal).map(|c| self.normal[c * terminal + c]).fold(0.0, f64::max);
        for (c, Yield { by, rho }) in self.yields.iter().enumerate() {
            self.normal[c * terminal + c] += by / (1.0 - rho * by) + DEPENDENT * largest.max(1e-300);
        }
        if !cholesky(&mut self.normal, terminal) {
            return false;
        }
        for (y, start) in at.start_slopes.chunks_exact(n).enumerate() {
            for c in 0..terminal {
                self.by_start[y * terminal + c] = dot(start, &self.columns[(c + 1) * n..][..n]);
            }
            let solved = &mut self.solved[y * terminal..][..terminal];
            solved.copy_from_slice(&self.by_start[y * terminal..][..terminal]);
            substitute(&self.normal, solved);
        }
        for y in 0..starts {
            let vector = &mut self.vector[..n];
            vector.fill(0.0);
            for (p, by) in self.p.chunks_exact(n).zip(&at.start_slopes[y * n..][..n]) {
                add(vector, *by, p);
            }
            for x in 0..=y {
                self.reduced[y * starts + x] = dot(&at.start_slopes[x * n..][..n], vector)
                    + dot(
                        &self.by_start[x * terminal..][..terminal],
                        &self.solved[y * terminal..][..terminal],
                    );
            }
        }
        cholesky(&mut self.reduced, starts)
    }

    /// Solves for a right-hand side: increments of the point and of the multipliers of its equations.
    pub fn solve(
        &mut self,
        at: &Derivatives,
        right: &Right,
        point: &mut Increment,
        costates: &mut [f64],
        terminals: &mut [f64],
    ) {
        let (n, m, terminal, starts) = (self.n, self.m, self.terminal, self.starts);
        let (z, columns) = (n + m, 1 + terminal);
        let last = &mut self.columns[self.stages * n * columns..][..n];
        last.copy_from_slice(&right.last);
        for ((slope, given), lacking) in
            at.terminal_slopes.chunks_exact(n).zip(&self.yields).zip(&right.terminal)
        {
            add(last, given.rho * lacking, slope);
        }
        let omega = &mut self.omega;
        omega.copy_from_slice(&right.terminal);
        for stage in (0..self.stages).rev() {
            let step = &at.steps[stage * n * z..][..n * z];
            let (to, from) = self.columns.split_at_mut((stage + 1) * n * columns);
            let to = &mut to[stage * n * columns..][..n];
            let defect = &right.defects[stage * n..][..n];
            let y = &mut self.vector[..n];
            y.copy_from_slice(&from[..n]);
            for (p, value) in self.p[(stage + 1) * n * n..].chunks_exact(n).zip(defect) {
                if *value != 0.0 {
                    add(y, *value, p);
                }
            }
            let gradient = &right.gradients[stage * z..][..z];
            let all = &mut self.l[stage * m * columns..][..m * columns];
            let (l, others) = all.split_at_mut(m);
            for ((l, column), own) in l.iter_mut().zip(step.chunks_exact(n)).zip(gradient) {
                *l = own + dot(column, y);
            }
            forward(&self.u[stage * m * m..][..m * m], l);
            let w = &self.w[stage * m * n..][..m * n];
            for (i, to) in to.iter_mut().enumerate() {
                *to = gradient[m + i] + dot(&step[(m + i) * n..][..n], y) - dot(&w[i * m..][..m], l);
            }
            for (c, omega) in omega.iter_mut().enumerate() {
                *omega += dot(defect, &from[(c + 1) * n..][..n]) - dot(l, &others[c * m..][..m]);
            }
        }
        // What couples all stages.
        substitute(&self.normal, omega);
        for (y, start) in at.start_slopes.chunks_exact(n).enumerate() {
            let own = right.start[y] + dot(start, &self.columns[..n]);
            self.dy[y] = -own - dot(&self.by_start[y * terminal..][..terminal], omega);
        }
        substitute(&self.reduced, &mut self.dy);
        for y in 0..starts {
            add(omega, self.dy[y], &self.solved[y * terminal..][..terminal]);
        }
        for ((to, omega), Yield { by, rho }) in terminals.iter_mut().zip(omega.iter()).zip(&self.yields) {
            *to = omega / (1.0 - rho * by);
        }
        // Forward.
        let first = &mut point.states[..n];
        first.fill(0.0);
        for (start, dy) in at.start_slopes.chunks_exact(n).zip(&self.dy) {
            add(first, *dy, start);
        }
        for stage in 0..=self.stages {
            let (known, next) = point.states.split_at_mut((stage + 1) * n);
            let dx = &known[stage * n..];
            let costate = &mut costates[stage * n..][..n];
            let own = &self.columns[stage * n * columns..][..n * columns];
            costate.copy_from_slice(&own[..n]);
            for (column, omega) in own[n..].chunks_exact(n).zip(omega.iter()) {
                add(costate, *omega, column);
            }
            for (p, value) in self.p[stage * n * n..].chunks_exact(n).zip(dx) {
                add(costate, *value, p);
            }
            if stage == self.stages {
                break;
            }
            let du = &mut point.inputs[stage * m..][..m];
            let l = &self.l[stage * m * columns..][..m * columns];
            du.copy_from_slice(&l[..m]);
            for (c, omega) in omega.iter().enumerate() {
                add(du, *omega, &l[(c + 1) * m..][..m]);
            }
            if m > 0 {
                for (w, value) in self.w[stage * m * n..].chunks_exact(m).zip(dx) {
                    add(du, *value, w);
                }
            }
            du.iter_mut().for_each(|value| *value = -*value);
            backward(&self.u[stage * m * m..][..m * m], du);
            let next = &mut next[..n];
            next.copy_from_slice(&right.defects[stage * n..][..n]);
            let step = &at.steps[stage * n * z..][..n * z];
            for (column, value) in step.chunks_exact(n).zip(du.iter().chain(dx)) {
                add(next, *value, column);
            }
        }
    }
}

/// `to += by · from`.
#[inline(always)]
pub(super) fn add(to: &mut [f64], by: f64, from: &[f64]) {
    for (to, from) in to.iter_mut().zip(from) {
        *to += by * from;
    }
}

/// `a · b`.
#[inline(always)]
pub(super) fn dot(a: &[f64], b: &[f64]) -> f64 {
    a.iter().zip(b).map(|(a, b)| a * b).sum()
}

/// `U⁻ᵀ b` of an upper triangle.
#[inline(always)]
fn forward(u: &[f64], b: &mut [f64]) {
    let m = b.len();
    for i in 0..m {
        let value = b[i] - dot(&u[i * m..][..i], &b[..i]);
        b[i] = value / u[i * m + i];
    }
}

/// `U⁻¹ b`.
#[inline(always)]
fn backward(u: &[f64], b: &mut [f64]) {
    let m = b.len();
    for i in (0..m).rev() {
        let value = b[i] / u[i * m + i];
        b[i] = value;
        add(&mut b[..i], -value, &u[i * m..][..i]);
    }
}

/// The upper factor of a matrix whose upper triangle is given, in its place; `false` where it is not positive.
fn cholesky(matrix: &mut [f64], size: usize) -> bool {
    for i in 0..size {
        for j in 0..=i {
            let value = matrix[i * size + j] - dot(&matrix[i * size..][..j], &matrix[j * size..][..j]);
            if j < i {
                matrix[i * size + j] = value / matrix[j * size + j];
            } else if value > 0.0 && value.is_finite() {
                matrix[i * size + i] = value.sqrt();
            } else {
                return false;
            }
        }
    }
    true
}

/// Solves with the factor of [`cholesky`].
fn substitute(factor: &[f64], b: &mut [f64]) {
    forward(factor, b);
    backward(factor, b);
}
