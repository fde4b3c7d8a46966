//! Joins the regions of all slices to rooms.
//!
//! Regions of neighbouring slices that overlap by more than half are one stack, so a room is bounded by its walls, and
//! above and below by slabs, or by where its outline changes. In three dimensions at once, a building without slabs would
//! be one room: ceilings are often left out of files. Stacks too small for a room are joined to the neighbour with the
//! widest contact; then neighbours with a contact as wide as the smaller of them are joined, so that columns do not
//! split a hall.
//! Cost: O(voxels), and O(contacts log contacts).

use super::RoomOptions;
use super::grid::Grid;
use super::merge::Sets;
use super::slice::{NONE, Region, SliceFlood};
use rayon::prelude::*;
use std::collections::{BTreeMap, BTreeSet, HashMap};

/// Maximum distance to walls that is measured, in metres: wider halls have one region.
const CAP: f64 = 4.0;

/// Regions of neighbouring slices are one stack if the overlap is more than this share of their union.
const OVERLAP: f64 = 0.5;

/// Labels of voxels, by room.
pub(super) struct Labels {
    /// The room of each voxel that is free: [`NONE`] for solid ones and voids.
    pub(super) rooms: Vec<u32>,
    pub(super) count: usize,
    /// The room that reaches the border of the grid: the exterior.
    pub(super) outside: u32,
}

/// A stack of regions, or several that were joined.
#[derive(Clone, Copy, Debug)]
struct Stack {
    /// Number of voxels.
    volume: u64,
    /// First and last slice.
    slices: [u32; 2],
    /// Maximum distance to the nearest solid voxel, in voxels.
    peak: f64,
}

/// Number of open faces between the voxels of two stacks: sideways and upwards.
#[derive(Clone, Copy, Debug, Default)]
struct Contact {
    beside: u64,
    above: u64,
}

/// Contacts between regions, by their numbers: the lower region first if one is above the other.
type Contacts = Vec<((u32, u32), u32)>;

/// Finds the rooms among the voxels that are not solid.
pub(super) fn find(grid: &Grid, is_solid: impl Fn(usize) -> bool + Sync, options: &RoomOptions) -> Labels {
    let slice_len = grid.slice_len();
    let mut labels = vec![NONE; grid.len()];
    let size = [grid.size[0], grid.size[2]];
    let cap = (CAP / grid.step).round() as usize;
    let slices: Vec<Vec<Region>> = labels
        .par_chunks_mut(slice_len)
        .enumerate()
        .map_init(
            || SliceFlood::new(size, cap),
            |flood, (slice, labels)| flood.label(|voxel| is_solid(slice * slice_len + voxel), labels),
        )
        .collect();
    // Numbers regions over all slices.
    let mut first = 0;
    let firsts: Vec<u32> = slices
        .iter()
        .map(|regions| {
            let start = first;
            first += regions.len() as u32;
            start
        })
        .collect();
    labels
        .par_chunks_mut(slice_len)
        .zip(&firsts)
        .for_each(|(labels, &first)| {
            for label in labels.iter_mut().filter(|label| **label != NONE) {
                *label += first;
            }
        });
    let regions: Vec<(u32, Region)> = slices
        .iter()
        .enumerate()
        .flat_map(|(slice, regions)| regions.iter().map(move |&region| (slice as u32, region)))
        .collect();
    let (above, beside) = contacts(grid, &labels);
    let mut sets = Sets::new(regions.len());
    for &((lower, upper), overlap) in above.iter().flatten() {
        let areas = [lower, upper].map(|region| regions[region as usize].1.area);
        if f64::from(overlap) > OVERLAP * f64::from(areas[0] + areas[1] - overlap) {
            let [one, other] = [lower, upper].map(|region| sets.find(region));
            if one != other {
                sets.join(one.min(other), one.max(other));
            }
        }
    }
    let outside = join_border(grid, &labels, &mut sets);
    let mut stacks = Stacks::new(grid, &regions, &mut sets, outside);
    stacks.add_contacts(&above, &mut sets, |contact, faces| contact.above += faces);
    stacks.add_contacts(&beside, &mut sets, |contact, faces| contact.beside += faces);
    stacks.join_small(options, &mut sets);
    stacks.join_wide(options, &mut sets);
    stacks.number(labels, &mut sets)
}

/// Counts the faces between regions of each slice and the next, and between regions of a slice.
fn contacts(grid: &Grid, labels: &[u32]) -> (Vec<Contacts>, Vec<Contacts>) {
    let slice_len = grid.slice_len();
    let [columns, slices, rows] = grid.size;
    let of_slice = |slice: usize| {
        let here = &labels[slice * slice_len..][..slice_len];
        let mut above = Counter::default();
        if slice + 1 < slices {
            let next = &labels[(slice + 1) * slice_len..][..slice_len];
            for (&lower, &upper) in here.iter().zip(next) {
                if lower != NONE && upper != NONE {
                    above.add((lower, upper));
                }
            }
        }
        let mut beside = Counter::default();
        for voxel in 0..slice_len {
            let one = here[voxel];
            let mut meet = |other: u32| {
                if one != NONE && other != NONE && one != other {
                    beside.add((one.min(other), one.max(other)));
                }
            };
            if voxel % columns + 1 < columns {
                meet(here[voxel + 1]);
            }
            if voxel / columns + 1 < rows {
                meet(here[voxel + columns]);
            }
        }
        (above.sorted(), beside.sorted())
    };
    (0..slices).into_par_iter().map(of_slice).unzip()
}

