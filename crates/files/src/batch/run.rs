//! Planning of cases on several threads, with results in the order of the cases.
//!
//! Workers take the next case from one stream. If a result is finished before the results of
//! earlier cases, it waits for them. At most [`WINDOW`] results wait, which limits the memory and
//! how far one worker can be ahead of another.

use super::{Batch, BatchError, Case, CaseResult, MAX_THREADS, Options, Shard, Stream, solve};
use std::collections::BTreeMap;
use std::io;
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::mpsc::{self, RecvTimeoutError};
use std::sync::{Condvar, Mutex, MutexGuard, PoisonError};
use std::thread;
use std::time::Duration;

/// Largest number of results that wait for the result of an earlier case.
const WINDOW: u64 = 4096;
/// Stack size of a worker thread \[bytes\]. It equals the stack size of the main thread, so that a
/// case succeeds in either thread.
const STACK: usize = 8 << 20;
/// Interval between two calls of the caller's function `tick`.
const TICK: Duration = Duration::from_millis(100);

/// Reason why a run ended.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Ended {
    /// Every case has a result.
    Complete,
    /// The caller stopped the run.
    Stopped,
}

/// Queue of the remaining cases, with the numbers of cases taken and results written.
struct Queue<'a> {
    cases: Stream<'a>,
    /// Number of cases that workers have taken.
    taken: u64,
    /// Number of results that have been written.
    written: u64,
}

/// Data shared by the worker threads and the thread that writes the results.
struct Shared<'a> {
    queue: Mutex<Queue<'a>>,
    moved: Condvar,
    /// True if the run is over: no further case may start, and running cases must stop.
    over: AtomicBool,
}

impl<'a> Shared<'a> {
    fn queue(&self) -> MutexGuard<'_, Queue<'a>> {
        self.queue.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// Waits until the result of the next case fits into the window of waiting results; then
    /// returns the case with its index in the shard. Returns `None` if no case is left or the run
    /// is over.
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

/// Plans the cases of `shard`, skipping the first `done`. Passes each result to `take` in the order
/// of the cases, as a value and as a line of the file. All threads call `stop` often; the run ends
/// when it returns true. `tick` is called ten times per second.
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
                    // Sending fails if the writer has ended with an error.
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
            // If a thread cannot be created, the existing threads plan all cases.
            (Ok(0), Some(error)) if wanted > 0 && !stop() => Err(no_thread(&error)),
            (written, _) => written,
        }
    })?;
    Ok(if written == wanted { Ended::Complete } else { Ended::Stopped })
}

fn no_thread(error: &io::Error) -> BatchError {
    let reason = format!("the system cannot create a thread: {error}");
    BatchError::argument("E0115", reason, "allow more processes (`ulimit -u`), or more memory")
}

/// Returns a result together with its line of JSON.
fn with_line(result: CaseResult) -> Result<(CaseResult, String), BatchError> {
    let line = serde_json::to_string(&result).map_err(crate::export::ExportError::from)?;
    Ok((result, line))
}

type Finished = (u64, Result<(CaseResult, String), BatchError>);

/// Passes the results to the caller in the order of the cases until all workers have ended. Returns
/// the number of results.
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
