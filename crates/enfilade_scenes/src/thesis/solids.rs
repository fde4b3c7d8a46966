//! Solids with few faces: the tetrahedron, the same with inconsistent winding, and a cube with a triangle through it.

use super::{BLUE, Figure, GREEN, IVORY, ORANGE, RED, ROSE, TEAL, VIOLET, YELLOW};
use crate::BuiltIn;
use crate::camera::camera_with_fov;
use enfilade::MaterialId;
use glam::{Vec3, vec3};

/// Near, left and right corner of the base, and the tip.
///
/// In W of the camera, near < tip < left and right. So the three faces at the near corner have equal minimal z.
const CORNERS: [Vec3; 4] = [
    vec3(0.27, -0.7, 1.22),
    vec3(-1.19, -0.7, -0.37),
    vec3(0.92, -0.7, -0.85),
    vec3(0.0, 1.0, 0.0),
];

/// The hidden base is between the visible faces, so that no order of equal keys ends up right.
const FACES: [(&str, MaterialId); 4] = [("right", BLUE), ("base", YELLOW), ("back", GREEN), ("left", RED)];

/// A tetrahedron. The painter's algorithm is right with mean z and wrong with minimal z.
///
/// The left and the right face are visible, red and blue. In minimal z the base is as near as they are, because it
/// shares the near corner: it is painted over one of them, and yellow shows.
pub(crate) fn tetrahedron() -> BuiltIn {
    tetrahedron_of([[0, 2, 3], [1, 2, 0], [2, 1, 3], [1, 0, 3]])
}

/// The same tetrahedron with inconsistent winding: two faces look outwards, two inwards.
///
/// The painter's algorithm ignores winding, so mean z is right here too. The thesis shows a wrong picture of its BSP
/// tree, which took fronts from the winding. A tree that tests the eye and the polygons against the same planes must be
/// right for any winding.
pub(crate) fn wrong_winding() -> BuiltIn {
    tetrahedron_of([[0, 2, 3], [2, 1, 0], [1, 2, 3], [3, 1, 0]])
}

fn tetrahedron_of(faces: [[usize; 3]; 4]) -> BuiltIn {
    let mut figure = Figure::tilted(30.0);
    for ((name, color), corners) in FACES.into_iter().zip(faces) {
        figure.polygon(name, color, &corners.map(|corner| CORNERS[corner]));
    }
    figure.seen_from(vec![camera_with_fov(
        "front",
        [-0.1, -0.4, 3.7],
        [-0.1, -0.05, 0.0],
        42.0,
    )])
}

/// A triangle through a cube. The painter's algorithm is wrong.
///
/// The triangle comes out of visible faces of the cube: before such a face on one side of the intersection line, behind
/// it on the other. Unsplit, it is painted over the cube or under it; a tree must split it, and its picture must not
/// show where.
pub(crate) fn triangle_through_cube() -> BuiltIn {
    let mut figure = Figure::new();
    let corner = |bits: usize| {
        let side = |bit: usize| if bits & bit == 0 { -0.8 } else { 0.8 };
        vec3(side(1), side(2), side(4))
    };
    for (name, color, corners) in [
        ("left", VIOLET, [0, 4, 6, 2]),
        ("right", BLUE, [1, 3, 7, 5]),
        ("bottom", GREEN, [0, 1, 5, 4]),
        ("top", IVORY, [2, 6, 7, 3]),
        ("back", ROSE, [0, 2, 3, 1]),
        ("front", TEAL, [4, 5, 7, 6]),
    ] {
        figure.polygon(name, color, &corners.map(corner));
    }
    figure.polygon(
        "triangle",
        ORANGE,
        &[vec3(-2.2, -0.6, 0.9), vec3(1.9, -0.3, 0.9), vec3(0.1, 1.7, -0.9)],
    );
    figure.seen_from(vec![camera_with_fov(
        "corner",
        [2.1, 1.6, 3.6],
        [0.0, 0.1, 0.0],
        45.0,
    )])
}
