//! One rule for all readers: a surface hides others only if the file says for sure that it is opaque, that it is drawn, and where.
//!
//! Each row is a way in which a file can say that one of these is not so, or that it is: a wall between the eye and a crate.

use crate::gltf::file::File;
use crate::gltf::grid::Grid;
use crate::quake::little::{Format, Little};
use enfilade::{ItemIndex, Method, View, Viewer};
use enfilade_import::NonOccluder::{self, *};
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

/// What a reader makes of the wall.
#[derive(Clone, Copy, Debug, PartialEq)]
enum Says {
    Hides,
    HidesNothing(NonOccluder),
    NotDrawn,
}

use Says::*;

/// Checks what is visible from the origin, and why the wall hides nothing.
fn check(what: &str, says: Says, import: &Import) {
    let visible = visible(import);
    let sees = |name: &str| visible.iter().any(|visible| visible == name);
    assert_eq!(sees("crate"), says != Hides, "{what}: {visible:?}");
    assert_eq!(sees("wall"), says != NotDrawn, "{what}: {visible:?}");
    check_reason(what, says, "wall", import);
}

/// Checks why an item hides nothing.
fn check_reason(what: &str, says: Says, name: &str, import: &Import) {
    let room = &import.rooms[0];
    let mut items = (0..room.geometry.items().len() as u32).map(ItemIndex);
    let item = items.find(|&item| room.geometry.name(item) == name);
    let found = match item.map(|item| room.non_occluders.of_item(&room.geometry, item)) {
        None => NotDrawn,
        Some(reasons) => match reasons.iter().collect::<Vec<_>>()[..] {
            [] => Hides,
            [&why] => HidesNothing(why),
            _ => panic!("{what}: {reasons:?}"),
        },
    };
    assert_eq!(found, says, "{what}");
}

