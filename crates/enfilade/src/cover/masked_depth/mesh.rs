//! Whole meshes of occluders, as compact arrays.
//!
//! Faces keep the order that they come in, the largest or the nearest first, and are cut into parts of few corners, so that
//! what is known of a part's corners stays in the first cache. Positions stand sixteen by sixteen, each axis by itself. Of
//! triangles, two that follow each other and make a flat convex quad are merged to one.
//! Source: the order as in Hasselgren, Andersson, Akenine-Möller, Masked Software Occlusion Culling, HPG 2016, section 4.
//! Cost: O(faces).
//! Conservative: as [`super::batch`].

use super::MaskedDepth;
use super::batch::{Block, LANES};
use super::worker::Worker;
use crate::geom::Aabb;
use crate::passage::Passage;
use crate::stats::Stats;
use crate::threads;
use fearless_simd::prelude::*;
use fearless_simd::{f32x16, mask32x16};
use glam::DVec3;
use std::collections::HashMap;

/// Triangles or flat convex quads that hide what is behind them, seen from their front alone.
#[derive(Clone, Debug, Default)]
pub struct OccluderMesh {
    parts: Vec<Part>,
}

/// A run of faces that share their corners with no other part.
#[derive(Clone, Debug)]
pub(super) struct Part {
    /// Around all corners that are numbers.
    pub(super) bounds: Aabb,
    pub(super) blocks: Vec<Block>,
    pub(super) quads: Sided<4, 2>,
    pub(super) triangles: Sided<3, 1>,
}

/// Faces of so many sides, and triangles that each consists of.
#[derive(Clone, Debug, Default)]
pub(super) struct Sided<const SIDES: usize, const HALVES: usize> {
    /// Corners, as places among the positions of the part.
    faces: Vec<[u32; SIDES]>,
    /// Of sixteen faces: n and d of the planes of their triangles, n · p + d above zero before them.
    planes: Vec<[[[f32; LANES]; 4]; HALVES]>,
}

/// The most corners of a part: 8 kB of them on the screen.
const MAX_CORNERS: usize = 512;

impl OccluderMesh {
    /// Triangles, as three indices into `positions` each, counter-clockwise seen from their front. One with a corner that
    /// is no number, or is not there, hides nothing.
    pub fn triangles(positions: &[[f32; 3]], corners: &[u32]) -> OccluderMesh {
        let mut building = Building::new(positions);
        let triangles = corners.as_chunks().0;
        let mut next = 0;
        while let Some(&one) = triangles.get(next) {
            let merged = triangles
                .get(next + 1)
                .and_then(|&other| merged(positions, one, other));
            match merged {
                Some(quad) => building.add_quad(quad),
                None => building.add_triangle(one),
            }
            next += if merged.is_some() { 2 } else { 1 };
        }
        building.finish()
    }

    /// Flat convex quads, four indices each; else as [`OccluderMesh::triangles`].
    pub fn quads(positions: &[[f32; 3]], corners: &[u32]) -> OccluderMesh {
        let mut building = Building::new(positions);
        for quad in corners.as_chunks::<4>().0 {
            building.add_quad(*quad);
        }
        building.finish()
    }

    /// Memory in bytes.
    pub fn bytes(&self) -> u64 {
        let parts = self.parts.iter().map(|part| {
            size_of_val(part)
                + size_of_val(&*part.blocks)
                + size_of_val(&*part.quads.faces)
                + size_of_val(&*part.quads.planes)
                + size_of_val(&*part.triangles.faces)
                + size_of_val(&*part.triangles.planes)
        });
        parts.sum::<usize>() as u64
    }
}

