//! Regions of a horizontal slice: the parts of its free space, separated where it narrows.
//!
//! Computes the distance to the nearest solid voxel and floods from the peaks of that distance downwards. Where two
//! basins meet, the distance is that of the saddle: half the width of the narrowest passage between them. Basins with a
//! passage almost as wide as the smaller of them are one region.
//! Source: distance: Felzenszwalb, Huttenlocher, Distance Transforms of Sampled Functions, Theory of Computing 2012;
//!     flooding: Vincent, Soille, Watersheds in Digital Spaces, PAMI 1991; rooms as watershed basins of a distance
//!     field: Haumont, Debeir, Sillion, Volumetric Cell-and-Portal Generation, Eurographics 2003.
//! Cost: O(voxels of the slice).

use super::merge::Sets;
use std::collections::VecDeque;

/// Label of a voxel that is in no region.
pub(super) const NONE: u32 = u32::MAX;

/// Basins are joined if the distance at the saddle is at least this share of that at the smaller peak.
const WIDE: f64 = 0.9;

/// They are also joined if the two differ by less than this, in voxels: rounding of the distance.
const ROUNDING: f64 = 0.9;

/// Buffers for slices of one size.
pub(super) struct SliceFlood {
    /// Columns and rows.
    size: [usize; 2],
    /// Maximum distance that is measured, in voxels.
    cap: usize,
    /// Square of the distance to the nearest solid voxel, in voxels.
    distance: Vec<u16>,
    /// Voxels with a distance above zero, farthest first.
    order: Vec<u32>,
    queue: VecDeque<u32>,
    basins: Sets,
    /// Squared distance at the peak of each basin.
    peaks: Vec<u16>,
}

/// A region of a slice.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Region {
    /// Number of voxels.
    pub(super) area: u32,
    /// Maximum distance to the nearest solid voxel, in voxels.
    pub(super) peak: f64,
}

impl SliceFlood {
    pub(super) fn new(size: [usize; 2], cap: usize) -> SliceFlood {
        // Squares fit 16 bits.
        let cap = cap.clamp(1, 250);
        SliceFlood {
            size,
            cap,
            distance: vec![0; size[0] * size[1]],
            order: Vec::new(),
            queue: VecDeque::new(),
            basins: Sets::default(),
            peaks: Vec::new(),
        }
    }

    /// Labels the voxels of a slice by region, counted from 0; solid ones get [`NONE`].
    pub(super) fn label(&mut self, is_solid: impl Fn(usize) -> bool, labels: &mut [u32]) -> Vec<Region> {
        labels.fill(NONE);
        self.measure(is_solid);
        self.sort();
        self.basins.clear();
        self.peaks.clear();
        let mut start = 0;
        while let Some(&first) = self.order.get(start) {
            let level = self.distance[first as usize];
            let same = self.order[start..]
                .iter()
                .take_while(|&&voxel| self.distance[voxel as usize] == level);
            let end = start + same.count();
            self.flood(level, start..end, labels);
            start = end;
        }
        self.regions(labels)
    }

