//! Reads 3D scenes from files as [`enfilade`] scenes, with their rooms, portals, materials, cameras and lights.
//!
//! Formats: glTF 2.0 (`.glb`, or `.gltf` with embedded or separate buffers); OBJ with its MTL files and images;
//! tiles of 3D Tiles (`.b3dm`, `.i3dm`); compiled maps of Quake and Quake 3 (`.bsp`); terrain as a raw heightmap with a JSON description; baked scenes (`.enf`).
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
//! # What hides
//!
//! A surface hides others only if the file says for sure that it is opaque, that it is drawn, and where. Everything else is visible
//! like any other item, and hides nothing:
//!
//! | format | hides nothing |
//! |---|---|
//! | glTF | skinned and morphed meshes, which are drawn in the pose that the file stores; nodes that an animation moves or shows, with those below them; nodes with levels of detail; alpha test and blend; transmission, volume, diffuse transmission, dispersion; materials that an animation changes; meshes with a variant that is not opaque |
//! | OBJ | `d` below 1, `Tr` above 0 (unless `d` says otherwise), `d -halo`, `map_d`, a filter color `Tf`, `illum` 4, 6, 7 and 9, lines about opacity that cannot be read, materials that are not defined |
//! | Quake | liquids and teleporters, which engines may draw translucent; textures `{…`; brush entities that may move or vanish, or have `alpha`, `renderamt`, `rendermode` or `renderfx` |
//! | Quake 3 | liquids, glass, sky; textures whose contents are not solid or are translucent, or whose surface is not solid; shaders with `blendFunc`, `alphaFunc`, `deformVertexes` (such items are never culled either), `surfaceparm trans`, `cull none` or `cull back` in the `.shader` files beside the map, in `scripts` there, or in `scripts` beside its folder |
//!
//! [`Room::non_occluders`] says why each of them hides nothing; so do `enfilade info` and `enfilade look --non-occluders`.
//!
//! `extras.enfilade` of a glTF node says `{"occluder": false}` for what shall hide nothing, with all nodes below it, and
//! `{"occluder": true}` for an animated, skinned or morphed mesh that may hide in the pose that the file stores; never for alpha.
//!
//! # glTF
//!
//! Each node with a mesh becomes an item; nodes that share a mesh still share it after import. Node names or
//! `extras.enfilade` mark rooms, portals, mirrors and terrain:
//!
//! | node name ends in | `extras.enfilade` | meaning |
//! |---|---|---|
//! | `-room` | `{"kind": "room", "method": "bsp"}` | a room: the node's descendants, except nested rooms, form a sector |
//! | `-portal` | `{"kind": "portal", "to": "Hall-room", "one_way": true}` | a portal: a flat convex mesh is its polygon |
//! | `-portal` | `{"kind": "portal", "exit": "NODE"}` | a teleport portal: enters along the node's −Z, leaves along the exit's −Z |
//! | | `{"kind": "portal", "exit": "NODE", "scale": 8}` | the same; the target appears 8 times smaller than it is |
//! | `-mirror` | `{"kind": "mirror"}` | a flat convex mesh that mirrors its room |
//! | `-terrain` | `{"kind": "terrain"}` | a heightfield mesh (regular grid) for the method `floating-horizon` |
//! | | `{"kind": "door"}` | the leaf of a door: it can move, which only [`SceneRoomItems`] cares about |
//!
//! A portal, mirror or terrain without a mesh has the meshes of all nodes below it, except those of other marked nodes and of what
//! is below these: packers put a mesh one node below its name, and authors mark an empty. Together they must be one flat convex
//! polygon; terrain must have one mesh. Room, direction and exit are those of the marked node.
//!
//! Either the name or the extras suffice. Blender's numeric suffix (`.001`) is ignored, and 1 counts as `true`. All
//! rooms share world space. The importer finds the two rooms that a portal joins from the geometry on its two sides,
//! unless `to` names one; if the portal's parent room is among the candidates, or is around the portal and `to` names
//! the other, it takes precedence. A room without a
//! ceiling, such as a garden or a courtyard, extends upwards (+Y) without bound: an opening with only sky on one side,
//! such as a roof window, leads to the smallest such room below it. A teleport uses only the translation and rotation
//! of the portal and its exit; it ignores the scales of their nodes, and enlarges what passes only by `scale`. So a
//! doll's house in a room is a set of rooms elsewhere in the file, in full size: a portal with `scale` leads into it,
//! and one with the inverse back. Nodes outside every room form one additional room.
//!
//! A terrain mesh is a heightfield with y up in object space. Its vertices are at the intersections of grid columns
//! (constant x) and rows (constant z), with one height per grid point. Every cell is split into two upward-facing
//! triangles, all along the same diagonal. It has one material, no skin, no morph targets and no instances. Its blocks
//! of 32×32 cells become items: `Hill-terrain 3 7` is the fourth row from the north and the eighth block from the west.
//! Vertex positions stay bit-exact, and texture coordinates, colors and normals are kept. Grid steps may vary, and
//! vertices may be duplicated; where duplicates have different normals, faces are flat shaded. If the vertices of a
//! column differ slightly in x, as in a grid that was rotated before export, all of them snap to the minimum; the
//! tolerance is 2⁻²² of the maximum x or z. Any other mesh is an error that names the offending grid point.
//!
//! # OBJ
//!
//! Each `o` or `g` that has faces becomes an item, all in one room: OBJ has no node hierarchy, so it cannot mark rooms.
//! OBJ tells neither its up axis nor its unit, and coordinates stay as they are in the file; [`detect_scene_up`] and
//! [`detect_scene_unit`] find them from the floors. Polygons of any shape are triangulated. Materials are double-sided. `d` and `Tr` make a material alpha-blended; an
//! image that is both `map_Kd` and `map_d` makes it alpha-tested. Material colors are read as linear, vertex colors as
//! sRGB. Nothing outside the file's folder is read.
//!
//! # 3D Tiles
//!
//! Supported: Batched and Instanced 3D Models of 3D Tiles 1.0 (`.b3dm`, also with one of the two older headers, and `.i3dm`).
//! A tile is one room, with the y up of its glTF: what the tile's feature table says with z up is turned, so x stays x, z
//! becomes y, and y becomes −z. `RTC_CENTER` moves the model. Each instance of an `.i3dm` is an item for each item of its model,
//! `NAME[7]`: `POSITION` or `POSITION_QUANTIZED`, `NORMAL_UP` and `NORMAL_RIGHT` (also `_OCT32P`) or `EAST_NORTH_UP`, `SCALE` and
//! `SCALE_NON_UNIFORM` are applied. Batch tables, and the transforms of a tileset, are not read.
//!
//! Tiles are often at the surface of the Earth, with coordinates from its centre, where 32-bit floats are half a metre apart. A
//! tile whose `RTC_CENTER` or first instance is more than 16,384 m from the origin is therefore placed relative to it, and
//! [`WarningKind::FarOrigin`] names it.
//!
//! # Quake maps
//!
//! Supported: BSP29 and BSP2 (Quake), IBSP46 (Quake 3). World faces become items, one for each set of leafs (`leaf 12`)
//! or clusters (`cluster 12`) that lists them; of several sets that begin with the same leaf, the second is `leaf
//! 12.2`. Brush entities such as doors and lifts become separate items: `func_door gate#34` is the class name, the
//! target name and the entity index. Faces that engines do not draw are left out. Sky is an opaque face in maps of Quake, because
//! it bounds the world. Player starts become cameras and light entities become lights; faces with lightmaps use those
//! instead of the lights. The PVS, if the file has one, becomes the geometry's [baked
//! cells](enfilade::Geometry::cells). Maps have Z up: x stays x, their z becomes y, and their y becomes −z; units are
//! unchanged. The images of their textures are in other game files, so colors are derived from the texture names.
//!
//! [`read_portals`] reads the `.prt` file that a map compiler writes beside the map: the convex cells between which
//! `enfilade_bake` computes the PVS. [`with_visibility`] writes that PVS into the map, and [`with_ambient_sounds`]
//! writes the ambient sound levels of each leaf. If the `.prt` is missing, [`rebuild_portals`] reconstructs it from the
//! map.
//!
//! # Terrain
//!
//! A raw heightmap (16 or 32 bits per height) with a JSON description; read the JSON file. [`TerrainError`] lists what
//! the description must contain. Blocks of 32×32 cells become items: `block 3 7` is the fourth row from the north and
//! the eighth block from the west. The diagonal of each cell runs from its north-east to its south-west corner, unless
//! the description says otherwise. x points east, z south and y up; units are metres.
//!
//! # Baked scenes
//!
//! [`bake`] writes what was read as a baked scene (`.enf`). [`read`] maps it into memory, uses its meshes in place, and returns
//! the same [`Import`]. Do not truncate or write the file until everything read from it is dropped: write a new one and rename
//! it. [`Pages`] reads its meshes one group at a time.
//!
//! # What is read of glTF
//!
//! Base color and emissive textures (PNG and JPEG; embedded, in separate files, or data URIs), samplers, alpha test and
//! alpha blend, emission, vertex normals and colors, lights, and perspective and orthographic cameras ([`Camera`]).
//! Accessors may be sparse, quantized or compressed.
//!
//! Skins and morph targets are applied in the pose that the file stores: the transforms of the joints' nodes, and the `weights` of
//! the node or else of its mesh; first the targets, then the joints, of any number of sets. A skinned mesh is where its joints
//! are, whatever the transform of its node. Nodes with different skins or weights get copies of their mesh. Weights of joints are
//! divided by their sum; a vertex without any follows its first joint.
//!
//! Supported extensions:
//!
//! | extension | result |
//! |---|---|
//! | `EXT_mesh_gpu_instancing` | each instance is an item, `NAME[7]` |
//! | `EXT_meshopt_compression`, `KHR_meshopt_compression` | decoded |
//! | `KHR_animation_pointer` | what it changes hides nothing |
//! | `KHR_lights_punctual` | [`Import::lights`]; a light belongs to the room above its node, otherwise to the smallest room around it |
//! | `KHR_materials_diffuse_transmission`, `_dispersion`, `_subsurface`, `_volume`, `_volume_scatter` | such materials hide nothing |
//! | `KHR_materials_emissive_strength`, `KHR_materials_unlit` | applied |
//! | `KHR_materials_transmission` | alpha-blended; 90 % of the transmission factor becomes transparency |
//! | `KHR_materials_variants` | drawn as by default; hides only if all variants are opaque |
//! | `KHR_mesh_quantization` | decoded |
//! | `KHR_node_visibility` | an invisible node and those below it are not drawn; marks of rooms and portals count all the same |
//! | `KHR_texture_transform` | applied to the texture coordinates |
//! | `MSFT_lod` | the finest level of nodes and materials is drawn, and hides nothing |
//!
//! Extensions of textures, shading and metadata are ignored with a warning, also if a file requires them. A file that requires one
//! without which shapes would be wrong, or an unknown one, is an error, unless it is read as [lenient](ReadOptions::lenient). If it
//! is, or the file only uses the extension, there is a warning, and what the extension may change hides nothing: the nodes, meshes
//! and materials that carry it, with all below such nodes; or everything, if nothing carries it, or something else does than
//! nodes, meshes, materials, textures, cameras and lights.
//! [`Import::warnings`] names everything that is not drawn or not supported yet (animations, metallic-roughness
//! textures). An image that cannot be read becomes grey, with a warning that gives the reason. A file that violates a
//! rule returns an [`ImportError`] that names the element and the rule.
// `deny`, not `forbid`: one function in `map.rs` needs an exception to map a file into memory.
#![cfg_attr(docsrs, feature(doc_cfg))]
#![deny(unsafe_code)]

