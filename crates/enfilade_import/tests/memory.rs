//! Memory bombs: small files that become large. Whatever a file holds, reading it takes at most twice the limit.
//!
//! Each file is read in a process of its own, which reports the most memory that was ever resident.
#![cfg(target_os = "linux")]
#![allow(clippy::print_stdout, reason = "the answer of the process that reads")]

use enfilade_import::{Import, Pages, ReadOptions, Room, bake, read, read_portals};
use serde_json::{Value, json};
use std::fmt::Write as _;
use std::fs;
use std::io::Cursor;
use std::path::Path;
use std::process::Command;
use xxhash_rust::xxh3::xxh3_64;

/// Limits at which each file is read, in bytes: it is refused at once, late, or read.
const LIMITS: [u64; 7] = [
    4 << 20,
    8 << 20,
    16 << 20,
    32 << 20,
    64 << 20,
    128 << 20,
    256 << 20,
];

/// Memory of a process that reads almost nothing, in bytes.
const BASE: u64 = 7 << 20;

const BOMB: &str = "ENFILADE_BOMB";

#[test]
#[ignore = "run by the other test, in a process of its own"]
fn read_the_file_that_is_named() {
    // None, if all ignored tests are run.
    let Ok(bomb) = std::env::var(BOMB) else { return };
    let (limit, path) = bomb.split_once(' ').expect("a limit, and a file");
    let path = Path::new(path);
    let options = ReadOptions {
        limit_bytes: limit.parse().expect("a limit"),
        ..ReadOptions::default()
    };
    let what = match path.extension().and_then(|ending| ending.to_str()) {
        Some("prt") => read_portals(path, &options).map(drop),
        Some("pages") => Pages::open(path, &options).map(|(_, pages)| {
            (0..pages.count()).for_each(|page| drop(pages.load(page)));
        }),
        _ => read(path, &options).map(drop),
    };
    let status = fs::read_to_string("/proc/self/status").expect("Linux");
    let peak = status.lines().find_map(|line| line.strip_prefix("VmHWM:"));
    let kib: u64 = peak
        .and_then(|line| line.trim().strip_suffix(" kB")?.parse().ok())
        .expect("a number");
    let what = what.map_or_else(|why| why.to_string(), |()| "read".to_owned());
    println!("peak={} {what}", 1024 * kib);
}

/// Reads a file with a limit. Returns the peak memory, in bytes, and the error.
fn peak(path: &Path, limit: u64) -> (u64, String) {
    let output = Command::new(std::env::current_exe().expect("this test"))
        .args([
            "--exact",
            "read_the_file_that_is_named",
            "--ignored",
            "--nocapture",
        ])
        .env(BOMB, format!("{limit} {}", path.display()))
        .env("RAYON_NUM_THREADS", "2")
        .output()
        .expect("it starts");
    let text = String::from_utf8_lossy(&output.stdout);
    let line = text.lines().find_map(|line| line.split_once("peak="));
    let (peak, what) = line
        .and_then(|(_, rest)| rest.split_once(' '))
        .unwrap_or_else(|| {
            panic!(
                "{}: {text}{}",
                path.display(),
                String::from_utf8_lossy(&output.stderr)
            )
        });
    (peak.parse().expect("bytes"), what.to_owned())
}

