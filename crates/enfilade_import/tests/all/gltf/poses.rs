//! Poses: skins and morph targets, compared with a plain computation in f64 beside them.

use super::file::{File, reads, refuses, warnings};
use enfilade::{ItemIndex, Method, View, Viewer};
use enfilade_import::{Import, ReadOptions, read_bytes};
use serde_json::{Value, json};

/// A matrix in rows, of 3×4 numbers.
type Matrix = [[f64; 4]; 3];

fn times(a: Matrix, b: Matrix) -> Matrix {
    let last = [0.0, 0.0, 0.0, 1.0];
    let at = |row: usize, column: usize| {
        let below = |k: usize| if k < 3 { b[k][column] } else { last[column] };
        (0..4).map(|k| a[row][k] * below(k)).sum()
    };
    std::array::from_fn(|row| std::array::from_fn(|column| at(row, column)))
}

fn apply(m: Matrix, p: [f64; 3]) -> [f64; 3] {
    m.map(|row| row[0] * p[0] + row[1] * p[1] + row[2] * p[2] + row[3])
}

/// As glTF stores it: 16 numbers, column by column.
fn columns(m: Matrix) -> [f64; 16] {
    std::array::from_fn(|i| match i % 4 {
        3 => f64::from(u8::from(i == 15)),
        row => m[row][i / 4],
    })
}

/// A random matrix that turns, stretches, shears and moves.
fn random_matrix(random: &mut fastrand::Rng) -> Matrix {
    std::array::from_fn(|row| {
        std::array::from_fn(|column| {
            let off = random.f64() - 0.5;
            if column == 3 {
                6.0 * off
            } else {
                off + f64::from(u8::from(row == column))
            }
        })
    })
}

fn as_f32(m: Matrix) -> Vec<f32> {
    columns(m).map(|value| value as f32).to_vec()
}

/// Rounded as in a file.
fn rounded(m: Matrix) -> Matrix {
    m.map(|row| row.map(|value| f64::from(value as f32)))
}

/// The corners of all triangles of an item, in world space.
fn corners(import: &Import, name: &str) -> Vec<[f32; 3]> {
    let geometry = &import.rooms[0].geometry;
    let item = (0..geometry.items().len() as u32)
        .map(ItemIndex)
        .find(|&item| geometry.name(item) == name)
        .unwrap_or_else(|| panic!("no item {name}"));
    let (mesh, place) = (geometry.mesh_of(item), geometry.item(item).transform());
    (0..mesh.face_count())
        .flat_map(|face| mesh.face(face).to_vec())
        .map(|corner| place.point(mesh.positions()[corner as usize]))
        .collect()
}

/// Asserts that two sets of points are equal up to rounding, in any order.
#[track_caller]
fn are_same(found: &[[f32; 3]], expected: &[[f64; 3]], what: &str) {
    assert_eq!(found.len(), expected.len(), "{what}");
    for point in expected {
        let off = |found: &[f32; 3]| {
            (0..3)
                .map(|axis| (f64::from(found[axis]) - point[axis]).abs())
                .fold(0.0, f64::max)
        };
        let nearest = found.iter().map(off).fold(f64::INFINITY, f64::min);
        let size = point.iter().fold(1.0, |most: f64, value| most.max(value.abs()));
        assert!(nearest < 1e-5 * size, "{what}: {point:?} is not among {found:?}");
    }
}

/// The names of what is visible from the origin along −z.
fn visible(import: &Import) -> Vec<String> {
    let view = View::new([0.0; 3], [0.0, 0.0, -1.0], [64, 48]).expect("a view");
    let scene = import.scene(Method::ZBuffer, 1 << 30).expect("a scene");
    let mut viewer = Viewer::new();
    let set = viewer.look(&scene, &view);
    let mut names: Vec<String> = set.names(&scene).map(|name| name.to_string()).collect();
    names.sort();
    names
}

/// How joint indices and weights are stored.
#[derive(Clone, Copy, Debug)]
struct Stored {
    joints: u32,
    weights: u32,
}

