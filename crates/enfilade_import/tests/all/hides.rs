//! One rule for all readers: a surface hides others only if the file says for sure that it is opaque, that it is drawn, and where.
//!
//! Each row is a way in which a file can say that one of these is not so, or that it is: a wall between the eye and a crate.

use crate::gltf::file::File;
use enfilade::{Method, View, Viewer};
use enfilade_import::{Import, ReadOptions, read, read_bytes};
use serde_json::{Value, json};

/// The names of what is visible from the origin along −z.
fn visible(import: &Import) -> Vec<String> {
    visible_from(import, [0.0; 3], [0.0, 0.0, -1.0])
}

fn visible_from(import: &Import, eye: [f32; 3], toward: [f32; 3]) -> Vec<String> {
    let view = View::new(eye, toward, [64, 48]).expect("a view");
    let visible = |method| {
        let scene = import.scene(method, 1 << 30).expect("a scene");
        let mut viewer = Viewer::new();
        let set = viewer.look(&scene, &view);
        let mut found: Vec<String> = set.names(&scene).map(|name| name.to_string()).collect();
        found.sort();
        found
    };
    let exact = visible(Method::ZBuffer);
    for method in [Method::Masked, Method::HierarchicalZ, Method::Svbsp] {
        let found = visible(method);
        assert!(
            exact.iter().all(|name| found.contains(name)),
            "{method}: {found:?}, {exact:?}"
        );
    }
    exact
}

/// A quad of the given half size, which faces the origin.
fn quad(half: f32, z: f32) -> [[f32; 3]; 4] {
    [
        [-half, -half, z],
        [half, -half, z],
        [half, half, z],
        [-half, half, z],
    ]
}

/// Node 0 is a wall with material 0, node 1 a crate behind it.
fn gltf() -> File {
    let mut file = File::empty();
    for (name, half, z) in [("wall", 20.0, -5.0), ("crate", 1.0, -10.0)] {
        let mut primitive = file.primitive(&quad(half, z), &[0, 1, 2, 0, 2, 3]);
        if name == "wall" {
            primitive["material"] = json!(0);
        }
        let mesh = file.mesh(json!([primitive]));
        file.node(json!({ "name": name, "mesh": mesh }));
    }
    file.push("materials", json!({}));
    file
}

/// An animation of the translation of a node.
fn animation(file: &mut File, target: Value) {
    let [times, values] = [file.floats(&[0.0, 1.0], 1), file.floats(&[0.0; 6], 3)];
    let sampler = json!({ "input": times, "output": values });
    file.push(
        "animations",
        json!({ "samplers": [sampler], "channels": [{ "sampler": 0, "target": target }] }),
    );
}

fn skin(file: &mut File) {
    let joint = file.node(json!({ "name": "bone" }));
    let skin = file.push("skins", json!({ "joints": [joint] }));
    file.json["nodes"][0]["skin"] = json!(skin);
}

fn morph(file: &mut File) {
    let target = file.positions(&quad(0.0, 0.0));
    file.json["meshes"][0]["primitives"][0]["targets"] = json!([{ "POSITION": target }]);
}

fn extend(file: &mut File, list: &str, extension: &str, value: Value) {
    file.json[list][0]["extensions"] = json!({ extension: value });
}

