//! Floor plans as SVG: rooms in colours, walls, doors and windows, cut at chest height.

use super::Rooms;
use super::outline::outlines;
use crate::html::escaped;
use crate::text::short;
use enfilade_bake::{Door, DoorKind, FoundRooms, RoomId};
use std::collections::{BTreeMap, BTreeSet, VecDeque};
use std::fmt::Write;

/// Height above the floor at which a storey is cut, in metres, and up to which a better one is looked for.
const CUT: f64 = 1.2;
const HIGHEST_CUT: f64 = 3.2;

/// Pixels per metre, and the margin around a plan in metres.
const SCALE: f64 = 22.0;
const MARGIN: f64 = 0.5;

/// The plan of one storey.
pub(super) struct Plan {
    pub(super) svg: String,
    /// Rooms that it shows.
    pub(super) rooms: BTreeSet<u32>,
}

/// A horizontal cut through the voxels.
struct Cut<'a> {
    found: &'a FoundRooms,
    slice: usize,
    /// First column and row that is drawn, and their numbers.
    first: [usize; 2],
    size: [usize; 2],
}

impl Cut<'_> {
    fn voxel(&self, x: usize, z: usize) -> usize {
        self.found
            .voxels
            .index([self.first[0] + x, self.slice, self.first[1] + z])
    }

    /// Returns the room of a free cell; `None` for walls and the exterior.
    fn room(&self, x: usize, z: usize) -> Option<u32> {
        let room = self.found.voxels.free_room(self.voxel(x, z))?;
        (self.found.graph.outside() != Some(RoomId(room))).then_some(room)
    }

    /// Returns `true` for solid cells and gaps inside walls, but not for panes and doors.
    fn is_wall(&self, x: usize, z: usize) -> bool {
        let voxel = self.voxel(x, z);
        let voxels = &self.found.voxels;
        voxels.free_room(voxel).is_none() && (voxels.is_opaque(voxel) || !voxels.is_separating(voxel))
    }

    /// Returns a point in metres, y up, in pixels.
    fn pixels(&self, [x, _, z]: [f64; 3]) -> [f64; 2] {
        let voxels = &self.found.voxels;
        let at = |value: f64, axis: usize, first: usize| {
            ((value - voxels.origin()[axis]) / voxels.step() - first as f64) * self.cell() + MARGIN * SCALE
        };
        [at(x, 0, self.first[0]), at(z, 2, self.first[1])]
    }

    /// Returns the side of a cell in pixels.
    fn cell(&self) -> f64 {
        self.found.voxels.step() * SCALE
    }

    fn path(&self, has_label: impl Fn(usize, usize) -> bool) -> String {
        let mut path = String::new();
        for outline in outlines(self.size, has_label) {
            for (number, [x, z]) in outline.into_iter().enumerate() {
                let letter = if number == 0 { 'M' } else { 'L' };
                let [x, z] = [x, z].map(|value| value * self.cell() + MARGIN * SCALE);
                // Writing to a String cannot fail.
                let _ = write!(path, "{letter}{x:.1} {z:.1}");
            }
            path.push('Z');
        }
        path
    }
}

/// Returns the plan of a storey; `None` if no room is cut.
pub(super) fn plan(rooms: &Rooms, storey: usize) -> Option<Plan> {
    let found = rooms.found;
    let voxels = &found.voxels;
    let floor = found.graph.storeys().nth(storey)? * rooms.report.metres_per_unit;
    let height = cut_height(found, floor);
    let slice = ((height - voxels.origin()[1]) / voxels.step()).floor().max(0.0) as usize;
    let [columns, slices, depth] = voxels.size();
    let whole = Cut {
        found,
        slice: slice.min(slices - 1),
        first: [0, 0],
        size: [columns, depth],
    };
    let (cut, cells) = cropped(&whole)?;
    let mut svg = String::new();
    let [width, down] = cut
        .size
        .map(|count| count as f64 * cut.cell() + 2.0 * MARGIN * SCALE);
    let _ = writeln!(
        svg,
        "<svg xmlns=\"http://www.w3.org/2000/svg\" viewBox=\"0 0 {width:.0} {down:.0}\" width=\"{width:.0}\" height=\"{down:.0}\" \
         font-family=\"system-ui, 'Segoe UI', 'Liberation Sans', sans-serif\" text-anchor=\"middle\">"
    );
    for &room in cells.keys() {
        let entry = &rooms.report.rooms[room as usize];
        let _ = writeln!(
            svg,
            "<path d=\"{}\" fill=\"{}\" fill-rule=\"evenodd\"><title>{}: {} m², {} m high</title></path>",
            cut.path(|x, z| cut.room(x, z) == Some(room)),
            color(room),
            escaped(&entry.name),
            short(entry.area_m2),
            short(entry.height_m),
        );
    }
    let _ = writeln!(
        svg,
        "<path d=\"{}\" fill=\"#3a4150\" fill-rule=\"evenodd\"/>",
        cut.path(|x, z| cut.is_wall(x, z))
    );
    for door in found.graph.doors() {
        draw_door(&mut svg, rooms, &cut, door, height);
    }
    for (&room, cells) in &cells {
        label(&mut svg, rooms, &cut, room, cells);
    }
    draw_scale(&mut svg, down);
    svg += "</svg>\n";
    Some(Plan {
        svg,
        rooms: cells.into_keys().collect(),
    })
}

