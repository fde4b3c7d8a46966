//! The reference, and what methods are held against it.
//!
//! Idea: five rays a sample, each followed through portals; whatever any of them may meet first may own the sample.
//! Source: DESIGN of the contracts; Möller, Trumbore 1997 for triangles.
//! Cost: about 3 µs a sample and core, half of one for a single ray anywhere; memory of two nodes a triangle.
//! Independent of the methods: it shares with them only the input arrays of geometries, scenes and views. Which sector the
//! eye is in, the rays of a view and the chains of portals they follow are computed here anew, in the simplest way.
//!
//! Positions are f32, so a face or an opening is where its corners are only up to half the spacing of f32 at its greatest
//! coordinate. Where that decides which of two is nearer, both are possible: it matters for faces nearly in one plane, seen
//! at a grazing angle or from very close, and far from the origin. Where the corners of an opening are not quite in one plane,
//! a ray that passes its edge within that bend may go in or not.

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

pub use contracts::{Broken, Contestants};
pub use layers::{LayerPicture, LayerVerdict, Layers};
pub use owners::OwnerPicture;
pub use reference::Reference;
pub use straight::{Lamplight, chains, goes_straight};
pub use truth::{Truth, Verdict};
pub use walks::views_through;

/// How far from a sample's centre the other four rays pass, in pixels, along x and y: 2⁻¹⁰.
pub const DELTA_PX: f64 = 1.0 / 1024.0;

/// Faces whose reversed depth differs by less than this, relatively, are as near as each other: 2⁻¹⁶.
pub const EPSILON: f64 = 1.0 / 65_536.0;
