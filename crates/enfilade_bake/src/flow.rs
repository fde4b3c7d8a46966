//! Recursive portal flow: follows chains of ways, clipping the source and the current way against each other.
//!
//! The flow continues from a cell through every way out of it. It clips that way to the separating planes of the source
//! and the previous way, then clips the source likewise. A chain ends when either winding is empty. A chain continues
//! only while an undecided way may follow in it: most ways are proven visible by a sampled ray, or were decided from
//! their own end.
//! Source: Teller 1992, section 3.3; the set of undecided ways and the look-ahead are new.
//! Cost: the number of chains grows with the openness of the world; each step clips two windings of a few corners.
//! Conservative: each cut is made outside the plane by its rounding error. A chain enters no cell twice, because a ray
//! leaves a convex cell for good.

use crate::bits::{BitRows, has, put};
use crate::passages::Passages;
use crate::separators::Separators;
use crate::ways::Ways;
use crate::winding::{ClipResult, clip};
use glam::DVec3;

/// One way of a chain.
#[derive(Debug, Default)]
struct Step {
    way: usize,
    /// The part of the way visible from the source.
    pass: Vec<DVec3>,
    /// The part of the source visible from the way.
    source: Vec<DVec3>,
    /// Separating planes of `source` and `pass`.
    planes: Separators,
    /// Words of the ways that may follow in the chain.
    may: Vec<u64>,
    /// The undecided ways among those: nonzero words with their indices.
    undecided: Vec<(u32, u64)>,
    /// The next way to try out of the cell that `way` enters.
    next: usize,
}

impl Step {
    /// Returns `true` if a way is undecided and may follow in the chain.
    fn is_undecided(&self, way: usize) -> bool {
        let at = self
            .undecided
            .binary_search_by_key(&((way / 64) as u32), |&(number, _)| number);
        at.is_ok_and(|at| self.undecided[at].1 >> (way % 64) & 1 != 0)
    }
}

/// An undecided way that a chain has reached.
#[derive(Debug)]
pub(crate) struct ChainEnd<'a> {
    pub(crate) way: usize,
    /// Whether this is the first chain that reaches it.
    pub(crate) first: bool,
    /// The part of the source visible from the way.
    pub(crate) source: &'a [DVec3],
    /// The part of the way visible from the source.
    pub(crate) target: &'a [DVec3],
    between: &'a [Step],
}

impl ChainEnd<'_> {
    /// Returns all windings that a ray from the source to the way must cross, including those two.
    pub(crate) fn windings(&self) -> impl Iterator<Item = &[DVec3]> {
        let between = self.between.iter().map(|step| step.pass.as_slice());
        [self.source, self.target].into_iter().chain(between)
    }
}

/// Buffers of the flow, reused between sources.
#[derive(Debug, Default)]
pub(crate) struct Flow {
    steps: Vec<Step>,
    reached: Vec<u64>,
    after: PassageRows,
    in_chain: Vec<bool>,
    scratch: Vec<DVec3>,
    planes: Separators,
}

/// Cache of the ways that may follow passages, restricted to the nonzero words of the source's bound. Chains use the
/// same passages repeatedly, and whole rows of large worlds exceed the CPU caches.
#[derive(Debug, Default)]
struct PassageRows {
    /// Indices of the nonzero words of the source's bound.
    words: Vec<u32>,
    /// For each word index, its slot in `words`, or [`NO_SLOT`].
    slots: Vec<u32>,
    /// For each passage, the start of its row in `rows` and the run that stored it.
    starts: Vec<[u32; 2]>,
    run: u32,
    rows: Vec<u64>,
}

/// Slot of a zero word.
const NO_SLOT: u32 = u32::MAX;

/// The ways that may follow one passage.
#[derive(Clone, Copy)]
struct PassageRow<'a> {
    slots: &'a [u32],
    words: &'a [u64],
}

impl PassageRow<'_> {
    /// Returns a word by its index; the source's bound must be nonzero there.
    fn word(&self, number: u32) -> u64 {
        self.words[self.slots[number as usize] as usize]
    }
}

impl PassageRows {
    /// Maximum number of cached words.
    const MAX_WORDS: usize = 1 << 20;

    fn begin(&mut self, bound: &[u64], passages: usize) {
        self.words.clear();
        self.slots.clear();
        for (number, &word) in (0..).zip(bound) {
            let slot = if word == 0 {
                NO_SLOT
            } else {
                self.words.push(number);
                self.words.len() as u32 - 1
            };
            self.slots.push(slot);
        }
        self.starts.resize(passages, [0; 2]);
        self.forget();
    }

    fn forget(&mut self) {
        self.rows.clear();
        self.run = self.run.wrapping_add(1);
        if self.run == 0 {
            self.starts.fill([0; 2]);
            self.run = 1;
        }
    }

    /// Gathers into `words` the words of a full row.
    fn take(&self, row: &[u64], words: &mut Vec<u64>) {
        words.clear();
        words.extend(self.words.iter().map(|&number| row[number as usize]));
    }

    /// Returns `true` if `set` contains a way.
    fn has(&self, set: &[u64], way: usize) -> bool {
        let slot = self.slots[way / 64];
        slot != NO_SLOT && set[slot as usize] >> (way % 64) & 1 != 0
    }

