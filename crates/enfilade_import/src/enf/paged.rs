//! Baked scenes whose meshes are read page by page, for worlds larger than memory.

use super::container::{Container, Kind, Section, Source};
use super::hints::{Hint, read_hints};
use super::read::{
    MESHES, afford_page, build, invalid, mapped, mesh_records, read_levels, read_page, stored_scene,
};
use super::stored::{MeshRecord, StoredRoom, StoredScene};
use crate::budget::{BYTES_PER_MESH, Budget};
use crate::{BrokenRule, EnfError, Import, ImportError, ReadOptions};
use enfilade::{Aabb, MAX_COORDINATE, Mesh, MeshId, Method};
use std::fs::File;
use std::path::Path;
use std::sync::{Arc, Mutex};

/// The pages of a baked scene: groups of meshes that are near each other, read one by one.
///
/// Any number of threads may load pages at once.
pub struct Pages {
    file: String,
    container: Container,
    records: Vec<MeshRecord>,
    of_pages: Vec<Vec<u32>>,
    /// The meshes of each room.
    of_rooms: Vec<Vec<u32>>,
    /// Whether each page was read at once, because the method of a room needs all its meshes.
    resident: Vec<bool>,
    hints: Vec<Hint>,
    /// Number of materials that each mesh may have.
    materials: Vec<u32>,
}

/// Returns `true` if rooms of this method can do without some of their meshes: an edit of an item costs little.
fn takes_pages(method: Option<Method>) -> bool {
    !matches!(
        method,
        Some(Method::Bsp | Method::BspFront | Method::Cell | Method::Pvs | Method::FloatingHorizon)
    )
}

impl Pages {
    /// Opens a baked scene without reading its meshes: they are [`Mesh::bounds_only`], so their items may be visible if any
    /// part of their box may be, and hide nothing.
    ///
    /// Rooms whose method is `bsp`, `bsp-front`, `cell`, `pvs` or `floating-horizon`, or that have terrain, are read whole.
    /// [`ReadOptions::limit_bytes`] limits what is read now.
    ///
    /// # Errors
    /// Returns an [`ImportError`] if the file is no baked scene, or is damaged.
    pub fn open(path: &Path, options: &ReadOptions) -> Result<(Import, Pages), ImportError> {
        let file = path.display().to_string();
        match Pages::open_rule(path, file.clone(), options) {
            Ok(opened) => Ok(opened),
            Err(rule) => Err(ImportError { file, rule }),
        }
    }

    fn open_rule(path: &Path, file: String, options: &ReadOptions) -> Result<(Import, Pages), BrokenRule> {
        if mapped(path)?.is_none() {
            return Err(EnfError::NotBaked.into());
        }
        let opened = File::open(path).map_err(BrokenRule::Unreadable)?;
        let container = Container::open(Source::File(Mutex::new(opened)))?;
        let mut budget = Budget::new(options.limit_bytes);
        budget.take(container.length_without([Kind::Page, Kind::Level]), || {
            "the scene without its meshes".to_owned()
        })?;
        let scene = stored_scene(&container, options, &mut budget)?;
        let (records, of_pages) = mesh_records(&container, &mut budget)?;
        let mut resident = vec![false; of_pages.len()];
        let is_whole = |room: &&StoredRoom| {
            let method = room.method.as_deref().and_then(Method::by_name);
            !takes_pages(method) || !room.terrains.is_empty()
        };
        for &mesh in scene.rooms.iter().filter(is_whole).flat_map(|room| &room.meshes) {
            let record = records.get(mesh as usize);
            let record = record.ok_or_else(|| invalid(MESHES, "a mesh of a room does not exist"))?;
            resident[record.page as usize] = true;
        }
        let mut meshes: Vec<Arc<Mesh>> = Vec::with_capacity(records.len());
        for record in &records {
            meshes.push(Arc::new(stand_in(record)?));
        }
        for page in (0..of_pages.len() as u32).filter(|&page| resident[page as usize]) {
            let bytes = container.length(Section(Kind::Page, page));
            budget.take(bytes, || "rooms that are read whole".to_owned())?;
            afford_page(&container, page, &of_pages[page as usize], &records, &mut budget)?;
            for (index, mesh) in read_page(&container, page, &of_pages[page as usize], &records)? {
                meshes[index as usize] = mesh;
            }
        }
        let hints = read_hints(&container, &scene, &mut budget)?;
        let materials = material_counts(&scene, records.len());
        let of_rooms = scene.rooms.iter().map(|room| room.meshes.clone()).collect();
        let import = build(scene, meshes, &container, options, budget)?;
        let pages = Pages {
            file,
            container,
            records,
            of_pages,
            of_rooms,
            resident,
            hints,
            materials,
        };
        Ok((import, pages))
    }

    /// Returns the number of pages.
    pub fn count(&self) -> u32 {
        self.of_pages.len() as u32
    }

