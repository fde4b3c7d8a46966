//! Paths of files that an OBJ file references: inside its folder or below it.

use crate::budget::Budget;
use crate::read_regular_file;
use std::path::{Path, PathBuf};

/// A path below the folder of the OBJ file, which it cannot leave.
#[derive(Clone, Debug, Default, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub(super) struct InnerPath(PathBuf);

impl InnerPath {
    /// Resolves `name`, written in the file `here`. An absolute path, or one that leaves the folder, is replaced by the
    /// file of that name next to `here`, where shared files usually are.
    pub(super) fn of(name: &str, here: &InnerPath) -> InnerPath {
        let beside = here.0.parent().unwrap_or(Path::new(""));
        let name = name.replace('\\', "/");
        let is_elsewhere = name.starts_with('/') || name.get(1..2) == Some(":");
        let followed = (!is_elsewhere).then(|| follow(beside, &name)).flatten();
        InnerPath(followed.unwrap_or_else(|| beside.join(last_part(&name))))
    }

    /// Returns the bytes of the file, or the reason why it cannot be read.
    pub(super) fn read(&self, folder: Option<&Path>, budget: &mut Budget) -> Result<Vec<u8>, String> {
        let folder = folder.ok_or_else(|| "no folder was given to look for it".to_owned())?;
        read_regular_file(&folder.join(&self.0), None, &|| self.spoken(), budget)
            .map_err(|why| why.to_string())
    }

    /// Returns the full path.
    pub(super) fn path(&self, folder: Option<&Path>) -> Option<PathBuf> {
        Some(folder?.join(&self.0))
    }

    /// Returns `true` if the file exists.
    pub(super) fn exists(&self, folder: Option<&Path>) -> bool {
        folder.is_some_and(|folder| folder.join(&self.0).is_file())
    }

    /// Returns the path for messages: with `/` on every system, and truncated if it is very long.
    pub(super) fn spoken(&self) -> String {
        const LONGEST: usize = 120;
        let path = self.0.to_string_lossy().replace('\\', "/");
        match path.char_indices().nth(LONGEST) {
            Some((end, _)) => format!("{}…", &path[..end]),
            None => path,
        }
    }
}

/// Resolves a path relative to a folder; `None` if it leaves the root folder or ends in it.
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

/// Returns the file name without folders, or a placeholder if there is none.
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
        let here = InnerPath::of("materials/a.mtl", &InnerPath::default());
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
            assert_eq!(InnerPath::of(name, &here).spoken(), means, "{name}");
        }
        assert_eq!(InnerPath::of("../a.mtl", &InnerPath::default()).spoken(), "a.mtl");
    }
}
