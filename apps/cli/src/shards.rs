//! What all verbs with `--parts`, `--shard` and `--merge` share: the files in the folder of parts.

use crate::args::ShardArgs;
use crate::text::plural;
use crate::values::Shard;
use anyhow::{Context, Result, bail, ensure};
use std::ffi::OsStr;
use std::fs;
use std::path::{Path, PathBuf};

/// Returns the folder of `--parts`; `None` without it.
///
/// # Errors
/// Fails if there is no such folder.
pub(crate) fn parts_folder(args: &ShardArgs) -> Result<Option<&Path>> {
    if let Some(folder) = &args.parts {
        ensure!(
            folder.is_dir(),
            "{}: there is no such folder; create it first, or name another with --parts",
            folder.display()
        );
    }
    Ok(args.parts.as_deref())
}

/// The parts of one input, which are the files `INPUT.I-of-N.ENDING` of a folder.
#[derive(Debug)]
pub(crate) struct PartFiles {
    folder: PathBuf,
    /// Name of the input.
    input: String,
    ending: &'static str,
}

impl PartFiles {
    /// Returns the parts of an input in the folder of `--parts`.
    pub(crate) fn new(args: &ShardArgs, input: &OsStr, ending: &'static str) -> Result<PartFiles> {
        // The command line requires it.
        let folder = parts_folder(args)?.context("--shard and --merge need --parts")?;
        let name = Path::new(input).file_name().unwrap_or(input).to_string_lossy();
        Ok(PartFiles {
            folder: folder.to_owned(),
            input: name.trim_start_matches('@').to_owned(),
            ending,
        })
    }

    /// Returns the path of a part.
    pub(crate) fn path(&self, shard: Shard) -> PathBuf {
        self.path_of(&format!("{}-of-{}", shard.index(), shard.count()))
    }

    /// Returns the path of a file that belongs to the parts.
    pub(crate) fn path_of(&self, what: &str) -> PathBuf {
        self.folder.join(format!("{}.{what}.{}", self.input, self.ending))
    }

    /// Returns all parts of one run, in order.
    ///
    /// # Errors
    /// Fails if one is missing, or if there are parts of runs with different numbers of shards.
    pub(crate) fn whole_set(&self) -> Result<Vec<(Shard, PathBuf)>> {
        let mut found = self.found()?;
        found.sort_by_key(|shard| (shard.count(), shard.index()));
        let folder = self.folder.display();
        let Some(&first) = found.first() else {
            bail!(
                "{folder}: there is no part of {}; compute its parts with --shard, or name their folder with --parts",
                self.input
            );
        };
        if let Some(other) = found.iter().find(|shard| shard.count() != first.count()) {
            bail!(
                "{folder}: {} is of {}, but {} of {}; remove the parts that are not to be joined",
                self.path(first).display(),
                plural(first.count() as usize, "shard"),
                self.path(*other).display(),
                other.count()
            );
        }
        check_all(&self.input, &found, first.count()).with_context(|| folder.to_string())?;
        Ok(found.into_iter().map(|shard| (shard, self.path(shard))).collect())
    }

    /// Returns the shards whose parts are in the folder.
    fn found(&self) -> Result<Vec<Shard>> {
        let fails = || format!("cannot read {}", self.folder.display());
        let mut found = Vec::new();
        for entry in fs::read_dir(&self.folder).with_context(fails)? {
            let name = entry.with_context(fails)?.file_name();
            found.extend(name.to_str().and_then(|name| self.shard_of(name)));
        }
        Ok(found)
    }

    fn shard_of(&self, name: &str) -> Option<Shard> {
        let numbers = name.strip_prefix(&self.input)?.strip_prefix('.')?;
        let numbers = numbers.strip_suffix(self.ending)?.strip_suffix('.')?;
        let (index, count) = numbers.split_once("-of-")?;
        let shard = Shard::new(index.parse().ok()?, count.parse().ok()?)?;
        // Not `00-of-2`, which is another file.
        (self.path(shard).file_name() == Some(OsStr::new(name))).then_some(shard)
    }
}

/// Fails if a shard is missing, and names some that are.
fn check_all(input: &str, found: &[Shard], count: u32) -> Result<()> {
    /// Missing parts that are named.
    const FEW: usize = 8;
    let number = count as usize - found.len();
    let missing: Vec<String> = (0..count)
        .filter_map(|index| Shard::new(index, count))
        .filter(|shard| !found.contains(shard))
        .take(FEW)
        .map(|shard| shard.to_string())
        .collect();
    ensure!(
        number == 0,
        "{number} of {} of {input} missing: {}{}; compute missing ones with --shard {}",
        plural(count as usize, "part"),
        missing.join(", "),
        if number > missing.len() { ", ..." } else { "" },
        missing[0]
    );
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Returns the parts of `map.bsp` in a folder with these files, or the error.
    fn set(names: &[&str]) -> Result<Vec<String>, String> {
        let folder = tempfile::tempdir().expect("a folder");
        for name in names {
            fs::write(folder.path().join(name), "").expect("written");
        }
        let parts = PartFiles {
            folder: folder.path().to_owned(),
            input: "map.bsp".to_owned(),
            ending: "vis",
        };
        let shards = |set: Vec<(Shard, PathBuf)>| set.iter().map(|(shard, _)| shard.to_string()).collect();
        parts.whole_set().map(shards).map_err(|why| format!("{why:#}"))
    }

    #[test]
    fn a_set_is_found_by_its_names() {
        let other = [
            "other.bsp.0-of-2.vis",
            "map.bsp.start.vis",
            "map.bsp.1-of-2.json",
            "map.bsp.00-of-2.vis",
        ];
        let own = ["map.bsp.2-of-3.vis", "map.bsp.0-of-3.vis", "map.bsp.1-of-3.vis"];
        assert_eq!(
            set(&[&other[..], &own].concat()).as_deref(),
            Ok(&["0/3", "1/3", "2/3"].map(str::to_owned)[..])
        );
        let why = set(&other).expect_err("none is there");
        assert!(why.contains("there is no part of map.bsp"), "{why}");
    }

    #[test]
    fn what_is_missing_or_too_much_is_named() {
        let why = set(&["map.bsp.1-of-3.vis"]).expect_err("two are missing");
        assert!(
            why.ends_with(
                ": 2 of 3 parts of map.bsp missing: 0/3, 2/3; compute missing ones with --shard 0/3"
            ),
            "{why}"
        );
        let why = set(&["map.bsp.0-of-1000.vis"]).expect_err("many are missing");
        assert!(why.contains("8/1000, ...;"), "{why}");
        let why = set(&["map.bsp.0-of-2.vis", "map.bsp.1-of-3.vis"]).expect_err("of two runs");
        assert!(
            why.contains("map.bsp.0-of-2.vis is of 2 shards, but ")
                && why.contains("map.bsp.1-of-3.vis of 3; remove"),
            "{why}"
        );
    }
}
