//! Lamps, spots and suns: how bright, how far, which way, and in which room.

use super::file::{File, reads, refusal, warnings};
use enfilade::{Light, LightShape, Method, SectorId};
use enfilade_import::Import;
use serde_json::{Value, json};
use std::f32::consts::PI;

/// A leaf and a node with a light.
fn lit(light: Value, node: Value) -> File {
    let mut file = File::leaf();
    file.json["extensions"] = json!({ "KHR_lights_punctual": { "lights": [light] } });
    add(&mut file, node);
    file
}

fn add(file: &mut File, mut node: Value) -> usize {
    node["extensions"] = json!({ "KHR_lights_punctual": { "light": 0 } });
    file.node(node)
}

fn only(import: &Import) -> Light {
    assert_eq!(warnings(import), [""; 0]);
    assert_eq!(import.lights.len(), 1);
    // A scene takes them, too.
    import.scene(Method::ZBuffer, 1 << 30).expect("a sound light");
    import.lights[0]
}

fn is_near(found: [f32; 3], expected: [f32; 3]) -> bool {
    (0..3).all(|axis| (found[axis] - expected[axis]).abs() < 1e-5)
}

#[test]
fn a_lamp_shines_from_its_node_as_brightly_as_the_file_says() {
    let node = json!({ "translation": [1, 2, 3], "scale": [5, 5, 5] });
    let import = reads(&lit(
        json!({ "type": "point", "color": [1, 0.5, 0], "intensity": 20, "range": 7 }),
        node.clone(),
    ));
    let light = only(&import);
    assert_eq!(light.shape, LightShape::Point);
    assert_eq!((light.position, light.range), ([1.0, 2.0, 3.0], 7.0));
    assert!(is_near(light.color, [20.0 / PI, 10.0 / PI, 0.0]), "{light:?}");
    let plain = only(&reads(&lit(json!({ "type": "point" }), node)));
    assert_eq!(plain.range, f32::INFINITY);
    assert!(is_near(plain.color, [1.0 / PI; 3]));
}

#[test]
fn spots_and_suns_shine_along_the_node_whatever_its_scale() {
    let half = std::f64::consts::FRAC_1_SQRT_2;
    // A quarter turn about x: what went along −z goes down… up, by the right hand.
    let up = json!({ "rotation": [half, 0, 0, half], "scale": [3, 0.5, 2] });
    let sun = only(&reads(&lit(json!({ "type": "directional" }), up.clone())));
    let LightShape::Sun { direction } = sun.shape else {
        panic!("{sun:?}")
    };
    assert!(is_near(direction, [0.0, 1.0, 0.0]), "{direction:?}");
    let cone = json!({ "innerConeAngle": 0.2, "outerConeAngle": 0.6 });
    let spot = only(&reads(&lit(json!({ "type": "spot", "spot": cone }), up)));
    let LightShape::Spot {
        direction,
        inner,
        outer,
    } = spot.shape
    else {
        panic!("{spot:?}")
    };
    assert!(is_near(direction, [0.0, 1.0, 0.0]));
    assert_eq!((inner, outer), (0.2, 0.6));
    let usual = only(&reads(&lit(json!({ "type": "spot" }), json!({}))));
    let LightShape::Spot {
        direction,
        inner,
        outer,
    } = usual.shape
    else {
        panic!("{usual:?}")
    };
    assert!(is_near(direction, [0.0, 0.0, -1.0]));
    assert_eq!((inner, outer), (0.0, PI / 4.0));
}

#[test]
fn a_cone_with_a_hard_edge_is_one() {
    let cone = json!({ "innerConeAngle": 0.6, "outerConeAngle": 0.6 });
    let spot = only(&reads(&lit(json!({ "type": "spot", "spot": cone }), json!({}))));
    let LightShape::Spot { inner, outer, .. } = spot.shape else {
        panic!("{spot:?}")
    };
    assert!(inner < outer && outer == 0.6 && outer - inner < 1e-6);
}

#[test]
fn lights_that_can_light_nothing_are_left_out_and_named() {
    let cone = |inner: f64, outer: f64| json!({ "type": "spot", "spot": { "innerConeAngle": inner, "outerConeAngle": outer } });
    for light in [
        json!({ "type": "point", "range": -3 }),
        json!({ "type": "point", "range": 0 }),
        json!({ "type": "point", "intensity": 0 }),
        json!({ "type": "point", "intensity": -1 }),
        json!({ "type": "point", "intensity": 1e39 }),
        json!({ "type": "point", "color": [1, -1, 1] }),
        json!({ "type": "point", "color": [3e38, 3e38, 1], "intensity": 100 }),
        json!({ "type": "moon" }),
        cone(0.5, 0.4),
        cone(-0.1, 0.4),
        cone(0.0, 0.0),
        cone(0.0, 1.6),
    ] {
        let import = reads(&lit(light.clone(), json!({ "name": "Lamp" })));
        assert!(import.lights.is_empty(), "{light}");
        assert_eq!(
            warnings(&import),
            ["lights with an invalid color, range, cone or transform are ignored (node 1 \"Lamp\")"],
            "{light}"
        );
    }
    // Which way does a node point that has no size?
    let import = reads(&lit(
        json!({ "type": "directional" }),
        json!({ "scale": [0, 0, 0] }),
    ));
    assert!(import.lights.is_empty() && import.warnings.len() == 1);
}

