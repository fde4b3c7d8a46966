//! Small random scenes with inputs that tend to break visibility code, and cameras where it tends to break.
//!
//! Most scenes have positions on a coarse grid, so that faces, openings and eyes share planes, edges and corners. The
//! whole scene is then scaled, rotated and translated: tiny, huge, or far from the origin, because coordinates are f32.

use crate::engine_view::{engine_view, oblique_view, parallel_view};
use crate::random::Random;
use enfilade::{
    Alpha, Camera, ConvexPolygon, Geometry, GeometryBuilder, Material, MaterialId, Mesh, Method, OpeningId,
    Scene, SceneBuilder, SectorId, Transform, View,
};
use glam::{Vec2, Vec3, vec3};

/// A random scene with views of it.
pub struct FuzzScene {
    /// One to four sectors, joined by portals of every kind.
    pub scene: Scene,
    /// Views on planes, edges, corners and in openings, and some at random positions.
    pub views: Vec<View>,
}

/// Edge length of a room's cube, before the scene is scaled.
const ROOM: f32 = 4.0;

/// Transform of the whole scene.
struct World {
    scale: f32,
    world_from_local: Transform,
}

/// A sector under construction.
struct Room {
    geometry: GeometryBuilder,
    /// Minimum corner, in units of rooms.
    cell: Vec3,
    outlines: Vec<ConvexPolygon>,
    /// Corners of faces, used as eye positions.
    corners: Vec<Vec3>,
}

/// Creates the random scene of a seed. The same seed gives the same scene.
///
/// # Panics
/// If a generated scene is invalid, which is a bug of this function.
pub fn fuzz_scene(seed: u64) -> FuzzScene {
    let mut random = Random::new(seed);
    let world = World::new(&mut random);
    let cells: Vec<Vec3> = (0..1 + random.below(4))
        .map(|_| {
            let mut along = || random.below(2) as f32;
            vec3(along(), 0.0, along())
        })
        .collect();
    let mut rooms: Vec<Room> = cells.into_iter().map(Room::new).collect();
    for room in &mut rooms {
        if random.below(4) > 0 {
            room.walls(&world, &mut random);
        }
        for _ in 0..random.below(7) {
            room.thing(&world, &mut random);
        }
    }
    let mut portals = Vec::new();
    for _ in 0..random.below(5) {
        let from = random.below(rooms.len());
        let to = random.below(rooms.len());
        if let Some(portal) = join(&mut rooms, [from, to], &world, &mut random) {
            portals.push(portal);
        }
    }
    let mut scene = SceneBuilder::new();
    let mut seen = Vec::new();
    for room in rooms {
        let geometry: Geometry = room.geometry.build().expect("geometry within its limits");
        let sector = scene.add("room", geometry, Method::HierarchicalZ);
        seen.push((sector, room.outlines, room.corners));
    }
    for portal in portals {
        portal.add_to(&mut scene);
    }
    let mut scene = scene.build().expect("portals between existing rooms");
    for portal in 0..scene.portals().len() as u32 {
        if random.once_in(12) {
            scene.set_open(enfilade::PortalId(portal), false);
        }
    }
    let mut views: Vec<View> = (0..4)
        .map(|_| view(&seen, &world, perspective, &mut random))
        .collect();
    views.extend([parallel_view, oblique_view].map(|make| view(&seen, &world, make, &mut random)));
    FuzzScene { scene, views }
}

impl World {
    fn new(random: &mut Random) -> World {
        let scale = random.pick(&[1.0, 1.0, 1.0, 1.0, 1e-3, 1e-2, 37.0, 1e3, 1e5]);
        let far = scale * random.pick(&[0.0, 0.0, 0.0, 1.0, 100.0, 1e4]);
        let turn = if random.once_in(3) {
            Transform::rotation(random.point(1.0), f64::from(random.between(-3.0, 3.0)))
        } else {
            Transform::IDENTITY
        };
        World {
            scale,
            world_from_local: Transform::translation(random.point(1.0).map(|at| at * far))
                * turn
                * Transform::scaling([scale; 3]),
        }
    }

