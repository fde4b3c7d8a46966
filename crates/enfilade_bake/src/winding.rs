//! Convex windings (corner lists): plane, area, centre, and clipping against planes.

use glam::DVec3;

/// A half-space `normal · x ≥ offset`.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Plane {
    /// Unit length.
    pub(crate) normal: DVec3,
    pub(crate) offset: f64,
    /// Bound of the rounding error of a height above the plane, anywhere in the world, in units.
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

/// Exact orientation test: positive if `point` is above the plane through three points, which are counter-clockwise as
/// seen from above. Only the sign is meaningful.
///
/// Source: Shewchuk. Adaptive Precision Floating-Point Arithmetic and Fast Robust Geometric Predicates. 1997.
pub(crate) fn above_exactly(through: &[DVec3; 3], point: DVec3) -> f64 {
    // Zero is the slowest result of the adaptive test. In maps most zeros are a corner of the plane itself, or four
    // points in one axis-aligned plane.
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

/// Result of clipping a winding against planes.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum ClipResult {
    All,
    Part,
    Nothing,
}

/// Returns the vector area times two (Newell's method); it points along the counter-clockwise normal.
pub(crate) fn newell(corners: &[DVec3]) -> DVec3 {
    let first = corners[0];
    let fans = corners[1..].windows(2);
    fans.map(|pair| (pair[0] - first).cross(pair[1] - first)).sum()
}

pub(crate) fn centre(corners: &[DVec3]) -> DVec3 {
    corners.iter().sum::<DVec3>() / corners.len() as f64
}

/// Returns the largest distance of a corner from the plane through the centre.
pub(crate) fn thickness(corners: &[DVec3], normal: DVec3) -> f64 {
    let middle = centre(corners);
    let offs = corners.iter().map(|&corner| normal.dot(corner - middle).abs());
    offs.fold(0.0, f64::max)
}

/// Clips a winding to the upper side of a plane; `kept` is scratch memory.
///
/// Conservative: the winding is cut `slack` below the plane, so rounding never removes anything above it.
pub(crate) fn clip(winding: &mut Vec<DVec3>, plane: &Plane, kept: &mut Vec<DVec3>) -> ClipResult {
    let heights = winding.iter().map(|&corner| plane.above(corner));
    let [mut lowest, mut highest] = [f64::INFINITY, f64::NEG_INFINITY];
    for above in heights {
        lowest = lowest.min(above);
        highest = highest.max(above);
    }
    if highest < -plane.slack {
        return ClipResult::Nothing;
    }
    if lowest >= -plane.slack {
        return ClipResult::All;
    }
    cut(winding, plane, kept);
    ClipResult::Part
}

/// As [`clip`], for a winding with corners on both sides of the cut.
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
