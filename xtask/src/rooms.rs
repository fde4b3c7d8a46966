//! Scores the rooms, doors and windows that `find_rooms` finds in buildings of which the true ones are known.
//!
//! The truth of `NAME.glb` is in `NAME_cells.json` (closed volumes, and portals with boxes) or `NAME.truth.json` (boxes of
//! rooms, and portals with corners) beside it.
#![allow(clippy::print_stdout, reason = "a command prints what it finds")]

use anyhow::{Context, Result, ensure};
use enfilade::{Geometry, GeometryBuilder, Material, MaterialId, Mesh, Method, Ray, Transform};
use enfilade_bake::{
    DoorId, DoorKind, DoorSuggestion, FoundRooms, RoomGraph, RoomId, RoomOptions, RoomVoxels,
    detect_metres_per_unit, find_rooms, is_door_name,
};
use enfilade_import::{ReadOptions, SceneRoomItems, read};
use serde_json::Value;
use std::collections::{BTreeMap, BTreeSet, HashMap};
use std::fs;
use std::path::{Path, PathBuf};
use std::time::Instant;

#[derive(clap::Args)]
pub(crate) struct Args {
    /// Buildings [default: all in ENFILADE_SCENES with a known truth]
    #[arg(value_name = "SCENES")]
    scenes: Vec<PathBuf>,
    /// Fail if less is right than promised: 97 % of groups and doors, 95 % of windows, 1.5 rooms for a true one, all lines
    #[arg(long)]
    check: bool,
    /// Print each room and door that is wrong
    #[arg(long)]
    verbose: bool,
    /// Test with random points that room_at finds their rooms, and time it
    #[arg(long)]
    points: bool,
    /// Test with N random lines of sight that what sees each other is relevant to each other
    #[arg(long, value_name = "N", default_value_t = 0)]
    lines: usize,
    /// Ignore the names of items: doors are then suggested by their shape
    #[arg(long)]
    no_names: bool,
}

/// Minimum intersection over union for a room to be right.
const OVERLAP: f64 = 0.8;

/// Minimum share of a door or window in its wall that must be open.
const OPEN: f64 = 0.25;

/// Contact of true rooms, in square metres, from which on they are one group.
const JOINED: f64 = 1.2;

/// Gap between the volumes of true rooms that are joined, in metres: walls end there.
const GAP: f64 = 0.45;

/// True rooms and portals, in metres with y up.
struct Truth {
    names: Vec<String>,
    /// Closed surfaces: triangles.
    volumes: Vec<Vec<[[f64; 3]; 3]>>,
    portals: Vec<TruePortal>,
}

struct TruePortal {
    name: String,
    is_window: bool,
    min: [f64; 3],
    max: [f64; 3],
    normal: [f64; 3],
    /// Rooms on its two sides; `None` for the exterior.
    rooms: [Option<u16>; 2],
}

/// Numbers of true ones, and of those that were found.
#[derive(Default)]
struct Score {
    rooms: usize,
    rooms_right: usize,
    groups: usize,
    groups_right: usize,
    /// Found rooms that are mostly inside a true one.
    found: usize,
    doors: usize,
    doors_right: usize,
    /// Doors between two rooms with an item that is suggested.
    doors_suggested: usize,
    windows: usize,
    windows_right: usize,
    suggestions: usize,
    /// Suggested items that are doors by name.
    suggestions_right: usize,
    points: Points,
}

/// Random points in the free space of true rooms that are not part of an open plan.
#[derive(Clone, Copy, Default)]
struct Points {
    count: usize,
    right: usize,
    nanoseconds: f64,
}

