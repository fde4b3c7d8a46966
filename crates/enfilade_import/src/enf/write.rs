//! Writes baked scenes.

use super::container::{Kind, Section, Writer};
use super::pages::Meshes;
use super::stored::{ItemRecord, MeshRecord, StoredMap, StoredRoom, StoredScene, StoredTerrain, flags};
use crate::{Import, Room};
use bytemuck::Zeroable;
use enfilade::{Geometry, ItemIndex, Material, Terrain, Texture};
use image::codecs::png::PngEncoder;
use image::{ExtendedColorType, ImageEncoder};
use rayon::prelude::*;
use std::io::{self, Seek, Write};
use std::sync::Arc;
use thiserror::Error;

/// Why a scene cannot be baked.
#[derive(Debug, Error)]
#[non_exhaustive]
pub enum BakeError {
    /// Writing fails.
    #[error(transparent)]
    Io(#[from] io::Error),
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
    if let Some(room) = import.rooms.iter().find(|room| room.large.is_some()) {
        return Err(BakeError::LargeTerrain(room.name.clone()));
    }
    let mut writer = Writer::new(to)?;
    let meshes = Meshes::of(import);
    let records = write_pages(&meshes, &mut writer)?;
    writer.section(Section(Kind::Meshes, 0), bytemuck::cast_slice(&records))?;
    write_items(import, &mut writer)?;
    let mut tables = Tables::default();
    let rooms = import.rooms.iter().zip(meshes.of_rooms);
    let rooms = rooms
        .map(|(room, meshes)| stored_room(room, meshes, tables.add(&room.geometry)))
        .collect();
    for (number, &texture) in (0..).zip(&tables.textures) {
        writer.section(Section(Kind::Image, number), &png(texture)?)?;
    }
    let scene = StoredScene {
        rooms,
        portals: import.portals.clone(),
        cameras: import.cameras.clone(),
        orthographic_heights: import.orthographic_heights.clone(),
        lights: import.lights.clone(),
        map: import.map.as_ref().map(|map| StoredMap {
            format: map.format.to_owned(),
            leafs: map.leafs as u64,
            clusters: map.clusters.map(|clusters| clusters as u64),
            faces: map.faces as u64,
            models: map.models as u64,
            entities: map.entities as u64,
            visibility_bytes: map.visibility_bytes as u64,
        }),
        warnings: import.warnings.clone(),
        texture_tables: tables.texture_tables(),
        materials: tables.materials.iter().map(|&table| table.into()).collect(),
        textures: tables.textures.iter().map(|&texture| texture.into()).collect(),
    };
    let scene = rmp_serde::to_vec_named(&scene).map_err(|why| BakeError::Encoding(why.to_string()))?;
    writer.section(Section(Kind::Scene, 0), &scene)?;
    Ok(writer.finish()?)
}

/// Writes the meshes, page by page. Returns where each is.
fn write_pages(
    meshes: &Meshes,
    writer: &mut Writer<impl Write + Seek>,
) -> Result<Vec<MeshRecord>, BakeError> {
    let mut records = vec![MeshRecord::zeroed(); meshes.list.len()];
    let mut number = 0;
    for pages in meshes.pages.chunks(PAGES_AT_ONCE) {
        let encoded: Vec<Vec<Vec<u8>>> = pages
            .par_iter()
            .map(|page| {
                page.iter()
                    .map(|&mesh| meshes.list[mesh as usize].to_bytes())
                    .collect()
            })
            .collect();
        for (page, encoded) in pages.iter().zip(encoded) {
            let mut bytes = Vec::with_capacity(encoded.iter().map(Vec::len).sum());
            for (&mesh, encoded) in page.iter().zip(encoded) {
                let held = meshes.list[mesh as usize];
                let places = [bytes.len(), encoded.len()].map(u32::try_from);
                let [Ok(start), Ok(length)] = places else {
                    return Err(BakeError::LargeMesh(held.face_count()));
                };
                records[mesh as usize] = MeshRecord {
                    page: number,
                    start,
                    length,
                    faces: held.face_count(),
                    bounds: [held.bounds().min, held.bounds().max],
                };
                bytes.extend(encoded);
            }
            writer.section(Section(Kind::Page, number), &bytes)?;
            number += 1;
        }
    }
    Ok(records)
}

fn write_items(import: &Import, writer: &mut Writer<impl Write + Seek>) -> Result<(), BakeError> {
    let (mut records, mut names) = (Vec::new(), Vec::new());
    for room in &import.rooms {
        let geometry = &room.geometry;
        for index in (0..geometry.items().len() as u32).map(ItemIndex) {
            let item = geometry.item(index);
            let name = geometry.name(index);
            names.extend_from_slice(name.as_bytes());
            records.push(ItemRecord {
                key: geometry.key(index),
                sector_from_item: item.sector_from_item,
                mesh: item.mesh.0,
                name: name.len() as u32,
                layers: item.options.layers,
                max_distance: item.options.max_distance,
                min_size_px: item.options.min_size_px,
                flags: flags(&item.options),
            });
        }
    }
    writer.section(Section(Kind::Items, 0), bytemuck::cast_slice(&records))?;
    writer.section(Section(Kind::Names, 0), &names)?;
    Ok(())
}

/// Tables that rooms share, each once.
#[derive(Default)]
struct Tables<'a> {
    materials: Vec<&'a [Material]>,
    texture_tables: Vec<&'a [Arc<Texture>]>,
    textures: Vec<&'a Texture>,
}

impl<'a> Tables<'a> {
    fn add(&mut self, geometry: &'a Geometry) -> [u32; 2] {
        let textures = geometry.textures();
        for texture in textures {
            index_in(&mut self.textures, &**texture);
        }
        [
            index_in(&mut self.materials, geometry.materials()),
            index_in(&mut self.texture_tables, textures),
        ]
    }

    /// Returns the texture tables by the indices of their textures.
    fn texture_tables(&mut self) -> Vec<Vec<u32>> {
        let textures = &mut self.textures;
        let tables = self.texture_tables.iter();
        let mut index = |texture: &'a Arc<Texture>| index_in(textures, &**texture);
        tables
            .map(|table| table.iter().map(&mut index).collect())
            .collect()
    }
}

/// Returns the index of an element, which is added if it is not there yet.
fn index_in<'a, T: ?Sized>(list: &mut Vec<&'a T>, element: &'a T) -> u32 {
    let known = list.iter().position(|known| std::ptr::eq(*known, element));
    known.unwrap_or_else(|| {
        list.push(element);
        list.len() - 1
    }) as u32
}

fn stored_room(room: &Room, meshes: Vec<u32>, [materials, textures]: [u32; 2]) -> StoredRoom {
    let geometry = &room.geometry;
    StoredRoom {
        name: room.name.clone(),
        method: room.method.map(|method| method.name().to_owned()),
        open_above: room.open_above,
        nodes: room.nodes.clone(),
        items: geometry.items().len() as u32,
        meshes,
        materials,
        textures,
        openings: geometry.openings().to_vec(),
        cells: geometry.cells().cloned(),
        terrains: geometry.terrains().iter().map(stored_terrain).collect(),
    }
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
