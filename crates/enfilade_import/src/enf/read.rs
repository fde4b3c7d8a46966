//! Reads baked scenes.

use super::EnfError;
use super::built::BuiltBytes;
use super::container::{Container, Kind, MAGIC, Section, Source};
use super::hints::read_hints;
use super::stored::{ItemRecord, MeshRecord, StoredRoom, StoredScene, StoredTerrain, StoredTexture};
use crate::budget::{BYTES_PER_MESH, Budget};
use crate::{BrokenRule, Import, NonOccluder, NonOccluders, ReadOptions, Room, map};
use bytemuck::Pod;
use bytes::Bytes;
use enfilade::{
    Aabb, Geometry, GeometryBuilder, GeometryError, HeightField, ItemIndex, Material, MaterialId, Mesh,
    MeshId, Method, Texture, Transform,
};
use image::codecs::png::PngDecoder;
use image::{ColorType, ImageDecoder};
use rayon::prelude::*;
use std::collections::BTreeMap;
use std::fmt::Display;
use std::fs::File;
use std::io::{Cursor, Read};
use std::path::Path;
use std::sync::Arc;

/// Returns `true` if the bytes begin like a baked scene.
pub(crate) fn begins_like_enf(bytes: &[u8]) -> bool {
    bytes.starts_with(&MAGIC)
}

/// Maps a file into memory; `None` if it does not begin like a baked scene.
pub(super) fn mapped(path: &Path) -> Result<Option<Bytes>, BrokenRule> {
    // Checked before opening: opening a pipe blocks until it has a writer.
    if !std::fs::metadata(path).map_err(BrokenRule::Unreadable)?.is_file() {
        return Ok(None);
    }
    let mut file = File::open(path).map_err(BrokenRule::Unreadable)?;
    let mut start = [0; MAGIC.len()];
    if file.read_exact(&mut start).is_err() || !begins_like_enf(&start) {
        return Ok(None);
    }
    let length = file.metadata().map_err(BrokenRule::Unreadable)?.len();
    let length = usize::try_from(length).map_err(|_| std::io::ErrorKind::OutOfMemory.into());
    let map = length.and_then(|length| map::map(path, length));
    Ok(Some(Bytes::from_owner(map.map_err(BrokenRule::Unreadable)?)))
}

/// Reads a file; `None` if it does not begin like a baked scene.
pub(crate) fn read(path: &Path, options: &ReadOptions) -> Option<Result<Import, BrokenRule>> {
    let bytes = mapped(path).ok()??;
    let mut budget = Budget::new(options.limit_bytes);
    let taken = budget.take(bytes.len() as u64, || "the file".to_owned());
    Some(taken.and_then(|()| import(bytes, options, budget)))
}

pub(super) fn invalid(section: Section, rule: impl Display) -> EnfError {
    EnfError::Invalid {
        section: section.to_string(),
        rule: rule.to_string(),
    }
}

const SCENE: Section = Section(Kind::Scene, 0);
pub(super) const MESHES: Section = Section(Kind::Meshes, 0);
const ITEMS: Section = Section(Kind::Items, 0);
const NAMES: Section = Section(Kind::Names, 0);

/// Reads a baked scene.
pub(crate) fn import(bytes: Bytes, options: &ReadOptions, mut budget: Budget) -> Result<Import, BrokenRule> {
    let container = Container::open(Source::Memory(bytes))?;
    let scene = stored_scene(&container, options, &mut budget)?;
    check_the_rest(&container, &scene, &mut budget)?;
    let meshes = read_meshes(&container, &mut budget)?;
    build(scene, meshes, &container, options, budget)
}

/// Checks what only [`Pages`](super::Pages) need: a damaged file is an error, whoever reads it.
fn check_the_rest(container: &Container, scene: &StoredScene, budget: &mut Budget) -> Result<(), BrokenRule> {
    read_hints(container, scene, budget)?;
    let levels = (0..container.count(Kind::Page)).into_par_iter();
    levels.try_for_each(|page| container.section(Section(Kind::Level, page)).map(drop))
}

