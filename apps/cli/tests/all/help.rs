//! Every help ends with examples, and every example runs.

use crate::carved::{Format, TWO_ROOMS, carved};
use crate::support::Folder;
use crate::support::quake::Grid;
use enfilade::Method;

/// The examples of a verb's help.
fn examples(folder: &Folder, verb: &str) -> Vec<String> {
    let help = folder.run(&format!("{verb} --help"));
    assert_eq!(help.code, Some(0), "{}", help.stderr);
    let (_, examples) = help
        .stdout
        .split_once("\nExamples:\n")
        .expect("examples at the end");
    examples
        .lines()
        .map(|line| {
            line.trim()
                .strip_prefix("enfilade")
                .expect("a command")
                .to_owned()
        })
        .collect()
}

fn examples_run(verb: &str) {
    examples_run_in(&Folder::new(), verb);
}

fn examples_run_in(folder: &Folder, verb: &str) {
    let examples = examples(folder, verb);
    assert!(!examples.is_empty());
    for example in examples {
        let run = folder.run(&example);
        assert_eq!(run.code, Some(0), "enfilade{example}: {}", run.stderr);
        assert_eq!(run.complaints(), "", "enfilade{example}");
        assert!(!run.stdout.is_empty(), "enfilade{example}");
    }
}

#[test]
fn the_examples_of_the_program_run() {
    examples_run("");
}

#[test]
fn the_examples_of_draw_run() {
    examples_run("draw");
}

#[test]
fn the_examples_of_look_run() {
    examples_run("look");
}

#[test]
fn the_examples_of_rooms_run() {
    examples_run("rooms");
}

#[test]
fn the_examples_of_compare_run() {
    examples_run("compare");
}

#[test]
fn the_examples_of_bench_run() {
    examples_run("bench");
}

#[test]
fn the_examples_of_link_run() {
    let folder = Folder::new();
    folder.add(
        "world.toml",
        "[[part]]\nname = 'yard'\nfile = 'scene.glb'\n[[part]]\nname = 'other'\nfile = 'scene.glb'\ntranslation = [40, 0, 0]",
    );
    examples_run_in(&folder, "link");
}

#[test]
fn the_examples_of_portals_run() {
    let folder = Folder::new();
    folder.add("map.bsp", carved(&TWO_ROOMS).bytes(Format::Bsp29));
    examples_run_in(&folder, "portals");
}

#[test]
fn the_examples_of_vis_run() {
    let folder = Folder::new();
    let grid = Grid::row(3);
    folder.add("map.bsp", grid.bsp());
    folder.add("map.prt", grid.prt());
    folder.add("other-name.prt", grid.prt());
    assert_eq!(folder.run("vis map.bsp -o shipped.bsp").code, Some(0));
    examples_run_in(&folder, "vis");
}

#[test]
fn the_examples_of_info_run() {
    let folder = Folder::new();
    folder.add("scene.obj", "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3");
    folder.add("map.bsp", crate::support::map::map(true));
    examples_run_in(&folder, "info");
}

#[test]
fn the_examples_of_bake_run() {
    let folder = Folder::new();
    folder.add("map.bsp", crate::support::map::map(true));
    examples_run_in(&folder, "bake");
}

#[test]
fn the_examples_of_hints_run() {
    let folder = Folder::new();
    folder.json("bake scene.glb -o town.enf");
    examples_run_in(&folder, "hints");
}

#[test]
fn no_line_of_a_help_ends_before_it_is_full_but_where_a_paragraph_does() {
    let folder = Folder::new();
    for verb in [
        "draw", "look", "compare", "bench", "link", "vis", "portals", "bake", "hints", "info",
    ] {
        let help = folder.run(&format!("help {verb}")).stdout;
        let (before, _) = help.split_once("\nExamples:\n").expect("examples at the end");
        let last = before.trim_end().rsplit("\n\n").next().expect("a paragraph");
        let width = help.lines().map(str::len).max().unwrap_or(0).min(100);
        let lines: Vec<&str> = last.lines().collect();
        for pair in lines.windows(2) {
            let word = pair[1].split(' ').next().unwrap_or("").len();
            let ends = pair[0].ends_with(['.', ':']) || pair[1].starts_with(' ');
            assert!(ends || pair[0].len() + 1 + word > width, "{verb}: {last}");
        }
    }
}

#[test]
fn without_a_verb_there_is_a_picture_a_table_of_all_methods_and_what_to_try_next() {
    let folder = Folder::new();
    let run = folder.run("");
    assert_eq!(run.code, Some(0), "{}", run.stderr);
    let methods = Method::ALL.map(Method::name);
    for word in methods
        .iter()
        .chain(&["enfilade.png", "Try next", "enfilade look"])
    {
        assert!(run.stdout.contains(word), "{}", run.stdout);
    }
    let picture = std::fs::read(folder.path("enfilade.png")).expect("a picture");
    assert!(picture.starts_with(b"\x89PNG"));
}

#[test]
fn a_reader_that_goes_away_is_no_panic() {
    let folder = Folder::new();
    for arguments in [
        "--help",
        "info scene.glb",
        "look scene.glb --json - --size 64x36",
        "look scene.glb --size 64x36",
    ] {
        let run = folder.run_unread(arguments);
        assert_eq!((run.code, run.stderr.as_str()), (Some(0), ""), "{arguments}");
    }
}
