//! Rooms, portals and mirrors that authors marked, by names and by extras.

use super::file::{File, reads, warnings};
use enfilade::{ItemIndex, Method, Portal, SectorId};
use enfilade_import::{Import, ReadOptions, read_bytes};
use serde_json::{Value, json};

/// Nodes over three meshes: 0 is a box from (-1, -1, -1) to (1, 1, 1) whose walls are seen from inside, 1 a square of side 1
/// in the plane z = 0, front toward +z, and 2 a triangle.
pub(crate) fn house(nodes: Value) -> File {
    let mut file = File::empty();
    let corner = |i: u8| [0, 1, 2].map(|axis| if i >> axis & 1 == 1 { 1.0_f32 } else { -1.0 });
    let corners: Vec<[f32; 3]> = (0..8).map(corner).collect();
    let walls = [
        [0, 2, 6, 4],
        [1, 5, 7, 3],
        [0, 4, 5, 1],
        [2, 3, 7, 6],
        [0, 1, 3, 2],
        [4, 6, 7, 5],
    ];
    let indices: Vec<u16> = walls
        .iter()
        .flat_map(|&[a, b, c, d]| [a, b, c, a, c, d])
        .collect();
    let walls = file.primitive(&corners, &indices);
    let square = [
        [-0.5, -0.5, 0.0],
        [0.5, -0.5, 0.0],
        [0.5, 0.5, 0.0],
        [-0.5, 0.5, 0.0],
    ];
    let square = file.primitive(&square, &[0, 1, 2, 0, 2, 3]);
    let leaf = file.primitive(&[[0.0; 3], [0.2, 0.0, 0.0], [0.0, 0.2, 0.0]], &[0, 1, 2]);
    for primitive in [walls, square, leaf] {
        file.mesh(json!([primitive]));
    }
    file.json["nodes"] = nodes;
    file
}

/// Two rooms side by side, A from x = -2 to 0 and B from 0 to 2, with their walls below them, and more nodes after.
pub(crate) fn two_rooms(more: &[Value]) -> File {
    let mut nodes = vec![
        json!({ "name": "A-room", "children": [1], "translation": [-1, 0, 0] }),
        json!({ "name": "A-walls", "mesh": 0 }),
        json!({ "name": "B-room", "children": [3], "translation": [1, 0, 0] }),
        json!({ "name": "B-walls", "mesh": 0 }),
    ];
    nodes.extend_from_slice(more);
    house(json!(nodes))
}

/// The square, standing in the plane x = 0 with its front toward -x.
pub(crate) fn door(name: &str, enfilade: Value) -> Value {
    let turn = [0.0, -(0.5_f64.sqrt()), 0.0, 0.5_f64.sqrt()];
    let mut node = json!({ "name": name, "mesh": 1, "rotation": turn });
    if !enfilade.is_null() {
        node["extras"] = json!({ "enfilade": enfilade });
    }
    node
}

/// Every portal as `NAME: FROM -> TO`, in order.
pub(crate) fn ways(import: &Import) -> Vec<String> {
    let room = |id: SectorId| &import.rooms[id.0 as usize];
    let way = |portal: &Portal| {
        let opening = &room(portal.from).geometry.openings()[usize::from(portal.opening.0)];
        format!(
            "{}: {} -> {}",
            opening.name,
            room(portal.from).name,
            room(portal.to).name
        )
    };
    import.portals.iter().map(way).collect()
}

fn items(import: &Import, room: usize) -> Vec<&str> {
    let geometry = &import.rooms[room].geometry;
    (0..geometry.items().len() as u32)
        .map(|item| geometry.name(ItemIndex(item)))
        .collect()
}

