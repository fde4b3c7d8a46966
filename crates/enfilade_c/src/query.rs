//! Queries through portals: where a point is, what a ray hits, what is near, where a body goes.

use crate::handle;
use crate::ids::{EnfiladeItemId, EnfiladeSectorId};
use crate::items::matrix;
use crate::lent::Caller;
use crate::scene::{EnfiladeScene, SceneState, check_reserved};
use crate::status::{EnfiladeError, EnfiladeStatus, Failure, check_finite};
use enfilade::{Location, MAX_COORDINATE, Ray, RayEnd};
use enfilade_walk::Capsule;

/// A position in a scene.
#[repr(C)]
#[derive(Clone, Copy, Debug)]
pub struct EnfiladeLocation {
    /// The sector.
    pub sector: EnfiladeSectorId,
    /// Coordinates in the space of the sector.
    pub position: [f32; 3],
    /// Must be 0.
    pub reserved: u32,
}

/// What stops a ray.
#[repr(u32)]
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum EnfiladeRayEnd {
    /// Nothing: it goes on for ever.
    Nothing = 0,
    /// A face of an item.
    Face = 1,
    /// A portal that is closed.
    Closed = 2,
    /// More portals than are followed, 256.
    Limit = 3,
}

/// Where a ray ends.
#[repr(C)]
#[derive(Clone, Copy, Debug)]
pub struct EnfiladeHit {
    /// Distance over all portals, in lengths of the direction; infinite if nothing is hit.
    pub distance: f64,
    /// The sector that it ends in.
    pub sector: EnfiladeSectorId,
    /// The item that is hit, or 0.
    pub item: EnfiladeItemId,
    /// The key of that item.
    pub key: u64,
    /// An EnfiladeRayEnd.
    pub end: u32,
    /// 1 if the face is hit from behind, else 0.
    pub from_behind: u32,
}

/// An item near a location.
#[repr(C)]
#[derive(Clone, Copy, Debug)]
pub struct EnfiladeNearItem {
    /// Its key.
    pub key: u64,
    /// Its id.
    pub item: EnfiladeItemId,
    /// Its sector.
    pub sector: EnfiladeSectorId,
    /// Length of the shortest way to its box, through open portals.
    pub distance: f64,
}

/// A body that slides along walls: a cylinder with round ends.
#[repr(C)]
#[derive(Clone, Copy, Debug)]
pub struct EnfiladeCapsule {
    /// Radius, above 0.
    pub radius: f32,
    /// Height, with the round ends; a sphere if at most twice the radius.
    pub height: f32,
    /// Direction of its axis, of any length but 0.
    pub up: [f32; 3],
    /// Height of a step that it climbs, or 0.
    pub climb: f32,
}

impl SceneState {
    fn location(&self, location: &EnfiladeLocation) -> Result<Location, Failure> {
        check_reserved(location.reserved)?;
        let sector = self.sector(location.sector)?;
        check_in_range("the position of a location", &location.position)?;
        Ok(Location {
            sector,
            position: location.position,
        })
    }

    fn location_out(&self, location: &Location) -> EnfiladeLocation {
        EnfiladeLocation {
            sector: self.sectors.id(location.sector.0),
            position: location.position,
            reserved: 0,
        }
    }
}

fn check_in_range(name: &str, numbers: &[f32]) -> Result<(), Failure> {
    check_finite(name, numbers)?;
    if numbers.iter().all(|number| number.abs() <= MAX_COORDINATE) {
        return Ok(());
    }
    Err(crate::status::refuse(
        "c/too-far",
        format_args!("{name} is farther out than {MAX_COORDINATE:e}"),
    ))
}

/// Finds the sector that contains a point: the smallest of those whose boxes do, else the nearest.
///
/// @param point 3 doubles.
/// @param target Null, or 3 doubles: a point that the eye at @p point looks at, which decides in a doorway.
/// @param sector Receives the id; 0 if the scene has no sectors.
///
/// Errors: ENFILADE_STATUS_BAD_ARGUMENT for numbers that are not finite.
#[allow(unsafe_code, reason = "called from C")]
#[unsafe(no_mangle)]
pub unsafe extern "C" fn enfilade_scene_locate(
    scene: *const EnfiladeScene,
    point: *const f64,
    target: *const f64,
    sector: *mut EnfiladeSectorId,
    error: *mut EnfiladeError,
) -> EnfiladeStatus {
    // SAFETY: the promise of the caller, as the crate's documentation says.
    let caller = unsafe { Caller::new() };
    caller.call(error, |caller| {
        let sector = caller.out(sector, "sector")?;
        let scene = handle::find(scene)?;
        let scene = scene.read()?;
        let point = caller.numbers::<f64, 3>(point, "point")?;
        check_finite("point", &point)?;
        let target = caller.maybe(target.cast::<[f64; 3]>()).unwrap_or(point);
        check_finite("target", &target)?;
        let found = scene.scene.locate(point, target);
        sector.set(found.map_or(0, |found| scene.sectors.id(found.0)));
        Ok(())
    })
}

