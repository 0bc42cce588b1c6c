//! Checks that triangles form a closed surface, with two faces at every edge.

use super::{Polyhedron, ShapeError};
use crate::Vector3;

/// One side of an edge: the edge in the direction in which the face on this side traverses it.
#[derive(Clone, Copy, Debug)]
pub(super) struct HalfEdge {
    pub from: u32,
    pub to: u32,
    pub face: usize,
}

impl HalfEdge {
    fn ends(&self) -> (u32, u32) {
        (self.from.min(self.to), self.from.max(self.to))
    }
}

/// Returns both sides of all edges, with the two sides of an edge next to each other.
pub(super) fn half_edges(faces: &[[u32; 3]]) -> Vec<HalfEdge> {
    let of = |(face, &[a, b, c]): (usize, &[u32; 3])| {
        [(a, b), (b, c), (c, a)].map(|(from, to)| HalfEdge { from, to, face })
    };
    let mut edges: Vec<_> = faces.iter().enumerate().flat_map(of).collect();
    edges.sort_unstable_by_key(|edge| (edge.ends(), edge.face));
    edges
}

/// Checks that numbers are in range, that each face names three different vertices, and that every
/// edge has two faces which traverse it in opposite directions.
pub(super) fn check(vertices: &[Vector3], faces: &[[u32; 3]]) -> Result<(), ShapeError> {
    let limit = Polyhedron::SIZE;
    for (name, count) in [("vertices", vertices.len()), ("faces", faces.len())] {
        if !(4..=limit).contains(&count) {
            return Err(ShapeError::Count { name, count, limit });
        }
    }
    for (index, vertex) in vertices.iter().enumerate() {
        let limit = Polyhedron::COORDINATE;
        if let Some(&value) = vertex.iter().find(|value| value.is_nan() || value.abs() > limit) {
            return Err(ShapeError::Coordinate { vertex: index + 1, value, limit });
        }
    }
    for (index, face) in faces.iter().enumerate() {
        let (face_number, count) = (index + 1, vertices.len());
        if let Some(&vertex) = face.iter().find(|&&vertex| vertex as usize >= count) {
            let vertex = vertex as usize + 1;
            return Err(ShapeError::OutOfRange { face: face_number, vertex, vertices: count });
        }
        let [a, b, c] = *face;
        if a == b || b == c || c == a {
            let vertex = if a == b || c == a { a } else { b } as usize + 1;
            return Err(ShapeError::Repeated { face: face_number, vertex });
        }
    }
    check_edges(&half_edges(faces))
}

fn check_edges(edges: &[HalfEdge]) -> Result<(), ShapeError> {
    for sides in edges.chunk_by(|a, b| a.ends() == b.ends()) {
        let first = sides[0];
        let (face, from, to) = (first.face + 1, first.from as usize + 1, first.to as usize + 1);
        match sides {
            [_] => return Err(ShapeError::Open { face, from, to }),
            [_, second] if second.from == first.from => {
                return Err(ShapeError::Orientation { face, other: second.face + 1, from, to });
            }
            [_, _] => {}
            more => return Err(ShapeError::NotManifold { face, faces: more.len(), from, to }),
        }
    }
    Ok(())
}
