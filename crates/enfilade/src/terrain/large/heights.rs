//! Heights that are read as they are needed, out of bytes that may lie in a mapped file.

use crate::terrain::HeightFieldError;

/// Heights at the places of a grid, which some file or generator has and no list.
///
/// They must stay what they are: what was found out of them when a terrain was made of them is what looks skip by.
pub trait Heights: Send + Sync {
    /// Samples from west to east and from north to south.
    fn size(&self) -> [u32; 2];

    /// Reads the heights of one row, the northern being 0, from a column on eastward, as many as `heights` takes. All of them
    /// are there. NaN stands for a hole.
    fn read(&self, column: u32, row: u32, heights: &mut [f32]);
}

/// How a height is stored.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum HeightFormat {
    /// 16 bits without sign, the lower byte first.
    U16Le,
    /// 16 bits without sign, the higher byte first.
    U16Be,
    /// 32 bits of IEEE 754, the lowest byte first.
    F32Le,
    /// 32 bits of IEEE 754, the highest byte first.
    F32Be,
}

impl HeightFormat {
    /// Bytes of a height.
    pub fn bytes(self) -> u64 {
        match self {
            HeightFormat::U16Le | HeightFormat::U16Be => 2,
            HeightFormat::F32Le | HeightFormat::F32Be => 4,
        }
    }

    /// Turns as many bytes as there are heights into them.
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

/// Heights in bytes, row after row, the northern first and each from west to east: a list of bytes, or whatever else lends
/// them, as a map of a file does.
#[derive(Clone, Debug)]
pub struct HeightBytes<B> {
    bytes: B,
    size: [u32; 2],
    format: HeightFormat,
    hole: Option<f32>,
}

impl<B: AsRef<[u8]> + Send + Sync> HeightBytes<B> {
    /// `size` heights from west to east and from north to south; `hole` is the height that stands for none, if one does.
    ///
    /// # Errors
    /// [`HeightFieldError::Bytes`] where there are more or fewer bytes than they take.
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
