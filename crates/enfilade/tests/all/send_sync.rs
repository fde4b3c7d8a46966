//! Public types can be moved to other threads and shared between them.

use enfilade::*;
use std::path::Path;

const fn is_send_and_sync<T: Send + Sync>() {}

/// Compiles only if all of these are `Send + Sync`: what an engine keeps from frame to frame.
const _: () = {
    is_send_and_sync::<Mesh>();
    is_send_and_sync::<Part>();
    is_send_and_sync::<Geometry>();
    is_send_and_sync::<GeometryBuilder>();
    is_send_and_sync::<Scene>();
    is_send_and_sync::<SceneBuilder>();
    is_send_and_sync::<Edit>();
    is_send_and_sync::<OccluderSet>();
    is_send_and_sync::<OccluderMesh>();
    is_send_and_sync::<View>();
    is_send_and_sync::<Viewer>();
    is_send_and_sync::<ViewerOptions>();
    is_send_and_sync::<VisibleSet>();
    is_send_and_sync::<VisibleItem>();
    is_send_and_sync::<Passage>();
    is_send_and_sync::<Aperture>();
    is_send_and_sync::<Collector>();
    is_send_and_sync::<Memory>();
    is_send_and_sync::<SceneError>();
    is_send_and_sync::<EditError>();
};

#[test]
fn the_listing_of_the_public_api_has_no_type_that_must_stay_on_one_thread() {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("public-api.txt");
    let listing = std::fs::read_to_string(path).expect("the listing");
    assert!(listing.contains("pub struct enfilade::Viewer"));
    let bound = ["Send", "Sync"].map(|kind| format!("impl !core::marker::{kind} for"));
    let bound: Vec<&str> = (listing.lines())
        .filter(|line| bound.iter().any(|kind| line.contains(kind)))
        .collect();
    assert!(bound.is_empty(), "{bound:#?}");
}
