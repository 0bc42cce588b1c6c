//! The request to stop the witnesses, and the places where they poll it.

use super::verification::WitnessError;
use std::sync::atomic::{AtomicBool, Ordering};

/// The number of steps between two polls.
const EVERY: usize = 16;

/// Whether the witnesses continue. Witnesses on another thread read the answer that the polling
/// thread stored.
#[derive(Clone, Copy)]
pub(crate) struct Watch<'a> {
    stopped: &'a AtomicBool,
    ask: Option<&'a dyn Fn() -> bool>,
}

impl<'a> Watch<'a> {
    /// Builds a watch that polls `ask` and stores its answer.
    pub(crate) fn new(stopped: &'a AtomicBool, ask: &'a dyn Fn() -> bool) -> Self {
        Self { stopped, ask: Some(ask) }
    }

    /// Returns the flag of this watch, for work on another thread.
    pub(super) fn noted(&self) -> &'a AtomicBool {
        self.stopped
    }

    /// Creates a watch that reads the flag and never calls the caller's function.
    pub(super) fn of(stopped: &'a AtomicBool) -> Self {
        Self { stopped, ask: None }
    }

    /// Asks the caller now whether to stop.
    pub(super) fn ask(&self) {
        if self.ask.is_some_and(|stop| stop()) {
            self.stopped.store(true, Ordering::Relaxed);
        }
    }

    /// Polls the caller at some of the steps and returns whether to stop.
    ///
    /// # Errors
    /// [`WitnessError::Stopped`].
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
