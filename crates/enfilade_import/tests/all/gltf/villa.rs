//! A villa whose rooms and portals were authored in Blender, against what its maker says of them.

use enfilade::{Method, SectorId, Transform};
use enfilade_import::{ReadOptions, WarningKind, read};
use serde_json::Value;
use std::collections::{BTreeMap, BTreeSet};
use std::path::Path;

/// The ways through one opening, as (from, to, where it leads).
type Ways<'a> = BTreeMap<&'a str, Vec<(&'a str, &'a str, Transform)>>;

fn text(value: &Value) -> &str {
    value.as_str().expect("a text")
}

fn list(value: &Value) -> &[Value] {
    value.as_array().expect("a list")
}

fn point(value: &Value) -> [f32; 3] {
    let number = |value: &Value| value.as_f64().expect("a number") as f32;
    let numbers: Vec<f32> = list(value).iter().map(number).collect();
    numbers.try_into().expect("three")
}

#[test]
#[ignore = "needs ENFILADE_SCENES"]
fn a_villa_has_the_rooms_and_portals_that_its_maker_gave_it() {
    let folder = std::env::var_os("ENFILADE_SCENES").expect("ENFILADE_SCENES names a folder");
    let folder = Path::new(&folder);
    let truth = std::fs::read(folder.join("blender_villa.truth.json")).expect("the truth");
    let truth: Value = serde_json::from_slice(&truth).expect("JSON");
    let import = read(&folder.join("blender_villa.glb"), &ReadOptions::default())
        .unwrap_or_else(|error| panic!("{error}"));

    // Two original plants are at the origin, outside every room.
    let rooms: BTreeSet<&str> = list(&truth["rooms"])
        .iter()
        .map(|room| text(&room["name"]))
        .collect();
    let (stray, named): (Vec<_>, Vec<_>) = import.rooms.iter().partition(|room| room.name == "blender_villa");
    assert_eq!(
        named.iter().map(|room| &*room.name).collect::<BTreeSet<_>>(),
        rooms
    );
    assert_eq!(
        stray
            .iter()
            .map(|room| room.geometry.items().len())
            .collect::<Vec<_>>(),
        [2]
    );
    for room in list(&truth["rooms"]) {
        let found = named
            .iter()
            .find(|found| found.name == text(&room["name"]))
            .expect("it is there");
        let is_item = |name: &&Value| !text(name).ends_with("-portal") && !text(name).ends_with("-mirror");
        let names = list(&room["items"]).iter().filter(is_item);
        // 128 cells by 128 are 16 blocks, and each is an item.
        let items_of = |name: &Value| if text(name).ends_with("-terrain") { 16 } else { 1 };
        let items: usize = names.map(items_of).sum();
        assert_eq!(found.geometry.items().len(), items, "{}", found.name);
        let method = room["extras"]["method"].as_str().and_then(Method::by_name);
        assert_eq!(found.method, method, "{}", found.name);
    }

    let name = |id: SectorId| &*import.rooms[id.0 as usize].name;
    let mut ways: Ways = BTreeMap::new();
    for portal in &import.portals {
        let opening =
            &import.rooms[portal.from.0 as usize].geometry.openings()[usize::from(portal.opening.0)];
        let way = (name(portal.from), name(portal.to), portal.there_from_here);
        ways.entry(&opening.name).or_default().push(way);
        // The outline is that of the file, whichever way round.
        let known = list(&truth["portals"]).iter().chain(list(&truth["mirrors"]));
        let known = known.filter(|known| text(&known["name"]) == opening.name);
        let corners: Vec<[f32; 3]> = known
            .flat_map(|known| list(&known["corners"]))
            .map(point)
            .collect();
        for corner in opening.outline.corners() {
            let apart = |other: &[f32; 3]| {
                (0..3)
                    .map(|axis| (corner[axis] - other[axis]).abs())
                    .fold(0.0, f32::max)
            };
            assert!(
                corners.iter().any(|other| apart(other) < 1e-4),
                "{}: {corner:?}",
                opening.name
            );
        }
        assert_eq!(opening.outline.corners().len(), corners.len(), "{}", opening.name);
    }
    assert_eq!(
        ways.len(),
        list(&truth["portals"]).len() + list(&truth["mirrors"]).len()
    );
    for portal in list(&truth["portals"]) {
        let [a, b] = [0, 1].map(|side| text(&portal["rooms"][side]));
        let found = &ways[text(&portal["name"])];
        let ends: BTreeSet<(&str, &str)> = found.iter().map(|(from, to, _)| (*from, *to)).collect();
        if portal["exit"].is_null() {
            let expected = if portal["one_way"] == true {
                vec![(a, b)]
            } else {
                vec![(a, b), (b, a)]
            };
            assert_eq!(ends, expected.into_iter().collect(), "{}", portal["name"]);
            assert!(found.iter().all(|(.., leads)| *leads == Transform::IDENTITY));
        } else {
            assert_eq!(ends, BTreeSet::from([(a, b)]), "{}", portal["name"]);
            let rows = list(&portal["exit_from_portal_frames"]["there_from_here"]);
            let columns = found[0].2.columns();
            for (row, column) in (0..3).flat_map(|row| (0..4).map(move |column| (row, column))) {
                let expected = rows[row][column].as_f64().expect("a number") as f32;
                assert!(
                    (columns[column][row] - expected).abs() < 1e-4,
                    "row {row}, column {column}"
                );
            }
        }
    }
    for mirror in list(&truth["mirrors"]) {
        let [(from, to, leads)] = ways[text(&mirror["name"])][..] else {
            panic!("a mirror is one portal");
        };
        assert_eq!([from, to], [text(&mirror["room"]); 2]);
        assert!(leads.mirrors());
    }
    let odd = [
        WarningKind::EmptyRooms,
        WarningKind::OpeningsWithoutRooms,
        WarningKind::UnreadNotes,
    ];
    assert!(
        import.warnings.iter().all(|warning| !odd.contains(&warning.kind)),
        "{:?}",
        import.warnings
    );
}

