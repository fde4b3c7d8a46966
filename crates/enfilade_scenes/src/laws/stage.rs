//! Builds a sector of a small scene.

use crate::BuiltIn;
use crate::envelope::{Side, envelope};
use crate::shape::Shape;
use enfilade::{
    Alpha, BakedCells, Camera, ConvexPolygon, Geometry, GeometryBuilder, Light, Material, MaterialId, Mesh,
    Method, OpeningId, PortalEnd, SceneBuilder, SectorId, Transform,
};
use glam::{Vec3, vec2, vec3};
use std::sync::Arc;

pub(crate) const GREY: MaterialId = MaterialId(0);
pub(crate) const WHITE: MaterialId = MaterialId(1);
pub(crate) const RED: MaterialId = MaterialId(2);
pub(crate) const GREEN: MaterialId = MaterialId(3);
pub(crate) const BLUE: MaterialId = MaterialId(4);
pub(crate) const YELLOW: MaterialId = MaterialId(5);
pub(crate) const BROWN: MaterialId = MaterialId(6);
/// Two-sided, as the three after it.
pub(crate) const RED_SHEET: MaterialId = MaterialId(7);
pub(crate) const GREEN_SHEET: MaterialId = MaterialId(8);
pub(crate) const BLUE_SHEET: MaterialId = MaterialId(9);
pub(crate) const YELLOW_SHEET: MaterialId = MaterialId(10);
/// Alpha-tested.
pub(crate) const LEAF: MaterialId = MaterialId(11);
pub(crate) const BLUE_GLASS: MaterialId = MaterialId(12);
pub(crate) const RED_GLASS: MaterialId = MaterialId(13);

/// Returns the materials of all small scenes.
fn materials() -> [Material; 14] {
    let sheet = |color| Material {
        double_sided: true,
        ..Material::opaque(color)
    };
    let [red, green, blue] = [[0.6, 0.05, 0.04], [0.06, 0.4, 0.08], [0.05, 0.12, 0.6]];
    let yellow = [0.75, 0.6, 0.08];
    let glass = |[r, g, b]: [f32; 3]| Material {
        base_color: [r, g, b, 0.4],
        alpha: Alpha::Blend,
        ..sheet([r, g, b])
    };
    [
        Material::opaque([0.35, 0.34, 0.32]),
        Material::opaque([0.8, 0.8, 0.78]),
        Material::opaque(red),
        Material::opaque(green),
        Material::opaque(blue),
        Material::opaque(yellow),
        Material::opaque([0.3, 0.16, 0.06]),
        sheet(red),
        sheet(green),
        sheet(blue),
        sheet(yellow),
        Material {
            alpha: Alpha::Mask,
            ..sheet([0.1, 0.35, 0.05])
        },
        glass(blue),
        glass(red),
    ]
}

/// A sector under construction.
pub(crate) struct Stage {
    geometry: GeometryBuilder,
}

impl Stage {
    pub(crate) fn new() -> Stage {
        Stage {
            geometry: GeometryBuilder::new(materials()),
        }
    }

    /// Adds an item with an identity transform.
    pub(crate) fn thing(&mut self, name: &str, shape: &Shape) {
        self.copies(name, &shape.mesh(), [Transform::IDENTITY]);
    }

    /// Adds an item with a transform.
    pub(crate) fn placed(&mut self, name: &str, shape: &Shape, at: Transform) {
        self.copies(name, &shape.mesh(), [at]);
    }

    /// Adds several items with one mesh and one name.
    pub(crate) fn copies(
        &mut self,
        name: &str,
        mesh: &Arc<Mesh>,
        places: impl IntoIterator<Item = Transform>,
    ) {
        let id = self.geometry.mesh(Arc::clone(mesh));
        for at in places {
            self.geometry.item(name, id, at);
        }
    }

    /// Adds an opening; counter-clockwise as seen from its front, from which one enters.
    pub(crate) fn opening(&mut self, name: &str, outline: &[Vec3]) -> OpeningId {
        let corners: Vec<[f32; 3]> = outline.iter().map(|corner| corner.to_array()).collect();
        self.geometry.opening(
            name,
            ConvexPolygon::new(&corners).expect("openings are drawn flat and convex"),
        )
    }