#[test]
fn the_nearest_room_above_a_node_has_it() {
    let import = reads(&house(json!([
        { "name": "Hall-room.001", "mesh": 0, "children": [1, 2], "scale": [5, 5, 5] },
        { "name": "lamp", "mesh": 2 },
        { "name": "closet", "extras": { "enfilade": { "kind": "room", "method": "bsp" } }, "children": [3] },
        { "name": "broom", "mesh": 2 },
        { "name": "moon", "mesh": 2 },
        { "name": "sun", "mesh": 2 },
    ])));
    let names: Vec<&str> = import.rooms.iter().map(|room| &*room.name).collect();
    assert_eq!(names, ["Hall-room.001", "closet", "scene"]);
    assert_eq!(items(&import, 0), ["Hall-room.001", "lamp"]);
    assert_eq!(items(&import, 1), ["broom"]);
    assert_eq!(items(&import, 2), ["moon", "sun"]);
    let methods: Vec<Option<Method>> = import.rooms.iter().map(|room| room.method).collect();
    assert_eq!(
        methods,
        [None, Some(Method::by_name("bsp").expect("a method")), None]
    );
    assert_eq!(
        warnings(&import),
        [
            "nodes outside every room and not reachable through a portal; visible only from inside that space (node 4 \"moon\", node 5 \"sun\")"
        ]
    );
}

#[test]
fn a_room_that_says_it_is_a_convex_cell_is_held_to_it() {
    let mut file = two_rooms(&[
        door("Door-portal", Value::Null),
        json!({ "name": "broom", "mesh": 2 }),
    ]);
    file.json["nodes"][0]["extras"] = json!({ "enfilade": { "kind": "room", "method": "cell" } });
    let scene = |file: &File| reads(file).scene(Method::ZBuffer, Method::DEFAULT_LIMIT);
    let scene_of_cells = scene(&file).expect("a box with a door is convex");
    assert_eq!(scene_of_cells.method(SectorId(0)), Some(Method::Cell));
    file.json["nodes"][0]["children"] = json!([1, 5]);
    let why = scene(&file).err().expect("a broom stands in it").to_string();
    assert!(
        why.starts_with("sector `A-room`: method cell needs a convex sector"),
        "{why}"
    );
    assert!(why.contains("`broom`"), "{why}");
}

#[test]
fn a_portal_joins_the_two_rooms_at_its_sides() {
    for (name, extras) in [
        ("Door-portal", Value::Null),
        ("Door-portal.001", Value::Null),
        ("Door", json!({ "kind": "portal" })),
        ("Door-portal", json!({ "to": "B-room" })),
        ("Door-portal", json!({ "one_way": false })),
        ("Door-portal", json!({ "one_way": 0 })),
    ] {
        let mut file = two_rooms(&[door(name, extras.clone())]);
        file.json["nodes"][0]["children"] = json!([1, 4]);
        file.json["nodes"][4]["translation"] = json!([1, 0, 0]);
        let import = reads(&file);
        let expected = [
            format!("{name}: A-room -> B-room"),
            format!("{name}: B-room -> A-room"),
        ];
        assert_eq!(ways(&import), expected, "{name} {extras}");
        assert_eq!(items(&import, 0), ["A-walls"]);
        assert!(warnings(&import).is_empty());
        // One looks out of a room from the front of its opening.
        let normal = |room: usize| import.rooms[room].geometry.openings()[0].outline.normal()[0];
        assert_eq!([normal(0), normal(1)].map(f32::round), [-1.0, 1.0]);
    }
}

#[test]
fn a_one_way_portal_leads_out_of_the_room_it_belongs_to_or_into_the_one_it_names() {
    for (truth, to, owner, expected) in [
        (json!(true), Value::Null, 0, "Door-portal: A-room -> B-room"),
        (json!(1), Value::Null, 0, "Door-portal: A-room -> B-room"),
        (json!(1.0), Value::Null, 2, "Door-portal: B-room -> A-room"),
        (json!(true), json!("A-room"), 0, "Door-portal: B-room -> A-room"),
    ] {
        let mut file = two_rooms(&[door("Door-portal", json!({ "one_way": truth, "to": to }))]);
        file.json["nodes"][owner]["children"] = json!([owner + 1, 4]);
        file.json["nodes"][4]["translation"] = json!([if owner == 0 { 1 } else { -1 }, 0, 0]);
        let import = reads(&file);
        assert_eq!(ways(&import), [expected], "{truth} {to} {owner}");
        let facing = import.rooms[import.portals[0].from.0 as usize]
            .geometry
            .openings()[0]
            .outline
            .normal()[0];
        let out_of_a = import.portals[0].from == SectorId(0);
        assert_eq!(facing.round(), if out_of_a { -1.0 } else { 1.0 });
    }
}

