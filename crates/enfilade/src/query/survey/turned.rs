//! Surveys with another up vector than +y, or with a known unit.
//!
//! Idea: survey a copy of the scene that is turned until its up vector is +y, and turn the views back. The copy shares the
//!     meshes; for an axis of the scene it is exact.
//! Cost: that of [`survey`](super::survey), and O(items) for the copy.

use super::{Survey, SurveyView, Surveyor};
use crate::geom::{ConvexPolygon, Transform};
use crate::geometry::{Geometry, GeometryBuilder};
use crate::ids::{ItemIndex, PortalId, SectorId};
use crate::method::Method;
use crate::scene::{Scene, SceneBuilder};
use glam::{DAffine3, DMat3, DVec3};

/// Options of [`survey_with`].
#[derive(Clone, Copy, Debug, PartialEq)]
#[non_exhaustive]
pub struct SurveyOptions {
    /// Up vector of the scene, of any length. Default: +y, which is also taken for one that is zero or not finite.
    pub up: [f32; 3],
    /// Length of a metre in scene units, above 0 and finite. Default: `None`, which estimates it as [`survey`](super::survey)
    /// does.
    pub metre: Option<f64>,
    /// The only sector to find positions in, as [`survey_in`](super::survey_in) does. Default: `None`, for all.
    pub sector: Option<SectorId>,
}

impl Default for SurveyOptions {
    fn default() -> SurveyOptions {
        SurveyOptions {
            up: [0.0, 1.0, 0.0],
            metre: None,
            sector: None,
        }
    }
}

/// Returns positions like [`survey`](super::survey), for a scene with another up vector or a known unit.
///
/// Sectors of your own kind cannot be turned: with another up vector, no position is in one, and none looks into one.
///
/// ```
/// # use enfilade::*;
/// # let scene = Scene::single(GeometryBuilder::new([]).build()?, Method::ZBuffer)?;
/// // A building in millimetres, with z up.
/// let mut options = SurveyOptions::default();
/// (options.up, options.metre) = ([0.0, 0.0, 1.0], Some(1000.0));
/// let found = survey_with(&scene, 16, &options);
/// # assert!(found.views.is_empty());
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
pub fn survey_with(scene: &Scene, count: usize, options: &SurveyOptions) -> Survey {
    let up = DVec3::from(options.up.map(f64::from)).try_normalize();
    let Some(up) = up.filter(|&up| up != DVec3::Y) else {
        return survey_upright(scene, count, options);
    };
    let upright_from_scene = Transform(DAffine3::from_mat3(rotation_to_y(up)));
    let Some(turned) = turned(scene, upright_from_scene) else {
        return Survey::default();
    };
    let mut found = survey_upright(&turned, count, options);
    let scene_from_upright = Transform(upright_from_scene.0.inverse());
    for view in &mut found.views {
        *view = SurveyView {
            eye: scene_from_upright.point(view.eye),
            toward: scene_from_upright.point(view.toward),
            ..*view
        };
    }
    found
}

/// Seed for all sectors.
const SEED: u64 = 0x656E_6669_6C61_6465;

/// Surveys a scene with +y up.
fn survey_upright(scene: &Scene, count: usize, options: &SurveyOptions) -> Survey {
    let mut surveyor = match options.sector {
        Some(sector) => Surveyor::new(scene, std::iter::once(sector), u64::from(sector.0)),
        None => Surveyor::new(scene, scene.sectors(), SEED),
    };
    if let Some(metre) = options.metre.filter(|metre| *metre > 0.0 && metre.is_finite()) {
        surveyor.metre = metre;
        surveyor.is_metre_given = true;
    }
    surveyor.survey(count)
}

/// Returns a rotation that turns a unit vector to +y. Axes turn to axes, so z up becomes y up by a quarter turn about x.
fn rotation_to_y(up: DVec3) -> DMat3 {
    let lengths = up.abs();
    let aside = if lengths.x <= lengths.y.min(lengths.z) {
        DVec3::X
    } else if lengths.y <= lengths.z {
        DVec3::Y
    } else {
        DVec3::Z
    };
    let aside = (aside - up * aside.dot(up)).normalize();
    // The columns of the inverse are where the axes come from.
    DMat3::from_cols(aside, up, aside.cross(up)).transpose()
}

/// Returns a turned copy of a scene; `None` if an opening is too far from flat once it is turned and rounded.
fn turned(scene: &Scene, turn: Transform) -> Option<Scene> {
    let mut builder = SceneBuilder::new();
    builder.limit_bytes(u64::MAX);
    for sector in scene.sectors() {
        let geometry = match scene.geometry(sector) {
            Some(geometry) => turned_geometry(geometry, turn)?,
            None => GeometryBuilder::new([]).build().ok()?,
        };
        let id = builder.add(scene.sector_name(sector), geometry, Method::Masked);
        if scene.is_open_above(sector) {
            builder.open_above(id);
        }
    }
    let back = Transform(turn.0.inverse());
    for (portal, number) in scene.portals().iter().zip(0..) {
        if scene.has_portal(PortalId(number)) && scene.geometry(portal.from).is_some() {
            let there_from_here = turn * portal.there_from_here * back;
            builder.portal((portal.from, portal.opening), portal.to, there_from_here);
        }
    }
    builder.build().ok()
}

