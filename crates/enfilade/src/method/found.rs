//! What a walk finds that a cover without a picture does not hide.

use crate::collector::{Collector, FoundClusters};
use crate::faces::{FaceSource, Faces};
use crate::geom::Aabb;
use crate::geometry::{Geometry, ItemId, OpeningId};
use crate::memory::{Marks, Memory};
use crate::order::{Order, Visit};
use crate::passage::Passage;
use crate::region::{Region, Visibility};
use crate::stats::Stats;
use glam::DAffine3;

/// What a walk holds things against: a cover, in samples or in cells.
pub(super) trait Against {
    /// Do faces that the walk finds hide what it finds later? Then all that was found is asked about once more at the end.
    const TAKES_FACES: bool;

    /// How much of a box can still be seen.
    fn sees(&mut self, region: &Region) -> Visibility;

    /// As [`Against::sees`], of a box given in another space; `None` where it is out of view.
    fn sight_of(
        &mut self,
        passage: &Passage,
        screen_from_local: &DAffine3,
        bounds: &Aabb,
    ) -> Option<Visibility> {
        Region::of(passage, screen_from_local, bounds).map(|region| self.sees(&region))
    }

    /// From now on all boxes lie in the one that was asked about last.
    fn go_within(&mut self) {}

    /// From now on boxes lie anywhere again.
    fn go_back(&mut self) {}

    /// May any of the faces within `region` be seen? `true` when unsure. From now on they hide what they can. Only asked
    /// where [`Against::TAKES_FACES`], as is the next.
    fn take_faces(&mut self, faces: &Faces, region: &Region, passage: &Passage, stats: &mut Stats) -> bool;

    /// Is it enough to know that some of so many triangles may be seen within `region`, whichever of them?
    fn are_enough(&self, _triangles: u64, _region: &Region) -> bool {
        false
    }

    /// May any of the faces within `region` be seen? `true` when unsure.
    fn sees_faces(&mut self, faces: &Faces, region: &Region, passage: &Passage, stats: &mut Stats) -> bool;
}

/// More clusters than these are looked at in parts in any case: they may be a city.
const FEW_CLUSTERS: usize = 64;

/// Clusters and openings that nothing hides.
#[derive(Default)]
pub(super) struct Found {
    pub(super) clusters: FoundClusters,
    openings: Vec<OpeningId>,
}

/// Reports what an order's walk finds of a geometry.
pub(super) fn find<O: Order>(
    order: &O,
    geometry: &Geometry,
    passage: &Passage,
    against: &mut impl Against,
    memory: &mut Memory,
    seen: &mut Collector,
) {
    let mut scratch = memory.take::<O::Scratch>();
    let mut found = memory.take::<Found>();
    memory.marks.begin(geometry.items().len());
    let mut walk = Walk {
        passage,
        geometry,
        against,
        marks: &mut memory.marks,
        stats: &mut memory.stats,
        found: &mut found,
    };
    order.visit(geometry, passage, &mut scratch, &mut walk);
    walk.report(seen);
    memory.put_back(scratch);
    memory.put_back(found);
}

/// Joins an order's walk to what it is held against.
pub(super) struct Walk<'a, A> {
    pub(super) passage: &'a Passage,
    pub(super) geometry: &'a Geometry,
    pub(super) against: &'a mut A,
    pub(super) marks: &'a mut Marks,
    pub(super) stats: &'a mut Stats,
    pub(super) found: &'a mut Found,
}

