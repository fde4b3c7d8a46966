//! Emits the clusters of one item, front to back by the octree of its mesh: the lower of the two levels of a traversal.

use super::Visit;
use crate::faces::Faces;
use crate::geom::{Aabb, Enter, Step};
use crate::geometry::Geometry;
use crate::ids::ItemIndex;
use crate::view::passage::Passage;
use crate::view::region::Visibility;
use crate::view::screen_map::ScreenMap;

/// Emits the clusters of one item that may be visible, unless the item was emitted before.
pub(crate) fn emit_item(geometry: &Geometry, passage: &Passage, item: ItemIndex, visit: &mut impl Visit) {
    let mesh = geometry.mesh_of(item);
    let clusters = mesh.clusters();
    if clusters.is_empty() || !visit.first_time(item) {
        return;
    }
    let screen_from_item = passage.screen_from(&geometry.item(item).transform());
    match box_visibility(passage, &screen_from_item, &mesh.bounds(), visit) {
        Visibility::Hidden => return,
        Visibility::Partial if clusters.len() > 1 => {}
        _ => return visit.whole(geometry, item, &screen_from_item),
    }
    visit.go_within();
    let mut is_root = true;
    // Last box found partially visible. The only cluster of a leaf has the leaf's box, which need not be tested again.
    let mut partly = mesh.bounds();
    mesh.tree()
        .walk_by(screen_from_item.eye().into(), |step, all| match step {
            // The root has the box of the whole mesh, which was just tested.
            Step::Node(_) if std::mem::take(&mut is_root) => Enter::Ask,
            Step::Node(bounds) => match box_visibility(passage, &screen_from_item, bounds, visit) {
                Visibility::Hidden => Enter::Skip,
                Visibility::Partial => {
                    partly = *bounds;
                    Enter::Ask
                }
                Visibility::Full => Enter::All,
            },
            Step::Thing(cluster) => {
                let bounds = &clusters[cluster as usize].bounds;
                if all || *bounds == partly || may_be_visible(passage, &screen_from_item, bounds, visit) {
                    visit.cluster(geometry, item, cluster, &screen_from_item);
                }
                Enter::Skip
            }
        });
    visit.go_back();
}

/// Emits a whole item without tests, unless it was emitted before; for an item within a fully visible box.
pub(crate) fn emit_whole(geometry: &Geometry, passage: &Passage, item: ItemIndex, visit: &mut impl Visit) {
    if visit.first_time(item) {
        let screen_from_item = passage.screen_from(&geometry.item(item).transform());
        visit.whole(geometry, item, &screen_from_item);
    }
}

/// Emits the openings that may be in view, unless the passage treats openings as plain holes.
pub(crate) fn emit_openings(geometry: &Geometry, passage: &Passage, visit: &mut impl Visit) {
    Faces::of_openings(geometry, passage, |faces| visit.faces(faces));
}

pub(crate) fn may_be_visible(
    passage: &Passage,
    screen_from_local: &ScreenMap,
    bounds: &Aabb,
    visit: &mut impl Visit,
) -> bool {
    box_visibility(passage, screen_from_local, bounds, visit) != Visibility::Hidden
}

/// Returns the visibility of a box; hidden if it is out of view.
pub(crate) fn box_visibility(
    passage: &Passage,
    screen_from_local: &ScreenMap,
    bounds: &Aabb,
    visit: &mut impl Visit,
) -> Visibility {
    visit.enter_box(passage, screen_from_local, bounds)
}
