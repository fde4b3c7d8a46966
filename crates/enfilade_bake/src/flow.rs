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
use crate::separators::separators;
use crate::ways::Ways;
use crate::winding::{Left, Plane, clip};
use crate::within::keep_within;
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
    planes: Vec<Plane>,
    /// What the chain may still see.
    may: Vec<u64>,
    /// What of that is asked for.
    asked: Vec<u64>,
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
    /// The ways still asked for, as now.
    asked: Vec<u64>,
    after: After,
    in_chain: Vec<bool>,
    scratch: Vec<DVec3>,
    planes: Vec<Plane>,
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

impl After {
    /// Maximum number of words kept.
    const MOST: usize = 1 << 22;

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
    ) -> &[u64] {
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
        &self.rows[start as usize..][..self.words.len()]
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
        self.after.take(asked, &mut self.asked);
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
        step.asked.clone_from(&self.asked);
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
            // What may be seen, and is asked for, after this way.
            let after = self.after.passage(ways, bound, passages, [step.way, number]);
            next.may.clear();
            next.may
                .extend(step.may.iter().zip(after).map(|(may, after)| may & after));
            next.asked.clear();
            let still = step.asked.iter().zip(&self.asked);
            next.asked.extend(
                next.may
                    .iter()
                    .zip(still)
                    .map(|(may, (before, now))| may & before & now),
            );
            let any = next.asked.iter().any(|&word| word != 0);
            let here = has(asked, number);
            if !any && !here {
                continue;
            }
            // What is left of the way, then of the source.
            let target = &mut next.pass;
            target.clone_from(&way.corners);
            if clip(target, &first.plane, [&[]; 2], &mut self.scratch) == Left::Nothing {
                continue;
            }
            if step.planes.iter().any(|plane| {
                clip(target, plane, [&step.source, &step.pass], &mut self.scratch) == Left::Nothing
            }) {
                continue;
            }
            next.source.clone_from(&step.source);
            if clip(
                &mut next.source,
                &way.plane.flipped(),
                [&[]; 2],
                &mut self.scratch,
            ) == Left::Nothing
            {
                continue;
            }
            if depth > 0 {
                self.planes.clear();
                separators(ways, &next.pass, &step.pass, true, &mut self.planes);
                let gone = self.planes.iter().any(|plane| {
                    clip(
                        &mut next.source,
                        plane,
                        [&next.pass, &step.pass],
                        &mut self.scratch,
                    ) == Left::Nothing
                });
                if gone {
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
                self.after.take(asked, &mut self.asked);
            }
            if !any {
                continue;
            }
            next.planes.clear();
            separators(ways, &next.source, &next.pass, false, &mut next.planes);
            let numbers = &self.after.words;
            keep_within(
                ways,
                &next.planes,
                [&next.source, &next.pass],
                &mut next.asked,
                |word| numbers[word] as usize,
            );
            if next.asked.iter().all(|&word| word == 0) {
                continue;
            }
            next.way = number;
            next.next = ways.out_of(way.to).start;
            self.in_chain[way.to as usize] = true;
            depth += 1;
        }
    }
}
