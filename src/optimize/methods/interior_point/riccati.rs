//! The linear system of one Newton step, solved by a Riccati recursion with a border.
//!
//! ```text
//! min Σ ½ zᵀHz + h·z ,     z = (u, x)
//! dx⁺ = [B A] dz + d ,     E dx_N + e = D dν ,     dx_0 = G dy
//! ```
//!
//! `H` includes the part `CᵀΣC` of the rows. The backward recursion works on columns `c`: column 0
//! is the right-hand side, and each terminal equation has one more column,
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
//! The inertia is correct if all `U` exist, and `N` and the matrix left for `dy` are positive
//! definite. The term `ρ` does not change the solution; it makes the blocks `H_uu` positive
//! definite if the program is convex only on the terminal manifold. Forward:
//! `du = −U⁻¹(W dx + Σ l^c θ_c)`, `dλ = P dx + Σ p^c θ_c`.
//!
//! A further right-hand side takes one backward and one forward pass over vectors. The recursion
//! follows Domahidi et al. 2012 and Frison 2016; the border is the Schur complement of the terminal
//! equations and of the unknown start, which couple all stages.

use super::program::{Derivatives, Increment, Shape};
use crate::numerics::widest::widest;

/// Elasticity of a terminal equation, and its weight in the Hessian, which makes the problem convex
/// off the terminal manifold.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct Yield {
    /// Elasticity `D`: the equation reads `E dx_N + e = D dν`.
    pub by: f64,
    /// Weight `ρ` of the equation in the Hessian, at most `½/D`.
    pub rho: f64,
}

/// Parts of the Hessian that a factorisation includes.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Taken {
    /// True if the second derivatives of steps and rows are included; false for Gauss–Newton.
    pub curved: bool,
    /// Shift added to the diagonal of the Hessian.
    pub shift: f64,
}

