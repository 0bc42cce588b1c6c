//! Charts of the attitude: Euler angles, quaternion, and the angle to the attitude at the end.

use super::charts::{shown, time_axis};
use super::{Shown, Subject, line};
use crate::draw::{Axis, Chart};
use slewkit::lie;
use slewkit_files::export::euler_angles;

/// Returns the charts of the Euler angles, the quaternion and the angle to the end attitude.
pub(super) fn charts(subject: &Subject) -> Vec<Shown> {
    let mut all = turning(subject);
    all.push(error(subject));
    all
}

/// Returns the charts of the Euler angles and the quaternion.
pub(super) fn turning(subject: &Subject) -> Vec<Shown> {
    let trajectory = subject.trajectory();
    vec![
        euler_chart(&trajectory.time, &trajectory.quaternion, subject.sequence),
        quaternion_chart(&trajectory.time, &trajectory.quaternion),
    ]
}

/// Returns the chart of the Euler angles in the given sequence, such as "zyx".
pub(super) fn euler_chart(time: &[f64], quaternions: &[[f64; 4]], sequence: &str) -> Shown {
    let angles = |quaternion: &[f64; 4]| {
        euler_angles(&lie::rotation_from_quaternion(quaternion), sequence).map(f64::to_degrees)
    };
    let angles: Vec<[f64; 3]> = quaternions.iter().map(angles).collect();
    let angles = unwrapped(angles);
    let curve = |index: usize| {
        let axis = &sequence[index..=index];
        let name = format!("{} about {axis}", ["first,", "second,", "third,"][index]);
        line(name, index, time, angles.iter().map(|angles| angles[index]))
    };
    let title = format!("Euler angles {sequence}");
    let chart = Chart::new(title, time_axis(), Axis::linear("angle, deg"), (0..3).map(curve).collect());
    let rotations = sequence.chars().map(|axis| format!("R{axis}")).collect::<Vec<_>>().join(" ");
    shown("euler", chart, format!("intrinsic: R = {rotations}; continued over full turns"))
}

/// Removes the jumps by full turns between consecutive angles \[deg\]. Near gimbal lock, the angles
/// still change fast.
fn unwrapped(mut angles: Vec<[f64; 3]>) -> Vec<[f64; 3]> {
    for row in 1..angles.len() {
        let before = angles[row - 1];
        for (angle, before) in angles[row].iter_mut().zip(before) {
            *angle += 360.0 * ((before - *angle) / 360.0).round();
        }
    }
    angles
}

/// Returns the chart of the four components of the quaternion.
pub(super) fn quaternion_chart(time: &[f64], quaternions: &[[f64; 4]]) -> Shown {
    let curve = |index: usize| {
        let values = quaternions.iter().map(move |quaternion| quaternion[index]);
        line(["w", "x", "y", "z"][index], [7, 0, 1, 2][index], time, values)
    };
    let curves = (0..4).map(curve).collect();
    let chart = Chart::new("Quaternion", time_axis(), Axis::linear("q"), curves);
    shown("quaternion", chart, "Hamilton, body to reference axes, continuous")
}

fn error(subject: &Subject) -> Shown {
    let trajectory = subject.trajectory();
    let end = &subject.problem.end.attitude;
    let left = trajectory
        .quaternion
        .iter()
        .map(|quaternion| lie::minus(&lie::rotation_from_quaternion(quaternion), end).norm().to_degrees());
    let title = "Angle to the end attitude";
    let course = match &subject.course {
        Some(Ok(course)) => course,
        other => {
            let chart = Chart::new(
                title,
                time_axis(),
                Axis::logarithmic("angle, deg"),
                vec![line("plan", 0, &trajectory.time, left)],
            );
            let why = match other {
                Some(Err(error)) => format!("the true motion is not shown: {error}"),
                _ => String::new(),
            };
            return shown("error", chart, why);
        }
    };
    let degrees = |angles: &[f64]| angles.iter().map(|angle| angle.to_degrees()).collect::<Vec<_>>();
    let curve = |name: &str, style: usize, angles: &[f64]| {
        line(name, style, &trajectory.time, degrees(angles).into_iter())
    };
    let curves = vec![
        curve("true motion", 0, &course.continuous_left),
        curve("discrete motion", 1, &course.discrete_left),
    ];
    let chart = Chart::new(title, time_axis(), Axis::logarithmic("angle, deg"), curves);
    shown(
        "error",
        chart,
        "by the witnesses: the continuous motion under the held torque, and the discrete one",
    )
}
