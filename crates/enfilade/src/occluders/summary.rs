//! Statistics of the occluders of a geometry.

use super::{OccluderSet, cofactor, greatest_stretch};
use crate::geometry::{Alpha, Geometry, Item};
use crate::mesh::Mesh;
use glam::{DMat3, DVec3};

/// Statistics of the occluders of a geometry.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
#[non_exhaustive]
pub struct OccluderSummary {
    /// Number of polygons, counting each mesh once.
    pub polygons: u64,
    /// Number of polygons over all items that may occlude.
    pub placed: u64,
    /// Number of triangles merged into them, counting each mesh once.
    pub triangles: u64,
    /// Area that they cover over all items, in square scene units; where polygons of a mesh overlap, counted once.
    pub area: f64,
    /// Area of the opaque faces of all items that may occlude, in square scene units.
    pub opaque_area: f64,
    /// Memory of the occluder set, in bytes.
    pub bytes: u64,
}

impl OccluderSet {
    /// Computes statistics over all items.
    pub fn summary(&self, geometry: &Geometry) -> OccluderSummary {
        let mut summary = OccluderSummary {
            polygons: self.polygons.len() as u64,
            triangles: self
                .polygons
                .iter()
                .map(|polygon| u64::from(polygon.triangles))
                .sum(),
            bytes: self.bytes(),
            ..OccluderSummary::default()
        };
        let added: Vec<f64> = self
            .meshes
            .iter()
            .map(|mesh| self.added(mesh.polygons, &DMat3::IDENTITY))
            .collect();
        for item in geometry.items().iter().filter(|item| item.options.is_occluder) {
            let of_mesh = &self.meshes[item.mesh.0 as usize];
            summary.placed += u64::from(of_mesh.polygons[1] - of_mesh.polygons[0]);
            let areas = cofactor(&item.transform().0.matrix3);
            let (least, greatest) = stretches(&areas);
            if greatest - least <= 1e-5 * greatest {
                summary.area += greatest * added[item.mesh.0 as usize];
                summary.opaque_area += greatest * of_mesh.opaque_area;
            } else {
                summary.area += self.added(of_mesh.polygons, &areas);
                summary.opaque_area += opaque_area(geometry, item, &areas);
            }
        }
        summary
    }

    /// Returns the area that polygons cover, given a matrix that maps area vectors.
    fn added(&self, [start, end]: [u32; 2], areas: &DMat3) -> f64 {
        let polygons = &self.polygons[start as usize..end as usize];
        polygons
            .iter()
            .map(|polygon| polygon.added * (*areas * polygon.normal).length())
            .sum()
    }
}

/// Returns bounds of the factors by which a matrix lengthens vectors, minimum and maximum; equal if it scales
/// uniformly.
fn stretches(map: &DMat3) -> (f64, f64) {
    let inverse = map.inverse();
    let least = if inverse.is_finite() {
        1.0 / greatest_stretch(inverse)
    } else {
        0.0
    };
    (least, greatest_stretch(*map))
}

/// Returns the area of the opaque faces of an item, given a matrix that maps area vectors.
fn opaque_area(geometry: &Geometry, item: &Item, areas: &DMat3) -> f64 {
    let mesh: &Mesh = &geometry.meshes()[item.mesh.0 as usize];
    let opaque = mesh
        .clusters()
        .iter()
        .filter(|cluster| geometry.material(cluster).alpha == Alpha::Opaque);
    let faces = opaque.flat_map(|cluster| cluster.faces.clone());
    faces
        .map(|face| {
            let corner = |index: u32| DVec3::from(mesh.positions()[index as usize].map(f64::from));
            let corners = mesh.face(face);
            let first = corner(corners[0]);
            let sum: DVec3 = corners
                .windows(2)
                .map(|pair| (corner(pair[0]) - first).cross(corner(pair[1]) - first))
                .sum();
            0.5 * (*areas * sum).length()
        })
        .sum()
}
