//! Optima that belong to a family of equal optima, by a symmetry. The cost is level along the
//! family, and round-off must not make an optimum a saddle.

use slewkit::maneuver::{Problem, SecondOrder, Settings, State};
use slewkit::mechanics::{Actuation, ActuatorSet, AxisFrame, Body, Inertia};
use slewkit::optimize::search::solve;
use slewkit::plan::Silent;
use slewkit::{Matrix3, Vector3, lie};
use std::f64::consts::PI;

/// Returns a body that is symmetric about z turns about z by torques about x and y alone: a plan
/// turned about z by any angle has an equal cost. No such path of half a turn is symmetric to
/// itself.
fn without_a_torque_about_the_axis(axial: f64, angle: f64, steps: usize) -> Problem {
    let moments = Matrix3::from_diagonal(&Vector3::new(1.0, 1.0, axial));
    let body = Body { inertia: Inertia::new(moments).unwrap(), mass: None };
    let end = State::at_rest(lie::exp(&(angle * Vector3::z())));
    let torques = ActuatorSet::new(vec![Vector3::x(), Vector3::y()], AxisFrame::Body).unwrap();
    Problem::attitude(body, State::at_rest(Matrix3::identity()), end, 3.0)
        .with_actuation(Actuation::torques(torques))
        .with_steps(steps)
}

/// The reduced Hessian of a direct method of 100 steps (CasADi, by its null space) has −5e-16,
/// 0.0258, 0.0268 … as its least eigenvalues, at the cost 14.959, of 800 steps 14.983.
#[test]
fn one_of_a_circle_of_equal_minima_is_no_saddle() {
    for (axial, steps) in [(1.0, 50), (1.0, 99), (1.0, 100), (1.0, 101), (0.7, 100), (1.6, 80)] {
        let problem = without_a_torque_about_the_axis(axial, PI, steps);
        let found = solve(&problem, &Settings::default(), None, &mut Silent).unwrap();
        assert_eq!(
            found.optimality.second_order(),
            SecondOrder::Undecided,
            "{axial}, {steps} steps: {found:?}"
        );
        if (axial, steps) == (1.0, 100) {
            let discrete = found.landing.as_ref().unwrap().cost_before;
            assert!((discrete - 14.959).abs() < 1e-3, "{discrete}");
        }
    }
}
