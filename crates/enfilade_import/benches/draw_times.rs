//! Measures drawing: every method, over the 16 survey views at 1280x720, each sample painted in a plain color.
//!
//! Scenes: an office, a hall, a classroom. First each sample is counted: it must be painted exactly once, and as many
//! as the statistics say, whatever the method; the items seen are those of the table. Then the methods draw in turn,
//! view by view: one round to warm up, then five; the median of five for each view, then the median over the views.
//! For the s-buffer, also prints how it decided which of two faces is nearer.
#![allow(clippy::print_stdout, reason = "a bench prints its table")]

mod common;

use common::{BenchScene, ExpectedVisibility, Paint, ROOMS, drawn_once, folder, in_turn, median_of, open};
use enfilade::{Contract, Method, Scene, SpanStats, Viewer};

const ROUNDS: usize = 5;

/// On the office at least this part of the answers must be known, not computed, in percent.
const LEAST_KNOWN: f64 = 80.0;

fn main() {
    let Some(folder) = folder() else { return };
    let mut spans = Vec::new();
    println!(
        "{:20}{:16}{:>10}{:>10}{:>10}{:>12}{:>14}",
        "scene", "method", "draw ms", "least", "most", "of z-buffer", "samples"
    );
    for known in &ROOMS {
        let place = open(&folder, known.file);
        let mut drawn = Vec::new();
        for method in Method::ALL
            .into_iter()
            .filter(|method| method.requires().is_none())
        {
            let Some(scene) = place.seen_by(method) else {
                println!("{:20}{:16}{:>10}", known.file, method.name(), "too large");
                continue;
            };
            let (samples, counts) = check(&place, &scene, method, known);
            if method == Method::SBuffer {
                spans.push((known.file, counts));
            }
            drawn.push((method, scene, samples));
        }
        let mut contenders: Vec<Box<dyn FnMut(usize)>> = Vec::new();
        for (_, scene, _) in &drawn {
            let (mut viewer, mut paint, views) = (Viewer::new(), Paint::new(), &place.views);
            contenders.push(Box::new(move |view| {
                viewer.draw(scene, &views[view], &mut paint);
            }));
        }
        let times = in_turn(place.views.len(), ROUNDS, &mut contenders);
        let middle = |place: usize| median_of(times[place].iter().copied());
        let baseline = drawn
            .iter()
            .position(|(method, ..)| *method == Method::ZBuffer)
            .map_or(f64::NAN, middle);
        for (number, (method, _, samples)) in drawn.iter().enumerate() {
            let ms = middle(number);
            let [least, most] = [f64::min, f64::max].map(|pick| {
                let all = times[number].iter().copied();
                all.reduce(pick).unwrap_or(f64::NAN)
            });
            println!(
                "{:20}{:16}{ms:10.2}{least:10.2}{most:10.2}{:11.2}x{samples:14}",
                known.file,
                method.name(),
                ms / baseline
            );
        }
    }
    print_spans(&spans);
}

/// Draws all views once, counting. Gives the samples painted, and what s-buffers compared.
fn check(place: &BenchScene, scene: &Scene, method: Method, known: &ExpectedVisibility) -> (u64, SpanStats) {
    let what = format!("{method} on {}", known.file);
    let mut viewer = Viewer::new();
    let (mut samples, mut items, mut spans) = (0, 0, SpanStats::default());
    for view in &place.views {
        let (painted, seen) = drawn_once(&mut viewer, scene, view, &what);
        samples += painted;
        items += seen;
        let more = viewer.stats().spans;
        spans.compared += more.compared;
        spans.by_cache += more.by_cache;
        spans.by_neighbour += more.by_neighbour;
        spans.by_adjacency += more.by_adjacency;
        spans.by_range += more.by_range;
        spans.by_plane += more.by_plane;
        spans.by_depth += more.by_depth;
    }
    assert_eq!(samples, known.samples, "{what}: samples painted over all views");
    if method.contract() == Contract::Exact {
        assert_eq!(items, known.items, "{what}: items seen over all views");
    }
    (samples, spans)
}

fn print_spans(spans: &[(&str, SpanStats)]) {
    println!(
        "\nHow the s-buffer knew which face is nearer, in percent of the spans compared:\n{:20}{:>12}{:>8}{:>11}{:>11}{:>8}{:>8}{:>8}{:>9}",
        "scene", "compared", "cache", "neighbour", "adjacency", "range", "plane", "depth", "known"
    );
    for (file, spans) in spans {
        let part = |count: u64| 100.0 * count as f64 / spans.compared as f64;
        let known = part(spans.by_cache + spans.by_neighbour + spans.by_adjacency);
        println!(
            "{file:20}{:12}{:8.1}{:11.1}{:11.1}{:8.1}{:8.1}{:8.1}{known:9.1}",
            spans.compared,
            part(spans.by_cache),
            part(spans.by_neighbour),
            part(spans.by_adjacency),
            part(spans.by_range),
            part(spans.by_plane),
            part(spans.by_depth),
        );
        if *file == "ifc_office_a.glb" {
            assert!(
                known >= LEAST_KNOWN,
                "{file}: only {known:.1} % of the answers were known"
            );
        }
    }
    println!("known: from an earlier row, from the span to the left, or from the face next to it");
}
