//! Methods with a cover that only culls: occluders are rasterized first, then the traversal is tested against them.
//!
//! If the cover takes faces, those of clusters that pass the test become occluders for the rest of the traversal,
//! whatever the occluder budget, even 0. Clusters that were found before them are tested again at the end. The
//! potentially visible set is drawn with a z-buffer, so the picture is exact although the set is conservative.

use super::count::count_faces;
use super::editable::{EditStats, EditableSector, edit_order};
use super::found::{OcclusionTest, find};
use super::gathered::draw_gathered;
use super::in_cells::CoarseMethod;
use super::shares::find_by_shares;
use super::{Method, TooLarge, Unsuited};
use crate::canvas::Canvas;
use crate::collector::Collector;
use crate::cover::{Coarse, Hides};
use crate::faces::Faces;
use crate::geom::Aabb;
use crate::geometry::{Changes, Geometry, ItemId, Opening};
use crate::memory::Memory;
use crate::occluders::{OccluderRoom, OccluderSelection, OccluderSet};
use crate::order::{Gives, Order};
use crate::passage::Passage;
use crate::region::{Region, Visibility};
use crate::sector::{BuildStats, Contract, Hit, Ray, Sector, Surface};
use crate::stats::Stats;
use glam::DAffine3;
use std::marker::PhantomData;
use std::sync::{Arc, OnceLock};

/// Method made of an order and a cover that only culls; drawing uses a z-buffer.
///
/// Used by [`Masked`](crate::Masked), [`Svbsp`](crate::Svbsp) and [`Mobsp`](crate::Mobsp).
pub struct Culled<O, C> {
    method: Method,
    geometry: Arc<Geometry>,
    /// Computed on first use: a cover may not need them.
    occluders: OnceLock<Arc<OccluderSet>>,
    order: O,
    cover: PhantomData<fn() -> C>,
}

impl<O, C> Culled<O, C>
where
    O: Order,
    C: Hides,
    O::Gives: Gives<C::CullNeeds>,
{
    pub(super) fn build(method: Method, geometry: Arc<Geometry>, limit: u64) -> Result<Self, Unsuited> {
        let needs_bytes = O::needs_bytes(&geometry) + OccluderSet::needs_bytes(&geometry);
        if needs_bytes > limit {
            return Err(TooLarge::new(method, needs_bytes, limit).into());
        }
        let order =
            O::build(&geometry, limit).map_err(|refusal| Unsuited::of(method, &geometry, refusal, limit))?;
        let culled = Culled {
            method,
            occluders: OnceLock::new(),
            order,
            geometry,
            cover: PhantomData,
        };
        if C::OCCLUDERS > 0 {
            culled.occluders();
        }
        Ok(culled)
    }

    fn occluders(&self) -> &OccluderSet {
        if let Some(occluders) = self.occluders.get() {
            return occluders;
        }
        // Built outside of `get_or_init`: a thread that waits inside the cell may be scheduled work that needs the same
        // occluders, and would deadlock.
        let found = self.geometry.share(|| OccluderSet::build(&self.geometry));
        self.occluders.get_or_init(|| found)
    }

    /// Clears a cover and rasterizes the best occluders into it, up to the budget.
    fn fill(&self, cover: &mut C, passage: &Passage, memory: &mut Memory) {
        cover.clear(passage);
        let budget = memory.occluders.unwrap_or(C::OCCLUDERS) as usize;
        if budget == 0 {
            return;
        }
        let mut choice = memory.take::<OccluderSelection>();
        let mut room = memory.take::<OccluderRoom>();
        let set = self.occluders();
        let mut choosing = set.choosing(&self.geometry, passage, C::MEASURE, &mut choice);
        for _ in 0..budget {
            let Some(chosen) =
                choosing.next(|screen_from_local, bounds| !cover.hides(passage, screen_from_local, bounds))
            else {
                break;
            };
            if let Some(occluder) = set.on_screen(&self.geometry, passage, &chosen, &mut room) {
                memory.stats.occluders += 1;
                cover.hide(&occluder, passage, &mut memory.stats);
            }
        }
        memory.put_back(choice);
        memory.put_back(room);
    }

    /// Reports the potentially visible clusters and openings.
    fn look(&self, cover: &mut C, passage: &Passage, memory: &mut Memory, seen: &mut Collector) {
        self.fill(cover, passage, memory);
        // A cover that takes faces is traversed by one thread: what its faces hide depends on the order in which they
        // are rasterized, so the visible set would depend on the number of threads.
        if !C::TAKES_FACES && memory.threads() > 1 {
            find_by_shares(&self.order, &self.geometry, passage, cover, memory, seen);
            return;
        }
        find(
            &self.order,
            &self.geometry,
            passage,
            &mut SampleCover(cover),
            memory,
            seen,
        );
    }
}

