//! Finds the rooms, doors and windows of a building in its triangles, without markup.
//!
//! Voxelizes the building, floods each horizontal slice from the middles of its free parts ([`slice`]), and joins the
//! regions of all slices to rooms ([`stacks`]). Where two rooms meet and nothing opaque is between them, there is a door,
//! a window or an opening ([`doors`]).
//! Source: Haumont, Debeir, Sillion, Volumetric Cell-and-Portal Generation, Eurographics 2003; here by slices, because a
//!     building whose slabs are missing would be one cell.
//! Cost: O(voxels): 0.1 m wide, or wider if there would be more than 60 million.
//! Approximate: rooms are what most people would call so. Looks do not use them.

mod authored;
mod doors;
mod file;
mod graph;
mod grid;
mod holes;
mod input;
mod labels;
mod merge;
mod sight;
mod slice;
mod stacks;
mod suggest;
mod units;
mod voxels;

pub use authored::{AuthoredDoor, AuthoredRooms};
pub use file::RoomFileError;
pub use graph::{
    Door, DoorId, DoorKind, Room, RoomChange, RoomGraph, RoomId, RoomPath, RoomTracker, SoundLoss,
};
pub use input::{RoomItem, RoomMesh, RoomsInput, Up, is_door_name};
pub use suggest::DoorSuggestion;
pub use units::{FaceAreas, detect_metres_per_unit, detect_up, metres_per_unit_of};
pub use voxels::RoomVoxels;

use grid::{Grid, VoxelSet};
use input::{Bounds, Metric};
use labels::LabelGrid;
use rayon::prelude::*;
use slice::NONE;
use stacks::Labels;
use thiserror::Error;
use voxels::Solids;

/// Options of [`find_rooms`]. Lengths are in metres.
#[derive(Clone, Copy, Debug, PartialEq)]
#[non_exhaustive]
pub struct RoomOptions {
    /// The vertical axis. Default [`Up::Y`].
    pub up: Up,
    /// Metres per scene unit. Default 1.
    pub metres_per_unit: f64,
    /// Side of a voxel. Default 0.1. Larger if there would be more than `max_voxels`.
    pub step: f64,
    /// Maximum number of voxels. Default 60 million; one takes about 5 bytes.
    pub max_voxels: usize,
    /// Items with an extent below this on all axes separate no rooms. Default 1.
    pub clutter: f64,
    /// Minimum volume of a room, in cubic metres. Default 2.
    pub min_volume: f64,
    /// Minimum height of a room. Default 1.2.
    pub min_height: f64,
    /// Minimum distance to the walls in the middle of a room. Default 0.25.
    pub min_half_width: f64,
    /// Rooms are joined where the contact between them is at least this wide, as a share of the side of a square with
    /// the floor area of the smaller room. Default 0.5: columns do not split a hall, doorways separate rooms.
    pub join_width: f64,
}

impl Default for RoomOptions {
    fn default() -> RoomOptions {
        RoomOptions {
            up: Up::Y,
            metres_per_unit: 1.0,
            step: 0.1,
            max_voxels: 60_000_000,
            clutter: 1.0,
            min_volume: 2.0,
            min_height: 1.2,
            min_half_width: 0.25,
            join_width: 0.5,
        }
    }
}

/// Why rooms could not be found.
#[derive(Clone, Debug, PartialEq, Error)]
#[non_exhaustive]
pub enum RoomsError {
    /// A triangle refers to a position that does not exist.
    #[error("mesh {mesh} has a triangle with position {index}, but only {positions} positions")]
    NoSuchPosition {
        /// Index of the mesh.
        mesh: usize,
        /// Index of the position.
        index: u32,
        /// Number of positions.
        positions: usize,
    },
    /// An item refers to a mesh that does not exist.
    #[error("item {item} has mesh {mesh}, but there are only {meshes}")]
    NoSuchMesh {
        /// Index of the item.
        item: usize,
        /// Index of the mesh.
        mesh: usize,
        /// Number of meshes.
        meshes: usize,
    },
    /// There is nothing that could separate rooms.
    #[error("there are no triangles with an area")]
    NoTriangles,
    /// An option is not a number above zero.
    #[error("option {option} is {value}; it must be a number above zero")]
    BadOption {
        /// Name of the option.
        option: &'static str,
        /// Its value.
        value: f64,
    },
}

/// The rooms of a building, and what they were found in.
pub struct FoundRooms {
    /// Rooms, doors and windows.
    pub graph: RoomGraph,
    /// Items that may be closed doors, though nothing says so.
    pub suggestions: Vec<DoorSuggestion>,
    /// The voxels that they were found in.
    pub voxels: RoomVoxels,
}

