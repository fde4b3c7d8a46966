//! Convex polygons, and what planes leave of them.
//!
//! Planes along an axis cut to the very number that the file has, so that portals of grid-aligned maps touch where they
//! touch, to the last digit. What rounding cannot decide stays on both sides: nothing that light goes through is cut off.

use crate::quake::bsp::SplitPlane;
use glam::DVec3;

/// Where a polygon turns.
#[derive(Clone, Copy, Debug)]
pub(super) struct Corner {
    pub(super) at: DVec3,
    /// The plane that cut the edge from here to the next corner.
    pub(super) edge: Side,
}

/// The side of a plane where `normal · x ≥ offset`.
#[derive(Clone, Copy, Debug)]
pub(super) struct Side {
    /// Of length one.
    pub(super) normal: DVec3,
    offset: f64,
    /// Along which axis it looks, where it looks along one.
    pub(super) axis: Option<usize>,
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
    fn range(&self, corners: &[Corner]) -> [f64; 2] {
        let start = [f64::NEG_INFINITY, f64::INFINITY];
        corners.iter().fold(start, |[most, least], corner| {
            let inside = self.inside(corner.at);
            [most.max(inside), least.min(inside)]
        })
    }

    /// What of a polygon lies inside; empty where it only touches. A polygon in the plane is on both of its sides.
    pub(super) fn cut(&self, polygon: Vec<Corner>) -> Vec<Corner> {
        let [most, least] = self.range(&polygon);
        if least >= -ON {
            return polygon;
        }
        if most <= ON {
            return Vec::new();
        }
        let mut kept = Vec::with_capacity(polygon.len() + 1);
        for (nth, &corner) in polygon.iter().enumerate() {
            let next = polygon[(nth + 1) % polygon.len()];
            let [here, there] = [corner.at, next.at].map(|at| self.inside(at));
            if here >= -ON {
                // From the plane on, the edge to the next corner that is kept lies in it.
                let leaves = here <= ON && there < -ON;
                let edge = if leaves { *self } else { corner.edge };
                kept.push(Corner { edge, ..corner });
            }
            if (here > ON && there < -ON) || (here < -ON && there > ON) {
                let at = self.between([corner.at, next.at], [here, there]);
                let edge = if here > there { *self } else { corner.edge };
                kept.push(Corner { at, edge });
            }
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
    pub(super) fn sheet(&self) -> Vec<Corner> {
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
        let corners = [
            middle - along - across,
            middle + along - across,
            middle + along + across,
            middle - along + across,
        ];
        corners.map(|at| Corner { at, edge: *self }).to_vec()
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
