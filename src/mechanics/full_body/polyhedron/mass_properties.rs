//! Volume, mass center and second moments of a solid bounded by triangles, in closed form.
//!
//! The divergence theorem turns the integrals of 1, x and x xᵀ over the solid into sums of
//! polynomials over its faces (Mirtich 1996, Eberly 2002). They belong to the tetrahedra from a
//! common apex, `d = a·(b × c)`:
//! ```text
//! V = Σ d/6      V x̄ = Σ d (a + b + c)/24      ∫ x xᵀ dV = Σ d [a aᵀ + b bᵀ + c cᵀ + s sᵀ]/120,   s = a + b + c
//! ```

use super::ShapeError;
use crate::{Matrix3, Vector3};

#[derive(Clone, Debug, PartialEq)]
pub(super) struct MassProperties {
    /// `V` \[m³\].
    pub volume: f64,
    /// `x̄` \[m\].
    pub center: Vector3,
    /// `∫ ρ ρᵀ dV` about the mass center \[m⁵\].
    pub second: Matrix3,
}

impl MassProperties {
    /// The volume below which a solid counts as flat, relative to a third of area times size: the
    /// round-off of its sum.
    const ROUND_OFF: f64 = 1e-12;

    pub fn new(vertices: &[Vector3], faces: &[[u32; 3]]) -> Result<Self, ShapeError> {
        // The sums are about the middle and in units of the size, so that no term cancels or leaves
        // the range of numbers.
        let apex = vertices.iter().map(|vertex| vertex / vertices.len() as f64).sum::<Vector3>();
        let size = vertices.iter().map(|vertex| (vertex - apex).amax()).fold(0.0, f64::max);
        let (mut volume, mut area, mut first, mut second) = (0.0, 0.0, Vector3::zeros(), Matrix3::zeros());
        for face in faces {
            let [a, b, c] = face.map(|index| (vertices[index as usize] - apex) / size);
            let (d, s) = (a.dot(&b.cross(&c)), a + b + c);
            area += 0.5 * (b - a).cross(&(c - a)).norm();
            volume += d / 6.0;
            first += d / 24.0 * s;
            second +=
                d / 120.0 * (a * a.transpose() + b * b.transpose() + c * c.transpose() + s * s.transpose());
        }
        // False also for NaN, from a size of zero.
        let is_solid = volume.abs() > Self::ROUND_OFF * area;
        if !is_solid {
            return Err(ShapeError::NoVolume { volume: volume * size.powi(3), area: area * size.powi(2) });
        }
        if volume < 0.0 {
            return Err(ShapeError::Inverted { volume: volume * size.powi(3) });
        }
        let middle = first / volume;
        second -= volume * middle * middle.transpose();
        Ok(Self {
            volume: volume * size.powi(3),
            center: apex + size * middle,
            second: second * size.powi(5),
        })
    }
}
