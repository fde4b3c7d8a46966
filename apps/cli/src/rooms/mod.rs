//! `rooms`: finds the rooms, doors and windows of a building, and draws its floor plans.

mod outline;
mod page;
mod plan;

use crate::Outcome;
use crate::args::{PortalArgs, RoomsArgs};
use crate::json::{Sink, rounded};
use crate::leak::{LeakEntry, leak_of};
use crate::open::{OpenedScene, Purpose, allow_threads, open};
use crate::out;
use crate::progress::Progress;
use crate::run_files::RunFiles;
use crate::text::{plural, point, short, table};
use crate::values::Choice;
use anyhow::{Context, Result, anyhow};
use enfilade::{Aabb, Scene, SectorId};
use enfilade_bake::{
    AuthoredRooms, Door, DoorKind, FoundRooms, RoomId, RoomOptions, Up, detect_metres_per_unit, detect_up,
    find_rooms_among, is_door_name,
};
use enfilade_import::{SceneRoomItems, authored_doors};
use serde::Serialize;
use std::path::Path;
use std::time::Instant;

/// Memory for a voxel, with that of what is found in it.
const BYTES_PER_VOXEL: u64 = 10;

/// The report.
#[derive(Debug, Serialize)]
struct RoomsReport {
    file: String,
    up: &'static str,
    metres_per_unit: f64,
    /// Side of a voxel, in metres.
    voxel_m: f64,
    voxels: usize,
    storeys: usize,
    rooms: Vec<RoomRow>,
    doors: usize,
    windows: usize,
    openings: usize,
    suggestions: Vec<Suggestion>,
    /// Holes between rooms that nobody can pass, largest first.
    leaks: Vec<Leak>,
    seconds: f64,
    warnings: Vec<String>,
}

/// A room in the report.
#[derive(Debug, Serialize)]
struct RoomRow {
    name: String,
    storey: u32,
    outside: bool,
    area_m2: f64,
    height_m: f64,
    volume_m3: f64,
    doors: usize,
    windows: usize,
    openings: usize,
    items: usize,
}

/// An item that may be a door.
#[derive(Debug, Serialize)]
struct Suggestion {
    item: String,
    rooms: [String; 2],
    middle: [f64; 3],
}

/// A hole between two rooms.
#[derive(Debug, Serialize)]
struct Leak {
    rooms: [String; 2],
    /// Area over length.
    width_cm: f64,
    length_cm: f64,
    middle: [f64; 3],
}

/// Everything that the outputs show.
struct Rooms<'a> {
    report: RoomsReport,
    found: &'a FoundRooms,
    /// Name of each item of the input.
    names: Vec<&'a str>,
}

