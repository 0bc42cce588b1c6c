//! Work shared among the threads of rayon; without the feature `threads`, done by the calling thread.

/// Threads that share the work.
#[cfg(feature = "threads")]
pub(crate) use rayon::current_num_threads as threads;

/// Threads that share the work.
#[cfg(not(feature = "threads"))]
pub(crate) fn threads() -> usize {
    1
}

/// Writes `of(item)` of each item into its place in `results`; a thread takes at least `batch` items at once.
pub(crate) fn fill<T: Sync, R: Send>(
    items: &[T],
    results: &mut [R],
    batch: usize,
    of: impl Fn(&T) -> R + Send + Sync,
) {
    #[cfg(feature = "threads")]
    {
        use rayon::prelude::*;
        let pairs = items.par_iter().zip(results.par_iter_mut());
        pairs.with_min_len(batch).for_each(|(item, result)| *result = of(item));
    }
    #[cfg(not(feature = "threads"))]
    {
        let _ = batch;
        items.iter().zip(results).for_each(|(item, result)| *result = of(item));
    }
}