pub(crate) fn run(args: &Args) -> Result<()> {
    let scenes = if args.scenes.is_empty() {
        known()?
    } else {
        args.scenes.clone()
    };
    let mut sum = Score::default();
    let mut missed = 0;
    println!("{HEADER}");
    for path in &scenes {
        let start = Instant::now();
        let import = read(path, &ReadOptions::default())?;
        let scene = import.scene(Method::ZBuffer, Method::DEFAULT_LIMIT)?;
        let name = |sector, item| scene.geometry(sector).map_or("", |geometry| geometry.name(item));
        let items = SceneRoomItems::of(&scene, |sector, item| {
            !args.no_names && is_door_name(name(sector, item))
        });
        let mut options = RoomOptions::default();
        options.metres_per_unit = detect_metres_per_unit(&items.input, options.up).unwrap_or(1.0);
        let found = find_rooms(&items.input, &options)?;
        let seconds = start.elapsed().as_secs_f64();
        let file = path.file_stem().unwrap_or_default().to_string_lossy();
        if truth_path(path).exists() {
            let truth = truth_of(path)?;
            let score = score(&found, &items, &truth, args.verbose);
            score.print(&file, seconds);
            if args.points {
                let Points {
                    count,
                    right,
                    nanoseconds,
                } = score.points;
                println!(
                    "{right} of {count} random points are in the right room; {nanoseconds:.0} ns for each"
                );
            }
            sum.add(&score);
        } else {
            println!(
                "{file:18} {} rooms, {} doors, windows and so on; {:.1} million voxels of {:.3} m; {seconds:.2} s",
                found.graph.rooms().len(),
                found.graph.doors().len(),
                found.voxels.size().iter().product::<usize>() as f64 / 1e6,
                found.voxels.step(),
            );
        }
        if args.lines > 0 {
            missed += test_lines(&items, &found, args)?;
        }
    }
    if scenes.len() > 1 {
        sum.print("all", 0.0);
    }
    if args.check { sum.check(missed) } else { Ok(()) }
}

const HEADER: &str = "\
building           | rooms right found | groups right | doors right suggested | windows right | suggestions right |      s";

/// Returns the buildings with a known truth.
fn known() -> Result<Vec<PathBuf>> {
    let folder = std::env::var_os("ENFILADE_SCENES").context("give scenes, or set ENFILADE_SCENES")?;
    let mut scenes: Vec<PathBuf> = fs::read_dir(&folder)?
        .map(|entry| Ok(entry?.path()))
        .collect::<Result<_>>()?;
    scenes.retain(|path| path.extension().is_some_and(|ending| ending == "glb") && truth_path(path).exists());
    scenes.sort();
    ensure!(!scenes.is_empty(), "no building with a known truth in {folder:?}");
    Ok(scenes)
}

fn truth_path(scene: &Path) -> PathBuf {
    let stem = scene.file_stem().unwrap_or_default().to_string_lossy();
    let cells = scene.with_file_name(format!("{stem}_cells.json"));
    if cells.exists() {
        cells
    } else {
        scene.with_file_name(format!("{stem}.truth.json"))
    }
}

fn numbers(value: &Value) -> [f64; 3] {
    [0, 1, 2].map(|axis| value[axis].as_f64().unwrap_or(f64::NAN))
}

fn truth_of(scene: &Path) -> Result<Truth> {
    let path = truth_path(scene);
    let text = fs::read(&path).with_context(|| path.display().to_string())?;
    let json: Value = serde_json::from_slice(&text).with_context(|| path.display().to_string())?;
    Ok(if json["cells"].is_array() {
        cells(&json)
    } else {
        boxes(&json)
    })
}

fn list<'a>(json: &'a Value, key: &str) -> &'a [Value] {
    json[key].as_array().map_or(&[], |values| values)
}

/// Reads rooms of an IFC file.
fn cells(json: &Value) -> Truth {
    let cells = list(json, "cells");
    let number_of = |id: &Value| {
        let at = cells.iter().position(|cell| id.is_string() && cell["id"] == *id);
        at.map(|at| at as u16)
    };
    let volume = |cell: &Value| {
        let corners: Vec<[f64; 3]> = list(cell, "vertices").iter().map(numbers).collect();
        let triangle = |triangle: &Value| {
            [0, 1, 2].map(|corner| corners[triangle[corner].as_u64().unwrap_or(0) as usize])
        };
        list(cell, "triangles").iter().map(triangle).collect()
    };
    let portal = |portal: &Value| {
        Some(TruePortal {
            name: portal["name"].as_str().unwrap_or_default().to_owned(),
            is_window: match portal["kind"].as_str()? {
                "door" => false,
                "window" => true,
                _ => return None,
            },
            min: numbers(&portal["aabbMin"]),
            max: numbers(&portal["aabbMax"]),
            normal: numbers(&portal["normal"]),
            rooms: [0, 1].map(|side| number_of(&portal["cellsGeometric"][side])),
        })
    };
    Truth {
        names: cells
            .iter()
            .map(|cell| {
                format!(
                    "{} {}",
                    cell["name"].as_str().unwrap_or(""),
                    cell["longName"].as_str().unwrap_or("")
                )
            })
            .collect(),
        volumes: cells.iter().map(volume).collect(),
        portals: list(json, "portals").iter().filter_map(portal).collect(),
    }
}

