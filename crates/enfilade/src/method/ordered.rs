//! Methods without a cover: the order alone decides what is potentially visible.
//!
//! For orders with precomputed visibility, which never emit hidden geometry. The potentially visible set is drawn with
//! a z-buffer, so the picture is exact although the set is not. With that z-buffer as its cover, a method would report
//! only what is visible at samples: its set would no longer be strict.

use super::count::count_faces;
use super::editable::{EditStats, EditableSector, edit_order};
use super::found::{OcclusionTest, find};
use super::gathered::draw_gathered;
use super::{Method, TooLarge, Unsuited};
use crate::canvas::Canvas;
use crate::collector::Collector;
use crate::faces::Faces;
use crate::geom::Aabb;
use crate::geometry::{Changes, Geometry, ItemId, Opening};
use crate::memory::Memory;
use crate::order::Order;
use crate::passage::Passage;
use crate::region::{Region, Visibility};
use crate::sector::{BuildStats, Contract, Hit, Ray, Sector, Surface};
use crate::stats::Stats;
use std::sync::Arc;

/// Method made of an order alone: what the order emits is the visible set.
///
/// Used by [`Pvs`](crate::Pvs).
pub struct Ordered<O> {
    method: Method,
    geometry: Arc<Geometry>,
    order: O,
}

impl<O: Order> Ordered<O> {
    pub(super) fn build(method: Method, geometry: Arc<Geometry>, limit: u64) -> Result<Self, Unsuited> {
        let needs_bytes = O::needs_bytes(&geometry);
        if needs_bytes > limit {
            return Err(TooLarge::new(method, needs_bytes, limit).into());
        }
        let order =
            O::build(&geometry, limit).map_err(|refusal| Unsuited::of(method, &geometry, refusal, limit))?;
        Ok(Ordered {
            method,
            order,
            geometry,
        })
    }
}

/// An occlusion test that every box and face passes.
struct NoCover;

impl OcclusionTest for NoCover {
    const TAKES_FACES: bool = false;

    fn test(&mut self, _region: &Region) -> Visibility {
        Visibility::Partial
    }

    fn test_and_add(&mut self, _: &Faces, _: &Region, _: &Passage, _: &mut Stats) -> bool {
        true
    }

    fn test_faces(&mut self, _: &Faces, _: &Region, _: &Passage, _: &mut Stats) -> bool {
        true
    }
}

impl<O: Order> Sector for Ordered<O> {
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
        find(&self.order, &self.geometry, passage, &mut NoCover, memory, seen);
    }

    fn draw(&self, passage: &Passage, memory: &mut Memory, seen: &mut Collector, canvas: &mut dyn Canvas) {
        draw_gathered(&self.geometry, passage, memory, seen, canvas);
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
        self.geometry.bytes() + self.order.bytes()
    }
}

impl<O: Order> EditableSector for Ordered<O> {
    fn geometry(&self) -> &Arc<Geometry> {
        &self.geometry
    }

    fn edit(&mut self, changes: &mut Changes, limit: u64) -> Result<EditStats, Unsuited> {
        let Self {
            method,
            geometry,
            order,
            ..
        } = self;
        edit_order(*method, order, geometry, changes, limit, |_| 0).map(|(edited, _)| edited)
    }
}
