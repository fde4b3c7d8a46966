//! Outputs replace files as a whole or not at all, and keep their mode; temporary files of dead runs are removed.
#![cfg(target_os = "linux")]

use crate::support::quake::Grid;
use crate::support::{Folder, Run};
use std::fs::{self, File};
use std::os::unix::fs::{MetadataExt, PermissionsExt, chown, symlink};
use std::process::{Command, Stdio};

const WORLD: &str = "[[part]]\nname = 'yard'\nfile = 'scene.glb'\n";

/// A folder with an input for every verb.
fn folder() -> Folder {
    let folder = Folder::new();
    folder.add("map.bsp", Grid::row(3).bsp());
    folder.add("map.prt", Grid::row(3).prt());
    folder.add(
        "carved.bsp",
        crate::carved::carved(&crate::carved::TWO_ROOMS).bytes(crate::carved::Format::Bsp2),
    );
    folder.add("world.toml", WORLD);
    folder
}

fn bytes(folder: &Folder, name: &str) -> Vec<u8> {
    fs::read(folder.path(name)).unwrap_or_else(|why| panic!("{name}: {why}"))
}

fn mode(folder: &Folder, name: &str) -> u32 {
    fs::metadata(folder.path(name)).expect("it is there").mode() & 0o7777
}

fn set_mode(folder: &Folder, name: &str, mode: u32) {
    fs::set_permissions(folder.path(name), fs::Permissions::from_mode(mode)).expect("set");
}

/// Runs with a file size limit of `blocks`, so that writes fail as on a full disk.
fn run_with_little_space(folder: &Folder, blocks: usize, arguments: &str) -> Run {
    let inner = folder.command(arguments);
    let output = Command::new("sh")
        .args([
            "-c",
            &format!("trap '' XFSZ; ulimit -f {blocks}; exec \"$@\""),
            "sh",
        ])
        .arg(inner.get_program())
        .args(inner.get_args())
        .current_dir(folder.path(""))
        .output();
    Run::from(output.expect("it starts"))
}

/// Every kind of output, and the name of the file.
const OUTPUTS: [(&str, &str); 10] = [
    ("draw scene.glb --size 64x36 -o old.png", "old.png"),
    ("look scene.glb --size 64x36 --json old.json", "old.json"),
    ("info scene.glb --json old.json", "old.json"),
    (
        "compare scene.glb --size 16x9 --method z-buffer -o old.html",
        "old.html",
    ),
    ("bake scene.glb -o old.enf", "old.enf"),
    ("choose scene.glb --size 16x9 -o old.glb", "old.glb"),
    ("link world.toml -o old.glb", "old.glb"),
    ("vis map.bsp -o old.bsp", "old.bsp"),
    ("vis map.bsp", "map.bsp"),
    ("portals carved.bsp --force -o old.prt", "old.prt"),
];

#[test]
fn on_a_full_disk_every_output_fails_and_leaves_what_was_there() {
    for (arguments, output) in OUTPUTS {
        let folder = folder();
        if output != "map.bsp" {
            folder.add(output, "old");
        }
        let (names, before) = (folder.names(), bytes(&folder, output));
        let run = run_with_little_space(&folder, 0, arguments);
        assert_eq!(run.code, Some(2), "{arguments}: {}{}", run.stdout, run.stderr);
        assert!(
            // A slow run of `vis` fails at its unfinished work, beside the map.
            run.stderr.contains(&format!("cannot write {output}")),
            "{arguments}: {}",
            run.stderr
        );
        assert_eq!(bytes(&folder, output), before, "{arguments}");
        assert_eq!(folder.names(), names, "{arguments}");
    }
}

#[test]
fn a_disk_that_is_full_at_any_block_of_a_picture_leaves_the_old_picture() {
    let folder = Folder::new();
    let draw = "draw scene.glb --size 320x180 -o a.png";
    assert_eq!(folder.run(draw).code, Some(0));
    let whole = bytes(&folder, "a.png");
    for blocks in 0.. {
        folder.add("a.png", "old");
        let run = run_with_little_space(&folder, blocks, draw);
        if run.code == Some(0) {
            assert!(blocks > 2, "the picture has several blocks");
            assert_eq!(bytes(&folder, "a.png"), whole, "{blocks} blocks");
            return;
        }
        assert_eq!(run.code, Some(2), "{}", run.stderr);
        assert_eq!(bytes(&folder, "a.png"), b"old", "{blocks} blocks");
    }
}

