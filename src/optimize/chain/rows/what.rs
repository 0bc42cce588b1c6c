//! The kinds of limit rows, and their values at a stage.

use super::super::model::Model;
use super::boresight::{Bend, BoresightArc};
use crate::maneuver::constraint::{Direction, During, Pointing, Rule, Side, angle_between, on_arc};
use crate::maneuver::problem::{Problem, State};
use crate::optimize::chain::model::step;
use crate::{Matrix3, Vector3, lie};

/// Quantity that a row bounds, and its limit.
#[derive(Clone, Debug)]
pub(crate) enum What {
    /// Input limit, `sign u_i ≤ limit`.
    InputSize { input: usize, sign: f64, limit: f64 },
    /// Limit on the change of an input between this stage and the next, `sign (u⁺_i − u_i) ≤
    /// limit`.
    InputRate { input: usize, sign: f64, limit: f64 },
    /// Limit on the norm of the forces or the torques, `|B u| ≤ limit`.
    InputNorm { forces: bool, limit: f64 },
    /// Limit on the norm of the angular velocity, `|Ω| ≤ limit`, at the node or on the arc that
    /// begins at the node.
    RateNorm { arc: bool, limit: f64 },
    /// Limit on the angular rate about one body axis, `sign Ω_axis ≤ limit`.
    RateAxis { arc: bool, axis: usize, sign: f64, limit: f64 },
    /// Boresight constraint `sign (w·R b) ≤ sign cos α`, which may be limited to intervals of time,
    /// or the equation `w·R b = cos α` at a node.
    Cone(Cone),
    /// Limit of a wheel's momentum, `sign h_i ≤ limit`.
    Wheel { wheel: usize, sign: f64, limit: f64 },
    /// Lower bound of a one-sided input, `u_i ≥ 0`, scaled by the input's upper limit.
    Push { input: usize, limit: f64 },
    /// Imposes no bound: marks a two-sided input whose fuel is charged, in units of its limit.
    Burn { input: usize, limit: f64 },
    /// Imposes no bound: marks forces or torques whose fuel is charged by their norm.
    BurnOfNorm { forces: bool, limit: f64 },
}

/// Constraint of a boresight by a cone, at a node or on the arc that begins at the node.
#[derive(Clone, Debug)]
pub(crate) struct Cone {
    arc: bool,
    boresight: Vector3,
    direction: Direction,
    sign: f64,
    half_angle: f64,
    during: During,
    /// If the boresight is held on the cone: its deviations from the cone at the start and at the
    /// end of the maneuver \[rad\], interpolated linearly in between. They are due to rounding, or
    /// to the end that the landing has shifted. `None` for keep-in and keep-out cones.
    on: Option<[f64; 2]>,
}

/// Tolerance, as a fraction of the duration, with which the time at which a cone becomes active or
/// inactive is identified with a node. Without it, round-off could omit the node's row or add it
/// twice.
const EDGE: f64 = 1e-12;

impl What {
    /// Returns the rows of a constraint at a node or on an arc.
    pub(super) fn of(problem: &Problem, rule: &Rule, arc: bool) -> Vec<Self> {
        let duration = problem.seconds();
        match rule {
            Rule::RateNorm(limit) => vec![Self::RateNorm { arc, limit: limit * duration }],
            Rule::RateAxes(limits) => {
                let row = |axis: usize, sign: f64| Self::RateAxis {
                    arc,
                    axis,
                    sign,
                    limit: limits[axis] * duration,
                };
                (0..3).flat_map(|axis| [row(axis, 1.0), row(axis, -1.0)]).collect()
            }
            Rule::Pointing(pointing) => {
                let on = matches!(pointing.side, Side::On { .. });
                let sign = if pointing.side == Side::KeepIn { -1.0 } else { 1.0 };
                if on && arc {
                    // The boresight is held on the cone at the nodes only: an arc between them has
                    // no inputs of its own to follow the cone.
                    return Vec::new();
                }
                let half_angle = pointing.effective_half_angle();
                let cone = |(boresight, direction): (&Vector3, &Direction)| {
                    let (boresight, direction) = (*boresight, direction.clone());
                    let during = pointing.during.clone();
                    let on = on.then(|| off_at_ends(problem, pointing, &boresight, &direction));
                    Self::Cone(Cone { arc, boresight, direction, sign, half_angle, during, on })
                };
                pointing.pairs().map(cone).collect()
            }
        }
    }

