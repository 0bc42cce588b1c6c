//! Smoothed extremals by a lifted Newton method.
//!
//! The unknowns are the costates at the start `M`, `e_0`, the duration, and all nodes. A sweep
//! integrates every interval from its own node and returns the gaps between intervals. If Newton
//! continues from a path, a second sweep chains the derivatives with respect to the seven
//! parameters and the gaps, so that the whole Newton step is a 7×7 system. Along the maneuver only
//! derivatives grow, not errors of the motion.

use super::extremal::{Bias, Extremal, LawResponse};
use super::flow::{Course, FlowStages, Lanes, Node, UnitRows, taken};
use super::tuning::smooth::*;
use super::tuning::{NEAR_ITERATIONS, POINTS, SAME};
use super::work::{Work, count};
use crate::numerics::eight::{Eight, Number};
use crate::numerics::hermite::hermite;
use crate::numerics::tableau::FOURTH;
use crate::numerics::three::{Vector, apply, cross, splat};
use crate::numerics::widest::widest;
use crate::optimize::methods::continuation::follow;
use crate::{Vector3, lie};
use nalgebra::{SMatrix, SVector};

const TIME: usize = 6;
const GAP: usize = 7;

/// A path of the smoothed problem: its nodes, its duration and the costates at its start.
#[derive(Clone, Debug)]
pub(crate) struct Path {
    /// Attitude costate `M`, reference axes.
    pub m: Vector3,
    pub duration: f64,
    pub nodes: Vec<Node>,
    /// Time of each node as a fraction of the duration, from 0 to 1.
    pub parts: Vec<f64>,
}

/// Errors of a path: the residual of the seven equations, and as merit the norm of this residual
/// together with the gaps between intervals.
struct Misses {
    residual: SVector<f64, 7>,
    merit: f64,
}

/// Derivatives of the seven equations with respect to the parameters and to the gaps.
struct Answers {
    jacobian: SMatrix<f64, 7, 7>,
    carried: SVector<f64, 7>,
}

/// Buffers of a sweep, eight intervals at once: the stages that derivatives need, the gaps, and the
/// derivatives of the nodes.
#[derive(Default)]
struct SweptIntervals {
    stages: Vec<FlowStages<Eight, 4>>,
    gaps: Vec<[Vector<Eight>; 3]>,
    lanes: Vec<Lanes<8>>,
}

/// The smoothed problem at one ε, with an optional perturbation.
pub(crate) struct Smooth<'a> {
    pub extremal: &'a Extremal,
    pub epsilon: f64,
    pub bias: Bias,
}

impl Path {
    /// Creates a path whose nodes are equally spaced in time.
    pub fn equal(m: Vector3, duration: f64, nodes: Vec<Node>) -> Self {
        let intervals = nodes.len() - 1;
        let parts = (0..=intervals).map(|node| node as f64 / intervals as f64).collect();
        Self { m, duration, nodes, parts }
    }

    pub fn intervals(&self) -> usize {
        self.nodes.len() - 1
    }

    /// Converts an extremal of the time-reversed maneuver to one of `extremal`. The first node is
    /// set to the exact start, because the other extremal meets its end only within the residual,
    /// and Newton does not correct the start.
    pub fn reversed(&self, extremal: &Extremal) -> Self {
        let mut nodes: Vec<Node> = self.nodes.iter().rev().map(|node| node.reversed(extremal)).collect();
        nodes[0] = Node::at_start(extremal, nodes[0].e);
        Self {
            m: -extremal.end_attitude * self.m,
            duration: self.duration,
            nodes,
            parts: self.parts.iter().rev().map(|part| 1.0 - part).collect(),
        }
    }

    /// Returns the path flown `factor` times slower. The switching functions do not change, because
    /// their size is that of the price of fuel at any rate.
    pub fn slower(&self, factor: f64) -> Self {
        let nodes = self.nodes.iter().map(|node| Node { pi: node.pi / factor, ..*node }).collect();
        Self { m: self.m / factor, duration: factor * self.duration, nodes, parts: self.parts.clone() }
    }

