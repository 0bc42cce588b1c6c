//! Constraints on where the body may point and how fast it may turn.
//!
//! A constraint holds along the whole discrete trajectory: at the nodes, and on the arcs between
//! them. On an arc the body turns about one fixed axis at one fixed rate.

mod alternatives;
mod arc;
mod conflict;
mod during;

pub use crate::mechanics::direction::Direction;
pub use alternatives::{Alternatives, AlternativesError, Shift, Turns};
pub use arc::{Approach, Arc, Extreme, Target, angle_between};
pub use conflict::{Conflict, conflict};
pub use during::During;

use crate::numerics::figures::decimals;
use crate::{Matrix3, Vector3};
use std::f64::consts::PI;
use thiserror::Error;

/// Tolerance for rounding by which a boundary value may exceed its limit, relative to the limit, or
/// in \[rad\] for a cone.
pub const BOUNDARY_ROUNDING: f64 = 1e-9;

/// A constraint with its name.
#[derive(Clone, Debug, PartialEq)]
pub struct Constraint {
    /// The name of the constraint in reports and messages.
    pub name: String,
    /// The condition that the constraint imposes on the motion.
    pub rule: Rule,
}

/// The condition that a constraint imposes on the motion.
#[derive(Clone, Debug, PartialEq)]
pub enum Rule {
    /// Boresights stay outside of, or inside, cones about directions.
    Pointing(Pointing),
    /// The angular velocity `|Ω|` stays below a limit [rad/s].
    RateNorm(f64),
    /// Each component of the angular velocity, body axes, stays below its limit [rad/s] in size.
    RateAxes(Vector3),
}

/// The side of a cone on which a boresight must stay.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Side {
    /// Every boresight stays at least the half angle away from every direction.
    KeepOut,
    /// Every boresight stays within the half angle of every direction.
    KeepIn,
    /// Every boresight is held at the half angle from every direction: exactly at the nodes, and
    /// within the stated tolerance between them and at the ends. Between two nodes the boresight
    /// leaves the cone by an angle proportional to the square of the arc.
    On {
        /// The largest deviation from the cone \[rad\].
        within: f64,
    },
}

impl Side {
    /// Returns the extremes of the angle along an arc at which the margin can be smallest.
    fn extremes(self) -> &'static [Extreme] {
        match self {
            Self::KeepOut => &[Extreme::Nearest],
            Self::KeepIn => &[Extreme::Farthest],
            Self::On { .. } => &[Extreme::Nearest, Extreme::Farthest],
        }
    }
}

/// Cones about directions. They apply to every pair of a boresight and a direction.
#[derive(Clone, Debug, PartialEq)]
pub struct Pointing {
    /// The side of the cones on which the boresights stay.
    pub side: Side,
    /// Boresights, unit vectors in body axes.
    pub boresights: Vec<Vector3>,
    /// The axes of the cones.
    pub directions: Vec<Direction>,
    /// Half angle of the cones \[rad\], in (0, π).
    pub half_angle: f64,
    /// The margin \[rad\]. It enlarges a keep-out cone and reduces a keep-in cone. It is 0 if a
    /// boresight is held on the cone.
    pub margin: f64,
    /// The times at which the cones are active. Default: always.
    pub during: During,
}

/// The reason why a constraint is invalid.
#[derive(Clone, Debug, Error, PartialEq)]
pub enum ConstraintError {
    /// A boresight or direction is not a unit vector.
    #[error("a vector of a pointing constraint has length {length}: it must be 1")]
    Vector {
        /// Length of the vector.
        length: f64,
    },
    /// A pointing constraint has no boresight, or no direction.
    #[error("a pointing constraint needs at least one boresight and one direction")]
    Nothing,
    /// The half angle with the margin is not between 0 and 180°.
    #[error("the half angle with the margin is {degrees} deg: it must be more than 0 and less than 180")]
    Angle {
        /// Half angle with margin \[deg\].
        degrees: f64,
    },
    /// A constraint that holds a boresight on a cone has a margin, or a tolerance that is not
    /// positive.
    #[error(
        "a boresight held on a cone has a margin, or no positive tolerance: remove the margin and give a \
     positive tolerance"
    )]
    OnCone,
    /// Time intervals are not finite, or overlap.
    #[error("the intervals of a constraint must be finite and in order, without overlap")]
    Intervals,
    /// A rate limit is not positive and finite.
    #[error("a rate limit is {value} rad/s: it must be positive and finite")]
    Rate {
        /// The invalid limit [rad/s].
        value: f64,
    },
    /// Another constraint has this name, so reports could not distinguish the two.
    #[error("another constraint has this name")]
    SameName,
}

