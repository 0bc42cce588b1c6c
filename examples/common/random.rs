//! The splitmix64 generator: the same cases on every machine.

use slewkit::Vector3;

pub struct Random(u64);

impl Random {
    pub fn new(seed: u64) -> Self {
        Self(seed)
    }

    /// Uniform in [0, 1).
    pub fn unit(&mut self) -> f64 {
        self.0 = self.0.wrapping_add(0x9E37_79B9_7F4A_7C15);
        let mut z = self.0;
        z = (z ^ (z >> 30)).wrapping_mul(0xBF58_476D_1CE4_E5B9);
        z = (z ^ (z >> 27)).wrapping_mul(0x94D0_49BB_1331_11EB);
        ((z ^ (z >> 31)) >> 11) as f64 * 2.0f64.powi(-53)
    }

    /// Uniform on the unit sphere.
    pub fn direction(&mut self) -> Vector3 {
        loop {
            let v = Vector3::from_fn(|_, _| 2.0 * self.unit() - 1.0);
            let size = v.norm();
            if size > 0.1 && size < 1.0 {
                return v / size;
            }
        }
    }
}
