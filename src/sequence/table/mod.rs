//! Tables of the times or efforts of all rest-to-rest legs of one spacecraft.
//!
//! A node stores the value, its gradient by the rotation vector φ of the turn, and a rigorous lower
//! bound ([`LegBound`]). The gradient is the terminal costate of the attitude in the plan of the
//! node. The table interpolates the ratio `r = T/T_ref` of the value to a closed form
//! (`reference`):
//!
//! ```text
//! T(φ) = T_ref(φ) Σ w_i (r_i + ½ ∇r_i·(x − x_i))
//! ```
//!
//! in the chart x = (point of the octahedron, angle), with the weights w of the triangle and of the
//! two angles (`mesh`). The weights reproduce linear functions, and the sum is then exact for
//! quadratic functions. The reason is that the error of linear interpolation is `½ Σ w dᵀHd`, the
//! sum of the tangents has the opposite error, and this formula is the mean of both.
//!
//! # Which interpolations were compared?
//!
//! Fractions of 600 random turns with errors within 0.5 % and within 1 %, for n = 12, 19 angles and
//! quick plans of the nodes:
//!
//! | interpolation | XTE, box of torques | asymmetric, 4 wheels, 4°/s |
//! |---|---|---|
//! | linear in r | 87 %, 95 % | |
//! | sum of tangents | 85 %, 97 % | |
//! | least tangent | 68 %, 80 % | |
//! | half gradients | 94 %, 98.5 % | 100 %, 100 % |
//! | half gradients, r by the true box | 82 %, 91 % | |
//! | half gradients, default search, 11 angles | 97.5 %, 99.7 % | 100 %, 100 % |
//! | the same on n = 6 | 78 %, 94 % | 99.7 %, 100 % |
//! | the same on n = 12, two sheets beyond 180° | 97.7 %, 99.7 % | |
//!
//! Quick searches missed the best plan of the XTE by more than 0.5 % in 17 of 600 cases, default
//! searches in none. The nodes are therefore planned with the search settings of the spec. The
//! value is a minimum of smooth branches, and has kinks between them. Planes of symmetry and half
//! turns are edges of the mesh. At a node on a plane of symmetry the gradient has images under the
//! symmetry, one for each branch, and interpolation uses the lowest branch. The remaining errors
//! come from other kinks.
//!
//! # Which legs cannot be tabulated?
//!
//! Cones, momentum stored in wheels, force fields, and inputs fixed in the reference frame make a
//! leg depend on both attitudes instead of the turn between them. Cones only lengthen a leg: a
//! table without them is an optimistic estimate, and its lower bounds stay valid. The other cases
//! are rejected ([`TableError`]).

mod making;
mod mesh;
mod reference;
#[cfg(test)]
mod tests;

pub use making::{Left, Making, TableError, TableOptions};

use crate::sequence::leg_bound::LegBound;
use crate::{Matrix3, Vector3, lie};
use mesh::Mesh;
use reference::Reference;
use std::f64::consts::PI;

/// The number of signed permutations of three axes.
const MOST_MAPS: usize = 48;

/// The physical quantity that a table contains.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Quantity {
    /// Minimum time \[s\].
    Time,
    /// Minimum effort `∫ ½ uᵀWu dt` in a given duration.
    Effort,
}

impl Quantity {
    /// Returns the name of the quantity in table files.
    pub fn name(self) -> &'static str {
        match self {
            Self::Time => "time",
            Self::Effort => "effort",
        }
    }
}

/// Measured relative errors of a table: interpolated value over planned value, minus 1.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Errors {
    /// Number of random turns that were planned for the measurement.
    pub count: usize,
    /// Median of the absolute errors.
    pub median: f64,
    /// 99th percentile of the absolute errors.
    pub most: f64,
    /// Smallest signed error, at most 0: the table underestimates the value by this fraction.
    pub lowest: f64,
    /// Largest signed error, at least 0: the table overestimates the value by this fraction.
    pub highest: f64,
    /// Median of the ratio of the lower bound to the planned value.
    pub bound: f64,
}

impl Errors {
    /// Computes the errors from triples of interpolated value, planned value and lower bound.
    pub fn of(cases: &[[f64; 3]]) -> Self {
        let sorted = |mut values: Vec<f64>| {
            values.sort_by(f64::total_cmp);
            values
        };
        let errors = sorted(cases.iter().map(|[found, planned, _]| found / planned - 1.0).collect());
        let sizes = sorted(errors.iter().map(|error| error.abs()).collect());
        let bounds = sorted(cases.iter().map(|[_, planned, bound]| bound / planned).collect());
        let at = |values: &[f64], part: f64| {
            let last = values.len().saturating_sub(1);
            values.get((part * last as f64).round() as usize).copied().unwrap_or(0.0)
        };
        Self {
            count: cases.len(),
            median: at(&sizes, 0.5),
            most: at(&sizes, 0.99),
            lowest: errors.first().copied().unwrap_or(0.0).min(0.0),
            highest: errors.last().copied().unwrap_or(0.0).max(0.0),
            bound: at(&bounds, 0.5),
        }
    }
}

