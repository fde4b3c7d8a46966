//! Opens scenes: files, or built-in scenes by name. Configures threads and SIMD.

use crate::args::{BakeArgs, HowArgs, LimitArgs, PortalArgs};
use crate::out;
use crate::progress::Progress;
use crate::run_files::RunFiles;
use crate::upright::Upright;
use crate::values::{Choice, among, nearest};
use anyhow::{Context, Result, anyhow, bail, ensure};
use enfilade::{Camera, Method, Scene, SceneError, Unsuited};
use enfilade_draw::Stage;
use enfilade_import::{
    BakedSections, BrokenRule, FileScene, Import, ImportError, MapSummary, NonOccluders, ReadOptions, Room,
    SourceNodes,
};
use std::ffi::OsStr;
use std::fs::File;
use std::io::Read;
use std::path::{Path, PathBuf};
use std::sync::{Arc, OnceLock};
use std::time::Instant;

/// A scene with its cameras, source and warnings.
pub(crate) struct OpenedScene {
    /// The name the user gave: a path or `@NAME`, with anything that is not UTF-8 replaced.
    pub(crate) file: String,
    /// The file format, in words.
    pub(crate) format: &'static str,
    pub(crate) scene: Scene,
    pub(crate) cameras: Vec<Camera>,
    /// For each camera the height of its view volume, if it is orthographic.
    pub(crate) orthographic_heights: Vec<Option<f32>>,
    /// The glTF nodes the items come from, by sector; empty for a built-in scene.
    pub(crate) nodes: Vec<SourceNodes>,
    /// Why items and materials hide nothing, by sector; empty for a built-in scene.
    pub(crate) non_occluders: Vec<NonOccluders>,
    /// The scenes of the file, of which one is open.
    pub(crate) scenes: Vec<FileScene>,
    /// Summary of a compiled map; `None` for other files.
    pub(crate) map: Option<MapSummary>,
    /// Which way is up, and how long a unit is.
    pub(crate) upright: Upright,
    /// What a baked scene consists of; `None` for other files.
    pub(crate) sections: Option<BakedSections>,
    /// Warnings of the reader, one line each; already printed.
    pub(crate) warnings: Vec<String>,
    /// The other files that the scene consists of.
    pub(crate) files: Vec<PathBuf>,
    pub(crate) load_ms: f64,
    /// Data that all pictures of the scene share; set when the first is drawn.
    pub(crate) stage: Arc<OnceLock<Stage>>,
}

/// The purpose a scene is opened for.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Purpose {
    /// Shaded pictures, which need the textures.
    Pictures,
    /// Visibility only, without textures.
    Visibility,
}

/// Opens a scene and prints its warnings.
///
/// With [`Choice::Own`] rooms of a file that names no method get hierarchical-z. With `portals.flat` a file is read as
/// one room; a built-in or baked scene keeps its portals, and the caller must not follow them. Adds the files that belong to the
/// scene to the inputs in `files`.
pub(crate) fn open(
    scene: &OsStr,
    wanted: Purpose,
    choice: Choice,
    portals: &PortalArgs,
    limits: &LimitArgs,
    files: &mut RunFiles,
) -> Result<OpenedScene> {
    let name = &*scene.to_string_lossy();
    let progress = Progress::spinner(&format!("loading {name}"));
    let start = Instant::now();
    let mut opened = match name.strip_prefix('@') {
        Some(built_in) => has_no_scenes(name, portals.file.scene_of_file.as_deref())
            .and_then(|()| open_built_in(name, built_in)),
        None => open_file(Path::new(scene), wanted, choice, portals, limits, files),
    }?;
    opened.load_ms = start.elapsed().as_secs_f64() * 1e3;
    drop(progress);
    opened
        .warnings
        .iter()
        .for_each(|warning| out::warn(format_args!("{name}: {warning}")));
    Ok(opened)
}

/// Refuses a choice among the scenes of a built-in one.
fn has_no_scenes(name: &str, choice: Option<&str>) -> Result<()> {
    ensure!(
        choice.is_none(),
        "{name}: a built-in scene has no scenes to choose from; leave out --scene"
    );
    Ok(())
}

fn open_built_in(file: &str, name: &str) -> Result<OpenedScene> {
    let built = enfilade_scenes::built_in(name).ok_or_else(|| {
        let names: Vec<String> = enfilade_scenes::NAMES
            .iter()
            .map(|name| format!("@{name}"))
            .collect();
        anyhow!(
            "no built-in scene `{file}`; {}",
            among(file, names.iter().map(String::as_str))
        )
    })?;
    Ok(OpenedScene {
        file: file.to_owned(),
        format: "built-in",
        scene: built.scene,
        orthographic_heights: vec![None; built.cameras.len()],
        cameras: built.cameras,
        nodes: Vec::new(),
        non_occluders: Vec::new(),
        scenes: Vec::new(),
        map: None,
        upright: Upright::default(),
        sections: None,
        warnings: Vec::new(),
        files: Vec::new(),
        load_ms: 0.0,
        stage: Arc::default(),
    })
}

