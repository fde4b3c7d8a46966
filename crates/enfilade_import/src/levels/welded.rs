//! Welds vertices: the clusters of a mesh store separate positions, which simplification would pull apart.

use enfilade::{Attributes, MaterialId, Mesh, Vertices};
use std::collections::{BTreeMap, HashMap};

/// A mesh whose identical vertices are merged. Vertices with the same position but different attributes stay separate,
/// such as at a texture seam; `meshopt` detects by itself that they must move together.
#[derive(Default)]
pub(super) struct Welded {
    pub(super) positions: Vec<[f32; 3]>,
    normals: Vec<[f32; 3]>,
    texture: Vec<[f32; 2]>,
    colors: Vec<[f32; 4]>,
    /// Index lists of the triangles, by material.
    pub(super) parts: BTreeMap<MaterialId, Vec<u32>>,
    /// For each vertex, whether two materials share its position. Those are locked, otherwise cracks would open between
    /// the materials.
    pub(super) shared: Vec<bool>,
}

impl Welded {
    pub(super) fn new(mesh: &Mesh) -> Welded {
        let mut made = Welded::default();
        let mut known: HashMap<[u32; 12], u32> = HashMap::new();
        let welded: Vec<u32> = (0..mesh.positions().len())
            .map(|corner| {
                *known.entry(carried(mesh, corner)).or_insert_with(|| {
                    made.positions.push(mesh.positions()[corner]);
                    made.normals.extend(mesh.normals().get(corner));
                    made.texture.extend(mesh.texture().get(corner));
                    made.colors.extend(mesh.colors().get(corner));
                    made.positions.len() as u32 - 1
                })
            })
            .collect();
        let mut used: HashMap<[u32; 3], Option<MaterialId>> = HashMap::new();
        for cluster in mesh.clusters() {
            let part = made.parts.entry(cluster.material).or_default();
            for face in cluster.faces.clone() {
                for corners in triangles(mesh.face(face)) {
                    for corner in corners {
                        let users = used
                            .entry(bits(mesh.positions()[corner as usize]))
                            .or_insert(Some(cluster.material));
                        *users = users.filter(|&other| other == cluster.material);
                    }
                    part.extend(corners.map(|corner| welded[corner as usize]));
                }
            }
        }
        let by_two = |position: &[f32; 3]| used.get(&bits(*position)) == Some(&None);
        made.shared = made.positions.iter().map(by_two).collect();
        made
    }

    pub(super) fn attributes(&self) -> Attributes<'_> {
        Attributes {
            normals: Vertices::Packed(&self.normals),
            texture: Vertices::Packed(&self.texture),
            colors: Vertices::Packed(&self.colors),
        }
    }
}

/// Returns the key by which vertices are merged: the bits of position and attributes.
fn carried(mesh: &Mesh, corner: usize) -> [u32; 12] {
    let [x, y, z] = bits(mesh.positions()[corner]);
    let [nx, ny, nz] = mesh.normals().get(corner).map_or([0; 3], |&normal| bits(normal));
    let [u, v] = mesh.texture().get(corner).map_or([0; 2], |&place| bits(place));
    let [r, g, b, a] = mesh.colors().get(corner).map_or([0; 4], |&color| bits(color));
    [x, y, z, nx, ny, nz, u, v, r, g, b, a]
}

/// Returns the bits of numbers, with −0 as 0.
fn bits<const N: usize>(numbers: [f32; N]) -> [u32; N] {
    numbers.map(|value| (value + 0.0).to_bits())
}

/// Triangulates a convex face as a fan.
pub(super) fn triangles(corners: &[u32]) -> impl Iterator<Item = [u32; 3]> {
    corners[1..].windows(2).map(|pair| [corners[0], pair[0], pair[1]])
}
