//! A house in a valley: the terrain of Jacksboro with the duplex standing in it, joined by its windows and outer doors.
//!
//! Items visible from outside (walls, floors, roof, windows, doors) are in both sectors; furniture, ceilings and inner
//! doors only inside; ground and foundations only outside.

use enfilade::{
    ConvexPolygon, GeometryBuilder, HeightField, Material, MaterialId, Method, Scene, SceneBuilder, SectorId,
    Transform, View,
};
use enfilade_import::{ReadOptions, read};
use serde_json::Value;
use std::path::Path;
use std::sync::Arc;

/// The two sectors, in the order of the scene.
pub(crate) const OUTSIDE: SectorId = SectorId(0);
pub(crate) const INSIDE: SectorId = SectorId(1);

/// Name prefixes of items that are only inside, and of those only outside.
const ONLY_INSIDE: [&str; 4] = [
    "IfcFurnishingElement",
    "IfcCovering",
    "IfcStairFlight",
    "IfcRailing",
];
const ONLY_OUTSIDE: [&str; 2] = ["IfcFooting", "IfcSlab:Basic Roof"];

/// Walls that are so thick stand between inside and outside.
const OUTER_WALL: f64 = 0.4;

/// A window or a door of an outer wall.
struct Opening {
    corners: [[f64; 3]; 4],
    /// Points out of the house.
    outward: [f64; 3],
}

/// The scene, by two methods, and views: for each opening one from outside toward it, and one through it from inside.
pub(crate) fn house_in_a_valley(folder: &Path, methods: [Method; 2], size: [u32; 2]) -> (Scene, Vec<View>) {
    let flat = ReadOptions {
        flat: true,
        ..ReadOptions::default()
    };
    let import = read(&folder.join("ifc_duplex.glb"), &flat).unwrap_or_else(|error| panic!("{error}"));
    let house = &import.rooms[0].geometry;
    let (field, foot) = valley(folder);
    let world_from_house = Transform::translation(foot.map(|part| part as f32));
    let ground = MaterialId(house.materials().len() as u32);
    let materials: Vec<Material> = house
        .materials()
        .iter()
        .copied()
        .chain([Material::opaque([0.32, 0.36, 0.17])])
        .collect();
    let materials: Arc<[Material]> = materials.into();
    let [mut outside, mut inside] = [(); 2].map(|()| GeometryBuilder::new(Arc::clone(&materials)));
    outside
        .terrain("ground", field, ground, Transform::IDENTITY)
        .expect("few faces");
    for (geometry, elsewhere) in [(&mut outside, &ONLY_INSIDE[..]), (&mut inside, &ONLY_OUTSIDE[..])] {
        for (number, item) in (0..).zip(house.items()) {
            let name = house.name(enfilade::ItemIndex(number));
            if elsewhere.iter().any(|beginning| name.starts_with(beginning)) {
                continue;
            }
            let mesh = geometry.mesh(Arc::clone(&house.meshes()[item.mesh.0 as usize]));
            geometry.item(name, mesh, world_from_house * item.transform());
        }
    }
    let openings = openings(folder);
    let mut views = Vec::new();
    let mut doors = Vec::new();
    for (number, opening) in openings.iter().enumerate() {
        let at = |point: [f64; 3]| -> [f32; 3] { std::array::from_fn(|i| (point[i] + foot[i]) as f32) };
        let outline = ConvexPolygon::new(&opening.corners.map(at)).expect("a flat rectangle");
        let outline = if dot(outline.normal().map(f64::from), opening.outward) > 0.0 {
            outline
        } else {
            outline.flipped()
        };
        let name = format!("opening {number}");
        let there = inside.opening(&name, outline.flipped());
        doors.push((outside.opening(&name, outline), there));
        let middle: [f64; 3] = std::array::from_fn(|i| (opening.corners[0][i] + opening.corners[2][i]) / 2.0);
        let off = |distance: f64| at(std::array::from_fn(|i| middle[i] + distance * opening.outward[i]));
        views.push(View::new(off(9.0), off(0.0), size));
        views.push(View::new(off(-1.5), off(3.0), size));
    }
    let mut scene = SceneBuilder::new();
    let outside = scene.add("outside", outside.build().expect("a geometry"), methods[0]);
    let inside = scene.add("inside", inside.build().expect("a geometry"), methods[1]);
    assert_eq!([outside, inside], [OUTSIDE, INSIDE]);
    for (from, to) in doors {
        scene.door((outside, from), (inside, to));
    }
    (scene.build().expect("a scene"), views)
}

