//! `vis`: computes the PVS of a Quake or Quake 3 map, and writes it into the map.

mod backup;
mod differ;
mod habits;
mod overall;
mod report;
mod shards;
mod start;
mod unfinished;

use crate::Outcome;
use crate::args::VisArgs;
use crate::invocation::program;
use crate::json::Sink;
use crate::leak::{leak_of, write_line};
use crate::open::allow_threads;
use crate::out;
use crate::progress::Progress;
use crate::read::read_file;
use crate::run_files::{RunFiles, is_same, portals_beside};
use crate::save::Destination;
use anyhow::{Context, Error, Result, anyhow, bail, ensure};
use backup::Backup;
use differ::OtherPvs;
use enfilade_bake::{PairsWork, Stage, VisiblePairs, find_missing};
use enfilade_import::{
    PortalFile, ReadOptions, place_portals, read_portals, visibility_bytes, with_ambient_sounds,
    with_visibility,
};
pub(crate) use habits::as_mappers_type;
use overall::{OverallProgress, is_stopped, stop_at_a_signal};
use report::{LineCheck, StageSeconds, VisReport, VisResult};
use shards::NamedPart;
use start::FlowStart;
use std::path::{Path, PathBuf};
use std::time::{Duration, Instant};
use unfinished::{SavedWork, UnfinishedWork};

/// Ending of the names of parts.
const ENDING: &str = "vis";

