//! The shortest path of a boresight around a keep-out cone: a great circle to the cone, an arc
//! along its rim, and another great circle.
//!
//! Let a cone have the half angle β < 90°. On the unit sphere let `d_0`, `d_1` be the distances
//! of the ends from its axis, and Δ the angle between the two ends at that axis. Then
//!
//! ```text
//! length = ℓ_0 + ℓ_1 + sin β (Δ − ψ_0 − ψ_1) ,   cos ℓ = cos d/cos β ,   cos ψ = tan β/tan d
//! ```
//!
//! as long as the bracket is positive; else the cone is not in the way of the great circle.

use crate::Vector3;
use crate::maneuver::constraint::angle_between;
use std::f64::consts::FRAC_PI_2;

/// A path of a boresight around a keep-out cone.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Detour {
    /// Name of the constraint.
    pub name: String,
    /// Half angle of the cone, margin included \[rad\].
    pub half_angle: f64,
    /// Angular distances of start and end from the axis of the cone \[rad\].
    distance: [f64; 2],
    /// Angle between start and end at the axis of the cone \[rad\].
    azimuth: f64,
    /// Length of the great circle from start to end \[rad\].
    direct: f64,
}

impl Detour {
    /// Builds the path of a boresight from the direction `start` to `end`, both outside of a cone
    /// about `axis`; unit vectors, inertial axes.
    pub(super) fn new(name: &str, half_angle: f64, axis: &Vector3, start: &Vector3, end: &Vector3) -> Self {
        let across = |v: &Vector3| axis.cross(v);
        Self {
            name: name.into(),
            half_angle,
            distance: [angle_between(axis, start), angle_between(axis, end)],
            azimuth: angle_between(&across(start), &across(end)),
            direct: angle_between(start, end),
        }
    }

    /// Returns the length \[rad\] of the shortest path from start to end around a cone with the
    /// half angle `half_angle` \[rad\] and the axis of this detour.
    pub(super) fn length(&self, half_angle: f64) -> f64 {
        if half_angle >= FRAC_PI_2 {
            // The outside of the cone is a convex cap, which contains the great circle.
            return self.direct;
        }
        let (sine, cosine) = half_angle.sin_cos();
        // An end on the rim, to round-off, is its own point of contact.
        let straight = |d: &f64| (d.cos() / cosine).clamp(-1.0, 1.0).acos();
        let turned = |d: &f64| (sine / cosine / d.tan()).clamp(-1.0, 1.0).acos();
        let rim = self.azimuth - self.distance.iter().map(turned).sum::<f64>();
        if rim <= 0.0 {
            return self.direct;
        }
        self.distance.iter().map(straight).sum::<f64>() + sine * rim
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::lie;
    use crate::testing::Random;

    /// Returns the length of a taut string of points that goes around the cone on one side.
    fn string(start: &Vector3, end: &Vector3, axis: &Vector3, half_angle: f64, side: f64) -> f64 {
        const COUNT: usize = 60;
        let meridian = |v: &Vector3| (v - axis * axis.dot(v)).normalize();
        let (from, to) = (meridian(start), meridian(end));
        let mut azimuth = angle_between(&from, &to);
        if from.cross(&to).dot(axis) * side < 0.0 {
            azimuth = std::f64::consts::TAU - azimuth;
        }
        let (d0, d1) = (angle_between(axis, start), angle_between(axis, end));
        let point = |index: usize| {
            let part = index as f64 / COUNT as f64;
            let distance = (d0 + part * (d1 - d0)).max(half_angle);
            let turned = lie::exp(&(axis * (side * part * azimuth))) * from;
            axis * distance.cos() + turned * distance.sin()
        };
        let mut points: Vec<Vector3> = (0..=COUNT).map(point).collect();
        for _ in 0..12_000 {
            for i in 1..COUNT {
                let mut p = (points[i - 1] + points[i + 1]).normalize();
                if angle_between(axis, &p) < half_angle {
                    p = axis * half_angle.cos() + meridian(&p) * half_angle.sin();
                }
                points[i] = p;
            }
        }
        points.windows(2).map(|pair| angle_between(&pair[0], &pair[1])).sum()
    }

    #[test]
    fn way_around_a_cone_is_that_of_a_taut_string() {
        let mut random = Random(9);
        let mut around = 0;
        for case in 0..8 {
            let axis = random.vector3().normalize();
            let half_angle = 0.3 + 0.5 * random.uniform().abs();
            let away = |random: &mut Random| loop {
                let v = random.vector3().normalize();
                if (half_angle..1.4).contains(&angle_between(&v, &axis)) {
                    return v;
                }
            };
            let start = away(&mut random);
            // Both ends are on roughly opposite sides, so that the cone is in the way.
            let through = lie::exp(&(axis * std::f64::consts::PI)) * start;
            let end = loop {
                let v = (through + 0.2 * random.vector3()).normalize();
                if angle_between(&v, &axis) > half_angle {
                    break v;
                }
            };
            let found = Detour::new("", half_angle, &axis, &start, &end);
            let expected = string(&start, &end, &axis, half_angle, 1.0)
                .min(string(&start, &end, &axis, half_angle, -1.0));
            let length = found.length(half_angle);
            assert!((length - expected).abs() < 3e-4, "{case}: {length} {expected}");
            assert!(length >= found.direct - 1e-12 && found.length(1e-6) <= length);
            around += usize::from(length > found.direct + 1e-3);
        }
        assert!(around >= 4, "only {around} cones were in the way");
    }
}