/// Adds joints and weights of vertices, in as many sets of four as they need.
fn bind(file: &mut File, primitive: &mut Value, vertices: &[Vec<(u32, f64)>], stored: Stored) {
    let sets = vertices.iter().map(|vertex| vertex.len().div_ceil(4)).max();
    for set in 0..sets.unwrap_or(0) {
        let part =
            |vertex: &Vec<(u32, f64)>, lane: usize| vertex.get(4 * set + lane).copied().unwrap_or((0, 0.0));
        let lanes = || {
            vertices
                .iter()
                .flat_map(|vertex| (0..4).map(move |lane| part(vertex, lane)))
        };
        let joints = lanes().flat_map(|(joint, _)| match stored.joints {
            5121 => vec![joint as u8],
            _ => (joint as u16).to_le_bytes().to_vec(),
        });
        let joints = file.accessor(stored.joints, "VEC4", vertices.len(), joints.collect());
        let weights = lanes().flat_map(|(_, weight)| match stored.weights {
            5121 => vec![(weight * 255.0) as u8],
            5123 => ((weight * 65535.0) as u16).to_le_bytes().to_vec(),
            _ => (weight as f32).to_le_bytes().to_vec(),
        });
        let weights = file.accessor(stored.weights, "VEC4", vertices.len(), weights.collect());
        if stored.weights != 5126 {
            file.json["accessors"][weights]["normalized"] = json!(true);
        }
        primitive["attributes"][format!("JOINTS_{set}")] = json!(joints);
        primitive["attributes"][format!("WEIGHTS_{set}")] = json!(weights);
    }
}

const FLOATS: Stored = Stored {
    joints: 5123,
    weights: 5126,
};

/// Two triangles.
const SHAPE: [[f32; 3]; 6] = [
    [0.0, 0.0, 0.0],
    [1.0, 0.0, 0.0],
    [0.0, 1.0, 0.0],
    [2.0, 0.0, 1.0],
    [3.0, 0.5, 1.0],
    [2.0, 1.0, -1.0],
];

/// A file with one skinned node, `body`, whose vertices each follow one joint, at a translation each.
fn moved_by(joints: &[[f32; 3]], vertices: &[Vec<(u32, f64)>]) -> File {
    let mut file = File::empty();
    let mut primitive = file.primitive(&SHAPE, &[0, 1, 2, 3, 4, 5]);
    bind(&mut file, &mut primitive, vertices, FLOATS);
    let mesh = file.mesh(json!([primitive]));
    file.node(
        json!({ "name": "body", "mesh": mesh, "skin": 0, "translation": [500, 0, 0], "scale": [0, 7, 1] }),
    );
    let first = file.json["nodes"].as_array().expect("nodes").len();
    for at in joints {
        file.node(json!({ "translation": at }));
    }
    let numbers: Vec<usize> = (first..first + joints.len()).collect();
    file.push("skins", json!({ "joints": numbers, "name": "bones" }));
    file
}