mod authoring;
mod budget;
mod enf;
mod error;
mod faults;
mod gltf;
mod images;
#[cfg(feature = "levels")]
mod levels;
mod map;
mod non_occluders;
mod obj;
mod other_format;
mod pin;
mod quake;
mod room_items;
mod rooms;
mod source_nodes;
mod spoken;
mod terrain;
mod tiles;
mod upright;
mod warning;

pub use authoring::AuthoringError;
pub use enf::{BakeError, BakedSections, Baker, EnfError, Hint, Pages, SectionTotal, bake, bake_hints};
pub use error::{BrokenRule, ImportError};
pub use faults::AuthoringErrors;
pub use gltf::link::{LinkError, Linked, Linker, NodeId, PartId, Placing, Shape};
#[cfg(feature = "levels")]
pub use levels::{Levels, details_of};
pub use non_occluders::{NonOccluder, NonOccluders};
pub use obj::ObjError;
pub use pin::{PinError, with_methods};
pub use quake::{
    AmbientLeafs, AmbientSounds, BspError, ClustersFrom, Leak, MapSummary, PlacedPortals, PortalFile,
    PrtError, PrtKind, RebuiltPortals, find_leak, place_portals, read_portals, rebuild_portals,
    rebuild_portals_bytes, visibility_bytes, with_ambient_sounds, with_visibility,
};
pub use room_items::{SceneRoomItems, authored_doors};
pub use source_nodes::SourceNodes;
pub use terrain::{GridError, GridPlace, TerrainError};
pub use tiles::TileError;
pub use upright::{detect_scene_unit, detect_scene_up, survey_options};
pub use warning::{Warning, WarningKind};

