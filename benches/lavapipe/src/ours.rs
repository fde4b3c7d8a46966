//! Our side. Nothing else here knows how `enfilade_draw` is called.

use enfilade::{Scene, View, Viewer};
use enfilade_draw::{Painter, Show};

/// Red, green and blue of each pixel in sRGB, row after row from the top.
pub(crate) type Picture = Vec<u8>;

/// Cores that [`picture`] uses.
pub(crate) const CORES: usize = 1;

/// The whole picture of a view, sky included, as the other side draws it, too.
pub(crate) fn picture(viewer: &mut Viewer, scene: &Scene, view: &View) -> Picture {
    let mut painter = Painter::new(scene, view, Show::Image);
    viewer.draw(scene, view, &mut painter);
    painter.into_image().into_raw()
}