/// Runs `rooms`.
pub(crate) fn run(args: &RoomsArgs) -> Result<Outcome> {
    let mut files = RunFiles::of(&args.scene.scene, None)?;
    let output = args
        .output
        .as_deref()
        .map(|path| files.writes(path))
        .transpose()?;
    let html = args.html.as_deref().map(|path| files.writes(path)).transpose()?;
    let sink = Sink::new(&args.json, &mut files)?;
    allow_threads(&args.limits)?;
    let mut opened = open(
        &args.scene.scene,
        Purpose::Visibility,
        Choice::All,
        &PortalArgs {
            file: args.read.clone(),
            ..PortalArgs::default()
        },
        &args.limits,
        &mut files,
    )?;
    warn_of_leak(&mut opened, args);
    let progress = Progress::spinner("finding rooms");
    let start = Instant::now();
    let name = |sector, item| {
        opened
            .scene
            .geometry(sector)
            .map_or("", |geometry| geometry.name(item))
    };
    let can_move = |sector: SectorId, item| {
        let nodes = opened.nodes.get(sector.0 as usize);
        nodes.is_some_and(|nodes| nodes.is_movable(item))
    };
    let items = SceneRoomItems::of(&opened.scene, |sector, item| {
        can_move(sector, item) || is_door(args, name(sector, item))
    });
    let mut options = RoomOptions::default();
    options.up = up(args, &opened, &items);
    options.metres_per_unit = metres_per_unit(args, &opened, &items, options.up);
    options.step = args.voxel;
    options.max_voxels = options
        .max_voxels
        .min((args.limits.memory() / BYTES_PER_VOXEL) as usize);
    let scene = &opened.scene;
    let room_at = |point: [f64; 3]| sector_at(scene, point).map(|sector| sector.0);
    let authored = AuthoredRooms {
        names: scene.sectors().map(|sector| scene.sector_name(sector)).collect(),
        room_at: &room_at,
        doors: authored_doors(scene),
    };
    let authored = (scene.sector_count() > 1 && !args.flat).then_some(&authored);
    let found = find_rooms_among(&items.input, &options, authored)
        .map_err(|why| anyhow!("{}: {why}", opened.file))?;
    let seconds = start.elapsed().as_secs_f64();
    drop(progress);
    let names: Vec<&str> = items.input.items.iter().map(|item| item.name).collect();
    let rooms = Rooms {
        report: report(&opened, &options, &found, &names, seconds),
        found: &found,
        names,
    };
    if let Some(output) = &output {
        output.write(rooms.graph_json()?.as_bytes())?;
    }
    if let Some(html) = &html {
        html.write(page::page(&rooms).as_bytes())?;
    }
    if !args.json.takes_stdout() {
        out::print(&rooms.for_people(args))?;
    }
    sink.write(&rooms.report)?;
    Ok(Outcome::Done)
}

/// Warns of a leak in a map without a PVS: its rooms may join the void.
fn warn_of_leak(opened: &mut OpenedScene, args: &RoomsArgs) {
    if opened.map.as_ref().is_none_or(|map| map.visibility_bytes > 0) {
        return;
    }
    if let Some(leak) = leak_of(Path::new(&args.scene.scene), args.limits.memory()) {
        let warning = LeakEntry::from(leak).for_people(&opened.file);
        out::warn(format_args!("{}: {warning}", opened.file));
        opened.warnings.push(warning);
    }
}

/// Returns `true` if an item is a door by its name.
fn is_door(args: &RoomsArgs, name: &str) -> bool {
    if args.no_names {
        false
    } else if args.doors.is_empty() {
        is_door_name(name)
    } else {
        let name = name.to_lowercase();
        args.doors
            .iter()
            .any(|word| !word.is_empty() && name.contains(&word.to_lowercase()))
    }
}

/// Returns the sector whose box contains a point.
fn sector_at(scene: &Scene, point: [f64; 3]) -> Option<SectorId> {
    let [x, y, z] = point;
    let sector = scene.locate([x, y, z], [x, y, z + 1.0])?;
    let Aabb { min, max } = scene.bounds(sector);
    let is_inside = (0..3).all(|axis| {
        let is_below = point[axis] <= f64::from(max[axis]) || (axis == 1 && scene.is_open_above(sector));
        f64::from(min[axis]) <= point[axis] && is_below
    });
    is_inside.then_some(sector)
}

/// Returns the metres in a scene unit.
fn metres_per_unit(args: &RoomsArgs, opened: &OpenedScene, items: &SceneRoomItems, up: Up) -> f64 {
    /// A unit of Quake is an inch, more or less.
    const QUAKE: f64 = 0.0254;
    match args.scale {
        Some(scale) => scale,
        None if opened.map.is_some() => QUAKE,
        None => detect_metres_per_unit(&items.input, up).unwrap_or(1.0),
    }
}

fn up(args: &RoomsArgs, opened: &OpenedScene, items: &SceneRoomItems) -> Up {
    match args.up {
        Some(up) => up.into(),
        // All other formats have y up, once read.
        None if opened.format == "OBJ" => detect_up(&items.input),
        None => Up::Y,
    }
}

