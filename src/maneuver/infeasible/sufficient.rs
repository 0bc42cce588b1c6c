//! A sufficient duration: the duration of a turn about a fixed axis within the limits, from rest to
//! rest.
//!
//! On the path `R = R_0 exp(θ S(e))` the inputs u, and the momenta h of wheels, are
//!
//! ```text
//! u = W (Je θ̈ + e×Je θ̇²)                        without wheels
//! u = W (Je θ̈ + e×μ θ̇) ,   h = h_0 + W (μ − μ_0) − W Je θ̇ ,   μ = exp(−θ S(e)) μ_0      with wheels
//! ```
//!
//! where W is a right inverse of the axes B, `B W v = v`: the inverse that needs the smallest part
//! of the limits along `Je`. The turn accelerates at a constant acceleration, continues at a
//! constant rate, and decelerates. If torque rates are limited, the acceleration changes at a
//! constant rate. Each limit is checked with the largest value of each of its terms, as if all
//! terms were largest at the same time. Cones are checked along the whole path, at the times at
//! which the body passes.

use super::capability::{fastest, isolated, standing};
use super::outputs::Outputs;
use crate::maneuver::constraint::{Arc, Rule, on_arc};
use crate::maneuver::problem::{EndCondition, Motion, Path, Problem};
use crate::mechanics::actuators::AxisFrame;
use crate::numerics::figures::rounded_up;
use crate::{Vector3, lie};
use nalgebra::{DMatrix, DVector};
use std::f64::consts::TAU;

/// The factor on the duration of the quickest turn about the axis. This margin is needed because
/// plans hold inputs over steps, and because the search starts from other paths. A larger factor
/// reports a longer duration; a smaller factor reports a duration that is harder to plan.
const STRETCH: f64 = 1.08;

/// The additional duration for jumps of the torque, in steps: three jumps of the acceleration, each
/// within one step.
const PER_STEP: f64 = 3.0;

/// Number of points of the path at which momenta and cones are checked.
const POINTS: usize = 200;

/// Number of parts of the angle over which the rate of a turn is integrated. More parts take longer;
/// the error is of the order of the inverse square.
const PARTS: usize = 1000;

/// The factor from one tried rate or acceleration to the next, and the numbers of tried rates and
/// accelerations.
const FINER: f64 = 0.96;
const RATES: i32 = 120;
const ACCELERATIONS: i32 = 60;

/// The largest acceleration that is tried if torques have no limit, as a multiple of the squared
/// rate over the angle.
const BRISK: f64 = 30.0;

/// The relative error of a produced torque above which the inputs count as unable to produce it.
const UNREACHED: f64 = 1e-7;

/// Required margin to a cone \[rad\], for the deviation of a plan from the checked path.
const ROOM: f64 = 1e-3;

/// Returns a duration \[s\], rounded up to four digits and longer than the duration of the problem,
/// in which a turn about a fixed axis is a plan. Returns `None` if no such duration is known: if an
/// end is not at rest, in a field, for a body that translates, for thrusters, or if a constraint
/// forbids the turn.
pub(crate) fn sufficient(problem: &Problem) -> Option<f64> {
    let turns = turns(problem).filter_map(|turn| turn.duration());
    turns.reduce(f64::min).map(rounded_up).filter(|duration| *duration > problem.seconds())
}

/// Returns the duration \[s\] of a turn about a fixed axis from the start to the end of a maneuver:
/// it accelerates, continues at a constant rate, and decelerates, as fast as the limits on torques,
/// rates and wheels allow. The turn is feasible, so a minimum-time plan is
/// not longer. Cones are ignored. Returns `None` if an end is not at rest, in a field, for a body
/// that translates, for one-sided inputs, and if no input limits the duration.
pub fn fixed_axis_duration(problem: &Problem) -> Option<f64> {
    let durations = turns(problem).filter_map(|turn| {
        let steady = turn.quickest()?.duration(turn.angle);
        Some(turn.swept().map_or(steady, |swept| swept.min(steady)))
    });
    durations.reduce(f64::min)
}

