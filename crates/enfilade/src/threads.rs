//! The threads that work may be shared among: those of the rayon pool that one is in, or else of the global one.
//!
//! Without the feature `rayon` there is one.

#[cfg(feature = "rayon")]
use rayon::prelude::*;

/// How many there are.
#[cfg(feature = "rayon")]
pub(crate) fn count() -> usize {
    rayon::current_num_threads()
}

/// How many there are.
#[cfg(not(feature = "rayon"))]
pub(crate) fn count() -> usize {
    1
}

/// Does some work on each of a list, which is told its place: each is taken by whatever thread is free.
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

/// Does two pieces of work, on two threads if `shared` and there are some.
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