#[test]
fn a_body_stands_where_its_joints_put_it_however_joints_and_weights_are_stored() {
    let mut random = fastrand::Rng::with_seed(7);
    for round in 0..40 {
        let stored = Stored {
            joints: [5121, 5123][round % 2],
            weights: [5126, 5121, 5123][round % 3],
        };
        let influences = 1 + round % 11;
        let mut file = File::empty();
        // Two chains of joints, in the space of a parent that is moved too.
        let parent = random_matrix(&mut random);
        let locals: Vec<Matrix> = (0..6).map(|_| random_matrix(&mut random)).collect();
        let binds: Vec<Matrix> = (0..6).map(|_| rounded(random_matrix(&mut random))).collect();
        let mut worlds: Vec<Matrix> = Vec::new();
        for (number, &local) in locals.iter().enumerate() {
            let above = if number % 3 == 0 {
                parent
            } else {
                worlds[number - 1]
            };
            worlds.push(times(above, local));
        }
        let vertices: Vec<Vec<(u32, f64)>> = SHAPE
            .iter()
            .map(|_| {
                (0..influences)
                    .map(|_| (random.u32(..6), 0.1 + 0.9 * random.f64()))
                    .collect()
            })
            .collect();
        let mut primitive = file.primitive(&SHAPE, &[0, 1, 2, 3, 4, 5]);
        bind(&mut file, &mut primitive, &vertices, stored);
        let mesh = file.mesh(json!([primitive]));
        let numbers: Vec<f32> = binds.iter().flat_map(|&bind| as_f32(bind)).collect();
        let bytes = numbers.iter().flat_map(|value| value.to_le_bytes()).collect();
        let accessor = file.accessor(5126, "MAT4", 6, bytes);
        file.push(
            "skins",
            json!({ "joints": [2, 3, 4, 5, 6, 7], "inverseBindMatrices": accessor }),
        );
        // The transform of the node itself and of what is above it moves nothing.
        file.node(json!({ "name": "body", "mesh": mesh, "skin": 0, "scale": [3, 3, 3] }));
        file.node(json!({ "matrix": columns(parent), "children": [0, 2, 5] }));
        for (number, &local) in locals.iter().enumerate() {
            let children: &[usize] = if number % 3 == 2 { &[] } else { &[number + 3] };
            file.node(json!({ "matrix": columns(local), "children": children }));
        }
        let expected: Vec<[f64; 3]> = SHAPE
            .iter()
            .zip(&vertices)
            .map(|(position, vertex)| {
                let quantized = |weight: f64| match stored.weights {
                    5121 => (weight * 255.0).floor() / 255.0,
                    5123 => (weight * 65535.0).floor() / 65535.0,
                    _ => weight,
                };
                let total: f64 = vertex.iter().map(|&(_, weight)| quantized(weight)).sum();
                let mut sum = [0.0; 3];
                for &(joint, weight) in vertex {
                    let joint = joint as usize;
                    let moved = apply(times(worlds[joint], binds[joint]), position.map(f64::from));
                    (0..3).for_each(|axis| sum[axis] += quantized(weight) / total * moved[axis]);
                }
                sum
            })
            .collect();
        let import = reads(&file);
        let what = format!("round {round}, {stored:?}, {influences} influences");
        are_same(&corners(&import, "body"), &expected, &what);
        let bounds = import.rooms[0].geometry.bounds();
        for axis in 0..3 {
            let least = expected
                .iter()
                .map(|point| point[axis])
                .fold(f64::INFINITY, f64::min);
            let off = (f64::from(bounds.min[axis]) - least).abs();
            assert!(off < 1e-4, "{what}: {bounds:?}, {expected:?}");
        }
        // Some triangles face away, so only what is drawn at all is certain.
        assert!(
            warnings(&import).iter().all(|text| text.contains("shear")),
            "{:?}",
            warnings(&import)
        );
    }
}

#[test]
fn weights_are_divided_by_their_sum_and_a_vertex_without_any_follows_its_first_joint() {
    let at = [[10.0, 0.0, 0.0], [0.0, 20.0, 0.0]];
    let half = |a: f64, b: f64| vec![(0, a), (1, b)];
    let file = moved_by(
        &at,
        &[
            half(0.5, 0.5),
            half(2.0, 2.0),
            half(0.001, 0.003),
            half(1.0, 0.0),
            vec![(1, 0.0)],
            vec![(1, f64::NAN)],
        ],
    );
    let import = reads(&file);
    let expected = [
        [5.0, 10.0, 0.0],
        [6.0, 10.0, 0.0],
        [2.5, 16.0, 0.0],
        [12.0, 0.0, 1.0],
        [3.0, 20.5, 1.0],
        [2.0, 21.0, -1.0],
    ];
    are_same(&corners(&import, "body"), &expected, "weights");
    assert_eq!(
        warnings(&import),
        [
            "vertices of skinned meshes without valid joint weights follow their first joint; meshes without joints follow their \
          node (meshes[0].primitives[0])"
        ]
    );
}

