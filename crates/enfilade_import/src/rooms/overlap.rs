//! Finds overlapping rooms.
//!
//! A point is inside a room if every ray from it hits the front of one of the room's faces. A point in a closet within
//! a hall is inside both rooms, but all rays hit the closet first; where rooms overlap, some rays hit one room first
//! and some the other. Only this unambiguous case is an error.

use super::sides::spread;
use enfilade::{Aabb, Geometry, Hit, Ray};
use glam::DVec3;
use rayon::prelude::*;

const DIRECTIONS: usize = 18;
/// Minimum fraction of the rays that must hit each room first.
const BOTH: f64 = 0.25;
/// Sample points per axis in the intersection of two AABBs, and how many of them must be inside both rooms.
const GRID: usize = 3;
const SURE: usize = 2;

/// Maximum number of pairs that are reported.
const MAX_PAIRS: usize = 20;
/// Pairs tested in parallel, before checking whether enough were found.
const AT_ONCE: usize = 256;

/// Returns pairs of overlapping rooms, each with a point inside both.
pub(super) fn overlaps(rooms: &[Geometry]) -> Vec<(usize, usize, [f32; 3])> {
    let mut by_x: Vec<usize> = (0..rooms.len())
        .filter(|&room| !rooms[room].bounds().is_empty())
        .collect();
    by_x.sort_by(|&a, &b| rooms[a].bounds().min[0].total_cmp(&rooms[b].bounds().min[0]));
    let mut pairs = Vec::new();
    for (place, &a) in by_x.iter().enumerate() {
        let end = rooms[a].bounds().max[0];
        let later = by_x[place + 1..]
            .iter()
            .take_while(|&&b| rooms[b].bounds().min[0] < end);
        pairs.extend(later.map(|&b| (a.min(b), a.max(b))));
    }
    pairs.sort_unstable();
    let mut found = Vec::new();
    for pairs in pairs.chunks(AT_ONCE) {
        let in_both = pairs
            .par_iter()
            .filter_map(|&(a, b)| Some((a, b, in_both(&rooms[a], &rooms[b])?)));
        found.par_extend(in_both);
        if found.len() >= MAX_PAIRS {
            break;
        }
    }
    found.truncate(MAX_PAIRS);
    found
}

/// Returns a point inside both rooms, if they overlap.
fn in_both(a: &Geometry, b: &Geometry) -> Option<[f32; 3]> {
    let shared = shared(&a.bounds(), &b.bounds())?;
    // The smaller room is more likely not to contain the point; then the larger one is not tested.
    let smaller_first = if a.bounds().volume() <= b.bounds().volume() {
        [a, b]
    } else {
        [b, a]
    };
    let at = |axis: usize, i: usize| {
        let [low, high] = [f64::from(shared.min[axis]), f64::from(shared.max[axis])];
        low + (high - low) * (i as f64 + 0.5) / GRID as f64
    };
    let points =
        (0..GRID.pow(3)).map(|i| DVec3::new(at(0, i % GRID), at(1, i / GRID % GRID), at(2, i / GRID / GRID)));
    let mut inside = points.filter(|&point| lies_in_both(smaller_first, point));
    inside.nth(SURE - 1).map(|point| point.as_vec3().into())
}

fn shared(a: &Aabb, b: &Aabb) -> Option<Aabb> {
    let min = [0, 1, 2].map(|axis| a.min[axis].max(b.min[axis]));
    let max = [0, 1, 2].map(|axis| a.max[axis].min(b.max[axis]));
    (0..3)
        .all(|axis| min[axis] < max[axis])
        .then(|| Aabb::of([min, max]))
}

fn lies_in_both(rooms: [&Geometry; 2], point: DVec3) -> bool {
    let mut first = [0; 2];
    for i in 0..DIRECTIONS {
        let ray = Ray {
            origin: point.as_vec3().into(),
            direction: spread(i, DIRECTIONS).as_vec3().into(),
        };
        let front = |room: &Geometry| room.cast(&ray).filter(|hit: &Hit| !hit.from_behind);
        let Some(one) = front(rooms[0]) else { return false };
        let Some(other) = front(rooms[1]) else {
            return false;
        };
        first[0] += usize::from(one.distance <= other.distance);
        first[1] += usize::from(other.distance <= one.distance);
    }
    first
        .iter()
        .all(|&votes| votes as f64 >= BOTH * DIRECTIONS as f64)
}
