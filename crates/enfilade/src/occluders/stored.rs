//! Occluders as bytes, kept with a mesh: finding them takes longer than reading the mesh.
//!
//! Layout, in little-endian words of 32 bits: [`Header`], the polygons, and for each cluster of the mesh a byte:
//! [`cluster_flags`]. A polygon is its [`Head`], its number of triangles, its corners, and those of its values that do not follow
//! from its corners ([`each_value`]): most have a few vertices of the mesh as corners, and all values follow.

use super::Polygon;
use super::in_mesh::{MeshPolygons, area, box_around};
use super::outline::EXACT;
use super::sheets::unit_normal;
use super::soup::twice_area;
use crate::geometry::Material;
use crate::mesh::{Cluster, Mesh};
use bytemuck::{Pod, Zeroable};
use bytes::Bytes;
use glam::DVec3;
use std::collections::HashMap;

/// What the bytes begin with.
#[repr(C)]
#[derive(Clone, Copy, Debug, Pod, Zeroable)]
struct Header {
    opaque_area: f64,
    polygons: u32,
    /// Length of the polygons, in bytes.
    length: u32,
}

/// What stands before the position of a corner that is no vertex of the mesh, instead of the vertex.
const NOT_A_VERTEX: u32 = u32::MAX;

/// The first word of a polygon.
struct Head {
    /// Number of corners.
    corners: usize,
    double_sided: bool,
    /// Bit mask of the values that are stored.
    stored: u8,
}

impl Head {
    fn of(word: u32) -> Head {
        Head {
            corners: word as usize & 0xFFFF,
            double_sided: word & 1 << 16 != 0,
            stored: (word >> 24) as u8,
        }
    }

    fn word(&self) -> u32 {
        self.corners as u32 | u32::from(self.double_sided) << 16 | u32::from(self.stored) << 24
    }
}

impl Mesh {
    /// Returns the mesh with its occluders, which [`Mesh::to_bytes`] then writes too: found once, for all geometries in which the
    /// same clusters are opaque and double-sided as with these materials. Those of other meshes are found by each
    /// [`OccluderSet::build`](super::OccluderSet::build).
    ///
    /// O(n log n) in the faces.
    ///
    /// # Panics
    /// If a cluster has a material that is not among them.
    #[must_use]
    pub fn with_occluders(&self, materials: &[Material]) -> Mesh {
        let found = MeshPolygons::of(self, materials);
        let mut mesh = self.clone();
        mesh.set_occluder_bytes(Bytes::from(write(&found, self, materials)));
        mesh
    }

    /// Returns the mesh without the occluders of [`Mesh::with_occluders`].
    #[must_use]
    pub fn without_occluders(&self) -> Mesh {
        let mut mesh = self.clone();
        mesh.set_occluder_bytes(Bytes::new());
        mesh
    }
}

/// Returns what occluders depend on, besides the faces of a cluster.
fn cluster_flags(cluster: &Cluster, materials: &[Material]) -> u8 {
    if cluster.faces.is_empty() {
        return 0;
    }
    let material = &materials[cluster.material.0 as usize];
    u8::from(material.can_occlude()) | u8::from(material.double_sided) << 1
}

fn write(found: &MeshPolygons, mesh: &Mesh, materials: &[Material]) -> Vec<u8> {
    let bits = |point: DVec3| point.to_array().map(f64::to_bits);
    // Few vertices of a mesh are corners of occluders.
    let corners = found.polygons.iter().flat_map(|(_, corners)| corners);
    let mut vertices: HashMap<[u64; 3], Option<u32>> = corners.map(|&corner| (bits(corner), None)).collect();
    for (index, &vertex) in (0..).zip(mesh.positions()) {
        if let Some(known) = vertices.get_mut(&bits(position(vertex))) {
            known.get_or_insert(index);
        }
    }
    let mut polygons: Vec<u8> = Vec::new();
    for (polygon, corners) in &found.polygons {
        let (mut stored, mut values, mut number) = (0, Vec::new(), 0);
        each_value(&mut { *polygon }, corners, |value, expected| {
            if value.to_bits() != expected.to_bits() {
                stored |= 1 << number;
                values.push(*value);
            }
            number += 1;
        });
        let head = Head {
            corners: corners.len(),
            double_sided: polygon.double_sided,
            stored,
        };
        polygons.extend_from_slice(bytemuck::bytes_of(&[head.word(), polygon.triangles]));
        for &corner in corners {
            let vertex = vertices[&bits(corner)].unwrap_or(NOT_A_VERTEX);
            polygons.extend_from_slice(bytemuck::bytes_of(&vertex));
            if vertex == NOT_A_VERTEX {
                polygons.extend_from_slice(bytemuck::bytes_of(&corner.to_array()));
            }
        }
        polygons.extend_from_slice(bytemuck::cast_slice(&values));
    }
    let header = Header {
        opaque_area: found.opaque_area,
        polygons: found.polygons.len() as u32,
        length: polygons.len() as u32,
    };
    let flags = mesh
        .clusters()
        .iter()
        .map(|cluster| cluster_flags(cluster, materials));
    let mut bytes = bytemuck::bytes_of(&header).to_vec();
    bytes.extend(polygons);
    bytes.extend(flags);
    bytes
}

