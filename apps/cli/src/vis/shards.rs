//! `vis --shard` and `vis --merge`: the portal flow on several machines.

use super::report::{StageSeconds, peak_memory};
use super::unfinished::UnfinishedWork;
use super::{begin, ending, map_with_portals, portals_of, read_map, work};
use crate::Outcome;
use crate::args::VisArgs;
use crate::json::Sink;
use crate::open::allow_threads;
use crate::out;
use crate::read::read_file;
use crate::run_files::RunFiles;
use crate::shards::check_set;
use crate::text::{bytes, plural, short};
use crate::values::Shard;
use anyhow::{Context, Result, anyhow, bail};
use enfilade_bake::{FlowPart, PairsWork, PartError, Stage};
use enfilade_import::{PortalFile, ReadOptions, place_portals, read_portals};
use serde::Serialize;
use std::fmt::Write;
use std::path::{Path, PathBuf};
use std::time::Instant;

/// The report of a shard.
#[derive(Debug, Serialize)]
struct ShardReport {
    map: String,
    prt: String,
    format: &'static str,
    clusters: u32,
    portals: usize,
    shard: String,
    /// Path of the written part.
    written: String,
    /// Size of the part.
    bytes: usize,
    /// Whether it resumed an unfinished run.
    resumed: bool,
    seconds: StageSeconds,
    threads: usize,
    /// Peak memory of the program, in bytes; `None` if the system does not report it.
    peak_memory: Option<u64>,
}

/// Runs `vis --shard`.
pub(super) fn run(args: &VisArgs, shard: Shard) -> Result<Outcome> {
    // The command line requires it.
    let target = args
        .output
        .as_deref()
        .context("--shard needs -o, the name of the part")?;
    if matches!(ending(target).as_deref(), Some("bsp" | "prt")) {
        bail!(
            "cannot write {}: with --shard, -o names a part and no map; use another ending, such as .part",
            target.display()
        );
    }
    let mut files = RunFiles::default();
    let destination = files.writes(target)?;
    let prt = portals_of(args)?;
    [&args.map, &prt]
        .into_iter()
        .try_for_each(|input| files.reads(input))?;
    let mut unfinished = UnfinishedWork::beside(target, &mut files)?;
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
    let begun = begin(args, &portals, &prt, &mut unfinished, saved)?;
    let work = work(
        args,
        begun,
        Stage::Backflow,
        Vec::new(),
        &mut unfinished,
        &mut seconds,
    )?;
    let part = work.save_part().context("the shard has not ended")?;
    let writing = Instant::now();
    destination.write(&part)?;
    seconds.write = writing.elapsed().as_secs_f64();
    unfinished.remove()?;
    seconds.total = start.elapsed().as_secs_f64();
    let report = ShardReport {
        map: args.map.display().to_string(),
        prt: prt.display().to_string(),
        format: portals.kind.name(),
        clusters: portals.cells.count(),
        portals: portals.cells.portals().len(),
        shard: shard.to_string(),
        written: target.display().to_string(),
        bytes: part.len(),
        resumed,
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
    fn text(&self, shard: Shard) -> String {
        let mut text = format!(
            "{}: shard {shard} of the portal flow of {}, {}\n",
            self.map,
            plural(self.clusters as usize, "cluster"),
            plural(self.portals, "portal")
        );
        if self.resumed {
            text += "  resumed from the saved work of an unfinished run\n";
        }
        // Writing to a String cannot fail.
        let _ = writeln!(
            text,
            "  written to {}: a part of {}",
            self.written,
            bytes(self.bytes as u64)
        );
        let parts = plural(shard.count() as usize, "part");
        let _ = writeln!(
            text,
            "  when all {parts} are there: enfilade vis {} --merge PART...",
            self.map
        );
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
    fn read(path: &Path, args: &VisArgs, portals: &PortalFile) -> Result<NamedPart> {
        let bytes = read_file(path, args.limits.memory(), "raise --memory")?;
        let part = FlowPart::from_bytes(&portals.cells, &bytes).map_err(|why| error(path, args, why))?;
        Ok(NamedPart {
            path: path.to_owned(),
            part,
        })
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

fn error(path: &Path, args: &VisArgs, why: PartError) -> anyhow::Error {
    let remedy = match why {
        PartError::Other => "name the parts of this map",
        PartError::Damaged => "copy it again, or compute its shard again",
        _ => "name files that `vis --shard` of this version wrote",
    };
    let of = match why {
        PartError::Other => format!(", not those of {}", args.map.display()),
        _ => String::new(),
    };
    anyhow!("{}: {why}{of}; {remedy}", path.display())
}

/// Reads the parts of `--merge`; none without it.
///
/// # Errors
/// Fails if a file is not a part of these portals, or if not each of the shards of one run is there once.
pub(super) fn read_parts(args: &VisArgs, portals: &PortalFile) -> Result<Vec<NamedPart>> {
    let parts: Vec<NamedPart> = (args.merge.iter())
        .map(|path| NamedPart::read(path, args, portals))
        .collect::<Result<_>>()?;
    let shards = parts.iter().map(|part| (part.path.as_path(), part.part.shard()));
    check_set(shards)?;
    Ok(parts)
}