/// Runs `vis`.
pub(crate) fn run(mut args: VisArgs) -> Result<Outcome> {
    args.map = with_ending(args.map);
    let args = &args;
    if args.shards.shard.is_some() || args.prepare {
        return shards::run(args);
    }
    let name = args.map.display();
    let target = match ending(&args.map).as_deref() {
        Some("bsp") => Some(args.output.as_deref().unwrap_or(&args.map)),
        Some("prt") if args.output.is_some() || args.prt.is_some() => {
            bail!("{name}: a .prt gives a report only; name the .bsp to use --prt or -o")
        }
        Some("prt") => None,
        _ => bail!("{name}: not a map; name a .bsp, or its .prt for a report only"),
    };
    let mut files = RunFiles::default();
    let destination = target
        .map(|target| writable(target, &args.map, &mut files))
        .transpose()?;
    let prt = portals_of(args);
    let inputs = [Some(&args.map), prt.as_ref().ok(), args.compare.as_ref()];
    let inputs = inputs.into_iter().flatten();
    inputs.into_iter().try_for_each(|input| files.reads(input))?;
    let mut flow_start = match args.shards.merge {
        true => Some(FlowStart::new(args, &mut files)?),
        false => None,
    };
    let mut unfinished = UnfinishedWork::beside(target.unwrap_or(&args.map), &mut files)?;
    let sink = Sink::new(&args.json, &mut files)?;
    let backup = match target {
        Some(target) => Backup::of(target, !args.no_backup, &mut files)?,
        None => None,
    };
    let threads = allow_threads(&args.limits)?;
    let start = Instant::now();
    let mut seconds = StageSeconds::default();
    let map = read_map(args)?;
    let prt = match prt {
        Ok(prt) => prt,
        Err(why) => return Err(without_portals(args, why, &mut files)?),
    };
    let options = ReadOptions {
        limit_bytes: args.limits.memory(),
        ..ReadOptions::default()
    };
    let portals = read_portals(&prt, &options)?;
    let placed = match &map {
        Some(map) => Some(place_portals(map, &portals).with_context(|| map_with_portals(&args.map, &prt))?),
        None => None,
    };
    let other = match &args.compare {
        Some(path) => Some(OtherPvs::read(path, &portals, placed.as_ref(), &options)?),
        None => None,
    };
    let parts = match args.shards.merge {
        true => shards::read_parts(args, &portals, &mut files)?,
        false => Vec::new(),
    };
    let merged = parts.len();
    seconds.read = start.elapsed().as_secs_f64();

    if let Some(backup) = &backup {
        backup.announce();
    }
    let saved = unfinished.begin(args.resume, args.limits.memory())?;
    let is_resumed = saved.is_some();
    let begun = begin(args, &portals, &prt, &mut unfinished, saved, flow_start.as_mut())?;
    let end = if args.fast { Stage::Sampling } else { Stage::Done };
    let plan = WorkPlan {
        end,
        flow_start: flow_start.as_ref(),
        parts,
    };
    let work = work(args, begun, plan, &mut unfinished, &mut seconds)?;
    let pairs = work.pairs();
    let checked = args
        .check
        .map(|lines| check(&portals, &pairs, lines, &mut seconds))
        .transpose()?;
    let differs = other.map(|other| other.compare(&portals, &work, &pairs));
    let missing = checked.as_ref().is_some_and(|checked| checked.missing.is_some());

    let mut ambient = None;
    let written = match (&map, &destination) {
        (Some(map), Some(destination)) if !missing => {
            let start = Instant::now();
            let mut bytes = with_visibility(map, &portals, &pairs).with_context(|| name.to_string())?;
            if let Some(sounds) = args.ambient.sounds() {
                // The PVS may have taken hours, so a damaged texture must not discard it.
                match with_ambient_sounds(&bytes, &portals, &pairs, sounds) {
                    Ok(Some((with_sounds, leafs))) => (bytes, ambient) = (with_sounds, Some(leafs)),
                    Ok(None) => {}
                    Err(why) => out::warn(format_args!("{name}: no ambient sounds are written: it {why}")),
                }
            }
            backup.as_ref().map_or(Ok(()), Backup::write)?;
            destination.write(&bytes)?;
            seconds.write = start.elapsed().as_secs_f64();
            Some(visibility_bytes(&bytes)? as u64)
        }
        _ => None,
    };
    let is_complete = work.stage() == Stage::Done || (args.fast && work.stage() >= Stage::Sampling);
    // A fast run removes its own saved work, but not work it resumed from, which may be more advanced.
    let is_obsolete = is_complete && !args.resume && unfinished.is_held();
    if (work.stage() == Stage::Done || is_obsolete) && !missing {
        unfinished.remove()?;
    }
    seconds.total = start.elapsed().as_secs_f64();
    let visibility = VisReport::new(VisResult {
        map: &args.map,
        target: target.filter(|_| written.is_some()),
        backup: backup
            .as_ref()
            .and_then(Backup::path)
            .filter(|_| written.is_some()),
        lump_bytes: written,
        prt: &prt,
        portals: &portals,
        leafs: &placed.map_or_else(|| leafs_by_portals(&portals), |placed| placed.leafs),
        pairs: &pairs,
        is_fast: args.fast,
        is_complete,
        asked_to_resume: args.resume,
        is_resumed,
        merged,
        is_prepared: flow_start.as_ref().is_some_and(FlowStart::is_read),
        stopped_in: work.stage(),
        threads,
        seconds,
        checked,
        differs,
        ambient,
    });
    if !args.json.takes_stdout() {
        out::print(&visibility.text())?;
        if !is_complete && unfinished.is_held() {
            out::print(&format!(
                "  --resume continues from {}\n",
                unfinished.path().display()
            ))?;
        }
    }
    sink.write(&visibility)?;
    Ok(if missing {
        Outcome::CheckFailed
    } else {
        Outcome::Done
    })
}

/// Appends `.bsp` to the map's name if it is missing and that file exists.
fn with_ending(map: PathBuf) -> PathBuf {
    let mut name = map.clone().into_os_string();
    name.push(".bsp");
    let whole = PathBuf::from(name);
    let is_whole = matches!(ending(&map).as_deref(), Some("bsp" | "prt"));
    if !is_whole && whole.is_file() { whole } else { map }
}

fn ending(path: &Path) -> Option<String> {
    Some(path.extension()?.to_str()?.to_ascii_lowercase())
}

