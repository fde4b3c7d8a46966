//! The work at the beginning of the flow, kept in the folder of parts, so that shards and merges need not repeat it.
//!
//! It is saved work, so it names its version and its portals by a hash, and has a checksum. It does not depend on the run
//! that wrote it: two that write it at once write the same bytes.

use super::ENDING;
use crate::args::VisArgs;
use crate::run_files::RunFiles;
use crate::save::Destination;
use crate::shards::PartFiles;
use anyhow::Result;
use enfilade_bake::{PairsWork, Stage};
use enfilade_import::{PortalFile, file_bytes};
use std::path::{Path, PathBuf};

/// The files `MAP.bsp.start.vis` and `MAP.bsp.passages.vis`.
pub(super) struct FlowStart {
    path: PathBuf,
    destination: Destination,
    path_of_passages: PathBuf,
    passages: Destination,
    is_read: bool,
}

impl FlowStart {
    /// Returns the files in the folder of `--parts`, and adds them to the outputs.
    pub(super) fn new(args: &VisArgs, files: &mut RunFiles) -> Result<FlowStart> {
        let parts = PartFiles::new(&args.shards, args.map.as_os_str(), ENDING)?;
        let [path, path_of_passages] = ["start", "passages"].map(|what| parts.path_of(what));
        Ok(FlowStart {
            destination: files.writes_too(&path)?,
            path,
            passages: files.writes_too(&path_of_passages)?,
            path_of_passages,
            is_read: false,
        })
    }

    pub(super) fn path(&self) -> &Path {
        &self.path
    }

    /// Whether the run began with this work.
    pub(super) fn is_read(&self) -> bool {
        self.is_read
    }

    /// Reads the work; `None` if a file is missing, damaged, too large, of other portals or of another version.
    pub(super) fn read(&mut self, portals: &PortalFile, limit: u64) -> Option<PairsWork> {
        let [saved, passages] = [&self.path, &self.path_of_passages].map(|path| file_bytes(path, limit).ok());
        let work = PairsWork::resume(&portals.cells, limit, &saved?, &passages?).ok()?;
        // Without its passages it is in an earlier stage.
        self.is_read = is_start(&work) && work.shard().is_none();
        self.is_read.then_some(work)
    }

    /// Writes the work if it is at the beginning of the flow, and was not read.
    pub(super) fn write(&self, work: &PairsWork) -> Result<()> {
        if self.is_read || !is_start(work) {
            return Ok(());
        }
        self.passages.write(&work.save_passages())?;
        self.destination.write(&work.save())?;
        Ok(())
    }
}

fn is_start(work: &PairsWork) -> bool {
    work.stage() == Stage::Flow && work.share() == 0.0
}
