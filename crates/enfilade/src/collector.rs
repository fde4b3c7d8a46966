//! What one sector reports through one passage.

use crate::aperture::Rows;
use crate::canvas::{Canvas, Span};
use crate::geometry::{Geometry, ItemId, OpeningId, Owner, Owners};
use crate::passage::PassageId;
use crate::visible::VisibleSet;
use std::cmp::Reverse;

/// Gathers what a sector sees through one passage; cleared for each.
#[derive(Debug, Default)]
pub struct Collector {
    pub(crate) items: Vec<CollectedItem>,
    pub(crate) openings: Vec<CollectedOpening>,
    /// For each opening its place in `openings`, if it is there: else any number.
    places: Vec<u32>,
    pub(crate) clusters: Vec<u32>,
    pub(crate) glass: Vec<GlassSample>,
    /// The same, while what is behind the openings is painted.
    pub(crate) panes: Panes,
    /// Samples that opaque faces own.
    pub(crate) samples_owned: u64,
    /// Is every sample of glass wanted, or only which glass is seen?
    pub(crate) paints: bool,
    /// Buffers to work with, and rows to fill.
    pub(crate) report: ReportBuffers,
    pub(crate) spare_rows: Vec<Rows>,
}

/// What covers work with to report; kept from one passage to the next.
#[derive(Debug, Default)]
pub(crate) struct ReportBuffers {
    pub(crate) owners: Vec<(ItemId, u32)>,
    /// Faces and clusters that are in `owners` already, each at a place that its number says; others come there too, and
    /// take the place over. Faces by the lower halves of their samples.
    pub(crate) faces: Vec<u32>,
    pub(crate) clusters: Vec<(ItemId, u32)>,
    pub(crate) row: Vec<(u16, u16, Owner)>,
    pub(crate) spans: Vec<Span>,
}

/// An item that may be seen, and which of its clusters.
#[derive(Clone, Copy, Debug)]
pub(crate) struct CollectedItem {
    pub(crate) item: ItemId,
    /// A run of [`Collector::clusters`]; empty where the item has only one, or it is not known which are seen.
    pub(crate) clusters: [u32; 2],
}

/// An opening that may be seen, and the samples it owns, where the method knows them.
#[derive(Debug)]
pub(crate) struct CollectedOpening {
    pub(crate) opening: OpeningId,
    pub(crate) rows: Option<Rows>,
}

/// A sample at which glass, or a cut-out, is in front of what hides.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct GlassSample {
    pub(crate) y: u16,
    pub(crate) x: u16,
    /// Bits of the reversed depth: they sort as the reversed depth does.
    pub(crate) rev_depth: u32,
    pub(crate) item: ItemId,
    pub(crate) face: u32,
}

impl Collector {
    /// Reports an item. Report each once.
    pub fn item(&mut self, item: ItemId) {
        self.items.push(CollectedItem {
            item,
            clusters: [0, 0],
        });
    }

    /// Reports an opening, and the samples it owns where they are known. Report each once.
    pub fn opening(&mut self, opening: OpeningId, rows: Option<Rows>) {
        let number = usize::from(opening.0);
        if self.places.len() <= number {
            self.places.resize(number + 1, 0);
        }
        self.places[number] = self.openings.len() as u32;
        self.openings.push(CollectedOpening { opening, rows });
    }

    /// Adds samples `x0..x1` of row `y` to those that an opening owns; rows come top to bottom.
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

