//! Initial smoothed extremals of a turn, from which the continuation in ε starts.
//!
//! The initial path has angles that are cubic in time and meets the attitude and both rates. Its
//! duration is chosen so that the largest input is a given fraction of its limit, and its costates
//! are those for which the smoothed law produces these inputs. A body of any inertia is approached
//! from the isotropic one by the homotopy `J(s) = V diag(J_i^s) Vᵀ`, because the smoothed extremal
//! of a sphere is always found.
//!
//! # How do the methods for minimum time apply to minimum fuel?
//!
//! An input that costs fuel is one-sided: it is off at 0 and costs its price up to its limit. With
//! `f = ½ (1 + v)`, `v ∈ [−1, 1]`, the switching function of minimum time gains a constant,
//! `s = a·e + c`. Nothing else changes: the smoothed law (with the square root, which is also the
//! best of three for fuel), Newton, the certificate and the grid are shared. A two-sided torque is
//! two such inputs in opposite directions. If the duration is given, this equation replaces the
//! condition on the Hamiltonian, and on the grid the mean discrete Hamiltonians of all arcs are
//! equal instead of zero. Two things differ. First, between pulses every switching function is
//! positive, so a short pulse may leave no zero crossing in the smoothed law; pulses are therefore
//! identified by area and centroid. Second, a turn about one axis has two switches, which do not
//! determine the costates of the other axes; the Newton step is then the shortest one. If thrusters
//! of unequal strength have no extremal for any given or free duration, the extremal of inputs
//! whose mid-range torque is zero is continued to them.
//!
//! If only the norm of the torque is limited, fuel is `∫ c|τ| dt`, as for one motor that can point
//! anywhere. The magnitude of the torque is then one more one-sided input with `s = ½U(c − |e|)`,
//! where `U` is the norm limit. Its direction follows the costate, so on a burn arc the torque is
//! given by a law and is not constant (`ArcLaw`). `|e|` can stay within a thousandth of the price
//! for half of the maneuver (`problems/minimum_fuel_norm_moving.toml`). The smoothed law is
//! therefore continued to smaller ε, and arcs are identified by zero crossings first, because
//! pulses that are separated by short pauses merge.

use super::extremal::{Bias, Extremal, TorqueLimit};
use super::flow::Node;
use super::smooth::{Path, Smooth, Smoothed, descend};
use super::tuning::branches::BRANCHING;
use super::tuning::paths::*;
use super::tuning::smooth::{INTERVALS, INTERVALS_NEAR};
use super::tuning::{FAR_ITERATIONS, NOTHING};
use super::work::Work;
use crate::numerics::hermite::hermite;
use crate::optimize::methods::continuation::{Step, follow};
use crate::{Matrix3, Vector3, lie};

/// Initial path `R = exp(q 2πn) exp(φ)` to the terminal attitude: a rotation vector `φ` that is
/// cubic in time, and whole turns about an axis `n` of the reference frame, with `q` from 0 to 1
/// and zero rate of `q` at both ends.
#[derive(Clone, Copy, Debug)]
pub(super) struct Turn {
    pub phi: Vector3,
    /// Whole turns as a rotation vector, `2πn` times their number; zero without whole turns.
    pub whole: Vector3,
}

impl Turn {
    /// Creates a path without whole turns.
    pub fn straight(phi: Vector3) -> Self {
        Self { phi, whole: Vector3::zeros() }
    }

    /// Returns attitude, rate and acceleration in body axes at the fraction `u` of the duration.
    /// The acceleration omits the coupling of the two rotations and the gyroscopic torque.
    fn at(&self, ends: [&Vector3; 2], duration: f64, u: f64) -> (Matrix3, Vector3, Vector3) {
        let (a, b) = cubic(&self.phi, ends[0], ends[1], duration);
        let t = u * duration;
        let angle = t * ends[0] + t * t * (0.5 * a + u / 6.0 * b);
        let turned = lie::exp(&angle);
        let whole = turned.tr_mul(&self.whole);
        let rate = ends[0] + t * (a + 0.5 * u * b) + 6.0 * u * (1.0 - u) / duration * whole;
        let acceleration = a + u * b + (6.0 - 12.0 * u) / (duration * duration) * whole;
        let about = hermite(u, 1.0, [&0.0, &1.0], [&0.0, &0.0]) * self.whole;
        (lie::exp(&about) * turned, rate, acceleration)
    }
}

/// Returns `a` and `b` of the acceleration `a + b t/T` of angles that are cubic in time.
fn cubic(phi: &Vector3, start: &Vector3, end: &Vector3, duration: f64) -> (Vector3, Vector3) {
    let t = duration;
    let a = 6.0 / (t * t) * phi - (4.0 * start + 2.0 * end) / t;
    let b = -12.0 / (t * t) * phi + 6.0 * (start + end) / t;
    (a, b)
}

