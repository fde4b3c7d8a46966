//! Traversal orders: the sequence in which nodes and faces are visited.
//!
//! An [`Order`] does not know any cover; `method` combines one of each. It does not hold the geometry either:
//! [`Order::visit`] gets it as an argument, because all methods of a sector share one geometry.

mod baked_cells;
#[cfg(feature = "classic")]
mod beside_sorted;
#[cfg(feature = "classic")]
mod bsp;
mod bvh;
#[cfg(feature = "classic")]
mod convex_cell;
#[cfg(feature = "classic")]
mod depth_sort;
mod kd_tree;
#[cfg(feature = "terrain")]
mod large_terrain;
mod octree;
#[cfg(feature = "terrain")]
mod terrain_rows;
mod unordered;

pub use crate::traversal::Visit;
pub use baked_cells::BakedCellsOrder;
#[cfg(feature = "classic")]
pub use bsp::{Bsp, Direction};
pub use bvh::BvhOrder;
#[cfg(feature = "classic")]
pub use convex_cell::ConvexCell;
#[cfg(feature = "classic")]
pub use depth_sort::{DepthSort, Mean, Min, SortKey};
pub use kd_tree::KdTreeOrder;
pub use octree::OctreeOrder;
#[cfg(feature = "terrain")]
pub use terrain_rows::TerrainRows;
pub use unordered::Unordered;

use crate::geometry::{Geometry, MovedItem};
use crate::sector::{BuildStats, Requirement};
use crate::unsuited::Unsuited;
use crate::view::passage::Passage;

/// Guarantee of an [`Order`]: none.
pub struct Unsorted;
/// Guarantee of an [`Order`]: nodes come front to back, as far as boxes can be ordered.
pub struct NodesNearToFar;
/// Guarantee of an [`Order`]: front to back; no face comes before one that occludes it.
pub struct NearToFar;
/// Guarantee of an [`Order`]: back to front; no face comes after one that it occludes.
pub struct FarToNear;

/// `A: Gives<B>`: an order that guarantees A satisfies a cover that requires B.
#[diagnostic::on_unimplemented(
    message = "an order that guarantees `{Self}` cannot be combined with a cover that requires `{Needed}`",
    label = "incompatible order and cover"
)]
pub trait Gives<Needed> {}
impl<T> Gives<Unsorted> for T {}
impl Gives<NodesNearToFar> for NodesNearToFar {}
impl Gives<NodesNearToFar> for NearToFar {}
impl Gives<NearToFar> for NearToFar {}
impl Gives<FarToNear> for FarToNear {}

/// Keeps [`Order`] and its parameters from being implemented elsewhere.
mod sealed {
    use super::*;

    pub trait Sealed {}
    impl Sealed for BakedCellsOrder {}
    #[cfg(feature = "classic")]
    impl<D> Sealed for Bsp<D> {}
    impl Sealed for BvhOrder {}
    #[cfg(feature = "classic")]
    impl Sealed for ConvexCell {}
    #[cfg(feature = "classic")]
    impl<K> Sealed for DepthSort<K> {}
    impl Sealed for KdTreeOrder {}
    impl Sealed for OctreeOrder {}
    #[cfg(feature = "terrain")]
    impl Sealed for TerrainRows {}
    impl Sealed for Unordered {}
    impl Sealed for FarToNear {}
    impl Sealed for NearToFar {}
    #[cfg(feature = "classic")]
    impl Sealed for Min {}
    #[cfg(feature = "classic")]
    impl Sealed for Mean {}
}

/// Traversal order: emits faces in batches in a guaranteed order, and tests each node's visibility before entering it.
///
/// Sealed: a cover that relies on [`Order::Gives`] culls visible items if an order breaks it, which the compiler cannot
/// check, only the laws. So the trait may also gain methods in any version. To compute visibility in another way,
/// implement [`Sector`](crate::Sector).
#[doc(alias = "traversal order")]
pub trait Order: sealed::Sealed + Send + Sync + Sized + 'static {
    /// Guaranteed order: one of [`Unsorted`], [`NodesNearToFar`], [`NearToFar`], [`FarToNear`].
    type Gives;

    /// Scratch memory of a traversal, reused by the next one.
    type Scratch: Default + Send + 'static;

    /// Name of the type, for tables and reports.
    const NAME: &'static str;

    /// What the geometry must have; `None` if the order takes any geometry.
    const REQUIRES: Option<Requirement> = None;

    /// Whether the faces always come in the order of [`Order::Gives`], not only in simple cases.
    const KEEPS_ORDER: bool = true;

    /// Whether building sorts all faces into a BSP tree. That splits some, and takes long for many faces.
    const SPLITS_FACES: bool = false;

    /// Whether what was built includes the openings, and so must be built again when these change.
    const INCLUDES_OPENINGS: bool = false;

    /// Returns `true` if a geometry meets [`Order::REQUIRES`].
    fn suits(geometry: &Geometry) -> bool {
        Self::REQUIRES.is_none() || Self::build(geometry, u64::MAX).is_ok()
    }

    /// Builds the order over a geometry.
    ///
    /// # Errors
    /// The requirement that the geometry does not meet; [`Unsuited::TooLarge`] if building turns out to need
    /// more than `limit_bytes`.
    fn build(geometry: &Geometry, limit_bytes: u64) -> Result<Self, Unsuited>;

    /// Returns an upper estimate of the bytes that [`Order::build`] needs, without building.
    fn needs_bytes(geometry: &Geometry) -> u64;

    /// Returns the memory in use, in bytes, without what the geometry itself holds.
    fn bytes(&self) -> u64;

    /// Returns the number of faces and splits and the depth of what was built.
    fn build_stats(&self, geometry: &Geometry) -> BuildStats {
        BuildStats {
            faces: geometry.face_count(),
            ..BuildStats::default()
        }
    }

    /// Updates the order after items of `geometry` have moved, been added or removed. Changes only affected nodes and
    /// appends them to `touched`. Returns `false` if the order cannot be updated and must be rebuilt.
    ///
    /// Default `false`. A default instead of a trait of its own, because a sector is edited as a trait object, whose
    /// order is not known then.
    fn follow(&mut self, _geometry: &Geometry, _moved: &[MovedItem], _touched: &mut Vec<u32>) -> bool {
        false
    }

    /// Emits all faces of the items and openings that may be visible through `passage`.
    fn visit(
        &self,
        geometry: &Geometry,
        passage: &Passage,
        scratch: &mut Self::Scratch,
        visit: &mut impl Visit,
    );

    /// Begins a traversal that can be split into parts for several threads ([`Order::deal`], [`Order::go_on`]). Returns
    /// the number of pending entries: at least `least`, or fewer if there are no more. Returns 0 if everything was
    /// emitted already, as by orders that cannot be split.
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

    /// Splits the pending traversal queue into `of` parts and returns part `number` in `share`; part 0 comes first in
    /// the order. All parts together emit what one traversal would; an item listed in two of them is emitted twice.
    fn deal(&self, _begun: &Self::Scratch, [_number, _of]: [usize; 2], _share: &mut Self::Scratch) {}

    /// Continues a traversal begun by [`Order::begin`], or one part of it.
    fn go_on(
        &self,
        _geometry: &Geometry,
        _passage: &Passage,
        _scratch: &mut Self::Scratch,
        _visit: &mut impl Visit,
    ) {
    }
}