    /// Returns the interval that contains the time `part` (fraction of the duration), and the
    /// position within the interval, from 0 to 1.
    pub fn interval_at(&self, part: f64) -> (usize, f64) {
        let last = self.intervals() - 1;
        let index = self.parts.partition_point(|begin| *begin <= part).saturating_sub(1).min(last);
        let [from, to] = [self.parts[index], self.parts[index + 1]];
        (index, ((part - from) / (to - from)).clamp(0.0, 1.0))
    }
}

impl<'a> Smooth<'a> {
    /// Creates the smoothed problem without a perturbation.
    pub fn of(extremal: &'a Extremal, epsilon: f64) -> Self {
        Self { extremal, epsilon, bias: Bias::default() }
    }

    /// Integrates every interval from its own node and returns the errors of the path. It computes
    /// no derivatives, because most trial paths are rejected. Returns `None` if the merit is not
    /// below `most`; usually the first intervals suffice to see this.
    fn sweep(&self, path: &Path, most: f64, swept: &mut SweptIntervals) -> Option<Misses> {
        let residual = self.residual(path);
        let at_end = residual.norm_squared();
        let gaps = widest(
            #[inline(always)]
            || self.eight_by_eight(path, most * most - at_end, swept),
        );
        let merit = (at_end + gaps).sqrt();
        (merit.is_finite() && merit < most).then_some(Misses { residual, merit })
    }

    /// Returns the residual of the seven equations: six terminal conditions and the condition on
    /// the duration.
    fn residual(&self, path: &Path) -> SVector<f64, 7> {
        let extremal = self.extremal;
        let end = path.nodes[path.intervals()];
        // The seventh equation: the duration has its given value or, if it is free, the Hamiltonian
        // is zero.
        let last = match extremal.given_duration {
            Some(given) => path.duration - given,
            None => extremal.hamiltonian(&path.m, &end, self.at_end(&end).minimum),
        };
        extremal.miss(&end).push(last)
    }

    /// Returns the derivatives of the seven equations, for the path of the last sweep.
    fn answers(&self, path: &Path, swept: &mut SweptIntervals) -> Answers {
        widest(
            #[inline(always)]
            || self.carry(path, swept),
        );
        self.at_the_end(path, &swept.lanes[path.intervals()])
    }

    fn at_end(&self, end: &Node) -> LawResponse {
        self.extremal.smooth(&end.e, self.epsilon, &self.bias.at(1.0))
    }

    /// Returns the control law as a function of the position within an interval, from 0 to 1.
    /// `from` and `to` are the start and the end of the interval, as fractions of the duration.
    #[inline(always)]
    fn law<T: Number>(&self, [from, to]: [T; 2]) -> impl Fn(f64, &Vector<T>) -> LawResponse<T> {
        #[inline(always)]
        move |fraction, e| {
            let bias = self.bias.at(from + T::of(fraction) * (to - from));
            self.extremal.smooth(e, self.epsilon, &bias)
        }
    }

    /// Computes the gaps between intervals by the fourth-order method, eight intervals at once, and
    /// returns the sum of their squares. It stops when the sum reaches `most`.
    #[inline(always)]
    fn eight_by_eight(&self, path: &Path, most: f64, swept: &mut SweptIntervals) -> f64 {
        let n = path.intervals();
        let batches = n.div_ceil(Eight::LANES);
        swept.stages.resize_with(batches, FlowStages::empty);
        swept.gaps.resize(batches, [splat(&Vector3::zeros()); 3]);
        let course = Course::of(self.extremal, &path.m);
        let duration = Eight::of(path.duration);
        let mut gaps = 0.0;
        for (batch, (stages, gap)) in swept.stages.iter_mut().zip(&mut swept.gaps).enumerate() {
            let first = batch * Eight::LANES;
            // If fewer than eight intervals are left, the last one fills the remaining lanes.
            let interval = |lane: usize| (first + lane).min(n - 1);
            let from = Node::of(|lane| &path.nodes[interval(lane)]);
            let to = Node::of(|lane| &path.nodes[interval(lane) + 1]);
            let stretch = [0, 1].map(|end| Eight::from_fn(|lane| path.parts[interval(lane) + end]));
            let length = (stretch[1] - stretch[0]) * duration;
            *gap = course.step(&FOURTH, &from, length, self.law(stretch), stages).minus(&to);
            for lane in 0..Eight::LANES.min(n - first) {
                gaps +=
                    taken(gap, |number| number.0[lane]).iter().map(|part| part.norm_squared()).sum::<f64>();
            }
            if gaps >= most {
                break;
            }
        }
        gaps
    }

