//! Orders: what comes next. An order knows nothing of covers; `method` joins the two.

mod baked_cells;
mod bsp;
mod bvh;
mod convex_cell;
mod depth_sort;
mod items;
mod kd_tree;
mod large_terrain;
mod octree;
mod queue;
mod terrain_rows;
mod unordered;

pub use baked_cells::BakedCellsOrder;
pub use bsp::{Bsp, Direction};
pub use bvh::BvhOrder;
pub use convex_cell::ConvexCell;
pub use depth_sort::{DepthSort, Mean, Min, SortKey};
pub use kd_tree::KdTreeOrder;
pub use octree::OctreeOrder;
pub use terrain_rows::TerrainRows;
pub use unordered::Unordered;

use crate::faces::Faces;
use crate::geom::Aabb;
use crate::geometry::{Geometry, ItemId, MovedItem, Owner};
use crate::passage::Passage;
use crate::region::{Region, Visibility};
use crate::sector::BuildStats;
use glam::DAffine3;

/// What an order promises: nothing.
pub struct Unsorted;
/// What an order promises: nodes come near to far, as far as boxes can be ordered.
pub struct NodesNearToFar;
/// What an order promises: no face comes before one that hides it.
pub struct NearToFar;
/// What an order promises: no face comes after one that it hides.
pub struct FarToNear;

/// `A: Gives<B>`: an order that promises A may be used where B is needed.
#[diagnostic::on_unimplemented(
    message = "an order that gives `{Self}` does not suit a cover that needs `{Needed}`",
    label = "this order and this cover do not go together"
)]
pub trait Gives<Needed> {}
impl<T> Gives<Unsorted> for T {}
impl Gives<NodesNearToFar> for NodesNearToFar {}
impl Gives<NodesNearToFar> for NearToFar {}
impl Gives<NearToFar> for NearToFar {}
impl Gives<FarToNear> for FarToNear {}

/// Why an order cannot be built over a geometry.
#[derive(Clone, Copy, Debug, PartialEq)]
#[non_exhaustive]
pub enum Refusal {
    /// It turns out that more bytes are needed than are allowed.
    TooLarge,
    /// There are no cells to go by.
    NotBaked,
    /// A face has others on both of its sides.
    NotConvex(Dent),
    /// There is no ground to go by.
    NoTerrain,
    /// A block of the ground is not where it was, or not as it was.
    TerrainChanged,
}

/// A face, and what is farthest behind it although something else is before it.
#[derive(Clone, Copy, Debug, PartialEq)]
#[non_exhaustive]
pub struct Dent {
    /// The face, or the opening.
    pub wall: Owner,
    /// What has a corner behind it.
    pub behind: Owner,
    /// That corner, in the space of the sector.
    pub point: [f64; 3],
    /// How far behind the plane of `wall` it is, in scene units.
    pub by: f64,
}

/// Hands out faces, in batches, in the order it promises; asks before it enters a node.
pub trait Order: Send + Sync + Sized + 'static {
    /// One of [`Unsorted`], [`NodesNearToFar`], [`NearToFar`], [`FarToNear`].
    type Gives;

    /// What a walk needs; kept from one to the next.
    type Scratch: Default + Send + 'static;

    /// Prepares the order of a geometry.
    ///
    /// # Errors
    /// [`Refusal`], which is [`Refusal::TooLarge`] where it turns out that more than `limit_bytes` are needed.
    fn build(geometry: &Geometry, limit_bytes: u64) -> Result<Self, Refusal>;

    /// At most how many bytes [`Order::build`] will take, by an estimate made without building.
    fn needs_bytes(geometry: &Geometry) -> u64;

    /// Memory in bytes.
    fn bytes(&self) -> u64;

    /// What was built.
    fn build_stats(&self, geometry: &Geometry) -> BuildStats {
        BuildStats {
            faces: geometry.face_count(),
            ..BuildStats::default()
        }
    }

    /// Follows items of `geometry` that have moved, come or gone since, touching only what is concerned, and writes down the
    /// nodes touched. `false` where it cannot, and must be built anew.
    fn follow(&mut self, _geometry: &Geometry, _moved: &[MovedItem], _touched: &mut Vec<u32>) -> bool {
        false
    }

    /// Hands out all faces of the items and openings that may be seen through `passage`.
    fn visit(
        &self,
        geometry: &Geometry,
        passage: &Passage,
        scratch: &mut Self::Scratch,
        visit: &mut impl Visit,
    );

    /// Begins a visit that several visitors can go on with, each in a share of what waits then, side by side. Gives how much
    /// that is: about `least` and more, or all that there is; 0 where all was handed out, as by orders that cannot do this.
    fn begin(
        &self,
        geometry: &Geometry,
        passage: &Passage,
        _least: usize,
        scratch: &mut Self::Scratch,
        visit: &mut impl Visit,
    ) -> usize {
        self.visit(geometry, passage, scratch, visit);
        0
    }

    /// Deals one of so many shares of what waits in a visit begun, by number; what comes first is in the first. All together are
    /// what one visitor would be handed out, what stands in two of them twice.
    fn deal(&self, _begun: &Self::Scratch, [_number, _of]: [usize; 2], _share: &mut Self::Scratch) {}

    /// Goes on with a visit begun, or a share of it.
    fn go_on(
        &self,
        _geometry: &Geometry,
        _passage: &Passage,
        _scratch: &mut Self::Scratch,
        _visit: &mut impl Visit,
    ) {
    }
}

/// What walks along with an order.
pub trait Visit {
    /// How much of this box can still be seen? Of what is in a box that is fully seen, an order need not ask again.
    fn enter(&mut self, region: &Region) -> Visibility;

    /// As [`Visit::enter`], of a box given in another space; nothing of it where it is out of view.
    fn enter_box(&mut self, passage: &Passage, screen_from_local: &DAffine3, bounds: &Aabb) -> Visibility {
        Region::of(passage, screen_from_local, bounds)
            .map_or(Visibility::Hidden, |region| self.enter(&region))
    }

    /// From now on all boxes lie in the one that was entered last.
    fn go_within(&mut self) {}

    /// From now on boxes lie anywhere again.
    fn go_back(&mut self) {}

    /// Is it enough that a node of an item's mesh, within `region`, was met? Then its clusters are not handed out.
    fn are_enough(&mut self, _item: ItemId, _node: u32, _region: &Region) -> bool {
        false
    }

    /// Is it the first time that this item is met in this walk? An item may stand in several nodes.
    fn first_time(&mut self, item: ItemId) -> bool;

    /// The next batch.
    fn faces(&mut self, faces: &Faces);

    /// The next batch is a cluster of an item. Who does not need its faces saves looking them up.
    fn cluster(&mut self, geometry: &Geometry, item: ItemId, cluster: u32, screen_from_item: &DAffine3) {
        self.faces(&Faces::of_cluster(geometry, item, cluster, screen_from_item));
    }

    /// The next batches are all clusters of an item.
    fn whole(&mut self, geometry: &Geometry, item: ItemId, screen_from_item: &DAffine3) {
        for cluster in 0..geometry.mesh_of(item).clusters().len() as u32 {
            self.cluster(geometry, item, cluster, screen_from_item);
        }
    }
}
