//! Reference methods from the crate `differential-equations`: DOP853 and Verner's 9(8), with error
//! control.
//!
//! Each step is a separate integration, so inputs may jump at the nodes. The solvers of that crate
//! allocate memory: these two methods are for accuracy, not for speed.

use super::ambient::Ambient;
use super::course::{Course, Method};
use super::{Input, StepError};
use crate::propagate::adaptive::integrate;
use differential_equations::methods::{Adaptive, DormandPrince, ExplicitRungeKutta, Ordinary};
use differential_equations::ode::ODE;
use differential_equations::tolerance::Tolerance;
use std::cell::RefCell;

type Dop853 = ExplicitRungeKutta<Ordinary, DormandPrince, f64, Vec<f64>, 8, 12, 16>;
type Verner98 = ExplicitRungeKutta<Ordinary, Adaptive, f64, Vec<f64>, 9, 16, 21>;

/// Largest number of parts into which a step may be divided.
const MAX_PARTS: usize = 100_000;

/// A reference method with its solver.
pub(super) struct Reference {
    ambient: Ambient,
    solver: Solver,
    tolerance: f64,
    /// Length of the first part to try: the length of the last part of the step before.
    part: f64,
    scales: Vec<f64>,
    /// Number of parts rejected so far.
    rejected: u64,
}

/// The solver of the reference method.
enum Solver {
    Dop853(Box<Dop853>),
    Verner98(Box<Verner98>),
}

/// The change over a step as an ODE in the time since the start of the step.
struct Change<'a> {
    ambient: RefCell<&'a mut Ambient>,
    inputs: &'a [Input],
    step: f64,
}

impl ODE<f64, Vec<f64>> for Change<'_> {
    fn diff(&self, t: f64, y: &Vec<f64>, dydt: &mut Vec<f64>) {
        self.ambient.borrow_mut().rate(t / self.step, y, self.inputs, dydt);
    }
}

impl Reference {
    pub fn dop853(course: Course, tolerance: f64) -> Self {
        let solver = Dop853::dop853().max_steps(usize::MAX);
        Self::new(course, tolerance, Solver::Dop853(Box::new(solver)))
    }

    pub fn verner98(course: Course, tolerance: f64) -> Self {
        let solver = Verner98::rkv988e().max_steps(usize::MAX);
        Self::new(course, tolerance, Solver::Verner98(Box::new(solver)))
    }

    fn new(course: Course, tolerance: f64, solver: Solver) -> Self {
        let part = course.loads.step;
        let ambient = Ambient::new(course);
        let scales = vec![0.0; ambient.size];
        Self { ambient, solver, tolerance, part, scales, rejected: 0 }
    }
}

impl Method for Reference {
    fn advance(&mut self, inputs: &[Input]) -> Result<(), StepError> {
        let step = self.ambient.course.loads.step;
        let zero = vec![0.0; self.scales.len()];
        let mut rate = zero.clone();
        self.ambient.rate(0.0, &zero, inputs, &mut rate);
        rate.iter_mut().for_each(|rate| *rate *= step);
        self.ambient.error_scales(&rate, self.tolerance, &mut self.scales);
        let allowed = Tolerance::Vector(self.scales.iter().map(|scale| self.tolerance * scale).collect());
        let change = Change { ambient: RefCell::new(&mut self.ambient), inputs, step };
        let (part, rejected) = (&mut self.part, &mut self.rejected);
        // The changes start at zero, so the error is measured relative to the scales only.
        let none = Tolerance::Scalar(0.0);
        let result = match &mut self.solver {
            Solver::Dop853(solver) => {
                (solver.h0, solver.atol, solver.rtol) = (part.min(step), allowed, none);
                integrate(solver.as_mut(), &change, step, &zero, MAX_PARTS, part, rejected)
            }
            Solver::Verner98(solver) => {
                (solver.h0, solver.atol, solver.rtol) = (part.min(step), allowed, none);
                integrate(solver.as_mut(), &change, step, &zero, MAX_PARTS, part, rejected)
            }
        };
        let y = result.ok_or(StepError::GaveUp { step })?;
        self.ambient.course.work.rejected = self.rejected;
        self.ambient.finish(&y)
    }

    fn course(&self) -> &Course {
        &self.ambient.course
    }
}
