//! Which items of a scene hide nothing, and why.

use crate::names::Names;
use crate::open::OpenedScene;
use crate::text::{count, plural};
use enfilade::{Geometry, ItemIndex, SectorId};
use enfilade_import::{NonOccluder, NonOccluders};
use serde::Serialize;
use std::collections::{BTreeMap, BTreeSet};
use std::fmt::Write;

/// An item of which some faces hide nothing.
#[derive(Clone, Debug, Serialize)]
pub(crate) struct NonOccluderItem {
    item: String,
    reasons: BTreeSet<NonOccluder>,
    /// Whether faces of other materials hide what is behind them.
    hides_partly: bool,
}

/// What hides nothing for one reason.
#[derive(Debug, Serialize)]
pub(crate) struct NonOccluderCount {
    reason: NonOccluder,
    items: usize,
    triangles: u64,
}

/// Lists the items of which some faces hide nothing, in the order of the scene.
pub(crate) fn list(opened: &OpenedScene) -> Vec<NonOccluderItem> {
    let names = Names::new(&opened.scene);
    let mut items = Vec::new();
    visit(opened, |sector, item, reasons, occluding| {
        if !reasons.is_empty() {
            items.push(NonOccluderItem {
                item: names.of((sector, item)),
                reasons: reasons.keys().copied().collect(),
                hides_partly: occluding > 0,
            });
        }
    });
    items
}

/// Returns the text of a list.
pub(crate) fn for_people(items: &[NonOccluderItem]) -> String {
    let mut text = match items.len() {
        0 => "all faces of all items hide what is behind them\n".to_owned(),
        some => format!("{} with faces that hide nothing:\n", plural(some, "item")),
    };
    for item in items {
        let reasons: Vec<&str> = item.reasons.iter().map(|reason| reason.name()).collect();
        let part = if item.hides_partly {
            "; other faces hide"
        } else {
            ""
        };
        // Writing to a String cannot fail.
        let _ = writeln!(text, "  {}: {}{part}", item.item, reasons.join(", "));
    }
    text
}

/// Counts what hides nothing, by reason, and the triangles that hide what is behind them.
pub(crate) fn counts(opened: &OpenedScene) -> (Vec<NonOccluderCount>, u64) {
    let mut totals: BTreeMap<NonOccluder, (usize, u64)> = BTreeMap::new();
    let mut all_occluding = 0;
    visit(opened, |_, _, reasons, occluding| {
        all_occluding += occluding;
        for (&reason, &triangles) in reasons {
            let total = totals.entry(reason).or_default();
            total.0 += 1;
            total.1 += triangles;
        }
    });
    let entry = |(reason, (items, triangles))| NonOccluderCount {
        reason,
        items,
        triangles,
    };
    (totals.into_iter().map(entry).collect(), all_occluding)
}

impl NonOccluderCount {
    pub(crate) fn for_people(&self) -> String {
        let items = plural(self.items, "item");
        format!("{}: {items}, {} triangles", self.reason, count(self.triangles))
    }
}

/// Calls `found` for each item with the triangles that hide nothing, by reason, and the number of those that do.
fn visit(opened: &OpenedScene, mut found: impl FnMut(SectorId, ItemIndex, &BTreeMap<NonOccluder, u64>, u64)) {
    // Built-in scenes have no reasons but those that their materials and options tell.
    let untold = NonOccluders::default();
    for sector in opened.scene.sectors() {
        let Some(geometry) = opened.scene.geometry(sector) else {
            continue;
        };
        let told = opened.non_occluders.get(sector.0 as usize).unwrap_or(&untold);
        for item in (0..geometry.items().len() as u32).map(ItemIndex) {
            let (reasons, occluding) = triangles_by_reason(geometry, told, item);
            found(sector, item, &reasons, occluding);
        }
    }
}

fn triangles_by_reason(
    geometry: &Geometry,
    told: &NonOccluders,
    item: ItemIndex,
) -> (BTreeMap<NonOccluder, u64>, u64) {
    let of_item = told.of_whole_item(geometry, item);
    let mut reasons = BTreeMap::new();
    let mut occluding = 0;
    let mesh = geometry.mesh_of(item);
    for (number, cluster) in mesh.clusters().iter().enumerate() {
        match of_item.or_else(|| told.of_material(geometry, cluster.material)) {
            Some(reason) => *reasons.entry(reason).or_default() += mesh.triangles_in(number),
            None => occluding += mesh.triangles_in(number),
        }
    }
    (reasons, occluding)
}
