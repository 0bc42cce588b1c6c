//! The quantities of a free body without wheels that no input can change.
//!
//! Two inputs steer an asymmetric body to any attitude, so the rank of the linearisation proves
//! nothing. For a body on which only its actuators act, these statements prove that an end is out
//! of reach:
//!
//! - `c·Π` is conserved when `cᵀB = 0` and the body is symmetric about `c` (`J S(c) = S(c) J`);
//! - `Π` stays in the smallest subspace that holds `Π_0` and the torque axes and is closed under
//!   `Π × J⁻¹Π`; if that is one axis, the body turns about it and no other;
//! - with torques fixed to the reference frame, `c·RΠ` is conserved when `cᵀB = 0`;
//! - without force along `c`, `c·γ` is conserved and `c·x` moves uniformly.
//!
//! An unstable rotation amplifies small errors, so a premise that nearly holds proves nothing: it
//! must hold to the round-off of the given numbers. Only the values that a proof compares may
//! differ by more.

use super::capability::Ends;
use super::words::{about, direction};
use crate::Vector3;
use crate::lie::hat;
use crate::maneuver::problem::{Motion, Problem};
use crate::mechanics::actuators::{ActuatorSet, AxisFrame};
use nalgebra::DMatrix;

/// The relative round-off of the given numbers: a premise that holds within it counts as true.
const ROUND_OFF: f64 = 1e-14;
/// The relative difference above which two conserved values count as different.
const DIFFERENT: f64 = 1e-9;

/// Returns the proof that no input can meet the terminal conditions, in words; `None` without a
/// proof.
pub(super) fn proof(problem: &Problem) -> Option<String> {
    if !problem.environment.is_free() {
        return None;
    }
    let ends = Ends::of(problem, problem.seconds());
    translation(problem).or_else(|| match problem.actuation.torque.frame() {
        AxisFrame::Body => symmetric_axis(problem, &ends).or_else(|| momentum_subspace(problem, &ends)),
        AxisFrame::Reference => spatial_momentum(problem, &ends),
    })
}

/// Returns orthonormal directions `c` with `rows · c = 0`.
fn null_space(rows: &[Vector3]) -> Vec<Vector3> {
    // Three rows of zeros are added, so that the decomposition has all three directions for any
    // number of rows.
    let stacked =
        DMatrix::from_fn(rows.len() + 3, 3, |row, column| rows.get(row).map_or(0.0, |row| row[column]));
    let Some(svd) = stacked.try_svd(false, true, f64::EPSILON, 1000) else { return Vec::new() };
    let Some(directions) = svd.v_t else { return Vec::new() };
    let small = ROUND_OFF * svd.singular_values.amax().max(1.0);
    let null = (0..3).filter(|index| svd.singular_values[*index] <= small);
    null.map(|index| upright(&Vector3::from_fn(|axis, _| directions[(index, axis)]))).collect()
}

/// Returns the direction with its largest component positive and its round-off removed.
fn upright(direction: &Vector3) -> Vector3 {
    let largest = direction[direction.iamax()];
    direction.map(|value| if value.abs() < DIFFERENT { 0.0 } else { value * largest.signum() })
}

fn unit_axes(channel: &ActuatorSet) -> Vec<Vector3> {
    // A thruster through the mass centre produces no torque.
    let axes = channel.axes().iter().filter(|axis| axis.amax() > 0.0);
    axes.map(|axis| axis / axis.amax()).map(|axis| axis.normalize()).collect()
}

/// Returns whether two values of an angular momentum differ by more than round-off.
fn differ(problem: &Problem, a: f64, b: f64) -> bool {
    (a - b).abs() * problem.seconds() > DIFFERENT * problem.body.inertia.mean()
}

