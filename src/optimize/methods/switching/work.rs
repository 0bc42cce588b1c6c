//! Work counters of a search of extremals, and requests to stop it.

use crate::optimize::methods::method::Watch;
use std::cell::Cell;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::Instant;

/// Work counters, and the watch that may stop the search. Every Newton iteration polls it, so that
/// anything that consists of Newton iterations stops soon.
pub(crate) struct Work<'a> {
    /// Number of sweeps over paths of smoothed problems.
    pub sweeps: Cell<usize>,
    /// Number of Newton runs for switching times.
    pub newtons: Cell<usize>,
    watch: Watch<'a>,
}

impl<'a> Work<'a> {
    /// Creates counters at zero, with the watch that may stop the search.
    pub fn of(watch: Watch<'a>) -> Self {
        Self { sweeps: Cell::new(0), newtons: Cell::new(0), watch }
    }

    pub fn stopped(&self) -> bool {
        self.watch.stopped()
    }
}

/// A request to stop that long loops poll: it is raised if the flag of the observer is set or the
/// deadline has passed.
#[derive(Clone, Debug, Default)]
pub(crate) struct StopRequest {
    flag: Option<Arc<AtomicBool>>,
    deadline: Option<Instant>,
}

impl StopRequest {
    /// Number of steps of a sweep between two checks for a stop request.
    const POLLED: usize = 4096;

    /// Creates the request from the flag and the deadline of a watch.
    pub fn of(watch: &Watch) -> Self {
        Self { flag: watch.flag.cloned(), deadline: watch.deadline }
    }

    /// Returns whether the flag is set or the deadline has passed.
    pub fn is_raised(&self) -> bool {
        self.flag.as_ref().is_some_and(|flag| flag.load(Ordering::Relaxed))
            || self.deadline.is_some_and(|deadline| Instant::now() >= deadline)
    }

    /// Returns whether a stop is requested, for a loop over steps; polls only at every
    /// `Self::POLLED`-th step.
    pub fn is_raised_at(&self, step: usize) -> bool {
        step.is_multiple_of(Self::POLLED) && self.is_raised()
    }
}

/// Increments a counter.
pub(super) fn count(of: &Cell<usize>) {
    of.set(of.get() + 1);
}