/// Finds rooms, and the doors and windows between them. Uses the rayon pool of the caller; the result does not depend on
/// the number of threads.
///
/// # Errors
/// Returns a [`RoomsError`] if an index is out of range, an option is not above zero, or there are no triangles.
pub fn find_rooms(input: &RoomsInput, options: &RoomOptions) -> Result<FoundRooms, RoomsError> {
    find_rooms_among(input, options, None)
}

/// As [`find_rooms`], in a scene with rooms that its author marked: where there are any, they are the rooms, and their
/// doors have the outlines that are marked.
///
/// # Errors
/// As [`find_rooms`].
pub fn find_rooms_among(
    input: &RoomsInput,
    options: &RoomOptions,
    authored: Option<&AuthoredRooms>,
) -> Result<FoundRooms, RoomsError> {
    input.check()?;
    options.check()?;
    let metric = Metric {
        up: options.up,
        metres_per_unit: options.metres_per_unit,
    };
    let bounds = input.bounds(&metric);
    let classes = voxels::classify(input, &bounds, options);
    let extent = voxels::extent(input, &bounds, &metric, options)?;
    // The margin is a way around the building for the exterior.
    let grid = Grid::around(&extent, 1.0, options.step, options.max_voxels.max(1000));
    let options = &options.at_least_voxels(grid.step);
    let solids = Solids::new(&grid, input, &classes, &metric);
    let found = stacks::find(&grid, |voxel| solids.separating.has(voxel), options);
    let (found, names) = match authored {
        Some(authored) => authored::relabel(&grid, &metric, found, authored),
        None => (found, Vec::new()),
    };
    let Labels {
        rooms: mut labels,
        count,
        outside,
    } = found;
    let free = VoxelSet::new(&grid);
    (0..grid.len()).into_par_iter().for_each(|voxel| {
        if labels[voxel] != NONE {
            free.insert(voxel);
        }
    });
    let extents = measure(&grid, &labels, count);
    stacks::grow(&grid, &mut labels);
    let outside = (outside != NONE).then_some(RoomId(outside));
    let (mut rooms, storeys) = rooms_of(&grid, &metric, &extents, outside);
    for (room, name) in rooms.iter_mut().zip(&names) {
        room.name.clone_from(name);
    }
    list_items(input, &grid, &metric, &labels, &mut rooms);
    let compact = LabelGrid::new(&grid, &labels);
    let voxels = RoomVoxels {
        grid,
        metric,
        solids,
        labels,
        free,
    };
    let holes = holes::find(input, &voxels, &classes);
    let mut doors = doors::find(&voxels, &classes, &bounds, &holes);
    if let Some(authored) = authored {
        authored::outline_doors(&mut doors, &names, authored, &metric);
    }
    Ok(FoundRooms {
        graph: RoomGraph::new(rooms, doors, outside, storeys, metric, compact),
        suggestions: suggest::find(input, &voxels, &classes, &bounds),
        voxels,
    })
}

impl RoomOptions {
    /// Returns options for which a room has at least a few voxels on each axis.
    fn at_least_voxels(&self, step: f64) -> RoomOptions {
        RoomOptions {
            min_volume: self.min_volume.max(64.0 * step.powi(3)),
            min_height: self.min_height.max(4.0 * step),
            min_half_width: self.min_half_width.max(1.5 * step),
            ..*self
        }
    }

    fn check(&self) -> Result<(), RoomsError> {
        let numbers = [
            ("metres_per_unit", self.metres_per_unit),
            ("step", self.step),
            ("clutter", self.clutter),
            ("min_volume", self.min_volume),
            ("min_height", self.min_height),
            ("min_half_width", self.min_half_width),
            ("join_width", self.join_width),
        ];
        let bad = numbers
            .into_iter()
            .find(|&(_, value)| !(value > 0.0 && value < f64::INFINITY));
        bad.map_or(Ok(()), |(option, value)| {
            Err(RoomsError::BadOption { option, value })
        })
    }
}

/// The free space of a room: number of voxels, and first and end place (exclusive).
struct Extent {
    voxels: u64,
    low: [usize; 3],
    high: [usize; 3],
}

/// Measures the free space of each room.
fn measure(grid: &Grid, labels: &[u32], count: usize) -> Vec<Extent> {
    let none = || -> Vec<Extent> {
        let empty = |_| Extent {
            voxels: 0,
            low: [usize::MAX; 3],
            high: [0; 3],
        };
        (0..count).map(empty).collect()
    };
    let slice_len = grid.slice_len();
    labels
        .par_chunks(slice_len)
        .enumerate()
        .fold(none, |mut extents, (slice, labels)| {
            for (voxel, &label) in labels.iter().enumerate().filter(|(_, label)| **label != NONE) {
                let place = [voxel % grid.size[0], slice, voxel / grid.size[0]];
                let extent = &mut extents[label as usize];
                extent.voxels += 1;
                extent.low = [0, 1, 2].map(|axis| extent.low[axis].min(place[axis]));
                extent.high = [0, 1, 2].map(|axis| extent.high[axis].max(place[axis] + 1));
            }
            extents
        })
        .reduce(none, |mut sum, part| {
            for (sum, part) in sum.iter_mut().zip(part) {
                sum.voxels += part.voxels;
                sum.low = [0, 1, 2].map(|axis| sum.low[axis].min(part.low[axis]));
                sum.high = [0, 1, 2].map(|axis| sum.high[axis].max(part.high[axis]));
            }
            sum
        })
}

