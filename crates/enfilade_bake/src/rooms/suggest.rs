//! Suggests items that look like closed doors, when nothing says that they can be opened.
//!
//! A door is thin and upright. A wall is beside and above it, but not below it, no other item is in its middle, and it
//! separates two rooms. So do wardrobes and panels of facades, now and then: a person should confirm.
//! Cost: O(voxels of the items that have the size of a door).

use super::graph::RoomId;
use super::input::{Bounds, Class, RoomsInput};
use super::voxels::RoomVoxels;
use std::collections::BTreeSet;
use std::ops::RangeInclusive;

/// An item that looks like the closed leaf of a door.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct DoorSuggestion {
    /// The item, by index in the input.
    pub item: u32,
    /// The rooms on its two sides, the lower index first.
    pub rooms: [RoomId; 2],
    /// Its middle, in scene coordinates.
    pub middle: [f64; 3],
}

/// Extents of doors, in metres.
const WIDTH: RangeInclusive<f64> = 0.5..=4.0;
const HEIGHT: RangeInclusive<f64> = 1.6..=4.0;
const MAX_THICKNESS: f64 = 0.5;

/// An item as an upright box, rotated in plan.
struct Upright {
    middle: [f64; 3],
    /// Direction of its width in plan: x and z.
    along: [f64; 2],
    width: f64,
    height: f64,
    thickness: f64,
}

impl Upright {
    /// Returns a point of the box: `across`, `up` and `through` are −0.5 to 0.5 inside.
    fn at(&self, across: f64, up: f64, through: f64) -> [f64; 3] {
        self.offset([across * self.width, up * self.height, through * self.thickness])
    }

    /// Returns a point at distances from the middle, in metres: along the width, up and through.
    fn offset(&self, [across, up, through]: [f64; 3]) -> [f64; 3] {
        let [x, z] = self.along;
        [
            self.middle[0] + across * x - through * z,
            self.middle[1] + up,
            self.middle[2] + across * z + through * x,
        ]
    }
}

pub(super) fn find(
    input: &RoomsInput,
    voxels: &RoomVoxels,
    classes: &[Class],
    bounds: &[Bounds],
) -> Vec<DoorSuggestion> {
    let candidates = (0..input.items.len()).filter(|&item| classes[item] == Class::Structure);
    let suggest = |item: usize| {
        let [x, y, z] = bounds[item].size();
        let has_size = HEIGHT.contains(&y) && x.max(z) <= WIDTH.end() + MAX_THICKNESS;
        let door = has_size.then(|| upright(input, voxels, item))??;
        let rooms = sides(voxels, &door)?;
        let is_door = is_framed(voxels, &door) && is_alone(input, voxels, bounds, item, &door);
        is_door.then(|| DoorSuggestion {
            item: item as u32,
            rooms,
            middle: voxels.metric.scene(door.middle),
        })
    };
    candidates.filter_map(suggest).collect()
}

/// Fits the thinnest upright box to an item; `None` if it has not the size of a door.
fn upright(input: &RoomsInput, voxels: &RoomVoxels, item: usize) -> Option<Upright> {
    const ANGLES: u32 = 90;
    let mut corners: Vec<[f64; 3]> = Vec::new();
    input.for_each_triangle(item, &voxels.metric, |triangle, _| corners.extend(triangle));
    let [low, high] = [f64::min, f64::max].map(|pick| corners.iter().map(|at| at[1]).reduce(pick));
    let (low, high) = (low?, high?);
    let fit = |number: u32| {
        let (z, x) = (f64::from(number) * std::f64::consts::PI / f64::from(ANGLES)).sin_cos();
        let reach = |dx: f64, dz: f64| {
            let places = || corners.iter().map(move |at| at[0] * dx + at[2] * dz);
            [
                places().fold(f64::INFINITY, f64::min),
                places().fold(f64::NEG_INFINITY, f64::max),
            ]
        };
        let [left, right] = reach(x, z);
        let [back, front] = reach(-z, x);
        let [across, through] = [0.5 * (left + right), 0.5 * (back + front)];
        Upright {
            middle: [
                across * x - through * z,
                0.5 * (low + high),
                across * z + through * x,
            ],
            along: [x, z],
            width: right - left,
            height: high - low,
            thickness: front - back,
        }
    };
    let thinnest = (0..ANGLES)
        .map(fit)
        .min_by(|a, b| a.thickness.total_cmp(&b.thickness))?;
    let Upright {
        width,
        height,
        thickness,
        ..
    } = thinnest;
    let is_door =
        WIDTH.contains(&width) && HEIGHT.contains(&height) && thickness <= MAX_THICKNESS.min(0.5 * width);
    is_door.then_some(thinnest)
}

