//! The lower of two levels: the clusters of one item, near to far.

use super::Visit;
use crate::content::{Alpha, Content, ItemId, OpeningId};
use crate::faces::Faces;
use crate::geom::Step;
use crate::passage::{Passage, eye_in};
use crate::region::{Region, Sight};

/// Hands out what may be seen of one item, unless that was done already.
pub(super) fn hand_out(content: &Content, passage: &Passage, item: ItemId, visit: &mut impl Visit) {
    let placed = content.item(item);
    let mesh = content.mesh_of(item);
    let clusters = mesh.clusters();
    if clusters.is_empty() || !visit.first_time(item) {
        return;
    }
    let screen_from_item = passage.screen_from(&placed.transform());
    if clusters.len() == 1 {
        if may_be_seen(passage, &screen_from_item, &mesh.bounds(), visit) {
            visit.faces(&Faces::of_cluster(content, item, 0, &screen_from_item));
        }
        return;
    }
    mesh.walk(eye_in(&screen_from_item).into(), |step| match step {
        Step::Node(bounds) => may_be_seen(passage, &screen_from_item, bounds, visit),
        Step::Thing(cluster) => {
            if may_be_seen(
                passage,
                &screen_from_item,
                &clusters[cluster as usize].bounds,
                visit,
            ) {
                visit.faces(&Faces::of_cluster(content, item, cluster, &screen_from_item));
            }
            true
        }
    });
}

/// Hands out what may be seen of an item's faces that do not hide: for orders that sort only those that do.
pub(super) fn hand_out_see_through(
    content: &Content,
    passage: &Passage,
    item: ItemId,
    visit: &mut impl Visit,
) {
    let screen_from_item = passage.screen_from(&content.item(item).transform());
    for (number, cluster) in content.mesh_of(item).clusters().iter().enumerate() {
        if content.material_of(cluster).alpha != Alpha::Opaque
            && may_be_seen(passage, &screen_from_item, &cluster.bounds, visit)
        {
            visit.faces(&Faces::of_cluster(
                content,
                item,
                number as u32,
                &screen_from_item,
            ));
        }
    }
}

/// Hands out all openings, unless they are plain holes.
pub(super) fn hand_out_openings(content: &Content, passage: &Passage, visit: &mut impl Visit) {
    if passage.flat {
        return;
    }
    for opening in 0..content.openings().len() as u16 {
        visit.faces(&opening_faces(content, passage, OpeningId(opening)));
    }
}

/// An opening as a face.
pub(super) fn opening_faces<'a>(content: &'a Content, passage: &'a Passage, opening: OpeningId) -> Faces<'a> {
    Faces::of_opening(content, opening, &passage.screen_from_fragment)
}

pub(super) fn may_be_seen(
    passage: &Passage,
    screen_from_local: &glam::DAffine3,
    bounds: &crate::geom::Aabb,
    visit: &mut impl Visit,
) -> bool {
    Region::of(passage, screen_from_local, bounds).is_some_and(|region| visit.enter(&region) != Sight::Hidden)
}
