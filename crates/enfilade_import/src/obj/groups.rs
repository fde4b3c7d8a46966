//! Which faces make which item: a line `o` or `g` begins one.

use super::parse::{Faces, Mark, What};
use crate::BrokenRule;
use crate::budget::Budget;
use std::collections::{HashMap, HashSet};
use std::num::NonZeroU32;
use std::ops::Range;

/// An item in the making.
#[derive(Debug)]
pub(super) struct Group {
    /// No other item of the file has it.
    pub(super) name: String,
    pub(super) runs: Vec<Run>,
}

/// Faces that follow each other and have everything in common.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Run {
    /// Which piece of the text.
    pub(super) piece: usize,
    /// Which of its faces.
    pub(super) faces: Range<usize>,
    /// A place in [`Groups::materials`]; `None` where the file names none.
    pub(super) material: Option<usize>,
    pub(super) smooth: Option<NonZeroU32>,
}

/// What the marks between faces come to.
#[derive(Debug, Default)]
pub(super) struct Groups {
    /// Those that have faces, in order.
    pub(super) groups: Vec<Group>,
    /// Names of those materials that faces are made of, in the order of their first use.
    pub(super) materials: Vec<String>,
    /// What lines `mtllib` say, in order and each once.
    pub(super) libraries: Vec<String>,
}

/// What the standard calls faces that stand before any group, or in one without a name.
const UNNAMED: &str = "default";
/// About what a run takes, its group included.
const BYTES_PER_RUN: u64 = 500;

impl Groups {
    /// Goes through all marks in order.
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

    /// Are there faces in a smoothing group?
    pub(super) fn any_smooth(&self) -> bool {
        let runs = self.groups.iter().flat_map(|group| &group.runs);
        runs.into_iter().any(|run| run.smooth.is_some())
    }
}

/// What holds where the walk is.
#[derive(Default)]
struct Walk<'a> {
    found: Groups,
    /// How the group is called that faces now go to; empty for the one without a name.
    name: &'a str,
    /// Has it a face?
    begun: bool,
    material: Option<&'a str>,
    smooth: Option<NonZeroU32>,
    numbers: HashMap<&'a str, usize>,
    seen: HashSet<&'a str>,
}

impl<'a> Walk<'a> {
    fn mark(&mut self, what: &'a What) {
        match what {
            // Some programs repeat the name with every material.
            What::Group(name) => {
                self.begun &= *name == self.name;
                self.name = name;
            }
            What::Material(name) => self.material = Some(name),
            What::Smooth(number) => self.smooth = *number,
            What::Libraries(files) => {
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
        let group = self.found.groups.last_mut().expect("one was begun");
        group.runs.push(Run {
            piece,
            faces,
            material,
            smooth: self.smooth,
        });
    }
}

/// Sets its number behind the name of each group that shares it, as names of glTF nodes are told apart.
///
/// Two names that end in numbers differ there. So a made name can only be that of a group which has its name for itself;
/// then the number is set behind it once more.
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
