//! Work that is watched, stopped, saved and gone on with.

use crate::{pairs_of, worlds};
use enfilade_bake::{Cells, PairsOptions, PairsWork, ResumeError, Stage, VisiblePairs};

const LIMIT: u64 = 1 << 30;

fn begin(cells: &Cells) -> PairsWork {
    PairsWork::begin(cells, LIMIT).expect("little memory")
}

/// Steps on until `save` gives something, and `steps` steps more.
fn saved_after(cells: &Cells, steps: usize) -> Vec<u8> {
    let mut work = begin(cells);
    while work.save().is_none() {
        work.step();
    }
    for _ in 0..steps {
        work.step();
    }
    work.save().expect("the fast bound is passed")
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
                end.seen_from(from).all(|to| pairs.sees(from, to)),
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
    let cells = worlds::random(5, 90);
    let end = pairs_of(&cells);
    let mut steps = 0;
    loop {
        let saved = saved_after(&cells, steps);
        let mut work = PairsWork::resume(&cells, LIMIT, &saved).expect("it is of these cells");
        // Stopped once more before it is where it was.
        assert_eq!(work.save().as_ref(), Some(&saved));
        while work.stage() <= Stage::Passages {
            work.step();
        }
        assert_eq!(
            work.save().as_ref(),
            Some(&saved),
            "it is where it was after {steps} steps"
        );
        let was_over = work.stage() == Stage::Done;
        while work.stage() != Stage::Done {
            work.step();
        }
        assert_eq!(work.pairs(), end, "stopped after {steps} steps");
        if was_over {
            break;
        }
        steps += 1;
    }
    assert!(steps > 5, "it was stopped {steps} times");
}

#[test]
fn saved_work_of_other_cells_or_with_any_byte_changed_is_refused() {
    let cells = worlds::random(11, 12);
    let saved = saved_after(&cells, 1);
    let refused = |cells: &Cells, bytes: &[u8]| PairsWork::resume(cells, LIMIT, bytes).expect_err("refused");
    assert_eq!(refused(&worlds::random(12, 12), &saved), ResumeError::Other);
    assert_eq!(refused(&cells, b""), ResumeError::Foreign);
    assert_eq!(refused(&cells, b"PRT1 and so on"), ResumeError::Foreign);
    for length in 8..saved.len() {
        assert_eq!(refused(&cells, &saved[..length]), ResumeError::Damaged);
    }
    for at in 0..saved.len() {
        let mut bytes = saved.clone();
        bytes[at] ^= 1 << (at % 8);
        refused(&cells, &bytes);
    }
}

#[test]
fn work_that_would_take_too_much_is_refused_before_it_begins() {
    let many = Cells::new(u32::MAX, Vec::new()).expect("no portal is wrong");
    let refused = PairsWork::begin(&many, LIMIT).expect_err("a square of four billion");
    assert!(refused.needs_bytes > 1 << 60, "{refused}");
    let refused = VisiblePairs::compute(&many, &PairsOptions::default()).expect_err("as much");
    assert!(refused.needs_bytes > 1 << 60, "{refused}");
    let cells = worlds::random(2, 60);
    let needs = PairsWork::begin(&cells, 0).expect_err("something").needs_bytes;
    assert!(PairsWork::begin(&cells, needs).is_ok());
}
