//! The oracle, a plain array of one reversed depth per sample, and random occluders and boxes.

use super::*;
pub(super) use crate::chance::Dice;
use crate::geom::Aabb;
use crate::geom::ConvexPolygon;
use crate::view::aperture::Rows;

/// A convex polygon in the space of a passage, as corners and plane.
#[derive(Clone, Debug)]
pub(super) struct Polygon {
    pub(super) corners: Vec<DVec3>,
    pub(super) plane: (DVec3, f64),
}

impl Polygon {
    /// Creates the polygon and its plane from corners in the space of the sector.
    pub(super) fn new(corners: &[DVec3], passage: &Passage) -> Polygon {
        let corners: Vec<DVec3> = corners
            .iter()
            .map(|&c| passage.screen_from_sector.point(c))
            .collect();
        let normal = (2..corners.len())
            .map(|i| (corners[i - 1] - corners[0]).cross(corners[i] - corners[0]))
            .sum::<DVec3>()
            .normalize_or_zero();
        // Behind all corners, within rounding.
        let side = if normal.dot(corners[0]) < 0.0 { -1.0 } else { 1.0 };
        let farthest = corners.iter().map(|c| side * normal.dot(*c)).fold(0.0, f64::max);
        Polygon {
            corners,
            plane: (side * normal, farthest * (1.0 + 1e-12)),
        }
    }

    /// A regular polygon with some shortened sides.
    pub(super) fn random(dice: &mut Dice, passage: &Passage, center: DVec3, radius: f64) -> Polygon {
        let [u, v] = [dice.direction(), dice.direction()];
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

    pub(super) fn occluder(&self) -> Occluder<'_> {
        Occluder {
            corners: &self.corners,
            plane: self.plane,
        }
    }
}

/// Reversed depth of each sample.
pub(super) struct Oracle {
    pub(super) size: [u16; 2],
    pub(super) near: f64,
    pub(super) entry: Option<(DVec3, f64)>,
    pub(super) open: Vec<bool>,
    pub(super) rev_depth: Vec<f64>,
}

pub(super) fn samples(rect: Rect) -> impl Iterator<Item = (u16, u16)> {
    (rect.y0..rect.y1).flat_map(move |y| (rect.x0..rect.x1).map(move |x| (x, y)))
}

impl Oracle {
    pub(super) fn new(passage: &Passage) -> Oracle {
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
            near: f64::from(passage.z_near),
            entry: passage.entry,
            rev_depth: vec![0.0; open.len()],
            open,
        }
    }

    pub(super) fn at(&self, x: u16, y: u16) -> usize {
        usize::from(y) * usize::from(self.size[0]) + usize::from(x)
    }

    pub(super) fn all(&self) -> Rect {
        let [x1, y1] = self.size;
        Rect { x0: 0, y0: 0, x1, y1 }
    }

    pub(super) fn add(&mut self, polygon: &Polygon) {
        let Polygon { corners, plane } = polygon;
        for (x, y) in samples(self.all()) {
            let ray = DVec3::new(f64::from(x) + 0.5, f64::from(y) + 0.5, 1.0);
            let rev_depth = plane.0.dot(ray) / plane.1;
            let sides = (0..corners.len()).map(|i| {
                let [from, to] = [corners[i], corners[(i + 1) % corners.len()]];
                let normal = from.cross(to);
                normal.dot(ray) / normal.truncate().length().max(f64::MIN_POSITIVE)
            });
            // Slightly larger than the polygon, so that the buffer is never expected to hide less than the truth.
            let mut signs = [true, true];
            for distance in sides {
                signs[0] &= distance > -1e-7;
                signs[1] &= distance < 1e-7;
            }
            let inside = (signs[0] || signs[1]) && rev_depth > 0.0 && rev_depth * self.near < 1.0;
            let beyond = self
                .entry
                .is_none_or(|(normal, d)| normal.dot(ray) > d * rev_depth);
            if inside && beyond {
                let at = self.at(x, y);
                self.rev_depth[at] = self.rev_depth[at].max(rev_depth);
            }
        }
    }

    /// Whether any open sample of `rect` may show geometry with reversed depth `rev_depth(x, y)`.
    pub(super) fn sees(&self, rect: Rect, rev_depth: impl Fn(u16, u16) -> Option<f64>) -> bool {
        samples(rect).any(|(x, y)| {
            let at = self.at(x, y);
            self.open[at] && rev_depth(x, y).is_some_and(|rev_depth| rev_depth >= self.rev_depth[at])
        })
    }
}

/// Returns the reversed depth of a box at a sample; `None` if the ray through the sample misses it.
pub(super) fn rev_depth_of(volume: &Volume, x: u16, y: u16) -> Option<f64> {
    let ray = DVec3::new(f64::from(x) + 0.5, f64::from(y) + 0.5, 1.0);
    let [mut enter, mut leave] = [0.0_f64, f64::INFINITY];
    let mut sides = volume.sides;
    if let Some(flat) = sides.iter().position(|&side| side == DVec3::ZERO) {
        // Give a flat box a small thickness, because a ray is inside it for zero length.
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

pub(super) fn passage(size: [u32; 2]) -> Passage {
    Passage::at_the_eye(
        &View::new([0.0; 3], [0.0, 0.0, -1.0], size).expect("a valid view"),
        SectorId(0),
        false,
    )
}

/// All kinds of passages: the whole screen, behind an outline, behind a set of samples.
pub(super) fn passages(seed: u64, dice: &mut Dice) -> Passage {
    let mut passage = passage([[77, 43], [64, 16], [200, 61], [33, 9]][seed as usize % 4]);
    let [width, height] = passage.size;
    if seed % 3 == 1 {
        let corner = [
            dice.between(-0.8, 0.2) as f32,
            dice.between(-0.5, 0.2) as f32,
            -1.0,
        ];
        let door = ConvexPolygon::rectangle(corner, [0.7, 0.1, 0.0], [0.1, 0.5, 0.0]).expect("a door");
        if let Some(behind) = passage.aperture_behind(&door, None, 0.0) {
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
        let behind = passage.aperture_behind(&door.expect("a door"), Some(rows), 0.0);
        passage.aperture = behind.expect("some samples are open");
    }
    passage
}

/// Polygons of all sizes, mostly in front of the eye, some through the near plane or around the eye.
pub(super) fn polygons(dice: &mut Dice, passage: &Passage, count: usize) -> Vec<Polygon> {
    (0..count)
        .map(|_| {
            let distance = dice.by_ratio(0.05, 50.0);
            let at = DVec3::new(dice.between(-1.2, 1.2), dice.between(-0.7, 0.7), -1.0) * distance;
            let radius = distance * dice.by_ratio(0.02, 3.0);
            Polygon::random(dice, passage, at, radius)
        })
        .collect()
}

/// Returns the region of the unit cube after its transform to the sector.
pub(super) fn region_of(passage: &Passage, sector_from_cube: &DAffine3) -> Option<Region> {
    let cube = Aabb {
        min: [0.0; 3],
        max: [1.0; 3],
    };
    Region::of(
        passage,
        &(passage.screen_from(&Transform(*sector_from_cube))),
        &cube,
    )
}

/// A random box, rotated and scaled; one in five is flat, one in twenty a segment.
pub(super) fn random_box(dice: &mut Dice) -> DAffine3 {
    let distance = dice.by_ratio(0.05, 80.0);
    let at = DVec3::new(dice.between(-1.2, 1.2), dice.between(-0.7, 0.7), -1.0) * distance;
    let turn = DAffine3::from_axis_angle(dice.direction(), dice.between(0.0, 6.0));
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
