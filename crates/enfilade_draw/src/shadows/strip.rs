//! The samples that a light may reach, with a tree of boxes.

use super::volume::{Part, Volume};
use crate::face::Rays;
use crate::lamps::PassageLight;
use crate::painter::Paint;
use crate::pending::PendingSpan;
use glam::{DVec3, Vec3};
use smallvec::SmallVec;

/// Columns and rows of a block.
const BLOCK: u16 = 8;
/// Displayed value of light that is too weak to be worth a test for shadows: a quarter of a step of the picture.
const NEGLIGIBLE: f32 = 1.0 / 1024.0;
/// How far behind a face a sample must be to be in its shadow, relative to the distances of samples from the eye, which are
/// rounded to f32.
const BEHIND: f64 = 1e-5;

/// A box around samples, relative to the eye.
#[derive(Clone, Copy)]
pub(super) struct Bounds {
    min: Vec3,
    max: Vec3,
}

impl Bounds {
    const NONE: Bounds = Bounds {
        min: Vec3::INFINITY,
        max: Vec3::NEG_INFINITY,
    };

    fn with(&self, other: &Bounds) -> Bounds {
        Bounds {
            min: self.min.min(other.min),
            max: self.max.max(other.max),
        }
    }

    pub(super) fn around(boxes: impl IntoIterator<Item = Bounds>) -> Bounds {
        boxes
            .into_iter()
            .fold(Bounds::NONE, |sum, bounds| sum.with(&bounds))
    }

    pub(super) fn middle(&self) -> DVec3 {
        0.5 * (self.min.as_dvec3() + self.max.as_dvec3())
    }

    pub(super) fn half(&self) -> DVec3 {
        0.5 * (self.max.as_dvec3() - self.min.as_dvec3())
    }
}

/// Maximum number of samples of a block.
const SAMPLES: usize = (BLOCK * BLOCK) as usize;

/// Samples that are near each other.
struct Block {
    middle: DVec3,
    /// Positions relative to the middle, axis by axis; NaN beyond the last.
    points: [[f32; SAMPLES]; 3],
    /// Their places among the samples of the strip.
    samples: SmallVec<[u32; SAMPLES]>,
    /// One bit for each that is not in shadow yet.
    lit: u64,
}

impl Block {
    fn of(points: &[(u32, u32, Vec3)]) -> (Block, Bounds) {
        let bounds = Bounds::around(points.iter().map(|&(_, _, point)| Bounds {
            min: point,
            max: point,
        }));
        let middle = bounds.middle();
        let mut axes = [[f32::NAN; SAMPLES]; 3];
        for (place, (_, _, point)) in points.iter().enumerate() {
            let off = (point.as_dvec3() - middle).as_vec3();
            (0..3).for_each(|axis| axes[axis][place] = off[axis]);
        }
        let block = Block {
            middle,
            points: axes,
            samples: points.iter().map(|point| point.1).collect(),
            lit: u64::MAX >> (SAMPLES - points.len()),
        };
        (block, bounds)
    }

    /// Returns one bit for each sample in a volume.
    fn inside(&self, volume: &Volume, behind: f64) -> u64 {
        // The least signed distance from any plane.
        let mut least = [f32::INFINITY; SAMPLES];
        let [x, y, z] = &self.points;
        for (number, &(normal, distance)) in volume.planes.iter().enumerate() {
            let slack = if number == 0 { behind } else { 0.0 };
            let scale = 1.0 / normal.abs().max_element().max(f64::MIN_POSITIVE);
            let at_middle = ((normal.dot(self.middle) - distance - slack) * scale) as f32;
            let normal = (normal * scale).as_vec3();
            for i in 0..SAMPLES {
                let at = at_middle + normal.x * x[i] + normal.y * y[i] + normal.z * z[i];
                // Not `min`, which would leave out NaN.
                least[i] = if at >= least[i] { least[i] } else { at };
            }
        }
        least
            .iter()
            .enumerate()
            .fold(0, |bits, (i, &least)| bits | u64::from(least >= 0.0) << i)
    }

    fn point(&self, place: usize) -> DVec3 {
        let [x, y, z] = [0, 1, 2].map(|axis| f64::from(self.points[axis][place]));
        self.middle + DVec3::new(x, y, z)
    }
}

/// The samples of some bands of rows that a light may reach: blocks of them, and a tree over the blocks.
pub(super) struct Strip {
    /// How far behind a face a sample must be to be in its shadow.
    behind: f64,
    blocks: Vec<Block>,
    /// Boxes of the blocks, then of four blocks each, then of four of those, up to a single one. Empty without samples.
    pub(super) levels: Vec<Vec<Bounds>>,
    /// One bit per sample of the strip; each band begins a word.
    pub(super) shadow: Vec<u64>,
    /// Where the words of each band begin, and the end of the last.
    pub(super) words: Vec<usize>,
}

