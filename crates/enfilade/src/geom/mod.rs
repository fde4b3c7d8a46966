//! Boxes, transforms, convex polygons, and trees over them: plain geometry that knows nothing else of Enfilade.

mod aabb;
mod bsp;
mod bvh;
#[cfg(test)]
mod changes;
mod cross;
mod kd_tree;
mod octree;
mod pierce;
mod polygon;
mod runs;
mod transform;

pub use aabb::Aabb;
pub use bsp::{BspLink, BspOptions, BspStep, BspTree, Piece, Polygons};
pub use bvh::Bvh;
pub(crate) use cross::cross;
pub use kd_tree::KdTree;
pub use octree::{Enter, Octree, Step};
pub(crate) use pierce::{Pierced, nearest_in, pierced};
pub use polygon::{ConvexPolygon, PolygonError};
pub use transform::Transform;