#[test]
fn a_skinned_wall_whose_joint_is_far_away_is_culled_and_does_not_hide_a_crate() {
    let quad = |half: f32, z: f32| {
        [
            [-half, -half, z],
            [half, -half, z],
            [half, half, z],
            [-half, half, z],
        ]
    };
    let with_joint_at = |x: f32| {
        let mut file = File::empty();
        let mut wall = file.primitive(&quad(20.0, -5.0), &[0, 1, 2, 0, 2, 3]);
        bind(&mut file, &mut wall, &vec![vec![(0, 1.0)]; 4], FLOATS);
        let wall = file.mesh(json!([wall]));
        let case = file.primitive(&quad(1.0, -10.0), &[0, 1, 2, 0, 2, 3]);
        let case = file.mesh(json!([case]));
        file.node(json!({ "name": "wall", "mesh": wall, "skin": 0 }));
        file.node(json!({ "name": "crate", "mesh": case }));
        file.node(json!({ "translation": [x, 0, 0] }));
        file.push("skins", json!({ "joints": [2] }));
        file
    };
    assert_eq!(visible(&reads(&with_joint_at(100.0))), ["crate"]);
    assert_eq!(visible(&reads(&with_joint_at(0.0))), ["crate", "wall"]);
    let mut told = with_joint_at(0.0);
    told.json["nodes"][0]["extras"] = json!({ "enfilade": { "occluder": true } });
    assert_eq!(visible(&reads(&told)), ["wall"]);
}

#[test]
fn two_nodes_that_share_a_mesh_have_each_its_own_pose() {
    let mut file = moved_by(&[[10.0, 0.0, 0.0], [0.0, 20.0, 0.0]], &vec![vec![(0, 1.0)]; 6]);
    file.push("skins", json!({ "joints": [2] }));
    let other = file.node(json!({ "name": "other", "mesh": 0, "skin": 1 }));
    file.node(json!({ "name": "still", "mesh": 0, "translation": [0, 0, 3] }));
    // With the pose of the first.
    file.node(json!({ "name": "twin", "mesh": 0, "skin": 0, "rotation": [0, 1, 0, 0] }));
    assert_eq!(other, 3);
    let import = reads(&file);
    let moved = |by: [f64; 3]| -> Vec<[f64; 3]> {
        let add = |corner: &[f32; 3]| std::array::from_fn(|axis| f64::from(corner[axis]) + by[axis]);
        SHAPE.iter().map(add).collect()
    };
    for (name, by) in [
        ("body", [10.0, 0.0, 0.0]),
        ("other", [0.0, 20.0, 0.0]),
        ("still", [0.0, 0.0, 3.0]),
        ("twin", [10.0, 0.0, 0.0]),
    ] {
        are_same(&corners(&import, name), &moved(by), name);
    }
    assert_eq!(import.rooms[0].geometry.meshes().len(), 3);
}

#[test]
fn a_body_far_from_the_origin_keeps_its_shape() {
    let file = moved_by(&[[4_000_000.0, 0.0, -3_000_000.0]], &vec![vec![(0, 1.0)]; 6]);
    let import = reads(&file);
    let geometry = &import.rooms[0].geometry;
    let size = geometry.mesh_of(ItemIndex(0)).bounds().size();
    assert_eq!(size, [3.0, 1.0, 2.0]);
    let min = geometry.bounds().min;
    assert!(
        (min[0] - 4_000_000.0).abs() < 1.0 && (min[2] + 3_000_001.0).abs() < 1.0,
        "{min:?}"
    );
}

/// A leaf with morph targets: each moves all three corners by the given offsets.
fn morphed(deltas: &[[[f32; 3]; 3]]) -> File {
    let mut file = File::leaf();
    let targets: Vec<Value> = deltas
        .iter()
        .map(|delta| json!({ "POSITION": file.positions(delta) }))
        .collect();
    file.json["meshes"][0]["primitives"][0]["targets"] = json!(targets);
    file
}

const UP: [[f32; 3]; 3] = [[0.0, 0.0, 1.0]; 3];
const ASIDE: [[f32; 3]; 3] = [[2.0, 0.0, 0.0], [4.0, 0.0, 0.0], [6.0, 0.0, 0.0]];

