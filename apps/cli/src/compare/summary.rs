//! The summary table: cost and verdict, one row per method.

use super::Comparison;
use super::charts::color;
use crate::html::escaped;
use crate::report::Report;
use crate::text::{bytes, count, ms, plural, short, table};
use enfilade::Contract;

/// A column of the table.
struct Column {
    /// Header on the page.
    name: &'static str,
    /// Explanation, shown as a tooltip.
    hint: &'static str,
    /// Short header on standard output; empty to omit the column there.
    short: &'static str,
    cell: fn(&Comparison, &Report) -> String,
}

impl Column {
    /// Returns the HTML class. Columns omitted on standard output are also hidden on narrow pages.
    fn class(&self) -> &'static str {
        if self.short.is_empty() {
            " class=\"minor\""
        } else {
            ""
        }
    }
}

const COLUMNS: [Column; 12] = [
    Column {
        name: "build ms",
        hint: "time to build the data of the method, once",
        short: "build ms",
        cell: |_, report| ms(report.build_ms),
    },
    Column {
        name: "faces built",
        hint: "faces after the splits of the method",
        short: "",
        cell: |_, report| count(report.faces_built),
    },
    Column {
        name: "growth",
        hint: "faces built per face of the scene",
        short: "growth",
        cell: |comparison, report| {
            growth(comparison, report).map_or_else(none, |growth| format!("{}×", short(growth)))
        },
    },
    Column {
        name: "memory",
        hint: "the scene, the data of the method, and the buffers for this screen",
        short: "memory",
        cell: |_, report| bytes(report.bytes),
    },
    Column {
        name: "order ms",
        hint: "time to walk the traversal order alone, nothing culled",
        short: "order ms",
        cell: |_, report| report.median_ms(|view| view.order_ms).map_or_else(none, ms),
    },
    Column {
        name: "look ms",
        hint: "time to compute the visible set, without a picture",
        short: "look ms",
        cell: |_, report| ms(report.summary.ms_median),
    },
    Column {
        name: "draw ms",
        hint: "time to render the picture, shading included",
        short: "draw ms",
        cell: |_, report| report.median_ms(|view| view.draw_ms).map_or_else(none, ms),
    },
    Column {
        name: "items",
        hint: "items in the visible set, mean over the views",
        short: "items",
        cell: |_, report| {
            let mean = report.summary.items_visible_mean;
            if report.summary.views == 1 {
                count(mean as u64)
            } else {
                short(mean)
            }
        },
    },
    Column {
        name: "in set ÷ visible",
        hint: "items in the visible set per item of it that is visible; 1.00: no hidden item",
        short: "÷ visible",
        cell: |_, report| {
            report
                .overestimate()
                .map_or_else(none, |ratio| format!("{ratio:.2}"))
        },
    },
    Column {
        name: "missed",
        hint: "false culls over all views: items that are certainly visible and not in the set",
        short: "missed",
        cell: |_, report| count(report.summary.missed as u64),
    },
    Column {
        name: "pixels wrong",
        hint: "wrong pixels over all views: the surface drawn there is not visible according to the reference",
        short: "wrong px",
        cell: |_, report| count(report.summary.pixels_different),
    },
    Column {
        name: "contested",
        hint: "samples over all views that have more than one possible owner; any of them is right",
        short: "",
        cell: |_, report| {
            let checks = report.views.iter().filter_map(|view| view.check.as_ref());
            count(checks.map(|check| check.pixels_contested).sum())
        },
    },
];

fn none() -> String {
    "–".to_owned()
}

/// Returns the number of faces built per face of the scene.
pub(super) fn growth(comparison: &Comparison, report: &Report) -> Option<f64> {
    (comparison.faces > 0).then(|| report.faces_built as f64 / comparison.faces as f64)
}

/// Ratio of items in the set to visible ones from which the verdict is "culls little".
const CULLS_LITTLE_RATIO: f64 = 2.0;

/// Returns the verdict of a method: its class in the style sheet, and its text.
pub(super) fn verdict(report: &Report) -> (&'static str, &'static str) {
    if report.views.is_empty() {
        return ("allowed", "no views");
    }
    match (report.is_wrong(), report.contract) {
        (false, _)
            if report
                .overestimate()
                .is_some_and(|ratio| ratio >= CULLS_LITTLE_RATIO) =>
        {
            ("allowed", "misses nothing, culls little")
        }
        (false, Contract::Conservative) => ("right", "misses nothing"),
        (false, _) => ("right", "right"),
        (true, Contract::Approximate) => ("allowed", "wrong, allowed"),
        (true, _) => ("broken", "breaks its contract"),
    }
}

