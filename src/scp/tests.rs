//! The convex road against the shooting and the reference files.

use super::*;
use crate::actuation::{Actuation, AxisFrame, Channel, Limits};
use crate::body::{Body, Inertia};
use crate::environment::Pose;
use crate::lie;
use crate::problem::{Problem, Scheme, State};
use crate::Matrix3;

/// The cubic along the shortest rotation.
pub(super) fn straight(model: &Model) -> Vec<Pose> {
    let relative = lie::log(&model.start.attitude.tr_mul(&model.target.attitude));
    (0..=model.steps)
        .map(|stage| {
            let t = stage as f64 * model.h;
            let along = 3.0 * t * t - 2.0 * t * t * t;
            Pose {
                position: model.start.position + (model.target.position - model.start.position) * along,
                attitude: model.start.attitude * lie::exp(&(relative * along)),
            }
        })
        .collect()
}

#[test]
fn scratch() {
    let weight = nalgebra::DMatrix::from_diagonal(&nalgebra::DVector::from_vec(vec![1.0, 2.0, 0.5]));
    let axes = vec![crate::Vector3::x(), crate::Vector3::y(), crate::Vector3::z()];
    let channel = Channel::new(axes, AxisFrame::Body, weight).unwrap();
    let body = Body { inertia: crate::testing::full_inertia(), mass: None };
    let axis = crate::Vector3::new(1.0, 2.0, -0.5).normalize();
    let end = lie::exp(&(axis * 120f64.to_radians()));
    let problem = Problem::attitude(body, State::at_rest(Matrix3::identity()), State::at_rest(end), 2.0)
        .with_scheme(Scheme::LieEuler)
        .with_steps(50);
    let peak = 4.642254525192247;
    for share in [10.0 * peak, 0.75 * peak, 0.65 * peak, 0.55 * peak, 0.52 * peak] {
        let limited = channel.clone().with_limits(Limits { size: Some(vec![share; 3]), norm: None, rate: None }).unwrap();
        let problem = problem.clone().with_actuation(Actuation::torques(limited));
        let model = Model::new(&problem, 50);
        let rows = Rows::of(&problem, &model);
        let start = guess::along(&model, &rows, &straight(&model));
        for early in [true, false] {
            let options = Options { polish_early: early, ..Options::default() };
            let began = std::time::Instant::now();
            let convex = run(&model, &rows, start.clone(), None, &options, &|| None).unwrap();
            let unit = model.dynamics.units.cost;
            eprintln!(
                "limit {share} early {early}: {:?} cost {:.12} subproblems {} residuals {:?} cone {:.1} ms of {:.1} ms, {} its",
                convex.outcome, convex.cost * unit, convex.subproblems, convex.residuals, 1e3 * convex.cone_seconds, 1e3 * began.elapsed().as_secs_f64(), convex.cone_iterations
            );
            if let Some(p) = &convex.polished {
                let d = p.multipliers.costates[1].clone() - &convex.multipliers.costates[1];
                eprintln!("   polished {:.12} residual {:.1e} its {} dual diff {:.1e}", p.cost * unit, p.residual, p.iterations, d.amax() / p.multipliers.costates[1].amax());
            }
            let peak = convex.iterate.inputs.iter().flatten().fold(0.0f64, |a, b| a.max(b.abs())) * model.input_unit[0];
            eprintln!("   peak {peak}");
        }
    }
}
