//! Shared by the benches on real scenes: scenes with their views, interleaved timing, canvases, and an independent
//! projection of AABBs.
#![allow(
    dead_code,
    clippy::print_stdout,
    clippy::print_stderr,
    reason = "a bench prints its table, and none of them needs everything"
)]

pub(crate) mod land;

use enfilade::{
    Aabb, Canvas, Geometry, Item, Method, Owner, Passage, PassageId, Scene, Span, View, Viewer, survey,
};
use enfilade_import::{ReadOptions, read};
use glam::{DAffine3, DMat3, DVec3};
use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::time::Instant;

pub(crate) const VIEWS: usize = 16;
pub(crate) const SIZE: [u32; 2] = [1280, 720];

/// Three kinds of rooms: many small ones, one tall hall, one full of furniture.
pub(crate) const ROOMS: [ExpectedVisibility; 3] = [
    ExpectedVisibility {
        file: "ifc_office_a.glb",
        items: 373,
        samples: 14_452_869,
    },
    ExpectedVisibility {
        file: "sponza_crytek.glb",
        items: 912,
        samples: 14_485_154,
    },
    ExpectedVisibility {
        file: "classroom.glb",
        items: 404,
        samples: 13_610_470,
    },
];

/// Expected visibility of a scene over the views of its survey.
pub(crate) struct ExpectedVisibility {
    pub(crate) file: &'static str,
    /// Number of items visible by every exact method.
    pub(crate) items: usize,
    /// Samples that an opaque face owns; they do not depend on the method.
    pub(crate) samples: u64,
}

/// A scene and where it is looked at from.
pub(crate) struct BenchScene {
    pub(crate) scene: Scene,
    pub(crate) views: Vec<View>,
}

/// The folder of real scenes; `None`, and said so, where there is none.
pub(crate) fn folder() -> Option<PathBuf> {
    let folder = std::env::var_os("ENFILADE_SCENES").map(PathBuf::from);
    if folder.is_none() {
        eprintln!("skipped: ENFILADE_SCENES names no folder of .glb files");
    }
    folder
}

/// Reads a scene of one sector, and surveys it as `enfilade look --survey 16` does.
pub(crate) fn open(folder: &Path, file: &str) -> BenchScene {
    let options = ReadOptions {
        flat: true,
        ..ReadOptions::default()
    };
    let import = read(&folder.join(file), &options).unwrap_or_else(|error| panic!("{error}"));
    let scene = import
        .scene(Method::ZBuffer, Method::DEFAULT_LIMIT)
        .expect("one sector");
    let views = survey(&scene, VIEWS)
        .views
        .iter()
        .map(|at| View::new(at.eye, at.toward, SIZE).expect("a valid view"))
        .collect();
    BenchScene { scene, views }
}

impl BenchScene {
    /// Geometry of its only sector.
    pub(crate) fn geometry(&self) -> &Arc<Geometry> {
        let only = self.scene.sectors().next().expect("one sector");
        self.scene.geometry(only).expect("a sector of ours")
    }

    /// Returns the scene with a method; `None` if that would be too large.
    pub(crate) fn seen_by(&self, method: Method) -> Option<Scene> {
        self.scene.with_method(method, Method::DEFAULT_LIMIT).ok()
    }
}

