//! Paintings in gilded frames.

use super::palette::{dress, painted};
use super::room::{Room, shift};
use super::textures::{ASPECT, BROAD, HIGH};
use crate::shape::{Shape, frame};
use enfilade::{MaterialId, Mesh, Transform};
use enfilade_scenes::Random;
use glam::{Vec3, vec2, vec3};
use std::sync::Arc;

/// Adds a painting of the given size; `place` is the wall frame at its lower left corner.
pub(crate) fn hang_painting(room: &mut Room, place: Transform, size: [f32; 2], gilt: MaterialId) {
    let border = gilded_frame(room, size, gilt);
    room.put("picture frame", &border, place);
    let canvas = painting(&mut room.random, size).dressed(dress);
    room.put("painting", &canvas, place * shift(0.0, 0.0, 0.2 * breadth(size)));
}

/// Width of a painting's frame.
fn breadth(size: [f32; 2]) -> f32 {
    0.10 + 0.04 * size[0].min(size[1])
}

/// A frame for a painting of the given size, its lower left corner at the origin.
pub(crate) fn gilded_frame(room: &mut Room, size: [f32; 2], gilt: MaterialId) -> Arc<Mesh> {
    let broad = breadth(size);
    room.shop.piece(format!("frame {size:?} {}", gilt.0), || {
        const PROFILE: [[f32; 2]; 10] = [
            [-1.0, 0.0],
            [-1.0, 0.35],
            [-0.85, 0.55],
            [-0.70, 0.45],
            [-0.60, 0.50],
            [-0.35, 0.75],
            [-0.20, 0.70],
            [-0.15, 0.55],
            [0.0, 0.40],
            [0.0, 0.15],
        ];
        frame(
            gilt,
            size,
            &PROFILE.map(|[inwards, out]| [inwards * broad, out * broad]),
        )
    })
}

/// A painting in the plane z = 0, its lower left corner at the origin. Chooses a picture of similar aspect ratio,
/// cropped to fit.
fn painting(random: &mut Random, [wide, high]: [f32; 2]) -> Shape {
    let broad = wide >= high;
    let (number, aspect) = if broad {
        (random.below(BROAD), ASPECT)
    } else {
        (BROAD + random.below(HIGH), 1.0 / ASPECT)
    };
    let [u, v] = if wide / high > aspect {
        [1.0, aspect * high / wide]
    } else {
        [wide / high / aspect, 1.0]
    };
    // The subject is in the lower part of a picture.
    let [left, top] = [0.5 * (1.0 - u), 0.7 * (1.0 - v)];
    let [right, bottom] = [left + u, top + v];
    let mut shape = Shape::new();
    shape.placed(
        painted(number),
        &[
            Vec3::ZERO,
            vec3(wide, 0.0, 0.0),
            vec3(wide, high, 0.0),
            vec3(0.0, high, 0.0),
        ],
        &[
            vec2(left, bottom),
            vec2(right, bottom),
            vec2(right, top),
            vec2(left, top),
        ],
    );
    shape
}
