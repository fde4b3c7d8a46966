//! Methods with a cover that only culls: occluders are rasterized first, then the traversal is tested against them.
//!
//! If the cover takes faces, those of clusters that pass the test become occluders for the rest of the traversal,
//! whatever the occluder budget, even 0. Clusters that were found before them are tested again at the end. The
//! potentially visible set is drawn with a z-buffer, so the picture is exact although the set is conservative.

use super::combined::Combination;
use super::found::{OcclusionTest, find};
use super::gathered::draw_gathered;
use super::shares::find_by_shares;
use crate::contract::Contract;
use crate::cover::{FineNode, Hides, ItemTest};
use crate::faces::Faces;
use crate::geom::Aabb;
use crate::geometry::{Exchanged, Geometry};
use crate::occluders::{OccluderRoom, OccluderSelection, OccluderSet};
use crate::order::{Gives, Order};
use crate::stats::Stats;
use crate::view::canvas::{Canvas, CoverShape};
use crate::view::collector::Collector;
use crate::view::memory::Memory;
use crate::view::options::Tightness;
use crate::view::passage::Passage;
use crate::view::region::{Region, Visibility};
use crate::view::screen_map::ScreenMap;
#[cfg(feature = "steps")]
use crate::view::step_log::LookStep;
use std::marker::PhantomData;
use std::sync::{Arc, OnceLock};

/// Method made of an order and a cover that only culls; drawing uses a z-buffer.
///
/// Used by [`Masked`](crate::Masked), [`Svbsp`](crate::Svbsp) and [`Mobsp`](crate::Mobsp).
pub struct Culled<O, C> {
    /// Computed on first use: a cover may not need them.
    occluders: OnceLock<Arc<OccluderSet>>,
    parts: PhantomData<fn() -> (O, C)>,
}

impl<O, C> Combination for Culled<O, C>
where
    O: Order,
    C: Hides,
    O::Gives: Gives<C::Needs>,
{
    type Order = O;

    const COVER: &'static str = C::NAME;
    const CONTRACT: Contract = C::CONTRACT;
    const OCCLUDERS: Option<u32> = Some(C::OCCLUDERS);
    const COVER_SHAPE: Option<CoverShape> = C::SHAPE;

    fn screen_bytes(size: [u32; 2], _cover_size: Option<[u32; 2]>) -> u64 {
        C::needs_bytes(size)
    }

    fn needs_bytes(geometry: &Geometry) -> u64 {
        OccluderSet::needs_bytes(geometry)
    }

    fn new(geometry: &Geometry) -> Self {
        let culled = Culled {
            occluders: OnceLock::new(),
            parts: PhantomData,
        };
        if C::OCCLUDERS > 0 {
            culled.occluders(geometry);
        }
        culled
    }

    fn gather(
        &self,
        order: &O,
        geometry: &Geometry,
        passage: &Passage,
        memory: &mut Memory,
        seen: &mut Collector,
    ) {
        let mut cover = memory.take::<C>();
        self.look(order, geometry, &mut cover, passage, memory, seen);
        memory.put_back(cover);
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
        draw_gathered(geometry, passage, memory, seen, canvas);
        if canvas.wants_cover() {
            // Other passages have used the cover since `gather`.
            let mut cover = memory.take::<C>();
            let stats = memory.stats;
            self.look(
                order,
                geometry,
                &mut cover,
                passage,
                memory,
                &mut Collector::default(),
            );
            memory.stats = stats;
            cover.show(passage, canvas);
            memory.put_back(cover);
        }
    }

    fn bytes(&self) -> u64 {
        self.occluders.get().map_or(0, |set| set.bytes())
    }

    fn follow(&mut self, geometry: &Geometry, done: &mut Exchanged) -> u64 {
        let occluders = self.occluders.get_mut();
        occluders.map_or(0, |set| Arc::make_mut(set).follow(geometry, done))
    }
}

impl<O: Order, C: Hides> Culled<O, C> {
    fn occluders(&self, geometry: &Geometry) -> &OccluderSet {
        if let Some(occluders) = self.occluders.get() {
            return occluders;
        }
        // Built outside of `get_or_init`: a thread that waits inside the cell may be scheduled work that needs the same
        // occluders, and would deadlock.
        let found = geometry.share(|| OccluderSet::build(geometry));
        self.occluders.get_or_init(|| found)
    }