/// Returns the turns about a fixed axis that the chosen homotopy class allows; none for a maneuver
/// that they do not describe.
fn turns(problem: &Problem) -> impl Iterator<Item = Turn<'_>> {
    let torque = &problem.actuation.torque;
    let rests = [&problem.start, &problem.end].iter().all(|end| end.angular_velocity == Vector3::zeros());
    let plain = problem.motion == Motion::Attitude
        && problem.end_condition == EndCondition::State
        && problem.actuation.thrusters.is_none()
        && !torque.limits().one_sided
        && problem.shortest_pulse().is_none()
        && problem.alternatives.is_empty()
        && !(problem.actuation.wheels.is_some() && torque.limits().rate.is_some())
        && torque.frame() == AxisFrame::Body;
    let described = plain && rests && isolated(problem) && standing(problem);
    let ways = if described { ways(problem) } else { Vec::new() };
    ways.into_iter().filter_map(|way| Turn::new(problem, &way))
}

/// Returns the rotation vectors that the chosen homotopy class allows, in the body axes of the
/// start.
fn ways(problem: &Problem) -> Vec<Vector3> {
    let short = lie::minus(&problem.end.attitude, &problem.start.attitude);
    let angle = short.norm();
    let long = || (angle > 0.0).then(|| short * (1.0 - TAU / angle));
    match problem.path {
        Path::Shortest => vec![short],
        Path::Long => long().into_iter().collect(),
        Path::Best => [short].into_iter().chain(long()).collect(),
        Path::AsGiven(way) => vec![way],
    }
}

/// A turn about a fixed axis.
struct Turn<'a> {
    problem: &'a Problem,
    axis: Vector3,
    angle: f64,
    /// Largest terms of each input, per unit of θ̈, of θ̇ and of θ̇².
    inputs: [Vec<f64>; 3],
    /// Inputs per unit of θ̈ and of θ̇², with their signs; the second ones are zero with wheels.
    signed: [Vec<f64>; 2],
    /// Largest terms of the torque, per unit of θ̈, of θ̇ and of θ̇².
    torque: [f64; 3],
    /// The largest rate that rate limits and the momenta of wheels allow \[rad/s\].
    fastest: f64,
}

/// The largest rate, acceleration and rate of change of the acceleration [rad/s, rad/s², rad/s³].
#[derive(Clone, Copy)]
struct Course {
    rate: f64,
    acceleration: f64,
    slope: f64,
}

impl Course {
    /// Returns the time of the acceleration to the full rate \[s\].
    fn rise(&self) -> f64 {
        self.rate / self.acceleration + self.acceleration / self.slope
    }

    fn duration(&self, angle: f64) -> f64 {
        angle / self.rate + self.rise()
    }

    /// Returns the angle after `time` \[s\] of a turn by `angle`.
    fn angle_at(&self, time: f64, angle: f64) -> f64 {
        let (rise, end) = (self.rise(), self.duration(angle));
        let ramp = self.acceleration / self.slope;
        // The angle since the start of the acceleration. The whole acceleration turns the body by
        // half of the angle at the full rate.
        let rising = |time: f64| {
            let [whole, first, second, last] =
                [0.0, ramp, rise - ramp, rise].map(|from| (time - from).max(0.0));
            let cubic = |time: f64| time.powi(3) / 6.0;
            if ramp > 0.0 {
                self.slope * (cubic(whole) - cubic(first) - cubic(second) + cubic(last))
            } else {
                0.5 * self.acceleration * (whole.powi(2) - last.powi(2))
            }
        };
        if time < end - rise { rising(time) } else { angle - rising((end - time).max(0.0)) }
    }
}