/// Right-hand side of the linear system: gradients of the Lagrangian and residuals of the
/// equations.
#[derive(Clone, Debug, Default)]
pub(crate) struct Right {
    /// Gradients of the Lagrangian with respect to `(u, x)`, `m + n` numbers for each stage.
    pub gradients: Vec<f64>,
    /// Gradient of the Lagrangian with respect to the last state, `n` numbers.
    pub last: Vec<f64>,
    pub defects: Vec<f64>,
    pub terminal: Vec<f64>,
    /// Gradient of the Lagrangian with respect to the unknowns of the start, `Gᵀλ_0`.
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

/// Number of rows and of columns of a block in the matrix kernels.
const LANES: usize = 4;
type Lanes = [f64; LANES];
/// Smallest number of unknowns of a row at which the row is added to the Hessian as a dense row.
const DENSE: usize = 5;

/// Factors of the linear system, with the work space of the factorisation. Matrix sizes are padded
/// to whole blocks.
#[derive(Clone, Debug, Default)]
pub(crate) struct Riccati {
    n: usize,
    m: usize,
    stages: usize,
    terminal: usize,
    starts: usize,
    /// Number `n` of state components, padded to whole blocks.
    wide_n: usize,
    /// Number `m` of inputs, padded to whole blocks.
    wide_m: usize,
    /// Number of state components and terminal equations together, padded to whole blocks.
    width: usize,
    /// Value function: rows of `[P_k, p_k^1 …]`.
    p: Vec<f64>,
    /// Vectors `p_k⁰` of the right-hand side.
    main: Vec<f64>,
    /// Vectors `l_k⁰` of the right-hand side.
    l: Vec<f64>,
    /// Factors `U_k` of all stages, m×m each, column by column.
    u: Vec<f64>,
    /// Matrices `[W_k, l_k^1 …]` of all stages, row by row.
    w: Vec<f64>,
    /// Matrix `N` of the border, later its factor.
    normal: Vec<f64>,
    /// Matrix `g` of the border, starts×terminal.
    by_start: Vec<f64>,
    /// Matrix `N⁻¹gᵀ` of the border.
    solved: Vec<f64>,
    /// Matrix of the border that remains for the unknowns `dy` of the start, later its factor.
    reduced: Vec<f64>,
    yields: Vec<Yield>,
    // Work space, in columns of blocks: `[B A]` followed by the dense rows, their products with
    // `P` and `Σ`, and `[P, p^1 …]`; then the Hessian with the terminal columns, and vectors.
    rows: usize,
    left: Vec<Lanes>,
    right: Vec<Lanes>,
    after: Vec<Lanes>,
    h: Vec<f64>,
    sums: Vec<f64>,
    vector: Vec<f64>,
    omega: Vec<f64>,
    dy: Vec<f64>,
}

/// Relative regularisation of the diagonal of the border matrix `N`, needed if the terminal
/// equations are linearly dependent.
const DEPENDENT: f64 = 1e-14;

impl Riccati {
    pub fn of(shape: &Shape) -> Self {
        let Shape { n, m, stages, terminal, starts, .. } = *shape;
        let [wide_n, wide_m, ends] = [n, m, terminal].map(|size| size.next_multiple_of(LANES));
        let (width, wide) = (wide_n + ends, wide_m + wide_n);
        let dense =
            |stage: usize| shape.rows_of(stage).filter(|row| shape.slopes_of(*row).len() >= DENSE).count();
        let rows = n + (0..stages).map(dense).max().unwrap_or(0);
        Self {
            n,
            m,
            stages,
            terminal,
            starts,
            wide_n,
            wide_m,
            width,
            p: vec![0.0; (stages + 1) * n * width],
            main: vec![0.0; (stages + 1) * n],
            l: vec![0.0; stages * m],
            u: vec![0.0; stages * m * m],
            w: vec![0.0; stages * m * width],
            normal: vec![0.0; terminal * terminal],
            by_start: vec![0.0; starts * terminal],
            solved: vec![0.0; starts * terminal],
            reduced: vec![0.0; starts * starts],
            yields: vec![Yield::default(); terminal],
            rows,
            left: vec![[0.0; LANES]; rows * wide / LANES],
            right: vec![[0.0; LANES]; rows * wide / LANES],
            after: vec![[0.0; LANES]; n.max(m) * width / LANES],
            h: vec![0.0; wide * (wide + ends)],
            sums: vec![0.0; ends * ends],
            vector: vec![0.0; width],
            omega: vec![0.0; terminal],
            dy: vec![0.0; starts],
        }
    }

    /// Factors the system with the rows' weights `Σ`; returns `false` if its inertia is wrong.
    pub fn factor(
        &mut self,
        shape: &Shape,
        at: &Derivatives,
        sigma: &[f64],
        yields: &[Yield],
        taken: Taken,
    ) -> bool {
        let (n, terminal, width) = (self.n, self.terminal, self.width);
        self.yields.copy_from_slice(yields);
        self.sums.fill(0.0);
        // The last state.
        let last = &mut self.p[self.stages * n * width..];
        for (j, row) in last.chunks_exact_mut(width).enumerate() {
            row[..n].copy_from_slice(&at.last_hessian[j * n..][..n]);
            if taken.curved {
                add(&mut row[..n], 1.0, &at.last_curvature[j * n..][..n]);
            }
            row[j] += taken.shift;
            for (c, (slope, given)) in at.terminal_slopes.chunks_exact(n).zip(yields).enumerate() {
                if slope[j] != 0.0 {
                    add(&mut row[..n], given.rho * slope[j], slope);
                }
                row[self.wide_n + c] = slope[j];
            }
        }
        let positive = widest(
            #[inline(always)]
            || self.recur(shape, at, sigma, taken),
        );
        if !positive {
            return false;
        }
        let ends = width - self.wide_n;
        for c in 0..terminal {
            for d in 0..terminal {
                self.normal[c * terminal + d] = self.sums[c.min(d) * ends + c.max(d)];
            }
        }
        self.close(at)
    }

