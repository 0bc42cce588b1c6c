//! Whether stationary arcs satisfy the maximum principle, and by how much they fail it.
//!
//! The multipliers of the equations are what the costates `p` begin with at the end, and by what they jump at
//! contacts; along an arc `p` goes backwards by the transposed flow of the closed loop. An input must minimise
//!
//! ```text
//! s_i v_i + c_i |v_i| ,     s_i = p · (E_i + Σ_f E_f ∂v_f/∂v_i) + Σ_f c_f sign(v_f) ∂v_f/∂v_i
//! ```
//!
//! with what inputs do to the derivative of the state, `E`, and the free inputs `f` making up for it. A free input is what
//! `S = (p·E_f + c_f sign v_f)/(ν·E_f)` says of its limit: the multiplier of a limit of order one is `Ṡ`, of order two `−S̈`, and
//! must not be negative; nor must that of a contact, which is that of its equation.

use super::constraint::Limit;
use super::motion::{Driven, Input, Law, Level, Maneuver};
use super::newton::Stationary;
use super::state::{CHANGES, Change, State};
use crate::Vector3;
use crate::numerics::hermite::hermite;
use nalgebra::{DMatrix, DVector, SVector};

/// Least number of samples of an arc.
const SAMPLES: usize = 8;

/// Points between samples at which limits are looked at.
const POINTS: usize = 8;

/// Limits may be exceeded by this: far more than interpolation between samples leaves.
const EXCEEDED: f64 = 1e-8;

/// Switching functions below this part of the largest are zero: what differences of the flow leave.
const ZERO: f64 = 1e-6;

/// What is wrong with arcs.
#[derive(Clone, Debug, PartialEq)]
pub(crate) enum Wrong {
    /// An input should be at another level on a stretch of an arc, from one time of it to another.
    Level { arc: usize, input: usize, wanted: f64, from: f64, to: f64 },
    /// A loose input should be at a limit somewhere, or off.
    Loose { input: usize },
    /// A limit is exceeded within an arc, most at this time of it; from and to.
    Exceeded { arc: usize, limit: usize, at: f64, from: f64, to: f64 },
    /// A contact holds the motion to a limit that it would leave inwards.
    Repelled { arc: usize, limit: usize },
    /// An arc holds a limit that the motion would leave inwards, from one time of it to another.
    Released { arc: usize, limit: usize, from: f64, to: f64 },
    /// A free input is beyond this level, a limit of its own, on a stretch of an arc.
    Beyond { arc: usize, input: usize, level: f64, from: f64, to: f64 },
}

/// What is found along arcs.
#[derive(Clone, Debug)]
pub(crate) struct Certificate {
    /// The worst of each kind first, limits before signs.
    pub wrong: Vec<Wrong>,
    /// What the inputs at a level leave of the least Hamiltonian, integrated over their arcs by the trapezoidal rule, in the unit of cost.
    pub gap: f64,
}

/// One sample of an arc.
struct Sample {
    time: f64,
    state: State,
    costate: Change,
}

