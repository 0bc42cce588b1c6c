//! Run of one method with one step. A first pass records the conserved quantities, and further
//! passes measure the computing time.

use super::StudyError;
use super::history::Recorder;
use super::sample::{Sample, Scales};
use crate::studies::clock::thread_time;
use serde::{Deserialize, Deserializer, Serialize};
use slewkit::numerics::figures::short;
use slewkit::propagate::integrator::{ErrorControl, Integrator, Kind, StepError, System, SystemState, Work};
use std::ops::ControlFlow;

/// Approximate number of states at which errors are computed, equally spaced up to the longest
/// horizon.
const SAMPLES: u64 = 200_000;

/// Number of steps between two checks of the clock and of a request to stop.
const CHUNK: u64 = 1024;

/// Total time of the repetitions of a run after which it is not repeated again \[s\].
const SHORT: f64 = 0.02;
/// Computing time above which a run is not repeated \[s\].
const LONG: f64 = 1.0;

/// The largest number of repetitions of a run.
const MOST_REPEATS: u32 = 100;

/// Errors and work of a method with one step, over one horizon.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct IntegratorRun {
    /// Name of the method of the run.
    #[serde(deserialize_with = "name")]
    pub method: Name,
    /// Step of the run \[s\].
    pub step_s: f64,
    /// Duration of the motion \[s\].
    pub horizon_s: f64,
    /// The number of steps to the horizon.
    pub steps: u64,
    /// The errors of conserved quantities; `None` if the method did not reach this horizon.
    #[serde(flatten)]
    pub errors: Option<Errors>,
    /// Number of evaluations of the potential. One evaluation covers all bodies.
    pub force_evaluations: u64,
    /// Number of Newton or fixed-point iterations. If each body iterates separately, it is the sum
    /// over the bodies.
    pub iterations: u64,
    /// Shortest CPU time of all repetitions, measured for the thread that computes the steps \[s\].
    /// Without the feature `cpu-time` it is the elapsed time. If several threads share the
    /// summation over many points, it is the CPU time of one of them.
    pub time_s: f64,
    /// The reason why the method did not reach the horizon; `None` if it did.
    #[serde(skip_serializing_if = "Option::is_none", default)]
    pub failure: Option<String>,
}

/// A name of a method from [`Kind::NAMES`].
pub type Name = &'static str;

/// Deserialises the name of a method; an unknown name is an error.
pub(super) fn name<'de, D: Deserializer<'de>>(from: D) -> Result<&'static str, D::Error> {
    let name = String::deserialize(from)?;
    name.parse().map(Kind::name).map_err(serde::de::Error::custom)
}

/// Errors of conserved quantities over the sampled states. These are all states or, in long runs,
/// equally spaced ones.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Errors {
    /// Largest energy error `e_E` over the samples.
    pub energy_error_max: f64,
    /// Mean energy error `e_E` over the samples.
    pub energy_error_mean: f64,
    /// Largest orthogonality error `e_R` over the samples.
    pub orthogonality_error_max: f64,
    /// Mean orthogonality error `e_R` over the samples.
    pub orthogonality_error_mean: f64,
    /// Largest error of the linear momentum `e_P`. For a body in a force field, it includes the
    /// change of momentum due to the field.
    pub linear_momentum_error_max: f64,
    /// Largest error of the angular momentum `e_L`. For a body in a force field, it includes the
    /// change of momentum due to the field.
    pub angular_momentum_error_max: f64,
}

/// Sums and maxima of the errors over the samples added so far.
#[derive(Clone, Copy, Debug, Default)]
struct Sums {
    count: u64,
    largest: Errors,
}

impl Sums {
    /// Adds a sample. Returns false if one of its numbers is not finite.
    fn add(&mut self, sample: &Sample) -> bool {
        let errors = &mut self.largest;
        self.count += 1;
        errors.energy_error_max = errors.energy_error_max.max(sample.energy_error);
        errors.energy_error_mean += sample.energy_error;
        errors.orthogonality_error_max = errors.orthogonality_error_max.max(sample.orthogonality);
        errors.orthogonality_error_mean += sample.orthogonality;
        errors.linear_momentum_error_max = errors.linear_momentum_error_max.max(sample.linear);
        errors.angular_momentum_error_max = errors.angular_momentum_error_max.max(sample.angular);
        // A sum is NaN if a term is NaN; `f64::max` would ignore the NaN.
        (sample.energy_error + sample.orthogonality + sample.linear + sample.angular).is_finite()
    }

    fn errors(&self) -> Errors {
        let count = self.count.max(1) as f64;
        Errors {
            energy_error_mean: self.largest.energy_error_mean / count,
            orthogonality_error_mean: self.largest.orthogonality_error_mean / count,
            ..self.largest
        }
    }
}

