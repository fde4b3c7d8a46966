//! Files made to do harm: they may be refused, but never take the program down, or its memory, or its time.

use super::file::{numbers, read_among, refusal};
use enfilade_import::{BrokenRule, ReadOptions, read_bytes};
use std::time::{Duration, Instant};

/// Long enough for a busy machine, and far too short for anything that grows with the square.
const PATIENCE: Duration = Duration::from_secs(20);

/// A file that has a bit of everything.
const HOUSE: &str = "# a house\nmtllib house.mtl\no Hall\nv 0 0 0 1 0 0\nv 4 0 0\nv 4 3 0.5\nv 2 1 0\nv 0 3 0\nvt 0 0\n\
                     vt 1 0\nvt 1 1\nvn 0 0 1\ns 1\nusemtl oak\nf 1/1/1 2/2/1 3/3/1 4 5\nf -1 -2 -3 -4\ng Roof b\ns off\n\
                     usemtl slate\nf 1//1 2//1 \\\n 3//1\nl 1 2\np 1\ng Hall\nusemtl glass\nf 1 3 2 5 4\n";
const MATERIALS: &str = "newmtl oak\nKd 0.5 0.4 0.3\nmap_Kd -s 2 2 2 -o 0 0 0 -clamp on oak.png\nmap_d oak.png\n\
                         newmtl slate\nKd 0.1 0.1 0.1\nKe 1 1 1\nillum 2\nnewmtl glass\nd 0.5\nTr 0.5\nmap_Ke -mm 0 1 a b.png\n";

/// Reads both, one of them spoilt; says whether the OBJ was refused.
fn refused(house: &[u8], materials: &[u8]) -> bool {
    let files = [("house.obj", house), ("house.mtl", materials)];
    read_among(&files, &ReadOptions::default()).is_err()
}

#[test]
fn files_with_a_byte_wrong_are_read_or_refused() {
    let mut number = numbers(3);
    let (mut read, mut no) = (0, 0);
    for round in 0..3000 {
        let mut house = HOUSE.as_bytes().to_vec();
        let mut materials = MATERIALS.as_bytes().to_vec();
        let spoilt = if round % 2 == 0 {
            &mut house
        } else {
            &mut materials
        };
        for _ in 0..1 + number(3) {
            let at = number(spoilt.len());
            match number(4) {
                0 => spoilt[at] ^= 1 << number(8),
                1 => spoilt[at] = b" \n\\/-#9.0"[number(9)],
                2 if spoilt.len() > 1 => drop(spoilt.remove(at)),
                _ => spoilt.truncate(at.max(1)),
            }
        }
        if refused(&house, &materials) {
            no += 1
        } else {
            read += 1
        }
    }
    assert!(read > 500 && no > 100, "{read} read, {no} refused");
}

#[test]
fn files_with_a_word_wrong_are_read_or_refused() {
    let words = [
        "0",
        "-1",
        "-99999999999999999999",
        "1e38",
        "-1e38",
        "nan",
        "inf",
        "9/9/9",
        "1/",
        "//",
        "f",
        "v",
        "o",
        "usemtl",
        "\\",
        "#",
        "\"",
        "-clamp",
        "-s",
        "4294967296",
        "2147483648",
        "\u{e4}",
        "..",
        "C:\\",
    ];
    let mut number = numbers(8);
    let (mut read, mut no) = (0, 0);
    for round in 0..3000 {
        let source = if round % 4 == 3 { MATERIALS } else { HOUSE };
        let at = number(source.split(' ').count());
        let spoilt: Vec<&str> = source
            .split(' ')
            .enumerate()
            .map(|(place, word)| {
                if place == at {
                    words[number(words.len())]
                } else {
                    word
                }
            })
            .collect();
        let spoilt = spoilt.join(" ");
        let (house, materials) = if round % 4 == 3 {
            (HOUSE, &*spoilt)
        } else {
            (&*spoilt, MATERIALS)
        };
        if refused(house.as_bytes(), materials.as_bytes()) {
            no += 1
        } else {
            read += 1
        }
    }
    assert!(read > 500 && no > 500, "{read} read, {no} refused");
}

