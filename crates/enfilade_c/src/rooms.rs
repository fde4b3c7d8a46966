//! Rooms and doors of a building, found in its triangles: for AI, sound, network relevance.

use crate::handle::{self, Handle};
use crate::ids::{EnfiladeDoorId, EnfiladeItemId, EnfiladeRoomId, IdSpace};
use crate::lent::Caller;
use crate::scene::EnfiladeScene;
use crate::status::{EnfiladeError, EnfiladeStatus, Failure, border, characters, check_finite, refuse};
use crate::threads;
use crate::version::check_version;
use enfilade_bake::{
    AuthoredRooms, DoorId, DoorKind, RoomGraph, RoomId, RoomOptions, SoundLoss, Up, detect_metres_per_unit,
    detect_up, find_rooms_among, is_door_name,
};
use enfilade_import::{SceneRoomItems, authored_doors};
use std::ffi::c_char;

/// Rooms of a building, and the doors, windows, openings and gaps between them. Looks use sectors instead; enfilade_scene_locate finds
/// the sector of the eye in microseconds. Queries may run on several threads at once; enfilade_rooms_set_open must be alone.
pub struct EnfiladeRooms {
    _opaque: (),
}

impl Handle for EnfiladeRooms {
    type Object = RoomsState;
    const NAME: &'static str = "graph of rooms";
}

pub(crate) struct RoomsState {
    graph: RoomGraph,
    rooms: IdSpace,
    doors: IdSpace,
    /// The ids of the items that leaves are numbered by; empty for a graph that was read.
    leaves: Vec<EnfiladeItemId>,
}

/// The vertical axis.
#[repr(u32)]
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum EnfiladeUp {
    /// Found out from the floors.
    Detect = 0,
    /// +x.
    X = 1,
    /// +y.
    Y = 2,
    /// +z.
    Z = 3,
}

/// How rooms are found. All zero is a good default.
#[repr(C)]
#[derive(Clone, Copy, Debug)]
pub struct EnfiladeRoomOptions {
    /// Metres per scene unit; 0: guessed from the height of rooms.
    pub metres_per_unit: f64,
    /// Side of a voxel in metres; 0 for 0.1.
    pub voxel: f64,
    /// Most voxels, of which one takes about 5 bytes; 0 for 60 million. Voxels are larger if there would be more.
    pub max_voxels: u64,
    /// An EnfiladeUp.
    pub up: u32,
    /// 1 to ignore the sectors of the scene; else these are the rooms, if there are several.
    pub ignores_sectors: u32,
}

/// A room.
#[repr(C)]
#[derive(Clone, Copy, Debug)]
pub struct EnfiladeRoom {
    /// Its id.
    pub room: EnfiladeRoomId,
    /// Volume of its free space, in cubic metres.
    pub volume: f64,
    /// Floor area, in square metres.
    pub area: f64,
    /// Lower corner of the box around it, in scene coordinates.
    pub box_min: [f64; 3],
    /// Upper corner of that box.
    pub box_max: [f64; 3],
    /// Its storey, counted from the lowest.
    pub storey: u32,
    /// 1 for what is outside of the building, else 0.
    pub is_outside: u32,
    /// Its name, cut to fit.
    pub name: [c_char; 64],
}

/// What is between two rooms.
#[repr(u32)]
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum EnfiladeDoorKind {
    /// A door or gate that can be opened and closed.
    Door = 0,
    /// Glass: seen through, not passed.
    Window = 1,
    /// Nothing: always open.
    Opening = 2,
    /// A hole too small to pass: light and sound pass.
    Gap = 3,
}

/// A door, a window, an opening or a gap between two rooms.
#[repr(C)]
#[derive(Clone, Copy, Debug)]
pub struct EnfiladeDoor {
    /// Its id.
    pub door: EnfiladeDoorId,
    /// The rooms on its two sides.
    pub rooms: [EnfiladeRoomId; 2],
    /// The item that opens and closes; 0 if there is none, or the rooms were read.
    pub leaf: EnfiladeItemId,
    /// Area without opaque parts other than the leaf, in square metres.
    pub area: f64,
    /// A rectangle in it: 4 corners of 3 doubles, in scene coordinates.
    pub corners: [f64; 12],
    /// An EnfiladeDoorKind.
    pub kind: u32,
    /// 1 if bodies can pass, else 0.
    pub is_open: u32,
}

