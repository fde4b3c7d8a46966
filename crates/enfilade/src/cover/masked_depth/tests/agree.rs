//! Occluders cover the same samples that the exact covers assign to the same faces.

use super::*;
use crate::cover::{DepthBuffer, Paints};
use crate::faces::Faces;
use crate::geom::Transform;
use crate::geometry::{Geometry, GeometryBuilder, Material};
use crate::ids::{ItemIndex, MaterialId};
use crate::mesh::{Attributes, Mesh, Part};
use crate::raster::{Band, Raster, Sink, Triangle};
use crate::view::collector::Collector;
use std::collections::BTreeSet;

/// The samples of a face according to the rasterizer.
struct SampleMask(Vec<bool>, usize);

impl Sink for SampleMask {
    fn hides(&mut self, _rect: &Rect, _nearest: f32) -> bool {
        false
    }

    fn band(&mut self, band: &Band, _triangle: &Triangle) {
        for (y, [x0, x1]) in band.rows() {
            self.0[usize::from(y) * self.1..][usize::from(x0)..usize::from(x1)].fill(true);
        }
    }
}

/// Rasterizes a face with both. Returns the samples that only the rasterizer covers, and asserts that the buffer covers
/// no others.
fn lost(corners: &[[f32; 3]], passage: &Passage) -> (Vec<bool>, Polygon, usize) {
    let mut builder = GeometryBuilder::new([Material {
        double_sided: true,
        ..Material::opaque([1.0; 3])
    }]);
    let order: Vec<u32> = (0..corners.len() as u32).collect();
    let part = Part {
        positions: corners,
        corners: &order,
        sides: Some(&[corners.len() as u32]),
        material: MaterialId(0),
        attributes: Attributes::default(),
    };
    let mesh = builder.mesh(Mesh::new(&[part]).expect("flat and convex"));
    builder.item("face", mesh, Transform::IDENTITY);
    let geometry = builder.build().expect("one sound face");
    let [width, height] = passage.size.map(|side| side as usize);
    let mut held = SampleMask(vec![false; width * height], width);
    let faces = Faces::of_cluster(&geometry, ItemIndex(0), 0, &passage.screen_from_sector);
    Raster::default().run(&faces, passage, &mut held, &mut Stats::default());
    let corners: Vec<DVec3> = corners
        .iter()
        .map(|&corner| DVec3::from(corner.map(f64::from)))
        .collect();
    let polygon = Polygon::new(&corners, passage);
    let mut cover = MaskedDepth::default();
    Hides::clear(&mut cover, passage);
    cover.hide(&polygon.occluder(), passage, &mut Stats::default());
    let mut covered = 0;
    let mut lost = vec![false; width * height];
    for (x, y) in samples(cover.grid.rect) {
        let at = usize::from(y) * width + usize::from(x);
        let known = cover.known(x, y) > 0.0;
        assert!(held.0[at] || !known, "{x}, {y} is not of {corners:?}");
        covered += usize::from(known);
        lost[at] = held.0[at] && !known;
    }
    (lost, polygon, covered)
}

/// Returns `true` if the polygon's plane at a sample is clearly behind the near plane.
fn plainly_there(polygon: &Polygon, passage: &Passage, at: usize) -> bool {
    let [x, y] = [at % passage.size[0] as usize, at / passage.size[0] as usize];
    let ray = DVec3::new(x as f64 + 0.5, y as f64 + 0.5, 1.0);
    polygon.plane.0.dot(ray) / polygon.plane.1 * f64::from(passage.near) * 4.02 < 1.0
}

#[test]
fn a_triangle_covers_the_samples_that_it_owns() {
    let [mut dice, mut total] = [(); 2].map(|()| Dice::new(5));
    let mut covered = 0;
    for round in 0..6000 {
        let mut passage = passage([[77, 43], [64, 64]][round % 2]);
        passage.near = [0.01, 0.5][round / 2 % 2];
        let distance = dice.by_ratio(0.02, 100.0);
        let reach = distance * dice.by_ratio(0.003, 100.0);
        let center = DVec3::new(dice.between(-1.0, 1.0), dice.between(-0.6, 0.6), -1.0) * distance;
        let mut corners = [(); 3].map(|()| center + dice.direction() * dice.roll() * reach);
        if total.roll() < 0.2 {
            // A sliver.
            corners[2] = corners[0] + (corners[1] - corners[0]) * dice.between(-0.5, 1.5);
        }
        let corners = corners.map(|corner| corner.as_vec3().to_array());
        let (lost, polygon, now) = lost(&corners, &passage);
        covered += now;
        for at in (0..lost.len()).filter(|&at| lost[at]) {
            assert!(
                !plainly_there(&polygon, &passage, at),
                "{at} of {corners:?} in {round}"
            );
        }
    }
    assert!(covered > 100_000, "{covered}");
}

