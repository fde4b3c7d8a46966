//! Tests whether one mesh is within a distance of another.
//!
//! The distance to a single triangle is a convex function: if the corners of a piece are all close enough to the same
//! triangle, so is the whole piece. If there is no such triangle, the piece is split into four.
//! Source: the idea of Aspert, Santa-Cruz, Ebrahimi, MESH: measuring errors between surfaces, 2002, with a bound
//! instead of samples.
//! Cost: O(faces + edge lengths of both / distance) nearest-triangle queries, on all cores.
//! Conservative: `true` is always correct; `false` is also returned when the test would take too long.

use super::triangles;
use enfilade::geom::Step;
use enfilade::{Aabb, Mesh};
use glam::DVec3;
use rayon::prelude::*;
use std::sync::atomic::{AtomicU64, Ordering};

/// Maximum recursion depth of splitting a face into four.
const DEPTH: u32 = 8;

/// Maximum number of pieces per face of both meshes.
const PIECES: u64 = 30;

/// Returns `true` if every point of `of` is within `distance` of `to`; `false` when unsure.
pub(super) fn within(of: &Mesh, to: &Mesh, distance: f64) -> bool {
    let left = AtomicU64::new(PIECES * u64::from(of.face_count() + to.face_count()));
    let at = |index: u32| DVec3::from(of.positions()[index as usize].map(f64::from));
    (0..of.face_count()).into_par_iter().all(|face| {
        triangles(of.face(face)).all(|corners| piece(corners.map(at), to, distance, DEPTH, &left))
    })
}

/// Tests a triangular piece, recursively; `left` counts the pieces that may still be split.
fn piece(corners: [DVec3; 3], to: &Mesh, distance: f64, depth: u32, left: &AtomicU64) -> bool {
    let [a, b, c] = corners;
    match holding(corners, to, distance) {
        Proximity::One => return true,
        Proximity::None => return false,
        Proximity::Several => {}
    }
    if depth == 0 || left.fetch_sub(1, Ordering::Relaxed) as i64 <= 0 {
        return false;
    }
    let [ab, bc, ca] = [0.5 * (a + b), 0.5 * (b + c), 0.5 * (c + a)];
    [[ab, bc, ca], [a, ab, ca], [ab, b, bc], [ca, bc, c]]
        .into_iter()
        .all(|corners| piece(corners, to, distance, depth - 1, left))
}

/// Part of a piece that is within the distance of the other mesh.
enum Proximity {
    /// The whole piece is within the distance of one triangle.
    One,
    /// Its centroid is; the rest of the piece may be, but only of several triangles together.
    Several,
    /// Its centroid is not within the distance of any triangle.
    None,
}

/// Classifies a piece by the triangles of `to` near its centroid.
fn holding(corners: [DVec3; 3], to: &Mesh, distance: f64) -> Proximity {
    let middle = (corners[0] + corners[1] + corners[2]) / 3.0;
    let square = distance * distance;
    let at = |index: u32| DVec3::from(to.positions()[index as usize].map(f64::from));
    let mut nearest = Proximity::None;
    to.walk(middle.into(), |step| {
        if matches!(nearest, Proximity::One) {
            return false;
        }
        match step {
            Step::Node(bounds) => reaches(bounds, middle, square),
            Step::Thing(cluster) => {
                let cluster = &to.clusters()[cluster as usize];
                if reaches(&cluster.bounds, middle, square) {
                    for face in cluster.faces.clone() {
                        for triangle in triangles(to.face(face)) {
                            let triangle = triangle.map(at);
                            if square_distance(middle, triangle) > square {
                                continue;
                            }
                            let mut all = corners.iter();
                            if all.all(|&corner| square_distance(corner, triangle) <= square) {
                                nearest = Proximity::One;
                                return false;
                            }
                            nearest = Proximity::Several;
                        }
                    }
                }
                false
            }
        }
    });
    nearest
}

/// Returns `true` if the squared distance from the point to the AABB is at most `square`.
fn reaches(bounds: &Aabb, point: DVec3, square: f64) -> bool {
    let [min, max] = [bounds.min, bounds.max].map(|corner| DVec3::from(corner.map(f64::from)));
    point.distance_squared(point.clamp(min, max)) <= square
}

/// Returns the squared distance from a point to a triangle, or to its edges if it has no area.
fn square_distance(point: DVec3, [a, b, c]: [DVec3; 3]) -> f64 {
    let normal = (b - a).cross(c - a);
    let edges = [(a, b), (b, c), (c, a)];
    let area = normal.length_squared();
    let above = |&(from, to): &(DVec3, DVec3)| (to - from).cross(point - from).dot(normal) >= 0.0;
    if area > 0.0 && edges.iter().all(above) {
        return (point - a).dot(normal).powi(2) / area;
    }
    edges
        .into_iter()
        .map(|(from, to)| {
            let along = to - from;
            let length = along.length_squared();
            let t = if length > 0.0 {
                ((point - from).dot(along) / length).clamp(0.0, 1.0)
            } else {
                0.0
            };
            point.distance_squared(from + t * along)
        })
        .fold(f64::INFINITY, f64::min)
}