    /// Eliminates all stages, beginning with the last; returns `false` if the Hessian of a stage
    /// with respect to its inputs is not positive definite.
    #[inline(always)]
    fn recur(&mut self, shape: &Shape, at: &Derivatives, sigma: &[f64], taken: Taken) -> bool {
        for stage in (0..self.stages).rev() {
            self.gather(shape, at, sigma, taken, stage);
            if !self.eliminate(stage) {
                return false;
            }
        }
        true
    }

    /// Assembles the Hessian of a stage from all terms that depend on its unknowns: the Hessian of
    /// its cost, the curvature of its step, its rows, the value function of the next state, and the
    /// terminal columns.
    #[inline(always)]
    fn gather(&mut self, shape: &Shape, at: &Derivatives, sigma: &[f64], taken: Taken, stage: usize) {
        let (n, m, width) = (self.n, self.m, self.width);
        let (z, wide) = (n + m, self.wide_m + self.wide_n);
        let h_width = self.wide_m + width;
        let gap = self.wide_m - m;
        let place = |index: usize| if index < m { index } else { index + gap };
        let (hessian, curvature) =
            (&at.hessians[stage * z * z..][..z * z], &at.curvatures[stage * z * z..][..z * z]);
        for j in 0..z {
            let row = &mut self.h[place(j) * h_width..][..h_width];
            let (of_inputs, of_states) = row.split_at_mut(self.wide_m);
            let own = &hessian[j * z..][..z];
            of_inputs[..m].copy_from_slice(&own[..m]);
            of_states[..n].copy_from_slice(&own[m..]);
            if taken.curved {
                let own = &curvature[j * z..][..z];
                add(&mut of_inputs[..m], 1.0, &own[..m]);
                add(&mut of_states[..n], 1.0, &own[m..]);
            }
            self.h[place(j) * (h_width + 1)] += taken.shift;
        }
        // `[B A]` and the matrices that multiply it.
        let rows = self.rows;
        let step = &at.steps[stage * n * z..][..n * z];
        for (j, column) in step.chunks_exact(n).enumerate() {
            let j = place(j);
            for (to, value) in self.left[j / LANES * rows..].iter_mut().zip(column) {
                to[j % LANES] = *value;
            }
        }
        let after = &self.p[(stage + 1) * n * width..][..n * width];
        for (i, row) in after.chunks_exact(width).enumerate() {
            for (j, value) in row.as_chunks::<LANES>().0.iter().enumerate() {
                self.after[j * n + i] = *value;
            }
        }
        for i in (0..n).step_by(LANES) {
            for (left, right) in self.left.chunks_exact(rows).zip(self.right.chunks_exact_mut(rows)) {
                let found = block(&self.after[i / LANES * n..][..n], &left[..n]);
                let count = LANES.min(n - i);
                right[i..i + count].copy_from_slice(&found[..count]);
            }
        }
        let mut count = n;
        for row in shape.rows_of(stage) {
            let slopes = shape.slopes_of(row);
            let (places, values) = (&shape.unknowns[slopes.clone()], &at.slopes[slopes]);
            if places.len() >= DENSE {
                for all in [&mut self.left, &mut self.right] {
                    all.iter_mut().skip(count).step_by(rows).for_each(|lanes| *lanes = [0.0; LANES]);
                }
                for (index, value) in places.iter().zip(values) {
                    let index = place(usize::from(*index));
                    let at = index / LANES * rows + count;
                    self.left[at][index % LANES] = *value;
                    self.right[at][index % LANES] = sigma[row] * value;
                }
                count += 1;
                continue;
            }
            for (index, (own, value)) in places.iter().zip(values).enumerate() {
                let (column, scaled) = (place(usize::from(*own)), sigma[row] * value);
                for (other, by) in places[..=index].iter().zip(values) {
                    self.h[place(usize::from(*other)) * h_width + column] += scaled * by;
                }
            }
        }
        for (i, left) in self.left.chunks_exact(rows).enumerate() {
            let h = &mut self.h[i * LANES * h_width..];
            for (j, right) in self.right.chunks_exact(rows).enumerate().skip(i) {
                add_block(&mut h[j * LANES..], h_width, &block(&left[..count], &right[..count]));
            }
            let ends = self.after[..n * width / LANES].chunks_exact(n).skip(self.wide_n / LANES);
            for (j, right) in ends.enumerate() {
                let at = wide + j * LANES;
                for (row, found) in h[at..].chunks_mut(h_width).zip(&block(&left[..n], right)) {
                    row[..LANES].copy_from_slice(found);
                }
            }
        }
    }

