//! What every method improves: a maneuver on one grid, whole or in part, in the solver's units.
//!
//! A candidate holds what the method that made it knows. The rest follows: states and inputs from
//! the first costate by the sweep, momenta and inputs from poses by inverse dynamics.
//!
//! # What does every method improve?
//!
//! A `Candidate`: a maneuver on one grid, whole or in part. It owns the grid (its steps and its
//! duration), states, inputs, costates, multipliers, and its provenance: the start and what it has
//! taken so far. It holds what the method that made it knows, and the rest follows: from the first
//! costate by the sweep, from poses by inverse dynamics. A shooting candidate is one costate, a
//! path around a cone is poses alone. `Method::improve(candidate, budget) -> Attempt` is the whole
//! interface: shooting, coarse to fine, descents on paths, the lifted Newton, the interior point
//! and SCP are its implementations, so a search that wants another method adds a line. Drawing
//! limits in is not one of them: its result is a candidate within
//! *wider* limits, which is no candidate of the maneuver.

use crate::maneuver::grid::Grid;
use crate::maneuver::settings::Method;
use crate::optimize::discrete::step::Point;
use nalgebra::{DMatrix, DVector, SMatrix, SVector};

/// A maneuver that a method may improve.
#[derive(Clone, Debug)]
pub(crate) struct Candidate {
    /// Its grid, in the unit of time: its steps and its duration.
    pub grid: Grid,
    /// States `y_0 … y_N`, or none. With wheels the momentum is the total one.
    pub states: Vec<Point>,
    /// Momenta of the wheels at the same nodes; empty without wheels.
    pub wheels: Vec<DVector<f64>>,
    /// Inputs `u_0 … u_N` (`u_0` is unused by Lie–Euler), or none.
    pub inputs: Vec<Vec<f64>>,
    /// Costates `λ_{−1} … λ_{N−1}`; the first alone where a sweep gives the others; or none. Those
    /// of the wheels come last.
    pub costates: Vec<DVector<f64>>,
    /// Multipliers of the terminal condition and of the rows of all limits, where a method has
    /// them.
    pub multipliers: (DVector<f64>, Vec<f64>),
    /// `Ψ₁₂`, where a method derived it.
    pub sensitivity: Option<DMatrix<f64>>,
    /// Where it comes from.
    pub provenance: Provenance,
}

/// Where a candidate comes from, and what it has taken so far.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Provenance {
    /// Shooting, or SCP.
    pub method: Method,
    /// The start: "short", "long", "+1 turn", …
    pub start: String,
    /// Newton iterations and subproblems, all rungs from the start on.
    pub iterations: usize,
    /// Subproblems among them.
    pub subproblems: usize,
    /// Whether its path has been led past the cones as far as it is to be.
    pub led_past: bool,
}

impl Candidate {
    /// Nothing but a grid and the name of a start.
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

    /// The extremal that a sweep from `λ_{−1}` gives.
    pub fn of_costate<const N: usize>(start: &str, grid: &Grid, costate: &SVector<f64, N>) -> Self {
        Self::empty(Method::Shooting, start, grid.clone()).with_costate(costate)
    }

    /// The same with another `λ_{−1}`, from which all else follows.
    pub fn with_costate<const N: usize>(self, costate: &SVector<f64, N>) -> Self {
        let provenance = Provenance { method: Method::Shooting, ..self.provenance };
        let costates = vec![DVector::from_column_slice(costate.as_slice())];
        Self { costates, provenance, ..Self::empty(Method::Shooting, "", self.grid) }
    }

    /// The same extremal on another grid, as far as its first costate tells.
    pub fn on_grid(self, grid: &Grid) -> Self {
        Self { grid: grid.clone(), ..self }
    }

    /// Number of steps of its grid.
    pub fn steps(&self) -> usize {
        self.grid.steps()
    }

    /// `λ_{−1}`; NaN where there is none.
    pub fn costate<const N: usize>(&self) -> SVector<f64, N> {
        let first = self.costates.first();
        SVector::from_fn(|row, _| first.map_or(f64::NAN, |costate| costate[row]))
    }

    /// `Ψ₁₂`, where it was derived.
    pub fn sensitivity<const N: usize>(&self) -> Option<SMatrix<f64, N, N>> {
        self.sensitivity.as_ref().map(|psi| SMatrix::from_fn(|row, column| psi[(row, column)]))
    }
}
