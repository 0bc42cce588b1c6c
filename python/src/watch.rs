//! Reports progress to Python. A computation stops if the caller's progress function returns
//! `False` or raises an exception, or on Ctrl-C.

use pyo3::prelude::*;
use slewkit::plan::{Control, Observer, Progress};
use std::time::{Duration, Instant};

/// The smallest interval between two checks of signals or calls of the progress function. Taking
/// the lock of a busy interpreter costs milliseconds.
const INTERVAL: Duration = Duration::from_millis(50);

/// The observer of a computation, which calls the progress function and checks signals.
pub struct Watch {
    progress: Option<Py<PyAny>>,
    looked: Option<Instant>,
    /// The exception that the progress function or a signal raised.
    raised: Option<PyErr>,
    stopped: bool,
}

impl Watch {
    /// Builds an observer that calls `progress` immediately and then repeatedly. If `progress`
    /// returns `False`, the work stops.
    pub fn new(progress: Option<Py<PyAny>>) -> Self {
        // Without a progress function, signals are first checked after one interval, so short work
        // is never interrupted.
        let looked = if progress.is_some() { None } else { Some(Instant::now()) };
        Self { progress, looked, raised: None, stopped: false }
    }

    /// Returns the exception that was raised during the work.
    pub fn raised(self) -> Option<PyErr> {
        self.raised
    }

    /// Passes the current stage to the progress function, and returns whether to stop.
    pub fn stops(&mut self, stage: &str, start: &str, steps: u64, elapsed: f64, part: &str) -> bool {
        if !self.stopped && self.looked.is_none_or(|looked| looked.elapsed() >= INTERVAL) {
            let asked = Python::attach(|py| -> PyResult<bool> {
                py.check_signals()?;
                let Some(progress) = &self.progress else { return Ok(false) };
                let answer = progress.bind(py).call1((stage, start, steps, elapsed, part))?;
                // Only `False` stops the work. A progress function without a return value returns
                // `None`, which continues it.
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
