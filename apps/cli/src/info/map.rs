//! The part of `info` that only compiled maps have.

use crate::json::rounded;
use crate::leak::LeakEntry;
use crate::text::{bytes, count, plural};
use enfilade::{CellId, Geometry};
use enfilade_import::MapSummary;
use serde::Serialize;

/// Summary of a compiled map.
#[derive(Debug, Serialize)]
pub(super) struct MapEntry {
    format: String,
    leafs: usize,
    /// Quake 3 only.
    clusters: Option<usize>,
    faces: usize,
    models: usize,
    entities: usize,
    /// Size of the PVS, in bytes; 0 if none has been computed.
    visibility_bytes: usize,
    /// Mean share of all cells that is visible from a cell, 0 to 1; `None` without a PVS.
    visible_share: Option<f64>,
    /// Why there is no PVS and no portal file beside the map, if that is a leak.
    pub(super) leak: Option<LeakEntry>,
}

impl MapEntry {
    pub(super) fn of(map: &MapSummary, geometries: &[&Geometry], leak: Option<LeakEntry>) -> MapEntry {
        let cells = geometries.iter().find_map(|geometry| geometry.cells());
        let visible_share = cells.filter(|cells| cells.cell_count() > 0).map(|cells| {
            let ids = || (0..cells.cell_count() as u32).map(CellId);
            let seen: usize = ids()
                .map(|from| ids().filter(|&to| cells.may_see(from, to)).count())
                .sum();
            rounded(seen as f64 / (cells.cell_count() as f64).powi(2))
        });
        let MapSummary {
            format,
            leafs,
            clusters,
            faces,
            models,
            entities,
            visibility_bytes,
            ..
        } = map.clone();
        MapEntry {
            format,
            leafs,
            clusters,
            faces,
            models,
            entities,
            visibility_bytes,
            visible_share,
            leak,
        }
    }

    pub(super) fn for_people(&self) -> String {
        let clusters = self.clusters.map(|clusters| plural(clusters, "cluster"));
        let parts = [
            Some(plural(self.leafs, "leaf")),
            clusters,
            Some(plural(self.faces, "face")),
        ];
        let parts = parts.into_iter().flatten();
        let more = [
            plural(self.models, "model"),
            format!("{} entities", count(self.entities as u64)),
        ];
        parts.chain(more).collect::<Vec<_>>().join(", ")
    }

    pub(super) fn visible_for_people(&self) -> String {
        match self.visible_share {
            Some(share) => {
                let percent = 100.0 * share;
                format!(
                    "{percent:.1} % of the map from a leaf, in {}",
                    bytes(self.visibility_bytes as u64)
                )
            }
            None => "not computed (--method pvs needs it)".to_owned(),
        }
    }
}
