//! Occluder selection: a few large convex polygons that hide what the faces of a geometry hide.
//!
//! When an [`OccluderSet`] is built, connected coplanar faces of a mesh are merged into a sheet ([`sheets`]). A sheet
//! becomes one polygon if its outline is convex ([`outline`]), otherwise several that may overlap ([`pieces`]). Each
//! look then selects the best few ([`choose`]) and projects them to the screen ([`screen`]).
//! Source: Coorg, Teller, Real-Time Occlusion Culling for Models with Large Occluders, I3D 1997, for a few large
//!     occluders, selected anew for each view; Boreskov, Hierarchical s-buffer for scenes of high complexity, for
//!     leaving out small ones.
//! Cost: building O(n log n) for each mesh, however many items are copies of it.
//! Exact, not simplified: everything that an occluder hides is hidden by the faces it was merged from. A point is
//! hidden if it is on the inner side of the planes through the eye and each edge, and behind the occluder's plane. That
//! plane is pushed away from the eye by [`Polygon::slack`], because corners in f32 are not exactly coplanar.
//! Only opaque faces become occluders, and none that the scene's author marks as detail.

mod choose;
mod flat;
mod in_mesh;
mod large_faces;
mod measure;
mod outline;
mod pieces;
mod screen;
mod sheets;
mod soup;
mod stored;
mod summary;
#[cfg(test)]
mod tests;

pub use choose::{OccluderSelection, SelectedOccluder};
pub(crate) use large_faces::{LargeFace, large_faces};
pub use measure::OccluderMeasure;
pub use screen::{Occluder, OccluderRoom};
pub use summary::OccluderSummary;

use crate::geom::{Aabb, Line, Octree, Step};
use crate::geometry::{Exchanged, Geometry, MovedItem};
use crate::ids::{ItemIndex, MeshId};
use crate::mesh::Mesh;
use crate::threads;
use glam::{DMat3, DVec3};
use in_mesh::MeshPolygons;
use outline::EXACT;

/// Maximum number of polygons or items in a leaf of an octree.
const FEW: usize = 8;

/// Meshes of up to this many faces are processed in parallel; larger ones one after the other, since each takes much
/// memory.
const LARGEST_SIDE_BY_SIDE: u32 = 1 << 16;

/// The occluders of a geometry: planar convex polygons, stored once per mesh in the mesh's object space.
///
/// Build it with [`OccluderSet::build`], select the best occluders of a view with [`OccluderSet::choose`], and project
/// each of them with [`OccluderSet::on_screen`].
#[derive(Clone, Debug, Default)]
#[doc(alias = "occluder mesh")]
#[doc(alias = "occlusion proxy")]
pub struct OccluderSet {
    polygons: Vec<Polygon>,
    corners: Vec<DVec3>,
    /// Occluders of each mesh, by its index.
    meshes: Vec<MeshOccluders>,
    /// Number of polygons of meshes that were removed or replaced.
    waste: usize,
    /// Octree over the items that have occluders.
    tree: Octree,
    /// For each item, an upper bound of the area of its largest occluder, in sector space; 0 if it hides nothing.
    areas: Vec<f64>,
    /// For each node of the tree, the maximum of `areas` below it.
    largest: Vec<f64>,
}

/// A convex occluder polygon in the object space of its mesh.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Polygon {
    first_corner: u32,
    corners: u32,
    /// Unit normal; points to the side from which the polygon is visible (front face).
    normal: DVec3,
    /// Distance of its plane from the origin, along the normal.
    distance: f64,
    /// Maximum distance of a corner of its faces from the plane.
    slack: f64,
    /// Distance that it keeps from the outline of its faces; 0 if it is bounded by edges of the mesh, and then hides
    /// from every eye position.
    inset: f64,
    area: f64,
    /// Part of the area that no earlier polygon of the same faces covers.
    added: f64,
    /// Number of triangles merged into it and into no earlier polygon.
    triangles: u32,
    centre: DVec3,
    /// Bounding box of its corners.
    bounds: Aabb,
    double_sided: bool,
}

/// An occluder as a plain polygon, in the object space of its mesh.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Wall<'a> {
    /// At least three, counter-clockwise when viewed from the side that `normal` points to.
    pub(crate) corners: &'a [DVec3],
    /// Unit normal of the plane.
    pub(crate) normal: DVec3,
    /// Distance of its plane from the origin, along the normal.
    pub(crate) distance: f64,
    /// Maximum distance of its faces from the plane.
    pub(crate) slack: f64,
}

/// Occluders of one mesh.
#[derive(Clone, Debug, Default)]
struct MeshOccluders {
    /// Index range of its polygons in the set: first, end (exclusive).
    polygons: [u32; 2],
    /// Octree over its polygons, which are counted from the first.
    tree: Octree,
    /// For each node of the tree, the area of the largest polygon below it.
    largest: Vec<f64>,
    /// Total area of its opaque faces that may occlude.
    opaque_area: f64,
}

impl OccluderSet {
    /// Estimates the peak memory of [`OccluderSet::build`], in bytes.
    pub(crate) fn needs_bytes(geometry: &Geometry) -> u64 {
        /// Memory per face of the largest mesh while its neighbours are found; the set itself is far smaller.
        const BYTES_PER_FACE: u64 = 256;
        u64::from(geometry.most_faces()) * BYTES_PER_FACE + geometry.items().len() as u64 * 16
    }