/// Reads rooms that are boxes.
fn boxes(json: &Value) -> Truth {
    let rooms: Vec<&Value> = list(json, "rooms")
        .iter()
        .filter(|room| room["interior"].is_object())
        .collect();
    let number_of = |name: &Value| {
        rooms
            .iter()
            .position(|room| room["name"] == *name)
            .map(|at| at as u16)
    };
    let volume = |room: &&Value| {
        let [min, max] = ["min", "max"].map(|end| numbers(&room["interior"][end]));
        let at = |bits: usize| {
            [0, 1, 2].map(|axis| {
                if bits >> axis & 1 == 0 {
                    min[axis]
                } else {
                    max[axis]
                }
            })
        };
        // Only the floor and the ceiling matter.
        [[0, 1, 5], [0, 5, 4], [2, 3, 7], [2, 7, 6]]
            .map(|triangle| triangle.map(at))
            .to_vec()
    };
    let portal = |portal: &Value| {
        let corners: Vec<[f64; 3]> = portal["corners"].as_array()?.iter().map(numbers).collect();
        let pick = |pick: fn(f64, f64) -> f64| {
            [0, 1, 2].map(|axis| corners.iter().map(|at| at[axis]).reduce(pick).unwrap_or_default())
        };
        let [min, max] = [pick(f64::min), pick(f64::max)];
        let thin = (0..3).min_by(|&a, &b| (max[a] - min[a]).total_cmp(&(max[b] - min[b])))?;
        let mut normal = [0.0; 3];
        normal[thin] = 1.0;
        // The wall is 0.3 m thick.
        let [mut low, mut high] = [min, max];
        low[thin] -= 0.15;
        high[thin] += 0.15;
        let is_between = portal["exit"].is_null() && portal["rooms"].as_array()?.len() == 2;
        is_between.then_some(TruePortal {
            name: portal["name"].as_str().unwrap_or_default().to_owned(),
            is_window: portal["window"] == true,
            min: low,
            max: high,
            normal,
            rooms: [0, 1].map(|side| number_of(&portal["rooms"][side])),
        })
    };
    Truth {
        names: rooms
            .iter()
            .map(|room| room["name"].as_str().unwrap_or_default().to_owned())
            .collect(),
        volumes: rooms.iter().map(volume).collect(),
        portals: list(json, "portals").iter().filter_map(portal).collect(),
    }
}

const NONE: u16 = u16::MAX;

/// Returns the true room of each voxel, by the parity of crossings along y.
fn true_rooms(truth: &Truth, voxels: &RoomVoxels) -> Vec<u16> {
    let [columns, slices, rows] = voxels.size();
    let (origin, step) = (voxels.origin(), voxels.step());
    let mut labels = vec![NONE; columns * slices * rows];
    for (room, volume) in truth.volumes.iter().enumerate() {
        let mut crossings: HashMap<[usize; 2], Vec<f64>> = HashMap::new();
        for triangle in volume {
            // Column and row of voxel centres.
            let at = triangle.map(|at| [(at[0] - origin[0]) / step - 0.5, (at[2] - origin[2]) / step - 0.5]);
            let side = |[ax, az]: [f64; 2], [bx, bz]: [f64; 2], [x, z]: [f64; 2]| {
                (bx - ax) * (z - az) - (x - ax) * (bz - az)
            };
            let area = side(at[0], at[1], at[2]);
            if area.abs() < 1e-12 {
                continue;
            }
            let range = |axis: usize, count: usize| {
                let low = at
                    .iter()
                    .fold(f64::INFINITY, |low, at| low.min(at[axis]))
                    .ceil()
                    .max(0.0);
                let high = at
                    .iter()
                    .fold(f64::NEG_INFINITY, |high, at| high.max(at[axis]))
                    .floor();
                low as usize..((high + 1.0).max(0.0) as usize).min(count)
            };
            for z in range(1, rows) {
                for x in range(0, columns) {
                    // Slightly off, so that no centre is on an edge that two triangles share.
                    let center = [x as f64 + 1.3e-5, z as f64 + 2.7e-5];
                    let shares = [
                        side(at[1], at[2], center) / area,
                        side(at[2], at[0], center) / area,
                        side(at[0], at[1], center) / area,
                    ];
                    if shares.iter().all(|&share| share >= 0.0) {
                        let height = (0..3).map(|corner| shares[corner] * triangle[corner][1]).sum();
                        crossings.entry([x, z]).or_default().push(height);
                    }
                }
            }
        }
        for ([x, z], mut heights) in crossings {
            heights.sort_by(f64::total_cmp);
            for pair in heights.chunks_exact(2) {
                let [low, high] = [pair[0], pair[1]].map(|height| (height - origin[1]) / step - 0.5);
                for y in low.ceil().max(0.0) as usize..((high.floor() + 1.0).max(0.0) as usize).min(slices) {
                    labels[voxels.index([x, y, z])] = room as u16;
                }
            }
        }
    }
    labels
}

