//! The flow split into shards, and merged.

use crate::{pairs_of, worlds};
use enfilade_bake::{Cells, FlowPart, PairsWork, PartError, Shard, Stage, VisiblePairs};

const LIMIT: u64 = 1 << 30;

fn shard(index: u32, count: u32) -> Shard {
    Shard::new(index, count).expect("a shard")
}

fn run_to(work: &mut PairsWork, end: Stage) {
    while work.stage() < end {
        work.step();
    }
}

fn begin_shard(cells: &Cells, shard: Shard) -> PairsWork {
    let work = PairsWork::begin(cells, LIMIT).expect("within the memory limit");
    work.with_shard(shard).expect("the flow has not begun")
}

/// Computes a part.
fn part(cells: &Cells, shard: Shard) -> Vec<u8> {
    let mut work = begin_shard(cells, shard);
    run_to(&mut work, Stage::Backflow);
    work.save_part().expect("it is over")
}

fn parts(cells: &Cells, count: u32) -> Vec<Vec<u8>> {
    (0..count).map(|index| part(cells, shard(index, count))).collect()
}

/// Returns work at the beginning of the flow, with the parts.
fn begun<'a>(cells: &Cells, parts: impl IntoIterator<Item = &'a Vec<u8>>) -> PairsWork {
    let mut work = PairsWork::begin(cells, LIMIT).expect("within the memory limit");
    run_to(&mut work, Stage::Flow);
    for bytes in parts {
        let part = FlowPart::from_bytes(cells, bytes).expect("a part");
        work.add_part(part).expect("of the same start");
    }
    work
}

fn merged<'a>(cells: &Cells, parts: impl IntoIterator<Item = &'a Vec<u8>>) -> VisiblePairs {
    let mut work = begun(cells, parts);
    run_to(&mut work, Stage::Done);
    work.pairs()
}

/// Whether both hold the same pairs. The number of pairs proven by a ray may differ.
fn same(a: &VisiblePairs, b: &VisiblePairs) -> bool {
    (0..a.cell_count()).all(|cell| a.seen_from(cell).eq(b.seen_from(cell)))
}

#[test]
fn any_number_of_shards_in_any_order_gives_the_pairs_of_one_run() {
    let mut dropped = 0;
    for seed in 600..612 {
        let cells = worlds::random(seed, 60);
        let one = pairs_of(&cells);
        for count in [1, 2, 3, 7, 40] {
            let mut parts = parts(&cells, count);
            assert!(
                same(&merged(&cells, &parts), &one),
                "world {seed}, {count} shards"
            );
            parts.reverse();
            assert!(
                same(&merged(&cells, &parts), &one),
                "world {seed}, {count} shards reversed"
            );
        }
        dropped += begun(&cells, []).pairs().count() - one.count();
    }
    assert!(dropped > 30, "the flow drops only {dropped} pairs");
}

/// Returns the bit rows of saved work: the bound, the known pairs, and what the stage keeps besides.
fn saved_rows(work: &PairsWork) -> [Vec<u64>; 3] {
    let saved = work.save();
    let words: Vec<u64> = saved
        .as_chunks()
        .0
        .iter()
        .map(|&word| u64::from_le_bytes(word))
        .collect();
    let [ways, cells] = [words[4], words[5]].map(|count| count as usize);
    let mut rest = &words[9..];
    let third = if work.stage() == Stage::Flow { cells } else { ways };
    [ways, cells, third].map(|size| {
        let whole = rest;
        // A word whose bits mark the nonzero words that follow, of each 64.
        for _ in 0..(size * size.div_ceil(64)).div_ceil(64) {
            rest = &rest[1 + rest[0].count_ones() as usize..];
        }
        whole[..whole.len() - rest.len()].to_vec()
    })
}

#[test]
fn the_rays_that_shards_find_change_none_of_the_bounds() {
    let mut more_rays = 0;
    // In the last two, chains that other ways keep going would reach ways that the planes exclude.
    for (seed, size) in [(650, 60), (651, 60), (652, 60), (1017, 250), (1041, 250)] {
        let cells = worlds::random(seed, size);
        let mut work = begun(&cells, &parts(&cells, 3));
        let mut one = begun(&cells, []);
        let mut is_back = false;
        while one.stage() != Stage::Done {
            assert_eq!(work.stage(), one.stage());
            let ([bound, known, kept], [bound_of_one, known_of_one, kept_of_one]) =
                (saved_rows(&work), saved_rows(&one));
            assert!(
                one.stage() != Stage::Flow || bound == bound_of_one,
                "world {seed}: the bound of the flow"
            );
            assert!(kept == kept_of_one, "world {seed}: what {:?} keeps", one.stage());
            more_rays += usize::from(known != known_of_one);
            if one.stage() == Stage::Backflow && !is_back {
                assert!(bound == bound_of_one, "world {seed}: the bound after the flow");
                is_back = true;
            }
            work.step();
            one.step();
        }
        assert!(same(&work.pairs(), &one.pairs()), "world {seed}");
    }
    assert!(more_rays > 10, "the shards have found other rays");
}

