//! Items: instances of meshes, added, moved, changed and removed between looks.

use crate::handle;
use crate::ids::{EnfiladeItemId, EnfiladeSectorId};
use crate::lent::Caller;
use crate::mesh::EnfiladeMesh;
use crate::scene::{EnfiladeScene, SceneState, check_flags};
use crate::status::{EnfiladeError, EnfiladeStatus, Failure, characters, refuse};
use crate::threads;
use enfilade::{EditError, ItemId, ItemOptions, Mesh, SectorId, Transform};
use std::ffi::c_char;
use std::sync::Arc;

/// Flags of EnfiladeItemOptions.
#[repr(u32)]
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum EnfiladeItemFlags {
    /// Its faces hide nothing: its mesh only approximates what is drawn.
    NoOccluder = 1,
    /// It hides, but is never visible itself: a proxy inside of what is drawn.
    NotDrawn = 2,
    /// Each look into its sector finds it, even if it is hidden or out of view.
    NeverCull = 4,
}

/// How an item takes part in looks. All zero is a good default.
#[repr(C)]
#[derive(Clone, Copy, Debug)]
pub struct EnfiladeItemOptions {
    /// EnfiladeItemFlags, or 0.
    pub flags: u32,
    /// The layers it is in, one bit each; 0 for all. Viewers look at layers.
    pub layers: u32,
    /// Distance from which on looks ignore it, in scene units; 0 for no limit.
    pub max_distance: f32,
    /// Diameter on the screen below which looks ignore it, in pixels.
    pub min_size_px: f32,
}

/// An item to add.
#[repr(C)]
#[derive(Clone, Copy, Debug)]
pub struct EnfiladeItem {
    /// Its mesh, which may be freed afterwards.
    pub mesh: *const EnfiladeMesh,
    /// Your number for it: answers name it by its key, and bit sets have a bit for each key, so use small ones if you use those.
    pub key: u64,
    /// The transform from the space of the mesh to that of the sector: 16 floats, column after column, as in EnfiladeView. The
    /// last row must be 0, 0, 0, 1.
    pub sector_from_item: [f32; 16],
    /// How it takes part in looks.
    pub options: EnfiladeItemOptions,
    /// UTF-8; null for none. Copied.
    pub name: *const c_char,
}

/// What an item is.
#[repr(C)]
#[derive(Clone, Copy, Debug)]
pub struct EnfiladeItemInfo {
    /// Its sector.
    pub sector: EnfiladeSectorId,
    /// Its key.
    pub key: u64,
    /// Its transform, as in EnfiladeItem.
    pub sector_from_item: [f32; 16],
    /// Lower corner of its box, in the space of the sector.
    pub box_min: [f32; 3],
    /// Upper corner of its box.
    pub box_max: [f32; 3],
    /// How it takes part in looks.
    pub options: EnfiladeItemOptions,
    /// Number of triangles of its mesh; 0 for a box.
    pub triangle_count: u64,
    /// Its name, cut to fit.
    pub name: [c_char; 64],
}

impl EnfiladeItemOptions {
    fn options(&self) -> Result<ItemOptions, Failure> {
        check_flags(self.flags, 7)?;
        if !(self.max_distance >= 0.0 && self.min_size_px >= 0.0) {
            return Err(refuse(
                "c/item-options",
                "max_distance and min_size_px must be 0 or more",
            ));
        }
        let has = |flag: EnfiladeItemFlags| self.flags & flag as u32 != 0;
        let mut options = ItemOptions {
            is_occluder: !has(EnfiladeItemFlags::NoOccluder),
            is_drawn: !has(EnfiladeItemFlags::NotDrawn),
            never_cull: has(EnfiladeItemFlags::NeverCull),
            min_size_px: self.min_size_px,
            ..ItemOptions::default()
        };
        if self.layers != 0 {
            options.layers = self.layers;
        }
        if self.max_distance != 0.0 {
            options.max_distance = self.max_distance;
        }
        Ok(options)
    }

    fn of(options: &ItemOptions) -> EnfiladeItemOptions {
        let flag = |is_set: bool, flag: EnfiladeItemFlags| if is_set { flag as u32 } else { 0 };
        EnfiladeItemOptions {
            flags: flag(!options.is_occluder, EnfiladeItemFlags::NoOccluder)
                | flag(!options.is_drawn, EnfiladeItemFlags::NotDrawn)
                | flag(options.never_cull, EnfiladeItemFlags::NeverCull),
            layers: options.layers,
            max_distance: if options.max_distance.is_finite() {
                options.max_distance
            } else {
                0.0
            },
            min_size_px: options.min_size_px,
        }
    }
}

