//! Trees over faces and items, built by `obvhs`, walked by rays in f64.
//!
//! Its own walk is in f32, which is too coarse for scenes far from the origin: what it drops would be missed here.

use super::bundle::Bundle;
use super::openings::Outline;
use crate::content::{Alpha, Content, ItemId, Opening};
use crate::geom::{Aabb, Transform};
use crate::mesh::Mesh;
use glam::{DAffine3, DVec3};
use obvhs::bvh2::Bvh2;
use obvhs::bvh2::builder::build_bvh2;
use obvhs::{Boundable, BvhBuildParams};
use rayon::prelude::*;
use smallvec::SmallVec;
use std::collections::HashMap;
use std::sync::Arc;
use std::time::Duration;

/// A face that a ray meets.
#[derive(Clone, Copy, Debug)]
pub(super) struct Meeting {
    pub(super) ray: usize,
    /// The ray's parameter there: the least and the greatest that the rounding of positions to f32 leaves open.
    pub(super) w: [f64; 2],
    pub(super) item: ItemId,
    pub(super) face: u32,
    pub(super) hides: bool,
}

/// A content, ready for rays.
pub(super) struct Trees {
    content: Arc<Content>,
    items: Bvh2,
    /// The items that the tree holds: those that have faces.
    solid: Vec<ItemId>,
    /// The tree of each item's faces; in the item's space, or in the fragment's where the item is flattened.
    faces: Vec<Arc<Faces>>,
    /// Into each item's space; `None` where its tree is in the fragment's.
    item_from_fragment: Vec<Option<DAffine3>>,
    openings: Vec<Outline>,
}

/// A tree over the triangles of a mesh.
#[derive(Default)]
struct Faces {
    tree: Bvh2,
    /// Face and last corner of each triangle; empty where all faces are triangles.
    triangles: Vec<[u32; 2]>,
}

/// Nodes to be looked into, and where the bundle enters them; the next one last. Few trees are so deep that it needs
/// memory of its own.
type Waiting = SmallVec<[(f64, u32); 64]>;

struct Boxed(Aabb);

impl Boundable for Boxed {
    fn aabb(&self) -> obvhs::aabb::Aabb {
        obvhs::aabb::Aabb {
            min: self.0.min.into(),
            max: self.0.max.into(),
        }
    }
}

fn tree(boxes: &[Boxed]) -> Bvh2 {
    if boxes.is_empty() {
        return Bvh2::default();
    }
    let mut unused = Duration::ZERO;
    // One triangle a leaf: a box is tested once for a whole bundle, a triangle once for every ray.
    let params = BvhBuildParams {
        max_prims_per_leaf: 1,
        ..BvhBuildParams::fast_build()
    };
    build_bvh2(boxes, params, &mut unused)
}

impl Faces {
    fn build(mesh: &Mesh, placed: &Transform) -> Faces {
        let all_triangles = mesh.triangle_count() == u64::from(mesh.face_count());
        let mut triangles = Vec::new();
        let mut boxes = Vec::with_capacity(mesh.triangle_count() as usize);
        for face in 0..mesh.face_count() {
            let corners = mesh.face(face);
            for last in 2..corners.len() {
                if !all_triangles {
                    triangles.push([face, last as u32]);
                }
                let used = [corners[0], corners[last - 1], corners[last]];
                let corner = |index: u32| placed.point_box(mesh.positions()[index as usize]);
                boxes.push(Boxed(
                    used.into_iter().fold(Aabb::EMPTY, |sum, i| sum.union(&corner(i))),
                ));
            }
        }
        Faces {
            tree: tree(&boxes),
            triangles,
        }
    }
}

/// Trees of meshes that are built already, by the mesh's address: contents may share meshes.
#[derive(Default)]
pub(super) struct Built(HashMap<usize, Arc<Faces>>);

fn address(mesh: &Arc<Mesh>) -> usize {
    Arc::as_ptr(mesh).addr()
}

impl Trees {
    pub(super) fn build(content: &Arc<Content>, built: &mut Built) -> Trees {
        let new: Vec<(usize, Arc<Faces>)> = content
            .meshes()
            .par_iter()
            .filter(|mesh| !built.0.contains_key(&address(mesh)))
            .map(|mesh| (address(mesh), Arc::new(Faces::build(mesh, &Transform::IDENTITY))))
            .collect();
        built.0.extend(new);
        let item_from_fragment: Vec<Option<DAffine3>> = content
            .items()
            .iter()
            .map(|item| item.transform().inverse().map(|back| back.0))
            .collect();
        let faces = (content.items().iter().zip(&item_from_fragment))
            .map(|(item, back)| {
                let mesh = &content.meshes()[item.mesh.0 as usize];
                match back {
                    Some(_) => Arc::clone(&built.0[&address(mesh)]),
                    None => Arc::new(Faces::build(mesh, &item.transform())),
                }
            })
            .collect();
        let all = (0..content.items().len() as u32).map(ItemId);
        let solid: Vec<ItemId> = all
            .filter(|&item| !content.item(item).bounds.is_empty())
            .collect();
        let boxes: Vec<Boxed> = solid
            .iter()
            .map(|&item| Boxed(content.item(item).bounds))
            .collect();
        let outline = |opening: &Opening| {
            let corners = opening.outline.corners().iter();
            Outline::new(corners.map(|c| DVec3::from(c.map(f64::from))).collect())
        };
        Trees {
            openings: content.openings().iter().map(outline).collect(),
            content: Arc::clone(content),
            items: tree(&boxes),
            solid,
            faces,
            item_from_fragment,
        }
    }

