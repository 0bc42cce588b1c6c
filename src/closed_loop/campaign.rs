//! Monte Carlo simulation of a plan.

use super::craft::{DelayLine, Errors, Limited};
use super::draws::{Drawn, Draws};
use super::feedforward::{Feedforward, SAME_TIME};
use super::{Flown, Lost, Moment, Plant};
use crate::feedback::Gains;
use crate::flight::{Excess, Flight, Held};
use crate::maneuver::{Constraint, Problem, State};
use crate::mechanics::actuators::ActuatorSet;
use crate::mechanics::body::{Body, Inertia};
use crate::numerics::parallel;
use crate::numerics::random::Stream;
use crate::optimize::discrete::linear_plan::{LinearPlan, Vector6};
use crate::uncertainty::Uncertainty;
use crate::{Vector3, lie};

/// A Monte Carlo simulation of a plan: many flights, called cases, each with its own random errors.
#[derive(Clone, Debug)]
pub struct Campaign<'a> {
    pub(super) problem: &'a Problem,
    plan: &'a LinearPlan,
    gains: Option<&'a Gains>,
    pub(super) uncertainty: &'a Uncertainty,
    plant: Plant,
    draws: Draws<'a>,
    /// Number of threads that share the cases; `None` for all available threads.
    threads: Option<usize>,
    /// Torque actuators of the craft with their full limits, including the reserve of the plan.
    actuators: ActuatorSet,
    /// Constraints whose distances are recorded, without the margins of the plan.
    constraints: Vec<Constraint>,
    /// Integrator of the nominal motion, with the number of parts per step already chosen.
    nominal: Flight<'a>,
    /// Feedforward commands, each with the time \[s\] from which it acts: first the commands given
    /// before the start, then one command per step.
    feedforward: Vec<(f64, Vec<f64>)>,
}

impl<'a> Campaign<'a> {
    /// Maximum number of cases in a run.
    pub const MOST_CASES: u64 = 1_000_000;

    /// Builds the simulation of a maneuver. `plan` is the plan with its linearised motion (torques
    /// held over each step), and `seed` determines all random draws. If `gains` is `None`, the
    /// flights are in open loop.
    pub fn new(
        problem: &'a Problem,
        plan: &'a LinearPlan,
        gains: Option<&'a Gains>,
        uncertainty: &'a Uncertainty,
        plant: Plant,
        seed: u64,
    ) -> Self {
        let mut nominal = Flight::new(problem);
        let steps: Vec<(Held, f64)> = (0..plan.count())
            .map(|k| (held(&problem.actuation.torque, plan.inputs(k)), plan.times()[k + 1] - plan.times()[k]))
            .collect();
        nominal.settle(&steps);
        let craft = problem.of_craft();
        Self {
            problem,
            plan,
            gains,
            uncertainty,
            plant,
            draws: Draws::new(uncertainty, &problem.body.inertia, seed),
            threads: None,
            actuators: craft.actuation.torque,
            constraints: craft.constraints,
            nominal,
            feedforward: Feedforward { plan, plant: &plant }.commands(),
        }
    }

    /// Records the distances from these constraints instead of the constraints of the maneuver.
    pub(crate) fn with_constraints(self, constraints: Vec<Constraint>) -> Self {
        Self { constraints, ..self }
    }

    /// Simulates the case with the number `case`.
    ///
    /// # Errors
    /// [`Lost`] if the motion cannot be propagated, or if every drawn inertia is impossible.
    pub fn fly(&self, case: u64) -> Result<Flown, Lost> {
        self.flown(case, |_| ())
    }

    /// Simulates the case with the number `case`, and returns its result and its state at every
    /// step.
    ///
    /// # Errors
    /// [`Lost`] if the motion cannot be propagated, or if every drawn inertia is impossible.
    pub fn traced(&self, case: u64) -> Result<(Flown, Vec<Moment>), Lost> {
        let mut moments = Vec::with_capacity(self.plan.count() + 1);
        let flown = self.flown(case, |moment| moments.push(moment()))?;
        Ok((flown, moments))
    }