impl Certificate {
    pub fn of(maneuver: &Maneuver, found: &Stationary) -> Option<Self> {
        let Stationary { arcs, followed, multipliers, .. } = found;
        let last = followed.nodes.last()?;
        let (ends, mut costate) = (maneuver.ends(), Change::zeros());
        for row in 0..ends {
            costate += multipliers[row] * last.gradient(&|state| state.minus(&maneuver.end)[row]);
        }
        let mut sampled = Vec::with_capacity(arcs.laws.len());
        for arc in (0..arcs.laws.len()).rev() {
            let driven = maneuver.driven(&arcs.laws[arc])?;
            let samples = sampled_back(&driven, &followed.nodes[arc], arcs.lengths[arc], costate);
            costate = samples.first()?.costate;
            for (row, contact) in followed.contacts.iter().enumerate() {
                if contact.arc == arc {
                    let slope = followed.nodes[arc].gradient(&|state| contact.missed(maneuver, state));
                    costate += multipliers[ends + row] * slope;
                }
            }
            sampled.push(samples);
        }
        sampled.reverse();
        let mut scale: f64 = 0.0;
        for sample in sampled.iter().flatten() {
            let pull = |input: &Input| pull(maneuver, sample, input).abs();
            scale = maneuver.inputs.iter().map(pull).fold(scale, f64::max);
        }
        let zero = ZERO * scale;
        let mut wrong = Vec::new();
        for (row, contact) in followed.contacts.iter().enumerate() {
            let touched = !arcs.laws[contact.arc].holds.contains(&contact.limit);
            if touched && !contact.slope && multipliers[ends + row] < -zero {
                let repelled = Wrong::Repelled { arc: contact.arc, limit: contact.limit };
                wrong.push((-multipliers[ends + row], repelled));
            }
        }
        let (mut exceeded, mut levels, mut loose, mut gap) = (Vec::new(), Vec::new(), Vec::new(), 0.0);
        for (arc, (law, samples)) in arcs.laws.iter().zip(&sampled).enumerate() {
            let driven = maneuver.driven(law)?;
            exceeded.extend(exceeding(maneuver, &driven, arc, law, samples));
            wrong.extend(beyond(maneuver, &driven, arc, law, samples));
            wrong.extend(released(maneuver, &driven, arc, law, samples, zero));
            for (input, level) in law.levels.iter().enumerate() {
                let Some(part) = level.part() else { continue };
                let mut own = Vec::new();
                gap += stretches(maneuver, &driven, (arc, law), (input, part), samples, zero, &mut own);
                match level {
                    Level::Loose(_) => {
                        loose.extend(own.iter().map(|(size, _)| (*size, Wrong::Loose { input })))
                    }
                    _ => levels.extend(own),
                }
            }
        }
        let mut all = Vec::new();
        for mut kind in [exceeded, wrong, levels, loose] {
            kind.sort_by(|a: &(f64, Wrong), b| b.0.total_cmp(&a.0));
            all.extend(kind.into_iter().map(|(_, wrong)| wrong));
        }
        // The largest of numbers passes over those that are none, their sum does not.
        (scale + gap).is_finite().then_some(Self { wrong: all, gap })
    }
}

/// Samples along an arc, the costate at whose end is given.
fn sampled_back(driven: &Driven, from: &State, length: f64, costate: Change) -> Vec<Sample> {
    let count = driven.steps(from, length).max(SAMPLES);
    let (mut state, mut pieces) = (*from, Vec::with_capacity(count));
    for _ in 0..count {
        let (to, slope) = driven.linearised(&state, length / count as f64, 1);
        pieces.push((state, slope));
        state = to;
    }
    let mut samples = vec![Sample { time: length, state, costate }];
    let mut costate = costate;
    for (index, (state, slope)) in pieces.iter().enumerate().rev() {
        let mut after = SVector::<f64, { CHANGES + 1 }>::zeros();
        after.fixed_rows_mut::<CHANGES>(0).copy_from(&costate);
        after[CHANGES] = 1.0;
        costate = slope.tr_mul(&after);
        samples.push(Sample { time: length * index as f64 / count as f64, state: *state, costate });
    }
    samples.reverse();
    samples
}

/// `p · E_i`: what an input does to the derivative of the state, by the costates.
fn pull(maneuver: &Maneuver, sample: &Sample, input: &Input) -> f64 {
    sample.costate.dot(&maneuver.effect(input, &sample.state))
}

/// The free inputs of a law, in their order.
fn free(law: &Law) -> Vec<usize> {
    (0..law.levels.len()).filter(|input| law.levels[*input] == Level::Free).collect()
}