/// Returns the destination of the map with its PVS: the map itself or a copy.
fn writable(path: &Path, map: &Path, files: &mut RunFiles) -> Result<Destination> {
    if ending(path).as_deref() != Some("bsp") {
        bail!(
            "cannot write {}: the name of a map must end in .bsp",
            path.display()
        );
    }
    if is_same(path, map) {
        files.changes(path)
    } else {
        files.writes(path)
    }
}

/// Reads the map; `None` if the input is a .prt.
fn read_map(args: &VisArgs) -> Result<Option<Vec<u8>>> {
    if ending(&args.map).as_deref() != Some("bsp") {
        return Ok(None);
    }
    let remedy = "raise --memory to more than twice the size";
    read_file(&args.map, args.limits.memory() / 2, remedy).map(Some)
}

/// Returns the file of portals: that of `--prt`, or the one beside the map.
fn portals_of(args: &VisArgs) -> Result<PathBuf> {
    if let Some(prt) = &args.prt {
        return Ok(prt.clone());
    }
    if ending(&args.map).as_deref() == Some("prt") {
        return Ok(args.map.clone());
    }
    let [direct, bare] = portals_beside(&args.map);
    [&direct, &bare]
        .into_iter()
        .find(|path| path.is_file())
        .cloned()
        .ok_or_else(|| {
            anyhow!(
                "{}: there is no {} beside it; compile the map again, name its portals with --prt FILE, or rebuild them \
                 from the map: {} portals {}",
                args.map.display(),
                direct.file_name().unwrap_or_default().display(),
                program(),
                args.map.display()
            )
        })
}

/// Adds to the error about missing portals why a compiler wrote none: a leak, whose line is written.
fn without_portals(args: &VisArgs, why: Error, files: &mut RunFiles) -> Result<Error> {
    let leak = leak_of(&args.map, args.limits.memory());
    Ok(match leak {
        Some(leak) => anyhow!("{why}\n{}", write_line(&leak, &args.map, files)?),
        None => why,
    })
}

/// Returns the context of an error about portals that do not match the map.
fn map_with_portals(map: &Path, prt: &Path) -> String {
    format!("{} with the portals of {}", map.display(), prt.display())
}

/// Returns the number of leafs of each cluster, from the portal file alone.
fn leafs_by_portals(portals: &PortalFile) -> Vec<u32> {
    let clusters = portals.cells.count() as usize;
    let Some(of_leafs) = &portals.cluster_of_leaf else {
        return vec![1; clusters];
    };
    let mut leafs = vec![0; clusters];
    of_leafs.iter().for_each(|&cluster| leafs[cluster as usize] += 1);
    leafs
}

/// What a run computes.
struct WorkPlan<'a> {
    /// The stage at which it ends.
    end: Stage,
    /// Where to keep the work when the flow begins.
    flow_start: Option<&'a FlowStart>,
    /// The parts to add when the flow begins.
    parts: Vec<NamedPart>,
}

impl WorkPlan<'_> {
    /// Does what is to be done in work that has reached the flow, new or resumed.
    fn begin_flow(&mut self, args: &VisArgs, mut work: PairsWork) -> Result<PairsWork> {
        if work.stage() < Stage::Flow {
            return Ok(work);
        }
        if let Some(flow_start) = self.flow_start.take() {
            flow_start.write(&work)?;
        }
        // Only now, because all shards begin with the same work.
        if let Some(shard) = args.shards.shard.filter(|_| work.shard().is_none()) {
            work = work.with_shard(shard).context(
                "the saved work is not of a shard; leave out --resume to start from the beginning",
            )?;
        }
        for part in self.parts.drain(..) {
            part.add_to(&mut work)?;
        }
        Ok(work)
    }
}