    /// Returns the exponent of the duration `s` in the limit.
    pub fn growth(&self) -> i32 {
        match self {
            Self::Cone(_) | Self::Push { .. } | Self::Burn { .. } | Self::BurnOfNorm { .. } => 0,
            Self::RateNorm { .. } | Self::RateAxis { .. } | Self::Wheel { .. } => 1,
            Self::InputSize { .. } | Self::InputNorm { .. } => 2,
            Self::InputRate { .. } => 3,
        }
    }

    /// Returns whether the row depends on the state and not only on the inputs.
    pub fn is_of_state(&self) -> bool {
        matches!(self, Self::RateNorm { .. } | Self::RateAxis { .. } | Self::Cone(_) | Self::Wheel { .. })
    }

    /// Returns whether the row is an equation.
    pub fn is_equation(&self) -> bool {
        matches!(self, Self::Cone(Cone { on: Some(_), .. }))
    }

    /// Returns whether the row is a ball `|v| ≤ 1`.
    pub fn is_ball(&self) -> bool {
        matches!(self, Self::InputNorm { .. } | Self::RateNorm { .. })
    }
}

/// Returns the deviation of a boresight from the cone on which it is held \[rad\], at the start and
/// at the end of the maneuver; 0 if the cone is not active at that time, or if the end attitude is
/// free.
fn off_at_ends(
    problem: &Problem,
    pointing: &Pointing,
    boresight: &Vector3,
    direction: &Direction,
) -> [f64; 2] {
    let frame_rate = problem.environment.frame_rate();
    let off = |state: &State, time: f64| {
        let angle = angle_between(&(state.attitude * boresight), &direction.at(time, &frame_rate));
        angle - pointing.effective_half_angle() - direction.angular_radius(time)
    };
    let end = problem.duration.known().filter(|_| !problem.ends_in_any_attitude());
    let ends = [(&problem.start, Some(0.0)), (&problem.end, end)];
    ends.map(|(state, time)| {
        let acting = time.filter(|time| pointing.during.contains(*time));
        acting.map_or(0.0, |time| off(state, time))
    })
}

/// Value of a cone's row at a node or on an arc, and its derivatives with respect to the rotation
/// of the attitude, the arc `log F`, and `ln s`.
#[derive(Clone, Copy, Debug)]
pub(crate) struct ConeAt {
    pub c: f64,
    pub by_attitude: Vector3,
    pub by_arc: Vector3,
    pub by_duration: f64,
    /// Fraction of the arc at which the row is evaluated: 0 at its start and 1 at its end.
    pub fraction: f64,
}

impl Cone {
    /// Returns whether this is the row of an arc.
    pub(crate) fn is_of_arc(&self) -> bool {
        self.arc
    }

    /// Returns whether both rows belong to the same cone, each at a node or on an arc.
    pub(crate) fn is_same_as(&self, other: &Self) -> bool {
        self.boresight == other.boresight
            && self.sign == other.sign
            && self.half_angle == other.half_angle
            && self.direction == other.direction
            && self.during == other.during
    }

    /// Returns whether this row is at a node and `other` is the row of an arc for the same cone.
    pub(crate) fn is_node_of(&self, other: &Self) -> bool {
        !self.arc && other.arc && self.is_same_as(other)
    }

    /// Evaluates the row at the attitude of stage `stage`, or at its largest value along the arc
    /// that begins there. If `closed`, the ends of the arc are included; otherwise only a maximum
    /// between them counts. Returns `None` if the cone is not active or no such maximum exists.
    pub(crate) fn met(
        &self,
        model: &Model,
        stage: usize,
        (attitude, stretch): (&Matrix3, f64),
        arc: Option<&Vector3>,
        closed: bool,
    ) -> Option<ConeAt> {
        self.meeting(model, stage, (attitude, stretch), arc, closed)
            .map(|meeting| self.slopes(model, &meeting, arc))
    }

