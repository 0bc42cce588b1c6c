//! Turns that take equal times because of symmetries of the spacecraft and its inputs.
//!
//! Let the rotation S map the inertia, the inputs and the rate limits to themselves. It then maps a
//! plan with rate Ω to a plan with rate `SΩ`, so `T(SQSᵀ) = T(Q)`: the rotation vector φ becomes
//! Sφ. From rest to rest a free body can also fly a plan in reverse, with `R(T − t)` and `u(T − t)`
//! for any inputs. Therefore `T(Q⁻¹) = T(Q)`: φ becomes −φ.
//!
//! A reflection of the spacecraft acts on torques and rates, which are axial vectors, like a half
//! turn about the normal of the mirror plane. Rotations are therefore sufficient.
//!
//! The nodes of a table have directions that signed permutations of three axes map to each other
//! ([`Symmetry::axes`]). The group is searched among the rotations that map two inputs, or two
//! principal axes, to two others. Among the rotations found, those that are signed permutations in
//! the best candidate axes are kept. Threefold axes are not used.

use crate::maneuver::constraint::Rule;
use crate::maneuver::objective::Objective;
use crate::maneuver::problem::Problem;
use crate::mechanics::body::principal_axes;
use crate::{Matrix3, Vector3};

/// Relative tolerance within which inertias, axes or limits count as equal. The times then differ
/// by about as much, which is far less than the error of a table.
const EQUAL: f64 = 1e-6;

/// The rotations and the time reversal that map legs of a spacecraft to legs of equal cost.
#[derive(Clone, Debug, PartialEq)]
pub struct Symmetry {
    /// Axes of the signed permutations, as columns in body axes.
    pub axes: Matrix3,
    /// The signed permutations in these axes, 2 to 48, including the identity and −identity.
    pub maps: Vec<Matrix3>,
}

impl Symmetry {
    /// Finds the symmetry of all rest-to-rest legs of the craft of a problem.
    pub fn of(problem: &Problem) -> Self {
        let craft = Craft::new(problem);
        let group = craft.group();
        let frames = frames(&group);
        let kept = |axes: &Matrix3| -> Vec<Matrix3> {
            group.iter().filter_map(|map| signed_permutation(&(axes.transpose() * map * axes))).collect()
        };
        let mut best = (Matrix3::identity(), kept(&Matrix3::identity()));
        for axes in frames {
            let maps = kept(&axes);
            if maps.len() > best.1.len() {
                best = (axes, maps);
            }
        }
        let (axes, rotations) = best;
        let maps = rotations.iter().flat_map(|map| [*map, -map]).collect();
        Self { axes, maps }
    }
}

/// The properties of a spacecraft that a symmetry must preserve.
struct Craft {
    inertia: Matrix3,
    /// The inputs, each with its axis, its limits, and whether it is two-sided.
    inputs: Vec<Input>,
    /// Whether the torque capability is the same in all directions.
    round: bool,
    rate_axes: Vec<Vector3>,
}

/// One input: its axis, its limits and weight, and whether it can act in both directions.
struct Input {
    axis: Vector3,
    limits: Vec<f64>,
    both_sides: bool,
}

impl Craft {
    fn new(problem: &Problem) -> Self {
        let set = &problem.actuation.torque;
        let limits = set.limits();
        let held = problem.actuation.wheels.as_ref();
        let weighted = match &problem.objective {
            Objective::Effort(weights) => weights.torque(&problem.actuation).weight.clone(),
            _ => nalgebra::DMatrix::identity(set.count(), set.count()),
        };
        let diagonal = (0..set.count())
            .all(|row| (0..set.count()).all(|column| row == column || weighted[(row, column)] == 0.0));
        let inputs = (0..set.count()).map(|index| Input {
            axis: set.axes()[index],
            limits: [
                limits.size.as_ref().map_or(f64::INFINITY, |sizes| sizes[index]),
                limits.rate.as_ref().map_or(f64::INFINITY, |rates| rates[index]),
                held.map_or(f64::INFINITY, |held| held.momentum_limit[index]),
                // If weights couple the inputs, each input counts as equal to itself only.
                if diagonal { weighted[(index, index)] } else { index as f64 },
            ]
            .to_vec(),
            both_sides: !limits.one_sided && diagonal,
        });
        let inputs: Vec<Input> = inputs.collect();
        // The torque is limited by its norm only, or the effort has equal weights in all
        // directions.
        let gram: Matrix3 = set.axes().iter().map(|axis| axis * axis.transpose()).sum();
        let isotropic = (gram - Matrix3::identity() * (gram.trace() / 3.0)).amax() <= EQUAL * gram.amax();
        let alike = inputs.iter().all(|input| input.limits == inputs[0].limits);
        let round = limits.size.is_none()
            && limits.rate.is_none()
            && held.is_none()
            && alike
            && isotropic
            && diagonal;
        let rate_axes = problem.constraints.iter().filter_map(|constraint| match &constraint.rule {
            Rule::RateAxes(limits) => Some(*limits),
            _ => None,
        });
        Self { inertia: *problem.body.inertia.j(), inputs, round, rate_axes: rate_axes.collect() }
    }

