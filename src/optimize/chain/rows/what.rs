//! What one row bounds, and what it is worth at a stage.

use super::super::model::Model;
use super::boresight::{Bend, BoresightArc};
use crate::maneuver::constraint::{Direction, During, Pointing, Rule, Side, angle_between, on_arc};
use crate::maneuver::problem::{Problem, State};
use crate::optimize::chain::model::step;
use crate::{Matrix3, Vector3, lie};

/// What one row bounds.
#[derive(Clone, Debug)]
pub(crate) enum What {
    /// `sign u_i ≤ limit`.
    InputSize { input: usize, sign: f64, limit: f64 },
    /// `sign (u⁺_i − u_i) ≤ limit`, from this stage to the next.
    InputRate { input: usize, sign: f64, limit: f64 },
    /// `|B u| ≤ limit`, forces or torques.
    InputNorm { forces: bool, limit: f64 },
    /// `|Ω| ≤ limit`, at the node or on the arc that begins here.
    RateNorm { arc: bool, limit: f64 },
    /// `sign Ω_axis ≤ limit`.
    RateAxis { arc: bool, axis: usize, sign: f64, limit: f64 },
    /// `sign (w·R b) ≤ sign cos α`, at times; or `w·R b = cos α` at the node.
    Cone(Cone),
    /// `sign h_i ≤ limit` of a wheel's momentum.
    Wheel { wheel: usize, sign: f64, limit: f64 },
    /// `u_i ≥ 0`, as a part of its limit.
    Push { input: usize, limit: f64 },
    /// Nothing: the fuel of an input with two sides is counted, in units of its limit.
    Burn { input: usize, limit: f64 },
    /// Nothing: the fuel of a set is counted by the norm of what it gives.
    BurnOfNorm { forces: bool, limit: f64 },
}

/// A boresight and a cone, at a node or on the arc that begins there.
#[derive(Clone, Debug)]
pub(crate) struct Cone {
    arc: bool,
    boresight: Vector3,
    direction: Direction,
    sign: f64,
    half_angle: f64,
    during: During,
    /// Where the boresight is held on it: by how much it is off at the start and at the end
    /// \[rad\], and on the way from the one to the other between them. An end may be off by
    /// rounding, or by what a landing makes up for.
    on: Option<[f64; 2]>,
}

/// A time at which a cone begins or ceases to act is that of a node within this part of the
/// duration: rounded otherwise, the row of the node would be missing, or stand there twice.
const EDGE: f64 = 1e-12;

impl What {
    /// What a constraint of a maneuver bounds at a node or on an arc.
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
                    // Nodes are held on it: an arc between them has no inputs of its own to follow
                    // it by.
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

    /// Power of the duration with which the limit grows.
    pub fn growth(&self) -> i32 {
        match self {
            Self::Cone(_) | Self::Push { .. } | Self::Burn { .. } | Self::BurnOfNorm { .. } => 0,
            Self::RateNorm { .. } | Self::RateAxis { .. } | Self::Wheel { .. } => 1,
            Self::InputSize { .. } | Self::InputNorm { .. } => 2,
            Self::InputRate { .. } => 3,
        }
    }

    /// Whether it bounds the state, and not the inputs alone.
    pub fn is_of_state(&self) -> bool {
        matches!(self, Self::RateNorm { .. } | Self::RateAxis { .. } | Self::Cone(_) | Self::Wheel { .. })
    }

    /// Whether it is an equation.
    pub fn is_equation(&self) -> bool {
        matches!(self, Self::Cone(Cone { on: Some(_), .. }))
    }

    /// Whether it is a ball.
    pub fn is_ball(&self) -> bool {
        matches!(self, Self::InputNorm { .. } | Self::RateNorm { .. })
    }
}

/// By how much a boresight is off a cone that it is held on \[rad\], at the start and at the end; 0
/// where the cone does not act then, and where the end is not known.
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

/// A cone's row at a node or on an arc, with its derivatives by the turn of the attitude, the arc
/// `log F`, and `ln s`.
#[derive(Clone, Copy, Debug)]
pub(crate) struct ConeAt {
    pub c: f64,
    pub by_attitude: Vector3,
    pub by_arc: Vector3,
    pub by_duration: f64,
    /// Where on the arc it is met: 0 and 1 at its ends.
    pub fraction: f64,
}

impl Cone {
    /// Whether it is one of an arc.
    pub(crate) fn is_of_arc(&self) -> bool {
        self.arc
    }

    /// Whether it is the same cone as another, at a node or on an arc.
    pub(crate) fn is_same_as(&self, other: &Self) -> bool {
        self.boresight == other.boresight
            && self.sign == other.sign
            && self.half_angle == other.half_angle
            && self.direction == other.direction
            && self.during == other.during
    }

    /// Whether it is the same cone at a node as another one on an arc.
    pub(crate) fn is_node_of(&self, other: &Self) -> bool {
        !self.arc && other.arc && self.is_same_as(other)
    }

    /// The row at the attitude of stage `stage` and along the arc from there, at its highest point:
    /// that of the arc with its ends where it is `closed`, else of what lies between them. `None`
    /// where it does not act.
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

    /// Returns the value of the row on a closed arc, or at a node.
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

    /// Returns the row on a closed arc, or at a node, with its second derivatives by attitude and
    /// arc.
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

    /// Whether neither the row nor its derivatives know the duration.
    pub(crate) fn stands(&self, model: &Model) -> bool {
        matches!(self.direction, Direction::Fixed(_))
            && self.during.given().is_none()
            && step::frame_rate(model) == Vector3::zeros()
    }

