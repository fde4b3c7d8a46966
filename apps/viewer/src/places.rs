//! Where sectors are in one common space: that of the sector of a frozen camera.

use enfilade::{ItemIndex, Passage, PassageId, Scene, SectorId, Transform, View, Viewer};
use enfilade_wgpu::PlacedItem;

/// Colour of what is in view but hidden: linear red, green, blue and coverage.
pub const HIDDEN: [f32; 4] = [0.9, 0.25, 0.05, 0.16];
/// As [`HIDDEN`], of what is out of view.
pub const OUTSIDE: [f32; 4] = [0.25, 0.45, 0.9, 0.07];

/// Most ghosts that are drawn.
pub const MAX_GHOSTS: usize = 20_000;

/// A sector at a place of its own.
#[derive(Clone, Copy, Debug)]
pub struct SectorPlacement {
    /// The sector.
    pub sector: SectorId,
    /// Maps the space of the sector to that of the camera's sector.
    pub root_from_sector: Transform,
    /// The passage that shows it there; `None` if none does.
    pub passage: Option<PassageId>,
}

/// Returns the map from the space of a passage's sector to that of the camera's sector.
pub fn root_from_sector(view: &View, passage: &Passage) -> Transform {
    view.eye_from_sector().inverse().unwrap_or(Transform::IDENTITY) * passage.eye_from_sector()
}

/// Returns the places of all sectors: of each passage, and of each sector that no passage shows where portals lead to it.
pub fn places(scene: &Scene, viewer: &Viewer, view: &View) -> Vec<SectorPlacement> {
    let set = viewer.visible();
    let mut places: Vec<SectorPlacement> = (0..)
        .map(PassageId)
        .zip(set.passages())
        .map(|(id, passage)| SectorPlacement {
            sector: passage.sector,
            root_from_sector: root_from_sector(view, passage),
            passage: Some(id),
        })
        .collect();
    // From the camera's sector through all portals that do not mirror, open or not.
    let mut found: Vec<Option<Transform>> = vec![None; scene.sectors().count()];
    let mut pending: Vec<SectorId> = Vec::new();
    if let Some(first) = places.first() {
        found[first.sector.0 as usize] = Some(first.root_from_sector);
        pending.push(first.sector);
    }
    while let Some(sector) = pending.pop() {
        let Some(root_from_sector) = found[sector.0 as usize] else {
            continue;
        };
        for portal in scene.portals().iter().filter(|portal| portal.from == sector) {
            let there = &mut found[portal.to.0 as usize];
            if there.is_some() || portal.there_from_here.mirrors() {
                continue;
            }
            if let Some(back) = portal.there_from_here.inverse() {
                *there = Some(root_from_sector * back);
                pending.push(portal.to);
            }
        }
    }
    for sector in scene.sectors() {
        let root_from_sector = found[sector.0 as usize].unwrap_or(Transform::IDENTITY);
        let is_same = |place: &SectorPlacement| {
            place.sector == sector && same(&place.root_from_sector, &root_from_sector)
        };
        if !places.iter().any(is_same) {
            places.push(SectorPlacement {
                sector,
                root_from_sector,
                passage: None,
            });
        }
    }
    places
}

/// Whether two places are the same but for rounding.
fn same(a: &Transform, b: &Transform) -> bool {
    let (a, b) = (a.columns_f64(), b.columns_f64());
    a.iter()
        .flatten()
        .zip(b.iter().flatten())
        .all(|(a, b)| (a - b).abs() <= 1e-6 * (1.0 + a.abs()))
}

/// Returns all items at their places, the visible ones as they look and the others as ghosts, and the number of ghosts
/// that are too many to be drawn.
pub fn placed_items(
    scene: &Scene,
    viewer: &Viewer,
    places: &[SectorPlacement],
    ghosts: bool,
) -> (Vec<PlacedItem>, usize) {
    let set = viewer.visible();
    let mut items: Vec<PlacedItem> = Vec::new();
    for visible in set.items() {
        let place = &places[visible.passage.0 as usize];
        items.push(PlacedItem {
            sector: place.sector,
            item: visible.item.index,
            root_from_sector: place.root_from_sector,
            visible: Some(*visible),
            ghost: None,
        });
    }
    let (mut drawn, mut left_out) = (0, 0);
    let mut is_done = vec![false; scene.sectors().count()];
    // The last place of a sector is its own; a sector that one passage shows has only that.
    for place in places.iter().rev() {
        if std::mem::replace(&mut is_done[place.sector.0 as usize], true) || !ghosts {
            continue;
        }
        let Some(geometry) = scene.geometry(place.sector) else {
            continue;
        };
        let seen: Vec<ItemIndex> = match place.passage {
            Some(id) => {
                let of_passage = set.items().iter().filter(|item| item.passage == id);
                of_passage
                    .filter(|item| set.clusters(item).is_empty())
                    .map(|item| item.item.index)
                    .collect()
            }
            None => Vec::new(),
        };
        for item in (0..geometry.items().len() as u32).map(ItemIndex) {
            if !geometry.holds(item) || seen.binary_search(&item).is_ok() {
                continue;
            }
            if drawn == MAX_GHOSTS {
                left_out += 1;
                continue;
            }
            drawn += 1;
            let bounds = geometry.item(item).bounds;
            let in_view = set
                .passages()
                .iter()
                .any(|passage| passage.sector == place.sector && passage.may_show(&bounds));
            items.push(PlacedItem {
                sector: place.sector,
                item,
                root_from_sector: place.root_from_sector,
                visible: None,
                ghost: Some(if in_view { HIDDEN } else { OUTSIDE }),
            });
        }
    }
    (items, left_out)
}
