//! One method tried in one fragment.

use super::{Aim, Cost, Terms};
use crate::canvas::{Canvas, Span};
use crate::content::{Content, Owner};
use crate::fragment::Fragment;
use crate::memory::Memory;
use crate::method::{Method, Unsuited};
use crate::passage::{Passage, PassageId};
use crate::seen::Seen;
use std::sync::Arc;
use std::time::Duration;

/// What is so much slower than the best is not measured again.
const FAR_FROM_BEST: f64 = 1.5;

/// A method built over a fragment, and what it took so far.
pub(super) struct Tried {
    fragment: Arc<dyn Fragment>,
    memory: Memory,
    seen: Seen,
    owners: Owners,
    build: Duration,
    bytes: u64,
    pub(super) edit: Duration,
    /// The least of each view.
    look: Vec<Duration>,
    draw: Vec<Duration>,
}

impl Tried {
    pub(super) fn build(
        method: Method,
        content: Arc<Content>,
        size: [u32; 2],
        limit_bytes: u64,
        clock: &dyn Fn() -> Duration,
    ) -> Result<Tried, Unsuited> {
        // The content's own, whatever sees it.
        content.item_tree();
        let shared = content.bytes();
        let start = clock();
        let fragment = method.build(content, limit_bytes)?;
        Ok(Tried {
            build: clock().saturating_sub(start),
            bytes: fragment.bytes().saturating_sub(shared) + method.screen_bytes(size, None),
            fragment,
            memory: Memory::default(),
            seen: Seen::default(),
            owners: Owners::new(size),
            edit: Duration::ZERO,
            look: Vec::new(),
            draw: Vec::new(),
        })
    }

    /// Does what is aimed at once from each view; the first time also what is not.
    pub(super) fn run(&mut self, through: &[Vec<&Passage>], aim: Aim, clock: &dyn Fn() -> Duration) {
        let is_first = self.look.is_empty();
        if is_first || aim == Aim::Look {
            let looks = self.timed(through, clock, Tried::look);
            keep_least(&mut self.look, looks);
        }
        if is_first || aim == Aim::Draw {
            let draws = self.timed(through, clock, Tried::draw);
            keep_least(&mut self.draw, draws);
        }
    }

    /// Touches all buffers, which takes longer than to use them.
    pub(super) fn warm_up(&mut self, first: &[&Passage]) {
        for passage in first {
            self.look(passage);
            self.draw(passage);
        }
    }

    fn timed(
        &mut self,
        through: &[Vec<&Passage>],
        clock: &dyn Fn() -> Duration,
        run: fn(&mut Tried, &Passage),
    ) -> Vec<Duration> {
        let view = |passages: &Vec<&Passage>| {
            let start = clock();
            self.memory.recall.begin_look();
            passages.iter().for_each(|passage| run(self, passage));
            clock().saturating_sub(start)
        };
        through.iter().map(view).collect()
    }

    fn look(&mut self, passage: &Passage) {
        self.seen.clear(false);
        self.fragment.gather(passage, &mut self.memory, &mut self.seen);
        self.seen.recycle();
    }

    fn draw(&mut self, passage: &Passage) {
        self.owners.enter(PassageId(0), passage);
        if self.fragment.draws_what_was_gathered(&self.memory) {
            self.seen.clear(false);
            self.fragment.gather(passage, &mut self.memory, &mut self.seen);
            self.seen.keep_items_alone();
        } else {
            self.seen.clear(true);
        }
        self.fragment
            .draw(passage, &mut self.memory, &mut self.seen, &mut self.owners);
        self.seen.recycle();
    }

    /// Is it worth while to measure it again, where the best takes so long a frame?
    pub(super) fn may_be_best(&self, best: Duration, terms: &Terms) -> bool {
        self.look.is_empty() || self.frame(terms) <= best.mul_f64(FAR_FROM_BEST)
    }

    /// What counts, as far as it is known.
    pub(super) fn frame(&self, terms: &Terms) -> Duration {
        let aim = match terms.aim {
            Aim::Look => mean(&self.look),
            Aim::Draw => mean(&self.draw),
        };
        aim + self.edit + self.build / terms.frames.max(1)
    }

    pub(super) fn cost(&self, terms: &Terms) -> Cost {
        Cost {
            build: self.build,
            bytes: self.bytes,
            look: mean(&self.look),
            draw: mean(&self.draw),
            edit: self.edit,
            frame: self.frame(terms),
        }
    }
}

fn keep_least(least: &mut Vec<Duration>, times: Vec<Duration>) {
    if least.is_empty() {
        *least = times;
    } else {
        least
            .iter_mut()
            .zip(times)
            .for_each(|(least, time)| *least = time.min(*least));
    }
}

fn mean(times: &[Duration]) -> Duration {
    times.iter().sum::<Duration>() / times.len().max(1) as u32
}

/// A picture of numbers: as little as can be done with what is seen, and not nothing.
struct Owners {
    width: usize,
    samples: Vec<u32>,
}

impl Owners {
    fn new(size: [u32; 2]) -> Owners {
        let [width, height] = size.map(|side| side as usize);
        Owners {
            width,
            samples: vec![0; width * height],
        }
    }
}

impl Canvas for Owners {
    fn enter(&mut self, _id: PassageId, _passage: &Passage) {}

    fn row(&mut self, y: u16, spans: &[Span]) {
        let row = &mut self.samples[usize::from(y) * self.width..][..self.width];
        for span in spans {
            let number = match span.owner {
                Owner::Face(item, face) => item.0 ^ face.rotate_left(16),
                Owner::Opening(opening) => opening.0.into(),
            };
            row[usize::from(span.x0)..usize::from(span.x1)].fill(number);
        }
    }
}
