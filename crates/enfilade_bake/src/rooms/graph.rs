//! The graph of rooms and doors that a game queries.
//!
//! Cost: a point O(log runs); paths and sound O(doors log doors); relevance O(chains of doors that a line can pass).

use super::input::Metric;
use super::labels::LabelGrid;
use super::sight;
use std::cmp::Reverse;
use std::collections::{BTreeMap, BinaryHeap};

/// A room of a [`RoomGraph`], by index.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct RoomId(pub u32);

/// A door, window or opening of a [`RoomGraph`], by index.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct DoorId(pub u32);

/// A room.
#[derive(Clone, Debug, PartialEq)]
pub struct Room {
    /// Name: that of the sector if the scene has several, else the storey and a number.
    pub name: String,
    /// Volume of its free space, in cubic metres.
    pub volume: f64,
    /// Floor area: volume over height, in square metres.
    pub area: f64,
    /// Index of its storey, counted from the lowest.
    pub storey: u32,
    /// Lower and upper corner of its free space, in scene coordinates.
    pub bounds: [[f64; 3]; 2],
    /// Items in it or at its border, by index in the input.
    pub items: Vec<u32>,
}

/// What is between two rooms.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub enum DoorKind {
    /// A door or gate with a leaf: can be opened and closed.
    Door,
    /// Glass: seen through, but not passed.
    Window,
    /// Nothing: always open.
    Opening,
    /// A hole that is too small to pass: light and sound pass.
    Gap,
}

/// A door, a window or an opening between two rooms.
#[derive(Clone, Debug, PartialEq)]
pub struct Door {
    /// The rooms on its two sides, the lower index first.
    pub rooms: [RoomId; 2],
    /// What is in it.
    pub kind: DoorKind,
    /// The leaf, by item index in the input. A gap has one if it is around a closed door.
    pub leaf: Option<u32>,
    /// Area without opaque parts other than the leaf, in square metres.
    pub area: f64,
    /// A rectangle in it, in scene coordinates.
    pub polygon: [[f64; 3]; 4],
    /// Boxes that every line of sight through it passes one of.
    pub(super) sights: Vec<Sight>,
}

/// A part of a door whose faces point the same way.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Sight {
    /// Lower and upper corner, in scene coordinates.
    pub(super) bounds: [[f64; 3]; 2],
    /// Axis of the faces, in scene coordinates.
    pub(super) axis: u8,
    /// Whether a line from the first room to the second goes up the axis.
    pub(super) goes_up: bool,
}

impl Door {
    /// Returns the middle of its rectangle.
    pub fn middle(&self) -> [f64; 3] {
        [0, 1, 2].map(|axis| self.polygon.iter().map(|corner| corner[axis]).sum::<f64>() / 4.0)
    }

    /// Returns the room on the other side; `None` if `room` is on neither.
    pub fn across(&self, room: RoomId) -> Option<RoomId> {
        match self.rooms {
            [one, other] if one == room => Some(other),
            [one, other] if other == room => Some(one),
            _ => None,
        }
    }
}

