//! Random slews under a torque limit, with keep-out cones on the unconstrained path.

use slewkit::maneuver::{Constraint, Direction, Path, Pointing, Problem, Rule, Settings, Side, State};
use slewkit::mechanics::{Actuation, ActuatorSet, AxisFrame, Body, Inertia, Limits};
use slewkit::plan::{Silent, plan};
use slewkit::{Matrix3, Vector3, lie};

use crate::Random;

/// Returns the case with number `seed`; `None` if the unconstrained slew is not found. The body has
/// moments of 0.3–1.3 and makes a rest-to-rest slew by 30–170° in unit time. The limit on each
/// torque is 60–95 % of the largest component of the unconstrained torque. The case has `cones`
/// keep-out cones of 3–12°; if `cones` is `None`, one or two at random. The unconstrained path of a
/// random boresight crosses each cone in the middle half of the slew, usually off the axis of the
/// cone. Neither end lies inside a cone. A cone that violates this in a hundred draws is left out.
pub fn case(seed: u64, cones: Option<usize>) -> Option<Problem> {
    let mut random = Random::new(seed.wrapping_mul(0x1234_5677) + 99);
    let moments = loop {
        let m = Vector3::from_fn(|_, _| 0.3 + random.unit());
        if m.x + m.y > 1.05 * m.z && m.y + m.z > 1.05 * m.x && m.z + m.x > 1.05 * m.y {
            break m;
        }
    };
    let axes = lie::exp(&(random.direction() * 3.0));
    let j = axes * Matrix3::from_diagonal(&moments) * axes.transpose();
    let body = Body { inertia: Inertia::new(0.5 * (j + j.transpose())).ok()?, mass: None };
    let angle = 0.5 + 2.5 * random.unit();
    let start = lie::exp(&(random.direction() * (3.0 * random.unit())));
    let end = start * lie::exp(&(random.direction() * angle));
    let free = Problem::attitude(body, State::at_rest(start), State::at_rest(end), 1.0);
    let unconstrained =
        plan(&free.clone().with_path(Path::Shortest), &Settings::discrete(), None, &mut Silent).ok()?;
    let trajectory = &unconstrained.solution.trajectory;
    let peak = trajectory.torque.iter().map(|torque| torque.amax()).fold(0.0, f64::max);
    let share = 0.6 + 0.35 * random.unit();
    let limits = Limits { size: Some(vec![share * peak; 3]), ..Limits::default() };
    let channel = ActuatorSet::three_axes(AxisFrame::Body).with_limits(limits).ok()?;
    let mut problem = free.with_actuation(Actuation::torques(channel));
    let by_chance = 1 + usize::from(random.unit() > 0.5);
    let cones = cones.unwrap_or(by_chance);
    let mut text = format!("limit {share:.3}");
    for index in 0..cones {
        // Draws a boresight, and a direction that it passes at a random time of the unconstrained
        // slew.
        for _ in 0..100 {
            let boresight = random.direction();
            let at = 0.25 + 0.5 * random.unit();
            let q = trajectory.quaternion[(at * (trajectory.quaternion.len() - 1) as f64) as usize];
            let half_angle = (3.0 + 9.0 * random.unit()).to_radians();
            // The path usually crosses the cone off its axis.
            let aside = lie::exp(&(random.direction() * (half_angle * random.unit())));
            let direction = aside * lie::rotation_from_quaternion(&q) * boresight;
            let away =
                |r: &Matrix3| (r * boresight).dot(&direction).clamp(-1.0, 1.0).acos() > half_angle + 0.02;
            if away(&start) && away(&end) {
                text += &format!(", cone {:.1} deg at {at:.2}", half_angle.to_degrees());
                let pointing = Pointing::new(
                    Side::KeepOut,
                    vec![boresight],
                    vec![Direction::Fixed(direction.normalize())],
                    half_angle,
                );
                problem = problem.with_constraint(Constraint {
                    name: format!("cone {index}"),
                    rule: Rule::Pointing(pointing),
                });
                break;
            }
        }
    }
    problem.name = text;
    Some(problem)
}
