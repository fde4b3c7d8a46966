//! The report, as text and as JSON. The JSON keys are a stable interface.

use super::truth::ErrorCounts;
use super::{Row, SIZE};
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
    left_out: Vec<OmittedRow>,
}

#[derive(Debug, Serialize)]
pub(super) struct RowReport {
    pub(super) name: &'static str,
    /// Faces or boxes, in millions per second: in the median round, and in the fastest.
    m_per_s: f64,
    best_m_per_s: f64,
    /// Nanoseconds per face or box in the fastest round.
    best_ns: f64,
    /// Milliseconds per view, for rows of scenes: in the median round, and in the fastest.
    #[serde(skip_serializing_if = "Option::is_none")]
    ms: Option<f64>,
    #[serde(skip_serializing_if = "Option::is_none")]
    best_ms: Option<f64>,
    /// Number of samples that the buffer covers at the end of a run, of all views.
    samples: u64,
    /// Number of samples or boxes with which something visible may be culled.
    pub(super) wrong: u64,
    /// Number of samples or boxes that are conservative though they could be decided.
    loose: u64,
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
        found: &[ErrorCounts],
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
                .map(|(row, found)| RowReport::new(row, found))
                .collect(),
            left_out: left_out
                .map(|name| OmittedRow {
                    name,
                    why: "no scene is given",
                })
                .collect(),
        }
    }

    /// Returns the text output.
    pub(super) fn for_people(&self) -> String {
        let header = [
            "row",
            "M/s",
            "best M/s",
            "best ns",
            "ms per view",
            "best ms",
            "samples",
            "wrong",
            "loose",
        ];
        let row = |row: &RowReport| {
            vec![
                row.name.to_owned(),
                short(row.m_per_s),
                short(row.best_m_per_s),
                short(row.best_ns),
                row.ms.map_or_else(String::new, short),
                row.best_ms.map_or_else(String::new, short),
                row.samples.to_string(),
                row.wrong.to_string(),
                row.loose.to_string(),
            ]
        };
        let [width, height] = self.size;
        let mut text = format!(
            "masked depth buffer at {width}x{height}, 1 thread, {}, median and fastest of {} rounds\n\n",
            self.simd, self.rounds
        );
        text += &table(&header, &self.rows.iter().map(row).collect::<Vec<_>>());
        for OmittedRow { name, why } in &self.left_out {
            text += &format!("  {name} is left out: {why}\n");
        }
        text
    }
}

impl RowReport {
    fn new(row: &Row, found: &ErrorCounts) -> RowReport {
        let [seconds, best] = [row.median_seconds(), row.best_seconds()];
        let count = row.work.count() as f64;
        let ms = |seconds: f64| row.views.map(|views| rounded(seconds / views as f64 * 1e3));
        RowReport {
            name: row.name,
            m_per_s: rounded(count / seconds / 1e6),
            best_m_per_s: rounded(count / best / 1e6),
            best_ns: rounded(best / count * 1e9),
            ms: ms(seconds),
            best_ms: ms(best),
            samples: found.covered,
            wrong: found.wrong,
            loose: found.loose,
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
