//! What a walk finds that a cover without a picture does not hide.

use crate::content::{Content, ItemId, OpeningId};
use crate::faces::{Faces, Of};
use crate::memory::{Marks, Memory};
use crate::order::{Order, Visit};
use crate::passage::Passage;
use crate::region::{Region, Sight};
use crate::seen::{Seen, report_owners};
use crate::stats::Stats;

/// What a walk holds things against: a cover, in samples or in cells.
pub(super) trait Against {
    /// Do faces that the walk finds hide what it finds later? Then all that was found is asked about once more at the end.
    const TAKES_FACES: bool;

    /// How much of a box can still be seen.
    fn sees(&mut self, region: &Region) -> Sight;

    /// May any of the faces within `region` be seen? `true` when unsure. From now on they hide what they can. Only asked
    /// where [`Against::TAKES_FACES`], as is the next.
    fn take_faces(&mut self, faces: &Faces, region: &Region, passage: &Passage, stats: &mut Stats) -> bool;

    /// May any of the faces within `region` be seen? `true` when unsure.
    fn sees_faces(&mut self, faces: &Faces, region: &Region, passage: &Passage, stats: &mut Stats) -> bool;
}

/// Clusters and openings that nothing hides.
#[derive(Default)]
struct Found {
    clusters: Vec<(ItemId, u32)>,
    openings: Vec<OpeningId>,
}

/// Reports what an order's walk finds of a content.
pub(super) fn find<O: Order>(
    order: &O,
    content: &Content,
    passage: &Passage,
    against: &mut impl Against,
    memory: &mut Memory,
    seen: &mut Seen,
) {
    let mut scratch = memory.take::<O::Scratch>();
    let mut found = memory.take::<Found>();
    memory.marks.begin(content.items().len());
    let mut walk = Walk {
        passage,
        content,
        against,
        marks: &mut memory.marks,
        stats: &mut memory.stats,
        found: &mut found,
    };
    order.visit(content, passage, &mut scratch, &mut walk);
    walk.look_again();
    report_owners(&mut found.clusters, content, seen);
    found.clusters.clear();
    for opening in found.openings.drain(..) {
        seen.opening(opening, None);
    }
    memory.put_back(scratch);
    memory.put_back(found);
}

/// Joins an order's walk to what it is held against.
struct Walk<'a, A> {
    passage: &'a Passage,
    content: &'a Content,
    against: &'a mut A,
    marks: &'a mut Marks,
    stats: &'a mut Stats,
    found: &'a mut Found,
}

impl<A: Against> Walk<'_, A> {
    fn region_of(&self, faces: &Faces, item: ItemId, cluster: u32) -> Option<Region> {
        let bounds = &self.content.mesh_of(item).clusters()[cluster as usize].bounds;
        Region::of(self.passage, faces.screen_from_local, bounds)
    }

    /// Holds openings, and clusters that came before all that hides them, against all that does.
    fn look_again(&mut self) {
        let Found {
            mut clusters,
            mut openings,
        } = std::mem::take(self.found);
        if A::TAKES_FACES {
            clusters.retain(|&(item, cluster)| {
                let screen_from_item = self.passage.screen_from(&self.content.item(item).transform());
                let faces = Faces::of_cluster(self.content, item, cluster, &screen_from_item);
                self.region_of(&faces, item, cluster).is_some_and(|region| {
                    self.enter(&region) != Sight::Hidden
                        && self.against.sees_faces(&faces, &region, self.passage, self.stats)
                })
            });
        }
        openings.retain(|opening| {
            let outline = &self.content.openings()[usize::from(opening.0)].outline;
            let region = self.passage.region_of_opening(outline);
            region.is_some_and(|region| self.enter(&region) != Sight::Hidden)
        });
        *self.found = Found { clusters, openings };
    }
}

impl<A: Against> Visit for Walk<'_, A> {
    fn enter(&mut self, region: &Region) -> Sight {
        self.stats.boxes_tested += 1;
        let sight = self.against.sees(region);
        self.stats.boxes_hidden += u64::from(sight == Sight::Hidden);
        sight
    }

    fn first_time(&mut self, item: ItemId) -> bool {
        self.marks.first_time(item)
    }

    fn faces(&mut self, faces: &Faces) {
        match faces.of {
            Of::Item(item, cluster) => {
                let stays = !A::TAKES_FACES
                    || self.region_of(faces, item, cluster).is_some_and(|region| {
                        self.against.take_faces(faces, &region, self.passage, self.stats)
                    });
                if stays {
                    self.found.clusters.push((item, cluster));
                }
            }
            Of::Opening(opening) => self.found.openings.push(opening),
        }
    }
}
