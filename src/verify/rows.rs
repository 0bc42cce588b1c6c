//! The recorded rows of a plan: whether they fit the problem, and whether they agree with the
//! motion.

use super::discrete::Discrete;
use super::margins::{Margin, Meter};
use super::motion::{InOrder, Inputs, Phase, Scale, judgeable};
use super::verification::WitnessError;
use super::watch::Watch;
use super::wheels::Wheels;
use crate::maneuver::grid::{Grid, GridError};
use crate::maneuver::objective::{self, Objective, Weighted};
use crate::maneuver::problem::{Motion, Problem};
use crate::maneuver::solution::Trajectory;
use crate::propagate::plant::{Output, Plant};
use crate::{Matrix3, Vector3, lie};

/// Returns how many recorded numbers are NaN or infinite.
pub(super) fn not_finite(trajectory: &Trajectory) -> usize {
    let Trajectory { angular_velocity, position, velocity, torque, force, .. } = trajectory;
    let vectors = [angular_velocity, position, velocity, torque, force].into_iter().flatten().flatten();
    let quaternions = trajectory.quaternion.iter().flatten();
    let Trajectory { time, input, costates, wheel_momentum, .. } = trajectory;
    let scalars = [time, input, costates, wheel_momentum].into_iter().flatten();
    vectors.chain(quaternions).chain(scalars).filter(|value| !value.is_finite()).count()
}

/// Returns the angle by which the body turns along its recorded path \[rad\]. It is the sum over
/// the steps, so turning back also counts.
pub(super) fn turned(trajectory: &Trajectory) -> f64 {
    let angle = |pair: &[[f64; 4]]| {
        let apart =
            |sign: f64| pair[0].iter().zip(&pair[1]).map(|(a, b)| (a + sign * b).powi(2)).sum::<f64>().sqrt();
        let (sum, difference) = (apart(1.0), apart(-1.0));
        // Both signs of a quaternion are the same rotation; the nearer sign is used.
        4.0 * sum.min(difference).atan2(sum.max(difference))
    };
    trajectory.quaternion.windows(2).map(angle).sum()
}

/// Returns the angle swept `∫|Ω|dt` \[rad\] from the recorded rates, by the trapezoidal rule.
#[must_use]
pub fn swept(trajectory: &Trajectory) -> f64 {
    let rate = |node: usize| trajectory.angular_velocity[node].norm();
    let nodes = trajectory.time.len().min(trajectory.angular_velocity.len());
    (1..nodes)
        .map(|node| 0.5 * (trajectory.time[node] - trajectory.time[node - 1]) * (rate(node) + rate(node - 1)))
        .sum()
}

/// Checks that the trajectory has every row that the problem needs, and no others.
pub(super) fn fit(problem: &Problem, trajectory: &Trajectory) -> Result<(), WitnessError> {
    let nodes = problem.steps + 1;
    let outputs = problem.input_rows();
    let moves = problem.motion == Motion::RigidBody;
    let on_se3 = |rows: usize| if moves { rows } else { 0 };
    let inputs = problem.actuation.count();
    let wheels = problem.actuation.wheels.as_ref().map_or(0, |wheels| wheels.momentum.len());
    let expected = [
        ("inputs in a row", trajectory.input_count, inputs),
        ("input numbers", trajectory.input.len(), outputs * inputs),
        ("times", trajectory.time.len(), nodes),
        ("quaternions", trajectory.quaternion.len(), nodes),
        ("angular velocities", trajectory.angular_velocity.len(), nodes),
        ("positions", trajectory.position.len(), on_se3(nodes)),
        ("velocities", trajectory.velocity.len(), on_se3(nodes)),
        ("torques", trajectory.torque.len(), outputs),
        ("forces", trajectory.force.len(), on_se3(outputs)),
        ("wheel momenta", trajectory.wheel_momentum.len(), nodes * wheels),
    ];
    match expected.into_iter().find(|(_, found, expected)| found != expected) {
        Some((what, found, expected)) => Err(WitnessError::Rows { what, found, expected }),
        None => Ok(()),
    }
}

