//! Voxels of a building: which separate rooms, which block sight, and the room of each.

use super::grid::{Grid, VoxelSet};
use super::input::{Bounds, Class, Metric, RoomsInput};
use super::slice::NONE;
use super::{RoomOptions, RoomsError};
use rayon::prelude::*;

/// What the triangles of a building touch.
pub(super) struct Solids {
    /// Everything but clutter.
    pub(super) separating: VoxelSet,
    /// Opaque, and not the leaf of a door.
    pub(super) opaque: VoxelSet,
    /// Leaves of doors.
    pub(super) leaves: VoxelSet,
}

impl Solids {
    /// Voxelizes all items.
    pub(super) fn new(grid: &Grid, input: &RoomsInput, classes: &[Class], metric: &Metric) -> Solids {
        let solids = Solids {
            separating: VoxelSet::new(grid),
            opaque: VoxelSet::new(grid),
            leaves: VoxelSet::new(grid),
        };
        (0..input.items.len()).into_par_iter().for_each(|item| {
            input.for_each_triangle(item, metric, |corners, is_see_through| {
                grid.for_each_voxel_of(corners, |voxel| {
                    match classes[item] {
                        Class::Leaf => {
                            solids.leaves.insert(voxel);
                            solids.separating.insert(voxel);
                            return;
                        }
                        Class::Structure => solids.separating.insert(voxel),
                        Class::Clutter => {}
                    }
                    if !is_see_through {
                        solids.opaque.insert(voxel);
                    }
                });
            });
        });
        solids
    }
}

/// The room of each voxel, for tests and scores.
pub struct RoomVoxels {
    pub(super) grid: Grid,
    pub(super) metric: Metric,
    pub(super) solids: Solids,
    /// Rooms grown into solid voxels.
    pub(super) labels: Vec<u32>,
    /// Voxels that had a room before.
    pub(super) free: VoxelSet,
}

impl RoomVoxels {
    /// Returns the number of voxels along x, y and z, in metres with y up.
    pub fn size(&self) -> [usize; 3] {
        self.grid.size
    }

    /// Returns the lower corner of the first voxel, in metres with y up.
    pub fn origin(&self) -> [f64; 3] {
        self.grid.origin
    }

    /// Returns the side of a voxel, in metres.
    pub fn step(&self) -> f64 {
        self.grid.step
    }

    /// Returns a point of the scene in metres with y up.
    pub fn metres(&self, point: [f64; 3]) -> [f64; 3] {
        self.metric.metres(point)
    }

    /// Returns a point in metres, y up, in the coordinates of the scene.
    pub fn scene(&self, point: [f64; 3]) -> [f64; 3] {
        self.metric.scene(point)
    }

    /// Returns the voxel that contains a point of the scene; `None` outside the grid.
    pub fn voxel_at(&self, point: [f64; 3]) -> Option<usize> {
        let cell = self.grid.cell_at(self.metric.metres(point))?;
        Some(self.grid.index(cell))
    }

    /// Returns the number of a voxel from its column, height and row.
    pub fn index(&self, place: [usize; 3]) -> usize {
        self.grid.index(place)
    }

    /// Returns the column, height and row of a voxel.
    pub fn place(&self, voxel: usize) -> [usize; 3] {
        self.grid.place(voxel)
    }

    /// Returns the room of a voxel, whether it is solid or free; `None` if there are no rooms.
    pub fn room(&self, voxel: usize) -> Option<u32> {
        let label = self.labels[voxel];
        (label != NONE).then_some(label)
    }

    /// Returns the room of a voxel that nothing touches but clutter; `None` for others and for voids.
    pub fn free_room(&self, voxel: usize) -> Option<u32> {
        if self.free.has(voxel) {
            self.room(voxel)
        } else {
            None
        }
    }

    /// Returns `true` for voxels that light passes: free ones, panes and leaves, but not gaps inside walls, which nothing
    /// separates and no room reaches.
    pub(super) fn shows(&self, voxel: usize) -> bool {
        !self.is_opaque(voxel) && (self.free.has(voxel) || self.is_separating(voxel))
    }

