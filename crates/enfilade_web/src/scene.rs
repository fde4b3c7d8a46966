//! The scene: one sector, whose items have the keys of the page.

use crate::{check_length, error};
use enfilade::{
    Edit, EditError, Geometry, GeometryBuilder, Indices, ItemId, ItemOptions, Material, MaterialId, Mesh,
    MeshError, Method, Part, SceneError, SectorId, Transform, Vertices,
};
use std::collections::BTreeSet;
use std::sync::Arc;
use wasm_bindgen::prelude::*;

/// The only sector of a scene.
const SECTOR: SectorId = SectorId(0);

/// Bits of a material's kind, as `Side` and `Scene.addMesh` in `web/src/index.ts` have them.
const DOUBLE_SIDED: u32 = 1;
const SEE_THROUGH: u32 = 2;
const BACK_SIDE: u32 = 4;

/// Bits of an item's flags.
const OCCLUDER: u32 = 1;
const ALWAYS_VISIBLE: u32 = 2;

/// A scene of objects without rooms, culled by `masked`.
///
/// An object that the scene refuses (its position is not finite, say) counts as visible in every view.
#[wasm_bindgen]
pub struct Scene {
    scene: enfilade::Scene,
    meshes: Vec<Option<Arc<Mesh>>>,
    free_meshes: Vec<u32>,
    /// By key.
    objects: Vec<Option<Object>>,
    /// Keys of objects without an item.
    always_visible: BTreeSet<u32>,
}

struct Object {
    /// `None` if the scene refused it, because of its transform.
    item: Option<ItemId>,
    mesh: Arc<Mesh>,
    options: ItemOptions,
}

#[wasm_bindgen]
impl Scene {
    /// Creates an empty scene.
    ///
    /// # Errors
    /// None that a page can cause.
    #[wasm_bindgen(constructor)]
    pub fn new() -> Result<Scene, JsValue> {
        let material = |kind: u32| Material {
            double_sided: kind & DOUBLE_SIDED != 0,
            // Only whether a face occludes counts here, and a blended one does not.
            alpha: if kind & SEE_THROUGH == 0 {
                enfilade::Alpha::Opaque
            } else {
                enfilade::Alpha::Blend
            },
            ..Material::opaque([1.0; 3])
        };
        let empty: Geometry = GeometryBuilder::new([0, 1, 2, 3].map(material))
            .build()
            .map_err(|why| error(why.code(), why))?;
        Ok(Scene {
            scene: enfilade::Scene::single(empty, Method::Masked).map_err(scene_error)?,
            meshes: Vec::new(),
            free_meshes: Vec::new(),
            objects: Vec::new(),
            always_visible: BTreeSet::new(),
        })
    }

    /// Adds a triangle mesh and returns its number. `positions` has three numbers per vertex, `indices` three per triangle,
    /// or none if the vertices are those of the triangles in order. `groups` has three numbers for each part: first
    /// index, number of indices, and the kind of its material; faces that no group contains do not exist.
    ///
    /// # Errors
    /// Returns the code of a [`MeshError`], or `web/length`.
    #[wasm_bindgen(js_name = addMesh)]
    pub fn add_mesh(&mut self, positions: &[f32], indices: Vec<u32>, groups: &[u32]) -> Result<u32, JsValue> {
        let (positions, rest) = positions.as_chunks::<3>();
        check_length("the end of positions", rest.len(), 0)?;
        let (groups, rest) = groups.as_chunks::<3>();
        check_length("the end of groups", rest.len(), 0)?;
        let mut indices = if indices.is_empty() {
            (0..positions.len() as u32).collect()
        } else {
            indices
        };
        let mut ranges = Vec::new();
        for &[start, count, kind] in groups {
            let end = (start as usize).saturating_add(count as usize).min(indices.len());
            let range = (start as usize).min(end)..end;
            if kind & BACK_SIDE != 0 {
                for triangle in indices[range.clone()].as_chunks_mut::<3>().0 {
                    triangle.swap(1, 2);
                }
            }
            ranges.push((range, kind));
        }
        let parts: Vec<Part> = ranges
            .into_iter()
            .map(|(range, kind)| Part {
                positions: Vertices::Packed(positions),
                corners: Indices::U32(&indices[range]),
                sides: None,
                material: MaterialId(kind & (DOUBLE_SIDED | SEE_THROUGH)),
                attributes: enfilade::Attributes::default(),
            })
            .collect();
        let mesh = Mesh::new(&parts).map_err(mesh_error)?;
        Ok(self.keep(mesh))
    }

