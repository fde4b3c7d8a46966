//! Rays: the first face that one meets, or all of them, and how a face looks.
//!
//! The tree over the items is walked from near to far, then the trees of the meshes; what lies beyond the first hit is
//! skipped.
//! Source: the walk is that of [`Octree`](crate::geom::Octree); Möller, Trumbore, Fast, Minimum Storage Ray/Triangle
//!     Intersection, 1997.
//! Cost: O(log items + log clusters) boxes where little overlaps, then the faces of the clusters that are met.
//! A hit lies where the ray is in the box of the face's cluster, also where rounding says otherwise: so to skip boxes never
//! changes an answer, and the first of all hits is the first hit.

use crate::geom::{Line, Step};
use crate::geometry::{Geometry, ItemId, Material};
use crate::mesh::Mesh;
use crate::sector::{Hit, Ray, Surface};
use glam::DVec3;

impl Geometry {
    /// The first face along a ray, seen from whichever side; of several at one distance that of the lowest item, and its
    /// lowest face. What a scale of zero flattens is not met. A ray that is not finite, or has no direction, meets nothing.
    pub fn cast(&self, ray: &Ray) -> Option<Hit> {
        self.first_along(&line_of(ray)?, f64::INFINITY, |_| true)
    }

    /// All faces along a ray, as [`Geometry::cast`] meets them, no farther than `limit` lengths of its direction: the
    /// nearest first, then by item and face. They replace what `hits` held; nothing is allocated where it has room.
    ///
    /// Each face is there once. A ray through an edge that faces share meets one of them, or both.
    pub fn cast_all(&self, ray: &Ray, limit: f64, hits: &mut Vec<Hit>) {
        hits.clear();
        let Some(line) = line_of(ray).filter(|_| limit >= 0.0) else {
            return;
        };
        self.along(
            &line,
            limit,
            |_| true,
            |hit| {
                hits.push(hit);
                limit
            },
        );
        hits.sort_unstable_by(|a, b| a.distance.total_cmp(&b.distance).then(a.of().cmp(&b.of())));
    }

    /// The first face along a line that is no farther than `limit` and made of what counts.
    pub(super) fn first_along(
        &self,
        line: &Line,
        limit: f64,
        counts: impl Fn(&Material) -> bool,
    ) -> Option<Hit> {
        let mut first: Option<Hit> = None;
        self.along(line, limit, counts, |hit| {
            let comes_first = |known: &Hit| (hit.distance, hit.of()) < (known.distance, known.of());
            if first.as_ref().is_none_or(comes_first) {
                first = Some(hit);
            }
            first.map_or(limit, |hit| hit.distance)
        });
        first
    }

    /// Every face along a line that is no farther than a limit, roughly the nearest first; `found` says what the limit is
    /// from now on.
    pub(super) fn along(
        &self,
        line: &Line,
        mut limit: f64,
        counts: impl Fn(&Material) -> bool,
        mut found: impl FnMut(Hit) -> f64,
    ) {
        self.item_tree().walk(line.origin.into(), |step| match step {
            Step::Node(bounds) => line.meets(bounds, line.margin(bounds), limit).is_some(),
            Step::Thing(item) => {
                self.along_item(ItemId(item), line, &mut limit, &counts, &mut found);
                true
            }
        });
    }

    fn along_item(
        &self,
        item: ItemId,
        line: &Line,
        limit: &mut f64,
        counts: &impl Fn(&Material) -> bool,
        found: &mut impl FnMut(Hit) -> f64,
    ) {
        let placed = self.item(item);
        if line
            .meets(&placed.bounds, line.margin(&placed.bounds), *limit)
            .is_none()
        {
            return;
        }
        // In the item's own space distances, counted in lengths of the direction, stay what they are.
        let Some(item_from_sector) = placed.transform().inverse() else {
            return;
        };
        let line = line.moved(&item_from_sector.0);
        let mesh = self.mesh_of(item);
        mesh.walk(line.origin.into(), |step| match step {
            Step::Node(bounds) => line.meets(bounds, 0.0, *limit).is_some(),
            Step::Thing(cluster) => {
                let cluster = &mesh.clusters()[cluster as usize];
                let inside = line.meets(&cluster.bounds, 0.0, *limit);
                let Some([enter, leave]) = inside.filter(|_| counts(&self.material_of(item, cluster))) else {
                    return true;
                };
                for face in cluster.faces.clone() {
                    let Some((distance, from_behind)) = meet_face(mesh, face, &line) else {
                        continue;
                    };
                    let distance = distance.max(enter).min(leave.max(f64::MIN_POSITIVE));
                    if distance <= *limit {
                        *limit = found(Hit {
                            item,
                            face,
                            distance,
                            from_behind,
                        });
                    }
                }
                true
            }
        });
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

impl Hit {
    /// What is met, for an order among equals.
    fn of(&self) -> (ItemId, u32) {
        (self.item, self.face)
    }
}

pub(super) fn line_of(ray: &Ray) -> Option<Line> {
    let [origin, direction] = [ray.origin, ray.direction].map(|v| DVec3::from(v.map(f64::from)));
    Line::new(origin, direction)
}

/// Where a line first meets a face, and whether from behind.
fn meet_face(mesh: &Mesh, face: u32, line: &Line) -> Option<(f64, bool)> {
    let corners = mesh.face(face);
    let corner = |i: usize| DVec3::from(mesh.positions()[corners[i] as usize].map(f64::from));
    let first = corner(0);
    let triangles = (2..corners.len()).map(|last| [first, corner(last - 1), corner(last)]);
    triangles
        .filter_map(|triangle| meet(triangle, line.origin, line.direction))
        .min_by(|a, b| a.0.total_cmp(&b.0))
}

/// Where a ray meets a triangle, and whether from behind.
pub(super) fn meet([a, b, c]: [DVec3; 3], origin: DVec3, direction: DVec3) -> Option<(f64, bool)> {
    let [ab, ac, from_a] = [b - a, c - a, origin - a];
    let p = direction.cross(ac);
    let determinant = ab.dot(p);
    if determinant == 0.0 {
        return None;
    }
    let u = from_a.dot(p);
    // Most are missed: that is told before anything is divided.
    if u * determinant < 0.0 || u.abs() > determinant.abs() {
        return None;
    }
    let u = u / determinant;
    let q = from_a.cross(ab);
    let v = direction.dot(q) / determinant;
    let distance = ac.dot(q) / determinant;
    (u >= 0.0 && v >= 0.0 && u + v <= 1.0 && distance > 0.0).then_some((distance, determinant < 0.0))
}
