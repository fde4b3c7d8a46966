//! Obstacles around a capsule: the faces of every sector that it reaches into, transformed to the space of its centre.
//!
//! Idea: a face collides only with the parts of the capsule that are in its sector. That is so if the path from the
//!     capsule's centre along its axis, and from there straight to the face, crosses the openings that lead to that
//!     sector and no other.
//! Source: RenderWare, Portal culling: bodies in doorways collide in each section that they stand in.
//! Cost: collecting the nearby clusters; then one distance to each of their triangles per query.
//! Faces beyond an opening are clipped at its plane; the part in front of it is ignored.

use super::body::Body;
use enfilade::geom::{Step, nearest_points};
use enfilade::{
    Aabb, ConvexPolygon, Geometry, ItemIndex, Location, OpeningId, PortalId, Scene, SectorId, Transform,
};
use glam::{DAffine3, DVec3};

/// Triangles around a capsule, in the space of the sector that contains its centre.
pub(super) struct Obstacles {
    triangles: Vec<Triangle>,
    sides: Vec<Side>,
}

struct Triangle {
    corners: [DVec3; 3],
    /// Minimum and maximum corner of the bounding box.
    around: [DVec3; 2],
    side: usize,
}

/// A sector that the capsule reaches into, in the space of the capsule's centre.
struct Side {
    /// The openings crossed to get there, in order, and those that lead on from there.
    entered: Vec<Hole>,
    left: Vec<Hole>,
}

/// An open opening.
struct Hole {
    corners: Vec<DVec3>,
    /// Unit normal, to the front.
    normal: DVec3,
    slack: f64,
}

/// Closest approach of a capsule's axis and a triangle.
#[derive(Clone, Copy, Debug)]
pub(super) struct Contact {
    pub(super) distance: f64,
    /// From the triangle to the axis, of unit length.
    pub(super) normal: DVec3,
    /// The closest point on the triangle.
    pub(super) on: DVec3,
    /// The triangle's normal, on the side of the capsule.
    pub(super) of_face: DVec3,
}

impl Obstacles {
    /// Collects all triangles within `reach` of a body.
    pub(super) fn about(scene: &Scene, place: Location, body: &Body, reach: f64) -> Obstacles {
        let middle = DVec3::from(place.position.map(f64::from));
        let around = body.radius + reach;
        let axis = body.axis(middle);
        let near = [axis[0].min(axis[1]) - around, axis[0].max(axis[1]) + around];
        let mut obstacles = Obstacles {
            triangles: Vec::new(),
            sides: Vec::new(),
        };
        for present in scene.body_sectors(place, (body.half + around) as f32) {
            let Some(here_from_there) = present.there_from_here.inverse() else {
                continue;
            };
            let affine = DAffine3::from(here_from_there);
            let entered = holes_on_the_way(scene, place.sector, &present.crossed);
            let came = present.crossed.last();
            let sector = present.location.sector;
            let left = scene
                .open_portals(sector)
                .filter(|&(portal, _)| !came.is_some_and(|&came| scene.leads_back(came, portal)))
                .map(|(_, outline)| Hole::of(outline, &here_from_there));
            obstacles.sides.push(Side {
                left: left.collect(),
                entered,
            });
            if let Some(geometry) = scene.geometry(sector) {
                obstacles.add_faces(geometry, &affine, &near);
            }
            if scene.is_flat() {
                continue;
            }
            for (opening, number) in scene.sector(sector).openings().iter().zip(0..) {
                let portal = scene.portal_of(sector, OpeningId(number));
                if !portal.is_some_and(|id| scene.portals()[id.0 as usize].open) {
                    let corners = corners(&opening.outline);
                    obstacles.add(corners.into_iter().map(|c| affine.transform_point3(c)), &near);
                }
            }
        }
        obstacles
    }

    /// Adds the faces of the last side.
    fn add_faces(&mut self, geometry: &Geometry, here_from_there: &DAffine3, near: &[DVec3; 2]) {
        let [min, max] = near.map(|corner| corner.as_vec3().to_array());
        let here = Aabb {
            min: min.map(f32::next_down),
            max: max.map(f32::next_up),
        };
        let there = here.placed(&here_from_there.inverse());
        geometry.items_in_box(&there, |item: ItemIndex| {
            let here_from_item = *here_from_there * DAffine3::from(geometry.item(item).transform());
            let mesh = geometry.mesh_of(item);
            mesh.walk([0.0; 3], |step| match step {
                Step::Node(bounds) => bounds.placed(&here_from_item).meets(&here),
                Step::Thing(cluster) => {
                    let cluster = &mesh.clusters()[cluster as usize];
                    if cluster.bounds.placed(&here_from_item).meets(&here) {
                        for face in cluster.faces.clone() {
                            let corner = |&index: &u32| {
                                let position = mesh.positions()[index as usize].map(f64::from);
                                here_from_item.transform_point3(DVec3::from(position))
                            };
                            self.add(mesh.face(face).iter().map(corner), near);
                        }
                    }
                    true
                }
            });
        });
    }

    /// Adds a face of the last side, clipped to the part beyond the opening that leads there.
    fn add(&mut self, corners: impl Iterator<Item = DVec3>, near: &[DVec3; 2]) {
        let side = self.sides.len() - 1;
        let mut outline: Vec<DVec3> = corners.collect();
        if let Some(hole) = self.sides[side].entered.last() {
            outline = hole.beyond(&outline);
        }
        for last in 2..outline.len() {
            let corners = [outline[0], outline[last - 1], outline[last]];
            let [a, b, c] = corners;
            let around = [a.min(b).min(c), a.max(b).max(c)];
            if meet(&around, near) {
                self.triangles.push(Triangle {
                    corners,
                    around,
                    side,
                });
            }
        }
    }

