//! Progress reports to Python. A computation stops on Ctrl-C, or if the caller's progress function
//! returns `False` or raises an exception.

use pyo3::prelude::*;
use slewkit::plan::{Control, Observer, Progress};
use std::time::{Duration, Instant};

/// Shortest interval between two checks for signals or calls of the progress function. It is
/// limited because taking the lock of a busy interpreter costs milliseconds.
const INTERVAL: Duration = Duration::from_millis(50);

/// Observer of a computation, which calls the progress function and checks for signals.
pub struct Watch {
    progress: Option<Py<PyAny>>,
    looked: Option<Instant>,
    /// Exception that the progress function or a signal raised; `None` if none was raised.
    raised: Option<PyErr>,
    stopped: bool,
}

impl Watch {
    /// Creates an observer that calls `progress` at once and then repeatedly. The computation stops
    /// if `progress` returns `False`.
    pub fn new(progress: Option<Py<PyAny>>) -> Self {
        // Without a progress function, signals are first checked after one interval, so that a
        // short computation is never interrupted.
        let looked = if progress.is_some() { None } else { Some(Instant::now()) };
        Self { progress, looked, raised: None, stopped: false }
    }

    /// Returns the exception that was raised during the computation, if any.
    pub fn raised(self) -> Option<PyErr> {
        self.raised
    }

    /// Passes the current stage to the progress function. Returns true if the computation must
    /// stop.
    pub fn stops(&mut self, stage: &str, start: &str, steps: u64, elapsed: f64, part: &str) -> bool {
        if !self.stopped && self.looked.is_none_or(|looked| looked.elapsed() >= INTERVAL) {
            let asked = Python::attach(|py| -> PyResult<bool> {
                py.check_signals()?;
                let Some(progress) = &self.progress else { return Ok(false) };
                let answer = progress.bind(py).call1((stage, start, steps, elapsed, part))?;
                // Only `False` stops the computation. A progress function without a return value
                // returns `None`, which does not stop it.
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