    /// Builds the occluders of all meshes of a geometry.
    ///
    /// O(n log n) in the faces of each mesh; small meshes are processed in parallel.
    pub fn build(geometry: &Geometry) -> OccluderSet {
        let is_small = |mesh: &Mesh| mesh.face_count() <= LARGEST_SIDE_BY_SIDE;
        let mut found: Vec<MeshPolygons> = Vec::new();
        found.resize_with(geometry.meshes().len(), MeshPolygons::default);
        threads::for_each(&mut found, |place, found| {
            let mesh = &geometry.meshes()[place];
            if is_small(mesh) {
                *found = MeshPolygons::of(mesh, geometry.materials());
            }
        });
        let mut set = OccluderSet::default();
        for (mesh, found) in geometry.meshes().iter().zip(found) {
            let found = if is_small(mesh) {
                found
            } else {
                MeshPolygons::of(mesh, geometry.materials())
            };
            let of_mesh = set.add(found);
            set.meshes.push(of_mesh);
        }
        set.polygons.shrink_to_fit();
        set.corners.shrink_to_fit();
        set.build_tree(geometry);
        set
    }

    /// Updates the set after items were edited, and returns the number of octree nodes touched.
    pub(crate) fn follow(&mut self, geometry: &Geometry, done: &mut Exchanged) -> u64 {
        for &mesh in &done.meshes {
            let found = MeshPolygons::of(&geometry.meshes()[mesh.0 as usize], geometry.materials());
            let of_mesh = self.add(found);
            let place = mesh.0 as usize;
            if place >= self.meshes.len() {
                self.meshes.resize_with(place + 1, MeshOccluders::default);
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
        done.touched.clear();
        for MovedItem { item, old_bounds } in &done.moved {
            tree.shift(item.0, old_bounds, &boxes, &mut done.touched);
        }
        if tree.tidy(geometry.items().len(), &boxes) {
            self.largest = largest_below(&self.tree, |item| self.areas[item as usize]);
        } else {
            self.largest.resize(self.tree.node_count(), 0.0);
            // If a node is listed twice, the last entry counts: by then its children are up to date.
            for &node in &done.touched {
                self.largest[node as usize] = self.largest_in(node);
            }
        }
        done.touched.len() as u64
    }

    /// Builds the octree over the items.
    fn build_tree(&mut self, geometry: &Geometry) {
        let items = 0..geometry.items().len() as u32;
        self.areas = items
            .clone()
            .map(|item| self.area_of(geometry, ItemIndex(item)))
            .collect();
        let bounds: Vec<Aabb> = items.map(|item| box_of(geometry, &self.areas, item)).collect();
        self.tree = Octree::build(&bounds, FEW);
        self.largest = largest_below(&self.tree, |item| self.areas[item as usize]);
    }

    /// Returns an upper bound of the area of an item's largest occluder, in sector space; 0 if it hides nothing. An
    /// item flattened by its transform hides nothing, since its areas are meaningless.
    fn area_of(&self, geometry: &Geometry, item: ItemIndex) -> f64 {
        let placed = geometry.item(item);
        let largest = &self.meshes[placed.mesh.0 as usize].largest;
        match largest.first() {
            Some(largest) if placed.options.is_occluder && placed.transform().inverse().is_some() => {
                largest * greatest_stretch(cofactor(&placed.transform().0.matrix3)) * (1.0 + EXACT)
            }
            _ => 0.0,
        }
    }

    /// Returns the maximum area in a node, given those of its children.
    fn largest_in(&self, node: u32) -> f64 {
        let own = self
            .tree
            .things(node)
            .iter()
            .map(|&item| self.areas[item as usize]);
        let below = self.tree.children(node).map(|child| self.largest[child as usize]);
        own.chain(below).fold(0.0, f64::max)
    }

    /// Appends the polygons found in a mesh.
    fn add(&mut self, found: MeshPolygons) -> MeshOccluders {
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
        MeshOccluders {
            polygons: [first as u32, self.polygons.len() as u32],
            largest: largest_below(&tree, |polygon| polygons[polygon as usize].area),
            tree,
            opaque_area: found.opaque_area,
        }
    }

    /// Visits the occluders of a mesh whose boxes a line segment, with its end at parameter 1, intersects. All
    /// coordinates are in the object space of the mesh.
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

    /// Returns the corners of a polygon.
    fn corners_of(&self, polygon: &Polygon) -> &[DVec3] {
        &self.corners[polygon.first_corner as usize..(polygon.first_corner + polygon.corners) as usize]
    }

    /// Returns the memory of the set in bytes.
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

/// Returns the bounding box of an item with occluders; an empty box if it has none.
fn box_of(geometry: &Geometry, areas: &[f64], item: u32) -> Aabb {
    if areas[item as usize] > 0.0 {
        geometry.item(ItemIndex(item)).bounds
    } else {
        Aabb::EMPTY
    }
}

/// Returns, for each node of a tree, the maximum area below it.
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

/// Returns the cofactor matrix: it maps area vectors (area times normal) as `matrix` maps points.
fn cofactor(matrix: &DMat3) -> DMat3 {
    let DMat3 {
        x_axis: x,
        y_axis: y,
        z_axis: z,
    } = *matrix;
    DMat3::from_cols(y.cross(z), z.cross(x), x.cross(y))
}

/// Returns an upper bound of the factor by which a matrix lengthens a vector; exact if it scales uniformly.
fn greatest_stretch(matrix: DMat3) -> f64 {
    let gram = matrix.transpose() * matrix;
    let rows = [gram.x_axis, gram.y_axis, gram.z_axis].map(|row| row.abs().element_sum());
    rows.into_iter().fold(0.0, f64::max).sqrt()
}
