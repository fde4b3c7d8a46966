//! Overlapping pairs of boxes that move, appear and disappear.

use enfilade::Aabb;
use enfilade_scenes::Random;
use enfilade_walk::{BoxError, Pairs};
use std::collections::{BTreeMap, BTreeSet};

/// Returns all pairs by brute force.
fn every(boxes: &BTreeMap<u32, Aabb>) -> BTreeSet<[u32; 2]> {
    let later = |(&a, held): (&u32, &Aabb)| {
        let held = *held;
        let others = boxes.range(a + 1..).filter(move |(_, other)| held.meets(other));
        others.map(move |(&b, _)| [a, b])
    };
    boxes.iter().flat_map(later).collect()
}

/// Boxes that move randomly on a grid of halves, so that many touch.
fn wander(sides: [f32; 3], count: u32, seed: u64) -> [usize; 2] {
    let mut chance = Random::new(seed);
    let mut place = || {
        let min = chance.point(1.0).map(|value| value * 0.5 + 0.5);
        let size: [f32; 3] = [(); 3].map(|()| (chance.unit() * 4.0).floor() * 0.5);
        let min = [0, 1, 2].map(|axis| (2.0 * sides[axis] * min[axis]).round() * 0.5);
        let max = [0, 1, 2].map(|axis| min[axis] + size[axis].min(sides[axis]));
        Aabb { min, max }
    };
    let mut pairs = Pairs::new();
    let mut boxes = BTreeMap::new();
    let mut before = BTreeSet::new();
    let [mut began, mut ended] = [0; 2];
    let mut dice = Random::new(seed + 100);
    for update in 0..60 {
        for _ in 0..if update % 20 == 0 {
            count
        } else {
            (count / 10).max(1)
        } {
            // Sparse ids: they are keys, not indices.
            let id = dice.below(count as usize) as u32 * 9_973;
            if dice.below(8) == 0 {
                assert_eq!(pairs.remove(id), boxes.remove(&id).is_some());
            } else {
                let bounds = place();
                pairs.set(id, bounds).expect("sound");
                boxes.insert(id, bounds);
            }
        }
        let now = every(&boxes);
        let changes = pairs.update();
        assert!(
            changes.began.iter().eq(now.difference(&before)),
            "update {update}"
        );
        assert!(
            changes.ended.iter().eq(before.difference(&now)),
            "update {update}"
        );
        began += changes.began.len();
        ended += changes.ended.len();
        assert_eq!(pairs.count(), now.len());
        assert!(pairs.all().iter().eq(&now));
        let id = dice.below(count as usize) as u32 * 9_973;
        let mut others: Vec<u32> = pairs.of(id).collect();
        others.sort_unstable();
        let expected = boxes
            .keys()
            .filter(|&&other| now.contains(&[id.min(other), id.max(other)]));
        assert!(others.iter().eq(expected));
        assert_eq!(pairs.bounds(id), boxes.get(&id).copied());
        let nothing = pairs.update();
        assert_eq!([nothing.began, nothing.ended], [&[] as &[[u32; 2]]; 2]);
        before = now;
    }
    [began, ended]
}

#[test]
fn boxes_in_space_in_a_plane_and_along_a_line_overlap_as_each_does_with_each() {
    for (sides, count) in [
        ([12.0; 3], 400),
        ([40.0, 0.0, 40.0], 400),
        ([300.0, 0.0, 0.0], 300),
        ([0.0; 3], 40),
        ([1.0; 3], 3),
    ] {
        let [began, ended] = wander(sides, count, u64::from(count));
        assert!(
            began > 4 && ended > 4,
            "{sides:?}: {began} pairs began, {ended} ended"
        );
    }
}

#[test]
fn what_is_no_box_is_refused_and_leaves_the_box_as_it_was() {
    let unit = Aabb {
        min: [0.0; 3],
        max: [1.0; 3],
    };
    let mut pairs = Pairs::new();
    for id in [5, 1] {
        pairs.set(id, unit).expect("sound");
    }
    assert_eq!(pairs.update().began, [[1, 5]]);
    let mut not_a_number = unit;
    not_a_number.max[1] = f32::NAN;
    assert_eq!(pairs.set(5, not_a_number), Err(BoxError::NotFinite(5)));
    assert_eq!(pairs.set(5, Aabb::EMPTY), Err(BoxError::NotFinite(5)));
    let inside_out = Aabb {
        min: unit.max,
        max: unit.min,
    };
    let refused = pairs.set(9, inside_out).expect_err("it is empty");
    assert_eq!(
        refused.to_string(),
        "box 9 is empty: a minimum exceeds its maximum"
    );
    assert_eq!([pairs.bounds(5), pairs.bounds(9)], [Some(unit), None]);
    assert!(pairs.update().ended.is_empty());
    assert!(pairs.remove(5) && !pairs.remove(5) && !pairs.remove(77));
    // Moved away and back before the next query: no change.
    pairs.set(5, unit).expect("sound");
    assert!(pairs.update().ended.is_empty());
    assert_eq!(pairs.all(), [[1, 5]]);
}
