//! `look --shard` and `look --merge`: a check on several machines.
//!
//! A part lists the checks of its views, one line each, and what all parts must share: the scene, the options and the
//! methods. It holds nothing that differs between runs or machines. A merge copies the lines, so numbers keep their
//! digits, and adds up the summary again.

use super::{CERTAIN_ENOUGH, Opened, location, print_approximate, print_failure, warn_of_uncertain};
use crate::Outcome;
use crate::args::{LookArgs, TightnessArg};
use crate::check::{CheckResult, check_methods, reference};
use crate::json::{Sink, json_of};
use crate::measure::{self, LookResult};
use crate::names::Names;
use crate::open::OpenedScene;
use crate::out;
use crate::prepare::{PreparedScene, SkippedMethod};
use crate::progress::Progress;
use crate::read::read_file;
use crate::report::{ContestedReport, parallel_height, single};
use crate::run_files::RunFiles;
use crate::save::Destination;
use crate::shards::PartFiles;
use crate::text::{count, percent, plural, table};
use crate::values::{Choice, Shard};
use anyhow::{Context, Result, anyhow, bail, ensure};
use enfilade::{Contract, View, Viewer};
use serde::{Deserialize, Serialize};
use serde_json::value::{RawValue, to_raw_value};
use std::borrow::Cow;
use std::collections::BTreeMap;
use std::fs::File;
use std::io;
use std::path::{Path, PathBuf};
use xxhash_rust::xxh3::Xxh3;

/// Ending of the names of parts.
const ENDING: &str = "json";

/// Marks a part. Its number changes with the format.
const MARK: &str = "enfilade look part 1";

/// The report of a shard, or of all.
#[derive(Debug, Deserialize, Serialize)]
struct Part<'a> {
    /// [`MARK`].
    part: Cow<'a, str>,
    #[serde(flatten, borrow)]
    run: CheckRun<'a>,
    /// Index and number of shards.
    shard: [u32; 2],
    /// One per method, over the views of this shard.
    summary: Vec<CheckSummary>,
    /// The [`CheckedView`]s of this shard.
    views: Vec<&'a RawValue>,
}

/// What all parts share.
#[derive(Debug, Deserialize, PartialEq, Serialize)]
struct CheckRun<'a> {
    /// Version of the program.
    program: Cow<'a, str>,
    scene: SceneFacts,
    /// The options that matter, as text.
    options: BTreeMap<String, String>,
    view_count: usize,
    /// Hash of the cameras of all views.
    view_hash: String,
    methods: Vec<MethodFacts>,
    skipped: Vec<SkippedFacts>,
}

#[derive(Debug, Deserialize, PartialEq, Serialize)]
struct SceneFacts {
    /// File name, without folders.
    file: String,
    /// Hash of the bytes of all files; absent for a built-in scene.
    #[serde(skip_serializing_if = "Option::is_none")]
    hash: Option<String>,
    items: usize,
    triangles: u64,
    sectors: usize,
    portals: usize,
}

#[derive(Debug, Deserialize, PartialEq, Serialize)]
struct MethodFacts {
    method: String,
    contract: String,
}

#[derive(Debug, Deserialize, PartialEq, Serialize)]
struct SkippedFacts {
    method: String,
    why: String,
}

/// A method over all views of a report.
#[derive(Clone, Debug, Default, Deserialize, Serialize)]
struct CheckSummary {
    method: String,
    views: usize,
    items_visible: u64,
    reference_visible: u64,
    missed: usize,
    extra: u64,
    pixels_different: u64,
    pixels_contested: u64,
    pixels: u64,
}

/// A view, and its check by each method.
#[derive(Debug, Deserialize, Serialize)]
struct CheckedView {
    /// Counted from 1, as in messages.
    view: usize,
    eye: [f32; 3],
    toward: [f32; 3],
    up: [f32; 3],
    /// Vertical field of view, in radians; 0 in a parallel view.
    fov_y: f32,
    /// Height of what a parallel view shows, in scene units.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    parallel: Option<f64>,
    methods: Vec<CheckedMethod>,
}

#[derive(Debug, Deserialize, Serialize)]
struct CheckedMethod {
    method: String,
    complete: bool,
    passages: usize,
    items_in_frustum: usize,
    items_visible: usize,
    triangles_visible: u64,
    reference_visible: usize,
    missed: Vec<String>,
    extra: usize,
    pixels_different: u64,
    pixels_contested: u64,
    pixels: u64,
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    contested: Vec<ContestedReport>,
}

