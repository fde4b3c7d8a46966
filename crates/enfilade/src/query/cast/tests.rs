//! Rays against the same arithmetic for every face, without boxes of faces.

use super::*;
use crate::chance::Dice;
use crate::geom::Transform;
use crate::geometry::GeometryBuilder;
use crate::mesh::soup;

/// Returns all hits up to a limit: items and clusters by their boxes, then every face.
fn hits_of_all(geometry: &Geometry, line: &Line, limit: f64) -> Vec<Hit> {
    let mut hits = Vec::new();
    for item in (0..geometry.items().len() as u32).map(ItemIndex) {
        let placed = geometry.item(item);
        let is_near = line
            .meets(&placed.bounds, line.margin(&placed.bounds), limit)
            .is_some();
        let Some(item_from_sector) = placed.transform().inverse().filter(|_| is_near) else {
            continue;
        };
        let line = line.moved(&item_from_sector.0);
        let mesh = geometry.mesh_of(item);
        for cluster in mesh.clusters() {
            let Some([enter, leave]) = line.meets(&cluster.bounds, 0.0, limit) else {
                continue;
            };
            for face in cluster.faces.clone() {
                let Some((distance, from_behind)) = meet_face(mesh, face, &line) else {
                    continue;
                };
                let distance = distance.max(enter).min(leave.max(f64::MIN_POSITIVE));
                hits.extend((distance <= limit).then_some(Hit {
                    item: geometry.id_of(item),
                    key: geometry.key(item),
                    face,
                    distance,
                    from_behind,
                }));
            }
        }
    }
    hits.sort_unstable_by(|a, b| a.distance.total_cmp(&b.distance).then(a.rank().cmp(&b.rank())));
    hits
}

/// Instances of slivers, coplanar and duplicate faces, huge and tiny, each at about the same size.
fn heap(dice: &mut Dice) -> Geometry {
    let mut builder = GeometryBuilder::new([Material::opaque([1.0; 3])]);
    for _ in 0..6 {
        let scale = dice.by_ratio(1e-6, 1e6);
        let mesh = builder.mesh(soup(dice, scale));
        for turned in [false, true] {
            let turn = Transform::rotation(dice.direction().as_vec3().into(), f64::from(turned));
            let shrink = Transform::scaling([(1.0 / scale) as f32; 3]);
            builder.item(
                "",
                mesh,
                Transform::translation(dice.point(2.0).as_vec3().into()) * turn * shrink,
            );
        }
    }
    builder.build().expect("sound meshes")
}

#[test]
fn a_ray_meets_what_it_meets_among_all_faces() {
    let mut dice = Dice::new(7);
    let mut met = 0;
    for _ in 0..40 {
        let geometry = heap(&mut dice);
        let corner = |dice: &mut Dice| {
            let item = ItemIndex(dice.below(geometry.items().len()) as u32);
            let positions = geometry.mesh_of(item).positions();
            geometry
                .item(item)
                .transform()
                .point(positions[dice.below(positions.len())])
        };
        for question in 0..200 {
            let mut origin = dice.point(3.0);
            let mut direction = dice.direction() * dice.by_ratio(1e-20, 1e20);
            match question % 6 {
                0 => direction[dice.below(3)] = 0.0,
                1 => direction = DVec3::AXES[dice.below(3)],
                // Through a corner, from afar; from corner to corner.
                2 => {
                    origin *= dice.by_ratio(1.0, 1e6);
                    direction = DVec3::from(corner(&mut dice).map(f64::from)) - origin;
                }
                3 => {
                    origin = DVec3::from(corner(&mut dice).map(f64::from));
                    direction = DVec3::from(corner(&mut dice).map(f64::from)) - origin;
                }
                _ => {}
            }
            let ray = Ray {
                origin: origin.as_vec3().into(),
                direction: direction.as_vec3().into(),
            };
            let Some(line) = line_of(&ray) else { continue };
            let limit = match question % 4 {
                0 => dice.roll() * 4.0 / direction.length(),
                _ => f64::INFINITY,
            };
            let expected = hits_of_all(&geometry, &line, limit);
            let mut hits = Vec::new();
            geometry.cast_all(&ray, limit, &mut hits);
            assert_eq!(hits, expected, "{ray:?} up to {limit}");
            assert_eq!(
                geometry.first_along(&line, limit, |_| true),
                expected.first().copied()
            );
            met += usize::from(!expected.is_empty());
        }
    }
    assert!(met > 2000, "only {met} rays met anything");
}
