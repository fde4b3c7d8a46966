//! Compares every method with the reference on many views of many scenes.
//!
//! The reference is evaluated once per view for all methods. Each viewer goes from view to view, so temporal coherence is
//! tested too. A failure is printed with the command that reproduces it.
#![allow(clippy::print_stdout, reason = "a command prints what it finds")]

use anyhow::{Context, Result, bail, ensure};
use enfilade::laws::{LayerPicture, OwnerPicture, Reference, Verdict};
use enfilade::{Camera, Contract, Method, Scene, SurveyView, Tightness, View, Viewer, survey, survey_hard};
use enfilade_import::{ReadOptions, read};
use enfilade_scenes::{Random, engine_view, oblique_view, parallel_view, random_edits, random_graph_edits};
use std::path::{Path, PathBuf};
use std::time::Instant;

#[derive(clap::Args)]
pub(crate) struct Args {
    /// Scenes: files, folders of .glb files, or @NAME [default: built-in scenes and those in ENFILADE_SCENES]
    scenes: Vec<String>,
    /// Views of each scene
    #[arg(long, default_value_t = 1000)]
    views: usize,
    /// Use views that are hard to decide: in doorways, at corners and edges, in planes of faces
    #[arg(long)]
    hard: bool,
    /// Look through random matrices of engines: off-centre, jittered, reversed or infinite depth, left-handed
    #[arg(long, conflicts_with_all = ["parallel", "oblique"])]
    matrices: bool,
    /// Look through random parallel projections
    #[arg(long, conflicts_with = "oblique")]
    parallel: bool,
    /// Look through random oblique near planes
    #[arg(long)]
    oblique: bool,
    /// Viewport width and height, in pixels
    #[arg(long, num_args = 2, default_values_t = [320, 180])]
    size: Vec<u32>,
    /// Number of views in which strict methods are tested at random sample positions
    #[arg(long, default_value_t = 64)]
    strict_views: usize,
    /// Viewport width and height for these, in pixels
    #[arg(long, num_args = 2, default_values_t = [640, 360])]
    strict_size: Vec<u32>,
    /// Sample positions per pixel for these
    #[arg(long, default_value_t = 16)]
    places: u32,
    /// Width and height of covers; tests only the methods that support a cover size
    #[arg(long, num_args = 2)]
    cover_size: Option<Vec<u32>>,
    /// What `masked` tests at the end: boxes, faces, or faces at exact depths (resolved)
    #[arg(long, value_enum, default_value = "boxes")]
    tightness: TightnessArg,
    /// How far `masked` grows the boxes that it tests, in pixels on each side
    #[arg(long, default_value_t = 0.0)]
    growth: f32,
    /// Number of random edits after every eighth view: items are added, removed, moved and changed
    #[arg(long, default_value_t = 0)]
    edits: usize,
    /// Number of random changes after every eighth view: sectors, openings and portals are added and removed, and items
    /// move between sectors
    #[arg(long, default_value_t = 0)]
    graph_edits: usize,
    /// Compare glass with the reference too, layer by layer
    #[arg(long)]
    glass: bool,
    /// Methods by name [default: all]
    #[arg(long)]
    method: Vec<String>,
}

/// See [`Tightness`].
#[derive(Clone, Copy, clap::ValueEnum)]
enum TightnessArg {
    Boxes,
    Faces,
    Resolved,
}

const VIEWS_BETWEEN_EDITS: usize = 8;

/// A method on a scene, and the failures found so far.
struct Candidate {
    method: Method,
    contract: Contract,
    scene: Scene,
    viewer: Viewer,
    missed: usize,
    different: u64,
    /// Samples with other layers of glass, or in another order.
    glass: usize,
    extra: usize,
    items: usize,
}

pub(crate) fn run(args: &Args) -> Result<()> {
    let mut methods = methods(&args.method)?;
    if args.cover_size.is_some() {
        methods.retain(|method| method.takes_cover_size());
    }
    let mut wrong = 0;
    for name in scenes(&args.scenes)? {
        wrong += verify(&name, &methods, args).with_context(|| name.clone())?;
    }
    ensure!(wrong == 0, "{wrong} views break a contract");
    println!("\nno false cull, no wrong pixel");
    Ok(())
}

fn methods(names: &[String]) -> Result<Vec<Method>> {
    if names.is_empty() {
        return Ok(Method::ALL.to_vec());
    }
    let known = |name: &String| Method::by_name(name).with_context(|| format!("there is no method `{name}`"));
    names.iter().map(known).collect()
}

