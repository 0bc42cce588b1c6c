//! Legs planned together: Newton on what they share.
//!
//! The cost of the whole is a sum of the costs of the legs, and each depends on few of the
//! unknowns: the numbers that are free at its two ends, and when they are, where a total is split.
//! The slopes come from the costates ([`super::leg`]). The curvature of each leg begins with
//! differences of its slopes and is corrected by what every step shows of it (SR1; partially
//! separable functions: Griewank and Toint 1982). A step minimises the quadratic model within the
//! bounds of the joints and of the windows, and is halved until the cost falls.
//!
//! Cones that move are where they are when a leg begins; that the start of a leg depends on the
//! legs before it changes the cost, but not the slopes.
//!
//! Legs are planned one by one, so that all of what one leg may have (limits, cones, wheels, least
//! time) goes with stops too. That the unknowns end to first order right makes the cost right to
//! second order.

use super::arrivals::{Bounds, is_given};
use super::carried::carry;
use super::joint::Joint;
use super::leg::{Leg, LegError};
use super::order::Visit;
use crate::Vector3;
use crate::maneuver::problem::{Problem, State};
use crate::maneuver::settings::{Method, Settings};
use crate::optimize::search::Observer;
use nalgebra::{DMatrix, DVector};

/// Settings of the Newton method.
#[derive(Clone, Debug)]
pub struct Tuning {
    /// Largest number of Newton steps. A solve that needs more has met legs that change their kind.
    pub steps: usize,
    /// Halvings of a step.
    pub halvings: usize,
    /// The decrease that a step foresees or brings, relative to the cost, at which nothing is left to
    /// gain: less of it follows the round-off of plans.
    pub gain: f64,
    /// The decrease that counts as none where the interior point plans a leg: the cost of its optimum
    /// depends on where the switches lie between the nodes, and every plan takes its time.
    pub gain_on_grid: f64,
    /// Differences of the unknowns from which the first curvature comes, as a part of their
    /// sizes: a smaller one is lost in what plans are known to.
    pub difference: f64,
    /// Least curvature of a leg, as a part of its largest: a smaller one makes longer first steps.
    pub flat: f64,
}

impl Default for Tuning {
    fn default() -> Self {
        Self { steps: 40, halvings: 8, gain: 1e-9, gain_on_grid: 1e-6, difference: 1e-3, flat: 1e-3 }
    }
}

/// Legs from a start by way of joints.
pub struct Together<'a> {
    /// The maneuver without its ends.
    pub craft: &'a Problem,
    pub start: State,
    /// When the first leg begins \[s\].
    pub begins: f64,
    /// What happens at the joints.
    pub visits: Vec<Visit>,
    /// The angular momentum of the craft with its wheels, inertial axes [N·m·s].
    pub momentum: Vector3,
    pub joints: &'a [Joint],
    /// Bounds of the end of each leg \[s\]; `None` where each leg lasts as its own plan finds best.
    pub arrivals: Option<&'a [Bounds]>,
    pub settings: &'a Settings,
    pub tuning: Tuning,
}

/// Unknowns: the free numbers of all joints, one after the other, then the ends of the legs that are
/// not given.
#[derive(Clone, Debug)]
pub struct Whole {
    pub unknowns: DVector<f64>,
    pub legs: Vec<Leg>,
    /// When each leg begins \[s\].
    pub begins: Vec<f64>,
}

impl Whole {
    /// Returns the cost of all legs.
    pub fn cost(&self) -> f64 {
        self.legs.iter().map(|leg| leg.cost).sum()
    }
}