    fn point(&self, local: Vec3) -> [f32; 3] {
        self.world_from_local.point(local.to_array())
    }
}

/// Returns the materials of every room: 0 to 2 opaque and one-sided, 3 and 4 opaque and two-sided, 5 alpha-tested, 6
/// and 7 alpha-blended.
fn materials() -> Vec<Material> {
    let colored = |color, double_sided, alpha| Material {
        double_sided,
        alpha,
        ..Material::opaque(color)
    };
    vec![
        colored([0.8, 0.3, 0.2], false, Alpha::Opaque),
        colored([0.2, 0.6, 0.3], false, Alpha::Opaque),
        colored([0.7, 0.7, 0.7], false, Alpha::Opaque),
        colored([0.3, 0.3, 0.8], true, Alpha::Opaque),
        colored([0.8, 0.8, 0.3], true, Alpha::Opaque),
        colored([0.2, 0.5, 0.1], true, Alpha::Mask),
        colored([0.5, 0.6, 0.8], true, Alpha::Blend),
        colored([0.8, 0.5, 0.5], false, Alpha::Blend),
    ]
}

/// Returns a point in one room's box, mostly on a grid of half units.
fn grid_point(random: &mut Random) -> Vec3 {
    let at = Vec3::from(std::array::from_fn(|_| random.between(0.0, ROOM)));
    if random.once_in(4) {
        at
    } else {
        (2.0 * at).round() * 0.5
    }
}

impl Room {
    fn new(cell: Vec3) -> Room {
        Room {
            geometry: GeometryBuilder::new(materials()),
            cell,
            outlines: Vec::new(),
            corners: Vec::new(),
        }
    }

    fn origin(&self) -> Vec3 {
        self.cell * ROOM
    }

    /// Adds some of the six sides of the room's cube, in one mesh or in several.
    fn walls(&mut self, world: &World, random: &mut Random) {
        let material = MaterialId(random.pick(&[2, 2, 2, 3]));
        let mut triangles = Vec::new();
        for axis in 0..3 {
            for far in [0.0, ROOM] {
                if random.once_in(6) {
                    continue;
                }
                let [u, v] = [(axis + 1) % 3, (axis + 2) % 3];
                let corner = |a: f32, b: f32| {
                    let mut at = self.origin();
                    at[axis] += far;
                    at[u] += a * ROOM;
                    at[v] += b * ROOM;
                    at
                };
                let mut quad = [
                    corner(0.0, 0.0),
                    corner(1.0, 0.0),
                    corner(1.0, 1.0),
                    corner(0.0, 1.0),
                ];
                if far > 0.0 {
                    quad.reverse();
                }
                triangles.extend([[quad[0], quad[1], quad[2]], [quad[0], quad[2], quad[3]]]);
            }
        }
        let parts = if random.once_in(2) {
            1
        } else {
            triangles.len().max(1)
        };
        for part in triangles.chunks(triangles.len().div_ceil(parts).max(1)) {
            self.item("wall", part, material, &Transform::IDENTITY, world);
        }
    }

    /// Adds triangles in scene space, transformed by `moved`, as one item.
    fn item(
        &mut self,
        name: &str,
        triangles: &[[Vec3; 3]],
        material: MaterialId,
        moved: &Transform,
        world: &World,
    ) {
        let positions: Vec<[f32; 3]> = triangles.iter().flatten().map(Vec3::to_array).collect();
        let corners: Vec<u32> = (0..positions.len() as u32).collect();
        let mesh = Mesh::triangles(&positions, &corners, material).expect("finite positions");
        let mesh = self.geometry.mesh(mesh);
        let world_from_mesh = world.world_from_local * *moved;
        self.geometry.item(name, mesh, world_from_mesh);
        self.corners
            .extend(positions.iter().map(|&corner| Vec3::from(moved.point(corner))));
    }

