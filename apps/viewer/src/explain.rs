//! Why an item is drawn, or is not.

use crate::places::root_from_sector;
use enfilade::{Aabb, ItemIndex, Passage, PassageId, Ray, RayEnd, Scene, SectorId, View, VisibleSet};
use glam::DVec3;
use std::collections::BTreeMap;

/// Why an item is in a visible set, or is not.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Explanation {
    /// Name of the item.
    pub name: String,
    /// Whether it is in the set.
    pub is_visible: bool,
    /// The reasons, one sentence each.
    pub reasons: Vec<String>,
}

/// Points along each axis of a box that rays are cast to.
const POINTS: u32 = 4;

/// Explains why an item of a sector is in the set of a look of `view`, or is not.
pub fn explain(
    scene: &Scene,
    view: &View,
    set: &VisibleSet,
    sector: SectorId,
    item: ItemIndex,
) -> Explanation {
    let mut reasons = Vec::new();
    let entries = set
        .items()
        .iter()
        .filter(|entry| entry.item.index == item && set.passage(entry.passage).sector == sector);
    for entry in entries {
        let way = way(scene, set, entry.passage);
        let parts = match (scene.geometry(sector), set.clusters(entry).len()) {
            (Some(geometry), shown) if shown > 0 => {
                let all = geometry.mesh_of(item).clusters().len();
                format!("; {shown} of its {all} clusters are drawn")
            }
            _ => String::new(),
        };
        reasons.push(format!(
            "Visible {way}, {} pixels on its longer side{parts}.",
            entry.size_px
        ));
    }
    let is_visible = !reasons.is_empty();
    if !is_visible {
        not_visible(scene, view, set, (sector, item), &mut reasons);
    }
    Explanation {
        name: name(scene, sector, item),
        is_visible,
        reasons,
    }
}

/// Returns the name of an item, or its number if it has none.
pub fn name(scene: &Scene, sector: SectorId, item: ItemIndex) -> String {
    let name = match scene.geometry(sector) {
        Some(geometry) => geometry.name(item).to_owned(),
        None => scene.sector(sector).item_name(item),
    };
    if name.is_empty() {
        format!("item {}", item.0)
    } else {
        name
    }
}

