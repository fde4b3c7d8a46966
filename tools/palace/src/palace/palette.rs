//! Materials of the palace. Colors are linear; textures tint them.

use super::textures::*;
use crate::shape::Dress;
use enfilade::{Alpha, GeometryBuilder, Material, MaterialId, TextureId};
use std::sync::{Arc, LazyLock};

/// Creates an empty geometry with the palace's materials and textures, the same for all sectors.
pub(crate) fn geometry() -> GeometryBuilder {
    static MADE: LazyLock<Arc<[Material]>> = LazyLock::new(materials);
    let mut geometry = GeometryBuilder::new(Arc::clone(&MADE));
    geometry.textures(textures());
    geometry
}

fn materials() -> Arc<[Material]> {
    let table = TABLE.iter().map(|&(_, material, finish)| Material {
        texture: finish.texture(),
        // Stained glass glows in its texture's colors only.
        emission_texture: finish.texture().filter(|_| material.emission != [0.0; 3]),
        ..material
    });
    let paintings = (0..(BROAD + HIGH) as u32).map(|number| Material {
        texture: Some(TextureId(FIRST_PAINTING + number)),
        ..solid(1.0, 1.0, 1.0)
    });
    table.chain(paintings).collect()
}

/// Returns a painting by its index: wide ones first, then tall ones.
pub(crate) fn painted(number: usize) -> MaterialId {
    MaterialId((TABLE.len() + number) as u32)
}

/// Returns how the faces of a material are rendered.
pub(crate) fn dress(material: MaterialId) -> Dress {
    match TABLE.get(material.0 as usize) {
        Some(&(_, material, finish)) => finish.dress(material.double_sided),
        // A painting, with explicit texture coordinates.
        None => PLACED.dress(false),
    }
}

/// Texture of a material: texture, repetitions per metre, and whether it has a grain.
#[derive(Clone, Copy)]
struct Finish(Option<TextureId>, f32, bool);

/// One color.
const EVEN: Finish = Finish(None, 1.0, false);

/// Texture coordinates are fractions of the texture, not metres.
const PLACED: Finish = Finish(Some(TextureId(FIRST_PAINTING)), 1.0, false);

/// A texture with its repetitions per metre.
const fn with(texture: TextureId, per_metre: f32) -> Finish {
    Finish(Some(texture), per_metre, false)
}

/// As [`with`], with a grain along the longer side.
const fn grained(texture: TextureId, per_metre: f32) -> Finish {
    Finish(Some(texture), per_metre, true)
}

impl Finish {
    const fn texture(self) -> Option<TextureId> {
        self.0
    }

    fn dress(self, cloth: bool) -> Dress {
        match self {
            Finish(None, ..) => Dress::Smooth,
            Finish(Some(_), per_metre, grain) => Dress::Textured {
                per_metre,
                grain,
                cloth,
            },
        }
    }
}

const fn solid(r: f32, g: f32, b: f32) -> Material {
    Material::opaque([r, g, b])
}

/// Thin two-sided surfaces.
const fn sheet(r: f32, g: f32, b: f32) -> Material {
    Material {
        double_sided: true,
        ..solid(r, g, b)
    }
}

const fn cut_out(r: f32, g: f32, b: f32) -> Material {
    Material {
        alpha: Alpha::Mask,
        ..sheet(r, g, b)
    }
}

/// An alpha-tested material whose two sides are separate faces, so that both can be lit equally.
const fn one_sided(r: f32, g: f32, b: f32) -> Material {
    Material {
        double_sided: false,
        ..cut_out(r, g, b)
    }
}

const fn glass(r: f32, g: f32, b: f32, coverage: f32) -> Material {
    Material {
        base_color: [r, g, b, coverage],
        alpha: Alpha::Blend,
        ..sheet(r, g, b)
    }
}

/// An emissive material.
const fn glowing(material: Material, emission: [f32; 3]) -> Material {
    Material { emission, ..material }
}

/// Stained glass against daylight: dark without it.
const fn stained(own: f32) -> Material {
    glowing(solid(own, own, own), [1.1, 1.1, 1.1])
}

