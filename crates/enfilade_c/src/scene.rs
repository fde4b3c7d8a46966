//! Scenes: empty or from a file, their sectors, and what else a file holds.

use crate::handle::{self, Handle};
use crate::ids::{EnfiladeSectorId, IdSpace, ItemTable};
use crate::lent::Caller;
use crate::status::{EnfiladeError, EnfiladeStatus, Failure, border, characters, refuse};
use crate::threads;
use crate::version::check_version;
use crate::view::EnfiladeCamera;
use enfilade::{
    Alpha, Camera, GeometryBuilder, ItemIndex, Material, Method, PortalId, Scene, SceneBuilder, SectorId,
};
use enfilade_draw::Stage;
use enfilade_import::{Import, ImportError, ReadOptions};
use std::ffi::c_char;
use std::path::Path;
use std::sync::OnceLock;

/// A scene: sectors with items, joined by portals.
///
/// Any number of threads may look at one scene and query it at the same time, each with its own viewer. A call that changes the
/// scene must be alone: while others use it, it returns ENFILADE_STATUS_BUSY, and so do they.
pub struct EnfiladeScene {
    _opaque: (),
}

impl Handle for EnfiladeScene {
    type Object = SceneState;
    const NAME: &'static str = "scene";
}

/// A scene with its ids.
pub(crate) struct SceneState {
    pub(crate) scene: Scene,
    pub(crate) items: ItemTable,
    pub(crate) sectors: IdSpace,
    pub(crate) portals: IdSpace,
    /// What drawing prepares once for a scene; emptied by what changes it.
    pub(crate) stage: OnceLock<Stage>,
    /// The methods of the sectors, each once: looks check the memory that they need for the screen.
    pub(crate) methods: Vec<Method>,
    cameras: Vec<Camera>,
    warnings: String,
}

/// How a sector finds out what is visible. The book says which to use when; ENFILADE_METHOD_MASKED suits most.
#[repr(u32)]
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum EnfiladeMethod {
    /// Masked occlusion culling: fast; conservative. It keeps two depths per 32 x 8 pixels, so that an item behind a wall may stay
    /// visible where a floor begins; with ENFILADE_TIGHTNESS_RESOLVED it does not.
    Masked = 0,
    /// Occlusion tree over boxes: valid at any sample position (MSAA, TAA, dynamic resolution).
    Mobsp = 1,
    /// Occlusion tree over faces: as ENFILADE_METHOD_MOBSP, fewer hidden items, slower.
    Svbsp = 2,
    /// Hierarchical z-buffer: exact.
    HierarchicalZ = 3,
    /// Hierarchical s-buffer: exact.
    HierarchicalS = 4,
    /// Z-buffer: exact, slow.
    ZBuffer = 5,
    /// S-buffer: exact.
    SBuffer = 6,
    /// Baked PVS: for files that hold one.
    Pvs = 7,
    /// Convex cell: for convex rooms.
    Cell = 8,
    /// BSP tree, back to front: exact, for scenes that do not change.
    Bsp = 9,
    /// BSP tree, front to back: exact, for scenes that do not change.
    BspFront = 10,
    /// Floating horizon: for terrain of a file.
    FloatingHorizon = 11,
    /// Painter's algorithm by nearest points: approximate.
    PainterMin = 12,
    /// Painter's algorithm by centres: approximate.
    PainterMean = 13,
}

const METHODS: [Method; 14] = [
    Method::Masked,
    Method::Mobsp,
    Method::Svbsp,
    Method::HierarchicalZ,
    Method::HierarchicalS,
    Method::ZBuffer,
    Method::SBuffer,
    Method::Pvs,
    Method::Cell,
    Method::Bsp,
    Method::BspFront,
    Method::FloatingHorizon,
    Method::PainterMin,
    Method::PainterMean,
];

/// How light passes through a material.
#[repr(u32)]
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum EnfiladeAlpha {
    /// Opaque: its faces are occluders.
    Opaque = 0,
    /// Alpha-tested: hides nothing.
    Mask = 1,
    /// Alpha-blended: hides nothing.
    Blend = 2,
}

