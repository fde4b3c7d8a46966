//! `--scene` and `--lenient`: which scene of a glTF file is read, and what it may require.

use crate::support::{Folder, glb, yard};
use serde_json::{Value, json};

/// Asserts that a run fails with one error that contains every word.
fn refused(folder: &Folder, arguments: &str, words: &[&str]) {
    let run = folder.run(arguments);
    assert_eq!(
        (run.code, &*run.stdout),
        (Some(2), ""),
        "{arguments}: {}",
        run.stderr
    );
    for word in words {
        assert!(run.stderr.contains(word), "{arguments}: {}", run.stderr);
    }
}

/// The yard in a scene "Day", and only its camera in the default scene "Night".
fn two_scenes() -> Value {
    let mut file = yard();
    let all = file["scenes"][0]["nodes"].clone();
    file["scenes"] = json!([{ "name": "Day", "nodes": all }, { "name": "Night", "nodes": [] }]);
    file["scene"] = json!(1);
    file
}

#[test]
fn a_scene_is_chosen_by_name_or_index_and_info_lists_all() {
    let folder = Folder::new();
    folder.add("two.glb", glb(&two_scenes()));
    assert_eq!(folder.json("info two.glb")["items"], 0);
    for choice in ["Day", "0"] {
        let info = folder.json(&format!("info two.glb --scene {choice}"));
        assert!(info["items"].as_u64() > Some(0), "{info}");
        assert_eq!(
            info["scenes"],
            json!([
                { "name": "Day", "is_default": false, "is_read": true },
                { "name": "Night", "is_default": true, "is_read": false }
            ])
        );
    }
    let text = folder.run("info two.glb --scene Day").stdout;
    for line in ["0 \"Day\": read here", "1 \"Night\": default"] {
        assert!(text.contains(line), "{text}");
    }
    for verb in [
        "look two.glb --size 64x36",
        "draw two.glb -o a.png --size 64x36",
        "bake two.glb -o a.enf",
    ] {
        let run = folder.run(&format!("{verb} --scene Day"));
        assert_eq!(run.code, Some(0), "{verb}: {}", run.stderr);
    }
    let words = ["no scene `Dai`", "0 \"Day\", 1 \"Night\"", "did you mean Day?"];
    refused(&folder, "info two.glb --scene Dai", &words);
    refused(
        &folder,
        "info @two-rooms --scene Day",
        &["no scenes to choose from", "--scene"],
    );
}

#[test]
fn a_file_that_requires_an_unknown_extension_is_read_if_that_is_wanted() {
    let folder = Folder::new();
    let mut file = yard();
    file["extensionsUsed"] = json!(["ACME_melt"]);
    file["extensionsRequired"] = json!(["ACME_melt"]);
    folder.add("melt.glb", glb(&file));
    refused(&folder, "info melt.glb", &["ACME_melt", "--lenient"]);
    let info = folder.json("info melt.glb --lenient");
    assert!(info["items"].as_u64() > Some(0), "{info}");
}
