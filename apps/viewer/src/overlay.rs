//! Lines over the picture: frustum, sectors, portals, apertures, occluders, and the selected item.

use crate::occluders::{Occluder, Outline};
use crate::session::Session;
use eframe::egui::{Align2, Color32, FontId, Painter, Pos2, Rect, Shape, Stroke, vec2};
use enfilade::{Aabb, Passage, PassageId, Transform, View};
use glam::{DMat4, DVec3, DVec4};

/// What is drawn over the picture.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Overlays {
    /// Edges of the frozen frustum.
    pub frustum: bool,
    /// Boxes of the sectors.
    pub sectors: bool,
    /// Outlines of the portals.
    pub portals: bool,
    /// Clip regions of the passages.
    pub apertures: bool,
    /// Occluders of the look.
    pub occluders: bool,
    /// Boxes of the visible items.
    pub boxes: bool,
}

impl Overlays {
    /// Nothing.
    pub const NONE: Overlays = Overlays {
        frustum: false,
        sectors: false,
        portals: false,
        apertures: false,
        occluders: false,
        boxes: false,
    };

    /// Returns all, with their names.
    pub fn all(&mut self) -> [(&'static str, &mut bool); 6] {
        [
            ("frustum", &mut self.frustum),
            ("portals", &mut self.portals),
            ("apertures", &mut self.apertures),
            ("sectors", &mut self.sectors),
            ("occluders", &mut self.occluders),
            ("boxes", &mut self.boxes),
        ]
    }
}

impl Default for Overlays {
    fn default() -> Overlays {
        Overlays {
            frustum: true,
            portals: true,
            apertures: true,
            ..Overlays::NONE
        }
    }
}

const VISIBLE: Color32 = Color32::from_rgb(90, 220, 120);
const FOLLOWED: Color32 = Color32::from_rgb(255, 205, 60);
const CLOSED: Color32 = Color32::from_rgb(235, 80, 70);
const FAINT: Color32 = Color32::from_rgba_premultiplied(70, 80, 95, 110);
const OCCLUDER: Color32 = Color32::from_rgb(255, 120, 30);
const SELECTED: Color32 = Color32::from_rgb(255, 255, 255);

/// Draws lines of a space on a picture.
struct Pen<'a> {
    painter: &'a Painter,
    rect: Rect,
    clip_from_root: DMat4,
    near: f64,
}

impl Pen<'_> {
    fn line(&self, a: DVec3, b: DVec3, stroke: Stroke) {
        let [a, b] = [a, b].map(|at| self.clip_from_root * at.extend(1.0));
        let clipped = |a: DVec4, b: DVec4| match a.w < self.near {
            true => a.lerp(b, (self.near - a.w) / (b.w - a.w)),
            false => a,
        };
        let (a, b) = (clipped(a, b), clipped(b, a));
        if a.is_finite() && b.is_finite() && a.w > 0.0 && b.w > 0.0 {
            let line = [self.pixel(a), self.pixel(b)];
            // Lines far beyond the edges are a burden for the tessellator.
            let is_near = |at: &Pos2| at.x.abs() < 1e5 && at.y.abs() < 1e5;
            if line.iter().all(is_near) {
                self.painter.line_segment(line, stroke);
            }
        }
    }

    fn pixel(&self, at: DVec4) -> Pos2 {
        let part = vec2((0.5 + 0.5 * at.x / at.w) as f32, (0.5 - 0.5 * at.y / at.w) as f32);
        self.rect.min + part * self.rect.size()
    }

    fn polygon(&self, corners: &[DVec3], stroke: Stroke) {
        for (number, &corner) in corners.iter().enumerate() {
            self.line(corner, corners[(number + 1) % corners.len()], stroke);
        }
    }

    /// Fills a convex polygon.
    fn fill(&self, corners: &[DVec3], color: Color32) {
        let clip = corners.iter().map(|&at| self.clip_from_root * at.extend(1.0));
        let clip: Vec<DVec4> = clip.collect();
        let mut kept: Vec<Pos2> = Vec::new();
        for (number, &a) in clip.iter().enumerate() {
            let b = clip[(number + 1) % clip.len()];
            if a.w >= self.near {
                kept.push(self.pixel(a));
            }
            if (a.w < self.near) != (b.w < self.near) {
                kept.push(self.pixel(a.lerp(b, (self.near - a.w) / (b.w - a.w))));
            }
        }
        if kept.len() > 2 && kept.iter().all(|at| at.x.abs() < 1e5 && at.y.abs() < 1e5) {
            let shape = Shape::convex_polygon(kept, color, Stroke::NONE);
            self.painter.add(shape);
        }
    }

    fn bounds(&self, bounds: &Aabb, root_from_here: &Transform, stroke: Stroke) {
        if bounds.is_empty() {
            return;
        }
        let corners = bounds.corners().map(|corner| point(root_from_here, corner));
        for (number, &corner) in corners.iter().enumerate() {
            for axis in [1, 2, 4] {
                if number & axis == 0 {
                    self.line(corner, corners[number | axis], stroke);
                }
            }
        }
    }

    fn label(&self, at: DVec3, text: &str, color: Color32) {
        let clip = self.clip_from_root * at.extend(1.0);
        if clip.w > self.near {
            let at = self.pixel(clip);
            let font = FontId::proportional(12.0);
            self.painter.text(
                at + vec2(1.0, 1.0),
                Align2::CENTER_CENTER,
                text,
                font.clone(),
                Color32::BLACK,
            );
            self.painter.text(at, Align2::CENTER_CENTER, text, font, color);
        }
    }
}

