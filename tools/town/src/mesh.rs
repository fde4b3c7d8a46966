//! The mesh of one item under construction, and the shapes that it is built from.

use crate::material::Material;
use crate::random::Random;
use crate::vector::{Frame, Vector, v};
use std::f64::consts::TAU;

/// Positions are multiples of 1 / `STEPS` metres, so that f32 holds them exactly in tiles and in the whole town, and
/// vertices that neighbours share stay equal.
pub(crate) const STEPS: f64 = 4096.0;

/// The faces of one material.
#[derive(Default)]
pub(crate) struct Part {
    /// In steps, relative to the tile.
    pub(crate) positions: Vec<[i32; 3]>,
    pub(crate) normals: Vec<[i8; 3]>,
    pub(crate) indices: Vec<u32>,
}

/// An indexed mesh with flat or smooth normals, its faces sorted by material.
pub(crate) struct Mesh {
    /// The frame in which the shapes below are given.
    pub(crate) frame: Frame,
    /// The material of the faces that are added.
    pub(crate) material: Material,
    /// Random numbers of this item alone.
    pub(crate) random: Random,
    /// Density of the triangles that describe small details, relative to a tile of about two million.
    level: f64,
    /// Whether triangles are only counted.
    counting: bool,
    parts: Vec<(Material, Part)>,
    triangles: usize,
}

/// How an extrusion ends.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum End {
    Open,
    Cap,
    /// Longer by the z of each point: meets another extrusion at an outer corner of 90°.
    Mitre,
}

impl Mesh {
    pub(crate) fn new(random: Random, level: f64, counting: bool) -> Mesh {
        Mesh {
            frame: Frame::TILE,
            material: Material::Stone,
            random,
            level,
            counting,
            parts: Vec::new(),
            triangles: 0,
        }
    }

    pub(crate) fn triangles(&self) -> usize {
        self.triangles
    }

    /// Returns the parts, sorted by material.
    pub(crate) fn into_parts(mut self) -> Vec<(Material, Part)> {
        self.parts.sort_by_key(|(material, _)| *material);
        self.parts
    }

    /// Returns the number of segments of a curve that has `at_one` at level 1. Rounds at random, so that the
    /// triangles of a tile grow steadily with the level.
    pub(crate) fn segments(&mut self, at_one: f64, min: usize) -> usize {
        let exact = at_one * self.level.sqrt();
        ((exact + self.random.unit()) as usize).clamp(min, 96)
    }

    /// Returns a number of things whose size does not depend on the level, such as leaves.
    pub(crate) fn many(&mut self, at_one: f64, min: usize) -> usize {
        ((at_one * self.level + self.random.unit()) as usize).max(min)
    }

    /// Returns the size of the pieces that cover an area, such as roof tiles, within limits.
    pub(crate) fn piece(&self, at_one: f64, [min, max]: [f64; 2]) -> f64 {
        (at_one / self.level.sqrt()).clamp(min, max)
    }

    fn part(&mut self) -> &mut Part {
        let found = self.parts.iter().position(|(used, _)| *used == self.material);
        let index = found.unwrap_or_else(|| {
            self.parts.push((self.material, Part::default()));
            self.parts.len() - 1
        });
        &mut self.parts[index].1
    }

    /// Adds vertices with normals, and triangles between them by their number among the vertices.
    fn add(&mut self, vertices: &[(Vector, Vector)], triangles: &[[u32; 3]]) {
        self.triangles += triangles.len();
        if self.counting {
            return;
        }
        let frame = self.frame;
        let part = self.part();
        let start = part.positions.len() as u32;
        for &(at, normal) in vertices {
            let at = frame.point(at);
            let normal = frame.direction(normal);
            part.positions
                .push([at.x, at.y, at.z].map(|metres| (metres * STEPS).round() as i32));
            part.normals
                .push([normal.x, normal.y, normal.z].map(|share| (share * 127.0).round() as i8));
        }
        let corners = triangles.as_flattened();
        part.indices.extend(corners.iter().map(|corner| start + corner));
    }

