//! Splits a flat outline with holes into few convex faces.
//!
//! Bridges connect the holes to the outline, ears are clipped one by one, and faces are merged across every cut that is
//! not needed. No vertex is added, so faces that share an edge with another surface share its ends exactly.
//! Source: Meisters. Polygons have ears. 1975; Hertel, Mehlhorn. Fast triangulation of simple polygons. 1983.
//! Cost: O(n³) in the worst case; walls have tens of corners.

use glam::Vec3;
use std::collections::HashMap;

/// Returns the faces of a flat surface. The outline is counter-clockwise as seen from the front. Holes have either
/// winding and touch neither the outline nor each other. Corners on a straight edge stay corners of the adjacent faces.
pub(crate) fn fill(outline: &[Vec3], holes: &[Vec<Vec3>]) -> Vec<Vec<Vec3>> {
    let mut surface = Surface {
        points: outline.to_vec(),
        flat: Vec::new(),
    };
    let mut loops = vec![(0..outline.len()).collect::<Vec<usize>>()];
    for hole in holes {
        loops.push((surface.points.len()..surface.points.len() + hole.len()).collect());
        surface.points.extend(hole);
    }
    surface.flatten(outline);
    for hole in &mut loops[1..] {
        if surface.area(hole) > 0.0 {
            hole.reverse();
        }
    }
    let path = surface.bridged(loops);
    let triangles = surface.ears(path);
    let faces = surface.joined(triangles);
    faces
        .into_iter()
        .map(|face| face.into_iter().map(|i| surface.points[i]).collect())
        .collect()
}

struct Surface {
    points: Vec<Vec3>,
    /// Points projected to the plane, as seen from the front, in f64, where orientation tests of f32 points are nearly
    /// exact.
    flat: Vec<[f64; 2]>,
}

impl Surface {
    /// Projects along the dominant axis; the two other coordinates stay exact.
    fn flatten(&mut self, outline: &[Vec3]) {
        let normal: Vec3 = (1..outline.len() - 1)
            .map(|i| (outline[i] - outline[0]).cross(outline[i + 1] - outline[0]))
            .sum();
        let facing = normal.abs().max_position();
        let [mut across, mut up] = [(facing + 1) % 3, (facing + 2) % 3];
        if normal[facing] < 0.0 {
            std::mem::swap(&mut across, &mut up);
        }
        self.flat = self
            .points
            .iter()
            .map(|point| [across, up].map(|axis| f64::from(point[axis])))
            .collect();
    }

    /// Returns twice the signed area of a triangle; positive if counter-clockwise.
    fn turn(&self, [a, b, c]: [usize; 3]) -> f64 {
        let [a, b, c] = [a, b, c].map(|i| self.flat[i]);
        (b[0] - a[0]) * (c[1] - a[1]) - (b[1] - a[1]) * (c[0] - a[0])
    }

    fn area(&self, path: &[usize]) -> f64 {
        (1..path.len() - 1)
            .map(|i| self.turn([path[0], path[i], path[i + 1]]))
            .sum()
    }

    /// Returns one path around the outline and, over bridges, around all holes.
    fn bridged(&self, mut loops: Vec<Vec<usize>>) -> Vec<usize> {
        let mut path = loops.remove(0);
        while !loops.is_empty() {
            let (hole, inner, outer) = self.shortest_bridge(&path, &loops);
            let ring = loops.remove(hole);
            let there_and_back = ring.iter().cycle().skip(inner).take(ring.len() + 1).copied();
            let back = path[outer];
            path.splice(outer + 1..outer + 1, there_and_back.chain([back]));
        }
        path
    }

    /// Returns the shortest bridge that crosses no edge: a hole, its corner, and the path's corner.
    fn shortest_bridge(&self, path: &[usize], holes: &[Vec<usize>]) -> (usize, usize, usize) {
        let mut bridges = Vec::new();
        for (hole, ring) in holes.iter().enumerate() {
            for (inner, &a) in ring.iter().enumerate() {
                for (outer, &b) in path.iter().enumerate() {
                    bridges.push((
                        self.points[a].distance_squared(self.points[b]),
                        hole,
                        inner,
                        outer,
                    ));
                }
            }
        }
        bridges.sort_by(|a, b| a.0.total_cmp(&b.0));
        let free = bridges.iter().find(|&&(_, hole, inner, outer)| {
            let bridge = [holes[hole][inner], path[outer]];
            self.opens(path, outer, bridge[0])
                && std::iter::once(path)
                    .chain(holes.iter().map(Vec::as_slice))
                    .all(|ring| {
                        (0..ring.len()).all(|i| !self.crosses(bridge, [ring[i], ring[(i + 1) % ring.len()]]))
                    })
        });
        let &(_, hole, inner, outer) = free.expect("every hole has a free bridge");
        (hole, inner, outer)
    }

