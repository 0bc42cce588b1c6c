//! The matrix of the conditions of Karush, Kuhn and Tucker on a set of acting rows, a band.
//!
//! ```text
//! [ ∇²L  Cᵀ ] [ δ(states, inputs) ]
//! [ C    −ε ] [ δ(multipliers)    ]
//! ```
//!
//! with `C` the derivatives of dynamics, terminal conditions and acting rows. Its unknowns stand stage by
//! stage, so that it couples neighbours alone.

use super::curvature::{Multipliers, blocks};
use super::iterate::{Evaluated, Iterate};
use super::model::Model;
use super::rows::{Rows, Value};

/// Proximal term on the multipliers: keeps the matrix regular where rows repeat each other, or a symmetry
/// makes a terminal condition follow from the others, and vanishes from the solution.
pub(super) const PROXIMAL: f64 = 1e-11;

/// The matrix, and where its unknowns stand.
pub(super) struct Kkt {
    pub layout: Layout,
    /// Elements (row, column, value), to be added up.
    pub entries: Vec<(usize, usize, f64)>,
}

/// Where each unknown of a stage stands: costate, inputs, multipliers of its acting rows, state.
pub(super) struct Layout {
    pub costate: Vec<usize>,
    pub inputs: Vec<usize>,
    pub states: Vec<usize>,
    pub rows: Vec<Option<usize>>,
    pub terminal: usize,
    pub size: usize,
}

impl Layout {
    pub fn of(model: &Model, rows: &Rows, active: &[bool]) -> Self {
        let mut layout = Self {
            costate: Vec::new(),
            inputs: Vec::new(),
            states: Vec::new(),
            rows: vec![None; active.len()],
            terminal: 0,
            size: 0,
        };
        let mut at = 0;
        let mut row = 0;
        for stage in 0..=model.steps {
            layout.costate.push(at);
            at += model.n;
            layout.inputs.push(at);
            at += model.m;
            while row < rows.rows.len() && rows.rows[row].stage == stage {
                if active[row] {
                    layout.rows[row] = Some(at);
                    at += 1;
                }
                row += 1;
            }
            layout.states.push(at);
            at += model.n;
        }
        layout.terminal = at;
        layout.size = at + model.terminal_count();
        layout
    }
}

impl Kkt {
    /// The matrix at an iterate, with `proximal` in the place of `ε` for rows; `None` where a step of the dynamics cannot be differentiated.
    pub fn of(
        model: &Model,
        rows: &Rows,
        iterate: &Iterate,
        evaluated: &Evaluated,
        multipliers: &Multipliers,
        active: &[bool],
        proximal: f64,
    ) -> Option<Self> {
        let curvature = blocks(model, rows, iterate, evaluated, multipliers).ok()?;
        let layout = Layout::of(model, rows, active);
        let (n, m) = (model.n, model.m);
        let mut entries: Vec<(usize, usize, f64)> = Vec::new();
        let mut both = |row: usize, column: usize, value: f64| {
            entries.push((row, column, value));
            entries.push((column, row, value));
        };
        for (stage, curvature) in curvature.iter().enumerate() {
            let (l, u, z) = (layout.costate[stage], layout.inputs[stage], layout.states[stage]);
            for i in 0..n {
                both(l + i, z + i, -1.0);
            }
            let slope = if stage == 0 { &evaluated.opening_slope } else { &evaluated.steps[stage - 1].b };
            for j in 0..m {
                for i in 0..n {
                    both(l + i, u + j, slope[(i, j)]);
                }
            }
            if stage > 0 {
                let before = layout.states[stage - 1];
                let a = &evaluated.steps[stage - 1].a;
                for i in 0..n {
                    for j in 0..n {
                        both(l + i, before + j, a[(i, j)]);
                    }
                }
            }
            if let Some(next) = &curvature.next {
                let after = layout.inputs[stage + 1];
                for i in 0..n {
                    for j in 0..m {
                        both(z + i, after + j, next[(i, j)]);
                    }
                }
            }
            if let Some(mixed) = &curvature.mixed {
                for i in 0..n {
                    for j in 0..m {
                        both(z + i, u + j, mixed[(i, j)]);
                    }
                }
            }
        }
        let t = layout.terminal;
        for i in 0..model.terminal_count() {
            for j in 0..n {
                both(t + i, layout.states[model.steps] + j, evaluated.terminal_slope[(i, j)]);
            }
        }
        for (index, place) in layout.rows.iter().enumerate() {
            let Some(place) = *place else { continue };
            let Value::Half { state, inputs, next, .. } = &evaluated.rows[index] else { continue };
            let stage = rows.rows[index].stage;
            let parts = [
                (state, layout.states[stage]),
                (inputs, layout.inputs[stage]),
                (next, layout.inputs[(stage + 1).min(model.steps)]),
            ];
            for (slope, at) in parts {
                for (offset, value) in slope.iter().flat_map(|slope| slope.iter().enumerate()) {
                    both(place, at + offset, *value);
                }
            }
        }
        // The diagonal blocks, once each.
        for (stage, curvature) in curvature.iter().enumerate() {
            let (u, z) = (layout.inputs[stage], layout.states[stage]);
            let weight = model.kick_weight(stage);
            for i in 0..m {
                for j in 0..m {
                    let rows = curvature.inputs.as_ref().map_or(0.0, |inputs| inputs[(i, j)]);
                    // Lie–Euler has no u_0: keep it where it is.
                    let own = if weight > 0.0 {
                        model.weight[(i, j)] * weight
                    } else {
                        f64::from(u8::from(i == j))
                    };
                    entries.push((u + i, u + j, own + rows));
                }
            }
            for i in 0..n {
                for j in 0..n {
                    entries.push((z + i, z + j, curvature.state[(i, j)]));
                }
            }
        }
        let terminal = (0..model.terminal_count()).map(|row| layout.terminal + row);
        entries.extend(layout.rows.iter().flatten().map(|place| (*place, *place, -proximal)));
        entries.extend(terminal.map(|place| (place, place, -PROXIMAL)));
        Some(Self { layout, entries })
    }
}
