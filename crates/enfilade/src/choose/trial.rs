//! One method tried in one sector.

use super::{ChoiceGoal, ChoiceOptions, Cost, Views};
use crate::canvas::{Canvas, Span};
use crate::collector::Collector;
use crate::geometry::{Geometry, Owner};
use crate::memory::Memory;
use crate::method::{Method, Unsuited};
use crate::passage::{Passage, PassageId};
use crate::sector::Sector;
use crate::stats::Stats;
use std::sync::Arc;
use std::time::Duration;

/// A view that takes so many times as long as others with as much work was disturbed whenever it was measured.
const DISTURBED: f64 = 2.0;
/// What is not aimed at is measured on the first of so many views, once: it is reported, and decides nothing.
const OTHER_AIM: usize = 8;
/// Below this a build is measured again: a single disturbance would count.
const SHORT_BUILD: Duration = Duration::from_millis(50);
const SHORT_BUILDS: usize = 3;

/// A method built over a sector, and what it took so far.
pub(super) struct Tried {
    sector: Arc<dyn Sector>,
    memory: Memory,
    seen: Collector,
    owners: Owners,
    build: Duration,
    bytes: u64,
    pub(super) edit: Duration,
    look: Measured,
    draw: Measured,
}

/// What one view after the other took.
#[derive(Default)]
struct Measured {
    /// The least of each view.
    times: Vec<Duration>,
    /// What each counted, in boxes tested or about as much.
    work: Vec<u64>,
}

impl Tried {
    pub(super) fn build(
        method: Method,
        geometry: Arc<Geometry>,
        size: [u32; 2],
        limit_bytes: u64,
        clock: &dyn Fn() -> Duration,
    ) -> Result<Tried, Unsuited> {
        // The geometry's own, whatever sees it.
        geometry.item_tree();
        let shared = geometry.bytes();
        let build_once = || -> Result<_, Unsuited> {
            let start = clock();
            let sector = method.build(Arc::clone(&geometry), limit_bytes)?;
            Ok((sector, clock().saturating_sub(start)))
        };
        let (sector, mut build) = build_once()?;
        for _ in 1..SHORT_BUILDS {
            if build < SHORT_BUILD {
                build = build.min(build_once()?.1);
            }
        }
        Ok(Tried {
            build,
            bytes: sector.bytes().saturating_sub(shared) + method.screen_bytes(size, None),
            sector,
            memory: Memory::default(),
            seen: Collector::default(),
            owners: Owners::new(size),
            edit: Duration::ZERO,
            look: Measured::default(),
            draw: Measured::default(),
        })
    }

    /// Measures what is aimed at from view number `view`; the first time also what is not, if it is one of [`OTHER_AIM`] views.
    pub(super) fn run(
        &mut self,
        view: usize,
        passages: &[&Passage],
        aim: ChoiceGoal,
        clock: &dyn Fn() -> Duration,
    ) {
        let (time, work) = self.timed(passages, clock, aim);
        self.measured(aim).take(view, time, work);
        let other = match aim {
            ChoiceGoal::Look => ChoiceGoal::Draw,
            ChoiceGoal::Draw => ChoiceGoal::Look,
        };
        if view.is_multiple_of(OTHER_AIM) && self.measured(other).times.len() == view / OTHER_AIM {
            let (time, work) = self.timed(passages, clock, other);
            self.measured(other).take(view / OTHER_AIM, time, work);
        }
    }

    fn measured(&mut self, aim: ChoiceGoal) -> &mut Measured {
        match aim {
            ChoiceGoal::Look => &mut self.look,
            ChoiceGoal::Draw => &mut self.draw,
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
        passages: &[&Passage],
        clock: &dyn Fn() -> Duration,
        aim: ChoiceGoal,
    ) -> (Duration, u64) {
        let run = match aim {
            ChoiceGoal::Look => Tried::look,
            ChoiceGoal::Draw => Tried::draw,
        };
        self.memory.stats = Stats::default();
        let start = clock();
        self.memory.recall.begin_look();
        passages.iter().for_each(|passage| run(self, passage));
        (clock().saturating_sub(start), work(&self.memory.stats))
    }

    fn look(&mut self, passage: &Passage) {
        self.seen.clear(false);
        self.sector.gather(passage, &mut self.memory, &mut self.seen);
        self.seen.recycle();
    }

    fn draw(&mut self, passage: &Passage) {
        self.owners.enter(PassageId(0), passage);
        if self.sector.draws_what_was_gathered(&self.memory) {
            self.seen.clear(false);
            self.sector.gather(passage, &mut self.memory, &mut self.seen);
            self.seen.keep_items_alone();
        } else {
            self.seen.clear(true);
        }
        self.sector
            .draw(passage, &mut self.memory, &mut self.seen, &mut self.owners);
        self.seen.recycle();
    }

    /// What counts, as far as it is known, by some of the views.
    pub(super) fn frame(&self, views: Views, terms: &ChoiceOptions) -> Duration {
        let aim = match terms.aim {
            ChoiceGoal::Look => self.look.mean(views),
            ChoiceGoal::Draw => self.draw.mean(views),
        };
        aim + self.edit + self.build / terms.frames.max(1)
    }

    pub(super) fn bytes(&self) -> u64 {
        self.bytes
    }

    pub(super) fn cost(&self, terms: &ChoiceOptions) -> Cost {
        Cost {
            build: self.build,
            bytes: self.bytes,
            look: self.look.mean(Views::All),
            draw: self.draw.mean(Views::All),
            edit: self.edit,
            frame: self.frame(Views::All, terms),
        }
    }
}

/// About how much was done, in boxes tested.
fn work(stats: &Stats) -> u64 {
    1 + stats.boxes_tested + 2 * stats.triangles + stats.spans.compared + stats.samples / 16
}

impl Measured {
    fn take(&mut self, view: usize, time: Duration, work: u64) {
        if let Some(least) = self.times.get_mut(view) {
            *least = time.min(*least);
        } else {
            self.times.push(time);
            self.work.push(work);
        }
    }

    /// The mean of some views. Of one that was disturbed only as much counts as its work may have taken.
    fn mean(&self, views: Views) -> Duration {
        let each = || self.times.iter().zip(&self.work);
        let mut rates: Vec<f64> = each()
            .map(|(time, &work)| time.as_secs_f64() / work as f64)
            .collect();
        rates.sort_by(f64::total_cmp);
        let Some(usual) = rates.get(rates.len() / 2) else {
            return Duration::ZERO;
        };
        let undisturbed = |(time, &work): (&Duration, &u64)| {
            (*time).min(Duration::from_secs_f64(DISTURBED * usual * work as f64))
        };
        let chosen: Vec<Duration> = (each().map(undisturbed).enumerate())
            .filter_map(|(view, time)| views.holds(view).then_some(time))
            .collect();
        chosen.iter().sum::<Duration>() / chosen.len().max(1) as u32
    }
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
