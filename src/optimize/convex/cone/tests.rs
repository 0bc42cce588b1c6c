//! Tests of each known pitfall of the cone solver, and of the signs of the duals by closed forms.

use super::*;

/// Builds a program whose only rows are `rows·x + s = b`.
fn program(
    n: usize,
    p: &[(usize, usize, f64)],
    q: &[f64],
    rows: &[(usize, usize, f64)],
    b: &[f64],
    cones: &[Cone],
) -> Program {
    Program {
        quadratic: Sparse::of_entries(n, n, p),
        linear: q.to_vec(),
        matrix: Sparse::of_entries(b.len(), n, rows),
        bound: b.to_vec(),
        cones: cones.to_vec(),
    }
}

/// Builds min ½x² subject to x = b.
fn pinned(b: f64) -> Program {
    program(1, &[(0, 0, 1.0)], &[0.0], &[(0, 0, 1.0)], &[b], &[Cone::Zero(1)])
}

fn new(program: Program) -> ConeSolver {
    ConeSolver::new(program, &ConeSettings::default()).unwrap()
}

fn refused(program: Program) -> ConeError {
    ConeSolver::new(program, &ConeSettings::default()).err().expect("refused")
}

fn solved(solver: &mut ConeSolver) -> Optimum {
    match solver.solve() {
        Answer::Solved(optimum) => optimum,
        other => panic!("{other:?}"),
    }
}

/// Quality of a point, computed from the data: `½xᵀPx + qᵀx`, `−½xᵀPx − bᵀz`, `max |Ax + s − b|`,
/// `max |Px + q + Aᵀz|`.
struct Judged {
    objective: f64,
    dual_objective: f64,
    primal_residual: f64,
    dual_residual: f64,
}

fn judged(program: &Program, Optimum { x, z, s }: &Optimum) -> Judged {
    let dot = |a: &[f64], b: &[f64]| a.iter().zip(b).map(|(a, b)| a * b).sum::<f64>();
    let mut gradient = vec![0.0; x.len()];
    for (row, column, value) in program.quadratic.entries() {
        gradient[row] += value * x[column];
        if row != column {
            gradient[column] += value * x[row];
        }
    }
    let curvature = dot(x, &gradient);
    gradient.iter_mut().zip(&program.linear).for_each(|(entry, q)| *entry += q);
    program.matrix.add_transposed_product(z, &mut gradient);
    let mut residual: Vec<f64> = s.iter().zip(&program.bound).map(|(s, b)| s - b).collect();
    program.matrix.entries().for_each(|(row, column, value)| residual[row] += value * x[column]);
    Judged {
        objective: 0.5 * curvature + dot(x, &program.linear),
        dual_objective: -0.5 * curvature - dot(&program.bound, z),
        primal_residual: largest(&residual),
        dual_residual: largest(&gradient),
    }
}

/// Returns the strength of a dual direction as a certificate of infeasibility: every `x` that meets
/// the constraints has `max |x_i| ≥ reach = −bᵀz / Σ|Aᵀz|`, round-off included. Returns zero if `z`
/// is not in `K*`, so that it proves nothing.
fn reach(program: &Program, z: &[f64]) -> f64 {
    let inside = program.parts(z).all(|(cone, part)| match cone {
        Cone::Zero(_) => true,
        Cone::Nonnegative(_) => part.iter().all(|value| *value >= 0.0),
        _ => false,
    });
    // Generous bound of the sums' round-off: the error of each term is a few ulps times the number
    // of terms.
    let ulps = 4.0 * f64::EPSILON * (z.len() as f64 + 4.0);
    let terms = || program.bound.iter().zip(z).map(|(b, z)| b * z);
    let depth = -terms().sum::<f64>() - ulps * terms().map(f64::abs).sum::<f64>();
    let mut image = vec![0.0; program.linear.len()];
    program.matrix.add_transposed_product(z, &mut image);
    let slack: f64 = program.matrix.entries().map(|(row, _, value)| ulps * (value * z[row]).abs()).sum();
    let width = image.iter().map(|value| value.abs()).sum::<f64>() + slack;
    if inside && depth > 0.0 { depth / width } else { 0.0 }
}