use budget::Budget;
use enfilade::{
    Camera, Geometry, ItemIndex, LargeTerrain, Light, Method, Portal, Scene, SceneBuilder, SceneError,
};
use std::ffi::OsStr;
use std::fs::File;
use std::io::Read;
use std::path::{Path, PathBuf};
use std::sync::Arc;

/// The contents of a file.
#[derive(Debug)]
pub struct Import {
    /// The rooms of the file's default scene, all in world space: y up, in metres unless the author used another unit.
    /// At least one. Exactly one if no room is marked or the file was read as [flat](ReadOptions::flat).
    ///
    /// Item names are unique in a file. glTF: the node's name, `NAME#nodeIndex` if several nodes with meshes share that
    /// name, `node#12` if it has none; instances append their index, `NAME[7]`. OBJ: the group's name, `NAME#itemIndex`
    /// if several groups share it, `default` if it has none. Quake maps: the leafs, the cluster or the entity.
    pub rooms: Vec<Room>,
    /// The portals between the rooms; [`SectorId`](enfilade::SectorId) n is room n. A door makes two portals, a mirror
    /// one that reflects.
    pub portals: Vec<Portal>,
    /// The cameras of the default scene, in node order, named like items.
    ///
    /// A view has a perspective projection, so an orthographic camera becomes one with a narrow field of view, far behind its
    /// position in the file. Its sector is set, because that position does not tell it.
    pub cameras: Vec<Camera>,
    /// For each camera the height of its view volume, in scene units, if it is orthographic in the file.
    pub orthographic_heights: Vec<Option<f32>>,
    /// The lights, each with the room that contains it. Colors keep the units of the file; the renderer chooses an
    /// exposure.
    pub lights: Vec<Light>,
    /// The scenes of the file, in file order; empty if the format has none, or the file lists none.
    pub scenes: Vec<FileScene>,
    /// Data that only compiled maps have; `None` for other formats.
    pub map: Option<MapSummary>,
    /// Everything in the file that was not read or looks wrong: one warning per kind, worst first, but one for each
    /// [skipped](ReadOptions::skip_bad_portals) portal.
    pub warnings: Vec<Warning>,
    /// The other files that this file references, read or not: buffers, images, materials, heights. Check output paths
    /// against this list to avoid overwriting a source.
    pub files: Vec<PathBuf>,
}

