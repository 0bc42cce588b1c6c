//! Comparison of the work and the precision of integrators for one motion.
//!
//! ```text
//! e_E = |E − E₀| / (T₀ + |U₀|)           energy, of the kinetic and potential energy at the start
//! e_L = |L − L₀| / Σ|x_i×γ_i + R_iΠ_i|   angular momentum; likewise e_P = |P − P₀| / Σ|γ_i|
//! e_R = max_i ‖I − R_iᵀR_i‖              orthogonality (Frobenius)
//! ```
//!
//! A [`Study`] defines the methods, the steps and the horizons, which are durations of the motion.
//! [`Study::run`] returns a [`WorkPrecision`]. For each combination it contains the largest and the
//! mean value of the errors above, and the work: computing time, evaluations of the potential, and
//! iterations. From these values, the work of each method at equal mean energy error
//! ([`EqualError`]) is interpolated on logarithmic axes. [`figures`] draws the comparison as
//! figures 2 and 3 in section 3.4 of the survey by Leok (*An overview of Lie group variational
//! integrators*).
//!
//! A ratio of work depends on the error level and on the horizon. The energy error of a symplectic
//! method is bounded, whereas the error of other methods grows, so every such ratio grows with the
//! horizon. For short smooth arcs, methods of high order need less work.

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

/// Methods, steps and horizons of a comparison of integrators.
#[derive(Clone, Debug, PartialEq)]
pub struct Study {
    /// Methods that are compared. The work of each method is given relative to the work of the
    /// first.
    pub kinds: Vec<Kind>,
    /// Steps in decreasing order \[s\].
    pub steps: Vec<f64>,
    /// Durations of the motion in increasing order \[s\]. Each of them is a multiple of every step.
    pub horizons: Vec<f64>,
    /// Mean energy errors `e_E` for which the work is compared. If the list is empty, the program
    /// chooses at most five levels. They are 1 or 3 times a power of ten, lie within the errors of
    /// the first method over the longest horizon, and are above round-off.
    pub levels: Vec<f64>,
    /// Step for which errors are recorded over time \[s\]. It must be one of `steps`.
    pub shown_step: f64,
    /// Error control of the adaptive methods.
    pub settings: integrator::ErrorControl,
    /// Number of repetitions of each run; the shortest computing time of the repetitions counts.
    /// Short runs are repeated more often, and runs of more than a second are not repeated.
    pub repeats: u32,
}

/// Values that the user requests for a study. An empty list stands for the values of the survey.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Asked {
    /// Methods that are compared, as in [`Study::kinds`].
    pub kinds: Vec<Kind>,
    /// The steps \[s\], as in [`Study::steps`].
    pub steps: Vec<f64>,
    /// The horizons \[s\], as in [`Study::horizons`].
    pub horizons: Vec<f64>,
    /// The error levels, as in [`Study::levels`].
    pub levels: Vec<f64>,
}

/// Reason why a study cannot be carried out.
#[derive(Clone, Debug, Error, PartialEq)]
pub enum StudyError {
    /// A list is empty or too long.
    #[error("a comparison needs 1 to {limit} {what}, and {found} are given")]
    Count {
        /// Name of the contents of the list, such as "steps".
        what: &'static str,
        /// Number of entries of the list.
        found: usize,
        /// The largest allowed number of entries.
        limit: usize,
    },
    /// A number in a list is not positive and finite, or the numbers are not in the required order.
    #[error("the {what} must be positive numbers in {order} order, and {value} is not")]
    Order {
        /// Name of the contents of the list, such as "steps".
        what: &'static str,
        /// Order in which the numbers must be, as a phrase.
        order: &'static str,
        /// The first number that violates the order.
        value: f64,
    },
    /// A horizon is not a multiple of a step.
    #[error(
        "the step {} s does not divide the horizon {} s; the next that does is {} s",
        short(*step), short(*horizon), short(horizon / (horizon / step).ceil().max(1.0))
    )]
    Division {
        /// Step that does not divide the horizon \[s\].
        step: f64,
        /// Horizon that is not a multiple of the step \[s\].
        horizon: f64,
    },
    /// The number of steps to the horizon is too large.
    #[error(
        "{steps:.1e} steps of {} s to the horizon {} s are too many: at most {:.0e} are allowed",
        short(*step), short(*horizon), Study::STEPS
    )]
    TooManySteps {
        /// The number of steps to the horizon.
        steps: f64,
        /// Step with which the horizon needs too many steps \[s\].
        step: f64,
        /// Horizon that needs too many steps \[s\].
        horizon: f64,
    },
    /// The step for which errors are to be recorded over time is not one of the steps.
    #[error("the step to show, {} s, is not one of the compared steps", short(*step))]
    ShownStep {
        /// Step for which errors were to be recorded \[s\].
        step: f64,
    },
    /// The initial state does not fit the system, or a setting of the integrator is invalid.
    #[error(transparent)]
    System(#[from] SystemError),
}

