//! `--simd` does not change the visible sets.

use crate::support::Folder;
use serde_json::Value;

/// Returns the parts of a report that are the same at every level: the sets and the counters.
fn answers(folder: &Folder, scene: &str, level: &str) -> Vec<[Value; 4]> {
    let report = folder.json(&format!(
        "look {scene} --survey 3 --method all --size 160x90 --simd {level}"
    ));
    let methods = report["methods"].as_array().expect("methods");
    let answer = |method: &Value| {
        assert_eq!(method["simd"], level);
        let views = method["views"].as_array().expect("views");
        let visible = views.iter().map(|view| view["visible"].clone()).collect();
        ["method", "stats", "faces_built"]
            .map(|key| method[key].clone())
            .into_iter()
            .chain([visible])
            .collect::<Vec<_>>()
            .try_into()
            .expect("four")
    };
    methods.iter().map(answer).collect()
}

#[test]
fn every_level_of_the_machine_sees_the_same() {
    let folder = Folder::new();
    let levels: Vec<&str> = enfilade::simd_levels().collect();
    for scene in ["@house", "@mirrors", "@crowd"] {
        let best = answers(&folder, scene, levels[0]);
        assert!(best.len() > 5);
        for level in &levels[1..] {
            assert_eq!(answers(&folder, scene, level), best, "{scene}, {level}");
        }
    }
}

#[test]
fn without_it_the_best_level_is_used() {
    let report = Folder::new().json("look scene.glb --size 64x36");
    assert_eq!(report["simd"], enfilade::simd_levels().next().expect("a level"));
}

#[test]
fn a_level_that_is_not_there_is_refused_with_those_that_are() {
    let folder = Folder::new();
    let elsewhere = if cfg!(target_arch = "aarch64") {
        "sse2"
    } else {
        "neon"
    };
    for verb in ["look", "draw -o a.png", "compare -o a.html", "bench"] {
        for level in ["avx3", elsewhere] {
            let run = folder.run(&format!("{verb} --simd {level}"));
            assert_eq!(run.code, Some(2), "{verb}: {}", run.stderr);
            for there in enfilade::simd_levels() {
                assert!(run.stderr.contains(there), "{verb}: {}", run.stderr);
            }
        }
    }
}
