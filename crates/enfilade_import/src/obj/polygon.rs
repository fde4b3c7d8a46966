//! Triangulates polygons in space, by projecting them to a plane.
//!
//! A flat polygon is projected along the axis closest to its normal, so that nothing is rounded and collinear corners
//! stay collinear. A non-planar one is projected along its mean normal, which distorts it least. If the projection
//! self-intersects, the other projection is tried too. Triangles keep the winding of the polygon.

use super::ring::Ring;
use glam::{DVec2, DVec3};

/// Triangulates polygons; reuses its memory for the next one.
#[derive(Debug, Default)]
pub(crate) struct Cutter {
    ring: Ring,
    /// Indices of the corners without consecutive duplicates.
    apart: Vec<u32>,
    flat: Vec<[f64; 2]>,
}

impl Cutter {
    /// Triangulates a polygon with finite corners; appends triangles as indices into `corners`, none if the polygon has
    /// no area. Returns `true` if the polygon is simple; a self-intersecting one is triangulated approximately.
    pub(crate) fn cut(&mut self, corners: &[[f32; 3]], triangles: &mut Vec<[u32; 3]>) -> bool {
        self.apart.clear();
        for (place, corner) in (0..).zip(corners) {
            let before = self.apart.last();
            if before.is_none_or(|&before| corners[before as usize] != *corner) {
                self.apart.push(place);
            }
        }
        while let [first, .., last] = self.apart[..]
            && corners[first as usize] == corners[last as usize]
        {
            self.apart.pop();
        }
        if self.apart.len() < 3 {
            return true;
        }
        let start = triangles.len();
        let normal = self.normal(corners);
        let mut ways = [Axes::nearest(normal, &self.apart, corners), Axes::along(normal)];
        if self.is_bent(normal, corners) {
            ways.reverse();
        }
        let rough = self.cut_along(&ways[0], corners, triangles);
        if rough == 0 || normal == DVec3::ZERO {
            return rough == 0;
        }
        let second = triangles.len();
        let rougher = self.cut_along(&ways[1], corners, triangles);
        if rougher < rough {
            triangles.drain(start..second);
        } else {
            triangles.truncate(second);
        }
        rougher.min(rough) == 0
    }

    /// Returns `true` if a corner is farther off the plane than rounding explains.
    fn is_bent(&self, normal: DVec3, corners: &[[f32; 3]]) -> bool {
        const ROUNDED: f64 = 1e-4;
        let origin = place(corners, self.apart[0]);
        let normal = unit(normal);
        let arms = self.apart.iter().map(|&corner| place(corners, corner) - origin);
        let (off, size) = arms.fold((0.0_f64, 0.0_f64), |(off, size), arm| {
            (off.max(arm.dot(normal).abs()), size.max(arm.length()))
        });
        off > ROUNDED * size
    }

    /// Returns the mean normal; its length is twice the area.
    fn normal(&self, corners: &[[f32; 3]]) -> DVec3 {
        let origin = place(corners, self.apart[0]);
        let arm = |&corner: &u32| place(corners, corner) - origin;
        self.apart[1..]
            .windows(2)
            .map(|pair| arm(&pair[0]).cross(arm(&pair[1])))
            .sum()
    }

    /// Triangulates the projection of the polygon; returns the number of triangles that are only approximate.
    fn cut_along(&mut self, axes: &Axes, corners: &[[f32; 3]], triangles: &mut Vec<[u32; 3]>) -> usize {
        let flat = |&corner: &u32| axes.flat(place(corners, corner)).to_array();
        self.flat.clear();
        self.flat.extend(self.apart.iter().map(flat));
        let apart = &self.apart;
        self.ring.cut(&self.flat, |triangle| {
            triangles.push(triangle.map(|place| apart[place as usize]));
        })
    }
}

fn place(corners: &[[f32; 3]], corner: u32) -> DVec3 {
    DVec3::from(corners[corner as usize].map(f64::from))
}

/// Normalizes a vector, also if its squared length overflows or underflows; zero stays zero.
fn unit(direction: DVec3) -> DVec3 {
    let scale = direction.abs().max_element();
    if scale > 0.0 {
        (direction / scale).normalize()
    } else {
        DVec3::ZERO
    }
}

/// Two projection axes, in which the polygon is counter-clockwise.
struct Axes([DVec3; 2]);

impl Axes {
    /// Returns the two coordinate axes that the polygon is closest to parallel to.
    fn nearest(normal: DVec3, apart: &[u32], corners: &[[f32; 3]]) -> Axes {
        let mut facing = normal;
        if facing == DVec3::ZERO {
            // Its signed area is zero, so it is projected along the axis with the largest extent of the other two.
            let places = apart.iter().map(|&corner| place(corners, corner));
            let around = |(min, max): (DVec3, DVec3), at: DVec3| (min.min(at), max.max(at));
            let (min, max) = places.fold((DVec3::INFINITY, DVec3::NEG_INFINITY), around);
            let size = max - min;
            facing = DVec3::new(size.y * size.z, size.z * size.x, size.x * size.y);
        }
        let axis = facing.abs().max_position();
        let [u, v] = [(axis + 1) % 3, (axis + 2) % 3].map(|axis| DVec3::AXES[axis]);
        Axes(if facing[axis] < 0.0 { [v, u] } else { [u, v] })
    }

    /// Returns two axes perpendicular to the normal.
    fn along(normal: DVec3) -> Axes {
        let (u, v) = (normal / normal.abs().max_element())
            .normalize()
            .any_orthonormal_pair();
        Axes([u, v])
    }

    fn flat(&self, place: DVec3) -> DVec2 {
        DVec2::new(self.0[0].dot(place), self.0[1].dot(place))
    }
}