fn score(found: &FoundRooms, items: &SceneRoomItems, truth: &Truth, verbose: bool) -> Score {
    let voxels = &found.voxels;
    let labels = true_rooms(truth, voxels);
    let count = truth.names.len();
    // Numbers of voxels: of true rooms, all and free; of found ones, all and inside a true one; of both.
    let [mut all, mut free] = [vec![0_u32; count], vec![0_u32; count]];
    let [mut own, mut inside] = [
        vec![0_u32; found.graph.rooms().len()],
        vec![0_u32; found.graph.rooms().len()],
    ];
    let mut both: BTreeMap<(u32, u16), u32> = BTreeMap::new();
    for (voxel, &label) in labels.iter().enumerate() {
        let room = voxels.free_room(voxel);
        if label != NONE {
            all[label as usize] += 1;
        }
        if let Some(room) = room {
            own[room as usize] += 1;
            if label != NONE {
                free[label as usize] += 1;
                inside[room as usize] += 1;
                *both.entry((room, label)).or_default() += 1;
            }
        }
    }
    let shared = |room: u32, label: u16| both.get(&(room, label)).copied().unwrap_or(0);
    // A found room belongs to the true one with at least half of it.
    let owner_of = |room: u32| {
        let label = (0..count as u16).max_by_key(|&label| (shared(room, label), std::cmp::Reverse(label)))?;
        let most = shared(room, label);
        (most > 0 && 2 * most >= inside[room as usize]).then_some(label)
    };
    let owners: Vec<Option<u16>> = (0..found.graph.rooms().len() as u32).map(owner_of).collect();
    let mut score = Score {
        rooms: count,
        found: (0..found.graph.rooms().len())
            .filter(|&room| owners[room].is_some() && found.graph.outside() != Some(RoomId(room as u32)))
            .count(),
        ..Score::default()
    };
    for label in 0..count as u16 {
        let [mut common, mut union] = [0, 0];
        for room in (0..owners.len()).filter(|&room| owners[room] == Some(label)) {
            common += shared(room as u32, label);
            union += inside[room];
        }
        let overlap = f64::from(common) / f64::from((free[label as usize] + union - common).max(1));
        score.rooms_right += usize::from(overlap >= OVERLAP);
    }
    let group_of = groups(voxels, &labels, count);
    for group in 0..count as u16 {
        let members: Vec<u16> = (0..count as u16)
            .filter(|&label| group_of[label as usize] == group)
            .collect();
        if members.is_empty() {
            continue;
        }
        score.groups += 1;
        let [mut common, mut union] = [0, 0];
        for (room, &inside) in (0..).zip(&inside) {
            let within: u32 = members.iter().map(|&label| shared(room, label)).sum();
            if within > 0 && 2 * within >= inside {
                common += within;
                union += inside;
            }
        }
        let of_members: u32 = members.iter().map(|&label| free[label as usize]).sum();
        let overlap = f64::from(common) / f64::from((of_members + union - common).max(1));
        if overlap >= OVERLAP {
            score.groups_right += 1;
        } else if verbose {
            let names: Vec<&str> = members
                .iter()
                .map(|&label| &*truth.names[label as usize])
                .collect();
            println!("    group {names:?}: {overlap:.2}");
        }
    }
    score_portals(found, truth, &owners, &mut score, verbose);
    let is_alone = |label: u16| {
        group_of
            .iter()
            .filter(|&&group| group == group_of[label as usize])
            .count()
            == 1
    };
    let alone: Vec<bool> = (0..count as u16).map(is_alone).collect();
    score.points = points(found, &labels, &alone, &owners);
    score.suggestions = found.suggestions.len();
    let is_door = |door: &&DoorSuggestion| is_door_name(items.input.items[door.item as usize].name);
    score.suggestions_right = found.suggestions.iter().filter(is_door).count();
    score
}

