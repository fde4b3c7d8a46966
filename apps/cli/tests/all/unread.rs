//! Inputs that are not files, or too large, are refused before they are read; names need not be UTF-8.
#![cfg(target_os = "linux")]

use crate::support::quake::Grid;
use crate::support::{Folder, Run, glb, yard};
use serde_json::json;
use std::ffi::OsStr;
use std::fs::{self, File};
use std::os::unix::ffi::OsStrExt;
use std::os::unix::fs::symlink;
use std::path::Path;
use std::process::Command;

/// Creates a pipe. A program that opens it reads nothing and continues, so that the test fails instead of hanging.
fn pipe(folder: &Folder, name: &str) {
    let path = folder.path(name);
    let made = Command::new("mkfifo").arg(&path).status().expect("mkfifo");
    assert!(made.success());
    std::thread::spawn(move || while File::options().write(true).open(&path).is_ok() {});
}

/// Runs with 4 GB of address space, so that a program that reads without limit fails without harming others.
fn run_with_little_memory(folder: &Folder, arguments: &str) -> Run {
    let inner = folder.command(arguments);
    let output = Command::new("sh")
        .args(["-c", "ulimit -v 4000000; exec \"$@\"", "sh"])
        .arg(inner.get_program())
        .args(inner.get_args())
        .current_dir(folder.path(""))
        .output();
    Run::from(output.expect("it starts"))
}

#[track_caller]
fn refused(folder: &Folder, arguments: &str, words: &[&str]) {
    let run = run_with_little_memory(folder, arguments);
    assert_eq!(run.code, Some(2), "{arguments}: {}{}", run.stdout, run.stderr);
    for word in words {
        assert!(
            run.stderr.contains(word),
            "{arguments} does not say `{word}`: {}",
            run.stderr
        );
    }
}

#[test]
fn pipes_and_devices_are_refused_wherever_a_file_is_read() {
    let folder = Folder::new();
    folder.add("map.bsp", Grid::row(3).bsp());
    folder.add("map.prt", Grid::row(3).prt());
    symlink("/dev/zero", folder.path("zero")).expect("a link");
    pipe(&folder, "pipe");
    for kind in ["pipe", "zero"] {
        for ending in ["toml", "jsonl", "bsp", "prt", "glb", "obj"] {
            symlink(kind, folder.path(&format!("{kind}.{ending}"))).expect("a link");
        }
        folder.add(
            &format!("{kind}-world.toml"),
            format!("[[part]]\nname = 'a'\nfile = '{kind}.glb'\n"),
        );
        for (arguments, ending) in [
            ("link KIND.toml -o a.glb", "toml"),
            ("link KIND-world.toml -o a.glb", "glb"),
            ("look scene.glb --path KIND.jsonl", "jsonl"),
            ("look KIND.glb", "glb"),
            ("look KIND.obj", "obj"),
            ("info KIND.bsp", "bsp"),
            ("vis KIND.bsp --prt map.prt", "bsp"),
            ("vis map.bsp --prt KIND.prt", "prt"),
            ("vis map.bsp -o a.bsp --compare KIND.bsp", "bsp"),
            ("portals KIND.bsp -o a.prt", "bsp"),
        ] {
            let arguments = arguments.replace("KIND", kind);
            let file = format!("{kind}.{ending}");
            refused(
                &folder,
                &arguments,
                &[&file, "is not a file, but a folder, a pipe or a device"],
            );
        }
        symlink(kind, folder.path("map.bsp.vis-unfinished")).expect("a link");
        refused(
            &folder,
            "vis map.bsp --resume",
            &["map.bsp.vis-unfinished", "is not a file"],
        );
        fs::remove_file(folder.path("map.bsp.vis-unfinished")).expect("removed");
    }
}

#[test]
fn files_of_six_gigabytes_are_refused_by_a_limit_that_is_named() {
    let folder = Folder::new();
    folder.add("map.bsp", Grid::row(3).bsp());
    folder.add("map.prt", Grid::row(3).prt());
    for name in [
        "big.toml",
        "big.jsonl",
        "big.bsp",
        "big.prt",
        "map.bsp.vis-unfinished",
    ] {
        let file = File::create(folder.path(name)).expect("a file");
        file.set_len(6 << 30).expect("sparse");
    }
    for (arguments, file, limit) in [
        ("link big.toml -o a.glb", "big.toml", "limit of 1.0 MB"),
        ("look scene.glb --path big.jsonl", "big.jsonl", "limit of 67.1 MB"),
        ("look big.bsp", "big.bsp", "limit"),
        ("vis big.bsp --prt map.prt", "big.bsp", "--memory"),
        ("vis map.bsp --prt big.prt", "big.prt", "limit"),
        ("vis map.bsp -o a.bsp --compare big.bsp", "big.bsp", "limit"),
        ("vis map.bsp --resume", "map.bsp.vis-unfinished", "limit"),
        ("portals big.bsp -o a.prt", "big.bsp", "limit"),
    ] {
        refused(&folder, arguments, &[file, limit]);
    }
}

