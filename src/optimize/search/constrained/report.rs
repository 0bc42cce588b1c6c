//! What is told of maneuvers that the convex road found.

use super::{Found, Search, relaxed};
use crate::Matrix3;
use crate::maneuver::problem::{Motion, Problem};
use crate::maneuver::solution::{
    ActiveConstraint, ConvexWork, Optimality, Outcome, Rival, Sense, Solution, TerminalError,
};
use crate::optimize::methods::scp::{self, Watch, iterate::Iterate, model::Model, rows::Rows};
use crate::optimize::search::record;
use crate::optimize::sweep::BoundaryValueProblem;
use nalgebra::DVector;

impl Search<'_, '_> {
    /// Everything that is told of a converged maneuver.
    pub(super) fn fill(&self, solution: &mut Solution, model: &Model, rows: &Rows, found: Found) {
        let Some(polished) = &found.convex.polished else { return };
        solution.outcome = Outcome::Converged;
        solution.start = found.name.clone();
        solution.iterations = found.subproblems + found.newton;
        solution.convex = Some(ConvexWork { subproblems: found.subproblems, ..self.work });
        self.write(solution, model, &polished.iterate, &polished.multipliers.costates);
        solution.optimality = Optimality {
            stationarity: polished.residual,
            conjugate_points: scp::second_order::descents(
                model,
                rows,
                &polished.iterate,
                &polished.multipliers,
                &Watch { interrupt: &|| self.context.interrupt(), deadline: None },
            ),
            rank: model.terminal_count(),
            condition: f64::NAN,
        };
        solution.active = rows
            .groups
            .iter()
            .enumerate()
            .filter_map(|(group, named)| {
                let acting = rows.rows.iter().zip(&polished.multipliers.rows);
                let acting = acting.filter(|(row, multiplier)| row.group == group && **multiplier > 0.0);
                let (time_s, multiplier): (Vec<f64>, Vec<f64>) = acting
                    .map(|(row, multiplier)| (row.stage as f64 * self.problem.step(), *multiplier))
                    .unzip();
                (!time_s.is_empty()).then(|| ActiveConstraint {
                    name: named.name.clone(),
                    time_s,
                    multiplier,
                })
            })
            .collect();
    }

    /// The trajectory of an iterate in SI units, with its cost and terminal error.
    pub(super) fn write(
        &self,
        solution: &mut Solution,
        model: &Model,
        iterate: &Iterate,
        costates: &[DVector<f64>],
    ) {
        let Ok(replayed) = iterate.replayed(model) else { return };
        solution.cost = iterate.cost(model) * model.dynamics.units.cost;
        let (error, _) = model.terminal(&replayed.states[model.steps]);
        let norm = |row: usize| error.rows(row, 3).norm();
        let moves = model.terminal_count() == 12;
        solution.terminal = TerminalError {
            attitude_rad: norm(model.zeta()),
            momentum_relative: norm(model.pi()),
            position_relative: moves.then(|| norm(0)),
            linear_momentum_relative: moves.then(|| norm(3)),
        };
        solution.trajectory = scp::record::trajectory(self.problem, model, &replayed, costates);
        let attitudes: Vec<Matrix3> = replayed.states.iter().map(|state| state.attitude).collect();
        solution.sense = sense(self.problem, &attitudes);
        solution.turned_deg = turned_deg(model, &replayed);
    }
}

/// A maneuver that was found, as one of several.
pub(super) fn rival(problem: &Problem, model: &Model, found: &Found, unit: f64) -> Rival {
    let iterate = found.convex.polished.as_ref().map_or(&found.convex.iterate, |polished| &polished.iterate);
    let attitudes: Vec<Matrix3> = iterate.states.iter().map(|state| state.attitude).collect();
    Rival {
        sense: sense(problem, &attitudes),
        start: found.name.clone(),
        cost: found.cost * unit,
        conjugate_points: None,
        turned_deg: turned_deg(model, iterate),
    }
}

/// Total angle turned, inertial \[deg\].
fn turned_deg(model: &Model, iterate: &Iterate) -> f64 {
    let rates: Vec<f64> = (0..=model.steps)
        .map(|stage| {
            let physical = model.physical(stage, &iterate.states[stage], &iterate.inputs[stage]);
            let carried = model.wheel_momentum(&physical.wheels);
            (model.dynamics.j_inverse * (physical.momentum - carried)).norm()
        })
        .collect();
    let sum: f64 = rates.windows(2).map(|pair| 0.5 * model.h * (pair[0] + pair[1])).sum();
    sum.to_degrees()
}

/// The sense of a path of attitudes; the straight one where it cannot be told.
pub(super) fn sense(problem: &Problem, attitudes: &[Matrix3]) -> Sense {
    let relaxed = relaxed(problem);
    let sense = match problem.motion {
        Motion::Attitude => {
            record::sense_of::<6>(&BoundaryValueProblem::new(&relaxed, problem.steps), attitudes)
        }
        Motion::RigidBody => {
            record::sense_of::<12>(&BoundaryValueProblem::new(&relaxed, problem.steps), attitudes)
        }
    };
    sense.unwrap_or(Sense::Short)
}
