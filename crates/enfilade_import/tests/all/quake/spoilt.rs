//! Maps made to do harm: they may be refused, but never take the program down, or its memory, or its time.

use super::little::{FORMATS, Format, Little};
use super::maps::maps;
use enfilade::{Camera, Method, Viewer};
use enfilade_import::{Import, ReadOptions, read_bytes};
use std::time::{Duration, Instant};

/// Long enough for a busy machine, and far too short for anything that grows with the square.
const PATIENCE: Duration = Duration::from_secs(20);

fn refusal(map: &[u8]) -> Option<String> {
    let options = ReadOptions {
        limit_bytes: 1 << 26,
        ..ReadOptions::default()
    };
    match read_bytes(map, None, &options) {
        Err(error) => Some(error.to_string()),
        Ok(import) => {
            looked_at(&import);
            None
        }
    }
}

/// Looks around in a map that was read, through its cells if it has any.
fn looked_at(import: &Import) {
    let method = match import.rooms[0].geometry.cells() {
        Some(_) => Method::Pvs,
        None => Method::HierarchicalZ,
    };
    let Ok(scene) = import.scene(method, 1 << 26) else {
        return;
    };
    for camera in import.cameras.iter().take(1) {
        let plain = Camera::new(camera.eye, camera.toward);
        if let Ok(view) = plain.view([64, 48]) {
            Viewer::new().look(&scene, &view);
        }
    }
}

/// Returns random numbers below those asked for, reproducible by seed.
fn numbers(seed: u64) -> impl FnMut(usize) -> usize {
    let mut random = fastrand::Rng::with_seed(seed);
    move |below| random.usize(..below)
}

#[test]
fn a_map_that_is_cut_short_anywhere_is_refused_and_says_what_to_do() {
    for format in FORMATS {
        let map = Little::new(format).bytes();
        for end in 0..map.len() {
            let said = refusal(&map[..end]).unwrap_or_else(|| panic!("{format:?} up to {end}"));
            assert!(
                said.contains("again")
                    || said.contains("name a scene")
                    || said.contains("is not a compiled map of a known format"),
                "{said}"
            );
        }
    }
}

#[test]
fn a_map_with_a_few_bytes_wrong_is_read_or_refused() {
    let mut number = numbers(20_261_122);
    for format in FORMATS {
        let whole = Little::new(format).bytes();
        let (mut read, mut refused) = (0, 0);
        for _ in 0..4000 {
            let mut map = whole.clone();
            for _ in 0..=number(3) {
                let at = number(map.len());
                match number(4) {
                    0 => map[at] ^= 1 << number(8),
                    1 => map[at] = [0, 1, 0x7f, 0x80, 0xff][number(5)],
                    _ => {
                        // A whole number where one stands.
                        let bad = [
                            -1,
                            0,
                            1,
                            3,
                            255,
                            65_535,
                            i32::MAX,
                            i32::MIN,
                            0x7fc0_0000,
                            0x7f7f_ffff,
                        ];
                        let at = at / 4 * 4;
                        let bad = bad[number(bad.len())].to_le_bytes();
                        let end = map.len().min(at + 4);
                        map[at..end].copy_from_slice(&bad[..end - at]);
                    }
                }
            }
            match refusal(&map) {
                None => read += 1,
                Some(said) => {
                    assert!(!said.is_empty());
                    refused += 1;
                }
            }
        }
        assert!(
            read > 200 && refused > 200,
            "{format:?}: {read} read, {refused} refused"
        );
    }
}

/// Spoils one word, or a stretch of bytes.
fn spoil(map: &mut [u8], number: &mut impl FnMut(usize) -> usize) {
    // Mostly where the tables are: the rest is long lists of places, that may be anywhere.
    let at = match number(3) {
        0 => number(144),
        _ => number(map.len()),
    };
    let end = map.len().min(at + 1 + number(40));
    match number(3) {
        0 => map[at..end].fill(0xff),
        1 => map[at..end].reverse(),
        _ => map[at] ^= 1 << number(8),
    }
}

#[test]
#[ignore = "needs ENFILADE_MAPS"]
fn a_real_map_with_a_stretch_of_it_spoilt_is_read_or_refused() {
    let folder = maps();
    let mut number = numbers(5);
    for name in ["quake/dm1.bsp", "quake3/darkzone.shipped.bsp"] {
        let whole = std::fs::read(folder.join(name)).expect("a map");
        let (mut read, mut refused) = (0, 0);
        for round in 0..120 {
            let mut map = whole.clone();
            (0..=round % 3).for_each(|_| spoil(&mut map, &mut number));
            if round % 10 == 9 {
                map.truncate(number(whole.len()));
            }
            *if refusal(&map).is_none() {
                &mut read
            } else {
                &mut refused
            } += 1;
        }
        assert!(
            read > 10 && refused > 10,
            "{name}: {read} read, {refused} refused"
        );
    }
}