    /// Chains the derivatives of the nodes, one interval after the other.
    #[inline(always)]
    fn carry(&self, path: &Path, swept: &mut SweptIntervals) {
        let n = path.intervals();
        let units = UnitRows::new();
        swept.lanes.resize(n + 1, Lanes::zero());
        swept.lanes[0] = Lanes::of_costate();
        for k in 0..n {
            let (batch, lane) = (k / Eight::LANES, k % Eight::LANES);
            let length = (path.parts[k + 1] - path.parts[k]) * path.duration;
            let stretched = Some((TIME, path.duration));
            let gap = taken(&swept.gaps[batch], |number| number.0[lane]);
            let carried =
                swept.stages[batch]
                    .carry_on(length, &swept.lanes[k], stretched, &units, |number| number.0[lane]);
            swept.lanes[k + 1] = carried.with(GAP, &gap, &units);
        }
    }

    /// Returns the derivatives of the seven equations, from the derivatives `lanes` of the last
    /// node.
    fn at_the_end(&self, path: &Path, lanes: &Lanes<8>) -> Answers {
        let end = path.nodes[path.intervals()];
        let extremal = self.extremal;
        let jacobian_of_log =
            lie::left_jacobian_inverse(&extremal.miss(&end).fixed_rows::<3>(0).into_owned());
        let [w, pi_dot, e_dot] = extremal.rate(&path.m, &end, &self.at_end(&end).torque);
        let mut columns = [SVector::<f64, 7>::zeros(); 8];
        for (lane, column) in columns.iter_mut().enumerate() {
            let (eta, pi, e) = (lanes.block(0, lane), lanes.block(1, lane), lanes.block(2, lane));
            let unit = if lane < 3 { Vector3::ith(lane, 1.0) } else { Vector3::zeros() };
            let h = match extremal.given_duration {
                Some(_) => f64::from(lane == TIME),
                None => pi_dot.dot(&e) - e_dot.dot(&pi) + w.dot(&(unit + cross(&path.m, &eta))),
            };
            let eta = apply(&jacobian_of_log, &eta);
            *column = SVector::from([eta.x, eta.y, eta.z, pi.x, pi.y, pi.z, h]);
        }
        let [m_x, m_y, m_z, e_x, e_y, e_z, time, carried] = columns;
        Answers { jacobian: SMatrix::from_columns(&[m_x, m_y, m_z, e_x, e_y, e_z, time]), carried }
    }