#[test]
#[ignore = "needs ENFILADE_SCENES"]
fn a_villa_has_its_textures_and_its_lights_hang_in_their_rooms() {
    let folder = std::env::var_os("ENFILADE_SCENES").expect("ENFILADE_SCENES names a folder");
    let path = Path::new(&folder).join("blender_villa.glb");
    let import = read(&path, &ReadOptions::default()).unwrap_or_else(|error| panic!("{error}"));
    let textures = import.rooms[0].geometry.textures();
    // One more is a map of what is metal, which is not drawn.
    assert_eq!(textures.len(), 20);
    let mut names: Vec<&str> = textures.iter().map(|texture| &*texture.name).collect();
    assert!(names.contains(&"wood") && names.contains(&"stone"), "{names:?}");
    names.sort_unstable();
    names.dedup();
    assert_eq!(names.len(), 20, "each image is there once");
    let large = |texture: &std::sync::Arc<enfilade::Texture>| texture.size().iter().all(|&side| side >= 16);
    assert!(textures.iter().all(large));
    for room in &import.rooms {
        assert!(
            std::sync::Arc::ptr_eq(&textures[0], &room.geometry.textures()[0]),
            "texels are kept once"
        );
        let meshes = room.geometry.meshes().iter();
        for mesh in meshes.filter(|mesh| mesh.triangle_count() > 0) {
            assert_eq!(mesh.normals().len(), mesh.positions().len());
            let textured = mesh
                .clusters()
                .iter()
                .any(|cluster| room.geometry.material(cluster).texture.is_some());
            assert_eq!(textured, !mesh.texture().is_empty());
        }
    }

    // `Kitchen-spot` is below `Kitchen-room`; the sun is the garden's.
    let bytes = std::fs::read(&path).expect("the file");
    let end = 20 + u32::from_le_bytes(bytes[12..16].try_into().expect("four bytes")) as usize;
    let document: Value = serde_json::from_slice(&bytes[20..end]).expect("JSON");
    let lamps = list(&document["nodes"])
        .iter()
        .filter(|node| !node["extensions"]["KHR_lights_punctual"].is_null());
    let lamps: Vec<&str> = lamps.map(|node| text(&node["name"])).collect();
    assert_eq!((lamps.len(), import.lights.len()), (11, 11));
    for (lamp, light) in lamps.iter().zip(&import.lights) {
        let room = &*import.rooms[light.sector.0 as usize].name;
        let expected = match lamp.split_once('-') {
            Some((room, _)) => format!("{room}-room"),
            None => "Garden-room".to_owned(),
        };
        assert_eq!(room, expected, "{lamp}");
        let bounds = import.rooms[light.sector.0 as usize].geometry.bounds();
        assert!(*lamp == "Sun" || bounds.contains(light.position), "{lamp}");
    }
    assert_eq!(import.cameras.len(), 4);
    let left_out: Vec<WarningKind> = import.warnings.iter().map(|warning| warning.kind).collect();
    assert_eq!(left_out, [WarningKind::InNoRoom, WarningKind::OtherMaps]);
}
