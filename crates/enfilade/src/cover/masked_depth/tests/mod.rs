//! The buffer against a plain array of one nearness for each sample.

mod agree;
mod cases;

use super::*;
use crate::aperture::{Rect, Rows};
use crate::geom::{Aabb, ConvexPolygon};
use crate::region::{Region, Volume};
use crate::scene::FragmentId;
use crate::view::View;
use glam::{DAffine3, DVec3};

/// Numbers from 0 to 1 that look random; the same for the same seed.
struct Dice(u64);

impl Dice {
    fn new(seed: u64) -> Dice {
        Dice(seed.wrapping_mul(0x9E37_79B9_7F4A_7C15) | 1)
    }

    fn roll(&mut self) -> f64 {
        self.0 ^= self.0 << 13;
        self.0 ^= self.0 >> 7;
        self.0 ^= self.0 << 17;
        (self.0 >> 11) as f64 / (1_u64 << 53) as f64
    }

    fn between(&mut self, low: f64, high: f64) -> f64 {
        low + (high - low) * self.roll()
    }

    /// From `low` to `high`, as many below the middle by ratio as above.
    fn by_ratio(&mut self, low: f64, high: f64) -> f64 {
        low * (high / low).powf(self.roll())
    }

    fn unit(&mut self) -> DVec3 {
        let point = DVec3::new(self.roll(), self.roll(), self.roll()) - 0.5;
        point.normalize_or(DVec3::X)
    }
}

/// A convex polygon in the space of a passage, as corners and plane.
#[derive(Clone, Debug)]
struct Polygon {
    corners: Vec<DVec3>,
    plane: (DVec3, f64),
}

impl Polygon {
    /// The plane through corners that are given in the space of the fragment.
    fn new(corners: &[DVec3], passage: &Passage) -> Polygon {
        let corners: Vec<DVec3> = corners
            .iter()
            .map(|&c| passage.screen_from_fragment.transform_point3(c))
            .collect();
        let normal = (2..corners.len())
            .map(|i| (corners[i - 1] - corners[0]).cross(corners[i] - corners[0]))
            .sum::<DVec3>()
            .normalize_or_zero();
        // Behind all corners, as far as rounding goes.
        let side = if normal.dot(corners[0]) < 0.0 { -1.0 } else { 1.0 };
        let farthest = corners.iter().map(|c| side * normal.dot(*c)).fold(0.0, f64::max);
        Polygon {
            corners,
            plane: (side * normal, farthest * (1.0 + 1e-12)),
        }
    }

    /// A regular polygon that some of the sides of are cut short.
    fn random(dice: &mut Dice, passage: &Passage, center: DVec3, radius: f64) -> Polygon {
        let [u, v] = [dice.unit(), dice.unit()];
        let v = u.cross(v).normalize_or(u.any_orthonormal_vector());
        let u = v.cross(u).normalize_or_zero();
        let count = 3 + (4.0 * dice.roll()) as usize;
        let squash = dice.by_ratio(1e-3, 1.0);
        let corners: Vec<DVec3> = (0..count)
            .map(|i| {
                let angle = (i as f64 + dice.between(0.0, 0.9)) / count as f64 * std::f64::consts::TAU;
                center + radius * (u * angle.cos() + v * (squash * angle.sin()))
            })
            .collect();
        Polygon::new(&corners, passage)
    }

    fn occluder(&self) -> Occluder<'_> {
        Occluder {
            corners: &self.corners,
            plane: self.plane,
        }
    }
}

/// What is at each sample.
struct Oracle {
    size: [u16; 2],
    near: f64,
    entry: Option<(DVec3, f64)>,
    open: Vec<bool>,
    nearness: Vec<f64>,
}

fn samples(rect: Rect) -> impl Iterator<Item = (u16, u16)> {
    (rect.y0..rect.y1).flat_map(move |y| (rect.x0..rect.x1).map(move |x| (x, y)))
}

impl Oracle {
    fn new(passage: &Passage) -> Oracle {
        let size = passage.size.map(|side| side as u16);
        let mut open = vec![false; usize::from(size[0]) * usize::from(size[1])];
        let mut runs = Vec::new();
        for y in 0..size[1] {
            passage.aperture.open_in_row(y, &mut runs);
            for &[x0, x1] in &runs {
                let row = usize::from(y) * usize::from(size[0]);
                open[row + usize::from(x0)..row + usize::from(x1)].fill(true);
            }
        }
        Oracle {
            size,
            near: f64::from(passage.near),
            entry: passage.entry,
            nearness: vec![0.0; open.len()],
            open,
        }
    }

