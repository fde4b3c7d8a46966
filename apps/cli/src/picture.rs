//! Pictures of a prepared scene, and their encoding as PNG.

use crate::prepare::PreparedScene;
use anyhow::{Context, Result};
use enfilade::{View, Viewer};
use enfilade_draw::{Exposure, Picture, RgbImage, Settings, Show};
use image::codecs::png::{CompressionType, FilterType, PngEncoder};

/// Returns the program's render settings: exposure adapts to the light at the eye.
pub(crate) fn settings(show: Show) -> Settings {
    let mut settings = Settings::default();
    settings.show = show;
    settings.exposure = Exposure::Eye(0.0);
    settings
}

/// Draws a view, shading included.
pub(crate) fn draw(
    prepared: &PreparedScene,
    viewer: &mut Viewer,
    view: &View,
    settings: &Settings,
) -> Picture {
    prepared.stage().draw(viewer, &prepared.scene, view, settings)
}

/// Returns a picture as the bytes of a PNG.
pub(crate) fn png(image: &RgbImage) -> Result<Vec<u8>> {
    let mut bytes = Vec::new();
    // The fastest compression makes pictures with large flat areas twice as large.
    let png = PngEncoder::new_with_quality(&mut bytes, CompressionType::Default, FilterType::Adaptive);
    image
        .write_with_encoder(png)
        .context("cannot encode a picture as PNG")?;
    Ok(bytes)
}
