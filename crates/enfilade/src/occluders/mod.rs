//! Occluders: few large convex polygons that hide what the faces of a geometry hide.
//!
//! When they are built, faces of one mesh that lie in one plane and hang together become a sheet ([`sheets`]); a sheet
//! becomes one polygon where its outline is convex ([`outline`]), else several that may overlap ([`pieces`]). A look
//! then takes the best few ([`choose`]) and sees them on the screen ([`screen`]).
//! Source: Coorg, Teller, Real-Time Occlusion Culling for Models with Large Occluders, I3D 1997, for few large ones,
//!     chosen anew for each look; Boreskov, Hierarchical s-buffer for scenes of high complexity, for leaving small ones
//!     out.
//! Cost: building O(n log n) for each mesh, however many items are copies of it.
//! Exact, not simplified: what is hidden by an occluder is hidden by the faces it stands for. A point is behind one
//! where it is on the inner side of the planes through the eye and each edge, and behind the occluder's plane; and that
//! is pushed back, away from the eye, by [`Polygon::slack`], for corners of f32 do not lie in one plane.
//! Only opaque faces become occluders, and none that the maker of a scene marks as detail.

mod choose;
mod flat;
mod in_mesh;
mod measure;
mod outline;
mod pieces;
mod screen;
mod sheets;
mod soup;
mod summary;
#[cfg(test)]
mod tests;

pub use choose::{OccluderSelection, SelectedOccluder};
pub use measure::OccluderMeasure;
pub use screen::{Occluder, OccluderRoom};
pub use summary::OccluderSummary;

use crate::geom::{Aabb, Line, Octree, Step};
use crate::geometry::{Exchanged, Geometry, ItemId, MeshId, MovedItem};
use crate::mesh::Mesh;
use crate::threads;
use glam::{DMat3, DVec3};
use in_mesh::InMesh;
use outline::EXACT;

/// Polygons or items in a leaf of a tree, at most.
const FEW: usize = 8;

/// Meshes of no more faces are looked through side by side; of larger ones, each takes much memory, one after the other.
const LARGEST_SIDE_BY_SIDE: u32 = 1 << 16;

/// The occluders of a geometry: of each mesh once, in the space of the mesh.
#[derive(Clone, Debug, Default)]
pub struct OccluderSet {
    polygons: Vec<Polygon>,
    corners: Vec<DVec3>,
    /// By mesh.
    meshes: Vec<OfMesh>,
    /// Polygons of meshes that are gone.
    waste: usize,
    /// Over the items that have any.
    tree: Octree,
    /// Of each item the area of its largest, in the space of the sector, or more; 0 where it hides nothing.
    areas: Vec<f64>,
    /// For each node of the tree, the greatest of these below it.
    largest: Vec<f64>,
}

/// A convex polygon.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Polygon {
    first_corner: u32,
    corners: u32,
    /// Of unit length; it is seen from where this points to.
    normal: DVec3,
    /// Of its plane from the origin, along the normal.
    distance: f64,
    /// How far off the plane a corner of its faces stands, at most.
    slack: f64,
    /// How far it keeps from the outline of its faces; 0 where it is bounded by true edges, and hides for every eye.
    inset: f64,
    area: f64,
    /// The part of the area that no earlier polygon of the same faces covers.
    added: f64,
    /// Triangles merged into it, and into no earlier one.
    triangles: u32,
    centre: DVec3,
    /// Around its corners.
    bounds: Aabb,
    double_sided: bool,
}

/// An occluder as plain geometry, in the space of its mesh.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Wall<'a> {
    /// Counter-clockwise seen from where `normal` points to.
    pub(crate) corners: &'a [DVec3],
    /// Of unit length.
    pub(crate) normal: DVec3,
    /// Of its plane from the origin, along the normal.
    pub(crate) distance: f64,
    /// How far off the plane its faces stand, at most.
    pub(crate) slack: f64,
}

/// The occluders of a mesh.
#[derive(Clone, Debug, Default)]
struct OfMesh {
    /// The first, among all, and the one after the last.
    polygons: [u32; 2],
    /// Over the polygons, counted from the first.
    tree: Octree,
    /// For each node of the tree, the area of the largest below it.
    largest: Vec<f64>,
    /// Of all opaque faces.
    opaque_area: f64,
}

