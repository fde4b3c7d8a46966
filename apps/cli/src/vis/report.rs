//! The report of `vis`, as JSON and as text.

use super::differ::PvsDifferences;
use crate::text::{bytes, count, plural, short};
use enfilade_bake::{Stage, VisiblePairs, Witness};
use enfilade_import::{AmbientLeafs, PortalFile};
use serde::Serialize;
use std::fmt::{self, Display, Formatter, Write};
use std::path::Path;
use std::time::Duration;

/// The PVS of a map in numbers, and the cost of computing it.
#[derive(Debug, Serialize)]
pub(super) struct VisReport {
    map: String,
    prt: String,
    format: &'static str,
    /// Path of the written map.
    written: Option<String>,
    /// Path where this run kept the map that it replaced.
    backup: Option<String>,
    leafs: u64,
    clusters: u32,
    portals: usize,
    /// `full` or `fast`; for a run that was stopped, the bound it has reached.
    bound: &'static str,
    complete: bool,
    /// Whether it resumed an unfinished run.
    resumed: bool,
    /// Number of parts of shards that it merged.
    #[serde(skip_serializing_if = "Option::is_none")]
    parts: Option<usize>,
    /// Whether it began with the work of `--prepare` or of a shard.
    #[serde(skip_serializing_if = "std::ops::Not::not")]
    prepared: bool,
    #[serde(skip)]
    has_nothing_to_resume: bool,
    /// Number of ordered pairs of distinct clusters that may see each other.
    pairs: usize,
    /// Their share of all ordered pairs.
    share: f64,
    /// Number of pairs proven visible by a line of sight.
    pairs_proven: usize,
    symmetric: bool,
    average_leafs: f64,
    /// Size of the visibility lump, in bytes.
    bytes: Option<u64>,
    /// Number of leafs with each ambient sound.
    #[serde(skip_serializing_if = "Option::is_none")]
    ambient: Option<Ambient>,
    seconds: StageSeconds,
    threads: usize,
    /// Peak memory of the program, in bytes; `None` if the system does not report it.
    peak_memory: Option<u64>,
    #[serde(skip_serializing_if = "Option::is_none")]
    check: Option<LineCheck>,
    #[serde(skip_serializing_if = "Option::is_none")]
    compare: Option<PvsDifferences>,
}

/// Leafs with ambient sounds.
#[derive(Debug, Serialize)]
struct Ambient {
    water: usize,
    sky: usize,
    lava: usize,
    /// Source of the classification: `texture names` or `contents`.
    by: &'static str,
}

impl From<AmbientLeafs> for Ambient {
    fn from(leafs: AmbientLeafs) -> Ambient {
        Ambient {
            water: leafs.water,
            sky: leafs.sky,
            lava: leafs.lava,
            by: if leafs.by_names {
                "texture names"
            } else {
                "contents"
            },
        }
    }
}

impl Ambient {
    fn line(&self) -> String {
        let parts = [("water", self.water), ("sky", self.sky), ("lava", self.lava)]
            .into_iter()
            .filter(|&(_, leafs)| leafs > 0)
            .map(|(sound, leafs)| format!("{sound} in {}", plural(leafs, "leaf")));
        let parts: Vec<String> = parts.collect();
        let sounds = if parts.is_empty() {
            "none".to_owned()
        } else {
            parts.join(", ")
        };
        let by = if self.by == "contents" {
            " (from the contents of leafs, because the map has no texture names)"
        } else {
            ""
        };
        format!("ambient sounds: {sounds}{by}")
    }
}

/// Wall-clock seconds of each stage, and in total.
#[derive(Debug, Default, Serialize)]
pub(super) struct StageSeconds {
    pub(super) read: f64,
    first_bound: f64,
    passages: f64,
    fixpoint: f64,
    sampling: f64,
    flow: f64,
    backflow: f64,
    pub(super) check: f64,
    pub(super) write: f64,
    pub(super) total: f64,
}

