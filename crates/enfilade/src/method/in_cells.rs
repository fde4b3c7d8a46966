//! Adapter for methods whose cover can have a lower resolution than the screen.
//!
//! Idea: a low-resolution cover holds no picture. A face occludes only the cells that it covers fully, and the
//!     potentially visible set is drawn with a z-buffer. Coarser cells cost less and cull less.
//! Source: Boreskov, Hierarchical s-buffer for scenes of high complexity, section 3: the cover only culls, at a lower
//!     resolution than the screen, and another rasterizer draws.
//! Conservative at the screen's samples, and at any position between them.

use super::Unsuited;
use super::editable::{EditStats, EditableSector};
use super::enlarged::CellUpscaler;
use super::found::{OcclusionTest, find};
use super::gathered::draw_gathered;
use crate::aperture::CellRoom;
use crate::canvas::Canvas;
use crate::collector::Collector;
use crate::cover::{Coarse, CoarseCoverage, Cover};
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

/// A method whose cover can work on cells.
pub(super) trait CoarseMethod: EditableSector {
    type Order: Order;
    type Cover: Coarse;

    fn order(&self) -> &Self::Order;
}

/// A method that uses a low-resolution cover if the viewer has set a cover size, and its normal one otherwise.
pub(super) struct CoarseAdapter<M>(pub(super) M);

/// Occlusion test against a low-resolution cover, into which faces are rasterized by the cells that they cover fully.
struct CellCover<'a, C> {
    cover: &'a mut C,
    surface: &'a mut CoarseCoverage,
}

impl<C: Coarse> OcclusionTest for CellCover<'_, C> {
    const TAKES_FACES: bool = true;

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

impl<M: CoarseMethod> CoarseAdapter<M> {
    fn look(
        &self,
        cells: [u32; 2],
        whole: &Passage,
        memory: &mut Memory,
        seen: &mut Collector,
        canvas: Option<&mut dyn Canvas>,
    ) {
        let geometry = self.0.geometry();
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
        find(self.0.order(), geometry, &passage, &mut occlusion, memory, seen);
        if let Some(canvas) = canvas {
            cover.show(&passage, &mut CellUpscaler::new(canvas, whole, cells));
        }
        room.take_back(passage.aperture);
        memory.put_back(room);
        memory.put_back(cover);
        memory.put_back(surface);
    }
}

impl<M: CoarseMethod> Sector for CoarseAdapter<M> {
    fn bounds(&self) -> Aabb {
        self.0.bounds()
    }

    fn openings(&self) -> &[Opening] {
        self.0.openings()
    }

    fn contract(&self) -> Contract {
        self.0.contract()
    }

    fn draws_what_was_gathered(&self, memory: &Memory) -> bool {
        memory.cover_size.is_some() || self.0.draws_what_was_gathered(memory)
    }

    fn gather(&self, passage: &Passage, memory: &mut Memory, seen: &mut Collector) {
        match memory.cover_size {
            Some(cells) => self.look(cells, passage, memory, seen, None),
            None => self.0.gather(passage, memory, seen),
        }
    }

    fn draw(&self, passage: &Passage, memory: &mut Memory, seen: &mut Collector, canvas: &mut dyn Canvas) {
        let Some(cells) = memory.cover_size else {
            return self.0.draw(passage, memory, seen, canvas);
        };
        draw_gathered(self.0.geometry(), passage, memory, seen, canvas);
        if canvas.wants_cover() {
            let stats = memory.stats;
            self.look(cells, passage, memory, &mut Collector::default(), Some(canvas));
            memory.stats = stats;
        }
    }

    fn cast(&self, ray: &Ray) -> Option<Hit> {
        self.0.cast(ray)
    }

    fn surface(&self, item: ItemId, face: u32) -> Surface {
        self.0.surface(item, face)
    }

    fn walk(&self, passage: &Passage, memory: &mut Memory) -> u64 {
        self.0.walk(passage, memory)
    }

    fn build_stats(&self) -> BuildStats {
        self.0.build_stats()
    }

    fn bytes(&self) -> u64 {
        self.0.bytes()
    }
}

impl<M: CoarseMethod> EditableSector for CoarseAdapter<M> {
    fn geometry(&self) -> &Arc<Geometry> {
        self.0.geometry()
    }

    fn edit(&mut self, changes: &mut Changes, limit: u64) -> Result<EditStats, Unsuited> {
        self.0.edit(changes, limit)
    }
}