/// Reports that the momenta at both ends differ about an axis c on which no torque acts: a
/// direction with `rows · c = 0`.
fn differ_about(
    problem: &Problem,
    rows: &[Vector3],
    ends: [Vector3; 2],
    axis: &str,
    why: &str,
) -> Option<String> {
    null_space(rows).into_iter().find_map(|c| {
        let [before, after] = ends.map(|momentum| c.dot(&momentum));
        differ(problem, before, after).then(|| {
            format!(
                "no torque changes the angular momentum about the {axis} axis {}{why}: it is {} N·m·s at the start \
                 and {} at the end",
                direction(&c),
                about(before),
                about(after)
            )
        })
    })
}

fn symmetric_axis(problem: &Problem, ends: &Ends) -> Option<String> {
    let inertia = &problem.body.inertia;
    let j = inertia.j() / inertia.mean();
    let mut rows = unit_axes(&problem.actuation.torque);
    // J S(c) − S(c) J is linear in c: nine rows.
    let columns = [Vector3::x(), Vector3::y(), Vector3::z()].map(|c| j * hat(&c) - hat(&c) * j);
    rows.extend((0..9).map(|element| Vector3::from_fn(|column, _| columns[column][element])));
    let why = " (no actuator, and the body is symmetric about it)";
    differ_about(problem, &rows, ends.momentum, "body", why)
}

fn spatial_momentum(problem: &Problem, ends: &Ends) -> Option<String> {
    let momenta = [0, 1].map(|end| ends.spatial_momentum(end));
    differ_about(problem, &unit_axes(&problem.actuation.torque), momenta, "reference", "")
}

fn momentum_subspace(problem: &Problem, ends: &Ends) -> Option<String> {
    let inertia = &problem.body.inertia;
    let rate = |momentum: &Vector3| inertia.j_inverse() * momentum * inertia.mean();
    let [start, end] = ends.momentum;
    let mut basis: Vec<Vector3> = Vec::new();
    // Rates of unit momenta are at most `mean/J₁`, so this is their round-off.
    let small = ROUND_OFF * (inertia.mean() / inertia.principal()[0]);
    let outside = |basis: &[Vector3], vector: Vector3| {
        basis.iter().fold(vector, |rest, axis| rest - axis * axis.dot(&rest))
    };
    let add = |basis: &mut Vec<Vector3>, vector: Vector3| {
        let rest = outside(basis, vector);
        let grows = rest.norm() > small;
        basis.extend(grows.then(|| rest.normalize()));
        grows
    };
    // Even a very small component counts, because it may grow.
    for axis in start.try_normalize(0.0).into_iter().chain(unit_axes(&problem.actuation.torque)) {
        add(&mut basis, axis);
    }
    let mut grown = true;
    while grown && basis.len() < 3 {
        grown = false;
        for a in basis.clone() {
            for b in basis.clone() {
                grown |= add(&mut basis, a.cross(&rate(&b)) + b.cross(&rate(&a)));
            }
        }
    }
    let outside = outside(&basis, end);
    if basis.len() < 3 && differ(problem, outside.norm(), 0.0) {
        let where_ = if basis.len() == 1 { "one axis" } else { "one plane" };
        return Some(format!(
            "for any torques, the angular momentum stays in {where_} of the body, and the terminal \
            rate is outside of it by {} N·m·s along {}",
            about(outside.norm()),
            direction(&upright(&outside.normalize()))
        ));
    }
    let [axis] = basis[..] else { return None };
    let axis = upright(&axis);
    let relative = problem.start.attitude.tr_mul(&problem.end.attitude);
    let tilt = (relative * axis - axis).norm();
    (tilt > DIFFERENT).then(|| {
        format!(
            "for any torques, the body turns about its axis {} only: the direction of that axis is \
            conserved, and the terminal attitude tilts it by {:.3} deg",
            direction(&axis),
            (2.0 * (0.5 * tilt).min(1.0).asin()).to_degrees()
        )
    })
}

