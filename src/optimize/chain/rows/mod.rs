//! Limits and constraints as inequality rows of the stages, each scaled by its limit.
//!
//! A row is a half space `c ≤ 0` or a ball `|v| ≤ 1`, and it provides its derivatives. A condition
//! that must hold between the nodes has a row for each arc, the motion on one step, on which the
//! body turns about one axis at a constant rate.
//!
//! If the duration is free, the scaled limits grow with its multiple s, as `s`, `s²` or `s³`
//! (`model`).
//!
//! Inputs that burn fuel have rows that impose no bound and only mark the input for the interior
//! point method: a two-sided input, or a set that is charged by the norm of its output. A one-sided
//! input has a row `u ≥ 0`.
//!
//! # Why are there rows for arcs?
//!
//! On one step the body turns about one axis at one rate, so the closest approach of a boresight to
//! a direction on the arc is the root of one smooth function, and the row is differentiated at that
//! point by the envelope theorem. If the extremum is at an end of the arc, the row of the node
//! covers it, and the row of the arc is inactive: two rows for one condition would make the active
//! set degenerate.

mod boresight;
mod what;

use super::model::Model;
use crate::maneuver::constraint::Rule;
use crate::maneuver::problem::Problem;
use crate::mechanics::actuators::{InputLimit, LimitKind};
pub(crate) use boresight::Bend;
use std::ops::Range;
pub(crate) use what::{Cone, ConeAt, What};

/// A limit or constraint at one stage.
#[derive(Clone, Debug)]
pub(crate) struct LimitRow {
    /// Index in [`LimitRows::groups`] of the constraint to which the row belongs.
    pub group: usize,
    pub stage: usize,
    pub what: What,
}

/// A constraint or limit to which several rows belong.
#[derive(Clone, Debug)]
pub(crate) struct Group {
    pub name: String,
    /// Whether every iterate must satisfy the limit, as for input limits. The iterates may violate
    /// other limits until the iteration converges.
    pub hard: bool,
    /// Whether violations are angles \[rad\] rather than relative to the limit.
    pub is_angle: bool,
}

/// All limit rows of a maneuver, ordered by stage.
#[derive(Clone, Debug, Default)]
pub(crate) struct LimitRows {
    pub groups: Vec<Group>,
    pub rows: Vec<LimitRow>,
}

impl LimitRows {
    /// Returns the range of indices of the rows of one stage.
    pub fn range(&self, stage: usize) -> Range<usize> {
        let first = |stage: usize| self.rows.partition_point(|row| row.stage < stage);
        first(stage)..first(stage + 1)
    }

    /// Builds the rows of a maneuver on the grid of `model`.
    pub fn of(problem: &Problem, model: &Model) -> Self {
        let mut rows = Self::default();
        rows.input_limits(problem, model);
        for constraint in &problem.constraints {
            let group = rows.group(&constraint.name, false);
            rows.groups[group].is_angle = matches!(constraint.rule, Rule::Pointing(_));
            // One row at every inner node and one on every arc.
            for (stage, arc) in (0..model.steps).flat_map(|stage| [(stage, false), (stage, true)]) {
                if arc || stage > 0 {
                    let whats = What::of(problem, &constraint.rule, arc);
                    rows.rows.extend(whats.into_iter().map(|what| LimitRow { group, stage, what }));
                }
            }
        }
        rows.burns(problem, model);
        rows.rows.sort_by_key(|row| row.stage);
        rows
    }

    /// Adds the rows of inputs that burn fuel, of one-sided inputs, and of forces or torques whose
    /// fuel is charged by their norm.
    fn burns(&mut self, problem: &Problem, model: &Model) {
        let bounds = model.input_bounds(problem);
        let sets = [(true, problem.actuation.force.as_ref(), 0..model.forces)];
        let sets = sets.into_iter().chain([(false, Some(&problem.actuation.torque), model.forces..model.m)]);
        for (forces, set, inputs) in sets {
            let Some(set) = set.filter(|_| !inputs.is_empty()) else { continue };
            let one_sided = set.limits().one_sided;
            let whats: Vec<What> = match (&model.fuel, set.limits().norm) {
                (Some(fuel), Some(norm)) if fuel.is_of_norm(forces) => {
                    vec![What::BurnOfNorm { forces, limit: norm / model.input_unit[inputs.start] }]
                }
                _ if one_sided => inputs.map(|input| What::Push { input, limit: bounds[input] }).collect(),
                (Some(_), _) => inputs.map(|input| What::Burn { input, limit: bounds[input] }).collect(),
                (None, _) => continue,
            };
            let group = self.group(problem.actuation.limit_name(LimitKind::Size, forces), true);
            for stage in model.first_input()..=model.steps {
                self.rows.extend(whats.iter().map(|what| LimitRow { group, stage, what: what.clone() }));
            }
        }
    }

    fn group(&mut self, name: &str, hard: bool) -> usize {
        self.groups.push(Group { name: name.into(), hard, is_angle: false });
        self.groups.len() - 1
    }

    /// Adds the rows of all input limits, for both signs, at every stage that has inputs; forces
    /// come first.
    fn input_limits(&mut self, problem: &Problem, model: &Model) {
        let mut limits: Vec<_> = problem.actuation.limits().collect();
        limits.retain(|limit| !limit.of_force || model.forces > 0);
        limits.sort_by_key(|limit| limit.first);
        for InputLimit { kind, name, of_force: forces, set, bounds, .. } in limits {
            let group = self.group(name, kind != LimitKind::WheelMomentum);
            let (_, offset) = model.channel(forces);
            let (unit, momentum) = (model.input_unit[offset], model.dynamics.units.momentum());
            // The lower limit 0 of a one-sided input is a separate row.
            let one_sided = kind == LimitKind::Size && set.limits().one_sided;
            let signs = if one_sided || kind == LimitKind::Norm { &[1.0][..] } else { &[1.0, -1.0] };
            let stages = match kind {
                LimitKind::Size | LimitKind::Norm => model.first_input()..=model.steps,
                LimitKind::Rate => model.first_input()..=model.steps - 1,
                LimitKind::WheelMomentum => 1..=model.steps,
            };
            for stage in stages {
                for (index, bound) in bounds.iter().enumerate().filter(|(_, bound)| bound.is_finite()) {
                    let input = offset + index;
                    let what = |sign: f64| match kind {
                        LimitKind::Size => What::InputSize { input, sign, limit: bound / unit },
                        LimitKind::Norm => What::InputNorm { forces, limit: bound / unit },
                        LimitKind::Rate => {
                            let limit = bound * problem.seconds() * model.dynamics.grid.step(stage) / unit;
                            What::InputRate { input, sign, limit }
                        }
                        LimitKind::WheelMomentum => {
                            What::Wheel { wheel: index, sign, limit: bound / momentum }
                        }
                    };
                    self.rows.extend(signs.iter().map(|sign| LimitRow { group, stage, what: what(*sign) }));
                }
            }
        }
    }
}
