//! Limits of the state as functions of it, with what an input must do to stay on them.
//!
//! ```text
//! c = ±Ω_i − L                       ċ = ±Ω̇_i                                                          order 1
//! c = (Ω·Ω − L²)/2L                  ċ = Ω·Ω̇ / L                                                       order 1
//! c = ±(w·R b − cos α)/sin α         ċ = ±d·(Ω×b)/sin α ,   c̈ = ±[d·(Ω×(Ω×b)) + (b×d)·Ω̇]/sin α         order 2
//! ```
//!
//! with the direction `d = Rᵀw` in body axes. The last derivative of each is linear in `Ω̇`: `ν·Ω̇ + r`. It vanishes along an arc that
//! holds the limit.

use super::state::State;
use crate::Vector3;
use crate::maneuver::constraint::{Direction, Rule, Side};
use crate::maneuver::problem::Problem;

/// A limit of the state: `c ≤ 0`.
#[derive(Clone, Debug)]
pub(crate) struct Limit {
    /// Which constraint of the maneuver it belongs to.
    pub constraint: usize,
    kind: Kind,
}

#[derive(Clone, Debug)]
enum Kind {
    Axis { axis: usize, sign: f64, limit: f64 },
    Norm { limit: f64 },
    Cone { boresight: Vector3, direction: Vector3, sign: f64, cosine: f64, sine: f64 },
}

impl Limit {
    /// Those of a maneuver, in a unit of time and in the axes of the start; `None` where one moves, acts at times, or is an equation.
    pub fn all(problem: &Problem, time: f64) -> Option<Vec<Self>> {
        let mut all = Vec::new();
        for (constraint, rule) in problem.constraints.iter().map(|constraint| &constraint.rule).enumerate() {
            let mut push = |kind| all.push(Self { constraint, kind });
            match rule {
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
                        let Direction::Fixed(fixed) = direction else { return None };
                        let direction = problem.start.attitude.tr_mul(fixed);
                        push(Kind::Cone { boresight: *boresight, direction, sign, cosine, sine });
                    }
                }
            }
        }
        Some(all)
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
            Kind::Cone { boresight, direction, sign, cosine, sine } => {
                sign * (state.in_body_axes(direction).dot(boresight) - cosine) / sine
            }
        }
    }

    /// `ċ` of a limit of second order.
    pub fn slope(&self, state: &State) -> f64 {
        match &self.kind {
            Kind::Cone { boresight, direction, sign, sine, .. } => {
                sign * state.in_body_axes(direction).dot(&state.rate().cross(boresight)) / sine
            }
            Kind::Axis { .. } | Kind::Norm { .. } => 0.0,
        }
    }

    /// `ν` and `r`: `ν·Ω̇ + r` is the derivative of `c` in which inputs show.
    pub fn held(&self, state: &State) -> (Vector3, f64) {
        let rate = state.rate();
        match &self.kind {
            Kind::Axis { axis, sign, .. } => (Vector3::ith(*axis, *sign), 0.0),
            Kind::Norm { limit } => (rate / *limit, 0.0),
            Kind::Cone { boresight, direction, sign, sine, .. } => {
                let direction = state.in_body_axes(direction);
                let turning = direction.dot(&rate.cross(&rate.cross(boresight)));
                (boresight.cross(&direction) * (sign / sine), sign * turning / sine)
            }
        }
    }
}
