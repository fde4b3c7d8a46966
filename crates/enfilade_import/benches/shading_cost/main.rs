//! Measures whether an s-buffer wins where shading is expensive: draws over the 16 survey views at 1280x720, with each
//! shaded sample costing one texture fetch and eight lights.
//!
//! Draws in turn, view by view: (a) `s-buffer`; (b) `z-buffer`, which keeps an owner per sample and so also shades
//! once; (c) a classic z-buffer, Catmull 1974, which shades whenever a nearer face is written. The last is
//! `classic.rs`: items in order, clusters outside the frustum culled, triangles clipped at the near plane and
//! rasterized scanline by scanline. It is timed as it is, and, because its rasterizer is not the engine's, also as the
//! look of (b) plus the shading of its own writes (c'). All three shade the same transparent surfaces, and the visible
//! samples of (c) must equal those of (b) except for one in a thousand.
//! Median of three rounds for each view; the tables are by overdraw: covered samples per visible one.
#![allow(clippy::print_stdout, reason = "a bench prints its table")]

mod classic;
#[path = "../common/mod.rs"]
mod common;

use classic::Classic;
use common::{BenchScene, Lens, ROOMS, SIZE, drawn_once, dye, folder, in_turn, median_of, open};
use enfilade::{Canvas, ItemIndex, Method, Owner, Passage, PassageId, Span, Viewer};
use std::hint::black_box;

const ROUNDS: usize = 3;
/// The claim applies to views with more overdraw than this.
const MUCH: f64 = 3.0;

/// A sample's cost: a texture of 256 × 256 texels, and eight point lights.
struct Shader {
    texture: Vec<u32>,
    lights: [[f32; 8]; 3],
    image: Vec<u32>,
    shaded: u64,
}

impl Shader {
    fn new() -> Shader {
        let place = |axis: usize| std::array::from_fn(|light| ((7 * light + 3 * axis) % 11) as f32 * 130.0);
        Shader {
            texture: (0..1 << 16_u32)
                .map(|texel: u32| texel.wrapping_mul(0x9E37_79B9))
                .collect(),
            lights: std::array::from_fn(place),
            image: vec![0; (SIZE[0] * SIZE[1]) as usize],
            shaded: 0,
        }
    }

    /// Never inlined, so that it costs the same whoever calls it, one sample or a run.
    #[inline(never)]
    fn shade(&mut self, x: usize, y: usize, dye: u32) {
        let texel = self.texture[(y << 8).wrapping_add(x).wrapping_add(dye as usize) & 0xFFFF];
        let [px, py] = [x as f32, y as f32];
        let pz = (dye & 0xFF) as f32 + 0.125 * px;
        let normal = [8, 16, 24].map(|shift| (dye >> shift & 0xFF) as f32 - 127.5);
        let mut light = 0.0_f32;
        for number in 0..8 {
            let [x, y, z] = [0, 1, 2].map(|axis| self.lights[axis][number]);
            let [dx, dy, dz] = [x - px, y - py, z - pz];
            let per_distance = 1.0 / (dx * dx + dy * dy + dz * dz + 1.0).sqrt();
            let facing = (dx * normal[0] + dy * normal[1] + dz * normal[2]) * per_distance;
            light += facing.max(0.0) * per_distance;
        }
        self.shaded += 1;
        self.image[y * SIZE[0] as usize + x] = texel ^ (light * 255.0) as u32;
    }
}

impl Canvas for Shader {
    fn enter(&mut self, _id: PassageId, _passage: &Passage) {}

    fn row(&mut self, y: u16, spans: &[Span]) {
        for span in spans {
            let dye = dye(span.owner);
            for x in span.x0..span.x1 {
                self.shade(usize::from(x), usize::from(y), dye);
            }
        }
    }
}

/// Counts at one view.
struct Counts {
    overdraw: f64,
    /// For each visible sample, samples written by the classic z-buffer.
    writes: f64,
}

fn main() {
    let Some(folder) = folder() else { return };
    println!("shading a sample: {:.1} ns\n", ns_per_sample());
    println!(
        "medians over the views of a class, in ms: a s-buffer, b z-buffer that shades once, c classic z-buffer, c' the \
         look of b and the shading of c\n\
         {:18}{:>10}{:>7}{:>10}{:>8}{:>8}{:>8}{:>8}{:>8}{:>7}{:>7}{:>7}{:>10}{:>10}",
        "scene",
        "overdraw",
        "views",
        "overdraw",
        "writes",
        "a",
        "b",
        "c",
        "c'",
        "b/a",
        "c/a",
        "c'/a",
        "a<b",
        "a<c, c'"
    );
    for known in &ROOMS {
        let place = open(&folder, known.file);
        let counts = count(&place, known.samples);
        let times = time(&place);
        for (class, much) in [("above 3", true), ("others", false)] {
            let views: Vec<usize> = (0..counts.len())
                .filter(|&view| (counts[view].overdraw > MUCH) == much)
                .collect();
            if views.is_empty() {
                continue;
            }
            let over = |value: &dyn Fn(usize) -> f64| median_of(views.iter().map(|&view| value(view)));
            let ratio = |of: usize| over(&|view| times[of][view] / times[0][view]);
            let faster = |than: &[usize]| {
                let faster = |&&view: &&usize| than.iter().all(|&of| times[0][view] < times[of][view]);
                format!("{}/{}", views.iter().filter(faster).count(), views.len())
            };
            println!(
                "{:18}{class:>10}{:7}{:10.2}{:8.2}{:8.1}{:8.1}{:8.1}{:8.1}{:7.2}{:7.2}{:7.2}{:>10}{:>10}",
                known.file,
                views.len(),
                over(&|view| counts[view].overdraw),
                over(&|view| counts[view].writes),
                over(&|view| times[0][view]),
                over(&|view| times[1][view]),
                over(&|view| times[2][view]),
                over(&|view| times[3][view]),
                ratio(1),
                ratio(2),
                ratio(3),
                faster(&[1]),
                faster(&[2, 3]),
            );
        }
    }
}

