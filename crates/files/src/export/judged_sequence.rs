//! Verification of the plan of a sequence. The witnesses verify each leg; further checks verify the
//! transitions between the legs.

use super::{ExportError, Judgement, PlanFile, Seal, SequenceFile};
use crate::identity::Identity;
use crate::spec::{ClosedLoop, Loaded, LoadedSequence};
use slewkit::Vector3;
use slewkit::lie;
use slewkit::maneuver::{Problem, State};
use slewkit::plan::Status;
use slewkit::sequence::{Place, Stop, tracked};
use slewkit::verify::Check;

/// Results of the verification of the plan of a sequence.
#[derive(Clone, Debug)]
pub struct SequenceJudgement {
    /// Results of the witnesses for each leg, in the order of the legs.
    pub legs: Vec<Judgement>,
    /// Results of the witnesses for each hold on a moving target or past moving cones, each with
    /// the name of its stop.
    pub holds: Vec<(String, Judgement)>,
    /// Checks of the transitions between legs, of stops, holds and windows, and of recorded values.
    pub checks: Vec<Check>,
}

impl SequenceJudgement {
    /// Returns true if all checks of the legs, holds and transitions passed.
    pub fn passed(&self) -> bool {
        self.checks.iter().all(|check| check.passed)
            && self.judgements().all(|judged| judged.verification.passed())
    }

    /// Returns true if the verification of any leg or hold was stopped before its end.
    pub fn was_stopped(&self) -> bool {
        self.judgements().any(|judged| judged.verification.was_stopped())
    }

    fn judgements(&self) -> impl Iterator<Item = &Judgement> {
        self.legs.iter().chain(self.holds.iter().map(|(_, hold)| hold))
    }
}

/// Tolerance within which two states or two times count as equal. It applies to the difference of
/// the attitudes \[rad\], to the difference of the rates times the duration of the leg \[rad\], and
/// to the relative difference of the times.
const SAME: f64 = 1e-9;

impl SequenceFile<'_> {
    /// Verifies every leg with the witnesses, using the limits and settings of `loaded`. Also
    /// checks that each leg begins where the previous part ended, that the stops are the stops of
    /// the spec, and that the holds and windows are met. The verification ends early when `stop`
    /// returns true.
    ///
    /// # Errors
    /// Returns an error if the lengths of arrays are inconsistent, or if a leg has no spec.
    pub fn judge(
        &self,
        loaded: &LoadedSequence,
        stop: &dyn Fn() -> bool,
    ) -> Result<SequenceJudgement, ExportError> {
        let (sequence, settings) = (&loaded.sequence, &loaded.settings);
        let mut checks = Checks(Vec::new());
        let (mut legs, mut holds) = (Vec::with_capacity(self.legs.len()), Vec::new());
        let mut unvisited: Vec<&Stop> = sequence.stops.iter().collect();
        let (mut at, mut time, mut late) = (sequence.craft.start, 0.0, 0.0);
        let mut held: Option<Held> = None;
        if self.legs.len() != self.record.stops.len() {
            checks.holds("a leg for each stop", false);
        }
        for ((leg, record), hold) in self.legs.iter().zip(&self.record.stops).zip(&self.holds) {
            let part = Own::of(leg)?;
            let (own, lasting, name) = (&part.problem, part.lasting, &record.name);
            let what = format!("start of the leg to {name}");
            checks.joins(&what, &own.start, &at, lasting);
            held = checks.carries(&what, held, &part, leg);
            let stopped =
                unvisited.iter().position(|stop| stop.name == *name).map(|index| unvisited.remove(index));
            let Some(stopped) = stopped else {
                checks.holds(&format!("{name} is a stop of the spec, visited once"), false);
                continue;
            };
            let arrival = time + lasting;
            checks.is_at(stopped, &own.end, &at, arrival);
            let mut asked = Problem {
                end_condition: own.end_condition.clone(),
                duration: own.duration,
                chooses_steps: own.chooses_steps,
                ..sequence.craft.later(time).known_for(lasting)
            };
            part.gives(&mut asked);
            legs.push(leg.judge(&asked, settings, &part.identity, &ClosedLoop::default(), stop)?);
            let (leaves, behind) = stopped.visit.after(arrival);
            at = own.end;
            let needs = leaves > arrival && (tracked::moves(stopped) || sequence.craft.is_timed());
            if needs != hold.is_some() {
                checks.holds(&format!("a motion of the hold at {name}"), false);
            }
            if let Some(hold) = hold.as_ref().filter(|_| needs) {
                let own = Own::of(hold)?;
                let what = format!("start of the hold at {name}");
                checks.joins(&what, &own.problem.start, &at, own.lasting);
                held = checks.carries(&what, held, &own, hold);
                checks.equal(&format!("end of the hold at {name}"), own.lasting, leaves - arrival, leaves);
                let off = tracked::off_target(stopped, arrival, &hold.trajectory.0);
                checks.within(&format!("hold at {name}, rad from the target"), off, ON_TARGET);
                let mut asked = tracked::holding(sequence, stopped, (arrival, at), leaves - arrival);
                own.gives(&mut asked);
                at = own.problem.end;
                let judged = hold.judge(&asked, settings, &own.identity, &ClosedLoop::default(), stop)?;
                holds.push((name.clone(), judged));
            }
            let told = [
                ("begins", record.leg_begins_s, time),
                ("arrives", record.arrives_s, arrival),
                ("hold", record.hold_begins_s, leaves - stopped.visit.hold),
                ("leaves", record.leaves_s, leaves),
            ];
            for (what, told, found) in told {
                checks.equal(&format!("recorded times of {name}: {what}"), told, found, leaves);
            }
            (time, late) = (leaves, late + behind);
        }
        checks.holds("every stop of the spec is visited", unvisited.is_empty());
        let cost: f64 = self.legs.iter().map(|leg| leg.cost).sum();
        checks.equal("recorded cost", self.record.cost, cost, cost);
        checks.equal("recorded duration", self.record.duration_s, time, time);
        checks.within("seconds by which windows are missed", late, 0.0);
        let solved = self.parts().all(|part| part.status == Status::Solved) && late == 0.0;
        let status = self.record.status;
        let coherent = (status == Status::Solved) == solved && self.record.exit_code == status.exit_code();
        checks.holds("recorded status", coherent);
        checks.holds("recorded checksum", !matches!(self.seal, Seal::Broken));
        Ok(SequenceJudgement { legs, holds, checks: checks.0 })
    }
}

