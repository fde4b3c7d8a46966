//! Reads scenes from files: glTF 2.0, as `.glb` and as `.gltf` with its buffers beside it or inside it; OBJ, with its MTL files
//! and their images beside it; compiled maps of Quake and Quake 3; and terrain, as heights with a JSON file that describes them.
//!
//! ```
//! use enfilade::{SectorId, Method};
//! use enfilade_import::{ReadOptions, read_bytes};
//!
//! let file = br#"{
//!     "asset": { "version": "2.0" },
//!     "nodes": [{ "name": "Leaf", "mesh": 0, "translation": [0, 2, 0] }],
//!     "meshes": [{ "primitives": [{ "attributes": { "POSITION": 0 } }] }],
//!     "accessors": [{ "bufferView": 0, "componentType": 5126, "type": "VEC3", "count": 3 }],
//!     "bufferViews": [{ "buffer": 0, "byteLength": 36 }],
//!     "buffers": [{ "byteLength": 36, "uri":
//!         "data:application/octet-stream;base64,AAAAAAAAAAAAAAAAAACAPwAAAAAAAAAAAAAAAAAAgD8AAAAA" }]
//! }"#;
//! let leaf = read_bytes(file, None, &ReadOptions::default())?;
//! assert_eq!(leaf.rooms[0].geometry.triangle_count(), 1);
//! assert_eq!(leaf.rooms[0].geometry.bounds().max, [1.0, 3.0, 0.0]);
//! let scene = leaf.scene(Method::HierarchicalZ, Method::DEFAULT_LIMIT)?;
//! assert_eq!(scene.sector_name(SectorId(0)), "scene");
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```
//!
//! Each node with a mesh becomes an item, and nodes that share a mesh share it here too. What an author marked, by the
//! endings of names or in `extras.enfilade`, becomes rooms, portals between them, and mirrors:
//!
//! | a node's name ends in | `extras.enfilade` | it is |
//! |---|---|---|
//! | `-room` | `{"kind": "room", "method": "bsp"}` | a room: what is below it, up to rooms nested in it, is a sector |
//! | `-portal` | `{"kind": "portal", "to": "Hall-room", "one_way": true}` | a flat convex mesh to look through |
//! | `-portal` | `{"kind": "portal", "exit": "NODE"}` | the same as a teleport: in along its −Z, out along the exit's |
//! | `-mirror` | `{"kind": "mirror"}` | a flat convex mesh that mirrors its room |
//! | `-terrain` | `{"kind": "terrain"}` | a mesh that is a grid of heights, for the method `floating-horizon` |
//!
//! The name or the extras are enough, Blender's `.001` may follow, and 1 counts as true. All rooms share world space.
//! Which two rooms a portal joins is found from what stands at its two sides, unless `to` says it; the room that it is
//! parented to comes first where it is one of them. A room without a top, as a garden or a courtyard, extends upwards (+Y) without
//! end: an opening with nothing but sky at one side, as a roof window, leads to the smallest such room below. Scales of a portal and its exit do not count in a teleport, which moves
//! and turns only. What stands in no room is one more room.
//!
//! Terrain is a mesh, y up in its own space, whose corners stand where columns of one x and rows of one z cross, with one height
//! at each place and every cell cut in two triangles that face up, all along the same diagonal; one material, no skeleton, no
//! morph targets, no instances. Its blocks of 32 by 32 cells are items, `Hill-terrain 3 7`: the fourth row from the north, the
//! eighth block from the west. Triangles stay where they are, to the bit, with their places in textures, colors and
//! normals; steps may differ, and corners may be there more than once. Where those at one place have different normals, faces are
//! flat. Where no corner of a column has quite the same x, as in a grid that was turned before it was exported, they go to the
//! least, which is within 2⁻²² of the greatest x or z. What is no such grid is an error that names the place.
//!
//! Of an OBJ file each `o` and `g` that has faces is an item, all in one room: OBJ has no tree of nodes, so it cannot say
//! what stands in a room. Polygons of any shape are cut into triangles. Materials are seen from both sides, `d` and `Tr` make
//! glass, an image that is both `map_Kd` and `map_d` cut-outs. Colors of materials are taken as linear, those of positions as
//! they look on a screen. Nothing outside the file's folder is read.
//!
//! Of a compiled map (`.bsp`: BSP29 and BSP2 of Quake, IBSP46 of Quake 3) the faces of the world are items by the leafs that
//! show them, `leaf 12`, or the clusters, `cluster 12`; where several sets of leafs begin with one, the second is `leaf 12.2`.
//! Doors, lifts and what else moves are items of their own, `func_door gate#34`: what it is, how others call it, and its number
//! among the map's entities. What engines do not draw is left out; sky is an opaque face, for it bounds the world. Places where
//! players start are cameras, lights are lamps. Faces with lightmaps show those instead of lamps. What is visible from where, if
//! that has been computed, becomes the geometry's [cells](enfilade::Geometry::cells). Z is up in maps: x stays x, their z is our
//! y, their y our −z; lengths stay theirs. The images of their textures lie in files of the game, so colors are made up by
//! their names.
//!
//! Of a map for Quake or Quake 3 [`read_portals`] reads the `.prt` that its compiler leaves beside it: the convex cells that
//! `enfilade_bake` computes the visible pairs of, which [`with_visibility`] puts into the map, and [`with_ambient_sounds`] what is
//! heard in each leaf. Where the `.prt` is lost,
//! [`rebuild_portals`] makes it again out of the map.
//!
//! Terrain is a file of heights, of 16 bits or of 32, and a JSON file beside it, which is the one to be read; see [`TerrainError`] for what it must
//! say. Its blocks of 32 by 32 cells are items, `block 3 7`: the fourth row from the north, the eighth block from the west. The
//! diagonal of each cell goes from the corner north-east to the one south-west, unless it says otherwise. x goes east, z south, y up; metres.
//!
//! What is read of how a glTF scene looks: colors and images on faces (PNG and JPEG; in the file, beside it, or in an
//! address), their samplers, cut-outs and glass, light that things send out, normals and colors of corners, lights, and
//! cameras, also orthographic ones ([`Camera`]). Numbers may be sparse, quantized or compressed. Of extensions these are read:
//!
//! | extension | what becomes of it |
//! |---|---|
//! | `EXT_mesh_gpu_instancing` | each instance is an item, `NAME[7]` |
//! | `EXT_meshopt_compression`, `KHR_meshopt_compression` | decoded |
//! | `KHR_lights_punctual` | [`Import::lights`]; a light stands in the room above its node, else in the smallest around it |
//! | `KHR_materials_emissive_strength`, `KHR_materials_unlit` | as they say |
//! | `KHR_materials_transmission` | glass that is seen through by nine tenths of what it transmits |
//! | `KHR_mesh_quantization` | as it says |
//! | `KHR_texture_transform` | the coordinates of corners are those after it |
//!
//! A file that requires another one is refused; one that only uses it is read, with a warning. What is not drawn or not read
//! yet (skins, animations, maps of metal and roughness) is named in [`Import::warnings`], never silently dropped. An image
//! that cannot be had is grey, and a warning says why. A file that breaks a rule, however it does, gives an [`ImportError`]
//! that names the place and the rule.
// Not forbidden, for `terrain/map.rs` allows it, in one function.
#![cfg_attr(docsrs, feature(doc_cfg))]
#![deny(unsafe_code)]

