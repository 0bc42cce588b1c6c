//! Recording of errors over time, and of the motion, with a bounded amount of memory.

use super::sample::{Sample, Scales};
use slewkit::mechanics::environment::Pose;
use slewkit::propagate::integrator::{Kind, System, SystemState};

/// The number of time intervals of a history.
const MOMENTS: usize = 500;

/// The largest number of poses of each body in a path.
const POSES: u64 = 4000;

/// Errors of a method over time, for a single step.
#[derive(Clone, Debug, PartialEq)]
pub struct History {
    /// Method whose errors were recorded.
    pub kind: Kind,
    /// The step of the method \[s\].
    pub step: f64,
    /// The energy at the start \[J\].
    pub start_energy: f64,
    /// Time intervals of equal length in chronological order. Intervals without a sample are
    /// omitted.
    pub moments: Vec<Moment>,
}

/// The errors in one time interval.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Moment {
    /// The middle of the interval \[s\].
    pub time: f64,
    /// The lowest and the highest relative change of the energy, `(E − E₀)/(T₀ + |U₀|)`.
    pub energy: (f64, f64),
    /// Largest energy error `e_E` in the interval.
    pub energy_error: f64,
    /// Largest orthogonality error `e_R` in the interval.
    pub orthogonality: f64,
    /// Largest error of the angular momentum `e_L` in the interval.
    pub angular_momentum: f64,
}

/// Recorded motion of all bodies.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Path {
    /// The poses of each body, equally spaced in time from the start.
    pub poses: Vec<Vec<Pose>>,
    /// For each body, true if it translates.
    pub moves: Vec<bool>,
    /// The number of steps from one pose to the next.
    pub stride: u64,
}

/// Recorder of errors and poses while a method runs.
pub(super) struct Recorder {
    horizon: f64,
    start_energy: f64,
    moments: Vec<Option<Moment>>,
    path: Option<(Path, u64)>,
}

impl Recorder {
    pub fn new(scales: &Scales, horizon: f64) -> Self {
        Self { horizon, start_energy: scales.start.energy, moments: vec![None; MOMENTS], path: None }
    }

    /// Starts to record the poses of the bodies too, for the first `steps` steps.
    pub fn follow(&mut self, system: &System, start: &SystemState, steps: u64) {
        let path = Path {
            poses: start.poses().iter().map(|pose| vec![*pose]).collect(),
            moves: system.bodies().iter().map(|body| body.mass.is_some()).collect(),
            stride: steps.div_ceil(POSES).max(1),
        };
        self.path = Some((path, steps));
    }

    pub fn pose(&mut self, step: u64, state: &SystemState) {
        let Some((path, steps)) = &mut self.path else { return };
        if step <= *steps && step.is_multiple_of(path.stride) {
            for (poses, pose) in path.poses.iter_mut().zip(state.poses()) {
                poses.push(*pose);
            }
        }
    }

    pub fn add(&mut self, time: f64, sample: &Sample) {
        let index = (time / self.horizon * MOMENTS as f64) as usize;
        let slot = &mut self.moments[index.min(MOMENTS - 1)];
        let middle = (index.min(MOMENTS - 1) as f64 + 0.5) / MOMENTS as f64 * self.horizon;
        let moment = slot.get_or_insert(Moment {
            time: middle,
            energy: (sample.energy, sample.energy),
            energy_error: 0.0,
            orthogonality: 0.0,
            angular_momentum: 0.0,
        });
        moment.energy = (moment.energy.0.min(sample.energy), moment.energy.1.max(sample.energy));
        moment.energy_error = moment.energy_error.max(sample.energy_error);
        moment.orthogonality = moment.orthogonality.max(sample.orthogonality);
        moment.angular_momentum = moment.angular_momentum.max(sample.angular);
    }

    pub fn history(&self, kind: Kind, step: f64) -> History {
        let moments = self.moments.iter().copied().flatten().collect();
        History { kind, step, start_energy: self.start_energy, moments }
    }

    pub fn path(self) -> Option<Path> {
        self.path.map(|(path, _)| path)
    }
}
