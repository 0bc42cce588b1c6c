//! The convex subproblem about a point of a program of stages, as a cone program.
//!
//! Variables: `δu_k`, `δx_k` of every stage, the fraction `t` of the defects that remains, and a
//! slack `σ_g` of every group of constraints that iterates may violate. With weights `μ` and `ρ_g`
//!
//! ```text
//! minimise   Σ g_k·δ_k + ½ δ_kᵀ H_k δ_k + μ D t + Σ ρ_g σ_g
//! subject to δx_0 = 0 ,   δx_{k+1} = A_k δx_k + B_k δu_k + (1 − t) d_k ,   E δx_N = −(1 − t) e ,
//!            c + C δ ≤ σ_g ,   |c + C δ| ≤ σ_g of an equation ,   |δζ_k| ≤ Δ ,   0 ≤ t ≤ 1 ,   σ ≥ 0
//! ```
//!
//! `D` is the size of all defects, and `H` the second derivative of the effort. The virtual control
//! `−t d_k` has one scalar variable: with `t = 1`, zero increments and slacks equal to the
//! violations the subproblem is always feasible. The duals of the equations are `−λ_k`, those of
//! the rows `ν`. Linear limits of the inputs are never relaxed. The trust region on the rotation of
//! each node is an angle and needs no chart.

use crate::maneuver::solution::Outcome;
use crate::numerics::parallel;
use crate::optimize::convex::cone::{
    Answer, Cone, ConeError, ConeSettings, ConeSolver, Program as ConeProgram, Reason, Work,
};
use crate::optimize::convex::sparse::{Sparse, SparseParts};
use crate::optimize::methods::interior_point::chain::ChainProgram;
use crate::optimize::methods::interior_point::program::{
    Derivatives, Duals, Increment, Program, RowKind, Shape, Values,
};
use crate::optimize::methods::method::Watch;
use crate::optimize::methods::scp::infeasibility;
use crate::optimize::methods::scp::tuning::LARGE;
use std::sync::Arc;
use std::sync::atomic::AtomicBool;

/// Penalties and trust radius of a subproblem.
#[derive(Clone, Debug)]
pub(crate) struct Weights {
    /// Penalty `μ` per unit of defect.
    pub defect: f64,
    /// Penalty `ρ_g` per unit of violation, for each group.
    pub violation: Vec<f64>,
    /// Trust radius Δ for the rotation of every node \[rad\].
    pub radius: f64,
}

/// Solution of a subproblem.
#[derive(Clone, Debug)]
pub(crate) struct Move {
    pub increment: Increment,
    /// Fraction of the defects that remains.
    pub left: f64,
    /// Remaining violation of each group.
    pub slacks: Vec<f64>,
    pub duals: Duals,
    /// Predicted decrease of the merit function.
    pub predicted: f64,
}

/// Why a subproblem has no solution.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Failure {
    /// The data were invalid, or the cone solver failed.
    Numerical,
    /// The time limit was reached.
    Time,
    /// The caller requested a stop.
    Stopped,
}

/// Builder and solver of subproblems; the sparsity pattern is computed once.
pub(crate) struct Subproblem<'a> {
    program: &'a ChainProgram<'a>,
    solver: Option<ConeSolver>,
    /// Requested accuracy of the cone solver.
    tolerance: f64,
    /// Source of stop requests and of the time limit.
    watch: Watch<'a>,
    /// Index, in the vector of unknowns, of the fraction `t` of the defects that remains.
    left: usize,
    /// Index of the slack of each group in the vector of unknowns; `None` if the group has no
    /// slack.
    slack: Vec<Option<usize>>,
    /// Number of unknowns of the cone program.
    count: usize,
    /// Wall-clock time in the cone solver so far \[s\].
    pub seconds: f64,
    /// Number of iterations of the cone solver so far.
    pub iterations: u32,
}

/// Data of a cone program, with matrices as lists of entries.
#[derive(Default)]
struct Draft {
    quadratic: Vec<(usize, usize, f64)>,
    linear: Vec<f64>,
    matrix: Vec<(usize, usize, f64)>,
    bound: Vec<f64>,
    cones: Vec<Cone>,
}

impl Draft {
    /// Appends a row `a·x + s = bound` without entries; returns its index.
    fn row(&mut self, bound: f64) -> usize {
        self.bound.push(bound);
        self.bound.len() - 1
    }

    fn put(&mut self, row: usize, column: usize, value: f64) {
        self.matrix.push((row, column, value));
    }

    /// Closes the block of rows from row `first` to the last row as one cone; `cone` builds it from
    /// the number of rows.
    fn cone(&mut self, first: usize, cone: impl Fn(usize) -> Cone) {
        self.cones.push(cone(self.bound.len() - first));
    }

