//! Buildings drawn as plans.

use enfilade_bake::{DoorKind, FoundRooms, RoomId, RoomItem, RoomMesh, RoomOptions, RoomsInput, find_rooms};
use std::collections::{BTreeMap, BTreeSet};

/// Side of a cell, height of the rooms and of doors, in metres.
const CELL: f32 = 0.5;
const HEIGHT: f32 = 3.0;
const DOOR: f32 = 2.0;

/// A storey: `#` wall, `.` floor, `|` the leaf of a door in a wall, `!` one that leaves a gap of 3 cm in a wall along z, `=` a pane from floor to ceiling, `o` a box that is
/// too small to part rooms, letters are floor.
pub(crate) struct Plan {
    cells: Vec<Vec<char>>,
    /// Boxes: lower and upper corner.
    boxes: Vec<(&'static str, Vec<[f32; 3]>)>,
    pub(crate) leaves_are_movable: bool,
}

impl Plan {
    pub(crate) fn new(plan: &str) -> Plan {
        let cells: Vec<Vec<char>> = plan.split_whitespace().map(|row| row.chars().collect()).collect();
        let mut boxes = Vec::new();
        let place = |x: usize, z: usize| [x as f32 * CELL, z as f32 * CELL];
        let is_wall = |x: usize, z: usize| cells.get(z).and_then(|row| row.get(x)) == Some(&'#');
        for (z, row) in cells.iter().enumerate() {
            for (x, &cell) in row.iter().enumerate() {
                let [left, near] = place(x, z);
                let [right, far] = place(x + 1, z + 1);
                // A leaf or pane is thin, in the middle of its cell, along the wall.
                let along_z = z > 0 && (is_wall(x, z - 1) || is_wall(x, z + 1));
                let thin = |low: f32, high: f32| {
                    if along_z {
                        let middle = 0.5 * (left + right);
                        corners([middle - 0.02, low, near], [middle + 0.02, high, far])
                    } else {
                        let middle = 0.5 * (near + far);
                        corners([left, low, middle - 0.02], [right, high, middle + 0.02])
                    }
                };
                match cell {
                    '#' => boxes.push(("wall", corners([left, 0.0, near], [right, HEIGHT, far]))),
                    '|' => {
                        boxes.push(("leaf", thin(0.0, DOOR)));
                        boxes.push(("lintel", corners([left, DOOR, near], [right, HEIGHT, far])));
                    }
                    '!' => {
                        let middle = 0.5 * (left + right);
                        boxes.push((
                            "leaf",
                            corners([middle - 0.02, 0.0, near + 0.03], [middle + 0.02, DOOR, far]),
                        ));
                        boxes.push(("lintel", corners([left, DOOR, near], [right, HEIGHT, far])));
                    }
                    '=' => boxes.push(("pane", thin(0.0, HEIGHT))),
                    'o' => boxes.push(("box", corners([left, 0.0, near], [right, 0.5, far]))),
                    _ => {}
                }
            }
        }
        // The slabs end at the walls.
        let walls: Vec<[usize; 2]> = (0..cells.len())
            .flat_map(|z| (0..cells[z].len()).map(move |x| [x, z]))
            .filter(|&[x, z]| is_wall(x, z))
            .collect();
        let reach = |axis: usize| {
            let places = || walls.iter().map(|place| place[axis]);
            [
                places().min().expect("a wall"),
                places().max().expect("a wall") + 1,
            ]
        };
        let [[x0, x1], [z0, z1]] = [reach(0), reach(1)];
        let [low, high] = [place(x0, z0), place(x1, z1)];
        for (name, bottom, top) in [("floor", -0.2, 0.0), ("ceiling", HEIGHT, HEIGHT + 0.2)] {
            boxes.push((name, corners([low[0], bottom, low[1]], [high[0], top, high[1]])));
        }
        Plan {
            cells,
            boxes,
            leaves_are_movable: true,
        }
    }