/// Rooms, doors and windows of a building, and which doors are open.
///
/// Closed doors block paths and sight, and damp sound. At first every door with a leaf is closed.
///
/// ```
/// use enfilade_bake::{RoomItem, RoomMesh, RoomOptions, RoomsInput, find_rooms};
///
/// // Two rooms, 4 m wide, with a doorway in the wall between them; floor and ceiling are left out.
/// let wall = |from: [f32; 2], to: [f32; 2], low: f32| {
///     [[from[0], low, from[1]], [to[0], low, to[1]], [to[0], 3.0, to[1]], [from[0], 3.0, from[1]]]
/// };
/// let walls = [
///     wall([0.0, 0.0], [8.0, 0.0], 0.0),
///     wall([8.0, 0.0], [8.0, 4.0], 0.0),
///     wall([8.0, 4.0], [0.0, 4.0], 0.0),
///     wall([0.0, 4.0], [0.0, 0.0], 0.0),
///     wall([4.0, 0.0], [4.0, 1.5], 0.0),
///     wall([4.0, 2.5], [4.0, 4.0], 0.0),
///     wall([4.0, 1.5], [4.0, 2.5], 2.0),
/// ];
/// let mut positions: Vec<[f32; 3]> = walls.concat();
/// // Floor and ceiling.
/// for height in [0.0, 3.0] {
///     positions.extend([[0.0, height, 0.0], [8.0, height, 0.0], [8.0, height, 4.0], [0.0, height, 4.0]]);
/// }
/// let quads = 0..positions.len() as u32 / 4;
/// let mesh = RoomMesh {
///     positions: &positions,
///     opaque: quads.flat_map(|quad| [[4 * quad, 4 * quad + 1, 4 * quad + 2], [4 * quad, 4 * quad + 2, 4 * quad + 3]]).collect(),
///     see_through: Vec::new(),
/// };
/// let house = RoomItem {
///     name: "house",
///     mesh: 0,
///     world_from_item: [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0], [0.0; 3]],
///     movable: false,
/// };
/// let input = RoomsInput { meshes: vec![mesh], items: vec![house] };
/// let found = find_rooms(&input, &RoomOptions::default())?;
/// let rooms = found.graph;
/// let [left, right] = [[1.0, 1.0, 1.0], [7.0, 1.0, 1.0]].map(|point| rooms.room_at(point));
/// assert_ne!(left, right);
/// let path = rooms.path([1.0, 1.0, 1.0], [7.0, 1.0, 1.0]).expect("there is a doorway");
/// assert!(path.doors.len() == 1 && path.length > 6.0);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Clone, Debug, PartialEq)]
pub struct RoomGraph {
    pub(super) rooms: Vec<Room>,
    pub(super) doors: Vec<Door>,
    pub(super) outside: Option<RoomId>,
    /// The height of the floor of each storey along the up axis, in metres.
    pub(super) storeys: Vec<f64>,
    pub(super) metric: Metric,
    pub(super) labels: LabelGrid,
    /// Doors of each room.
    pub(super) doors_of: Vec<Vec<DoorId>>,
    /// Whether light passes.
    pub(super) is_open: Vec<bool>,
}

/// A way from one point to another.
#[derive(Clone, Debug, PartialEq)]
pub struct RoomPath {
    /// Length in metres, by the middles of doors, plus what doors add.
    pub length: f64,
    /// Doors on the way.
    pub doors: Vec<DoorId>,
}

/// How doors and windows damp sound: metres that each adds to the length of a path.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SoundLoss {
    /// A closed door. Default 15.
    pub door: f64,
    /// A window. Default 20.
    pub window: f64,
    /// A gap. Default 10.
    pub gap: f64,
}

impl Default for SoundLoss {
    fn default() -> SoundLoss {
        SoundLoss {
            door: 15.0,
            window: 20.0,
            gap: 10.0,
        }
    }
}

impl RoomGraph {
    pub(super) fn new(
        rooms: Vec<Room>,
        doors: Vec<Door>,
        outside: Option<RoomId>,
        storeys: Vec<f64>,
        metric: Metric,
        labels: LabelGrid,
    ) -> RoomGraph {
        let mut doors_of = vec![Vec::new(); rooms.len()];
        for (number, door) in doors.iter().enumerate() {
            for room in door.rooms {
                doors_of[room.0 as usize].push(DoorId(number as u32));
            }
        }
        RoomGraph {
            is_open: doors
                .iter()
                .map(|door| door.kind != DoorKind::Door && door.leaf.is_none())
                .collect(),
            rooms,
            doors,
            outside,
            storeys,
            metric,
            labels,
            doors_of,
        }
    }

    /// Returns the rooms, by [`RoomId`].
    pub fn rooms(&self) -> &[Room] {
        &self.rooms
    }

    /// Returns the doors, windows and openings, by [`DoorId`].
    pub fn doors(&self) -> &[Door] {
        &self.doors
    }

    /// Returns the room that is not enclosed; `None` if there is none.
    pub fn outside(&self) -> Option<RoomId> {
        self.outside
    }

    /// Returns the height of the floor of each storey along the up axis, in scene units.
    pub fn storeys(&self) -> impl Iterator<Item = f64> {
        self.storeys
            .iter()
            .map(|floor| floor / self.metric.metres_per_unit)
    }

    /// Returns the room at a point in scene coordinates. Inside walls it is the nearest room, elsewhere outside the
    /// building [`RoomGraph::outside`]; `None` for NaN or if there is no such room.
    pub fn room_at(&self, point: [f64; 3]) -> Option<RoomId> {
        let metres = self.metric.metres(point);
        if metres.iter().any(|value| value.is_nan()) {
            return None;
        }
        match self.labels.grid.cell_at(metres) {
            Some(_) => self.labels.room_at(metres).map(RoomId),
            None => self.outside,
        }
    }

    /// Returns the doors of a room, and the room behind each.
    ///
    /// # Panics
    /// If there is no such room.
    pub fn neighbours(&self, room: RoomId) -> impl Iterator<Item = (DoorId, RoomId)> {
        self.doors_of[room.0 as usize]
            .iter()
            .filter_map(move |&door| Some((door, self.doors[door.0 as usize].across(room)?)))
    }

