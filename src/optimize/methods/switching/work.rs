//! What a search of extremals has done, and whether it is to go on.

use crate::optimize::methods::method::Watch;
use std::cell::Cell;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::Instant;

/// Counts, and who may end the work early: every Newton asks, so that whatever is made of Newtons
/// ends soon.
pub(crate) struct Work<'a> {
    /// Sweeps of smoothed problems.
    pub sweeps: Cell<usize>,
    /// Newtons on switching times.
    pub newtons: Cell<usize>,
    watch: Watch<'a>,
}

impl<'a> Work<'a> {
    /// None done yet.
    pub fn of(watch: Watch<'a>) -> Self {
        Self { sweeps: Cell::new(0), newtons: Cell::new(0), watch }
    }

    pub fn stopped(&self) -> bool {
        self.watch.stopped()
    }
}

/// A request to stop that long loops look at: the flag of the observer, or the end of the time
/// limit.
#[derive(Clone, Debug, Default)]
pub(crate) struct StopRequest {
    flag: Option<Arc<AtomicBool>>,
    deadline: Option<Instant>,
}

impl StopRequest {
    /// Steps of a sweep after which it looks again.
    const POLLED: usize = 4096;

    /// Returns the request that a watch hears.
    pub fn of(watch: &Watch) -> Self {
        Self { flag: watch.flag.cloned(), deadline: watch.deadline }
    }

    /// Returns whether somebody asks to stop.
    pub fn is_raised(&self) -> bool {
        self.flag.as_ref().is_some_and(|flag| flag.load(Ordering::Relaxed))
            || self.deadline.is_some_and(|deadline| Instant::now() >= deadline)
    }

    /// Returns the same for a loop over steps, which looks at a few of them only.
    pub fn is_raised_at(&self, step: usize) -> bool {
        step.is_multiple_of(Self::POLLED) && self.is_raised()
    }
}

/// Counts one more.
pub(super) fn count(of: &Cell<usize>) {
    of.set(of.get() + 1);
}
