//! Volume, mass centre and second moments of a solid bounded by triangles, in closed form.
//!
//! The divergence theorem turns the integrals of 1, x and x xᵀ over the solid into sums of
//! polynomials over its faces (Mirtich 1996, Eberly 2002). The terms are the integrals over
//! tetrahedra from a common apex to the faces, with `d = a·(b × c)`:
//! ```text
//! V = Σ d/6      V x̄ = Σ d (a + b + c)/24      ∫ x xᵀ dV = Σ d [a aᵀ + b bᵀ + c cᵀ + s sᵀ]/120,   s = a + b + c
//! ```

use super::ShapeError;
use crate::{Matrix3, Vector3};

#[derive(Clone, Debug, PartialEq)]
pub(super) struct MassProperties {
    /// Volume `V` \[m³\].
    pub volume: f64,
    /// Mass centre `x̄` at constant density \[m\].
    pub center: Vector3,
    /// Second moments `∫ ρ ρᵀ dV` about the mass centre \[m⁵\].
    pub second: Matrix3,
}

impl MassProperties {
    /// The round-off of the volume, relative to area times size. Solids with less volume
    /// count as flat.
    const ROUND_OFF: f64 = 1e-12;

    pub fn new(vertices: &[Vector3], faces: &[[u32; 3]]) -> Result<Self, ShapeError> {
        // The sums are relative to the mean of the vertices and in units of the size of the solid,
        // so that terms neither cancel nor overflow.
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
        // The comparison is also false for NaN, which a size of zero causes.
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