    /// Returns `true` if a page was read at once, because the method of a room needs all its meshes.
    ///
    /// # Panics
    /// If there is no such page.
    pub fn is_resident(&self, page: u32) -> bool {
        self.resident[page as usize]
    }

    /// Estimates the memory that the meshes of a page take once they are loaded, in bytes; 0 if there is no such page.
    pub fn bytes(&self, page: u32) -> u64 {
        let meshes = self.of_pages.get(page as usize).map_or(0, Vec::len) as u64;
        self.container.length(Section(Kind::Page, page)) + meshes * BYTES_PER_MESH
    }

    /// Returns the index in the file of a mesh of a room.
    ///
    /// # Panics
    /// If there is no such room or mesh.
    pub fn mesh_of(&self, room: usize, mesh: MeshId) -> u32 {
        self.of_rooms[room][mesh.0 as usize]
    }

    /// Returns the page of a mesh, by its index in the file.
    ///
    /// # Panics
    /// If there is no such mesh.
    pub fn page_of(&self, mesh: u32) -> u32 {
        self.records[mesh as usize].page
    }

    /// Returns the size of a mesh, by its index in the file, in bytes.
    ///
    /// # Panics
    /// If there is no such mesh.
    pub fn mesh_bytes(&self, mesh: u32) -> u64 {
        self.records[mesh as usize].length.into()
    }

    /// Returns what is seen from regions of rooms, if the scene was baked with hints.
    pub fn hints(&self) -> &[Hint] {
        &self.hints
    }

    /// Returns the number of meshes in the file.
    pub fn mesh_count(&self) -> u32 {
        self.records.len() as u32
    }

    /// Reads a page. Returns its meshes with their index in the file.
    ///
    /// # Errors
    /// Returns an [`ImportError`] if the page is damaged, or cannot be read.
    ///
    /// # Panics
    /// If there is no such page.
    pub fn load(&self, page: u32) -> Result<Vec<(u32, Arc<Mesh>)>, ImportError> {
        let meshes = &self.of_pages[page as usize];
        let read = read_page(&self.container, page, meshes, &self.records);
        read.map_err(|rule| self.error(rule))
    }

    /// Reads coarser meshes of those of a page, to draw until it is read: each is within the box of its mesh, has its materials,
    /// and at most an eighth of its triangles, or 64. Returns them with the index in the file of the mesh that they stand for. They are
    /// not for looks: they hide what their mesh does not, and the other way round.
    ///
    /// # Errors
    /// Returns an [`ImportError`] if they are damaged, or cannot be read.
    ///
    /// # Panics
    /// If there is no such page.
    pub fn load_levels(&self, page: u32) -> Result<Vec<(u32, Arc<Mesh>)>, ImportError> {
        let meshes = &self.of_pages[page as usize];
        let read = read_levels(&self.container, page, meshes, &self.records, &self.materials);
        read.map_err(|rule| self.error(rule))
    }

    /// Returns the size of the coarser meshes of a page, in bytes.
    ///
    /// # Panics
    /// If there is no such page.
    pub fn level_bytes(&self, page: u32) -> u64 {
        self.container.length(Section(Kind::Level, page))
    }

    fn error(&self, rule: BrokenRule) -> ImportError {
        ImportError {
            file: self.file.clone(),
            rule,
        }
    }
}

/// Returns the number of materials that each mesh may have: those of each room that it is in.
fn material_counts(scene: &StoredScene, meshes: usize) -> Vec<u32> {
    let mut counts = vec![u32::MAX; meshes];
    for room in &scene.rooms {
        let table = scene.materials.get(room.materials as usize);
        let count = table.map_or(0, |table| table.len() as u32);
        for &mesh in &room.meshes {
            if let Some(least) = counts.get_mut(mesh as usize) {
                *least = count.min(*least);
            }
        }
    }
    counts
}

/// Returns a mesh that stands for one that is not read, or has no faces.
fn stand_in(record: &MeshRecord) -> Result<Mesh, EnfError> {
    let [min, max] = record.bounds;
    if (Aabb { min, max }).is_empty() {
        return Mesh::new(&[]).map_err(|why| invalid(MESHES, why));
    }
    // A flat mesh gets a box of some volume.
    let size = (0..3).map(|axis| max[axis] - min[axis]).fold(0.0, f32::max);
    let pad = |axis: usize| {
        let far = min[axis].abs().max(max[axis].abs());
        if max[axis] > min[axis] {
            0.0
        } else {
            (far * 1e-6).max(size * 1e-6).max(f32::MIN_POSITIVE)
        }
    };
    let place = |corner: [f32; 3], sign: f32| {
        [0, 1, 2].map(|axis| (corner[axis] + sign * pad(axis)).clamp(-MAX_COORDINATE, MAX_COORDINATE))
    };
    Mesh::bounds_only(place(min, -1.0), place(max, 1.0)).map_err(|why| invalid(MESHES, why))
}
