//! Rooms as JSON: written by `enfilade rooms`, read by games.

use super::NONE;
use super::graph::{Door, DoorKind, Room, RoomGraph, RoomId, Sight};
use super::grid::Grid;
use super::input::{Metric, Up};
use super::labels::LabelGrid;
use serde::de::Error as _;
use serde::{Deserialize, Deserializer, Serialize, Serializer};
use serde_json::value::RawValue;
use thiserror::Error;

/// Why JSON is no [`RoomGraph`].
#[derive(Debug, Error)]
#[non_exhaustive]
pub enum RoomFileError {
    /// It is not JSON, or a value is missing or of the wrong type.
    #[error(transparent)]
    Json(#[from] serde_json::Error),
    /// It is of another format or version.
    #[error("it is format {format:?}, version {version}; expected {FORMAT:?}, version {VERSION}")]
    OtherFormat {
        /// Value of `format`.
        format: String,
        /// Value of `version`.
        version: u32,
    },
    /// A value contradicts another.
    #[error("{place}: {rule}")]
    Inconsistent {
        /// Where the value is.
        place: String,
        /// What it must be.
        rule: &'static str,
    },
}

const FORMAT: &str = "enfilade-rooms";
const VERSION: u32 = 1;

/// Maximum number of rows of voxels: a small file must not need much memory.
const MAX_ROWS: usize = 1 << 26;

#[derive(Serialize, Deserialize)]
struct File {
    format: String,
    version: u32,
    up: UpName,
    metres_per_unit: Number,
    /// Height of the floor of each storey along the up axis, in metres.
    storeys: Vec<Number>,
    outside: Option<u32>,
    rooms: Vec<RoomEntry>,
    doors: Vec<DoorEntry>,
    labels: Labels,
}

#[derive(Clone, Copy, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
enum UpName {
    X,
    Y,
    Z,
}

#[derive(Clone, Copy, Serialize, Deserialize)]
struct BoundsEntry {
    min: [Number; 3],
    max: [Number; 3],
}

#[derive(Serialize, Deserialize)]
struct RoomEntry {
    name: String,
    volume_m3: Number,
    area_m2: Number,
    storey: u32,
    bounds: BoundsEntry,
    items: Vec<u32>,
}

#[derive(Serialize, Deserialize)]
struct DoorEntry {
    rooms: [u32; 2],
    kind: KindName,
    leaf: Option<u32>,
    area_m2: Number,
    polygon: [[Number; 3]; 4],
    sights: Vec<SightEntry>,
}

/// A box that lines of sight through a door pass.
#[derive(Clone, Copy, Serialize, Deserialize)]
struct SightEntry {
    min: [Number; 3],
    max: [Number; 3],
    /// Axis of its faces, 0 to 2; with a minus, −3 to −1, if lines from the first room to the second go down the axis.
    way: i8,
}

#[derive(Clone, Copy, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
enum KindName {
    Door,
    Window,
    Opening,
    Gap,
}

/// A number that is read to the last bit; `serde_json` alone may be off by one.
#[derive(Clone, Copy)]
struct Number(f64);

impl Serialize for Number {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        serializer.serialize_f64(self.0)
    }
}

impl<'de> Deserialize<'de> for Number {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Number, D::Error> {
        let text = <&RawValue>::deserialize(deserializer)?.get();
        let number = text.parse().ok().filter(|number: &f64| number.is_finite());
        let number =
            number.ok_or_else(|| D::Error::custom(format_args!("expected a number, not {text:.20}")))?;
        Ok(Number(number))
    }
}

/// The room of each voxel.
#[derive(Serialize, Deserialize)]
struct Labels {
    size: [usize; 3],
    origin: [Number; 3],
    step: Number,
    /// Runs of voxels along x: end (exclusive) and room (−1 for none), in turn.
    patterns: Vec<Vec<i64>>,
    /// Rows along x, by z, then by y: how many have the same pattern, and its index, in turn.
    rows: Vec<u32>,
}