#[test]
fn a_light_that_is_not_there_is_refused() {
    let mut file = lit(json!({ "type": "point" }), json!({ "name": "Lamp" }));
    file.json["nodes"][1]["extensions"]["KHR_lights_punctual"]["light"] = json!(7);
    let said = refusal(&file.glb()).expect("an error");
    assert!(
        said.contains("node 1 \"Lamp\" names light 7, but there are only 1"),
        "{said}"
    );
    file.json["extensions"] = json!(null);
    let said = refusal(&file.glb()).expect("an error");
    assert!(said.contains("names light 7, but there are only 0"), "{said}");
    file.json["extensions"] = json!({ "KHR_lights_punctual": { "lights": "many" } });
    let said = refusal(&file.glb()).expect("an error");
    assert!(
        said.contains("its JSON cannot be read: extensions.KHR_lights_punctual.lights: "),
        "{said}"
    );
    // Without a node that has a light, the list of lights is not read.
    file.json["nodes"][1]["extensions"] = json!(null);
    assert_eq!(refusal(&file.glb()), None);
}

/// A house of 20 around a room of 2, and something far away in no room.
fn house(light: Value, lamps: &[Value]) -> Import {
    let mut file = File::empty();
    file.json["extensions"] = json!({ "KHR_lights_punctual": { "lights": [light] } });
    let mut boxed = |size: f32| {
        let primitive = file.primitive(&[[-size; 3], [size; 3], [size, -size, 0.0]], &[0, 1, 2]);
        file.mesh(json!([primitive]))
    };
    let (large, small) = (boxed(10.0), boxed(1.0));
    let mut room = |name: &str, mesh: usize, x: f64| {
        let item = file.node(json!({ "mesh": mesh, "translation": [x, 0, 0] }));
        file.node(json!({ "name": name, "children": [item] }))
    };
    room("Hall-room", large, 0.0);
    room("Closet-room", small, 0.0);
    file.node(json!({ "name": "Stone", "mesh": small, "translation": [100, 0, 0] }));
    let numbers: Vec<usize> = lamps.iter().map(|lamp| add(&mut file, lamp.clone())).collect();
    // The last one is below the hall.
    let last = *numbers.last().expect("a lamp");
    let children = file.json["nodes"][1]["children"].as_array_mut();
    children.expect("a list").push(json!(last));
    reads(&file)
}

#[test]
fn a_light_stands_in_the_room_above_it_else_in_the_smallest_around_it() {
    let at = |x: f64| json!({ "translation": [x, 0, 0] });
    let lamps = [at(0.5), at(5.0), at(100.5), at(1000.0), at(0.5)];
    let rooms = |import: &Import| -> Vec<String> {
        let name = |light: &Light| import.rooms[light.sector.0 as usize].name.clone();
        import.lights.iter().map(name).collect()
    };
    let points = house(json!({ "type": "point" }), &lamps);
    assert_eq!(
        rooms(&points),
        ["Closet-room", "Hall-room", "scene", "scene", "Hall-room"]
    );
    // A sun stands outside, wherever its node is; below a room it is that room's.
    let suns = house(json!({ "type": "directional" }), &lamps);
    assert_eq!(rooms(&suns), ["scene", "scene", "scene", "scene", "Hall-room"]);
}

#[test]
fn where_all_is_in_rooms_a_sun_lights_the_largest() {
    let mut file = lit(json!({ "type": "directional" }), json!({}));
    let tree = file.node(json!({ "name": "Tree-room", "children": [0] }));
    let big = file.node(json!({ "mesh": 0, "scale": [9, 9, 9] }));
    file.node(json!({ "name": "Garden-room", "children": [big] }));
    let import = reads(&file);
    assert_eq!(import.rooms.len(), 2);
    // The leaf is flat, so both boxes have no volume; the lower number then.
    assert_eq!(only(&import).sector, SectorId(0));
    let primitive = file.primitive(&[[-50.0; 3], [50.0; 3], [50.0, -50.0, 0.0]], &[0, 1, 2]);
    let mesh = file.mesh(json!([primitive]));
    file.json["nodes"][big]["mesh"] = json!(mesh);
    let import = reads(&file);
    let room = import.lights[0].sector.0 as usize;
    assert_eq!(import.rooms[room].name, "Garden-room");
    assert_eq!(file.json["nodes"][tree]["name"], "Tree-room");
}
