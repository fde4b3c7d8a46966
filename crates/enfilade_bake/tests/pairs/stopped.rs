//! Work that reports progress, stops, is saved and resumed.

use crate::{pairs_of, worlds};
use enfilade_bake::{Cells, PairsOptions, PairsWork, ResumeError, Stage, VisiblePairs};
use std::collections::BTreeSet;

const LIMIT: u64 = 1 << 30;

fn begin(cells: &Cells) -> PairsWork {
    PairsWork::begin(cells, LIMIT).expect("within the memory limit")
}

/// Saves work and its passages after `steps` steps.
fn saved_after(cells: &Cells, steps: usize) -> [Vec<u8>; 2] {
    let mut work = begin(cells);
    for _ in 0..steps {
        work.step();
    }
    [work.save(), work.save_passages()]
}

#[test]
fn at_every_moment_all_that_is_seen_is_in_the_pairs() {
    let cells = worlds::random(3, 90);
    let end = pairs_of(&cells);
    let mut work = begin(&cells);
    let mut before = u64::MAX;
    let mut stages = vec![work.stage()];
    while work.stage() != Stage::Done {
        let pairs = work.pairs();
        for from in 0..cells.count() {
            assert!(
                end.seen_from(from).all(|to| pairs.may_see(from, to)),
                "{:?}",
                work.stage()
            );
        }
        assert!(pairs.count() as u64 <= before, "the bound never grows");
        assert!(pairs.proven() <= end.count());
        before = pairs.count() as u64;
        let (stage, share) = (work.stage(), work.share());
        work.step();
        if work.stage() == stage {
            assert!((share..=1.0).contains(&work.share()), "{stage:?} goes forward");
        } else {
            stages.push(work.stage());
        }
    }
    assert_eq!(stages[..stages.len() - 1], Stage::ALL);
    assert_eq!(work.pairs(), end);
    assert_eq!(work.share(), 1.0);
    work.step();
    assert_eq!(work.pairs(), end, "a step after the end changes nothing");
}

#[test]
fn work_that_was_stopped_anywhere_ends_like_work_that_was_not() {
    // More ways than one step handles in any stage.
    let cells = worlds::random(5, 90);
    let end = pairs_of(&cells);
    let mut stages = BTreeSet::new();
    for steps in 0.. {
        let [saved, passages] = saved_after(&cells, steps);
        let mut work = PairsWork::resume(&cells, LIMIT, &saved, &passages).expect("saved for these cells");
        let stage = work.stage();
        stages.insert(stage);
        assert_eq!(work.save(), saved, "it is where it was after {steps} steps");
        assert_eq!(work.save_passages(), passages);
        while work.stage() != Stage::Done {
            work.step();
        }
        assert_eq!(work.pairs(), end, "stopped after {steps} steps");
        if stage == Stage::Done {
            break;
        }
    }
    assert_eq!(stages.len(), 7, "{stages:?}");
}

#[test]
fn work_whose_passages_are_lost_or_older_ends_like_work_that_was_not_stopped() {
    let cells = worlds::random(5, 90);
    let end = pairs_of(&cells);
    let [_, older] = saved_after(&cells, 3);
    for steps in 0..12 {
        let [saved, passages] = saved_after(&cells, steps);
        let damaged = &passages[..passages.len() - 8];
        for passages in [&[], damaged, &older, b"something else"] {
            let mut work = PairsWork::resume(&cells, LIMIT, &saved, passages).expect("saved for these cells");
            while work.stage() != Stage::Done {
                work.step();
            }
            assert_eq!(work.pairs(), end, "stopped after {steps} steps");
        }
    }
}

#[test]
fn saved_work_of_other_cells_or_with_any_byte_changed_is_refused() {
    let cells = worlds::random(11, 12);
    for steps in [1, 5] {
        let [saved, passages] = saved_after(&cells, steps);
        let refused = |cells: &Cells, bytes: &[u8]| {
            PairsWork::resume(cells, LIMIT, bytes, &passages).expect_err("refused")
        };
        assert_eq!(refused(&worlds::random(12, 12), &saved), ResumeError::Other);
        assert_eq!(refused(&cells, b""), ResumeError::Foreign);
        assert_eq!(refused(&cells, b"PRT1 and so on"), ResumeError::Foreign);
        assert_eq!(refused(&cells, &passages), ResumeError::Foreign);
        for length in 8..saved.len() {
            assert_eq!(refused(&cells, &saved[..length]), ResumeError::Damaged);
        }
        for at in 0..saved.len() {
            let mut bytes = saved.clone();
            bytes[at] ^= 1 << (at % 8);
            refused(&cells, &bytes);
        }
    }
}

#[test]
fn work_that_would_take_too_much_is_refused_before_it_begins() {
    let many = Cells::new(u32::MAX, Vec::new()).expect("no portal is wrong");
    let refused = PairsWork::begin(&many, LIMIT).expect_err("four billion squared exceeds the limit");
    assert!(refused.needs_bytes > 1 << 60, "{refused}");
    let refused = VisiblePairs::compute(&many, &PairsOptions::default()).expect_err("the same limit");
    assert!(refused.needs_bytes > 1 << 60, "{refused}");
    let cells = worlds::random(2, 60);
    let needs = PairsWork::begin(&cells, 0)
        .expect_err("no memory allowed")
        .needs_bytes;
    assert!(PairsWork::begin(&cells, needs).is_ok());
}
