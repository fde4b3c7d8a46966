//! Real scenes: every `.glb` in the folder that `ENFILADE_SCENES` names is read.

use enfilade_import::{ReadOptions, read};
use std::collections::HashSet;
use std::path::Path;

/// Items, and triangles with each copy counted, as their makers state them; the terrain of the villa is 16 items.
const KNOWN: [(&str, usize, u64); 14] = [
    ("blender_villa.glb", 249, 364_180),
    ("city_etoile.glb", 565, 13_098),
    ("city_munich.glb", 2_367, 38_936),
    ("city_san_francisco.glb", 4_735, 268_041),
    ("classroom.glb", 79, 103_832),
    ("country_kitchen.glb", 286, 1_021_815),
    ("ifc_duplex.glb", 215, 26_348),
    ("ifc_fzk_haus.glb", 83, 21_668),
    ("ifc_office_a.glb", 803, 51_711),
    ("q3_oa_rpg3dm2.glb", 4_196, 21_291),
    ("san_miguel.glb", 10_435, 9_407_550),
    ("sponza_crytek.glb", 579, 262_267),
    ("staircase.glb", 775, 262_663),
    ("terrain_jacksboro.glb", 156, 275_772),
];

#[test]
#[ignore = "needs ENFILADE_SCENES"]
fn real_scenes_have_as_many_items_and_triangles_as_their_makers_say() {
    let folder = std::env::var_os("ENFILADE_SCENES").expect("ENFILADE_SCENES names a folder");
    let mut met = 0;
    for entry in std::fs::read_dir(Path::new(&folder)).expect("ENFILADE_SCENES is a folder") {
        let path = entry.expect("an entry of the folder").path();
        if path.extension().is_none_or(|extension| extension != "glb") {
            continue;
        }
        met += 1;
        let flat = ReadOptions {
            flat: true,
            ..ReadOptions::default()
        };
        let import = read(&path, &flat).unwrap_or_else(|error| panic!("{error}"));
        let geometry = &import.rooms[0].geometry;
        let names: HashSet<&str> = (0..geometry.items().len() as u32)
            .map(|item| geometry.name(enfilade::ItemIndex(item)))
            .collect();
        assert_eq!(
            names.len(),
            geometry.items().len(),
            "{}: names are unique",
            path.display()
        );
        let file = path
            .file_name()
            .and_then(|name| name.to_str())
            .unwrap_or_default();
        if let Some((_, items, triangles)) = KNOWN.iter().find(|(name, ..)| *name == file) {
            assert_eq!(
                (geometry.items().len(), geometry.triangle_count()),
                (*items, *triangles),
                "{file}"
            );
        }
    }
    assert!(met > 0, "ENFILADE_SCENES names a folder without a .glb");
}
