//! The sections of the page: pictures and numbers of each view.

use super::Comparison;
use super::pictures::{MethodPictures, ViewPictures};
use super::summary::{failures, method};
use crate::html::escaped;
use crate::report::{CheckReport, Report, ViewReport};
use crate::text::{count, ms, plural, point};

/// Returns a section per view with pictures, and a table of the others.
pub(super) fn as_html(comparison: &Comparison) -> String {
    let mut html = String::new();
    for (number, pictures) in comparison.pictures.iter().enumerate() {
        html += &section(comparison, number, pictures);
    }
    html + &others(comparison)
}

fn section(comparison: &Comparison, number: usize, pictures: &ViewPictures) -> String {
    let Some(view) = comparison.reports.first().map(|report| &report.views[number]) else {
        return String::new();
    };
    let mut html = format!(
        "<section class=\"view\" id=\"view-{n}\">\n<h2>View {n}</h2>\n<p class=\"place\">{}</p>\n",
        position(view),
        n = number + 1
    );
    html += &truth(view, pictures);
    for (report, drawn) in comparison.reports.iter().zip(&pictures.methods) {
        html += &card(report, &report.views[number], number, drawn, pictures.size);
    }
    html + "</section>\n"
}

fn position(view: &ViewReport) -> String {
    format!(
        "from ({}) toward ({}), {}° vertical field of view",
        point(view.eye),
        point(view.toward),
        view.fov
    )
}

/// Returns the card of the reference, with the legend of the pictures.
fn truth(view: &ViewReport, pictures: &ViewPictures) -> String {
    let facts = view.check.as_ref().map_or(String::new(), |check| {
        let mut facts = vec![
            ("certainly visible", count(check.reference_visible as u64)),
            ("in the frustum", count(view.items_in_frustum as u64)),
            ("contested pixels", count(check.pixels_contested)),
        ];
        // Samples of coplanar items are contested too, but not marked: only edges are.
        if (pictures.marked as u64) < check.pixels_contested {
            facts.push(("of these marked", count(pictures.marked as u64)));
        }
        list(&facts)
    });
    let owners = if pictures.wrong == 0 {
        "Drawn with a z-buffer; the reference allows every pixel.".to_owned()
    } else {
        format!(
            "Drawn with a z-buffer; the reference does not allow {} of it.",
            plural(pictures.wrong as usize, "pixel")
        )
    };
    format!(
        "<div class=\"card truth\"><div class=\"words\"><h3>The reference</h3>{facts}<p>{owners}</p></div>\n{}{}\
         <div class=\"legend\">{LEGEND}</div></div>\n",
        figure("picture", "The scene", &pictures.image, pictures.size),
        figure(
            "items, each in its colour",
            "The items",
            &pictures.items,
            pictures.size
        ),
    )
}

const LEGEND: &str = "<h4>How to read the pictures</h4>\n<dl>\
    <dt><span class=\"mark wrong\"></span>wrong</dt><dd>the surface drawn there is not visible according to the reference; marks are at \
    least three pixels wide, so that a single one can be found</dd>\
    <dt><span class=\"mark contested\"></span>contested</dt><dd>on an edge between items that is so close to the \
    sample that either may own it</dd>\
    <dt><span class=\"mark heat\"></span>overdraw</dt><dd>number of faces tested at a sample, from 0 to 16 or more</dd></dl>";

fn card(report: &Report, view: &ViewReport, number: usize, drawn: &MethodPictures, size: [u32; 2]) -> String {
    let check = view.check.as_ref();
    let wrong = check.and_then(|check| failures(check.missed.len(), check.pixels_different));
    let class = match wrong {
        Some(_) if report.contract == enfilade::Contract::Approximate => "allowed",
        Some(_) => "broken",
        None => "right",
    };
    let verdict = wrong.as_deref().unwrap_or("agrees with the reference");
    let mut facts = vec![
        (
            "items",
            of(view.items_visible as u64, view.items_in_frustum as u64),
        ),
        ("triangles", of(view.triangles_visible, view.triangles_in_frustum)),
        ("passages", count(view.passages as u64)),
        ("look", format!("{} ms", ms(view.ms))),
    ];
    let times = [("draw", view.draw_ms), ("order", view.order_ms)];
    facts.extend(
        times
            .into_iter()
            .filter_map(|(name, time)| Some((name, format!("{} ms", ms(time?))))),
    );
    if let Some(extra) = check.map(|check| check.extra).filter(|&extra| extra > 0) {
        facts.push(("extra", count(extra as u64)));
    }
    let missed = check.map_or(String::new(), missed_names);
    let incomplete = if view.complete {
        ""
    } else {
        "<p>Portal recursion limit reached; the visible set may be incomplete.</p>"
    };
    let alt = |picture: &str| format!("{picture} by {}, view {}", report.method, number + 1);
    format!(
        "<div class=\"card {class}\"><div class=\"words\"><h3>{}</h3><p><span class=\"badge {class}\">{verdict}</span>\
         </p>{}{incomplete}</div>\n{}{}{}{missed}</div>\n",
        method(report.method),
        list(&facts),
        figure("picture", &alt("Picture"), &drawn.image, size),
        figure("difference", &alt("Difference"), &drawn.difference, size),
        figure("overdraw", &alt("Overdraw"), &drawn.overdraw, size),
    )
}

