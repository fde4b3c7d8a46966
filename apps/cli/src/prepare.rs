//! The methods that are asked for, each built over the scene and within its memory.

use crate::args::HowArgs;
use crate::choose::{self, ChoiceReport};
use crate::open::Opened;
use crate::progress::Progress;
use crate::report::Skipped;
use crate::values::Choice;
use anyhow::{Result, anyhow, bail, ensure};
use enfilade::{ChoiceGoal, Contract, Method, Scene, Unsuited, View, Viewer};
use enfilade_draw::Stage;
use std::sync::{Arc, OnceLock};
use std::time::Instant;

/// A scene ready to be looked at by a method.
pub(crate) struct Prepared {
    /// The method's name, or `own`.
    pub(crate) method: &'static str,
    /// Of all sectors together; where only some are seen, more may be promised.
    pub(crate) contract: Contract,
    pub(crate) scene: Scene,
    pub(crate) build_ms: f64,
    stage: Arc<OnceLock<Stage>>,
    coherence: bool,
    occluders: Option<u32>,
    pub(crate) cover_size: Option<[u32; 2]>,
    /// How its methods were chosen, where they were.
    pub(crate) choices: Vec<ChoiceReport>,
}

impl Prepared {
    /// What its pictures share: those of all methods over one scene.
    pub(crate) fn stage(&self) -> &Stage {
        self.stage.get_or_init(|| Stage::new(&self.scene))
    }

    /// A viewer that remembers nothing yet.
    pub(crate) fn viewer(&self) -> Viewer {
        let mut viewer = Viewer::new();
        viewer.set_coherence(self.coherence);
        viewer.set_occluders(self.occluders);
        viewer.set_cover_size(self.cover_size);
        viewer
    }

    /// The method in words for people: `own` says which one, where all sectors agree.
    pub(crate) fn spoken_method(&self) -> &'static str {
        match self.methods().as_slice() {
            [one] => one.name(),
            _ => "each sector's own method",
        }
    }

    /// The methods that its sectors are seen by, each once.
    pub(crate) fn methods(&self) -> Vec<Method> {
        methods_of(&self.scene)
    }

    /// Memory of the scene, of what was built over it, and of the buffers for a screen of this size, in bytes.
    pub(crate) fn bytes(&self, size: [u32; 2]) -> u64 {
        self.scene.bytes()
            + self
                .methods()
                .iter()
                .map(|method| method.screen_bytes(size, self.cover_size))
                .sum::<u64>()
    }
}

/// Builds what is asked for over a scene, for views that all have one size; where methods are to be chosen, those that make
/// `aim` cheap.
///
/// # Errors
/// A method that would need too much memory, or does not suit the scene, unless all were asked for: then it is skipped.
pub(crate) fn prepare(
    opened: &Opened,
    choice: Choice,
    aim: ChoiceGoal,
    how: &HowArgs,
    view: Option<&View>,
) -> Result<(Vec<Prepared>, Vec<Skipped>)> {
    check_cover_size(opened, choice, how, view)?;
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
            let remedy = match why {
                Unsuited::NotBaked(_) => "choose another --method, or a scene that has cells",
                Unsuited::NotConvex(_) => "choose another --method, or split the scene into convex rooms",
                Unsuited::TerrainUnusable(_) => "choose another --method, or a scene that is terrain",
                _ => "raise --memory, or choose a smaller --size or another --method",
            };
            anyhow!("{}: {why}; {remedy}", opened.file)
        })?;
        return Ok((vec![built], Vec::new()));
    }
    let (mut prepared, mut skipped) = (Vec::new(), Vec::new());
    for method in Method::ALL {
        if let Err(why) = stays_visible(opened, Some(method)) {
            skipped.push(Skipped {
                method: method.name(),
                why: why.to_string(),
            });
            progress.step();
            continue;
        }
        match build(Choice::One(method)) {
            Ok(built) => prepared.push(built),
            Err(why) => skipped.push(Skipped {
                method: method.name(),
                why: why.to_string(),
            }),
        }
    }
    Ok((prepared, skipped))
}

/// The names of sectors that are terrain too large to be meshes.
pub(crate) fn in_files(scene: &Scene) -> impl Iterator<Item = &str> {
    let own = scene.sectors().filter(|&id| scene.geometry(id).is_none());
    own.map(|id| scene.sector_name(id))
}

/// Refuses to see terrain that stays in its file by any method but the one that can, or to choose one for it.
pub(crate) fn stays_visible(opened: &Opened, method: Option<Method>) -> Result<()> {
    let seen_by = Method::FloatingHorizon;
    if method != Some(seen_by) && in_files(&opened.scene).next().is_some() {
        bail!(
            "{}: terrain that does not fit in --memory can only be seen by {seen_by}; choose that --method, or raise --memory",
            opened.file
        );
    }
    Ok(())
}