/// Runs `look --shard`.
pub(super) fn run(args: &LookArgs, shard: Shard) -> Result<Outcome> {
    let choice = args.methods.choice();
    ensure!(
        choice != Choice::Auto,
        "--method auto selects by times, which differ between machines; with --shard name a method, or all"
    );
    let parts = PartFiles::new(&args.shards, &args.scene.scene, ENDING)?;
    let mut files = RunFiles::of(&args.scene.scene, args.cameras.path.as_deref())?;
    let destination = files.writes(&parts.path(shard))?;
    let sink = Sink::new(&args.json, &mut files)?;
    let Opened {
        scene: opened,
        views,
        prepared,
        skipped,
    } = Opened::new(args, choice, &mut files)?;
    let checked = checked_views(args, shard, &prepared, &views)?;
    let lines: Vec<Box<RawValue>> = (checked.iter())
        .map(|view| to_raw_value(view).context("cannot encode the report as JSON"))
        .collect::<Result<_>>()?;
    let part = Part {
        part: MARK.into(),
        run: CheckRun {
            program: env!("CARGO_PKG_VERSION").into(),
            scene: SceneFacts::new(&opened, Path::new(&args.scene.scene))?,
            options: options(args),
            view_count: views.len(),
            view_hash: hash_of_views(&views),
            methods: prepared.iter().map(MethodFacts::new).collect(),
            skipped: skipped.into_iter().map(SkippedFacts::from).collect(),
        },
        shard: [shard.index(), shard.count()],
        summary: Vec::new(),
        views: lines.iter().map(|line| &**line).collect(),
    };
    finish(args, part, &checked, Some(&destination), &sink)
}

/// Checks the views of a shard, each with new viewers: what one view sees depends on no other.
fn checked_views(
    args: &LookArgs,
    shard: Shard,
    prepared: &[PreparedScene],
    views: &[View],
) -> Result<Vec<CheckedView>> {
    let own: Vec<(usize, &View)> = views
        .iter()
        .enumerate()
        .filter(|&(number, _)| shard.has(number))
        .collect();
    let Some(first) = prepared.first().filter(|_| !own.is_empty()) else {
        let view = |(number, view)| CheckedView::new(number, view, Vec::new());
        return Ok(own.into_iter().map(view).collect());
    };
    let reference = reference(&first.scene)?;
    let names = Names::new(&first.scene);
    let progress = Progress::steps("checking", own.len());
    let checked = own.into_iter().map(|(number, view)| {
        let mut viewers: Vec<Viewer> = prepared.iter().map(PreparedScene::viewer).collect();
        let looks: Vec<LookResult> = (prepared.iter().zip(&mut viewers))
            .map(|(prepared, viewer)| measure::look(prepared, viewer, view))
            .collect();
        // The command line requires it.
        let samples = args.check.unwrap_or(1);
        let found = check_methods(&reference, prepared, &mut viewers, view, samples);
        let methods = (prepared.iter().zip(&looks).zip(found))
            .map(|((prepared, look), found)| CheckedMethod::new(prepared.method, look, found, &names))
            .collect();
        progress.step();
        CheckedView::new(number, view, methods)
    });
    Ok(checked.collect())
}

/// Runs `look --merge`.
pub(super) fn merge(args: &LookArgs) -> Result<Outcome> {
    let set = PartFiles::new(&args.shards, &args.scene.scene, ENDING)?.whole_set()?;
    let mut files = RunFiles::default();
    set.iter().try_for_each(|(_, path)| files.reads(path))?;
    let sink = Sink::new(&args.json, &mut files)?;
    let texts: Vec<(Shard, &Path, String)> = (set.iter())
        .map(|(shard, path)| {
            let text = read_text(path, args.methods.how.limits.memory())?;
            Ok((*shard, path.as_path(), text))
        })
        .collect::<Result<_>>()?;
    let mut parts = Vec::new();
    for (shard, path, text) in &texts {
        parts.push((*path, *shard, read_part(path, *shard, text)?));
    }
    let (first_path, _, first) = &parts[0];
    for (path, _, part) in &parts[1..] {
        if let Some(differs) = first.run.difference(&part.run) {
            bail!(
                "{} is of another run than {}: {differs}; name the parts of one run",
                path.display(),
                first_path.display()
            );
        }
    }
    let mut views = Vec::new();
    for (path, shard, part) in &parts {
        views.extend(
            part.checked(path, *shard)?
                .into_iter()
                .zip(part.views.iter().copied()),
        );
    }
    views.sort_by_key(|(view, _)| view.view);
    let (checked, lines): (Vec<CheckedView>, Vec<&RawValue>) = views.into_iter().unzip();
    let (_, _, first) = parts.swap_remove(0);
    let part = Part {
        shard: [0, 1],
        views: lines,
        ..first
    };
    finish(args, part, &checked, None, &sink)
}

