//! Tests that lumps written into maps are read back as engines read them.

use super::maps::{maps, pairs_of, read};
use super::reads;
use super::rows::{lump, seen_in_quake, word};
use enfilade_bake::VisiblePairs;
use enfilade_import::{BspError, PortalFile, with_visibility};

/// That all lumps but one are as they were, but for words in leafs.
fn nothing_else_changed(before: &[u8], after: &[u8], lumps: usize, written: usize, leafs: Option<usize>) {
    for number in (0..lumps).filter(|&number| number != written && Some(number) != leafs) {
        assert!(
            before[lump(before, number)] == after[lump(after, number)],
            "lump {number}"
        );
    }
}

/// A map of three leafs in a row and the solid one before them; the third is in the cluster of the first.
fn small(magic: &[u8; 4], leaf_bytes: usize, lump_of_old: &[u8]) -> (Vec<u8>, PortalFile, VisiblePairs) {
    let portals = reads("PRT2\n3\n2\n1\n4 0 1 (8 0 0) (8 8 0) (8 8 8) (8 0 8)\n0 2 -1\n1 -1\n");
    let pairs = pairs_of(&portals);
    let mut lumps = vec![vec![7u8; 5]; 15];
    lumps[4] = lump_of_old.to_vec();
    lumps[10] = vec![0xff; leaf_bytes * 5];
    lumps[14] = vec![0; 64];
    lumps[14][52] = 3;
    let mut map = magic.to_vec();
    map.resize(4 + 15 * 8, 0);
    for (number, lump) in lumps.iter().enumerate() {
        map.resize(map.len().next_multiple_of(4), 0);
        let entry = [map.len() as u32, lump.len() as u32]
            .map(u32::to_le_bytes)
            .concat();
        map[4 + number * 8..][..8].copy_from_slice(&entry);
        map.extend_from_slice(lump);
    }
    map.extend_from_slice(b"BSPX follows");
    (map, portals, pairs)
}

#[test]
fn leafs_of_a_cluster_share_a_row_in_both_kinds_of_quake_map() {
    for (magic, leaf_bytes) in [(&29u32.to_le_bytes(), 28), (b"BSP2", 44)] {
        for old in [&[][..], &[1, 2, 3], &[9; 1000]] {
            let (map, portals, pairs) = small(magic, leaf_bytes, old);
            let written = with_visibility(&map, &portals, &pairs).expect("a map");
            for leaf in 1..=3 {
                assert_eq!(seen_in_quake(&written, leaf), [1, 2, 3]);
            }
            assert_eq!(lump(&written, 4).len(), 1, "all rows are equal");
            nothing_else_changed(&map, &written, 15, 4, Some(10));
            let leafs = &written[lump(&written, 10)];
            assert_eq!(
                leafs[leaf_bytes * 4..],
                vec![0xff; leaf_bytes],
                "a leaf of a door is none of the world's"
            );
            assert_eq!(
                &written[map.len() - 12..][..12],
                b"BSPX follows",
                "no directory, so it stays"
            );
            let again = with_visibility(&written, &portals, &pairs).expect("a map");
            assert!(again == written, "writing once more changes nothing");
        }
    }
}

#[test]
fn a_map_that_is_damaged_or_another_is_refused() {
    let (map, portals, pairs) = small(b"BSP2", 44, &[]);
    let refused = |map: &[u8]| with_visibility(map, &portals, &pairs).expect_err("a refusal");
    assert!(matches!(refused(b"IBSP\x2f\0\0\0"), BspError::NotMap { .. }));
    assert!(matches!(refused(&[]), BspError::NotMap { .. }));
    assert!(matches!(refused(b"IBSP\x2e\0\0\0"), BspError::CutShort { .. }));
    let changed = |at: usize, to: u32| {
        let mut map = map.clone();
        map[at..at + 4].copy_from_slice(&to.to_le_bytes());
        refused(&map)
    };
    let of_leafs = 4 + 10 * 8;
    assert!(matches!(changed(of_leafs, u32::MAX), BspError::CutShort { .. }));
    assert!(matches!(
        changed(of_leafs + 4, 1 << 30),
        BspError::CutShort { .. }
    ));
    assert!(matches!(
        changed(of_leafs + 4, 45),
        BspError::OddLump { lump: 10, .. }
    ));
    assert!(matches!(
        changed(4 + 14 * 8 + 4, 0),
        BspError::OddLump { lump: 14, .. }
    ));
    let models = lump(&map, 14).start;
    let other = changed(models + 52, 4).to_string();
    assert!(
        other.starts_with("has 4 leafs, but its portals have 3: they are of another map"),
        "{other}"
    );
    for end in 0..map.len() - 12 {
        refused(&map[..end]);
    }
    let others = pairs_of(&reads("PRT1\n3\n0\n"));
    let of_others = with_visibility(&map, &portals, &others).expect_err("a refusal");
    assert_eq!(
        of_others,
        BspError::OtherPairs {
            pairs: 3,
            clusters: 2
        }
    );
}

#[test]
#[ignore = "needs ENFILADE_MAPS"]
fn a_map_of_quake_has_its_pairs_in_it_in_no_more_bytes_than_others_need() {
    let folder = maps();
    for (name, most) in [("dm1", 11_403), ("end", 13_143), ("lq_e0m1", 18_544)] {
        let portals = read(&folder, &format!("quake/{name}.prt"));
        let pairs = pairs_of(&portals);
        let map = std::fs::read(folder.join(format!("quake/{name}.bsp"))).expect("a map");
        let written = with_visibility(&map, &portals, &pairs).unwrap_or_else(|error| panic!("{error}"));
        let clusters = portals.cluster_of_leaf.as_ref().expect("clusters");
        for (leaf, &cluster) in clusters.iter().enumerate() {
            let all = (1..).zip(clusters);
            let wanted: Vec<usize> = all
                .filter(|&(_, &at)| pairs.may_see(cluster, at))
                .map(|(leaf, _)| leaf)
                .collect();
            assert_eq!(
                seen_in_quake(&written, leaf + 1),
                wanted,
                "{name}: leaf {}",
                leaf + 1
            );
        }
        nothing_else_changed(&map, &written, 15, 4, Some(10));
        let bytes = lump(&written, 4).len();
        assert!(bytes * 100 <= most * 102, "{name}: {bytes} bytes");
    }
}

#[test]
#[ignore = "needs ENFILADE_MAPS"]
fn a_map_of_quake_3_has_a_row_for_each_cluster() {
    let folder = maps();
    let portals = read(&folder, "quake3/darkzone.prt");
    let pairs = pairs_of(&portals);
    for name in ["novis", "shipped"] {
        let map = std::fs::read(folder.join(format!("quake3/darkzone.{name}.bsp"))).expect("a map");
        let written = with_visibility(&map, &portals, &pairs).unwrap_or_else(|error| panic!("{error}"));
        let rows = &written[lump(&written, 16)];
        let (clusters, row_bytes) = (word(rows, 0), word(rows, 4));
        assert_eq!((clusters, row_bytes), (534, 72));
        assert_eq!(rows.len(), 8 + clusters * row_bytes);
        for from in 0..clusters {
            for to in 0..row_bytes * 8 {
                let seen = rows[8 + from * row_bytes + to / 8] >> (to % 8) & 1 != 0;
                assert_eq!(
                    seen,
                    to < clusters && pairs.may_see(from as u32, to as u32),
                    "{from} {to}"
                );
            }
        }
        nothing_else_changed(&map, &written, 17, 16, None);
    }
}