/// A scene of a file.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct FileScene {
    /// Its name; empty if it has none.
    pub name: String,
    /// Whether the file names it as its default scene.
    pub is_default: bool,
    /// Whether it was read.
    pub is_read: bool,
}

/// A room of a file; it becomes a sector of the scene.
#[derive(Clone, Debug)]
pub struct Room {
    /// Name of the room's node; the file stem (`scene` for bytes) if the file marks no room.
    pub name: String,
    /// The room's items and openings; an opening is named after its portal's node.
    pub geometry: Arc<Geometry>,
    /// The glTF nodes that the items come from; empty for other formats.
    pub nodes: SourceNodes,
    /// Why items and materials hide nothing.
    pub non_occluders: NonOccluders,
    /// The visibility method that the author chose for this room, if any.
    pub method: Option<Method>,
    /// Whether the room has no ceiling, such as a garden or a courtyard: it contains everything above it, at any
    /// height.
    pub open_above: bool,
    /// Terrain too large to fit in memory as meshes. If present, it is the sector, `geometry` is empty and `method` is
    /// ignored.
    pub large: Option<Arc<LargeTerrain>>,
}

impl Room {
    /// Creates a room without a chosen method, for an [`Import`] of your own.
    pub fn new(name: &str, geometry: impl Into<Arc<Geometry>>) -> Room {
        Room {
            name: name.to_owned(),
            geometry: geometry.into(),
            nodes: SourceNodes::default(),
            non_occluders: NonOccluders::default(),
            method: None,
            open_above: false,
            large: None,
        }
    }
}

