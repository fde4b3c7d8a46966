//! Openings to the open sky: roof windows, courtyards and balconies, as Blender exports them.

use super::file::{File, reads, refuses};
use super::rooms::{house, ways};
use enfilade::laws::{Contestants, views_through};
use enfilade::{Limits, Method, PortalId, Scene, SectorId, View};
use enfilade_import::{Import, ReadOptions, read_bytes};
use serde_json::json;

type Span = [f32; 2];
type Quad = [[f32; 3]; 4];

/// A level rectangle, seen from above or from below.
fn plate([x0, x1]: Span, [z0, z1]: Span, y: f32, from_above: bool) -> Quad {
    let mut quad = [[x0, y, z1], [x1, y, z1], [x1, y, z0], [x0, y, z0]];
    if !from_above {
        quad.reverse();
    }
    quad
}

/// The same with a hole.
fn frame(x: Span, z: Span, [hole_x, hole_z]: [Span; 2], y: f32, from_above: bool) -> Vec<Quad> {
    vec![
        plate([x[0], hole_x[0]], z, y, from_above),
        plate([hole_x[1], x[1]], z, y, from_above),
        plate(hole_x, [z[0], hole_z[0]], y, from_above),
        plate(hole_x, [hole_z[1], z[1]], y, from_above),
    ]
}

/// Four walls, seen from within or from outside.
fn walls([x0, x1]: Span, [z0, z1]: Span, [y0, y1]: Span, from_within: bool) -> Vec<Quad> {
    let mut quads = vec![
        [[x0, y0, z0], [x1, y0, z0], [x1, y1, z0], [x0, y1, z0]],
        [[x1, y0, z1], [x0, y0, z1], [x0, y1, z1], [x1, y1, z1]],
        [[x0, y0, z1], [x0, y0, z0], [x0, y1, z0], [x0, y1, z1]],
        [[x1, y0, z0], [x1, y0, z1], [x1, y1, z1], [x1, y1, z0]],
    ];
    if !from_within {
        quads.iter_mut().for_each(|quad| quad.reverse());
    }
    quads
}

/// Adds a room with what it is made of below it, and perhaps more.
fn room(file: &mut File, name: &str, quads: &[Quad]) -> usize {
    let mesh = mesh(file, quads);
    let walls = file.node(json!({ "name": format!("{name}.walls"), "mesh": mesh }));
    file.node(json!({ "name": format!("{name}-room"), "children": [walls] }))
}

fn mesh(file: &mut File, quads: &[Quad]) -> usize {
    let corners: Vec<[f32; 3]> = quads.iter().flatten().copied().collect();
    let indices: Vec<u16> = (0..quads.len() as u16)
        .flat_map(|quad| [0, 1, 2, 0, 2, 3].map(|corner| 4 * quad + corner))
        .collect();
    let primitive = file.primitive(&corners, &indices);
    file.mesh(json!([primitive]))
}

/// Adds a horizontal portal: Blender's plane, rotated from z up to y up.
fn hatch(file: &mut File, name: &str, at: [f64; 3], size: f64) -> usize {
    let turn = 0.5_f64.sqrt();
    file.node(json!({
        "name": name, "mesh": 1, "translation": at, "rotation": [-turn, 0.0, 0.0, turn], "scale": [size, size, 1.0]
    }))
}

const HOUSE: Span = [-2.0, 2.0];
const HOLE: [Span; 2] = [[-0.5, 0.5]; 2];

/// An attic with a roof window of side 1 that looks straight up, 3.1 above the ground of a garden that is flat.
fn roof_window() -> File {
    let mut file = house(json!([]));
    attic(&mut file);
    garden(&mut file, "Garden", [-15.0, 15.0]);
    hatch(&mut file, "Skylight-portal", [0.0, 3.1, 0.0], 1.0);
    file
}

fn attic(file: &mut File) {
    let mut quads = walls(HOUSE, HOUSE, [0.0, 3.0], true);
    quads.push(plate(HOUSE, HOUSE, 0.0, true));
    quads.extend(frame(HOUSE, HOUSE, HOLE, 3.0, false));
    room(file, "Attic", &quads);
}

