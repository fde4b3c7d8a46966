//! `bench --micro`: measures how many faces and boxes per second the masked depth buffer processes, relative to the
//! machine and to other cullers.
//!
//! All rows run in turn, round after round, and the median of each is reported, so that other load on the cores slows
//! all alike. The results of the timed work are then compared with a reference in f64, in the same run.

mod boxes;
mod ceilings;
mod faces;
mod items;
mod lens;
mod report;
mod rows;
mod screen;
mod shapes;
mod truth;
mod walk;

use crate::Outcome;
use crate::args::{BenchArgs, PortalArgs};
use crate::measure::median;
use crate::open::{Purpose, configure, open};
use crate::out;
use crate::progress::Progress;
use crate::report::Sink;
use crate::run_files::RunFiles;
use crate::values::Choice;
use anyhow::Result;
use ceilings::{Ceiling, Ceilings};
use enfilade::Method;
use report::MicroReport;
use screen::Screen;
use truth::ErrorCounts;

/// Screen size of all rows except those of scenes.
const SIZE: [u32; 2] = [1920, 1080];

/// Bytes of one sub-tile of the buffer: a mask of the open ones of its 32 samples, a mask of its working layer, and the
/// reversed depths of both layers.
const SUB_TILE_BYTES: u64 = 16;

/// Returns the names of all rows, those of scenes last.
pub(crate) fn names() -> impl Iterator<Item = &'static str> {
    rows::names().chain(walk::NAMES)
}

/// Work that is timed and then compared with the truth.
trait Workload {
    /// Returns the number of faces or boxes per run.
    fn count(&self) -> u64;

    /// Runs the work, and returns the seconds it took.
    fn run(&mut self, screen: &mut Screen) -> f64;

    /// Runs the work once more, counts its errors and the minimum of bytes it must touch.
    fn check(&mut self, screen: &mut Screen) -> Verification;
}

/// Result of [`Workload::check`].
struct Verification {
    errors: ErrorCounts,
    /// Minimum number of bytes of the buffer that must be touched, and the cache whose ceiling applies.
    min_bytes: u64,
    ceiling: Ceiling,
}

/// A row of the table.
struct Row {
    name: &'static str,
    /// Figure of the best other culler, in millions per second.
    peer: f64,
    work: Box<dyn Workload>,
    /// Time of each round.
    seconds: Vec<f64>,
    /// Number of views per run, if the row is reported in milliseconds per view.
    views: Option<u64>,
}

impl Row {
    fn new(name: &'static str, peer: f64, work: Box<dyn Workload>) -> Row {
        Row {
            name,
            peer,
            work,
            seconds: Vec::new(),
            views: None,
        }
    }

    /// Returns the median time of all rounds.
    fn median_seconds(&self) -> f64 {
        median(&self.seconds)
    }
}

/// Runs `bench --micro`.
pub(super) fn run(args: &BenchArgs) -> Result<Outcome> {
    let scene = args.scene.as_deref();
    let mut files = scene.map_or_else(|| Ok(RunFiles::default()), |scene| RunFiles::of(scene, None))?;
    let sink = Sink::new(&args.json, &mut files)?;
    configure(&args.how)?;
    let generating = Progress::spinner("generating faces");
    let mut screen = Screen::new(SIZE)?;
    let wanted = |name: &str| args.rows.is_empty() || args.rows.iter().any(|row| row == name);
    let mut rows = rows::rows(&screen, wanted);
    drop(generating);
    if let Some(scene) = scene {
        // Portals are ignored, so the whole scene is in one space.
        let opened = open(
            scene,
            Purpose::Visibility,
            Choice::One(Method::ZBuffer),
            PortalArgs {
                flat: true,
                ..PortalArgs::default()
            },
            &args.how.limits,
            &mut files,
        )?;
        rows.extend(walk::rows(&opened.scene, wanted)?);
    }
    let mut ceilings = Ceilings::new();
    let rounds = args.rounds as usize;
    let progress = Progress::steps("measuring", (1 + rounds) * rows.len());
    // The first round warms up.
    for round in 0..=rounds {
        ceilings.measure();
        if round == 0 {
            ceilings.clear();
        }
        for row in &mut rows {
            let seconds = row.work.run(&mut screen);
            if round > 0 {
                row.seconds.push(seconds);
            }
            progress.step();
        }
    }
    drop(progress);
    let progress = Progress::steps("checking", rows.len());
    let found: Vec<Verification> = rows
        .iter_mut()
        .map(|row| {
            let found = row.work.check(&mut screen);
            progress.step();
            found
        })
        .collect();
    drop(progress);
    let report = MicroReport::new(&rows, &found, &ceilings, args.rounds, wanted);
    if !args.json.takes_stdout() {
        out::print(&report.for_people())?;
    }
    sink.write(&report)?;
    let wrong = report.rows.iter().filter(|row| row.wrong > 0);
    let printed = wrong.map(|row| {
        out::note(format_args!(
            "bench: {}: {} wrong: visible items may be culled",
            row.name, row.wrong
        ));
    });
    Ok(if printed.count() > 0 {
        Outcome::CheckFailed
    } else {
        Outcome::Done
    })
}
