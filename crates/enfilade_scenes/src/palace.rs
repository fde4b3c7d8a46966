//! The built-in palace: an enfilade of twelve rooms, with a gallery, a court and cabinets beside it, a garden before
//! its last rooms, and a gallery of convex cells along the garden.
//!
//! A file: `tools/palace` of the repository generates it.

use crate::BuiltIn;
use enfilade::{Camera, Method};
use enfilade_import::{ReadOptions, read_bytes};

/// The palace as glTF.
pub const PALACE: &[u8] = include_bytes!("palace.glb");

/// Reads the palace.
pub(crate) fn palace() -> BuiltIn {
    let import = read_bytes(PALACE, None, &ReadOptions::default()).expect("the palace is a sound file");
    let camera = |camera: &Camera| Camera {
        z_near: None,
        ..camera.clone()
    };
    BuiltIn {
        scene: (import.scene(Method::HierarchicalZ, Method::DEFAULT_LIMIT)).expect("the palace stands"),
        cameras: import.cameras.iter().map(camera).collect(),
    }
}
