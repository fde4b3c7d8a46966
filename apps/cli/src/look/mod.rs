//! `look`: computes the visible set of each view, times it, and optionally checks it.

mod shards;

use crate::Outcome;
use crate::args::LookArgs;
use crate::cameras;
use crate::check::check;
use crate::choose;
use crate::json::{SceneReport, Sink};
use crate::measure::{self, PASSES};
use crate::non_occluders;
use crate::open::{OpenedScene, Purpose, configure, open};
use crate::out;
use crate::prepare::{PreparedScene, SkippedMethod, left_out, prepare};
use crate::progress::Progress;
use crate::report::{PassageReport, Report, Reports, Summary};
use crate::run_files::RunFiles;
use crate::text::{bytes, count, ms, percent, plural, point, short, table};
use crate::values::Choice;
use anyhow::Result;
use enfilade::{ChoiceGoal, Contract, View, Viewer};
use std::cmp::Reverse;
use std::collections::BTreeMap;
use std::fmt::Write;
use std::sync::Arc;

/// Runs `look`.
pub(crate) fn run(args: &LookArgs) -> Result<Outcome> {
    if args.shards.merge {
        return shards::merge(args);
    }
    if let Some(shard) = args.shards.shard {
        return shards::run(args, shard);
    }
    let mut files = RunFiles::of(&args.scene.scene, args.cameras.path.as_deref())?;
    let sink = Sink::new(&args.json, &mut files)?;
    let choice = args.methods.choice();
    let Opened {
        scene: opened,
        views,
        prepared,
        skipped,
    } = Opened::new(args, choice, &mut files)?;
    let mut viewers: Vec<Viewer> = prepared.iter().map(|prepared| prepared.viewer()).collect();
    let mut reports = Vec::new();
    let progress = Progress::steps("looking", prepared.len() * views.len() * (1 + PASSES));
    for (prepared, viewer) in prepared.iter().zip(&mut viewers) {
        let looks = measure::looks(prepared, &views, viewer, &progress);
        reports.push(Report::new(&opened, prepared, &views, args.cameras.size, looks));
    }
    drop(progress);
    if let Some(samples) = args.check {
        let found = check(&prepared, &mut viewers, &views, samples)?;
        for ((report, found), prepared) in reports.iter_mut().zip(&found).zip(&prepared) {
            report.add_checks(found, &prepared.scene);
        }
    }
    let listed = args.non_occluders.then(|| non_occluders::list(&opened));
    for report in &mut reports {
        report.scene.non_occluders.clone_from(&listed);
    }
    let left_out = left_out(&skipped);
    let reports = Reports::new(choice == Choice::All, reports, skipped);
    if !args.json.takes_stdout() {
        let listed = listed.map_or(String::new(), |items| non_occluders::for_people(&items));
        let text = for_people(&SceneReport::new(&opened), reports.each());
        out::print(&(text + &left_out + &listed))?;
    }
    sink.write(&reports)?;
    warn_of_contested(reports.each());
    reports.each().iter().for_each(print_failures);
    Ok(Outcome::of(reports.each()))
}

/// What a run looks at.
struct Opened {
    scene: OpenedScene,
    views: Vec<View>,
    prepared: Vec<PreparedScene>,
    skipped: Vec<SkippedMethod>,
}

impl Opened {
    fn new(args: &LookArgs, choice: Choice, files: &mut RunFiles) -> Result<Opened> {
        let how = &args.methods.how;
        configure(how)?;
        let mut scene = open(
            &args.scene.scene,
            Purpose::Visibility,
            choice,
            &how.portals,
            &how.limits,
            files,
        )?;
        scene.upright.set(&args.cameras.upright);
        let views = cameras::views(&args.cameras, &scene)?;
        let (prepared, skipped) = prepare(&scene, choice, ChoiceGoal::Look, how, views.first())?;
        Ok(Opened {
            scene,
            views,
            prepared,
            skipped,
        })
    }
}

/// Minimum share of certain samples; with fewer, a check has tested little, and a warning is printed.
const CERTAIN_ENOUGH: f64 = 0.8;

/// Warns if the reference could not decide the owner of many samples, and names items whose faces coincide.
pub(crate) fn warn_of_contested(reports: &[Report]) {
    // The reference is the same for all methods.
    let Some(report) = reports.first() else { return };
    let Some(certain) = report.summary.certain.filter(|&certain| certain < CERTAIN_ENOUGH) else {
        return;
    };
    let checks = report.views.iter().filter_map(|view| view.check.as_ref());
    let mut groups: BTreeMap<&[String], u64> = BTreeMap::new();
    for contested in checks.flat_map(|check| &check.contested) {
        *groups.entry(&contested.items).or_default() += contested.pixels;
    }
    warn_of_uncertain(certain, groups);
}