/// Returns the grid of a plan, whose rows must fit. For switching inputs the steps are those
/// between the recorded times. Otherwise the grid is uniform over the duration of the problem or,
/// if that is free, of the plan.
pub(super) fn grid(problem: &Problem, trajectory: &Trajectory) -> Result<Grid, WitnessError> {
    if !problem.switches() {
        let found = || trajectory.time.last().copied().ok_or(WitnessError::NotFinite { time: 0.0 });
        let duration = problem.duration.known().map_or_else(found, Ok)?;
        return Ok(Grid::uniform(problem.scheme, duration, problem.steps));
    }
    let lengths: Vec<f64> = trajectory.time.windows(2).map(|pair| pair[1] - pair[0]).collect();
    let negative = |error| match error {
        GridError::Empty => WitnessError::NotFinite { time: 0.0 },
        GridError::Length { index, length } => {
            WitnessError::Step { time: trajectory.time[index], step: length }
        }
    };
    Grid::of_lengths(problem.scheme, &lengths).map_err(negative)
}

/// A node that the discrete witness has reached, with the motion and the inputs there.
pub(super) struct Reached<'a> {
    inputs: &'a Inputs<'a>,
    body: &'a Discrete<'a>,
    /// Momenta of the wheels at this node.
    wheels: &'a [f64],
    index: usize,
    /// The output of the actuators for the input row of this node; `None` if the node has no
    /// inputs.
    output: Option<Output>,
}

impl Reached<'_> {
    /// Returns the index of the input row of this node; `None` if the node has no inputs.
    fn row(&self) -> Option<usize> {
        self.inputs.row_at(self.index)
    }

    /// Returns the attitude of the body at this node.
    pub(super) fn attitude(&self) -> Matrix3 {
        self.body.phase().attitude
    }

    /// Measures the margins at this node, and on the arc that leads to it.
    pub(super) fn measure(&self, meter: &mut Meter) {
        let (problem, time) = (self.inputs.problem, self.body.time());
        let step = self.index.checked_sub(1).map_or(f64::NAN, |before| self.inputs.grid.step(before));
        if let Some(arc) = self.body.arc() {
            meter.arc(time - step, step, arc);
        }
        meter.rate(time, &self.body.phase().angular_velocity(problem));
        meter.wheels(time, self.wheels);
        if let Some(row) = self.row() {
            let before = row.checked_sub(1).map(|row| self.inputs.numbers(row));
            meter.inputs(time, self.inputs.numbers(row), step, before);
        }
    }
}

/// Runs the discrete witness from node to node and calls `visit` at each. For Lie–Verlet the visit
/// is in the middle of the kick at the node.
pub(super) fn walk(
    plant: &Plant,
    inputs: &Inputs,
    watch: Option<&Watch>,
    mut visit: impl FnMut(Reached),
) -> Result<Phase, WitnessError> {
    let problem = plant.problem;
    let start = Phase::of(problem, &problem.start);
    let mut body = Discrete::new(plant, &start, problem.scheme, inputs.grid.step(0));
    let mut wheels = Wheels::new(inputs);
    let mut outputs = InOrder::new(inputs);
    for index in 0..=problem.steps {
        if let Some(watch) = watch {
            watch.step(index)?;
        }
        if index > 0 {
            let (from, to) = outputs.ends(index - 1);
            body.set_step(inputs.grid.step(index - 1));
            body.advance(&from, &to)?;
            wheels.advance(inputs, index - 1);
        }
        let output = inputs.row_at(index).map(|row| outputs.row(row));
        visit(Reached { inputs, body: &body, wheels: wheels.momenta(), index, output });
    }
    Ok(body.phase())
}

/// The results of a run of the discrete witness over the plan.
#[derive(Clone, Debug)]
pub(super) struct Finding {
    pub(super) end: Phase,
    /// Largest scaled difference between recorded and propagated values; NaN if a value is NaN.
    pub(super) recorded: f64,
    pub(super) peak_torque: f64,
    pub(super) peak_rate: f64,
    pub(super) margins: Vec<Margin>,
}

/// Returns the larger number; unlike `f64::max`, NaN if either number is NaN.
pub(super) fn larger(a: f64, b: f64) -> f64 {
    if b > a || b.is_nan() { b } else { a }
}