/// `s_i` of an input at a level.
fn switching(maneuver: &Maneuver, driven: &Driven, law_free: &[usize], input: usize, sample: &Sample) -> f64 {
    let input = &maneuver.inputs[input];
    let mut sum = pull(maneuver, sample, input);
    if !law_free.is_empty() {
        let makes_up = driven.compensation(&sample.state, &maneuver.effect(input, &sample.state));
        let levels = driven.free_levels(&sample.state);
        for (index, other) in law_free.iter().enumerate() {
            let other = &maneuver.inputs[*other];
            let price = other.price * levels[index].signum();
            sum += makes_up[index] * (pull(maneuver, sample, other) + price);
        }
    }
    sum
}

/// Adds the stretches of an arc on which an input should have another level, and gives what its level leaves of the least Hamiltonian,
/// integrated over the arc.
fn stretches(
    maneuver: &Maneuver,
    driven: &Driven,
    (arc, law): (usize, &Law),
    (input, level): (usize, f64),
    samples: &[Sample],
    zero: f64,
    found: &mut Vec<(f64, Wrong)>,
) -> f64 {
    let law_free = &free(law);
    let Input { price, lowest, .. } = maneuver.inputs[input];
    let cost = |s: f64, level: f64| s * level + price * level.abs();
    let missing = |sample: &Sample| {
        let s = switching(maneuver, driven, law_free, input, sample);
        let best = [lowest, 0.0, 1.0].into_iter().min_by(|a, b| cost(s, *a).total_cmp(&cost(s, *b)));
        let best = best.unwrap_or(level);
        (cost(s, level) - cost(s, best), best)
    };
    let missing: Vec<(f64, f64)> = samples.iter().map(missing).collect();
    let (mut open, mut gap): (Option<(f64, f64, f64, f64)>, f64) = (None, 0.0);
    let mut close = |open: &mut Option<(f64, f64, f64, f64)>, to: f64| {
        if let Some((from, size, wanted, _)) = open.take() {
            found.push((size, Wrong::Level { arc, input, wanted, from, to }));
        }
    };
    for (pair, values) in samples.windows(2).zip(missing.windows(2)) {
        let [(before, first), (after, second)] = [values[0], values[1]];
        let (start, length) = (pair[0].time, pair[1].time - pair[0].time);
        let size = 0.5 * (before + after) * length;
        gap += size;
        if before <= zero && after <= zero {
            close(&mut open, start);
            continue;
        }
        let wanted = if before > after { first } else { second };
        // Of what begins or ends within, by the straight line.
        let part = |small: f64, large: f64| if small > zero { 0.0 } else { (zero - small) / (large - small) };
        let from = start + if before < after { length * part(before, after) } else { 0.0 };
        match &mut open {
            Some((_, sum, best, most)) => {
                *sum += size;
                if before.max(after) > *most {
                    (*best, *most) = (wanted, before.max(after));
                }
            }
            None => open = Some((from, size, wanted, before.max(after))),
        }
        if after <= zero {
            close(&mut open, start + length * (1.0 - part(after, before)));
        }
    }
    close(&mut open, samples.last().map_or(0.0, |sample| sample.time));
    gap
}

/// The worst excess of a limit that the arc does not hold.
fn exceeding(
    maneuver: &Maneuver,
    driven: &Driven,
    arc: usize,
    law: &Law,
    samples: &[Sample],
) -> Vec<(f64, Wrong)> {
    let mut found = Vec::new();
    let idle = |index: &usize| !law.holds.contains(index);
    for limit in (0..maneuver.limits.len()).filter(idle) {
        let of: &Limit = &maneuver.limits[limit];
        let at = |sample: &Sample| {
            let rate = if of.order() == 2 {
                of.slope(&sample.state)
            } else {
                let (normal, rest) = of.held(&sample.state);
                normal.dot(&driven.rates(&sample.state).1) + rest
            };
            (of.value(&sample.state), rate)
        };
        let values: Vec<(f64, f64)> = samples.iter().map(at).collect();
        let (mut worst, mut when) = (EXCEEDED, None);
        let mut stretch: Option<(f64, f64)> = None;
        for (pair, ends) in samples.windows(2).zip(values.windows(2)) {
            let length = pair[1].time - pair[0].time;
            for point in 0..=POINTS {
                let part = point as f64 / POINTS as f64;
                let [from, to] = [0, 1].map(|end: usize| Vector3::x() * ends[end].0);
                let [first, last] = [0, 1].map(|end: usize| Vector3::x() * ends[end].1);
                let between = hermite(part, length, [&from, &to], [&first, &last]).x;
                let time = pair[0].time + part * length;
                if between > EXCEEDED {
                    stretch = Some((stretch.map_or(time, |(from, _)| from), time));
                }
                if between > worst {
                    (worst, when) = (between, Some(time));
                }
            }
        }
        if let (Some(at), Some((from, to))) = (when, stretch) {
            found.push((worst, Wrong::Exceeded { arc, limit, at, from, to }));
        }
    }
    found
}

