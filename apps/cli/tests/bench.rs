//! `bench`: its reports, and the comparison of sets with the expected ones.

mod support;

use serde_json::{Value, json};
use support::Folder;

fn names(rows: &Value) -> Vec<&str> {
    let rows = rows.as_array().expect("rows");
    rows.iter()
        .map(|row| row["name"].as_str().expect("a name"))
        .collect()
}

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
fn rows_have_their_stable_shape_and_nothing_is_wrong() {
    let folder = Folder::new();
    let report = folder.json("bench --micro --rounds 1 --rows tri-1000,tri-back,rect-hidden-16,rect-visible");
    let rows = &report["rows"];
    assert_eq!(
        names(rows),
        ["tri-1000", "tri-back", "rect-hidden-16", "rect-visible"]
    );
    for row in rows.as_array().expect("rows") {
        for key in ["m_per_s", "of_ceiling", "ns", "peer", "of_peer"] {
            assert!(row[key].as_f64().is_some_and(|value| value > 0.0), "{key}: {row}");
        }
        assert_eq!(row["wrong"], 0, "{row}");
    }
    for ceiling in ["l1_gb_s", "l2_gb_s"] {
        assert!(
            report["ceilings"][ceiling]
                .as_f64()
                .is_some_and(|value| value > 0.1)
        );
    }
    assert_eq!(report["left_out"], json!([]));
}

#[test]
fn rows_of_a_scene_are_in_milliseconds_a_view_and_left_out_with_a_word_without_one() {
    let folder = Folder::new();
    let rows = "--rounds 1 --rows rect-visible,sponza-512";
    let report = folder.json(&format!("bench scene.glb --micro {rows}"));
    assert_eq!(names(&report["rows"]), ["rect-visible", "sponza-512"]);
    let row = &report["rows"][1];
    assert!(row["ms"].as_f64().is_some_and(|ms| ms > 0.0), "{row}");
    assert_eq!(row["wrong"], 0, "{row}");
    let run = folder.run(&format!("bench --micro {rows}"));
    assert_eq!(run.code, Some(0), "{}", run.stderr);
    assert!(
        run.stdout.contains("sponza-512 is left out: no scene"),
        "{}",
        run.stdout
    );
}

#[test]
fn what_does_not_go_together_is_refused() {
    let folder = Folder::new();
    for (arguments, word) in [
        ("bench --micro --rows tri-11", "did you mean tri-10?"),
        ("bench --micro --survey 3", "--survey"),
        ("bench --micro --method masked", "--method"),
        ("bench --rounds 3", "--micro"),
        ("bench --rows tri-10", "--micro"),
        ("bench --micro --rounds 0", "--rounds"),
        ("bench nowhere.glb", "nowhere.glb"),
    ] {
        let run = folder.run(arguments);
        assert_eq!(run.code, Some(2), "{arguments}: {}", run.stderr);
        assert!(run.stderr.contains(word), "{arguments}: {}", run.stderr);
    }
}
