//! The convex subproblem around an iterate, as a cone program.
//!
//! Variables: `z_k`, `δu_k` of every stage, a share `t` of the defects that is left, and a slack `σ_g`
//! of every constraint that may be violated on the way. With weights `μ` and `ρ_g`
//!
//! ```text
//! minimise   Σ κ ½(u+δu)ᵀW(u+δu) + μ D t + Σ ρ_g σ_g
//! subject to z_0 = B_0 δu_0 + (1 − t) d_0 ,   z_{k+1} = A_k z_k + B_{k+1} δu_{k+1} + (1 − t) d_{k+1}
//!            S z_N = −(1 − t) e ,             |ζ_k| ≤ Δ ,   0 ≤ t ≤ 1 ,   σ ≥ 0
//!            rows: c + ∂c·δ ≤ σ_g ,           |v + ∂v·δ| ≤ 1 + σ_g ,       |c + ∂c·δ| ≤ σ_g of an equation
//! ```
//!
//! `D` is the size of all defects. The virtual control `−t d_k` has one scalar: with `t = 1`, nothing
//! moved and the slacks at the violations, the subproblem is always feasible. The duals of the
//! equations are `−λ_k`, those of the rows `ν`.
//!
//! # What does the convex iteration solve?
//!
//! `optimize/chain/model` writes the maneuver as a chain of stages with the planner's own discrete step, so a point without defects
//! is a variational trajectory. `optimize/chain/rows` writes every limit as a half space or a ball, relative to the limit. The
//! subproblem has a trust region on the rotation of each node, which is an angle and needs no chart, and is always feasible:
//! one scalar leaves a share of all defects standing (the virtual control), one slack per constraint leaves its worst
//! violation standing. Limits of the inputs are never relaxed.

use crate::maneuver::objective;
use crate::maneuver::solution::Outcome;
use crate::numerics::parallel;
use crate::optimize::chain::Multipliers;
use crate::optimize::chain::iterate::Evaluated;
use crate::optimize::chain::model::Model;
use crate::optimize::chain::rows::{LimitRows, RowValue};
use crate::optimize::convex::cone::{
    Answer, Cone, ConeError, ConeSettings, ConeSolver, Program, Reason, Work,
};
use crate::optimize::convex::sparse::{Sparse, SparseParts};
use crate::optimize::methods::method::Watch;
use crate::optimize::methods::scp::tuning::LARGE;
use nalgebra::{DMatrix, DVector};
use std::sync::Arc;
use std::sync::atomic::AtomicBool;

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
    /// Somebody asked to stop.
    Stopped,
}

/// Builds and solves subproblems; the pattern is made once.
pub(crate) struct Subproblem<'a> {
    model: &'a Model,
    rows: &'a LimitRows,
    solver: Option<ConeSolver>,
    /// Accuracy asked of the cone solver.
    tolerance: f64,
    /// Who may end a solve.
    watch: Watch<'a>,
    /// Wall time inside the cone solver \[s\].
    pub seconds: f64,
    /// Interior-point iterations in all.
    pub iterations: u32,
}

/// Where everything stands.
struct ProgramLayout {
    n: usize,
    m: usize,
    left: usize,
    slack: Vec<Option<usize>>,
    count: usize,
}

impl ProgramLayout {
    fn of(model: &Model, rows: &LimitRows) -> Self {
        let (n, m) = (model.n, model.m);
        let left = (model.steps + 1) * (n + m);
        let mut count = left + 1;
        let slack = rows.groups.iter().map(|group| {
            (!group.hard).then(|| {
                count += 1;
                count - 1
            })
        });
        let slack = slack.collect();
        Self { n, m, left, slack, count }
    }

    fn state(&self, stage: usize) -> usize {
        stage * (self.n + self.m)
    }

    fn inputs(&self, stage: usize) -> usize {
        self.state(stage) + self.n
    }
}

/// The data of a cone program, its matrices as they were written, entry by entry.
struct Draft {
    quadratic: Vec<(usize, usize, f64)>,
    linear: Vec<f64>,
    matrix: Vec<(usize, usize, f64)>,
    bound: Vec<f64>,
    cones: Vec<Cone>,
}

