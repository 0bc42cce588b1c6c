//! The set of outputs of bounded inputs, `{B u : |u_i| ≤ L_i}`: a zonotope, with its corners and
//! faces.

use crate::Vector3;

/// Sine of the angle below which directions count as parallel or coplanar.
const FLAT: f64 = 1e-9;

/// Largest number of coplanar inputs for which all corners are evaluated.
const MAX_IN_PLANE: usize = 10;

/// The inputs that act along one line: their unit axis, and the sum of their `|a_i| L_i`, which may
/// be infinite.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Generator {
    axis: Vector3,
    size: f64,
}

/// The set of all outputs of bounded inputs, as a zonotope with its generators.
#[derive(Clone, Debug)]
pub(crate) struct Outputs {
    generators: Vec<Generator>,
}

impl Outputs {
    /// Builds the set for inputs along `axes` with the bounds `limits`; a limit may be infinite.
    pub(crate) fn new(axes: &[Vector3], limits: impl IntoIterator<Item = f64>) -> Self {
        let mut generators: Vec<Generator> = vec![];
        for (axis, limit) in axes.iter().zip(limits) {
            let size = axis.norm() * limit;
            let axis = axis.normalize();
            if size == 0.0 {
                continue;
            }
            match generators.iter_mut().find(|other| other.axis.cross(&axis).norm() <= FLAT) {
                Some(other) => other.size += size,
                None => generators.push(Generator { axis, size }),
            }
        }
        Self { generators }
    }

    /// Returns an upper bound on the largest `|B u|`, which it equals except with many coplanar
    /// inputs.
    ///
    /// The largest norm is attained at a corner of the zonotope. A corner belongs to a cell in the
    /// arrangement of the planes normal to the generators: it has a sign for each generator. Every
    /// cell has an edge along the cross product of two generators. On this edge all generators have
    /// the signs of the corner, except generators normal to the edge, which are tried with both
    /// signs.
    pub(crate) fn largest(&self) -> f64 {
        let all = &self.generators;
        if all.len() == 1 || all.iter().any(|generator| generator.size == f64::INFINITY) {
            return all.iter().map(|generator| generator.size).sum();
        }
        let corner = |edge: Vector3| {
            let (flat, steep): (Vec<&Generator>, Vec<&Generator>) =
                all.iter().partition(|generator| edge.dot(&generator.axis).abs() <= FLAT);
            let signed = |generator: &Generator| {
                generator.axis * (generator.size * edge.dot(&generator.axis).signum())
            };
            farthest(&steep.into_iter().map(signed).sum(), &flat)
        };
        self.edges().map(corner).fold(0.0, f64::max)
    }

    /// Returns the smallest factor by which the limits must grow to reach `point`, and the
    /// direction of the largest deficit. A factor up to 1 means that `point` may be within reach.
    /// An infinite factor means that no limits suffice.
    pub(super) fn shortfall(&self, point: &Vector3) -> (f64, Vector3) {
        let size = point.norm();
        if size == 0.0 {
            return (0.0, *point);
        }
        let point = point / size;
        let axes = || self.generators.iter().map(|generator| generator.axis);
        // The faces of a zonotope of full dimension are normal to the edges. A flat zonotope and
        // a line have other normals too. Every direction gives a valid bound.
        let in_plane = self.edges().flat_map(|edge| axes().map(move |axis| edge.cross(&axis)));
        let off_line = axes().map(|axis| point - axis * axis.dot(&point));
        let mut worst = (0.0, point);
        for direction in self.edges().chain(in_plane).chain(off_line).chain([point]) {
            let length = direction.norm();
            if length <= FLAT {
                continue;
            }
            let direction = direction / length * direction.dot(&point).signum();
            // Round-off of the direction must not lead to a claim.
            let along = size * (direction.dot(&point) - FLAT);
            let reach = self.generators.iter().fold(0.0, |sum, generator| sum + generator.along(&direction));
            if along > worst.0 * reach {
                worst = (along / reach, direction);
            }
        }
        worst
    }

    /// Returns the normalised cross products of all pairs of generators.
    fn edges(&self) -> impl Iterator<Item = Vector3> {
        let axes: Vec<Vector3> = self.generators.iter().map(|generator| generator.axis).collect();
        let pairs = (0..axes.len()).flat_map(move |i| (0..i).map(move |j| (i, j)));
        pairs.map(move |(i, j)| axes[i].cross(&axes[j]).normalize())
    }
}

impl Generator {
    /// Returns the largest output along a unit vector. An infinite generator normal to the vector
    /// contributes nothing.
    fn along(&self, direction: &Vector3) -> f64 {
        let part = self.axis.dot(direction).abs();
        if part <= FLAT && self.size == f64::INFINITY { 0.0 } else { part * self.size }
    }
}

