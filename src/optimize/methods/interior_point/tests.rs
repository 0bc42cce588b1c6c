//! The interior-point method on programs with known optima, and its linear algebra compared with
//! dense matrices.

use super::iteration::{End, Solver};
use super::program::*;
use super::riccati::{Riccati, Right, Taken, Yield};
use super::tuning::Tuning;
use crate::maneuver::solution::Outcome;
use crate::optimize::methods::method::Watch;
use std::cell::Cell;

/// Generator of reproducible numbers in (−1, 1).
struct Random(u64);

impl Random {
    fn next(&mut self) -> f64 {
        self.0 = self.0.wrapping_mul(6364136223846793005).wrapping_add(1442695040888963407);
        (self.0 >> 11) as f64 / (1u64 << 52) as f64 - 1.0
    }
}

/// Double integrator: a mass on a line, `p⁺ = p + hv + ½h²u`, `v⁺ = v + hu`, that comes to rest at
/// `p = 1` by inputs within ±1, on `steps` steps of `T/steps`.
struct Line {
    shape: Shape,
    steps: usize,
    /// Fixed duration `T` of a minimum-effort problem; `None` for minimum time.
    given: Option<f64>,
    /// Limit of the speed; `None` without a limit.
    speed: Option<f64>,
    bounded: bool,
}

impl Line {
    fn new(steps: usize, given: Option<f64>, speed: Option<f64>, bounded: bool) -> Self {
        let mut shape =
            Shape { terminal: 2, starts: usize::from(given.is_none()), ..Shape::new(3, 1, 3, steps) };
        for stage in 0..steps {
            if bounded {
                shape.row(RowKind::Hard, [0]);
                shape.row(RowKind::Hard, [0]);
            }
            if speed.is_some() && stage > 0 {
                shape.row(RowKind::Elastic, [2]);
            }
            shape.end_stage();
        }
        Self { shape, steps, given, speed, bounded }
    }

    fn solver(&self, duration: f64) -> Solver {
        let mut solver = Solver::of(&self.shape);
        for (k, state) in solver.point.states.chunks_exact_mut(3).enumerate() {
            state.copy_from_slice(&[k as f64 / self.steps as f64, 0.5, duration]);
        }
        solver.point.states[..2].fill(0.0);
        solver
    }
}

impl Program for Line {
    fn shape(&self) -> &Shape {
        &self.shape
    }

    fn values(&self, at: &Point, out: &mut Values) -> bool {
        let steps = self.steps as f64;
        out.cost = if self.given.is_none() { at.states[3 * self.steps + 2] } else { 0.0 };
        for k in 0..self.steps {
            let ([p, v, t], u) = ([0, 1, 2].map(|i| at.states[3 * k + i]), at.inputs[k]);
            if t <= 0.0 {
                return false;
            }
            let h = t / steps;
            let next = [p + h * v + 0.5 * h * h * u, v + h * u, t];
            for (i, next) in next.iter().enumerate() {
                out.defects[3 * k + i] = next - at.states[3 * (k + 1) + i];
            }
            if self.given.is_some() {
                out.cost += 0.5 * h * u * u;
            }
            let mut rows = self.shape.rows_of(k);
            if self.bounded {
                out.rows[rows.next().unwrap()] = u - 1.0;
                out.rows[rows.next().unwrap()] = -u - 1.0;
            }
            if let (Some(row), Some(speed)) = (rows.next(), self.speed) {
                out.rows[row] = v - speed;
            }
        }
        out.terminal.copy_from_slice(&[at.states[3 * self.steps] - 1.0, at.states[3 * self.steps + 1]]);
        true
    }

    fn derivatives(&self, at: &Point, duals: &Duals, out: &mut Derivatives) -> bool {
        self.values(at, &mut out.values);
        let steps = self.steps as f64;
        for k in 0..self.steps {
            let ([_, v, t], u) = ([0, 1, 2].map(|i| at.states[3 * k + i]), at.inputs[k]);
            let h = t / steps;
            // The columns are u, p, v, T.
            out.steps[12 * k..][..12].copy_from_slice(&[
                0.5 * h * h,
                h,
                0.0, //
                1.0,
                0.0,
                0.0, //
                h,
                1.0,
                0.0, //
                (v + h * u) / steps,
                u / steps,
                1.0,
            ]);
            let (l, m) = (duals.costates[3 * (k + 1)], duals.costates[3 * (k + 1) + 1]);
            let curvature = &mut out.curvatures[16 * k..][..16];
            let mut put = |i: usize, j: usize, value: f64| {
                curvature[4 * i + j] = value;
                curvature[4 * j + i] = value;
            };
            put(0, 3, l * h / steps + m / steps);
            put(2, 3, l / steps);
            put(3, 3, l * u / steps / steps);
            if self.given.is_some() {
                out.gradients[4 * k] = h * u;
                out.hessians[16 * k] = h;
            }
            let slopes: &[f64] = if self.bounded { &[1.0, -1.0, 1.0] } else { &[1.0] };
            let rows = self.shape.rows_of(k);
            let places = self.shape.first_unknown[rows.start]..self.shape.first_unknown[rows.end];
            let count = places.len();
            out.slopes[places].copy_from_slice(&slopes[..count]);
        }
        if self.given.is_none() {
            out.last_gradient[2] = 1.0;
            out.start_slopes.copy_from_slice(&[0.0, 0.0, 1.0]);
        }
        out.terminal_slopes.copy_from_slice(&[1.0, 0.0, 0.0, 0.0, 1.0, 0.0]);
        true
    }