#[test]
fn a_face_has_the_expression_of_its_node_or_else_of_its_mesh() {
    let of = |node: Value, mesh: Value| {
        let mut file = morphed(&[UP, ASIDE]);
        if !node.is_null() {
            file.json["nodes"][0]["weights"] = node;
        }
        if !mesh.is_null() {
            file.json["meshes"][0]["weights"] = mesh;
        }
        let import = reads(&file);
        assert_eq!(warnings(&import), [""; 0]);
        corners(&import, "Leaf")
    };
    let expected = |up: f64, aside: f64| {
        [
            [2.0 * aside, 0.0, up],
            [1.0 + 4.0 * aside, 0.0, up],
            [6.0 * aside, 1.0, up],
        ]
    };
    let none = Value::Null;
    for (node, mesh, [up, aside]) in [
        (none.clone(), none.clone(), [0.0, 0.0]),
        (none.clone(), json!([0.5, 0.25]), [0.5, 0.25]),
        (json!([1, 0]), json!([0.5, 0.25]), [1.0, 0.0]),
        (json!([0, 0]), json!([0.5, 0.25]), [0.0, 0.0]),
        (json!([-2, 1.5]), none, [-2.0, 1.5]),
    ] {
        are_same(
            &of(node.clone(), mesh.clone()),
            &expected(up, aside),
            &format!("{node} {mesh}"),
        );
    }
}

#[test]
fn weights_that_are_too_few_or_too_many_are_read_with_a_warning() {
    for (weights, up) in [(json!([1]), 1.0), (json!([1, 0, 9]), 1.0), (json!([]), 0.0)] {
        let mut file = morphed(&[UP, ASIDE]);
        file.json["nodes"][0]["weights"] = weights.clone();
        let import = reads(&file);
        assert_eq!(
            warnings(&import),
            [
                "weights that are not as many as the morph targets of a mesh: missing ones are 0, others are ignored (node 0 \
              \"Leaf\")"
            ],
            "{weights}"
        );
        are_same(
            &corners(&import, "Leaf"),
            &[[0.0, 0.0, up], [1.0, 0.0, up], [0.0, 1.0, up]],
            "weights",
        );
    }
}

#[test]
fn morph_targets_may_be_sparse_quantized_or_without_bytes() {
    // Sparse over nothing: only corner 1 moves.
    let mut sparse = morphed(&[UP]);
    let [numbers, values] =
        [vec![1_u8], [0.0_f32, 0.0, 3.0].map(f32::to_le_bytes).concat()].map(|bytes| sparse.view(bytes));
    let accessor = json!({
        "componentType": 5126, "type": "VEC3", "count": 3, "sparse": {
            "count": 1, "indices": { "bufferView": numbers, "componentType": 5121 }, "values": { "bufferView": values }
        }
    });
    let accessor = sparse.push("accessors", accessor);
    // Normalized shorts: 32767 is 1.
    let mut shorts = morphed(&[UP]);
    let bytes = [0_i16, 0, 0, 0, 0, 0, 0, 32767, -32767, 0, 0, 0]
        .map(i16::to_le_bytes)
        .concat();
    let quantized = shorts.accessor(5122, "VEC3", 3, bytes[..18].to_vec());
    shorts.json["accessors"][quantized]["normalized"] = json!(true);
    // Plain bytes.
    let mut bytes = morphed(&[UP]);
    let plain = bytes.accessor(
        5120,
        "VEC3",
        3,
        [0_i8, 0, -7, 0, 5, 0, 1, 0, 0].map(|v| v as u8).to_vec(),
    );
    // No bytes at all: nothing moves.
    let mut nothing = morphed(&[UP]);
    let empty = nothing.push(
        "accessors",
        json!({ "componentType": 5126, "type": "VEC3", "count": 3 }),
    );
    for (mut file, accessor, expected) in [
        (
            sparse,
            accessor,
            [[0.0, 0.0, 0.0], [1.0, 0.0, 6.0], [0.0, 1.0, 0.0]],
        ),
        (
            shorts,
            quantized,
            [[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 3.0, -2.0]],
        ),
        (
            bytes,
            plain,
            [[0.0, 0.0, -14.0], [1.0, 10.0, 0.0], [2.0, 1.0, 0.0]],
        ),
        (
            nothing,
            empty,
            [[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]],
        ),
    ] {
        file.json["meshes"][0]["primitives"][0]["targets"][0]["POSITION"] = json!(accessor);
        file.json["nodes"][0]["weights"] = json!([2]);
        are_same(&corners(&reads(&file), "Leaf"), &expected, "stored");
    }
}

