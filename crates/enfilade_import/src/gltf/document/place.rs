//! Finds places in the JSON text: the element at the position of an error, and properties that are null.
//!
//! Reads tokens without recursion and without checking the grammar.
//! Cost: O(bytes); only if the text cannot be parsed, or has a null.

use super::short;
use serde::Deserialize;
use std::borrow::Cow;
use std::ops::Range;

/// An object or array around the current token.
struct Frame {
    is_array: bool,
    /// Index of the current element of an array.
    index: usize,
    /// The key of the current property of an object, with its quotes.
    key: Option<Range<usize>>,
    /// Start of the current value.
    value: usize,
    /// The last comma of an object that is not blanked.
    comma: Option<usize>,
}

/// Nesting that is followed; the parser refuses deeper text.
const MAX_DEPTH: usize = 128;

/// A token of JSON.
#[derive(Clone, Copy, PartialEq)]
enum Token {
    Open,
    Close,
    Comma,
    Key,
    Null,
    /// Any other value.
    Value,
}

/// Reads tokens, and keeps what is around them.
struct Tokens<'j> {
    json: &'j [u8],
    at: usize,
    frames: Vec<Frame>,
}

impl<'j> Tokens<'j> {
    fn new(json: &'j [u8]) -> Tokens<'j> {
        Tokens {
            json,
            at: 0,
            frames: Vec::new(),
        }
    }

    /// Returns the position and first byte of the next token.
    fn peek(&self) -> Option<(usize, u8)> {
        let rest = self.json.iter().enumerate().skip(self.at);
        let mut tokens = rest.filter(|(_, byte)| !b" \t\r\n:".contains(byte));
        tokens.next().map(|(at, byte)| (at, *byte))
    }

    /// Returns the next token and its bytes. Containers are entered and left.
    fn next(&mut self) -> Option<(Token, Range<usize>)> {
        while let Some(&byte) = self.json.get(self.at) {
            let start = self.at;
            self.at += 1;
            let token = match byte {
                b' ' | b'\t' | b'\r' | b'\n' | b':' => continue,
                b'{' | b'[' => {
                    self.value_at(start);
                    if self.frames.len() == MAX_DEPTH {
                        return None;
                    }
                    self.frames.push(Frame {
                        is_array: byte == b'[',
                        index: 0,
                        key: None,
                        value: start,
                        comma: None,
                    });
                    Token::Open
                }
                b'}' | b']' => {
                    self.frames.pop();
                    Token::Close
                }
                b',' => {
                    if let Some(frame) = self.frames.last_mut() {
                        frame.index += 1;
                        frame.key = None;
                    }
                    Token::Comma
                }
                b'"' => self.string(start),
                _ => self.word(start),
            };
            return Some((token, start..self.at));
        }
        None
    }

    fn string(&mut self, start: usize) -> Token {
        while let Some(&byte) = self.json.get(self.at) {
            self.at += 1;
            match byte {
                b'\\' => self.at += 1,
                b'"' => break,
                _ => {}
            }
        }
        self.at = self.at.min(self.json.len());
        match self.frames.last_mut() {
            Some(frame) if !frame.is_array && frame.key.is_none() => {
                frame.key = Some(start..self.at);
                Token::Key
            }
            _ => {
                self.value_at(start);
                Token::Value
            }
        }
    }

    fn word(&mut self, start: usize) -> Token {
        let ends = |byte: &u8| b" \t\r\n,:]}[{\"".contains(byte);
        let rest = &self.json[self.at..];
        self.at += rest.iter().position(ends).unwrap_or(rest.len());
        self.value_at(start);
        match &self.json[start..self.at] {
            b"null" => Token::Null,
            _ => Token::Value,
        }
    }

    fn value_at(&mut self, start: usize) {
        if let Some(frame) = self.frames.last_mut() {
            frame.value = start;
        }
    }

    fn key(&self, frame: &Frame) -> Option<Cow<'j, str>> {
        let key = &self.json[frame.key.clone()?];
        serde_json::from_slice::<String>(key).ok().map(Cow::Owned)
    }

    /// Returns the place of the current value in words: `nodes[3] "Door", in children`. Elements of the document are those
    /// at `depth` containers.
    fn place(&self, depth: usize) -> String {
        let mut place = String::new();
        for (number, frame) in self.frames.iter().enumerate() {
            let before = place.len();
            if frame.is_array {
                place += &format!("[{}]", frame.index);
            } else if let Some(key) = self.key(frame) {
                let dot = if place.is_empty() || place.ends_with(", in ") {
                    ""
                } else {
                    "."
                };
                place += &format!("{dot}{}", short(&key));
            }
            if number + 1 == depth && frame.is_array && place.len() > before {
                if let Some(name) = name(&self.json[frame.value..]) {
                    place += &format!(" {:?}", short(&name));
                }
                if self.frames.len() > depth {
                    place += ", in ";
                }
            }
        }
        place.trim_end_matches(", in ").to_owned()
    }
}

/// Returns the name of the element that begins here.
fn name(json: &[u8]) -> Option<String> {
    #[derive(Deserialize)]
    struct Named {
        name: String,
    }
    let mut elements = serde_json::Deserializer::from_slice(json).into_iter::<Named>();
    elements.next()?.ok().map(|named| named.name)
}

