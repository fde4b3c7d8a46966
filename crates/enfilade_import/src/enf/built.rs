//! Estimates what MessagePack becomes in memory, before it is parsed.
//!
//! One byte may become a list of its own, so the length says nothing. The text is walked once, without allocating, and each
//! value is charged for the largest type that it can be in a [`StoredScene`](super::stored::StoredScene), and in the rooms built
//! from it.
//! Cost: a few nanoseconds per value.

use serde::de::{Deserialize, Deserializer, MapAccess, SeqAccess, Visitor};
use std::fmt;

/// Memory that a value takes once it is parsed and built, in bytes.
pub(super) struct BuiltBytes(pub(super) u64);

/// Of a number: an index in a list, and the shared pointer that it becomes.
const NUMBER: u64 = 16;
/// Of a text, beside its characters.
const TEXT: u64 = 48;
/// Of a list or a structure, beside its values; lists grow by doubling.
const LIST: u64 = 80;
/// Of an entry of a map, beside its key and value.
const ENTRY: u64 = 32;

impl<'de> Deserialize<'de> for BuiltBytes {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<BuiltBytes, D::Error> {
        deserializer.deserialize_any(Walk)
    }
}

struct Walk;

impl<'de> Visitor<'de> for Walk {
    type Value = BuiltBytes;

    fn expecting(&self, f: &mut fmt::Formatter) -> fmt::Result {
        f.write_str("a value")
    }

    fn visit_bool<E>(self, _: bool) -> Result<BuiltBytes, E> {
        Ok(BuiltBytes(NUMBER))
    }

    fn visit_u64<E>(self, _: u64) -> Result<BuiltBytes, E> {
        Ok(BuiltBytes(NUMBER))
    }

    fn visit_i64<E>(self, _: i64) -> Result<BuiltBytes, E> {
        Ok(BuiltBytes(NUMBER))
    }

    fn visit_f64<E>(self, _: f64) -> Result<BuiltBytes, E> {
        Ok(BuiltBytes(NUMBER))
    }

    fn visit_unit<E>(self) -> Result<BuiltBytes, E> {
        Ok(BuiltBytes(NUMBER))
    }

    fn visit_str<E>(self, text: &str) -> Result<BuiltBytes, E> {
        Ok(BuiltBytes(TEXT + 2 * text.len() as u64))
    }

    fn visit_bytes<E>(self, bytes: &[u8]) -> Result<BuiltBytes, E> {
        Ok(BuiltBytes(TEXT + 2 * bytes.len() as u64))
    }

    fn visit_seq<A: SeqAccess<'de>>(self, mut values: A) -> Result<BuiltBytes, A::Error> {
        let mut sum = LIST;
        while let Some(BuiltBytes(bytes)) = values.next_element()? {
            sum += bytes;
        }
        Ok(BuiltBytes(sum))
    }

    fn visit_map<A: MapAccess<'de>>(self, mut entries: A) -> Result<BuiltBytes, A::Error> {
        let mut sum = LIST;
        while let Some((BuiltBytes(key), BuiltBytes(value))) = entries.next_entry()? {
            sum += ENTRY + key + value;
        }
        Ok(BuiltBytes(sum))
    }
}
