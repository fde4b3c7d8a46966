//! Stands in for whole meshes of occluders until their kernels are there: one after the other, as chosen occluders.

use super::MaskedDepth;
use super::tile::{COLUMNS, ROWS};
use crate::aperture::Rect;
use crate::cover::Hides;
use crate::occluders::Occluder;
use crate::passage::Passage;
use crate::stats::Stats;
use glam::DVec3;

/// Triangles or quads that hide.
#[derive(Clone, Debug)]
pub struct OccluderMesh {
    positions: Vec<[f32; 3]>,
    corners: Vec<u32>,
    sides: usize,
}

impl OccluderMesh {
    /// Triangles, three corners each.
    pub fn triangles(positions: &[[f32; 3]], corners: &[u32]) -> OccluderMesh {
        OccluderMesh {
            positions: positions.to_vec(),
            corners: corners.to_vec(),
            sides: 3,
        }
    }

    /// Planar convex quads.
    pub fn quads(positions: &[[f32; 3]], corners: &[u32]) -> OccluderMesh {
        OccluderMesh {
            sides: 4,
            ..OccluderMesh::triangles(positions, corners)
        }
    }
}

impl MaskedDepth {
    /// Lets a mesh hide what is behind it.
    pub fn hide_mesh(&mut self, mesh: &OccluderMesh, passage: &Passage, stats: &mut Stats) {
        for face in mesh.corners.chunks_exact(mesh.sides) {
            let mut at = [DVec3::ZERO; 4];
            for (at, &corner) in at.iter_mut().zip(face) {
                let position = DVec3::from(mesh.positions[corner as usize].map(f64::from));
                *at = passage.screen_from_fragment.transform_point3(position);
            }
            let corners = &at[..mesh.sides];
            let normal = (at[1] - at[0]).cross(at[2] - at[0]);
            let distance = normal.dot(at[0]);
            if distance < 0.0 {
                let occluder = Occluder {
                    corners,
                    plane: (-normal, -distance),
                };
                self.hide(&occluder, passage, stats);
            }
        }
    }

    /// May something as near as `nearest` be seen in the rectangle?
    pub fn sees_rect(&self, rect: &Rect, nearest: f32) -> bool {
        self.grid
            .first_seen(&rect.intersection(&self.grid.rect), nearest)
            .is_some()
    }

    /// Something is at least as near at this sample; 0 where nothing is known.
    pub fn nearness_at(&self, x: u16, y: u16) -> f32 {
        let [x, y] = [usize::from(x), usize::from(y)];
        self.grid.tiles[y / ROWS * self.grid.columns + x / COLUMNS].known(x % COLUMNS, y % ROWS)
    }
}