/// A garden with the outside of the house in it.
fn garden(file: &mut File, name: &str, span: Span) {
    let outer = [-2.2, 2.2];
    let mut quads = walls(outer, outer, [0.0, 3.2], false);
    quads.extend(frame(span, span, [outer; 2], 0.0, true));
    quads.extend(frame(outer, outer, HOLE, 3.2, true));
    room(file, name, &quads);
}

/// A court with walls 3 high, in a garden, and a portal as large as its open top, unless it has another size.
fn courtyard(portal: f64) -> File {
    let mut file = house(json!([]));
    let mut quads = walls([-3.0, 3.0], [-3.0, 3.0], [0.0, 3.0], true);
    quads.push(plate([-3.0, 3.0], [-3.0, 3.0], 0.0, true));
    room(&mut file, "Court", &quads);
    let outer = [-3.5, 3.5];
    let mut quads = walls(outer, outer, [0.0, 3.0], false);
    quads.extend(frame([-20.0, 20.0], [-20.0, 20.0], [outer; 2], 0.0, true));
    quads.extend(frame(outer, outer, [[-3.0, 3.0]; 2], 3.0, true));
    room(&mut file, "Garden", &quads);
    if portal > 0.0 {
        hatch(&mut file, "Top-portal", [0.0, 3.0, 0.0], portal);
    }
    file
}

/// A bedroom whose floor is 4 above a flat garden, with a door to a balcony; who owns the balcony differs.
fn balcony(is_of_the_garden: bool) -> File {
    let mut file = house(json!([]));
    let (high, gap) = ([4.0, 7.0], [4.0, 6.0]);
    let mut quads = walls(HOUSE, HOUSE, high, true);
    quads.pop();
    quads.push(plate(HOUSE, HOUSE, 4.0, true));
    quads.push(plate(HOUSE, HOUSE, 7.0, false));
    // What is left of the wall with the door: its front to the room.
    let inner = |z: Span, y: Span| {
        [
            [2.0, y[0], z[0]],
            [2.0, y[0], z[1]],
            [2.0, y[1], z[1]],
            [2.0, y[1], z[0]],
        ]
    };
    quads.extend([
        inner([-2.0, -0.5], high),
        inner([0.5, 2.0], high),
        inner([-0.5, 0.5], [gap[1], high[1]]),
    ]);
    let slab = plate([2.2, 4.0], [-1.5, 1.5], 4.0, true);
    let outer = [-2.2, 2.2];
    let mut outside = walls(outer, outer, [0.0, 7.2], false);
    outside.pop();
    outside.push(plate(outer, outer, 7.2, true));
    let facade = |z: Span, y: Span| {
        let mut quad = inner(z, y).map(|[_, y, z]| [2.2, y, z]);
        quad.reverse();
        quad
    };
    outside.extend([
        facade([-2.2, -0.5], [0.0, 7.2]),
        facade([0.5, 2.2], [0.0, 7.2]),
        facade([-0.5, 0.5], [gap[1], 7.2]),
        facade([-0.5, 0.5], [0.0, gap[0]]),
    ]);
    outside.push(plate([-15.0, 15.0], [-15.0, 15.0], 0.0, true));
    if is_of_the_garden {
        outside.push(slab);
    } else {
        quads.push(slab);
    }
    room(&mut file, "Bedroom", &quads);
    room(&mut file, "Garden", &outside);
    let turn = 0.5_f64.sqrt();
    file.node(json!({
        "name": "Balcony-portal", "mesh": 1, "translation": [2.1, 5.0, 0.0], "rotation": [0.0, turn, 0.0, turn],
        "scale": [1.0, 2.0, 1.0]
    }));
    file
}

fn scene(import: &Import) -> Scene {
    let scene = import.scene(Method::HierarchicalZ, Method::DEFAULT_LIMIT);
    scene.expect("it is sound")
}

fn both_ways(name: &str, a: &str, b: &str) -> [String; 2] {
    [format!("{name}: {a} -> {b}"), format!("{name}: {b} -> {a}")]
}

/// The rooms without a top, by their names.
fn open_above(import: &Import) -> Vec<&str> {
    let open = import.rooms.iter().filter(|room| room.open_above);
    open.map(|room| &*room.name).collect()
}