    /// Adds the inside of a box-shaped room with its floor at y = 0, with doorways; returns their openings.
    pub(crate) fn room(
        &mut self,
        x: [f32; 2],
        z: [f32; 2],
        height: f32,
        doorways: &[Doorway],
    ) -> Vec<OpeningId> {
        let inside = envelope(x, z, height, doorways);
        self.thing("floor", &inside.floor);
        for wall in &inside.walls {
            self.thing("wall", wall);
        }
        self.thing("ceiling", &inside.ceiling);
        doorways
            .iter()
            .map(|door| self.opening(door.name, &door.outline()))
            .collect()
    }

    /// Attaches baked cells to the sector.
    pub(crate) fn cells(&mut self, cells: BakedCells) {
        self.geometry.cells(cells);
    }

    pub(crate) fn build(self) -> Geometry {
        self.geometry
            .build()
            .expect("small worlds are made of sound things")
    }
}

/// A rectangular hole in a wall of a room: the wall, the coordinate of the opening's plane, the extent along the wall
/// (in x or z, ascending), and the heights of its lower and upper edge.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Doorway {
    pub(crate) name: &'static str,
    pub(crate) side: Side,
    pub(crate) plane: f32,
    pub(crate) along: [f32; 2],
    pub(crate) up: [f32; 2],
}

impl Doorway {
    /// Returns the outline, counter-clockwise as seen from the room.
    pub(crate) fn outline(&self) -> Vec<Vec3> {
        let ahead = self.side.direction();
        let right = vec2(-ahead.y, ahead.x);
        let [from, to] = if right.x + right.y > 0.0 {
            self.along
        } else {
            [self.along[1], self.along[0]]
        };
        let corner = |along: f32, up: f32| {
            if ahead.x == 0.0 {
                vec3(along, up, self.plane)
            } else {
                vec3(self.plane, up, along)
            }
        };
        let [low, high] = self.up;
        vec![
            corner(from, low),
            corner(to, low),
            corner(to, high),
            corner(from, high),
        ]
    }

    /// Returns the same hole as seen from the room on the other side.
    pub(crate) fn other_side(&self) -> Doorway {
        Doorway {
            side: self.side.opposite(),
            ..*self
        }
    }
}

/// Creates a rectangle from its lower left corner, as seen from its front.
pub(crate) fn sheet(material: MaterialId, corner: Vec3, along: Vec3, up: Vec3) -> Shape {
    let mut shape = Shape::new();
    shape.face(
        material,
        &[corner, corner + along, corner + along + up, corner + up],
    );
    shape
}

/// Creates a scene of one sector.
pub(crate) fn alone(stage: Stage, cameras: Vec<Camera>) -> BuiltIn {
    let mut scene = SceneBuilder::new();
    scene.add("world", stage.build(), Method::HierarchicalZ);
    finished(scene, cameras)
}

/// Adds a white lamp to a sector; `range` in metres.
pub(crate) fn lamp(scene: &mut SceneBuilder, sector: SectorId, position: [f32; 3], range: f32) {
    let strength = 0.05 * range * range;
    let color = [strength, 0.92 * strength, 0.78 * strength];
    scene.light(Light::point(sector, position, color, range));
}

/// Adds two sectors in one space, joined by a door between an opening of each.
pub(crate) fn joined(
    (here, out): (Stage, OpeningId),
    (there, back): (Stage, OpeningId),
    cameras: Vec<Camera>,
) -> BuiltIn {
    let mut scene = SceneBuilder::new();
    let here = scene.add("here", here.build(), Method::HierarchicalZ);
    let there = scene.add("there", there.build(), Method::HierarchicalZ);
    scene.door((here, out), (there, back));
    finished(scene, cameras)
}

/// Adds a portal and its reverse.
pub(crate) fn both_ways(
    scene: &mut SceneBuilder,
    here: impl Into<PortalEnd>,
    there: impl Into<PortalEnd>,
    there_from_here: Transform,
) {
    let (here, there) = (here.into(), there.into());
    let here_from_there = there_from_here
        .inverse()
        .expect("a turn and a scale can be undone");
    scene.portal(here.clone(), there.clone(), there_from_here);
    scene.portal(there, here, here_from_there);
}

pub(crate) fn finished(scene: SceneBuilder, cameras: Vec<Camera>) -> BuiltIn {
    BuiltIn {
        scene: scene.build().expect("small worlds are joined soundly"),
        cameras,
    }
}