/// Returns the largest of the minimum-norm inputs that produce a torque, as a fraction of its
/// limit. For a limit on the norm of the torque, returns the norm as a fraction of this limit.
fn largest(extremal: &Extremal, inverse: &Matrix3, torque: &Vector3) -> f64 {
    match &extremal.law {
        TorqueLimit::Inputs(axes) => {
            let wanted = inverse * (torque - extremal.middle);
            axes.iter().map(|axis| axis.dot(&wanted).abs()).fold(0.0, f64::max)
        }
        TorqueLimit::Norm(limit) => (torque - extremal.middle).norm() / limit,
    }
}

/// Returns the momentum costate, in units of ε, at which the smoothed law produces a torque, at
/// least approximately.
fn costate(extremal: &Extremal, inverse: &Matrix3, torque: &Vector3, epsilon: f64) -> Vector3 {
    let switching = |v: f64| -v / (1.0 - v * v).max(1e-3).sqrt();
    match &extremal.law {
        TorqueLimit::Inputs(axes) => {
            let wanted = inverse * (torque - extremal.middle);
            let pairs = axes.iter().zip(&extremal.costs);
            let part =
                |(axis, cost): (&Vector3, &f64)| (switching(axis.dot(&wanted)) - cost / epsilon) * axis;
            inverse * pairs.map(part).sum::<Vector3>()
        }
        TorqueLimit::Norm(_) => {
            let wanted = torque.norm();
            if wanted == 0.0 {
                return Vector3::zeros();
            }
            let along = -torque / wanted;
            let given = |size: f64| {
                extremal.smooth(&(size * epsilon * along), epsilon, &Vector3::zeros()).torque.norm()
            };
            least(1.0, LARGEST_COSTATE, |size| given(size) >= wanted) * along
        }
    }
}

/// Returns the duration of the cubic path whose largest input is the fraction `level` of its limit;
/// `None` if the largest input exceeds this fraction for every duration.
fn duration_at(extremal: &Extremal, inverse: &Matrix3, turn: &Turn, level: f64) -> Option<f64> {
    let ends = [&extremal.start_rate, &extremal.end_rate];
    let loads = |duration: f64| {
        [0.0, 0.5, 1.0]
            .map(|u| turn.at(ends, duration, u).2)
            .map(|acceleration| largest(extremal, inverse, &(extremal.j * acceleration)))
            .into_iter()
            .fold(0.0, f64::max)
    };
    // Unequal one-sided thrusters need inputs even for zero torque.
    let level = level.max(largest(extremal, inverse, &Vector3::zeros()) + ABOVE_IDLE);
    let duration = least(1e-3, 1e9, |duration| loads(duration) <= level);
    (loads(duration) <= level).then_some(duration)
}

/// Returns the threshold above which `holds` is true: `first` is doubled until `holds` is true, up
/// to about `largest`; then the bracket is bisected.
fn least(first: f64, largest: f64, holds: impl Fn(f64) -> bool) -> f64 {
    let (mut low, mut high) = (0.0, first);
    while !holds(high) && high < largest {
        (low, high) = (high, 2.0 * high);
    }
    for _ in 0..HALVINGS {
        let middle = 0.5 * (low + high);
        if holds(middle) { high = middle } else { low = middle }
    }
    high
}

/// Creates the initial path of a turn. Its duration is the given one or, if the duration is free,
/// the one determined by the input level with index `try_index`.
fn guess(extremal: &Extremal, turn: &Turn, intervals: usize, try_index: usize) -> Option<Smoothed> {
    let inverse = extremal.authority().try_inverse()?;
    let start = extremal.start_rate;
    let (duration, mut epsilon) = match extremal.given_duration {
        Some(duration) => (duration, EASY[try_index]),
        None => (duration_at(extremal, &inverse, turn, levels(extremal)[try_index])?, 1.0),
    };
    let node = |k: usize| {
        let (r, rate, acceleration) =
            turn.at([&start, &extremal.end_rate], duration, k as f64 / intervals as f64);
        let e = costate(extremal, &inverse, &(extremal.j * acceleration), epsilon);
        Node { r, pi: extremal.j * rate, e }
    };
    let mut nodes: Vec<Node> = (0..=intervals).map(node).collect();
    nodes[0].pi = extremal.j * start;
    let e_rate = (nodes[intervals].e - nodes[0].e) / duration;
    let m = -(extremal.j * e_rate);
    if extremal.given_duration.is_none() {
        // The condition H(0) = p + ε (…) = 0 determines ε.
        let (first, w) = (nodes[0], start);
        let minimum = extremal.smooth(&first.e, 1.0, &Vector3::zeros()).minimum;
        let slope = m.dot(&w) + first.e.dot(&first.pi.cross(&w)) + minimum;
        epsilon = if slope < -0.1 { -extremal.time_price / slope } else { 2.0 };
    }
    for node in &mut nodes {
        node.e *= epsilon;
    }
    Some(Smoothed { path: Path::equal(epsilon * m, duration, nodes), epsilon })
}