impl RoomsState {
    fn new(graph: RoomGraph, leaves: Vec<EnfiladeItemId>) -> RoomsState {
        RoomsState {
            graph,
            rooms: IdSpace::new("room"),
            doors: IdSpace::new("door"),
            leaves,
        }
    }

    fn room(&self, id: EnfiladeRoomId) -> Result<RoomId, Failure> {
        Ok(RoomId(self.rooms.index(id, self.graph.rooms().len())?))
    }
}

/// Finds the rooms of a scene, and the doors and windows between them; for what is found, see the book. All doors with a leaf are
/// closed at first. Takes seconds, for a palace ten or more: write the result with enfilade_rooms_write.
///
/// @param version ENFILADE_VERSION.
/// @param options Null for the defaults.
/// @param rooms Receives the rooms. Free them with enfilade_rooms_free.
///
/// Errors: ENFILADE_STATUS_BAD_SCENE if there are no triangles; ENFILADE_STATUS_BAD_ARGUMENT.
#[allow(unsafe_code, reason = "called from C")]
#[unsafe(no_mangle)]
pub unsafe extern "C" fn enfilade_rooms_find(
    version: u32,
    scene: *const EnfiladeScene,
    options: *const EnfiladeRoomOptions,
    rooms: *mut *mut EnfiladeRooms,
    error: *mut EnfiladeError,
) -> EnfiladeStatus {
    // SAFETY: the promise of the caller, as the crate's documentation says.
    let caller = unsafe { Caller::new() };
    caller.call(error, |caller| {
        let rooms = caller.out(rooms, "rooms")?;
        check_version(version)?;
        let wanted = caller.maybe(options).unwrap_or(EnfiladeRoomOptions {
            metres_per_unit: 0.0,
            voxel: 0.0,
            max_voxels: 0,
            up: 0,
            ignores_sectors: 0,
        });
        let state = handle::find(scene)?;
        let state = state.read()?;
        let scene = &state.scene;
        let is_leaf = |sector, item| {
            let geometry = scene.geometry(sector);
            geometry.is_some_and(|geometry| is_door_name(geometry.name(item)))
        };
        let items = SceneRoomItems::of(scene, is_leaf);
        let up = match wanted.up {
            0 => None,
            1 => Some(Up::X),
            2 => Some(Up::Y),
            3 => Some(Up::Z),
            _ => return Err(refuse("c/up", "up must be an EnfiladeUp")),
        };
        let found = threads::on_all(|| {
            let mut options = RoomOptions::default();
            options.up = up.unwrap_or_else(|| detect_up(&items.input));
            if wanted.metres_per_unit == 0.0 {
                let detected = detect_metres_per_unit(&items.input, options.up);
                options.metres_per_unit = detected.unwrap_or(1.0);
            } else {
                options.metres_per_unit = wanted.metres_per_unit;
            }
            if wanted.voxel != 0.0 {
                options.step = wanted.voxel;
            }
            if wanted.max_voxels != 0 {
                options.max_voxels = usize::try_from(wanted.max_voxels)
                    .unwrap_or(usize::MAX)
                    .min(options.max_voxels);
            }
            let held = scene.sectors().filter(|&sector| scene.has_sector(sector));
            let room_at = |point: [f64; 3]| {
                let sector = scene.locate(point, point)?;
                let bounds = scene.bounds(sector);
                let is_in = (0..3).all(|axis| {
                    f64::from(bounds.min[axis]) <= point[axis] && point[axis] <= f64::from(bounds.max[axis])
                });
                is_in.then_some(sector.0)
            };
            let authored = AuthoredRooms {
                names: scene.sectors().map(|sector| scene.sector_name(sector)).collect(),
                room_at: &room_at,
                doors: authored_doors(scene),
            };
            let authored = (held.count() > 1 && wanted.ignores_sectors == 0).then_some(&authored);
            find_rooms_among(&items.input, &options, authored)
        });
        let found = found.map_err(|why| Failure::new(EnfiladeStatus::BadScene, "c/rooms", why))?;
        let leaf = |&(sector, index): &(enfilade::SectorId, enfilade::ItemIndex)| {
            let geometry = scene.geometry(sector);
            geometry.map_or(0, |geometry| state.items.id_of(sector, geometry.id_of(index)))
        };
        let leaves = items.items.iter().map(leaf).collect();
        rooms.set(handle::create(RoomsState::new(found.graph, leaves))?);
        Ok(())
    })
}

