//! Reading of `[bodies.shape]`: the shape of a body, which determines its mass, inertia and
//! gravity.

use super::{Section, Solid, cut, short};
use slewkit::Matrix3;
use slewkit::mechanics::full_body::polyhedron::read_obj;
use slewkit::mechanics::full_body::{
    Attractor, Dumbbell, FullBodyError, HomogeneousPolyhedron, MassPoint, PointCloud, Polyhedron,
};
use std::fs::File;
use std::io::{BufReader, Read};
use std::path::{Component, Path, PathBuf};

/// Largest total number of faces of all shapes of a spec.
pub(crate) const MAX_FACES: usize = 200_000;
/// Largest total number of points and Gauss points of all shapes of a spec.
pub(crate) const MAX_POINTS: usize = 2_000_000;

/// Largest total size of all OBJ files of a spec \[bytes\]. Reading files of this size takes
/// seconds.
pub(crate) const MAX_BYTES: u64 = 128 << 20;

/// Default order of the Gauss quadrature in each direction of a tetrahedron.
const GAUSS_ORDER: usize = 3;

/// Unused part of the limits on the total size of all shapes of a spec.
#[derive(Clone, Debug)]
pub(crate) struct Budget {
    faces: usize,
    points: usize,
    /// Number of bytes of OBJ files that may still be read.
    bytes: u64,
    /// Paths of the files that have been read.
    pub files: Vec<PathBuf>,
}

impl Budget {
    pub fn new() -> Self {
        Self { faces: MAX_FACES, points: MAX_POINTS, bytes: MAX_BYTES, files: Vec::new() }
    }

    /// Subtracts the size of a shape from the unused part of the limits. If the shape is too large,
    /// reports an error and returns false.
    fn take(&mut self, section: &Section, faces: usize, points: usize) -> bool {
        if let (Some(faces), Some(points)) = (self.faces.checked_sub(faces), self.points.checked_sub(points))
        {
            (self.faces, self.points) = (faces, points);
            return true;
        }
        let reason = format!(
            "the shape has {faces} faces and {points} points; all bodies together may have {MAX_FACES} \
            faces and {MAX_POINTS} points, and {} and {} remain",
            self.faces, self.points
        );
        section.error_here("E0034", reason, "use a coarser shape, or a lower gauss_order");
        false
    }

    /// Subtracts the size of an OBJ file from the number of bytes that may still be read. If the
    /// file is too large, reports an error and returns false. It is called before the file is read.
    fn take_file(&mut self, section: &Section, size: u64) -> bool {
        if let Some(bytes) = self.bytes.checked_sub(size) {
            self.bytes = bytes;
            return true;
        }
        let megabytes = |bytes: u64| short(bytes as f64 / f64::from(1 << 20));
        let [size, most, left] = [size, MAX_BYTES, self.bytes].map(megabytes);
        let reason =
            format!("the file has {size} MiB; all OBJ files together may have {most} MiB, and {left} remain");
        section.error("E0034", "obj", reason, "use a coarser shape");
        false
    }
}

/// Shape of a body with its mass properties.
#[derive(Clone, Debug)]
pub(crate) struct Shape {
    /// Mass of the body \[kg\].
    pub mass: f64,
    /// Inertia about the center of mass in body axes \[kg·m²\]. It is singular if all points lie on
    /// a line.
    pub inertia: Matrix3,
    /// Gravity field of the body.
    pub attractor: Attractor,
    /// The dumbbell, whose gravity has a closed form; `None` for other shapes.
    pub dumbbell: Option<Dumbbell>,
    /// Distance of the farthest point of the body from its center of mass \[m\].
    pub reach: f64,
    /// Solid of the shape; `None` if the shape has no faces.
    pub solid: Option<Solid>,
}

