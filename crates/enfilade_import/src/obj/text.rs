//! Lines, words and numbers of OBJ and MTL files.

use std::borrow::Cow;

/// A line that is neither empty nor a comment, joined with its continuation lines.
#[derive(Debug)]
pub(super) struct Line<'a> {
    /// Line number, from 1.
    pub(super) number: usize,
    /// Without leading and trailing white space.
    pub(super) text: Cow<'a, [u8]>,
}

impl Line<'_> {
    /// Returns the first word.
    pub(super) fn keyword(&self) -> &[u8] {
        words(&self.text).next().unwrap_or_default()
    }

    /// Returns the words after the keyword, up to a comment.
    pub(super) fn words(&self) -> impl Iterator<Item = &[u8]> {
        words(&self.text).skip(1).take_while(|word| word[0] != b'#')
    }

    /// Returns everything after the keyword. Names may contain spaces and `#`, so `#` does not begin a comment here.
    pub(super) fn rest(&self) -> Cow<'_, str> {
        String::from_utf8_lossy(self.text[self.keyword().len()..].trim_ascii())
    }
}

fn words(text: &[u8]) -> impl Iterator<Item = &[u8]> {
    text.split(u8::is_ascii_whitespace)
        .filter(|word| !word.is_empty())
}

/// Iterates over the lines that are neither empty nor comments.
#[derive(Clone, Debug)]
pub(super) struct Lines<'a> {
    rest: &'a [u8],
    /// Number of physical lines consumed.
    passed: usize,
}

impl<'a> Lines<'a> {
    /// Iterates over a text that begins after `passed` lines of the file.
    pub(super) fn of(text: &'a [u8], passed: usize) -> Lines<'a> {
        Lines { rest: text, passed }
    }

    /// Returns the number of physical lines consumed.
    pub(super) fn passed(&self) -> usize {
        self.passed
    }

    /// Returns the next physical line, trimmed.
    fn take(&mut self) -> Option<&'a [u8]> {
        if self.rest.is_empty() {
            return None;
        }
        let end = self.rest.iter().position(|&byte| byte == b'\n');
        let (line, rest) = match end {
            Some(end) => (&self.rest[..end], &self.rest[end + 1..]),
            None => (self.rest, &[][..]),
        };
        self.rest = rest;
        self.passed += 1;
        Some(line.trim_ascii())
    }
}

impl<'a> Iterator for Lines<'a> {
    type Item = Line<'a>;

    fn next(&mut self) -> Option<Line<'a>> {
        loop {
            let line = self.take()?;
            let number = self.passed;
            // Comments are not continued, because one may end in a Windows folder name.
            if line.is_empty() || line[0] == b'#' {
                continue;
            }
            let Some(begun) = line.strip_suffix(b"\\") else {
                let text = Cow::Borrowed(line);
                return Some(Line { number, text });
            };
            let mut text = begun.to_vec();
            while let Some(more) = self.take() {
                text.push(b' ');
                match more.strip_suffix(b"\\") {
                    Some(more) => text.extend(more),
                    None => {
                        text.extend(more);
                        break;
                    }
                }
            }
            let text = text.trim_ascii().to_vec();
            if !text.is_empty() && text[0] != b'#' {
                let text = Cow::Owned(text);
                return Some(Line { number, text });
            }
        }
    }
}

/// Returns the bytes without a byte order mark.
pub(super) fn without_mark(bytes: &[u8]) -> &[u8] {
    bytes.strip_prefix(b"\xEF\xBB\xBF").unwrap_or(bytes)
}

/// Returns `true` if the line ends are single carriage returns, as in files of classic Mac OS.
pub(super) fn has_old_line_ends(bytes: &[u8]) -> bool {
    bytes.contains(&b'\r') && !bytes.contains(&b'\n')
}

/// Returns the text with line feeds as line ends.
pub(super) fn with_line_ends(bytes: &[u8]) -> Cow<'_, [u8]> {
    if !has_old_line_ends(bytes) {
        return Cow::Borrowed(bytes);
    }
    let ends = |&byte: &u8| if byte == b'\r' { b'\n' } else { byte };
    Cow::Owned(bytes.iter().map(ends).collect())
}