/// A material, by which faces hide what is behind them.
#[repr(C)]
#[derive(Clone, Copy, Debug)]
pub struct EnfiladeMaterial {
    /// Red, green, blue and opacity, linear, 0 to 1; for enfilade_viewer_draw.
    pub color: [f32; 4],
    /// An EnfiladeAlpha.
    pub alpha: u32,
    /// 1 if faces are visible from both sides, 0 if back-faces are culled.
    pub double_sided: u32,
    /// 1 for plants, crockery and the like, whose faces are too small to be occluders; else 0.
    pub detail: u32,
}

/// Flags of EnfiladeReadOptions.
#[repr(u32)]
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum EnfiladeReadFlags {
    /// Read everything as one sector, without portals and mirrors.
    Flat = 1,
    /// Leave out portals and mirrors that are wrong, each with a warning.
    SkipBadPortals = 2,
    /// Leave out textures, which only enfilade_viewer_draw uses.
    NoTextures = 4,
}

/// How a file is read. All zero is a good default.
#[repr(C)]
#[derive(Clone, Copy, Debug)]
pub struct EnfiladeReadOptions {
    /// EnfiladeReadFlags, or 0.
    pub flags: u32,
    /// An EnfiladeMethod: that of sectors for which the file names none.
    pub method: u32,
    /// Most memory that reading may take, and then each sector, in bytes; 0 for 1 GiB.
    pub limit_bytes: u64,
}

/// What a sector is.
#[repr(C)]
#[derive(Clone, Copy, Debug)]
pub struct EnfiladeSectorInfo {
    /// Lower corner of the box around its items; greater than box_max if it has none.
    pub box_min: [f32; 3],
    /// Upper corner of that box.
    pub box_max: [f32; 3],
    /// Number of items.
    pub item_count: u64,
    /// Number of triangles of all items.
    pub triangle_count: u64,
    /// An EnfiladeMethod; UINT32_MAX for terrain that is read from its file on demand.
    pub method: u32,
    /// Always 0.
    pub reserved: u32,
    /// Its name, cut to fit.
    pub name: [c_char; 64],
}

impl SceneState {
    fn new(scene: Scene) -> SceneState {
        let mut state = SceneState {
            scene,
            items: ItemTable::new(),
            sectors: IdSpace::new("sector"),
            portals: IdSpace::new("portal"),
            stage: OnceLock::new(),
            methods: Vec::new(),
            cameras: Vec::new(),
            warnings: String::new(),
        };
        state.list_methods();
        state
    }

    /// Takes over a scene that was read, and numbers its items: their keys are 0, 1, 2, ..., sector after sector.
    fn of(import: Import, mut scene: Scene) -> Result<SceneState, Failure> {
        let mut items = Vec::new();
        for sector in scene.sectors() {
            if let Some(geometry) = scene.geometry(sector) {
                let indices = (0..geometry.items().len() as u32).map(ItemIndex);
                let held = indices.filter(|&index| geometry.holds(index));
                items.extend(held.map(|index| (sector, geometry.id_of(index))));
            }
        }
        let mut edit = scene.edit();
        for (&(sector, item), key) in items.iter().zip(0..) {
            edit.set_key(sector, item, key)?;
        }
        edit.finish()?;
        let warnings: Vec<String> = import.warnings.iter().map(ToString::to_string).collect();
        let mut state = SceneState {
            cameras: import.cameras,
            warnings: warnings.join("\n"),
            ..SceneState::new(scene)
        };
        for (sector, item) in items {
            state.items.add(sector, item);
        }
        Ok(state)
    }

    /// Returns a sector by its id.
    pub(crate) fn sector(&self, id: EnfiladeSectorId) -> Result<SectorId, Failure> {
        let index = self.sectors.index(id, self.scene.sector_count())?;
        let sector = SectorId(index);
        match self.scene.has_sector(sector) {
            true => Ok(sector),
            false => Err(crate::ids::no_such("sector", id)),
        }
    }

