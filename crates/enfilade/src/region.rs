//! A box in space, as a passage sees it.

use crate::aperture::Rect;
use crate::geom::Aabb;
use crate::passage::Passage;
use glam::{DAffine3, DVec3};

/// How much of something can be seen.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Sight {
    /// Nothing of it.
    Hidden,
    /// Some of it, or one cannot say.
    Partly,
    /// All of it, and so all of what is in it.
    Fully,
}

/// A box in space, as a passage sees it: the samples it may touch, and how near it comes.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Region {
    /// The samples inside the aperture's rectangle that any part of the box may own.
    pub rect: Rect,
    /// Nearness (1 / distance along the line of sight) of its nearest corner, rounded up; infinite where the box
    /// reaches before the near distance.
    pub nearest: f32,
    /// The box itself.
    pub(crate) volume: Volume,
}

/// A box in the space of (X, Y, W), where the eye is the origin: a corner, and the edges that leave it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Volume {
    pub(crate) origin: DVec3,
    pub(crate) sides: [DVec3; 3],
}

/// By how much nearness is rounded up in queries, relatively: more than covers lose (2⁻²⁴), less than what the
/// reference calls equal (2⁻¹⁶).
const ROUND_UP: f64 = 1.0 + 1.0 / (1_u64 << 20) as f64;

impl Region {
    /// What `passage` sees of a box given in another space; `None` where no sample of the aperture's rectangle can
    /// show any of it.
    pub(crate) fn of(passage: &Passage, screen_from_local: &DAffine3, bounds: &Aabb) -> Option<Region> {
        let near = f64::from(passage.near);
        Region::in_rect(passage, passage.aperture.rect(), near, screen_from_local, bounds)
            .filter(|region| !region.rect.is_empty())
    }

    /// As [`Region::of`], in another rectangle, from another distance on, and also where no sample shows any of it.
    pub(crate) fn in_rect(
        passage: &Passage,
        limits: Rect,
        near: f64,
        screen_from_local: &DAffine3,
        bounds: &Aabb,
    ) -> Option<Region> {
        if bounds.is_empty() {
            return None;
        }
        let volume = Volume::new(screen_from_local, bounds);
        let corners = volume.corners();
        // From the middle of the rectangle, so that its sides stand at ±half.
        let middle = [limits.x0 + limits.x1, limits.y0 + limits.y1].map(|sum| 0.5 * f64::from(sum));
        let half = [limits.x1 - limits.x0, limits.y1 - limits.y0].map(|side| 0.5 * f64::from(side));
        let mut outside = 0b11_1111_u8;
        let [mut least, mut greatest] = [[f64::INFINITY; 3], [f64::NEG_INFINITY; 3]];
        for corner in &corners {
            let w = corner.z;
            let [x, y] = [corner.x - middle[0] * w, corner.y - middle[1] * w];
            let beyond_entry = passage
                .entry
                .is_none_or(|(normal, d)| normal.dot(*corner) >= d * (1.0 - 1e-6));
            outside &= u8::from(x < -half[0] * w)
                | u8::from(x > half[0] * w) << 1
                | u8::from(y < -half[1] * w) << 2
                | u8::from(y > half[1] * w) << 3
                | u8::from(w < near) << 4
                | u8::from(!beyond_entry) << 5;
            for (axis, value) in [x, y, w].into_iter().enumerate() {
                least[axis] = smaller(value, least[axis]);
                greatest[axis] = greater(value, greatest[axis]);
            }
        }
        if outside != 0 {
            return None;
        }
        // What is seen in the rectangle has |x| ≤ half · w, so w is at least |x| / half: a ceiling overhead comes no
        // nearer than where it enters the picture, however far behind the eye its box reaches.
        let mut nearest_w = greater(least[2], near);
        for axis in 0..2 {
            nearest_w = greater(nearest_w, greater(least[axis], -greatest[axis]) / half[axis]);
        }
        let nearest = if nearest_w > near {
            (ROUND_UP / nearest_w) as f32
        } else {
            f32::INFINITY
        };
        let [mut min, mut max] = [[0.0; 2], [0.0; 2]];
        if least[2] > near {
            [min, max] = [[f64::INFINITY; 2], [f64::NEG_INFINITY; 2]];
            for corner in &corners {
                let per_w = 1.0 / corner.z;
                for (axis, value) in [corner.x * per_w, corner.y * per_w].into_iter().enumerate() {
                    min[axis] = smaller(value, min[axis]);
                    max[axis] = greater(value, max[axis]);
                }
            }
        } else {
            for axis in 0..2 {
                // w lies between these two, whatever x and y are.
                let [close, far] = [nearest_w, greatest[2]];
                min[axis] = middle[axis] + least[axis] / if least[axis] < 0.0 { close } else { far };
                max[axis] = middle[axis] + greatest[axis] / if greatest[axis] > 0.0 { close } else { far };
            }
        }
        let rect = if passage.any_place {
            Rect::touched(min, max, &limits)
        } else {
            Rect::around(min, max, &limits)
        };
        Some(Region {
            rect,
            nearest,
            volume,
        })
    }
}

