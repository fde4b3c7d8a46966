//! Writes baked scenes.

use super::coarse::coarse;
use super::container::{Kind, Section, Writer};
use super::pages::{Meshes, PagedMesh};
use super::stored::{ItemRecord, MeshRecord, StoredRoom, StoredScene, StoredTerrain, StoredTexture, flags};
use crate::{Import, ImportError, NonOccluder, Room};
use bytemuck::Zeroable;
use enfilade::{
    Camera, ItemIndex, Light, Material, MaterialId, Mesh, Portal, SectorId, Terrain, Texture, TextureId,
};
use image::codecs::png::PngEncoder;
use image::{ExtendedColorType, ImageEncoder};
use rayon::prelude::*;
use std::collections::hash_map::Entry;
use std::collections::{BTreeMap, HashMap};
use std::io::{self, Seek, Write};
use std::sync::Arc;
use thiserror::Error;
use xxhash_rust::xxh3::xxh3_128;

/// Why a scene cannot be baked.
#[derive(Debug, Error)]
#[non_exhaustive]
pub enum BakeError {
    /// Writing fails.
    #[error(transparent)]
    Io(#[from] io::Error),
    /// A baked scene that it is made from cannot be read.
    #[error(transparent)]
    Unreadable(#[from] ImportError),
    /// The heights of a terrain stay in their file, because they would take more memory than allowed.
    #[error(
        "terrain `{0}` is read from its own file on demand, because it does not fit in memory; allow more (--memory), or use \
         that file"
    )]
    LargeTerrain(String),
    /// A page would be larger than 4 GB. Holds the faces of its first mesh.
    #[error("a mesh of {0} faces takes more than 4 GB; split it")]
    LargeMesh(u32),
    /// A table cannot be encoded.
    #[error("the scene cannot be encoded: {0}")]
    Encoding(String),
}

/// Pages that are encoded at once, in parallel, before they are written.
const PAGES_AT_ONCE: usize = 64;

/// Writes a scene as a baked scene (`.enf`) to the start of `to`. Returns the number of bytes.
///
/// The bytes depend on the scene alone, not on the number of threads. [`read`](crate::read) returns the same scene, bit by bit.
/// Write to a new file and rename it: readers map the file into memory, and expect that it does not change.
///
/// # Errors
/// Returns a [`BakeError`] if the scene has terrain that does not fit in memory, or writing fails.
pub fn bake(import: &Import, to: impl Write + Seek) -> Result<u64, BakeError> {
    let mut baker = Baker::new(to, "")?;
    baker.add(import, None)?;
    baker.finish()
}

/// Bakes several scenes into one, one after another: tiles of a world, of which only one needs to be in memory.
///
/// The meshes of a scene are written when it is added.
pub struct Baker<W> {
    writer: Writer<W>,
    /// Name of the room that tiles share.
    name: String,
    /// Index of that room.
    shared: Option<usize>,
    meshes: Vec<MeshRecord>,
    pages: u32,
    /// The items of each room, and their names.
    items: Vec<(Vec<ItemRecord>, String)>,
    /// The index of each texture by the hash of its image and its sampler.
    known_textures: HashMap<u128, u32>,
    scene: StoredScene,
}

impl<W: Write + Seek> Baker<W> {
    /// Starts to write at the start of `to`. `name` is that of the room that tiles share.
    ///
    /// # Errors
    /// Returns [`BakeError::Io`] if writing fails.
    pub fn new(to: W, name: &str) -> Result<Baker<W>, BakeError> {
        Ok(Baker {
            writer: Writer::new(to)?,
            name: name.to_owned(),
            shared: None,
            meshes: Vec::new(),
            pages: 0,
            items: Vec::new(),
            known_textures: HashMap::new(),
            scene: StoredScene::default(),
        })
    }