impl RoomGraph {
    /// Returns the graph as JSON. Which doors are open is not part of it.
    pub fn to_json(&self) -> String {
        let numbers = |point: [f64; 3]| point.map(Number);
        let bounds = |[min, max]: [[f64; 3]; 2]| BoundsEntry {
            min: numbers(min),
            max: numbers(max),
        };
        let room = |room: &Room| RoomEntry {
            name: room.name.clone(),
            volume_m3: Number(room.volume),
            area_m2: Number(room.area),
            storey: room.storey,
            bounds: bounds(room.bounds),
            items: room.items.clone(),
        };
        let door = |door: &Door| DoorEntry {
            rooms: door.rooms.map(|room| room.0),
            kind: match door.kind {
                DoorKind::Door => KindName::Door,
                DoorKind::Window => KindName::Window,
                DoorKind::Opening => KindName::Opening,
                DoorKind::Gap => KindName::Gap,
            },
            leaf: door.leaf,
            area_m2: Number(door.area),
            polygon: door.polygon.map(numbers),
            sights: door.sights.iter().map(sight_entry).collect(),
        };
        let file = File {
            format: FORMAT.to_owned(),
            version: VERSION,
            up: match self.metric.up {
                Up::X => UpName::X,
                Up::Y => UpName::Y,
                Up::Z => UpName::Z,
            },
            metres_per_unit: Number(self.metric.metres_per_unit),
            storeys: self.storeys.iter().copied().map(Number).collect(),
            outside: self.outside.map(|room| room.0),
            rooms: self.rooms.iter().map(room).collect(),
            doors: self.doors.iter().map(door).collect(),
            labels: labels_entry(&self.labels),
        };
        serde_json::to_string(&file).unwrap_or_default()
    }

    /// Reads a graph from JSON; all doors with a leaf are closed. Unknown keys are ignored.
    ///
    /// # Errors
    /// Returns a [`RoomFileError`] if it is not what [`RoomGraph::to_json`] writes.
    pub fn from_json(json: &str) -> Result<RoomGraph, RoomFileError> {
        #[derive(Deserialize)]
        struct Head {
            format: String,
            version: u32,
        }
        let Head { format, version } = serde_json::from_str(json)?;
        if format != FORMAT || version != VERSION {
            return Err(RoomFileError::OtherFormat { format, version });
        }
        let file: File = serde_json::from_str(json)?;
        let wrong = |place: &str, rule| {
            Err(RoomFileError::Inconsistent {
                place: place.to_owned(),
                rule,
            })
        };
        let count = file.rooms.len() as u32;
        if file.metres_per_unit.0 <= 0.0 {
            return wrong("metres_per_unit", "must be a number above zero");
        }
        if file.outside.is_some_and(|room| room >= count) {
            return wrong("outside", "must be the index of a room");
        }
        for (number, room) in file.rooms.iter().enumerate() {
            if room.storey as usize >= file.storeys.len().max(1) {
                return wrong(
                    &format!("rooms[{number}].storey"),
                    "must be the index of a storey",
                );
            }
        }
        for (number, door) in file.doors.iter().enumerate() {
            let [one, other] = door.rooms;
            if one >= other || other >= count {
                return wrong(
                    &format!("doors[{number}].rooms"),
                    "must be the indices of two rooms, the lower first",
                );
            }
            if door.sights.iter().any(|sight| !(-3..3).contains(&sight.way)) {
                return wrong(&format!("doors[{number}].sights"), "way must be from -3 to 2");
            }
        }
        let labels = read_labels(&file.labels, count)?;
        let point = |point: [Number; 3]| point.map(|number| number.0);
        let bounds = |BoundsEntry { min, max }| [point(min), point(max)];
        let room = |room: RoomEntry| Room {
            name: room.name,
            volume: room.volume_m3.0,
            area: room.area_m2.0,
            storey: room.storey,
            bounds: bounds(room.bounds),
            items: room.items,
        };
        let door = |door: DoorEntry| Door {
            rooms: door.rooms.map(RoomId),
            kind: match door.kind {
                KindName::Door => DoorKind::Door,
                KindName::Window => DoorKind::Window,
                KindName::Opening => DoorKind::Opening,
                KindName::Gap => DoorKind::Gap,
            },
            leaf: door.leaf,
            area: door.area_m2.0,
            polygon: door.polygon.map(point),
            sights: door.sights.iter().map(read_sight).collect(),
        };
        let metric = Metric {
            up: match file.up {
                UpName::X => Up::X,
                UpName::Y => Up::Y,
                UpName::Z => Up::Z,
            },
            metres_per_unit: file.metres_per_unit.0,
        };
        Ok(RoomGraph::new(
            file.rooms.into_iter().map(room).collect(),
            file.doors.into_iter().map(door).collect(),
            file.outside.map(RoomId),
            file.storeys.iter().map(|number| number.0).collect(),
            metric,
            labels,
        ))
    }
}