#[test]
fn a_room_around_both_has_no_say_at_a_door_between_them() {
    // The garden's walls are far out, and its box holds both rooms.
    let import = reads(&two_rooms(&[
        door("Door-portal", Value::Null),
        json!({ "name": "Garden-room", "mesh": 0, "scale": [20, 20, 20] }),
        json!({ "name": "Window-portal", "mesh": 1, "translation": [-1, 0, 1] }),
    ]));
    assert_eq!(
        ways(&import),
        [
            "Door-portal: A-room -> B-room",
            "Door-portal: B-room -> A-room",
            "Window-portal: Garden-room -> A-room",
            "Window-portal: A-room -> Garden-room",
        ]
    );
}

#[test]
fn a_teleport_goes_in_along_minus_z_and_out_along_the_exits() {
    // In from A toward +x, whichever way its mesh is wound; out at (0, 0.5, 0) of B toward -z. Scales do not count.
    let teleport = |scale: [f64; 3]| {
        let mut node = door("Door-portal", json!({ "kind": "portal", "exit": "Out" }));
        node["scale"] = json!(scale);
        node["translation"] = json!([-0.1, 0, 0]);
        two_rooms(&[
            node,
            json!({ "name": "Out", "translation": [1, 0.5, 0], "scale": [3, 3, 3] }),
        ])
    };
    for scale in [[1.0, 1.0, 1.0], [0.5, 2.0, 1.0], [1.0, -1.0, 1.0]] {
        let import = reads(&teleport(scale));
        assert_eq!(ways(&import), ["Door-portal: A-room -> B-room"], "{scale:?}");
        let opening = &import.rooms[0].geometry.openings()[0];
        assert_eq!(opening.outline.normal()[0].round(), -1.0, "{scale:?}");
        if scale[1] > 0.0 {
            let out = import.portals[0].there_from_here.point([0.9, 0.0, 0.25]);
            let expected = [1.25, 0.5, -1.0];
            assert!(
                (0..3).all(|axis| (out[axis] - expected[axis]).abs() < 1e-5),
                "{out:?}"
            );
        }
    }
}

#[test]
fn a_teleport_with_a_scale_enlarges_what_passes() {
    let mut node = door(
        "Door-portal",
        json!({ "kind": "portal", "exit": "Out", "scale": 8 }),
    );
    node["translation"] = json!([-0.1, 0, 0]);
    let out = json!({ "name": "Out", "translation": [1, 0.5, 0], "scale": [3, 3, 3] });
    let import = reads(&two_rooms(&[node, out]));
    // A point a quarter aside of the door's middle and one ahead of it.
    let there = import.portals[0].there_from_here.point([0.9, 0.0, 0.25]);
    let expected = [3.0, 0.5, -8.0];
    assert!(
        (0..3).all(|axis| (there[axis] - expected[axis]).abs() < 1e-4),
        "{there:?}"
    );
    let scene = import.scene(Method::HierarchicalZ, Method::DEFAULT_LIMIT);
    assert!(scene.is_ok(), "a portal may scale");
}