/// Takes the occluders from a mesh; `None` if it has none, or they are those of other materials, or damaged.
pub(super) fn read(mesh: &Mesh, materials: &[Material]) -> Option<MeshPolygons> {
    let mut rest: &[u8] = mesh.occluder_bytes();
    let header: Header = bytemuck::pod_read_unaligned(take(&mut rest, size_of::<Header>())?);
    let mut of_polygons = take(&mut rest, header.length as usize)?;
    let clusters = mesh.clusters();
    let are_same = |(cluster, &flags): (&Cluster, &u8)| flags == cluster_flags(cluster, materials);
    if rest.len() != clusters.len() || !clusters.iter().zip(rest).all(are_same) {
        return None;
    }
    let mut polygons = Vec::new();
    for _ in 0..header.polygons {
        polygons.push(read_polygon(&mut of_polygons, mesh)?);
    }
    let is_sound = of_polygons.is_empty() && header.opaque_area.is_finite();
    is_sound.then_some(MeshPolygons {
        polygons,
        opaque_area: header.opaque_area,
    })
}

fn read_polygon(rest: &mut &[u8], mesh: &Mesh) -> Option<(Polygon, Vec<DVec3>)> {
    let head = Head::of(word(rest)?);
    let triangles = word(rest)?;
    let mut corners = Vec::new();
    for _ in 0..head.corners {
        corners.push(match word(rest)? {
            NOT_A_VERTEX => DVec3::new(value(rest)?, value(rest)?, value(rest)?),
            vertex => position(*mesh.positions().get(vertex as usize)?),
        });
    }
    let bounds = box_around(&corners);
    let are_sound = corners.iter().all(|corner| corner.is_finite()) && bounds.is_in_range();
    if corners.len() < 3 || !are_sound {
        return None;
    }
    let mut polygon = Polygon {
        first_corner: 0,
        corners: corners.len() as u32,
        // Those of `each_value` follow.
        normal: DVec3::ZERO,
        distance: 0.0,
        slack: 0.0,
        inset: 0.0,
        area: 0.0,
        added: 0.0,
        triangles,
        centre: corners.iter().sum::<DVec3>() / corners.len() as f64,
        bounds,
        double_sided: head.double_sided,
    };
    let (mut number, mut are_sound) = (0, true);
    each_value(&mut polygon, &corners, |held, expected| {
        *held = if head.stored >> number & 1 == 0 {
            expected
        } else {
            value(rest).unwrap_or(f64::NAN)
        };
        are_sound &= held.is_finite();
        number += 1;
    });
    let is_plane = polygon.normal.is_normalized() && polygon.slack >= 0.0 && polygon.inset >= 0.0;
    (are_sound && is_plane).then_some((polygon, corners))
}

/// Visits the values of a polygon that mostly follow from its corners and the values before, with what follows.
fn each_value(polygon: &mut Polygon, corners: &[DVec3], mut visit: impl FnMut(&mut f64, f64)) {
    let normal = unit_normal(twice_area(corners.iter().copied())).unwrap_or_default();
    visit(&mut polygon.normal.x, normal.x);
    visit(&mut polygon.normal.y, normal.y);
    visit(&mut polygon.normal.z, normal.z);
    let distances = || corners.iter().map(|&corner| polygon.normal.dot(corner));
    let least = distances().fold(f64::INFINITY, f64::min);
    let greatest = distances().fold(f64::NEG_INFINITY, f64::max);
    visit(&mut polygon.distance, 0.5 * (least + greatest));
    let coordinates = corners.iter().map(|corner| corner.abs().max_element());
    let rounding = EXACT * coordinates.fold(0.0, f64::max);
    let slack = (greatest - polygon.distance).max(polygon.distance - least) + rounding;
    visit(&mut polygon.slack, slack);
    visit(&mut polygon.inset, 0.0);
    visit(&mut polygon.area, area(corners));
    visit(&mut polygon.added, polygon.area);
}

/// Returns the position of a vertex. Zeros are positive, as those of corners: equal positions have the same bits.
fn position(vertex: [f32; 3]) -> DVec3 {
    DVec3::from(vertex.map(f64::from)) + DVec3::ZERO
}

/// Takes a word off bytes; `None` if there are fewer.
fn word(rest: &mut &[u8]) -> Option<u32> {
    take(rest, 4).map(bytemuck::pod_read_unaligned)
}

