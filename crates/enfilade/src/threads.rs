//! Parallel loops on the current rayon pool, or else the global one.
//!
//! Without the feature `rayon` everything runs on the calling thread.

#[cfg(feature = "rayon")]
use rayon::prelude::*;

/// Returns the number of threads in the pool.
#[cfg(feature = "rayon")]
pub(crate) fn count() -> usize {
    rayon::current_num_threads()
}

/// Returns the number of threads: 1.
#[cfg(not(feature = "rayon"))]
pub(crate) fn count() -> usize {
    1
}

/// Calls `work` with the index and the element for each element of a list, on all threads of the pool. Each idle thread
/// takes the next element.
pub(crate) fn for_each<T: Send>(list: &mut [T], work: impl Fn(usize, &mut T) + Send + Sync) {
    #[cfg(feature = "rayon")]
    if count() > 1 {
        let each = list.par_iter_mut().enumerate().with_max_len(1);
        return each.for_each(|(place, item)| work(place, item));
    }
    for (place, item) in list.iter_mut().enumerate() {
        work(place, item);
    }
}

/// Calls `work` with the index of its first element for each run of `length` elements of a list, on all threads of the
/// pool if `shared`.
pub(crate) fn for_each_run<T: Send>(
    shared: bool,
    list: &mut [T],
    length: usize,
    work: impl Fn(usize, &mut [T]) + Send + Sync,
) {
    #[cfg(feature = "rayon")]
    if shared && count() > 1 && list.len() > length {
        let each = list.par_chunks_mut(length).enumerate();
        return each.for_each(|(run, elements)| work(run * length, elements));
    }
    let _ = shared;
    for (run, elements) in list.chunks_mut(length).enumerate() {
        work(run * length, elements);
    }
}

/// Runs two closures, on two threads if `shared` and the pool has several.
pub(crate) fn join<A: Send, B: Send>(
    shared: bool,
    a: impl FnOnce() -> A + Send,
    b: impl FnOnce() -> B + Send,
) -> (A, B) {
    #[cfg(feature = "rayon")]
    if shared && count() > 1 {
        return rayon::join(a, b);
    }
    let _ = shared;
    (a(), b())
}
