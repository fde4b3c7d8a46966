//! `vis --prepare`, `vis --shard` and `vis --merge`: the portal flow on several machines.

use super::report::{StageSeconds, peak_memory};
use super::start::FlowStart;
use super::unfinished::UnfinishedWork;
use super::{ENDING, WorkPlan, begin, map_with_portals, portals_of, read_map, without_portals, work};
use crate::Outcome;
use crate::args::VisArgs;
use crate::json::Sink;
use crate::open::allow_threads;
use crate::out;
use crate::read::read_file;
use crate::run_files::RunFiles;
use crate::shards::PartFiles;
use crate::text::{bytes, plural, short};
use crate::values::Shard;
use anyhow::{Context, Result, anyhow, ensure};
use enfilade_bake::{FlowPart, PairsWork, PartError, Stage};
use enfilade_import::{PortalFile, ReadOptions, place_portals, read_portals};
use serde::Serialize;
use std::fmt::Write;
use std::fs;
use std::path::{Path, PathBuf};
use std::time::Instant;

/// The report of a shard, or of `--prepare`.
#[derive(Debug, Serialize)]
struct ShardReport {
    map: String,
    prt: String,
    format: &'static str,
    clusters: u32,
    portals: usize,
    #[serde(skip_serializing_if = "Option::is_none")]
    shard: Option<String>,
    /// Path of the written part, or of the work that all shards begin with.
    written: String,
    /// Size of that file.
    bytes: u64,
    /// Whether it resumed an unfinished run.
    resumed: bool,
    /// Whether it began with the work of `--prepare` or of another shard.
    prepared: bool,
    seconds: StageSeconds,
    threads: usize,
    /// Peak memory of the program, in bytes; `None` if the system does not report it.
    peak_memory: Option<u64>,
}

/// Runs `vis --shard` or `vis --prepare`.
pub(super) fn run(args: &VisArgs) -> Result<Outcome> {
    let shard = args.shards.shard;
    let parts = PartFiles::new(&args.shards, args.map.as_os_str(), ENDING)?;
    let mut files = RunFiles::default();
    let mut flow_start = FlowStart::new(args, &mut files)?;
    let target = shard.map_or(flow_start.path().to_owned(), |shard| parts.path(shard));
    let destination = shard.map(|_| files.writes(&target)).transpose()?;
    let prt = match portals_of(args) {
        Ok(prt) => prt,
        Err(why) => return Err(without_portals(args, why, &mut files)?),
    };
    [&args.map, &prt]
        .into_iter()
        .try_for_each(|input| files.reads(input))?;
    let mut unfinished = UnfinishedWork::beside(&target, &mut files)?;
    let sink = Sink::new(&args.json, &mut files)?;
    let threads = allow_threads(&args.limits)?;
    let start = Instant::now();
    let mut seconds = StageSeconds::default();
    let map = read_map(args)?;
    let options = ReadOptions {
        limit_bytes: args.limits.memory(),
        ..ReadOptions::default()
    };
    let portals = read_portals(&prt, &options)?;
    if let Some(map) = &map {
        // A part of the portals of another map would be refused only by the merge.
        place_portals(map, &portals).with_context(|| map_with_portals(&args.map, &prt))?;
    }
    seconds.read = start.elapsed().as_secs_f64();
    let saved = unfinished.begin(args.resume, args.limits.memory())?;
    let resumed = saved.is_some();
    let begun = begin(
        args,
        &portals,
        &prt,
        &mut unfinished,
        saved,
        Some(&mut flow_start),
    )?;
    let plan = WorkPlan {
        end: if shard.is_some() {
            Stage::Backflow
        } else {
            Stage::Flow
        },
        flow_start: Some(&flow_start),
        parts: Vec::new(),
    };
    let work = work(args, begun, plan, &mut unfinished, &mut seconds)?;
    let writing = Instant::now();
    if let Some(destination) = destination {
        destination.write(&work.save_part().context("the shard has not ended")?)?;
    }
    seconds.write = writing.elapsed().as_secs_f64();
    unfinished.remove()?;
    seconds.total = start.elapsed().as_secs_f64();
    let report = ShardReport {
        map: args.map.display().to_string(),
        prt: prt.display().to_string(),
        format: portals.kind.name(),
        clusters: portals.cells.count(),
        portals: portals.cells.portals().len(),
        shard: shard.map(|shard| shard.to_string()),
        written: target.display().to_string(),
        bytes: fs::metadata(&target).map_or(0, |file| file.len()),
        resumed,
        prepared: flow_start.is_read(),
        seconds,
        threads,
        peak_memory: peak_memory(),
    };
    if !args.json.takes_stdout() {
        out::print(&report.text(shard))?;
    }
    sink.write(&report)?;
    Ok(Outcome::Done)
}