/// The nodes of a table, as stored in a file. Lists have one entry per node, angle by angle, and
/// within an angle by direction.
#[derive(Clone, Debug, PartialEq)]
pub struct Nodes {
    /// The physical quantity that the table contains.
    pub quantity: Quantity,
    /// Number n of divisions of each edge of the octahedron.
    pub divisions: usize,
    /// Axes of the octahedron as columns, in body axes.
    pub axes: Matrix3,
    /// The symmetry: signed permutations of these axes, including −identity. They map a rotation
    /// vector to others of equal value.
    pub maps: Vec<Matrix3>,
    /// Angles of the turns \[rad\], ascending; the last one is π.
    pub angles: Vec<f64>,
    /// Tabulated value of each node: \[s\], or the unit of the effort.
    pub values: Vec<f64>,
    /// Gradient of the value of each node by the rotation vector, body axes.
    pub gradients: Vec<Vector3>,
    /// Lower bound of the value of each node.
    pub bounds: Vec<f64>,
    /// Duration of the turn of each node about its fixed axis (eigenaxis) within the limits \[s\],
    /// from [`fixed_axis_duration`](crate::maneuver::fixed_axis_duration). Empty for efforts, and if
    /// this duration is not known.
    pub fixed_axis: Vec<f64>,
    /// Duration for which efforts are tabulated \[s\]; zero for tables of times.
    pub duration_s: f64,
    /// Whether the efforts also hold for other durations, scaled by `1/T³`. This is the case
    /// without limits.
    pub scales: bool,
    /// The two matrices of the closed form by which the values are divided: of the torques, and of
    /// the rates.
    pub reference: [Matrix3; 2],
    /// The numbers that define the lower bounds, from [`LegBound::numbers`].
    pub bound: [f64; LegBound::NUMBERS],
    /// Settling time after a leg \[s\].
    pub settling_s: f64,
    /// Number of maneuvers that were planned for the table; symmetry gives the other nodes.
    pub planned: usize,
    /// Errors on random turns; all zero if they were not measured.
    pub errors: Errors,
}

/// A table of legs, prepared for interpolation.
///
/// ```
/// use slewkit::sequence::{SlewTable, TableOptions};
/// use slewkit::{Actuation, ActuatorSet, AxisFrame, Body, Inertia, Limits, Matrix3, Problem, State, Vector3, lie};
///
/// let body = Body { inertia: Inertia::diagonal(Vector3::new(1.0, 1.0, 1.0))?, mass: None };
/// let still = State::at_rest(Matrix3::identity());
/// let limits = Limits { size: Some(vec![1.0; 3]), ..Limits::default() };
/// let torques = ActuatorSet::three_axes(AxisFrame::Body).with_limits(limits)?;
/// let problem = Problem::minimum_time(body, still, still).with_actuation(Actuation::torques(torques));
///
/// let options = TableOptions { divisions: Some(2), checks: 0, ..TableOptions::default() };
/// let table = SlewTable::make(&problem, &Default::default(), &options, &mut |_| true)?;
/// let quarter = lie::exp(&Vector3::new(0.0, 0.0, std::f64::consts::FRAC_PI_2));
/// // Bilimoria and Wie 1993: 2.4211 s.
/// assert!((table.value(&quarter) - 2.4211).abs() < 0.03);
/// assert!(table.bound(&quarter) < 2.4211);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Clone, Debug)]
pub struct SlewTable {
    nodes: Nodes,
    mesh: Mesh,
    reference: Reference,
    bound: LegBound,
    /// Ratio and half slopes of each node, in the chart of the mesh.
    pieces: Vec<Piece>,
    /// The half slopes ½ ∂r/∂p of further branches, at nodes that a symmetry maps to themselves.
    branches: Vec<Vector3>,
}

/// The data of one node in the chart: r, ½ ∂r/∂p and ½ ∂r/∂θ.
#[derive(Clone, Copy, Debug)]
struct Piece {
    ratio: f64,
    along: Vector3,
    outward: f64,
    /// Range of its further branches in `branches`: first index, and index after the last.
    branches: [u32; 2],
}

impl SlewTable {
    /// Largest number of divisions of an edge of the octahedron.
    pub const MAX_DIVISIONS: usize = 64;
    /// Largest number of angles.
    pub const MAX_ANGLES: usize = 180;

