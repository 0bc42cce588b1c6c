//! Cone programs, and the only module that knows the solver of them, clarabel.
//!
//! ```text
//! minimise    ½ xᵀ P x + qᵀ x
//! subject to  A x + s = b,   s ∈ K = K_1 × K_2 × …
//! ```
//!
//! **Sign of the duals.** `L = ½xᵀPx + qᵀx + zᵀ(Ax + s − b)`: stationarity reads `Px + q + Aᵀz = 0`, `z ∈ K*`, and
//! `∂cost/∂b = −z`. A row `x = 3` under cost `½x²` has `z = −3`. A costate of dynamics written as a row of
//! `A x = b` is `−z`; the dual of an inequality is ≥ 0.
//!
//! The solver takes any numbers: a NaN in `b` comes back as "solved", an index outside `A` as a panic, a
//! non-convex `P` as a solution that is none. So every number, pattern and pivot is checked here before it is handed
//! over, and no `x` leaves without a status that says what it is.

use super::sparse::{Sparse, SparseParts};
use clarabel::qdldl::{QDLDLFactorisation, QDLDLSettings};
use clarabel::solver::{DefaultSettings, DefaultSolver, IPSolver, SolverStatus, SupportedConeT};
use thiserror::Error;

/// One factor of the cone `K`, with the number of rows it takes (except as noted).
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Cone {
    /// `s = 0`: equations.
    Zero(usize),
    /// `s ≥ 0`.
    Nonnegative(usize),
    /// `s_0 ≥ |(s_1, …)|`: the bound comes first; at least two rows.
    SecondOrder(usize),
    /// A positive semidefinite `n×n` matrix: `n(n+1)/2` rows, the upper triangle column by column with its
    /// off-diagonal entries times √2.
    #[cfg(feature = "sdp")]
    Semidefinite(usize),
}

