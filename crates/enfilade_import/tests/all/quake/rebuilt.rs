//! Portals that are rebuilt out of small maps made by code, and maps that nobody should have made.

use super::carved::{Format, Raw, Room, SOLID, TWO_ROOMS, carved};
use super::reads;
use enfilade_bake::{Cells, PairsOptions, Portal, VisiblePairs};
use enfilade_import::{
    ClustersFrom, PortalFile, PrtKind, ReadOptions, RebuiltPortals, rebuild_portals_bytes, with_visibility,
};

const FORMATS: [Format; 3] = [Format::Bsp29, Format::Bsp2, Format::Ibsp46];

#[track_caller]
fn rebuilt(map: &[u8]) -> RebuiltPortals {
    rebuild_portals_bytes(map, &ReadOptions::default()).unwrap_or_else(|error| panic!("{error}"))
}

#[track_caller]
fn refused(map: &[u8], words: &[&str]) {
    let error = match rebuild_portals_bytes(map, &ReadOptions::default()) {
        Ok(rebuilt) => panic!("{} portals", rebuilt.file.cells.portals().len()),
        Err(error) => error.to_string(),
    };
    words
        .iter()
        .for_each(|word| assert!(error.contains(word), "`{error}` does not say `{word}`"));
}

/// Two leafs of a file, and the box around what is between them.
fn boxes(file: &PortalFile) -> Vec<([u32; 2], [[f64; 3]; 2])> {
    let portals = file.cells.portals().iter().map(|portal| {
        let mut cells = portal.cells;
        cells.sort_unstable();
        let fold = |start: f64, pick: fn(f64, f64) -> f64| {
            [0, 1, 2].map(|axis| portal.corners.iter().map(|corner| corner[axis]).fold(start, pick))
        };
        (
            cells,
            [fold(f64::INFINITY, f64::min), fold(f64::NEG_INFINITY, f64::max)],
        )
    });
    let mut portals: Vec<_> = portals.collect();
    portals.sort_by_key(|&(cells, _)| cells);
    portals
}

#[test]
fn a_doorway_opens_into_the_rooms_at_both_its_ends() {
    for format in FORMATS {
        let rebuilt = rebuilt(&carved(&TWO_ROOMS).bytes(format));
        assert_eq!((rebuilt.leafs, rebuilt.slivers), (3, 0));
        assert_eq!(rebuilt.file.cells.count(), 3);
        let ends = boxes(&rebuilt.file).into_iter().map(|(_, around)| around);
        let mut ends: Vec<_> = ends.collect();
        ends.sort_by(|a, b| a[0][0].total_cmp(&b[0][0]));
        let end = |x: f64| [[x, -16.0, 0.0], [x, 16.0, 48.0]];
        assert_eq!(ends, [end(-8.0), end(8.0)], "{format:?}");
        let (kind, from) = match format {
            Format::Ibsp46 => (PrtKind::Quake3, ClustersFrom::Map),
            _ => (PrtKind::Prt1, ClustersFrom::Leafs),
        };
        assert_eq!((rebuilt.file.kind, rebuilt.clusters_from), (kind, from));
    }
}

#[test]
fn a_portal_points_from_its_first_cluster_into_its_second() {
    let map = carved(&TWO_ROOMS);
    for format in FORMATS {
        for Portal { corners, cells } in rebuilt(&map.bytes(format)).file.cells.portals() {
            let [a, b, c] = [0, 1, 2].map(|at| corners[at]);
            let along_x = (b[1] - a[1]) * (c[2] - a[2]) - (b[2] - a[2]) * (c[1] - a[1]);
            // The doorway is the one in the middle; the rooms are in front of it and behind it.
            let x = corners[0][0];
            let doorway_is_second = (along_x > 0.0) == (x < 0.0);
            let [first, second] = cells.map(|cell| touches(&map, format, cell));
            assert_eq!([first, second], if doorway_is_second { [1, 2] } else { [2, 1] });
        }
    }
}

