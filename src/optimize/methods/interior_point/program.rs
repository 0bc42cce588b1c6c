//! Programs of stages that the interior point solves, and their values and derivatives.
//!
//! ```text
//! min Σ f_k(x_k, u_k) + f(x_N)
//! x_0 = start(y) ,  x_{k+1} = step_k(x_k, u_k) ,  c_k(x_k, u_k) ≤ 0 ,  e(x_N) = 0
//! ```
//!
//! States live on a manifold and are stored in coordinates of their own; derivatives are with
//! respect to increments in the tangent space at each state. The unknowns of a stage are ordered `z
//! = (u, x)`. All matrices are dense, columns one after the other.

/// How a row is met.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum RowKind {
    /// `c ≤ 0`, always in the end.
    Hard,
    /// `c ≤ t` with a price on `t ≥ 0`: where no point keeps it the least violation is found.
    Elastic,
    /// `c = 0`.
    Equation,
}

/// Sizes of a program, and which unknowns each of its rows depends on.
#[derive(Clone, Debug, Default)]
pub(crate) struct Shape {
    /// Tangent dimension of a state.
    pub n: usize,
    /// Inputs of a stage.
    pub m: usize,
    /// Numbers by which a state is stored.
    pub coordinates: usize,
    /// Steps from a state to the next: the states are `x_0 … x_stages`.
    pub stages: usize,
    /// Terminal equations.
    pub terminal: usize,
    /// Unknowns `y` of the start.
    pub starts: usize,
    /// First row of each stage, and the number of all.
    pub first_row: Vec<usize>,
    /// Where the unknowns of each row begin in `unknowns`, and their number in all.
    pub first_unknown: Vec<usize>,
    /// Places in `z` that rows depend on.
    pub unknowns: Vec<u16>,
    /// How each row is met.
    pub kinds: Vec<RowKind>,
}

impl Shape {
    /// A shape without rows.
    pub fn new(n: usize, m: usize, coordinates: usize, stages: usize) -> Self {
        Self { n, m, coordinates, stages, first_row: vec![0], first_unknown: vec![0], ..Self::default() }
    }

    /// Appends a row to the present stage.
    pub fn row(&mut self, kind: RowKind, unknowns: impl IntoIterator<Item = usize>) {
        self.kinds.push(kind);
        self.unknowns.extend(unknowns.into_iter().map(|place| place as u16));
        self.first_unknown.push(self.unknowns.len());
    }

    /// Ends the description of a stage.
    pub fn end_stage(&mut self) {
        self.first_row.push(self.kinds.len());
    }

    /// Returns the number of unknowns of a stage.
    pub fn z(&self) -> usize {
        self.n + self.m
    }

    /// Returns the number of rows.
    pub fn rows(&self) -> usize {
        self.kinds.len()
    }

    /// Returns the rows of a stage.
    pub fn rows_of(&self, stage: usize) -> std::ops::Range<usize> {
        self.first_row[stage]..self.first_row[stage + 1]
    }

    /// Returns the places of the slopes of a row.
    pub fn slopes_of(&self, row: usize) -> std::ops::Range<usize> {
        self.first_unknown[row]..self.first_unknown[row + 1]
    }
}

/// A point: coordinates of the states, and inputs.
#[derive(Clone, Debug, Default)]
pub(crate) struct Point {
    /// `coordinates` numbers for each of the states.
    pub states: Vec<f64>,
    /// `m` inputs for each stage.
    pub inputs: Vec<f64>,
}

/// An increment of a point in its tangent space.
#[derive(Clone, Debug, Default)]
pub(crate) struct Increment {
    /// `n` for each of the states.
    pub states: Vec<f64>,
    /// `m` for each stage.
    pub inputs: Vec<f64>,
}

/// Multipliers of all equations and rows.
#[derive(Clone, Debug, Default)]
pub(crate) struct Duals {
    /// `n` costates for each state: of the start, then of each step.
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
    /// `step_k(x_k, u_k) ⊖ x_{k+1}`.
    pub defects: Vec<f64>,
    pub rows: Vec<f64>,
    pub terminal: Vec<f64>,
}

/// Values of a program at a point, with derivatives.
#[derive(Clone, Debug, Default)]
pub(crate) struct Derivatives {
    pub values: Values,
    /// Derivative of each step, `n × (m + n)`.
    pub steps: Vec<f64>,
    /// Gradients of the cost of each stage, and second derivatives of the cost, symmetric.
    pub gradients: Vec<f64>,
    pub hessians: Vec<f64>,
    /// Second derivatives of `λ·step + Σ z c` of each stage, symmetric.
    pub curvatures: Vec<f64>,
    /// Derivatives of the rows by the unknowns that the shape lists.
    pub slopes: Vec<f64>,
    /// Gradient and second derivatives of the cost of the last state.
    pub last_gradient: Vec<f64>,
    pub last_hessian: Vec<f64>,
    /// Second derivatives of `ν·e`.
    pub last_curvature: Vec<f64>,
    /// Derivatives of the terminal equations, `n × terminal`.
    pub terminal_slopes: Vec<f64>,
    /// Derivatives of the start by its unknowns, `n × starts`.
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

/// A program of stages.
pub(crate) trait Program {
    /// Returns the sizes of the program.
    fn shape(&self) -> &Shape;

    /// Computes the values at a point, without allocating; returns `false` if a value does not
    /// exist.
    fn values(&self, at: &Point, out: &mut Values) -> bool;

    /// Computes values and derivatives at a point, with second derivatives of steps, rows and
    /// terminal equations weighted by `duals`; returns `false` if a value does not exist. Elements
    /// that are always the same may be left as they are.
    fn derivatives(&self, at: &Point, duals: &Duals, out: &mut Derivatives) -> bool;

    /// Moves `at` by a part of an increment.
    fn moved(&self, at: &Point, by: &Increment, part: f64, out: &mut Point);

    /// Returns the largest part of an increment from a point, at most 1, within which the
    /// derivatives are trusted.
    fn longest(&self, at: &Point, by: &Increment) -> f64;

    /// Tells the program the barrier term for which it is evaluated from now on, or the mean
    /// complementarity while that is larger: rows with corners are rounded by it.
    fn at_barrier(&self, _barrier: f64) {}

    /// Returns which of the optima that are known a point is at, whose cost exceeds that of its
    /// optimum by so much.
    fn known(&self, _at: &Point, _excess: f64) -> Option<usize> {
        None
    }

    /// Writes the price of a unit of error of each terminal equation.
    fn terminal_prices(&self, out: &mut [f64]);
}
