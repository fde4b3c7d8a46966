//! Finds the heightmap of a description.

use super::TerrainError;
use std::ffi::OsStr;
use std::path::{Path, PathBuf};

/// Returns the file called `named`, or else the only `.raw` file that belongs to a description called `name`.
pub(super) fn heights_of(
    named: &Option<String>,
    folder: &Path,
    name: &OsStr,
) -> Result<PathBuf, TerrainError> {
    if let Some(named) = named {
        let is_beside = !named.contains(['/', '\\', ':']) && !matches!(named.as_str(), "" | "." | "..");
        return if is_beside {
            Ok(folder.join(named))
        } else {
            Err(TerrainError::NotBeside(named.clone()))
        };
    }
    let mut wanted = name.to_owned();
    wanted.push(".raw");
    let own = folder.join(&wanted);
    let wanted = wanted.to_string_lossy().into_owned();
    if own.is_file() {
        return Ok(own);
    }
    let folder = if folder.as_os_str().is_empty() {
        Path::new(".")
    } else {
        folder
    };
    let files = std::fs::read_dir(folder).into_iter().flatten().flatten();
    let mut all: Vec<PathBuf> = files
        .map(|file| file.path())
        .filter(|path| {
            let begins = path
                .file_stem()
                .is_some_and(|stem| stem.as_encoded_bytes().starts_with(name.as_encoded_bytes()));
            let ends = path
                .extension()
                .is_some_and(|ending| ending.eq_ignore_ascii_case("raw"));
            begins && ends
        })
        .collect();
    // `read_dir` returns files in any order.
    all.sort();
    match all.as_slice() {
        [one] => Ok(one.clone()),
        [] => Err(TerrainError::NoFile {
            wanted,
            found: "there is none".to_owned(),
        }),
        [first, second, ..] => Err(TerrainError::NoFile {
            wanted,
            found: format!("there are {} and {}", first.display(), second.display()),
        }),
    }
}
