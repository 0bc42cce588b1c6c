//! Proofs of infeasibility: never against a maneuver that exists, and the figures where they are
//! known.

mod bounds;
mod never_denied;
mod wheels_and_cones;

use crate::evidence::Random;
use slewkit::maneuver::constraint::{Constraint, Direction, Pointing, Rule, Side};
use slewkit::maneuver::infeasible::{Proof, proof};
use slewkit::maneuver::problem::{Problem, Scheme, State};
use slewkit::maneuver::solution::Trajectory;
use slewkit::mechanics::actuators::{Actuation, ActuatorSet, AxisFrame, Limits, Wheels};
use slewkit::mechanics::body::{Body, Inertia};
use slewkit::mechanics::environment::{GravityGradient, UniformGravity};
use slewkit::verify::{margins, replay};
use slewkit::{Matrix3, Vector3, lie};
use std::f64::consts::TAU;

const SCHEMES: [Scheme; 2] = [Scheme::LieEuler, Scheme::LieVerlet];

fn limited(limits: Limits) -> Actuation {
    Actuation::torques(ActuatorSet::three_axes(AxisFrame::Body).with_limits(limits).unwrap())
}

fn norm_limit(limit: f64) -> Actuation {
    limited(Limits { norm: Some(limit), ..Limits::default() })
}

fn body(j: Matrix3) -> Body {
    Body { inertia: Inertia::new(j).unwrap(), mass: None }
}

/// Returns a body with principal moments up to a factor of about a hundred apart, axes askew.
fn random_body(random: &mut Random) -> Body {
    // Moments of a cloud of masses: every triangle inequality holds by itself.
    let spread = Vector3::from_fn(|_, _| 10.0_f64.powf(random.uniform()));
    let moments = Vector3::new(spread.y + spread.z, spread.z + spread.x, spread.x + spread.y);
    let axes = random.rotation();
    let j = axes * Matrix3::from_diagonal(&moments) * axes.transpose();
    body(0.5 * (j + j.transpose()))
}

fn rest_to_rest(body: Body, rotation: Vector3, duration: f64, actuation: Actuation) -> Problem {
    let start = State::at_rest(Matrix3::identity());
    Problem::attitude(body, start, State::at_rest(lie::exp(&rotation)), duration).with_actuation(actuation)
}

// ---- no maneuver that exists is denied
// --------------------------------------------------------------

/// Returns the maneuver whose end is the end of the motion under `inputs`, and that motion.
fn aimed(mut problem: Problem, inputs: &[f64]) -> Option<(Problem, Trajectory)> {
    let plan = replay(&problem, inputs).ok()?;
    problem.end = State::attitude(
        lie::rotation_from_quaternion(plan.quaternion.last().unwrap()),
        *plan.angular_velocity.last().unwrap(),
    );
    Some((problem, plan))
}

/// Returns inputs of several shapes: noise, bang-bang, smooth, one axis.
fn shaped_inputs(random: &mut Random, rows: usize, count: usize, size: f64) -> Vec<f64> {
    let shape = (random.bits() % 5) as usize;
    let phase: Vec<f64> = (0..count).map(|_| 3.0 * random.uniform()).collect();
    let axis: Vec<f64> = (0..count).map(|_| random.uniform()).collect();
    let mut inputs = vec![];
    for row in 0..rows {
        let t = row as f64 / (rows - 1) as f64;
        for i in 0..count {
            let value = match shape {
                0 => random.uniform(),
                1 => (6.0 * t + phase[i]).sin().signum(),
                2 => (4.0 * t + phase[i]).sin(),
                3 => axis[i] * if t < 0.5 { 1.0 } else { -1.0 },
                _ => axis[i] * (1.0 - 2.0 * t),
            };
            inputs.push(size * value);
        }
    }
    inputs
}

fn smallest_axis(body: &Body) -> Vector3 {
    let eigen = body.inertia.j().symmetric_eigen();
    eigen.eigenvectors.column(eigen.eigenvalues.imin()).into_owned()
}

// ---- the figures
// ------------------------------------------------------------------------------------

fn denied(problem: &Problem) -> Proof {
    problem.check().unwrap();
    proof(problem).unwrap_or_else(|| panic!("not denied: {problem:#?}"))
}

/// Returns the named shortest duration, which must be a little below the closed form and never
/// above.
fn shortest(problem: &Problem, closed_form: f64, slack: f64) -> String {
    let found = denied(problem);
    let shortest = found.duration_lower_bound.unwrap();
    let below = closed_form * (1.0 - slack) <= shortest && shortest <= closed_form * (1.0 + 1e-6);
    assert!(below, "{shortest} against {closed_form}: {found}");
    // Just below it is denied, just above it is not; and the duration is in the text.
    let with = |duration: f64| problem.clone().with_duration(duration);
    assert!(proof(&with(shortest * (1.0 - 1e-5))).is_some(), "{found}");
    assert_eq!(proof(&with(shortest * (1.0 + 1e-5))), None);
    let digits: f64 = text_between(&found.reason, "no plan is shorter than ", " s").parse().unwrap();
    assert!(digits <= shortest * (1.0 + 3e-6) && digits >= shortest * 0.999, "{found}");
    found.reason
}

fn text_between<'a>(text: &'a str, from: &str, to: &str) -> &'a str {
    text.split(from).nth(1).and_then(|rest| rest.split(to).next()).unwrap_or_else(|| panic!("{text}"))
}
