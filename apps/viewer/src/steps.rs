//! Step mode: one look, test by test, forwards and backwards.

use crate::explain;
use crate::session::{LookKey, Session};
use eframe::egui::{Color32, Painter, Rect, Stroke, StrokeKind, vec2};
use enfilade::{LookStep, View, Viewer, Visibility};
use enfilade_draw::{RgbImage, Settings, Show};

/// A look that is stepped through.
pub struct StepMode {
    /// All steps of the look.
    pub all: Vec<LookStep>,
    /// Number of steps done.
    pub done: usize,
    /// The state of the cover after them.
    pub cover: RgbImage,
    view: View,
    of: LookKey,
    viewer: Viewer,
}

impl StepMode {
    /// Begins with the look of a session, before the first step.
    pub fn new(session: &Session) -> StepMode {
        let mut mode = StepMode {
            all: Vec::new(),
            done: 0,
            cover: RgbImage::new(1, 1),
            view: session.view,
            of: session.key(),
            viewer: Viewer::with_options(session.viewer.options),
        };
        mode.all = mode.look(session, usize::MAX);
        mode.go_to(session, 0);
        mode
    }

    /// Whether it still steps through the look of the session.
    pub fn is_of(&self, session: &Session) -> bool {
        self.of == session.key()
    }

    /// Goes to a number of steps done.
    pub fn go_to(&mut self, session: &Session, done: usize) {
        self.done = done.min(self.all.len());
        self.look(session, self.done);
    }

    fn look(&mut self, session: &Session, limit: usize) -> Vec<LookStep> {
        let world = &session.world;
        let mut settings = Settings::default();
        settings.show = Show::Cover;
        let mut painter = enfilade_draw::Painter::on(&world.stage, &world.scene, &self.view, &settings);
        let steps = self
            .viewer
            .look_steps(&world.scene, &self.view, limit, &mut painter);
        self.cover = painter.finish().image;
        steps
    }

    /// Says what the last step did.
    pub fn text(&self, session: &Session) -> String {
        let scene = &session.world.scene;
        let sector = |passage: enfilade::PassageId| {
            let passages = session.viewer.visible().passages();
            passages.get(passage.0 as usize).map(|passage| passage.sector)
        };
        match self.done.checked_sub(1).and_then(|last| self.all.get(last)) {
            None => "Nothing is tested yet, and the cover is empty.".to_owned(),
            Some(LookStep::Occluder { passage, item, .. }) => {
                let name =
                    sector(*passage).map_or_else(String::new, |sector| explain::name(scene, sector, *item));
                format!("An occluder is selected and put into the cover: a face of {name}.")
            }
            Some(LookStep::Box { rect, visibility, .. }) => {
                let answer = match visibility {
                    Visibility::Hidden => "hidden: what is inside is skipped",
                    Visibility::Partial => "partly visible: what is inside is tested next",
                    Visibility::Full => "fully visible: what is inside need not be tested",
                };
                format!(
                    "A box of {}x{} pixels is {answer}.",
                    rect.x1 - rect.x0,
                    rect.y1 - rect.y0
                )
            }
            Some(LookStep::Cluster {
                passage,
                item,
                cluster,
            }) => {
                let name =
                    sector(*passage).map_or_else(String::new, |sector| explain::name(scene, sector, *item));
                let part = cluster.map_or("all".to_owned(), |number| format!("cluster {number}"));
                format!("Found: {part} of {name}. If it is opaque, the cover takes its faces.")
            }
            Some(LookStep::Opening { passage, opening }) => {
                let openings = sector(*passage).map(|sector| scene.sector(sector).openings());
                let name = openings.and_then(|openings| openings.get(usize::from(opening.0)));
                let name = name.map_or("", |opening| opening.name.as_str());
                format!("Found: the opening `{name}`. What is behind it comes later.")
            }
            Some(_) => String::new(),
        }
    }

    /// Draws the boxes of the last steps over a picture.
    pub(crate) fn draw(&self, painter: &Painter, rect: Rect) {
        /// Boxes that are drawn, the older the fainter.
        const SHOWN: usize = 24;
        let painter = painter.with_clip_rect(rect);
        let size = self.view.size().map(|side| side as f32);
        let scale = rect.size() / vec2(size[0], size[1]);
        let first = self.done.saturating_sub(SHOWN);
        for (number, step) in self.all[..self.done].iter().enumerate().skip(first) {
            let LookStep::Box {
                rect: tested,
                visibility,
                ..
            } = step
            else {
                continue;
            };
            let color = match visibility {
                Visibility::Hidden => Color32::from_rgb(255, 90, 70),
                Visibility::Partial => Color32::from_rgb(255, 205, 60),
                Visibility::Full => Color32::from_rgb(90, 220, 120),
            };
            let [x0, y0, x1, y1] = [tested.x0, tested.y0, tested.x1, tested.y1].map(f32::from);
            let on = Rect::from_min_max(rect.min + vec2(x0, y0) * scale, rect.min + vec2(x1, y1) * scale);
            let is_last = number + 1 == self.done;
            if is_last {
                painter.rect_filled(on, 0.0, color.gamma_multiply(0.25));
            }
            let age = (self.done - number) as f32 / SHOWN as f32;
            let stroke = Stroke::new(
                if is_last { 2.5 } else { 1.0 },
                color.gamma_multiply(1.0 - 0.8 * age),
            );
            painter.rect_stroke(on, 0.0, stroke, StrokeKind::Inside);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::world::World;

    #[test]
    fn steps_go_forwards_and_backwards_and_say_what_they_did() {
        let mut session = Session::new(World::open("@two-rooms").expect("a built-in scene"));
        session.look([160, 120]);
        let mut mode = StepMode::new(&session);
        let steps = mode.all.len();
        assert!(steps > 5, "{steps}");
        let empty = mode.cover.clone();
        mode.go_to(&session, steps);
        assert_ne!(mode.cover, empty, "the cover holds what was found");
        assert!(!mode.text(&session).is_empty());
        mode.go_to(&session, 0);
        assert_eq!(mode.cover, empty);
        assert!(mode.is_of(&session));
    }
}
