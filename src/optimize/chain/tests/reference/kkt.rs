//! The KKT matrix for a set of active rows, a band matrix.
//!
//! ```text
//! [ ∇²L  Cᵀ ] [ δ(states, inputs) ]
//! [ C    −ε ] [ δ(multipliers)    ]
//! ```
//!
//! with `C` the derivatives of dynamics, terminal conditions and active rows. Its unknowns are
//! ordered by stage, so that the matrix couples only neighbouring stages.

use super::curvature::blocks;
use super::evaluated::Evaluated;
use super::step;
use crate::optimize::chain::Multipliers;
use crate::optimize::chain::model::Model;
use crate::optimize::chain::rows::LimitRows;
use crate::optimize::chain::tuning::PROXIMAL;
use nalgebra::DMatrix;

/// KKT matrix and the positions of its unknowns.
pub(crate) struct Kkt {
    pub layout: KktLayout,
    /// Matrix elements (row, column, value); duplicates are summed.
    pub entries: Vec<(usize, usize, f64)>,
}

/// Positions of the unknowns of each stage: costate, inputs, multipliers of its active rows, state.
#[derive(Default)]
pub(crate) struct KktLayout {
    pub costate: Vec<usize>,
    pub inputs: Vec<usize>,
    pub states: Vec<usize>,
    pub rows: Vec<Option<usize>>,
    pub terminal: usize,
    pub size: usize,
}

impl KktLayout {
    pub fn of(model: &Model, rows: &LimitRows, active: &[bool]) -> Self {
        let mut layout = Self { rows: vec![None; active.len()], ..Self::default() };
        let mut size = 0;
        let mut take = |count: usize| {
            size += count;
            size - count
        };
        for stage in 0..=model.steps {
            layout.costate.push(take(model.n));
            layout.inputs.push(take(model.m));
            for row in rows.range(stage).filter(|row| active[*row]) {
                layout.rows[row] = Some(take(1));
            }
            layout.states.push(take(model.n));
        }
        layout.terminal = take(model.terminal_count());
        Self { size, ..layout }
    }
}

/// List of matrix elements under construction.
#[derive(Default)]
struct Entries(Vec<(usize, usize, f64)>);

impl Entries {
    /// Adds a block whose first element is at (row, column).
    fn block(&mut self, row: usize, column: usize, block: &DMatrix<f64>) {
        for j in 0..block.ncols() {
            self.0.extend((0..block.nrows()).map(|i| (row + i, column + j, block[(i, j)])));
        }
    }

    /// Adds an element and its transpose.
    fn both(&mut self, row: usize, column: usize, value: f64) {
        self.0.extend([(row, column, value), (column, row, value)]);
    }

    /// Adds a block and its transpose.
    fn coupling(&mut self, row: usize, column: usize, block: &DMatrix<f64>) {
        for j in 0..block.ncols() {
            (0..block.nrows()).for_each(|i| self.both(row + i, column + j, block[(i, j)]));
        }
    }
}

impl Kkt {
    /// Assembles the matrix at an iterate with smooth rows, with `proximal` as the value of `ε` for
    /// rows. Returns `None` if a step of the dynamics cannot be differentiated or a stop is
    /// requested.
    pub fn of(at: &Evaluated, multipliers: &Multipliers, active: &[bool], proximal: f64) -> Option<Self> {
        let (model, limits) = (at.model, at.limits);
        let curvature = blocks(at, multipliers).ok()?;
        let layout = KktLayout::of(model, limits, active);
        let mut entries = Entries::default();
        for (stage, curvature) in curvature.iter().enumerate() {
            let (l, u, z) = (layout.costate[stage], layout.inputs[stage], layout.states[stage]);
            (0..model.n).for_each(|i| entries.both(l + i, z + i, -1.0));
            entries.coupling(l, u, at.input_slope(stage));
            if stage > 0 {
                entries.coupling(l, layout.states[stage - 1], &at.steps[stage - 1].a);
            }
            if let Some(next) = &curvature.next {
                entries.coupling(z, layout.inputs[stage + 1], next);
            }
            if let Some(mixed) = &curvature.mixed {
                entries.coupling(z, u, mixed);
            }
            let own = step::input_weight(model, stage);
            entries.block(u, u, &curvature.inputs.as_ref().map_or_else(|| own.clone(), |rows| &own + rows));
            entries.block(z, z, &curvature.state);
        }
        entries.coupling(layout.terminal, layout.states[model.steps], &at.terminal_slope);
        for ((row, value), place) in limits.rows.iter().zip(&at.rows).zip(&layout.rows) {
            let Some(place) = *place else { continue };
            let [state, inputs, next] = value.slopes();
            let parts = [
                (state, layout.states[row.stage]),
                (inputs, layout.inputs[row.stage]),
                (next, layout.inputs[(row.stage + 1).min(model.steps)]),
            ];
            for (slope, at) in parts {
                for (offset, value) in slope.into_iter().flat_map(|slope| slope.iter().enumerate()) {
                    entries.both(place, at + offset, *value);
                }
            }
        }
        entries.0.extend(layout.rows.iter().flatten().map(|place| (*place, *place, -proximal)));
        let terminal = (0..model.terminal_count()).map(|row| layout.terminal + row);
        entries.0.extend(terminal.map(|place| (place, place, -PROXIMAL)));
        Some(Self { layout, entries: entries.0 })
    }
}
