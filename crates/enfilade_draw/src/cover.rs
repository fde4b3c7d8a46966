//! Pictures of covers: what they know, by colour, and how near it is, by light.

use crate::palette::{distinct, dusk, encode};
use enfilade::{CoverShape, CoverSpan, HiddenBy};
use image::RgbImage;

/// What covers know of each sample.
pub(crate) struct CoverPicture {
    width: usize,
    samples: Vec<Known>,
    /// Goes up with each passage: their cells have the same numbers.
    passage: u32,
    shape: Option<CoverShape>,
}

#[derive(Clone, Copy, Default)]
struct Known {
    passage: u32,
    cell: u32,
    rev_depth: f32,
    shape: Option<CoverShape>,
    by: Option<HiddenBy>,
}

/// Nothing hides here.
pub(crate) const OPEN: [f32; 3] = [0.93, 0.94, 0.96];
/// No cover has said anything.
const UNKNOWN: [f32; 3] = [0.008; 3];
/// The layers of a masked buffer.
pub(crate) const REFERENCE: [f32; 3] = [0.09, 0.30, 0.55];
pub(crate) const WORKING: [f32; 3] = [0.95, 0.50, 0.10];
/// What is farthest keeps this part of its colour.
const FARTHEST: f32 = 0.16;

impl CoverPicture {
    pub(crate) fn new(size: [u32; 2]) -> CoverPicture {
        CoverPicture {
            width: size[0] as usize,
            samples: vec![Known::default(); size[0] as usize * size[1] as usize],
            passage: 0,
            shape: None,
        }
    }

    /// What follows is another passage's.
    pub(crate) fn enter(&mut self, shape: Option<CoverShape>) {
        self.passage += 1;
        self.shape = shape;
    }

    pub(crate) fn row(&mut self, y: u16, spans: &[CoverSpan]) {
        for span in spans {
            let [start, end] = [span.x0, span.x1].map(|x| usize::from(y) * self.width + usize::from(x));
            let steps = (end - start).saturating_sub(1).max(1) as f32;
            let [first, last] = span.rev_depth;
            for (step, sample) in self.samples[start..end].iter_mut().enumerate() {
                *sample = Known {
                    passage: self.passage,
                    cell: span.cell,
                    rev_depth: first + (last - first) * (step as f32 / steps),
                    shape: self.shape,
                    by: Some(span.by),
                };
            }
        }
    }

    pub(crate) fn into_image(self) -> RgbImage {
        let light = Light::over(&self.samples);
        let height = self.samples.len() / self.width;
        let mut image = RgbImage::new(self.width as u32, height as u32);
        for (i, target) in image.pixels_mut().enumerate() {
            let [x, y] = [i % self.width, i / self.width];
            let known = &self.samples[i];
            let left = if x > 0 { &self.samples[i - 1] } else { known };
            let above = if y > 0 {
                &self.samples[i - self.width]
            } else {
                known
            };
            let dimmed = dimming(known, left, above, y);
            target.0 = encode(color(known, &light).map(|value| value * dimmed));
        }
        image
    }
}

/// How the outlines of cells, and the rows that hold spans, darken a sample.
fn dimming(known: &Known, left: &Known, above: &Known, y: usize) -> f32 {
    let differs = |other: &Known| (other.passage, other.cell) != (known.passage, known.cell);
    match known.shape {
        // Rows know nothing of each other: only the ends of spans are outlines.
        Some(CoverShape::Spans) if differs(left) => 0.4,
        Some(CoverShape::Spans) if y % 2 == 1 => 0.85,
        Some(CoverShape::Spans) => 1.0,
        Some(CoverShape::Tiles) if differs(left) || differs(above) => 0.72,
        _ if differs(left) || differs(above) => 0.3,
        _ => 1.0,
    }
}

fn color(known: &Known, light: &Light) -> [f32; 3] {
    let part = light.of(known.rev_depth);
    let lit = |color: [f32; 3]| color.map(|value| value * (FARTHEST + (1.0 - FARTHEST) * part));
    match known.by {
        None => UNKNOWN,
        Some(HiddenBy::Nothing) => OPEN,
        Some(HiddenBy::One(number)) => lit(distinct(u64::from(number)).map(|value| 0.06 + 1.2 * value)),
        Some(HiddenBy::Reference) => lit(REFERENCE),
        Some(HiddenBy::Working) => lit(WORKING),
        _ => dusk(part),
    }
}

/// Reversed depth as light, 0 to 1: half by its logarithm, half by how much of the picture is farther, so that neither a leaf
/// before the eye nor a view down a street makes all else one.
struct Light {
    sorted: Vec<f32>,
    farthest: f32,
    per_doubling: f32,
}

impl Light {
    fn over(samples: &[Known]) -> Light {
        let rev_depth = samples.iter().map(|known| known.rev_depth);
        let mut sorted: Vec<f32> = rev_depth
            .filter(|&rev_depth| rev_depth > 0.0 && rev_depth.is_finite())
            .collect();
        sorted.sort_unstable_by(f32::total_cmp);
        let at = |percent: usize| sorted.get(sorted.len() * percent / 100).copied().unwrap_or(1.0);
        let [farthest, nearest] = [at(1), at(99)];
        Light {
            sorted,
            farthest,
            per_doubling: 1.0 / (nearest / farthest).log2().max(0.1),
        }
    }

    fn of(&self, rev_depth: f32) -> f32 {
        let by_logarithm = (rev_depth / self.farthest).log2() * self.per_doubling;
        let farther = self.sorted.partition_point(|&other| other < rev_depth);
        let by_rank = farther as f32 / self.sorted.len().max(1) as f32;
        0.5 * by_logarithm.clamp(0.0, 1.0) + 0.5 * by_rank
    }
}
