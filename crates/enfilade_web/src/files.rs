//! Scenes from files, with their rooms, portals and mirrors.

use crate::scene::scene_error;
use crate::viewer::{Viewer, view};
use crate::{check_length, error};
use enfilade::{Alpha, Camera, ItemId, ItemIndex, Method, SectorId};
use enfilade_import::{ReadOptions, read_bytes};
use wasm_bindgen::prelude::*;

/// A scene read from a `.glb`, `.obj` or `.bsp` file. Its objects have the keys 0, 1, …, room after room.
#[wasm_bindgen]
pub struct SceneFile {
    scene: enfilade::Scene,
    /// By key.
    items: Vec<(SectorId, ItemId)>,
    /// The first mesh of each sector among those of all.
    first_mesh: Vec<u32>,
    /// The first material of each sector among those of all.
    first_material: Vec<u32>,
    cameras: Vec<enfilade::Camera>,
    warnings: Vec<String>,
}

#[wasm_bindgen]
impl SceneFile {
    /// Reads a file, in at most about `limit_bytes` of memory. `flat`: as one room, without portals.
    ///
    /// # Errors
    /// Returns an error that names the broken rule and its place in the file.
    #[wasm_bindgen(constructor)]
    pub fn new(bytes: &[u8], flat: bool, limit_bytes: f64) -> Result<SceneFile, JsValue> {
        let options = ReadOptions {
            flat,
            textures: false,
            limit_bytes: limit_bytes as u64,
            ..ReadOptions::default()
        };
        let import = read_bytes(bytes, None, &options).map_err(|why| error("file/unreadable", why))?;
        let mut scene = import
            .scene(Method::Masked, options.limit_bytes)
            .map_err(scene_error)?;
        let mut items = Vec::new();
        let [mut first_mesh, mut first_material] = [Vec::new(), Vec::new()];
        let [mut meshes, mut materials] = [0, 0];
        for sector in scene.sectors() {
            first_mesh.push(meshes);
            first_material.push(materials);
            if let Some(geometry) = scene.geometry(sector) {
                meshes += geometry.meshes().len() as u32;
                materials += geometry.materials().len() as u32;
                let indices = (0..geometry.items().len() as u32).map(ItemIndex);
                let held = indices.filter(|&index| geometry.holds(index));
                items.extend(held.map(|index| (sector, geometry.id_of(index))));
            }
        }
        let mut edit = scene.edit();
        for (key, &(sector, item)) in items.iter().enumerate() {
            edit.set_key(sector, item, key as u64)
                .map_err(|why| error(why.code(), why))?;
        }
        edit.finish().map_err(scene_error)?;
        Ok(SceneFile {
            scene,
            items,
            first_mesh,
            first_material,
            cameras: import.cameras,
            warnings: import.warnings.iter().map(ToString::to_string).collect(),
        })
    }

    /// Names of the sectors.
    #[wasm_bindgen(getter, js_name = sectorNames)]
    pub fn sector_names(&self) -> Vec<String> {
        let sectors = self.scene.sectors();
        sectors
            .map(|sector| self.scene.sector_name(sector).to_owned())
            .collect()
    }

    /// What was strange in the file.
    #[wasm_bindgen(getter)]
    pub fn warnings(&self) -> Vec<String> {
        self.warnings.clone()
    }

    /// Names of the objects, by key.
    #[wasm_bindgen(getter, js_name = itemNames)]
    pub fn item_names(&self) -> Vec<String> {
        let name = |geometry: &enfilade::Geometry, item: ItemId| geometry.name(item.index).to_owned();
        self.each_item(name)
    }

    /// Sector of each object.
    #[wasm_bindgen(getter, js_name = itemSectors)]
    pub fn item_sectors(&self) -> Vec<u32> {
        self.items.iter().map(|(sector, _)| sector.0).collect()
    }

    /// Mesh of each object.
    #[wasm_bindgen(getter, js_name = itemMeshes)]
    pub fn item_meshes(&self) -> Vec<u32> {
        let meshes = self.each_item(|geometry, item| geometry.item(item.index).mesh.0);
        let first = |sector: SectorId| self.first_mesh[sector.0 as usize];
        (self.items.iter().zip(meshes))
            .map(|(&(sector, _), mesh)| first(sector) + mesh)
            .collect()
    }

    /// Transform of each object into its sector: 16 numbers, the columns of a matrix.
    #[wasm_bindgen(getter, js_name = itemTransforms)]
    pub fn item_transforms(&self) -> Vec<f32> {
        let columns = self.each_item(|geometry, item| geometry.item(item.index).sector_from_item);
        let flat = |[x, y, z, w]: [[f32; 3]; 4]| [(x, 0.0), (y, 0.0), (z, 0.0), (w, 1.0)];
        (columns.into_iter().flat_map(flat))
            .flat_map(|([a, b, c], d)| [a, b, c, d])
            .collect()
    }

    /// Number of meshes.
    #[wasm_bindgen(getter, js_name = meshCount)]
    pub fn mesh_count(&self) -> u32 {
        self.geometries()
            .map(|geometry| geometry.meshes().len() as u32)
            .sum()
    }

