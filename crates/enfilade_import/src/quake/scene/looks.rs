//! The appearance of faces: a muted color derived from the texture name, and a pattern that shows scale and
//! orientation.
//!
//! Maps reference images of their game, or store them without the palette. So colors are made up, identical for a name
//! in every map: from a word in the name that indicates a material, otherwise from a hash of the name.

use super::light::FULL;
use super::pattern::{PATTERNS, Pattern};
use crate::budget::Budget;
use crate::{BrokenRule, NonOccluder};
use enfilade::{Alpha, Material, MaterialId, Texture, TextureId};
use std::collections::HashMap;
use std::sync::Arc;

/// Kind of a face, as far as it affects appearance and occlusion.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub(in crate::quake) enum Kind {
    Wall,
    /// A wall with holes: its texture has a transparent color.
    Fence,
    Glass,
    Water,
    Slime,
    Lava,
    /// A teleporter surface.
    Gate,
    /// The sky; it bounds the world, so it occludes like a wall.
    Sky,
}

impl Kind {
    /// Returns why such faces hide nothing, whatever the flags of their texture.
    pub(super) fn non_occluder(self) -> Option<NonOccluder> {
        match self {
            Kind::Wall | Kind::Sky => None,
            Kind::Fence => Some(NonOccluder::AlphaKey),
            Kind::Glass => Some(NonOccluder::Blended),
            Kind::Water | Kind::Slime | Kind::Lava | Kind::Gate => Some(NonOccluder::Liquid),
        }
    }
}

/// The materials of a map.
#[derive(Debug, Default)]
pub(super) struct Looks {
    pub(super) materials: Vec<Material>,
    /// Why each hides nothing, if it does not.
    pub(super) non_occluders: Vec<Option<NonOccluder>>,
    known: HashMap<(u32, Kind, Option<TextureId>, Option<NonOccluder>), MaterialId>,
    with_patterns: bool,
    /// Lightmaps; their ids follow those of the patterns.
    pub(super) light: Vec<Arc<Texture>>,
}

/// Words in texture names, with their linear color and pattern.
const WORDS: [(&str, [f32; 3], Pattern); 22] = [
    ("brick", [0.27, 0.13, 0.085], Pattern::Bricks),
    ("brk", [0.27, 0.13, 0.085], Pattern::Bricks),
    ("wood", [0.22, 0.125, 0.06], Pattern::Planks),
    ("wall", [0.25, 0.21, 0.165], Pattern::Bricks),
    ("cement", [0.27, 0.265, 0.25], Pattern::Plates),
    ("crete", [0.27, 0.265, 0.25], Pattern::Plates),
    ("stone", [0.23, 0.21, 0.18], Pattern::Bricks),
    ("rock", [0.21, 0.18, 0.15], Pattern::Rough),
    ("floor", [0.19, 0.165, 0.135], Pattern::Plates),
    ("flr", [0.19, 0.165, 0.135], Pattern::Plates),
    ("grass", [0.10, 0.17, 0.05], Pattern::Rough),
    ("ground", [0.20, 0.15, 0.09], Pattern::Rough),
    ("dirt", [0.20, 0.15, 0.09], Pattern::Rough),
    ("sand", [0.37, 0.30, 0.19], Pattern::Rough),
    ("rust", [0.24, 0.11, 0.05], Pattern::Plates),
    ("trim", [0.14, 0.125, 0.115], Pattern::Plates),
    ("ceil", [0.17, 0.16, 0.15], Pattern::Plates),
    ("door", [0.28, 0.19, 0.10], Pattern::Planks),
    ("plat", [0.24, 0.22, 0.13], Pattern::Plates),
    ("met", [0.19, 0.205, 0.23], Pattern::Plates),
    ("mtl", [0.19, 0.205, 0.23], Pattern::Plates),
    ("tech", [0.15, 0.19, 0.21], Pattern::Plates),
];
const GLASS: [f32; 4] = [0.45, 0.6, 0.62, 0.35];
const WATER: [f32; 3] = [0.05, 0.12, 0.19];
const SLIME: [f32; 3] = [0.09, 0.17, 0.03];
const LAVA: [f32; 3] = [0.75, 0.17, 0.02];
const GATE: [f32; 3] = [0.10, 0.05, 0.19];
const SKY: [f32; 3] = [0.28, 0.37, 0.50];

impl Looks {
    pub(super) fn new(with_patterns: bool) -> Looks {
        Looks {
            with_patterns,
            ..Looks::default()
        }
    }

    /// Returns `true` if textures, including lightmaps, are wanted.
    pub(super) fn has_images(&self) -> bool {
        self.with_patterns
    }

    /// Returns the textures of the materials: patterns, then lightmaps.
    pub(super) fn textures(&self, budget: &mut Budget) -> Result<Vec<Arc<Texture>>, BrokenRule> {
        if !self.with_patterns {
            return Ok(Vec::new());
        }
        let texture = |pattern: &Pattern| {
            let (name, size, texels) = pattern.image();
            budget.take(4 * texels.len() as u64, || format!("pattern {name}"))?;
            Ok(Arc::new(
                Texture::new(name, [size; 2], texels).expect("the texel count matches the size"),
            ))
        };
        let patterns = PATTERNS.iter().map(texture);
        patterns.chain(self.light.iter().cloned().map(Ok)).collect()
    }