/// Returns the transform of a matrix of 16 floats, column after column.
pub(crate) fn transform(matrix: &[f32; 16]) -> Result<Transform, Failure> {
    if [matrix[3], matrix[7], matrix[11], matrix[15]] != [0.0, 0.0, 0.0, 1.0] {
        return Err(refuse(
            "c/matrix",
            "the last row of a transform must be 0, 0, 0, 1; is the matrix transposed, or not set?",
        ));
    }
    crate::status::check_finite("a transform", matrix)?;
    let column = |number: usize| [0, 1, 2].map(|row| matrix[4 * number + row]);
    Ok(Transform::from_columns([0, 1, 2, 3].map(column)))
}

/// Returns a transform as 16 floats, column after column.
pub(crate) fn matrix(transform: &Transform) -> [f32; 16] {
    let [x, y, z, translation] = transform.columns();
    let mut matrix = [0.0; 16];
    for (number, (column, last)) in [(x, 0.0), (y, 0.0), (z, 0.0), (translation, 1.0)]
        .into_iter()
        .enumerate()
    {
        matrix[4 * number..4 * number + 3].copy_from_slice(&column);
        matrix[4 * number + 3] = last;
    }
    matrix
}

/// The failure of the first element that was refused.
#[derive(Default)]
struct First(Option<Failure>);

impl First {
    fn note(&mut self, number: usize, why: impl Into<Failure>) {
        let why = why.into();
        self.0.get_or_insert(why.at(number));
    }

    fn into_result(self) -> Result<(), Failure> {
        self.0.map_or(Ok(()), Err)
    }
}

/// Adds items to a sector.
///
/// Adds as many as it can: the id of one that is refused is 0, the status is why the first was, and the index of the error is
/// its index.
///
/// @param items The items.
/// @param count Their number.
/// @param ids Receives their ids; room for @p count.
///
/// Errors: ENFILADE_STATUS_BAD_HANDLE for a mesh, ENFILADE_STATUS_BAD_ARGUMENT for a transform, a material that the sector
/// lacks, or options; ENFILADE_STATUS_TOO_LARGE, and then none is added.
#[allow(unsafe_code, reason = "called from C")]
#[unsafe(no_mangle)]
pub unsafe extern "C" fn enfilade_scene_add_items(
    scene: *mut EnfiladeScene,
    sector: EnfiladeSectorId,
    items: *const EnfiladeItem,
    count: usize,
    ids: *mut EnfiladeItemId,
    error: *mut EnfiladeError,
) -> EnfiladeStatus {
    // SAFETY: the promise of the caller, as the crate's documentation says.
    let caller = unsafe { Caller::new() };
    caller.call(error, |caller| {
        let ids = caller.slice_mut(ids, count, "ids")?;
        ids.fill(0);
        let scene = handle::find(scene)?;
        let mut scene = scene.write()?;
        let scene = &mut *scene;
        let sector = scene.sector(sector)?;
        let items = caller.list(items, 0, count, "items")?;
        let before = scene
            .scene
            .geometry(sector)
            .map_or(0, |geometry| geometry.item_count());
        let mut first = First::default();
        let mut edit = scene.scene.edit();
        let mut added: Vec<(usize, ItemId)> = Vec::with_capacity(count);
        let mut last: (*const EnfiladeMesh, Option<Arc<Mesh>>) = (std::ptr::null(), None);
        for (number, item) in items.iter().enumerate() {
            // Instances of one mesh mostly follow each other.
            if last.1.is_none() || last.0 != item.mesh {
                last = (item.mesh, None);
            }
            let mut add = || -> Result<ItemId, Failure> {
                let mesh = match &last.1 {
                    Some(mesh) => Arc::clone(mesh),
                    None => {
                        let mesh = Arc::clone(&*handle::find(item.mesh)?.read()?);
                        Arc::clone(last.1.insert(mesh))
                    }
                };
                let transform = transform(&item.sector_from_item)?;
                let options = item.options.options()?;
                let name = caller.text(item.name, "name")?;
                let id = edit.add(sector, name, mesh, transform)?;
                edit.set_key(sector, id, item.key)?;
                edit.set_options(sector, id, options)?;
                Ok(id)
            };
            match add() {
                Ok(id) => added.push((number, id)),
                Err(why) => first.note(number, why),
            }
        }
        threads::on_all(|| edit.finish())?;
        for &(number, item) in &added {
            ids[number] = scene.items.add(sector, item);
        }
        // Trees that grew item by item are worse than those built at once.
        if added.len() > before.max(8)
            && let Some(method) = scene.scene.method(sector)
        {
            threads::on_all(|| scene.scene.set_method(sector, method))?;
        }
        first.into_result()
    })
}