    /// Returns a portal by its id.
    pub(crate) fn portal(&self, id: u64) -> Result<PortalId, Failure> {
        let index = self.portals.index(id, self.scene.portals().len())?;
        let portal = PortalId(index);
        match self.scene.has_portal(portal) {
            true => Ok(portal),
            false => Err(crate::ids::no_such("portal", id)),
        }
    }

    /// Notes that sectors, methods or portals have changed.
    pub(crate) fn has_changed(&mut self) {
        self.stage.take();
        self.list_methods();
    }

    fn list_methods(&mut self) {
        let scene = &self.scene;
        let methods = scene.sectors().filter_map(|sector| scene.method(sector));
        self.methods.clear();
        self.methods.extend(methods);
        self.methods.sort_unstable_by_key(|&method| number_of(method));
        self.methods.dedup();
    }
}

fn number_of(method: Method) -> u32 {
    let number = METHODS.iter().position(|&known| known == method);
    number.map_or(u32::MAX, |number| number as u32)
}

fn method_of(number: u32) -> Result<Method, Failure> {
    let method = METHODS.get(number as usize).copied();
    method.ok_or_else(|| {
        refuse(
            "c/method",
            format_args!(
                "{number} is no EnfiladeMethod; they are 0 to {}",
                METHODS.len() - 1
            ),
        )
    })
}

/// Creates an empty scene. Free it with enfilade_scene_free.
///
/// @param version ENFILADE_VERSION.
/// @param scene Receives the scene.
#[allow(unsafe_code, reason = "called from C")]
#[unsafe(no_mangle)]
pub unsafe extern "C" fn enfilade_scene_create(
    version: u32,
    scene: *mut *mut EnfiladeScene,
    error: *mut EnfiladeError,
) -> EnfiladeStatus {
    // SAFETY: the promise of the caller, as the crate's documentation says.
    let caller = unsafe { Caller::new() };
    caller.call(error, |caller| {
        let scene = caller.out(scene, "scene")?;
        check_version(version)?;
        scene.set(handle::create(SceneState::new(SceneBuilder::new().build()?))?);
        Ok(())
    })
}

/// Reads a scene from a file: glTF 2.0 (.glb, .gltf), OBJ, a compiled map of Quake or Quake 3 (.bsp), or a heightmap (.json).
/// Rooms, portals and mirrors that the author marked become sectors and portals. Items have the keys 0, 1, 2, ...
///
/// @param version ENFILADE_VERSION.
/// @param path Path of the file, UTF-8.
/// @param options Null for the defaults.
/// @param scene Receives the scene.
///
/// Errors: ENFILADE_STATUS_BAD_FILE, with a message that names the place in the file; ENFILADE_STATUS_BAD_SCENE and
/// ENFILADE_STATUS_TOO_LARGE.
#[allow(unsafe_code, reason = "called from C")]
#[unsafe(no_mangle)]
pub unsafe extern "C" fn enfilade_scene_read_file(
    version: u32,
    path: *const c_char,
    options: *const EnfiladeReadOptions,
    scene: *mut *mut EnfiladeScene,
    error: *mut EnfiladeError,
) -> EnfiladeStatus {
    // SAFETY: the promise of the caller, as the crate's documentation says.
    let caller = unsafe { Caller::new() };
    caller.call(error, |caller| {
        let scene = caller.out(scene, "scene")?;
        check_version(version)?;
        let path = caller.text(path, "path")?;
        let options = caller.maybe(options);
        let read = |options: &ReadOptions| enfilade_import::read(Path::new(path), options);
        scene.set(handle::create(threads::on_all(|| scene_from(options, read))?)?);
        Ok(())
    })
}

