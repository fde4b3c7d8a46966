//! Builds the requested methods over a scene, each within the memory limit.

use crate::args::{HowArgs, TightnessArg};
use crate::choose::{self, ChoiceReport};
use crate::open::{OpenedScene, stays_visible};
use crate::progress::Progress;
use crate::values::Choice;
use anyhow::{Result, anyhow, bail, ensure};
use enfilade::{ChoiceGoal, Contract, Method, Scene, Unsuited, UnsuitedMethod, View, Viewer, ViewerOptions};
use enfilade_draw::Stage;
use serde::Serialize;
use std::sync::{Arc, OnceLock};
use std::time::Instant;

/// A scene with a method built over it, and the options of its viewers.
pub(crate) struct PreparedScene {
    /// The method's name, `own` or `auto`.
    pub(crate) method: &'static str,
    /// The weakest contract of all sectors; a view that shows only some of them may have a stronger one.
    pub(crate) contract: Contract,
    pub(crate) scene: Scene,
    pub(crate) build_ms: f64,
    stage: Arc<OnceLock<Stage>>,
    pub(crate) options: ViewerOptions,
    /// How `auto` chose the methods; empty otherwise.
    pub(crate) choices: Vec<ChoiceReport>,
}

/// A method that does not suit the scene, or exceeds the memory limit.
#[derive(Debug, Serialize)]
pub(crate) struct SkippedMethod {
    pub(crate) method: &'static str,
    pub(crate) why: String,
}

/// Returns the text for skipped methods, one line each.
pub(crate) fn left_out(skipped: &[SkippedMethod]) -> String {
    let line = |SkippedMethod { method, why }: &SkippedMethod| format!("  {method} is skipped: {why}\n");
    skipped.iter().map(line).collect()
}

impl PreparedScene {
    /// Returns the data that the pictures of all methods over one scene share.
    pub(crate) fn stage(&self) -> &Stage {
        self.stage.get_or_init(|| Stage::new(&self.scene))
    }

    /// Returns a new viewer, without temporal coherence data yet.
    pub(crate) fn viewer(&self) -> Viewer {
        Viewer::with_options(self.options)
    }

    /// Returns the method for text output: its name if all sectors use the same.
    pub(crate) fn spoken_method(&self) -> &'static str {
        match self.methods().as_slice() {
            [one] => one.name(),
            _ => "the method of each sector",
        }
    }

    /// Returns the methods of the sectors, each once.
    pub(crate) fn methods(&self) -> Vec<Method> {
        methods_of(&self.scene)
    }

    /// Returns the memory of the scene, the methods' data and the buffers for a screen of this size, in bytes.
    pub(crate) fn bytes(&self, size: [u32; 2]) -> u64 {
        self.scene.bytes()
            + self
                .methods()
                .iter()
                .map(|method| method.screen_bytes(size, self.options.cover_size))
                .sum::<u64>()
    }
}

/// Builds the requested methods over a scene, for views of one size. `auto` minimizes the cost of `aim`.
///
/// # Errors
/// Fails if a method needs too much memory or does not suit the scene. With [`Choice::All`] such methods are skipped
/// and returned with the reason.
pub(crate) fn prepare(
    opened: &OpenedScene,
    choice: Choice,
    aim: ChoiceGoal,
    how: &HowArgs,
    view: Option<&View>,
) -> Result<(Vec<PreparedScene>, Vec<SkippedMethod>)> {
    check_cover_size(opened, choice, how, view)?;
    check_tightness(opened, choice, how)?;
    if let Choice::One(method) = choice {
        stays_visible(opened, Some(method))?;
    }
    if choice == Choice::Auto {
        return Ok((vec![chosen(opened, aim, how, view)?], Vec::new()));
    }
    let progress = Progress::steps(
        "building",
        if choice == Choice::All {
            Method::ALL.len()
        } else {
            1
        },
    );
    let build = |choice| {
        let built = build(opened, choice, how, view);
        progress.step();
        built
    };
    if choice != Choice::All {
        let built = build(choice).map_err(|why| {
            // The message itself names a method to use instead.
            let remedy = match why.reason {
                Unsuited::NotBaked => " (`enfilade vis` bakes maps)",
                Unsuited::NotConvex(_) => ", or split the sector into convex rooms",
                Unsuited::NoTerrain | Unsuited::TerrainEdited => "",
                _ => "; raise --memory, or use a smaller --size or another --method",
            };
            anyhow!("{}: {why}{remedy}", opened.file)
        })?;
        return Ok((vec![built], Vec::new()));
    }
    let (mut prepared, mut skipped) = (Vec::new(), Vec::new());
    for method in Method::ALL {
        if let Err(why) = stays_visible(opened, Some(method)) {
            skipped.push(SkippedMethod {
                method: method.name(),
                why: why.to_string(),
            });
            progress.step();
            continue;
        }
        match build(Choice::One(method)) {
            Ok(built) => prepared.push(built),
            Err(why) => skipped.push(SkippedMethod {
                method: method.name(),
                why: why.to_string(),
            }),
        }
    }
    Ok((prepared, skipped))
}

/// Measures the methods, and builds the cheapest for each sector.
fn chosen(
    opened: &OpenedScene,
    aim: ChoiceGoal,
    how: &HowArgs,
    view: Option<&View>,
) -> Result<PreparedScene> {
    let scene = &opened.scene;
    let size = view.map_or([1280, 720], |view| view.size());
    let options = choose::auto_options(aim, !how.conservative, how.limits.memory());
    let choices = choose::choose(opened, size, &options);
    let mut with_choices = scene.clone();
    let start = Instant::now();
    choose::apply(&mut with_choices, &choices)?;
    let built = BuiltScene {
        scene: with_choices,
        ms: start.elapsed().as_secs_f64() * 1e3,
        choices: choices
            .iter()
            .map(|choice| ChoiceReport::new(scene, choice))
            .collect(),
    };
    finish(opened, "auto", built, how, view).map_err(|why| anyhow!("{}: {why}", opened.file))
}

