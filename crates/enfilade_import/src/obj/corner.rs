//! Parses the corners of a face: `7`, `7/2`, `7/2/-1` or `7//-1`.

use super::ObjError;
use super::survey::Counts;
use super::text::quoted;
use std::num::NonZeroU32;

/// A corner of a face: the index of its position from 0, and the indices of its other attributes from 1.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub(super) struct Corner {
    pub(super) position: u32,
    pub(super) texture: Option<NonZeroU32>,
    pub(super) normal: Option<NonZeroU32>,
}

/// Numbers of elements before a line.
#[derive(Clone, Copy, Debug)]
pub(super) struct ElementCounts {
    pub(super) positions: usize,
    pub(super) texture: usize,
    pub(super) normals: usize,
}

impl Corner {
    /// Parses a corner in a file with `all` elements.
    pub(super) fn parse(word: &[u8], so_far: ElementCounts, all: &Counts) -> Result<Corner, BadCorner> {
        let mut parts = word.split(|&byte| byte == b'/');
        let mut next = |kind, before, count| match parts.next() {
            None | Some(b"") => Ok(None),
            Some(part) => {
                let number = whole(part).ok_or(BadCorner::Form)?;
                let why = |why| BadCorner::Number { kind, number, why };
                resolve(number, before, count).map(Some).map_err(why)
            }
        };
        let position = next("position", so_far.positions, all.positions)?;
        let texture = next("texture coordinates", so_far.texture, all.texture)?;
        let normal = next("normal", so_far.normals, all.normals)?;
        match (position, parts.next()) {
            (Some(position), None) => Ok(Corner {
                position: position.get() - 1,
                texture,
                normal,
            }),
            _ => Err(BadCorner::Form),
        }
    }
}

/// Why a word is not a valid corner.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum BadCorner {
    /// The word has the wrong form.
    Form,
    /// An index is out of range.
    Number {
        kind: &'static str,
        number: i64,
        why: BadIndex,
    },
}

impl BadCorner {
    /// Converts to the error of a word in a line.
    pub(super) fn error(self, line: usize, word: &[u8]) -> ObjError {
        let found = quoted(word);
        let BadCorner::Number { kind, number, why } = self else {
            return ObjError::BadCorner { line, found };
        };
        match why {
            BadIndex::Zero => ObjError::NumberZero { line, found, kind },
            BadIndex::TooLarge { count } => ObjError::NoSuch {
                line,
                found,
                kind,
                number,
                count,
            },
            BadIndex::TooFarBack { before } => ObjError::BeforeTheFirst {
                line,
                found,
                kind,
                number,
                before,
            },
        }
    }
}

/// Parses an integer; saturates if it is too large.
fn whole(word: &[u8]) -> Option<i64> {
    let (negative, digits) = match word {
        [b'-', digits @ ..] => (true, digits),
        [b'+', digits @ ..] => (false, digits),
        digits => (false, digits),
    };
    if digits.is_empty() {
        return None;
    }
    let mut value = 0_i64;
    for digit in digits {
        let digit = digit.is_ascii_digit().then_some(i64::from(digit & 15))?;
        value = value.saturating_mul(10).saturating_add(digit);
    }
    Some(if negative { -value } else { value })
}

/// Why an index is out of range.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum BadIndex {
    Zero,
    TooLarge { count: usize },
    TooFarBack { before: usize },
}

/// Resolves an index: 1 is the first element, and −1 the last of the `before` elements above the line. The file has
/// `count` elements; later ones may be referenced too.
fn resolve(number: i64, before: usize, count: usize) -> Result<NonZeroU32, BadIndex> {
    let place = if number < 0 {
        before as i64 + number + 1
    } else {
        number
    };
    let named = u32::try_from(place).ok().and_then(NonZeroU32::new);
    match named.filter(|named| named.get() as usize <= count) {
        Some(named) => Ok(named),
        None if number == 0 => Err(BadIndex::Zero),
        None if number < 0 => Err(BadIndex::TooFarBack { before }),
        None => Err(BadIndex::TooLarge { count }),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn parse(word: &str) -> Result<Corner, BadCorner> {
        let so_far = ElementCounts {
            positions: 5,
            texture: 2,
            normals: 1,
        };
        let all = Counts {
            positions: 7,
            texture: 2,
            normals: 3,
            ..Counts::default()
        };
        Corner::parse(word.as_bytes(), so_far, &all)
    }

    #[test]
    fn numbers_count_from_one_or_back_from_the_line() {
        let corner = |position, texture: u32, normal: u32| {
            Ok(Corner {
                position,
                texture: NonZeroU32::new(texture),
                normal: NonZeroU32::new(normal),
            })
        };
        assert_eq!(parse("1"), corner(0, 0, 0));
        assert_eq!(parse("7"), corner(6, 0, 0));
        assert_eq!(parse("-1"), corner(4, 0, 0));
        assert_eq!(parse("-5/-2/-1"), corner(0, 1, 1));
        assert_eq!(parse("+2//3"), corner(1, 0, 3));
        for word in ["3/2", "3/2/", "03/002"] {
            assert_eq!(parse(word), corner(2, 2, 0), "{word}");
        }
    }

    #[test]
    fn what_names_nothing_is_told_from_what_is_no_corner() {
        for word in [
            "", "a", "1/2/3/4", "1.5", "/1", "//1", "--1", "-", "1-", "1/b", "\u{661}",
        ] {
            assert_eq!(parse(word), Err(BadCorner::Form), "{word}");
        }
        let largest = i64::MAX;
        for (word, named, is) in [
            ("0", 0, BadIndex::Zero),
            ("-0", 0, BadIndex::Zero),
            ("8", 8, BadIndex::TooLarge { count: 7 }),
            ("-6", -6, BadIndex::TooFarBack { before: 5 }),
            ("99999999999", 99_999_999_999, BadIndex::TooLarge { count: 7 }),
            ("4294967297", 4_294_967_297, BadIndex::TooLarge { count: 7 }),
            (
                "99999999999999999999999",
                largest,
                BadIndex::TooLarge { count: 7 },
            ),
            (
                "-99999999999999999999999",
                -largest,
                BadIndex::TooFarBack { before: 5 },
            ),
        ] {
            let expected = BadCorner::Number {
                kind: "position",
                number: named,
                why: is,
            };
            assert_eq!(parse(word), Err(expected), "{word}");
        }
        let normal = BadCorner::Number {
            kind: "normal",
            number: -2,
            why: BadIndex::TooFarBack { before: 1 },
        };
        assert_eq!(parse("1//-2"), Err(normal));
    }
}