fn close(value: f64, expected: f64) {
    assert!((value - expected).abs() < 1e-7, "{value} is not {expected}");
}

#[test]
fn the_dual_of_an_equation_is_minus_the_price_of_its_bound() {
    let optimum = solved(&mut new(pinned(3.0)));
    close(optimum.x[0], 3.0);
    close(optimum.z[0], -3.0);
    let found = judged(&pinned(3.0), &optimum);
    close(found.objective, 4.5);
    close(found.dual_objective, 4.5);
    assert!(found.primal_residual < 1e-8 && found.dual_residual < 1e-8);
    // d cost / d b = −z, by a finite difference.
    let step = 1e-3;
    let cost = |b| judged(&pinned(b), &solved(&mut new(pinned(b)))).objective;
    let slope = (cost(3.0 + step) - cost(3.0 - step)) / (2.0 * step);
    assert!((slope + optimum.z[0]).abs() < 1e-5, "{slope}");
}

#[test]
fn the_dual_of_an_inequality_is_not_negative() {
    // min ½x² − 2x subject to x ≤ 1: x = 1, z = 1.
    let bounded = program(1, &[(0, 0, 1.0)], &[-2.0], &[(0, 0, 1.0)], &[1.0], &[Cone::Nonnegative(1)]);
    let optimum = solved(&mut new(bounded));
    close(optimum.x[0], 1.0);
    close(optimum.z[0], 1.0);
}

#[test]
fn a_second_order_cone_has_its_bound_first() {
    // min −x − y subject to |(x, y)| ≤ 1.
    let rows = [(1, 0, -1.0), (2, 1, -1.0)];
    let disk = program(2, &[], &[-1.0, -1.0], &rows, &[1.0, 0.0, 0.0], &[Cone::SecondOrder(3)]);
    let optimum = solved(&mut new(disk.clone()));
    close(optimum.x[0], 0.5f64.sqrt());
    close(judged(&disk, &optimum).objective, -(2.0f64.sqrt()));
}

#[cfg(feature = "sdp")]
#[test]
fn a_semidefinite_cone_is_packed_by_columns_with_root_two() {
    // min 2a + c subject to [a 3; 3 c] ⪰ 0: ac = 9, so a = 3/√2, c = 3√2, and z has the same
    // packing.
    let root = 2.0f64.sqrt();
    let rows = [(0, 0, -1.0), (2, 1, -1.0)];
    let mut solver =
        new(program(2, &[], &[2.0, 1.0], &rows, &[0.0, 3.0 * root, 0.0], &[Cone::Semidefinite(2)]));
    let optimum = solved(&mut solver);
    let objective = judged(solver.program(), &optimum).objective;
    // On the boundary of the cone, x is accurate only to the square root of the tolerance.
    let expected = [3.0 / root, 3.0 * root, 6.0 * root, 2.0, -2.0, 1.0];
    let found = [optimum.x[0], optimum.x[1], objective, optimum.z[0], optimum.z[1], optimum.z[2]];
    for (found, expected) in found.iter().zip(expected) {
        assert!((found - expected).abs() < 1e-5, "{found} is not {expected}");
    }
}

#[test]
fn no_number_that_is_not_finite_reaches_the_solver() {
    for bad in [f64::NAN, f64::INFINITY, f64::NEG_INFINITY] {
        let spoil: [fn(&mut Program, f64); 4] = [
            |program, bad| program.quadratic.nzval[0] = bad,
            |program, bad| program.linear[0] = bad,
            |program, bad| program.matrix.nzval[0] = bad,
            |program, bad| program.bound[0] = bad,
        ];
        for (spoil, part) in spoil.iter().zip(["P", "q", "A", "b"]) {
            let mut program = pinned(3.0);
            spoil(&mut program, bad);
            match refused(program) {
                ConeError::Value { part: found, index: 0, .. } => assert_eq!(found, part),
                other => panic!("{other:?}"),
            }
        }
        let mut solver = new(pinned(3.0));
        for spoil in spoil {
            let mut program = pinned(3.0);
            spoil(&mut program, bad);
            assert!(matches!(solver.update(program), Err(ConeError::Value { index: 0, .. })));
        }
        // The previous program is unchanged.
        close(solved(&mut solver).x[0], 3.0);
    }
}

