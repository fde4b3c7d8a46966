//! Overlapping pairs of moving boxes, compared with `parry3d`.

use super::{Bench, cube};
use enfilade::Aabb;
use enfilade_scenes::Random;
use enfilade_walk::Pairs;
use parry3d::partitioning::{Bvh, BvhBuildStrategy, BvhWorkspace};
use std::hint::black_box;
use std::time::Instant;

/// Number of boxes, and number of boxes moved per update.
const BOXES: u32 = 10_000;
const MOVED: u32 = 1_000;

pub(crate) fn pairs(bench: &Bench, place: &str, sides: [f32; 3]) {
    let mut chance = Random::new(4);
    let whole = Aabb {
        min: [0.0; 3],
        max: sides,
    };
    let mut boxes: Vec<Aabb> = (0..BOXES).map(|_| cube(chance.point_in(&whole), 0.5)).collect();
    let mut pairs = Pairs::new();
    for (id, &bounds) in (0..).zip(&boxes) {
        pairs.set(id, bounds).expect("sound");
    }
    let start = Instant::now();
    pairs.update();
    let first = start.elapsed().as_secs_f64() * 1e9;
    let theirs = |bounds: &Aabb| parry3d::bounding_volume::Aabb::new(bounds.min.into(), bounds.max.into());
    let leaves: Vec<_> = boxes.iter().map(theirs).collect();
    let mut space = BvhWorkspace::default();
    let start = Instant::now();
    let mut tree = Bvh::from_leaves(BvhBuildStrategy::Binned, &leaves);
    let mut met = 0_usize;
    tree.traverse_bvtt_single_tree::<false>(&mut space, &mut |_, _| met += 1);
    let other = start.elapsed().as_secs_f64() * 1e9;
    assert_eq!(pairs.count(), met, "{place}");
    bench.tell(
        place,
        "pairs of 10,000 boxes, initial",
        first,
        Some(("parry3d", other)),
        met as f64,
    );

    let [mut ours, mut other] = [Vec::new(), Vec::new()];
    let mut changes = 0;
    let updates = if bench.times { 100 } else { 3 };
    for update in 0..updates {
        let moved: Vec<u32> = (0..MOVED).map(|i| (i * 10 + update) % BOXES).collect();
        for &id in &moved {
            let by = chance.point(1.0).map(|part| 0.1 * part);
            let held = &mut boxes[id as usize];
            *held = cube([0, 1, 2].map(|axis| held.center()[axis] + by[axis]), 0.5);
        }
        let start = Instant::now();
        for &id in &moved {
            pairs.set(id, boxes[id as usize]).expect("sound");
        }
        let changed = pairs.update();
        changes += changed.began.len() + changed.ended.len();
        ours.push(start.elapsed().as_secs_f64() * 1e9);
        let start = Instant::now();
        for &id in &moved {
            tree.insert_or_update_partially(theirs(&boxes[id as usize]), id, 0.0);
        }
        tree.refit(&mut space);
        tree.optimize_incremental(&mut space);
        let mut met = 0_usize;
        tree.traverse_bvtt_single_tree::<true>(&mut space, &mut |_, _| met += 1);
        black_box(met);
        other.push(start.elapsed().as_secs_f64() * 1e9);
    }
    let mut met = 0;
    tree.traverse_bvtt_single_tree::<false>(&mut space, &mut |_, _| met += 1);
    assert_eq!(pairs.count(), met, "{place}, after all updates");
    let median = |times: &mut Vec<f64>| {
        times.sort_by(f64::total_cmp);
        times[times.len() / 2]
    };
    let [ours, other] = [median(&mut ours), median(&mut other)];
    let changes = changes as f64 / f64::from(updates);
    bench.tell(
        place,
        "pairs, 1,000 of 10,000 moved",
        ours,
        Some(("parry3d", other)),
        changes,
    );
}
