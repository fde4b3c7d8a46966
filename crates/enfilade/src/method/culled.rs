//! Content seen by an order and a cover that holds no picture: occluders first, then what they leave.
//!
//! Where the cover takes faces too, those of what is found hide what the walk finds later; what was found before them is
//! asked about again at the end. Whatever the budget of chosen occluders, also 0, they do.
//! Drawn by a z-buffer, which gets what may be seen and nothing else: the picture is exact though the set is not.

use super::count::count_faces;
use super::gathered::draw_gathered;
use super::in_cells::InParts;
use super::{Method, TooLarge};
use crate::canvas::Canvas;
use crate::content::{Content, ItemId, Opening, OpeningId};
use crate::cover::{Coarse, Hides};
use crate::faces::{Faces, Of};
use crate::fragment::{Built, Contract, Fragment, Hit, Ray, Surface};
use crate::geom::Aabb;
use crate::memory::{Marks, Memory};
use crate::occluders::{Choice, OccluderRoom, OccluderSet};
use crate::order::{Gives, Order, Visit};
use crate::passage::Passage;
use crate::region::{Region, Sight};
use crate::seen::{Seen, report_owners};
use crate::stats::Stats;
use std::marker::PhantomData;
use std::sync::Arc;

/// Content seen by an order and a cover that holds no picture.
pub struct Culled<O, C> {
    method: Method,
    content: Arc<Content>,
    occluders: Arc<OccluderSet>,
    order: O,
    cover: PhantomData<fn() -> C>,
}

impl<O, C> Culled<O, C>
where
    O: Order,
    C: Hides,
    O::Gives: Gives<C::CullNeeds>,
{
    pub(super) fn build(method: Method, content: Arc<Content>, limit: u64) -> Result<Self, TooLarge> {
        let needs_bytes = O::needs_bytes(&content) + OccluderSet::needs_bytes(&content);
        if needs_bytes > limit {
            return Err(TooLarge::new(method, needs_bytes, limit));
        }
        let order = O::build(&content, limit).ok_or_else(|| TooLarge::new(method, needs_bytes, limit))?;
        Ok(Culled {
            method,
            occluders: content.share(|| OccluderSet::build(&content)),
            order,
            content,
            cover: PhantomData,
        })
    }

    /// Starts a cover over, with the occluders that are worth most.
    fn fill(&self, cover: &mut C, passage: &Passage, memory: &mut Memory) {
        let mut choice = memory.take::<Choice>();
        let mut room = memory.take::<OccluderRoom>();
        cover.clear(passage);
        let budget = memory.occluders.unwrap_or(C::OCCLUDERS) as usize;
        let set = &self.occluders;
        let mut choosing = set.choosing(&self.content, passage, C::MEASURE, &mut choice);
        for _ in 0..budget {
            let Some(chosen) = choosing.next(|region| !cover.hides(region)) else {
                break;
            };
            if let Some(occluder) = set.on_screen(&self.content, passage, &chosen, &mut room) {
                memory.stats.occluders += 1;
                cover.hide(&occluder, passage, &mut memory.stats);
            }
        }
        memory.put_back(choice);
        memory.put_back(room);
    }

    /// Reports what may be seen past the cover, which knows at the end all that hides.
    fn look(&self, cover: &mut C, passage: &Passage, memory: &mut Memory, seen: &mut Seen) {
        let mut scratch = memory.take::<O::Scratch>();
        let mut found = memory.take::<Found>();
        self.fill(cover, passage, memory);
        memory.marks.begin(self.content.items().len());
        let mut walk = Walk {
            passage,
            content: &self.content,
            cover,
            marks: &mut memory.marks,
            stats: &mut memory.stats,
            found: &mut found,
        };
        self.order.visit(&self.content, passage, &mut scratch, &mut walk);
        if C::TAKES_FACES {
            walk.look_again();
        }
        report_owners(&mut found.clusters, &self.content, seen);
        found.clusters.clear();
        for opening in found.openings.drain(..) {
            seen.opening(opening, None);
        }
        memory.put_back(scratch);
        memory.put_back(found);
    }
}