mod authoring;
mod budget;
mod camera;
mod error;
mod faults;
mod gltf;
mod images;
#[cfg(feature = "levels")]
mod levels;
mod obj;
mod pin;
mod quake;
mod rooms;
mod source_nodes;
mod spoken;
mod terrain;
mod warning;

pub use authoring::AuthoringError;
pub use camera::Camera;
pub use error::{BrokenRule, ImportError};
pub use faults::AuthoringErrors;
pub use gltf::link::{LinkError, Linked, Linker, NodeId, PartId, Placing, Shape};
#[cfg(feature = "levels")]
pub use levels::{Levels, details_of};
pub use obj::ObjError;
pub use pin::{PinError, with_methods};
pub use quake::{
    AmbientLeafs, AmbientSounds, BspError, ClustersFrom, MapSummary, PlacedPortals, PortalFile, PrtError,
    PrtKind, RebuiltPortals, place_portals, read_portals, rebuild_portals, rebuild_portals_bytes,
    visibility_bytes, with_ambient_sounds, with_visibility,
};
pub use source_nodes::SourceNodes;
pub use terrain::{GridError, GridPlace, TerrainError};
pub use warning::{Warning, WarningKind};

use budget::Budget;
use enfilade::{Geometry, LargeTerrain, Light, Method, Portal, Scene, SceneBuilder, SceneError};
use std::ffi::OsStr;
use std::fs::File;
use std::io::Read;
use std::path::{Path, PathBuf};
use std::sync::Arc;