    fn moved(&self, at: &Point, by: &Increment, part: f64, out: &mut Point) {
        let all = at.states.iter().zip(&by.states).zip(&mut out.states);
        all.for_each(|((at, by), out)| *out = at + part * by);
        let all = at.inputs.iter().zip(&by.inputs).zip(&mut out.inputs);
        all.for_each(|((at, by), out)| *out = at + part * by);
    }

    fn longest(&self, _: &Point, _: &Increment) -> f64 {
        1.0
    }

    fn terminal_prices(&self, out: &mut [f64]) {
        out.fill(1.0);
    }
}

/// The optimum is `T = 2`: full force forward, then backward; the switch is at a node.
#[test]
fn the_shortest_time_of_a_double_integrator_is_found() {
    let line = Line::new(20, None, None, true);
    for guess in [1.0, 3.0, 7.0] {
        let mut solver = line.solver(guess);
        let run = solver.run(&line, &Tuning::default(), &Watch::NONE);
        assert_eq!(run.end, End::Converged, "{run:?}");
        assert!(run.exact && run.iterations < 40, "{run:?}");
        // The cost exceeds the optimum by the barrier parameter for each active row, one for every
        // input.
        let (above, gap) = (solver.point.states[2] - 2.0, 20.0 * run.barrier);
        assert!(above > -1e-12 && above < 2.0 * gap && gap < 1e-8, "{above:.2e} {gap:.2e}");
        for (k, u) in solver.point.inputs.iter().enumerate() {
            let bang = if k < 10 { 1.0 } else { -1.0 };
            // A slack is the barrier parameter over its multiplier, and the multiplier is small
            // near the switch.
            assert!((u - bang).abs() < 1e-7, "{k} {u}");
        }
        // The costate of the position is dT/dp = T/2p.
        assert!((solver.duals.terminal[0] + 1.0).abs() < 1e-8, "{:?}", solver.duals.terminal);
    }
}

/// The optimum is `T = d/v + v`, with switches at nodes.
#[test]
fn a_limit_of_the_speed_is_kept() {
    let line = Line::new(41, None, Some(0.8), true);
    let mut solver = line.solver(3.0);
    let run = solver.run(&line, &Tuning::default(), &Watch::NONE);
    assert_eq!(run.end, End::Converged, "{run:?}");
    assert!((solver.point.states[2] - 2.05).abs() < 1e-8, "{}", solver.point.states[2]);
    assert!(run.violation < 1e-9 && run.miss < 1e-11, "{run:?}");
}

/// The minimum of `½ Σ h u²` with `Σ h u = 0`, `Σ h u (T − t) = 1` is the inverse of `2 h Σ τ²`,
/// with `τ` the time from the middle of the maneuver to the middle of each step.
#[test]
fn the_least_effort_of_a_double_integrator_is_found_at_once() {
    let (steps, duration) = (30, 2.5);
    let line = Line::new(steps, Some(duration), None, false);
    let mut solver = line.solver(duration);
    let run = solver.run(&line, &Tuning::default(), &Watch::NONE);
    assert_eq!(run.end, End::Converged, "{run:?}");
    let h = duration / steps as f64;
    let tau = |k: usize| h * (k as f64 + 0.5) - 0.5 * duration;
    let least = 0.5 / (0..steps).map(|k| h * tau(k) * tau(k)).sum::<f64>();
    assert!((solver.at.values.cost - least).abs() < 1e-10 * least, "{} {least}", solver.at.values.cost);
}

