//! Cone programs, and the interface to their solver, clarabel; no other module uses it.
//!
//! ```text
//! minimise    ½ xᵀ P x + qᵀ x
//! subject to  A x + s = b,   s ∈ K = K_1 × K_2 × …
//! ```
//!
//! **Sign of the duals.** `L = ½xᵀPx + qᵀx + zᵀ(Ax + s − b)`: stationarity reads
//! `Px + q + Aᵀz = 0`, `z ∈ K*`, and `∂cost/∂b = −z`. A row `x = 3` under cost `½x²` has `z = −3`.
//! A costate of dynamics written as a row of `A x = b` is `−z`; the dual of an inequality is ≥ 0.
//!
//! The solver accepts any numbers: it reports a NaN in `b` as "solved", panics at an index outside
//! `A`, and returns a wrong solution for a non-convex `P`. So every number, pattern and pivot is
//! checked here before it is passed on, and every returned `x` has a status that states its
//! accuracy.

use super::sparse::{Sparse, SparseParts};
use clarabel::qdldl::{QDLDLFactorisation, QDLDLSettings};
use clarabel::solver::{DefaultInfo, DefaultSettings, DefaultSolver, IPSolver, SolverStatus, SupportedConeT};
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use thiserror::Error;

/// One factor of the cone `K`, with its number of rows or, for [`Self::Semidefinite`], the size of
/// its matrix.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Cone {
    /// Equations, `s = 0`.
    Zero(usize),
    /// Inequalities, `s ≥ 0`.
    Nonnegative(usize),
    /// Second-order cone `s_0 ≥ |(s_1, …)|`: the bound comes first; at least two rows.
    SecondOrder(usize),
    /// Cone of the positive semidefinite `n×n` matrices. It has `n(n+1)/2` rows: the upper triangle
    /// column by column, with its off-diagonal entries times √2.
    #[cfg(feature = "sdp")]
    Semidefinite(usize),
}

impl Cone {
    /// Returns the number of rows of the cone.
    pub fn rows(self) -> usize {
        match self {
            Self::Zero(rows) | Self::Nonnegative(rows) | Self::SecondOrder(rows) => rows,
            #[cfg(feature = "sdp")]
            Self::Semidefinite(n) => n.saturating_mul(n + 1) / 2,
        }
    }

    fn supported(self) -> SupportedConeT<f64> {
        match self {
            Self::Zero(rows) => SupportedConeT::ZeroConeT(rows),
            Self::Nonnegative(rows) => SupportedConeT::NonnegativeConeT(rows),
            Self::SecondOrder(rows) => SupportedConeT::SecondOrderConeT(rows),
            #[cfg(feature = "sdp")]
            Self::Semidefinite(n) => SupportedConeT::PSDTriangleConeT(n),
        }
    }
}

/// Data of a cone program.
#[derive(Clone, Debug)]
pub(crate) struct Program {
    /// Quadratic cost: the upper triangle of `P`, n×n, positive semidefinite.
    pub quadratic: Sparse,
    /// Linear cost `q`, length n.
    pub linear: Vec<f64>,
    /// Constraint matrix `A`, m×n.
    pub matrix: Sparse,
    /// Right-hand side `b` of the constraints, length m.
    pub bound: Vec<f64>,
    /// The factors of `K`; their rows add up to m.
    pub cones: Vec<Cone>,
}

/// Limits and tolerances of the cone solver.
#[derive(Clone, Debug)]
pub(crate) struct ConeSettings {
    /// Relative tolerance of gap and residuals. Default 1e-9. Below about 1e-12 round-off usually
    /// limits the result to [`Answer::AlmostSolved`].
    pub tolerance: f64,
    /// Largest number of iterations. Default 200.
    pub max_iterations: u32,
    /// Wall-clock limit of one solve \[s\]. Default: unlimited.
    pub time_limit: f64,
    /// Static regularisation of the linear systems, corrected by iterative refinement. The default,
    /// 1e-8, is also the default of clarabel. Semidefinite programs with solutions of rank one
    /// converge with a larger value, and not with a smaller one.
    pub regularization: f64,
}

impl Default for ConeSettings {
    fn default() -> Self {
        Self { tolerance: 1e-9, max_iterations: 200, time_limit: f64::INFINITY, regularization: 1e-8 }
    }
}