impl Pointing {
    /// Builds cones of a half angle \[rad\] about directions, for boresights in body axes.
    /// Boresights and directions must be unit vectors. The cones have no margin and are always
    /// active.
    pub fn new(side: Side, boresights: Vec<Vector3>, directions: Vec<Direction>, half_angle: f64) -> Self {
        Self { side, boresights, directions, half_angle, margin: 0.0, during: During::default() }
    }

    /// Returns the half angle of the cone with the margin included \[rad\].
    pub fn effective_half_angle(&self) -> f64 {
        match self.side {
            Side::KeepOut => self.half_angle + self.margin,
            Side::KeepIn => self.half_angle - self.margin,
            Side::On { .. } => self.half_angle,
        }
    }

    /// Returns the margin \[rad\] of a boresight at `angle` from a direction. A negative margin
    /// is a violation.
    pub fn room(&self, angle: f64) -> f64 {
        self.room_beside(angle, 0.0)
    }

    /// Returns the margin \[rad\] of a boresight at `angle` from the centre of a disc of angular
    /// `radius`, for a cone about the limb of the disc.
    pub fn room_beside(&self, angle: f64, radius: f64) -> f64 {
        let outside = angle - self.effective_half_angle() - radius;
        match self.side {
            Side::KeepOut => outside,
            Side::KeepIn => -outside,
            Side::On { within } => within - outside.abs(),
        }
    }

    /// Returns the point of an arc at which the margin of a boresight to a target is smallest, and
    /// this margin \[rad\]. The arc begins at `time` and lasts `step` \[s\]. Returns `None` if the
    /// constraint is not active on the arc.
    pub fn least_room(
        &self,
        arc: &Arc,
        boresight: &Vector3,
        target: &Target,
        [time, step]: [f64; 2],
    ) -> Option<(Approach, f64)> {
        let met = self.during.parts(time, step).flat_map(|part| {
            let (arc, target) = (arc.piece(part), target.piece(part));
            let at =
                move |found: Approach| Approach { part: part[0] + found.part * (part[1] - part[0]), ..found };
            let extremes = self.side.extremes().iter();
            extremes.map(move |extreme| at(arc.extreme(boresight, &target, *extreme)))
        });
        let met = met.map(|found| (found, self.room_beside(found.angle, target.radius_at(found.part))));
        met.reduce(|least, next| if next.1 < least.1 || next.1.is_nan() { next } else { least })
    }

    /// Returns every pair of a boresight and a direction.
    pub fn pairs(&self) -> impl Iterator<Item = (&Vector3, &Direction)> {
        self.boresights.iter().flat_map(|b| self.directions.iter().map(move |w| (b, w)))
    }
}

/// Returns the motion of a direction along the arc of `step` \[s\] that begins at `time` \[s\], in
/// the axes that the reference frame has at `t = 0`. The frame turns at `frame_rate`. A moving
/// direction is approximated by a rotation at a constant rate from its first to its last position
/// on the arc, and the radius of a disc by linear growth; the error in between is at most
/// `h²|d̈|/8` and `h²|r̈|/8`.
pub fn on_arc(direction: &Direction, time: f64, step: f64, frame_rate: &Vector3) -> Target {
    let start = direction.in_space(time, frame_rate).direction;
    match direction {
        Direction::Fixed(_) => Target::fixed(start),
        Direction::InFrame(_) => Target { turn: frame_rate * step, ..Target::fixed(start) },
        Direction::Moving(_) | Direction::Disc { .. } => {
            let turn = turn_between(&start, &direction.in_space(time + step, frame_rate).direction);
            let [first, last] = [time, time + step].map(|time| direction.angular_radius(time));
            Target { start, turn, radius: first, growth: last - first }
        }
    }
}

/// Returns the rotation vector of the shortest turn from one unit vector to another.
pub fn turn_between(from: &Vector3, to: &Vector3) -> Vector3 {
    let axis = from.cross(to);
    let sine = axis.norm();
    if sine == 0.0 { Vector3::zeros() } else { axis * (sine.atan2(from.dot(to)) / sine) }
}