#[test]
fn a_path_with_a_line_as_long_as_a_book_is_refused_by_its_line() {
    let folder = Folder::new();
    let views = fs::read_to_string(folder.path("views.jsonl")).expect("views");
    let long = format!("{views}{{\"eye\":[{}0]}}", "0,".repeat(1 << 20));
    folder.add("long.jsonl", long);
    refused(
        &folder,
        "look scene.glb --path long.jsonl",
        &["long.jsonl, line 4", "65536 bytes"],
    );
}

#[test]
fn a_world_of_more_parts_than_memory_holds_is_refused_at_the_part_that_is_too_much() {
    let folder = Folder::new();
    let mut document = yard();
    // A megabyte that nothing uses.
    document["buffers"][0]["byteLength"] = json!(132 + (1 << 20));
    let mut large = glb(&document);
    large.extend(vec![0; 1 << 20]);
    let length = (large.len() as u32).to_le_bytes();
    large[8..12].copy_from_slice(&length);
    let json_length = u32::from_le_bytes(large[12..16].try_into().expect("four bytes")) as usize;
    let chunk = (132 + (1_u32 << 20)).to_le_bytes();
    large[20 + json_length..][..4].copy_from_slice(&chunk);
    folder.add("large.glb", large);
    let part = |number| format!("[[part]]\nname = 'p{number}'\nfile = 'large.glb'\n");
    folder.add("world.toml", (0..40).map(part).collect::<String>());
    refused(
        &folder,
        "link world.toml -o a.glb --memory 8MB",
        &["[[part]] \"p", "limit of 8 MB"],
    );
}

#[test]
fn scenes_have_names_that_are_not_utf_8() {
    let folder = Folder::new();
    let name = OsStr::from_bytes(b"sc\xFFne.glb");
    let path = |name: &OsStr| folder.path("").join(Path::new(name));
    fs::rename(folder.path("scene.glb"), path(name)).expect("renamed");
    let with = |before: &str, name: &OsStr, after: &str| {
        let mut command = folder.command(before);
        let output = command.arg(name).args(after.split_whitespace()).output();
        Run::from(output.expect("it starts"))
    };
    for (verb, options) in [
        ("look", "--size 64x36 --json -"),
        ("info", "--json -"),
        ("draw", "--size 64x36 -o a.png --json -"),
        ("compare", "--size 16x9 --method z-buffer -o a.html --json -"),
        ("bench", "--size 16x9 --survey 1 --method z-buffer --json -"),
        ("choose", "--size 16x9 -o pinned.glb --json -"),
    ] {
        let run = with(verb, name, options);
        assert_eq!(run.code, Some(0), "{verb}: {}", run.stderr);
        assert!(run.stdout.contains("sc\u{FFFD}ne.glb"), "{verb}: {}", run.stdout);
    }
    // A description finds the heights of the same name.
    let valley =
        json!({ "width": 2, "height": 2, "format": "u16 little endian", "cellMetresX": 1, "cellMetresZ": 1 });
    fs::write(path(OsStr::from_bytes(b"\xFE.json")), valley.to_string()).expect("written");
    fs::write(path(OsStr::from_bytes(b"\xFE.raw")), [0; 8]).expect("written");
    fs::write(path(OsStr::from_bytes(b"\xFF.raw")), [0; 9]).expect("written");
    let run = with("info", OsStr::from_bytes(b"\xFE.json"), "");
    assert_eq!(run.code, Some(0), "{}", run.stderr);
    // Side files are found beside a name that is not UTF-8, and protected.
    fs::write(path(OsStr::from_bytes(b"c\xFF.bsp")), Grid::row(3).bsp()).expect("written");
    fs::write(path(OsStr::from_bytes(b"c\xFF.prt")), Grid::row(3).prt()).expect("written");
    let run = with("vis", OsStr::from_bytes(b"c\xFF.bsp"), "--json -");
    assert_eq!(run.code, Some(0), "{}", run.stderr);
    // Errors read as for any other name.
    let run = with("look", OsStr::from_bytes(b"n\xFFne.glb"), "");
    assert!(
        run.code == Some(2) && run.stderr.contains("n\u{FFFD}ne.glb"),
        "{}",
        run.stderr
    );
    let run = with("look", OsStr::from_bytes(b"@\xFF"), "");
    assert!(
        run.code == Some(2) && run.stderr.contains("no built-in scene"),
        "{}",
        run.stderr
    );
    let run = with("", name, "");
    assert!(
        run.code == Some(2) && run.stderr.contains("enfilade look"),
        "{}",
        run.stderr
    );
}
