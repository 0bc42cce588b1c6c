//! Planning of cases on several threads, with results in the order of the cases.
//!
//! Workers take the next case from one stream. A result that is finished early waits for its
//! predecessors. At most [`WINDOW`] results wait, which limits how far a worker is ahead, and the
//! memory.

use super::{Batch, BatchError, Case, CaseResult, MAX_THREADS, Options, Shard, Stream, solve};
use std::collections::BTreeMap;
use std::io;
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::mpsc::{self, RecvTimeoutError};
use std::sync::{Condvar, Mutex, MutexGuard, PoisonError};
use std::thread;
use std::time::Duration;

/// Largest number of results that wait for an earlier case.
const WINDOW: u64 = 4096;
/// Stack size of a worker \[bytes\], equal to the stack size of the main thread, so that a case
/// that runs in one thread also runs in the other.
const STACK: usize = 8 << 20;
/// Interval at which the caller's function `tick` is called.
const TICK: Duration = Duration::from_millis(100);

/// How a run ended.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Ended {
    /// Every case has a result.
    Complete,
    /// The caller stopped the run.
    Stopped,
}

/// Queue of the remaining cases, with counters of the taken and the written ones.
struct Queue<'a> {
    cases: Stream<'a>,
    /// Number of cases that workers have taken.
    taken: u64,
    /// Number of results that have been written.
    written: u64,
}

/// Data that the workers and the writer share.
struct Shared<'a> {
    queue: Mutex<Queue<'a>>,
    moved: Condvar,
    /// True if no further case may start and running cases must stop.
    over: AtomicBool,
}

impl<'a> Shared<'a> {
    fn queue(&self) -> MutexGuard<'_, Queue<'a>> {
        self.queue.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// Returns the next case and its index in the shard, as soon as its result is within the window
    /// of waiting results; `None` when no case is left or the run is over.
    fn next(&self) -> Option<(u64, Result<Case, BatchError>)> {
        let mut queue = self.queue();
        while queue.taken >= queue.written + WINDOW && !self.over.load(Ordering::Relaxed) {
            queue = self.moved.wait(queue).unwrap_or_else(PoisonError::into_inner);
        }
        if self.over.load(Ordering::Relaxed) {
            return None;
        }
        let case = queue.cases.next()?;
        queue.taken += 1;
        Some((queue.taken - 1, case))
    }

    fn wrote(&self, written: u64) {
        self.queue().written = written;
        self.moved.notify_all();
    }

    fn end(&self) {
        self.over.store(true, Ordering::Relaxed);
        drop(self.queue());
        self.moved.notify_all();
    }
}

/// Plans the cases of a shard except the first `done`. Passes each result to `take` in the order of
/// the cases, as a value and as a line of the file. `stop` is polled often, from all threads;
/// `tick` is called ten times per second.
///
/// # Errors
/// Returns the error of `take`, of the table or of a plan file, or an error if the system cannot
/// create a thread.
pub fn run(
    batch: &Batch,
    shard: Shard,
    done: u64,
    options: &Options,
    stop: &(dyn Fn() -> bool + Sync),
    take: &mut dyn FnMut(&CaseResult, &str) -> Result<(), BatchError>,
    tick: &mut dyn FnMut(),
) -> Result<Ended, BatchError> {
    let wanted = shard.count(batch.count()).saturating_sub(done);
    let queue = Queue { cases: batch.stream(shard, done)?, taken: 0, written: 0 };
    let shared = Shared { queue: Mutex::new(queue), moved: Condvar::new(), over: AtomicBool::new(false) };
    let written = thread::scope(|scope| {
        let (sender, finished) = mpsc::channel();
        let mut refused = None;
        for _ in 0..options.threads.clamp(1, MAX_THREADS).min(wanted.try_into().unwrap_or(MAX_THREADS)) {
            let (shared, sender) = (&shared, sender.clone());
            let work = move || {
                let stop = || shared.over.load(Ordering::Relaxed) || stop();
                while let Some((place, case)) = shared.next() {
                    let result = case.and_then(|case| solve::result(batch, &case, options, &stop));
                    let line = result.transpose().map(|result| result.and_then(with_line));
                    // The writer may have ended with an error.
                    if line.is_none_or(|line| sender.send((place, line)).is_err()) {
                        break;
                    }
                }
            };
            if let Err(error) = thread::Builder::new().stack_size(STACK).spawn_scoped(scope, work) {
                refused = Some(error);
                break;
            }
        }
        drop(sender);
        let written = write(&shared, &finished, stop, take, tick);
        shared.end();
        match (written, refused) {
            // Fewer threads than requested do the same work.
            (Ok(0), Some(error)) if wanted > 0 && !stop() => Err(no_thread(&error)),
            (written, _) => written,
        }
    })?;
    Ok(if written == wanted { Ended::Complete } else { Ended::Stopped })
}

fn no_thread(error: &io::Error) -> BatchError {
    let reason = format!("the system grants no thread: {error}");
    BatchError::argument("E0115", reason, "allow more processes (`ulimit -u`), or more memory")
}

/// Returns a result together with its line of JSON.
fn with_line(result: CaseResult) -> Result<(CaseResult, String), BatchError> {
    let line = serde_json::to_string(&result).map_err(crate::export::ExportError::from)?;
    Ok((result, line))
}

type Finished = (u64, Result<(CaseResult, String), BatchError>);

/// Passes the results on in the order of the cases until all workers have ended; returns the number
/// of results.
fn write(
    shared: &Shared<'_>,
    finished: &mpsc::Receiver<Finished>,
    stop: &(dyn Fn() -> bool + Sync),
    take: &mut dyn FnMut(&CaseResult, &str) -> Result<(), BatchError>,
    tick: &mut dyn FnMut(),
) -> Result<u64, BatchError> {
    let (mut written, mut early) = (0, BTreeMap::new());
    loop {
        match finished.recv_timeout(TICK) {
            Ok((place, result)) => {
                early.insert(place, result);
                while let Some(result) = early.remove(&written) {
                    let (result, line) = result?;
                    take(&result, &line)?;
                    written += 1;
                    shared.wrote(written);
                }
            }
            Err(RecvTimeoutError::Disconnected) => return Ok(written),
            Err(RecvTimeoutError::Timeout) => {}
        }
        if stop() {
            shared.end();
        }
        tick();
    }
}