/// Draws the lines of a session over its picture, which fills `rect` and shows `view`.
pub(crate) fn draw(
    painter: &Painter,
    rect: Rect,
    session: &Session,
    view: &View,
    overlays: Overlays,
    occluders: &[Occluder],
) {
    let painter = painter.with_clip_rect(rect);
    let clip = DMat4::from_cols_array_2d(&view.clip_from_eye());
    let pen = Pen {
        painter: &painter,
        rect,
        clip_from_root: clip * matrix(&view.eye_from_sector()),
        near: 1e-3 * session.world.metre,
    };
    for occluder in occluders {
        draw_occluder(&pen, occluder, session);
    }
    if session.frozen.is_some() {
        draw_frozen(&pen, session, overlays);
    } else if overlays.apertures {
        for passage in session.viewer.visible().passages().iter().skip(1) {
            let [width, height] = passage.size.map(|side| side as f32);
            let corner =
                |[x, y]: [f64; 2]| rect.min + vec2(x as f32 / width, y as f32 / height) * rect.size();
            let corners: Vec<Pos2> = passage.aperture.outline().iter().copied().map(corner).collect();
            let stroke = Stroke::new(1.0, aperture_color(session, passage));
            for (number, &at) in corners.iter().enumerate() {
                painter.line_segment([at, corners[(number + 1) % corners.len()]], stroke);
            }
        }
    }
    if let Some(selected) = &session.selected {
        let scene = &session.world.scene;
        let bounds = match scene.geometry(selected.sector) {
            Some(geometry) => geometry.item(selected.item).bounds,
            None => scene.sector(selected.sector).item_bounds(selected.item),
        };
        pen.bounds(&bounds, &selected.root_from_sector, Stroke::new(1.5, SELECTED));
    }
}

/// Returns the colour of an aperture: that of the selected item where it leads to the item's sector.
fn aperture_color(session: &Session, passage: &Passage) -> Color32 {
    match &session.selected {
        Some(selected) if selected.sector == passage.sector => SELECTED,
        _ => FOLLOWED,
    }
}

fn draw_occluder(pen: &Pen, occluder: &Occluder, session: &Session) {
    // Not beyond the edges of what the passage shows.
    let passage = session
        .viewer
        .visible()
        .passages()
        .get(occluder.passage.0 as usize);
    let painter = match passage.filter(|_| session.frozen.is_none()) {
        Some(passage) => {
            let scale = pen.rect.size() / vec2(passage.size[0] as f32, passage.size[1] as f32);
            let shown = passage.aperture.rect();
            let [x0, y0, x1, y1] = [shown.x0, shown.y0, shown.x1, shown.y1].map(f32::from);
            let corner = |x, y| pen.rect.min + vec2(x, y) * scale;
            pen.painter
                .with_clip_rect(Rect::from_min_max(corner(x0, y0), corner(x1, y1)))
        }
        None => pen.painter.clone(),
    };
    let pen = Pen {
        painter: &painter,
        ..*pen
    };
    let stroke = Stroke::new(0.6, OCCLUDER.gamma_multiply(0.7));
    match &occluder.outline {
        Outline::Polygon(corners) => {
            let corners = corners
                .iter()
                .map(|&corner| point(&occluder.root_from_sector, corner));
            let corners: Vec<DVec3> = corners.collect();
            pen.fill(&corners, OCCLUDER.gamma_multiply(0.08));
            pen.polygon(&corners, stroke);
        }
        Outline::Box(bounds) => pen.bounds(bounds, &occluder.root_from_sector, stroke),
    }
}

