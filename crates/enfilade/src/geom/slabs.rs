//! Ray/AABB intersection by the slab method.
//!
//! A box is the intersection of three slabs; the ray is inside the box while it is inside all three.
//! Source: Kay, Kajiya, Ray Tracing Complex Scenes, SIGGRAPH 1986.
//! Cost: three products and six comparisons for each slab; no division.
//! Monotone: a box contained in another is entered no earlier and left no later, to the last bit, so that whole
//! subtrees may be skipped.

use super::Aabb;
use glam::{DAffine3, DVec3, Vec3, Vec3A};
use std::cmp::Ordering;

/// A ray in f64: the points `origin + t · direction` with t ≥ 0.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Line {
    pub(crate) origin: DVec3,
    pub(crate) direction: DVec3,
    inverse: DVec3,
}

impl Line {
    /// Creates a ray; `None` if a number is not finite or the direction is zero.
    pub(crate) fn new(origin: DVec3, direction: DVec3) -> Option<Line> {
        let sound = origin.is_finite() && direction.is_finite() && direction != DVec3::ZERO;
        sound.then(|| Line {
            origin,
            direction,
            inverse: direction.recip(),
        })
    }

    /// Returns the same ray in another space. Points on it keep their parameter t.
    pub(crate) fn moved(&self, there_from_here: &DAffine3) -> Line {
        let direction = there_from_here.transform_vector3(self.direction);
        Line {
            origin: there_from_here.transform_point3(self.origin),
            direction,
            inverse: direction.recip(),
        }
    }

    /// Intersects the ray with a box enlarged by `margin`. Returns the parameters of entry (0 if the origin is inside)
    /// and exit; `None` if the ray misses the box or enters it beyond `limit`. Returns `Some` when unsure.
    #[inline]
    pub(crate) fn meets(&self, bounds: &Aabb, margin: f64, limit: f64) -> Option<[f64; 2]> {
        let [mut enter, mut leave] = [0.0_f64, f64::INFINITY];
        for axis in 0..3 {
            let low = f64::from(bounds.min[axis]) - margin - self.origin[axis];
            let high = f64::from(bounds.max[axis]) + margin - self.origin[axis];
            if self.direction[axis] == 0.0 {
                if low > 0.0 || high < 0.0 {
                    return None;
                }
            } else {
                let [a, b] = [low * self.inverse[axis], high * self.inverse[axis]];
                enter = enter.max(a.min(b));
                leave = leave.min(a.max(b));
            }
        }
        // Entry and exit of a flat box coincide; rounding must not turn a hit into a miss.
        (enter <= limit && enter <= leave + 1e-9 * leave.abs()).then_some([enter, leave])
    }

    /// Returns the margin by which boxes in the space of this ray must grow to contain points computed in another
    /// space.
    #[inline]
    pub(crate) fn margin(&self, bounds: &Aabb) -> f64 {
        let farthest = bounds
            .min
            .iter()
            .chain(&bounds.max)
            .fold(0.0_f32, |most, value| most.max(value.abs()));
        1e-10 * (f64::from(farthest) + self.origin.abs().max_element())
    }
}

/// A ray in f32, for a first test of many boxes in a space whose coordinates are at most as large as given.
#[derive(Clone, Copy, Debug)]
pub(crate) struct QuickLine {
    /// The origin, plus and minus a margin.
    above: Vec3A,
    below: Vec3A,
    inverse: Vec3A,
    /// Length of the parameter of [`Line`] in that of this ray, of which a step is at most 1 along each axis.
    scale: f64,
}

impl Line {
    /// Returns the ray for boxes inside `space`.
    #[inline]
    pub(crate) fn quick(&self, space: &Aabb) -> QuickLine {
        let farthest = Vec3::from(space.min)
            .abs()
            .max(Vec3::from(space.max).abs())
            .max_element();
        let origin = self.origin.as_vec3a();
        // More than the rounding of the origin and of differences from it, and than `Line::margin`.
        let margin = Vec3A::splat(4e-7 * (farthest + origin.abs().max_element()));
        let scale = self.direction.abs().max_element();
        if !margin.is_finite() {
            // Beyond the range of f32; this ray may meet every box.
            let zero = Vec3A::ZERO;
            return QuickLine {
                above: zero,
                below: zero,
                inverse: zero,
                scale: 0.0,
            };
        }
        // Along a side that is nearly parallel to it, the ray moves by less than the margin.
        let inverse = (self.inverse * scale).clamp(DVec3::splat(-1e18), DVec3::splat(1e18));
        QuickLine {
            above: origin + margin,
            below: origin - margin,
            inverse: inverse.as_vec3a(),
            scale,
        }
    }
}

