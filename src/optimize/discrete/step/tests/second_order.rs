//! `A`, `H` and the costate map compared with derivatives in dual numbers, exact to round-off.

use super::twin::{Field, Twin};
use crate::maneuver::problem::{Motion, Problem, Scheme, State};
use crate::mechanics::actuators::AxisFrame;
use crate::mechanics::body::Inertia;
use crate::mechanics::environment::{
    CentralGravity, GravityGradient, PointMass, SecondOrderGravity, UniformGravity,
};
use crate::optimize::discrete::step::Dynamics;
use crate::testing::{Random, attitude_only, full_inertia, graded, moving_ends, random_vector};
use crate::{Matrix3, Vector3};

/// Returns every environment with every input frame, each with a second implementation of its
/// field.
pub fn zoo() -> Vec<(Problem, Field)> {
    let mut random = Random(17);
    let inertia = full_inertia();
    let (arm, fall) = (Vector3::new(0.1, -0.2, 0.9), Vector3::new(0.6, 0.0, 0.8));
    let outward = Vector3::new(0.3, -0.5, 0.8).normalize();
    let points = [(0.6, Vector3::new(0.3, 0.1, 0.02)), (0.9, Vector3::new(-0.2, -0.2 / 3.0, -0.04 / 3.0))];
    let masses = points.map(|(parameter, position)| PointMass { parameter, position }).to_vec();
    // The body is small compared to its distance, as MacCullagh's approximation requires.
    let compact = Inertia::new(0.1 * inertia.j()).unwrap();
    let mut zoo = Vec::new();
    for frame in [AxisFrame::Body, AxisFrame::Reference] {
        let moving = moving_ends(&mut random, frame).with_scheme(Scheme::LieEuler);
        let attitude = attitude_only(moving.clone());
        let pendulum = UniformGravity::new(2.0, 0.85, fall, arm).unwrap();
        let turning = GravityGradient::new(0.9, &inertia).unwrap();
        let fixed = GravityGradient::along_fixed_direction(0.9, &inertia, outward).unwrap();
        let second = SecondOrderGravity::new(1.4, 1.3, &compact).unwrap();
        let cloud = CentralGravity::new(masses.clone()).unwrap();
        let stiffness: Matrix3 = inertia.j() * (3.0 * 0.9 * 0.9);
        zoo.push((attitude.clone(), Field::Free));
        zoo.push((attitude.clone().with_environment(pendulum), Field::Pendulum(1.7 * arm, fall)));
        zoo.push((
            attitude.clone().with_environment(turning),
            Field::GravityGradient(stiffness, Vector3::z()),
        ));
        zoo.push((attitude.with_environment(fixed), Field::GravityGradient(stiffness, outward)));
        zoo.push((moving.clone(), Field::Free));
        zoo.push((moving.clone().with_environment(cloud), Field::Cloud(points.to_vec())));
        zoo.push((moving.with_environment(second), Field::SecondOrder(1.4, 1.3, *compact.j())));
    }
    zoo
}

/// Returns tolerances for `A` and `H`: ten times the residuals of the survey. MacCullagh's field,
/// with its sixth powers of the distance, has twice the residuals of the cloud.
fn limits(motion: Motion) -> (f64, f64) {
    match motion {
        Motion::Attitude => (1.3e-14, 5e-15),
        Motion::RigidBody => (2e-14, 2e-14),
    }
}

fn check<const N: usize>(problem: &Problem, field: &Field, random: &mut Random) {
    check_step::<N>(problem, &Dynamics::new(problem, problem.steps), 0, field, random);
    let own = Dynamics::on(problem, graded(problem.scheme, problem.steps));
    check_step::<N>(problem, &own, 4, field, random);
}

fn check_step<const N: usize>(
    problem: &Problem,
    dynamics: &Dynamics,
    step: usize,
    field: &Field,
    random: &mut Random,
) {
    let twin = Twin { dynamics, field: field.clone(), step };
    let (a_limit, h_limit) = limits(problem.motion);
    for _ in 0..20 {
        let state = State {
            position: Vector3::new(1.0, 0.2, -0.1) + 0.2 * random.vector3(),
            velocity: random.vector3(),
            attitude: random.rotation(),
            angular_velocity: 2.0 * random.vector3(),
        };
        let (point, costate) = (dynamics.point(&state), random_vector::<N>(random));
        let step = dynamics.transition::<N>(step, &point, &costate).unwrap();
        let (a, (before, h)) = (twin.a(&point, &costate), twin.h(&point, &costate));
        let claims = [
            ("A", (step.linear.a - a).amax() / a.amax().max(1.0), a_limit),
            ("H", (step.linear.h - h).amax() / h.amax().max(1.0), h_limit),
            ("costate", (step.costate_before - before).amax() / before.amax().max(1.0), h_limit),
        ];
        for (name, error, limit) in claims {
            let frame = problem.actuation.torque.frame();
            assert!(error <= limit, "{name} of {field:?}, {frame:?}: {error:e} > {limit:e}");
        }
    }
}

#[test]
fn a_and_h_are_the_derivatives_of_step_and_costate_map() {
    let mut random = Random(23);
    for (problem, field) in zoo() {
        match problem.motion {
            Motion::Attitude => check::<6>(&problem, &field, &mut random),
            Motion::RigidBody => check::<12>(&problem, &field, &mut random),
        }
    }
}
