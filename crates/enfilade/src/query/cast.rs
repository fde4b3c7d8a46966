//! Ray casts within a geometry: the first hit or all hits, and the surface at a hit.
//!
//! Idea: traverses the tree over the items near to far, then the trees of the meshes; nodes beyond the first hit are
//!     skipped.
//! Source: the traversal is that of [`Octree`](crate::geom::Octree); Möller, Trumbore, Fast, Minimum Storage
//!     Ray/Triangle Intersection, 1997.
//! Cost: O(log items + log clusters) box tests where little overlaps, then the faces of the clusters met.
//! Each hit distance is clamped to the interval of the ray in the box of the face's cluster. So rounding never makes
//! skipping boxes change a result, and the first of all hits is the first hit.

use crate::geom::{Line, Step};
use crate::geometry::{Geometry, Material};
use crate::ids::ItemIndex;
use crate::mesh::Mesh;
use crate::sector::{Hit, Ray, Surface};
use glam::DVec3;

impl Geometry {
    /// Returns the first face along a ray, hit from either side. Among hits at the same distance, the one with the
    /// lowest item id, then the lowest face, wins. Ignores items that a scale of 0 flattens. `None` if nothing is hit,
    /// if the ray is not finite or if its direction is 0.
    #[doc(alias = "raycast")]
    #[doc(alias = "pick")]
    pub fn cast(&self, ray: &Ray) -> Option<Hit> {
        self.first_along(&line_of(ray)?, f64::INFINITY, |_| true)
    }

    /// Finds all faces along a ray up to `limit`, in multiples of the length of its direction. Replaces the contents of
    /// `hits`, sorted by distance, then by item and face. Does not allocate if `hits` has enough capacity.
    ///
    /// Each face is listed once. A ray through an edge that two faces share hits one of them, or both.
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
        hits.sort_unstable_by(|a, b| a.distance.total_cmp(&b.distance).then(a.rank().cmp(&b.rank())));
    }

    /// Returns the first face along a line up to `limit` whose material passes `counts`.
    pub(super) fn first_along(
        &self,
        line: &Line,
        limit: f64,
        counts: impl Fn(&Material) -> bool,
    ) -> Option<Hit> {
        let mut first: Option<Hit> = None;
        self.along(line, limit, counts, |hit| {
            let comes_first = |known: &Hit| (hit.distance, hit.rank()) < (known.distance, known.rank());
            if first.as_ref().is_none_or(comes_first) {
                first = Some(hit);
            }
            first.map_or(limit, |hit| hit.distance)
        });
        first
    }

    /// Calls `found` with the faces along a line up to a limit, roughly near to far; `found` returns the new limit.
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
                self.along_item(ItemIndex(item), line, &mut limit, &counts, &mut found);
                true
            }
        });
    }

    fn along_item(
        &self,
        item: ItemIndex,
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
        // In object space, distances in multiples of the direction's length are the same.
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
                            item: self.id_of(item),
                            key: self.key(item),
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

    /// Returns the surface of a face: normal, a point on it, and material.
    pub fn surface(&self, item: ItemIndex, face: u32) -> Surface {
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
    /// Returns the sort key of hits at the same distance.
    fn rank(&self) -> (ItemIndex, u32) {
        (self.item.index, self.face)
    }
}

pub(super) fn line_of(ray: &Ray) -> Option<Line> {
    let [origin, direction] = [ray.origin, ray.direction].map(|v| DVec3::from(v.map(f64::from)));
    Line::new(origin, direction)
}

/// Returns the first intersection of a line and a face: its distance, and whether it is from behind.
fn meet_face(mesh: &Mesh, face: u32, line: &Line) -> Option<(f64, bool)> {
    let corners = mesh.face(face);
    let corner = |i: usize| DVec3::from(mesh.positions()[corners[i] as usize].map(f64::from));
    let first = corner(0);
    let triangles = (2..corners.len()).map(|last| [first, corner(last - 1), corner(last)]);
    triangles
        .filter_map(|triangle| meet(triangle, line.origin, line.direction))
        .min_by(|a, b| a.0.total_cmp(&b.0))
}

/// Intersects a ray and a triangle (Möller, Trumbore): returns the distance, and whether the hit is from behind.
pub(super) fn meet([a, b, c]: [DVec3; 3], origin: DVec3, direction: DVec3) -> Option<(f64, bool)> {
    let [ab, ac, from_a] = [b - a, c - a, origin - a];
    let p = direction.cross(ac);
    let determinant = ab.dot(p);
    if determinant == 0.0 {
        return None;
    }
    let u = from_a.dot(p);
    // Early out before any division: most triangles are missed.
    if u * determinant < 0.0 || u.abs() > determinant.abs() {
        return None;
    }
    let u = u / determinant;
    let q = from_a.cross(ab);
    let v = direction.dot(q) / determinant;
    let distance = ac.dot(q) / determinant;
    (u >= 0.0 && v >= 0.0 && u + v <= 1.0 && distance > 0.0).then_some((distance, determinant < 0.0))
}
