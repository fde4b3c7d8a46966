//! Bounding volume hierarchies over faces and items, traversed by ray bundles in f64.
//!
//! They share no code with those of the methods, so that a fault there is detected. A split leaves at least an eighth
//! of a node's boxes on either side: building takes O(n log n) time and depth is O(log n) for any boxes.

use super::bundle::Bundle;
use super::openings::Outline;
use crate::geom::{Aabb, Transform};
use crate::geometry::{Alpha, Geometry, Opening};
use crate::ids::ItemIndex;
use crate::mesh::Mesh;
use glam::{DAffine3, DVec3};
use rayon::prelude::*;
use smallvec::SmallVec;
use std::collections::HashMap;
use std::sync::Arc;

/// A ray/face hit.
#[derive(Clone, Copy, Debug)]
pub(super) struct Meeting {
    pub(super) ray: usize,
    /// Minimum and maximum ray parameter, as positions are rounded to f32.
    pub(super) w: [f64; 2],
    pub(super) item: ItemIndex,
    pub(super) face: u32,
    pub(super) hides: bool,
}

/// The trees of a geometry.
pub(super) struct Trees {
    geometry: Arc<Geometry>,
    items: Tree,
    /// Items in the tree: those that have faces, in a layer that is looked at.
    solid: Vec<ItemIndex>,
    /// Items that are only bounds, in a layer that is looked at.
    bounds_only: Vec<ItemIndex>,
    /// The tree of each item's faces, in the item's space; in the sector's space if the item's transform is singular.
    faces: Vec<Arc<Faces>>,
    /// Transform into each item's space; `None` if its tree is in the sector's space.
    item_from_sector: Vec<Option<DAffine3>>,
    openings: Vec<Outline>,
}

/// A BVH over the triangles of a mesh.
#[derive(Default)]
struct Faces {
    tree: Tree,
    /// Face and last corner of each triangle; empty if all faces are triangles.
    triangles: Vec<[u32; 2]>,
}

/// Stack of nodes to visit, with the parameter at which the bundle enters them; popped from the end. Few trees are deep
/// enough to need a heap allocation.
type NodeStack = SmallVec<[(f64, u32); 64]>;

/// A BVH with one box per leaf: a box is tested once per bundle, a triangle once per ray.
#[derive(Default)]
struct Tree {
    /// The root is first; the two children of a node are adjacent.
    nodes: Vec<Node>,
}

struct Node {
    bounds: Aabb,
    below: Below,
}

enum Below {
    /// Index of the first of two adjacent children.
    Children(u32),
    /// Index of a box.
    Leaf(u32),
}

/// Number of bins for the centres of a node's boxes.
const BINS: usize = 8;

impl Tree {
    fn build(boxes: &[Aabb]) -> Tree {
        let mut order: Vec<u32> = (0..boxes.len() as u32).collect();
        let mut nodes = Vec::with_capacity((2 * boxes.len()).saturating_sub(1));
        let node = |held: &[u32]| Node {
            bounds: held
                .iter()
                .fold(Aabb::EMPTY, |sum, &i| sum.union(&boxes[i as usize])),
            below: Below::Leaf(held[0]),
        };
        if !order.is_empty() {
            nodes.push(node(&order));
        }
        let mut waiting = vec![(0, &mut order[..])];
        while let Some((number, held)) = waiting.pop() {
            if held.len() < 2 {
                continue;
            }
            let at = cut(held, boxes);
            let (low, high) = held.split_at_mut(at);
            let first = nodes.len();
            nodes[number].below = Below::Children(first as u32);
            nodes.extend([node(low), node(high)]);
            waiting.extend([(first, low), (first + 1, high)]);
        }
        Tree { nodes }
    }
}