/// Propagates the plan, compares its rows with the motion and measures its margins. The rows must
/// fit.
pub(super) fn compare(
    plant: &Plant,
    inputs: &Inputs,
    trajectory: &Trajectory,
    watch: &Watch,
) -> Result<Finding, WitnessError> {
    let problem = plant.problem;
    let scale = Scale::of(problem);
    let mut meter = Meter::new(problem);
    let (mut recorded, mut peak_torque, mut peak_rate) = (0.0, 0.0, 0.0);
    let end = walk(plant, inputs, Some(watch), |node| {
        let phase = node.body.phase();
        peak_rate = larger(peak_rate, phase.angular_velocity(problem).norm());
        let time = (trajectory.time[node.index] - node.body.time()).abs() / scale.time;
        recorded = larger(recorded, time);
        // A landed plan records the true motion, which the continuous witness checks.
        if trajectory.target.is_none() {
            let row = node.row().zip(node.output);
            recorded = larger(recorded, node_difference(plant, trajectory, node.index, &phase, row, &scale));
        }
        for (found, momentum) in node.wheels.iter().zip(row_of(trajectory, node.index, node.wheels.len())) {
            recorded = larger(recorded, (found - momentum).abs() * scale.time / scale.inertia);
        }
        if let Some(output) = node.output {
            peak_torque = larger(peak_torque, output.torque.norm());
        }
        node.measure(&mut meter);
    })?;
    Ok(Finding { end, recorded, peak_torque, peak_rate, margins: meter.margins() })
}

/// Returns the recorded momenta of the `count` wheels at a node.
fn row_of(trajectory: &Trajectory, node: usize, count: usize) -> &[f64] {
    &trajectory.wheel_momentum[node * count..(node + 1) * count]
}

/// Returns the largest change of the total inertial momentum `R(Π + μ)` over the recorded states of
/// a free body with wheels. It is relative to the larger of the unit of momentum and the momentum
/// itself. The rows must fit.
pub(super) fn momentum_drift(plant: &Plant, trajectory: &Trajectory) -> f64 {
    let problem = plant.problem;
    let channel = &problem.actuation.torque;
    let total = |node: usize| {
        let attitude = lie::rotation_from_quaternion(&trajectory.quaternion[node]);
        let stored = channel.output(row_of(trajectory, node, channel.count()));
        let momentum = attitude * (problem.body.inertia.j() * trajectory.angular_velocity[node] + stored);
        plant.to_reference(trajectory.time[node]).map_or(momentum, |frame| frame.tr_mul(&momentum))
    };
    let start = problem.start.attitude * {
        let phase = Phase::of(problem, &problem.start);
        phase.momentum + phase.stored
    };
    let scale = Scale::of(problem);
    let unit = (scale.inertia / scale.time).max(start.norm());
    (0..=problem.steps).fold(0.0, |drift, node| larger(drift, (total(node) - start).norm() / unit))
}

/// Returns the largest scaled difference between the recorded and the propagated values at a node.
/// The values are the state, and the output of the actuators for the input row of the node.
pub(super) fn node_difference(
    plant: &Plant,
    trajectory: &Trajectory,
    node: usize,
    phase: &Phase,
    row: Option<(usize, Output)>,
    scale: &Scale,
) -> f64 {
    let states = state_difference(plant, trajectory, node, phase, scale);
    let Some((row, output)) = row else { return states };
    let (torque_unit, force_unit) = scale.loads();
    let acting = plant.actuators(&phase.attitude, &output);
    let torque = larger(states, (trajectory.torque[row] - acting.moment).norm() / torque_unit);
    if !plant.moves {
        return torque;
    }
    larger(torque, (trajectory.force[row] - acting.force).norm() / force_unit)
}

/// Returns the scaled difference between the recorded state at a node and `phase`.
fn state_difference(
    plant: &Plant,
    trajectory: &Trajectory,
    node: usize,
    phase: &Phase,
    scale: &Scale,
) -> f64 {
    let problem = plant.problem;
    let rate: Vector3 = trajectory.angular_velocity[node];
    let q = trajectory.quaternion[node];
    let size = q.iter().map(|part| part * part).sum::<f64>().sqrt();
    let recorded = Phase {
        position: trajectory.position.get(node).copied().unwrap_or_else(Vector3::zeros),
        linear_momentum: trajectory
            .velocity
            .get(node)
            .map_or_else(Vector3::zeros, |velocity| velocity * problem.body.mass.unwrap_or(0.0)),
        attitude: lie::rotation_from_quaternion(&q),
        momentum: problem.body.inertia.j() * rate,
        stored: phase.stored,
    };
    larger(scale.distance(&recorded, phase, problem.motion).largest(), (size - 1.0).abs())
}