fn turned_geometry(geometry: &Geometry, turn: Transform) -> Option<Geometry> {
    let mut builder = GeometryBuilder::new(geometry.materials());
    builder.textures(geometry.textures());
    for mesh in geometry.meshes() {
        builder.mesh(mesh.clone());
    }
    for (item, number) in geometry.items().iter().zip(0..) {
        if geometry.holds(ItemIndex(number)) {
            let turned = builder.item("", item.mesh, turn * item.transform());
            builder.set_options(turned, item.options);
        }
    }
    for opening in geometry.openings() {
        let corners = opening.outline.corners().iter().map(|&corner| turn.point(corner));
        let outline = ConvexPolygon::new(&corners.collect::<Vec<_>>()).ok()?;
        builder.opening("", outline);
    }
    builder.build().ok()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::geometry::Material;
    use crate::ids::MaterialId;
    use crate::mesh::Mesh;

    #[test]
    fn axes_turn_to_axes_and_any_vector_to_y() {
        let turn = |up: [f64; 3]| rotation_to_y(DVec3::from(up).normalize());
        assert_eq!(
            turn([0.0, 0.0, 1.0]) * DVec3::new(1.0, 2.0, 3.0),
            DVec3::new(1.0, 3.0, -2.0)
        );
        assert_eq!(turn([1.0, 0.0, 0.0]) * DVec3::X, DVec3::Y);
        for up in [
            [0.0, 0.0, -1.0],
            [0.0, -1.0, 0.0],
            [-1.0, 0.0, 0.0],
            [1.0, 2.0, -3.0],
            [3.0, 0.1, 0.2],
        ] {
            let rotation = turn(up);
            let off = rotation * DVec3::from(up).normalize() - DVec3::Y;
            assert!(
                off.length() < 1e-12 && (rotation.determinant() - 1.0).abs() < 1e-12,
                "{up:?}"
            );
        }
    }

    /// Boxes that are a floor, two walls and a table, with y up.
    fn room() -> Scene {
        let mut builder = GeometryBuilder::new([Material::opaque([0.5; 3])]);
        for (low, high) in [
            ([-6.0, -0.2, -5.0], [6.0, 0.0, 5.0]),
            ([-6.0, 0.0, -5.2], [6.0, 3.0, -5.0]),
            ([-6.2, 0.0, -5.0], [-6.0, 3.0, 5.0]),
            ([1.0, 0.0, 1.0], [2.0, 0.8, 2.0]),
        ] {
            let mesh = Mesh::cuboid(low, high, MaterialId(0)).expect("a box");
            let mesh = builder.mesh(mesh);
            builder.item("box", mesh, Transform::IDENTITY);
        }
        Scene::single(builder.build().expect("boxes"), Method::ZBuffer).expect("a room")
    }

    #[test]
    fn a_room_with_another_up_axis_has_the_same_places() {
        let upright = room();
        let expected = super::super::survey(&upright, 6).views;
        assert_eq!(expected.len(), 6);
        for up in [[0.0, 0.0, 1.0], [1.0, 0.0, 0.0]] {
            let scene_from_upright = Transform(DAffine3::from_mat3(rotation_to_y(up.into()).transpose()));
            let lying = turned(&upright, scene_from_upright).expect("a room");
            let options = SurveyOptions {
                up: up.map(|part| part as f32),
                ..SurveyOptions::default()
            };
            let found = survey_with(&lying, 6, &options).views;
            let places = expected.iter().map(|view| scene_from_upright.point(view.eye));
            assert!(found.iter().map(|view| view.eye).eq(places), "{up:?}");
        }
    }

    #[test]
    fn eyes_are_as_high_as_the_given_metre_makes_them() {
        let with = |up, metre| SurveyOptions {
            up,
            metre,
            sector: None,
        };
        const Y: [f32; 3] = [0.0, 1.0, 0.0];
        let found = survey_with(&room(), 6, &with(Y, Some(0.5)));
        assert_eq!(found.metre, 0.5);
        assert!(
            found.views.iter().any(|view| (view.eye[1] - 0.8).abs() < 0.01),
            "{found:?}"
        );
        let expected = super::super::survey(&room(), 6).views;
        for metre in [0.0, -1.0, f64::NAN, f64::INFINITY] {
            assert_eq!(survey_with(&room(), 6, &with(Y, Some(metre))).views, expected);
        }
        assert_eq!(survey_with(&room(), 6, &with([0.0; 3], None)).views, expected);
    }
}