    /// Reports that glass, or a cut-out, is in front at a sample; `rev_depth` is 1 / distance along the line of
    /// sight. It is painted after what is seen through the openings.
    #[inline]
    pub fn glass(&mut self, x: u16, y: u16, rev_depth: f32, item: ItemId, face: u32) {
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

    /// The clusters of the reported items, in order, each once; of items reported whole, all.
    pub(crate) fn clusters_of_items(&self, owners: &dyn Owners) -> impl Iterator<Item = (ItemId, u32)> {
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

    /// Reports what was gathered through the same passage.
    pub(crate) fn report_again(&mut self, set: &VisibleSet, id: PassageId) {
        let first = set.items.partition_point(|item| item.passage < id);
        for item in set.items[first..].iter().take_while(|item| item.passage == id) {
            let start = self.clusters.len() as u32;
            self.clusters.extend_from_slice(set.clusters(item));
            self.items.push(CollectedItem {
                item: item.item,
                clusters: [start, self.clusters.len() as u32],
            });
        }
    }

    /// Only the items that were gathered are left, to be painted.
    pub(crate) fn keep_items_alone(&mut self) {
        self.recycle();
        self.glass.clear();
        self.samples_owned = 0;
        self.paints = true;
    }

    /// Takes the rows of openings that nobody follows, to be filled anew.
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

/// Glass as rows of spans, in the order in which it is painted: far smaller than its samples.
#[derive(Debug, Default)]
pub(crate) struct Panes {
    spans: Vec<Span>,
    /// Of each layer of a row the row's number, and where its spans end.
    layers: Vec<(u16, usize)>,
}

impl Panes {
    /// Takes samples of glass: at each place the farthest comes first, of equally near ones the one with the highest
    /// number, so that the lowest ends in front.
    pub(crate) fn fill(&mut self, glass: &mut [GlassSample]) {
        self.clear();
        glass.sort_unstable_by_key(|g| (g.y, g.x, g.rev_depth, Reverse((g.item, g.face))));
        // Layer by layer: the k-th farthest glass of each sample of a row is painted in one go.
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

    /// Paints the glass over what is behind it.
    pub(crate) fn paint(&self, canvas: &mut dyn Canvas) {
        let mut start = 0;
        for &(y, end) in &self.layers {
            canvas.row(y, &self.spans[start..end]);
            start = end;
        }
    }
}

/// Turns owners, in any order and with repeats, into items with their clusters.
pub(crate) fn report_owners(met: &mut Vec<(ItemId, u32)>, owners: &dyn Owners, seen: &mut Collector) {
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

/// Clusters that a walk found, in the order in which they came: mostly item after item.
#[derive(Debug, Default)]
pub(crate) struct FoundClusters {
    runs: Vec<Run>,
    clusters: Vec<u32>,
}

/// Clusters of one item that came one after the other.
#[derive(Clone, Copy, Debug)]
struct Run {
    item: ItemId,
    clusters: [u32; 2],
    what: What,
}

/// What stands together in a run.
#[derive(Clone, Copy, Debug, PartialEq)]
enum What {
    /// Clusters that are asked about one by one.
    Each,
    /// Those of a node of the item's mesh.
    Group(u32),
    /// All that the item has, without being written down.
    Whole,
}

impl FoundClusters {
    pub(crate) fn push(&mut self, item: ItemId, cluster: u32) {
        let end = self.clusters.len() as u32;
        match self.runs.last_mut() {
            Some(last) if last.item == item && last.what == What::Each => last.clusters[1] += 1,
            _ => self.runs.push(Run {
                item,
                clusters: [end, end + 1],
                what: What::Each,
            }),
        }
        self.clusters.push(cluster);
    }

    /// The clusters of a node of the item's mesh, to be kept or forgotten together.
    pub(crate) fn push_group(&mut self, item: ItemId, node: u32, clusters: &[u32]) {
        let start = self.clusters.len() as u32;
        self.clusters.extend_from_slice(clusters);
        self.runs.push(Run {
            item,
            clusters: [start, self.clusters.len() as u32],
            what: What::Group(node),
        });
    }

    /// Takes what another walk found of those items that `wanted` says yes of; of that nothing is left.
    pub(crate) fn take_in(&mut self, found: &mut FoundClusters, mut wanted: impl FnMut(ItemId) -> bool) {
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

    pub(crate) fn push_whole(&mut self, item: ItemId) {
        let end = self.clusters.len() as u32;
        self.runs.push(Run {
            item,
            clusters: [end; 2],
            what: What::Whole,
        });
    }

    /// Forgets the clusters that `stays` says no of; groups and items that are whole stay so.
    pub(crate) fn retain(&mut self, mut stays: impl FnMut(ItemId, u32) -> bool) {
        let mut kept = 0;
        for run in &mut self.runs {
            let [first, end] = std::mem::replace(&mut run.clusters, [kept; 2]);
            for place in first..end {
                let cluster = self.clusters[place as usize];
                if run.what != What::Each || stays(run.item, cluster) {
                    self.clusters[kept as usize] = cluster;
                    kept += 1;
                }
            }
            run.clusters[1] = kept;
        }
        self.clusters.truncate(kept as usize);
        self.runs
            .retain(|run| run.what == What::Whole || run.clusters[0] < run.clusters[1]);
    }

    /// Forgets the groups that `stays` says no of, by node.
    pub(crate) fn retain_groups(&mut self, mut stays: impl FnMut(ItemId, u32) -> bool) {
        self.runs.retain(|run| match run.what {
            What::Group(node) => stays(run.item, node),
            What::Each | What::Whole => true,
        });
    }

    /// Reports items with their clusters, in order; nothing is left.
    pub(crate) fn report(&mut self, geometry: &Geometry, seen: &mut Collector) {
        self.runs.sort_unstable_by_key(|run| (run.item, run.clusters[0]));
        for same in self.runs.chunk_by(|a, b| a.item == b.item) {
            let item = same[0].item;
            let start = seen.clusters.len();
            if geometry.mesh_of(item).clusters().len() > 1 && !same.iter().any(|run| run.what == What::Whole)
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
    /// The item, unless it is an opening.
    pub fn item(self) -> Option<ItemId> {
        match self {
            Owner::Face(item, _) => Some(item),
            Owner::Opening(_) => None,
        }
    }
}