/// Returns the height at which a storey is cut: at chest height, or where it cuts clearly more doors, because the slab
/// below them is missing.
fn cut_height(found: &FoundRooms, floor: f64) -> f64 {
    let doors = found
        .graph
        .doors()
        .iter()
        .filter(|door| door.kind == DoorKind::Door);
    let reaches: Vec<[f64; 2]> = doors.map(|door| heights(found, door)).collect();
    let cuts = |height: f64| {
        reaches
            .iter()
            .filter(|[low, high]| *low < height && height < *high)
            .count()
    };
    let usual = floor + CUT;
    let candidates = (0..)
        .map(|step| usual + 0.1 * f64::from(step))
        .take_while(|height| *height < floor + HIGHEST_CUT);
    let best = candidates.max_by_key(|&height| (cuts(height), std::cmp::Reverse((100.0 * height) as i64)));
    best.filter(|&height| 2 * cuts(height) > 3 * cuts(usual))
        .unwrap_or(usual)
}

/// Returns the lowest and the highest point of a door, in metres.
fn heights(found: &FoundRooms, door: &Door) -> [f64; 2] {
    let heights = || door.polygon.iter().map(|&corner| found.voxels.metres(corner)[1]);
    [
        heights().fold(f64::INFINITY, f64::min),
        heights().fold(f64::NEG_INFINITY, f64::max),
    ]
}

/// The cells of each room.
type CellsOfRooms = BTreeMap<u32, Vec<[usize; 2]>>;

/// Restricts a cut to its rooms and a little around them; returns the cells of each room.
fn cropped<'a>(whole: &Cut<'a>) -> Option<(Cut<'a>, CellsOfRooms)> {
    let [columns, rows] = whole.size;
    let [mut low, mut high] = [[usize::MAX; 2], [0; 2]];
    for z in 0..rows {
        for x in 0..columns {
            if whole.room(x, z).is_some() {
                low = [low[0].min(x), low[1].min(z)];
                high = [high[0].max(x + 1), high[1].max(z + 1)];
            }
        }
    }
    if low[0] > high[0] {
        return None;
    }
    let around = (0.6 / whole.found.voxels.step()).ceil() as usize;
    let first = low.map(|low| low.saturating_sub(around));
    let cut = Cut {
        found: whole.found,
        slice: whole.slice,
        first,
        size: [
            (high[0] + around).min(columns) - first[0],
            (high[1] + around).min(rows) - first[1],
        ],
    };
    let mut cells = CellsOfRooms::new();
    for z in 0..cut.size[1] {
        for x in 0..cut.size[0] {
            if let Some(room) = cut.room(x, z) {
                cells.entry(room).or_default().push([x, z]);
            }
        }
    }
    Some((cut, cells))
}

/// Returns a light colour; successive rooms differ.
fn color(room: u32) -> String {
    let hue = f64::from(room) * 137.508 % 360.0;
    format!("hsl({hue:.0} 62% {}%)", 80 + room % 3 * 4)
}