    /// Adds a flat convex polygon, counter-clockwise from its front.
    pub(crate) fn polygon(&mut self, corners: &[Vector]) {
        let count = corners.len() as u32;
        let across = |i: usize| (corners[i] - corners[0]).cross(corners[i + 1] - corners[0]);
        let normal = (1..corners.len() - 1).fold(Vector::ZERO, |sum, i| sum + across(i));
        let normal = normal.unit();
        let vertices: Vec<_> = corners.iter().map(|&corner| (corner, normal)).collect();
        let triangles: Vec<_> = (1..count - 1).map(|i| [0, i, i + 1]).collect();
        self.add(&vertices, &triangles);
    }

    pub(crate) fn quad(&mut self, a: Vector, b: Vector, c: Vector, d: Vector) {
        let normal = (c - a).cross(d - b).unit();
        self.add(
            &[(a, normal), (b, normal), (c, normal), (d, normal)],
            &[[0, 1, 2], [0, 2, 3]],
        );
    }

    /// Adds a quad whose corners have normals of their own.
    pub(crate) fn smooth_quad(&mut self, corners: [(Vector, Vector); 4]) {
        self.add(&corners, &[[0, 1, 2], [0, 2, 3]]);
    }

    /// Adds a grid of quads with smooth normals: `at` returns the position and the normal of a column and a row. Its
    /// front is where rows run to the left of columns.
    pub(crate) fn grid(
        &mut self,
        [columns, rows]: [usize; 2],
        at: impl Fn(usize, usize) -> (Vector, Vector),
    ) {
        if self.counting {
            self.triangles += 2 * columns * rows;
            return;
        }
        let mut vertices = Vec::with_capacity((columns + 1) * (rows + 1));
        let mut triangles = Vec::with_capacity(2 * columns * rows);
        let wide = columns as u32 + 1;
        for row in 0..=rows {
            for column in 0..=columns {
                vertices.push(at(column, row));
                if column < columns && row < rows {
                    let corner = row as u32 * wide + column as u32;
                    triangles.push([corner, corner + 1, corner + wide + 1]);
                    triangles.push([corner, corner + wide + 1, corner + wide]);
                }
            }
        }
        self.add(&vertices, &triangles);
    }

    /// Adds a box with all six faces.
    pub(crate) fn cuboid(&mut self, low: Vector, high: Vector) {
        self.open_cuboid(low, high);
        let ([x0, y, z0], [x1, z1]) = ([low.x, low.y, low.z], [high.x, high.z]);
        self.quad(v(x0, y, z0), v(x1, y, z0), v(x1, y, z1), v(x0, y, z1));
    }

    /// Adds a box without its lower face.
    pub(crate) fn open_cuboid(&mut self, low: Vector, high: Vector) {
        let ([x0, y0, z0], [x1, y1, z1]) = ([low.x, low.y, low.z], [high.x, high.y, high.z]);
        self.quad(v(x0, y0, z1), v(x1, y0, z1), v(x1, y1, z1), v(x0, y1, z1));
        self.quad(v(x1, y0, z0), v(x0, y0, z0), v(x0, y1, z0), v(x1, y1, z0));
        self.quad(v(x1, y0, z1), v(x1, y0, z0), v(x1, y1, z0), v(x1, y1, z1));
        self.quad(v(x0, y0, z0), v(x0, y0, z1), v(x0, y1, z1), v(x0, y1, z0));
        self.quad(v(x0, y1, z1), v(x1, y1, z1), v(x1, y1, z0), v(x0, y1, z0));
    }

