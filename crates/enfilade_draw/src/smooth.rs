//! Shades smooth faces sixteen samples at a time: faces where only the normal varies, under ambient light alone.
//!
//! The results equal [`Row::at`](crate::shade::Row::at) bit for bit; the loops are written for auto-vectorization.

use crate::face::{Face, LinearRow};
use crate::light::Daylight;
use crate::pixels::{Pixel, pixel};
use crate::shade::Illumination;
use glam::Vec3;

/// Samples per iteration.
const LANES: usize = 16;

/// A smooth face along one row of samples.
pub(crate) struct SmoothRow {
    own: Vec3,
    emission: Vec3,
    normal: Vec3,
    facing: LinearRow,
    /// For each axis of the normal: constant and linear part.
    base: [f32; 3],
    over: [LinearRow; 3],
    daylight: Daylight,
    back: Vec3,
}

impl SmoothRow {
    /// Returns `None` if anything but the normal varies, or a light reaches the face, or with ambient occlusion.
    pub(crate) fn of(face: &Face, light: &Illumination, y: u16) -> Option<SmoothRow> {
        let normals = face.normals.as_ref()?;
        let only_normals = face.uv.is_none() && face.colors.is_none() && face.lights.is_empty();
        let is_opaque_and_lit = !face.glass && !face.unlit && face.cutoff.is_none();
        let is_plain = only_normals && is_opaque_and_lit && !light.tone.soft;
        (is_plain && light.ambient.is_none()).then(|| SmoothRow {
            own: Vec3::new(face.color[0], face.color[1], face.color[2]),
            emission: face.emission,
            normal: face.normal,
            facing: face.facing.row(y),
            base: [normals[0].base, normals[1].base, normals[2].base],
            over: [
                normals[0].over.row(y),
                normals[1].over.row(y),
                normals[2].over.row(y),
            ],
            daylight: *light.daylight,
            back: light.rays.back,
        })
    }

    /// Shades a run of pixels that starts at column `x0`.
    pub(crate) fn paint(&self, x0: u16, pixels: &mut [Pixel]) {
        for (x, pixels) in (x0..).step_by(LANES).zip(pixels.chunks_mut(LANES)) {
            let mut columns = [0.0; LANES];
            for (lane, column) in columns.iter_mut().enumerate() {
                *column = f32::from(x) + lane as f32;
            }
            let light = self.light(&self.normals(&columns));
            for (at, lane) in pixels.iter_mut().zip(0..LANES) {
                *at = pixel(Vec3::new(light[0][lane], light[1][lane], light[2][lane]));
            }
        }
    }

    /// Returns the unit normals at some columns, axis by axis.
    fn normals(&self, columns: &[f32; LANES]) -> [[f32; LANES]; 3] {
        let mut normals = [[0.0; LANES]; 3];
        for (lane, &column) in columns.iter().enumerate() {
            let per_facing = 1.0 / self.facing.at(column);
            let axis = |axis: usize| self.base[axis] + self.over[axis].at(column) * per_facing;
            let [x, y, z] = [axis(0), axis(1), axis(2)];
            let per_length = 1.0 / (x * x + y * y + z * z).sqrt();
            let is_sound = (per_length > 0.0) & (per_length < f32::INFINITY);
            let pick = |bent: f32, own: f32| if is_sound { bent * per_length } else { own };
            normals[0][lane] = pick(x, self.normal.x);
            normals[1][lane] = pick(y, self.normal.y);
            normals[2][lane] = pick(z, self.normal.z);
        }
        normals
    }

    /// Returns the light towards the eye for some normals, channel by channel.
    fn light(&self, [x, y, z]: &[[f32; LANES]; 3]) -> [[f32; LANES]; 3] {
        let mut light = [[0.0; LANES]; 3];
        for lane in 0..LANES {
            let normal = Vec3::new(x[lane], y[lane], z[lane]);
            let sum = self.own * self.daylight.at(normal, self.back) + self.emission;
            light[0][lane] = sum.x;
            light[1][lane] = sum.y;
            light[2][lane] = sum.z;
        }
        light
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::palette::distinct;
    use crate::shade::Row;
    use crate::stage::{Exposure, Stage};
    use enfilade::{
        Attributes, GeometryBuilder, Indices, ItemIndex, Material, MaterialId, Mesh, Method, Part,
        SceneBuilder, SectorId, Transform, Vertices, View, Viewer,
    };

    /// Returns pseudorandom numbers between −1 and 1.
    fn spread(seed: u32) -> [f32; 3] {
        distinct(u64::from(seed)).map(|value| 2.0 * value - 1.0)
    }

    #[test]
    fn a_row_of_samples_is_painted_as_one_after_the_other() {
        let mut compared = 0;
        for seed in 0..200 {
            let corners = [0, 1, 2].map(|corner| {
                let [x, y, z] = spread(10 * seed + corner);
                [3.0 * x, 3.0 * y, 2.0 * z - 4.0]
            });
            let normals = [3, 4, 5].map(|corner| {
                let normal = spread(10 * seed + corner);
                // Some corners have no normal.
                if seed % 7 == corner % 7 { [0.0; 3] } else { normal }
            });
            let mesh = Mesh::new(&[Part {
                positions: Vertices::Packed(&corners),
                corners: Indices::U32(&[0, 1, 2]),
                sides: None,
                material: MaterialId(0),
                attributes: Attributes {
                    normals: Vertices::Packed(&normals),
                    ..Attributes::default()
                },
            }]);
            let mut builder = GeometryBuilder::new([Material::opaque(spread(seed).map(f32::abs))]);
            let mesh = builder.mesh(mesh.expect("a triangle"));
            builder.item("face", mesh, Transform::IDENTITY);
            let mut scene = SceneBuilder::new();
            scene.add("all", builder.build().expect("one item"), Method::ZBuffer);
            let scene = scene.build().expect("one sector");
            let stage = Stage::new(&scene);
            let view = View::new([0.0; 3], [0.0, 0.0, -1.0], [64, 48]).expect("a valid view");
            let rays = crate::face::Rays::new(&Viewer::new().look(&scene, &view).passages()[0]);
            let geometry = scene.geometry(SectorId(0)).expect("a geometry");
            let surface = scene.sector(SectorId(0)).surface(ItemIndex(0), 0);
            let face = Face::of_geometry((geometry, &stage), (ItemIndex(0), 0), &surface, &rays, &[]);
            let tone = crate::light::Tone {
                exposure: 1.0,
                soft: false,
            };
            let daylight = Daylight::of(&stage.lamps, SectorId(0), Exposure::Fixed(1.0), &tone);
            let light = Illumination {
                rays: &rays,
                lights: &[],
                daylight: &daylight,
                ambient: None,
                tone: &tone,
            };
            for y in [0, 11, 24, 47] {
                let Some(smooth) = SmoothRow::of(&face, &light, y) else {
                    continue;
                };
                let row = Row::new(&face, &light, y);
                let mut painted = [[0; 4]; 61];
                smooth.paint(3, &mut painted);
                for (x, painted) in (3..).zip(painted) {
                    assert_eq!(
                        painted,
                        pixel(row.at(x).color),
                        "column {x}, row {y} of face {seed}"
                    );
                    compared += 1;
                }
            }
        }
        assert!(compared > 20_000, "{compared}");
    }
}
