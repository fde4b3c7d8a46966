//! What the palace is made of. Colors are linear.

use enfilade::{Alpha, Material, MaterialId};
use std::sync::Arc;

/// The table that all fragments of the palace share.
pub(crate) fn materials() -> Arc<[Material]> {
    TABLE.iter().map(|&(_, material)| material).collect()
}

const fn solid(r: f32, g: f32, b: f32) -> Material {
    Material::opaque([r, g, b])
}

/// Thin things that are seen from both sides.
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

const fn glass(r: f32, g: f32, b: f32, coverage: f32) -> Material {
    Material {
        base_color: [r, g, b, coverage],
        alpha: Alpha::Blend,
        ..sheet(r, g, b)
    }
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
pub(crate) const FLAME: MaterialId = MaterialId(30);
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

const TABLE: [(MaterialId, Material); 49] = [
    (PLASTER, solid(0.74, 0.68, 0.57)),
    (IVORY, solid(0.83, 0.79, 0.68)),
    (STONE, solid(0.55, 0.46, 0.34)),
    (PALE_STONE, solid(0.68, 0.60, 0.48)),
    (DARK_STONE, solid(0.30, 0.25, 0.19)),
    (WHITE_MARBLE, solid(0.80, 0.78, 0.74)),
    (BLACK_MARBLE, solid(0.045, 0.045, 0.055)),
    (RED_MARBLE, solid(0.36, 0.11, 0.07)),
    (GREEN_MARBLE, solid(0.06, 0.18, 0.12)),
    (GOLD, solid(0.83, 0.54, 0.13)),
    (OLD_GOLD, solid(0.50, 0.30, 0.07)),
    (RED_SILK, solid(0.42, 0.035, 0.04)),
    (DARK_RED, solid(0.22, 0.02, 0.025)),
    (GREEN_SILK, solid(0.07, 0.22, 0.11)),
    (PALE_GREEN, solid(0.36, 0.50, 0.34)),
    (BLUE_SILK, solid(0.05, 0.13, 0.36)),
    (PALE_BLUE, solid(0.38, 0.52, 0.66)),
    (NIGHT_BLUE, solid(0.015, 0.03, 0.11)),
    (YELLOW_SILK, solid(0.74, 0.50, 0.14)),
    (ROSE, solid(0.66, 0.36, 0.32)),
    (OAK, solid(0.33, 0.18, 0.075)),
    (PALE_OAK, solid(0.47, 0.29, 0.13)),
    (WALNUT, solid(0.15, 0.07, 0.03)),
    (MAHOGANY, solid(0.22, 0.055, 0.025)),
    (EBONY, solid(0.025, 0.02, 0.018)),
    (BRONZE, solid(0.24, 0.14, 0.055)),
    (VERDIGRIS, solid(0.16, 0.36, 0.29)),
    (IRON, solid(0.09, 0.09, 0.10)),
    (SILVER, solid(0.62, 0.63, 0.66)),
    (WAX, solid(0.88, 0.83, 0.66)),
    (FLAME, sheet(1.0, 0.78, 0.25)),
    (EMBER, solid(0.95, 0.22, 0.03)),
    (PORCELAIN, solid(0.86, 0.88, 0.90)),
    (COBALT, solid(0.03, 0.08, 0.42)),
    (TERRACOTTA, solid(0.50, 0.19, 0.08)),
    (PAPER, solid(0.80, 0.73, 0.55)),
    (LAWN, solid(0.12, 0.30, 0.05)),
    (HEDGE, solid(0.035, 0.13, 0.03)),
    (GRAVEL, solid(0.60, 0.50, 0.36)),
    (BARK, solid(0.13, 0.085, 0.05)),
    (RED_VELVET, sheet(0.36, 0.02, 0.03)),
    (GREEN_VELVET, sheet(0.03, 0.14, 0.06)),
    (BLUE_VELVET, sheet(0.02, 0.06, 0.24)),
    (LEAF, cut_out(0.07, 0.24, 0.04)),
    (PALE_LEAF, cut_out(0.22, 0.38, 0.09)),
    (LACE, cut_out(0.84, 0.82, 0.76)),
    (PANE, glass(0.75, 0.88, 0.92, 0.12)),
    (WATER, glass(0.08, 0.28, 0.34, 0.6)),
    (CRYSTAL, glass(0.92, 0.95, 1.0, 0.35)),
];

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_material_stands_at_its_number() {
        for (place, (id, _)) in TABLE.iter().enumerate() {
            assert_eq!(id.0 as usize, place);
        }
    }
}
