//! Lightmaps: the light computed by map compilers, as textures.
//!
//! Quake stores one image per face and light style, with a sample every 16 texels; they are packed into one atlas
//! texture. Quake 3 stores lightmap pages of 128×128 samples, which faces share. Engines multiply gamma-encoded values:
//! a sample of 128 leaves a texture unchanged; in Quake 3, one of 64.
//! Source: the source code of both engines, `R_BuildLightMap` and `R_ColorShiftLightingBytes`.

use super::pattern::PATTERNS;
use crate::BrokenRule;
use crate::budget::Budget;
use crate::quake::bsp::Map;
use enfilade::{Filter, Minify, Texture, TextureId, Wrap};
use std::sync::Arc;

/// The light lumps.
const LIGHT: usize = 8;
const LIGHT_OF_QUAKE_3: usize = 14;
/// Width of the Quake atlas, in samples.
const WIDTH: u32 = 1024;
/// Width and height of a Quake 3 page, in samples.
const PAGE: u32 = 128;
const BYTES_OF_A_PAGE: usize = 3 * (PAGE * PAGE) as usize;
/// Texels between two samples.
const STEP: f64 = 16.0;
/// Maximum number of samples along a side of a face; compilers split faces long before.
const MAX_SAMPLES: f64 = WIDTH as f64;

/// Factor for colors under a lightmap, so that a sample of 128 shows them unchanged.
pub(super) const FULL: f32 = 4.63;

/// The atlas of all faces of a Quake map, packed in rows.
pub(super) struct FaceLight<'a> {
    lump: &'a [u8],
    texels: Vec<u8>,
    /// Position of the next image, and height of the current row.
    next: [u32; 2],
    row: u32,
}

/// The position of a face in the atlas.
pub(super) struct FaceLightmap {
    first: [u32; 2],
    /// Texel position of the first sample.
    least: [f64; 2],
}

