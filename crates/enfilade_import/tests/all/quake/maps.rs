//! Real maps, in the folder that `ENFILADE_MAPS` names: the smaller ones of each format, and all lines of sight that
//! compilers are known to have missed.

use enfilade_bake::{Cells, FlowPart, PairsOptions, PairsWork, Shard, Stage, VisiblePairs, find_missing};
use enfilade_import::{
    BspError, PlacedPortals, PortalFile, PrtKind, ReadOptions, place_portals, read_portals,
};
use std::path::PathBuf;

pub(crate) fn maps() -> PathBuf {
    let folder = std::env::var_os("ENFILADE_MAPS");
    folder.expect("ENFILADE_MAPS names a folder of maps").into()
}

#[track_caller]
pub(crate) fn read(folder: &std::path::Path, name: &str) -> PortalFile {
    let read = read_portals(&folder.join(name), &ReadOptions::default());
    read.unwrap_or_else(|error| panic!("{error}"))
}

pub(crate) fn pairs_of(file: &PortalFile) -> VisiblePairs {
    VisiblePairs::compute(&file.cells, &PairsOptions::default()).expect("little memory")
}

#[test]
#[ignore = "needs ENFILADE_MAPS"]
fn a_map_is_the_same_in_each_format() {
    let folder = maps();
    for (plain, other, kind) in [
        ("prt1/dm1.prt", "quake/dm1.prt", PrtKind::Prt2),
        ("prt1/q3_darkzone.prt", "quake3/darkzone.prt", PrtKind::Quake3),
    ] {
        let [plain, other] = [plain, other].map(|name| read(&folder, name));
        assert_eq!(plain.kind, PrtKind::Prt1);
        assert_eq!(other.kind, kind);
        assert_eq!(plain.cells.count(), other.cells.count());
        assert_eq!(plain.cells.portals(), other.cells.portals());
    }
}

#[test]
#[ignore = "needs ENFILADE_MAPS"]
fn every_file_of_portals_is_read() {
    let folder = maps();
    let mut count = 0;
    for kind in ["prt1", "quake", "quake3"] {
        for entry in std::fs::read_dir(folder.join(kind)).expect("a folder") {
            let path = entry.expect("an entry").path();
            if path.extension().is_some_and(|ending| ending == "prt") {
                read_portals(&path, &ReadOptions::default()).unwrap_or_else(|error| panic!("{error}"));
                count += 1;
            }
        }
    }
    assert!(count > 0, "no .prt is there");
}

#[test]
#[ignore = "needs ENFILADE_MAPS"]
fn lines_of_sight_that_compilers_missed_are_in_the_pairs() {
    let folder = maps();
    let mut witnesses = 0;
    for entry in std::fs::read_dir(folder.join("witness")).expect("a folder") {
        let path = entry.expect("an entry").path();
        let name = path.file_stem().expect("a name").to_string_lossy();
        let pairs = pairs_of(&read(&folder, &format!("prt1/{name}.prt")));
        for line in std::fs::read_to_string(&path).expect("text").lines() {
            let (_, chain) = line.rsplit_once("clusters: ").expect("a chain");
            let chain: Vec<u32> = chain
                .split_whitespace()
                .map(|word| word.parse().expect("a number"))
                .collect();
            let (from, to) = (chain[0], chain[chain.len() - 1]);
            assert!(
                pairs.may_see(from, to) && pairs.may_see(to, from),
                "{name}: {line}"
            );
            witnesses += 1;
        }
    }
    assert!(witnesses > 0, "no witness is there");
}

