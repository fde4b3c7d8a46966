//! What applies to all cameras.

use bevy_ecs::prelude::*;
use enfilade::{Limits, Method, ViewerOptions};

/// What applies to all cameras. May be changed at run time.
#[derive(Resource, Clone, Copy, Debug, PartialEq)]
pub struct EnfiladeSettings {
    /// Whether Enfilade culls. Default `true`. While it is off, it costs nothing; to turn it on reads the whole world again.
    pub enabled: bool,
    /// The method that culls. Default [`Method::Masked`].
    pub method: Method,
    /// At which samples of a picture nothing may be missing. Default `None`: what each camera's antialiasing takes. Without
    /// the feature `pbr`, that is not known, and is [`Samples::Any`].
    pub samples: Option<Samples>,
    /// Options of looks; layers are the camera's own, and the margin follows from the samples. A camera that sees through more
    /// portals than the [`Limits`] allow, between mirrors that face each other, say, is not culled for. Default: 128 passages.
    pub options: ViewerOptions,
}

/// Positions in the pixels of a picture.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Samples {
    /// The middle of each pixel, as without multisampling: one look.
    Centers,
    /// Those of 4x multisampling: a look at each.
    Four,
    /// Any, as with temporal antialiasing, 8x multisampling or upscaling: one look with occluders whose faces shrink by half
    /// a pixel. Faces of a few pixels then hide nothing.
    Any,
}

impl Default for EnfiladeSettings {
    fn default() -> EnfiladeSettings {
        let mut limits = Limits::default();
        limits.max_passages = 128;
        EnfiladeSettings {
            enabled: true,
            method: Method::Masked,
            samples: None,
            options: ViewerOptions {
                // What GPUs round.
                growth_px: 1.0,
                // Bevy's own tasks fill the cores.
                parallel: false,
                limits,
                ..ViewerOptions::default()
            },
        }
    }
}
