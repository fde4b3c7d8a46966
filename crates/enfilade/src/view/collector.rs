//! The output of one sector for one passage: items, openings and transparent samples.

use crate::geometry::{Geometry, Owner, Owners};
use crate::ids::{ItemIndex, OpeningId, PassageId};
use crate::view::aperture::Rows;
use crate::view::canvas::{Canvas, Span};
use crate::view::visible::VisibleSet;
use std::cmp::Reverse;

/// Collects what a sector reports for one passage: visible items, visible openings and transparent samples.
///
/// The viewer passes an empty collector to [`Sector::gather`](crate::Sector::gather) and
/// [`Sector::draw`](crate::Sector::draw). Report each item and each opening once; repeats are not removed.
#[derive(Debug, Default)]
pub struct Collector {
    pub(crate) items: Vec<CollectedItem>,
    pub(crate) openings: Vec<CollectedOpening>,
    /// For each opening its index in `openings`. Entries of openings that are not reported are stale: compare the id.
    places: Vec<u32>,
    pub(crate) clusters: Vec<u32>,
    pub(crate) glass: Vec<GlassSample>,
    /// The samples of `glass` as spans; filled when the viewer goes on to draw behind the openings.
    pub(crate) panes: Panes,
    /// Number of samples that opaque faces own.
    pub(crate) samples_owned: u64,
    /// Whether every transparent sample is needed (drawing), or only the faces that have one (culling).
    pub(crate) paints: bool,
    /// Scratch buffers, and spare rows for reuse.
    pub(crate) report: ReportBuffers,
    pub(crate) spare_rows: Vec<Rows>,
}

/// Scratch buffers of covers for reporting; reused from passage to passage.
#[derive(Debug, Default)]
pub(crate) struct ReportBuffers {
    pub(crate) owners: Vec<(ItemIndex, u32)>,
    /// Direct-mapped caches of the faces and clusters that `owners` already holds, indexed by their number modulo the
    /// size; a colliding entry replaces the old one. Faces are stored by the lower half of their samples' owner.
    pub(crate) faces: Vec<u32>,
    pub(crate) clusters: Vec<(ItemIndex, u32)>,
    pub(crate) row: Vec<(u16, u16, Owner)>,
    pub(crate) spans: Vec<Span>,
}

/// An item that may be visible, with its visible clusters.
#[derive(Clone, Copy, Debug)]
pub(crate) struct CollectedItem {
    pub(crate) item: ItemIndex,
    /// Range of [`Collector::clusters`]; empty if the item has one cluster only, or the visible ones are unknown.
    pub(crate) clusters: [u32; 2],
}

/// An opening that may be visible, with the samples it owns if the method knows them.
#[derive(Debug)]
pub(crate) struct CollectedOpening {
    pub(crate) opening: OpeningId,
    pub(crate) rows: Option<Rows>,
}

/// A sample of an alpha-blended or alpha-tested face in front of all opaque faces.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct GlassSample {
    pub(crate) y: u16,
    pub(crate) x: u16,
    /// Bits of the reversed depth; positive floats and their bits have the same order.
    pub(crate) rev_depth: u32,
    pub(crate) item: ItemIndex,
    pub(crate) face: u32,
}

impl Collector {
    /// Reports an item that may be visible, with all its clusters. Report each item once.
    pub fn item(&mut self, item: ItemIndex) {
        self.items.push(CollectedItem {
            item,
            clusters: [0, 0],
        });
    }

    /// Reports an opening that may be visible, with the samples it owns, if known. Report each opening once.
    ///
    /// With `None` the clip region behind the opening is its projected outline within the aperture.
    pub fn opening(&mut self, opening: OpeningId, rows: Option<Rows>) {
        let number = usize::from(opening.0);
        if self.places.len() <= number {
            self.places.resize(number + 1, 0);
        }
        self.places[number] = self.openings.len() as u32;
        self.openings.push(CollectedOpening { opening, rows });
    }

    /// Adds samples `x0..x1` of row `y` to those that an opening owns. Call with rows from top to bottom.
    pub(crate) fn add_to_opening(&mut self, opening: OpeningId, y: u16, x0: u16, x1: u16) {
        let place = self
            .places
            .get(usize::from(opening.0))
            .map_or(0, |&place| place as usize);
        let known = self.openings.get_mut(place);
        if let Some(seen) = known.filter(|seen| seen.opening == opening) {
            seen.rows.get_or_insert_default().push(y, x0, x1);
        } else {
            let mut rows = self.spare_rows.pop().unwrap_or_default();
            rows.push(y, x0, x1);
            self.opening(opening, Some(rows));
        }
    }

    /// Reports a sample (x, y) of an alpha-blended or alpha-tested face that no opaque face hides; `rev_depth` is 1 /
    /// distance along the view direction.
    ///
    /// The viewer draws these samples far to near, after everything visible through the openings.
    #[inline]
    pub fn glass(&mut self, x: u16, y: u16, rev_depth: f32, item: ItemIndex, face: u32) {
        let same = |last: &GlassSample| last.item == item && last.face == face;
        if self.paints || !self.glass.last().is_some_and(same) {
            self.glass.push(GlassSample {
                y,
                x,
                rev_depth: rev_depth.to_bits(),
                item,
                face,
            });
        }
    }