#[test]
#[ignore = "needs ENFILADE_MAPS"]
fn no_random_line_through_a_map_shows_a_pair_that_is_missing() {
    let folder = maps();
    // As many pairs as have been found before, or fewer: more would be a bound that has become looser.
    for (name, most) in [
        ("dm1", 33_746),
        ("end", 35_024),
        ("lq_e0m1", 36_316),
        ("q3_darkzone", 64_390),
    ] {
        let file = read(&folder, &format!("prt1/{name}.prt"));
        let pairs = pairs_of(&file);
        assert!(pairs.count() <= most, "{name}: {} pairs", pairs.count());
        assert!(
            pairs.proven() * 100 >= pairs.count() * 95,
            "{name}: {} proven",
            pairs.proven()
        );
        let missing = find_missing(&file.cells, &pairs, 300_000, 1);
        assert!(missing.is_none(), "{name}: {}", missing.expect("some"));
    }
}

#[test]
#[ignore = "needs ENFILADE_MAPS"]
fn shards_of_a_map_merge_to_the_pairs_of_one_run() {
    const LIMIT: u64 = 1 << 32;
    let folder = maps();
    let run_to = |mut work: PairsWork, end: Stage| {
        while work.stage() < end {
            work.step();
        }
        work
    };
    for (name, count) in [("dm1", 7), ("e1m1", 3), ("q3_accident", 3), ("lqdm13", 2)] {
        let file = read(&folder, &format!("prt1/{name}.prt"));
        let one = pairs_of(&file);
        let work = PairsWork::begin(&file.cells, LIMIT).expect("little memory");
        let mut work = run_to(work, Stage::Flow);
        for index in 0..count {
            let shard = Shard::new(index, count).expect("a shard");
            let part = PairsWork::begin(&file.cells, LIMIT).expect("little memory");
            let part = part.with_shard(shard).expect("the flow has not begun");
            let part = run_to(part, Stage::Backflow).save_part().expect("it is over");
            let part = FlowPart::from_bytes(&file.cells, &part).expect("a part");
            work.add_part(part).expect("of the same start");
        }
        let merged = run_to(work, Stage::Done).pairs();
        let is_same = (0..one.cell_count()).all(|cell| one.seen_from(cell).eq(merged.seen_from(cell)));
        assert!(
            is_same,
            "{name}: {} pairs, {} in one run",
            merged.count(),
            one.count()
        );
    }
}

#[test]
#[ignore = "needs ENFILADE_MAPS"]
fn portals_are_known_to_be_those_of_their_map() {
    let folder = maps();
    let map = |name: &str| std::fs::read(folder.join(name)).expect("a map");
    for name in ["dm1", "end", "e1m1", "lq_e4m4", "lqdm13"] {
        let portals = read(&folder, &format!("quake/{name}.prt"));
        let placed = place_portals(&map(&format!("quake/{name}.bsp")), &portals);
        let PlacedPortals { leafs, in_place } = placed.unwrap_or_else(|error| panic!("{name} {error}"));
        let fit = in_place.iter().filter(|&&fit| fit).count();
        assert!(
            fit * 100 >= in_place.len() * 95,
            "{name}: {fit} of {}",
            in_place.len()
        );
        let all = portals.cluster_of_leaf.as_ref().map_or(0, Vec::len);
        assert_eq!(leafs.iter().sum::<u32>() as usize, all, "{name}");
    }
    for name in ["darkzone", "accident", "final_rage"] {
        let portals = read(&folder, &format!("quake3/{name}.prt"));
        let placed = place_portals(&map(&format!("quake3/{name}.novis.bsp")), &portals);
        placed.unwrap_or_else(|error| panic!("{name} {error}"));
    }
    let dm1 = map("quake/dm1.bsp");
    let other = place_portals(&dm1, &read(&folder, "quake/end.prt"));
    assert!(matches!(other, Err(BspError::OtherMap { .. })), "{other:?}");
    // A map with as many leafs that stands elsewhere.
    let mut portals = read(&folder, "quake/dm1.prt");
    let moved = portals.cells.portals().iter().cloned().map(|mut portal| {
        portal.corners.iter_mut().for_each(|corner| corner[0] += 300.0);
        portal
    });
    portals.cells = Cells::new(portals.cells.count(), moved.collect()).expect("only moved");
    let other = place_portals(&dm1, &portals);
    assert!(matches!(other, Err(BspError::OtherPlaces { .. })), "{other:?}");
}