    /// Adds the inside of a box, without its face toward +z.
    pub(crate) fn niche(&mut self, low: Vector, high: Vector) {
        let ([x0, y0, z0], [x1, y1, z1]) = ([low.x, low.y, low.z], [high.x, high.y, high.z]);
        self.quad(v(x0, y0, z0), v(x1, y0, z0), v(x1, y1, z0), v(x0, y1, z0));
        self.quad(v(x0, y0, z1), v(x0, y0, z0), v(x0, y1, z0), v(x0, y1, z1));
        self.quad(v(x1, y0, z0), v(x1, y0, z1), v(x1, y1, z1), v(x1, y1, z0));
        self.quad(v(x0, y0, z1), v(x1, y0, z1), v(x1, y0, z0), v(x0, y0, z0));
        self.quad(v(x0, y1, z0), v(x1, y1, z0), v(x1, y1, z1), v(x0, y1, z1));
    }

    /// Adds a stone on the ground, with a worn upper edge: ten triangles. x and z are its outline, y its height.
    pub(crate) fn stone(&mut self, low: Vector, high: Vector, worn: f64) {
        let corners = [
            (low.x, high.z, [-1.0, 1.0]),
            (high.x, high.z, [1.0, 1.0]),
            (high.x, low.z, [1.0, -1.0]),
            (low.x, low.z, [-1.0, -1.0]),
        ];
        let [mut below, mut above] = [[(Vector::ZERO, Vector::Y); 4]; 2];
        for (i, (x, z, [right, front])) in corners.into_iter().enumerate() {
            below[i] = (v(x, low.y, z), v(right, 0.5, front).unit());
            let top = v(x - right * worn, high.y, z - front * worn);
            above[i] = (top, v(0.3 * right, 1.0, 0.3 * front).unit());
        }
        let [[a, b, c, d], [e, f, g, h]] = [below, above];
        self.add(
            &[a, b, c, d, e, f, g, h],
            &[
                [0, 1, 5],
                [0, 5, 4],
                [1, 2, 6],
                [1, 6, 5],
                [2, 3, 7],
                [2, 7, 6],
                [3, 0, 4],
                [3, 4, 7],
                [4, 5, 6],
                [4, 6, 7],
            ],
        );
    }

    /// Extrudes a profile along x: (y, z) from the lower inner point outward and up to the upper inner one.
    pub(crate) fn extrude(&mut self, [x0, x1]: [f64; 2], profile: &[(f64, f64)], [left, right]: [End; 2]) {
        let at_left = |(y, z): (f64, f64)| v(if left == End::Mitre { x0 - z } else { x0 }, y, z);
        let at_right = |(y, z): (f64, f64)| v(if right == End::Mitre { x1 + z } else { x1 }, y, z);
        for pair in profile.windows(2) {
            self.quad(
                at_left(pair[0]),
                at_right(pair[0]),
                at_right(pair[1]),
                at_left(pair[1]),
            );
        }
        // Fans start at the upper inner end, from which also hollow profiles are visible.
        let is_closed = profile.first() == profile.last();
        let mut outline = profile[usize::from(is_closed)..].to_vec();
        outline.rotate_right(1);
        if left == End::Cap {
            let corners: Vec<_> = outline.iter().copied().map(at_left).collect();
            self.polygon(&corners);
        }
        if right == End::Cap {
            outline[1..].reverse();
            let corners: Vec<_> = outline.iter().copied().map(at_right).collect();
            self.polygon(&corners);
        }
    }

    /// Adds a rectangular frame in the x-y plane: a profile of (inset, z) from its outer to its inner edge, mitred at
    /// the corners.
    pub(crate) fn ring(&mut self, [x0, y0]: [f64; 2], [x1, y1]: [f64; 2], profile: &[(f64, f64)]) {
        let corners = |(inset, z): (f64, f64)| {
            [
                v(x0 + inset, y0 + inset, z),
                v(x1 - inset, y0 + inset, z),
                v(x1 - inset, y1 - inset, z),
                v(x0 + inset, y1 - inset, z),
            ]
        };
        for pair in profile.windows(2) {
            let [outer, inner] = [corners(pair[0]), corners(pair[1])];
            for i in 0..4 {
                let next = (i + 1) % 4;
                self.quad(outer[i], outer[next], inner[next], inner[i]);
            }
        }
    }