#[test]
fn a_face_is_morphed_before_its_bones_turn_it() {
    let mut file = morphed(&[UP]);
    file.json["nodes"][0]["weights"] = json!([2]);
    file.json["nodes"][0]["skin"] = json!(0);
    let mut primitive = file.json["meshes"][0]["primitives"][0].clone();
    bind(&mut file, &mut primitive, &vec![vec![(0, 1.0)]; 3], FLOATS);
    file.json["meshes"][0]["primitives"][0] = primitive;
    // A quarter turn about y takes z to x.
    let half = std::f64::consts::FRAC_1_SQRT_2;
    let joint = file.node(json!({ "rotation": [0, half, 0, half] }));
    file.push("skins", json!({ "joints": [joint] }));
    let expected = [[2.0, 0.0, 0.0], [2.0, 0.0, -1.0], [2.0, 1.0, 0.0]];
    are_same(&corners(&reads(&file), "Leaf"), &expected, "morph, then skin");
}

#[test]
fn normals_texture_coordinates_and_colors_follow_the_pose() {
    let mut file = super::file::textured_leaf();
    let [normals, bent] =
        [[0.0, 0.0, 1.0].repeat(3), [1.0, 0.0, -1.0].repeat(3)].map(|values| file.floats(&values, 3));
    let [colors, redder] = [[0.2, 0.2, 0.2, 1.0].repeat(3), [0.5, -0.5, 0.0, -0.5].repeat(3)]
        .map(|values| file.floats(&values, 4));
    let moved = file.floats(&[0.25, 0.5].repeat(3), 2);
    for (attribute, accessor) in [("NORMAL", normals), ("COLOR_0", colors)] {
        file.carry(attribute, accessor);
    }
    file.json["meshes"][0]["primitives"][0]["targets"] =
        json!([{ "NORMAL": bent, "COLOR_0": redder, "TEXCOORD_0": moved, "TEXCOORD_7": 99, "TANGENT": 99 }]);
    file.json["nodes"][0]["weights"] = json!([1]);
    let import = reads(&file);
    assert_eq!(
        super::file::carried(&import, |mesh| mesh.normals())[0],
        [1.0, 0.0, 0.0]
    );
    assert_eq!(
        super::file::carried(&import, |mesh| mesh.colors())[0],
        [0.7, 0.0, 0.2, 0.5]
    );
    assert_eq!(
        super::file::carried(&import, |mesh| mesh.texture())[1],
        [1.25, 0.5]
    );

    // A joint that stretches x turns a slanted normal the other way, and one that mirrors turns it over.
    for (scale, expected) in [
        ([2.0, 1.0, 1.0], [0.5, 0.0, 1.0]),
        ([-1.0, 1.0, 1.0], [-1.0, 0.0, 1.0]),
        ([1.0, 1.0, 0.0], [0.0, 0.0, 1.0]),
    ] {
        let mut file = File::leaf();
        let slanted = file.floats(&[1.0, 0.0, 1.0].repeat(3), 3);
        file.carry("NORMAL", slanted);
        let mut primitive = file.json["meshes"][0]["primitives"][0].clone();
        bind(&mut file, &mut primitive, &vec![vec![(0, 1.0)]; 3], FLOATS);
        file.json["meshes"][0]["primitives"][0] = primitive;
        let joint = file.node(json!({ "scale": scale }));
        file.push("skins", json!({ "joints": [joint] }));
        file.json["nodes"][0]["skin"] = json!(0);
        let import = reads(&file);
        let normal = import.rooms[0].geometry.meshes()[0].normals()[0];
        let length = expected.iter().map(|v: &f32| v * v).sum::<f32>().sqrt();
        let off: f32 = (0..3)
            .map(|axis| (normal[axis] - expected[axis] / length).abs())
            .sum();
        assert!(off < 1e-5, "{scale:?}: {normal:?}");
    }
}