    fn thing(&mut self, world: &World, random: &mut Random) {
        let material = MaterialId(random.below(8) as u32);
        let at = self.origin() + grid_point(random);
        let size = random.pick(&[0.5, 1.0, 1.0, 2.0, 0.01, 60.0]);
        let triangles = match random.below(6) {
            0 => cuboid(random),
            1 => vec![[(); 3].map(|()| Vec3::from(random.point(1.0)))],
            // A needle, and a triangle without area.
            2 => vec![[
                Vec3::ZERO,
                vec3(1.0, 1e-6, 0.0),
                vec3(1.0, 0.0, random.pick(&[0.0, 1e-5])),
            ]],
            3 => {
                // Two overlapping coplanar sheets.
                let sheet = |from: f32| {
                    let corner = |x: f32, y: f32| vec3(from + x, from + y, 0.0);
                    let quad = [
                        corner(0.0, 0.0),
                        corner(1.0, 0.0),
                        corner(1.0, 1.0),
                        corner(0.0, 1.0),
                    ];
                    [[quad[0], quad[1], quad[2]], [quad[0], quad[2], quad[3]]]
                };
                sheet(0.0).into_iter().chain(sheet(0.25)).collect()
            }
            4 => pyramid(3 + random.below(4)),
            _ => {
                let [u, v] = [Vec3::AXES[random.below(3)], Vec3::AXES[random.below(3)]];
                vec![[Vec3::ZERO, u, u + v], [Vec3::ZERO, u + v, v]]
            }
        };
        let turn = if random.once_in(2) {
            Transform::IDENTITY
        } else {
            Transform::rotation(random.point(1.0), f64::from(random.between(-3.0, 3.0)))
        };
        let shape = match random.below(10) {
            0 => Transform::scaling([-1.0, 1.0, 1.0]),
            1 => Transform::scaling([1.0, 0.0, 1.0]),
            2 => Transform::scaling([1.0, 1e-4, -2.0]),
            _ => Transform::IDENTITY,
        };
        let moved = Transform::translation(at.to_array()) * turn * Transform::scaling([size; 3]) * shape;
        self.item("thing", &triangles, material, &moved, world);
        if random.once_in(8) {
            self.item("copy", &triangles, material, &moved, world);
        }
    }

    fn opening(&mut self, outline: ConvexPolygon) -> OpeningId {
        self.outlines.push(outline.clone());
        self.geometry.opening("opening", outline)
    }
}

fn cuboid(random: &mut Random) -> Vec<[Vec3; 3]> {
    let mut side = || random.pick(&[0.5, 1.0, 1.5]);
    let size = vec3(side(), side(), side());
    let corner = |i: usize| vec3((i & 1) as f32, (i >> 1 & 1) as f32, (i >> 2) as f32) * size;
    let quads = [
        [0, 4, 6, 2],
        [1, 3, 7, 5],
        [0, 1, 5, 4],
        [2, 6, 7, 3],
        [0, 2, 3, 1],
        [4, 5, 7, 6],
    ];
    let two = |[a, b, c, d]: [usize; 4]| [[a, b, c], [a, c, d]];
    quads.into_iter().flat_map(two).map(|t| t.map(corner)).collect()
}

fn pyramid(sides: usize) -> Vec<[Vec3; 3]> {
    let around = |i: usize| {
        let angle = (i % sides) as f32 * std::f32::consts::TAU / sides as f32;
        vec3(angle.cos(), 0.0, -angle.sin())
    };
    (0..sides)
        .flat_map(|i| {
            [
                [around(i), around(i + 1), Vec3::Y],
                [Vec3::ZERO, around(i + 1), around(i)],
            ]
        })
        .collect()
}

/// A portal to be added to the builder.
enum Portal {
    Door([(SectorId, OpeningId); 2]),
    Mirror(SectorId, OpeningId),
    OneWay([(SectorId, OpeningId); 2], Transform),
}

impl Portal {
    fn add_to(self, scene: &mut SceneBuilder) {
        match self {
            Portal::Door([a, b]) => {
                scene.door(a, b);
            }
            Portal::Mirror(sector, opening) => {
                scene.mirror(sector, opening);
            }
            Portal::OneWay([from, to], there_from_here) => {
                scene.portal(from, to, there_from_here);
            }
        }
    }
}