fn draw_door(svg: &mut String, rooms: &Rooms, cut: &Cut, door: &Door, height: f64) {
    let metres = door.polygon.map(|corner| cut.found.voxels.metres(corner));
    let [low, high] = heights(cut.found, door);
    // A window may begin above the cut, and is drawn nevertheless.
    let reach = if door.kind == DoorKind::Window { 1.0 } else { 0.0 };
    if height < low - reach || height > high + reach || high - low < 0.2 {
        return;
    }
    let [from, to] = [cut.pixels(metres[0]), cut.pixels(metres[1])];
    let ([x0, y0], [x1, y1]) = (from, to);
    let is_inside = |[x, y]: [f64; 2]| {
        let end = cut
            .size
            .map(|count| count as f64 * cut.cell() + 2.0 * MARGIN * SCALE);
        0.0 <= x && x <= end[0] && 0.0 <= y && y <= end[1]
    };
    if !is_inside(from) || !is_inside(to) {
        return;
    }
    let names = door
        .rooms
        .map(|room| escaped(&rooms.report.rooms[room.0 as usize].name));
    let leaf = door.leaf.map_or("", |item| rooms.names[item as usize]);
    let (kind, style) = match door.kind {
        DoorKind::Gap => return,
        DoorKind::Door => (
            "door",
            "stroke=\"#b4541a\" stroke-width=\"4\" stroke-linecap=\"round\"",
        ),
        DoorKind::Window => ("window", "stroke=\"#2f8fd6\" stroke-width=\"3.5\""),
        DoorKind::Opening => (
            "opening",
            "stroke=\"#5b6270\" stroke-width=\"1.5\" stroke-dasharray=\"4 3\"",
        ),
    };
    let _ = writeln!(
        svg,
        "<line x1=\"{x0:.1}\" y1=\"{y0:.1}\" x2=\"{x1:.1}\" y2=\"{y1:.1}\" {style}><title>{kind} between {} and {}, {} m² \
         {}</title></line>",
        names[0],
        names[1],
        short(door.area),
        escaped(leaf),
    );
}

/// Writes the name and area of a room where it is widest.
fn label(svg: &mut String, rooms: &Rooms, cut: &Cut, room: u32, cells: &[[usize; 2]]) {
    /// Width of a letter, as a share of the size of the font, and the smallest size.
    const LETTER: f64 = 0.6;
    const SMALLEST: f64 = 6.5;
    let Some(([x, z], reach)) = widest(cut, room, cells) else {
        return;
    };
    let half_width = reach as f64 * cut.cell();
    if half_width < 7.0 {
        return;
    }
    let entry = &rooms.report.rooms[room as usize];
    // The mark of rooms in glTF files says nothing here.
    let name = entry.name.strip_suffix("-room").unwrap_or(&entry.name);
    let fits = 2.2 * half_width / (LETTER * name.chars().count().max(1) as f64);
    let size = (half_width * 0.8).clamp(8.0, 15.0).min(fits);
    if size < SMALLEST {
        return;
    }
    let [x, y] = [x, z].map(|value| (value as f64 + 0.5) * cut.cell() + MARGIN * SCALE);
    let _ = writeln!(
        svg,
        "<text x=\"{x:.1}\" y=\"{y:.1}\" font-size=\"{size:.0}\" font-weight=\"600\" fill=\"#20252e\">{}</text>",
        escaped(name)
    );
    if half_width > 16.0 {
        let _ = writeln!(
            svg,
            "<text x=\"{x:.1}\" y=\"{:.1}\" font-size=\"{:.0}\" fill=\"#4a5260\">{} m²</text>",
            y + 1.15 * size,
            0.82 * size,
            short(entry.area_m2.round())
        );
    }
}

/// Returns the cell of a room that is farthest from others, and its distance in cells.
fn widest(cut: &Cut, room: u32, cells: &[[usize; 2]]) -> Option<([usize; 2], usize)> {
    let neighbours = |[x, z]: [usize; 2]| {
        [
            [x.wrapping_sub(1), z],
            [x + 1, z],
            [x, z.wrapping_sub(1)],
            [x, z + 1],
        ]
    };
    let is_of_room = |[x, z]: [usize; 2]| x < cut.size[0] && z < cut.size[1] && cut.room(x, z) == Some(room);
    let mut distances: BTreeMap<[usize; 2], usize> = BTreeMap::new();
    let mut queue = VecDeque::new();
    for &cell in cells {
        if !neighbours(cell).into_iter().all(is_of_room) {
            distances.insert(cell, 1);
            queue.push_back(cell);
        }
    }
    let mut last = None;
    while let Some(cell) = queue.pop_front() {
        let distance = distances[&cell];
        last = Some((cell, distance));
        for next in neighbours(cell) {
            if is_of_room(next) && !distances.contains_key(&next) {
                distances.insert(next, distance + 1);
                queue.push_back(next);
            }
        }
    }
    last
}

/// Draws a bar of a metre or five.
fn draw_scale(svg: &mut String, down: f64) {
    let y = down - 4.0;
    let _ = writeln!(
        svg,
        "<path d=\"M6 {0:.1}v4h{SCALE:.0}v-4\" fill=\"none\" stroke=\"#68707d\"/><text x=\"{1:.0}\" y=\"{y:.1}\" \
         font-size=\"10\" fill=\"#68707d\" text-anchor=\"start\">1 m</text>",
        y - 4.0,
        SCALE + 10.0
    );
}