    /// Returns the ways that may follow a passage.
    fn passage(
        &mut self,
        ways: &Ways,
        bound: &BitRows,
        passages: &Passages,
        [first, second]: [usize; 2],
    ) -> PassageRow<'_> {
        let number = passages.number(ways, first, second);
        let [mut start, run] = self.starts[number];
        if run != self.run {
            if self.rows.len() + self.words.len() > PassageRows::MAX_WORDS {
                self.forget();
            }
            start = self.rows.len() as u32;
            self.starts[number] = [start, self.run];
            self.rows.resize(self.rows.len() + self.words.len(), 0);
            let (of_second, row) = (bound.row(second), &mut self.rows[start as usize..]);
            for (number, of_passage) in passages.after(ways, first, second) {
                let slot = self.slots[number];
                if slot != NO_SLOT {
                    row[slot as usize] = of_second[number] & of_passage;
                }
            }
        }
        PassageRow {
            slots: &self.slots,
            words: &self.rows[start as usize..][..self.words.len()],
        }
    }
}

impl Flow {
    /// Follows chains from `source` to the ways in `undecided`; returns the ways reached. Ways that remain in
    /// `undecided` and are not reached are not visible.
    ///
    /// `met` is called for each chain that reaches such a way. It may clear the way, so that no more chains are
    /// followed to it, and any other way proven visible.
    pub(crate) fn run(
        &mut self,
        ways: &Ways,
        bound: &BitRows,
        passages: &Passages,
        source: usize,
        undecided: &mut [u64],
        mut met: impl FnMut(&mut [u64], &ChainEnd),
    ) -> &[u64] {
        self.reached.clear();
        self.reached.resize(bound.words_in_row(), 0);
        self.after.begin(bound.row(source), passages.count());
        self.in_chain.clear();
        self.in_chain.resize(ways.cells(), false);
        let first = &ways.all[source];
        self.in_chain[first.from as usize] = true;
        self.in_chain[first.to as usize] = true;
        if self.steps.is_empty() {
            self.steps.push(Step::default());
        }
        let step = &mut self.steps[0];
        step.way = source;
        step.pass.clone_from(&first.corners);
        step.source.clone_from(&first.corners);
        step.planes.clear();
        self.after.take(bound.row(source), &mut step.may);
        step.undecided.clear();
        step.undecided.extend(
            (0..)
                .zip(undecided.iter().copied())
                .filter(|&(_, word)| word != 0),
        );
        step.next = ways.out_of(first.to).start;
        let mut depth = 0;
        loop {
            let step = &mut self.steps[depth];
            let last = &ways.all[step.way];
            if step.next == ways.out_of(last.to).end {
                if depth == 0 {
                    return &self.reached;
                }
                self.in_chain[last.to as usize] = false;
                depth -= 1;
                continue;
            }
            let number = step.next;
            step.next += 1;
            let way = &ways.all[number];
            if self.in_chain[way.to as usize] || !self.after.has(&step.may, number) {
                continue;
            }
            if self.steps.len() == depth + 1 {
                self.steps.push(Step::default());
            }
            let (before, after) = self.steps.split_at_mut(depth + 1);
            let (step, next) = (&before[depth], &mut after[0]);
            // Undecided ways that may follow after this one.
            let after = self.after.passage(ways, bound, passages, [step.way, number]);
            next.undecided.clear();
            next.undecided
                .extend(step.undecided.iter().filter_map(|&(number, word)| {
                    let word = word & undecided[number as usize] & after.word(number);
                    (word != 0).then_some((number, word))
                }));
            let any = !next.undecided.is_empty();
            // Not in all of `undecided`: chains that another way keeps going would reach some ways that the planes exclude.
            let here = has(undecided, number) && step.is_undecided(number);
            if !any && !here {
                continue;
            }
            // Clip the way, then the source.
            let target = &mut next.pass;
            target.clone_from(&way.corners);
            if clip(target, &first.plane, &mut self.scratch) == ClipResult::Nothing {
                continue;
            }
            let windings: [&[DVec3]; 2] = [&step.source, &step.pass];
            if step.planes.clip(ways, windings, target, &mut self.scratch) == ClipResult::Nothing {
                continue;
            }
            next.source.clone_from(&step.source);
            if clip(&mut next.source, &way.plane.flipped(), &mut self.scratch) == ClipResult::Nothing {
                continue;
            }
            if depth > 0 {
                let windings: [&[DVec3]; 2] = [&next.pass, &step.pass];
                self.planes.find(ways, windings, true);
                if self
                    .planes
                    .clip(ways, windings, &mut next.source, &mut self.scratch)
                    == ClipResult::Nothing
                {
                    continue;
                }
            }
            if here {
                let reached = ChainEnd {
                    way: number,
                    first: !has(&self.reached, number),
                    source: &next.source,
                    target: &next.pass,
                    between: &before[1..],
                };
                met(undecided, &reached);
                put(&mut self.reached, number);
            }
            if !any {
                continue;
            }
            let windings: [&[DVec3]; 2] = [&next.source, &next.pass];
            next.planes.find(ways, windings, false);
            next.planes.keep_above(ways, windings, &mut next.undecided);
            if next.undecided.is_empty() {
                continue;
            }
            next.may.clear();
            next.may
                .extend(step.may.iter().zip(after.words).map(|(may, after)| may & after));
            next.way = number;
            next.next = ways.out_of(way.to).start;
            self.in_chain[way.to as usize] = true;
            depth += 1;
        }
    }
}