    /// Returns `true` if `point` is inside the interior angle at a corner of the path. A corner that the path visits
    /// twice has two such angles.
    fn opens(&self, path: &[usize], corner: usize, point: usize) -> bool {
        let count = path.len();
        let [before, at, after] = [
            path[(corner + count - 1) % count],
            path[corner],
            path[(corner + 1) % count],
        ];
        let [left_of_in, left_of_out] = [
            self.turn([before, at, point]) > 0.0,
            self.turn([at, after, point]) > 0.0,
        ];
        if self.turn([before, at, after]) >= 0.0 {
            left_of_in && left_of_out
        } else {
            left_of_in || left_of_out
        }
    }

    /// Returns `true` if two edges share a point that is not an end of both.
    fn crosses(&self, [a, b]: [usize; 2], [c, d]: [usize; 2]) -> bool {
        let shares = |point: usize| point == a || point == b;
        let between = |point: usize| {
            let [p, q, r] = [a, b, point].map(|i| self.flat[i]);
            let along = (r[0] - p[0]) * (q[0] - p[0]) + (r[1] - p[1]) * (q[1] - p[1]);
            let whole = (q[0] - p[0]).powi(2) + (q[1] - p[1]).powi(2);
            self.turn([a, b, point]) == 0.0 && along >= 0.0 && along <= whole
        };
        if shares(c) || shares(d) {
            return (!shares(c) && between(c)) || (!shares(d) && between(d));
        }
        let sides = |edge: [usize; 2], p: usize, q: usize| {
            self.turn([edge[0], edge[1], p]).signum() != self.turn([edge[0], edge[1], q]).signum()
        };
        between(c) || between(d) || (sides([a, b], c, d) && sides([c, d], a, b))
    }

    /// Clips ears: corners whose triangle contains no other corner.
    fn ears(&self, mut path: Vec<usize>) -> Vec<[usize; 3]> {
        let mut triangles = Vec::with_capacity(path.len());
        while path.len() > 3 {
            let count = path.len();
            let triangle = |i: usize| [path[(i + count - 1) % count], path[i], path[(i + 1) % count]];
            let ear = (0..count).find(|&i| self.turn(triangle(i)) > 0.0 && self.is_empty(triangle(i), &path));
            let ear = ear.expect("every simple outline has an ear");
            triangles.push(triangle(ear));
            path.remove(ear);
        }
        if self.turn([path[0], path[1], path[2]]) > 0.0 {
            triangles.push([path[0], path[1], path[2]]);
        }
        triangles
    }

    fn is_empty(&self, [a, b, c]: [usize; 3], path: &[usize]) -> bool {
        path.iter()
            .filter(|&&p| p != a && p != b && p != c)
            .all(|&p| self.turn([a, b, p]) < 0.0 || self.turn([b, c, p]) < 0.0 || self.turn([c, a, p]) < 0.0)
    }

    /// Merges faces across each cut whose union stays convex. One pass suffices: a corner that is not convex at a cut's
    /// end does not become convex by other merges.
    fn joined(&self, triangles: Vec<[usize; 3]>) -> Vec<Vec<usize>> {
        let mut faces: Vec<Vec<usize>> = triangles.iter().map(|triangle| triangle.to_vec()).collect();
        let mut face_of = HashMap::new();
        for (face, corners) in triangles.iter().enumerate() {
            for i in 0..3 {
                face_of.insert([corners[i], corners[(i + 1) % 3]], face);
            }
        }
        for corners in &triangles {
            for i in 0..3 {
                let [a, b] = [corners[i], corners[(i + 1) % 3]];
                let (Some(&one), Some(&other)) = (face_of.get(&[a, b]), face_of.get(&[b, a])) else {
                    continue;
                };
                let whole = join(&faces[one], &faces[other], a, b);
                if one == other || !self.is_convex_at(&whole, a) || !self.is_convex_at(&whole, b) {
                    continue;
                }
                face_of.remove(&[a, b]);
                face_of.remove(&[b, a]);
                for i in 0..whole.len() {
                    face_of.insert([whole[i], whole[(i + 1) % whole.len()]], one);
                }
                faces[one] = whole;
                faces[other].clear();
            }
        }
        faces.retain(|face| !face.is_empty());
        faces
    }