    /// Iterates Newton's method from `path` until the merit is below `tolerance`. Returns `None` if
    /// it does not converge within `most` iterations or is stopped.
    pub fn solve(&self, mut path: Path, tolerance: f64, most: usize, work: &Work) -> Option<Path> {
        if work.stopped() {
            return None;
        }
        count(&work.sweeps);
        let mut swept = SweptIntervals::default();
        let mut misses = self.sweep(&path, f64::INFINITY, &mut swept)?;
        for _ in 0..most {
            if misses.merit <= tolerance {
                return Some(path);
            }
            let Answers { jacobian, carried } = self.answers(&path, &mut swept);
            let step = jacobian.lu().solve(&-(misses.residual + carried))?;
            if !step.iter().all(|value| value.is_finite()) {
                return None;
            }
            let costate = (path.m.norm_squared() + path.nodes[0].e.norm_squared()).sqrt();
            let length = step.fixed_rows::<6>(0).norm();
            let factor = (costate / length).min(TIME_STEP * path.duration / step[TIME].abs());
            let changes = changes(&swept.lanes, &step);
            let mut factors = std::iter::successors(Some(factor.min(1.0)), |factor| Some(SHORTENED * factor))
                .take(MOST_TRIALS);
            (path, misses) = factors.find_map(|factor| {
                count(&work.sweeps);
                let trial = moved(&path, &changes, &step, factor);
                let most = (1.0 - DECREASE * factor) * misses.merit;
                let next = self.sweep(&trial, most, &mut swept)?;
                Some((trial, next))
            })?;
        }
        (misses.merit <= tolerance).then_some(path)
    }

    /// Returns the path with every interval halved.
    pub fn doubled(&self, path: &Path) -> Path {
        self.divided(path, |_, _, _, depth| depth == 0)
    }

    /// Returns the number of uniform intervals that suffices for this ε.
    fn wanted(&self) -> usize {
        (RESOLVED / self.epsilon) as usize
    }

    /// Returns the tolerance of the residual for an extremal in a continuation to smaller ε.
    pub fn tolerance(&self) -> f64 {
        (ON_THE_WAY * self.epsilon).clamp(ON_THE_WAY_WITHIN.0, ON_THE_WAY_WITHIN.1)
    }

    /// Solves by Newton, then refines the intervals by the rule `intervals` and solves again, until
    /// no interval needs to be refined.
    fn refined(&self, path: Path, intervals: Intervals, tolerance: f64, work: &Work) -> Option<Path> {
        let mut path = self.solve(path, tolerance, NEAR_ITERATIONS, work)?;
        while let Some(finer) = match intervals {
            _ if path.intervals() >= self.wanted() && intervals != Intervals::Close => None,
            Intervals::Equal => (2 * path.intervals() <= MOST_INTERVALS).then(|| self.doubled(&path)),
            Intervals::Following | Intervals::Close => self.finer(&path),
        } {
            path = self.solve(finer, tolerance, NEAR_ITERATIONS, work)?;
        }
        Some(path)
    }

    /// Returns the path on a finer grid; `None` if its grid is fine enough or would become too
    /// large. Intervals are halved if there are too few of them, or if an input changes on one by
    /// more than [`RESOLVED`] of its range.
    fn finer(&self, path: &Path) -> Option<Path> {
        let fuel = self.extremal.counts_fuel();
        let few = path.intervals() < if fuel { ENOUGH } else { ENOUGH.min(self.wanted()) };
        let inputs = self.extremal.switching_count();
        let level = |input: usize, e: &Vector3| self.extremal.level(input, e, self.epsilon);
        let change = |from: &Vector3, to: &Vector3| {
            let changes = (0..inputs).map(|input| (level(input, to) - level(input, from)).abs());
            changes.fold(0.0, f64::max)
        };
        let finer = self.divided(path, |from, to, length, depth| {
            // A pulse of fuel may begin and end between two nodes.
            let within = || {
                fuel && self.within(&path.m, from, to, length).any(|e| change(&from.e, &e) > 2.0 * RESOLVED)
            };
            few && depth == 0 || depth < DEEPEST && (change(&from.e, &to.e) > 2.0 * RESOLVED || within())
        });
        (finer.intervals() > path.intervals() && finer.intervals() <= MOST_INTERVALS).then_some(finer)
    }

