//! The gravity model of a body.

use super::error::Checked;
use super::{HomogeneousPolyhedron, MassPoint, PointCloud};
use crate::mechanics::body::{Body, Inertia, InertiaError};
use crate::{Matrix3, Vector3};

/// The gravity model of a body.
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub enum Attractor {
    /// Point masses. The gravity between two clouds is exact: all pairs of points are summed.
    Cloud(PointCloud),
    /// Only mass and inertia, by MacCullagh's formula. All pairs with such a body are of second
    /// order in size over distance.
    SecondOrder {
        /// Mass \[kg\].
        mass: f64,
        /// Inertia about the mass centre, body axes.
        inertia: Inertia,
    },
    /// A homogeneous polyhedron. Its gravity on points and clouds is exact. Between two polyhedra
    /// it acts on Gauss points of the smaller one.
    Polyhedron(HomogeneousPolyhedron),
}

impl Attractor {
    /// Returns a point mass \[kg\], which has the gravity of a homogeneous sphere.
    ///
    /// # Errors
    /// Returns a [`FullBodyError`](super::FullBodyError) if the mass is not a positive number.
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

    /// Returns the inertia about the mass centre [kg·m²], 3×3, body axes. It is singular if all
    /// points are on a line.
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
    /// Returns an [`InertiaError`] if the inertia is singular: all points on a line, or a single
    /// point.
    pub fn body(&self) -> Result<Body, InertiaError> {
        Ok(Body { inertia: Inertia::new(self.inertia())?, mass: Some(self.mass()) })
    }
}
