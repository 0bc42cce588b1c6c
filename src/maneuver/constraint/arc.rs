//! The arc of the motion between two nodes, and the smallest and largest angle between a boresight
//! and a direction on the arc.
//!
//! On one step of the variational integrators the body turns about one axis at one rate, seen
//! from inertial space: `A(τ) = A_k exp(τ S(f))`, `0 ≤ τ ≤ 1`, `F_k = exp S(f)`. Let `e = f/|f|`
//! and `v = A_kᵀw`. A direction `w` fixed in inertial space then has
//!
//! ```text
//! w·A(τ) b = a + c cos(τ|f|) + s sin(τ|f|) ,   a = (e·v)(e·b) ,   c = v·b − a ,   s = v·(e × b)
//! ```
//!
//! so the extremum inside the arc is at `τ|f| = atan2(±s, ±c)`. A direction that turns with a
//! reference frame leads to a product of two rotations, whose extremum has no closed form. In that
//! case a cubic interpolates values and slopes on pieces so short that its error is below
//! round-off.

use crate::{Matrix3, Vector3, lie};

/// The motion of the body from one node to the next.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Arc {
    /// Attitude at the start of the arc, body → inertial.
    pub start: Matrix3,
    /// Rotation vector of the whole arc, body axes \[rad\].
    pub turn: Vector3,
}

/// A moving direction during an arc: `exp(τ S(turn)) start`, with τ from 0 to 1.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Target {
    /// Unit vector at the start of the arc, inertial axes.
    pub start: Vector3,
    /// Rotation vector of the motion of the direction over the arc, inertial axes \[rad\]; zero for
    /// a fixed direction.
    pub turn: Vector3,
    /// Angular radius of the target at the start of the arc \[rad\]: the angle from its centre to
    /// its limb, 0 for a point.
    pub radius: f64,
    /// Change of the angular radius over the arc \[rad\], at a constant rate.
    pub growth: f64,
}

/// The kind of extreme of the angle between a boresight and the limb of a target on an arc. For a
/// point target the angle is measured from the boresight to the point.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Extreme {
    /// The smallest angle along the arc.
    Nearest,
    /// The largest angle along the arc.
    Farthest,
}

/// The point on an arc at which a boresight is nearest to a target, or farthest from it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Approach {
    /// Position on the arc, as a fraction from 0 to 1.
    pub part: f64,
    /// Angle between the boresight and the direction (or the centre of a disc) at this position
    /// \[rad\].
    pub angle: f64,
}

/// The largest piece \[rad\] of the joint rotation of body and target on which a cubic is accurate
/// to round-off: its error is `x⁴/384`.
const PIECE: f64 = 2e-3;

/// The largest number of pieces of an arc. Motions of more than a hundred radians in one step
/// exceed it, and the result is NaN.
const MAX_PIECES: f64 = 65_536.0;

/// Returns the angle between two vectors \[rad\], accurate to round-off also near 0 and π.
pub fn angle_between(a: &Vector3, b: &Vector3) -> f64 {
    a.cross(b).norm().atan2(a.dot(b))
}

impl Target {
    /// Builds a fixed target.
    pub fn fixed(start: Vector3) -> Self {
        Self { start, turn: Vector3::zeros(), radius: 0.0, growth: 0.0 }
    }

    /// Returns the angular radius after the fraction `part` of the arc \[rad\].
    pub fn radius_at(&self, part: f64) -> f64 {
        self.radius + part * self.growth
    }

    /// Returns a bound on the change, along the arc, of the angle from a boresight at rest to the
    /// limb \[rad\].
    pub fn travel(&self) -> f64 {
        self.turn.norm() + self.growth.abs()
    }

    /// Returns the direction after the fraction `part` of the arc, inertial axes.
    pub fn at(&self, part: f64) -> Vector3 {
        if self.turn == Vector3::zeros() { self.start } else { lie::exp(&(part * self.turn)) * self.start }
    }

    /// Returns the motion of the target between two fractions of the arc, as an arc of its own.
    pub(super) fn piece(&self, [from, to]: [f64; 2]) -> Self {
        Self {
            start: self.at(from),
            turn: self.turn * (to - from),
            radius: self.radius_at(from),
            growth: self.growth * (to - from),
        }
    }
}

impl Arc {
    /// Returns the attitude after the fraction `part` of the arc, body → inertial.
    pub fn attitude(&self, part: f64) -> Matrix3 {
        self.start * lie::exp(&(part * self.turn))
    }

    /// Returns the angle between `boresight` (unit vector, body axes) and `target` after the
    /// fraction `part` of the arc \[rad\].
    pub fn angle(&self, boresight: &Vector3, target: &Target, part: f64) -> f64 {
        angle_between(&(self.attitude(part) * boresight), &target.at(part))
    }

