//! Convex polygons as lists of corners, and what planes leave of them.

use glam::DVec3;

/// The side of a plane where `normal · x ≥ offset`.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Plane {
    /// Of length one.
    pub(crate) normal: DVec3,
    pub(crate) offset: f64,
    /// How far rounding can have shifted it, anywhere in the world, in units.
    pub(crate) slack: f64,
}

impl Plane {
    pub(crate) fn above(&self, point: DVec3) -> f64 {
        self.normal.dot(point) - self.offset
    }

    pub(crate) fn flipped(&self) -> Plane {
        Plane {
            normal: -self.normal,
            offset: -self.offset,
            slack: self.slack,
        }
    }
}

/// Positive above the plane through three points that turn counter-clockwise seen from there; only the sign counts, and
/// it is right.
///
/// Source: Shewchuk. Adaptive Precision Floating-Point Arithmetic and Fast Robust Geometric Predicates. 1997.
pub(crate) fn above_exactly(through: &[DVec3; 3], point: DVec3) -> f64 {
    // Zero is what exact arithmetic takes longest to find; in maps most of them are a corner of the plane itself, or lie
    // in a plane across an axis.
    let in_plane = |axis: usize| through.iter().all(|corner| corner[axis] == point[axis]);
    if through.contains(&point) || (0..3).any(in_plane) {
        return 0.0;
    }
    let coord = |at: DVec3| robust::Coord3D {
        x: at.x,
        y: at.y,
        z: at.z,
    };
    let [first, second, third] = through.map(coord);
    -robust::orient3d(first, second, third, coord(point))
}

/// What a plane left of a winding.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Left {
    All,
    Part,
    Nothing,
}

/// Twice the area, along the counter-clockwise normal.
pub(crate) fn newell(corners: &[DVec3]) -> DVec3 {
    let first = corners[0];
    let fans = corners[1..].windows(2);
    fans.map(|pair| (pair[0] - first).cross(pair[1] - first)).sum()
}

pub(crate) fn centre(corners: &[DVec3]) -> DVec3 {
    corners.iter().sum::<DVec3>() / corners.len() as f64
}

/// How far the farthest corner is off the plane through the middle.
pub(crate) fn thickness(corners: &[DVec3], normal: DVec3) -> f64 {
    let middle = centre(corners);
    let offs = corners.iter().map(|&corner| normal.dot(corner - middle).abs());
    offs.fold(0.0, f64::max)
}

/// Cuts off what is below the plane; `kept` is scratch.
///
/// What is left is never smaller than what lies above the plane: the cut is made as far below it as rounding can shift it.
pub(crate) fn clip(winding: &mut Vec<DVec3>, plane: &Plane, kept: &mut Vec<DVec3>) -> Left {
    let heights = winding.iter().map(|&corner| plane.above(corner));
    let [mut least, mut most] = [f64::INFINITY, f64::NEG_INFINITY];
    for above in heights {
        least = least.min(above);
        most = most.max(above);
    }
    if most < -plane.slack {
        return Left::Nothing;
    }
    if least >= -plane.slack {
        return Left::All;
    }
    cut(winding, plane, kept);
    Left::Part
}

/// As [`clip`], of a winding that has corners on both sides.
pub(crate) fn cut(winding: &mut Vec<DVec3>, plane: &Plane, kept: &mut Vec<DVec3>) {
    kept.clear();
    let mut before = winding[winding.len() - 1];
    let mut before_above = plane.above(before) + plane.slack;
    for &corner in winding.iter() {
        let above = plane.above(corner) + plane.slack;
        if (above >= 0.0) != (before_above >= 0.0) {
            let part = before_above / (before_above - above);
            kept.push(before + (corner - before) * part);
        }
        if above >= 0.0 {
            kept.push(corner);
        }
        before = corner;
        before_above = above;
    }
    std::mem::swap(winding, kept);
}