    /// Adds a box, `bounds` its minimum and maximum, in place of a mesh that is unknown or changes: it hides nothing. A flat
    /// one grows a little. Returns its number.
    ///
    /// # Errors
    /// Returns the code of a [`MeshError`], or `web/length`.
    #[wasm_bindgen(js_name = addBox)]
    pub fn add_box(&mut self, bounds: &[f32]) -> Result<u32, JsValue> {
        check_length("the box", bounds.len(), 6)?;
        let [mut min, mut max] = [0, 3].map(|first| [bounds[first], bounds[first + 1], bounds[first + 2]]);
        let longest = (0..3).map(|axis| max[axis] - min[axis]).fold(0.0, f32::max);
        for (low, high) in min.iter_mut().zip(&mut max) {
            if low == high {
                let grown = 1e-4 * longest.max(low.abs()).max(f32::MIN_POSITIVE);
                *low -= grown;
                *high += grown;
            }
        }
        let mesh = Mesh::bounds_only(min, max).map_err(mesh_error)?;
        Ok(self.keep(mesh))
    }

    /// Forgets a mesh or box. Objects that have it keep it.
    #[wasm_bindgen(js_name = removeMesh)]
    pub fn remove_mesh(&mut self, mesh: u32) {
        if let Some(kept) = self.meshes.get_mut(mesh as usize)
            && kept.take().is_some()
        {
            self.free_meshes.push(mesh);
        }
    }

    /// Adds objects, or replaces those that have the same keys. All arrays have one element per object, `transforms` 16:
    /// the columns of a matrix.
    ///
    /// # Errors
    /// Returns `web/length`, `web/no-mesh`, `web/key`, or the code of a [`SceneError`]; then nothing was added.
    pub fn add(
        &mut self,
        keys: &[u32],
        meshes: &[u32],
        transforms: &[f32],
        flags: &[u32],
        layers: &[u32],
    ) -> Result<(), JsValue> {
        let transforms = matrices(keys, transforms)?;
        for (what, array) in [("meshes", meshes), ("flags", flags), ("layers", layers)] {
            check_length(what, array.len(), keys.len())?;
        }
        self.check_keys(keys)?;
        let meshes: Vec<Arc<Mesh>> = (meshes.iter())
            .map(|&mesh| self.mesh(mesh))
            .collect::<Result<_, _>>()?;
        self.remove(keys)?;
        let mut edit = self.scene.edit();
        let mut added = Vec::with_capacity(keys.len());
        for (number, (&key, mesh)) in keys.iter().zip(meshes).enumerate() {
            let mut object = Object {
                item: None,
                mesh,
                options: options(flags[number], layers[number]),
            };
            object.item = place(&mut edit, key, &object, &transforms[number]).ok();
            added.push((key, object));
        }
        edit.finish().map_err(scene_error)?;
        for (key, object) in added {
            self.mark(key, object.item.is_none());
            self.objects[key as usize] = Some(object);
        }
        Ok(())
    }