fn not_visible(
    scene: &Scene,
    view: &View,
    set: &VisibleSet,
    (sector, item): (SectorId, ItemIndex),
    reasons: &mut Vec<String>,
) {
    let passages: Vec<&Passage> = set
        .passages()
        .iter()
        .filter(|passage| passage.sector == sector)
        .collect();
    if passages.is_empty() {
        reasons.push(format!(
            "Its sector `{}` is not visible: no chain of open portals leads there within the view.",
            scene.sector_name(sector)
        ));
        for portal in scene
            .portals()
            .iter()
            .filter(|portal| portal.to == sector && portal.from != sector)
        {
            let from = scene.sector_name(portal.from);
            let opening = &scene.sector(portal.from).openings()[usize::from(portal.opening.0)].name;
            let is_seen = set.passages().iter().any(|passage| passage.sector == portal.from);
            reasons.push(match (portal.open, is_seen) {
                (false, _) => format!("The portal `{opening}` from `{from}` is closed."),
                (true, true) => {
                    format!("The portal `{opening}` from `{from}` is outside the view, or hidden.")
                }
                (true, false) => format!(
                    "The portal `{opening}` from `{from}` is open, but `{from}` is not visible either."
                ),
            });
        }
        return;
    }
    let bounds = match scene.geometry(sector) {
        Some(geometry) => geometry.item(item).bounds,
        None => scene.sector(sector).item_bounds(item),
    };
    let showing: Vec<&&Passage> = passages
        .iter()
        .filter(|passage| passage.may_show(&bounds))
        .collect();
    if showing.is_empty() {
        reasons.push(match passages.iter().any(|passage| passage.parent.is_none()) {
            true => "It is outside the view frustum.".to_owned(),
            false => "Its sector is visible, but it is outside what the portals show of it.".to_owned(),
        });
        let ids = (0..).map(PassageId).zip(set.passages());
        let through = ids.filter(|(_, passage)| passage.sector == sector && passage.parent.is_some());
        for (id, passage) in through.take(3) {
            let [_, _, width, height] = passage.scissor();
            reasons.push(format!(
                "The sector is seen {}, in {width} x {height} pixels (white outline).",
                way(scene, set, id)
            ));
        }
        return;
    }
    for passage in showing {
        let root_from_sector = root_from_sector(view, passage);
        let (mut rays, mut reached) = (0, 0);
        let mut blockers: BTreeMap<String, u32> = BTreeMap::new();
        let Some(start) = scene.sector_of(view) else {
            continue;
        };
        let eye = DVec3::from(view.eye());
        for number in 0..POINTS.pow(3) {
            let part = [0, 1, 2]
                .map(|axis| (f64::from(number / POINTS.pow(axis) % POINTS) + 0.5) / f64::from(POINTS));
            let [min, max] = [bounds.min, bounds.max].map(|corner| DVec3::from(corner.map(f64::from)));
            let inside: [f32; 3] = (min + (max - min) * DVec3::from(part)).as_vec3().into();
            // What hides the rest of the box hides nothing that is in view.
            let at_inside = Aabb {
                min: inside,
                max: inside,
            };
            if !passage.may_show(&at_inside) {
                continue;
            }
            let target = DVec3::from(root_from_sector.point(inside).map(f64::from));
            let direction = target - eye;
            let cast = scene.cast(
                start,
                &Ray {
                    origin: eye.as_vec3().into(),
                    direction: direction.as_vec3().into(),
                },
            );
            rays += 1;
            match cast.end {
                RayEnd::Face(hit) if cast.sector == sector && hit.item.index == item => reached += 1,
                RayEnd::Face(hit) if cast.distance < 1.0 => {
                    *blockers
                        .entry(name(scene, cast.sector, hit.item.index))
                        .or_default() += 1;
                }
                RayEnd::Closed(_) if cast.distance < 1.0 => {
                    *blockers.entry("a closed portal".to_owned()).or_default() += 1;
                }
                _ => {}
            }
        }
        let beside = rays - reached - blockers.values().sum::<u32>();
        let mut blockers: Vec<(String, u32)> = blockers.into_iter().collect();
        blockers.sort_by_key(|(_, count)| std::cmp::Reverse(*count));
        let mut list: Vec<String> = blockers
            .iter()
            .take(4)
            .map(|(name, count)| format!("{name} ({count})"))
            .collect();
        if blockers.len() > list.len() {
            let others: u32 = blockers[list.len()..].iter().map(|(_, count)| count).sum();
            list.push(format!("others ({others})"));
        }
        reasons.push(match list.is_empty() {
            true if rays == 0 => "Only the edges of its box are in view.".to_owned(),
            true => "It is in view, but covers no pixel: it is too small, or its faces show their backs."
                .to_owned(),
            false => format!(
                "It is in view but hidden. Of {rays} rays to points of its box that are in view, these are stopped by: {}.",
                list.join(", ")
            ),
        });
        if beside > 0 && !list.is_empty() {
            reasons.push(format!("{beside} rays pass beside its faces."));
        }
        if reached > 0 {
            reasons.push(format!(
                "{reached} rays reach it between the samples of the pixels, or through faces that do not hide."
            ));
        }
    }
}

/// Returns through which portals a passage leads.
fn way(scene: &Scene, set: &VisibleSet, id: PassageId) -> String {
    let mut names = Vec::new();
    let mut passage = set.passage(id);
    while let (Some(portal), Some(parent)) = (passage.portal, passage.parent) {
        let portal = &scene.portals()[portal.0 as usize];
        let opening = &scene.sector(portal.from).openings()[usize::from(portal.opening.0)];
        names.push(format!("`{}`", opening.name));
        passage = set.passage(parent);
    }
    names.reverse();
    match names.len() {
        0 => "in the camera's own sector".to_owned(),
        1 => format!("through {}", names[0]),
        count if count > 6 => format!(
            "through {count} portals, from {} to {}",
            names[0],
            names[count - 1]
        ),
        _ => format!("through {}", names.join(", then ")),
    }
}
