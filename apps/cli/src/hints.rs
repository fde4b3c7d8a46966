//! `hints`: samples what is seen from the rooms of a baked scene, so that it can be loaded before it is visible.

use crate::Outcome;
use crate::args::HintsArgs;
use crate::bake::{self, SectionEntry};
use crate::invocation::program;
use crate::json::{Sink, rounded};
use crate::open::allow_threads;
use crate::out;
use crate::progress::Progress;
use crate::run_files::{RunFiles, is_same};
use crate::save::Destination;
use crate::shards::PartFiles;
use crate::text::{bytes, count, ms, plural};
use anyhow::{Context, Result, ensure};
use enfilade::{Aabb, ItemIndex, SectorId};
use enfilade_import::{BakedSections, bake_hints, file_bytes};
use enfilade_stream::{Hint, HintOptions, HintSampler};
use serde::{Deserialize, Serialize};
use std::fmt::Write;
use std::path::{Path, PathBuf};
use std::time::Instant;

/// The JSON report.
#[derive(Debug, Default, Serialize)]
struct HintsReport {
    /// `None` for a share of the regions.
    file: Option<String>,
    scene: String,
    bytes: u64,
    /// Number of regions, and how many of them were sampled now.
    regions: usize,
    sampled: usize,
    /// Number of hinted items, of all regions together.
    items: usize,
    /// Regions in which no position was found.
    without_positions: usize,
    sections: Vec<SectionEntry>,
    /// `None` without `--check`.
    check: Option<CheckReport>,
    hints_ms: f64,
}

/// Compares hints with further views.
#[derive(Debug, Default, Serialize)]
struct CheckReport {
    views: u32,
    /// Views of whose visible items at least 95 % are hinted.
    views_covered: u32,
    /// Visible items, once per view, and how many of them are hinted.
    items_visible: u64,
    items_hinted: u64,
    /// Items that are seen from the regions, by sampling and by these views.
    items_seen: u64,
}

/// Runs `hints`.
pub(crate) fn run(args: &HintsArgs) -> Result<Outcome> {
    let mut files = RunFiles::default();
    let output = args.output.as_deref().unwrap_or(&args.scene);
    let destination = if args.shards.shard.is_some() {
        files.reads(&args.scene)?;
        None
    } else {
        Some(writable(output, &args.scene, &mut files)?)
    };
    let sink = Sink::new(&args.json, &mut files)?;
    allow_threads(&args.limits)?;
    let start = Instant::now();
    let mut run = HintsRun::new(args)?;
    let hints = run.sample(&mut files)?;
    if let (Some(destination), Some(hints)) = (&destination, hints) {
        run.check(&hints)?;
        run.report.bytes = destination.write_with(|file| Ok(bake_hints(&args.scene, &hints, file)?))?;
        run.report.file = Some(output.display().to_string());
        run.report.sections =
            BakedSections::read(output)?.map_or(Vec::new(), |sections| bake::entries(&sections));
    }
    let mut report = run.report;
    report.hints_ms = rounded(start.elapsed().as_secs_f64() * 1e3);
    if !args.json.takes_stdout() {
        out::print(&report.for_people())?;
    }
    sink.write(&report)?;
    Ok(Outcome::Done)
}

fn writable(output: &Path, scene: &Path, files: &mut RunFiles) -> Result<Destination> {
    if output == scene || is_same(output, scene) {
        return files.changes(output);
    }
    files.reads(scene)?;
    bake::writable(output, files)
}

struct HintsRun<'a> {
    args: &'a HintsArgs,
    sampler: HintSampler,
    source: Source,
    parts: Option<PartFiles>,
    report: HintsReport,
}

