//! Floor plans drawn in squares of a metre: their walls, and their PVS.

use super::super::stage::{BROWN, GREY, Stage, WHITE, sheet};
use crate::shape::Shape;
use enfilade::{BakedCells, CellId, CellNode, CellSide, CellTree, MaterialId};
use enfilade_bake::{Cells, PairsOptions, Portal, VisiblePairs};
use glam::{Vec3, vec3};
use std::collections::BTreeMap;
use std::ops::Range;

/// Heights of rooms and of doorways.
const HIGH: [f32; 2] = [3.0, 2.0];

/// An open rectangle of the plan: a room, or a doorway through a wall.
#[derive(Clone, Debug)]
pub(crate) struct OpenRect {
    pub(crate) name: String,
    pub(crate) is_doorway: bool,
    /// Columns and rows, half-open.
    pub(crate) x: Range<usize>,
    pub(crate) z: Range<usize>,
}

/// Rooms and doorways in solid rock.
pub(crate) struct Plan {
    size: [usize; 2],
    /// Position of the first column and row.
    from: [f32; 2],
    pub(crate) open: Vec<OpenRect>,
    /// By row and column: index of the open rectangle there.
    squares: Vec<Option<usize>>,
}

/// A side of a square.
#[derive(Clone, Copy)]
struct Edge {
    name: &'static str,
    /// Step to the square beyond.
    way: [i32; 2],
    /// Offsets of its ends from the square's centre, left and right as seen from within.
    ends: [[f32; 2]; 2],
}

const EDGES: [Edge; 4] = [
    Edge {
        name: "north",
        way: [0, -1],
        ends: [[-0.5, -0.5], [0.5, -0.5]],
    },
    Edge {
        name: "east",
        way: [1, 0],
        ends: [[0.5, -0.5], [0.5, 0.5]],
    },
    Edge {
        name: "south",
        way: [0, 1],
        ends: [[0.5, 0.5], [-0.5, 0.5]],
    },
    Edge {
        name: "west",
        way: [-1, 0],
        ends: [[-0.5, 0.5], [-0.5, -0.5]],
    },
];

impl Plan {
    /// Parses a plan: a letter is a room, a digit or a capital a doorway; each fills a rectangle. `#` is rock.
    pub(crate) fn drawn(from: [f32; 2], rows: &[&str]) -> Plan {
        let mut open: BTreeMap<char, OpenRect> = BTreeMap::new();
        for (z, row) in rows.iter().enumerate() {
            for (x, letter) in row.chars().enumerate().filter(|(_, letter)| *letter != '#') {
                let found = open.entry(letter).or_insert(OpenRect {
                    name: letter.to_string(),
                    is_doorway: !letter.is_ascii_lowercase(),
                    x: x..x + 1,
                    z: z..z + 1,
                });
                found.x = found.x.start.min(x)..found.x.end.max(x + 1);
                found.z = found.z.start.min(z)..found.z.end.max(z + 1);
            }
        }
        Plan::new(from, [rows[0].len(), rows.len()], open.into_values().collect())
    }

    pub(crate) fn new(from: [f32; 2], size: [usize; 2], open: Vec<OpenRect>) -> Plan {
        let mut squares = vec![None; size[0] * size[1]];
        for (number, OpenRect { x, z, .. }) in open.iter().enumerate() {
            for z in z.clone() {
                squares[z * size[0]..][x.clone()].fill(Some(number));
            }
        }
        Plan {
            size,
            from,
            open,
            squares,
        }
    }

    /// Returns the minimum and maximum x and z of a room.
    pub(crate) fn bounds(&self, room: &OpenRect) -> [[f32; 2]; 2] {
        let at = |x: usize, z: usize| [self.from[0] + x as f32, self.from[1] + z as f32];
        [at(room.x.start, room.z.start), at(room.x.end, room.z.end)]
    }

    /// Returns the index of the open rectangle at a square; `None` in rock or outside.
    fn at(&self, [x, z]: [i32; 2]) -> Option<usize> {
        let [x, z] = [usize::try_from(x).ok()?, usize::try_from(z).ok()?];
        let inside = x < self.size[0] && z < self.size[1];
        inside.then(|| self.squares[z * self.size[0] + x]).flatten()
    }

    fn is_outside(&self, [x, z]: [i32; 2]) -> bool {
        let [width, depth] = self.size.map(|side| side as i32);
        !((0..width).contains(&x) && (0..depth).contains(&z))
    }

    /// Builds the walls: an item for each side of a room, and one for each floor and ceiling. A doorway at the edge of
    /// the plan stays open there.
    pub(crate) fn build(&self, stage: &mut Stage) {
        let mut shapes: BTreeMap<String, Shape> = BTreeMap::new();
        for (number, room) in self.open.iter().enumerate() {
            let mut add = |name: &str, material: MaterialId, corner: Vec3, along: Vec3, up: Vec3| {
                let shape = shapes.entry(format!("{} {name}", room.name)).or_default();
                shape.join(sheet(material, corner, along, up));
            };
            let [wall, flat] = if room.is_doorway {
                [BROWN; 2]
            } else {
                [WHITE, GREY]
            };
            let high = HIGH[usize::from(room.is_doorway)];
            for [x, z] in room.z.clone().flat_map(|z| room.x.clone().map(move |x| [x, z])) {
                let corner = vec3(self.from[0] + x as f32, 0.0, self.from[1] + z as f32);
                add("floor", flat, corner + Vec3::Z, Vec3::X, -Vec3::Z);
                add("ceiling", flat, corner + Vec3::Y * high, Vec3::X, Vec3::Z);
                for Edge { name, way, ends } in EDGES {
                    let beside = [x as i32 + way[0], z as i32 + way[1]];
                    let other = self.at(beside);
                    if other == Some(number) || (room.is_doorway && self.is_outside(beside)) {
                        continue;
                    }
                    let middle = corner + vec3(0.5, 0.0, 0.5);
                    let [start, end] = ends.map(|[x, z]| middle + vec3(x, 0.0, z));
                    // Split at the height of doorways, so that neighbours share their corners.
                    if other.is_none() {
                        add(name, wall, start, end - start, Vec3::Y * HIGH[1]);
                    }
                    let is_open_above = other.is_some_and(|other| !self.open[other].is_doorway);
                    if !room.is_doorway && !is_open_above {
                        let above = Vec3::Y * HIGH[1];
                        add(name, wall, start + above, end - start, Vec3::Y * HIGH[0] - above);
                    }
                }
            }
        }
        for (name, shape) in shapes {
            stage.thing(&name, &shape);
        }
    }

