//! Compares Enfilade's software renderer with `wgpu` on a software Vulkan driver: the same triangles, in one run.
//!
//! See the README beside the manifest for what is compared, and how.

mod clock;
mod differ;
mod gpu;
mod lens;
mod measure;
mod ours;
mod peer;
mod pipelines;
mod place;
mod plan;
mod report;
mod serve;
mod stock;
mod weld;

use crate::ours::EnfiladeRenderer;
use anyhow::{Context, Result, ensure};
use clap::Parser;
use clock::Clock;
use enfilade::{Contract, Method, Scene};
use peer::Peer;
use place::SurveyedScene;
use report::Report;
use std::ffi::OsString;
use std::path::{Path, PathBuf};
use std::process::ExitCode;

/// Draws scenes with Enfilade's renderer and with wgpu on a software Vulkan driver (lavapipe), in turn, and prints the
/// times
#[derive(Parser)]
struct Args {
    /// Scenes: .glb or .gltf
    #[arg(required = true, value_name = "SCENE")]
    scenes: Vec<PathBuf>,
    /// Views of each scene's survey
    #[arg(long, default_value_t = 16, value_parser = clap::value_parser!(u16).range(1..))]
    views: u16,
    /// Rounds over all views, after one to warm up
    #[arg(long, default_value_t = 5, value_parser = clap::value_parser!(u16).range(1..))]
    rounds: u16,
    /// Columns and rows
    #[arg(long, default_value = "1280x720", value_name = "WxH", value_parser = size)]
    size: [u32; 2],
    /// Methods to render with; times are compared with the fastest one on each scene
    #[arg(long, value_delimiter = ',', value_name = "METHODS", value_parser = method,
        default_value = "hierarchical-z,s-buffer,hierarchical-s,masked,z-buffer")]
    methods: Vec<Method>,
    /// Method that computes visibility before lavapipe draws only the visible items
    #[arg(long, default_value = "masked", value_name = "METHOD", value_parser = method)]
    seen_by: Method,
    /// Folder for the pictures of both renderers
    #[arg(long, value_name = "FOLDER")]
    pictures: Option<PathBuf>,
    /// Run as the drawing process: execute commands from standard input
    #[arg(long, hide = true)]
    serve: bool,
}

/// Part of pixels that may differ noticeably over all views of a scene: edges that cover other samples, because GPUs
/// snap corners to 1/256 pixel, and coplanar faces, which have no defined order.
const MAY_DIFFER: f64 = 0.01;

fn main() -> ExitCode {
    match run(&Args::parse()) {
        Ok(()) => ExitCode::SUCCESS,
        Err(error) => {
            eprintln!("error: {error:#}");
            ExitCode::FAILURE
        }
    }
}

fn run(args: &Args) -> Result<()> {
    if args.serve {
        let place = SurveyedScene::open(&args.scenes[0], args.views.into(), args.size)?;
        return serve::serve(
            place,
            args.seen_by,
            std::io::stdin().lock(),
            std::io::stdout().lock(),
        );
    }
    if let Some(folder) = &args.pictures {
        std::fs::create_dir_all(folder).with_context(|| folder.display().to_string())?;
    }
    let all = std::thread::available_parallelism()?.get();
    let cores: Vec<usize> = if all > 1 { vec![1, all] } else { vec![1] };
    let mut reports = Vec::new();
    for file in &args.scenes {
        let report = bench(args, file, &cores)?;
        report.print(args.seen_by);
        reports.push(report);
    }
    for clock in Clock::ALL {
        report::print_summary(&reports, &cores, clock);
    }
    reports.iter().try_for_each(agree)
}

/// Verifies that the pictures of both renderers agree.
///
/// # Errors
/// If they differ, because then the times are not comparable.
fn agree(report: &Report) -> Result<()> {
    let most = report
        .drawn
        .iter()
        .map(|drawn| drawn.differing[0])
        .fold(0.0, f64::max);
    ensure!(
        most <= MAY_DIFFER,
        "{}: {:.2} % of the pixels differ, so the times are not comparable",
        report.name,
        100.0 * most
    );
    Ok(())
}

/// Runs the benchmark on one scene.
fn bench(args: &Args, file: &Path, cores: &[usize]) -> Result<Report> {
    let name = file
        .file_stem()
        .context("the path does not name a file")?
        .to_string_lossy()
        .into_owned();
    let place = SurveyedScene::open(file, args.views.into(), args.size)?;
    let scenes: Vec<(Method, Scene)> = args
        .methods
        .iter()
        .map(|&method| Ok((method, place.seen_by(method)?)))
        .collect::<Result<_>>()?;
    let most = cores.iter().copied().max().unwrap_or(1);
    let mut peers: Vec<Peer> = cores
        .iter()
        .map(|&cores| Peer::start(&server_arguments(args, file), cores, most))
        .collect::<Result<_>>()?;
    println!("{name}: {} views by {}", place.views.len(), peers[0].driver);
    let start = args.pictures.as_ref().map(|folder| folder.join(&name));
    let ours: Vec<EnfiladeRenderer> = cores
        .iter()
        .map(|&cores| EnfiladeRenderer::new(&scenes[0].1, cores))
        .collect::<Result<_>>()?;
    let drawn = measure::compare(&place, (&ours[0], &scenes[0].1), &mut peers[0], start.as_deref())?;
    let taken = measure::time(&place, &ours, &scenes, &mut peers, args.rounds.into())?;
    Ok(Report {
        name,
        items: place.geometry()?.item_count(),
        triangles: place.geometry()?.triangle_count(),
        drawn,
        taken,
    })
}

/// Returns the arguments of a drawing process.
fn server_arguments(args: &Args, file: &Path) -> Vec<OsString> {
    let [width, height] = args.size;
    let options = [
        "--serve".to_owned(),
        format!("--views={}", args.views),
        format!("--size={width}x{height}"),
        format!("--seen-by={}", args.seen_by),
        "--".to_owned(),
    ];
    options
        .into_iter()
        .map(OsString::from)
        .chain([file.as_os_str().to_owned()])
        .collect()
}

fn size(text: &str) -> Result<[u32; 2], String> {
    let sides = text
        .split_once('x')
        .and_then(|(width, height)| Some([width.parse().ok()?, height.parse().ok()?]));
    sides
        .filter(|sides| sides.iter().all(|side| (1..=8192).contains(side)))
        .ok_or_else(|| "WxH, each from 1 to 8192".to_owned())
}

/// Parses a method that never misses visible items; a method that leaves some out would appear faster.
fn method(name: &str) -> Result<Method, String> {
    let known = Method::by_name(name).filter(|method| method.contract() != Contract::Approximate);
    known.ok_or_else(|| {
        let names = Method::ALL
            .iter()
            .filter(|method| method.contract() != Contract::Approximate);
        let names: Vec<&str> = names.map(|method| method.name()).collect();
        format!("one of {}", names.join(", "))
    })
}
