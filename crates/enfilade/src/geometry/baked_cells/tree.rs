//! Finds the leaves of a BSP tree that a point, box or polygon overlaps. Rounding may add leaves, but never misses one.
//!
//! Polygons are clipped by planes moved outwards by more than the rounding of all clips can shift the rest. After
//! [`MAX_CUTS`] clips this no longer holds, so clipping stops. Traversal uses an explicit stack, because a tree may be
//! as deep as it has nodes.

use super::{BakedCellsError, CellNode, CellSide, CellTree};
use crate::geom::Aabb;
use crate::ids::CellId;
use glam::DVec3;

/// Rounding error of a plane test, relative to the coordinates: twice the rounding of f32, in positions and in planes.
const ROUNDING: f64 = 1.0 / (1_u64 << 22) as f64;

/// Maximum number of clips of a polygon: each clip shifts it by 2⁻⁵⁰ of its coordinates, and planes are moved by 2⁻²².
const MAX_CUTS: u32 = 1000;

/// A leaf that something may overlap.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Leaf {
    Cell(CellId),
    /// No cell. `barely`: the overlap is within the rounding error and tolerance of a plane.
    Solid {
        barely: bool,
    },
}

/// Checks the tree, normalizes its normals, and returns its depth.
pub(super) fn check(tree: &mut CellTree, cells: usize) -> Result<u32, BakedCellsError> {
    let CellTree {
        root,
        nodes,
        tolerance,
    } = tree;
    if !(*tolerance >= 0.0 && tolerance.is_finite()) {
        return Err(BakedCellsError::Tolerance(*tolerance));
    }
    for (number, node) in nodes.iter_mut().enumerate() {
        (node.normal, node.distance) = unit(node).ok_or(BakedCellsError::BadPlane(number))?;
    }
    let mut reached = vec![false; nodes.len()];
    let mut waiting = vec![(*root, None, true, 0)];
    let mut deepest = 0;
    while let Some((side, of, front, depth)) = waiting.pop() {
        match side {
            CellSide::Solid => {}
            CellSide::Cell(CellId(cell)) if (cell as usize) < cells => {}
            CellSide::Cell(CellId(cell)) => {
                return Err(BakedCellsError::NoSuchCell {
                    of,
                    front,
                    cell,
                    cells,
                });
            }
            CellSide::Node(number) => {
                let node = nodes.get(number as usize).ok_or(BakedCellsError::NoSuchNode {
                    of,
                    front,
                    node: number,
                    nodes: nodes.len(),
                })?;
                if std::mem::replace(&mut reached[number as usize], true) {
                    return Err(BakedCellsError::NoTree(number));
                }
                deepest = deepest.max(depth + 1);
                waiting.push((node.back, Some(number), false, depth + 1));
                waiting.push((node.front, Some(number), true, depth + 1));
            }
        }
    }
    Ok(deepest)
}

/// Returns the plane with a unit normal; `None` if the plane is invalid.
fn unit(node: &CellNode) -> Option<([f64; 3], f64)> {
    let normal = DVec3::from(node.normal);
    // Scaled first: squares of huge or tiny numbers would overflow or underflow.
    let scale = normal.abs().max_element();
    let sound = normal.is_finite() && scale > 0.0 && node.distance.is_finite();
    let scaled = normal / scale;
    // A unit normal stays as it is, so that a stored tree is the same again.
    if sound && (normal.length_squared() - 1.0).abs() < 2e-15 {
        return Some((node.normal, node.distance));
    }
    let length = scaled.length();
    let distance = node.distance / scale / length;
    let plane = (scaled / length).to_array();
    (sound && distance.is_finite() && plane.iter().all(|value| value.is_finite()))
        .then_some((plane, distance))
}

/// Returns the leaf that contains a point.
pub(super) fn leaf_at(tree: &CellTree, point: DVec3) -> Leaf {
    let mut side = tree.root;
    loop {
        match side {
            CellSide::Cell(cell) => return Leaf::Cell(cell),
            CellSide::Solid => return Leaf::Solid { barely: false },
            CellSide::Node(number) => {
                let node = &tree.nodes[number as usize];
                let is_front = DVec3::from(node.normal).dot(point) >= node.distance;
                side = if is_front { node.front } else { node.back };
            }
        }
    }
}

/// Returns the maximum error of a plane test for coordinates up to `far`.
fn slack(tree: &CellTree, node: &CellNode, far: f64) -> f64 {
    tree.tolerance + ROUNDING * (far + node.distance.abs())
}

/// Returns the deepest subtree that contains all leaves that a box overlaps: a leaf, or the first node that splits it.
pub(super) fn around(tree: &CellTree, bounds: &Aabb) -> CellSide {
    let [min, max] = [bounds.min, bounds.max].map(|corner| DVec3::from(corner.map(f64::from)));
    let far = min.abs().max(max.abs()).max_element();
    let mut side = tree.root;
    while let CellSide::Node(number) = side {
        let node = &tree.nodes[number as usize];
        let normal = DVec3::from(node.normal);
        // By the interval ends along the normal: the centre of a box may overflow even if its corners are finite.
        let at_least = (normal * min).min(normal * max);
        let at_most = (normal * min).max(normal * max);
        let sum = |ends: DVec3| ends.x + ends.y + ends.z - node.distance;
        let slack = slack(tree, node, far);
        side = if sum(at_least) > slack {
            node.front
        } else if sum(at_most) < -slack {
            node.back
        } else {
            return side;
        };
    }
    side
}

