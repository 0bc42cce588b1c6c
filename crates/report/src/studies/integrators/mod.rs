//! Work and precision of integrators on one motion, side by side.
//!
//! ```text
//! e_E = |E − E₀| / (T₀ + |U₀|)           energy, of the kinetic and potential energy at the start
//! e_L = |L − L₀| / Σ|x_i×γ_i + R_iΠ_i|   angular momentum; likewise e_P = |P − P₀| / Σ|γ_i|
//! e_R = max_i ‖I − R_iᵀR_i‖              orthogonality (Frobenius)
//! ```
//!
//! A [`Study`] names methods, steps and horizons. [`Study::run`] returns a [`WorkPrecision`]: for
//! each of them the errors above, largest and mean, and the work: time, evaluations of the
//! potential, iterations. The work of each method at equal mean energy error follows from the
//! rows ([`EqualError`]), interpolated between the steps on logarithmic axes. [`figures`] draws
//! them: the comparison of section 3.4 of the survey, its figures 2 and 3.
//!
//! A ratio of work needs its error level and its horizon: the energy error of a symplectic method
//! is bounded, and the energy error of other methods grows, so every such ratio grows with the
//! horizon. Methods of high order need less work on short smooth arcs.

mod at_equal_error;
pub mod figures;
mod history;
mod run;
mod sample;
mod table;
#[cfg(test)]
mod tests;

pub use at_equal_error::{Bound, EqualError};
pub use history::{History, Moment, Path};
pub use run::{Errors, IntegratorRun, Name};
pub use table::{EQUAL, RUNS, equal_row, run_row};

use history::Recorder;
use run::Measured;
use serde::Serialize;
use slewkit::numerics::figures::short;
use slewkit::propagate::integrator::{self, Kind, System, SystemError, SystemState};
use slewkit::propagate::simulate::Simulation;
use std::ops::ControlFlow;
use thiserror::Error;

/// The methods, steps and horizons of a comparison.
#[derive(Clone, Debug, PartialEq)]
pub struct Study {
    /// The methods; the work of each is compared with the work of the first.
    pub kinds: Vec<Kind>,
    /// Their steps \[s\], longest first.
    pub steps: Vec<f64>,
    /// The durations of the motion \[s\], shortest first; each is a whole number of every step.
    pub horizons: Vec<f64>,
    /// The mean energy errors `e_E` at which work is compared. Empty for 1, 3, 10, 30, … times a
    /// power of ten, at most five, within the range of the first method at the longest horizon,
    /// and above round-off.
    pub levels: Vec<f64>,
    /// The step whose runs are recorded over time, one of `steps` \[s\].
    pub shown_step: f64,
    /// Settings of the methods that have any.
    pub settings: integrator::ErrorControl,
    /// The number of repetitions of a run, to find its shortest time: short runs are repeated
    /// more often, runs of more than a second are not repeated.
    pub repeats: u32,
}

/// The requested values of a study; an empty list selects the values of the survey.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Asked {
    /// [`Study::kinds`].
    pub kinds: Vec<Kind>,
    /// [`Study::steps`] \[s\].
    pub steps: Vec<f64>,
    /// [`Study::horizons`] \[s\].
    pub horizons: Vec<f64>,
    /// [`Study::levels`].
    pub levels: Vec<f64>,
}

/// The reason for which a study cannot be made.
#[derive(Clone, Debug, Error, PartialEq)]
pub enum StudyError {
    /// A list is empty or too long.
    #[error("a comparison needs 1 to {limit} {what}, and {found} are given")]
    Count {
        /// The contents of the list.
        what: &'static str,
        /// The number found.
        found: usize,
        /// The largest allowed number.
        limit: usize,
    },
    /// A number is not positive and finite, or the list is not in order.
    #[error("the {what} must be positive numbers in {order} order, and {value} is not")]
    Order {
        /// The contents of the list.
        what: &'static str,
        /// The required order.
        order: &'static str,
        /// The first number that breaks it.
        value: f64,
    },
    /// A horizon is not a whole number of steps.
    #[error(
        "the step {} s does not divide the horizon {} s; the next that does is {} s",
        short(*step), short(*horizon), short(horizon / (horizon / step).ceil().max(1.0))
    )]
    Division {
        /// The step \[s\].
        step: f64,
        /// The horizon \[s\].
        horizon: f64,
    },
    /// The horizon needs too many steps.
    #[error(
        "{steps:.1e} steps of {} s to the horizon {} s are too many: at most {:.0e} are allowed",
        short(*step), short(*horizon), Study::STEPS
    )]
    TooManySteps {
        /// Steps to the horizon.
        steps: f64,
        /// The step \[s\].
        step: f64,
        /// The horizon \[s\].
        horizon: f64,
    },
    /// The step to show is not one of the steps.
    #[error("the step to show, {} s, is not one of the compared steps", short(*step))]
    ShownStep {
        /// The step \[s\].
        step: f64,
    },
    /// The state is not one of the system, or a setting is unusable.
    #[error(transparent)]
    System(#[from] SystemError),
}