impl Strip {
    pub(super) fn of(
        bands: &[&[PendingSpan]],
        (number, light): (u16, &PassageLight),
        exposure: f32,
        rays: &Rays,
        paints: &[Paint],
    ) -> Strip {
        let mut points: Vec<(u32, u32, Vec3)> = Vec::new();
        let mut words = vec![0];
        for spans in bands {
            let mut sample = words[words.len() - 1] as u32 * 64;
            for span in *spans {
                let first = sample;
                sample += u32::from(span.x1 - span.x0);
                let Paint::Varied(face) = &paints[span.owner as usize] else {
                    continue;
                };
                if !face.lights.iter().any(|&(of, _)| of == number) {
                    continue;
                }
                let facing = face.facing.row(span.y);
                let slopes = [facing.right, facing.down];
                points.extend((span.x0..span.x1).zip(first..).filter_map(|(x, sample)| {
                    let per_facing = 1.0 / facing.at(f32::from(x));
                    let (point, _) = rays.point(face, [x, span.y], per_facing, slopes);
                    let block = interleaved([x, span.y].map(|at| at / BLOCK));
                    let counts = point.is_finite() && light.at_most(point) * exposure > NEGLIGIBLE;
                    counts.then_some((block, sample, point))
                }));
            }
            words.push((sample as usize).div_ceil(64));
        }
        points.sort_by_key(|&(block, ..)| block);
        let blocks = points.chunk_by(|a, b| a.0 == b.0);
        let (blocks, bounds): (Vec<Block>, Vec<Bounds>) = blocks
            .flat_map(|here| here.chunks(SAMPLES))
            .map(Block::of)
            .unzip();
        let mut levels = Vec::new();
        let mut level = bounds;
        while !level.is_empty() {
            let above = match level.len() {
                1 => Vec::new(),
                _ => level
                    .chunks(4)
                    .map(|four| Bounds::around(four.iter().copied()))
                    .collect(),
            };
            levels.push(std::mem::replace(&mut level, above));
        }
        let bounds = levels.last().map_or(Bounds::NONE, |top| top[0]);
        let farthest = bounds.min.abs().max(bounds.max.abs()).length();
        Strip {
            behind: BEHIND * f64::from(farthest),
            blocks,
            levels,
            shadow: vec![0; words[words.len() - 1]],
            words,
        }
    }

    pub(super) fn bounds(&self) -> Bounds {
        self.levels.last().map_or(Bounds::NONE, |top| top[0])
    }

    /// Marks the samples in a volume that are below a node of the tree.
    pub(super) fn darken(&mut self, volume: &Volume, light: &PassageLight, level: usize, number: usize) {
        let part = volume.part(&self.levels[level][number], self.behind);
        if matches!(part, Part::None) {
            return;
        }
        if matches!(part, Part::All) {
            let width = 4_usize.pow(level as u32);
            let end = (width * (number + 1)).min(self.blocks.len());
            for block in &mut self.blocks[width * number..end] {
                mark(&mut self.shadow, block, block.lit);
            }
        } else if level > 0 {
            let below = self.levels[level - 1].len();
            for child in 4 * number..(4 * number + 4).min(below) {
                self.darken(volume, light, level - 1, child);
            }
        } else if self.blocks[number].lit != 0 {
            let block = &mut self.blocks[number];
            let mut dark = block.inside(volume, self.behind) & block.lit;
            if let Some(cutout) = &volume.cutout {
                for place in 0..block.samples.len() {
                    let is_dark = dark >> place & 1 == 1;
                    if is_dark && !cutout.is_opaque_at(volume.entry(block.point(place), light)) {
                        dark &= !(1 << place);
                    }
                }
            }
            mark(&mut self.shadow, block, dark);
        }
    }
}

/// Marks samples of a block as in shadow.
fn mark(shadow: &mut [u64], block: &mut Block, dark: u64) {
    let mut rest = dark;
    while rest != 0 {
        let sample = block.samples[rest.trailing_zeros() as usize] as usize;
        shadow[sample / 64] |= 1 << (sample % 64);
        rest &= rest - 1;
    }
    block.lit &= !dark;
}

/// Returns the bits of two numbers in turn, so that neighbours in both have numbers near each other.
fn interleaved(at: [u16; 2]) -> u32 {
    let spread = |value: u16| (0..16).fold(0, |sum, bit| sum | (u32::from(value) >> bit & 1) << (2 * bit));
    spread(at[0]) | spread(at[1]) << 1
}