/// Occlusion test against a cover at its normal resolution.
pub(super) struct SampleCover<'a, C>(pub(super) &'a mut C);

impl<C: Hides> OcclusionTest for SampleCover<'_, C> {
    const TAKES_FACES: bool = C::TAKES_FACES;

    fn test(&mut self, region: &Region) -> Visibility {
        self.0.test(region)
    }

    fn test_local(
        &mut self,
        passage: &Passage,
        screen_from_local: &DAffine3,
        bounds: &Aabb,
    ) -> Option<Visibility> {
        self.0.test_local(passage, screen_from_local, bounds)
    }

    fn go_within(&mut self) {
        self.0.go_within();
    }

    fn go_back(&mut self) {
        self.0.go_back();
    }

    fn test_and_add(&mut self, faces: &Faces, region: &Region, passage: &Passage, stats: &mut Stats) -> bool {
        if faces.can_occlude {
            self.0.hide_faces(faces, region, passage, stats);
        }
        true
    }

    fn test_faces(&mut self, _: &Faces, _: &Region, _: &Passage, _: &mut Stats) -> bool {
        true
    }

    fn accepts_node(&self, triangles: u64, region: &Region) -> bool {
        C::are_too_fine(triangles, region)
    }
}

impl<O, C> Sector for Culled<O, C>
where
    O: Order,
    C: Hides,
    O::Gives: Gives<C::CullNeeds>,
{
    fn bounds(&self) -> Aabb {
        self.geometry.bounds()
    }

    fn openings(&self) -> &[Opening] {
        self.geometry.openings()
    }

    fn contract(&self) -> Contract {
        self.method.contract()
    }

    fn draws_what_was_gathered(&self, _memory: &Memory) -> bool {
        true
    }

    fn gather(&self, passage: &Passage, memory: &mut Memory, seen: &mut Collector) {
        let mut cover = memory.take::<C>();
        self.look(&mut cover, passage, memory, seen);
        memory.put_back(cover);
    }

    fn draw(&self, passage: &Passage, memory: &mut Memory, seen: &mut Collector, canvas: &mut dyn Canvas) {
        draw_gathered(&self.geometry, passage, memory, seen, canvas);
        if canvas.wants_cover() {
            // Other passages have used the cover since `gather`.
            let mut cover = memory.take::<C>();
            let stats = memory.stats;
            self.look(&mut cover, passage, memory, &mut Collector::default());
            memory.stats = stats;
            cover.show(passage, canvas);
            memory.put_back(cover);
        }
    }

    fn cast(&self, ray: &Ray) -> Option<Hit> {
        self.geometry.cast(ray)
    }

    fn surface(&self, item: ItemId, face: u32) -> Surface {
        self.geometry.surface(item, face)
    }

    fn walk(&self, passage: &Passage, memory: &mut Memory) -> u64 {
        count_faces(&self.order, &self.geometry, passage, memory)
    }

    fn build_stats(&self) -> BuildStats {
        self.order.build_stats(&self.geometry)
    }

    fn bytes(&self) -> u64 {
        let occluders = self.occluders.get().map_or(0, |set| set.bytes());
        self.geometry.bytes() + self.order.bytes() + occluders
    }
}

impl<O, C> EditableSector for Culled<O, C>
where
    O: Order,
    C: Hides,
    O::Gives: Gives<C::CullNeeds>,
{
    fn geometry(&self) -> &Arc<Geometry> {
        &self.geometry
    }

    fn edit(&mut self, changes: &mut Changes, limit: u64) -> Result<EditStats, Unsuited> {
        let (mut edited, done) = edit_order(
            self.method,
            &mut self.order,
            &mut self.geometry,
            changes,
            limit,
            OccluderSet::needs_bytes,
        )?;
        if let Some(occluders) = self.occluders.get_mut() {
            edited.nodes += Arc::make_mut(occluders).follow(&self.geometry, &done);
        }
        Ok(edited)
    }
}

impl<O, C> CoarseMethod for Culled<O, C>
where
    O: Order,
    C: Hides + Coarse,
    O::Gives: Gives<C::CullNeeds>,
{
    type Order = O;
    type Cover = C;

    fn order(&self) -> &O {
        &self.order
    }
}