    /// Sets the number of threads that share the cases; `None` for all available threads. The
    /// results do not depend on this number.
    #[must_use]
    pub fn with_threads(self, threads: Option<usize>) -> Self {
        Self { threads, ..self }
    }

    /// Simulates `count` cases from the number `first` on, with several threads.
    pub fn fly_all(&self, first: u64, count: usize) -> Vec<Result<Flown, Lost>> {
        self.each(first, count, |case| self.fly(case))
    }

    /// Simulates `count` cases from the number `first` on, with several threads, and records every
    /// step. Returns the result of the function `of` for each case.
    pub fn trace_all<R: Clone + Send>(
        &self,
        first: u64,
        count: usize,
        of: impl Fn(Flown, Vec<Moment>) -> R + Send + Sync,
    ) -> Vec<Result<R, Lost>> {
        self.each(first, count, |case| self.traced(case).map(|(flown, moments)| of(flown, moments)))
    }

    fn each<R: Clone + Send>(
        &self,
        first: u64,
        count: usize,
        of: impl Fn(u64) -> Result<R, Lost> + Send + Sync,
    ) -> Vec<Result<R, Lost>> {
        /// Number of cases that a thread processes as one batch; a case takes about 50 µs.
        const BATCH: usize = 16;
        let cases: Vec<u64> = (0..count as u64).map(|case| first + case).collect();
        let mut results: Vec<Result<R, Lost>> = vec![Err(Lost); count];
        parallel::within(self.threads, || parallel::fill(&cases, &mut results, BATCH, |case| of(*case)));
        results
    }

    fn flown(&self, case: u64, watch: impl FnMut(&dyn Fn() -> Moment)) -> Result<Flown, Lost> {
        let Drawn { parameters, inertia, rejected } = self.draws.craft(case)?;
        let (beside, noise) = (self.draws.start(case), self.draws.noise(case));
        let flown = self.run(&parameters, inertia, &beside, noise, watch)?;
        Ok(Flown { rejected, parameters, ..flown })
    }

