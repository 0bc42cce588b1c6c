//! Limits of the state as functions of it, with what an input must do to stay on them.
//!
//! ```text
//! c = ±Ω_i − L                       ċ = ±Ω̇_i                                                          order 1
//! c = (Ω·Ω − L²)/2L                  ċ = Ω·Ω̇ / L                                                       order 1
//! c = ±h_i − L                       ċ = ±ḣ_i                                                          order 1
//! c = ±w_i − 1                       ċ = ±ẇ_i                                                          order 1
//! c = ±(w·R b − cos α)/sin α         ċ = ±[d·(Ω×b) + d'·b]/sin α                                       order 2
//!                                    c̈ = ±[d·(Ω×(Ω×b)) + 2 d'·(Ω×b) + d''·b + (b×d)·Ω̇]/sin α
//! ```
//!
//! with the direction `d`, `d'` and `d''` in body axes of `w`, `ẇ` and `ẅ`, which are zero of one that is fixed in inertial space. The last
//! derivative of each is linear in the derivative of the state: `ν·ẏ + r`. It vanishes along an arc that holds the limit.

use super::state::{Change, State, at};
use crate::maneuver::constraint::{Direction, Rule, Side};
use crate::maneuver::problem::Problem;
use crate::mechanics::actuators::LimitKind;
use crate::mechanics::direction::LineOfSight;
use crate::{Vector3, lie};

/// A limit of the state: `c ≤ 0`.
#[derive(Clone, Debug)]
pub(crate) struct Limit {
    /// Of the constraint of the maneuver, or of the limit of its wheels, that it belongs to.
    pub name: String,
    kind: Kind,
}

#[derive(Clone, Debug)]
enum Kind {
    Axis { axis: usize, sign: f64, limit: f64 },
    Norm { limit: f64 },
    Wheel { wheel: usize, sign: f64, limit: f64 },
    Ramp { ramp: usize, sign: f64 },
    Cone(Cone),
}

/// A cone about a direction.
#[derive(Clone, Debug)]
struct Cone {
    boresight: Vector3,
    direction: Direction,
    /// Angular velocity of the reference frame [rad/s], and the unit of time \[s\].
    frame_rate: Vector3,
    time: f64,
    sign: f64,
    cosine: f64,
    sine: f64,
}

impl Cone {
    /// The direction and its derivatives in inertial space, body axes, in the unit of time.
    fn seen(&self, state: &State) -> LineOfSight {
        let time = state.time() * self.time;
        let LineOfSight { direction, rate, acceleration } = self.direction.in_space(time, &self.frame_rate);
        let in_body = |vector: Vector3| {
            let still = self.frame_rate == Vector3::zeros();
            let vector = if still { vector } else { lie::exp(&(self.frame_rate * -time)) * vector };
            state.in_body_axes(&vector)
        };
        LineOfSight {
            direction: in_body(direction),
            rate: in_body(rate * self.time),
            acceleration: in_body(acceleration * (self.time * self.time)),
        }
    }
}

impl Limit {
    /// Those of a maneuver, in units of time and torque; `None` where one acts at times, is an equation, or is about a disc, whose limb
    /// changes its distance.
    pub fn all(problem: &Problem, time: f64, torque: f64) -> Option<Vec<Self>> {
        let frame_rate = problem.environment.frame_rate();
        let mut all = Vec::new();
        for limit in problem.actuation.limits().filter(|limit| limit.kind == LimitKind::WheelMomentum) {
            let bounded = limit.bounds.iter().enumerate().filter(|(_, bound)| bound.is_finite());
            for (wheel, sign) in bounded.flat_map(|(wheel, _)| [(wheel, 1.0), (wheel, -1.0)]) {
                let kind = Kind::Wheel { wheel, sign, limit: limit.bounds[wheel] / (torque * time) };
                all.push(Self { name: limit.name.into(), kind });
            }
        }
        for constraint in &problem.constraints {
            let mut push = |kind| all.push(Self { name: constraint.name.clone(), kind });
            match &constraint.rule {
                Rule::RateNorm(limit) => push(Kind::Norm { limit: limit * time }),
                Rule::RateAxes(limits) => {
                    for (axis, sign) in (0..3).flat_map(|axis| [(axis, 1.0), (axis, -1.0)]) {
                        push(Kind::Axis { axis, sign, limit: limits[axis] * time });
                    }
                }
                Rule::Pointing(pointing) => {
                    let sign = match pointing.side {
                        Side::KeepOut => 1.0,
                        Side::KeepIn => -1.0,
                        Side::On { .. } => return None,
                    };
                    if pointing.during.given().is_some() {
                        return None;
                    }
                    let (sine, cosine) = pointing.effective_half_angle().sin_cos();
                    for (boresight, direction) in pointing.pairs() {
                        if matches!(direction, Direction::Disc { .. }) {
                            return None;
                        }
                        let (boresight, direction) = (*boresight, direction.clone());
                        push(Kind::Cone(Cone { boresight, direction, frame_rate, time, sign, cosine, sine }));
                    }
                }
            }
        }
        Some(all)
    }

