//! How the program was started, for commands that it suggests.

use std::env;
use std::path::Path;

/// Returns the beginning of a command line that starts this program as it was started: `cargo run --release --` from a folder of
/// its sources, else `enfilade`.
pub(crate) fn program() -> &'static str {
    let variables = ["CARGO", "CARGO_PKG_NAME", "CARGO_MANIFEST_DIR"].map(|name| env::var(name).ok());
    let folder = env::current_dir().ok();
    if is_run_by_cargo(variables, folder.as_deref()) {
        "cargo run --release --"
    } else {
        "enfilade"
    }
}

/// Whether `cargo run` of this package started the program, by the variables that it sets. Tests have them too, and so have
/// programs that they start, but in another folder, where such a command would not work.
fn is_run_by_cargo([cargo, package, manifest]: [Option<String>; 3], folder: Option<&Path>) -> bool {
    let is_this = package.as_deref() == Some(env!("CARGO_PKG_NAME"));
    let sources = manifest
        .as_deref()
        .and_then(|app| Path::new(app).ancestors().nth(2));
    let is_inside = sources
        .zip(folder)
        .is_some_and(|(sources, folder)| folder.starts_with(sources));
    cargo.is_some() && is_this && is_inside
}

/// Returns suggested commands with the beginning that fits.
pub(crate) fn suggested(text: &str) -> String {
    text.replace("  enfilade ", &format!("  {} ", program()))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn cargo_run_is_told_from_an_installed_program_and_from_tests() {
        let set = |name: &str, app: &str| ["cargo", name, app].map(|value| Some(value.to_owned()));
        let at = |variables, folder: &str| is_run_by_cargo(variables, Some(Path::new(folder)));
        let by_cargo = || set("enfilade-cli", "/home/ann/enfilade/apps/cli");
        assert!(at(by_cargo(), "/home/ann/enfilade"));
        assert!(at(by_cargo(), "/home/ann/enfilade/apps/cli"));
        assert!(!at(by_cargo(), "/tmp/test"));
        assert!(!at(
            set("game", "/home/ann/enfilade/apps/cli"),
            "/home/ann/enfilade"
        ));
        assert!(!at([None, None, None], "/home/ann/enfilade"));
        assert!(!is_run_by_cargo(by_cargo(), None));
    }
}
