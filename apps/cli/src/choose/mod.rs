//! `choose`: which method suits which sector, with what each costs there; and what `--method auto` takes.

mod report;

use crate::Outcome;
use crate::args::{ChooseArgs, PortalArgs};
use crate::open::{For, Opened, open, settle_on};
use crate::out;
use crate::prepare::stays_visible;
use crate::progress::Progress;
use crate::report::Sink;
use crate::run_files::RunFiles;
use crate::values::{Choice, among};
use anyhow::{Context, Result, anyhow, ensure};
use enfilade::{ChoiceGoal, ChoiceOptions, MethodChoice, Scene, SectorId, View, choose_methods, survey_in};
use std::path::Path;
use std::time::Instant;

pub(crate) use report::{ChoiceReport, in_words};
use report::{Chosen, HeldBack};

/// Views in each sector that methods are tried on, and as many that are held back.
const PLACES: usize = 32;

/// Runs `choose`.
pub(crate) fn run(args: &ChooseArgs) -> Result<Outcome> {
    let mut files = RunFiles::of(&args.scene.scene, None)?;
    let sink = Sink::new(&args.json, &mut files)?;
    let output = args.output.as_deref();
    let destination = output.map(|output| files.writes(output)).transpose()?;
    settle_on(&args.limits, args.simd.as_deref())?;
    // As it is read for answers with a method of its own for each room, so that pins are no part of the question.
    let opened = open(
        &args.scene.scene,
        For::Answers,
        Choice::Auto,
        PortalArgs {
            flat: false,
            bad: args.bad_portals,
        },
        &args.limits,
        &mut files,
    )?;
    let file = Path::new(&args.scene.scene);
    stays_visible(&opened, None)?;
    if let Some(output) = output {
        ensure!(
            !opened.file.starts_with('@'),
            "{}: methods cannot be written into a built-in scene; leave out -o, or name a file",
            opened.file
        );
        must_lie_beside(file, output)?;
    }
    let mut terms = ChoiceOptions::default();
    terms.aim = args.aim;
    terms.exact = !args.conservative;
    terms.limit_bytes = args.limits.memory();
    terms.moving = named(&args.moving, &opened)?;
    let choices = choose(&opened.scene, args.size, &terms);
    let held_back = args.check.then(|| {
        let views = views(&opened.scene, args.size, 1);
        let again = measured(&opened.scene, &views, &terms, "measuring again");
        HeldBack::new(&choices, &again, views.len())
    });
    let chosen = Chosen::new(&opened, &choices, &terms, args.size, held_back);
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

/// Finds the methods that suit a scene's sectors, by views from places all over them.
pub(crate) fn choose(scene: &Scene, size: [u32; 2], terms: &ChoiceOptions) -> Vec<MethodChoice> {
    measured(scene, &views(scene, size, 0), terms, "trying methods")
}

/// Views from every other place in each sector, from the first on (those that methods are chosen by) or the second.
fn views(scene: &Scene, size: [u32; 2], from: usize) -> Vec<View> {
    let places = scene.sectors().flat_map(|sector| {
        let places = survey_in(scene, sector, 2 * PLACES).views;
        places.into_iter().skip(from).step_by(2)
    });
    places
        .map(|place| View::new(place.eye, place.toward, size))
        .collect()
}

fn measured(scene: &Scene, views: &[View], terms: &ChoiceOptions, what: &str) -> Vec<MethodChoice> {
    let progress = Progress::spinner(what);
    let start = Instant::now();
    let choices = choose_methods(scene, views, terms, &|| start.elapsed());
    drop(progress);
    choices
}

/// Takes choices over.
///
/// # Errors
/// What a method of the choice builds was within the limit when it was tried, so none is expected.
pub(crate) fn take_over(scene: &mut Scene, choices: &[MethodChoice]) -> Result<()> {
    for choice in choices {
        // A sector that is no geometry has no other method.
        let method = scene.method(choice.sector);
        if method.is_some_and(|method| method != choice.method) {
            scene.set_method(choice.sector, choice.method)?;
        }
    }
    Ok(())
}

/// Says for what `--method auto` chose, in the words of a verb.
pub(crate) fn terms(aim: ChoiceGoal, exact: bool, limit_bytes: u64) -> ChoiceOptions {
    let mut terms = ChoiceOptions::default();
    (terms.aim, terms.exact, terms.limit_bytes) = (aim, exact, limit_bytes);
    terms
}

/// Sectors by their names.
fn named(names: &[String], opened: &Opened) -> Result<Vec<SectorId>> {
    let scene = &opened.scene;
    let find = |name: &String| {
        let mut found = scene.sectors().filter(|&id| scene.sector_name(id) == name);
        found.next().ok_or_else(|| {
            let all = scene.sectors().map(|id| scene.sector_name(id));
            anyhow!(
                "{}: there is no sector `{name}`; {}",
                opened.file,
                among(name, all)
            )
        })
    };
    names.iter().map(find).collect()
}

/// Files that a file names are looked for in its folder, so a copy of it must lie there too.
fn must_lie_beside(file: &Path, output: &Path) -> Result<()> {
    let folder = |path: &Path| {
        let folder = path.parent().filter(|folder| !folder.as_os_str().is_empty());
        folder.unwrap_or(Path::new(".")).canonicalize().ok()
    };
    let is_whole = file
        .extension()
        .is_some_and(|ending| ending.eq_ignore_ascii_case("glb"));
    ensure!(
        is_whole || folder(file) == folder(output),
        "cannot write {}: {} names other files, which are looked for in its folder; write the copy there",
        output.display(),
        file.display()
    );
    Ok(())
}
