//! Wavefront OBJ files: vertices and faces of one solid.
//!
//! The reader uses the elements `v x y z` (a weight or a colour after the coordinates is ignored)
//! and `f a b c …` with corners `v`, `v/vt`, `v//vn` or `v/vt/vn`; negative indices count from the
//! end. Polygons become fans of triangles. A line that ends in `\` continues on the next line.
//! Normals, textures, materials, curves, free-form surfaces and all other elements without faces
//! are ignored. All groups and objects form one solid. Vertices with equal coordinates become one
//! vertex, because some exporters split faces; faces that lose a corner by this are removed.

use super::{Polyhedron, ShapeError};
use crate::Vector3;
use crate::numerics::encoding;
use std::collections::HashMap;
use std::io::{BufRead, Read};
use thiserror::Error;

/// An error in an OBJ file, with its line.
#[derive(Clone, Debug, Error, PartialEq)]
#[error("line {line}: {problem}")]
pub struct ObjError {
    /// The line, from 1. For an error of the whole file it is the last line, or the line of the
    /// face.
    pub line: usize,
    /// The kind of the error.
    pub problem: ObjProblem,
}

/// The possible errors of an OBJ file.
#[derive(Clone, Debug, Error, PartialEq)]
pub enum ObjProblem {
    /// The file cannot be read.
    #[error("cannot be read: {0}")]
    Read(String),
    /// A line, including its continuation lines, is too long.
    #[error("the line is longer than {limit} bytes")]
    LineTooLong {
        /// The largest allowed number of bytes.
        limit: usize,
    },
    /// The file is encoded in UTF-16.
    #[error("the file is in UTF-16: save it as UTF-8")]
    Utf16,
    /// The file is too long.
    #[error("the file is longer than {limit} bytes")]
    FileTooLong {
        /// The largest allowed number of bytes.
        limit: u64,
    },
    /// A line starts with a word that is not a keyword of the format.
    #[error("`{0}` is not a keyword of a Wavefront OBJ file")]
    Keyword(String),
    /// A vertex has fewer than three coordinates or more than OBJ allows.
    #[error("a vertex has {0} numbers; three coordinates are needed, a weight or a color may follow")]
    Coordinates(usize),
    /// A coordinate is not a number, or not finite.
    #[error("`{0}` is not a finite number")]
    Number(String),
    /// A face has fewer than three corners.
    #[error("a face has {0} corners; at least 3 are needed")]
    Corners(usize),
    /// A corner of a face is not an index.
    #[error(
        "`{0}` is not the corner of a face: v, v/vt, v//vn or v/vt/vn, counted from 1, or from the end by −1"
    )]
    Corner(String),
    /// A negative index refers to a vertex before the first one.
    #[error("the corner {index} counts from the end, but only {vertices} vertices came before")]
    BeforeFirst {
        /// The negative index.
        index: i64,
        /// The number of vertices so far.
        vertices: usize,
    },
    /// The scale is not a positive number.
    #[error("the scale is {0}; it must be a positive number")]
    Scale(f64),
    /// The vertices and faces do not bound a solid.
    #[error(transparent)]
    Shape(ShapeError),
}

/// The keywords whose lines do not describe the solid.
const IGNORED: &str = "vn vt vp g o s mg usemtl mtllib usemap maplib l p lod bevel c_interp d_interp \
    shadow_obj trace_obj cstype deg bmat step curv curv2 surf parm trim hole scrv sp end con ctech stech bsp \
    bzp cdc cdp res call csh";

/// The largest length of a line, in bytes.
const LINE: usize = 1 << 16;
/// The largest size of a file, in bytes.
const FILE: u64 = 1 << 28;

/// Reads the solid of a Wavefront OBJ file. Its coordinates times `scale` are in \[m\].
///
/// [`Polyhedron::SIZE`] limits the memory. A file is limited to 256 MiB, and a line to 64 KiB.
///
/// # Errors
/// Returns an [`ObjError`] with the line and the reason.
pub fn read_obj(reader: impl BufRead, scale: f64) -> Result<Polyhedron, ObjError> {
    if !(scale > 0.0 && scale.is_finite()) {
        return Err(ObjError { line: 0, problem: ObjProblem::Scale(scale) });
    }
    let mut mesh = Mesh { scale, ..Mesh::default() };
    let mut lines = Lines { reader: reader.take(FILE + 1), number: 0 };
    let mut text = Vec::new();
    loop {
        let first = lines.number + 1;
        let more =
            lines.next(&mut text).map_err(|problem| ObjError { line: lines.number.max(1), problem })?;
        if !more {
            break;
        }
        if first == 1 {
            if encoding::is_utf16(&text) {
                return Err(ObjError { line: 1, problem: ObjProblem::Utf16 });
            }
            if text.starts_with(encoding::MARK) {
                text.drain(..encoding::MARK.len());
            }
        }
        mesh.line(&String::from_utf8_lossy(&text), first)
            .map_err(|problem| ObjError { line: first, problem })?;
    }
    mesh.solid(lines.number.max(1))
}

