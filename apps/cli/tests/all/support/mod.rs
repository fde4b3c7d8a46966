//! Runs the program in a temporary folder with a small scene.

pub(crate) mod map;
pub(crate) mod quake;
pub(crate) mod schema;

use serde_json::{Value, json};
use std::path::PathBuf;
use std::process::{Command, Output, Stdio};
use tempfile::TempDir;

/// A temporary folder with `scene.glb`, `views.jsonl` and the files a test adds.
pub(crate) struct Folder(TempDir);

/// Result of a run.
pub(crate) struct Run {
    pub(crate) code: Option<i32>,
    pub(crate) stdout: String,
    pub(crate) stderr: String,
}

impl Run {
    /// Returns standard error without notes on the survey, on approximate methods and on maps that are overwritten.
    pub(crate) fn complaints(&self) -> String {
        let is_note = |line: &str| {
            line.starts_with("survey: ")
                || line.contains(" is approximate: ")
                || line.contains(" will be overwritten")
        };
        let lines = self.stderr.lines().filter(|line| !is_note(line));
        lines.collect::<Vec<_>>().join("\n")
    }
}

impl Folder {
    pub(crate) fn new() -> Folder {
        let folder = Folder::empty();
        folder.add("scene.glb", glb(&yard()));
        folder.add("views.jsonl", VIEWS);
        folder
    }

    pub(crate) fn empty() -> Folder {
        Folder(tempfile::tempdir().expect("a folder"))
    }

    pub(crate) fn path(&self, name: &str) -> PathBuf {
        self.0.path().join(name)
    }

    pub(crate) fn add(&self, name: &str, bytes: impl AsRef<[u8]>) {
        std::fs::write(self.path(name), bytes).expect("written");
    }

    pub(crate) fn names(&self) -> Vec<String> {
        let entries = std::fs::read_dir(self.0.path()).expect("a folder");
        let mut names: Vec<String> = entries
            .map(|entry| {
                entry
                    .expect("an entry")
                    .file_name()
                    .to_string_lossy()
                    .into_owned()
            })
            .collect();
        names.sort();
        names
    }

    /// Runs `enfilade` with arguments that hold no spaces.
    pub(crate) fn run(&self, arguments: &str) -> Run {
        let output = self.command(arguments).output().expect("it starts");
        Run::from(output)
    }

    /// Runs it with standard output closed by the reader.
    pub(crate) fn run_unread(&self, arguments: &str) -> Run {
        let mut child = self
            .command(arguments)
            .stdout(Stdio::piped())
            .stderr(Stdio::piped())
            .spawn()
            .expect("it starts");
        drop(child.stdout.take());
        Run::from(child.wait_with_output().expect("it ends"))
    }

    /// Asserts that it succeeds, and returns the JSON on its standard output.
    pub(crate) fn json(&self, arguments: &str) -> Value {
        let run = self.run(&format!("{arguments} --json -"));
        assert_eq!(run.code, Some(0), "{arguments}: {}", run.stderr);
        serde_json::from_str(&run.stdout).unwrap_or_else(|error| panic!("{error}: {}", run.stdout))
    }

    pub(crate) fn command(&self, arguments: &str) -> Command {
        let mut command = Command::new(env!("CARGO_BIN_EXE_enfilade"));
        command
            .args(arguments.split_whitespace())
            .current_dir(self.0.path());
        command
    }
}

impl From<Output> for Run {
    fn from(output: Output) -> Run {
        let text = |bytes: Vec<u8>| String::from_utf8(bytes).expect("text");
        Run {
            code: output.status.code(),
            stdout: text(output.stdout),
            stderr: text(output.stderr),
        }
    }
}

pub(crate) const VIEWS: &str = r#"{"eye": [0, 1.5, 6], "toward": [0, 1, 0]}

{"name": "behind", "eye": [0, 1.5, -6], "toward": [0, 1, 0], "up": [0, 1, 0], "fov": 50}
"#;

