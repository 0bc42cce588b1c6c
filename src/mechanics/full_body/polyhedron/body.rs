//! A polyhedron of constant density as an attracting rigid body.

use super::{Polyhedron, PolyhedronField};
use crate::mechanics::full_body::error::{Checked, count};
use crate::mechanics::full_body::{MassPoint, PointCloud};
use crate::mechanics::number::{finite, positive};
use crate::{Matrix3, Vector3};

/// A polyhedron of constant density, its mass center at the origin of the body axes.
///
/// Its gravity is exact on points and clouds. Between two polyhedra the exact field of the one
/// with the larger radius acts on the Gauss points of the other ([`Polyhedron::cubature`]). The
/// error falls as `O((l/d)^{2 order})`, with l the size of a tetrahedron of the smaller body and
/// d its distance from the surface of the larger one.
#[derive(Clone, Debug, PartialEq)]
pub struct HomogeneousPolyhedron {
    shape: Polyhedron,
    density: f64,
    mass: f64,
    field: PolyhedronField,
    cubature: PointCloud,
}

impl HomogeneousPolyhedron {
    /// Builds the body of a solid with a density [kg/m³], with `order³` Gauss points per face for
    /// the attraction of another polyhedron.
    ///
    /// # Errors
    /// A [`FullBodyError`](crate::mechanics::full_body::FullBodyError) if the density is not a
    /// positive number, the mass center is not the origin ([`Polyhedron::centered`] moves it
    /// there), or the order is not within 1 and [`Polyhedron::ORDER`] or gives more than
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

    /// Returns the body with a given mass \[kg\].
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

    /// Returns the inertia about the mass center [kg·m²], 3×3, body axes.
    pub fn inertia(&self) -> Matrix3 {
        self.density * self.shape.unit_inertia()
    }

    /// Returns the exact field of the body, for `G` and density 1.
    pub fn field(&self) -> &PolyhedronField {
        &self.field
    }

    /// Returns its Gauss points with their masses: a cloud that approximates the body. Masses are
    /// negative where the solid is not [star-shaped](Polyhedron::is_star_shaped).
    pub fn cubature(&self) -> &PointCloud {
        &self.cubature
    }

    /// Returns the acceleration of a point at `y` (body axes \[m\]) for a gravitational constant of
    /// 1 \[kg/m²\].
    pub fn attraction(&self, y: &Vector3) -> Vector3 {
        self.density * self.field.attraction(y)
    }
}
