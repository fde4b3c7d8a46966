//! Meshes, shared by the items that are instances of them.

use crate::handle::{self, Handle};
use crate::lent::Caller;
use crate::status::{EnfiladeError, EnfiladeStatus, Failure, border, refuse};
use crate::version::check_version;
use enfilade::{Attributes, Indices, MaterialId, Mesh, Part, Vertices};
use std::ffi::c_void;
use std::sync::Arc;

/// A mesh: triangles, or a box without any, for any number of items. Immutable. It stays in use by scenes after it was freed.
pub struct EnfiladeMesh {
    _opaque: (),
}

impl Handle for EnfiladeMesh {
    type Object = Arc<Mesh>;
    const NAME: &'static str = "mesh";
}

/// Triangles of one material. The arrays are read during the call only.
#[repr(C)]
#[derive(Clone, Copy)]
pub struct EnfiladeMeshPart {
    /// Positions, 3 floats each, in the space of the mesh: x, y, z.
    pub positions: *const f32,
    /// Number of positions.
    pub position_count: usize,
    /// Bytes from one position to the next, at least 12; 0 for 12. Any alignment.
    pub position_stride: usize,
    /// Three indices of positions per triangle, counter-clockwise as seen from its front. Aligned to their size.
    pub indices: *const c_void,
    /// Number of indices, a multiple of three.
    pub index_count: usize,
    /// Bytes per index: 2 (uint16_t) or 4 (uint32_t).
    pub index_size: u32,
    /// Index of the material in the table of the sector that the items are in.
    pub material: u32,
}

impl EnfiladeMeshPart {
    pub(crate) fn indices<'a>(&self, caller: &Caller<'a>) -> Result<Indices<'a>, Failure> {
        match self.index_size {
            2 => {
                let indices = caller.slice(self.indices.cast(), self.index_count, "indices")?;
                Ok(Indices::U16(indices))
            }
            4 => {
                let indices = caller.slice(self.indices.cast(), self.index_count, "indices")?;
                Ok(Indices::U32(indices))
            }
            other => Err(refuse(
                "c/index-size",
                format_args!("index_size is {other}; it must be 2 or 4"),
            )),
        }
    }
}

/// Creates a mesh from triangles. Free it with enfilade_mesh_free.
///
/// @param version ENFILADE_VERSION.
/// @param parts The parts, one for each material; none for a mesh without triangles, whose items are never visible. Positions
/// that no triangle uses may hold anything.
/// @param mesh Receives the mesh.
///
/// Errors: ENFILADE_STATUS_BAD_MESH for an index out of range, positions that are not finite or beyond 1e18, indices that are no
/// whole triangles; the index is that of the part.
#[allow(unsafe_code, reason = "called from C")]
#[unsafe(no_mangle)]
pub unsafe extern "C" fn enfilade_mesh_create(
    version: u32,
    parts: *const EnfiladeMeshPart,
    part_count: usize,
    mesh: *mut *mut EnfiladeMesh,
    error: *mut EnfiladeError,
) -> EnfiladeStatus {
    // SAFETY: the promise of the caller, as the crate's documentation says.
    let caller = unsafe { Caller::new() };
    caller.call(error, |caller| {
        let mesh = caller.out(mesh, "mesh")?;
        check_version(version)?;
        let lent: Vec<EnfiladeMeshPart> = caller.list(parts, 0, part_count, "parts")?.iter().collect();
        let mut borrowed = Vec::with_capacity(lent.len());
        for (number, part) in lent.iter().enumerate() {
            let positions = caller.list::<[f32; 3]>(
                part.positions.cast(),
                part.position_stride,
                part.position_count,
                "positions",
            );
            let part = positions.and_then(|positions| {
                let (bytes, stride) = positions.bytes();
                Ok(Part {
                    positions: Vertices::Strided { bytes, stride },
                    corners: part.indices(caller)?,
                    sides: None,
                    material: MaterialId(part.material),
                    attributes: Attributes::default(),
                })
            });
            borrowed.push(part.map_err(|failure| failure.at(number))?);
        }
        mesh.set(handle::create(Arc::new(Mesh::new(&borrowed)?))?);
        Ok(())
    })
}

/// Creates a mesh that is only a box: an item with it is visible where its box may be, and hides nothing. For skinned and
/// animated objects (a box around all poses), particles, lights, and objects whose triangles are not loaded yet.
///
/// @param version ENFILADE_VERSION.
/// @param box_min 3 floats, each less than in @p box_max.
/// @param box_max 3 floats.
/// @param mesh Receives the mesh.
///
/// Errors: ENFILADE_STATUS_BAD_MESH.
#[allow(unsafe_code, reason = "called from C")]
#[unsafe(no_mangle)]
pub unsafe extern "C" fn enfilade_mesh_create_box(
    version: u32,
    box_min: *const f32,
    box_max: *const f32,
    mesh: *mut *mut EnfiladeMesh,
    error: *mut EnfiladeError,
) -> EnfiladeStatus {
    // SAFETY: the promise of the caller, as the crate's documentation says.
    let caller = unsafe { Caller::new() };
    caller.call(error, |caller| {
        let mesh = caller.out(mesh, "mesh")?;
        check_version(version)?;
        let [min, max] = [
            caller.numbers(box_min, "box_min")?,
            caller.numbers(box_max, "box_max")?,
        ];
        mesh.set(handle::create(Arc::new(Mesh::bounds_only(min, max)?))?);
        Ok(())
    })
}

/// Frees a mesh. Items that use it keep it. Null is ignored.
///
/// Errors: ENFILADE_STATUS_BAD_HANDLE if it was freed before.
#[allow(unsafe_code, reason = "called from C")]
#[unsafe(no_mangle)]
pub extern "C" fn enfilade_mesh_free(mesh: *mut EnfiladeMesh) -> EnfiladeStatus {
    border(|| handle::free(mesh))
}
