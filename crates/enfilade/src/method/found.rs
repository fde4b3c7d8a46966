//! Traversal with occlusion tests for covers that hold no picture: collects the clusters and openings that pass.

use super::combined::takes;
use super::visit::visit;
use crate::cover::{FineNode, ItemTest};
use crate::faces::{FaceSource, Faces};
use crate::geom::Aabb;
use crate::geometry::Geometry;
use crate::ids::{ItemIndex, OpeningId};
use crate::order::{Order, Visit};
use crate::stats::Stats;
use crate::view::collector::{Collector, FoundClusters, FoundPart};
use crate::view::memory::{Marks, Memory};
use crate::view::passage::Passage;
use crate::view::region::{Region, Visibility};
use crate::view::screen_map::ScreenMap;

/// The occlusion test of a traversal: a cover at the resolution of samples or of cells.
pub(super) trait OcclusionTest {
    /// Whether faces that the traversal emits are added to the cover, so that they occlude what comes later. Then
    /// everything found is tested once more at the end.
    const TAKES_FACES: bool;

    /// Tests a box; returns how much of it is potentially visible.
    fn test(&mut self, region: &Region) -> Visibility;

    /// Tests a box in local space as [`OcclusionTest::test`] does; `None` if it is out of view.
    fn test_local(
        &mut self,
        passage: &Passage,
        screen_from_local: &ScreenMap,
        bounds: &Aabb,
    ) -> Option<Visibility> {
        Region::of(passage, screen_from_local, bounds).map(|region| self.test(&region))
    }

    /// Declares that all boxes until [`OcclusionTest::go_back`] are within the one tested last.
    fn go_within(&mut self) {}

    /// Ends the effect of [`OcclusionTest::go_within`].
    fn go_back(&mut self) {}

    /// Tests faces within `region`, then adds them to the cover as occluders. Returns `true` if any may be visible;
    /// `true` when unsure. Called only if [`OcclusionTest::TAKES_FACES`] is set, as is the next method.
    fn test_and_add(&mut self, faces: &Faces, region: &Region, passage: &Passage, stats: &mut Stats) -> bool;

    /// Returns `true` to accept a mesh node of `triangles` triangles within `region` as a whole.
    fn accepts_node(&self, _triangles: u64, _region: &Region) -> bool {
        false
    }

    /// Takes note of a mesh node that was accepted as a whole.
    fn note_fine(&mut self, _node: &FineNode, _region: &Region, _passage: &Passage) {}

    /// Returns the test of items by their faces at the end, which replaces [`OcclusionTest::test_faces`], if there is one.
    fn item_test(&mut self, _passage: &Passage) -> Option<ItemTest<'_>> {
        None
    }

    /// Whether [`OcclusionTest::test_faces`] tests anything.
    const TESTS_FACES: bool = false;

    /// Returns `true` if any of the faces within `region` may be visible; `true` when unsure.
    fn test_faces(&mut self, _: &Faces, _: &Region, _: &Passage, _: &mut Stats) -> bool {
        true
    }
}

/// Maximum number of faces of an item that is tested by its faces, so that the test does not cost more than it saves.
const MAX_FACES_TESTED: usize = 512;

/// Maximum number of clusters of a mesh node that is accepted as a whole. Larger nodes are always split: they may be a
/// city.
const MAX_WHOLE_CLUSTERS: usize = 64;

/// Clusters and openings found potentially visible.
#[derive(Default)]
pub(super) struct FoundSet {
    pub(super) clusters: FoundClusters,
    openings: Vec<OpeningId>,
    /// Items that are tested by their faces, sorted; a buffer.
    few: Vec<ItemIndex>,
}

/// Traverses a geometry and reports the clusters and openings that pass the occlusion test.
pub(super) fn find<O: Order>(
    order: &O,
    geometry: &Geometry,
    passage: &Passage,
    occlusion: &mut impl OcclusionTest,
    memory: &mut Memory,
    seen: &mut Collector,
) {
    let mut scratch = memory.take::<O::Scratch>();
    let mut found = memory.take::<FoundSet>();
    memory.marks.begin(geometry.items().len());
    let mut walk = Walk {
        passage,
        geometry,
        occlusion,
        marks: &mut memory.marks,
        stats: &mut memory.stats,
        found: &mut found,
    };
    visit(
        order,
        geometry,
        passage,
        &mut scratch,
        &mut walk,
        #[cfg(feature = "steps")]
        memory.steps.as_deref_mut(),
    );
    walk.report(seen);
    memory.put_back(scratch);
    memory.put_back(found);
}