/// Fails if `--cover-size` exceeds the screen, or if no selected method supports it.
fn check_cover_size(opened: &OpenedScene, choice: Choice, how: &HowArgs, view: Option<&View>) -> Result<()> {
    let (Some([width, height]), Some(view)) = (how.cover_size, view) else {
        return Ok(());
    };
    let screen = view.size();
    ensure!(
        width <= screen[0] && height <= screen[1],
        "--cover-size {width}x{height} is larger than the screen; use {}x{} at most, or a larger --size",
        screen[0],
        screen[1]
    );
    check_has_effect("--cover-size", opened, choice, |method| method.takes_cover_size())
}

/// Fails if `--tightness faces` or `resolved` would have no effect.
fn check_tightness(opened: &OpenedScene, choice: Choice, how: &HowArgs) -> Result<()> {
    let option = match how.tightness {
        TightnessArg::Boxes => return Ok(()),
        TightnessArg::Faces => "--tightness faces",
        TightnessArg::Resolved => "--tightness resolved",
    };
    ensure!(
        how.cover_size.is_none(),
        "{option} has no effect with --cover-size; leave one of them out"
    );
    check_has_effect(option, opened, choice, |method| method == Method::Masked)
}

/// Fails if an option affects none of the selected methods.
fn check_has_effect(
    option: &str,
    opened: &OpenedScene,
    choice: Choice,
    affects: impl Fn(Method) -> bool,
) -> Result<()> {
    let methods = match choice {
        Choice::One(method) => vec![method],
        Choice::Own => methods_of(&opened.scene),
        Choice::All | Choice::Auto => return Ok(()),
    };
    if methods.iter().any(|&method| affects(method)) {
        return Ok(());
    }
    let able = Method::ALL.into_iter().filter(|&method| affects(method));
    let able: Vec<&str> = able.map(|method| method.name()).collect();
    bail!(
        "{}: {option} has no effect on {}; use it with --method {}, or leave it out",
        opened.file,
        methods[0],
        able.join(", ")
    )
}

fn build(
    opened: &OpenedScene,
    choice: Choice,
    how: &HowArgs,
    view: Option<&View>,
) -> Result<PreparedScene, UnsuitedMethod> {
    let limit = how.limits.memory();
    let scene = &opened.scene;
    let start = Instant::now();
    let (name, scene) = match choice {
        Choice::One(method) => (method.name(), scene.with_method(method, limit)?),
        Choice::Own | Choice::All | Choice::Auto => {
            // Already built; built again to time it and to enforce the limit.
            for (geometry, method) in geometries(scene) {
                method.build(Arc::clone(geometry), limit)?;
            }
            ("own", scene.clone())
        }
    };
    let built = BuiltScene {
        scene,
        ms: start.elapsed().as_secs_f64() * 1e3,
        choices: Vec::new(),
    };
    finish(opened, name, built, how, view)
}

/// A scene with the requested methods, and the time to build them.
struct BuiltScene {
    scene: Scene,
    ms: f64,
    choices: Vec<ChoiceReport>,
}

fn finish(
    opened: &OpenedScene,
    name: &'static str,
    built: BuiltScene,
    how: &HowArgs,
    view: Option<&View>,
) -> Result<PreparedScene, UnsuitedMethod> {
    let limit = how.limits.memory();
    let BuiltScene { scene, ms, choices } = built;
    let methods = methods_of(&scene);
    if let Some(view) = view {
        methods
            .iter()
            .try_for_each(|method| method.check_screen(view, how.cover_size, limit))?;
    }
    // A cover of the screen's size has one cell per sample, so it is the default.
    let cover_size = how
        .cover_size
        .filter(|&cells| view.is_none_or(|view| view.size() != cells));
    let options = ViewerOptions {
        coherence: !how.no_coherence,
        occluders: how.occluders,
        cover_size,
        tightness: how.tightness.into(),
        ..ViewerOptions::default()
    };
    Ok(PreparedScene {
        method: name,
        contract: scene
            .sectors()
            .map(|id| scene.sector(id).contract(&options))
            .reduce(Contract::combined_with)
            .unwrap_or(Contract::Exact),
        scene: if how.portals.flat {
            scene.without_portals()
        } else {
            scene
        },
        build_ms: ms,
        stage: Arc::clone(&opened.stage),
        options,
        choices,
    })
}

/// Returns the same scene with another method, without a memory limit. Use a method that is cheap to build.
pub(crate) fn drawn_by(prepared: &PreparedScene, method: Method) -> Result<PreparedScene, UnsuitedMethod> {
    Ok(PreparedScene {
        method: method.name(),
        contract: method.contract(),
        scene: prepared.scene.with_method(method, u64::MAX)?,
        stage: Arc::clone(&prepared.stage),
        choices: Vec::new(),
        ..*prepared
    })
}

fn geometries(scene: &Scene) -> impl Iterator<Item = (&Arc<enfilade::Geometry>, Method)> {
    scene
        .sectors()
        .filter_map(|id| Some((scene.geometry(id)?, scene.method(id)?)))
}

/// Returns the methods of a scene's sectors, each once.
fn methods_of(scene: &Scene) -> Vec<Method> {
    let mut methods = Vec::new();
    for (_, method) in geometries(scene) {
        if !methods.contains(&method) {
            methods.push(method);
        }
    }
    methods
}
