//! A conserved momentum map makes Ψ₁₂ exactly singular, in known directions.

use crate::Vector3;
use crate::maneuver::objective::Weights;
use crate::maneuver::problem::Scheme;
use crate::mechanics::actuators::{Actuation, ActuatorSet, AxisFrame};
use crate::mechanics::environment::UniformGravity;
use crate::optimize::discrete::sweep::BoundaryValueProblem;
use crate::testing::{Random, attitude_only, moving_ends, random_vector};
use nalgebra::{DMatrix, SVector};

#[test]
fn torques_without_vertical_component_keep_the_vertical_momentum() {
    let mut random = Random(41);
    let axes = vec![Vector3::x(), Vector3::new(0.3, 1.2, 0.0)];
    let horizontal = ActuatorSet::new(axes, AxisFrame::Reference).unwrap();
    let weights = Weights::of_torques(DMatrix::from_row_slice(2, 2, &[1.0, 0.2, 0.2, 1.5]));
    let pendulum = UniformGravity::new(1.0, 1.7, Vector3::z(), Vector3::new(0.1, -0.2, 0.9)).unwrap();
    for scheme in [Scheme::LieEuler, Scheme::LieVerlet] {
        let problem = attitude_only(moving_ends(&mut random, AxisFrame::Body))
            .with_actuation(Actuation::torques(horizontal.clone()))
            .with_objective(weights.clone())
            .with_environment(pendulum.clone())
            .with_scheme(scheme)
            .with_steps(40);
        let bvp = BoundaryValueProblem::<6>::new(&problem, problem.steps);
        let costate = random_vector::<6>(&mut random);
        let mut nodes = Vec::new();
        bvp.sweep_observed(&costate, |node| nodes.push(node)).unwrap();
        let end = nodes[problem.steps].physical();
        let (_, psi) = bvp.sweep_linearized(&costate).unwrap();
        let null = |point: &crate::optimize::discrete::step::Point| {
            let vertical = point.attitude.value.tr_mul(&Vector3::z());
            let turn = point.momentum.value.cross(&vertical);
            SVector::<f64, 6>::from_iterator(turn.iter().chain(vertical.iter()).copied())
        };
        let map = |point: &crate::optimize::discrete::step::Point| {
            point.attitude.value.tr_mul(&Vector3::z()).dot(&point.momentum.value)
        };
        assert!((map(&end) - map(&bvp.start)).abs() < 1e-15);
        let left = psi.tr_mul(&null(&end)).amax() / psi.amax();
        assert!(left < 5e-15, "{scheme:?} {left:e}");
        // Gauge freedom: costates along the gradient of the momentum map have no effect; λ₋₁
        // belongs to the integrator's first node, after the half kick.
        let right = (psi * null(&nodes[0].point)).amax() / psi.amax();
        assert!(right < 5e-15, "{scheme:?} {right:e}");
        let values = psi.svd(false, false).singular_values;
        assert!(values.min() < 1e-15 * values.max(), "{scheme:?} {values}");
        assert_eq!(values.iter().filter(|value| **value > 1e-6 * values.max()).count(), 5);
    }
}
