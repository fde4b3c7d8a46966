//! Parses the entity lump: text of the form `{ "key" "value" … }`, repeated.
//!
//! Source: the parsers of the engines (`COM_Parse`). Words without spaces need no quotes, `//` begins a comment, nothing is escaped;
//! if a key repeats, the last value wins.
//! Hostile input: syntax errors are reported by line; nothing is nested.

use crate::BrokenRule;
use crate::budget::Budget;
use crate::quake::BspError;
use crate::quake::bsp::Map;
use std::borrow::Cow;

/// An entity of a map: the world, a light, a door, a player start.
#[derive(Clone, Debug, PartialEq)]
pub(in crate::quake) struct Entity<'t> {
    /// Index in the map's list; 0 is the world.
    pub(in crate::quake) number: usize,
    pairs: Vec<(&'t str, &'t str)>,
}

/// Maximum memory per byte of entity text: one pair per three bytes, as in `a""`, in a list that grows.
const TIMES_ITS_LENGTH: u64 = 32;

/// Returns the entity text of a map, and reserves memory for it and its entities.
pub(in crate::quake) fn text<'m>(map: &'m Map, budget: &mut Budget) -> Result<Cow<'m, str>, BrokenRule> {
    let text = map.lump(map.format.entities);
    budget.take(text.len() as u64 * (3 + TIMES_ITS_LENGTH), || {
        "its entities".to_owned()
    })?;
    Ok(String::from_utf8_lossy(text))
}

/// Parses the entity text of a map.
pub(in crate::quake) fn parse(text: &str) -> Result<Vec<Entity<'_>>, BspError> {
    let mut words = Words { rest: text, line: 1 };
    let mut entities = Vec::new();
    while let Some(word) = words.next()? {
        if word != Word::Open {
            return Err(words.refusal(&word, "`{`"));
        }
        let mut pairs = Vec::new();
        loop {
            let key = match words.next()? {
                Some(Word::Close) => break,
                // Engines drop these spaces too.
                Some(Word::Text(key)) => key.trim_end_matches(' '),
                other => return Err(words.refusal(&other.unwrap_or(Word::End), "a key or `}`")),
            };
            match words.next()? {
                Some(Word::Text(value)) => pairs.push((key, value)),
                other => return Err(words.refusal(&other.unwrap_or(Word::End), "a value")),
            }
        }
        entities.push(Entity {
            number: entities.len(),
            pairs,
        });
    }
    Ok(entities)
}

impl<'t> Entity<'t> {
    /// Returns the value of a key; empty if there is none.
    pub(in crate::quake) fn get(&self, key: &str) -> &'t str {
        let named = self.pairs.iter().rev().find(|pair| pair.0 == key);
        named.map_or("", |pair| pair.1)
    }

    /// Iterates over the keys and values.
    pub(in crate::quake) fn pairs(&self) -> impl Iterator<Item = (&'t str, &'t str)> {
        self.pairs.iter().copied()
    }

    /// Returns the class name, such as `func_door`.
    pub(in crate::quake) fn class(&self) -> &'t str {
        self.get("classname")
    }

    /// Returns the value of a key, if it is a finite number.
    pub(in crate::quake) fn number(&self, key: &str) -> Option<f32> {
        finite(self.get(key))
    }

    /// Returns the first finite number of several keys.
    pub(in crate::quake) fn number_of_any(&self, keys: &[&str]) -> Option<f32> {
        keys.iter().find_map(|key| self.number(key))
    }

    /// Returns the value of a key, if it is three finite numbers.
    pub(in crate::quake) fn three(&self, key: &str) -> Option<[f32; 3]> {
        let mut words = self.get(key).split_whitespace().map(finite);
        let mut next = || words.next().flatten();
        let three = [next()?, next()?, next()?];
        words.next().is_none().then_some(three)
    }

    /// Returns the unique name: class, target name, and index.
    pub(in crate::quake) fn name(&self) -> String {
        let called = ["targetname", "target"].map(|key| self.get(key));
        let called = called.into_iter().find(|name| !name.is_empty());
        let class = match self.class() {
            "" => "entity",
            class => class,
        };
        match called {
            Some(called) => format!("{class} {called}#{}", self.number),
            None => format!("{class}#{}", self.number),
        }
    }
}

fn finite(word: &str) -> Option<f32> {
    word.trim().parse().ok().filter(|number: &f32| number.is_finite())
}

