//! Many short lists of `u32` in one shared array, each with spare capacity; freed memory is reused.
//!
//! Cost: O(1) to append, O(length) to remove; a list is reallocated when its capacity is exhausted.

/// Storage for many lists of `u32` in one array.
#[derive(Clone, Debug, Default)]
pub(crate) struct Runs {
    all: Vec<u32>,
    spare: FreeList,
}

/// Handle of one list in [`Runs`]: its start, length and capacity.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Run {
    start: u32,
    len: u32,
    room: u32,
}

impl Run {
    pub(crate) const EMPTY: Run = Run {
        start: 0,
        len: 0,
        room: 0,
    };

    pub(crate) fn len(&self) -> usize {
        self.len as usize
    }
}

impl Runs {
    /// Returns the elements of a list.
    pub(crate) fn get(&self, run: Run) -> &[u32] {
        &self.all[run.start as usize..(run.start + run.len) as usize]
    }

    /// Creates a list. If it is appended to the array it gets no spare capacity, because most lists never grow.
    pub(crate) fn put(&mut self, numbers: &[u32]) -> Run {
        let len = numbers.len() as u32;
        if len == 0 {
            return Run::EMPTY;
        }
        let mut room = len.next_power_of_two();
        let start = self.spare.take(room).unwrap_or_else(|| {
            room = len;
            self.all.resize(self.all.len() + numbers.len(), 0);
            self.all.len() as u32 - len
        });
        self.all[start as usize..start as usize + numbers.len()].copy_from_slice(numbers);
        Run { start, len, room }
    }

    /// Appends a number to a list.
    pub(crate) fn push(&mut self, run: &mut Run, number: u32) {
        if run.len == run.room {
            let room = (run.len + 1).next_power_of_two();
            let start = self.spare.take(room).unwrap_or_else(|| {
                self.all.resize(self.all.len() + room as usize, 0);
                self.all.len() as u32 - room
            });
            let old = run.start as usize..(run.start + run.len) as usize;
            self.all.copy_within(old, start as usize);
            self.spare.give(run.start, run.room);
            [run.start, run.room] = [start, room];
        }
        self.all[(run.start + run.len) as usize] = number;
        run.len += 1;
    }

    /// Removes a number from a list by moving the last element into its slot. Returns `true` if the list contained it.
    pub(crate) fn remove(&mut self, run: &mut Run, number: u32) -> bool {
        let Some(index) = self.get(*run).iter().position(|&other| other == number) else {
            return false;
        };
        run.len -= 1;
        self.all[run.start as usize + index] = self.all[(run.start + run.len) as usize];
        if run.len == 0 {
            self.clear(run);
        }
        true
    }

    /// Empties a list and frees its memory for other lists.
    pub(crate) fn clear(&mut self, run: &mut Run) {
        self.spare.give(run.start, run.room);
        *run = Run::EMPTY;
    }

    /// Returns the memory in use, in bytes.
    pub(crate) fn bytes(&self) -> usize {
        self.all.len() * size_of::<u32>() + self.spare.bytes()
    }
}

/// Free blocks of an array, in size classes that are powers of two.
#[derive(Clone, Debug, Default)]
pub(super) struct FreeList {
    starts: Vec<Vec<u32>>,
    len: usize,
}

impl FreeList {
    /// Allocates a block of `room` elements (a power of two) and returns its start; `None` if no free block is large
    /// enough.
    pub(super) fn take(&mut self, room: u32) -> Option<u32> {
        let least = room.ilog2() as usize;
        let size = (least..self.starts.len()).find(|&size| !self.starts[size].is_empty())?;
        let start = self.starts[size].pop()?;
        self.len -= 1 << size;
        self.give(start + room, (1 << size) - room);
        Some(start)
    }

    /// Frees a block.
    pub(super) fn give(&mut self, mut start: u32, mut room: u32) {
        self.len += room as usize;
        while room > 0 {
            let size = room.ilog2();
            if self.starts.len() <= size as usize {
                self.starts.resize(size as usize + 1, Vec::new());
            }
            self.starts[size as usize].push(start);
            start += 1 << size;
            room -= 1 << size;
        }
    }

    /// Returns the number of free elements.
    pub(super) fn len(&self) -> usize {
        self.len
    }

    /// Returns the memory in use, in bytes.
    pub(super) fn bytes(&self) -> usize {
        let starts: usize = self.starts.iter().map(Vec::len).sum();
        starts * size_of::<u32>() + self.starts.len() * size_of::<Vec<u32>>()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn lists_that_grow_and_shrink_hold_what_they_were_given() {
        let mut runs = Runs::default();
        let mut lists: Vec<Vec<u32>> = (0..50).map(|i| (0..i % 7).collect()).collect();
        let mut kept: Vec<Run> = lists.iter().map(|list| runs.put(list)).collect();
        for step in 7..100_000_u32 {
            let which = (step.wrapping_mul(2_654_435_761) >> 16) as usize % lists.len();
            let (list, run) = (&mut lists[which], &mut kept[which]);
            // Every list goes through phases of growing and of shrinking.
            if (step >> 12 ^ which as u32) & 1 == 0 && list.len() < 100 {
                list.push(step);
                runs.push(run, step);
            } else if let Some(&number) = list.get(step as usize % list.len().max(1)) {
                list.retain(|&other| other != number);
                assert!(runs.remove(run, number) && !runs.remove(run, number));
            }
        }
        for (list, run) in lists.iter_mut().zip(kept) {
            let mut held = runs.get(run).to_vec();
            list.sort();
            held.sort();
            assert_eq!(*list, held);
        }
        assert!(runs.bytes() < 50 * 400 * size_of::<u32>(), "{}", runs.bytes());
    }
}
