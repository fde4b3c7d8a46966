//! Convex cell: faces that bound a convex space, in any order at all.
//!
//! Where every face has all others on one side, its inner one, a line of sight that meets a face from there leaves the space for
//! good: seen from inside, no face hides another. One that meets a face from outside has met nothing before: so faces
//! that show their outer sides (they are double-sided, or their fronts are outside) come once more after the
//! others, where the eye is on that side, and hide one another no more than the others do. Far to near is any order of
//! the first, then any order of the second; faces in one plane come by their numbers, the lowest last. What hides nothing
//! has no say, and may stand anywhere.
//! Source: Boreskov, Using portals to create aggregate scenes (a convex cell: just draw the front faces).
//! Cost: building 0.2 to 0.4 µs for each face in a plane met just before (a box of 12 million triangles: 3 s), and 2 to 20 µs
//!     for each in a new one (the more, the finer a dome is cut); what is not convex is refused at the first face that
//!     shows it, mostly within a millisecond. A walk O(items, and clusters of those in view), and twice for outer sides.
//! Gives an exact order, far to near, of geometries that are convex; others are refused, also after an edit.

mod laid;
mod resting;
mod walls;

use super::items::{hand_out_opening, hand_out_openings, hand_out_openings_at_eye, may_be_seen, sight};
use super::{FarToNear, Order, Refusal, Visit};
use crate::faces::Faces;
use crate::geometry::{Alpha, Geometry, ItemId, MovedItem, OpeningId};
use crate::passage::Passage;
use crate::region::Visibility;
use glam::{DAffine3, DVec3};
use walls::Walls;

/// The faces of a convex space.
pub struct ConvexCell {
    /// The planes of faces that show their outer sides.
    planes: Vec<Plane>,
    /// Those faces, in order of their numbers.
    outside: Vec<Outside>,
    /// Openings whose fronts are outside, and the plane of each by its place.
    openings: Vec<(OpeningId, u32)>,
    /// Clusters in which faces lie on one another, sorted.
    laid: Vec<(ItemId, u32)>,
    /// Of which items some face hides, by number.
    hiding: Vec<bool>,
}

/// Some faces of a cluster that show their outer sides, all in one plane.
#[derive(Clone, Copy, Debug)]
struct Outside {
    plane: u32,
    item: ItemId,
    cluster: u32,
    /// Their numbers: the first, and the one after the last.
    faces: [u32; 2],
}

/// A plane, by what is on its inner side.
#[derive(Clone, Copy, Debug)]
struct Plane {
    /// Of length 1; it points inside.
    normal: DVec3,
    offset: f64,
}

impl Plane {
    /// How far inside a point is.
    #[inline(always)]
    fn height(&self, point: DVec3) -> f64 {
        self.normal.dot(point) - self.offset
    }
}

impl Order for ConvexCell {
    // In a convex cell every order is far to near, as long as outer sides come last.
    type Gives = FarToNear;
    type Scratch = ();

    fn build(geometry: &Geometry, limit_bytes: u64) -> Result<ConvexCell, Refusal> {
        let mut walls = Walls::new(geometry, limit_bytes);
        walls.take_openings()?;
        for item in (0..geometry.items().len() as u32).map(ItemId) {
            walls.take_item(item)?;
        }
        Ok(walls.cell)
    }

    fn needs_bytes(geometry: &Geometry) -> u64 {
        // Most faces show one side; how many show the other is found out, and refused, while it is built.
        geometry.items().len() as u64 * size_of::<bool>() as u64
    }

    fn bytes(&self) -> u64 {
        (size_of_val(&*self.planes)
            + size_of_val(&*self.outside)
            + size_of_val(&*self.openings)
            + size_of_val(&*self.laid)
            + size_of_val(&*self.hiding)) as u64
    }

    fn follow(&mut self, geometry: &Geometry, moved: &[MovedItem], _touched: &mut Vec<u32>) -> bool {
        // What hides nothing, and did not before either, may be anywhere.
        moved.iter().all(|moved| {
            let hid = self.hiding.get(moved.item.0 as usize).is_some_and(|&hid| hid);
            !hid && clusters_that_hide(geometry, moved.item).next().is_none()
        })
    }

