//! Splits a tile into its tables and its model.

use super::TileError;
use crate::BrokenRule;

pub(super) const BATCHED: &[u8] = b"b3dm";
pub(super) const INSTANCED: &[u8] = b"i3dm";

/// A tile in parts.
#[derive(Debug)]
pub(super) struct Header<'a> {
    /// JSON of the feature table; may be empty.
    pub(super) features: &'a [u8],
    /// Binary part of the feature table.
    pub(super) feature_bytes: &'a [u8],
    pub(super) model: Model<'a>,
}

/// The model of a tile.
#[derive(Clone, Copy, Debug)]
pub(super) enum Model<'a> {
    /// Of a `.b3dm`: glTF, once.
    Single(&'a [u8]),
    /// Of an `.i3dm`: glTF, at each instance.
    Embedded(&'a [u8]),
    /// Of an `.i3dm`: the URI of a glTF file.
    Separate(&'a [u8]),
}

/// Length of the fields that all headers begin with: magic, version, length of the tile.
const COMMON: usize = 12;

/// A length of at least this is no length, but the beginning of JSON (`"`) or of a model (`glTF`).
const NO_LENGTH: u32 = 0x2200_0000;

/// The lengths of the four tables, and where the first begins.
struct Lengths {
    start: usize,
    features: [u32; 2],
    batch: [u32; 2],
}

impl<'a> Header<'a> {
    /// Splits a tile. Two older headers of `.b3dm` have no feature table.
    pub(super) fn read(bytes: &'a [u8]) -> Result<Header<'a>, BrokenRule> {
        let is_instanced = bytes.starts_with(INSTANCED);
        let version = word(bytes, 4)?;
        if version != 1 {
            return Err(TileError::Version(version).into());
        }
        let length = word(bytes, 8)?;
        let end = usize::try_from(length)
            .ok()
            .filter(|&end| end <= bytes.len())
            .ok_or_else(|| cut("tile", length.into(), bytes.len()))?;
        let tile = &bytes[..end];
        let lengths = Lengths::read(tile, is_instanced)?;
        let mut at = lengths.start;
        let mut part = |part: &'static str, length: u32| {
            let end = at as u64 + u64::from(length);
            let inside = usize::try_from(end).ok().and_then(|end| tile.get(at..end));
            let inside = inside.ok_or_else(|| cut(part, end, tile.len()))?;
            at = end as usize;
            Ok::<_, BrokenRule>(inside)
        };
        let features = part("feature table", lengths.features[0])?;
        let feature_bytes = part("feature table", lengths.features[1])?;
        part("batch table", lengths.batch[0])?;
        part("batch table", lengths.batch[1])?;
        let model = &tile[at..];
        if model.is_empty() {
            return Err(TileError::NoModel.into());
        }
        let model = match is_instanced.then(|| word(tile, 28)).transpose()? {
            None => Model::Single(model),
            Some(1) => Model::Embedded(model),
            Some(0) => Model::Separate(model),
            Some(other) => return Err(TileError::GltfFormat(other).into()),
        };
        Ok(Header {
            features,
            feature_bytes,
            model,
        })
    }
}

impl Lengths {
    fn read(tile: &[u8], is_instanced: bool) -> Result<Lengths, BrokenRule> {
        let number = |nth: usize| word(tile, COMMON + 4 * nth);
        let first = [number(0)?, number(1)?];
        if !is_instanced && number(2)? >= NO_LENGTH {
            // Number of batches, length of the batch table.
            return Ok(Lengths {
                start: 20,
                features: [0; 2],
                batch: [first[1], 0],
            });
        }
        if !is_instanced && number(3)? >= NO_LENGTH {
            // Lengths of the batch table, number of batches.
            return Ok(Lengths {
                start: 24,
                features: [0; 2],
                batch: first,
            });
        }
        Ok(Lengths {
            start: if is_instanced { 32 } else { 28 },
            features: first,
            batch: [number(2)?, number(3)?],
        })
    }
}

/// Reads a little-endian number of the header.
fn word(bytes: &[u8], at: usize) -> Result<u32, BrokenRule> {
    let four = bytes.get(at..).and_then(|rest| rest.first_chunk::<4>());
    four.map(|four| u32::from_le_bytes(*four))
        .ok_or_else(|| cut("header", at as u64 + 4, bytes.len()))
}

fn cut(part: &'static str, needs: u64, has: usize) -> BrokenRule {
    BrokenRule::Truncated {
        part,
        needs,
        has: has as u64,
    }
}
