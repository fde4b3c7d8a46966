//! The pictures of each view, and the numbers that belong to them.

use super::Comparison;
use super::html::escaped;
use super::pictures::{MethodPictures, ViewPictures};
use super::summary::{method, what_is_wrong};
use crate::report::{CheckReport, Report, ViewReport};
use crate::text::{count, ms, plural, point};

/// A section for each view with pictures, and a table of the others.
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
        place(view),
        n = number + 1
    );
    html += &truth(view, pictures);
    for (report, drawn) in comparison.reports.iter().zip(&pictures.methods) {
        html += &card(report, &report.views[number], number, drawn, pictures.size);
    }
    html + "</section>\n"
}

fn place(view: &ViewReport) -> String {
    format!(
        "from ({}) towards ({}), a lens of {}°",
        point(view.eye),
        point(view.toward),
        view.fov
    )
}

/// What is really seen, and what the marks of the pictures below mean.
fn truth(view: &ViewReport, pictures: &ViewPictures) -> String {
    let facts = view.check.as_ref().map_or(String::new(), |check| {
        let mut facts = vec![
            ("certainly visible", count(check.reference_visible as u64)),
            ("in the frustum", count(view.items_in_frustum as u64)),
            ("contested pixels", count(check.pixels_contested)),
        ];
        // Items that lie in one plane are contested, too, but not beside each other.
        if (pictures.marked as u64) < check.pixels_contested {
            facts.push(("of them marked", count(pictures.marked as u64)));
        }
        list(&facts)
    });
    let owners = if pictures.wrong == 0 {
        "Drawn by a z-buffer, each of whose pixels is one that the reference allows.".to_owned()
    } else {
        format!(
            "Drawn by a z-buffer; {} of it the reference does not allow.",
            plural(pictures.wrong as usize, "pixel")
        )
    };
    format!(
        "<div class=\"card truth\"><div class=\"words\"><h3>The reference</h3>{facts}<p>{owners}</p></div>\n{}{}\
         <div class=\"legend\">{LEGEND}</div></div>\n",
        figure(
            "what is seen",
            "The scene as it is seen",
            &pictures.image,
            pictures.size
        ),
        figure(
            "each item in a colour of its own",
            "Its items",
            &pictures.items,
            pictures.size
        ),
    )
}

const LEGEND: &str = "<h4>How to read the pictures</h4>\n<dl>\
    <dt><span class=\"mark wrong\"></span>wrong</dt><dd>the surface drawn there is not visible according to the reference; at least three \
    pixels wide, so that a single one is found</dd>\
    <dt><span class=\"mark contested\"></span>contested</dt><dd>on an edge between items, so near to the sample that \
    either may own it</dd>\
    <dt><span class=\"mark heat\"></span>overdraw</dt><dd>faces tested at a sample, from none to 16 and more</dd></dl>";

fn card(report: &Report, view: &ViewReport, number: usize, drawn: &MethodPictures, size: [u32; 2]) -> String {
    let check = view.check.as_ref();
    let wrong = check.and_then(|check| what_is_wrong(check.missed.len(), check.pixels_different));
    let class = match wrong {
        Some(_) if report.contract == enfilade::Contract::Approximate => "allowed",
        Some(_) => "broken",
        None => "right",
    };
    let verdict = wrong.as_deref().unwrap_or("as the reference");
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
    let missed = check.map_or(String::new(), names_of_the_missed);
    let incomplete = if view.complete {
        ""
    } else {
        "<p>A limit ended the look: more may be visible.</p>"
    };
    let alt = |what: &str| format!("{what} by {}, view {}", report.method, number + 1);
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

/// `34 of 120`.
fn of(visible: u64, in_frustum: u64) -> String {
    format!("{} <small>of {}</small>", count(visible), count(in_frustum))
}

fn names_of_the_missed(check: &CheckReport) -> String {
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

/// A picture with its caption; `alt` is what is read aloud instead.
fn figure(caption: &str, alt: &str, uri: &str, [width, height]: [u32; 2]) -> String {
    format!(
        "<figure><img src=\"{uri}\" alt=\"{}\" width=\"{width}\" height=\"{height}\"><figcaption>{caption}\
         </figcaption></figure>\n",
        escaped(alt)
    )
}

/// The views that have no pictures, in numbers.
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
        true => format!("<span title=\"{}\">{}</span>", place(view), number + 1),
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