    /// Positions of a mesh, three numbers per vertex.
    #[wasm_bindgen(js_name = meshPositions)]
    pub fn mesh_positions(&self, mesh: u32) -> Vec<f32> {
        self.mesh(mesh)
            .map_or_else(Vec::new, |(mesh, _)| mesh.positions().as_flattened().to_vec())
    }

    /// Triangles of a mesh, three vertices each.
    #[wasm_bindgen(js_name = meshIndices)]
    pub fn mesh_indices(&self, mesh: u32) -> Vec<u32> {
        self.mesh(mesh)
            .map_or_else(Vec::new, |(mesh, _)| mesh.triangle_indices().collect())
    }

    /// Parts of a mesh: first index, number of indices, material.
    #[wasm_bindgen(js_name = meshGroups)]
    pub fn mesh_groups(&self, mesh: u32) -> Vec<u32> {
        let Some((mesh, sector)) = self.mesh(mesh) else {
            return Vec::new();
        };
        let mut groups: Vec<[u32; 3]> = Vec::new();
        for (number, cluster) in mesh.clusters().iter().enumerate() {
            let indices = mesh.cluster_indices(number);
            let material = self.first_material[sector] + cluster.material.0;
            match groups.last_mut() {
                Some([start, count, last]) if *last == material && *start + *count == indices.start => {
                    *count = indices.end - *start;
                }
                _ => groups.push([indices.start, indices.end - indices.start, material]),
            }
        }
        groups.into_flattened()
    }

    /// Colour of each material: red, green, blue and opacity, linear; then 1 if it is double-sided.
    #[wasm_bindgen(getter)]
    pub fn materials(&self) -> Vec<f32> {
        let number = |material: &enfilade::Material| {
            let [r, g, b, a] = material.base_color;
            let opacity = if material.alpha == Alpha::Opaque { 1.0 } else { a };
            [r, g, b, opacity, f32::from(u8::from(material.double_sided))]
        };
        (self.geometries().flat_map(|geometry| geometry.materials()))
            .flat_map(number)
            .collect()
    }

    /// Cameras of the file: eye, target and up vector, then the vertical field of view in radians.
    #[wasm_bindgen(getter)]
    pub fn cameras(&self) -> Vec<f64> {
        let numbers = |camera: &enfilade::Camera| {
            let vectors = [camera.eye, camera.toward, camera.up];
            (vectors.into_iter().flatten())
                .chain([f64::from(camera.fov_y)])
                .collect::<Vec<_>>()
        };
        self.cameras.iter().flat_map(numbers).collect()
    }

    /// Number of triangles of all objects.
    #[wasm_bindgen(getter, js_name = triangleCount)]
    pub fn triangle_count(&self) -> f64 {
        self.scene.triangle_count() as f64
    }

    /// Determines what is visible: as [`Viewer::look`].
    ///
    /// # Errors
    /// As [`Viewer::look`].
    #[allow(
        clippy::too_many_arguments,
        reason = "numbers cross the border of the module more cheaply than objects"
    )]
    pub fn look(
        &self,
        viewer: &mut Viewer,
        eye_from_world: &[f64],
        clip_from_eye: &[f64],
        depth: u32,
        width: u32,
        height: u32,
        layers: u32,
    ) -> Result<(), JsValue> {
        let view = view(eye_from_world, clip_from_eye, depth, [width, height])?;
        viewer.see(&self.scene, [], self.items.len() as u64, &view, layers)
    }

    /// As [`SceneFile::look`], from a camera like those of [`SceneFile::cameras`].
    ///
    /// # Errors
    /// Returns `web/length`, or the code of a [`ViewError`](enfilade::ViewError).
    #[wasm_bindgen(js_name = lookFrom)]
    pub fn look_from(
        &self,
        viewer: &mut Viewer,
        camera: &[f64],
        width: u32,
        height: u32,
        layers: u32,
    ) -> Result<(), JsValue> {
        check_length("the camera", camera.len(), 10)?;
        let vector = |first: usize| [camera[first], camera[first + 1], camera[first + 2]];
        let camera = Camera {
            up: vector(6),
            fov_y: camera[9] as f32,
            ..Camera::new(vector(0), vector(3))
        };
        let view = camera
            .view([width, height])
            .map_err(|why| error(why.code(), why))?;
        viewer.see(&self.scene, [], self.items.len() as u64, &view, layers)
    }
}

impl SceneFile {
    fn geometries(&self) -> impl Iterator<Item = &enfilade::Geometry> {
        let sectors = self.scene.sectors();
        sectors.filter_map(|sector| self.scene.geometry(sector).map(AsRef::as_ref))
    }

    fn each_item<T>(&self, of: impl Fn(&enfilade::Geometry, ItemId) -> T) -> Vec<T> {
        let value = |&(sector, item): &(SectorId, ItemId)| Some(of(self.scene.geometry(sector)?, item));
        self.items.iter().filter_map(value).collect()
    }

    /// Returns a mesh and the number of its sector.
    fn mesh(&self, number: u32) -> Option<(&enfilade::Mesh, usize)> {
        let sector = self
            .first_mesh
            .partition_point(|&first| first <= number)
            .checked_sub(1)?;
        let geometry = self.scene.geometry(SectorId(sector as _))?;
        let mesh = geometry
            .meshes()
            .get((number - self.first_mesh[sector]) as usize)?;
        Some((mesh, sector))
    }
}
