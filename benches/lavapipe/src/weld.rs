//! Flat faces that share their corners, as an index buffer wants them.
//!
//! A face's normal and colour are those of its first corner: shaders are told not to interpolate them. So a corner serves
//! as the first of faces in one plane only, but as the second or third of any; nearly no corner is needed twice.

use bytemuck::{Pod, Zeroable};
use glam::DVec3;
use std::collections::HashMap;

/// A corner, 28 bytes.
#[derive(Clone, Copy, Pod, Zeroable)]
#[repr(C)]
pub(crate) struct Vertex {
    pub(crate) position: [f32; 3],
    /// Of the faces whose first corner this is, in steps of 1/32767; the last is unused.
    pub(crate) normal: [i16; 4],
    /// Their linear colour and coverage, in steps of 1/65535.
    pub(crate) color: [u16; 4],
}

/// A normal and a colour, as they are stored.
#[derive(Clone, Copy, PartialEq, Eq)]
pub(crate) struct Look {
    normal: [i16; 4],
    color: [u16; 4],
}

impl Look {
    pub(crate) fn new(normal: DVec3, color: [f32; 4]) -> Look {
        let normal = (normal * 32767.0).round();
        Look {
            normal: [normal.x as i16, normal.y as i16, normal.z as i16, 0],
            color: color.map(|part| (part.clamp(0.0, 1.0) * 65535.0).round() as u16),
        }
    }
}

/// Corners as they are gathered.
#[derive(Default)]
pub(crate) struct Weld {
    pub(crate) vertices: Vec<Vertex>,
    /// Who the first corner is of; `None`: of nobody yet.
    looks: Vec<Option<Look>>,
    /// The vertices at each corner of the mesh at hand: the first, and those that were needed besides.
    places: HashMap<u32, Vec<u32>>,
}

impl Weld {
    /// The corners of another mesh follow: nothing is shared with those before.
    pub(crate) fn start(&mut self) {
        self.places.clear();
    }

    /// The indices of a triangle, turned so that its first corner has its look. `at`: the mesh's numbers of its corners.
    pub(crate) fn triangle(&mut self, at: [u32; 3], positions: [[f32; 3]; 3], look: Look) -> [u32; 3] {
        let found = (0..3).find_map(|turn| Some((turn, self.first(at[turn], positions[turn], look)?)));
        let (turn, first) = found.unwrap_or_else(|| (0, self.add(at[0], positions[0])));
        self.looks[first as usize] = Some(look);
        let [second, third] = [1, 2].map(|after| {
            let corner = (turn + after) % 3;
            self.any(at[corner], positions[corner])
        });
        [first, second, third]
    }

    /// The looks are written into the vertices.
    pub(crate) fn finish(mut self) -> Vec<Vertex> {
        for (vertex, look) in self.vertices.iter_mut().zip(&self.looks) {
            if let Some(Look { normal, color }) = *look {
                (vertex.normal, vertex.color) = (normal, color);
            }
        }
        self.vertices
    }

    /// A vertex at a corner that is of this look, or of nobody yet.
    fn first(&mut self, at: u32, position: [f32; 3], look: Look) -> Option<u32> {
        let Some(here) = self.places.get(&at) else {
            return Some(self.add(at, position));
        };
        let fits = |vertex: &&u32| self.looks[**vertex as usize].is_none_or(|found| found == look);
        here.iter().find(fits).copied()
    }

    /// A vertex at a corner, whatever its look.
    fn any(&mut self, at: u32, position: [f32; 3]) -> u32 {
        match self.places.get(&at) {
            Some(here) => here[0],
            None => self.add(at, position),
        }
    }

    fn add(&mut self, at: u32, position: [f32; 3]) -> u32 {
        let vertex = self.vertices.len() as u32;
        self.vertices.push(Vertex {
            position,
            normal: [0; 4],
            color: [0; 4],
        });
        self.looks.push(None);
        self.places.entry(at).or_default().push(vertex);
        vertex
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn each_triangle_shows_its_own_look_and_no_more_vertices_than_triangles_are_needed() {
        let mut weld = Weld::default();
        weld.start();
        let side = 20;
        let mut expected = Vec::new();
        for y in 0..side {
            for x in 0..side {
                let corner = |x: u32, y: u32| y * (side + 1) + x;
                let [a, b, c, d] = [
                    corner(x, y),
                    corner(x + 1, y),
                    corner(x + 1, y + 1),
                    corner(x, y + 1),
                ];
                for at in [[a, b, c], [a, c, d]] {
                    // Each triangle is of a plane of its own.
                    let look = Look::new(
                        DVec3::new(f64::from(expected.len() as u32) / 1000.0, 0.0, 1.0),
                        [0.5; 4],
                    );
                    expected.push((
                        weld.triangle(at, at.map(|at| [at as f32, 0.0, 0.0]), look),
                        at,
                        look,
                    ));
                }
            }
        }
        let vertices = weld.finish();
        for (indices, at, look) in expected {
            assert_eq!(vertices[indices[0] as usize].normal, look.normal);
            let [a, b, c] = indices.map(|index| vertices[index as usize].position[0] as u32);
            assert!(
                [[a, b, c], [b, c, a], [c, a, b]].contains(&at),
                "a triangle must not be turned over"
            );
        }
        // Twice as many triangles as corners: so many firsts are needed.
        assert!(
            vertices.len() < (side * side * 2 + 2 * side) as usize,
            "{}",
            vertices.len()
        );
    }
}
