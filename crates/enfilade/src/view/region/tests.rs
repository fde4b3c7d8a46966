//! Tests of the projection of boxes.

use super::*;
use crate::chance::{Dice, levels};
use crate::ids::SectorId;
use crate::view::passage::Passage;
use crate::view::{Camera, View};

/// Projects a box for an eye at the origin that looks along −z, with a field of view of 90 degrees and a square
/// viewport.
fn seen(min: [f32; 3], max: [f32; 3]) -> Option<Region> {
    let camera = Camera {
        fov_y: 90.0_f32.to_radians(),
        ..Camera::new([0.0; 3], [0.0, 0.0, -1.0])
    };
    let view = camera.view([100, 100]).expect("a valid view");
    let passage = Passage::at_the_eye(&view, SectorId(0), false);
    Region::of(&passage, &passage.screen_from_sector, &Aabb { min, max })
}

#[test]
fn a_box_ahead_is_as_near_as_its_front() {
    let region = seen([-1.0, -1.0, -4.0], [1.0, 1.0, -2.0]).expect("box in view");
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
    let region = seen([-9.0, 3.0, -20.0], [9.0, 3.1, 20.0]).expect("box in view");
    assert!(
        region.nearest >= 1.0 / 3.0 && region.nearest < 0.334,
        "{region:?}"
    );
    assert!(region.rect.y0 == 0 && region.rect.y1 < 50, "{region:?}");
}

#[test]
fn a_box_around_the_eye_is_everywhere_and_at_hand() {
    let region = seen([-1.0; 3], [1.0; 3]).expect("eye inside the box");
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

impl Volume {
    fn touched_one_by_one(
        &self,
        limits: &Rect,
        near: f64,
        entry: Option<(DVec3, f64)>,
    ) -> Option<ScreenBounds> {
        let corners = self.corners();
        let [middle, half] = middle_and_half(limits);
        let mut outside = 0b11_1111_u8;
        let [mut least, mut greatest] = [[f64::INFINITY; 3], [f64::NEG_INFINITY; 3]];
        for corner in &corners {
            let w = corner.z;
            let [x, y] = [corner.x - middle[0] * w, corner.y - middle[1] * w];
            let beyond_entry = entry.is_none_or(|(normal, d)| normal.dot(*corner) >= d * (1.0 - 1e-6));
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
        let nearest_w = nearest_w(&least, &greatest, near, &half);
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
                // w is between these two for all x and y.
                let [close, far] = [nearest_w, greatest[2]];
                min[axis] = middle[axis] + least[axis] / if least[axis] < 0.0 { close } else { far };
                max[axis] = middle[axis] + greatest[axis] / if greatest[axis] > 0.0 { close } else { far };
            }
        }
        Some(ScreenBounds {
            min,
            max,
            nearest: nearest(nearest_w, near),
        })
    }
}

/// Normalizes a result for comparison: zero has no sign, and all NaNs are equal.
fn spoken(touched: ScreenBounds) -> String {
    let ScreenBounds { min, max, nearest } = touched;
    let sides = [min[0], min[1], max[0], max[1]].map(|value| value + 0.0);
    format!("{sides:?} {nearest:?}")
}

#[test]
fn eight_corners_at_once_touch_what_they_touch_one_by_one_at_every_level() {
    let mut dice = Dice::new(23);
    let mut seen = 0;
    let limits = Rect {
        x0: 10,
        y0: 0,
        x1: 90,
        y1: 77,
    };
    for round in 0..20_000 {
        let mut vector = |most: f64| {
            let mut odd = || {
                if round % 4 == 0 {
                    dice.odd(most)
                } else {
                    dice.within(most)
                }
            };
            DVec3::new(odd(), odd(), odd())
        };
        let volume = Volume {
            origin: vector(60.0) + DVec3::new(40.0, 40.0, 1.0),
            sides: [vector(30.0), vector(30.0), vector(30.0)],
            is_parallel: false,
        };
        let entry = (round % 3 == 0).then(|| (vector(1.0), 0.5));
        let expected = volume.touched_one_by_one(&limits, 0.1, entry);
        seen += u32::from(expected.is_some());
        for level in levels() {
            let clip = Clip {
                rect: limits,
                near: 0.1,
                entry,
                spread: 0.0,
                level,
            };
            let known = dispatch!(level, simd => volume.touched(simd, &clip));
            assert_eq!(known.map(spoken), expected.map(spoken), "{volume:?}");
        }
    }
    assert!(seen > 2000, "{seen}");
}

fn somewhere(dice: &mut Dice, most: f64) -> [f32; 3] {
    [(); 3].map(|()| dice.within(most) as f32)
}

#[test]
fn eight_boxes_at_once_are_seen_as_one_by_one_at_every_level() {
    let mut dice = Dice::new(29);
    let mut seen = 0;
    for round in 0..2_000 {
        let camera = Camera {
            z_near: Some(0.01 + dice.within(0.005) as f32),
            ..Camera::new(somewhere(&mut dice, 3.0), somewhere(&mut dice, 9.0))
        };
        let size = [100 + round % 7, 60 + round % 5];
        let view = match round % 3 {
            0 => View::parallel(camera.eye, camera.toward, camera.up, 12.0, size),
            _ => camera.view(size),
        };
        let view = view.expect("a valid view");
        let mut passage = Passage::at_the_eye(&view, SectorId(0), false);
        passage.fit(&Aabb {
            min: [-4.0; 3],
            max: [4.0; 3],
        });
        passage.spread = [0.5, 0.0, 0.01][round as usize % 3];
        if round % 4 == 0 {
            passage.entry = Some((DVec3::from(somewhere(&mut dice, 1.0).map(f64::from)), 0.5));
        }
        let boxes: [Aabb; BOXES] = std::array::from_fn(|number| {
            if number == 5 {
                return Aabb::EMPTY;
            }
            Aabb::of([somewhere(&mut dice, 8.0), somewhere(&mut dice, 8.0)])
        });
        let count = 1 + round as usize % BOXES;
        let space = passage.screen_from_sector;
        let expected = boxes.map(|bounds| Region::of(&passage, &space, &bounds));
        for level in levels() {
            passage.level = level;
            let eight = EightBoxes::of(&passage, &space, &boxes[..count]);
            let known: [Option<Region>; BOXES] = std::array::from_fn(|lane| eight.region(lane));
            assert_eq!(known[..count], expected[..count], "{boxes:?}");
            assert!(known[count..].iter().all(Option::is_none));
        }
        seen += expected.iter().flatten().count();
    }
    assert!(seen > 4_000, "{seen}");
}