    pub(super) fn openings(&self) -> &[Outline] {
        &self.openings
    }

    /// Meets all faces that rays of the bundle (those in `active`) meet no farther than the nearest that hides, or a
    /// little behind it; `limit` is asked again after each.
    pub(super) fn walk<const N: usize>(
        &self,
        bundle: &Bundle<N>,
        active: &[bool; N],
        found: &mut impl Found,
    ) {
        visit(&self.items, bundle, found, |place, found| {
            self.walk_item(self.solid[place as usize], bundle, active, found);
        });
    }

    fn walk_item<const N: usize>(
        &self,
        item: ItemId,
        bundle: &Bundle<N>,
        active: &[bool; N],
        found: &mut impl Found,
    ) {
        let faces = &self.faces[item.0 as usize];
        let back = &self.item_from_fragment[item.0 as usize];
        let local = back.map_or(*bundle, |back| bundle.moved(&back));
        let mesh = self.content.mesh_of(item);
        let fragment_from_item = self.content.item(item).transform();
        // A flattened item's faces are met where they stand.
        let place = back.is_none().then_some(fragment_from_item);
        visit(&faces.tree, &local, found, |triangle, found| {
            let [face, last] = *faces.triangles.get(triangle as usize).unwrap_or(&[triangle, 2]);
            let corners = mesh.face(face);
            let corner = |index: u32| {
                let position = DVec3::from(mesh.positions()[index as usize].map(f64::from));
                place.map_or(position, |place| place.0.transform_point3(position))
            };
            let used = [corners[0], corners[last as usize - 1], corners[last as usize]].map(corner);
            for ray in (0..N).filter(|&ray| active[ray]) {
                let Some((w, from_behind)) = local.meets(ray, used) else {
                    continue;
                };
                let material = self
                    .content
                    .material_of(item, &mesh.clusters()[mesh.cluster_of(face)]);
                if material.double_sided || !from_behind {
                    let hides = material.alpha == Alpha::Opaque;
                    let placed = match back {
                        Some(_) => used.map(|corner| fragment_from_item.0.transform_point3(corner)),
                        None => used,
                    };
                    let off = spread(placed, bundle.directions[ray]);
                    found.add(Meeting {
                        ray,
                        w: [(w - off).max(0.0), w + off],
                        item,
                        face,
                        hides,
                    });
                }
            }
        });
    }
}

/// By how much a ray's parameter changes where a triangle is moved along its normal by half the spacing of f32 at its
/// greatest coordinate: no closer are its corners to where they were meant.
fn spread(corners: [DVec3; 3], direction: DVec3) -> f64 {
    let [a, b, c] = corners;
    let greatest = corners
        .iter()
        .map(|corner| corner.abs().max_element())
        .fold(0.0, f64::max);
    let cosine = (b - a).cross(c - a).normalize_or_zero().dot(direction).abs();
    (0.5 * f64::from(f32::EPSILON) * greatest / cosine).min(f64::MAX)
}

/// Calls `leaf` with what lies in all boxes of a tree that a bundle may enter before the limit, roughly the nearest
/// first.
fn visit<const N: usize, F: Found>(
    tree: &Bvh2,
    bundle: &Bundle<N>,
    found: &mut F,
    mut leaf: impl FnMut(u32, &mut F),
) {
    if tree.nodes.is_empty() {
        return;
    }
    let slopes = bundle.slopes();
    let enters = |node: u32, limit: f64| {
        let bounds = tree.nodes[node as usize].aabb();
        let bounds = Aabb {
            min: bounds.min.into(),
            max: bounds.max.into(),
        };
        bundle.enters(&slopes, &bounds, limit)
    };
    let mut waiting = Waiting::new();
    waiting.extend(enters(0, found.limit()).map(|w| (w, 0)));
    while let Some((w, index)) = waiting.pop() {
        if w > found.limit() {
            continue;
        }
        let node = &tree.nodes[index as usize];
        if node.prim_count > 0 {
            for place in node.first_index..node.first_index + node.prim_count {
                leaf(tree.primitive_indices[place as usize], found);
            }
            continue;
        }
        let (one, other) = (node.first_index, node.first_index + 1);
        match (enters(one, found.limit()), enters(other, found.limit())) {
            (Some(a), Some(b)) if a < b => {
                waiting.push((b, other));
                waiting.push((a, one));
            }
            (Some(a), Some(b)) => {
                waiting.push((a, one));
                waiting.push((b, other));
            }
            (Some(a), None) => waiting.push((a, one)),
            (None, Some(b)) => waiting.push((b, other)),
            (None, None) => {}
        }
    }
}

/// Receives what rays meet.
pub(super) trait Found {
    /// Beyond this parameter nothing matters any more.
    fn limit(&self) -> f64;
    fn add(&mut self, meeting: Meeting);
}