    /// Returns where the row is met.
    fn meeting(
        &self,
        model: &Model,
        stage: usize,
        (attitude, stretch): (&Matrix3, f64),
        arc: Option<&Vector3>,
        closed: bool,
    ) -> Option<Meeting> {
        let (unit, grid) = (model.dynamics.units.time, &model.dynamics.grid);
        // In seconds, as directions know the time.
        let (frame_rate, seconds) = (step::frame_rate(model) / unit, unit * stretch);
        let (time, step) = (grid.after(stage) * seconds, arc.map_or(0.0, |_| grid.step(stage) * seconds));
        let near = EDGE * grid.duration() * seconds;
        let acting = match arc {
            Some(_) => self.during.hull(time + near, step - 2.0 * near),
            None => self.during.hull(time - near, 2.0 * near).map(|_| [0.0, 0.0]),
        }?;
        let target = on_arc(&self.direction, time, step, &frame_rate);
        // What the cone is opened by at the ends goes linearly from one to the other.
        let part = grid.after(stage) / grid.duration();
        let along = arc.map_or(0.0, |_| grid.step(stage) / grid.duration());
        let [off, opened] =
            self.on.map_or([0.0; 2], |[first, last]| [first + part * (last - first), along * (last - first)]);
        let acts_at_end = arc.is_some() && stage + 1 == model.steps && acting[1] >= 1.0;
        let given = if acts_at_end { self.opened_at_end(model, time + step, &frame_rate) } else { 0.0 };
        // In the axes of the reference frame as it stands when the arc begins.
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
            cone: [self.half_angle + target.radius + off, target.growth + opened + given],
        };
        let fraction = match arc {
            None => 0.0,
            Some(_) if closed => pointing.highest(acting),
            Some(_) => pointing.extremum(acting)?,
        };
        Some(Meeting { pointing, frame_rate, time, step, acting, fraction })
    }

    /// Returns the change of the half angle \[rad\] over the last arc with which the cone admits the
    /// attitude at the end, `time` seconds from the start: zero if the cone admits it already.
    ///
    /// A landing shifts the end of the discrete motion, so that the true motion ends where the
    /// maneuver does. The shifted end may lie on the other side of a cone whose edge the maneuver
    /// ends on. The change is twice what the end lacks, so that the row is not active at the end.
    fn opened_at_end(&self, model: &Model, time: f64, frame_rate: &Vector3) -> f64 {
        let Some(end) = model.attitude_at_end() else { return 0.0 };
        let angle = angle_between(&(end * self.boresight), &self.direction.at(time, frame_rate));
        let beyond = angle - self.half_angle - self.direction.angular_radius(time);
        if self.sign * beyond < 0.0 { 2.0 * beyond } else { 0.0 }
    }

    /// The row where it is met, with its derivatives.
    fn slopes(&self, model: &Model, meeting: &Meeting, arc: Option<&Vector3>) -> ConeAt {
        let Meeting { pointing, frame_rate, time, step, acting, fraction } = meeting;
        let (time, step, fraction) = (*time, *step, *fraction);
        let (value, slope) = pointing.at(fraction);
        // Near the edge of the cone this is the violation in rad.
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
            // Of a disc the half angle and the scale move.
            let by_time = |time: f64| self.direction.angular_radius_rate(time) * time;
            let grown = by_time(time) + fraction * (by_time(time + step) - by_time(time));
            let grown = self.sign * pointing.half_angle(fraction).sin() * grown;
            let scaled = value * scale * pointing.cone[0].cos() * by_time(time);
            let passed = match &self.direction {
                Direction::Fixed(_) => frame_rate * -time,
                Direction::InFrame(_) => pointing.turn * fraction,
                Direction::Moving(_) | Direction::Disc { .. } => {
                    // On an arc it turns at one rate from its first to its last position.
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
            // A moment at which it begins or ends to act stays where it is while the nodes go by.
            let is_edge = fraction > 0.0 && fraction < 1.0 && acting.contains(&fraction);
            let slid = if is_edge { pointing.slope(fraction) * (time / step + fraction) } else { 0.0 };
            by_duration = (pointing.along(fraction, &passed) + grown - scaled - slid) * scale;
        }
        ConeAt { c: value * scale, by_attitude, by_arc, by_duration, fraction }
    }
}

/// The rotation vector of the shortest turn from one unit vector to another, and its derivative as
/// they move: `φ a×b`, `φ = θ/sin θ`.
fn turn_between_moving([a, b]: [Vector3; 2], [da, db]: [Vector3; 2]) -> (Vector3, Vector3) {
    let (axis, cosine) = (a.cross(&b), a.dot(&b));
    let squared = axis.norm_squared();
    let angle = squared.sqrt().atan2(cosine);
    // dφ/d cos θ = (φ cos θ − 1)/sin² θ, which cancels for small angles.
    let (stretch, slope) = if squared < 1e-6 {
        (1.0 + angle * angle / 6.0, -1.0 / 3.0)
    } else {
        let stretch = angle / squared.sqrt();
        (stretch, (stretch * cosine - 1.0) / squared)
    };
    let change = da.cross(&b) + a.cross(&db);
    (axis * stretch, change * stretch + axis * (slope * (da.dot(&b) + a.dot(&db))))
}

/// Where a cone's row is met.
struct Meeting {
    pointing: BoresightArc,
    /// [rad/s]
    frame_rate: Vector3,
    /// When the arc begins, and how long it takes \[s\].
    time: f64,
    step: f64,
    /// Fractions of the arc between which the cone acts.
    acting: [f64; 2],
    fraction: f64,
}
