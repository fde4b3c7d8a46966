//! A room under construction: items are added, holes are cut, and at the end its envelope is built around them.

use super::floor::Floor;
use super::lamps::{Lamp, chosen};
use super::palette::{dress, geometry};
use super::workshop::Workshop;
use crate::envelope::{Ceiling, Envelope, Finish, Hole, Plan, Side, envelope};
use crate::shape::Shape;
use enfilade::{
    ConvexPolygon, Geometry, GeometryBuilder, HeightField, MaterialId, Mesh, MeshId, Method, OpeningId,
    SceneBuilder, SectorId, Transform,
};
use enfilade_scenes::Random;
use glam::{Vec2, Vec3, vec2};
use std::collections::HashMap;
use std::sync::Arc;

/// Height of the paving above the closed floor beneath it, in metres.
pub(crate) const PAVING: f32 = 0.02;

/// Shape and style of a room, without items.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Design {
    pub(crate) name: &'static str,
    pub(crate) plan: Plan,
    /// Height of the walls.
    pub(crate) height: f32,
    pub(crate) ceiling: Ceiling,
    pub(crate) style: Style,
}

/// Materials of a room, from the floor up.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Style {
    pub(crate) floor: Floor,
    /// Skirting, door frames, the cornice.
    pub(crate) trim: MaterialId,
    /// Edges of the trim and frames of the panels.
    pub(crate) gilt: MaterialId,
    /// The wall below the rail, and above it.
    pub(crate) dado: MaterialId,
    pub(crate) wall: MaterialId,
    /// Panel fields within their frames.
    pub(crate) field: MaterialId,
    pub(crate) ceiling: MaterialId,
    /// Sides of doorways and windows.
    pub(crate) reveal: MaterialId,
}

/// A doorway or window, in wall coordinates.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Doorway {
    /// Index of the wall on the plan.
    pub(crate) wall: usize,
    /// Distance from the wall's left end to the middle of the doorway.
    pub(crate) along: f32,
    pub(crate) width: f32,
    /// Height of the lower edge; 0 for doors.
    pub(crate) sill: f32,
    /// Height where the arch begins, and height of the arch.
    pub(crate) spring: f32,
    pub(crate) rise: f32,
    /// Distance from the wall to the plane of the opening.
    pub(crate) depth: f32,
}

impl Doorway {
    /// Returns the extent along the wall that it occupies, with a margin on both sides.
    pub(crate) fn reach(&self, margin: f32) -> [f32; 2] {
        let half = 0.5 * self.width + margin;
        [self.along - half, self.along + half]
    }
}

/// A wall of a room, as seen from inside.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Wall {
    pub(crate) left: Vec2,
    pub(crate) right: Vec2,
}

/// A finished room.
pub(crate) struct FinishedRoom {
    pub(crate) geometry: Geometry,
    mirrors: Vec<OpeningId>,
    pub(crate) lamps: Vec<Lamp>,
}

/// A room under construction.
pub(crate) struct Room<'a> {
    pub(crate) design: Design,
    pub(crate) shop: &'a mut Workshop,
    pub(crate) random: Random,
    pub(crate) holes: Vec<Hole>,
    pub(crate) doorways: Vec<Doorway>,
    /// For each wall, the extents along it that panels must leave free.
    pub(crate) taken: Vec<Vec<[f32; 2]>>,
    /// Mirrors added so far.
    pub(crate) mirrors: Vec<OpeningId>,
    /// Lamps, and candles that become lamps if there are too few.
    pub(crate) lamps: Vec<Lamp>,
    pub(crate) candles: Vec<Lamp>,
    geometry: GeometryBuilder,
    meshes: HashMap<*const Mesh, MeshId>,
    counts: HashMap<String, u32>,
}

impl Wall {
    pub(crate) fn length(&self) -> f32 {
        self.left.distance(self.right)
    }

    /// Returns the frame `along` metres from the wall's left end and `up` from the floor: x right, y up, z out of the
    /// wall.
    pub(crate) fn at(&self, along: f32, up: f32) -> Transform {
        let right = (self.right - self.left).normalize();
        let at = self.left + right * along;
        Transform::from_columns([
            [right.x, 0.0, right.y],
            [0.0, 1.0, 0.0],
            [-right.y, 0.0, right.x],
            [at.x, up, at.y],
        ])
    }