fn read_text(path: &Path, limit: u64) -> Result<String> {
    let bytes = read_file(path, limit, "raise --memory")?;
    String::from_utf8(bytes).map_err(|_| not_a_part(path))
}

fn not_a_part(path: &Path) -> anyhow::Error {
    anyhow!(
        "{} is not a part that `look --shard` wrote; remove it, and compute the part again",
        path.display()
    )
}

/// Parses the part of a shard.
fn read_part<'a>(path: &Path, shard: Shard, text: &'a str) -> Result<Part<'a>> {
    /// The beginning of any part of any version.
    #[derive(Deserialize)]
    struct Mark {
        part: String,
    }
    let Mark { part } = serde_json::from_str(text).map_err(|_| not_a_part(path))?;
    ensure!(
        part == MARK,
        "{} was written by another version of the program, as `{part}`; compute the part again with this version",
        path.display()
    );
    let damaged = |why: &dyn std::fmt::Display| {
        anyhow!(
            "{} is a damaged part: {why}; copy it again, or compute the part again",
            path.display()
        )
    };
    let part: Part = serde_json::from_str(text).map_err(|why| damaged(&why))?;
    let [index, count] = part.shard;
    ensure!(
        [index, count] == [shard.index(), shard.count()],
        "{} is the part of shard {index}/{count}; undo the change of its name, or compute the part again",
        path.display()
    );
    Ok(part)
}

impl Part<'_> {
    /// Parses the views. Fails unless they are those of the shard.
    fn checked(&self, path: &Path, shard: Shard) -> Result<Vec<CheckedView>> {
        let damaged = || {
            format!(
                "{} is a damaged part; copy it again, or compute the part again",
                path.display()
            )
        };
        let checked: Vec<CheckedView> = (self.views.iter())
            .map(|line| serde_json::from_str(line.get()).with_context(damaged))
            .collect::<Result<_>>()?;
        let expected = (0..self.run.view_count).filter(|&number| shard.has(number));
        let methods = || self.run.methods.iter().map(|facts| &facts.method);
        let is_whole = expected.eq(checked.iter().map(|view| view.view.wrapping_sub(1)))
            && (checked.iter()).all(|view| methods().eq(view.methods.iter().map(|checked| &checked.method)));
        ensure!(is_whole, "{}: it lacks views or methods", damaged());
        Ok(checked)
    }
}

impl CheckRun<'_> {
    /// Returns the first difference from another run, in words.
    fn difference(&self, other: &CheckRun) -> Option<String> {
        if self.program != other.program {
            return Some(format!("program versions {} and {}", self.program, other.program));
        }
        if self.scene != other.scene {
            let [a, b] = [self, other].map(|run| &run.scene.file);
            return Some(if a == b {
                format!("the bytes of {a} differ")
            } else {
                format!("scenes {a} and {b}")
            });
        }
        let names = self.options.keys().chain(other.options.keys());
        for name in names {
            let values = [self, other].map(|run| run.options.get(name).map_or("not given", String::as_str));
            if values[0] != values[1] {
                return Some(format!("--{name} {} and {}", values[0], values[1]));
            }
        }
        if (self.view_count, &self.view_hash) != (other.view_count, &other.view_hash) {
            return Some("the views differ".to_owned());
        }
        (self != other).then(|| "the methods differ".to_owned())
    }
}

/// Adds the summary, prints and writes the report.
fn finish(
    args: &LookArgs,
    mut part: Part,
    checked: &[CheckedView],
    destination: Option<&Destination>,
    sink: &Sink,
) -> Result<Outcome> {
    part.summary = summary(&part.run.methods, checked);
    if let Some(destination) = destination {
        destination.write(json_of(&part)?.as_bytes())?;
    }
    if !args.json.takes_stdout() {
        out::print(&for_people(&part))?;
    }
    sink.write(&part)?;
    warn_of_contested(&part, checked);
    let mut outcome = Outcome::Done;
    for (number, (facts, sum)) in part.run.methods.iter().zip(&part.summary).enumerate() {
        if facts.contract == Contract::Approximate.to_string() {
            print_approximate(&facts.method, sum.missed, sum.pixels_different);
            continue;
        }
        if sum.missed > 0 || sum.pixels_different > 0 {
            outcome = Outcome::CheckFailed;
        }
        for view in checked {
            let found = &view.methods[number];
            let location = location(&facts.method, view.view, view.eye);
            print_failure(&location, &found.missed, found.pixels_different);
        }
    }
    Ok(outcome)
}