    /// Builds a table from its nodes.
    ///
    /// # Errors
    /// [`TableError::Nodes`] if lengths of lists do not match, numbers are not finite, or values
    /// are not positive.
    pub fn new(nodes: Nodes) -> Result<Self, TableError> {
        let unfit = |what: &'static str| Err(TableError::Nodes { what });
        if !(1..=Self::MAX_DIVISIONS).contains(&nodes.divisions) {
            return unfit("the number of divisions is not from 1 to 64");
        }
        let angles = &nodes.angles;
        let ascend = angles.windows(2).all(|pair| pair[0] < pair[1]);
        let ends = angles.first().is_some_and(|first| *first > 0.0)
            && angles.last().is_some_and(|last| (last - PI).abs() < 1e-9);
        if !(2..=Self::MAX_ANGLES).contains(&angles.len()) || !ascend || !ends {
            return unfit("the angles do not ascend from above 0° to 180°");
        }
        let mesh = Mesh::new(nodes.divisions);
        let count = mesh.count() * angles.len();
        if [nodes.values.len(), nodes.gradients.len(), nodes.bounds.len()] != [count; 3] {
            return unfit("values, gradients and bounds are not as many as directions times angles");
        }
        if ![0, count].contains(&nodes.fixed_axis.len()) {
            return unfit("turns about fixed axes are not as many as directions times angles");
        }
        let positive = |value: &f64| *value > 0.0 && value.is_finite();
        if !nodes.values.iter().chain(&nodes.fixed_axis).all(positive) {
            return unfit("a value is not positive and finite");
        }
        let finite = nodes.gradients.iter().flatten().chain(&nodes.bounds).all(|value| value.is_finite());
        let reference = nodes.reference.iter().flatten().all(|value| value.is_finite());
        let times = nodes.settling_s >= 0.0 && nodes.settling_s.is_finite() && nodes.duration_s >= 0.0;
        if !finite || !reference || !times {
            return unfit("a number is not finite, or a time is negative");
        }
        let orthogonal = lie::orthogonality(&nodes.axes) < 1e-9;
        if !orthogonal {
            return unfit("the axes are not orthogonal");
        }
        let Some(bound) = LegBound::from_numbers(&nodes.bound) else {
            return unfit("the numbers of the bound are unusable");
        };
        let [torque, rate] = nodes.reference;
        let reference = Reference { quantity: nodes.quantity, torque, rate };
        let fits = |map: &Matrix3| {
            let whole = map.iter().all(|part| [-1.0, 0.0, 1.0].contains(part));
            whole && lie::orthogonality(map) < 1e-9
        };
        if nodes.maps.len() > MOST_MAPS || !nodes.maps.iter().all(fits) {
            return unfit("the symmetry is not of signed permutations");
        }
        let stays: Vec<Vec<&Matrix3>> = (0..mesh.count())
            .map(|node| nodes.maps.iter().filter(|map| mesh.image(map, node) == node).collect())
            .collect();
        let (mut pieces, mut branches) = (Vec::with_capacity(count), Vec::<Vector3>::new());
        for (level, angle) in angles.iter().enumerate() {
            for (node, stays) in stays.iter().enumerate() {
                let index = level * mesh.count() + node;
                let point = mesh.point(node);
                let length = point.norm();
                let axis = point / length;
                let vector = nodes.axes * axis * *angle;
                let divisor = reference.value(&vector);
                let ratio = nodes.values[index] / divisor;
                let slope = (nodes.gradients[index] - reference.gradient(&vector) * ratio) / divisor;
                let slope = nodes.axes.tr_mul(&slope);
                let outward = slope.dot(&axis);
                if !(divisor > 0.0 && ratio.is_finite() && outward.is_finite()) {
                    return unfit("the closed form is not positive");
                }
                // Here φ = θ p/|p|.
                let along = (slope - axis * outward) * (0.5 * angle / length);
                let first = branches.len();
                for map in stays {
                    let image = *map * along;
                    let differs = |other: &Vector3| (other - image).amax() > 1e-12 * along.amax();
                    if differs(&along) && branches[first..].iter().all(differs) {
                        branches.push(image);
                    }
                }
                let range = [first as u32, branches.len() as u32];
                pieces.push(Piece { ratio, along, outward: 0.5 * outward, branches: range });
            }
        }
        Ok(Self { nodes, mesh, reference, bound, pieces, branches })
    }

    /// Returns the nodes of the table.
    pub fn nodes(&self) -> &Nodes {
        &self.nodes
    }

    /// Returns the rotation vectors of the nodes \[rad\], body axes, in the order of their values.
    pub fn vectors(&self) -> impl Iterator<Item = Vector3> {
        vectors(&self.mesh, &self.nodes.axes, &self.nodes.angles)
    }

