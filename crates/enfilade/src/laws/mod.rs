//! Conformance checks (laws): an independent ray-cast oracle, and the comparison of every method's result with it.
//!
//! Idea: traces five rays per sample through the portals; every surface that any of them may hit first is a possible
//! owner. If all possible owners are one item, the sample is certain, otherwise it is contested.
//! Source: the definitions of [`Contract`](crate::Contract); Möller, Trumbore 1997 for triangles.
//! Cost: about 3 µs per sample and core, half a microsecond for a single ray at a random position; two tree nodes per
//! triangle.
//! Independent of the methods: shares with them only the input arrays of geometries, scenes and views. The sector of
//! the eye, the rays of a view and their portal chains are computed separately, in the simplest way.
//!
//! Tolerance: positions are f32, so a face or an opening is known only to half an f32 ulp of its largest coordinate. If
//! that decides which of two surfaces is nearer, both are possible owners. This matters for nearly coplanar faces, at
//! grazing angles, at very short distances and far from the origin. If the corners of an opening are not quite
//! coplanar, a ray that passes its edge within that deviation may or may not enter.

mod bundle;
mod chains;
mod contracts;
mod hits;
mod layers;
mod lens;
mod openings;
mod owners;
mod reference;
mod sector;
mod straight;
mod tree;
mod truth;
mod walks;

pub use contracts::{Broken, Contestants, Law, Report, check, check_custom};
pub use layers::{LayerPicture, LayerVerdict, Layers};
pub use owners::OwnerPicture;
pub use reference::Reference;
pub use straight::{Blocker, Lamplight, SurfacePoint, chains, goes_straight};
pub use truth::{Truth, Verdict};
pub use walks::views_through;

/// Offset of the four outer rays from the sample's centre, in pixels, along x and y: 2⁻¹⁰.
pub const DELTA_PX: f64 = 1.0 / 1024.0;

/// Relative tolerance of reversed depth: two surfaces that differ by less are equally near. 2⁻¹⁶.
pub const EPSILON: f64 = 1.0 / 65_536.0;
