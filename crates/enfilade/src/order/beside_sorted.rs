//! Emits what orders that sort opaque faces visit in another way: clusters that are not opaque, and openings.

use super::Visit;
use crate::faces::Faces;
use crate::geom::Step;
use crate::geometry::{Alpha, Geometry};
use crate::ids::{ItemIndex, OpeningId};
use crate::traversal::may_be_visible;
use crate::view::opening_view::may_touch_eye;
use crate::view::passage::Passage;

/// Emits the clusters of an item that are not opaque and may be visible, for orders that sort opaque faces only.
pub(super) fn emit_non_opaque(
    geometry: &Geometry,
    passage: &Passage,
    item: ItemIndex,
    visit: &mut impl Visit,
) {
    let screen_from_item = passage.screen_from(&geometry.item(item).transform());
    for (number, cluster) in geometry.mesh_of(item).clusters().iter().enumerate() {
        if geometry.material_of(item, cluster).alpha != Alpha::Opaque
            && may_be_visible(passage, &screen_from_item, &cluster.bounds, visit)
        {
            visit.cluster(geometry, item, number as u32, &screen_from_item);
        }
    }
}

/// Emits an opening if its front faces the eye.
pub(super) fn emit_opening(
    geometry: &Geometry,
    passage: &Passage,
    opening: OpeningId,
    visit: &mut impl Visit,
) {
    if let Some(view) = passage.view_of(geometry, opening) {
        visit.faces(&Faces::of_opening(geometry, opening, &view));
    }
}

/// Emits the openings that touch the eye ([`OpeningView`](crate::view::opening_view::OpeningView)).
pub(super) fn emit_openings_at_eye(geometry: &Geometry, passage: &Passage, visit: &mut impl Visit) {
    if passage.flat {
        return;
    }
    let eye = passage.viewpoint();
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