/// Returns the table for standard output.
pub(super) fn as_text(comparison: &Comparison) -> String {
    let columns = || COLUMNS.iter().filter(|column| !column.short.is_empty());
    let mut header = vec!["method", "contract"];
    header.extend(columns().map(|column| column.short));
    header.push("verdict");
    let row = |report: &Report| {
        let mut row = vec![report.method.to_owned(), report.contract.to_string()];
        row.extend(columns().map(|column| (column.cell)(comparison, report)));
        row.push(verdict(report).1.to_owned());
        row
    };
    table(&header, &comparison.reports.iter().map(row).collect::<Vec<_>>())
}

/// Returns the table for the page, and the skipped methods.
pub(super) fn as_html(comparison: &Comparison) -> String {
    let mut html = String::from(
        "<div class=\"wide\"><table class=\"summary\"><thead><tr><th scope=\"col\">method</th>\
         <th scope=\"col\" class=\"word\">verdict</th><th scope=\"col\" class=\"word minor\">contract</th>",
    );
    for column in &COLUMNS {
        let Column { name, hint, .. } = column;
        html += &format!(
            "<th scope=\"col\" title=\"{hint}\"{class}>{name}</th>",
            class = column.class()
        );
    }
    html += "</tr></thead>\n<tbody>\n";
    for report in comparison.reports {
        html += &row(comparison, report);
    }
    html += "</tbody></table></div>\n";
    if !comparison.skipped.is_empty() {
        html += "<ul class=\"skipped\">\n";
        for skipped in comparison.skipped {
            html += &format!(
                "<li><b>{}</b> is skipped: {}</li>\n",
                escaped(skipped.method),
                escaped(&skipped.why)
            );
        }
        html += "</ul>\n";
    }
    html
}

fn row(comparison: &Comparison, report: &Report) -> String {
    let (class, words) = verdict(report);
    let mut row = format!(
        "<tr><th scope=\"row\">{}<small class=\"narrow\">{contract}</small></th>\
         <td class=\"word\"><span class=\"badge {class}\">{words}</span></td><td class=\"word minor\">{contract}</td>",
        method(report.method),
        contract = report.contract
    );
    for column in &COLUMNS {
        row += &format!("<td{}>{}</td>", column.class(), (column.cell)(comparison, report));
    }
    row + "</tr>\n"
}

/// Returns the name of a method, after a square of its colour.
pub(super) fn method(name: &str) -> String {
    let [r, g, b] = color(name);
    format!(
        "<span class=\"swatch\" style=\"background:#{r:02x}{g:02x}{b:02x}\"></span>{}",
        escaped(name)
    )
}

/// Returns the facts of the scene and the run, as names and values.
pub(super) fn scene_facts(comparison: &Comparison) -> Vec<(&'static str, String)> {
    let scene = &comparison.scene;
    let [width, height] = comparison.args.cameras.size;
    let mut facts = vec![
        ("items", count(scene.items as u64)),
        ("triangles", count(scene.triangles)),
        ("faces", count(comparison.faces)),
        ("sectors", count(scene.sectors as u64)),
        ("portals", count(scene.portals as u64)),
        ("screen", format!("{width} × {height}")),
        ("views", count(comparison.views as u64)),
        ("threads", rayon::current_num_threads().to_string()),
        ("SIMD", enfilade::simd_level().to_owned()),
    ];
    if comparison.args.how.portals.flat {
        facts.push(("openings", "plain holes".to_owned()));
    }
    if comparison.args.how.no_coherence {
        facts.push(("temporal coherence", "off".to_owned()));
    }
    facts
}

/// Returns `2 missed, 1,234 pixels wrong`; `None` if nothing is wrong.
pub(super) fn failures(missed: usize, pixels: u64) -> Option<String> {
    let mut failures = Vec::new();
    if missed > 0 {
        failures.push(format!("{} missed", count(missed as u64)));
    }
    if pixels > 0 {
        failures.push(format!("{} wrong", plural(pixels as usize, "pixel")));
    }
    (!failures.is_empty()).then(|| failures.join(", "))
}
