//! Random numbers of the examples: the same cases on every machine.

use slewkit::Vector3;

#[path = "../../tests/common/random.rs"]
mod splitmix;
pub use splitmix::Random;

impl Random {
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