    /// Moves objects. `transforms` has 16 numbers per key: the columns of a matrix.
    ///
    /// # Errors
    /// Returns `web/length`, or the code of a [`SceneError`]; then nothing was moved.
    #[wasm_bindgen(js_name = setTransforms)]
    pub fn set_transforms(&mut self, keys: &[u32], transforms: &[f32]) -> Result<(), JsValue> {
        let transforms = matrices(keys, transforms)?;
        let mut moves = Vec::with_capacity(keys.len());
        let mut absent = Vec::new();
        for (&key, columns) in keys.iter().zip(transforms) {
            match self.objects.get(key as usize) {
                Some(Some(Object { item: Some(item), .. })) => moves.push((key, *item, transform(columns))),
                Some(Some(object)) => absent.push((key, object, columns)),
                _ => {}
            }
        }
        let mut refused = Vec::new();
        let mut edit = self.scene.edit();
        edit.set_transforms(
            SECTOR,
            moves.iter().map(|&(_, item, transform)| (item, transform)),
            &mut refused,
        )
        .map_err(edit_error)?;
        // It must not hide anything at its old position.
        for (number, _) in &refused {
            edit.remove(SECTOR, moves[*number].1).map_err(edit_error)?;
        }
        let mut placed = Vec::new();
        for (key, object, columns) in absent {
            if let Ok(item) = place(&mut edit, key, object, columns) {
                placed.push((key, Some(item)));
            }
        }
        edit.finish().map_err(scene_error)?;
        placed.extend(refused.iter().map(|(number, _)| (moves[*number].0, None)));
        for (key, item) in placed {
            if let Some(object) = &mut self.objects[key as usize] {
                object.item = item;
            }
            self.mark(key, item.is_none());
        }
        Ok(())
    }

    /// Replaces the meshes of objects.
    ///
    /// # Errors
    /// Returns `web/length`, `web/no-mesh`, or the code of a [`SceneError`] or [`EditError`]; then nothing was changed.
    #[wasm_bindgen(js_name = setMeshes)]
    pub fn set_meshes(&mut self, keys: &[u32], meshes: &[u32]) -> Result<(), JsValue> {
        check_length("meshes", meshes.len(), keys.len())?;
        let meshes: Vec<Arc<Mesh>> = (meshes.iter())
            .map(|&mesh| self.mesh(mesh))
            .collect::<Result<_, _>>()?;
        let mut edit = self.scene.edit();
        let mut refused = Vec::new();
        for (&key, mesh) in keys.iter().zip(&meshes) {
            if let Some(Some(Object { item: Some(item), .. })) = self.objects.get(key as usize)
                && edit.set_mesh(SECTOR, *item, Arc::clone(mesh)).is_err()
            {
                edit.remove(SECTOR, *item).map_err(edit_error)?;
                refused.push(key);
            }
        }
        edit.finish().map_err(scene_error)?;
        for (&key, mesh) in keys.iter().zip(meshes) {
            if let Some(Some(object)) = self.objects.get_mut(key as usize) {
                object.mesh = mesh;
                if refused.contains(&key) {
                    object.item = None;
                    self.always_visible.insert(key);
                }
            }
        }
        Ok(())
    }

    /// Replaces the flags and layers of objects.
    ///
    /// # Errors
    /// Returns `web/length`, or the code of a [`SceneError`]; then nothing was changed.
    #[wasm_bindgen(js_name = setOptions)]
    pub fn set_options(&mut self, keys: &[u32], flags: &[u32], layers: &[u32]) -> Result<(), JsValue> {
        check_length("flags", flags.len(), keys.len())?;
        check_length("layers", layers.len(), keys.len())?;
        let mut edit = self.scene.edit();
        for (number, &key) in keys.iter().enumerate() {
            if let Some(Some(Object { item: Some(item), .. })) = self.objects.get(key as usize) {
                edit.set_options(SECTOR, *item, options(flags[number], layers[number]))
                    .map_err(edit_error)?;
            }
        }
        edit.finish().map_err(scene_error)?;
        for (number, &key) in keys.iter().enumerate() {
            if let Some(Some(object)) = self.objects.get_mut(key as usize) {
                object.options = options(flags[number], layers[number]);
            }
        }
        Ok(())
    }