/// Tests `room_at` at random points.
fn points(found: &FoundRooms, labels: &[u16], alone: &[bool], owners: &[Option<u16>]) -> Points {
    const COUNT: usize = 100_000;
    let voxels = &found.voxels;
    let mut random = Random(3);
    let mut points = Vec::with_capacity(COUNT);
    let candidates: Vec<usize> = (0..labels.len())
        .filter(|&voxel| {
            let label = labels[voxel];
            label != NONE && alone[label as usize] && voxels.free_room(voxel).is_some()
        })
        .collect();
    while points.len() < COUNT && !candidates.is_empty() {
        let voxel = candidates[(random.next() * candidates.len() as f64) as usize];
        let place = voxels.place(voxel);
        let at = [0, 1, 2]
            .map(|axis| voxels.origin()[axis] + (place[axis] as f64 + random.next()) * voxels.step());
        points.push((at, labels[voxel]));
    }
    let start = Instant::now();
    let rooms: Vec<Option<RoomId>> = points.iter().map(|(at, _)| found.graph.room_at(*at)).collect();
    let nanoseconds = start.elapsed().as_secs_f64() * 1e9 / points.len().max(1) as f64;
    let is_right = |(room, (_, label)): (&Option<RoomId>, &([f64; 3], u16))| {
        room.and_then(|room| owners[room.0 as usize]) == Some(*label)
    };
    Points {
        count: points.len(),
        right: rooms.iter().zip(&points).filter(|&pair| is_right(pair)).count(),
        nanoseconds,
    }
}

/// Returns for each true room the first of its group: rooms that touch with no wall, pane or leaf between them.
fn groups(voxels: &RoomVoxels, labels: &[u16], count: usize) -> Vec<u16> {
    let size = voxels.size();
    let reach = (GAP / voxels.step()).round() as usize;
    let strides = [1, voxels.index([0, 1, 0]), voxels.index([0, 0, 1])];
    let mut faces: BTreeMap<(u16, u16), u32> = BTreeMap::new();
    for (voxel, &label) in labels.iter().enumerate() {
        if label == NONE || voxels.is_separating(voxel) {
            continue;
        }
        let place = voxels.place(voxel);
        for axis in 0..3 {
            for away in 1..=reach.min(size[axis] - 1 - place[axis]) {
                let next = voxel + away * strides[axis];
                if voxels.is_separating(next) {
                    break;
                }
                if labels[next] != NONE {
                    if labels[next] != label {
                        let pair = (label.min(labels[next]), label.max(labels[next]));
                        *faces.entry(pair).or_default() += 1;
                    }
                    break;
                }
            }
        }
    }
    let mut group_of: Vec<u16> = (0..count as u16).collect();
    for (&(one, other), &count) in &faces {
        if f64::from(count) * voxels.step().powi(2) > JOINED {
            let [one, other] = [one, other].map(|label| group_of[label as usize]);
            let [kept, gone] = [one.min(other), one.max(other)];
            group_of
                .iter_mut()
                .filter(|group| **group == gone)
                .for_each(|group| *group = kept);
        }
    }
    group_of
}

