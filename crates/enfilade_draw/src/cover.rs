//! Pictures of occlusion buffers ([`Show::Cover`](crate::Show::Cover)): the occluder as hue, the reversed depth as
//! brightness.

use crate::palette::{distinct, dusk, encode};
use enfilade::{CoverShape, CoverSpan, HiddenBy};
use image::RgbImage;

/// Content of the occlusion buffers at each sample.
pub(crate) struct CoverPicture {
    width: usize,
    samples: Vec<CoverSample>,
    /// Number of the passage, which distinguishes cells of different passages with equal numbers.
    passage: u32,
    shape: Option<CoverShape>,
}

#[derive(Clone, Copy, Default)]
struct CoverSample {
    passage: u32,
    cell: u32,
    rev_depth: f32,
    shape: Option<CoverShape>,
    by: Option<HiddenBy>,
}

/// Samples without an occluder.
pub(crate) const OPEN: [f32; 3] = [0.93, 0.94, 0.96];
/// Samples that no occlusion buffer covers.
const UNKNOWN: [f32; 3] = [0.008; 3];
/// The reference and working layers of a masked depth buffer.
pub(crate) const REFERENCE: [f32; 3] = [0.09, 0.30, 0.55];
pub(crate) const WORKING: [f32; 3] = [0.95, 0.50, 0.10];
/// Brightness of the farthest samples.
const FARTHEST: f32 = 0.16;

impl CoverPicture {
    pub(crate) fn new(size: [u32; 2]) -> CoverPicture {
        CoverPicture {
            width: size[0] as usize,
            samples: vec![CoverSample::default(); size[0] as usize * size[1] as usize],
            passage: 0,
            shape: None,
        }
    }

    /// Starts the next passage.
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
                *sample = CoverSample {
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
            let sample = &self.samples[i];
            let left = if x > 0 { &self.samples[i - 1] } else { sample };
            let above = if y > 0 {
                &self.samples[i - self.width]
            } else {
                sample
            };
            let dimmed = dimming(sample, left, above, y);
            target.0 = encode(color(sample, &light).map(|value| value * dimmed));
        }
        image
    }
}

/// Returns a factor that darkens the outlines of cells, and every other row of spans.
fn dimming(sample: &CoverSample, left: &CoverSample, above: &CoverSample, y: usize) -> f32 {
    let differs = |other: &CoverSample| (other.passage, other.cell) != (sample.passage, sample.cell);
    match sample.shape {
        // Rows of spans are independent: only span ends are outlines.
        Some(CoverShape::Spans) if differs(left) => 0.4,
        Some(CoverShape::Spans) if y % 2 == 1 => 0.85,
        Some(CoverShape::Spans) => 1.0,
        Some(CoverShape::Tiles) if differs(left) || differs(above) => 0.72,
        _ if differs(left) || differs(above) => 0.3,
        _ => 1.0,
    }
}

fn color(sample: &CoverSample, light: &Light) -> [f32; 3] {
    let part = light.of(sample.rev_depth);
    let lit = |color: [f32; 3]| color.map(|value| value * (FARTHEST + (1.0 - FARTHEST) * part));
    match sample.by {
        None => UNKNOWN,
        Some(HiddenBy::Nothing) => OPEN,
        Some(HiddenBy::One(number)) => lit(distinct(u64::from(number)).map(|value| 0.06 + 1.2 * value)),
        Some(HiddenBy::Reference) => lit(REFERENCE),
        Some(HiddenBy::Working) => lit(WORKING),
        _ => dusk(part),
    }
}

/// Maps reversed depth to brightness, 0 to 1: half by its logarithm, half by its rank in the picture. So neither one
/// near leaf nor a view down a street makes everything else uniform.
struct Light {
    sorted: Vec<f32>,
    farthest: f32,
    per_doubling: f32,
}

impl Light {
    fn over(samples: &[CoverSample]) -> Light {
        let rev_depth = samples.iter().map(|sample| sample.rev_depth);
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