impl Cone {
    /// Number of rows.
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

/// The data of a cone program.
#[derive(Clone, Debug)]
pub(crate) struct Program {
    /// Upper triangle of `P`, n×n, positive semidefinite.
    pub quadratic: Sparse,
    /// `q`, length n.
    pub linear: Vec<f64>,
    /// `A`, m×n.
    pub matrix: Sparse,
    /// `b`, length m.
    pub bound: Vec<f64>,
    /// The factors of `K`; their rows add up to m.
    pub cones: Vec<Cone>,
}

/// What the solver may spend and when it may stop.
#[derive(Clone, Debug)]
pub(crate) struct ConeSettings {
    /// Tolerance of gap and residuals, relative. Default 1e-9. Below about 1e-12 the answer is
    /// [`Answer::AlmostSolved`] more often than not: round-off.
    pub tolerance: f64,
    /// Default 200.
    pub max_iterations: u32,
    /// Wall clock of one solve \[s\]. Default: none.
    pub time_limit: f64,
    /// Static regularisation of the linear systems, mended by iterative refinement. Default 1e-8, the solver's own; a
    /// larger one carries semidefinite programs with solutions of rank one to the end, a smaller one does not.
    pub regularization: f64,
}

impl Default for ConeSettings {
    fn default() -> Self {
        Self { tolerance: 1e-9, max_iterations: 200, time_limit: f64::INFINITY, regularization: 1e-8 }
    }
}

/// Data that the solver must not see.
#[derive(Clone, Debug, Error, PartialEq)]
pub(crate) enum ConeError {
    /// A number is NaN or infinite, or an entry of `b` so large that the solver takes it for infinity.
    #[error("entry {index} of {part} is {value}: must be finite{}", if *.part == "b" { " and below 1e20" } else { "" })]
    Value { part: &'static str, index: usize, value: f64 },
    /// Sizes or patterns do not agree.
    #[error("{0}")]
    Shape(&'static str),
    /// `P` has a negative eigenvalue.
    #[error("the quadratic cost is not convex: P is not positive semidefinite")]
    NotConvex,
    /// A setting is out of range.
    #[error("setting {name} is {value}: out of range")]
    Setting { name: &'static str, value: f64 },
    /// The solver refused the data for a reason of its own.
    #[error("cone solver: {0}")]
    Solver(String),
}

/// A point that satisfies the optimality conditions up to its residuals.
#[derive(Clone, Debug)]
pub(crate) struct Optimum {
    /// Variables, length n.
    pub x: Vec<f64>,
    /// Duals of the rows, length m; the sign is that of the module's header.
    pub z: Vec<f64>,
    /// Slacks `b − A x` as the solver keeps them, in `K`, length m.
    pub s: Vec<f64>,
    /// `½xᵀPx + qᵀx`.
    pub objective: f64,
    /// `−½xᵀPx − bᵀz`. A lower bound on the cost only as far as `dual_residual` is zero.
    pub dual_objective: f64,
    /// `max |Ax + s − b|`, recomputed from the data.
    pub primal_residual: f64,
    /// `max |Px + q + Aᵀz|`, recomputed from the data.
    pub dual_residual: f64,
    /// What the solve took.
    pub work: Work,
}

/// What a solve took.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct Work {
    /// Interior-point iterations.
    pub iterations: u32,
    /// Wall clock inside the solver \[s\].
    pub seconds: f64,
}

/// Why a program has no solution: a dual direction `z ∈ K*` with `Aᵀz ≈ 0` and `bᵀz < 0`.
#[derive(Clone, Debug)]
pub(crate) struct Certificate {
    /// The direction, length m. Its large entries are the rows that contradict each other.
    pub z: Vec<f64>,
    /// Every `x` that meets the constraints has `max |x_i| ≥ reach = −bᵀz / Σ|Aᵀz|`, round-off included. A reach far
    /// beyond any sensible `x` makes the certificate a proof. Zero where `z` leaves `K*`, which proves nothing.
    pub reach: f64,
    /// What the solve took.
    pub work: Work,
}

/// Why a solve has nothing to show.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Reason {
    /// The cost has no lower bound: the program was built wrongly.
    Unbounded,
    /// Infeasible or unbounded to low accuracy only: no certificate.
    Undecided,
    /// Iteration limit.
    Iterations,
    /// Time limit.
    Time,
    /// The steps became too short, or the linear algebra broke down.
    Numerical,
}

/// How a solve ended.
#[derive(Clone, Debug)]
pub(crate) enum Answer {
    /// To the tolerance asked for.
    Solved(Optimum),
    /// To a reduced accuracy (5e-5): good for a step, never for a proof.
    AlmostSolved(Optimum),
    /// No `x` of sensible size meets the constraints.
    Infeasible(Certificate),
    /// No answer.
    Failed {
        /// Why.
        reason: Reason,
        /// The last dual iterate where there is a finite one. Good for a bound that corrects it, and for nothing else.
        z: Option<Vec<f64>>,
        /// What the solve took.
        work: Work,
    },
}

impl Answer {
    /// The point, where it may serve as a step.
    pub fn step(&self) -> Option<&Optimum> {
        match self {
            Self::Solved(optimum) | Self::AlmostSolved(optimum) => Some(optimum),
            Self::Infeasible(_) | Self::Failed { .. } => None,
        }
    }

    /// What the solve took.
    pub fn work(&self) -> Work {
        match self {
            Self::Solved(optimum) | Self::AlmostSolved(optimum) => optimum.work,
            Self::Infeasible(certificate) => certificate.work,
            Self::Failed { work, .. } => *work,
        }
    }
}

/// A cone program in the solver, to be solved again and again with other numbers in the same places.
///
/// No warm start: each solve is cold. What an update saves is the symbolic factorisation. The scaling of the first
/// data is kept, so after a change of the data by orders of magnitude make a new one.
pub(crate) struct ConeSolver {
    solver: DefaultSolver<f64>,
    settings: ConeSettings,
    program: Program,
    convexity: Convexity,
}

impl ConeSolver {
    /// Checks `program` and prepares the solver.
    ///
    /// # Errors
    /// A [`ConeError`] that says what is wrong with the data.
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
        Ok(Self { solver, settings: settings.clone(), program, convexity })
    }