impl OccluderSet {
    /// About how many bytes [`OccluderSet::build`] works with.
    pub(crate) fn needs_bytes(geometry: &Geometry) -> u64 {
        /// For a face of the largest mesh, what finding its neighbours takes; the set itself is far smaller.
        const BYTES_PER_FACE: u64 = 256;
        let faces = geometry.meshes().iter().map(|mesh| u64::from(mesh.face_count()));
        faces.max().unwrap_or(0) * BYTES_PER_FACE + geometry.items().len() as u64 * 16
    }

    /// Finds the occluders of all meshes.
    pub fn build(geometry: &Geometry) -> OccluderSet {
        let is_small = |mesh: &Mesh| mesh.face_count() <= LARGEST_SIDE_BY_SIDE;
        let mut found: Vec<InMesh> = Vec::new();
        found.resize_with(geometry.meshes().len(), InMesh::default);
        threads::for_each(&mut found, |place, found| {
            let mesh = &geometry.meshes()[place];
            if is_small(mesh) {
                *found = InMesh::of(mesh, geometry);
            }
        });
        let mut set = OccluderSet::default();
        for (mesh, found) in geometry.meshes().iter().zip(found) {
            let found = if is_small(mesh) {
                found
            } else {
                InMesh::of(mesh, geometry)
            };
            let of_mesh = set.add(found);
            set.meshes.push(of_mesh);
        }
        set.polygons.shrink_to_fit();
        set.corners.shrink_to_fit();
        set.place(geometry);
        set
    }

    /// Follows items that were edited; gives the number of nodes touched.
    pub(crate) fn follow(&mut self, geometry: &Geometry, done: &Exchanged) -> u64 {
        for &mesh in &done.meshes {
            let of_mesh = self.add(InMesh::of(&geometry.meshes()[mesh.0 as usize], geometry));
            let place = mesh.0 as usize;
            if place >= self.meshes.len() {
                self.meshes.resize_with(place + 1, OfMesh::default);
            }
            let gone = std::mem::replace(&mut self.meshes[place], of_mesh);
            self.waste += (gone.polygons[1] - gone.polygons[0]) as usize;
        }
        if 2 * self.waste > self.polygons.len() {
            *self = OccluderSet::build(geometry);
            return self.tree.node_count() as u64;
        }
        self.areas.resize(geometry.items().len(), 0.0);
        for &MovedItem { item, .. } in &done.moved {
            self.areas[item.0 as usize] = self.area_of(geometry, item);
        }
        let OccluderSet { tree, areas, .. } = self;
        let boxes = |item: u32| box_of(geometry, areas, item);
        let mut touched = Vec::new();
        for MovedItem { item, old_bounds } in &done.moved {
            tree.shift(item.0, old_bounds, &boxes, &mut touched);
        }
        if tree.tidy(geometry.items().len(), &boxes) {
            self.largest = largest_below(&self.tree, |item| self.areas[item as usize]);
        } else {
            self.largest.resize(self.tree.node_count(), 0.0);
            // Of one that is there twice the last counts: then its children come before it.
            for &node in &touched {
                self.largest[node as usize] = self.largest_in(node);
            }
        }
        touched.len() as u64
    }

    /// The tree over the items.
    fn place(&mut self, geometry: &Geometry) {
        let items = 0..geometry.items().len() as u32;
        self.areas = items
            .clone()
            .map(|item| self.area_of(geometry, ItemId(item)))
            .collect();
        let bounds: Vec<Aabb> = items.map(|item| box_of(geometry, &self.areas, item)).collect();
        self.tree = Octree::build(&bounds, FEW);
        self.largest = largest_below(&self.tree, |item| self.areas[item as usize]);
    }

    /// The area of an item's largest occluder, in the space of the sector, or more; 0 where it hides nothing. One that its
    /// place flattens does not, and its areas are nothing.
    fn area_of(&self, geometry: &Geometry, item: ItemId) -> f64 {
        let placed = geometry.item(item);
        let largest = &self.meshes[placed.mesh.0 as usize].largest;
        match largest.first() {
            Some(largest) if placed.is_occluder && placed.transform().inverse().is_some() => {
                largest * greatest_stretch(cofactor(&placed.transform().0.matrix3)) * (1.0 + EXACT)
            }
            _ => 0.0,
        }
    }

