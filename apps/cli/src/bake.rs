//! `bake`: writes scenes as a baked scene, which opens at once.

use crate::Outcome;
use crate::args::BakeArgs;
use crate::json::{Sink, rounded};
use crate::open::{allow_threads, import_of};
use crate::out;
use crate::progress::Progress;
use crate::run_files::RunFiles;
use crate::save::Destination;
use crate::shards::parts_folder;
use crate::text::{bytes, count, ms, plural};
use anyhow::{Context, Result, bail, ensure};
use enfilade_import::{BakedSections, Baker, Import, ReadOptions, SectionTotal};
use serde::Serialize;
use std::collections::BTreeMap;
use std::ffi::OsStr;
use std::fmt::Write;
use std::fs::File;
use std::io;
use std::path::{Path, PathBuf};
use std::time::Instant;
use xxhash_rust::xxh3::Xxh3;

/// The JSON report.
#[derive(Debug, Default, Serialize)]
struct BakeReport {
    /// `None` for a share of the tiles.
    file: Option<String>,
    scenes: Vec<String>,
    bytes: u64,
    rooms: usize,
    items: usize,
    sections: Vec<SectionEntry>,
    /// The files of tiles that were baked, and those that were up to date.
    parts_baked: Vec<String>,
    parts_unchanged: Vec<String>,
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
    let mut files = RunFiles::default();
    for scene in &args.scenes {
        files.reads(Path::new(scene))?;
    }
    let output = args
        .output
        .as_deref()
        .map(|output| writable(output, &mut files))
        .transpose()?;
    let tiles = Tile::all(args)?;
    let sink = Sink::new(&args.json, &mut files)?;
    allow_threads(&args.limits)?;
    let start = Instant::now();
    let mut report = BakeReport {
        scenes: args
            .scenes
            .iter()
            .map(|scene| scene.to_string_lossy().into_owned())
            .collect(),
        ..BakeReport::default()
    };
    bake_parts(args, &tiles, &mut files, &mut report)?;
    if let Some(output) = output {
        join(args, &tiles, &output, &mut files, &mut report)?;
    }
    report.bake_ms = rounded(start.elapsed().as_secs_f64() * 1e3);
    if !args.json.takes_stdout() {
        out::print(&report.for_people())?;
    }
    sink.write(&report)?;
    Ok(Outcome::Done)
}

/// Checks that an output can be written, and is called like a baked scene.
pub(crate) fn writable(output: &Path, files: &mut RunFiles) -> Result<Destination> {
    ensure!(
        output
            .extension()
            .is_some_and(|ending| ending.eq_ignore_ascii_case("enf")),
        "cannot write {}: a baked scene is a .enf file, so the name must end in .enf",
        output.display()
    );
    files.writes(output)
}

/// A scene to bake.
struct Tile<'a> {
    scene: &'a OsStr,
    /// Its name in the world, if there are several.
    name: Option<String>,
    /// The file that it is baked into first.
    part: Option<PathBuf>,
}

impl Tile<'_> {
    /// Names the scenes.
    fn all(args: &BakeArgs) -> Result<Vec<Tile<'_>>> {
        let folder = parts_folder(&args.shards)?;
        let mut named: BTreeMap<String, &OsStr> = BTreeMap::new();
        let mut tiles = Vec::new();
        for scene in &args.scenes {
            let stem = Path::new(scene).file_stem().unwrap_or(scene).to_string_lossy();
            let stem = stem.trim_start_matches('@').to_owned();
            if let Some(other) = named.insert(stem.clone(), scene) {
                bail!(
                    "{} and {} are both called {stem}, but tiles of a world need different names; rename one",
                    other.display(),
                    scene.display()
                );
            }
            tiles.push(Tile {
                scene,
                part: folder.map(|folder| folder.join(format!("{stem}.enf"))),
                name: (args.scenes.len() > 1).then_some(stem),
            });
        }
        Ok(tiles)
    }
}

/// Bakes the tiles of this share that are not up to date.
fn bake_parts(args: &BakeArgs, tiles: &[Tile], files: &mut RunFiles, report: &mut BakeReport) -> Result<()> {
    let of_share = tiles
        .iter()
        .enumerate()
        .filter(|(number, _)| args.shards.shard.is_none_or(|shard| shard.has(*number)));
    let of_share: Vec<(&Tile, &PathBuf)> = of_share
        .filter_map(|(_, tile)| Some((tile, tile.part.as_ref()?)))
        .collect();
    let progress = Progress::steps("baking tiles", of_share.len());
    for (tile, part) in of_share {
        let shown = part.display().to_string();
        if is_up_to_date(part, tile.scene, args) {
            report.parts_unchanged.push(shown);
        } else if args.shards.merge {
            bail!("{shown} is missing or not up to date; bake it first, without --merge");
        } else {
            let destination = files.writes(part)?;
            let (import, source) = read_with_source(args, tile.scene, files)?;
            note_warnings(tile.scene, &import, report);
            destination.write_with(|file| {
                let mut baker = Baker::new(file, "")?;
                baker.add(&import, None)?;
                baker.note_source(&serde_json::to_vec(&source)?)?;
                Ok(baker.finish()?)
            })?;
            report.parts_baked.push(shown);
        }
        progress.step();
    }
    Ok(())
}

