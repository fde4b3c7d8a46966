//! Recorded camera paths: JSON lines, one view each, as `--path` of the program reads them.

use anyhow::{Context, Result, bail};
use enfilade::Camera;
use serde::{Deserialize, Serialize};

/// Other keys of a line are ignored, as by the program.
#[derive(Serialize, Deserialize)]
struct Line {
    eye: [f64; 3],
    toward: [f64; 3],
    #[serde(default = "upright")]
    up: [f64; 3],
    /// Degrees.
    #[serde(default = "sixty")]
    fov: f64,
}

fn upright() -> [f64; 3] {
    [0.0, 1.0, 0.0]
}

fn sixty() -> f64 {
    60.0
}

/// Writes cameras as lines.
pub fn write(cameras: &[Camera]) -> String {
    let line = |camera: &Camera| {
        let line = Line {
            eye: camera.eye,
            toward: camera.toward,
            up: camera.up,
            fov: f64::from(camera.fov_y.to_degrees()),
        };
        serde_json::to_string(&line).expect("numbers") + "\n"
    };
    cameras.iter().map(line).collect()
}

/// Writes cameras to a new file `camera-path.jsonl` in the current folder, or `camera-path-2.jsonl` and so on: no file is
/// replaced. Returns its name.
///
/// # Errors
/// If the folder cannot be written to.
#[cfg(not(target_arch = "wasm32"))]
pub fn save(cameras: &[Camera]) -> Result<String> {
    use std::io::{ErrorKind, Write};
    for number in 1.. {
        let name = match number {
            1 => "camera-path.jsonl".to_owned(),
            _ => format!("camera-path-{number}.jsonl"),
        };
        match std::fs::File::create_new(&name) {
            Ok(mut file) => {
                file.write_all(write(cameras).as_bytes())
                    .and_then(|()| file.sync_all())
                    .with_context(|| format!("cannot write {name}"))?;
                return Ok(name);
            }
            Err(why) if why.kind() == ErrorKind::AlreadyExists => {}
            Err(why) => return Err(why).with_context(|| format!("cannot write {name}")),
        }
    }
    bail!("too many files are called camera-path")
}

/// Reads cameras from lines.
///
/// # Errors
/// If a line is no view, or there is none.
pub fn read(text: &str) -> Result<Vec<Camera>> {
    let lines = text
        .lines()
        .enumerate()
        .filter(|(_, line)| !line.trim().is_empty());
    let mut cameras = Vec::new();
    for (number, line) in lines {
        let place = || format!("line {}", number + 1);
        let line: Line = serde_json::from_str(line).with_context(place)?;
        let camera = Camera {
            up: line.up,
            fov_y: line.fov.to_radians() as f32,
            ..Camera::new(line.eye, line.toward)
        };
        camera.view([64, 64]).with_context(place)?;
        cameras.push(camera);
    }
    if cameras.is_empty() {
        bail!("it has no views: lines of {{\"eye\":[x,y,z],\"toward\":[x,y,z]}}");
    }
    Ok(cameras)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_path_that_is_written_and_read_is_the_same() {
        let cameras = [
            Camera::new([1.0, 2.0, 3.0], [0.1, 0.2, 0.3]),
            Camera::new([0.0; 3], [0.0, 0.0, -1.0]),
        ];
        let again = read(&write(&cameras)).expect("it reads what it writes");
        assert_eq!(again.len(), 2);
        assert_eq!(
            (again[0].eye, again[0].toward),
            (cameras[0].eye, cameras[0].toward)
        );
        assert!((again[1].fov_y - cameras[1].fov_y).abs() < 1e-6);
        let named = r#"{"name": "door", "eye": [0, 1, 2], "toward": [3, 4, 5]}"#;
        assert_eq!(read(named).expect("as the program reads it").len(), 1);
        for broken in [r#"{"eye":[1,2]}"#, r#"{"eye":[1,2,3],"toward":[1,2,3]}"#] {
            let error = format!("{:#}", read(&format!("\n{broken}")).expect_err("no view"));
            assert!(error.starts_with("line 2"), "{error}");
        }
    }
}
