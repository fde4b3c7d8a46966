//! Adapter for methods whose cover can have a lower resolution than the screen.
//!
//! Idea: a low-resolution cover holds no picture. A face occludes only the cells that it covers fully, and the
//!     potentially visible set is drawn with a z-buffer. Coarser cells cost less and cull less.
//! Source: Boreskov, Hierarchical s-buffer for scenes of high complexity, section 3: the cover only culls, at a lower
//!     resolution than the screen, and another rasterizer draws.
//! Conservative at the screen's samples, and at any position between them.

use super::combined::Combination;
use super::enlarged::CellUpscaler;
use super::found::{OcclusionTest, find};
use super::gathered::draw_gathered;
use super::{Culled, Paired};
use crate::contract::Contract;
use crate::cover::{Coarse, CoarseCoverage, Cover, DepthBuffer};
use crate::faces::Faces;
use crate::geometry::{Exchanged, Geometry};
use crate::order::Order;
use crate::stats::Stats;
use crate::view::aperture::CellRoom;
use crate::view::canvas::{Canvas, CoverShape};
use crate::view::collector::Collector;
use crate::view::memory::Memory;
use crate::view::options::ViewerOptions;
use crate::view::passage::Passage;
use crate::view::region::{Region, Visibility};

/// A method whose cover can work on cells.
pub(super) trait CoarseCombination: Combination {
    type Cover: Coarse;
}

impl<O: Order, C: Coarse> CoarseCombination for Paired<O, C>
where
    Self: Combination<Order = O>,
{
    type Cover = C;
}

impl<O: Order, C: Coarse> CoarseCombination for Culled<O, C>
where
    Self: Combination<Order = O>,
{
    type Cover = C;
}

/// A method that uses a cover of cells if the viewer has set a cover size or a margin, and its normal one otherwise.
pub(super) struct InCells<M>(M);

/// Occlusion test against a low-resolution cover, into which faces are rasterized by the cells that they cover fully.
struct CellCover<'a, C> {
    cover: &'a mut C,
    surface: &'a mut CoarseCoverage,
}

impl<C: Coarse> OcclusionTest for CellCover<'_, C> {
    const TAKES_FACES: bool = true;
    const TESTS_FACES: bool = true;

    fn test(&mut self, region: &Region) -> Visibility {
        if self.cover.sees_cells(&region.rect, region.nearest) {
            Visibility::Partial
        } else {
            Visibility::Hidden
        }
    }

    fn test_and_add(&mut self, faces: &Faces, region: &Region, passage: &Passage, stats: &mut Stats) -> bool {
        let seen = self.test_faces(faces, region, passage, stats);
        if seen && faces.can_occlude && CoarseCoverage::is_worth(faces, region) {
            self.surface.add(faces, passage, stats, self.cover);
        }
        seen
    }

    fn test_faces(&mut self, faces: &Faces, region: &Region, passage: &Passage, _stats: &mut Stats) -> bool {
        !CoarseCoverage::is_worth(faces, region) || self.surface.may_show(faces, passage, self.cover)
    }
}

impl<M: CoarseCombination> InCells<M> {
    fn look(
        order: &M::Order,
        geometry: &Geometry,
        cells: [u32; 2],
        whole: &Passage,
        memory: &mut Memory,
        seen: &mut Collector,
        canvas: Option<&mut dyn Canvas>,
    ) {
        let mut room = memory.take::<CellRoom>();
        let mut cover = memory.take::<M::Cover>();
        let mut surface = memory.take::<CoarseCoverage>();
        let passage = whole.in_cells(cells, &mut room);
        cover.clear_cells(&passage);
        surface.clear(&passage);
        let mut occlusion = CellCover {
            cover: &mut *cover,
            surface: &mut surface,
        };
        find(order, geometry, &passage, &mut occlusion, memory, seen);
        if let Some(canvas) = canvas {
            cover.show(&passage, &mut CellUpscaler::new(canvas, whole, cells));
        }
        room.take_back(passage.aperture);
        memory.put_back(room);
        memory.put_back(cover);
        memory.put_back(surface);
    }
}

impl<M: CoarseCombination> Combination for InCells<M> {
    type Order = M::Order;

    const COVER: &'static str = M::COVER;
    const CONTRACT: Contract = M::CONTRACT;
    const TAKES_COVER_SIZE: bool = true;
    const OCCLUDERS: Option<u32> = M::OCCLUDERS;
    const COVER_SHAPE: Option<CoverShape> = M::COVER_SHAPE;

    fn screen_bytes(size: [u32; 2], cover_size: Option<[u32; 2]>) -> u64 {
        match cover_size.filter(|&cells| cells != size) {
            // The picture is drawn with a z-buffer then.
            Some(cells) => {
                M::Cover::needs_bytes(cells)
                    + CoarseCoverage::needs_bytes(cells)
                    + DepthBuffer::needs_bytes(size)
            }
            None => M::screen_bytes(size, None),
        }
    }

    fn needs_bytes(geometry: &Geometry) -> u64 {
        M::needs_bytes(geometry)
    }

    fn new(geometry: &Geometry) -> Self {
        InCells(M::new(geometry))
    }

    fn draws_what_was_gathered(&self, options: &ViewerOptions) -> bool {
        options.cover_size.is_some() || options.margin() > 0.0 || self.0.draws_what_was_gathered(options)
    }

    fn gather(
        &self,
        order: &M::Order,
        geometry: &Geometry,
        passage: &Passage,
        memory: &mut Memory,
        seen: &mut Collector,
    ) {
        match passage.options.cells(passage.size) {
            Some(cells) => Self::look(order, geometry, cells, passage, memory, seen, None),
            None => self.0.gather(order, geometry, passage, memory, seen),
        }
    }

    fn draw(
        &self,
        order: &M::Order,
        geometry: &Geometry,
        passage: &Passage,
        memory: &mut Memory,
        seen: &mut Collector,
        canvas: &mut dyn Canvas,
    ) {
        let Some(cells) = passage.options.cells(passage.size) else {
            return self.0.draw(order, geometry, passage, memory, seen, canvas);
        };
        draw_gathered(geometry, passage, memory, seen, canvas);
        if canvas.wants_cover() {
            let (stats, mut unused) = (memory.stats, Collector::default());
            Self::look(order, geometry, cells, passage, memory, &mut unused, Some(canvas));
            memory.stats = stats;
        }
    }

    fn bytes(&self) -> u64 {
        self.0.bytes()
    }

    fn follow(&mut self, geometry: &Geometry, done: &mut Exchanged) -> u64 {
        self.0.follow(geometry, done)
    }
}
