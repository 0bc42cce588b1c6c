//! Random numbers that are the same on every machine and in every version, so that the cases of
//! tests and counts never change.

use slewkit::mechanics::Inertia;
use slewkit::{Matrix3, Vector3, lie};
use std::f64::consts::PI;

/// A stream of random numbers, by SplitMix64 (Steele, Lea, Flood 2014).
pub struct Random(u64);

impl Random {
    /// Builds the stream of a seed.
    pub fn new(seed: u64) -> Self {
        Self(seed)
    }

    /// Builds the stream of random numbers for one case of a seed.
    pub fn of_case(seed: u64, index: usize) -> Self {
        let mut random = Self::new(seed ^ (index as u64).wrapping_mul(0xD134_2543_DE82_EF95));
        random.unit();
        random
    }

    /// Draws 64 uniform bits.
    pub fn bits(&mut self) -> u64 {
        self.0 = self.0.wrapping_add(0x9e37_79b9_7f4a_7c15);
        let mut z = self.0;
        z = (z ^ (z >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
        z ^ (z >> 31)
    }

    /// Draws a number uniform in [0, 1): the upper 53 bits, so that every value is exact.
    pub fn unit(&mut self) -> f64 {
        (self.bits() >> 11) as f64 * 2.0_f64.powi(-53)
    }

    /// Draws a number uniform in [−1, 1).
    pub fn uniform(&mut self) -> f64 {
        2.0 * self.unit() - 1.0
    }

    /// Draws a number uniform between two others.
    pub fn within(&mut self, low: f64, high: f64) -> f64 {
        low + (high - low) * self.unit()
    }

    /// Draws a whole number from 0 to `count − 1`.
    pub fn below(&mut self, count: usize) -> usize {
        (self.unit() * count as f64) as usize
    }

    /// Draws one of the given values.
    pub fn pick<T: Copy>(&mut self, from: &[T]) -> T {
        from[self.below(from.len())]
    }

    /// Draws true with probability ½.
    pub fn coin(&mut self) -> bool {
        self.unit() < 0.5
    }

    /// Draws a normally distributed number of mean 0 and variance 1, by the Box–Muller method.
    pub fn normal(&mut self) -> f64 {
        (-2.0 * (1.0 - self.unit()).ln()).sqrt() * (2.0 * PI * self.unit()).cos()
    }

    /// Draws a vector uniform in the cube [−1, 1)³.
    pub fn vector(&mut self) -> Vector3 {
        Vector3::from_fn(|_, _| self.uniform())
    }

    /// Draws a vector uniform in the cube [−half, half)³.
    pub fn within_cube(&mut self, half: f64) -> Vector3 {
        Vector3::from_fn(|_, _| self.within(-half, half))
    }

    /// Draws a direction uniform on the unit sphere, as the direction of a random point in the unit
    /// ball.
    pub fn direction(&mut self) -> Vector3 {
        loop {
            let v = self.vector();
            if (0.01..=1.0).contains(&v.norm()) {
                return v.normalize();
            }
        }
    }

    /// Draws a direction uniform on the unit sphere from three normally distributed numbers. It
    /// uses the stream in another way than [`Self::direction`].
    pub fn normal_direction(&mut self) -> Vector3 {
        Vector3::from_fn(|_, _| self.normal()).normalize()
    }

    /// Draws a rotation by a random angle about a random axis. It is not uniform on SO(3).
    pub fn rotation(&mut self) -> Matrix3 {
        lie::exp(&(self.direction() * (PI * self.uniform())))
    }

    /// Draws a rotation uniform on SO(3), from a normalised quaternion of four normally distributed
    /// numbers.
    pub fn uniform_rotation(&mut self) -> Matrix3 {
        let q: [f64; 4] = std::array::from_fn(|_| self.normal());
        let norm = q.iter().map(|value| value * value).sum::<f64>().sqrt();
        lie::rotation_from_quaternion(&q.map(|value| value / norm))
    }

    /// Draws the principal moments of inertia of a body \[kg·m²\]. The principal second moments of
    /// mass are log-uniform over a factor of 40, and are drawn again while the ratio of the largest
    /// to the smallest moment exceeds `ratio`.
    pub fn moments(&mut self, ratio: f64) -> Vector3 {
        loop {
            let d: [f64; 3] = std::array::from_fn(|_| 40f64.powf(-self.unit()));
            let moments = Vector3::new(d[1] + d[2], d[2] + d[0], d[0] + d[1]);
            if moments.amax() <= ratio * moments.amin() {
                return moments;
            }
        }
    }

    /// Draws principal moments of inertia with a ratio of at most `ratio` and a mean of 1
    /// \[kg·m²\].
    pub fn mean_moments(&mut self, ratio: f64) -> Vector3 {
        let moments = self.moments(ratio);
        moments * (3.0 / moments.sum())
    }

    /// Draws an inertia with moments as in [`Self::mean_moments`] about principal axes uniform on
    /// SO(3).
    pub fn inertia(&mut self, ratio: f64) -> Inertia {
        let moments = self.mean_moments(ratio);
        self.about_any_axes(&moments)
    }

    /// Draws an inertia with the given moments about principal axes uniform on SO(3).
    pub fn about_any_axes(&mut self, moments: &Vector3) -> Inertia {
        let axes = self.uniform_rotation();
        let j = axes * Matrix3::from_diagonal(moments) * axes.transpose();
        Inertia::new(0.5 * (j + j.transpose())).expect("a physical inertia")
    }
}