impl<'a> FaceLight<'a> {
    /// Returns an empty atlas; `None` if the map has no light.
    pub(super) fn of(map: &'a Map) -> Option<FaceLight<'a>> {
        let lump = map.lump(LIGHT);
        (!lump.is_empty()).then_some(FaceLight {
            lump,
            texels: Vec::new(),
            next: [0; 2],
            row: 0,
        })
    }

    /// Adds the light of a face whose vertices have these texel positions; returns `None` if its samples exceed the
    /// lump. Black if the face has no samples.
    pub(super) fn add(
        &mut self,
        corners: &[[f64; 2]],
        offset: i64,
        styles: [u8; 4],
        budget: &mut Budget,
    ) -> Result<Option<FaceLightmap>, BrokenRule> {
        let along = |axis: usize| corners.iter().map(move |corner| corner[axis]);
        let least = [0, 1].map(|axis| (along(axis).fold(f64::INFINITY, f64::min) / STEP).floor());
        let most = [0, 1].map(|axis| (along(axis).fold(f64::NEG_INFINITY, f64::max) / STEP).ceil());
        let samples = [0, 1].map(|axis| most[axis] - least[axis] + 1.0);
        if !samples.iter().all(|count| (1.0..=MAX_SAMPLES).contains(count)) {
            return Ok(None);
        }
        let size = samples.map(|count| count as u32);
        let of_style = size[0] as usize * size[1] as usize;
        let used = styles.iter().take_while(|&&style| style != u8::MAX).count();
        let bytes = usize::try_from(offset)
            .ok()
            .map(|start| start..start.saturating_add(used * of_style));
        let bytes = match bytes {
            Some(range) => match self.lump.get(range) {
                Some(bytes) => bytes,
                None => return Ok(None),
            },
            None => &[],
        };
        let Some(first) = self.place(size, budget)? else {
            return Ok(None);
        };
        for (at, texel) in (0..of_style).map(|at| {
            let sum: u32 = bytes
                .chunks_exact(of_style)
                .map(|style| u32::from(style[at]))
                .sum();
            (at as u32, sum.min(255) as u8)
        }) {
            let [column, row] = [first[0] + at % size[0], first[1] + at / size[0]];
            self.texels[(row * WIDTH + column) as usize] = texel;
        }
        Ok(Some(FaceLightmap {
            first,
            least: least.map(|least| least * STEP),
        }))
    }

    /// Returns the position of an image of a given size; `None` once the atlas has the maximum height.
    fn place(
        &mut self,
        [width, height]: [u32; 2],
        budget: &mut Budget,
    ) -> Result<Option<[u32; 2]>, BrokenRule> {
        if self.next[0] + width > WIDTH {
            self.next = [0, self.next[1] + self.row];
            self.row = 0;
        }
        let rows = self.texels.len() as u32 / WIDTH;
        let needed = (self.next[1] + height).saturating_sub(rows);
        if rows + needed > Texture::MAX_TEXELS {
            return Ok(None);
        }
        if needed > 0 {
            budget.take(5 * u64::from(needed * WIDTH), || "its lightmaps".to_owned())?;
            self.texels.resize(((rows + needed) * WIDTH) as usize, 0);
        }
        self.row = self.row.max(height);
        let first = self.next;
        self.next[0] += width;
        Ok(Some(first))
    }

    /// Returns the atlas, and the divisors from samples to texture coordinates.
    pub(super) fn texture(self) -> Option<(Arc<Texture>, [f32; 2])> {
        let height = self.texels.len() as u32 / WIDTH;
        let texels = self
            .texels
            .into_iter()
            .map(|light| [light, light, light, 255])
            .collect();
        Some((
            texture("light", [WIDTH, height], texels)?,
            [WIDTH as f32, height as f32],
        ))
    }
}

impl FaceLightmap {
    /// Converts a texel position of the face to a sample position in the atlas.
    pub(super) fn at(&self, place: [f64; 2]) -> [f32; 2] {
        [0, 1].map(|axis| {
            let sample = (place[axis] - self.least[axis]) / STEP + 0.5;
            (f64::from(self.first[axis]) + sample) as f32
        })
    }
}

/// Returns the lightmap pages of a Quake 3 map.
pub(super) fn pages(map: &Map, budget: &mut Budget) -> Result<Vec<Arc<Texture>>, BrokenRule> {
    let pages = map.lump(LIGHT_OF_QUAKE_3).chunks_exact(BYTES_OF_A_PAGE);
    let read = |page: &[u8]| {
        budget.take(4 * u64::from(PAGE * PAGE), || "its lightmaps".to_owned())?;
        let texels = page
            .as_chunks::<3>()
            .0
            .iter()
            .map(|&light| twice(light))
            .collect();
        Ok(texture("light", [PAGE; 2], texels))
    };
    let pages: Result<Vec<_>, BrokenRule> = pages.map(read).collect();
    Ok(pages?.into_iter().flatten().collect())
}

/// Doubles a light sample, clamped without changing its hue.
fn twice(light: [u8; 3]) -> [u8; 4] {
    let doubled = light.map(|part| 2 * u32::from(part));
    let most = doubled.into_iter().fold(255, u32::max);
    let [red, green, blue] = doubled.map(|part| (part * 255 / most) as u8);
    [red, green, blue, 255]
}

/// Creates a lightmap texture; `None` if its size is invalid.
fn texture(name: &str, size: [u32; 2], texels: Vec<[u8; 4]>) -> Option<Arc<Texture>> {
    let mut texture = Texture::new(name, size, texels).ok()?;
    texture.wrap = [Wrap::Clamp; 2];
    // Mipmaps of an atlas would blend adjacent images.
    texture.minify = Minify {
        texels: Filter::Linear,
        levels: None,
    };
    Some(Arc::new(texture))
}

/// Returns the id of a lightmap; the pattern textures come first.
pub(super) fn number(page: usize) -> TextureId {
    TextureId((PATTERNS.len() + page) as u32)
}
