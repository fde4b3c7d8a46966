//! URIs: files in the same folder as the document, and data URIs.

use super::document::short;
use crate::budget::Budget;
use crate::{BrokenRule, read_regular_file};
use base64::Engine;
use base64::engine::{DecodePaddingMode, GeneralPurpose, GeneralPurposeConfig};
use percent_encoding::percent_decode_str;
use std::borrow::Cow;
use std::path::{Component, Path, PathBuf};

/// Base64 with or without padding.
const BASE64: GeneralPurpose = GeneralPurpose::new(
    &base64::alphabet::STANDARD,
    GeneralPurposeConfig::new().with_decode_padding_mode(DecodePaddingMode::Indifferent),
);

/// Reads all bytes of a URI.
pub(crate) fn fetch_all(
    uri: &str,
    place: &str,
    folder: Option<&Path>,
    budget: &mut Budget,
) -> Result<Vec<u8>, BrokenRule> {
    fetch(uri, u64::MAX, &|| place.to_owned(), folder, budget)
}

/// Reads at most the first `most` bytes of a URI.
pub(super) fn fetch(
    uri: &str,
    most: u64,
    place: &dyn Fn() -> String,
    folder: Option<&Path>,
    budget: &mut Budget,
) -> Result<Vec<u8>, BrokenRule> {
    match scheme(uri) {
        Some(scheme) if scheme.eq_ignore_ascii_case("data") => decode(uri, place, budget),
        Some(_) => Err(BrokenRule::NotLocal {
            place: place(),
            uri: short(uri),
        }),
        None => {
            inside_folder(uri, place)?;
            let folder = folder.ok_or_else(|| BrokenRule::NoFolder {
                place: place(),
                uri: short(uri),
            })?;
            let path = path(uri, place, folder)?;
            read_regular_file(&path, Some(most), place, budget).map_err(|why| match why {
                BrokenRule::TooLarge { .. } => why,
                why => BrokenRule::BufferFile {
                    place: place(),
                    path: path.display().to_string(),
                    why: Box::new(why),
                },
            })
        }
    }
}

/// Returns the file path of a URI, if it is a file in the folder.
pub(crate) fn file(uri: &str, folder: &Path) -> Option<PathBuf> {
    let is_file = !uri.is_empty() && scheme(uri).is_none();
    is_file
        .then(|| path(uri, &String::new, folder))
        .and_then(Result::ok)
}

/// Returns `true` if the path in a URI has the separators of Windows, which are read as `/`.
pub(super) fn has_backslash(uri: &str) -> bool {
    scheme(uri).is_none() && percent_decode_str(uri).any(|byte| byte == b'\\')
}

/// Returns the path of the file of a URI.
fn path(uri: &str, place: &dyn Fn() -> String, folder: &Path) -> Result<PathBuf, BrokenRule> {
    // Elsewhere than on Windows, the name of a file may have a backslash.
    let literal = percent_decode_str(uri).decode_utf8_lossy();
    let is_name = !literal.contains('/') && literal.contains('\\');
    if is_name && !cfg!(windows) && folder.join(&*literal).is_file() {
        return Ok(folder.join(&*literal));
    }
    Ok(folder.join(inside_folder(uri, place)?))
}

/// Returns the scheme of a URI, if it has one.
fn scheme(uri: &str) -> Option<&str> {
    let (scheme, _) = uri.split_once(':')?;
    let mut letters = scheme.chars();
    let begins = letters.next().is_some_and(|first| first.is_ascii_alphabetic());
    (begins && letters.all(|c| c.is_ascii_alphanumeric() || "+-.".contains(c))).then_some(scheme)
}

/// Decodes a base64 data URI.
fn decode(uri: &str, place: &dyn Fn() -> String, budget: &mut Budget) -> Result<Vec<u8>, BrokenRule> {
    let bad = |why: String| BrokenRule::BadUri { place: place(), why };
    let (head, data) = uri
        .split_once(',')
        .ok_or_else(|| bad("its data URI has no comma".to_owned()))?;
    if !head.to_ascii_lowercase().ends_with(";base64") {
        return Err(bad("its data URI is not base64".to_owned()));
    }
    budget.take(data.len() as u64 / 4 * 3 + 3, place)?;
    // Some writers break its lines.
    let mut data = Cow::Borrowed(data);
    if data.contains(|letter: char| letter.is_ascii_whitespace()) {
        budget.take(data.len() as u64, place)?;
        data = Cow::Owned(data.split_ascii_whitespace().collect());
    }
    BASE64
        .decode(&*data)
        .map_err(|why| bad(format!("its data URI is not base64: {why}")))
}

/// Returns the path of a relative URI, which must not leave the folder. A backslash separates folders, as on Windows.
fn inside_folder(uri: &str, place: &dyn Fn() -> String) -> Result<PathBuf, BrokenRule> {
    let decoded = percent_decode_str(uri)
        .decode_utf8()
        .map_err(|_| BrokenRule::BadUri {
            place: place(),
            why: format!("`{}` is not UTF-8", short(uri)),
        })?;
    let path = PathBuf::from(decoded.replace('\\', "/"));
    if path
        .components()
        .all(|part| matches!(part, Component::Normal(_) | Component::CurDir))
    {
        Ok(path)
    } else {
        Err(BrokenRule::LeavesFolder {
            place: place(),
            uri: short(uri),
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn only_paths_that_stay_in_the_folder_are_followed() {
        let place = || "buffer 0".to_owned();
        for (uri, path) in [
            ("a.bin", "a.bin"),
            ("./b/a%20c.bin", "./b/a c.bin"),
            ("%C3%A9.bin", "é.bin"),
            ("b\\c.bin", "b/c.bin"),
            (".\\b\\a%20c.bin", "./b/a c.bin"),
            ("b%5Cd/c.bin", "b/d/c.bin"),
        ] {
            assert_eq!(inside_folder(uri, &place).expect("inside"), Path::new(path));
        }
        for uri in [
            "../a.bin",
            "b/../../a.bin",
            "/etc/passwd",
            "%2Fetc/passwd",
            "%2e%2e/a.bin",
            "//host/a.bin",
            "..\\a.bin",
            "b%5C..%5c..\\a.bin",
            "\\\\host\\a.bin",
            "\\a.bin",
        ] {
            assert!(
                matches!(inside_folder(uri, &place), Err(BrokenRule::LeavesFolder { .. })),
                "{uri}"
            );
        }
    }

    #[test]
    fn a_scheme_is_told_from_a_name() {
        for (uri, expected) in [
            ("https://a.b/c.bin", Some("https")),
            ("data:;base64,", Some("data")),
            ("C:/a.bin", Some("C")),
            ("a.bin", None),
            ("a b:c.bin", None),
            (":a", None),
        ] {
            assert_eq!(scheme(uri), expected, "{uri}");
        }
    }
}
