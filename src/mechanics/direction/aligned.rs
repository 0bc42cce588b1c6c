//! The attitude with one body axis along a direction, and a second body axis as near as possible to
//! a second direction.

use super::LineOfSight;
use crate::{Matrix3, Vector3};

/// The attitude that points one body axis along a direction, and a second body axis as closely as
/// possible towards a second direction. It includes the angular velocity ω and the angular
/// acceleration of the frame that stays aligned, in the axes of the directions.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct AlignedFrame {
    /// Attitude, body → axes of the directions: `Σ tᵢsᵢᵀ`.
    pub attitude: Matrix3,
    /// Angular velocity ω \[rad/s\].
    pub rate: Vector3,
    /// Angular acceleration ω̇ \[rad/s²\].
    pub acceleration: Vector3,
}

impl AlignedFrame {
    /// Builds the frame from `t₁ = d₁`, `t₂ = N/n`, `N = d₁ × d₂`, `n = |N|`, `t₃ = t₁ × t₂`, and
    /// `s`, which is built from the body axes as `t` is from the directions:
    ///
    /// ```text
    /// σ = t₃·Ṅ/n ,   ω = d₁ × ḋ₁ + σd₁ ,   σ̇ = (t₃·N̈ + (ω × t₃)·Ṅ − σ t₂·Ṅ)/n ,   ω̇ = d₁ × d̈₁ + σ̇d₁ + σḋ₁
    /// ```
    ///
    /// The result is not finite if the directions, or the axes, are parallel.
    pub fn of(axes: [&Vector3; 2], directions: [&LineOfSight; 2]) -> Self {
        let triad = |first: &Vector3, second: &Vector3| {
            let t2 = first.cross(second).normalize();
            Matrix3::from_columns(&[*first, t2, first.cross(&t2)])
        };
        let [a, b] = directions;
        let body = triad(axes[0], axes[1]);
        let space = triad(&a.direction, &b.direction);
        let (t2, t3) = (space.column(1).into_owned(), space.column(2).into_owned());
        let n = a.direction.cross(&b.direction).norm();
        let first = a.rate.cross(&b.direction) + a.direction.cross(&b.rate);
        let second = a.acceleration.cross(&b.direction)
            + 2.0 * a.rate.cross(&b.rate)
            + a.direction.cross(&b.acceleration);
        let roll = t3.dot(&first) / n;
        let rate = a.direction.cross(&a.rate) + a.direction * roll;
        let change = (t3.dot(&second) + rate.cross(&t3).dot(&first) - roll * t2.dot(&first)) / n;
        let acceleration = a.direction.cross(&a.acceleration) + a.direction * change + a.rate * roll;
        Self { attitude: space * body.transpose(), rate, acceleration }
    }
}

#[cfg(test)]
mod tests {
    use super::super::Direction;
    use super::super::track::tests::passing;
    use super::*;
    use crate::lie;

    #[test]
    fn an_aligned_frame_moves_as_it_says() {
        let (sun, station) =
            (Direction::Fixed(Vector3::new(0.2, 0.9, -0.3).normalize()), Direction::Moving(passing()));
        let (axes, h, zero) = ([Vector3::z(), Vector3::new(0.6, 0.0, 0.8)], 1e-3, Vector3::zeros());
        let at = |t: f64| {
            AlignedFrame::of([&axes[0], &axes[1]], [&station.in_space(t, &zero), &sun.in_space(t, &zero)])
        };
        for t in [5.0, 58.0, 61.0, 120.0] {
            let (before, here, after) = (at(t - h), at(t), at(t + h));
            let rate = lie::log(&(after.attitude * before.attitude.transpose())) / (2.0 * h);
            let acceleration = (after.rate - before.rate) / (2.0 * h);
            assert!((here.attitude * axes[0] - station.at(t, &zero)).amax() < 1e-14);
            assert!((here.rate - rate).amax() < 1e-8, "{t} {} {rate}", here.rate);
            assert!((here.acceleration - acceleration).amax() < 1e-8, "{t}");
        }
    }
}
