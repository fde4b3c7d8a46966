//! Measures one method in one sector.

use super::{ChoiceGoal, ChoiceOptions, Cost, ViewSubset};
use crate::geometry::{Geometry, Owner};
use crate::ids::PassageId;
use crate::method::{Method, UnsuitedMethod};
use crate::sector::Sector;
use crate::stats::Stats;
use crate::view::canvas::{Canvas, Span};
use crate::view::collector::Collector;
use crate::view::memory::Memory;
use crate::view::passage::Passage;
use std::sync::Arc;
use std::time::Duration;

/// A view that takes this factor longer, per unit of work, than the median was disturbed in every measurement.
const DISTURBED: f64 = 2.0;
/// Of this many views, the first one is also measured for the other goal, once: for the report only.
const OTHER_GOAL: usize = 8;
/// Shorter builds are measured several times, because a single disturbance would count.
const SHORT_BUILD: Duration = Duration::from_millis(50);
const SHORT_BUILDS: usize = 3;

/// A method built over a sector, with its measurements so far.
pub(super) struct MethodTrial {
    sector: Arc<dyn Sector>,
    memory: Memory,
    seen: Collector,
    canvas: NumberCanvas,
    build: Duration,
    bytes: u64,
    pub(super) edit: Duration,
    look: Measurements,
    draw: Measurements,
}

/// Times and work by view.
#[derive(Default)]
struct Measurements {
    /// Minimum time of each view.
    times: Vec<Duration>,
    /// Work of each view: number of box tests or equivalent.
    work: Vec<u64>,
}

impl MethodTrial {
    pub(super) fn build(
        method: Method,
        geometry: Arc<Geometry>,
        size: [u32; 2],
        limit_bytes: u64,
        clock: &dyn Fn() -> Duration,
    ) -> Result<MethodTrial, UnsuitedMethod> {
        // Built before the clock starts: all methods share the geometry's octree.
        geometry.item_tree();
        let shared = geometry.bytes();
        let build_once = || -> Result<_, UnsuitedMethod> {
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
        Ok(MethodTrial {
            build,
            bytes: sector.bytes().saturating_sub(shared) + method.screen_bytes(size, None),
            sector,
            memory: Memory::default(),
            seen: Collector::default(),
            canvas: NumberCanvas::new(size),
            edit: Duration::ZERO,
            look: Measurements::default(),
            draw: Measurements::default(),
        })
    }

    /// Measures the goal from view number `view`; for one view in [`OTHER_GOAL`] also the other goal, once.
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
        if view.is_multiple_of(OTHER_GOAL) && self.measured(other).times.len() == view / OTHER_GOAL {
            let (time, work) = self.timed(passages, clock, other);
            self.measured(other).take(view / OTHER_GOAL, time, work);
        }
    }

    fn measured(&mut self, aim: ChoiceGoal) -> &mut Measurements {
        match aim {
            ChoiceGoal::Look => &mut self.look,
            ChoiceGoal::Draw => &mut self.draw,
        }
    }

    /// Touches all buffers: the first use of a buffer is slower than later ones.
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
            ChoiceGoal::Look => MethodTrial::look,
            ChoiceGoal::Draw => MethodTrial::draw,
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
        self.canvas.enter(PassageId(0), passage);
        if self.sector.draws_what_was_gathered(&passage.options) {
            self.seen.clear(false);
            self.sector.gather(passage, &mut self.memory, &mut self.seen);
            self.seen.keep_items_alone();
        } else {
            self.seen.clear(true);
        }
        self.sector
            .draw(passage, &mut self.memory, &mut self.seen, &mut self.canvas);
        self.seen.recycle();
    }

    /// Returns the time per frame that decides, over a subset of the views.
    pub(super) fn frame(&self, views: ViewSubset, terms: &ChoiceOptions) -> Duration {
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
            look: self.look.mean(ViewSubset::All),
            draw: self.draw.mean(ViewSubset::All),
            edit: self.edit,
            frame: self.frame(ViewSubset::All, terms),
        }
    }
}

/// Estimates the work of a look, in box tests.
fn work(stats: &Stats) -> u64 {
    1 + stats.boxes_tested + 2 * stats.triangles + stats.spans.compared + stats.samples / 16
}

impl Measurements {
    fn take(&mut self, view: usize, time: Duration, work: u64) {
        if let Some(least) = self.times.get_mut(view) {
            *least = time.min(*least);
        } else {
            self.times.push(time);
            self.work.push(work);
        }
    }

    /// Returns the mean time of a subset of the views. The time of a disturbed view is limited by its work.
    fn mean(&self, views: ViewSubset) -> Duration {
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

/// A canvas of numbers: little work, but not none.
struct NumberCanvas {
    width: usize,
    samples: Vec<u32>,
}

impl NumberCanvas {
    fn new(size: [u32; 2]) -> NumberCanvas {
        let [width, height] = size.map(|side| side as usize);
        NumberCanvas {
            width,
            samples: vec![0; width * height],
        }
    }
}

impl Canvas for NumberCanvas {
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
