//! The continuous witness under the torque held over each step of the plan, and the witnesses that
//! start from its states.

use super::continuous::Continuous;
use super::margins::{Margin, Meter};
use super::motion::{InOrder, Inputs, Phase, Scale};
use super::order::{self, Stage};
use super::rows::{larger, node_difference};
use super::symplectic;
use super::verification::WitnessError;
use super::watch::Watch;
use super::window::{Marks, Window};
use crate::lie;
use crate::maneuver::constraint::Arc;
use crate::maneuver::solution::Trajectory;
use crate::propagate::plant::Plant;

/// The results of all witnesses that propagate the held torque.
pub(super) struct Held {
    pub method: &'static str,
    pub end: Phase,
    /// Margins of the continuous motion to rate limits and cones; empty if the problem has no
    /// constraints.
    pub margins: Vec<Margin>,
    /// Largest scaled difference between this motion and the states that a landed plan records; NaN
    /// if a number is NaN.
    pub recorded: f64,
    pub windows: Result<OnWindows, WitnessError>,
}

/// The results of the witnesses that run over windows of the plan.
pub(super) struct OnWindows {
    /// Total number of steps of the plan in the windows.
    pub steps: usize,
    /// Number of windows.
    pub windows: usize,
    /// The result of the symplectic witness, or the reason why it cannot check the plan.
    pub symplectic: Result<Symplectic, &'static str>,
    pub order: order::Comparison,
}

/// The results of the symplectic witness.
pub(super) struct Symplectic {
    /// State of the symplectic witness at the end of the last window, which is the end of the plan.
    pub end: Phase,
    pub order: usize,
    pub apart: f64,
    pub limit: f64,
}

/// Runs the continuous witness under the held torque, and the witnesses that start from its states.
///
/// `flown` is the plan if it records the true motion.
pub(super) fn held_witnesses(
    plant: &Plant,
    inputs: &Inputs,
    start: &Phase,
    flown: Option<&Trajectory>,
    watch: &Watch,
) -> Result<Held, WitnessError> {
    let Passage { end, method, margins, recorded, windows } = held_end(plant, inputs, start, flown, watch)?;
    let stage = Stage { plant, inputs, windows: &windows, watch: *watch };
    let on_windows = || {
        let mut symplectic = Err("has not run");
        for finer in symplectic::FINER {
            let next = match symplectic::ends(plant, inputs, &windows, finer, watch)? {
                Err(why) => Err(why),
                Ok((ends, order)) => {
                    let (apart, limit) = stage.agreement(&ends)?;
                    // At least one window exists because the plan has at least one step.
                    Ok(Symplectic { end: ends[ends.len() - 1], order, apart, limit })
                }
            };
            // If a finer level needs too many steps, the result of the coarser level stands.
            if next.is_err() && symplectic.is_ok() {
                break;
            }
            let agrees = next.as_ref().is_ok_and(|found: &Symplectic| found.apart <= found.limit);
            symplectic = next;
            if agrees || matches!(&symplectic, Err(why) if *why != symplectic::NO_CONVERGENCE) {
                break;
            }
        }
        let order = stage.compare()?;
        Ok(OnWindows { steps: stage.steps(), windows: windows.len(), symplectic, order })
    };
    let windows = on_windows();
    Ok(Held { method, end, margins, recorded, windows })
}

/// Number of pieces of a step; the continuous motion on each piece is treated as a rotation about a
/// fixed axis. The resulting error is of second order in the length of the pieces, and is a small
/// part of the error of the discrete motion (`tests/laws/witnesses/margins.rs`).
pub(super) const PIECES: usize = 8;

/// The results that the continuous witness records along the plan.
struct Passage {
    end: Phase,
    method: &'static str,
    margins: Vec<Margin>,
    recorded: f64,
    windows: Vec<Window>,
}

/// Runs the continuous witness under the held torque. Returns its end and method, its margins to
/// rate limits and cones if the problem has constraints, and its states at both ends of each
/// window.
fn held_end(
    plant: &Plant,
    inputs: &Inputs,
    start: &Phase,
    flown: Option<&Trajectory>,
    watch: &Watch,
) -> Result<Passage, WitnessError> {
    let problem = plant.problem;
    let mut body = Continuous::new(plant, start);
    let mut marks = Marks::new(problem, &inputs.grid, start);
    let pieces = if problem.constraints.is_empty() { 1 } else { PIECES };
    let mut meter = (pieces > 1).then(|| Meter::new(problem));
    if let Some(meter) = &mut meter {
        meter.rate(0.0, &problem.start.angular_velocity);
    }
    let scale = Scale::of(problem);
    let mut recorded = 0.0;
    let mut meet = |node: usize, body: &Continuous| {
        let Some(plan) = flown else { return };
        let (time, row) = (inputs.grid.after(node), inputs.row_at(node));
        let row = row.map(|row| (row, inputs.row(row)));
        recorded = larger(recorded, node_difference(plant, plan, node, &body.phase(time), row, &scale));
    };
    marks.pass(0, &body);
    meet(0, &body);
    let mut outputs = InOrder::new(inputs);
    for k in 0..problem.steps {
        watch.step(k)?;
        let held = outputs.held(k);
        let Some(meter) = &mut meter else {
            body.advance(inputs.grid.after(k), inputs.grid.step(k), &held, &held)?;
            marks.pass(k + 1, &body);
            meet(k + 1, &body);
            continue;
        };
        let piece = inputs.grid.step(k) / pieces as f64;
        for index in 0..pieces {
            let time = inputs.grid.after(k) + index as f64 * piece;
            let before = body.inertial_attitude();
            body.advance(time, piece, &held, &held)?;
            let turn = lie::minus(&body.inertial_attitude(), &before);
            meter.arc(time, piece, &Arc { start: before, turn });
            meter.rate(time + piece, &body.phase(time + piece).angular_velocity(problem));
        }
        marks.pass(k + 1, &body);
        meet(k + 1, &body);
    }
    let margins = meter.map_or_else(Vec::new, |meter| meter.margins());
    let (end, method) = (body.phase(problem.seconds()), body.method());
    Ok(Passage { end, method, margins, recorded, windows: marks.windows() })
}

/// Returns the end of the continuous motion under the torque that is interpolated linearly between
/// the rows of the plan.
pub(super) fn continuous_end(
    plant: &Plant,
    start: &Phase,
    inputs: &Inputs,
    watch: &Watch,
) -> Result<Phase, WitnessError> {
    let problem = plant.problem;
    let mut body = Continuous::new(plant, start);
    let mut outputs = InOrder::new(inputs);
    for k in 0..problem.steps {
        watch.step(k)?;
        let (from, to) = outputs.ends(k);
        body.advance(inputs.grid.after(k), inputs.grid.step(k), &from, &to)?;
    }
    Ok(body.phase(problem.seconds()))
}