#[test]
fn skins_and_targets_that_cannot_be_applied_are_refused_with_their_names() {
    let sound = || moved_by(&[[1.0, 0.0, 0.0]], &vec![vec![(0, 1.0)]; 6]);
    let mut file = sound();
    file.json["nodes"][0]["skin"] = json!(3);
    refuses(&file, &["node 0 \"body\"", "skin 3", "only 1"]);
    file = sound();
    file.json["skins"][0]["joints"] = json!([1, 77]);
    refuses(&file, &["skin 0 \"bones\"", "node 77", "only 2"]);
    file = sound();
    file.json["skins"][0]["joints"] = json!([]);
    refuses(&file, &["skin 0 \"bones\" has no joints"]);
    file = sound();
    file.json["skins"][0]["joints"] = json!("all");
    refuses(&file, &["skins[0]", "invalid type"]);
    let matrices = |numbers: &[f32], count: usize| {
        let mut file = sound();
        let bytes = numbers.iter().flat_map(|value| value.to_le_bytes()).collect();
        let accessor = file.accessor(5126, "MAT4", count, bytes);
        file.json["skins"][0]["inverseBindMatrices"] = json!(accessor);
        file
    };
    refuses(
        &matrices(&[], 0),
        &["skin 0 \"bones\" has 1 joints", "accessor 4", "0 inverse"],
    );
    let identity = as_f32([[1.0, 0.0, 0.0, 0.0], [0.0, 1.0, 0.0, 0.0], [0.0, 0.0, 1.0, 0.0]]);
    assert_eq!(
        reads(&matrices(&identity, 1)).rooms[0].geometry.bounds().min[0],
        1.0
    );
    let mut bad = identity.clone();
    bad[3] = 1.0;
    refuses(&matrices(&bad, 1), &["skin 0 \"bones\"", "joint 0", "last row"]);
    bad = identity.clone();
    bad[12] = f32::NAN;
    refuses(&matrices(&bad, 1), &["skin 0 \"bones\"", "joint 0", "not finite"]);
    file = sound();
    file.json["skins"][0]["inverseBindMatrices"] = json!(0);
    refuses(&file, &["accessor 0", "MAT4"]);
    let attribute = |file: &mut File, key: &str| {
        file.json["meshes"][0]["primitives"][0]["attributes"][key]
            .as_u64()
            .expect("an accessor")
    };
    file = sound();
    let joints = attribute(&mut file, "JOINTS_0");
    file.json["accessors"][joints as usize]["componentType"] = json!(5126);
    file.json["accessors"][joints as usize]["count"] = json!(3);
    refuses(&file, &[&format!("accessor {joints}"), "joints as VEC4"]);
    file = sound();
    let weights = attribute(&mut file, "WEIGHTS_0");
    file.json["accessors"][weights as usize]["count"] = json!(5);
    refuses(
        &file,
        &["meshes[0].primitives[0] has 5 sets of joint weights, but 6 positions"],
    );
    file = moved_by(
        &[[1.0, 0.0, 0.0]],
        &[
            vec![(0, 1.0)],
            vec![(0, 1.0)],
            vec![(9, 0.0), (0, 1.0)],
            vec![(4, 1.0)],
            vec![],
            vec![],
        ],
    );
    refuses(
        &file,
        &["meshes[0].primitives[0] has vertex 3 at joint 4, but skin 0 \"bones\" has only 1 joints"],
    );

    let with = |target: Value| {
        let mut file = morphed(&[UP, UP]);
        file.json["meshes"][0]["primitives"][0]["targets"][1] = target;
        file.json["meshes"][0]["weights"] = json!([0, 1]);
        file
    };
    refuses(
        &with(json!({ "POSITION": 50 })),
        &["meshes[0].primitives[0].targets[1]", "accessor 50"],
    );
    refuses(
        &with(json!({ "POSITION": 1 })),
        &["accessor 1", "positions as VEC3"],
    );
    let mut short = with(json!({}));
    let accessor = short.positions(&[[0.0; 3]; 2]);
    short.json["meshes"][0]["primitives"][0]["targets"][1] = json!({ "NORMAL": accessor });
    short.carry("NORMAL", 0);
    refuses(
        &short,
        &["meshes[0].primitives[0].targets[1] has 2 changes of normals, but 3 positions"],
    );
    let mut endless = with(json!({ "POSITION": 0 }));
    endless.json["meshes"][0]["weights"] = json!([0, 1e300]);
    refuses(&endless, &["meshes[0].primitives[0], in its pose,", "not finite"]);
}

