//! Distribution of work over the threads of rayon. Without the feature `threads` the calling thread
//! does all work.
//!
//! # Why does a plan use two threads?
//!
//! If a plan has a few hundred steps or more, the replay and the continuous witness under linear
//! torque run on one thread, and the witnesses of the held torque on the other. Before that, an
//! extremal is recorded on one thread while its second order is tested on the other. Neither half
//! reads results of the other, so that the bits of the result do not depend on the number of
//! threads.

use std::sync::Arc;
use std::sync::atomic::AtomicBool;

/// Returns the number of threads that share the work; 1 if the system grants no more.
#[cfg(feature = "threads")]
pub(crate) fn threads() -> usize {
    use std::sync::OnceLock;
    static THREADS: OnceLock<usize> = OnceLock::new();
    *THREADS.get_or_init(|| {
        use std::error::Error;
        let more = std::thread::available_parallelism().map_or(1, |threads| threads.get()) > 1;
        // A query of rayon panics if not all of its threads can be started. They are therefore
        // started here. A program that uses this library may have started them before; only this
        // case is an error without a source.
        let started = || {
            rayon::ThreadPoolBuilder::new()
                .build_global()
                .map_or_else(|error| error.source().is_none(), |()| true)
        };
        if more && started() { rayon::current_num_threads() } else { 1 }
    })
}

/// Returns the number of threads: 1 without the feature `threads`.
#[cfg(not(feature = "threads"))]
pub(crate) fn threads() -> usize {
    1
}

/// Writes `of(item)` of each item to its place in `results`. A thread takes at least `batch` items
/// at a time.
pub(crate) fn fill<T: Sync, R: Send>(
    items: &[T],
    results: &mut [R],
    batch: usize,
    of: impl Fn(&T) -> R + Send + Sync,
) {
    #[cfg(feature = "threads")]
    if threads() > 1 {
        use rayon::prelude::*;
        let pairs = items.par_iter().zip(results.par_iter_mut());
        pairs.with_min_len(batch).for_each(|(item, result)| *result = of(item));
        return;
    }
    let _ = batch;
    items.iter().zip(results).for_each(|(item, result)| *result = of(item));
}

/// Returns the result of `work`, run on `count` threads instead of all available threads. If the
/// system does not grant the threads, the available threads are used.
pub(crate) fn within<R: Send>(count: Option<usize>, work: impl FnOnce() -> R + Send) -> R {
    #[cfg(feature = "threads")]
    if let Some(count) = count
        && let Ok(pool) = rayon::ThreadPoolBuilder::new().num_threads(count).build()
    {
        return pool.install(work);
    }
    let _ = count;
    work()
}

/// Returns the results of `here` and `there`. It runs `there` on another thread, while the calling
/// thread runs `here` and then calls `meanwhile` repeatedly until both are done. Without the
/// feature `threads`, and on a thread of rayon, it runs `here` first and then `there`.
pub(crate) fn both<A, B: Send>(
    here: impl FnOnce() -> A,
    there: impl FnOnce() -> B + Send,
    meanwhile: impl Fn(),
) -> (A, B) {
    #[cfg(feature = "threads")]
    {
        if rayon::current_thread_index().is_some() {
            // `there` could be queued on this thread, which would wait for it.
            return (here(), there());
        }
        use std::sync::mpsc::{RecvTimeoutError, channel};
        const NOW_AND_THEN: std::time::Duration = std::time::Duration::from_millis(20);
        let mut found = None;
        let first = rayon::in_place_scope(|scope| {
            let (done, told) = channel::<()>();
            let found = &mut found;
            scope.spawn(move |_| {
                *found = Some(there());
                drop(done);
            });
            let first = here();
            while told.recv_timeout(NOW_AND_THEN) == Err(RecvTimeoutError::Timeout) {
                meanwhile();
            }
            first
        });
        (first, found.expect("a scope ends after the work in it"))
    }
    #[cfg(not(feature = "threads"))]
    {
        let _ = meanwhile;
        (here(), there())
    }
}

/// Returns the result of `work`, which runs on its own thread, while the calling thread polls
/// `stopped`. If `stopped` returns true, the function sets a flag and returns `None`. The thread
/// then continues alone with its own data, and ends when the work reads the flag. If threads are
/// disabled, or if no thread can be started, the calling thread does the work.
pub(crate) fn unless_stopped<T: Send + 'static>(
    work: impl FnOnce(Arc<AtomicBool>) -> T + Send + 'static,
    stopped: impl Fn() -> bool,
) -> Option<T> {
    let left = Arc::new(AtomicBool::new(false));
    #[cfg(feature = "threads")]
    {
        use std::sync::Mutex;
        use std::sync::atomic::Ordering;
        use std::sync::mpsc::{RecvTimeoutError, channel};
        use std::thread::Builder;
        const NOW_AND_THEN: std::time::Duration = std::time::Duration::from_millis(10);
        // The work is shared, so that it is not lost if the thread cannot be started.
        let shared = Arc::new(Mutex::new(Some(work)));
        let taken = |shared: &Mutex<Option<_>>| shared.lock().ok()?.take();
        let (done, told) = channel();
        let (there, flag) = (Arc::clone(&shared), Arc::clone(&left));
        // The receiver may have been dropped.
        let errand = move || taken(&there).map(|work| done.send(work(flag)));
        let Ok(thread) = Builder::new().spawn(errand) else {
            return taken(&shared).map(|work| work(left));
        };
        loop {
            match told.recv_timeout(NOW_AND_THEN) {
                Ok(result) => return Some(result),
                Err(RecvTimeoutError::Timeout) if stopped() => {
                    left.store(true, Ordering::Relaxed);
                    return None;
                }
                Err(RecvTimeoutError::Timeout) => {}
                Err(RecvTimeoutError::Disconnected) => match thread.join() {
                    Err(panic) => std::panic::resume_unwind(panic),
                    Ok(_) => return None,
                },
            }
        }
    }
    #[cfg(not(feature = "threads"))]
    {
        let _ = stopped;
        Some(work(left))
    }
}

#[cfg(all(test, feature = "threads"))]
mod tests {
    use super::*;
    use std::sync::atomic::Ordering;
    use std::sync::mpsc::channel;
    use std::time::{Duration, Instant};

    #[test]
    fn work_that_is_stopped_is_left_and_ends_by_its_flag() {
        assert_eq!(unless_stopped(|_| 1, || false), Some(1));
        let (done, told) = channel();
        let endless = move |left: Arc<AtomicBool>| {
            while !left.load(Ordering::Relaxed) {
                std::thread::sleep(Duration::from_millis(1));
            }
            done.send(()).unwrap();
        };
        let began = Instant::now();
        assert_eq!(unless_stopped(endless, || began.elapsed() > Duration::from_millis(30)), None);
        told.recv_timeout(Duration::from_secs(20)).expect("the work ends");
    }

    #[test]
    #[should_panic(expected = "of the work")]
    fn a_panic_of_work_on_another_thread_is_one_here() {
        unless_stopped(|_| panic!("of the work"), || false);
    }

    #[test]
    fn both_works_within_a_pool_of_one_thread() {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(1).build().unwrap();
        assert_eq!(pool.install(|| both(|| 1, || 2, || {})), (1, 2));
        assert_eq!(both(|| 1, || 2, || {}), (1, 2));
    }
}