pub(crate) const PLASTER: MaterialId = MaterialId(0);
pub(crate) const IVORY: MaterialId = MaterialId(1);
pub(crate) const STONE: MaterialId = MaterialId(2);
pub(crate) const PALE_STONE: MaterialId = MaterialId(3);
pub(crate) const DARK_STONE: MaterialId = MaterialId(4);
pub(crate) const WHITE_MARBLE: MaterialId = MaterialId(5);
pub(crate) const BLACK_MARBLE: MaterialId = MaterialId(6);
pub(crate) const RED_MARBLE: MaterialId = MaterialId(7);
pub(crate) const GREEN_MARBLE: MaterialId = MaterialId(8);
pub(crate) const GOLD: MaterialId = MaterialId(9);
pub(crate) const OLD_GOLD: MaterialId = MaterialId(10);
pub(crate) const RED_SILK: MaterialId = MaterialId(11);
pub(crate) const DARK_RED: MaterialId = MaterialId(12);
pub(crate) const GREEN_SILK: MaterialId = MaterialId(13);
pub(crate) const PALE_GREEN: MaterialId = MaterialId(14);
pub(crate) const BLUE_SILK: MaterialId = MaterialId(15);
pub(crate) const PALE_BLUE: MaterialId = MaterialId(16);
pub(crate) const NIGHT_BLUE: MaterialId = MaterialId(17);
pub(crate) const YELLOW_SILK: MaterialId = MaterialId(18);
pub(crate) const ROSE: MaterialId = MaterialId(19);
pub(crate) const OAK: MaterialId = MaterialId(20);
pub(crate) const PALE_OAK: MaterialId = MaterialId(21);
pub(crate) const WALNUT: MaterialId = MaterialId(22);
pub(crate) const MAHOGANY: MaterialId = MaterialId(23);
pub(crate) const EBONY: MaterialId = MaterialId(24);
pub(crate) const BRONZE: MaterialId = MaterialId(25);
pub(crate) const VERDIGRIS: MaterialId = MaterialId(26);
pub(crate) const IRON: MaterialId = MaterialId(27);
pub(crate) const SILVER: MaterialId = MaterialId(28);
pub(crate) const WAX: MaterialId = MaterialId(29);
pub(crate) const YELLOW_VELVET: MaterialId = MaterialId(30);
pub(crate) const EMBER: MaterialId = MaterialId(31);
pub(crate) const PORCELAIN: MaterialId = MaterialId(32);
pub(crate) const COBALT: MaterialId = MaterialId(33);
pub(crate) const TERRACOTTA: MaterialId = MaterialId(34);
pub(crate) const PAPER: MaterialId = MaterialId(35);
pub(crate) const LAWN: MaterialId = MaterialId(36);
pub(crate) const HEDGE: MaterialId = MaterialId(37);
pub(crate) const GRAVEL: MaterialId = MaterialId(38);
pub(crate) const BARK: MaterialId = MaterialId(39);
pub(crate) const RED_VELVET: MaterialId = MaterialId(40);
pub(crate) const GREEN_VELVET: MaterialId = MaterialId(41);
pub(crate) const BLUE_VELVET: MaterialId = MaterialId(42);
pub(crate) const LEAF: MaterialId = MaterialId(43);
pub(crate) const PALE_LEAF: MaterialId = MaterialId(44);
pub(crate) const LACE: MaterialId = MaterialId(45);
pub(crate) const PANE: MaterialId = MaterialId(46);
pub(crate) const WATER: MaterialId = MaterialId(47);
pub(crate) const CRYSTAL: MaterialId = MaterialId(48);
pub(crate) const CANDLE_FLAME: MaterialId = MaterialId(49);
pub(crate) const GLOW: MaterialId = MaterialId(50);
pub(crate) const ASHLAR: MaterialId = MaterialId(51);
pub(crate) const PALE_ASHLAR: MaterialId = MaterialId(52);
pub(crate) const PLANKS: MaterialId = MaterialId(53);
pub(crate) const LEADED_GLASS: MaterialId = MaterialId(54);
pub(crate) const STAINED_GLASS: MaterialId = MaterialId(55);
pub(crate) const SKYLIGHT: MaterialId = MaterialId(56);
pub(crate) const RED_CURTAIN: MaterialId = MaterialId(57);
pub(crate) const GREEN_CURTAIN: MaterialId = MaterialId(58);
pub(crate) const BLUE_CURTAIN: MaterialId = MaterialId(59);
pub(crate) const RED_RUG: MaterialId = MaterialId(60);
pub(crate) const BLUE_RUG: MaterialId = MaterialId(61);
pub(crate) const GREEN_RUG: MaterialId = MaterialId(62);
pub(crate) const ROSE_RUG: MaterialId = MaterialId(63);
pub(crate) const YELLOW_RUG: MaterialId = MaterialId(64);
/// Trees of the woods: light leaves and dark ones.
pub(crate) const PALE_BOUGHS: MaterialId = MaterialId(65);
pub(crate) const DARK_BOUGHS: MaterialId = MaterialId(66);
pub(crate) const LONG_GRASS: MaterialId = MaterialId(67);
/// The ground of the garden, untextured, because terrain has no texture coordinates.
pub(crate) const MEADOW: MaterialId = MaterialId(68);
pub(crate) const SLATE: MaterialId = MaterialId(69);
pub(crate) const GREEN_PANELS: MaterialId = MaterialId(70);
pub(crate) const ROSE_PANELS: MaterialId = MaterialId(71);
pub(crate) const INLAID_MARBLE: MaterialId = MaterialId(72);
pub(crate) const PAINTED_SKY: MaterialId = MaterialId(73);
pub(crate) const POND: MaterialId = MaterialId(74);
/// The stripes of a lawn that were mown the other way.
pub(crate) const MOWN: MaterialId = MaterialId(75);
/// The masses of leaves behind the boughs: light and dark.
pub(crate) const PALE_LEAVES: MaterialId = MaterialId(76);
pub(crate) const DARK_LEAVES: MaterialId = MaterialId(77);

