//! Ambient sounds: the rule over the rows that are written, and the levels of the usual compilers.
#![allow(clippy::print_stderr, reason = "figures of real maps")]

use super::maps::{maps, pairs_of, read};
use super::rows::{lump, seen_in_quake, word};
use enfilade_bake::VisiblePairs;
use enfilade_import::{
    AmbientLeafs, AmbientSounds, BspError, PortalFile, with_ambient_sounds, with_visibility,
};
use std::path::Path;

type Levels = [u8; 4];

/// A map with the names of its textures put back: a header of 40 bytes each.
fn with_names(map: &[u8], names: &str) -> Vec<u8> {
    let names: Vec<&str> = names
        .lines()
        .map(|line| line.split_once(' ').expect("a number and a name").1)
        .collect();
    let mut textures = (names.len() as u32).to_le_bytes().to_vec();
    for at in 0..names.len() as u32 {
        textures.extend((4 + 4 * names.len() as u32 + 40 * at).to_le_bytes());
    }
    for name in names {
        let mut header = [0; 40];
        header[..name.len()].copy_from_slice(name.as_bytes());
        textures.extend(header);
    }
    let mut named = map.to_vec();
    named.resize(named.len().next_multiple_of(4), 0);
    let entry = [named.len() as u32, textures.len() as u32];
    named[4 + 8 * 2..][..8].copy_from_slice(&entry.map(u32::to_le_bytes).concat());
    named.extend(textures);
    named
}

fn leaf_bytes(map: &[u8]) -> usize {
    if map.starts_with(b"BSP2") { 44 } else { 28 }
}

fn levels(map: &[u8], leaf: usize) -> Levels {
    let end = lump(map, 10).start + (leaf + 1) * leaf_bytes(map);
    map[end - 4..end].try_into().expect("four bytes")
}

/// Which classes the faces of a leaf have, by the names of their textures.
fn marks(map: &[u8], leaf: usize) -> [bool; 4] {
    let is_long = map.starts_with(b"BSP2");
    let number = |at: usize| match is_long {
        true => word(map, at),
        false => u16::from_le_bytes([map[at], map[at + 1]]).into(),
    };
    let (size, face_bytes, placing) = if is_long { (4, 28, 16) } else { (2, 20, 10) };
    let at = lump(map, 10).start + leaf * leaf_bytes(map) + if is_long { 32 } else { 20 };
    let [first, count] = [at, at + size].map(number);
    let mut marks = [false; 4];
    for mark in first..first + count {
        let face = number(lump(map, 11).start + mark * size);
        let placing = number(lump(map, 7).start + face * face_bytes + placing);
        let texture = word(map, lump(map, 6).start + placing * 40 + 32);
        let textures = lump(map, 2).start;
        let name = textures + word(map, textures + 4 + 4 * texture);
        let name = String::from_utf8_lossy(&map[name..name + 16]).to_lowercase();
        let begins = |all: &[&str]| all.iter().any(|with| name.starts_with(with));
        marks[0] |= begins(&["*water", "*04water", "*slime"]);
        marks[1] |= begins(&["sky"]);
        marks[3] |= begins(&["*lava"]);
    }
    marks
}

fn heard(
    map: &[u8],
    portals: &PortalFile,
    pairs: &VisiblePairs,
    sounds: AmbientSounds,
) -> (Vec<u8>, AmbientLeafs) {
    let heard = with_ambient_sounds(map, portals, pairs, sounds).unwrap_or_else(|error| panic!("{error}"));
    heard.expect("a map of Quake")
}

/// The number of leafs that differ from the levels of a file, as many as there are leafs of the world.
fn different(map: &[u8], leafs: usize, reference: &str) -> usize {
    let wanted = reference.lines().map(|line| -> Levels {
        let mut numbers = line
            .split_whitespace()
            .map(|number| number.parse().expect("a level"));
        std::array::from_fn(|_| numbers.next().expect("four levels"))
    });
    let wanted: Vec<Levels> = wanted.collect();
    (1..=leafs)
        .filter(|&leaf| levels(map, leaf) != wanted[leaf])
        .count()
}

