//! Cameras that stand in a file.

/// A perspective camera in world space: what [`enfilade::View`] needs, but for the size of the screen.
#[derive(Clone, Debug, PartialEq)]
pub struct Camera {
    /// How its author called it.
    pub name: String,
    /// Where it stands.
    pub eye: [f32; 3],
    /// A point that it looks at: one unit ahead, or a thousandth of the way to the origin where that is more, so
    /// that rounding does not turn a camera that stands far out.
    pub toward: [f32; 3],
    /// The direction that is upright in its picture, one unit long.
    pub up: [f32; 3],
    /// Vertical angle of the lens, in radians, above 0 and below π.
    pub fov_y: f32,
    /// What is nearer than this is not seen; above 0, in scene units.
    pub near: f32,
}
