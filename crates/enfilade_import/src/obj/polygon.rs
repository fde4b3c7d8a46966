//! Polygons in space: what they are seen as from in front of them is cut into triangles.
//!
//! A flat polygon is looked at along the axis that it faces most, so that nothing is rounded and corners in line stay in
//! line; a bent one along its mean normal, from where it is the least bent. Where it crosses itself then, the other way is
//! tried, too. Triangles turn the way that the polygon does.

use super::ring::Ring;
use glam::{DVec2, DVec3};

/// Cuts polygons. What it holds is used again for the next.
#[derive(Debug, Default)]
pub(crate) struct Cutter {
    ring: Ring,
    /// Corners that are not in the place of the one before, by their places in the polygon.
    apart: Vec<u32>,
    flat: Vec<[f64; 2]>,
}

impl Cutter {
    /// Cuts the polygon with these corners, all of them finite, into triangles, which are handed out as places in
    /// `corners`: none where it has no area. Says whether it is sound: one that crosses itself is cut as well as can be.
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

    /// Is some corner farther off the plane of the others than rounding can have put it?
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

    /// The mean normal, twice as long as the polygon has area.
    fn normal(&self, corners: &[[f32; 3]]) -> DVec3 {
        let origin = place(corners, self.apart[0]);
        let arm = |&corner: &u32| place(corners, corner) - origin;
        self.apart[1..]
            .windows(2)
            .map(|pair| arm(&pair[0]).cross(arm(&pair[1])))
            .sum()
    }

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

/// A direction of length 1, also of what is so long or short that its square is not a number; zero stays zero.
fn unit(direction: DVec3) -> DVec3 {
    let scale = direction.abs().max_element();
    if scale > 0.0 {
        (direction / scale).normalize()
    } else {
        DVec3::ZERO
    }
}

/// Two directions across which a polygon is looked at, so that it turns counter-clockwise.
struct Axes([DVec3; 2]);

impl Axes {
    /// Those of the world that a polygon lies along most.
    fn nearest(normal: DVec3, apart: &[u32], corners: &[[f32; 3]]) -> Axes {
        let mut facing = normal;
        if facing == DVec3::ZERO {
            // It turns as much one way as the other: it is looked at where it is largest.
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
