//! Holds the names that the crate exports against a committed list, so that none comes or goes unnoticed.

/// The names of `pub use` and `pub mod` in lib.rs, sorted; what a feature adds says so.
fn exported(lib: &str) -> String {
    let code: Vec<&str> = lib
        .lines()
        .map(str::trim)
        .filter(|line| !line.starts_with("//"))
        .collect();
    let mut names = Vec::new();
    for statement in code.join(" ").split(';') {
        // A condition stands before its statement.
        let (condition, statement) = statement.rsplit_once(']').unwrap_or(("", statement));
        let when = if condition.contains("feature") {
            " (feature laws)"
        } else {
            ""
        };
        if let Some(module) = statement.trim().strip_prefix("pub mod ") {
            names.push(format!("mod {module}{when}\n"));
        } else if let Some(path) = statement.trim().strip_prefix("pub use ") {
            let (_, list) = path.rsplit_once("::").expect("a path");
            let list = list.trim_matches(['{', '}', ' ']).split(',').map(str::trim);
            names.extend(
                list.filter(|name| !name.is_empty())
                    .map(|name| format!("{name}{when}\n")),
            );
        }
    }
    names.sort();
    names.concat()
}

#[test]
fn the_exported_names_are_those_on_the_list() {
    let now = exported(include_str!("../src/lib.rs"));
    let listed = include_str!("public_api.txt");
    assert!(now.lines().count() > 30, "hardly anything is found in lib.rs");
    assert!(
        now == listed,
        "src/lib.rs exports other names than tests/public_api.txt lists. If that is meant, make the list\n\n{now}\n\
         and say in CHANGELOG.md what changed."
    );
}