/// Removes items. Their ids are invalid from then on, and never name other items.
///
/// Removes as many as it can; the status and the index of the error are those of the first that was refused.
///
/// Errors: ENFILADE_STATUS_NO_SUCH_ID.
#[allow(unsafe_code, reason = "called from C")]
#[unsafe(no_mangle)]
pub unsafe extern "C" fn enfilade_scene_remove_items(
    scene: *mut EnfiladeScene,
    ids: *const EnfiladeItemId,
    count: usize,
    error: *mut EnfiladeError,
) -> EnfiladeStatus {
    // SAFETY: the promise of the caller, as the crate's documentation says.
    let caller = unsafe { Caller::new() };
    caller.call(error, |caller| {
        let scene = handle::find(scene)?;
        let mut scene = scene.write()?;
        let SceneState { scene, items, .. } = &mut *scene;
        let ids = caller.list(ids, 0, count, "ids")?;
        let mut first = First::default();
        let mut edit = scene.edit();
        let mut removed = Vec::with_capacity(ids.len());
        for (number, id) in ids.iter().enumerate() {
            let known = items.get(id);
            match known.and_then(|(sector, item)| Ok(edit.remove(sector, item)?)) {
                Ok(()) => removed.push(id),
                Err(why) => first.note(number, why),
            }
        }
        edit.finish()?;
        for id in removed {
            items.remove(id);
        }
        first.into_result()
    })
}

/// Moves items: replaces their transforms. Report everything that moves, or it is culled where it was.
///
/// Moves as many as it can; the status and the index of the error are those of the first that was refused. One that is refused
/// stays where it was, so draw it without culling until a transform is accepted.
///
/// Allocates nothing once the buffers of the scene have grown, except where nodes of a tree split.
///
/// @param ids The items; several transforms of one item: the last counts.
/// @param count Their number.
/// @param transforms One for each item: 16 floats, column after column, as EnfiladeItem::sector_from_item.
/// @param stride Bytes from one transform to the next, at least 64; 0 for 64. Any alignment.
/// @param refused Null, or one word for each 64 items: receives bit i % 64 of word i / 64 for each item i that was refused.
///
/// Errors: ENFILADE_STATUS_NO_SUCH_ID, ENFILADE_STATUS_BAD_ARGUMENT for a transform that is not finite or leads beyond 1e18;
/// ENFILADE_STATUS_TOO_LARGE, and then none is moved.
#[allow(unsafe_code, reason = "called from C")]
#[unsafe(no_mangle)]
pub unsafe extern "C" fn enfilade_scene_move_items(
    scene: *mut EnfiladeScene,
    ids: *const EnfiladeItemId,
    count: usize,
    transforms: *const f32,
    stride: usize,
    refused: *mut u64,
    error: *mut EnfiladeError,
) -> EnfiladeStatus {
    // SAFETY: the promise of the caller, as the crate's documentation says.
    let caller = unsafe { Caller::new() };
    caller.call(error, |caller| {
        let refused: &mut [u64] = match refused.is_null() {
            true => &mut [],
            false => caller.slice_mut(refused, count.div_ceil(64), "refused")?,
        };
        refused.fill(0);
        let scene = handle::find(scene)?;
        let mut scene = scene.write()?;
        let SceneState { scene, items, .. } = &mut *scene;
        let ids = caller.list(ids, 0, count, "ids")?;
        let transforms = caller.list::<[f32; 16]>(transforms.cast(), stride, count, "transforms")?;
        let mut first = First::default();
        let mut edit = scene.edit();
        for (number, (id, columns)) in ids.iter().zip(transforms.iter()).enumerate() {
            let moved = items.get(id).and_then(|(sector, item)| {
                let transform = transform(&columns)?;
                Ok(edit.set_transform(sector, item, transform)?)
            });
            if let Err(why) = moved {
                if let Some(word) = refused.get_mut(number / 64) {
                    *word |= 1 << (number % 64);
                }
                first.note(number, why);
            }
        }
        edit.finish()?;
        first.into_result()
    })
}

