//! `info`: prints the contents of a scene.

mod map;
mod occluders;

use crate::Outcome;
use crate::args::InfoArgs;
use crate::bake::{SectionEntry, entries};
use crate::json::{Sink, rounded};
use crate::leak::{LeakEntry, leak_of};
use crate::non_occluders::{self, NonOccluderCount};
use crate::open::{OpenedScene, Purpose, allow_threads, open};
use crate::out;
use crate::report::single;
use crate::run_files::RunFiles;
use crate::text::{bytes, count, ms, plural, point, short};
use crate::upright::{Source, doubtful_up, up_for_people};
use crate::values::Choice;
use anyhow::Result;
use enfilade::{Aabb, Alpha, Camera, Geometry, LightShape, Material, Portal, Scene, Transform};
use map::MapEntry;
use occluders::Occluders;
use serde::Serialize;
use std::collections::HashSet;
use std::fmt::Write;
use std::path::Path;
use std::sync::Arc;

/// Contents of a scene.
#[derive(Debug, Serialize)]
struct Inventory {
    file: String,
    format: &'static str,
    /// The up vector.
    up: [f32; 3],
    /// Where it comes from: `format`, `floors`, `option`, or `nothing`.
    up_from: &'static str,
    /// Metres per scene unit, if they are given or found.
    metres_per_unit: Option<f64>,
    /// For a format with y up: the axis that floors face, if that is another.
    floors_face: Option<&'static str>,
    items: usize,
    meshes: usize,
    /// Triangles of all meshes, each mesh counted once.
    triangles_unique: u64,
    /// Triangles of all items.
    triangles_drawn: u64,
    clusters: usize,
    materials: Materials,
    /// Union of the bounds of all sectors, each in its own space; `None` if the scene is empty.
    bounds: Option<Bounds>,
    cameras: Vec<CameraEntry>,
    lights: Lights,
    /// The scenes of a glTF file.
    scenes: Vec<SceneEntry>,
    /// Compiled maps only.
    map: Option<MapEntry>,
    sectors: Vec<SectorEntry>,
    portals: usize,
    /// The portals; a door is two.
    ways: Vec<PortalEntry>,
    openings: usize,
    occluders: Occluders,
    /// Triangles of all items that hide what is behind them.
    triangles_occluding: u64,
    /// What hides nothing, by reason.
    non_occluders: Vec<NonOccluderCount>,
    /// Baked scenes only.
    sections: Vec<SectionEntry>,
    bytes: u64,
    load_ms: f64,
    warnings: Vec<String>,
}

#[derive(Debug, Default, Serialize)]
struct Materials {
    opaque: usize,
    mask: usize,
    blend: usize,
    double_sided: usize,
}

/// Number of lights by shape.
#[derive(Debug, Default, Serialize)]
struct Lights {
    points: usize,
    spots: usize,
    suns: usize,
}

#[derive(Debug, Serialize)]
struct Bounds {
    min: [f32; 3],
    max: [f32; 3],
}

#[derive(Debug, Serialize)]
struct CameraEntry {
    name: String,
    eye: [f32; 3],
    toward: [f32; 3],
    up: [f32; 3],
    /// Vertical field of view, in degrees.
    fov: f64,
    /// Height of the view of an orthographic camera, in scene units; `None` for a perspective one.
    height: Option<f32>,
}

/// A scene of a glTF file.
#[derive(Debug, Serialize)]
struct SceneEntry {
    name: String,
    /// Whether the file names it as its default scene.
    is_default: bool,
    /// Whether this is the inventory of it.
    is_read: bool,
}

#[derive(Debug, Serialize)]
struct SectorEntry {
    name: String,
    method: &'static str,
    items: usize,
    triangles: u64,
    openings: usize,
    /// Whether it is open to the sky, as a garden is.
    open_above: bool,
}

/// One portal.
#[derive(Debug, Serialize)]
struct PortalEntry {
    opening: String,
    from: String,
    to: String,
    /// `mirror` if it reflects, `portal` if it leads to the other side of its opening, else `teleport`.
    kind: &'static str,
}