impl Volume {
    pub(crate) fn new(screen_from_local: &DAffine3, bounds: &Aabb) -> Volume {
        let [min, max] = [bounds.min, bounds.max].map(|corner| DVec3::from(corner.map(f64::from)));
        let DVec3 { x, y, z } = max - min;
        let axes = screen_from_local.matrix3;
        Volume {
            origin: screen_from_local.transform_point3(min),
            sides: [axes.x_axis * x, axes.y_axis * y, axes.z_axis * z],
        }
    }

    /// The eight corners; bit k of a corner's place says that side k leads to it.
    pub(crate) fn corners(&self) -> [DVec3; 8] {
        let Volume {
            origin,
            sides: [x, y, z],
        } = *self;
        let (xy, far) = (x + y, origin + z);
        [
            origin,
            origin + x,
            origin + y,
            origin + xy,
            far,
            far + x,
            far + y,
            far + xy,
        ]
    }
}

#[inline(always)]
fn smaller(a: f64, b: f64) -> f64 {
    if a < b { a } else { b }
}

#[inline(always)]
fn greater(a: f64, b: f64) -> f64 {
    if a > b { a } else { b }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scene::FragmentId;
    use crate::view::View;

    /// What an eye at the origin, looking along −z with a lens of 90 degrees, sees of a box on a square screen.
    fn seen(min: [f32; 3], max: [f32; 3]) -> Option<Region> {
        let mut view = View::new([0.0; 3], [0.0, 0.0, -1.0], [100, 100]);
        view.fov_y = 90.0_f32.to_radians();
        let passage = Passage::at_the_eye(&view, FragmentId(0), false);
        Region::of(&passage, &passage.screen_from_fragment, &Aabb { min, max })
    }

    #[test]
    fn a_box_ahead_is_as_near_as_its_front() {
        let region = seen([-1.0, -1.0, -4.0], [1.0, 1.0, -2.0]).expect("it is in view");
        assert_eq!(
            region.rect,
            Rect {
                x0: 25,
                y0: 25,
                x1: 75,
                y1: 75
            }
        );
        assert!(region.nearest >= 0.5 && region.nearest < 0.500_01);
    }

    #[test]
    fn a_ceiling_that_reaches_behind_the_eye_is_as_near_as_where_it_enters_the_picture() {
        let region = seen([-9.0, 3.0, -20.0], [9.0, 3.1, 20.0]).expect("it is in view");
        assert!(
            region.nearest >= 1.0 / 3.0 && region.nearest < 0.334,
            "{region:?}"
        );
        assert!(region.rect.y0 == 0 && region.rect.y1 < 50, "{region:?}");
    }

    #[test]
    fn a_box_around_the_eye_is_everywhere_and_at_hand() {
        let region = seen([-1.0; 3], [1.0; 3]).expect("the eye is in it");
        assert_eq!(region.nearest, f32::INFINITY);
        assert_eq!(
            region.rect,
            Rect {
                x0: 0,
                y0: 0,
                x1: 100,
                y1: 100
            }
        );
    }

    #[test]
    fn a_box_beside_or_behind_the_picture_is_not_seen() {
        assert_eq!(seen([5.0, -1.0, -4.0], [6.0, 1.0, -3.0]), None);
        assert_eq!(seen([-1.0, -1.0, 1.0], [1.0, 1.0, 3.0]), None);
    }
}
