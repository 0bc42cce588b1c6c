//! The convex subproblem around an iterate, as a cone program.
//!
//! Variables: `z_k`, `δu_k` of every stage, a share `t` of the defects that is left, and a slack `σ_g`
//! of every constraint that may be violated on the way. With weights `μ` and `ρ_g`
//!
//! ```text
//! minimise   Σ κ ½(u+δu)ᵀW(u+δu) + ½ Σ z_kᵀ P_k z_k + μ D t + Σ ρ_g σ_g
//! subject to z_0 = B_0 δu_0 + (1 − t) d_0 ,   z_{k+1} = A_k z_k + B_{k+1} δu_{k+1} + (1 − t) d_{k+1}
//!            S z_N = −(1 − t) e ,             |ζ_k| ≤ Δ ,   0 ≤ t ≤ 1 ,   σ ≥ 0
//!            rows: c + ∂c·δ ≤ σ_g ,           |v + ∂v·δ| ≤ 1 + σ_g
//! ```
//!
//! `D` is the size of all defects. The virtual control `−t d_k` has one scalar: with `t = 1`, nothing
//! moved and the slacks at the violations, the subproblem is always feasible. `P_k` is the convex part
//! of the Lagrangian's second derivatives. The duals of the equations are `−λ_k`, those of the rows `ν`.

use super::curvature::Multipliers;
use super::iterate::{Evaluated, Iterate};
use super::model::Model;
use super::rows::{Rows, Value};
use crate::optimize::convex::cone::{Answer, Cone, ConeError, ConeSettings, ConeSolver, Program, Reason};
use crate::optimize::convex::sparse::{Sparse, SparseParts};
use nalgebra::{DMatrix, DVector};

/// Weights and trust radius of a subproblem.
#[derive(Clone, Debug)]
pub(crate) struct Weights {
    /// Price `μ` of a unit of defect.
    pub defect: f64,
    /// Price `ρ_g` of a unit of violation, per group.
    pub violation: Vec<f64>,
    /// Trust radius Δ on the rotation of every node \[rad\].
    pub radius: f64,
}

/// The solution of a subproblem.
#[derive(Clone, Debug)]
pub(crate) struct Move {
    pub states: Vec<DVector<f64>>,
    pub inputs: Vec<DVector<f64>>,
    /// Share of the defects left.
    pub left: f64,
    /// Violations left, per group.
    pub slacks: Vec<f64>,
    pub multipliers: Multipliers,
    /// The model's decrease of the merit function.
    pub predicted: f64,
}

/// Why there is no move.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Failure {
    /// The data were refused, or the cone solver broke down.
    Numerical,
    /// It ran out of time.
    Time,
}

/// Builds and solves subproblems; the pattern is made once.
pub(crate) struct Subproblem<'a> {
    model: &'a Model,
    rows: &'a Rows,
    solver: Option<ConeSolver>,
    /// Accuracy asked of the cone solver.
    tolerance: f64,
    /// What the next solve may take \[s\].
    pub seconds_left: f64,
    /// Wall time inside the cone solver \[s\].
    pub seconds: f64,
    /// Interior-point iterations in all.
    pub iterations: u32,
}

/// Where everything stands.
struct Layout {
    n: usize,
    m: usize,
    left: usize,
    slack: Vec<Option<usize>>,
    count: usize,
}

impl Layout {
    fn of(model: &Model, rows: &Rows) -> Self {
        let (n, m) = (model.n, model.m);
        let left = (model.steps + 1) * (n + m);
        let mut count = left + 1;
        let slack = rows
            .groups
            .iter()
            .map(|group| {
                (!group.hard).then(|| {
                    count += 1;
                    count - 1
                })
            })
            .collect();
        Self { n, m, left, slack, count }
    }

    fn state(&self, stage: usize) -> usize {
        stage * (self.n + self.m)
    }