#[test]
fn skins_and_targets_that_nothing_uses_may_be_broken() {
    let mut file = morphed(&[UP]);
    file.json["skins"] = json!([{ "joints": "none" }, 7]);
    file.json["meshes"][0]["primitives"][0]["targets"] = json!([{ "POSITION": 99 }]);
    file.json["meshes"][0]["weights"] = json!([0]);
    assert_eq!(warnings(&reads(&file)), [""; 0]);
}

#[test]
fn a_mesh_without_joints_follows_its_node_and_instances_of_a_skinned_one_are_one() {
    let mut file = File::leaf();
    file.json["nodes"][0]["skin"] = json!(0);
    file.json["nodes"][0]["translation"] = json!([0, 5, 0]);
    let joint = file.node(json!({ "translation": [100, 0, 0] }));
    file.push("skins", json!({ "joints": [joint] }));
    let import = reads(&file);
    assert_eq!(import.rooms[0].geometry.bounds().min, [0.0, 5.0, 0.0]);
    assert!(
        warnings(&import)[0].ends_with("(node 0 \"Leaf\", whose mesh has no joints)"),
        "{:?}",
        warnings(&import)
    );

    let mut file = moved_by(&[[1.0, 0.0, 0.0]], &vec![vec![(0, 1.0)]; 6]);
    let places = file.floats(&[0.0, 0.0, 0.0, 9.0, 9.0, 9.0], 3);
    file.json["nodes"][0]["extensions"] =
        json!({ "EXT_mesh_gpu_instancing": { "attributes": { "TRANSLATION": places } } });
    let import = reads(&file);
    assert_eq!(import.rooms[0].geometry.items().len(), 1);
    assert_eq!(
        warnings(&import),
        [
            "instances of skinned meshes are ignored: each mesh is drawn once, where its joints are (node 0 \"body\")"
        ]
    );
}

#[test]
fn poses_take_memory_that_is_asked_for_first() {
    let mut file = moved_by(&[[1.0, 0.0, 0.0]], &vec![vec![(0, 1.0)]; 6]);
    for number in 0..200 {
        let joint = file.node(json!({ "translation": [number, 0, 0] }));
        let skin = file.push("skins", json!({ "joints": vec![joint; 50] }));
        file.node(json!({ "mesh": 0, "skin": skin }));
    }
    let read = |limit_bytes| {
        let options = ReadOptions {
            limit_bytes,
            ..ReadOptions::default()
        };
        read_bytes(&file.glb(), None, &options)
            .map(drop)
            .map_err(|why| why.to_string())
    };
    assert_eq!(read(64 << 20), Ok(()));
    let why = read(2 << 20).expect_err("too little");
    assert!(why.contains("skin ") && why.contains("above the limit"), "{why}");
}

#[test]
fn a_mesh_with_more_targets_than_one_can_add_up_is_refused_at_once() {
    let mut file = morphed(&[]);
    let many = 400_000;
    file.json["accessors"][0] = json!({ "componentType": 5126, "type": "VEC3", "count": 3000 });
    file.json["meshes"][0]["primitives"] = json!([{
        "attributes": { "POSITION": 0 }, "targets": vec![json!({ "POSITION": 0 }); many]
    }]);
    file.json["meshes"][0]["weights"] = json!(vec![1; many]);
    let start = std::time::Instant::now();
    let why = read_bytes(
        &file.glb(),
        None,
        &ReadOptions {
            limit_bytes: 8 << 30,
            ..ReadOptions::default()
        },
    );
    let why = why.map(drop).expect_err("too many").to_string();
    assert!(
        why.contains("meshes[0] takes the sum of 1200000000 values"),
        "{why}"
    );
    assert!(start.elapsed().as_secs() < 30, "{:?}", start.elapsed());
}
