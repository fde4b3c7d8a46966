//! The memory budget of a reader.

use crate::BrokenRule;

/// Bytes of memory that a reader may still use. Estimates are subtracted before anything is allocated.
#[derive(Debug)]
pub(crate) struct Budget {
    limit: u64,
    taken: u64,
}

impl Budget {
    pub(crate) fn new(limit: u64) -> Budget {
        Budget { limit, taken: 0 }
    }

    /// Returns `true` if at least `bytes` bytes are left.
    pub(crate) fn has(&self, bytes: u64) -> bool {
        self.taken.saturating_add(bytes) <= self.limit
    }

    /// Reserves `bytes` bytes for the element `place`, which an error names.
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