impl Constraint {
    /// Checks that vectors have unit length, that angles and limits are in range, and that time
    /// intervals are in order.
    ///
    /// # Errors
    /// Returns a [`ConstraintError`] that names the wrong value.
    pub fn check(&self) -> Result<(), ConstraintError> {
        let positive = |value: f64| {
            if value > 0.0 && value.is_finite() { Ok(()) } else { Err(ConstraintError::Rate { value }) }
        };
        match &self.rule {
            Rule::RateNorm(limit) => positive(*limit),
            Rule::RateAxes(limits) => limits.iter().try_for_each(|limit| positive(*limit)),
            Rule::Pointing(pointing) => {
                if pointing.boresights.is_empty() || pointing.directions.is_empty() {
                    return Err(ConstraintError::Nothing);
                }
                let lengths = pointing.boresights.iter().map(Vector3::norm);
                let is_unit = |length: &f64| (length - 1.0).abs() <= 1e-9;
                let odd = lengths.into_iter().find(|length| !is_unit(length));
                let odd = odd.or_else(|| pointing.directions.iter().find_map(Direction::length_defect));
                if let Some(length) = odd {
                    return Err(ConstraintError::Vector { length });
                }
                let angle = pointing.effective_half_angle();
                let cone = |angle: f64| angle > 0.0 && angle < PI;
                // The half angle is measured from the limb of a disc as seen at the start.
                let discs = pointing.directions.iter().map(|direction| angle + direction.angular_radius(0.0));
                let angle = discs.fold(angle, f64::max);
                if let Side::On { within } = pointing.side
                    && !(within > 0.0 && within.is_finite() && pointing.margin == 0.0)
                {
                    return Err(ConstraintError::OnCone);
                }
                if !pointing.during.is_in_order() {
                    return Err(ConstraintError::Intervals);
                }
                let usable = cone(angle) && cone(pointing.half_angle) && pointing.margin >= 0.0;
                if usable { Ok(()) } else { Err(ConstraintError::Angle { degrees: angle.to_degrees() }) }
            }
        }
    }

    /// Returns the violation of the constraint by a body in `attitude` with angular velocity
    /// `rate` [rad/s] at `time` \[s\], in words with the value and the limit; `None` if the
    /// constraint holds, also exactly on the limit.
    ///
    /// The reference frame turns at `frame_rate` [rad/s]. If several pairs are violated, the worst
    /// one is reported. If `time` is `None`, moving directions are ignored.
    pub fn violation(
        &self,
        attitude: &Matrix3,
        rate: &Vector3,
        time: Option<f64>,
        frame_rate: &Vector3,
    ) -> Option<String> {
        let above = |value: f64, limit: f64| value > limit * (1.0 + BOUNDARY_ROUNDING);
        let told = |value: f64, limit: f64| {
            let (value, limit) = distinct(value.to_degrees(), limit.to_degrees());
            format!("is {value} deg/s, the limit is {limit} deg/s")
        };
        match &self.rule {
            Rule::RateNorm(limit) => {
                above(rate.norm(), *limit).then(|| format!("the rate {}", told(rate.norm(), *limit)))
            }
            Rule::RateAxes(limits) => {
                let excess = |axis: &usize| rate[*axis].abs() / limits[*axis];
                let worst = (0..3).max_by(|a, b| excess(a).total_cmp(&excess(b)))?;
                let (value, limit) = (rate[worst].abs(), limits[worst]);
                let axis = ["x", "y", "z"][worst];
                above(value, limit).then(|| format!("the rate about {axis} {}", told(value, limit)))
            }
            Rule::Pointing(pointing) => pointing.violation(attitude, time, frame_rate),
        }
    }
}

