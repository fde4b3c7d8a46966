//! `portals`: rebuilds the portals of a compiled map, so that `vis` can run if the .prt is lost.

use crate::Outcome;
use crate::args::PortalsArgs;
use crate::json::Sink;
use crate::leak::{LeakEntry, leak_in};
use crate::out;
use crate::progress::Progress;
use crate::run_files::RunFiles;
use crate::text::{bytes, plural, short};
use anyhow::{Result, bail};
use enfilade_import::{ClustersFrom, ReadOptions, RebuiltPortals, rebuild_portals};
use serde::Serialize;
use std::fs;
use std::path::{Path, PathBuf};
use std::time::Instant;

/// The JSON report.
#[derive(Debug, Serialize)]
struct PortalsReport {
    file: String,
    bytes: u64,
    map: String,
    /// `PRT1`, `PRT2`, or `PRT1 of Quake 3`.
    kind: &'static str,
    /// Source of the clusters: `map`, `rows` of the PVS, or `leafs` if neither exists; then each leaf is a cluster.
    clusters_from: &'static str,
    leafs: u32,
    clusters: u32,
    portals: usize,
    slivers: usize,
    seconds: f64,
}

/// Runs `portals`.
pub(crate) fn run(args: &PortalsArgs) -> Result<Outcome> {
    let output = args.output.clone().unwrap_or_else(|| beside(&args.map));
    if !output
        .extension()
        .is_some_and(|ending| ending.eq_ignore_ascii_case("prt"))
    {
        bail!(
            "cannot write {}: portals are a .prt file, so the name must end in .prt",
            output.display()
        );
    }
    keep_existing(&output, args.force)?;
    let mut files = RunFiles::default();
    files.reads(&args.map)?;
    let destination = files.writes(&output)?;
    let sink = Sink::new(&args.json, &mut files)?;
    let options = ReadOptions {
        limit_bytes: args.memory.bytes,
        ..ReadOptions::default()
    };
    let progress = Progress::spinner("rebuilding");
    let start = Instant::now();
    let RebuiltPortals {
        file,
        clusters_from,
        leafs,
        slivers,
    } = rebuild_portals(&args.map, &options)?;
    let text = file.to_text();
    let seconds = start.elapsed().as_secs_f64();
    let leak = match clusters_from {
        // A map with a PVS was sealed when it was computed.
        ClustersFrom::Rows => None,
        ClustersFrom::Map | ClustersFrom::Leafs => leak_in(&args.map, args.memory.bytes),
    };
    drop(progress);
    if let Some(leak) = leak {
        let map = args.map.display();
        let leak = LeakEntry::from(leak).for_people(&map.to_string());
        out::warn(format_args!(
            "{map}: {leak}; these portals lead into the void as well"
        ));
    }
    keep_existing(&output, args.force)?;
    destination.write(text.as_bytes())?;
    let made = PortalsReport {
        file: output.display().to_string(),
        bytes: text.len() as u64,
        map: args.map.display().to_string(),
        kind: file.kind.name(),
        clusters_from: match clusters_from {
            ClustersFrom::Map => "map",
            ClustersFrom::Rows => "rows",
            ClustersFrom::Leafs => "leafs",
        },
        leafs,
        clusters: file.cells.count(),
        portals: file.cells.portals().len(),
        slivers,
        seconds,
    };
    if !args.json.takes_stdout() {
        let alone = match clusters_from {
            ClustersFrom::Leafs => "\nThe map has no clusters and no PVS, so each leaf is a cluster.",
            ClustersFrom::Map | ClustersFrom::Rows => "",
        };
        out::print(&format!(
            "{}: {}, {}, {}, {}, {} in {} s{alone}\n",
            made.file,
            made.kind,
            plural(made.leafs as usize, "leaf"),
            plural(made.clusters as usize, "cluster"),
            plural(made.portals, "portal"),
            bytes(made.bytes),
            short(made.seconds),
        ))?;
    }
    sink.write(&made)?;
    Ok(Outcome::Done)
}

/// Returns the default path of a map's portals: `NAME.prt` beside `NAME.bsp` or `NAME.novis.bsp`.
fn beside(map: &Path) -> PathBuf {
    let is = |path: &Path, word: &str| {
        path.extension()
            .is_some_and(|ending| ending.eq_ignore_ascii_case(word))
    };
    let mut path = map.to_owned();
    if is(&path, "bsp") {
        path.set_extension("");
    }
    if is(&path, "novis") {
        path.set_extension("");
    }
    let mut name = path.file_name().unwrap_or_default().to_owned();
    name.push(".prt");
    path.with_file_name(name)
}

/// Fails if the output exists, unless `force`.
fn keep_existing(output: &Path, force: bool) -> Result<()> {
    if !force && fs::symlink_metadata(output).is_ok() {
        bail!(
            "cannot write {}: it exists already; name another file with -o, or replace it with --force",
            output.display()
        );
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn portals_stand_beside_their_map() {
        for (map, portals) in [
            ("maps/dm1.bsp", "maps/dm1.prt"),
            ("darkzone.novis.bsp", "darkzone.prt"),
            ("DM1.BSP", "DM1.prt"),
            ("a.b.bsp", "a.b.prt"),
            ("../odd", "../odd.prt"),
        ] {
            assert_eq!(beside(Path::new(map)), Path::new(portals));
        }
    }
}
