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
    /// Existing folder to which the plan file of each case is written; `None` if plan files are not
    /// written.
    pub plans: Option<PathBuf>,
    /// True if the result lines hold wall times; the files of two runs then differ, although their
    /// inputs are equal.
    pub times: bool,
}

impl Default for Options {
    fn default() -> Self {
        let threads = thread::available_parallelism().map_or(1, |threads| threads.get());
        Self { threads: threads.min(MAX_THREADS), plans: None, times: false }
    }
}
