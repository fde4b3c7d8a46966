//! Maps that leak: their compilers write no portals, so nothing can compute a PVS for them.

use crate::invocation::program;
use crate::run_files::{RunFiles, portals_beside};
use crate::text::point;
use anyhow::Result;
use enfilade_import::{Leak, ReadOptions, file_bytes, find_leak};
use serde::Serialize;
use std::path::{Path, PathBuf};

/// A leak in a report.
#[derive(Debug, Serialize)]
pub(crate) struct LeakEntry {
    /// The entity that sees the void.
    entity: String,
    /// Its position, in the units and axes of the map.
    origin: [f64; 3],
    /// A way from there to the void.
    line: Vec<[f64; 3]>,
}

impl From<Leak> for LeakEntry {
    fn from(leak: Leak) -> LeakEntry {
        LeakEntry {
            entity: leak.entity,
            origin: leak.origin,
            line: leak.line,
        }
    }
}

/// Returns the leak of a map without portals beside it; `None` if it has some, is sealed, or cannot be read.
pub(crate) fn leak_of(map: &Path, limit_bytes: u64) -> Option<Leak> {
    let has_portals = portals_beside(map).iter().any(|portals| portals.is_file());
    if has_portals {
        None
    } else {
        leak_in(map, limit_bytes)
    }
}

/// Returns the leak of a map; `None` if it is sealed, or cannot be read.
pub(crate) fn leak_in(map: &Path, limit_bytes: u64) -> Option<Leak> {
    let options = ReadOptions {
        limit_bytes,
        ..ReadOptions::default()
    };
    let bytes = file_bytes(map, limit_bytes).ok()?;
    find_leak(&bytes, &options).ok().flatten()
}

impl LeakEntry {
    /// Says what a leak is, and how to see it.
    pub(crate) fn for_people(&self, map: &str) -> String {
        format!(
            "{}; `{} vis {map}` writes the line to the hole as a .pts file",
            what_leaks(&self.entity, self.origin),
            program()
        )
    }
}

fn what_leaks(entity: &str, origin: [f64; 3]) -> String {
    format!(
        "the map has a leak: {entity} at {} can see the void outside, so its compiler wrote no portals, and vis cannot work",
        point(origin.map(|part| part as f32))
    )
}

/// Writes the line of a leak beside the map as `MAP.pts`, where compilers write it and editors look for it, unless there is
/// such a file. Returns the message.
pub(crate) fn write_line(leak: &Leak, map: &Path, files: &mut RunFiles) -> Result<String> {
    let path = pts_beside(map);
    let what = what_leaks(&leak.entity, leak.origin);
    let name = path.display();
    let line = if path.symlink_metadata().is_ok() {
        format!("{name} is there already: load it in the editor")
    } else {
        files.writes(&path)?.write(leak.to_pts().as_bytes())?;
        format!(
            "the line from there to the void is in {name}: load it in the editor (TrenchBroom: File > Load Point File)"
        )
    };
    Ok(format!(
        "{what}; {line}, close the hole, and compile the map again"
    ))
}

fn pts_beside(map: &Path) -> PathBuf {
    map.with_extension("pts")
}