impl Pointing {
    fn violation(&self, attitude: &Matrix3, time: Option<f64>, frame_rate: &Vector3) -> Option<String> {
        let limit = self.effective_half_angle();
        let several = self.directions.len() > 1;
        let (mut worst, mut found) = (BOUNDARY_ROUNDING, None);
        for (index, (boresight, direction)) in self.pairs().enumerate() {
            let still = direction.is_still(frame_rate);
            // If the time is unknown, a moving direction may be anywhere.
            let always = self.during.given().is_none();
            let Some(time) = time.or((still && always).then_some(0.0)) else { continue };
            if !self.during.contains(time) {
                continue;
            }
            let (b, w) = (attitude * boresight, direction.at(time, frame_rate));
            let angle = angle_between(&b, &w);
            let limit = limit + direction.angular_radius(time);
            let excess = -self.room_beside(angle, direction.angular_radius(time));
            if excess > worst {
                (worst, found) = (excess, Some((index, angle, limit)));
            }
        }
        let (index, angle, limit) = found?;
        let (boresight, direction) = (index / self.directions.len(), index % self.directions.len());
        let name = |what: &str, many: bool, index: usize| {
            if many { format!("{what} {}", index + 1) } else { format!("the {what}") }
        };
        let boresight = name("boresight", self.boresights.len() > 1, boresight);
        let axis = if several { name("direction", true, direction) } else { "the axis".into() };
        let (angle, cone) = distinct(angle.to_degrees(), limit.to_degrees());
        let margin = decimals(self.margin.to_degrees(), 4);
        let margin = match (self.margin > 0.0, self.side) {
            (false, _) => String::new(),
            (true, Side::KeepOut) => format!(", margin of {margin} deg included"),
            (true, Side::KeepIn) => format!(", margin of {margin} deg subtracted"),
            (true, Side::On { .. }) => String::new(),
        };
        Some(format!("{boresight} is {angle} deg from {axis}, the cone is {cone} deg{margin}"))
    }
}

