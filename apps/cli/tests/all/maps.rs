//! Compiled maps work with every verb that reads a scene.

use crate::support::Folder;
use crate::support::map::map;

#[test]
fn info_says_what_is_in_a_map_and_how_much_a_leaf_sees() {
    let folder = Folder::new();
    folder.add("baked.bsp", map(true));
    folder.add("plain.bsp", map(false));
    let said = folder.run("info baked.bsp").stdout;
    for line in [
        "baked.bsp: BSP2, a map of Quake",
        "map        1 leaf, 1 face, 1 model, 2 entities",
        "visible    100.0 % of the map from a leaf, in 1 byte",
        "camera     info_player_start: from 0, 0, 0",
    ] {
        assert!(said.contains(line), "{line} is not in\n{said}");
    }
    let said = folder.run("info plain.bsp").stdout;
    assert!(said.contains("visible    not computed"), "{said}");
    let info = folder.json("info plain.bsp");
    assert_eq!(info["map"]["format"], "BSP2");
    assert_eq!(info["map"]["leafs"], 1);
    assert!(info["map"]["visible_share"].is_null());
}

#[test]
fn a_map_is_looked_at_from_its_start_and_through_its_cells() {
    let folder = Folder::new();
    folder.add("baked.bsp", map(true));
    folder.add("plain.bsp", map(false));
    for method in ["z-buffer", "pvs"] {
        let look = folder.json(&format!("look baked.bsp --method {method} --size 64x48"));
        assert_eq!(look["views"][0]["visible"][0], "leaf 1", "{method}");
    }
    let refused = folder.run("draw plain.bsp -o plain.png --method pvs");
    assert_eq!(refused.code, Some(2), "{}", refused.stderr);
    assert!(refused.stderr.contains("plain.bsp"), "{}", refused.stderr);
}

#[test]
fn a_map_that_is_cut_short_is_refused_by_name_and_with_a_remedy() {
    let folder = Folder::new();
    let whole = map(true);
    folder.add("cut.bsp", &whole[..whole.len() - 40]);
    let refused = folder.run("info cut.bsp");
    assert_eq!(refused.code, Some(2));
    assert!(
        refused.stderr.contains("cut.bsp: is damaged: its lump")
            && refused.stderr.contains("compile the map again"),
        "{}",
        refused.stderr
    );
}
