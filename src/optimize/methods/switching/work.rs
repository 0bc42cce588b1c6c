//! What a search of extremals has done, and whether it is to go on.

use std::cell::Cell;

/// Counts, and whoever may ask to stop: every Newton asks, so that whatever is made of Newtons ends soon.
pub(crate) struct Work<'a> {
    /// Sweeps of smoothed problems.
    pub sweeps: Cell<usize>,
    /// Newtons on switching times.
    pub newtons: Cell<usize>,
    stop: &'a dyn Fn() -> bool,
}

impl<'a> Work<'a> {
    /// None done yet.
    pub fn until(stop: &'a dyn Fn() -> bool) -> Self {
        Self { sweeps: Cell::new(0), newtons: Cell::new(0), stop }
    }

    /// With what somebody else has done.
    pub fn add(&self, other: &Work) {
        self.sweeps.set(self.sweeps.get() + other.sweeps.get());
        self.newtons.set(self.newtons.get() + other.newtons.get());
    }

    pub fn stopped(&self) -> bool {
        (self.stop)()
    }
}

/// Counts one more.
pub(super) fn count(of: &Cell<usize>) {
    of.set(of.get() + 1);
}
