//! The methods that are asked for, each built over the scene and within its memory.

use crate::args::HowArgs;
use crate::open::Opened;
use crate::progress::Progress;
use crate::report::Skipped;
use crate::values::Choice;
use anyhow::{Result, anyhow};
use enfilade::{Contract, Method, Scene, TooLarge, View, Viewer};
use std::sync::Arc;
use std::time::Instant;

/// A scene ready to be looked at by a method.
pub(crate) struct Prepared {
    /// The method's name, or `own`.
    pub(crate) method: &'static str,
    /// The weakest of its fragments'.
    pub(crate) contract: Contract,
    pub(crate) scene: Scene,
    pub(crate) build_ms: f64,
    coherence: bool,
    occluders: Option<u32>,
}

impl Prepared {
    /// A viewer that remembers nothing yet.
    pub(crate) fn viewer(&self) -> Viewer {
        let mut viewer = Viewer::new();
        viewer.set_coherence(self.coherence);
        viewer.set_occluders(self.occluders);
        viewer
    }

    /// The method in words for people: `own` says which one, where all fragments agree.
    pub(crate) fn spoken_method(&self) -> &'static str {
        match self.methods().as_slice() {
            [one] => one.name(),
            _ => "each fragment's own method",
        }
    }

    /// The methods that its fragments are seen by, each once.
    pub(crate) fn methods(&self) -> Vec<Method> {
        methods_of(&self.scene)
    }

    /// Memory of the scene, of what was built over it, and of the buffers for a screen of this size, in bytes.
    pub(crate) fn bytes(&self, size: [u32; 2]) -> u64 {
        self.scene.bytes()
            + self
                .methods()
                .iter()
                .map(|method| method.screen_bytes(size))
                .sum::<u64>()
    }
}

/// Builds what is asked for over a scene, for views that all have one size.
///
/// # Errors
/// A method that would need too much memory, unless all were asked for: then it is skipped.
pub(crate) fn prepare(
    opened: &Opened,
    choice: Choice,
    how: &HowArgs,
    view: Option<&View>,
) -> Result<(Vec<Prepared>, Vec<Skipped>)> {
    let progress = Progress::steps(
        "building",
        if choice == Choice::All {
            Method::ALL.len()
        } else {
            1
        },
    );
    let build = |choice| {
        let built = build(&opened.scene, choice, how, view);
        progress.step();
        built
    };
    if choice != Choice::All {
        let remedy = "raise --memory, or choose a smaller --size or another --method";
        let built = build(choice).map_err(|why| anyhow!("{}: {why}; {remedy}", opened.file))?;
        return Ok((vec![built], Vec::new()));
    }
    let (mut prepared, mut skipped) = (Vec::new(), Vec::new());
    for method in Method::ALL {
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

fn build(scene: &Scene, choice: Choice, how: &HowArgs, view: Option<&View>) -> Result<Prepared, TooLarge> {
    let limit = how.limits.memory.unwrap_or(Method::DEFAULT_LIMIT);
    let start = Instant::now();
    let built = match choice {
        Choice::One(method) => scene.with_method(method, limit)?,
        Choice::Own | Choice::All => {
            // It is built already; done again to be timed, and to be held against the limit.
            for (content, method) in contents(scene) {
                method.build(Arc::clone(content), limit)?;
            }
            scene.clone()
        }
    };
    let build_ms = start.elapsed().as_secs_f64() * 1e3;
    let methods = methods_of(&built);
    if let Some(view) = view {
        methods
            .iter()
            .try_for_each(|method| method.check_screen(view, limit))?;
    }
    Ok(Prepared {
        method: if let Choice::One(method) = choice {
            method.name()
        } else {
            "own"
        },
        contract: methods
            .iter()
            .map(|method| method.contract())
            .min()
            .unwrap_or(Contract::Exact),
        scene: if how.flat { built.without_portals() } else { built },
        build_ms,
        coherence: !how.no_coherence,
        occluders: how.occluders,
    })
}

/// The same scene, by a method that builds next to nothing, to be drawn by it.
pub(crate) fn drawn_by(prepared: &Prepared, method: Method) -> Result<Prepared, TooLarge> {
    Ok(Prepared {
        method: method.name(),
        contract: method.contract(),
        scene: prepared.scene.with_method(method, u64::MAX)?,
        ..*prepared
    })
}

fn contents(scene: &Scene) -> impl Iterator<Item = (&Arc<enfilade::Content>, Method)> {
    scene
        .fragments()
        .filter_map(|id| Some((scene.content(id)?, scene.method(id)?)))
}

/// The methods that a scene's fragments are seen by, each once.
fn methods_of(scene: &Scene) -> Vec<Method> {
    let mut methods = Vec::new();
    for (_, method) in contents(scene) {
        if !methods.contains(&method) {
            methods.push(method);
        }
    }
    methods
}
