//! Procedural textures of the palace, generated once per process.

mod cloth;
mod glass;
mod joinery;
mod noise;
mod pictures;
mod plants;
mod rug;
mod sheet;
mod stone;
mod wood;

pub(crate) use pictures::{ASPECT, BROAD, HIGH};
pub(crate) use rug::BORDER;

use enfilade::{Texture, TextureId};
use glam::{Vec3, vec3};
use std::sync::atomic::{AtomicUsize, Ordering};
use std::sync::{Arc, LazyLock, OnceLock};

pub(crate) const WHITE_VEINED: TextureId = TextureId(0);
pub(crate) const BLACK_VEINED: TextureId = TextureId(1);
pub(crate) const RED_VEINED: TextureId = TextureId(2);
pub(crate) const GREEN_VEINED: TextureId = TextureId(3);
pub(crate) const MASONRY: TextureId = TextureId(4);
pub(crate) const CARVED: TextureId = TextureId(5);
pub(crate) const PLASTERED: TextureId = TextureId(6);
pub(crate) const PEBBLES: TextureId = TextureId(7);
pub(crate) const GILDING: TextureId = TextureId(8);
pub(crate) const WOOD: TextureId = TextureId(9);
pub(crate) const BOARDS: TextureId = TextureId(10);
pub(crate) const BARKED: TextureId = TextureId(11);
pub(crate) const DAMASK: TextureId = TextureId(12);
pub(crate) const VELVET: TextureId = TextureId(13);
pub(crate) const LACEWORK: TextureId = TextureId(14);
pub(crate) const LEAFLET: TextureId = TextureId(15);
pub(crate) const YEW: TextureId = TextureId(16);
pub(crate) const GRASS: TextureId = TextureId(17);
pub(crate) const LEADED: TextureId = TextureId(18);
pub(crate) const STAINED: TextureId = TextureId(19);
/// Curtains: red, green, blue.
pub(crate) const CURTAINS: [TextureId; 3] = [TextureId(20), TextureId(21), TextureId(22)];
/// Rugs: red, blue, green, rose, yellow.
pub(crate) const RUGS: [TextureId; 5] = [
    TextureId(23),
    TextureId(24),
    TextureId(25),
    TextureId(26),
    TextureId(27),
];
/// A bough full of leaves, and a tuft of long grass.
pub(crate) const BOUGH: TextureId = TextureId(28);
pub(crate) const GRASS_TUFT: TextureId = TextureId(29);
/// Panelled walls, one panel broad and as high as the wall: green and rose.
pub(crate) const PANELLED: [TextureId; 2] = [TextureId(30), TextureId(31)];
pub(crate) const INLAID: TextureId = TextureId(32);
pub(crate) const PAINTED_CLOUDS: TextureId = TextureId(33);
pub(crate) const CAST_BRONZE: TextureId = TextureId(34);
pub(crate) const FOLIAGE: TextureId = TextureId(35);
/// The first painting; the others follow, wide ones before tall ones.
pub(crate) const FIRST_PAINTING: u32 = 36;

/// Number of textures.
const COUNT: usize = FIRST_PAINTING as usize + BROAD + HIGH;

/// Returns all textures by index, which every geometry of the palace contains.
pub(crate) fn textures() -> Arc<[Arc<Texture>]> {
    static ALL: LazyLock<Arc<[Arc<Texture>]>> = LazyLock::new(|| all().into());
    Arc::clone(&ALL)
}

/// Generates all textures on all cores.
fn all() -> Vec<Arc<Texture>> {
    let made: [OnceLock<Arc<Texture>>; COUNT] = std::array::from_fn(|_| OnceLock::new());
    let next = AtomicUsize::new(0);
    let work = || {
        loop {
            let number = next.fetch_add(1, Ordering::Relaxed);
            let Some(place) = made.get(number) else { return };
            place.get_or_init(|| texture(number as u32));
        }
    };
    let threads = std::thread::available_parallelism().map_or(1, usize::from).min(8);
    std::thread::scope(|scope| {
        for _ in 1..threads {
            scope.spawn(work);
        }
        work();
    });
    made.into_iter().filter_map(OnceLock::into_inner).collect()
}