impl Draft {
    fn program(self) -> Program {
        let Self { quadratic, linear, matrix, bound, cones } = self;
        let count = linear.len();
        let quadratic = Sparse::of_entries(count, count, &quadratic);
        let matrix = Sparse::of_entries(bound.len(), count, &matrix);
        Program { quadratic, linear, matrix, bound, cones }
    }
}

/// The answer to a program by a solver that may be there already, and that solver.
fn solved(
    solver: Option<ConeSolver>,
    draft: Draft,
    settings: &ConeSettings,
    flags: Vec<Arc<AtomicBool>>,
) -> (Option<ConeSolver>, Result<Answer, ConeError>) {
    let program = draft.program();
    let (mut solver, made) = match solver {
        Some(mut solver) if solver.fits(&program) => {
            let updated = solver.update(program).and_then(|()| solver.set(settings));
            (Some(solver), updated)
        }
        _ => match ConeSolver::new(program, settings) {
            Ok(solver) => (Some(solver), Ok(())),
            Err(error) => (None, Err(error)),
        },
    };
    let answer = made.map(|()| {
        let solver = solver.as_mut().expect("made above");
        solver.heed(flags);
        solver.solve()
    });
    (solver, answer)
}

/// Rows of a ball: its bound, and three components.
pub(crate) const BALL: usize = 4;

/// The rows of `A x + s = b` as they are written.
#[derive(Default)]
struct Writer {
    entries: Vec<(usize, usize, f64)>,
    bound: Vec<f64>,
    /// Where the dual of each limit's row stands.
    places: Vec<usize>,
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

    /// `sign` times `values` from a column on.
    fn put_all<'a>(&mut self, row: usize, first: usize, values: impl Iterator<Item = &'a f64>, sign: f64) {
        values.enumerate().for_each(|(offset, value)| self.put(row, first + offset, sign * value));
    }

    /// A slack that relaxes the row, where there is one.
    fn slack(&mut self, row: usize, slack: Option<usize>) {
        slack.into_iter().for_each(|slack| self.put(row, slack, -1.0));
    }
}

impl<'a> Subproblem<'a> {
    pub fn new(model: &'a Model, rows: &'a LimitRows, tolerance: f64, watch: Watch<'a>) -> Self {
        Self { model, rows, solver: None, tolerance, watch, seconds: 0.0, iterations: 0 }
    }

    /// The best move from an iterate. With `after`, where a move has led, the one that also makes up
    /// for the defects there: what the equations of motion lack beyond first order.
    pub fn solve(
        &mut self,
        at: &Evaluated,
        weights: &Weights,
        after: Option<&Evaluated>,
    ) -> Result<Move, Failure> {
        let layout = ProgramLayout::of(self.model, self.rows);
        let (draft, places) = self.draft(&layout, at, weights, after);
        let answer = self.answer(draft)?;
        let Some(optimum) = answer.step() else {
            return Err(match answer {
                Answer::Failed { reason: Reason::Time, .. } => Failure::Time,
                Answer::Failed { reason: Reason::Stopped, .. } => Failure::Stopped,
                _ => Failure::Numerical,
            });
        };
        let part = |at: usize, count: usize| DVector::from_column_slice(&optimum.x[at..at + count]);
        let dual = |at: usize, count: usize| -DVector::from_column_slice(&optimum.z[at..at + count]);
        let stages = 0..=self.model.steps;
        let n = layout.n;
        let slack = |slot: &Option<usize>| slot.map_or(0.0, |slot| optimum.x[slot].max(0.0));
        let terminal = (self.model.steps + 1) * n;
        let mut best = Move {
            states: stages.clone().map(|stage| part(layout.state(stage), n)).collect(),
            inputs: stages.clone().map(|stage| part(layout.inputs(stage), layout.m)).collect(),
            left: optimum.x[layout.left].clamp(0.0, 1.0),
            slacks: layout.slack.iter().map(slack).collect(),
            multipliers: Multipliers {
                costates: stages.map(|stage| dual(stage * n, n)).collect(),
                terminal: -dual(terminal, self.model.terminal_count()),
                rows: places.iter().map(|place| optimum.z[*place].max(0.0)).collect(),
            },
            predicted: 0.0,
        };
        // Of an equation the two sides: the second one stands next to the first.
        for (row, place) in places.iter().enumerate() {
            if self.rows.rows[row].what.is_equation() {
                best.multipliers.rows[row] = optimum.z[*place] - optimum.z[place + 1];
            }
        }
        best.predicted = best.promised(at, weights);
        Ok(best)
    }

