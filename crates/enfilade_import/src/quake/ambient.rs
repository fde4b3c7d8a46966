//! Ambient sounds: what a player hears in each leaf of a Quake map.
//!
//! An engine plays a looping sound for each class (water, sky, slime, lava) by the level that the leaf of the camera has for it.
//! A leaf has level 255 for a class if any leaf of its row in the PVS has a face of that class, else 0. Slime sounds like water.
//! Source: the levels that id Software's `vis` and its successors write.
//! Cost: O(faces + visible pairs).

use super::bsp::{BspError, Map, Tree, check_pairs, clusters_of_leafs, in_range, int, short};
use super::prt::PortalFile;
use super::scene::{Image, Kind, Outlines, behind, faces, front, images, placings, plane_side_placing};
use enfilade_bake::VisiblePairs;

/// The texture classes that emit ambient sounds.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub struct AmbientSounds {
    /// Textures `*water…` and `*04water…`. Default `true`, as for all others.
    pub water: bool,
    /// Textures `sky…`.
    pub sky: bool,
    /// Textures `*slime…`; they sound like water.
    pub slime: bool,
    /// Textures `*lava…`.
    pub lava: bool,
}

impl Default for AmbientSounds {
    fn default() -> AmbientSounds {
        AmbientSounds {
            water: true,
            sky: true,
            slime: true,
            lava: true,
        }
    }
}

/// Numbers of leafs with each ambient sound, as written by [`with_ambient_sounds`].
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
#[non_exhaustive]
pub struct AmbientLeafs {
    /// Number of leafs with the sound of water, or of slime.
    pub water: usize,
    /// Number of leafs with the sound of the sky.
    pub sky: usize,
    /// Number of leafs with the sound of lava.
    pub lava: usize,
    /// Whether the map has texture names. Without them, a face belongs to the class of the leaf behind it.
    pub by_names: bool,
}

/// Returns the bytes of a Quake map with the ambient sound levels of all leafs of the world set, and the number of leafs that have
/// each; `None` for a Quake 3 map, which has no such levels.
///
/// # Errors
/// Returns a [`BspError`] if the format of the map is unknown, if the map is damaged, or if the portals or pairs belong
/// to another map.
pub fn with_ambient_sounds(
    map: &[u8],
    portals: &PortalFile,
    pairs: &VisiblePairs,
    sounds: AmbientSounds,
) -> Result<Option<(Vec<u8>, AmbientLeafs)>, BspError> {
    check_pairs(portals, pairs)?;
    let mut map = Map::read(map)?;
    if map.format.is_quake3 {
        return Ok(None);
    }
    map.check_disjoint(map.format.leafs)?;
    let tree = Tree::read(&map)?;
    let images = images(&map)?;
    let classes = classes_of_faces(&map, &tree, &images, sounds)?;
    let clusters = clusters_of_leafs(&map, portals)?;
    let mut class_of_cluster = vec![0; pairs.cell_count() as usize];
    for (leaf, &cluster) in clusters.iter().enumerate() {
        if let Some(cluster) = cluster {
            class_of_cluster[cluster as usize] |= class_of_leaf(&map, &tree, leaf, &classes)?;
        }
    }
    let heard: Vec<u8> = (0..pairs.cell_count())
        .map(|cluster| {
            let seen = pairs
                .seen_from(cluster)
                .map(|other| class_of_cluster[other as usize]);
            seen.fold(class_of_cluster[cluster as usize], |all, class| all | class)
        })
        .collect();
    let mut leafs = AmbientLeafs {
        by_names: images.iter().any(|image| !image.name.is_empty()),
        ..AmbientLeafs::default()
    };
    let record_offsets: Vec<usize> = map
        .record_offsets(map.format.leafs, map.format.leaf_bytes)?
        .collect();
    for (place, cluster) in record_offsets.into_iter().zip(&clusters) {
        let Some(cluster) = cluster else { continue };
        let heard = heard[*cluster as usize];
        let end = place + map.format.leaf_bytes;
        for (channel, level) in map.bytes[end - CHANNELS..end].iter_mut().enumerate() {
            *level = 255 * (heard >> channel & 1);
        }
        leafs.water += usize::from(heard & WATER != 0);
        leafs.sky += usize::from(heard & SKY != 0);
        leafs.lava += usize::from(heard & LAVA != 0);
    }
    Ok(Some((map.bytes, leafs)))
}

/// Each leaf record ends with one level each for water, sky, slime and lava. The bits of a class use the same order.
const CHANNELS: usize = 4;
const WATER: u8 = 1 << 0;
const SKY: u8 = 1 << 1;
const LAVA: u8 = 1 << 3;

/// Index of the lump with the face indices of the leafs.
const LEAF_FACES: usize = 11;

/// Returns the union of the classes of a leaf's faces.
fn class_of_leaf(map: &Map, tree: &Tree, leaf: usize, classes: &[u8]) -> Result<u8, BspError> {
    let is_short = map.format.is_short;
    let numbers = map.records(LEAF_FACES, if is_short { 2 } else { 4 })?;
    let [first, count] = tree.leafs[leaf].faces.map(|number| number as usize);
    let count_of_all = numbers.len();
    if first + count > count_of_all {
        return Err(BspError::NoSuch {
            what: "leaf",
            at: leaf,
            names: "faces up to",
            number: (first + count) as i64,
            count: count_of_all,
        });
    }
    numbers.skip(first).take(count).try_fold(0, |all, number| {
        let face = match is_short {
            true => short(number, 0).into(),
            false => i64::from(int(number, 0)),
        };
        Ok(all | classes[in_range("leaf", leaf, "face", face, classes.len())? as usize])
    })
}

/// Returns the class of each face: by its texture name, or by the leaf behind it if the map has no names.
fn classes_of_faces(
    map: &Map,
    tree: &Tree,
    images: &[Image],
    sounds: AmbientSounds,
) -> Result<Vec<u8>, BspError> {
    let outlines = Outlines::of(map)?;
    let placings = placings(map, images.len())?;
    let mut outline = Vec::new();
    let class = |(at, face): (usize, &[u8])| {
        let [plane, side, placing] = plane_side_placing(map, face);
        let placing = &placings[in_range("face", at, "texture placing", placing, placings.len())? as usize];
        let name = images.get(placing.image as usize).map_or("", |image| &image.name);
        if !name.is_empty() {
            return Ok(class_of_name(name, sounds));
        }
        let plane = in_range("face", at, "plane", plane, tree.planes.len())?;
        outlines.read(at, face, &mut outline)?;
        let front = front(&tree.planes[plane as usize], side);
        Ok(match behind(tree, &outline, front) {
            Kind::Water if sounds.water => WATER,
            Kind::Slime if sounds.slime => WATER,
            Kind::Lava if sounds.lava => LAVA,
            Kind::Sky if sounds.sky => SKY,
            _ => 0,
        })
    };
    faces(map)?.enumerate().map(class).collect()
}

/// Returns the class of a texture by its lower-case name. Other liquids (`*teleport`, `*blood1`, `*04mwat1`) are
/// silent.
fn class_of_name(name: &str, sounds: AmbientSounds) -> u8 {
    let begins = |with: &str| name.starts_with(with);
    let water = sounds.water && (begins("*water") || begins("*04water"));
    let slime = sounds.slime && begins("*slime");
    let mut class = 0;
    for (bit, is_of_class) in [
        (WATER, water || slime),
        (SKY, sounds.sky && begins("sky")),
        (LAVA, sounds.lava && begins("*lava")),
    ] {
        class |= if is_of_class { bit } else { 0 };
    }
    class
}