/// Free inputs that are beyond their limits somewhere.
fn beyond(
    maneuver: &Maneuver,
    driven: &Driven,
    arc: usize,
    law: &Law,
    samples: &[Sample],
) -> Vec<(f64, Wrong)> {
    let mut found = Vec::new();
    for (index, input) in free(law).into_iter().enumerate() {
        let lowest = maneuver.inputs[input].lowest;
        let level = |sample: &Sample| driven.free_levels(&sample.state)[index];
        for (limit, side) in [(1.0, 1.0), (lowest, -1.0)] {
            let excess = |sample: &Sample| side * (level(sample) - limit);
            let worst = samples.iter().map(excess).fold(f64::NEG_INFINITY, f64::max);
            let mut beyond =
                samples.iter().filter(|sample| excess(sample) > EXCEEDED).map(|sample| sample.time);
            if let Some(from) = beyond.next() {
                let to = beyond.next_back().unwrap_or(from);
                found.push((worst, Wrong::Beyond { arc, input, level: limit, from, to }));
            }
        }
    }
    found
}

/// Limits that an arc holds though their multiplier has the wrong sign.
fn released(
    maneuver: &Maneuver,
    driven: &Driven,
    arc: usize,
    law: &Law,
    samples: &[Sample],
    zero: f64,
) -> Vec<(f64, Wrong)> {
    let free = free(law);
    if free.is_empty() {
        return Vec::new();
    }
    let count = free.len();
    let mut found = Vec::new();
    let worths: Vec<(f64, DVector<f64>)> = samples
        .iter()
        .filter_map(|sample| {
            let levels = driven.free_levels(&sample.state);
            let matrix = DMatrix::from_fn(count, count, |row, column| {
                let limit = &maneuver.limits[law.holds[column]];
                let effect = maneuver.effect(&maneuver.inputs[free[row]], &sample.state);
                limit.held(&sample.state).0.dot(&effect)
            });
            let pulls = DVector::from_fn(count, |row, _| {
                let input = &maneuver.inputs[free[row]];
                pull(maneuver, sample, input) + input.price * levels[row].signum()
            });
            Some((sample.time, matrix.lu().solve(&pulls)?))
        })
        .collect();
    for (index, limit) in law.holds.iter().enumerate() {
        let values: Vec<(f64, f64)> = worths.iter().map(|(time, worth)| (*time, worth[index])).collect();
        let pulled: Vec<(f64, f64, f64)> = if maneuver.limits[*limit].order() == 1 {
            values.windows(2).map(|pair| (pair[0].1 - pair[1].1, pair[0].0, pair[1].0)).collect()
        } else {
            let second = |three: &[(f64, f64)]| three[0].1 - 2.0 * three[1].1 + three[2].1;
            values.windows(3).map(|three| (second(three), three[0].0, three[2].0)).collect()
        };
        let mut wrong = pulled.iter().filter(|(pulled, _, _)| *pulled > zero);
        if let Some(first) = wrong.next() {
            let last = wrong.next_back().unwrap_or(first);
            let most = pulled.iter().map(|(pulled, _, _)| *pulled).fold(0.0, f64::max);
            found.push((most, Wrong::Released { arc, limit: *limit, from: first.1, to: last.2 }));
        }
    }
    found
}
