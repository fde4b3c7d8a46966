//! Computes the outline of a flat mesh, if it is a single convex polygon.
//!
//! Works for any triangulation: the mesh is convex if its triangles cover their convex hull, by area.
//! Source of the hull: Andrew, Another Efficient Algorithm for Convex Hulls in Two Dimensions, 1979.

use crate::AuthoringError;
use enfilade::geom::PolygonError;
use enfilade::{ConvexPolygon, Mesh, Transform};
use glam::{DVec2, DVec3};
use std::sync::Arc;

/// Maximum distance of a corner from the plane, relative to the size of the outline: a millimetre on a door. Such
/// corners are projected into the plane.
const FLATNESS: f64 = 1e-3;
/// Maximum fraction of the hull's area that faces may leave open, or cover twice.
const COVERAGE: f64 = 2e-3;

/// Maximum number of triangles of an opening; more, in a mesh shared by many nodes, would take unbounded memory and
/// time.
const MAX_TRIANGLES: u64 = 50_000;

/// Returns the convex outline of transformed meshes; its front is that of the largest triangle.
pub(super) fn outline(
    faces: &[(Arc<Mesh>, Transform)],
    spoken: &str,
) -> Result<ConvexPolygon, AuthoringError> {
    let count = faces.iter().map(|(mesh, _)| mesh.triangle_count()).sum();
    if count > MAX_TRIANGLES {
        return Err(AuthoringError::TooFine {
            node: spoken.to_owned(),
            triangles: count,
        });
    }
    let all: Vec<[DVec3; 3]> = faces
        .iter()
        .flat_map(|(mesh, world)| triangles(mesh, world))
        .collect();
    of_triangles(&all, spoken)
}

/// Returns the transformed triangles of a mesh, which has no larger faces.
fn triangles(mesh: &Mesh, world: &Transform) -> Vec<[DVec3; 3]> {
    let [x, y, z, origin] = world.columns().map(|column| DVec3::from(column.map(f64::from)));
    let corner = |&index: &u32| {
        let [a, b, c] = mesh.positions()[index as usize].map(f64::from);
        origin + x * a + y * b + z * c
    };
    (0..mesh.face_count())
        .filter_map(|face| match mesh.face(face) {
            [a, b, c] => Some([a, b, c].map(corner)),
            _ => None,
        })
        .collect()
}

fn of_triangles(triangles: &[[DVec3; 3]], spoken: &str) -> Result<ConvexPolygon, AuthoringError> {
    let node = || spoken.to_owned();
    if triangles.is_empty() {
        return Err(AuthoringError::NoMesh {
            node: node(),
            found: "its mesh has no triangles".to_owned(),
        });
    }
    let origin = triangles[0][0];
    let twice = |[a, b, c]: &[DVec3; 3]| (*b - *a).cross(*c - *a);
    let corners = || triangles.iter().flatten().copied();
    let size = corners()
        .map(|corner| (corner - origin).length())
        .fold(0.0, f64::max);
    let largest = triangles.iter().map(twice).fold(DVec3::ZERO, |most, next| {
        if next.length() > most.length() { next } else { most }
    });
    let sum: DVec3 = triangles
        .iter()
        .map(twice)
        .map(|vector| {
            if vector.dot(largest) < 0.0 {
                -vector
            } else {
                vector
            }
        })
        .sum();
    let Some(normal) = sum.try_normalize().filter(|_| sum.length() > 1e-9 * size * size) else {
        return Err(AuthoringError::NoArea { node: node() });
    };
    let middle = corners().sum::<DVec3>() / (3 * triangles.len()) as f64;
    let off = corners()
        .map(|corner| normal.dot(corner - middle).abs())
        .fold(0.0, f64::max);
    if off > FLATNESS * size {
        return Err(AuthoringError::NotFlat { node: node(), off });
    }
    let x = normal.any_orthonormal_vector();
    let y = normal.cross(x);
    let flat = |corner: DVec3| DVec2::new(x.dot(corner - middle), y.dot(corner - middle));
    let hull = hull(corners().map(flat).collect(), 1e-6 * size);
    let area = 0.5
        * (1..hull.len())
            .map(|i| hull[i - 1].perp_dot(hull[i]))
            .sum::<f64>()
        + 0.5
            * hull
                .last()
                .zip(hull.first())
                .map_or(0.0, |(last, first)| last.perp_dot(*first));
    let covered = covered(triangles);
    if hull.len() < 3 || (covered - area).abs() > COVERAGE * area {
        let percent = 100.0 * covered / area;
        return Err(AuthoringError::NotConvex {
            node: node(),
            percent,
        });
    }
    let corners: Vec<[f32; 3]> = hull
        .iter()
        .map(|corner| (middle + x * corner.x + y * corner.y).as_vec3().into())
        .collect();
    ConvexPolygon::new(&corners).map_err(|why| match why {
        PolygonError::TooFar(_) => AuthoringError::TooFar { node: node() },
        // Far from the origin, rounding to 32 bits may make it non-planar again.
        _ => AuthoringError::NotFlat { node: node(), off },
    })
}

