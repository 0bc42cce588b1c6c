//! Tests of the three solution methods for the implicit attitude equation.

use super::*;
use crate::mechanics::body::Inertia;
use crate::propagate::integrator::AttitudeEquation;

#[test]
fn three_ways_to_solve_it_meet_the_reference() {
    for case in reference("implicit.json")["cases"].as_array().unwrap() {
        let inertia = Inertia::new(matrix(&case["J"])).unwrap();
        let equation = AttitudeEquation::new(&inertia, case["h"].as_f64().unwrap());
        let momentum: Vector3 = vector(&case["Pi"]);
        let (f, c): (Vector3, Vector3) = (vector(&case["f"]), vector(&case["cayley"]));
        let limit = if f.norm() > 1.5 { 1e-6 } else { 2e-14 };
        let near = |root: Option<(Vector3, u32)>, expected: &Vector3| {
            let error = (root.unwrap().0 - expected).norm();
            assert!(error <= limit * expected.norm(), "{}: {error:e}", case["inertia"]);
        };
        near(equation.solve(&momentum), &c);
        near(equation.newton(&momentum), &c);
        near(equation.exponential(&momentum), &f);
    }
}

/// Newton's method needs 2–3 iterations up to 0.3 rad in a step; with Chebyshev's correction one or
/// two.
#[test]
fn a_few_iterations_do() {
    let mut random = crate::testing::Random(7);
    for (angle, newton, chebyshev) in [(0.01, 2, 1), (0.05, 3, 1), (0.1, 3, 2), (0.3, 3, 2), (0.6, 4, 2)] {
        let equation = AttitudeEquation::new(&full_inertia(), 1.0);
        let mut most = [0, 0, 0];
        for _ in 0..200 {
            let momentum = full_inertia().j() * random.vector3().normalize() * angle;
            let counts = [
                equation.newton(&momentum).unwrap().1,
                equation.exponential(&momentum).unwrap().1,
                equation.solve(&momentum).unwrap().1,
            ];
            most = std::array::from_fn(|way| most[way].max(counts[way]));
        }
        println!("{angle}: {most:?}");
        assert!(most[0] <= newton && most[1] <= newton && most[2] <= chebyshev, "{angle} rad: {most:?}");
    }
}

/// For a step beyond 90° no method finds a solution, and a NaN momentum has no solution either.
#[test]
fn too_long_a_step_has_no_solution() {
    let inertia = Inertia::diagonal(Vector3::new(1.0, 2.0, 2.5)).unwrap();
    let equation = AttitudeEquation::new(&inertia, 1.0);
    for momentum in [Vector3::new(0.0, 0.0, 2.51), Vector3::new(9.0, 1.0, 1.0), Vector3::repeat(f64::NAN)] {
        assert_eq!(equation.solve(&momentum), None);
        assert_eq!(equation.newton(&momentum), None);
        assert_eq!(equation.exponential(&momentum), None);
    }
    let system = System::new(vec![Body { inertia, mass: None }], None).unwrap();
    let state = start(&system, &Matrix3::identity(), Vector3::new(0.1, 0.2, 2.51));
    for kind in [Kind::LieEuler, Kind::LieVerlet, Kind::LieVerletLagrangian] {
        let mut method = method(kind, &system, &state, 1.0);
        let error = method.step(&[]).unwrap_err();
        assert!(matches!(error, crate::propagate::integrator::StepError::TooLong { body: 1, .. }), "{error}");
        assert_eq!(method.state(), &state, "the state is as it was");
        assert!(error.to_string().contains("shorten") || error.to_string().contains("use a step of"));
    }
}