    /// Removes objects; keys without an object are ignored.
    ///
    /// # Errors
    /// Returns the code of a [`SceneError`]; then nothing was removed.
    pub fn remove(&mut self, keys: &[u32]) -> Result<(), JsValue> {
        let mut edit = self.scene.edit();
        for &key in keys {
            let object = self.objects.get_mut(key as usize).and_then(Option::take);
            if let Some(item) = object.and_then(|object| object.item) {
                edit.remove(SECTOR, item).map_err(edit_error)?;
            }
        }
        edit.finish().map_err(scene_error)?;
        for key in keys {
            self.always_visible.remove(key);
        }
        Ok(())
    }

    /// Number of objects.
    #[wasm_bindgen(getter, js_name = itemCount)]
    pub fn item_count(&self) -> u32 {
        self.scene.item_count() as u32
    }

    /// Number of triangles of all objects.
    #[wasm_bindgen(getter, js_name = triangleCount)]
    pub fn triangle_count(&self) -> f64 {
        self.scene.triangle_count() as f64
    }

    /// Approximate size in memory, in bytes.
    #[wasm_bindgen(getter)]
    pub fn bytes(&self) -> f64 {
        self.scene.bytes() as f64
    }
}

impl Scene {
    pub(crate) fn scene(&self) -> &enfilade::Scene {
        &self.scene
    }

    pub(crate) fn always_visible(&self) -> &BTreeSet<u32> {
        &self.always_visible
    }

    fn keep(&mut self, mesh: Mesh) -> u32 {
        let mesh = Some(Arc::new(mesh));
        if let Some(number) = self.free_meshes.pop() {
            self.meshes[number as usize] = mesh;
            return number;
        }
        self.meshes.push(mesh);
        self.meshes.len() as u32 - 1
    }

    fn mesh(&self, number: u32) -> Result<Arc<Mesh>, JsValue> {
        let mesh = self.meshes.get(number as usize).and_then(Option::as_ref);
        let none = || error("web/no-mesh", format_args!("there is no mesh {number}"));
        mesh.cloned().ok_or_else(none)
    }

    /// Makes room for keys.
    fn check_keys(&mut self, keys: &[u32]) -> Result<(), JsValue> {
        /// Each costs a bit per viewer and twelve bytes here.
        const LIMIT: u32 = 1 << 24;
        let Some(&largest) = keys.iter().max() else {
            return Ok(());
        };
        if largest >= LIMIT {
            return Err(error(
                "web/key",
                format_args!("key {largest} is not less than {LIMIT}; number your objects from 0"),
            ));
        }
        if self.objects.len() <= largest as usize {
            self.objects.resize_with(largest as usize + 1, || None);
        }
        Ok(())
    }

    fn mark(&mut self, key: u32, is_always_visible: bool) {
        if is_always_visible {
            self.always_visible.insert(key);
        } else {
            self.always_visible.remove(&key);
        }
    }
}

fn place(edit: &mut Edit, key: u32, object: &Object, columns: &[f32; 16]) -> Result<ItemId, EditError> {
    let item = edit.add(SECTOR, "", Arc::clone(&object.mesh), transform(columns))?;
    edit.set_key(SECTOR, item, u64::from(key))?;
    edit.set_options(SECTOR, item, object.options)?;
    Ok(item)
}

fn options(flags: u32, layers: u32) -> ItemOptions {
    ItemOptions {
        is_occluder: flags & OCCLUDER != 0,
        never_cull: flags & ALWAYS_VISIBLE != 0,
        layers,
        ..ItemOptions::default()
    }
}

fn matrices<'a>(keys: &[u32], transforms: &'a [f32]) -> Result<&'a [[f32; 16]], JsValue> {
    check_length("transforms", transforms.len(), 16 * keys.len())?;
    Ok(transforms.as_chunks::<16>().0)
}

fn transform(columns: &[f32; 16]) -> Transform {
    let column = |number: usize| [0, 1, 2].map(|row| columns[4 * number + row]);
    Transform::from_columns([0, 1, 2, 3].map(column))
}

fn mesh_error(why: MeshError) -> JsValue {
    error(why.code(), why)
}

fn edit_error(why: EditError) -> JsValue {
    error(why.code(), why)
}

pub(crate) fn scene_error(why: SceneError) -> JsValue {
    error(why.code(), why)
}
