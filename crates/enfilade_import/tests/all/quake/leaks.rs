//! Maps that leak: the line from an entity to the void passes the hole.

use super::carved::{Format, Room, carved};
use enfilade_import::{BrokenRule, Leak, ReadOptions, find_leak};

const FORMATS: [Format; 3] = [Format::Bsp29, Format::Bsp2, Format::Ibsp46];

/// Beyond the end of the world.
const FAR: i32 = 200_000;

/// A hall, a passage from it and a closet at its end, all sealed.
const SEALED: [Room; 3] = [
    Room([0, 0, 0], [256, 256, 128], -1),
    Room([256, 96, 0], [512, 160, 128], -1),
    Room([512, 0, 0], [768, 256, 128], -1),
];

/// A hole of 16 x 16 units in the far wall of the closet, and all that is beyond that wall.
const HOLE: [Room; 2] = [
    Room([768, 200, 64], [784, 216, 80], -1),
    Room([784, -FAR, -FAR], [FAR, FAR, FAR], -1),
];

/// A map of rooms with entities.
fn map(rooms: &[Room], format: Format, entities: &str) -> Vec<u8> {
    let mut bytes = carved(rooms).bytes(format);
    let table = if format == Format::Ibsp46 { 8 } else { 4 };
    let entry = [bytes.len() as u32, entities.len() as u32]
        .map(u32::to_le_bytes)
        .concat();
    bytes[table..][..8].copy_from_slice(&entry);
    bytes.extend(entities.as_bytes());
    bytes
}

fn leak(rooms: &[Room], format: Format, entities: &str) -> Option<Leak> {
    find_leak(&map(rooms, format, entities), &ReadOptions::default()).expect("a sound map")
}

const ENTITIES: &str = "{\"classname\" \"worldspawn\"}\n\
    {\"classname\" \"info_player_start\" \"origin\" \"40 40 24\"}\n\
    {\"classname\" \"func_door\" \"model\" \"*1\" \"origin\" \"900 0 0\"}\n\
    {\"classname\" \"light\" \"targetname\" \"lamp\" \"origin\" \"600 128 100\"}\n";

#[test]
fn a_sealed_map_has_no_leak_and_a_hole_is_one() {
    for format in FORMATS {
        assert_eq!(leak(&SEALED, format, ENTITIES), None, "{format:?}");
        let holed = [&SEALED[..], &HOLE].concat();
        let leak = leak(&holed, format, ENTITIES).expect("a leak");
        // The nearest entity to the hole is the lamp, not the start; the door is a brush.
        assert_eq!(
            (&*leak.entity, leak.origin),
            ("light lamp#3", [600.0, 128.0, 100.0]),
            "{format:?}"
        );
        assert_eq!(leak.line[0], leak.origin);
        let is_in_hole = |point: &&[f64; 3]| {
            (768.0..=784.0).contains(&point[0])
                && (200.0..=216.0).contains(&point[1])
                && (64.0..=80.0).contains(&point[2])
        };
        assert!(
            leak.line.iter().any(|point| is_in_hole(&point)),
            "{format:?}: {leak:?}"
        );
        let [x, ..] = *leak.line.last().expect("points");
        assert!(x > 784.0 && x < 900.0, "{format:?}: {leak:?}");
    }
}

#[test]
fn entities_in_walls_and_maps_without_entities_do_not_leak() {
    let holed = [&SEALED[..], &HOLE].concat();
    for entities in [
        "",
        "{\"classname\" \"light\" \"origin\" \"300 0 0\"}",
        "{\"classname\" \"light\"}",
    ] {
        assert_eq!(leak(&holed, Format::Bsp29, entities), None, "{entities}");
    }
    let cut_off = [&SEALED[..], &HOLE[1..]].concat();
    assert_eq!(
        leak(&cut_off, Format::Bsp29, ENTITIES),
        None,
        "the wall is closed"
    );
    let outside = "{\"classname\" \"light\" \"origin\" \"5000 0 0\"}";
    let leak = leak(&cut_off, Format::Bsp29, outside).expect("it is in the void");
    assert_eq!(leak.line[0], [5000.0, 0.0, 0.0]);
}

#[test]
fn sky_seals_a_map() {
    let mut holed = [&SEALED[..], &HOLE].concat();
    holed[3].2 = -6;
    assert_eq!(leak(&holed, Format::Bsp29, ENTITIES), None);
}

#[test]
fn a_pts_file_is_a_line_of_points_that_are_near_each_other() {
    let holed = [&SEALED[..], &HOLE].concat();
    let leak = leak(&holed, Format::Bsp2, ENTITIES).expect("a leak");
    let text = leak.to_pts();
    let points: Vec<Vec<f64>> = text
        .lines()
        .map(|line| {
            line.split(' ')
                .map(|number| number.parse().expect("a number"))
                .collect()
        })
        .collect();
    assert_eq!(points[0], leak.origin);
    assert_eq!(
        points.last().map(Vec::as_slice),
        leak.line.last().map(|end| &end[..])
    );
    for pair in points.windows(2) {
        assert_eq!(pair[0].len(), 3);
        let squares = (0..3).map(|axis| (pair[1][axis] - pair[0][axis]).powi(2));
        let step = squares.sum::<f64>().sqrt();
        assert!(step <= 2.01 && step > 0.0, "{pair:?}");
    }
}

#[test]
fn damaged_maps_are_refused_and_never_read_without_bounds() {
    let whole = map(&[&SEALED[..], &HOLE].concat(), Format::Bsp29, ENTITIES);
    for end in (0..whole.len()).step_by(7) {
        // Cut short, it is refused or has fewer entities; it never panics.
        let _ = find_leak(&whole[..end], &ReadOptions::default());
    }
    let options = ReadOptions {
        limit_bytes: 1000,
        ..ReadOptions::default()
    };
    let error = find_leak(&whole, &options).expect_err("too large");
    assert!(matches!(error.rule, BrokenRule::TooLarge { .. }), "{error}");
}
