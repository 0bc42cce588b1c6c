//! Legs that are planned together: a quasi-Newton method for the quantities that they share.
//!
//! The total cost is the sum of the costs of the legs. The cost of a leg depends on few of the
//! unknowns: the free parameters of the joints at its two ends and, if the total duration is
//! divided among the legs, the times of these ends. The costates give the gradients
//! ([`super::leg`]). The Hessian of each leg is first computed by finite differences of its
//! gradient, and then updated after every step (SR1; partially separable functions: Griewank and
//! Toint 1982). A step minimises the quadratic model within the bounds of the joints and of the
//! windows. It is halved until the cost decreases.
//!
//! A leg uses the positions of moving cones at its start. The start time of a leg depends on the
//! legs before it; this changes the cost, but the gradient ignores it.
//!
//! Each leg is planned by the planner for single maneuvers. Everything that a single maneuver may
//! have (limits, cones, wheels, minimum time) is therefore possible in sequences too. First-order
//! errors of the unknowns cause only second-order errors of the cost.

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

/// Settings of the quasi-Newton method.
#[derive(Clone, Debug)]
pub struct Tuning {
    /// Maximum number of Newton steps. More steps are needed only if the type of a leg's solution
    /// changes during the iteration.
    pub steps: usize,
    /// Maximum number of times that a step is halved.
    pub halvings: usize,
    /// Relative decrease of the cost, predicted or actual, below which the iteration ends. Smaller
    /// decreases are dominated by the round-off of the plans.
    pub gain: f64,
    /// Relative decrease of the cost below which the iteration ends if the interior-point method
    /// plans a leg. The cost of such a leg depends on the positions of the switches between the
    /// nodes, and each of its plans takes long to compute.
    pub gain_on_grid: f64,
    /// Step of the finite differences for the first Hessian, relative to the scale of each unknown.
    /// With a smaller step the errors of the plans dominate the differences.
    pub difference: f64,
    /// Lower bound on the eigenvalues of a leg's Hessian, relative to its largest eigenvalue. A
    /// smaller bound allows longer first steps.
    pub flat: f64,
}

impl Default for Tuning {
    fn default() -> Self {
        Self { steps: 40, halvings: 8, gain: 1e-9, gain_on_grid: 1e-6, difference: 1e-3, flat: 1e-3 }
    }
}

/// Legs that are planned together, from a start state through the joints between them.
pub struct Together<'a> {
    /// The spacecraft with its objective, limits and constraints; the end states are not used.
    pub craft: &'a Problem,
    pub start: State,
    /// Start time of the first leg \[s\].
    pub begins: f64,
    /// Settling time, hold and window at each joint.
    pub visits: Vec<Visit>,
    /// Angular momentum of the craft including its wheels, inertial axes [N·m·s].
    pub momentum: Vector3,
    pub joints: &'a [Joint],
    /// Bounds of the end time of each leg \[s\]; `None` if the planner finds the duration of each
    /// leg independently.
    pub arrivals: Option<&'a [Bounds]>,
    pub settings: &'a Settings,
    pub tuning: Tuning,
}

/// Values of the unknowns with the plans of all legs. The unknowns are the free parameters of all
/// joints, in their order, followed by the end times of the legs that are not given.
#[derive(Clone, Debug)]
pub struct Whole {
    pub unknowns: DVector<f64>,
    pub legs: Vec<Leg>,
    /// Start time of each leg \[s\].
    pub begins: Vec<f64>,
}

impl Whole {
    /// Returns the sum of the costs of all legs.
    pub fn cost(&self) -> f64 {
        self.legs.iter().map(|leg| leg.cost).sum()
    }
}

