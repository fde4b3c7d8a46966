//! What goes into the buffer and what it is asked about, in the space of a passage: (X, Y, W).

use glam::DVec3;

/// A flat convex polygon that hides what is behind it.
#[derive(Clone, Copy, Debug)]
pub struct Occluder<'a> {
    /// Counter-clockwise as the eye sees them.
    pub corners: &'a [DVec3],
    /// What lies at n · p > d, in the cone of the eye over the polygon, is hidden; d > 0. The plane may lie a little
    /// behind the surface.
    pub plane: (DVec3, f64),
}

/// A box: `origin` plus up to once each of `sides`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Volume {
    /// One corner.
    pub origin: DVec3,
    /// The edges that meet there.
    pub sides: [DVec3; 3],
}
