//! Rooms: floors that are wide, parted where they are narrow.
//!
//! Idea: floors are taken from the most open one down. One that touches no room starts one; where two rooms meet at a
//!     place that is much narrower than both, such as a door, they stay apart; else they become one.
//! Source: Beucher, Meyer, The Morphological Approach to Segmentation: The Watershed Transformation, 1993; as Recast
//!     parts its regions.
//! Cost: O(n log n) for n floors.

use super::floors::{Floors, Kind};
use std::collections::VecDeque;

/// Clearance that counts as open, in metres: halls are not parted.
const OPEN: f64 = 2.0;
/// How much narrower the way between two rooms is than both, in metres, and as a part of the narrower.
const NARROWER: [f64; 2] = [0.15, 0.2];
/// Narrower places do not count, in metres.
const NARROWEST: f64 = 0.25;

/// Floors that belong together.
pub(super) struct Room {
    pub(super) floors: Vec<u32>,
    /// In square metres.
    pub(super) area: f64,
    /// What most of it is.
    pub(super) kind: Kind,
}

/// The rooms of a content, and the clearance of each floor: how far what ends it is, in metres.
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
    (rooms, clearance)
}

/// How far each floor is from the nearest one with an end: the nearest end is handed on from floor to floor.
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

/// Floors by the basin that they are in.
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