    /// The program as it stands.
    #[cfg(test)]
    pub fn program(&self) -> &Program {
        &self.program
    }

    /// Whether a program differs from the present one in its numbers alone.
    pub fn fits(&self, program: &Program) -> bool {
        let old = &self.program;
        old.matrix.is_equal_sparsity(&program.matrix)
            && old.quadratic.is_equal_sparsity(&program.quadratic)
            && old.linear.len() == program.linear.len()
            && old.bound.len() == program.bound.len()
            && old.cones == program.cones
    }

    /// Puts other numbers into the same places.
    ///
    /// # Errors
    /// As [`ConeSolver::new`]; the old program then stays.
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

    /// Replaces the wall clock of the solves to come \[s\].
    ///
    /// # Errors
    /// A limit that is not positive, or none.
    pub fn set_time_limit(&mut self, seconds: f64) -> Result<(), ConeError> {
        self.settings.time_limit = seconds;
        let settings = self.settings.checked()?;
        self.solver.update_settings(settings).map_err(solver_error)
    }

    /// Solves the program as it stands.
    pub fn solve(&mut self) -> Answer {
        self.solver.solve();
        let solution = &self.solver.solution;
        let work = Work { iterations: solution.iterations, seconds: solution.solve_time };
        let all_finite = |values: &[f64]| values.iter().all(|value| value.is_finite());
        let failed = |reason, z| Answer::Failed { reason, z, work };
        let last_dual = || all_finite(&solution.z).then(|| solution.z.clone());
        match solution.status {
            SolverStatus::Solved | SolverStatus::AlmostSolved => {
                if ![&solution.x, &solution.z, &solution.s].into_iter().all(|values| all_finite(values)) {
                    return failed(Reason::Numerical, None);
                }
                let optimum = self.optimum(work);
                if solution.status == SolverStatus::Solved {
                    Answer::Solved(optimum)
                } else {
                    Answer::AlmostSolved(optimum)
                }
            }
            SolverStatus::PrimalInfeasible => match last_dual() {
                Some(z) => Answer::Infeasible(self.program.certificate(z, work)),
                None => failed(Reason::Numerical, None),
            },
            SolverStatus::DualInfeasible => failed(Reason::Unbounded, None),
            SolverStatus::AlmostPrimalInfeasible | SolverStatus::AlmostDualInfeasible => {
                failed(Reason::Undecided, None)
            }
            SolverStatus::MaxIterations => failed(Reason::Iterations, last_dual()),
            SolverStatus::MaxTime => failed(Reason::Time, last_dual()),
            SolverStatus::InsufficientProgress => failed(Reason::Numerical, last_dual()),
            // After a numerical error the arrays may hold the solution of an earlier solve.
            SolverStatus::NumericalError | SolverStatus::Unsolved | SolverStatus::CallbackTerminated => {
                failed(Reason::Numerical, None)
            }
        }
    }

    /// The solver's point with residuals recomputed from the unscaled data.
    fn optimum(&self, work: Work) -> Optimum {
        let solution = &self.solver.solution;
        let (x, z, s) = (&solution.x, &solution.z, &solution.s);
        let program = &self.program;
        let mut gradient = vec![0.0; x.len()];
        program.quadratic.add_symmetric_product(x, &mut gradient);
        let curvature = dot(x, &gradient);
        let objective = 0.5 * curvature + dot(x, &program.linear);
        let dual_objective = -0.5 * curvature - dot(&program.bound, z);
        for (entry, q) in gradient.iter_mut().zip(&program.linear) {
            *entry += q;
        }
        program.matrix.add_transposed_product(z, &mut gradient);
        let mut residual: Vec<f64> = s.iter().zip(&program.bound).map(|(s, b)| s - b).collect();
        program.matrix.add_product(x, &mut residual);
        Optimum {
            x: x.clone(),
            z: z.clone(),
            s: s.clone(),
            objective,
            dual_objective,
            primal_residual: largest(&residual),
            dual_residual: largest(&gradient),
            work,
        }
    }
}

impl Program {
    /// Each cone with its part of as many numbers as there are rows.
    pub fn parts<'a>(&'a self, mut rows: &'a [f64]) -> impl Iterator<Item = (Cone, &'a [f64])> {
        self.cones.iter().map(move |cone| {
            let (part, rest) = rows.split_at(cone.rows());
            rows = rest;
            (*cone, part)
        })
    }