/// Returns the number of portals of each cluster.
fn touches(map: &Raw, format: Format, cluster: u32) -> usize {
    let file = rebuilt(&map.bytes(format)).file;
    let portals = file.cells.portals().iter();
    portals.filter(|portal| portal.cells.contains(&cluster)).count()
}

#[test]
fn one_sees_into_water_but_behind_the_sky_only_sky() {
    for (below, above, portals) in [
        (-1, -1, 1),
        (-3, -1, 1),
        (-5, -3, 1),
        (-6, -6, 1),
        (-6, -1, 0),
        (-3, -6, 0),
    ] {
        let pool = [
            Room([0, 0, -64], [64, 64, 0], below),
            Room([0, 0, 0], [64, 64, 64], above),
        ];
        for format in [Format::Bsp29, Format::Bsp2] {
            let rebuilt = rebuilt(&carved(&pool).bytes(format));
            assert_eq!(
                rebuilt.file.cells.portals().len(),
                portals,
                "{below} under {above}"
            );
            assert_eq!(rebuilt.file.cells.count(), 2);
        }
    }
}

#[test]
fn a_fence_that_looks_solid_but_is_numbered_among_the_leafs_is_seen_through() {
    let mut raw = carved(&TWO_ROOMS);
    raw.leafs[2][0] = -2;
    assert_eq!(rebuilt(&raw.bytes(Format::Bsp2)).file.cells.portals().len(), 2);
    // The same leaf after those of the world is no cluster of it.
    let last = raw.leafs.len() as i32;
    raw.leafs.push([-2, -1]);
    for (_, children) in &mut raw.nodes {
        children
            .iter_mut()
            .filter(|child| **child == -3)
            .for_each(|child| *child = -last - 1);
    }
    assert_eq!(rebuilt(&raw.bytes(Format::Bsp2)).file.cells.portals().len(), 0);
}

#[test]
fn leafs_that_share_a_row_are_a_cluster_again_where_they_stand_side_by_side() {
    // A row of four rooms without walls between; the first two are a cluster, and so are the third and the fourth.
    let row = [0, 1, 2, 3].map(|at| Room([at * 64, 0, 0], [at * 64 + 64, 64, 64], -1));
    let map = carved(&row).bytes(Format::Bsp29);
    let plain = rebuilt(&map).file;
    assert_eq!((plain.cells.count(), plain.cells.portals().len()), (4, 3));
    let leafs = plain
        .cells
        .portals()
        .iter()
        .map(|portal| (portal.corners[0][0], portal.cells));
    let [_, middle, _] = {
        let mut leafs: Vec<_> = leafs.collect();
        leafs.sort_by(|a, b| a.0.total_cmp(&b.0));
        [leafs[0], leafs[1], leafs[2]]
    };
    assert_eq!(middle.0, 128.0);
    // A PVS as of a compiler with two clusters; from each, only itself is visible.
    for (clusters, parts) in [([0, 0, 1, 1], 2), ([0, 1, 1, 0], 4), ([0, 1, 2, 2], 3)] {
        let of_leaf = ordered(&plain, clusters);
        let count = 1 + *of_leaf.iter().max().expect("some");
        let seen = PortalFile {
            kind: PrtKind::Prt2,
            cells: Cells::new(count, Vec::new()).expect("cells"),
            cluster_of_leaf: Some(of_leaf),
        };
        let pairs = VisiblePairs::compute(&seen.cells, &PairsOptions::default()).expect("little memory");
        let again = rebuilt(&with_visibility(&map, &seen, &pairs).expect("written"));
        assert_eq!(again.clusters_from, ClustersFrom::Rows);
        assert_eq!(
            (again.file.cells.count(), again.leafs),
            (parts, 4),
            "{clusters:?}"
        );
        assert_eq!(again.file.cells.portals().len() as u32, parts - 1);
        let leafs_alone = parts == 4;
        assert_eq!(again.file.cluster_of_leaf.is_none(), leafs_alone);
    }
}

