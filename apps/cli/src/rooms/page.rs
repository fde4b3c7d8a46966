//! The HTML page of floor plans: one self-contained file.

use super::plan::{Plan, plan};
use super::{RoomRow, Rooms};
use crate::html::escaped;
use crate::text::{plural, short};
use std::fmt::Write;

/// The content security policy: the page may not load anything from outside.
const ALLOWED: &str = "default-src 'none'; style-src 'unsafe-inline'";

const STYLE: &str = concat!(include_str!("../page.css"), include_str!("style.css"));

/// Returns the whole page.
pub(super) fn page(rooms: &Rooms) -> String {
    let report = &rooms.report;
    let file = escaped(&report.file);
    let mut body = String::new();
    for storey in 0..report.storeys {
        if let Some(plan) = plan(rooms, storey) {
            body += &section(rooms, storey, &plan);
        }
    }
    format!(
        "<!DOCTYPE html>\n<html lang=\"en\">\n<head>\n<meta charset=\"utf-8\">\n\
         <meta name=\"viewport\" content=\"width=device-width, initial-scale=1\">\n\
         <meta http-equiv=\"Content-Security-Policy\" content=\"{ALLOWED}\">\n\
         <title>{file}: rooms and doors</title>\n<style>\n{STYLE}</style>\n</head>\n<body>\n<header>\n\
         <p class=\"maker\">Enfilade {version}</p>\n<h1>Rooms of {file}</h1>\n{facts}{legend}</header>\n<main>\n{body}{suggestions}\
         </main>\n</body>\n</html>\n",
        version = env!("CARGO_PKG_VERSION"),
        facts = facts(rooms),
        legend = LEGEND,
        suggestions = suggestions(rooms),
    )
}

const LEGEND: &str = "<p class=\"legend\"><span><i class=\"wall\"></i>wall or large furniture</span>\
    <span><i class=\"door\"></i>door</span><span><i class=\"window\"></i>window</span>\
    <span><i class=\"opening\"></i>opening</span></p>\n";

fn facts(rooms: &Rooms) -> String {
    let report = &rooms.report;
    let indoors = report.rooms.iter().filter(|room| !room.outside);
    let area: f64 = indoors.clone().map(|room| room.area_m2).sum();
    let facts = [
        ("Rooms", indoors.count().to_string()),
        ("Storeys", report.storeys.to_string()),
        ("Floor area", format!("{} m²", short(area.round()))),
        ("Doors", report.doors.to_string()),
        ("Windows", report.windows.to_string()),
        ("Openings", report.openings.to_string()),
        ("Voxels", format!("{} cm", short(100.0 * report.voxel_m))),
        ("Time", format!("{} s", short(report.seconds))),
    ];
    let facts = facts
        .iter()
        .map(|(name, value)| format!("<div><dt>{name}</dt><dd>{value}</dd></div>\n"));
    format!("<dl class=\"facts\">\n{}</dl>\n", facts.collect::<String>())
}

fn section(rooms: &Rooms, storey: usize, plan: &Plan) -> String {
    let shown = |room: &u32| &rooms.report.rooms[*room as usize];
    let mut rows: Vec<&RoomRow> = plan.rooms.iter().map(shown).collect();
    rows.sort_by(|a, b| a.name.cmp(&b.name));
    let mut table = String::new();
    for room in rows {
        // Writing to a String cannot fail.
        let _ = writeln!(
            table,
            "<tr><th>{}</th><td>{}</td><td>{}</td><td>{}</td><td>{}</td><td>{}</td><td>{}</td><td>{}</td></tr>",
            escaped(&room.name),
            short(room.area_m2),
            short(room.height_m),
            short(room.volume_m3),
            room.doors,
            room.windows,
            room.openings,
            room.items,
        );
    }
    let floor = rooms.found.graph.storeys().nth(storey).unwrap_or(0.0) * rooms.report.metres_per_unit;
    format!(
        "<section>\n<h2>Storey {storey} <small>floor at {} m, {}</small></h2>\n<div class=\"plan\">{}</div>\n\
         <details><summary>Table of rooms</summary><div class=\"wide\"><table><thead><tr><th>Room</th><th>Area, m²</th>\
         <th>Height, m</th><th>Volume, m³</th><th>Doors</th><th>Windows</th><th>Openings</th><th>Items</th></tr></thead>\n\
         <tbody>\n{table}</tbody></table></div></details>\n</section>\n",
        short((100.0 * floor).round() / 100.0),
        plural(plan.rooms.len(), "room"),
        plan.svg,
    )
}

fn suggestions(rooms: &Rooms) -> String {
    let suggestions = &rooms.report.suggestions;
    if suggestions.is_empty() {
        return String::new();
    }
    let mut rows = String::new();
    for suggestion in suggestions {
        let [one, other] = &suggestion.rooms;
        let _ = writeln!(
            rows,
            "<tr><th>{}</th><td>{}</td><td>{}</td></tr>",
            escaped(&suggestion.item),
            escaped(one),
            escaped(other)
        );
    }
    format!(
        "<section>\n<h2>May be closed doors <small>by their shape; --doors makes them doors by name</small></h2>\n\
         <div class=\"wide\"><table><thead><tr><th>Item</th><th>Room</th><th>Room</th></tr></thead>\n<tbody>\n{rows}</tbody>\
         </table></div>\n</section>\n"
    )
}
