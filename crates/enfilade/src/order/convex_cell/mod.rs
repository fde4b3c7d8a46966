//! Convex cell: the faces that bound a convex space, drawn in any order without depth tests.
//!
//! If every face has all others on its inner side, a line of sight that meets a face from inside leaves the space for
//! good: seen from inside, no face occludes another. A line that meets a face from outside has met nothing before. So
//! faces whose outer sides are visible (double-sided ones, or those whose fronts point outward) are emitted once more
//! after all others if the eye is on their outer side, or within rounding of it; among themselves they do not occlude
//! each other either. Back to front is therefore any order of the first group, then any order of the second. The first
//! group keeps the faces of the second, so that clusters can be emitted whole. Coplanar faces come by descending
//! number, so that the lowest is drawn last. Geometry that occludes nothing is not considered and may be anywhere.
//! Source: Boreskov, Using portals to create aggregate scenes (a convex cell: just draw the front faces).
//! Cost: building takes 0.2 to 0.4 µs for each face in a recently used plane (a box of 12 million triangles: 3 s), and
//!     2 to 20 µs for each in a new one (more for finely tessellated domes); a non-convex geometry is rejected at the
//!     first offending face, mostly within a millisecond. A traversal takes O(items, and clusters of those in view),
//!     twice for outer sides.
//! Guarantees an exact back-to-front order for convex geometry. Building returns an error for any other, also after an
//! edit.

mod overlap;
mod support;
mod walls;

use super::beside_sorted::{emit_opening, emit_openings_at_eye};
use super::{FarToNear, Order, Visit};
use crate::faces::Faces;
use crate::geometry::{Alpha, Geometry, MovedItem};
use crate::ids::{ItemIndex, OpeningId};
use crate::sector::Requirement;
use crate::traversal::{box_visibility, emit_openings, may_be_visible};
use crate::unsuited::Unsuited;
use crate::view::passage::Passage;
use crate::view::region::Visibility;
use crate::view::screen_map::ScreenMap;
use glam::DVec3;
use walls::Walls;

/// Faces of a convex space, drawn back to front in any order.
pub struct ConvexCell {
    /// Planes of the faces whose outer sides may be visible.
    planes: Vec<Plane>,
    /// Maximum distance of a face from its plane.
    slack: f64,
    /// Those faces, in order of their numbers.
    outside: Vec<Outside>,
    /// Openings whose fronts point outward.
    openings: Vec<OpeningId>,
    /// Clusters that contain coplanar overlapping faces, sorted.
    overlapping: Vec<(ItemIndex, u32)>,
    /// By item: whether any of its faces is an occluder.
    occluders: Vec<bool>,
}

/// A run of coplanar faces of a cluster whose outer sides may be visible.
#[derive(Clone, Copy, Debug)]
struct Outside {
    plane: u32,
    item: ItemIndex,
    cluster: u32,
    /// First face number, and one past the last.
    faces: [u32; 2],
}

/// A plane; its positive side is the inside of the cell.
#[derive(Clone, Copy, Debug)]
struct Plane {
    /// Unit normal; points inward.
    normal: DVec3,
    offset: f64,
}

impl Plane {
    /// Returns the signed distance of a point; positive inside.
    #[inline(always)]
    fn height(&self, point: DVec3) -> f64 {
        self.normal.dot(point) - self.offset
    }
}

impl Order for ConvexCell {
    // In a convex cell every order is back to front, as long as outer sides come last.
    type Gives = FarToNear;
    type Scratch = ();

    const NAME: &'static str = "ConvexCell";
    const REQUIRES: Option<Requirement> = Some(Requirement::Convex);
    const INCLUDES_OPENINGS: bool = true;

    fn build(geometry: &Geometry, limit_bytes: u64) -> Result<ConvexCell, Unsuited> {
        let mut walls = Walls::new(geometry, limit_bytes);
        walls.take_openings()?;
        for item in (0..geometry.items().len() as u32).map(ItemIndex) {
            walls.take_item(item)?;
        }
        Ok(walls.cell)
    }

    fn needs_bytes(geometry: &Geometry) -> u64 {
        // Most faces show one side only. How many show both is found, and limited, while building.
        geometry.items().len() as u64 * size_of::<bool>() as u64
    }

    fn bytes(&self) -> u64 {
        (size_of_val(&*self.planes)
            + size_of_val(&*self.outside)
            + size_of_val(&*self.openings)
            + size_of_val(&*self.overlapping)
            + size_of_val(&*self.occluders)) as u64
    }

