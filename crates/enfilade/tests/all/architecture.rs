//! Compares ARCHITECTURE.md with the folders, and tests the import rules in it.

use enfilade::Method;
use std::collections::{BTreeMap, BTreeSet};
use std::fs;
use std::path::{Path, PathBuf};

fn root() -> PathBuf {
    let package = Path::new(env!("CARGO_MANIFEST_DIR"));
    package.join("../..").canonicalize().expect("the workspace")
}

/// Returns all files and folders under a workspace folder, as relative paths.
fn under(folder: &str) -> Vec<String> {
    let start = root().join(folder);
    let mut waiting = vec![start.clone()];
    let mut found = Vec::new();
    while let Some(folder) = waiting.pop() {
        for entry in fs::read_dir(&folder).expect("a folder") {
            let path = entry.expect("an entry").path();
            let from_start = path.strip_prefix(&start).expect("it is below");
            found.push(from_start.to_string_lossy().replace('\\', "/"));
            if path.is_dir() {
                waiting.push(path);
            }
        }
    }
    found.sort();
    assert!(!found.is_empty(), "nothing is in {folder}");
    found
}

/// Returns the source files under a workspace folder, with their relative paths.
fn sources(folder: &str) -> Vec<(String, String)> {
    let paths = under(folder).into_iter().filter(|path| path.ends_with(".rs"));
    paths
        .map(|path| {
            let text = fs::read_to_string(root().join(folder).join(&path)).expect("text");
            (path, text)
        })
        .collect()
}

/// Returns the crate paths that a source file imports, outside its unit tests, which may import anything:
/// `order::Unsorted;` and the following text for `use crate::order::Unsorted;`.
fn mentions(text: &str) -> impl Iterator<Item = &str> {
    let code = text.split("#[cfg(test)]\nmod tests").next().unwrap_or(text);
    assert!(
        !code.contains("crate::{"),
        "one `use` for each module, so that these tests can read it"
    );
    code.split("crate::").skip(1)
}

const CORE: &str = "crates/enfilade/src";

#[test]
fn every_crate_and_every_folder_of_the_core_is_on_the_map() {
    let map = fs::read_to_string(root().join("ARCHITECTURE.md")).expect("the map");
    let crates = ["crates", "apps"].iter().flat_map(|folder| {
        let entries = fs::read_dir(root().join(folder)).expect("a folder");
        let name = |entry: std::io::Result<fs::DirEntry>| entry.expect("an entry").file_name();
        entries.map(move |entry| format!("{folder}/{}", name(entry).to_string_lossy()))
    });
    let is_folder = |path: &String| root().join(CORE).join(path).is_dir() && !path.ends_with("tests");
    let missing: Vec<String> = crates
        .chain(under(CORE).into_iter().filter(is_folder))
        .filter(|path| !map.contains(&format!("`{path}/`")))
        .collect();
    assert!(
        missing.is_empty(),
        "ARCHITECTURE.md does not describe {missing:?}"
    );
}

#[test]
fn every_path_on_the_map_exists() {
    let map = fs::read_to_string(root().join("ARCHITECTURE.md")).expect("the map");
    let named = map.split('`').skip(1).step_by(2);
    let paths: Vec<&str> = named
        .filter(|name| name.ends_with(".rs") || (name.ends_with('/') && !name.contains(' ')))
        .collect();
    assert!(paths.len() > 30);
    for path in paths {
        let folders = [
            "",
            "crates/enfilade",
            CORE,
            "crates/enfilade_detail/src",
            "crates/enfilade_import/src",
            "crates/enfilade_walk/src",
            "apps/cli/src",
        ];
        let exists = folders
            .iter()
            .any(|folder| root().join(folder).join(path).exists());
        assert!(exists, "ARCHITECTURE.md names `{path}`, which does not exist");
    }
}