/// Bakes all tiles into one file.
fn join(
    args: &BakeArgs,
    tiles: &[Tile],
    output: &Destination,
    files: &mut RunFiles,
    report: &mut BakeReport,
) -> Result<()> {
    let name = output
        .name()
        .file_stem()
        .unwrap_or_default()
        .to_string_lossy()
        .into_owned();
    let progress = Progress::steps("baking", tiles.len());
    report.bytes = output.write_with(|file| {
        let mut baker = Baker::new(file, &name)?;
        for tile in tiles {
            let import = match &tile.part {
                None => {
                    let import = read(args, tile.scene, files)?;
                    note_warnings(tile.scene, &import, report);
                    import
                }
                Some(part) => {
                    let options = ReadOptions {
                        limit_bytes: args.limits.memory(),
                        ..ReadOptions::default()
                    };
                    enfilade_import::read(part, &options)?
                }
            };
            report.items += import
                .rooms
                .iter()
                .map(|room| room.geometry.items().len())
                .sum::<usize>();
            baker.add(&import, tile.name.as_deref())?;
            progress.step();
        }
        report.rooms = baker.room_count();
        Ok(baker.finish()?)
    })?;
    report.file = Some(output.name().display().to_string());
    report.sections = BakedSections::read(output.name())?.map_or(Vec::new(), |sections| entries(&sections));
    Ok(())
}

fn read(args: &BakeArgs, scene: &OsStr, files: &mut RunFiles) -> Result<Import> {
    import_of(scene, args, files)
}

/// Reads a scene, and hashes its files before they are read: if one changes meanwhile, the part is not up to date.
fn read_with_source(args: &BakeArgs, scene: &OsStr, files: &mut RunFiles) -> Result<(Import, Source)> {
    let source = Source::of(args, scene, &[])?;
    let import = read(args, scene, files)?;
    if import.files.is_empty() {
        return Ok((import, source));
    }
    // Only reading tells which files belong to it.
    let source = Source::of(args, scene, &import.files)?;
    Ok((read(args, scene, files)?, source))
}

fn note_warnings(scene: &OsStr, import: &Import, report: &mut BakeReport) {
    for warning in &import.warnings {
        let warning = format!("{}: {warning}", scene.display());
        out::warn(&warning);
        report.warnings.push(warning);
    }
}

/// What a tile was baked from: options, and the files, relative to the folder of the scene, with the hashes of their bytes.
#[derive(Debug, PartialEq, serde::Serialize, serde::Deserialize)]
struct Source {
    program: String,
    flat: bool,
    skip_bad_portals: bool,
    #[serde(default)]
    scene: Option<String>,
    #[serde(default)]
    lenient: bool,
    files: BTreeMap<PathBuf, Option<String>>,
}

impl Source {
    fn of(args: &BakeArgs, scene: &OsStr, side_files: &[PathBuf]) -> Result<Source> {
        let folder = folder_of(scene);
        let files = side_files.iter().map(PathBuf::as_path).chain([Path::new(scene)]);
        let hashed = |file: &Path| {
            Ok((
                file.strip_prefix(folder).unwrap_or(file).to_owned(),
                hash_of(file)?,
            ))
        };
        Ok(Source {
            files: files.map(hashed).collect::<Result<_>>()?,
            ..Source::without_files(args)
        })
    }

    fn without_files(args: &BakeArgs) -> Source {
        Source {
            program: env!("CARGO_PKG_VERSION").to_owned(),
            flat: args.flat,
            skip_bad_portals: args.bad.skip,
            scene: args.read.scene_of_file.clone(),
            lenient: args.read.lenient,
            files: BTreeMap::new(),
        }
    }
}

/// Returns `true` if a tile was baked from the same files, with the same options. A damaged one was not.
fn is_up_to_date(part: &Path, scene: &OsStr, args: &BakeArgs) -> bool {
    let sections = BakedSections::read(part).ok().flatten();
    let source = sections.and_then(|sections| serde_json::from_slice::<Source>(&sections.source).ok());
    source.is_some_and(|mut source| {
        let files = std::mem::take(&mut source.files);
        source == Source::without_files(args)
            && files.contains_key(Path::new(Path::new(scene).file_name().unwrap_or(scene)))
            && files
                .iter()
                .all(|(file, hash)| hash_of(&folder_of(scene).join(file)).is_ok_and(|now| now == *hash))
            && is_whole(part)
    })
}

fn folder_of(scene: &OsStr) -> &Path {
    Path::new(scene).parent().unwrap_or(Path::new(""))
}

/// Returns `true` if all sections of a part are as they were written.
fn is_whole(part: &Path) -> bool {
    let options = ReadOptions {
        limit_bytes: u64::MAX,
        ..ReadOptions::default()
    };
    enfilade_import::read(part, &options).is_ok()
}

/// Returns the hash of a file's bytes; `None` if there is no such file.
fn hash_of(path: &Path) -> Result<Option<String>> {
    if !path.is_file() {
        return Ok(None);
    }
    let mut hash = Xxh3::new();
    let copied = File::open(path).and_then(|mut file| io::copy(&mut file, &mut hash));
    copied.with_context(|| format!("cannot read {}", path.display()))?;
    Ok(Some(format!("{:032x}", hash.digest128())))
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
        let mut text = String::new();
        // Writing to a String cannot fail.
        if !(self.parts_baked.is_empty() && self.parts_unchanged.is_empty()) {
            let _ = writeln!(
                text,
                "{} baked, {} up to date",
                plural(self.parts_baked.len(), "tile"),
                count(self.parts_unchanged.len() as u64)
            );
        }
        if let Some(file) = &self.file {
            let _ = writeln!(
                text,
                "{file}: {}, {}, {}; baked in {} ms",
                plural(self.rooms, "room"),
                plural(self.items, "item"),
                bytes(self.bytes),
                ms(self.bake_ms)
            );
        }
        for section in &self.sections {
            let _ = writeln!(text, "  {}", section.for_people());
        }
        text
    }
}
