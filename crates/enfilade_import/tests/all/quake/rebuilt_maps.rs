//! Compares the portals rebuilt from real maps with those of the map compilers.
//!
//! Maps of Quake do not say which leafs are one cluster until what is visible is written into them, so that is done first,
//! as if each cluster saw itself alone.

use super::located::Located;
use super::maps::{maps, pairs_of, read};
use super::outline::{common_area, normal, out_of, points};
use enfilade_bake::{Cells, PairsOptions, Portal, VisiblePairs, find_missing};
use enfilade_import::{
    ClustersFrom, PortalFile, ReadOptions, RebuiltPortals, place_portals, rebuild_portals_bytes,
    with_visibility,
};
use std::collections::HashMap;
use std::path::Path;

/// Farther apart than this, in units, two portals are not the same: half of what compilers take for nothing.
const SAME: f64 = 0.1;

/// How the rebuilt portals of a map compare with the compiler's.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
struct Compared {
    /// One and the same, to a tenth of a unit.
    same: usize,
    /// Less, for the compiler's also leads into a wall that its author had said not to part leafs.
    walled: usize,
    /// None, for all of the compiler's leads into such walls.
    wall: usize,
    /// Less, for the compiler's also leads into others' leafs: it lets go what is thinner than 0.2.
    beside: usize,
    /// Those that the compiler did not have.
    extra: usize,
}

const MAPS: [(&str, [usize; 5]); 13] = [
    ("quake/dm1", [983, 0, 0, 0, 0]),
    ("quake/end", [968, 0, 0, 0, 0]),
    ("quake/lq_e0m1", [1336, 0, 0, 0, 0]),
    ("quake/lqdm13", [1857, 28, 0, 0, 0]),
    ("quake/e1m1", [3062, 0, 0, 0, 0]),
    ("quake/start", [3111, 4, 0, 0, 0]),
    ("quake/lq_e1m5", [3520, 171, 11, 27, 8]),
    ("quake/lq_e4m4", [8911, 278, 61, 27, 19]),
    ("quake3/darkzone", [1512, 0, 0, 0, 0]),
    ("quake3/stormkeep", [2124, 0, 0, 1, 1]),
    ("quake3/aneurysm", [2068, 0, 0, 0, 0]),
    ("quake3/accident", [3604, 0, 0, 0, 0]),
    ("quake3/final_rage", [6958, 0, 0, 0, 0]),
];

fn map_of(folder: &Path, name: &str) -> Vec<u8> {
    let ending = if name.starts_with("quake3") {
        ".novis.bsp"
    } else {
        ".bsp"
    };
    std::fs::read(folder.join(format!("{name}{ending}"))).expect("a map")
}

#[track_caller]
fn rebuilt(map: &[u8]) -> RebuiltPortals {
    rebuild_portals_bytes(map, &ReadOptions::default()).unwrap_or_else(|error| panic!("{error}"))
}

/// A map of Quake with its clusters in it.
fn with_clusters(map: &[u8], given: &PortalFile) -> Vec<u8> {
    let alone = Cells::new(given.cells.count(), Vec::new()).expect("cells");
    let pairs = VisiblePairs::compute(
        &alone,
        &PairsOptions {
            fast: true,
            ..PairsOptions::default()
        },
    )
    .expect("little memory");
    with_visibility(map, given, &pairs).expect("written")
}

/// Returns the compiler's portals, the map with its clusters in it, and the rebuilt portals.
fn both(folder: &Path, name: &str) -> (PortalFile, Vec<u8>, RebuiltPortals) {
    let given = read(folder, &format!("{name}.prt"));
    let mut map = map_of(folder, name);
    if name.starts_with("quake/") {
        map = with_clusters(&map, &given);
    }
    let rebuilt = rebuilt(&map);
    (given, map, rebuilt)
}

fn between(portal: &Portal) -> [u32; 2] {
    let mut cells = portal.cells;
    cells.sort_unstable();
    cells
}

/// The clusters on both sides of a point in a portal, so far off it; `None` for what is solid.
fn sides(
    map: &Located,
    cluster: &dyn Fn(usize) -> Option<u32>,
    portal: &Portal,
    point: [f64; 3],
    off: f64,
) -> [Option<u32>; 2] {
    let up = normal(&portal.corners);
    let side = |off: f64| cluster(map.leaf([0, 1, 2].map(|axis| point[axis] + up[axis] * off)));
    [side(-off), side(off)]
}

/// The cluster of a leaf of a map, as its rebuilt portals have it.
fn cluster_of(map: &[u8], rebuilt: &RebuiltPortals) -> impl Fn(usize) -> Option<u32> {
    let of_leaf: Vec<Option<u32>> = if rebuilt.clusters_from == ClustersFrom::Map {
        let leafs = &map[super::rows::lump(map, 4)];
        let cluster = |leaf: &[u8]| u32::try_from(super::rows::word(leaf, 0) as i32).ok();
        leafs.chunks_exact(48).map(cluster).collect()
    } else {
        let clusters = match &rebuilt.file.cluster_of_leaf {
            Some(clusters) => clusters.clone(),
            None => (0..rebuilt.file.cells.count()).collect(),
        };
        std::iter::once(None)
            .chain(clusters.into_iter().map(Some))
            .collect()
    };
    move |leaf| of_leaf.get(leaf).copied().flatten()
}