/// Reads the section of the scene.
pub(super) fn stored_scene(
    container: &Container,
    options: &ReadOptions,
    budget: &mut Budget,
) -> Result<StoredScene, BrokenRule> {
    if options.flat {
        return Err(EnfError::Flat.into());
    }
    let bytes = container.section(SCENE)?;
    let BuiltBytes(built) = rmp_serde::from_slice(&bytes).map_err(|why| invalid(SCENE, why))?;
    budget.take(built, || "the tables of the scene".to_owned())?;
    let scene: StoredScene = rmp_serde::from_slice(&bytes).map_err(|why| invalid(SCENE, why))?;
    let rooms = scene.rooms.len() as u64;
    budget.take(rooms * BYTES_PER_ROOM, || "the rooms".to_owned())?;
    // A room lists each of its meshes once; what it lists more often it also prepares more often.
    let listed: u64 = scene.rooms.iter().map(|room| room.meshes.len() as u64).sum();
    let meshes = container.length(MESHES) / size_of::<MeshRecord>() as u64;
    let repeated = listed.saturating_sub(meshes);
    budget.take(repeated * BYTES_PER_MESH, || "meshes that rooms share".to_owned())?;
    Ok(scene)
}

/// Memory of a room beside what it lists, in bytes.
const BYTES_PER_ROOM: u64 = 1500;
/// Memory of an item, in bytes.
const BYTES_PER_ITEM: u64 = 300;

/// Builds the rooms over these meshes.
pub(super) fn build(
    scene: StoredScene,
    meshes: Vec<Arc<Mesh>>,
    container: &Container,
    options: &ReadOptions,
    mut budget: Budget,
) -> Result<Import, BrokenRule> {
    let textures = if options.textures {
        read_textures(container, &scene.textures, &mut budget)?
    } else {
        Vec::new()
    };
    let count = container.length(ITEMS) / size_of::<ItemRecord>() as u64;
    let bytes = count * BYTES_PER_ITEM + 2 * container.length(NAMES);
    budget.take(bytes, || "the items".to_owned())?;
    let items = records::<ItemRecord>(container, ITEMS)?;
    let names = container.section(NAMES)?;
    let names = std::str::from_utf8(&names).map_err(|why| invalid(NAMES, why))?;
    let mut reader = RoomReader {
        tables: Tables::new(&scene, textures, options.textures)?,
        meshes,
        items: &items,
        names,
    };
    let rooms = scene
        .rooms
        .into_iter()
        .map(|room| reader.room(room))
        .collect::<Result<_, _>>()?;
    if !reader.items.is_empty() || !reader.names.is_empty() {
        return Err(invalid(ITEMS, "there are more items than the rooms have").into());
    }
    let import = Import {
        rooms,
        portals: scene.portals,
        cameras: scene.cameras,
        orthographic_heights: scene.orthographic_heights,
        lights: scene.lights,
        scenes: Vec::new(),
        map: scene.map,
        warnings: scene.warnings,
        files: Vec::new(),
    };
    if import.rooms.is_empty() {
        return Err(invalid(SCENE, "there are no rooms").into());
    }
    if import.cameras.len() != import.orthographic_heights.len() {
        return Err(invalid(SCENE, "there is not one height for each camera").into());
    }
    Ok(import)
}

/// Reads a section of records.
fn records<T: Pod>(container: &Container, section: Section) -> Result<Vec<T>, BrokenRule> {
    let bytes = container.section(section)?;
    if !bytes.len().is_multiple_of(size_of::<T>()) {
        return Err(invalid(section, "it ends within a record").into());
    }
    Ok(bytemuck::pod_collect_to_vec(&bytes))
}