impl<'a> HintsRun<'a> {
    fn new(args: &'a HintsArgs) -> Result<HintsRun<'a>> {
        let parts = args.shards.parts.as_ref();
        let parts = parts.map(|_| PartFiles::new(&args.shards, args.scene.as_os_str(), "hint"));
        let parts = parts.transpose()?;
        let name = args.scene.display();
        let sections = BakedSections::read(&args.scene)?;
        let sections = sections.with_context(|| {
            format!(
                "{name}: not a baked scene; bake it first: {} bake {name} -o FILE.enf",
                program()
            )
        })?;
        let mut options = HintOptions::default();
        options.positions = args.positions;
        options.bytes = args.limits.memory();
        let sampler = HintSampler::open(&args.scene, options)?;
        Ok(HintsRun {
            args,
            parts,
            report: HintsReport {
                scene: name.to_string(),
                regions: sampler.region_count(),
                ..HintsReport::default()
            },
            source: Source {
                program: env!("CARGO_PKG_VERSION").to_owned(),
                scene: format!("{:016x}", sections.hash),
                positions: args.positions,
                size: options.size,
            },
            sampler,
        })
    }

    /// Returns the hints of all regions; `None` for a share.
    fn sample(&mut self, files: &mut RunFiles) -> Result<Option<Vec<Hint>>> {
        let shard = self.args.shards.shard;
        let of_share: Vec<usize> = (0..self.sampler.region_count())
            .filter(|&region| shard.is_none_or(|shard| shard.has(region)))
            .collect();
        let progress = Progress::steps("sampling", of_share.len());
        let mut hints = Vec::new();
        for region in of_share {
            let hint = self.hint(region, files)?;
            self.report.items += hint.items.len();
            self.report.without_positions += usize::from(hint.items.is_empty());
            hints.push(hint);
            progress.step();
        }
        Ok(shard.is_none().then_some(hints))
    }

    /// Returns the hint of a region, sampled or read.
    fn hint(&mut self, region: usize, files: &mut RunFiles) -> Result<Hint> {
        let file = self.file_of(region);
        if let Some(file) = &file {
            if let Some(known) = Part::read(file).filter(|known| known.source == self.source) {
                return Ok(known.hint());
            }
            ensure!(
                !self.args.shards.merge,
                "{} is missing, or of another scene; sample it first, without --merge",
                file.display()
            );
        }
        let hint = self.sampler.sample(region)?;
        self.report.sampled += 1;
        if let Some(file) = file {
            let bytes = serde_json::to_vec(&Part::new(&self.source, &hint))?;
            files.writes(&file)?.write(&bytes)?;
        }
        Ok(hint)
    }

    fn file_of(&self, region: usize) -> Option<PathBuf> {
        let parts = self.parts.as_ref()?;
        Some(parts.path_of(&format!("{region:05}")))
    }

    fn check(&mut self, hints: &[Hint]) -> Result<()> {
        let Some(views) = self.args.check else {
            return Ok(());
        };
        let progress = Progress::steps("checking", hints.len());
        let report = self.report.check.insert(CheckReport::default());
        for (region, hint) in hints.iter().enumerate() {
            let check = self.sampler.check(region, hint, views)?;
            report.views += check.views;
            report.views_covered += check.covered;
            report.items_visible += check.visible;
            report.items_hinted += check.hinted;
            report.items_seen += check.seen;
            progress.step();
        }
        Ok(())
    }
}

/// What hints were sampled from, and how.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
struct Source {
    program: String,
    scene: String,
    positions: u32,
    size: u32,
}

/// The hint of a region, in a file of its own.
#[derive(Serialize, Deserialize)]
struct Part {
    source: Source,
    room: u32,
    bounds: [[f32; 3]; 2],
    /// The room and the index of each.
    items: Vec<[u32; 2]>,
}

impl Part {
    fn new(source: &Source, hint: &Hint) -> Part {
        let items = hint.items.iter();
        Part {
            source: source.clone(),
            room: hint.sector.0,
            bounds: [hint.bounds.min, hint.bounds.max],
            items: items.map(|(room, item)| [room.0, item.0]).collect(),
        }
    }

    /// Reads a file; `None` if it does not exist, or is damaged.
    fn read(file: &Path) -> Option<Part> {
        serde_json::from_slice(&file_bytes(file, u64::MAX).ok()?).ok()
    }

    fn hint(self) -> Hint {
        let [min, max] = self.bounds;
        let items = self.items.into_iter();
        Hint {
            sector: SectorId(self.room),
            bounds: Aabb { min, max },
            items: items
                .map(|[room, item]| (SectorId(room), ItemIndex(item)))
                .collect(),
        }
    }
}

impl HintsReport {
    fn for_people(&self) -> String {
        let mut text = String::new();
        // Writing to a String cannot fail.
        let _ = writeln!(
            text,
            "{}, {} sampled now: {} in {} ms",
            plural(self.regions, "region"),
            count(self.sampled as u64),
            plural(self.items, "hinted item"),
            ms(self.hints_ms)
        );
        if self.without_positions > 0 {
            let _ = writeln!(
                text,
                "no position to stand at was found in {}; nothing is hinted there",
                plural(self.without_positions, "region")
            );
        }
        if let Some(check) = &self.check {
            let _ = writeln!(
                text,
                "check: in {} of {} at least 95 % of the visible items are hinted; {} of {} in all",
                count(check.views_covered.into()),
                plural(check.views as usize, "further view"),
                count(check.items_hinted),
                count(check.items_visible)
            );
        }
        if let Some(file) = &self.file {
            let _ = writeln!(text, "{file}: {}", bytes(self.bytes));
        }
        for section in &self.sections {
            let _ = writeln!(text, "  {}", section.for_people());
        }
        text
    }
}
