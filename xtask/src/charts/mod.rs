//! Charts of the cost of every method on every scene, and in every room of the palace, for the book's chapter on choosing
//! a method.
//!
//! The program measures each scene once (`bench` and `choose`, one thread). Its reports are cached in `target/charts`.

mod matrix;

use crate::targets::cargo;
use anyhow::{Context, Result, ensure};
use enfilade::Method;
use matrix::{Row, draw, significant};
use serde_json::Value;
use std::fs;
use std::path::{Path, PathBuf};
use std::process::Command;

/// Inputs and the output folder.
#[derive(clap::Args)]
pub(crate) struct Args {
    /// Folder of real scenes
    #[arg(long, value_name = "FOLDER", env = "ENFILADE_SCENES")]
    scenes: PathBuf,
    /// Output folder
    #[arg(long, value_name = "FOLDER", default_value = "book/src/pictures")]
    output: PathBuf,
    /// Views of each scene
    #[arg(long, value_name = "N", default_value_t = 8)]
    views: u32,
}

/// Scenes with more triangles get fewer views: some methods take seconds per view.
const MANY_TRIANGLES: u64 = 500_000;
const FEW_VIEWS: u32 = 2;

/// A quantity, its path in the report of a method, and its format.
struct Quantity {
    file: &'static str,
    title: &'static str,
    value: fn(&Value) -> Option<f64>,
    written: fn(f64) -> String,
    /// Whether the second of two methods that share a tree reuses the first one's value.
    is_shared: bool,
}

/// A quantity of the palace's rooms, and its path in the report of `choose`.
struct RoomQuantity {
    file: &'static str,
    title: &'static str,
    aim: &'static str,
    key: &'static str,
    /// Divisor from the report's unit to the chart's.
    unit: f64,
    /// Smaller values are shown as this one.
    least: f64,
    is_shared: bool,
}

const ROOMS: [RoomQuantity; 4] = [
    RoomQuantity {
        file: "which-rooms-look.svg",
        title: "rooms of the palace: look, ms",
        aim: "look",
        key: "frame_ms",
        unit: 1.0,
        least: 0.0,
        is_shared: false,
    },
    RoomQuantity {
        file: "which-rooms-draw.svg",
        title: "rooms of the palace: look and draw, no shading, ms",
        aim: "draw",
        key: "frame_ms",
        unit: 1.0,
        least: 0.0,
        is_shared: false,
    },
    RoomQuantity {
        file: "which-rooms-build.svg",
        title: "rooms of the palace: build, ms",
        aim: "look",
        key: "build_ms",
        unit: 1.0,
        least: 0.1,
        is_shared: true,
    },
    RoomQuantity {
        file: "which-rooms-memory.svg",
        title: "rooms of the palace: memory of method and screen, MB",
        aim: "look",
        key: "bytes",
        unit: 1e6,
        least: 0.0,
        is_shared: false,
    },
];

const QUANTITIES: [Quantity; 4] = [
    Quantity {
        file: "which-look.svg",
        title: "look, ms",
        value: |report| report["summary"]["ms_median"].as_f64(),
        written: significant,
        is_shared: false,
    },
    Quantity {
        file: "which-draw.svg",
        title: "look and draw, ms",
        value: |report| {
            median(
                report["views"]
                    .as_array()?
                    .iter()
                    .filter_map(|view| view["draw_ms"].as_f64()),
            )
        },
        written: significant,
        is_shared: false,
    },
    Quantity {
        file: "which-build.svg",
        title: "build, ms",
        // Smaller values are noise.
        value: |report| Some(report["build_ms"].as_f64()?.max(0.1)),
        written: significant,
        is_shared: true,
    },
    Quantity {
        file: "which-memory.svg",
        title: "memory of scene, method and screen, MB",
        value: |report| Some(report["bytes"].as_f64()? / 1e6),
        written: significant,
        is_shared: false,
    },
];

/// Runs `charts`.
pub(crate) fn run(args: &Args) -> Result<()> {
    let kept = Path::new("target/charts");
    fs::create_dir_all(kept)?;
    let built = cargo()
        .args(["build", "--release", "--package", "enfilade-cli"])
        .status()?;
    ensure!(built.success(), "the program does not build");
    let mut reports = Vec::new();
    for scene in scenes(&args.scenes)? {
        let views = if triangles(&scene, kept)? > MANY_TRIANGLES {
            FEW_VIEWS
        } else {
            args.views
        };
        let views = views.to_string();
        let options = ["bench", &scene, "--survey", &views, "--threads", "1"];
        reports.push((short(&scene), measured(kept, &scene, &options)?));
    }
    for quantity in &QUANTITIES {
        let mut rows: Vec<Row> = reports
            .iter()
            .map(|(name, report)| of_methods(name, report, quantity.value))
            .collect();
        if quantity.is_shared {
            rows.iter_mut().for_each(Row::share);
        }
        let columns = columns(&reports);
        draw(
            &args.output.join(quantity.file),
            quantity.title,
            &columns,
            &rows,
            quantity.written,
        )?;
    }
    for room in &ROOMS {
        let name = format!("rooms-{}", room.aim);
        let options = [
            "choose",
            "@enfilade",
            "--conservative",
            "--aim",
            room.aim,
            "--threads",
            "1",
        ];
        let report = measured(kept, &name, &options)?;
        let (columns, mut rows) = rooms(&report, room)?;
        if room.is_shared {
            rows.iter_mut().for_each(Row::share);
        }
        draw(
            &args.output.join(room.file),
            room.title,
            &columns,
            &rows,
            significant,
        )?;
    }
    Ok(())
}