/// The clusters of rooms along x as those of leafs, whose numbers the carver chose.
fn ordered(file: &PortalFile, rooms: [u32; 4]) -> Vec<u32> {
    let mut portals: Vec<_> = file.cells.portals().iter().collect();
    portals.sort_by(|a, b| a.corners[0][0].total_cmp(&b.corners[0][0]));
    let shared = |a: &Portal, b: &Portal| {
        a.cells
            .into_iter()
            .find(|cell| b.cells.contains(cell))
            .expect("one")
    };
    let other = |of: &Portal, cell: u32| of.cells[usize::from(of.cells[0] == cell)];
    let [second, third] = [shared(portals[0], portals[1]), shared(portals[1], portals[2])];
    let along = [other(portals[0], second), second, third, other(portals[2], third)];
    let mut of_leaf = vec![0; 4];
    along
        .iter()
        .zip(rooms)
        .for_each(|(&leaf, cluster)| of_leaf[leaf as usize] = cluster);
    of_leaf
}

#[test]
fn what_is_written_is_read_again_to_the_last_digit() {
    let odd = "PRT2\n3\n2\n1\n4 0 1 (8 0 0) (8 8.000000000000002 0) (8 8 8.1) (8 -0.3333333333333333 8)\n0 2 -1\n1 -1\n";
    let given = reads(odd);
    let mut plain = given.clone();
    (plain.kind, plain.cluster_of_leaf) = (PrtKind::Prt1, None);
    let mut quake3 = plain.clone();
    quake3.kind = PrtKind::Quake3;
    let rooms = rebuilt(&carved(&TWO_ROOMS).bytes(Format::Bsp29)).file;
    for file in [given, plain, quake3, rooms] {
        assert_eq!(reads(&file.to_text()), file);
    }
}

#[test]
fn a_tree_of_a_hundred_thousand_planes_in_a_row_is_walked() {
    let count = 100_000;
    for (format, turned) in [
        (Format::Bsp2, false),
        (Format::Bsp2, true),
        (Format::Ibsp46, false),
    ] {
        let mut raw = Raw {
            leafs: vec![[-2, -1]],
            ..Raw::default()
        };
        for at in 0..count {
            let side = if turned { -1.0 } else { 1.0 };
            raw.planes.push([side, 0.0, 0.0, side * at as f32]);
            raw.leafs.push([-1, -1]);
            let next = if at + 1 < count { at + 1 } else { SOLID };
            let leaf = -2 - at;
            raw.nodes
                .push((at, if turned { [leaf, next] } else { [next, leaf] }));
        }
        raw.world_leafs = count;
        let rebuilt = rebuilt(&raw.bytes(format));
        assert_eq!(rebuilt.file.cells.count(), count as u32);
        // Of Quake 3 the world is no box here, for all of its corners are 0.
        assert_eq!(rebuilt.file.cells.portals().len(), count as usize - 1);
    }
}