fn follows_the_rule(folder: &Path, name: &str) {
    let file = |kind: &str| {
        let path = folder.join(format!("ambient/{name}.{kind}"));
        std::fs::read_to_string(path).expect("a file of levels")
    };
    let nameless = std::fs::read(folder.join(format!("quake/{name}.bsp"))).expect("a map");
    let named = with_names(&nameless, &file("textures.txt"));
    let portals = read(folder, &format!("quake/{name}.prt"));
    let pairs = pairs_of(&portals);
    let written = with_visibility(&named, &portals, &pairs).unwrap_or_else(|error| panic!("{error}"));
    let (with_sounds, leafs) = heard(&written, &portals, &pairs, AmbientSounds::default());
    assert!(leafs.by_names);

    let count = word(&written, lump(&written, 14).start + 52);
    let marks: Vec<[bool; 4]> = (0..=count).map(|leaf| marks(&written, leaf)).collect();
    let mut counted = [0; 4];
    for leaf in 1..=count {
        let mut seen = seen_in_quake(&written, leaf);
        seen.push(leaf);
        let rule: Levels =
            std::array::from_fn(|class| 255 * u8::from(seen.iter().any(|&other| marks[other][class])));
        assert_eq!(levels(&with_sounds, leaf), rule, "{name}: leaf {leaf}");
        (0..4).for_each(|class| counted[class] += usize::from(rule[class] != 0));
    }
    assert_eq!([leafs.water, leafs.sky, 0, leafs.lava], counted, "{name}");
    assert_ne!(counted, [0; 4], "{name} is not silent");

    // Nothing but the levels has changed.
    let mut rest = with_sounds.clone();
    for leaf in 1..=count {
        let end = lump(&rest, 10).start + (leaf + 1) * leaf_bytes(&rest);
        rest[end - 4..end].copy_from_slice(&levels(&written, leaf));
    }
    assert!(rest == written, "{name}");

    let by_names = different(&with_sounds, count, &file("ambient"));
    let (by_contents, leafs) = heard(&nameless, &portals, &pairs, AmbientSounds::default());
    assert!(!leafs.by_names);
    let by_contents = different(&by_contents, count, &file("ambient"));
    eprintln!("{name}: {by_names} of {count} leafs differ by names, {by_contents} by contents");
    assert!(by_names <= 15, "{name}: {by_names}");
}

#[test]
#[ignore = "needs ENFILADE_MAPS"]
fn leafs_hear_what_they_may_see_as_the_usual_compilers_write_it() {
    let folder = maps();
    ["dm1", "end", "lq_e0m1"]
        .iter()
        .for_each(|name| follows_the_rule(&folder, name));
}

#[test]
#[ignore = "computes the pairs of large maps; part of cargo xtask ci-long"]
fn leafs_of_large_maps_hear_what_they_may_see() {
    let folder = maps();
    ["e1m1", "lq_e1m5", "lqdm13", "start"]
        .iter()
        .for_each(|name| follows_the_rule(&folder, name));
}

#[test]
#[ignore = "needs ENFILADE_MAPS"]
fn sounds_that_are_switched_off_are_silent_and_maps_of_quake_3_have_none() {
    let folder = maps();
    let map = std::fs::read(folder.join("quake/end.bsp")).expect("a map");
    let portals = read(&folder, "quake/end.prt");
    let pairs = pairs_of(&portals);
    let (_, all) = heard(&map, &portals, &pairs, AmbientSounds::default());
    assert!(all.lava > 0 && all.water > 0, "{all:?}");
    let mut sounds = AmbientSounds::default();
    sounds.lava = false;
    let (quiet, leafs) = heard(&map, &portals, &pairs, sounds);
    assert_eq!((leafs.lava, leafs.water), (0, all.water));
    assert!((1..=word(&map, lump(&map, 14).start + 52)).all(|leaf| levels(&quiet, leaf)[3] == 0));

    let others = read(&folder, "quake/dm1.prt");
    let refused = with_ambient_sounds(&map, &others, &pairs_of(&others), AmbientSounds::default());
    assert!(matches!(refused, Err(BspError::OtherMap { .. })), "{refused:?}");

    let map = std::fs::read(folder.join("quake3/darkzone.novis.bsp")).expect("a map");
    let portals = read(&folder, "quake3/darkzone.prt");
    let none = with_ambient_sounds(&map, &portals, &pairs_of(&portals), AmbientSounds::default());
    assert_eq!(none, Ok(None));
}
