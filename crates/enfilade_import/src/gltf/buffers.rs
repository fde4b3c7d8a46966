//! Loads buffers from the binary chunk, separate files and data URIs, and decodes compressed buffer views.

use super::address::fetch;
use super::compressed::Compressed;
use super::document::{Document, find};
use crate::BrokenRule;
use crate::budget::Budget;
use std::borrow::Cow;
use std::collections::{BTreeMap, BTreeSet};
use std::path::Path;

/// The bytes of used buffers, each at least as long as declared, and of decoded buffer views.
#[derive(Debug)]
pub(super) struct Buffers<'a> {
    loaded: Vec<Option<Cow<'a, [u8]>>>,
    decoded: BTreeMap<u32, Vec<u8>>,
}

/// The memory that holds the elements of an accessor.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub(super) enum Source {
    Buffer(u32),
    /// A compressed buffer view, decoded.
    View(u32),
}

impl<'a> Buffers<'a> {
    /// Loads buffers and decodes compressed buffer views; `used` may repeat both.
    pub(super) fn load(
        document: &Document,
        used: impl Iterator<Item = Source>,
        binary: Option<&'a [u8]>,
        folder: Option<&Path>,
        budget: &mut Budget,
    ) -> Result<Buffers<'a>, BrokenRule> {
        let used: BTreeSet<Source> = used.collect();
        let mut buffers = Buffers {
            loaded: Vec::new(),
            decoded: BTreeMap::new(),
        };
        buffers.loaded.resize_with(document.buffers.len(), || None);
        let mut views = Vec::new();
        for source in used {
            let buffer = match source {
                Source::Buffer(buffer) => buffer,
                Source::View(view) => match Compressed::of(document, view)? {
                    Some(compressed) => {
                        views.push((view, compressed));
                        compressed.buffer
                    }
                    None => continue,
                },
            };
            if buffers.loaded[buffer as usize].is_none() {
                buffers.loaded[buffer as usize] = Some(load(document, buffer, binary, folder, budget)?);
            }
        }
        buffers.decode(&views, budget)?;
        Ok(buffers)
    }

    /// Decodes compressed views. Filters work in place, so the memory is that of the decoded bytes.
    fn decode(&mut self, views: &[(u32, Compressed)], budget: &mut Budget) -> Result<(), BrokenRule> {
        for (view, compressed) in views {
            budget.take(compressed.decoded_bytes(), || format!("bufferView {view}"))?;
            let bytes = compressed.decode(self.bytes(Source::Buffer(compressed.buffer)))?;
            self.decoded.insert(*view, bytes);
        }
        Ok(())
    }

    /// Returns the bytes of a loaded buffer or decoded buffer view.
    pub(super) fn bytes(&self, source: Source) -> &[u8] {
        match source {
            Source::Buffer(buffer) => self.loaded[buffer as usize].as_deref(),
            Source::View(view) => self.decoded.get(&view).map(Vec::as_slice),
        }
        .expect("all sources of accessors are loaded")
    }
}

fn load<'a>(
    document: &Document,
    index: u32,
    binary: Option<&'a [u8]>,
    folder: Option<&Path>,
    budget: &mut Budget,
) -> Result<Cow<'a, [u8]>, BrokenRule> {
    let place = || format!("buffer {index}");
    let buffer = find(&document.buffers, index, "buffer", || "the document".to_owned())?;
    let needs = buffer.byte_length;
    let bytes = if !buffer.uri.is_empty() {
        Cow::Owned(fetch(&buffer.uri, needs, &place, folder, budget)?)
    } else {
        // Only the first buffer can be the binary chunk.
        let chunk = binary.filter(|_| index == 0);
        Cow::Borrowed(chunk.ok_or_else(|| BrokenRule::BufferWithoutBytes { place: place() })?)
    };
    let has = bytes.len() as u64;
    if has < needs {
        return Err(BrokenRule::BufferTooShort {
            place: place(),
            needs,
            has,
        });
    }
    Ok(bytes)
}
