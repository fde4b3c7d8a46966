//! Doors, windows and openings: where two rooms meet and nothing opaque is between them.
//!
//! Cost: O(voxels), and O(open faces · leaves of doors) where leaves are.

use super::containing;
use super::input::{Bounds, Class};
use super::slice::NONE;
use super::voxels::RoomVoxels;
use rayon::prelude::*;
use std::collections::{BTreeMap, HashMap};

/// What is between two rooms.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub enum PortalKind {
    /// The leaf of a door or gate.
    Door,
    /// Glass.
    Window,
    /// Nothing.
    Opening,
}

/// A door, a window or an opening between two rooms.
#[derive(Clone, Debug, PartialEq)]
pub struct RoomPortal {
    /// The rooms on its two sides, the lower index first.
    pub rooms: [u32; 2],
    /// What is in it.
    pub kind: PortalKind,
    /// The leaf of a door, by item index.
    pub leaf: Option<u32>,
    /// Open area, in square metres: that of voxels without opaque parts.
    pub area: f64,
    /// A rectangle around it, in scene coordinates.
    pub polygon: [[f64; 3]; 4],
}

/// A face between two voxels of different rooms.
#[derive(Clone, Copy)]
struct Face {
    /// The lower voxel; the other is the next one along the axis.
    voxel: u32,
    axis: u8,
}

/// Faces that belong together: rooms, kind and leaf.
type Key = ([u32; 2], PortalKind, Option<u32>);

/// Groups smaller than this, in square metres, are joined to a larger one that they touch.
const SLIVER: f64 = 0.3;

pub(super) fn find(voxels: &RoomVoxels, classes: &[Class], bounds: &[Bounds]) -> Vec<RoomPortal> {
    let grid = &voxels.grid;
    let slice_len = grid.slice_len();
    let strides = grid.strides();
    let of_slice = |slice: usize| {
        let mut faces = Vec::new();
        for voxel in slice * slice_len..(slice + 1) * slice_len {
            if voxels.is_opaque(voxel) {
                continue;
            }
            let one = voxels.labels[voxel];
            let place = grid.place(voxel);
            for axis in 0..3 {
                if place[axis] + 1 == grid.size[axis] {
                    continue;
                }
                let next = voxel + strides[axis];
                let other = voxels.labels[next];
                if one != other && one != NONE && other != NONE && !voxels.is_opaque(next) {
                    let face = Face {
                        voxel: voxel as u32,
                        axis: axis as u8,
                    };
                    faces.push((key_of(voxels, face, classes, bounds), face));
                }
            }
        }
        faces
    };
    let faces: Vec<Vec<(Key, Face)>> = (0..grid.size[1]).into_par_iter().map(of_slice).collect();
    let mut by_key: BTreeMap<Key, Vec<Face>> = BTreeMap::new();
    for (key, face) in faces.into_iter().flatten() {
        by_key.entry(key).or_default().push(face);
    }
    let mut groups: Vec<(Key, Vec<Face>)> = by_key
        .into_par_iter()
        .flat_map_iter(|(key, faces)| {
            connected(voxels, &faces)
                .into_iter()
                .map(move |group| (key, group))
        })
        .collect();
    join_slivers(voxels, &mut groups);
    let portal = |(key, faces): &(Key, Vec<Face>)| portal(voxels, *key, faces);
    groups.iter().map(portal).collect()
}

fn key_of(voxels: &RoomVoxels, face: Face, classes: &[Class], bounds: &[Bounds]) -> Key {
    let pair = [
        face.voxel as usize,
        face.voxel as usize + voxels.grid.strides()[face.axis as usize],
    ];
    let [one, other] = pair.map(|voxel| voxels.labels[voxel]);
    let rooms = [one.min(other), one.max(other)];
    if let Some(voxel) = pair.into_iter().find(|&voxel| voxels.solids.leaves.has(voxel)) {
        let is_leaf = |item: usize| classes[item] == Class::Leaf;
        let leaf = containing(bounds, is_leaf, voxels.grid.center(voxel), voxels.grid.step);
        return (rooms, PortalKind::Door, leaf.map(|item| item as u32));
    }
    let is_glass = pair.into_iter().any(|voxel| voxels.is_separating(voxel));
    let kind = if is_glass {
        PortalKind::Window
    } else {
        PortalKind::Opening
    };
    (rooms, kind, None)
}

/// Splits faces into groups whose voxels touch.
fn connected(voxels: &RoomVoxels, faces: &[Face]) -> Vec<Vec<Face>> {
    let mut of_voxel: HashMap<u32, Vec<u32>> = HashMap::new();
    for (number, face) in faces.iter().enumerate() {
        of_voxel.entry(face.voxel).or_default().push(number as u32);
    }
    let mut is_taken = vec![false; faces.len()];
    let mut groups = Vec::new();
    for start in 0..faces.len() {
        if is_taken[start] {
            continue;
        }
        is_taken[start] = true;
        let mut group = vec![start];
        let mut done = 0;
        while let Some(&number) = group.get(done) {
            done += 1;
            for_each_around(voxels, faces[number].voxel, |voxel| {
                for &next in of_voxel.get(&voxel).into_iter().flatten() {
                    if !std::mem::replace(&mut is_taken[next as usize], true) {
                        group.push(next as usize);
                    }
                }
            });
        }
        group.sort_unstable();
        groups.push(group.into_iter().map(|number| faces[number]).collect());
    }
    groups
}