/// Connects the traversal of an order to an occlusion test.
pub(super) struct Walk<'a, A> {
    pub(super) passage: &'a Passage,
    pub(super) geometry: &'a Geometry,
    pub(super) occlusion: &'a mut A,
    pub(super) marks: &'a mut Marks,
    pub(super) stats: &'a mut Stats,
    pub(super) found: &'a mut FoundSet,
}

impl<A: OcclusionTest> Walk<'_, A> {
    fn count(&mut self, visibility: Visibility) -> Visibility {
        self.stats.boxes_tested += 1;
        self.stats.boxes_hidden += u64::from(visibility == Visibility::Hidden);
        visibility
    }

    /// Reports the clusters and openings found, and removes them from the list.
    pub(super) fn report(&mut self, seen: &mut Collector) {
        self.retest();
        self.found.clusters.report(self.geometry, seen);
        for opening in self.found.openings.drain(..) {
            seen.opening(opening, None);
        }
    }

    /// Tests a cluster, by its box and, if the occlusion test does, its faces, against the complete cover.
    fn sees_cluster(&mut self, item: ItemIndex, cluster: u32, screen_from_item: &ScreenMap) -> bool {
        let bounds = &self.geometry.mesh_of(item).clusters()[cluster as usize].bounds;
        let Some(region) = Region::of(self.passage, screen_from_item, bounds) else {
            return false;
        };
        if self.enter(&region) == Visibility::Hidden {
            return false;
        }
        if !A::TESTS_FACES {
            return true;
        }
        let faces = Faces::of_cluster(self.geometry, item, cluster, screen_from_item);
        faces.count() == 0
            || self
                .occlusion
                .test_faces(&faces, &region, self.passage, self.stats)
    }

    /// Tests openings, and clusters that were found before all occluders were known, against the complete cover. Once
    /// one cluster of an item passes, its others are kept untested: the renderer draws the item, and drawing them too
    /// costs hardly more.
    fn retest(&mut self) {
        let FoundSet {
            mut clusters,
            mut openings,
            mut few,
        } = std::mem::take(self.found);
        if A::TAKES_FACES {
            if self.occlusion.item_test(self.passage).is_some() {
                self.retest_items(&mut clusters, &mut few);
            } else {
                self.retest_clusters(&mut clusters);
            }
        }
        openings.retain(|opening| {
            let outline = &self.geometry.openings()[usize::from(opening.0)].outline;
            let region = self.passage.region_around_openings(&outline.bounds());
            region.is_some_and(|region| {
                self.passage.is_before_near(&region) || self.enter(&region) != Visibility::Hidden
            })
        });
        *self.found = FoundSet {
            clusters,
            openings,
            few,
        };
    }

    fn retest_clusters(&mut self, clusters: &mut FoundClusters) {
        let mut last = None;
        let mut screen_from_item = ScreenMap::IDENTITY;
        let mut seen = false;
        clusters.retain_by_item(|item, part| {
            if last != Some(item) {
                (last, seen) = (Some(item), false);
                screen_from_item = self.passage.screen_from(&self.geometry.item(item).transform());
            }
            let stays = seen
                || match part {
                    FoundPart::Cluster(cluster) => self.sees_cluster(item, cluster, &screen_from_item),
                    FoundPart::Group(node, clusters) => {
                        self.sees_group(item, node, clusters, &screen_from_item)
                    }
                };
            seen |= stays;
            stays
        });
    }

    /// Tests items by their boxes, then those of few faces by these, and all doubtful ones together at the end.
    fn retest_items(&mut self, clusters: &mut FoundClusters, few: &mut Vec<ItemIndex>) {
        few.clear();
        self.retest_boxes(clusters, few);
        let mut doubtful = 0;
        let (mut next, mut tested) = (0, None::<TestedItem>);
        clusters.retain_by_item(|item, part| {
            if tested.as_ref().is_none_or(|tested| tested.item != item) {
                if self.end_item(tested.take()) {
                    few[doubtful] = few[next - 1];
                    doubtful += 1;
                }
                if few.get(next) != Some(&item) {
                    return true;
                }
                next += 1;
                if let Some(mut test) = self.occlusion.item_test(self.passage) {
                    test.begin_item(self.passage);
                }
            }
            let tested = tested.get_or_insert_with(|| TestedItem {
                item,
                screen_from_item: self.passage.screen_from(&self.geometry.item(item).transform()),
                visibility: Visibility::Hidden,
            });
            match part {
                FoundPart::Cluster(cluster) => self.test_faces(tested, cluster),
                FoundPart::Group(_, clusters) => self.test_group(tested, clusters),
            }
        });
        if self.end_item(tested) {
            few[doubtful] = few[next - 1];
            doubtful += 1;
        }
        few.truncate(doubtful);
        if few.is_empty() {
            return;
        }
        let Some(mut test) = self.occlusion.item_test(self.passage) else {
            return;
        };
        test.resolve(self.geometry, self.passage);
        let mut last = None;
        clusters.retain_items(|item| match last {
            Some((last, stays)) if last == item => stays,
            _ => {
                let number = few.binary_search(&item);
                let stays = number.map_or(true, |number| {
                    test.is_visible(number, self.geometry, self.passage)
                });
                last = Some((item, stays));
                stays
            }
        });
    }

    /// Tests clusters by their boxes until those of an item that pass have too many faces to be tested. Lists the items
    /// with fewer, sorted.
    fn retest_boxes(&mut self, clusters: &mut FoundClusters, few: &mut Vec<ItemIndex>) {
        let (mut last, mut faces) = (None, 0);
        let mut screen_from_item = ScreenMap::IDENTITY;
        clusters.retain_by_item(|item, part| {
            if last != Some(item) {
                (last, faces) = (Some(item), 0);
                screen_from_item = self.passage.screen_from(&self.geometry.item(item).transform());
            }
            let are_many = faces > MAX_FACES_TESTED;
            let mesh = self.geometry.mesh_of(item);
            let (stays, more) = match part {
                FoundPart::Cluster(_) if are_many => (true, 0),
                FoundPart::Cluster(number) => {
                    let cluster = &mesh.clusters()[number as usize];
                    // Nobody knows where in its box a cluster without faces is.
                    let count = match cluster.faces.len() {
                        0 => MAX_FACES_TESTED + 1,
                        count => count,
                    };
                    (self.sees_cluster(item, number, &screen_from_item), count)
                }
                FoundPart::Group(node, clusters) => {
                    let triangles = mesh.below().triangles(node) as usize;
                    let stays = self.sees_group(item, node, clusters, &screen_from_item);
                    (stays, triangles)
                }
            };
            let before = faces;
            faces += if stays { more } else { 0 };
            if before == 0 && faces > 0 {
                few.push(item);
            }
            if !are_many && faces > MAX_FACES_TESTED {
                few.pop();
            }
            stays
        });
    }

    /// Tests the box of a mesh node, then those of its clusters.
    fn sees_group(
        &mut self,
        item: ItemIndex,
        node: u32,
        clusters: &[u32],
        screen_from_item: &ScreenMap,
    ) -> bool {
        let bounds = self.geometry.mesh_of(item).tree().bounds(node);
        let region = Region::of(self.passage, screen_from_item, bounds);
        region.is_some_and(|region| self.enter(&region) != Visibility::Hidden)
            && clusters
                .iter()
                .any(|&cluster| self.sees_cluster(item, cluster, screen_from_item))
    }

    /// Tests the faces of a cluster; returns `false` if they are hidden.
    fn test_faces(&mut self, tested: &mut TestedItem, cluster: u32) -> bool {
        if tested.visibility == Visibility::Full {
            return true;
        }
        let faces = Faces::of_cluster(self.geometry, tested.item, cluster, &tested.screen_from_item);
        let visibility = match self.occlusion.item_test(self.passage) {
            Some(mut test) => test.test_faces(&faces, self.passage),
            None => Visibility::Full,
        };
        if visibility != Visibility::Hidden {
            tested.visibility = visibility;
        }
        visibility != Visibility::Hidden
    }

    /// Tests the clusters of a mesh node by their boxes and faces; returns `false` if all are hidden.
    fn test_group(&mut self, tested: &mut TestedItem, clusters: &[u32]) -> bool {
        let mut any = false;
        for &cluster in clusters {
            if tested.visibility == Visibility::Full {
                return true;
            }
            let bounds = &self.geometry.mesh_of(tested.item).clusters()[cluster as usize].bounds;
            let region = Region::of(self.passage, &tested.screen_from_item, bounds);
            any |= region.is_some_and(|region| self.enter(&region) != Visibility::Hidden)
                && self.test_faces(tested, cluster);
        }
        any
    }

    /// Ends the test of an item; returns `true` if it is doubtful.
    fn end_item(&mut self, tested: Option<TestedItem>) -> bool {
        let is_doubtful = tested.is_some_and(|tested| tested.visibility == Visibility::Partial);
        if is_doubtful && let Some(mut test) = self.occlusion.item_test(self.passage) {
            test.end_doubtful();
        }
        is_doubtful
    }
}