    fn is_convex_at(&self, face: &[usize], corner: usize) -> bool {
        let count = face.len();
        face.iter()
            .position(|&p| p == corner)
            .is_some_and(|i| self.turn([face[(i + count - 1) % count], corner, face[(i + 1) % count]]) >= 0.0)
    }
}

/// Returns the outline of two faces that share an edge, `a` to `b` in one and `b` to `a` in the other.
fn join(one: &[usize], other: &[usize], a: usize, b: usize) -> Vec<usize> {
    let from = |face: &[usize], corner: usize| face.iter().position(|&p| p == corner).unwrap_or(0);
    let [start, other_start] = [from(one, b), from(other, a)];
    let mut whole: Vec<usize> = (0..one.len()).map(|i| one[(start + i) % one.len()]).collect();
    whole.extend((1..other.len() - 1).map(|i| other[(other_start + i) % other.len()]));
    whole
}

#[cfg(test)]
mod tests {
    use super::*;
    use enfilade::ConvexPolygon;

    fn points(flat: &[[f32; 2]]) -> Vec<Vec3> {
        flat.iter().map(|&[x, y]| Vec3::new(x, y, 0.0)).collect()
    }

    fn square(x: f32, y: f32, side: f32) -> Vec<Vec3> {
        points(&[[x, y], [x + side, y], [x + side, y + side], [x, y + side]])
    }

    fn area(faces: &[Vec<Vec3>]) -> f32 {
        let of = |face: &Vec<Vec3>| -> f32 {
            (1..face.len() - 1)
                .map(|i| (face[i] - face[0]).cross(face[i + 1] - face[0]).z)
                .sum()
        };
        0.5 * faces.iter().map(of).sum::<f32>()
    }

    fn check(outline: &[Vec3], holes: &[Vec<Vec3>], expected_area: f32, most_faces: usize) {
        let faces = fill(outline, holes);
        assert!(
            (area(&faces) - expected_area).abs() < 1e-4,
            "an area of {}",
            area(&faces)
        );
        assert!(faces.len() <= most_faces, "{} faces: {faces:?}", faces.len());
        for face in &faces {
            let corners: Vec<[f32; 3]> = face.iter().map(|c| c.to_array()).collect();
            assert_eq!(
                ConvexPolygon::new(&corners).expect("convex").normal(),
                [0.0, 0.0, 1.0]
            );
        }
    }

    #[test]
    fn a_convex_outline_stays_whole() {
        check(&square(0.0, 0.0, 2.0), &[], 4.0, 1);
        let with_corners_on_edges = points(&[
            [0.0, 0.0],
            [1.0, 0.0],
            [1.5, 0.0],
            [2.0, 0.0],
            [2.0, 2.0],
            [0.0, 2.0],
        ]);
        check(&with_corners_on_edges, &[], 4.0, 1);
    }

    #[test]
    fn a_wall_has_holes_for_its_windows() {
        let windows: Vec<Vec<Vec3>> = (0..9).map(|i| square(1.0 + 2.0 * i as f32, 1.0, 1.0)).collect();
        check(
            &points(&[[0.0, 0.0], [19.0, 0.0], [19.0, 3.0], [0.0, 3.0]]),
            &windows,
            48.0,
            40,
        );
    }

    #[test]
    fn a_doorway_is_a_bay_in_the_outline() {
        let wall = [
            [0.0, 0.0],
            [2.0, 0.0],
            [2.0, 2.0],
            [3.0, 2.0],
            [3.0, 0.0],
            [5.0, 0.0],
            [5.0, 3.0],
            [0.0, 3.0],
        ];
        check(&points(&wall), &[], 13.0, 3);
    }
}