/// Reads a scene from the bytes of a file, as enfilade_scene_read_file; other files that it refers to are not read.
///
/// @param version ENFILADE_VERSION.
/// @param bytes The bytes, which are read during the call only.
/// @param options Null for the defaults.
/// @param scene Receives the scene.
///
/// Errors: as enfilade_scene_read_file.
#[allow(unsafe_code, reason = "called from C")]
#[unsafe(no_mangle)]
pub unsafe extern "C" fn enfilade_scene_read_memory(
    version: u32,
    bytes: *const u8,
    byte_count: usize,
    options: *const EnfiladeReadOptions,
    scene: *mut *mut EnfiladeScene,
    error: *mut EnfiladeError,
) -> EnfiladeStatus {
    // SAFETY: the promise of the caller, as the crate's documentation says.
    let caller = unsafe { Caller::new() };
    caller.call(error, |caller| {
        let scene = caller.out(scene, "scene")?;
        check_version(version)?;
        let bytes = caller.slice(bytes, byte_count, "bytes")?;
        let options = caller.maybe(options);
        let read = |options: &ReadOptions| enfilade_import::read_bytes(bytes, None, options);
        scene.set(handle::create(threads::on_all(|| scene_from(options, read))?)?);
        Ok(())
    })
}

fn scene_from(
    options: Option<EnfiladeReadOptions>,
    read: impl FnOnce(&ReadOptions) -> Result<Import, ImportError>,
) -> Result<SceneState, Failure> {
    let EnfiladeReadOptions {
        flags,
        method,
        limit_bytes,
    } = options.unwrap_or(EnfiladeReadOptions {
        flags: 0,
        method: 0,
        limit_bytes: 0,
    });
    check_flags(flags, 7)?;
    let method = method_of(method)?;
    let has = |flag: EnfiladeReadFlags| flags & flag as u32 != 0;
    let mut options = ReadOptions {
        flat: has(EnfiladeReadFlags::Flat),
        skip_bad_portals: has(EnfiladeReadFlags::SkipBadPortals),
        textures: !has(EnfiladeReadFlags::NoTextures),
        ..ReadOptions::default()
    };
    if limit_bytes != 0 {
        options.limit_bytes = limit_bytes;
    }
    let import =
        read(&options).map_err(|why| Failure::new(EnfiladeStatus::BadFile, "file/unreadable", why))?;
    let scene = import.scene(method, options.limit_bytes)?;
    SceneState::of(import, scene)
}

/// Returns an error if a bit is set that has no meaning.
pub(crate) fn check_flags(flags: u32, known: u32) -> Result<(), Failure> {
    if flags & !known == 0 {
        return Ok(());
    }
    Err(refuse(
        "c/flags",
        format_args!("flags are {flags:#x}; only bits of {known:#x} have a meaning"),
    ))
}

/// Checks a field that a later version may use.
pub(crate) fn check_reserved(reserved: u32) -> Result<(), Failure> {
    if reserved == 0 {
        return Ok(());
    }
    Err(refuse(
        "c/reserved",
        format_args!("reserved is {reserved}; it must be 0, so clear the struct first"),
    ))
}

/// Frees a scene. Null is ignored. Viewers that looked at it stay.
///
/// Errors: ENFILADE_STATUS_BAD_HANDLE if it was freed before.
#[allow(unsafe_code, reason = "called from C")]
#[unsafe(no_mangle)]
pub extern "C" fn enfilade_scene_free(scene: *mut EnfiladeScene) -> EnfiladeStatus {
    border(|| handle::free(scene))
}

/// Adds a sector: a room, a region, or all of a scene without rooms. Then add its items, and connect it by a door or portal.
///
/// @param name UTF-8; null for none.
/// @param method An EnfiladeMethod.
/// @param materials The materials of the sector, to which its meshes refer by index; they stay as they are.
/// @param sector Receives the id.
///
/// Errors: ENFILADE_STATUS_BAD_SCENE if the method needs what the sector lacks.
#[allow(unsafe_code, reason = "called from C")]
#[unsafe(no_mangle)]
pub unsafe extern "C" fn enfilade_scene_add_sector(
    scene: *mut EnfiladeScene,
    name: *const c_char,
    method: u32,
    materials: *const EnfiladeMaterial,
    material_count: usize,
    sector: *mut EnfiladeSectorId,
    error: *mut EnfiladeError,
) -> EnfiladeStatus {
    // SAFETY: the promise of the caller, as the crate's documentation says.
    let caller = unsafe { Caller::new() };
    caller.call(error, |caller| {
        let sector = caller.out(sector, "sector")?;
        let scene = handle::find(scene)?;
        let mut scene = scene.write()?;
        let name = caller.text(name, "name")?;
        let method = method_of(method)?;
        let materials = caller.list(materials, 0, material_count, "materials")?;
        let materials = materials.iter().enumerate().map(material_of);
        let materials = materials.collect::<Result<Vec<Material>, Failure>>()?;
        let geometry = GeometryBuilder::new(materials).build();
        let geometry = geometry.map_err(|why| Failure::new(EnfiladeStatus::BadScene, why.code(), &why))?;
        let added = scene.scene.add_sector(name, geometry, method)?;
        scene.has_changed();
        sector.set(scene.sectors.id(added.0));
        Ok(())
    })
}