#[test]
fn a_full_device_is_an_error() {
    let folder = Folder::new();
    for name in ["full.png", "full.html", "full.json"] {
        symlink("/dev/full", folder.path(name)).expect("a link");
    }
    for (arguments, name) in [
        ("draw scene.glb --size 64x36 -o full.png", "full.png"),
        (
            "compare scene.glb --size 16x9 --method z-buffer -o full.html",
            "full.html",
        ),
        ("info scene.glb --json full.json", "full.json"),
        ("info scene.glb --json /dev/full", "/dev/full"),
    ] {
        let run = folder.run(arguments);
        assert_eq!(run.code, Some(2), "{arguments}: {}", run.stderr);
        assert!(
            run.stderr.contains(&format!("cannot write {name}: ")),
            "{}",
            run.stderr
        );
    }
    for arguments in [
        "info scene.glb",
        "info scene.glb --json -",
        "--help",
        "draw --help",
        "--version",
    ] {
        let full = File::options().write(true).open("/dev/full").expect("a device");
        let output = folder
            .command(arguments)
            .stdout(full)
            .output()
            .expect("it starts");
        let run = Run::from(output);
        assert_eq!(run.code, Some(2), "{arguments}: {}", run.stderr);
        assert!(
            run.stderr.contains("cannot write to standard output"),
            "{}",
            run.stderr
        );
    }
}

#[test]
fn a_link_to_standard_output_is_written_to_and_stays_a_link() {
    let folder = Folder::new();
    symlink("/dev/stdout", folder.path("out.json")).expect("a link");
    let run = folder.run("info scene.glb --json out.json");
    assert_eq!(run.code, Some(0), "{}", run.stderr);
    assert!(run.stdout.contains("\"triangles_drawn\""), "{}", run.stdout);
    assert!(folder.path("out.json").is_symlink());
}

#[test]
fn a_file_that_is_replaced_keeps_its_mode_and_owner() {
    let folder = folder();
    for (arguments, output) in OUTPUTS {
        if !folder.path(output).exists() {
            folder.add(output, "old");
        }
        for wanted in [0o600, 0o664, 0o755] {
            set_mode(&folder, output, wanted);
            // Only root may change the owner of a file.
            let is_given_away = chown(folder.path(output), Some(1234), Some(4321)).is_ok();
            let run = folder.run(arguments);
            assert_eq!(run.code, Some(0), "{arguments}: {}", run.stderr);
            assert_eq!(mode(&folder, output), wanted, "{arguments}");
            if is_given_away {
                let there = fs::metadata(folder.path(output)).expect("it is there");
                assert_eq!((there.uid(), there.gid()), (1234, 4321), "{arguments}");
            }
        }
    }
}

#[test]
fn a_new_file_gets_the_mode_that_the_system_gives_new_files() {
    let folder = Folder::new();
    folder.add("plain", "");
    assert_eq!(folder.run("draw scene.glb --size 64x36 -o a.png").code, Some(0));
    assert_eq!(mode(&folder, "a.png"), mode(&folder, "plain"));
}

#[test]
fn a_file_with_several_names_is_replaced_under_one_with_a_warning() {
    let folder = folder();
    fs::hard_link(folder.path("map.bsp"), folder.path("other.bsp")).expect("a link");
    let before = bytes(&folder, "map.bsp");
    let run = folder.run("vis map.bsp");
    assert_eq!(run.code, Some(0), "{}", run.stderr);
    assert!(
        run.stderr.contains("warning: map.bsp has 2 hard links"),
        "{}",
        run.stderr
    );
    assert_eq!(bytes(&folder, "other.bsp"), before);
    assert_ne!(bytes(&folder, "map.bsp"), before);
    assert_eq!(folder.run("vis map.bsp").complaints(), "", "it has one name now");
}

#[test]
fn a_link_is_followed_and_one_that_leads_nowhere_is_refused() {
    let folder = Folder::new();
    folder.add("there.png", "old");
    symlink("there.png", folder.path("a.png")).expect("a link");
    symlink("nothing.png", folder.path("b.png")).expect("a link");
    let names = folder.names();
    assert_eq!(folder.run("draw scene.glb --size 64x36 -o a.png").code, Some(0));
    assert!(folder.path("a.png").is_symlink());
    assert!(bytes(&folder, "there.png").starts_with(b"\x89PNG"));
    // The scene is missing too: an error about the output shows that the output is checked first.
    let run = folder.run("draw missing.glb --size 64x36 -o b.png");
    assert_eq!(run.code, Some(2));
    assert!(
        run.stderr
            .contains("cannot write b.png: it is a symbolic link to nothing.png"),
        "{}",
        run.stderr
    );
    assert_eq!(folder.names(), names);
}

#[test]
fn a_file_that_is_read_only_is_not_replaced() {
    let folder = Folder::new();
    folder.add("a.png", "old");
    set_mode(&folder, "a.png", 0o444);
    let run = folder.run("draw missing.glb -o a.png");
    assert_eq!(run.code, Some(2));
    assert!(
        run.stderr.contains("cannot write a.png: it is read-only"),
        "{}",
        run.stderr
    );
}

