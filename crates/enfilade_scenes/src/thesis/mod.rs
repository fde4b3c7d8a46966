//! The figures of a thesis that compares the painter's algorithm with BSP trees, in pictures and timings.
//!
//! The painter's algorithm sorts polygons by one number, a key, and paints them back to front. The thesis compares two
//! keys: minimal z (W of the polygon's nearest corner) and mean z (mean of W over its corners), where W is the distance
//! along the view direction. Every polygon is an item (except in the four cylinders), so that a picture of item ids
//! shows where an order is wrong. All polygons are two-sided: with back-face culling the tetrahedron could not go
//! wrong.
//!
//! Source: the thesis "Painter's algorithm and binary space partitioning" (in Russian, author unknown), sections 2.2,
//! 2.3 and 3. It gives no coordinates. The coordinates here are chosen so that its statements hold whichever of two
//! equal keys comes first.

mod round;
mod sheets;
mod solids;

pub(crate) use round::{cone, cylinder, four_cylinders};
pub(crate) use sheets::{crossing_triangles, cycle, overlap, parallel_rectangles, parallel_triangles};
pub(crate) use solids::{tetrahedron, triangle_through_cube, wrong_winding};

use crate::BuiltIn;
use crate::shape::Shape;
use enfilade::{Camera, GeometryBuilder, Material, MaterialId, Method, SceneBuilder, Transform};
use glam::Vec3;

const RED: MaterialId = MaterialId(0);
const ORANGE: MaterialId = MaterialId(1);
const YELLOW: MaterialId = MaterialId(2);
const GREEN: MaterialId = MaterialId(3);
const TEAL: MaterialId = MaterialId(4);
const BLUE: MaterialId = MaterialId(5);
const VIOLET: MaterialId = MaterialId(6);
const ROSE: MaterialId = MaterialId(7);
const IVORY: MaterialId = MaterialId(8);

/// Around the wheel of hues, then [`IVORY`]; linear.
const COLORS: [[f32; 3]; 9] = [
    [0.70, 0.05, 0.05],
    [0.82, 0.27, 0.03],
    [0.82, 0.60, 0.06],
    [0.16, 0.47, 0.08],
    [0.02, 0.42, 0.40],
    [0.05, 0.18, 0.66],
    [0.27, 0.09, 0.52],
    [0.76, 0.17, 0.36],
    [0.80, 0.77, 0.68],
];

/// A figure under construction.
struct Figure {
    geometry: GeometryBuilder,
    place: Transform,
}

impl Figure {
    fn new() -> Figure {
        Figure::tilted(0.0)
    }

    /// Creates a figure whose top leans towards the eye: seen from above, with an upright sky.
    fn tilted(degrees: f64) -> Figure {
        let materials = COLORS.map(|color| Material {
            double_sided: true,
            ..Material::opaque(color)
        });
        Figure {
            geometry: GeometryBuilder::new(materials),
            place: Transform::rotation([1.0, 0.0, 0.0], degrees.to_radians()),
        }
    }

    /// Adds a flat convex polygon as an item.
    fn polygon(&mut self, name: &str, color: MaterialId, corners: &[Vec3]) {
        let mut shape = Shape::new();
        shape.face(color, corners);
        self.thing(name, &shape);
    }

    /// Adds all faces of a shape as one item.
    fn thing(&mut self, name: &str, shape: &Shape) {
        let mesh = self.geometry.mesh(shape.mesh());
        self.geometry.item(name, mesh, self.place);
    }

    fn seen_from(self, cameras: Vec<Camera>) -> BuiltIn {
        let mut scene = SceneBuilder::new();
        let geometry = self.geometry.build().expect("valid geometry");
        scene.add("figure", geometry, Method::HierarchicalZ);
        BuiltIn {
            scene: scene.build().expect("a scene of one sector"),
            cameras,
        }
    }
}
