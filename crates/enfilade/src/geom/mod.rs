//! Boxes, planes, transforms and convex polygons: plain geometry that knows nothing else of Enfilade.

mod aabb;
pub mod bsp;
mod octree;
mod polygon;
mod transform;

pub use aabb::Aabb;
pub use octree::{Copies, Octree, Step};
pub use polygon::{ConvexPolygon, PolygonError};
pub use transform::Transform;
