//! Emits the leaf at each pixel centre, for debug pictures.

use super::{Link, Plane, Tree};
use crate::cover::show::{push, show_rows};
use crate::view::canvas::{Canvas, CoverSpan, HiddenBy};
use crate::view::passage::Passage;
use glam::DVec3;

impl Tree {
    /// Emits the cells of the tree to a canvas, row by row.
    pub(super) fn show(&self, passage: &Passage, canvas: &mut dyn Canvas) {
        show_rows(passage, canvas, |y, [x0, x1], spans| {
            for x in x0..x1 {
                push(spans, self.at_sample(x, y));
            }
        });
    }

    /// Returns the nearest shadow at a pixel centre, or the lit leaf that extends to infinity there.
    fn at_sample(&self, x: u16, y: u16) -> CoverSpan {
        let sample = DVec3::new(f64::from(x) + 0.5, f64::from(y) + 0.5, 1.0);
        let mut span = CoverSpan {
            x0: x,
            x1: x + 1,
            cell: 0,
            by: HiddenBy::Nothing,
            rev_depth: [0.0; 2],
        };
        let mut next = self.root;
        while let Link::Node(number) = next {
            let node = &self.nodes[number as usize];
            let leaf = 2 * number + 1;
            next = match &node.plane {
                Plane::Line(line) => {
                    let inside = line.height(sample) >= 0.0;
                    if span.by == HiddenBy::Nothing {
                        span.cell = leaf + u32::from(inside);
                    }
                    if inside { node.inside } else { node.outside }
                }
                Plane::Back(back) => {
                    let occluder = self.firsts.partition_point(|&first| first <= number);
                    let rev_depth = (back.normal.dot(sample) / back.distance) as f32;
                    span = CoverSpan {
                        cell: leaf,
                        by: HiddenBy::One(occluder as u32),
                        rev_depth: [rev_depth.max(0.0); 2],
                        ..span
                    };
                    // The part in front of it may hold a nearer shadow.
                    node.outside
                }
            };
        }
        span
    }
}