/// Partitions at least two boxes into two groups, along the longest axis of the bounds of their centres. Returns the
/// start of the second group.
fn cut(held: &mut [u32], boxes: &[Aabb]) -> usize {
    if held.len() == 2 {
        return 1;
    }
    let center = |&i: &u32| DVec3::from(boxes[i as usize].center().map(f64::from));
    let [low, high] = (held.iter().map(center))
        .fold([DVec3::INFINITY, DVec3::NEG_INFINITY], |[low, high], at| {
            [low.min(at), high.max(at)]
        });
    let axis = (high - low).max_position();
    let scale = BINS as f64 / (high - low)[axis];
    let bin_of = |i: &u32| (((center(i) - low)[axis] * scale) as usize).min(BINS - 1);
    let mut bins = [(Aabb::EMPTY, 0); BINS];
    for i in &*held {
        let (bounds, count) = &mut bins[bin_of(i)];
        *bounds = bounds.union(&boxes[*i as usize]);
        *count += 1;
    }
    // Surface area times box count on either side of each bin border (surface area heuristic).
    let sums = |bins: &mut dyn Iterator<Item = &(Aabb, usize)>| {
        let mut sum = (Aabb::EMPTY, 0);
        let mut add = |bin: &(Aabb, usize)| {
            sum = (sum.0.union(&bin.0), sum.1 + bin.1);
            (sum.0.half_area() * sum.1 as f64, sum.1)
        };
        bins.map(&mut add).collect::<SmallVec<[(f64, usize); BINS]>>()
    };
    let [below, above] = [sums(&mut bins.iter()), sums(&mut bins.iter().rev())];
    let cuts = (1..BINS).map(|bin| (bin, below[bin - 1], above[BINS - 1 - bin]));
    let best = cuts
        .filter(|(_, below, above)| below.1.min(above.1) > held.len() / 8)
        .min_by(|a, b| (a.1.0 + a.2.0).total_cmp(&(b.1.0 + b.2.0)));
    let Some((bin, (_, count), _)) = best else {
        let half = held.len() / 2;
        held.select_nth_unstable_by(half, |a, b| {
            center(a)[axis].total_cmp(&center(b)[axis]).then(a.cmp(b))
        });
        return half;
    };
    let mut next = 0;
    for i in 0..held.len() {
        if bin_of(&held[i]) < bin {
            held.swap(i, next);
            next += 1;
        }
    }
    count
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
                boxes.push(placed.box_of(&used.map(|index| mesh.positions()[index as usize])));
            }
        }
        Faces {
            tree: Tree::build(&boxes),
            triangles,
        }
    }
}

/// Trees already built, by the address of their mesh: geometries may share meshes.
#[derive(Default)]
pub(super) struct MeshTrees(HashMap<usize, Arc<Faces>>);

fn address(mesh: &Arc<Mesh>) -> usize {
    Arc::as_ptr(mesh).addr()
}

impl Trees {
    pub(super) fn build(geometry: &Arc<Geometry>, layers: u32, built: &mut MeshTrees) -> Trees {
        let new: Vec<(usize, Arc<Faces>)> = geometry
            .meshes()
            .par_iter()
            .filter(|mesh| !built.0.contains_key(&address(mesh)))
            .map(|mesh| (address(mesh), Arc::new(Faces::build(mesh, &Transform::IDENTITY))))
            .collect();
        built.0.extend(new);
        let item_from_sector: Vec<Option<DAffine3>> = geometry
            .items()
            .iter()
            .map(|item| item.transform().inverse().map(|back| back.0))
            .collect();
        let faces = (geometry.items().iter().zip(&item_from_sector))
            .map(|(item, back)| {
                let mesh = &geometry.meshes()[item.mesh.0 as usize];
                match back {
                    Some(_) => Arc::clone(&built.0[&address(mesh)]),
                    None => Arc::new(Faces::build(mesh, &item.transform())),
                }
            })
            .collect();
        let all = (0..geometry.items().len() as u32).map(ItemIndex);
        let (solid, bounds_only): (Vec<_>, Vec<_>) = all
            .filter(|&item| {
                let placed = geometry.item(item);
                !placed.bounds.is_empty() && placed.options.layers & layers != 0
            })
            .partition(|&item| geometry.mesh_of(item).face_count() > 0);
        let boxes: Vec<Aabb> = solid.iter().map(|&item| geometry.item(item).bounds).collect();
        let outline = |opening: &Opening| {
            let corners = opening.outline.corners().iter();
            Outline::new(corners.map(|c| DVec3::from(c.map(f64::from))).collect())
        };
        Trees {
            openings: geometry.openings().iter().map(outline).collect(),
            geometry: Arc::clone(geometry),
            items: Tree::build(&boxes),
            solid,
            bounds_only,
            faces,
            item_from_sector,
        }
    }

    pub(super) fn openings(&self) -> &[Outline] {
        &self.openings
    }

    pub(super) fn is_drawn(&self, item: ItemIndex) -> bool {
        self.geometry.item(item).options.is_drawn
    }

    /// Calls `found` with each ray in `active` that passes through an item that is only bounds, the item, and the
    /// parameters at which the ray enters and leaves it.
    pub(super) fn pass_bounds<const N: usize>(
        &self,
        bundle: &Bundle<N>,
        active: &[bool; N],
        mut found: impl FnMut(usize, ItemIndex, [f64; 2]),
    ) {
        for &item in self.bounds_only.iter().filter(|&&item| self.is_drawn(item)) {
            // A flattened box is tested by its AABB.
            let (local, bounds) = match &self.item_from_sector[item.0 as usize] {
                Some(back) => (bundle.moved(back), self.geometry.mesh_of(item).bounds()),
                None => (*bundle, self.geometry.item(item).bounds),
            };
            for ray in (0..N).filter(|&ray| active[ray]) {
                if let Some(w) = local.passes(ray, &bounds) {
                    found(ray, item, w);
                }
            }
        }
    }

