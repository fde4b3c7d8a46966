//! The occlusion buffer alone: no scene, no ids; draw occluders, test boxes.

use crate::handle::{self, Handle};
use crate::items::transform;
use crate::lent::Caller;
use crate::mesh::EnfiladeMeshPart;
use crate::status::{EnfiladeError, EnfiladeStatus, Failure, border};
use crate::version::check_version;
use crate::view::EnfiladeView;
use enfilade::{Aabb, Indices, OccluderMesh, OcclusionBuffer, Transform};
use std::sync::Arc;

/// Triangles that occlude. Immutable.
pub struct EnfiladeOccluder {
    _opaque: (),
}

impl Handle for EnfiladeOccluder {
    type Object = Arc<OccluderMesh>;
    const NAME: &'static str = "occluder";
}

/// A software depth buffer, for engines that keep their own scene: begin a view, draw occluders, test what they hide.
///
/// Nothing visible at a pixel centre is reported hidden, as long as occluders are opaque and no larger than what is drawn. Tests
/// may run on several threads at once; enfilade_occlusion_begin and enfilade_occlusion_draw must be alone.
pub struct EnfiladeOcclusion {
    _opaque: (),
}

impl Handle for EnfiladeOcclusion {
    type Object = OcclusionState;
    const NAME: &'static str = "occlusion buffer";
}

pub(crate) struct OcclusionState {
    buffer: OcclusionBuffer,
    size: [u32; 2],
}

/// Boxes that are copied and tested at a time.
const AT_A_TIME: usize = 512;

/// Creates an occluder from triangles. Free it with enfilade_occluder_free.
///
/// @param version ENFILADE_VERSION.
/// @param part The triangles; their material is ignored. The largest first is best.
/// @param double_sided 1 if faces hide from both sides, 0 if only from their front.
/// @param occluder Receives the occluder.
///
/// Errors: ENFILADE_STATUS_BAD_MESH, with the index of the triangle.
#[allow(unsafe_code, reason = "called from C")]
#[unsafe(no_mangle)]
pub unsafe extern "C" fn enfilade_occluder_create(
    version: u32,
    part: *const EnfiladeMeshPart,
    double_sided: u32,
    occluder: *mut *mut EnfiladeOccluder,
    error: *mut EnfiladeError,
) -> EnfiladeStatus {
    // SAFETY: the promise of the caller, as the crate's documentation says.
    let caller = unsafe { Caller::new() };
    caller.call(error, |caller| {
        let occluder = caller.out(occluder, "occluder")?;
        check_version(version)?;
        let part = caller.one(part, "part")?;
        let positions = caller.list::<[f32; 3]>(
            part.positions.cast(),
            part.position_stride,
            part.position_count,
            "positions",
        )?;
        let positions: Vec<[f32; 3]> = positions.iter().collect();
        let indices: Vec<u32> = match part.indices(caller)? {
            Indices::U16(indices) => indices.iter().map(|&index| index.into()).collect(),
            Indices::U32(indices) => indices.to_vec(),
        };
        let mut mesh = OccluderMesh::triangles(&positions, &indices)?;
        mesh.double_sided = double_sided != 0;
        occluder.set(handle::create(Arc::new(mesh))?);
        Ok(())
    })
}

/// Frees an occluder. Null is ignored.
///
/// Errors: ENFILADE_STATUS_BAD_HANDLE if it was freed before.
#[allow(unsafe_code, reason = "called from C")]
#[unsafe(no_mangle)]
pub extern "C" fn enfilade_occluder_free(occluder: *mut EnfiladeOccluder) -> EnfiladeStatus {
    border(|| handle::free(occluder))
}

/// Creates an occlusion buffer. Until enfilade_occlusion_begin, everything is visible. Free it with enfilade_occlusion_free.
///
/// @param version ENFILADE_VERSION.
/// @param occlusion Receives the buffer.
#[allow(unsafe_code, reason = "called from C")]
#[unsafe(no_mangle)]
pub unsafe extern "C" fn enfilade_occlusion_create(
    version: u32,
    occlusion: *mut *mut EnfiladeOcclusion,
    error: *mut EnfiladeError,
) -> EnfiladeStatus {
    // SAFETY: the promise of the caller, as the crate's documentation says.
    let caller = unsafe { Caller::new() };
    caller.call(error, |caller| {
        let occlusion = caller.out(occlusion, "occlusion")?;
        check_version(version)?;
        let mut buffer = OcclusionBuffer::new();
        buffer.parallel = false;
        let size = [0, 0];
        occlusion.set(handle::create(OcclusionState { buffer, size })?);
        Ok(())
    })
}

/// Frees an occlusion buffer. Null is ignored.
///
/// Errors: ENFILADE_STATUS_BAD_HANDLE if it was freed before.
#[allow(unsafe_code, reason = "called from C")]
#[unsafe(no_mangle)]
pub extern "C" fn enfilade_occlusion_free(occlusion: *mut EnfiladeOcclusion) -> EnfiladeStatus {
    border(|| handle::free(occlusion))
}