/// Returns the input levels of the initial paths for a free duration, as fractions of the limits.
fn levels(extremal: &Extremal) -> &'static [f64] {
    if extremal.counts_fuel() { &LEVELS_FUEL } else { &LEVELS }
}

/// Solves for a smoothed extremal at the ε of `from`, with the path of `from` as the initial guess.
fn relaxed(extremal: &Extremal, from: &Smoothed, work: &Work) -> Option<Smoothed> {
    from.solved(extremal, RELAXED, FAR_ITERATIONS, work)
}

/// Continues the smoothed extremal `from` of the problem at homotopy parameter 0 to the problem at
/// 1. `carried` converts a path of one intermediate problem into an initial guess for the next one.
fn by_way_of(
    problems: impl Fn(f64) -> Option<Extremal>,
    from: Smoothed,
    carried: impl Fn(&mut Path, &Extremal, f64),
    work: &Work,
) -> Option<Smoothed> {
    let reached = follow(
        &HOMOTOPY,
        (from, 0.0_f64),
        |(_, part)| *part >= 1.0,
        |(at, part), step| {
            let next = (part + step).min(1.0);
            let solved = problems(next).and_then(|there| {
                let mut trial = at.clone();
                carried(&mut trial.path, &there, *part);
                relaxed(&there, &trial, work)
            });
            solved.map(|solved| (solved, next)).into()
        },
    );
    reached.ok().map(|(solved, _)| solved)
}

/// Returns whether the body rotates at the start or at the end.
fn moves(extremal: &Extremal) -> bool {
    extremal.start_rate.norm() + extremal.end_rate.norm() > 0.0
}

/// Returns the problem at homotopy parameter `s` between the isotropic body (0) and the actual one
/// (1), with the boundary rates multiplied by `rates`.
fn between(extremal: &Extremal, s: f64, rates: f64) -> Option<Extremal> {
    let eigen = extremal.j.symmetric_eigen();
    let powers = eigen.eigenvalues.map(|value| value.powf(s));
    let v = eigen.eigenvectors;
    extremal.with_inertia(v * Matrix3::from_diagonal(&powers) * v.transpose(), rates)
}

/// Continues an extremal of the isotropic body, optionally from zero boundary rates, to the body
/// itself.
fn through_bodies(
    extremal: &Extremal,
    turn: &Turn,
    intervals: usize,
    try_index: usize,
    rates: bool,
    work: &Work,
) -> Option<Smoothed> {
    let body = |s: f64| between(extremal, s, if rates { s } else { 1.0 });
    let sphere = body(0.0)?;
    let at = relaxed(&sphere, &guess(&sphere, turn, intervals, try_index)?, work)?;
    // The momenta scale with the inertia; rates and attitudes do not change.
    let carried = |path: &mut Path, there: &Extremal, part: f64| {
        let Some(here) = body(part) else { return };
        let change = there.j * here.j_inverse;
        for node in &mut path.nodes {
            node.pi = change * node.pi;
        }
        path.nodes[0].pi = there.j * there.start_rate;
    };
    by_way_of(body, at, carried, work)
}

/// Finds minimum-time smoothed extremals for a turn by first solving for given durations, which are
/// multiples of the duration of the initial path. The boundary rates are kept throughout or scaled
/// up from zero. This is used if the input levels fail, as for fast bodies whose gyroscopic torques
/// are comparable to the limits.
///
/// For a given duration and large ε, a smoothed extremal is nearly a minimum-effort one, which
/// cubic angles approximate; a longer duration leads to other paths.
pub(super) fn by_durations(extremal: &Extremal, turn: &Turn, intervals: usize, work: &Work) -> Vec<Smoothed> {
    let usual = extremal.authority().try_inverse();
    let Some(usual) = usual.and_then(|inverse| duration_at(extremal, &inverse, turn, LEVELS[0])) else {
        return Vec::new();
    };
    let scaled: &[bool] = if moves(extremal) { &[false, true] } else { &[false] };
    let each = DURATIONS.iter().flat_map(|part| scaled.iter().map(move |scaled| (part, *scaled)));
    let found = each.filter_map(|(part, rates)| {
        let given = extremal.lasting(Some(part * usual));
        let of_given = through_bodies(&given, turn, intervals, 0, rates, work)?;
        at_branching(extremal, sought(extremal, of_given, work)?, work)
    });
    found.collect()
}

