//! A floor plan: sectors from above, the eye, and what it sees.

use crate::places::{SectorPlacement, places};
use crate::session::Session;
use eframe::egui::{Color32, Pos2, Rect, Sense, Shape, Stroke, StrokeKind, Ui, vec2};
use enfilade::{Aabb, Transform};
use glam::DVec3;

/// The two horizontal axes for a direction up.
fn axes(up: DVec3) -> [usize; 2] {
    let up = up.abs();
    match () {
        () if up.y >= up.x && up.y >= up.z => [0, 2],
        () if up.z >= up.x => [0, 1],
        () => [1, 2],
    }
}

/// Shows the plan, as wide as the interface allows.
pub(crate) fn show(ui: &mut Ui, session: &Session) {
    let scene = &session.world.scene;
    let own: Vec<SectorPlacement>;
    let places = match &session.frozen {
        Some(frozen) => &frozen.places,
        None => {
            own = places(scene, &session.viewer, &session.view);
            &own
        }
    };
    let axes = axes(DVec3::from(session.view.up()));
    let flat = |root_from_here: &Transform, bounds: &Aabb| {
        let corners = bounds.corners().map(|corner| {
            let at = root_from_here.point(corner);
            vec2(at[axes[0]], at[axes[1]])
        });
        let min = corners.iter().fold(corners[0], |a, b| a.min(*b));
        let max = corners.iter().fold(corners[0], |a, b| a.max(*b));
        [min, max]
    };
    let known = places
        .iter()
        .filter(|place| !scene.bounds(place.sector).is_empty());
    // Rooms behind mirrors would double the plan.
    let boxes: Vec<_> = known
        .filter(|place| !place.root_from_sector.mirrors())
        .map(|place| (place, flat(&place.root_from_sector, &scene.bounds(place.sector))))
        .collect();
    let Some((_, first)) = boxes.first() else { return };
    let [min, max] = boxes.iter().fold(*first, |[min, max], (_, [low, high])| {
        [min.min(*low), max.max(*high)]
    });
    let width = ui.available_width();
    let extent = (max - min).max(vec2(1e-6, 1e-6));
    let scale = ((width - 8.0) / extent.x).min(300.0 / extent.y);
    let (rect, _) = ui.allocate_exact_size(vec2(width, extent.y * scale + 8.0), Sense::hover());
    let painter = ui.painter_at(rect);
    painter.rect_filled(rect, 3.0, Color32::from_rgb(18, 20, 26));
    let start = rect.center() - 0.5 * extent * scale;
    let at = |point: eframe::egui::Vec2| -> Pos2 { start + (point - min) * scale };
    for visible in [false, true] {
        for (_, [low, high]) in boxes
            .iter()
            .filter(|(place, _)| place.passage.is_some() == visible)
        {
            let rect = Rect::from_min_max(at(*low), at(*high));
            if visible {
                painter.rect_filled(rect, 0.0, Color32::from_rgba_unmultiplied(80, 200, 110, 26));
            }
            let color = if visible {
                Color32::from_rgb(90, 200, 120)
            } else {
                Color32::from_gray(70)
            };
            painter.rect_stroke(rect, 0.0, Stroke::new(1.0, color), StrokeKind::Middle);
        }
    }
    let set = session.viewer.visible();
    for item in set.items().iter().take(4000) {
        let place = &places[item.passage.0 as usize];
        let Some(geometry) = scene.geometry(place.sector) else {
            continue;
        };
        if place.root_from_sector.mirrors() {
            continue;
        }
        let bounds = geometry.item(item.item.index).bounds;
        let [low, high] = flat(&place.root_from_sector, &bounds);
        let rect = Rect::from_min_max(at(low), at(high));
        painter.rect_stroke(
            rect,
            0.0,
            Stroke::new(0.5, Color32::from_rgba_unmultiplied(150, 230, 170, 70)),
            StrokeKind::Middle,
        );
    }
    let flat_point = |point: DVec3| {
        let point = point.to_array();
        at(vec2(point[axes[0]] as f32, point[axes[1]] as f32))
    };
    let eye = DVec3::from(session.view.eye());
    let size = session.view.size().map(f64::from);
    let reach = f64::from(extent.length());
    let fan = [0.0, size[0]].map(|x| {
        let [origin, direction] = session.view.ray([x, 0.5 * size[1]]).map(DVec3::from);
        flat_point(origin + direction.normalize_or_zero() * reach)
    });
    let blue = Color32::from_rgb(120, 190, 255);
    painter.add(Shape::convex_polygon(
        vec![flat_point(eye), fan[0], fan[1]],
        Color32::from_rgba_unmultiplied(120, 190, 255, 16),
        Stroke::new(1.0, blue.gamma_multiply(0.6)),
    ));
    painter.circle_filled(flat_point(eye), 3.5, blue);
    if session.frozen.is_some() {
        let flying = session.walker.camera(scene).eye;
        painter.circle_stroke(flat_point(flying.into()), 3.5, Stroke::new(1.5, Color32::WHITE));
    }
}
