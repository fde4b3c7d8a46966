//! `vis --compare`: lists the differences from another PVS of the same map, with evidence.

use super::report::SightLine;
use crate::read::read_file;
use crate::text::{count, plural};
use anyhow::{Context, Result, bail};
use enfilade::{BakedCells, CellId};
use enfilade_bake::{PairsWork, Stage, VisiblePairs};
use enfilade_import::{PlacedPortals, PortalFile, ReadOptions, place_portals};
use serde::Serialize;
use std::path::Path;
use std::sync::Arc;

/// Maximum number of pairs printed per list; the JSON report lists all.
const PRINTED: usize = 10;

/// The PVS of another compile of the map.
pub(super) struct OtherPvs {
    file: String,
    cells: Arc<BakedCells>,
    /// One cell of each cluster. In Quake cells are leafs, and all leafs of a cluster have the same row.
    cell_of: Vec<CellId>,
    /// Whether each cluster has portals that are elsewhere in the other map.
    is_elsewhere: Vec<bool>,
}

/// The differences between both PVS.
#[derive(Debug, Serialize)]
pub(super) struct PvsDifferences {
    other: String,
    other_pairs: u64,
    /// Number of clusters that are elsewhere in the other map; their pairs are not compared.
    clusters_elsewhere: usize,
    /// Pairs that only this PVS has.
    missing_there: Vec<MissingPair>,
    /// Pairs that only the other PVS has.
    more_there: Vec<ExtraPair>,
}

#[derive(Debug, Serialize)]
struct MissingPair {
    from: u32,
    to: u32,
    /// A line of sight, if one is found. It proves that the other PVS hides something visible.
    witness: Option<SightLine>,
}

#[derive(Debug, Serialize)]
struct ExtraPair {
    from: u32,
    to: u32,
    /// The bound that rules out a line of sight.
    blocked_by: &'static str,
}

impl OtherPvs {
    /// Reads the PVS of another map. `placed` locates the portals in this map.
    pub(super) fn read(
        path: &Path,
        portals: &PortalFile,
        placed: Option<&PlacedPortals>,
        options: &ReadOptions,
    ) -> Result<OtherPvs> {
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
        let placed_there = place_portals(&bytes, portals).with_context(name)?;
        // Another compile may have a few clusters elsewhere; those cannot be compared.
        let mut is_elsewhere = vec![false; portals.cells.count() as usize];
        for (number, portal) in portals.cells.portals().iter().enumerate() {
            let here = placed.is_none_or(|placed| placed.in_place[number]);
            if here && !placed_there.in_place[number] {
                portal
                    .cells
                    .iter()
                    .for_each(|&cell| is_elsewhere[cell as usize] = true);
            }
        }
        Ok(OtherPvs {
            file: name(),
            cell_of: cells_of_clusters(portals),
            cells: cells.clone(),
            is_elsewhere,
        })
    }

    fn may_see(&self, from: u32, to: u32) -> bool {
        self.cells
            .may_see(self.cell_of[from as usize], self.cell_of[to as usize])
    }

    /// Returns all differing pairs, with the evidence for each.
    pub(super) fn compare(
        self,
        portals: &PortalFile,
        work: &PairsWork,
        pairs: &VisiblePairs,
    ) -> PvsDifferences {
        let mut differs = PvsDifferences {
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
            let there = self.may_see(from, to);
            differs.other_pairs += u64::from(there);
            if self.is_elsewhere[from as usize] || self.is_elsewhere[to as usize] {
                continue;
            }
            match (pairs.may_see(from, to), there) {
                (true, false) => differs.missing_there.push(MissingPair {
                    from,
                    to,
                    witness: work.line_between(from, to).map(SightLine::from),
                }),
                (false, true) => {
                    let [first, fast] = bounds.get_or_insert_with(|| bounds_of(portals));
                    let blocked_by = if !first.may_see(from, to) {
                        "no chain of portals, each in front of the one before, leads there"
                    } else if !fast.may_see(from, to) {
                        "planes separating two consecutive portals rule out every chain"
                    } else {
                        "in every chain of portals nothing of the first or last portal remains after clipping"
                    };
                    differs.more_there.push(ExtraPair { from, to, blocked_by });
                }
                _ => {}
            }
        }
        differs.other = self.file;
        differs
    }
}

/// Returns one cell for each cluster.
fn cells_of_clusters(portals: &PortalFile) -> Vec<CellId> {
    let mut cell_of: Vec<CellId> = (0..portals.cells.count()).map(CellId).collect();
    let leafs = portals.cluster_of_leaf.iter().flatten().enumerate();
    leafs.for_each(|(leaf, &cluster)| cell_of[cluster as usize] = CellId(leaf as u32));
    cell_of
}

/// Returns the first bound and the fast bound of the visible pairs.
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

impl PvsDifferences {
    /// Returns the text output, in lines.
    pub(super) fn lines(&self) -> Vec<String> {
        let mut lines = vec![format!("{}: {} pairs", self.other, count(self.other_pairs))];
        if self.clusters_elsewhere > 0 {
            lines.push(format!(
                "  {} of it elsewhere; their pairs are not compared",
                plural(self.clusters_elsewhere, "cluster")
            ));
        }
        let shown = self
            .missing_there
            .iter()
            .filter(|missing| missing.witness.is_some())
            .count();
        lines.push(format!(
            "  {} that it misses, {} of them proven by a line of sight",
            plural(self.missing_there.len(), "pair"),
            count(shown as u64)
        ));
        // Proven pairs first.
        let mut missing: Vec<&MissingPair> = self.missing_there.iter().collect();
        missing.sort_by_key(|missing| missing.witness.is_none());
        for MissingPair { from, to, witness } in missing.iter().take(PRINTED) {
            lines.push(match witness {
                Some(line) => format!("    {line}"),
                None => format!("    clusters {from} and {to}: undecided, no line of sight found"),
            });
        }
        lines.push(format!(
            "  {} that only it has",
            plural(self.more_there.len(), "pair")
        ));
        for ExtraPair { from, to, blocked_by } in self.more_there.iter().take(PRINTED) {
            lines.push(format!("    clusters {from} and {to}: {blocked_by}"));
        }
        if self.missing_there.len().max(self.more_there.len()) > PRINTED {
            lines.push("  --json lists all of them".to_owned());
        }
        lines
    }
}
