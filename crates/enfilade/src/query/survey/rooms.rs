//! Segments floors into rooms, which end where the free width is small, as in doorways.
//!
//! Idea: watershed by clearance. Floors are visited in descending order of clearance. One that has no neighbour in a
//!     room starts a room. Where two rooms meet at a clearance much smaller than that of both, as in a door, they stay
//!     separate; otherwise they merge.
//! Source: Beucher, Meyer, The Morphological Approach to Segmentation: The Watershed Transformation, 1993; Recast
//!     partitions its regions in the same way.
//! Cost: O(n log n) for n floors.

use super::floors::{Floors, Kind};
use std::collections::VecDeque;

/// Maximum clearance, in metres: halls are not segmented.
const OPEN: f64 = 2.0;
/// Minimum difference of clearance that separates two rooms: in metres, and relative to the smaller room's.
const NARROWER: [f64; 2] = [0.15, 0.2];
/// Minimum clearance of a floor in a room, in metres.
pub(super) const NARROWEST: f64 = 0.25;
/// Minimum area of a room, in square metres: no shelves, steps or table tops.
const SMALLEST: f64 = 0.5;

/// Connected floors.
pub(super) struct Room {
    pub(super) floors: Vec<u32>,
    /// In square metres.
    pub(super) area: f64,
    /// Kind of most of its floors.
    pub(super) kind: Kind,
}

/// Returns the rooms of a geometry and the clearance of each floor in metres.
pub(super) fn rooms(floors: &Floors, metre: f64) -> (Vec<Room>, Vec<f32>) {
    let clearance = clearance(floors, metre);
    let mut order: Vec<u32> = (0..floors.all.len() as u32)
        .filter(|&floor| f64::from(clearance[floor as usize]) >= NARROWEST)
        .collect();
    order.sort_unstable_by(|&a, &b| {
        let [by, to] = [b, a].map(|floor| clearance[floor as usize]);
        by.total_cmp(&to).then(a.cmp(&b))
    });
    let mut basins = Basins {
        parents: vec![u32::MAX; floors.all.len()],
    };
    for floor in order {
        let saddle = clearance[floor as usize];
        let mut roots: Vec<u32> = floors.neighbours(floor).into_iter().flatten().collect();
        roots.retain(|&next| basins.parents[next as usize] != u32::MAX);
        roots.iter_mut().for_each(|next| *next = basins.root(*next));
        // A basin's root is its first floor, the most open of it.
        roots.sort_unstable_by(|&a, &b| {
            let [by, to] = [b, a].map(|root| clearance[root as usize]);
            by.total_cmp(&to).then(a.cmp(&b))
        });
        roots.dedup();
        let Some((&widest, others)) = roots.split_first() else {
            basins.parents[floor as usize] = floor;
            continue;
        };
        basins.parents[floor as usize] = widest;
        for &other in others {
            let peak = f64::from(clearance[other as usize]);
            if peak - f64::from(saddle) < NARROWER[0].max(NARROWER[1] * peak) {
                basins.parents[other as usize] = widest;
            }
        }
    }
    let mut rooms: Vec<Room> = Vec::new();
    let mut room_of = vec![u32::MAX; floors.all.len()];
    let area = (floors.side / metre).powi(2);
    for floor in 0..floors.all.len() as u32 {
        if basins.parents[floor as usize] == u32::MAX {
            continue;
        }
        let root = basins.root(floor) as usize;
        if room_of[root] == u32::MAX {
            room_of[root] = rooms.len() as u32;
            rooms.push(Room {
                floors: Vec::new(),
                area: 0.0,
                kind: Kind::Floor,
            });
        }
        rooms[room_of[root] as usize].floors.push(floor);
    }
    for room in &mut rooms {
        room.area = area * room.floors.len() as f64;
        for kind in [Kind::Roof, Kind::Assumed] {
            let of_kind = (room.floors.iter()).filter(|&&floor| floors.all[floor as usize].kind == kind);
            if 2 * of_kind.count() > room.floors.len() {
                room.kind = kind;
            }
        }
    }
    rooms.retain(|room| room.area >= SMALLEST);
    (rooms, clearance)
}

/// Returns the distance of each floor from the nearest border floor, which lacks a neighbour: a distance transform that
/// propagates the nearest border floor.
fn clearance(floors: &Floors, metre: f64) -> Vec<f32> {
    let mut nearest = vec![u32::MAX; floors.all.len()];
    let mut waiting = VecDeque::new();
    for floor in 0..floors.all.len() as u32 {
        if floors.neighbours(floor).contains(&None) {
            nearest[floor as usize] = floor;
            waiting.push_back(floor);
        }
    }
    let far = |from: u32, to: u32| {
        let off = floors.place(from) - floors.place(to);
        (off.x.hypot(off.z) + 0.5 * floors.side) / metre
    };
    let mut clearance = vec![OPEN as f32; floors.all.len()];
    while let Some(floor) = waiting.pop_front() {
        let end = nearest[floor as usize];
        let here = far(floor, end) as f32;
        if here >= OPEN as f32 {
            continue;
        }
        clearance[floor as usize] = clearance[floor as usize].min(here);
        for next in floors.neighbours(floor).into_iter().flatten() {
            let known = nearest[next as usize];
            if known == u32::MAX || far(next, end) + 1e-9 < far(next, known) {
                nearest[next as usize] = end;
                waiting.push_back(next);
            }
        }
    }
    clearance
}

/// Disjoint sets of floors.
struct Basins {
    parents: Vec<u32>,
}

impl Basins {
    fn root(&mut self, mut floor: u32) -> u32 {
        while self.parents[floor as usize] != floor {
            let parent = self.parents[floor as usize];
            self.parents[floor as usize] = self.parents[parent as usize];
            floor = parent;
        }
        floor
    }
}
