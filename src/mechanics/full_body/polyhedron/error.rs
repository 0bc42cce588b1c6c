//! The reasons why vertices and faces do not bound a solid.

use thiserror::Error;

/// The reason why vertices and faces do not bound a solid. Vertices and faces are counted from 1.
#[derive(Clone, Debug, Error, PartialEq)]
pub enum ShapeError {
    /// The number of vertices or faces is too small, or too large for the memory.
    #[error("{count} {name}; from 4 to {limit} are possible")]
    Count {
        /// "vertices" or "faces".
        name: &'static str,
        /// The number of items.
        count: usize,
        /// The largest possible number.
        limit: usize,
    },
    /// A coordinate is NaN, infinite, or so large that the fifth power of a length overflows.
    #[error("vertex {vertex} has the coordinate {value} m; magnitudes up to {limit:e} are possible")]
    Coordinate {
        /// The number of the vertex, from 1.
        vertex: usize,
        /// The coordinate \[m\].
        value: f64,
        /// The largest allowed magnitude \[m\].
        limit: f64,
    },
    /// A face names a vertex that does not exist.
    #[error("face {face} names vertex {vertex}, but there are {vertices}")]
    OutOfRange {
        /// The number of the face, from 1.
        face: usize,
        /// The number of the missing vertex.
        vertex: usize,
        /// The number of vertices that exist.
        vertices: usize,
    },
    /// A face names a vertex twice.
    #[error("face {face} names vertex {vertex} twice")]
    Repeated {
        /// The number of the face.
        face: usize,
        /// The number of the repeated vertex.
        vertex: usize,
    },
    /// An edge belongs to one face only, so that the surface is not closed.
    #[error(
        "the surface is not closed: no second face joins face {face} at the edge from vertex {from} to {to}"
    )]
    Open {
        /// The number of the face.
        face: usize,
        /// The first vertex of the edge.
        from: usize,
        /// The last vertex of the edge.
        to: usize,
    },
    /// An edge belongs to more than two faces.
    #[error(
        "the surface is not a manifold: {faces} faces, of which one is {face}, meet at the edge from vertex \
            {from} to {to}"
    )]
    NotManifold {
        /// The number of one of the faces, from 1.
        face: usize,
        /// The number of faces that meet at the edge.
        faces: usize,
        /// The first vertex of the edge.
        from: usize,
        /// The last vertex of the edge.
        to: usize,
    },
    /// Two neighbouring faces traverse their common edge in the same direction.
    #[error(
        "faces {face} and {other} both run from vertex {from} to {to}: one of them is turned over; outward \
         faces run counterclockwise seen from outside"
    )]
    Orientation {
        /// The number of the first face.
        face: usize,
        /// The number of the second face.
        other: usize,
        /// The first vertex of the edge.
        from: usize,
        /// The last vertex of the edge.
        to: usize,
    },
    /// The normals of all faces point inwards.
    #[error(
        "the faces look inwards (volume {volume} m³): turn the order of the vertices of all faces over, or \
         export the shape with outward normals"
    )]
    Inverted {
        /// The negative volume \[m³\].
        volume: f64,
    },
    /// The volume is zero to round-off.
    #[error("the solid has no volume: {volume} m³ within a surface of {area} m²")]
    NoVolume {
        /// The volume \[m³\].
        volume: f64,
        /// The area of the surface \[m²\].
        area: f64,
    },
}