#[test]
fn the_table_of_methods_on_the_map_is_that_of_the_library() {
    let map = fs::read_to_string(root().join("ARCHITECTURE.md")).expect("the map");
    let quoted = |name: &str| match name {
        "" => String::new(),
        name => format!("`{name}`"),
    };
    let row = |method: Method| {
        let requires = method
            .requires()
            .map_or(String::new(), |needed| needed.to_string());
        let [order, cover] = [method.order(), method.cover()].map(quoted);
        let (contract, source) = (method.contract(), method.source());
        let takes_cover_size = if method.takes_cover_size() { "yes" } else { "" };
        format!(
            "| {method} | {order} | {cover} | {contract} | {requires} | {takes_cover_size} | {source} |\n"
        )
    };
    let table: String = Method::ALL.into_iter().map(row).collect();
    let lines = map.lines().skip_while(|line| !line.starts_with("| method |"));
    let found = lines.skip(2).take_while(|line| line.starts_with('|'));
    let found: String = found
        .map(|line| format!("{}\n", line.replace("|  |", "| |")))
        .collect();
    let table = table.replace("|  |", "| |").replace("|  |", "| |");
    assert!(found == table, "the table in ARCHITECTURE.md should be:\n{table}");
}

#[test]
fn orders_know_nothing_of_covers() {
    for (path, text) in sources(&format!("{CORE}/order")) {
        assert!(mentions(&text).all(|of| !of.starts_with("cover")), "order/{path}");
        assert!(!text.contains("super::super"), "order/{path}");
    }
}

#[test]
fn the_rasterizer_knows_nothing_of_orders_covers_and_methods() {
    for (path, text) in sources(&format!("{CORE}/raster")) {
        let above = |of: &&str| {
            ["order", "cover", "method"]
                .iter()
                .any(|word| of.starts_with(word))
        };
        assert_eq!(mentions(&text).find(above), None, "raster/{path}");
    }
}

#[test]
fn covers_know_of_orders_only_what_they_can_promise() {
    const PROMISES: [&str; 4] = ["Unsorted", "NodesNearToFar", "NearToFar", "FarToNear"];
    let mut known = 0;
    for (path, text) in sources(&format!("{CORE}/cover")) {
        assert!(!text.contains("super::super"), "cover/{path}");
        for of in mentions(&text).filter_map(|of| of.strip_prefix("order::")) {
            let (of, _) = of.split_once(';').expect("an import");
            let mut of = of.trim_matches(['{', '}']).split(',').map(str::trim);
            let other = of.find(|name| !PROMISES.contains(name));
            assert_eq!(other, None, "cover/{path} may not import this from `order`");
            known += 1;
        }
    }
    assert!(known > 0, "no cover says what it needs");
}

#[test]
fn only_methods_know_both_orders_and_covers() {
    for (path, text) in sources(CORE) {
        let knows = |what: &str| mentions(&text).any(|of| of.starts_with(what));
        let inside = path.starts_with("order/") || path.starts_with("cover/");
        if !inside && (knows("order::") || knows("cover::")) {
            assert!(path.starts_with("method/"), "{path}");
        }
    }
}

#[test]
fn orders_covers_and_methods_know_nothing_of_portals() {
    // Unit tests in a separate folder may import anything, too.
    for (path, text) in sources(CORE)
        .into_iter()
        .filter(|(path, _)| !path.contains("/tests/"))
    {
        if path.starts_with("order/") || path.starts_with("cover/") || path.starts_with("method/") {
            let of_scenes = mentions(&text).find(|of| of.starts_with("scene"));
            assert_eq!(of_scenes, None, "{path}");
        }
    }
}

#[test]
fn geometry_knows_nothing_else_of_ours_but_the_simd_level_and_the_threads() {
    for (path, text) in sources(&format!("{CORE}/geom")) {
        let known = |of: &&str| {
            // `chance` makes random numbers for tests.
            ["geom", "simd", "threads", "chance"]
                .iter()
                .any(|word| of.starts_with(word))
        };
        let other = mentions(&text).find(|of| !known(of));
        assert_eq!(other, None, "geom/{path}");
    }
}

