//! Heat maps: one row per scene or room, one column per method.

use anyhow::Result;
use enfilade::{Contract, Method};
use plotters::prelude::*;
use plotters::style::text_anchor::{HPos, Pos, VPos};
use std::path::Path;

/// One row of a chart: a scene or a room, and a value per method.
pub(super) struct Row {
    pub(super) name: String,
    pub(super) values: Vec<Option<f64>>,
}

/// Pairs of methods that share a tree: the second reuses what the first built, so it takes at least the first value.
const SHARED: [[Method; 2]; 2] = [[Method::Bsp, Method::BspFront], [Method::Svbsp, Method::Mobsp]];

impl Row {
    pub(super) fn share(&mut self) {
        for pair in SHARED {
            let [first, second] = pair.map(|method| Method::ALL.iter().position(|one| *one == method));
            if let (Some(first), Some(second)) = (first, second)
                && let (Some(shared), Some(own)) = (self.values[first], self.values[second])
            {
                self.values[second] = Some(own.max(shared));
            }
        }
    }
}

/// Formats a value with two or three significant digits.
pub(super) fn significant(value: f64) -> String {
    match value {
        value if value >= 99.5 => format!("{value:.0}"),
        value if value >= 9.95 => format!("{value:.1}"),
        value if value >= 0.095 => format!("{value:.2}"),
        value => format!("{value:.3}"),
    }
}

const NAMES: i32 = 176;
const CELL: [i32; 2] = [78, 24];
const HEAD: i32 = 66;
const INK: RGBColor = RGBColor(38, 43, 51);
const FAINT: RGBColor = RGBColor(118, 125, 137);

/// Draws a table whose cells are colored by their ratio to the best of the row; the best exact method is framed.
pub(super) fn draw(
    file: &Path,
    title: &str,
    columns: &[&str],
    rows: &[Row],
    written: fn(f64) -> String,
) -> Result<()> {
    let size = [
        NAMES + CELL[0] * columns.len() as i32 + 8,
        HEAD + CELL[1] * rows.len() as i32 + 8,
    ];
    let root = SVGBackend::new(file, (size[0] as u32, size[1] as u32)).into_drawing_area();
    root.fill(&WHITE)?;
    let text = |size: i32, color: &RGBColor, across: HPos| {
        ("sans-serif", size)
            .into_font()
            .color(color)
            .pos(Pos::new(across, VPos::Center))
    };
    root.draw(&Text::new(title.to_owned(), (8, 16), text(15, &INK, HPos::Left)))?;
    let all = Method::ALL.map(Method::name);
    for (number, column) in columns.iter().enumerate() {
        let middle = NAMES + CELL[0] * number as i32 + CELL[0] / 2;
        let words: Vec<&str> = column.split('-').collect();
        for (line, word) in words.iter().enumerate() {
            let from_below = (words.len() - line) as i32;
            let at = (middle, HEAD - 2 - 15 * from_below + 4);
            root.draw(&Text::new((*word).to_owned(), at, text(13, &INK, HPos::Center)))?;
        }
    }
    for (number, row) in rows.iter().enumerate() {
        let top = HEAD + CELL[1] * number as i32;
        let middle = top + CELL[1] / 2;
        let name = Text::new(
            row.name.clone(),
            (NAMES - 10, middle),
            text(13, &INK, HPos::Right),
        );
        root.draw(&name)?;
        let best = best_of(row, |_| true);
        let is_exact = |method: Method| method.contract() == Contract::Exact;
        let best_exact = best_of(row, is_exact);
        let are_best = row.values.iter().zip(Method::ALL);
        let are_best = are_best.filter(|(value, method)| is_exact(*method) && **value == Some(best_exact));
        let is_one_best = are_best.count() == 1;
        for (place, column) in columns.iter().enumerate() {
            let left = NAMES + CELL[0] * place as i32;
            let value = all
                .iter()
                .position(|name| name == column)
                .and_then(|at| row.values[at]);
            let corners = [(left + 1, top + 1), (left + CELL[0] - 1, top + CELL[1] - 1)];
            let (shown, ink) = match value {
                Some(value) => {
                    root.draw(&Rectangle::new(corners, shade(value / best).filled()))?;
                    let is_exact = Method::by_name(column).is_some_and(is_exact);
                    if is_one_best && is_exact && value == best_exact {
                        root.draw(&Rectangle::new(corners, INK.stroke_width(2)))?;
                    }
                    (written(value), &INK)
                }
                None => ("–".to_owned(), &FAINT),
            };
            let at = (left + CELL[0] / 2, middle);
            root.draw(&Text::new(shown, at, text(13, ink, HPos::Center)))?;
        }
    }
    root.present()?;
    Ok(())
}

/// Returns the minimum of a row over the given methods.
fn best_of(row: &Row, counts: impl Fn(Method) -> bool) -> f64 {
    let values = row
        .values
        .iter()
        .zip(Method::ALL)
        .filter(|(_, method)| counts(*method));
    values
        .filter_map(|(value, _)| *value)
        .fold(f64::INFINITY, f64::min)
}

/// Returns the color of a ratio to the best: green at 1, yellow at 3, red at 10 and more.
fn shade(times: f64) -> RGBColor {
    const STOPS: [[f64; 3]; 3] = [
        [188.0, 225.0, 190.0],
        [252.0, 242.0, 196.0],
        [240.0, 170.0, 150.0],
    ];
    let place = (times.max(1.0).log10() * 2.0).clamp(0.0, 2.0);
    let from = (place as usize).min(1);
    let share = place - from as f64;
    let [r, g, b] = [0, 1, 2].map(|i| (STOPS[from][i] + share * (STOPS[from + 1][i] - STOPS[from][i])) as u8);
    RGBColor(r, g, b)
}