const TABLE: [(MaterialId, Material, Finish); 78] = [
    (PLASTER, solid(0.62, 0.56, 0.45), with(PLASTERED, 0.7)),
    (IVORY, solid(0.68, 0.63, 0.52), with(PLASTERED, 0.7)),
    (STONE, solid(0.55, 0.46, 0.34), with(CARVED, 1.0)),
    (PALE_STONE, solid(0.60, 0.52, 0.41), with(CARVED, 1.0)),
    (DARK_STONE, solid(0.30, 0.25, 0.19), with(CARVED, 1.0)),
    (WHITE_MARBLE, solid(0.72, 0.70, 0.66), with(WHITE_VEINED, 0.55)),
    (BLACK_MARBLE, solid(1.0, 1.0, 1.0), with(BLACK_VEINED, 0.6)),
    (RED_MARBLE, solid(1.0, 1.0, 1.0), with(RED_VEINED, 0.6)),
    (GREEN_MARBLE, solid(1.0, 1.0, 1.0), with(GREEN_VEINED, 0.6)),
    (GOLD, solid(0.80, 0.50, 0.12), with(GILDING, 2.0)),
    (OLD_GOLD, solid(0.56, 0.35, 0.09), with(GILDING, 2.0)),
    (RED_SILK, solid(0.52, 0.045, 0.05), with(DAMASK, 1.25)),
    (DARK_RED, solid(0.22, 0.02, 0.025), with(VELVET, 1.5)),
    (GREEN_SILK, solid(0.09, 0.28, 0.14), with(DAMASK, 1.25)),
    (PALE_GREEN, solid(0.44, 0.60, 0.42), with(DAMASK, 1.25)),
    (BLUE_SILK, solid(0.065, 0.17, 0.46), with(DAMASK, 1.25)),
    (PALE_BLUE, solid(0.46, 0.62, 0.78), with(DAMASK, 1.25)),
    (NIGHT_BLUE, solid(0.015, 0.03, 0.11), with(VELVET, 1.5)),
    (YELLOW_SILK, solid(0.88, 0.60, 0.18), with(DAMASK, 1.25)),
    (ROSE, solid(0.76, 0.43, 0.38), with(DAMASK, 1.25)),
    (OAK, solid(0.40, 0.22, 0.095), grained(WOOD, 1.4)),
    (PALE_OAK, solid(0.56, 0.35, 0.16), grained(WOOD, 1.4)),
    (WALNUT, solid(0.19, 0.092, 0.042), grained(WOOD, 1.4)),
    (MAHOGANY, solid(0.28, 0.072, 0.034), grained(WOOD, 1.4)),
    (EBONY, solid(0.025, 0.02, 0.018), grained(WOOD, 1.4)),
    (BRONZE, solid(1.0, 1.0, 1.0), with(CAST_BRONZE, 1.0)),
    (VERDIGRIS, solid(0.16, 0.36, 0.29), with(CARVED, 1.0)),
    (IRON, solid(0.09, 0.09, 0.10), EVEN),
    (SILVER, solid(0.62, 0.63, 0.66), EVEN),
    (WAX, solid(0.88, 0.83, 0.66), EVEN),
    (YELLOW_VELVET, sheet(0.85, 0.60, 0.18), with(VELVET, 1.5)),
    (EMBER, solid(0.95, 0.22, 0.03), EVEN),
    (PORCELAIN, solid(0.86, 0.88, 0.90), with(PLASTERED, 1.0)),
    (COBALT, solid(0.03, 0.08, 0.42), with(CARVED, 0.7)),
    (TERRACOTTA, solid(0.50, 0.19, 0.08), with(CARVED, 1.3)),
    (PAPER, solid(0.80, 0.73, 0.55), EVEN),
    (LAWN, solid(0.125, 0.25, 0.05), with(GRASS, 0.9)),
    (HEDGE, solid(0.07, 0.24, 0.055), with(YEW, 2.4)),
    (GRAVEL, solid(0.56, 0.47, 0.35), with(PEBBLES, 1.6)),
    (BARK, solid(0.13, 0.085, 0.05), with(BARKED, 2.0)),
    (RED_VELVET, sheet(0.36, 0.02, 0.03), with(VELVET, 1.5)),
    (GREEN_VELVET, sheet(0.03, 0.14, 0.06), with(VELVET, 1.5)),
    (BLUE_VELVET, sheet(0.02, 0.06, 0.24), with(VELVET, 1.5)),
    (LEAF, cut_out(0.10, 0.32, 0.06), with(LEAFLET, 1.0)),
    (PALE_LEAF, cut_out(0.28, 0.48, 0.12), with(LEAFLET, 1.0)),
    (LACE, cut_out(0.84, 0.82, 0.76), with(LACEWORK, 3.0)),
    (PANE, glass(0.75, 0.88, 0.92, 0.12), EVEN),
    (WATER, glass(0.08, 0.28, 0.34, 0.6), EVEN),
    (CRYSTAL, glass(0.92, 0.95, 1.0, 0.35), EVEN),
    (
        CANDLE_FLAME,
        glowing(sheet(1.0, 0.78, 0.25), [1.0, 0.72, 0.30]),
        EVEN,
    ),
    (GLOW, glowing(solid(0.95, 0.22, 0.03), [0.9, 0.16, 0.02]), EVEN),
    (ASHLAR, solid(0.54, 0.45, 0.34), with(MASONRY, 0.66)),
    (PALE_ASHLAR, solid(0.64, 0.57, 0.46), with(MASONRY, 0.66)),
    (PLANKS, solid(0.36, 0.20, 0.09), grained(BOARDS, 0.9)),
    (LEADED_GLASS, glass(1.0, 1.0, 1.0, 1.0), with(LEADED, 1.6)),
    (STAINED_GLASS, stained(0.05), with(STAINED, 0.8)),
    (
        SKYLIGHT,
        glowing(solid(0.30, 0.36, 0.42), [0.34, 0.42, 0.52]),
        EVEN,
    ),
    (RED_CURTAIN, cut_out(1.0, 1.0, 1.0), with(CURTAINS[0], 1.0)),
    (GREEN_CURTAIN, cut_out(1.0, 1.0, 1.0), with(CURTAINS[1], 1.0)),
    (BLUE_CURTAIN, cut_out(1.0, 1.0, 1.0), with(CURTAINS[2], 1.0)),
    (RED_RUG, cut_out(1.0, 1.0, 1.0), with(RUGS[0], 1.0)),
    (BLUE_RUG, cut_out(1.0, 1.0, 1.0), with(RUGS[1], 1.0)),
    (GREEN_RUG, cut_out(1.0, 1.0, 1.0), with(RUGS[2], 1.0)),
    (ROSE_RUG, cut_out(1.0, 1.0, 1.0), with(RUGS[3], 1.0)),
    (YELLOW_RUG, cut_out(1.0, 1.0, 1.0), with(RUGS[4], 1.0)),
    (PALE_BOUGHS, one_sided(0.27, 0.44, 0.10), with(BOUGH, 1.0)),
    (DARK_BOUGHS, one_sided(0.11, 0.28, 0.10), with(BOUGH, 1.0)),
    (LONG_GRASS, cut_out(0.34, 0.46, 0.12), with(GRASS_TUFT, 1.0)),
    (MEADOW, solid(0.15, 0.27, 0.05), EVEN),
    (SLATE, solid(0.15, 0.165, 0.20), with(MASONRY, 1.6)),
    (GREEN_PANELS, solid(1.0, 1.0, 1.0), with(PANELLED[0], 1.0)),
    (ROSE_PANELS, solid(1.0, 1.0, 1.0), with(PANELLED[1], 1.0)),
    (INLAID_MARBLE, solid(1.0, 1.0, 1.0), with(INLAID, 0.8)),
    (PAINTED_SKY, solid(1.0, 1.0, 1.0), with(PAINTED_CLOUDS, 0.22)),
    (POND, glass(0.10, 0.20, 0.24, 0.82), EVEN),
    (MOWN, solid(0.20, 0.34, 0.07), with(GRASS, 0.9)),
    (PALE_LEAVES, solid(0.23, 0.38, 0.085), with(FOLIAGE, 1.0)),
    (DARK_LEAVES, solid(0.095, 0.24, 0.085), with(FOLIAGE, 1.0)),
];

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_material_stands_at_its_number() {
        for (place, (id, ..)) in TABLE.iter().enumerate() {
            assert_eq!(id.0 as usize, place);
        }
    }
}