fn value(rest: &mut &[u8]) -> Option<f64> {
    take(rest, 8).map(bytemuck::pod_read_unaligned)
}

fn take<'a>(rest: &mut &'a [u8], count: usize) -> Option<&'a [u8]> {
    let (taken, after) = rest.split_at_checked(count)?;
    *rest = after;
    Some(taken)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::geom::Transform;
    use crate::geometry::{Alpha, Geometry, GeometryBuilder};
    use crate::ids::MaterialId;
    use crate::mesh::{Attributes, Indices, Part, Vertices};
    use crate::occluders::OccluderSet;

    /// An L of three squares, of the second material, beside a slope, of the first.
    fn corner() -> Mesh {
        let place = |i: u32| {
            let [x, y] = [i % 4, i / 4].map(|value| value as f32);
            [x, y, 0.3 * (x - 2.0).max(0.0)]
        };
        let positions: Vec<[f32; 3]> = (0..16).map(place).collect();
        let quad = |i: u32| [i, i + 1, i + 5, i, i + 5, i + 4];
        let flat: Vec<u32> = [0, 1, 4].into_iter().flat_map(quad).collect();
        let part = |corners, material| Part {
            positions: Vertices::Packed(&positions),
            corners: Indices::U32(corners),
            sides: None,
            material: MaterialId(material),
            attributes: Attributes::default(),
        };
        Mesh::new(&[part(&flat, 1), part(&quad(2), 0)]).expect("a valid mesh")
    }

    fn room(mesh: &Mesh, materials: &[Material]) -> Geometry {
        let mut room = GeometryBuilder::new(materials);
        let mesh = room.mesh(mesh.clone());
        room.item("corner", mesh, Transform::IDENTITY);
        room.build().expect("a valid room")
    }

    fn set(mesh: &Mesh, materials: &[Material]) -> String {
        format!("{:?}", OccluderSet::build(&room(mesh, materials)))
    }

    #[test]
    fn occluders_kept_with_a_mesh_are_those_found_in_it() {
        let opaque = [Material::opaque([0.5; 3]); 2];
        let plain = corner();
        let kept = plain.with_occluders(&opaque);
        assert!(read(&plain, &opaque).is_none());
        assert_eq!(read(&kept, &opaque).expect("as written").polygons.len(), 3);
        assert_eq!(set(&kept, &opaque), set(&plain, &opaque));
        let again = Mesh::from_bytes(Bytes::from_owner(kept.to_bytes())).expect("sound bytes");
        assert_eq!(set(&again, &opaque), set(&plain, &opaque));
        assert_eq!(again.with_occluders(&opaque).to_bytes(), kept.to_bytes());
    }

    #[test]
    fn once_a_wall_is_made_glass_its_kept_occluders_hide_nothing() {
        let opaque = [Material::opaque([0.5; 3]); 2];
        let plain = corner();
        let kept = plain.with_occluders(&opaque);
        let glass = Material {
            alpha: Alpha::Blend,
            ..opaque[1]
        };
        let changed = [opaque[0], glass];
        assert_ne!(set(&kept, &changed), set(&kept, &opaque));
        assert_eq!(set(&kept, &changed), set(&plain, &changed));
        let both = Material {
            double_sided: true,
            ..opaque[1]
        };
        let changed = [opaque[0], both];
        assert_eq!(set(&kept, &changed), set(&plain, &changed));
    }

    #[test]
    fn damaged_occluders_are_found_again() {
        let opaque = [Material::opaque([0.5; 3]); 2];
        let plain = corner();
        let sound = plain.with_occluders(&opaque).occluder_bytes().to_vec();
        let mut damaged = plain.clone();
        for length in 0..sound.len() {
            damaged.set_occluder_bytes(Bytes::from(sound[..length].to_vec()));
            assert!(read(&damaged, &opaque).is_none(), "{length} bytes");
        }
        assert_eq!(set(&damaged, &opaque), set(&plain, &opaque));
        // An infinite value, or one that is not a number, a vertex that is not there, or other flags.
        let is_refused = |&place: &usize| {
            let mut bytes = sound.clone();
            let end = sound.len().min(place + 4);
            bytes[place..end].fill(0xFF);
            damaged.set_occluder_bytes(Bytes::from(bytes));
            let found = read(&damaged, &opaque);
            // Numbers of triangles, and the lower halves of values, may be any.
            assert!(
                found.as_ref().is_none_or(|found| found.polygons.len() == 3),
                "{place}"
            );
            found.is_none()
        };
        let refused = (0..sound.len()).step_by(4).filter(is_refused).count();
        assert!(refused > sound.len() / 8, "{refused} of {} bytes", sound.len());
    }
}
