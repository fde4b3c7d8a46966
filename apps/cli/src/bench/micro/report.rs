//! What `bench --micro` reports: the table for people, and the JSON, whose names programs rely on.

use super::ceilings::{Ceiling, Ceilings};
use super::{Found, Row, SIZE};
use crate::report::rounded;
use crate::text::table;
use serde::Serialize;

/// All rows, in the order of the table.
#[derive(Debug, Serialize)]
pub(super) struct MicroReport {
    /// The screen of all rows but those of scenes.
    size: [u32; 2],
    simd: &'static str,
    rounds: u32,
    pub(super) rows: Vec<RowReport>,
    ceilings: CeilingReport,
    left_out: Vec<LeftOut>,
}

#[derive(Debug, Serialize)]
pub(super) struct RowReport {
    pub(super) name: &'static str,
    /// Faces or boxes, in millions a second.
    m_per_s: f64,
    /// What one takes.
    ns: f64,
    /// A view, where the row is of views.
    #[serde(skip_serializing_if = "Option::is_none")]
    ms: Option<f64>,
    /// The share of the ceiling that the bytes come to which must be touched.
    of_ceiling: f64,
    ceiling: &'static str,
    /// The best other culler, in the unit of this row, and how many times as fast this one is.
    peer: f64,
    of_peer: f64,
    /// Samples or answers by which what is seen may be called hidden.
    pub(super) wrong: u64,
    /// Those that are right and could be better.
    loose: u64,
}

#[derive(Debug, Serialize)]
struct CeilingReport {
    l1_gb_s: f64,
    l2_gb_s: f64,
}

/// A row that could not be measured.
#[derive(Debug, Serialize)]
struct LeftOut {
    name: &'static str,
    why: &'static str,
}

impl MicroReport {
    pub(super) fn new(
        rows: &[Row],
        found: &[Found],
        ceilings: &Ceilings,
        rounds: u32,
        wanted: impl Fn(&str) -> bool,
    ) -> MicroReport {
        let left_out = super::walk::NAMES
            .into_iter()
            .filter(|name| wanted(name) && rows.iter().all(|row| row.name != *name));
        MicroReport {
            size: SIZE,
            simd: enfilade::simd_level(),
            rounds,
            rows: rows
                .iter()
                .zip(found)
                .map(|(row, found)| RowReport::new(row, found, ceilings))
                .collect(),
            ceilings: CeilingReport {
                l1_gb_s: rounded(ceilings.gb_s(Ceiling::L1)),
                l2_gb_s: rounded(ceilings.gb_s(Ceiling::L2)),
            },
            left_out: left_out
                .map(|name| LeftOut {
                    name,
                    why: "no scene is given",
                })
                .collect(),
        }
    }

    /// The table, and what its columns are relative to.
    pub(super) fn for_people(&self) -> String {
        let header = [
            "row",
            "M/s",
            "ns",
            "ms a view",
            "peer",
            "of peer",
            "of ceiling",
            "wrong",
            "loose",
        ];
        let row = |row: &RowReport| {
            vec![
                row.name.to_owned(),
                short(row.m_per_s),
                short(row.ns),
                row.ms.map_or_else(String::new, short),
                short(row.peer),
                format!("{:.2}×", row.of_peer),
                format!("{:.2} % {}", 100.0 * row.of_ceiling, row.ceiling),
                row.wrong.to_string(),
                row.loose.to_string(),
            ]
        };
        let [width, height] = self.size;
        let mut text = format!(
            "the masked cover at {width}x{height}, 1 thread, {}, median of {} rounds\n\n",
            self.simd, self.rounds
        );
        text += &table(&header, &self.rows.iter().map(row).collect::<Vec<_>>());
        let CeilingReport { l1_gb_s, l2_gb_s } = self.ceilings;
        text += &format!("ceilings: L1 {l1_gb_s:.0} GB/s, L2 {l2_gb_s:.0} GB/s read, changed and written\n");
        for LeftOut { name, why } in &self.left_out {
            text += &format!("  {name} is left out: {why}\n");
        }
        text
    }
}

impl RowReport {
    fn new(row: &Row, found: &Found, ceilings: &Ceilings) -> RowReport {
        let seconds = row.median_seconds();
        let count = row.work.count() as f64;
        let m_per_s = count / seconds / 1e6;
        let of_peer = m_per_s / row.best;
        let ms = row.views.map(|views| seconds / views as f64 * 1e3);
        RowReport {
            name: row.name,
            m_per_s: rounded(m_per_s),
            ns: rounded(seconds / count * 1e9),
            ms: ms.map(rounded),
            of_ceiling: rounded(found.least_bytes as f64 / seconds / 1e9 / ceilings.gb_s(found.ceiling)),
            ceiling: match found.ceiling {
                Ceiling::L1 => "L1",
                Ceiling::L2 => "L2",
            },
            peer: rounded(ms.map_or(row.best, |ms| ms * of_peer)),
            of_peer: rounded(of_peer),
            wrong: found.held.wrong,
            loose: found.held.loose,
        }
    }
}

/// Three digits, or more where there are more before the point.
fn short(value: f64) -> String {
    match value {
        v if v < 1.0 => format!("{v:.3}"),
        v if v < 10.0 => format!("{v:.2}"),
        v if v < 100.0 => format!("{v:.1}"),
        v => format!("{v:.0}"),
    }
}