    /// Returns the distance along the wall of the point nearest to a plan position.
    pub(crate) fn along(&self, point: Vec2) -> f32 {
        (point - self.left).dot((self.right - self.left).normalize())
    }
}

/// Returns a position on the paving, rotated counter-clockwise as seen from above; fronts face +z without rotation.
pub(crate) fn spot(x: f32, z: f32, degrees: f32) -> Transform {
    Transform::translation([x, PAVING, z])
        * Transform::rotation([0.0, 1.0, 0.0], f64::from(degrees).to_radians())
}

/// Returns a translation.
pub(crate) fn shift(x: f32, y: f32, z: f32) -> Transform {
    Transform::translation([x, y, z])
}

/// Returns a uniform scaling.
pub(crate) fn scaled(factor: f32) -> Transform {
    Transform::scaling([factor; 3])
}

impl<'a> Room<'a> {
    pub(crate) fn new(design: Design, shop: &'a mut Workshop, random: Random) -> Room<'a> {
        let walls = design.plan.corners().len();
        Room {
            design,
            shop,
            random,
            holes: Vec::new(),
            doorways: Vec::new(),
            taken: vec![Vec::new(); walls],
            mirrors: Vec::new(),
            lamps: Vec::new(),
            candles: Vec::new(),
            geometry: geometry(),
            meshes: HashMap::new(),
            counts: HashMap::new(),
        }
    }

    /// Adds an item. Items of one name are numbered.
    pub(crate) fn put(&mut self, thing: &str, mesh: &Arc<Mesh>, at: Transform) {
        let count = self.counts.entry(thing.to_owned()).or_default();
        *count += 1;
        let name = format!("{}: {thing} {count}", self.design.name);
        let id =
            *(self.meshes.entry(Arc::as_ptr(mesh))).or_insert_with(|| self.geometry.mesh(Arc::clone(mesh)));
        self.geometry.item(&name, id, at);
    }

    /// Adds a unique item, with an identity transform.
    pub(crate) fn make(&mut self, thing: &str, shape: &Shape) {
        self.put(thing, &shape.dressed(dress), Transform::IDENTITY);
    }

    /// Adds an opening; its front faces the room.
    pub(crate) fn opening(&mut self, name: &str, outline: &[Vec3]) -> OpeningId {
        let corners: Vec<[f32; 3]> = outline.iter().map(|corner| corner.to_array()).collect();
        self.geometry.opening(
            name,
            ConvexPolygon::new(&corners).expect("outlines are made convex"),
        )
    }

    pub(crate) fn walls(&self) -> Vec<Wall> {
        let corners = self.design.plan.corners();
        (0..corners.len())
            .map(|i| Wall {
                left: corners[i],
                right: corners[(i + 1) % corners.len()],
            })
            .collect()
    }

    pub(crate) fn wall(&self, side: Side) -> Wall {
        self.walls()[self.design.plan.wall(side)]
    }

    /// Keeps panels away from an extent of a wall.
    pub(crate) fn take(&mut self, wall: usize, from: f32, to: f32) {
        self.taken[wall].push([from, to]);
    }

    /// Adds an item on a wall: `along` it from its left end, `up` from the floor.
    pub(crate) fn hang(&mut self, thing: &str, mesh: &Arc<Mesh>, side: Side, along: f32, up: f32) {
        let at = self.wall(side).at(along, up);
        self.put(thing, mesh, at);
    }

    /// Cuts a hole into a wall: an outline in wall coordinates at `along`, `depth` deep. Returns its far outline.
    pub(crate) fn cut(
        &mut self,
        wall: usize,
        along: f32,
        outline: &[Vec2],
        depth: f32,
        back: Option<MaterialId>,
        reveal: MaterialId,
    ) -> Vec<Vec3> {
        let frame = self.walls()[wall].at(along, 0.0);
        let far: Vec<Vec3> = outline
            .iter()
            .map(|at| Vec3::from(frame.point([at.x, at.y, -depth])))
            .collect();
        let reach = outline.iter().fold(0.0, |most: f32, at| most.max(at.x.abs()));
        self.take(wall, along - reach, along + reach);
        self.holes.push(Hole {
            wall,
            far: far.clone(),
            back,
            reveal,
        });
        far
    }

    /// Leaves a doorway free in a wall.
    pub(crate) fn doorway(&mut self, door: Doorway, far: Vec<Vec3>) {
        let [from, to] = door.reach(0.36);
        self.take(door.wall, from, to);
        self.holes.push(Hole {
            wall: door.wall,
            far,
            back: None,
            reveal: self.design.style.reveal,
        });
        self.doorways.push(door);
    }

    /// Adds terrain, whose first sample is at `sector_from_field`'s origin.
    pub(crate) fn ground(&mut self, field: Arc<HeightField>, material: MaterialId, at: Transform) {
        let name = format!("{}: ground", self.design.name);
        self.geometry
            .terrain(&name, field, material, at)
            .expect("far fewer faces than are numbered");
    }

    /// Closes the room around its items.
    pub(crate) fn close(mut self) -> FinishedRoom {
        let shell = self.shell();
        self.make("shell floor", &shell.floor);
        for wall in &shell.walls {
            self.make("shell wall", wall);
        }
        if !matches!(self.design.ceiling, Ceiling::Sky) {
            self.make("shell ceiling", &shell.ceiling);
        }
        self.finished()
    }

    /// Closes a room with walls on some sides only. Terrain closes it below and rises beyond the other sides.
    pub(crate) fn close_beside(mut self, sides: &[Side]) -> FinishedRoom {
        let shell = self.shell();
        for &side in sides {
            self.make("shell wall", &shell.walls[self.design.plan.wall(side)]);
        }
        self.finished()
    }

    fn shell(&self) -> Envelope {
        let Design {
            plan,
            height,
            ceiling,
            style,
            ..
        } = self.design;
        let finish = Finish {
            floor: style.trim,
            wall: style.wall,
            ceiling: style.ceiling,
        };
        envelope(plan, height, ceiling, &self.holes, finish)
    }

    fn finished(self) -> FinishedRoom {
        FinishedRoom {
            geometry: self.geometry.build().expect("a room is made of sound things"),
            mirrors: self.mirrors,
            lamps: chosen(self.lamps, self.candles),
        }
    }
}

impl FinishedRoom {
    /// Wraps geometry that was not built as a room.
    pub(crate) fn of(geometry: Geometry, lamps: Vec<Lamp>) -> FinishedRoom {
        FinishedRoom {
            geometry,
            mirrors: Vec::new(),
            lamps,
        }
    }