/// Invalid data, which are not passed to the solver.
#[derive(Clone, Debug, Error, PartialEq)]
pub(crate) enum ConeError {
    /// A number is NaN or infinite, or an entry of `b` is so large that the solver would treat it
    /// as infinite.
    #[error("entry {index} of {part} is {value}: must be finite{}", if *.part == "b" { " and below 1e20" } else { "" })]
    Value { part: &'static str, index: usize, value: f64 },
    /// Sizes or sparsity patterns do not agree.
    #[error("{0}")]
    Shape(&'static str),
    /// `P` has a negative eigenvalue.
    #[error("the quadratic cost is not convex: P is not positive semidefinite")]
    NotConvex,
    /// A setting is out of range.
    #[error("setting {name} is {value}: out of range")]
    Setting { name: &'static str, value: f64 },
    /// The solver rejected the data; holds its message.
    #[error("cone solver: {0}")]
    Solver(String),
}

/// A point that satisfies the optimality conditions up to its residuals.
#[derive(Clone, Debug)]
pub(crate) struct Optimum {
    /// Variables, length n.
    pub x: Vec<f64>,
    /// Duals of the rows, length m; the module's header defines their sign.
    pub z: Vec<f64>,
    /// Slacks `b − A x` as computed by the solver, in `K`, length m.
    pub s: Vec<f64>,
}

/// Iterations and time of a solve.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct Work {
    /// Interior-point iterations.
    pub iterations: u32,
    /// Wall-clock time in the solver \[s\].
    pub seconds: f64,
}

/// Why a solve returned no solution.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Reason {
    /// The cost has no lower bound: the program was built incorrectly.
    Unbounded,
    /// The program is infeasible or unbounded only to low accuracy, so that no certificate exists.
    Undecided,
    /// The iteration limit was reached.
    Iterations,
    /// The time limit was reached.
    Time,
    /// The caller requested a stop.
    Stopped,
    /// The steps became too short, or the linear algebra broke down.
    Numerical,
}

/// Result of a solve.
#[derive(Clone, Debug)]
pub(crate) enum Answer {
    /// Solved to the requested tolerance.
    Solved(Optimum),
    /// Solved to a reduced accuracy (5e-5): sufficient for a step, but not for a proof.
    AlmostSolved(Optimum),
    /// Infeasible: no `x` of moderate size meets the constraints. The certificate is a dual
    /// direction `z ∈ K*`, length m, with `Aᵀz ≈ 0` and `bᵀz < 0`. Its large entries belong to the
    /// rows that contradict each other.
    Infeasible(Vec<f64>),
    /// The solver failed.
    Failed {
        /// Reason of the failure.
        reason: Reason,
        /// Last dual iterate; `None` if it is not finite. It is only useful for a bound that is
        /// corrected by its residuals.
        z: Option<Vec<f64>>,
    },
}

impl Answer {
    /// Returns the solution if its accuracy is sufficient for a step.
    pub fn step(&self) -> Option<&Optimum> {
        match self {
            Self::Solved(optimum) | Self::AlmostSolved(optimum) => Some(optimum),
            Self::Infeasible(_) | Self::Failed { .. } => None,
        }
    }
}

/// A cone program in the solver, to be solved repeatedly with other numbers in the same sparsity
/// pattern.
///
/// The solver has no warm start: each solve is cold. An update saves only the symbolic
/// factorisation. The scaling of the first data is kept, so a change of the data by orders of
/// magnitude requires a new solver.
pub(crate) struct ConeSolver {
    solver: DefaultSolver<f64>,
    program: Program,
    convexity: Convexity,
}

impl ConeSolver {
    /// Checks `program` and prepares the solver.
    ///
    /// # Errors
    /// A [`ConeError`] that states what is wrong with the data.
    pub fn new(program: Program, settings: &ConeSettings) -> Result<Self, ConeError> {
        let solver_settings = settings.checked()?;
        let (n, m) = (program.linear.len(), program.bound.len());
        let (p, a) = (&program.quadratic, &program.matrix);
        if n == 0 || p.m != n || p.n != n || a.n != n || a.m != m {
            return Err(ConeError::Shape("P must be n×n, q n, A m×n and b m, with n at least 1"));
        }
        if p.entries().any(|(row, column, _)| row > column) {
            return Err(ConeError::Shape("P must be given by its upper triangle"));
        }
        let mut rows = 0usize;
        for cone in &program.cones {
            let least = if matches!(cone, Cone::SecondOrder(_)) { 2 } else { 1 };
            if cone.rows() < least {
                return Err(ConeError::Shape("a cone needs a row, a second-order cone two"));
            }
            rows = rows.saturating_add(cone.rows());
        }
        if rows != m {
            return Err(ConeError::Shape("the rows of the cones must add up to the rows of A"));
        }
        for matrix in [p, a] {
            matrix.check_format().map_err(solver_error)?;
        }
        program.check_numbers()?;
        let convexity = Convexity::new(&program.quadratic)?;
        let cones: Vec<_> = program.cones.iter().map(|cone| cone.supported()).collect();
        let solver = DefaultSolver::new(p, &program.linear, a, &program.bound, &cones, solver_settings)
            .map_err(solver_error)?;
        Ok(Self { solver, program, convexity })
    }

    /// Returns the current program.
    #[cfg(test)]
    pub fn program(&self) -> &Program {
        &self.program
    }