    fn inputs(&self, stage: usize) -> usize {
        self.state(stage) + self.n
    }
}

/// The rows of `A x + s = b` as they are written.
#[derive(Default)]
struct Writer {
    entries: Vec<(usize, usize, f64)>,
    bound: Vec<f64>,
}

impl Writer {
    /// Begins a row; returns its index.
    fn row(&mut self, bound: f64) -> usize {
        self.bound.push(bound);
        self.bound.len() - 1
    }

    fn put(&mut self, row: usize, column: usize, value: f64) {
        self.entries.push((row, column, value));
    }
}

impl<'a> Subproblem<'a> {
    pub fn new(model: &'a Model, rows: &'a Rows, tolerance: f64) -> Self {
        Self {
            model,
            rows,
            solver: None,
            tolerance,
            seconds_left: f64::INFINITY,
            seconds: 0.0,
            iterations: 0,
        }
    }

    /// The best move from an iterate. `curvature` holds a positive semidefinite matrix per stage.
    pub fn solve(
        &mut self,
        iterate: &Iterate,
        evaluated: &Evaluated,
        curvature: &[DMatrix<f64>],
        weights: &Weights,
    ) -> Result<Move, Failure> {
        let layout = Layout::of(self.model, self.rows);
        let (program, places) = self.program(&layout, iterate, evaluated, curvature, weights);
        let answer = self.answer(program).map_err(|_| Failure::Numerical)?;
        let work = answer.work();
        self.seconds += work.seconds;
        self.iterations += work.iterations;
        let Some(optimum) = answer.step() else {
            let late = matches!(answer, Answer::Failed { reason: Reason::Time, .. });
            return Err(if late { Failure::Time } else { Failure::Numerical });
        };
        let part = |at: usize, count: usize| DVector::from_column_slice(&optimum.x[at..at + count]);
        let dual = |at: usize, count: usize| -DVector::from_column_slice(&optimum.z[at..at + count]);
        let stages = 0..=self.model.steps;
        let n = layout.n;
        let slacks: Vec<f64> =
            layout.slack.iter().map(|slot| slot.map_or(0.0, |slot| optimum.x[slot].max(0.0))).collect();
        let left = optimum.x[layout.left].clamp(0.0, 1.0);
        let terminal = (self.model.steps + 1) * n;
        let inputs: Vec<_> = stages.clone().map(|stage| part(layout.inputs(stage), layout.m)).collect();
        let multipliers = Multipliers {
            costates: stages.clone().map(|stage| dual(stage * n, n)).collect(),
            terminal: -dual(terminal, self.model.terminal_count()),
            rows: places.iter().map(|place| optimum.z[*place].max(0.0)).collect(),
        };
        let states: Vec<_> = stages.map(|stage| part(layout.state(stage), n)).collect();
        let predicted =
            self.predicted(iterate, evaluated, curvature, weights, &states, &inputs, left, &slacks);
        Ok(Move { states, inputs, left, slacks, multipliers, predicted })
    }

    /// Decrease of the merit function that the subproblem promises, its curvature included.
    #[allow(clippy::too_many_arguments)]
    fn predicted(
        &self,
        iterate: &Iterate,
        evaluated: &Evaluated,
        curvature: &[DMatrix<f64>],
        weights: &Weights,
        states: &[DVector<f64>],
        inputs: &[DVector<f64>],
        left: f64,
        slacks: &[f64],
    ) -> f64 {
        let moved: f64 = (self.model.first_input()..=self.model.steps)
            .map(|stage| {
                let u: Vec<f64> =
                    iterate.inputs[stage].iter().zip(inputs[stage].iter()).map(|(u, du)| u + du).collect();
                self.model.kick_weight(stage) * self.model.effort(&u)
            })
            .sum();
        let bend: f64 = states.iter().zip(curvature).map(|(z, p)| 0.5 * z.dot(&(p * z))).sum();
        let violations = evaluated.violations(self.rows);
        let relief: f64 = weights
            .violation
            .iter()
            .zip(violations.iter().zip(slacks))
            .map(|(weight, (before, after))| weight * (before - after))
            .sum();
        evaluated.cost - moved - bend + weights.defect * (1.0 - left) * evaluated.infeasibility() + relief
    }

