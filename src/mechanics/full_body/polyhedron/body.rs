//! A polyhedron of constant density as an attracting rigid body.

use super::{Polyhedron, PolyhedronField};
use crate::mechanics::full_body::error::{Checked, count};
use crate::mechanics::full_body::{MassPoint, PointCloud};
use crate::mechanics::number::{finite, positive};
use crate::{Matrix3, Vector3};

/// A polyhedron of constant density whose mass centre is the origin of the body axes.
///
/// Its gravity on points and clouds is exact. Between two polyhedra, the exact field of the
/// polyhedron with the larger radius acts on the Gauss points of the other
/// ([`Polyhedron::cubature`]). The error falls as `O((l/d)^{2 order})`, with l the size of a
/// tetrahedron of the smaller body and d its distance from the surface of the larger body.
#[derive(Clone, Debug, PartialEq)]
pub struct HomogeneousPolyhedron {
    shape: Polyhedron,
    density: f64,
    mass: f64,
    field: PolyhedronField,
    cubature: PointCloud,
}

impl HomogeneousPolyhedron {
    /// Builds the body of a solid with the given density [kg/m³]. `order³` Gauss points per face
    /// represent it in the field of another polyhedron.
    ///
    /// # Errors
    /// Returns a [`FullBodyError`](crate::mechanics::full_body::FullBodyError) if the density is
    /// not a positive number, the mass centre is not the origin ([`Polyhedron::centered`] moves it
    /// to the origin), or the order is not from 1 to [`Polyhedron::ORDER`] or gives more than
    /// [`PointCloud::POINTS`] points.
    pub fn new(shape: Polyhedron, density: f64, order: usize) -> Checked<Self> {
        positive("density", density)?;
        count("order of the cubature", order, Polyhedron::ORDER)?;
        count("Gauss points of a polyhedron", shape.faces().len() * order.pow(3), PointCloud::POINTS)?;
        shape.check_centered()?;
        let mass =
            positive("mass of a polyhedron", finite("mass of a polyhedron", density * shape.volume())?)?;
        let points = shape.cubature(order).into_iter();
        let points = points.map(|point| MassPoint { mass: density * point.mass, ..point });
        let cubature = PointCloud::weighted(points.collect());
        Ok(Self { density, mass, field: PolyhedronField::new(&shape), cubature, shape })
    }

    /// Builds the body of a solid with the given mass \[kg\].
    ///
    /// # Errors
    /// Returns the errors of [`HomogeneousPolyhedron::new`].
    pub fn with_mass(shape: Polyhedron, mass: f64, order: usize) -> Checked<Self> {
        let density = positive("mass of a polyhedron", mass)? / shape.volume();
        Self::new(shape, density, order)
    }

    /// Returns the solid.
    pub fn shape(&self) -> &Polyhedron {
        &self.shape
    }

    /// Returns the density [kg/m³].
    pub fn density(&self) -> f64 {
        self.density
    }

    /// Returns the mass \[kg\].
    pub fn mass(&self) -> f64 {
        self.mass
    }

    /// Returns the inertia about the mass centre [kg·m²], 3×3, body axes.
    pub fn inertia(&self) -> Matrix3 {
        self.density * self.shape.unit_inertia()
    }

    /// Returns the exact field of the solid, for `G = 1` and density 1.
    pub fn field(&self) -> &PolyhedronField {
        &self.field
    }

    /// Returns the Gauss points with their masses: a cloud that approximates the body. Some masses
    /// are negative if the solid is not [star-shaped](Polyhedron::is_star_shaped).
    pub fn cubature(&self) -> &PointCloud {
        &self.cubature
    }

    /// Returns the gravitational acceleration of a point at `y` (body axes \[m\]), divided by `G`
    /// \[kg/m²\].
    pub fn attraction(&self, y: &Vector3) -> Vector3 {
        self.density * self.field.attraction(y)
    }
}