    fn answer(&mut self, draft: Draft) -> Result<Answer, Failure> {
        let (tolerance, time_limit) = (self.tolerance, self.watch.seconds_left());
        let settings = ConeSettings { tolerance, time_limit, ..ConeSettings::default() };
        let (solver, flag) = (self.solver.take(), self.watch.flag.cloned());
        let solved = if draft.linear.len() < LARGE {
            solved(solver, draft, &settings, flag.into_iter().collect())
        } else {
            let work = move |left| solved(solver, draft, &settings, flag.into_iter().chain([left]).collect());
            let answer = parallel::unless_stopped(work, || self.watch.stopped());
            answer.ok_or_else(|| match (self.watch.interrupt)() {
                Some(Outcome::TimeLimit) => Failure::Time,
                _ => Failure::Stopped,
            })?
        };
        let (solver, answer) = solved;
        self.solver = solver;
        let answer = answer.map_err(|_| Failure::Numerical)?;
        let work = self.solver.as_ref().map_or(Work::default(), ConeSolver::work);
        self.seconds += work.seconds;
        self.iterations += work.iterations;
        Ok(answer)
    }

    /// The cone program, and where each row's dual stands.
    fn draft(
        &self,
        layout: &ProgramLayout,
        at: &Evaluated,
        weights: &Weights,
        after: Option<&Evaluated>,
    ) -> (Draft, Vec<usize>) {
        let model = self.model;
        let mut linear = vec![0.0; layout.count];
        let mut quadratic = Vec::new();
        let mut upper = |first: usize, block: &DMatrix<f64>| {
            let column = |j: usize| (0..=j).map(move |i| (first + i, first + j, block[(i, j)]));
            quadratic.extend((0..block.ncols()).flat_map(column));
        };
        for stage in 0..=model.steps {
            upper(layout.inputs(stage), &model.input_weight(stage));
            let inputs = DVector::from_column_slice(&at.iterate.inputs[stage]);
            let slope = &model.weight * inputs * model.kick_weight(stage);
            linear[layout.inputs(stage)..][..layout.m].copy_from_slice(slope.as_slice());
        }
        linear[layout.left] = weights.defect * at.infeasibility();
        for (slot, weight) in layout.slack.iter().zip(&weights.violation) {
            if let Some(slot) = slot {
                linear[*slot] = *weight;
            }
        }
        let mut writer = Writer { places: vec![0; self.rows.rows.len()], ..Writer::default() };
        self.write_chain(layout, at, after, &mut writer);
        let equations = writer.bound.len();
        self.write_half_spaces(layout, at, &mut writer);
        let inequalities = writer.bound.len() - equations;
        self.write_balls(layout, at, weights.radius, &mut writer);
        let Writer { entries, bound, places } = writer;
        let mut cones = vec![Cone::Zero(equations), Cone::Nonnegative(inequalities)];
        cones.resize(2 + (bound.len() - equations - inequalities) / BALL, Cone::SecondOrder(BALL));
        (Draft { quadratic, linear, matrix: entries, bound, cones }, places)
    }

    /// Opening, steps, terminal conditions: `n (N + 1)` rows, then those of the end.
    fn write_chain(
        &self,
        layout: &ProgramLayout,
        at: &Evaluated,
        after: Option<&Evaluated>,
        writer: &mut Writer,
    ) {
        let model = self.model;
        for stage in 0..=model.steps {
            let defect = &at.defects[stage];
            let inputs = at.input_slope(stage);
            for i in 0..layout.n {
                let row = writer.row(defect[i] + after.map_or(0.0, |after| after.defects[stage][i]));
                writer.put(row, layout.state(stage) + i, 1.0);
                writer.put(row, layout.left, defect[i]);
                for j in (0..layout.m).filter(|j| model.reaches(i, *j)) {
                    writer.put(row, layout.inputs(stage) + j, -inputs[(i, j)]);
                }
                if stage > 0 {
                    writer.put_all(row, layout.state(stage - 1), at.steps[stage - 1].a.row(i).iter(), -1.0);
                }
            }
        }
        for (i, (error, slope)) in at.terminal.iter().zip(at.terminal_slope.row_iter()).enumerate() {
            let row = writer.row(-error - after.map_or(0.0, |after| after.terminal[i]));
            writer.put_all(row, layout.state(model.steps), slope.iter(), 1.0);
            writer.put(row, layout.left, -error);
        }
    }