/// The name of the room in which an eye is that looks down.
fn room_at(scene: &Scene, eye: [f32; 3]) -> &str {
    let toward = [eye[0], eye[1] - 1.0, eye[2]];
    scene.sector_name(scene.locate(eye, toward).expect("there are rooms"))
}

/// Through every portal, and from these eyes toward a point, every method computes the same visibility as the
/// reference.
#[track_caller]
fn nothing_is_missed(scene: &Scene, views: &[([f32; 3], [f32; 3])]) {
    let mut contestants = Contestants::new(scene, Limits::default(), Method::DEFAULT_LIMIT);
    let portals = (0..scene.portals().len() as u32).map(PortalId);
    let through = portals.flat_map(|portal| views_through(scene, portal, [16, 12]));
    let own = views
        .iter()
        .map(|&(eye, toward)| View::new(eye, toward, [48, 36]).expect("a valid view"));
    let mut visible = 0;
    for view in through.collect::<Vec<_>>().into_iter().chain(own) {
        let (items, broken) = contestants.check(&view);
        let broken: Vec<String> = broken.iter().map(ToString::to_string).collect();
        assert!(broken.is_empty(), "{view:?}:\n{}", broken.join("\n"));
        visible += items;
    }
    assert!(visible > 30, "{visible}");
}

/// Both rooms are seen from an eye.
#[track_caller]
fn sees_two_rooms(scene: &Scene, eye: [f32; 3], toward: [f32; 3]) {
    let mut viewer = enfilade::Viewer::new();
    viewer.look(scene, &View::new(eye, toward, [96, 72]).expect("a valid view"));
    assert_eq!(viewer.visible().passages().len(), 2, "from {eye:?}");
}

#[test]
fn a_roof_window_leads_from_the_attic_into_the_garden_below_it() {
    let import = reads(&roof_window());
    assert_eq!(
        ways(&import),
        both_ways("Skylight-portal", "Garden-room", "Attic-room")
    );
    assert_eq!(open_above(&import), ["Garden-room"]);
    let scene = scene(&import);
    for (eye, room) in [
        ([0.0, 1.5, 0.0], "Attic-room"),
        ([0.0, 4.0, 0.0], "Garden-room"),
        ([1.5, 90.0, 1.5], "Garden-room"),
        ([9.0, 1.5, 9.0], "Garden-room"),
    ] {
        assert_eq!(room_at(&scene, eye), room, "{eye:?}");
    }
    sees_two_rooms(&scene, [0.3, 6.0, 0.2], [0.0, 0.0, 0.0]);
    nothing_is_missed(
        &scene,
        &[
            ([0.3, 6.0, 0.2], [0.0, 0.0, 0.0]),
            ([0.1, 3.3, 0.2], [1.0, 0.0, 1.0]),
            ([3.0, 30.0, 3.0], [0.0, 0.0, 0.0]),
            ([0.2, 1.0, 0.3], [0.0, 9.0, 0.0]),
        ],
    );
}

#[test]
fn the_open_top_of_a_courtyard_leads_into_the_garden_around_it() {
    let import = reads(&courtyard(6.0));
    assert_eq!(
        ways(&import),
        both_ways("Top-portal", "Garden-room", "Court-room")
    );
    // The space above the portal belongs to the garden.
    assert_eq!(open_above(&import), ["Garden-room"]);
    let scene = scene(&import);
    assert_eq!(room_at(&scene, [0.0, 1.0, 0.0]), "Court-room");
    assert_eq!(room_at(&scene, [0.0, 5.0, 0.0]), "Garden-room");
    sees_two_rooms(&scene, [4.0, 8.0, 4.0], [0.0, 0.0, 0.0]);
    nothing_is_missed(
        &scene,
        &[
            ([4.0, 8.0, 4.0], [0.0, 0.0, 0.0]),
            ([0.0, 3.2, 0.0], [9.0, 0.0, 9.0]),
            ([2.0, 1.0, 2.0], [-3.0, 3.0, -3.0]),
        ],
    );
    // Without a portal the court has no ceiling.
    let import = reads(&courtyard(0.0));
    assert_eq!(open_above(&import), ["Court-room", "Garden-room"]);
    assert_eq!(room_at(&self::scene(&import), [0.0, 5.0, 0.0]), "Court-room");
}

