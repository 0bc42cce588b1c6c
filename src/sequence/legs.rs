//! Planning of the legs for a given order of stops. Legs that share free quantities are planned
//! together ([`super::together`]). Legs to moving targets are planned one at a time.

use super::arrivals::{Bounds, is_given, split};
use super::carried::{self, carry};
use super::joint::Joint;
use super::leg::{Leg, LegError};
use super::order::Visit;
use super::together::{Together, Tuning, Whole};
use super::tracked::{self, Hold};
use super::{Part, Place, PlannedLeg, Sequence, SequenceError, rolls};
use crate::maneuver::aim::{Aim, AimRate};
use crate::maneuver::problem::{Problem, ProblemError, State};
use crate::maneuver::settings::{Settings, Target};
use crate::maneuver::solution::Trajectory;
use crate::optimize::search::Observer;
use crate::plan::{Guess, Status, plan};
use crate::{Matrix3, Vector3, lie};

/// Consecutive stops whose legs share free quantities, with the visits to these stops and the
/// bounds of the end times of the legs \[s\].
struct Run {
    stops: Vec<usize>,
    visits: Vec<Visit>,
    arrivals: Option<Vec<Bounds>>,
}

/// The legs that are planned so far, and the state after them.
pub struct Legs<'a> {
    sequence: &'a Sequence,
    settings: &'a Settings,
    /// Number of legs in the order.
    count: usize,
    /// Bounds of the end time of each leg \[s\]; `None` if the planner finds the duration of each
    /// leg independently.
    arrivals: Option<Vec<Bounds>>,
    /// State at the start of the next leg.
    at: State,
    /// Wheel momenta at the start of the next leg; `None` before the first leg and without wheels.
    held: Option<Vec<f64>>,
    /// The planned legs, in their order.
    pub planned: Vec<PlannedLeg>,
    /// Sum of the costs of the planned legs.
    pub cost: f64,
    /// Start time of the next leg \[s\].
    pub time: f64,
    /// Sum of the delays past the windows of the stops so far \[s\].
    pub late: f64,
    /// Status of the search that was stopped before all legs were planned; `None` if none was.
    pub cut: Option<Status>,
}

impl<'a> Legs<'a> {
    /// Plans the legs to `stops` in this order. If a leg does not converge, no further legs are
    /// planned.
    ///
    /// # Errors
    /// The errors of [`Sequence::plan`].
    pub fn planned(
        sequence: &'a Sequence,
        settings: &'a Settings,
        stops: &[usize],
        observer: &mut dyn Observer,
    ) -> Result<Self, SequenceError> {
        let (count, at, arrivals) = (stops.len(), sequence.craft.start, sequence.arrivals(stops)?);
        let planned = Vec::with_capacity(count);
        let (cost, time, late) = (0.0, 0.0, 0.0);
        let mut legs = Self {
            sequence,
            settings,
            count,
            arrivals,
            at,
            held: None,
            planned,
            cost,
            time,
            late,
            cut: None,
        };
        let mut left = stops;
        while !left.is_empty() && !legs.has_failed() {
            let (next, count) = match left {
                [stop, ..] if legs.stays(*stop) => (legs.stay(*stop, observer), 1),
                _ => {
                    let count = legs.sharing(left)?;
                    let next = match &left[..count] {
                        [stop] if sequence.stops[*stop].passing.is_none() => legs.alone(*stop, observer),
                        run => legs.run(run, observer),
                    };
                    (next, count)
                }
            };
            match next {
                // Finished legs are kept.
                Err(SequenceError::Stopped(status)) if !legs.planned.is_empty() => legs.cut = Some(status),
                next => next?,
            }
            left = &left[count..];
        }
        Ok(legs)
    }

    /// Returns the bounds of the end times of the remaining legs \[s\]; `None` if the planner finds
    /// the duration of each leg independently.
    fn next_arrivals(&self) -> Option<&[Bounds]> {
        self.arrivals.as_ref().map(|arrivals| &arrivals[self.planned.len()..])
    }

    /// Returns the number of the next legs to plan together; `left` are the remaining stops. Each
    /// of these legs except the last one has a free end time, or ends at a stop with free
    /// parameters.
    fn sharing(&self, left: &[usize]) -> Result<usize, SequenceError> {
        let sequence = self.sequence;
        let is_alone = |stop: usize| tracked::moves(&sequence.stops[stop]);
        let arrivals = self.next_arrivals();
        for (index, pair) in left.windows(2).enumerate() {
            let is_open = arrivals.is_some_and(|arrivals| !is_given(arrivals[index]));
            let shares = is_open
                || !pair.iter().any(|stop| is_alone(*stop))
                    && sequence.joint(&sequence.stops[pair[0]])?.size() > 0;
            if !shares {
                return Ok(index + 1);
            }
        }
        Ok(left.len())
    }