impl Together<'_> {
    /// Returns the place of the first unknown of a joint.
    fn place(&self, joint: usize) -> usize {
        self.joints[..joint].iter().map(Joint::size).sum()
    }

    fn count(&self) -> usize {
        self.place(self.joints.len()) + self.open_ends().count()
    }

    /// Returns the legs whose ends are unknowns, with their bounds.
    fn open_ends(&self) -> impl Iterator<Item = (usize, Bounds)> {
        let bounds = self.arrivals.unwrap_or_default().iter().copied().enumerate();
        bounds.filter(|(_, bounds)| !is_given(*bounds))
    }

    /// Returns the unknown that is the end of a leg.
    fn end(&self, leg: usize) -> Option<usize> {
        let index = self.open_ends().position(|(open, _)| open == leg)?;
        Some(self.place(self.joints.len()) + index)
    }

    /// Returns the unknowns from the states at the joints and the ends of the legs.
    pub fn unknowns(&self, states: &[State], ends: &[f64]) -> DVector<f64> {
        let numbers = self.joints.iter().zip(states).flat_map(|(joint, state)| joint.numbers(state));
        let ends = self.open_ends().filter_map(|(leg, _)| ends.get(leg).copied());
        DVector::from_vec(numbers.chain(ends).collect())
    }

    fn numbers<'x>(&self, unknowns: &'x DVector<f64>, joint: usize) -> &'x [f64] {
        let first = self.place(joint);
        &unknowns.as_slice()[first..first + self.joints[joint].size()]
    }

    /// Returns the state at the start of a leg.
    fn begun(&self, unknowns: &DVector<f64>, leg: usize) -> State {
        match leg.checked_sub(1) {
            None => self.start,
            Some(joint) => self.joints[joint].state(self.numbers(unknowns, joint)),
        }
    }

    /// Returns the duration of a leg, where it is not its own to find.
    fn lasting(&self, unknowns: &DVector<f64>, leg: usize) -> Option<f64> {
        let bounds = self.arrivals?;
        let at = |leg: usize| self.end(leg).map_or(bounds[leg][1], |end| unknowns[end]);
        let begins = leg.checked_sub(1).map_or(self.begins, |before| at(before) + self.visits[before].rest());
        Some(at(leg) - begins)
    }

    /// Returns the unknowns that a leg depends on: what is free at its ends, and when they are.
    fn own(&self, leg: usize) -> Vec<usize> {
        let of_joint = |joint: usize| self.place(joint)..self.place(joint + 1);
        let before = leg.checked_sub(1);
        let numbers = before.map_or(0..0, of_joint).chain(of_joint(leg));
        numbers.chain(before.and_then(|before| self.end(before))).chain(self.end(leg)).collect()
    }

    /// Plans a leg for unknowns.
    fn leg(
        &self,
        unknowns: &DVector<f64>,
        (leg, begins): (usize, f64),
        near: Option<&Leg>,
        observer: &mut dyn Observer,
    ) -> Result<Option<Leg>, LegError> {
        let end = self.joints[leg].state(self.numbers(unknowns, leg));
        let mut problem = Problem { start: self.begun(unknowns, leg), end, ..self.craft.later(begins) };
        carry(&mut problem, &self.momentum, None);
        if let Some(duration) = self.lasting(unknowns, leg) {
            if duration.is_nan() || duration <= 0.0 {
                return Ok(None);
            }
            problem = problem.with_duration(duration);
        }
        Leg::of(problem, self.settings, near, observer)
    }

    /// Plans all legs for unknowns, from the neighbours of some; `None` if one has no plan.
    pub fn planned(
        &self,
        unknowns: DVector<f64>,
        near: Option<&Whole>,
        observer: &mut dyn Observer,
    ) -> Result<Option<Whole>, LegError> {
        let mut legs = Vec::with_capacity(self.joints.len());
        let (mut begins, mut time) = (Vec::with_capacity(self.joints.len()), self.begins);
        for leg in 0..self.joints.len() {
            let known = near.map(|near| &near.legs[leg]);
            // What a leg does not depend on leaves it as it is.
            let same = near.is_some_and(|near| {
                (!self.craft.is_timed() || near.begins[leg] == time)
                    && self.own(leg).iter().all(|own| near.unknowns[*own] == unknowns[*own])
            });
            let next = match known.filter(|_| same) {
                Some(known) => Some(known.clone()),
                None => self.leg(&unknowns, (leg, time), known, observer)?,
            };
            let Some(next) = next else { return Ok(None) };
            begins.push(time);
            time = self.visits[leg].after(time + next.lasting()).0;
            legs.push(next);
        }
        Ok(Some(Whole { unknowns, legs, begins }))
    }

    /// Returns the slope of the cost of a leg by the unknowns that it depends on.
    fn slope(&self, unknowns: &DVector<f64>, leg: usize, plan: &Leg) -> DVector<f64> {
        let before = leg
            .checked_sub(1)
            .map(|joint| self.joints[joint].slope(self.numbers(unknowns, joint), &plan.slopes[0]));
        let after = self.joints[leg].slope(self.numbers(unknowns, leg), &plan.slopes[1]);
        let began = leg.checked_sub(1).and_then(|before| self.end(before)).map(|_| -plan.by_duration);
        let ended = self.end(leg).map(|_| plan.by_duration);
        DVector::from_vec(before.into_iter().flatten().chain(after).chain(began).chain(ended).collect())
    }

    /// Returns the curvature of a leg by differences of its slopes.
    fn curvature(
        &self,
        at: &Whole,
        leg: usize,
        observer: &mut dyn Observer,
    ) -> Result<DMatrix<f64>, LegError> {
        let own = self.own(leg);
        let slope = self.slope(&at.unknowns, leg, &at.legs[leg]);
        let mut curvature = DMatrix::zeros(own.len(), own.len());
        let ends = [leg.checked_sub(1).and_then(|before| self.end(before)), self.end(leg)];
        for (column, unknown) in own.iter().enumerate() {
            // To begin later is to end earlier.
            if column > 0 && ends == [own.get(column - 1).copied(), Some(*unknown)] {
                let earlier = -curvature.column(column - 1);
                curvature.set_column(column, &earlier);
                continue;
            }
            let by = self.tuning.difference * self.size(at, *unknown);
            let mut moved = at.unknowns.clone();
            moved[*unknown] += by;
            if let Some(next) = self.leg(&moved, (leg, at.begins[leg]), Some(&at.legs[leg]), observer)? {
                let change = (self.slope(&moved, leg, &next) - &slope) / by;
                curvature.set_column(column, &change);
            }
        }
        Ok(0.5 * (&curvature + curvature.transpose()))
    }

    /// Returns the size of an unknown: a radian, a radian in the duration of a leg, or the mean
    /// duration.
    fn size(&self, at: &Whole, unknown: usize) -> f64 {
        if unknown >= self.place(self.joints.len()) {
            return at.legs.iter().map(Leg::lasting).sum::<f64>() / at.legs.len() as f64;
        }
        let joint = (0..self.joints.len()).find(|joint| unknown < self.place(joint + 1)).unwrap_or(0);
        let is_roll = unknown == self.place(joint)
            && matches!(self.joints[joint], Joint::Roll(_) | Joint::PassingRoll { .. });
        if is_roll { 1.0 } else { 1.0 / at.legs[joint].lasting() }
    }

    /// Moves unknowns to where the joints may have them, and ends into their bounds.
    fn hold(&self, unknowns: &mut DVector<f64>) {
        for (joint, of) in self.joints.iter().enumerate() {
            let first = self.place(joint);
            of.hold(&mut unknowns.as_mut_slice()[first..first + of.size()]);
        }
        let first = self.place(self.joints.len());
        for (index, (_, [from, until])) in self.open_ends().enumerate() {
            unknowns[first + index] = unknowns[first + index].clamp(from, until);
        }
    }

    /// Improves a whole until nothing is left to gain, or a step leads nowhere.
    ///
    /// # Errors
    /// [`LegError`] if a leg cannot be attempted, or the search was stopped.
    pub fn improved(&self, mut at: Whole, observer: &mut dyn Observer) -> Result<Whole, LegError> {
        if self.count() == 0 {
            return Ok(at);
        }
        let legs = self.joints.len();
        let mut curvatures = Vec::with_capacity(legs);
        for leg in 0..legs {
            curvatures.push(self.curvature(&at, leg, observer)?);
        }
        let is_on_grid = |leg: &Leg| leg.solution.method == Method::InteriorPoint;
        let on_grid = at.legs.iter().any(is_on_grid);
        let gain = if on_grid { self.tuning.gain_on_grid } else { self.tuning.gain };
        for _ in 0..self.tuning.steps {
            let slopes: Vec<_> = (0..legs).map(|leg| self.slope(&at.unknowns, leg, &at.legs[leg])).collect();
            let model = self.model(&at, &slopes, &curvatures);
            let step = model.step(&at.unknowns, &|unknowns| self.hold(unknowns));
            if model.decrease(&step) <= gain * at.cost().abs() {
                break;
            }
            let (mut part, mut better) = (1.0, None);
            for _ in 0..=self.tuning.halvings {
                let mut unknowns = &at.unknowns + part * &step;
                self.hold(&mut unknowns);
                if let Some(next) = self.planned(unknowns, Some(&at), observer)? {
                    for leg in 0..legs {
                        let own = self.own(leg);
                        let moved = (&next.unknowns - &at.unknowns).select_rows(&own);
                        let change = self.slope(&next.unknowns, leg, &next.legs[leg]) - &slopes[leg];
                        correct(&mut curvatures[leg], &moved, &change);
                    }
                    if next.cost() < at.cost() {
                        better = Some(next);
                        break;
                    }
                }
                part *= 0.5;
            }
            let Some(next) = better else { break };
            let gained = at.cost() - next.cost();
            at = next;
            if gained <= gain * at.cost().abs() {
                break;
            }
        }
        Ok(at)
    }

    /// Returns the quadratic model of the whole: each leg with a curvature that is positive.
    fn model(&self, at: &Whole, slopes: &[DVector<f64>], curvatures: &[DMatrix<f64>]) -> Model {
        let count = self.count();
        let sizes = DVector::from_fn(count, |unknown, _| self.size(at, unknown));
        let mut model =
            Model { slope: DVector::zeros(count), curvature: DMatrix::zeros(count, count), sizes };
        for (leg, (slope, curvature)) in slopes.iter().zip(curvatures).enumerate() {
            let own = self.own(leg);
            // A leg between given ends has no unknown, and a matrix of none no eigenvalues.
            if own.is_empty() {
                continue;
            }
            let scale = DMatrix::from_diagonal(&model.sizes.select_rows(&own));
            let eigen = (&scale * curvature * &scale).symmetric_eigen();
            let largest = eigen.eigenvalues.amax();
            let values = eigen.eigenvalues.map(|value| value.abs().max(self.tuning.flat * largest));
            let positive =
                &eigen.eigenvectors * DMatrix::from_diagonal(&values) * eigen.eigenvectors.transpose();
            for (row, to) in own.iter().enumerate() {
                model.slope[*to] += slope[row] * model.sizes[*to];
                for (column, other) in own.iter().enumerate() {
                    model.curvature[(*to, *other)] += positive[(row, column)];
                }
            }
        }
        model
    }
}

