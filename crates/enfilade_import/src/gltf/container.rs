//! Splits a file into its JSON and its binary chunk.

use crate::BrokenRule;

/// The JSON and the binary chunk of a file.
#[derive(Debug, PartialEq)]
pub(super) struct Container<'a> {
    pub(super) json: &'a [u8],
    /// The binary chunk of a `.glb`, if it has one.
    pub(super) binary: Option<&'a [u8]>,
    /// Whether the header of a `.glb` gives its length as 0, as writers do that cannot go back.
    pub(super) has_zero_length: bool,
}

const MAGIC: &[u8] = b"glTF";
const HEADER: usize = 12;
const JSON: [u8; 4] = *b"JSON";
const BINARY: [u8; 4] = *b"BIN\0";

impl<'a> Container<'a> {
    /// Splits a file. The first bytes decide between `.glb` and `.gltf`, because file extensions may be wrong.
    pub(super) fn split(bytes: &'a [u8]) -> Result<Container<'a>, BrokenRule> {
        if is_binary(bytes) {
            return split_binary(bytes);
        }
        if begins_like_json(bytes) {
            let json = without_mark(bytes);
            return Ok(Container {
                json,
                binary: None,
                has_zero_length: false,
            });
        }
        Err(BrokenRule::NotGltf {
            begins: beginning(bytes),
        })
    }
}

/// Returns `true` if the bytes begin like a glTF file.
pub(crate) fn begins_like_gltf(bytes: &[u8]) -> bool {
    bytes.starts_with(MAGIC) || begins_like_json(bytes)
}

fn begins_like_json(bytes: &[u8]) -> bool {
    without_mark(bytes).trim_ascii_start().starts_with(b"{")
}

/// Returns the bytes without a byte order mark.
fn without_mark(bytes: &[u8]) -> &[u8] {
    bytes.strip_prefix(b"\xEF\xBB\xBF").unwrap_or(bytes)
}

/// Describes the first bytes of a file: "begins with `…`", or "is empty".
pub(crate) fn beginning(bytes: &[u8]) -> String {
    match bytes {
        [] => "is empty".to_owned(),
        _ => format!("begins with `{}`", bytes[..bytes.len().min(12)].escape_ascii()),
    }
}

/// Splits a `.glb`: magic, version and length, then chunks, each with its length and type.
fn split_binary(bytes: &[u8]) -> Result<Container<'_>, BrokenRule> {
    let word = |at: usize| bytes.get(at..).and_then(|rest| rest.first_chunk::<4>());
    let has = bytes.len() as u64;
    let cut = |part, needs| BrokenRule::Truncated { part, needs, has };
    let (Some(version), Some(length)) = (word(4), word(8)) else {
        return Err(cut("header", HEADER as u64));
    };
    let version = u32::from_le_bytes(*version);
    if version != 2 {
        return Err(BrokenRule::Version(version.to_string()));
    }
    let has_zero_length = *length == [0; 4];
    let length = if has_zero_length {
        has
    } else {
        u64::from(u32::from_le_bytes(*length))
    };
    let chunk = |part: &'static str, start: usize| {
        let (Some(size), Some(kind)) = (word(start), word(start + 4)) else {
            return Err(cut(part, start as u64 + 8));
        };
        let end = start as u64 + 8 + u64::from(u32::from_le_bytes(*size));
        match usize::try_from(end)
            .ok()
            .and_then(|end| bytes.get(start + 8..end))
        {
            Some(inside) => Ok((*kind, inside, end)),
            None => Err(cut(part, end)),
        }
    };
    let (kind, json, json_end) = chunk("JSON chunk", HEADER)?;
    if kind != JSON {
        return Err(BrokenRule::NoJsonChunk);
    }
    let mut binary = None;
    if json_end + 8 <= length {
        let (kind, inside, _) = chunk("binary chunk", json_end as usize)?;
        binary = (kind == BINARY).then_some(inside);
    }
    if length > has {
        return Err(cut("last chunk", length));
    }
    // Padding is of spaces; some writers pad with zeros.
    let padding = json
        .iter()
        .rev()
        .take_while(|&&byte| matches!(byte, 0 | b' '))
        .count();
    Ok(Container {
        json: without_mark(&json[..json.len() - padding]),
        binary,
        has_zero_length,
    })
}

/// Returns `true` if the bytes are a `.glb`.
pub(super) fn is_binary(bytes: &[u8]) -> bool {
    bytes.starts_with(MAGIC)
}

/// Returns a `.glb` with these two chunks; `None` if it would exceed 4 GiB.
pub(super) fn joined(json: &[u8], binary: &[u8]) -> Option<Vec<u8>> {
    let padded = |bytes: &[u8]| bytes.len().next_multiple_of(4);
    let chunks = [(JSON, json, b' '), (BINARY, binary, 0)];
    let chunks = chunks.iter().filter(|(_, bytes, _)| !bytes.is_empty());
    let length = HEADER
        + chunks
            .clone()
            .map(|(_, bytes, _)| 8 + padded(bytes))
            .sum::<usize>();
    let mut glb = MAGIC.to_vec();
    glb.extend(2_u32.to_le_bytes());
    glb.extend(u32::try_from(length).ok()?.to_le_bytes());
    for &(kind, bytes, padding) in chunks {
        glb.extend((padded(bytes) as u32).to_le_bytes());
        glb.extend(kind);
        glb.extend_from_slice(bytes);
        glb.resize(glb.len() + padded(bytes) - bytes.len(), padding);
    }
    Some(glb)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn json_may_have_space_and_a_byte_order_mark_before_it() {
        for text in ["{}", " \n{}", "\u{feff}{}"] {
            assert!(Container::split(text.as_bytes()).is_ok(), "{text:?}");
        }
    }
}