/// Replaces the options of items.
///
/// Changes as many as it can; the status and the index of the error are those of the first that was refused.
///
/// @param options One for each item.
///
/// Errors: ENFILADE_STATUS_NO_SUCH_ID, ENFILADE_STATUS_BAD_ARGUMENT.
#[allow(unsafe_code, reason = "called from C")]
#[unsafe(no_mangle)]
pub unsafe extern "C" fn enfilade_scene_set_options(
    scene: *mut EnfiladeScene,
    ids: *const EnfiladeItemId,
    count: usize,
    options: *const EnfiladeItemOptions,
    error: *mut EnfiladeError,
) -> EnfiladeStatus {
    // SAFETY: the promise of the caller, as the crate's documentation says.
    let caller = unsafe { Caller::new() };
    caller.call(error, |caller| {
        let options = caller.list(options, 0, count, "options")?;
        let mut options = options.iter();
        each_item(caller, scene, ids, count, |edit, sector, item| {
            let Some(options) = options.next() else {
                return Ok(());
            };
            Ok(edit.set_options(sector, item, options.options()?)?)
        })
    })
}

/// Replaces the keys of items.
///
/// Changes as many as it can; the status and the index of the error are those of the first that was refused.
///
/// @param keys One for each item.
///
/// Errors: ENFILADE_STATUS_NO_SUCH_ID.
#[allow(unsafe_code, reason = "called from C")]
#[unsafe(no_mangle)]
pub unsafe extern "C" fn enfilade_scene_set_keys(
    scene: *mut EnfiladeScene,
    ids: *const EnfiladeItemId,
    count: usize,
    keys: *const u64,
    error: *mut EnfiladeError,
) -> EnfiladeStatus {
    // SAFETY: the promise of the caller, as the crate's documentation says.
    let caller = unsafe { Caller::new() };
    caller.call(error, |caller| {
        let keys = caller.list(keys, 0, count, "keys")?;
        let mut keys = keys.iter();
        each_item(caller, scene, ids, count, |edit, sector, item| {
            match keys.next() {
                Some(key) => Ok(edit.set_key(sector, item, key)?),
                None => Ok(()),
            }
        })
    })
}

/// Calls `change` for each item, also for those that do not exist, so that it can keep step with other arrays.
fn each_item(
    caller: &Caller,
    scene: *mut EnfiladeScene,
    ids: *const EnfiladeItemId,
    count: usize,
    mut change: impl FnMut(&mut enfilade::Edit, SectorId, ItemId) -> Result<(), Failure>,
) -> Result<(), Failure> {
    let scene = handle::find(scene)?;
    let mut scene = scene.write()?;
    let SceneState { scene, items, .. } = &mut *scene;
    let ids = caller.list(ids, 0, count, "ids")?;
    let mut first = First::default();
    let mut edit = scene.edit();
    for (number, id) in ids.iter().enumerate() {
        let known = items.get(id);
        let (sector, item) = match &known {
            Ok(known) => *known,
            // Refused by the edit, which has no such sector.
            Err(_) => (SectorId(u32::MAX), ItemId::from(enfilade::ItemIndex(0))),
        };
        let changed = change(&mut edit, sector, item);
        if let Err(why) = known.and(changed) {
            first.note(number, why);
        }
    }
    edit.finish()?;
    first.into_result()
}

/// Replaces the mesh of an item and keeps its transform: for a mesh that was loaded after the item, or another LOD.
///
/// Errors: ENFILADE_STATUS_NO_SUCH_ID, ENFILADE_STATUS_BAD_HANDLE, ENFILADE_STATUS_BAD_ARGUMENT for a material that the sector
/// lacks.
#[allow(unsafe_code, reason = "called from C")]
#[unsafe(no_mangle)]
pub unsafe extern "C" fn enfilade_scene_set_mesh(
    scene: *mut EnfiladeScene,
    item: EnfiladeItemId,
    mesh: *const EnfiladeMesh,
    error: *mut EnfiladeError,
) -> EnfiladeStatus {
    // SAFETY: the promise of the caller, as the crate's documentation says.
    let caller = unsafe { Caller::new() };
    caller.call(error, |_| {
        let scene = handle::find(scene)?;
        let mut scene = scene.write()?;
        let (sector, item) = scene.items.get(item)?;
        let mesh = Arc::clone(&*handle::find(mesh)?.read()?);
        let mut edit = scene.scene.edit();
        edit.set_mesh(sector, item, mesh)?;
        edit.finish()?;
        Ok(())
    })
}

