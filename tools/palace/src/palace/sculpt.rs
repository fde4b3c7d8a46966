//! Sculpture: distance fields, and the meshes of their surfaces.
//!
//! A field is negative inside and grows at most about as fast as the distance. Its surface is found cell by cell and
//! then simplified, so that faces are small only where the surface bends.
//! Source: Gibson. Constrained elastic surface nets. 1998; Garland, Heckbert. Surface simplification using quadric error
//! metrics. 1997.

use super::palette::dress;
use crate::shape::{Dress, Shape};
use enfilade::{Attributes, Indices, MaterialId, Mesh, Part, Vertices};
use glam::{Vec3, vec3};
use meshopt::SimplifyOptions;
use rayon::prelude::*;
use std::collections::HashMap;
use std::sync::Arc;

/// Cells along the edge of a block; blocks far from the surface are skipped as a whole.
const BLOCK: i32 = 8;

/// A point of the grid, or the cell whose lowest corner it is.
type Cell = [i32; 3];

const AXES: [Cell; 3] = [[1, 0, 0], [0, 1, 0], [0, 0, 1]];

fn plus(a: Cell, b: Cell) -> Cell {
    [a[0] + b[0], a[1] + b[1], a[2] + b[2]]
}

fn minus(a: Cell, b: Cell) -> Cell {
    [a[0] - b[0], a[1] - b[1], a[2] - b[2]]
}

fn metric(cell: Cell) -> Vec3 {
    Vec3::from_array(cell.map(|value| value as f32))
}

/// Returns all cells of a box, along x first.
fn cells([wide, high, deep]: Cell) -> impl Iterator<Item = Cell> {
    (0..deep).flat_map(move |z| (0..high).flat_map(move |y| (0..wide).map(move |x| [x, y, z])))
}

/// Values at the corners of the cells of one block.
struct Block {
    first: Cell,
    values: Vec<f32>,
}

impl Block {
    fn at(&self, [x, y, z]: Cell) -> f32 {
        self.values[((z * (BLOCK + 1) + y) * (BLOCK + 1) + x) as usize]
    }
}

/// The triangles of a sculpture, with smooth normals.
#[derive(Default)]
pub(crate) struct Carved {
    pub(crate) positions: Vec<[f32; 3]>,
    pub(crate) normals: Vec<[f32; 3]>,
    pub(crate) corners: Vec<u32>,
}

/// Returns a field's surface within a box, from a grid of `step` metres, in at most about `faces` triangles.
pub(crate) fn carve(
    [low, high]: [Vec3; 2],
    step: f32,
    faces: usize,
    field: impl Fn(Vec3) -> f32 + Sync,
) -> Carved {
    let at = |cell: Cell| low + metric(cell) * step;
    // Cut off flat inside the box, so that the surface is closed.
    let [middle, half] = [0.5 * (low + high), 0.5 * (high - low) - 2.0 * step];
    let field = |point: Vec3| field(point).max(((point - middle).abs() - half).max_element());
    let near = blocks([low, high], step, &field);
    let mut vertex_of: HashMap<Cell, u32> = HashMap::new();
    let mut vertices: Vec<[f32; 3]> = Vec::new();
    for block in &near {
        for cell in cells([BLOCK; 3]) {
            if let Some(offset) = crossing(|of| block.at(plus(cell, of))) {
                let global = plus(block.first, cell);
                vertex_of.insert(global, vertices.len() as u32);
                vertices.push(settled(at(global) + offset * step, step, &field).to_array());
            }
        }
    }
    let mut indices: Vec<u32> = Vec::new();
    for block in &near {
        for cell in cells([BLOCK; 3]) {
            for axis in 0..3 {
                let [a, b] = [block.at(cell), block.at(plus(cell, AXES[axis]))];
                if (a < 0.0) == (b < 0.0) {
                    continue;
                }
                let [u, v] = [AXES[(axis + 1) % 3], AXES[(axis + 2) % 3]];
                let last = plus(block.first, cell);
                let around = [minus(minus(last, u), v), minus(last, v), last, minus(last, u)];
                let mut quad = around.map(|cell| {
                    let vertex = vertex_of.get(&cell).copied();
                    vertex.unwrap_or_else(|| panic!("a hole at {}", at(cell)))
                });
                if a >= 0.0 {
                    quad.reverse();
                }
                indices.extend([0, 1, 2, 0, 2, 3].map(|i: usize| quad[i]));
            }
        }
    }
    let most_error = 0.02;
    let simple = meshopt::simplify_decoder(
        &indices,
        &vertices,
        3 * faces,
        most_error,
        SimplifyOptions::None,
        None,
    );
    let mut carved = Carved::default();
    let mut numbers: HashMap<u32, u32> = HashMap::new();
    for vertex in simple {
        let number = *numbers.entry(vertex).or_insert_with(|| {
            let position = Vec3::from(vertices[vertex as usize]);
            carved.positions.push(position.to_array());
            let normal = slope(position, 0.5 * step, &field).normalize_or(Vec3::Y);
            carved.normals.push(normal.to_array());
            carved.positions.len() as u32 - 1
        });
        carved.corners.push(number);
    }
    carved
}

