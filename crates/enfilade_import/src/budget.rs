//! What reading may still take.

use crate::BrokenRule;

/// Bytes of memory that are left to a reader. Estimates are taken from it before anything is allocated.
#[derive(Debug)]
pub(crate) struct Budget {
    limit: u64,
    taken: u64,
}

impl Budget {
    pub(crate) fn new(limit: u64) -> Budget {
        Budget { limit, taken: 0 }
    }

    /// Are so many bytes left?
    pub(crate) fn has(&self, bytes: u64) -> bool {
        self.taken.saturating_add(bytes) <= self.limit
    }

    /// Sets `bytes` aside for what stands at `place`.
    pub(crate) fn take(&mut self, bytes: u64, place: impl FnOnce() -> String) -> Result<(), BrokenRule> {
        let taken = self.taken.saturating_add(bytes);
        if taken > self.limit {
            return Err(BrokenRule::TooLarge {
                place: place(),
                needs_bytes: taken,
                limit_bytes: self.limit,
            });
        }
        self.taken = taken;
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_does_not_fit_is_refused_and_takes_nothing() {
        let mut budget = Budget::new(100);
        let mut take = |bytes| budget.take(bytes, String::new).is_ok();
        assert_eq!(
            [60, 41, u64::MAX, 40, 1].map(&mut take),
            [true, false, false, true, false]
        );
    }
}