/// Two triangles as one quad, of which they are the halves, if they share an edge and it is flat and convex.
pub(super) fn merged(positions: &[[f32; 3]], one: [u32; 3], other: [u32; 3]) -> Option<[u32; 4]> {
    /// A quad is so flat, by its size: what is nearer behind it is not hidden.
    const FLAT: f64 = 1e-4;
    let turns = |[a, b, c]: [u32; 3]| [[a, b, c], [b, c, a], [c, a, b]];
    let (one, other) = turns(one)
        .into_iter()
        .flat_map(|one| turns(other).map(|other| (one, other)))
        .find(|(one, other)| one[0] == other[0] && one[2] == other[1])?;
    let quad = [one[0], one[1], one[2], other[2]];
    let mut at = [DVec3::ZERO; 4];
    for (at, corner) in at.iter_mut().zip(quad) {
        *at = DVec3::from(positions.get(corner as usize)?.map(f64::from));
    }
    let [a, b, c, d] = at;
    let normal = (b - a).cross(c - a).normalize_or_zero();
    let is_flat = normal.dot(d - a).abs() <= FLAT * (c - a).length();
    let is_convex = [[d, a, b], [a, b, c], [b, c, d], [c, d, a]]
        .iter()
        .all(|[before, here, after]| (here - before).cross(after - here).dot(normal) > 0.0);
    (is_flat && is_convex).then_some(quad)
}

/// A mesh in the making.
struct Building<'a> {
    positions: &'a [[f32; 3]],
    parts: Vec<Part>,
    /// Of the part at hand: its faces, the places of their corners, and what is there.
    quads: Sided<4, 2>,
    triangles: Sided<3, 1>,
    places: HashMap<u32, u32>,
    used: Vec<[f32; 3]>,
}

impl<'a> Building<'a> {
    fn new(positions: &'a [[f32; 3]]) -> Building<'a> {
        Building {
            positions,
            parts: Vec::new(),
            quads: Sided::default(),
            triangles: Sided::default(),
            places: HashMap::new(),
            used: Vec::new(),
        }
    }

    fn add_triangle(&mut self, corners: [u32; 3]) {
        let face = self.place(corners);
        self.triangles.faces.push(face);
    }

    fn add_quad(&mut self, corners: [u32; 4]) {
        let face = self.place(corners);
        self.quads.faces.push(face);
    }

    /// The places of corners among those of the part at hand, which is another one where it would have too many.
    fn place<const SIDES: usize>(&mut self, corners: [u32; SIDES]) -> [u32; SIDES] {
        if self.used.len() + SIDES > MAX_CORNERS {
            self.close_part();
        }
        corners.map(|corner| {
            *self.places.entry(corner).or_insert_with(|| {
                let position = self.positions.get(corner as usize).copied();
                self.used.push(position.unwrap_or([f32::NAN; 3]));
                self.used.len() as u32 - 1
            })
        })
    }

    fn close_part(&mut self) {
        let is_number = |at: &&[f32; 3]| at.iter().all(|value| value.is_finite());
        self.quads.find_planes(&self.used);
        self.triangles.find_planes(&self.used);
        self.parts.push(Part {
            bounds: Aabb::of(self.used.iter().filter(is_number).copied()),
            blocks: self.used.chunks(LANES).map(block).collect(),
            quads: std::mem::take(&mut self.quads),
            triangles: std::mem::take(&mut self.triangles),
        });
        self.used.clear();
        self.places.clear();
    }

    fn finish(mut self) -> OccluderMesh {
        self.close_part();
        OccluderMesh { parts: self.parts }
    }
}

impl<const SIDES: usize, const HALVES: usize> Sided<SIDES, HALVES> {
    fn find_planes(&mut self, positions: &[[f32; 3]]) {
        for faces in self.faces.chunks(LANES) {
            let mut planes = [[[0.0; LANES]; 4]; HALVES];
            for (lane, face) in faces.iter().enumerate() {
                let at = face.map(|corner| DVec3::from(positions[corner as usize].map(f64::from)));
                for (half, planes) in planes.iter_mut().enumerate() {
                    let normal = (at[half + 1] - at[0])
                        .cross(at[half + 2] - at[0])
                        .normalize_or_zero();
                    let plane = [normal.x, normal.y, normal.z, -normal.dot(at[0])];
                    for (axis, value) in plane.into_iter().enumerate() {
                        planes[axis][lane] = value as f32;
                    }
                }
            }
            self.planes.push(planes);
        }
    }

