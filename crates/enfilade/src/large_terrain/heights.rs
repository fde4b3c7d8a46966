//! Sources of heights for large terrain: read on demand, for example from a memory-mapped file.
//!
//! [`Heights`] is a trait because this crate opens no file: the caller implements it over its own file or generator, or
//! passes the bytes to [`HeightBytes`].

use crate::terrain::HeightFieldError;

/// Heights of a grid, read on demand from a file or a generator.
///
/// They must not change: culling relies on the minimum and maximum heights computed when the terrain was created.
pub trait Heights: Send + Sync {
    /// Returns the number of samples from west to east and from north to south.
    fn size(&self) -> [u32; 2];

    /// Reads `heights.len()` heights of row `row` (0 is the northernmost), eastward from `column`. All of them exist.
    /// NaN marks a hole.
    fn read(&self, column: u32, row: u32, heights: &mut [f32]);
}

/// Binary format of a height.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum HeightFormat {
    /// Unsigned 16 bits, little-endian.
    U16Le,
    /// Unsigned 16 bits, big-endian.
    U16Be,
    /// IEEE 754 32 bits, little-endian.
    F32Le,
    /// IEEE 754 32 bits, big-endian.
    F32Be,
}

impl HeightFormat {
    /// Returns the number of bytes per height.
    pub fn bytes(self) -> u64 {
        match self {
            HeightFormat::U16Le | HeightFormat::U16Be => 2,
            HeightFormat::F32Le | HeightFormat::F32Be => 4,
        }
    }

    /// Decodes one height per element of `heights`.
    fn decode(self, bytes: &[u8], heights: &mut [f32]) {
        match self {
            HeightFormat::U16Le => each(bytes, heights, |two| f32::from(u16::from_le_bytes(two))),
            HeightFormat::U16Be => each(bytes, heights, |two| f32::from(u16::from_be_bytes(two))),
            HeightFormat::F32Le => each(bytes, heights, f32::from_le_bytes),
            HeightFormat::F32Be => each(bytes, heights, f32::from_be_bytes),
        }
    }
}

fn each<const N: usize>(bytes: &[u8], heights: &mut [f32], decode: impl Fn([u8; N]) -> f32) {
    for (height, &bytes) in heights.iter_mut().zip(bytes.as_chunks::<N>().0) {
        *height = decode(bytes);
    }
}

/// Raw heights in memory, row after row from the north, each row from west to east. `B` is any byte container, such as
/// a `Vec<u8>` or a memory-mapped file.
#[derive(Clone, Debug)]
pub struct HeightBytes<B> {
    bytes: B,
    size: [u32; 2],
    format: HeightFormat,
    hole: Option<f32>,
}

impl<B: AsRef<[u8]> + Send + Sync> HeightBytes<B> {
    /// Interprets `bytes` as `size` heights (west to east, north to south). `hole` is the height that marks a hole, if
    /// any.
    ///
    /// # Errors
    /// [`HeightFieldError::Bytes`] if the number of bytes does not match.
    pub fn new(
        bytes: B,
        size: [u32; 2],
        format: HeightFormat,
        hole: Option<f32>,
    ) -> Result<HeightBytes<B>, HeightFieldError> {
        let count = u64::from(size[0]) * u64::from(size[1]);
        let needs = count.saturating_mul(format.bytes());
        let has = bytes.as_ref().len() as u64;
        if needs != has {
            return Err(HeightFieldError::Bytes { needs, has });
        }
        Ok(HeightBytes {
            bytes,
            size,
            format,
            hole,
        })
    }
}

impl<B: AsRef<[u8]> + Send + Sync> Heights for HeightBytes<B> {
    fn size(&self) -> [u32; 2] {
        self.size
    }

    fn read(&self, column: u32, row: u32, heights: &mut [f32]) {
        let width = self.format.bytes() as usize;
        let first = (row as usize * self.size[0] as usize + column as usize) * width;
        let bytes = &self.bytes.as_ref()[first..first + heights.len() * width];
        self.format.decode(bytes, heights);
        if let Some(hole) = self.hole {
            let holes = heights.iter_mut().filter(|height| **height == hole);
            holes.for_each(|height| *height = f32::NAN);
        }
    }
}
