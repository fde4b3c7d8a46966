//! The HTML page: one self-contained file.

use super::charts::{self, Bar, Unit};
use super::{Comparison, summary, views};
use crate::html::escaped;
use crate::report::Report;
use anyhow::Result;

/// Returns the whole page.
pub(super) fn page(comparison: &Comparison) -> Result<String> {
    let scene = escaped(&comparison.scene.file);
    Ok(format!(
        "<!DOCTYPE html>\n<html lang=\"en\">\n<head>\n<meta charset=\"utf-8\">\n\
         <meta name=\"viewport\" content=\"width=device-width, initial-scale=1\">\n\
         <meta http-equiv=\"Content-Security-Policy\" content=\"{ALLOWED}\">\n\
         <title>{scene}: methods compared by Enfilade</title>\n<style>\n{STYLE}</style>\n</head>\n<body>\n\
         <header>\n<p class=\"maker\">Enfilade {version}</p>\n<h1>{title}</h1>\n{facts}</header>\n<main>\n\
         <section>\n<h2>Summary</h2>\n{table}<p class=\"note\">{TIMES}</p>\n</section>\n\
         {charts}{views}</main>\n</body>\n</html>\n",
        version = env!("CARGO_PKG_VERSION"),
        title = title(comparison, &scene),
        facts = facts(comparison),
        table = summary::as_html(comparison),
        charts = charts(comparison)?,
        views = views::as_html(comparison),
    ))
}

/// The content security policy: the page may not load anything from outside.
const ALLOWED: &str = "default-src 'none'; img-src data:; style-src 'unsafe-inline'";

const STYLE: &str = concat!(include_str!("../page.css"), include_str!("style.css"));

const TIMES: &str = "Times to look and draw are medians over the views; the time of a view is the median of three passes \
    over all views in order, after one warm-up pass, so temporal coherence always uses the view before. Building is timed \
    once. A look computes the visible set without a picture; drawing renders it, shading included. The verdict compares with \
    the reference: rays through portals, traced in double precision by code that shares nothing with the methods but their \
    input.";

fn title(comparison: &Comparison, scene: &str) -> String {
    match comparison.reports {
        [one] => format!("<b>{}</b> on {scene}", escaped(one.method)),
        several => format!("{} methods on {scene}", several.len()),
    }
}

fn facts(comparison: &Comparison) -> String {
    let facts = summary::scene_facts(comparison);
    let facts = facts
        .iter()
        .map(|(name, value)| format!("<div><dt>{name}</dt><dd>{value}</dd></div>\n"));
    format!("<dl class=\"facts\">\n{}</dl>\n", facts.collect::<String>())
}

/// A chart: its title, the unit of its axis, and its values; `None` if not measured.
struct Chart {
    title: &'static str,
    about: &'static str,
    unit: Unit,
    value: fn(&Comparison, &Report) -> Option<f64>,
}

const CHARTS: [Chart; 6] = [
    Chart {
        title: "Draw",
        about: "ms per picture, shading included",
        unit: Unit::Milliseconds,
        value: |_, report| report.median_ms(|view| view.draw_ms),
    },
    Chart {
        title: "Look",
        about: "ms for the visible set",
        unit: Unit::Milliseconds,
        value: |_, report| report.median_ms(|view| Some(view.ms)),
    },
    Chart {
        title: "Order",
        about: "ms to walk the traversal order, nothing culled",
        unit: Unit::Milliseconds,
        value: |_, report| report.median_ms(|view| view.order_ms),
    },
    Chart {
        title: "Build",
        about: "ms, once",
        unit: Unit::Milliseconds,
        value: |_, report| Some(report.build_ms),
    },
    Chart {
        title: "Memory",
        about: "of scene, method and buffers",
        unit: Unit::Bytes,
        value: |_, report| Some(report.bytes as f64),
    },
    Chart {
        title: "Growth of faces",
        about: "faces built per face of the scene",
        unit: Unit::Times,
        value: summary::growth,
    },
];

fn charts(comparison: &Comparison) -> Result<String> {
    let mut html = String::from("<section>\n<h2>Costs</h2>\n<div class=\"charts\">\n");
    let mut drawn = 0;
    for Chart {
        title,
        about,
        unit,
        value,
    } in &CHARTS
    {
        let bars = comparison.reports.iter().filter_map(|report| {
            Some(Bar {
                method: report.method,
                value: value(comparison, report)?,
            })
        });
        let bars: Vec<Bar> = bars.collect();
        if bars.is_empty() {
            continue;
        }
        let (svg, logarithmic) = charts::bars(&bars, *unit)?;
        let scale = if logarithmic { ", logarithmic" } else { "" };
        html += &format!(
            "<figure class=\"chart\"><figcaption><b>{title}</b> {about}{scale}</figcaption>\n{svg}</figure>\n"
        );
        drawn += 1;
    }
    Ok(if drawn == 0 {
        String::new()
    } else {
        html + "</div>\n</section>\n"
    })
}