    /// Returns `true` if a body can pass: an opening, or an open door.
    ///
    /// # Panics
    /// If there is no such door.
    pub fn is_open(&self, door: DoorId) -> bool {
        match self.doors[door.0 as usize].kind {
            DoorKind::Door => self.is_open[door.0 as usize],
            DoorKind::Opening => true,
            DoorKind::Window | DoorKind::Gap => false,
        }
    }

    /// Returns `true` if light passes: all but closed doors, and gaps around them.
    ///
    /// # Panics
    /// If there is no such door.
    pub fn shows(&self, door: DoorId) -> bool {
        self.is_open[door.0 as usize]
    }

    /// Opens or closes the leaf of a door, and so all doors and gaps with that leaf. Others stay as they are.
    ///
    /// # Panics
    /// If there is no such door.
    pub fn set_open(&mut self, door: DoorId, open: bool) {
        let Door { kind, leaf, .. } = self.doors[door.0 as usize];
        if kind == DoorKind::Door {
            self.is_open[door.0 as usize] = open;
        }
        if leaf.is_some() {
            for (door, is_open) in self.doors.iter().zip(&mut self.is_open) {
                if door.leaf == leaf {
                    *is_open = open;
                }
            }
        }
    }

    /// Returns the doors whose leaf is an item of the input.
    pub fn doors_with_leaf(&self, item: u32) -> impl Iterator<Item = DoorId> {
        let doors = self.doors.iter().zip(0..);
        doors.filter_map(move |(door, number)| (door.leaf == Some(item)).then_some(DoorId(number)))
    }

    /// Returns the shortest way between two points through open doors and openings. `None` if there is none, or a point
    /// is in no room.
    pub fn path(&self, from: [f64; 3], to: [f64; 3]) -> Option<RoomPath> {
        self.path_by(from, to, |door| self.is_open(door).then_some(0.0))
    }

    /// As [`RoomGraph::path`], with a rule of the caller: metres that a door adds to the length, or `None` if it cannot
    /// be passed. Negative numbers and NaN count as 0.
    pub fn path_by(
        &self,
        from: [f64; 3],
        to: [f64; 3],
        cost: impl Fn(DoorId) -> Option<f64>,
    ) -> Option<RoomPath> {
        let [start, end] = [self.room_at(from)?, self.room_at(to)?];
        let reached = self.reach(from, start, cost);
        let direct = (start == end).then(|| (self.distance(from, to), None));
        let through = self.doors_of[end.0 as usize].iter().filter_map(|&door| {
            let DoorReach { length, .. } = reached.get(&(door, end))?;
            Some((
                length + self.distance(self.doors[door.0 as usize].middle(), to),
                Some(door),
            ))
        });
        let (length, last) = direct
            .into_iter()
            .chain(through)
            .min_by(|a, b| a.0.total_cmp(&b.0))?;
        let mut doors = Vec::new();
        let mut next = last.map(|door| (door, end));
        while let Some(place) = next {
            doors.push(place.0);
            next = reached.get(&place).and_then(|reached| reached.before);
        }
        doors.reverse();
        Some(RoomPath { length, doors })
    }

    /// Returns how far a sound at `source` seems from `listener`: the length of the shortest way through doors, in
    /// metres, plus what closed doors and windows add. `None` if there is no way, or a point is in no room.
    pub fn heard_from(&self, listener: [f64; 3], source: [f64; 3], loss: &SoundLoss) -> Option<f64> {
        let path = self.path_by(source, listener, |door| Some(self.loss(door, loss)))?;
        Some(path.length)
    }

    /// Returns the rooms in which a sound at `source` seems at most `reach` metres away at the nearest door, nearest
    /// first; the room of the source is at 0.
    pub fn audible(&self, source: [f64; 3], reach: f64, loss: &SoundLoss) -> Vec<(RoomId, f64)> {
        let Some(start) = self.room_at(source) else {
            return Vec::new();
        };
        let mut nearest = BTreeMap::from([(start, 0.0)]);
        for (&(_, room), reached) in &self.reach(source, start, |door| Some(self.loss(door, loss))) {
            if reached.length <= reach {
                let least = nearest.entry(room).or_insert(reached.length);
                *least = least.min(reached.length);
            }
        }
        let mut rooms: Vec<(RoomId, f64)> = nearest.into_iter().collect();
        rooms.sort_by(|a, b| a.1.total_cmp(&b.1).then(a.0.cmp(&b.0)));
        rooms
    }

