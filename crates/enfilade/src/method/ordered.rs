//! Geometry seen by an order alone: what it hands out is the set.
//!
//! For orders that know more than where things are: what cannot be seen never comes. No cover culls what comes.
//! Drawn by a z-buffer, which gets what may be seen and nothing else: the picture is exact though the set is not.

use super::count::count_faces;
use super::editable::{EditStats, EditableSector, edit_order};
use super::found::{Against, find};
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

/// Geometry seen by an order alone.
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

/// Nothing hides what the order hands out.
struct Open;

impl Against for Open {
    const TAKES_FACES: bool = false;

    fn sees(&mut self, _region: &Region) -> Visibility {
        Visibility::Partial
    }

    fn take_faces(&mut self, _: &Faces, _: &Region, _: &Passage, _: &mut Stats) -> bool {
        true
    }

    fn sees_faces(&mut self, _: &Faces, _: &Region, _: &Passage, _: &mut Stats) -> bool {
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
        find(&self.order, &self.geometry, passage, &mut Open, memory, seen);
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