    /// Adds a scene. With `tile`, the name of a tile, its rooms, items and cameras are called `TILE/NAME`, and if it has one
    /// room alone, without portals, baked cells and terrain, its items join those of other such tiles in one room; they lose the
    /// nodes of their file, and items whose key is their index get that of the new room.
    ///
    /// # Errors
    /// Returns a [`BakeError`] if the scene has terrain that does not fit in memory, or writing fails.
    pub fn add(&mut self, import: &Import, tile: Option<&str>) -> Result<(), BakeError> {
        if let Some(room) = import.rooms.iter().find(|room| room.large.is_some()) {
            return Err(BakeError::LargeTerrain(room.name.clone()));
        }
        let named = |name: &str| match tile {
            Some(tile) => format!("{tile}/{name}"),
            None => name.to_owned(),
        };
        let first_mesh = self.meshes.len() as u32;
        let Meshes {
            list,
            mut of_rooms,
            pages,
        } = Meshes::of(import);
        of_rooms.iter_mut().flatten().for_each(|mesh| *mesh += first_mesh);
        let alone = match &import.rooms[..] {
            [room] if tile.is_some() && joins(room) && import.portals.is_empty() => Some(room),
            _ => None,
        };
        let first_room = if let Some(room) = alone {
            let shared = self.shared_room();
            let materials = self.join_materials(shared, room)?;
            let is_same = materials.iter().enumerate().all(|(old, &new)| old as u32 == new);
            self.write_pages(&list, &pages, (!is_same).then_some(&materials[..]))?;
            let joined = &mut self.scene.rooms[shared];
            if joined.method.is_none() {
                joined.method = room.method.map(|method| method.name().to_owned());
            }
            joined.open_above |= room.open_above;
            let meshes = joined.meshes.len() as u32;
            joined.meshes.extend(of_rooms.concat());
            self.add_items(shared, room, meshes, named);
            shared
        } else {
            let first = self.scene.rooms.len();
            self.write_pages(&list, &pages, None)?;
            let mut tables = HashMap::new();
            for (room, meshes) in import.rooms.iter().zip(of_rooms) {
                let stored = self.stored_room(room, named(&room.name), meshes, &mut tables)?;
                let number = self.add_room(stored);
                self.add_items(number, room, 0, named);
            }
            first
        };
        let sector = |SectorId(room): SectorId| SectorId(first_room as u32 + room);
        let scene = &mut self.scene;
        scene.portals.extend(import.portals.iter().map(|portal| Portal {
            from: sector(portal.from),
            to: sector(portal.to),
            ..portal.clone()
        }));
        scene.cameras.extend(import.cameras.iter().map(|camera| Camera {
            name: named(&camera.name),
            sector: camera.sector.map(sector),
            ..camera.clone()
        }));
        scene.orthographic_heights.extend(&import.orthographic_heights);
        scene.lights.extend(import.lights.iter().map(|light| Light {
            sector: sector(light.sector),
            ..*light
        }));
        scene.map = scene.map.take().or_else(|| import.map.clone());
        scene.warnings.extend(import.warnings.iter().cloned());
        Ok(())
    }

    /// Returns the number of rooms so far.
    pub fn room_count(&self) -> usize {
        self.scene.rooms.len()
    }

    /// Notes what the scene is baked from, such as a hash of its files, for [`BakedSections::source`](crate::BakedSections). At
    /// most once.
    ///
    /// # Errors
    /// Returns [`BakeError::Io`] if writing fails.
    pub fn note_source(&mut self, source: &[u8]) -> Result<(), BakeError> {
        Ok(self.writer.section(Section(Kind::Source, 0), source)?)
    }

    /// Writes everything but the meshes. Returns the length of the file, in bytes.
    ///
    /// # Errors
    /// Returns a [`BakeError`] if writing fails.
    pub fn finish(mut self) -> Result<u64, BakeError> {
        let (mut items, mut names) = (Vec::new(), String::new());
        for (room, (of_room, names_of_room)) in self.scene.rooms.iter_mut().zip(self.items) {
            room.items = of_room.len() as u32;
            items.extend(of_room);
            names += &names_of_room;
        }
        let scene =
            rmp_serde::to_vec_named(&self.scene).map_err(|why| BakeError::Encoding(why.to_string()))?;
        for (kind, bytes) in [
            (Kind::Meshes, bytemuck::cast_slice(&self.meshes)),
            (Kind::Items, bytemuck::cast_slice(&items)),
            (Kind::Names, names.as_bytes()),
            (Kind::Scene, &scene),
        ] {
            self.writer.section(Section(kind, 0), bytes)?;
        }
        Ok(self.writer.finish()?)
    }

