//! Charts of what every method costs on every scene, and in every room of the palace: those of the book's chapter on which
//! method suits when.
//!
//! The program measures (`bench` and `choose`, one thread), each scene once: its reports are kept in `target/charts` and not made
//! again while they are there.

use anyhow::{Context, Result, ensure};
use plotters::prelude::*;
use plotters::style::text_anchor::{HPos, Pos, VPos};
use serde_json::Value;
use std::fs;
use std::path::{Path, PathBuf};
use std::process::Command;

/// What is to be measured, and where charts go.
#[derive(clap::Args)]
pub(crate) struct Args {
    /// The folder of real scenes
    #[arg(long, value_name = "FOLDER", env = "ENFILADE_SCENES")]
    scenes: PathBuf,
    /// Where charts go
    #[arg(long, value_name = "FOLDER", default_value = "book/src/pictures")]
    output: PathBuf,
    /// Views of each scene
    #[arg(long, value_name = "N", default_value_t = 8)]
    views: u32,
}

/// Of more triangles fewer views are taken, for some methods take seconds for each.
const MANY_TRIANGLES: u64 = 500_000;
const FEW_VIEWS: u32 = 2;

/// One row of a chart: a scene or a room, and a value for each method.
struct Row {
    name: String,
    values: Vec<Option<f64>>,
}

/// A quantity, where it stands in the report of a method, and how it is written.
struct Quantity {
    file: &'static str,
    title: &'static str,
    value: fn(&Value) -> Option<f64>,
    written: fn(f64) -> String,
}

const QUANTITIES: [Quantity; 4] = [
    Quantity {
        file: "which-look.svg",
        title: "look, ms",
        value: |report| report["summary"]["ms_median"].as_f64(),
        written: significant,
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
    },
    Quantity {
        file: "which-build.svg",
        title: "build, ms",
        // What takes less is not told apart.
        value: |report| Some(report["build_ms"].as_f64()?.max(0.1)),
        written: significant,
    },
    Quantity {
        file: "which-memory.svg",
        title: "memory of scene, method and screen, MB",
        value: |report| Some(report["bytes"].as_f64()? / 1e6),
        written: significant,
    },
];

/// Runs `charts`.
pub(crate) fn run(args: &Args) -> Result<()> {
    let kept = Path::new("target/charts");
    fs::create_dir_all(kept)?;
    let built = Command::new(env!("CARGO"))
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
        let rows: Vec<Row> = reports
            .iter()
            .map(|(name, report)| of_methods(name, report, quantity.value))
            .collect();
        let columns = columns(&reports);
        draw(
            &args.output.join(quantity.file),
            quantity.title,
            &columns,
            &rows,
            quantity.written,
        )?;
    }
    for aim in ["look", "draw"] {
        let options = [
            "choose",
            "@enfilade",
            "--conservative",
            "--aim",
            aim,
            "--threads",
            "1",
        ];
        let report = measured(kept, &format!("rooms-{aim}"), &options)?;
        let (columns, rows) = rooms(&report)?;
        let file = args.output.join(format!("which-rooms-{aim}.svg"));
        draw(
            &file,
            &format!("rooms of the palace: {aim}, ms"),
            &columns,
            &rows,
            significant,
        )?;
    }
    Ok(())
}

/// Every scene of the folder, and the palace.
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

/// The report of a run of the program, made now unless it was kept.
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

/// The methods that suit any of the scenes, in their own order.
fn columns(reports: &[(String, Value)]) -> Vec<&'static str> {
    let is_there = |name: &&str| {
        reports
            .iter()
            .any(|(_, report)| methods(report).any(|one| one["method"] == *name))
    };
    enfilade::Method::ALL
        .map(enfilade::Method::name)
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
    let all = enfilade::Method::ALL.map(enfilade::Method::name);
    Row {
        name: name.to_owned(),
        values: all.iter().map(|method| of(method)).collect(),
    }
}

