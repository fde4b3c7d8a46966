//! Boxes of one space, as a passage sees them: eight at a time.
//!
//! Lanes are boxes, and corners come one after the other, so that nothing has to be gathered across lanes.
//! Source: none but ours.
//! Cost: O(1), as much for eight boxes as for one.
//! Conservative, with the same bits as [`Region::of`] at every SIMD level.

use super::{Region, Touched, Volume, middle_and_half};
use crate::aperture::Rect;
use crate::geom::Aabb;
use crate::passage::Passage;
use fearless_simd::prelude::*;
use fearless_simd::{dispatch, f64x8, mask64x8};
use glam::{DAffine3, DVec3};

/// Boxes that are looked at together.
pub(crate) const BOXES: usize = 8;

impl Region {
    /// As [`Region::of`], of several boxes, in their order; no more than [`BOXES`].
    pub(crate) fn of_eight(
        passage: &Passage,
        screen_from_local: &DAffine3,
        boxes: &[Aabb],
    ) -> [Option<Region>; BOXES] {
        let mut regions = [None; BOXES];
        let boxes = &boxes[..boxes.len().min(BOXES)];
        let mut volumes = Volumes::default();
        for (lane, bounds) in boxes.iter().enumerate() {
            if !bounds.is_empty() {
                volumes.put(lane, &Volume::new(screen_from_local, bounds));
            }
        }
        let (limits, near) = (passage.aperture.rect(), f64::from(passage.near));
        let touched = dispatch!(passage.level, simd => volumes.touched(simd, &limits, near, passage.entry));
        for (lane, bounds) in boxes.iter().enumerate() {
            if let Some(touched) = touched[lane].filter(|_| !bounds.is_empty()) {
                let region = touched.in_rect(passage, &limits, volumes.get(lane));
                regions[lane] = Some(region).filter(|region| !region.rect.is_empty());
            }
        }
        regions
    }
}

/// Eight volumes: x, y and w of the origin, then of each side.
#[derive(Default)]
struct Volumes([[[f64; BOXES]; 3]; 4]);

impl Volumes {
    fn put(&mut self, lane: usize, volume: &Volume) {
        let Volume {
            origin,
            sides: [x, y, z],
        } = *volume;
        for (kept, vector) in self.0.iter_mut().zip([origin, x, y, z]) {
            for (kept, value) in kept.iter_mut().zip(vector.to_array()) {
                kept[lane] = value;
            }
        }
    }

    fn get(&self, lane: usize) -> Volume {
        let [origin, x, y, z] = self.0.map(|kept| DVec3::from(kept.map(|axis| axis[lane])));
        Volume {
            origin,
            sides: [x, y, z],
        }
    }

    /// As [`Volume::touched`], for each.
    #[inline(always)]
    fn touched<S: Simd>(
        &self,
        simd: S,
        limits: &Rect,
        near: f64,
        entry: Option<(DVec3, f64)>,
    ) -> [Option<Touched>; BOXES] {
        let [middle, half] = middle_and_half(limits);
        let mut bounds = Bounds::new(simd);
        let mut outside: [mask64x8<S>; 6] = [mask64x8::splat(simd, true); 6];
        for corner in 0..8 {
            let [x, y, w] = [
                self.coordinate(simd, 0, corner),
                self.coordinate(simd, 1, corner),
                self.coordinate(simd, 2, corner),
            ];
            let from_middle = [x - w * middle[0], y - w * middle[1]];
            let [right, below] = [w * half[0], w * half[1]];
            outside[0] &= from_middle[0].simd_lt(-right);
            outside[1] &= from_middle[0].simd_gt(right);
            outside[2] &= from_middle[1].simd_lt(-below);
            outside[3] &= from_middle[1].simd_gt(below);
            outside[4] &= w.simd_lt(near);
            if let Some((normal, d)) = entry {
                let at = x * normal.x + y * normal.y + w * normal.z;
                outside[5] &= !at.simd_ge(f64x8::splat(simd, d * (1.0 - 1e-6)));
            }
            let per_w = f64x8::splat(simd, 1.0) / w;
            bounds.add([from_middle[0], from_middle[1], w, x * per_w, y * per_w]);
        }
        let mut any = outside[0] | outside[1] | outside[2] | outside[3] | outside[4];
        if entry.is_some() {
            any |= outside[5];
        }
        bounds.touched(any.to_bitmask(), limits, near)
    }

    /// One coordinate of a corner of each, added up as for one volume alone.
    #[inline(always)]
    fn coordinate<S: Simd>(&self, simd: S, axis: usize, corner: usize) -> f64x8<S> {
        let [origin, x, y, z] = [
            f64x8::from_slice(simd, &self.0[0][axis]),
            f64x8::from_slice(simd, &self.0[1][axis]),
            f64x8::from_slice(simd, &self.0[2][axis]),
            f64x8::from_slice(simd, &self.0[3][axis]),
        ];
        let from = if corner & 4 == 0 { origin } else { origin + z };
        from + match corner & 3 {
            0 => f64x8::splat(simd, 0.0),
            1 => x,
            2 => y,
            _ => x + y,
        }
    }
}

/// The least and the greatest of five numbers of the corners: x and y from the middle times w, w, and x and y on the
/// screen.
struct Bounds<S: Simd> {
    least: [f64x8<S>; 5],
    greatest: [f64x8<S>; 5],
}

impl<S: Simd> Bounds<S> {
    #[inline(always)]
    fn new(simd: S) -> Bounds<S> {
        Bounds {
            least: [f64x8::splat(simd, f64::INFINITY); 5],
            greatest: [f64x8::splat(simd, f64::NEG_INFINITY); 5],
        }
    }

    #[inline(always)]
    fn add(&mut self, values: [f64x8<S>; 5]) {
        for ((least, greatest), value) in self.least.iter_mut().zip(&mut self.greatest).zip(values) {
            *least = value.simd_lt(*least).select(value, *least);
            *greatest = value.simd_gt(*greatest).select(value, *greatest);
        }
    }

    /// What the boxes touch but for those of some lanes.
    #[inline(always)]
    fn touched(&self, outside: u64, limits: &Rect, near: f64) -> [Option<Touched>; BOXES] {
        let [mut least, mut greatest] = [[[0.0; BOXES]; 5]; 2];
        for number in 0..5 {
            least[number] = self.least[number].into();
            greatest[number] = self.greatest[number].into();
        }
        let mut touched = [None; BOXES];
        for (lane, touched) in touched.iter_mut().enumerate() {
            if outside >> lane & 1 == 0 {
                let at = |all: &[[f64; BOXES]; 5]| [all[0][lane], all[1][lane], all[2][lane]];
                let on_screen = [
                    [least[3][lane], least[4][lane]],
                    [greatest[3][lane], greatest[4][lane]],
                ];
                *touched = Some(Touched::new(at(&least), at(&greatest), on_screen, limits, near));
            }
        }
        touched
    }
}