    /// Bakes the cells: one for each room and each doorway, in order, and the PVS between them.
    pub(crate) fn bake(&self) -> BakedCells {
        let cells = Cells::new(self.open.len() as u32, self.portals()).expect("doorways are flat and convex");
        let pairs = VisiblePairs::compute(&cells, &PairsOptions::default()).expect("little memory");
        let mut tree = CellTree {
            root: CellSide::Solid,
            nodes: Vec::new(),
            tolerance: 0.0,
        };
        let within = self.part(&mut tree, [0..self.size[0], 0..self.size[1]]);
        let above_floor = add(&mut tree, Vec3::Y, 0.0, within, CellSide::Solid);
        tree.root = above_floor;
        let row_of: Vec<Option<u32>> = (0..self.open.len() as u32).map(Some).collect();
        let rows = (0..self.open.len() as u32).map(|cell| pairs.seen_from(cell).map(CellId));
        BakedCells::new(tree, &row_of, rows).expect("a tree over squares is sound")
    }

    /// Returns the portals between doorways and rooms.
    fn portals(&self) -> Vec<Portal> {
        let mut portals = Vec::new();
        for (number, door) in self.open.iter().enumerate().filter(|(_, open)| open.is_doorway) {
            let [x, z] = [door.x.start, door.z.start];
            for Edge { way, ends, .. } in EDGES {
                let Some(room) = self.at([x as i32 + way[0], z as i32 + way[1]]) else {
                    continue;
                };
                let middle = [self.from[0] + x as f32 + 0.5, self.from[1] + z as f32 + 0.5];
                let [start, end] = ends.map(|[x, z]| [middle[0] + x, middle[1] + z].map(f64::from));
                let corner = |[x, z]: [f64; 2], y: f32| [x, f64::from(y), z];
                // As for walls, counter-clockwise as seen from within.
                let [low, high] = [0.0, HIGH[1]];
                portals.push(Portal {
                    corners: vec![
                        corner(start, low),
                        corner(end, low),
                        corner(end, high),
                        corner(start, high),
                    ],
                    cells: [room as u32, number as u32],
                });
            }
        }
        portals
    }

    /// Builds the cell tree over a part of the plan.
    fn part(&self, tree: &mut CellTree, [x, z]: [Range<usize>; 2]) -> CellSide {
        let here = |[x, z]: [usize; 2]| self.at([x as i32, z as i32]);
        let first = here([x.start, z.start]);
        let mut all = z.clone().flat_map(|z| x.clone().map(move |x| [x, z]));
        if all.all(|square| here(square) == first) {
            let Some(open) = first else {
                return CellSide::Solid;
            };
            let high = HIGH[usize::from(self.open[open].is_doorway)];
            return add(
                tree,
                Vec3::Y,
                high,
                CellSide::Solid,
                CellSide::Cell(CellId(open as u32)),
            );
        }
        // Split where a room or doorway ends, near the middle.
        let is_end = |axis: usize, at: usize| {
            let before = |k: usize| {
                if axis == 0 {
                    [[at - 1, k], [at, k]]
                } else {
                    [[k, at - 1], [k, at]]
                }
            };
            let across = if axis == 0 { z.clone() } else { x.clone() };
            across.into_iter().any(|k| {
                let [a, b] = before(k).map(here);
                a != b
            })
        };
        let sides = [x.clone(), z.clone()];
        let ends = [0, 1].into_iter().flat_map(|axis| {
            let side = sides[axis].clone();
            let middle = side.start + side.end;
            (side.start + 1..side.end)
                .filter(move |&at| is_end(axis, at))
                .map(move |at| ((2 * at).abs_diff(middle), axis, at))
                .collect::<Vec<_>>()
        });
        let (_, axis, at) = ends.min().expect("it is not all one");
        let [mut low, mut high] = [[x.clone(), z.clone()], [x, z]];
        low[axis].end = at;
        high[axis].start = at;
        let [back, front] = [self.part(tree, low), self.part(tree, high)];
        let normal = [Vec3::X, Vec3::Z][axis];
        add(tree, normal, self.from[axis] + at as f32, front, back)
    }
}

/// Adds a plane to the tree, and returns the new node as a side.
fn add(tree: &mut CellTree, normal: Vec3, distance: f32, front: CellSide, back: CellSide) -> CellSide {
    tree.nodes.push(CellNode {
        normal: normal.to_array().map(f64::from),
        distance: f64::from(distance),
        front,
        back,
    });
    CellSide::Node(tree.nodes.len() as u32 - 1)
}
