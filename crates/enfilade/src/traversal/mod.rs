//! What traversal orders share: the receiver of a traversal, the priority queue of boxes, and the clusters of an item.

mod items;
mod queue;
#[cfg(feature = "steps")]
mod recorder;

#[cfg(feature = "classic")]
pub(crate) use items::may_be_visible;
pub(crate) use items::{box_visibility, emit_item, emit_openings, emit_whole};

pub(crate) use queue::{Queue, Tree, walk};
#[cfg(feature = "terrain")]
pub(crate) use queue::{begin, go_on};
#[cfg(feature = "steps")]
pub(crate) use recorder::Recorder;

use crate::faces::Faces;
use crate::geom::Aabb;
use crate::geometry::Geometry;
use crate::ids::ItemIndex;
use crate::view::passage::Passage;
use crate::view::region::{Region, Visibility};
use crate::view::screen_map::ScreenMap;

/// Receiver of a traversal: culls nodes and takes faces.
pub trait Visit {
    /// Returns the visibility of a box. An order need not test what is inside a fully visible box.
    fn enter(&mut self, region: &Region) -> Visibility;

    /// Like [`Visit::enter`], for a box in another space; hidden if it is out of view.
    fn enter_box(&mut self, passage: &Passage, screen_from_local: &ScreenMap, bounds: &Aabb) -> Visibility {
        Region::of(passage, screen_from_local, bounds)
            .map_or(Visibility::Hidden, |region| self.enter(&region))
    }

    /// Declares that all following boxes are inside the one entered last, until [`Visit::go_back`].
    fn go_within(&mut self) {}

    /// Ends the scope of [`Visit::go_within`]: following boxes may be anywhere.
    fn go_back(&mut self) {}

    /// Returns `true` to accept this mesh node as a whole and skip its clusters. `region` is the node's screen region.
    fn are_enough(&mut self, _item: ItemIndex, _node: u32, _region: &Region) -> bool {
        false
    }

    /// Returns `true` if this item is visited for the first time in this traversal. An item may be in several nodes.
    fn first_time(&mut self, item: ItemIndex) -> bool;

    /// Takes the next batch of faces.
    fn faces(&mut self, faces: &Faces);

    /// As [`Visit::faces`], for faces of an item within the region entered last.
    fn faces_within(&mut self, faces: &Faces, _region: &Region) {
        self.faces(faces);
    }

    /// Takes one cluster of an item as the next batch. A receiver that does not need the faces saves looking them up.
    fn cluster(&mut self, geometry: &Geometry, item: ItemIndex, cluster: u32, screen_from_item: &ScreenMap) {
        self.faces(&Faces::of_cluster(geometry, item, cluster, screen_from_item));
    }

    /// Takes all clusters of an item as the next batches.
    fn whole(&mut self, geometry: &Geometry, item: ItemIndex, screen_from_item: &ScreenMap) {
        for cluster in 0..geometry.mesh_of(item).clusters().len() as u32 {
            self.cluster(geometry, item, cluster, screen_from_item);
        }
    }
}
