//! `compare`: the page and its numbers.

use crate::support::{Folder, document, glb};
use enfilade::Method;
use serde_json::{Value, json};

/// The page of a run that went well.
fn page(folder: &Folder, arguments: &str) -> String {
    let run = folder.run(&format!("compare {arguments} -o page.html"));
    assert_eq!(
        (run.code, run.stderr.as_str()),
        (Some(0), ""),
        "{arguments}: {}",
        run.stdout
    );
    assert!(run.stdout.contains("page.html: "), "{}", run.stdout);
    std::fs::read_to_string(folder.path("page.html")).expect("a page of text")
}

#[test]
fn a_page_has_a_section_for_each_method_and_needs_nothing_else() {
    let folder = Folder::new();
    let page = page(&folder, "@two-rooms --size 96x54");
    let methods = Method::ALL
        .into_iter()
        .filter(|method| method.requires().is_none());
    for method in methods.clone() {
        let card = format!("alt=\"Difference by {method}, view 1\"");
        assert!(page.contains(&card), "{method}");
    }
    // The reference has two pictures, each method three.
    let pictures = page.matches("<img ").count();
    assert_eq!(pictures, 2 + 3 * methods.count());
    assert_eq!(page.matches("src=\"data:image/png;base64,").count(), pictures);
    assert_eq!(page.matches("<svg").count(), 6);
    for outside in ["src=\"http", "<link", "<script", "url(", "@import", "href"] {
        assert!(!page.contains(outside), "{outside}");
    }
    assert!(page.trim_end().ends_with("</html>"));
}

#[test]
fn the_report_is_that_of_a_look_with_its_check_and_more_times() {
    let folder = Folder::new();
    let report = folder.json("compare scene.glb --path views.jsonl --size 96x54 -o page.html");
    let methods = report["methods"].as_array().expect("a list");
    let skipped = report["skipped"].as_array().expect("a list");
    assert_eq!(methods.len() + skipped.len(), Method::ALL.len());
    let names: Vec<_> = skipped.iter().map(|skipped| &skipped["method"]).collect();
    assert_eq!(names, ["pvs", "cell", "floating-horizon"]);
    for method in methods {
        assert_eq!(method["scene"]["items"], 4);
        assert_eq!(method["summary"]["views"], 2);
        assert!(method["faces_built"].as_u64() >= Some(48), "{}", method["method"]);
        for view in method["views"].as_array().expect("a list") {
            assert!(view["draw_ms"].as_f64() > Some(0.0));
            assert!(view["order_ms"].as_f64() >= Some(0.0));
            assert_eq!(view["check"]["reference_visible"], 3);
            if method["contract"] != "approximate" {
                assert_eq!(view["check"]["pixels_different"], 0);
                assert_eq!(view["check"]["missed"], json!([]));
            }
        }
    }
}

#[test]
fn one_method_can_be_compared_with_the_reference_alone() {
    let folder = Folder::new();
    let report =
        folder.json("compare scene.glb --method z-buffer --size 96x54 -o page.html --flat --no-coherence");
    let names: Vec<&Value> = report["methods"]
        .as_array()
        .expect("a list")
        .iter()
        .map(|method| &method["method"])
        .collect();
    assert_eq!(names, ["z-buffer"]);
}

#[test]
fn views_without_pictures_are_in_the_numbers() {
    let folder = Folder::new();
    let shown = page(
        &folder,
        "scene.glb --path views.jsonl --size 96x54 --pictures 1 --method z-buffer",
    );
    assert!(shown.contains("View 1") && !shown.contains("View 2"));
    assert!(shown.contains("1 view without pictures"));
    let bare = page(
        &folder,
        "scene.glb --path views.jsonl --size 96x54 --pictures 0 --method z-buffer",
    );
    assert!(!bare.contains("<img ") && bare.contains("2 views without pictures"));
}

#[test]
fn methods_that_do_not_fit_are_named() {
    let folder = Folder::new();
    let run = folder.run("compare @two-rooms --memory 1 --size 16x9 -o page.html");
    assert_eq!(run.code, Some(0), "{}", run.stderr);
    let page = std::fs::read_to_string(folder.path("page.html")).expect("a page");
    assert!(page.contains("<b>z-buffer</b> is skipped"), "{page}");
    assert!(!page.contains("<svg"));
}

#[test]
fn names_from_files_are_no_markup() {
    let folder = Folder::new();
    let cube = |name: &str| json!({ "name": name, "mesh": 0 });
    folder.add("a<b>'&.glb", glb(&document(&[cube("<script>\"x\"")], json!([]))));
    let page = page(&folder, "a<b>'&.glb --size 32x18 --eye 0,0,4 --toward 0,0,0");
    assert!(page.contains("a&lt;b&gt;&#39;&amp;.glb"));
    assert!(!page.contains("<b>'") && !page.contains("<script"));
}

#[test]
fn a_page_that_cannot_be_written_is_refused_before_the_work() {
    let folder = Folder::new();
    for (arguments, word) in [
        ("-o page.htm", "must end in .html"),
        ("-o page", "must end in .html"),
        ("-o no/page.html", "there is no folder no"),
        ("-o page.html --json no/report.json", "there is no folder no"),
        ("", "--output"),
    ] {
        let run = folder.run(&format!("compare scene.glb {arguments}"));
        assert_eq!(run.code, Some(2), "{arguments}");
        assert!(run.stderr.contains(word), "{arguments}: {}", run.stderr);
        assert_eq!(folder.names(), ["scene.glb", "views.jsonl"], "{arguments}");
    }
}
