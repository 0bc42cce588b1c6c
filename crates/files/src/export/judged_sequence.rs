//! The judgement of the plan of a sequence: each leg by the witnesses, and what joins them.

use super::{ExportError, Judgement, Seal, SequenceFile};
use crate::spec::{ClosedLoop, Loaded, LoadedSequence};
use slewkit::Vector3;
use slewkit::lie;
use slewkit::maneuver::{Problem, State};
use slewkit::plan::Status;
use slewkit::sequence::{Place, Stop};
use slewkit::verify::Check;

/// The results for the plan of a sequence.
#[derive(Clone, Debug)]
pub struct SequenceJudgement {
    /// The results of the witnesses for each leg, in the order of the legs.
    pub legs: Vec<Judgement>,
    /// What joins the legs: ends, stops, holds, windows, records.
    pub checks: Vec<Check>,
}

impl SequenceJudgement {
    /// Returns whether everything holds.
    pub fn passed(&self) -> bool {
        self.checks.iter().all(|check| check.passed) && self.legs.iter().all(|leg| leg.verification.passed())
    }

    /// Returns whether a witness was stopped.
    pub fn was_stopped(&self) -> bool {
        self.legs.iter().any(|leg| leg.verification.was_stopped())
    }
}

/// The largest difference of two states that are one: of their attitudes \[rad\], of their rates as
/// a part of a radian in the duration of a leg, and of times as a part of the whole.
const SAME: f64 = 1e-9;

impl SequenceFile<'_> {
    /// Lets the witnesses judge every leg by the limits and the settings of `loaded`, and checks
    /// that the legs join, that the stops are those of the spec, and that holds and windows are
    /// kept. The witnesses stop when `stop` returns true.
    ///
    /// # Errors
    /// Arrays that do not fit, or a leg without a spec.
    pub fn judge(
        &self,
        loaded: &LoadedSequence,
        stop: &dyn Fn() -> bool,
    ) -> Result<SequenceJudgement, ExportError> {
        let (sequence, settings) = (&loaded.sequence, &loaded.settings);
        let mut checks = Checks(Vec::new());
        let mut legs = Vec::with_capacity(self.legs.len());
        let mut unvisited: Vec<&Stop> = sequence.stops.iter().collect();
        let (mut at, mut time, mut late) = (sequence.craft.start, 0.0, 0.0);
        let mut held: Option<Vec<f64>> = None;
        if self.legs.len() != self.record.stops.len() {
            checks.holds("a leg for each stop", false);
        }
        for (leg, record) in self.legs.iter().zip(&self.record.stops) {
            let own = leg.spec.as_ref().ok_or(ExportError::NoSpec)?;
            let own = own.read("the spec of a leg", &[]).map_err(|_| ExportError::NoSpec)?;
            let Loaded { problem: own, identity, .. } = own;
            let name = &record.name;
            let lasting = leg.trajectory.0.time.last().copied().unwrap_or(0.0);
            checks.joins(&format!("start of the leg to {name}"), &own.start, &at, lasting);
            // The momenta of the wheels are those that the leg before has left.
            let wheels = own.actuation.wheels.as_ref().map(|wheels| wheels.momentum.clone());
            if let (Some(before), Some(now)) = (&held, &wheels) {
                let scale =
                    before.iter().chain(now).fold(f64::MIN_POSITIVE, |most, part| most.max(part.abs()));
                let apart = before.iter().zip(now).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max);
                checks.within(&format!("wheels at the start of the leg to {name}"), apart / scale, CARRIED);
            }
            held = wheels.as_ref().map(|wheels| {
                let rows = &leg.trajectory.0.wheel_momentum;
                rows[rows.len().saturating_sub(wheels.len())..].to_vec()
            });
            let stopped =
                unvisited.iter().position(|stop| stop.name == *name).map(|index| unvisited.remove(index));
            let Some(stopped) = stopped else {
                checks.holds(&format!("{name} is a stop of the spec, visited once"), false);
                continue;
            };
            checks.is_at(stopped, &own.end, &at);
            let mut asked = Problem {
                start: own.start,
                end: own.end,
                name: own.name.clone(),
                duration: own.duration,
                steps: own.steps,
                chooses_steps: own.chooses_steps,
                ..sequence.craft.clone()
            };
            asked.actuation.wheels.clone_from(&own.actuation.wheels);
            if let (Some(asked), Some(craft)) =
                (&mut asked.actuation.wheels, &sequence.craft.actuation.wheels)
            {
                asked.momentum_limit.clone_from(&craft.momentum_limit);
            }
            legs.push(leg.judge(&asked, settings, &identity, &ClosedLoop::default(), stop)?);
            let (leaves, behind) = stopped.visit.after(time + lasting);
            let told = [
                ("begins", record.leg_begins_s, time),
                ("arrives", record.arrives_s, time + lasting),
                ("hold", record.hold_begins_s, leaves - stopped.visit.hold),
                ("leaves", record.leaves_s, leaves),
            ];
            for (what, told, found) in told {
                checks.equal(&format!("recorded times of {name}: {what}"), told, found, leaves);
            }
            (at, time, late) = (State { ..own.end }, leaves, late + behind);
        }
        checks.holds("every stop of the spec is visited", unvisited.is_empty());
        let cost: f64 = self.legs.iter().map(|leg| leg.cost).sum();
        checks.equal("recorded cost", self.record.cost, cost, cost);
        checks.equal("recorded duration", self.record.duration_s, time, time);
        checks.within("seconds by which windows are missed", late, 0.0);
        let solved = self.legs.iter().all(|leg| leg.status == Status::Solved) && late == 0.0;
        let status = self.record.status;
        let coherent = (status == Status::Solved) == solved && self.record.exit_code == status.exit_code();
        checks.holds("recorded status", coherent);
        checks.holds("recorded checksum", !matches!(self.seal, Seal::Broken));
        Ok(SequenceJudgement { legs, checks: checks.0 })
    }
}