    /// Eliminates the inputs of a stage; returns `false` if the Hessian with respect to the inputs
    /// is not positive definite.
    #[inline(always)]
    fn eliminate(&mut self, stage: usize) -> bool {
        let (n, m, width, wide_m) = (self.n, self.m, self.width, self.wide_m);
        let h_width = wide_m + width;
        let u = &mut self.u[stage * m * m..][..m * m];
        for i in 0..m {
            for j in 0..i {
                let dot: f64 = (0..j).map(|r| u[j * m + r] * u[i * m + r]).sum();
                u[i * m + j] = (self.h[j * h_width + i] - dot) / u[j * m + j];
            }
            let pivot = self.h[i * h_width + i] - (0..i).map(|r| u[i * m + r] * u[i * m + r]).sum::<f64>();
            if !(pivot > 0.0 && pivot.is_finite()) {
                return false;
            }
            u[i * m + i] = pivot.sqrt();
        }
        let w = &mut self.w[stage * m * width..][..m * width];
        for i in 0..m {
            let (known, own) = w.split_at_mut(i * width);
            let own = &mut own[..width];
            own.copy_from_slice(&self.h[i * h_width + wide_m..][..width]);
            for (known, by) in known.chunks_exact(width).zip(&u[i * m..]) {
                add(own, -by, known);
            }
            let by = 1.0 / u[i * m + i];
            own.iter_mut().for_each(|value| *value *= by);
        }
        // The Schur complement for the states; `W` again in columns of blocks.
        let columns = &mut self.after[..m * width / LANES];
        for (i, row) in w.chunks_exact(width).enumerate() {
            for (j, value) in row.as_chunks::<LANES>().0.iter().enumerate() {
                columns[j * m + i] = *value;
            }
        }
        let column = |first: usize| &columns[first / LANES * m..][..m];
        let p = &mut self.p[stage * n * width..][..n * width];
        for i in (0..n).step_by(LANES) {
            for j in (i..width).step_by(LANES) {
                let found = block(column(i), column(j));
                let of_h = self.h[(wide_m + i) * h_width + wide_m + j..].chunks(h_width);
                let rows = p[i * width + j..].chunks_mut(width);
                for ((row, found), of_h) in rows.zip(&found).zip(of_h).take(n - i) {
                    for ((to, found), of_h) in row[..LANES].iter_mut().zip(found).zip(of_h) {
                        *to = of_h - found;
                    }
                }
            }
        }
        for i in 0..n {
            for j in 0..i {
                p[i * width + j] = p[j * width + i];
            }
        }
        let ends = width - self.wide_n;
        for i in (0..ends).step_by(LANES) {
            for j in (i..ends).step_by(LANES) {
                let found = block(column(self.wide_n + i), column(self.wide_n + j));
                add_block(&mut self.sums[i * ends + j..], ends, &found);
            }
        }
        true
    }