    /// Keeps the faces that the eye is not surely behind.
    #[inline(always)]
    pub(super) fn keep_facing<S: Simd>(&self, simd: S, eye: [f32; 3], facing: &mut Vec<[u32; SIDES]>) {
        facing.clear();
        for (planes, faces) in self.planes.iter().zip(self.faces.chunks(LANES)) {
            let mut left = !behind(simd, planes, eye) & ((1 << faces.len()) - 1);
            if left == (1 << LANES) - 1 {
                facing.extend_from_slice(faces);
                continue;
            }
            while left != 0 {
                facing.push(faces[left.trailing_zeros() as usize]);
                left &= left - 1;
            }
        }
    }
}

/// A bit for each of sixteen faces that the eye is surely behind.
#[inline(always)]
fn behind<S: Simd, const HALVES: usize>(simd: S, planes: &[[[f32; LANES]; 4]; HALVES], eye: [f32; 3]) -> u64 {
    /// What rounding may come to, relatively, and ample.
    const ROUNDING: f32 = 1.0 / (1_u32 << 20) as f32;
    let mut behind = mask32x16::splat(simd, true);
    for [a, b, c, d] in planes {
        let a = f32x16::from_slice(simd, a) * eye[0];
        let b = f32x16::from_slice(simd, b) * eye[1];
        let c = f32x16::from_slice(simd, c) * eye[2];
        let d = f32x16::from_slice(simd, d);
        let slack = (a.abs() + b.abs() + c.abs() + d.abs()) * ROUNDING;
        // Also of those of which nothing can be said.
        behind &= (a + b + c + d).simd_lt(-slack);
    }
    behind.to_bitmask()
}

/// Positions as a kernel takes them; what is missing is no number.
pub(super) fn block(positions: &[[f32; 3]]) -> Block {
    if let Ok(whole) = <&[[f32; 3]; LANES]>::try_from(positions) {
        return [0, 1, 2].map(|axis| whole.map(|position| position[axis]));
    }
    let mut block = [[f32::NAN; LANES]; 3];
    for (lane, position) in positions.iter().enumerate() {
        for (axis, &value) in position.iter().enumerate() {
            block[axis][lane] = value;
        }
    }
    block
}

impl MaskedDepth {
    /// Lets a mesh, in the space of the passage's sector, hide what is behind it.
    pub fn hide_mesh(&mut self, mesh: &OccluderMesh, passage: &Passage, stats: &mut Stats) {
        self.worker
            .hide_parts(&mut self.grid.all(), &mesh.parts, passage, stats);
    }

    /// As [`MaskedDepth::hide_mesh`], in so many strips of rows, each by whatever thread is free, of the rayon pool that this is
    /// called in or else of the global one.
    ///
    /// Strips share nothing but the mesh: each sorts out by itself what reaches into it. What is hidden then is the same for
    /// any number of threads. It need not be for another number of strips: the two reversed depths of a sub-tile may be others,
    /// and neither is ever above the truth.
    pub fn hide_mesh_in_strips(
        &mut self,
        mesh: &OccluderMesh,
        passage: &Passage,
        strips: usize,
        stats: &mut Stats,
    ) {
        if self.workers.len() < strips {
            self.workers.resize_with(strips, || Worker::at(self.level));
        }
        let mut strips: Vec<_> = self
            .grid
            .strips(strips)
            .zip(&mut self.workers)
            .map(|(tiles, worker)| (tiles, worker, Stats::default()))
            .collect();
        threads::for_each(&mut strips, |_, (tiles, worker, stats)| {
            worker.hide_parts(tiles, &mesh.parts, passage, stats);
        });
        for (_, _, done) in &strips {
            stats.add(done);
        }
    }
}