/// Counts pairs; runs of the same pair are quick.
#[derive(Default)]
struct Counter {
    counts: HashMap<(u32, u32), u32>,
    last: (u32, u32),
    run: u32,
}

impl Counter {
    fn add(&mut self, pair: (u32, u32)) {
        if pair != self.last {
            self.flush();
            self.last = pair;
        }
        self.run += 1;
    }

    fn flush(&mut self) {
        if self.run > 0 {
            *self.counts.entry(self.last).or_default() += self.run;
            self.run = 0;
        }
    }

    fn sorted(mut self) -> Contacts {
        self.flush();
        let mut sorted: Contacts = self.counts.into_iter().collect();
        sorted.sort_unstable();
        sorted
    }
}

/// Joins the regions at the border of the grid, and returns their representative.
fn join_border(grid: &Grid, labels: &[u32], sets: &mut Sets) -> Option<u32> {
    let [columns, slices, rows] = grid.size;
    let mut outside = None;
    for slice in 0..slices {
        let mut visit = |x: usize, z: usize| {
            let label = labels[grid.index([x, slice, z])];
            if label == NONE {
                return;
            }
            let found = sets.find(label);
            match outside {
                None => outside = Some(found),
                Some(outside) if outside != found => sets.join(outside, found),
                Some(_) => {}
            }
        };
        let is_whole = slice == 0 || slice + 1 == slices;
        for z in 0..rows {
            let is_edge = is_whole || z == 0 || z + 1 == rows;
            let step = if is_edge { 1 } else { (columns - 1).max(1) };
            (0..columns).step_by(step).for_each(|x| visit(x, z));
        }
    }
    outside
}

/// The stacks that are left, and their contacts.
struct Stacks<'a> {
    grid: &'a Grid,
    /// By the representative of its regions.
    stacks: BTreeMap<u32, Stack>,
    contacts: HashMap<u32, BTreeMap<u32, Contact>>,
    outside: Option<u32>,
}