fn score_portals(
    found: &FoundRooms,
    truth: &Truth,
    owners: &[Option<u16>],
    score: &mut Score,
    verbose: bool,
) {
    let voxels = &found.voxels;
    let (origin, step, size) = (voxels.origin(), voxels.step(), voxels.size());
    let strides = [1, voxels.index([0, 1, 0]), voxels.index([0, 0, 1])];
    for portal in &truth.portals {
        let low =
            [0, 1, 2].map(|axis| ((portal.min[axis] - origin[axis]) / step - 1.0).floor().max(0.0) as usize);
        let high = [0, 1, 2].map(|axis| {
            (((portal.max[axis] - origin[axis]) / step + 1.0).ceil().max(0.0) as usize).min(size[axis] - 1)
        });
        let [mut open, mut joining] = [0.0, 0.0];
        for y in low[1]..high[1] {
            for z in low[2]..high[2] {
                for x in low[0]..high[0] {
                    let voxel = voxels.index([x, y, z]);
                    for (axis, stride) in strides.into_iter().enumerate() {
                        let next = voxel + stride;
                        let rooms = [voxels.room(voxel), voxels.room(next)];
                        if rooms[0] == rooms[1] || voxels.is_opaque(voxel) || voxels.is_opaque(next) {
                            continue;
                        }
                        let area = portal.normal[axis].abs() * step * step;
                        open += area;
                        let owner = rooms.map(|room| room.and_then(|room| owners[room as usize]));
                        if owner == portal.rooms || owner == [portal.rooms[1], portal.rooms[0]] {
                            joining += area;
                        }
                    }
                }
            }
        }
        let mut sides = [0, 1, 2].map(|axis| portal.max[axis] - portal.min[axis]);
        sides.sort_by(f64::total_cmp);
        let whole = sides[1] * sides[2];
        let is_open = open >= OPEN * whole;
        let is_between =
            portal.rooms[0].is_some() && portal.rooms[1].is_some() && portal.rooms[0] != portal.rooms[1];
        if portal.is_window {
            score.windows += 1;
            score.windows_right += usize::from(is_open);
        } else if is_between {
            score.doors += 1;
            score.doors_right += usize::from(is_open);
            let is_near = |at: [f64; 3]| {
                (0..3).all(|axis| portal.min[axis] - 0.2 <= at[axis] && at[axis] <= portal.max[axis] + 0.2)
            };
            let is_suggested = found.suggestions.iter().any(|door| is_near(door.middle));
            score.doors_suggested += usize::from(is_suggested);
        } else {
            continue;
        }
        if verbose && !is_open {
            println!(
                "    {} at {:?}: open {open:.2} of {whole:.2} m2, between its rooms {joining:.2}",
                portal.name, portal.min
            );
        }
    }
}

impl Score {
    fn add(&mut self, other: &Score) {
        self.rooms += other.rooms;
        self.rooms_right += other.rooms_right;
        self.groups += other.groups;
        self.groups_right += other.groups_right;
        self.found += other.found;
        self.doors += other.doors;
        self.doors_right += other.doors_right;
        self.windows += other.windows;
        self.windows_right += other.windows_right;
        self.doors_suggested += other.doors_suggested;
        self.suggestions += other.suggestions;
        self.suggestions_right += other.suggestions_right;
    }

    /// Fails if less is right than promised.
    fn check(&self, missed: usize) -> Result<()> {
        let is_share = |right: usize, all: usize, share: f64| right as f64 >= share * all as f64;
        ensure!(self.rooms > 0, "no building has a known truth");
        ensure!(
            is_share(self.groups_right, self.groups, 0.97),
            "too few groups of rooms are right"
        );
        ensure!(
            is_share(self.doors_right, self.doors, 0.97),
            "too few doors are right"
        );
        ensure!(
            is_share(self.windows_right, self.windows, 0.95),
            "too few windows are right"
        );
        ensure!(
            self.found as f64 <= 1.5 * self.rooms as f64,
            "too many rooms are found"
        );
        ensure!(
            missed == 0,
            "{missed} lines of sight end in a room that is not relevant"
        );
        Ok(())
    }

    fn print(&self, name: &str, seconds: f64) {
        println!(
            "{name:18} | {:5} {:5} {:5} | {:6} {:5} | {:5} {:5} {:9} | {:7} {:5} | {:11} {:5} | {seconds:6.2}",
            self.rooms,
            self.rooms_right,
            self.found,
            self.groups,
            self.groups_right,
            self.doors,
            self.doors_right,
            self.doors_suggested,
            self.windows,
            self.windows_right,
            self.suggestions,
            self.suggestions_right,
        );
    }
}

/// Tests random lines between points that see each other, with all doors open and with all closed. Returns the number of
/// those that end in a room that is not relevant.
fn test_lines(items: &SceneRoomItems, found: &FoundRooms, args: &Args) -> Result<usize> {
    let mut all_missed = 0;
    for open in [true, false] {
        let mut graph = found.graph.clone();
        for door in 0..graph.doors().len() as u32 {
            graph.set_open(DoorId(door), open);
        }
        let obstacles = obstacles(items, !open)?;
        all_missed += test_lines_in(
            &graph,
            &obstacles,
            found,
            args,
            if open { "open" } else { "closed" },
        );
    }
    Ok(all_missed)
}