    /// Returns the value of the row at a node or on a closed arc; `None` if the cone is not active.
    pub(crate) fn value(
        &self,
        model: &Model,
        stage: usize,
        at: (&Matrix3, f64),
        arc: Option<&Vector3>,
    ) -> Option<f64> {
        let meeting = self.meeting(model, stage, at, arc, true)?;
        let (value, _) = meeting.pointing.at(meeting.fraction);
        Some(value / meeting.pointing.cone[0].sin())
    }

    /// Returns the row at a node or on a closed arc, with its second derivatives with respect to
    /// attitude and arc; `None` if the cone is not active.
    pub(crate) fn bent(
        &self,
        model: &Model,
        stage: usize,
        at: (&Matrix3, f64),
        arc: Option<&Vector3>,
    ) -> Option<(ConeAt, Bend)> {
        let meeting = self.meeting(model, stage, at, arc, true)?;
        let Meeting { fraction, acting: [low, high], .. } = meeting;
        let bend = meeting.pointing.bend(fraction, arc.is_some() && fraction > low && fraction < high);
        Some((self.slopes(model, &meeting, arc), bend.scaled(1.0 / meeting.pointing.cone[0].sin())))
    }

    /// Returns whether the row and its derivatives are independent of the duration.
    pub(crate) fn stands(&self, model: &Model) -> bool {
        matches!(self.direction, Direction::Fixed(_))
            && self.during.given().is_none()
            && step::frame_rate(model) == Vector3::zeros()
    }

    /// Returns the point at which the row is evaluated; `None` if the row does not apply.
    fn meeting(
        &self,
        model: &Model,
        stage: usize,
        (attitude, stretch): (&Matrix3, f64),
        arc: Option<&Vector3>,
        closed: bool,
    ) -> Option<Meeting> {
        let (unit, grid) = (model.dynamics.units.time, &model.dynamics.grid);
        // Rates and times are in 1/s and s here, because directions are functions of time in
        // seconds.
        let (frame_rate, seconds) = (step::frame_rate(model) / unit, unit * stretch);
        let (time, step) = (grid.after(stage) * seconds, arc.map_or(0.0, |_| grid.step(stage) * seconds));
        let near = EDGE * grid.duration() * seconds;
        let acting = match arc {
            Some(_) => self.during.hull(time + near, step - 2.0 * near),
            None => self.during.hull(time - near, 2.0 * near).map(|_| [0.0, 0.0]),
        }?;
        let target = on_arc(&self.direction, time, step, &frame_rate);
        // The deviation of the cone is interpolated linearly between the two ends of the maneuver.
        let part = grid.after(stage) / grid.duration();
        let along = arc.map_or(0.0, |_| grid.step(stage) / grid.duration());
        let [off, opened] =
            self.on.map_or([0.0; 2], |[first, last]| [first + part * (last - first), along * (last - first)]);
        // The turn of the direction is expressed in the axes of the reference frame at the
        // beginning of the arc.
        let turn = if frame_rate == Vector3::zeros() {
            target.turn
        } else {
            lie::exp(&(frame_rate * -time)) * target.turn
        };
        let pointing = BoresightArc {
            attitude: *attitude,
            boresight: self.boresight,
            direction: self.direction.at(time, &frame_rate),
            turn,
            arc: arc.copied().unwrap_or_else(Vector3::zeros),
            sign: self.sign,
            cone: [self.half_angle + target.radius + off, target.growth + opened],
        };
        let fraction = match arc {
            None => 0.0,
            Some(_) if closed => pointing.highest(acting),
            Some(_) => pointing.extremum(acting)?,
        };
        Some(Meeting { pointing, frame_rate, time, step, acting, fraction })
    }

