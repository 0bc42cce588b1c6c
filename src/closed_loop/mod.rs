//! A plan flown: the true craft under the plan's torques and its gains, with all that it differs by.
//!
//! The plant is not the planner's step: it is the continuous motion of a craft of another inertia, under torques held over a tick
//! (`flight`). A step of the loop:
//!
//! ```text
//! measure  R exp S(β) exp S(ν) ,  (1 + g) Ω + c + ν     z = [log(R*ᵀR) ; J (Ω − Ω*)]     u = u* − K z
//! within limits ─▶ quantum ─▶ delay ─▶ lag  v += (1 − e^{−h/τ})(c − v) ─▶ τ = exp S(α) B (1 + s) v + b + η
//! ```
//!
//! Every case of a seed has random numbers of its own, from a key and a counter (`numerics::random`): the same bits for any number
//! of threads, in any order, alone or among others. Constant errors are drawn once a case; an inertia that is none, because two
//! of its moments are less than the third, is drawn again, and how often is told.

mod statistics;

pub use statistics::{Proportion, Sampled, quantile};

use crate::feedback::Gains;
use crate::flight::{Excess, Flight, Held};
use crate::maneuver::constraint::{Constraint, Pointing, Rule};
use crate::maneuver::{Problem, State};
use crate::mechanics::actuators::ActuatorSet;
use crate::mechanics::body::{Body, Inertia};
use crate::numerics::parallel;
use crate::numerics::random::Stream;
use crate::optimize::linear_plan::{LinearPlan, Matrix6, Parameter, Vector6};
use crate::uncertainty::Uncertainty;
use crate::{Matrix3, Vector3, lie};

/// How the actuators follow what they are told; by default at once, within the limits of the plan.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Plant {
    /// Time constant of their lag \[s\].
    pub lag: f64,
    /// Time from a command to its effect \[s\].
    pub delay: f64,
    /// What commands are multiples of, in the unit of an input; 0: any number.
    pub quantum: f64,
    /// Time between two changes of the torque \[s\]; 0: the step of the plan.
    pub tick: f64,
    /// Whether the plan's commands lead a lag and a delay, which are known.
    pub leads: bool,
    /// What the actuators can give, as a multiple of the limits that the plan keeps: what is above 1 is held back for gains.
    pub authority: f64,
}

impl Default for Plant {
    fn default() -> Self {
        Self { lag: 0.0, delay: 0.0, quantum: 0.0, tick: 0.0, leads: false, authority: 1.0 }
    }
}

/// What became of one case.
#[derive(Clone, Debug, PartialEq)]
pub struct Flown {
    /// `[ζ; δΩ]` at the end, rad and rad/s: true minus planned, body axes.
    pub end: Vector6,
    /// What is least left of each constraint without its margin, along the whole motion: \[rad\] of cones, of rates a part of the
    /// limit; negative where it is violated.
    pub room: Vec<f64>,
    /// Part of the steps in which a limit of the inputs cut a command.
    pub saturated: f64,
    /// Inertias that were drawn and are none.
    pub rejected: u32,
    /// The parameters that were drawn, in the order of [`Uncertainty::parameters`].
    pub parameters: Vec<f64>,
}

/// One step of a case, for people.
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub struct Moment {
    /// Time \[s\].
    pub time: f64,
    /// Attitude, body → reference.
    pub attitude: Matrix3,
    /// Angular velocity [rad/s].
    pub angular_velocity: Vector3,
    /// `[ζ; δΩ]` beside the plan, rad and rad/s.
    pub beside: Vector6,
    /// Inputs that were commanded in the step that begins here, SI; none at the end.
    pub commanded: Vec<f64>,
}

/// A plan that is flown again and again.
#[derive(Clone, Debug)]
pub struct Campaign<'a> {
    problem: &'a Problem,
    plan: &'a LinearPlan,
    gains: Option<&'a Gains>,
    uncertainty: &'a Uncertainty,
    plant: Plant,
    seed: u64,
    /// Threads that share the cases; those there are where none is given.
    threads: Option<usize>,
    /// Constraints without their margins.
    constraints: Vec<Constraint>,
    /// What the nominal motion has settled on.
    nominal: Flight<'a>,
    /// Square roots of the covariances of start, torque noise and sensors.
    roots: (Matrix6, Matrix3, Matrix6),
    /// Ticks a step of the plan.
    ticks: usize,
    /// Commands without feedback, and from when on each acts: those given before the start, then those of the steps.
    feedforward: Vec<(f64, Vec<f64>)>,
}