/// Moves an item to another sector, with its id, key, mesh and options. The materials of its mesh are those of the new sector
/// with the same numbers.
///
/// @param sector_from_item Its transform in the new sector: 16 floats.
///
/// Errors: ENFILADE_STATUS_NO_SUCH_ID, ENFILADE_STATUS_BAD_ARGUMENT.
#[allow(unsafe_code, reason = "called from C")]
#[unsafe(no_mangle)]
pub unsafe extern "C" fn enfilade_scene_transfer_item(
    scene: *mut EnfiladeScene,
    item: EnfiladeItemId,
    sector: EnfiladeSectorId,
    sector_from_item: *const f32,
    error: *mut EnfiladeError,
) -> EnfiladeStatus {
    // SAFETY: the promise of the caller, as the crate's documentation says.
    let caller = unsafe { Caller::new() };
    caller.call(error, |caller| {
        let scene = handle::find(scene)?;
        let mut scene = scene.write()?;
        let (from, there) = scene.items.get(item)?;
        let to = scene.sector(sector)?;
        let transform = transform(&caller.numbers(sector_from_item, "sector_from_item")?)?;
        let mut edit = scene.scene.edit();
        if from == to {
            edit.set_transform(from, there, transform)?;
            edit.finish()?;
            return Ok(());
        }
        let moved = edit.move_to(from, there, to, transform)?;
        edit.finish()?;
        scene.items.relocate(item, to, moved);
        Ok(())
    })
}

/// Lists the items of a sector, or of all sectors.
///
/// @param sector 0 for all.
/// @param ids Receives up to @p capacity ids; null to get their number alone.
/// @param count Receives their number.
///
/// Errors: ENFILADE_STATUS_BUFFER_TOO_SMALL.
#[allow(unsafe_code, reason = "called from C")]
#[unsafe(no_mangle)]
pub unsafe extern "C" fn enfilade_scene_items(
    scene: *const EnfiladeScene,
    sector: EnfiladeSectorId,
    ids: *mut EnfiladeItemId,
    capacity: usize,
    count: *mut usize,
    error: *mut EnfiladeError,
) -> EnfiladeStatus {
    // SAFETY: the promise of the caller, as the crate's documentation says.
    let caller = unsafe { Caller::new() };
    caller.call(error, |caller| {
        let buffer = caller.buffer(ids, capacity, count, "ids")?;
        let scene = handle::find(scene)?;
        let scene = scene.read()?;
        let sector = match sector {
            0 => None,
            id => Some(scene.sector(id)?),
        };
        let is_there = |&id: &EnfiladeItemId| {
            let known = scene.items.get(id).ok();
            known.is_some_and(|(there, _)| sector.is_none_or(|sector| sector == there))
        };
        buffer.fill(scene.items.ids().filter(is_there))
    })
}

/// Describes an item.
///
/// Errors: ENFILADE_STATUS_NO_SUCH_ID.
#[allow(unsafe_code, reason = "called from C")]
#[unsafe(no_mangle)]
pub unsafe extern "C" fn enfilade_scene_item(
    scene: *const EnfiladeScene,
    item: EnfiladeItemId,
    info: *mut EnfiladeItemInfo,
    error: *mut EnfiladeError,
) -> EnfiladeStatus {
    // SAFETY: the promise of the caller, as the crate's documentation says.
    let caller = unsafe { Caller::new() };
    caller.call(error, |caller| {
        let info = caller.out(info, "info")?;
        let scene = handle::find(scene)?;
        let scene = scene.read()?;
        let (sector, id) = scene.items.get(item)?;
        let found = scene.scene.geometry(sector);
        let found = found.and_then(|geometry| Some((geometry, geometry.index_of(id)?)));
        let Some((geometry, index)) = found else {
            let sector = scene.scene.sector_name(sector).to_owned();
            return Err(EditError::NoSuchItem { sector, item: id }.into());
        };
        let placed = geometry.item(index);
        info.set(EnfiladeItemInfo {
            sector: scene.sectors.id(sector.0),
            key: geometry.key(index),
            sector_from_item: matrix(&placed.transform()),
            box_min: placed.bounds.min,
            box_max: placed.bounds.max,
            options: EnfiladeItemOptions::of(&placed.options),
            triangle_count: geometry.mesh_of(index).triangle_count(),
            name: characters(geometry.name(index)),
        });
        Ok(())
    })
}