impl ShardReport {
    fn text(&self, shard: Option<Shard>) -> String {
        let done = shard.map_or("prepared".to_owned(), |shard| format!("shard {shard}"));
        let mut text = format!(
            "{}: {done} of the portal flow of {}, {}\n",
            self.map,
            plural(self.clusters as usize, "cluster"),
            plural(self.portals, "portal")
        );
        if self.resumed {
            text += "  resumed from the saved work of an unfinished run\n";
        }
        // Writing to a String cannot fail.
        let _ = match (shard, self.prepared) {
            (None, true) => writeln!(text, "  {} is up to date", self.written),
            _ => writeln!(text, "  written to {}: {}", self.written, bytes(self.bytes)),
        };
        if let Some(shard) = shard {
            if self.prepared {
                text += "  began with what --prepare or another shard has kept\n";
            }
            let parts = plural(shard.count() as usize, "part");
            let _ = writeln!(text, "  when all {parts} are there, --merge joins them");
        }
        let memory = self
            .peak_memory
            .map_or(String::new(), |peak| format!(", {}", bytes(peak)));
        let _ = writeln!(
            text,
            "  {} s on {}{memory}",
            short(self.seconds.total),
            plural(self.threads, "thread")
        );
        text
    }
}

/// A part, and its file.
pub(super) struct NamedPart {
    path: PathBuf,
    part: FlowPart,
}

impl NamedPart {
    fn read(path: PathBuf, shard: Shard, args: &VisArgs, portals: &PortalFile) -> Result<NamedPart> {
        let bytes = read_file(&path, args.limits.memory(), "raise --memory")?;
        let part =
            FlowPart::from_bytes(&portals.cells, &bytes).map_err(|why| error(&path, args, why, shard))?;
        ensure!(
            part.shard() == shard,
            "{} is the part of shard {}; undo the change of its name, or compute shard {shard} again",
            path.display(),
            part.shard()
        );
        Ok(NamedPart { path, part })
    }

    /// Adds the part to work that has reached the flow.
    pub(super) fn add_to(self, work: &mut PairsWork) -> Result<()> {
        let NamedPart { path, part } = self;
        let shard = part.shard();
        work.add_part(part).map_err(|why| {
            anyhow!(
                "{}: {why}, so another version of the program wrote it; compute shard {shard} again with this one",
                path.display()
            )
        })
    }
}

fn error(path: &Path, args: &VisArgs, why: PartError, shard: Shard) -> anyhow::Error {
    let of = match why {
        PartError::Other => format!(", not those of {}", args.map.display()),
        _ => String::new(),
    };
    anyhow!("{}: {why}{of}; compute shard {shard} again", path.display())
}

/// Reads the parts of all shards.
///
/// # Errors
/// Fails if one is missing, or is not a part of these portals.
pub(super) fn read_parts(
    args: &VisArgs,
    portals: &PortalFile,
    files: &mut RunFiles,
) -> Result<Vec<NamedPart>> {
    let parts = PartFiles::new(&args.shards, args.map.as_os_str(), ENDING)?.whole_set()?;
    let read = |(shard, path): (Shard, PathBuf)| {
        files.reads(&path)?;
        NamedPart::read(path, shard, args, portals)
    };
    parts.into_iter().map(read).collect()
}