/// Returns the largest `|sum ± flat_1 ± flat_2 …|`, or an upper bound if `flat` has many
/// generators.
fn farthest(sum: &Vector3, flat: &[&Generator]) -> f64 {
    if flat.len() > MAX_IN_PLANE {
        return sum.norm() + flat.iter().map(|generator| generator.size).sum::<f64>();
    }
    let signed = |signs: u32| {
        let part = |(index, generator): (usize, &&Generator)| {
            generator.axis * if signs >> index & 1 == 1 { -generator.size } else { generator.size }
        };
        (sum + flat.iter().enumerate().map(part).sum::<Vector3>()).norm()
    };
    (0..1_u32 << flat.len()).map(signed).fold(0.0, f64::max)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::testing::Random;

    fn every_corner(axes: &[Vector3], limits: &[f64]) -> Vec<Vector3> {
        let corner = |signs: u32| {
            let part = |(i, (a, l)): (usize, (&Vector3, &f64))| a * if signs >> i & 1 == 1 { -l } else { *l };
            axes.iter().zip(limits).enumerate().map(part).sum()
        };
        (0..1 << axes.len()).map(corner).collect()
    }

    #[test]
    fn largest_output_is_that_of_all_corners() {
        let mut random = Random(3);
        for case in 0..300 {
            let count = 1 + case % 7;
            let mut axes: Vec<Vector3> = (0..count).map(|_| random.vector3()).collect();
            match case % 4 {
                // Parallel, opposite and coplanar axes.
                1 => axes.iter_mut().skip(2).for_each(|axis| axis.z = 0.0),
                2 if count > 2 => axes[2] = -2.0 * axes[0],
                3 if count > 3 => axes[3] = axes[0] + axes[1] - axes[2],
                _ => {}
            }
            let limits: Vec<f64> = (0..count).map(|_| 1.1 + random.uniform()).collect();
            let expected = every_corner(&axes, &limits).iter().map(Vector3::norm).fold(0.0, f64::max);
            let found = Outputs::new(&axes, limits).largest();
            assert!((found - expected).abs() < 1e-9 * expected, "{case}: {found} {expected}");
        }
        let cube = [Vector3::x(), Vector3::y(), Vector3::z()];
        assert!((Outputs::new(&cube, [1.0; 3]).largest() - 3.0_f64.sqrt()).abs() < 1e-15);
        assert_eq!(Outputs::new(&cube, [1.0, f64::INFINITY, 1.0]).largest(), f64::INFINITY);
        assert_eq!(Outputs::new(&cube[..1], [2.0]).largest(), 2.0);
        // Twenty coplanar inputs: not all corners are evaluated, and the result is never too small.
        let fan: Vec<Vector3> =
            (0..20).map(|i| Vector3::new(f64::from(i).cos(), f64::from(i).sin(), 0.0)).collect();
        let corners = every_corner(&fan, &[1.0; 20]).iter().map(Vector3::norm).fold(0.0, f64::max);
        assert!(Outputs::new(&fan, [1.0; 20]).largest() >= corners);
    }

    /// Checks that points produced by allowed inputs are never denied, and that the corner farthest
    /// along a normal is exactly at the limit.
    #[test]
    fn shortfall_is_exact_on_the_faces_and_never_denies_a_point() {
        let mut random = Random(4);
        for case in 0..400 {
            let count = 1 + case % 6;
            let mut axes: Vec<Vector3> = (0..count).map(|_| random.vector3()).collect();
            if case % 5 == 0 {
                axes.iter_mut().for_each(|axis| axis.y = 0.5 * axis.x);
            }
            let limits: Vec<f64> = (0..count).map(|_| 1.1 + random.uniform()).collect();
            let outputs = Outputs::new(&axes, limits.iter().copied());
            let inside: Vector3 =
                axes.iter().zip(&limits).map(|(axis, limit)| axis * (limit * random.uniform())).sum();
            assert!(outputs.shortfall(&inside).0 <= 1.0 + 1e-12, "{case}");
            // The corner that is farthest in a direction lies on the boundary.
            let direction = random.vector3();
            let farther = |a: &Vector3, b: &Vector3| a.dot(&direction).total_cmp(&b.dot(&direction));
            let corner = every_corner(&axes, &limits).into_iter().max_by(farther).unwrap();
            for factor in [1.0, 1.7] {
                let found = outputs.shortfall(&(factor * corner)).0;
                assert!((found - factor).abs() < 1e-7, "{case}: {found} {factor}");
            }
        }
    }

    #[test]
    fn what_no_limit_can_reach_is_infinitely_short() {
        let plane = [Vector3::x(), Vector3::y()];
        for limit in [1.0, f64::INFINITY] {
            let outputs = Outputs::new(&plane, [limit; 2]);
            let (factor, direction) = outputs.shortfall(&Vector3::new(0.1, 0.2, 0.3));
            assert_eq!((factor, direction), (f64::INFINITY, Vector3::z()));
        }
        let line = Outputs::new(&plane[..1], [f64::INFINITY]);
        assert_eq!(line.shortfall(&Vector3::new(5.0, 0.1, 0.0)), (f64::INFINITY, Vector3::y()));
        assert!(line.shortfall(&Vector3::new(-5.0, 0.0, 0.0)).0 <= 1.0);
        assert_eq!(line.shortfall(&Vector3::zeros()).0, 0.0);
        assert_eq!(Outputs::new(&[], []).shortfall(&Vector3::x()).0, f64::INFINITY);
    }
}