#[test]
fn a_door_to_a_balcony_leads_into_the_garden_whoever_owns_the_balcony() {
    for is_of_the_garden in [true, false] {
        let import = reads(&balcony(is_of_the_garden));
        let expected = both_ways("Balcony-portal", "Garden-room", "Bedroom-room");
        let mut found = ways(&import);
        found.sort();
        let mut expected = expected.to_vec();
        expected.sort();
        assert_eq!(found, expected, "{is_of_the_garden}");
        assert_eq!(open_above(&import), ["Garden-room"], "{is_of_the_garden}");
        let scene = scene(&import);
        if is_of_the_garden {
            assert_eq!(room_at(&scene, [3.0, 5.6, 0.0]), "Garden-room");
        }
        assert_eq!(room_at(&scene, [0.0, 5.6, 0.0]), "Bedroom-room");
        assert_eq!(room_at(&scene, [3.0, 8.6, 0.0]), "Garden-room");
        sees_two_rooms(&scene, [8.0, 5.6, 0.0], [0.0, 5.0, 0.0]);
        nothing_is_missed(
            &scene,
            &[
                ([3.5, 5.6, 0.5], [0.0, 5.0, 0.0]),
                ([0.0, 5.6, 0.5], [9.0, 4.0, 0.0]),
                ([3.5, 9.6, 0.5], [0.0, 5.0, 0.0]),
            ],
        );
    }
}

#[test]
fn of_several_outdoor_rooms_below_a_window_the_smallest_has_it() {
    let mut file = house(json!([]));
    attic(&mut file);
    // The park's ground is below the garden's, and goes on around it.
    room(
        &mut file,
        "Park",
        &[plate([-40.0, 40.0], [-40.0, 40.0], -0.5, true)],
    );
    garden(&mut file, "Garden", [-15.0, 15.0]);
    hatch(&mut file, "Skylight-portal", [0.0, 3.1, 0.0], 1.0);
    let import = reads(&file);
    assert_eq!(
        ways(&import),
        both_ways("Skylight-portal", "Garden-room", "Attic-room")
    );
    assert_eq!(open_above(&import), ["Park-room", "Garden-room"]);
    let scene = scene(&import);
    assert_eq!(room_at(&scene, [9.0, 20.0, 9.0]), "Garden-room");
    assert_eq!(room_at(&scene, [30.0, 20.0, 9.0]), "Park-room");
}

#[test]
fn a_sky_that_is_a_room_of_its_own_is_behind_a_window_that_looks_up() {
    let mut file = house(json!([]));
    attic(&mut file);
    let far = [-90.0, 90.0];
    let mut sky = walls(far, far, [-1.0, 60.0], true);
    sky.push(plate(far, far, 60.0, false));
    sky.push(plate(far, far, -1.0, true));
    room(&mut file, "Sky", &sky);
    hatch(&mut file, "Skylight-portal", [0.0, 3.1, 0.0], 1.0);
    let import = reads(&file);
    assert_eq!(
        ways(&import),
        both_ways("Skylight-portal", "Sky-room", "Attic-room")
    );
    assert!(open_above(&import).is_empty());
    assert_eq!(room_at(&scene(&import), [0.0, 5.0, 0.0]), "Sky-room");
}

#[test]
fn cameras_above_a_garden_are_in_it() {
    let mut file = roof_window();
    file.json["cameras"] = json!([
        { "type": "orthographic", "orthographic": { "xmag": 5, "ymag": 5, "znear": 0.1, "zfar": 50 } }
    ]);
    file.node(json!({ "name": "Drone", "camera": 0, "translation": [0.0, 25.0, 0.0] }));
    let import = reads(&file);
    assert_eq!(import.cameras[0].sector, Some(SectorId(1)));
}