fn open_file(
    path: &Path,
    wanted: Purpose,
    choice: Choice,
    portals: &PortalArgs,
    limits: &LimitArgs,
    files: &mut RunFiles,
) -> Result<OpenedScene> {
    let file = &*path.to_string_lossy();
    let sections = BakedSections::read(path).ok().flatten();
    let mut options = ReadOptions {
        flat: portals.flat && sections.is_none(),
        skip_bad_portals: portals.bad.skip,
        textures: wanted == Purpose::Pictures,
        ..portals.file.options()
    };
    options.limit_bytes = limits.memory();
    if !path.exists() && enfilade_scenes::NAMES.contains(&file) {
        bail!("{file}: no such file; the built-in scene is called @{file}");
    }
    let mut import = enfilade_import::read(path, &options).map_err(with_ways_on)?;
    import
        .files
        .iter()
        .try_for_each(|side_file| files.reads(side_file))?;
    if choice != Choice::Own {
        import.rooms.iter_mut().for_each(|room| room.method = None);
    }
    let mut large = import.rooms.iter().filter(|room| room.large.is_some());
    let pinned = large.find_map(|room| room.method.filter(|&method| method != Method::FloatingHorizon));
    if let Some(method) = pinned {
        bail!(
            "{file}: it names method {method}, but terrain that does not fit in --memory needs {}; use that --method, or \
             raise --memory",
            Method::FloatingHorizon
        );
    }
    let method = match choice {
        Choice::Own | Choice::Auto => Method::HierarchicalZ,
        // The requested methods are built and timed later, so start with the cheapest to build.
        Choice::One(_) | Choice::All => Method::ZBuffer,
    };
    let scene = import.scene(method, limits.memory()).map_err(|why| {
        // The message itself names a method to use instead; this one comes from the file.
        let remedy = match &why {
            SceneError::Unsuited { why, .. } if !matches!(why.reason, Unsuited::TooLarge { .. }) => {
                "--method overrides the method in the file"
            }
            _ => "raise --memory, or use another --method",
        };
        anyhow!("{file}: {why}; {remedy}")
    })?;
    let upright = if import.tells_up() {
        Upright::default()
    } else {
        Upright::of_floors(&scene)
    };
    let (nodes, non_occluders) = import
        .rooms
        .into_iter()
        .map(|room| (room.nodes, room.non_occluders))
        .unzip();
    Ok(OpenedScene {
        file: file.to_owned(),
        format: format(path),
        upright,
        scene,
        cameras: import.cameras,
        orthographic_heights: import.orthographic_heights,
        nodes,
        non_occluders,
        scenes: import.scenes,
        map: import.map,
        sections,
        warnings: import.warnings.iter().map(ToString::to_string).collect(),
        files: import.files,
        load_ms: 0.0,
        stage: Arc::default(),
    })
}

/// Reads everything in a file that is to be baked, textures included; or a built-in scene as if it were read from a file. Adds the files that
/// belong to the scene to the inputs in `files`.
pub(crate) fn import_of(scene: &OsStr, args: &BakeArgs, files: &mut RunFiles) -> Result<Import> {
    let name = &*scene.to_string_lossy();
    if let Some(built_in) = name.strip_prefix('@') {
        has_no_scenes(name, args.read.scene_of_file.as_deref())?;
        let OpenedScene { scene, cameras, .. } = open_built_in(name, built_in)?;
        ensure!(
            !args.flat,
            "{name}: a built-in scene cannot be read as flat; leave --flat out"
        );
        return as_import(&scene, cameras).with_context(|| name.to_owned());
    }
    let mut options = ReadOptions {
        flat: args.flat,
        skip_bad_portals: args.bad.skip,
        ..args.read.options()
    };
    options.limit_bytes = args.limits.memory();
    let import = enfilade_import::read(Path::new(scene), &options).map_err(with_ways_on)?;
    import
        .files
        .iter()
        .try_for_each(|side_file| files.reads(side_file))?;
    Ok(import)
}

