//! Rays: the first face that one meets, and how a face looks.

use crate::content::{Content, ItemId};
use crate::fragment::{Hit, Ray, Surface};
use crate::geom::{Aabb, Step};
use glam::DVec3;

impl Content {
    /// The first face along a ray, seen from whichever side; what a scale of zero flattens is not met. Cost: O(items) boxes, then the clusters near the ray.
    pub fn cast(&self, ray: &Ray) -> Option<Hit> {
        let [origin, direction] = [ray.origin, ray.direction].map(|v| DVec3::from(v.map(f64::from)));
        let mut first: Option<Hit> = None;
        for item in (0..self.items().len() as u32).map(ItemId) {
            let placed = self.item(item);
            let limit = first.map_or(f64::INFINITY, |hit| hit.distance);
            if !meets(&placed.bounds, origin, direction, limit) {
                continue;
            }
            // In the item's own space distances, counted in lengths of the direction, stay what they are.
            let fragment_from_item = placed.transform();
            let Some(item_from_fragment) = fragment_from_item.inverse() else {
                continue;
            };
            let origin = item_from_fragment.0.transform_point3(origin);
            let direction = item_from_fragment.0.transform_vector3(direction);
            let mesh = self.mesh_of(item);
            mesh.walk(origin.into(), |step| {
                let limit = first.map_or(f64::INFINITY, |hit| hit.distance);
                match step {
                    Step::Node(bounds) => meets(bounds, origin, direction, limit),
                    Step::Thing(cluster) => {
                        for face in mesh.clusters()[cluster as usize].faces.clone() {
                            let corner = |i: usize| {
                                DVec3::from(mesh.positions()[mesh.face(face)[i] as usize].map(f64::from))
                            };
                            for last in 2..mesh.face(face).len() {
                                let triangle = [corner(0), corner(last - 1), corner(last)];
                                let Some((distance, from_behind)) = meet(triangle, origin, direction) else {
                                    continue;
                                };
                                if first.is_none_or(|hit| distance < hit.distance) {
                                    first = Some(Hit {
                                        item,
                                        face,
                                        distance,
                                        from_behind,
                                    });
                                }
                            }
                        }
                        true
                    }
                }
            });
        }
        first
    }

    /// How a face looks.
    pub fn surface(&self, item: ItemId, face: u32) -> Surface {
        let mesh = self.mesh_of(item);
        let material = self.material_of(item, &mesh.clusters()[mesh.cluster_of(face)]);
        let transform = self.item(item).transform();
        let corners = mesh.face(face);
        let corner = |i: usize| {
            transform
                .0
                .transform_point3(DVec3::from(mesh.positions()[corners[i] as usize].map(f64::from)))
        };
        let first = corner(0);
        let normal: DVec3 = (2..corners.len())
            .map(|last| (corner(last - 1) - first).cross(corner(last) - first))
            .sum();
        let front = if transform.mirrors() { -1.0 } else { 1.0 };
        Surface {
            normal: (normal.normalize_or_zero() * front).as_vec3().into(),
            point: first.as_vec3().into(),
            color: material.base_color,
            alpha: material.alpha,
        }
    }
}

/// Does a ray meet a box before `limit`? `true` when unsure.
fn meets(bounds: &Aabb, origin: DVec3, direction: DVec3, limit: f64) -> bool {
    let [mut enter, mut leave] = [0.0_f64, limit];
    for axis in 0..3 {
        let [low, high] = [bounds.min[axis], bounds.max[axis]].map(|side| f64::from(side) - origin[axis]);
        if direction[axis] == 0.0 {
            if low > 0.0 || high < 0.0 {
                return false;
            }
        } else {
            let [a, b] = [low / direction[axis], high / direction[axis]];
            enter = enter.max(a.min(b));
            leave = leave.min(a.max(b));
        }
    }
    // A flat box is entered and left at once; a rounding must not make it missed.
    enter <= leave + 1e-9 * leave.abs()
}

/// Where a ray meets a triangle, and whether from behind. Möller, Trumbore, Fast, Minimum Storage Ray/Triangle
/// Intersection, 1997.
fn meet([a, b, c]: [DVec3; 3], origin: DVec3, direction: DVec3) -> Option<(f64, bool)> {
    let [ab, ac, from_a] = [b - a, c - a, origin - a];
    let p = direction.cross(ac);
    let determinant = ab.dot(p);
    if determinant == 0.0 {
        return None;
    }
    let u = from_a.dot(p) / determinant;
    let q = from_a.cross(ab);
    let v = direction.dot(q) / determinant;
    let distance = ac.dot(q) / determinant;
    (u >= 0.0 && v >= 0.0 && u + v <= 1.0 && distance > 0.0).then_some((distance, determinant < 0.0))
}
