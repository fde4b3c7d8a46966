//! Where another vis of the same map says otherwise, and who is right.

use super::report::Line;
use crate::read::read_file;
use crate::text::{count, plural};
use anyhow::{Context, Result, bail};
use enfilade::{BakedCells, CellId};
use enfilade_bake::{PairsWork, Stage, VisiblePairs};
use enfilade_import::{PlacedPortals, PortalFile, ReadOptions, place_portals};
use serde::Serialize;
use std::path::Path;
use std::sync::Arc;

/// Pairs that are printed; the report has all.
const PRINTED: usize = 10;

/// The pairs of another vis.
pub(super) struct Other {
    file: String,
    cells: Arc<BakedCells>,
    /// By cluster one of its cells: in Quake those are leafs, which share the rows of their clusters.
    cell_of: Vec<CellId>,
    /// By cluster, whether it is not where the portals are.
    is_elsewhere: Vec<bool>,
}

/// The pairs that differ.
#[derive(Debug, Serialize)]
pub(super) struct Differs {
    other: String,
    other_pairs: u64,
    /// Clusters of which nothing can be said, for the other map has them elsewhere.
    clusters_elsewhere: usize,
    /// Pairs that the other does not have.
    missing_there: Vec<Missing>,
    /// Pairs that the other has beyond ours.
    more_there: Vec<More>,
}

#[derive(Debug, Serialize)]
struct Missing {
    from: u32,
    to: u32,
    /// A line of sight, where one is found: then the other hides what can be seen.
    witness: Option<Line>,
}

#[derive(Debug, Serialize)]
struct More {
    from: u32,
    to: u32,
    /// What proves that there is no line of sight.
    blocked_by: &'static str,
}

impl Other {
    /// Reads what another map says is visible; `placed` is how the portals stand in the map itself.
    pub(super) fn read(
        path: &Path,
        portals: &PortalFile,
        placed: Option<&PlacedPortals>,
        options: &ReadOptions,
    ) -> Result<Other> {
        let import = enfilade_import::read(
            path,
            &ReadOptions {
                textures: false,
                ..options.clone()
            },
        )?;
        let Some(cells) = import.rooms.first().and_then(|room| room.geometry.cells()) else {
            bail!(
                "{}: it has no PVS; name a map that vis has run on",
                path.display()
            );
        };
        let name = || path.display().to_string();
        let bytes = read_file(path, options.limit_bytes, "raise --memory")?;
        let there = place_portals(&bytes, portals).with_context(name)?;
        // Compiled again a map may have a few clusters elsewhere: nothing can be said of those.
        let mut is_elsewhere = vec![false; portals.cells.count() as usize];
        for (number, portal) in portals.cells.portals().iter().enumerate() {
            let here = placed.is_none_or(|placed| placed.in_place[number]);
            if here && !there.in_place[number] {
                portal
                    .cells
                    .iter()
                    .for_each(|&cell| is_elsewhere[cell as usize] = true);
            }
        }
        Ok(Other {
            file: name(),
            cell_of: cells_of_clusters(portals),
            cells: cells.clone(),
            is_elsewhere,
        })
    }

    fn sees(&self, from: u32, to: u32) -> bool {
        self.cells
            .sees(self.cell_of[from as usize], self.cell_of[to as usize])
    }

    /// All pairs that differ, with what speaks for it.
    pub(super) fn compare(self, portals: &PortalFile, work: &PairsWork, pairs: &VisiblePairs) -> Differs {
        let mut differs = Differs {
            other_pairs: 0,
            clusters_elsewhere: self.is_elsewhere.iter().filter(|&&elsewhere| elsewhere).count(),
            missing_there: Vec::new(),
            more_there: Vec::new(),
            other: String::new(),
        };
        let mut bounds = None;
        let clusters = pairs.cell_count();
        for (from, to) in (0..clusters).flat_map(|from| (0..clusters).map(move |to| (from, to))) {
            if from == to {
                continue;
            }
            let there = self.sees(from, to);
            differs.other_pairs += u64::from(there);
            if self.is_elsewhere[from as usize] || self.is_elsewhere[to as usize] {
                continue;
            }
            match (pairs.sees(from, to), there) {
                (true, false) => differs.missing_there.push(Missing {
                    from,
                    to,
                    witness: work.line_between(from, to).map(Line::from),
                }),
                (false, true) => {
                    let [first, fast] = bounds.get_or_insert_with(|| bounds_of(portals));
                    let blocked_by = if !first.sees(from, to) {
                        "no chain of portals that lie before one another leads there"
                    } else if !fast.sees(from, to) {
                        "planes between two portals in a row part all chains"
                    } else {
                        "each chain of portals leaves nothing of its first or its last portal"
                    };
                    differs.more_there.push(More { from, to, blocked_by });
                }
                _ => {}
            }
        }
        differs.other = self.file;
        differs
    }
}

/// Which cells stand for clusters.
fn cells_of_clusters(portals: &PortalFile) -> Vec<CellId> {
    let mut cell_of: Vec<CellId> = (0..portals.cells.count()).map(CellId).collect();
    let leafs = portals.cluster_of_leaf.iter().flatten().enumerate();
    leafs.for_each(|(leaf, &cluster)| cell_of[cluster as usize] = CellId(leaf as u32));
    cell_of
}

/// What may be seen by the first bound, and by the fast one.
fn bounds_of(portals: &PortalFile) -> [VisiblePairs; 2] {
    let mut work = PairsWork::begin(&portals.cells, u64::MAX).expect("no limit is set");
    let mut until = |stage: Stage| {
        while work.stage() < stage {
            work.step();
        }
        work.pairs()
    };
    [Stage::Passages, Stage::Sampling].map(&mut until)
}

impl Differs {
    /// As lines of text.
    pub(super) fn lines(&self) -> Vec<String> {
        let mut lines = vec![format!("{}: {} pairs", self.other, count(self.other_pairs))];
        if self.clusters_elsewhere > 0 {
            lines.push(format!(
                "  {} of it elsewhere: nothing is said of pairs with those",
                plural(self.clusters_elsewhere, "cluster")
            ));
        }
        let shown = self
            .missing_there
            .iter()
            .filter(|missing| missing.witness.is_some())
            .count();
        lines.push(format!(
            "  {} that it misses, {} of them shown to be seen by a line",
            plural(self.missing_there.len(), "pair"),
            count(shown as u64)
        ));
        // Those with a line first.
        let mut missing: Vec<&Missing> = self.missing_there.iter().collect();
        missing.sort_by_key(|missing| missing.witness.is_none());
        for Missing { from, to, witness } in missing.iter().take(PRINTED) {
            lines.push(match witness {
                Some(line) => format!("    {line}"),
                None => format!(
                    "    cluster {from} and {to}: no line is found, and nothing proves that there is none"
                ),
            });
        }
        lines.push(format!("  {} too many", plural(self.more_there.len(), "pair")));
        for More { from, to, blocked_by } in self.more_there.iter().take(PRINTED) {
            lines.push(format!("    cluster {from} and {to}: {blocked_by}"));
        }
        if self.missing_there.len().max(self.more_there.len()) > PRINTED {
            lines.push("  --json has all of them".to_owned());
        }
        lines
    }
}