/// Clears the buffer and sets the view of the draws and tests to come. It takes half a byte per pixel of the viewport.
///
/// @param view The view; its sector is ignored.
///
/// Errors: ENFILADE_STATUS_BAD_VIEW.
#[allow(unsafe_code, reason = "called from C")]
#[unsafe(no_mangle)]
pub unsafe extern "C" fn enfilade_occlusion_begin(
    occlusion: *mut EnfiladeOcclusion,
    view: *const EnfiladeView,
    error: *mut EnfiladeError,
) -> EnfiladeStatus {
    // SAFETY: the promise of the caller, as the crate's documentation says.
    let caller = unsafe { Caller::new() };
    caller.call(error, |caller| {
        let occlusion = handle::find(occlusion)?;
        let mut occlusion = occlusion.write()?;
        let view = caller.one(view, "view")?.anywhere()?;
        occlusion.size = view.size();
        occlusion.buffer.begin(&view);
        Ok(())
    })
}

/// Draws instances of an occluder: what is behind them is hidden from then on. Nearest first is fastest, and hides most.
///
/// An instance with a transform that is refused hides nothing; the status and the index of the error are those of the first.
///
/// @param transforms World-from-mesh transforms: 16 floats each, column after column.
/// @param stride Bytes from one transform to the next, at least 64; 0 for 64.
/// @param count Number of instances.
///
/// Errors: ENFILADE_STATUS_BAD_ARGUMENT.
#[allow(unsafe_code, reason = "called from C")]
#[unsafe(no_mangle)]
pub unsafe extern "C" fn enfilade_occlusion_draw(
    occlusion: *mut EnfiladeOcclusion,
    occluder: *const EnfiladeOccluder,
    transforms: *const f32,
    stride: usize,
    count: usize,
    error: *mut EnfiladeError,
) -> EnfiladeStatus {
    // SAFETY: the promise of the caller, as the crate's documentation says.
    let caller = unsafe { Caller::new() };
    caller.call(error, |caller| {
        let occlusion = handle::find(occlusion)?;
        let mut occlusion = occlusion.write()?;
        let occluder = handle::find(occluder)?;
        let occluder = occluder.read()?;
        let transforms = caller.list::<[f32; 16]>(transforms.cast(), stride, count, "transforms")?;
        let mut first: Option<Failure> = None;
        let mut number = 0;
        let placed = transforms.iter().filter_map(|columns| {
            let transform = transform(&columns);
            number += 1;
            let place = |transform: Transform| (&**occluder, transform);
            match transform {
                Ok(transform) => Some(place(transform)),
                Err(why) => {
                    first.get_or_insert(why.at(number - 1));
                    None
                }
            }
        });
        occlusion.buffer.draw_all(placed);
        first.map_or(Ok(()), Err)
    })
}

/// Tests boxes: sets bit i % 64 of word i / 64 to 1 if any part of box i may be visible, and to 0 if occluders hide all of it or it
/// is out of view. Empty boxes are hidden, boxes that are not finite visible.
///
/// @param boxes 6 floats each: lower corner, upper corner, in world space.
/// @param stride Bytes from one box to the next, at least 24; 0 for 24. Any alignment.
/// @param count Number of boxes.
/// @param visible One word for each 64 boxes.
///
/// Allocates nothing.
#[allow(unsafe_code, reason = "called from C")]
#[unsafe(no_mangle)]
pub unsafe extern "C" fn enfilade_occlusion_test_boxes(
    occlusion: *const EnfiladeOcclusion,
    boxes: *const f32,
    stride: usize,
    count: usize,
    visible: *mut u64,
    error: *mut EnfiladeError,
) -> EnfiladeStatus {
    // SAFETY: the promise of the caller, as the crate's documentation says.
    let caller = unsafe { Caller::new() };
    caller.call(error, |caller| {
        let visible = caller.slice_mut(visible, count.div_ceil(64), "visible")?;
        visible.fill(0);
        let occlusion = handle::find(occlusion)?;
        let occlusion = occlusion.read()?;
        let mut boxes = caller
            .list::<[f32; 6]>(boxes.cast(), stride, count, "boxes")?
            .iter();
        let mut copied = [Aabb::EMPTY; AT_A_TIME];
        for words in visible.chunks_mut(AT_A_TIME / 64) {
            let mut length = 0;
            for (to, [x, y, z, to_x, to_y, to_z]) in copied.iter_mut().zip(boxes.by_ref()) {
                *to = Aabb {
                    min: [x, y, z],
                    max: [to_x, to_y, to_z],
                };
                length += 1;
            }
            occlusion.buffer.test_boxes(&copied[..length], words);
        }
        Ok(())
    })
}

/// Copies the depth buffer, to show it: reversed depth (1 / distance along the view direction; larger is nearer, 0 where nothing
/// hides) at each pixel, row by row from the top.
///
/// @param depths Receives up to @p capacity floats; null to get their number alone.
/// @param count Receives their number: width x height of the view.
///
/// Errors: ENFILADE_STATUS_BUFFER_TOO_SMALL.
#[allow(unsafe_code, reason = "called from C")]
#[unsafe(no_mangle)]
pub unsafe extern "C" fn enfilade_occlusion_depths(
    occlusion: *const EnfiladeOcclusion,
    depths: *mut f32,
    capacity: usize,
    count: *mut usize,
    error: *mut EnfiladeError,
) -> EnfiladeStatus {
    // SAFETY: the promise of the caller, as the crate's documentation says.
    let caller = unsafe { Caller::new() };
    caller.call(error, |caller| {
        let buffer = caller.buffer(depths, capacity, count, "depths")?;
        let occlusion = handle::find(occlusion)?;
        let occlusion = occlusion.read()?;
        if depths.is_null() {
            let [width, height] = occlusion.size.map(|side| side as usize);
            return buffer.fill(std::iter::repeat_n(0.0, width * height));
        }
        buffer.fill(occlusion.buffer.depth())
    })
}