/// Quantities with streams of their own: a new sensor does not shift the numbers of another.
mod stream {
    pub const PARAMETERS: u32 = 1 << 16;
    pub const START: u32 = PARAMETERS + 1;
    pub const SENSORS: u32 = PARAMETERS + 2;
    pub const TORQUE: u32 = PARAMETERS + 3;
}

/// Inertias drawn before a case is given up: one in two is none about a plate.
const MOST_DRAWS: u32 = 64;

/// Ticks of the plant in a step of the plan, at most.
const MOST_TICKS: usize = 1000;

/// A case that cannot be told: it turned faster than can be followed, or no inertia was one.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Lost;

impl<'a> Campaign<'a> {
    /// Most cases of a run.
    pub const MOST_CASES: u64 = 1_000_000;

    /// Of a maneuver and the motion beside its plan (torques held); without gains it is flown open loop.
    pub fn new(
        problem: &'a Problem,
        plan: &'a LinearPlan,
        gains: Option<&'a Gains>,
        uncertainty: &'a Uncertainty,
        plant: Plant,
        seed: u64,
    ) -> Self {
        let without = |constraint: &Constraint| match &constraint.rule {
            Rule::Pointing(pointing) => {
                let rule = Rule::Pointing(Pointing { margin: 0.0, ..pointing.clone() });
                Constraint { rule, name: constraint.name.clone() }
            }
            _ => constraint.clone(),
        };
        let step = plan.times()[1] - plan.times()[0];
        let ticks =
            if plant.tick > 0.0 { ((step / plant.tick).round() as usize).clamp(1, MOST_TICKS) } else { 1 };
        let mut nominal = Flight::new(problem);
        let steps: Vec<(Held, f64)> = (0..plan.count())
            .map(|k| (held(&problem.actuation.torque, plan.inputs(k)), plan.times()[k + 1] - plan.times()[k]))
            .collect();
        nominal.settle(&steps);
        let mut campaign = Self {
            problem,
            plan,
            gains,
            uncertainty,
            plant,
            seed,
            threads: None,
            constraints: problem.constraints.iter().map(without).collect(),
            nominal,
            roots: (
                root(&uncertainty.start),
                root(&uncertainty.torque_noise),
                root(&uncertainty.sensor_noise),
            ),
            ticks,
            feedforward: Vec::new(),
        };
        campaign.feedforward = campaign.led();
        campaign
    }

    /// The plan's inputs as they are to be commanded: `count` of them at the nodes, behind those that were commanded before the start.
    ///
    /// Where lag and delay are known, a command is what the plan gives on average while it acts, a delay after it is given, and ahead
    /// of the lag: with `v` what the actuators have reached before and `m` the mean of `e^{−t/τ}` over the ticks, they give
    /// `c + (v − c) m` on average, so `c = (u* − m v)/(1 − m)`.
    fn led(&self) -> Vec<(f64, Vec<f64>)> {
        let times = self.plan.times();
        let count = self.plan.count();
        let m = self.plan.axes().ncols();
        if !self.plant.leads {
            return (0..count).map(|k| (times[k] + self.plant.delay, self.plan.inputs(k).to_vec())).collect();
        }
        let delay = self.plant.delay;
        let step = times[1] - times[0];
        // No more than the plan has steps, however long the delay.
        let early = ((delay / step - SAME_TIME).ceil().max(0.0) as usize).min(count);
        let before = (1..=early).rev().map(|j| (delay - j as f64 * step).max(0.0));
        let starts: Vec<f64> = before.chain(times.iter().map(|time| time + delay)).collect();
        let (mut reached, mut commands) = (vec![0.0; m], Vec::with_capacity(starts.len()));
        for ends in starts.windows(2) {
            let mut command = self.planned(ends[0], ends[1]);
            if self.plant.lag > 0.0 {
                let parts = self.ticks as f64;
                let kept = ((ends[0] - ends[1]) / (parts * self.plant.lag)).exp();
                let (mean, whole) = (self.mean_kept(kept), kept.powf(parts));
                for (command, reached) in command.iter_mut().zip(&mut reached) {
                    *command = (*command - mean * *reached) / (1.0 - mean);
                    *reached = *command + whole * (*reached - *command);
                }
            }
            commands.push((ends[0], command));
        }
        commands
    }