/// Splits a text at line ends that are not continued, into chunks of about `size` bytes.
pub(super) fn pieces(text: &[u8], size: usize) -> Vec<&[u8]> {
    let mut pieces = Vec::new();
    let mut rest = text;
    while rest.len() > size {
        let is_end = |&byte: &u8| byte == b'\n';
        // Start at the line that contains the desired end, and advance line by line.
        let mut start = rest[..size]
            .iter()
            .rposition(is_end)
            .map_or(0, |before| before + 1);
        let cut = loop {
            let Some(length) = rest[start..].iter().position(is_end) else {
                break rest.len();
            };
            let line = rest[start..start + length].trim_ascii_end();
            start += length + 1;
            if start > size && !line.ends_with(b"\\") {
                break start;
            }
        };
        let (piece, later) = rest.split_at(cut);
        pieces.push(piece);
        rest = later;
    }
    if !rest.is_empty() {
        pieces.push(rest);
    }
    pieces
}

/// Parses a number, which may be NaN or infinite in any common spelling.
pub(super) fn number(word: &[u8]) -> Option<f32> {
    let text = std::str::from_utf8(word).ok()?;
    text.parse().ok().or_else(|| {
        // Spellings of C runtimes on Windows: 1.#QNAN0, -1.#IND00, -nan(ind).
        let text = text.trim_start_matches(['-', '+']);
        (text.starts_with("1.#") || text.starts_with("nan(")).then_some(f32::NAN)
    })
}

/// Returns a word for a message, truncated if it is very long.
pub(super) fn quoted(word: &[u8]) -> String {
    const LONGEST: usize = 40;
    let text = String::from_utf8_lossy(&word[..word.len().min(LONGEST)]).into_owned();
    if word.len() > LONGEST { text + "…" } else { text }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn lines(text: &str) -> Vec<(usize, String)> {
        Lines::of(text.as_bytes(), 0)
            .map(|line| (line.number, String::from_utf8_lossy(&line.text).into_owned()))
            .collect()
    }

    #[test]
    fn lines_end_in_either_way_go_on_after_a_backslash_and_are_counted() {
        let text = "# a\\\r\n\r\n  v 1\t2 3 \r\nf 1 2\\\r\n 3 \\\n4\n\\\n\nend";
        let expected = [(3, "v 1\t2 3"), (4, "f 1 2 3  4"), (9, "end")];
        assert_eq!(lines(text), expected.map(|(n, line)| (n, line.to_owned())));
        assert_eq!(lines("\\"), []);
        assert_eq!(lines("v \\"), [(1, "v".to_owned())]);
    }

    #[test]
    fn words_end_before_a_comment_and_names_do_not() {
        let line = Lines::of(b"usemtl dark  oak #2", 0).next().expect("a line");
        assert_eq!(line.keyword(), b"usemtl");
        assert_eq!(line.words().collect::<Vec<_>>(), [&b"dark"[..], b"oak"]);
        assert_eq!(line.rest(), "dark  oak #2");
    }

    #[test]
    fn pieces_are_whole_lines_and_together_the_text() {
        let text: String = (0..200).map(|n| format!("f {n} \\\n 2 3\nv 1 2 3\r\n")).collect();
        for size in [1, 2, 7, 30, 1000, 100_000] {
            let pieces = pieces(text.as_bytes(), size);
            assert_eq!(pieces.concat(), text.as_bytes());
            let apart: usize = pieces.iter().map(|piece| Lines::of(piece, 0).count()).sum();
            assert_eq!(apart, 400, "pieces of {size}");
        }
        assert!(pieces(b"", 10).is_empty());
    }

    #[test]
    fn numbers_are_read_as_all_programs_write_them() {
        for (word, value) in [
            ("1", 1.0),
            ("-.5", -0.5),
            ("+2.", 2.0),
            ("1e-3", 0.001),
            ("3E+1", 30.0),
        ] {
            assert_eq!(number(word.as_bytes()), Some(value), "{word}");
        }
        for word in [
            "nan",
            "-NaN",
            "inf",
            "-Infinity",
            "1e99",
            "1.#QNAN0",
            "-1.#IND00",
            "-nan(ind)",
        ] {
            assert!(
                number(word.as_bytes()).is_some_and(|value| !value.is_finite()),
                "{word}"
            );
        }
        for word in ["", "1,5", "0x10", "one", "1.0f", "--1", "\u{661}"] {
            assert_eq!(number(word.as_bytes()), None, "{word}");
        }
    }
}
