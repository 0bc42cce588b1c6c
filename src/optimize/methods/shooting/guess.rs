//! Starts of the shooting: rotation senses and windings, counted from the ballistic end point.
//!
//! Let `e_b = log(R_dᵀ R_b)` be the attitude error and `e_p` the other errors at the end of the motion
//! without inputs, and `Ψ₁₂(0)` its sensitivity. The starts are
//!
//! ```text
//! λ_{−1} = −c Ψ₁₂(0)⁻¹ [e; e_p] ,    e = e_b (1 + 2πm/|e_b|) ,   m = 0 short, −1 long, +1, −2, … turns
//! ```
//!
//! For a free body at rest and small angles `m = 0, c = 1` is the discrete optimum of the double
//! integrator. With rates, a potential or a turning frame it counts the senses where they tie.

use crate::Vector3;
use crate::numerics::factor::Factor;
use crate::optimize::step::StepError;
use crate::optimize::sweep::BoundaryValueProblem;
use nalgebra::SVector;
use std::f64::consts::TAU;

/// A costate to start from, and its name in reports.
#[derive(Clone, Debug)]
pub(crate) struct Start<const N: usize> {
    pub name: String,
    pub costate: SVector<f64, N>,
}

/// The name of a start by its turns.
pub(crate) fn name_of(turns: i32) -> String {
    match turns {
        0 => "short".into(),
        -1 => "long".into(),
        1 => "+1 turn".into(),
        _ => format!("{turns:+} turns"),
    }
}

/// The error that stands for a way of `turns` more turns: `e_b (1 + 2π turns/|e_b|)`.
///
/// Without an error there is no axis to turn about; the body's first axis then serves.
pub(crate) fn wound(error: &Vector3, turns: i32) -> Vector3 {
    let angle = error.norm();
    if turns == 0 {
        return *error;
    }
    let axis = if angle > 1e-12 { error / angle } else { Vector3::x() };
    axis * (angle + TAU * f64::from(turns))
}

/// The starts with the given turns, each damped by `fraction`.
pub(crate) fn ballistic<const N: usize>(
    bvp: &BoundaryValueProblem<N>,
    turns: &[i32],
    fractions: &[f64],
) -> Result<Vec<Start<N>>, StepError> {
    let (end, psi) = bvp.sweep_linearized(&SVector::zeros())?;
    let factor = Factor::new(&psi);
    let short: Vector3 = end.error.fixed_rows::<3>(N - 6).into_owned();
    let mut starts = Vec::new();
    for &fraction in fractions {
        for &turns in turns {
            let mut error = end.error;
            error.fixed_rows_mut::<3>(N - 6).copy_from(&wound(&short, turns));
            let costate = factor.solve(&error) * -fraction;
            let name = name_of(turns);
            starts.push(Start { name, costate });
        }
    }
    Ok(starts)
}