/// Casts a ray through open portals. All faces stop it, from both sides.
///
/// @param from Where it starts.
/// @param direction 3 floats, of any length but 0: distances are multiples of it.
/// @param hit Receives where it ends.
///
/// Errors: ENFILADE_STATUS_NO_SUCH_ID, ENFILADE_STATUS_BAD_ARGUMENT.
#[allow(unsafe_code, reason = "called from C")]
#[unsafe(no_mangle)]
pub unsafe extern "C" fn enfilade_scene_cast_ray(
    scene: *const EnfiladeScene,
    from: *const EnfiladeLocation,
    direction: *const f32,
    hit: *mut EnfiladeHit,
    error: *mut EnfiladeError,
) -> EnfiladeStatus {
    // SAFETY: the promise of the caller, as the crate's documentation says.
    let caller = unsafe { Caller::new() };
    caller.call(error, |caller| {
        let out = caller.out(hit, "hit")?;
        let scene = handle::find(scene)?;
        let scene = scene.read()?;
        let from = scene.location(&caller.one(from, "from")?)?;
        let direction = caller.numbers::<f32, 3>(direction, "direction")?;
        check_finite("direction", &direction)?;
        let ray = Ray {
            origin: from.position,
            direction,
        };
        let cast = scene.scene.cast(from.sector, &ray);
        let (end, hit) = match cast.end {
            RayEnd::Face(hit) => (EnfiladeRayEnd::Face, Some(hit)),
            RayEnd::Closed(_) => (EnfiladeRayEnd::Closed, None),
            RayEnd::Limit(_) => (EnfiladeRayEnd::Limit, None),
            _ => (EnfiladeRayEnd::Nothing, None),
        };
        out.set(EnfiladeHit {
            distance: cast.distance,
            sector: scene.sectors.id(cast.sector.0),
            item: hit.map_or(0, |hit| scene.items.id_of(cast.sector, hit.item)),
            key: hit.map_or(0, |hit| hit.key),
            end: end as u32,
            from_behind: hit.map_or(0, |hit| u32::from(hit.from_behind)),
        });
        Ok(())
    })
}

/// Tests the line of sight between two locations, straight or through open portals. All faces block it.
///
/// @param sees Receives 1 if nothing is between them, else 0.
///
/// Errors: ENFILADE_STATUS_NO_SUCH_ID, ENFILADE_STATUS_BAD_ARGUMENT.
#[allow(unsafe_code, reason = "called from C")]
#[unsafe(no_mangle)]
pub unsafe extern "C" fn enfilade_scene_sees(
    scene: *const EnfiladeScene,
    from: *const EnfiladeLocation,
    to: *const EnfiladeLocation,
    sees: *mut u32,
    error: *mut EnfiladeError,
) -> EnfiladeStatus {
    // SAFETY: the promise of the caller, as the crate's documentation says.
    let caller = unsafe { Caller::new() };
    caller.call(error, |caller| {
        let sees = caller.out(sees, "sees")?;
        let scene = handle::find(scene)?;
        let scene = scene.read()?;
        let from = scene.location(&caller.one(from, "from")?)?;
        let to = scene.location(&caller.one(to, "to")?)?;
        sees.set(u32::from(scene.scene.sees(from, to).is_some()));
        Ok(())
    })
}

/// Finds the items within a distance, along ways through open portals. Walls within a sector are no obstacle.
///
/// @param radius In scene units, 0 or more.
/// @param items Receives up to @p capacity items, nearest first; null to get their number alone.
/// @param count Receives their number.
///
/// Errors: ENFILADE_STATUS_BUFFER_TOO_SMALL, ENFILADE_STATUS_NO_SUCH_ID, ENFILADE_STATUS_BAD_ARGUMENT; ENFILADE_STATUS_TOO_LARGE
/// if there are so many ways that some were not followed: items are missing.
#[allow(unsafe_code, reason = "called from C")]
#[unsafe(no_mangle)]
pub unsafe extern "C" fn enfilade_scene_near(
    scene: *const EnfiladeScene,
    from: *const EnfiladeLocation,
    radius: f32,
    items: *mut EnfiladeNearItem,
    capacity: usize,
    count: *mut usize,
    error: *mut EnfiladeError,
) -> EnfiladeStatus {
    // SAFETY: the promise of the caller, as the crate's documentation says.
    let caller = unsafe { Caller::new() };
    caller.call(error, |caller| {
        let buffer = caller.buffer(items, capacity, count, "items")?;
        let scene = handle::find(scene)?;
        let scene = scene.read()?;
        let from = scene.location(&caller.one(from, "from")?)?;
        if radius.is_nan() || radius < 0.0 {
            return Err(crate::status::refuse("c/radius", "radius must be 0 or more"));
        }
        let found = scene.scene.near(from, radius);
        buffer.fill(found.items.iter().map(|near| EnfiladeNearItem {
            key: near.key,
            item: scene.items.id_of(near.sector, near.item),
            sector: scene.sectors.id(near.sector.0),
            distance: near.distance,
        }))?;
        if found.complete {
            return Ok(());
        }
        Err(Failure::new(
            EnfiladeStatus::TooLarge,
            "c/incomplete",
            format_args!("only what is within {:.4} was searched", found.searched),
        ))
    })
}

