//! The lower of two levels: the clusters of one item, near to far.

use super::Visit;
use crate::faces::Faces;
use crate::geom::{Aabb, Enter, Step};
use crate::geometry::{Alpha, Geometry, ItemId, OpeningId};
use crate::opening_view::may_touch_eye;
use crate::passage::{Passage, eye_in};
use crate::region::Visibility;

/// Hands out what may be seen of one item, unless that was done already.
pub(super) fn hand_out(geometry: &Geometry, passage: &Passage, item: ItemId, visit: &mut impl Visit) {
    let mesh = geometry.mesh_of(item);
    let clusters = mesh.clusters();
    if clusters.is_empty() || !visit.first_time(item) {
        return;
    }
    let screen_from_item = passage.screen_from(&geometry.item(item).transform());
    match sight(passage, &screen_from_item, &mesh.bounds(), visit) {
        Visibility::Hidden => return,
        Visibility::Partial if clusters.len() > 1 => {}
        _ => return visit.whole(geometry, item, &screen_from_item),
    }
    visit.go_within();
    let mut is_root = true;
    // A leaf's only cluster has the leaf's box: what was said of that need not be asked again.
    let mut partly = mesh.bounds();
    mesh.tree()
        .walk_by(eye_in(&screen_from_item).into(), |step, all| match step {
            // It has the box of the whole mesh.
            Step::Node(_) if std::mem::take(&mut is_root) => Enter::Ask,
            Step::Node(bounds) => match sight(passage, &screen_from_item, bounds, visit) {
                Visibility::Hidden => Enter::Skip,
                Visibility::Partial => {
                    partly = *bounds;
                    Enter::Ask
                }
                Visibility::Full => Enter::All,
            },
            Step::Thing(cluster) => {
                let bounds = &clusters[cluster as usize].bounds;
                if all || *bounds == partly || may_be_seen(passage, &screen_from_item, bounds, visit) {
                    visit.cluster(geometry, item, cluster, &screen_from_item);
                }
                Enter::Skip
            }
        });
    visit.go_back();
}

/// Hands out all of an item, unless that was done already: for one in a box that is seen fully.
pub(super) fn hand_out_whole(geometry: &Geometry, passage: &Passage, item: ItemId, visit: &mut impl Visit) {
    if visit.first_time(item) {
        let screen_from_item = passage.screen_from(&geometry.item(item).transform());
        visit.whole(geometry, item, &screen_from_item);
    }
}

/// Hands out what may be seen of an item's faces that do not hide: for orders that sort only those that do.
pub(super) fn hand_out_see_through(
    geometry: &Geometry,
    passage: &Passage,
    item: ItemId,
    visit: &mut impl Visit,
) {
    let screen_from_item = passage.screen_from(&geometry.item(item).transform());
    for (number, cluster) in geometry.mesh_of(item).clusters().iter().enumerate() {
        if geometry.material_of(item, cluster).alpha != Alpha::Opaque
            && may_be_seen(passage, &screen_from_item, &cluster.bounds, visit)
        {
            visit.cluster(geometry, item, number as u32, &screen_from_item);
        }
    }
}

/// Hands out the openings that may be in view, unless they are plain holes.
pub(super) fn hand_out_openings(geometry: &Geometry, passage: &Passage, visit: &mut impl Visit) {
    Faces::of_openings(geometry, passage, |faces| visit.faces(faces));
}

/// Hands out an opening, if its front is seen.
pub(super) fn hand_out_opening(
    geometry: &Geometry,
    passage: &Passage,
    opening: OpeningId,
    visit: &mut impl Visit,
) {
    if let Some(view) = passage.view_of(geometry, opening) {
        visit.faces(&Faces::of_opening(geometry, opening, &view));
    }
}

/// Hands out the openings that touch the eye ([`OpeningView`](crate::opening_view::OpeningView)).
pub(super) fn hand_out_openings_at_eye(geometry: &Geometry, passage: &Passage, visit: &mut impl Visit) {
    if passage.flat {
        return;
    }
    let eye = passage.eye();
    geometry.opening_tree().walk(eye, |step| match step {
        Step::Node(bounds) => may_touch_eye(bounds, eye.into()),
        Step::Thing(opening) => {
            let opening = OpeningId(opening as u16);
            if let Some(view) = passage.view_of(geometry, opening).filter(|view| view.touches_eye) {
                visit.faces(&Faces::of_opening(geometry, opening, &view));
            }
            true
        }
    });
}

pub(super) fn may_be_seen(
    passage: &Passage,
    screen_from_local: &glam::DAffine3,
    bounds: &Aabb,
    visit: &mut impl Visit,
) -> bool {
    sight(passage, screen_from_local, bounds, visit) != Visibility::Hidden
}

/// How much of a box can be seen; nothing where it is out of view.
pub(super) fn sight(
    passage: &Passage,
    screen_from_local: &glam::DAffine3,
    bounds: &Aabb,
    visit: &mut impl Visit,
) -> Visibility {
    visit.enter_box(passage, screen_from_local, bounds)
}