/// What a file holds.
#[derive(Debug)]
pub struct Import {
    /// The rooms of the file's default scene, all in world space: y up, metres unless the file's author thought
    /// otherwise. At least one; exactly one where none is marked, or where the file was read as [flat](ReadOptions::flat).
    ///
    /// An item is named for its node, `NAME#nodeIndex` where nodes with meshes share the name, `node#12` where it
    /// has none; of several instances each has its number behind that, `NAME[7]`; of an OBJ file for its group,
    /// `NAME#itemIndex` where groups share the name, `default` where it has none; of a map for what shows it. No two items of a
    /// file have the same name.
    pub rooms: Vec<Room>,
    /// The ways between them; [`SectorId`](enfilade::SectorId) n is room n. A door is two, a mirror one that reflects.
    pub portals: Vec<Portal>,
    /// The cameras of that scene, in the order of their nodes, named as items are.
    pub cameras: Vec<Camera>,
    /// Its lights, each in the room that it stands in. Their colors are in the units of the file, whatever its author meant by
    /// them: whoever draws chooses an exposure.
    pub lights: Vec<Light>,
    /// What only a compiled map has; `None` of other files.
    pub map: Option<MapSummary>,
    /// What the file has that was not read, or that is odd: one warning of each kind, worst first; but one of each portal that was
    /// [skipped](ReadOptions::skip_bad_portals).
    pub warnings: Vec<Warning>,
    /// The other files that it names, read or not: buffers, images, materials, heights. Whoever writes files should write
    /// none of these.
    pub files: Vec<PathBuf>,
}

/// A sector of a file.
#[derive(Clone, Debug)]
pub struct Room {
    /// How its author called it; the file's name without its ending (`scene` for bytes) where nobody marked it.
    pub name: String,
    /// What stands in it, and its openings, which are named for the nodes of their portals.
    pub geometry: Arc<Geometry>,
    /// Which nodes of a glTF file those items come from; empty for other files.
    pub nodes: SourceNodes,
    /// How it is to be seen, where its author says so.
    pub method: Option<Method>,
    /// It has no top, as a garden or a courtyard: what is above it, however far, is in it.
    pub open_above: bool,
    /// Terrain that would not have fit in memory as meshes: then `geometry` holds nothing, and this is the sector, whatever
    /// `method` says.
    pub large: Option<Arc<LargeTerrain>>,
}

impl Import {
    /// The rooms joined by their portals. Where a room says no method it is seen by `method`; what that builds may take
    /// `limit_bytes` in each room.
    ///
    /// # Errors
    /// [`SceneError::TooLarge`], and [`SceneError::NotConvex`] or [`SceneError::NotBaked`] where a room says a method that does
    /// not suit it.
    pub fn scene(&self, method: Method, limit_bytes: u64) -> Result<Scene, SceneError> {
        let mut builder = SceneBuilder::new();
        builder.limit_bytes(limit_bytes);
        for room in &self.rooms {
            if let Some(large) = &room.large {
                builder.add_custom(&room.name, Arc::clone(large) as _);
                continue;
            }
            let id = builder.add(
                &room.name,
                Arc::clone(&room.geometry),
                room.method.unwrap_or(method),
            );
            if room.open_above {
                builder.open_above(id);
            }
        }
        for portal in &self.portals {
            builder.portal((portal.from, portal.opening), portal.to, portal.there_from_here);
        }
        for &light in &self.lights {
            builder.light(light);
        }
        builder.build()
    }
}

/// How a file is read.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct ReadOptions {
    /// Bytes that reading may take, file included. What would take more, by an estimate made before anything is
    /// allocated, is refused. 1 GiB unless told: enough for some 10 million triangles, each stored once.
    ///
    /// Only terrain described by a JSON file is not: what would take more stays in its file, which is then mapped into memory
    /// ([`Room::large`]). Nobody must cut that file off or write into it until the room is dropped.
    pub limit_bytes: u64,
    /// Take everything as one room: portals are plain holes, and a mirror is what its mesh is. Where rooms and portals are
    /// is not asked then, so a file in which they make no sense can still be looked at.
    pub flat: bool,
    /// Leave out portals and mirrors that do not make sense, each with a warning: they become plain holes. Otherwise such a
    /// file is refused.
    pub skip_bad_portals: bool,
    /// Read images on faces? Who only asks what can be seen needs none, and reads faster without.
    pub textures: bool,
}

impl Default for ReadOptions {
    fn default() -> ReadOptions {
        ReadOptions {
            limit_bytes: 1 << 30,
            flat: false,
            skip_bad_portals: false,
            textures: true,
        }
    }
}