/// Generates the texture with an index.
fn texture(number: u32) -> Arc<Texture> {
    let gray = Vec3::splat;
    let [red, blue, green] = [
        vec3(0.36, 0.03, 0.03),
        vec3(0.02, 0.04, 0.16),
        vec3(0.04, 0.16, 0.09),
    ];
    let [gold, ivory] = [vec3(0.66, 0.46, 0.15), vec3(0.70, 0.62, 0.46)];
    match TextureId(number) {
        WHITE_VEINED => stone::marble(
            "white marble",
            1,
            [gray(0.86), gray(0.98)],
            [vec3(0.52, 0.52, 0.55), vec3(0.62, 0.56, 0.46)],
        ),
        BLACK_VEINED => stone::marble(
            "black marble",
            2,
            [gray(0.018), gray(0.05)],
            [vec3(0.42, 0.40, 0.37), vec3(0.50, 0.38, 0.16)],
        ),
        RED_VEINED => stone::marble(
            "red marble",
            3,
            [vec3(0.15, 0.035, 0.025), vec3(0.30, 0.095, 0.06)],
            [vec3(0.52, 0.36, 0.28), vec3(0.06, 0.015, 0.012)],
        ),
        GREEN_VEINED => stone::marble(
            "green marble",
            4,
            [vec3(0.025, 0.10, 0.06), vec3(0.08, 0.22, 0.14)],
            [vec3(0.36, 0.50, 0.38), vec3(0.01, 0.04, 0.03)],
        ),
        MASONRY => stone::ashlar(),
        CARVED => stone::grain(),
        PLASTERED => stone::plaster(),
        PEBBLES => stone::gravel(),
        GILDING => stone::gilt(),
        WOOD => wood::grain(),
        BOARDS => wood::boards(),
        BARKED => wood::bark(),
        DAMASK => cloth::damask(),
        VELVET => cloth::velvet(),
        LACEWORK => cloth::lace(),
        LEAFLET => plants::leaf(),
        YEW => plants::hedge(),
        GRASS => plants::lawn(),
        LEADED => glass::leaded(),
        STAINED => glass::stained(),
        id if id == CURTAINS[0] => cloth::curtain("red curtain", vec3(0.38, 0.025, 0.03)),
        id if id == CURTAINS[1] => cloth::curtain("green curtain", vec3(0.035, 0.16, 0.07)),
        id if id == CURTAINS[2] => cloth::curtain("blue curtain", vec3(0.03, 0.08, 0.28)),
        id if id == RUGS[0] => rug::rug("red rug", [red, blue, gold], 701),
        id if id == RUGS[1] => rug::rug("blue rug", [blue * 1.6, red * 0.6, gold], 702),
        id if id == RUGS[2] => rug::rug("green rug", [green, red * 0.7, gold], 703),
        id if id == RUGS[3] => rug::rug("rose rug", [vec3(0.58, 0.28, 0.24), red * 0.8, ivory], 704),
        id if id == RUGS[4] => rug::rug("yellow rug", [vec3(0.58, 0.38, 0.12), red * 0.6, ivory], 705),
        BOUGH => plants::bough(),
        GRASS_TUFT => plants::tuft(),
        id if id == PANELLED[0] => joinery::panelled_wall("green panels", vec3(0.30, 0.46, 0.32), 500),
        id if id == PANELLED[1] => joinery::panelled_wall("rose panels", vec3(0.60, 0.31, 0.26), 505),
        CAST_BRONZE => stone::bronze(),
        FOLIAGE => plants::foliage(),
        INLAID => joinery::inlaid_floor(),
        PAINTED_CLOUDS => joinery::painted_sky(),
        TextureId(number) => pictures::painting((number - FIRST_PAINTING) as usize),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use enfilade::Wrap;

    /// Returns the mean difference between neighbouring texels, in bytes: inside, and across the repeat.
    fn steps(texture: &Texture, axis: usize) -> [f32; 2] {
        let [wide, high] = texture.size().map(|side| side as usize);
        let texel = |x: usize, y: usize| texture.texels()[(y % high) * wide + x % wide].map(f32::from);
        let step = |x: usize, y: usize| {
            let [a, b] = [
                texel(x, y),
                if axis == 0 {
                    texel(x + 1, y)
                } else {
                    texel(x, y + 1)
                },
            ];
            (0..4).map(|i| (a[i] - b[i]).abs()).sum::<f32>() / 4.0
        };
        let [along, across] = if axis == 0 { [wide, high] } else { [high, wide] };
        let at = |i: usize, j: usize| if axis == 0 { step(i, j) } else { step(j, i) };
        let row = |i: usize| (0..across).map(|j| at(i, j)).sum::<f32>() / across as f32;
        let most = (0..along - 1).map(row).fold(0.0, f32::max);
        [most, row(along - 1)]
    }

    #[test]
    fn textures_that_repeat_have_no_seam() {
        let mut sides = 0;
        for texture in textures().iter() {
            for axis in 0..2 {
                if texture.wrap[axis] == Wrap::Repeat {
                    let [inside, seam] = steps(texture, axis);
                    assert!(
                        seam <= 1.2 * inside + 2.0,
                        "{} has a seam: {seam} where {inside} is the most inside",
                        texture.name
                    );
                    sides += 1;
                }
            }
        }
        assert!(sides > 35, "{sides} sides");
    }

    #[test]
    fn they_are_the_same_every_time_and_each_shows_something() {
        let again = all();
        assert_eq!([again.len(), textures().len()], [COUNT; 2]);
        for (texture, again) in textures().iter().zip(&again) {
            assert_eq!(texture, again);
            let colors: std::collections::BTreeSet<_> = texture.texels().iter().collect();
            assert!(colors.len() > 10, "{} is empty", texture.name);
            assert!(texture.size().iter().all(|side| (64..=512).contains(side)));
        }
        let holes = |id: TextureId| {
            textures()[id.0 as usize]
                .texels()
                .iter()
                .any(|texel| texel[3] == 0)
        };
        let green = [LEAFLET, BOUGH, GRASS_TUFT];
        let cut = green.into_iter().chain([LACEWORK]).chain(CURTAINS).chain(RUGS);
        assert!(cut.into_iter().all(holes));
    }
}