#[test]
fn a_number_that_names_nothing_is_told_with_what_names_it() {
    let cases: [(Format, usize, usize, i32, &str); 16] = [
        (Format::Bsp2, 5, 0, 99, "node 0 names plane 99, but there are"),
        (Format::Bsp2, 7, 0, 99, "face 0 names plane 99"),
        (Format::Bsp2, 7, 8, -1, "face 0 names edges up to 3"),
        (Format::Bsp2, 7, 16, 7, "face 0 names texture placing 7"),
        (Format::Bsp2, 13, 0, -999, "face 0 names edge 999"),
        (Format::Bsp2, 12, 8, 999, "edge 1 names vertex 999"),
        (Format::Bsp2, 6, 32, 4, "texture placing 0 names texture 4"),
        (Format::Bsp2, 2, 8, 9999, "texture 1 ends after"),
        (
            Format::Bsp2,
            3,
            0,
            0x7fc0_0000,
            "vertex 0 has a coordinate that is not finite",
        ),
        (Format::Bsp2, 10, 48, 9, "leaf 1 names byte of rows 9"),
        (Format::Bsp2, 11, 0, 88, "leaf 1 names face 88"),
        (Format::Bsp2, 14, 56, 77, "model 0 names faces up to 90"),
        (Format::Ibsp46, 4, 48, 2, "leaf 1 names cluster 2"),
        (
            Format::Ibsp46,
            13,
            20,
            80,
            "face 0 names corners of triangles up to 86",
        ),
        (Format::Ibsp46, 11, 0, 4, "face 0 names corner 4"),
        (
            Format::Ibsp46,
            16,
            0,
            9,
            "the PVS row of cluster 8 ends after its lump",
        ),
    ];
    for (format, lump, at, number, wanted) in cases {
        let mut little = Little::new(format);
        little.lumps[lump][at..at + 4].copy_from_slice(&number.to_le_bytes());
        let said = refusal(&little.bytes()).unwrap_or_else(|| panic!("it is read: {wanted}"));
        assert!(said.contains(wanted), "it says\n  {said}\nand not\n  {wanted}");
        assert!(said.contains("again"), "what to do about it: {said}");
    }
}

#[test]
fn entities_that_are_none_are_told_by_their_line() {
    let mut little = Little::new(Format::Bsp29);
    little.lumps[0] = b"{\n\"classname\" { }".to_vec();
    let said = refusal(&little.bytes()).expect("a refusal");
    assert!(
        said.contains("its entities have `{` where a value is expected, in line 2"),
        "{said}"
    );
    little.lumps[0] = b"{ } { \"classname\" \"func_wall\" \"model\" \"*7\" }".to_vec();
    let said = refusal(&little.bytes()).expect("a refusal");
    assert!(said.contains("entity 1 names model 7, but there are 2"), "{said}");
}

#[test]
fn a_patch_of_an_even_number_of_corners_is_refused() {
    let mut little = Little::new(Format::Ibsp46);
    little.lumps[13][8..12].copy_from_slice(&2i32.to_le_bytes());
    little.lumps[13][96..104].copy_from_slice(&[2, 0, 0, 0, 2, 0, 0, 0]);
    let said = refusal(&little.bytes()).expect("a refusal");
    assert!(
        said.contains("face 0 is a patch of 2 by 2 control points"),
        "{said}"
    );
}

/// All faces over all edges, all leafs over all faces, or all rows from all places: what would take the square of its bytes
/// is refused by how much it would take.
#[test]
fn a_map_that_means_everything_many_times_is_refused_at_once() {
    const MANY: usize = 20_000;
    let start = Instant::now();
    let mut little = Little::new(Format::Bsp2);
    let face = little.lumps[7][..28].to_vec();
    little.lumps[13].resize(4 * MANY, 0);
    little.lumps[7] = face.repeat(MANY);
    for at in 0..MANY {
        little.lumps[7][28 * at + 8..][..8]
            .copy_from_slice(&[0i32.to_le_bytes(), (MANY as i32).to_le_bytes()].concat());
    }
    let said = refusal(&little.bytes()).expect("a refusal");
    assert!(
        said.contains("its faces would raise the memory needed to"),
        "{said}"
    );

    let mut little = Little::new(Format::Bsp2);
    let leaf = little.lumps[10][44..88].to_vec();
    little.lumps[11].resize(4 * MANY, 0);
    little.lumps[10] = leaf.repeat(MANY + 1);
    for at in 0..=MANY {
        little.lumps[10][44 * at + 32..][..8]
            .copy_from_slice(&[0i32.to_le_bytes(), (MANY as i32).to_le_bytes()].concat());
    }
    little.lumps[14][52..56].copy_from_slice(&(MANY as i32).to_le_bytes());
    let said = refusal(&little.bytes()).expect("a refusal");
    assert!(
        said.contains("its leafs' faces would raise the memory needed to"),
        "{said}"
    );

    let mut little = Little::new(Format::Bsp2);
    little.lumps[10] = leaf.repeat(MANY + 1);
    little.lumps[4] = vec![0b0101_0101; 2 * MANY];
    for at in 0..=MANY {
        little.lumps[10][44 * at + 4..][..4].copy_from_slice(&(at as i32).to_le_bytes());
        little.lumps[10][44 * at + 36..][..4].fill(0);
    }
    little.lumps[14][52..56].copy_from_slice(&(MANY as i32).to_le_bytes());
    let said = refusal(&little.bytes()).expect("a refusal");
    assert!(
        said.contains("its visibility data would raise the memory needed to"),
        "{said}"
    );
    assert!(start.elapsed() < PATIENCE, "{:?}", start.elapsed());
}