/// Reads the shape of a body. `mass` is the value of `mass_kg`, if the spec gives it. Returns
/// `None` if an error was reported.
pub(crate) fn shape(body: &Section, mass: Option<f64>, folder: &Path, budget: &mut Budget) -> Option<Shape> {
    let section = body.section("shape")?;
    let kind = section.word("kind")?;
    let density = section.number("density_kg_m3");
    let solid = kind != "dumbbell" && kind != "points";
    let given_twice =
        if kind == "points" { body.has("mass_kg") } else { body.has("mass_kg") && density.is_some() };
    if given_twice {
        let other = if kind == "points" { "the masses of the points" } else { "`density_kg_m3`" };
        let reason = format!("the mass is given twice, by `mass_kg` and by {other}");
        return body.refuse("E0028", "mass_kg", reason, "remove mass_kg");
    }
    let known = kind == "points" || body.has("mass_kg") || (solid && section.has("density_kg_m3"));
    if !known {
        let reason = format!("[{}] needs `mass_kg`: the shape does not determine the mass", body.path);
        let remedy = if solid {
            "add mass_kg = 1 to it, or density_kg_m3 = 2000 to its shape"
        } else {
            "add mass_kg = 1"
        };
        return body.refuse_here("E0021", reason, remedy);
    }
    match kind {
        "sphere" => sphere(section, mass, density),
        "dumbbell" => {
            let (length, sphere_radius) = (section.number("length_m")?, section.number("sphere_radius_m")?);
            let dumbbell = Dumbbell { mass: mass?, length, sphere_radius };
            if length < 2.0 * sphere_radius {
                let reason = format!(
                    "the spheres overlap: their centers are {} m apart, but the sum of their radii is {} \
                    m, and the inertia counts the common part twice",
                    short(length),
                    short(2.0 * sphere_radius)
                );
                let remedy = "lengthen `length_m`, or give the body its own `inertia_kg_m2`";
                section.warn("W0136", "sphere_radius_m", reason, remedy);
            }
            let attractor = Attractor::Cloud(accept(dumbbell.cloud(), section)?);
            let (inertia, reach) = (dumbbell.inertia(), 0.5 * length + sphere_radius);
            let dumbbell = Some(dumbbell);
            Some(Shape { mass: mass?, inertia, attractor, dumbbell, reach, solid: None })
        }
        "points" => points(section, budget),
        _ => {
            let lengths = |name: &str| ("E0088", section.spot(name), "give three positive lengths");
            let solid = match kind {
                "cuboid" => {
                    let made = Polyhedron::cuboid(&section.vector("edges_m")?);
                    section.report.accept(made, |_| lengths("edges_m"))
                }
                "octahedron" => {
                    let made = Polyhedron::octahedron(&section.vector("semi_axes_m")?);
                    section.report.accept(made, |_| lengths("semi_axes_m"))
                }
                _ if section.has("obj") && (section.has("vertices_m") || section.has("faces")) => None,
                _ if section.has("obj") => from_obj(section, folder, budget),
                _ => listed(section),
            }?;
            homogeneous(&solid, section, mass, density, budget)
        }
    }
}

fn sphere(section: &Section, mass: Option<f64>, density: Option<f64>) -> Option<Shape> {
    let radius = section.number("radius_m")?;
    let volume = 4.0 / 3.0 * std::f64::consts::PI * radius.powi(3);
    let mass = mass.or(density.map(|density| density * volume))?;
    let attractor = accept(Attractor::point(mass), section)?;
    let inertia = Matrix3::identity() * (0.4 * mass * radius * radius);
    Some(Shape { mass, inertia, attractor, dumbbell: None, reach: radius, solid: None })
}

fn points(section: &Section, budget: &mut Budget) -> Option<Shape> {
    let list = section.list("points");
    if list.is_empty() {
        let reason = "kind = \"points\" needs at least one point";
        let remedy = "add points = [ { mass_kg = 0.5, position_m = [0.15, 0, 0] }, … ]";
        return section.refuse("E0021", "points", reason, remedy);
    }
    if !budget.take(section, 0, list.len()) {
        return None;
    }
    let point = |point: &Section| {
        Some(MassPoint { mass: point.number("mass_kg")?, position: point.vector("position_m")? })
    };
    let points: Option<Vec<_>> = list.iter().map(point).collect();
    let (cloud, _) = accept(PointCloud::centered(points?), section)?;
    let (mass, inertia, reach) = (cloud.mass(), cloud.inertia(), cloud.radius());
    Some(Shape { mass, inertia, attractor: Attractor::Cloud(cloud), dumbbell: None, reach, solid: None })
}

