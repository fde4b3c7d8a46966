//! Entries of priority queues.

use std::cmp::Ordering;

/// A target in a [`BinaryHeap`](std::collections::BinaryHeap): the highest rank comes first, and among equal ranks the
/// lowest target, so that every traversal is deterministic.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Ranked<K, T>(pub(crate) K, pub(crate) T);

/// A rank, ordered by `total_cmp`.
pub(crate) trait Rank: Copy {
    fn compare(self, other: Self) -> Ordering;
}

impl Rank for f32 {
    fn compare(self, other: f32) -> Ordering {
        self.total_cmp(&other)
    }
}

impl Rank for f64 {
    fn compare(self, other: f64) -> Ordering {
        self.total_cmp(&other)
    }
}

impl<K: Rank, T: Ord> Ord for Ranked<K, T> {
    fn cmp(&self, other: &Ranked<K, T>) -> Ordering {
        self.0.compare(other.0).then_with(|| other.1.cmp(&self.1))
    }
}

impl<K: Rank, T: Ord> PartialOrd for Ranked<K, T> {
    fn partial_cmp(&self, other: &Ranked<K, T>) -> Option<Ordering> {
        Some(self.cmp(other))
    }
}

impl<K: Rank, T: Ord> PartialEq for Ranked<K, T> {
    fn eq(&self, other: &Ranked<K, T>) -> bool {
        self.cmp(other).is_eq()
    }
}

impl<K: Rank, T: Ord> Eq for Ranked<K, T> {}

#[cfg(test)]
mod tests {
    use super::*;
    use std::collections::BinaryHeap;

    #[test]
    fn the_nearest_comes_first_and_the_lower_number_among_equals() {
        let mut heap = BinaryHeap::from([Ranked(0.5, 7), Ranked(0.25, 1), Ranked(0.5, 2), Ranked(2.0, 9)]);
        let taken: Vec<i32> = std::iter::from_fn(|| heap.pop()).map(|entry| entry.1).collect();
        assert_eq!(taken, [9, 2, 7, 1]);
    }
}
