//! Our side. Nothing else here knows how `enfilade_draw` is called.

use anyhow::Result;
use enfilade::{Scene, View, Viewer};
use enfilade_draw::{Settings, Stage};
use rayon::{ThreadPool, ThreadPoolBuilder};

/// Red, green and blue of each pixel in sRGB, row after row from the top.
pub(crate) type Picture = Vec<u8>;

/// Our renderer with a number of threads to shade by.
pub(crate) struct Ours {
    stage: Stage,
    pool: ThreadPool,
    pub(crate) cores: usize,
}

impl Ours {
    /// Makes ready what all pictures of a scene share.
    pub(crate) fn new(scene: &Scene, cores: usize) -> Result<Ours> {
        Ok(Ours {
            stage: Stage::new(scene),
            pool: ThreadPoolBuilder::new().num_threads(cores).build()?,
            cores,
        })
    }

    /// The whole picture of a view, sky included, as the other side draws it, too.
    pub(crate) fn picture(&self, viewer: &mut Viewer, scene: &Scene, view: &View) -> Picture {
        let draw = || self.stage.draw(viewer, scene, view, &Settings::default());
        self.pool.install(draw).image.into_raw()
    }
}