/// With a warm start from the multipliers of its own solution, a slightly changed program takes at
/// most two thirds of the iterations of a cold start, and converges to the same optimum.
#[test]
fn a_solve_goes_on_from_known_multipliers() {
    let (first, next) = (Line::new(20, Some(2.5), None, true), Line::new(20, Some(2.501), None, true));
    let mut fresh = next.solver(2.501);
    let cold = fresh.run(&next, &Tuning::default(), &Watch::NONE);
    let mut solver = first.solver(2.5);
    assert_eq!(solver.run(&first, &Tuning::default(), &Watch::NONE).end, End::Converged);
    solver.point.states.chunks_exact_mut(3).for_each(|state| state[2] = 2.501);
    let tuning = Tuning { first: 1e-8, ..Tuning::default() };
    let warm = solver.resume(&next, &tuning, &Watch::NONE);
    assert_eq!((cold.end, warm.end), (End::Converged, End::Converged), "{cold:?} {warm:?}");
    assert!(3 * warm.iterations <= 2 * cold.iterations, "{} {}", warm.iterations, cold.iterations);
    let off = solver.at.values.cost - fresh.at.values.cost;
    assert!(off.abs() < 1e-9 * fresh.at.values.cost, "{off:.1e}");
}

/// If the duration is too short, the run converges to the smallest terminal error and reports it.
#[test]
fn too_short_a_duration_ends_in_the_least_miss() {
    let line = Line::new(20, Some(1.5), None, true);
    let mut solver = line.solver(1.5);
    let run = solver.run(&line, &Tuning::default(), &Watch::NONE);
    assert_eq!(run.end, End::Converged, "{run:?}");
    assert!(run.miss > 0.1, "{run:?}");
    let enough = Line::new(20, Some(2.01), None, true);
    let mut solver = enough.solver(2.01);
    let run = solver.run(&enough, &Tuning::default(), &Watch::NONE);
    assert!(run.end == End::Converged && run.miss < 1e-9, "{run:?}");
}

/// Double integrator with one gradient component that is NaN after a number of evaluations.
struct Broken {
    line: Line,
    evaluations: Cell<usize>,
    from: usize,
}

impl Program for Broken {
    fn shape(&self) -> &Shape {
        self.line.shape()
    }

    fn values(&self, at: &Point, out: &mut Values) -> bool {
        self.line.values(at, out)
    }

    fn derivatives(&self, at: &Point, duals: &Duals, out: &mut Derivatives) -> bool {
        let exists = self.line.derivatives(at, duals, out);
        self.evaluations.set(self.evaluations.get() + 1);
        if self.evaluations.get() > self.from {
            out.gradients[5] = f64::NAN;
        }
        exists
    }

    fn moved(&self, at: &Point, by: &Increment, part: f64, out: &mut Point) {
        self.line.moved(at, by, part, out);
    }

    fn longest(&self, at: &Point, by: &Increment) -> f64 {
        self.line.longest(at, by)
    }

    fn terminal_prices(&self, out: &mut [f64]) {
        self.line.terminal_prices(out);
    }
}

/// NaN is never returned, whether it occurs in the initial point or in a gradient at the first or a
/// later point.
#[test]
fn what_is_not_a_number_is_no_plan() {
    let line = Line::new(20, None, None, true);
    let mut solver = line.solver(f64::NAN);
    assert_eq!(solver.run(&line, &Tuning::default(), &Watch::NONE).end, End::NotFinite);
    for from in [0, 3] {
        let mut solver = line.solver(3.0);
        let broken = Broken { line: Line::new(20, None, None, true), evaluations: Cell::new(0), from };
        let run = solver.run(&broken, &Tuning::default(), &Watch::NONE);
        assert_eq!((run.end, run.iterations), (End::NotFinite, from));
        let known = solver.point.states.iter().chain(&solver.point.inputs);
        assert!(known.chain(&solver.duals.rows).all(|value| value.is_finite()));
    }
}

/// A run ends when it is interrupted, and at its deadline.
#[test]
fn a_run_stops_where_it_is_asked_to() {
    let line = Line::new(50, None, None, true);
    let asked = Cell::new(0);
    let interrupt = || {
        asked.set(asked.get() + 1);
        (asked.get() > 5).then_some(Outcome::Interrupted)
    };
    let watch = Watch { interrupt: &interrupt, deadline: None, flag: None };
    let mut solver = line.solver(3.0);
    let run = solver.run(&line, &Tuning::default(), &watch);
    assert_eq!(run.end, End::Stopped);
    assert!(run.iterations < 5 && run.dual.is_finite(), "{run:?}");
    // The same solver can be used again afterwards.
    let mut fresh = line.solver(3.0);
    solver.point = fresh.point.clone();
    let [again, known] =
        [&mut solver, &mut fresh].map(|solver| solver.run(&line, &Tuning::default(), &Watch::NONE));
    assert_eq!((again.end, again.iterations), (End::Converged, known.iterations));
    assert_eq!(solver.point.states, fresh.point.states);
}

