//! Counts lines of code: without blank lines, comments, docs and tests.
//!
//! Each library and program is counted along its `mod` items, so that `tests/`, `benches/` and `examples/` stay out, and
//! modules behind features count only where these are on. Sources are scanned, not parsed: brackets that macros leave
//! open would be missed.
#![allow(clippy::print_stdout, reason = "a command prints what it counts")]

use crate::targets::cargo;
use anyhow::{Context, Result};
use serde_json::Value;
use std::fs;
use std::path::Path;

/// The crate of which a second line says what is compiled with default features.
const CORE: &str = "enfilade";

#[derive(clap::Args)]
pub(crate) struct Args {}

pub(crate) fn run(_: &Args) -> Result<()> {
    let metadata = cargo()
        .args(["metadata", "--no-deps", "--format-version", "1"])
        .output()?;
    let metadata: Value = serde_json::from_slice(&metadata.stdout).context("cargo metadata")?;
    let list = |value: &Value| value.as_array().cloned().unwrap_or_default();
    let mut total = 0;
    let mut core = None;
    for package in list(&metadata["packages"]) {
        let name = package["name"].as_str().unwrap_or_default();
        let features = list(&package["features"]["default"]);
        let is_default = |feature: &str| features.iter().any(|on| on == feature);
        let mut lines = 0;
        for target in list(&package["targets"]) {
            let is_built = |kind: &Value| kind == "lib" || kind == "bin";
            if let Some(root) = target["src_path"].as_str()
                && list(&target["kind"]).iter().any(is_built)
            {
                let root = Path::new(root);
                lines += count_file(root, &|_| None)?;
                if name == CORE {
                    core = Some(count_file(root, &|feature| Some(is_default(feature)))?);
                }
            }
        }
        println!("{lines:>7}  {name}");
        total += lines;
    }
    println!("{total:>7}  total");
    let core = core.context("the workspace has no core")?;
    println!("{core:>7}  core with default features");
    Ok(())
}

/// Whether a feature is on; `None` if it may be either, then the code counts.
type IsOn<'a> = &'a dyn Fn(&str) -> Option<bool>;

/// Counts a module's file and those of the modules that it declares.
fn count_file(file: &Path, is_on: IsOn) -> Result<usize> {
    let source = fs::read_to_string(file).with_context(|| file.display().to_string())?;
    let code = without_disabled(&without_comments(&source), is_on);
    let is_root = ["lib.rs", "main.rs", "mod.rs"]
        .iter()
        .any(|root| file.ends_with(root));
    let folder = if is_root {
        file.parent().unwrap_or(file).to_owned()
    } else {
        file.with_extension("")
    };
    let mut lines = 0;
    for line in code.lines().map(str::trim) {
        lines += usize::from(!line.is_empty() && !line.starts_with("#[doc"));
        let declared = line
            .strip_suffix(';')
            .and_then(|line| line.split_once("mod "))
            .filter(|(before, _)| before.is_empty() || before.starts_with("pub"));
        if let Some((_, name)) = declared {
            let beside = folder.join(format!("{name}.rs"));
            let below = folder.join(name).join("mod.rs");
            let file = if beside.exists() { beside } else { below };
            lines += count_file(&file, is_on)?;
        }
    }
    Ok(lines)
}

/// Replaces comments by spaces, and what could be mistaken for code in strings by `_`.
fn without_comments(source: &str) -> String {
    let mut code = String::with_capacity(source.len());
    let mut rest = source;
    while let Some(next) = rest.chars().next() {
        let before = code.chars().next_back().unwrap_or(' ');
        let in_word = before.is_alphanumeric() || before == '_';
        let quote = rest.trim_start_matches(['b', 'c', 'r']);
        let quote = quote.trim_start_matches('#');
        let is_raw = !in_word && quote.starts_with('"') && rest[..rest.len() - quote.len()].contains('r');
        let (length, is_comment) = if rest.starts_with("//") {
            (rest.find('\n').unwrap_or(rest.len()), true)
        } else if rest.starts_with("/*") {
            (block_comment(rest), true)
        } else if is_raw {
            let prefix = &rest[..rest.len() - quote.len()];
            let end = format!("\"{}", "#".repeat(prefix.matches('#').count()));
            let length = quote[1..].find(&end).map_or(quote.len(), |at| 1 + at + end.len());
            (prefix.len() + length, false)
        } else if next == '"' {
            (quoted(rest, '"'), false)
        } else if next == '\'' && is_char(rest) {
            (quoted(rest, '\''), false)
        } else {
            code.push(next);
            rest = &rest[next.len_utf8()..];
            continue;
        };
        code.extend(rest[..length].chars().map(|c| match c {
            '\n' => c,
            _ if is_comment => ' ',
            '(' | ')' | '[' | ']' | '{' | '}' | ';' | ',' | '#' => '_',
            _ => c,
        }));
        rest = &rest[length..];
    }
    code
}