    fn answer(&mut self, program: Program) -> Result<Answer, ConeError> {
        match &mut self.solver {
            Some(solver) if solver.fits(&program) => solver.update(program)?,
            _ => {
                let settings = ConeSettings { tolerance: self.tolerance, ..ConeSettings::default() };
                self.solver = Some(ConeSolver::new(program, &settings)?);
            }
        }
        let solver = self.solver.as_mut().expect("made above");
        if self.seconds_left.is_finite() {
            solver.set_time_limit(self.seconds_left)?;
        }
        Ok(solver.solve())
    }

    /// The cone program, and where each row's dual stands.
    fn program(
        &self,
        layout: &Layout,
        iterate: &Iterate,
        evaluated: &Evaluated,
        curvature: &[DMatrix<f64>],
        weights: &Weights,
    ) -> (Program, Vec<usize>) {
        let model = self.model;
        let mut linear = vec![0.0; layout.count];
        let mut quadratic = Vec::new();
        for (stage, curvature) in curvature.iter().enumerate() {
            let (z, u) = (layout.state(stage), layout.inputs(stage));
            for j in 0..layout.n {
                for i in 0..=j {
                    quadratic.push((z + i, z + j, curvature[(i, j)]));
                }
            }
            // Lie–Euler has no u_0: any weight keeps it at zero.
            let weight = model.kick_weight(stage);
            let inputs = DVector::from_column_slice(&iterate.inputs[stage]);
            let slope = &model.weight * inputs * weight;
            for j in 0..layout.m {
                for i in 0..=j {
                    let own = if weight > 0.0 {
                        model.weight[(i, j)] * weight
                    } else {
                        f64::from(u8::from(i == j))
                    };
                    quadratic.push((u + i, u + j, own));
                }
                linear[u + j] = slope[j];
            }
        }
        linear[layout.left] = weights.defect * evaluated.infeasibility();
        for (slot, weight) in layout.slack.iter().zip(&weights.violation) {
            if let Some(slot) = slot {
                linear[*slot] = *weight;
            }
        }
        let mut writer = Writer::default();
        self.write_chain(layout, evaluated, &mut writer);
        let equations = writer.bound.len();
        let mut places = vec![0; self.rows.rows.len()];
        self.write_half_spaces(layout, evaluated, &mut writer, &mut places);
        let mut cones = vec![Cone::Zero(equations), Cone::Nonnegative(writer.bound.len() - equations)];
        self.write_balls(layout, evaluated, weights.radius, &mut writer, &mut places, &mut cones);
        let rows = writer.bound.len();
        let program = Program {
            quadratic: Sparse::of_entries(layout.count, layout.count, &quadratic),
            linear,
            matrix: Sparse::of_entries(rows, layout.count, &writer.entries),
            bound: writer.bound,
            cones,
        };
        (program, places)
    }

    /// Opening, steps, terminal conditions: `n (N + 1)` rows, then those of the end.
    fn write_chain(&self, layout: &Layout, evaluated: &Evaluated, writer: &mut Writer) {
        let model = self.model;
        for stage in 0..=model.steps {
            let defect = &evaluated.defects[stage];
            let inputs = if stage == 0 { &evaluated.opening_slope } else { &evaluated.steps[stage - 1].b };
            for i in 0..layout.n {
                let row = writer.row(defect[i]);
                writer.put(row, layout.state(stage) + i, 1.0);
                writer.put(row, layout.left, defect[i]);
                for j in 0..layout.m {
                    if model.reaches(i, j) {
                        writer.put(row, layout.inputs(stage) + j, -inputs[(i, j)]);
                    }
                }
                if stage > 0 {
                    let a = &evaluated.steps[stage - 1].a;
                    for j in 0..layout.n {
                        writer.put(row, layout.state(stage - 1) + j, -a[(i, j)]);
                    }
                }
            }
        }
        for i in 0..model.terminal_count() {
            let row = writer.row(-evaluated.terminal[i]);
            for j in 0..layout.n {
                writer.put(row, layout.state(model.steps) + j, evaluated.terminal_slope[(i, j)]);
            }
            writer.put(row, layout.left, -evaluated.terminal[i]);
        }
    }