fn sight_entry(sight: &Sight) -> SightEntry {
    let [min, max] = sight.bounds;
    let axis = sight.axis as i8;
    SightEntry {
        min: min.map(Number),
        max: max.map(Number),
        way: if sight.goes_up { axis } else { -1 - axis },
    }
}

fn read_sight(&SightEntry { min, max, way }: &SightEntry) -> Sight {
    let (axis, goes_up) = if way < 0 { (-1 - way, false) } else { (way, true) };
    Sight {
        bounds: [min, max].map(|point| point.map(|number| number.0)),
        axis: axis as u8,
        goes_up,
    }
}

fn labels_entry(labels: &LabelGrid) -> Labels {
    let LabelGrid {
        grid,
        rows,
        firsts,
        runs,
    } = labels;
    let room_number = |room: u32| if room == NONE { -1 } else { i64::from(room) };
    let pattern = |ends: &[u32]| {
        let runs = &runs[ends[0] as usize..ends[1] as usize];
        runs.iter()
            .flat_map(|&[end, room]| [i64::from(end), room_number(room)])
            .collect()
    };
    let same = rows.chunk_by(|a, b| a == b);
    Labels {
        size: grid.size,
        origin: grid.origin.map(Number),
        step: Number(grid.step),
        patterns: firsts.windows(2).map(pattern).collect(),
        rows: same.flat_map(|same| [same.len() as u32, same[0]]).collect(),
    }
}

fn read_labels(file: &Labels, rooms: u32) -> Result<LabelGrid, RoomFileError> {
    let wrong = |place: &str, rule| {
        Err(RoomFileError::Inconsistent {
            place: place.to_owned(),
            rule,
        })
    };
    let [columns, slices, depth] = file.size;
    let Some(row_count) = slices.checked_mul(depth).filter(|&rows| rows <= MAX_ROWS) else {
        return wrong("labels.size", "must have at most 2^26 rows along x");
    };
    if file.step.0 <= 0.0 {
        return wrong("labels.step", "must be a number above zero");
    }
    let mut labels = LabelGrid {
        grid: Grid {
            size: file.size,
            origin: file.origin.map(|number| number.0),
            step: file.step.0,
        },
        rows: Vec::new(),
        firsts: vec![0],
        runs: Vec::new(),
    };
    for (number, pattern) in file.patterns.iter().enumerate() {
        let (runs, left) = pattern.as_chunks::<2>();
        let mut last = 0;
        for &[end, room] in runs {
            if end <= last || end > columns as i64 || room < -1 || room >= i64::from(rooms) {
                return wrong(
                    &format!("labels.patterns[{number}]"),
                    "must be increasing ends up to the width, each with the index of a room or -1",
                );
            }
            last = end;
            labels
                .runs
                .push([end as u32, u32::try_from(room).unwrap_or(NONE)]);
        }
        if !left.is_empty() || last != columns as i64 {
            return wrong(
                &format!("labels.patterns[{number}]"),
                "must be pairs that end at the width",
            );
        }
        labels.firsts.push(labels.runs.len() as u32);
    }
    let (pairs, left) = file.rows.as_chunks::<2>();
    let total: u64 = pairs.iter().map(|&[count, _]| u64::from(count)).sum();
    let is_known = |&[_, pattern]: &[u32; 2]| (pattern as usize) < file.patterns.len();
    if !left.is_empty() || total != row_count as u64 || !pairs.iter().all(is_known) {
        return wrong(
            "labels.rows",
            "must be pairs of a count and the index of a pattern, as many rows in all as the size says",
        );
    }
    for &[count, pattern] in pairs {
        labels.rows.extend(std::iter::repeat_n(pattern, count as usize));
    }
    Ok(labels)
}
