//! How far a motion stays from every limit and constraint, at the nodes and on the arcs between them.
//!
//! On an arc the body turns at the one rate `f/h` about one axis, so the rate is checked there as at the
//! nodes, and every cone where its boresight is nearest to the rim ([`crate::maneuver::constraint::Arc`]). The torque of a
//! plan is held over each step, and the momentum of its wheels is linear there: their limits need the nodes only.
//!
//! That is the discrete motion. Under the same held torque the continuous one is a little elsewhere, and has
//! margins of its own ([`Margin::continuous_margin`]).

use crate::Vector3;
use crate::maneuver::constraint::{Arc, Constraint, Pointing, Rule, Side};
use crate::maneuver::problem::Problem;
use crate::mechanics::actuators::{ActuatorSet, LimitKind};
use crate::numerics::figures::short;
use serde::{Deserialize, Serialize};
use std::fmt;

/// How far a plan stays from one limit or constraint, at the nodes and on the arcs between them.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Margin {
    /// Name of the constraint, or "torque limit", "torque norm limit", "torque rate limit", "wheel torque
    /// limit", "wheel momentum limit" and the like.
    pub name: String,
    /// The smallest distance to the limit, in `unit`; negative: violated.
    pub margin: f64,
    /// The same of the continuous motion under the held torque, for rates and cones: it differs by the error
    /// of the discretisation.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub continuous_margin: Option<f64>,
    /// "deg", "deg/s", "N·m", "N·m/s", "N·m·s", "N", "N/s".
    pub unit: String,
    /// The same relative to the limit, or \[rad\] for a cone.
    pub scaled: f64,
    /// When \[s\].
    pub time_s: f64,
    /// Which input, axis, wheel, or pair of boresight and direction, in words; empty where there is one.
    pub at: String,
}

impl Margin {
    /// Whether the limit holds, to round-off ([`Margin::ROUND_OFF`]).
    pub fn holds(&self) -> bool {
        self.scaled >= -Self::ROUND_OFF
    }

    /// What a limit may be missed by, scaled, and still counts as held.
    pub const ROUND_OFF: f64 = 1e-9;
}

/// In words: `"torque limit" is missed by 0.32 N·m at t = 4.2 s (input 2)`.
impl fmt::Display for Margin {
    fn fmt(&self, f: &mut fmt::Formatter) -> fmt::Result {
        let (size, time) = (short(self.margin.abs()), short(self.time_s));
        let Self { name, unit, at, .. } = self;
        if self.holds() {
            write!(f, "\"{name}\" holds with {size} {unit} to spare, least at t = {time} s")?;
        } else {
            write!(f, "\"{name}\" is missed by {size} {unit} at t = {time} s")?;
        }
        if at.is_empty() { Ok(()) } else { write!(f, " ({at})") }
    }
}

/// The worst scaled violation among margins; 0 where all hold, NaN where one is NaN.
pub fn worst_violation(margins: &[Margin]) -> f64 {
    margins.iter().fold(0.0, |worst: f64, margin| {
        let violation = -margin.scaled;
        if violation > worst || violation.is_nan() { violation } else { worst }
    })
}

/// One limit or constraint and the smallest margin met so far.
struct Entry<'a> {
    name: String,
    unit: &'static str,
    what: What<'a>,
    smallest: Smallest,
}