    /// Returns `true` if the capsule reaches into more than one sector.
    pub(super) fn has_ways_out(&self) -> bool {
        self.sides.len() > 1
    }

    /// Finds all triangles nearer to the axis of a body than `within`.
    pub(super) fn contacts(&self, middle: DVec3, body: &Body, within: f64, found: &mut Vec<Contact>) {
        found.clear();
        let axis = body.axis(middle);
        let about = [axis[0].min(axis[1]) - within, axis[0].max(axis[1]) + within];
        for triangle in &self.triangles {
            if !meet(&triangle.around, &about) {
                continue;
            }
            let [near, on] = nearest_points(axis, triangle.corners);
            let off = near - on;
            let distance = off.length();
            if distance >= within || !self.sides[triangle.side].is_reached([middle, near, on]) {
                continue;
            }
            let [a, b, c] = triangle.corners;
            let of_face = (b - a).cross(c - a).normalize_or(body.up);
            // If the axis intersects the triangle, the normal points to the side of the centre.
            let of_face = if of_face.dot(middle - a) < 0.0 {
                -of_face
            } else {
                of_face
            };
            let normal = off.try_normalize().unwrap_or(of_face);
            found.push(Contact {
                distance,
                normal,
                on,
                of_face,
            });
        }
    }
}

impl Side {
    fn is_reached(&self, way: [DVec3; 3]) -> bool {
        let goes_through = |hole: &Hole| hole.is_on(way[0], way[1]) || hole.is_on(way[1], way[2]);
        self.entered.iter().all(goes_through) && !self.left.iter().any(goes_through)
    }
}

impl Hole {
    fn of(outline: &ConvexPolygon, here_from_there: &Transform) -> Hole {
        let affine = DAffine3::from(*here_from_there);
        let place = |corner: DVec3| affine.transform_point3(corner);
        let corners: Vec<DVec3> = corners(outline).into_iter().map(place).collect();
        let normal = affine.transform_vector3(DVec3::from(outline.normal().map(f64::from)));
        Hole {
            corners,
            normal: normal.normalize_or_zero(),
            slack: outline.slack() * here_from_there.scale(),
        }
    }

    fn height(&self, point: DVec3) -> f64 {
        self.normal.dot(point - self.corners[0])
    }

    /// Returns `true` if the segment crosses the opening from the front to the back.
    fn is_on(&self, from: DVec3, to: DVec3) -> bool {
        let [before, behind] = [from, to].map(|point| self.height(point));
        if before < -self.slack || behind >= -self.slack {
            return false;
        }
        let at = from.lerp(to, (before / (before - behind)).clamp(0.0, 1.0));
        let turns = (0..self.corners.len()).map(|i| {
            let [start, end] = [self.corners[i], self.corners[(i + 1) % self.corners.len()]];
            (end - start).cross(at - start).dot(self.normal)
        });
        let [least, most] = turns.fold([f64::INFINITY, f64::NEG_INFINITY], |[least, most], turn| {
            [least.min(turn), most.max(turn)]
        });
        // Both windings: a reflection reverses outlines.
        least >= 0.0 || most <= 0.0
    }

    /// Returns the part of a face that is behind the plane of the opening or in it.
    fn beyond(&self, outline: &[DVec3]) -> Vec<DVec3> {
        let mut kept = Vec::with_capacity(outline.len() + 1);
        for (i, &corner) in outline.iter().enumerate() {
            let next = outline[(i + 1) % outline.len()];
            let [here, there] = [corner, next].map(|point| self.height(point) - self.slack);
            if here <= 0.0 {
                kept.push(corner);
            }
            if (here < 0.0 && there > 0.0) || (here > 0.0 && there < 0.0) {
                kept.push(corner.lerp(next, here / (here - there)));
            }
        }
        kept
    }
}

/// Returns the openings of a chain of portals, in the space of the first sector.
fn holes_on_the_way(scene: &Scene, from: SectorId, crossed: &[PortalId]) -> Vec<Hole> {
    debug_assert!(
        crossed
            .first()
            .is_none_or(|id| scene.portals()[id.0 as usize].from == from)
    );
    let mut here_from_there = Transform::IDENTITY;
    let mut holes = Vec::with_capacity(crossed.len());
    for id in crossed {
        let portal = &scene.portals()[id.0 as usize];
        let opening = &scene.sector(portal.from).openings()[usize::from(portal.opening.0)];
        holes.push(Hole::of(&opening.outline, &here_from_there));
        if let Some(back) = portal.there_from_here.inverse() {
            here_from_there = here_from_there * back;
        }
    }
    holes
}

/// Returns the corners of an outline in f64.
fn corners(outline: &ConvexPolygon) -> Vec<DVec3> {
    let corners = outline.corners().iter();
    corners.map(|corner| DVec3::from(corner.map(f64::from))).collect()
}

/// Returns `true` if two boxes, each [minimum, maximum], share a point.
fn meet(one: &[DVec3; 2], other: &[DVec3; 2]) -> bool {
    one[0].cmple(other[1]).all() && one[1].cmpge(other[0]).all()
}