impl StageSeconds {
    pub(super) fn add(&mut self, stage: Stage, time: Duration) {
        let of = match stage {
            Stage::FirstBound => &mut self.first_bound,
            Stage::Passages => &mut self.passages,
            Stage::Fixpoint => &mut self.fixpoint,
            Stage::Sampling => &mut self.sampling,
            Stage::Flow => &mut self.flow,
            Stage::Backflow | Stage::Done => &mut self.backflow,
        };
        *of += time.as_secs_f64();
    }
}

/// Result of `--check`.
#[derive(Debug, Serialize)]
pub(super) struct LineCheck {
    lines: u64,
    pub(super) missing: Option<SightLine>,
}

/// A line of sight.
#[derive(Debug, Serialize)]
pub(super) struct SightLine {
    pub(super) origin: [f64; 3],
    pub(super) direction: [f64; 3],
    pub(super) clusters: Vec<u32>,
}

impl From<Witness> for SightLine {
    fn from(witness: Witness) -> SightLine {
        SightLine {
            origin: witness.origin,
            direction: witness.direction,
            clusters: witness.cells,
        }
    }
}

impl Display for SightLine {
    fn fmt(&self, out: &mut Formatter<'_>) -> fmt::Result {
        let ([x, y, z], [a, b, c]) = (self.origin, self.direction);
        let [from, to] = [self.clusters.first(), self.clusters.last()].map(|end| end.copied().unwrap_or(0));
        write!(
            out,
            "cluster {from} sees {to}: the line from ({x} {y} {z}) along ({a} {b} {c}) passes through clusters"
        )?;
        self.clusters
            .iter()
            .try_for_each(|cluster| write!(out, " {cluster}"))
    }
}

impl LineCheck {
    pub(super) fn new(lines: u64, missing: Option<Witness>) -> LineCheck {
        LineCheck {
            lines,
            missing: missing.map(SightLine::from),
        }
    }
}

/// The input of the report.
pub(super) struct VisResult<'a> {
    pub(super) map: &'a Path,
    pub(super) target: Option<&'a Path>,
    pub(super) backup: Option<&'a Path>,
    pub(super) prt: &'a Path,
    pub(super) portals: &'a PortalFile,
    pub(super) leafs: &'a [u32],
    pub(super) pairs: &'a VisiblePairs,
    pub(super) lump_bytes: Option<u64>,
    pub(super) is_fast: bool,
    pub(super) is_complete: bool,
    pub(super) asked_to_resume: bool,
    pub(super) is_resumed: bool,
    /// Number of parts; 0 without `--merge`.
    pub(super) merged: usize,
    pub(super) is_prepared: bool,
    pub(super) stopped_in: Stage,
    pub(super) threads: usize,
    pub(super) seconds: StageSeconds,
    pub(super) checked: Option<LineCheck>,
    pub(super) differs: Option<PvsDifferences>,
    pub(super) ambient: Option<AmbientLeafs>,
}

impl VisReport {
    pub(super) fn new(found: VisResult) -> VisReport {
        let pairs = found.pairs;
        let clusters = pairs.cell_count();
        let all = f64::from(clusters) * f64::from(clusters.max(1) - 1);
        let leafs: u64 = found.leafs.iter().map(|&leafs| u64::from(leafs)).sum();
        // Number of leafs visible from each leaf of a cluster.
        let seen = |from: u32| {
            pairs
                .seen_from(from)
                .map(|to| u64::from(found.leafs[to as usize]))
                .sum::<u64>()
        };
        let sum: u64 = (0..clusters)
            .map(|from| u64::from(found.leafs[from as usize]) * seen(from))
            .sum();
        let symmetric = (0..clusters).all(|from| pairs.seen_from(from).all(|to| pairs.may_see(to, from)));
        VisReport {
            map: found.map.display().to_string(),
            prt: found.prt.display().to_string(),
            format: found.portals.kind.name(),
            written: found.target.map(|target| target.display().to_string()),
            backup: found.backup.map(|backup| backup.display().to_string()),
            leafs,
            clusters,
            portals: found.portals.cells.portals().len(),
            bound: match (found.is_complete, found.is_fast) {
                (true, true) => "fast",
                (true, false) => "full",
                (false, _) if found.stopped_in == Stage::FirstBound => "everything",
                (false, _) if found.stopped_in <= Stage::Fixpoint => "first",
                (false, _) => "between fast and full",
            },
            complete: found.is_complete,
            resumed: found.is_resumed,
            parts: (found.merged > 0).then_some(found.merged),
            prepared: found.is_prepared,
            has_nothing_to_resume: found.asked_to_resume && !found.is_resumed,
            pairs: pairs.count(),
            share: pairs.count() as f64 / all.max(1.0),
            pairs_proven: pairs.proven(),
            symmetric,
            average_leafs: sum as f64 / leafs.max(1) as f64,
            bytes: found.lump_bytes,
            ambient: found.ambient.map(Ambient::from),
            seconds: found.seconds,
            threads: found.threads,
            peak_memory: peak_memory(),
            check: found.checked,
            compare: found.differs,
        }
    }

