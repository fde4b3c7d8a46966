//! Files that an OBJ file names: they lie in its folder, or below it.

use crate::budget::Budget;
use crate::read_regular_file;
use std::path::{Path, PathBuf};

/// A path below the folder of the OBJ file, which it cannot leave.
#[derive(Clone, Debug, Default, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub(super) struct Inside(PathBuf);

impl Inside {
    /// What `name` means in a file that is `here`. A path that is of another machine, or leads out of the folder, stands for
    /// the file of that name beside the one that names it, which is where it lies as a rule when such files are handed on.
    pub(super) fn of(name: &str, here: &Inside) -> Inside {
        let beside = here.0.parent().unwrap_or(Path::new(""));
        let name = name.replace('\\', "/");
        let is_elsewhere = name.starts_with('/') || name.get(1..2) == Some(":");
        let followed = (!is_elsewhere).then(|| follow(beside, &name)).flatten();
        Inside(followed.unwrap_or_else(|| beside.join(last_part(&name))))
    }

    /// Its bytes, or why they cannot be had.
    pub(super) fn read(&self, folder: Option<&Path>, budget: &mut Budget) -> Result<Vec<u8>, String> {
        let folder = folder.ok_or_else(|| "no folder was given to look for it".to_owned())?;
        read_regular_file(&folder.join(&self.0), None, &|| self.spoken(), budget)
            .map_err(|why| why.to_string())
    }

    /// Where it is.
    pub(super) fn path(&self, folder: Option<&Path>) -> Option<PathBuf> {
        Some(folder?.join(&self.0))
    }

    /// Is there such a file?
    pub(super) fn exists(&self, folder: Option<&Path>) -> bool {
        folder.is_some_and(|folder| folder.join(&self.0).is_file())
    }

    /// As people write it, on any machine, but not longer than one can read.
    pub(super) fn spoken(&self) -> String {
        const LONGEST: usize = 120;
        let path = self.0.to_string_lossy().replace('\\', "/");
        match path.char_indices().nth(LONGEST) {
            Some((end, _)) => format!("{}…", &path[..end]),
            None => path,
        }
    }
}

/// Goes the steps of a path from a folder, if none of them leads above where all folders begin, nor they all nowhere.
fn follow(from: &Path, name: &str) -> Option<PathBuf> {
    let mut at = from.to_owned();
    for step in name.split('/') {
        match step {
            "" | "." => {}
            ".." => {
                if !at.pop() {
                    return None;
                }
            }
            step => at.push(step),
        }
    }
    (!at.as_os_str().is_empty()).then_some(at)
}

/// The name without folders, or one that no file has.
fn last_part(name: &str) -> &str {
    name.rsplit(['/', ':'])
        .find(|part| !matches!(*part, "" | "." | ".."))
        .unwrap_or("(no name)")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn no_path_leads_out_of_the_folder() {
        let here = Inside::of("materials/a.mtl", &Inside::default());
        for (name, means) in [
            ("wood.png", "materials/wood.png"),
            ("./tex\\my wood.png", "materials/tex/my wood.png"),
            ("..\\tex//wood.png", "tex/wood.png"),
            ("../../secret/wood.png", "materials/wood.png"),
            ("/etc/passwd", "materials/passwd"),
            ("C:\\art\\wood.png", "materials/wood.png"),
            ("\\\\host\\art\\wood.png", "materials/wood.png"),
            ("D:wood.png", "materials/wood.png"),
            ("../..", "materials/(no name)"),
            ("tex/../../x/../y/wood.png", "y/wood.png"),
        ] {
            assert_eq!(Inside::of(name, &here).spoken(), means, "{name}");
        }
        assert_eq!(Inside::of("../a.mtl", &Inside::default()).spoken(), "a.mtl");
    }
}
