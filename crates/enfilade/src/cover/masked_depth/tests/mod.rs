//! Compares the buffer with a plain array of one reversed depth per sample.

mod agree;
mod alone;
mod cases;
mod meshes;
mod oracle;
mod simplified;

use super::*;
use crate::geom::{Aabb, Transform};
use crate::ids::SectorId;
use crate::view::aperture::Rect;
use crate::view::region::Volume;
use crate::view::{Camera, View};
use glam::{DAffine3, DVec3};
use oracle::*;

/// Returns a buffer and an oracle with the same polygons.
fn filled(passage: &Passage, polygons: &[Polygon]) -> (MaskedDepth, Oracle) {
    let mut cover = MaskedDepth::default();
    // Leave contents of an earlier passage in the buffer.
    cover.clear(passage);
    let before = [[-9.0, -9.0, -0.1], [9.0, -9.0, -0.1], [0.0, 9.0, -0.1]].map(DVec3::from);
    let before = Polygon::new(&before, passage);
    cover.hide(&before.occluder(), passage, &mut Stats::default());
    cover.clear(passage);
    let mut oracle = Oracle::new(passage);
    for polygon in polygons {
        cover.hide(&polygon.occluder(), passage, &mut Stats::default());
        oracle.add(polygon);
    }
    (cover, oracle)
}

impl MaskedDepth {
    fn hide_batch(&mut self, faces: &Faces, passage: &Passage, stats: &mut Stats) {
        self.worker
            .hide_batch(&mut self.grid.all(), faces, passage, stats);
    }

    fn sees_rect(&self, rect: &Rect, nearest: f32) -> bool {
        self.grid.shows(rect, nearest)
    }

    fn known(&self, x: u16, y: u16) -> f32 {
        self.grid.rev_depth_at(x.into(), y.into())
    }
}

impl OcclusionBuffer {
    fn known(&self, x: u16, y: u16) -> f32 {
        self.grid.rev_depth_at(x.into(), y.into())
    }
}

#[test]
fn nothing_is_stored_nearer_than_the_truth() {
    let mut known = 0;
    for seed in 0..400 {
        let mut dice = Dice::new(seed);
        let passage = passages(seed, &mut dice);
        let count = 1 + (40.0 * dice.roll() * dice.roll()) as usize;
        let polygons = polygons(&mut dice, &passage, count);
        let (cover, oracle) = filled(&passage, &polygons);
        for (x, y) in samples(cover.grid.rect) {
            let at = oracle.at(x, y);
            let stored = cover.known(x, y);
            assert_eq!(
                stored == f32::INFINITY,
                !oracle.open[at],
                "{x}, {y} of scene {seed}"
            );
            if oracle.open[at] {
                assert!(
                    f64::from(stored) <= oracle.rev_depth[at],
                    "{x}, {y} of scene {seed}: {stored} for {}",
                    oracle.rev_depth[at]
                );
                known += usize::from(stored > 0.0);
            }
        }
    }
    assert!(known > 100_000, "almost nothing is covered: {known}");
}

#[test]
fn a_rectangle_is_hidden_only_where_everything_before_it_is_nearer() {
    let [mut hidden, mut known] = [0, 0];
    for seed in 0..200 {
        let mut dice = Dice::new(seed);
        let passage = passages(seed, &mut dice);
        let polygons = polygons(&mut dice, &passage, 25);
        let (cover, oracle) = filled(&passage, &polygons);
        let Rect { x0, y0, x1, y1 } = cover.grid.rect;
        for _ in 0..200 {
            let column = |dice: &mut Dice| x0 + (f64::from(x1 - x0) * dice.roll()) as u16;
            let row = |dice: &mut Dice| y0 + (f64::from(y1 - y0) * dice.roll()) as u16;
            let [left, right] = [column(&mut dice), column(&mut dice)];
            let [top, bottom] = [row(&mut dice), row(&mut dice)];
            let rect = Rect {
                x0: left.min(right),
                y0: top.min(bottom),
                x1: left.max(right) + 1,
                y1: top.max(bottom) + 1,
            };
            let nearest = dice.by_ratio(0.01, 30.0) as f32;
            let seen = oracle.sees(rect, |_, _| Some(f64::from(nearest)));
            known += u32::from(!seen);
            if !cover.sees_rect(&rect, nearest) {
                hidden += 1;
                assert!(!seen, "{rect:?} at {nearest} of scene {seed}");
            }
        }
    }
    assert!(hidden > 2000 && hidden * 10 > known * 8, "{hidden} of {known}");
}