    /// Returns whether a program has the sparsity pattern, sizes and cones of the current one.
    pub fn fits(&self, program: &Program) -> bool {
        let old = &self.program;
        old.matrix.is_equal_sparsity(&program.matrix)
            && old.quadratic.is_equal_sparsity(&program.quadratic)
            && old.linear.len() == program.linear.len()
            && old.bound.len() == program.bound.len()
            && old.cones == program.cones
    }

    /// Replaces the numbers of the program; the sparsity pattern must stay the same.
    ///
    /// # Errors
    /// The errors of [`ConeSolver::new`]; the old program is then kept.
    pub fn update(&mut self, program: Program) -> Result<(), ConeError> {
        if !self.fits(&program) {
            return Err(ConeError::Shape("an update keeps pattern and length"));
        }
        program.check_numbers()?;
        self.convexity.check(&program.quadratic.nzval)?;
        self.solver.update_P(&program.quadratic.nzval).map_err(solver_error)?;
        self.solver.update_q(&program.linear).map_err(solver_error)?;
        self.solver.update_A(&program.matrix.nzval).map_err(solver_error)?;
        self.solver.update_b(&program.bound).map_err(solver_error)?;
        self.program = program;
        Ok(())
    }

    /// Replaces the settings of subsequent solves.
    ///
    /// # Errors
    /// A [`ConeError::Setting`] if a setting is out of its range.
    pub fn set(&mut self, settings: &ConeSettings) -> Result<(), ConeError> {
        self.solver.update_settings(settings.checked()?).map_err(solver_error)
    }

    /// Makes subsequent solves stop after the current iteration when one of `flags` is set.
    pub fn heed(&mut self, flags: Vec<Arc<AtomicBool>>) {
        let any = move || flags.iter().any(|flag| flag.load(Ordering::Relaxed));
        self.solver.set_termination_callback(move |_: &DefaultInfo<f64>| any());
    }

    /// Solves the current program.
    pub fn solve(&mut self) -> Answer {
        self.solver.solve();
        let solution = &self.solver.solution;
        let finite = |values: &[f64]| values.iter().all(|value| value.is_finite()).then(|| values.to_vec());
        let optimum =
            || Some(Optimum { x: finite(&solution.x)?, z: finite(&solution.z)?, s: finite(&solution.s)? });
        let failed = |reason, z| Answer::Failed { reason, z };
        let numerical = failed(Reason::Numerical, None);
        match solution.status {
            SolverStatus::Solved => optimum().map_or(numerical, Answer::Solved),
            SolverStatus::AlmostSolved => optimum().map_or(numerical, Answer::AlmostSolved),
            SolverStatus::PrimalInfeasible => finite(&solution.z).map_or(numerical, Answer::Infeasible),
            SolverStatus::DualInfeasible => failed(Reason::Unbounded, None),
            SolverStatus::AlmostPrimalInfeasible | SolverStatus::AlmostDualInfeasible => {
                failed(Reason::Undecided, None)
            }
            SolverStatus::MaxIterations => failed(Reason::Iterations, finite(&solution.z)),
            SolverStatus::MaxTime => failed(Reason::Time, finite(&solution.z)),
            SolverStatus::InsufficientProgress => failed(Reason::Numerical, finite(&solution.z)),
            // After a numerical error the arrays may contain the solution of an earlier solve.
            SolverStatus::NumericalError | SolverStatus::Unsolved => numerical,
            SolverStatus::CallbackTerminated => failed(Reason::Stopped, None),
        }
    }

    /// Returns the iterations and the time of the last solve.
    pub fn work(&self) -> Work {
        let solution = &self.solver.solution;
        Work { iterations: solution.iterations, seconds: solution.solve_time }
    }
}

impl Program {
    /// Splits a vector of row values into the parts of the cones.
    pub fn parts<'a>(&'a self, mut rows: &'a [f64]) -> impl Iterator<Item = (Cone, &'a [f64])> {
        self.cones.iter().map(move |cone| {
            let (part, rest) = rows.split_at(cone.rows());
            rows = rest;
            (*cone, part)
        })
    }

    /// Checks that every number of the program is finite and in the range that the solver handles.
    fn check_numbers(&self) -> Result<(), ConeError> {
        finite("P", &self.quadratic.nzval)?;
        finite("q", &self.linear)?;
        finite("A", &self.matrix.nzval)?;
        finite("b", &self.bound)?;
        // The solver silently truncates larger entries of `b`.
        first_bad("b", &self.bound, |value| value.abs() < clarabel::get_infinity())
    }
}