fn material_of((number, material): (usize, EnfiladeMaterial)) -> Result<Material, Failure> {
    crate::status::check_finite("the color of a material", &material.color)
        .map_err(|failure| failure.at(number))?;
    let alpha = match material.alpha {
        0 => Alpha::Opaque,
        1 => Alpha::Mask,
        2 => Alpha::Blend,
        other => {
            let message = format_args!("alpha is {other}; it must be an EnfiladeAlpha").to_string();
            return Err(refuse("c/alpha", message).at(number));
        }
    };
    let [r, g, b, _] = material.color;
    Ok(Material {
        base_color: material.color,
        alpha,
        double_sided: material.double_sided != 0,
        detail: material.detail != 0,
        ..Material::opaque([r, g, b])
    })
}

/// Removes a sector with its items, and all portals into and out of it.
///
/// Errors: ENFILADE_STATUS_NO_SUCH_ID.
#[allow(unsafe_code, reason = "called from C")]
#[unsafe(no_mangle)]
pub unsafe extern "C" fn enfilade_scene_remove_sector(
    scene: *mut EnfiladeScene,
    sector: EnfiladeSectorId,
    error: *mut EnfiladeError,
) -> EnfiladeStatus {
    // SAFETY: the promise of the caller, as the crate's documentation says.
    let caller = unsafe { Caller::new() };
    caller.call(error, |_| {
        let scene = handle::find(scene)?;
        let mut scene = scene.write()?;
        let sector = scene.sector(sector)?;
        scene.scene.remove_sector(sector);
        scene.items.remove_sector(sector);
        scene.has_changed();
        Ok(())
    })
}

/// Replaces the method of a sector, and rebuilds what it needs. With the same method: rebuilds trees that many moves have made
/// slow.
///
/// @param method An EnfiladeMethod.
///
/// Errors: ENFILADE_STATUS_BAD_SCENE if the method needs what the sector lacks; ENFILADE_STATUS_TOO_LARGE.
#[allow(unsafe_code, reason = "called from C")]
#[unsafe(no_mangle)]
pub unsafe extern "C" fn enfilade_scene_set_method(
    scene: *mut EnfiladeScene,
    sector: EnfiladeSectorId,
    method: u32,
    error: *mut EnfiladeError,
) -> EnfiladeStatus {
    // SAFETY: the promise of the caller, as the crate's documentation says.
    let caller = unsafe { Caller::new() };
    caller.call(error, |_| {
        let scene = handle::find(scene)?;
        let mut scene = scene.write()?;
        let sector = scene.sector(sector)?;
        let method = method_of(method)?;
        let scene = &mut *scene;
        threads::on_all(|| scene.scene.set_method(sector, method))?;
        scene.has_changed();
        Ok(())
    })
}

/// Lists the sectors, oldest first.
///
/// @param sectors Receives up to @p capacity ids; null to get their number alone.
/// @param count Receives their number.
///
/// Errors: ENFILADE_STATUS_BUFFER_TOO_SMALL.
#[allow(unsafe_code, reason = "called from C")]
#[unsafe(no_mangle)]
pub unsafe extern "C" fn enfilade_scene_sectors(
    scene: *const EnfiladeScene,
    sectors: *mut EnfiladeSectorId,
    capacity: usize,
    count: *mut usize,
    error: *mut EnfiladeError,
) -> EnfiladeStatus {
    // SAFETY: the promise of the caller, as the crate's documentation says.
    let caller = unsafe { Caller::new() };
    caller.call(error, |caller| {
        let buffer = caller.buffer(sectors, capacity, count, "sectors")?;
        let scene = handle::find(scene)?;
        let scene = scene.read()?;
        let sectors = scene.scene.sectors();
        let held = sectors.filter(|&sector| scene.scene.has_sector(sector));
        buffer.fill(held.map(|sector| scene.sectors.id(sector.0)))
    })
}

