//! Measures how many faces and boxes per second the masked depth buffer processes.
//!
//! All rows run in turn, round after round, so that other load on the cores slows all alike; the median and the fastest
//! round of each are reported. The results of the timed work are then compared with a reference in f64, in the same run.
#![allow(clippy::print_stdout, reason = "a program prints what it measures")]
#![forbid(unsafe_code)]

mod boxes;
mod faces;
mod items;
mod lens;
mod look;
mod report;
mod rows;
mod screen;
mod shapes;
mod truth;
mod walk;

use anyhow::{Context, Result, ensure};
use clap::Parser;
use clap::builder::PossibleValuesParser;
use enfilade::Method;
use enfilade_import::{ReadOptions, read};
use report::MicroReport;
use screen::Screen;
use std::path::PathBuf;
use std::rc::Rc;
use truth::ErrorCounts;

/// Measures the masked depth buffer alone, on one thread.
///
/// Exits with 1 if a sample or a box is wrong: something visible might be culled.
#[derive(Parser)]
#[command(after_help = "\
Columns:
  M/s, best M/s    millions of faces or boxes per second: the median round, and the fastest
  best ns          nanoseconds per face or box in the fastest round
  ms per view      rows of SCENE: mean of 16 positions, in the median round; best ms: in the fastest
  samples          samples covered at the end of a run, of all views
  wrong            samples or boxes that would cull something visible: must be 0
  loose            samples or boxes kept though hidden: costs time, never correctness

It runs at 1920x1080; rows take turns in each round. The chapter Benchmarks of the book defines rows.")]
struct Args {
    /// A .glb, .gltf or .obj file; without one, rows of scenes are left out
    #[arg(value_name = "SCENE")]
    scene: Option<PathBuf>,
    /// Time N rounds
    #[arg(long, value_name = "N", default_value_t = 15, value_parser = clap::value_parser!(u32).range(1..=10_000))]
    rounds: u32,
    /// Only these rows
    #[arg(long, value_name = "NAME,..", value_delimiter = ',', value_parser = PossibleValuesParser::new(names()))]
    rows: Vec<String>,
    /// SIMD level [default: the best of this machine]
    #[arg(long, value_name = "LEVEL", value_parser = PossibleValuesParser::new(enfilade::simd_levels()))]
    simd: Option<String>,
    /// Write the report as JSON
    #[arg(long, value_name = "FILE")]
    json: Option<PathBuf>,
}

/// Screen size of all rows except those of scenes.
const SIZE: [u32; 2] = [1920, 1080];

/// Returns the names of all rows, those of scenes last.
fn names() -> impl Iterator<Item = &'static str> {
    rows::names().chain(walk::NAMES).chain([look::NAME])
}

/// Work that is timed and then compared with the truth.
trait Workload {
    /// Returns the number of faces or boxes per run.
    fn count(&self) -> u64;

    /// Runs the work, and returns the seconds it took.
    fn run(&mut self, screen: &mut Screen) -> f64;

    /// Runs the work once more, and counts its errors.
    fn check(&mut self, screen: &mut Screen) -> ErrorCounts;
}

/// A row of the table.
struct Row {
    name: &'static str,
    work: Box<dyn Workload>,
    /// Time of each round.
    seconds: Vec<f64>,
    /// Number of views per run, if the row is reported in milliseconds per view.
    views: Option<u64>,
}

impl Row {
    fn new(name: &'static str, work: Box<dyn Workload>) -> Row {
        Row {
            name,
            work,
            seconds: Vec::new(),
            views: None,
        }
    }

    /// Returns the median time of all rounds.
    fn median_seconds(&self) -> f64 {
        median(&self.seconds)
    }

    /// Returns the time of the fastest round.
    fn best_seconds(&self) -> f64 {
        self.seconds.iter().copied().fold(f64::INFINITY, f64::min)
    }
}

/// Returns the median; of none 0.
fn median(values: &[f64]) -> f64 {
    let mut sorted = values.to_vec();
    sorted.sort_by(f64::total_cmp);
    match sorted.len() {
        0 => 0.0,
        count if count % 2 == 1 => sorted[count / 2],
        count => 0.5 * (sorted[count / 2 - 1] + sorted[count / 2]),
    }
}

fn main() -> Result<()> {
    let args = Args::parse();
    if let Some(level) = &args.simd {
        enfilade::use_simd_level(level)?;
    }
    let mut screen = Screen::new(SIZE);
    let wanted = |name: &str| args.rows.is_empty() || args.rows.iter().any(|row| row == name);
    let mut rows = rows::rows(&screen, wanted);
    if let Some(scene) = &args.scene {
        // Portals are ignored, so the whole scene is in one space.
        let options = ReadOptions {
            flat: true,
            ..ReadOptions::default()
        };
        let scene = read(scene, &options)?.scene(Method::Masked, Method::DEFAULT_LIMIT)?;
        let scene = Rc::new(scene);
        rows.extend(walk::rows(&scene, wanted)?);
        if wanted(look::NAME) {
            rows.push(look::row(&scene)?);
        }
    }
    // The first round warms up.
    for round in 0..=args.rounds {
        for row in &mut rows {
            let seconds = row.work.run(&mut screen);
            if round > 0 {
                row.seconds.push(seconds);
            }
        }
    }
    let found: Vec<ErrorCounts> = rows.iter_mut().map(|row| row.work.check(&mut screen)).collect();
    let report = MicroReport::new(&rows, &found, args.rounds, wanted);
    print!("{}", report.for_people());
    if let Some(path) = &args.json {
        let text = serde_json::to_string_pretty(&report)? + "\n";
        std::fs::write(path, text).with_context(|| path.display().to_string())?;
    }
    let wrong = report.rows.iter().filter(|row| row.wrong > 0);
    let wrong: Vec<&str> = wrong.map(|row| row.name).collect();
    ensure!(
        wrong.is_empty(),
        "wrong rows, visible items may be culled: {}",
        wrong.join(", ")
    );
    Ok(())
}
