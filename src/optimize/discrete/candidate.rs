//! The candidate: a maneuver on one grid, complete or partial, in the solver's units.
//!
//! A candidate holds the data that its method has computed. The rest follows: states and inputs
//! from the first costate by the sweep, momenta and inputs from poses by inverse dynamics.
//!
//! # What does every method improve?
//!
//! A `Candidate`: a maneuver on one grid, complete or partial. It owns the grid (its steps and its
//! duration), states, inputs, costates, multipliers, and its provenance: the start and the work
//! done so far. A shooting candidate is one costate. A path around a cone consists of poses alone.
//! `Method::improve(candidate, budget) -> Attempt` is the whole interface. Shooting, coarse to
//! fine, descents on paths, the lifted Newton method, the interior point method and SCP implement
//! it, so a search that needs another method adds a line. Tightening the limits until the true
//! motion keeps them is not such a method: its result is a candidate within *wider* limits, which
//! is not a candidate of the maneuver.

use crate::maneuver::grid::Grid;
use crate::maneuver::settings::Method;
use crate::optimize::discrete::step::Point;
use nalgebra::{DMatrix, DVector, SMatrix, SVector};

/// A maneuver that a method may improve.
#[derive(Clone, Debug)]
pub(crate) struct Candidate {
    /// Grid in the solver's unit of time: its steps and its duration.
    pub grid: Grid,
    /// States `y_0 … y_N`; empty if unknown. With wheels the momentum is that of body and wheels
    /// together.
    pub states: Vec<Point>,
    /// Wheel momenta at the nodes `0 … N`; empty without wheels.
    pub wheels: Vec<DVector<f64>>,
    /// Inputs `u_0 … u_N` (`u_0` is unused by Lie–Euler); empty if unknown.
    pub inputs: Vec<Vec<f64>>,
    /// Costates `λ_{−1} … λ_{N−1}`, or `λ_{−1}` alone if a sweep computes the others; empty if
    /// unknown. The costates of the wheels come last in each vector.
    pub costates: Vec<DVector<f64>>,
    /// Multipliers of the terminal condition, and of the rows of all limits; both empty if the
    /// method does not compute them.
    pub multipliers: (DVector<f64>, Vec<f64>),
    /// `Ψ₁₂ = ∂z_N/∂λ_{−1}`, the sensitivity of the final state to the first costate; `None` if the
    /// method did not compute it.
    pub sensitivity: Option<DMatrix<f64>>,
    /// Origin of the candidate: the method, the start and the iterations so far.
    pub provenance: Provenance,
}

/// Origin of a candidate, and the work spent on it so far.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Provenance {
    /// Method that computed the candidate.
    pub method: Method,
    /// Name of the start: "short", "long", "+1 turn", …
    pub start: String,
    /// Newton iterations and convex subproblems since the start, summed over all strategies.
    pub iterations: usize,
    /// Number of convex subproblems among the iterations.
    pub subproblems: usize,
    /// Whether the path has already been led around the cones.
    pub led_past: bool,
}

impl Candidate {
    /// Returns a candidate without states, inputs and costates: a grid and the name of its start.
    pub fn empty(method: Method, start: &str, grid: Grid) -> Self {
        let provenance =
            Provenance { method, start: start.into(), iterations: 0, subproblems: 0, led_past: false };
        Self {
            grid,
            states: Vec::new(),
            wheels: Vec::new(),
            inputs: Vec::new(),
            costates: Vec::new(),
            multipliers: (DVector::zeros(0), Vec::new()),
            sensitivity: None,
            provenance,
        }
    }

    /// Returns the extremal that the sweep from `λ_{−1} = costate` computes.
    pub fn of_costate<const N: usize>(start: &str, grid: &Grid, costate: &SVector<f64, N>) -> Self {
        Self::empty(Method::Shooting, start, grid.clone()).with_costate(costate)
    }

    /// Replaces `λ_{−1}` and discards the states, inputs and costates that depended on the old
    /// value.
    pub fn with_costate<const N: usize>(self, costate: &SVector<f64, N>) -> Self {
        let provenance = Provenance { method: Method::Shooting, ..self.provenance };
        let costates = vec![DVector::from_column_slice(costate.as_slice())];
        Self { costates, provenance, ..Self::empty(Method::Shooting, "", self.grid) }
    }

    /// Moves the candidate to another grid; only its first costate remains meaningful there.
    pub fn on_grid(self, grid: &Grid) -> Self {
        Self { grid: grid.clone(), ..self }
    }

    /// Returns the number of steps of the grid.
    pub fn steps(&self) -> usize {
        self.grid.steps()
    }

    /// Returns `λ_{−1}`; NaN if the candidate has no costates.
    pub fn costate<const N: usize>(&self) -> SVector<f64, N> {
        let first = self.costates.first();
        SVector::from_fn(|row, _| first.map_or(f64::NAN, |costate| costate[row]))
    }

    /// Returns `Ψ₁₂ = ∂z_N/∂λ_{−1}`; `None` if no method computed it.
    pub fn sensitivity<const N: usize>(&self) -> Option<SMatrix<f64, N, N>> {
        self.sensitivity.as_ref().map(|psi| SMatrix::from_fn(|row, column| psi[(row, column)]))
    }
}