    fn follow(&mut self, geometry: &Geometry, moved: &[MovedItem], _touched: &mut Vec<u32>) -> bool {
        // An item that occludes nothing, neither before nor now, may be anywhere.
        moved.iter().all(|moved| {
            let hid = self.occluders.get(moved.item.0 as usize).is_some_and(|&hid| hid);
            !hid && occluder_clusters(geometry, moved.item).next().is_none()
        })
    }

    fn visit(&self, geometry: &Geometry, passage: &Passage, _scratch: &mut (), visit: &mut impl Visit) {
        emit_openings(geometry, passage, visit);
        for item in (0..geometry.items().len() as u32).rev().map(ItemIndex) {
            self.emit_item(geometry, passage, item, visit);
        }
        if !passage.flat {
            // Only those whose fronts face the eye.
            for &opening in self.openings.iter().rev() {
                emit_opening(geometry, passage, opening, visit);
            }
        }
        let eye = DVec3::from(passage.viewpoint());
        if self.planes.iter().any(|plane| plane.height(eye) < self.slack) {
            self.emit_outer_sides(geometry, passage, eye, visit);
        }
        // Rounding may have put these openings among the outer sides, or drawn faces that end in their plane over them.
        emit_openings_at_eye(geometry, passage, visit);
    }
}

impl ConvexCell {
    /// Emits the clusters of an item that may be visible, the last one first.
    fn emit_item(&self, geometry: &Geometry, passage: &Passage, item: ItemIndex, visit: &mut impl Visit) {
        let mesh = geometry.mesh_of(item);
        let clusters = mesh.clusters();
        if clusters.is_empty() || !visit.first_time(item) {
            return;
        }
        let screen_from_item = passage.screen_from(&geometry.item(item).transform());
        let whole = match box_visibility(passage, &screen_from_item, &mesh.bounds(), visit) {
            Visibility::Hidden => return,
            Visibility::Partial => clusters.len() == 1,
            Visibility::Full => true,
        };
        for (number, cluster) in (0..clusters.len() as u32).zip(clusters).rev() {
            if !whole && !may_be_visible(passage, &screen_from_item, &cluster.bounds, visit) {
                continue;
            }
            if self.overlapping.binary_search(&(item, number)).is_ok() {
                let faces = [cluster.faces.start, cluster.faces.end];
                emit_backwards(geometry, item, faces, &screen_from_item, visit);
            } else {
                visit.cluster(geometry, item, number, &screen_from_item);
            }
        }
    }

    /// Emits the faces whose outer sides may face `eye`, after everything that they occlude. If the eye is on the inner
    /// side by less than the slack, nothing but outer sides can occlude a face, so those come first.
    fn emit_outer_sides(&self, geometry: &Geometry, passage: &Passage, eye: DVec3, visit: &mut impl Visit) {
        for heights in [0.0..self.slack, f64::NEG_INFINITY..0.0] {
            for &Outside {
                plane,
                item,
                cluster,
                faces,
            } in self.outside.iter().rev()
            {
                if !heights.contains(&self.planes[plane as usize].height(eye)) {
                    continue;
                }
                let screen_from_item = passage.screen_from(&geometry.item(item).transform());
                let bounds = &geometry.mesh_of(item).clusters()[cluster as usize].bounds;
                if may_be_visible(passage, &screen_from_item, bounds, visit) {
                    emit_backwards(geometry, item, faces, &screen_from_item, visit);
                }
            }
        }
    }
}

/// Emits faces one by one, the last one first: among coplanar faces the lowest is painted over the others.
fn emit_backwards(
    geometry: &Geometry,
    item: ItemIndex,
    faces: [u32; 2],
    screen_from_item: &ScreenMap,
    visit: &mut impl Visit,
) {
    for face in (faces[0]..faces[1]).rev() {
        visit.faces(&Faces::of_face(geometry, item, face, screen_from_item, &[]));
    }
}

/// Returns the indices of an item's clusters whose faces are occluders.
fn occluder_clusters(geometry: &Geometry, item: ItemIndex) -> impl Iterator<Item = u32> + '_ {
    let clusters = (0_u32..).zip(geometry.mesh_of(item).clusters());
    let hide =
        clusters.filter(move |(_, cluster)| geometry.material_of(item, cluster).alpha == Alpha::Opaque);
    hide.map(|(number, _)| number)
}
