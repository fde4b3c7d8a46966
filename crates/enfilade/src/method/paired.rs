//! Methods with a cover that holds the picture: faces are rasterized as the order emits them.

use super::combined::{Combination, takes};
use super::strips::{self, look_in_strips};
use super::visit::visit;
use crate::contract::Contract;
use crate::cover::Paints;
use crate::faces::{FaceSource, Faces};
use crate::geometry::{Alpha, Geometry};
use crate::ids::ItemIndex;
use crate::order::{Gives, Order, Visit};
use crate::stats::Stats;
use crate::view::canvas::{Canvas, CoverShape};
use crate::view::collector::Collector;
use crate::view::memory::{Marks, Memory};
use crate::view::options::ViewerOptions;
use crate::view::passage::Passage;
use crate::view::region::{Region, Visibility};
use std::marker::PhantomData;

/// Method made of an order and a cover that rasterizes. Incompatible pairs are rejected at compile time:
///
/// ```compile_fail,E0277
/// use enfilade::order::{Gives, NearToFar, Order, Unordered};
/// fn needs_near_to_far<O: Order>() where O::Gives: Gives<NearToFar> {}
/// needs_near_to_far::<Unordered>();
/// ```
pub struct Paired<O, C>(PhantomData<fn() -> (O, C)>);

impl<O, C> Combination for Paired<O, C>
where
    O: Order,
    C: Paints,
    O::Gives: Gives<C::Needs>,
{
    type Order = O;

    const COVER: &'static str = C::NAME;
    const CONTRACT: Contract = if O::KEEPS_ORDER {
        Contract::Exact
    } else {
        Contract::Approximate
    };
    const COVER_SHAPE: Option<CoverShape> = C::SHAPE;

    fn screen_bytes(size: [u32; 2], _cover_size: Option<[u32; 2]>) -> u64 {
        C::needs_bytes(size)
    }

    fn new(_geometry: &Geometry) -> Self {
        Paired(PhantomData)
    }

    fn draws_what_was_gathered(&self, _options: &ViewerOptions) -> bool {
        false
    }

    fn gather(
        &self,
        order: &O,
        geometry: &Geometry,
        passage: &Passage,
        memory: &mut Memory,
        seen: &mut Collector,
    ) {
        Self::see(order, geometry, passage, memory, seen, None);
    }

    fn draw(
        &self,
        order: &O,
        geometry: &Geometry,
        passage: &Passage,
        memory: &mut Memory,
        seen: &mut Collector,
        canvas: &mut dyn Canvas,
    ) {
        Self::see(order, geometry, passage, memory, seen, Some(canvas));
    }
}

impl<O: Order, C: Paints> Paired<O, C> {
    /// Reports what is visible. If the cover benefits, last frame's visible clusters are rasterized first.
    fn see(
        order: &O,
        geometry: &Geometry,
        passage: &Passage,
        memory: &mut Memory,
        seen: &mut Collector,
        canvas: Option<&mut dyn Canvas>,
    ) {
        let size = geometry.bounds().longest_side();
        let primes = C::PRIMES && passage.options.coherence;
        let last = if primes {
            memory.recall.seen_last(passage, size)
        } else {
            memory.recall.list()
        };
        memory.stats.clusters_primed += last.len() as u64;
        // No strips if there is a canvas: it receives its rows in order.
        let strips = if canvas.is_some() {
            1
        } else {
            strips::count(passage)
        };
        if strips > 1 {
            look_in_strips(strips, geometry, passage, memory, seen, |strip, memory, seen| {
                Self::look(order, geometry, strip, &last, memory, seen, None)
            });
        } else {
            Self::look(order, geometry, passage, &last, memory, seen, canvas);
        }
        memory.stats.samples_owned += seen.samples_owned;
        if primes {
            memory
                .recall
                .remember(passage, seen.clusters_of_items(geometry), last);
        } else {
            memory.recall.give_back(last);
        }
    }

    /// Reports what is visible, rasterizing the clusters of `first` first.
    fn look(
        order: &O,
        geometry: &Geometry,
        passage: &Passage,
        first: &[(ItemIndex, u32)],
        memory: &mut Memory,
        seen: &mut Collector,
        mut canvas: Option<&mut dyn Canvas>,
    ) {
        let mut cover = memory.take::<C>();
        let mut work = memory.take::<Work>();
        let mut scratch = memory.take::<O::Scratch>();
        cover.clear(passage, memory.trace);
        memory.marks.begin(geometry.items().len());
        let mut walk = Walk {
            geometry,
            passage,
            cover: &mut *cover,
            marks: &mut memory.marks,
            stats: &mut memory.stats,
            work: &mut work,
            primed: first,
            canvas: reborrow(&mut canvas),
        };
        walk.prime();
        visit(
            order,
            geometry,
            passage,
            &mut scratch,
            &mut walk,
            #[cfg(feature = "steps")]
            memory.steps.as_deref_mut(),
        );
        for (item, cluster) in work.waiting.drain(..) {
            let screen_from_item = passage.screen_from(&geometry.item(item).transform());
            let bounds = geometry.mesh_of(item).clusters()[cluster as usize].bounds;
            let region = Region::of(passage, &screen_from_item, &bounds);
            let Some(region) =
                region.filter(|region| !C::KEEPS_DEPTHS || cover.test(region) != Visibility::Hidden)
            else {
                continue;
            };
            let faces = Faces::of_cluster(geometry, item, cluster, &screen_from_item);
            if faces.count() > 0 {
                cover.look_through(&faces, passage, &mut memory.stats, seen);
                continue;
            }
            // An item that is only bounds owns no sample. Where a plane cuts it, its sides do not enclose what is seen.
            let is_cut = passage.entry.is_some() || passage.is_before_near(&region);
            let corners = bounds.corners();
            let sides = faces.of_sides(&corners);
            if is_cut || shows(&mut *cover, &sides, passage, &mut memory.stats, seen) {
                seen.report.owners.push((item, cluster));
            }
        }
        cover.finish(geometry, passage, seen, reborrow(&mut canvas));
        if let Some(canvas) = canvas.filter(|canvas| canvas.wants_cover()) {
            cover.show(passage, canvas);
        }
        #[cfg(feature = "steps")]
        if let Some(steps) = &mut memory.steps {
            steps.keep_cover(passage, |canvas| cover.show(passage, canvas));
        }
        memory.put_back(cover);
        memory.put_back(work);
        memory.put_back(scratch);
    }
}