/// Returns a convex outline in scene space, in a wall of the room or free inside it.
fn outline(room: &Room, world: &World, random: &mut Random) -> Option<ConvexPolygon> {
    let axis = random.below(3);
    let mut corner = room.origin();
    let in_wall = random.below(3) > 0;
    corner[axis] += if in_wall {
        random.pick(&[0.0, ROOM])
    } else {
        0.5 * random.below(9) as f32
    };
    let [u, v] = [(axis + 1) % 3, (axis + 2) % 3];
    let mut corners = Vec::new();
    let [low, size] = [0; 2].map(|_| Vec2::from([(); 2].map(|()| 0.5 * random.below(5) as f32)));
    let size = size.max(Vec2::splat(random.pick(&[0.5, 0.5, 0.5, 1e-3])));
    let sides = random.pick(&[4, 4, 4, 3, 7]);
    for side in 0..sides {
        let place = match sides {
            4 => [[0.0, 0.0], [1.0, 0.0], [1.0, 1.0], [0.0, 1.0]][side],
            _ => {
                let angle = side as f32 * std::f32::consts::TAU / sides as f32;
                [0.5 + 0.5 * angle.cos(), 0.5 + 0.5 * angle.sin()]
            }
        };
        let mut at = corner;
        at[u] += low.x + size.x * place[0];
        at[v] += low.y + size.y * place[1];
        corners.push(at);
    }
    if !in_wall && random.once_in(2) {
        let turn = Transform::rotation(random.point(1.0), f64::from(random.between(-3.0, 3.0)));
        let middle = corners.iter().sum::<Vec3>() / sides as f32;
        for at in &mut corners {
            *at = middle + Vec3::from(turn.direction((*at - middle).to_array()));
        }
    }
    let corners: Vec<[f32; 3]> = corners.into_iter().map(|at| world.point(at)).collect();
    // Far from the origin f32 rounding may collapse a small outline.
    let outline = ConvexPolygon::new(&corners).ok()?;
    Some(if random.once_in(2) {
        outline.flipped()
    } else {
        outline
    })
}

/// Creates a portal from one room to another, or back into the same.
fn join(rooms: &mut [Room], [from, to]: [usize; 2], world: &World, random: &mut Random) -> Option<Portal> {
    let outline = outline(&rooms[from], world, random)?;
    let here = SectorId(from as u32);
    let there = SectorId(to as u32);
    let kind = random.below(6);
    if kind == 0 || from == to && kind < 4 {
        let opening = rooms[from].opening(outline);
        return Some(Portal::Mirror(here, opening));
    }
    if kind < 4 {
        let back = outline.flipped();
        let ends = [
            (here, rooms[from].opening(outline)),
            (there, rooms[to].opening(back)),
        ];
        return Some(Portal::Door(ends));
    }
    // One way: to its own position, or rotated, scaled or mirrored about a corner of the outline.
    let pivot = outline.corners()[0];
    let away = Transform::translation(pivot.map(|value| -value));
    let turn = Transform::rotation(random.point(1.0), f64::from(random.between(-3.0, 3.0)));
    let scale = random.pick(&[1.0, 1.0, 0.5, 3.0]);
    let mirror = random.pick(&[1.0, 1.0, 1.0, -1.0]);
    let step = random.point(2.0 * world.scale);
    let moved = if random.once_in(3) {
        Transform::IDENTITY
    } else {
        Transform::translation(std::array::from_fn(|axis| pivot[axis] + step[axis]))
            * turn
            * Transform::scaling([scale * mirror, scale, scale])
            * away
    };
    let exit: Vec<[f32; 3]> = outline
        .corners()
        .iter()
        .map(|&corner| moved.point(corner))
        .collect();
    let exit = ConvexPolygon::new(&exit).ok()?;
    let ends = [
        (here, rooms[from].opening(outline)),
        (there, rooms[to].opening(exit)),
    ];
    Some(Portal::OneWay(ends, moved))
}