/// Corrects a curvature by the change of the slope along a step (SR1).
fn correct(curvature: &mut DMatrix<f64>, moved: &DVector<f64>, change: &DVector<f64>) {
    let lacks = change - &*curvature * moved;
    let along = lacks.dot(moved);
    if along.abs() > 1e-8 * lacks.norm() * moved.norm() {
        *curvature += &lacks * lacks.transpose() / along;
    }
}

/// A quadratic model in unknowns that are measured by their sizes.
struct Model {
    slope: DVector<f64>,
    curvature: DMatrix<f64>,
    sizes: DVector<f64>,
}

impl Model {
    /// Returns the decrease along a step.
    fn decrease(&self, step: &DVector<f64>) -> f64 {
        let step = step.component_div(&self.sizes);
        -(self.slope.dot(&step) + 0.5 * step.dot(&(&self.curvature * &step)))
    }

    /// Returns the step to the minimum within bounds, to which `hold` moves unknowns: by projected
    /// gradients with momentum (Nesterov 1983), begun anew where they climb.
    fn step(&self, from: &DVector<f64>, hold: &dyn Fn(&mut DVector<f64>)) -> DVector<f64> {
        let steepest = self.curvature.symmetric_eigenvalues().max();
        if steepest.is_nan() || steepest <= 0.0 {
            return DVector::zeros(from.len());
        }
        let slope = |at: &DVector<f64>| &self.slope + &self.curvature * at;
        let held = |at: DVector<f64>| {
            let mut unknowns = from + at.component_mul(&self.sizes);
            hold(&mut unknowns);
            (unknowns - from).component_div(&self.sizes)
        };
        let (mut at, mut ahead, mut pace) =
            (held(DVector::zeros(from.len())), DVector::zeros(from.len()), 1.0_f64);
        for _ in 0..MOST_GRADIENTS {
            let next = held(&ahead - slope(&ahead) / steepest);
            let moved = &next - &at;
            if moved.amax() <= f64::EPSILON * next.amax() {
                return next.component_mul(&self.sizes);
            }
            if slope(&ahead).dot(&moved) > 0.0 {
                pace = 1.0;
                ahead = next.clone();
            } else {
                let quicker = 0.5 + (0.25 + pace * pace).sqrt();
                ahead = &next + moved * ((pace - 1.0) / quicker);
                pace = quicker;
            }
            at = next;
        }
        at.component_mul(&self.sizes)
    }
}

/// Largest number of projected gradients of a step: many, since each takes microseconds.
const MOST_GRADIENTS: usize = 20_000;
