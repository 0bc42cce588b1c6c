//! The rows of a program, and the unknowns on which each depends.

use super::super::program::{RowKind, Shape};
use super::{Bound, Lane, NO_ROW, Norm, Row};
use crate::optimize::chain::model::Model;
use crate::optimize::chain::rows::{LimitRows, What};

/// Appends the rows of a stage with the unknowns on which they depend.
pub(super) fn describe(
    model: &Model,
    limits: &LimitRows,
    (lanes, norms): (&[Lane], &[Norm]),
    stage: usize,
    shape: &mut Shape,
    rows: &mut Vec<Row>,
) {
    let (own, m) = (lanes.len(), shape.m);
    let (zeta, pi, duration) = (m + model.zeta(), m + model.pi(), model.duration.map(|d| m + d));
    let of_input = |input: usize| {
        lanes.iter().enumerate().filter(move |(_, lane)| lane.input == input).map(|(place, _)| place)
    };
    let kind = |row: usize, hard: bool| {
        if limits.rows[row].what.is_equation() {
            RowKind::Equation
        } else if hard || limits.groups[limits.rows[row].group].hard {
            RowKind::Hard
        } else {
            RowKind::Elastic
        }
    };
    let turning = !model.is_free() || model.turning(false).is_some() || model.turning(true).is_some();
    // Unknowns that determine the motion on the arc after a stage.
    let kicked = |attitude: bool| -> Vec<usize> {
        let mut all: Vec<usize> = (0..own).collect();
        if turning && zeta > m {
            all.extend(m..m + 3);
        }
        if attitude || turning {
            all.extend(zeta..zeta + 3);
        }
        all.extend(pi..pi + 3);
        all.extend(pi + 3..pi + 3 + model.wheels);
        all.extend(duration);
        all
    };
    for row in limits.range(stage) {
        let what = &limits.rows[row].what;
        let mut put = |kind: RowKind, unknowns: Vec<usize>| {
            shape.row(kind, unknowns);
            rows.push(Row { bound: Bound::Row, row });
        };
        match what {
            What::InputSize { input, .. } => {
                put(kind(row, true), of_input(*input).chain(duration).collect());
            }
            What::InputNorm { .. } => {
                let attitude = if turning { Some(zeta..zeta + 3) } else { None };
                put(
                    kind(row, true),
                    (0..own).chain(attitude.into_iter().flatten()).chain(duration).collect(),
                );
            }
            What::RateNorm { .. } | What::RateAxis { .. } => put(kind(row, false), kicked(false)),
            What::Wheel { wheel, .. } => {
                let own = [pi + 3 + wheel];
                let inputs = of_input(model.forces + wheel);
                put(kind(row, false), inputs.chain(own).chain(duration).collect());
            }
            What::Cone(cone) if cone.is_of_arc() => put(kind(row, false), kicked(true)),
            What::Cone(_) if what.is_equation() => {
                put(kind(row, false), (zeta..zeta + 3).chain(duration).collect());
            }
            What::Push { input, .. } | What::Burn { input, .. } => {
                for place in of_input(*input) {
                    shape.row(RowKind::Hard, [place]);
                    rows.push(Row { bound: Bound::Side(place), row });
                }
            }
            What::BurnOfNorm { forces, .. } => {
                let found = norms.iter().enumerate().find(|(_, norm)| norm.forces == *forces);
                if let Some((index, norm)) = found {
                    let of_set = |place: &usize| (lanes[*place].input < model.forces) == *forces;
                    shape.row(RowKind::Hard, (0..own).filter(of_set).chain([norm.place]));
                    rows.push(Row { bound: Bound::Norm(index), row });
                }
            }
            What::Cone(_) | What::InputRate { .. } => {}
        }
    }
    // Limits on the change of inputs from the previous stage to this one.
    for row in stage.checked_sub(1).map_or(0..0, |before| limits.range(before)) {
        let What::InputRate { input, .. } = limits.rows[row].what else { continue };
        let before = m + model.n + input;
        shape.row(RowKind::Hard, of_input(input).chain(duration).chain([before]));
        rows.push(Row { bound: Bound::Change, row });
    }
}

/// Appends the rows that keep the roll of the end within its band.
pub(super) fn hold_roll(roll: usize, shape: &mut Shape, rows: &mut Vec<Row>) {
    for side in [1.0, -1.0] {
        shape.row(RowKind::Hard, [shape.m + roll]);
        rows.push(Row { bound: Bound::Roll(side), row: NO_ROW });
    }
}

/// Returns the sets of inputs whose fuel is charged by the norm of their sum.
pub(super) fn norms(model: &Model, limits: &LimitRows, first: usize) -> Vec<Norm> {
    let mut norms: Vec<Norm> = Vec::new();
    for row in &limits.rows {
        let What::BurnOfNorm { forces, limit } = row.what else { continue };
        if norms.iter().all(|norm| norm.forces != forces) {
            let (_, input) = model.channel(forces);
            let price = model.fuel.as_ref().map_or(0.0, |fuel| fuel.inputs[input]) * limit;
            norms.push(Norm { forces, limit, price, place: first + norms.len() });
        }
    }
    norms
}