fn block_comment(text: &str) -> usize {
    let mut depth = 0;
    for (at, _) in text.char_indices() {
        if text[at..].starts_with("/*") {
            depth += 1;
        } else if text[..at].ends_with("*/") {
            // `/*/` opens and does not close.
            depth -= usize::from(at > 3);
            if depth == 0 {
                return at;
            }
        }
    }
    text.len()
}

/// Returns `true` if a quote begins a character rather than a lifetime.
fn is_char(text: &str) -> bool {
    text[1..].starts_with('\\') || text.chars().nth(2) == Some('\'')
}

/// Returns the length of a string or character with its quotes.
fn quoted(text: &str, quote: char) -> usize {
    let mut escaped = false;
    let end = text[1..].find(|c| {
        let ends = c == quote && !escaped;
        escaped = c == '\\' && !escaped;
        ends
    });
    end.map_or(text.len(), |at| at + 2)
}

/// Removes items, statements and fields whose `#[cfg(…)]` is off.
fn without_disabled(code: &str, is_on: IsOn) -> String {
    let mut kept = String::new();
    let mut rest = code;
    while let Some(at) = rest.find("#[cfg(") {
        let (before, from) = rest.split_at(at);
        kept.push_str(before);
        let attribute = 1 + bracketed(&from[1..]);
        if holds(&from["#[cfg(".len()..attribute - 2], is_on) == Some(false) {
            rest = &from[attribute + item(&from[attribute..])..];
        } else {
            kept.push_str(&from[..attribute]);
            rest = &from[attribute..];
        }
    }
    kept + rest
}

/// Returns the length of a text up to the bracket that closes its first one.
fn bracketed(text: &str) -> usize {
    let mut depth = 0;
    for (at, c) in text.char_indices() {
        match c {
            '(' | '[' | '{' => depth += 1,
            ')' | ']' | '}' if depth == 1 => return at + 1,
            ')' | ']' | '}' => depth -= 1,
            _ => {}
        }
    }
    text.len()
}

/// Returns the length of the item, statement or field at the start, with further attributes.
fn item(text: &str) -> usize {
    let first = text.trim_start().split(|c: char| !c.is_alphanumeric()).next();
    // A comma ends a field or an argument, and goes on in `fn a<B, C>()` or `impl A<B, C> for D`.
    let is_item = [
        "pub", "fn", "impl", "struct", "enum", "trait", "type", "const", "unsafe",
    ];
    let ends_at_comma = !is_item.contains(&first.unwrap_or_default());
    let mut at = 0;
    while let Some(c) = text[at..].chars().next() {
        match c {
            ';' => return at + 1,
            ',' if ends_at_comma => return at + 1,
            '{' => {
                let end = at + bracketed(&text[at..]);
                // As `use a::{b, c};` ends.
                return end + usize::from(text[end..].starts_with(';'));
            }
            '(' | '[' => at += bracketed(&text[at..]),
            '}' | ')' | ']' => return at,
            _ => at += c.len_utf8(),
        }
    }
    at
}

/// Evaluates a condition of `cfg`; `None` if it may be either.
fn holds(condition: &str, is_on: IsOn) -> Option<bool> {
    let condition = condition.trim();
    let inner = |name: &str| condition.strip_prefix(name)?.strip_prefix('(')?.strip_suffix(')');
    let parts = |list: &'_ str| list.split(',').map(|part| holds(part, is_on)).collect::<Vec<_>>();
    if let Some(list) = inner("not") {
        return holds(list, is_on).map(|held| !held);
    }
    for (name, decisive) in [("any", true), ("all", false)] {
        if let Some(list) = inner(name) {
            let parts = parts(list);
            let undecided = parts.contains(&None).then_some(None);
            return if parts.contains(&Some(decisive)) {
                Some(decisive)
            } else {
                undecided.unwrap_or(Some(!decisive))
            };
        }
    }
    match condition.split_once('=') {
        Some((name, feature)) if name.trim() == "feature" => is_on(feature.trim().trim_matches('"')),
        _ => (condition == "test").then_some(false),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn comments_tests_and_disabled_items_are_no_code() {
        let source = r##"
            /* a { /* nested */ */ fn a() {} // {
            const B: &str = "// no comment {";
            const C: &str = r#"a " // "#;
            const D: [char; 2] = ['{', '\''];
            #[cfg(feature = "f")]
            pub fn e<T, U>(_: [T; 2], _: U) { if true { } }
            #[cfg(all(test, feature = "f"))] use g::{h, i};
            #[cfg(any(test, feature = "f"))]
            mod j;
            struct K { #[cfg(test)] l: u8, m: u8 }
            fn n<'a>(o: &'a u8) {}
            #[cfg(test)]
            mod p { fn q() {} }
        "##;
        let count = |is_on: IsOn| {
            let code = without_disabled(&without_comments(source), is_on);
            code.lines().filter(|line| !line.trim().is_empty()).count()
        };
        assert_eq!(count(&|_| Some(false)), 6);
        assert_eq!(count(&|_| Some(true)), 10);
        assert_eq!(count(&|_| None), 10);
    }
}