/// Returns a random system of stages, with everything that a factorisation needs.
fn random(random: &mut Random, bend: f64) -> (Shape, Derivatives, Vec<f64>, Right, Vec<Yield>) {
    let mut shape = Shape { terminal: 2, starts: 1, ..Shape::new(4, 2, 4, 5) };
    for _ in 0..5 {
        shape.row(RowKind::Hard, [0, 3]);
        shape.row(RowKind::Hard, [1, 2, 5]);
        shape.end_stage();
    }
    let mut at = Derivatives::of(&shape);
    let mut fill = |values: &mut [f64]| values.iter_mut().for_each(|value| *value = random.next());
    fill(&mut at.steps);
    fill(&mut at.slopes);
    fill(&mut at.terminal_slopes);
    fill(&mut at.start_slopes);
    let z = shape.z();
    for block in at.hessians.chunks_exact_mut(z * z) {
        (0..z).for_each(|i| block[i * z + i] = 2.0);
    }
    for block in at.curvatures.chunks_exact_mut(z * z) {
        for i in 0..z {
            for j in 0..=i {
                let value = bend * random.next();
                (block[i * z + j], block[j * z + i]) = (value, value);
            }
        }
    }
    (0..4).for_each(|i| at.last_hessian[5 * i] = 1.0);
    let mut right = Right::of(&shape);
    let mut fill = |values: &mut [f64]| values.iter_mut().for_each(|value| *value = random.next());
    fill(&mut right.gradients);
    fill(&mut right.last);
    fill(&mut right.defects);
    fill(&mut right.terminal);
    fill(&mut right.start);
    let sigma = (0..shape.rows()).map(|_| random.next().abs() + 0.1).collect();
    let yields = vec![Yield { by: 0.0, rho: 3.0 }, Yield { by: 0.2, rho: 2.0 }];
    (shape, at, sigma, right, yields)
}

/// Assembles the symmetric matrix of the whole system, with the unknowns
/// `dy, dx_k, du_k, dλ_k, dν`, and its right-hand side.
fn dense(
    shape: &Shape,
    at: &Derivatives,
    sigma: &[f64],
    right: &Right,
    yields: &[Yield],
) -> (Vec<Vec<f64>>, Vec<f64>) {
    let (n, m, z, stages) = (shape.n, shape.m, shape.z(), shape.stages);
    let x = |k: usize| shape.starts + k * n;
    let u = |k: usize| x(stages + 1) + k * m;
    let lambda = |k: usize| u(stages) + k * n;
    let nu = lambda(stages + 1);
    let size = nu + shape.terminal;
    let (mut matrix, mut rhs) = (vec![vec![0.0; size]; size], vec![0.0; size]);
    let mut both = |i: usize, j: usize, value: f64| {
        matrix[i][j] += value;
        if i != j {
            matrix[j][i] += value;
        }
    };
    for (y, start) in right.start.iter().enumerate() {
        (0..n).for_each(|i| both(y, lambda(0) + i, at.start_slopes[y * n + i]));
        rhs[y] = -start;
    }
    for k in 0..stages {
        let place = |i: usize| if i < m { u(k) + i } else { x(k) + i - m };
        let mut h = vec![0.0; z * z];
        (0..z * z).for_each(|i| h[i] = at.hessians[k * z * z + i] + at.curvatures[k * z * z + i]);
        for row in shape.rows_of(k) {
            let slopes = shape.slopes_of(row);
            for a in slopes.clone() {
                for b in slopes.clone() {
                    let (i, j) = (usize::from(shape.unknowns[a]), usize::from(shape.unknowns[b]));
                    h[i * z + j] += sigma[row] * at.slopes[a] * at.slopes[b];
                }
            }
        }
        for i in 0..z {
            (0..=i).for_each(|j| both(place(i), place(j), h[i * z + j]));
            (0..n).for_each(|r| both(place(i), lambda(k + 1) + r, at.steps[(k * z + i) * n + r]));
            rhs[place(i)] = -right.gradients[k * z + i];
        }
        (0..n).for_each(|i| {
            both(x(k) + i, lambda(k) + i, -1.0);
            rhs[lambda(k + 1) + i] = -right.defects[k * n + i];
        });
    }
    for i in 0..n {
        both(x(stages) + i, lambda(stages) + i, -1.0);
        (0..=i).for_each(|j| both(x(stages) + i, x(stages) + j, at.last_hessian[i * n + j]));
        rhs[x(stages) + i] = -right.last[i];
        (0..shape.terminal).for_each(|c| both(x(stages) + i, nu + c, at.terminal_slopes[c * n + i]));
    }
    for (c, given) in yields.iter().enumerate() {
        both(nu + c, nu + c, -given.by);
        rhs[nu + c] = -right.terminal[c];
    }
    (matrix, rhs)
}