/// Calls `visit` with a voxel and those that share a corner with it.
fn for_each_around(voxels: &RoomVoxels, voxel: u32, mut visit: impl FnMut(u32)) {
    let grid = &voxels.grid;
    let place = grid.place(voxel as usize);
    let near = |axis: usize| place[axis].saturating_sub(1)..(place[axis] + 2).min(grid.size[axis]);
    for y in near(1) {
        for z in near(2) {
            for x in near(0) {
                visit(grid.index([x, y, z]) as u32);
            }
        }
    }
}

/// Joins small groups to the largest group between the same rooms that they touch.
fn join_slivers(voxels: &RoomVoxels, groups: &mut Vec<(Key, Vec<Face>)>) {
    let face_area = voxels.grid.step.powi(2);
    let is_sliver = |faces: &[Face]| faces.len() as f64 * face_area < SLIVER;
    let mut of_voxel: HashMap<([u32; 2], u32), u32> = HashMap::new();
    for (number, (key, faces)) in groups.iter().enumerate() {
        if !is_sliver(faces) {
            for face in faces {
                of_voxel.entry((key.0, face.voxel)).or_insert(number as u32);
            }
        }
    }
    for number in 0..groups.len() {
        if !is_sliver(&groups[number].1) {
            continue;
        }
        let mut into: Option<u32> = None;
        let rooms = groups[number].0.0;
        for face in &groups[number].1 {
            for_each_around(voxels, face.voxel, |voxel| {
                if let Some(&group) = of_voxel.get(&(rooms, voxel)) {
                    let size = |group: u32| (groups[group as usize].1.len(), std::cmp::Reverse(group));
                    if into.is_none_or(|into| size(group) > size(into)) {
                        into = Some(group);
                    }
                }
            });
        }
        if let Some(into) = into {
            let faces = std::mem::take(&mut groups[number].1);
            groups[into as usize].1.extend(faces);
        }
    }
    groups.retain(|(_, faces)| !faces.is_empty());
}

/// Fits a rectangle to a group of faces.
fn portal(voxels: &RoomVoxels, (rooms, kind, leaf): Key, faces: &[Face]) -> RoomPortal {
    let step = voxels.grid.step;
    let centers: Vec<[f64; 3]> = faces
        .iter()
        .map(|face| {
            let mut at = voxels.grid.center(face.voxel as usize);
            at[face.axis as usize] += 0.5 * step;
            at
        })
        .collect();
    let count = centers.len() as f64;
    let mean = [0, 1, 2].map(|axis| centers.iter().map(|at| at[axis]).sum::<f64>() / count);
    let level = faces.iter().filter(|face| face.axis == 1).count();
    let is_level = 2 * level > faces.len();
    // Direction in plan along which the centres spread most.
    let spread = |a: usize, b: usize| -> f64 {
        centers
            .iter()
            .map(|at| (at[a] - mean[a]) * (at[b] - mean[b]))
            .sum()
    };
    let angle = 0.5 * (2.0 * spread(0, 2)).atan2(spread(0, 0) - spread(2, 2));
    let along = [angle.cos(), 0.0, angle.sin()];
    let across = [-along[2], 0.0, along[0]];
    let up = if is_level { across } else { [0.0, 1.0, 0.0] };
    let normal = if is_level { [0.0, 1.0, 0.0] } else { across };
    let reach = |direction: [f64; 3]| {
        let at = |center: &[f64; 3]| -> f64 {
            (0..3)
                .map(|axis| (center[axis] - mean[axis]) * direction[axis])
                .sum()
        };
        let low = centers.iter().map(at).fold(f64::INFINITY, f64::min) - 0.5 * step;
        let high = centers.iter().map(at).fold(f64::NEG_INFINITY, f64::max) + 0.5 * step;
        [low, high]
    };
    let [left, right] = reach(along);
    let [bottom, top] = reach(up);
    let corner = |a: f64, b: f64| {
        voxels
            .metric
            .scene([0, 1, 2].map(|axis| mean[axis] + a * along[axis] + b * up[axis]))
    };
    // Faces of a slanted boundary form steps: only their projection counts.
    let area: f64 = faces.iter().map(|face| normal[face.axis as usize].abs()).sum();
    RoomPortal {
        rooms,
        kind,
        leaf,
        area: area * step * step,
        polygon: [
            corner(left, bottom),
            corner(right, bottom),
            corner(right, top),
            corner(left, top),
        ],
    }
}