/// Returns the named scenes, or all known ones.
pub(crate) fn scenes(named: &[String]) -> Result<Vec<String>> {
    let mut all = Vec::new();
    if named.is_empty() {
        all.extend(enfilade_scenes::NAMES.iter().map(|name| format!("@{name}")));
        match std::env::var_os("ENFILADE_SCENES") {
            Some(folder) => all.extend(files_in(Path::new(&folder))?),
            None => println!("ENFILADE_SCENES is not set to a folder of .glb files: built-in scenes only"),
        }
    }
    for name in named {
        if Path::new(name).is_dir() {
            all.extend(files_in(Path::new(name))?);
        } else {
            all.push(name.clone());
        }
    }
    Ok(all)
}

fn files_in(folder: &Path) -> Result<Vec<String>> {
    let entries = std::fs::read_dir(folder).with_context(|| folder.display().to_string())?;
    let mut files: Vec<PathBuf> = entries
        .map(|entry| entry.map(|entry| entry.path()))
        .collect::<Result<_, _>>()?;
    files.retain(|path| path.extension().is_some_and(|extension| extension == "glb"));
    files.sort();
    Ok(files.iter().map(|path| path.display().to_string()).collect())
}

pub(crate) fn open(name: &str) -> Result<Scene> {
    if let Some(built_in) = name.strip_prefix('@') {
        let built = enfilade_scenes::built_in(built_in);
        return Ok(built.context("there is no such built-in scene")?.scene);
    }
    let options = ReadOptions {
        textures: false,
        ..ReadOptions::default()
    };
    let import = read(Path::new(name), &options)?;
    Ok(import.scene(Method::ZBuffer, Method::DEFAULT_LIMIT)?)
}

fn viewer(args: &Args) -> Viewer {
    let mut viewer = Viewer::new();
    viewer.options.cover_size = args.cover_size.as_ref().map(|size| [size[0], size[1]]);
    viewer.options.growth_px = args.growth;
    viewer.options.tightness = match args.tightness {
        TightnessArg::Boxes => Tightness::Boxes,
        TightnessArg::Faces => Tightness::Faces,
        TightnessArg::Resolved => Tightness::Resolved,
    };
    viewer
}

/// Returns the contract of a method for the requested cover size and growth.
fn contract(method: Method, args: &Args) -> Contract {
    if args.cover_size.is_some() || args.growth > 0.0 {
        Contract::Conservative
    } else {
        method.contract()
    }
}

/// Returns the view number `number` from a position.
fn view_from(place: &SurveyView, number: usize, size: [u32; 2], args: &Args) -> View {
    let camera = Camera {
        // Items that move may enlarge the bounds of sectors.
        sector: Some(place.sector),
        ..Camera::new(place.eye, place.toward)
    };
    let random = &mut Random::new(number as u64);
    if args.matrices {
        engine_view(&camera, size, random)
    } else if args.parallel {
        parallel_view(&camera, size, random)
    } else if args.oblique {
        oblique_view(&camera, size, random)
    } else {
        camera.view(size).expect("a view of the survey")
    }
}

