//! Enfilade's renderer. This module alone calls `enfilade_draw`.

use anyhow::Result;
use enfilade::{Scene, View, Viewer};
use enfilade_draw::{Settings, Stage};
use rayon::{ThreadPool, ThreadPoolBuilder};

/// RGB of each pixel in sRGB, row after row from the top.
pub(crate) type Picture = Vec<u8>;

/// Enfilade's renderer with a thread pool for shading.
pub(crate) struct EnfiladeRenderer {
    stage: Stage,
    pool: ThreadPool,
    pub(crate) cores: usize,
}

impl EnfiladeRenderer {
    /// Prepares the per-scene state.
    pub(crate) fn new(scene: &Scene, cores: usize) -> Result<EnfiladeRenderer> {
        Ok(EnfiladeRenderer {
            stage: Stage::new(scene),
            pool: ThreadPoolBuilder::new().num_threads(cores).build()?,
            cores,
        })
    }

    /// Renders the whole picture of a view, sky included, as the other renderer does.
    pub(crate) fn picture(&self, viewer: &mut Viewer, scene: &Scene, view: &View) -> Picture {
        let draw = || self.stage.draw(viewer, scene, view, &Settings::default());
        self.pool.install(draw).image.into_raw()
    }
}