/// Returns the area of all triangles; duplicates, such as the two sides of a double-sided sheet, count once.
fn covered(triangles: &[[DVec3; 3]]) -> f64 {
    let bits = |corner: &DVec3| corner.to_array().map(|value| (value + 0.0).to_bits());
    let mut keyed: Vec<([[u64; 3]; 3], f64)> = triangles
        .iter()
        .map(|triangle| {
            let [a, b, c] = triangle;
            let mut key = [bits(a), bits(b), bits(c)];
            key.sort_unstable();
            (key, 0.5 * (*b - *a).cross(*c - *a).length())
        })
        .collect();
    keyed.sort_unstable_by_key(|(key, _)| *key);
    keyed.dedup_by_key(|(key, _)| *key);
    keyed.iter().map(|(_, area)| area).sum()
}

/// Returns the convex hull, counter-clockwise, without collinear corners.
fn hull(mut points: Vec<DVec2>, tolerance: f64) -> Vec<DVec2> {
    points.sort_unstable_by(|a, b| a.x.total_cmp(&b.x).then(a.y.total_cmp(&b.y)));
    let mut hull: Vec<DVec2> = Vec::new();
    for pass in 0..2 {
        let kept = hull.len();
        for &point in &points {
            while let [.., before, last] = hull[kept..] {
                let along = last - before;
                if along.perp_dot(point - before) > tolerance * (point - before).length() {
                    break;
                }
                hull.pop();
            }
            if hull
                .last()
                .is_none_or(|last| pass == 1 && hull.len() == kept || (point - *last).length() > tolerance)
            {
                hull.push(point);
            }
        }
        // The last point of each half is the first point of the other.
        hull.pop();
        points.reverse();
    }
    hull
}

#[cfg(test)]
mod tests {
    use super::*;

    fn fan(corners: &[[f64; 3]]) -> Vec<[DVec3; 3]> {
        let corner = |i: usize| DVec3::from(corners[i]);
        (2..corners.len())
            .map(|last| [corner(0), corner(last - 1), corner(last)])
            .collect()
    }

    #[test]
    fn any_cut_of_a_convex_polygon_gives_its_corners() {
        let square = [[0.0, 0.0, 5.0], [2.0, 0.0, 5.0], [2.0, 1.0, 5.0], [0.0, 1.0, 5.0]];
        let found = of_triangles(&fan(&square), "a").expect("a rectangle");
        assert_eq!(found.corners().len(), 4);
        assert_eq!(found.normal(), [0.0, 0.0, 1.0]);
        // A collinear corner, both sides of the sheet, and a grid.
        let more = [
            [0.0, 0.0, 5.0],
            [1.0, 0.0, 5.0],
            [2.0, 0.0, 5.0],
            [2.0, 1.0, 5.0],
            [0.0, 1.0, 5.0],
        ];
        let mut both = fan(&more);
        both.extend(fan(&more).into_iter().map(|[a, b, c]| [a, c, b]));
        assert_eq!(of_triangles(&both, "a").expect("a rectangle").corners().len(), 4);
        let step = |i: usize| i as f64 * 0.25;
        let grid: Vec<[DVec3; 3]> = (0..16)
            .flat_map(|cell| {
                let (x, y) = (cell % 4, cell / 4);
                fan(&[[0, 0], [1, 0], [1, 1], [0, 1]].map(|[a, b]| [step(x + a), step(y + b), 0.0]))
            })
            .collect();
        assert_eq!(grid.len(), 32);
        assert_eq!(of_triangles(&grid, "a").expect("a square").corners().len(), 4);
    }

    #[test]
    fn what_is_bent_notched_too_far_or_nothing_is_refused() {
        let bent = [[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [1.0, 1.0, 0.5], [0.0, 1.0, 0.0]];
        assert!(matches!(
            of_triangles(&fan(&bent), "a"),
            Err(AuthoringError::NotFlat { .. })
        ));
        let notched = [[0.0, 0.0, 0.0], [2.0, 0.0, 0.0], [0.5, 0.5, 0.0], [0.0, 2.0, 0.0]];
        assert!(matches!(
            of_triangles(&fan(&notched), "a"),
            Err(AuthoringError::NotConvex { .. })
        ));
        let line = [[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [2.0, 0.0, 0.0]];
        assert!(matches!(
            of_triangles(&fan(&line), "a"),
            Err(AuthoringError::NoArea { .. })
        ));
        assert!(matches!(
            of_triangles(&fan(&[[1.0; 3]; 3]), "a"),
            Err(AuthoringError::NoArea { .. })
        ));
        let far = [[0.0; 3], [2e12, 0.0, 0.0], [0.0, 2e12, 0.0]];
        assert!(matches!(
            of_triangles(&fan(&far), "a"),
            Err(AuthoringError::TooFar { .. })
        ));
        assert!(matches!(
            of_triangles(&[], "a"),
            Err(AuthoringError::NoMesh { .. })
        ));
    }
}
