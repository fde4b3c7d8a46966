//! Why a view is refused.

use super::{ClipDepth, View};
use crate::geom::MAX_COORDINATE;
use thiserror::Error;

/// Why the constructors of [`View`] refuse a view.
#[derive(Clone, Copy, Debug, PartialEq, Error)]
#[non_exhaustive]
pub enum ViewError {
    /// A value is NaN or infinite.
    #[error("{0} is not finite")]
    NotFinite(&'static str),
    /// A coordinate is beyond ±[`MAX_COORDINATE`].
    #[error(
        "{0} is farther out than {MAX_COORDINATE:e} units; scale the scene down or move it to the origin"
    )]
    TooFar(&'static str),
    /// `eye` and `toward` are equal.
    #[error("the eye and its target point are the same; they must differ")]
    NoDirection,
    /// Width or height is 0 or above [`View::MAX_PIXELS`].
    #[error("viewport of {0}x{1} pixels; width and height must be 1 to {max}", max = View::MAX_PIXELS)]
    Size(u32, u32),
    /// The viewport starts so far to the right or down that pixel numbers would overflow.
    #[error("viewport at pixel ({0}, {1}); both must be below 4 billion")]
    Origin(u32, u32),
    /// The field of view is not above 0 and below π; the value is in degrees.
    #[error("vertical field of view of {0} degrees; it must be above 0 and below 180")]
    FieldOfView(f32),
    /// The sample is outside its pixel.
    #[error("sample at ({0}, {1}) from the pixel centre; both must be from -0.5 to 0.5")]
    Sample(f32, f32),
    /// The near-plane distance is zero, negative or not finite.
    #[error("near-plane distance of {0}; it must be above 0 and finite")]
    Near(f32),
    /// The orientation is not a unit quaternion.
    #[error("the orientation is not a unit quaternion (x, y, z, w)")]
    Orientation,
    /// The tangents do not grow from left to right and from bottom to top.
    #[error("the tangents must be finite, left below right and bottom below top")]
    Tangents,
    /// The last row of the view matrix is not (0, 0, 0, 1).
    #[error("the last row of eye_from_sector must be (0, 0, 0, 1); is the matrix transposed, or not set?")]
    NotAffine,
    /// The projection matrix is transposed: its last row has no distance along the view direction, but the row of z has.
    #[error("the projection matrix is transposed: its last row must be (0, 0, -1, 0) or (0, 0, 1, 0)")]
    Transposed,
    /// A matrix has no inverse: it maps space to a plane, a line or a point.
    #[error("the matrices have no inverse")]
    Singular,
    /// The height of what a parallel view shows is not above 0 and finite.
    #[error("a parallel view that shows a height of {0}; it must be above 0 and finite")]
    Height(f64),
    /// A parallel projection without depth: its near plane contains the view direction.
    #[error("the near plane of the parallel projection contains the view direction; the row of z is wrong")]
    Parallel,
    /// An oblique near plane with the eye on the side that is drawn.
    #[error("the eye is not behind the oblique near plane; its normal must point away from the eye")]
    Oblique,
    /// With the given clip depth, the near plane of the projection is not in front of the eye, or not nearer than the far
    /// plane. `is_reversed` tells whether it would be with [`ClipDepth::OneToZero`].
    #[error(
        "with clip depth {depth:?} the near plane is not in front of the far plane; {}",
        match (*is_reversed, *depth) {
            (true, _) => "depth is reversed, use OneToZero",
            (false, ClipDepth::OneToZero) => "depth is not reversed, use ZeroToOne or MinusOneToOne",
            (false, _) => "is the projection matrix transposed?",
        }
    )]
    ClipDepth {
        /// The clip depth that was given.
        depth: ClipDepth,
        /// Whether the depth of the matrix is reversed.
        is_reversed: bool,
    },
}
