//! Doors, windows and openings: where two rooms meet and nothing opaque is between them.
//!
//! Cost: O(voxels), and O(open faces · leaves of doors) where leaves are.

use super::graph::{Door, DoorKind, RoomId, Sight};
use super::holes::Hole;
use super::input::{Bounds, Class, Metric};
use super::slice::NONE;
use super::voxels::RoomVoxels;
use super::{containing, rounded};
use glam::DVec3;
use rayon::prelude::*;
use std::collections::{BTreeMap, HashMap};

/// A face between two voxels of different rooms.
#[derive(Clone, Copy)]
struct Face {
    /// The lower voxel; the other is the next one along the axis.
    voxel: u32,
    axis: u8,
    /// Share of it that is open.
    open: f64,
}

/// Faces that belong together: rooms, kind and leaf.
type Key = ([u32; 2], DoorKind, Option<u32>);

/// Groups smaller than this, in square metres, are joined to a larger one that they touch.
const SLIVER: f64 = 0.3;

/// Openings smaller than this, in square metres, are gaps: nobody passes. So are parts of a door that lead elsewhere.
const GAP: f64 = 0.4;

pub(super) fn find(voxels: &RoomVoxels, classes: &[Class], bounds: &[Bounds], holes: &[Hole]) -> Vec<Door> {
    let grid = &voxels.grid;
    let slice_len = grid.slice_len();
    let strides = grid.strides();
    let of_slice = |slice: usize| {
        let mut faces = Vec::new();
        for voxel in slice * slice_len..(slice + 1) * slice_len {
            if !voxels.shows(voxel) {
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
                if one != other && one != NONE && other != NONE && voxels.shows(next) {
                    let face = Face {
                        voxel: voxel as u32,
                        axis: axis as u8,
                        open: 1.0,
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
    for &Hole {
        voxel,
        axis,
        open,
        leaf,
    } in holes
    {
        let next = voxel as usize + strides[axis as usize];
        let [one, other] = [voxel as usize, next].map(|voxel| voxels.labels[voxel]);
        let key = ([one.min(other), one.max(other)], DoorKind::Gap, leaf);
        by_key.entry(key).or_default().push(Face { voxel, axis, open });
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
    groups
        .iter()
        .map(|(key, faces)| door(voxels, *key, faces))
        .collect()
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
        return (rooms, DoorKind::Door, leaf.map(|item| item as u32));
    }
    let is_glass = pair.into_iter().any(|voxel| voxels.is_separating(voxel));
    let kind = if is_glass {
        DoorKind::Window
    } else {
        DoorKind::Opening
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
    let closes = |&(_, kind, leaf): &Key| kind == DoorKind::Door || leaf.is_some();
    for number in 0..groups.len() {
        // Holes beside a door are no part of it.
        if groups[number].0.1 == DoorKind::Gap || !is_sliver(&groups[number].1) {
            continue;
        }
        let mut into: Option<u32> = None;
        let own = groups[number].0;
        let rooms = own.0;
        // What a leaf does not close must not become part of what it closes.
        let may_join = |group: u32| {
            let other = &groups[group as usize].0;
            !closes(other) || (closes(&own) && other.2 == own.2)
        };
        for face in &groups[number].1 {
            for_each_around(voxels, face.voxel, |voxel| {
                if let Some(&group) = of_voxel.get(&(rooms, voxel)).filter(|&&group| may_join(group)) {
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
fn door(voxels: &RoomVoxels, (rooms, kind, leaf): Key, faces: &[Face]) -> Door {
    let step = voxels.grid.step;
    let centers: Vec<DVec3> = faces
        .iter()
        .map(|face| {
            let mut at = voxels.grid.center(face.voxel as usize);
            at[face.axis as usize] += 0.5 * step;
            DVec3::from(at)
        })
        .collect();
    let mean = centers.iter().sum::<DVec3>() / centers.len() as f64;
    let level = faces.iter().filter(|face| face.axis == 1).count();
    // Direction in plan along which the centres spread most.
    let spread = |a: usize, b: usize| -> f64 {
        centers
            .iter()
            .map(|at| (at[a] - mean[a]) * (at[b] - mean[b]))
            .sum()
    };
    let angle = 0.5 * (2.0 * spread(0, 2)).atan2(spread(0, 0) - spread(2, 2));
    let along = DVec3::new(angle.cos(), 0.0, angle.sin());
    let across = DVec3::new(-along.z, 0.0, along.x);
    let [up, normal] = if 2 * level > faces.len() {
        [across, DVec3::Y]
    } else {
        [DVec3::Y, across]
    };
    // Faces of a slanted boundary form steps: only their projection counts.
    let area: f64 = faces
        .iter()
        .map(|face| face.open * normal[face.axis as usize].abs())
        .sum();
    let kind = match kind {
        DoorKind::Opening | DoorKind::Door if area * step * step < GAP => DoorKind::Gap,
        kind => kind,
    };
    Door {
        rooms: rooms.map(RoomId),
        kind,
        leaf,
        area: rounded(area * step * step, f64::round),
        polygon: rectangle_along(&centers, [along, up], 0.5 * step, &voxels.metric),
        sights: sights(voxels, rooms[0], faces),
    }
}

/// Returns the rectangle around a flat outline in scene coordinates, upright unless the outline is level.
pub(super) fn rectangle(outline: &[[f64; 3]], metric: &Metric) -> [[f64; 3]; 4] {
    let points: Vec<DVec3> = outline.iter().map(|&at| DVec3::from(metric.metres(at))).collect();
    let next = points.iter().cycle().skip(1);
    let normal: DVec3 = points.iter().zip(next).map(|(a, b)| a.cross(*b)).sum();
    let along = normal.cross(DVec3::Y).normalize_or(DVec3::X);
    let is_level = normal.y.abs() > normal.x.hypot(normal.z);
    let up = if is_level { along.cross(DVec3::Y) } else { DVec3::Y };
    rectangle_along(&points, [along, up], 0.0, metric)
}

/// Returns the rectangle around points in metres with these directions, in scene coordinates to a tenth of a millimetre.
fn rectangle_along(points: &[DVec3], [along, up]: [DVec3; 2], margin: f64, metric: &Metric) -> [[f64; 3]; 4] {
    let mean = points.iter().sum::<DVec3>() / points.len() as f64;
    let reach = |direction: DVec3| {
        let places = || points.iter().map(|at| (*at - mean).dot(direction));
        [
            places().fold(f64::INFINITY, f64::min) - margin,
            places().fold(f64::NEG_INFINITY, f64::max) + margin,
        ]
    };
    let [left, right] = reach(along);
    let [bottom, top] = reach(up);
    [[left, bottom], [right, bottom], [right, top], [left, top]].map(|[a, b]| {
        let at = metric.scene((mean + a * along + b * up).into());
        at.map(|value| rounded(value, f64::round))
    })
}

/// Returns the boxes of the faces that point the same way.
fn sights(voxels: &RoomVoxels, first: u32, faces: &[Face]) -> Vec<Sight> {
    let Metric { up, .. } = voxels.metric;
    let mut boxes: BTreeMap<(u8, bool), Bounds> = BTreeMap::new();
    for face in faces {
        let goes_up = voxels.labels[face.voxel as usize] == first;
        let bounds = boxes.entry((face.axis, goes_up)).or_insert(Bounds::EMPTY);
        let place = voxels.grid.place(face.voxel as usize);
        let corner = |ahead: usize| {
            let at = |axis: usize| {
                let ahead = if axis == face.axis as usize { 1 } else { ahead };
                voxels.grid.origin[axis] + (place[axis] + ahead) as f64 * voxels.grid.step
            };
            voxels.metric.scene([at(0), at(1), at(2)])
        };
        bounds.add(corner(0));
        bounds.add(corner(1));
    }
    let sight = |((axis, goes_up), bounds): ((u8, bool), Bounds)| Sight {
        bounds: [
            bounds.min.map(|value| rounded(value, f64::floor)),
            bounds.max.map(|value| rounded(value, f64::ceil)),
        ],
        axis: up.scene_axis(axis),
        goes_up,
    };
    boxes.into_iter().map(sight).collect()
}