fn draw_frozen(pen: &Pen, session: &Session, overlays: Overlays) {
    let (scene, set) = (&session.world.scene, session.viewer.visible());
    let Some(frozen) = &session.frozen else { return };
    let eye = DVec3::from(session.view.eye());
    if overlays.sectors {
        for place in &frozen.places {
            let color = if place.passage.is_some() { VISIBLE } else { FAINT };
            let bounds = scene.bounds(place.sector);
            pen.bounds(&bounds, &place.root_from_sector, Stroke::new(1.0, color));
            if scene.sector_count() > 1 && !bounds.is_empty() {
                let middle = point(&place.root_from_sector, bounds.center());
                pen.label(middle, scene.sector_name(place.sector), color);
            }
        }
    }
    if overlays.portals {
        for portal in scene.portals() {
            let Some(place) = frozen
                .places
                .iter()
                .rev()
                .find(|place| place.sector == portal.from)
            else {
                continue;
            };
            let color = if portal.open { FAINT } else { CLOSED };
            let outline = &scene.sector(portal.from).openings()[usize::from(portal.opening.0)].outline;
            let corners = outline
                .corners()
                .iter()
                .map(|&corner| point(&place.root_from_sector, corner));
            pen.polygon(&corners.collect::<Vec<_>>(), Stroke::new(1.0, color));
        }
    }
    if overlays.apertures {
        for (id, passage) in (0..).map(PassageId).zip(set.passages()) {
            let (Some(plane), Some(_)) = (passage.entry_plane(), passage.parent) else {
                continue;
            };
            let Some(place) = frozen.places.iter().find(|place| place.passage == Some(id)) else {
                continue;
            };
            let plane = DVec4::from(plane);
            let corner = |at: [f64; 2]| {
                let [origin, direction] = passage.ray(at).map(DVec3::from);
                let away = -plane.dot(origin.extend(1.0)) / plane.truncate().dot(direction);
                let there = (origin + direction * away).as_vec3();
                point(&place.root_from_sector, there.into())
            };
            let corners: Vec<DVec3> = passage.aperture.outline().iter().copied().map(corner).collect();
            let color = aperture_color(session, passage);
            pen.polygon(&corners, Stroke::new(2.0, color));
            for &corner in &corners {
                pen.line(eye, corner, Stroke::new(0.5, color.gamma_multiply(0.35)));
            }
        }
    }
    if overlays.boxes {
        for item in frozen.items.iter().filter(|item| item.visible.is_some()) {
            if let Some(geometry) = scene.geometry(item.sector) {
                let bounds = geometry.item(item.item).bounds;
                pen.bounds(&bounds, &item.root_from_sector, Stroke::new(0.7, VISIBLE));
            }
        }
    }
    if overlays.frustum {
        let size = session.view.size().map(f64::from);
        let farthest = frozen
            .places
            .iter()
            .map(|place| f64::from(scene.bounds(place.sector).longest_side()))
            .fold(session.world.metre, f64::max);
        let corners = [[0.0, 0.0], [size[0], 0.0], size, [0.0, size[1]]];
        let rays = corners.map(|at| DVec3::from(session.view.ray(at)[1]).normalize_or_zero() * farthest);
        let stroke = Stroke::new(1.5, Color32::from_rgb(120, 190, 255));
        for ray in rays {
            pen.line(eye, eye + ray, stroke);
        }
        pen.polygon(&rays.map(|ray| eye + 0.02 * ray), stroke);
        pen.label(eye, "camera", Color32::from_rgb(150, 210, 255));
    }
}

fn point(root_from_here: &Transform, at: [f32; 3]) -> DVec3 {
    DVec3::from(root_from_here.point(at).map(f64::from))
}

fn matrix(transform: &Transform) -> DMat4 {
    let [x, y, z, moved] = transform.columns_f64().map(DVec3::from);
    DMat4::from_cols(x.extend(0.0), y.extend(0.0), z.extend(0.0), moved.extend(1.0))
}
