//! The gravity of a body.

use super::error::Checked;
use super::{HomogeneousPolyhedron, MassPoint, PointCloud};
use crate::mechanics::body::{Body, Inertia, InertiaError};
use crate::{Matrix3, Vector3};

/// The kind of gravity of a body.
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub enum Attractor {
    /// Point masses: exact among clouds, all pairs of points.
    Cloud(PointCloud),
    /// Mass and inertia alone, MacCullagh's formula: second order in size over distance in all its
    /// pairs.
    SecondOrder {
        /// Mass \[kg\].
        mass: f64,
        /// Inertia about the mass center, body axes.
        inertia: Inertia,
    },
    /// A homogeneous polyhedron: exact on points and clouds; on another polyhedron by Gauss points
    /// of the smaller one.
    Polyhedron(HomogeneousPolyhedron),
}

impl Attractor {
    /// Returns a sphere, or a point mass \[kg\].
    ///
    /// # Errors
    /// A [`FullBodyError`](super::FullBodyError) if the mass is not a positive number.
    pub fn point(mass: f64) -> Checked<Self> {
        Ok(Self::Cloud(PointCloud::new(vec![MassPoint { mass, position: Vector3::zeros() }])?))
    }

    /// Returns the mass \[kg\].
    pub fn mass(&self) -> f64 {
        match self {
            Self::Cloud(cloud) => cloud.mass(),
            Self::SecondOrder { mass, .. } => *mass,
            Self::Polyhedron(solid) => solid.mass(),
        }
    }

    /// Returns the inertia about the mass center [kg·m²], 3×3, body axes. Singular for points on a
    /// line.
    pub fn inertia(&self) -> Matrix3 {
        match self {
            Self::Cloud(cloud) => cloud.inertia(),
            Self::SecondOrder { inertia, .. } => *inertia.j(),
            Self::Polyhedron(solid) => solid.inertia(),
        }
    }

    /// Returns the rigid body for the integrators.
    ///
    /// # Errors
    /// An [`InertiaError`] if the inertia is singular: points on a line, or a single one.
    pub fn body(&self) -> Result<Body, InertiaError> {
        Ok(Body { inertia: Inertia::new(self.inertia())?, mass: Some(self.mass()) })
    }
}
