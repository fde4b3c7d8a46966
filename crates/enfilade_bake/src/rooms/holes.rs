//! Holes in walls that are smaller than a voxel: railings, cracks, gaps below doors.
//!
//! Where two rooms meet inside solid voxels, or at the leaf of a door, short random segments from one room to the other are tested against the
//! triangles. One that meets none is a line of sight. Eight
//! segments are cast for each face of a voxel, so a small hole may be missed.
//! Source: segments against triangles: Möller, Trumbore, Fast, Minimum Storage Ray/Triangle Intersection, 1997.
//! Cost: O(faces between rooms), and O(triangles near them).

use super::grid::VoxelSet;
use super::input::{Class, RoomsInput};
use super::slice::NONE;
use super::voxels::RoomVoxels;
use glam::Vec3;
use rayon::prelude::*;

/// Segments through each face.
const SEGMENTS: u64 = 8;

/// Maximum distance from a face to the room on each side, in voxels: thicker walls have no holes.
const REACH: usize = 6;

/// Maximum slope of a segment against the normal of its face.
const SLOPE: f32 = 0.8;

/// A face between two voxels of different rooms that is not plainly open: a voxel beside it is solid, or a leaf is in it.
#[derive(Clone, Copy)]
struct Suspect {
    /// The lower voxel; the other is the next one along the axis.
    voxel: u32,
    axis: u8,
    /// Distance to free voxels of the two rooms, in voxels.
    before: u8,
    after: u8,
    /// Whether it is open but for a leaf.
    is_door: bool,
}

/// A face with the share of segments that pass.
#[derive(Clone, Copy)]
pub(super) struct Hole {
    pub(super) voxel: u32,
    pub(super) axis: u8,
    pub(super) open: f64,
    /// The leaf of a door that blocks all segments while it is closed, by item index.
    pub(super) leaf: Option<u32>,
}

struct NearTriangle {
    corners: [Vec3; 3],
    /// The item, if it is the leaf of a door.
    leaf: Option<u32>,
}

/// Triangles by voxel, in voxels from the origin of the grid.
struct NearTriangles {
    triangles: Vec<NearTriangle>,
    /// Voxel and triangle, sorted.
    in_voxels: Vec<(u32, u32)>,
}

/// Finds the faces that can be seen through though a voxel beside them is solid.
pub(super) fn find(input: &RoomsInput, voxels: &RoomVoxels, classes: &[Class]) -> Vec<Hole> {
    let suspects = suspects(voxels);
    let crossed = VoxelSet::new(&voxels.grid);
    suspects.par_iter().for_each(|suspect| {
        for number in 0..SEGMENTS {
            let segment = Segment::new(voxels, suspect, number);
            segment.for_each_voxel(voxels, |voxel| {
                crossed.insert(voxel);
                true
            });
        }
    });
    let near = NearTriangles::new(input, voxels, classes, &crossed);
    let open = |suspect: &Suspect| {
        let mut count = 0;
        let mut leaf = None;
        let mut is_clear = false;
        for number in 0..SEGMENTS {
            match near.along(voxels, &Segment::new(voxels, suspect, number)) {
                Obstacle::Wall => continue,
                // That is the door itself.
                Obstacle::Leaf(_) if suspect.is_door => continue,
                Obstacle::Leaf(item) => leaf = Some(item),
                Obstacle::Nothing => is_clear = true,
            }
            count += 1;
        }
        (count > 0).then(|| Hole {
            voxel: suspect.voxel,
            axis: suspect.axis,
            open: f64::from(count) / SEGMENTS as f64,
            leaf: leaf.filter(|_| !is_clear),
        })
    };
    suspects.par_iter().filter_map(open).collect()
}

