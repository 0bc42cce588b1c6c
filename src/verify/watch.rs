//! The request to stop the witnesses, and the functions that poll it.

use super::verification::WitnessError;
use std::sync::atomic::{AtomicBool, Ordering};

/// Number of steps of a witness between two checks for a stop request.
const EVERY: usize = 16;

/// The decision whether the witnesses continue. One thread polls the caller and stores the answer;
/// witnesses on other threads read it.
#[derive(Clone, Copy)]
pub(crate) struct Watch<'a> {
    stopped: &'a AtomicBool,
    ask: Option<&'a dyn Fn() -> bool>,
}

impl<'a> Watch<'a> {
    /// Builds a watch that polls `ask` and stores its answer in `stopped`.
    pub(crate) fn new(stopped: &'a AtomicBool, ask: &'a dyn Fn() -> bool) -> Self {
        Self { stopped, ask: Some(ask) }
    }

    /// Returns the stop flag of this watch, for work on another thread.
    pub(super) fn noted(&self) -> &'a AtomicBool {
        self.stopped
    }

    /// Builds a watch that only reads the flag and never polls the caller.
    pub(super) fn of(stopped: &'a AtomicBool) -> Self {
        Self { stopped, ask: None }
    }

    /// Polls the caller now, and stores a request to stop.
    pub(super) fn ask(&self) {
        if self.ask.is_some_and(|stop| stop()) {
            self.stopped.store(true, Ordering::Relaxed);
        }
    }

    /// Polls the caller at every sixteenth step.
    ///
    /// # Errors
    /// [`WitnessError::Stopped`] if a stop was requested.
    #[inline]
    pub(super) fn step(&self, step: usize) -> Result<(), WitnessError> {
        if step.is_multiple_of(EVERY) {
            self.ask();
            if self.stopped.load(Ordering::Relaxed) {
                return Err(WitnessError::Stopped);
            }
        }
        Ok(())
    }
}