    fn program(self) -> ConeProgram {
        let Self { quadratic, linear, matrix, bound, cones } = self;
        let count = linear.len();
        let quadratic = Sparse::of_entries(count, count, &quadratic);
        let matrix = Sparse::of_entries(bound.len(), count, &matrix);
        ConeProgram { quadratic, linear, matrix, bound, cones }
    }
}

/// Solves a program, reusing a solver if one with the same sparsity pattern exists; returns the
/// answer and the solver for the next program.
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

impl<'a> Subproblem<'a> {
    pub fn new(program: &'a ChainProgram<'a>, tolerance: f64, watch: Watch<'a>) -> Self {
        let shape = program.shape();
        let left = shape.stages * shape.z() + shape.n;
        let mut count = left + 1;
        let mut slack = vec![None; program.groups()];
        for row in (0..shape.rows()).filter(|row| program.may_be_violated(*row)) {
            let own = &mut slack[program.group_of(row)];
            if own.is_none() {
                *own = Some(count);
                count += 1;
            }
        }
        Self { program, solver: None, tolerance, watch, left, slack, count, seconds: 0.0, iterations: 0 }
    }

    /// Returns the index of unknown `unknown` of `(u, x)` of a stage in the vector of unknowns. The
    /// terminal state is stored as the state of stage N, which has no inputs.
    fn place(&self, stage: usize, unknown: usize) -> usize {
        let shape = self.program.shape();
        stage * shape.z() + if stage == shape.stages { unknown - shape.m } else { unknown }
    }

    /// Returns the largest rotation of a node in a move \[rad\].
    pub fn longest(&self, step: &Move) -> f64 {
        let (n, zeta) = (self.program.shape().n, self.program.attitude());
        let turn = |state: &[f64]| state[zeta..zeta + 3].iter().map(|part| part * part).sum::<f64>().sqrt();
        step.increment.states.chunks_exact(n).map(turn).fold(0.0, f64::max)
    }