/// Whether transparent faces are visible at any sample; reports nothing.
fn shows(
    cover: &mut impl Paints,
    faces: &Faces,
    passage: &Passage,
    stats: &mut Stats,
    seen: &mut Collector,
) -> bool {
    let before = seen.glass.len();
    cover.look_through(faces, passage, stats, seen);
    let shows = seen.glass.len() > before;
    seen.glass.truncate(before);
    shows
}

/// Reborrows an optional canvas.
fn reborrow<'a>(canvas: &'a mut Option<&mut dyn Canvas>) -> Option<&'a mut dyn Canvas> {
    match canvas {
        Some(canvas) => Some(&mut **canvas),
        None => None,
    }
}

/// Buffers that are reused from one passage to the next.
#[derive(Default)]
struct Work {
    /// Clusters that are no occluders; tested once all occluders are in the cover.
    waiting: Vec<(ItemIndex, u32)>,
    /// Clusters rasterized before the traversal, with the maximum of their reversed depth.
    first: Vec<(f32, ItemIndex, u32)>,
}

/// Connects the traversal of an order to a cover.
struct Walk<'a, C> {
    geometry: &'a Geometry,
    passage: &'a Passage,
    cover: &'a mut C,
    marks: &'a mut Marks,
    stats: &'a mut Stats,
    work: &'a mut Work,
    /// Clusters rasterized before the traversal, sorted.
    primed: &'a [(ItemIndex, u32)],
    canvas: Option<&'a mut dyn Canvas>,
}

impl<C: Paints> Walk<'_, C> {
    /// Rasterizes last frame's visible clusters front to back, leaving out those that are now out of view.
    fn prime(&mut self) {
        let geometry = self.geometry;
        let mut first = std::mem::take(&mut self.work.first);
        first.extend(self.primed.iter().filter_map(|&(item, cluster)| {
            // The geometry may have been replaced since the last look.
            let placed = geometry.items().get(item.0 as usize)?;
            if !self.passage.takes(placed) {
                return None;
            }
            let screen_from_item = self.passage.screen_from(&placed.transform());
            let bounds = &geometry.mesh_of(item).clusters().get(cluster as usize)?.bounds;
            let region = Region::of(self.passage, &screen_from_item, bounds)?;
            Some((region.nearest, item, cluster))
        }));
        first.sort_unstable_by(|a, b| b.0.total_cmp(&a.0).then((a.1, a.2).cmp(&(b.1, b.2))));
        for (_, item, cluster) in first.drain(..) {
            let screen_from_item = self.passage.screen_from(&geometry.item(item).transform());
            self.take(&Faces::of_cluster(geometry, item, cluster, &screen_from_item));
        }
        self.work.first = first;
    }

    fn take(&mut self, faces: &Faces) {
        match (faces.alpha, faces.source) {
            (Alpha::Mask | Alpha::Blend, FaceSource::Item(item, cluster)) => {
                if self.geometry.item(item).options.is_drawn {
                    self.work.waiting.push((item, cluster));
                }
            }
            _ => {
                self.cover
                    .add(faces, self.passage, self.stats, reborrow(&mut self.canvas));
            }
        }
    }
}

impl<C: Paints> Visit for Walk<'_, C> {
    fn enter(&mut self, region: &Region) -> Visibility {
        self.stats.boxes_tested += 1;
        let visibility = self.cover.test(region);
        self.stats.boxes_hidden += u64::from(visibility == Visibility::Hidden);
        visibility
    }

    fn first_time(&mut self, item: ItemIndex) -> bool {
        self.marks.first_time(item) && takes(self.passage, self.geometry.item(item), self.stats)
    }

    fn faces(&mut self, faces: &Faces) {
        if let FaceSource::Item(item, cluster) = faces.source {
            let placed = self.geometry.item(item);
            if !self.passage.takes(placed) {
                // Orders that sort faces do not ask `first_time`.
                if self.marks.first_time(item) {
                    takes(self.passage, placed, self.stats);
                }
                return;
            }
            if self.primed.binary_search(&(item, cluster)).is_ok() {
                return;
            }
        }
        self.take(faces);
    }
}
