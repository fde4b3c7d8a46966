//! `portals`: rebuilds a lost .prt, and never overwrites an existing one unasked.

use crate::carved::{Format, TWO_ROOMS, carved};
use crate::support::Folder;
use serde_json::json;
use std::path::Path;

fn with_map(format: Format) -> Folder {
    let folder = Folder::new();
    folder.add("map.bsp", carved(&TWO_ROOMS).bytes(format));
    folder
}

fn text(folder: &Folder, name: &str) -> String {
    std::fs::read_to_string(folder.path(name)).expect("text")
}

#[track_caller]
fn refused(folder: &Folder, arguments: &str, words: &[&str]) {
    let before = folder.names();
    let run = folder.run(arguments);
    assert_eq!(run.code, Some(2), "{arguments}: {}{}", run.stdout, run.stderr);
    assert_eq!(folder.names(), before, "{arguments}");
    assert_eq!(run.stdout, "");
    for word in words {
        assert!(
            run.stderr.contains(word),
            "`{}` does not say `{word}`",
            run.stderr
        );
    }
}

#[test]
fn a_lost_prt_stands_beside_its_map_again() {
    for (format, beginning) in [
        (Format::Bsp29, "PRT1\n3\n2\n4 "),
        (Format::Bsp2, "PRT1\n3\n2\n4 "),
        (Format::Ibsp46, "PRT1\n3\n2\n0\n4 "),
    ] {
        let folder = with_map(format);
        let before = std::fs::read(folder.path("map.bsp")).expect("a map");
        let run = folder.run("portals map.bsp");
        assert_eq!((run.code, run.stderr.as_str()), (Some(0), ""));
        assert!(run.stdout.starts_with("map.prt: PRT1"), "{}", run.stdout);
        assert!(
            run.stdout.contains("3 leafs, 3 clusters, 2 portals"),
            "{}",
            run.stdout
        );
        assert!(text(&folder, "map.prt").starts_with(beginning));
        assert_eq!(std::fs::read(folder.path("map.bsp")).expect("a map"), before);
    }
}

#[test]
fn a_map_without_vis_in_its_name_has_the_prt_of_the_map() {
    let folder = with_map(Format::Bsp2);
    std::fs::rename(folder.path("map.bsp"), folder.path("map.novis.bsp")).expect("renamed");
    let made = folder.json("portals map.novis.bsp");
    assert_eq!(made["file"], "map.prt");
    assert!(folder.path("map.prt").exists());
}

#[test]
fn the_report_says_what_was_made_and_of_what() {
    let folder = with_map(Format::Bsp29);
    let mut made = folder.json("portals map.bsp -o other.prt");
    assert!(made["seconds"].as_f64().is_some_and(|seconds| seconds >= 0.0));
    made["seconds"] = json!(0);
    assert_eq!(
        made,
        json!({
            "file": "other.prt", "bytes": text(&folder, "other.prt").len(), "map": "map.bsp", "kind": "PRT1",
            "clusters_from": "leafs", "leafs": 3, "clusters": 3, "portals": 2, "slivers": 0, "seconds": 0
        })
    );
    assert!(!folder.path("map.prt").exists());
}

#[test]
fn a_prt_that_is_there_is_never_lost() {
    let folder = with_map(Format::Bsp29);
    folder.add("map.prt", "the only one");
    refused(&folder, "portals map.bsp", &["map.prt", "-o", "--force"]);
    refused(
        &folder,
        "portals map.bsp -o map.prt",
        &["map.prt", "-o", "--force"],
    );
    assert_eq!(text(&folder, "map.prt"), "the only one");
    // --force keeps it too if the portals cannot be rebuilt.
    folder.add("broken.bsp", "no map");
    refused(
        &folder,
        "portals broken.bsp -o map.prt --force",
        &["broken.bsp", "not a compiled map"],
    );
    assert_eq!(text(&folder, "map.prt"), "the only one");
    assert_eq!(folder.run("portals map.bsp --force").code, Some(0));
    assert!(text(&folder, "map.prt").starts_with("PRT1"));
}

#[test]
fn what_cannot_be_done_is_said_and_leaves_nothing() {
    let folder = with_map(Format::Bsp29);
    folder.add("cut.bsp", &carved(&TWO_ROOMS).bytes(Format::Bsp29)[..200]);
    refused(&folder, "portals nowhere.bsp", &["nowhere.bsp", "cannot be read"]);
    refused(
        &folder,
        "portals scene.glb",
        &["scene.glb", "not a compiled map", "BSP29"],
    );
    refused(&folder, "portals cut.bsp", &["cut.bsp", "is damaged", "compile"]);
    refused(
        &folder,
        "portals map.bsp -o map.bsp --force",
        &["map.bsp", ".prt"],
    );
    refused(&folder, "portals map.bsp -o no/map.prt", &["there is no folder"]);
    refused(&folder, "portals map.bsp --focre", &["--focre", "--force"]);
    refused(&folder, "portals map.bsp --memory 1000", &["map.bsp", "limit"]);
    refused(&folder, "portals", &["MAP.bsp"]);
    refused(&folder, "portals .", &["."]);
}

#[cfg(unix)]
#[test]
fn a_folder_that_may_not_be_written_is_said_before_the_work() {
    use std::os::unix::fs::PermissionsExt;
    let folder = with_map(Format::Bsp29);
    std::fs::create_dir(folder.path("locked")).expect("a folder");
    let mode = |mode| {
        let permissions = std::fs::Permissions::from_mode(mode);
        std::fs::set_permissions(folder.path("locked"), permissions).expect("changed");
    };
    mode(0o555);
    // Permissions do not stop root.
    let is_locked = std::fs::write(folder.path("locked/probe"), "").is_err();
    if is_locked {
        refused(
            &folder,
            "portals map.bsp -o locked/map.prt",
            &["cannot write", "locked"],
        );
    }
    mode(0o755);
}

#[test]
#[ignore = "needs ENFILADE_MAPS"]
fn real_maps_have_the_clusters_of_their_lost_prt() {
    let maps = std::env::var_os("ENFILADE_MAPS").expect("ENFILADE_MAPS names a folder");
    let maps = Path::new(&maps);
    for (map, from, clusters, portals) in [
        ("quake/dm1.bsp", "leafs", 415, 990),
        ("quake3/darkzone.novis.bsp", "map", 534, 1512),
    ] {
        let folder = Folder::new();
        folder.add("map.bsp", std::fs::read(maps.join(map)).expect("a map"));
        let made = folder.json("portals map.bsp");
        assert_eq!(made["clusters_from"], from);
        assert_eq!(
            (&made["clusters"], &made["portals"]),
            (&json!(clusters), &json!(portals)),
            "{map}"
        );
        assert!(made["seconds"].as_f64().is_some_and(|seconds| seconds < 10.0));
    }
}