#[test]
fn a_bound_that_the_solver_takes_for_infinity_is_refused() {
    assert!(matches!(refused(pinned(1e20)), ConeError::Value { part: "b", .. }));
    assert!(matches!(refused(pinned(-3e22)), ConeError::Value { part: "b", .. }));
}

#[test]
fn the_process_wide_infinity_is_left_alone() {
    solved(&mut new(pinned(3.0)));
    assert!((clarabel::get_infinity() - clarabel::INFINITY_DEFAULT).abs() < f64::EPSILON);
}

#[test]
fn a_cost_that_is_not_convex_is_refused() {
    assert_eq!(
        refused(program(1, &[(0, 0, -1.0)], &[0.0], &[(0, 0, 1.0)], &[3.0], &[Cone::Zero(1)])),
        ConeError::NotConvex
    );
    // Positive diagonal, eigenvalues 3 and −1.
    let saddle = [(0, 0, 1.0), (0, 1, 2.0), (1, 1, 1.0)];
    let rows = [(0, 0, 1.0), (1, 1, 1.0)];
    let cones = [Cone::Nonnegative(2)];
    assert_eq!(refused(program(2, &saddle, &[0.0; 2], &rows, &[1.0; 2], &cones)), ConeError::NotConvex);
    // An off-diagonal entry without a diagonal entry.
    assert_eq!(
        refused(program(2, &[(0, 1, 1.0)], &[0.0; 2], &rows, &[1.0; 2], &cones)),
        ConeError::NotConvex
    );
    // A singular matrix is convex, at any scale; updates are checked too.
    for scale in [1e-12, 1.0, 1e9] {
        let flat = [(0, 0, scale), (0, 1, -scale), (1, 1, scale)];
        let mut solver = new(program(2, &flat, &[0.0; 2], &rows, &[1.0; 2], &cones));
        let mut update = |values: [f64; 3]| {
            let mut program = solver.program().clone();
            program.quadratic.nzval = values.to_vec();
            solver.update(program)
        };
        assert_eq!(update([scale, -1.1 * scale, scale]), Err(ConeError::NotConvex));
        update([scale, 0.5 * scale, scale]).unwrap();
    }
}

#[test]
fn a_pattern_that_leaves_the_matrix_is_refused() {
    let mut outside = pinned(3.0);
    outside.matrix.rowval[0] = 5;
    assert!(matches!(refused(outside), ConeError::Solver(_)));
    let mut unsorted =
        program(1, &[(0, 0, 1.0)], &[0.0], &[(0, 0, 1.0), (1, 0, 1.0)], &[3.0, 4.0], &[Cone::Nonnegative(2)]);
    unsorted.matrix.rowval.swap(0, 1);
    assert!(matches!(refused(unsorted), ConeError::Solver(_)));
    let lower = program(2, &[(1, 0, 1.0)], &[0.0; 2], &[(0, 0, 1.0)], &[1.0], &[Cone::Zero(1)]);
    assert!(matches!(refused(lower), ConeError::Shape(_)));
}

#[test]
fn sizes_that_disagree_are_refused() {
    let mut few = pinned(3.0);
    few.cones = vec![];
    let mut many = pinned(3.0);
    many.cones = vec![Cone::Zero(1), Cone::Nonnegative(1)];
    let mut empty = pinned(3.0);
    empty.cones = vec![Cone::Zero(1), Cone::Nonnegative(0)];
    let mut thin = pinned(3.0);
    thin.cones = vec![Cone::SecondOrder(1)];
    let mut long = pinned(3.0);
    long.linear.push(1.0);
    for program in [few, many, empty, thin, long] {
        assert!(matches!(refused(program), ConeError::Shape(_)));
    }
    let mut solver = new(pinned(3.0));
    // The solver would interpret an empty update as "leave unchanged".
    for bound in [vec![1.0, 2.0], vec![]] {
        let update = Program { bound, ..pinned(3.0) };
        assert!(matches!(solver.update(update), Err(ConeError::Shape(_))));
    }
}