#[test]
fn no_import_circle_joins_folders_of_the_core_or_of_the_program() {
    for folder in [CORE, "apps/cli/src"] {
        // A file in the folder itself counts as a folder. Unit tests and the root of the crate may import anything.
        let place = |path: &str| {
            let place = path.split('/').next().unwrap_or(path);
            place.trim_end_matches(".rs").to_owned()
        };
        let mut imports: BTreeMap<String, BTreeSet<String>> = BTreeMap::new();
        for (path, text) in sources(folder) {
            let is_test = path.contains("tests/") || path.ends_with("tests.rs");
            if !is_test && path != "lib.rs" && path != "main.rs" {
                let own = place(&path);
                let code: String = text
                    .lines()
                    .filter(|line| !line.trim_start().starts_with("//"))
                    .map(|line| format!("{line}\n"))
                    .collect();
                let word = |of: &str| {
                    let end = of.find(|letter: char| !letter.is_alphanumeric() && letter != '_');
                    of[..end.unwrap_or(of.len())].to_owned()
                };
                let others = mentions(&code).map(word).filter(|other| *other != own);
                imports.entry(own.clone()).or_default().extend(others);
            }
        }
        // Places that import nothing that is left are removed, until none does.
        let count = imports.len();
        assert!(count > 15, "{folder} has {count} folders and files");
        loop {
            let left: BTreeSet<String> = imports.keys().cloned().collect();
            imports.retain(|_, others| others.iter().any(|other| left.contains(other)));
            if imports.len() == left.len() {
                break;
            }
        }
        assert!(imports.is_empty(), "{folder}: a circle is among {imports:#?}");
    }
}

#[test]
fn the_reference_knows_nothing_of_methods() {
    // Except the file that tests methods against the reference.
    let sources = sources(&format!("{CORE}/laws"));
    for (path, text) in sources.iter().filter(|(path, _)| path != "contracts.rs") {
        let shared = |of: &&str| {
            ["method", "faces", "view::region", "view::memory"]
                .iter()
                .any(|word| of.starts_with(word))
        };
        assert_eq!(mentions(text).find(shared), None, "laws/{path}");
    }
}

#[test]
fn the_library_opens_nothing_reads_no_clock_starts_no_thread_and_fuses_nothing() {
    // Unit tests in a separate folder may use pools of several sizes.
    for (path, text) in sources(CORE)
        .into_iter()
        .filter(|(path, _)| !path.contains("/tests/"))
    {
        for word in [
            // One `use` for each module, so that the rest of this list is found.
            "std::{",
            "std::fs",
            "std::io",
            "std::net",
            "std::process",
            "std::env",
            "std::thread",
            "ThreadPool",
            "Instant",
            "SystemTime",
            "mul_add",
        ] {
            let mut code = text.lines().filter(|line| !line.trim_start().starts_with("//"));
            assert!(!code.any(|line| line.contains(word)), "{path} mentions {word}");
        }
    }
}

#[test]
fn no_source_holds_unsafe_code_but_the_one_that_maps_files_and_the_border_of_c() {
    const MAPS_FILES: &str = "enfilade_import/src/map.rs";
    let word = ["un", "safe"].concat();
    let (mut roots, mut mapping, mut promised) = (0, 0, 0);
    for folder in ["crates", "apps"] {
        for (path, text) in sources(folder) {
            let has_exceptions = ["enfilade_import/", "enfilade_c/"]
                .iter()
                .any(|of| path.starts_with(of));
            let how = if has_exceptions { "deny" } else { "forbid" };
            let forbids = format!("#![{how}({word}_code)]");
            if path.ends_with("src/lib.rs") || path.ends_with("src/main.rs") {
                assert!(text.contains(&forbids), "{path} does not forbid it");
                roots += 1;
            }
            if let Some(file) = path.strip_prefix("enfilade_c/") {
                // Calls promise that their pointers are sound; one file follows them. Tests and examples call as C does.
                let code = text.split("#[cfg(test)]").next().unwrap_or(&text);
                let [blocks, promises] = [format!("{word} {{"), format!("{word} {{ Caller::new() }}")]
                    .map(|words| code.matches(&words).count());
                let follows = file == "src/lent.rs" || !file.starts_with("src/");
                assert!(follows || blocks == promises, "{path}");
                promised += promises;
                continue;
            }
            if path == MAPS_FILES {
                let [times, reasons] = [format!("{word} {{"), "// SAFETY: ".to_owned()]
                    .map(|words| text.matches(&words).count());
                assert_eq!([times, reasons], [1, 1], "{path}");
                mapping += 1;
                continue;
            }
            assert!(!text.contains(&format!("#[allow({word}_code)]")), "{path}");
            assert!(
                !text.replace(&forbids, "").contains(&format!("{word} ")),
                "{path}"
            );
        }
    }
    assert!(roots >= 5);
    assert!(promised > 50, "calls of C promise something else now");
    assert_eq!(mapping, 1, "{MAPS_FILES} is gone");
}
