//! Methods without a cover: the order alone decides what is potentially visible.
//!
//! For orders with precomputed visibility, which never emit hidden geometry. The potentially visible set is drawn with
//! a z-buffer, so the picture is exact although the set is not. With that z-buffer as its cover, a method would report
//! only what is visible at samples: its set would no longer be strict.

use super::combined::Combination;
use super::found::{OcclusionTest, find};
use super::gathered::draw_gathered;
use crate::contract::Contract;
use crate::cover::{Cover, DepthBuffer};
use crate::faces::Faces;
use crate::geometry::Geometry;
use crate::order::Order;
use crate::stats::Stats;
use crate::view::canvas::{Canvas, CoverShape};
use crate::view::collector::Collector;
use crate::view::memory::Memory;
use crate::view::passage::Passage;
use crate::view::region::{Region, Visibility};
use std::marker::PhantomData;

/// Method made of an order alone: what the order emits is the visible set.
///
/// Used by [`Pvs`](crate::Pvs).
pub struct Ordered<O>(PhantomData<fn() -> O>);

impl<O: Order> Combination for Ordered<O> {
    type Order = O;

    const COVER: &'static str = "";
    const CONTRACT: Contract = Contract::Strict;
    const COVER_SHAPE: Option<CoverShape> = DepthBuffer::SHAPE;

    fn screen_bytes(size: [u32; 2], _cover_size: Option<[u32; 2]>) -> u64 {
        DepthBuffer::needs_bytes(size)
    }

    fn new(_geometry: &Geometry) -> Self {
        Ordered(PhantomData)
    }

    fn gather(
        &self,
        order: &O,
        geometry: &Geometry,
        passage: &Passage,
        memory: &mut Memory,
        seen: &mut Collector,
    ) {
        find(order, geometry, passage, &mut NoCover, memory, seen);
    }

    fn draw(
        &self,
        _order: &O,
        geometry: &Geometry,
        passage: &Passage,
        memory: &mut Memory,
        seen: &mut Collector,
        canvas: &mut dyn Canvas,
    ) {
        draw_gathered(geometry, passage, memory, seen, canvas);
    }
}

/// An occlusion test that every box and face passes.
pub(super) struct NoCover;

impl OcclusionTest for NoCover {
    const TAKES_FACES: bool = false;

    fn test(&mut self, _region: &Region) -> Visibility {
        Visibility::Partial
    }

    fn test_and_add(&mut self, _: &Faces, _: &Region, _: &Passage, _: &mut Stats) -> bool {
        true
    }
}