fn dot(a: [f64; 3], b: [f64; 3]) -> f64 {
    a.iter().zip(b).map(|(a, b)| a * b).sum()
}

fn json(path: &Path) -> Value {
    let text = std::fs::read_to_string(path).unwrap_or_else(|why| panic!("{}: {why}", path.display()));
    serde_json::from_str(&text).expect("JSON")
}

/// The terrain, with its lowest place made level for the house, and where that is.
fn valley(folder: &Path) -> (HeightField, [f64; 3]) {
    let said = json(&folder.join("terrain_jacksboro.json"));
    let size = ["width", "height"].map(|key| said[key].as_u64().expect("a number") as usize);
    let cell = ["cellMetresX", "cellMetresZ"].map(|key| said[key].as_f64().expect("a number"));
    let raw = std::fs::read(folder.join("terrain_jacksboro_u16le.raw")).expect("heights");
    let (pairs, _) = raw.as_chunks::<2>();
    let mut heights: Vec<f32> = pairs.iter().map(|&two| u16::from_le_bytes(two).into()).collect();
    let inner = (size[1] / 4..3 * size[1] / 4)
        .flat_map(|row| (size[0] / 4..3 * size[0] / 4).map(move |column| row * size[0] + column));
    let lowest = inner
        .min_by(|&a, &b| heights[a].total_cmp(&heights[b]))
        .expect("there are some");
    let level = heights[lowest];
    for corner in [lowest, lowest + 1, lowest + size[0], lowest + size[0] + 1] {
        heights[corner] = level;
    }
    // The house is some 9 m by 26 m, and reaches 4 m to the north of its own middle.
    let place = [lowest % size[0], lowest / size[0]];
    let foot = [
        (place[0] as f64 + 0.5) * cell[0],
        f64::from(level) + 0.02,
        (place[1] as f64 + 0.4) * cell[1],
    ];
    let field = HeightField::new(size.map(|side| side as u32), cell, heights).expect("a field");
    (field, foot)
}

fn openings(folder: &Path) -> Vec<Opening> {
    let said = json(&folder.join("ifc_duplex_cells.json"));
    let point = |value: &Value| -> [f64; 3] { std::array::from_fn(|i| value[i].as_f64().expect("a number")) };
    let list = |key: &str| said[key].as_array().expect("a list").clone();
    let cells = list("cells");
    let middle_of = |id: &str| {
        let cell = cells.iter().find(|cell| cell["id"] == id).expect("a cell");
        let [low, high] = ["aabbMin", "aabbMax"].map(|key| point(&cell[key]));
        let middle: [f64; 3] = std::array::from_fn(|i| (low[i] + high[i]) / 2.0);
        middle
    };
    let mut openings = Vec::new();
    for portal in list("portals") {
        let [low, high, normal] = ["aabbMin", "aabbMax", "normal"].map(|key| point(&portal[key]));
        let thick: f64 = (0..3).map(|i| normal[i].abs() * (high[i] - low[i])).sum();
        let rooms: Vec<&str> = [0, 1]
            .iter()
            .filter_map(|&side| portal["cellsGeometric"][side].as_str())
            .collect();
        let [room] = rooms[..] else { continue };
        if thick < OUTER_WALL || portal["kind"] == "opening" {
            continue;
        }
        let corners: [[f64; 3]; 4] = std::array::from_fn(|corner| point(&portal["quad"][corner]));
        let room = middle_of(room);
        let toward_room = std::array::from_fn(|i| room[i] - corners[0][i]);
        let turn = if dot(normal, toward_room) > 0.0 { -1.0 } else { 1.0 };
        openings.push(Opening {
            corners,
            outward: normal.map(|part| turn * part),
        });
    }
    assert!(!openings.is_empty(), "the house has windows");
    openings
}