/// Formats `34 of 120`.
fn of(visible: u64, in_frustum: u64) -> String {
    format!("{} <small>of {}</small>", count(visible), count(in_frustum))
}

/// Returns a list of the false culls.
fn missed_names(check: &CheckReport) -> String {
    const FEW: usize = 6;
    if check.missed.is_empty() {
        return String::new();
    }
    let names: Vec<String> = check.missed.iter().take(FEW).map(|name| escaped(name)).collect();
    let more = match check.missed.len().saturating_sub(FEW) {
        0 => String::new(),
        more => format!(" and {} more", count(more as u64)),
    };
    format!("<p class=\"missed\">Missed: {}{more}</p>", names.join(", "))
}

fn list(facts: &[(&str, String)]) -> String {
    let facts = facts
        .iter()
        .map(|(name, value)| format!("<div><dt>{name}</dt><dd>{value}</dd></div>"));
    format!("<dl>{}</dl>", facts.collect::<String>())
}

/// Returns a picture with its caption and alternative text.
fn figure(caption: &str, alt: &str, uri: &str, [width, height]: [u32; 2]) -> String {
    format!(
        "<figure><img src=\"{uri}\" alt=\"{}\" width=\"{width}\" height=\"{height}\"><figcaption>{caption}\
         </figcaption></figure>\n",
        escaped(alt)
    )
}

/// Returns the table of the views without pictures.
fn others(comparison: &Comparison) -> String {
    let first = comparison.pictures.len();
    if first >= comparison.views || comparison.reports.is_empty() {
        return String::new();
    }
    let mut html = format!(
        "<section class=\"view\"><h2>{}</h2>\n<details><summary>{} without pictures</summary>\n<div class=\"wide\">\
         <table><thead><tr><th scope=\"col\">view</th><th scope=\"col\" class=\"word\">method</th>\
         <th scope=\"col\">items</th><th scope=\"col\">look ms</th><th scope=\"col\">draw ms</th>\
         <th scope=\"col\">missed</th><th scope=\"col\">pixels wrong</th><th scope=\"col\">contested</th></tr></thead>\
         \n<tbody>\n",
        if first == 0 {
            "The views"
        } else {
            "The other views"
        },
        plural(comparison.views - first, "view"),
    );
    for number in first..comparison.views {
        for (row, report) in comparison.reports.iter().enumerate() {
            html += &other(report, number, row == 0);
        }
    }
    html + "</tbody></table></div></details></section>\n"
}

fn other(report: &Report, number: usize, first: bool) -> String {
    let view = &report.views[number];
    let of_check = |of: fn(&CheckReport) -> u64| view.check.as_ref().map_or(String::new(), |c| count(of(c)));
    let name = match first {
        true => format!("<span title=\"{}\">{}</span>", position(view), number + 1),
        false => String::new(),
    };
    format!(
        "<tr{}><td>{name}</td><td class=\"word\">{}</td><td>{}</td><td>{}</td><td>{}</td><td>{}</td><td>{}</td>\
         <td>{}</td></tr>\n",
        if first { " class=\"next\"" } else { "" },
        method(report.method),
        count(view.items_visible as u64),
        ms(view.ms),
        view.draw_ms.map_or(String::new(), ms),
        of_check(|check| check.missed.len() as u64),
        of_check(|check| check.pixels_different),
        of_check(|check| check.pixels_contested),
    )
}