fn test_lines_in(
    graph: &RoomGraph,
    obstacles: &Geometry,
    found: &FoundRooms,
    args: &Args,
    doors: &str,
) -> usize {
    let rooms = || (0..graph.rooms().len() as u32).map(RoomId);
    let is_no_gap = |door: DoorId| graph.shows(door) && graph.doors()[door.0 as usize].kind != DoorKind::Gap;
    let start = Instant::now();
    let relevant: Vec<BTreeSet<RoomId>> = rooms()
        .map(|room| graph.relevant(room).into_iter().collect())
        .collect();
    let count = relevant.len().max(1) as f64;
    let ms = 1e3 * start.elapsed().as_secs_f64() / count;
    let average = relevant.iter().map(BTreeSet::len).sum::<usize>() as f64 / count;
    let without_gaps = rooms()
        .map(|room| graph.relevant_by(room, is_no_gap).len())
        .sum::<usize>() as f64
        / count;
    let voxels = &found.voxels;
    let free: Vec<usize> = (0..voxels.size().iter().product())
        .filter(|&voxel| voxels.free_room(voxel).is_some())
        .collect();
    let mut random = Random(7);
    let [mut tested, mut between, mut missed] = [0_usize; 3];
    while tested < args.lines && !free.is_empty() {
        let voxel = free[(random.next() * free.len() as f64) as usize];
        let place = voxels.place(voxel);
        let from = [0, 1, 2]
            .map(|axis| voxels.origin()[axis] + (place[axis] as f64 + random.next()) * voxels.step());
        let from = voxels.scene(from);
        let [rise, angle] = [0.6 * random.next() - 0.3, std::f64::consts::TAU * random.next()];
        let ray = Ray {
            origin: from.map(|value| value as f32),
            direction: [angle.cos(), rise, angle.sin()].map(|value| value as f32),
        };
        // Farther than any building is long.
        let hit = obstacles.cast(&ray).map_or(300.0, |hit| hit.distance);
        let share = 0.999 * hit * random.next();
        let to = [0, 1, 2].map(|axis| f64::from(ray.origin[axis]) + share * f64::from(ray.direction[axis]));
        // Points in rooms, not in gaps inside walls.
        let is_in_wall = voxels
            .voxel_at(to)
            .is_some_and(|voxel| voxels.free_room(voxel).is_none());
        let (Some(one), Some(other)) = (graph.room_at(from), graph.room_at(to)) else {
            continue;
        };
        if is_in_wall {
            continue;
        }
        tested += 1;
        between += usize::from(one != other);
        if !relevant[one.0 as usize].contains(&other) {
            missed += 1;
            if args.verbose && missed <= 10 {
                let [one, other] = [one, other].map(|room| &graph.rooms()[room.0 as usize].name);
                println!("    {one} {from:.3?} sees {other} {to:.3?}");
            }
        }
    }
    println!(
        "  doors {doors}: {tested} lines, {between} between two rooms, {missed} missed; of {count} rooms {average:.1} relevant on \
         average in {ms:.1} ms, {without_gaps:.1} without gaps"
    );
    missed
}

/// Returns the triangles that block sight; those of doors too if they are closed.
fn obstacles(items: &SceneRoomItems, are_closed: bool) -> Result<Geometry> {
    let mut builder = GeometryBuilder::new(vec![Material::opaque([1.0; 3])]);
    for item in &items.input.items {
        let mesh = &items.input.meshes[item.mesh];
        if (item.movable && !are_closed) || mesh.opaque.is_empty() {
            continue;
        }
        let built = Mesh::triangles(mesh.positions, mesh.opaque.as_flattened(), MaterialId(0))?;
        let id = builder.mesh(built);
        builder.item(item.name, id, Transform::from_columns_f64(item.world_from_item));
    }
    Ok(builder.build()?)
}

/// A small generator: the same lines on every machine.
struct Random(u64);

impl Random {
    /// Returns a number from 0 to below 1.
    fn next(&mut self) -> f64 {
        self.0 = self
            .0
            .wrapping_mul(6_364_136_223_846_793_005)
            .wrapping_add(1_442_695_040_888_963_407);
        (self.0 >> 11) as f64 / (1_u64 << 53) as f64
    }
}
