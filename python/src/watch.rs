//! Progress, and the ways to stop a computation: the result of the caller's function, an
//! exception in it, or Ctrl-C.

use pyo3::prelude::*;
use slewkit::plan::{Control, Observer, Progress};
use std::time::{Duration, Instant};

/// The interval between two checks of signals, or two calls of the caller's function: taking the
/// lock of a busy interpreter costs milliseconds.
const INTERVAL: Duration = Duration::from_millis(50);

/// Listens while the library computes.
pub struct Watch {
    progress: Option<Py<PyAny>>,
    looked: Option<Instant>,
    /// The exception of the caller's function, or of a signal.
    raised: Option<PyErr>,
    stopped: bool,
}

impl Watch {
    /// Builds a watch that calls `progress` with the progress of the work, at once and then
    /// repeatedly. A return value of `False` stops the work.
    pub fn new(progress: Option<Py<PyAny>>) -> Self {
        // Work of a few milliseconds is not interrupted if no progress function is given.
        let looked = if progress.is_some() { None } else { Some(Instant::now()) };
        Self { progress, looked, raised: None, stopped: false }
    }

    /// Returns the exception that was raised meanwhile.
    pub fn raised(self) -> Option<PyErr> {
        self.raised
    }

    /// Returns whether to stop, and passes the current stage to the caller's function.
    pub fn stops(&mut self, stage: &str, start: &str, steps: u64, elapsed: f64, part: &str) -> bool {
        if !self.stopped && self.looked.is_none_or(|looked| looked.elapsed() >= INTERVAL) {
            let asked = Python::attach(|py| -> PyResult<bool> {
                py.check_signals()?;
                let Some(progress) = &self.progress else { return Ok(false) };
                let answer = progress.bind(py).call1((stage, start, steps, elapsed, part))?;
                // Only `False` itself stops the work: a function that returns nothing continues it.
                Ok(answer.is(&*pyo3::types::PyBool::new(py, false)))
            });
            self.stopped = match asked {
                Ok(stop) => stop,
                Err(error) => {
                    self.raised = Some(error);
                    true
                }
            };
            self.looked = Some(Instant::now());
        }
        self.stopped
    }
}

impl Observer for Watch {
    fn on_progress(&mut self, progress: &Progress) -> Control {
        let Progress { rung, start, steps, elapsed, part, .. } = progress;
        let stop = self.stops(rung.name(), start, *steps as u64, *elapsed, part);
        if stop { Control::Stop } else { Control::Continue }
    }
}