/// Finds the faces between rooms that are not plainly open.
fn suspects(voxels: &RoomVoxels) -> Vec<Suspect> {
    let grid = &voxels.grid;
    let slice_len = grid.slice_len();
    let strides = grid.strides();
    let of_slice = |slice: usize| {
        let mut found = Vec::new();
        for voxel in slice * slice_len..(slice + 1) * slice_len {
            let one = voxels.labels[voxel];
            for axis in 0..3 {
                let place = grid.place(voxel);
                if one == NONE || place[axis] + 1 == grid.size[axis] {
                    continue;
                }
                let next = voxel + strides[axis];
                let other = voxels.labels[next];
                let is_open = voxels.shows(voxel) && voxels.shows(next);
                let has_leaf = voxels.solids.leaves.has(voxel) || voxels.solids.leaves.has(next);
                if other == one || other == NONE || (is_open && !has_leaf) {
                    continue;
                }
                let free = |room: u32, away: usize, is_after: bool| {
                    let room_left = if is_after {
                        grid.size[axis] - 2 - place[axis]
                    } else {
                        place[axis]
                    };
                    let at = |away: usize| {
                        if is_after {
                            next + away * strides[axis]
                        } else {
                            voxel - away * strides[axis]
                        }
                    };
                    away <= room_left && voxels.free.has(at(away)) && voxels.labels[at(away)] == room
                };
                let before = (0..REACH).find(|&away| free(one, away, false));
                let after = (0..REACH).find(|&away| free(other, away, true));
                if let (Some(before), Some(after)) = (before, after) {
                    found.push(Suspect {
                        voxel: voxel as u32,
                        axis: axis as u8,
                        before: before as u8,
                        after: after as u8,
                        is_door: is_open,
                    });
                }
            }
        }
        found
    };
    let slices: Vec<Vec<Suspect>> = (0..grid.size[1]).into_par_iter().map(of_slice).collect();
    slices.into_iter().flatten().collect()
}

/// A line from one room to another, in voxels from the origin of the grid.
struct Segment {
    from: Vec3,
    along: Vec3,
}

impl Segment {
    /// Returns a random segment through a face; the same for the same number.
    fn new(voxels: &RoomVoxels, suspect: &Suspect, number: u64) -> Segment {
        let seed = u64::from(suspect.voxel) * 3 + u64::from(suspect.axis);
        let mut state = (seed * SEGMENTS + number).wrapping_mul(0x9E37_79B9_7F4A_7C15);
        let mut random = || {
            // SplitMix64: Steele, Lea, Flood, Fast Splittable Pseudorandom Number Generators, OOPSLA 2014.
            state = state.wrapping_add(0x9E37_79B9_7F4A_7C15);
            let mut mixed = state;
            mixed = (mixed ^ mixed >> 30).wrapping_mul(0xBF58_476D_1CE4_E5B9);
            mixed = (mixed ^ mixed >> 27).wrapping_mul(0x94D0_49BB_1331_11EB);
            (mixed >> 40) as f32 / (1_u32 << 24) as f32
        };
        let place = voxels.grid.place(suspect.voxel as usize).map(|at| at as f32);
        let axis = suspect.axis as usize;
        let mut through = Vec3::from(place);
        let mut along = Vec3::ZERO;
        for other in 0..3 {
            if other == axis {
                through[other] += 1.0;
                along[other] = 1.0;
            } else {
                through[other] += random();
                along[other] = SLOPE * (2.0 * random() - 1.0);
            }
        }
        let [before, after] = [suspect.before, suspect.after].map(|away| f32::from(away) + 0.5);
        Segment {
            from: through - before * along,
            along: (before + after) * along,
        }
    }

    /// Calls `visit` with the voxels it passes, until that returns `false`.
    fn for_each_voxel(&self, voxels: &RoomVoxels, mut visit: impl FnMut(usize) -> bool) {
        /// Steps per voxel: corners that are cut are short.
        const STEPS: f32 = 4.0;
        let grid = &voxels.grid;
        let steps = (self.along.abs().max_element() * STEPS).ceil();
        let mut last = None;
        for step in 0..=steps as u32 {
            let at = self.from + self.along * (step as f32 / steps);
            let place = [at.x, at.y, at.z].map(|value| value.floor());
            let is_inside = (0..3).all(|axis| place[axis] >= 0.0 && place[axis] < grid.size[axis] as f32);
            if !is_inside {
                continue;
            }
            let voxel = grid.index(place.map(|value| value as usize));
            if last.replace(voxel) != Some(voxel) && !visit(voxel) {
                return;
            }
        }
    }
}

