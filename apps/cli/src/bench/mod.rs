//! `bench`: times every method over a list of views, and compares each visible set with the expected one.

mod expected;

use crate::Outcome;
use crate::args::BenchArgs;
use crate::cameras;
use crate::json::{SceneReport, Sink};
use crate::open::{Purpose, configure, open};
use crate::out;
use crate::prepare::{PreparedScene, left_out, prepare};
use crate::report::{Report, Reports, measured};
use crate::run_files::RunFiles;
use crate::text::{bytes, count, ms, plural, point, short, table};
use crate::values::Choice;
use anyhow::Result;
use enfilade::{ChoiceGoal, Contract, Viewer};
use std::ffi::OsStr;

/// Number of survey views if no camera option is given.
const VIEWS: u32 = 16;

/// Runs `bench`.
pub(crate) fn run(mut args: BenchArgs) -> Result<Outcome> {
    let scene = args.scene.as_deref().unwrap_or(OsStr::new("@enfilade"));
    let mut files = RunFiles::of(scene, args.cameras.path.as_deref())?;
    let sink = Sink::new(&args.json, &mut files)?;
    configure(&args.how)?;
    let mut opened = open(
        scene,
        Purpose::Pictures,
        args.method,
        &args.how.portals,
        &args.how.limits,
        &mut files,
    )?;
    opened.upright.set(&args.cameras.upright);
    args.cameras.survey_by_default(VIEWS);
    let views = cameras::views(&args.cameras, &opened)?;
    let (prepared, skipped) = prepare(&opened, args.method, ChoiceGoal::Look, &args.how, views.first())?;
    let mut viewers: Vec<Viewer> = prepared.iter().map(PreparedScene::viewer).collect();
    let mut reports = measured(&opened, &prepared, &mut viewers, &views, args.cameras.size);
    expected::check_sets(&mut reports, &prepared, &mut viewers, &views)?;
    let scene = SceneReport::new(&opened);
    let left_out = left_out(&skipped);
    let reports = Reports::new(args.method == Choice::All, reports, skipped);
    if !args.json.takes_stdout() {
        out::print(&(for_people(&scene, reports.each()) + &left_out))?;
    }
    sink.write(&reports)?;
    reports.each().iter().for_each(print_failures);
    Ok(if reports.each().iter().any(Report::is_not_as_expected) {
        Outcome::CheckFailed
    } else {
        Outcome::Done
    })
}

fn for_people(scene: &SceneReport, reports: &[Report]) -> String {
    let SceneReport {
        file,
        items,
        triangles,
        ..
    } = scene;
    let mut text = format!(
        "{file}: {}, {} triangles",
        plural(*items, "item"),
        count(*triangles)
    );
    if let Some(first) = reports.first() {
        let [width, height] = first.size;
        let views = plural(first.summary.views, "view");
        let threads = plural(first.threads, "thread");
        text += &format!("; {views} at {width}x{height}, {threads}, {}", first.simd);
    }
    let header = [
        "method", "contract", "build ms", "look ms", "99 %", "order ms", "draw ms", "memory", "items",
        "expected", "verdict",
    ];
    text += "\n\n";
    text + &table(&header, &reports.iter().map(row).collect::<Vec<_>>())
}

fn row(report: &Report) -> Vec<String> {
    let summary = &report.summary;
    let time = |time: Option<f64>| time.map_or_else(|| "–".to_owned(), ms);
    let expected = report.views.iter().filter_map(|view| view.expected.as_ref());
    let expected: usize = expected.map(|expected| expected.items_visible).sum();
    vec![
        report.method.to_owned(),
        report.contract.to_string(),
        ms(report.build_ms),
        ms(summary.ms_median),
        ms(summary.ms_p99),
        time(report.median_ms(|view| view.order_ms)),
        time(report.median_ms(|view| view.draw_ms)),
        bytes(report.bytes),
        short(summary.items_visible_mean),
        short(expected as f64 / summary.views.max(1) as f64),
        verdict(report).to_owned(),
    ]
}

fn verdict(report: &Report) -> &'static str {
    match (report.is_not_as_expected(), report.contract) {
        (true, _) => "wrong",
        (false, Contract::Exact) => "as expected",
        (false, Contract::Approximate) => "not checked",
        (false, _) => "misses nothing",
    }
}

/// Prints the views at which a set violates its contract.
fn print_failures(report: &Report) {
    for (number, view) in report.views.iter().enumerate() {
        let Some(expected) = &view.expected else { continue };
        let print = |failure: String| {
            let eye = point(view.eye);
            out::note(format_args!(
                "bench: {}, view {} (eye {eye}): {failure}",
                report.method,
                number + 1
            ));
        };
        if !expected.missed.is_empty() {
            print(format!("missed {}", expected.missed.join(", ")));
        }
        if expected.extra > 0 {
            print(format!("{} in the set", plural(expected.extra, "hidden item")));
        }
        if !expected.same_again {
            print("a second pass returned another set".to_owned());
        }
    }
}