    /// Revolves a profile of (radius, y) about the y axis: from its lower end outward and up to its upper end.
    pub(crate) fn lathe(&mut self, profile: &[(f64, f64)], sides: usize) {
        for pair in profile.windows(2) {
            let [(r0, y0), (r1, y1)] = [pair[0], pair[1]];
            let slope = v(y1 - y0, r0 - r1, 0.0).unit();
            let at = |column: usize, radius: f64, y: f64| {
                let (sine, cosine) = (column as f64 / sides as f64 * TAU).sin_cos();
                let normal = v(sine * slope.x, slope.y, cosine * slope.x);
                (v(sine * radius, y, cosine * radius), normal)
            };
            if r0 > 1e-9 && r1 > 1e-9 {
                self.grid([sides, 1], |column, row| {
                    if row == 0 {
                        at(column, r0, y0)
                    } else {
                        at(column, r1, y1)
                    }
                });
                continue;
            }
            for column in 0..sides {
                let triangle = if r0 > 1e-9 {
                    [at(column, r0, y0), at(column + 1, r0, y0), at(column, r1, y1)]
                } else {
                    [at(column, r0, y0), at(column + 1, r1, y1), at(column, r1, y1)]
                };
                self.add(&triangle, &[[0, 1, 2]]);
            }
        }
    }

    /// Adds a smooth tube along points, without caps.
    pub(crate) fn tube(&mut self, path: &[(Vector, f64)], sides: usize) {
        let along = |i: usize| {
            let [before, after] = [i.saturating_sub(1), (i + 1).min(path.len() - 1)];
            (path[after].0 - path[before].0).unit()
        };
        let first = along(0);
        let aside = if first.y.abs() < 0.9 { Vector::Y } else { Vector::X };
        let mut aside = (aside - first * aside.dot(first)).unit();
        let mut rings = Vec::with_capacity(path.len());
        for (i, &(center, radius)) in path.iter().enumerate() {
            let tangent = along(i);
            // Carried from ring to ring, so that the tube does not twist.
            aside = (aside - tangent * aside.dot(tangent)).unit();
            rings.push((center, radius, aside, tangent.cross(aside)));
        }
        self.grid([sides, path.len() - 1], |column, row| {
            let (center, radius, first, second) = rings[row];
            let (sine, cosine) = (column as f64 / sides as f64 * TAU).sin_cos();
            let normal = first * cosine + second * sine;
            (center + normal * radius, normal)
        });
    }

    /// Adds an ellipsoid.
    pub(crate) fn ellipsoid(&mut self, center: Vector, radii: Vector, sides: usize) {
        let rows = (sides / 2).max(2);
        let at = |column: usize, row: usize| {
            let (sine, cosine) = (column as f64 / sides as f64 * TAU).sin_cos();
            // The poles are small holes rather than triangles without area.
            let share = 0.04 + 0.92 * row as f64 / rows as f64;
            let (high, wide) = ((share - 0.5) * TAU / 2.0).sin_cos();
            let on = v(wide * sine, high, wide * cosine);
            let place = v(on.x * radii.x, on.y * radii.y, on.z * radii.z);
            let normal = v(on.x / radii.x, on.y / radii.y, on.z / radii.z);
            (center + place, normal.unit())
        };
        self.grid([sides, rows], at);
    }
}

/// Returns the points of an arc in a profile; angles in quarter turns from the first axis to the second.
pub(crate) fn arc(center: (f64, f64), radius: f64, quarters: [f64; 2], segments: usize) -> Vec<(f64, f64)> {
    let point = |i: usize| {
        let share = i as f64 / segments as f64;
        let angle = (quarters[0] + (quarters[1] - quarters[0]) * share) * TAU / 4.0;
        (center.0 + radius * angle.cos(), center.1 + radius * angle.sin())
    };
    (0..=segments).map(point).collect()
}
