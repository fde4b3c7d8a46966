//! Occluder meshes, built of Bevy's.
//!
//! Idea: a mesh is built when an occluder first uses it, large ones on the task pool. Until then, and if it has no triangles
//! to read, its entities are culled by their boxes and hide nothing.

use bevy_asset::{AssetId, Assets};
use bevy_mesh::{Indices, Mesh, PrimitiveTopology, VertexAttributeValues};
use bevy_platform::collections::HashMap;
use bevy_tasks::{AsyncComputeTaskPool, Task, block_on, poll_once};
use enfilade::MaterialId;
use std::sync::Arc;

use crate::Occluder;

/// Triangles from which a mesh is built on the task pool: a smaller one takes less than 0.1 ms.
const LARGE: usize = 1000;

/// BuiltMesh meshes, by asset and by which sides hide.
#[derive(Default)]
pub(crate) struct OccluderMeshes {
    numbers: HashMap<(AssetId<Mesh>, Occluder), u64>,
    /// Those that are being built, by their numbers.
    pending: Vec<(u64, Task<Option<Arc<enfilade::Mesh>>>)>,
    next: u64,
}

/// A mesh that has been built, or cannot be.
pub(crate) type BuiltMesh = (u64, Option<Arc<enfilade::Mesh>>);

impl OccluderMeshes {
    /// Returns the number of a mesh, and begins to build it if it is new.
    pub(crate) fn number(
        &mut self,
        key: (AssetId<Mesh>, Occluder),
        assets: &Assets<Mesh>,
        built: &mut Vec<BuiltMesh>,
    ) -> u64 {
        if let Some(&number) = self.numbers.get(&key) {
            return number;
        }
        let number = self.next;
        self.next += 1;
        self.numbers.insert(key, number);
        self.build(number, key, assets, built);
        number
    }

    /// Rebuilds the meshes of an asset that has changed.
    pub(crate) fn changed(&mut self, id: AssetId<Mesh>, assets: &Assets<Mesh>, built: &mut Vec<BuiltMesh>) {
        for sides in [Occluder::OneSided, Occluder::TwoSided] {
            if let Some(&number) = self.numbers.get(&(id, sides)) {
                self.build(number, (id, sides), assets, built);
            }
        }
    }

    /// Drops the meshes of an asset that is gone.
    pub(crate) fn removed(&mut self, id: AssetId<Mesh>, built: &mut Vec<BuiltMesh>) {
        for sides in [Occluder::OneSided, Occluder::TwoSided] {
            if let Some(&number) = self.numbers.get(&(id, sides)) {
                self.pending.retain(|(pending, _)| *pending != number);
                built.push((number, None));
            }
        }
    }

    /// Collects the meshes that the task pool has built.
    pub(crate) fn poll(&mut self, built: &mut Vec<BuiltMesh>) {
        self.pending
            .retain_mut(|(number, task)| match block_on(poll_once(task)) {
                Some(mesh) => {
                    built.push((*number, mesh));
                    false
                }
                None => true,
            });
    }

    /// Returns whether meshes are being built.
    pub(crate) fn is_busy(&self) -> bool {
        !self.pending.is_empty()
    }

    fn build(
        &mut self,
        number: u64,
        (id, sides): (AssetId<Mesh>, Occluder),
        assets: &Assets<Mesh>,
        built: &mut Vec<BuiltMesh>,
    ) {
        self.pending.retain(|(pending, _)| *pending != number);
        let material = material(sides);
        match assets.get(id).and_then(triangles) {
            None => built.push((number, None)),
            Some(triangles) if triangles.1.len() < 3 * LARGE => {
                built.push((number, build(&triangles, material)));
            }
            Some(triangles) => {
                built.push((number, None));
                let task = AsyncComputeTaskPool::get().spawn(async move { build(&triangles, material) });
                self.pending.push((number, task));
            }
        }
    }
}

/// Materials of all sectors: that of front faces, and that of both sides.
pub(crate) fn materials() -> [enfilade::Material; 2] {
    let one_sided = enfilade::Material::opaque([0.5; 3]);
    let two_sided = enfilade::Material {
        double_sided: true,
        ..one_sided
    };
    [one_sided, two_sided]
}

fn material(sides: Occluder) -> MaterialId {
    match sides {
        Occluder::OneSided => MaterialId(0),
        Occluder::TwoSided => MaterialId(1),
    }
}

fn build(
    (positions, indices): &(Vec<[f32; 3]>, Vec<u32>),
    material: MaterialId,
) -> Option<Arc<enfilade::Mesh>> {
    enfilade::Mesh::triangles(positions, indices, material)
        .ok()
        .map(Arc::new)
}