impl Carved {
    pub(crate) fn join(mut self, other: Carved) -> Carved {
        let first = self.positions.len() as u32;
        self.positions.extend(other.positions);
        self.normals.extend(other.normals);
        self.corners
            .extend(other.corners.into_iter().map(|corner| first + corner));
        self
    }

    /// Returns texture coordinates that run around the y axis from left to right, in front as behind, so that there is
    /// no seam. They are true to scale at a distance of `radius`.
    pub(crate) fn wrapped(&self, radius: f32, per_metre: f32) -> Vec<[f32; 2]> {
        (self.positions.iter())
            .map(|&[x, y, z]| [radius * z.abs().atan2(x) * per_metre, -y * per_metre])
            .collect()
    }

    /// Builds the mesh of a sculpture and of what belongs to it, raised by some metres.
    pub(crate) fn mesh(&self, material: MaterialId, with: &Shape, raised: f32) -> Arc<Mesh> {
        let up = |[x, y, z]: [f32; 3]| [x, y + raised, z];
        let positions: Vec<[f32; 3]> = self.positions.iter().copied().map(up).collect();
        let Dress::Textured { per_metre, .. } = dress(material) else {
            panic!("sculptures have texture");
        };
        let texture = self.wrapped(0.2, per_metre);
        let sculpture = Part {
            positions: Vertices::Packed(&positions),
            corners: Indices::U32(&self.corners),
            sides: None,
            material,
            attributes: Attributes {
                normals: Vertices::Packed(&self.normals),
                texture: Vertices::Packed(&texture),
                ..Attributes::default()
            },
        };
        let with = with.dressed(dress);
        let lifted: Vec<[f32; 3]> = with.positions().iter().copied().map(up).collect();
        let sheets: Vec<(MaterialId, Vec<u32>, Vec<u32>)> = (with.clusters().iter())
            .map(|cluster| {
                let faces = || cluster.faces.clone().map(|face| with.face(face));
                let corners = faces().flatten().copied().collect();
                (
                    cluster.material,
                    corners,
                    faces().map(|face| face.len() as u32).collect(),
                )
            })
            .collect();
        let others = sheets.iter().map(|(material, corners, sides)| Part {
            positions: Vertices::Packed(&lifted),
            corners: Indices::U32(corners),
            sides: Some(sides),
            material: *material,
            attributes: Attributes {
                normals: Vertices::Packed(with.normals()),
                texture: Vertices::Packed(with.texture()),
                ..Attributes::default()
            },
        });
        let parts: Vec<Part> = std::iter::once(sculpture).chain(others).collect();
        Arc::new(Mesh::new(&parts).expect("sculptures consist of sound triangles"))
    }
}

/// Evaluates a field in all blocks near its surface.
fn blocks([low, high]: [Vec3; 2], step: f32, field: &(impl Fn(Vec3) -> f32 + Sync)) -> Vec<Block> {
    let size = step * BLOCK as f32;
    let counts = ((high - low) / size).ceil().to_array().map(|count| count as i32);
    // Fields grow at most twice as fast as the distance.
    let far = 2.0 * 0.5 * size * 3.0_f32.sqrt();
    let all: Vec<Cell> = cells(counts).collect();
    all.into_par_iter()
        .filter_map(|block| {
            let first = block.map(|count| count * BLOCK);
            let at = |cell: Cell| low + metric(plus(first, cell)) * step;
            let is_near = field(at([0; 3]) + 0.5 * size).abs() <= far;
            is_near.then(|| Block {
                first,
                values: cells([BLOCK + 1; 3]).map(|cell| field(at(cell))).collect(),
            })
        })
        .collect()
}