/// The item whose faces are tested.
struct TestedItem {
    item: ItemIndex,
    screen_from_item: ScreenMap,
    /// `Partial` if it is doubtful so far.
    visibility: Visibility,
}

impl<A: OcclusionTest> Visit for Walk<'_, A> {
    fn enter(&mut self, region: &Region) -> Visibility {
        let visibility = self.occlusion.test(region);
        self.count(visibility)
    }

    fn enter_box(&mut self, passage: &Passage, screen_from_local: &ScreenMap, bounds: &Aabb) -> Visibility {
        match self.occlusion.test_local(passage, screen_from_local, bounds) {
            Some(visibility) => self.count(visibility),
            None => Visibility::Hidden,
        }
    }

    fn go_within(&mut self) {
        self.occlusion.go_within();
    }

    fn go_back(&mut self) {
        self.occlusion.go_back();
    }

    fn first_time(&mut self, item: ItemIndex) -> bool {
        self.marks.first_time(item) && takes(self.passage, self.geometry.item(item), self.stats)
    }

    fn are_enough(&mut self, item: ItemIndex, node: u32, region: &Region) -> bool {
        let below = self.geometry.mesh_of(item).below();
        let clusters = below.clusters(node);
        if !A::TAKES_FACES || clusters.len() > MAX_WHOLE_CLUSTERS {
            return false;
        }
        let triangles = below.triangles(node);
        let enough = self.occlusion.accepts_node(triangles, region);
        if enough {
            self.found.clusters.push_group(item, node, clusters);
            let fine = FineNode {
                item,
                clusters,
                triangles,
            };
            self.occlusion.note_fine(&fine, region, self.passage);
        }
        enough
    }

    fn faces(&mut self, faces: &Faces) {
        match faces.source {
            FaceSource::Item(item, cluster) if A::TAKES_FACES && faces.count() > 0 => {
                let bounds = &self.geometry.mesh_of(item).clusters()[cluster as usize].bounds;
                if let Some(region) = Region::of(self.passage, faces.screen_from_local, bounds) {
                    self.faces_within(faces, &region);
                }
            }
            FaceSource::Item(item, cluster) => self.found.clusters.push(item, cluster),
            FaceSource::Opening(opening) => self.found.openings.push(opening),
        }
    }

    fn faces_within(&mut self, faces: &Faces, region: &Region) {
        let FaceSource::Item(item, cluster) = faces.source else {
            return self.faces(faces);
        };
        let stays = !A::TAKES_FACES
            || faces.count() == 0
            || self
                .occlusion
                .test_and_add(faces, region, self.passage, self.stats);
        if stays {
            self.found.clusters.push(item, cluster);
        }
    }

    fn cluster(&mut self, geometry: &Geometry, item: ItemIndex, cluster: u32, screen_from_item: &ScreenMap) {
        if A::TAKES_FACES {
            self.faces(&Faces::of_cluster(geometry, item, cluster, screen_from_item));
        } else {
            self.found.clusters.push(item, cluster);
        }
    }

    fn whole(&mut self, geometry: &Geometry, item: ItemIndex, screen_from_item: &ScreenMap) {
        if A::TAKES_FACES {
            for cluster in 0..geometry.mesh_of(item).clusters().len() as u32 {
                self.cluster(geometry, item, cluster, screen_from_item);
            }
        } else {
            self.found.clusters.push_whole(item);
        }
    }
}