    pub(super) fn text(&self) -> String {
        let mut text = format!(
            "{}: {} in {}, {}\n",
            self.map,
            plural(self.leafs as usize, "leaf"),
            plural(self.clusters as usize, "cluster"),
            plural(self.portals, "portal")
        );
        let proven = if self.bound == "full" && self.pairs > 0 {
            format!(
                ", {:.1} % of them proven by a line of sight",
                100.0 * self.pairs_proven as f64 / self.pairs as f64
            )
        } else {
            String::new()
        };
        let mut line = |shown: String| {
            // Writing to a String cannot fail.
            let _ = writeln!(text, "  {shown}");
        };
        line(format!(
            "{} visible pairs, {:.1} % of all{proven}",
            count(self.pairs as u64),
            100.0 * self.share
        ));
        line(format!(
            "{} leafs visible from a leaf on average",
            short(self.average_leafs)
        ));
        if self.resumed {
            line("resumed from the saved work of an unfinished run".to_owned());
        }
        if let Some(parts) = self.parts {
            line(format!("merged from {}", plural(parts, "part")));
        }
        if self.has_nothing_to_resume {
            line("no unfinished run to resume; started from the beginning".to_owned());
        }
        if !self.complete {
            line(format!(
                "stopped when time was up: this is an upper bound ({})",
                self.bound
            ));
        } else if self.bound == "fast" {
            line("this is the fast upper bound; a run without --fast leaves fewer pairs".to_owned());
        }
        match &self.check {
            Some(LineCheck {
                missing: Some(witness),
                ..
            }) => {
                line(format!("missing pair, nothing is written: {}", witness));
            }
            Some(LineCheck { lines, .. }) => {
                line(format!("{} random lines: no pair is missing", count(*lines)))
            }
            None => {}
        }
        if let Some(differs) = &self.compare {
            differs.lines().into_iter().for_each(&mut line);
        }
        if let (Some(written), Some(size)) = (&self.written, self.bytes) {
            let backup = self.backup.as_ref();
            let backup = backup.map_or(String::new(), |backup| format!("; the old map is in {backup}"));
            line(format!("written to {written}: a PVS of {}{backup}", bytes(size)));
        }
        if let Some(ambient) = &self.ambient {
            line(ambient.line());
        }
        let memory = self
            .peak_memory
            .map_or(String::new(), |peak| format!(", {}", bytes(peak)));
        line(format!(
            "{} s on {}{memory}",
            short(self.seconds.total),
            plural(self.threads, "thread")
        ));
        text
    }
}

/// Returns the peak memory of the program, in bytes; `None` on systems without `/proc`.
pub(super) fn peak_memory() -> Option<u64> {
    let status = std::fs::read_to_string("/proc/self/status").ok()?;
    let line = status.lines().find_map(|line| line.strip_prefix("VmHWM:"))?;
    let kibibytes: u64 = line.trim().strip_suffix("kB")?.trim().parse().ok()?;
    Some(kibibytes * 1024)
}