/// Returns the view of a camera, or one through random matrices of engines.
fn perspective(camera: &Camera, size: [u32; 2], random: &mut Random) -> View {
    if random.once_in(3) {
        engine_view(camera, size, random)
    } else {
        camera.view(size).expect("two points and a field of view")
    }
}

/// Creates a view from a difficult position; `make` turns the camera into it.
fn view(
    rooms: &[(SectorId, Vec<ConvexPolygon>, Vec<Vec3>)],
    world: &World,
    make: fn(&Camera, [u32; 2], &mut Random) -> View,
    random: &mut Random,
) -> View {
    let (sector, outlines, corners) = &rooms[random.below(rooms.len())];
    let anywhere =
        |random: &mut Random| world.point(grid_point(random) + ROOM * vec3(random.below(2) as f32, 0.0, 0.0));
    let mut toward = anywhere(random);
    let eye = match random.below(5) {
        0 | 1 if !outlines.is_empty() => {
            let outline = &outlines[random.below(outlines.len())];
            let eye = point_in_outline(outline, random);
            let normal = Vec3::from(outline.normal());
            let off = random.pick(&[0.0, 0.0, 0.0, 1e-7, -1e-7, 1e-5, 1e-3, -1e-3, 5e-3, 0.02]) * world.scale;
            let along = Vec3::from(point_in_outline(outline, random)) - Vec3::from(eye);
            let eye = Vec3::from(eye) + off * normal;
            let step = match random.below(5) {
                0 => normal,
                1 | 2 => -normal,
                3 => along.normalize_or(normal.any_orthonormal_vector()),
                _ => Vec3::from(random.point(1.0)) - normal,
            };
            toward = (eye + world.scale * step).to_array();
            eye.to_array()
        }
        2 | 3 if !corners.is_empty() => {
            // On a corner, an edge, or in the plane of a face.
            let face = random.below(corners.len() / 3) * 3;
            let [a, b, c] = [0, 1, 2].map(|i| corners[face + i]);
            let [s, t] = [0; 2].map(|_| random.pick(&[0.0, 0.0, 0.25, 0.5, 1.0]));
            world.point(a + s * (b - a) + t * (c - a))
        }
        _ => anywhere(random),
    };
    if eye == toward {
        toward =
            std::array::from_fn(|axis| eye[axis] + [0.0, 0.0, world.scale][axis] + eye[axis].abs() * 1e-3);
    }
    let size = [1 + random.below(24) as u32, 1 + random.below(16) as u32];
    let mut camera = Camera {
        fov_y: random.between(20.0, 120.0).to_radians(),
        up: random.pick(&[
            [0.0, 1.0, 0.0],
            [0.0, 1.0, 0.0],
            [0.3, 0.9, -0.2],
            [0.0, 0.0, 1.0],
        ]),
        ..Camera::new(eye, toward)
    };
    if random.once_in(2) {
        camera.sector = Some(*sector);
    }
    if random.once_in(4) {
        camera.z_near = Some(random.pick(&[1e-6, 1e-4, 0.05, 0.5]) * world.scale);
    }
    let view = make(&camera, size, random);
    if random.once_in(4) {
        let sample = View::FOUR_SAMPLES[random.below(4)];
        return view.at_sample(sample).expect("a position in the pixel");
    }
    view
}

/// Returns a point of an outline: a corner, on an edge, or inside.
fn point_in_outline(outline: &ConvexPolygon, random: &mut Random) -> [f32; 3] {
    let corners = outline.corners();
    let corner = |at: usize| Vec3::from(corners[at % corners.len()]);
    let first = random.below(corners.len());
    let middle = (0..corners.len()).map(corner).sum::<Vec3>() / corners.len() as f32;
    let edge = corner(first).lerp(corner(first + 1), random.pick(&[0.0, 0.5, 0.3]));
    edge.lerp(middle, random.pick(&[0.0, 1e-3, 0.5, 1.0])).to_array()
}
