//! Measures looks: every method, over the 16 survey views at 1280x720, and the speed of each relative to the z-buffer
//! of the same run.
//!
//! A wrong number of visible items is an error, not a time. The methods look in turn, view by view: one round to warm
//! up, then three; the median of three for each view, then the median over the views.
#![allow(clippy::print_stdout, reason = "a bench prints its table")]

mod common;

use common::{ROOMS, folder, in_turn, median_of, open};
use enfilade::{Contract, Method, Viewer};

const ROUNDS: usize = 3;

/// Scenes without rooms, and the number of items visible by every exact method, over all views.
const OTHERS: [(&str, usize); 2] = [("city_san_francisco.glb", 243), ("country_kitchen.glb", 545)];

fn main() {
    let Some(folder) = folder() else { return };
    println!(
        "{:24}{:16}{:>10}{:>16}",
        "scene", "method", "look ms", "than z-buffer"
    );
    let rooms = ROOMS.iter().map(|known| (known.file, known.items));
    for (file, expected) in rooms.chain(OTHERS) {
        let place = open(&folder, file);
        let views = &place.views;
        let methods = Method::ALL
            .into_iter()
            .filter(|method| method.requires().is_none());
        let scenes: Vec<_> = methods
            .map(|method| (method, place.seen_by(method).expect("they are not that large")))
            .collect();
        let mut contenders: Vec<Box<dyn FnMut(usize)>> = Vec::new();
        for (method, scene) in &scenes {
            let mut viewer = Viewer::new();
            if method.contract() == Contract::Exact {
                let seen = views.iter().map(|view| viewer.look(scene, view).items().len());
                assert_eq!(seen.sum::<usize>(), expected, "{method} on {file}");
            }
            contenders.push(Box::new(move |view| {
                viewer.look(scene, &views[view]);
            }));
        }
        let times = in_turn(views.len(), ROUNDS, &mut contenders);
        let middle = |number: usize| median_of(times[number].iter().copied());
        let baseline = scenes.iter().position(|(method, _)| *method == Method::ZBuffer);
        let baseline = middle(baseline.expect("one of all"));
        for (number, (method, _)) in scenes.iter().enumerate() {
            let ms = middle(number);
            println!("{file:24}{:16}{ms:10.2}{:15.1}x", method.name(), baseline / ms);
        }
    }
}