    /// Returns the rotations that preserve the craft, the identity first.
    fn group(&self) -> Vec<Matrix3> {
        let mut found = vec![Matrix3::identity()];
        let add = |map: Matrix3, found: &mut Vec<Matrix3>| {
            if self.is_kept(&map) && found.iter().all(|other| (other - map).amax() > 1e-3) {
                found.push(map);
            }
        };
        let principal = principal_axes(&self.inertia).1;
        for half_turn in [[1.0, -1.0, -1.0], [-1.0, 1.0, -1.0], [-1.0, -1.0, 1.0]] {
            let turn = Matrix3::from_diagonal(&Vector3::from(half_turn));
            add(principal * turn * principal.transpose(), &mut found);
        }
        let units: Vec<Vector3> = self.inputs.iter().map(|input| input.axis.normalize()).collect();
        // The images of two nonparallel inputs determine a rotation.
        let Some(second) = (1..units.len()).find(|index| units[0].cross(&units[*index]).norm() > 1e-3) else {
            return found;
        };
        let signs = |input: &Input| if input.both_sides { vec![1.0, -1.0] } else { vec![1.0] };
        let from = triad(&units[0], &units[second]);
        for (i, first_image) in units.iter().enumerate() {
            for (j, second_image) in units.iter().enumerate() {
                for s in signs(&self.inputs[i]) {
                    for t in signs(&self.inputs[j]) {
                        let (a, b) = (first_image * s, second_image * t);
                        if i != j && (a.dot(&b) - units[0].dot(&units[second])).abs() <= EQUAL {
                            add(triad(&a, &b) * from.transpose(), &mut found);
                        }
                    }
                }
            }
        }
        found
    }

    /// Returns whether a rotation preserves inertia, inputs and rate limits.
    fn is_kept(&self, map: &Matrix3) -> bool {
        let turned = map * self.inertia * map.transpose();
        let rates = self.rate_axes.iter().all(|limits| {
            // Only signed permutations that preserve the rate limits map their box to itself.
            signed_permutation(map)
                .is_some_and(|turn| (turn.abs() * limits - limits).amax() <= EQUAL * limits.amax())
        });
        let equal = |a: f64, b: f64| a == b || (a - b).abs() <= EQUAL * a.abs().max(b.abs());
        let has_image = |input: &Input| {
            let image = map * input.axis;
            let size = EQUAL * image.norm();
            self.inputs.iter().any(|other| {
                let same = (other.axis - image).norm() <= size;
                let opposite = input.both_sides && other.both_sides && (other.axis + image).norm() <= size;
                (same || opposite) && input.limits.iter().zip(&other.limits).all(|(a, b)| equal(*a, *b))
            })
        };
        (turned - self.inertia).amax() <= EQUAL * self.inertia.amax()
            && rates
            && (self.round || self.inputs.iter().all(has_image))
    }
}

/// Returns right-handed axes whose first axis is along `a`; the second lies in the plane of `a` and
/// `b`, towards `b`.
fn triad(a: &Vector3, b: &Vector3) -> Matrix3 {
    let third = a.cross(b).normalize();
    Matrix3::from_columns(&[*a, third.cross(a), third])
}