/// The largest change of the momenta of wheels between legs, as a part of the largest one: a leg ends
/// as well as it lands.
const CARRIED: f64 = 1e-3;

/// The checks so far.
struct Checks(Vec<Check>);

impl Checks {
    fn within(&mut self, name: &str, value: f64, limit: f64) {
        self.0.push(Check { name: name.into(), value, limit, passed: value <= limit });
    }

    fn holds(&mut self, name: &str, holds: bool) {
        self.within(name, f64::from(u8::from(!holds)), 0.0);
    }

    fn equal(&mut self, name: &str, told: f64, found: f64, scale: f64) {
        self.within(name, (told - found).abs() / scale.abs().max(f64::MIN_POSITIVE), SAME);
    }

    /// Checks that two states are one.
    fn joins(&mut self, name: &str, state: &State, other: &State, lasting: f64) {
        let turn = lie::minus(&state.attitude, &other.attitude).norm();
        let rate = (state.angular_velocity - other.angular_velocity).norm() * lasting;
        self.within(name, turn.max(rate), SAME);
    }

    /// Checks that a state is at a stop; `from` is the state at the start of its leg.
    fn is_at(&mut self, stop: &Stop, state: &State, from: &State) {
        let fastest = stop.passing.unwrap_or(0.0);
        let excess = (state.angular_velocity.norm() - fastest).max(0.0);
        let rate = if fastest.is_finite() { excess } else { 0.0 };
        self.within(&format!("rate at {} beyond its bound, rad/s", stop.name), rate, SAME);
        let away = match &stop.place {
            Place::Attitude(attitude) => lie::minus(&state.attitude, attitude).norm(),
            Place::Aim(aim) => match aim.clone().at_rest().ends(0.0, &from.attitude, &Vector3::zeros()) {
                Ok(ends) => {
                    let roll = ends.nearest(&state.attitude);
                    let held = roll.clamp(-ends.within(), ends.within());
                    let roll = if aim.has_roll() { held } else { 0.0 };
                    lie::minus(&state.attitude, &ends.at(roll).0).norm()
                }
                Err(_) => f64::INFINITY,
            },
        };
        self.within(&format!("attitude at {}, rad from the stop", stop.name), away, SAME);
    }
}