    /// Solves for the best move from the point `at`. If `after` has the values at the point that a
    /// first move led to, the new move also corrects the defects at that point, which are the
    /// second-order error of the linearisation.
    pub fn solve(
        &mut self,
        at: &Derivatives,
        weights: &Weights,
        after: Option<&Values>,
    ) -> Result<Move, Failure> {
        let (draft, places) = self.draft(at, weights, after);
        let answer = self.answer(draft)?;
        let Some(optimum) = answer.step() else {
            return Err(match answer {
                Answer::Failed { reason: Reason::Time, .. } => Failure::Time,
                Answer::Failed { reason: Reason::Stopped, .. } => Failure::Stopped,
                _ => Failure::Numerical,
            });
        };
        let shape = self.program.shape();
        let Shape { n, m, stages, terminal, .. } = *shape;
        let (mut increment, mut duals) = (Increment::of(shape), Duals::of(shape));
        for (stage, state) in increment.states.chunks_exact_mut(n).enumerate() {
            state.copy_from_slice(&optimum.x[self.place(stage, m)..][..n]);
        }
        for (stage, inputs) in increment.inputs.chunks_exact_mut(m).enumerate() {
            inputs.copy_from_slice(&optimum.x[self.place(stage, 0)..][..m]);
        }
        duals.costates.iter_mut().zip(&optimum.z).for_each(|(to, z)| *to = -z);
        duals.terminal.copy_from_slice(&optimum.z[(stages + 1) * n..][..terminal]);
        for ((to, place), kind) in duals.rows.iter_mut().zip(places).zip(&shape.kinds) {
            // An equation has two rows, one for each sign, the second directly after the first.
            let equation = *kind == RowKind::Equation;
            *to = if equation { optimum.z[place] - optimum.z[place + 1] } else { optimum.z[place].max(0.0) };
        }
        let slack = |slot: &Option<usize>| slot.map_or(0.0, |slot| optimum.x[slot].max(0.0));
        let left = optimum.x[self.left].clamp(0.0, 1.0);
        let slacks = self.slack.iter().map(slack).collect();
        let mut best = Move { increment, left, slacks, duals, predicted: 0.0 };
        best.predicted = self.promised(&best, at, weights);
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

    /// Builds the cone program; also returns the index of the dual of each row of the program of
    /// stages.
    fn draft(&self, at: &Derivatives, weights: &Weights, after: Option<&Values>) -> (Draft, Vec<usize>) {
        let shape = self.program.shape();
        let Shape { n, m, stages, .. } = *shape;
        let z = shape.z();
        let mut draft = Draft { linear: vec![0.0; self.count], ..Draft::default() };
        draft.linear[..stages * z].copy_from_slice(&at.gradients);
        draft.linear[self.left] = weights.defect * infeasibility(&at.values);
        for (slot, weight) in self.slack.iter().zip(&weights.violation) {
            slot.iter().for_each(|slot| draft.linear[*slot] = *weight);
        }
        for stage in 0..stages {
            for column in 0..m {
                let own = &at.hessians[(stage * z + column) * z..][..=column];
                let place = |unknown| self.place(stage, unknown);
                let entry = |(row, value): (usize, &f64)| (place(row), place(column), *value);
                draft.quadratic.extend(own.iter().enumerate().map(entry));
            }
        }
        (0..n).for_each(|i| {
            let row = draft.row(0.0);
            draft.put(row, self.place(0, m + i), 1.0);
        });
        for stage in 0..stages {
            let defects = &at.values.defects[stage * n..][..n];
            for (i, defect) in defects.iter().enumerate() {
                let more = after.map_or(0.0, |after| after.defects[stage * n + i]);
                let row = draft.row(defect + more);
                draft.put(row, self.place(stage + 1, m + i), 1.0);
                draft.put(row, self.left, *defect);
                let steps = at.steps[stage * n * z..][..n * z].chunks_exact(n).enumerate();
                steps.for_each(|(unknown, column)| draft.put(row, self.place(stage, unknown), -column[i]));
            }
        }
        for (index, (error, slope)) in
            at.values.terminal.iter().zip(at.terminal_slopes.chunks_exact(n)).enumerate()
        {
            let row = draft.row(-error - after.map_or(0.0, |after| after.terminal[index]));
            draft.put(row, self.left, -error);
            let slope = slope.iter().enumerate();
            slope.for_each(|(i, value)| draft.put(row, self.place(stages, m + i), *value));
        }
        draft.cone(0, Cone::Zero);
        let first = draft.bound.len();
        let places = self.write_rows(at, &mut draft);
        let bounds = [(0.0, self.left, -1.0), (1.0, self.left, 1.0)].into_iter();
        for (bound, column, value) in bounds.chain(self.slack.iter().flatten().map(|slot| (0.0, *slot, -1.0)))
        {
            let row = draft.row(bound);
            draft.put(row, column, value);
        }
        draft.cone(first, Cone::Nonnegative);
        for stage in 1..=stages {
            let first = draft.row(weights.radius);
            for i in 0..3 {
                let row = draft.row(0.0);
                draft.put(row, self.place(stage, m + self.program.attitude() + i), -1.0);
            }
            draft.cone(first, Cone::SecondOrder);
        }
        (draft, places)
    }

    /// Writes the rows of the program of stages, and returns the index of each in the cone program.
    fn write_rows(&self, at: &Derivatives, draft: &mut Draft) -> Vec<usize> {
        let shape = self.program.shape();
        let mut places = Vec::with_capacity(shape.rows());
        for stage in 0..shape.stages {
            for row in shape.rows_of(stage) {
                let (c, slack) = (at.values.rows[row], self.slack[self.program.group_of(row)]);
                let sides = if shape.kinds[row] == RowKind::Equation { &[1.0, -1.0][..] } else { &[1.0] };
                places.push(draft.bound.len());
                for side in sides {
                    let place = draft.row(-side * c);
                    for slope in shape.slopes_of(row) {
                        let unknown = usize::from(shape.unknowns[slope]);
                        draft.put(place, self.place(stage, unknown), side * at.slopes[slope]);
                    }
                    slack.iter().for_each(|slack| draft.put(place, *slack, -1.0));
                }
            }
        }
        places
    }

    /// Returns the decrease of the merit function that the subproblem predicts.
    fn promised(&self, step: &Move, at: &Derivatives, weights: &Weights) -> f64 {
        let shape = self.program.shape();
        let (m, z) = (shape.m, shape.z());
        let mut gained = 0.0;
        for (stage, inputs) in step.increment.inputs.chunks_exact(m).enumerate() {
            for (column, own) in inputs.iter().enumerate() {
                let index = stage * z + column;
                let bend = at.hessians[index * z..][..m].iter().zip(inputs).map(|(h, du)| h * du);
                gained -= own * (at.gradients[index] + 0.5 * bend.sum::<f64>());
            }
        }
        let violations = self.program.violations(&at.values);
        let relief = violations.iter().zip(&step.slacks).zip(&weights.violation);
        let relief: f64 = relief.map(|((before, after), weight)| weight * (before - after)).sum();
        gained + weights.defect * (1.0 - step.left) * infeasibility(&at.values) + relief
    }
}
