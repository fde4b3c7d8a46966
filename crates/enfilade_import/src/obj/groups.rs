//! Groups the faces into items: a line `o` or `g` begins one.

use super::parse::{Faces, Mark, Statement};
use crate::BrokenRule;
use crate::budget::Budget;
use std::collections::{HashMap, HashSet};
use std::num::NonZeroU32;
use std::ops::Range;

/// The faces of an item.
#[derive(Debug)]
pub(super) struct Group {
    /// Unique in the file.
    pub(super) name: String,
    pub(super) runs: Vec<Run>,
}

/// Consecutive faces with the same material and smoothing group.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Run {
    /// Index of the text chunk.
    pub(super) piece: usize,
    /// Indices of its faces.
    pub(super) faces: Range<usize>,
    /// Index into [`Groups::materials`]; `None` if the file specifies no material.
    pub(super) material: Option<usize>,
    pub(super) smooth: Option<NonZeroU32>,
}

/// The groups, materials and material files of a text.
#[derive(Debug, Default)]
pub(super) struct Groups {
    /// Groups with faces, in order.
    pub(super) groups: Vec<Group>,
    /// Names of used materials, in the order of their first use.
    pub(super) materials: Vec<String>,
    /// Arguments of `mtllib` lines, in order and without duplicates.
    pub(super) libraries: Vec<String>,
}

/// Name of faces before any group, or in one without a name, as defined by the standard.
const UNNAMED: &str = "default";
/// Approximate memory of a run, including its group.
const BYTES_PER_RUN: u64 = 500;

impl Groups {
    /// Applies all state statements in order.
    pub(super) fn of(pieces: &[Faces], budget: &mut Budget) -> Result<Groups, BrokenRule> {
        let marks = pieces.iter().flat_map(|faces| &faces.marks);
        let needs = |mark: &Mark| BYTES_PER_RUN + 3 * mark.what.name().len() as u64;
        let needs = marks.map(needs).sum::<u64>() + BYTES_PER_RUN * pieces.len() as u64;
        budget.take(needs, || "the groups".to_owned())?;
        let mut walk = Walk::default();
        for (piece, faces) in pieces.iter().enumerate() {
            let mut done = 0;
            for mark in &faces.marks {
                walk.run(piece, done..mark.face);
                done = mark.face;
                walk.mark(&mark.what);
            }
            walk.run(piece, done..faces.ends.len());
        }
        let mut found = walk.found;
        tell_apart(&mut found.groups);
        Ok(found)
    }

    /// Returns `true` if any face is in a smoothing group.
    pub(super) fn any_smooth(&self) -> bool {
        let runs = self.groups.iter().flat_map(|group| &group.runs);
        runs.into_iter().any(|run| run.smooth.is_some())
    }
}

/// State while the statements are applied.
#[derive(Default)]
struct Walk<'a> {
    found: Groups,
    /// Name of the current group; empty for the unnamed group.
    name: &'a str,
    /// Whether the current group has a face.
    begun: bool,
    material: Option<&'a str>,
    smooth: Option<NonZeroU32>,
    numbers: HashMap<&'a str, usize>,
    seen: HashSet<&'a str>,
}

impl<'a> Walk<'a> {
    fn mark(&mut self, what: &'a Statement) {
        match what {
            // Some programs repeat the group name with every material.
            Statement::Group(name) => {
                self.begun &= *name == self.name;
                self.name = name;
            }
            Statement::Material(name) => self.material = Some(name),
            Statement::Smooth(number) => self.smooth = *number,
            Statement::Libraries(files) => {
                if self.seen.insert(files) {
                    self.found.libraries.push(files.to_string());
                }
            }
        }
    }

    fn run(&mut self, piece: usize, faces: Range<usize>) {
        if faces.is_empty() {
            return;
        }
        if !std::mem::replace(&mut self.begun, true) {
            let name = if self.name.is_empty() { UNNAMED } else { self.name };
            self.found.groups.push(Group {
                name: name.to_owned(),
                runs: Vec::new(),
            });
        }
        let materials = &mut self.found.materials;
        let material = self.material.map(|name| {
            *self.numbers.entry(name).or_insert_with(|| {
                materials.push(name.to_owned());
                materials.len() - 1
            })
        });
        let group = self
            .found
            .groups
            .last_mut()
            .expect("the current group was added above");
        group.runs.push(Run {
            piece,
            faces,
            material,
            smooth: self.smooth,
        });
    }
}

/// Makes group names unique: appends its index to the name of each group that shares it, as for glTF nodes.
///
/// Generated names differ by their index. So a generated name can only collide with the unique name of another group;
/// then the index is appended again.
fn tell_apart(groups: &mut [Group]) {
    let mut bearers: HashMap<String, u32> = HashMap::new();
    for group in &*groups {
        *bearers.entry(group.name.clone()).or_default() += 1;
    }
    for (number, group) in groups.iter_mut().enumerate() {
        if bearers[&group.name] == 1 {
            continue;
        }
        loop {
            group.name = format!("{}#{number}", group.name);
            if bearers.get(&group.name) != Some(&1) {
                break;
            }
        }
    }
}