    /// Writes meshes page by page, with other materials if `materials` has them.
    fn write_pages(
        &mut self,
        meshes: &[PagedMesh],
        pages: &[Vec<u32>],
        materials: Option<&[u32]>,
    ) -> Result<(), BakeError> {
        let first = self.meshes.len();
        self.meshes.resize(first + meshes.len(), MeshRecord::zeroed());
        let encode = |&number: &u32| {
            let PagedMesh { mesh, materials: own } = meshes[number as usize];
            let stored = |mesh: Mesh| match materials {
                Some(new) => mesh
                    .with_materials(|old| MaterialId(new[old.0 as usize]))
                    .to_bytes(),
                None => mesh.to_bytes(),
            };
            [
                stored(mesh.with_occluders(own)),
                coarse(mesh).map_or(Vec::new(), stored),
            ]
        };
        for pages in pages.chunks(PAGES_AT_ONCE) {
            let encoded: Vec<Vec<[Vec<u8>; 2]>> = pages
                .par_iter()
                .map(|page| page.iter().map(encode).collect())
                .collect();
            for (page, encoded) in pages.iter().zip(encoded) {
                let [mut bytes, mut levels] = [const { Vec::new() }; 2];
                for (&mesh, [encoded, level]) in page.iter().zip(encoded) {
                    let held = meshes[mesh as usize].mesh;
                    let places = [bytes.len(), encoded.len(), levels.len(), level.len()].map(u32::try_from);
                    let [Ok(start), Ok(length), Ok(level_start), Ok(level_length)] = places else {
                        return Err(BakeError::LargeMesh(held.face_count()));
                    };
                    self.meshes[first + mesh as usize] = MeshRecord {
                        page: self.pages,
                        start,
                        length,
                        faces: held.face_count(),
                        level_start,
                        level_length,
                        bounds: [held.bounds().min, held.bounds().max],
                    };
                    bytes.extend(encoded);
                    levels.extend(level);
                }
                self.writer.section(Section(Kind::Page, self.pages), &bytes)?;
                self.writer.section(Section(Kind::Level, self.pages), &levels)?;
                self.pages += 1;
            }
        }
        Ok(())
    }

    /// Returns the index of the room that tiles share.
    fn shared_room(&mut self) -> usize {
        if let Some(shared) = self.shared {
            return shared;
        }
        self.scene.materials.push(Vec::new());
        self.scene.non_occluders.push(BTreeMap::new());
        self.scene.texture_tables.push(Vec::new());
        let number = self.add_room(StoredRoom {
            name: self.name.clone(),
            materials: self.scene.materials.len() as u32 - 1,
            textures: self.scene.texture_tables.len() as u32 - 1,
            ..StoredRoom::default()
        });
        *self.shared.insert(number)
    }

    /// Adds a room without items, and returns its index.
    fn add_room(&mut self, room: StoredRoom) -> usize {
        self.scene.rooms.push(room);
        self.items.push(Default::default());
        self.scene.rooms.len() - 1
    }

    /// Adds the items of `added` to a room, whose meshes follow the first `meshes` of the room.
    fn add_items(&mut self, room: usize, added: &Room, meshes: u32, named: impl Fn(&str) -> String) {
        let (items, names) = &mut self.items[room];
        let geometry = &added.geometry;
        let first = items.len() as u32;
        let why = added.non_occluders.items().iter();
        let why = why.map(|(item, &why)| (first + item.0, why));
        self.scene.rooms[room].non_occluders.extend(why);
        for index in (0..geometry.items().len() as u32).map(ItemIndex) {
            let item = geometry.item(index);
            let name = named(geometry.name(index));
            let own_key = geometry.key(index);
            *names += &name;
            items.push(ItemRecord {
                key: if own_key == u64::from(index.0) {
                    items.len() as u64
                } else {
                    own_key
                },
                sector_from_item: item.sector_from_item,
                mesh: meshes + item.mesh.0,
                name: name.len() as u32,
                layers: item.options.layers,
                max_distance: item.options.max_distance,
                min_size_px: item.options.min_size_px,
                flags: flags(&item.options),
            });
        }
    }

    /// Adds materials to the table of a room. Returns the new index of each.
    fn join_materials(&mut self, room: usize, added: &Room) -> Result<Vec<u32>, BakeError> {
        let geometry = &added.geometry;
        let textures = self.store_textures(geometry.textures())?;
        let StoredRoom {
            materials: table,
            textures: texture_table,
            ..
        } = self.scene.rooms[room];
        let known = &mut self.scene.texture_tables[texture_table as usize];
        let mut place = |texture: TextureId| TextureId(index_in(known, textures[texture.0 as usize]));
        let reasons = &mut self.scene.non_occluders[table as usize];
        let table = &mut self.scene.materials[table as usize];
        let join = |(number, material): (u32, &Material)| {
            let material = Material {
                texture: material.texture.map(&mut place),
                emission_texture: material.emission_texture.map(&mut place),
                ..*material
            };
            let why = added.non_occluders.recorded(MaterialId(number));
            let is_same = |at: u32| table[at as usize] == material && reasons.get(&at) == why.as_ref();
            let next = table.len() as u32;
            let index = (0..next).find(|&at| is_same(at)).unwrap_or(next);
            if index == next {
                table.push(material);
                reasons.extend(why.map(|why| (next, why)));
            }
            index
        };
        Ok((0..).zip(geometry.materials()).map(join).collect())
    }