    fn write_half_spaces(
        &self,
        layout: &Layout,
        evaluated: &Evaluated,
        writer: &mut Writer,
        places: &mut [usize],
    ) {
        for (index, (row, value)) in self.rows.rows.iter().zip(&evaluated.rows).enumerate() {
            if row.what.is_ball() {
                continue;
            }
            let zeros = (DVector::zeros(layout.n), DVector::zeros(layout.m));
            let (c, state, inputs, next) = match value {
                Value::Half { c, state, inputs, next } => {
                    (*c, state.as_ref(), inputs.as_ref(), next.as_ref())
                }
                // An idle arc keeps its place in the pattern.
                _ => {
                    let (by_state, by_inputs, _) = row.what.depends(self.model);
                    (-1.0, by_state.then_some(&zeros.0), by_inputs.then_some(&zeros.1), None)
                }
            };
            let at = writer.row(-c);
            places[index] = at;
            let parts = [
                (state, layout.state(row.stage)),
                (inputs, layout.inputs(row.stage)),
                (next, layout.inputs((row.stage + 1).min(self.model.steps))),
            ];
            for (slope, first) in parts {
                for (offset, value) in slope.into_iter().flat_map(|slope| slope.iter().enumerate()) {
                    let own = row.what.input();
                    let of_inputs = first != layout.state(row.stage);
                    if !of_inputs || own.is_none_or(|input| input == offset) {
                        writer.put(at, first + offset, *value);
                    }
                }
            }
            if let Some(slack) = layout.slack[row.group] {
                writer.put(at, slack, -1.0);
            }
        }
        let at = writer.row(0.0);
        writer.put(at, layout.left, -1.0);
        let at = writer.row(1.0);
        writer.put(at, layout.left, 1.0);
        for slack in layout.slack.iter().flatten() {
            let at = writer.row(0.0);
            writer.put(at, *slack, -1.0);
        }
    }

    fn write_balls(
        &self,
        layout: &Layout,
        evaluated: &Evaluated,
        radius: f64,
        writer: &mut Writer,
        places: &mut [usize],
        cones: &mut Vec<Cone>,
    ) {
        for (index, (row, value)) in self.rows.rows.iter().zip(&evaluated.rows).enumerate() {
            let Value::Ball { v, state, inputs } = value else { continue };
            let top = writer.row(1.0);
            places[index] = top;
            if let Some(slack) = layout.slack[row.group] {
                writer.put(top, slack, -1.0);
            }
            for i in 0..3 {
                let at = writer.row(v[i]);
                let parts = [(state, layout.state(row.stage)), (inputs, layout.inputs(row.stage))];
                for (slope, first) in parts {
                    for (offset, value) in slope
                        .iter()
                        .flat_map(|slope| slope.row(i).iter().copied().enumerate().collect::<Vec<_>>())
                    {
                        writer.put(at, first + offset, -value);
                    }
                }
            }
            cones.push(Cone::SecondOrder(4));
        }
        for stage in 0..=self.model.steps {
            writer.row(radius);
            for i in 0..3 {
                let at = writer.row(0.0);
                writer.put(at, layout.state(stage) + self.model.zeta() + i, -1.0);
            }
            cones.push(Cone::SecondOrder(4));
        }
    }
}