/// Solves a dense system by Gaussian elimination with partial pivoting.
fn eliminate(mut matrix: Vec<Vec<f64>>, mut rhs: Vec<f64>) -> Vec<f64> {
    let size = rhs.len();
    for i in 0..size {
        let pivot = (i..size).max_by(|a, b| matrix[*a][i].abs().total_cmp(&matrix[*b][i].abs())).unwrap();
        matrix.swap(i, pivot);
        rhs.swap(i, pivot);
        for j in i + 1..size {
            let by = matrix[j][i] / matrix[i][i];
            if by != 0.0 {
                let (above, below) = matrix.split_at_mut(j);
                below[0].iter_mut().zip(&above[i]).for_each(|(to, from)| *to -= by * from);
                rhs[j] -= by * rhs[i];
            }
        }
    }
    for i in (0..size).rev() {
        let known: f64 = (i + 1..size).map(|j| matrix[i][j] * rhs[j]).sum();
        rhs[i] = (rhs[i] - known) / matrix[i][i];
    }
    rhs
}

/// Counts the negative eigenvalues of a symmetric matrix by Jacobi rotations.
fn negative(mut a: Vec<Vec<f64>>) -> usize {
    let size = a.len();
    for _ in 0..60 {
        for p in 0..size {
            for q in p + 1..size {
                if a[p][q].abs() < 1e-15 {
                    continue;
                }
                let theta = 0.5 * (a[q][q] - a[p][p]) / a[p][q];
                let t = theta.signum() / (theta.abs() + (theta * theta + 1.0).sqrt());
                let c = 1.0 / (t * t + 1.0).sqrt();
                let s = t * c;
                for row in &mut a {
                    (row[p], row[q]) = (c * row[p] - s * row[q], s * row[p] + c * row[q]);
                }
                let (above, below) = a.split_at_mut(q);
                for (a, b) in above[p].iter_mut().zip(&mut below[0]) {
                    (*a, *b) = (c * *a - s * *b, s * *a + c * *b);
                }
            }
        }
    }
    (0..size).filter(|i| a[*i][*i] < 0.0).count()
}

#[test]
fn the_recursion_solves_the_whole_system() {
    let mut numbers = Random(7);
    for _ in 0..20 {
        let (shape, at, sigma, right, yields) = random(&mut numbers, 0.1);
        let mut riccati = Riccati::of(&shape);
        assert!(riccati.factor(&shape, &at, &sigma, &yields, Taken { curved: true, shift: 0.0 }));
        let (mut point, mut duals) = (Increment::of(&shape), Duals::of(&shape));
        riccati.solve(&at, &right, &mut point, &mut duals.costates, &mut duals.terminal);
        let (matrix, rhs) = dense(&shape, &at, &sigma, &right, &yields);
        let known = eliminate(matrix, rhs);
        let found = point.states.iter().chain(&point.inputs).chain(&duals.costates).chain(&duals.terminal);
        for (known, found) in known[shape.starts..].iter().zip(found) {
            assert!((known - found).abs() < 1e-9 * (1.0 + known.abs()), "{known} {found}");
        }
    }
}

/// If a factorisation exists, the whole matrix has as many negative eigenvalues as equations. If it
/// has, the factorisation exists, provided that `ρ` is large.
#[test]
fn the_recursion_tells_the_inertia() {
    let mut numbers = Random(11);
    let mut told = [0; 2];
    for round in 0..40 {
        let (shape, at, sigma, right, mut yields) = random(&mut numbers, [1.0, 2.0, 3.0, 4.0][round % 4]);
        yields.iter_mut().for_each(|given| *given = Yield { by: 0.0, rho: 1e6 });
        let mut riccati = Riccati::of(&shape);
        let exists = riccati.factor(&shape, &at, &sigma, &yields, Taken { curved: true, shift: 0.0 });
        let (matrix, _) = dense(&shape, &at, &sigma, &right, &yields);
        let right_inertia = negative(matrix) == (shape.stages + 1) * shape.n + shape.terminal;
        assert_eq!(exists, right_inertia);
        told[usize::from(exists)] += 1;
    }
    assert!(told[0] > 5 && told[1] > 5, "{told:?}");
}