fn report(
    opened: &OpenedScene,
    options: &RoomOptions,
    found: &FoundRooms,
    names: &[&str],
    seconds: f64,
) -> RoomsReport {
    let graph = &found.graph;
    let count = |kind: DoorKind| graph.doors().iter().filter(|door| door.kind == kind).count();
    let axis = match options.up {
        Up::X => 0,
        Up::Y => 1,
        Up::Z => 2,
    };
    let row = |(number, room): (u32, &enfilade_bake::Room)| {
        let of = |kind: DoorKind| {
            let doors = graph.neighbours(RoomId(number));
            doors
                .filter(|&(door, _)| graph.doors()[door.0 as usize].kind == kind)
                .count()
        };
        let [low, high] = room.bounds;
        RoomRow {
            name: room.name.clone(),
            storey: room.storey,
            outside: graph.outside() == Some(RoomId(number)),
            area_m2: rounded(room.area),
            height_m: rounded((high[axis] - low[axis]) * options.metres_per_unit),
            volume_m3: rounded(room.volume),
            doors: of(DoorKind::Door),
            windows: of(DoorKind::Window),
            openings: of(DoorKind::Opening),
            items: room.items.len(),
        }
    };
    let room_name = |room: RoomId| graph.rooms()[room.0 as usize].name.clone();
    let step = found.voxels.step();
    let mut warnings = opened.warnings.clone();
    if step > 1.5 * options.step {
        let coarse = format!(
            "the scene is large, so voxels are {} m wide: smaller rooms and doors are missed",
            short(step)
        );
        out::warn(format_args!("{}: {coarse}", opened.file));
        warnings.push(coarse);
    }
    RoomsReport {
        file: opened.file.clone(),
        up: ["x", "y", "z"][axis],
        metres_per_unit: options.metres_per_unit,
        voxel_m: rounded(step),
        voxels: found.voxels.size().iter().product(),
        storeys: graph.storeys().count(),
        rooms: (0..).zip(graph.rooms()).map(row).collect(),
        doors: count(DoorKind::Door),
        windows: count(DoorKind::Window),
        openings: count(DoorKind::Opening),
        suggestions: found
            .suggestions
            .iter()
            .map(|door| Suggestion {
                item: names[door.item as usize].to_owned(),
                rooms: door.rooms.map(room_name),
                middle: door.middle.map(rounded),
            })
            .collect(),
        leaks: leaks(found),
        seconds: rounded(seconds),
        warnings,
    }
}

fn leaks(found: &FoundRooms) -> Vec<Leak> {
    let graph = &found.graph;
    let mut gaps: Vec<&Door> = graph
        .doors()
        .iter()
        .filter(|door| door.kind == DoorKind::Gap)
        .collect();
    gaps.sort_by(|a, b| b.area.total_cmp(&a.area));
    let leak = |door: &&Door| {
        let corners = door.polygon.map(|corner| found.voxels.metres(corner));
        let side = |to: usize| {
            let squares = (0..3).map(|axis| (corners[to][axis] - corners[0][axis]).powi(2));
            squares.sum::<f64>().sqrt()
        };
        let length = side(1).max(side(3));
        Leak {
            rooms: door.rooms.map(|room| graph.rooms()[room.0 as usize].name.clone()),
            width_cm: rounded(100.0 * door.area / length),
            length_cm: rounded(100.0 * length),
            middle: door.middle().map(rounded),
        }
    };
    gaps.iter().map(leak).collect()
}