/// The progress of a study.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct StudyProgress {
    /// The method that runs.
    pub kind: Kind,
    /// Step of the current run \[s\].
    pub step: f64,
    /// The numbers of finished runs and of all runs; each is made once to record its errors and
    /// once to time it.
    pub runs: (usize, usize),
}

/// The result of a study.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct WorkPrecision {
    /// Energy that energy errors are relative to, `T₀ + |U₀|` \[J\].
    pub energy_scale_j: f64,
    /// Mean energy errors at which work is compared.
    pub levels: Vec<f64>,
    /// A row per method, step and horizon, in this order.
    pub runs: Vec<IntegratorRun>,
    /// A row per horizon, level and method, in this order.
    pub equal_error: Vec<EqualError>,
    /// The methods over time at the step shown, to the longest horizon.
    #[serde(skip)]
    pub histories: Vec<History>,
    /// The motion over the horizon in the middle, by the first method at the shortest step.
    #[serde(skip)]
    pub path: Path,
    /// Whether the study was stopped before its end; its results so far are kept.
    pub interrupted: bool,
}

impl Study {
    /// The largest number of methods, steps, horizons or levels.
    pub const COUNT: usize = 32;
    /// The largest number of steps to a horizon.
    pub const STEPS: f64 = 1e9;

    /// The comparison of the survey's section 3.4: Lie–Verlet (LGVI), Crouch–Grossman (LGM),
    /// explicit midpoint (RK) and implicit midpoint (SRK).
    pub const SURVEY: [Kind; 4] =
        [Kind::LieVerlet, Kind::CrouchGrossman2, Kind::ExplicitMidpoint, Kind::ImplicitMidpoint];

    /// Builds a study of the methods of the survey at 16, 8, 4, 2, 1, ½ and ¼ times `step`. The
    /// horizons are `duration`, a tenth and a hundredth of it, rounded to a whole number of the
    /// longest steps. The program chooses the levels. Short motions have shorter steps and fewer
    /// horizons. Both are in seconds.
    pub fn survey(step: f64, duration: f64) -> Self {
        let step = step.min(duration);
        let factors = [16.0, 8.0, 4.0, 2.0, 1.0];
        let factor = factors.into_iter().find(|factor| 100.0 * factor * step <= duration).unwrap_or(1.0);
        let longest = factor * step;
        let mut horizons =
            [0.01, 0.1, 1.0].map(|part| (part * duration / longest).round().max(1.0) * longest).to_vec();
        horizons.dedup_by(|a, b| a <= b);
        Self {
            kinds: Self::SURVEY.to_vec(),
            steps: (0..7)
                .map(|halvings| longest * 0.5_f64.powi(halvings))
                .filter(|shorter| *shorter >= step || duration / shorter <= Self::STEPS)
                .collect(),
            horizons,
            levels: Vec::new(),
            shown_step: step,
            settings: integrator::ErrorControl::default(),
            repeats: 3,
        }
    }

    /// Builds the survey of a motion at its own step over its own duration, with its own
    /// integrator too, and with the requested replacements.
    pub fn of(simulation: &Simulation, asked: &Asked) -> Self {
        let mut study = Self::survey(simulation.step(), simulation.duration);
        study.settings = simulation.settings;
        if !Self::SURVEY.contains(&simulation.kind) {
            study.kinds.push(simulation.kind);
        }
        let lists = [
            (&mut study.steps, &asked.steps),
            (&mut study.horizons, &asked.horizons),
            (&mut study.levels, &asked.levels),
        ];
        for (list, asked) in lists.into_iter().filter(|(_, asked)| !asked.is_empty()) {
            list.clone_from(asked);
        }
        if !asked.kinds.is_empty() {
            study.kinds.clear();
            for kind in &asked.kinds {
                if !study.kinds.contains(kind) {
                    study.kinds.push(*kind);
                }
            }
        }
        // The step of the spec, or the middle one of the requested steps.
        if !asked.steps.is_empty() {
            study.shown_step = asked.steps[asked.steps.len() / 2];
        }
        study
    }