impl Together<'_> {
    /// Returns the index of the first unknown of a joint.
    fn place(&self, joint: usize) -> usize {
        self.joints[..joint].iter().map(Joint::size).sum()
    }

    fn count(&self) -> usize {
        self.place(self.joints.len()) + self.open_ends().count()
    }

    /// Returns the indices of the legs whose end times are unknowns, with the bounds of these
    /// times.
    fn open_ends(&self) -> impl Iterator<Item = (usize, Bounds)> {
        let bounds = self.arrivals.unwrap_or_default().iter().copied().enumerate();
        bounds.filter(|(_, bounds)| !is_given(*bounds))
    }

    /// Returns the index of the unknown that is the end time of a leg; `None` if this time is
    /// given.
    fn end(&self, leg: usize) -> Option<usize> {
        let index = self.open_ends().position(|(open, _)| open == leg)?;
        Some(self.place(self.joints.len()) + index)
    }

    /// Returns the unknowns for given states at the joints and end times of the legs \[s\].
    pub fn unknowns(&self, states: &[State], ends: &[f64]) -> DVector<f64> {
        let numbers = self.joints.iter().zip(states).flat_map(|(joint, state)| joint.numbers(state));
        let ends = self.open_ends().filter_map(|(leg, _)| ends.get(leg).copied());
        DVector::from_vec(numbers.chain(ends).collect())
    }

    fn numbers<'x>(&self, unknowns: &'x DVector<f64>, joint: usize) -> &'x [f64] {
        let first = self.place(joint);
        &unknowns.as_slice()[first..first + self.joints[joint].size()]
    }

    /// Returns the state at the start of a leg for given values of the unknowns.
    fn begun(&self, unknowns: &DVector<f64>, leg: usize) -> State {
        match leg.checked_sub(1) {
            None => self.start,
            Some(joint) => self.joints[joint].state(self.numbers(unknowns, joint)),
        }
    }

    /// Returns the duration of a leg \[s\]; `None` if the planner of the leg finds the duration.
    fn lasting(&self, unknowns: &DVector<f64>, leg: usize) -> Option<f64> {
        let bounds = self.arrivals?;
        let at = |leg: usize| self.end(leg).map_or(bounds[leg][1], |end| unknowns[end]);
        let begins = leg.checked_sub(1).map_or(self.begins, |before| at(before) + self.visits[before].rest());
        Some(at(leg) - begins)
    }

    /// Returns the indices of the unknowns on which a leg depends: the free parameters at its two
    /// ends, and the times of these ends.
    fn own(&self, leg: usize) -> Vec<usize> {
        let of_joint = |joint: usize| self.place(joint)..self.place(joint + 1);
        let before = leg.checked_sub(1);
        let numbers = before.map_or(0..0, of_joint).chain(of_joint(leg));
        numbers.chain(before.and_then(|before| self.end(before))).chain(self.end(leg)).collect()
    }

    /// Plans a leg for given values of the unknowns.
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

    /// Plans all legs for given values of the unknowns. If `near` is given, its plans are the
    /// initial guesses. Returns `None` if no plan is found for a leg.
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
            // A leg is not planned again if the unknowns on which it depends have not changed.
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

    /// Returns the gradient of the cost of a leg with respect to the unknowns on which it depends.
    fn slope(&self, unknowns: &DVector<f64>, leg: usize, plan: &Leg) -> DVector<f64> {
        let before = leg
            .checked_sub(1)
            .map(|joint| self.joints[joint].slope(self.numbers(unknowns, joint), &plan.slopes[0]));
        let after = self.joints[leg].slope(self.numbers(unknowns, leg), &plan.slopes[1]);
        let began = leg.checked_sub(1).and_then(|before| self.end(before)).map(|_| -plan.by_duration);
        let ended = self.end(leg).map(|_| plan.by_duration);
        DVector::from_vec(before.into_iter().flatten().chain(after).chain(began).chain(ended).collect())
    }

    /// Computes the Hessian of the cost of a leg by finite differences of its gradient.
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
            // A later start has the same effect as an earlier end.
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

    /// Returns the scale of an unknown: 1 rad for a roll, 1 rad per duration of a leg for a rate,
    /// and the mean duration of the legs for a time.
    fn size(&self, at: &Whole, unknown: usize) -> f64 {
        if unknown >= self.place(self.joints.len()) {
            return at.legs.iter().map(Leg::lasting).sum::<f64>() / at.legs.len() as f64;
        }
        let joint = (0..self.joints.len()).find(|joint| unknown < self.place(joint + 1)).unwrap_or(0);
        let is_roll = unknown == self.place(joint)
            && matches!(self.joints[joint], Joint::Roll(_) | Joint::PassingRoll { .. });
        if is_roll { 1.0 } else { 1.0 / at.legs[joint].lasting() }
    }

    /// Moves the parameters of the joints and the end times of the legs into their bounds.
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

    /// Minimises the total cost from the values `at`, until the decrease is below the tolerance or
    /// a step fails.
    ///
    /// # Errors
    /// [`LegError`] if the planner rejects a leg, or if the search was stopped.
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

    /// Returns the quadratic model of the total cost. The Hessian of each leg is made positive
    /// definite.
    fn model(&self, at: &Whole, slopes: &[DVector<f64>], curvatures: &[DMatrix<f64>]) -> Model {
        let count = self.count();
        let sizes = DVector::from_fn(count, |unknown, _| self.size(at, unknown));
        let mut model =
            Model { slope: DVector::zeros(count), curvature: DMatrix::zeros(count, count), sizes };
        for (leg, (slope, curvature)) in slopes.iter().zip(curvatures).enumerate() {
            let own = self.own(leg);
            // A leg between given ends depends on no unknowns, and an empty matrix has no
            // eigenvalues.
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

/// Updates a Hessian by the SR1 formula: `moved` is the step, and `change` the change of the
/// gradient along the step.
fn correct(curvature: &mut DMatrix<f64>, moved: &DVector<f64>, change: &DVector<f64>) {
    let lacks = change - &*curvature * moved;
    let along = lacks.dot(moved);
    if along.abs() > 1e-8 * lacks.norm() * moved.norm() {
        *curvature += &lacks * lacks.transpose() / along;
    }
}

/// A quadratic model of the total cost in scaled unknowns.
struct Model {
    slope: DVector<f64>,
    curvature: DMatrix<f64>,
    sizes: DVector<f64>,
}

impl Model {
    /// Returns the decrease of the model along a step.
    fn decrease(&self, step: &DVector<f64>) -> f64 {
        let step = step.component_div(&self.sizes);
        -(self.slope.dot(&step) + 0.5 * step.dot(&(&self.curvature * &step)))
    }

    /// Returns the step to the minimum of the model within the bounds, onto which `hold` projects
    /// the unknowns. The method is the projected gradient method with momentum (Nesterov 1983),
    /// restarted if the model increases.
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

/// Maximum number of projected-gradient iterations for one step; an iteration takes microseconds.
const MOST_GRADIENTS: usize = 20_000;
