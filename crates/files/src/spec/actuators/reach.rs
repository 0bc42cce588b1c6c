//! Search for a direction in which the inputs have no effect.

use slewkit::Vector3;
use slewkit::mechanics::{Actuation, ActuatorSet};

/// Size below which a component of a unit axis counts as zero.
const NOTHING: f64 = 1e-9;

/// Describes a direction in which the inputs have no effect, such as "nothing turns the body about
/// (0, 0, -1)". `moves` is true if the body also translates. Returns `None` if the inputs can act
/// in every direction.
pub(crate) fn lacking(actuation: &Actuation, moves: bool) -> Option<String> {
    if actuation.reaches_every_direction(moves) {
        return None;
    }
    let force = actuation.force.as_ref().filter(|_| actuation.thrusters.is_some());
    let lacks = |set: &ActuatorSet, what: &str| Some(format!("nothing {what} {}", shown(&direction(set)?)));
    lacks(&actuation.torque, "turns the body about")
        .or_else(|| lacks(force?, "pushes the body along"))
        .or_else(|| {
            force.map(|_| {
                "each single direction is possible, but not every combination of force and torque".into()
            })
        })
}

/// Returns a unit vector in whose direction no input acts. One-sided inputs may act in the opposite
/// direction.
fn direction(set: &ActuatorSet) -> Option<Vector3> {
    match set.rank() {
        (3, _) if !set.limits().one_sided => None,
        (2, normal) => normal,
        // All axes are parallel, so any perpendicular direction is not reached.
        (1, Some(line)) => {
            let across = Vector3::ith(line.iamin(), 1.0);
            Some((across - line * line.dot(&across)).normalize())
        }
        _ => half_space(set.axes()),
    }
}

/// Returns a direction that has no positive scalar product with any axis. All such directions form
/// a cone; each of its edges is normal to two axes. The mean of the edges is returned.
fn half_space(axes: &[Vector3]) -> Option<Vector3> {
    let units: Vec<Vector3> = axes.iter().map(|axis| axis.normalize()).collect();
    let mut amid = Vector3::zeros();
    for (index, a) in units.iter().enumerate() {
        for b in &units[..index] {
            let across = a.cross(b);
            for edge in [across, -across] {
                if across.norm() > NOTHING && units.iter().all(|unit| unit.dot(&edge) <= NOTHING) {
                    amid += edge.normalize();
                }
            }
        }
    }
    (amid.norm() > NOTHING).then(|| amid.normalize())
}

/// Formats three components with three decimals.
fn shown(vector: &Vector3) -> String {
    let [x, y, z] = [vector.x, vector.y, vector.z].map(|part| (part * 1e3).round() / 1e3 + 0.0);
    format!("({x}, {y}, {z})")
}

#[cfg(test)]
mod tests {
    use super::*;
    use slewkit::mechanics::{AxisFrame, Limits};

    fn set(axes: &[[f64; 3]], one_sided: bool) -> ActuatorSet {
        let axes: Vec<Vector3> = axes.iter().copied().map(Vector3::from).collect();
        let limits = Limits { size: Some(vec![1.0; axes.len()]), one_sided, ..Limits::default() };
        ActuatorSet::new(axes, AxisFrame::Body).unwrap().with_limits(limits).unwrap()
    }

    /// A reported direction has no positive scalar product with any axis. No direction is reported
    /// if the axes together act in all directions.
    #[test]
    fn a_direction_is_named_where_one_lacks_and_nowhere_else() {
        const PAIRS: [[f64; 3]; 6] = [
            [1.0, 0.0, 0.0],
            [-1.0, 0.0, 0.0],
            [0.0, 1.0, 0.0],
            [0.0, -1.0, 0.0],
            [0.0, 0.0, 1.0],
            [0.0, 0.0, -1.0],
        ];
        assert_eq!(direction(&set(&PAIRS, true)), None);
        assert_eq!(direction(&set(&PAIRS[..5], true)).map(|way| shown(&way)), Some("(0, 0, -1)".into()));
        assert_eq!(direction(&set(&[PAIRS[0], PAIRS[2], PAIRS[4]], false)), None);
        let two = direction(&set(&[PAIRS[0], PAIRS[2]], false)).unwrap();
        assert!((two.z.abs() - 1.0).abs() < 1e-12);
        for few in [&PAIRS[..4], &PAIRS[..3], &PAIRS[2..], &PAIRS[1..]] {
            let set = set(few, true);
            let way = direction(&set).unwrap();
            assert!(set.axes().iter().all(|axis| axis.dot(&way) <= 1e-9), "{few:?}: {way}");
        }
    }
}