#[test]
fn a_box_is_hidden_only_where_no_ray_meets_it_first() {
    let [mut hidden, mut by_rect, mut known] = [0, 0, 0];
    for seed in 0..300 {
        let mut dice = Dice::new(seed + 1000);
        let passage = passages(seed, &mut dice);
        let polygons = polygons(&mut dice, &passage, 30);
        let (mut cover, oracle) = filled(&passage, &polygons);
        for _ in 0..200 {
            let Some(region) = region_of(&passage, &random_box(&mut dice)) else {
                continue;
            };
            let seen = oracle.sees(oracle.all(), |x, y| {
                let rev_depth = rev_depth_of(&region.volume, x, y)?;
                let ray = DVec3::new(f64::from(x) + 0.5, f64::from(y) + 0.5, 1.0);
                let beyond = oracle
                    .entry
                    .is_none_or(|(normal, d)| normal.dot(ray) > d * rev_depth);
                // The part in front of the near plane is not visible, but the rest of the box may be.
                beyond.then_some(rev_depth.min(1.0 / oracle.near))
            });
            known += u32::from(!seen);
            by_rect += u32::from(!cover.sees_rect(&region.rect, region.nearest));
            if cover.test(&region) == Visibility::Hidden {
                hidden += 1;
                assert!(!seen, "{region:?} of scene {seed}");
            }
        }
    }
    // Expected tightness: nearly all boxes that no ray reaches are hidden, and the outline test hides many more than
    // rectangles do.
    assert!(known > 10_000 && hidden * 100 > known * 92, "{hidden} of {known}");
    assert!(
        hidden * 100 > by_rect * 140,
        "{hidden}, {by_rect} by their rectangles"
    );
}

#[test]
fn a_grown_box_is_hidden_only_if_it_is_wherever_it_may_move() {
    const GROWTH: f64 = 1.25;
    let [mut hidden, mut hidden_at_rest] = [0, 0];
    for seed in 0..100 {
        let mut dice = Dice::new(seed + 3000);
        let passage = passages(seed, &mut dice);
        let polygons = polygons(&mut dice, &passage, 30);
        let (mut cover, oracle) = filled(&passage, &polygons);
        for _ in 0..200 {
            let Some(region) = region_of(&passage, &random_box(&mut dice)) else {
                continue;
            };
            hidden_at_rest += u32::from(cover.test(&region) == Visibility::Hidden);
            let grown = Region {
                rect: oracle.all(),
                ..region
            };
            cover.growth = GROWTH;
            let is_hidden = cover.test(&grown) == Visibility::Hidden;
            cover.growth = 0.0;
            if !is_hidden {
                continue;
            }
            hidden += 1;
            for _ in 0..8 {
                let [dx, dy] = [(); 2].map(|()| GROWTH * (2.0 * dice.roll() - 1.0));
                let moved = |at: DVec3| DVec3::new(at.x + dx * at.z, at.y + dy * at.z, at.z);
                let volume = Volume {
                    origin: moved(region.volume.origin),
                    sides: region.volume.sides.map(moved),
                    is_parallel: false,
                };
                let seen = oracle.sees(oracle.all(), |x, y| {
                    Some(rev_depth_of(&volume, x, y)?.min(1.0 / oracle.near))
                });
                assert!(!seen, "{region:?} of scene {seed}, moved by {dx}, {dy}");
            }
        }
    }
    assert!(
        hidden > 1000 && hidden < hidden_at_rest,
        "{hidden} of {hidden_at_rest}"
    );
}

#[test]
fn every_simd_level_says_the_same() {
    let mut hidden = 0;
    for seed in 0..60 {
        let mut dice = Dice::new(seed + 2000);
        let passage = passages(seed, &mut dice);
        let polygons = polygons(&mut dice, &passage, 30);
        let boxes: Vec<DAffine3> = (0..100).map(|_| random_box(&mut dice)).collect();
        let [(known, seen), widest] = [Level::baseline(), Level::new()].map(|level| {
            let mut cover = MaskedDepth::at(level);
            cover.clear(&passage);
            for polygon in &polygons {
                cover.hide(&polygon.occluder(), &passage, &mut Stats::default());
            }
            let known: Vec<u32> = samples(cover.grid.rect)
                .map(|(x, y)| cover.known(x, y).to_bits())
                .collect();
            let regions = boxes.iter().filter_map(|at| region_of(&passage, at));
            let seen: Vec<Visibility> = regions.map(|region| cover.test(&region)).collect();
            (known, seen)
        });
        hidden += seen.iter().filter(|&&sight| sight == Visibility::Hidden).count();
        assert!((known, seen) == widest, "scene {seed}");
    }
    assert!(hidden > 500, "{hidden}");
}