    pub(crate) fn input(&self) -> RoomsInput<'_> {
        let mesh = |(name, positions): &'_ (&'static str, Vec<[f32; 3]>)| {
            let triangles = faces();
            let (opaque, see_through) = if *name == "pane" {
                (Vec::new(), triangles)
            } else {
                (triangles, Vec::new())
            };
            (opaque, see_through, positions.len())
        };
        RoomsInput {
            meshes: self
                .boxes
                .iter()
                .map(|entry| {
                    let (opaque, see_through, _) = mesh(entry);
                    RoomMesh {
                        positions: &entry.1,
                        opaque,
                        see_through,
                    }
                })
                .collect(),
            items: self
                .boxes
                .iter()
                .enumerate()
                .map(|(number, &(name, _))| RoomItem {
                    name,
                    mesh: number,
                    world_from_item: [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0], [0.0; 3]],
                    movable: self.leaves_are_movable && name == "leaf",
                })
                .collect(),
        }
    }

    pub(crate) fn find(&self) -> FoundRooms {
        find_rooms(&self.input(), &RoomOptions::default()).expect("rooms")
    }

    /// Returns the middle of each letter's cell, a metre above the floor.
    pub(crate) fn letters(&self) -> Vec<(char, [f64; 3])> {
        let mut letters = Vec::new();
        for (z, row) in self.cells.iter().enumerate() {
            for (x, &cell) in row
                .iter()
                .enumerate()
                .filter(|(_, cell)| cell.is_ascii_uppercase())
            {
                let middle = |place: usize| (place as f64 + 0.5) * f64::from(CELL);
                letters.push((cell, [middle(x), 1.0, middle(z)]));
            }
        }
        letters
    }

    /// Returns the place of a letter.
    pub(crate) fn at(&self, letter: char) -> [f64; 3] {
        let letters = self.letters();
        letters
            .iter()
            .find(|(other, _)| *other == letter)
            .expect("a letter")
            .1
    }

    /// Asserts that the same letters are in the same room, different ones in different rooms, and that there are no other
    /// rooms than those listed.
    #[track_caller]
    pub(crate) fn has_rooms(&self, expected: &str) -> &Plan {
        let found = self.find();
        let mut rooms: BTreeMap<char, BTreeSet<RoomId>> = BTreeMap::new();
        for (letter, at) in self.letters() {
            rooms
                .entry(letter)
                .or_default()
                .insert(found.graph.room_at(at).expect("a room"));
        }
        let all: Vec<RoomId> = rooms.values().flatten().copied().collect();
        let distinct: BTreeSet<RoomId> = all.iter().copied().collect();
        assert_eq!(all.len(), distinct.len(), "{rooms:?}");
        assert!(rooms.values().all(|rooms| rooms.len() == 1), "{rooms:?}");
        let indoors = found.graph.rooms().len() - usize::from(found.graph.outside().is_some());
        assert_eq!(
            indoors,
            expected.split_whitespace().count(),
            "{:?}",
            found.graph.rooms()
        );
        self
    }

    /// Asserts that these doors, windows and openings exist, and no others; gaps do not count.
    #[track_caller]
    pub(crate) fn has_doors(&self, expected: &[(DoorKind, char, char)]) {
        let found = self.find();
        let room = |letter: char| found.graph.room_at(self.at(letter)).expect("a room");
        let mut expected: Vec<(DoorKind, [RoomId; 2])> = expected
            .iter()
            .map(|&(kind, one, other)| {
                let [one, other] = [room(one), room(other)];
                (kind, [one.min(other), one.max(other)])
            })
            .collect();
        expected.sort();
        let doors = found
            .graph
            .doors()
            .iter()
            .filter(|door| door.kind != DoorKind::Gap);
        let mut doors: Vec<(DoorKind, [RoomId; 2])> = doors.map(|door| (door.kind, door.rooms)).collect();
        doors.sort();
        assert_eq!(doors, expected);
    }
}

fn corners(low: [f32; 3], high: [f32; 3]) -> Vec<[f32; 3]> {
    (0..8)
        .map(|bits| {
            [0, 1, 2].map(|axis| {
                if bits >> axis & 1 == 0 {
                    low[axis]
                } else {
                    high[axis]
                }
            })
        })
        .collect()
}

/// Returns the triangles of a box.
fn faces() -> Vec<[u32; 3]> {
    let quads = [
        [0, 1, 3, 2],
        [4, 6, 7, 5],
        [0, 4, 5, 1],
        [2, 3, 7, 6],
        [0, 2, 6, 4],
        [1, 5, 7, 3],
    ];
    quads
        .iter()
        .flat_map(|&[a, b, c, d]| [[a, b, c], [a, c, d]])
        .collect()
}