type Row = (&'static str, Says, fn(&mut File));

const GLTF: &[Row] = &[
    ("nothing special", Hides, |_| {}),
    ("alphaMode MASK", HidesNothing(AlphaTested), |file| {
        file.json["materials"][0]["alphaMode"] = json!("MASK")
    }),
    ("alphaMode BLEND", HidesNothing(Blended), |file| {
        file.json["materials"][0]["alphaMode"] = json!("BLEND")
    }),
    ("alpha of an opaque material", Hides, |file| {
        file.json["materials"][0]["pbrMetallicRoughness"] = json!({ "baseColorFactor": [1, 1, 1, 0.2] });
    }),
    ("transmission", HidesNothing(Transmissive), |file| {
        extend(
            file,
            "materials",
            "KHR_materials_transmission",
            json!({ "transmissionFactor": 0.5 }),
        );
    }),
    ("volume", HidesNothing(Transmissive), |file| {
        extend(file, "materials", "KHR_materials_volume", json!({}))
    }),
    ("diffuse transmission", HidesNothing(Transmissive), |file| {
        extend(file, "materials", "KHR_materials_diffuse_transmission", json!({}));
    }),
    ("subsurface scattering", HidesNothing(Transmissive), |file| {
        extend(file, "materials", "KHR_materials_subsurface", json!({}));
    }),
    ("dispersion", HidesNothing(Transmissive), |file| {
        extend(
            file,
            "materials",
            "KHR_materials_dispersion",
            json!({ "dispersion": 1 }),
        );
    }),
    ("clearcoat", Hides, |file| {
        extend(file, "materials", "KHR_materials_clearcoat", json!({}))
    }),
    ("unlit", Hides, |file| {
        extend(file, "materials", "KHR_materials_unlit", json!({}))
    }),
    ("variants that are opaque", Hides, |file| {
        variants(file, json!({}))
    }),
    ("a variant of glass", HidesNothing(MaterialVariant), |file| {
        variants(file, json!({ "alphaMode": "BLEND" }))
    }),
    ("a skin", HidesNothing(Skinned), skin),
    ("morph targets", HidesNothing(Morphed), morph),
    ("an animated node", HidesNothing(Animated), |file| {
        animation(file, json!({ "node": 0, "path": "translation" }))
    }),
    ("an animation of another node", Hides, |file| {
        animation(file, json!({ "node": 1, "path": "translation" }))
    }),
    ("an animated node above", HidesNothing(Animated), |file| {
        let above = file.node(json!({ "children": [0] }));
        animation(file, json!({ "node": above, "path": "rotation" }));
    }),
    ("an animation of its visibility", HidesNothing(Animated), |file| {
        let pointer = json!({ "pointer": "/nodes/0/extensions/KHR_node_visibility/visible" });
        animation(
            file,
            json!({ "path": "pointer", "extensions": { "KHR_animation_pointer": pointer } }),
        );
    }),
    ("an animation of its material", HidesNothing(Animated), |file| {
        let pointer = json!({ "pointer": "/materials/0/pbrMetallicRoughness/baseColorFactor" });
        animation(
            file,
            json!({ "path": "pointer", "extensions": { "KHR_animation_pointer": pointer } }),
        );
    }),
    (
        "an animation of a path that cannot be followed",
        HidesNothing(Animated),
        |file| {
            let pointer = json!({ "pointer": "/nodes/*/translation" });
            animation(
                file,
                json!({ "path": "pointer", "extensions": { "KHR_animation_pointer": pointer } }),
            );
        },
    ),
    ("an animation of a camera", Hides, |file| {
        let pointer = json!({ "pointer": "/cameras/0/perspective/yfov" });
        animation(
            file,
            json!({ "path": "pointer", "extensions": { "KHR_animation_pointer": pointer } }),
        );
    }),
    (
        "a channel of an animation that cannot be read",
        HidesNothing(Animated),
        |file| {
            animation(file, json!({ "node": -1, "path": "translation" }));
        },
    ),
    ("a channel that moves nothing", Hides, |file| {
        animation(file, json!({ "path": "translation" }))
    }),
    ("a shield in a hand", HidesNothing(Skinned), |file| {
        file.push("skins", json!({ "joints": [0] }));
        file.json["nodes"][1]["skin"] = json!(0);
    }),
    (
        "levels of detail of its material",
        HidesNothing(LevelOfDetail),
        |file| {
            let coarse = file.push("materials", json!({ "alphaMode": "BLEND" }));
            extend(file, "materials", "MSFT_lod", json!({ "ids": [coarse] }));
        },
    ),
    ("an invisible node", NotDrawn, |file| {
        extend(file, "nodes", "KHR_node_visibility", json!({ "visible": false }));
    }),
    ("a visible node", Hides, |file| {
        extend(file, "nodes", "KHR_node_visibility", json!({ "visible": true }))
    }),
    ("an invisible node above", NotDrawn, |file| {
        let above = json!({ "children": [0], "extensions": { "KHR_node_visibility": { "visible": false } } });
        file.node(above);
    }),
    ("levels of detail", HidesNothing(LevelOfDetail), |file| {
        let other = file.node(json!({ "name": "coarse" }));
        extend(file, "nodes", "MSFT_lod", json!({ "ids": [other] }));
    }),
    ("an author who says so", HidesNothing(Author), |file| {
        file.json["nodes"][0]["extras"] = json!({ "enfilade": { "occluder": false } })
    }),
    (
        "a node above of whom the author says so",
        HidesNothing(Author),
        |file| {
            file.node(json!({ "children": [0], "extras": { "enfilade": { "occluder": 0 } } }));
        },
    ),
    ("an author who says that a skin does", Hides, |file| {
        skin(file);
        file.json["nodes"][0]["extras"] = json!({ "enfilade": { "occluder": true } });
    }),
    (
        "an author who says that glass does",
        HidesNothing(Blended),
        |file| {
            file.json["materials"][0]["alphaMode"] = json!("BLEND");
            file.json["nodes"][0]["extras"] = json!({ "enfilade": { "occluder": true } });
        },
    ),
];

fn variants(file: &mut File, material: Value) {
    let material = file.push("materials", material);
    let mappings = json!({ "mappings": [{ "material": material, "variants": [0] }] });
    file.json["meshes"][0]["primitives"][0]["extensions"] = json!({ "KHR_materials_variants": mappings });
}

#[test]
fn a_gltf_wall_hides_a_crate_only_if_it_is_opaque_and_drawn_where_it_is() {
    for (what, says, change) in GLTF {
        let mut file = gltf();
        change(&mut file);
        let import = read_bytes(&file.glb(), None, &ReadOptions::default());
        let import = import.unwrap_or_else(|why| panic!("{what}: {why}"));
        check(what, *says, &import);
    }
}

/// Extensions without which shapes and what they hide are the same, or that are read.
const HARMLESS: &[&str] = &[
    "EXT_feature_metadata",
    "EXT_instance_features",
    "EXT_lights_area",
    "EXT_lights_environment",
    "EXT_lights_ies",
    "EXT_lights_image_based",
    "EXT_manifold",
    "EXT_materials_bump",
    "EXT_materials_clearcoat_color",
    "EXT_materials_diffuse_roughness",
    "EXT_mesh_features",
    "EXT_mesh_gpu_instancing",
    "EXT_mesh_manifold",
    "EXT_mesh_polygon",
    "EXT_mesh_primitive_edge_visibility",
    "EXT_meshopt_compression",
    "EXT_structural_metadata",
    "EXT_texture_astc",
    "EXT_texture_avif",
    "EXT_texture_procedurals",
    "EXT_texture_procedurals_mx_1_39",
    "EXT_texture_video",
    "EXT_texture_webp",
    "KHR_animation_pointer",
    "KHR_audio",
    "KHR_audio_emitter",
    "KHR_audio_graph",
    "KHR_character",
    "KHR_collision_shapes",
    "KHR_implicit_shapes",
    "KHR_lights_area",
    "KHR_lights_environment",
    "KHR_lights_punctual",
    "KHR_materials_anisotropy",
    "KHR_materials_clearcoat",
    "KHR_materials_coat",
    "KHR_materials_diffuse_roughness",
    "KHR_materials_diffuse_transmission",
    "KHR_materials_dispersion",
    "KHR_materials_emissive_strength",
    "KHR_materials_fuzz",
    "KHR_materials_ior",
    "KHR_materials_iridescence",
    "KHR_materials_pbrSpecularGlossiness",
    "KHR_materials_sheen",
    "KHR_materials_specular",
    "KHR_materials_subsurface",
    "KHR_materials_transmission",
    "KHR_materials_unlit",
    "KHR_materials_variants",
    "KHR_materials_volume",
    "KHR_materials_volume_scatter",
    "KHR_mesh_quantization",
    "KHR_meshopt_compression",
    "KHR_node_hoverability",
    "KHR_node_selectability",
    "KHR_node_visibility",
    "KHR_texture_basisu",
    "KHR_texture_procedurals",
    "KHR_texture_transform",
    "KHR_texture_video",
    "KHR_xmp",
    "KHR_xmp_json_ld",
    "MSFT_lod",
    "OMI_collider",
    "OMI_physics_shape",
    "MSFT_texture_dds",
];

/// Extensions without which something is lost, and the remedy.
const SHAPING: &[(&str, &str)] = &[
    ("AGI_articulations", "its parts are moved by it"),
    ("CESIUM_RTC", "its place is lost"),
    ("EXT_blend", "its materials are blended by it"),
    ("EXT_geopose", "its place is lost"),
    ("EXT_implicit_cylinder_region", "its shapes are lost"),
    ("EXT_implicit_ellipsoid_region", "its shapes are lost"),
    ("EXT_mesh_lod", "which of its levels is drawn is not known"),
    ("EXT_mesh_opacity_micromap", "its triangles may have holes"),
    ("EXT_mesh_primitive_restart", "as triangle lists"),
    ("EXT_node_lod", "which of its levels is drawn is not known"),
    ("EXT_primitive_voxels", "its voxels are lost"),
    ("EXT_property_animation", "a program moves its nodes"),
    ("EXT_volumetricvideo", "its shapes are lost"),
    ("KHR_behavior", "a program moves its nodes"),
    ("KHR_binary_glTF", "to glTF 2.0"),
    ("KHR_billboard", "turn to the camera"),
    ("KHR_blend", "its materials are blended by it"),
    ("KHR_gaussian_splatting", "its splats are lost"),
    ("KHR_gaussian_splatting_compression_spz", "its splats are lost"),
    ("KHR_interactivity", "a program moves its nodes"),
    ("KHR_materials_common", "to glTF 2.0"),
    ("KHR_physics_rigid_bodies", "bodies fall by it"),
    ("KHR_techniques_webgl", "its own shaders"),
    ("KHR_unheard_of", "export it again without"),
    ("VRMC_springBone", "its nodes are moved by it"),
];

/// Extensions that store numbers in other ways: what has a plain copy is the same.
const STORING: &[&str] = &[
    "EXT_accessor_additional_types",
    "KHR_accessor_float16",
    "KHR_accessor_float64",
    "KHR_draco_mesh_compression",
];

/// The wall and the crate with an extension that is used, and perhaps required.
fn with_extension(extension: &str, is_required: bool) -> File {
    let mut file = gltf();
    file.json["extensionsUsed"] = json!([extension]);
    if is_required {
        file.json["extensionsRequired"] = json!([extension]);
    }
    file
}

fn lenient(file: &File) -> Import {
    let options = ReadOptions {
        lenient: true,
        ..ReadOptions::default()
    };
    read_bytes(&file.glb(), None, &options).unwrap_or_else(|why| panic!("{why}"))
}

#[test]
fn extensions_that_change_no_shape_may_be_required() {
    for extension in HARMLESS {
        let file = with_extension(extension, true);
        let import = read_bytes(&file.glb(), None, &ReadOptions::default());
        let import = import.unwrap_or_else(|why| panic!("{why}"));
        assert_eq!(visible(&import), ["wall"], "{extension}");
    }
}

#[test]
fn extensions_that_may_change_shapes_are_refused_or_hide_nothing() {
    for (extension, remedy) in SHAPING {
        let file = with_extension(extension, true);
        let why = read_bytes(&file.glb(), None, &ReadOptions::default()).map(drop);
        let why = why.expect_err("a refusal").to_string();
        for words in [extension, remedy, &"--lenient"] {
            assert!(why.contains(words), "{why}");
        }
        assert_eq!(visible(&lenient(&file)), ["crate", "wall"], "{extension}");
        let used = with_extension(extension, false);
        let import = read_bytes(&used.glb(), None, &ReadOptions::default()).expect("it is only used");
        assert_eq!(visible(&import), ["crate", "wall"], "{extension}");
    }
    for extension in STORING {
        let file = with_extension(extension, true);
        let why = read_bytes(&file.glb(), None, &ReadOptions::default()).map(drop);
        assert!(
            why.expect_err("a refusal").to_string().contains("--lenient"),
            "{extension}"
        );
        assert_eq!(visible(&lenient(&file)), ["wall"], "{extension}");
    }
}

#[test]
fn what_an_author_says_in_words_that_are_not_understood_hides_nothing() {
    let mut file = gltf();
    file.json["nodes"][0]["extras"] = json!({ "enfilade": { "occluder": "false" } });
    let options = |flat| ReadOptions {
        flat,
        ..ReadOptions::default()
    };
    assert!(read_bytes(&file.glb(), None, &options(false)).is_err());
    let import = read_bytes(&file.glb(), None, &options(true)).expect("a scene");
    assert_eq!(visible(&import), ["crate", "wall"]);
}

#[test]
fn an_extension_that_is_not_read_changes_what_carries_it() {
    const WHAT: &str = "ACME_melt";
    let carried: [Row; 12] = [
        ("the node", HidesNothing(ExtensionUnread), |file| {
            extend(file, "nodes", WHAT, json!({}))
        }),
        ("another node", Hides, |file| {
            file.json["nodes"][1]["extensions"] = json!({ WHAT: {} });
        }),
        ("a node above", HidesNothing(ExtensionUnread), |file| {
            file.node(
                json!({ "children": [0], "extensions": { WHAT: { "speed": [1, { "extensions": 2 }] } } }),
            );
        }),
        ("the mesh", HidesNothing(ExtensionUnread), |file| {
            extend(file, "meshes", WHAT, json!(null))
        }),
        ("another mesh", Hides, |file| {
            file.json["meshes"][1]["extensions"] = json!({ WHAT: {} });
        }),
        ("a primitive", HidesNothing(ExtensionUnread), |file| {
            file.json["meshes"][0]["primitives"][0]["extensions"] = json!({ WHAT: {} });
        }),
        ("the material", HidesNothing(ExtensionUnread), |file| {
            extend(file, "materials", WHAT, json!({}))
        }),
        (
            "a texture in the material",
            HidesNothing(ExtensionUnread),
            |file| {
                file.json["materials"][0]["pbrMetallicRoughness"] = json!({ "extensions": { WHAT: {} } });
            },
        ),
        ("a camera", Hides, |file| {
            file.json["cameras"] = json!([{ "type": "perspective", "perspective": { "yfov": 1, "znear": 1 }, "extensions": { WHAT: {} } }]);
        }),
        ("an accessor", HidesNothing(ExtensionUnread), |file| {
            extend(file, "accessors", WHAT, json!({}))
        }),
        ("the document", HidesNothing(ExtensionUnread), |file| {
            file.json["extensions"] = json!({ WHAT: { "nodes": [1] } });
        }),
        (
            "notes of another program",
            HidesNothing(ExtensionUnread),
            |file| {
                file.json["nodes"][1]["extras"] = json!({ "extensions": { WHAT: {} } });
            },
        ),
    ];
    for (what, says, change) in carried {
        for is_required in [false, true] {
            let mut file = with_extension(WHAT, is_required);
            change(&mut file);
            check(what, says, &lenient(&file));
        }
    }
    // One that something carries says nothing about one that nothing carries.
    let mut two = with_extension(WHAT, false);
    two.json["extensionsUsed"] = json!([WHAT, "ACME_bend"]);
    two.json["nodes"][1]["extensions"] = json!({ WHAT: {} });
    assert_eq!(visible(&lenient(&two)), ["crate", "wall"]);
    // The author knows the pose, and no more.
    let mut told = with_extension(WHAT, false);
    told.json["nodes"][0]["extensions"] = json!({ WHAT: {} });
    told.json["nodes"][0]["extras"] = json!({ "enfilade": { "occluder": true } });
    assert_eq!(visible(&lenient(&told)), ["crate", "wall"]);
}

#[test]
fn what_cannot_be_decoded_is_left_out_of_a_file_that_is_read_leniently() {
    let mut draco = with_extension("KHR_draco_mesh_compression", true);
    let primitive = &mut draco.json["meshes"][0]["primitives"][0];
    primitive["extensions"] = json!({ "KHR_draco_mesh_compression": { "bufferView": 0, "attributes": {} } });
    draco.json["accessors"][0]
        .as_object_mut()
        .expect("an accessor")
        .remove("bufferView");
    let mut doubles = with_extension("KHR_accessor_float64", true);
    doubles.json["accessors"][0]["componentType"] = json!(5130);
    let mut later = with_extension("KHR_meshopt_compression", true);
    let view = json!({ "buffer": 0, "byteLength": 8, "byteStride": 12, "count": 4, "mode": "MESHLETS" });
    extend(&mut later, "bufferViews", "KHR_meshopt_compression", view);
    for file in [draco, doubles, later] {
        let import = lenient(&file);
        assert_eq!(visible(&import), ["crate"]);
        let warnings: Vec<String> = import.warnings.iter().map(ToString::to_string).collect();
        let left_out =
            "primitives whose compression or storage is not supported are left out (meshes[0].primitives[0])";
        assert!(warnings.contains(&left_out.to_owned()), "{warnings:?}");
        assert!(read_bytes(&file.glb(), None, &ReadOptions::default()).is_err());
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
    for (lines, says) in [
        ("", Hides),
        ("d 1", Hides),
        ("Tr 0", Hides),
        ("d 1\nTr 0", Hides),
        ("d 1\nTr 1", Hides),
        ("map_opacity leaf.png", HidesNothing(MaterialUnread)),
        ("d 1\nPt 0.9", HidesNothing(MaterialUnread)),
        ("D 0.5", HidesNothing(MaterialUnread)),
        ("d 1 -halo", HidesNothing(MaterialUnread)),
        ("d 1.0 0.3", HidesNothing(MaterialUnread)),
        ("d=0.3", HidesNothing(MaterialUnread)),
        ("d 0.3\nd 1", HidesNothing(MaterialUnread)),
        ("d 1\nd 1.0", Hides),
        ("d 1\nTr 0.5", HidesNothing(MaterialUnread)),
        ("Kt 0.5 0.5 0.5", HidesNothing(MaterialUnread)),
        ("refraction 0.9", HidesNothing(MaterialUnread)),
        ("map_mask leaf.png", HidesNothing(MaterialUnread)),
        ("disp bumps.png", HidesNothing(MaterialUnread)),
        ("map_Bump bumps.png\nnorm n.png\nrefl -type sphere r.png", Hides),
        ("Ka 1 1 1\nKs 0 0 0\nNs 10\nNi 1.5\nPr 0.5\nmap_Pm m.png", Hides),
        ("NEWMTL other\nd 0.3", HidesNothing(MaterialUnread)),
        ("newmtl wall\nd 0.3", HidesNothing(MaterialUnread)),
        ("newmtl wall\nKd 1 0 0", Hides),
        ("illum 10", HidesNothing(MaterialUnread)),
        ("illum glass", HidesNothing(MaterialUnread)),
        ("d 0.3", HidesNothing(Blended)),
        ("Tr 0.5", HidesNothing(Blended)),
        ("d 0", HidesNothing(Blended)),
        ("Tr 1", HidesNothing(Blended)),
        ("d -halo 0.3", HidesNothing(MaterialUnread)),
        ("d -halo 1", HidesNothing(MaterialUnread)),
        ("d 2", HidesNothing(MaterialUnread)),
        ("d glass", HidesNothing(MaterialUnread)),
        ("Tr", HidesNothing(MaterialUnread)),
        ("map_d leaf.png", HidesNothing(AlphaTested)),
        ("map_d missing.png", HidesNothing(AlphaTested)),
        ("map_d", HidesNothing(AlphaTested)),
        ("map_Tr leaf.png", HidesNothing(AlphaTested)),
        ("illum 0", Hides),
        ("illum 1", Hides),
        ("illum 2", Hides),
        ("illum 3", Hides),
        ("illum 4", HidesNothing(Transmissive)),
        ("illum 5", Hides),
        ("illum 6", HidesNothing(Transmissive)),
        ("illum 7", HidesNothing(Transmissive)),
        ("illum 8", Hides),
        ("illum 9", HidesNothing(Transmissive)),
        ("Tf 0.5 1 1\nillum 4", HidesNothing(Transmissive)),
        ("Tf 1 1 1\nillum 2", Hides),
    ] {
        let mtl = format!("newmtl crate\nKd 1 0 0\nnewmtl wall\nKd 1 1 1\n{lines}\n");
        std::fs::write(folder.path().join("a.mtl"), mtl).expect("written");
        let import = read(&folder.path().join("a.obj"), &ReadOptions::default()).expect("a scene");
        check(lines, says, &import);
    }
    let read = |mtl: &str| {
        std::fs::write(folder.path().join("a.mtl"), mtl).expect("written");
        read(&folder.path().join("a.obj"), &ReadOptions::default()).expect("a scene")
    };
    let says = HidesNothing(MaterialUnread);
    check("no such material", says, &read("newmtl crate\nKd 1 0 0\n"));
    check("an empty material file", says, &read(""));
    std::fs::remove_file(folder.path().join("a.mtl")).expect("removed");
    let import = enfilade_import::read(&folder.path().join("a.obj"), &ReadOptions::default());
    check("no material file", says, &import.expect("a scene"));
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
    for (pane, texture, says) in [
        (r#""classname" "func_wall""#, "brick", Hides),
        (r#""classname" "func_detail""#, "brick", Hides),
        (r#""classname" "func_wall" "alpha" "1""#, "brick", Hides),
        (
            r#""classname" "func_wall" "alpha" "0.3""#,
            "brick",
            HidesNothing(TranslucentBrush),
        ),
        (
            r#""classname" "func_wall" "alpha" "0""#,
            "brick",
            HidesNothing(TranslucentBrush),
        ),
        (
            r#""classname" "func_wall" "alpha" "a bit""#,
            "brick",
            HidesNothing(TranslucentBrush),
        ),
        (
            r#""classname" "func_wall" "renderamt" "120""#,
            "brick",
            HidesNothing(TranslucentBrush),
        ),
        (
            r#""classname" "func_wall" "rendermode" "2""#,
            "brick",
            HidesNothing(TranslucentBrush),
        ),
        (r#""classname" "func_door""#, "brick", HidesNothing(MovingBrush)),
        (
            r#""classname" "func_wall" "spawnflags" "1792""#,
            "brick",
            HidesNothing(MovingBrush),
        ),
        (r#""classname" "func_wall" "spawnflags" "0""#, "brick", Hides),
        (
            r#""classname" "func_wall" "targetname" "bars"} {"classname" "info_null" "killtarget" "bars"} {"classname" "func_wall""#,
            "brick",
            Hides,
        ),
        (
            r#""classname" "func_wall" "targetname" "bars" "killtarget" "bars""#,
            "brick",
            HidesNothing(MovingBrush),
        ),
        (r#""classname" "func_wall" "targetname" "bars""#, "brick", Hides),
        (
            r#""classname" "func_wall" "origin" "0, 0, 0""#,
            "brick",
            HidesNothing(MovingBrush),
        ),
        (
            r#""classname" "func_wall" "scale" "2""#,
            "brick",
            HidesNothing(MovingBrush),
        ),
        (
            r#""classname" "func_wall" "alpha " "0.5""#,
            "brick",
            HidesNothing(TranslucentBrush),
        ),
        ("classname func_wall // a fence\n", "brick", Hides),
        (r#""classname" "func_train""#, "brick", HidesNothing(MovingBrush)),
        (r#""classname" "func_wall""#, "{grate", HidesNothing(AlphaKey)),
        (r#""classname" "func_wall""#, "*water1", HidesNothing(Liquid)),
        (r#""classname" "func_wall""#, "*slime0", HidesNothing(Liquid)),
        (r#""classname" "func_wall""#, "*lava1", HidesNothing(Liquid)),
        (r#""classname" "func_wall""#, "*teleport", HidesNothing(Liquid)),
        (r#""classname" "func_wall""#, "!water", HidesNothing(Liquid)),
    ] {
        let import = read_bytes(&map(pane, texture), None, &ReadOptions::default()).expect("a map");
        let visible = visible_from(&import, [-200.0, 0.0, 0.0], [3.0, 0.0, 0.0]);
        let is_seen = visible.iter().any(|name| name.contains("crate"));
        assert_eq!(is_seen, says != Hides, "{pane} {texture}: {visible:?}");
        let mut others = visible.iter().filter(|name| !name.contains("crate"));
        let pane = others.next().expect("the pane is drawn");
        check_reason(pane, says, pane, &import);
    }
}

/// A room of Quake 3 with a pane between the eye and a crate; the texture of the pane is `textures/little/pane`.
fn arena(surface: u32, content: u32) -> Vec<u8> {
    let mut little = Little::new(Format::Ibsp46);
    let entities = String::from_utf8_lossy(&little.lumps[0])
        .replace("func_door", "func_static")
        .replace("32 0 0", "16 0 0");
    little.lumps[0] = entities.into_bytes();
    let texture = &mut little.lumps[1][3 * 72..];
    let name = b"textures/little/pane";
    texture[..name.len()].copy_from_slice(name);
    texture[64..68].copy_from_slice(&surface.to_le_bytes());
    texture[68..72].copy_from_slice(&content.to_le_bytes());
    // The crate, its last face, looks at the pane.
    let start = little.lumps[11].len() - 24;
    let turned: Vec<u8> = [0_u32, 2, 1, 0, 3, 2]
        .iter()
        .flat_map(|corner| corner.to_le_bytes())
        .collect();
    little.lumps[11][start..].copy_from_slice(&turned);
    little.bytes()
}

fn check_arena(what: &str, says: Says, import: &Import) {
    let visible = visible_from(import, [60.0, 0.0, 0.0], [0.0; 3]);
    let is_seen = visible.iter().any(|name| name.contains("func_static"));
    assert_eq!(is_seen, says != Hides, "{what}: {visible:?}");
    let room = &import.rooms[0];
    let mut items = (0..room.geometry.items().len() as u32).map(ItemIndex);
    let item = items.find(|&item| room.geometry.name(item) == "cluster 1");
    let mut reasons = room
        .non_occluders
        .of_item(&room.geometry, item.expect("the room"));
    if let HidesNothing(why) = says {
        assert!(reasons.remove(&why), "{what}: {reasons:?}");
    }
    // Its floor is lava.
    reasons.remove(&Liquid);
    assert!(reasons.is_empty(), "{what}: {reasons:?}");
}

#[test]
fn a_pane_of_quake_3_hides_a_crate_only_if_its_flags_say_that_it_is_solid_and_opaque() {
    for (surface, content, says) in [
        (0, 1, Hides),
        (0x20, 1, Hides),
        (0, 0, HidesNothing(NotSolid)),
        (0x4000, 1, HidesNothing(NotSolid)),
        (0, 0x2000_0000, HidesNothing(Translucent)),
        (0, 0x2000_0001, HidesNothing(Translucent)),
        (0, 0x41, HidesNothing(Translucent)),
        (0x8000, 1, HidesNothing(Translucent)),
        (0x1_0000, 1, HidesNothing(Translucent)),
        (0x4, 1, HidesNothing(Sky)),
        (0, 0x20, HidesNothing(Liquid)),
        (0, 0x10, HidesNothing(Liquid)),
        (0, 0x8, HidesNothing(Liquid)),
        (0, 0x21, HidesNothing(Liquid)),
        (0x80, 1, NotDrawn),
        (0x100, 1, NotDrawn),
        (0x200, 1, NotDrawn),
    ] {
        let import = read_bytes(&arena(surface, content), None, &ReadOptions::default());
        let what = format!("surface {surface:#x}, content {content:#x}");
        check_arena(&what, says, &import.expect("a map"));
    }
}

#[test]
fn a_pane_of_quake_3_hides_a_crate_only_if_no_shader_file_says_that_one_sees_through_it() {
    let folder = tempfile::tempdir().expect("a folder");
    let folder = folder.path();
    std::fs::create_dir_all(folder.join("game/maps")).expect("folders");
    std::fs::create_dir_all(folder.join("game/scripts")).expect("folders");
    std::fs::create_dir_all(folder.join("game/Scripts")).expect("folders");
    let map = folder.join("game/maps/arena.bsp");
    std::fs::write(&map, arena(0, 1)).expect("written");
    let places = [
        "game/maps/a.shader",
        "game/scripts/a.SHADER",
        "game/Scripts/a.shader",
    ];
    for (directives, says) in [
        ("{\nmap pane.tga\n}", Hides),
        ("cull front", Hides),
        ("surfaceparm nomarks", Hides),
        ("// cull none", Hides),
        ("{\nmap pane.tga\nblendFunc add\n}", HidesNothing(Blended)),
        (
            "{\nmap pane.tga\nblendfunc GL_SRC_ALPHA GL_ONE\n}",
            HidesNothing(Blended),
        ),
        ("{\nmap pane.tga\nalphaFunc GE128\n}", HidesNothing(AlphaTested)),
        ("surfaceparm trans", HidesNothing(Translucent)),
        ("cull none", HidesNothing(DoubleSidedShader)),
        (
            "surfaceparm nomarks surfaceparm lightfilter",
            HidesNothing(Translucent),
        ),
        ("surfaceparm nonsolid", HidesNothing(NotSolid)),
        ("surfaceparm nodraw", HidesNothing(NotSolid)),
        ("surfaceparm water", HidesNothing(Liquid)),
        ("surfaceparm sky", HidesNothing(Sky)),
        ("sort additive", HidesNothing(Translucent)),
        ("dp_refract 1 1", HidesNothing(MaterialUnread)),
        ("{ map pane.tga blendFunc add }", HidesNothing(Blended)),
        ("cull disable", HidesNothing(DoubleSidedShader)),
        ("cull back", HidesNothing(DoubleSidedShader)),
        ("deformVertexes wave 100 sin 0 2 0 1", HidesNothing(Animated)),
    ] {
        for place in places {
            let path = folder.join(place);
            let text = format!("// A script.\ntextures/little/Pane\n{{\n{directives}\n}}\n");
            std::fs::write(&path, text).expect("written");
            let import = read(&map, &ReadOptions::default()).expect("a map");
            check_arena(&format!("{place}: {directives}"), says, &import);
            let named: Vec<_> = import
                .files
                .iter()
                .filter_map(|file| file.canonicalize().ok())
                .collect();
            assert_eq!(named, [path.canonicalize().expect("it exists")]);
            std::fs::remove_file(&path).expect("removed");
        }
    }
}

#[test]
fn a_ridge_of_terrain_hides_the_valley_behind_it_unless_its_author_says_that_it_does_not() {
    let mut grid = Grid::new([2, 70]);
    for position in &mut grid.positions {
        position[1] = if position[2] == 20.0 { 9.0 } else { 0.0 };
    }
    let mut file = grid.file();
    let visible = |file: &File| {
        let import = read_bytes(&file.glb(), None, &ReadOptions::default()).expect("a hill");
        let view = View::new([0.5, 6.0, 1.0], [0.5, 5.0, 30.0], [640, 480]).expect("a view");
        [
            Method::ZBuffer,
            Method::FloatingHorizon,
            Method::Masked,
            Method::Svbsp,
        ]
        .map(|method| {
            let scene = import.scene(method, 1 << 30).expect("a scene");
            Viewer::new().look(&scene, &view).names(&scene).count()
        })
    };
    assert_eq!(visible(&file), [1; 4], "one of three blocks");
    file.json["nodes"][0]["extras"] = json!({ "enfilade": { "occluder": false } });
    assert_eq!(visible(&file), [3; 4], "all blocks");
}