type Row = (&'static str, bool, fn(&mut File));

const GLTF: &[Row] = &[
    ("nothing special", true, |_| {}),
    ("alphaMode MASK", false, |file| {
        file.json["materials"][0]["alphaMode"] = json!("MASK")
    }),
    ("alphaMode BLEND", false, |file| {
        file.json["materials"][0]["alphaMode"] = json!("BLEND")
    }),
    ("alpha of an opaque material", true, |file| {
        file.json["materials"][0]["pbrMetallicRoughness"] = json!({ "baseColorFactor": [1, 1, 1, 0.2] });
    }),
    ("transmission", false, |file| {
        extend(
            file,
            "materials",
            "KHR_materials_transmission",
            json!({ "transmissionFactor": 0.5 }),
        );
    }),
    ("volume", false, |file| {
        extend(file, "materials", "KHR_materials_volume", json!({}))
    }),
    ("diffuse transmission", false, |file| {
        extend(file, "materials", "KHR_materials_diffuse_transmission", json!({}));
    }),
    ("dispersion", false, |file| {
        extend(
            file,
            "materials",
            "KHR_materials_dispersion",
            json!({ "dispersion": 1 }),
        );
    }),
    ("clearcoat", true, |file| {
        extend(file, "materials", "KHR_materials_clearcoat", json!({}))
    }),
    ("unlit", true, |file| {
        extend(file, "materials", "KHR_materials_unlit", json!({}))
    }),
    ("variants that are opaque", true, |file| variants(file, json!({}))),
    ("a variant of glass", false, |file| {
        variants(file, json!({ "alphaMode": "BLEND" }))
    }),
    ("a skin", false, skin),
    ("morph targets", false, morph),
    ("an animated node", false, |file| {
        animation(file, json!({ "node": 0, "path": "translation" }))
    }),
    ("an animation of another node", true, |file| {
        animation(file, json!({ "node": 1, "path": "translation" }))
    }),
    ("an animated node above", false, |file| {
        let above = file.node(json!({ "children": [0] }));
        animation(file, json!({ "node": above, "path": "rotation" }));
    }),
    ("an animation of its visibility", false, |file| {
        let pointer = json!({ "pointer": "/nodes/0/extensions/KHR_node_visibility/visible" });
        animation(
            file,
            json!({ "path": "pointer", "extensions": { "KHR_animation_pointer": pointer } }),
        );
    }),
    ("an animation of its material", false, |file| {
        let pointer = json!({ "pointer": "/materials/0/pbrMetallicRoughness/baseColorFactor" });
        animation(
            file,
            json!({ "path": "pointer", "extensions": { "KHR_animation_pointer": pointer } }),
        );
    }),
    ("an invisible node", false, |file| {
        extend(file, "nodes", "KHR_node_visibility", json!({ "visible": false }));
    }),
    ("a visible node", true, |file| {
        extend(file, "nodes", "KHR_node_visibility", json!({ "visible": true }))
    }),
    ("an invisible node above", false, |file| {
        let above = json!({ "children": [0], "extensions": { "KHR_node_visibility": { "visible": false } } });
        file.node(above);
    }),
    ("levels of detail", false, |file| {
        let other = file.node(json!({ "name": "coarse" }));
        extend(file, "nodes", "MSFT_lod", json!({ "ids": [other] }));
    }),
    ("an author who says so", false, |file| {
        file.json["nodes"][0]["extras"] = json!({ "enfilade": { "occluder": false } })
    }),
    ("a node above of whom the author says so", false, |file| {
        file.node(json!({ "children": [0], "extras": { "enfilade": { "occluder": 0 } } }));
    }),
    ("an author who says that a skin does", true, |file| {
        skin(file);
        file.json["nodes"][0]["extras"] = json!({ "enfilade": { "occluder": true } });
    }),
    ("an author who says that glass does", false, |file| {
        file.json["materials"][0]["alphaMode"] = json!("BLEND");
        file.json["nodes"][0]["extras"] = json!({ "enfilade": { "occluder": true } });
    }),
];

fn variants(file: &mut File, material: Value) {
    let material = file.push("materials", material);
    let mappings = json!({ "mappings": [{ "material": material, "variants": [0] }] });
    file.json["meshes"][0]["primitives"][0]["extensions"] = json!({ "KHR_materials_variants": mappings });
}

#[test]
fn a_gltf_wall_hides_a_crate_only_if_it_is_opaque_and_drawn_where_it_is() {
    for (what, hides, change) in GLTF {
        let mut file = gltf();
        change(&mut file);
        let import = read_bytes(&file.glb(), None, &ReadOptions::default());
        let import = import.unwrap_or_else(|why| panic!("{what}: {why}"));
        let visible = visible(&import);
        assert_eq!(
            visible.contains(&"crate".to_owned()),
            !hides,
            "{what}: {visible:?}"
        );
        let is_drawn = !what.contains("invisible");
        assert_eq!(
            visible.contains(&"wall".to_owned()),
            is_drawn,
            "{what}: {visible:?}"
        );
    }
}

#[test]
fn extensions_that_change_no_shape_may_be_required() {
    let import = |extension: &str| {
        let mut file = gltf();
        file.json["extensionsUsed"] = json!([extension]);
        file.json["extensionsRequired"] = json!([extension]);
        read_bytes(&file.glb(), None, &ReadOptions::default())
    };
    for extension in [
        "EXT_mesh_features",
        "EXT_structural_metadata",
        "EXT_texture_avif",
        "EXT_texture_webp",
        "KHR_materials_clearcoat",
        "KHR_materials_ior",
        "KHR_materials_pbrSpecularGlossiness",
        "KHR_materials_variants",
        "KHR_texture_basisu",
        "KHR_xmp_json_ld",
        "MSFT_texture_dds",
    ] {
        let import = import(extension).unwrap_or_else(|why| panic!("{why}"));
        assert_eq!(visible(&import), ["wall"], "{extension}");
    }
    for (extension, remedy) in [
        ("KHR_draco_mesh_compression", "without compression"),
        ("KHR_gaussian_splatting", "its splats are lost"),
        ("EXT_implicit_ellipsoid_region", "its shapes are lost"),
        ("KHR_unheard_of", "export it again without"),
    ] {
        let why = import(extension).expect_err("a refusal").to_string();
        assert!(why.contains(extension) && why.contains(remedy), "{why}");
    }
}

#[test]
fn an_obj_wall_hides_a_crate_only_if_all_its_lines_say_that_it_is_opaque() {
    let folder = tempfile::tempdir().expect("a folder");
    let corners = |half: f32, z: f32| -> String {
        quad(half, z)
            .iter()
            .map(|[x, y, z]| format!("v {x} {y} {z}\n"))
            .collect()
    };
    let obj = format!(
        "mtllib a.mtl\n{}{}g wall\nusemtl wall\nf 1 2 3 4\ng crate\nusemtl crate\nf 5 6 7 8\n",
        corners(20.0, -5.0),
        corners(1.0, -10.0)
    );
    std::fs::write(folder.path().join("a.obj"), obj).expect("written");
    for (lines, hides) in [
        ("", true),
        ("d 1", true),
        ("Tr 0", true),
        ("d 1\nTr 0", true),
        ("d 1\nTr 1", true),
        ("d 0.3", false),
        ("Tr 0.5", false),
        ("d 0", false),
        ("Tr 1", false),
        ("d -halo 0.3", false),
        ("d -halo 1", false),
        ("d 2", false),
        ("d glass", false),
        ("Tr", false),
        ("map_d leaf.png", false),
        ("map_d missing.png", false),
        ("map_d", false),
        ("map_Tr leaf.png", false),
        ("illum 0", true),
        ("illum 1", true),
        ("illum 2", true),
        ("illum 3", true),
        ("illum 4", false),
        ("illum 5", true),
        ("illum 6", false),
        ("illum 7", false),
        ("illum 8", true),
        ("illum 9", false),
        ("Tf 0.5 1 1\nillum 4", false),
        ("Tf 1 1 1\nillum 2", true),
    ] {
        let mtl = format!("newmtl crate\nKd 1 0 0\nnewmtl wall\nKd 1 1 1\n{lines}\n");
        std::fs::write(folder.path().join("a.mtl"), mtl).expect("written");
        let import = read(&folder.path().join("a.obj"), &ReadOptions::default()).expect("a scene");
        let visible = visible(&import);
        assert_eq!(
            visible.contains(&"crate".to_owned()),
            !hides,
            "{lines:?}: {visible:?}"
        );
        assert!(visible.contains(&"wall".to_owned()), "{lines:?}: {visible:?}");
    }
}

/// A room of BSP29 with a pane, model 1, and a crate behind it, model 2.
const PANE_AND_CRATE: &[u8] = include_bytes!("../data/pane_and_crate.bsp");

/// Returns the map with other entities, and another name for the texture of the pane.
fn map(pane: &str, texture: &str) -> Vec<u8> {
    let mut map = PANE_AND_CRATE.to_vec();
    let word = |map: &[u8], at: usize| u32::from_le_bytes(map[at..at + 4].try_into().expect("four")) as usize;
    let start = word(&map, 4 + 8 * 2);
    let name = start + word(&map, start + 4);
    let mut bytes = texture.as_bytes().to_vec();
    bytes.resize(16, 0);
    map[name..name + 16].copy_from_slice(&bytes);
    let entities = format!(
        r#"{{"classname" "worldspawn"}}{{{pane} "model" "*1"}}{{"classname" "func_wall" "targetname" "crate" "model" "*2"}}"#
    );
    let entry = [map.len(), entities.len()].map(|number| (number as u32).to_le_bytes());
    map[4..12].copy_from_slice(&entry.concat());
    map.extend_from_slice(entities.as_bytes());
    map
}

#[test]
fn a_brush_entity_of_quake_hides_a_crate_only_if_it_stands_still_and_is_opaque() {
    for (pane, texture, hides) in [
        (r#""classname" "func_wall""#, "brick", true),
        (r#""classname" "func_detail""#, "brick", true),
        (r#""classname" "func_wall" "alpha" "1""#, "brick", true),
        (r#""classname" "func_wall" "alpha" "0.3""#, "brick", false),
        (r#""classname" "func_wall" "alpha" "0""#, "brick", false),
        (r#""classname" "func_wall" "alpha" "a bit""#, "brick", false),
        (r#""classname" "func_wall" "renderamt" "120""#, "brick", false),
        (r#""classname" "func_wall" "rendermode" "2""#, "brick", false),
        (r#""classname" "func_door""#, "brick", false),
        (r#""classname" "func_train""#, "brick", false),
        (r#""classname" "func_wall""#, "{grate", false),
        (r#""classname" "func_wall""#, "*water1", false),
        (r#""classname" "func_wall""#, "*slime0", false),
        (r#""classname" "func_wall""#, "*lava1", false),
        (r#""classname" "func_wall""#, "*teleport", false),
        (r#""classname" "func_wall""#, "!water", false),
    ] {
        let import = read_bytes(&map(pane, texture), None, &ReadOptions::default()).expect("a map");
        let visible = visible_from(&import, [-200.0, 0.0, 0.0], [3.0, 0.0, 0.0]);
        let is_seen = visible.iter().any(|name| name.contains("crate"));
        assert_eq!(is_seen, !hides, "{pane} {texture}: {visible:?}");
        assert!(
            visible.len() > usize::from(is_seen),
            "the pane is drawn: {visible:?}"
        );
    }
}