    /// Returns the motion between two fractions of the arc, as an arc of its own.
    pub(super) fn piece(&self, [from, to]: [f64; 2]) -> Self {
        if from == 0.0 && to == 1.0 {
            return *self;
        }
        Self { start: self.attitude(from), turn: self.turn * (to - from) }
    }

    /// Returns the point of the arc with the smallest or largest angle from the limb of a target.
    /// The result is NaN if an input is NaN, or if the turn exceeds a hundred radians.
    pub fn extreme(&self, boresight: &Vector3, target: &Target, which: Extreme) -> Approach {
        let at = |part: f64| Approach { part, angle: self.angle(boresight, target, part) };
        let worse = |a: Approach, b: Approach| {
            let [before, after] = [&a, &b].map(|point| point.angle - target.radius_at(point.part));
            let (smaller, larger) = (after < before, after > before);
            let taken = if which == Extreme::Nearest { smaller } else { larger };
            if taken || after.is_nan() { b } else { a }
        };
        let ends = worse(at(0.0), at(1.0));
        if target.turn == Vector3::zeros() && target.growth == 0.0 {
            self.turning_point(boresight, &target.start, which).map_or(ends, |part| worse(ends, at(part)))
        } else {
            self.turning_points(boresight, target, which).map(at).fold(ends, worse)
        }
    }

    /// Returns the fraction of the arc at which the angle from `boresight` to the fixed direction
    /// `direction` has its extremum, in closed form; `None` if the extremum is not on the arc.
    fn turning_point(&self, boresight: &Vector3, direction: &Vector3, which: Extreme) -> Option<f64> {
        let angle = self.turn.norm();
        if angle == 0.0 {
            return None;
        }
        let axis = self.turn / angle;
        let v = self.start.tr_mul(direction);
        let c = v.dot(boresight) - axis.dot(&v) * axis.dot(boresight);
        let s = v.dot(&axis.cross(boresight));
        let phase = if which == Extreme::Nearest { s.atan2(c) } else { (-s).atan2(-c) };
        // On an arc of more than half a turn, the extremum may be at the phase plus a full turn.
        let phase = if phase < 0.0 { phase + std::f64::consts::TAU } else { phase };
        (phase <= angle).then_some(phase / angle)
    }

    /// Returns the fractions of the arc at which the cubics have their extrema, one or two for each
    /// piece, or NaN if the pieces are too many.
    ///
    /// The angle θ from a limb of radius r has its extremum where `θ′ = r′`, which is where
    /// `g = cos θ + ∫ r′ sin θ dτ` has its extremum. The cubic has the values and the slopes of g.
    /// If a boresight passes the centre of the target, θ has its extremum at a kink, at which the
    /// cubic of cos θ has its extremum too.
    fn turning_points(
        &self,
        boresight: &Vector3,
        target: &Target,
        which: Extreme,
    ) -> impl Iterator<Item = f64> + use<> {
        let sign = if which == Extreme::Nearest { 1.0 } else { -1.0 };
        let (arc, target, boresight) = (*self, *target, *boresight);
        let sample = move |part: f64| {
            let (attitude, w) = (arc.attitude(part), target.at(part));
            let (v, dv) = (attitude * boresight, attitude * arc.turn.cross(&boresight));
            let grown = if target.growth == 0.0 { 0.0 } else { target.growth * w.cross(&v).norm() };
            (sign * w.dot(&v), sign * (w.dot(&dv) + target.turn.cross(&w).dot(&v)), sign * grown)
        };
        let pieces = ((self.turn.norm() + target.travel()) / PIECE).ceil().max(1.0);
        let usable = pieces <= MAX_PIECES;
        let count = if usable { pieces as u32 } else { 1 };
        let length = 1.0 / f64::from(count);
        let mut left = sample(0.0);
        let tips = move |piece: u32| {
            if !usable {
                return [Some(f64::NAN), None];
            }
            let start = f64::from(piece) * length;
            let right = sample(start + length);
            let grown = 0.5 * length * (left.2 + right.2);
            let [first, last] = [left, right].map(|(_, slope, growth)| length * (slope + growth));
            let of_limb = highest_of_cubic(left.0, right.0 + grown, first, last);
            let of_centre = || highest_of_cubic(left.0, right.0, length * left.1, length * right.1);
            let of_centre = if target.growth == 0.0 { None } else { of_centre() };
            left = right;
            [of_limb, of_centre].map(|found| found.map(|part| start + part * length))
        };
        (0..count).flat_map(tips).flatten()
    }
}