/// Returns the positions and triangles of a mesh; `None` if it has none, or they are in the render world alone.
///
/// Triangles with a corner that is not finite, or that does not exist, are left out: no renderer draws them.
pub(crate) fn triangles(mesh: &Mesh) -> Option<(Vec<[f32; 3]>, Vec<u32>)> {
    let positions = match mesh.try_attribute(Mesh::ATTRIBUTE_POSITION).ok()? {
        VertexAttributeValues::Float32x3(positions) => positions,
        _ => return None,
    };
    let corners: Vec<u32> = match mesh.try_indices() {
        Ok(Indices::U16(indices)) => indices.iter().map(|&index| index.into()).collect(),
        Ok(Indices::U32(indices)) => indices.clone(),
        Err(_) => (0..positions.len() as u32).collect(),
    };
    let mut triangles = Vec::new();
    let mut add = |triangle: [u32; 3]| {
        let is_sound = |&index: &u32| {
            let position = positions.get(index as usize);
            position.is_some_and(|position| position.iter().all(|part| part.is_finite()))
        };
        if triangle.iter().all(is_sound) {
            triangles.extend(triangle);
        }
    };
    match mesh.primitive_topology() {
        PrimitiveTopology::TriangleList => {
            corners
                .as_chunks::<3>()
                .0
                .iter()
                .for_each(|&triangle| add(triangle));
        }
        PrimitiveTopology::TriangleStrip => {
            for (number, triangle) in corners.windows(3).enumerate() {
                let [a, b, c] = [triangle[0], triangle[1], triangle[2]];
                add(if number % 2 == 0 { [a, b, c] } else { [b, a, c] });
            }
        }
        _ => return None,
    }
    if triangles.is_empty() {
        return None;
    }
    // A vertex that no triangle uses may be anything.
    let mut numbers = vec![u32::MAX; positions.len()];
    let mut used = Vec::new();
    for index in &mut triangles {
        let number = &mut numbers[*index as usize];
        if *number == u32::MAX {
            *number = used.len() as u32;
            used.push(positions[*index as usize]);
        }
        *index = *number;
    }
    Some((used, triangles))
}

#[cfg(test)]
mod tests {
    use super::*;
    use bevy_asset::RenderAssetUsages;

    fn a_mesh(topology: PrimitiveTopology, positions: Vec<[f32; 3]>, indices: Option<Vec<u32>>) -> Mesh {
        let mut mesh = Mesh::new(topology, RenderAssetUsages::default());
        mesh.insert_attribute(Mesh::ATTRIBUTE_POSITION, positions);
        if let Some(indices) = indices {
            mesh.insert_indices(Indices::U32(indices));
        }
        mesh
    }

    const SQUARE: [[f32; 3]; 4] = [[0.0; 3], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [1.0, 1.0, 0.0]];

    #[test]
    fn strips_turn_every_other_triangle() {
        let mesh = a_mesh(PrimitiveTopology::TriangleStrip, SQUARE.to_vec(), None);
        let (_, indices) = triangles(&mesh).expect("two triangles");
        assert_eq!(indices, [0, 1, 2, 2, 1, 3]);
    }

    #[test]
    fn a_corner_that_is_not_a_number_loses_its_triangles_only() {
        let mut positions = SQUARE.to_vec();
        positions.extend([[f32::NAN; 3], [f32::NAN; 3]]);
        let indices = vec![0, 1, 2, 2, 1, 3, 0, 1, 4, 0, 1, 99];
        let mesh = a_mesh(PrimitiveTopology::TriangleList, positions, Some(indices));
        let (used, indices) = triangles(&mesh).expect("two triangles");
        assert_eq!((used.len(), indices.len()), (4, 6));
    }

    #[test]
    fn points_lines_and_meshes_without_positions_hide_nothing() {
        for topology in [PrimitiveTopology::PointList, PrimitiveTopology::LineStrip] {
            assert!(triangles(&a_mesh(topology, SQUARE.to_vec(), None)).is_none());
        }
        let bare = Mesh::new(PrimitiveTopology::TriangleList, RenderAssetUsages::default());
        assert!(triangles(&bare).is_none());
        assert!(triangles(&a_mesh(PrimitiveTopology::TriangleList, Vec::new(), None)).is_none());
        // The data is in the render world.
        let mut gone = a_mesh(
            PrimitiveTopology::TriangleList,
            SQUARE.to_vec(),
            Some(vec![0, 1, 2]),
        );
        gone.take_gpu_data().expect("it has data");
        assert!(triangles(&gone).is_none());
    }
}