/// What a frame takes in each room, by methods that were tried in any.
fn rooms(report: &Value) -> Result<(Vec<&'static str>, Vec<Row>)> {
    let all = enfilade::Method::ALL.map(enfilade::Method::name);
    let choices = report["choices"].as_array().context("there are no choices")?;
    let rows: Vec<Row> = choices
        .iter()
        .map(|choice| {
            let trials = choice["trials"].as_array().map_or(&[][..], Vec::as_slice);
            let of = |method: &str| trials.iter().find(|one| one["method"] == method)?["frame_ms"].as_f64();
            Row {
                name: choice["fragment"].as_str().unwrap_or_default().to_owned(),
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

/// Two or three digits that count.
fn significant(value: f64) -> String {
    match value {
        value if value >= 99.5 => format!("{value:.0}"),
        value if value >= 9.95 => format!("{value:.1}"),
        value if value >= 0.095 => format!("{value:.2}"),
        value => format!("{value:.3}"),
    }
}

const NAMES: i32 = 176;
const CELL: [i32; 2] = [78, 24];
const HEAD: i32 = 66;
const INK: RGBColor = RGBColor(38, 43, 51);
const FAINT: RGBColor = RGBColor(118, 125, 137);

/// A table whose cells are colored by how many times the best of their row they are.
fn draw(file: &Path, title: &str, columns: &[&str], rows: &[Row], written: fn(f64) -> String) -> Result<()> {
    let size = [
        NAMES + CELL[0] * columns.len() as i32 + 8,
        HEAD + CELL[1] * rows.len() as i32 + 8,
    ];
    let root = SVGBackend::new(file, (size[0] as u32, size[1] as u32)).into_drawing_area();
    root.fill(&WHITE)?;
    let text = |size: i32, color: &RGBColor, across: HPos| {
        ("sans-serif", size)
            .into_font()
            .color(color)
            .pos(Pos::new(across, VPos::Center))
    };
    root.draw(&Text::new(title.to_owned(), (8, 16), text(15, &INK, HPos::Left)))?;
    let all = enfilade::Method::ALL.map(enfilade::Method::name);
    for (number, column) in columns.iter().enumerate() {
        let middle = NAMES + CELL[0] * number as i32 + CELL[0] / 2;
        let words: Vec<&str> = column.split('-').collect();
        for (line, word) in words.iter().enumerate() {
            let from_below = (words.len() - line) as i32;
            let at = (middle, HEAD - 2 - 15 * from_below + 4);
            root.draw(&Text::new((*word).to_owned(), at, text(13, &INK, HPos::Center)))?;
        }
    }
    for (number, row) in rows.iter().enumerate() {
        let top = HEAD + CELL[1] * number as i32;
        let middle = top + CELL[1] / 2;
        let name = Text::new(
            row.name.clone(),
            (NAMES - 10, middle),
            text(13, &INK, HPos::Right),
        );
        root.draw(&name)?;
        let best = row.values.iter().flatten().copied().fold(f64::INFINITY, f64::min);
        for (place, column) in columns.iter().enumerate() {
            let left = NAMES + CELL[0] * place as i32;
            let value = all
                .iter()
                .position(|name| name == column)
                .and_then(|at| row.values[at]);
            let corners = [(left + 1, top + 1), (left + CELL[0] - 1, top + CELL[1] - 1)];
            let (shown, ink) = match value {
                Some(value) => {
                    root.draw(&Rectangle::new(corners, shade(value / best).filled()))?;
                    (written(value), &INK)
                }
                None => ("–".to_owned(), &FAINT),
            };
            let at = (left + CELL[0] / 2, middle);
            root.draw(&Text::new(shown, at, text(13, ink, HPos::Center)))?;
        }
    }
    root.present()?;
    Ok(())
}

/// From the best, green, over three times as much, to ten times and more, red.
fn shade(times: f64) -> RGBColor {
    const STOPS: [[f64; 3]; 3] = [
        [188.0, 225.0, 190.0],
        [252.0, 242.0, 196.0],
        [240.0, 170.0, 150.0],
    ];
    let place = (times.max(1.0).log10() * 2.0).clamp(0.0, 2.0);
    let from = (place as usize).min(1);
    let share = place - from as f64;
    let [r, g, b] = [0, 1, 2].map(|i| (STOPS[from][i] + share * (STOPS[from + 1][i] - STOPS[from][i])) as u8);
    RGBColor(r, g, b)
}
