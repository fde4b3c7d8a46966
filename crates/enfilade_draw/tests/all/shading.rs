//! Shading of faces: vertex normals, spots, suns, and unlit materials.

use crate::stage::{SIZE, parallel_view, ray, view};
use enfilade::{
    Attributes, GeometryBuilder, Indices, Light, LightShape, Material, MaterialId, Mesh, Method, Part, Scene,
    SceneBuilder, Transform, Vertices, View, Viewer,
};
use enfilade_draw::{Exposure, Settings, Stage};
use glam::DVec3;

/// Creates a wall across the view at z = −3 with these vertex normals.
fn wall(normals: &[[f32; 3]], material: Material, lights: &[Light]) -> Scene {
    let mut geometry = GeometryBuilder::new([material]);
    let mesh = Mesh::new(&[Part {
        positions: Vertices::Packed(&[
            [-6.0, -4.0, -3.0],
            [6.0, -4.0, -3.0],
            [6.0, 4.0, -3.0],
            [-6.0, 4.0, -3.0],
        ]),
        corners: Indices::U32(&[0, 1, 2, 3]),
        sides: Some(&[4]),
        material: MaterialId(0),
        attributes: Attributes {
            normals: Vertices::Packed(normals),
            ..Attributes::default()
        },
    }]);
    let mesh = geometry.mesh(mesh.expect("a wall"));
    geometry.item("wall", mesh, Transform::IDENTITY);
    let mut scene = SceneBuilder::new();
    scene.add("yard", geometry.build().expect("a yard"), Method::ZBuffer);
    for &light in lights {
        scene.light(light);
    }
    scene.build().expect("a yard")
}

fn drawn(scene: &Scene, view: &View) -> enfilade_draw::RgbImage {
    Stage::new(scene)
        .draw(&mut Viewer::new(), scene, view, &Settings::default())
        .image
}

fn linear(byte: u8) -> f64 {
    let srgb = f64::from(byte) / 255.0;
    if srgb <= 0.040_45 {
        srgb / 12.92
    } else {
        ((srgb + 0.055) / 1.055).powf(2.4)
    }
}

/// Returns the point where the ray through a pixel's centre meets the wall.
fn met(view: &View, x: u32, y: u32) -> DVec3 {
    let [origin, way] = ray(view, [f64::from(x) + 0.5, f64::from(y) + 0.5]);
    origin + way * ((-3.0 - origin.z) / way.z)
}

/// Asserts that a light adds the expected light to the picture.
fn holds(
    light: Light,
    normals: &[[f32; 3]],
    normal: impl Fn(DVec3) -> DVec3,
    strength: impl Fn(DVec3) -> (DVec3, f64),
) {
    let white = Material::opaque([1.0; 3]);
    let mut off = light;
    off.color = [0.0; 3];
    for view in [view(), parallel_view()] {
        let [lit, unlit] = [light, off].map(|light| drawn(&wall(normals, white, &[light]), &view));
        let mut lit_pixels = 0;
        for y in 0..SIZE[1] {
            for x in 0..SIZE[0] {
                let point = met(&view, x, y);
                let (to_light, part) = strength(point);
                let added = part * normal(point).dot(to_light).max(0.0) * f64::from(light.color[0]);
                let [shown, before] = [&lit, &unlit].map(|image| linear(image.get_pixel(x, y).0[0]));
                let expected = (before + added).min(1.0);
                // One step of an sRGB byte at that brightness.
                assert!(
                    (shown - expected).abs() < 0.012,
                    "({x}, {y}): {shown}, {expected}"
                );
                lit_pixels += usize::from(added > 0.05);
            }
        }
        assert!(lit_pixels > 500, "{lit_pixels}");
    }
}

const FLAT: [[f32; 3]; 0] = [];
const YARD: enfilade::SectorId = enfilade::SectorId(0);