#[test]
fn a_polygon_of_many_corners_covers_the_samples_that_it_owns() {
    let mut dice = Dice::new(6);
    let mut covered = 0;
    for round in 0..2000 {
        let mut view = View::new([0.0; 3], [0.0, 0.0, -1.0], [80, 50]);
        view.toward = (DVec3::NEG_Z + 0.8 * dice.direction()).as_vec3().to_array();
        let passage = Passage::at_the_eye(&view, SectorId(0), false);
        let count = 3 + round % 8;
        let distance = -dice.by_ratio(0.05, 20.0) as f32;
        let radius = -f64::from(distance) * dice.by_ratio(0.02, 20.0);
        let [x, y] = [(); 2].map(|()| dice.between(-0.6, 0.6) * radius);
        let corners: Vec<[f32; 3]> = (0..count)
            .map(|i| {
                let angle = i as f64 / count as f64 * std::f64::consts::TAU;
                [x + radius * angle.cos(), y + radius * angle.sin()].map(|value| value as f32)
            })
            .map(|[x, y]| [x, y, distance])
            .collect();
        let (lost, polygon, now) = lost(&corners, &passage);
        covered += now;
        for at in (0..lost.len()).filter(|&at| lost[at]) {
            assert!(
                !plainly_there(&polygon, &passage, at),
                "{at} of {corners:?} in {round}"
            );
        }
    }
    assert!(covered > 100_000, "{covered}");
}

/// Triangles around the eye, each in an item; some share corners and planes.
fn triangles(dice: &mut Dice, count: usize) -> Geometry {
    let mut builder = GeometryBuilder::new([Material {
        double_sided: true,
        ..Material::opaque([1.0; 3])
    }]);
    let mut last = [[0.0; 3]; 3];
    for i in 0..count {
        let center =
            DVec3::new(dice.between(-1.0, 1.0), dice.between(-0.6, 0.6), -1.0) * dice.by_ratio(0.5, 20.0);
        let reach = dice.by_ratio(0.1, 10.0);
        let mut corners = [(); 3].map(|()| (center + dice.direction() * reach).as_vec3().to_array());
        // An edge neighbour or a duplicate: both have the same depth where they meet.
        corners[..i % 4].copy_from_slice(&last[..i % 4]);
        last = corners;
        if let Ok(mesh) = Mesh::triangles(&corners, &[0, 1, 2], MaterialId(0)) {
            let mesh = builder.mesh(mesh);
            builder.item("face", mesh, Transform::IDENTITY);
        }
    }
    builder.build().expect("sound faces")
}

#[test]
fn whatever_a_depth_buffer_shows_is_seen_past_the_faces_that_it_took() {
    let [mut shown, mut hidden] = [0, 0];
    for seed in 0..300 {
        let mut dice = Dice::new(seed);
        let geometry = triangles(&mut dice, 40);
        let passage = passage([[77, 43], [200, 120]][seed as usize % 2]);
        let items = (0..geometry.items().len() as u32).map(ItemIndex);
        let faces = |item| Faces::of_cluster(&geometry, item, 0, &passage.screen_from_sector);
        let (mut stats, mut seen) = (Stats::default(), Collector::default());
        let mut exact = DepthBuffer::default();
        Paints::clear(&mut exact, &passage, false);
        let mut cover = MaskedDepth::default();
        Hides::clear(&mut cover, &passage);
        for item in items.clone() {
            exact.add(&faces(item), &passage, &mut stats, None);
            cover.hide_batch(&faces(item), &passage, &mut stats);
        }
        exact.finish(&geometry, &passage, &mut seen, None);
        let owners: BTreeSet<ItemIndex> = seen.items.iter().map(|item| item.item).collect();
        for item in items {
            let bounds = geometry.mesh_of(item).bounds();
            let region = Region::of(&passage, &passage.screen_from_sector, &bounds);
            if region.is_none_or(|region| cover.test(&region) == Visibility::Hidden) {
                assert!(!owners.contains(&item), "{item:?} of scene {seed}");
                hidden += 1;
            }
        }
        shown += owners.len();
    }
    assert!(
        shown > 1000 && hidden > 1000,
        "{shown} are shown, {hidden} hidden"
    );
}
