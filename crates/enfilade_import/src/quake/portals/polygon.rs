//! Clips convex polygons by planes.
//!
//! Axis-aligned planes cut at exactly the offset in the file, so portals of grid-aligned maps touch bit-exactly.
//! Corners within the rounding tolerance of a plane stay on both sides, so nothing that light passes through is cut
//! off.

use crate::quake::bsp::SplitPlane;
use glam::DVec3;

/// A vertex of a polygon.
#[derive(Clone, Copy, Debug)]
pub(super) struct Corner {
    pub(super) at: DVec3,
    /// The plane of the edge from this corner to the next.
    pub(super) edge: Side,
}

/// The half-space where `normal · x ≥ offset`.
#[derive(Clone, Copy, Debug)]
pub(super) struct Side {
    /// Unit length.
    pub(super) normal: DVec3,
    offset: f64,
    /// The axis of an axis-aligned plane.
    pub(super) axis: Option<usize>,
}

/// Corners closer than this to a plane are on it, in units: a thousand times the rounding error in a world of size
/// [`HALF`], and far below the tolerance of map compilers.
pub(super) const ON: f64 = 1e-7;

/// The world is a cube from −`HALF` to `HALF` on each axis, in units; the largest maps that engines load are half that
/// size.
pub(super) const HALF: f64 = 131_072.0;

impl Side {
    /// Returns the front side of a plane of the map.
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

    /// Returns the front side of the plane through a point, with a normal of unit length.
    pub(super) fn across(normal: DVec3, point: DVec3) -> Side {
        Side {
            normal,
            offset: normal.dot(point),
            axis: None,
        }
    }

    /// Returns the opposite side.
    pub(super) fn behind(&self) -> Side {
        Side {
            normal: -self.normal,
            offset: -self.offset,
            axis: self.axis,
        }
    }

    /// Returns the signed distance of a point, in units; negative outside.
    pub(super) fn inside(&self, point: DVec3) -> f64 {
        self.normal.dot(point) - self.offset
    }

    /// Returns the maximum and the minimum signed distance of corners.
    fn range(&self, corners: &[Corner]) -> [f64; 2] {
        let start = [f64::NEG_INFINITY, f64::INFINITY];
        corners.iter().fold(start, |[most, least], corner| {
            let inside = self.inside(corner.at);
            [most.max(inside), least.min(inside)]
        })
    }

    /// Clips a polygon to this side; returns no corners if it only touches. A polygon in the plane is on both sides.
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
                // When the outline leaves through the plane, the next kept edge is in the plane.
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

    /// Returns the intersection of a line segment with the plane; bit-identical for both directions of the segment.
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

    /// Returns a polygon that covers the plane across the whole world; empty if the plane is outside it.
    /// Counter-clockwise seen from the front.
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

/// Returns the six sides of a box, given its minimum and maximum corner; their fronts point into it.
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
