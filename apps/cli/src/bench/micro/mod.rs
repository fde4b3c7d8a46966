//! `bench --micro`: how many faces and boxes a second the masked cover takes, beside what the machine and others can do.
//!
//! All rows are run in turn, round after round, and the median of each is told: cores that are shared with others slow
//! them all alike. Whatever was timed is then held against a reference in f64, in the same run.

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
use crate::open::{For, open, settle};
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
use truth::Held;

/// The screen of all rows but those of scenes.
const SIZE: [u32; 2] = [1920, 1080];

/// What one sub-tile of a cover takes: which of 32 samples are open, which are of its nearer layer, and the reversed depth of
/// both.
const SUB_TILE_BYTES: u64 = 16;

/// What all rows are called, those of scenes last.
pub(crate) fn names() -> impl Iterator<Item = &'static str> {
    rows::names().chain(walk::NAMES)
}

/// Work that is timed and then held against the truth.
trait Work {
    /// How many faces or boxes it comes to.
    fn count(&self) -> u64;

    /// Does it, and gives the seconds that it took.
    fn run(&mut self, screen: &mut Screen) -> f64;

    /// Does it once more, and finds out how right it is and what it takes at least.
    fn hold(&mut self, screen: &mut Screen) -> Found;
}

/// What was found out about work.
struct Found {
    held: Held,
    /// Bytes of the cover that cannot but be touched, and the cache that they may lie in.
    least_bytes: u64,
    ceiling: Ceiling,
}

/// A row of the table.
struct Row {
    name: &'static str,
    /// What the best other culler comes to, in millions a second.
    best: f64,
    work: Box<dyn Work>,
    /// Of each round.
    seconds: Vec<f64>,
    /// How many views the work is, where it is told in milliseconds a view.
    views: Option<u64>,
}

impl Row {
    fn new(name: &'static str, best: f64, work: Box<dyn Work>) -> Row {
        Row {
            name,
            best,
            work,
            seconds: Vec::new(),
            views: None,
        }
    }

    /// The median of all rounds.
    fn median_seconds(&self) -> f64 {
        median(&self.seconds)
    }
}

/// Runs `bench --micro`.
pub(super) fn run(args: &BenchArgs) -> Result<Outcome> {
    let scene = args.scene.as_deref();
    let mut files = scene.map_or_else(|| Ok(RunFiles::default()), |scene| RunFiles::of(scene, None))?;
    let sink = Sink::new(&args.json, &mut files)?;
    settle(&args.how)?;
    let making = Progress::spinner("making faces");
    let mut screen = Screen::new(SIZE)?;
    let wanted = |name: &str| args.rows.is_empty() || args.rows.iter().any(|row| row == name);
    let mut rows = rows::rows(&screen, wanted);
    drop(making);
    if let Some(scene) = scene {
        // Openings are left aside: all of the scene is in one space.
        let opened = open(
            scene,
            For::Answers,
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
            ceilings.forget();
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
    let found: Vec<Found> = rows
        .iter_mut()
        .map(|row| {
            let found = row.work.hold(&mut screen);
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
    let told = wrong.map(|row| {
        out::note(format_args!(
            "bench: {}: {} wrong: what can be seen may be hidden",
            row.name, row.wrong
        ));
    });
    Ok(if told.count() > 0 {
        Outcome::CheckFailed
    } else {
        Outcome::Done
    })
}