fn translation(problem: &Problem) -> Option<String> {
    if problem.motion == Motion::Attitude {
        return None;
    }
    let free = match &problem.actuation.force {
        None => vec![Vector3::x(), Vector3::y(), Vector3::z()],
        Some(channel) if channel.frame() == AxisFrame::Reference => null_space(&unit_axes(channel)),
        Some(_) => return None,
    };
    let (start, end, duration) = (&problem.start, &problem.end, problem.seconds());
    free.into_iter().find_map(|c| {
        let speeds = (c.dot(&start.velocity), c.dot(&end.velocity));
        let drifted = c.dot(&(start.position + start.velocity * duration));
        let position = c.dot(&end.position);
        let length = [start.position, end.position, start.velocity * duration, end.velocity * duration]
            .iter()
            .fold(0.0, |length, vector| vector.amax().max(length));
        let told = if (speeds.0 - speeds.1).abs() * duration > DIFFERENT * length {
            format!("velocity along it stays {} m/s", about(speeds.0)) + &ending(speeds.1)
        } else if (drifted - position).abs() > DIFFERENT * length {
            format!("position along it will be {} m", about(drifted)) + &ending(position)
        } else {
            return None;
        };
        Some(format!("no force acts along the reference axis {}: the {told}", direction(&c)))
    })
}

fn ending(value: f64) -> String {
    format!(" and the terminal one is {}", about(value))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::Matrix3;
    use crate::lie;
    use crate::maneuver::problem::State;
    use crate::mechanics::actuators::Actuation;
    use crate::mechanics::body::{Body, Inertia};

    fn problem(moments: [f64; 3], axes: &[[f64; 3]], frame: AxisFrame, end: State) -> Problem {
        let inertia = Inertia::diagonal(Vector3::from(moments)).unwrap();
        let axes: Vec<Vector3> = axes.iter().map(|axis| Vector3::from(*axis)).collect();
        let torque = ActuatorSet::new(axes, frame).unwrap();
        let body = Body { inertia, mass: None };
        Problem::attitude(body, State::at_rest(Matrix3::identity()), end, 2.0)
            .with_actuation(Actuation::torques(torque))
    }

    fn turned(rotation: [f64; 3], rate: [f64; 3]) -> State {
        State::attitude(lie::exp(&Vector3::from(rotation)), Vector3::from(rate))
    }

    #[test]
    fn one_axis_of_a_sphere_turns_about_itself_only() {
        let tilted =
            problem([1.0; 3], &[[1.0, 0.0, 0.0]], AxisFrame::Body, turned([0.5, 0.3, 0.0], [0.0; 3]));
        assert!(proof(&tilted).unwrap().contains("tilts it by"));
        let about = problem([1.0; 3], &[[1.0, 0.0, 0.0]], AxisFrame::Body, turned([0.5, 0.0, 0.0], [0.0; 3]));
        assert_eq!(proof(&about), None);
    }

    #[test]
    fn spin_of_a_symmetric_body_without_axial_torque_is_conserved() {
        let axes = [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0]];
        let spun = problem([2.0, 2.0, 1.0], &axes, AxisFrame::Body, turned([0.5, 0.3, 0.0], [0.0, 0.0, 0.2]));
        assert!(proof(&spun).unwrap().contains("(0, 0, 1)"));
        let at_rest = problem([2.0, 2.0, 1.0], &axes, AxisFrame::Body, turned([0.5, 0.3, 0.4], [0.0; 3]));
        assert_eq!(proof(&at_rest), None);
    }

    #[test]
    fn two_torques_steer_an_asymmetric_body_anywhere() {
        let axes = [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0]];
        let any = problem([1.0, 1.5, 0.8], &axes, AxisFrame::Body, turned([0.5, 0.3, 2.0], [0.1, 0.2, 0.3]));
        assert_eq!(proof(&any), None);
    }

    #[test]
    fn horizontal_reference_torques_leave_the_vertical_momentum() {
        let axes = [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0]];
        let spun = problem([1.0, 1.5, 0.8], &axes, AxisFrame::Reference, turned([0.0; 3], [0.0, 0.0, 0.3]));
        assert!(proof(&spun).unwrap().contains("reference axis (0, 0, 1)"));
    }
}