impl<'a> Turn<'a> {
    fn new(problem: &'a Problem, way: &Vector3) -> Option<Self> {
        let (angle, axis) = (way.norm(), way.try_normalize(0.0)?);
        let (set, limits) = (&problem.actuation.torque, problem.actuation.torque.limits());
        let wheels = problem.actuation.wheels.as_ref();
        let along = problem.body.inertia.j() * axis;
        let sizes = limits.size.as_deref().or(wheels.map(|wheels| &wheels.momentum_limit[..]));
        let sizes: Vec<f64> = (0..set.count())
            .map(|input| sizes.map_or(1.0, |sizes| if sizes[input].is_finite() { sizes[input] } else { 1.0 }))
            .collect();
        let inverse = Inverse::new(set.axes(), &sizes, &along)?;
        let largest = |values: Vec<DVector<f64>>| -> Vec<f64> {
            let of_input = |input: usize| values.iter().fold(0.0, |most: f64, v| most.max(v[input].abs()));
            (0..set.count()).map(of_input).collect()
        };
        let per_acceleration = inverse.of(&along)?;
        let stored = problem.actuation.stored_momentum();
        let points = || (0..=POINTS).map(|point| angle * point as f64 / POINTS as f64);
        let held = |at: f64| lie::exp(&(axis * -at)) * stored;
        let none = || vec![0.0; set.count()];
        let (per_rate, of_square, sideways) = match wheels {
            Some(_) => {
                let terms: Option<Vec<_>> = points().map(|at| inverse.of(&axis.cross(&held(at)))).collect();
                (largest(terms?), none(), [axis.cross(&stored).norm(), 0.0])
            }
            None => {
                let bent = axis.cross(&along);
                (none(), Vec::from(inverse.of(&bent)?.as_slice()), [0.0, bent.norm()])
            }
        };
        let per_square = of_square.iter().map(|input| input.abs()).collect();
        let rules = problem.constraints.iter().filter_map(|constraint| match &constraint.rule {
            Rule::RateAxes(limits) => (0..3).map(|i| limits[i] / axis[i].abs()).reduce(f64::min),
            Rule::RateNorm(limit) => Some(*limit),
            Rule::Pointing(_) => None,
        });
        let mut rate = rules.fold(f64::INFINITY, f64::min).min(fastest(problem, None));
        if let Some(wheels) = wheels {
            for at in points() {
                let moved = inverse.of(&(held(at) - stored))?;
                for (input, limit) in wheels.momentum_limit.iter().enumerate() {
                    let left = limit - (wheels.momentum[input] + moved[input]).abs();
                    if left <= 0.0 {
                        return None;
                    }
                    rate = rate.min(left / per_acceleration[input].abs());
                }
            }
        }
        let [across, bent] = sideways;
        Some(Self {
            problem,
            axis,
            angle,
            signed: [Vec::from(per_acceleration.as_slice()), of_square],
            inputs: [largest(vec![per_acceleration]), per_rate, per_square],
            torque: [along.norm(), across, bent],
            fastest: rate,
        })
    }

    /// Returns the duration \[s\] with its margin; `None` if no rate leaves an acceleration, or if
    /// a constraint is in the way.
    fn duration(&self) -> Option<f64> {
        let best = self.quickest()?;
        let stretch = STRETCH + PER_STEP / self.problem.steps as f64;
        let stretched = Course {
            rate: best.rate / stretch,
            acceleration: best.acceleration / stretch.powi(2),
            slope: best.slope / stretch.powi(3),
        };
        self.is_clear(&stretched).then(|| stretched.duration(self.angle))
    }

    /// Returns the course of the shortest duration; `None` if no rate leaves an acceleration.
    fn quickest(&self) -> Option<Course> {
        let at_rest = self.acceleration(0.0);
        // The turn is no faster than with the acceleration at rest, and its rate of change at rest,
        // all along.
        let quickest = self
            .fastest
            .min((self.angle * at_rest).sqrt())
            .min((self.angle.powi(2) * self.slope(0.0, 0.0)).cbrt());
        if !(quickest.is_finite() && quickest > 0.0) {
            return None;
        }
        let rates = (0..RATES).map(|power| quickest * FINER.powi(power));
        let time = |course: &Course| course.duration(self.angle);
        rates.flat_map(|rate| self.courses(rate)).min_by(|a, b| time(a).total_cmp(&time(b)))
    }

    /// Returns the duration \[s\] of the turn whose acceleration is as large as the limits allow at
    /// each rate; `None` if torque rates are limited.
    ///
    /// With `p = θ̇²/2` the limits bound `dp/dθ = θ̈`, from above during acceleration and from below
    /// during deceleration.
    fn swept(&self) -> Option<f64> {
        if self.problem.actuation.torque.limits().rate.is_some() {
            return None;
        }
        let (step, most) = (self.angle / PARTS as f64, 0.5 * self.fastest * self.fastest);
        let grown = |side: f64| -> Option<Vec<f64>> {
            let slope = |p: f64| self.largest(p, side).max(0.0);
            let mut p = vec![0.0];
            for _ in 0..PARTS {
                let at = p[p.len() - 1];
                let middle = at + 0.5 * step * slope(at);
                p.push((at + step * slope(middle)).min(most));
            }
            (p[1] > 0.0).then_some(p)
        };
        let (up, down) = (grown(1.0)?, grown(-1.0)?);
        let rate = |index: usize| (2.0 * up[index].min(down[PARTS - index])).sqrt();
        Some((0..PARTS).map(|index| 2.0 * step / (rate(index) + rate(index + 1))).sum())
    }