fn as_import(scene: &Scene, cameras: Vec<Camera>) -> Result<Import> {
    let room = |id| {
        let geometry = scene
            .geometry(id)
            .context("a sector of its own kind cannot be baked")?;
        Ok(Room {
            method: scene.method(id),
            open_above: scene.is_open_above(id),
            ..Room::new(scene.sector_name(id), Arc::clone(geometry))
        })
    };
    Ok(Import {
        portals: scene.portals().to_vec(),
        orthographic_heights: vec![None; cameras.len()],
        cameras,
        lights: scene.lights().to_vec(),
        ..Import::of_rooms(scene.sectors().map(room).collect::<Result<_>>()?)
    })
}

/// Adds to an authoring error the options that open the file in spite of it.
fn with_ways_on(why: ImportError) -> anyhow::Error {
    let errors = match &why.rule {
        BrokenRule::Authoring(errors) => errors,
        BrokenRule::NoSuchScene { scene, there } => {
            let names = there.iter().map(String::as_str).filter(|name| !name.is_empty());
            return match nearest(scene, names) {
                Some(name) => anyhow!("{why}\ndid you mean {name}?"),
                None => why.into(),
            };
        }
        _ => return why.into(),
    };
    let mut ways = Vec::new();
    if errors.can_be_skipped() {
        ways.push("--skip-bad-portals to turn these portals into plain holes");
    }
    if errors.flat_ignores_them() {
        ways.push(
            "--flat (of look, draw, compare, bench and info) to read everything as one room without portals",
        );
    }
    if ways.is_empty() {
        return why.into();
    }
    anyhow!("{why}\nto open it unchanged, use {}", ways.join(", or "))
}

/// Returns the format of a readable file, in words, from its first bytes.
fn format(path: &Path) -> &'static str {
    let mut first = Vec::new();
    let opened = File::open(path);
    // A read error is ignored: the file was read successfully before.
    let _ = opened.and_then(|file| file.take(1 << 12).read_to_end(&mut first));
    let text = first.strip_prefix(b"\xEF\xBB\xBF").unwrap_or(&first);
    match text.trim_ascii_start() {
        _ if first.starts_with(&[29, 0, 0, 0]) => "BSP29, a map of Quake",
        [b'B', b'S', b'P', b'2', ..] => "BSP2, a map of Quake",
        [b'I', b'B', b'S', b'P', ..] => "IBSP46, a map of Quake 3",
        [b'g', b'l', b'T', b'F', ..] => "glTF 2.0, binary",
        [b'E', b'N', b'F', b'I', b'L', b'A', b'D', b'E', ..] => "baked scene",
        [b'{', rest @ ..] if rest.windows(13).any(|key| key == b"\"cellMetresX\"") => {
            "heightmap with a description"
        }
        [b'{', ..] => "glTF 2.0",
        [b'b', b'3', b'd', b'm', ..] => "b3dm, a tile of 3D Tiles",
        [b'i', b'3', b'd', b'm', ..] => "i3dm, a tile of 3D Tiles",
        _ => "OBJ",
    }
}

/// Sets the threads and SIMD level of the whole program. Call it before anything is built.
pub(crate) fn configure(how: &HowArgs) -> Result<()> {
    configure_with(&how.limits, how.simd.as_deref())
}

/// As [`configure`], for a verb that takes no other options of [`HowArgs`].
pub(crate) fn configure_with(limits: &LimitArgs, simd: Option<&str>) -> Result<()> {
    allow_threads(limits)?;
    if let Some(level) = simd {
        enfilade::use_simd_level(level)?;
    }
    Ok(())
}

/// Sets the number of threads of the whole program, and returns it.
pub(crate) fn allow_threads(limits: &LimitArgs) -> Result<usize> {
    if let Some(threads) = limits.threads {
        rayon::ThreadPoolBuilder::new()
            .num_threads(threads.into())
            .build_global()
            .with_context(|| format!("cannot start {threads} threads; use fewer with --threads"))?;
    }
    Ok(rayon::current_num_threads())
}

/// Returns the names of terrain sectors that are too large for meshes and are read from their file on demand.
pub(crate) fn in_files(scene: &Scene) -> impl Iterator<Item = &str> {
    let own = scene.sectors().filter(|&id| scene.geometry(id).is_none());
    own.map(|id| scene.sector_name(id))
}

/// Fails if the scene has terrain that is read from its file on demand and `method` cannot look at it. `None` is
/// any method that `choose` would try.
pub(crate) fn stays_visible(opened: &OpenedScene, method: Option<Method>) -> Result<()> {
    let required = Method::FloatingHorizon;
    if method != Some(required) && in_files(&opened.scene).next().is_some() {
        bail!(
            "{}: terrain that does not fit in --memory needs {required}; use that --method, or raise --memory",
            opened.file
        );
    }
    Ok(())
}
