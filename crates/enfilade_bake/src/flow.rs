//! The flow: chains of ways, one by one, with what is left of the first seen from the last and of the last from the first.
//!
//! From one way the flow goes on through every way out of the cell it is in. The way is clipped to the planes between the
//! source and the way before, then the source to those between it and the way before; a chain of which nothing is left
//! ends. A chain goes on only while one of the ways that are still asked for may lie in it: most are known to be seen by
//! a sampled line, or were decided from their own side.
//! Source: Teller 1992, section 3.3; what is asked for, and the look ahead, are ours.
//! Cost: chains grow with the openness of the world; each step clips two windings of a few corners.
//! Conservative: windings are cut farther out than rounding can shift a plane. A cell is not entered twice, for a line
//! leaves a convex cell for good.

use crate::bits::{BitRows, has, put};
use crate::passages::Passages;
use crate::separators::Separators;
use crate::ways::Ways;
use crate::winding::{Left, clip};
use glam::DVec3;

/// One way of a chain.
#[derive(Debug, Default)]
struct Step {
    way: usize,
    /// What is left of it, seen from the source.
    pass: Vec<DVec3>,
    /// What is left of the source, seen from here.
    source: Vec<DVec3>,
    /// The planes between those two.
    planes: Separators,
    /// What the chain may still see.
    may: Vec<u64>,
    /// What of that is asked for: words that are not zero, with their numbers.
    asked: Vec<(u32, u64)>,
    /// The next way to try out of the cell that `way` enters.
    next: usize,
}

/// A way that was asked for, at the end of a chain.
#[derive(Debug)]
pub(crate) struct Reached<'a> {
    pub(crate) way: usize,
    /// Whether no chain has come to it before.
    pub(crate) first: bool,
    /// What is left of the source, seen from the way.
    pub(crate) source: &'a [DVec3],
    /// What is left of the way, seen from the source.
    pub(crate) target: &'a [DVec3],
    between: &'a [Step],
}

impl Reached<'_> {
    /// All that a line from the source to the way has to go through, those two among them.
    pub(crate) fn windings(&self) -> impl Iterator<Item = &[DVec3]> {
        let between = self.between.iter().map(|step| step.pass.as_slice());
        [self.source, self.target].into_iter().chain(between)
    }
}

/// Buffers of a flow, used again.
#[derive(Debug, Default)]
pub(crate) struct Flow {
    steps: Vec<Step>,
    reached: Vec<u64>,
    after: After,
    in_chain: Vec<bool>,
    scratch: Vec<DVec3>,
    planes: Separators,
}

/// What may be seen after passages, of what may be seen from the source: only those words of rows that are not zero there. Chains
/// come through the same passages again and again, and whole rows of large worlds are in no cache.
#[derive(Debug, Default)]
struct After {
    /// The numbers of the words.
    words: Vec<u32>,
    /// By the number of a word, its place among those.
    places: Vec<u32>,
    /// By passage, where its words begin in `rows` and in which run they were put there.
    starts: Vec<[u32; 2]>,
    run: u32,
    rows: Vec<u64>,
}

/// Place of a word that is zero.
const NOWHERE: u32 = u32::MAX;

/// What may be seen after one passage.
#[derive(Clone, Copy)]
struct AfterOne<'a> {
    places: &'a [u32],
    words: &'a [u64],
}

impl AfterOne<'_> {
    /// Returns a word of what may be seen from the source, by its number.
    fn word(&self, number: u32) -> u64 {
        self.words[self.places[number as usize] as usize]
    }
}

impl After {
    /// Maximum number of words kept.
    const MOST: usize = 1 << 20;

