//! Maps that are rewritten keep every byte that is not of the PVS: what absolute offsets lead to is still there.

use super::carved::{Format, TWO_ROOMS, carved};
use super::maps::{maps, pairs_of, read};
use super::rows::{lump, word};
use enfilade_bake::VisiblePairs;
use enfilade_import::{
    AmbientSounds, BspError, PortalFile, ReadOptions, rebuild_portals_bytes, with_ambient_sounds,
    with_visibility,
};
use fastrand::Rng;
use std::collections::BTreeMap;
use std::ops::Range;

/// Numbers of a format, written down once more: offset of the lump table, lumps, the lump of the PVS, that of leafs, and the
/// bytes of a leaf.
#[derive(Clone, Copy)]
struct Layout {
    table: usize,
    lumps: usize,
    pvs: usize,
    leafs: usize,
    leaf_bytes: usize,
}

impl Layout {
    fn table_end(&self) -> usize {
        self.table + 8 * self.lumps
    }
}

fn layout(map: &[u8]) -> Layout {
    let quake = |leaf_bytes| Layout {
        table: 4,
        lumps: 15,
        pvs: 4,
        leafs: 10,
        leaf_bytes,
    };
    match &map[..4] {
        b"IBSP" => Layout {
            table: 8,
            lumps: 17,
            pvs: 16,
            leafs: 4,
            leaf_bytes: 48,
        },
        b"BSP2" => quake(44),
        _ => quake(28),
    }
}

/// Returns the bytes of a lump behind the lump table; an empty one may have any offset.
fn content(map: &[u8], number: usize) -> &[u8] {
    let range = lump(map, number);
    let start = range.start.max(layout(map).table_end());
    if range.is_empty() {
        &[]
    } else {
        &map[start.min(range.end)..range.end]
    }
}

/// Returns where engines look for BSPX: behind the furthest lump, at a multiple of 4. `None` if there is none.
fn directory(map: &[u8]) -> Option<Range<usize>> {
    // Offsets are signed.
    let ends = (0..layout(map).lumps).map(|number| lump(map, number).end as isize);
    let start = usize::try_from(ends.max()?).ok()?.div_ceil(4) * 4;
    let is_there = map.get(start..start + 4)? == b"BSPX" && map.len() >= start + 8;
    let directory = is_there.then(|| start..start + 8 + 32 * word(map, start + 4));
    directory.filter(|directory| directory.end <= map.len())
}

/// Returns the blocks of a BSPX directory, by name. Those that begin in the lump table or end after the file are no blocks.
fn extended(map: &[u8]) -> BTreeMap<Vec<u8>, Vec<u8>> {
    let entries = directory(map).map_or(&[][..], |directory| &map[directory][8..]);
    let block = |entry: &[u8]| {
        let [start, length] = [24, 28].map(|at| word(entry, at));
        let is_block = length > 0 && start >= layout(map).table_end();
        let block = map.get(start..start + length).filter(|_| is_block)?;
        Some((entry[..24].to_vec(), block.to_vec()))
    };
    entries.chunks_exact(32).filter_map(block).collect()
}

/// Asserts that a map is another one with other PVS rows and sounds: by name, and by position.
#[track_caller]
fn only_the_pvs_differs(before: &[u8], after: &[u8]) {
    let layout = layout(before);
    for number in (0..layout.lumps).filter(|number| ![layout.pvs, layout.leafs].contains(number)) {
        let [old, new] = [before, after].map(|map| content(map, number));
        assert!(old == new, "lump {number}");
    }
    let blocks = extended(after);
    for (name, block) in extended(before) {
        assert_eq!(
            blocks.get(&name),
            Some(&block),
            "{}",
            String::from_utf8_lossy(&name)
        );
    }
    let mut may_differ = vec![false; before.len()];
    let mut allow = |range: Range<usize>| may_differ[range].fill(true);
    allow(layout.table + 8 * layout.pvs..layout.table + 8 * layout.pvs + 8);
    let pvs = lump(before, layout.pvs);
    if let Some(directory) = directory(before) {
        // With the padding before it, if the PVS is the last lump.
        let is_last = pvs.end.div_ceil(4) * 4 == directory.start;
        allow(if is_last { pvs.end } else { directory.start }..directory.end);
    }
    if !pvs.is_empty() {
        allow(pvs);
    }
    if layout.table == 4 {
        let leafs = lump(before, layout.leafs);
        for leaf in leafs.step_by(layout.leaf_bytes) {
            allow(leaf + 4..leaf + 8);
            allow(leaf + layout.leaf_bytes - 4..leaf + layout.leaf_bytes);
        }
    }
    let moved = (0..before.len()).find(|&at| !may_differ[at] && after.get(at) != Some(&before[at]));
    assert_eq!(moved, None, "a byte that is not of the PVS has changed");
}

