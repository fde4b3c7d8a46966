//! Draw data from visible sets: index ranges of an item's visible clusters, and instances by mesh.

use crate::geometry::Geometry;
use crate::ids::{MaterialId, MeshId, PassageId};
use crate::mesh::Mesh;
use crate::view::visible::{VisibleItem, VisibleSet};
use std::ops::Range;

/// A range of a mesh's index buffer to draw with one material, from [`VisibleSet::draw_runs`].
#[doc(alias = "draw call")]
#[doc(alias = "multi-draw indirect")]
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct DrawRun {
    /// Material of all triangles.
    pub material: MaterialId,
    /// Range of [`Mesh::triangle_indices`].
    pub indices: Range<u32>,
}

impl VisibleSet {
    /// Finds the index ranges of an item's visible clusters. Replaces the contents of `runs`, sorted by material, then by
    /// index; clusters of one material that follow each other in the index buffer are one run. Does not allocate if
    /// `runs` has enough capacity.
    ///
    /// ```
    /// # use enfilade::*;
    /// # let mut room = GeometryBuilder::new([Material::opaque([0.8, 0.6, 0.4])]);
    /// # let cube = room.mesh(Mesh::cuboid([-1.0; 3], [1.0; 3], MaterialId(0))?);
    /// # room.item("crate", cube, Transform::translation([0.0, 0.0, -4.0]));
    /// # let scene = Scene::single(room.build()?, Method::HierarchicalZ)?;
    /// # let (mut viewer, view) = (Viewer::new(), View::new([0.0; 3], [0.0, 0.0, -1.0], [64, 64])?);
    /// # let mut draws = Vec::new();
    /// let mut runs = Vec::new();
    /// let set = viewer.look(&scene, &view);
    /// for item in set.items() {
    ///     let geometry = scene.geometry(set.passage(item.passage).sector).expect("no custom sector");
    ///     set.draw_runs(item, geometry.mesh_of(item.item.index), &mut runs);
    ///     draws.extend(runs.iter().map(|run| (item.item.index, run.material, run.indices.clone())));
    /// }
    /// assert_eq!(draws, [(ItemIndex(0), MaterialId(0), 0..36)]);
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    ///
    /// # Panics
    /// If `mesh` has fewer clusters than the mesh of the item.
    #[doc(alias = "draw call")]
    pub fn draw_runs(&self, item: &VisibleItem, mesh: &Mesh, runs: &mut Vec<DrawRun>) {
        runs.clear();
        let run = |cluster: usize| DrawRun {
            material: mesh.clusters()[cluster].material,
            indices: mesh.cluster_indices(cluster),
        };
        match self.clusters(item) {
            [] => runs.extend((0..mesh.clusters().len()).map(run)),
            some => runs.extend(some.iter().map(|&cluster| run(cluster as usize))),
        }
        runs.sort_unstable_by_key(|run| (run.material, run.indices.start));
        runs.dedup_by(|next, run| {
            let follows = next.material == run.material && next.indices.start <= run.indices.end;
            if follows {
                run.indices.end = run.indices.end.max(next.indices.end);
            }
            follows
        });
    }

    /// Groups the visible items of a passage by mesh, for instanced draws: iterates over the meshes by id, each with its
    /// items by id. Replaces the contents of `sorted`; does not allocate if it has enough capacity.
    ///
    /// `geometry` is that of the passage's sector. Draws of a whole mesh draw its hidden clusters too: for large meshes,
    /// use [`VisibleSet::draw_runs`] instead. Items with [`VisibleItem::blends`] are listed like the others.
    ///
    /// ```
    /// # use enfilade::*;
    /// # let mut room = GeometryBuilder::new([Material::opaque([0.8, 0.6, 0.4])]);
    /// # let cube = room.mesh(Mesh::cuboid([-1.0; 3], [1.0; 3], MaterialId(0))?);
    /// # room.item("crate", cube, Transform::translation([-2.0, 0.0, -9.0]));
    /// # room.item("crate", cube, Transform::translation([2.0, 0.0, -9.0]));
    /// # let scene = Scene::single(room.build()?, Method::HierarchicalZ)?;
    /// # let geometry = scene.geometry(SectorId(0)).expect("no custom sector");
    /// # let (mut viewer, view) = (Viewer::new(), View::new([0.0; 3], [0.0, 0.0, -1.0], [64, 64])?);
    /// # let (mut transforms, mut draws) = (Vec::new(), Vec::new());
    /// let mut sorted = Vec::new();
    /// let set = viewer.look(&scene, &view);
    /// for (mesh, items) in set.instances(PassageId(0), geometry, &mut sorted) {
    ///     let first = transforms.len();
    ///     transforms.extend(items.iter().map(|item| geometry.item(item.item.index).sector_from_item));
    ///     draws.push((mesh, first..transforms.len()));
    /// }
    /// assert_eq!(draws, [(MeshId(0), 0..2)]);
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    ///
    /// # Panics
    /// If an item is not in `geometry`.
    #[doc(alias = "instancing")]
    #[doc(alias = "batching")]
    pub fn instances<'a>(
        &self,
        passage: PassageId,
        geometry: &'a Geometry,
        sorted: &'a mut Vec<VisibleItem>,
    ) -> impl Iterator<Item = (MeshId, &'a [VisibleItem])> + use<'a> {
        let start = self.items().partition_point(|item| item.passage < passage);
        let of_passage = self.items()[start..]
            .iter()
            .take_while(|item| item.passage == passage);
        sorted.clear();
        sorted.extend(of_passage);
        let mesh = |item: &VisibleItem| geometry.item(item.item.index).mesh;
        sorted.sort_unstable_by_key(|item| (mesh(item), item.item));
        let same = sorted.chunk_by(move |a, b| mesh(a) == mesh(b));
        same.map(move |items| (mesh(&items[0]), items))
    }
}