    /// Factors the border, which couples all stages; returns `false` if the inertia is wrong.
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
                let rows = self.p.chunks_exact(self.width).zip(start);
                self.by_start[y * terminal + c] = rows.map(|(row, by)| row[self.wide_n + c] * by).sum();
            }
            let solved = &mut self.solved[y * terminal..][..terminal];
            solved.copy_from_slice(&self.by_start[y * terminal..][..terminal]);
            substitute(&self.normal, solved);
        }
        for y in 0..starts {
            let vector = &mut self.vector[..n];
            vector.fill(0.0);
            for (p, by) in self.p.chunks_exact(self.width).zip(&at.start_slopes[y * n..][..n]) {
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

    /// Solves the factored system for a right-hand side: the increments of the point, of the
    /// costates and of the terminal multipliers.
    pub fn solve(
        &mut self,
        at: &Derivatives,
        right: &Right,
        point: &mut Increment,
        costates: &mut [f64],
        terminals: &mut [f64],
    ) {
        widest(
            #[inline(always)]
            || self.pass(at, right, point, costates, terminals),
        );
    }

    /// Solves for one right-hand side, by one backward and one forward pass over the stages.
    #[inline(always)]
    fn pass(
        &mut self,
        at: &Derivatives,
        right: &Right,
        point: &mut Increment,
        costates: &mut [f64],
        terminals: &mut [f64],
    ) {
        let (n, m, terminal, starts, width) = (self.n, self.m, self.terminal, self.starts, self.width);
        let (z, wide_n) = (n + m, self.wide_n);
        let main = &mut self.main[self.stages * n..];
        main.copy_from_slice(&right.last);
        for ((slope, given), lacking) in
            at.terminal_slopes.chunks_exact(n).zip(&self.yields).zip(&right.terminal)
        {
            add(main, given.rho * lacking, slope);
        }
        // The states, followed by the sums for the terminal equations.
        let vector = &mut self.vector[..];
        vector.fill(0.0);
        vector[wide_n..][..terminal].copy_from_slice(&right.terminal);
        for stage in (0..self.stages).rev() {
            let step = &at.steps[stage * n * z..][..n * z];
            vector[..n].copy_from_slice(&self.main[(stage + 1) * n..][..n]);
            let after = self.p[(stage + 1) * n * width..].chunks_exact(width);
            for (row, value) in after.zip(&right.defects[stage * n..][..n]) {
                if *value != 0.0 {
                    add(vector, *value, row);
                }
            }
            let gradient = &right.gradients[stage * z..][..z];
            let l = &mut self.l[stage * m..][..m];
            for ((l, column), own) in l.iter_mut().zip(step.chunks_exact(n)).zip(gradient) {
                *l = own + dot(column, &vector[..n]);
            }
            forward(&self.u[stage * m * m..][..m * m], l);
            let main = &mut self.main[stage * n..][..n];
            for ((to, column), own) in main.iter_mut().zip(step.chunks_exact(n).skip(m)).zip(&gradient[m..]) {
                *to = own + dot(column, &vector[..n]);
            }
            vector[..n].copy_from_slice(main);
            for (row, l) in self.w[stage * m * width..].chunks_exact(width).zip(l.iter()) {
                add(vector, -l, row);
            }
            main.copy_from_slice(&vector[..n]);
        }
        // The border couples all stages.
        let omega = &mut self.omega;
        omega.copy_from_slice(&vector[wide_n..][..terminal]);
        substitute(&self.normal, omega);
        for (y, start) in at.start_slopes.chunks_exact(n).enumerate() {
            let own = right.start[y] + dot(start, &self.main[..n]);
            self.dy[y] = -own - dot(&self.by_start[y * terminal..][..terminal], omega);
        }
        substitute(&self.reduced, &mut self.dy);
        for y in 0..starts {
            add(omega, self.dy[y], &self.solved[y * terminal..][..terminal]);
        }
        for ((to, omega), Yield { by, rho }) in terminals.iter_mut().zip(omega.iter()).zip(&self.yields) {
            *to = omega / (1.0 - rho * by);
        }
        // Forward pass.
        vector.fill(0.0);
        vector[wide_n..][..terminal].copy_from_slice(omega);
        let first = &mut point.states[..n];
        first.fill(0.0);
        for (start, dy) in at.start_slopes.chunks_exact(n).zip(&self.dy) {
            add(first, *dy, start);
        }
        for stage in 0..=self.stages {
            let (known, next) = point.states.split_at_mut((stage + 1) * n);
            let dx = &known[stage * n..];
            vector[..n].copy_from_slice(dx);
            let costate = &mut costates[stage * n..][..n];
            let rows = self.p[stage * n * width..].chunks_exact(width).zip(&self.main[stage * n..]);
            for (to, (row, own)) in costate.iter_mut().zip(rows) {
                *to = own + dot_of_blocks(row, vector);
            }
            if stage == self.stages {
                break;
            }
            let du = &mut point.inputs[stage * m..][..m];
            let rows = self.w[stage * m * width..].chunks_exact(width).zip(&self.l[stage * m..]);
            for (to, (row, own)) in du.iter_mut().zip(rows) {
                *to = -own - dot_of_blocks(row, vector);
            }
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

/// Computes the block `Σ a_r b_rᵀ`, summed over the rows `r` of two columns of blocks.
#[inline(always)]
fn block(a: &[Lanes], b: &[Lanes]) -> [Lanes; LANES] {
    let mut out = [[0.0; LANES]; LANES];
    for (a, b) in a.iter().zip(b) {
        for i in 0..LANES {
            for j in 0..LANES {
                out[i][j] += a[i] * b[j];
            }
        }
    }
    out
}

/// Adds a block to a matrix whose rows are `apart` elements apart.
#[inline(always)]
fn add_block(to: &mut [f64], apart: usize, block: &[Lanes; LANES]) {
    for (row, block) in to.chunks_mut(apart).zip(block) {
        for (to, value) in row.iter_mut().zip(block) {
            *to += value;
        }
    }
}

/// Computes `a · b` of vectors padded to whole blocks.
#[inline(always)]
fn dot_of_blocks(a: &[f64], b: &[f64]) -> f64 {
    let mut sums = [0.0; LANES];
    for (a, b) in a.chunks_exact(LANES).zip(b.chunks_exact(LANES)) {
        for i in 0..LANES {
            sums[i] += a[i] * b[i];
        }
    }
    sums.iter().sum()
}

/// Computes `to += by · from`.
#[inline(always)]
pub(super) fn add(to: &mut [f64], by: f64, from: &[f64]) {
    for (to, from) in to.iter_mut().zip(from) {
        *to += by * from;
    }
}

/// Computes `a · b`.
#[inline(always)]
pub(super) fn dot(a: &[f64], b: &[f64]) -> f64 {
    a.iter().zip(b).map(|(a, b)| a * b).sum()
}

/// Solves `Uᵀ x = b` for an upper triangular `U`, in place.
#[inline(always)]
fn forward(u: &[f64], b: &mut [f64]) {
    let m = b.len();
    for i in 0..m {
        let value = b[i] - dot(&u[i * m..][..i], &b[..i]);
        b[i] = value / u[i * m + i];
    }
}

/// Solves `U x = b` for an upper triangular `U`, in place.
#[inline(always)]
fn backward(u: &[f64], b: &mut [f64]) {
    let m = b.len();
    for i in (0..m).rev() {
        let value = b[i] / u[i * m + i];
        b[i] = value;
        add(&mut b[..i], -value, &u[i * m..][..i]);
    }
}

/// Replaces a matrix, given by its upper triangle, by its upper Cholesky factor; returns `false` if
/// it is not positive definite.
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

/// Solves a linear system in place, with the factor that [`cholesky`] computes.
fn substitute(factor: &[f64], b: &mut [f64]) {
    forward(factor, b);
    backward(factor, b);
}