/// Continues a smoothed extremal of a given duration to one of minimum time.
///
/// If costates and ε are multiplied by a common factor, the extremal remains one of that duration,
/// because inputs cost nothing except by smoothing. The factor is chosen for which the Hamiltonian
/// vanishes. If no such factor exists, because a longer duration would need more effort, the
/// duration is reduced.
fn sought(extremal: &Extremal, from: Smoothed, work: &Work) -> Option<Smoothed> {
    let shortest = NOTHING * from.path.duration;
    let mut found = scaled(extremal, &from, work);
    let ended = |at: &Smoothed| at.path.duration <= shortest;
    let _ = follow(&STRETCHING, from, ended, |at, length| {
        if found.is_some() {
            return Step::Stopped;
        }
        let mut shorter = at.clone();
        shorter.path.duration /= STRETCH.powf(length);
        let next = relaxed(&extremal.lasting(Some(shorter.path.duration)), &shorter, work);
        found = next.as_ref().and_then(|next| scaled(extremal, next, work));
        next.into()
    });
    found
}

/// Scales a smoothed extremal to minimum time without changing its duration first; `None` if no
/// positive factor exists or Newton fails.
fn scaled(extremal: &Extremal, at: &Smoothed, work: &Work) -> Option<Smoothed> {
    let end = at.path.nodes[at.path.intervals()];
    let minimum = extremal.smooth(&end.e, at.epsilon, &Vector3::zeros()).minimum;
    let price = extremal.time_price;
    let factor = price / (price - extremal.hamiltonian(&at.path.m, &end, minimum));
    if !(factor > 0.0 && factor.is_finite()) {
        return None;
    }
    let mut sought = at.clone();
    sought.epsilon *= factor;
    sought.path.m *= factor;
    for node in &mut sought.path.nodes {
        node.e *= factor;
    }
    relaxed(extremal, &sought, work)
}

/// Finds smoothed extremals for a turn, at the ε at which branches are distinguished.
///
/// The result has at most one extremal, or one for each successful initial path in three cases:
///
/// - Fuel counts and the duration is free.
/// - Thrusters have unequal strengths; some of their extremals are not near any single initial
///   path.
/// - `all` is true.
pub(super) fn bases(extremal: &Extremal, turn: &Turn, all: bool, work: &Work) -> Vec<Smoothed> {
    let sought_fuel = extremal.counts_fuel() && extremal.given_duration.is_none();
    let several = all || sought_fuel || extremal.middle != Vector3::zeros();
    let intervals = if several { INTERVALS } else { INTERVALS_NEAR };
    let tries = if extremal.given_duration.is_some() { EASY.len() } else { levels(extremal).len() };
    let mut found = Vec::new();
    for try_index in 0..tries {
        found.extend(base(extremal, turn, intervals, try_index, work));
        if !several && !found.is_empty() {
            break;
        }
    }
    // If none has been found, the caller tries all durations.
    if all && extremal.seeks_time() && !found.is_empty() {
        found.extend(by_durations(extremal, turn, intervals, work));
    }
    found
}

/// Finds the smoothed extremal to which one initial path of a turn leads, at the ε at which
/// branches are distinguished. `try_index` selects the initial path. Returns `None` if Newton or a
/// continuation fails.
fn base(
    extremal: &Extremal,
    turn: &Turn,
    intervals: usize,
    try_index: usize,
    work: &Work,
) -> Option<Smoothed> {
    let isotropic = (extremal.j - Matrix3::identity() * (extremal.j.trace() / 3.0)).amax() < 1e-9;
    let direct = |work: &Work| relaxed(extremal, &guess(extremal, turn, intervals, try_index)?, work);
    let found = if isotropic {
        direct(work)
    } else {
        through_bodies(extremal, turn, intervals, try_index, false, work).or_else(|| direct(work))
    }?;
    at_branching(extremal, found, work)
}

/// Refines an initial extremal to `INTERVALS` intervals and continues it to the smoothing parameter
/// ε = `BRANCHING`, at which branches are distinguished. Returns `None` if the continuation fails.
fn at_branching(extremal: &Extremal, mut found: Smoothed, work: &Work) -> Option<Smoothed> {
    while found.path.intervals() < INTERVALS {
        found.path = Smooth::of(extremal, found.epsilon).doubled(&found.path);
    }
    descend(extremal, &found, BRANCHING.min(found.epsilon), &Bias::default(), work).ok()
}