/// Runs `info`.
pub(crate) fn run(args: &InfoArgs) -> Result<Outcome> {
    let mut files = RunFiles::of(&args.scene.scene, None)?;
    let sink = Sink::new(&args.json, &mut files)?;
    allow_threads(&args.limits)?;
    let mut opened = open(
        &args.scene.scene,
        Purpose::Visibility,
        Choice::Own,
        &args.portals,
        &args.limits,
        &mut files,
    )?;
    opened.upright.set(&args.upright);
    let leak = leak(&opened, args);
    let mut inventory = Inventory::of(opened, leak);
    if args.portals.flat {
        // A built-in scene keeps its portals, but no verb follows them with --flat.
        inventory.portals = 0;
        inventory.ways.clear();
    }
    if !args.json.takes_stdout() {
        out::print(&inventory.for_people())?;
    }
    sink.write(&inventory)?;
    Ok(Outcome::Done)
}

impl Inventory {
    fn of(opened: OpenedScene, leak: Option<LeakEntry>) -> Inventory {
        let scene = &opened.scene;
        let geometries: Vec<&Geometry> = scene
            .sectors()
            .filter_map(|id| scene.geometry(id))
            .map(|c| &**c)
            .collect();
        // Sectors may share meshes and material tables; count each once.
        let mut counted = HashSet::new();
        let meshes: Vec<_> = geometries
            .iter()
            .flat_map(|geometry| geometry.meshes())
            .filter(|mesh| counted.insert(Arc::as_ptr(mesh).addr()))
            .collect();
        let mut materials = Materials::default();
        let mut tables: Vec<&[Material]> = Vec::new();
        for geometry in &geometries {
            if tables.contains(&geometry.materials()) {
                continue;
            }
            tables.push(geometry.materials());
            geometry.materials().iter().for_each(|material| {
                *match material.alpha {
                    Alpha::Opaque => &mut materials.opaque,
                    Alpha::Mask => &mut materials.mask,
                    Alpha::Blend => &mut materials.blend,
                } += 1;
                materials.double_sided += usize::from(material.double_sided);
            });
        }
        let boxes = scene
            .sectors()
            .map(|id| scene.bounds(id))
            .filter(|bounds| !bounds.is_empty());
        let (non_occluders, triangles_occluding) = non_occluders::counts(&opened);
        Inventory {
            format: opened.format,
            up: opened.upright.up,
            up_from: opened.upright.up_from.name(),
            metres_per_unit: opened.upright.metres_per_unit,
            floors_face: floors_face(&opened),
            items: scene.item_count(),
            meshes: meshes.len(),
            triangles_unique: meshes.iter().map(|mesh| mesh.triangle_count()).sum(),
            triangles_drawn: scene.triangle_count(),
            clusters: meshes.iter().map(|mesh| mesh.clusters().len()).sum(),
            materials,
            bounds: boxes
                .reduce(|a, b| a.union(&b))
                .map(|Aabb { min, max, .. }| Bounds { min, max }),
            scenes: opened
                .scenes
                .into_iter()
                .map(|scene| SceneEntry {
                    name: scene.name,
                    is_default: scene.is_default,
                    is_read: scene.is_read,
                })
                .collect(),
            map: opened
                .map
                .as_ref()
                .map(|map| MapEntry::of(map, &geometries, leak)),
            sectors: sectors(scene),
            portals: scene.portals().len(),
            ways: ways(scene),
            openings: scene.sectors().map(|id| scene.sector(id).openings().len()).sum(),
            occluders: Occluders::of(&geometries),
            triangles_occluding,
            non_occluders,
            sections: opened.sections.as_ref().map_or(Vec::new(), entries),
            bytes: scene.bytes(),
            load_ms: rounded(opened.load_ms),
            cameras: opened
                .cameras
                .into_iter()
                .zip(opened.orthographic_heights)
                .map(CameraEntry::new)
                .collect(),
            lights: Lights::of(scene),
            warnings: opened.warnings,
            file: opened.file,
        }
    }