#[test]
#[allow(clippy::print_stderr, reason = "a table to be read")]
#[ignore = "needs ENFILADE_MAPS"]
fn rebuilt_portals_are_those_of_the_compiler() {
    let folder = maps();
    let mut wrong = Vec::new();
    for (name, [same, walled, wall, beside, extra]) in MAPS {
        let (given, map, rebuilt) = both(&folder, name);
        assert_eq!(rebuilt.file.cells.count(), given.cells.count(), "{name}");
        assert_eq!(rebuilt.file.cluster_of_leaf, given.cluster_of_leaf, "{name}");
        assert_eq!(rebuilt.file.kind, given.kind, "{name}");
        let wanted = Compared {
            same,
            walled,
            wall,
            beside,
            extra,
        };
        let compared = compare(&given, &map, &rebuilt);
        eprintln!(
            "{name}: {compared:?} of {}, {} slivers",
            given.cells.portals().len(),
            rebuilt.slivers
        );
        if compared != wanted {
            wrong.push(name);
        }
    }
    assert!(wrong.is_empty(), "{wrong:?}");
}

fn compare(given: &PortalFile, map: &[u8], rebuilt: &RebuiltPortals) -> Compared {
    let located = Located::new(map);
    let cluster = cluster_of(map, rebuilt);
    let mut ours: HashMap<[u32; 2], Vec<&Portal>> = HashMap::new();
    for portal in rebuilt.file.cells.portals() {
        ours.entry(between(portal)).or_default().push(portal);
    }
    let mut compared = Compared::default();
    for portal in given.cells.portals() {
        let some = ours.entry(between(portal)).or_default();
        let shared = |at: &usize| common_area(&some[*at].corners, &portal.corners);
        let best = (0..some.len()).max_by(|a, b| shared(a).total_cmp(&shared(b)));
        let best = best.map(|at| some.swap_remove(at));
        let is_far = |from: &Portal, other: &Portal| {
            let outs = from.corners.iter().map(|&corner| out_of(corner, &other.corners));
            outs.fold(0.0, f64::max) > SAME
        };
        if let Some(best) = best {
            assert!(
                !is_far(best, portal),
                "larger by more than rounding: {best:?}, {portal:?}"
            );
            if !is_far(portal, best) {
                let turned = if best.cells == portal.cells { 1.0 } else { -1.0 };
                let [a, b] = [best, portal].map(|portal| normal(&portal.corners));
                assert!((0..3).map(|axis| a[axis] * b[axis]).sum::<f64>() * turned > 0.99);
                compared.same += 1;
                continue;
            }
        }
        // What the compiler has more.
        let missing = points(&portal.corners);
        let missing = missing
            .into_iter()
            .filter(|&point| best.is_none_or(|best| out_of(point, &best.corners) > 0.02));
        let missing: Vec<_> = missing
            .map(|point| sides(&located, &cluster, portal, point, 0.01))
            .collect();
        let is_wall = missing.iter().any(|sides| sides.contains(&None));
        match (best, is_wall) {
            (Some(_), true) => compared.walled += 1,
            (None, true) => compared.wall += 1,
            (_, false) => compared.beside += 1,
        }
    }
    compared.extra = ours.values().map(Vec::len).sum();
    compared
}

/// The law of a rebuilt map: wherever light passes from one cluster into another, there is a portal.
#[test]
#[ignore = "needs ENFILADE_MAPS"]
fn wherever_two_clusters_touch_there_is_a_portal() {
    let folder = maps();
    for (name, _) in MAPS {
        let (given, map, rebuilt) = both(&folder, name);
        holds_every_hole(name, &given, &map, &rebuilt);
        let plain = map_of(&folder, name);
        let each_leaf = self::rebuilt(&plain);
        holds_every_hole(name, &given, &plain, &each_leaf);
    }
}

fn holds_every_hole(name: &str, given: &PortalFile, map: &[u8], rebuilt: &RebuiltPortals) {
    let located = Located::new(map);
    let cluster = cluster_of(map, rebuilt);
    let mut ours: HashMap<[u32; 2], Vec<&Portal>> = HashMap::new();
    for portal in rebuilt.file.cells.portals() {
        ours.entry(between(portal)).or_default().push(portal);
    }
    let mut asked = 0;
    for portal in given.cells.portals() {
        for point in points(&portal.corners) {
            let [near, middle, far] =
                [0.0002, 0.002, 0.02].map(|off| sides(&located, &cluster, portal, point, off));
            let [Some(a), Some(b)] = near else { continue };
            // Beside another plane the two may be parted by a third that is thin.
            if a == b || near != middle || near != far {
                continue;
            }
            asked += 1;
            let some = ours.get(&[a.min(b), a.max(b)]).map_or(&[][..], Vec::as_slice);
            let is_there = some.iter().any(|ours| out_of(point, &ours.corners) < 0.05);
            assert!(
                is_there,
                "{name}: no portal between {a} and {b} at {point:?}, in {portal:?}: {some:?}"
            );
        }
    }
    assert!(asked > 10_000, "{name}: {asked} points");
}

