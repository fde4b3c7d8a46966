//! Cameras of a file.

use enfilade::SectorId;

/// A camera in world space: all parameters of an [`enfilade::View`] except the viewport size.
///
/// A view has a perspective projection, because apertures, passages and covers require an eye point, and covers compare
/// depth as 1/w. An orthographic camera therefore becomes a perspective one with a narrow field
/// of view, far behind its original position: so far that in a 1280-pixel-wide viewport no vertex moves by more than
/// about half a pixel. Geometry halfway between the near and far ends of the scene has the correct size.
#[derive(Clone, Debug, PartialEq)]
pub struct Camera {
    /// Name of the camera's node or entity.
    pub name: String,
    /// Camera position.
    pub eye: [f32; 3],
    /// Look-at point. Perspective: one unit ahead, or a thousandth of the distance to the origin if that is larger, so
    /// that rounding does not rotate a camera far from the origin. Orthographic: the centre of the visible depth range.
    pub toward: [f32; 3],
    /// Up vector, unit length.
    pub up: [f32; 3],
    /// Vertical field of view, in radians, above 0 and below π.
    pub fov_y: f32,
    /// Near-plane distance in scene units, above 0. For an orthographic camera, the same plane as in the file.
    pub near: f32,
    /// Sector of the camera. `None`: found from the position, as described at [`enfilade::View::sector`]. Always `Some`
    /// for an orthographic camera, because its position here is not the one in the file.
    pub sector: Option<SectorId>,
    /// Height of the view volume of an orthographic camera, in scene units; `None` for a perspective one.
    pub height: Option<f32>,
}
