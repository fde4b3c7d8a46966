//! Triangle lists for renderers: one index buffer per mesh, drawn in ranges of clusters.

use super::Mesh;
use std::ops::Range;

impl Mesh {
    /// Iterates over the indices of all triangles, three each, into [`Mesh::positions`]: the index buffer of the mesh, to
    /// be uploaded once. Clusters come in order, as [`Mesh::cluster_indices`] says; faces of more than three corners are
    /// triangulated as fans from their first corner.
    #[doc(alias = "index buffer")]
    pub fn triangle_indices(&self) -> impl Iterator<Item = u32> {
        (0..self.face_count()).flat_map(|face| {
            let corners = self.face(face);
            (2..corners.len()).flat_map(move |last| [corners[0], corners[last - 1], corners[last]])
        })
    }

    /// Returns the range of a cluster's triangles in [`Mesh::triangle_indices`].
    ///
    /// # Panics
    /// If there is no such cluster, or the mesh has more than 2³²/3 triangles before it.
    pub fn cluster_indices(&self, cluster: usize) -> Range<u32> {
        let faces = &self.clusters[cluster].faces;
        // A face of n corners is n - 2 triangles.
        let indices_before = |face: u32| match self.starts.get(face as usize) {
            Some(&corners) => 3 * (corners - 2 * face),
            None => 3 * face,
        };
        indices_before(faces.start)..indices_before(faces.end)
    }
}

#[cfg(test)]
mod tests {
    use crate::ids::MaterialId;
    use crate::mesh::{Attributes, Indices, Mesh, Part, Vertices};

    #[test]
    fn each_cluster_is_a_range_of_the_triangles_of_its_faces() {
        // Rows of quads and triangles, in turn.
        let (mut positions, mut corners, mut sides) = (Vec::new(), Vec::new(), Vec::new());
        for cell in 0..900_u16 {
            let [x, y] = [cell % 30, cell / 30].map(f32::from);
            let first = positions.len() as u32;
            positions.extend([
                [x, y, 0.0],
                [x + 1.0, y, 0.0],
                [x + 1.0, y + 1.0, 0.0],
                [x, y + 1.0, 0.0],
            ]);
            let count = 3 + u32::from(cell / 30 % 2);
            corners.extend(first..first + count);
            sides.push(count);
        }
        let quads = Part {
            positions: Vertices::Packed(&positions),
            corners: Indices::U32(&corners),
            sides: Some(&sides),
            material: MaterialId(0),
            attributes: Attributes::default(),
        };
        check(&Mesh::new(&[quads]).expect("flat and convex"));
        let whole = &corners[..corners.len() / 3 * 3];
        check(&Mesh::triangles(&positions, whole, MaterialId(0)).expect("triangles"));
    }

    fn check(mesh: &Mesh) {
        assert!(mesh.clusters().len() > 5);
        let all: Vec<u32> = mesh.triangle_indices().collect();
        assert_eq!(all.len() as u64, 3 * mesh.triangle_count());
        let mut end = 0;
        for (number, cluster) in mesh.clusters().iter().enumerate() {
            let range = mesh.cluster_indices(number);
            assert_eq!(
                (range.start, range.len() as u64),
                (end, 3 * mesh.triangles_in(number))
            );
            end = range.end;
            let mut rest = all[range.start as usize..range.end as usize].chunks(3);
            for face in cluster.faces.clone().map(|face| mesh.face(face)) {
                for pair in face[1..].windows(2) {
                    assert_eq!(rest.next(), Some(&[face[0], pair[0], pair[1]][..]));
                }
            }
            assert_eq!(rest.next(), None);
        }
        assert_eq!(end as usize, all.len());
    }
}