#[test]
fn noise_is_read_or_refused() {
    let mut number = numbers(21);
    for round in 0..2000 {
        let letters: &[u8] = if round % 2 == 0 {
            b"vfogtn 0123456789.-/\\\r\n#e"
        } else {
            b""
        };
        let length = number(400);
        let mut noise: Vec<u8> = (0..length)
            .map(|_| match letters {
                [] => number(256) as u8,
                letters => letters[number(letters.len())],
            })
            .collect();
        noise.splice(0..0, *b"v 0 0 0\nv 1 0 0\nv 0 1 0\n");
        refusal(&noise);
        refused(&noise[8..], &noise);
        refused(HOUSE.as_bytes(), &noise);
    }
}

#[test]
fn random_faces_over_few_positions_are_cut_or_refused() {
    let mut number = numbers(4);
    for _ in 0..3000 {
        let mut text = String::new();
        let positions = 1 + number(9);
        for _ in 0..positions {
            let value = [0.0, -0.0, 1.0, 2.0, -1.0, 0.5, 1e-40, 3e38, -3e38, 1.000_000_1];
            let most = if number(9) == 0 { 10 } else { 6 };
            let [x, y, z] = [0; 3].map(|_| value[number(most)]);
            text += &format!("v {x:e} {y:e} {z:e}\n");
        }
        for _ in 0..4 {
            text += "s 1\nf";
            for _ in 0..3 + number(12) {
                text += &format!(" {}", 1 + number(positions));
            }
            text += "\n";
        }
        if let Some(said) = refusal(text.as_bytes()) {
            let is_meant = said.contains("not finite") || said.contains("farther out");
            assert!(is_meant, "{said}\n{text}");
        }
    }
}

#[test]
fn memory_is_asked_for_before_it_is_taken() {
    let limit = |limit_bytes| ReadOptions {
        limit_bytes,
        ..ReadOptions::default()
    };
    let positions = "v 0 0 0\n".repeat(10_000);
    let corners = format!("v 0 0 0\nf{}", " 1".repeat(40_000));
    let groups = "g a\nf 1 1 1\n".repeat(8_000) + "v 0 0 0";
    let marks = "usemtl a\n".repeat(9_000) + "v 0 0 0";
    let comment = format!("v 0 0 0\n#{}", "x".repeat(80_000));
    for (what, text, fits) in [
        ("positions", positions, false),
        ("corners", corners, false),
        ("groups", groups, false),
        ("marks", marks, false),
        ("a comment", comment, true),
    ] {
        let text = format!("v 0 0 0\n{text}");
        let read = read_bytes(text.as_bytes(), None, &limit(text.len() as u64 + 100_000));
        match read {
            Ok(_) => assert!(fits, "{what}"),
            Err(error) => {
                assert!(
                    !fits && matches!(error.rule, BrokenRule::TooLarge { .. }),
                    "{what}: {error}"
                );
            }
        }
        assert!(
            read_bytes(text.as_bytes(), None, &limit(50 << 20)).is_ok(),
            "{what}"
        );
        assert!(read_bytes(text.as_bytes(), None, &limit(100)).is_err(), "{what}");
    }
}

#[test]
fn nothing_takes_longer_than_the_file_is_long() {
    let many = 300_000;
    let one_position = format!(
        "v 0 0 0\n{}f{}",
        "vt 0 0\n".repeat(many),
        (1..=many).map(|n| format!(" 1/{n}")).collect::<String>()
    );
    for (what, text) in [
        ("one position with many texture coordinates", one_position),
        (
            "empty lines after a backslash",
            format!("v 0 0 0 \\{}", "\n".repeat(2_000_000)),
        ),
        (
            "a line that goes on and on",
            format!("v 0 0 0\nf{}", " 1\\\n".repeat(many)),
        ),
        (
            "names",
            (0..many).map(|n| format!("o {n}\n")).collect::<String>() + "v 0 0 0",
        ),
        (
            "materials",
            (0..many).map(|n| format!("usemtl {n}\n")).collect::<String>() + "v 0 0 0",
        ),
        ("words", format!("v 0 0 0\no{}", " a".repeat(1_000_000))),
        ("files", format!("v 0 0 0\nmtllib{}", " a.mtl".repeat(many))),
        (
            "one name",
            "v 0 0 0\n".to_owned() + &"g a\nf 1 1 1\ng b\nf 1 1 1\n".repeat(30_000),
        ),
        ("smooth", "v 0 0 0\ns 1\n".to_owned() + &"f 1 1 1\n".repeat(many)),
    ] {
        let start = Instant::now();
        refusal(text.as_bytes());
        assert!(start.elapsed() < PATIENCE, "{what}: {:?}", start.elapsed());
    }
}