    /// Clears a cover and rasterizes the best occluders into it, up to the budget.
    fn fill(&self, geometry: &Geometry, cover: &mut C, passage: &Passage, memory: &mut Memory) {
        cover.clear(passage);
        let budget = passage.options.occluders.unwrap_or(C::OCCLUDERS) as usize;
        if budget == 0 {
            return;
        }
        let mut choice = memory.take::<OccluderSelection>();
        let mut room = memory.take::<OccluderRoom>();
        let set = self.occluders(geometry);
        let mut choosing = set.choosing(geometry, passage, C::MEASURE, &mut choice);
        for _ in 0..budget {
            #[cfg(feature = "steps")]
            if memory.steps.as_ref().is_some_and(|steps| steps.is_full()) {
                break;
            }
            let Some(chosen) =
                choosing.next(|screen_from_local, bounds| !cover.hides(passage, screen_from_local, bounds))
            else {
                break;
            };
            if let Some(occluder) = set.on_screen(geometry, passage, &chosen, &mut room) {
                memory.stats.occluders += 1;
                cover.hide(&occluder, passage, &mut memory.stats);
                #[cfg(feature = "steps")]
                if let Some(steps) = &mut memory.steps {
                    steps.steps.push(LookStep::Occluder {
                        passage: steps.passage(),
                        item: chosen.item,
                        corners: set.in_sector(geometry, &chosen),
                    });
                }
            }
        }
        memory.put_back(choice);
        memory.put_back(room);
    }

    /// Reports the potentially visible clusters and openings.
    fn look(
        &self,
        order: &O,
        geometry: &Geometry,
        cover: &mut C,
        passage: &Passage,
        memory: &mut Memory,
        seen: &mut Collector,
    ) {
        self.fill(geometry, cover, passage, memory);
        // A cover that takes faces is traversed by one thread: what its faces hide depends on the order in which they
        // are rasterized, so the visible set would depend on the number of threads.
        if !C::TAKES_FACES && passage.threads() > 1 {
            find_by_shares(order, geometry, passage, cover, memory, seen);
            return;
        }
        find(
            order,
            geometry,
            passage,
            &mut SampleCover::new(cover),
            memory,
            seen,
        );
        #[cfg(feature = "steps")]
        if let Some(steps) = &mut memory.steps {
            steps.keep_cover(passage, |canvas| cover.show(passage, canvas));
        }
    }
}

/// Occlusion test against a cover at its normal resolution.
pub(super) struct SampleCover<'a, C> {
    cover: &'a mut C,
}

impl<'a, C> SampleCover<'a, C> {
    pub(super) fn new(cover: &'a mut C) -> SampleCover<'a, C> {
        SampleCover { cover }
    }

    pub(super) fn cover(&self) -> &C {
        self.cover
    }
}

impl<C: Hides> OcclusionTest for SampleCover<'_, C> {
    const TAKES_FACES: bool = C::TAKES_FACES;

    fn test(&mut self, region: &Region) -> Visibility {
        self.cover.test(region)
    }

    fn test_local(
        &mut self,
        passage: &Passage,
        screen_from_local: &ScreenMap,
        bounds: &Aabb,
    ) -> Option<Visibility> {
        self.cover.test_local(passage, screen_from_local, bounds)
    }

    fn go_within(&mut self) {
        self.cover.go_within();
    }

    fn go_back(&mut self) {
        self.cover.go_back();
    }

    fn test_and_add(&mut self, faces: &Faces, region: &Region, passage: &Passage, stats: &mut Stats) -> bool {
        if faces.can_occlude {
            self.cover.hide_faces(faces, region, passage, stats);
        }
        true
    }

    fn note_fine(&mut self, node: &FineNode, region: &Region, passage: &Passage) {
        self.cover.note_fine(node, region, passage);
    }

    fn item_test(&mut self, passage: &Passage) -> Option<ItemTest<'_>> {
        if passage.options.tightness == Tightness::Boxes || passage.options.growth() > 0.0 {
            return None;
        }
        self.cover.item_test()
    }

    fn accepts_node(&self, triangles: u64, region: &Region) -> bool {
        C::are_too_fine(triangles, region)
    }
}