/// Warns that only the share `certain` of the samples has one possible owner, and names the items of the others.
fn warn_of_uncertain(certain: f64, groups: BTreeMap<&[String], u64>) {
    const FEW: usize = 3;
    let mut groups: Vec<_> = groups.into_iter().collect();
    groups.sort_by_key(|&(_, pixels)| Reverse(pixels));
    let most: Vec<String> = (groups.iter().take(FEW))
        .map(|(items, pixels)| format!("{} ({})", items.join(" and "), plural(*pixels as usize, "sample")))
        .collect();
    let named = if most.is_empty() {
        String::new()
    } else {
        format!("; faces probably coincide: {}", most.join(", "))
    };
    out::warn(format_args!(
        "check: only {} of the samples have one possible owner, so the check tested little{named}",
        percent(certain)
    ));
}

/// Prints false culls and wrong pixels on standard error. For approximate methods prints only their numbers.
pub(crate) fn print_failures(report: &Report) {
    let Summary {
        missed,
        pixels_different,
        ..
    } = report.summary;
    if report.contract == Contract::Approximate {
        return print_approximate(report.method, missed, pixels_different);
    }
    for (number, view) in (1..).zip(&report.views) {
        if let Some(check) = &view.check {
            let location = location(report.method, number, view.eye);
            print_failure(&location, &check.missed, check.pixels_different);
        }
    }
}

/// Returns the method and the view, for messages of a check. Views are counted from 1.
fn location(method: &str, view: usize, eye: [f32; 3]) -> String {
    format!("{method}, view {view} (eye {})", point(eye))
}

/// Prints the failures of a method whose contract allows them.
fn print_approximate(method: &str, missed: usize, pixels_different: u64) {
    if missed > 0 || pixels_different > 0 {
        out::note(format_args!(
            "check: {method} is approximate: {} missed and {} (--json lists them)",
            plural(missed, "item"),
            plural(pixels_different as usize, "wrong pixel")
        ));
    }
}

/// Prints the failures of a method at a view, if any.
fn print_failure(location: &str, missed: &[String], pixels_different: u64) {
    if !missed.is_empty() {
        out::note(format_args!("check: {location}: missed {}", missed.join(", ")));
    }
    if pixels_different > 0 {
        out::note(format_args!(
            "check: {location}: {} (the surface drawn there is not visible according to the reference)",
            plural(pixels_different as usize, "wrong pixel")
        ));
    }
}

fn for_people(scene: &SceneReport, reports: &[Report]) -> String {
    let SceneReport {
        file,
        items,
        triangles,
        sectors,
        portals,
        ..
    } = scene;
    let mut text = format!(
        "{file}: {}, {} triangles",
        plural(*items, "item"),
        count(*triangles)
    );
    if *sectors != 1 || *portals > 0 {
        text += &format!(", {}, {}", plural(*sectors, "sector"), plural(*portals, "portal"));
    }
    text.push('\n');
    for report in reports {
        text.push('\n');
        add_report(&mut text, report);
    }
    text
}

/// Appends the text of one method. Writing to a String cannot fail, so `writeln!` results are dropped here and below.
fn add_report(text: &mut String, report: &Report) {
    let [width, height] = report.size;
    let method = if report.method == "own" {
        "the method of each sector"
    } else {
        report.method
    };
    let _ = writeln!(
        text,
        "{method}: {}, {width}x{height}, {}, built in {} ms, {}",
        report.contract,
        plural(report.threads, "thread"),
        ms(report.build_ms),
        bytes(report.bytes)
    );
    text.push_str(&choose::summary_line(&report.choices));
    if report.depth > 0 {
        let growth = report.faces_built as f64 / (report.faces_built - report.splits) as f64;
        let _ = writeln!(
            text,
            "tree: {} after {}, {} times the input; {}",
            plural(report.faces_built as usize, "face"),
            plural(report.splits as usize, "split"),
            short(growth),
            plural(report.depth as usize, "level")
        );
    }
    if report.views.is_empty() {
        text.push_str("no views\n");
        return;
    }
    let header = [
        "view",
        "eye",
        "passages",
        "items in frustum",
        "visible",
        "triangles in frustum",
        "visible",
        "ms",
    ];
    let rows: Vec<Vec<String>> = report
        .views
        .iter()
        .enumerate()
        .map(|(number, view)| {
            let incomplete = if view.complete { "" } else { "+" };
            vec![
                (number + 1).to_string(),
                point(view.eye),
                format!("{}{incomplete}", view.passages),
                count(view.items_in_frustum as u64),
                count(view.items_visible as u64),
                count(view.triangles_in_frustum),
                count(view.triangles_visible),
                ms(view.ms),
            ]
        })
        .collect();
    text.push_str(&table(&header, &rows));
    if report.views.iter().any(|view| !view.complete) {
        text.push_str("+ portal recursion limit reached; the visible set may be incomplete\n");
    }
    if let [view] = &report.views[..] {
        add_passages(text, &view.through);
        add_visible(text, &view.visible);
    }
    add_summary(text, report);
}

