//! Homogeneous polyhedra: the solid, its mass properties, its exact field, and points that
//! represent the solid.

mod body;
mod cubature;
mod error;
mod field;
mod lattice;
mod mass_properties;
mod obj;
mod surface;

pub use body::HomogeneousPolyhedron;
pub use error::ShapeError;
pub use field::PolyhedronField;
pub(in crate::mechanics::full_body) use field::side_by_side;
pub use obj::{ObjError, ObjProblem, read_obj};

use super::error::centered;
use crate::mechanics::body::principal_axes;
use crate::{Matrix3, Vector3};
use mass_properties::MassProperties;

/// A solid bounded by triangles. The surface is closed, every edge belongs to two faces, and the
/// normals of the faces point outward.
///
/// [`ShapeError`] lists the checks. The surface may intersect itself without an error; a volume
/// that it encloses twice then counts twice.
#[derive(Clone, Debug, PartialEq)]
pub struct Polyhedron {
    vertices: Vec<Vector3>,
    faces: Vec<[u32; 3]>,
    properties: MassProperties,
}

impl Polyhedron {
    /// The largest number of vertices, and the largest number of faces.
    pub const SIZE: usize = 1_000_000;
    /// Largest magnitude of a coordinate \[m\].
    pub const COORDINATE: f64 = 1e30;

    /// Builds the solid within these triangles. They name vertices by indices from 0, and run
    /// counterclockwise as seen from outside.
    ///
    /// # Errors
    /// Returns a [`ShapeError`] that names the vertex, face or edge. A triangle of zero area is
    /// allowed.
    pub fn new(vertices: Vec<Vector3>, faces: Vec<[u32; 3]>) -> Result<Self, ShapeError> {
        surface::check(&vertices, &faces)?;
        let properties = MassProperties::new(&vertices, &faces)?;
        Ok(Self { vertices, faces, properties })
    }

    /// Builds the octahedron with vertices at `±a e₁`, `±b e₂`, `±c e₃` \[m\], as in Fahnestock et
    /// al. (2006).
    ///
    /// # Errors
    /// Returns a [`ShapeError`] if a semi-axis is not a positive number.
    pub fn octahedron(semi_axes: &Vector3) -> Result<Self, ShapeError> {
        let corner =
            |k: usize| if k.is_multiple_of(2) { 1.0 } else { -1.0 } * Vector3::ith(k / 2, semi_axes[k / 2]);
        let octants = (0..8u32).map(|octant| {
            let [x, y, z] = [octant & 1, 2 + (octant >> 1 & 1), 4 + (octant >> 2)];
            // Every reflection reverses the orientation of the face.
            if octant.count_ones().is_multiple_of(2) { [x, y, z] } else { [x, z, y] }
        });
        Self::new((0..6).map(corner).collect(), octants.collect())
    }

    /// Builds the cuboid with the edge lengths `edges` \[m\] along the axes, and its centre at the
    /// origin.
    ///
    /// # Errors
    /// Returns a [`ShapeError`] if an edge length is not a positive number.
    pub fn cuboid(edges: &Vector3) -> Result<Self, ShapeError> {
        let corner =
            |k: usize| Vector3::from_fn(|axis, _| if k >> axis & 1 == 1 { 0.5 } else { -0.5 } * edges[axis]);
        let quads = [[0, 4, 6, 2], [1, 3, 7, 5], [0, 1, 5, 4], [2, 6, 7, 3], [0, 2, 3, 1], [4, 5, 7, 6]];
        let halves = quads.iter().flat_map(|&[a, b, c, d]| [[a, b, c], [a, c, d]]);
        Self::new((0..8).map(corner).collect(), halves.collect())
    }

    /// Returns the vertices \[m\].
    pub fn vertices(&self) -> &[Vector3] {
        &self.vertices
    }

    /// Returns the triangles, as indices of vertices from 0.
    pub fn faces(&self) -> &[[u32; 3]] {
        &self.faces
    }

    /// Returns the volume \[m³\].
    pub fn volume(&self) -> f64 {
        self.properties.volume
    }

    /// Returns the mass centre at constant density \[m\].
    pub fn center(&self) -> &Vector3 {
        &self.properties.center
    }

    /// Returns the inertia about the mass centre at constant density 1 kg/m³,
    /// `∫ (|ρ|² I − ρ ρᵀ) dV` \[m⁵\], 3×3.
    pub fn unit_inertia(&self) -> Matrix3 {
        let second = self.properties.second;
        second.trace() * Matrix3::identity() - second
    }

    /// Returns the distance of the farthest vertex from the origin \[m\].
    pub fn radius(&self) -> f64 {
        self.vertices.iter().map(|vertex| vertex.norm()).fold(0.0, f64::max)
    }

    /// Returns whether every point of the surface is visible from the mass centre. The weights of
    /// [`cubature`](Self::cubature) are then all positive.
    pub fn is_star_shaped(&self) -> bool {
        let center = self.center();
        self.triangles().all(|[a, b, c]| (a - center).dot(&(b - a).cross(&(c - a))) >= 0.0)
    }

    /// Returns the solid moved so that its mass centre is the origin.
    #[must_use]
    pub fn centered(&self) -> Self {
        let center = *self.center();
        let vertices = self.vertices.iter().map(|vertex| vertex - center).collect();
        let properties = MassProperties { center: Vector3::zeros(), ..self.properties.clone() };
        Self { vertices, faces: self.faces.clone(), properties }
    }

    /// Returns the solid centred and rotated to its principal axes, with the smallest moment
    /// first, and the rotation matrix from the new axes to the old ones.
    ///
    /// If two moments agree to round-off, their axes are arbitrary.
    pub fn principal(&self) -> (Self, Matrix3) {
        let (_, axes) = principal_axes(&self.unit_inertia());
        let centered = self.centered();
        let vertices = centered.vertices.iter().map(|vertex| axes.tr_mul(vertex)).collect();
        let second = axes.transpose() * self.properties.second * axes;
        let properties =
            MassProperties { second: 0.5 * (second + second.transpose()), ..centered.properties };
        (Self { vertices, faces: centered.faces, properties }, axes)
    }

    /// Returns the corners of every triangle.
    fn triangles(&self) -> impl Iterator<Item = [Vector3; 3]> {
        self.faces.iter().map(|face| face.map(|index| self.vertices[index as usize]))
    }

    fn check_centered(&self) -> Result<(), super::FullBodyError> {
        centered(self.center(), self.radius())
    }
}