/// Progress of a study while it runs.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct StudyProgress {
    /// Method that is running.
    pub kind: Kind,
    /// The step of the current run \[s\].
    pub step: f64,
    /// Number of finished runs, and number of all runs. Each combination is run once to record the
    /// errors, and once more to measure the time.
    pub runs: (usize, usize),
}

/// Errors and work of all methods of a study.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct WorkPrecision {
    /// Energy `T₀ + |U₀|` by which energy errors are divided \[J\].
    pub energy_scale_j: f64,
    /// Mean energy errors for which the work is compared.
    pub levels: Vec<f64>,
    /// Errors and work of each run, sorted by method, step and horizon.
    pub runs: Vec<IntegratorRun>,
    /// Work at equal error, sorted by horizon, level and method.
    pub equal_error: Vec<EqualError>,
    /// Errors of the methods over time, for the step [`Study::shown_step`] and the longest horizon.
    #[serde(skip)]
    pub histories: Vec<History>,
    /// Motion over the middle one of the horizons, computed by the first method with the shortest
    /// step.
    #[serde(skip)]
    pub path: Path,
    /// True if the study was stopped before its end. The results obtained before are included.
    pub interrupted: bool,
}

impl Study {
    /// Largest number of methods, steps, horizons or error levels.
    pub const COUNT: usize = 32;
    /// The largest number of steps to a horizon.
    pub const STEPS: f64 = 1e9;

    /// Methods that section 3.4 of Leok's survey (*An overview of Lie group variational
    /// integrators*, see the crate `slewkit`) compares: Lie–Verlet (LGVI), Crouch–Grossman (LGM),
    /// explicit midpoint (RK) and implicit midpoint (SRK).
    pub const SURVEY: [Kind; 4] =
        [Kind::LieVerlet, Kind::CrouchGrossman2, Kind::ExplicitMidpoint, Kind::ImplicitMidpoint];

    /// Creates a study of the methods of the survey with steps of 16, 8, 4, 2, 1, ½ and ¼ times
    /// `step` \[s\]. The horizons are `duration` \[s\], a tenth and a hundredth of it, rounded to a
    /// multiple of the longest step. The program chooses the error levels. For short motions, the
    /// steps are shorter and the horizons fewer.
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

    /// Creates the study of a simulation. In addition to the methods of the survey, it includes the
    /// integrator of the simulation. Step and duration are those of the simulation, and values in
    /// `asked` replace the defaults.
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
        // The errors over time are recorded for the step of the spec or, if steps are requested,
        // for the middle one of these steps.
        if !asked.steps.is_empty() {
            study.shown_step = asked.steps[asked.steps.len() / 2];
        }
        study
    }

    /// Returns the number of steps of length `step` \[s\] to the time `horizon` \[s\].
    fn count(step: f64, horizon: f64) -> u64 {
        (horizon / step).round() as u64
    }

    /// Checks that the study can be carried out.
    ///
    /// # Errors
    /// Returns a [`StudyError`] that states the invalid value.
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
        // The bits are compared, because the step must be an element of the list and not only close
        // to one.
        if !self.steps.iter().any(|step| step.to_bits() == self.shown_step.to_bits()) {
            return Err(StudyError::ShownStep { step: self.shown_step });
        }
        Ok(())
    }

    /// Runs every method with every step from the state `start`. `watch` receives the progress a
    /// few times per second and may stop the study. If a method fails, its rows have the reason and
    /// no errors.
    ///
    /// # Errors
    /// Returns a [`StudyError`] before anything runs, if the study is not valid.
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

/// Checks that all numbers are positive and finite, and that neighbouring numbers satisfy
/// `in_order`.
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
