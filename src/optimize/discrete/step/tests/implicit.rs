//! The implicit equation compared with reference solutions, up to the bound of its solvability.

use crate::mechanics::drift_equation::solve;
use crate::testing::{Random, matrix, reference, vector};
use crate::{Matrix3, Vector3, lie};

#[test]
fn the_reference_cayley_vectors_are_met() {
    for case in reference("implicit.json")["cases"].as_array().unwrap() {
        let j: Matrix3 = matrix(&case["J"]);
        let g: Vector3 = vector::<3>(&case["Pi"]) * case["h"].as_f64().unwrap();
        let expected: Vector3 = vector(&case["cayley"]);
        let j_inverse = j.try_inverse().unwrap();
        let c = solve(&j, &j_inverse, &g).unwrap();
        // At 0.9999 of the bound the equation is nearly singular; the reference file allows 1e-6.
        let edge = (j_inverse * g).norm() > 0.999;
        let limit = if edge { 1e-6 } else { 1e-14 };
        let error = (c - expected).amax() / expected.amax().max(1e-300);
        assert!(error <= limit, "{}: {error:e}", case["inertia"]);
        let rotation = lie::cayley(&c) - matrix::<3, 3>(&case["F"]);
        assert!(rotation.amax() <= limit.max(1e-15), "{}", case["inertia"]);
    }
}

/// Returns `(J_d, J, g)` of a random body whose `J_d` has eigenvalues from `least` to 1, and with
/// `|J⁻¹g|` up to `bound`.
fn random_step(random: &mut Random, least: f64, bound: f64) -> (Matrix3, Matrix3, Vector3) {
    // J_d = ∫ρρᵀdm.
    let spread = Vector3::from_fn(|_, _| least.powf(0.5 - 0.5 * random.uniform()));
    let axes = random.rotation();
    let j_d = axes * Matrix3::from_diagonal(&spread) * axes.transpose();
    let j = Matrix3::from_diagonal_element(j_d.trace()) - j_d;
    let size = bound * (0.5 + 0.5 * random.uniform()).sqrt();
    (j_d, j, j * random.vector3().normalize() * size)
}

/// Counts the steps without a solution among `cases`; checks that the solutions are physical.
fn failures(seed: u64, cases: usize, least: f64, bound: f64) -> usize {
    let mut random = Random(seed);
    let mut failures = 0;
    for case in 0..cases {
        let (j_d, j, g) = random_step(&mut random, least, bound);
        let Some(c) = solve(&j, &j.try_inverse().unwrap(), &g) else {
            failures += 1;
            continue;
        };
        let f = lie::cayley(&c);
        let residual = f * j_d - j_d * f.transpose() - lie::hat(&g);
        assert!(residual.amax() <= 8.0 * f64::EPSILON * j.amax(), "case {case}: {:e}", residual.amax());
        // A rotation of less than 90° is a sufficient condition for the physical branch.
        assert!(f.trace() > 1.0, "case {case}");
    }
    failures
}

#[test]
fn below_the_bound_the_physical_branch_is_always_found() {
    assert_eq!(failures(31, 20_000, 0.1, 0.99), 0, "no principal moment far below the others");
    assert_eq!(failures(32, 20_000, 0.01, 0.5), 0, "half the bound");
}

#[test]
fn thin_rods_and_plates_find_the_physical_branch_too() {
    // Newton's method from ½J⁻¹g, without the initial passes, fails in none of these cases.
    for (least, bound) in [(0.01, 0.99), (1e-3, 0.5), (1e-6, 0.5), (1e-6, 0.25), (1e-6, 0.1)] {
        assert_eq!(failures(33, 20_000, least, bound), 0, "J_d from {least} to 1, |J⁻¹g| up to {bound}");
    }
}