    /// Returns the clusters of the reported items, sorted and without repeats if the items are; all clusters of an item
    /// that was reported as a whole.
    pub(crate) fn clusters_of_items(&self, owners: &dyn Owners) -> impl Iterator<Item = (ItemIndex, u32)> {
        self.items.iter().flat_map(|seen| {
            let some = &self.clusters[seen.clusters[0] as usize..seen.clusters[1] as usize];
            let all = if some.is_empty() {
                owners.cluster_count(seen.item)
            } else {
                0
            };
            some.iter()
                .copied()
                .chain(0..all)
                .map(|cluster| (seen.item, cluster))
        })
    }

    /// Reports the items and clusters that an earlier look gathered through passage `id`.
    pub(crate) fn report_again(&mut self, set: &VisibleSet, id: PassageId) {
        let first = set.items.partition_point(|item| item.passage < id);
        for item in set.items[first..].iter().take_while(|item| item.passage == id) {
            let start = self.clusters.len() as u32;
            self.clusters.extend_from_slice(set.clusters(item));
            self.items.push(CollectedItem {
                item: item.item.index,
                clusters: [start, self.clusters.len() as u32],
            });
        }
    }

    /// Clears everything but the items, so that they can be drawn.
    pub(crate) fn keep_items_alone(&mut self) {
        self.recycle();
        self.glass.clear();
        self.samples_owned = 0;
        self.paints = true;
    }

    /// Moves the rows of openings that will not be followed to the spare rows.
    pub(crate) fn recycle(&mut self) {
        for mut rows in self.openings.drain(..).filter_map(|opening| opening.rows) {
            rows.clear();
            self.spare_rows.push(rows);
        }
    }

    pub(crate) fn clear(&mut self, paints: bool) {
        self.items.clear();
        self.openings.clear();
        self.clusters.clear();
        self.glass.clear();
        self.panes.clear();
        self.samples_owned = 0;
        self.paints = paints;
    }
}

/// Transparent samples as rows of spans in drawing order: much smaller than the samples.
#[derive(Debug, Default)]
pub(crate) struct Panes {
    spans: Vec<Span>,
    /// For each layer of a row, the row number and the end of its spans.
    layers: Vec<(u16, usize)>,
}

impl Panes {
    /// Sorts transparent samples into layers. At each sample the farthest comes first; at equal depth the highest
    /// (item, face) comes first, so that the lowest is drawn last.
    pub(crate) fn fill(&mut self, glass: &mut [GlassSample]) {
        self.clear();
        glass.sort_unstable_by_key(|g| (g.y, g.x, g.rev_depth, Reverse((g.item, g.face))));
        // Layer by layer: the k-th farthest transparent faces of a row's samples are drawn together.
        for row in glass.chunk_by(|a, b| a.y == b.y) {
            for layer in 0.. {
                let start = self.spans.len();
                for sample in row.chunk_by(|a, b| a.x == b.x).filter_map(|same| same.get(layer)) {
                    let owner = Owner::Face(sample.item, sample.face);
                    match self.spans[start..].last_mut() {
                        Some(span) if span.x1 == sample.x && span.owner == owner => span.x1 += 1,
                        _ => self.spans.push(Span {
                            x0: sample.x,
                            x1: sample.x + 1,
                            owner,
                            see_through: true,
                        }),
                    }
                }
                if self.spans.len() == start {
                    break;
                }
                self.layers.push((row[0].y, self.spans.len()));
            }
        }
    }

    fn clear(&mut self) {
        self.spans.clear();
        self.layers.clear();
    }

    pub(crate) fn is_empty(&self) -> bool {
        self.layers.is_empty()
    }

    /// Draws the transparent spans over what the canvas already holds.
    pub(crate) fn paint(&self, canvas: &mut dyn Canvas) {
        let mut start = 0;
        for &(y, end) in &self.layers {
            canvas.row(y, &self.spans[start..end]);
            start = end;
        }
    }
}

/// Reports (item, cluster) pairs, in any order and with repeats, as items with their clusters.
pub(crate) fn report_owners(met: &mut Vec<(ItemIndex, u32)>, owners: &dyn Owners, seen: &mut Collector) {
    met.sort_unstable();
    met.dedup();
    for same in met.chunk_by(|a, b| a.0 == b.0) {
        let item = same[0].0;
        let start = seen.clusters.len() as u32;
        if owners.cluster_count(item) > 1 {
            seen.clusters.extend(same.iter().map(|&(_, cluster)| cluster));
        }
        seen.items.push(CollectedItem {
            item,
            clusters: [start, seen.clusters.len() as u32],
        });
    }
}

/// Clusters found by a traversal, in order of discovery: mostly item after item.
#[derive(Debug, Default)]
pub(crate) struct FoundClusters {
    runs: Vec<Run>,
    clusters: Vec<u32>,
}

/// Clusters of one item that were found in succession.
#[derive(Clone, Copy, Debug)]
struct Run {
    item: ItemIndex,
    clusters: [u32; 2],
    kind: RunKind,
}