fn add_passages(text: &mut String, passages: &[PassageReport]) {
    const FEW: usize = 16;
    if passages.len() < 2 {
        return;
    }
    let header = ["passage", "portals", "contract", "visible"];
    let row = |way: &PassageReport| {
        vec![
            match &way.portal {
                Some(portal) => format!("{} through {portal}", way.sector),
                None => way.sector.clone(),
            },
            way.crossings.to_string(),
            way.contract.to_string(),
            count(way.items_visible as u64),
        ]
    };
    let rows: Vec<Vec<String>> = passages.iter().take(FEW).map(row).collect();
    let _ = write!(text, "\n{}", table(&header, &rows));
    if passages.len() > FEW {
        let more = count((passages.len() - FEW) as u64);
        let _ = writeln!(text, "and {more} more passages (--json - lists all)");
    }
    text.push('\n');
}

fn add_visible(text: &mut String, visible: &[Arc<str>]) {
    const FEW: usize = 12;
    if visible.is_empty() {
        return;
    }
    let _ = write!(text, "visible: {}", visible[..visible.len().min(FEW)].join(", "));
    if visible.len() > FEW {
        let _ = write!(
            text,
            " and {} more (--json - lists all)",
            count((visible.len() - FEW) as u64)
        );
    }
    text.push('\n');
}

fn add_summary(text: &mut String, report: &Report) {
    let summary = &report.summary;
    if summary.views > 1 {
        let _ = writeln!(
            text,
            "{} views: median {} ms, 99 % within {} ms; on average {} of {} items in the frustum are visible",
            summary.views,
            ms(summary.ms_median),
            ms(summary.ms_p99),
            short(summary.items_visible_mean),
            short(summary.items_in_frustum_mean)
        );
    }
    let checks: Vec<_> = report
        .views
        .iter()
        .filter_map(|view| view.check.as_ref())
        .collect();
    if !checks.is_empty() {
        let sum =
            |of: fn(&crate::report::CheckReport) -> u64| count(checks.iter().map(|check| of(check)).sum());
        let _ = writeln!(
            text,
            "check: {} missed of {} certainly visible, {} extra, {} wrong pixels, {} contested; {} of the samples are certain",
            count(summary.missed as u64),
            sum(|check| check.reference_visible as u64),
            sum(|check| check.extra as u64),
            count(summary.pixels_different),
            sum(|check| check.pixels_contested),
            percent(summary.certain.unwrap_or(1.0))
        );
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::args::{Args, Verb};
    use crate::check::CheckResult;
    use crate::open::open;
    use clap::Parser;
    use enfilade::{Contract, ItemIndex, SectorId};

    #[test]
    fn what_is_missed_or_painted_wrongly_fails_unless_the_method_is_approximate() {
        let line = ["enfilade", "look", "@enfilade", "--size", "16x9"];
        let Some(Verb::Look(args)) = Args::try_parse_from(line).expect("sound").verb else {
            panic!("a look")
        };
        let opened = open(
            "@enfilade".as_ref(),
            Purpose::Visibility,
            Choice::Own,
            &args.methods.how.portals,
            &args.methods.how.limits,
            &mut RunFiles::default(),
        )
        .expect("it is built in");
        let views = cameras::views(&args.cameras, &opened).expect("a view");
        let (prepared, _) = prepare(
            &opened,
            Choice::Own,
            ChoiceGoal::Look,
            &args.methods.how,
            views.first(),
        )
        .expect("it fits");
        let fails_with = |contract, missed: &[(SectorId, ItemIndex)], pixels_different| {
            let progress = Progress::spinner("looking");
            let looks = measure::looks(&prepared[0], &views, &mut prepared[0].viewer(), &progress);
            let mut report = Report::new(&opened, &prepared[0], &views, args.cameras.size, looks);
            let missed = missed.to_vec();
            let found = CheckResult {
                reference_visible: 1,
                missed,
                extra: 0,
                pixels_different,
                pixels_contested: 0,
                pixels: 144,
                contested: Vec::new(),
            };
            report.add_checks(&[found], &opened.scene);
            report.contract = contract;
            report.breaks_its_contract()
        };
        let item = (SectorId(0), ItemIndex(0));
        assert!(!fails_with(Contract::Exact, &[], 0));
        assert!(fails_with(Contract::Exact, &[item], 0));
        assert!(fails_with(Contract::Conservative, &[], 1));
        assert!(!fails_with(Contract::Approximate, &[item], 1));
    }
}
