//! Convex polygons in a plane, counter-clockwise, and the lines that bound them.

use glam::{DMat2, DVec2};

/// A half of the plane: where inward · p ≥ offset; the normal is of unit length.
#[derive(Clone, Copy)]
pub(super) struct Side {
    pub(super) inward: DVec2,
    offset: f64,
}

impl Side {
    pub(super) fn left_of(from: DVec2, to: DVec2) -> Side {
        Side::through(from, (to - from).perp())
    }

    pub(super) fn through(point: DVec2, inward: DVec2) -> Side {
        // Exact along the axes, as most walls are.
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

    pub(super) fn moved(self, inward: f64) -> Side {
        Side {
            offset: self.offset + inward,
            ..self
        }
    }

    pub(super) fn height(&self, point: DVec2) -> f64 {
        self.inward.dot(point) - self.offset
    }
}

/// −1, 0 or 1.
fn sign(value: f64) -> f64 {
    if value == 0.0 { 0.0 } else { value.signum() }
}

pub(super) fn sides(piece: &[DVec2]) -> impl Iterator<Item = Side> + '_ {
    (0..piece.len()).map(|place| Side::left_of(piece[place], piece[(place + 1) % piece.len()]))
}

/// The part of a segment that is higher than `reach` over all sides, as fractions of its length; `None` where none is.
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

/// The part of a convex polygon on one side.
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

/// Twice the area, above zero where corners run counter-clockwise.
pub(super) fn doubled(piece: &[DVec2]) -> f64 {
    let Some(&first) = piece.first() else { return 0.0 };
    piece
        .windows(2)
        .map(|pair| (pair[0] - first).perp_dot(pair[1] - first))
        .sum()
}

pub(super) fn area_of(piece: &[DVec2]) -> f64 {
    0.5 * doubled(piece).abs()
}

pub(super) fn holds(piece: &[DVec2], point: DVec2) -> bool {
    sides(piece).all(|side| side.height(point) >= 0.0)
}

/// The middle of a polygon, and a measure of distance by which it is about as long as broad.
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
    // Moments of the triangles around the middle, by their corners: near enough.
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

/// The area of a piece outside others.
pub(super) fn added_by(piece: &[DVec2], others: &[Vec<DVec2>]) -> f64 {
    // A piece less a convex one is as many convex ones as that has sides, at most.
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