/// Reads the section of meshes. Returns it with the meshes of each page, by their index. No two share bytes, so that a page
/// bounds what is built from it.
pub(super) fn mesh_records(
    container: &Container,
    budget: &mut Budget,
) -> Result<(Vec<MeshRecord>, Vec<Vec<u32>>), BrokenRule> {
    let count = container.length(MESHES) / size_of::<MeshRecord>() as u64;
    budget.take(count * BYTES_PER_MESH, || "the meshes".to_owned())?;
    let records = records::<MeshRecord>(container, MESHES)?;
    let mut of_pages = vec![Vec::new(); container.count(Kind::Page) as usize];
    for (index, record) in (0..).zip(&records) {
        let page = of_pages.get_mut(record.page as usize);
        page.ok_or_else(|| invalid(MESHES, "a mesh is in a page that does not exist"))?
            .push(index);
    }
    for meshes in &of_pages {
        let ranges = |range: fn(&MeshRecord) -> [u32; 2]| {
            let mut ranges: Vec<_> = meshes
                .iter()
                .map(|&mesh| range(&records[mesh as usize]))
                .collect();
            ranges.retain(|&[_, length]| length > 0);
            ranges.sort_unstable();
            ranges
        };
        let in_page = ranges(|record| [record.start, record.length]);
        let levels = ranges(|record| [record.level_start, record.level_length]);
        let overlap = |pair: &[[u32; 2]]| pair[0][0].saturating_add(pair[0][1]) > pair[1][0];
        if in_page.windows(2).chain(levels.windows(2)).any(overlap) {
            return Err(invalid(MESHES, "two meshes share bytes of a page").into());
        }
    }
    Ok((records, of_pages))
}

/// Reads all pages, in parallel, and returns the meshes in the order of their records.
fn read_meshes(container: &Container, budget: &mut Budget) -> Result<Vec<Arc<Mesh>>, BrokenRule> {
    let (records, of_pages) = mesh_records(container, budget)?;
    for page in 0..of_pages.len() as u32 {
        afford_page(container, page, &of_pages[page as usize], &records, budget)?;
    }
    let pages = of_pages.par_iter().enumerate();
    let read = pages.map(|(page, meshes)| read_page(container, page as u32, meshes, &records));
    let mut read = read.collect::<Result<Vec<_>, _>>()?.concat();
    read.sort_unstable_by_key(|(index, _)| *index);
    Ok(read.into_iter().map(|(_, mesh)| mesh).collect())
}

/// Reads the meshes of a page, with their index.
pub(super) fn read_page(
    container: &Container,
    page: u32,
    meshes: &[u32],
    records: &[MeshRecord],
) -> Result<Vec<(u32, Arc<Mesh>)>, BrokenRule> {
    let section = Section(Kind::Page, page);
    let bytes = container.section(section)?;
    let read = |&index: &u32| {
        Ok((
            index,
            Arc::new(read_mesh(&bytes, &records[index as usize], section)?),
        ))
    };
    meshes.iter().map(read).collect()
}

/// Bound of what [`Mesh::bytes_beside`] returns for a sound mesh, by the length of its bytes: a cluster is stored in 12.
const MOST_TIMES_ITS_LENGTH: u64 = 16;

/// Reserves memory for what is built of the meshes of a page beside its bytes.
pub(super) fn afford_page(
    container: &Container,
    page: u32,
    meshes: &[u32],
    records: &[MeshRecord],
    budget: &mut Budget,
) -> Result<(), BrokenRule> {
    let section = Section(Kind::Page, page);
    for &mesh in meshes {
        let MeshRecord { start, length, .. } = records[mesh as usize];
        let header = container.beginning(section, start.into(), Mesh::HEADER_BYTES.min(length as usize))?;
        // The header is not checked yet: a damaged one must not look like a large mesh.
        let most = MOST_TIMES_ITS_LENGTH * u64::from(length);
        budget.take(Mesh::bytes_beside(&header).min(most), || format!("mesh {mesh}"))?;
    }
    Ok(())
}

fn read_mesh(page: &Bytes, record: &MeshRecord, section: Section) -> Result<Mesh, EnfError> {
    let mesh = mesh_at(page, record.start, record.length, section)?;
    let bounds = mesh.bounds();
    if mesh.face_count() != record.faces || [bounds.min, bounds.max] != record.bounds {
        return Err(invalid(section, "a mesh is not as the section of meshes says"));
    }
    Ok(mesh)
}

fn mesh_at(section_bytes: &Bytes, start: u32, length: u32, section: Section) -> Result<Mesh, EnfError> {
    let [start, length] = [start, length].map(|number| number as usize);
    let end = start
        .checked_add(length)
        .filter(|&end| end <= section_bytes.len());
    let end = end.ok_or_else(|| invalid(MESHES, format!("a mesh ends after its section `{section}`")))?;
    Mesh::from_bytes(section_bytes.slice(start..end)).map_err(|why| invalid(section, why))
}

