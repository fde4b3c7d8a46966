//! Cameras that stand in a file.

use enfilade::SectorId;

/// A camera in world space: what [`enfilade::View`] needs, but for the size of the screen.
///
/// A view has a lens. So an orthographic camera, whose lines of sight are parallel, is here one with a narrow lens that
/// stands far behind where its author put it: so far that on a screen 1280 pixels wide nothing that its author has in its
/// picture is more than about half a pixel off, and what is in the middle of all that, from near to far, as large as it
/// should be.
#[derive(Clone, Debug, PartialEq)]
pub struct Camera {
    /// How its author called it.
    pub name: String,
    /// Where it stands.
    pub eye: [f32; 3],
    /// A point that it looks at: one unit ahead, or a thousandth of the way to the origin where that is more, so
    /// that rounding does not turn a camera that stands far out. Of an orthographic one, the middle of what it sees.
    pub toward: [f32; 3],
    /// The direction that is upright in its picture, one unit long.
    pub up: [f32; 3],
    /// Vertical angle of the lens, in radians, above 0 and below π.
    pub fov_y: f32,
    /// What is nearer than this is not seen; above 0, in scene units. Of an orthographic one, where its author has its
    /// picture begin.
    pub near: f32,
    /// The room to look from. `None`: to be found, from where it stands, as [`enfilade::View::sector`] says; of an
    /// orthographic one, which stands elsewhere, it is always said.
    pub sector: Option<SectorId>,
    /// What an orthographic one shows from bottom to top, in scene units; `None` of one with a lens.
    pub height: Option<f32>,
}