impl NearTriangles {
    fn new(input: &RoomsInput, voxels: &RoomVoxels, classes: &[Class], crossed: &VoxelSet) -> NearTriangles {
        let of_item = |item: usize| {
            let mut triangles: Vec<NearTriangle> = Vec::new();
            let mut in_voxels: Vec<(u32, u32)> = Vec::new();
            let leaf = (classes[item] == Class::Leaf).then_some(item as u32);
            input.for_each_triangle(item, &voxels.metric, |corners, is_see_through| {
                if is_see_through {
                    return;
                }
                let number = triangles.len() as u32;
                let before = in_voxels.len();
                voxels.grid.for_each_voxel_of(corners, |voxel| {
                    if crossed.has(voxel) {
                        in_voxels.push((voxel as u32, number));
                    }
                });
                if in_voxels.len() > before {
                    let place = |at: [f64; 3]| {
                        [0, 1, 2]
                            .map(|axis| ((at[axis] - voxels.grid.origin[axis]) / voxels.grid.step) as f32)
                    };
                    triangles.push(NearTriangle {
                        corners: corners.map(|at| Vec3::from(place(at))),
                        leaf,
                    });
                }
            });
            (triangles, in_voxels)
        };
        let of_items: Vec<_> = (0..input.items.len()).into_par_iter().map(of_item).collect();
        let mut near = NearTriangles {
            triangles: Vec::new(),
            in_voxels: Vec::new(),
        };
        for (triangles, in_voxels) in of_items {
            let first = near.triangles.len() as u32;
            near.triangles.extend(triangles);
            near.in_voxels.extend(
                in_voxels
                    .into_iter()
                    .map(|(voxel, number)| (voxel, first + number)),
            );
        }
        near.in_voxels.par_sort_unstable();
        near
    }

    /// Returns what a segment meets; a wall before a leaf, wherever they are.
    fn along(&self, voxels: &RoomVoxels, segment: &Segment) -> Obstacle {
        let mut obstacle = Obstacle::Nothing;
        segment.for_each_voxel(voxels, |voxel| {
            let start = self
                .in_voxels
                .partition_point(|&(other, _)| (other as usize) < voxel);
            let here = self.in_voxels[start..]
                .iter()
                .take_while(|&&(other, _)| other as usize == voxel);
            for &(_, number) in here {
                let NearTriangle { corners, leaf } = &self.triangles[number as usize];
                if meets_triangle(segment, corners) {
                    match *leaf {
                        Some(leaf) => obstacle = Obstacle::Leaf(leaf),
                        None => {
                            obstacle = Obstacle::Wall;
                            return false;
                        }
                    }
                }
            }
            true
        });
        obstacle
    }
}

/// What is on a segment.
#[derive(Clone, Copy)]
enum Obstacle {
    Nothing,
    Leaf(u32),
    Wall,
}

/// Returns `true` if a segment meets a triangle, or almost: so none slips between two.
fn meets_triangle(Segment { from, along }: &Segment, [a, b, c]: &[Vec3; 3]) -> bool {
    /// Share of a triangle by which it is enlarged.
    const SLACK: f32 = 1e-4;
    let [one, other] = [*b - *a, *c - *a];
    let across = along.cross(other);
    let determinant = one.dot(across);
    if determinant == 0.0 {
        return false;
    }
    let per = 1.0 / determinant;
    let away = *from - *a;
    let u = away.dot(across) * per;
    let turned = away.cross(one);
    let v = along.dot(turned) * per;
    let t = other.dot(turned) * per;
    u >= -SLACK && v >= -SLACK && u + v <= 1.0 + SLACK && (0.0..=1.0).contains(&t)
}
