//! Equal point masses on a cubic lattice inside a polyhedron.

use super::{HomogeneousPolyhedron, Polyhedron};
use crate::Vector3;
use crate::mechanics::full_body::error::{Checked, count};
use crate::mechanics::full_body::{MassPoint, PointCloud};
use crate::mechanics::number::positive;

impl HomogeneousPolyhedron {
    /// Returns a cloud of equal masses with the total mass of the solid. The masses are at the
    /// centres, inside of the solid, of the cubes of edge `spacing` \[m\]; the cloud is shifted so
    /// that its mass centre is the origin.
    ///
    /// All masses are positive for any shape, but the errors of inertia and field fall at best as
    /// the square of the spacing. [`Polyhedron::cubature`] is much more accurate unless the other
    /// body is very close.
    ///
    /// # Errors
    /// Returns a [`FullBodyError`](crate::mechanics::full_body::FullBodyError) if the spacing is
    /// not a positive number, or if no centre or more than [`PointCloud::POINTS`] centres are
    /// inside.
    pub fn lattice(&self, spacing: f64) -> Checked<PointCloud> {
        positive("spacing of the lattice", spacing)?;
        let cells = self.shape().volume() / spacing.powi(3);
        // Counts far outside of the limits are reported before the points are enumerated.
        let limit = PointCloud::POINTS;
        count("points of a lattice", (cells.min(1e18) as usize).max(1), limit)?;
        let columns = [0, 1].map(|axis| rows(self.shape(), axis, spacing).count());
        count("columns of a lattice", columns[0].saturating_mul(columns[1]), limit)?;
        let centers = self.shape().lattice_points(spacing);
        count("points of a lattice", centers.len(), limit)?;
        let mass = self.mass() / centers.len() as f64;
        let points = centers.into_iter().map(|position| MassPoint { mass, position }).collect();
        Ok(PointCloud::centered(points)?.0)
    }
}

impl Polyhedron {
    /// Returns the centres of the cubes that are inside of the solid, for a lattice centred at the
    /// origin. Columns along z are filled between crossings of the surface.
    fn lattice_points(&self, spacing: f64) -> Vec<Vector3> {
        let at = |index: i64| (index as f64 + 0.5) * spacing;
        let mut points = Vec::new();
        for i in rows(self, 0, spacing) {
            let slab: Vec<_> = self.triangles().filter(|corners| spans(corners, 0, at(i))).collect();
            for j in rows(self, 1, spacing) {
                let (x, y) = (at(i), at(j));
                let mut crossings: Vec<_> =
                    slab.iter().filter_map(|corners| crossing(corners, x, y)).collect();
                crossings.sort_by(|a, b| a.0.total_cmp(&b.0));
                let mut depth = 0;
                for pair in crossings.windows(2) {
                    depth += pair[0].1;
                    let first = (pair[0].0 / spacing - 0.5).ceil() as i64;
                    let last = (pair[1].0 / spacing - 0.5).ceil() as i64;
                    if depth > 0 && points.len() <= PointCloud::POINTS {
                        points.extend((first..last).map(|k| Vector3::new(x, y, at(k))));
                    }
                }
            }
        }
        points
    }
}

/// Returns the indices of the rows of cubes that the solid reaches along an axis.
fn rows(shape: &Polyhedron, axis: usize, spacing: f64) -> impl Iterator<Item = i64> + Clone {
    let values = shape.vertices().iter().map(move |vertex| vertex[axis]);
    let (low, high) = values.fold((f64::MAX, f64::MIN), |(low, high), x| (low.min(x), high.max(x)));
    // Beyond these indices there are too many points in any case.
    let index = |x: f64| (x / spacing).clamp(-1e8, 1e8) as i64;
    (index(low) - 1)..=(index(high) + 1)
}

/// Returns whether the corners are on both sides of `value` along an axis. A corner at `value`
/// counts as below it.
fn spans(corners: &[Vector3; 3], axis: usize, value: f64) -> bool {
    let beyond = corners.map(|corner| corner[axis] > value);
    beyond.contains(&true) && beyond.contains(&false)
}

/// Returns the height at which the line along z at (x, y) crosses the triangle, with +1 if the line
/// enters the solid, or −1 if it leaves. Returns `None` if the line misses the triangle.
///
/// On which side of an edge the line passes is computed from the ends of the edge in a fixed order,
/// so that the two faces of an edge agree, and no line slips between them.
fn crossing(corners: &[Vector3; 3], x: f64, y: f64) -> Option<(f64, i32)> {
    let mut inside = false;
    for k in 0..3 {
        let (mut a, mut b) = (corners[k], corners[(k + 1) % 3]);
        if (a.x > x) != (b.x > x) {
            if (a.x, a.y) > (b.x, b.y) {
                std::mem::swap(&mut a, &mut b);
            }
            inside ^= a.y + (x - a.x) / (b.x - a.x) * (b.y - a.y) > y;
        }
    }
    let normal = (corners[1] - corners[0]).cross(&(corners[2] - corners[0]));
    let height = corners[0].z - (normal.x * (x - corners[0].x) + normal.y * (y - corners[0].y)) / normal.z;
    (inside && height.is_finite()).then_some((height, if normal.z < 0.0 { 1 } else { -1 }))
}