/// A file, and its name.
struct Bomb(&'static str, Vec<u8>);

/// What `heights.json` names.
const HEIGHTS: &str = "heights_u16le.raw";

#[test]
fn no_file_takes_more_than_twice_the_limit() {
    let folder = tempfile::tempdir().expect("a folder");
    let mut failures = String::new();
    for Bomb(name, bytes) in gltf()
        .into_iter()
        .chain(obj())
        .chain(tiles())
        .chain(quake())
        .chain(terrain())
        .chain(baked())
    {
        // A long path, because readers keep those of the files that are named.
        let long = folder.path().join("a".repeat(250)).join("b".repeat(250));
        fs::create_dir_all(&long).expect("a folder");
        let path = long.join(name);
        fs::write(&path, bytes).expect("written");
        if name == "heights.json" {
            fs::write(long.join(HEIGHTS), vec![7; 2 * 1500 * 1500]).expect("written");
        }
        let mut was_refused = false;
        for limit in LIMITS {
            let (peak, what) = peak(&path, limit);
            was_refused |= what.contains("above the limit");
            if peak > BASE + 2 * limit {
                let ratio = (peak - BASE) as f64 / limit as f64;
                let _ = writeln!(
                    failures,
                    "{name}: {ratio:.1} times {} MiB, {what:.90}",
                    limit >> 20
                );
            }
        }
        // Heights that do not fit stay in their file.
        if !was_refused && name != "heights.json" {
            let _ = writeln!(failures, "{name}: no limit refuses it, so it tests nothing");
        }
        fs::remove_file(path).expect("removed");
    }
    assert!(failures.is_empty(), "\n{failures}");
}

/// Joins what a function returns for each number.
fn list(count: usize, of: impl Fn(usize) -> String) -> String {
    (0..count).map(of).collect::<Vec<_>>().join(",")
}

fn gltf() -> Vec<Bomb> {
    const TRIANGLE: &str = r#""accessors":[{"componentType":5126,"type":"VEC3","count":3}]"#;
    const MESH: &str = r#"{"primitives":[{"attributes":{"POSITION":0}}]}"#;
    let file = |rest: String| format!(r#"{{"asset":{{"version":"2.0"}},{rest}}}"#).into_bytes();
    let with_node = |rest: String| {
        file(format!(
            r#"{rest},"nodes":[{{"mesh":0}}],"meshes":[{MESH}],{TRIANGLE}"#
        ))
    };
    let disc = |corners: usize| -> Vec<u8> {
        let rim = |at: usize| {
            let angle = std::f32::consts::TAU * at as f32 / corners as f32;
            [angle.cos(), angle.sin(), 0.0]
        };
        let fan = (1..corners - 1).flat_map(|at| [rim(0), rim(at), rim(at + 1)]);
        fan.flatten().flat_map(f32::to_le_bytes).collect()
    };
    let portals = {
        let disc = disc(400);
        let nodes = list(6000, |at| {
            format!(r#"{{"name":"-portal","mesh":0,"translation":[{},0,0]}}"#, 9 * at)
        });
        let json = file(format!(
            r#""nodes":[{{"name":"a-room","children":[1]}},{{"mesh":0}},{nodes}],"meshes":[{MESH}],
            "accessors":[{{"bufferView":0,"componentType":5126,"type":"VEC3","count":{}}}],
            "bufferViews":[{{"buffer":0,"byteLength":{1}}}],"buffers":[{{"byteLength":{1}}}]"#,
            disc.len() / 12,
            disc.len()
        ));
        glb(json, disc)
    };
    vec![
        Bomb(
            "roots.gltf",
            with_node(format!(
                r#""scenes":[{{"nodes":[{}]}}]"#,
                list(800_000, |_| "0".to_owned())
            )),
        ),
        Bomb("portals.glb", portals),
        Bomb(
            "images.gltf",
            with_node(format!(
                r#""images":[{}]"#,
                list(60_000, |_| r#"{"uri":"a"}"#.to_owned())
            )),
        ),
        Bomb(
            "nulls.gltf",
            with_node(list(300_000, |at| format!(r#""x{at}":null"#))),
        ),
        Bomb(
            "scenes.gltf",
            with_node(format!(
                r#""scenes":[{}]"#,
                list(200_000, |at| format!(r#"{{"name":"{at}"}}"#))
            )),
        ),
        // Each node has a pose of its own, and so a copy of the mesh.
        Bomb(
            "weights.gltf",
            file(format!(
                r#""nodes":[{}],"meshes":[{{"primitives":[{{"attributes":{{"POSITION":0}},"targets":[{{"POSITION":1}}]}}]}}],
                "accessors":[{{"componentType":5126,"type":"VEC3","count":3000}},{{"componentType":5126,"type":"VEC3","count":3000}}]"#,
                list(500, |at| format!(r#"{{"mesh":0,"weights":[{}]}}"#, at + 1))
            )),
        ),
        Bomb(
            "targets.gltf",
            file(format!(
                r#""nodes":[{{"mesh":0}}],"meshes":[{{"weights":[{}],"primitives":[{{"attributes":{{"POSITION":0}},"targets":[{}]}}]}}],
                {TRIANGLE}"#,
                list(100_000, |_| "1".to_owned()),
                list(100_000, |_| r#"{"POSITION":0}"#.to_owned())
            )),
        ),
        Bomb(
            "joint_sets.gltf",
            file(format!(
                r#""nodes":[{{"mesh":0,"skin":0}}],"skins":[{{"joints":[0]}}],"meshes":[{{"primitives":[{{"attributes":{{"POSITION":0,{}}}}}]}}],
                "accessors":[{{"componentType":5126,"type":"VEC3","count":3}},{{"componentType":5121,"type":"VEC4","count":3}}]"#,
                list(100_000, |at| format!(r#""JOINTS_{at}":1,"WEIGHTS_{at}":1"#))
            )),
        ),
        Bomb(
            "skins.gltf",
            file(format!(
                r#""nodes":[{}],"skins":[{}],"meshes":[{{"primitives":[{{"attributes":{{"POSITION":0,"JOINTS_0":1,"WEIGHTS_0":1}}}}]}}],
                "accessors":[{{"componentType":5126,"type":"VEC3","count":3}},{{"componentType":5121,"type":"VEC4","count":3}}]"#,
                list(50, |at| format!(r#"{{"mesh":0,"skin":{at}}}"#)),
                list(50, |_| format!(
                    r#"{{"joints":[{}]}}"#,
                    list(20_000, |_| "0".to_owned())
                ))
            )),
        ),
        Bomb(
            "extensions.gltf",
            with_node(format!(
                r#""extensionsUsed":[{}]"#,
                list(300_000, |at| format!("\"{at:x}\""))
            )),
        ),
        Bomb(
            "meshes.gltf",
            file(format!(
                r#""nodes":[{}],"meshes":[{}],{TRIANGLE}"#,
                list(20_000, |at| format!(r#"{{"mesh":{at}}}"#)),
                list(20_000, |_| MESH.to_owned())
            )),
        ),
        Bomb(
            "rooms.gltf",
            file(format!(
                r#""nodes":[{},{{"mesh":0}}],"meshes":[{MESH}],{TRIANGLE}"#,
                list(30_000, |at| format!(r#"{{"name":"{at:x}-room"}}"#))
            )),
        ),
        Bomb(
            "items.gltf",
            file(format!(
                r#""nodes":[{}],"meshes":[{MESH}],{TRIANGLE}"#,
                list(90_000, |_| r#"{"mesh":0}"#.to_owned())
            )),
        ),
    ]
}

fn glb(mut json: Vec<u8>, mut binary: Vec<u8>) -> Vec<u8> {
    json.resize(json.len().next_multiple_of(4), b' ');
    binary.resize(binary.len().next_multiple_of(4), 0);
    let word = |number: usize| (number as u32).to_le_bytes();
    let header = [*b"glTF", word(2), word(28 + json.len() + binary.len())].concat();
    [
        header,
        word(json.len()).to_vec(),
        b"JSON".to_vec(),
        json,
        word(binary.len()).to_vec(),
        b"BIN\0".to_vec(),
        binary,
    ]
    .concat()
}

fn tiles() -> Vec<Bomb> {
    let leaf = || {
        let json = r#"{"asset":{"version":"2.0"},"nodes":[{"mesh":0}],
            "meshes":[{"primitives":[{"attributes":{"POSITION":0}}]}],
            "accessors":[{"bufferView":0,"componentType":5126,"type":"VEC3","count":3}],
            "bufferViews":[{"buffer":0,"byteLength":36}],"buffers":[{"byteLength":36}]}"#;
        let corners = [0_f32, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0, 0.0];
        glb(
            json.into(),
            corners.iter().flat_map(|part| part.to_le_bytes()).collect(),
        )
    };
    let tile = |features: String, numbers: Vec<u8>| {
        let model = leaf();
        let length = 32 + features.len() + numbers.len() + model.len();
        let fields = [1, length, features.len(), numbers.len(), 0, 0, 1];
        let mut bytes = b"i3dm".to_vec();
        bytes.extend(fields.iter().flat_map(|&field| (field as u32).to_le_bytes()));
        bytes.extend(features.bytes().chain(numbers).chain(model));
        bytes
    };
    let count = 300_000;
    let packed = format!(
        "{{\"INSTANCES_LENGTH\":{count},\"POSITION_QUANTIZED\":{{\"byteOffset\":0}},\
        \"QUANTIZED_VOLUME_OFFSET\":[0,0,0],\"QUANTIZED_VOLUME_SCALE\":[1,1,1]}}"
    );
    let listed = format!(
        "{{\"INSTANCES_LENGTH\":{count},\"POSITION\":[{}]}}",
        list(3 * count, |_| "0".to_owned())
    );
    let other = format!(
        "{{\"INSTANCES_LENGTH\":0,\"POSITION\":[{}]}}",
        list(3_000_000, |_| "0".to_owned())
    );
    vec![
        Bomb("packed.i3dm", tile(packed, vec![0; 6 * count])),
        Bomb("listed.i3dm", tile(listed, Vec::new())),
        Bomb("other.i3dm", tile(other, Vec::new())),
    ]
}

fn obj() -> Vec<Bomb> {
    const CORNERS: &str = "v 0 0 0\nv 1 0 0\nv 0 1 0\n";
    let groups: String = (0..40_000).map(|at| format!("g {at:x}\nf 1 2 3\n")).collect();
    let files: String = (0..90_000).map(|at| format!("{at:x}.mtl ")).collect();
    let positions: String = (0..99)
        .map(|at| format!("v {} {} 0\n", at * 7919 % 97, at * 104_729 % 89))
        .collect();
    let polygon: String = (0..40_000_u64)
        .map(|at| format!(" {}", 1 + at * at % 99))
        .collect();
    vec![
        Bomb("groups.obj", format!("{CORNERS}{groups}").into_bytes()),
        Bomb(
            "files.obj",
            format!("mtllib {files}\n{CORNERS}f 1 2 3\n").into_bytes(),
        ),
        Bomb("polygon.obj", format!("{positions}f{polygon}\n").into_bytes()),
    ]
}

/// A map of one triangle, in BSP29, with other lumps.
fn map(changed: &[(usize, Vec<u8>)]) -> Vec<u8> {
    let words =
        |numbers: &[i32]| -> Vec<u8> { numbers.iter().flat_map(|number| number.to_le_bytes()).collect() };
    let shorts =
        |numbers: &[i16]| -> Vec<u8> { numbers.iter().flat_map(|number| number.to_le_bytes()).collect() };
    let floats =
        |numbers: &[f32]| -> Vec<u8> { numbers.iter().flat_map(|number| number.to_le_bytes()).collect() };
    let mut lumps = vec![Vec::new(); 15];
    lumps[0] = WORLD.as_bytes().to_vec();
    lumps[1] = [floats(&[0.0, 0.0, 1.0, 0.0]), words(&[2])].concat();
    lumps[3] = floats(&[0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0, 0.0]);
    lumps[5] = [words(&[0]), shorts(&[-2, -1, -9, -9, -9, 9, 9, 9, 0, 1])].concat();
    lumps[6] = [floats(&[1.0, 0.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0]), words(&[0, 0])].concat();
    lumps[7] = FACE.to_vec();
    lumps[10] = [leaf(-2, 0, 0), leaf(-1, 0, 1)].concat();
    lumps[11] = shorts(&[0]);
    lumps[12] = shorts(&[0, 1, 1, 2, 2, 0]);
    lumps[13] = words(&[0, 1, 2]);
    lumps[14] = model(0, 1, 1);
    for (number, lump) in changed {
        lumps[*number].clone_from(lump);
    }
    with_lumps(&words(&[29]), lumps)
}

/// A map of these lumps.
fn with_lumps(magic: &[u8], lumps: Vec<Vec<u8>>) -> Vec<u8> {
    let mut map = magic.to_vec();
    let mut at = magic.len() + 8 * lumps.len();
    for lump in &lumps {
        let entry = [at, lump.len()].map(|number| (number as u32).to_le_bytes());
        map.extend(entry.concat());
        at += lump.len().next_multiple_of(4);
    }
    for lump in lumps {
        map.extend(lump);
        map.resize(map.len().next_multiple_of(4), 0);
    }
    map
}

const WORLD: &str = r#"{"classname" "worldspawn"}"#;

/// Three edges on plane 0, without light.
const FACE: [u8; 20] = [
    0, 0, 0, 0, 0, 0, 0, 0, 3, 0, 0, 0, 255, 255, 255, 255, 255, 255, 255, 255,
];

fn leaf(contents: i32, first: u16, count: u16) -> Vec<u8> {
    let mut leaf = [contents.to_le_bytes(), (-1_i32).to_le_bytes()].concat();
    leaf.extend(
        [-9_i16, -9, -9, 9, 9, 9]
            .iter()
            .flat_map(|number| number.to_le_bytes()),
    );
    leaf.extend(
        [first, count, 0, 0]
            .iter()
            .flat_map(|number| number.to_le_bytes()),
    );
    leaf
}

fn model(first: i32, count: i32, leafs: i32) -> Vec<u8> {
    let mut model: Vec<u8> = [-9.0_f32, -9.0, -9.0, 9.0, 9.0, 9.0, 0.0, 0.0, 0.0]
        .iter()
        .flat_map(|number| number.to_le_bytes())
        .collect();
    model.extend(
        [0, 0, 0, 0, leafs, first, count]
            .iter()
            .flat_map(|number| number.to_le_bytes()),
    );
    model
}

fn quake() -> Vec<Bomb> {
    let textures = {
        let count: u32 = 300_000;
        let mut lump = count.to_le_bytes().to_vec();
        lump.extend((0..count).flat_map(|_| (4 + 4 * count).to_le_bytes()));
        // A name that is no UTF-8 becomes three times as long.
        lump.extend([255; 16]);
        lump.extend(
            [16_u32, 16, 40, 0, 0, 0]
                .iter()
                .flat_map(|number| number.to_le_bytes()),
        );
        lump
    };
    let models: usize = 20_000;
    let entities: String = (1..=models)
        .map(|number| format!(r#"{{"model" "*{number}"}}"#))
        .collect();
    let faces: u16 = 20_000;
    let leafs = (0..faces).map(|face| leaf(-1, face, 1));
    let leafs: Vec<Vec<u8>> = std::iter::once(leaf(-2, 0, 0)).chain(leafs).collect();
    let count = i32::from(faces);
    let winding = "(0 0 0) ".repeat(3);
    let portals: String = (0..60_000).map(|_| format!("3 0 1 {winding}\n")).collect();
    vec![
        Bomb("textures.bsp", map(&[(2, textures)])),
        Bomb(
            "models.bsp",
            map(&[
                (14, model(0, 1, 1).repeat(models + 1)),
                (0, format!("{WORLD}{entities}").into_bytes()),
            ]),
        ),
        Bomb(
            "leafs.bsp",
            map(&[
                (7, FACE.repeat(faces.into())),
                (10, leafs.concat()),
                (11, (0..faces).flat_map(u16::to_le_bytes).collect()),
                (14, model(0, count, count)),
            ]),
        ),
        Bomb("patches.bsp", patches()),
        Bomb("portals.prt", format!("PRT1\n2\n60000\n{portals}").into_bytes()),
    ]
}

/// A map of one triangle in 20,000 patches of the same nine corners, in IBSP46.
fn patches() -> Vec<u8> {
    let words =
        |numbers: &[i32]| -> Vec<u8> { numbers.iter().flat_map(|number| number.to_le_bytes()).collect() };
    let floats =
        |numbers: &[f32]| -> Vec<u8> { numbers.iter().flat_map(|number| number.to_le_bytes()).collect() };
    let count = 20_000;
    let mut lumps = vec![Vec::new(); 17];
    lumps[0] = WORLD.as_bytes().to_vec();
    let mut texture = b"textures/wall".to_vec();
    texture.resize(64, 0);
    lumps[1] = [texture, words(&[0, 1])].concat();
    lumps[2] = floats(&[0.0, 0.0, 1.0, 0.0]);
    lumps[3] = words(&[0, -1, -2, -9, -9, -9, 9, 9, 9]);
    lumps[4] = [
        words(&[-1, 0, -9, -9, -9, 9, 9, 9, 0, 0, 0, 0]),
        words(&[0, 0, -9, -9, -9, 9, 9, 9, 0, count, 0, 0]),
    ]
    .concat();
    lumps[5] = (0..count).flat_map(i32::to_le_bytes).collect();
    lumps[7] = [
        floats(&[-9.0, -9.0, -9.0, 9.0, 9.0, 9.0]),
        words(&[0, count, 0, 0]),
    ]
    .concat();
    for corner in 0_u8..9 {
        let place = [f32::from(corner % 3), f32::from(corner / 3), 0.0];
        lumps[10].extend(floats(&place));
        lumps[10].extend(vec![0; 32]);
    }
    let mut face = words(&[0, -1, 2, 0, 9, 0, 0, -1]);
    face.resize(96, 0);
    face.extend(words(&[3, 3]));
    lumps[13] = face.repeat(count as usize);
    with_lumps(b"IBSP\x2e\0\0\0", lumps)
}

fn terrain() -> Vec<Bomb> {
    let described = json!({
        "width": 1500, "height": 1500, "format": "u16 little endian", "cellMetresX": 1, "cellMetresZ": 1, "file": HEIGHTS
    });
    vec![Bomb("heights.json", described.to_string().into_bytes())]
}

/// The sections of a baked scene, by kind and number.
struct Baked(Vec<([u32; 2], Vec<u8>)>, u32);

impl Baked {
    /// One triangle.
    fn triangle() -> Baked {
        let mut room = enfilade::GeometryBuilder::new([enfilade::Material::opaque([0.5; 3])]);
        let corners = [[0.0; 3], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]];
        let mesh =
            enfilade::Mesh::triangles(&corners, &[0, 1, 2], enfilade::MaterialId(0)).expect("a triangle");
        let mesh = room.mesh(mesh);
        room.item("a", mesh, enfilade::Transform::IDENTITY);
        let import = Import::of_rooms(vec![Room::new("a", room.build().expect("a room"))]);
        let mut file = Cursor::new(Vec::new());
        bake(&import, &mut file).expect("baked");
        let file = file.into_inner();
        let word = |at: usize| u64::from_le_bytes(file[at..at + 8].try_into().expect("eight")) as usize;
        let half = |at: usize| u32::from_le_bytes(file[at..at + 4].try_into().expect("four"));
        let (count, table) = (half(12) as usize, word(16));
        let entries = (0..count).map(|entry| table + 32 * entry);
        let section = |at: usize| {
            (
                [half(at), half(at + 4)],
                file[word(at + 8)..][..word(at + 16)].to_vec(),
            )
        };
        Baked(entries.map(section).collect(), half(8))
    }

    fn section(&mut self, kind: u32) -> &mut Vec<u8> {
        let found = self.0.iter_mut().find(|(id, _)| *id == [kind, 0]);
        &mut found.expect("a section").1
    }

    /// Changes the tables of the scene.
    fn scene(mut self, change: impl FnOnce(&mut Value)) -> Baked {
        let mut scene: Value = rmp_serde::from_slice(self.section(1)).expect("MessagePack");
        change(&mut scene);
        *self.section(1) = rmp_serde::to_vec_named(&scene).expect("MessagePack");
        self
    }

    fn bytes(self) -> Vec<u8> {
        let mut file = vec![0; 64];
        let mut table = Vec::new();
        let count = self.0.len() as u32;
        for ([kind, number], section) in self.0 {
            file.resize(file.len().next_multiple_of(64), 0);
            table.extend([kind, number].iter().flat_map(|number| number.to_le_bytes()));
            let entry = [file.len() as u64, section.len() as u64, xxh3_64(&section)];
            table.extend(entry.iter().flat_map(|number| number.to_le_bytes()));
            file.extend(section);
        }
        file.resize(file.len().next_multiple_of(64), 0);
        let numbers = [file.len(), file.len() + table.len()].map(|number| number as u64);
        let version = self.1.to_le_bytes();
        let mut header = [&b"ENFILADE"[..], &version, &count.to_le_bytes()].concat();
        header.extend(numbers.iter().flat_map(|number| number.to_le_bytes()));
        header.extend(xxh3_64(&table).to_le_bytes());
        header.extend([0; 16]);
        let checksum = xxh3_64(&header);
        header.extend(checksum.to_le_bytes());
        file[..64].copy_from_slice(&header);
        [file, table].concat()
    }
}

fn baked() -> Vec<Bomb> {
    let scene = |change: fn(&mut Value)| Baked::triangle().scene(change).bytes();
    let rooms = Baked::triangle().scene(|scene| {
        let mut room = scene["rooms"][0].clone();
        room["items"] = json!(0);
        room["meshes"] = json!([]);
        let rooms = scene["rooms"].as_array_mut().expect("rooms");
        rooms.extend(vec![room; 20_000]);
    });
    // All of the same bytes.
    let pages = {
        let mut pages = Baked::triangle();
        let record = pages.section(2).clone();
        *pages.section(2) = record.repeat(60_000);
        pages.bytes()
    };
    let hints = {
        let mut hints = Baked::triangle();
        let region = [&0_u32.to_le_bytes()[..], &[0; 24]].concat();
        hints.0.push(([8, 0], [region, [0; 8].repeat(700_000)].concat()));
        hints.bytes()
    };
    let clusters = {
        let mut clusters = Baked::triangle();
        let mesh = clusters
            .0
            .iter()
            .find(|(id, _)| id[0] == 5)
            .expect("a page")
            .1
            .clone();
        let size = mesh.len() as u32;
        let mut record = clusters.section(2).clone();
        let mut records = Vec::new();
        for number in 0..30_000 {
            record[4..8].copy_from_slice(&(number * size).to_le_bytes());
            record[16..24].fill(0);
            records.extend_from_slice(&record);
        }
        *clusters.section(2) = records;
        let page = clusters.0.iter_mut().find(|(id, _)| id[0] == 5).expect("a page");
        page.1 = mesh.repeat(30_000);
        clusters
    };
    let image = {
        let side: u32 = 1500;
        let mut png = Cursor::new(Vec::new());
        let black = image::ImageBuffer::<image::Rgba<u16>, _>::new(side, side);
        black
            .write_to(&mut png, image::ImageFormat::Png)
            .expect("written");
        let mut baked = Baked::triangle().scene(|scene| {
            let texture = json!({ "name": "a", "size": [1500, 1500], "wrap": ["Repeat", "Repeat"], "magnify": "Linear",
                "minify": { "texels": "Linear", "levels": null } });
            scene["textures"] = json!([texture, texture]);
        });
        baked
            .0
            .extend([0, 1].map(|number| ([6, number], png.get_ref().clone())));
        baked.bytes()
    };
    vec![
        Bomb(
            "materials.enf",
            scene(|scene| scene["materials"] = many_empty(1_000_000)),
        ),
        Bomb(
            "tables.enf",
            scene(|scene| scene["texture_tables"] = many_empty(1_000_000)),
        ),
        Bomb(
            "reasons.enf",
            scene(|scene| scene["non_occluders"] = json!(vec![json!({}); 1_000_000])),
        ),
        Bomb(
            "warnings.enf",
            scene(|scene| {
                let names = vec![json!(""); 1_000_000];
                scene["warnings"] = json!([{ "kind": "Points", "count": 1_000_000, "first": names }]);
            }),
        ),
        Bomb(
            "list.enf",
            scene(|scene| scene["rooms"][0]["meshes"] = json!(vec![0; 1_000_000])),
        ),
        Bomb("rooms.enf", rooms.bytes()),
        Bomb("records.enf", pages.clone()),
        Bomb("records.pages", pages),
        Bomb("hints.enf", hints),
        Bomb("meshes.enf", clusters.bytes()),
        Bomb("images.enf", image),
    ]
}

fn many_empty(count: usize) -> Value {
    json!(vec![json!([]); count])
}