/// The stack and scratch buffers of a traversal with a polygon.
#[derive(Default)]
pub(crate) struct Room {
    /// The query: an outline to be clipped, or points whose convex hull is tested without clipping.
    points: Vec<DVec3>,
    waiting: Vec<Piece>,
    offsets: Vec<f64>,
    /// Number of plane tests since this was set to 0.
    pub(crate) planes: u64,
}

/// The rest of a polygon in a subtree: points from `start` to `end`.
struct Piece {
    side: CellSide,
    start: usize,
    end: usize,
    /// Length of `points` when this piece was pushed; later points are discarded when it is popped.
    top: usize,
    cuts: u32,
    barely: bool,
}

impl Room {
    /// Starts a query with the outline of a planar convex polygon.
    pub(crate) fn outline(&mut self, corners: impl IntoIterator<Item = DVec3>) {
        self.take(corners, 0);
    }

    /// Starts a query with the convex hull of points, in any order.
    pub(crate) fn hull(&mut self, points: impl IntoIterator<Item = DVec3>) {
        self.take(points, MAX_CUTS);
    }

    fn take(&mut self, points: impl IntoIterator<Item = DVec3>, cuts: u32) {
        self.points.clear();
        self.points.extend(points);
        self.waiting.clear();
        self.waiting.push(Piece {
            side: CellSide::Solid,
            start: 0,
            end: self.points.len(),
            top: self.points.len(),
            cuts,
            barely: false,
        });
    }
}

/// Calls `each` with the leaves below `side` that the query may overlap, until it returns `false`. Returns `false` if
/// `each` did, or if a coordinate is not finite.
pub(super) fn touched(
    tree: &CellTree,
    side: CellSide,
    room: &mut Room,
    mut each: impl FnMut(Leaf) -> bool,
) -> bool {
    let far = room
        .points
        .iter()
        .fold(0.0, |far: f64, point| far.max(point.abs().max_element()));
    if room.points.is_empty() || room.points.iter().any(|point| !point.is_finite()) {
        return room.points.is_empty();
    }
    if let [whole] = &mut room.waiting[..] {
        whole.side = side;
    }
    while let Some(piece) = room.waiting.pop() {
        let leaf = match piece.side {
            CellSide::Node(number) => {
                room.part(
                    &piece,
                    &tree.nodes[number as usize],
                    slack(tree, &tree.nodes[number as usize], far),
                );
                continue;
            }
            CellSide::Cell(cell) => Leaf::Cell(cell),
            CellSide::Solid => Leaf::Solid { barely: piece.barely },
        };
        if !each(leaf) {
            return false;
        }
    }
    true
}

impl Room {
    /// Pushes the parts of a piece on each side of a plane with error `slack`.
    fn part(&mut self, piece: &Piece, node: &CellNode, slack: f64) {
        self.planes += 1;
        let normal = DVec3::from(node.normal);
        self.points.truncate(piece.top);
        self.offsets.clear();
        let points = &self.points[piece.start..piece.end];
        self.offsets
            .extend(points.iter().map(|&point| normal.dot(point) - node.distance));
        let least = self
            .offsets
            .iter()
            .fold(f64::INFINITY, |least, &off| least.min(off));
        let most = self
            .offsets
            .iter()
            .fold(f64::NEG_INFINITY, |most, &off| most.max(off));
        let [in_front, behind] = [most >= -slack, least <= slack];
        if !(in_front && behind) {
            let side = if in_front { node.front } else { node.back };
            self.waiting.push(Piece { side, ..*piece });
            return;
        }
        for (side, sign, reach) in [(node.front, 1.0, most), (node.back, -1.0, -least)] {
            let barely = piece.barely || reach <= slack;
            let start = self.points.len();
            let mut left = Piece {
                side,
                barely,
                ..*piece
            };
            // Not clipped if all of it is on this side, or if it was clipped too often to bound its error.
            let is_cut = piece.cuts < MAX_CUTS && self.offsets.iter().any(|off| sign * off < -slack);
            if is_cut {
                self.cut(piece, sign, slack);
                [left.start, left.end] = [start, self.points.len()];
                left.cuts += 1;
            }
            left.top = self.points.len();
            self.waiting.push(left);
        }
    }

    /// Appends the part of a piece where `sign` times the distance from a plane is at least −`slack`.
    fn cut(&mut self, piece: &Piece, sign: f64, slack: f64) {
        let count = piece.end - piece.start;
        for at in 0..count {
            let next = (at + 1) % count;
            let [here, there] = [at, next].map(|at| sign * self.offsets[at] + slack);
            let [corner, after] = [at, next].map(|at| self.points[piece.start + at]);
            if here >= 0.0 {
                self.points.push(corner);
            }
            if (here < 0.0) != (there < 0.0) {
                // The same result in either direction of the edge.
                let part = here / (here - there);
                self.points.push(corner * (1.0 - part) + after * part);
            }
        }
    }
}