    /// Computes the squared distances.
    fn measure(&mut self, is_solid: impl Fn(usize) -> bool) {
        let [columns, rows] = self.size;
        let cap = self.cap as u32;
        // Along rows: the distance to the nearest solid voxel of the row, by two sweeps.
        for (row, distances) in self.distance.chunks_mut(columns).enumerate() {
            let mut run = cap;
            for (column, distance) in distances.iter_mut().enumerate() {
                run = if is_solid(row * columns + column) {
                    0
                } else {
                    (run + 1).min(cap)
                };
                *distance = (run * run) as u16;
            }
            run = cap;
            for distance in distances.iter_mut().rev() {
                run = if *distance == 0 { 0 } else { (run + 1).min(cap) };
                *distance = (*distance).min((run * run) as u16);
            }
        }
        // Along columns: the lower envelope of parabolas.
        let most = (cap * cap) as u16;
        let mut own = vec![0_i64; rows];
        let mut vertices: Vec<usize> = Vec::with_capacity(rows);
        let mut starts: Vec<f64> = Vec::with_capacity(rows);
        for column in 0..columns {
            for (row, own) in own.iter_mut().enumerate() {
                *own = i64::from(self.distance[row * columns + column]);
            }
            if own.iter().all(|&own| own == i64::from(most)) {
                continue;
            }
            let height = |row: usize| own[row] + (row * row) as i64;
            vertices.clear();
            starts.clear();
            for row in 0..rows {
                let mut start = f64::NEG_INFINITY;
                while let (Some(&last), Some(&begin)) = (vertices.last(), starts.last()) {
                    start = (height(row) - height(last)) as f64 / (2 * (row - last)) as f64;
                    if start > begin {
                        break;
                    }
                    vertices.pop();
                    starts.pop();
                    start = f64::NEG_INFINITY;
                }
                vertices.push(row);
                starts.push(start);
            }
            let mut lowest = 0;
            for row in 0..rows {
                while starts.get(lowest + 1).is_some_and(|&start| start < row as f64) {
                    lowest += 1;
                }
                let away = row as i64 - vertices[lowest] as i64;
                let squared = away * away + own[vertices[lowest]];
                self.distance[row * columns + column] = squared.min(i64::from(most)) as u16;
            }
        }
    }

    /// Sorts the voxels that are not solid, farthest first; those of one distance by number.
    fn sort(&mut self) {
        let most = self.cap * self.cap;
        let mut starts = vec![0_u32; most + 2];
        for &distance in self.distance.iter().filter(|&&distance| distance > 0) {
            starts[most - usize::from(distance) + 1] += 1;
        }
        for place in 1..starts.len() {
            starts[place] += starts[place - 1];
        }
        self.order.clear();
        self.order.resize(starts[most + 1] as usize, 0);
        for (voxel, &distance) in self
            .distance
            .iter()
            .enumerate()
            .filter(|(_, distance)| **distance > 0)
        {
            let start = &mut starts[most - usize::from(distance)];
            self.order[*start as usize] = voxel as u32;
            *start += 1;
        }
    }

    /// Labels the voxels of one distance, by basin.
    fn flood(&mut self, level: u16, range: std::ops::Range<usize>, labels: &mut [u32]) {
        for place in range.clone() {
            let voxel = self.order[place];
            let neighbours = neighbours(self.size, voxel);
            if neighbours.clone().any(|next| labels[next as usize] != NONE) {
                self.queue.push_back(voxel);
            }
        }
        self.spread(level, labels);
        for place in range {
            let voxel = self.order[place];
            if labels[voxel as usize] == NONE {
                let basin = self.basins.add();
                self.peaks.push(level);
                labels[voxel as usize] = basin;
                let same = |next: &u32| self.distance[*next as usize] == level;
                self.queue.extend(neighbours(self.size, voxel).filter(same));
                self.spread(level, labels);
            }
        }
    }

    /// Labels the queued voxels, and all of the same distance that they reach, by the neighbour with the greatest
    /// distance; joins basins that meet.
    fn spread(&mut self, level: u16, labels: &mut [u32]) {
        while let Some(voxel) = self.queue.pop_front() {
            if labels[voxel as usize] != NONE {
                continue;
            }
            let around = neighbours(self.size, voxel);
            let nearest = around
                .clone()
                .filter(|&next| labels[next as usize] != NONE)
                .min_by_key(|&next| std::cmp::Reverse(self.distance[next as usize]));
            let Some(nearest) = nearest else { continue };
            let mut basin = self.basins.find(labels[nearest as usize]);
            labels[voxel as usize] = basin;
            for next in around {
                if labels[next as usize] == NONE {
                    if self.distance[next as usize] == level {
                        self.queue.push_back(next);
                    }
                    continue;
                }
                let other = self.basins.find(labels[next as usize]);
                if other == basin {
                    continue;
                }
                let peaks = [basin, other].map(|basin| self.peaks[basin as usize]);
                let smaller = f64::from(peaks[0].min(peaks[1])).sqrt();
                let saddle = f64::from(level).sqrt();
                if saddle >= WIDE * smaller || smaller - saddle < ROUNDING {
                    let [kept, gone] = if peaks[0] >= peaks[1] {
                        [basin, other]
                    } else {
                        [other, basin]
                    };
                    self.basins.join(kept, gone);
                    basin = kept;
                }
            }
        }
    }

