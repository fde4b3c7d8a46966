//! Numbers of the last frames, as plots.

use crate::counts::grouped;
use eframe::egui::{Align2, Color32, FontId, Pos2, Rect, Sense, Shape, Stroke, Ui, vec2};
use std::collections::VecDeque;

/// Frames that are kept.
const FRAMES: usize = 240;

/// One frame.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct Frame {
    pub(crate) look_ms: f64,
    pub(crate) encode_ms: f64,
    pub(crate) items: f64,
    pub(crate) items_in_frustum: f64,
    pub(crate) triangles: f64,
    pub(crate) triangles_in_frustum: f64,
    pub(crate) draw_calls: f64,
    pub(crate) passages: f64,
}

/// A value of the frames to plot: its name, its colour, and where it is.
pub(crate) type Series<'a> = (&'a str, Color32, fn(&Frame) -> f64);

/// The last frames.
#[derive(Default)]
pub(crate) struct History {
    frames: VecDeque<Frame>,
}

impl History {
    pub(crate) fn push(&mut self, frame: Frame) {
        if self.frames.len() == FRAMES {
            self.frames.pop_front();
        }
        self.frames.push_back(frame);
    }

    /// Plots values of the frames over each other.
    pub(crate) fn plot(&self, ui: &mut Ui, series: &[Series], unit: &str) {
        let (rect, _) = ui.allocate_exact_size(vec2(ui.available_width(), 46.0), Sense::hover());
        let painter = ui.painter_at(rect);
        painter.rect_filled(rect, 3.0, Color32::from_rgb(18, 20, 26));
        let all = || self.frames.iter();
        let most = series
            .iter()
            .flat_map(|(.., value)| all().map(value))
            .fold(1e-9, f64::max);
        let inner = Rect::from_min_max(rect.min + vec2(2.0, 16.0), rect.max - vec2(2.0, 2.0));
        for (number, (name, color, value)) in series.iter().enumerate() {
            let point = |(frame, of): (usize, &Frame)| -> Pos2 {
                let x = inner.left() + inner.width() * frame as f32 / (FRAMES - 1) as f32;
                Pos2::new(x, inner.bottom() - inner.height() * (value(of) / most) as f32)
            };
            let line: Vec<Pos2> = all().enumerate().map(point).collect();
            painter.add(Shape::line(line, Stroke::new(1.5, *color)));
            let at = rect.min + vec2(6.0 + 0.5 * rect.width() * number as f32, 2.0);
            let last = self.frames.back().map_or(0.0, value);
            let text = if unit.is_empty() {
                format!("{name} {}", grouped(last as u64))
            } else {
                format!("{name} {last:.2} {unit}")
            };
            painter.text(at, Align2::LEFT_TOP, text, FontId::proportional(11.0), *color);
        }
    }
}