    fn at(&self, x: u16, y: u16) -> usize {
        usize::from(y) * usize::from(self.size[0]) + usize::from(x)
    }

    fn all(&self) -> Rect {
        let [x1, y1] = self.size;
        Rect { x0: 0, y0: 0, x1, y1 }
    }

    fn add(&mut self, polygon: &Polygon) {
        let Polygon { corners, plane } = polygon;
        for (x, y) in samples(self.all()) {
            let ray = DVec3::new(f64::from(x) + 0.5, f64::from(y) + 0.5, 1.0);
            let nearness = plane.0.dot(ray) / plane.1;
            let sides = (0..corners.len()).map(|i| {
                let [from, to] = [corners[i], corners[(i + 1) % corners.len()]];
                let normal = from.cross(to);
                normal.dot(ray) / normal.truncate().length().max(f64::MIN_POSITIVE)
            });
            // A little more than it covers, so that what the buffer is held to is no more than the truth.
            let mut signs = [true, true];
            for distance in sides {
                signs[0] &= distance > -1e-7;
                signs[1] &= distance < 1e-7;
            }
            let inside = (signs[0] || signs[1]) && nearness > 0.0 && nearness * self.near < 1.0;
            let beyond = self
                .entry
                .is_none_or(|(normal, d)| normal.dot(ray) > d * nearness);
            if inside && beyond {
                let at = self.at(x, y);
                self.nearness[at] = self.nearness[at].max(nearness);
            }
        }
    }

    /// Does any open sample of `rect` show what is as near as `nearness(x, y)`?
    fn sees(&self, rect: Rect, nearness: impl Fn(u16, u16) -> Option<f64>) -> bool {
        samples(rect).any(|(x, y)| {
            let at = self.at(x, y);
            self.open[at] && nearness(x, y).is_some_and(|nearness| nearness >= self.nearness[at])
        })
    }
}

/// How near a box is at a sample; `None` where a ray through the sample does not meet it.
fn nearness_of(volume: &Volume, x: u16, y: u16) -> Option<f64> {
    let ray = DVec3::new(f64::from(x) + 0.5, f64::from(y) + 0.5, 1.0);
    let [mut enter, mut leave] = [0.0_f64, f64::INFINITY];
    let mut sides = volume.sides;
    if let Some(flat) = sides.iter().position(|&side| side == DVec3::ZERO) {
        // A ray meets what is flat in an instant: give it a little time.
        let [a, b] = [sides[(flat + 1) % 3], sides[(flat + 2) % 3]];
        sides[flat] = a.cross(b).normalize_or_zero() * (1e-10 * a.length());
        if sides[flat] == DVec3::ZERO {
            return None;
        }
    }
    for axis in 0..3 {
        let normal = sides[(axis + 1) % 3].cross(sides[(axis + 2) % 3]);
        let along = normal.dot(ray);
        let start = normal.dot(volume.origin);
        let end = start + normal.dot(sides[axis]);
        let [a, b] = [start / along, end / along];
        enter = enter.max(a.min(b));
        leave = leave.min(a.max(b));
    }
    (enter < leave).then(|| 1.0 / enter)
}

fn passage(size: [u32; 2]) -> Passage {
    Passage::at_the_eye(&View::new([0.0; 3], [0.0, 0.0, -1.0], size), FragmentId(0), false)
}

/// Passages of all kinds: the whole screen, behind an outline, behind samples.
fn passages(seed: u64, dice: &mut Dice) -> Passage {
    let mut passage = passage([[77, 43], [64, 16], [200, 61], [33, 9]][seed as usize % 4]);
    let [width, height] = passage.size;
    if seed % 3 == 1 {
        let corner = [
            dice.between(-0.8, 0.2) as f32,
            dice.between(-0.5, 0.2) as f32,
            -1.0,
        ];
        let door = ConvexPolygon::rectangle(corner, [0.7, 0.1, 0.0], [0.1, 0.5, 0.0]).expect("a door");
        if let Some(behind) = passage
            .aperture
            .behind(&door, &passage.screen_from_fragment, None, false)
        {
            passage.aperture = behind;
            passage.entry = Some((DVec3::Z, 1.0));
        }
    } else if seed % 3 == 2 {
        let mut rows = Rows::default();
        for y in height / 5..height - 1 {
            let mut x = 0;
            while x < width {
                let end = (x + 1 + (30.0 * dice.roll()) as u32).min(width);
                if dice.roll() < 0.6 {
                    rows.push(y as u16, x as u16, end as u16);
                }
                x = end + 1;
            }
        }
        let door = ConvexPolygon::rectangle([-9.0, -9.0, -1.0], [18.0, 0.0, 0.0], [0.0, 18.0, 0.0]);
        let behind = passage.aperture.behind(
            &door.expect("a door"),
            &passage.screen_from_fragment,
            Some(rows),
            false,
        );
        passage.aperture = behind.expect("some samples are open");
    }
    passage
}