/// Computes the PVS until the end of the plan or until time is up, and saves unfinished work at intervals.
fn work(
    args: &VisArgs,
    mut work: PairsWork,
    mut plan: WorkPlan,
    unfinished: &mut UnfinishedWork,
    seconds: &mut StageSeconds,
) -> Result<PairsWork> {
    let end = plan.end;
    stop_at_a_signal();
    let start = Instant::now();
    let mut overall = OverallProgress::new(end, args.quiet);
    let mut saved = start;
    let mut cost = Duration::ZERO;
    while work.stage() < end {
        let stage = work.stage();
        work = plan.begin_flow(args, work)?;
        let began = Instant::now();
        while work.stage() == stage {
            work.step();
            overall.show(&work);
            let is_over = args
                .seconds
                .is_some_and(|most| start.elapsed().as_secs_f64() >= most);
            let every = args
                .save_every
                .map_or_else(|| between_saves(start.elapsed(), cost), Duration::from_secs_f64);
            if is_over || is_stopped() || saved.elapsed() >= every {
                cost = unfinished.save(&work)?;
                saved = Instant::now();
            }
            if is_stopped() {
                bail!("{}", stopped_message(args, unfinished));
            }
            if is_over {
                seconds.add(stage, began.elapsed());
                return Ok(work);
            }
        }
        seconds.add(stage, began.elapsed());
    }
    plan.begin_flow(args, work)
}

/// Returns the time between two saves. It keeps both the work that a killed run loses and the time of saves to a small
/// share of the run.
fn between_saves(elapsed: Duration, cost: Duration) -> Duration {
    /// Saving does not pay in short runs.
    const MIN: Duration = Duration::from_millis(150);
    MIN.max(10 * cost).max(elapsed / 50)
}

/// Returns the error of an interrupted run.
fn stopped_message(args: &VisArgs, unfinished: &UnfinishedWork) -> String {
    let map = args.map.display();
    let nothing = match args.shards.shard {
        Some(_) => "no part is written",
        None if args.prepare => "nothing is written",
        None => "nothing is written into the map",
    };
    if unfinished.is_held() {
        format!("{map}: stopped; {nothing}; the same command with --resume continues")
    } else {
        format!("{map}: stopped; {nothing}, and no work is saved, because another run works on it")
    }
}

/// Starts new work, resumes saved work, or begins with work that is kept in the folder of parts.
fn begin(
    args: &VisArgs,
    portals: &PortalFile,
    prt: &Path,
    unfinished: &mut UnfinishedWork,
    saved: Option<SavedWork>,
    flow_start: Option<&mut FlowStart>,
) -> Result<PairsWork> {
    let limit = args.limits.memory();
    let Some(saved) = saved else {
        if let Some(work) = flow_start.and_then(|start| start.read(portals, limit)) {
            return Ok(work);
        }
        return PairsWork::begin(&portals.cells, limit)
            .map_err(|why| anyhow!("{}: {why}; raise --memory", prt.display()));
    };
    let work = PairsWork::resume(&portals.cells, limit, &saved.work, &saved.passages).map_err(|why| {
        anyhow!(
            "{}: {why}; leave out --resume to start from the beginning",
            unfinished.path().display()
        )
    })?;
    if let Some(shard) = work.shard().filter(|shard| args.shards.shard != Some(*shard)) {
        bail!(
            "{}: was saved by shard {shard}; leave out --resume to start from the beginning",
            unfinished.path().display()
        );
    }
    unfinished.set_resumed(&work);
    Ok(work)
}

/// Tests the PVS with random lines, until one proves a missing pair.
fn check(
    portals: &PortalFile,
    pairs: &VisiblePairs,
    lines: u64,
    seconds: &mut StageSeconds,
) -> Result<LineCheck> {
    /// Lines per update of the progress bar.
    const PART: u64 = 1 << 20;
    let start = Instant::now();
    let progress = Progress::share("checking with lines");
    let mut missing = None;
    let mut shot = 0;
    while shot < lines && missing.is_none() {
        let part = PART.min(lines - shot);
        missing = find_missing(&portals.cells, pairs, part, shot);
        shot += part;
        progress.set(shot as f64 / lines as f64);
        ensure!(
            !is_stopped(),
            "stopped while checking; nothing is written into the map"
        );
    }
    seconds.check = start.elapsed().as_secs_f64();
    Ok(LineCheck::new(shot, missing))
}