/// Reads the coarser meshes of a page, with the index of the mesh that each stands for. `materials` is the number of those that
/// each mesh may have.
pub(super) fn read_levels(
    container: &Container,
    page: u32,
    meshes: &[u32],
    records: &[MeshRecord],
    materials: &[u32],
) -> Result<Vec<(u32, Arc<Mesh>)>, BrokenRule> {
    let section = Section(Kind::Level, page);
    let bytes = container.section(section)?;
    let read = |&index: &u32| -> Result<_, BrokenRule> {
        let record = &records[index as usize];
        let level = mesh_at(&bytes, record.level_start, record.level_length, section)?;
        let [min, max] = record.bounds;
        let is_inside = level.bounds().intersection(&Aabb { min, max }) == level.bounds();
        let exists = |material: MaterialId| material.0 < materials[index as usize];
        if !is_inside || !level.clusters().iter().all(|cluster| exists(cluster.material)) {
            return Err(invalid(section, "a coarser mesh is not like its mesh").into());
        }
        Ok((index, Arc::new(level)))
    };
    let with_level = meshes
        .iter()
        .filter(|&&index| records[index as usize].level_length > 0);
    with_level.map(read).collect()
}

fn read_textures(
    container: &Container,
    stored: &[StoredTexture],
    budget: &mut Budget,
) -> Result<Vec<Arc<Texture>>, BrokenRule> {
    for texture in stored {
        let [width, height] = texture.size.map(u64::from);
        let bytes = width.saturating_mul(height).saturating_mul(4);
        budget.take(bytes, || format!("texture `{}`", texture.name))?;
    }
    let read = |(number, texture): (usize, &StoredTexture)| -> Result<_, BrokenRule> {
        let section = Section(Kind::Image, number as u32);
        let bytes = container.section(section)?;
        let image = PngDecoder::new(Cursor::new(&bytes[..])).map_err(|why| invalid(section, why))?;
        // Checked before anything is allocated, because a small image may say that it is large.
        if <[u32; 2]>::from(image.dimensions()) != texture.size {
            return Err(invalid(section, "its size is not as the section of the scene says").into());
        }
        if image.color_type() != ColorType::Rgba8 {
            return Err(invalid(section, "it is not RGBA of 8 bits").into());
        }
        let [width, height] = texture.size.map(|side| side as usize);
        let mut texels = vec![[0; 4]; width * height];
        image
            .read_image(texels.as_flattened_mut())
            .map_err(|why| invalid(section, why))?;
        let mut read =
            Texture::new(&texture.name, texture.size, texels).map_err(|why| invalid(section, why))?;
        (read.wrap, read.magnify, read.minify) = (texture.wrap, texture.magnify, texture.minify);
        Ok(Arc::new(read))
    };
    stored.par_iter().enumerate().map(read).collect()
}

/// Tables that rooms share.
struct Tables {
    materials: Vec<Arc<[Material]>>,
    /// By table and material, as [`NonOccluders::of_materials`] takes it.
    non_occluders: Vec<Arc<[Option<NonOccluder>]>>,
    textures: Vec<Arc<[Arc<Texture>]>>,
}

impl Tables {
    fn new(scene: &StoredScene, textures: Vec<Arc<Texture>>, has_textures: bool) -> Result<Tables, EnfError> {
        if scene.non_occluders.len() != scene.materials.len() {
            return Err(invalid(
                SCENE,
                "there are not reasons for each table of materials",
            ));
        }
        let reasons = |(table, materials): (&BTreeMap<u32, NonOccluder>, &Vec<Material>)| {
            let count = if table.is_empty() {
                0
            } else {
                materials.len() as u32
            };
            (0..count).map(|material| table.get(&material).copied()).collect()
        };
        let non_occluders = scene
            .non_occluders
            .iter()
            .zip(&scene.materials)
            .map(reasons)
            .collect();
        if !has_textures {
            let without = |table: &Vec<Material>| {
                let plain = |material: &Material| Material {
                    texture: None,
                    emission_texture: None,
                    ..*material
                };
                table.iter().map(plain).collect()
            };
            return Ok(Tables {
                materials: scene.materials.iter().map(without).collect(),
                non_occluders,
                textures: vec![Arc::default(); scene.texture_tables.len()],
            });
        }
        let table = |table: &Vec<u32>| {
            let texture = |&index: &u32| textures.get(index as usize).cloned();
            let table: Option<Arc<[Arc<Texture>]>> = table.iter().map(texture).collect();
            table.ok_or_else(|| invalid(SCENE, "a texture does not exist"))
        };
        Ok(Tables {
            materials: scene.materials.iter().map(|table| (&table[..]).into()).collect(),
            non_occluders,
            textures: scene.texture_tables.iter().map(table).collect::<Result<_, _>>()?,
        })
    }
}

