//! The rows that need no scene.

use super::boxes::Boxes;
use super::faces::Faces;
use super::items::Items;
use super::screen::Screen;
use super::shapes::{FaceOrder, Shapes};
use super::{Row, Workload};

/// Number of boxes that are tested: as many as a large scene has items.
const BOXES: usize = 4096;

type MakeWorkload = fn(&Screen) -> Box<dyn Workload>;

/// Name and workload of each row.
const ROWS: [(&str, MakeWorkload); 14] = [
    ("tri-10", |screen| btf(screen, 3, 10.0, 1_000_000)),
    ("quad-10", |screen| btf(screen, 4, 10.0, 1_000_000)),
    ("tri-100", |screen| btf(screen, 3, 100.0, 100_000)),
    ("tri-1000", |screen| btf(screen, 3, 1000.0, 50_000)),
    ("tri-10000-btf", |screen| btf(screen, 3, 10_000.0, 10_000)),
    ("tri-10000-ftb", |screen| {
        let shapes = Shapes::new(&screen.lens, 3, 10_000.0, 10_000, FaceOrder::FrontToBack);
        Box::new(Faces::once(shapes))
    }),
    ("tri-10-near", |screen| {
        Box::new(Faces::once(Shapes::near(&screen.lens, 10.0, 1_000_000)))
    }),
    ("tri-back", |screen| {
        let shapes = Shapes::new(&screen.lens, 3, 10.0, 1000, FaceOrder::BackToFront);
        Box::new(Faces::repeated(shapes.reversed()))
    }),
    ("rect-hidden-4", |screen| hidden(screen, 4)),
    ("rect-hidden-16", |screen| hidden(screen, 16)),
    ("rect-hidden-64", |screen| hidden(screen, 64)),
    ("rect-hidden-200", |screen| hidden(screen, 200)),
    ("rect-visible", |screen| {
        Box::new(Boxes::visible(screen.squares(64, BOXES)))
    }),
    ("items", |screen| Box::new(Items::new(screen, BOXES))),
];

/// Returns the names of the rows.
pub(super) fn names() -> impl Iterator<Item = &'static str> {
    ROWS.iter().map(|&(name, ..)| name)
}

/// Creates the rows selected by name.
pub(super) fn rows(screen: &Screen, wanted: impl Fn(&str) -> bool) -> Vec<Row> {
    let rows = ROWS.iter().filter(|(name, ..)| wanted(name));
    rows.map(|(name, make)| Row::new(name, make(screen))).collect()
}

fn btf(screen: &Screen, sides: usize, pixels: f64, count: usize) -> Box<dyn Workload> {
    Box::new(Faces::once(Shapes::new(
        &screen.lens,
        sides,
        pixels,
        count,
        FaceOrder::BackToFront,
    )))
}

fn hidden(screen: &Screen, side: u16) -> Box<dyn Workload> {
    Box::new(Boxes::hidden(screen.squares(side, BOXES)))
}