impl Rooms<'_> {
    /// Returns the graph as JSON, with the names of items.
    fn graph_json(&self) -> Result<String> {
        #[derive(Serialize)]
        struct GraphAdditions<'a> {
            file: &'a str,
            item_names: &'a [&'a str],
            suggestions: &'a [Suggestion],
        }
        let added = GraphAdditions {
            file: &self.report.file,
            item_names: &self.names,
            suggestions: &self.report.suggestions,
        };
        // Both are objects; as text, because reading the numbers of the graph could change their last bits.
        let graph = self.found.graph.to_json();
        let graph = graph.strip_suffix('}').context("cannot encode the graph")?;
        let added = serde_json::to_string(&added).context("cannot encode the names of items")?;
        Ok(format!("{graph},{}\n", &added[1..]))
    }

    fn for_people(&self, args: &RoomsArgs) -> String {
        /// Rows of tables before the rest is only counted.
        const MAX_ROWS: usize = 40;
        let report = &self.report;
        let indoors: Vec<&RoomRow> = report.rooms.iter().filter(|room| !room.outside).collect();
        let mut text = format!(
            "{}: {} on {}, {}, {}, {}; {} s\n",
            report.file,
            plural(indoors.len(), "room"),
            plural(report.storeys, "storey"),
            plural(report.doors, "door"),
            plural(report.windows, "window"),
            plural(report.openings, "opening"),
            short(report.seconds),
        );
        if report.metres_per_unit != 1.0 && args.scale.is_none() {
            text += &format!(
                "  a unit is taken as {} m; --scale sets it\n",
                short(report.metres_per_unit)
            );
        }
        let mut sorted = indoors.clone();
        sorted.sort_by(|a, b| a.storey.cmp(&b.storey).then(b.area_m2.total_cmp(&a.area_m2)));
        let rows: Vec<Vec<String>> = sorted
            .iter()
            .take(MAX_ROWS)
            .map(|room| {
                vec![
                    room.name.clone(),
                    short(room.area_m2),
                    short(room.height_m),
                    room.doors.to_string(),
                    room.windows.to_string(),
                    room.openings.to_string(),
                    room.items.to_string(),
                ]
            })
            .collect();
        if !rows.is_empty() {
            text += "\n";
            text += &table(
                &["room", "m²", "height m", "doors", "windows", "openings", "items"],
                &rows,
            );
        }
        if sorted.len() > MAX_ROWS {
            text += &format!("  and {} more; -o writes all\n", sorted.len() - MAX_ROWS);
        }
        if !report.suggestions.is_empty() {
            text += &format!(
                "\n{} may be closed doors, by their shape:\n",
                plural(report.suggestions.len(), "item")
            );
            for suggestion in report.suggestions.iter().take(MAX_ROWS) {
                let [one, other] = &suggestion.rooms;
                text += &format!("  {} between {one} and {other}\n", suggestion.item);
            }
            if report.suggestions.len() > MAX_ROWS {
                text += &format!(
                    "  and {} more; --json lists all\n",
                    report.suggestions.len() - MAX_ROWS
                );
            }
        }
        text += &self.leaks_for_people();
        for (what, path) in [("graph", &args.output), ("floor plans", &args.html)] {
            if let Some(path) = path {
                text += &format!("\n{what}: {}\n", path.display());
            }
        }
        text
    }

    fn leaks_for_people(&self) -> String {
        /// Narrower ones are counted only.
        const MIN_WIDTH_CM: f64 = 2.0;
        const MAX_ROWS: usize = 8;
        let leaks = &self.report.leaks;
        if leaks.is_empty() {
            return String::new();
        }
        let mut text = format!(
            "\n{} between rooms, too small to pass:\n",
            plural(leaks.len(), "hole")
        );
        let wide = leaks.iter().filter(|leak| leak.width_cm >= MIN_WIDTH_CM);
        for leak in wide.take(MAX_ROWS) {
            let [one, other] = &leak.rooms;
            text += &format!(
                "  {one} and {other} join through a hole {} x {} cm at {}\n",
                short(leak.width_cm.round()),
                short(leak.length_cm.round()),
                point(leak.middle.map(|value| value as f32)),
            );
        }
        if leaks.len() > MAX_ROWS {
            text += "  --json lists all\n";
        }
        text
    }
}
