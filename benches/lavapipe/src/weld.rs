//! Flat-shaded faces with shared vertices.
//!
//! A face's normal and colour are those of its first vertex, because shaders do not interpolate them. So a vertex can
//! be the first of faces with one normal and colour only, but the second or third of any; few vertices need duplicates.

use bytemuck::{Pod, Zeroable};
use glam::DVec3;
use std::collections::HashMap;

/// A vertex, 28 bytes.
#[derive(Clone, Copy, Pod, Zeroable)]
#[repr(C)]
pub(crate) struct Vertex {
    pub(crate) position: [f32; 3],
    /// Normal of the faces whose first vertex this is, in steps of 1/32767; the last component is unused.
    pub(crate) normal: [i16; 4],
    /// Their linear colour and coverage, in steps of 1/65535.
    pub(crate) color: [u16; 4],
}

/// A normal and a colour in vertex format.
#[derive(Clone, Copy, PartialEq, Eq)]
pub(crate) struct Shade {
    normal: [i16; 4],
    color: [u16; 4],
}

impl Shade {
    pub(crate) fn new(normal: DVec3, color: [f32; 4]) -> Shade {
        let normal = (normal * 32767.0).round();
        Shade {
            normal: [normal.x as i16, normal.y as i16, normal.z as i16, 0],
            color: color.map(|part| (part.clamp(0.0, 1.0) * 65535.0).round() as u16),
        }
    }
}

/// Vertices under construction.
#[derive(Default)]
pub(crate) struct Weld {
    pub(crate) vertices: Vec<Vertex>,
    /// Shade of the faces whose first vertex this is; `None` if not the first of any yet.
    shades: Vec<Option<Shade>>,
    /// The vertices at each corner of the current mesh: the first, and its duplicates.
    places: HashMap<u32, Vec<u32>>,
}

impl Weld {
    /// Starts the next mesh; it shares no vertices with those before.
    pub(crate) fn start(&mut self) {
        self.places.clear();
    }

    /// Returns the indices of a triangle, rotated so that its first vertex has its shade. `at` holds the mesh's corner
    /// indices.
    pub(crate) fn triangle(&mut self, at: [u32; 3], positions: [[f32; 3]; 3], shade: Shade) -> [u32; 3] {
        let found = (0..3).find_map(|turn| Some((turn, self.first(at[turn], positions[turn], shade)?)));
        let (turn, first) = found.unwrap_or_else(|| (0, self.add(at[0], positions[0])));
        self.shades[first as usize] = Some(shade);
        let [second, third] = [1, 2].map(|after| {
            let corner = (turn + after) % 3;
            self.any(at[corner], positions[corner])
        });
        [first, second, third]
    }

    /// Writes the shades into the vertices and returns them.
    pub(crate) fn finish(mut self) -> Vec<Vertex> {
        for (vertex, shade) in self.vertices.iter_mut().zip(&self.shades) {
            if let Some(Shade { normal, color }) = *shade {
                (vertex.normal, vertex.color) = (normal, color);
            }
        }
        self.vertices
    }

    /// Returns a vertex at a corner that has this shade, or none yet.
    fn first(&mut self, at: u32, position: [f32; 3], shade: Shade) -> Option<u32> {
        let Some(here) = self.places.get(&at) else {
            return Some(self.add(at, position));
        };
        let fits = |vertex: &&u32| self.shades[**vertex as usize].is_none_or(|found| found == shade);
        here.iter().find(fits).copied()
    }

    /// Returns a vertex at a corner, whatever its shade.
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
        self.shades.push(None);
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
                    // Each triangle has a different plane.
                    let shade = Shade::new(
                        DVec3::new(f64::from(expected.len() as u32) / 1000.0, 0.0, 1.0),
                        [0.5; 4],
                    );
                    expected.push((
                        weld.triangle(at, at.map(|at| [at as f32, 0.0, 0.0]), shade),
                        at,
                        shade,
                    ));
                }
            }
        }
        let vertices = weld.finish();
        for (indices, at, shade) in expected {
            assert_eq!(vertices[indices[0] as usize].normal, shade.normal);
            let [a, b, c] = indices.map(|index| vertices[index as usize].position[0] as u32);
            assert!(
                [[a, b, c], [b, c, a], [c, a, b]].contains(&at),
                "a triangle must not be turned over"
            );
        }
        // There are twice as many triangles as corners, so as many first vertices are needed.
        assert!(
            vertices.len() < (side * side * 2 + 2 * side) as usize,
            "{}",
            vertices.len()
        );
    }
}
