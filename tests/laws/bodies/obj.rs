//! Wavefront OBJ files, good and bad.

use crate::evidence::Random;
use slewkit::mechanics::full_body::Polyhedron;
use slewkit::mechanics::full_body::polyhedron::{ObjError, read_obj};

fn read(text: &str) -> Result<Polyhedron, ObjError> {
    read_obj(text.as_bytes(), 1.0)
}

/// A pyramid on a square, in every form that faces have.
const PYRAMID: &str = "\
# a pyramid
mtllib none.mtl
o pyramid
v  1  1  0
v -1  1  0 1.0
v -1 -1  0 0.5 0.5 0.5
v  1 -1  0
v 0 0 \\
  1.5
vt 0 0
vn 0 0 1
g sides
s off
f 1 2 5
f 2/1 3/1 5/1
f 3//1 4//1 5//1
f -2/1/1 -5/1/1 -1/1/1   # 4 1 5
usemtl base
f 4 3 2 1
";

#[test]
fn a_pyramid_in_every_form() {
    for text in [PYRAMID.to_string(), PYRAMID.replace('\n', "\r\n"), PYRAMID.trim_end().to_string()] {
        let shape = read(&text).unwrap();
        assert_eq!((shape.vertices().len(), shape.faces().len()), (5, 6));
        assert!((shape.volume() - 2.0).abs() < 1e-15);
        assert!((shape.center().z - 0.375).abs() < 1e-15);
    }
    let kilometers = read_obj(PYRAMID.as_bytes(), 1000.0).unwrap();
    assert!((kilometers.volume() / 2e9 - 1.0).abs() < 1e-15);
}

#[test]
fn vertices_at_one_place_are_one() {
    // Every face has its own corners; one of them is written twice at the tip.
    let corners = ["1 1 0", "-1 1 0", "-1 -1 0", "1 -1 -0", "0 0 1.5"];
    let mut text = String::new();
    for face in [&[0, 1, 4, 4][..], &[1, 2, 4], &[2, 3, 4], &[3, 0, 4], &[3, 2, 1, 0]] {
        face.iter().for_each(|&corner: &usize| text += &format!("v {}\n", corners[corner]));
        let indices: Vec<_> = (1..=face.len()).rev().map(|back| format!("-{back}")).collect();
        text += &format!("f {}\n", indices.join(" "));
    }
    let shape = read(&text).unwrap();
    assert_eq!((shape.vertices().len(), shape.faces().len()), (5, 6));
    assert!((shape.volume() - 2.0).abs() < 1e-15);
}

#[test]
fn mistakes_have_a_line_and_a_reason() {
    let edit = |from: &str, to: &str| {
        assert!(PYRAMID.contains(from));
        PYRAMID.replacen(from, to, 1)
    };
    let cases = [
        (edit("v -1  1  0 1.0", "v -1 1"), "line 5: a vertex has 2 numbers; three coordinates are needed"),
        (edit("-1  1  0 1.0", "-1 x 0"), "line 5: `x` is not a finite number"),
        (edit("-1  1  0 1.0", "-1 nan 0"), "line 5: `nan` is not a finite number"),
        (edit("-1  1  0 1.0", "-1 1e999 0"), "line 5: `1e999` is not a finite number"),
        (edit("-1  1  0 1.0", "-1 1e40 0"), "line 19: vertex 2 has the coordinate 1"),
        (edit("g sides", "polygon 3"), "line 12: `polygon` is not a keyword of a Wavefront OBJ file"),
        (edit("f 1 2 5", "f 1 2"), "line 14: a face has 2 corners"),
        (edit("f 1 2 5", "f 1 2 0"), "line 14: `0` is not the corner of a face"),
        (edit("f 1 2 5", "f 1 2 5/x"), "line 14: `5/x` is not the corner of a face"),
        (edit("f 1 2 5", "f 1 2 5/1/1/1"), "line 14: `5/1/1/1` is not the corner of a face"),
        (edit("f 1 2 5", "f 1 2 99999999999999999999"), "line 14: `99999999999999999999` is not the corner"),
        (edit("f 1 2 5", "f 1 2 9"), "line 14: face 1 names vertex 9, but there are 5"),
        (edit("f 1 2 5", "f 1 2 -6"), "line 14: the corner -6 counts from the end, but only 5 vertices"),
        (edit("f 1 2 5", "f 1 2 2"), "line 14: face 1 names vertex 2 twice"),
        (edit("f 1 2 5", "f 2 1 5"), "line 14: faces 1 and"),
        (edit("f 1 2 5", "f 1 2 5\nf 1 2 5"), "line 14: the surface is not a manifold"),
        (edit("f 4 3 2 1", ""), "line 14: the surface is not closed"),
        (String::new(), "line 1: 0 vertices; from 4 to 1000000 are possible"),
        ("\u{0}\u{1}binary".into(), "line 1: `\u{fffd}\u{fffd}binary` is not a keyword"),
    ];
    for (text, expected) in cases {
        let message = read(&text).unwrap_err().to_string();
        assert!(message.starts_with(expected), "{message}\n{expected}");
    }
    let inverted: String = PYRAMID
        .lines()
        .map(|line| match line.split('#').next().unwrap().strip_prefix("f ") {
            Some(corners) => {
                format!("f {}\n", corners.split_whitespace().rev().collect::<Vec<_>>().join(" "))
            }
            None => format!("{line}\n"),
        })
        .collect();
    let message = read(&inverted).unwrap_err().to_string();
    assert!(message.contains("the faces look inwards (volume -2"), "{message}");
    for scale in [0.0, -1.0, f64::NAN, f64::INFINITY] {
        assert!(read_obj(PYRAMID.as_bytes(), scale).unwrap_err().to_string().contains("the scale is"));
    }
}

#[test]
fn endless_input_ends() {
    /// Comments without end.
    struct Comments;
    impl std::io::Read for Comments {
        fn read(&mut self, buffer: &mut [u8]) -> std::io::Result<usize> {
            buffer.fill(b'#');
            buffer[buffer.len() - 1] = b'\n';
            Ok(buffer.len())
        }
    }
    let spaces = std::io::BufReader::new(std::io::repeat(b' '));
    let message = read_obj(spaces, 1.0).unwrap_err().to_string();
    assert_eq!(message, "line 1: the line is longer than 65536 bytes");
    let message = read_obj(std::io::BufReader::new(Comments), 1.0).unwrap_err().to_string();
    assert!(message.ends_with("the file is longer than 268435456 bytes"), "{message}");
    // A continued line is as long as its parts and a space for every backslash.
    let continued = "\\\n".repeat(70_000);
    assert!(read(&continued).unwrap_err().to_string().ends_with("the line is longer than 65536 bytes"));
}

#[test]
fn damaged_files_are_errors_or_solids() {
    let mut random = Random::new(31);
    let mut solids = 0;
    for _ in 0..20_000 {
        let mut bytes = PYRAMID.as_bytes().to_vec();
        for _ in 0..1 + random.bits() % 3 {
            let at = (random.bits() % bytes.len() as u64) as usize;
            match random.bits() % 3 {
                0 => bytes[at] = (random.bits() % 256) as u8,
                1 => drop(bytes.remove(at)),
                _ => bytes.insert(at, b"0123456789-/. \nvf\\"[(random.bits() % 18) as usize]),
            }
        }
        if let Ok(shape) = read_obj(bytes.as_slice(), 1.0) {
            assert!(shape.volume() > 0.0 && shape.volume().is_finite());
            assert!(shape.unit_inertia().iter().all(|value| value.is_finite()));
            solids += 1;
        }
    }
    assert!(solids > 1000, "{solids}");
}