impl<A: Against> Walk<'_, A> {
    fn count(&mut self, sight: Visibility) -> Visibility {
        self.stats.boxes_tested += 1;
        self.stats.boxes_hidden += u64::from(sight == Visibility::Hidden);
        sight
    }

    fn region_of(&self, faces: &Faces, item: ItemId, cluster: u32) -> Option<Region> {
        let bounds = &self.geometry.mesh_of(item).clusters()[cluster as usize].bounds;
        Region::of(self.passage, faces.screen_from_local, bounds)
    }

    /// Reports what was found; nothing is left.
    pub(super) fn report(&mut self, seen: &mut Collector) {
        self.look_again();
        self.found.clusters.report(self.geometry, seen);
        for opening in self.found.openings.drain(..) {
            seen.opening(opening, None);
        }
    }

    /// Holds openings, and what came before all that hides it, against all that does. Of an item of which one cluster is seen
    /// the others stay: they are drawn or not by whoever draws it, at hardly more cost.
    fn look_again(&mut self) {
        let Found {
            mut clusters,
            mut openings,
        } = std::mem::take(self.found);
        if A::TAKES_FACES {
            let mut seen = None;
            clusters.retain(|item, cluster| {
                if seen == Some(item) {
                    return true;
                }
                let screen_from_item = self.passage.screen_from(&self.geometry.item(item).transform());
                let faces = Faces::of_cluster(self.geometry, item, cluster, &screen_from_item);
                let stays = self.region_of(&faces, item, cluster).is_some_and(|region| {
                    self.enter(&region) != Visibility::Hidden
                        && self.against.sees_faces(&faces, &region, self.passage, self.stats)
                });
                seen = stays.then_some(item).or(seen);
                stays
            });
            clusters.retain_groups(|item, node| {
                let screen_from_item = self.passage.screen_from(&self.geometry.item(item).transform());
                let bounds = self.geometry.mesh_of(item).tree().bounds(node);
                let region = Region::of(self.passage, &screen_from_item, bounds);
                region.is_some_and(|region| self.enter(&region) != Visibility::Hidden)
            });
        }
        openings.retain(|opening| {
            let outline = &self.geometry.openings()[usize::from(opening.0)].outline;
            let region = self.passage.region_around_openings(&outline.bounds());
            region.is_some_and(|region| {
                self.passage.is_before_near(&region) || self.enter(&region) != Visibility::Hidden
            })
        });
        *self.found = Found { clusters, openings };
    }
}

impl<A: Against> Visit for Walk<'_, A> {
    fn enter(&mut self, region: &Region) -> Visibility {
        let sight = self.against.sees(region);
        self.count(sight)
    }

    fn enter_box(&mut self, passage: &Passage, screen_from_local: &DAffine3, bounds: &Aabb) -> Visibility {
        match self.against.sight_of(passage, screen_from_local, bounds) {
            Some(sight) => self.count(sight),
            None => Visibility::Hidden,
        }
    }

    fn go_within(&mut self) {
        self.against.go_within();
    }

    fn go_back(&mut self) {
        self.against.go_back();
    }

    fn first_time(&mut self, item: ItemId) -> bool {
        self.marks.first_time(item)
    }

    fn are_enough(&mut self, item: ItemId, node: u32, region: &Region) -> bool {
        let below = self.geometry.mesh_of(item).below();
        let clusters = below.clusters(node);
        if !A::TAKES_FACES || clusters.len() > FEW_CLUSTERS {
            return false;
        }
        let enough = self.against.are_enough(below.triangles(node), region);
        if enough {
            self.found.clusters.push_group(item, node, clusters);
        }
        enough
    }

    fn faces(&mut self, faces: &Faces) {
        match faces.source {
            FaceSource::Item(item, cluster) => {
                let stays = !A::TAKES_FACES
                    || self.region_of(faces, item, cluster).is_some_and(|region| {
                        self.against.take_faces(faces, &region, self.passage, self.stats)
                    });
                if stays {
                    self.found.clusters.push(item, cluster);
                }
            }
            FaceSource::Opening(opening) => self.found.openings.push(opening),
        }
    }

    fn cluster(&mut self, geometry: &Geometry, item: ItemId, cluster: u32, screen_from_item: &DAffine3) {
        if A::TAKES_FACES {
            self.faces(&Faces::of_cluster(geometry, item, cluster, screen_from_item));
        } else {
            self.found.clusters.push(item, cluster);
        }
    }

    fn whole(&mut self, geometry: &Geometry, item: ItemId, screen_from_item: &DAffine3) {
        if A::TAKES_FACES {
            for cluster in 0..geometry.mesh_of(item).clusters().len() as u32 {
                self.cluster(geometry, item, cluster, screen_from_item);
            }
        } else {
            self.found.clusters.push_whole(item);
        }
    }
}