/// Returns the mean of the points where the edges of a unit cell cross the surface, or `None` if none does.
fn crossing(value: impl Fn(Cell) -> f32) -> Option<Vec3> {
    let (mut sum, mut count) = (Vec3::ZERO, 0.0);
    for axis in 0..3 {
        let [u, v] = [AXES[(axis + 1) % 3], AXES[(axis + 2) % 3]];
        for start in [[0; 3], u, v, plus(u, v)] {
            let [a, b] = [value(start), value(plus(start, AXES[axis]))];
            if (a < 0.0) != (b < 0.0) {
                sum += metric(start) + Vec3::AXES[axis] * (a / (a - b));
                count += 1.0;
            }
        }
    }
    (count > 0.0).then(|| sum / count)
}

/// Returns the gradient of a field, from differences over `tiny` metres.
pub(crate) fn slope(point: Vec3, tiny: f32, field: &impl Fn(Vec3) -> f32) -> Vec3 {
    Vec3::from_array([0, 1, 2].map(|axis| {
        let off = Vec3::AXES[axis] * tiny;
        (field(point + off) - field(point - off)) / (2.0 * tiny)
    }))
}

/// Moves a point onto the surface, by at most one step.
fn settled(point: Vec3, step: f32, field: &impl Fn(Vec3) -> f32) -> Vec3 {
    let slope = slope(point, 0.25 * step, field);
    let off = slope * (field(point) / slope.length_squared().max(0.01));
    point - off.clamp_length_max(step)
}

/// Returns the union of two fields, rounded over about `soft` metres where they meet.
pub(crate) fn joined(a: f32, b: f32, soft: f32) -> f32 {
    let part = (soft - (a - b).abs()).max(0.0) / soft;
    a.min(b) - 0.25 * part * part * soft
}

/// Returns the first field without the second, rounded over about `soft` metres.
pub(crate) fn without(a: f32, b: f32, soft: f32) -> f32 {
    -joined(-a, b, soft)
}

/// Returns what is in both fields, rounded over about `soft` metres.
pub(crate) fn both(a: f32, b: f32, soft: f32) -> f32 {
    -joined(-a, -b, soft)
}

/// A ball stretched to three half axes.
pub(crate) fn egg(point: Vec3, middle: Vec3, half: Vec3) -> f32 {
    let off = point - middle;
    let [one, two] = [(off / half).length(), (off / (half * half)).length()];
    if two < 1e-6 {
        -half.min_element()
    } else {
        one * (one - 1.0) / two
    }
}

/// A limb from one joint to the next, with a radius at each.
pub(crate) fn limb(point: Vec3, [from, to]: [Vec3; 2], [thick, thin]: [f32; 2]) -> f32 {
    let [along, off] = [to - from, point - from];
    let part = (off.dot(along) / along.length_squared()).clamp(0.0, 1.0);
    (off - along * part).length() - (thick + (thin - thick) * part)
}

/// A row of limbs through joints, all of one radius.
pub(crate) fn cord(point: Vec3, joints: &[Vec3], radius: f32) -> f32 {
    joints
        .windows(2)
        .map(|pair| limb(point, [pair[0], pair[1]], [radius; 2]))
        .fold(f32::MAX, f32::min)
}

/// A ring about an axis.
pub(crate) fn ring(point: Vec3, middle: Vec3, axis: Vec3, radius: f32, thick: f32) -> f32 {
    let off = point - middle;
    let up = off.dot(axis);
    let out = (off - axis * up).length() - radius;
    (out * out + up * up).sqrt() - thick
}

/// Returns the point on the side of positive x, of it and its mirror image.
pub(crate) fn mirrored(point: Vec3) -> Vec3 {
    vec3(point.x.abs(), point.y, point.z)
}

/// Returns 0 below `from`, 1 above `to`, and a smooth step between.
pub(crate) fn ramp(from: f32, to: f32, value: f32) -> f32 {
    let part = ((value - from) / (to - from)).clamp(0.0, 1.0);
    part * part * (3.0 - 2.0 * part)
}