/// Returns the number of failed views, summed over all methods.
fn verify(name: &str, methods: &[Method], args: &Args) -> Result<usize> {
    let start = Instant::now();
    let mut scene = open(name)?;
    let count = args.views.max(args.strict_views);
    let places = if args.hard {
        survey_hard(&scene, count)
    } else {
        survey(&scene, count).views
    };
    if places.is_empty() {
        println!("\n{name}: the survey finds no camera position");
        return Ok(0);
    }
    let mut reference = Reference::new(&scene);
    let mut candidates = Vec::new();
    for &method in methods {
        if args.edits + args.graph_edits > 0 && method.requires().is_some() {
            println!("{name}: {method} needs static walls: skipped with edits");
            continue;
        }
        match scene.with_method(method, Method::DEFAULT_LIMIT) {
            Ok(scene) => candidates.push(Candidate {
                method,
                scene,
                contract: contract(method, args),
                viewer: viewer(args),
                missed: 0,
                different: 0,
                glass: 0,
                extra: 0,
                items: 0,
            }),
            Err(why) => println!("{name}: {why}: skipped"),
        }
    }
    let [size, strict_size] = [&args.size, &args.strict_size].map(|size| [size[0], size[1]]);
    let limits = Viewer::new().options.limits;
    let at_first: Vec<usize> = (scene.sectors())
        .map(|id| scene.geometry(id).map_or(0, |geometry| geometry.item_count()))
        .collect();
    let (mut wrong, mut visible, mut glass) = (0, 0, 0);
    let (mut edited, mut changes) = (0, 0);
    for (number, place) in places[..args.views.min(places.len())].iter().enumerate() {
        if args.edits + args.graph_edits > 0 && number % VIEWS_BETWEEN_EDITS == VIEWS_BETWEEN_EDITS - 1 {
            let scenes = candidates.iter_mut().map(|candidate| &mut candidate.scene);
            for scene in scenes.chain([&mut scene]) {
                let mut random = Random::new(number as u64);
                edited += random_edits(scene, args.edits, &at_first, &mut random)?.items;
                let sectors = at_first.len() + args.graph_edits;
                changes += random_graph_edits(scene, args.graph_edits, sectors, &mut random)?;
            }
            reference = Reference::new(&scene);
        }
        let view = view_from(place, number, size, args);
        let truth = reference.see(&scene, &view, &limits);
        let layers = args.glass.then(|| reference.layers(&scene, &view, &limits));
        visible += truth.visible().len();
        for candidate in &mut candidates {
            let mut picture = OwnerPicture::new(size);
            let set = candidate.viewer.draw(&candidate.scene, &view, &mut picture);
            let verdict = truth.check(set, Some(&picture));
            let mut is_wrong = candidate.take(&verdict, name, number, &view);
            if let Some(layers) = &layers {
                let mut picture = LayerPicture::new(size);
                candidate.viewer.draw(&candidate.scene, &view, &mut picture);
                let verdict = layers.check(&picture);
                glass += verdict.compared;
                candidate.glass += verdict.different.len();
                let different = candidate.contract.never_misses() && !verdict.different.is_empty();
                is_wrong |= different;
            }
            wrong += usize::from(is_wrong);
        }
    }
    for (number, place) in places[..args.strict_views.min(places.len())].iter().enumerate() {
        let strict = |candidate: &&mut Candidate| candidate.contract == Contract::Strict;
        if !candidates.iter_mut().any(|candidate| strict(&candidate)) {
            break;
        }
        let view = view_from(place, number, strict_size, args);
        let truth = reference.see_anywhere(&scene, &view, &limits, args.places, number as u64);
        for candidate in candidates.iter_mut().filter(strict) {
            let verdict = truth.check(candidate.viewer.look(&candidate.scene, &view), None);
            wrong += usize::from(candidate.take(&verdict, name, number, &view));
        }
    }
    println!(
        "\n{name}: {} views, {visible} items certainly visible, {:.0} s",
        args.views.min(places.len()),
        start.elapsed().as_secs_f64()
    );
    if args.edits + args.graph_edits > 0 {
        println!(
            "  {edited} items edited and {changes} changes of sectors, openings and portals, over all methods"
        );
    }
    if args.glass {
        println!("  {glass} samples of glass compared, over all methods");
    }
    for candidate in &candidates {
        println!(
            "  {:16}{:>14}{:8} missed{:8} pixels different{:8} wrong glass samples{:8} extra of {} items",
            candidate.method.name(),
            candidate.contract.to_string(),
            candidate.missed,
            candidate.different,
            candidate.glass,
            candidate.extra,
            candidate.items,
        );
    }
    if visible == 0 {
        bail!("nothing is visible in any view, so nothing was tested");
    }
    Ok(wrong)
}

impl Candidate {
    /// Adds a verdict; returns `true` if it breaks the contract.
    fn take(&mut self, verdict: &Verdict, name: &str, number: usize, view: &View) -> bool {
        self.missed += verdict.missed.len();
        self.different += verdict.pixels_different;
        self.extra += verdict.extra;
        self.items += self.viewer.visible().items().len();
        let contract = self.contract;
        let broken = contract.never_misses() && (!verdict.missed.is_empty() || verdict.pixels_different > 0)
            || contract == Contract::Exact && verdict.extra > 0;
        if broken {
            let [eye, toward] = [view.eye(), view.toward()].map(|[x, y, z]| format!("{x},{y},{z}"));
            println!(
                "{name}, view {number}: {} missed {:?}, {} wrong pixels, {} extra:\n  enfilade look {name} \
                 --method {} --check --size {}x{} --eye={eye} --toward={toward}",
                self.method,
                verdict.missed,
                verdict.pixels_different,
                verdict.extra,
                self.method,
                view.size()[0],
                view.size()[1],
            );
        }
        broken
    }
}