    fn has_failed(&self) -> bool {
        self.cut.is_some() || self.planned.last().is_some_and(|leg| leg.status() != Status::Solved)
    }

    /// Plans the legs to `stops` together, then each leg with [`plan()`]. If the body stays at rest
    /// from one stop to the next, the leg between them does not take part in the joint planning.
    fn run(&mut self, stops: &[usize], observer: &mut dyn Observer) -> Result<(), SequenceError> {
        let run = self.without_stays(stops);
        let whole = self.together(&run, observer)?;
        let mut legs = whole.legs.into_iter();
        for stop in stops {
            if !run.stops.contains(stop) {
                self.stay(*stop, observer)?;
            } else if let Some(leg) = legs.next() {
                let guess = Guess::of(&leg.solution, &leg.problem);
                let constraints = self.sequence.craft.later(self.time).constraints;
                self.add(*stop, Problem { constraints, ..leg.problem }, Some(guess), observer)?;
            }
            if self.has_failed() {
                break;
            }
        }
        Ok(())
    }

    /// Returns the run for `stops` without each stop at which the body already is. The visit to the
    /// stop before lasts longer instead.
    fn without_stays(&self, stops: &[usize]) -> Run {
        let mut run = Run { stops: Vec::new(), visits: Vec::new(), arrivals: None };
        let all = self.next_arrivals().map(|arrivals| &arrivals[..stops.len()]);
        let mut arrivals = Vec::new();
        for (index, stop) in stops.iter().enumerate() {
            let visit = self.sequence.stops[*stop].visit;
            let bounds = all.map(|all| all[index]);
            let stays = index > 0 && self.sequence.stays(stops[index - 1], *stop) && self.is_unbound(*stop);
            match run.visits.last_mut().filter(|_| stays) {
                Some(before) => {
                    if let (Some(last), Some([from, until])) = (arrivals.last_mut(), bounds) {
                        let [least, most]: Bounds = *last;
                        *last = [least.max(from - before.rest()), most.min(until - before.rest())];
                    }
                    before.hold += visit.rest();
                }
                None => {
                    run.stops.push(*stop);
                    run.visits.push(visit);
                    arrivals.extend(bounds);
                }
            }
        }
        run.arrivals = all.map(|_| arrivals);
        run
    }

    /// Returns `true` if the window of a stop does not restrict the end time of its leg.
    fn is_unbound(&self, stop: usize) -> bool {
        let visit = self.sequence.stops[stop].visit;
        self.arrivals.is_none() || visit.window == Visit::PASSED.window && !visit.pinned
    }

    /// Returns `true` if the body already is at `stop`, at rest, the legs share the total duration,
    /// and the stop has no window: the leg to this stop then takes no time.
    fn stays(&self, stop: usize) -> bool {
        self.arrivals.is_some() && self.sequence.is_at(stop, &self.at) && self.is_unbound(stop)
    }

    /// Adds a leg in which the body does not move. If the legs share the total duration, this leg
    /// lasts less than the round-off of the time.
    fn stay(&mut self, stop: usize, observer: &mut dyn Observer) -> Result<(), SequenceError> {
        let mut leg = Problem { start: self.at, end: self.at, ..self.sequence.leg() };
        if let Some(arrivals) = self.next_arrivals() {
            leg = leg.with_duration(0.25 * f64::EPSILON * arrivals[0][1].max(self.time));
        }
        self.add(stop, leg.later(self.time), None, observer)
    }

    /// Plans a leg independently of the other legs. It ends on the target at the position that the
    /// target has on arrival; a free roll is optimal for this leg only.
    fn alone(&mut self, stop: usize, observer: &mut dyn Observer) -> Result<(), SequenceError> {
        let at = &self.sequence.stops[stop];
        let leg = Problem { start: self.at, ..self.sequence.leg() };
        let mut leg = match &at.place {
            Place::Aim(aim) if aim.has_roll() || tracked::moves(at) => {
                let rate = if tracked::moves(at) { AimRate::Matched } else { AimRate::Zero };
                leg.with_aim_at_end(Aim { rate, ..aim.clone() })
            }
            Place::Aim(_) | Place::Attitude(_) => Problem { end: self.sequence.joint(at)?.state(&[]), ..leg },
        };
        if let Some(arrivals) = self.next_arrivals() {
            leg = leg.with_duration(arrivals[0][1] - self.time);
        }
        self.add(stop, leg.later(self.time), None, observer)
    }