/// The data that a run needs.
pub(super) struct Setup<'a> {
    pub system: &'a System,
    pub start: &'a SystemState,
    pub kind: Kind,
    pub step: f64,
    /// Number of steps to each horizon, in increasing order.
    pub horizons: Vec<u64>,
    pub settings: ErrorControl,
}

/// Results of a run, with one row for each horizon. If the study was stopped, rows are missing.
pub(super) struct Measured {
    pub rows: Vec<IntegratorRun>,
    pub stopped: bool,
}

/// Reason why a pass over the steps ended.
enum End {
    Reached,
    Failed(String),
    Stopped,
}

impl Setup<'_> {
    fn method(&self) -> Result<Box<dyn Integrator>, StudyError> {
        Ok(self.kind.start(self.system, self.start, self.step, &self.settings)?)
    }

    pub fn measure(
        &self,
        scales: &Scales,
        horizons: &[f64],
        repeats: u32,
        recorder: &mut Recorder,
        go_on: &mut dyn FnMut() -> ControlFlow<()>,
    ) -> Result<Measured, StudyError> {
        let mut reached: Vec<(Errors, Work)> = Vec::new();
        let end = self.observe(scales, recorder, &mut reached, go_on)?;
        let mut times = vec![f64::INFINITY; reached.len()];
        let mut stopped = matches!(end, End::Stopped);
        let mut spent = 0.0;
        for repeat in 0..MOST_REPEATS {
            let enough = repeat >= repeats.max(1) && spent >= SHORT;
            if stopped || reached.is_empty() || enough {
                break;
            }
            let passed = self.time(&self.horizons[..reached.len()], go_on)?;
            stopped = passed.is_none();
            for (best, time) in times.iter_mut().zip(passed.into_iter().flatten()) {
                *best = best.min(time);
            }
            spent += times.last().copied().unwrap_or(0.0);
            if spent > LONG {
                break;
            }
        }
        let failure = match end {
            End::Failed(reason) => Some(reason),
            End::Reached | End::Stopped => None,
        };
        let row = |index: usize| {
            let at = reached.get(index);
            let work = at.map_or_else(Work::default, |(_, work)| *work);
            IntegratorRun {
                method: self.kind.name(),
                step_s: self.step,
                horizon_s: horizons[index],
                steps: self.horizons[index],
                errors: at.map(|(errors, _)| *errors),
                force_evaluations: work.force_evaluations,
                iterations: work.iterations,
                time_s: times.get(index).copied().unwrap_or(0.0),
                failure: if at.is_some() { None } else { failure.clone() },
            }
        };
        Ok(Measured { rows: (0..horizons.len()).map(row).collect(), stopped })
    }

    /// Runs the method and samples its states.
    fn observe(
        &self,
        scales: &Scales,
        recorder: &mut Recorder,
        reached: &mut Vec<(Errors, Work)>,
        go_on: &mut dyn FnMut() -> ControlFlow<()>,
    ) -> Result<End, StudyError> {
        let mut method = self.method()?;
        let last = self.horizons.last().copied().unwrap_or(0);
        let stride = last.div_ceil(SAMPLES).max(1);
        let mut sums = Sums::default();
        for step in 1..=last {
            if step % CHUNK == 0 && go_on().is_break() {
                return Ok(End::Stopped);
            }
            let time = step as f64 * self.step;
            if let Err(error) = method.step(&[]) {
                return Ok(End::Failed(at(time, &error)));
            }
            recorder.pose(step, method.state());
            let here = self.horizons.contains(&step);
            if step % stride == 0 || here {
                let sample = scales.sample(&self.system.invariants(method.state()));
                if !sums.add(&sample) {
                    return Ok(End::Failed(at(time, &StepError::NotFinite)));
                }
                recorder.add(time, &sample);
            }
            if here {
                reached.push((sums.errors(), method.work()));
            }
        }
        Ok(End::Reached)
    }

    /// Returns the computing time of the steps to each of `horizons`, without sampling; `None` if
    /// the study was stopped.
    fn time(
        &self,
        horizons: &[u64],
        go_on: &mut dyn FnMut() -> ControlFlow<()>,
    ) -> Result<Option<Vec<f64>>, StudyError> {
        let mut method = self.method()?;
        let (mut times, mut done, mut spent) = (Vec::with_capacity(horizons.len()), 0, 0.0);
        for &horizon in horizons {
            while done < horizon {
                let chunk = (horizon - done).min(64 * CHUNK);
                let began = thread_time();
                for _ in 0..chunk {
                    // This cannot fail, because the first run reached this step, and equal inputs
                    // give equal outputs.
                    if method.step(&[]).is_err() {
                        break;
                    }
                }
                spent += (thread_time() - began).as_secs_f64();
                done += chunk;
                if go_on().is_break() {
                    return Ok(None);
                }
            }
            times.push(spent);
        }
        Ok(Some(times))
    }
}

fn at(time: f64, error: &StepError) -> String {
    format!("at t = {} s: {error}", short(time))
}