#[test]
fn a_program_without_rows_is_its_unconstrained_minimum() {
    let free = program(1, &[(0, 0, 2.0)], &[-1.0], &[], &[], &[]);
    close(solved(&mut new(free)).x[0], 0.5);
}

#[test]
fn an_updated_program_is_solved_as_a_new_one() {
    let p = [(0, 0, 2.0), (0, 1, 0.0), (1, 1, 1.0)];
    let rows = [(0, 0, 1.0), (0, 1, 0.0), (1, 0, 1.0), (2, 1, 1.0)];
    let cones = [Cone::Zero(1), Cone::Nonnegative(2)];
    let mut solver = new(program(2, &p, &[0.0, -1.0], &rows, &[1.0, 5.0, 5.0], &cones));
    solved(&mut solver);
    // The explicit zeros of the first data become nonzero entries.
    let p = [(0, 0, 2.0), (0, 1, 0.5), (1, 1, 1.5)];
    let rows = [(0, 0, 1.0), (0, 1, 2.0), (1, 0, 1.0), (2, 1, 1.0)];
    let other = program(2, &p, &[0.3, -2.0], &rows, &[1.5, 4.0, 0.5], &cones);
    solver.update(other.clone()).unwrap();
    let updated = solved(&mut solver);
    let fresh = solved(&mut new(other));
    for (updated, fresh) in updated.x.iter().chain(&updated.z).zip(fresh.x.iter().chain(&fresh.z)) {
        assert!((updated - fresh).abs() < 1e-7, "{updated} {fresh}");
    }
    // x = 1.5 − 2y, y ≤ ½, and the unconstrained minimum over y is at y = 0.7: the bound is active.
    close(updated.x[0], 0.5);
    close(updated.x[1], 0.5);
}

#[test]
fn what_contradicts_itself_comes_with_a_certificate() {
    // x ≤ 1 and x ≥ 2.
    let rows = [(0, 0, 1.0), (1, 0, -1.0)];
    let mut solver = new(program(1, &[(0, 0, 1.0)], &[0.0], &rows, &[1.0, -2.0], &[Cone::Nonnegative(2)]));
    match solver.solve() {
        Answer::Infeasible(z) => assert!(reach(solver.program(), &z) > 1e6),
        other => panic!("{other:?}"),
    }
    // The solver recovers with the next good data.
    solver.update(Program { bound: vec![1.0, 2.0], ..solver.program().clone() }).unwrap();
    close(solved(&mut solver).x[0], 0.0);
}

#[test]
fn a_certificate_says_how_far_it_reaches() {
    // The solver reports 1e-300 x = 3 as infeasible. That is correct for every x of moderate size;
    // `reach` states the size.
    let tiny = program(1, &[(0, 0, 1.0)], &[0.0], &[(0, 0, 1e-300)], &[3.0], &[Cone::Zero(1)]);
    match new(tiny.clone()).solve() {
        Answer::Infeasible(z) => assert!((reach(&tiny, &z) / 3e300 - 1.0).abs() < 1e-9),
        other => panic!("{other:?}"),
    }
    // A direction outside the dual cone, and one that proves nothing, have zero reach.
    let rows = [(0, 0, 1.0), (1, 0, -1.0)];
    let program = program(1, &[], &[0.0], &rows, &[1.0, -2.0], &[Cone::Nonnegative(2)]);
    let reach = |z: [f64; 2]| reach(&program, &z);
    assert!(reach([1.0, 1.0]) > 1e12);
    assert!((reach([1.0, 1.1]) - 12.0).abs() < 1e-9, "{}", reach([1.0, 1.1]));
    assert!(reach([-1.0, -1.0]) < f64::MIN_POSITIVE);
    assert!(reach([1.0, 0.0]) < f64::MIN_POSITIVE);
}

#[test]
fn an_unbounded_program_is_a_failure_without_a_point() {
    let mut solver = new(program(1, &[], &[-1.0], &[(0, 0, -1.0)], &[0.0], &[Cone::Nonnegative(1)]));
    let answer = solver.solve();
    assert!(matches!(answer, Answer::Failed { reason: Reason::Unbounded, .. }), "{answer:?}");
    assert!(answer.step().is_none());
}

