//! Simulation of many flights of a plan.

use crate::failure::{self, detached};
use crate::maneuver::{self, Overrides};
use crate::planned::Planned;
use crate::stops::PlannedSequence;
use crate::watch::Watch;
use numpy::PyArray1;
use pyo3::exceptions::PyValueError;
use pyo3::prelude::*;
use pyo3::types::PyDict;
use serde_json::json;
use slewkit::closed_loop::{Campaign, Flown, Lost};
use slewkit::maneuver::Outcome;
use slewkit::plan::Status;
use slewkit_files::batch::MAX_THREADS;
use slewkit_files::export::ExportError;
use slewkit_files::flown::{Flight, LoopRecord, NotFlown, Runs, WholeFlight};
use slewkit_files::spec::Diagnostics;
use std::time::Instant;

/// Number of cases between two calls of the caller's progress function and checks for signals.
const CHUNK: usize = 4096;

/// Simulates `count` flights of the plan of a maneuver or a sequence, each with another craft that
/// differs from the model, with or without gains. Returns the statistics as JSON, and the cases as
/// named one-dimensional arrays, with NaN for a lost case. Also returns an exception that was
/// raised during the work.
#[pyfunction]
#[pyo3(signature = (planned, count, seed, threads = None, gains = true, overrides = None, progress = None))]
#[expect(clippy::too_many_arguments, reason = "keywords of Python")]
pub fn fly<'py>(
    py: Python<'py>,
    planned: &Bound<'py, PyAny>,
    count: u64,
    seed: u64,
    threads: Option<usize>,
    gains: bool,
    overrides: Overrides<'py>,
    progress: Option<Py<PyAny>>,
) -> PyResult<(String, Bound<'py, PyDict>, Option<PyErr>)> {
    if !(2..=Campaign::MOST_CASES).contains(&count) {
        let reason = format!("runs = {count}: give a number from 2 to {}", Campaign::MOST_CASES);
        return Err(PyValueError::new_err(reason));
    }
    if threads.is_some_and(|threads| !(1..=MAX_THREADS).contains(&threads)) {
        return Err(PyValueError::new_err(format!("threads: give a number from 1 to {MAX_THREADS}")));
    }
    let refused = |reason: &str, remedy: &str| failure::coded(py, "PlanError", "E0173", reason, remedy);
    let overrides = maneuver::overrides(&overrides)?;
    let unsolved = || refused("this plan did not reach its end", "give a solved plan");
    let not_flown = |error: NotFlown| match error {
        NotFlown::File(error) => failure::export(py, &error, "plan"),
        error => failure::coded(py, "PlanError", "E0170", &error.to_string(), error.remedy()),
    };
    let spec_missing = || failure::export(py, &ExportError::NoSpec, "plan");
    let of_spec = |found: Diagnostics| failure::spec(py, &found);
    let (closed_loop, WholeFlight { problem, beside, marks }) =
        if let Ok(sequence) = planned.cast::<PlannedSequence>() {
            let file = sequence.get().file();
            if file.record.status != Status::Solved {
                return Err(unsolved());
            }
            let held = file.record.spec.as_ref().ok_or_else(spec_missing)?;
            let loaded = held.read_sequence("plan, spec", &overrides).map_err(of_spec)?;
            let loaded = loaded.ok_or_else(spec_missing)?;
            let flight = WholeFlight::of(&file, &loaded).map_err(not_flown)?;
            (loaded.closed_loop, flight)
        } else {
            let planned = planned.cast::<Planned>()?.get();
            if planned.plan.solution.outcome != Outcome::Converged {
                return Err(unsolved());
            }
            let file = planned.file();
            let held = file.spec.as_ref().ok_or_else(spec_missing)?;
            let loaded = held.read("plan, spec", &overrides).map_err(of_spec)?;
            let flight = WholeFlight::of_maneuver(&file, &loaded).map_err(not_flown)?;
            (loaded.closed_loop, flight)
        };
    let closed_loop = &closed_loop;
    let Some(uncertainty) = &closed_loop.uncertainty else {
        let reason = "the plan has no uncertainty: the craft would fly as planned";
        let remedy =
            "add [uncertainty] to its spec, or pass overrides={\"uncertainty.inertia.relative\": 0.02}";
        return Err(refused(reason, remedy));
    };
    if gains && beside.gains.is_none() {
        let remedy = "add [feedback] to its spec, or pass overrides={\"feedback.kind\": \"tvlqr\"}; without \
         gains: gains=False";
        return Err(refused("the plan has no gains", remedy));
    }
    let (problem, beside, marks) = (&problem, &beside, &marks[..]);
    let runs = Runs { problem, closed_loop, uncertainty, beside, marks, seed, threads };
    let Some(mut flight) = runs.flight(gains) else {
        return Err(refused("the plan has no covariance", "add [uncertainty]"));
    };
    let (watch, began) = (Watch::new(progress), Instant::now());
    let (record, watch) = detached(py, || {
        let (campaign, mut watch) = (runs.campaign(gains), watch);
        let mut stopped = false;
        while (flight.cases.len() as u64) < count && !stopped {
            let first = flight.cases.len() as u64;
            flight.cases.extend(campaign.fly_all(first, ((count - first) as usize).min(CHUNK)));
            let done = flight.cases.len() as u64;
            stopped = watch.stops("flights", Runs::name(gains), done, began.elapsed().as_secs_f64(), "");
        }
        let loops = LoopRecord::new(problem, marks, &flight);
        let names = problem.constraints.iter().map(|constraint| &constraint.name).collect::<Vec<_>>();
        let record = json!({
            "status": if stopped && (flight.cases.len() as u64) < count { "interrupted" } else { "solved" },
            "name": problem.name,
            "loop": loops,
            "constraints": names,
            "parameters": uncertainty.parameters.iter().map(|(name, ..)| name).collect::<Vec<_>>(),
        });
        (record.to_string(), watch)
    })?;
    let arrays = arrays(py, &flight, &runs)?;
    Ok((record, arrays, watch.raised()))
}

/// Returns the results of the cases as named arrays.
fn arrays<'py>(py: Python<'py>, flight: &Flight<'_>, runs: &Runs<'_>) -> PyResult<Bound<'py, PyDict>> {
    let of = |width: usize, numbers: &dyn Fn(&Flown) -> Vec<f64>| {
        let row = |case: &Result<Flown, Lost>| match case {
            Ok(flown) => numbers(flown),
            Err(Lost) => vec![f64::NAN; width],
        };
        PyArray1::from_vec(py, flight.cases.iter().flat_map(row).collect())
    };
    let named = PyDict::new(py);
    let (constraints, parameters) = (runs.problem.constraints.len(), runs.uncertainty.parameters.len());
    let instants = runs.marks.len();
    named.set_item("end", of(6, &|flown| flown.end.iter().copied().collect()))?;
    // The last instant of a sequence may be its end, whose errors are in `end`.
    let stops = |flown: &Flown| -> Vec<f64> {
        let each = (0..instants).map(|index| flown.stops.get(index).unwrap_or(&flown.end));
        each.flat_map(|error| error.iter().copied()).collect()
    };
    named.set_item("stops", of(6 * instants, &stops))?;
    named.set_item("room", of(constraints, &|flown| flown.room.clone()))?;
    let inputs = flight.cases.iter().flatten().next().map_or(0, |flown| flown.input_room.len());
    named.set_item("input_room", of(inputs, &|flown| flown.input_room.clone()))?;
    named.set_item("saturated", of(1, &|flown| vec![flown.saturated]))?;
    named.set_item("parameters", of(parameters, &|flown| flown.parameters.clone()))?;
    Ok(named)
}