/// Returns every scene of the folder, and the palace.
fn scenes(folder: &Path) -> Result<Vec<String>> {
    let mut scenes = Vec::new();
    for entry in fs::read_dir(folder).with_context(|| folder.display().to_string())? {
        let path = entry?.path();
        let name = path.file_name().unwrap_or_default().to_string_lossy();
        if name.ends_with(".glb") || name == "terrain_jacksboro.json" {
            scenes.push(path.display().to_string());
        }
    }
    ensure!(
        !scenes.is_empty(),
        "{}: there is no scene in it",
        folder.display()
    );
    scenes.sort();
    scenes.push("@enfilade".to_owned());
    Ok(scenes)
}

fn short(scene: &str) -> String {
    let path = Path::new(scene);
    let stem = path
        .file_stem()
        .unwrap_or_default()
        .to_string_lossy()
        .into_owned();
    if scene.ends_with(".json") {
        stem + " (heights)"
    } else {
        stem
    }
}

fn triangles(scene: &str, kept: &Path) -> Result<u64> {
    let info = measured(kept, &format!("info-{}", short(scene)), &["info", scene])?;
    Ok(info["triangles_drawn"].as_u64().unwrap_or(0))
}

/// Returns the cached report of a run of the program, or runs it.
fn measured(kept: &Path, name: &str, options: &[&str]) -> Result<Value> {
    let file = kept.join(short(name).replace([' ', '(', ')', '@'], "") + ".json");
    if !file.exists() {
        let beside = file.with_extension("new");
        let status = Command::new("target/release/enfilade")
            .args(options)
            .args(["--json", &beside.display().to_string()])
            .status()?;
        ensure!(status.success(), "enfilade {} fails", options.join(" "));
        fs::rename(&beside, &file)?;
    }
    let text = fs::read_to_string(&file)?;
    serde_json::from_str(&text).with_context(|| file.display().to_string())
}

fn methods(report: &Value) -> impl Iterator<Item = &Value> {
    report["methods"].as_array().into_iter().flatten()
}

/// Returns the methods that fit any of the scenes, in the order of [`Method::ALL`].
fn columns(reports: &[(String, Value)]) -> Vec<&'static str> {
    let is_there = |name: &&str| {
        reports
            .iter()
            .any(|(_, report)| methods(report).any(|one| one["method"] == *name))
    };
    Method::ALL
        .map(Method::name)
        .into_iter()
        .filter(is_there)
        .collect()
}

fn of_methods(name: &str, report: &Value, value: fn(&Value) -> Option<f64>) -> Row {
    let of = |method: &str| {
        methods(report)
            .find(|one| one["method"] == method)
            .and_then(value)
    };
    let all = Method::ALL.map(Method::name);
    Row {
        name: name.to_owned(),
        values: all.iter().map(|method| of(method)).collect(),
    }
}

/// Returns a quantity per room, for the methods that were tried in any room.
fn rooms(report: &Value, quantity: &RoomQuantity) -> Result<(Vec<&'static str>, Vec<Row>)> {
    let all = Method::ALL.map(Method::name);
    let choices = report["choices"].as_array().context("there are no choices")?;
    let rows: Vec<Row> = choices
        .iter()
        .map(|choice| {
            let trials = choice["trials"].as_array().map_or(&[][..], Vec::as_slice);
            let of = |method: &str| {
                let value = trials.iter().find(|one| one["method"] == method)?[quantity.key].as_f64()?;
                Some((value / quantity.unit).max(quantity.least))
            };
            Row {
                name: choice["sector"].as_str().unwrap_or_default().to_owned(),
                values: all.iter().map(|method| of(method)).collect(),
            }
        })
        .collect();
    let tried = |place: usize| rows.iter().any(|row| row.values[place].is_some());
    let columns = all
        .iter()
        .enumerate()
        .filter(|(place, _)| tried(*place))
        .map(|(_, name)| *name);
    Ok((columns.collect(), rows))
}

fn median(values: impl Iterator<Item = f64>) -> Option<f64> {
    let mut values: Vec<f64> = values.collect();
    values.sort_by(f64::total_cmp);
    values.get(values.len() / 2).copied()
}
