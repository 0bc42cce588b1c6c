//! Programs of stages, the problems of the interior-point method, with their values and
//! derivatives.
//!
//! ```text
//! min Σ f_k(x_k, u_k) + f(x_N)
//! x_0 = start(y) ,  x_{k+1} = step_k(x_k, u_k) ,  c_k(x_k, u_k) ≤ 0 ,  e(x_N) = 0
//! ```
//!
//! States are points of a manifold and are stored in redundant coordinates; derivatives are with
//! respect to increments in the tangent space at each state. The unknowns of a stage are ordered `z
//! = (u, x)`. All matrices are dense, columns one after the other.

/// Kind of an inequality or equality row.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum RowKind {
    /// Inequality `c ≤ 0` that every solution satisfies.
    Hard,
    /// Inequality `c ≤ t` with a penalty on `t ≥ 0`: if no feasible point exists, the smallest
    /// violation is found.
    Elastic,
    /// Equality `c = 0`.
    Equation,
}

/// Dimensions of a program, and the unknowns on which each of its rows depends.
#[derive(Clone, Debug, Default)]
pub(crate) struct Shape {
    /// Dimension of the tangent space of a state.
    pub n: usize,
    /// Number of inputs of a stage.
    pub m: usize,
    /// Number of coordinates that store a state.
    pub coordinates: usize,
    /// Number of steps: the states are `x_0 … x_stages`.
    pub stages: usize,
    /// Number of terminal equations.
    pub terminal: usize,
    /// Number of unknowns `y` of the start.
    pub starts: usize,
    /// Index of the first row of each stage, and finally the number of all rows.
    pub first_row: Vec<usize>,
    /// Index in `unknowns` of the first unknown of each row, and finally the length of `unknowns`.
    pub first_unknown: Vec<usize>,
    /// Indices in `z` of the unknowns on which the rows depend.
    pub unknowns: Vec<u16>,
    /// Kind of each row.
    pub kinds: Vec<RowKind>,
}

impl Shape {
    /// Returns a shape without rows.
    pub fn new(n: usize, m: usize, coordinates: usize, stages: usize) -> Self {
        Self { n, m, coordinates, stages, first_row: vec![0], first_unknown: vec![0], ..Self::default() }
    }

    /// Appends a row to the current stage.
    pub fn row(&mut self, kind: RowKind, unknowns: impl IntoIterator<Item = usize>) {
        self.kinds.push(kind);
        self.unknowns.extend(unknowns.into_iter().map(|place| place as u16));
        self.first_unknown.push(self.unknowns.len());
    }

    /// Ends the current stage.
    pub fn end_stage(&mut self) {
        self.first_row.push(self.kinds.len());
    }

    /// Returns the number of unknowns of a stage, inputs and state.
    pub fn z(&self) -> usize {
        self.n + self.m
    }

    /// Returns the number of rows.
    pub fn rows(&self) -> usize {
        self.kinds.len()
    }

    /// Returns the range of rows of a stage.
    pub fn rows_of(&self, stage: usize) -> std::ops::Range<usize> {
        self.first_row[stage]..self.first_row[stage + 1]
    }

    /// Returns the range of derivatives of a row, which is also the range of its unknowns.
    pub fn slopes_of(&self, row: usize) -> std::ops::Range<usize> {
        self.first_unknown[row]..self.first_unknown[row + 1]
    }
}

/// Point of a program: the coordinates of the states, and the inputs.
#[derive(Clone, Debug, Default)]
pub(crate) struct Point {
    /// Coordinates of the states, `coordinates` numbers for each.
    pub states: Vec<f64>,
    /// Inputs, `m` numbers for each stage.
    pub inputs: Vec<f64>,
}

/// An increment of a point in its tangent space.
#[derive(Clone, Debug, Default)]
pub(crate) struct Increment {
    /// Increments of the states, `n` numbers for each.
    pub states: Vec<f64>,
    /// Increments of the inputs, `m` numbers for each stage.
    pub inputs: Vec<f64>,
}

/// Lagrange multipliers of all equations and rows.
#[derive(Clone, Debug, Default)]
pub(crate) struct Duals {
    /// Costates, `n` numbers for each state: of the start, then of each step.
    pub costates: Vec<f64>,
    /// Multipliers of the terminal equations.
    pub terminal: Vec<f64>,
    /// Multipliers of the rows.
    pub rows: Vec<f64>,
}

/// Cost, defects, rows and terminal errors of a program at a point.
#[derive(Clone, Debug, Default)]
pub(crate) struct Values {
    pub cost: f64,
    /// Defects of the dynamics, `step_k(x_k, u_k) ⊖ x_{k+1}`.
    pub defects: Vec<f64>,
    pub rows: Vec<f64>,
    pub terminal: Vec<f64>,
}

