//! Conversions from an iterate of the chain to a point of the program and back.

use super::super::program::{Duals, Point, Shape};
use super::ChainProgram;
use crate::optimize::chain::Multipliers;
use crate::optimize::chain::iterate::Iterate;
use crate::optimize::chain::model::{ChainState, step};
use crate::optimize::chain::rows::What;
use crate::{Matrix3, Vector3};
use nalgebra::DVector;

impl ChainProgram<'_> {
    /// Writes the point that corresponds to an iterate.
    pub fn point(&self, iterate: &Iterate, out: &mut Point) {
        let (model, c) = (self.model, self.shape.coordinates);
        if self.roll.is_some() {
            let end = &iterate.states[model.steps];
            let roll = self.nearest_roll(iterate.stretch(), &end.attitude);
            out.states.chunks_exact_mut(c).for_each(|state| state[c - 1] = roll);
        }
        for stage in 0..=model.steps + 1 {
            let after = stage == model.steps + 1;
            let node = stage.min(model.steps);
            let (state, inputs) = (&iterate.states[node], &iterate.inputs[node]);
            let state = if stage == 0 {
                model.start_in(iterate.stretch())
            } else if after {
                state.clone()
            } else {
                step::before_kick(model, node, state, inputs)
            };
            self.write(&state, &mut out.states[stage * c..][..c]);
            if self.before > 0 {
                let before = &mut out.states[stage * c + self.held()..][..self.before];
                before.fill(0.0);
                if stage > 0 {
                    let inputs = &iterate.inputs[stage - 1];
                    before.iter_mut().zip(inputs).zip(&self.units).for_each(|((to, u), unit)| *to = u / unit);
                }
            }
            if !after {
                for (lane, to) in self.lanes.iter().zip(&mut out.inputs[stage * self.shape.m..]) {
                    let part = inputs[lane.input] / lane.factor;
                    let split = self.lanes.iter().filter(|other| other.input == lane.input).count() > 1;
                    *to = if stage < model.first_input() {
                        0.0
                    } else if split {
                        part.max(0.0)
                    } else {
                        part
                    };
                }
                for norm in &self.norms {
                    out.inputs[stage * self.shape.m + norm.place] =
                        self.burnt(norm, inputs).norm() + self.tuning.spare;
                }
            }
        }
    }

    /// Writes the coordinates of a state, without the previous inputs.
    fn write(&self, state: &ChainState, out: &mut [f64]) {
        let mut at = 0;
        let mut put = |values: &[f64]| {
            out[at..at + values.len()].copy_from_slice(values);
            at += values.len();
        };
        if self.model.zeta() == 6 {
            put(state.position.as_slice());
            put(state.linear_momentum.as_slice());
        }
        put(state.attitude.as_slice());
        put(state.momentum.as_slice());
        put(state.wheels.as_slice());
        put(&[state.stretch]);
    }

    /// Converts the coordinates of a state to a state of the chain.
    fn read(&self, from: &[f64]) -> ChainState {
        let body = if self.model.zeta() == 6 { 6 } else { 0 };
        let vector = |at: usize| Vector3::from_column_slice(&from[at..at + 3]);
        let zero = Vector3::zeros();
        ChainState {
            position: if body > 0 { vector(0) } else { zero },
            linear_momentum: if body > 0 { vector(3) } else { zero },
            attitude: Matrix3::from_column_slice(&from[body..body + 9]),
            momentum: vector(body + 9),
            wheels: DVector::from_column_slice(&from[body + 12..][..self.model.wheels]),
            stretch: from[body + 12 + self.model.wheels],
        }
    }

    /// Converts a point to the chain: states after their kicks, inputs, costates, and the
    /// multipliers of the chain's rows. `values` are the values of the program's rows. A row is
    /// active if its multiplier exceeds its slack. The multiplier of an inactive row is only the
    /// barrier parameter divided by the slack, and is set to zero.
    pub fn found(&self, at: &Point, duals: &Duals, values: &[f64]) -> (Iterate, Multipliers) {
        let Shape { n, m, coordinates: c, .. } = self.shape;
        let model = self.model;
        let by = 1.0 / self.scale;
        let (mut states, mut inputs, mut costates) = (Vec::new(), Vec::new(), Vec::new());
        for stage in 0..=model.steps {
            let mut own = vec![0.0; model.m];
            for (lane, w) in self.lanes.iter().zip(&at.inputs[stage * m..][..m]) {
                own[lane.input] += lane.factor * w;
            }
            let before = self.read(&at.states[stage * c..][..c]);
            let state = if stage == model.steps {
                self.read(&at.states[(stage + 1) * c..][..c])
            } else {
                step::after_kick(model, stage, &before, &own)
            };
            let costate = DVector::from_column_slice(&duals.costates[stage * n..][..model.n]) * by;
            costates.push(step::costate_after_kick(model, stage, &before, &own, &costate));
            states.push(state);
            inputs.push(own);
        }
        let mut rows = vec![0.0; self.limits.rows.len()];
        for ((row, multiplier), c) in self.rows.iter().zip(&duals.rows).zip(values) {
            let Some(what) = self.what_of(row) else { continue };
            let acts = multiplier + c > 0.0 || what.is_equation();
            if acts && !matches!(what, What::Burn { .. } | What::BurnOfNorm { .. }) {
                rows[row.row] += multiplier * by;
            }
        }
        self.to_nodes(at, &mut rows);
        let terminal = DVector::from_column_slice(&duals.terminal) * by;
        (Iterate { states, inputs }, Multipliers { costates, terminal, rows })
    }

    /// Moves the multiplier of an arc whose largest value is at an end to the row of the node at
    /// that end.
    fn to_nodes(&self, at: &Point, rows: &mut [f64]) {
        for row in &self.rows {
            let Some(limit) = self.limits.rows.get(row.row) else { continue };
            let What::Cone(cone) = &limit.what else { continue };
            if !cone.is_of_arc() || rows[row.row] == 0.0 {
                continue;
            }
            let mut space = self.space.borrow_mut();
            let Some(stage) = self.stage(at, limit.stage, &mut space) else { continue };
            let Some(found) = self.cone_at(cone, limit.stage, &stage) else { continue };
            let node = match found.fraction {
                fraction if fraction <= 0.0 => limit.stage,
                fraction if fraction >= 1.0 => limit.stage + 1,
                _ => continue,
            };
            let multiplier = std::mem::take(&mut rows[row.row]);
            let same = |other: &usize| matches!(&self.limits.rows[*other].what, What::Cone(other) if other.is_node_of(cone));
            if let Some(other) = self.limits.range(node).find(same) {
                rows[other] += multiplier;
            }
        }
    }
}
