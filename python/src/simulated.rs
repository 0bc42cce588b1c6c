//! Simulation of motions without optimisation; the rows are returned as arrays.

use crate::failure::{self, detached};
use crate::maneuver::{Maneuver, Overrides, load, overrides};
use crate::watch::Watch;
use numpy::PyArray1;
use pyo3::exceptions::PyValueError;
use pyo3::prelude::*;
use pyo3::types::PyDict;
use slewkit::maneuver::Problem;
use slewkit::propagate::integrator::{Kind, StepError};
use slewkit::propagate::simulate::{Observer, Simulation, SimulationError, SimulationRow};
use slewkit::verify::WitnessError;
use slewkit::verify::propagation::{Propagation, Propagator, propagate};
use slewkit_files::export::SimulationFile;
use slewkit_files::spec::Spec;
use slewkit_report::simulation_page;
use std::ops::ControlFlow;
use std::time::Instant;

/// Method by which a motion is propagated.
enum Carrier {
    /// An integrator for one or several bodies.
    Integrator(Box<Simulation>),
    /// The equations of motion of the witnesses, for a body with reaction wheels.
    Witness(Box<Problem>, Propagator, Option<Vec<f64>>),
}

/// A motion to be propagated, with its propagation method.
struct Motion {
    carrier: Carrier,
    name: String,
    integrator: Kind,
    bodies: Vec<String>,
    moves: Vec<bool>,
    duration: f64,
    steps: u64,
    stride: u64,
}

/// Reason why a motion ended early.
enum Ended {
    NotFinite(String),
    Failed(String),
}

impl Motion {
    fn of_bodies(simulation: Simulation) -> Self {
        Self {
            name: simulation.name.clone(),
            integrator: simulation.kind,
            bodies: simulation.bodies.clone(),
            moves: simulation.system.bodies().iter().map(|body| body.mass.is_some()).collect(),
            duration: simulation.duration,
            steps: simulation.steps,
            stride: simulation.stride,
            carrier: Carrier::Integrator(Box::new(simulation)),
        }
    }

    fn of_maneuver(problem: &Problem, asked: &Asked) -> PyResult<Self> {
        let inputs = asked.inputs.as_deref();
        if inputs.into_iter().flatten().any(|value| !value.is_finite()) {
            return Err(PyValueError::new_err("inputs: every input must be finite"));
        }
        let Some(duration) = problem.duration.known() else {
            let reason = "the duration of the maneuver is free: plan it first, or set maneuver.duration_s";
            return Err(PyValueError::new_err(reason));
        };
        if problem.actuation.wheels.is_none() {
            let made = Simulation::of(problem, inputs);
            let mut simulation = made.map_err(|error| PyValueError::new_err(error.to_string()))?;
            simulation.steps = problem.steps as u64;
            return Ok(Self::of_bodies(simulation));
        }
        let integrator = asked.integrator.unwrap_or(Kind::LieVerlet);
        let propagator = match integrator {
            Kind::LieVerlet => Propagator::LieVerlet,
            Kind::Verner98 => Propagator::Verner98,
            other => {
                let reason = format!("integrator {other}: reaction wheels need lie_verlet or verner98");
                return Err(PyValueError::new_err(reason));
            }
        };
        Ok(Self {
            name: problem.name.clone(),
            integrator,
            bodies: vec!["body 1".into()],
            moves: vec![problem.motion == slewkit::maneuver::Motion::RigidBody],
            duration,
            steps: problem.steps as u64,
            stride: 1,
            carrier: Carrier::Witness(Box::new(problem.clone()), propagator, asked.inputs.clone()),
        })
    }

    fn asked(mut self, asked: &Asked) -> Self {
        self.integrator = asked.integrator.unwrap_or(self.integrator);
        self.steps = asked.steps.unwrap_or(self.steps);
        self.stride = asked.stride.unwrap_or(self.stride);
        if let Carrier::Integrator(simulation) = &mut self.carrier {
            simulation.kind = self.integrator;
            (simulation.steps, simulation.stride) = (self.steps, self.stride);
        }
        self
    }