    /// Returns the text output. Writing to a String cannot fail, so `writeln!` results are dropped.
    fn for_people(&self) -> String {
        let mut text = format!("{}: {}\n", self.file, self.format);
        let mut say = |label: &str, value: String| {
            let _ = writeln!(text, "  {label:<10} {value}");
        };
        for (number, scene) in self.scenes.iter().enumerate().filter(|_| self.scenes.len() > 1) {
            let marks = [(scene.is_default, "default"), (scene.is_read, "read here")];
            let marks = marks.iter().filter(|(is_so, _)| *is_so).map(|(_, mark)| *mark);
            let marks: Vec<&str> = marks.collect();
            let name = match &*scene.name {
                "" => number.to_string(),
                name => format!("{number} {name:?}"),
            };
            say(
                "scene",
                match &*marks {
                    [] => name,
                    marks => format!("{name}: {}", marks.join(", ")),
                },
            );
        }
        say("up", self.up_for_people());
        if let Some(metres) = self.metres_per_unit {
            say("unit", format!("{} m; --unit sets it", short(metres)));
        }
        say("items", count(self.items as u64));
        say("meshes", count(self.meshes as u64));
        say(
            "triangles",
            format!(
                "{} drawn, {} unique",
                count(self.triangles_drawn),
                count(self.triangles_unique)
            ),
        );
        say("clusters", count(self.clusters as u64));
        let Materials {
            opaque,
            mask,
            blend,
            double_sided,
        } = self.materials;
        say(
            "materials",
            format!(
                "{opaque} opaque, {mask} alpha-tested, {blend} alpha-blended; {double_sided} of them double-sided"
            ),
        );
        match &self.bounds {
            Some(Bounds { min, max }) => say("bounds", format!("from {} to {}", point(*min), point(*max))),
            None => say("bounds", "none: the scene is empty".to_owned()),
        }
        if self.cameras.is_empty() {
            say("cameras", "none".to_owned());
        }
        for camera in &self.cameras {
            let CameraEntry {
                name,
                eye,
                toward,
                fov,
                height,
                ..
            } = camera;
            let lens = match height {
                Some(height) => format!("orthographic, {height} high"),
                None => format!("{fov:.1} degrees"),
            };
            say(
                "camera",
                format!("{name}: from {} toward {}, {lens}", point(*eye), point(*toward)),
            );
        }
        let Lights { points, spots, suns } = self.lights;
        let lights = match points + spots + suns {
            0 => "none".to_owned(),
            _ => [
                plural(points, "point light"),
                plural(spots, "spot light"),
                plural(suns, "sun"),
            ]
            .join(", "),
        };
        say("lights", lights);
        if let Some(map) = &self.map {
            say("map", map.for_people());
            say("visible", map.visible_for_people());
            if let Some(leak) = &map.leak {
                say("leak", leak.for_people(&self.file));
            }
        }
        for sector in &self.sectors {
            let SectorEntry {
                name,
                method,
                items,
                triangles,
                openings,
                open_above,
            } = sector;
            let openings = plural(*openings, "opening");
            let top = if *open_above { ", open above" } else { "" };
            let items = plural(*items, "item");
            say(
                "sector",
                format!(
                    "{name}: {items}, {} triangles, {openings}{top}, by {method}",
                    count(*triangles)
                ),
            );
        }
        let mut printed = HashSet::new();
        for way in &self.ways {
            let PortalEntry {
                opening,
                from,
                to,
                kind,
            } = way;
            let is_back = |other: &&PortalEntry| {
                *kind == "portal" && (&other.opening, &other.from, &other.to) == (opening, to, from)
            };
            match self.ways.iter().find(is_back) {
                _ if printed.contains(&(opening, to, from)) => {}
                Some(_) => {
                    printed.insert((opening, from, to));
                    say("door", format!("{opening}: between {from} and {to}"));
                }
                None => say(kind, format!("{opening}: from {from} to {to}")),
            }
        }
        say("portals", count(self.portals as u64));
        say("openings", count(self.openings as u64));
        let Occluders {
            polygons,
            triangles_merged,
            area_share,
            build_ms,
            ..
        } = self.occluders;
        say(
            "occluders",
            format!(
                "{} of {} triangles, {:.1} % of all opaque area; found in {} ms",
                count(polygons),
                count(triangles_merged),
                100.0 * area_share,
                ms(build_ms)
            ),
        );
        for reason in &self.non_occluders {
            say("hides none", reason.for_people());
        }
        for section in &self.sections {
            say("section", section.for_people());
        }
        say("memory", bytes(self.bytes));
        say("loaded in", format!("{} ms", ms(self.load_ms)));
        for warning in &self.warnings {
            say("warning", warning.clone());
        }
        text
    }
}