    /// Renumbers basins as regions.
    fn regions(&mut self, labels: &mut [u32]) -> Vec<Region> {
        let mut regions = Vec::new();
        let mut region_of = vec![NONE; self.peaks.len()];
        for label in labels.iter_mut().filter(|label| **label != NONE) {
            let basin = self.basins.find(*label) as usize;
            if region_of[basin] == NONE {
                region_of[basin] = regions.len() as u32;
                regions.push(Region {
                    area: 0,
                    peak: f64::from(self.peaks[basin]).sqrt(),
                });
            }
            *label = region_of[basin];
            regions[*label as usize].area += 1;
        }
        regions
    }
}

/// Returns the neighbours of a voxel in its slice: up to four.
fn neighbours([columns, rows]: [usize; 2], voxel: u32) -> impl Iterator<Item = u32> + Clone {
    let columns = columns as u32;
    let [column, row] = [voxel % columns, voxel / columns];
    let left = (column > 0).then(|| voxel - 1);
    let right = (column + 1 < columns).then_some(voxel + 1);
    let above = (row > 0).then(|| voxel - columns);
    let below = (row + 1 < rows as u32).then_some(voxel + columns);
    [left, right, above, below].into_iter().flatten()
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Labels a plan in which `#` is solid, and returns the number of regions and the label of each letter.
    fn regions(plan: &str) -> (usize, Vec<(char, u32)>) {
        let rows: Vec<&str> = plan.split_whitespace().collect();
        let size = [rows[0].len(), rows.len()];
        let cells: Vec<char> = rows.iter().flat_map(|row| row.chars()).collect();
        let mut labels = vec![0; cells.len()];
        let found = SliceFlood::new(size, 40).label(|voxel| cells[voxel] == '#', &mut labels);
        let letters = cells.iter().zip(&labels).filter(|(cell, _)| cell.is_alphabetic());
        (
            found.len(),
            letters.map(|(&cell, &label)| (cell, label)).collect(),
        )
    }

    #[test]
    fn a_narrow_door_separates_two_rooms() {
        let (count, letters) = regions(
            "###################
             #........#........#
             #........#........#
             #........#........#
             #...a.........b...#
             #........#........#
             #........#........#
             #........#........#
             ###################",
        );
        assert_eq!(count, 2);
        assert_ne!(letters[0].1, letters[1].1);
    }

    #[test]
    fn a_corridor_is_one_region() {
        let (count, _) = regions(
            "##############################
             #............................#
             #............................#
             #............................#
             #............................#
             ##########################...#
             #########################....#
             #########################....#
             #########################....#
             ##############################",
        );
        assert_eq!(count, 1);
    }

    #[test]
    fn distances_are_those_of_the_nearest_solid_voxel() {
        let mut random = fastrand::Rng::with_seed(3);
        for _ in 0..100 {
            let size = [random.usize(1..24), random.usize(1..24)];
            let solid: Vec<bool> = (0..size[0] * size[1]).map(|_| random.u8(..) < 20).collect();
            let mut flood = SliceFlood::new(size, 9);
            flood.measure(|voxel| solid[voxel]);
            for (voxel, &distance) in flood.distance.iter().enumerate() {
                let away = |other: usize| {
                    let across = (voxel % size[0]).abs_diff(other % size[0]);
                    let down = (voxel / size[0]).abs_diff(other / size[0]);
                    across * across + down * down
                };
                let nearest = (0..solid.len()).filter(|&other| solid[other]).map(away).min();
                assert_eq!(usize::from(distance), nearest.unwrap_or(81).min(81));
            }
        }
    }
}