/// Counts samples at each view, and holds the classic z-buffer against ours.
fn count(place: &BenchScene, expected: u64) -> Vec<Counts> {
    let [span, depth] =
        [Method::SBuffer, Method::ZBuffer].map(|method| place.seen_by(method).expect("small"));
    let (mut viewers, mut classic) = ([Viewer::new(), Viewer::new()], Classic::new());
    let mut total = 0;
    let counts = place.views.iter().map(|view| {
        let [(samples, _), (same, _)] = [(&span, 0), (&depth, 1)]
            .map(|(scene, number)| drawn_once(&mut viewers[number], scene, view, "a or b"));
        assert_eq!(samples, same, "s-buffer and z-buffer shade as many samples");
        total += samples;
        let mut shader = Shader::new();
        viewers[1].draw(&depth, view, &mut shader);
        let (stats, mut seen_through) = (*viewers[1].stats(), 0);
        let once = shader.shaded;
        classic.draw(place.geometry(), &Lens::of(view), &mut |_, _, _| {
            seen_through += 1
        });
        seen_through -= classic.writes;
        let visible = classic
            .rev_depth
            .iter()
            .filter(|&&rev_depth| rev_depth > 0.0)
            .count() as u64;
        assert!(
            visible.abs_diff(samples) <= samples / 1000
                && (visible + seen_through).abs_diff(once) <= once / 1000,
            "the classic z-buffer shows {visible} samples and {seen_through} of glass, not {samples} and {}",
            once - samples
        );
        Counts {
            overdraw: stats.samples as f64 / stats.samples_owned as f64,
            writes: classic.writes as f64 / visible as f64,
        }
    });
    let counts = counts.collect();
    assert_eq!(total, expected, "samples over all views");
    counts
}

/// Milliseconds at each view of a, b, c and c'.
fn time(place: &BenchScene) -> [Vec<f64>; 4] {
    let [span, depth] =
        [Method::SBuffer, Method::ZBuffer].map(|method| place.seen_by(method).expect("small"));
    let lenses: Vec<Lens> = place.views.iter().map(Lens::of).collect();
    let (views, geometry, lenses) = (&place.views, place.geometry(), &lenses);
    let mut contenders: Vec<Box<dyn FnMut(usize)>> = Vec::new();
    for scene in [&span, &depth] {
        let (mut viewer, mut shader) = (Viewer::new(), Shader::new());
        contenders.push(Box::new(move |view| {
            viewer.draw(scene, &views[view], &mut shader);
        }));
    }
    let (mut classic, mut shader) = (Classic::new(), Shader::new());
    contenders.push(Box::new(move |view| {
        classic.draw(geometry, &lenses[view], &mut |x, y, dye| shader.shade(x, y, dye));
    }));
    let (mut classic, mut writes) = (Classic::new(), 0_u64);
    contenders.push(Box::new(move |view| {
        classic.draw(geometry, &lenses[view], &mut |_, _, _| writes += 1);
        black_box(writes);
    }));
    let (mut viewer, depth) = (Viewer::new(), &depth);
    contenders.push(Box::new(move |view| {
        viewer.look(depth, &views[view]);
    }));
    let mut times = in_turn(views.len(), ROUNDS, &mut contenders).into_iter();
    let [a, b, c, unshaded, look] = [(); 5].map(|()| times.next().expect("five contenders"));
    let split = (0..views.len())
        .map(|view| look[view] + c[view] - unshaded[view])
        .collect();
    [a, b, c, split]
}

/// Shading time of one sample of spans, in nanoseconds.
fn ns_per_sample() -> f64 {
    let mut shader = Shader::new();
    let owner = Owner::Face(ItemIndex(7), 11);
    let spans = [Span {
        x0: 0,
        x1: SIZE[0] as u16,
        owner,
        see_through: false,
    }];
    let mut pass: [Box<dyn FnMut(usize)>; 1] = [Box::new(|_| {
        for y in 0..SIZE[1] as u16 {
            shader.row(y, &spans);
        }
    })];
    1e6 * in_turn(1, 9, &mut pass)[0][0] / f64::from(SIZE[0] * SIZE[1])
}
