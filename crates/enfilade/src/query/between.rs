//! Visibility between two boxes, over all straight lines from one to the other.
//!
//! Idea: an unobstructed line proves visibility. A single convex occluder that blocks all lines between the corners
//!     proves that the boxes are hidden from each other.
//! Source: Teller, Séquin, Visibility Preprocessing for Interactive Walkthroughs, SIGGRAPH 1991, for cell-to-cell
//!     visibility; Coorg, Teller, Real-Time Occlusion Culling for Models with Large Occluders, I3D 1997, for one convex
//!     occluder at a time.
//! Cost: up to 64 lines, and 64 pairs of corners for each occluder along the line between the centres.
//! Never wrong: if neither is proven, the result is unknown.

use crate::geom::{Aabb, Line, Step};
use crate::geometry::{Alpha, Geometry};
use crate::ids::ItemIndex;
use crate::occluders::{OccluderSet, Wall};
use glam::DVec3;

/// Visibility between two boxes, from [`Geometry::between`].
#[derive(Clone, Copy, Debug, PartialEq)]
#[non_exhaustive]
pub enum BoxVisibility {
    /// At least this line, from a point of the first box to a point of the second, is unobstructed.
    Visible([[f32; 3]; 2]),
    /// Every line is blocked.
    Hidden,
    /// Neither could be proven.
    Unknown,
}

impl Geometry {
    /// Tests whether any straight line between two boxes is unobstructed. Opaque faces block a line from both sides. A
    /// box stands for everything in it, so faces inside or touching either box do not block, and boxes that overlap are
    /// visible. Openings, alpha-blended and alpha-tested faces block nothing.
    ///
    /// `occluders` must be those of this geometry ([`OccluderSet::build`]); only they can prove that a box is hidden.
    /// Returns [`BoxVisibility::Unknown`] for boxes that are empty or not finite.
    #[doc(alias = "cell-to-cell visibility")]
    #[doc(alias = "box to box visibility")]
    pub fn between(&self, from: &Aabb, to: &Aabb, occluders: &OccluderSet) -> BoxVisibility {
        let sound = |bounds: &Aabb| {
            !bounds.is_empty() && bounds.min.iter().chain(&bounds.max).all(|side| side.is_finite())
        };
        if !(sound(from) && sound(to)) {
            return BoxVisibility::Unknown;
        }
        let both = from.intersection(to);
        if !both.is_empty() {
            return BoxVisibility::Visible([both.center(); 2]);
        }
        let mut lines = lines(from, to);
        let first = lines.next();
        if let Some(line) = first.filter(|line| self.is_free(line, from, to)) {
            return BoxVisibility::Visible(line);
        }
        if self.is_hidden_by_one(from, to, occluders) {
            return BoxVisibility::Hidden;
        }
        let free = lines.find(|line| self.is_free(line, from, to));
        free.map_or(BoxVisibility::Unknown, BoxVisibility::Visible)
    }

    /// Returns `true` if no opaque face blocks a line between the boxes.
    fn is_free(&self, line: &[[f32; 3]; 2], from: &Aabb, to: &Aabb) -> bool {
        // Fraction of the line's length within which a face counts as touching a box.
        const TOUCHES: f64 = 1e-7;
        let [start, end] = line.map(|point| DVec3::from(point.map(f64::from)));
        let Some(line) = Line::new(start, end - start) else {
            return true;
        };
        let [leaves, enters] = [from, to].map(|bounds| line.meets(bounds, 0.0, 1.0));
        let leaves = leaves.map_or(0.0, |[_, leave]| leave) + TOUCHES;
        let enters = enters.map_or(1.0, |[enter, _]| enter) - TOUCHES;
        let mut free = true;
        let opaque = |material: &crate::geometry::Material| material.alpha == Alpha::Opaque;
        self.along(&line, enters, opaque, |hit| {
            if hit.distance > leaves && hit.distance < enters {
                free = false;
                // One hit is enough: a negative limit ends the search.
                return -1.0;
            }
            enters
        });
        free
    }

    /// Returns `true` if one occluder blocks every line.
    fn is_hidden_by_one(&self, from: &Aabb, to: &Aabb, occluders: &OccluderSet) -> bool {
        let [start, end] = [from, to].map(|bounds| DVec3::from(bounds.center().map(f64::from)));
        // Such an occluder must block the line between the centres.
        let Some(line) = Line::new(start, end - start) else {
            return false;
        };
        let mut found = false;
        self.item_tree().walk(start.into(), |step| match step {
            Step::Node(bounds) => !found && line.meets(bounds, line.margin(bounds), 1.0).is_some(),
            Step::Thing(item) => {
                let placed = self.item(ItemIndex(item));
                let near = line.meets(&placed.bounds, line.margin(&placed.bounds), 1.0);
                let Some(item_from_here) = placed
                    .transform()
                    .inverse()
                    .filter(|_| placed.options.is_occluder && near.is_some() && !found)
                else {
                    return true;
                };
                // In object space the box is a parallelepiped, still the convex hull of its corners.
                let corners = [from, to].map(|bounds| {
                    let corner = |corner: [f32; 3]| DVec3::from(item_from_here.point_f64(corner));
                    bounds.corners().map(corner)
                });
                let local = line.moved(&item_from_here.0);
                occluders.along(placed.mesh, &local, |wall| {
                    found = found || stops_all(&wall, &corners[0], &corners[1]);
                });
                true
            }
        });
        found
    }
}

