//! The reasons for which vertices and faces are not the surface of a solid.

use thiserror::Error;

/// The reason for which vertices and faces are not the surface of a solid. Vertices and faces are
/// counted from 1.
#[derive(Clone, Debug, Error, PartialEq)]
pub enum ShapeError {
    /// A count is zero, or too large for the memory.
    #[error("{count} {name}; from 4 to {limit} are possible")]
    Count {
        /// "vertices" or "faces".
        name: &'static str,
        /// The number of items.
        count: usize,
        /// The largest possible number.
        limit: usize,
    },
    /// A coordinate is NaN, infinite, or so large that the fifth power of lengths leaves the range
    /// of numbers.
    #[error("vertex {vertex} has the coordinate {value} m; magnitudes up to {limit:e} are possible")]
    Coordinate {
        /// The number of the vertex.
        vertex: usize,
        /// The coordinate \[m\].
        value: f64,
        /// The largest magnitude \[m\].
        limit: f64,
    },
    /// A face names a vertex that does not exist.
    #[error("face {face} names vertex {vertex}, but there are {vertices}")]
    OutOfRange {
        /// The number of the face.
        face: usize,
        /// The vertex that the face names.
        vertex: usize,
        /// The number of vertices.
        vertices: usize,
    },
    /// A face names a vertex twice.
    #[error("face {face} names vertex {vertex} twice")]
    Repeated {
        /// The number of the face.
        face: usize,
        /// The vertex.
        vertex: usize,
    },
    /// An edge has a face on one side only.
    #[error(
        "the surface is not closed: no second face joins face {face} at the edge from vertex {from} to {to}"
    )]
    Open {
        /// The face.
        face: usize,
        /// The first vertex of the edge.
        from: usize,
        /// The last vertex of the edge.
        to: usize,
    },
    /// An edge has more than two faces.
    #[error(
        "the surface is not a manifold: {faces} faces, of which one is {face}, meet at the edge from vertex \
            {from} to {to}"
    )]
    NotManifold {
        /// One of the faces.
        face: usize,
        /// The number of its faces.
        faces: usize,
        /// The first vertex of the edge.
        from: usize,
        /// The last vertex of the edge.
        to: usize,
    },
    /// Two neighbours run along their edge in the same sense.
    #[error(
        "faces {face} and {other} both run from vertex {from} to {to}: one of them is turned over; outward \
         faces run counterclockwise seen from outside"
    )]
    Orientation {
        /// The first face.
        face: usize,
        /// The second face.
        other: usize,
        /// The first vertex of the edge.
        from: usize,
        /// The last vertex of the edge.
        to: usize,
    },
    /// All faces look inwards.
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