/// The pairs that differ depend on slits of less than a thousandth of a unit: the rebuilt portals are larger by that
/// much, and the compiler's corners are off by that much. No line of sight proves a missing pair.
#[test]
#[ignore = "needs ENFILADE_MAPS"]
fn what_is_visible_through_rebuilt_portals_is_what_is_through_the_compilers() {
    let folder = maps();
    for (name, less, more) in [
        ("quake/dm1", 8, 68),
        ("quake/end", 8, 158),
        ("quake/lq_e0m1", 6, 162),
        ("quake3/darkzone", 14, 202),
    ] {
        let (given, map, rebuilt) = both(&folder, name);
        assert!(place_portals(&map, &rebuilt.file).is_ok(), "{name}");
        let [theirs, ours] = [&given, &rebuilt.file].map(pairs_of);
        let all = || (0..given.cells.count()).flat_map(|a| (0..given.cells.count()).map(move |b| (a, b)));
        let has_less = all()
            .filter(|&(a, b)| theirs.may_see(a, b) && !ours.may_see(a, b))
            .count();
        let has_more = all()
            .filter(|&(a, b)| ours.may_see(a, b) && !theirs.may_see(a, b))
            .count();
        assert!(
            has_less <= less && has_more <= more,
            "{name}: {has_less} less, {has_more} more"
        );
        for cells in [&rebuilt.file.cells, &given.cells] {
            let missing = find_missing(cells, &ours, 1_000_000, 3);
            assert!(missing.is_none(), "{name}: {}", missing.expect("some"));
        }
    }
}

#[test]
#[ignore = "needs ENFILADE_MAPS"]
fn what_is_visible_in_a_map_tells_its_clusters_and_where_it_does_not_each_leaf_is_one() {
    let folder = maps();
    // Clusters side by side that see the same share a row, and are one afterwards.
    for (name, least) in [("quake/dm1", 402), ("quake/end", 355), ("quake/lq_e0m1", 515)] {
        let (given, map, rebuilt) = both(&folder, name);
        let pairs = pairs_of(&rebuilt.file);
        let written = with_visibility(&map, &rebuilt.file, &pairs).expect("written");
        let again = self::rebuilt(&written);
        assert_eq!(again.clusters_from, ClustersFrom::Rows);
        let count = again.file.cells.count();
        assert!((least..=given.cells.count()).contains(&count), "{name}: {count}");
        let pairs = pairs_of(&again.file);
        assert!(with_visibility(&written, &again.file, &pairs).is_ok());
        let plain = map_of(&folder, name);
        let leafs = self::rebuilt(&plain);
        assert_eq!(leafs.clusters_from, ClustersFrom::Leafs);
        assert_eq!(leafs.leafs, leafs.file.cells.count());
        let pairs = pairs_of(&leafs.file);
        assert!(with_visibility(&plain, &leafs.file, &pairs).is_ok());
        let missing = find_missing(&leafs.file.cells, &pairs, 300_000, 4);
        assert!(missing.is_none(), "{name}: {}", missing.expect("some"));
    }
}

#[test]
#[ignore = "needs ENFILADE_MAPS"]
fn lines_of_sight_that_compilers_missed_are_seen_through_rebuilt_portals() {
    let folder = maps();
    let mut witnesses = 0;
    for (name, witness) in [
        ("quake/e1m1", "e1m1"),
        ("quake/start", "start"),
        ("quake/lqdm13", "lqdm13"),
        ("quake3/aneurysm", "q3_aneurysm"),
        ("quake3/stormkeep", "q3_stormkeep"),
    ] {
        let (_, _, rebuilt) = both(&folder, name);
        // The hard one takes half a minute for what its first bound shows as well.
        let options = PairsOptions {
            fast: name.ends_with("lqdm13"),
            ..PairsOptions::default()
        };
        let pairs = VisiblePairs::compute(&rebuilt.file.cells, &options).expect("little memory");
        let lines = std::fs::read_to_string(folder.join(format!("witness/{witness}.txt"))).expect("text");
        for line in lines.lines() {
            let (_, chain) = line.rsplit_once("clusters: ").expect("a chain");
            let mut chain = chain
                .split_whitespace()
                .map(|word| word.parse::<u32>().expect("a number"));
            let (Some(from), Some(to)) = (chain.next(), chain.next_back()) else {
                panic!("{line}")
            };
            assert!(
                pairs.may_see(from, to) && pairs.may_see(to, from),
                "{name}: {line}"
            );
            witnesses += 1;
        }
    }
    assert_eq!(witnesses, 23);
}