/// What is held against what.
enum What<'a> {
    /// `|u_i|` of a channel, whose inputs begin at an offset in a row.
    Size(&'a [f64], usize),
    /// `|B u|`.
    Norm(&'a ActuatorSet, f64, usize),
    /// `|u_i⁺ − u_i| / h`.
    Slope(&'a [f64], usize),
    /// `|h_i|` of the wheels.
    Momentum(&'a [f64]),
    RateNorm(f64),
    RateAxes(Vector3),
    Pointing(&'a Pointing),
}

#[derive(Clone, Copy)]
struct Smallest {
    margin: f64,
    scaled: f64,
    time: f64,
    /// Which input, axis, wheel or pair.
    index: usize,
}

impl Smallest {
    /// Takes a smaller margin, or one that is NaN, for good.
    fn meet(&mut self, other: Self) {
        if !self.scaled.is_nan() && (other.scaled < self.scaled || other.scaled.is_nan()) {
            *self = other;
        }
    }

    /// Each value against its limit; infinite limits are none.
    fn meet_all(&mut self, values: impl IntoIterator<Item = (f64, f64)>, time: f64) {
        for (index, (value, limit)) in values.into_iter().enumerate() {
            if limit.is_finite() {
                let margin = limit - value.abs();
                self.meet(Self { margin, scaled: margin / limit, time, index });
            }
        }
    }
}

/// Meets a motion node by node and arc by arc, and keeps the smallest margins.
pub(crate) struct Meter<'a> {
    frame_rate: Vector3,
    step: f64,
    entries: Vec<Entry<'a>>,
}

impl<'a> Meter<'a> {
    pub(crate) fn new(problem: &'a Problem) -> Self {
        let actuation = &problem.actuation;
        let mut entries = vec![];
        let mut push = |name: &str, unit, what| {
            let smallest =
                Smallest { margin: f64::INFINITY, scaled: f64::INFINITY, time: f64::NAN, index: 0 };
            entries.push(Entry { name: name.into(), unit, what, smallest });
        };
        let mut channel = |channel: &'a ActuatorSet, offset, force| {
            let limits = channel.limits();
            let name = |kind| actuation.limit_name(kind, force);
            let (unit, per_second) = if force { ("N", "N/s") } else { ("N·m", "N·m/s") };
            if let Some(size) = &limits.size {
                push(name(LimitKind::Size), unit, What::Size(size, offset));
            }
            if let Some(norm) = limits.norm {
                push(name(LimitKind::Norm), unit, What::Norm(channel, norm, offset));
            }
            if let Some(rate) = &limits.rate {
                push(name(LimitKind::Rate), per_second, What::Slope(rate, offset));
            }
            if let Some(wheels) = actuation.wheels.as_ref().filter(|_| !force)
                && wheels.momentum_limit.iter().any(|limit| limit.is_finite())
            {
                push(name(LimitKind::WheelMomentum), "N·m·s", What::Momentum(&wheels.momentum_limit));
            }
        };
        channel(&actuation.torque, actuation.force.as_ref().map_or(0, ActuatorSet::count), false);
        if let Some(force) = &actuation.force {
            channel(force, 0, true);
        }
        for Constraint { name, rule } in &problem.constraints {
            match rule {
                Rule::RateNorm(limit) => push(name, "deg/s", What::RateNorm(*limit)),
                Rule::RateAxes(limits) => push(name, "deg/s", What::RateAxes(*limits)),
                Rule::Pointing(pointing) => push(name, "deg", What::Pointing(pointing)),
            }
        }
        Self { frame_rate: problem.environment.frame_rate(), step: problem.step(), entries }
    }

    /// For a motion met every `step` \[s\].
    pub(crate) fn every(step: f64, problem: &'a Problem) -> Self {
        Self { step, ..Self::new(problem) }
    }

    /// A row of inputs at `time`, after the row `before` one step earlier.
    pub(crate) fn inputs(&mut self, time: f64, row: &[f64], before: Option<&[f64]>) {
        let step = self.step;
        for Entry { what, smallest, .. } in &mut self.entries {
            match what {
                What::Size(limits, offset) => {
                    smallest.meet_all(pairs(&row[*offset..], limits), time);
                }
                What::Norm(channel, limit, offset) => {
                    let inputs = &row[*offset..*offset + channel.count()];
                    smallest.meet_all([(channel.output(inputs).norm(), *limit)], time);
                }
                What::Slope(limits, offset) => {
                    let Some(before) = before else { continue };
                    let slopes = row.iter().zip(before).skip(*offset).map(|(now, then)| (now - then) / step);
                    smallest.meet_all(slopes.zip(limits.iter().copied()), time);
                }
                _ => {}
            }
        }
    }

    /// The momenta of the wheels at `time`.
    pub(crate) fn wheels(&mut self, time: f64, momenta: &[f64]) {
        for Entry { what, smallest, .. } in &mut self.entries {
            if let What::Momentum(limits) = what {
                smallest.meet_all(pairs(momenta, limits), time);
            }
        }
    }

    /// An angular velocity, body axes, at `time`.
    pub(crate) fn rate(&mut self, time: f64, rate: &Vector3) {
        for Entry { what, smallest, .. } in &mut self.entries {
            match what {
                What::RateNorm(limit) => smallest.meet_all([(rate.norm(), *limit)], time),
                What::RateAxes(limits) => smallest.meet_all(pairs(rate.as_slice(), limits.as_slice()), time),
                _ => {}
            }
        }
    }

    /// One step from `time` along `arc`, at its one rate.
    pub(crate) fn arc(&mut self, time: f64, arc: &Arc) {
        let (step, frame_rate) = (self.step, self.frame_rate);
        self.rate(time + 0.5 * step, &(arc.turn / step));
        let travel = arc.turn.norm() + frame_rate.norm() * step;
        for Entry { what, smallest, .. } in &mut self.entries {
            let What::Pointing(pointing) = what else { continue };
            let limit = pointing.effective_half_angle();
            let margin = |angle: f64| match pointing.side {
                Side::KeepOut => angle - limit,
                Side::KeepIn => limit - angle,
            };
            for (index, (boresight, direction)) in pointing.pairs().enumerate() {
                let target = direction.on_arc(time, step, &frame_rate);
                // Too far away to come nearer than ever before: no extremum needed.
                if margin(arc.angle(boresight, &target, 0.0)) - travel > smallest.scaled {
                    continue;
                }
                let worst = arc.extreme(boresight, &target, pointing.side);
                let scaled = margin(worst.angle);
                let time = time + worst.part * step;
                smallest.meet(Smallest { margin: scaled, scaled, time, index });
            }
        }
    }

    /// What was met. A limit that nothing was held against has no margin, and that is NaN.
    pub(crate) fn margins(&self) -> Vec<Margin> {
        self.entries.iter().map(Entry::margin).collect()
    }
}

fn pairs<'a>(values: &'a [f64], limits: &'a [f64]) -> impl Iterator<Item = (f64, f64)> + 'a {
    values.iter().copied().zip(limits.iter().copied())
}

impl Entry<'_> {
    fn margin(&self) -> Margin {
        let Smallest { margin, scaled, time, index } = self.smallest;
        let margin = if self.unit.starts_with("deg") { margin.to_degrees() } else { margin };
        let met = |value: f64| if value == f64::INFINITY { f64::NAN } else { value };
        Margin {
            name: self.name.clone(),
            margin: met(margin),
            continuous_margin: None,
            unit: self.unit.into(),
            scaled: met(scaled),
            time_s: time,
            at: self.which(index),
        }
    }

    /// Which of several.
    fn which(&self, index: usize) -> String {
        let one_of = |what: &str, index: usize, count: usize| {
            if count > 1 { format!("{what} {}", index + 1) } else { String::new() }
        };
        match &self.what {
            What::Size(limits, _) | What::Slope(limits, _) => {
                let what = if self.name.starts_with("wheel") { "wheel" } else { "input" };
                one_of(what, index, limits.len())
            }
            What::Momentum(limits) => one_of("wheel", index, limits.len()),
            What::Norm(..) | What::RateNorm(_) => String::new(),
            What::RateAxes(_) => format!("axis {}", ["x", "y", "z"][index]),
            What::Pointing(pointing) => {
                let (boresights, directions) = (pointing.boresights.len(), pointing.directions.len());
                let words = [
                    one_of("boresight", index / directions, boresights),
                    one_of("direction", index % directions, directions),
                ];
                words.into_iter().filter(|word| !word.is_empty()).collect::<Vec<_>>().join(", ")
            }
        }
    }
}