/// Iterates over deterministic lines between two boxes: first from centre to centre, then a low-discrepancy sequence
/// over all six dimensions.
fn lines(from: &Aabb, to: &Aabb) -> impl Iterator<Item = [[f32; 3]; 2]> {
    /// The root of g⁷ = g + 1, whose powers give a low-discrepancy sequence. Roberts, The Unreasonable Effectiveness of
    /// Quasirandom Sequences, 2018.
    const G: f64 = 1.112_775_684_278_706;
    const LINES: u32 = 64;
    let boxes = [*from, *to];
    (0..LINES).map(move |number| {
        let mut step = 1.0;
        boxes.map(|bounds| {
            std::array::from_fn(|axis| {
                step /= G;
                let part = (0.5 + f64::from(number) * step).fract();
                // Sample the sides more often, because much is visible past edges.
                let part = ((part - 0.5) * 1.25 + 0.5).clamp(0.0, 1.0);
                let [min, max] = [bounds.min[axis], bounds.max[axis]];
                let at = (f64::from(min) + part * (f64::from(max) - f64::from(min))) as f32;
                at.clamp(min, max)
            })
        })
    })
}

/// Returns `true` if a convex wall blocks every line from the convex hull of `from` to that of `to`.
///
/// It does if all points of one are in front of its plane, all of the other behind, and it blocks the lines between the
/// corners. Proof: with one end fixed, the intersection of a line with the plane is the central projection of the other
/// end, which maps the hull of the corners, all on one side, to the hull of their images. So first one end, then the
/// other may move from corners to any points of the hulls: the intersection stays in the hull of those of the corners,
/// which is inside the convex wall.
///
/// The faces that the wall represents may be off its plane by up to `slack`. So both parallel planes at that distance
/// are tested: a line through the outline at both is inside it everywhere between them, and so crosses a face.
fn stops_all(wall: &Wall, from: &[DVec3; 8], to: &[DVec3; 8]) -> bool {
    let ends = || from.iter().chain(to).chain(wall.corners);
    let far = ends().map(|point| point.abs().max_element()).fold(0.0, f64::max);
    let rounding = 1e-9 * far;
    let slack = wall.slack + rounding;
    let heights = |points: &[DVec3; 8]| points.map(|point| wall.normal.dot(point) - wall.distance);
    let [above, below] = [heights(from), heights(to)];
    let before = |heights: &[f64; 8], side: f64| heights.iter().all(|height| height * side > slack);
    let parted = [1.0, -1.0]
        .iter()
        .any(|&side| before(&above, side) && before(&below, -side));
    let holds = |point: DVec3| {
        (0..wall.corners.len()).all(|i| {
            let [start, end] = [wall.corners[i], wall.corners[(i + 1) % wall.corners.len()]];
            let inwards = wall.normal.cross(end - start);
            inwards.dot(point - start) >= rounding * inwards.length()
        })
    };
    parted
        && from.iter().zip(above).all(|(&a, high)| {
            to.iter().zip(below).all(|(&b, low)| {
                let at = |height: f64| a + (b - a) * ((high - height) / (high - low));
                holds(at(slack)) && holds(at(-slack))
            })
        })
}

#[cfg(test)]
mod tests {
    use super::*;

    const CORNERS: [[f64; 3]; 4] = [
        [-1.0, -1.0, 0.0],
        [1.0, -1.0, 0.0],
        [1.0, 1.0, 0.0],
        [-1.0, 1.0, 0.0],
    ];

    fn stops(half: f32, at: f32, other: f32) -> bool {
        let corners = CORNERS.map(DVec3::from);
        let wall = Wall {
            corners: &corners,
            normal: DVec3::Z,
            distance: 0.0,
            slack: 0.0,
        };
        let cube = |half: f32, z: f32| {
            let bounds = Aabb {
                min: [-half, -half, z - half],
                max: [half, half, z + half],
            };
            bounds.corners().map(|corner| DVec3::from(corner.map(f64::from)))
        };
        stops_all(&wall, &cube(half, at), &cube(0.1, other))
    }

    #[test]
    fn a_wall_stops_all_lines_between_boxes_that_look_small_behind_it() {
        assert!(stops(0.9, 2.0, -1.0) && stops(0.9, -2.0, 1.0));
        // The larger box is visible past the edges at this distance.
        assert!(!stops(1.9, 2.0, -2.0));
        assert!(!stops(0.9, -2.0, -1.0), "both are behind it");
        assert!(!stops(0.9, 0.5, -1.0), "one intersects it");
    }
}