/// Moves a point through the open portals that it crosses: a camera, a projectile. Nothing else stops it.
///
/// @param location Where it is; receives where it is then.
/// @param step 3 floats, in the space of the start.
/// @param there_from_here Null, or receives 16 floats: the transform from the space of the start to that of the end, for
/// velocities and orientations.
///
/// Errors: ENFILADE_STATUS_NO_SUCH_ID, ENFILADE_STATUS_BAD_ARGUMENT; the location stays as it was.
#[allow(unsafe_code, reason = "called from C")]
#[unsafe(no_mangle)]
pub unsafe extern "C" fn enfilade_scene_walk(
    scene: *const EnfiladeScene,
    location: *mut EnfiladeLocation,
    step: *const f32,
    there_from_here: *mut f32,
    error: *mut EnfiladeError,
) -> EnfiladeStatus {
    // SAFETY: the promise of the caller, as the crate's documentation says.
    let caller = unsafe { Caller::new() };
    caller.call(error, |caller| {
        let transform = caller.maybe_out(there_from_here.cast::<[f32; 16]>());
        let scene = handle::find(scene)?;
        let scene = scene.read()?;
        let from = scene.location(&caller.one(location, "location")?)?;
        let step = caller.numbers::<f32, 3>(step, "step")?;
        check_in_range("step", &step)?;
        let walked = scene.scene.walk(from, step);
        if let Some(transform) = transform {
            transform.set(matrix(&walked.there_from_here));
        }
        caller
            .out(location, "location")?
            .set(scene.location_out(&walked.location));
        Ok(())
    })
}

/// Moves a body: it slides along walls, climbs low steps, and passes through open portals. Add gravity to the step.
///
/// @param capsule The body; receives it as the portals have turned and scaled it.
/// @param location Where its centre is; receives where it is then.
/// @param step 3 floats, in the space of the start.
/// @param there_from_here Null, or receives 16 floats, as of enfilade_scene_walk.
/// @param on_ground Null, or receives 1 if it stands on something, else 0.
///
/// Errors: ENFILADE_STATUS_NO_SUCH_ID, ENFILADE_STATUS_BAD_ARGUMENT; the body stays as it was.
#[allow(unsafe_code, reason = "called from C")]
#[unsafe(no_mangle)]
pub unsafe extern "C" fn enfilade_scene_slide(
    scene: *const EnfiladeScene,
    capsule: *mut EnfiladeCapsule,
    location: *mut EnfiladeLocation,
    step: *const f32,
    there_from_here: *mut f32,
    on_ground: *mut u32,
    error: *mut EnfiladeError,
) -> EnfiladeStatus {
    // SAFETY: the promise of the caller, as the crate's documentation says.
    let caller = unsafe { Caller::new() };
    caller.call(error, |caller| {
        let transform = caller.maybe_out(there_from_here.cast::<[f32; 16]>());
        let on_ground = caller.maybe_out(on_ground);
        let scene = handle::find(scene)?;
        let scene = scene.read()?;
        let from = scene.location(&caller.one(location, "location")?)?;
        let step = caller.numbers::<f32, 3>(step, "step")?;
        check_in_range("step", &step)?;
        let body = caller.one(capsule, "capsule")?;
        let [x, y, z] = body.up;
        check_in_range("the capsule", &[body.radius, body.height, body.climb, x, y, z])?;
        if body.radius <= 0.0 || body.up == [0.0; 3] {
            return Err(crate::status::refuse(
                "c/capsule",
                "the radius of a capsule must be above 0, and its axis have a length",
            ));
        }
        let mut moved = Capsule::new(body.radius, body.height);
        moved.up = body.up;
        moved.climb = body.climb;
        let slid = moved.slide(&scene.scene, from, step);
        if let Some(transform) = transform {
            transform.set(matrix(&slid.there_from_here));
        }
        if let Some(on_ground) = on_ground {
            on_ground.set(u32::from(slid.on_ground));
        }
        caller.out(capsule, "capsule")?.set(EnfiladeCapsule {
            radius: slid.capsule.radius,
            height: slid.capsule.height,
            up: slid.capsule.up,
            climb: slid.capsule.climb,
        });
        caller
            .out(location, "location")?
            .set(scene.location_out(&slid.location));
        Ok(())
    })
}