impl QuickLine {
    /// Returns `true` if [`Line::meets`] may return `Some` for a box inside the space, with the margin of
    /// [`Line::margin`].
    #[inline]
    pub(crate) fn may_meet(&self, bounds: &Aabb, limit: f64) -> bool {
        let low = (Vec3A::from(bounds.min) - self.above) * self.inverse;
        let high = (Vec3A::from(bounds.max) - self.below) * self.inverse;
        let enter = low.min(high).max_element().max(0.0);
        let leave = low.max(high).min_element().min((limit * self.scale) as f32);
        // NaN must not miss a box.
        enter.partial_cmp(&(leave * (1.0 + 1e-6))) != Some(Ordering::Greater)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::chance::Dice;

    #[test]
    fn a_box_within_another_is_entered_no_earlier_and_a_flat_one_at_once() {
        let line = Line::new(DVec3::new(-3.0, 0.5, 0.5), DVec3::new(2.0, 0.1, 0.0)).expect("a line");
        let unit = Aabb {
            min: [0.0; 3],
            max: [1.0; 3],
        };
        let flat = Aabb {
            min: [0.25, 0.0, 0.0],
            max: [0.25, 1.0, 1.0],
        };
        let [whole, part] =
            [unit, flat].map(|bounds| line.meets(&bounds, 0.0, 9.0).expect("the ray hits the box"));
        assert_eq!(whole, [1.5, 2.0]);
        assert_eq!(part, [1.625; 2]);
        assert_eq!(line.meets(&unit, 0.0, 1.4), None);
    }

    #[test]
    fn a_quick_ray_meets_every_box_that_a_ray_meets_and_few_others() {
        let mut dice = Dice::new(3);
        let [mut met, mut more] = [0; 2];
        for _ in 0..20_000 {
            let far = dice.by_ratio(1e-6, 1e12);
            let mut direction = dice.direction() * dice.by_ratio(1e-30, 1e30);
            if dice.below(3) == 0 {
                direction[dice.below(3)] = 0.0;
            }
            let origin = dice.point(far) * dice.by_ratio(1e-3, 1e3);
            let Some(line) = Line::new(origin, direction) else {
                continue;
            };
            let boxed = |dice: &mut Dice| {
                let [a, b] = [(); 2].map(|()| dice.point(far).as_vec3());
                let [mut a, mut b] = [a, a.lerp(b, dice.by_ratio(1e-4, 1.0) as f32)];
                let axis = dice.below(3);
                match dice.below(4) {
                    // Flat, or in line with the origin along an axis.
                    0 => b[axis] = a[axis],
                    1 => a[axis] = origin.as_vec3()[axis],
                    _ => {}
                }
                Aabb::of([a.into(), b.into()])
            };
            let boxes = [(); 8].map(|()| boxed(&mut dice));
            let space = boxes.iter().fold(Aabb::EMPTY, |sum, held| sum.union(held));
            let quick = line.quick(&space);
            for bounds in &boxes {
                let limit = match line.meets(bounds, line.margin(bounds), f64::INFINITY) {
                    // Just as far as the box.
                    Some([enter, _]) if dice.below(2) == 0 => enter,
                    _ => f64::INFINITY,
                };
                let meets = line.meets(bounds, line.margin(bounds), limit).is_some();
                let may_meet = quick.may_meet(bounds, limit);
                assert!(may_meet || !meets, "{line:?}, {bounds:?}, {limit}");
                met += usize::from(meets);
                more += usize::from(may_meet && !meets);
            }
        }
        assert!(
            met > 500 && more < met / 10,
            "{met} boxes are met, and {more} others"
        );
        let outside = Line::new(DVec3::splat(1e60), DVec3::X).expect("a line");
        assert!(
            outside
                .quick(&Aabb::of([[1.0; 3]]))
                .may_meet(&Aabb::of([[1.0; 3]]), 1.0)
        );
    }

    #[test]
    fn nothing_lies_along_a_line_without_direction() {
        assert!(Line::new(DVec3::ZERO, DVec3::ZERO).is_none());
        assert!(Line::new(DVec3::NAN, DVec3::X).is_none());
    }
}