/// Reads rooms that enfilade_rooms_write or the program `enfilade rooms` wrote.
///
/// @param version ENFILADE_VERSION.
/// @param json UTF-8, without a null character at the end.
/// @param rooms Receives the rooms. Free them with enfilade_rooms_free.
///
/// Errors: ENFILADE_STATUS_BAD_FILE.
#[allow(unsafe_code, reason = "called from C")]
#[unsafe(no_mangle)]
pub unsafe extern "C" fn enfilade_rooms_read(
    version: u32,
    json: *const u8,
    byte_count: usize,
    rooms: *mut *mut EnfiladeRooms,
    error: *mut EnfiladeError,
) -> EnfiladeStatus {
    // SAFETY: the promise of the caller, as the crate's documentation says.
    let caller = unsafe { Caller::new() };
    caller.call(error, |caller| {
        let rooms = caller.out(rooms, "rooms")?;
        check_version(version)?;
        let json = std::str::from_utf8(caller.slice(json, byte_count, "json")?);
        let json = json.map_err(|_| refuse("c/not-utf-8", "json is not UTF-8"))?;
        let graph = RoomGraph::from_json(json)
            .map_err(|why| Failure::new(EnfiladeStatus::BadFile, "c/rooms", why))?;
        rooms.set(handle::create(RoomsState::new(graph, Vec::new()))?);
        Ok(())
    })
}

/// Writes rooms as JSON. Which doors are open is not part of it.
///
/// @param json Receives up to @p capacity bytes; null to get their number alone.
/// @param count Receives their number.
///
/// Errors: ENFILADE_STATUS_BUFFER_TOO_SMALL.
#[allow(unsafe_code, reason = "called from C")]
#[unsafe(no_mangle)]
pub unsafe extern "C" fn enfilade_rooms_write(
    rooms: *const EnfiladeRooms,
    json: *mut u8,
    capacity: usize,
    count: *mut usize,
    error: *mut EnfiladeError,
) -> EnfiladeStatus {
    // SAFETY: the promise of the caller, as the crate's documentation says.
    let caller = unsafe { Caller::new() };
    caller.call(error, |caller| {
        let buffer = caller.buffer(json, capacity, count, "json")?;
        let rooms = handle::find(rooms)?;
        let rooms = rooms.read()?;
        buffer.fill(rooms.graph.to_json().into_bytes())
    })
}

/// Frees rooms. Null is ignored.
///
/// Errors: ENFILADE_STATUS_BAD_HANDLE if they were freed before.
#[allow(unsafe_code, reason = "called from C")]
#[unsafe(no_mangle)]
pub extern "C" fn enfilade_rooms_free(rooms: *mut EnfiladeRooms) -> EnfiladeStatus {
    border(|| handle::free(rooms))
}

/// Lists the rooms.
///
/// @param list Receives up to @p capacity rooms; null to get their number alone.
/// @param count Receives their number.
///
/// Errors: ENFILADE_STATUS_BUFFER_TOO_SMALL.
#[allow(unsafe_code, reason = "called from C")]
#[unsafe(no_mangle)]
pub unsafe extern "C" fn enfilade_rooms_list(
    rooms: *const EnfiladeRooms,
    list: *mut EnfiladeRoom,
    capacity: usize,
    count: *mut usize,
    error: *mut EnfiladeError,
) -> EnfiladeStatus {
    // SAFETY: the promise of the caller, as the crate's documentation says.
    let caller = unsafe { Caller::new() };
    caller.call(error, |caller| {
        let buffer = caller.buffer(list, capacity, count, "list")?;
        let rooms = handle::find(rooms)?;
        let rooms = rooms.read()?;
        let outside = rooms.graph.outside();
        buffer.fill(
            rooms
                .graph
                .rooms()
                .iter()
                .zip(0..)
                .map(|(room, number)| EnfiladeRoom {
                    room: rooms.rooms.id(number),
                    volume: room.volume,
                    area: room.area,
                    box_min: room.bounds[0],
                    box_max: room.bounds[1],
                    storey: room.storey,
                    is_outside: u32::from(outside == Some(RoomId(number))),
                    name: characters(&room.name),
                }),
        )
    })
}

