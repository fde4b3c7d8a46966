//! Floating horizon for out-of-core terrain: a traversal of its own, and the same cover as for terrain in a geometry.
//!
//! Such terrain is a sector of its own and has no choice of method: the items of a geometry have meshes, which every
//! order, cover and query may read, while these triangles exist only while a look visits their block.

use super::combined::Count;
use super::strips::{self, look_in_strips};
use crate::contract::Contract;
use crate::cover::{Cover, Horizon, Paints};
use crate::faces::{FaceSource, Faces};
use crate::geom::Aabb;
use crate::geometry::Opening;
use crate::ids::ItemIndex;
use crate::large_terrain::{LargeTerrain, Workplace};
use crate::order::Visit;
use crate::sector::{BuildStats, Hit, Ray, Sector, Surface};
use crate::stats::Stats;
use crate::view::canvas::Canvas;
use crate::view::collector::Collector;
use crate::view::memory::Memory;
use crate::view::options::ViewerOptions;
use crate::view::passage::Passage;
use crate::view::region::{Region, Visibility};

impl LargeTerrain {
    fn look(
        &self,
        passage: &Passage,
        memory: &mut Memory,
        seen: &mut Collector,
        mut canvas: Option<&mut dyn Canvas>,
    ) {
        let mut cover = memory.take::<Horizon>();
        let mut workplace = memory.take::<Workplace>();
        cover.clear(passage, memory.trace);
        let mut walk = Walk {
            passage,
            cover: &mut cover,
            stats: &mut memory.stats,
        };
        self.visit(passage, &mut workplace, &mut walk);
        cover.finish(
            self,
            passage,
            seen,
            canvas.as_mut().map(|canvas| &mut **canvas as _),
        );
        if let Some(canvas) = canvas.filter(|canvas| canvas.wants_cover()) {
            cover.show(passage, canvas);
        }
        memory.put_back(cover);
        memory.put_back(workplace);
    }
}

/// Connects the traversal to the cover.
struct Walk<'a> {
    passage: &'a Passage,
    cover: &'a mut Horizon,
    stats: &'a mut Stats,
}

impl Visit for Walk<'_> {
    fn enter(&mut self, region: &Region) -> Visibility {
        self.stats.boxes_tested += 1;
        let visibility = self.cover.test(region);
        self.stats.boxes_hidden += u64::from(visibility == Visibility::Hidden);
        visibility
    }

    /// Always `true`: each block is in exactly one square, so it is visited once.
    fn first_time(&mut self, _item: ItemIndex) -> bool {
        true
    }

    fn faces(&mut self, faces: &Faces) {
        self.cover.add(faces, self.passage, self.stats, None);
    }
}

/// Reports all blocks and openings in the clip region.
struct NoCover<'a> {
    seen: &'a mut Collector,
}

impl Visit for NoCover<'_> {
    fn enter(&mut self, _region: &Region) -> Visibility {
        Visibility::Partial
    }

    fn first_time(&mut self, _item: ItemIndex) -> bool {
        true
    }

    fn faces(&mut self, faces: &Faces) {
        match faces.source {
            FaceSource::Item(item, _) => self.seen.item(item),
            FaceSource::Opening(opening) => self.seen.opening(opening, None),
        }
    }
}

impl Sector for LargeTerrain {
    fn bounds(&self) -> Aabb {
        let ground = self.bounds_of(self.level_count() - 1, [0, 0]);
        ground.union(&self.holes().bounds())
    }

    fn openings(&self) -> &[Opening] {
        self.holes().openings()
    }

    fn contract(&self, options: &ViewerOptions) -> Contract {
        if !options.occlusion {
            Contract::Strict
        } else if options.margin() > 0.0 {
            Contract::Conservative
        } else {
            Contract::Exact
        }
    }

    fn gather(&self, passage: &Passage, memory: &mut Memory, seen: &mut Collector) {
        if passage.options.margin() > 0.0 || !passage.options.occlusion {
            let mut workplace = memory.take::<Workplace>();
            self.visit(passage, &mut workplace, &mut NoCover { seen });
            memory.put_back(workplace);
            return;
        }
        let strips = strips::count(passage);
        if strips > 1 {
            look_in_strips(strips, self, passage, memory, seen, |strip, memory, seen| {
                self.look(strip, memory, seen, None);
            });
        } else {
            self.look(passage, memory, seen, None);
        }
        memory.stats.samples_owned += seen.samples_owned;
    }

    fn draw(&self, passage: &Passage, memory: &mut Memory, seen: &mut Collector, canvas: &mut dyn Canvas) {
        // No strips here: a canvas receives its rows in order.
        self.look(passage, memory, seen, Some(canvas));
        memory.stats.samples_owned += seen.samples_owned;
    }

    fn cast(&self, ray: &Ray) -> Option<Hit> {
        self.first_along(ray)
    }

    fn surface(&self, item: ItemIndex, face: u32) -> Surface {
        self.surface_of(item, face)
    }

    fn walk(&self, passage: &Passage, memory: &mut Memory) -> u64 {
        let mut workplace = memory.take::<Workplace>();
        let mut count = Count::new(&mut memory.marks);
        self.visit(passage, &mut workplace, &mut count);
        let faces = count.faces;
        memory.put_back(workplace);
        faces
    }

    fn build_stats(&self) -> BuildStats {
        BuildStats {
            faces: self.triangle_count(),
            ..BuildStats::default()
        }
    }

    fn bytes(&self) -> u64 {
        self.own_bytes()
    }

    fn item_count(&self) -> u32 {
        self.blocks().iter().product()
    }

    fn item_name(&self, item: ItemIndex) -> String {
        let [column, row] = self.block_at(item);
        format!("block {row} {column}")
    }

    fn item_bounds(&self, item: ItemIndex) -> Aabb {
        self.bounds_of(0, self.block_at(item))
    }

    fn item_triangles(&self, item: ItemIndex, clusters: &[u32]) -> u64 {
        let block = self.block_at(item);
        let columns = self.squares(block)[0];
        if clusters.is_empty() {
            return self.triangles_of_block(block);
        }
        let squares = clusters.iter().map(|number| [number % columns, number / columns]);
        squares
            .map(|place| self.square(block, place).triangle_count())
            .sum()
    }
}