/// The logical lines of a file, with their continuation lines.
struct Lines<R> {
    reader: std::io::Take<R>,
    /// Number of lines read so far.
    number: usize,
}

impl<R: BufRead> Lines<R> {
    /// Reads the next line and its continuation lines into `text`. Returns false at the end of the
    /// file.
    fn next(&mut self, text: &mut Vec<u8>) -> Result<bool, ObjProblem> {
        text.clear();
        loop {
            let room = (LINE + 1 - text.len()) as u64;
            let count = self.reader.by_ref().take(room).read_until(b'\n', text);
            let count = count.map_err(|error| ObjProblem::Read(error.to_string()))?;
            self.number += usize::from(count > 0);
            if self.reader.limit() == 0 {
                return Err(ObjProblem::FileTooLong { limit: FILE });
            }
            if text.len() > LINE {
                return Err(ObjProblem::LineTooLong { limit: LINE });
            }
            // Blanks after the continuation sign are invisible to authors, so they are ignored.
            while text.last().is_some_and(u8::is_ascii_whitespace) {
                text.pop();
            }
            if count == 0 || text.last() != Some(&b'\\') {
                return Ok(count > 0 || !text.is_empty());
            }
            *text.last_mut().expect("it is a backslash") = b' ';
        }
    }
}

/// The vertices and faces that have been read so far.
#[derive(Default)]
struct Mesh {
    scale: f64,
    vertices: Vec<Vector3>,
    /// Triangles as indices of vertices. A face with more than three corners is split into several.
    faces: Vec<[u32; 3]>,
    /// For each triangle, its face and line in the file.
    origins: Vec<Origin>,
    /// Number of faces read so far.
    count: usize,
}

/// The face of the file that contains a triangle, and the line of the face, both counted from 1.
#[derive(Clone, Copy)]
struct Origin {
    face: usize,
    line: usize,
}

impl Mesh {
    fn line(&mut self, text: &str, line: usize) -> Result<(), ObjProblem> {
        let content = text.split('#').next().unwrap_or_default();
        let mut words = content.split_whitespace();
        match words.next() {
            None => Ok(()),
            Some("v") => self.vertex(words),
            // "fo" is an older keyword for a face.
            Some("f" | "fo") => self.face(words, line),
            Some(keyword) if IGNORED.split(' ').any(|ignored| ignored == keyword) => Ok(()),
            Some(keyword) => Err(ObjProblem::Keyword(shortened(keyword))),
        }
    }

