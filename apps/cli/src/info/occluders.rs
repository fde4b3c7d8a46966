//! The part of `info` about occluders.

use crate::json::rounded;
use enfilade::{Geometry, OccluderSet};
use serde::Serialize;
use std::time::Instant;

/// Summary of the occluders of a scene: large convex polygons merged from coplanar faces.
#[derive(Debug, Default, Serialize)]
pub(super) struct Occluders {
    /// Polygons of all meshes, each mesh counted once.
    pub(super) polygons: u64,
    /// Polygons of all items.
    pub(super) polygons_placed: u64,
    /// Triangles merged into the polygons, each mesh counted once.
    pub(super) triangles_merged: u64,
    /// Share of the opaque area of all items that the polygons cover, 0 to 1.
    pub(super) area_share: f64,
    pub(super) bytes: u64,
    pub(super) build_ms: f64,
}

impl Occluders {
    pub(super) fn of(geometries: &[&Geometry]) -> Occluders {
        let start = Instant::now();
        let sets: Vec<OccluderSet> = geometries
            .iter()
            .map(|geometry| OccluderSet::build(geometry))
            .collect();
        let build_ms = rounded(1e3 * start.elapsed().as_secs_f64());
        let mut occluders = Occluders {
            build_ms,
            ..Occluders::default()
        };
        let (mut area, mut opaque_area) = (0.0, 0.0);
        for (set, geometry) in sets.iter().zip(geometries) {
            let summary = set.summary(geometry);
            occluders.polygons += summary.polygons;
            occluders.polygons_placed += summary.placed;
            occluders.triangles_merged += summary.triangles;
            occluders.bytes += summary.bytes;
            area += summary.area;
            opaque_area += summary.opaque_area;
        }
        occluders.area_share = rounded(if opaque_area > 0.0 {
            area / opaque_area
        } else {
            0.0
        });
        occluders
    }
}