fn summary(methods: &[MethodFacts], checked: &[CheckedView]) -> Vec<CheckSummary> {
    let of_method = |(number, facts): (usize, &MethodFacts)| {
        let mut sum = CheckSummary {
            method: facts.method.clone(),
            ..CheckSummary::default()
        };
        for found in checked.iter().map(|view| &view.methods[number]) {
            sum.views += 1;
            sum.items_visible += found.items_visible as u64;
            sum.reference_visible += found.reference_visible as u64;
            sum.missed += found.missed.len();
            sum.extra += found.extra as u64;
            sum.pixels_different += found.pixels_different;
            sum.pixels_contested += found.pixels_contested;
            sum.pixels += found.pixels;
        }
        sum
    };
    methods.iter().enumerate().map(of_method).collect()
}

fn for_people(part: &Part) -> String {
    let [index, shards] = part.shard;
    let of_all = if shards > 1 {
        format!(
            ", shard {index}/{shards} of {}",
            plural(part.run.view_count, "view")
        )
    } else {
        String::new()
    };
    let mut text = format!(
        "{}: {} checked{of_all}\n\n",
        part.run.scene.file,
        plural(part.views.len(), "view")
    );
    let header = [
        "method",
        "contract",
        "missed",
        "of visible",
        "extra",
        "wrong pixels",
        "contested",
        "certain",
    ];
    let row = |(facts, sum): (&MethodFacts, &CheckSummary)| {
        vec![
            facts.method.clone(),
            facts.contract.clone(),
            count(sum.missed as u64),
            count(sum.reference_visible),
            count(sum.extra),
            count(sum.pixels_different),
            count(sum.pixels_contested),
            percent(sum.certain()),
        ]
    };
    let rows: Vec<Vec<String>> = part.run.methods.iter().zip(&part.summary).map(row).collect();
    text += &table(&header, &rows);
    for SkippedFacts { method, why } in &part.run.skipped {
        text += &format!("  {method} is skipped: {why}\n");
    }
    text
}

/// Warns if the reference could not decide the owner of many samples.
fn warn_of_contested(part: &Part, checked: &[CheckedView]) {
    // The reference is the same for all methods.
    let Some(certain) = part.summary.first().map(CheckSummary::certain) else {
        return;
    };
    if certain >= CERTAIN_ENOUGH {
        return;
    }
    let mut groups: BTreeMap<&[String], u64> = BTreeMap::new();
    for contested in checked.iter().flat_map(|view| &view.methods[0].contested) {
        *groups.entry(&contested.items).or_default() += contested.pixels;
    }
    warn_of_uncertain(certain, groups);
}

impl CheckSummary {
    /// Returns the share of the samples that have one possible owner.
    fn certain(&self) -> f64 {
        1.0 - self.pixels_contested as f64 / self.pixels.max(1) as f64
    }
}

impl SceneFacts {
    fn new(opened: &OpenedScene, path: &Path) -> Result<SceneFacts> {
        let scene = &opened.scene;
        let is_built_in = opened.file.starts_with('@');
        let name = path.file_name().unwrap_or_default().to_string_lossy();
        Ok(SceneFacts {
            file: name.into_owned(),
            hash: if is_built_in {
                None
            } else {
                Some(hash_of_files(path, &opened.files)?)
            },
            items: scene.item_count(),
            triangles: scene.triangle_count(),
            sectors: scene.sector_count(),
            portals: scene.portals().len(),
        })
    }
}

/// Returns a hash of the bytes of a scene's files. Images do not count: visibility does not depend on them.
fn hash_of_files(scene: &Path, others: &[PathBuf]) -> Result<String> {
    const IMAGES: [&str; 6] = ["png", "jpg", "jpeg", "webp", "ktx2", "tga"];
    let is_image = |path: &Path| {
        let ending = path.extension().and_then(|ending| ending.to_str());
        ending.is_some_and(|ending| IMAGES.iter().any(|image| image.eq_ignore_ascii_case(ending)))
    };
    let mut hash = Xxh3::new();
    let others = others.iter().map(PathBuf::as_path);
    for path in [scene].into_iter().chain(others.filter(|path| !is_image(path))) {
        let fails = || format!("cannot read {}", path.display());
        // The reader has warned of it, or does not need it. Opening a pipe would block until someone writes.
        if !path.is_file() && path != scene {
            continue;
        }
        let mut file = File::open(path).with_context(fails)?;
        let length = io::copy(&mut file, &mut hash).with_context(fails)?;
        hash.update(&length.to_le_bytes());
    }
    Ok(format!("{:032x}", hash.digest128()))
}