    /// The two of an input that changes at a limited rate.
    pub fn of_ramp(name: &str, ramp: usize) -> [Self; 2] {
        [1.0, -1.0].map(|sign| Self { name: name.into(), kind: Kind::Ramp { ramp, sign } })
    }

    /// The number of the input that changes at a limited rate, and on which side of it this is.
    pub fn ramp(&self) -> Option<(usize, f64)> {
        match self.kind {
            Kind::Ramp { ramp, sign } => Some((ramp, sign)),
            _ => None,
        }
    }

    /// Whether it depends on the time.
    pub fn moves(&self) -> bool {
        matches!(&self.kind, Kind::Cone(cone) if !cone.direction.is_still(&cone.frame_rate))
    }

    /// How many times `c` is differentiated until an input shows.
    pub fn order(&self) -> usize {
        if matches!(self.kind, Kind::Cone { .. }) { 2 } else { 1 }
    }

    /// `c`, a share of the limit's size or, near the cone, the violation \[rad\].
    pub fn value(&self, state: &State) -> f64 {
        let rate = state.rate();
        match &self.kind {
            Kind::Axis { axis, sign, limit } => sign * rate[*axis] - limit,
            Kind::Norm { limit } => 0.5 * (rate.norm_squared() - limit * limit) / limit,
            Kind::Wheel { wheel, sign, limit } => sign * state.stored(*wheel) - limit,
            Kind::Ramp { ramp, sign } => sign * state.given(*ramp) - 1.0,
            Kind::Cone(cone) => {
                cone.sign * (cone.seen(state).direction.dot(&cone.boresight) - cone.cosine) / cone.sine
            }
        }
    }

    /// `ċ` of a limit of second order.
    pub fn slope(&self, state: &State) -> f64 {
        match &self.kind {
            Kind::Cone(cone) => {
                let seen = cone.seen(state);
                let turning = seen.direction.dot(&state.rate().cross(&cone.boresight));
                cone.sign * (turning + seen.rate.dot(&cone.boresight)) / cone.sine
            }
            Kind::Axis { .. } | Kind::Norm { .. } | Kind::Wheel { .. } | Kind::Ramp { .. } => 0.0,
        }
    }

    /// `ν` and `r`: `ν·ẏ + r` is the derivative of `c` in which inputs show.
    pub fn held(&self, state: &State) -> (Change, f64) {
        let rate = state.rate();
        let mut normal = Change::zeros();
        let mut of_rate = |vector: &Vector3| normal.fixed_rows_mut::<3>(at::RATE).copy_from(vector);
        let rest = match &self.kind {
            Kind::Axis { axis, sign, .. } => {
                of_rate(&Vector3::ith(*axis, *sign));
                0.0
            }
            Kind::Norm { limit } => {
                of_rate(&(rate / *limit));
                0.0
            }
            Kind::Wheel { wheel, sign, .. } => {
                normal[at::WHEELS + wheel] = *sign;
                0.0
            }
            Kind::Ramp { ramp, sign } => {
                normal[at::RAMPS + ramp] = *sign;
                0.0
            }
            Kind::Cone(cone) => {
                let (seen, b) = (cone.seen(state), &cone.boresight);
                let scale = cone.sign / cone.sine;
                of_rate(&(b.cross(&seen.direction) * scale));
                let turning = rate.cross(b);
                let twice = seen.direction.dot(&rate.cross(&turning)) + 2.0 * seen.rate.dot(&turning);
                scale * (twice + seen.acceleration.dot(b))
            }
        };
        (normal, rest)
    }
}