/// Values of a program at a point, with derivatives.
#[derive(Clone, Debug, Default)]
pub(crate) struct Derivatives {
    pub values: Values,
    /// Derivative `[B A]` of each step, `n × (m + n)`.
    pub steps: Vec<f64>,
    /// Gradient of the cost of each stage.
    pub gradients: Vec<f64>,
    /// Hessian of the cost of each stage, symmetric.
    pub hessians: Vec<f64>,
    /// Hessian of `λ·step + Σ z c` of each stage, symmetric.
    pub curvatures: Vec<f64>,
    /// Derivatives of the rows with respect to the unknowns that the shape lists.
    pub slopes: Vec<f64>,
    /// Gradient of the cost of the last state.
    pub last_gradient: Vec<f64>,
    /// Hessian of the cost of the last state.
    pub last_hessian: Vec<f64>,
    /// Hessian of `ν·e` with respect to the last state.
    pub last_curvature: Vec<f64>,
    /// Derivatives of the terminal equations with respect to the last state, `n × terminal`.
    pub terminal_slopes: Vec<f64>,
    /// Derivatives of the start with respect to its unknowns, `n × starts`.
    pub start_slopes: Vec<f64>,
}

impl Point {
    pub fn of(shape: &Shape) -> Self {
        Self {
            states: vec![0.0; shape.coordinates * (shape.stages + 1)],
            inputs: vec![0.0; shape.m * shape.stages],
        }
    }
}

impl Increment {
    pub fn of(shape: &Shape) -> Self {
        Self { states: vec![0.0; shape.n * (shape.stages + 1)], inputs: vec![0.0; shape.m * shape.stages] }
    }
}

impl Duals {
    pub fn of(shape: &Shape) -> Self {
        Self {
            costates: vec![0.0; shape.n * (shape.stages + 1)],
            terminal: vec![0.0; shape.terminal],
            rows: vec![0.0; shape.rows()],
        }
    }
}

impl Values {
    pub fn of(shape: &Shape) -> Self {
        Self {
            cost: 0.0,
            defects: vec![0.0; shape.n * shape.stages],
            rows: vec![0.0; shape.rows()],
            terminal: vec![0.0; shape.terminal],
        }
    }

    /// Returns whether all numbers are finite.
    pub fn are_finite(&self) -> bool {
        let all = |values: &[f64]| values.iter().all(|value| value.is_finite());
        self.cost.is_finite() && all(&self.defects) && all(&self.rows) && all(&self.terminal)
    }
}

impl Derivatives {
    pub fn of(shape: &Shape) -> Self {
        let (n, z, stages) = (shape.n, shape.z(), shape.stages);
        Self {
            values: Values::of(shape),
            steps: vec![0.0; stages * n * z],
            gradients: vec![0.0; stages * z],
            hessians: vec![0.0; stages * z * z],
            curvatures: vec![0.0; stages * z * z],
            slopes: vec![0.0; shape.unknowns.len()],
            last_gradient: vec![0.0; n],
            last_hessian: vec![0.0; n * n],
            last_curvature: vec![0.0; n * n],
            terminal_slopes: vec![0.0; n * shape.terminal],
            start_slopes: vec![0.0; n * shape.starts],
        }
    }
}

/// A program of stages: the interface through which the interior-point method evaluates a problem.
pub(crate) trait Program {
    /// Returns the dimensions of the program.
    fn shape(&self) -> &Shape;

    /// Computes the values at a point, without allocating memory; returns `false` if a value does
    /// not exist.
    fn values(&self, at: &Point, out: &mut Values) -> bool;

    /// Computes values and derivatives at a point, with second derivatives of steps, rows and
    /// terminal equations weighted by `duals`; returns `false` if a value does not exist. Constant
    /// elements need not be written again.
    fn derivatives(&self, at: &Point, duals: &Duals, out: &mut Derivatives) -> bool;

    /// Writes to `out` the point that results from `at` by `part` times an increment.
    fn moved(&self, at: &Point, by: &Increment, part: f64, out: &mut Point);

    /// Returns the largest fraction of an increment, at most 1, within which the linearisation at
    /// the point is trusted.
    fn longest(&self, at: &Point, by: &Increment) -> f64;

    /// Sets the barrier parameter of subsequent evaluations, or the mean complementarity while that
    /// is larger: rows with corners are smoothed by it.
    fn at_barrier(&self, _barrier: f64) {}

    /// Returns the index of the known optimum to which a point has converged; `excess` estimates by
    /// how much the cost at the point exceeds the optimum. `None` if there is no such optimum.
    fn known(&self, _at: &Point, _excess: f64) -> Option<usize> {
        None
    }

    /// Writes the penalty per unit of error of each terminal equation.
    fn terminal_prices(&self, out: &mut [f64]);
}
