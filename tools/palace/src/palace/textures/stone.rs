//! Repeating textures: marble, masonry, plaster, gravel.

use super::noise::{bent, clouds, random_unit, step, veins};
use super::sheet::tile;
use enfilade::Texture;
use glam::{Vec2, Vec3, vec2};
use std::sync::Arc;

/// Marble: ground clouded from one color to another, and two kinds of veins.
pub(super) fn marble(name: &str, seed: u32, ground: [Vec3; 2], vein: [Vec3; 2]) -> Arc<Texture> {
    tile(name, 256, |at| {
        let cloud = step(-0.7, 0.7, clouds(at, [3, 3], 4, seed));
        let veined = bent(at, seed + 20);
        let broad = veins(veined, [2, 3], 5.0, seed + 40) * step(-0.5, 0.4, clouds(at, [2, 2], 2, seed + 50));
        let fine = veins(veined, [5, 4], 11.0, seed + 60) * step(-0.2, 0.6, clouds(at, [3, 3], 2, seed + 70));
        ground[0]
            .lerp(ground[1], cloud)
            .lerp(vein[0], 0.75 * broad)
            .lerp(vein[1], 0.8 * fine)
    })
}

/// Hewn blocks, two metres of them: four courses, each shifted by half a block, with joints between.
pub(super) fn ashlar() -> Arc<Texture> {
    tile("ashlar", 512, |at| {
        let course = (at.y * 4.0).floor();
        let shifted = vec2(at.x * 2.0 + 0.5 * (course % 2.0), at.y * 4.0);
        let block = [(shifted.x.floor() as i32).rem_euclid(2), course as i32];
        let inside = shifted - shifted.floor();
        // In metres from the nearest joint.
        let [across, down] = [inside.x.min(1.0 - inside.x), 0.5 * inside.y.min(1.0 - inside.y)];
        let joint = step(0.004, 0.016, across.min(down));
        let lit =
            1.0 + 0.10 * step(0.05, 0.0, 0.5 * inside.y) - 0.12 * step(0.05, 0.0, 0.5 * (1.0 - inside.y));
        let tone = 0.80 + 0.14 * random_unit(block, 3);
        let warm = random_unit(block, 4) - 0.5;
        let rough = 1.0 + 0.10 * clouds(at, [16, 16], 3, 5) + 0.05 * clouds(at, [4, 4], 2, 6);
        let color = Vec3::new(1.0 + 0.03 * warm, 1.0, 1.0 - 0.06 * warm) * tone * rough * lit;
        color * (0.58 + 0.42 * joint)
    })
}

/// Stone as it is carved: speckled and a little stained.
pub(super) fn grain() -> Arc<Texture> {
    tile("stone grain", 128, |at| {
        let stain = clouds(at, [3, 3], 3, 11);
        let speck = clouds(at, [24, 24], 2, 12);
        let pit = step(0.55, 0.9, clouds(at, [18, 18], 1, 13));
        Vec3::new(1.0, 0.985, 0.96) * (0.90 + 0.07 * stain + 0.06 * speck - 0.16 * pit)
    })
}

/// Painted plaster: nearly uniform.
pub(super) fn plaster() -> Arc<Texture> {
    tile("plaster", 128, |at| {
        let value = 0.955 + 0.03 * clouds(at, [3, 3], 3, 21) + 0.02 * clouds(at, [20, 12], 2, 22);
        Vec3::new(1.0, 0.995, 0.985) * value
    })
}

/// Small round stones in various grays.
pub(super) fn gravel() -> Arc<Texture> {
    const CELLS: i32 = 18;
    tile("gravel", 128, |at| {
        let scaled = at * CELLS as f32;
        let floor = scaled.floor();
        let mut nearest = (f32::MAX, [0, 0]);
        for dy in -1..=1 {
            for dx in -1..=1 {
                let cell = [floor.x as i32 + dx, floor.y as i32 + dy];
                let id = cell.map(|c| c.rem_euclid(CELLS));
                let stone = Vec2::from([cell[0] as f32, cell[1] as f32])
                    + vec2(random_unit(id, 31), random_unit(id, 32)) * 0.7
                    + 0.15;
                let away = stone.distance(scaled);
                if away < nearest.0 {
                    nearest = (away, id);
                }
            }
        }
        let (away, id) = nearest;
        let tone = 0.72 + 0.28 * random_unit(id, 33);
        let warm = 0.08 * (random_unit(id, 34) - 0.5);
        Vec3::new(1.0 + warm, 1.0, 1.0 - warm) * tone * (1.0 - 0.45 * step(0.35, 0.75, away))
    })
}

/// Beaten and polished metal: brightness varies with its dents.
pub(super) fn gilt() -> Arc<Texture> {
    tile("gilt", 128, |at| {
        let worn = step(0.35, 0.95, clouds(at, [7, 7], 3, 41));
        let shine = clouds(at, [4, 5], 2, 42);
        Vec3::new(1.0, 0.98, 0.92) * (0.86 + 0.14 * shine) - Vec3::new(0.10, 0.16, 0.12) * worn
    })
}

/// Cast bronze: dark where it was touched least, with green patina that ran down it.
pub(super) fn bronze() -> Arc<Texture> {
    tile("bronze", 128, |at| {
        let rubbed = step(-0.5, 0.6, clouds(at, [4, 4], 4, 46));
        let run = step(0.05, 0.75, clouds(bent(at, 47), [13, 5], 3, 48));
        let speck = 1.0 + 0.10 * clouds(at, [20, 20], 2, 49);
        let metal = Vec3::new(0.15, 0.088, 0.042).lerp(Vec3::new(0.36, 0.225, 0.105), rubbed);
        metal.lerp(Vec3::new(0.155, 0.25, 0.185), 0.42 * run) * speck
    })
}
