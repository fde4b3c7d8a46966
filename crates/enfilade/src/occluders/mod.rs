//! Occluders: faces that are worth testing others against.

use glam::DVec3;

/// Which occluders are worth most.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Measure {
    /// Those that cover most of the screen.
    ProjectedArea,
    /// Those with the greatest area · cosine / distance²: about the solid angle. Bittner, Havran, Slavík, Hierarchical
    /// Visibility Culling with Occlusion Trees, CGI 1998.
    AreaAngle,
}

/// A convex polygon that hides what is behind it, as a passage sees it.
///
/// Hidden is what lies inside the pyramid from the eye over the polygon, strictly beyond its plane.
#[derive(Clone, Copy, Debug)]

pub struct Occluder<'a> {
    /// Corners as (X, Y, W), where the eye is the origin; counter-clockwise as the eye sees them.
    pub(crate) corners: &'a [DVec3],
    /// n and d: what is behind the plane has n · p > d. d is above 0, for the eye is before it.
    pub(crate) plane: (DVec3, f64),
}