    /// Whether every number is one that the solver may see.
    fn check_numbers(&self) -> Result<(), ConeError> {
        finite("P", &self.quadratic.nzval)?;
        finite("q", &self.linear)?;
        finite("A", &self.matrix.nzval)?;
        finite("b", &self.bound)?;
        // The solver cuts larger entries of `b` off without a word.
        first_bad("b", &self.bound, |value| value.abs() < clarabel::get_infinity())
    }

    /// Judges a dual direction from the data, not from the solver's word.
    fn certificate(&self, z: Vec<f64>, work: Work) -> Certificate {
        let inside = self.parts(&z).all(|(cone, part)| match cone {
            Cone::Zero(_) => true,
            Cone::Nonnegative(_) => part.iter().all(|value| *value >= 0.0),
            Cone::SecondOrder(_) => dot(&part[1..], &part[1..]).sqrt() <= part[0],
            // Not looked into: no user asks for this proof yet.
            #[cfg(feature = "sdp")]
            Cone::Semidefinite(_) => false,
        });
        // Round-off of the sums, generously: each term is in error by a few ulps times the number of terms.
        let ulps = 4.0 * f64::EPSILON * (z.len() as f64 + 4.0);
        let size: f64 = self.bound.iter().zip(&z).map(|(b, z)| (b * z).abs()).sum();
        let depth = -dot(&self.bound, &z) - ulps * size;
        let mut image = vec![0.0; self.linear.len()];
        self.matrix.add_transposed_product(&z, &mut image);
        let mut slack = 0.0;
        for (row, _, value) in self.matrix.entries() {
            slack += ulps * (value * z[row]).abs();
        }
        let width = image.iter().map(|value| value.abs()).sum::<f64>() + slack;
        let reach = if !inside || depth <= 0.0 { 0.0 } else { depth / width };
        // 0/0 cannot be: depth > 0. An overflow to infinity says the same as a very large number.
        Certificate { z, reach, work }
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
            // Digits beyond the tolerance cost a tenth of the time and change nothing.
            iterative_refinement_reltol: (1e-3 * self.tolerance).max(1e-13),
            iterative_refinement_abstol: (1e-3 * self.tolerance).max(1e-12),
            ..DefaultSettings::default()
        })
    }
}

/// Whether `P` is positive semidefinite: `P + ε max|P| I` has a factorisation `L D Lᵀ` with `D > 0`.
struct Convexity {
    /// `None` while no entry exists.
    factor: Option<QDLDLFactorisation<f64>>,
    /// Slots of the entries of `P` in the shifted matrix.
    slots: Vec<usize>,
    /// Slots of the diagonal in the shifted matrix.
    diagonal: Vec<usize>,
    /// Which entry of `P`, if any, is on the diagonal.
    on_diagonal: Vec<Option<usize>>,
}

impl Convexity {
    /// Negative eigenvalues up to this share of the largest entry count as round-off.
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

fn dot(a: &[f64], b: &[f64]) -> f64 {
    a.iter().zip(b).map(|(a, b)| a * b).sum()
}

/// Largest magnitude; NaN where one entry is.
fn largest(values: &[f64]) -> f64 {
    values.iter().fold(
        0.0,
        |most: f64, value| {
            if value.is_nan() || most.is_nan() { f64::NAN } else { most.max(value.abs()) }
        },
    )
}

#[cfg(test)]
mod tests;
