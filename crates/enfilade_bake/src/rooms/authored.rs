//! Rooms and doors that the author of a scene marked: they win over those that are found.

use super::doors::rectangle;
use super::graph::Door;
use super::grid::Grid;
use super::input::Metric;
use super::slice::NONE;
use super::stacks::Labels;
use rayon::prelude::*;
use std::collections::BTreeMap;

/// Rooms of a scene that are marked.
pub struct AuthoredRooms<'a> {
    /// Name of each room.
    pub names: Vec<&'a str>,
    /// Returns the room at a point in scene coordinates, by its index; `None` where none is marked.
    pub room_at: &'a (dyn Fn([f64; 3]) -> Option<u32> + Sync),
    /// Doors between them.
    pub doors: Vec<AuthoredDoor>,
}

/// A door that is marked.
#[derive(Clone, Debug, PartialEq)]
pub struct AuthoredDoor {
    /// Indices of the rooms on its two sides.
    pub rooms: [u32; 2],
    /// Its outline, in scene coordinates.
    pub outline: Vec<[f64; 3]>,
}

/// Names of rooms that are marked, by their new numbers; they come first.
pub(super) type Names = Vec<String>;

/// Replaces found rooms by marked ones where there are any.
pub(super) fn relabel(
    grid: &Grid,
    metric: &Metric,
    found: Labels,
    authored: &AuthoredRooms,
) -> (Labels, Names) {
    let Labels {
        rooms: mut labels,
        count,
        outside,
    } = found;
    let marked_at = |voxel: usize| {
        let room = (authored.room_at)(metric.scene(grid.center(voxel)));
        room.filter(|&room| (room as usize) < authored.names.len())
    };
    let votes = votes(&labels, count, marked_at);
    // The marked room of each voxel, as a number after those found.
    let first = count as u32;
    labels
        .par_iter_mut()
        .enumerate()
        .filter(|(_, label)| **label != NONE)
        .for_each(|(voxel, label)| {
            let marked = match votes[*label as usize] {
                Vote::Nobody => None,
                Vote::All(room) => Some(room),
                Vote::Mixed => marked_at(voxel),
            };
            if let Some(room) = marked {
                *label = first + room;
            }
        });
    let mut is_used = vec![false; count + authored.names.len()];
    labels
        .iter()
        .filter(|label| **label != NONE)
        .for_each(|&label| is_used[label as usize] = true);
    let marked = first..is_used.len() as u32;
    let used: Vec<u32> = marked
        .chain(0..first)
        .filter(|&label| is_used[label as usize])
        .collect();
    let mut number_of = vec![NONE; is_used.len()];
    for (number, &label) in (0..).zip(&used) {
        number_of[label as usize] = number;
    }
    labels
        .par_iter_mut()
        .filter(|label| **label != NONE)
        .for_each(|label| *label = number_of[*label as usize]);
    let outside = match votes.get(outside as usize) {
        Some(Vote::All(room)) => number_of[(first + room) as usize],
        Some(_) => number_of[outside as usize],
        None => NONE,
    };
    let names = used.iter().filter(|&&label| label >= first);
    let names = names
        .map(|&label| authored.names[(label - first) as usize].to_owned())
        .collect();
    let labels = Labels {
        rooms: labels,
        count: used.len(),
        outside,
    };
    (labels, names)
}

/// What the author says of a found room.
#[derive(Clone, Copy)]
enum Vote {
    Nobody,
    All(u32),
    Mixed,
}

/// Samples the marked rooms of each found room.
fn votes(labels: &[u32], count: usize, marked_at: impl Fn(usize) -> Option<u32> + Sync) -> Vec<Vote> {
    /// Voxels that are asked of each room.
    const SAMPLES: usize = 64;
    /// Share of them that must agree.
    const AGREED: f64 = 0.8;
    let mut sizes = vec![0_usize; count];
    labels
        .iter()
        .filter(|label| **label != NONE)
        .for_each(|&label| sizes[label as usize] += 1);
    let mut samples: Vec<Vec<usize>> = vec![Vec::new(); count];
    let mut seen = vec![0_usize; count];
    for (voxel, &label) in labels.iter().enumerate().filter(|(_, label)| **label != NONE) {
        let room = label as usize;
        if seen[room].is_multiple_of(sizes[room].div_ceil(SAMPLES)) {
            samples[room].push(voxel);
        }
        seen[room] += 1;
    }
    let vote = |samples: &Vec<usize>| {
        let mut counts: BTreeMap<Option<u32>, usize> = BTreeMap::new();
        samples
            .iter()
            .for_each(|&voxel| *counts.entry(marked_at(voxel)).or_default() += 1);
        match counts.iter().max_by_key(|(_, count)| **count) {
            Some((&most, &count)) if count as f64 >= AGREED * samples.len() as f64 => {
                most.map_or(Vote::Nobody, Vote::All)
            }
            Some(_) => Vote::Mixed,
            None => Vote::Nobody,
        }
    };
    samples.par_iter().map(vote).collect()
}

/// Gives doors that are near a marked one between the same rooms its outline.
pub(super) fn outline_doors(doors: &mut [Door], names: &Names, authored: &AuthoredRooms, metric: &Metric) {
    /// Distance in metres, on each axis, at which a found door is the marked one.
    const NEAR: f64 = 0.3;
    for marked in &authored.doors {
        let name = |side: usize| authored.names.get(marked.rooms[side] as usize).copied();
        let wanted = [name(0), name(1)];
        let [low, high] = [f64::min, f64::max].map(|pick| {
            [0, 1, 2].map(|axis| {
                marked
                    .outline
                    .iter()
                    .map(|at| at[axis])
                    .reduce(pick)
                    .unwrap_or(f64::NAN)
            })
        });
        let near = NEAR / metric.metres_per_unit;
        for door in doors.iter_mut() {
            let of = |side: usize| names.get(door.rooms[side].0 as usize).map(String::as_str);
            let found = [of(0), of(1)];
            let middle = door.middle();
            let is_there =
                (0..3).all(|axis| low[axis] - near <= middle[axis] && middle[axis] <= high[axis] + near);
            if is_there && (found == wanted || found == [wanted[1], wanted[0]]) {
                door.polygon = rectangle(&marked.outline, metric);
            }
        }
    }
}
