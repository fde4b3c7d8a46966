//! Geometry and spatial data structures: AABBs, affine transforms, convex polygons, and trees over them (BVH, kd-tree,
//! octree, BSP tree).
//!
//! This module depends on no other part of Enfilade.

mod aabb;
mod apart;
#[cfg(feature = "classic")]
mod bsp;
mod bvh;
mod cross;
mod kd_tree;
mod octree;
mod pierce;
mod polygon;
mod runs;
mod slabs;
mod transform;
#[cfg(test)]
mod tree_laws;

pub(crate) use aabb::is_in_range;
pub use aabb::{Aabb, MAX_COORDINATE};
pub use apart::nearest_points;
#[cfg(feature = "classic")]
pub use bsp::{BspLink, BspOptions, BspStep, BspTree, Piece, Polygons};
pub(crate) use bvh::Bvh;
pub(crate) use cross::cross;
pub(crate) use kd_tree::KdTree;
pub use octree::Step;
pub(crate) use octree::{Enter, Octree, StoredNode};
pub(crate) use pierce::{Pierced, nearest_in, pierced};
pub use polygon::{ConvexPolygon, PolygonError};
pub(crate) use runs::{Run, Runs};
pub(crate) use slabs::Line;
pub use transform::Transform;