fn hash_of_views(views: &[View]) -> String {
    let mut hash = Xxh3::new();
    for view in views {
        let vectors = [view.eye(), view.toward(), view.up()];
        let numbers = vectors.into_iter().flatten();
        numbers
            .chain([f64::from(view.fov_y()), parallel_height(view).unwrap_or(0.0)])
            .for_each(|number| hash.update(&number.to_le_bytes()));
        view.size()
            .iter()
            .for_each(|side| hash.update(&side.to_le_bytes()));
    }
    format!("{:032x}", hash.digest128())
}

/// Returns the options that change the report, as text.
fn options(args: &LookArgs) -> BTreeMap<String, String> {
    let (cameras, how) = (&args.cameras, &args.methods.how);
    let size = |[width, height]: [u32; 2]| format!("{width}x{height}");
    let is_set = |is_set: bool| is_set.then(|| "given".to_owned());
    let method = match args.methods.choice() {
        Choice::Own => "own",
        Choice::One(method) => method.name(),
        Choice::All => "all",
        Choice::Auto => "auto",
    };
    let tightness = match how.tightness {
        TightnessArg::Boxes => "boxes",
        TightnessArg::Faces => "faces",
        TightnessArg::Resolved => "resolved",
    };
    let options = [
        ("check", args.check.map(|samples| samples.to_string())),
        ("size", Some(size(cameras.size))),
        ("survey", cameras.survey.map(|views| views.to_string())),
        ("survey-hard", cameras.survey_hard.map(|views| views.to_string())),
        ("method", Some(method.to_owned())),
        ("no-coherence", is_set(how.no_coherence)),
        ("occluders", how.occluders.map(|most| most.to_string())),
        ("cover-size", how.cover_size.map(size)),
        ("tightness", Some(tightness.to_owned())),
        ("flat", is_set(how.portals.flat)),
        ("skip-bad-portals", is_set(how.portals.bad.skip)),
        ("scene", how.portals.file.scene_of_file.clone()),
        ("lenient", is_set(how.portals.file.lenient)),
        ("memory", Some(how.limits.memory().to_string())),
    ];
    let given = options
        .into_iter()
        .filter_map(|(name, value)| Some((name.to_owned(), value?)));
    given.collect()
}

impl MethodFacts {
    fn new(prepared: &PreparedScene) -> MethodFacts {
        MethodFacts {
            method: prepared.method.to_owned(),
            contract: prepared.contract.to_string(),
        }
    }
}

impl From<SkippedMethod> for SkippedFacts {
    fn from(SkippedMethod { method, why }: SkippedMethod) -> SkippedFacts {
        SkippedFacts {
            method: method.to_owned(),
            why,
        }
    }
}

impl CheckedView {
    /// Creates the report of the view with an index.
    fn new(number: usize, view: &View, methods: Vec<CheckedMethod>) -> CheckedView {
        CheckedView {
            view: number + 1,
            eye: view.eye().map(single),
            toward: view.toward().map(single),
            up: view.up().map(single),
            fov_y: view.fov_y(),
            parallel: parallel_height(view),
            methods,
        }
    }
}

impl CheckedMethod {
    fn new(method: &str, look: &LookResult, found: CheckResult, names: &Names) -> CheckedMethod {
        let contested = found.contested.iter().map(|(items, pixels)| ContestedReport {
            items: items.iter().map(|&item| names.of(item)).collect(),
            pixels: *pixels,
        });
        CheckedMethod {
            method: method.to_owned(),
            complete: look.complete,
            passages: look.passages.len(),
            items_in_frustum: look.items_in_frustum,
            items_visible: look.visible.len(),
            triangles_visible: look.triangles_visible,
            reference_visible: found.reference_visible,
            missed: found.missed.iter().map(|&item| names.of(item)).collect(),
            extra: found.extra,
            pixels_different: found.pixels_different,
            pixels_contested: found.pixels_contested,
            pixels: found.pixels,
            contested: contested.collect(),
        }
    }
}