#[derive(Clone, Copy, Debug, PartialEq)]
enum Word<'t> {
    Open,
    Close,
    Text(&'t str),
    End,
}

struct Words<'t> {
    rest: &'t str,
    line: usize,
}

impl<'t> Words<'t> {
    fn next(&mut self) -> Result<Option<Word<'t>>, BspError> {
        loop {
            let blank = self.rest.len() - self.rest.trim_start().len();
            self.skip(blank);
            if !self.rest.starts_with("//") {
                break;
            }
            self.skip(self.rest.find('\n').unwrap_or(self.rest.len()));
        }
        // The text ends with a NUL byte; some compilers leave garbage after it.
        let Some(first) = self.rest.chars().next().filter(|&letter| letter != '\0') else {
            return Ok(None);
        };
        let word = match first {
            '{' => Word::Open,
            '}' => Word::Close,
            '"' => {
                let text = &self.rest[1..];
                let Some(end) = text.find(['"', '\0']).filter(|&end| text[end..].starts_with('"')) else {
                    return Err(self.refusal(&Word::End, "the closing `\"` of a string"));
                };
                self.skip(end + 2);
                return Ok(Some(Word::Text(&text[..end])));
            }
            _ => {
                let ends = |letter: char| letter.is_whitespace() || matches!(letter, '{' | '}' | '"' | '\0');
                let (text, rest) = self
                    .rest
                    .split_at(self.rest.find(ends).unwrap_or(self.rest.len()));
                self.rest = rest;
                return Ok(Some(Word::Text(text)));
            }
        };
        self.rest = &self.rest[1..];
        Ok(Some(word))
    }

    fn skip(&mut self, bytes: usize) {
        let (skipped, rest) = self.rest.split_at(bytes);
        self.line += skipped.bytes().filter(|&byte| byte == b'\n').count();
        self.rest = rest;
    }

    fn refusal(&self, found: &Word, wanted: &'static str) -> BspError {
        let found = match found {
            Word::Open => "`{`".to_owned(),
            Word::Close => "`}`".to_owned(),
            Word::Text(text) => format!("`{}`", text.chars().take(30).collect::<String>().escape_debug()),
            Word::End => "the end".to_owned(),
        };
        BspError::BadEntities {
            line: self.line,
            found,
            wanted,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn refused(text: &str) -> String {
        parse(text).expect_err("a refusal").to_string()
    }

    #[test]
    fn a_door_has_its_keys_and_a_name_that_no_other_has() {
        let text = "{\n\"classname\" \"worldspawn\"\n}\n{ \"classname\" \"func_door\" \"targetname\" \"gate\"\n\
                    \"origin\" \" 8 -16 0.5 \" \"angle\" \"1\" \"angle\" \"nan\" \"wait\" \"x\" }\0{";
        let entities = parse(text).expect("two");
        assert_eq!(entities.len(), 2);
        assert_eq!(entities[0].name(), "worldspawn#0");
        let door = &entities[1];
        assert_eq!(door.name(), "func_door gate#1");
        assert_eq!(door.three("origin"), Some([8.0, -16.0, 0.5]));
        assert_eq!(door.three("angle"), None);
        assert_eq!(door.number("angle"), None, "the last one counts");
        assert_eq!(door.get("speed"), "");
    }

    #[test]
    fn comments_are_skipped_and_words_need_no_quotes() {
        let text = "// A map.\n{\nclassname func_wall // the \"fence\"\n\"alpha \" 0.5}\n//{";
        let entities = parse(text).expect("one");
        assert_eq!(entities.len(), 1);
        assert_eq!(entities[0].class(), "func_wall");
        assert_eq!(entities[0].number("alpha"), Some(0.5));
    }

    #[test]
    fn what_does_not_fit_is_named_by_its_line() {
        for (text, said) in [
            ("\n\nworld", "`world` where `{` is expected, in line 3"),
            ("{ \"a\" }", "`}` where a value is expected, in line 1"),
            ("{\n\"a\n\" {", "`{` where a value is expected, in line 3"),
            (
                "{ \"a\" \"b\"",
                "the end where a key or `}` is expected, in line 1",
            ),
            (
                "{ \"a",
                "the end where the closing `\"` of a string is expected, in line 1",
            ),
            ("{ { }", "`{` where a key or `}` is expected, in line 1"),
            ("\u{e4}", "`\u{e4}` where `{` is expected, in line 1"),
        ] {
            let refused = refused(text);
            assert!(refused.contains(said), "{refused}");
        }
    }
}