    /// Stores textures that are not stored yet, and returns their indices.
    fn store_textures(&mut self, textures: &[Arc<Texture>]) -> Result<Vec<u32>, BakeError> {
        let images = textures
            .par_iter()
            .map(|texture| png(texture))
            .collect::<Result<Vec<_>, _>>()?;
        let mut indices = Vec::with_capacity(textures.len());
        for (texture, image) in textures.iter().zip(images) {
            let stored = StoredTexture::from(&**texture);
            let encoded = rmp_serde::to_vec(&stored).map_err(|why| BakeError::Encoding(why.to_string()))?;
            let hash = xxh3_128(&[&encoded[..], &image].concat());
            let index = match self.known_textures.entry(hash) {
                Entry::Occupied(known) => *known.get(),
                Entry::Vacant(free) => {
                    let index = self.scene.textures.len() as u32;
                    self.writer.section(Section(Kind::Image, index), &image)?;
                    self.scene.textures.push(stored);
                    *free.insert(index)
                }
            };
            indices.push(index);
        }
        Ok(indices)
    }

    /// Stores a room without its items. `tables` are those of rooms of the same scene, by their address.
    fn stored_room(
        &mut self,
        room: &Room,
        name: String,
        meshes: Vec<u32>,
        tables: &mut HashMap<(*const Material, *const Arc<Texture>), [u32; 2]>,
    ) -> Result<StoredRoom, BakeError> {
        let geometry = &room.geometry;
        let (materials, textures) = (geometry.materials(), geometry.textures());
        let [materials, textures] = match tables.entry((materials.as_ptr(), textures.as_ptr())) {
            Entry::Occupied(known) => *known.get(),
            Entry::Vacant(free) => {
                let table = self.store_textures(textures)?;
                self.scene.texture_tables.push(table);
                self.scene.materials.push(materials.to_vec());
                self.scene.non_occluders.push(recorded(room));
                let last = [self.scene.materials.len(), self.scene.texture_tables.len()];
                *free.insert(last.map(|count| count as u32 - 1))
            }
        };
        Ok(StoredRoom {
            name,
            method: room.method.map(|method| method.name().to_owned()),
            open_above: room.open_above,
            nodes: room.nodes.clone(),
            meshes,
            materials,
            textures,
            openings: geometry.openings().to_vec(),
            cells: geometry.cells().cloned(),
            terrains: geometry.terrains().iter().map(stored_terrain).collect(),
            ..StoredRoom::default()
        })
    }
}

/// Returns why materials of a room hide nothing, as far as their alpha modes do not tell.
fn recorded(room: &Room) -> BTreeMap<u32, NonOccluder> {
    let why = |number: u32| Some((number, room.non_occluders.recorded(MaterialId(number))?));
    (0..room.geometry.materials().len() as u32)
        .filter_map(why)
        .collect()
}

/// Returns `true` if the items of a room may join those of other tiles.
fn joins(room: &Room) -> bool {
    let geometry = &room.geometry;
    geometry.cells().is_none() && geometry.terrains().is_empty() && geometry.openings().is_empty()
}

/// Returns the index of an element, which is added if there is none like it.
fn index_in<T: PartialEq>(list: &mut Vec<T>, element: T) -> u32 {
    let known = list.iter().position(|known| *known == element);
    known.unwrap_or_else(|| {
        list.push(element);
        list.len() - 1
    }) as u32
}

fn stored_terrain(terrain: &Terrain) -> StoredTerrain {
    let field = terrain.field();
    let [columns, rows] = field.size();
    let height = |row| (0..columns).map(move |column| field.position(column, row)[1]);
    StoredTerrain {
        columns: (0..columns).map(|column| field.position(column, 0)[0]).collect(),
        rows: (0..rows).map(|row| field.position(0, row)[2]).collect(),
        heights: (0..rows).flat_map(height).collect(),
        diagonal: field.diagonal(),
        first_block: terrain.first_block().0,
        sector_from_field: *terrain.sector_from_field(),
    }
}

fn png(texture: &Texture) -> Result<Vec<u8>, BakeError> {
    let [width, height] = texture.size();
    let mut bytes = Vec::new();
    PngEncoder::new(&mut bytes)
        .write_image(
            texture.texels().as_flattened(),
            width,
            height,
            ExtendedColorType::Rgba8,
        )
        .map_err(|why| BakeError::Encoding(format!("texture `{}`: {why}", texture.name)))?;
    Ok(bytes)
}