/// Formats two numbers with the fewest digits that distinguish them.
fn distinct(value: f64, limit: f64) -> (String, String) {
    let largest = value.abs().max(limit.abs());
    if !(1e-4..1e7).contains(&largest) {
        return (format!("{value:e}"), format!("{limit:e}"));
    }
    let least = (2 - largest.log10().floor() as i32).max(0) as usize;
    let pair = |digits| (decimals(value, digits), decimals(limit, digits));
    // The limit is shown exactly as written if at most three more digits suffice.
    let rounded = |digits: usize| (limit - decimals(limit, digits).parse().unwrap_or(limit)).abs();
    let fits = |digits: &usize| {
        let (a, b) = pair(*digits);
        a != b && (rounded(*digits) <= 1e-12 * limit.abs() || *digits >= least + 3)
    };
    pair((least..16).find(fits).unwrap_or(16))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::mechanics::direction::{Track, TrackError};

    fn cone(side: Side, half_angle: f64, margin: f64) -> Constraint {
        let directions = vec![Direction::Fixed(Vector3::z())];
        let boresights = vec![Vector3::x()];
        let (half_angle, margin) = (half_angle.to_radians(), margin.to_radians());
        let pointing = Pointing::new(side, boresights, directions, half_angle);
        let rule = Rule::Pointing(Pointing { margin, ..pointing });
        Constraint { name: "cone".into(), rule }
    }

    /// Returns the violation by a body whose boresight x is turned about −y by `angle`, so that the
    /// boresight is 90° − `angle` from z.
    fn found(constraint: &Constraint, angle: f64) -> Option<String> {
        let attitude = crate::lie::exp(&(Vector3::y() * -angle.to_radians()));
        constraint.violation(&attitude, &Vector3::zeros(), Some(0.0), &Vector3::zeros())
    }

    #[test]
    fn a_cone_is_violated_inside_or_outside_and_not_on_its_surface() {
        let out = cone(Side::KeepOut, 35.0, 0.5);
        let told =
            "the boresight is 12.3 deg from the axis, the cone is 35.5 deg, margin of 0.5 deg included";
        assert_eq!(found(&out, 77.7).as_deref(), Some(told));
        assert_eq!(found(&out, 54.5), None);
        assert_eq!(found(&out, 54.5 + 5e-8), None);
        assert_eq!(
            found(&out, 54.5 + 1e-6).as_deref(),
            Some(
                "the boresight is 35.499999 deg from the axis, the cone is 35.5 deg, margin of 0.5 deg included"
            )
        );
        let within = cone(Side::KeepIn, 20.0, 0.0);
        assert_eq!(found(&within, 70.0), None);
        let told = "the boresight is 90 deg from the axis, the cone is 20 deg";
        assert_eq!(found(&within, 0.0).as_deref(), Some(told));
    }

    #[test]
    fn an_inertial_direction_turns_against_a_turning_frame() {
        // A quarter turn of the frame about y takes the inertial z to −x of the frame.
        let constraint = cone(Side::KeepOut, 10.0, 0.0);
        let rate = Vector3::y() * PI / 2.0;
        let back = crate::lie::exp(&(Vector3::z() * PI));
        let found = |time| constraint.violation(&back, &Vector3::zeros(), Some(time), &rate);
        assert_eq!(found(0.0), None);
        assert!(found(1.0).is_some_and(|told| told.contains("is 0 deg from the axis")), "{:?}", found(1.0));
    }

    #[test]
    fn a_rate_is_violated_above_its_limit_and_not_on_it() {
        let degrees = |x: f64, y: f64, z: f64| Vector3::new(x, y, z).map(f64::to_radians);
        let norm = Constraint { name: "n".into(), rule: Rule::RateNorm(0.25_f64.to_radians()) };
        let axes = Constraint { name: "a".into(), rule: Rule::RateAxes(degrees(1.0, 2.0, 3.0)) };
        let told = |constraint: &Constraint, rate: Vector3| {
            constraint.violation(&Matrix3::identity(), &rate, Some(0.0), &Vector3::zeros())
        };
        assert_eq!(told(&norm, degrees(0.15, 0.2, 0.0)), None);
        let wanted = "the rate is 0.5 deg/s, the limit is 0.25 deg/s";
        assert_eq!(told(&norm, degrees(0.0, 0.0, -0.5)).as_deref(), Some(wanted));
        assert_eq!(told(&axes, degrees(-1.0, 2.0, 3.0)), None);
        let wanted = "the rate about y is 2.5 deg/s, the limit is 2 deg/s";
        assert_eq!(told(&axes, degrees(1.1, -2.5, 3.0)).as_deref(), Some(wanted));
    }

    #[test]
    fn numbers_are_short_and_told_apart() {
        let both = |value, limit| {
            let (a, b) = distinct(value, limit);
            format!("{a} {b}")
        };
        assert_eq!(both(12.3, 35.0), "12.3 35");
        assert_eq!(both(34.999_999_9, 35.0), "34.9999999 35");
        assert_eq!(both(1234.5678, 0.25), "1235 0.25".replace("1235", "1234.57"));
        assert_eq!(both(1e9, 2.0), "1e9 2e0");
    }

    /// Checks the smallest margin of a body at rest to a sphere. It is at the end of a step if the
    /// sphere approaches, and at the start if the sphere recedes.
    #[test]
    fn a_disc_grows_along_an_arc() {
        let moving = |by: f64| {
            let centre = Track::fitted(0.0, 10.0, 10.0, 16, |time| {
                Ok::<_, TrackError>(Vector3::z() * (2.0 - by * time))
            });
            Direction::Disc { centre: centre.unwrap(), radius: 1.0 }
        };
        let cone = |direction: Direction| {
            Pointing::new(Side::KeepOut, vec![Vector3::x()], vec![direction], 20.0_f64.to_radians())
        };
        let arc = Arc { start: Matrix3::identity(), turn: Vector3::zeros() };
        let room = |distance: f64| 70.0_f64.to_radians() - (1.0 / distance).asin();
        for (by, part, at_start) in [(0.05, 1.0, 2.0), (-0.05, 0.0, 2.0)] {
            let direction = moving(by);
            let pointing = cone(direction.clone());
            let target = on_arc(&direction, 0.0, 4.0, &Vector3::zeros());
            let (found, least) =
                pointing.least_room(&arc, &Vector3::x(), &target, [0.0, 4.0]).expect("it acts");
            assert_eq!(found.part, part);
            assert!((least - room(at_start - 4.0 * by * part)).abs() < 1e-12, "{by} {least}");
            // Between the ends of the step the radius is accurate to second order in the step.
            let halves = [4.0, 2.0, 1.0].map(|step| {
                let target = on_arc(&direction, 0.0, step, &Vector3::zeros());
                (target.radius_at(0.5) - direction.angular_radius(0.5 * step)).abs()
            });
            assert!(
                halves[0] < 4e-3 && halves[1] < 0.3 * halves[0] && halves[2] < 0.3 * halves[1],
                "{halves:?}"
            );
            // The smallest margin is taken only over the time at which the cone is active.
            let first = Pointing { during: During::intervals(vec![[0.0, 1.0]]), ..pointing };
            let (_, least) = first.least_room(&arc, &Vector3::x(), &target, [0.0, 4.0]).expect("it acts");
            let linear = 70.0_f64.to_radians() - target.radius_at(0.25 * part);
            assert!((least - linear).abs() < 1e-12, "{by} {least}");
        }
    }
}