    fn begin(&mut self, bound: &[u64], passages: usize) {
        self.words.clear();
        self.places.clear();
        for (number, &word) in (0..).zip(bound) {
            let place = if word == 0 {
                NOWHERE
            } else {
                self.words.push(number);
                self.words.len() as u32 - 1
            };
            self.places.push(place);
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

    /// Replaces `words` by those of a row.
    fn take(&self, row: &[u64], words: &mut Vec<u64>) {
        words.clear();
        words.extend(self.words.iter().map(|&number| row[number as usize]));
    }

    /// Whether a way is in a set.
    fn has(&self, set: &[u64], way: usize) -> bool {
        let place = self.places[way / 64];
        place != NOWHERE && set[place as usize] >> (way % 64) & 1 != 0
    }

    /// Returns the ways after a passage.
    fn passage(
        &mut self,
        ways: &Ways,
        bound: &BitRows,
        passages: &Passages,
        [first, second]: [usize; 2],
    ) -> AfterOne<'_> {
        let number = passages.number(ways, first, second);
        let [mut start, run] = self.starts[number];
        if run != self.run {
            if self.rows.len() + self.words.len() > After::MOST {
                self.forget();
            }
            start = self.rows.len() as u32;
            self.starts[number] = [start, self.run];
            self.rows.resize(self.rows.len() + self.words.len(), 0);
            let (of_second, row) = (bound.row(second), &mut self.rows[start as usize..]);
            for (number, of_passage) in passages.after(ways, first, second) {
                let place = self.places[number];
                if place != NOWHERE {
                    row[place as usize] = of_second[number] & of_passage;
                }
            }
        }
        AfterOne {
            places: &self.places,
            words: &self.rows[start as usize..][..self.words.len()],
        }
    }
}

impl Flow {
    /// Follows chains from `source` to the ways in `asked`; what is left there and was not reached is not seen.
    ///
    /// Where a chain comes to one, `met` takes it out, or other chains will be followed to it; and it may take out more that
    /// is seen for sure. Gives the ways reached.
    pub(crate) fn run(
        &mut self,
        ways: &Ways,
        bound: &BitRows,
        passages: &Passages,
        source: usize,
        asked: &mut [u64],
        mut met: impl FnMut(&mut [u64], &Reached),
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
        step.asked.clear();
        step.asked
            .extend((0..).zip(asked.iter().copied()).filter(|&(_, word)| word != 0));
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
            // What is asked for and may be seen after this way.
            let after = self.after.passage(ways, bound, passages, [step.way, number]);
            next.asked.clear();
            next.asked.extend(step.asked.iter().filter_map(|&(number, word)| {
                let word = word & asked[number as usize] & after.word(number);
                (word != 0).then_some((number, word))
            }));
            let any = !next.asked.is_empty();
            let here = has(asked, number);
            if !any && !here {
                continue;
            }
            // What is left of the way, then of the source.
            let target = &mut next.pass;
            target.clone_from(&way.corners);
            if clip(target, &first.plane, &mut self.scratch) == Left::Nothing {
                continue;
            }
            let parted: [&[DVec3]; 2] = [&step.source, &step.pass];
            if step.planes.clip(ways, parted, target, &mut self.scratch) == Left::Nothing {
                continue;
            }
            next.source.clone_from(&step.source);
            if clip(&mut next.source, &way.plane.flipped(), &mut self.scratch) == Left::Nothing {
                continue;
            }
            if depth > 0 {
                let parted: [&[DVec3]; 2] = [&next.pass, &step.pass];
                self.planes.find(ways, parted, true);
                if self
                    .planes
                    .clip(ways, parted, &mut next.source, &mut self.scratch)
                    == Left::Nothing
                {
                    continue;
                }
            }
            if here {
                let reached = Reached {
                    way: number,
                    first: !has(&self.reached, number),
                    source: &next.source,
                    target: &next.pass,
                    between: &before[1..],
                };
                met(asked, &reached);
                put(&mut self.reached, number);
            }
            if !any {
                continue;
            }
            let parted: [&[DVec3]; 2] = [&next.source, &next.pass];
            next.planes.find(ways, parted, false);
            next.planes.keep_above(ways, parted, &mut next.asked);
            if next.asked.is_empty() {
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