#[test]
fn a_tolerance_below_round_off_is_almost_solved_at_best() {
    let disk = program(
        3,
        &[(0, 0, 1.0), (1, 1, 3.0)],
        &[-1.0, -1.0, 0.1],
        &[(0, 2, -1.0), (1, 0, -1.0), (2, 1, -1.0), (3, 2, 1.0)],
        &[0.0, 0.0, 0.0, 1.0],
        &[Cone::SecondOrder(3), Cone::Nonnegative(1)],
    );
    let strict = ConeSettings { tolerance: 1e-17, ..ConeSettings::default() };
    let answer = ConeSolver::new(disk.clone(), &strict).unwrap().solve();
    match answer {
        Answer::AlmostSolved(optimum) => {
            let found = judged(&disk, &optimum);
            assert!((found.objective - found.dual_objective).abs() < 1e-9);
        }
        Answer::Failed { reason: Reason::Numerical, .. } => {}
        other => panic!("{other:?}"),
    }
}

#[test]
fn limits_end_a_solve_and_are_named() {
    let one = ConeSettings { max_iterations: 1, ..ConeSettings::default() };
    let rows = [(0, 0, 1.0), (1, 0, -1.0)];
    let program = program(1, &[(0, 0, 1.0)], &[-7.0], &rows, &[1.0, 1.0], &[Cone::Nonnegative(2)]);
    let answer = ConeSolver::new(program.clone(), &one).unwrap().solve();
    assert!(matches!(answer, Answer::Failed { reason: Reason::Iterations, .. }), "{answer:?}");
    let hasty = ConeSettings { time_limit: 1e-12, ..ConeSettings::default() };
    let answer = ConeSolver::new(program, &hasty).unwrap().solve();
    assert!(matches!(answer, Answer::Failed { reason: Reason::Time, .. }), "{answer:?}");
}

#[test]
fn settings_are_checked_and_the_solver_is_silent_and_single() {
    for bad in [f64::NAN, 0.0, -1.0, f64::INFINITY] {
        let settings = ConeSettings { tolerance: bad, ..ConeSettings::default() };
        assert!(matches!(ConeSolver::new(pinned(3.0), &settings), Err(ConeError::Setting { .. })));
    }
    for bad in [f64::NAN, 0.0, -1.0] {
        let settings = ConeSettings { time_limit: bad, ..ConeSettings::default() };
        assert!(matches!(ConeSolver::new(pinned(3.0), &settings), Err(ConeError::Setting { .. })));
    }
    for bad in [f64::NAN, 0.0, 1.0] {
        let settings = ConeSettings { regularization: bad, ..ConeSettings::default() };
        assert!(matches!(ConeSolver::new(pinned(3.0), &settings), Err(ConeError::Setting { .. })));
    }
    let none = ConeSettings { max_iterations: 0, ..ConeSettings::default() };
    assert!(matches!(ConeSolver::new(pinned(3.0), &none), Err(ConeError::Setting { .. })));
    let solver = new(pinned(3.0));
    let chosen = solver.solver.settings();
    assert!(!chosen.verbose && !chosen.presolve_enable && !chosen.input_sparse_dropzeros);
    assert_eq!(chosen.max_threads, 1);
    assert_eq!(chosen.direct_solve_method, "qdldl");
    assert!(solver.solver.is_data_update_allowed());
}

#[test]
fn equal_programs_have_equal_answers_to_the_last_bit() {
    let chain = || {
        let n = 40;
        let p: Vec<_> = (0..n).map(|index| (index, index, 1.0 + index as f64)).collect();
        let mut rows: Vec<_> = (1..n).flat_map(|i| [(i - 1, i, 1.0), (i - 1, i - 1, -0.9)]).collect();
        rows.extend((0..n).map(|index| (n - 1 + index, index, 1.0)));
        let mut b = vec![0.1; n - 1];
        b.extend(vec![0.5; n]);
        solved(&mut new(program(
            n,
            &p,
            &vec![-1.0; n],
            &rows,
            &b,
            &[Cone::Zero(n - 1), Cone::Nonnegative(n)],
        )))
    };
    let (first, second) = (chain(), chain());
    assert_eq!(first.x, second.x);
    assert_eq!(first.z, second.z);
}
