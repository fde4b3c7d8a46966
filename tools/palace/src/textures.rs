//! Materials and textures. Textures with holes are PNG, the others JPEG.

use crate::document::{Document, number, numbers};
use anyhow::Result;
use enfilade::{Alpha, Filter, Geometry, Material, Texture, Wrap};
use image::codecs::jpeg::JpegEncoder;
use image::codecs::png::{CompressionType, FilterType, PngEncoder};
use image::{ExtendedColorType, ImageEncoder};
use serde_json::{Value, json};

const JPEG_QUALITY: u8 = 83;

/// Writes the materials of a geometry and the textures that they use.
pub(crate) fn write(document: &mut Document, geometry: &Geometry) -> Result<()> {
    let mut bytes = 0;
    for texture in geometry.textures() {
        let (kind, image) = encoded(texture)?;
        bytes += image.len();
        let view = document.view(&image);
        let source = document.push(
            "images",
            json!({"name": texture.name, "mimeType": kind, "bufferView": view}),
        );
        let sampler = document.push("samplers", sampler(texture));
        document.push("textures", json!({"source": source, "sampler": sampler}));
    }
    println!("{} textures: {bytes} bytes", geometry.textures().len());
    for material in geometry.materials() {
        document.push("materials", of(material));
    }
    Ok(())
}

fn encoded(texture: &Texture) -> Result<(&'static str, Vec<u8>)> {
    let mut image = Vec::new();
    let [width, height] = texture.size();
    if texture.texels().iter().all(|texel| texel[3] == 255) {
        let texels: Vec<[u8; 3]> = texture.texels().iter().map(|&[r, g, b, _]| [r, g, b]).collect();
        JpegEncoder::new_with_quality(&mut image, JPEG_QUALITY).write_image(
            texels.as_flattened(),
            width,
            height,
            ExtendedColorType::Rgb8,
        )?;
        Ok(("image/jpeg", image))
    } else {
        // The color of holes is not seen, and one color compresses better, but it bleeds into the edges.
        PngEncoder::new_with_quality(&mut image, CompressionType::Best, FilterType::Adaptive).write_image(
            texture.texels().as_flattened(),
            width,
            height,
            ExtendedColorType::Rgba8,
        )?;
        Ok(("image/png", image))
    }
}

fn sampler(texture: &Texture) -> Value {
    let [s, t] = texture.wrap.map(|wrap| match wrap {
        Wrap::Repeat => 10497,
        Wrap::Mirror => 33648,
        Wrap::Clamp => 33071,
    });
    let minify = match (texture.minify.texels, texture.minify.levels) {
        (Filter::Nearest, None) => 9728,
        (Filter::Linear, None) => 9729,
        (Filter::Nearest, Some(Filter::Nearest)) => 9984,
        (Filter::Linear, Some(Filter::Nearest)) => 9985,
        (Filter::Nearest, Some(Filter::Linear)) => 9986,
        (Filter::Linear, Some(Filter::Linear)) => 9987,
    };
    let magnify = match texture.magnify {
        Filter::Nearest => 9728,
        Filter::Linear => 9729,
    };
    json!({"wrapS": s, "wrapT": t, "minFilter": minify, "magFilter": magnify})
}

fn of(material: &Material) -> Value {
    let mut pbr = json!({"baseColorFactor": numbers(&material.base_color), "metallicFactor": 0});
    if let Some(texture) = material.texture {
        pbr["baseColorTexture"] = json!({"index": texture.0});
    }
    let mut written = json!({"pbrMetallicRoughness": pbr});
    if material.emission != [0.0; 3] {
        let strength = material.emission.into_iter().fold(1.0, f32::max);
        written["emissiveFactor"] = numbers(&material.emission.map(|part| part / strength));
        if strength > 1.0 {
            written["extensions"]["KHR_materials_emissive_strength"] =
                json!({"emissiveStrength": number(strength)});
        }
        if let Some(texture) = material.emission_texture {
            written["emissiveTexture"] = json!({"index": texture.0});
        }
    }
    if material.unlit {
        written["extensions"]["KHR_materials_unlit"] = json!({});
    }
    match material.alpha {
        Alpha::Opaque => {}
        Alpha::Mask => {
            written["alphaMode"] = json!("MASK");
            written["alphaCutoff"] = number(material.cutoff);
        }
        Alpha::Blend => written["alphaMode"] = json!("BLEND"),
    }
    if material.double_sided {
        written["doubleSided"] = json!(true);
    }
    if material.detail {
        written["extras"]["enfilade"]["detail"] = json!(true);
    }
    written
}