    /// Returns the interpolated value of a turn, without settling: \[s\] or the unit of the effort.
    /// It is zero for the identity, and NaN if an entry of `turn` is NaN.
    pub fn value(&self, turn: &Matrix3) -> f64 {
        self.of_vector(&lie::log(turn))
    }

    /// Returns the interpolated value of the turn with this rotation vector, whose norm is at most
    /// π \[rad\].
    pub fn of_vector(&self, vector: &Vector3) -> f64 {
        self.interpolated(vector, |index, aside, outward| {
            let piece = &self.pieces[index];
            // On a plane of symmetry the value has a kink; the lowest branch is used.
            let [first, end] = piece.branches.map(|place| place as usize);
            let others = self.branches[first..end].iter().map(|along| along.dot(&aside));
            let along = others.fold(piece.along.dot(&aside), f64::min);
            piece.ratio + along + piece.outward * outward
        })
    }

    /// Returns the duration \[s\] of a turn about its fixed axis (eigenaxis), interpolated linearly;
    /// `None` if the table does not have these durations.
    pub fn fixed_axis(&self, turn: &Matrix3) -> Option<f64> {
        let known = &self.nodes.fixed_axis;
        let ratio = |index: usize, _, _| {
            let piece = &self.pieces[index];
            piece.ratio * known[index] / self.nodes.values[index]
        };
        (!known.is_empty()).then(|| self.interpolated(&lie::log(turn), ratio))
    }

    /// Returns the closed form at a rotation vector, times the weighted mean of `ratio` over the
    /// nodes around it. The arguments of `ratio` are the index of a node, the displacement from the
    /// node on the octahedron, and the angle beyond that of the node \[rad\].
    #[inline]
    fn interpolated(&self, vector: &Vector3, ratio: impl Fn(usize, Vector3, f64) -> f64) -> f64 {
        let angle = vector.norm();
        if angle < 1e-12 {
            return 0.0;
        }
        let own = self.nodes.axes.tr_mul(vector);
        let point = own / own.abs().sum();
        if !point.x.is_finite() {
            return f64::NAN;
        }
        let angles = &self.nodes.angles;
        // Below the first angle of the table the ratio is constant.
        let inside = angle.clamp(angles[0], angles[angles.len() - 1]);
        let level = angles.partition_point(|known| *known <= inside).clamp(1, angles.len() - 1);
        let (low, high) = (angles[level - 1], angles[level]);
        let upper = (inside - low) / (high - low);
        let mut mean = 0.0;
        for (node, weight) in self.mesh.corners(&point) {
            let aside = point - self.mesh.point(node);
            for (level, share) in [(level - 1, 1.0 - upper), (level, upper)] {
                let index = level * self.mesh.count() + node;
                mean += weight * share * ratio(index, aside, inside - angles[level]);
            }
        }
        mean * self.reference.value(vector)
    }

    /// Returns a proved lower bound of the value of a turn.
    pub fn bound(&self, turn: &Matrix3) -> f64 {
        match self.nodes.quantity {
            Quantity::Time => self.bound.time(turn),
            Quantity::Effort => self.bound.effort(turn, self.nodes.duration_s),
        }
    }

    /// Returns the interpolated value of the turn between two attitudes, without settling. The
    /// attitudes are quaternions `[w, x, y, z]` of any nonzero length.
    pub fn between(&self, first: &[f64; 4], second: &[f64; 4]) -> f64 {
        let [a, b, c, d] = *first;
        let [w, x, y, z] = *second;
        // The quaternion q₁⁻¹ q₂ of the turn, not normalised.
        let scalar = a * w + b * x + c * y + d * z;
        let vector = Vector3::new(
            a * x - b * w - c * z + d * y,
            a * y + b * z - c * w - d * x,
            a * z - b * y + c * x - d * w,
        );
        let sine = vector.norm();
        if sine == 0.0 {
            return if scalar.abs() > 0.0 { 0.0 } else { f64::NAN };
        }
        let angle = 2.0 * sine.atan2(scalar.abs());
        self.of_vector(&(vector * (angle.copysign(scalar * angle) / sine)))
    }

    /// Returns the interpolated values between all pairs of n attitudes, as an n × n matrix, row by
    /// row.
    pub fn matrix(&self, attitudes: &[[f64; 4]]) -> Vec<f64> {
        attitudes.iter().flat_map(|from| attitudes.iter().map(|to| self.between(from, to))).collect()
    }
}

/// Returns the rotation vectors of all nodes, angle by angle.
fn vectors(mesh: &Mesh, axes: &Matrix3, angles: &[f64]) -> impl Iterator<Item = Vector3> {
    angles.iter().flat_map(move |angle| {
        (0..mesh.count()).map(move |node| axes * mesh.point(node).normalize() * *angle)
    })
}