/// Describes a sector.
///
/// Errors: ENFILADE_STATUS_NO_SUCH_ID.
#[allow(unsafe_code, reason = "called from C")]
#[unsafe(no_mangle)]
pub unsafe extern "C" fn enfilade_scene_sector(
    scene: *const EnfiladeScene,
    sector: EnfiladeSectorId,
    info: *mut EnfiladeSectorInfo,
    error: *mut EnfiladeError,
) -> EnfiladeStatus {
    // SAFETY: the promise of the caller, as the crate's documentation says.
    let caller = unsafe { Caller::new() };
    caller.call(error, |caller| {
        let info = caller.out(info, "info")?;
        let scene = handle::find(scene)?;
        let scene = scene.read()?;
        let sector = scene.sector(sector)?;
        let scene = &scene.scene;
        let bounds = scene.bounds(sector);
        let items = match scene.geometry(sector) {
            Some(geometry) => geometry.item_count() as u64,
            None => u64::from(scene.sector(sector).item_count()),
        };
        info.set(EnfiladeSectorInfo {
            box_min: bounds.min,
            box_max: bounds.max,
            item_count: items,
            triangle_count: scene.triangles_of(sector),
            method: scene.method(sector).map_or(u32::MAX, number_of),
            reserved: 0,
            name: characters(scene.sector_name(sector)),
        });
        Ok(())
    })
}

/// Lists the cameras of the file that the scene was read from.
///
/// @param cameras Receives up to @p capacity cameras; null to get their number alone.
/// @param count Receives their number.
///
/// Errors: ENFILADE_STATUS_BUFFER_TOO_SMALL.
#[allow(unsafe_code, reason = "called from C")]
#[unsafe(no_mangle)]
pub unsafe extern "C" fn enfilade_scene_cameras(
    scene: *const EnfiladeScene,
    cameras: *mut EnfiladeCamera,
    capacity: usize,
    count: *mut usize,
    error: *mut EnfiladeError,
) -> EnfiladeStatus {
    // SAFETY: the promise of the caller, as the crate's documentation says.
    let caller = unsafe { Caller::new() };
    caller.call(error, |caller| {
        let buffer = caller.buffer(cameras, capacity, count, "cameras")?;
        let scene = handle::find(scene)?;
        let scene = scene.read()?;
        buffer.fill(scene.cameras.iter().map(|camera| {
            let sector = camera.sector.map_or(0, |sector| scene.sectors.id(sector.0));
            EnfiladeCamera::of(camera, sector)
        }))
    })
}

/// Returns what was strange in the file that the scene was read from: lines of UTF-8, without a null character at the end.
///
/// @param text Receives up to @p capacity bytes; null to get their number alone.
/// @param count Receives their number, 0 if nothing was strange.
///
/// Errors: ENFILADE_STATUS_BUFFER_TOO_SMALL.
#[allow(unsafe_code, reason = "called from C")]
#[unsafe(no_mangle)]
pub unsafe extern "C" fn enfilade_scene_warnings(
    scene: *const EnfiladeScene,
    text: *mut c_char,
    capacity: usize,
    count: *mut usize,
    error: *mut EnfiladeError,
) -> EnfiladeStatus {
    // SAFETY: the promise of the caller, as the crate's documentation says.
    let caller = unsafe { Caller::new() };
    caller.call(error, |caller| {
        let buffer = caller.buffer(text, capacity, count, "text")?;
        let scene = handle::find(scene)?;
        let scene = scene.read()?;
        buffer.fill(scene.warnings.bytes().map(|byte| byte as c_char))
    })
}
