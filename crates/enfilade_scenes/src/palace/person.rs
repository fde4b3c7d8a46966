//! Figures of people, to be moved through the palace.

use super::head::{Hair, head};
use super::palette::{
    BLUE_SILK, DARK_RED, GREEN_SILK, MAHOGANY, NIGHT_BLUE, PALE_BLUE, ROSE, TERRACOTTA, YELLOW_SILK, dress,
};
use super::room::shift;
use super::statue::walking;
use enfilade::{MaterialId, Mesh};
use std::sync::Arc;

const CLOTHS: [MaterialId; 7] = [
    BLUE_SILK,
    DARK_RED,
    GREEN_SILK,
    NIGHT_BLUE,
    PALE_BLUE,
    ROSE,
    YELLOW_SILK,
];

/// Creates the mesh of a person in a long robe, 1.9 m tall, at the origin, facing +z. Its materials exist in every
/// sector of `@enfilade`. `number` selects one of seven variants.
pub fn person(number: usize) -> Arc<Mesh> {
    let cloth = CLOTHS[number % CLOTHS.len()];
    let (skin, hair) = if number.is_multiple_of(2) {
        (TERRACOTTA, Hair::Knot)
    } else {
        (MAHOGANY, Hair::Beard)
    };
    let (mut shape, neck) = walking(cloth, skin);
    shape.add(&head(skin, 0.27, hair), shift(neck.x, neck.y, neck.z));
    shape.dressed(dress)
}