    fn write_half_spaces(&self, layout: &ProgramLayout, at: &Evaluated, writer: &mut Writer) {
        let zeros = DVector::zeros(layout.n);
        for (index, (row, value)) in self.rows.rows.iter().zip(&at.rows).enumerate() {
            if row.what.is_ball() {
                continue;
            }
            let (c, state, inputs, next) = match value {
                RowValue::Half { c, state, inputs, next } => {
                    (*c, state.as_ref(), inputs.as_ref(), next.as_ref())
                }
                // A cone that does not act keeps its place in the pattern.
                _ => (-1.0, Some(&zeros), None, None),
            };
            let place = writer.row(-c);
            writer.places[index] = place;
            if let Some(state) = state {
                writer.put_all(place, layout.state(row.stage), state.iter(), 1.0);
            }
            let after = layout.inputs((row.stage + 1).min(self.model.steps));
            for (slope, first) in [(inputs, layout.inputs(row.stage)), (next, after)] {
                match (slope, row.what.input()) {
                    (Some(slope), Some(input)) => writer.put(place, first + input, slope[input]),
                    (Some(slope), None) => writer.put_all(place, first, slope.iter(), 1.0),
                    (None, _) => {}
                }
            }
            writer.slack(place, layout.slack[row.group]);
            if row.what.is_equation() {
                // The other side, of which an idle one has none either.
                let other = writer.row(if matches!(value, RowValue::Half { .. }) { c } else { 1.0 });
                let state = state.into_iter().flat_map(|state| state.iter());
                writer.put_all(other, layout.state(row.stage), state, -1.0);
                writer.slack(other, layout.slack[row.group]);
            }
        }
        let place = writer.row(0.0);
        writer.slack(place, Some(layout.left));
        let place = writer.row(1.0);
        writer.put(place, layout.left, 1.0);
        for slack in layout.slack.iter().flatten() {
            let place = writer.row(0.0);
            writer.slack(place, Some(*slack));
        }
    }

    fn write_balls(&self, layout: &ProgramLayout, at: &Evaluated, radius: f64, writer: &mut Writer) {
        for (index, (row, value)) in self.rows.rows.iter().zip(&at.rows).enumerate() {
            let RowValue::Ball { v, state, inputs } = value else { continue };
            let top = writer.row(1.0);
            writer.places[index] = top;
            writer.slack(top, layout.slack[row.group]);
            for i in 0..3 {
                let place = writer.row(v[i]);
                for (slope, first) in [(state, layout.state(row.stage)), (inputs, layout.inputs(row.stage))] {
                    if let Some(slope) = slope {
                        writer.put_all(place, first, slope.row(i).iter(), -1.0);
                    }
                }
            }
        }
        for stage in 0..=self.model.steps {
            writer.row(radius);
            for i in 0..3 {
                let place = writer.row(0.0);
                writer.put(place, layout.state(stage) + self.model.zeta() + i, -1.0);
            }
        }
    }
}

impl Move {
    /// Decrease of the merit function that the subproblem promises.
    fn promised(&self, at: &Evaluated, weights: &Weights) -> f64 {
        let model = at.model;
        let moved = |stage: usize| {
            let inputs = at.iterate.inputs[stage].iter().zip(self.inputs[stage].iter());
            let u: Vec<f64> = inputs.map(|(u, du)| u + du).collect();
            model.kick_weight(stage) * objective::effort(&model.weight, &u)
        };
        let moved: f64 = (model.first_input()..=model.steps).map(moved).sum();
        let violations = at.violations();
        let relief: f64 = weights
            .violation
            .iter()
            .zip(violations.iter().zip(&self.slacks))
            .map(|(weight, (before, after))| weight * (before - after))
            .sum();
        at.cost - moved + weights.defect * (1.0 - self.left) * at.infeasibility() + relief
    }
}
