//! Doors, mirrors and other portals between sectors.

use crate::handle;
use crate::ids::{EnfiladePortalId, EnfiladeSectorId};
use crate::items::{matrix, transform};
use crate::lent::Caller;
use crate::scene::{EnfiladeScene, SceneState};
use crate::status::{EnfiladeError, EnfiladeStatus, Failure};
use enfilade::{ConvexPolygon, OpeningId, PortalId, SectorId, Transform};

/// A portal: a one-way link out of a sector. A door is two portals, a mirror one that leads back.
#[repr(C)]
#[derive(Clone, Copy, Debug)]
pub struct EnfiladePortal {
    /// Its id.
    pub portal: EnfiladePortalId,
    /// The sector that it leads out of.
    pub from: EnfiladeSectorId,
    /// The sector that it leads into.
    pub to: EnfiladeSectorId,
    /// The transform from the space of the first sector to that of the second: 16 floats, column after column.
    pub there_from_here: [f32; 16],
    /// Lower corner of the box around its outline, in the space of the first sector.
    pub box_min: [f32; 3],
    /// Upper corner of that box.
    pub box_max: [f32; 3],
    /// 1 if it is open, 0 if it is closed: opaque.
    pub is_open: u32,
    /// Always 0.
    pub reserved: u32,
}

/// Adds a door: two portals, one each way, between sectors that share a space. Leave a hole in the walls there.
///
/// @param a A sector.
/// @param b Another, or the same.
/// @param corners The outline: at least three corners of 3 floats, flat, convex, counter-clockwise as seen from @p a.
/// @param stride Bytes from one corner to the next, at least 12; 0 for 12.
/// @param count Number of corners.
/// @param portals Receives two ids: of the portal out of @p a, then of that out of @p b.
///
/// Errors: ENFILADE_STATUS_BAD_MESH for the outline, with the index of the corner; ENFILADE_STATUS_NO_SUCH_ID;
/// ENFILADE_STATUS_BAD_SCENE.
#[allow(unsafe_code, reason = "called from C")]
#[unsafe(no_mangle)]
pub unsafe extern "C" fn enfilade_scene_add_door(
    scene: *mut EnfiladeScene,
    a: EnfiladeSectorId,
    b: EnfiladeSectorId,
    corners: *const f32,
    stride: usize,
    count: usize,
    portals: *mut EnfiladePortalId,
    error: *mut EnfiladeError,
) -> EnfiladeStatus {
    // SAFETY: the promise of the caller, as the crate's documentation says.
    let caller = unsafe { Caller::new() };
    caller.call(error, |caller| {
        let out = caller.out(portals.cast::<[EnfiladePortalId; 2]>(), "portals")?;
        let scene = handle::find(scene)?;
        let mut scene = scene.write()?;
        let scene = &mut *scene;
        let [a, b] = [scene.sector(a)?, scene.sector(b)?];
        let outline = outline(caller, corners, stride, count)?;
        let mut edit = scene.scene.edit();
        let front = edit.add_opening(a, "", outline.clone())?;
        let back = edit.add_opening(b, "", outline.flipped())?;
        edit.finish()?;
        let added = scene.scene.add_door((a, front), (b, back));
        if added.is_err() {
            // The last one first, so that the other keeps its number where both are in one sector.
            remove_openings(scene, &[(b, back), (a, front)])?;
        }
        let portals = added?;
        scene.has_changed();
        out.set(portals.map(|portal| scene.portals.id(portal.0)));
        Ok(())
    })
}

/// Adds a portal that leads one way: a mirror, a teleport, a window that is seen through from one side.
///
/// @param from The sector that it leads out of.
/// @param corners The outline, as of enfilade_scene_add_door, counter-clockwise as seen from @p from.
/// @param stride Bytes from one corner to the next, at least 12; 0 for 12.
/// @param count Number of corners.
/// @param to The sector that it leads into.
/// @param there_from_here 16 floats: the transform from the space of @p from to that of @p to: rigid, scaling alike in all
/// directions, or reflecting. Null: a mirror in the plane of the outline if @p to is @p from, else none.
/// @param portal Receives the id.
///
/// Errors: as enfilade_scene_add_door; ENFILADE_STATUS_BAD_SCENE for a transform that shears.
#[allow(unsafe_code, reason = "called from C")]
#[unsafe(no_mangle)]
pub unsafe extern "C" fn enfilade_scene_add_portal(
    scene: *mut EnfiladeScene,
    from: EnfiladeSectorId,
    corners: *const f32,
    stride: usize,
    count: usize,
    to: EnfiladeSectorId,
    there_from_here: *const f32,
    portal: *mut EnfiladePortalId,
    error: *mut EnfiladeError,
) -> EnfiladeStatus {
    // SAFETY: the promise of the caller, as the crate's documentation says.
    let caller = unsafe { Caller::new() };
    caller.call(error, |caller| {
        let out = caller.out(portal, "portal")?;
        let scene = handle::find(scene)?;
        let mut scene = scene.write()?;
        let scene = &mut *scene;
        let [from, to] = [scene.sector(from)?, scene.sector(to)?];
        let outline = outline(caller, corners, stride, count)?;
        let there_from_here = match caller.maybe(there_from_here.cast::<[f32; 16]>()) {
            Some(columns) => transform(&columns)?,
            None if from == to => Transform::reflection(outline.corners()[0], outline.normal()),
            None => Transform::IDENTITY,
        };
        let mut edit = scene.scene.edit();
        let opening = edit.add_opening(from, "", outline)?;
        edit.finish()?;
        let added = scene.scene.add_portal((from, opening), to, there_from_here);
        if added.is_err() {
            remove_openings(scene, &[(from, opening)])?;
        }
        let portal = added?;
        scene.has_changed();
        out.set(scene.portals.id(portal.0));
        Ok(())
    })
}