    /// Plans a leg from the present state to `stop`, and adds it with the hold at its end.
    fn add(
        &mut self,
        stop: usize,
        mut problem: Problem,
        guess: Option<Guess>,
        observer: &mut dyn Observer,
    ) -> Result<(), SequenceError> {
        let Self { sequence, settings, .. } = *self;
        let (at, craft) = (&sequence.stops[stop], &sequence.craft);
        let part = format!("leg {} of {}", self.planned.len() + 1, self.count);
        let observer = &mut Part { observer, part };
        let told = |error| SequenceError::Leg { stop: at.name.clone(), error };
        carry(&mut problem, &carried::momentum(craft), self.held.as_deref());
        problem.name = format!("{}, leg to {}", craft.name, at.name);
        if craft.chooses_steps {
            (problem.steps, problem.chooses_steps) = (craft.steps, true);
        }
        let guess = guess.filter(|_| !problem.objective.switches() && problem.duration.known().is_some());
        let plan = plan(&problem, settings, guess.as_ref(), observer).map_err(told)?;
        let path = &plan.solution.trajectory;
        if path.time.is_empty() && matches!(plan.status, Status::Interrupted | Status::LimitReached) {
            return Err(SequenceError::Stopped(plan.status));
        }
        let lasting = path.time.last().copied().unwrap_or(0.0);
        let problem = path.completed(&problem).known_for(lasting);
        let arrival = self.time + lasting;
        let (end, behind) = at.visit.after(arrival);
        let known = sequence.known_until();
        if end > known * (1.0 + Visit::ROUND_OFF) {
            return Err(SequenceError::Beyond { stop: at.name.clone(), end, known });
        }
        (self.at, self.held) = (problem.end, self.wheels(path));
        let holds =
            plan.status == Status::Solved && end > arrival && (tracked::moves(at) || craft.is_timed());
        let hold = if holds { Some(self.hold(stop, arrival, end, observer)?) } else { None };
        self.cost += plan.solution.cost;
        let planned =
            PlannedLeg { problem, plan, stop, begins: self.time, holds: [end - at.visit.hold, end], hold };
        self.planned.push(planned);
        (self.time, self.late) = (end, self.late + behind);
        Ok(())
    }

    /// Plans the hold at a stop from `arrival` to `until` \[s\]. Then sets the present state to the
    /// end of the hold.
    fn hold(
        &mut self,
        stop: usize,
        arrival: f64,
        until: f64,
        observer: &mut dyn Observer,
    ) -> Result<Hold, SequenceError> {
        let stop = &self.sequence.stops[stop];
        let asked = (self.settings, observer);
        let hold = tracked::hold(self.sequence, stop, (arrival, self.at), until, self.held.as_deref(), asked);
        let hold = hold.map_err(|error| SequenceError::Aim { stop: stop.name.clone(), error })?;
        (self.at, self.held) = (hold.end(), self.wheels(&hold.plan.solution.trajectory));
        Ok(hold)
    }

    /// Returns the wheel momenta at the end of a path; `None` without wheels.
    fn wheels(&self, path: &Trajectory) -> Option<Vec<f64>> {
        let wheels = self.sequence.craft.actuation.wheels.as_ref()?.momentum.len();
        let rows = &path.wheel_momentum;
        Some(rows[rows.len().checked_sub(wheels)?..].to_vec())
    }