/// Reads a file of any kind. Its first bytes say what it is, not its name; but OBJ files may begin with anything, so what is none of the
/// others is OBJ where it is called so, or begins with positions, materials or comments before them.
///
/// # Errors
/// An [`ImportError`] for the first broken rule that is met; the same one every time. Of what is wrong with rooms, portals and
/// terrain it holds all ([`AuthoringErrors`]).
pub fn read(path: &Path, options: &ReadOptions) -> Result<Import, ImportError> {
    read_file(path, options, |bytes, name, budget| {
        let is_called_obj = path
            .extension()
            .is_some_and(|ending| ending.eq_ignore_ascii_case("obj"));
        import(bytes, path.parent(), name, is_called_obj, options, budget)
    })
}

/// Reads a file that must be glTF.
fn read_gltf(path: &Path, options: &ReadOptions) -> Result<Import, ImportError> {
    read_file(path, options, |bytes, name, budget| {
        gltf::import(bytes, path.parent(), &name.to_string_lossy(), options, budget)
    })
}

/// Reads the bytes of a file, and what they hold by `import`, which gets the file's name without its ending.
fn read_file<T>(
    path: &Path,
    options: &ReadOptions,
    import: impl FnOnce(&[u8], &OsStr, Budget) -> Result<T, BrokenRule>,
) -> Result<T, ImportError> {
    let failed = |rule| ImportError {
        file: path.display().to_string(),
        rule,
    };
    let mut budget = Budget::new(options.limit_bytes);
    let bytes = read_regular_file(path, None, &|| "the file".to_owned(), &mut budget).map_err(failed)?;
    let name = path.file_stem().unwrap_or(OsStr::new("scene"));
    import(&bytes, name, budget).map_err(failed)
}

/// Reads the bytes of a file. `folder` is where the files lie that it names; with `None`, naming a buffer is an error, and an
/// image or a file of materials a warning.
///
/// # Errors
/// As [`read`].
pub fn read_bytes(bytes: &[u8], folder: Option<&Path>, options: &ReadOptions) -> Result<Import, ImportError> {
    let failed = |rule| ImportError {
        file: "the bytes given".to_owned(),
        rule,
    };
    let mut budget = Budget::new(options.limit_bytes);
    budget
        .take(bytes.len() as u64, || "the file".to_owned())
        .map_err(failed)?;
    import(bytes, folder, OsStr::new("scene"), false, options, budget).map_err(failed)
}

/// Finds out what the bytes are, and reads them. OBJ has no first bytes of its own, so what is not clearly something else
/// is taken for OBJ where it is called so.
fn import(
    bytes: &[u8],
    folder: Option<&Path>,
    name: &OsStr,
    is_called_obj: bool,
    options: &ReadOptions,
    budget: Budget,
) -> Result<Import, BrokenRule> {
    if terrain::describes_terrain(bytes) {
        return terrain::import(bytes, folder, name, options, budget);
    }
    let name = &*name.to_string_lossy();
    if gltf::begins_like_gltf(bytes) {
        return gltf::import(bytes, folder, name, options, budget);
    }
    if quake::begins_like_map(bytes) {
        return quake::import(bytes, name, options, budget);
    }
    let may_be_obj = !bytes.is_empty() && (is_called_obj || obj::begins_like_obj(bytes));
    if may_be_obj && let Some(import) = obj::import(bytes, folder, name, options, budget)? {
        return Ok(import);
    }
    Err(BrokenRule::UnknownFormat {
        begins: gltf::beginning(bytes),
    })
}

/// The first `most` bytes of a file, or all. Never waits on a pipe, and never reads more than the budget allows.
fn read_regular_file(
    path: &Path,
    most: Option<u64>,
    place: &dyn Fn() -> String,
    budget: &mut Budget,
) -> Result<Vec<u8>, BrokenRule> {
    // Asked before opening: a pipe without a writer would not open until someone writes.
    if !std::fs::metadata(path).map_err(BrokenRule::Unreadable)?.is_file() {
        return Err(BrokenRule::NotAFile);
    }
    let file = File::open(path).map_err(BrokenRule::Unreadable)?;
    let there = file.metadata().map_err(BrokenRule::Unreadable)?.len();
    let wanted = most.map_or(there, |most| most.min(there));
    budget.take(wanted, place)?;
    let mut bytes = Vec::new();
    let no_room = |_| BrokenRule::Unreadable(std::io::ErrorKind::OutOfMemory.into());
    bytes.try_reserve_exact(wanted as usize).map_err(no_room)?;
    file.take(wanted)
        .read_to_end(&mut bytes)
        .map_err(BrokenRule::Unreadable)?;
    Ok(bytes)
}
