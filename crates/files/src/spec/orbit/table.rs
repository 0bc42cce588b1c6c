//! Check that the rows of a table of positions lie on an orbit, and are close enough to each other
//! for interpolation.
//!
//! The velocities allow an independent check. From each row, two-body motion is propagated to the
//! next row and to the middle of the interval between them. The effect of the Earth's oblateness is
//! not included, but its size is known. A row is wrong if it disagrees with both of its neighbours
//! while the neighbours agree with each other. An interval whose ends disagree contains a maneuver,
//! or one of its two rows is wrong. If the interpolation polynomial disagrees with the propagated
//! position in the middle, the rows are too far apart.

use super::super::Section;
use slewkit::numerics::figures::significant;
use slewkit_sky::{Table, two_body};

/// Allowed difference of positions in addition to the effect of the oblateness \[m\]. It covers
/// other celestial bodies, drag and rounded digits over some minutes.
const ALLOWED: f64 = 100.0;
/// Largest accepted relative position error of the interpolation.
const ELSEWHERE: f64 = 1e-3;

/// Line number, reason and remedy of an error.
type Apart = (usize, String, &'static str);

/// Checks the rows that the maneuver needs, up to `ahead` \[s\] after the epoch. `line` has the
/// line numbers of the rows in the file, which messages call `shown`.
pub(super) fn check(
    section: &Section,
    table: &Table,
    line: &[usize],
    ahead: f64,
    shown: &str,
) -> Result<(), Apart> {
    let Table { time, position, velocity, between } = table;
    let count = time.len();
    let first = time.partition_point(|at| *at <= 0.0).saturating_sub(between.rows());
    let last = (time.partition_point(|at| *at < ahead) + between.rows()).min(count - 1);
    for k in first..=last {
        if two_body(&position[k], &velocity[k], 0.0).is_none() {
            let [distance, speed] =
                [&position[k], &velocity[k]].map(|vector| significant(vector.norm() / 1e3, 4));
            let reason = format!("at {distance} km a velocity of {speed} km/s escapes from the Earth");
            return Err((line[k], reason, "give positions in km and velocities in km/s: are these metres?"));
        }
    }
    // Returns the difference between the propagated and the tabulated position, and the largest
    // accepted difference, both in metres.
    let missed = |from: usize, to: usize| {
        let step = time[to] - time[from];
        let of = |from: usize, to: usize, step: f64| {
            let ((met, _), flattened) = two_body(&position[from], &velocity[from], step)?;
            Some(((met - position[to]).norm(), flattened))
        };
        match (of(from, to, step), of(to, from, -step)) {
            (Some((there, one)), Some((back, two))) => (there.min(back), ALLOWED + one.max(two)),
            _ => (0.0, ALLOWED),
        }
    };
    let off = |from: usize, to: usize| {
        let (missed, allowed) = missed(from, to);
        missed > allowed
    };
    let km = |from: usize, to: usize| significant(missed(from, to).0 / 1e3, 3);
    let intervals: Vec<usize> = (first..last).filter(|k| off(*k, k + 1)).collect();
    if intervals.len() * 2 > last - first && intervals.len() > 2 {
        let k = intervals[0];
        let reason = format!(
            "the velocities do not fit the positions: the orbit from this row misses the next by {} km",
            km(k, k + 1)
        );
        return Err((
            line[k],
            reason,
            "give rows that are closer together, and velocities in km/s against REF_FRAME",
        ));
    }
    let mut told = 0;
    let mut k = 0;
    while k < intervals.len() {
        let (from, to) = (intervals[k], intervals[k] + 1);
        let alone = intervals.get(k + 1) == Some(&to) && to < last && !off(from, to + 1);
        let (row, text) = if alone {
            (
                to,
                format!(
                    "this row contradicts its neighbours: the orbit through them misses it by {} km",
                    km(from, to)
                ),
            )
        } else {
            let text = format!(
                "between this row and the next the orbit jumps by {} km: a maneuver, or a row that is wrong",
                km(from, to)
            );
            (from, text)
        };
        k += if alone { 2 } else { 1 };
        told += 1;
        if told <= MOST_TOLD {
            let reason = format!("{shown}: line {}: {text}", line[row]);
            section.warn("W0077", "oem", reason, "check the row, or use another file");
        }
    }
    if told > 0 {
        return Ok(());
    }
    let mut worst = (0.0_f64, 0.0_f64, first);
    for k in first..last {
        let half = 0.5 * (time[k + 1] - time[k]);
        let Some(((met, _), flattened)) = two_body(&position[k], &velocity[k], half) else { continue };
        let Some(taken) = table.position(time[k] + half) else { continue };
        let apart = (met - taken).norm();
        if apart > ALLOWED + flattened && apart > worst.0 {
            worst = (apart, apart / position[k].norm(), k);
        }
    }
    let (apart, part, k) = worst;
    if apart > 0.0 {
        let reason = format!(
            "rows {} s apart are not enough for this orbit: between this row and the next the \
                 polynomial is off by {} km",
            significant(time[k + 1] - time[k], 4),
            significant(apart / 1e3, 3)
        );
        let remedy = "use rows that are closer together";
        if part > ELSEWHERE {
            return Err((line[k], reason, remedy));
        }
        section.warn("W0077", "oem", format!("{shown}: line {}: {reason}", line[k]), remedy);
    }
    Ok(())
}

/// Largest number of wrong rows that are reported.
const MOST_TOLD: usize = 3;