/// Lays the lumps of a map out anew: in another order, with other bytes between and behind them, and with a BSPX directory.
fn relaid(map: &[u8], random: &mut Rng) -> Vec<u8> {
    let layout = layout(map);
    let mut order: Vec<usize> = (0..layout.lumps).collect();
    random.shuffle(&mut order);
    let noise = |random: &mut Rng, most: usize| -> Vec<u8> {
        let bytes = random.usize(..most);
        (0..bytes).map(|_| random.u8(1..)).collect()
    };
    let mut new = map[..layout.table_end()].to_vec();
    let mut blocks: Vec<[usize; 2]> = Vec::new();
    let put = |new: &mut Vec<u8>, bytes: &[u8]| {
        let block = [new.len(), bytes.len()];
        new.extend_from_slice(bytes);
        block
    };
    for number in order {
        if random.u8(..3) == 0 {
            blocks.push(put(&mut new, &noise(random, 40)));
        }
        new.resize(new.len().next_multiple_of(4), 0);
        let content = match number == layout.pvs {
            true if random.bool() => Vec::new(),
            true => noise(random, 120),
            false => map[lump(map, number)].to_vec(),
        };
        let entry = put(&mut new, &content).map(|number| (number as u32).to_le_bytes());
        new[layout.table + 8 * number..][..8].copy_from_slice(&entry.concat());
    }
    if random.bool() {
        new.resize(new.len().next_multiple_of(4), 0);
        let behind = random.usize(..3);
        let count = blocks.len() + behind;
        let mut at = new.len() + 8 + 32 * count;
        let later: Vec<Vec<u8>> = (0..behind).map(|_| noise(random, 40)).collect();
        for block in &later {
            blocks.push([at, block.len()]);
            at += block.len();
        }
        new.extend_from_slice(&[b"BSPX", &(count as u32).to_le_bytes()[..]].concat());
        for (number, block) in blocks.iter().enumerate() {
            new.extend_from_slice(format!("BLOCK {number:18}").as_bytes());
            new.extend(block.iter().flat_map(|&number| (number as u32).to_le_bytes()));
        }
        new.extend(later.concat());
    }
    if random.u8(..4) == 0 {
        new.extend(noise(random, 9));
    }
    new
}

/// Rewrites a map as `vis` does.
fn rewritten(map: &[u8], portals: &PortalFile, pairs: &VisiblePairs) -> Result<Vec<u8>, BspError> {
    let written = with_visibility(map, portals, pairs)?;
    // A damaged texture must not discard the PVS.
    match with_ambient_sounds(&written, portals, pairs, AmbientSounds::default()) {
        Ok(Some((map, _))) => Ok(map),
        Ok(None) | Err(_) => Ok(written),
    }
}

#[test]
fn every_block_of_a_map_is_where_it_was_however_the_map_is_laid_out() {
    let mut random = Rng::with_seed(63);
    let mut directories = 0;
    for format in [Format::Bsp29, Format::Bsp2, Format::Ibsp46] {
        let map = carved(&TWO_ROOMS).bytes(format);
        let portals = rebuild_portals_bytes(&map, &ReadOptions::default())
            .expect("portals")
            .file;
        let pairs = pairs_of(&portals);
        for _ in 0..1000 {
            let before = relaid(&map, &mut random);
            let after = rewritten(&before, &portals, &pairs).expect("a map");
            only_the_pvs_differs(&before, &after);
            directories += usize::from(!extended(&before).is_empty());
            let again = rewritten(&after, &portals, &pairs).expect("a map");
            assert!(again == after, "a second run changes nothing");
            let fresh = with_visibility(&map, &portals, &pairs).expect("a map");
            let [rows, fresh] = [&after, &fresh].map(|map| &map[lump(map, layout(map).pvs)]);
            assert!(rows == fresh, "the PVS does not depend on the layout");
        }
    }
    assert!(directories > 1000, "{directories} had blocks");
}

