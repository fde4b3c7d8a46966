//! Files in a folder, and helpers for what was read.

use enfilade::{ItemIndex, Material};
use enfilade_import::{Import, ImportError, ReadOptions, read, read_bytes};
use std::path::Path;

/// Reads a valid text.
#[track_caller]
pub(crate) fn reads(text: &str) -> Import {
    read_bytes(text.as_bytes(), None, &ReadOptions::default()).unwrap_or_else(|error| panic!("{error}"))
}

/// The text of the error that a text gives, or nothing where there is none.
pub(crate) fn refusal(bytes: &[u8]) -> Option<String> {
    read_bytes(bytes, None, &ReadOptions::default())
        .err()
        .map(|error| error.to_string())
}

/// Reads the first of several files in one folder.
pub(crate) fn read_among(files: &[(&str, &[u8])], options: &ReadOptions) -> Result<Import, ImportError> {
    let folder = tempfile::tempdir().expect("a folder");
    for (name, bytes) in files {
        let path = folder.path().join(name);
        std::fs::create_dir_all(path.parent().expect("a folder")).expect("it is ours");
        std::fs::write(path, bytes).expect("it is ours");
    }
    read(&folder.path().join(Path::new(files[0].0)), options)
}

/// Reads the first of several files; it must be valid.
#[track_caller]
pub(crate) fn reads_among(files: &[(&str, &[u8])]) -> Import {
    read_among(files, &ReadOptions::default()).unwrap_or_else(|error| panic!("{error}"))
}

/// The names of all items.
pub(crate) fn names(import: &Import) -> Vec<&str> {
    let geometry = &import.rooms[0].geometry;
    (0..geometry.items().len() as u32)
        .map(|item| geometry.name(ItemIndex(item)))
        .collect()
}

/// The texts of all warnings.
pub(crate) fn warnings(import: &Import) -> Vec<String> {
    import.warnings.iter().map(ToString::to_string).collect()
}

/// A corner of a triangle, and all that it carries.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Corner {
    pub(crate) position: [f32; 3],
    pub(crate) normal: Option<[f32; 3]>,
    pub(crate) texture: Option<[f32; 2]>,
    pub(crate) color: Option<[f32; 4]>,
}

/// The triangles of an item with what they are made of, the corner of the least position first, then round; in no order.
pub(crate) fn triangles(import: &Import, item: u32) -> Vec<([Corner; 3], Material)> {
    let geometry = &import.rooms[0].geometry;
    let mesh = geometry.mesh_of(ItemIndex(item));
    (0..mesh.face_count())
        .map(|face| {
            let cluster = &mesh.clusters()[mesh.cluster_of(face)];
            let mut corners: Vec<Corner> = mesh
                .face(face)
                .iter()
                .map(|&index| Corner {
                    position: mesh.positions()[index as usize],
                    normal: mesh.normals().get(index as usize).copied(),
                    texture: mesh.texture().get(index as usize).copied(),
                    color: mesh.colors().get(index as usize).copied(),
                })
                .collect();
            let least = (0..3).min_by(|&a, &b| {
                corners[a]
                    .position
                    .partial_cmp(&corners[b].position)
                    .expect("finite")
            });
            corners.rotate_left(least.expect("three corners"));
            (
                corners.try_into().expect("three corners"),
                geometry.materials()[cluster.material.0 as usize],
            )
        })
        .collect()
}

/// Every triangle of an item by its corners, as `0,0,0 1,0,0 0,1,0`, in order.
pub(crate) fn places(import: &Import, item: u32) -> Vec<String> {
    let spoken = |corner: &Corner| {
        // Never -0.
        let [x, y, z] = corner.position.map(|value| value + 0.0);
        format!("{x},{y},{z}")
    };
    let mut lines: Vec<String> = triangles(import, item)
        .iter()
        .map(|(corners, _)| corners.iter().map(spoken).collect::<Vec<_>>().join(" "))
        .collect();
    lines.sort();
    lines
}

/// Returns the material of the first item, which has only one.
#[track_caller]
pub(crate) fn material(import: &Import) -> Material {
    let triangles = triangles(import, 0);
    let (_, first) = triangles[0];
    assert!(triangles.iter().all(|(_, material)| *material == first));
    first
}

/// All corners of the first item at a position, which must carry the same.
#[track_caller]
pub(crate) fn corner(import: &Import, position: [f32; 3]) -> Corner {
    let all = triangles(import, 0);
    let mut found = all
        .iter()
        .flat_map(|(corners, _)| corners)
        .filter(|c| c.position == position);
    let first = *found.next().expect("a corner there");
    assert!(found.all(|other| *other == first), "one corner at {position:?}");
    first
}

/// Returns random numbers below those asked for, reproducible by seed.
pub(crate) fn numbers(seed: u64) -> impl FnMut(usize) -> usize {
    let mut random = fastrand::Rng::with_seed(seed);
    move |below| random.usize(..below)
}
