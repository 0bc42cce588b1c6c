//! Cones that leave no attitude at some moment.
//!
//! Outside of a cone of half angle β about w is inside of one of half angle 180° − β about −w. Two boresights
//! at the angle γ, each inside of its cone, α₁ about w₁ and α₂ about w₂ with δ between them, can be so if and
//! only if `|γ − δ| ≤ α₁ + α₂`. Between directions of which one turns with the reference frame δ changes, and
//! the extremes on the whole maneuver are those of one rotation ([`crate::constraint::Arc`]).

use super::capability::SLACK;
use super::words::{about, at_least};
use crate::constraint::{Arc, Constraint, Pointing, Rule, Side, Target, angle_between};
use crate::problem::Problem;
use crate::{Matrix3, Vector3};

/// Pairs of boresights and directions that are compared with each other.
const MAX_PAIRS: usize = 1000;

/// One boresight that has to be inside of one cone.
struct Inside<'a> {
    name: &'a str,
    boresight: &'a Vector3,
    /// Axis at `t = 0`, and whether it turns with the frame.
    axis: Vector3,
    turns: bool,
    half_angle: f64,
}

/// Which constraints leave no attitude, and when; `None` where there is always one, as far as two of them
/// are concerned.
pub(super) fn obstruction(problem: &Problem) -> Option<String> {
    let frame_turn = problem.environment.frame_rate() * problem.duration;
    let all: Vec<Inside> = problem.constraints.iter().flat_map(cones).take(MAX_PAIRS).collect();
    for (index, a) in all.iter().enumerate() {
        for b in &all[..index] {
            let between = angle_between(a.boresight, b.boresight);
            let allowed = a.half_angle + b.half_angle + SLACK;
            let (time, apart) = worst(a, b, between, &frame_turn);
            let missing = (between - apart).abs() - allowed;
            if missing > 0.0 {
                return Some(format!(
                    "\"{}\" and \"{}\" leave no attitude at t = {} s: {} deg are missing between their cones",
                    b.name,
                    a.name,
                    about(time * problem.duration),
                    at_least(missing.to_degrees())
                ));
            }
        }
    }
    None
}

/// When the angle between two axes is farthest from `between`, as a part of the duration, and that angle.
fn worst(a: &Inside, b: &Inside, between: f64, frame_turn: &Vector3) -> (f64, f64) {
    let (moving, standing) = if a.turns { (a, b) } else { (b, a) };
    let turn = if moving.turns && !standing.turns { *frame_turn } else { Vector3::zeros() };
    let arc = Arc { start: Matrix3::identity(), turn };
    let target = Target { start: standing.axis, turn: Vector3::zeros() };
    let extremes = [Side::KeepOut, Side::KeepIn].map(|side| arc.extreme(&moving.axis, &target, side));
    let off = |angle: f64| (angle - between).abs();
    let [near, far] = extremes.map(|extreme| (extreme.part, extreme.angle));
    if off(near.1) > off(far.1) { near } else { far }
}

fn cones(constraint: &Constraint) -> impl Iterator<Item = Inside<'_>> {
    let pointing = match &constraint.rule {
        Rule::Pointing(pointing) => Some(pointing),
        Rule::RateNorm(_) | Rule::RateAxes(_) => None,
    };
    pointing.into_iter().flat_map(move |pointing| {
        let (sign, half_angle) = inside(pointing);
        pointing.pairs().map(move |(boresight, direction)| Inside {
            name: &constraint.name,
            boresight,
            axis: sign * direction.vector,
            turns: direction.turns_with_frame,
            half_angle,
        })
    })
}

/// Sign of the axis and half angle of the cone to be inside of.
fn inside(pointing: &Pointing) -> (f64, f64) {
    let angle = pointing.effective_half_angle();
    match pointing.side {
        Side::KeepIn => (1.0, angle),
        Side::KeepOut => (-1.0, std::f64::consts::PI - angle),
    }
}
