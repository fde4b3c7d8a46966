//! Regression fingerprint: visible sets and picture hashes of every method on every scene, to compare before and after a
//! change that must not alter results.
//!
//! Writes one line per scene, method and view.
#![allow(clippy::print_stdout, reason = "a command prints what it finds")]

use crate::verify::{open, scenes};
use anyhow::{Context, Result, ensure};
use conformance::fingerprint;
use enfilade::{SurveyView, View, survey};
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
        of_scene(&name, args, &mut lines).with_context(|| name.clone())?;
    }
    let text = lines.iter().map(|line| format!("{line}\n")).collect::<String>();
    std::fs::write(&args.file, text).with_context(|| args.file.display().to_string())?;
    println!("{} lines written to {}", lines.len(), args.file.display());
    let Some(earlier) = earlier else { return Ok(()) };
    compare(&earlier, &lines)?;
    println!("identical");
    Ok(())
}

/// Fails if two fingerprints differ, and prints the first lines that do.
pub(crate) fn compare(earlier: &str, now: &[String]) -> Result<()> {
    let earlier: Vec<&str> = earlier.lines().collect();
    let different = differences(&earlier, now);
    for line in different.iter().take(SHOWN) {
        println!("{line}");
    }
    ensure!(different.is_empty(), "{} lines differ", different.len());
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
fn of_scene(name: &str, args: &Args, lines: &mut Vec<String>) -> Result<()> {
    let scene = open(name)?;
    // The file's name alone, so that fingerprints do not depend on the folder.
    let name = name.rsplit(['/', '\\']).next().unwrap_or(name);
    let places = survey(&scene, args.views).views;
    ensure!(!places.is_empty(), "the survey finds no camera position");
    let view_from = |place: &SurveyView| {
        let view = View::new(place.eye, place.toward, [args.size[0], args.size[1]]);
        view.expect("a view of the survey").in_sector(place.sector)
    };
    let views: Vec<View> = places.iter().map(view_from).collect();
    fingerprint(name, &scene, &views, lines);
    Ok(())
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
