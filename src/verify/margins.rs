//! The margins of a motion to every limit and constraint, at the nodes and on the arcs between
//! them.
//!
//! On an arc the body turns at the rate `f/h` about one axis, and this rate is checked like the
//! rates at the nodes. Every cone is checked where its boresight is nearest to the edge
//! ([`crate::maneuver::constraint::Arc`]). The torque of a plan is held over each step, and the
//! momentum of its wheels is linear in time over a step, so their limits need to be checked at the
//! nodes only.
//!
//! These are margins of the discrete motion. The continuous motion under the held torque differs
//! slightly and has its own margins ([`Margin::continuous_margin`]).

mod at_nodes;

pub use at_nodes::{ConeAngle, NodeMargins, cone_angles, margins_at_nodes};

use crate::Vector3;
use crate::maneuver::constraint::{Arc, Constraint, Rule, on_arc};
use crate::maneuver::problem::Problem;
use crate::mechanics::actuators::{InputLimit, LimitKind};
use crate::numerics::figures::short;
use serde::{Deserialize, Serialize};
use std::fmt;

/// The margin of a plan to one limit or constraint: the smallest at the nodes and on the arcs
/// between.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[non_exhaustive]
pub struct Margin {
    /// Name of the constraint, or of the input limit: "torque limit", "torque norm limit", "torque
    /// rate limit", "wheel torque limit", "wheel momentum limit" and the like.
    pub name: String,
    /// Smallest distance of the plan from the limit, in `unit`; negative if the limit is violated.
    pub margin: f64,
    /// For a rate limit or a cone, the smallest distance of the continuous motion under the held
    /// torque from the limit, in `unit`. It differs from `margin` by the discretisation error.
    /// `None` for other limits, or if the distance could not be computed.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub continuous_margin: Option<f64>,
    /// Unit of the margins: "deg", "deg/s", "N·m", "N·m/s", "N·m·s", "N" or "N/s".
    pub unit: String,
    /// The margin as a fraction of the limit, or in \[rad\] for a cone.
    pub scaled: f64,
    /// Time of the smallest margin \[s\].
    pub time_s: f64,
    /// The input, axis, wheel, or pair of boresight and direction with the smallest margin, in
    /// words; empty if only one exists.
    pub at: String,
}

impl Margin {
    /// Returns whether the limit holds within round-off ([`Margin::ROUND_OFF`]).
    pub fn holds(&self) -> bool {
        self.scaled >= -Self::ROUND_OFF
    }

    /// Returns the margin of the true motion in `unit`: the margin of the continuous motion if it
    /// is known, otherwise the margin of the plan. A margin within round-off is returned as 0.
    pub fn met(&self) -> f64 {
        let value = self.continuous_margin.unwrap_or(self.margin);
        // A plan touches an active limit within round-off, with a margin of either sign.
        let scale = if self.scaled == 0.0 { 1.0 } else { (self.margin / self.scaled).abs() };
        if value.abs() <= Self::ROUND_OFF * scale { 0.0 } else { value }
    }

    /// Returns the index of the input with this margin, forces first; `None` if the margin does not
    /// belong to an input.
    pub fn input(&self, problem: &Problem) -> Option<usize> {
        let number = ["wheel ", "input "].iter().find_map(|kind| self.at.strip_prefix(kind))?;
        let index = number.parse::<usize>().ok()?.checked_sub(1)?;
        let limit = problem.actuation.limits().find(|limit| limit.name == self.name)?;
        limit.first.checked_add(index)
    }

    /// Largest scaled violation within which a limit counts as kept.
    pub const ROUND_OFF: f64 = 1e-9;
}

/// Displays the margin in words: `"torque limit" is missed by 0.32 N·m at t = 4.2 s (input 2)`.
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

/// Returns the largest scaled violation among `margins`: 0 if all limits hold, NaN if a margin is
/// NaN.
pub fn worst_violation(margins: &[Margin]) -> f64 {
    margins.iter().fold(0.0, |worst: f64, margin| {
        let violation = -margin.scaled;
        if violation > worst || violation.is_nan() { violation } else { worst }
    })
}

/// A limit or constraint, with its smallest margin so far.
struct Entry<'a> {
    name: String,
    unit: &'static str,
    what: What<'a>,
    smallest: Smallest,
}

/// A limit of the inputs, or a rule for the motion.
enum What<'a> {
    Input(InputLimit<'a>),
    Rule(&'a Rule),
}

#[derive(Clone, Copy)]
struct Smallest {
    margin: f64,
    scaled: f64,
    time: f64,
    /// Index of the input, axis, wheel or pair with the smallest margin.
    index: usize,
}

impl Smallest {
    /// Keeps the smaller of two margins; NaN replaces any margin and stays.
    fn meet(&mut self, other: Self) {
        if !self.scaled.is_nan() && (other.scaled < self.scaled || other.scaled.is_nan()) {
            *self = other;
        }
    }

    /// Records the margins of values that must not be negative (one-sided inputs).
    fn meet_none_negative(&mut self, values: impl IntoIterator<Item = (f64, f64)>, time: f64) {
        for (index, (value, limit)) in values.into_iter().enumerate() {
            self.meet(Self { margin: value, scaled: value / limit, time, index });
        }
    }

    /// Records the margin of each value to its limit. An infinite limit counts as no limit.
    fn meet_all(&mut self, values: impl IntoIterator<Item = (f64, f64)>, time: f64) {
        for (index, (value, limit)) in values.into_iter().enumerate() {
            if limit.is_finite() {
                let margin = limit - value.abs();
                self.meet(Self { margin, scaled: margin / limit, time, index });
            }
        }
    }
}

/// Measures a motion node by node and arc by arc, and keeps the smallest margins.
pub(crate) struct Meter<'a> {
    frame_rate: Vector3,
    entries: Vec<Entry<'a>>,
}