/// Polygons of all sizes, mostly before the eye, some through the near plane or around the eye.
fn polygons(dice: &mut Dice, passage: &Passage, count: usize) -> Vec<Polygon> {
    (0..count)
        .map(|_| {
            let distance = dice.by_ratio(0.05, 50.0);
            let at = DVec3::new(dice.between(-1.2, 1.2), dice.between(-0.7, 0.7), -1.0) * distance;
            let radius = distance * dice.by_ratio(0.02, 3.0);
            Polygon::random(dice, passage, at, radius)
        })
        .collect()
}

/// What a passage sees of the unit cube, put into the fragment.
fn region_of(passage: &Passage, fragment_from_cube: &DAffine3) -> Option<Region> {
    let cube = Aabb {
        min: [0.0; 3],
        max: [1.0; 3],
    };
    Region::of(
        passage,
        &(passage.screen_from_fragment * *fragment_from_cube),
        &cube,
    )
}

/// A box somewhere, turned and stretched; one in five is flat, one in twenty a stick.
fn random_box(dice: &mut Dice) -> DAffine3 {
    let distance = dice.by_ratio(0.05, 80.0);
    let at = DVec3::new(dice.between(-1.2, 1.2), dice.between(-0.7, 0.7), -1.0) * distance;
    let turn = DAffine3::from_axis_angle(dice.unit(), dice.between(0.0, 6.0));
    let mut size = DVec3::from([(); 3].map(|()| distance * dice.by_ratio(0.005, 0.6)));
    if dice.roll() < 0.2 {
        size.x = 0.0;
    }
    if dice.roll() < 0.05 {
        size.z = 0.0;
    }
    DAffine3::from_translation(at)
        * turn
        * DAffine3::from_scale(size)
        * DAffine3::from_translation(-DVec3::splat(0.5))
}

/// A buffer and an oracle that took the same polygons.
fn filled(passage: &Passage, polygons: &[Polygon]) -> (MaskedDepth, Oracle) {
    let mut cover = MaskedDepth::default();
    // Something is left from the last passage.
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
    fn known(&self, x: u16, y: u16) -> f32 {
        let [column, row] = [usize::from(x) / COLUMNS, usize::from(y) / ROWS];
        let tile = &self.grid.tiles[row * self.grid.columns + column];
        tile.known(usize::from(x) % COLUMNS, usize::from(y) % ROWS)
    }

    fn sees_rect(&self, rect: &Rect, nearest: f32) -> bool {
        self.grid
            .first_seen(&rect.intersection(&self.grid.rect), nearest)
            .is_some()
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
                    f64::from(stored) <= oracle.nearness[at],
                    "{x}, {y} of scene {seed}: {stored} for {}",
                    oracle.nearness[at]
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
                let nearness = nearness_of(&region.volume, x, y)?;
                let ray = DVec3::new(f64::from(x) + 0.5, f64::from(y) + 0.5, 1.0);
                let beyond = oracle
                    .entry
                    .is_none_or(|(normal, d)| normal.dot(ray) > d * nearness);
                // What is nearer than the near distance is not seen, but the rest of the box may be.
                beyond.then_some(nearness.min(1.0 / oracle.near))
            });
            known += u32::from(!seen);
            by_rect += u32::from(!cover.sees_rect(&region.rect, region.nearest));
            if cover.sees(&region) == Sight::Hidden {
                hidden += 1;
                assert!(!seen, "{region:?} of scene {seed}");
            }
        }
    }
    println!("of {known} hidden boxes {by_rect} by rectangle, {hidden} in all");
    assert!(
        hidden > by_rect && hidden > 2000,
        "{hidden} and {by_rect} of {known}"
    );
}