    /// Simulates a craft with these parameters from a start that deviates from the plan by
    /// `beside`, `[ζ; δΩ]` in rad and rad/s.
    pub(super) fn run(
        &self,
        parameters: &[f64],
        inertia: Inertia,
        beside: &Vector6,
        [mut sensors, mut torques]: [Stream; 2],
        mut watch: impl FnMut(&dyn Fn() -> Moment),
    ) -> Result<Flown, Lost> {
        let set = &self.problem.actuation.torque;
        let (m, count) = (set.count(), self.plan.count());
        let errors = Errors::of(&self.uncertainty.parameters, parameters, m);
        let mut start = self.problem.start;
        start.attitude *= lie::exp(&beside.fixed_rows::<3>(0).into_owned());
        start.angular_velocity += beside.fixed_rows::<3>(3);
        let body = Body { inertia, ..self.problem.body.clone() };
        let truth = Problem { body, start, ..self.problem.clone() };
        let flight = Flight::new(&truth).refined_as(&self.nominal);
        let mut body = flight.start();
        let mut excess = Excess::beside(&self.constraints, self.problem.environment.frame_rate());
        let (mut given, mut line, mut cut) = (vec![0.0; m], DelayLine::new(m), 0);
        let mut limited = Limited::new(&self.actuators, self.plant.authority);
        let (before, during) = self.feedforward.split_at(self.feedforward.len() - count);
        for (from, command) in before {
            let mut command = command.clone();
            limited.cut(&mut command);
            line.command(*from, command);
        }
        let mut less = vec![0.0; m];
        let mut stops = Vec::with_capacity(self.plan.stops().len());
        for (k, (acts, planned)) in during.iter().enumerate() {
            let (time, step) = (self.plan.times()[k], self.plan.times()[k + 1] - self.plan.times()[k]);
            let state = flight.state(time, &body);
            if self.plan.stops().get(stops.len()) == Some(&k) {
                stops.push(self.beside(k, &state));
            }
            let mut command = planned.clone();
            if let Some(gains) = self.gains.filter(|gains| k % gains.every == 0) {
                let mut z = self.measured(k, &state, &errors, &mut sensors).as_slice().to_vec();
                // The controller knows the wheel speeds exactly.
                z.extend(&(Flight::stored(&body) - self.plan.wheel_momentum(k)));
                less = gains.correction(k, &z).collect();
            }
            command.iter_mut().zip(&less).for_each(|(command, less)| *command -= less);
            limited.meet(step, &command);
            cut += usize::from(limited.cut(&mut command));
            if self.plant.quantum > 0.0 {
                command.iter_mut().for_each(|u| *u = (*u / self.plant.quantum).round() * self.plant.quantum);
            }
            watch(&|| self.moment(k, time, &state, command.clone()));
            line.command(*acts, command);
            let ticks = self.plant.ticks(step);
            let tick = step / ticks as f64;
            for index in 0..ticks {
                let (mut now, end) = (time + index as f64 * tick, time + (index + 1) as f64 * tick);
                let noise = self.draws.torque * Vector3::from_fn(|_, _| torques.normal()) / tick.sqrt();
                while now < end - SAME_TIME * tick {
                    // A command whose time is within the tick acts from that time on.
                    let (wanted, until) = line.at(now + SAME_TIME * tick);
                    let until = until.min(end);
                    let part = until - now;
                    let follow = if self.plant.lag > 0.0 { -(-part / self.plant.lag).exp_m1() } else { 1.0 };
                    given
                        .iter_mut()
                        .zip(wanted)
                        .for_each(|(given, wanted)| *given += follow * (wanted - *given));
                    let torque = errors.torque(set, &given) + noise;
                    let held = Held { force: Vector3::zeros(), torque, outside: errors.constant };
                    flight.carry(&mut body, now, &held, part, 1, Some(&mut excess)).ok_or(Lost)?;
                    now = until;
                }
            }
        }
        let time = self.plan.times()[count];
        let state = flight.state(time, &body);
        watch(&|| self.moment(count, time, &state, Vec::new()));
        let end = self.beside(count, &state);
        if !end.iter().all(|value| value.is_finite()) {
            return Err(Lost);
        }
        Ok(Flown {
            end,
            stops,
            room: excess.worst.iter().map(|worst| -worst).collect(),
            input_room: limited.room,
            saturated: cut as f64 / count as f64,
            rejected: 0,
            parameters: Vec::new(),
        })
    }

    /// Returns the deviation `z` from the plan as the controller measures it at node `node`. The
    /// controller multiplies the measured rates by the nominal inertia.
    fn measured(&self, node: usize, state: &State, errors: &Errors, sensors: &mut Stream) -> Vector6 {
        let (planned, planned_rate) = self.plan.node(node);
        let noise = self.draws.sensors * Vector6::from_fn(|_, _| sensors.normal());
        let seen = state.attitude * errors.sensor_turn * lie::exp(&noise.fixed_rows::<3>(0).into_owned());
        let rate = state.angular_velocity.component_mul(&errors.rate_scale) + errors.rate_bias;
        let rate = rate + noise.fixed_rows::<3>(3) - planned_rate;
        stacked(&lie::minus(&seen, planned), &(self.problem.body.inertia.j() * rate))
    }

    fn beside(&self, node: usize, state: &State) -> Vector6 {
        let (planned, rate) = self.plan.node(node);
        stacked(&lie::minus(&state.attitude, planned), &(state.angular_velocity - rate))
    }

    fn moment(&self, node: usize, time: f64, state: &State, commanded: Vec<f64>) -> Moment {
        Moment {
            time,
            attitude: state.attitude,
            angular_velocity: state.angular_velocity,
            beside: self.beside(node, state),
            commanded,
        }
    }
}

fn stacked(first: &Vector3, second: &Vector3) -> Vector6 {
    Vector6::new(first.x, first.y, first.z, second.x, second.y, second.z)
}

fn held(set: &ActuatorSet, inputs: &[f64]) -> Held {
    Held { force: Vector3::zeros(), torque: set.output(inputs), outside: Vector3::zeros() }
}