/// What is found by a walk: clusters and openings that nothing hides.
#[derive(Default)]
struct Found {
    clusters: Vec<(ItemId, u32)>,
    openings: Vec<OpeningId>,
}

/// Joins an order's walk to a cover.
struct Walk<'a, C> {
    passage: &'a Passage,
    content: &'a Content,
    cover: &'a mut C,
    marks: &'a mut Marks,
    stats: &'a mut Stats,
    found: &'a mut Found,
}

impl<C: Hides> Walk<'_, C> {
    /// Lets the faces of a cluster hide what is behind them; may any of them be seen?
    fn hide_faces(&mut self, faces: &Faces, item: ItemId, cluster: u32) -> bool {
        self.region_of(faces, item, cluster)
            .is_some_and(|region| self.cover.hide_faces(faces, &region, self.passage, self.stats))
    }

    fn region_of(&self, faces: &Faces, item: ItemId, cluster: u32) -> Option<Region> {
        let bounds = &self.content.mesh_of(item).clusters()[cluster as usize].bounds;
        Region::of(self.passage, faces.screen_from_local, bounds)
    }

    /// Drops what is hidden by what was found after it.
    fn look_again(&mut self) {
        let mut clusters = std::mem::take(&mut self.found.clusters);
        clusters.retain(|&(item, cluster)| {
            let screen_from_item = self.passage.screen_from(&self.content.item(item).transform());
            let faces = Faces::of_cluster(self.content, item, cluster, &screen_from_item);
            self.region_of(&faces, item, cluster).is_some_and(|region| {
                self.enter(&region) != Sight::Hidden
                    && self.cover.sees_faces(&faces, &region, self.passage, self.stats)
            })
        });
        self.found.clusters = clusters;
        let mut openings = std::mem::take(&mut self.found.openings);
        openings.retain(|&opening| self.sees_opening(opening));
        self.found.openings = openings;
    }

    fn sees_opening(&mut self, opening: OpeningId) -> bool {
        let outline = &self.content.openings()[usize::from(opening.0)].outline;
        let region = self.passage.region_of_opening(outline);
        region.is_some_and(|region| self.enter(&region) != Sight::Hidden)
    }
}

impl<C: Hides> Visit for Walk<'_, C> {
    fn enter(&mut self, region: &Region) -> Sight {
        self.stats.boxes_tested += 1;
        let sight = self.cover.sees(region);
        self.stats.boxes_hidden += u64::from(sight == Sight::Hidden);
        sight
    }

    fn first_time(&mut self, item: ItemId) -> bool {
        self.marks.first_time(item)
    }

    fn faces(&mut self, faces: &Faces) {
        match faces.of {
            Of::Item(item, cluster) => {
                let hides = C::TAKES_FACES && faces.may_be_chosen;
                if !hides || self.hide_faces(faces, item, cluster) {
                    self.found.clusters.push((item, cluster));
                }
            }
            Of::Opening(opening) => {
                if self.sees_opening(opening) {
                    self.found.openings.push(opening);
                }
            }
        }
    }
}

impl<O, C> Fragment for Culled<O, C>
where
    O: Order,
    C: Hides,
    O::Gives: Gives<C::CullNeeds>,
{
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
        let mut cover = memory.take::<C>();
        self.look(&mut cover, passage, memory, seen);
        memory.put_back(cover);
    }

    fn draw(&self, passage: &Passage, memory: &mut Memory, seen: &mut Seen, canvas: &mut dyn Canvas) {
        draw_gathered(&self.content, passage, memory, seen, canvas);
        if canvas.wants_cover() {
            // Other passages have used it since it was asked.
            let mut cover = memory.take::<C>();
            let stats = memory.stats;
            self.look(&mut cover, passage, memory, &mut Seen::default());
            memory.stats = stats;
            cover.show(passage, canvas);
            memory.put_back(cover);
        }
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
        self.content.bytes() + self.order.bytes() + self.occluders.bytes()
    }
}

impl<O, C> InParts for Culled<O, C>
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

    fn content(&self) -> &Content {
        &self.content
    }
}