    /// The greatest area in a node, where those of the nodes below it are known.
    fn largest_in(&self, node: u32) -> f64 {
        let own = self
            .tree
            .things(node)
            .iter()
            .map(|&item| self.areas[item as usize]);
        let below = self.tree.children(node).map(|child| self.largest[child as usize]);
        own.chain(below).fold(0.0, f64::max)
    }

    fn add(&mut self, found: InMesh) -> OfMesh {
        let first = self.polygons.len();
        for (polygon, corners) in found.polygons {
            self.polygons.push(Polygon {
                first_corner: self.corners.len() as u32,
                ..polygon
            });
            self.corners.extend(corners);
        }
        let polygons = &self.polygons[first..];
        let boxes: Vec<Aabb> = polygons.iter().map(|polygon| polygon.bounds).collect();
        let tree = Octree::build(&boxes, FEW);
        OfMesh {
            polygons: [first as u32, self.polygons.len() as u32],
            largest: largest_below(&tree, |polygon| polygons[polygon as usize].area),
            tree,
            opaque_area: found.opaque_area,
        }
    }

    /// Meets the occluders of a mesh whose boxes a line meets up to its end at 1, all in the space of the mesh.
    pub(crate) fn along(&self, mesh: MeshId, line: &Line, mut visit: impl FnMut(Wall)) {
        let Some(of_mesh) = self.meshes.get(mesh.0 as usize) else {
            return;
        };
        let polygons = &self.polygons[of_mesh.polygons[0] as usize..of_mesh.polygons[1] as usize];
        of_mesh.tree.walk(line.origin.into(), |step| match step {
            Step::Node(bounds) => line.meets(bounds, line.margin(bounds), 1.0).is_some(),
            Step::Thing(polygon) => {
                let polygon = &polygons[polygon as usize];
                visit(Wall {
                    corners: self.corners_of(polygon),
                    normal: polygon.normal,
                    distance: polygon.distance,
                    slack: polygon.slack,
                });
                true
            }
        });
    }

    fn corners_of(&self, polygon: &Polygon) -> &[DVec3] {
        &self.corners[polygon.first_corner as usize..(polygon.first_corner + polygon.corners) as usize]
    }

    /// Memory in bytes.
    pub fn bytes(&self) -> u64 {
        let meshes = self
            .meshes
            .iter()
            .map(|mesh| mesh.tree.bytes() + size_of_val(&*mesh.largest) as u64);
        (size_of_val(&*self.polygons)
            + size_of_val(&*self.corners)
            + size_of_val(&*self.meshes)
            + size_of_val(&*self.areas)
            + size_of_val(&*self.largest)) as u64
            + self.tree.bytes()
            + meshes.sum::<u64>()
    }
}

/// The box of an item that hides something; that of nothing where it does not.
fn box_of(geometry: &Geometry, areas: &[f64], item: u32) -> Aabb {
    if areas[item as usize] > 0.0 {
        geometry.item(ItemId(item)).bounds
    } else {
        Aabb::EMPTY
    }
}

/// For each node of a tree, the greatest area below it.
fn largest_below(tree: &Octree, area: impl Fn(u32) -> f64) -> Vec<f64> {
    let mut largest = vec![0.0; tree.node_count()];
    // Children have higher numbers than their parents.
    for node in (0..largest.len()).rev() {
        let own = tree.things(node as u32).iter().map(|&thing| area(thing));
        let below = tree.children(node as u32).map(|child| largest[child as usize]);
        largest[node] = own.chain(below).fold(0.0, f64::max);
    }
    largest
}

/// The map of normals times areas that goes with a map of points.
fn cofactor(matrix: &DMat3) -> DMat3 {
    let DMat3 {
        x_axis: x,
        y_axis: y,
        z_axis: z,
    } = *matrix;
    DMat3::from_cols(y.cross(z), z.cross(x), x.cross(y))
}

/// By how much a map lengthens a vector, at most; exact where it is alike in all directions.
fn greatest_stretch(matrix: DMat3) -> f64 {
    let gram = matrix.transpose() * matrix;
    let rows = [gram.x_axis, gram.y_axis, gram.z_axis].map(|row| row.abs().element_sum());
    rows.into_iter().fold(0.0, f64::max).sqrt()
}