#[test]
fn a_spot_shines_in_its_cone_and_fades_to_its_edge() {
    let at = DVec3::new(0.5, 0.4, 0.0);
    let direction = [0.1, -0.05, -1.0];
    let (inner, outer) = (0.25, 0.45);
    let mut spot = Light::point(YARD, at.as_vec3().into(), [6.0; 3], 20.0);
    spot.shape = LightShape::Spot {
        direction,
        inner,
        outer,
    };
    holds(
        spot,
        &FLAT,
        |_| DVec3::Z,
        |point| {
            let way = point - at;
            let middle = DVec3::from(direction.map(f64::from)).normalize();
            let cosine = middle.dot(way.normalize());
            let [full, none] = [inner, outer].map(|angle| f64::from(angle).cos());
            let part = ((cosine - none) / (full - none)).clamp(0.0, 1.0).powi(2);
            let distance = way.length();
            let window = 1.0 - (distance / 20.0).powi(4);
            (-way.normalize(), part * window / (distance * distance))
        },
    );
}

#[test]
fn a_sun_shines_alike_everywhere_and_the_normals_of_corners_bend_its_light() {
    let toward = DVec3::new(0.3, 0.5, 0.8).normalize();
    let mut sun = Light::point(YARD, [0.0; 3], [0.5; 3], f32::INFINITY);
    sun.shape = LightShape::Sun {
        direction: (-toward).as_vec3().into(),
    };
    holds(sun, &FLAT, |_| DVec3::Z, |_| (toward, 1.0));
    // The normals of the left and right edges lean outwards and are interpolated in between.
    let [left, right] = [[-0.6, 0.0, 0.8], [0.6, 0.0, 0.8]];
    let bent = [left, right, right, left];
    let normal = |point: DVec3| DVec3::new(0.6 * point.x / 6.0, 0.0, 0.8).normalize();
    holds(sun, &bent, normal, |_| (toward, 1.0));
}

#[test]
fn what_is_unlit_has_its_colour_in_any_light_and_what_glows_has_it_in_the_dark() {
    let lamp = Light::point(YARD, [0.0, 0.0, -2.0], [50.0; 3], 20.0);
    let unlit = Material {
        unlit: true,
        ..Material::opaque([0.25, 0.5, 0.75])
    };
    for lights in [&[][..], &[lamp]] {
        let image = drawn(&wall(&FLAT, unlit, lights), &view());
        let [r, g, b] = image.get_pixel(60, 40).0.map(linear);
        assert!((r - 0.25).abs() < 0.004 && (g - 0.5).abs() < 0.004 && (b - 0.75).abs() < 0.004);
    }
    let glowing = Material {
        emission: [0.0, 0.6, 0.0],
        ..Material::opaque([0.0; 3])
    };
    let [r, g, _] = drawn(&wall(&FLAT, glowing, &[]), &view())
        .get_pixel(60, 40)
        .0
        .map(linear);
    assert!(r == 0.0 && (g - 0.6).abs() < 0.005, "{g}");
}

#[test]
fn an_eye_gets_used_to_lamps_however_bright_the_file_says_they_are() {
    let shown = |unit: f32, stops: f32| {
        let lamp = Light::point(YARD, [0.0, 0.0, 0.0], [unit; 3], f32::INFINITY);
        let scene = wall(&FLAT, Material::opaque([0.5; 3]), &[lamp]);
        let mut settings = Settings::default();
        settings.exposure = Exposure::Eye(stops);
        let picture = Stage::new(&scene).draw(&mut Viewer::new(), &scene, &view(), &settings);
        let sum: u64 = picture.image.iter().map(|&byte| u64::from(byte)).sum();
        sum / picture.image.len() as u64
    };
    let [dim, bright] = [1.0, 5000.0].map(|unit| shown(unit, 0.0));
    assert!(dim.abs_diff(bright) <= 1, "{dim} and {bright}");
    assert!((60..220).contains(&dim), "neither black nor white: {dim}");
    assert!(shown(1.0, 1.0) > dim && shown(1.0, -2.0) < dim);
}