#[test]
fn some_of_the_parts_save_some_of_the_work_and_change_nothing() {
    let cells = worlds::random(641, 90);
    let one = pairs_of(&cells);
    let parts = parts(&cells, 3);
    assert!(same(&merged(&cells, &parts[1..2]), &one));
    assert!(same(&merged(&cells, [&parts[0], &parts[0], &parts[2]]), &one));
    // Parts of runs with different numbers of shards.
    let other = part(&cells, shard(1, 2));
    assert!(same(&merged(&cells, [&parts[0], &other]), &one));
}

#[test]
fn a_shard_and_a_merge_that_are_stopped_anywhere_end_like_others() {
    let cells = worlds::random(5, 90);
    let whole = part(&cells, shard(1, 3));
    let one = pairs_of(&cells);
    let parts = parts(&cells, 3);
    let mut stages = Vec::new();
    for steps in 0.. {
        let mut work = begin_shard(&cells, shard(1, 3));
        (0..steps).for_each(|_| work.step());
        if work.stage() == Stage::Backflow {
            break;
        }
        assert_eq!(work.save_part(), None, "too early");
        stages.push(work.stage());
        for passages in [work.save_passages(), Vec::new()] {
            let mut resumed =
                PairsWork::resume(&cells, LIMIT, &work.save(), &passages).expect("saved for these cells");
            assert_eq!(resumed.shard(), Some(shard(1, 3)));
            run_to(&mut resumed, Stage::Backflow);
            let is_same = resumed.save_part().as_ref() == Some(&whole);
            assert!(is_same, "stopped after {steps} steps");
        }
    }
    assert!(stages.contains(&Stage::Flow) && stages.contains(&Stage::Sampling));
    for steps in 0..10 {
        let mut work = begun(&cells, &parts);
        (0..steps).for_each(|_| work.step());
        let mut resumed = PairsWork::resume(&cells, LIMIT, &work.save(), &[]).expect("saved for these cells");
        assert_eq!(resumed.shard(), None);
        for part in &parts {
            let part = FlowPart::from_bytes(&cells, part).expect("a part");
            resumed.add_part(part).expect("of the same start");
        }
        run_to(&mut resumed, Stage::Done);
        assert!(
            same(&resumed.pairs(), &one),
            "stopped {steps} steps after the beginning of the flow"
        );
    }
}

#[test]
fn shards_that_begin_with_saved_work_give_the_same_parts() {
    let cells = worlds::random(643, 90);
    let start = begun(&cells, []);
    let (saved, passages) = (start.save(), start.save_passages());
    assert_eq!(
        (&saved, &passages),
        (&begun(&cells, []).save(), &start.save_passages())
    );
    for (number, whole) in parts(&cells, 3).into_iter().enumerate() {
        // Without the passages they are computed again.
        for passages in [passages.clone(), Vec::new()] {
            let work = PairsWork::resume(&cells, LIMIT, &saved, &passages).expect("saved for these cells");
            let mut work = work
                .with_shard(shard(number as u32, 3))
                .expect("the flow has not begun");
            run_to(&mut work, Stage::Backflow);
            assert!(work.save_part() == Some(whole.clone()), "shard {number}");
        }
    }
    let mut work = start;
    work.step();
    assert!(work.with_shard(shard(0, 3)).is_none(), "the flow has begun");
}

#[test]
fn parts_bring_the_rays_that_the_shards_found() {
    // Without the parts, the rays that the flow finds are not known at its beginning.
    let cells = worlds::random(642, 90);
    let parts = parts(&cells, 2);
    let [with, without] = [begun(&cells, &parts), begun(&cells, [])].map(|work| work.pairs().proven());
    assert!(with > without, "{with} pairs proven, {without} without the parts");
}

#[test]
fn a_part_with_any_byte_changed_or_of_other_cells_is_refused() {
    let cells = worlds::random(11, 12);
    let bytes = part(&cells, shard(1, 2));
    let refused = |cells: &Cells, bytes: &[u8]| FlowPart::from_bytes(cells, bytes).expect_err("refused");
    assert_eq!(refused(&worlds::random(12, 12), &bytes), PartError::Other);
    assert_eq!(refused(&cells, b""), PartError::Foreign);
    assert_eq!(refused(&cells, b"PRT1 and so on"), PartError::Foreign);
    let saved = PairsWork::begin(&cells, LIMIT).expect("within the limit").save();
    assert_eq!(refused(&cells, &saved), PartError::Foreign);
    for length in 8..bytes.len() {
        assert_eq!(refused(&cells, &bytes[..length]), PartError::Damaged);
    }
    for at in 0..bytes.len() {
        let mut changed = bytes.clone();
        changed[at] ^= 1 << (at % 8);
        refused(&cells, &changed);
    }
    let part = FlowPart::from_bytes(&cells, &bytes).expect("a part");
    assert_eq!(part.shard(), shard(1, 2));
    let mut work = PairsWork::begin(&cells, LIMIT).expect("within the limit");
    assert_eq!(
        work.add_part(part),
        Err(PartError::OtherStart),
        "the flow has not begun"
    );
}

#[test]
fn a_shard_is_one_of_those_there_are() {
    assert_eq!(Shard::new(2, 2), None);
    assert_eq!(Shard::new(0, 0), None);
    let third = shard(2, 3);
    assert_eq!(
        (third.index(), third.count(), third.to_string()),
        (2, 3, "2/3".to_owned())
    );
    assert_eq!(
        (0..9).filter(|&number| third.has(number)).collect::<Vec<_>>(),
        [2, 5, 8]
    );
}