impl<'a> Meter<'a> {
    /// Builds the meter for a motion of a maneuver.
    pub(crate) fn new(problem: &'a Problem) -> Self {
        let smallest = Smallest { margin: f64::INFINITY, scaled: f64::INFINITY, time: f64::NAN, index: 0 };
        let entry = |name: &str, unit, what| Entry { name: name.into(), unit, what, smallest };
        let inputs =
            problem.actuation.limits().map(|limit| entry(limit.name, limit.unit(), What::Input(limit)));
        let rules = problem.constraints.iter().map(|Constraint { name, rule }| {
            let unit = if matches!(rule, Rule::Pointing(_)) { "deg" } else { "deg/s" };
            entry(name, unit, What::Rule(rule))
        });
        let entries = inputs.chain(rules).collect();
        Self { frame_rate: problem.environment.frame_rate(), entries }
    }

    /// Measures a row of inputs at `time` \[s\]. `before` is the row one `step` \[s\] earlier.
    pub(crate) fn inputs(&mut self, time: f64, row: &[f64], step: f64, before: Option<&[f64]>) {
        for Entry { what, smallest, .. } in &mut self.entries {
            let What::Input(InputLimit { kind, set, first, bounds, .. }) = what else { continue };
            let inputs = &row[*first..*first + set.count()];
            match kind {
                LimitKind::Size => {
                    smallest.meet_all(pairs(inputs, bounds), time);
                    if set.limits().one_sided {
                        smallest.meet_none_negative(pairs(inputs, bounds), time);
                    }
                }
                LimitKind::Norm => smallest.meet_all(pairs(&[set.output(inputs).norm()], bounds), time),
                LimitKind::Rate => {
                    let Some(before) = before else { continue };
                    let slopes = inputs.iter().zip(&before[*first..]).map(|(now, then)| (now - then) / step);
                    smallest.meet_all(slopes.zip(bounds.iter().copied()), time);
                }
                LimitKind::WheelMomentum => {}
            }
        }
    }

    /// Measures the momenta of the wheels at `time` \[s\].
    pub(crate) fn wheels(&mut self, time: f64, momenta: &[f64]) {
        for Entry { what, smallest, .. } in &mut self.entries {
            if let What::Input(InputLimit { kind: LimitKind::WheelMomentum, bounds, .. }) = what {
                smallest.meet_all(pairs(momenta, bounds), time);
            }
        }
    }

    /// Measures an angular velocity (body axes, [rad/s]) at `time` \[s\].
    pub(crate) fn rate(&mut self, time: f64, rate: &Vector3) {
        for Entry { what, smallest, .. } in &mut self.entries {
            match what {
                What::Rule(Rule::RateNorm(limit)) => smallest.meet_all([(rate.norm(), *limit)], time),
                What::Rule(Rule::RateAxes(limits)) => {
                    smallest.meet_all(pairs(rate.as_slice(), limits.as_slice()), time);
                }
                _ => {}
            }
        }
    }

    /// Measures a step of length `step` \[s\] that begins at `time` and has the rotation `arc` at a
    /// constant rate.
    pub(crate) fn arc(&mut self, time: f64, step: f64, arc: &Arc) {
        let frame_rate = self.frame_rate;
        self.rate(time + 0.5 * step, &(arc.turn / step));
        for Entry { what, smallest, .. } in &mut self.entries {
            let What::Rule(Rule::Pointing(pointing)) = what else { continue };
            for (index, (boresight, direction)) in pointing.pairs().enumerate() {
                let target = on_arc(direction, time, step, &frame_rate);
                // This pair stays farther from the cone than the smallest margin so far; no
                // extremum is needed.
                let travel = arc.turn.norm() + target.travel();
                if pointing.room_beside(arc.angle(boresight, &target, 0.0), target.radius) - travel
                    > smallest.scaled
                {
                    continue;
                }
                let Some((worst, scaled)) = pointing.least_room(arc, boresight, &target, [time, step]) else {
                    continue;
                };
                let time = time + worst.part * step;
                smallest.meet(Smallest { margin: scaled, scaled, time, index });
            }
        }
    }

    /// Returns the smallest margins. A limit without values has the margin NaN. A constraint that
    /// was never active during the motion is omitted.
    pub(crate) fn margins(&self) -> Vec<Margin> {
        self.entries.iter().filter(|entry| entry.has_acted()).map(Entry::margin).collect()
    }
}

fn pairs<'a>(values: &'a [f64], limits: &'a [f64]) -> impl Iterator<Item = (f64, f64)> + 'a {
    values.iter().copied().zip(limits.iter().copied())
}

impl Entry<'_> {
    /// Returns whether the constraint is active at all times, or has been active during the motion.
    fn has_acted(&self) -> bool {
        let What::Rule(Rule::Pointing(pointing)) = self.what else { return true };
        pointing.during.given().is_none() || self.smallest.scaled != f64::INFINITY
    }

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

    /// Returns the name of one of several inputs, wheels, axes or pairs by its index; empty if
    /// there is only one.
    fn which(&self, index: usize) -> String {
        let one_of = |what: &str, index: usize, count: usize| {
            if count > 1 { format!("{what} {}", index + 1) } else { String::new() }
        };
        match &self.what {
            What::Input(InputLimit { name, bounds, .. }) => {
                one_of(if name.starts_with("wheel") { "wheel" } else { "input" }, index, bounds.len())
            }
            What::Rule(Rule::RateNorm(_)) => String::new(),
            What::Rule(Rule::RateAxes(_)) => format!("axis {}", ["x", "y", "z"][index]),
            What::Rule(Rule::Pointing(pointing)) => {
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