/// A wall across a floor, a table in front of it and a chest behind it; cameras on both sides and one in the wall.
pub(crate) fn yard() -> Value {
    let item = |name: &str, translation: [f32; 3], scale: [f32; 3]| {
        json!({
            "name": name, "mesh": 0, "translation": translation, "scale": scale
        })
    };
    let camera = |name: &str, translation: [f32; 3], rotation: [f32; 4]| {
        json!({
            "name": name, "camera": 0, "translation": translation, "rotation": rotation
        })
    };
    let nodes = [
        item("floor", [0.0, -0.1, 0.0], [20.0, 0.2, 20.0]),
        item("wall", [0.0, 1.4, 0.0], [8.0, 3.0, 1.0]),
        item("table", [0.0, 0.4, 2.0], [1.0, 1.0, 1.0]),
        item("chest", [0.0, 0.3, -3.0], [0.6, 0.6, 0.6]),
        camera("front", [0.0, 1.2, 6.0], [0.0, 0.0, 0.0, 1.0]),
        camera("back", [0.0, 1.2, -6.0], [0.0, 1.0, 0.0, 0.0]),
        camera("walled-in", [0.0, 1.2, 0.0], [0.0, 0.0, 0.0, 1.0]),
    ];
    document(
        &nodes,
        json!([{ "perspective": { "yfov": 0.9, "znear": 0.01 }, "type": "perspective" }]),
    )
}

/// A document whose mesh 0 is a cube of side 1.
pub(crate) fn document(nodes: &[Value], cameras: Value) -> Value {
    let mut document = json!({
        "asset": { "version": "2.0" },
        "scene": 0,
        "scenes": [{ "nodes": (0..nodes.len()).collect::<Vec<_>>() }],
        "nodes": nodes,
        "meshes": [{ "primitives": [{ "attributes": { "POSITION": 0 }, "indices": 1 }] }],
        "accessors": [
            { "bufferView": 0, "componentType": 5126, "type": "VEC3", "count": 8,
              "min": [-0.5, -0.5, -0.5], "max": [0.5, 0.5, 0.5] },
            { "bufferView": 1, "componentType": 5121, "type": "SCALAR", "count": 36 },
        ],
        "bufferViews": [
            { "buffer": 0, "byteOffset": 0, "byteLength": 96 },
            { "buffer": 0, "byteOffset": 96, "byteLength": 36 },
        ],
        "buffers": [{ "byteLength": 132 }],
    });
    if cameras.as_array().is_some_and(|cameras| !cameras.is_empty()) {
        document["cameras"] = cameras;
    }
    document
}

/// A document as a .glb, with the cube as its binary chunk.
pub(crate) fn glb(document: &Value) -> Vec<u8> {
    let mut text = document.to_string().into_bytes();
    text.resize(text.len().next_multiple_of(4), b' ');
    let cube = cube();
    let mut file = Vec::new();
    file.extend(b"glTF");
    file.extend(2_u32.to_le_bytes());
    file.extend((12 + 8 + text.len() as u32 + 8 + cube.len() as u32).to_le_bytes());
    for (chunk, kind) in [(text, b"JSON"), (cube, b"BIN\0")] {
        file.extend((chunk.len() as u32).to_le_bytes());
        file.extend(kind);
        file.extend(chunk);
    }
    file
}

/// The faces of a box whose corner i is at the greater end of axis a where bit a of i is set; counter-clockwise from outside.
pub(crate) const BOX_QUADS: [[u8; 4]; 6] = [
    [0, 4, 6, 2],
    [1, 3, 7, 5],
    [0, 1, 5, 4],
    [2, 6, 7, 3],
    [0, 2, 3, 1],
    [4, 5, 7, 6],
];

/// A cube of side 1 about the origin.
pub(crate) fn cube() -> Vec<u8> {
    let corner = |i: u8| [0, 1, 2].map(|axis| if i >> axis & 1 == 1 { 0.5_f32 } else { -0.5 });
    let positions = (0..8).flat_map(corner).flat_map(f32::to_le_bytes);
    let indices = BOX_QUADS.into_iter().flat_map(|[a, b, c, d]| [a, b, c, a, c, d]);
    positions.chain(indices).collect()
}