/// Returns the rooms in front and behind, if they are two.
fn sides(voxels: &RoomVoxels, door: &Upright) -> Option<[RoomId; 2]> {
    /// Distances from the door at which its sides are looked for, in metres.
    const AWAY: [f64; 4] = [0.15, 0.3, 0.45, 0.6];
    let room = |side: f64| {
        AWAY.into_iter().find_map(|away| {
            let through = side * (0.5 * door.thickness + away);
            let cell = voxels.grid.cell_at(door.offset([0.0, 0.0, through]))?;
            voxels.free_room(voxels.grid.index(cell))
        })
    };
    let [one, other] = [room(-1.0)?, room(1.0)?];
    (one != other).then(|| [RoomId(one.min(other)), RoomId(one.max(other))])
}

/// Returns `true` if a wall is on both sides of the door and above it, but not below it, as it is below a window.
fn is_framed(voxels: &RoomVoxels, door: &Upright) -> bool {
    /// Distances from the door at which a wall counts, in metres.
    const REACH: [f64; 3] = [0.05, 0.15, 0.25];
    /// Distance in front and behind at which a slab counts: it goes on there, a wall does not.
    const SLAB: f64 = 0.4;
    // Solid, or a gap inside a thick wall.
    let is_solid = |offset: [f64; 3]| {
        let cell = voxels.grid.cell_at(door.offset(offset));
        cell.is_some_and(|cell| !voxels.free.has(voxels.grid.index(cell)))
    };
    let [half_width, half_height] = [0.5 * door.width, 0.5 * door.height];
    let through = 0.5 * door.thickness + SLAB;
    let is_wall_at = |up: f64| {
        let is_slab = is_solid([0.0, up, -through]) && is_solid([0.0, up, through]);
        is_solid([0.0, up, 0.0]) && !is_slab
    };
    let beside = |side: f64| {
        REACH
            .into_iter()
            .any(|away| is_solid([side * (half_width + away), 0.0, 0.0]))
    };
    let above = REACH.into_iter().any(|away| is_wall_at(half_height + away));
    let below = REACH.into_iter().all(|away| is_wall_at(-half_height - away));
    beside(-1.0) && beside(1.0) && above && !below
}

/// Returns `true` if the item fills the middle of the door, and no other item reaches into it.
fn is_alone(input: &RoomsInput, voxels: &RoomVoxels, bounds: &[Bounds], item: usize, door: &Upright) -> bool {
    /// Points on each side of the middle, across and up, in its inner half.
    const STEPS: i32 = 4;
    /// Minimum share of them that the item covers: others are walls with a hole.
    const FILLED: f64 = 0.75;
    let grid = &voxels.grid;
    let cell = |point: [f64; 3]| grid.cell_at(point).map(|cell| grid.index(cell));
    let share = |step: i32| 0.25 * f64::from(step) / f64::from(STEPS);
    let points =
        || (-STEPS..=STEPS).flat_map(|across| (-STEPS..=STEPS).map(move |up| [share(across), share(up)]));
    let mut own = BTreeSet::new();
    input.for_each_triangle(item, &voxels.metric, |triangle, _| {
        grid.for_each_voxel_of(triangle, |voxel| {
            own.insert(voxel);
        });
    });
    let is_covered = |&[across, up]: &[f64; 2]| {
        let through = (-2..=2).map(|step| 0.25 * f64::from(step));
        through
            .filter_map(|through| cell(door.at(across, up, through)))
            .any(|voxel| own.contains(&voxel))
    };
    let covered = points().filter(is_covered).count();
    if (covered as f64) < FILLED * points().count() as f64 {
        return false;
    }
    let middle: BTreeSet<usize> = points()
        .filter_map(|[across, up]| cell(door.at(across, up, 0.0)))
        .collect();
    let reaches_in = |other: usize| {
        let mut reaches_in = false;
        if other != item && bounds[other].is_near(door.middle, 0.5 * door.width.max(door.height)) {
            input.for_each_triangle(other, &voxels.metric, |triangle, _| {
                if !reaches_in {
                    grid.for_each_voxel_of(triangle, |voxel| reaches_in |= middle.contains(&voxel));
                }
            });
        }
        reaches_in
    };
    !(0..input.items.len()).any(reaches_in)
}