    /// Returns the momentum costate `e` at interpolated points between two nodes.
    fn within(&self, m: &Vector3, from: &Node, to: &Node, length: f64) -> impl Iterator<Item = Vector3> {
        let law = |e: &Vector3| self.extremal.smooth(e, self.epsilon, &Vector3::zeros());
        let rate = |node: &Node| self.extremal.rate(m, node, &law(&node.e).torque)[2];
        let (rates, ends) = ([rate(from), rate(to)], [from.e, to.e]);
        (1..POINTS).map(move |point| {
            let x = point as f64 / POINTS as f64;
            hermite(x, length, [&ends[0], &ends[1]], [&rates[0], &rates[1]])
        })
    }

    /// Returns the path with intervals bisected repeatedly while `divide` is true. The arguments of
    /// `divide` are the nodes at both ends of an interval, its duration and the number of
    /// bisections that led to it.
    fn divided(&self, path: &Path, divide: impl Fn(&Node, &Node, f64, usize) -> bool) -> Path {
        let (course, mut stages) = (Course::of(self.extremal, &path.m), FlowStages::empty());
        let (mut nodes, mut parts) = (vec![path.nodes[0]], vec![0.0]);
        for k in 0..path.intervals() {
            // Pieces of the interval that remain to be examined, the earliest one last.
            let mut ahead = vec![(path.nodes[k + 1], path.parts[k + 1], 0)];
            while let Some((to, end, depth)) = ahead.pop() {
                let (from, begin) = (nodes[nodes.len() - 1], parts[parts.len() - 1]);
                if divide(&from, &to, (end - begin) * path.duration, depth) {
                    let half = 0.5 * (begin + end);
                    let length = (half - begin) * path.duration;
                    let middle = course.step(&FOURTH, &from, length, self.law([begin, half]), &mut stages);
                    ahead.extend([(to, end, depth + 1), (middle, half, depth + 1)]);
                } else {
                    nodes.push(to);
                    parts.push(end);
                }
            }
        }
        Path { nodes, parts, ..path.clone() }
    }
}

/// Returns the changes of the nodes for a step of the parameters that also closes the gaps.
fn changes(lanes: &[Lanes<8>], step: &SVector<f64, 7>) -> Vec<[Vector3; 3]> {
    let mut change = [0.0; 8];
    change[..7].copy_from_slice(step.as_slice());
    change[GAP] = 1.0;
    widest(
        #[inline(always)]
        || {
            let mut changes = Vec::with_capacity(lanes.len());
            for lanes in lanes {
                changes.push(lanes.folded(&change));
            }
            changes
        },
    )
}

fn moved(path: &Path, changes: &[[Vector3; 3]], step: &SVector<f64, 7>, factor: f64) -> Path {
    Path {
        m: path.m + factor * step.fixed_rows::<3>(0),
        duration: path.duration + factor * step[TIME],
        nodes: path.nodes.iter().zip(changes).map(|(node, change)| node.plus(change, factor)).collect(),
        parts: path.parts.clone(),
    }
}

/// A smoothed extremal: a path and its ε.
#[derive(Clone, Debug)]
pub(crate) struct Smoothed {
    pub path: Path,
    pub epsilon: f64,
}

impl Smoothed {
    /// Solves for an extremal of the maneuver `extremal` at the ε of this one, which is the initial
    /// guess. Returns `None` if Newton does not converge to `tolerance` within `most` iterations.
    pub fn solved(&self, extremal: &Extremal, tolerance: f64, most: usize, work: &Work) -> Option<Self> {
        let path = Smooth::of(extremal, self.epsilon).solve(self.path.clone(), tolerance, most, work)?;
        Some(Self { path, ..*self })
    }

    /// Returns the gap: to first order, the cost that could still be saved. It is the integral over
    /// time of `e·τ + Σ c_j v_j` minus the minimum of this sum over the inputs.
    pub fn gap(&self, extremal: &Extremal) -> f64 {
        let of =
            |node: &Node, law: &LawResponse| node.e.dot(&law.torque) + law.running - extremal.least(&node.e);
        self.integral(extremal, of)
    }