/// Returns the rooms with their names, and the floor of each storey, in metres.
fn rooms_of(
    grid: &Grid,
    metric: &Metric,
    extents: &[Extent],
    outside: Option<RoomId>,
) -> (Vec<Room>, Vec<f64>) {
    /// Minimum height between the floors of two storeys, in metres.
    const STOREY: f64 = 1.8;
    /// Minimum height of a room for its floor to be that of a storey: spaces above ceilings are lower.
    const UPRIGHT: f64 = 1.9;
    let is_outside = |room: usize| outside == Some(RoomId(room as u32));
    let floor = |extent: &Extent| grid.origin[1] + extent.low[1] as f64 * grid.step;
    let height = |extent: &Extent| (extent.high[1] - extent.low[1]) as f64 * grid.step;
    let indoors = || {
        let rooms = extents.iter().enumerate();
        rooms
            .filter(|&(room, _)| !is_outside(room))
            .map(|(_, extent)| extent)
    };
    let mut floors: Vec<f64> = indoors()
        .filter(|extent| height(extent) >= UPRIGHT)
        .map(floor)
        .collect();
    if floors.is_empty() {
        floors = indoors().map(floor).collect();
    }
    floors.sort_by(f64::total_cmp);
    let mut storeys: Vec<f64> = Vec::new();
    for floor in floors {
        if storeys.last().is_none_or(|&last| floor - last > STOREY) {
            storeys.push(floor);
        }
    }
    let mut numbers = vec![0; storeys.len()];
    let room = |(number, extent): (usize, &Extent)| {
        let Extent { voxels, low, high } = extent;
        let at = |place: &[usize; 3]| {
            metric.scene([0, 1, 2].map(|axis| grid.origin[axis] + place[axis] as f64 * grid.step))
        };
        let mut bounds = Bounds::EMPTY;
        bounds.add(at(low));
        bounds.add(at(high));
        let volume = *voxels as f64 * grid.step.powi(3);
        let storey = storeys
            .partition_point(|&storey| storey <= floor(extent))
            .saturating_sub(1);
        let name = if is_outside(number) {
            "outside".to_owned()
        } else {
            numbers[storey] += 1;
            format!("{storey}.{:02}", numbers[storey])
        };
        Room {
            name,
            volume: rounded(volume, f64::round),
            area: rounded(volume / height(extent), f64::round),
            storey: storey as u32,
            bounds: [
                bounds.min.map(|value| rounded(value, f64::floor)),
                bounds.max.map(|value| rounded(value, f64::ceil)),
            ],
            items: Vec::new(),
        }
    };
    let rooms = extents.iter().enumerate().map(room).collect();
    (rooms, storeys)
}

/// Lists the items of each room: all that touch a voxel of it.
fn list_items(input: &RoomsInput, grid: &Grid, metric: &Metric, labels: &[u32], rooms: &mut [Room]) {
    let touched = |item| {
        let mut rooms: Vec<u32> = Vec::new();
        let mut last = NONE;
        input.for_each_triangle(item, metric, |corners, _| {
            grid.for_each_voxel_of(corners, |voxel| {
                let label = labels[voxel];
                if label != last && label != NONE {
                    last = label;
                    if let Err(place) = rooms.binary_search(&label) {
                        rooms.insert(place, label);
                    }
                }
            });
        });
        rooms
    };
    let of_items: Vec<Vec<u32>> = (0..input.items.len()).into_par_iter().map(touched).collect();
    for (item, of_item) in of_items.iter().enumerate() {
        for &room in of_item {
            rooms[room as usize].items.push(item as u32);
        }
    }
}

/// Returns the item with the smallest of the boxes that contain a point within a margin.
fn containing(
    bounds: &[Bounds],
    which: impl Fn(usize) -> bool,
    point: [f64; 3],
    margin: f64,
) -> Option<usize> {
    let near = (0..bounds.len()).filter(|&item| which(item) && bounds[item].is_near(point, margin));
    near.min_by(|&a, &b| {
        let size = |item: usize| bounds[item].size().iter().sum::<f64>();
        size(a).total_cmp(&size(b))
    })
}

/// Rounds to a multiple of 10⁻⁴ by `round`: short numbers in files.
fn rounded(value: f64, round: fn(f64) -> f64) -> f64 {
    let rounded = round(value * 1e4) / 1e4;
    // Beyond 2⁵³ / 10⁴ every number is long, and a product could overflow.
    if rounded.is_finite() { rounded } else { value }
}
