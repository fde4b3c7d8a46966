//! The report, as text and as JSON. The JSON keys are a stable interface.

use super::ceilings::{Ceiling, Ceilings};
use super::{Row, SIZE, Verification};
use serde::Serialize;
use std::fmt::Write;

/// All rows, in the order of the table.
#[derive(Debug, Serialize)]
pub(super) struct MicroReport {
    /// Screen size of all rows except those of scenes.
    size: [u32; 2],
    simd: &'static str,
    rounds: u32,
    pub(super) rows: Vec<RowReport>,
    ceilings: CeilingReport,
    left_out: Vec<OmittedRow>,
}

#[derive(Debug, Serialize)]
pub(super) struct RowReport {
    pub(super) name: &'static str,
    /// Faces or boxes, in millions per second.
    m_per_s: f64,
    /// Nanoseconds per face or box.
    ns: f64,
    /// Milliseconds per view, for rows of scenes.
    #[serde(skip_serializing_if = "Option::is_none")]
    ms: Option<f64>,
    /// Rate of the bytes that must be touched, as a share of the ceiling.
    of_ceiling: f64,
    ceiling: &'static str,
    /// Figure of the best other culler, in the unit of this row, and the speed relative to it.
    peer: f64,
    of_peer: f64,
    /// Number of samples or boxes with which something visible may be culled.
    pub(super) wrong: u64,
    /// Number of samples or boxes that are conservative though they could be decided.
    loose: u64,
}

#[derive(Debug, Serialize)]
struct CeilingReport {
    l1_gb_s: f64,
    l2_gb_s: f64,
}

/// A row that was not measured.
#[derive(Debug, Serialize)]
struct OmittedRow {
    name: &'static str,
    why: &'static str,
}

impl MicroReport {
    pub(super) fn new(
        rows: &[Row],
        found: &[Verification],
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
                .map(|name| OmittedRow {
                    name,
                    why: "no scene is given",
                })
                .collect(),
        }
    }

    /// Returns the text output: the table and the ceilings.
    pub(super) fn for_people(&self) -> String {
        let header = [
            "row",
            "M/s",
            "ns",
            "ms per view",
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
            "masked depth buffer at {width}x{height}, 1 thread, {}, median of {} rounds\n\n",
            self.simd, self.rounds
        );
        text += &table(&header, &self.rows.iter().map(row).collect::<Vec<_>>());
        let CeilingReport { l1_gb_s, l2_gb_s } = self.ceilings;
        text += &format!("ceilings: L1 {l1_gb_s:.0} GB/s, L2 {l2_gb_s:.0} GB/s read, changed and written\n");
        for OmittedRow { name, why } in &self.left_out {
            text += &format!("  {name} is left out: {why}\n");
        }
        text
    }
}

impl RowReport {
    fn new(row: &Row, found: &Verification, ceilings: &Ceilings) -> RowReport {
        let seconds = row.median_seconds();
        let count = row.work.count() as f64;
        let m_per_s = count / seconds / 1e6;
        let of_peer = m_per_s / row.peer;
        let ms = row.views.map(|views| seconds / views as f64 * 1e3);
        RowReport {
            name: row.name,
            m_per_s: rounded(m_per_s),
            ns: rounded(seconds / count * 1e9),
            ms: ms.map(rounded),
            of_ceiling: rounded(found.min_bytes as f64 / seconds / 1e9 / ceilings.gb_s(found.ceiling)),
            ceiling: match found.ceiling {
                Ceiling::L1 => "L1",
                Ceiling::L2 => "L2",
            },
            peer: rounded(ms.map_or(row.peer, |ms| ms * of_peer)),
            of_peer: rounded(of_peer),
            wrong: found.errors.wrong,
            loose: found.errors.loose,
        }
    }
}

/// Formats three significant digits, or all digits before the decimal point if there are more.
fn short(value: f64) -> String {
    match value {
        v if v < 1.0 => format!("{v:.3}"),
        v if v < 10.0 => format!("{v:.2}"),
        v if v < 100.0 => format!("{v:.1}"),
        v => format!("{v:.0}"),
    }
}

/// Rounds to four decimals.
fn rounded(value: f64) -> f64 {
    (value * 1e4).round() / 1e4
}

/// Formats a table with a header; the first column is left-aligned, the others right-aligned.
fn table(header: &[&str], rows: &[Vec<String>]) -> String {
    let width = |column: usize| {
        let cells = rows.iter().map(|row| row[column].chars().count());
        cells.chain([header[column].chars().count()]).max().unwrap_or(0)
    };
    let widths: Vec<usize> = (0..header.len()).map(width).collect();
    let header: Vec<String> = header.iter().map(|&cell| cell.to_owned()).collect();
    let mut text = String::new();
    for row in std::iter::once(&header).chain(rows) {
        let mut line = String::new();
        for (column, (cell, &width)) in row.iter().zip(&widths).enumerate() {
            // Writing to a String cannot fail.
            let _ = if column == 0 {
                write!(line, "  {cell:<width$}")
            } else {
                write!(line, "  {cell:>width$}")
            };
        }
        text.push_str(line.trim_end());
        text.push('\n');
    }
    text
}