    /// Returns the cost without the smoothing term; proportional to the duration if only time
    /// counts.
    pub fn cost(&self, extremal: &Extremal) -> f64 {
        if !extremal.counts_fuel() {
            return extremal.time_price * self.path.duration;
        }
        self.integral(extremal, |_, law| extremal.time_price + law.running)
    }

    /// Integrates over the duration with cubic interpolation of the costate between nodes, because
    /// an input may switch from one limit to the other between two nodes.
    fn integral(&self, extremal: &Extremal, integrand: impl Fn(&Node, &LawResponse) -> f64) -> f64 {
        let (none, path) = (Vector3::zeros(), &self.path);
        let law = |e: &Vector3| extremal.smooth(e, self.epsilon, &none);
        let rate = |node: &Node| extremal.rate(&path.m, node, &law(&node.e).torque)[2];
        let rates: Vec<Vector3> = path.nodes.iter().map(rate).collect();
        let mut sum = 0.0;
        for k in 0..path.intervals() {
            let part = path.parts[k + 1] - path.parts[k];
            let (nodes, rates) = ([&path.nodes[k].e, &path.nodes[k + 1].e], [&rates[k], &rates[k + 1]]);
            for point in 0..POINTS {
                let x = (point as f64 + 0.5) / POINTS as f64;
                let e = hermite(x, part * path.duration, nodes, rates);
                sum += part / POINTS as f64 * integrand(&Node { e, ..path.nodes[k] }, &law(&e));
            }
        }
        sum * path.duration
    }
}

/// Solves for an extremal to round-off, at `target` or the nearest ε that converges, on intervals
/// that resolve every change of the inputs.
pub(crate) fn settle(extremal: &Extremal, from: Smoothed, target: f64, work: &Work) -> Smoothed {
    let mut at = from;
    let mut epsilon = at.epsilon;
    loop {
        let smooth = Smooth::of(extremal, epsilon);
        let Some(path) = smooth.refined(at.path.clone(), Intervals::Close, SAME, work) else { return at };
        at = Smoothed { path, epsilon };
        if epsilon <= target {
            return at;
        }
        epsilon = (SETTLING * epsilon).max(target);
    }
}

/// Continues an extremal from its ε to `target`; the error holds the last extremal that converged.
/// Coarse intervals suffice for the intermediate ε. Minimum-fuel problems use a uniform grid,
/// because pulses are extracted from the path and some appear only where their switching function
/// grazes zero.
pub(crate) fn descend(
    extremal: &Extremal,
    from: &Smoothed,
    target: f64,
    bias: &Bias,
    work: &Work,
) -> Result<Smoothed, Smoothed> {
    let intervals = if extremal.counts_fuel() { Intervals::Equal } else { Intervals::Following };
    descend_by(RATIO, intervals, extremal, from, target, bias, work)
}

/// Rule by which the intervals of a path are refined during a continuation.
#[derive(Clone, Copy, PartialEq)]
pub(crate) enum Intervals {
    /// Intervals of equal length.
    Equal,
    /// Intervals that resolve the changes of the inputs, up to a sufficient total number.
    Following,
    /// Intervals that resolve every change of the inputs.
    Close,
}

/// Continues as `descend` with this ratio of consecutive ε and this rule for intervals. With fewer
/// values of ε Newton takes more iterations for each, but fewer in total.
pub(crate) fn descend_by(
    ratio: f64,
    intervals: Intervals,
    extremal: &Extremal,
    from: &Smoothed,
    target: f64,
    bias: &Bias,
    work: &Work,
) -> Result<Smoothed, Smoothed> {
    let arrived = |at: &Smoothed| at.epsilon <= target * (1.0 + SAME);
    follow(&DESCENT, from.clone(), arrived, |at, length| {
        let epsilon = (ratio.powf(length) * at.epsilon).max(target);
        let smooth = Smooth { bias: *bias, ..Smooth::of(extremal, epsilon) };
        let path = smooth.refined(at.path.clone(), intervals, smooth.tolerance(), work);
        path.map(|path| Smoothed { path, epsilon }).into()
    })
}
