//! Compares the PVS with random rays, with a slow flow without short cuts, and with results known in advance.

mod naive;
mod refused;
mod rooms;
mod shards;
mod stopped;
mod worlds;

use enfilade_bake::{Cells, PairsOptions, PairsWork, Stage, VisiblePairs, find_missing};

fn pairs_of(cells: &Cells) -> VisiblePairs {
    VisiblePairs::compute(cells, &PairsOptions::default()).expect("within the memory limit")
}

#[test]
fn no_line_through_random_worlds_shows_a_pair_that_is_missing() {
    let mut pairs_seen = 0;
    for seed in 0..40 {
        let cells = worlds::random(seed, 60);
        let pairs = pairs_of(&cells);
        let missing = find_missing(&cells, &pairs, 30_000, seed);
        assert!(missing.is_none(), "world {seed}: {}", missing.expect("some"));
        pairs_seen += pairs.count();
    }
    assert!(
        pairs_seen > 20_000,
        "the worlds are too closed: {pairs_seen} pairs"
    );
}

#[test]
fn a_slow_flow_without_short_cuts_keeps_all_that_is_kept() {
    let [mut ours, mut slow] = [0; 2];
    for seed in 100..120 {
        let cells = worlds::random(seed, 24);
        let pairs = pairs_of(&cells);
        let naive = naive::pairs(&cells);
        for from in 0..cells.count() {
            for to in 0..cells.count() {
                // Neither is exact: both may keep pairs that are not visible, but a ray proves visible ones.
                ours += usize::from(pairs.may_see(from, to));
                slow += usize::from(naive[from as usize][to as usize]);
            }
        }
        for from in 0..cells.count() {
            for to in pairs.seen_from(from) {
                assert!(
                    naive[from as usize][to as usize],
                    "world {seed}: only the fast flow keeps {from} and {to}"
                );
            }
        }
    }
    assert!(
        ours > 5_000 && ours * 100 >= slow * 90,
        "{ours} pairs, {slow} for the slow flow"
    );
}

#[test]
fn most_pairs_are_shown_to_be_real_by_a_line() {
    let (mut count, mut proven) = (0, 0);
    for seed in 200..210 {
        let pairs = pairs_of(&worlds::random(seed, 60));
        count += pairs.count();
        proven += pairs.proven();
        assert!(pairs.proven() <= pairs.count());
    }
    assert!(count > 1000 && proven * 100 >= count * 98, "{proven} of {count}");
}

#[test]
fn sight_has_no_direction() {
    for seed in 300..310 {
        let cells = worlds::random(seed, 40);
        for fast in [false, true] {
            let pairs = VisiblePairs::compute(
                &cells,
                &PairsOptions {
                    fast,
                    ..PairsOptions::default()
                },
            )
            .expect("within the memory limit");
            for from in 0..cells.count() {
                assert!(pairs.may_see(from, from));
                for to in pairs.seen_from(from) {
                    assert!(pairs.may_see(to, from), "world {seed}: {from} sees {to}");
                }
            }
        }
    }
}

#[test]
fn the_fast_bound_keeps_all_that_the_full_one_keeps() {
    let mut more = 0;
    for seed in 400..410 {
        let cells = worlds::random(seed, 40);
        let [full, fast] = [false, true].map(|fast| {
            VisiblePairs::compute(
                &cells,
                &PairsOptions {
                    fast,
                    ..PairsOptions::default()
                },
            )
            .expect("within the memory limit")
        });
        for from in 0..cells.count() {
            assert!(full.seen_from(from).all(|to| fast.may_see(from, to)));
        }
        more += fast.count() - full.count();
    }
    assert!(more > 0, "the flow drops nothing");
}

#[test]
fn any_number_of_threads_finds_the_same_pairs() {
    let cells = worlds::random(7, 150);
    let on = |threads| {
        let pool = rayon::ThreadPoolBuilder::new()
            .num_threads(threads)
            .build()
            .expect("threads");
        pool.install(|| pairs_of(&cells))
    };
    let one = on(1);
    assert!(one.count() > 1000, "{}", one.count());
    assert_eq!(one, on(2));
    assert_eq!(one, on(4));
}

#[test]
fn nearly_every_pair_that_is_kept_has_a_line_to_show() {
    let (mut pairs_kept, mut shown) = (0, 0);
    for seed in 500..505 {
        let cells = worlds::random(seed, 60);
        let mut work = PairsWork::begin(&cells, 1 << 30).expect("within the memory limit");
        assert_eq!(work.line_between(0, 1), None, "too early");
        while work.stage() != Stage::Done {
            work.step();
        }
        let pairs = work.pairs();
        for from in 0..cells.count() {
            for to in (0..cells.count()).filter(|&to| to != from) {
                let line = work.line_between(from, to);
                assert!(
                    line.is_none() || pairs.may_see(from, to),
                    "a line from {from} to {to}"
                );
                pairs_kept += usize::from(pairs.may_see(from, to));
                let Some(line) = line else { continue };
                shown += 1;
                assert!(work.line_between(to, from).is_some(), "sight has no direction");
                assert_eq!((line.cells.first(), line.cells.last()), (Some(&from), Some(&to)));
                worlds::follow(&cells, &line);
            }
        }
    }
    assert!(shown * 100 >= pairs_kept * 97, "{shown} of {pairs_kept}");
}
