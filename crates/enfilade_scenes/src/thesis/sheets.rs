//! Several sheets: parallel, intersecting, cyclically overlapping, one extending past another.

use super::{BLUE, Figure, GREEN, ORANGE, RED, TEAL, VIOLET, YELLOW};
use crate::BuiltIn;
use crate::camera::camera_with_fov;
use enfilade::Transform;
use glam::{Vec3, vec3};

/// Three parallel triangles, the largest farthest away. Both sorts are right.
///
/// All corners of one are nearer than all corners of the next, so either key gives the order.
pub(crate) fn parallel_triangles() -> BuiltIn {
    let mut figure = Figure::new();
    let triangle = |[a, b, c]: [[f32; 2]; 3], z: f32| [a, b, c].map(|[x, y]| vec3(x, y, z));
    // Painted by item index they would be wrong: the sort must find the order.
    figure.polygon(
        "middle",
        YELLOW,
        &triangle([[-0.9, -1.3], [2.3, -1.1], [0.9, 1.5]], 0.0),
    );
    figure.polygon(
        "small",
        RED,
        &triangle([[-1.4, -1.0], [0.5, -1.2], [-0.3, 0.7]], 1.0),
    );
    figure.polygon(
        "large",
        BLUE,
        &triangle([[-2.9, -1.7], [1.7, -1.9], [-0.4, 2.5]], -1.0),
    );
    figure.seen_from(vec![camera_with_fov(
        "front",
        [0.5, 0.2, 5.6],
        [-0.1, 0.25, 0.0],
        48.0,
    )])
}

/// Three parallel rectangles, each over a corner of the next. Every method is right.
pub(crate) fn parallel_rectangles() -> BuiltIn {
    let mut figure = Figure::new();
    let mut rectangle = |name: &str, color, [x, y, z]: [f32; 3]| {
        let corner = vec3(x, y, z);
        let [along, up] = [2.6 * Vec3::X, 1.7 * Vec3::Y];
        figure.polygon(
            name,
            color,
            &[corner, corner + along, corner + along + up, corner + up],
        );
    };
    rectangle("middle", ORANGE, [-1.3, -0.85, 0.0]);
    rectangle("near", TEAL, [-2.1, -1.5, 0.8]);
    rectangle("far", VIOLET, [-0.4, -0.1, -0.8]);
    figure.seen_from(vec![camera_with_fov(
        "front",
        [0.7, 0.2, 4.8],
        [0.0, 0.0, 0.0],
        48.0,
    )])
}

/// Two intersecting triangles. Both sorts are wrong, as is every order of unsplit polygons.
///
/// Each is the nearer one on its side of the intersection line; painted whole, the last hides half of the other.
pub(crate) fn crossing_triangles() -> BuiltIn {
    let mut figure = Figure::new();
    figure.polygon(
        "upright",
        RED,
        &[vec3(-1.9, -1.5, 1.0), vec3(1.9, -1.5, -1.0), vec3(0.0, 1.9, 0.0)],
    );
    figure.polygon(
        "on its tip",
        TEAL,
        &[vec3(-2.1, 1.1, -1.2), vec3(0.2, -1.8, 0.1), vec3(2.1, 1.2, 1.1)],
    );
    figure.seen_from(vec![camera_with_fov(
        "front",
        [0.4, -0.1, 5.2],
        [0.05, 0.05, 0.0],
        45.0,
    )])
}

/// Three bars that overlap cyclically without touching. Both sorts are wrong.
///
/// Each bar is before the next at one end and behind the last at the other, so none of the six orders is right; a tree
/// must split one.
pub(crate) fn cycle() -> BuiltIn {
    let mut figure = Figure::new();
    for (name, color, turn) in [
        ("first", ORANGE, 0.0),
        ("second", GREEN, 1.0),
        ("third", VIOLET, 2.0),
    ] {
        let place = Transform::rotation([0.0, 0.0, 1.0], turn * 2.0 * std::f64::consts::PI / 3.0)
            * Transform::translation([0.0, -0.78, 0.0])
            * Transform::rotation([0.0, 1.0, 0.0], 0.25);
        let corners = [[-2.5, -0.36], [2.5, -0.36], [2.5, 0.36], [-2.5, 0.36]]
            .map(|[x, y]| Vec3::from(place.point([x, y, 0.0])));
        figure.polygon(name, color, &corners);
    }
    figure.seen_from(vec![camera_with_fov(
        "front",
        [0.9, -0.1, 9.8],
        [0.0, 0.35, 0.0],
        31.0,
    )])
}

/// A sail before a long wall that runs away from the eye.
///
/// The wall's near end is nearer than all of the sail: minimal z paints the wall last, over the sail. Mean z uses the
/// wall's middle, which from `mean right` is farther than the sail's. For `mean wrong` the eye moves to the left and
/// looks along the wall: now the sail's middle is the farther one, though the sail is still before the wall.
pub(crate) fn overlap() -> BuiltIn {
    let mut figure = Figure::new();
    figure.polygon(
        "sail",
        VIOLET,
        &[vec3(0.5, -1.5, 0.2), vec3(2.3, -1.0, -0.4), vec3(1.2, 1.8, 0.1)],
    );
    figure.polygon(
        "wall",
        YELLOW,
        &[
            vec3(-2.6, -1.1, 2.0),
            vec3(2.6, -1.1, -2.0),
            vec3(2.6, 1.4, -2.0),
            vec3(-2.6, 1.4, 2.0),
        ],
    );
    figure.seen_from(vec![
        camera_with_fov("mean right", [2.0, 0.0, 6.2], [0.0, 0.2, 0.0], 48.0),
        camera_with_fov("mean wrong", [-0.9, 0.0, 6.6], [-0.1, 0.2, 0.0], 48.0),
    ])
}
