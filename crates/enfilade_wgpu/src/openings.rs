//! Openings on the screen: projected and clipped in 64 bits, as triangles in clip space.
//!
//! The GPU must not clip an opening at the near plane: with the eye in a doorway, the room behind it would be lost.

use enfilade::Aperture;
use glam::{DMat4, DVec3, DVec4};

/// Distance of the clip planes left, right, above and below, in half screens: beyond the edges of the screen.
const BESIDE: f64 = 1.125;

/// Adds the triangles of an opening that are on the screen to `triangles`: x, y and reversed depth with w 1. Parts nearer
/// than the near plane get the depth of the near plane. `entry` is the entry plane of the passage, if it has one.
pub(crate) fn add(
    clip_from_sector: &DMat4,
    outline: &[[f32; 3]],
    entry: Option<[f64; 4]>,
    near: Option<f64>,
    triangles: &mut Vec<[f32; 4]>,
) {
    let corners = outline
        .iter()
        .map(|corner| DVec3::from(corner.map(f64::from)).extend(1.0));
    let mut polygon: Vec<DVec4> = corners.collect();
    if let Some(plane) = entry {
        // The opening that the passage leads through is in this plane, and so is its back.
        let first = polygon[0];
        let size = polygon.iter().map(|at| at.distance(first)).fold(0.0, f64::max);
        let plane = DVec4::from(plane) - DVec4::new(0.0, 0.0, 0.0, 1e-5 * size);
        polygon = clipped(&polygon, |at| plane.dot(at));
    }
    for corner in &mut polygon {
        *corner = *clip_from_sector * *corner;
    }
    let planes = [
        DVec4::new(0.0, 0.0, 0.0, 1.0),
        DVec4::new(1.0, 0.0, 0.0, BESIDE),
        DVec4::new(-1.0, 0.0, 0.0, BESIDE),
        DVec4::new(0.0, 1.0, 0.0, BESIDE),
        DVec4::new(0.0, -1.0, 0.0, BESIDE),
    ];
    for plane in planes {
        polygon = clipped(&polygon, |at| plane.dot(at));
    }
    let Some(near) = near else {
        // A parallel view: depth is linear, and openings before the near plane lead nowhere.
        return add_fan(&clipped(&polygon, |at| at.w - at.z), |at| at.z / at.w, triangles);
    };
    add_fan(&clipped(&polygon, |at| at.w - near), |at| at.z / at.w, triangles);
    add_fan(&clipped(&polygon, |at| near - at.w), |_| 1.0, triangles);
}

/// Adds the triangles of an aperture at one depth: of its samples if they are known, else of its outline.
pub(crate) fn add_aperture(aperture: &Aperture, size: [u32; 2], depth: f64, triangles: &mut Vec<[f32; 4]>) {
    let [width, height] = size.map(f64::from);
    let corner = |[x, y]: [f64; 2]| DVec4::new(2.0 * x / width - 1.0, 1.0 - 2.0 * y / height, depth, 1.0);
    let mut rectangle = |[x0, y0, x1, y1]: [u16; 4]| {
        let [x0, y0, x1, y1] = [x0, y0, x1, y1].map(f64::from);
        let corners = [[x0, y0], [x0, y1], [x1, y1], [x1, y0]].map(corner);
        add_fan(&corners, |at| at.z, triangles);
    };
    if let Some(rows) = aperture.rows() {
        for y in rows.range() {
            for &[x0, x1] in rows.row(y) {
                rectangle([x0, y, x1, y + 1]);
            }
        }
        return;
    }
    let outline: Vec<DVec4> = aperture.outline().iter().copied().map(corner).collect();
    if outline.len() < 3 {
        let rect = aperture.rect();
        return rectangle([rect.x0, rect.y0, rect.x1, rect.y1]);
    }
    add_fan(&outline, |at| at.z, triangles);
}

fn add_fan(polygon: &[DVec4], depth: impl Fn(DVec4) -> f64, triangles: &mut Vec<[f32; 4]>) {
    let point = |at: DVec4| [at.x / at.w, at.y / at.w, depth(at), 1.0].map(|value| value as f32);
    let is_sound = |at: &[f32; 4]| at.iter().all(|value| value.is_finite());
    for last in 2..polygon.len() {
        let triangle = [polygon[0], polygon[last - 1], polygon[last]].map(point);
        if triangle.iter().all(is_sound) {
            triangles.extend(triangle);
        }
    }
}

/// Returns the part of a convex polygon where a linear function is not negative.
fn clipped(polygon: &[DVec4], inside: impl Fn(DVec4) -> f64) -> Vec<DVec4> {
    let mut kept = Vec::with_capacity(polygon.len() + 1);
    for (number, &at) in polygon.iter().enumerate() {
        let next = polygon[(number + 1) % polygon.len()];
        let [here, there] = [inside(at), inside(next)];
        if here >= 0.0 {
            kept.push(at);
        }
        if (here >= 0.0) != (there >= 0.0) {
            // In one order, whichever side is walked, so that parts on both sides share the point.
            let point = match here >= 0.0 {
                true => at.lerp(next, here / (here - there)),
                false => next.lerp(at, there / (there - here)),
            };
            kept.push(point);
        }
    }
    kept
}

#[cfg(test)]
mod tests {
    use super::*;

    const NEAR: f64 = 0.1;

    /// Returns the area on the screen, in half screens squared, and the greatest depth, of a square opening 2 wide at
    /// distance `away` ahead.
    fn seen(away: f32) -> (f64, f32) {
        let clip = DMat4::from_cols(
            DVec4::X,
            DVec4::Y,
            DVec4::new(0.0, 0.0, 0.0, -1.0),
            DVec4::new(0.0, 0.0, NEAR, 0.0),
        );
        let outline = [[-1.0, -1.0], [1.0, -1.0], [1.0, 1.0], [-1.0, 1.0]].map(|[x, y]| [x, y, -away]);
        let mut triangles = Vec::new();
        add(&clip, &outline, None, Some(NEAR), &mut triangles);
        let area = triangles
            .chunks_exact(3)
            .map(|corners| {
                let [a, b, c] =
                    [0, 1, 2].map(|i| DVec3::new(corners[i][0].into(), corners[i][1].into(), 0.0));
                0.5 * (b - a).cross(c - a).z
            })
            .sum();
        let depth = triangles.iter().fold(0.0, |most: f32, at| most.max(at[2]));
        (area, depth)
    }

    #[test]
    fn an_opening_nearer_than_the_near_plane_stays_open() {
        assert_eq!(seen(2.0), (1.0, 0.05));
        let whole = (2.0 * BESIDE).powi(2);
        let (area, depth) = seen(0.05);
        assert!((area - whole).abs() < 1e-6);
        assert_eq!(depth, 1.0);
        assert_eq!(seen(-1.0), (0.0, 0.0), "behind the eye");
    }
}
