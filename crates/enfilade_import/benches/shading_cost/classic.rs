//! A classic z-buffer: shades whenever a nearer face is written.
//!
//! Triangles are clipped at the near distance and filled row by row; a box outside the picture is left out.
//! Source: Catmull, A Subdivision Algorithm for Computer Display of Curved Surfaces, 1974.
//! Cost: clear O(samples); a triangle O(rows) + O(samples it covers), and a shading for each that it writes.
//! Shares no code with the engine's; where two faces are equally near the first stays, and glass is seen.

use crate::common::{Lens, SIZE, dye};
use enfilade::{Alpha, Geometry, ItemIndex, Owner};
use glam::DVec3;

/// The classic z-buffer: a reversed depth at each sample, and nothing else.
pub(crate) struct Classic {
    pub(crate) rev_depth: Vec<f32>,
    corners: Vec<DVec3>,
    /// Samples written by faces that hide.
    pub(crate) writes: u64,
}

impl Classic {
    pub(crate) fn new() -> Classic {
        Classic {
            rev_depth: vec![0.0; (SIZE[0] * SIZE[1]) as usize],
            corners: Vec::new(),
            writes: 0,
        }
    }

    /// Draws all faces that hide, then glass and cut-outs before what is there.
    pub(crate) fn draw(
        &mut self,
        geometry: &Geometry,
        lens: &Lens,
        shade: &mut impl FnMut(usize, usize, u32),
    ) {
        self.rev_depth.fill(0.0);
        self.writes = 0;
        for hides in [true, false] {
            for item in (0..geometry.items().len() as u32).map(ItemIndex) {
                self.item(geometry, item, lens, hides, shade);
            }
        }
    }

    fn item(
        &mut self,
        geometry: &Geometry,
        id: ItemIndex,
        lens: &Lens,
        hides: bool,
        shade: &mut impl FnMut(usize, usize, u32),
    ) {
        let (item, mesh) = (geometry.item(id), geometry.mesh_of(id));
        let screen_from_item = lens.screen_from(item);
        if !lens.may_show(&screen_from_item, &mesh.bounds()) {
            return;
        }
        for cluster in mesh.clusters() {
            let material = geometry.material(cluster);
            assert!(material.double_sided, "faces are not left out by their side here");
            if (material.alpha == Alpha::Opaque) != hides
                || !lens.may_show(&screen_from_item, &cluster.bounds)
            {
                continue;
            }
            let positions = cluster.positions.start as usize..cluster.positions.end as usize;
            let mut corners = std::mem::take(&mut self.corners);
            corners.clear();
            corners.extend(
                mesh.positions()[positions]
                    .iter()
                    .map(|corner| screen_from_item.transform_point3(DVec3::from(corner.map(f64::from)))),
            );
            for face in cluster.faces.clone() {
                let dye = dye(Owner::Face(id, face));
                let at = |index: u32| corners[(index - cluster.positions.start) as usize];
                let indices = mesh.face(face);
                for pair in indices[1..].windows(2) {
                    let triangle = [at(indices[0]), at(pair[0]), at(pair[1])];
                    self.triangle(triangle, lens.near, hides, &mut |x, y| shade(x, y, dye));
                }
            }
            self.corners = corners;
        }
    }

    fn triangle(
        &mut self,
        triangle: [DVec3; 3],
        near: f64,
        hides: bool,
        shade: &mut impl FnMut(usize, usize),
    ) {
        // Of a triangle seen edge-on no sample is inside.
        let normal = (triangle[1] - triangle[0]).cross(triangle[2] - triangle[0]);
        let distance = normal.dot(triangle[0]);
        if distance == 0.0 {
            return;
        }
        // 1 / W is linear on the screen: n · (x, y, 1) = d / W.
        let slope = normal / distance;
        let mut outline = [[0.0; 2]; 4];
        let mut count = 0;
        for (number, &corner) in triangle.iter().enumerate() {
            let next = triangle[(number + 1) % 3];
            let [here, there] = [corner.z - near, next.z - near];
            if here >= 0.0 {
                outline[count] = [corner.x / corner.z, corner.y / corner.z];
                count += 1;
            }
            if (here < 0.0) != (there < 0.0) {
                let at = corner + (next - corner) * (here / (here - there));
                outline[count] = [at.x / near, at.y / near];
                count += 1;
            }
        }
        let outline = &outline[..count];
        let [width, height] = SIZE.map(f64::from);
        let first = |edge: f64, end: f64| (edge - 0.5).ceil().clamp(0.0, end) as usize;
        let top = outline
            .iter()
            .fold(f64::INFINITY, |least, corner| least.min(corner[1]));
        let bottom = outline.iter().fold(0.0, |most: f64, corner| most.max(corner[1]));
        for y in first(top, height)..first(bottom, height) {
            let center = y as f64 + 0.5;
            let [mut left, mut right] = [f64::INFINITY, f64::NEG_INFINITY];
            for (number, from) in outline.iter().enumerate() {
                let to = outline[(number + 1) % count];
                if (from[1] <= center) != (to[1] <= center) {
                    let x = from[0] + (to[0] - from[0]) * ((center - from[1]) / (to[1] - from[1]));
                    [left, right] = [left.min(x), right.max(x)];
                }
            }
            let columns = first(left, width)..first(right, width).max(first(left, width));
            let row = y * SIZE[0] as usize;
            let start = (slope.y * center + slope.z) + slope.x * (columns.start as f64 + 0.5);
            for (step, x) in columns.enumerate() {
                let rev_depth = (start + slope.x * step as f64) as f32;
                let before = self.rev_depth[row + x];
                if hides && rev_depth > before {
                    self.rev_depth[row + x] = rev_depth;
                    self.writes += 1;
                    shade(x, y);
                } else if !hides && rev_depth >= before {
                    shade(x, y);
                }
            }
        }
    }
}
