//! Pairs of cones that exclude every attitude at some time.
//!
//! The outside of a cone of half angle β about w is the inside of a cone of half angle 180° − β
//! about −w. Let two boresights have the angle γ, and two cones the half angles α₁, α₂ and the
//! angle δ between their axes. An attitude with each boresight inside of its cone exists if and
//! only if `|γ − δ| ≤ α₁ + α₂`. If one of the directions turns with the reference frame, δ changes;
//! its extremes over a whole maneuver have the closed form of a rotation about a fixed axis
//! ([`Arc`]).

use super::{
    Arc, BOUNDARY_ROUNDING, Constraint, Direction, Extreme, Pointing, Rule, Side, Target, angle_between,
};
use crate::{Matrix3, Vector3};
use std::f64::consts::PI;

/// The largest number of pairs of a boresight and a direction that are compared.
const MAX_PAIRS: usize = 1000;

/// Two constraints that exclude each other.
#[derive(Clone, Debug, PartialEq)]
pub struct Conflict<'a> {
    /// Names of the two constraints, in their order in the list. A constraint that contradicts
    /// itself is named twice.
    pub names: [&'a str; 2],
    /// The time of the conflict, as a fraction of the duration of the maneuver.
    pub part: f64,
    /// The angle by which the cones are too small for a common attitude \[rad\].
    pub missing: f64,
}

/// Returns the first two constraints that together exclude every attitude at some time of a
/// maneuver; `None` if no two constraints do. The reference frame turns by the vector `frame_turn`
/// \[rad\] during the maneuver.
///
/// The constraints must be valid ([`Constraint::check`]).
pub fn conflict<'a>(constraints: &'a [Constraint], frame_turn: &Vector3) -> Option<Conflict<'a>> {
    let all: Vec<Inside> = constraints.iter().flat_map(cones).take(MAX_PAIRS).collect();
    all.iter()
        .enumerate()
        .find_map(|(index, second)| all[..index].iter().find_map(|first| first.conflict(second, frame_turn)))
}

/// A boresight and a cone in which it must stay.
struct Inside<'a> {
    name: &'a str,
    boresight: &'a Vector3,
    /// Axis of the cone at `t = 0`. `turns` states whether the axis turns with the reference frame.
    axis: Vector3,
    turns: bool,
    half_angle: f64,
}

impl<'a> Inside<'a> {
    fn conflict(&self, other: &Inside<'a>, frame_turn: &Vector3) -> Option<Conflict<'a>> {
        let between = angle_between(self.boresight, other.boresight);
        let (moving, standing) = if self.turns { (self, other) } else { (other, self) };
        let turn = if moving.turns && !standing.turns { *frame_turn } else { Vector3::zeros() };
        let arc = Arc { start: Matrix3::identity(), turn };
        let target = Target::fixed(standing.axis);
        let off = |which: Extreme| {
            let extreme = arc.extreme(&moving.axis, &target, which);
            (extreme.part, (extreme.angle - between).abs())
        };
        let (near, far) = (off(Extreme::Nearest), off(Extreme::Farthest));
        let (part, worst) = if near.1 > far.1 { near } else { far };
        let missing = worst - self.half_angle - other.half_angle;
        let names = [self.name, other.name];
        (missing > BOUNDARY_ROUNDING).then_some(Conflict { names, part, missing })
    }
}

/// Returns the constraint as cones in which boresights must stay.
fn cones(constraint: &Constraint) -> impl Iterator<Item = Inside<'_>> {
    let pointing = match &constraint.rule {
        // A constraint that is active only at stated times proves nothing.
        Rule::Pointing(pointing) => Some(pointing).filter(|pointing| pointing.during.given().is_none()),
        Rule::RateNorm(_) | Rule::RateAxes(_) => None,
    };
    let sides = pointing.into_iter().flat_map(|pointing| inside(pointing).map(move |side| (pointing, side)));
    sides.flat_map(move |(pointing, (sign, half_angle))| {
        // A direction that moves on its own proves nothing.
        let constant = pointing.pairs().filter_map(|(b, to)| Some((b, to, to.constant()?)));
        constant.map(move |(boresight, direction, vector)| Inside {
            name: &constraint.name,
            boresight,
            axis: sign * vector,
            turns: matches!(direction, Direction::InFrame(_)),
            half_angle,
        })
    })
}

/// Returns the sign of the axis and the half angle of each cone in which a boresight must stay.
fn inside(pointing: &Pointing) -> impl Iterator<Item = (f64, f64)> + use<> {
    let angle = pointing.effective_half_angle();
    let (within, without) = match pointing.side {
        Side::KeepIn => (Some(angle), None),
        Side::KeepOut => (None, Some(angle)),
        Side::On { within } => (Some(angle + within), Some(angle - within)),
    };
    let without = without.map(|angle| (-1.0, PI - angle));
    within.map(|angle| (1.0, angle)).into_iter().chain(without)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::testing::Random;

    fn cone(name: &str, side: Side, boresight: Vector3, vector: Vector3, half_angle: f64) -> Constraint {
        let (boresights, directions) = (vec![boresight], vec![Direction::Fixed(vector)]);
        let rule = Rule::Pointing(Pointing::new(side, boresights, directions, half_angle));
        Constraint { name: name.into(), rule }
    }

    /// Compares the formula with a search for the attitude at which both boresights are nearest to
    /// their cones.
    #[test]
    fn two_cones_exclude_each_other_where_no_attitude_is_inside_of_both() {
        let mut random = Random(12);
        let (mut free, mut excluded) = (0, 0);
        for case in 0..400 {
            let unit = |random: &mut Random| random.vector3().normalize();
            let sides =
                [case % 2, case / 2 % 2].map(|odd| if odd == 0 { Side::KeepIn } else { Side::KeepOut });
            let angles = sides.map(|side| {
                let inside = 0.25 * PI * (1.0 + 0.9 * random.uniform());
                if side == Side::KeepIn { inside } else { PI - inside }
            });
            let list = [0, 1].map(|index| {
                let (b, w) = (unit(&mut random), unit(&mut random));
                cone(["a", "b"][index], sides[index], b, w, angles[index])
            });
            // Returns the larger distance of a boresight from its cone.
            let missed = |attitude: &Matrix3| {
                let missed = list
                    .iter()
                    .flat_map(cones)
                    .map(|cone| angle_between(&(attitude * cone.boresight), &cone.axis) - cone.half_angle);
                missed.fold(f64::NEG_INFINITY, f64::max)
            };
            let mut best = (0..300).map(|_| random.rotation()).min_by(|a, b| missed(a).total_cmp(&missed(b)));
            for step in 0..12_000 {
                let size = 10.0_f64.powf(-f64::from(step) / 2400.0);
                let tried = best.map(|best| best * crate::lie::exp(&(size * random.vector3())));
                if tried.as_ref().map(missed) < best.as_ref().map(missed) {
                    best = tried;
                }
            }
            let missed = best.as_ref().map(missed).unwrap();
            let found = conflict(&list, &Vector3::zeros());
            match &found {
                None => assert!(missed < 1e-3, "{case}: {missed} {list:?}"),
                Some(found) => {
                    assert_eq!(found.names, ["a", "b"]);
                    // At the optimum both cones are missed by half of the missing angle.
                    assert!((missed - 0.5 * found.missing).abs() < 2e-3, "{case}: {missed} {found:?}");
                }
            }
            free += usize::from(found.is_none());
            excluded += usize::from(found.is_some());
        }
        assert!(free > 50 && excluded > 20, "{free} {excluded}");
    }
}
