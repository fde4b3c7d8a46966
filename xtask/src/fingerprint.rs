//! Regression fingerprint: visible sets and picture hashes of every method on every scene, to compare before and after a
//! change that must not alter results.
//!
//! Writes one line per scene, method and view. Each method keeps its viewer from view to view, so temporal coherence is
//! covered too.
#![allow(clippy::print_stdout, reason = "a command prints what it finds")]

use crate::verify::{open, scenes};
use anyhow::{Context, Result, ensure};
use enfilade::{Camera, Method, Viewer, VisibleSet, survey};
use enfilade_draw::{Settings, Stage};
use std::collections::BTreeMap;
use std::fmt::Write;
use std::path::PathBuf;

#[derive(clap::Args)]
pub(crate) struct Args {
    /// Output file
    file: PathBuf,
    /// Scenes: files, folders of .glb files, or @NAME [default: built-in scenes and those in ENFILADE_SCENES]
    scenes: Vec<String>,
    /// Earlier fingerprint of the same scenes; any difference is an error
    #[arg(long, value_name = "FILE")]
    same_as: Option<PathBuf>,
    /// Views of each scene
    #[arg(long, default_value_t = 6)]
    views: usize,
    /// Viewport width and height, in pixels
    #[arg(long, num_args = 2, default_values_t = [192, 108])]
    size: Vec<u32>,
}

/// Maximum number of differing lines to print.
const SHOWN: usize = 10;

pub(crate) fn run(args: &Args) -> Result<()> {
    let earlier = args.same_as.as_ref().map(|path| {
        let text = std::fs::read_to_string(path);
        text.with_context(|| path.display().to_string())
    });
    let earlier = earlier.transpose()?;
    let mut lines = Vec::new();
    for name in scenes(&args.scenes)? {
        println!("{name}");
        fingerprint(&name, args, &mut lines).with_context(|| name.clone())?;
    }
    let text = lines.iter().map(|line| format!("{line}\n")).collect::<String>();
    std::fs::write(&args.file, text).with_context(|| args.file.display().to_string())?;
    println!("{} lines written to {}", lines.len(), args.file.display());
    let Some(earlier) = earlier else { return Ok(()) };
    let earlier: Vec<&str> = earlier.lines().collect();
    let different = differences(&earlier, &lines);
    for line in different.iter().take(SHOWN) {
        println!("{line}");
    }
    ensure!(different.is_empty(), "{} lines differ", different.len());
    println!("identical");
    Ok(())
}

/// Returns the lines that are in one fingerprint only, prefixed with `-` (earlier) or `+` (now).
fn differences(earlier: &[&str], now: &[String]) -> Vec<String> {
    let only = |sign: &'static str, lines: Vec<&str>, others: Vec<&str>| {
        let others: std::collections::BTreeSet<&str> = others.into_iter().collect();
        let only = lines.into_iter().filter(move |line| !others.contains(line));
        only.map(|line| format!("{sign} {line}")).collect::<Vec<_>>()
    };
    let now: Vec<&str> = now.iter().map(String::as_str).collect();
    let mut different = only("-", earlier.to_vec(), now.clone());
    different.extend(only("+", now, earlier.to_vec()));
    different.sort_by(|a, b| a[2..].cmp(&b[2..]));
    different
}

/// Appends the lines of one scene.
fn fingerprint(name: &str, args: &Args, lines: &mut Vec<String>) -> Result<()> {
    let scene = open(name)?;
    // The file's name alone, so that fingerprints do not depend on the folder.
    let name = name.rsplit(['/', '\\']).next().unwrap_or(name);
    let places = survey(&scene, args.views).views;
    ensure!(!places.is_empty(), "the survey finds no camera position");
    for method in Method::ALL {
        let Ok(scene) = scene.with_method(method, Method::DEFAULT_LIMIT) else {
            lines.push(format!("{name} {method}: unsuited"));
            continue;
        };
        let stage = Stage::new(&scene);
        let mut viewer = Viewer::new();
        for (number, place) in places.iter().enumerate() {
            let camera = Camera {
                sector: Some(place.sector),
                ..Camera::new(place.eye, place.toward)
            };
            let view = camera.view([args.size[0], args.size[1]]).expect("a valid view");
            let picture = stage.draw(&mut viewer, &scene, &view, &Settings::default());
            let mut sum = Sum::new();
            sum.add_bytes(picture.image.as_raw());
            let set = viewer.visible();
            lines.push(format!(
                "{name} {method} view {number}: picture {:016x}, set {:016x}, {}",
                sum.0,
                sum_of(set),
                items_of(set)
            ));
        }
    }
    Ok(())
}

/// Formats the items of a set by sector, as ranges of item indices: `0: 3-5 9; 2: 0`.
fn items_of(set: &VisibleSet) -> String {
    let mut by_sector: BTreeMap<u32, Vec<u32>> = BTreeMap::new();
    for item in set.items() {
        let sector = set.passage(item.passage).sector;
        by_sector.entry(sector.0).or_default().push(item.item.index.0);
    }
    let mut text = format!("{} items in {} passages", set.items().len(), set.passages().len());
    if !set.complete() {
        text.push_str(", not complete");
    }
    for (sector, mut items) in by_sector {
        items.sort_unstable();
        items.dedup();
        _ = write!(text, "; {sector}:");
        for run in items.chunk_by(|a, b| a + 1 == *b) {
            _ = match run {
                [one] => write!(text, " {one}"),
                [first, .., last] => write!(text, " {first}-{last}"),
                [] => Ok(()),
            };
        }
    }
    text
}

/// Hashes a visible set: passages, items and clusters, in order.
fn sum_of(set: &VisibleSet) -> u64 {
    let mut sum = Sum::new();
    for passage in set.passages() {
        sum.add(passage.parent.map_or(u64::MAX, |parent| parent.0.into()));
        sum.add(passage.portal.map_or(u64::MAX, |portal| portal.0.into()));
        sum.add(passage.sector.0.into());
        sum.add(passage.crossings.into());
        sum.add(passage.z_near.to_bits().into());
    }
    for item in set.items() {
        sum.add(item.passage.0.into());
        sum.add(item.item.index.0.into());
        sum.add(item.size_px.into());
        sum.add(item.blends.into());
        for &cluster in set.clusters(item) {
            sum.add(cluster.into());
        }
    }
    sum.0
}

/// FNV-1a (Fowler, Noll, Vo), 64 bits.
struct Sum(u64);

impl Sum {
    fn new() -> Sum {
        Sum(0xcbf2_9ce4_8422_2325)
    }

    fn add(&mut self, number: u64) {
        self.add_bytes(&number.to_le_bytes());
    }

    fn add_bytes(&mut self, bytes: &[u8]) {
        for &byte in bytes {
            self.0 = (self.0 ^ u64::from(byte)).wrapping_mul(0x0000_0100_0000_01b3);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_line_that_changed_is_shown_as_it_was_and_as_it_is() {
        let now = ["a view 0: 1", "b view 0: 3"].map(str::to_owned);
        assert!(differences(&["a view 0: 1", "b view 0: 3"], &now).is_empty());
        let different = differences(&["a view 0: 1", "b view 0: 2"], &now);
        assert_eq!(different, ["- b view 0: 2", "+ b view 0: 3"]);
    }
}