    /// Returns the steps of `step` to `horizon`.
    fn count(step: f64, horizon: f64) -> u64 {
        (horizon / step).round() as u64
    }

    /// Checks that the study can be made.
    ///
    /// # Errors
    /// Returns a [`StudyError`] that names the wrong value.
    pub fn check(&self) -> Result<(), StudyError> {
        let count = |what, found: usize| match found {
            1..=Self::COUNT => Ok(()),
            _ => Err(StudyError::Count { what, found, limit: Self::COUNT }),
        };
        count("methods", self.kinds.len())?;
        count("steps", self.steps.len())?;
        count("horizons", self.horizons.len())?;
        if !self.levels.is_empty() {
            count("error levels", self.levels.len())?;
        }
        in_order("steps", &self.steps, "falling", |before, value| value < before)?;
        in_order("horizons", &self.horizons, "rising", |before, value| value > before)?;
        in_order("error levels", &self.levels, "falling", |before, value| value < before)?;
        for (&step, &horizon) in self.steps.iter().flat_map(|s| self.horizons.iter().map(move |t| (s, t))) {
            let steps = horizon / step;
            if steps > Self::STEPS {
                return Err(StudyError::TooManySteps { steps, step, horizon });
            }
            if steps < 0.5 || (steps - steps.round()).abs() > 1e-9 * steps {
                return Err(StudyError::Division { step, horizon });
            }
        }
        // The step must be an element of the list, not the result of arithmetic.
        if !self.steps.iter().any(|step| step.to_bits() == self.shown_step.to_bits()) {
            return Err(StudyError::ShownStep { step: self.shown_step });
        }
        Ok(())
    }

    /// Runs every method with every step from `start`. `watch` receives progress a few times a
    /// second and may stop the study. A method that fails has rows with the reason and without
    /// errors.
    ///
    /// # Errors
    /// A [`StudyError`] before anything is run.
    pub fn run(
        &self,
        system: &System,
        start: &SystemState,
        watch: &mut dyn FnMut(&StudyProgress) -> ControlFlow<()>,
    ) -> Result<WorkPrecision, StudyError> {
        self.check()?;
        system.check(start)?;
        let scales = sample::Scales::of(system, start);
        let mut found = WorkPrecision {
            energy_scale_j: scales.energy,
            levels: self.levels.clone(),
            runs: Vec::new(),
            equal_error: Vec::new(),
            histories: Vec::new(),
            path: Path::default(),
            interrupted: false,
        };
        let total = self.kinds.len() * self.steps.len();
        let mut done = 0;
        for (first, kind) in self.kinds.iter().copied().enumerate().map(|(index, kind)| (index == 0, kind)) {
            for (index, &step) in self.steps.iter().enumerate() {
                let progress = StudyProgress { kind, step, runs: (done, total) };
                let horizons = self.horizons.iter().map(|&horizon| Self::count(step, horizon)).collect();
                let mut recorder = Recorder::new(&scales, *self.horizons.last().expect("checked"));
                if first && index + 1 == self.steps.len() {
                    recorder.follow(system, start, Self::count(step, self.horizons[self.horizons.len() / 2]));
                }
                let setup = run::Setup { system, start, kind, step, horizons, settings: self.settings };
                let mut go_on = || watch(&progress);
                let Measured { rows, stopped } =
                    setup.measure(&scales, &self.horizons, self.repeats, &mut recorder, &mut go_on)?;
                if stopped {
                    found.interrupted = true;
                    return Ok(self.compared(found));
                }
                found.runs.extend(rows);
                if step.to_bits() == self.shown_step.to_bits() {
                    found.histories.push(recorder.history(kind, step));
                }
                if let Some(path) = recorder.path() {
                    found.path = path;
                }
                done += 1;
            }
        }
        Ok(self.compared(found))
    }

    fn compared(&self, mut found: WorkPrecision) -> WorkPrecision {
        if found.levels.is_empty() {
            found.levels = at_equal_error::levels(self, &found.runs);
        }
        found.equal_error = at_equal_error::table(self, &found.levels, &found.runs);
        found
    }
}

/// Checks for positive finite numbers, each of them `in_order` after the one before.
fn in_order(
    what: &'static str,
    values: &[f64],
    order: &'static str,
    in_order: impl Fn(f64, f64) -> bool,
) -> Result<(), StudyError> {
    for (index, &value) in values.iter().enumerate() {
        let fits = index == 0 || in_order(values[index - 1], value);
        if !(fits && value > 0.0 && value.is_finite()) {
            return Err(StudyError::Order { what, order, value });
        }
    }
    Ok(())
}
