//! Options of a run of a batch.

use std::path::PathBuf;
use std::thread;

/// Largest number of threads.
pub const MAX_THREADS: usize = 1024;

/// Options for planning the cases of a batch; no option changes a plan.
#[derive(Clone, Debug)]
pub struct Options {
    /// Number of threads, from 1 to [`MAX_THREADS`].
    pub threads: usize,
    /// An existing folder into which the plan file of every case is written; `None` to write no
    /// plan files.
    pub plans: Option<PathBuf>,
    /// True if result lines hold wall times; equal inputs then give different files.
    pub times: bool,
}

impl Default for Options {
    fn default() -> Self {
        let threads = thread::available_parallelism().map_or(1, |threads| threads.get());
        Self { threads: threads.min(MAX_THREADS), plans: None, times: false }
    }
}
