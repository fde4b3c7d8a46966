//! An independent reader of PVS rows, written from the engines' sources.

use std::ops::Range;

pub(crate) fn word(bytes: &[u8], at: usize) -> usize {
    i32::from_le_bytes(bytes[at..at + 4].try_into().expect("four")) as usize
}

pub(crate) fn lump(map: &[u8], number: usize) -> Range<usize> {
    let table = if map.starts_with(b"IBSP") { 8 } else { 4 };
    let [start, length] = [0, 4].map(|at| word(map, table + number * 8 + at));
    start..start + length
}

/// Returns the leafs visible from a leaf of a Quake map, numbered as in the map.
pub(crate) fn seen_in_quake(map: &[u8], leaf: usize) -> Vec<usize> {
    let leaf_bytes = if map.starts_with(b"BSP2") { 44 } else { 28 };
    let leafs = word(map, lump(map, 14).start + 52);
    let offset = word(map, lump(map, 10).start + leaf * leaf_bytes + 4);
    let mut at = lump(map, 4).start + offset;
    let mut seen = Vec::new();
    let mut first = 1;
    while first <= leafs {
        if map[at] == 0 {
            first += 8 * usize::from(map[at + 1]);
            at += 2;
            continue;
        }
        seen.extend(
            (0..8)
                .filter(|bit| map[at] >> bit & 1 != 0)
                .map(|bit| first + bit),
        );
        first += 8;
        at += 1;
    }
    assert!(at <= lump(map, 4).end);
    seen
}
