//! A method whose cover may be of lower resolution than the screen.
//!
//! In cells the cover holds no picture: faces go in as far as they cover cells whole, and what may be seen is drawn by a
//! z-buffer. Coarser cells cost less and hide less.
//! Source: Boreskov, Hierarchical s-buffer for scenes of high complexity, section 3: the cover only culls, at a lower
//!     resolution than the screen, and another rasteriser draws.
//! Conservative at the screen's samples, and at any place between them.

use super::enlarged::Enlarged;
use super::gathered::draw_gathered;
use crate::aperture::CellRoom;
use crate::canvas::Canvas;
use crate::content::{Content, ItemId, Opening, OpeningId};
use crate::cover::{Coarse, Cover, Surface};
use crate::faces::{Faces, Of};
use crate::fragment::{Built, Contract, Fragment, Hit, Ray, Surface as FaceSurface};
use crate::geom::Aabb;
use crate::memory::{Marks, Memory};
use crate::order::{Order, Visit};
use crate::passage::Passage;
use crate::region::{Region, Sight};
use crate::seen::{Seen, report_owners};
use crate::stats::Stats;

/// An order and a cover that can do with cells.
pub(super) trait InParts: Fragment {
    type Order: Order;
    type Cover: Coarse;

    fn order(&self) -> &Self::Order;
    fn content(&self) -> &Content;
}

/// A method that looks in cells where the viewer asks for them, and as it is where not.
pub(super) struct InCells<M>(pub(super) M);

/// Clusters and openings that the walk finds.
#[derive(Default)]
struct Found {
    clusters: Vec<(ItemId, u32)>,
    openings: Vec<OpeningId>,
}

/// Joins an order's walk to a cover in cells.
struct Walk<'a, C> {
    passage: &'a Passage,
    content: &'a Content,
    cover: &'a mut C,
    surface: &'a mut Surface,
    marks: &'a mut Marks,
    stats: &'a mut Stats,
    found: &'a mut Found,
}

impl<C: Coarse> Visit for Walk<'_, C> {
    fn enter(&mut self, region: &Region) -> Sight {
        self.stats.boxes_tested += 1;
        if self.cover.sees_cells(&region.rect, region.nearest) {
            return Sight::Partly;
        }
        self.stats.boxes_hidden += 1;
        Sight::Hidden
    }

    fn first_time(&mut self, item: ItemId) -> bool {
        self.marks.first_time(item)
    }

    fn faces(&mut self, faces: &Faces) {
        match faces.of {
            Of::Item(item, cluster) => {
                let Some(region) = self.region_of(faces, item, cluster) else {
                    return;
                };
                let worth = Surface::is_worth(faces, &region);
                if worth && !self.surface.may_show(faces, self.passage, self.cover) {
                    return;
                }
                self.found.clusters.push((item, cluster));
                if worth && faces.may_be_chosen {
                    self.surface.add(faces, self.passage, self.stats, self.cover);
                }
            }
            Of::Opening(opening) => self.found.openings.push(opening),
        }
    }
}

impl<M: InParts> InCells<M> {
    fn look(
        &self,
        cells: [u32; 2],
        whole: &Passage,
        memory: &mut Memory,
        seen: &mut Seen,
        canvas: Option<&mut dyn Canvas>,
    ) {
        let content = self.0.content();
        let mut room = memory.take::<CellRoom>();
        let mut cover = memory.take::<M::Cover>();
        let mut surface = memory.take::<Surface>();
        let mut scratch = memory.take::<<M::Order as Order>::Scratch>();
        let mut found = memory.take::<Found>();
        let passage = whole.in_cells(cells, &mut room);
        cover.clear_cells(&passage);
        surface.clear(&passage);
        memory.marks.begin(content.items().len());
        let mut walk = Walk {
            passage: &passage,
            content,
            cover: &mut *cover,
            surface: &mut surface,
            marks: &mut memory.marks,
            stats: &mut memory.stats,
            found: &mut found,
        };
        self.0.order().visit(content, &passage, &mut scratch, &mut walk);
        walk.look_again();
        report_owners(&mut found.clusters, content, seen);
        found.clusters.clear();
        for opening in found.openings.drain(..) {
            seen.opening(opening, None);
        }
        if let Some(canvas) = canvas {
            cover.show(&passage, &mut Enlarged::new(canvas, whole, cells));
        }
        room.take_back(passage.aperture);
        memory.put_back(room);
        memory.put_back(cover);
        memory.put_back(surface);
        memory.put_back(scratch);
        memory.put_back(found);
    }
}

impl<C: Coarse> Walk<'_, C> {
    fn region_of(&self, faces: &Faces, item: ItemId, cluster: u32) -> Option<Region> {
        let bounds = &self.content.mesh_of(item).clusters()[cluster as usize].bounds;
        Region::of(self.passage, faces.screen_from_local, bounds)
    }

    /// Drops what came before all that hides it.
    fn look_again(&mut self) {
        let mut clusters = std::mem::take(&mut self.found.clusters);
        clusters.retain(|&(item, cluster)| {
            let screen_from_item = self.passage.screen_from(&self.content.item(item).transform());
            let faces = Faces::of_cluster(self.content, item, cluster, &screen_from_item);
            self.region_of(&faces, item, cluster).is_some_and(|region| {
                self.enter(&region) != Sight::Hidden
                    && (!Surface::is_worth(&faces, &region)
                        || self.surface.may_show(&faces, self.passage, self.cover))
            })
        });
        self.found.clusters = clusters;
        let mut openings = std::mem::take(&mut self.found.openings);
        openings.retain(|opening| {
            let outline = &self.content.openings()[usize::from(opening.0)].outline;
            let region = self.passage.region_of_opening(outline);
            region.is_some_and(|region| self.enter(&region) != Sight::Hidden)
        });
        self.found.openings = openings;
    }
}

impl<M: InParts> Fragment for InCells<M> {
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

    fn gather(&self, passage: &Passage, memory: &mut Memory, seen: &mut Seen) {
        match memory.cover_size {
            Some(cells) => self.look(cells, passage, memory, seen, None),
            None => self.0.gather(passage, memory, seen),
        }
    }

    fn draw(&self, passage: &Passage, memory: &mut Memory, seen: &mut Seen, canvas: &mut dyn Canvas) {
        let Some(cells) = memory.cover_size else {
            return self.0.draw(passage, memory, seen, canvas);
        };
        draw_gathered(self.0.content(), passage, memory, seen, canvas);
        if canvas.wants_cover() {
            let stats = memory.stats;
            self.look(cells, passage, memory, &mut Seen::default(), Some(canvas));
            memory.stats = stats;
        }
    }

    fn cast(&self, ray: &Ray) -> Option<Hit> {
        self.0.cast(ray)
    }

    fn surface(&self, item: ItemId, face: u32) -> FaceSurface {
        self.0.surface(item, face)
    }

    fn walk(&self, passage: &Passage, memory: &mut Memory) -> u64 {
        self.0.walk(passage, memory)
    }

    fn built(&self) -> Built {
        self.0.built()
    }

    fn bytes(&self) -> u64 {
        self.0.bytes()
    }
}