    fn visit(&self, geometry: &Geometry, passage: &Passage, _scratch: &mut (), visit: &mut impl Visit) {
        hand_out_openings(geometry, passage, visit);
        for item in (0..geometry.items().len() as u32).rev().map(ItemId) {
            self.hand_out(geometry, passage, item, visit);
        }
        let eye = DVec3::from(passage.eye());
        if self.planes.iter().any(|plane| plane.height(eye) < 0.0) {
            self.hand_out_outer_sides(geometry, passage, eye, visit);
        }
        // Rounding may have put these among the outer sides, or things that end in their plane over them.
        hand_out_openings_at_eye(geometry, passage, visit);
    }
}

impl ConvexCell {
    /// Hands out what may be seen of an item, the last cluster first.
    fn hand_out(&self, geometry: &Geometry, passage: &Passage, item: ItemId, visit: &mut impl Visit) {
        let mesh = geometry.mesh_of(item);
        let clusters = mesh.clusters();
        if clusters.is_empty() || !visit.first_time(item) {
            return;
        }
        let screen_from_item = passage.screen_from(&geometry.item(item).transform());
        let whole = match sight(passage, &screen_from_item, &mesh.bounds(), visit) {
            Visibility::Hidden => return,
            Visibility::Partial => clusters.len() == 1,
            Visibility::Full => true,
        };
        for (number, cluster) in (0..clusters.len() as u32).zip(clusters).rev() {
            if !whole && !may_be_seen(passage, &screen_from_item, &cluster.bounds, visit) {
                continue;
            }
            if self.laid.binary_search(&(item, number)).is_ok() {
                let faces = [cluster.faces.start, cluster.faces.end];
                hand_out_backwards(geometry, item, faces, &screen_from_item, visit);
            } else {
                visit.cluster(geometry, item, number, &screen_from_item);
            }
        }
    }

    /// Hands out the faces whose outer sides `eye` is on, over whatever they hide.
    fn hand_out_outer_sides(
        &self,
        geometry: &Geometry,
        passage: &Passage,
        eye: DVec3,
        visit: &mut impl Visit,
    ) {
        let is_outside = |plane: u32| self.planes[plane as usize].height(eye) < 0.0;
        if !passage.flat {
            for &(opening, plane) in self.openings.iter().rev() {
                if is_outside(plane) {
                    hand_out_opening(geometry, passage, opening, visit);
                }
            }
        }
        for &Outside {
            plane,
            item,
            cluster,
            faces,
        } in self.outside.iter().rev()
        {
            let screen_from_item = || passage.screen_from(&geometry.item(item).transform());
            let bounds = &geometry.mesh_of(item).clusters()[cluster as usize].bounds;
            if is_outside(plane) && may_be_seen(passage, &screen_from_item(), bounds, visit) {
                hand_out_backwards(geometry, item, faces, &screen_from_item(), visit);
            }
        }
    }
}

/// Hands out faces one by one, the last first: of those in one plane the lowest is painted over the others.
fn hand_out_backwards(
    geometry: &Geometry,
    item: ItemId,
    faces: [u32; 2],
    screen_from_item: &DAffine3,
    visit: &mut impl Visit,
) {
    for face in (faces[0]..faces[1]).rev() {
        visit.faces(&Faces::of_face(geometry, item, face, screen_from_item, &[]));
    }
}

/// The clusters of an item whose faces hide what is behind them, by their places.
fn clusters_that_hide(geometry: &Geometry, item: ItemId) -> impl Iterator<Item = u32> + '_ {
    let clusters = (0_u32..).zip(geometry.mesh_of(item).clusters());
    let hide =
        clusters.filter(move |(_, cluster)| geometry.material_of(item, cluster).alpha == Alpha::Opaque);
    hide.map(|(number, _)| number)
}