    /// Adds the sector with its mirrors and lights.
    pub(crate) fn add_to(self, scene: &mut SceneBuilder, name: &str) -> SectorId {
        self.seen_by(Method::HierarchicalZ, scene, name)
    }

    /// As [`FinishedRoom::add_to`], with an explicit method.
    pub(crate) fn seen_by(self, method: Method, scene: &mut SceneBuilder, name: &str) -> SectorId {
        let id = scene.add(name, self.geometry, method);
        for mirror in self.mirrors {
            scene.mirror(id, mirror);
        }
        for lamp in self.lamps {
            scene.light(lamp.in_sector(id));
        }
        id
    }
}

/// Returns a rectangle topped by half an ellipse, counter-clockwise from its lower left corner; the middle of its foot
/// is at (0, `foot`). A `rise` of 0 leaves the top flat.
pub(crate) fn arched(width: f32, foot: f32, spring: f32, rise: f32) -> Vec<Vec2> {
    const STEPS: usize = 12;
    let half = 0.5 * width;
    let mut outline = vec![vec2(-half, foot), vec2(half, foot), vec2(half, spring)];
    if rise > 0.0 {
        outline.extend((1..STEPS).map(|i| {
            let (sin, cos) = (std::f64::consts::PI * i as f64 / STEPS as f64).sin_cos();
            vec2(half * cos as f32, spring + rise * sin as f32)
        }));
    }
    outline.push(vec2(-half, spring));
    outline
}

impl Design {
    /// Returns the height of the highest point of the ceiling.
    pub(crate) fn crown(&self) -> f32 {
        match self.ceiling {
            Ceiling::Flat | Ceiling::Sky => self.height,
            Ceiling::Cove(_, rise) | Ceiling::Vault(_, rise) | Ceiling::Dome(rise, _) => self.height + rise,
        }
    }
}