    /// Computes the value of the row at its point, with its derivatives.
    fn slopes(&self, model: &Model, meeting: &Meeting, arc: Option<&Vector3>) -> ConeAt {
        let Meeting { pointing, frame_rate, time, step, acting, fraction } = meeting;
        let (time, step, fraction) = (*time, *step, *fraction);
        let (value, slope) = pointing.at(fraction);
        // The scale converts the value to the violation in rad near the edge of the cone.
        let scale = pointing.cone[0].sin().recip();
        let (mut by_attitude, mut by_arc) = (slope * scale, Vector3::zeros());
        if let Some(turn) = arc {
            let arrived = lie::exp(&(turn * -fraction));
            by_attitude = arrived.tr_mul(&slope) * scale;
            let along = lie::right_jacobian(&(turn * fraction)) * fraction;
            by_arc = along.tr_mul(&slope) * scale;
        }
        let mut by_duration = 0.0;
        if model.duration.is_some() && !self.stands(model) {
            // For a disc the half angle and the scale change.
            let by_time = |time: f64| self.direction.angular_radius_rate(time) * time;
            let grown = by_time(time) + fraction * (by_time(time + step) - by_time(time));
            let grown = self.sign * pointing.half_angle(fraction).sin() * grown;
            let scaled = value * scale * pointing.cone[0].cos() * by_time(time);
            let passed = match &self.direction {
                Direction::Fixed(_) => frame_rate * -time,
                Direction::InFrame(_) => pointing.turn * fraction,
                Direction::Moving(_) | Direction::Disc { .. } => {
                    // On an arc the direction turns at one rate from its first to its last
                    // position.
                    let [first, last] = [time, time + step].map(|at| self.direction.in_space(at, frame_rate));
                    let ends = [first.direction, last.direction];
                    let (turn, slope) =
                        turn_between_moving(ends, [first.rate * time, last.rate * (time + step)]);
                    let reached = lie::exp(&(turn * fraction));
                    let slid = lie::left_jacobian(&(turn * fraction)) * slope * fraction;
                    let begun = reached * first.direction.cross(&(first.rate * time));
                    let passed = lie::exp(&(frame_rate * -time)) * (begun + slid);
                    passed - frame_rate * time
                }
            };
            // A time at which the cone begins or ceases to be active is fixed while the nodes move
            // with the duration.
            let is_edge = fraction > 0.0 && fraction < 1.0 && acting.contains(&fraction);
            let slid = if is_edge { pointing.slope(fraction) * (time / step + fraction) } else { 0.0 };
            by_duration = (pointing.along(fraction, &passed) + grown - scaled - slid) * scale;
        }
        ConeAt { c: value * scale, by_attitude, by_arc, by_duration, fraction }
    }
}

/// Returns the rotation vector `φ a×b`, `φ = θ/sin θ`, of the shortest rotation from the unit
/// vector a to b, and its derivative when the two vectors change by da and db.
fn turn_between_moving([a, b]: [Vector3; 2], [da, db]: [Vector3; 2]) -> (Vector3, Vector3) {
    let (axis, cosine) = (a.cross(&b), a.dot(&b));
    let squared = axis.norm_squared();
    let angle = squared.sqrt().atan2(cosine);
    // dφ/d cos θ = (φ cos θ − 1)/sin² θ; the difference cancels for small angles.
    let (stretch, slope) = if squared < 1e-6 {
        (1.0 + angle * angle / 6.0, -1.0 / 3.0)
    } else {
        let stretch = angle / squared.sqrt();
        (stretch, (stretch * cosine - 1.0) / squared)
    };
    let change = da.cross(&b) + a.cross(&db);
    (axis * stretch, change * stretch + axis * (slope * (da.dot(&b) + a.dot(&db))))
}

/// Point at which a cone's row is evaluated.
struct Meeting {
    pointing: BoresightArc,
    /// Angular velocity of the reference frame [rad/s].
    frame_rate: Vector3,
    /// Start and length of the arc \[s\].
    time: f64,
    step: f64,
    /// Interval of fractions of the arc in which the cone is active.
    acting: [f64; 2],
    fraction: f64,
}