impl Import {
    /// Creates an import of rooms alone, such as to [`bake`] a scene that is in no file. There must be at least one.
    pub fn of_rooms(rooms: Vec<Room>) -> Import {
        Import {
            rooms,
            portals: Vec::new(),
            cameras: Vec::new(),
            orthographic_heights: Vec::new(),
            lights: Vec::new(),
            scenes: Vec::new(),
            map: None,
            warnings: Vec::new(),
            files: Vec::new(),
        }
    }

    /// Returns `true` if the format says which way is up: y, once read. OBJ does not, nor do scenes baked from it; their
    /// coordinates are those of the file, and [`detect_scene_up`] finds the axis from the floors.
    pub fn tells_up(&self) -> bool {
        let has_nodes = |room: &Room| room.nodes.node(ItemIndex(0)).is_some();
        let is_terrain = |room: &Room| room.large.is_some() || !room.geometry.terrains().is_empty();
        let mut rooms = self.rooms.iter();
        self.map.is_some() || rooms.any(|room| has_nodes(room) || is_terrain(room))
    }

    /// Builds a scene from the rooms and their portals. Rooms without a chosen method use `method`. The data structures
    /// that a method builds may take up to `limit_bytes` per room.
    ///
    /// # Errors
    /// [`SceneError::Unsuited`] if a room exceeds `limit_bytes`, or its geometry does not meet the requirement of its
    /// method.
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

/// Options of [`read`] and [`read_bytes`].
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct ReadOptions {
    /// Maximum memory for reading, in bytes, including the file itself. A file that would take more, by an estimate
    /// made before anything is allocated, is an error. Default: 1 GiB, enough for about 10 million triangles, each
    /// stored once.
    ///
    /// Exception: terrain with a JSON description that would take more stays in its file, which is mapped into memory
    /// ([`Room::large`]). Do not truncate or write that file until the room is dropped.
    pub limit_bytes: u64,
    /// Read everything as one room: portals become plain holes and mirrors ordinary meshes. Marked rooms and portals
    /// are not validated, so a file in which they are wrong can still be viewed. Default: `false`.
    pub flat: bool,
    /// Skip invalid portals and mirrors, each with a warning; they become plain holes. Otherwise such a file is an
    /// error. Default: `false`.
    pub skip_bad_portals: bool,
    /// The scene of a glTF file to read, by name or index; a name goes before an index. Default: `None`, the file's default
    /// scene. Other formats have no scenes, so it is an error there.
    pub scene: Option<String>,
    /// Read glTF files that require unsupported extensions, as far as possible: primitives whose compression is not
    /// supported are left out, with a warning, and what the extensions may change hides nothing. Default: `false`, an
    /// error.
    pub lenient: bool,
    /// Whether to read textures. Visibility queries need none, and reading is faster without them. Default: `true`.
    pub textures: bool,
}

impl Default for ReadOptions {
    fn default() -> ReadOptions {
        ReadOptions {
            limit_bytes: 1 << 30,
            flat: false,
            skip_bad_portals: false,
            scene: None,
            lenient: false,
            textures: true,
        }
    }
}

/// Reads a file of any supported format. The first bytes decide the format, not the file name. OBJ files may begin with
/// anything, so a file of no other format is OBJ if its extension is `.obj`, or if it begins with positions, materials
/// or comments before them.
///
/// # Errors
/// Returns an [`ImportError`] for the first violated rule, deterministically. Errors in rooms, portals and terrain are
/// collected and returned together ([`AuthoringErrors`]).
pub fn read(path: &Path, options: &ReadOptions) -> Result<Import, ImportError> {
    if let Some(baked) = enf::read(path, options) {
        let baked = without_scenes(options).and(baked);
        return baked.map_err(|rule| ImportError {
            file: path.display().to_string(),
            rule,
        });
    }
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
        if let Some(refusal) = other_format::refusal(bytes) {
            return Err(refusal);
        }
        gltf::import(bytes, path.parent(), &name.to_string_lossy(), options, budget)
    })
}