/// Returns the leak of a map without a PVS.
fn leak(opened: &OpenedScene, args: &InfoArgs) -> Option<LeakEntry> {
    let is_dark = opened.map.as_ref().is_some_and(|map| map.visibility_bytes == 0);
    let leak = is_dark.then(|| leak_of(Path::new(&args.scene.scene), args.limits.memory()));
    leak.flatten().map(LeakEntry::from)
}

impl Inventory {
    fn up_for_people(&self) -> String {
        let up = up_for_people(self.up);
        match (self.up_from, self.floors_face) {
            ("floors", _) => format!("{up}, by the floors; --up sets it"),
            ("nothing", _) => format!("{up}; the file does not tell, nor do its floors; --up sets it"),
            ("option", _) => format!("{up}, by --up"),
            (_, Some(other)) => {
                format!(
                    "{up}, but its floors seem to face {other}; --up {other} turns the survey and the cameras"
                )
            }
            _ => up,
        }
    }
}

/// Returns the axis that floors face, if that is clearly another than the one that the format gives.
fn floors_face(opened: &OpenedScene) -> Option<&'static str> {
    if opened.upright.up_from != Source::Format {
        return None;
    }
    doubtful_up(&opened.scene)
}

impl Lights {
    fn of(scene: &Scene) -> Lights {
        let mut lights = Lights::default();
        for light in scene.lights() {
            *match light.shape {
                LightShape::Point => &mut lights.points,
                LightShape::Spot { .. } => &mut lights.spots,
                LightShape::Sun { .. } => &mut lights.suns,
            } += 1;
        }
        lights
    }
}

impl CameraEntry {
    fn new((camera, height): (Camera, Option<f32>)) -> CameraEntry {
        let fov = rounded(f64::from(camera.fov_y).to_degrees());
        CameraEntry {
            name: camera.name,
            eye: camera.eye.map(single),
            toward: camera.toward.map(single),
            up: camera.up.map(single),
            fov,
            height,
        }
    }
}

fn ways(scene: &Scene) -> Vec<PortalEntry> {
    let entry = |portal: &Portal| PortalEntry {
        opening: scene.sector(portal.from).openings()[usize::from(portal.opening.0)]
            .name
            .clone(),
        from: scene.sector_name(portal.from).to_owned(),
        to: scene.sector_name(portal.to).to_owned(),
        kind: if portal.there_from_here.mirrors() {
            "mirror"
        } else if portal.there_from_here == Transform::IDENTITY {
            "portal"
        } else {
            "teleport"
        },
    };
    scene.portals().iter().map(entry).collect()
}

fn sectors(scene: &Scene) -> Vec<SectorEntry> {
    let entry = |id| {
        let geometry = scene.geometry(id);
        let sector = scene.sector(id);
        SectorEntry {
            name: scene.sector_name(id).to_owned(),
            method: scene.method(id).map_or("its own", |method| method.name()),
            items: geometry.map_or(sector.item_count() as usize, |geometry| geometry.items().len()),
            triangles: scene.triangles_of(id),
            openings: sector.openings().len(),
            open_above: scene.is_open_above(id),
        }
    };
    scene.sectors().map(entry).collect()
}
