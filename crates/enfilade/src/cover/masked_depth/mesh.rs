//! Whole meshes of occluders, as compact arrays.
//!
//! Faces keep the order that they come in, the largest or the nearest first, and are cut into parts of few corners, so that
//! what is known of a part's corners stays in the first cache. Positions stand sixteen by sixteen, each axis by itself.
//! Source: the order as in Hasselgren, Andersson, Akenine-Möller, Masked Software Occlusion Culling, HPG 2016, section 4.
//! Cost: O(faces).
//! Conservative: as [`super::batch`].

use super::MaskedDepth;
use super::batch::{Block, LANES};
use crate::faces::Faces;
use crate::passage::Passage;
use crate::stats::Stats;
use fearless_simd::prelude::*;
use fearless_simd::{dispatch, f32x16};
use glam::DVec3;
use std::collections::HashMap;
use std::ops::Range;

/// Triangles or flat convex quads that hide what is behind them, seen from their front alone.
#[derive(Clone, Debug, Default)]
pub struct OccluderMesh {
    blocks: Vec<Block>,
    /// Corners of triangles, as places among the positions of their part.
    corners: Vec<u32>,
    /// Of each triangle, sixteen by sixteen: n and d of its plane, n · p + d above zero before it.
    planes: Vec<[[f32; LANES]; 4]>,
    parts: Vec<Part>,
}

/// A run of triangles that share their corners with no other part.
#[derive(Clone, Debug)]
struct Part {
    blocks: Range<usize>,
    corners: Range<usize>,
    planes: Range<usize>,
}

/// The most corners of a part: 8 kB of them on the screen.
const MOST_CORNERS: usize = 512;

impl OccluderMesh {
    /// Triangles, as three indices into `positions` each, counter-clockwise seen from their front. One with a corner that
    /// is no number, or is not there, hides nothing.
    pub fn triangles(positions: &[[f32; 3]], corners: &[u32]) -> OccluderMesh {
        OccluderMesh::new(positions, corners, 3)
    }

    /// Flat convex quads, four indices each; else as [`OccluderMesh::triangles`].
    pub fn quads(positions: &[[f32; 3]], corners: &[u32]) -> OccluderMesh {
        OccluderMesh::new(positions, corners, 4)
    }

    fn new(positions: &[[f32; 3]], corners: &[u32], sides: usize) -> OccluderMesh {
        let mut mesh = OccluderMesh::default();
        let mut places = HashMap::new();
        let mut used = Vec::new();
        let mut first_corner = 0;
        for face in corners.chunks_exact(sides) {
            if used.len() + sides > MOST_CORNERS {
                mesh.close_part(&used, first_corner);
                first_corner = mesh.corners.len();
                used.clear();
                places.clear();
            }
            let mut at = [0; 4];
            for (at, &corner) in at.iter_mut().zip(face) {
                *at = *places.entry(corner).or_insert_with(|| {
                    let position = positions.get(corner as usize).copied();
                    used.push(position.unwrap_or([f32::NAN; 3]));
                    used.len() as u32 - 1
                });
            }
            for last in 2..sides {
                mesh.corners.extend([at[0], at[last - 1], at[last]]);
            }
        }
        mesh.close_part(&used, first_corner);
        mesh
    }

    fn close_part(&mut self, positions: &[[f32; 3]], first_corner: usize) {
        let first_block = self.blocks.len();
        self.blocks.extend(positions.chunks(LANES).map(block));
        let corners = first_corner..self.corners.len();
        let first_plane = self.planes.len();
        for faces in self.corners[corners.clone()].chunks(3 * LANES) {
            let mut planes = [[0.0; LANES]; 4];
            for (lane, face) in faces.as_chunks::<3>().0.iter().enumerate() {
                let [a, b, c] = face.map(|corner| DVec3::from(positions[corner as usize].map(f64::from)));
                let normal = (b - a).cross(c - a).normalize_or_zero();
                let plane = [normal.x, normal.y, normal.z, -normal.dot(a)];
                for (axis, value) in plane.into_iter().enumerate() {
                    planes[axis][lane] = value as f32;
                }
            }
            self.planes.push(planes);
        }
        self.parts.push(Part {
            blocks: first_block..self.blocks.len(),
            corners,
            planes: first_plane..self.planes.len(),
        });
    }

    /// Memory in bytes.
    pub fn bytes(&self) -> u64 {
        (size_of_val(&*self.blocks)
            + size_of_val(&*self.corners)
            + size_of_val(&*self.planes)
            + size_of_val(&*self.parts)) as u64
    }
}

/// Positions as a kernel takes them; what is missing is no number.
pub(super) fn block(positions: &[[f32; 3]]) -> Block {
    if let Some(whole) = positions.as_array::<LANES>() {
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

/// Keeps the triangles that the eye is not surely behind.
#[inline(always)]
fn keep_facing<S: Simd>(
    simd: S,
    planes: &[[[f32; LANES]; 4]],
    eye: [f32; 3],
    corners: &[u32],
    facing: &mut Vec<u32>,
) {
    /// What rounding may come to, relatively, and ample.
    const ROUNDING: f32 = 1.0 / (1_u32 << 20) as f32;
    for (planes, corners) in planes.iter().zip(corners.chunks(3 * LANES)) {
        let [a, b, c, d] = planes;
        let a = f32x16::from_slice(simd, a) * eye[0];
        let b = f32x16::from_slice(simd, b) * eye[1];
        let c = f32x16::from_slice(simd, c) * eye[2];
        let d = f32x16::from_slice(simd, d);
        let slack = (a.abs() + b.abs() + c.abs() + d.abs()) * ROUNDING;
        // Also of those of which nothing can be said.
        let behind = (a + b + c + d).simd_lt(-slack).to_bitmask();
        let kept = !behind & ((1 << (corners.len() / 3)) - 1);
        if kept == (1 << LANES) - 1 {
            facing.extend_from_slice(corners);
            continue;
        }
        let mut left = kept;
        while left != 0 {
            let at = 3 * left.trailing_zeros() as usize;
            facing.extend_from_slice(&corners[at..at + 3]);
            left &= left - 1;
        }
    }
}

impl MaskedDepth {
    /// Lets a mesh, in the space of the passage's fragment, hide what is behind it.
    pub fn hide_mesh(&mut self, mesh: &OccluderMesh, passage: &Passage, stats: &mut Stats) {
        let faces = Faces::of_triangles(&[], &[], &passage.screen_from_fragment);
        let eye = passage.eye().map(|at| at as f32);
        let mut facing = std::mem::take(&mut self.room.corners);
        for Part {
            blocks,
            corners,
            planes,
        } in &mesh.parts
        {
            let corners = &mesh.corners[corners.clone()];
            facing.clear();
            dispatch!(self.level, simd => keep_facing(simd, &mesh.planes[planes.clone()], eye, corners, &mut facing));
            if !facing.is_empty() {
                self.hide_triangles(&faces, &mesh.blocks[blocks.clone()], &facing, passage, stats);
            }
        }
        self.room.corners = facing;
    }
}