#[test]
fn a_threshold_without_walls_is_named_by_its_parent_and_by_to() {
    // A floor and a ceiling between A and B, a tenth deep: rays from one door leave by the other.
    let mut file = two_rooms(&[]);
    let corners = [-0.5, 0.5].map(|y| [[0.0, y, -0.5], [0.0, y, 0.5], [0.1, y, 0.5], [0.1, y, -0.5]]);
    let floor = file.primitive(corners.as_flattened(), &[0, 1, 2, 0, 2, 3, 4, 6, 5, 4, 7, 6]);
    let mesh = file.mesh(json!([floor]));
    let mut into = door("Into-portal", json!({ "kind": "portal", "to": "Sill-room" }));
    let mut out = door("Out-portal", json!({ "kind": "portal", "to": "B-room" }));
    (into["translation"], out["translation"]) = (json!([1, 0, 0]), json!([0.1, 0, 0]));
    let nodes = json!([
        { "name": "A-room", "children": [1, 2], "translation": [-1, 0, 0] },
        { "name": "A-walls", "mesh": 0 },
        into,
        { "name": "Sill-room", "children": [4, 5] },
        { "name": "Floor", "mesh": mesh },
        out,
        { "name": "B-room", "children": [7], "translation": [1.1, 0, 0] },
        { "name": "B-walls", "mesh": 0 },
    ]);
    file.json["nodes"] = nodes;
    assert_eq!(
        ways(&reads(&file)),
        [
            "Into-portal: A-room -> Sill-room",
            "Into-portal: Sill-room -> A-room",
            "Out-portal: Sill-room -> B-room",
            "Out-portal: B-room -> Sill-room",
        ]
    );
}

#[test]
fn a_mirror_shows_its_room_from_the_side_that_is_free() {
    // Both hang at the wall x = -2 of room A, one with its front to the wall.
    for turn in [0.5_f64.sqrt(), -(0.5_f64.sqrt())] {
        let mirror = json!({
            "name": "Pier-mirror", "mesh": 1, "translation": [-1.99, 0, 0], "rotation": [0.0, turn, 0.0, 0.5_f64.sqrt()]
        });
        let import = reads(&two_rooms(&[mirror]));
        assert_eq!(ways(&import), ["Pier-mirror: A-room -> A-room"]);
        assert_eq!(
            import.rooms[0].geometry.openings()[0].outline.normal()[0].round(),
            1.0
        );
        let seen = import.portals[0].there_from_here.point([-0.99, 0.0, 0.0]);
        assert!((seen[0] + 2.99).abs() < 1e-5 && import.portals[0].there_from_here.mirrors());
        assert_eq!(items(&import, 0), ["A-walls"]);
    }
}

#[test]
fn a_file_read_as_flat_is_one_room_without_openings() {
    let file = two_rooms(&[
        door("Door-portal", Value::Null),
        json!({ "name": "Pier-mirror", "mesh": 1, "translation": [-1.99, 0, 0] }),
    ]);
    let flat = ReadOptions {
        flat: true,
        ..ReadOptions::default()
    };
    let import = read_bytes(&file.glb(), None, &flat).expect("it is sound");
    assert_eq!(import.rooms.len(), 1);
    assert_eq!(items(&import, 0), ["A-walls", "B-walls", "Pier-mirror"]);
    assert!(import.portals.is_empty() && import.rooms[0].geometry.openings().is_empty());
}

#[test]
fn without_rooms_nothing_is_an_opening() {
    let import = reads(&house(json!([
        { "name": "Hall", "mesh": 0 },
        { "name": "Door-portal", "mesh": 1 },
        { "name": "Car-mirror", "mesh": 0 },
    ])));
    assert_eq!(items(&import, 0), ["Hall", "Door-portal", "Car-mirror"]);
    assert_eq!(
        warnings(&import),
        [
            "nodes are named like portals or mirrors, but no node is a room (NAME-room): drawn as ordinary meshes (node 1 \"Door-portal\", node 2 \"Car-mirror\")"
        ]
    );
}

#[test]
fn what_is_odd_is_warned_of() {
    let import = reads(&two_rooms(&[
        json!({ "name": "C-room", "extras": { "enfilade": { "methd": "bsp" }, "other": 5 } }),
        json!({ "name": "lamp", "mesh": 2, "extras": { "enfilade": { "glow": 1 } }, "translation": [-1, 0, 0] }),
    ]));
    assert_eq!(
        warnings(&import),
        [
            "nodes outside every room and not reachable through a portal; visible only from inside that space (node 5 \"lamp\")",
            "rooms have nothing in them (node 4 \"C-room\")",
            "extras.enfilade has unknown keys, which are ignored (node 4 \"C-room\", node 5 \"lamp\")",
        ]
    );
}