    /// Plans the legs of a run together, from two initial guesses of the states at the joints: from
    /// legs that are planned one by one, and from the shortest turns.
    fn together(&self, run: &Run, observer: &mut dyn Observer) -> Result<Whole, SequenceError> {
        let Self { sequence, settings, at: start, .. } = *self;
        let Run { stops, visits, arrivals } = run;
        let arrivals = arrivals.as_deref();
        let joints: Vec<Joint> =
            stops.iter().map(|stop| sequence.joint(&sequence.stops[*stop])).collect::<Result<_, _>>()?;
        let craft = sequence.leg();
        let power = sequence.power();
        let inertia = craft.body.inertia.j();
        let ends = |states: &[State]| -> Vec<f64> {
            let before = std::iter::once(&start).chain(states);
            let weight = |(from, to): (&State, &State)| {
                let momentum = (inertia * lie::minus(&to.attitude, &from.attitude)).norm();
                // An effort of c/T³ is minimised by times in proportion to the fourth roots of c.
                // The lower bound gives every leg some time.
                momentum.powf(0.25 * power).max(f64::EPSILON)
            };
            let weights: Vec<f64> = before.zip(states).map(weight).collect();
            let rests: Vec<f64> = visits.iter().map(Visit::rest).collect();
            arrivals.map_or(Vec::new(), |arrivals| split(self.time, arrivals, &rests, &weights))
        };
        let durations = |ends: &[f64]| -> Vec<f64> {
            let left = visits.iter().zip(ends).map(|(visit, end)| end + visit.rest());
            ends.iter()
                .zip(std::iter::once(self.time).chain(left))
                .map(|(end, begins)| end - begins)
                .collect()
        };
        let together = Together {
            craft: &craft,
            start,
            begins: self.time,
            visits: visits.clone(),
            momentum: carried::momentum(&sequence.craft),
            joints: &joints,
            arrivals,
            settings,
            tuning: Tuning::default(),
        };
        // Moving cones are evaluated at the start of the first leg.
        let now = craft.later(self.time).with_duration(f64::MIN_POSITIVE);
        let allowed = |state: &State| {
            let there = Problem { end: *state, ..now.clone() };
            let at_end = |error: ProblemError| matches!(error, ProblemError::Violated { end: "end", .. });
            !there.violations().any(at_end)
        };
        let cheapest =
            |lasting: &[f64]| rolls::cheapest(&start, &joints, &allowed, (inertia, power), lasting);
        let equal = durations(&ends(&cheapest(&[])));
        let of_turns = cheapest(&equal);
        let observer = &mut Part { observer, part: "all legs together".into() };
        let mut firsts = vec![of_turns];
        if joints.iter().any(|joint| joint.size() > 0) {
            firsts.extend(self.one_by_one(stops, &joints, &equal, observer)?);
        }
        let named = || sequence.named(stops);
        let told = |error: LegError| error.at(named());
        let mut best: Option<Whole> = None;
        for states in firsts {
            let passed = self.passed(&joints, states, &equal);
            let first = together.unknowns(&passed, &ends(&passed));
            let Some(whole) = together.planned(first, None, observer).map_err(told)? else { continue };
            let whole = together.improved(whole, observer).map_err(told)?;
            if best.as_ref().is_none_or(|best| whole.cost() < best.cost()) {
                best = Some(whole);
            }
        }
        best.ok_or_else(|| SequenceError::NoPlan { stop: named() })
    }

    /// Plans the legs one after the other, each with the roll at its end that is optimal for this
    /// leg. Returns the states at the ends of the legs; `None` if no plan is found for a leg.
    fn one_by_one(
        &self,
        stops: &[usize],
        joints: &[Joint],
        durations: &[f64],
        observer: &mut dyn Observer,
    ) -> Result<Option<Vec<State>>, SequenceError> {
        let sequence = self.sequence;
        let settings = Settings { target: Target::Discrete, ..self.settings.clone() };
        let (mut from, mut time) = (self.at, self.time);
        let mut states = Vec::with_capacity(stops.len());
        for (index, (stop, joint)) in stops.iter().zip(joints).enumerate() {
            let stop = &sequence.stops[*stop];
            let state = match (&stop.place, joint) {
                (Place::Aim(aim), Joint::Roll(_) | Joint::PassingRoll { .. }) => {
                    let mut problem = Problem { start: from, ..sequence.leg().later(time) };
                    if let Some(duration) = durations.get(index) {
                        problem = problem.with_duration(*duration);
                    }
                    let problem = problem.with_aim_at_end(aim.clone().at_rest());
                    let leg = Leg::of(problem, &settings, None, observer);
                    let Some(leg) = leg.map_err(|error| error.at(&stop.name))? else { return Ok(None) };
                    time = stop.visit.after(time + leg.lasting()).0;
                    let Some(last) = leg.solution.trajectory.quaternion.last() else { return Ok(None) };
                    let attitude = lie::project_to_rotation(&lie::rotation_from_quaternion(last));
                    State::attitude(attitude, Vector3::zeros())
                }
                _ => joint.state(&vec![0.0; joint.size()]),
            };
            states.push(state);
            from = State { angular_velocity: Vector3::zeros(), ..state };
        }
        Ok(Some(states))
    }

    /// Sets the angular velocity at each stop that the body passes to the derivative of an
    /// interpolating curve through this state and its two neighbours. Without `durations` \[s\] the
    /// states do not change.
    fn passed(&self, joints: &[Joint], mut states: Vec<State>, durations: &[f64]) -> Vec<State> {
        let attitudes: Vec<Matrix3> =
            std::iter::once(self.at.attitude).chain(states.iter().map(|state| state.attitude)).collect();
        for (index, joint) in joints.iter().enumerate() {
            let is_passed = matches!(joint, Joint::Passing { .. } | Joint::PassingRoll { .. });
            if let (true, Some(next), [before, after]) =
                (is_passed, attitudes.get(index + 2), durations.get(index..index + 2).unwrap_or(&[]))
            {
                let [from, at] = [attitudes[index], attitudes[index + 1]];
                let [come, gone] = [lie::minus(&at, &from) / *before, lie::minus(next, &at) / *after];
                states[index].angular_velocity = (come * *after + gone * *before) / (before + after);
            }
        }
        states
    }
}
