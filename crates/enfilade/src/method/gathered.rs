//! Draws a visible set with a z-buffer: the picture is exact even if the set is conservative.
//!
//! Drawing is a second pass over the set of a look. In a single pass, the clip regions behind openings would come from
//! drawn samples and be narrower than in a look, so drawing and looking would return different sets.

use crate::cover::{DepthBuffer, Paints};
use crate::faces::Faces;
use crate::geometry::{Alpha, Geometry};
use crate::ids::ItemIndex;
use crate::view::canvas::Canvas;
use crate::view::collector::Collector;
use crate::view::memory::Memory;
use crate::view::passage::Passage;
use crate::view::region::Region;

/// Potentially visible clusters.
#[derive(Default)]
struct Gathered(Vec<(ItemIndex, u32)>);

/// Draws the visible set `seen` of a geometry, and replaces it with what is visible in the picture.
pub(super) fn draw_gathered(
    geometry: &Geometry,
    passage: &Passage,
    memory: &mut Memory,
    seen: &mut Collector,
    canvas: &mut dyn Canvas,
) {
    let mut cover = memory.take::<DepthBuffer>();
    let mut gathered = memory.take::<Gathered>();
    gathered.0.extend(seen.clusters_of_items(geometry));
    seen.items.clear();
    seen.clusters.clear();
    cover.clear(passage, memory.trace);
    let stats = &mut memory.stats;
    let before = seen.samples_owned;
    Faces::of_openings(geometry, passage, |faces| cover.add(faces, passage, stats, None));
    let hides = |&(item, cluster): &(ItemIndex, u32)| {
        let cluster = &geometry.mesh_of(item).clusters()[cluster as usize];
        geometry.material_of(item, cluster).alpha == Alpha::Opaque
    };
    // Occluders that are not drawn are in no set.
    for &item in geometry.not_drawn() {
        let placed = geometry.item(item);
        let screen_from_item = passage.screen_from(&placed.transform());
        let bounds = geometry.mesh_of(item).bounds();
        if passage.takes(placed) && Region::of(passage, &screen_from_item, &bounds).is_some() {
            let all = 0..geometry.mesh_of(item).clusters().len() as u32;
            gathered
                .0
                .extend(all.map(|cluster| (item, cluster)).filter(hides));
        }
    }
    for opaque in [true, false] {
        for &(item, cluster) in gathered.0.iter().filter(|found| hides(found) == opaque) {
            let screen_from_item = passage.screen_from(&geometry.item(item).transform());
            let faces = Faces::of_cluster(geometry, item, cluster, &screen_from_item);
            if opaque {
                cover.add(&faces, passage, stats, None);
            } else {
                cover.look_through(&faces, passage, stats, seen);
            }
        }
    }
    cover.finish(geometry, passage, seen, Some(canvas));
    stats.samples_owned += seen.samples_owned - before;
    gathered.0.clear();
    memory.put_back(cover);
    memory.put_back(gathered);
}