impl ConeSettings {
    fn checked(&self) -> Result<DefaultSettings<f64>, ConeError> {
        let below = [
            ("tolerance", self.tolerance, 1.0),
            ("regularization", self.regularization, 1.0),
            ("time_limit", self.time_limit, f64::INFINITY),
        ];
        for (name, value, limit) in below {
            if !(value > 0.0 && (value < limit || limit.is_infinite())) {
                return Err(ConeError::Setting { name, value });
            }
        }
        if self.max_iterations == 0 {
            return Err(ConeError::Setting { name: "max_iterations", value: 0.0 });
        }
        Ok(DefaultSettings {
            verbose: false,
            presolve_enable: false,
            input_sparse_dropzeros: false,
            #[cfg(feature = "sdp")]
            chordal_decomposition_enable: false,
            direct_solve_method: "qdldl".to_string(),
            max_threads: 1,
            max_iter: self.max_iterations,
            time_limit: self.time_limit,
            tol_gap_abs: self.tolerance,
            tol_gap_rel: self.tolerance,
            tol_feas: self.tolerance,
            static_regularization_constant: self.regularization,
            // More digits than this would add a tenth to the solve time and not change the result.
            iterative_refinement_reltol: (1e-3 * self.tolerance).max(1e-13),
            iterative_refinement_abstol: (1e-3 * self.tolerance).max(1e-12),
            ..DefaultSettings::default()
        })
    }
}

/// Convexity test: `P` counts as positive semidefinite if `P + ε max|P| I` has a factorisation
/// `L D Lᵀ` with `D > 0`.
struct Convexity {
    /// Factorisation of the shifted matrix; `None` if `P` has no entries.
    factor: Option<QDLDLFactorisation<f64>>,
    /// Positions of the entries of `P` in the values of the shifted matrix.
    slots: Vec<usize>,
    /// Positions of the diagonal entries in the values of the shifted matrix.
    diagonal: Vec<usize>,
    /// For each diagonal entry its position in the values of `P`; `None` if `P` does not store it.
    on_diagonal: Vec<Option<usize>>,
}

impl Convexity {
    /// Negative eigenvalues up to this fraction of the largest entry count as round-off.
    const SHIFT: f64 = 1e-10;

    fn new(quadratic: &Sparse) -> Result<Self, ConeError> {
        let n = quadratic.n;
        let mut entries: Vec<_> = quadratic.entries().collect();
        entries.extend((0..n).map(|index| (index, index, 0.0)));
        let shifted = Sparse::of_entries(n, n, &entries);
        let slot = |row, column| shifted.slot(row, column).expect("in the pattern by construction");
        let slots = quadratic.entries().map(|(row, column, _)| slot(row, column)).collect();
        let diagonal = (0..n).map(|index| slot(index, index)).collect();
        let on_diagonal = (0..n).map(|index| quadratic.slot(index, index)).collect();
        let mut convexity = Self { factor: None, slots, diagonal, on_diagonal };
        if !quadratic.nzval.is_empty() {
            let settings =
                QDLDLSettings { regularize_enable: false, logical: true, ..QDLDLSettings::default() };
            let factor = QDLDLFactorisation::new(&shifted, Some(settings)).map_err(solver_error)?;
            convexity.factor = Some(factor);
            convexity.check(&quadratic.nzval)?;
        }
        Ok(convexity)
    }

    fn check(&mut self, values: &[f64]) -> Result<(), ConeError> {
        let scale = largest(values);
        let Some(factor) = &mut self.factor else { return Ok(()) };
        if scale == 0.0 {
            return Ok(());
        }
        let scaled: Vec<f64> = values.iter().map(|value| value / scale).collect();
        factor.update_values(&self.slots, &scaled);
        let shifted: Vec<f64> =
            self.on_diagonal.iter().map(|slot| slot.map_or(0.0, |slot| scaled[slot]) + Self::SHIFT).collect();
        factor.update_values(&self.diagonal, &shifted);
        let positive = factor.refactor().is_ok() && factor.D.iter().all(|pivot| *pivot > 0.0);
        if positive { Ok(()) } else { Err(ConeError::NotConvex) }
    }
}

fn finite(part: &'static str, values: &[f64]) -> Result<(), ConeError> {
    first_bad(part, values, f64::is_finite)
}

fn first_bad(part: &'static str, values: &[f64], good: impl Fn(f64) -> bool) -> Result<(), ConeError> {
    match values.iter().position(|value| !good(*value)) {
        Some(index) => Err(ConeError::Value { part, index, value: values[index] }),
        None => Ok(()),
    }
}

fn solver_error(error: impl std::fmt::Display) -> ConeError {
    ConeError::Solver(error.to_string())
}

/// Returns the largest magnitude; NaN if an entry is NaN.
fn largest(values: &[f64]) -> f64 {
    let larger = |most: f64, value: &f64| {
        if value.is_nan() || most.is_nan() { f64::NAN } else { most.max(value.abs()) }
    };
    values.iter().fold(0.0, larger)
}

#[cfg(test)]
mod tests;