/// Reads the bytes of a file and passes them to `import`, together with the file stem.
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
    let bytes = read_regular_file(path, None, &|| "the file".to_owned(), &mut budget);
    let bytes = bytes.map_err(|rule| match rule {
        // More memory would not help a file that is not read anyway.
        BrokenRule::TooLarge { .. } => failed(other_format::refusal_of_file(path).unwrap_or(rule)),
        rule => failed(rule),
    })?;
    let name = path.file_stem().unwrap_or(OsStr::new("scene"));
    import(&bytes, name, budget).map_err(failed)
}

/// Reads a file of any supported format from memory. `folder` is where referenced files are looked for; if it is
/// `None`, a referenced buffer is an error, and a referenced image or material file a warning.
///
/// # Errors
/// The same as [`read`].
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

/// Returns the bytes of a file, as the readers open files: folders, pipes and devices are refused without waiting for them, and a
/// file above `limit_bytes` before anything is allocated.
///
/// # Errors
/// [`BrokenRule::NotAFile`], [`BrokenRule::TooLarge`] and [`BrokenRule::Unreadable`].
pub fn file_bytes(path: &Path, limit_bytes: u64) -> Result<Vec<u8>, ImportError> {
    let mut budget = Budget::new(limit_bytes);
    let bytes = read_regular_file(path, None, &|| "the file".to_owned(), &mut budget);
    bytes.map_err(|rule| ImportError {
        file: path.display().to_string(),
        rule,
    })
}

/// Detects the format of the bytes and reads them. OBJ has no magic number, so bytes of no other format are read as OBJ
/// if `is_called_obj`, or if they begin like OBJ.
fn import(
    bytes: &[u8],
    folder: Option<&Path>,
    name: &OsStr,
    is_called_obj: bool,
    options: &ReadOptions,
    budget: Budget,
) -> Result<Import, BrokenRule> {
    if gltf::begins_like_gltf(bytes) && !terrain::describes_terrain(bytes) {
        let name = &*name.to_string_lossy();
        return gltf::import(bytes, folder, name, options, budget);
    }
    without_scenes(options)?;
    if terrain::describes_terrain(bytes) {
        return terrain::import(bytes, folder, name, options, budget);
    }
    if enf::begins_like_enf(bytes) {
        // Meshes keep the bytes that they are read from.
        let mut budget = budget;
        budget.take(bytes.len() as u64, || "a copy of the file".to_owned())?;
        return enf::import(bytes.to_vec().into(), options, budget);
    }
    let name = &*name.to_string_lossy();
    if quake::begins_like_map(bytes) {
        return quake::import(bytes, folder, name, options, budget);
    }
    if tiles::begins_like_tile(bytes) {
        return tiles::import(bytes, folder, name, options, budget);
    }
    if let Some(refusal) = other_format::refusal(bytes) {
        return Err(refusal);
    }
    let may_be_obj = !bytes.is_empty() && (is_called_obj || obj::begins_like_obj(bytes));
    if may_be_obj && let Some(import) = obj::import(bytes, folder, name, options, budget)? {
        return Ok(import);
    }
    Err(BrokenRule::UnknownFormat {
        begins: gltf::beginning(bytes),
    })
}

/// Returns an error if a scene of a format without scenes is requested.
fn without_scenes(options: &ReadOptions) -> Result<(), BrokenRule> {
    options
        .scene
        .as_ref()
        .map_or(Ok(()), |_| Err(BrokenRule::FormatWithoutScenes))
}

/// Reads the first `most` bytes of a file, or all of it. Never blocks on a pipe, and never reads more than the budget
/// allows.
fn read_regular_file(
    path: &Path,
    most: Option<u64>,
    place: &dyn Fn() -> String,
    budget: &mut Budget,
) -> Result<Vec<u8>, BrokenRule> {
    // Check the file type before opening: opening a pipe blocks until it has a writer.
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