/// Returns the shape of a homogeneous solid, translated so that its center of mass is the origin.
fn homogeneous(
    solid: &Polyhedron,
    section: &Section,
    mass: Option<f64>,
    density: Option<f64>,
    budget: &mut Budget,
) -> Option<Shape> {
    let order = section.count("gauss_order").unwrap_or(GAUSS_ORDER);
    let faces = solid.faces().len();
    if !budget.take(section, faces, faces * order.pow(3)) {
        return None;
    }
    let written = Solid { faces, volume: solid.volume(), mass_center: *solid.center() };
    let solid = solid.centered();
    let body = match (mass, density) {
        (Some(mass), _) => HomogeneousPolyhedron::with_mass(solid, mass, order),
        (None, density) => HomogeneousPolyhedron::new(solid, density?, order),
    };
    let body = accept(body, section)?;
    let (mass, inertia, reach) = (body.mass(), body.inertia(), body.shape().radius());
    let attractor = Attractor::Polyhedron(body);
    Some(Shape { mass, inertia, attractor, dumbbell: None, reach, solid: Some(written) })
}

/// Reads a solid whose vertices and faces are listed in the spec.
fn listed(section: &Section) -> Option<Polyhedron> {
    if !section.has("vertices_m") {
        // The first pass has reported that the shape is missing.
        return None;
    }
    if !section.has("faces") {
        let reason = "`vertices_m` needs `faces`";
        let remedy =
            "add faces = [[1, 2, 3], …]: vertices counted from 1, counterclockwise seen from outside";
        return section.refuse("E0021", "vertices_m", reason, remedy);
    }
    let (vertices, faces) = (section.vectors("vertices_m")?, section.faces("faces")?);
    // The first pass has checked that vertex numbers are at least 1.
    let faces = faces.into_iter().map(|face| face.map(|corner| corner.saturating_sub(1))).collect();
    let remedy = "check the faces: closed, each edge in two of them, counterclockwise seen from outside";
    section.report.accept(Polyhedron::new(vertices, faces), |_| ("E0088", section.spot("faces"), remedy))
}

fn from_obj(section: &Section, folder: &Path, budget: &mut Budget) -> Option<Polyhedron> {
    let written = section.word("obj")?;
    let (path, file) = match open(written, folder, "a Wavefront OBJ file") {
        Ok(opened) => opened,
        Err((code, reason, remedy)) => return section.refuse(code, "obj", reason, remedy),
    };
    let size = file.metadata().map_or(u64::MAX, |metadata| metadata.len());
    if !budget.take_file(section, size) {
        return None;
    }
    budget.files.push(path.clone());
    let unit = section.number("obj_unit_m");
    if unit.is_none() && section.has("obj_unit_m") {
        return None;
    }
    let read = read_obj(BufReader::new(file.take(size)), unit.unwrap_or(1.0));
    let read = read.map_err(|error| format!("{}: {error}", cut(&path.to_string_lossy(), 200)));
    let remedy = "repair the file, or export the shape again as a closed surface";
    section.report.accept(read, |_| ("E0089", section.spot("obj"), remedy))
}

/// Opens a file that a spec refers to. It must be in the folder of the spec or in a subfolder.
pub(super) fn open(
    written: &str,
    folder: &Path,
    what: &str,
) -> Result<(PathBuf, File), (&'static str, String, String)> {
    let relative = Path::new(written);
    let inside = relative.components().all(|part| matches!(part, Component::Normal(_) | Component::CurDir));
    let path = folder.join(relative);
    let shown = cut(&path.to_string_lossy(), 200);
    let escapes = |how: &str| {
        let reason = format!("\"{}\" leads {how} the folder of the spec", cut(written, 100));
        ("E0091", reason, "put the file into the folder of the spec, or into a folder below".into())
    };
    if !inside {
        return Err(escapes("out of"));
    }
    let missing = |error: std::io::Error| {
        let reason = format!("\"{}\" cannot be read, as {shown}: {}", cut(written, 100), error.kind());
        ("E0090", reason, "the path is relative to the folder of the spec: check it".into())
    };
    let here = if folder.as_os_str().is_empty() { Path::new(".") } else { folder };
    let (root, real) = (here.canonicalize().map_err(missing)?, path.canonicalize().map_err(missing)?);
    if !real.starts_with(&root) {
        return Err(escapes("through a link out of"));
    }
    if !real.metadata().map_err(missing)?.is_file() {
        let reason = format!("\"{}\" is not a file", cut(written, 100));
        return Err(("E0090", reason, format!("name {what}")));
    }
    let file = File::open(&real).map_err(missing)?;
    Ok((path, file))
}

/// Returns the shape `made`, or reports the error of its numbers and returns `None`.
fn accept<T>(made: Result<T, FullBodyError>, section: &Section) -> Option<T> {
    section.report.accept(made, |_| ("E0086", section.here(), "check the numbers of the shape"))
}