    /// Returns `true` if a wall, slab, pane or leaf touches the voxel.
    pub fn is_separating(&self, voxel: usize) -> bool {
        self.solids.separating.has(voxel)
    }

    /// Returns `true` if something opaque touches the voxel that is not the leaf of a door.
    pub fn is_opaque(&self, voxel: usize) -> bool {
        self.solids.opaque.has(voxel)
    }
}

/// Minimum height of the leaf of a door, and its maximum extent, in metres.
const MIN_LEAF: f64 = 1.0;
const MAX_LEAF: f64 = 10.0;

/// Returns the class of each item.
pub(super) fn classify(input: &RoomsInput, bounds: &[Bounds], options: &RoomOptions) -> Vec<Class> {
    let of = |(item, bounds): (&super::RoomItem, &Bounds)| {
        let extent = bounds.size().into_iter().fold(0.0, f64::max);
        // Lower ones are cupboards that are called doors, larger ones lifts or all that an animation turns.
        if item.movable && bounds.size()[1] >= MIN_LEAF && extent <= MAX_LEAF {
            Class::Leaf
        } else if extent < options.clutter {
            Class::Clutter
        } else {
            Class::Structure
        }
    };
    input.items.iter().zip(bounds).map(of).collect()
}

/// Returns a box around everything that can bound a room: without the flat surroundings of a building.
///
/// # Errors
/// If there are no triangles.
pub(super) fn extent(
    input: &RoomsInput,
    bounds: &[Bounds],
    metric: &Metric,
    options: &RoomOptions,
) -> Result<Bounds, RoomsError> {
    /// Minimum side of a column, in metres.
    const SIDE: f64 = 2.0;
    const MOST: usize = 1024;
    let mut all = Bounds::EMPTY;
    for bounds in bounds.iter().filter(|bounds| !bounds.is_empty()) {
        all.add(bounds.min);
        all.add(bounds.max);
    }
    if all.is_empty() {
        return Err(RoomsError::NoTriangles);
    }
    let size = all.size();
    let side = SIDE.max(size[0].max(size[2]) / MOST as f64);
    let columns = [0, 2].map(|axis| ((size[axis] / side) as usize + 1).min(MOST + 1));
    // Lowest and highest point of what is in each column.
    let mut heights = vec![[f64::INFINITY, f64::NEG_INFINITY]; columns[0] * columns[1]];
    let flat = Grid {
        size: [columns[0], 1, columns[1]],
        origin: [all.min[0], all.min[1] - 1.0, all.min[2]],
        step: side,
    };
    for item in 0..input.items.len() {
        input.for_each_triangle(item, metric, |corners, _| {
            let low = corners.iter().fold(f64::INFINITY, |low, at| low.min(at[1]));
            let high = corners.iter().fold(f64::NEG_INFINITY, |high, at| high.max(at[1]));
            let cells = |axis: usize, count: usize| {
                let [least, most] = [f64::min, f64::max]
                    .map(|pick| corners.iter().map(|at| at[axis]).reduce(pick).unwrap_or_default());
                let cell = |at: f64| (((at - flat.origin[axis]) / side) as usize).min(count - 1);
                cell(least)..=cell(most)
            };
            for z in cells(2, columns[1]) {
                for x in cells(0, columns[0]) {
                    let [lowest, highest] = &mut heights[z * columns[0] + x];
                    *lowest = lowest.min(low);
                    *highest = highest.max(high);
                }
            }
        });
    }
    let mut kept = Bounds::EMPTY;
    for (column, &[low, high]) in heights.iter().enumerate() {
        if high - low < options.min_height {
            continue;
        }
        let [x, z] = [column % columns[0], column / columns[0]];
        let corner = |dx: usize, dz: usize, y: f64| {
            [
                (flat.origin[0] + (x + dx) as f64 * side).clamp(all.min[0], all.max[0]),
                y,
                (flat.origin[2] + (z + dz) as f64 * side).clamp(all.min[2], all.max[2]),
            ]
        };
        kept.add(corner(0, 0, low));
        kept.add(corner(1, 1, high));
    }
    Ok(if kept.is_empty() { all } else { kept })
}