    fn vertex<'a>(&mut self, words: impl Iterator<Item = &'a str>) -> Result<(), ObjProblem> {
        let number = |word: &str| match word.parse::<f64>() {
            Ok(value) if value.is_finite() => Ok(value),
            _ => Err(ObjProblem::Number(shortened(word))),
        };
        let numbers = words.map(number).collect::<Result<Vec<_>, _>>()?;
        match numbers[..] {
            [x, y, z] | [x, y, z, _] | [x, y, z, _, _, _] | [x, y, z, _, _, _, _] => {
                self.full("vertices", self.vertices.len())?;
                self.vertices.push(self.scale * Vector3::new(x, y, z));
                Ok(())
            }
            _ => Err(ObjProblem::Coordinates(numbers.len())),
        }
    }

    fn face<'a>(&mut self, words: impl Iterator<Item = &'a str>, line: usize) -> Result<(), ObjProblem> {
        let corners = words.map(|word| self.corner(word)).collect::<Result<Vec<_>, _>>()?;
        if corners.len() < 3 {
            return Err(ObjProblem::Corners(corners.len()));
        }
        self.count += 1;
        for pair in corners[1..].windows(2) {
            self.full("faces", self.faces.len())?;
            self.faces.push([corners[0], pair[0], pair[1]]);
            self.origins.push(Origin { face: self.count, line });
        }
        Ok(())
    }

    /// Returns the vertex index of a corner, from 0. A positive index may refer to a vertex that
    /// follows later in the file.
    fn corner(&self, word: &str) -> Result<u32, ObjProblem> {
        let wrong = || ObjProblem::Corner(shortened(word));
        let mut parts = word.split('/');
        let index: i64 = parts.next().unwrap_or_default().parse().map_err(|_| wrong())?;
        let rest: Vec<_> = parts.collect();
        let is_index = |text: &&str| text.parse::<i64>().is_ok_and(|index| index != 0);
        // v, v/vt, v//vn, v/vt/vn; some exporters write v/ and v//.
        let well_formed = rest.len() <= 2 && rest.iter().all(|part| part.is_empty() || is_index(part));
        if !well_formed || index == 0 {
            return Err(wrong());
        }
        let vertices = self.vertices.len();
        if index > 0 {
            return u32::try_from(index - 1).map_err(|_| wrong());
        }
        let from_end = usize::try_from(index.unsigned_abs()).ok().and_then(|back| vertices.checked_sub(back));
        from_end.map(|vertex| vertex as u32).ok_or(ObjProblem::BeforeFirst { index, vertices })
    }

    fn full(&self, name: &'static str, count: usize) -> Result<(), ObjProblem> {
        let limit = Polyhedron::SIZE;
        if count < limit {
            Ok(())
        } else {
            Err(ObjProblem::Shape(ShapeError::Count { name, count: count + 1, limit }))
        }
    }

    /// Builds the solid. Errors refer to the vertices and faces as they are numbered in the file,
    /// and have the line of the face.
    fn solid(mut self, last: usize) -> Result<Polyhedron, ObjError> {
        let at_face = |line, error| ObjError { line, problem: ObjProblem::Shape(error) };
        let count = self.vertices.len();
        for (face, &Origin { face: number, line }) in self.faces.iter().zip(&self.origins) {
            if let Some(&vertex) = face.iter().find(|&&vertex| vertex as usize >= count) {
                let vertex = vertex as usize + 1;
                let error = ShapeError::OutOfRange { face: number, vertex, vertices: count };
                return Err(at_face(line, error));
            }
            let [a, b, c] = *face;
            if a == b || b == c || c == a {
                let vertex = if b == c { b } else { a } as usize + 1;
                return Err(at_face(line, ShapeError::Repeated { face: number, vertex }));
            }
        }
        let places = self.merge();
        let (vertices, faces, origins) = (self.vertices, self.faces, self.origins);
        Polyhedron::new(vertices, faces).map_err(|error| {
            let (line, error) = in_file(error, &places, &origins);
            at_face(line.unwrap_or(last), error)
        })
    }

    /// Merges vertices with equal coordinates, and removes vertices without a face and faces
    /// without three different corners. Returns the number in the file of every remaining vertex.
    fn merge(&mut self) -> Vec<usize> {
        let mut first_at = HashMap::new();
        let (mut vertices, mut places) = (Vec::new(), Vec::new());
        for face in &mut self.faces {
            for corner in face {
                let vertex = self.vertices[*corner as usize];
                // Adding zero makes −0 and 0 the same place.
                let key = [0, 1, 2].map(|axis| (vertex[axis] + 0.0).to_bits());
                *corner = *first_at.entry(key).or_insert_with(|| {
                    vertices.push(vertex);
                    places.push(*corner as usize + 1);
                    vertices.len() as u32 - 1
                });
            }
        }
        let has_corners = |[a, b, c]: &[u32; 3]| a != b && b != c && c != a;
        let kept: Vec<bool> = self.faces.iter().map(has_corners).collect();
        let mut keep = kept.iter();
        self.faces.retain(|_| *keep.next().unwrap_or(&true));
        let mut keep = kept.iter();
        self.origins.retain(|_| *keep.next().unwrap_or(&true));
        self.vertices = vertices;
        places
    }
}

/// Returns the line of an error, and the error with the vertex and face numbers of the file.
fn in_file(error: ShapeError, places: &[usize], origins: &[Origin]) -> (Option<usize>, ShapeError) {
    use ShapeError::{Coordinate, NotManifold, Open, Orientation};
    let place = |vertex: usize| places[vertex - 1];
    let of = |triangle: usize| origins[triangle - 1];
    match error {
        Open { face, from, to } => {
            let Origin { face, line } = of(face);
            (Some(line), Open { face, from: place(from), to: place(to) })
        }
        NotManifold { face, faces, from, to } => {
            let Origin { face, line } = of(face);
            (Some(line), NotManifold { face, faces, from: place(from), to: place(to) })
        }
        Orientation { face, other, from, to } => {
            let Origin { face, line } = of(face);
            let other = of(other).face;
            (Some(line), Orientation { face, other, from: place(from), to: place(to) })
        }
        Coordinate { vertex, value, limit } => (None, Coordinate { vertex: place(vertex), value, limit }),
        other => (None, other),
    }
}

/// Returns at most the first 40 characters of a word, for a message.
fn shortened(word: &str) -> String {
    let mut short: String =
        word.chars().take(40).map(|c| if c.is_control() { '\u{fffd}' } else { c }).collect();
    if short.chars().count() < word.chars().count() {
        short.push('…');
    }
    short
}
