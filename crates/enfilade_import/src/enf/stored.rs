//! What the sections of a baked scene hold.

use crate::quake::MapSummary;
use crate::{NonOccluder, SourceNodes, Warning};
use bytemuck::{Pod, Zeroable};
use enfilade::{
    BakedCells, Camera, Diagonal, Filter, ItemOptions, Light, Material, Minify, Opening, Portal, Texture,
    Transform, Wrap,
};
use serde::{Deserialize, Serialize};
use std::collections::BTreeMap;
use std::sync::Arc;

/// Everything but meshes, items and images.
#[derive(Default, Serialize, Deserialize)]
pub(super) struct StoredScene {
    pub(super) rooms: Vec<StoredRoom>,
    pub(super) portals: Vec<Portal>,
    pub(super) cameras: Vec<Camera>,
    pub(super) orthographic_heights: Vec<Option<f32>>,
    pub(super) lights: Vec<Light>,
    pub(super) map: Option<MapSummary>,
    pub(super) warnings: Vec<Warning>,
    /// Tables of materials, each used by at least one room.
    pub(super) materials: Vec<Vec<Material>>,
    /// For each table why its materials hide nothing, as far as their alpha modes do not tell.
    pub(super) non_occluders: Vec<BTreeMap<u32, NonOccluder>>,
    pub(super) textures: Vec<StoredTexture>,
    /// Tables of textures, by their index in `textures`.
    pub(super) texture_tables: Vec<Vec<u32>>,
}

#[derive(Default, Serialize, Deserialize)]
pub(super) struct StoredRoom {
    pub(super) name: String,
    pub(super) method: Option<String>,
    pub(super) open_above: bool,
    pub(super) nodes: SourceNodes,
    /// Why items hide nothing.
    pub(super) non_occluders: BTreeMap<u32, NonOccluder>,
    /// Number of its items, which follow those of the room before.
    pub(super) items: u32,
    /// Its meshes, by their index in the section of meshes.
    pub(super) meshes: Vec<u32>,
    /// Its tables of materials and textures.
    pub(super) materials: u32,
    pub(super) textures: u32,
    pub(super) openings: Vec<Opening>,
    pub(super) cells: Option<Arc<BakedCells>>,
    pub(super) terrains: Vec<StoredTerrain>,
}

/// The height field of a terrain. Its blocks are items.
#[derive(Serialize, Deserialize)]
pub(super) struct StoredTerrain {
    pub(super) columns: Vec<f32>,
    pub(super) rows: Vec<f32>,
    pub(super) heights: Vec<f32>,
    pub(super) diagonal: Diagonal,
    pub(super) first_block: u32,
    pub(super) sector_from_field: Transform,
}

/// A texture without its image.
#[derive(Serialize, Deserialize)]
pub(super) struct StoredTexture {
    pub(super) name: String,
    pub(super) size: [u32; 2],
    pub(super) wrap: [Wrap; 2],
    pub(super) magnify: Filter,
    pub(super) minify: Minify,
}

impl From<&Texture> for StoredTexture {
    fn from(texture: &Texture) -> StoredTexture {
        StoredTexture {
            name: texture.name.clone(),
            size: texture.size(),
            wrap: texture.wrap,
            magnify: texture.magnify,
            minify: texture.minify,
        }
    }
}

/// Where a mesh is stored.
#[repr(C)]
#[derive(Clone, Copy, Debug, Pod, Zeroable)]
pub(super) struct MeshRecord {
    pub(super) page: u32,
    /// Start and length in the page, in bytes.
    pub(super) start: u32,
    pub(super) length: u32,
    pub(super) faces: u32,
    /// Start and length of its coarser mesh among those of the page, in bytes; no length if there is none.
    pub(super) level_start: u32,
    pub(super) level_length: u32,
    /// AABB, least and greatest corner; infinite, and the wrong way round, if the mesh is empty.
    pub(super) bounds: [[f32; 3]; 2],
}

/// An item.
#[repr(C)]
#[derive(Clone, Copy, Debug, Pod, Zeroable)]
pub(super) struct ItemRecord {
    pub(super) key: u64,
    pub(super) sector_from_item: [[f32; 3]; 4],
    /// By its index in the meshes of the room.
    pub(super) mesh: u32,
    /// Length of its name, in bytes. Names follow each other.
    pub(super) name: u32,
    pub(super) layers: u32,
    pub(super) max_distance: f32,
    pub(super) min_size_px: f32,
    /// Bits: 1 occluder, 2 drawn, 4 never culled.
    pub(super) flags: u32,
}

const IS_OCCLUDER: u32 = 1;
const IS_DRAWN: u32 = 2;
const NEVER_CULL: u32 = 4;

impl ItemRecord {
    pub(super) fn options(&self) -> ItemOptions {
        let has = |flag| self.flags & flag != 0;
        ItemOptions {
            is_occluder: has(IS_OCCLUDER),
            is_drawn: has(IS_DRAWN),
            never_cull: has(NEVER_CULL),
            layers: self.layers,
            max_distance: self.max_distance,
            min_size_px: self.min_size_px,
        }
    }
}

/// Returns the flags of an item.
pub(super) fn flags(options: &ItemOptions) -> u32 {
    let flag = |flag, is_set| if is_set { flag } else { 0 };
    flag(IS_OCCLUDER, options.is_occluder)
        | flag(IS_DRAWN, options.is_drawn)
        | flag(NEVER_CULL, options.never_cull)
}
