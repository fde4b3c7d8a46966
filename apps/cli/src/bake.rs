//! `bake`: writes a scene as a baked scene, which opens at once.

use crate::Outcome;
use crate::args::BakeArgs;
use crate::json::{Sink, rounded};
use crate::open::{allow_threads, import_of};
use crate::out;
use crate::progress::Progress;
use crate::run_files::RunFiles;
use crate::text::{bytes, count, ms, plural};
use anyhow::{Result, bail};
use enfilade_import::{BakedSections, SectionTotal};
use serde::Serialize;
use std::fmt::Write;
use std::time::Instant;

/// The JSON report.
#[derive(Debug, Serialize)]
struct BakeReport {
    file: String,
    scene: String,
    bytes: u64,
    rooms: usize,
    items: usize,
    sections: Vec<SectionEntry>,
    read_ms: f64,
    bake_ms: f64,
    warnings: Vec<String>,
}

/// The sections of a kind, in JSON.
#[derive(Debug, Serialize)]
pub(crate) struct SectionEntry {
    pub(crate) kind: &'static str,
    pub(crate) count: u32,
    pub(crate) bytes: u64,
}

/// Runs `bake`.
pub(crate) fn run(args: &BakeArgs) -> Result<Outcome> {
    let output = &args.output;
    if !output
        .extension()
        .is_some_and(|ending| ending.eq_ignore_ascii_case("enf"))
    {
        bail!(
            "cannot write {}: a baked scene is a .enf file, so the name must end in .enf",
            output.display()
        );
    }
    let mut files = RunFiles::of(&args.scene.scene, None)?;
    let destination = files.writes(output)?;
    let sink = Sink::new(&args.json, &mut files)?;
    allow_threads(&args.limits)?;
    let name = args.scene.scene.to_string_lossy().into_owned();
    let start = Instant::now();
    let progress = Progress::spinner(&format!("loading {name}"));
    let import = import_of(
        &args.scene.scene,
        args.flat,
        args.bad.skip,
        &args.limits,
        &mut files,
    )?;
    drop(progress);
    let read_ms = start.elapsed().as_secs_f64() * 1e3;
    let warnings: Vec<String> = import.warnings.iter().map(ToString::to_string).collect();
    warnings
        .iter()
        .for_each(|warning| out::warn(format_args!("{name}: {warning}")));
    let start = Instant::now();
    let progress = Progress::spinner("baking");
    let length = destination.write_with(|file| Ok(enfilade_import::bake(&import, file)?))?;
    drop(progress);
    let report = BakeReport {
        file: output.display().to_string(),
        scene: name,
        bytes: length,
        rooms: import.rooms.len(),
        items: import.rooms.iter().map(|room| room.geometry.items().len()).sum(),
        sections: BakedSections::read(output)?.map_or(Vec::new(), |sections| entries(&sections)),
        read_ms: rounded(read_ms),
        bake_ms: rounded(start.elapsed().as_secs_f64() * 1e3),
        warnings,
    };
    if !args.json.takes_stdout() {
        out::print(&report.for_people())?;
    }
    sink.write(&report)?;
    Ok(Outcome::Done)
}

pub(crate) fn entries(sections: &BakedSections) -> Vec<SectionEntry> {
    let entry = |&SectionTotal { kind, count, bytes }: &SectionTotal| SectionEntry { kind, count, bytes };
    sections.totals.iter().map(entry).collect()
}

impl SectionEntry {
    /// Returns a line of text: the kind, and how much of the file it is.
    pub(crate) fn for_people(&self) -> String {
        let number = if self.count > 1 {
            format!(" in {}", count(self.count.into()))
        } else {
            String::new()
        };
        format!("{}: {}{number}", self.kind, bytes(self.bytes))
    }
}

impl BakeReport {
    fn for_people(&self) -> String {
        let mut text = format!(
            "{}: {}, {}, {}; read in {} ms, baked in {} ms\n",
            self.file,
            plural(self.rooms, "room"),
            plural(self.items, "item"),
            bytes(self.bytes),
            ms(self.read_ms),
            ms(self.bake_ms)
        );
        for section in &self.sections {
            // Writing to a String cannot fail.
            let _ = writeln!(text, "  {}", section.for_people());
        }
        text
    }
}