    /// Returns the largest acceleration (`side = 1`) or deceleration (`side = −1`) that the limits of
    /// the inputs leave at `p = θ̇²/2`; negative if they leave none.
    fn largest(&self, p: f64, side: f64) -> f64 {
        let (square, rate) = (2.0 * p, (2.0 * p).sqrt());
        let limits = self.problem.actuation.torque.limits();
        let mut most = f64::INFINITY;
        for (input, limit) in limits.size.iter().flatten().enumerate() {
            let [along, bent] = [0, 1].map(|term| self.signed[term][input]);
            let room = limit - rate * self.inputs[1][input];
            most = most.min((room - (side * along).signum() * square * bent) / along.abs());
        }
        if let Some(norm) = limits.norm {
            let [along, across, bent] = self.torque;
            let left = (norm * norm - (square * bent).powi(2)).max(0.0).sqrt() - rate * across;
            most = most.min(left / along);
        }
        if most.is_finite() { most } else { 0.0 }
    }

    /// Returns the largest acceleration that the limits of the inputs leave at a rate.
    fn acceleration(&self, rate: f64) -> f64 {
        let limits = self.problem.actuation.torque.limits();
        let mut most = f64::INFINITY;
        for (input, limit) in limits.size.iter().flatten().enumerate() {
            let [first, second, third] = [0, 1, 2].map(|term| self.inputs[term][input]);
            most = most.min((limit - rate * second - rate * rate * third) / first);
        }
        if let Some(norm) = limits.norm {
            let [first, second, third] = self.torque;
            // The gyroscopic torque is normal to the torque that accelerates the body.
            let left = (norm * norm - (rate * rate * third).powi(2)).max(0.0).sqrt() - rate * second;
            most = most.min(left / first);
        }
        most
    }

    /// Returns the largest rate of change of the acceleration that the limits of torque rates
    /// leave.
    fn slope(&self, rate: f64, acceleration: f64) -> f64 {
        let limits = self.problem.actuation.torque.limits().rate.iter().flatten().enumerate();
        limits.fold(f64::INFINITY, |least, (input, limit)| {
            let [first, _, third] = [0, 1, 2].map(|term| self.inputs[term][input]);
            least.min((limit - 2.0 * rate * acceleration * third) / first)
        })
    }

    /// Returns courses that reach a rate, or a lower rate if the angle is too small for this rate.
    fn courses(&self, rate: f64) -> impl Iterator<Item = Course> {
        let most = self.acceleration(rate).min(BRISK * rate * rate / self.angle);
        let count = if self.slope(0.0, 0.0).is_finite() { ACCELERATIONS } else { 1 };
        (0..count).filter_map(move |power| {
            let acceleration = most * FINER.powi(power);
            let slope = self.slope(rate, acceleration);
            if !(acceleration > 0.0 && slope > 0.0) {
                return None;
            }
            // rate (rate/acceleration + acceleration/slope) = angle
            let ramp = acceleration / slope;
            let reached =
                0.5 * acceleration * ((ramp * ramp + 4.0 * self.angle / acceleration).sqrt() - ramp);
            let course = Course { rate: rate.min(reached), acceleration, slope };
            (course.rate >= acceleration * ramp).then_some(course)
        })
    }