    fn run(&self, rows: &mut Rows) -> Result<(), Ended> {
        match &self.carrier {
            Carrier::Integrator(simulation) => simulation.run(rows).map(drop).map_err(|error| {
                let text = error.to_string();
                match error {
                    SimulationError::Step { error: StepError::NotFinite, .. } => Ended::NotFinite(text),
                    _ => Ended::Failed(text),
                }
            }),
            Carrier::Witness(problem, propagator, inputs) => {
                let (steps, stride, inputs) = (self.steps, self.stride, inputs.as_deref());
                let settings = Propagation { propagator: *propagator, steps, stride, inputs };
                propagate(problem, &settings, rows).map(drop).map_err(|error| {
                    let text = error.to_string();
                    match error {
                        WitnessError::NotFinite { .. } => Ended::NotFinite(text),
                        _ => Ended::Failed(text),
                    }
                })
            }
        }
    }
}

/// Arguments of the caller, which replace values of the spec.
struct Asked {
    steps: Option<u64>,
    stride: Option<u64>,
    integrator: Option<Kind>,
    inputs: Option<Vec<f64>>,
}

/// Rows of one body, stored by quantity.
#[derive(Default)]
struct BodyRows {
    quaternion: Vec<f64>,
    angular_velocity: Vec<f64>,
    position: Vec<f64>,
    velocity: Vec<f64>,
}

/// Rows of a simulation, stored by quantity.
struct Rows {
    watch: Watch,
    began: Instant,
    stopped: bool,
    time: Vec<f64>,
    bodies: Vec<BodyRows>,
    energy: Vec<f64>,
    linear_momentum: Vec<f64>,
    angular_momentum: Vec<f64>,
    orthogonality: Vec<f64>,
}

impl Observer for Rows {
    fn on_row(&mut self, row: &SimulationRow) -> ControlFlow<()> {
        self.time.push(row.time);
        for (rows, body) in self.bodies.iter_mut().zip(&row.bodies) {
            rows.quaternion.extend(body.quaternion);
            rows.angular_velocity.extend(&body.angular_velocity);
            rows.position.extend(&body.position);
            rows.velocity.extend(&body.velocity);
        }
        self.energy.push(row.invariants.energy);
        self.linear_momentum.extend(&row.invariants.linear_momentum);
        self.angular_momentum.extend(&row.invariants.angular_momentum);
        self.orthogonality.push(row.invariants.orthogonality);
        ControlFlow::Continue(())
    }

    fn on_step(&mut self, steps: u64) -> ControlFlow<()> {
        // Reading the clock takes as long as a short step, so it is not read in every step.
        if steps.is_multiple_of(64)
            && self.watch.stops("simulation", "", steps, self.began.elapsed().as_secs_f64(), "")
        {
            self.stopped = true;
            return ControlFlow::Break(());
        }
        ControlFlow::Continue(())
    }
}

