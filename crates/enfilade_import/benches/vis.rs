//! Measures the PVS computation of maps: time on one thread, number of visible pairs, and how many of them a line of
//! sight proves.
//!
//! Maps: those of `ENFILADE_MAPS`, each with the best known time of other programs, if any, and `rooms`: a generated
//! grid of rooms with five million visible pairs. More pairs than in the table are an error, as are fewer than 95 of
//! 100 proven by a line. Arguments select maps by name.
#![allow(
    clippy::print_stdout,
    clippy::print_stderr,
    reason = "a bench prints its table"
)]

use enfilade_bake::{Cells, PairsOptions, Portal, VisiblePairs};
use enfilade_import::{ReadOptions, read_portals};
use rayon::ThreadPoolBuilder;
use std::path::PathBuf;
use std::time::Instant;

/// Runs of a map, of which the one in the middle counts; one alone where that takes long.
const RUNS: usize = 3;
const LONG_SECONDS: f64 = 5.0;

/// Maps, the best seconds of others, and the most pairs that there may be.
const MAPS: [(&str, Option<f64>, usize); 14] = [
    ("dm1", Some(0.40), 33_746),
    ("end", Some(0.69), 35_024),
    ("lq_e0m1", Some(0.39), 36_316),
    ("lqdm13", Some(30.6), 129_020),
    ("e1m1", Some(4.4), 155_702),
    ("start", Some(6.2), 127_636),
    ("lq_e1m5", Some(8.5), 132_890),
    ("lq_e4m4", None, 1_021_348),
    ("q3_darkzone", Some(1.5), 64_390),
    ("q3_aneurysm", Some(6.4), 138_552),
    ("q3_stormkeep", Some(4.2), 122_420),
    ("q3_accident", Some(8.2), 265_984),
    ("q3_final_rage", Some(58.0), 1_352_750),
    (ROOMS, None, 5_065_460),
];

/// The generated map.
const ROOMS: &str = "rooms";

fn main() {
    let folder = std::env::var_os("ENFILADE_MAPS").map(PathBuf::from);
    if folder.is_none() {
        eprintln!("skipped all maps but {ROOMS}: ENFILADE_MAPS names no folder of maps");
    }
    let wanted: Vec<String> = std::env::args()
        .skip(1)
        .filter(|name| !name.starts_with("--"))
        .collect();
    let one = ThreadPoolBuilder::new().num_threads(1).build().expect("a thread");
    println!(
        "{:15}{:>9}{:>9}{:>11}{:>9}",
        "map", "seconds", "others", "pairs", "shown"
    );
    let (mut logs, mut timed) = (0.0, 0);
    for (name, others, most) in MAPS {
        if !wanted.is_empty() && !wanted.iter().any(|wanted| wanted == name) {
            continue;
        }
        let cells = if name == ROOMS {
            grid_of_rooms(80)
        } else if let Some(folder) = &folder {
            let file = read_portals(&folder.join(format!("prt1/{name}.prt")), &ReadOptions::default());
            file.unwrap_or_else(|error| panic!("{error}")).cells
        } else {
            continue;
        };
        let run = || {
            let start = Instant::now();
            let pairs = one
                .install(|| VisiblePairs::compute(&cells, &PairsOptions::default()).expect("little memory"));
            (start.elapsed().as_secs_f64(), pairs)
        };
        let (first, pairs) = run();
        let mut times = vec![first];
        if first < LONG_SECONDS {
            times.extend((1..RUNS).map(|_| run().0));
        }
        times.sort_by(f64::total_cmp);
        let seconds = times[times.len() / 2];
        let shown = pairs.proven() as f64 / pairs.count() as f64;
        println!(
            "{name:15}{seconds:9.2}{:>9}{:11}{:7.1} %",
            others.map_or("-".to_owned(), |others| format!("{others:.2}")),
            pairs.count(),
            100.0 * shown
        );
        assert!(pairs.count() <= most, "{name}: more than {most} pairs");
        assert!(shown >= 0.95, "{name}: {shown}");
        if let Some(others) = others {
            logs += (others / seconds).ln();
            timed += 1;
        }
    }
    if timed > 0 {
        println!(
            "others take {:.2} times as long (geometric mean)",
            (logs / f64::from(timed)).exp()
        );
    }
}

/// `side` × `side` square rooms of 256 units, a door in each wall between two: half to nine tenths of the wall wide, at a
/// random place in it, and 128 to 224 units high.
fn grid_of_rooms(side: u32) -> Cells {
    const ROOM: f64 = 256.0;
    let mut random = fastrand::Rng::with_seed(1);
    let mut portals = Vec::new();
    let rooms = (0..side).flat_map(|y| (0..side).map(move |x| [x, y]));
    for ([x, y], is_across) in rooms.flat_map(|room| [(room, true), (room, false)]) {
        let [next_x, next_y] = if is_across { [x + 1, y] } else { [x, y + 1] };
        if next_x == side || next_y == side {
            continue;
        }
        let width = (ROOM * (0.5 + 0.4 * random.f64())).round();
        let start = ((ROOM - width) * random.f64()).round();
        let top = 128.0 + (96.0 * random.f64()).round();
        let (left, right) = (start, start + width);
        // Counter-clockwise about the direction from the room to the next.
        let corners = if is_across {
            let [wall, beside] = [next_x, y].map(|at| f64::from(at) * ROOM);
            let corner = |along, up| [wall, beside + along, up];
            [
                corner(left, 0.0),
                corner(right, 0.0),
                corner(right, top),
                corner(left, top),
            ]
        } else {
            let [beside, wall] = [x, next_y].map(|at| f64::from(at) * ROOM);
            let corner = |along, up| [beside + along, wall, up];
            [
                corner(right, 0.0),
                corner(left, 0.0),
                corner(left, top),
                corner(right, top),
            ]
        };
        portals.push(Portal {
            corners: corners.to_vec(),
            cells: [y * side + x, next_y * side + next_x],
        });
    }
    Cells::new(side * side, portals).expect("flat convex doors")
}
