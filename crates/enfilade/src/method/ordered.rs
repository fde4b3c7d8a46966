//! Content seen by an order alone: what it hands out is the set.
//!
//! For orders that know more than where things are: what cannot be seen never comes. No cover culls what comes.
//! Drawn by a z-buffer, which gets what may be seen and nothing else: the picture is exact though the set is not.

use super::count::count_faces;
use super::found::{Against, find};
use super::gathered::draw_gathered;
use super::ours::{Edited, Ours, edit_order};
use super::{Method, TooLarge, Unsuited};
use crate::canvas::Canvas;
use crate::content::{Changes, Content, ItemId, Opening};
use crate::faces::Faces;
use crate::geom::Aabb;
use crate::memory::Memory;
use crate::order::Order;
use crate::passage::Passage;
use crate::region::{Region, Sight};
use crate::sector::{Built, Contract, Hit, Ray, Sector, Surface};
use crate::seen::Seen;
use crate::stats::Stats;
use std::sync::Arc;

/// Content seen by an order alone.
pub struct Ordered<O> {
    method: Method,
    content: Arc<Content>,
    order: O,
}

impl<O: Order> Ordered<O> {
    pub(super) fn build(method: Method, content: Arc<Content>, limit: u64) -> Result<Self, Unsuited> {
        let needs_bytes = O::needs_bytes(&content);
        if needs_bytes > limit {
            return Err(TooLarge::new(method, needs_bytes, limit).into());
        }
        let order =
            O::build(&content, limit).map_err(|refusal| Unsuited::of(method, &content, refusal, limit))?;
        Ok(Ordered {
            method,
            order,
            content,
        })
    }
}

/// Nothing hides what the order hands out.
struct Open;

impl Against for Open {
    const TAKES_FACES: bool = false;

    fn sees(&mut self, _region: &Region) -> Sight {
        Sight::Partly
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
        self.content.bounds()
    }

    fn openings(&self) -> &[Opening] {
        self.content.openings()
    }

    fn contract(&self) -> Contract {
        self.method.contract()
    }

    fn draws_what_was_gathered(&self, _memory: &Memory) -> bool {
        true
    }

    fn gather(&self, passage: &Passage, memory: &mut Memory, seen: &mut Seen) {
        find(&self.order, &self.content, passage, &mut Open, memory, seen);
    }

    fn draw(&self, passage: &Passage, memory: &mut Memory, seen: &mut Seen, canvas: &mut dyn Canvas) {
        draw_gathered(&self.content, passage, memory, seen, canvas);
    }

    fn cast(&self, ray: &Ray) -> Option<Hit> {
        self.content.cast(ray)
    }

    fn surface(&self, item: ItemId, face: u32) -> Surface {
        self.content.surface(item, face)
    }

    fn walk(&self, passage: &Passage, memory: &mut Memory) -> u64 {
        count_faces(&self.order, &self.content, passage, memory)
    }

    fn built(&self) -> Built {
        self.order.built(&self.content)
    }

    fn bytes(&self) -> u64 {
        self.content.bytes() + self.order.bytes()
    }
}

impl<O: Order> Ours for Ordered<O> {
    fn content(&self) -> &Arc<Content> {
        &self.content
    }

    fn edit(&mut self, changes: &mut Changes, limit: u64) -> Result<Edited, Unsuited> {
        let Self {
            method,
            content,
            order,
            ..
        } = self;
        edit_order(*method, order, content, changes, limit, |_| 0).map(|(edited, _)| edited)
    }
}