/// Propagates the bodies of a spec from their start. Returns the rows and their properties as a
/// dictionary, and an exception that was raised during the work.
#[pyfunction]
#[pyo3(signature = (
    spec, overrides = None, steps = None, stride = None, integrator = None, inputs = None, progress
    = None
))]
#[expect(clippy::too_many_arguments, reason = "keywords of the function of the package")]
pub fn simulate<'py>(
    py: Python<'py>,
    spec: &Bound<'py, PyAny>,
    overrides: Overrides<'py>,
    steps: Option<u64>,
    stride: Option<u64>,
    integrator: Option<&str>,
    inputs: Option<Vec<f64>>,
    progress: Option<Py<PyAny>>,
) -> PyResult<(Bound<'py, PyDict>, Option<PyErr>)> {
    let integrator = integrator.map(str::parse::<Kind>).transpose();
    let integrator = integrator.map_err(|error| PyValueError::new_err(error.to_string()))?;
    if steps == Some(0) || stride == Some(0) {
        return Err(PyValueError::new_err("steps and stride are at least 1"));
    }
    let asked = Asked { steps, stride, integrator, inputs };
    let motion = match spec.cast::<Maneuver>() {
        Ok(maneuver) => Motion::of_maneuver(&maneuver.get().loaded.problem, &asked)?,
        Err(_) => {
            match load(spec, &self::overrides(&overrides)?)?.map_err(|found| failure::spec(py, &found))? {
                Spec::Maneuver(loaded) => Motion::of_maneuver(&loaded.problem, &asked)?,
                Spec::Sequence(_) => {
                    let reason = "this spec has stops, and a simulation has none: remove [[stop]]";
                    return Err(PyValueError::new_err(reason));
                }
                Spec::Simulation(_) if asked.inputs.is_some() => {
                    let reason = "inputs: the bodies of a simulation spec have no actuators";
                    return Err(PyValueError::new_err(reason));
                }
                Spec::Simulation(loaded) => Motion::of_bodies(loaded.simulation),
            }
        }
    };
    let motion = motion.asked(&asked);
    let mut rows = Rows {
        watch: Watch::new(progress),
        began: Instant::now(),
        stopped: false,
        time: Vec::new(),
        bodies: motion.moves.iter().map(|_| BodyRows::default()).collect(),
        energy: Vec::new(),
        linear_momentum: Vec::new(),
        angular_momentum: Vec::new(),
        orthogonality: Vec::new(),
    };
    let ended = detached(py, || motion.run(&mut rows))?;
    let status = match &ended {
        Ok(()) if rows.stopped => "interrupted",
        Ok(()) => "simulated",
        Err(Ended::NotFinite(_)) => "not_finite",
        Err(Ended::Failed(reason)) => return Err(PyValueError::new_err(reason.clone())),
    };
    let found = PyDict::new(py);
    found.set_item("status", status)?;
    if let Err(Ended::NotFinite(reason)) = &ended {
        found.set_item("reason", reason)?;
    }
    found.set_item("name", &motion.name)?;
    found.set_item("integrator", motion.integrator.name())?;
    found.set_item("duration_s", motion.duration)?;
    found.set_item("steps", motion.steps)?;
    found.set_item("stride", motion.stride)?;
    found.set_item("time", PyArray1::from_vec(py, rows.time))?;
    let mut bodies = Vec::new();
    for ((name, moves), body) in motion.bodies.iter().zip(&motion.moves).zip(rows.bodies) {
        let of_body = PyDict::new(py);
        of_body.set_item("name", name)?;
        of_body.set_item("moves", moves)?;
        of_body.set_item("quaternion_wxyz", PyArray1::from_vec(py, body.quaternion))?;
        of_body.set_item("angular_velocity", PyArray1::from_vec(py, body.angular_velocity))?;
        of_body.set_item("position", PyArray1::from_vec(py, body.position))?;
        of_body.set_item("velocity", PyArray1::from_vec(py, body.velocity))?;
        bodies.push(of_body);
    }
    found.set_item("bodies", bodies)?;
    found.set_item("energy", PyArray1::from_vec(py, rows.energy))?;
    found.set_item("linear_momentum", PyArray1::from_vec(py, rows.linear_momentum))?;
    found.set_item("angular_momentum", PyArray1::from_vec(py, rows.angular_momentum))?;
    found.set_item("orthogonality", PyArray1::from_vec(py, rows.orthogonality))?;
    Ok((found, rows.watch.raised()))
}

/// Returns the HTML page of a simulation, from the JSON document of `slew simulate --format json`.
#[pyfunction]
pub fn simulation_report(py: Python<'_>, document: &str, euler: &str) -> PyResult<String> {
    let euler = failure::sequence(euler)?;
    let page =
        detached(py, || SimulationFile::read(document.as_bytes()).map(|file| simulation_page(&file, euler)))?;
    page.map_err(|error| failure::export(py, &error, "simulation"))
}