    /// Reports all faces hit by the rays in `active`, up to slightly beyond the nearest occluder; reads `limit` again
    /// after each hit.
    pub(super) fn walk<const N: usize>(
        &self,
        bundle: &Bundle<N>,
        active: &[bool; N],
        found: &mut impl HitSink,
    ) {
        visit(&self.items, bundle, found, |place, found| {
            self.walk_item(self.solid[place as usize], bundle, active, found);
        });
    }

    fn walk_item<const N: usize>(
        &self,
        item: ItemIndex,
        bundle: &Bundle<N>,
        active: &[bool; N],
        found: &mut impl HitSink,
    ) {
        let faces = &self.faces[item.0 as usize];
        let back = &self.item_from_sector[item.0 as usize];
        let local = back.map_or(*bundle, |back| bundle.moved(&back));
        let mesh = self.geometry.mesh_of(item);
        let sector_from_item = self.geometry.item(item).transform();
        // A singular transform has no inverse: such an item's faces are intersected in the sector's space.
        let place = back.is_none().then_some(sector_from_item);
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
                    .geometry
                    .material_of(item, &mesh.clusters()[mesh.cluster_of(face)]);
                if material.double_sided || !from_behind {
                    let hides = material.alpha == Alpha::Opaque;
                    if !hides && !self.is_drawn(item) {
                        continue;
                    }
                    let placed = match back {
                        Some(_) => used.map(|corner| sector_from_item.0.transform_point3(corner)),
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

/// Returns how much a ray's parameter can change if each corner of a triangle moves by half an f32 ulp of its largest
/// coordinate, the rounding error of f32 positions. That also tilts the triangle; one as thin as an ulp may face any
/// direction.
fn spread([a, b, c]: [DVec3; 3], direction: DVec3) -> f64 {
    let greatest = [a, b, c].map(|corner| corner.abs().max_element());
    let moved = 0.5 * f64::from(f32::EPSILON) * greatest.into_iter().fold(0.0, f64::max);
    let [ab, ac] = [b - a, c - a];
    let normal = ab.cross(ac);
    let tilt = 2.0 * moved * (ab.length() + ac.length()) * direction.length();
    let facing = normal.dot(direction).abs() - tilt;
    if facing > 0.0 {
        (moved * normal.length() / facing).min(f64::MAX)
    } else {
        f64::MAX
    }
}

/// Calls `leaf` for all leaves that a bundle may enter before the limit, roughly front to back.
fn visit<const N: usize, F: HitSink>(
    tree: &Tree,
    bundle: &Bundle<N>,
    found: &mut F,
    mut leaf: impl FnMut(u32, &mut F),
) {
    if tree.nodes.is_empty() {
        return;
    }
    let slopes = bundle.slopes();
    let enters = |node: u32, limit: f64| bundle.enters(&slopes, &tree.nodes[node as usize].bounds, limit);
    let mut waiting = NodeStack::new();
    waiting.extend(enters(0, found.limit()).map(|w| (w, 0)));
    while let Some((w, index)) = waiting.pop() {
        if w > found.limit() {
            continue;
        }
        let one = match tree.nodes[index as usize].below {
            Below::Children(first) => first,
            Below::Leaf(number) => {
                leaf(number, found);
                continue;
            }
        };
        let other = one + 1;
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

/// Receives ray/face hits.
pub(super) trait HitSink {
    /// Parameter beyond which hits are ignored.
    fn limit(&self) -> f64;
    fn add(&mut self, meeting: Meeting);
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn trees_over_boxes_that_are_hard_to_separate_are_shallow() {
        let cube = |at: f32, side: f32| Aabb {
            min: [at - side, -side, -side],
            max: [at + side, side, side],
        };
        let all = |each: fn(f32) -> [f32; 2]| -> Vec<Aabb> {
            let each = (0..100_000_u32).map(|i| each(i as f32));
            each.map(|[at, side]| cube(at, side)).collect()
        };
        for boxes in [
            all(|_| [0.0, 1.0]),
            all(|_| [0.0, 0.0]),
            all(|i| [0.0, i]),
            all(|i| [i * i, 0.5]),
            all(|i| [(i * 1e-3).exp2().min(1e38), 0.5]),
            all(|i| [3e38 - i * 1e33, 0.5]),
        ] {
            let tree = Tree::build(&boxes);
            let mut times = vec![0; boxes.len()];
            let mut waiting = vec![(0, 1)];
            while let Some((node, depth)) = waiting.pop() {
                // log n / log(8/7)
                assert!(depth <= 87, "{depth}");
                match tree.nodes[node].below {
                    Below::Leaf(number) => times[number as usize] += 1,
                    Below::Children(first) => {
                        waiting.extend([0, 1].map(|i| (first as usize + i, depth + 1)));
                    }
                }
            }
            assert!(times.iter().all(|&times| times == 1));
        }
        assert!(Tree::build(&[]).nodes.is_empty());
    }
}