    /// Mean of `q, q², … qⁿ` over the ticks of a step.
    fn mean_kept(&self, kept: f64) -> f64 {
        (1..=self.ticks).map(|tick| kept.powf(tick as f64)).sum::<f64>() / self.ticks as f64
    }

    /// Mean of the plan's inputs between two times; beyond its end those of its last step.
    fn planned(&self, from: f64, to: f64) -> Vec<f64> {
        let times = self.plan.times();
        let last = self.plan.count() - 1;
        let mut mean = vec![0.0; self.plan.axes().ncols()];
        let first = times.partition_point(|time| *time <= from).saturating_sub(1).min(last);
        for k in first..=last {
            let end = if k == last { f64::INFINITY } else { times[k + 1] };
            let part = (to.min(end) - from.max(times[k])) / (to - from);
            if part <= 0.0 && k > first {
                break;
            }
            mean.iter_mut().zip(self.plan.inputs(k)).for_each(|(mean, input)| *mean += part.max(0.0) * input);
        }
        mean
    }

    /// Flies a case.
    ///
    /// # Errors
    /// [`Lost`] where it cannot be followed.
    pub fn fly(&self, case: u64) -> Result<Flown, Lost> {
        self.flown(case, |_| ())
    }

    /// Flies a case and shows it step by step.
    ///
    /// # Errors
    /// [`Lost`] where it cannot be followed.
    pub fn traced(&self, case: u64) -> Result<(Flown, Vec<Moment>), Lost> {
        let mut moments = Vec::with_capacity(self.plan.count() + 1);
        let flown = self.flown(case, |moment| moments.push(moment()))?;
        Ok((flown, moments))
    }

    /// Shares the cases among so many threads, which changes none of them; by default among those there are.
    #[must_use]
    pub fn with_threads(self, threads: Option<usize>) -> Self {
        Self { threads, ..self }
    }

    /// Flies the cases `first … first + count`, on several threads.
    pub fn fly_all(&self, first: u64, count: usize) -> Vec<Result<Flown, Lost>> {
        self.each(first, count, |case| self.fly(case))
    }

