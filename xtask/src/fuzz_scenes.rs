//! Tests all methods on random scenes made of what breaks visibility code.
//!
//! Each scene depends on its seed alone: `--seed S` with a count of 1 reproduces one.
#![allow(clippy::print_stdout, reason = "a command prints what it finds")]

use anyhow::{Result, ensure};
use enfilade::laws::Contestants;
use enfilade::{Limits, Method, Scene, View};
use enfilade_scenes::{FuzzScene, fuzz_scene};
use std::ops::AddAssign;
use std::sync::atomic::{AtomicU64, Ordering};
use std::time::Instant;

#[derive(clap::Args)]
pub(crate) struct Args {
    /// Number of scenes
    #[arg(default_value_t = 1000)]
    count: u64,
    /// Seed of the first scene; the next has the next seed
    #[arg(long, default_value_t = 0)]
    seed: u64,
    /// Print every scene and view, not only those that fail
    #[arg(long)]
    verbose: bool,
}

/// Portals followed in a row: portals of random scenes form cycles.
const MAX_CROSSINGS: u16 = 4;

/// Counts of what was tested.
#[derive(Default)]
struct Tested {
    views: u64,
    /// Views with at least one certainly visible item.
    views_with_items: u64,
    items: u64,
    failures: u64,
}

impl AddAssign for Tested {
    fn add_assign(&mut self, other: Tested) {
        self.views += other.views;
        self.views_with_items += other.views_with_items;
        self.items += other.items;
        self.failures += other.failures;
    }
}

pub(crate) fn run(args: &Args) -> Result<()> {
    let start = Instant::now();
    let next = AtomicU64::new(0);
    let threads = std::thread::available_parallelism().map_or(1, usize::from);
    let mut tested = Tested::default();
    std::thread::scope(|scope| {
        let worker = || {
            // Scenes in parallel, each on one thread.
            let pool = rayon::ThreadPoolBuilder::new().num_threads(1).build()?;
            let mut tested = Tested::default();
            loop {
                let number = next.fetch_add(1, Ordering::Relaxed);
                if number >= args.count {
                    return anyhow::Ok(tested);
                }
                tested += pool.install(|| test(args.seed + number, args.verbose));
                if (number + 1).is_multiple_of(10_000) {
                    println!("{} scenes, {:.0} s", number + 1, start.elapsed().as_secs_f64());
                }
            }
        };
        let workers: Vec<_> = (0..threads).map(|_| scope.spawn(worker)).collect();
        for worker in workers {
            match worker.join() {
                Ok(part) => tested += part?,
                Err(panic) => std::panic::resume_unwind(panic),
            }
        }
        anyhow::Ok(())
    })?;
    println!(
        "{} scenes from seed {}, {} views ({} with visible items), {} visible items, {} failures, {:.0} s",
        args.count,
        args.seed,
        tested.views,
        tested.views_with_items,
        tested.items,
        tested.failures,
        start.elapsed().as_secs_f64(),
    );
    ensure!(
        tested.failures == 0,
        "{} results break a contract",
        tested.failures
    );
    ensure!(
        tested.items > 0,
        "nothing was visible in any view, so nothing was tested"
    );
    Ok(())
}

fn test(seed: u64, verbose: bool) -> Tested {
    let FuzzScene { scene, views } = fuzz_scene(seed);
    let mut limits = Limits::default();
    limits.max_crossings = MAX_CROSSINGS;
    let mut contestants = Contestants::new(&scene, limits, Method::DEFAULT_LIMIT);
    let mut tested = Tested::default();
    if verbose {
        describe(&scene);
    }
    for (number, view) in views.iter().enumerate() {
        let (visible, broken) = contestants.check(view);
        tested.views += 1;
        tested.views_with_items += u64::from(visible > 0);
        tested.items += visible as u64;
        tested.failures += broken.len() as u64;
        if verbose || !broken.is_empty() {
            print(seed, number, view, visible);
        }
        for broken in &broken {
            println!("  {broken}");
        }
    }
    tested
}

fn print(seed: u64, number: usize, view: &View, visible: usize) {
    println!("seed {seed}, view {number}, {visible} items certainly visible: {view:?}");
}

/// Lists the openings, portals and items of a scene.
fn describe(scene: &Scene) {
    for id in scene.sectors() {
        println!("{id:?}: {:?}", scene.bounds(id));
        let Some(geometry) = scene.geometry(id) else {
            continue;
        };
        for (number, opening) in geometry.openings().iter().enumerate() {
            println!("  opening {number}: {:?}", opening.outline.corners());
        }
        for (number, item) in geometry.items().iter().enumerate() {
            let mesh = &geometry.meshes()[item.mesh.0 as usize];
            let material = geometry.material(&mesh.clusters()[0]);
            let kind = (material.alpha, material.double_sided);
            println!(
                "  item {number}: {} faces, {kind:?}, {:?}",
                mesh.face_count(),
                item.bounds
            );
            let corner = |at: &u32| item.transform().point(mesh.positions()[*at as usize]);
            for face in 0..mesh.face_count().min(12) {
                let corners: Vec<_> = mesh.face(face).iter().map(corner).collect();
                println!("    face {face}: {corners:?}");
            }
        }
    }
    for (number, portal) in scene.portals().iter().enumerate() {
        println!(
            "portal {number}: {:?} {:?} -> {:?}, open {}, {:?}",
            portal.from,
            portal.opening,
            portal.to,
            portal.open,
            portal.there_from_here.columns()
        );
    }
}
