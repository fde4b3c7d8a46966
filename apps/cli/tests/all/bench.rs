//! `bench`: its reports, and the comparison of sets with the expected ones.

use crate::support::Folder;
use serde_json::json;

#[test]
fn every_method_is_timed_and_sees_what_is_expected_and_the_same_again() {
    let report = Folder::new().json("bench scene.glb --path views.jsonl --size 160x90");
    let methods = report["methods"].as_array().expect("methods");
    assert!(methods.len() > 5);
    assert!(report["skipped"].is_array());
    for method in methods {
        for time in ["build_ms", "bytes"] {
            assert!(method[time].is_number(), "{method}");
        }
        for time in ["ms_median", "ms_p99"] {
            assert!(method["summary"][time].is_number(), "{method}");
        }
        for view in method["views"].as_array().expect("views") {
            for time in ["ms", "draw_ms", "order_ms"] {
                assert!(view[time].is_number(), "{view}");
            }
            let expected = json!({ "items_visible": 3, "missed": [], "extra": 0, "same_again": true });
            assert_eq!(view["expected"], expected, "{}", method["method"]);
        }
    }
}

#[test]
fn one_method_makes_one_report_and_a_table_of_one_row() {
    let folder = Folder::new();
    let report = folder.json("bench scene.glb --path views.jsonl --size 64x36 --method masked");
    assert_eq!(report["method"], "masked");
    let run = folder.run("bench scene.glb --path views.jsonl --size 64x36 --method masked");
    assert_eq!(run.code, Some(0), "{}", run.stderr);
    for word in ["masked", "conservative", "misses nothing", "2 views"] {
        assert!(run.stdout.contains(word), "{}", run.stdout);
    }
    assert!(!run.stdout.contains("z-buffer"), "{}", run.stdout);
}

#[test]
fn without_a_camera_it_is_a_survey_of_sixteen_views() {
    let report = Folder::new().json("bench @enfilade --size 16x9 --method z-buffer");
    assert_eq!(report["summary"]["views"], 16);
}

#[test]
fn a_file_that_is_not_there_is_refused() {
    let run = Folder::new().run("bench nowhere.glb");
    assert_eq!(run.code, Some(2), "{}", run.stderr);
    assert!(run.stderr.contains("nowhere.glb"), "{}", run.stderr);
}
