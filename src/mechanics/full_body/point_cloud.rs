//! A rigid cloud of point masses. It approximates any shape, and represents a dumbbell exactly.
//!
//! At a point `y` in body axes, per unit of mass at this point and with G = 1,
//! ```text
//! s = Σ_p m_p/|d_p|³     v = Σ_p m_p ρ_p/|d_p|³     d_p = y − ρ_p
//! g = v − s y            moment on the cloud: −Σ_p ρ_p × g_p = v × y
//! ```
//! Four running sums give force and reaction, and `v × y + y × g = 0` then holds exactly. Because
//! `v` has the arms `ρ` as factors, the moment has an error of `|y|/|ρ|` ulps (`−y × g` would have
//! an error of `(|y|/|ρ|)²` ulps).

use super::error::{Checked, centered, count};
use super::lanes::{LANES, Lanes};
use crate::mechanics::number::{finite, finite_vector, positive};
use crate::{Matrix3, Vector3};

/// A point mass of a rigid body.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct MassPoint {
    /// Mass \[kg\].
    pub mass: f64,
    /// Position `ρ` from the mass centre of the body, body axes \[m\].
    pub position: Vector3,
}

/// Point masses that move as one rigid body.
#[derive(Clone, Debug, PartialEq)]
pub struct PointCloud {
    points: Vec<MassPoint>,
    blocks: Vec<Block>,
    mass: f64,
    radius: f64,
}

/// Up to four points side by side, for the lanes of a vector register.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Block {
    mass: Lanes,
    position: [Lanes; 3],
}

impl PointCloud {
    /// The largest number of points of a cloud.
    pub const POINTS: usize = 10_000_000;

    /// Builds a cloud of these points, whose mass centre must be the origin.
    ///
    /// # Errors
    /// Returns a [`FullBodyError`] if the list is empty or has more than [`Self::POINTS`] points, a
    /// mass is not a positive number, a position is not finite, or the mass centre is not the
    /// origin.
    pub fn new(points: Vec<MassPoint>) -> Checked<Self> {
        check(&points)?;
        let (mass, center) = mass_center(&points);
        finite("sum of the masses of the points", mass)?;
        centered(&center, farthest(&points))?;
        Ok(Self::weighted(points))
    }

    /// Builds a cloud of points that are given in any axes. It moves the origin to their mass
    /// centre, and also returns the position of the mass centre in the given axes \[m\].
    ///
    /// # Errors
    /// Returns the errors of [`PointCloud::new`], except the error for the mass centre.
    pub fn centered(mut points: Vec<MassPoint>) -> Checked<(Self, Vector3)> {
        check(&points)?;
        let (mass, center) = mass_center(&points);
        finite("sum of the masses of the points", mass)?;
        finite_vector("mass center of the points", center)?;
        points.iter_mut().for_each(|point| point.position -= center);
        Ok((Self::weighted(points), center))
    }

    /// Builds a cloud that represents a quadrature rule, whose weights may be negative.
    pub(super) fn weighted(points: Vec<MassPoint>) -> Self {
        let blocks = points.chunks(LANES).map(Block::new).collect();
        let mass = points.iter().map(|point| point.mass).sum();
        let radius = farthest(&points);
        Self { points, blocks, mass, radius }
    }

    /// Returns the points of the cloud.
    pub fn points(&self) -> &[MassPoint] {
        &self.points
    }

    /// Returns the total mass \[kg\].
    pub fn mass(&self) -> f64 {
        self.mass
    }

    /// Returns the distance of the farthest point from the mass centre \[m\].
    pub fn radius(&self) -> f64 {
        self.radius
    }

    /// Returns the inertia `J = Σ m (|ρ|² I − ρ ρᵀ)` [kg·m²], 3×3, body axes. It is singular if all
    /// points are on a line.
    pub fn inertia(&self) -> Matrix3 {
        let second = self.points.iter().fold(Matrix3::zeros(), |sum, point| {
            sum + point.mass * point.position * point.position.transpose()
        });
        second.trace() * Matrix3::identity() - second
    }

    /// Returns the sums `s = Σ m/|d|³` and `v = Σ m ρ/|d|³` at the field point `y`.
    #[inline]
    pub(super) fn pull(&self, y: &Vector3) -> (f64, Vector3) {
        let y = [0, 1, 2].map(|axis| Lanes::splat(y[axis]));
        let (mut s, mut v) = (Lanes::ZERO, [Lanes::ZERO; 3]);
        for block in &self.blocks {
            let squared = block.squared_distance(&y);
            let weight = block.mass / (squared * squared.sqrt());
            s += weight;
            for (sum, position) in v.iter_mut().zip(&block.position) {
                *sum += weight * *position;
            }
        }
        (s.sum(), Vector3::from(v.map(Lanes::sum)))
    }

    /// Returns the sum `Σ m/|d|` at the field point `y`.
    #[inline]
    pub(super) fn inverse_distances(&self, y: &Vector3) -> f64 {
        let y = [0, 1, 2].map(|axis| Lanes::splat(y[axis]));
        let mut sum = Lanes::ZERO;
        for block in &self.blocks {
            sum += block.mass / block.squared_distance(&y).sqrt();
        }
        sum.sum()
    }
}

impl Block {
    /// Builds the lanes of up to four points. A massless copy of the first point fills each empty
    /// lane.
    fn new(points: &[MassPoint]) -> Self {
        let of = |index: usize| points.get(index);
        Self {
            mass: Lanes::from_fn(|lane| of(lane).map_or(0.0, |point| point.mass)),
            position: [0, 1, 2]
                .map(|axis| Lanes::from_fn(|lane| of(lane).unwrap_or(&points[0]).position[axis])),
        }
    }

    #[inline(always)]
    fn squared_distance(&self, y: &[Lanes; 3]) -> Lanes {
        let [dx, dy, dz] = [0, 1, 2].map(|axis| y[axis] - self.position[axis]);
        dx * dx + dy * dy + dz * dz
    }
}

fn check(points: &[MassPoint]) -> Checked<()> {
    count("points of a cloud", points.len(), PointCloud::POINTS)?;
    for point in points {
        positive("mass of a point", point.mass)?;
        finite_vector("position of a point", point.position)?;
    }
    Ok(())
}

fn mass_center(points: &[MassPoint]) -> (f64, Vector3) {
    let mass: f64 = points.iter().map(|point| point.mass).sum();
    (mass, points.iter().map(|point| point.mass / mass * point.position).sum())
}

fn farthest(points: &[MassPoint]) -> f64 {
    points.iter().map(|point| point.position.norm()).fold(0.0, f64::max)
}
