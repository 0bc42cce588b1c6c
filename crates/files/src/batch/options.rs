//! The options of a run.

use std::path::PathBuf;
use std::thread;

/// The largest number of threads.
pub const MAX_THREADS: usize = 1024;

/// The options of planning the cases; no option changes a result.
#[derive(Clone, Debug)]
pub struct Options {
    /// Number of threads, from 1 to [`MAX_THREADS`].
    pub threads: usize,
    /// A folder that exists, for the plan file of every case.
    pub plans: Option<PathBuf>,
    /// Lines hold wall times; equal inputs then give different files.
    pub times: bool,
}

impl Default for Options {
    fn default() -> Self {
        let threads = thread::available_parallelism().map_or(1, |threads| threads.get());
        Self { threads: threads.min(MAX_THREADS), plans: None, times: false }
    }
}