/// Returns the position of the maximum of the cubic on [0, 1] with these values and slopes at its
/// ends, if the maximum is inside the interval or, to round-off, at an end: a maximum on the border
/// of two pieces must not be missed.
fn highest_of_cubic(value_0: f64, value_1: f64, slope_0: f64, slope_1: f64) -> Option<f64> {
    const BORDER: f64 = 1e-6;
    // p' = slope_0 + 2 q x + 3 r x²
    let rise = value_1 - value_0;
    let q = 3.0 * rise - 2.0 * slope_0 - slope_1;
    let r = slope_0 + slope_1 - 2.0 * rise;
    let discriminant = q * q - 3.0 * r * slope_0;
    if discriminant < 0.0 {
        return None;
    }
    // Selects the root with p'' = 2 (q + 3 r x) < 0, in the form without cancellation.
    let root = discriminant.sqrt();
    let x = if q < 0.0 { slope_0 / (root - q) } else { (-root - q) / (3.0 * r) };
    (x > -BORDER && x < 1.0 + BORDER).then_some(x.clamp(0.0, 1.0))
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Returns the maximum of `p = c₀ + c₁x + c₂x² + c₃x³` on [0, 1].
    fn highest([c0, c1, c2, c3]: [f64; 4]) -> Option<f64> {
        highest_of_cubic(c0, c0 + c1 + c2 + c3, c1, c1 + 2.0 * c2 + 3.0 * c3)
    }

    #[test]
    fn maxima_of_cubics_are_found_in_every_branch() {
        let close = |found: Option<f64>, x: f64| found.is_some_and(|found| (found - x).abs() < 1e-14);
        assert!(close(highest([0.3, 1.0, 0.0, -1.0]), (1.0_f64 / 3.0).sqrt()));
        assert!(close(highest([0.0, 1.0, -1.0, 0.0]), 0.5));
        // p' = −3 (x − 0.25)(x − 0.5): the maximum is at 0.5; p' = 3 (x − 0.25)(x − 0.5): at 0.25.
        assert!(close(highest([0.0, -0.375, 1.125, -1.0]), 0.5));
        assert!(close(highest([0.0, 0.375, -1.125, 1.0]), 0.25));
        for none in [[0.0, 1.0, 0.0, 0.0], [0.0, -1.0, 1.0, 0.0], [1.0, 1.0, 1.0, 1.0], [1.0, 0.0, 0.0, 0.0]]
        {
            assert_eq!(highest(none), None, "{none:?}");
        }
        assert_eq!(highest([0.0, 0.0, -1.0, 0.0]), Some(0.0));
        assert!(close(highest([0.0, 2.0, -1.0, 0.0]), 1.0));
    }

    /// Compares with ten thousand points of the arc. From an orbit, a limb grows a thousand times
    /// less in a step, and the error is proportional to the growth.
    #[test]
    fn a_limb_that_grows_is_nearest_where_the_angle_less_its_radius_is_least() {
        let arc =
            Arc { start: lie::exp(&Vector3::new(0.2, -0.7, 0.4)), turn: Vector3::new(0.05, 0.31, -0.22) };
        let boresight = Vector3::new(0.6, 0.0, 0.8);
        for (growth, turn) in [(0.2, 0.0), (-0.2, 0.0), (0.05, 0.1), (-0.35, 0.0), (0.0, 0.1)] {
            for aside in [0.0, 0.02, 0.7] {
                let start = arc.attitude(0.4) * lie::exp(&(Vector3::y() * aside)) * boresight;
                let turn = Vector3::new(0.4, 0.3, 0.9) * turn;
                let target = Target { start, turn, radius: 0.3, growth };
                let room = |part: f64| arc.angle(&boresight, &target, part) - target.radius_at(part);
                let sampled = (0..=10_000).map(|index| room(f64::from(index) * 1e-4));
                let (least, most) = sampled
                    .fold((f64::INFINITY, f64::NEG_INFINITY), |(least, most), next| {
                        (least.min(next), most.max(next))
                    });
                for (which, sampled) in [(Extreme::Nearest, least), (Extreme::Farthest, most)] {
                    let found = arc.extreme(&boresight, &target, which);
                    assert_eq!(found.angle, arc.angle(&boresight, &target, found.part));
                    let beyond =
                        (room(found.part) - sampled) * if which == Extreme::Nearest { 1.0 } else { -1.0 };
                    // Sampled points are up to 2e-5 rad from the extreme of an angle that may pass
                    // the centre.
                    let told = format!("{growth} {turn:?} {aside} {which:?}: {beyond:e}");
                    assert!(beyond < 1e-8 && beyond > -3e-5, "{told}");
                }
            }
        }
    }
}