    fn loss(&self, door: DoorId, loss: &SoundLoss) -> f64 {
        match self.doors[door.0 as usize].kind {
            DoorKind::Window => loss.window,
            _ if !self.shows(door) => loss.door,
            DoorKind::Gap => loss.gap,
            DoorKind::Door | DoorKind::Opening => 0.0,
        }
    }

    /// Returns the rooms that may be seen from a room through open doors, openings, windows and gaps, itself included, in
    /// order. Conservative: a room of which a point sees a point of `room` is not left out.
    ///
    /// Takes milliseconds in a house with gaps in its walls, and a tenth of a second in an office of 167 rooms: call it when
    /// a door opens or closes, not in every frame.
    ///
    /// # Panics
    /// If there is no such room.
    #[doc(alias = "network relevance")]
    pub fn relevant(&self, room: RoomId) -> Vec<RoomId> {
        self.relevant_by(room, |door| self.shows(door))
    }

    /// As [`RoomGraph::relevant`], with a rule of the caller for what light passes. A game may ignore gaps, for example:
    /// cracks show little, but through many rooms.
    ///
    /// # Panics
    /// If there is no such room.
    pub fn relevant_by(&self, room: RoomId, shows: impl Fn(DoorId) -> bool) -> Vec<RoomId> {
        sight::relevant(self, room, shows)
    }

    /// Returns the length in metres between two points.
    fn distance(&self, from: [f64; 3], to: [f64; 3]) -> f64 {
        let squares = (0..3).map(|axis| (from[axis] - to[axis]).powi(2));
        squares.sum::<f64>().sqrt() * self.metric.metres_per_unit
    }

    /// Returns the length of the shortest way from a point through each door, by the room that it is passed into.
    fn reach(
        &self,
        from: [f64; 3],
        start: RoomId,
        cost: impl Fn(DoorId) -> Option<f64>,
    ) -> BTreeMap<(DoorId, RoomId), DoorReach> {
        let mut reached: BTreeMap<(DoorId, RoomId), DoorReach> = BTreeMap::new();
        // Lengths are not negative, so their bits sort as they do.
        let mut queue = BinaryHeap::new();
        let leave = |room: RoomId, at: [f64; 3], length: f64, before, queue: &mut BinaryHeap<_>| {
            for (door, beyond) in self.neighbours(room) {
                if let Some(cost) = cost(door) {
                    let to = self.doors[door.0 as usize].middle();
                    let length = length + self.distance(at, to) + cost.max(0.0);
                    queue.push(Reverse((length.to_bits(), (door, beyond), before)));
                }
            }
        };
        leave(start, from, 0.0, None, &mut queue);
        while let Some(Reverse((bits, place, before))) = queue.pop() {
            if reached.contains_key(&place) {
                continue;
            }
            let length = f64::from_bits(bits);
            reached.insert(place, DoorReach { length, before });
            let (door, room) = place;
            leave(
                room,
                self.doors[door.0 as usize].middle(),
                length,
                Some(place),
                &mut queue,
            );
        }
        reached
    }

    /// Returns the memory in bytes.
    pub fn bytes(&self) -> u64 {
        let items: usize = self
            .rooms
            .iter()
            .map(|room| room.name.len() + size_of_val(&*room.items))
            .sum();
        let doors_of: usize = self
            .doors_of
            .iter()
            .map(|doors| size_of_val(doors) + size_of_val(&**doors))
            .sum();
        let arrays = size_of_val(&*self.rooms) + size_of_val(&*self.doors) + self.is_open.len();
        (items + doors_of + arrays + self.labels.bytes()) as u64
    }
}

/// The shortest way through a door.
struct DoorReach {
    length: f64,
    /// The door before, and the room between the two.
    before: Option<(DoorId, RoomId)>,
}

/// Follows one thing that moves, and reports when it changes rooms.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct RoomTracker {
    room: Option<RoomId>,
}

/// A change of rooms.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct RoomChange {
    /// The room that was left; `None` if it was in none.
    pub left: Option<RoomId>,
    /// The room that was entered; `None` if it is in none now.
    pub entered: Option<RoomId>,
}

impl RoomTracker {
    /// Returns the room it was in last.
    pub fn room(&self) -> Option<RoomId> {
        self.room
    }

    /// Records a position, and returns the change of rooms, if any.
    pub fn moved(&mut self, rooms: &RoomGraph, to: [f64; 3]) -> Option<RoomChange> {
        let entered = rooms.room_at(to);
        let left = std::mem::replace(&mut self.room, entered);
        (left != entered).then_some(RoomChange { left, entered })
    }
}