/// Returns the place of an error in words; empty at the top. `depth` is 2 in the document, and 1 in one of its lists.
pub(super) fn of_error(json: &[u8], why: &serde_json::Error, depth: usize) -> String {
    let lines = json.split_inclusive(|&byte| byte == b'\n');
    let line: usize = lines.take(why.line().saturating_sub(1)).map(<[u8]>::len).sum();
    let end = (line + why.column()).min(json.len());
    let mut tokens = Tokens::new(json);
    let mut place = String::new();
    while let Some((start, byte)) = tokens.peek() {
        // A comma would end the property, and a bracket open or close a container.
        if start >= end || (byte == b',' && start + 1 >= end) {
            break;
        }
        let Some((token, bytes)) = tokens.next() else {
            break;
        };
        if bytes.end >= end {
            if token == Token::Open {
                tokens.frames.pop();
            }
            place = tokens.place(depth);
            break;
        }
    }
    if place.is_empty() {
        tokens.place(depth)
    } else {
        place
    }
}

/// A step of a path in the JSON.
#[derive(Clone, Debug, PartialEq)]
pub(in crate::gltf) enum PathStep {
    Key(String),
    Index(usize),
}

/// Calls `found` with the path of each extension, outside `extras`: the keys and indices down to its name.
pub(in crate::gltf) fn extensions(json: &[u8], mut found: impl FnMut(&[PathStep])) {
    let mut tokens = Tokens::new(json);
    while let Some((token, _)) = tokens.next() {
        let [.., above, own] = &*tokens.frames else {
            continue;
        };
        let is_extension =
            token == Token::Key && !own.is_array && tokens.key(above).is_some_and(|key| key == "extensions");
        if !is_extension {
            continue;
        }
        let step = |frame: &Frame| match tokens.key(frame) {
            Some(key) if !frame.is_array => PathStep::Key(key.into_owned()),
            _ => PathStep::Index(frame.index),
        };
        let path: Vec<PathStep> = tokens.frames.iter().map(step).collect();
        if !path.contains(&PathStep::Key("extras".to_owned())) {
            found(&path);
        }
    }
}

/// Returns the text without properties that are null, outside `extras`, and calls `found` with the place of each. Lines and
/// columns stay the same.
pub(super) fn without_nulls(json: &[u8], mut found: impl FnMut(&dyn Fn() -> String)) -> Vec<u8> {
    let mut text = json.to_vec();
    let mut tokens = Tokens::new(json);
    // A null property whose following comma is to be blanked too, if there is one.
    let mut is_open = false;
    while let Some((token, bytes)) = tokens.next() {
        match token {
            Token::Comma => {
                if std::mem::take(&mut is_open) {
                    text[bytes.start] = b' ';
                } else if let Some(frame) = tokens.frames.last_mut() {
                    frame.comma = Some(bytes.start);
                }
                continue;
            }
            Token::Null => {
                let in_extras = |frame: &Frame| tokens.key(frame).is_some_and(|key| key == "extras");
                let Some(key) = tokens.frames.last().and_then(|frame| frame.key.clone()) else {
                    continue;
                };
                if tokens.frames.iter().any(in_extras) {
                    continue;
                }
                found(&|| tokens.place(2));
                let is_space = |byte: &&mut u8| !byte.is_ascii_whitespace();
                text[key.start..bytes.end]
                    .iter_mut()
                    .filter(is_space)
                    .for_each(|byte| *byte = b' ');
                is_open = is_followed_by_comma(&json[bytes.end..]);
                if !is_open && let Some(comma) = tokens.frames.last_mut().and_then(|frame| frame.comma.take())
                {
                    text[comma] = b' ';
                }
            }
            _ => {}
        }
    }
    text
}

fn is_followed_by_comma(json: &[u8]) -> bool {
    json.trim_ascii_start().starts_with(b",")
}

#[cfg(test)]
mod tests {
    use super::*;
    use serde_json::Value;

    #[test]
    fn properties_that_are_null_vanish_and_all_else_stays_where_it_is() {
        for (json, expected, places) in [
            (r#"{"a":null}"#, r#"{}"#, &["a"][..]),
            (r#"{"a":null,"b":null}"#, "{}", &["a", "b"]),
            (r#"{"a":1,"b":null,"c":null}"#, r#"{"a":1}"#, &["b", "c"]),
            (
                r#"{"a":1,"b":null,"c":2,"d":null}"#,
                r#"{"a":1,"c":2}"#,
                &["b", "d"],
            ),
            (
                r#"{"nodes":[{"name":"x\"y","children":null},{"children" : null , "mesh":0}]}"#,
                r#"{"nodes":[{"name":"x\"y"},{"mesh":0}]}"#,
                &[r#"nodes[0] "x\"y", in children"#, "nodes[1], in children"],
            ),
            (
                r#"{"a":[null,1],"b":"null","c":{}}"#,
                r#"{"a":[null,1],"b":"null","c":{}}"#,
                &[],
            ),
            (
                r#"{"extras":{"a":null},"b":[{"extras":null,"c":null}]}"#,
                r#"{"extras":{"a":null},"b":[{"extras":null}]}"#,
                &["b[0], in c"],
            ),
        ] {
            let mut found = Vec::new();
            let text = without_nulls(json.as_bytes(), |place| found.push(place()));
            assert_eq!(text.len(), json.len(), "{json}");
            let [text, expected] = [&*text, expected.as_bytes()].map(serde_json::from_slice::<Value>);
            assert_eq!(text.expect(json), expected.expect("JSON"), "{json}");
            assert_eq!(found, places, "{json}");
        }
    }

    #[test]
    fn text_that_is_no_json_ends() {
        for json in [
            "",
            "{",
            "]]]",
            "{\"",
            "{\"a\\",
            "[\"\\",
            "{,,}",
            "nul",
            "{\"a\":null",
            "{:null:,}",
        ] {
            without_nulls(json.as_bytes(), |place| drop(place()));
        }
        let deep = "[".repeat(100_000);
        without_nulls(deep.as_bytes(), |place| drop(place()));
    }
}