    /// Flies the cases `first … first + count` step by step, on several threads; of each what `of` makes of it.
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
        /// Cases a thread takes at once: a case takes about 50 µs.
        const BATCH: usize = 16;
        let cases: Vec<u64> = (0..count as u64).map(|case| first + case).collect();
        let mut results: Vec<Result<R, Lost>> = vec![Err(Lost); count];
        parallel::within(self.threads, || parallel::fill(&cases, &mut results, BATCH, |case| of(*case)));
        results
    }

    /// The craft of a case: what its parameters are, its inertia, and how many draws were none.
    fn drawn(&self, case: u64) -> Result<(Vec<f64>, Inertia, u32), Lost> {
        let parameters = &self.uncertainty.parameters;
        let mut stream = Stream::new(self.seed, case, stream::PARAMETERS);
        let mut values: Vec<f64> = parameters.iter().map(|(_, _, sigma)| sigma * stream.normal()).collect();
        let mut rejected = 0;
        loop {
            let mut j = *self.problem.body.inertia.j();
            for (value, (_, parameter, _)) in values.iter().zip(parameters) {
                if let Parameter::Inertia(delta) = parameter {
                    j += delta * *value;
                }
            }
            if let Ok(inertia) = Inertia::new(j) {
                return Ok((values, inertia, rejected));
            }
            rejected += 1;
            if rejected >= MOST_DRAWS {
                return Err(Lost);
            }
            for (value, (_, parameter, sigma)) in values.iter_mut().zip(parameters) {
                if matches!(parameter, Parameter::Inertia(_)) {
                    *value = sigma * stream.normal();
                }
            }
        }
    }

    fn flown(&self, case: u64, watch: impl FnMut(&dyn Fn() -> Moment)) -> Result<Flown, Lost> {
        let (parameters, inertia, rejected) = self.drawn(case)?;
        let mut normal = Stream::new(self.seed, case, stream::START);
        let beside = self.roots.0 * Vector6::from_fn(|_, _| normal.normal());
        let noise = [stream::SENSORS, stream::TORQUE].map(|of| Stream::new(self.seed, case, of));
        let flown = self.run(&parameters, inertia, &beside, noise, watch)?;
        Ok(Flown { rejected, parameters, ..flown })
    }

    /// Flies a craft of these parameters that begins at `beside`, `[ζ; δΩ]`.
    fn run(
        &self,
        parameters: &[f64],
        inertia: Inertia,
        beside: &Vector6,
        [mut sensors, mut torques]: [Stream; 2],
        mut watch: impl FnMut(&dyn Fn() -> Moment),
    ) -> Result<Flown, Lost> {
        let set = &self.problem.actuation.torque;
        let (m, ticks, count) = (set.count(), self.ticks, self.plan.count());
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
        let (before, during) = self.feedforward.split_at(self.feedforward.len() - count);
        for (from, command) in before {
            let mut command = command.clone();
            limit(set, self.plant.authority, &mut command);
            line.command(*from, command);
        }
        for (k, (acts, planned)) in during.iter().enumerate() {
            let (time, step) = (self.plan.times()[k], self.plan.times()[k + 1] - self.plan.times()[k]);
            let state = flight.state(time, &body);
            let mut command = planned.clone();
            if let Some(gains) = self.gains {
                let mut z = self.measured(k, &state, &errors, &mut sensors).as_slice().to_vec();
                // The speeds of wheels are known.
                z.extend(&(Flight::stored(&body) - self.plan.wheel_momentum(k)));
                command.iter_mut().zip(gains.correction(k, &z)).for_each(|(command, less)| *command -= less);
            }
            cut += usize::from(limit(set, self.plant.authority, &mut command));
            if self.plant.quantum > 0.0 {
                command.iter_mut().for_each(|u| *u = (*u / self.plant.quantum).round() * self.plant.quantum);
            }
            watch(&|| self.moment(k, time, &state, command.clone()));
            line.command(*acts, command);
            let tick = step / ticks as f64;
            for index in 0..ticks {
                let (mut now, end) = (time + index as f64 * tick, time + (index + 1) as f64 * tick);
                let noise = self.roots.1 * Vector3::from_fn(|_, _| torques.normal()) / tick.sqrt();
                while now < end - SAME_TIME * tick {
                    // A command whose time comes within the tick acts from then on.
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
            room: excess.worst.iter().map(|worst| -worst).collect(),
            saturated: cut as f64 / count as f64,
            rejected: 0,
            parameters: Vec::new(),
        })
    }

    /// `z` as the controller measures it at node `node`: it multiplies rates by the nominal inertia.
    fn measured(&self, node: usize, state: &State, errors: &Errors, sensors: &mut Stream) -> Vector6 {
        let (planned, planned_rate) = self.plan.node(node);
        let noise = self.roots.2 * Vector6::from_fn(|_, _| sensors.normal());
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

/// Part of a tick by which two times may differ and be one.
const SAME_TIME: f64 = 1e-6;

/// Constant errors of a case.
struct Errors {
    scale: Vec<f64>,
    turn: Matrix3,
    constant: Vector3,
    sensor_turn: Matrix3,
    rate_scale: Vector3,
    rate_bias: Vector3,
}

impl Errors {
    fn of(parameters: &[(String, Parameter, f64)], values: &[f64], inputs: usize) -> Self {
        let zero = Vector3::zeros();
        let (mut turn, mut sensor) = (zero, zero);
        let mut scale = vec![1.0; inputs];
        let (mut constant, mut rate_scale, mut rate_bias) = (zero, Vector3::repeat(1.0), zero);
        for ((_, parameter, _), value) in parameters.iter().zip(values) {
            match parameter {
                Parameter::Inertia(_) => {}
                Parameter::InputScale(input) => scale[*input] += value,
                Parameter::ActuatorTurn(axis) => turn += axis * *value,
                Parameter::ConstantTorque(torque) => constant += torque * *value,
                Parameter::SensorTurn(axis) => sensor += axis * *value,
                Parameter::RateScale(axis) => rate_scale[*axis] += value,
                Parameter::RateBias(bias) => rate_bias += bias * *value,
            }
        }
        Self { scale, turn: lie::exp(&turn), constant, sensor_turn: lie::exp(&sensor), rate_scale, rate_bias }
    }

    /// `exp S(α) B (1 + s) u`.
    fn torque(&self, set: &ActuatorSet, inputs: &[f64]) -> Vector3 {
        let axes = set.axes().iter().zip(inputs).zip(&self.scale);
        let torque: Vector3 = axes.map(|((axis, input), scale)| axis * (input * scale)).sum();
        self.turn * torque
    }
}

/// Commands on their way to the actuators.
struct DelayLine {
    /// When each begins to act, and what it is; zero before the first.
    waiting: std::collections::VecDeque<(f64, Vec<f64>)>,
    acting: Vec<f64>,
}

impl DelayLine {
    fn new(inputs: usize) -> Self {
        Self { waiting: std::collections::VecDeque::new(), acting: vec![0.0; inputs] }
    }

    fn command(&mut self, from: f64, inputs: Vec<f64>) {
        self.waiting.push_back((from, inputs));
    }

    /// What acts at a time, and until when.
    fn at(&mut self, time: f64) -> (&[f64], f64) {
        while self.waiting.front().is_some_and(|(from, _)| *from <= time) {
            if let Some((_, inputs)) = self.waiting.pop_front() {
                self.acting = inputs;
            }
        }
        (&self.acting, self.waiting.front().map_or(f64::INFINITY, |(from, _)| *from))
    }
}

fn held(set: &ActuatorSet, inputs: &[f64]) -> Held {
    Held { force: Vector3::zeros(), torque: set.output(inputs), outside: Vector3::zeros() }
}

/// Cuts inputs to `authority` times the limits of their set; whether any was beyond.
fn limit(set: &ActuatorSet, authority: f64, inputs: &mut [f64]) -> bool {
    let limits = set.limits();
    let mut cut = false;
    if let Some(sizes) = &limits.size {
        for (input, size) in inputs.iter_mut().zip(sizes) {
            let size = &(size * authority);
            let least = if limits.one_sided { 0.0 } else { -size };
            // What is at a limit by round-off is not cut.
            cut |= *input > size * (1.0 + ROUNDING) || *input < least - size * ROUNDING;
            *input = if *input > *size {
                *size
            } else if *input < least {
                least
            } else {
                *input
            };
        }
    }
    if let Some(norm) = limits.norm.map(|norm| norm * authority) {
        let size = set.output(inputs).norm();
        if size > norm {
            cut |= size > norm * (1.0 + ROUNDING);
            inputs.iter_mut().for_each(|input| *input *= norm / size);
        }
    }
    cut
}

/// Part of a limit by which an input may exceed it without being counted.
const ROUNDING: f64 = 1e-9;

/// A square root of a covariance, `root rootᵀ`.
fn root<const N: usize>(covariance: &nalgebra::SMatrix<f64, N, N>) -> nalgebra::SMatrix<f64, N, N>
where
    nalgebra::Const<N>: nalgebra::DimSub<nalgebra::U1>,
    nalgebra::Const<N>: nalgebra::ToTypenum,
    nalgebra::DefaultAllocator:
        nalgebra::allocator::Allocator<nalgebra::DimDiff<nalgebra::Const<N>, nalgebra::U1>>,
{
    let eigen = (0.5 * (covariance + covariance.transpose())).symmetric_eigen();
    let roots = eigen.eigenvalues.map(|value| value.max(0.0).sqrt());
    eigen.eigenvectors * nalgebra::SMatrix::<f64, N, N>::from_diagonal(&roots)
}

#[cfg(test)]
mod tests;