/// Lists the doors, windows, openings and gaps of a room, or all. Rooms with furniture have thousands of gaps: look at their kind.
///
/// @param room 0 for all rooms.
/// @param list Receives up to @p capacity doors; null to get their number alone.
/// @param count Receives their number.
///
/// Errors: ENFILADE_STATUS_BUFFER_TOO_SMALL, ENFILADE_STATUS_NO_SUCH_ID.
#[allow(unsafe_code, reason = "called from C")]
#[unsafe(no_mangle)]
pub unsafe extern "C" fn enfilade_rooms_doors(
    rooms: *const EnfiladeRooms,
    room: EnfiladeRoomId,
    list: *mut EnfiladeDoor,
    capacity: usize,
    count: *mut usize,
    error: *mut EnfiladeError,
) -> EnfiladeStatus {
    // SAFETY: the promise of the caller, as the crate's documentation says.
    let caller = unsafe { Caller::new() };
    caller.call(error, |caller| {
        let buffer = caller.buffer(list, capacity, count, "list")?;
        let rooms = handle::find(rooms)?;
        let rooms = rooms.read()?;
        let room = match room {
            0 => None,
            id => Some(rooms.room(id)?),
        };
        let doors = rooms.graph.doors().iter().zip(0..);
        let doors = doors.filter(|(door, _)| room.is_none_or(|room| door.rooms.contains(&room)));
        buffer.fill(doors.map(|(door, number)| {
            EnfiladeDoor {
                door: rooms.doors.id(number),
                rooms: door.rooms.map(|room| rooms.rooms.id(room.0)),
                leaf: door
                    .leaf
                    .and_then(|leaf| rooms.leaves.get(leaf as usize).copied())
                    .unwrap_or(0),
                area: door.area,
                corners: std::array::from_fn(|number| door.polygon[number / 3][number % 3]),
                kind: match door.kind {
                    DoorKind::Door => EnfiladeDoorKind::Door,
                    DoorKind::Window => EnfiladeDoorKind::Window,
                    DoorKind::Opening => EnfiladeDoorKind::Opening,
                    DoorKind::Gap => EnfiladeDoorKind::Gap,
                } as u32,
                is_open: u32::from(rooms.graph.is_open(DoorId(number))),
            }
        }))
    })
}

/// Finds the room at a point.
///
/// @param point 3 doubles, in scene coordinates.
/// @param room Receives the id; 0 if there is none.
///
/// Errors: ENFILADE_STATUS_BAD_ARGUMENT.
#[allow(unsafe_code, reason = "called from C")]
#[unsafe(no_mangle)]
pub unsafe extern "C" fn enfilade_rooms_at(
    rooms: *const EnfiladeRooms,
    point: *const f64,
    room: *mut EnfiladeRoomId,
    error: *mut EnfiladeError,
) -> EnfiladeStatus {
    // SAFETY: the promise of the caller, as the crate's documentation says.
    let caller = unsafe { Caller::new() };
    caller.call(error, |caller| {
        let room = caller.out(room, "room")?;
        let rooms = handle::find(rooms)?;
        let rooms = rooms.read()?;
        let point = point_of(caller, point, "point")?;
        let found = rooms.graph.room_at(point);
        room.set(found.map_or(0, |found| rooms.rooms.id(found.0)));
        Ok(())
    })
}

fn point_of(caller: &Caller, point: *const f64, name: &str) -> Result<[f64; 3], Failure> {
    let point = caller.numbers::<f64, 3>(point, name)?;
    check_finite(name, &point)?;
    Ok(point)
}

/// Opens or closes a door, and all doors and gaps with the same leaf. Windows, openings and gaps without a leaf stay as they are.
///
/// @param is_open 0 to close it.
///
/// Errors: ENFILADE_STATUS_NO_SUCH_ID.
#[allow(unsafe_code, reason = "called from C")]
#[unsafe(no_mangle)]
pub unsafe extern "C" fn enfilade_rooms_set_open(
    rooms: *mut EnfiladeRooms,
    door: EnfiladeDoorId,
    is_open: u32,
    error: *mut EnfiladeError,
) -> EnfiladeStatus {
    // SAFETY: the promise of the caller, as the crate's documentation says.
    let caller = unsafe { Caller::new() };
    caller.call(error, |_| {
        let rooms = handle::find(rooms)?;
        let mut rooms = rooms.write()?;
        let door = rooms.doors.index(door, rooms.graph.doors().len())?;
        rooms.graph.set_open(DoorId(door), is_open != 0);
        Ok(())
    })
}