/// Milliseconds that each contender takes at each step (a view, a frame): the median of `rounds`, after one to warm
/// up.
///
/// The contenders take turns at every step, so that whatever else the machine does slows all of them alike.
pub(crate) fn in_turn(
    steps: usize,
    rounds: usize,
    contenders: &mut [Box<dyn FnMut(usize) + '_>],
) -> Vec<Vec<f64>> {
    let mut times = vec![vec![Vec::with_capacity(rounds); steps]; contenders.len()];
    for round in 0..=rounds {
        for step in 0..steps {
            for (contender, times) in contenders.iter_mut().zip(&mut times) {
                let start = Instant::now();
                contender(step);
                if round > 0 {
                    times[step].push(start.elapsed().as_secs_f64() * 1e3);
                }
            }
        }
    }
    times
        .iter_mut()
        .map(|steps| steps.iter_mut().map(|times| median(times)).collect())
        .collect()
}

/// The value in the middle, or between the two in the middle; NaN where there is none.
pub(crate) fn median(values: &mut [f64]) -> f64 {
    if values.is_empty() {
        return f64::NAN;
    }
    values.sort_by(f64::total_cmp);
    0.5 * (values[(values.len() - 1) / 2] + values[values.len() / 2])
}

/// As [`median`], of values that stay in their order.
pub(crate) fn median_of(values: impl IntoIterator<Item = f64>) -> f64 {
    median(&mut values.into_iter().collect::<Vec<f64>>())
}

/// Hashes an owner to a pseudo-random number: its color, or its texture offset.
#[inline]
pub(crate) fn dye(owner: Owner) -> u32 {
    let number = match owner {
        Owner::Face(item, face) => item.0.wrapping_mul(0x9E37_79B9) ^ face.wrapping_mul(0x85EB_CA6B),
        Owner::Opening(opening) => u32::from(opening.0),
    };
    number.wrapping_mul(0xC2B2_AE35) ^ number >> 15
}

/// Paints each face in a different color: the minimum work of a shader.
pub(crate) struct Paint {
    image: Vec<u32>,
}

impl Paint {
    pub(crate) fn new() -> Paint {
        Paint {
            image: vec![0; (SIZE[0] * SIZE[1]) as usize],
        }
    }
}

impl Canvas for Paint {
    fn enter(&mut self, _id: PassageId, _passage: &Passage) {}

    fn row(&mut self, y: u16, spans: &[Span]) {
        let start = usize::from(y) * SIZE[0] as usize;
        for span in spans {
            let color = dye(span.owner);
            for sample in &mut self.image[start + usize::from(span.x0)..start + usize::from(span.x1)] {
                *sample = if span.see_through {
                    (*sample >> 1 & 0x7F7F_7F7F) + (color >> 1 & 0x7F7F_7F7F)
                } else {
                    color
                };
            }
        }
    }
}

/// Counts how often each sample is painted by a face that hides; glass comes on top and is not counted.
pub(crate) struct Once {
    painted: Vec<bool>,
    pub(crate) samples: u64,
    pub(crate) again: u64,
}

impl Once {
    pub(crate) fn new() -> Once {
        Once {
            painted: vec![false; (SIZE[0] * SIZE[1]) as usize],
            samples: 0,
            again: 0,
        }
    }
}

impl Canvas for Once {
    fn enter(&mut self, _id: PassageId, _passage: &Passage) {}

    fn row(&mut self, y: u16, spans: &[Span]) {
        let start = usize::from(y) * SIZE[0] as usize;
        for span in spans.iter().filter(|span| !span.see_through) {
            for painted in &mut self.painted[start + usize::from(span.x0)..start + usize::from(span.x1)] {
                self.samples += 1;
                self.again += u64::from(*painted);
                *painted = true;
            }
        }
    }
}

/// Draws one view, and holds that each sample is painted once and no fewer are than the statistics say. Gives the
/// samples and the items.
pub(crate) fn drawn_once(viewer: &mut Viewer, scene: &Scene, view: &View, what: &str) -> (u64, usize) {
    let mut once = Once::new();
    let items = viewer.draw(scene, view, &mut once).items().len();
    assert_eq!(once.again, 0, "{what}: samples painted twice");
    assert_eq!(once.samples, viewer.stats().samples_owned, "{what}: samples");
    (once.samples, items)
}

/// Projection of points to a view's screen, computed independently of the engine.
pub(crate) struct Lens {
    /// To (X, Y, W): the pixel is (X / W, Y / W), and W the depth along the view direction.
    pub(crate) screen_from_sector: DAffine3,
    pub(crate) near: f64,
}

impl Lens {
    pub(crate) fn of(view: &View) -> Lens {
        let [eye, toward, up] = [view.eye(), view.toward(), view.up()].map(|v| DVec3::from(v.map(f64::from)));
        let ahead = (toward - eye).normalize();
        let right = ahead.cross(up).normalize();
        let down = ahead.cross(right);
        let [width, height] = view.size().map(f64::from);
        let focal = 0.5 * height / (0.5 * f64::from(view.fov_y())).tan();
        let rows = [
            right * focal + ahead * (0.5 * width),
            down * focal + ahead * (0.5 * height),
            ahead,
        ];
        let matrix3 = DMat3::from_cols(rows[0], rows[1], rows[2]).transpose();
        Lens {
            screen_from_sector: DAffine3 {
                matrix3,
                translation: matrix3 * -eye,
            },
            near: f64::from(view.z_near()),
        }
    }

    pub(crate) fn screen_from(&self, item: &Item) -> DAffine3 {
        let [x, y, z, translation] = item
            .sector_from_item
            .map(|column| DVec3::from(column.map(f64::from)));
        let sector_from_item = DAffine3 {
            matrix3: DMat3::from_cols(x, y, z),
            translation,
        };
        self.screen_from_sector * sector_from_item
    }

    /// Returns `true` if any part of an AABB, given in another space, may be in the frustum; `true` when unsure.
    pub(crate) fn may_show(&self, screen_from_local: &DAffine3, bounds: &Aabb) -> bool {
        if bounds.is_empty() {
            return false;
        }
        let [width, height] = SIZE.map(f64::from);
        let mut outside = 0b1_1111_u8;
        for corner in bounds.corners() {
            let DVec3 { x, y, z: w } = screen_from_local.transform_point3(DVec3::from(corner.map(f64::from)));
            let sides = [x < 0.0, x > width * w, y < 0.0, y > height * w, w < self.near];
            outside &= sides
                .into_iter()
                .rev()
                .fold(0, |bits, out| bits << 1 | u8::from(out));
        }
        outside == 0
    }
}
