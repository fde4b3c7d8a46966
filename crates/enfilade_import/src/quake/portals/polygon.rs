//! Convex polygons, and what planes leave of them.
//!
//! Planes along an axis cut to the very number that the file has, so that portals of grid-aligned maps touch where they
//! touch, to the last digit. What rounding cannot decide stays on both sides: nothing that light goes through is cut off.

use crate::quake::bsp::SplitPlane;
use glam::DVec3;

/// The side of a plane where `normal · x ≥ offset`.
#[derive(Clone, Copy, Debug)]
pub(super) struct Side {
    /// Of length one.
    normal: DVec3,
    offset: f64,
    /// Along which axis it looks, where it looks along one.
    axis: Option<usize>,
}

/// Corners closer than this to a plane are on it, in units: a thousand times what rounding does in a world as large as
/// [`HALF`], a ten-thousandth of what compilers take for nothing.
pub(super) const ON: f64 = 1e-7;

/// The world is a cube from −`HALF` to `HALF` on each axis, in units; the largest maps that engines load are half as large.
pub(super) const HALF: f64 = 131_072.0;

impl Side {
    /// The side that the plane of a map looks to.
    pub(super) fn before(plane: &SplitPlane) -> Side {
        let normal = DVec3::from(plane.normal);
        let axis = (0..3).find(|&axis| normal[axis].abs() == 1.0 && normal.abs().element_sum() == 1.0);
        let length = if axis.is_some() { 1.0 } else { normal.length() };
        Side {
            normal: normal / length,
            offset: plane.offset / length,
            axis,
        }
    }

    /// The side that lies behind the plane.
    pub(super) fn behind(&self) -> Side {
        Side {
            normal: -self.normal,
            offset: -self.offset,
            axis: self.axis,
        }
    }

    /// How far in a point is, in units; below 0 outside.
    pub(super) fn inside(&self, point: DVec3) -> f64 {
        self.normal.dot(point) - self.offset
    }

    /// The most and the least that corners are inside.
    fn range(&self, corners: &[DVec3]) -> [f64; 2] {
        let start = [f64::NEG_INFINITY, f64::INFINITY];
        corners.iter().fold(start, |[most, least], &corner| {
            let inside = self.inside(corner);
            [most.max(inside), least.min(inside)]
        })
    }

    /// What of a polygon lies inside; empty where it only touches. A polygon in the plane is on both of its sides.
    pub(super) fn cut(&self, polygon: Vec<DVec3>) -> Vec<DVec3> {
        let [most, least] = self.range(&polygon);
        if least >= -ON {
            return polygon;
        }
        if most <= ON {
            return Vec::new();
        }
        let mut kept = Vec::with_capacity(polygon.len() + 1);
        let mut before = polygon[polygon.len() - 1];
        let mut before_inside = self.inside(before);
        for corner in polygon {
            let inside = self.inside(corner);
            let crosses = (before_inside > ON && inside < -ON) || (before_inside < -ON && inside > ON);
            if crosses {
                kept.push(self.between([before, corner], [before_inside, inside]));
            }
            if inside >= -ON {
                kept.push(corner);
            }
            before = corner;
            before_inside = inside;
        }
        kept
    }

    /// Where the line from one end to the other meets the plane. The same point whichever end is named first.
    fn between(&self, ends: [DVec3; 2], inside: [f64; 2]) -> DVec3 {
        let first = usize::from(inside[0] < inside[1]);
        let [from, to] = [ends[first], ends[1 - first]];
        let part = inside[first] / (inside[first] - inside[1 - first]);
        let mut point = from + (to - from) * part;
        for axis in 0..3 {
            if from[axis] == to[axis] {
                point[axis] = from[axis];
            }
        }
        if let Some(axis) = self.axis {
            point[axis] = self.offset * self.normal[axis];
        }
        point
    }

    /// The whole plane, as far as the world goes; empty where the plane lies outside. Counter-clockwise seen from inside.
    pub(super) fn sheet(&self) -> Vec<DVec3> {
        if self.offset.abs() > 2.0 * HALF {
            return Vec::new();
        }
        let up = match self.axis {
            Some(2) => DVec3::X,
            Some(_) => DVec3::Z,
            None if self.normal.z.abs() > 0.7 => DVec3::X,
            None => DVec3::Z,
        };
        let along = up.cross(self.normal).normalize() * 4.0 * HALF;
        let across = self.normal.cross(along);
        let middle = self.normal * self.offset;
        vec![
            middle - along - across,
            middle + along - across,
            middle + along + across,
            middle - along + across,
        ]
    }
}

/// The six sides of a box, from its least to its greatest corner, which look into it.
pub(super) fn sides_of([least, most]: [DVec3; 2]) -> [Side; 6] {
    std::array::from_fn(|at| {
        let axis = at / 2;
        let [sign, offset] = if at % 2 == 0 {
            [1.0, least[axis]]
        } else {
            [-1.0, -most[axis]]
        };
        Side {
            normal: DVec3::AXES[axis] * sign,
            offset,
            axis: Some(axis),
        }
    })
}

/// The width of the narrowest strip that a convex polygon fits in, in units.
pub(super) fn width(corners: &[DVec3]) -> f64 {
    let first = corners[0];
    let twice_area: DVec3 = corners[1..]
        .windows(2)
        .map(|pair| (pair[0] - first).cross(pair[1] - first))
        .sum();
    let Some(normal) = twice_area.try_normalize() else {
        return 0.0;
    };
    let edges = (0..corners.len()).map(|at| [corners[at], corners[(at + 1) % corners.len()]]);
    let widths = edges.filter_map(|[from, to]| {
        let inward = normal.cross(to - from).try_normalize()?;
        let depths = corners.iter().map(|&corner| inward.dot(corner - from));
        Some(depths.fold(0.0, f64::max))
    });
    widths.fold(f64::INFINITY, f64::min)
}

/// Leaves of corners that stand in one place, to a millionth of a unit, the first.
pub(super) fn tidy(corners: &mut Vec<DVec3>) {
    const SAME: f64 = 1e-6;
    corners.dedup_by(|here, before| here.distance(*before) < SAME);
    while corners.len() > 1 && corners[0].distance(corners[corners.len() - 1]) < SAME {
        corners.pop();
    }
}
