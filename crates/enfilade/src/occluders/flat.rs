//! Convex polygons in a plane, counter-clockwise, and the half-planes that bound them.

use glam::{DMat2, DVec2};

/// A half-plane: inward · p ≥ offset, with a unit normal.
#[derive(Clone, Copy)]
pub(super) struct Side {
    pub(super) inward: DVec2,
    offset: f64,
}

impl Side {
    /// Returns the half-plane to the left of the line through two points.
    pub(super) fn left_of(from: DVec2, to: DVec2) -> Side {
        Side::through(from, (to - from).perp())
    }

    /// Returns the half-plane bounded by a line through `point`, on the side of `inward`.
    pub(super) fn through(point: DVec2, inward: DVec2) -> Side {
        // Exact if axis-aligned, as most walls are.
        let inward = if inward.x == 0.0 || inward.y == 0.0 {
            DVec2::new(sign(inward.x), sign(inward.y))
        } else {
            inward.normalize()
        };
        Side {
            inward,
            offset: inward.dot(point),
        }
    }

    /// Returns the half-plane moved inwards by a distance.
    pub(super) fn moved(self, inward: f64) -> Side {
        Side {
            offset: self.offset + inward,
            ..self
        }
    }

    /// Returns the signed distance of a point inside the half-plane.
    pub(super) fn height(&self, point: DVec2) -> f64 {
        self.inward.dot(point) - self.offset
    }
}

/// Returns −1, 0 or 1.
fn sign(value: f64) -> f64 {
    if value == 0.0 { 0.0 } else { value.signum() }
}

/// Returns the half-planes that bound a counter-clockwise polygon.
pub(super) fn sides(piece: &[DVec2]) -> impl Iterator<Item = Side> + '_ {
    (0..piece.len()).map(|place| Side::left_of(piece[place], piece[(place + 1) % piece.len()]))
}

/// Returns the part of a segment whose height above all sides is more than `reach`, as fractions of its length; `None`
/// if there is none.
pub(super) fn inside(sides: &[Side], reach: f64, from: DVec2, to: DVec2) -> Option<[f64; 2]> {
    let [mut start, mut end] = [0.0_f64, 1.0_f64];
    for side in sides {
        let [a, b] = [from, to].map(|point| side.height(point) - reach);
        if a <= 0.0 && b <= 0.0 {
            return None;
        }
        let crossing = a / (a - b);
        if a <= 0.0 {
            start = start.max(crossing);
        } else if b <= 0.0 {
            end = end.min(crossing);
        }
    }
    (start < end).then_some([start, end])
}

/// Clips a convex polygon by a half-plane.
pub(super) fn clipped(piece: &[DVec2], side: &Side) -> Vec<DVec2> {
    let mut kept = Vec::with_capacity(piece.len() + 1);
    for (place, &corner) in piece.iter().enumerate() {
        let next = piece[(place + 1) % piece.len()];
        let [here, there] = [corner, next].map(|point| side.height(point));
        if here >= 0.0 {
            kept.push(corner);
        }
        if (here > 0.0 && there < 0.0) || (here < 0.0 && there > 0.0) {
            let mut at = corner + (next - corner) * (here / (here - there));
            for axis in 0..2 {
                if side.inward[1 - axis] == 0.0 {
                    at[axis] = side.offset * side.inward[axis];
                }
            }
            kept.push(at);
        }
    }
    kept.dedup();
    if kept.len() > 1 && kept[0] == kept[kept.len() - 1] {
        kept.pop();
    }
    kept
}

/// Returns twice the signed area, positive if the corners are counter-clockwise.
pub(super) fn doubled(piece: &[DVec2]) -> f64 {
    let Some(&first) = piece.first() else { return 0.0 };
    piece
        .windows(2)
        .map(|pair| (pair[0] - first).perp_dot(pair[1] - first))
        .sum()
}

/// Returns the area of a polygon.
pub(super) fn area_of(piece: &[DVec2]) -> f64 {
    0.5 * doubled(piece).abs()
}

/// Returns `true` if a polygon contains a point.
pub(super) fn holds(piece: &[DVec2], point: DVec2) -> bool {
    sides(piece).all(|side| side.height(point) >= 0.0)
}

/// Returns the centroid of a polygon, and a metric (d·M·d is the squared distance) in which it is about as long as
/// wide; `None` if it has no area.
pub(super) fn shape(piece: &[DVec2]) -> Option<(DVec2, DMat2)> {
    let first = *piece.first()?;
    let (mut sum, mut whole) = (DVec2::ZERO, 0.0);
    for pair in piece.windows(2) {
        let [a, b] = [pair[0] - first, pair[1] - first];
        let area = a.perp_dot(b);
        sum += (a + b) * area / 3.0;
        whole += area;
    }
    if whole <= 0.0 {
        return None;
    }
    let middle = first + sum / whole;
    // Second moments of the triangles around the centroid, approximated from their corners.
    let mut moments = DMat2::ZERO;
    for (place, &corner) in piece.iter().enumerate() {
        let [a, b] = [corner - middle, piece[(place + 1) % piece.len()] - middle];
        let area = a.perp_dot(b).abs();
        for d in [a, b, a + b] {
            moments += DMat2::from_cols(d * d.x, d * d.y) * area;
        }
    }
    let inverse = moments * (1.0 / (moments.x_axis.x + moments.y_axis.y));
    let measure = inverse.inverse();
    measure.is_finite().then_some((middle, measure))
}

/// Returns the area of a piece outside others.
pub(super) fn added_by(piece: &[DVec2], others: &[Vec<DVec2>]) -> f64 {
    // Each subtraction of a convex polygon leaves up to as many convex parts as it has sides. Beyond this limit, parts
    // are kept whole.
    const MAX_PARTS: usize = 256;
    let mut parts = vec![piece.to_vec()];
    for other in others {
        let mut next = Vec::new();
        for mut part in parts {
            let overlaps = sides(other).all(|side| part.iter().any(|&corner| side.height(corner) > 0.0));
            if !overlaps || next.len() > MAX_PARTS {
                next.push(part);
                continue;
            }
            for side in sides(other) {
                let outside = Side {
                    inward: -side.inward,
                    offset: -side.offset,
                };
                let out = clipped(&part, &outside);
                if doubled(&out) > 0.0 {
                    next.push(out);
                }
                part = clipped(&part, &side);
            }
        }
        parts = next;
    }
    parts.iter().map(|part| area_of(part)).sum()
}