#[test]
fn a_map_that_makes_no_sense_is_refused() {
    let good = carved(&TWO_ROOMS);
    refused(b"PRT1\n1\n0\n", &["not a compiled map"]);
    let change = |change: &dyn Fn(&mut Raw)| {
        let mut raw = good.clone();
        change(&mut raw);
        raw
    };
    for format in FORMATS {
        let map = good.bytes(format);
        for length in [0, 3, 8, 40, map.len() - 1] {
            assert!(
                rebuild_portals_bytes(&map[..length], &ReadOptions::default()).is_err(),
                "{length}"
            );
        }
        for number in [f32::NAN, f32::INFINITY] {
            for at in [0, 3] {
                refused(
                    &change(&|raw| raw.planes[1][at] = number).bytes(format),
                    &["plane 1"],
                );
            }
        }
        refused(
            &change(&|raw| raw.nodes[2].1[0] = 1).bytes(format),
            &["node 1 is reached twice"],
        );
        refused(
            &change(&|raw| raw.nodes[3].0 = 99).bytes(format),
            &["node 3 names plane 99"],
        );
        // One leaf in two places, of which neither is solid.
        let shared = change(&|raw| {
            let solid = raw
                .nodes
                .iter_mut()
                .flat_map(|(_, children)| children)
                .find(|child| **child == SOLID);
            *solid.expect("something is solid") = -2;
        });
        refused(&shared.bytes(format), &["leaf 1 has two parent nodes"]);
    }
    refused(
        &change(&|raw| raw.world_leafs = 2).bytes(Format::Bsp2),
        &["leaf 3", "there are 3"],
    );
    refused(
        &change(&|raw| raw.world_leafs = -1).bytes(Format::Bsp29),
        &["leaf -1"],
    );
    refused(
        &change(&|raw| raw.world_leafs = 1 << 30).bytes(Format::Bsp2),
        &["leaf 1073741824"],
    );
    let mut many = good.bytes(Format::Ibsp46);
    let at = many.len() - 40 - 48;
    assert_eq!(many[at..at + 4], 2i32.to_le_bytes());
    many[at..at + 4].copy_from_slice(&(1i32 << 30).to_le_bytes());
    refused(&many, &["leaf 3 names cluster 1073741824"]);
}

#[test]
fn odd_planes_make_no_odd_portals() {
    // Nearly in the door's plane, in it from the other side, far out of the world, and so oblique that only rounding says
    // where it passes.
    let odd = [
        [1.0, 0.0, 0.0, 8.0],
        [-1.0, 0.0, 0.0, -8.0],
        [1.0, 0.0, 0.0, 8.000_001],
        [1.0, 0.0, 0.0, 1e30],
        [0.9999999, 0.0003, 0.0, 8.0],
        [0.8, 0.8, 0.8, 0.0],
    ];
    for plane in odd {
        for format in FORMATS {
            let mut raw = carved(&TWO_ROOMS);
            // Each leaf is cut once more by the plane.
            let leafs = raw.leafs.len() as i32;
            for leaf in 1..leafs {
                let node = raw.nodes.len() as i32;
                let child = raw
                    .nodes
                    .iter_mut()
                    .flat_map(|(_, children)| children)
                    .find(|child| **child == -1 - leaf);
                *child.expect("it stands somewhere") = node;
                raw.nodes
                    .push((raw.planes.len() as i32, [-1 - leaf, -1 - raw.leafs.len() as i32]));
                raw.leafs.push([-1, -1]);
            }
            raw.planes.push(plane);
            raw.world_leafs = raw.leafs.len() as i32 - 1;
            let rebuilt = rebuilt(&raw.bytes(format));
            let pairs =
                VisiblePairs::compute(&rebuilt.file.cells, &PairsOptions::default()).expect("little memory");
            assert_eq!(rebuilt.file.cells.count(), 6);
            // Some part of each room is visible from some part of the other.
            let sees = [1, 4]
                .iter()
                .any(|&a| [3, 6].iter().any(|&b| pairs.may_see(a - 1, b - 1)))
                || [1, 4]
                    .iter()
                    .any(|&a| [2, 5].iter().any(|&b| pairs.may_see(a - 1, b - 1)));
            assert!(sees, "{plane:?} {format:?}");
        }
    }
}

#[test]
fn memory_is_asked_for_before_it_is_taken() {
    let map = carved(&TWO_ROOMS).bytes(Format::Bsp2);
    for limit_bytes in [0, 1000, map.len() as u64 * 7 + 100] {
        let options = ReadOptions {
            limit_bytes,
            ..ReadOptions::default()
        };
        let error = rebuild_portals_bytes(&map, &options).expect_err("too little");
        assert!(error.to_string().contains("above the limit"), "{error}");
    }
}
