//! What all JSON reports share: the destination, the scene, and how numbers are rounded.

use crate::args::JsonArg;
use crate::non_occluders::NonOccluderItem;
use crate::open::OpenedScene;
use crate::out;
use crate::run_files::RunFiles;
use crate::save::Destination;
use anyhow::{Context, Result};
use serde::Serialize;

#[derive(Clone, Debug, Serialize)]
pub(crate) struct SceneReport {
    pub(crate) file: String,
    pub(crate) items: usize,
    pub(crate) triangles: u64,
    pub(crate) sectors: usize,
    pub(crate) portals: usize,
    /// Items of which some faces hide nothing; if asked for.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub(crate) non_occluders: Option<Vec<NonOccluderItem>>,
}

/// Destination of the JSON report, checked to be writable before the work.
pub(crate) enum Sink {
    Nowhere,
    Stdout,
    File(Destination),
}

impl Sink {
    /// Checks that the file can be written, and is not another file of the run.
    pub(crate) fn new(json: &JsonArg, files: &mut RunFiles) -> Result<Sink> {
        Ok(match &json.file {
            None => Sink::Nowhere,
            Some(_) if json.takes_stdout() => Sink::Stdout,
            Some(file) => Sink::File(files.writes(file)?),
        })
    }

    /// Writes a report to the destination.
    pub(crate) fn write(&self, report: &impl Serialize) -> Result<()> {
        match self {
            Sink::Nowhere => Ok(()),
            Sink::Stdout => out::print(&json_of(report)?),
            Sink::File(file) => {
                file.write(json_of(report)?.as_bytes())?;
                Ok(())
            }
        }
    }
}

/// Returns a report as the text of a file.
pub(crate) fn json_of(report: &impl Serialize) -> Result<String> {
    let text = serde_json::to_string_pretty(report).context("cannot encode the report as JSON")?;
    Ok(text + "\n")
}

impl SceneReport {
    pub(crate) fn new(opened: &OpenedScene) -> SceneReport {
        let scene = &opened.scene;
        SceneReport {
            file: opened.file.clone(),
            items: scene.item_count(),
            triangles: scene.triangle_count(),
            sectors: scene.sector_count(),
            portals: scene.portals().len(),
            non_occluders: None,
        }
    }
}

/// Rounds to four decimals, so that 60 degrees print as 60, and times in ms to a tenth of a microsecond.
pub(crate) fn rounded(value: f64) -> f64 {
    (value * 1e4).round() / 1e4
}
