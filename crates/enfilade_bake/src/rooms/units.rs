//! Guesses the up axis and the unit of a building from its triangles.

use super::grid::{Grid, VoxelSet};
use super::input::{Bounds, Metric, RoomsInput, Up};
use glam::DVec3;
use std::ops::RangeInclusive;

/// Units that files are made in, in metres: metre, centimetre, millimetre, inch, foot.
const UNITS: [f64; 5] = [1.0, 0.01, 0.001, 0.0254, 0.3048];

/// Heights of rooms, in metres, for which the unit is a metre without a guess; up to the nave of a church.
const ROOMS: RangeInclusive<f64> = 1.5..=40.0;

/// Usual height of a room, in metres.
const USUAL: f64 = 2.8;

/// Returns the axis that floors face: the one across the planes with the most area, because a building is wider than high.
/// [`Up::Y`], unless another has clearly more.
pub fn detect_up(input: &RoomsInput) -> Up {
    /// Planes that are distinguished along the longest extent.
    const PLANES: usize = 256;
    /// Ratio of areas from which on it is another axis.
    const CLEARLY: f64 = 1.5;
    /// Cosine of the angle to an axis.
    const ALONG: f64 = 0.99;
    let as_it_is = Metric {
        up: Up::Y,
        metres_per_unit: 1.0,
    };
    let all = around(input, &as_it_is);
    let longest = all.size().into_iter().fold(0.0, f64::max);
    let mut areas = vec![DVec3::ZERO; PLANES];
    for item in 0..input.items.len() {
        input.for_each_triangle(item, &as_it_is, |corners, _| {
            let [a, b, c] = corners.map(DVec3::from);
            let normal = (b - a).cross(c - a);
            let length = normal.length();
            for axis in 0..3 {
                if normal[axis].abs() > ALONG * length {
                    let plane = (a[axis] - all.min[axis]) / longest * PLANES as f64;
                    areas[(plane as usize).min(PLANES - 1)][axis] += length;
                }
            }
        });
    }
    let most = areas.into_iter().fold(DVec3::ZERO, DVec3::max);
    if most.z > CLEARLY * most.y && most.z > most.x {
        Up::Z
    } else if most.x > CLEARLY * most.y {
        Up::X
    } else {
        Up::Y
    }
}

/// Returns the box of all items.
fn around(input: &RoomsInput, metric: &Metric) -> Bounds {
    let mut all = Bounds::EMPTY;
    for bounds in input.bounds(metric).iter().filter(|bounds| !bounds.is_empty()) {
        all.add(bounds.min);
        all.add(bounds.max);
    }
    all
}

/// Returns the metres per scene unit: 1 if rooms are as high as rooms are, else that of the usual unit for which they
/// are. `None` if there are no rooms with a floor and a ceiling.
pub fn detect_metres_per_unit(input: &RoomsInput, up: Up) -> Option<f64> {
    let height = room_height(input, up)?;
    if ROOMS.contains(&height) {
        return Some(1.0);
    }
    let off = |unit: &f64| (height * unit / USUAL).ln().abs();
    UNITS.into_iter().min_by(|a, b| off(a).total_cmp(&off(b)))
}

/// Returns the median height of the free space between a floor and a ceiling, in scene units.
fn room_height(input: &RoomsInput, up: Up) -> Option<f64> {
    const MAX_VOXELS: usize = 4_000_000;
    /// Voxels across the longest extent.
    const ACROSS: f64 = 384.0;
    /// Minimum height in voxels.
    const MIN_HEIGHT: usize = 3;
    let metric = Metric {
        up,
        metres_per_unit: 1.0,
    };
    let all = around(input, &metric);
    let longest = all.size().into_iter().fold(0.0, f64::max);
    if all.is_empty() || longest.is_infinite() || longest <= 0.0 {
        return None;
    }
    let step = longest / ACROSS;
    let grid = Grid::around(&all, step, step, MAX_VOXELS);
    let solid = VoxelSet::new(&grid);
    for item in 0..input.items.len() {
        input.for_each_triangle(item, &metric, |corners, _| {
            grid.for_each_voxel_of(corners, |voxel| solid.insert(voxel));
        });
    }
    // Number of free voxels by the height of their free space: by volume, because hollow slabs have as much area as rooms.
    let [columns, slices, rows] = grid.size;
    let mut heights = vec![0_u64; slices + 1];
    for z in 0..rows {
        for x in 0..columns {
            let mut last_solid: Option<usize> = None;
            for y in 0..slices {
                if solid.has(grid.index([x, y, z])) {
                    if let Some(last) = last_solid
                        && y - last > MIN_HEIGHT
                    {
                        heights[y - last - 1] += (y - last - 1) as u64;
                    }
                    last_solid = Some(y);
                }
            }
        }
    }
    let total: u64 = heights.iter().sum();
    let mut below = 0;
    let median = heights.iter().position(|&count| {
        below += count;
        total > 0 && 2 * below >= total
    })?;
    Some(median as f64 * grid.step)
}