/// Reads the rooms, one after another.
struct RoomReader<'a> {
    tables: Tables,
    meshes: Vec<Arc<Mesh>>,
    /// What no room has taken yet.
    items: &'a [ItemRecord],
    names: &'a str,
}

impl RoomReader<'_> {
    fn room(&mut self, room: StoredRoom) -> Result<Room, BrokenRule> {
        let geometry = self.geometry(&room)?;
        let reasons = self.tables.non_occluders.get(room.materials as usize);
        let mut non_occluders = NonOccluders::of_materials(reasons.map_or_else(Default::default, Arc::clone));
        let items = u32::try_from(geometry.items().len()).unwrap_or(u32::MAX);
        for (&item, &why) in &room.non_occluders {
            if item >= items {
                return Err(invalid(SCENE, "there is a reason for an item that does not exist").into());
            }
            non_occluders.add(ItemIndex(item), why);
        }
        let method = room.method.map(|name| {
            let method = Method::by_name(&name);
            method.ok_or_else(|| invalid(SCENE, format!("method `{name}` is unknown")))
        });
        Ok(Room {
            name: room.name,
            geometry: Arc::new(geometry),
            nodes: room.nodes,
            non_occluders,
            method: method.transpose()?,
            open_above: room.open_above,
            large: None,
        })
    }

    fn geometry(&mut self, room: &StoredRoom) -> Result<Geometry, BrokenRule> {
        let no_such = |what| move || invalid(SCENE, format!("a table of {what} does not exist"));
        let materials = self.tables.materials.get(room.materials as usize);
        let mut builder = GeometryBuilder::new(Arc::clone(materials.ok_or_else(no_such("materials"))?));
        let textures = self.tables.textures.get(room.textures as usize);
        builder.textures(Arc::clone(textures.ok_or_else(no_such("textures"))?));
        for &mesh in &room.meshes {
            let mesh = self.meshes.get(mesh as usize);
            builder.mesh(Arc::clone(mesh.ok_or_else(no_such("meshes"))?));
        }
        let items = self.items.split_at_checked(room.items as usize);
        let (items, rest) =
            items.ok_or_else(|| invalid(ITEMS, "there are fewer items than the rooms have"))?;
        self.items = rest;
        for item in items {
            let split = self.names.split_at_checked(item.name as usize);
            let (name, rest) = split.ok_or_else(|| invalid(NAMES, "there is not a name for each item"))?;
            self.names = rest;
            let place = Transform::from_columns(item.sector_from_item);
            let id = builder.item(name, MeshId(item.mesh), place);
            builder.set_key(id, item.key);
            builder.set_options(id, item.options());
        }
        for opening in &room.openings {
            builder.opening(&opening.name, opening.outline.clone());
        }
        if let Some(cells) = &room.cells {
            builder.cells(Arc::clone(cells));
        }
        for terrain in &room.terrains {
            add_terrain(&mut builder, terrain)?;
        }
        builder.build().map_err(|why| invalid(ITEMS, why).into())
    }
}

fn add_terrain(builder: &mut GeometryBuilder, terrain: &StoredTerrain) -> Result<(), EnfError> {
    let lines = [&terrain.columns, &terrain.rows].map(|lines| &lines[..]);
    let field = HeightField::on_lines(lines[0], lines[1], &terrain.heights[..]);
    let field = field
        .map_err(|why| invalid(SCENE, why))?
        .cut_along(terrain.diagonal);
    let first_block = ItemIndex(terrain.first_block);
    let declared = builder.terrain_of_items(field, first_block, terrain.sector_from_field);
    declared.map_err(|why: GeometryError| invalid(SCENE, why))
}
