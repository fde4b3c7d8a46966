//! What all verbs with `--shard` and `--merge` share.

use crate::text::plural;
use crate::values::Shard;
use anyhow::{Result, bail, ensure};
use std::path::Path;

/// Fails unless each of the shards of one run is there once, or no part at all.
pub(crate) fn check_set<'a>(parts: impl Iterator<Item = (&'a Path, Shard)>) -> Result<()> {
    let mut found: Vec<(&Path, Shard)> = Vec::new();
    for (path, shard) in parts {
        if let Some((first, other)) = found.first() {
            ensure!(
                shard.count() == other.count(),
                "{} is part {shard}, but {} is part {other}; name the parts of one run",
                path.display(),
                first.display()
            );
        }
        if let Some((other, _)) = found.iter().find(|(_, other)| *other == shard) {
            bail!(
                "{} and {} are both part {shard}; name each part once",
                other.display(),
                path.display()
            );
        }
        found.push((path, shard));
    }
    let Some(&(_, first)) = found.first() else {
        return Ok(());
    };
    /// Missing parts that are named.
    const FEW: usize = 8;
    let missing: Vec<String> = (0..first.count())
        .filter_map(|index| Shard::new(index, first.count()))
        .filter(|shard| found.iter().all(|(_, found)| found != shard))
        .take(FEW)
        .map(|shard| shard.to_string())
        .collect();
    let number = first.count() as usize - found.len();
    ensure!(
        number == 0,
        "{number} of {} missing: {}{}; name all parts, and compute missing ones with --shard {}",
        plural(first.count() as usize, "part"),
        missing.join(", "),
        if number > missing.len() { ", ..." } else { "" },
        missing[0]
    );
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;

    fn why(shards: &[(&str, [u32; 2])]) -> String {
        let parts = shards
            .iter()
            .map(|&(name, [index, count])| (Path::new(name), Shard::new(index, count).expect("a shard")));
        check_set(parts).map_or_else(|why| why.to_string(), |()| String::new())
    }

    #[test]
    fn a_set_is_whole_in_any_order() {
        assert_eq!(why(&[]), "");
        assert_eq!(why(&[("a", [0, 1])]), "");
        assert_eq!(why(&[("a", [2, 3]), ("b", [0, 3]), ("c", [1, 3])]), "");
    }

    #[test]
    fn what_is_missing_or_too_much_is_named() {
        assert_eq!(
            why(&[("a", [1, 3])]),
            "2 of 3 parts missing: 0/3, 2/3; name all parts, and compute missing ones with --shard 0/3"
        );
        assert!(why(&[("a", [0, 1000])]).contains("8/1000, ...;"));
        assert_eq!(
            why(&[("a", [0, 2]), ("b", [0, 2])]),
            "a and b are both part 0/2; name each part once"
        );
        assert_eq!(
            why(&[("a", [0, 2]), ("b", [1, 3])]),
            "b is part 1/3, but a is part 0/2; name the parts of one run"
        );
    }
}