impl<'a> Stacks<'a> {
    fn new(grid: &'a Grid, regions: &[(u32, Region)], sets: &mut Sets, outside: Option<u32>) -> Stacks<'a> {
        let mut stacks = BTreeMap::new();
        for (number, &(slice, Region { area, peak })) in regions.iter().enumerate() {
            let stack = stacks.entry(sets.find(number as u32)).or_insert(Stack {
                volume: 0,
                slices: [slice; 2],
                peak: 0.0,
            });
            stack.add(&Stack {
                volume: area.into(),
                slices: [slice; 2],
                peak,
            });
        }
        Stacks {
            grid,
            stacks,
            contacts: HashMap::new(),
            outside,
        }
    }

    fn add_contacts(&mut self, found: &[Contacts], sets: &mut Sets, add: impl Fn(&mut Contact, u64)) {
        for &((one, other), faces) in found.iter().flatten() {
            let [one, other] = [one, other].map(|region| sets.find(region));
            if one != other {
                for (from, to) in [(one, other), (other, one)] {
                    let contact = self.contacts.entry(from).or_default().entry(to).or_default();
                    add(contact, faces.into());
                }
            }
        }
    }

    /// Joins `gone` to `kept`.
    fn join(&mut self, kept: u32, gone: u32, sets: &mut Sets) {
        sets.join(kept, gone);
        if let (Some(stack), Some(into)) = (self.stacks.remove(&gone), self.stacks.get_mut(&kept)) {
            into.add(&stack);
        }
        for (other, contact) in self.contacts.remove(&gone).unwrap_or_default() {
            if let Some(of_other) = self.contacts.get_mut(&other) {
                of_other.remove(&gone);
            }
            if other != kept {
                for (from, to) in [(kept, other), (other, kept)] {
                    let sum = self.contacts.entry(from).or_default().entry(to).or_default();
                    sum.beside += contact.beside;
                    sum.above += contact.above;
                }
            }
        }
    }

    /// Returns `true` if a stack is too small for a room.
    fn is_small(&self, stack: &Stack, options: &RoomOptions) -> bool {
        let step = self.grid.step;
        let height = f64::from(stack.slices[1] - stack.slices[0] + 1) * step;
        (stack.volume as f64) * step.powi(3) < options.min_volume
            || height < options.min_height
            || stack.peak * step < options.min_half_width
    }

    /// Joins small stacks, smallest first, to the neighbour with the most open faces. Those without neighbours are
    /// voids: gaps inside walls.
    fn join_small(&mut self, options: &RoomOptions, sets: &mut Sets) {
        let small = self
            .stacks
            .iter()
            .filter(|(_, stack)| self.is_small(stack, options));
        let mut small: BTreeSet<(u64, u32)> = small.map(|(&number, stack)| (stack.volume, number)).collect();
        while let Some((_, number)) = small.pop_first() {
            if Some(number) == self.outside {
                continue;
            }
            let neighbours = self.contacts.get(&number);
            let widest = neighbours.and_then(|neighbours| {
                neighbours.iter().max_by_key(|(other, contact)| {
                    (contact.above + contact.beside, std::cmp::Reverse(**other))
                })
            });
            let Some((&into, _)) = widest else {
                self.stacks.remove(&number);
                continue;
            };
            if let Some(before) = self.stacks.get(&into) {
                small.remove(&(before.volume, into));
            }
            self.join(into, number, sets);
            if let Some(stack) = self.stacks.get(&into)
                && self.is_small(stack, options)
            {
                small.insert((stack.volume, into));
            }
        }
    }

    /// Joins neighbours with a wide contact, widest first. The exterior is never joined.
    fn join_wide(&mut self, options: &RoomOptions, sets: &mut Sets) {
        loop {
            let mut widest: Option<(f64, u32, u32)> = None;
            for (&one, neighbours) in &self.contacts {
                for (&other, contact) in neighbours.range(one..) {
                    if [Some(one), Some(other)].contains(&self.outside) {
                        continue;
                    }
                    let width = self.width(one, other, contact);
                    // By number if two are equally wide: the order of a hash map is random.
                    let is_wider = widest.is_none_or(|(most, first, second)| {
                        width > most || (width == most && (one, other) < (first, second))
                    });
                    if width >= options.join_width && is_wider {
                        widest = Some((width, one, other));
                    }
                }
            }
            let Some((_, one, other)) = widest else { break };
            let volume = |number| self.stacks.get(&number).map_or(0, |stack| stack.volume);
            let (kept, gone) = if volume(one) >= volume(other) {
                (one, other)
            } else {
                (other, one)
            };
            self.join(kept, gone, sets);
        }
    }

    /// Returns the width of a contact relative to the extent of the smaller stack: 1 for the side of a cube.
    fn width(&self, one: u32, other: u32, contact: &Contact) -> f64 {
        let stacks = [one, other].map(|number| self.stacks.get(&number));
        let [Some(one), Some(other)] = stacks else {
            return 0.0;
        };
        let small = if one.volume <= other.volume { one } else { other };
        let height = f64::from(small.slices[1] - small.slices[0] + 1);
        let floor = small.volume as f64 / height;
        contact.beside as f64 / (floor.sqrt() * height)
    }

    /// Renumbers stacks as rooms, in order of their first regions.
    fn number(&self, mut labels: Vec<u32>, sets: &mut Sets) -> Labels {
        let room_of: HashMap<u32, u32> = self
            .stacks
            .keys()
            .zip(0..)
            .map(|(&stack, room)| (stack, room))
            .collect();
        let rooms: Vec<u32> = (0..sets.len() as u32)
            .map(|region| room_of.get(&sets.find(region)).copied().unwrap_or(NONE))
            .collect();
        labels
            .par_iter_mut()
            .filter(|label| **label != NONE)
            .for_each(|label| *label = rooms[*label as usize]);
        let outside = self.outside.and_then(|outside| room_of.get(&sets.find(outside)));
        Labels {
            rooms: labels,
            count: room_of.len(),
            outside: outside.copied().unwrap_or(NONE),
        }
    }
}

impl Stack {
    fn add(&mut self, other: &Stack) {
        self.volume += other.volume;
        self.slices = [
            self.slices[0].min(other.slices[0]),
            self.slices[1].max(other.slices[1]),
        ];
        self.peak = self.peak.max(other.peak);
    }
}

/// Grows the rooms into solid voxels and voids, until every voxel has the room that is nearest to it.
pub(super) fn grow(grid: &Grid, labels: &mut [u32]) {
    let mut front: Vec<u32> = (0..labels.len() as u32)
        .into_par_iter()
        .filter(|&voxel| {
            let mut is_at_border = false;
            if labels[voxel as usize] != NONE {
                grid.for_each_neighbour(voxel as usize, |next| is_at_border |= labels[next] == NONE);
            }
            is_at_border
        })
        .collect();
    let mut next_front = Vec::new();
    while !front.is_empty() {
        for &voxel in &front {
            let label = labels[voxel as usize];
            grid.for_each_neighbour(voxel as usize, |next| {
                if labels[next] == NONE {
                    labels[next] = label;
                    next_front.push(next as u32);
                }
            });
        }
        front.clear();
        std::mem::swap(&mut front, &mut next_front);
    }
}
