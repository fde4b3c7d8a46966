//! Ray casts within a geometry: the first hit or all hits, and the surface at a hit.
//!
//! Idea: traverses the tree over the items near to far, then the trees of the meshes, then the boxes of the faces of a
//!     cluster, eight at a time; what is beyond the first hit is skipped.
//! Source: the traversal is that of [`Octree`](crate::geom::Octree); Möller, Trumbore, Fast, Minimum Storage
//!     Ray/Triangle Intersection, 1997.
//! Cost: O(log items + log clusters) box tests where little overlaps, then the faces whose boxes the ray meets. The
//!     first ray that reaches a cluster computes its faces' boxes.
//! Each hit distance is clamped to the interval of the ray in the box of the face's cluster, and boxes of faces are tested
//! with a margin above the rounding error of a hit. So skipping boxes does not change a result, and the first of all hits
//! is the first hit.

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
    /// `hits`, sorted by distance, then by item and face. Does not allocate if `hits` has enough capacity, except for the
    /// boxes of faces in clusters that no ray has reached before.
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
        let quick = line.quick(&self.bounds());
        self.item_tree().walk(line.origin.into(), |step| match step {
            Step::Node(bounds) => quick.may_meet(bounds, limit),
            Step::Thing(item) => {
                if quick.may_meet(&self.item(ItemIndex(item)).bounds, limit) {
                    self.along_item(ItemIndex(item), line, &mut limit, &counts, &mut found);
                }
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
        let quick = line.quick(&mesh.bounds());
        mesh.walk(line.origin.into(), |step| match step {
            Step::Node(bounds) => quick.may_meet(bounds, *limit),
            Step::Thing(number) => {
                let cluster = &mesh.clusters()[number as usize];
                if !quick.may_meet(&cluster.bounds, *limit) {
                    return true;
                }
                let inside = line.meets(&cluster.bounds, 0.0, *limit);
                let Some([enter, leave]) = inside.filter(|_| counts(&self.material_of(item, cluster))) else {
                    return true;
                };
                mesh.faces_along(number as usize, &line, [enter, leave], *limit, |face| {
                    let Some((distance, from_behind)) = meet_face(mesh, face, &line) else {
                        return;
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
                });
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

#[cfg(test)]
mod tests {
    use super::*;
    use crate::chance::Dice;
    use crate::geom::Transform;
    use crate::geometry::GeometryBuilder;
    use crate::mesh::soup;

    /// Returns all hits up to a limit by the same arithmetic, but without boxes of faces: items and clusters by their
    /// boxes, then every face.
    fn hits_of_all(geometry: &Geometry, line: &Line, limit: f64) -> Vec<Hit> {
        let mut hits = Vec::new();
        for item in (0..geometry.items().len() as u32).map(ItemIndex) {
            let placed = geometry.item(item);
            let is_near = line
                .meets(&placed.bounds, line.margin(&placed.bounds), limit)
                .is_some();
            let Some(item_from_sector) = placed.transform().inverse().filter(|_| is_near) else {
                continue;
            };
            let line = line.moved(&item_from_sector.0);
            let mesh = geometry.mesh_of(item);
            for cluster in mesh.clusters() {
                let Some([enter, leave]) = line.meets(&cluster.bounds, 0.0, limit) else {
                    continue;
                };
                for face in cluster.faces.clone() {
                    let Some((distance, from_behind)) = meet_face(mesh, face, &line) else {
                        continue;
                    };
                    let distance = distance.max(enter).min(leave.max(f64::MIN_POSITIVE));
                    hits.extend((distance <= limit).then_some(Hit {
                        item: geometry.id_of(item),
                        key: geometry.key(item),
                        face,
                        distance,
                        from_behind,
                    }));
                }
            }
        }
        hits.sort_unstable_by(|a, b| a.distance.total_cmp(&b.distance).then(a.rank().cmp(&b.rank())));
        hits
    }

    /// Instances of slivers, coplanar and duplicate faces, huge and tiny, each at about the same size.
    fn heap(dice: &mut Dice) -> Geometry {
        let mut builder = GeometryBuilder::new([Material::opaque([1.0; 3])]);
        for _ in 0..6 {
            let scale = dice.by_ratio(1e-6, 1e6);
            let mesh = builder.mesh(soup(dice, scale));
            for turned in [false, true] {
                let turn = Transform::rotation(dice.direction().as_vec3().into(), f64::from(turned));
                let shrink = Transform::scaling([(1.0 / scale) as f32; 3]);
                builder.item(
                    "",
                    mesh,
                    Transform::translation(dice.point(2.0).as_vec3().into()) * turn * shrink,
                );
            }
        }
        builder.build().expect("sound meshes")
    }

    #[test]
    fn a_ray_meets_what_it_meets_among_all_faces() {
        let mut dice = Dice::new(7);
        let mut met = 0;
        for _ in 0..40 {
            let geometry = heap(&mut dice);
            let corner = |dice: &mut Dice| {
                let item = ItemIndex(dice.below(geometry.items().len()) as u32);
                let positions = geometry.mesh_of(item).positions();
                geometry
                    .item(item)
                    .transform()
                    .point(positions[dice.below(positions.len())])
            };
            for question in 0..200 {
                let mut origin = dice.point(3.0);
                let mut direction = dice.direction() * dice.by_ratio(1e-20, 1e20);
                match question % 6 {
                    0 => direction[dice.below(3)] = 0.0,
                    1 => direction = DVec3::AXES[dice.below(3)],
                    // Through a corner, from afar; from corner to corner.
                    2 => {
                        origin *= dice.by_ratio(1.0, 1e6);
                        direction = DVec3::from(corner(&mut dice).map(f64::from)) - origin;
                    }
                    3 => {
                        origin = DVec3::from(corner(&mut dice).map(f64::from));
                        direction = DVec3::from(corner(&mut dice).map(f64::from)) - origin;
                    }
                    _ => {}
                }
                let ray = Ray {
                    origin: origin.as_vec3().into(),
                    direction: direction.as_vec3().into(),
                };
                let Some(line) = line_of(&ray) else { continue };
                let limit = match question % 4 {
                    0 => dice.roll() * 4.0 / direction.length(),
                    _ => f64::INFINITY,
                };
                let expected = hits_of_all(&geometry, &line, limit);
                let mut hits = Vec::new();
                geometry.cast_all(&ray, limit, &mut hits);
                assert_eq!(hits, expected, "{ray:?} up to {limit}");
                assert_eq!(
                    geometry.first_along(&line, limit, |_| true),
                    expected.first().copied()
                );
                met += usize::from(!expected.is_empty());
            }
        }
        assert!(met > 2000, "only {met} rays met anything");
    }
}