    /// Returns the material of a texture, given its index in the map and its name, which is empty if the map stores
    /// none. With `light`, the lightmap replaces the pattern, and the material is unlit. It hides nothing if there is a reason.
    pub(super) fn material(
        &mut self,
        texture: u32,
        name: &str,
        kind: Kind,
        double_sided: bool,
        non_occluder: Option<NonOccluder>,
        light: Option<TextureId>,
    ) -> MaterialId {
        let next = MaterialId(self.materials.len() as u32);
        let key = (texture, kind, light, non_occluder);
        let id = *self.known.entry(key).or_insert(next);
        if id == next {
            let (material, pattern) = match kind {
                Kind::Wall | Kind::Fence => wall(texture, name),
                Kind::Glass => (glass(), None),
                Kind::Water => (Material::opaque(WATER), Some(Pattern::Rough)),
                Kind::Slime => (Material::opaque(SLIME), Some(Pattern::Rough)),
                Kind::Lava => (bright(LAVA), Some(Pattern::Rough)),
                Kind::Gate => (bright(GATE), Some(Pattern::Rough)),
                Kind::Sky => (bright(SKY), None),
            };
            let pattern = pattern.filter(|_| self.with_patterns);
            let material = match light {
                Some(_) => bright([0, 1, 2].map(|part| (FULL * material.base_color[part]).min(1.0))),
                None => material,
            };
            self.non_occluders.push(non_occluder);
            self.materials.push(Material {
                alpha: if non_occluder.is_none() || material.alpha == Alpha::Blend {
                    material.alpha
                } else {
                    Alpha::Mask
                },
                texture: light.or(pattern.map(|pattern| TextureId(pattern as u32))),
                double_sided,
                ..material
            });
        }
        id
    }
}

fn glass() -> Material {
    Material {
        base_color: GLASS,
        alpha: Alpha::Blend,
        ..Material::opaque([0.0; 3])
    }
}

/// Returns an unlit material.
fn bright(color: [f32; 3]) -> Material {
    Material {
        unlit: true,
        ..Material::opaque(color)
    }
}

fn wall(texture: u32, name: &str) -> (Material, Option<Pattern>) {
    let name = name.to_ascii_lowercase();
    // The end of a path is the most specific.
    let end = name.rsplit('/').next().unwrap_or(&name);
    let number = match &*name {
        "" => spread(u64::from(texture) + 1),
        name => name
            .bytes()
            .fold(0, |sum, byte| spread(sum ^ (u64::from(byte) + 1))),
    };
    // Values from 0 to 1, each from different bits.
    let share = |place: u32| (number >> (place * 12) & 0xfff) as f32 / 4096.0;
    let word = [end, &name]
        .into_iter()
        .find_map(|text| WORDS.iter().find(|word| text.contains(word.0)));
    let (color, pattern) = match word {
        Some(&(_, color, pattern)) => {
            let tone = 0.75 + 0.5 * share(0);
            let tint = |at: usize| 0.88 + 0.24 * share(at as u32 + 1);
            ([0, 1, 2].map(|at| color[at] * tone * tint(at)), pattern)
        }
        None => {
            let pattern = PATTERNS[(number >> 60) as usize % PATTERNS.len()];
            (muted(share(0), share(1), share(2)), pattern)
        }
    };
    let shines = ["light", "lamp", "lite"].iter().any(|word| end.contains(word));
    let emission = if shines { [0.5, 0.46, 0.34] } else { [0.0; 3] };
    let material = Material {
        emission,
        ..Material::opaque(color)
    };
    (material, Some(pattern))
}

/// Returns a muted color between two tones of stone, wood or metal. All arguments are from 0 to 1.
fn muted(which: f32, between: f32, tone: f32) -> [f32; 3] {
    const EARTHS: [[f32; 3]; 8] = [
        [0.26, 0.22, 0.17],
        [0.24, 0.14, 0.08],
        [0.20, 0.21, 0.23],
        [0.17, 0.18, 0.11],
        [0.31, 0.26, 0.18],
        [0.14, 0.17, 0.20],
        [0.27, 0.16, 0.12],
        [0.16, 0.14, 0.13],
    ];
    let first = (which * EARTHS.len() as f32) as usize % EARTHS.len();
    let second = (first + 1) % EARTHS.len();
    let tone = 0.8 + 0.5 * tone;
    [0, 1, 2].map(|part| tone * (EARTHS[first][part] * (1.0 - between) + EARTHS[second][part] * between))
}

/// Hashes a number; every output bit depends on all input bits.
fn spread(number: u64) -> u64 {
    let mut mixed = number.wrapping_mul(0x9e37_79b9_7f4a_7c15);
    mixed = (mixed ^ mixed >> 30).wrapping_mul(0xbf58_476d_1ce4_e5b9);
    mixed = (mixed ^ mixed >> 27).wrapping_mul(0x94d0_49bb_1331_11eb);
    mixed ^ mixed >> 31
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn one_name_has_one_color_in_each_map_and_others_have_others() {
        let mut looks = Looks::new(true);
        let mut color = |texture, name| {
            let id = looks.material(texture, name, Kind::Wall, false, None, None);
            looks.materials[id.0 as usize].base_color
        };
        assert_eq!(color(0, "textures/a/metal_1"), color(7, "textures/a/metal_1"));
        assert_ne!(color(1, "textures/a/metal_2"), color(7, "textures/a/metal_1"));
        assert_ne!(color(2, ""), color(3, ""));
        assert_eq!(looks.materials.len(), 5);
        let muted = |material: &Material| material.base_color[..3].iter().all(|&part| part < 0.5);
        assert!(looks.materials.iter().all(muted));
    }

    #[test]
    fn without_images_the_colors_are_the_same() {
        let of = |with_patterns| {
            let mut looks = Looks::new(with_patterns);
            looks.material(0, "floor2_1", Kind::Wall, true, None, None);
            looks.materials[0]
        };
        assert!(of(true).texture.is_some());
        assert_eq!(
            of(false),
            Material {
                texture: None,
                ..of(true)
            }
        );
    }
}