fn outline(
    caller: &Caller,
    corners: *const f32,
    stride: usize,
    count: usize,
) -> Result<ConvexPolygon, Failure> {
    let corners = caller.list::<[f32; 3]>(corners.cast(), stride, count, "corners")?;
    let corners: Vec<[f32; 3]> = corners.iter().collect();
    Ok(ConvexPolygon::new(&corners)?)
}

fn remove_openings(scene: &mut SceneState, openings: &[(SectorId, OpeningId)]) -> Result<(), Failure> {
    let mut edit = scene.scene.edit();
    for &(sector, opening) in openings {
        edit.remove_opening(sector, opening)?;
    }
    edit.finish()?;
    Ok(())
}

/// Removes a portal with its opening. The other portal of a door stays.
///
/// Errors: ENFILADE_STATUS_NO_SUCH_ID.
#[allow(unsafe_code, reason = "called from C")]
#[unsafe(no_mangle)]
pub unsafe extern "C" fn enfilade_scene_remove_portal(
    scene: *mut EnfiladeScene,
    portal: EnfiladePortalId,
    error: *mut EnfiladeError,
) -> EnfiladeStatus {
    // SAFETY: the promise of the caller, as the crate's documentation says.
    let caller = unsafe { Caller::new() };
    caller.call(error, |_| {
        let scene = handle::find(scene)?;
        let mut scene = scene.write()?;
        let scene = &mut *scene;
        let PortalId(portal) = scene.portal(portal)?;
        let known = &scene.scene.portals()[portal as usize];
        let opening = (known.from, known.opening);
        remove_openings(scene, &[opening])?;
        scene.has_changed();
        Ok(())
    })
}

/// Opens or closes a portal. A closed one is opaque. Close both portals of a door.
///
/// @param is_open 0 to close it.
///
/// Errors: ENFILADE_STATUS_NO_SUCH_ID.
#[allow(unsafe_code, reason = "called from C")]
#[unsafe(no_mangle)]
pub unsafe extern "C" fn enfilade_scene_set_open(
    scene: *mut EnfiladeScene,
    portal: EnfiladePortalId,
    is_open: u32,
    error: *mut EnfiladeError,
) -> EnfiladeStatus {
    // SAFETY: the promise of the caller, as the crate's documentation says.
    let caller = unsafe { Caller::new() };
    caller.call(error, |_| {
        let scene = handle::find(scene)?;
        let mut scene = scene.write()?;
        let portal = scene.portal(portal)?;
        scene.scene.set_open(portal, is_open != 0);
        scene.stage.take();
        Ok(())
    })
}

/// Lists the portals out of a sector, or all.
///
/// @param sector 0 for all.
/// @param portals Receives up to @p capacity portals; null to get their number alone.
/// @param count Receives their number.
///
/// Errors: ENFILADE_STATUS_BUFFER_TOO_SMALL.
#[allow(unsafe_code, reason = "called from C")]
#[unsafe(no_mangle)]
pub unsafe extern "C" fn enfilade_scene_portals(
    scene: *const EnfiladeScene,
    sector: EnfiladeSectorId,
    portals: *mut EnfiladePortal,
    capacity: usize,
    count: *mut usize,
    error: *mut EnfiladeError,
) -> EnfiladeStatus {
    // SAFETY: the promise of the caller, as the crate's documentation says.
    let caller = unsafe { Caller::new() };
    caller.call(error, |caller| {
        let buffer = caller.buffer(portals, capacity, count, "portals")?;
        let scene = handle::find(scene)?;
        let scene = scene.read()?;
        let sector = match sector {
            0 => None,
            id => Some(scene.sector(id)?),
        };
        let all = scene.scene.portals().iter().zip((0..).map(PortalId));
        buffer.fill(all.filter_map(|(portal, id)| {
            let is_wanted = scene.scene.has_portal(id) && sector.is_none_or(|sector| sector == portal.from);
            let openings = scene.scene.sector(portal.from).openings();
            let bounds = openings.get(usize::from(portal.opening.0))?.outline.bounds();
            is_wanted.then(|| EnfiladePortal {
                portal: scene.portals.id(id.0),
                from: scene.sectors.id(portal.from.0),
                to: scene.sectors.id(portal.to.0),
                there_from_here: matrix(&portal.there_from_here),
                box_min: bounds.min,
                box_max: bounds.max,
                is_open: u32::from(portal.open),
                reserved: 0,
            })
        }))
    })
}