    /// Returns whether the path satisfies every cone.
    fn is_clear(&self, course: &Course) -> bool {
        let step = course.duration(self.angle) / POINTS as f64;
        let frame_rate = Vector3::zeros();
        let attitude =
            |at: f64| self.problem.start.attitude * lie::exp(&(self.axis * course.angle_at(at, self.angle)));
        (0..POINTS).all(|piece| {
            let time = step * piece as f64;
            let (start, end) = (attitude(time), attitude(time + step));
            let arc = Arc { start, turn: lie::minus(&end, &start) };
            self.problem.constraints.iter().all(|constraint| {
                let Rule::Pointing(pointing) = &constraint.rule else { return true };
                // Both ends satisfy the cones without an additional margin.
                let ends = piece == 0 || piece + 1 == POINTS;
                pointing.pairs().all(|(boresight, direction)| {
                    let target = on_arc(direction, time, step, &frame_rate);
                    let least = pointing.least_room(&arc, boresight, &target, [time, step]);
                    least.is_none_or(|(_, room)| room >= if ends { 0.0 } else { ROOM })
                })
            })
        })
    }
}

/// A right inverse of the matrix of the input axes.
struct Inverse<'a> {
    axes: &'a [Vector3],
    /// Inputs per unit of torque, by least squares of the inputs relative to their limits.
    by_squares: DMatrix<f64>,
    along: Vector3,
    /// The inputs that produce the torque `along`.
    best: DVector<f64>,
}

impl<'a> Inverse<'a> {
    /// Builds the inverse for the limits `sizes`; `None` if no inputs produce the torque `along`.
    fn new(axes: &'a [Vector3], sizes: &[f64], along: &Vector3) -> Option<Self> {
        let scaled = DMatrix::from_fn(3, axes.len(), |row, input| axes[input][row] * sizes[input]);
        let threshold = UNREACHED * scaled.amax();
        let mut by_squares = scaled.pseudo_inverse(threshold).ok()?;
        for (mut row, size) in by_squares.row_iter_mut().zip(sizes) {
            row *= *size;
        }
        let mut found = Self { axes, by_squares, along: *along, best: DVector::zeros(axes.len()) };
        found.best = &found.by_squares * along;
        if let Some(best) = found.at_a_face(sizes) {
            found.best = best;
        }
        (found.miss(&found.best, along) <= UNREACHED).then_some(found)
    }

    /// Returns the inputs for `along` that need the smallest part of the limits. All inputs use
    /// this part of their limits, except inputs parallel to the face of the zonotope on which
    /// `along` lies.
    fn at_a_face(&self, sizes: &[f64]) -> Option<DVector<f64>> {
        const FLAT: f64 = 1e-6;
        let (share, normal) = Outputs::new(self.axes, sizes.iter().copied()).shortfall(&self.along);
        let lever = |input: usize| self.axes[input].dot(&normal) / self.axes[input].norm();
        let (flat, steep): (Vec<usize>, Vec<usize>) =
            (0..self.axes.len()).partition(|input| lever(*input).abs() <= FLAT);
        let mut inputs = DVector::zeros(self.axes.len());
        let mut rest = self.along;
        for input in steep {
            inputs[input] = share * sizes[input] * lever(input).signum();
            rest -= self.axes[input] * inputs[input];
        }
        let plane =
            DMatrix::from_fn(3, flat.len(), |row, index| self.axes[flat[index]][row] * sizes[flat[index]]);
        if !flat.is_empty() {
            let shares = plane.pseudo_inverse(UNREACHED).ok()? * rest;
            for (input, part) in flat.iter().zip(shares.iter()) {
                inputs[*input] = part * sizes[*input];
            }
        }
        let within =
            (0..inputs.len()).all(|input| inputs[input].abs() <= share * sizes[input] * (1.0 + FLAT));
        (within && self.miss(&inputs, &self.along) <= UNREACHED).then_some(inputs)
    }

    /// Returns the error of the torque that the inputs produce, relative to the torque `along`.
    fn miss(&self, inputs: &DVector<f64>, torque: &Vector3) -> f64 {
        let given: Vector3 = self.axes.iter().zip(inputs.iter()).map(|(axis, input)| axis * *input).sum();
        (given - torque).norm() / self.along.norm()
    }

    /// Returns the inputs that produce a torque; `None` if no inputs produce it.
    fn of(&self, torque: &Vector3) -> Option<DVector<f64>> {
        let part = torque.dot(&self.along) / self.along.norm_squared();
        let inputs = &self.best * part + &self.by_squares * (torque - self.along * part);
        (self.miss(&inputs, torque) <= UNREACHED * (1.0 + torque.norm() / self.along.norm()))
            .then_some(inputs)
    }
}