#[test]
fn an_opening_to_a_sky_that_is_nobodys_says_what_is_missing() {
    let mut file = house(json!([]));
    attic(&mut file);
    room(
        &mut file,
        "Shed",
        &walls([30.0, 32.0], [0.0, 2.0], [0.0, 2.0], true),
    );
    hatch(&mut file, "Skylight-portal", [0.0, 3.1, 0.0], 1.0);
    let words = [
        "\"Skylight-portal\" touches only one room, node 1 \"Attic-room\"",
        "no room that is open above",
        "Extend the ground",
        "`to`",
    ];
    refuses(&file, &words);
    // A garden that does not extend below the window is none for it.
    let ground = plate([20.0, 50.0], [-9.0, 9.0], 0.0, true);
    room(&mut file, "Garden", &[ground]);
    refuses(&file, &words);
    // The author's `to` still takes precedence.
    let portal = file.json["nodes"].as_array().expect("a list").iter();
    let portal = portal.clone().position(|node| node["name"] == "Skylight-portal");
    file.json["nodes"][portal.expect("it is there")]["extras"] =
        json!({ "enfilade": { "to": "Garden-room" } });
    assert_eq!(reads(&file).portals.len(), 2);
}

#[test]
fn a_portal_in_a_top_that_is_open_around_it_says_that_the_room_has_none() {
    let words = [
        "\"Top-portal\"",
        "\"Court-room\" has no ceiling",
        "as large as the open top",
    ];
    refuses(&courtyard(1.0), &words);
    // Skipped, it does not close the court either.
    let skipping = ReadOptions {
        skip_bad_portals: true,
        ..ReadOptions::default()
    };
    let import = read_bytes(&courtyard(1.0).glb(), None, &skipping).expect("it is tolerated");
    assert_eq!(open_above(&import), ["Court-room", "Garden-room"]);
    assert_eq!(import.portals.len(), 0);
}

#[test]
fn a_portal_in_mid_air_says_that_both_sides_are_sky() {
    let mut file = roof_window();
    file.node(json!({ "name": "Lost-portal", "mesh": 1, "translation": [6, 200, 6] }));
    refuses(
        &file,
        &[
            "\"Lost-portal\"",
            "touches only one room, node 3 \"Garden-room\"",
            "only the open sky above it on both sides",
            "remove it",
        ],
    );
}

#[test]
fn a_room_with_a_ceiling_has_a_top_however_it_is_modelled() {
    let span = [-5.0, 5.0];
    let closed = |quads: Vec<Quad>, is_double_sided: bool| {
        let mut file = house(json!([]));
        room(&mut file, "Hall", &quads);
        room(&mut file, "Yard", &[plate([20.0, 30.0], span, 0.0, true)]);
        if is_double_sided {
            file.json["materials"] = json!([{ "doubleSided": true }]);
            for mesh in file.json["meshes"].as_array_mut().expect("a list") {
                mesh["primitives"][0]["material"] = json!(0);
            }
        }
        assert_eq!(
            open_above(&reads(&file)),
            ["Yard-room"],
            "double-sided: {is_double_sided}"
        );
    };
    for is_double_sided in [false, true] {
        let floor = plate(span, span, 0.0, true);
        let mut thin = walls(span, span, [0.0, 3.0], true);
        thin.extend([floor, plate(span, span, 3.0, false)]);
        closed(thin.clone(), is_double_sided);
        // With a roof that is seen from above, too.
        thin.push(plate(span, span, 3.4, true));
        closed(thin, is_double_sided);
        // A cube that was never turned inside out.
        let mut cube = walls(span, span, [0.0, 3.0], false);
        cube.extend([plate(span, span, 3.0, true), plate(span, span, 0.0, false)]);
        closed(cube, is_double_sided);
    }
}

#[test]
fn ground_may_be_a_slab_with_things_on_it() {
    let mut file = house(json!([]));
    let span = [-10.0, 10.0];
    let mut quads = walls(span, span, [-0.3, 0.0], false);
    quads.extend([plate(span, span, 0.0, true), plate(span, span, -0.3, false)]);
    // A shed, a pergola over a third of it, and a pond over its bed.
    quads.extend(walls([4.0, 8.0], [4.0, 8.0], [0.0, 3.0], false));
    quads.push(plate([4.0, 8.0], [4.0, 8.0], 3.0, true));
    quads.push(plate([-10.0, -4.0], span, 2.5, false));
    quads.push(plate([0.0, 3.0], [0.0, 3.0], 0.02, true));
    room(&mut file, "Garden", &quads);
    room(
        &mut file,
        "Cellar",
        &walls([0.0, 2.0], [0.0, 2.0], [-3.0, -1.0], true),
    );
    let import = reads(&file);
    assert_eq!(open_above(&import), ["Garden-room"]);
}
