//! `choose`: measures which method is fastest in each sector. Also implements `--method auto`.

mod report;

use crate::Outcome;
use crate::args::{ChooseArgs, PortalArgs};
use crate::json::Sink;
use crate::open::{OpenedScene, Purpose, configure_with, open, stays_visible};
use crate::out;
use crate::progress::Progress;
use crate::run_files::RunFiles;
use crate::values::{Choice, among};
use anyhow::{Context, Result, anyhow, ensure};
use enfilade::{
    Camera, ChoiceGoal, ChoiceOptions, MethodChoice, Scene, SectorId, SurveyView, View, choose_methods,
    survey_with,
};
use std::path::Path;
use std::time::Instant;

pub(crate) use report::{ChoiceReport, summary_line};
use report::{ChooseReport, HeldOut};

/// Number of views per sector that methods are measured on; `--check` uses as many others.
const VIEWS_PER_SECTOR: usize = 32;

/// Runs `choose`.
pub(crate) fn run(args: &ChooseArgs) -> Result<Outcome> {
    let mut files = RunFiles::of(&args.scene.scene, None)?;
    let sink = Sink::new(&args.json, &mut files)?;
    let output = args.output.as_deref();
    let destination = output.map(|output| files.writes(output)).transpose()?;
    configure_with(&args.limits, args.simd.as_deref())?;
    // With `Choice::Auto` the file's methods are ignored, so that pinned ones do not influence the measurement.
    let mut opened = open(
        &args.scene.scene,
        Purpose::Visibility,
        Choice::Auto,
        &PortalArgs {
            bad: args.bad_portals,
            ..PortalArgs::default()
        },
        &args.limits,
        &mut files,
    )?;
    opened.upright.set(&args.upright);
    let file = Path::new(&args.scene.scene);
    stays_visible(&opened, None)?;
    if let Some(output) = output {
        ensure!(
            !opened.file.starts_with('@'),
            "{}: methods cannot be written into a built-in scene; leave out -o, or name a scene file",
            opened.file
        );
        check_same_folder(file, output)?;
    }
    let mut options = ChoiceOptions::default();
    options.aim = args.aim;
    options.exact = !args.conservative;
    options.limit_bytes = args.limits.memory();
    options.moving = named(&args.moving, &opened)?;
    let choices = choose(&opened, args.size, &options);
    let held_back = args.check.then(|| {
        let views = views(&opened, args.size, 1);
        let again = measured(&opened.scene, &views, &options, "measuring again");
        HeldOut::new(&choices, &again, views.len())
    });
    let chosen = ChooseReport::new(&opened, &choices, &options, args.size, held_back);
    if let Some(destination) = &destination {
        let methods: Vec<_> = choices.iter().map(|choice| choice.method).collect();
        let pinned = enfilade_import::with_methods(file, &methods, args.limits.memory())
            .with_context(|| opened.file.clone())?;
        destination.write(&pinned)?;
    }
    if !args.json.takes_stdout() {
        out::print(&chosen.for_people())?;
    }
    sink.write(&chosen)?;
    Ok(Outcome::Done)
}

/// Chooses the methods of a scene's sectors, by views from positions all over them.
pub(crate) fn choose(opened: &OpenedScene, size: [u32; 2], options: &ChoiceOptions) -> Vec<MethodChoice> {
    measured(
        &opened.scene,
        &views(opened, size, 0),
        options,
        "measuring methods",
    )
}

/// Returns views from every second survey position of each sector: for `from` 0 those that methods are chosen by, for 1
/// those that `--check` uses.
fn views(opened: &OpenedScene, size: [u32; 2], from: usize) -> Vec<View> {
    let mut options = opened.upright.survey_options();
    let positions = opened.scene.sectors().flat_map(|sector| {
        options.sector = Some(sector);
        let positions = survey_with(&opened.scene, 2 * VIEWS_PER_SECTOR, &options).views;
        positions.into_iter().skip(from).step_by(2)
    });
    let view = |position: SurveyView| {
        let camera = Camera {
            up: opened.upright.up_f64().into(),
            ..Camera::new(position.eye, position.toward)
        };
        camera.view(size).expect("a valid view")
    };
    positions.map(view).collect()
}

fn measured(scene: &Scene, views: &[View], options: &ChoiceOptions, label: &str) -> Vec<MethodChoice> {
    let progress = Progress::spinner(label);
    let start = Instant::now();
    let choices = choose_methods(scene, views, options, &|| start.elapsed());
    drop(progress);
    choices
}

/// Applies choices to a scene.
///
/// # Errors
/// None are expected: every chosen method was built within the limit when it was measured.
pub(crate) fn apply(scene: &mut Scene, choices: &[MethodChoice]) -> Result<()> {
    for choice in choices {
        // Custom sectors have no method to replace.
        let method = scene.method(choice.sector);
        if method.is_some_and(|method| method != choice.method) {
            scene.set_method(choice.sector, choice.method)?;
        }
    }
    Ok(())
}

/// Returns the options of `--method auto`.
pub(crate) fn auto_options(aim: ChoiceGoal, exact: bool, limit_bytes: u64) -> ChoiceOptions {
    let mut options = ChoiceOptions::default();
    (options.aim, options.exact, options.limit_bytes) = (aim, exact, limit_bytes);
    options
}

/// Returns the sectors with these names.
fn named(names: &[String], opened: &OpenedScene) -> Result<Vec<SectorId>> {
    let scene = &opened.scene;
    let find = |name: &String| {
        let mut found = scene.sectors().filter(|&id| scene.sector_name(id) == name);
        found.next().ok_or_else(|| {
            let all = scene.sectors().map(|id| scene.sector_name(id));
            anyhow!("{}: no sector `{name}`; {}", opened.file, among(name, all))
        })
    };
    names.iter().map(find).collect()
}

/// Fails if the copy of a file with side files would be in another folder: side files are found relative to the file.
fn check_same_folder(file: &Path, output: &Path) -> Result<()> {
    let folder = |path: &Path| {
        let folder = path.parent().filter(|folder| !folder.as_os_str().is_empty());
        folder.unwrap_or(Path::new(".")).canonicalize().ok()
    };
    let is_whole = file
        .extension()
        .is_some_and(|ending| ending.eq_ignore_ascii_case("glb"));
    ensure!(
        is_whole || folder(file) == folder(output),
        "cannot write {}: {} names other files relative to its folder; write the copy to that folder",
        output.display(),
        file.display()
    );
    Ok(())
}
