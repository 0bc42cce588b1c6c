//! Starts of shooting: homotopy classes and windings, counted from the ballistic end point, and
//! given costates.
//!
//! Let `e_b = log(R_dᵀ R_b)` be the attitude error and `e_p` the other errors at the end of the
//! motion without inputs, and `Ψ₁₂(0)` its sensitivity. The starts are
//!
//! ```text
//! λ_{−1} = −c Ψ₁₂(0)⁻¹ [e; e_p] ,    e = e_b (1 + 2πm/|e_b|) ,   m = 0 short, −1 long, +1, −2, … turns
//! ```
//!
//! For a free body at rest and small angles, `m = 0, c = 1` is the discrete optimum of the double
//! integrator. With boundary rates, a potential or a rotating frame, the classes are counted from
//! the ballistic motion, where both are equally long.

pub mod any_attitude;
pub mod coarse;
pub mod detour;
pub mod families;
pub mod first_duration;
pub mod paths;
pub mod transfer;

use crate::Vector3;
use crate::lie;
use crate::maneuver::problem::{Path, Problem, Scheme};
use crate::maneuver::solution::Outcome;
use crate::numerics::factor::Factor;
use crate::optimize::discrete::candidate::Candidate;
use crate::optimize::discrete::step::StepError;
use crate::optimize::discrete::sweep::BoundaryValueProblem;
use crate::optimize::methods::shooting::newton::outcome_of;
use nalgebra::SVector;
use std::f64::consts::TAU;

/// Name of the start from the costates of a guess.
pub const GUESS: &str = "guess";
/// Name of the start from the costates of a plan that is being solved again.
pub const WARM: &str = "warm";

/// Returns the name of a start with this number of turns.
pub(crate) fn name_of(turns: i32) -> String {
    match turns {
        0 => "short".into(),
        -1 => "long".into(),
        1 => "+1 turn".into(),
        _ => format!("{turns:+} turns"),
    }
}

/// Returns the attitude error for a path with `turns` additional turns: `e_b (1 + 2π turns/|e_b|)`.
///
/// If the error is zero, the turns are about the first body axis.
pub(crate) fn wound(error: &Vector3, turns: i32) -> Vector3 {
    let angle = error.norm();
    if turns == 0 {
        return *error;
    }
    let axis = if angle > 1e-12 { error / angle } else { Vector3::x() };
    axis * (angle + TAU * f64::from(turns))
}

/// Returns the numbers of additional turns to try, in order.
pub fn wanted_turns(problem: &Problem) -> Vec<i32> {
    match problem.path {
        Path::Best => vec![0, -1],
        Path::Shortest => vec![0],
        Path::Long => vec![-1],
        Path::AsGiven(rotation) => vec![turns_as_given(problem, &rotation)],
    }
}

/// Returns the number of turns by which the given rotation differs from the shortest one between
/// the boundary attitudes. It only names the start; the given extremal is recognised by its own
/// rotation.
fn turns_as_given(problem: &Problem, rotation: &Vector3) -> i32 {
    let short = lie::minus(&problem.end.attitude, &problem.start.attitude);
    // A rotation by 370° is 10° and one turn; one by −350° about the same axis is 10° less one
    // turn.
    let axis = if short.norm() > 1e-12 { short / short.norm() } else { Vector3::x() };
    let along = rotation.norm() * rotation.dot(&axis).signum();
    ((along - short.norm()) / TAU).round() as i32
}

/// Returns the starts with the given numbers of turns, each with its costate multiplied by
/// `fraction`.
pub fn ballistic<const N: usize>(
    bvp: &BoundaryValueProblem<N>,
    turns: &[i32],
    fraction: f64,
) -> Result<Vec<Candidate>, StepError> {
    let (end, psi) = bvp.sweep_linearized(&SVector::zeros())?;
    let factor = Factor::new(&psi);
    let short: Vector3 = end.error.fixed_rows::<3>(N - 6).into_owned();
    let start = |turns: &i32| {
        let mut error = end.error;
        error.fixed_rows_mut::<3>(N - 6).copy_from(&wound(&short, *turns));
        let costate = factor.solve(&error) * -fraction;
        Candidate::of_costate(&name_of(*turns), &bvp.dynamics.grid, &costate)
    };
    Ok(turns.iter().map(start).collect())
}

/// Returns the scaled `λ_{−1}` from costates in the form of a solution: SI units, `λ_0` for
/// Lie–Euler, `λ_{−1}` for Lie–Verlet.
pub(crate) fn given<const N: usize>(
    problem: &Problem,
    bvp: &BoundaryValueProblem<N>,
    costates: &[f64],
) -> Result<SVector<f64, N>, Outcome> {
    let scaled = SVector::<f64, N>::from_row_slice(costates).component_div(&bvp.dynamics.units.costate());
    match problem.scheme {
        Scheme::LieVerlet => Ok(scaled),
        Scheme::LieEuler => {
            let first = bvp.dynamics.transition::<N>(0, &bvp.start, &scaled);
            first.map(|transition| transition.costate_before).map_err(outcome_of)
        }
    }
}
