//! Whether two boxes see each other, told of all straight lines between them at once.
//!
//! A line that nothing stops proves that they do; a convex wall that stops the lines between their corners, that they do not.
//! Source: Teller, Séquin, Visibility Preprocessing for Interactive Walkthroughs, SIGGRAPH 1991, for visibility of cells
//!     that holds wherever one stands in them; Coorg, Teller, Real-Time Occlusion Culling for Models with Large Occluders,
//!     I3D 1997, for one convex occluder at a time.
//! Cost: up to 64 lines, and the occluders along the line between the middles, 64 pairs of corners each.
//! Never wrong: what neither proves is unknown.

use crate::geom::{Aabb, Line, Step};
use crate::geometry::{Alpha, Geometry, ItemId};
use crate::occluders::{OccluderSet, Wall};
use glam::DVec3;

/// What is known of all straight lines from the points of one box to those of another.
#[derive(Clone, Copy, Debug, PartialEq)]
#[non_exhaustive]
pub enum BoxVisibility {
    /// Nothing stops this one, from a point of the first to a point of the second.
    Visible([[f32; 3]; 2]),
    /// Every line is stopped.
    Hidden,
    /// Neither was proven.
    Unknown,
}

impl Geometry {
    /// Do two boxes see each other? A line between them is stopped where it meets an opaque face, from whichever side,
    /// outside of both: a box stands for all that is in it, so what lies in a box, or touches it, is never in the way. So
    /// boxes that overlap are visible. Openings stop nothing, nor do glass and cut-outs.
    ///
    /// `occluders` are those of this geometry ([`OccluderSet::build`]): only they can prove that something is hidden. Boxes
    /// that are empty or not finite are unknown.
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
        if self.is_walled_off(from, to, occluders) {
            return BoxVisibility::Hidden;
        }
        let free = lines.find(|line| self.is_free(line, from, to));
        free.map_or(BoxVisibility::Unknown, BoxVisibility::Visible)
    }

    /// Does nothing opaque stand in the way from one box to the other?
    fn is_free(&self, line: &[[f32; 3]; 2], from: &Aabb, to: &Aabb) -> bool {
        // Of the line's length: what is so near to a box touches it.
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
                // One is enough: nothing is nearer than this.
                return -1.0;
            }
            enters
        });
        free
    }

    /// Does one occluder stop every line?
    fn is_walled_off(&self, from: &Aabb, to: &Aabb, occluders: &OccluderSet) -> bool {
        let [start, end] = [from, to].map(|bounds| DVec3::from(bounds.center().map(f64::from)));
        // It must stop the line between the middles.
        let Some(line) = Line::new(start, end - start) else {
            return false;
        };
        let mut found = false;
        self.item_tree().walk(start.into(), |step| match step {
            Step::Node(bounds) => !found && line.meets(bounds, line.margin(bounds), 1.0).is_some(),
            Step::Thing(item) => {
                let placed = self.item(ItemId(item));
                let near = line.meets(&placed.bounds, line.margin(&placed.bounds), 1.0);
                let Some(item_from_here) = placed
                    .transform()
                    .inverse()
                    .filter(|_| placed.is_occluder && near.is_some() && !found)
                else {
                    return true;
                };
                // A box becomes a parallelepiped: still the convex hull of its corners.
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

/// Lines between two boxes, always the same ones: from middle to middle, then spread over all six dimensions.
fn lines(from: &Aabb, to: &Aabb) -> impl Iterator<Item = [[f32; 3]; 2]> {
    /// The root of g⁷ = g + 1: its powers are the least alike. Roberts, The Unreasonable Effectiveness of Quasirandom
    /// Sequences, 2018.
    const G: f64 = 1.112_775_684_278_706;
    const LINES: u32 = 64;
    let boxes = [*from, *to];
    (0..LINES).map(move |number| {
        let mut step = 1.0;
        boxes.map(|bounds| {
            std::array::from_fn(|axis| {
                step /= G;
                let part = (0.5 + f64::from(number) * step).fract();
                // A little more often at the sides: much is seen past edges.
                let part = ((part - 0.5) * 1.25 + 0.5).clamp(0.0, 1.0);
                let [min, max] = [bounds.min[axis], bounds.max[axis]];
                let at = (f64::from(min) + part * (f64::from(max) - f64::from(min))) as f32;
                at.clamp(min, max)
            })
        })
    })
}

/// Does a convex wall stop every line from the convex hull of some points to that of others?
///
/// It does if all of one lie before its plane, all of the others behind, and it stops the lines between the corners. For
/// with one end held, the place where a line goes through the plane is the other end seen in central projection, and that
/// maps the hull of the corners, all on one side, to the hull of their images. So first one end, then the other may go from
/// corners to any points of the hulls: the place stays in the hull of those of the corners, and the wall, being convex,
/// holds that.
///
/// The faces that the wall stands for may lie off its plane by `slack`. So both planes that far off are asked instead: what
/// goes through the wall's outline at both goes through it all the way between them, and so through a face.
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
        // The larger looks past its edges from so near.
        assert!(!stops(1.9, 2.0, -2.0));
        assert!(!stops(0.9, -2.0, -1.0), "both stand behind it");
        assert!(!stops(0.9, 0.5, -1.0), "one stands in it");
    }
}
