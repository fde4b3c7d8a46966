//! Disjoint sets of numbers.

/// Disjoint sets, by union-find with path halving.
#[derive(Clone, Debug, Default)]
pub(super) struct Sets {
    parents: Vec<u32>,
}

impl Sets {
    pub(super) fn new(count: usize) -> Sets {
        Sets {
            parents: (0..count as u32).collect(),
        }
    }

    pub(super) fn len(&self) -> usize {
        self.parents.len()
    }

    pub(super) fn clear(&mut self) {
        self.parents.clear();
    }

    /// Adds a set of one new number, and returns the number.
    pub(super) fn add(&mut self) -> u32 {
        let number = self.parents.len() as u32;
        self.parents.push(number);
        number
    }

    /// Returns the representative of the set that contains `number`.
    pub(super) fn find(&mut self, number: u32) -> u32 {
        let mut at = number;
        loop {
            let parent = self.parents[at as usize];
            if parent == at {
                return at;
            }
            let above = self.parents[parent as usize];
            self.parents[at as usize] = above;
            at = above;
        }
    }

    /// Joins two sets, given by their representatives; `kept` represents both.
    pub(super) fn join(&mut self, kept: u32, gone: u32) {
        self.parents[gone as usize] = kept;
    }
}