/// How the clusters of a run are tested.
#[derive(Clone, Copy, Debug, PartialEq)]
enum RunKind {
    /// Each cluster is tested.
    Each,
    /// The clusters of a node of the item's mesh are tested together.
    Group(u32),
    /// All clusters of the item, which are not listed.
    Whole,
}

/// Clusters of an item that are kept or removed together.
#[derive(Clone, Copy, Debug)]
pub(crate) enum FoundPart<'a> {
    Cluster(u32),
    /// A node of the item's mesh, and its clusters.
    Group(u32, &'a [u32]),
}

impl FoundClusters {
    pub(crate) fn push(&mut self, item: ItemIndex, cluster: u32) {
        let end = self.clusters.len() as u32;
        match self.runs.last_mut() {
            Some(last) if last.item == item && last.kind == RunKind::Each => last.clusters[1] += 1,
            _ => self.runs.push(Run {
                item,
                clusters: [end, end + 1],
                kind: RunKind::Each,
            }),
        }
        self.clusters.push(cluster);
    }

    /// Adds the clusters of a node of the item's mesh, to be kept or removed together.
    pub(crate) fn push_group(&mut self, item: ItemIndex, node: u32, clusters: &[u32]) {
        let start = self.clusters.len() as u32;
        self.clusters.extend_from_slice(clusters);
        self.runs.push(Run {
            item,
            clusters: [start, self.clusters.len() as u32],
            kind: RunKind::Group(node),
        });
    }

    /// Moves the runs of all items for which `wanted` returns `true` from `found` to `self`; clears `found`.
    pub(crate) fn take_in(&mut self, found: &mut FoundClusters, mut wanted: impl FnMut(ItemIndex) -> bool) {
        for same in found.runs.chunk_by(|a, b| a.item == b.item) {
            if !wanted(same[0].item) {
                continue;
            }
            for run in same {
                let [first, end] = run.clusters.map(|place| place as usize);
                let start = self.clusters.len() as u32;
                self.clusters.extend_from_slice(&found.clusters[first..end]);
                let clusters = [start, self.clusters.len() as u32];
                self.runs.push(Run { clusters, ..*run });
            }
        }
        found.runs.clear();
        found.clusters.clear();
    }

    pub(crate) fn push_whole(&mut self, item: ItemIndex) {
        let end = self.clusters.len() as u32;
        self.runs.push(Run {
            item,
            clusters: [end; 2],
            kind: RunKind::Whole,
        });
    }

    /// Removes the clusters and groups for which `stays` returns `false`, item by item; whole items are kept.
    pub(crate) fn retain_by_item(&mut self, mut stays: impl FnMut(ItemIndex, FoundPart) -> bool) {
        self.sort_by_item();
        for run in &mut self.runs {
            let [first, end] = run.clusters.map(|place| place as usize);
            match run.kind {
                RunKind::Each => {
                    let mut kept = first;
                    for place in first..end {
                        let cluster = self.clusters[place];
                        if stays(run.item, FoundPart::Cluster(cluster)) {
                            self.clusters[kept] = cluster;
                            kept += 1;
                        }
                    }
                    run.clusters[1] = kept as u32;
                }
                RunKind::Group(node) => {
                    if !stays(run.item, FoundPart::Group(node, &self.clusters[first..end])) {
                        run.clusters[1] = run.clusters[0];
                    }
                }
                RunKind::Whole => {}
            }
        }
        self.runs
            .retain(|run| run.kind == RunKind::Whole || run.clusters[0] < run.clusters[1]);
    }

    /// Removes the items for which `stays` returns `false`; calls it once or more for each.
    pub(crate) fn retain_items(&mut self, mut stays: impl FnMut(ItemIndex) -> bool) {
        self.runs.retain(|run| stays(run.item));
    }

    fn sort_by_item(&mut self) {
        self.runs.sort_unstable_by_key(|run| (run.item, run.clusters[0]));
    }

    /// Reports all items with their clusters, sorted by item; clears `self`.
    pub(crate) fn report(&mut self, geometry: &Geometry, seen: &mut Collector) {
        self.sort_by_item();
        for same in self.runs.chunk_by(|a, b| a.item == b.item) {
            let item = same[0].item;
            let start = seen.clusters.len();
            if geometry.mesh_of(item).clusters().len() > 1
                && !same.iter().any(|run| run.kind == RunKind::Whole)
            {
                for run in same {
                    let [first, end] = run.clusters.map(|place| place as usize);
                    seen.clusters.extend_from_slice(&self.clusters[first..end]);
                }
                seen.clusters[start..].sort_unstable();
            }
            seen.items.push(CollectedItem {
                item,
                clusters: [start, seen.clusters.len()].map(|place| place as u32),
            });
        }
        self.runs.clear();
        self.clusters.clear();
    }
}

impl Owner {
    /// Returns the item of a face; `None` for an opening.
    pub fn item(self) -> Option<ItemIndex> {
        match self {
            Owner::Face(item, _) => Some(item),
            Owner::Opening(_) => None,
        }
    }
}