/// Each sector by the method that suits it.
fn chosen(opened: &Opened, aim: ChoiceGoal, how: &HowArgs, view: Option<&View>) -> Result<Prepared> {
    let scene = &opened.scene;
    let size = view.map_or([1280, 720], |view| view.size);
    let terms = choose::terms(aim, !how.conservative, how.limits.memory());
    let choices = choose::choose(scene, size, &terms);
    let mut with_choices = scene.clone();
    let start = Instant::now();
    choose::take_over(&mut with_choices, &choices)?;
    let built = Built {
        scene: with_choices,
        ms: start.elapsed().as_secs_f64() * 1e3,
        choices: choices
            .iter()
            .map(|choice| ChoiceReport::new(scene, choice))
            .collect(),
    };
    finish(opened, "auto", built, how, view).map_err(|why| anyhow!("{}: {why}", opened.file))
}

/// A cover is no larger than the screen, and asked for where some method can do with one of another size.
fn check_cover_size(opened: &Opened, choice: Choice, how: &HowArgs, view: Option<&View>) -> Result<()> {
    let (Some([width, height]), Some(view)) = (how.cover_size, view) else {
        return Ok(());
    };
    let screen = view.size;
    ensure!(
        width <= screen[0] && height <= screen[1],
        "--cover-size {width}x{height} is larger than the screen; choose one of {}x{} at most, or a larger --size",
        screen[0],
        screen[1]
    );
    let methods = match choice {
        Choice::One(method) => vec![method],
        Choice::Own => methods_of(&opened.scene),
        Choice::All | Choice::Auto => return Ok(()),
    };
    if methods.iter().any(|method| method.takes_cover_size()) {
        return Ok(());
    }
    let able = Method::ALL.iter().filter(|method| method.takes_cover_size());
    let able: Vec<&str> = able.map(|method| method.name()).collect();
    bail!(
        "{}: --cover-size has no effect on {}; choose one of --method {}, or leave it out",
        opened.file,
        methods[0],
        able.join(", ")
    )
}

fn build(opened: &Opened, choice: Choice, how: &HowArgs, view: Option<&View>) -> Result<Prepared, Unsuited> {
    let limit = how.limits.memory();
    let scene = &opened.scene;
    let start = Instant::now();
    let (name, scene) = match choice {
        Choice::One(method) => (method.name(), scene.with_method(method, limit)?),
        Choice::Own | Choice::All | Choice::Auto => {
            // It is built already; done again to be timed, and to be held against the limit.
            for (geometry, method) in geometries(scene) {
                method.build(Arc::clone(geometry), limit)?;
            }
            ("own", scene.clone())
        }
    };
    let built = Built {
        scene,
        ms: start.elapsed().as_secs_f64() * 1e3,
        choices: Vec::new(),
    };
    finish(opened, name, built, how, view)
}

/// A scene by the methods that were asked for.
struct Built {
    scene: Scene,
    ms: f64,
    choices: Vec<ChoiceReport>,
}

fn finish(
    opened: &Opened,
    name: &'static str,
    built: Built,
    how: &HowArgs,
    view: Option<&View>,
) -> Result<Prepared, Unsuited> {
    let limit = how.limits.memory();
    let Built { scene, ms, choices } = built;
    let methods = methods_of(&scene);
    if let Some(view) = view {
        methods
            .iter()
            .try_for_each(|method| method.check_screen(view, how.cover_size, limit))?;
    }
    // As many cells as the screen has samples are those samples.
    let cover_size = how
        .cover_size
        .filter(|&cells| view.is_none_or(|view| view.size != cells));
    Ok(Prepared {
        method: name,
        contract: scene
            .sectors()
            .map(|id| match scene.method(id) {
                Some(method) if cover_size.is_some() => method.contract_in_cells(),
                _ => scene.sector(id).contract(),
            })
            .reduce(Contract::combined_with)
            .unwrap_or(Contract::Exact),
        scene: if how.portals.flat {
            scene.without_portals()
        } else {
            scene
        },
        build_ms: ms,
        stage: Arc::clone(&opened.stage),
        coherence: !how.no_coherence,
        occluders: how.occluders,
        cover_size,
        choices,
    })
}

/// The same scene, by a method that builds next to nothing, to be drawn by it.
pub(crate) fn drawn_by(prepared: &Prepared, method: Method) -> Result<Prepared, Unsuited> {
    Ok(Prepared {
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

/// The methods that a scene's sectors are seen by, each once.
fn methods_of(scene: &Scene) -> Vec<Method> {
    let mut methods = Vec::new();
    for (_, method) in geometries(scene) {
        if !methods.contains(&method) {
            methods.push(method);
        }
    }
    methods
}