#[test]
fn a_name_as_long_as_names_can_be_is_written_to() {
    let name = |ending: &str| "n".repeat(254 - ending.len()) + ending;
    let folder = folder();
    let (picture, map, json) = (name(".png"), name(".bsp"), name(".json"));
    let draw = format!("draw scene.glb --size 64x36 -o {picture} --json {json}");
    let run = folder.run(&draw);
    assert_eq!(run.code, Some(0), "{}", run.stderr);
    folder.add(&map, Grid::row(9).bsp());
    folder.add("row.prt", Grid::row(9).prt());
    let vis = format!("vis {map} --prt row.prt --save-every 0");
    let run = folder.run(&format!("{vis} --seconds 0"));
    assert_eq!(run.code, Some(0), "{}", run.stderr);
    let run = folder.run(&format!("{vis} --resume"));
    assert_eq!(run.code, Some(0), "{}", run.stderr);
    let mut names = ["carved.bsp", "map.bsp", "map.prt", &map, &json, &picture]
        .map(str::to_owned)
        .to_vec();
    names.extend(["row.prt", "scene.glb", "views.jsonl", "world.toml"].map(str::to_owned));
    names.sort();
    let mut left = folder.names();
    let backup = left.iter().position(|name| name.ends_with(".bak"));
    left.remove(backup.expect("the old map is kept, by a shorter name"));
    assert_eq!(left, names, "nothing else is left behind");
    // The names of numbered pictures would be too long; that is refused before any is drawn.
    let run = folder.run(&format!("{draw} --survey 2"));
    assert_eq!(run.code, Some(2), "{}", run.stderr);
    assert!(
        run.stderr.contains("File name too long") && run.stdout.is_empty(),
        "{}",
        run.stderr
    );
}

#[test]
fn what_a_dead_run_left_is_removed_and_what_a_live_run_writes_is_not() {
    let folder = folder();
    let before = folder.names();
    folder.add(".enfilade-abcdefghijkl.tmp", "of a dead run");
    folder.add(".enfilade-mnopqrstuvwx.tmp", "of a live run");
    folder.add(".enfilade-notes.txt", "of the user");
    let live = File::open(folder.path(".enfilade-mnopqrstuvwx.tmp")).expect("it is there");
    live.lock().expect("locked");
    assert_eq!(folder.run("vis map.bsp --no-backup").code, Some(0));
    let mut left = vec![
        ".enfilade-mnopqrstuvwx.tmp".to_owned(),
        ".enfilade-notes.txt".to_owned(),
    ];
    left.extend(before.clone());
    assert_eq!(folder.names(), left);
    drop(live);
    assert_eq!(folder.run("vis map.bsp --no-backup").code, Some(0));
    assert_eq!(folder.names(), left[1..]);
}

#[test]
fn runs_side_by_side_write_one_map_and_leave_nothing() {
    let folder = Folder::empty();
    folder.add("map.bsp", Grid::row(9).bsp());
    folder.add("map.prt", Grid::row(9).prt());
    assert_eq!(folder.run("vis map.bsp -o whole.bsp").code, Some(0));
    let start = || {
        let mut command = folder.command("vis map.bsp --save-every 0 --threads 1");
        command
            .stdout(Stdio::null())
            .stderr(Stdio::piped())
            .spawn()
            .expect("it starts")
    };
    let runs: Vec<_> = std::iter::repeat_with(start).take(6).collect();
    for run in runs {
        let run = Run::from(run.wait_with_output().expect("it ends"));
        assert_eq!(run.code, Some(0), "{}", run.stderr);
    }
    assert_eq!(bytes(&folder, "map.bsp"), bytes(&folder, "whole.bsp"));
    assert_eq!(
        bytes(&folder, "map.bsp.bak"),
        Grid::row(9).bsp(),
        "none keeps what another has written"
    );
    assert_eq!(folder.names(), ["map.bsp", "map.bsp.bak", "map.prt", "whole.bsp"]);
}

#[test]
fn saved_work_of_a_live_run_is_neither_replaced_nor_removed_nor_used() {
    let folder = Folder::empty();
    folder.add("map.bsp", Grid::row(9).bsp());
    folder.add("map.prt", Grid::row(9).prt());
    folder.add("map.bsp.vis-unfinished", "how far a live run is");
    let live = File::open(folder.path("map.bsp.vis-unfinished")).expect("it is there");
    live.lock().expect("locked");
    for options in ["", "--resume", "--seconds 0"] {
        let run = folder.run(&format!("vis map.bsp --save-every 0 {options}"));
        assert_eq!(run.code, Some(0), "{}", run.stderr);
        assert!(
            run.stderr
                .contains("map.bsp.vis-unfinished belongs to a run in progress"),
            "{}",
            run.stderr
        );
        assert!(!run.stdout.contains("--resume continues"), "{}", run.stdout);
        assert_eq!(bytes(&folder, "map.bsp.vis-unfinished"), b"how far a live run is");
    }
    drop(live);
    assert_eq!(folder.run("vis map.bsp").code, Some(0));
    assert_eq!(folder.names(), ["map.bsp", "map.bsp.bak", "map.prt"]);
}
