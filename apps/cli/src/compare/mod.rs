//! `compare`: compares all methods on one scene, on an HTML page.

mod charts;
mod contested;
mod difference;
mod embed;
mod page;
mod pictures;
mod summary;
mod views;

use crate::Outcome;
use crate::args::CompareArgs;
use crate::cameras;
use crate::check::{CheckResult, check_view, reference};
use crate::json::{SceneReport, Sink};
use crate::look::{print_failures, warn_of_contested};
use crate::open::{Purpose, configure, open};
use crate::out;
use crate::prepare::{PreparedScene, SkippedMethod, left_out, prepare};
use crate::progress::Progress;
use crate::report::{Report, Reports, measured};
use crate::run_files::RunFiles;
use crate::save::Destination;
use crate::text::plural;
use anyhow::{Result, bail};
use enfilade::{ChoiceGoal, Scene, View, Viewer};
use pictures::{ViewPictures, ViewRenderer};
use std::path::Path;

/// The content of the page.
struct Comparison<'a> {
    args: &'a CompareArgs,
    scene: SceneReport,
    /// Number of faces of the scene, before any is split.
    faces: u64,
    views: usize,
    /// The checked reports, one per method.
    reports: &'a [Report],
    skipped: &'a [SkippedMethod],
    /// Pictures of the first views.
    pictures: Vec<ViewPictures>,
}

/// Runs `compare`.
pub(crate) fn run(args: &CompareArgs) -> Result<Outcome> {
    let mut files = RunFiles::of(&args.scene.scene, args.cameras.path.as_deref())?;
    let page = destination(&args.output, &mut files)?;
    let sink = Sink::new(&args.json, &mut files)?;
    configure(&args.how)?;
    let mut opened = open(
        &args.scene.scene,
        Purpose::Pictures,
        args.method,
        &args.how.portals,
        &args.how.limits,
        &mut files,
    )?;
    opened.upright.set(&args.cameras.upright);
    let views = cameras::views(&args.cameras, &opened)?;
    let (prepared, skipped) = prepare(&opened, args.method, ChoiceGoal::Draw, &args.how, views.first())?;
    let mut viewers: Vec<Viewer> = prepared.iter().map(PreparedScene::viewer).collect();
    let mut reports = measured(&opened, &prepared, &mut viewers, &views, args.cameras.size);
    let (found, pictures) = check_and_draw(&prepared, &mut viewers, &views, args.pictures)?;
    for ((report, found), prepared) in reports.iter_mut().zip(&found).zip(&prepared) {
        report.add_checks(found, &prepared.scene);
    }
    let comparison = Comparison {
        args,
        scene: SceneReport::new(&opened),
        faces: faces(&opened.scene),
        views: views.len(),
        reports: &reports,
        skipped: &skipped,
        pictures,
    };
    let text = page::page(&comparison)?;
    page.write(text.as_bytes())?;
    if !args.json.takes_stdout() {
        out::print(&(for_people(&comparison) + &left_out(&skipped)))?;
    }
    warn_of_contested(&reports);
    // Errors of approximate methods are on the page only.
    let broken = reports.iter().filter(|report| report.breaks_its_contract());
    broken.for_each(print_failures);
    let outcome = Outcome::of(&reports);
    sink.write(&Reports::All {
        methods: reports,
        skipped,
    })?;
    Ok(outcome)
}

fn faces(scene: &Scene) -> u64 {
    let faces = |id| match scene.geometry(id) {
        Some(geometry) => geometry.face_count(),
        None => scene.triangles_of(id),
    };
    scene.sectors().map(faces).sum()
}

fn destination(path: &Path, files: &mut RunFiles) -> Result<Destination> {
    if !path
        .extension()
        .is_some_and(|ending| ending.eq_ignore_ascii_case("html"))
    {
        bail!(
            "cannot write {}: the report is a page, so the name must end in .html",
            path.display()
        );
    }
    files.writes(path)
}

/// Checks every method at every view, and draws the pictures of the first views.
///
/// `viewers` are those of the timed passes, so that their temporal coherence is tested too.
fn check_and_draw(
    prepared: &[PreparedScene],
    viewers: &mut [Viewer],
    views: &[View],
    pictures: usize,
) -> Result<(Vec<Vec<CheckResult>>, Vec<ViewPictures>)> {
    let mut found: Vec<Vec<CheckResult>> = prepared.iter().map(|_| Vec::new()).collect();
    let mut drawn = Vec::new();
    let Some(first) = prepared.first().filter(|_| !views.is_empty()) else {
        return Ok((found, drawn));
    };
    let reference = reference(&first.scene)?;
    let mut renderer = ViewRenderer::new(prepared, views)?;
    let progress = Progress::steps("checking and drawing", views.len() * prepared.len());
    for (number, view) in views.iter().enumerate() {
        let truth = reference.see(&first.scene, view, &viewers[0].options.limits);
        let mut rendering = match number < pictures {
            true => Some(renderer.begin(view, &truth)?),
            false => None,
        };
        for (method, (prepared, viewer)) in prepared.iter().zip(&mut *viewers).enumerate() {
            let (verdict, owners) = check_view(&truth, prepared, viewer, view);
            found[method].push(verdict);
            if let Some(rendering) = &mut rendering {
                rendering.draw(method, viewer, &owners)?;
            }
            progress.step();
        }
        drawn.extend(rendering.map(|rendering| rendering.into_pictures()));
    }
    Ok((found, drawn))
}

/// Returns the text output: the summary, and the path of the page.
fn for_people(comparison: &Comparison) -> String {
    let methods = plural(comparison.reports.len(), "method");
    format!(
        "{}\n{}: {methods}, {}\n",
        summary::as_text(comparison),
        comparison.args.output.display(),
        plural(comparison.views, "view"),
    )
}