/// Propagates the inputs of a plan with the discrete witness, and returns the trajectory without
/// costates.
///
/// `inputs` contains the rows of [`Trajectory::input`] in succession.
///
/// # Errors
/// A [`WitnessError`] if the problem is unusable, the rows do not fit it, or a step has no
/// solution.
pub fn replay(problem: &Problem, inputs: &[f64]) -> Result<Trajectory, WitnessError> {
    problem.check_numbers()?;
    let plant = judgeable(problem)?;
    let rows = Inputs::checked(problem, inputs)?;
    let count = problem.actuation.count();
    let mut found = Trajectory { input: inputs.to_vec(), input_count: count, ..Trajectory::default() };
    let (nodes, outputs) = (problem.steps + 1, problem.input_rows());
    found.time.reserve_exact(nodes);
    found.quaternion.reserve_exact(nodes);
    found.angular_velocity.reserve_exact(nodes);
    found.torque.reserve_exact(outputs);
    let mut quaternion = lie::quaternion_from_rotation(&problem.start.attitude);
    walk(&plant, &rows, None, |node| {
        let phase = node.body.phase();
        quaternion = lie::continued(Some(&quaternion), lie::quaternion_from_rotation(&phase.attitude));
        found.time.push(node.body.time());
        found.quaternion.push(quaternion);
        found.angular_velocity.push(phase.angular_velocity(problem));
        if plant.moves {
            found.position.push(phase.position);
            found.velocity.push(phase.velocity(problem));
        }
        found.wheel_momentum.extend(node.wheels);
        if let Some(output) = &node.output {
            let acting = plant.actuators(&phase.attitude, output);
            found.torque.push(acting.moment);
            if plant.moves {
                found.force.push(acting.force);
            }
        }
    })?;
    Ok(found)
}

/// Returns the margins of the discrete motion under the inputs of a plan to every limit and
/// constraint of `problem`. Torque limits come first, then wheels, forces, and the constraints in
/// their order.
///
/// `inputs` contains the rows of [`Trajectory::input`] in succession.
///
/// # Errors
/// A [`WitnessError`] if the problem is unusable, the rows do not fit it, or a step has no
/// solution.
pub fn margins(problem: &Problem, inputs: &[f64]) -> Result<Vec<Margin>, WitnessError> {
    problem.check_numbers()?;
    let plant = judgeable(problem)?;
    let inputs = Inputs::checked(problem, inputs)?;
    let mut meter = Meter::new(problem);
    walk(&plant, &inputs, None, |node| node.measure(&mut meter))?;
    Ok(meter.margins())
}

/// Returns the cost of a plan: the effort or fuel of its inputs, or its duration for minimum time.
/// The rows must fit the problem. Returns NaN if inputs belong to nodes and the duration is unknown
/// ([`Trajectory::completed`]).
pub fn cost(problem: &Problem, trajectory: &Trajectory) -> f64 {
    if problem.duration.known().is_none() && !problem.switches() {
        return f64::NAN;
    }
    match &problem.objective {
        Objective::Effort(weights) => {
            let of_time = |price| price * problem.seconds();
            effort(problem, &trajectory.input) + weights.time_price.map_or(0.0, of_time)
        }
        Objective::Time => trajectory.time.last().copied().unwrap_or(f64::NAN),
        Objective::Fuel(fuel) => {
            let rate = |row: &[f64]| fuel.rate(&problem.actuation, row);
            if problem.is_shaped() {
                return at_nodes(problem, &trajectory.input, rate);
            }
            let rows = trajectory.input.chunks_exact(problem.actuation.count());
            rows.zip(trajectory.time.windows(2)).map(|(row, ends)| (ends[1] - ends[0]) * rate(row)).sum()
        }
    }
}

/// Returns the effort of the inputs of a plan, `Σ (h/2) uᵀWu`; for Lie–Verlet the first and the
/// last row count half. The rows must fit the problem, and the grid must be uniform.
pub fn effort(problem: &Problem, inputs: &[f64]) -> f64 {
    let weights = problem.objective.weights();
    let (torque, force) = (weights.torque(&problem.actuation), weights.force(&problem.actuation));
    let price = |inputs: &Weighted, row: &[f64]| objective::effort(&inputs.weight, row);
    at_nodes(problem, inputs, |row| {
        let (forces, torques) = problem.actuation.split_costs(row);
        price(&torque, torques) + force.as_ref().map_or(0.0, |force| price(force, forces))
    })
}

/// Returns `Σ h rate(u)` over the nodes of a uniform grid. For Lie–Verlet the first and the last
/// row count half.
fn at_nodes(problem: &Problem, inputs: &[f64], rate: impl Fn(&[f64]) -> f64) -> f64 {
    let last = (inputs.len() / problem.actuation.count()).saturating_sub(1);
    let rows = inputs.chunks_exact(problem.actuation.count()).enumerate().map(|(index, row)| {
        let end = problem.grid().has_half_kicks() && (index == 0 || index == last);
        if end { 0.5 * rate(row) } else { rate(row) }
    });
    problem.step() * rows.sum::<f64>()
}