#[test]
fn maps_with_changed_bytes_are_refused_or_lose_no_block() {
    let mut random = Rng::with_seed(64);
    let [mut written, mut refused] = [0; 2];
    for format in [Format::Bsp29, Format::Bsp2, Format::Ibsp46] {
        let map = carved(&TWO_ROOMS).bytes(format);
        let portals = rebuild_portals_bytes(&map, &ReadOptions::default())
            .expect("portals")
            .file;
        let pairs = pairs_of(&portals);
        for _ in 0..4000 {
            let mut before = relaid(&map, &mut random);
            let layout = layout(&before);
            let entries = layout.table..layout.table_end();
            let directory = directory(&before).unwrap_or(entries.clone());
            for _ in 0..random.usize(1..4) {
                let within = if random.bool() {
                    entries.clone()
                } else {
                    directory.clone()
                };
                let at = random.usize(within);
                before[at] = [0, 1, 4, before[at].wrapping_add(8), random.u8(..)][random.usize(..5)];
            }
            match rewritten(&before, &portals, &pairs) {
                Ok(after) => {
                    written += 1;
                    only_the_pvs_differs(&before, &after);
                }
                Err(_) => refused += 1,
            }
        }
    }
    assert!(
        written > 3000 && refused > 3000,
        "{written} written, {refused} refused"
    );
}

#[test]
fn a_leaf_lump_that_shares_bytes_with_another_block_is_refused_by_name() {
    let mut map = carved(&TWO_ROOMS).bytes(Format::Bsp29);
    let portals = rebuild_portals_bytes(&map, &ReadOptions::default())
        .expect("portals")
        .file;
    let pairs = pairs_of(&portals);
    let leafs = lump(&map, 10);
    for (number, name) in [(13, "its lump 13"), (8, "its lump 8")] {
        let mut map = map.clone();
        let entry = [leafs.start as u32 + 8, 4].map(u32::to_le_bytes).concat();
        map[4 + 8 * number..][..8].copy_from_slice(&entry);
        let other = name.to_owned();
        let why = with_visibility(&map, &portals, &pairs).expect_err("a refusal");
        assert_eq!(why, BspError::Overlap { lump: 10, other });
    }
    map.resize(map.len().next_multiple_of(4), 0);
    map.extend_from_slice(b"BSPX\x01\0\0\0BRUSHLIST\0\0\0\0\0\0\0\0\0\0\0\0\0\0\0");
    map.extend([leafs.start as u32, 3].map(u32::to_le_bytes).concat());
    let why = with_visibility(&map, &portals, &pairs).expect_err("a refusal");
    assert!(
        why.to_string().contains("overlaps its BSPX block BRUSHLIST"),
        "{why}"
    );
}

#[test]
#[ignore = "needs ENFILADE_MAPS"]
fn real_maps_with_changed_bytes_are_refused_or_lose_no_block() {
    let folder = maps();
    let mut random = Rng::with_seed(65);
    for (map, prt) in [
        ("quake/dm1.bsp", "quake/dm1.prt"),
        ("quake/lq_e0m1.bsp", "quake/lq_e0m1.prt"),
        ("quake3/darkzone.shipped.bsp", "quake3/darkzone.prt"),
    ] {
        let portals = read(&folder, prt);
        let pairs = pairs_of(&portals);
        let sound = std::fs::read(folder.join(map)).expect("a map");
        only_the_pvs_differs(&sound, &rewritten(&sound, &portals, &pairs).expect("a map"));
        let mut written = 0;
        for _ in 0..3400 {
            let mut before = relaid(&sound, &mut random);
            for _ in 0..random.usize(1..20) {
                let at = random.usize(..before.len());
                before[at] = random.u8(..);
            }
            if let Ok(after) = rewritten(&before, &portals, &pairs) {
                written += 1;
                only_the_pvs_differs(&before, &after);
            }
        }
        assert!(written > 1000, "{map}: {written} written");
    }
}
