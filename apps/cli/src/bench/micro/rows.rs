//! The rows that need no scene, by the names under which figures of other cullers are known.

use super::Row;
use super::boxes::Boxes;
use super::faces::Faces;
use super::screen::Screen;
use super::shapes::{From, Shapes};

/// Boxes that are asked about: as many as a large scene has items.
const BOXES: usize = 4096;

/// All of them, each with the figure of the best other culler, in millions a second.
pub(super) fn all(screen: &Screen) -> Vec<Row> {
    let lens = &screen.lens;
    let btf = |sides, pixels, count| Shapes::new(lens, sides, pixels, count, From::Back);
    let ftb = |sides, pixels, count| Shapes::new(lens, sides, pixels, count, From::Front);
    let row = |name, best, shapes| Row::new(name, best, Box::new(Faces::once(shapes)));
    let mut rows = vec![
        row("tri-10", 36.0, btf(3, 10.0, 1_000_000)),
        row("quad-10", 62.0, btf(4, 10.0, 1_000_000)),
        row("tri-100", 28.0, btf(3, 100.0, 100_000)),
        row("tri-1000", 15.6, btf(3, 1000.0, 50_000)),
        row("tri-10000-btf", 5.5, btf(3, 10_000.0, 10_000)),
        row("tri-10000-ftb", 8.5, ftb(3, 10_000.0, 10_000)),
        row("tri-10-near", 18.5, Shapes::near(lens, 10.0, 1_000_000)),
    ];
    let backs = Faces::again_and_again(btf(3, 10.0, 1000).turned());
    rows.push(Row::new("tri-back", 790.0, Box::new(backs)));
    let hidden = [
        ("rect-hidden-4", 4, 95.0),
        ("rect-hidden-16", 16, 72.0),
        ("rect-hidden-64", 64, 36.0),
        ("rect-hidden-200", 200, 9.4),
    ];
    for (name, side, best) in hidden {
        let boxes = Boxes::hidden(screen.squares(side, BOXES));
        rows.push(Row::new(name, best, Box::new(boxes)));
    }
    let boxes = Boxes::visible(screen.squares(64, BOXES));
    rows.push(Row::new("rect-visible", 215.0, Box::new(boxes)));
    rows
}