/// Largest difference of the wheel momenta at the end of a part and at the start of the next part,
/// relative to the largest momentum so far. The difference is not zero, because a leg meets its
/// target only within the accuracy of landing.
const CARRIED: f64 = 1e-3;

/// Largest attitude error at the nodes of a hold, relative to its target \[rad\]. It allows for the
/// round-off that the witnesses accumulate over many steps.
const ON_TARGET: f64 = 1e-7;

/// Maneuver of a leg or a hold, reconstructed from its file.
pub(crate) struct Own {
    pub(crate) problem: Problem,
    identity: Identity,
    /// Duration of the leg or hold \[s\].
    lasting: f64,
}

impl Own {
    pub(crate) fn of(part: &PlanFile<'_>) -> Result<Self, ExportError> {
        let spec = part.spec.as_ref().ok_or(ExportError::NoSpec)?;
        let read = spec.read("the spec of a leg", &[]).map_err(|_| ExportError::NoSpec)?;
        let Loaded { problem, identity, .. } = read;
        let path = &part.trajectory.0;
        let problem = Problem { end: path.completed(&problem).end, ..problem };
        Ok(Self { problem, identity, lasting: path.time.last().copied().unwrap_or(0.0) })
    }

    /// Copies the properties of this part to the maneuver `asked`: its start, its end, its number
    /// of steps, its name, and the initial momenta of its wheels.
    fn gives(&self, asked: &mut Problem) {
        let own = &self.problem;
        (asked.start, asked.end, asked.steps) = (own.start, own.end, own.steps);
        asked.name.clone_from(&own.name);
        if let (Some(asked), Some(own)) = (&mut asked.actuation.wheels, &own.actuation.wheels) {
            asked.momentum.clone_from(&own.momentum);
        }
    }
}

/// Wheel momenta at the end of a part, and the largest absolute momentum so far \[N·m·s\].
struct Held {
    last: Vec<f64>,
    largest: f64,
}

/// List of the checks that have been made.
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

    /// Checks that two states are equal. The difference of their rates is multiplied by `lasting`
    /// \[s\].
    fn joins(&mut self, name: &str, state: &State, other: &State, lasting: f64) {
        let turn = lie::minus(&state.attitude, &other.attitude).norm();
        let rate = (state.angular_velocity - other.angular_velocity).norm() * lasting;
        self.within(name, turn.max(rate), SAME);
    }

    /// Checks that the wheel momenta at the start of a part equal those at the end of the previous
    /// part, if it exists. Returns the momenta at the end of this part; `None` if the body has no
    /// wheels.
    fn carries(&mut self, name: &str, before: Option<Held>, own: &Own, part: &PlanFile<'_>) -> Option<Held> {
        let now = &own.problem.actuation.wheels.as_ref()?.momentum;
        let rows = &part.trajectory.0.wheel_momentum;
        let so_far = before.as_ref().map_or(f64::MIN_POSITIVE, |held| held.largest);
        let largest = rows.iter().chain(now).fold(so_far, |most, one| most.max(one.abs()));
        if let Some(Held { last, .. }) = before {
            let apart = last.iter().zip(now).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max);
            self.within(&format!("wheels at the {name}"), apart / largest, CARRIED);
        }
        Some(Held { last: rows[rows.len().saturating_sub(now.len())..].to_vec(), largest })
    }

    /// Checks that the state at `time` \[s\] satisfies the conditions of a stop; `from` is the
    /// state at the start of the leg to the stop.
    fn is_at(&mut self, stop: &Stop, state: &State, from: &State, time: f64) {
        let zero = Vector3::zeros();
        let (aim, moves) = match &stop.place {
            Place::Attitude(_) => (None, false),
            Place::Aim(aim) if tracked::moves(stop) => (Some(aim.clone()), true),
            Place::Aim(aim) => (Some(aim.clone().at_rest()), false),
        };
        let ends = aim.as_ref().map(|aim| aim.ends(time, &from.attitude, &zero));
        let matched = match &ends {
            Some(Ok(ends)) if moves => ends.at(ends.nearest(&state.attitude)).1,
            _ => zero,
        };
        let fastest = stop.passing.unwrap_or(0.0);
        let excess = ((state.angular_velocity - matched).norm() - fastest).max(0.0);
        let rate = if fastest.is_finite() { excess } else { 0.0 };
        self.within(&format!("rate at {} beyond its bound, rad/s", stop.name), rate, SAME);
        let away = match (&stop.place, ends) {
            (Place::Attitude(attitude), _) => lie::minus(&state.attitude, attitude).norm(),
            (Place::Aim(_), Some(Ok(ends))) => {
                lie::minus(&state.attitude, &ends.at(ends.nearest(&state.attitude)).0).norm()
            }
            (Place::Aim(_), _) => f64::INFINITY,
        };
        self.within(&format!("attitude at {}, rad from the stop", stop.name), away, SAME);
    }
}