/// Finds the shortest way between two points through open doors.
///
/// @param from 3 doubles.
/// @param to 3 doubles.
/// @param length Null, or receives the length in metres; negative if there is no way.
/// @param doors Receives up to @p capacity doors on the way; null to get their number alone.
/// @param count Receives their number.
///
/// Errors: ENFILADE_STATUS_BUFFER_TOO_SMALL, ENFILADE_STATUS_BAD_ARGUMENT.
#[allow(unsafe_code, reason = "called from C")]
#[unsafe(no_mangle)]
pub unsafe extern "C" fn enfilade_rooms_path(
    rooms: *const EnfiladeRooms,
    from: *const f64,
    to: *const f64,
    length: *mut f64,
    doors: *mut EnfiladeDoorId,
    capacity: usize,
    count: *mut usize,
    error: *mut EnfiladeError,
) -> EnfiladeStatus {
    // SAFETY: the promise of the caller, as the crate's documentation says.
    let caller = unsafe { Caller::new() };
    caller.call(error, |caller| {
        let length = caller.maybe_out(length);
        let buffer = caller.buffer(doors, capacity, count, "doors")?;
        let rooms = handle::find(rooms)?;
        let rooms = rooms.read()?;
        let path = rooms
            .graph
            .path(point_of(caller, from, "from")?, point_of(caller, to, "to")?);
        if let Some(length) = length {
            length.set(path.as_ref().map_or(-1.0, |path| path.length));
        }
        let doors = path.map_or_else(Vec::new, |path| path.doors);
        buffer.fill(doors.into_iter().map(|door| rooms.doors.id(door.0)))
    })
}

/// Returns how far a sound seems: the length of the way through doors, and 15 m for a closed door, 20 m for a window, 10 m for a
/// gap.
///
/// @param listener 3 doubles.
/// @param source 3 doubles.
/// @param distance Receives metres; negative if there is no way.
///
/// Errors: ENFILADE_STATUS_BAD_ARGUMENT.
#[allow(unsafe_code, reason = "called from C")]
#[unsafe(no_mangle)]
pub unsafe extern "C" fn enfilade_rooms_heard(
    rooms: *const EnfiladeRooms,
    listener: *const f64,
    source: *const f64,
    distance: *mut f64,
    error: *mut EnfiladeError,
) -> EnfiladeStatus {
    // SAFETY: the promise of the caller, as the crate's documentation says.
    let caller = unsafe { Caller::new() };
    caller.call(error, |caller| {
        let distance = caller.out(distance, "distance")?;
        let rooms = handle::find(rooms)?;
        let rooms = rooms.read()?;
        let listener = point_of(caller, listener, "listener")?;
        let source = point_of(caller, source, "source")?;
        let heard = rooms.graph.heard_from(listener, source, &SoundLoss::default());
        distance.set(heard.unwrap_or(-1.0));
        Ok(())
    })
}

/// Lists the rooms that may be seen from a room through open doors, windows, openings and gaps, itself included: an upper bound.
/// Takes milliseconds: call it when a door opens, not in each frame.
///
/// @param list Receives up to @p capacity rooms; null to get their number alone.
/// @param count Receives their number.
///
/// Errors: ENFILADE_STATUS_BUFFER_TOO_SMALL, ENFILADE_STATUS_NO_SUCH_ID.
#[allow(unsafe_code, reason = "called from C")]
#[unsafe(no_mangle)]
pub unsafe extern "C" fn enfilade_rooms_relevant(
    rooms: *const EnfiladeRooms,
    room: EnfiladeRoomId,
    list: *mut EnfiladeRoomId,
    capacity: usize,
    count: *mut usize,
    error: *mut EnfiladeError,
) -> EnfiladeStatus {
    // SAFETY: the promise of the caller, as the crate's documentation says.
    let caller = unsafe { Caller::new() };
    caller.call(error, |caller| {
        let buffer = caller.buffer(list, capacity, count, "list")?;
        let rooms = handle::find(rooms)?;
        let rooms = rooms.read()?;
        let relevant = rooms.graph.relevant(rooms.room(room)?);
        buffer.fill(relevant.into_iter().map(|room| rooms.rooms.id(room.0)))
    })
}