/// Returns candidate axes in which the group may consist of signed permutations: two perpendicular
/// rotation axes of the group, or one rotation axis with any normal to it.
fn frames(group: &[Matrix3]) -> Vec<Matrix3> {
    let axes: Vec<Vector3> =
        group.iter().skip(1).filter_map(|map| crate::lie::log(map).try_normalize(1e-6)).collect();
    let mut frames = Vec::new();
    for (index, a) in axes.iter().enumerate() {
        let rest = axes[index + 1..].iter().filter(|b| a.dot(b).abs() <= EQUAL);
        frames.extend(rest.map(|b| triad(a, b)));
        let aside = Vector3::ith(a.iamin(), 1.0);
        frames.push(triad(a, &aside));
    }
    frames
}

/// Returns the signed permutation that equals a matrix within ten times [`EQUAL`]; `None` if no
/// signed permutation does.
fn signed_permutation(map: &Matrix3) -> Option<Matrix3> {
    let rounded = map.map(f64::round);
    ((map - rounded).amax() <= 10.0 * EQUAL).then_some(rounded)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::testing::full_inertia;
    use crate::{
        Actuation, ActuatorSet, AxisFrame, Body, Constraint, Inertia, Limits, Problem, State, Wheels,
    };

    fn boxed(moments: [f64; 3], limits: [f64; 3]) -> Problem {
        let inertia = Inertia::diagonal(Vector3::from(moments)).unwrap();
        let still = State::at_rest(Matrix3::identity());
        let limits = Limits { size: Some(limits.to_vec()), ..Limits::default() };
        let torques = ActuatorSet::three_axes(AxisFrame::Body).with_limits(limits).unwrap();
        Problem::minimum_time(Body { inertia, mass: None }, still, still)
            .with_actuation(Actuation::torques(torques))
    }

    fn size(problem: &Problem) -> usize {
        Symmetry::of(problem).maps.len()
    }

    #[test]
    fn boxes_have_the_symmetries_of_their_sides() {
        let cube = boxed([1.0; 3], [1.0; 3]);
        assert_eq!(size(&cube), 48);
        assert_eq!(size(&boxed([1.0, 1.0, 1.5], [1.0; 3])), 16);
        assert_eq!(size(&boxed([1.0, 1.2, 1.5], [1.0; 3])), 8);
        assert_eq!(size(&boxed([1.0; 3], [1.0, 1.0, 2.0])), 16);
        // A smaller rate limit about one axis removes the symmetries that move this axis.
        let rule = Rule::RateAxes(Vector3::new(0.1, 0.1, 0.2));
        assert_eq!(size(&cube.with_constraint(Constraint { name: "rates".into(), rule })), 16);
        let mut full = boxed([1.0; 3], [1.0; 3]);
        full.body.inertia = full_inertia();
        assert_eq!(size(&full), 2);
    }

    #[test]
    fn a_pyramid_of_wheels_turns_by_quarters_about_its_axis() {
        let axes = [(0.8, 0.0), (-0.8, 0.0), (0.0, 0.8), (0.0, -0.8)].map(|(x, y)| Vector3::new(x, y, 0.6));
        let mut problem = boxed([2.0, 2.0, 1.5], [1.0; 3]);
        let wheels = Wheels { momentum: vec![0.0; 4], momentum_limit: vec![1.0; 4] };
        problem.actuation = Actuation::of_wheels(axes.to_vec(), vec![0.1; 4], wheels).unwrap();
        assert_eq!(size(&problem), 16);
        problem.actuation.wheels.as_mut().unwrap().momentum_limit[0] = 0.5;
        // Only the half turn about the plane of the failed wheel remains.
        assert_eq!(size(&problem), 4);
    }

    #[test]
    fn thrusters_of_one_side_have_no_opposite() {
        let mut problem = boxed([1.0; 3], [1.0; 3]);
        let axes =
            vec![Vector3::x(), Vector3::y(), Vector3::z(), -Vector3::x(), -Vector3::y(), -Vector3::z()];
        let limits = |sizes| Limits { size: Some(sizes), one_sided: true, ..Limits::default() };
        let set = |sizes| {
            ActuatorSet::new(axes.clone(), AxisFrame::Body).unwrap().with_limits(limits(sizes)).unwrap()
        };
        problem.actuation = Actuation::torques(set(vec![1.0; 6]));
        assert_eq!(size(&problem), 48);
        problem.actuation = Actuation::torques(set(vec![1.0, 1.0, 1.0, 0.5, 1.0, 1.0]));
        // Only quarter turns about x remain.
        assert_eq!(size(&problem), 8);
    }
}
