//! Animated PNG clips.

use image::RgbImage;
use png::{BitDepth, BlendOp, ColorType, Compression, DisposeOp, EncodingError, Writer};
use std::io::Write;

/// Writes an animated PNG frame by frame; it loops forever.
///
/// Each frame stores only the pixels that differ from the previous one.
pub struct Clip<W: Write> {
    writer: Writer<W>,
    last: Vec<u8>,
    frame: Vec<u8>,
}

impl<W: Write> Clip<W> {
    /// Starts a clip of `frames` frames of `size` pixels.
    ///
    /// # Errors
    /// An error of the writer, or no frames, or no pixels.
    pub fn new(
        file: W,
        size: [u32; 2],
        frames: u32,
        frames_per_second: u16,
    ) -> Result<Clip<W>, EncodingError> {
        let mut encoder = png::Encoder::new(file, size[0], size[1]);
        encoder.set_color(ColorType::Rgba);
        encoder.set_depth(BitDepth::Eight);
        encoder.set_compression(Compression::High);
        encoder.validate_sequence(true);
        encoder.set_animated(frames, 0)?;
        encoder.set_frame_delay(1, frames_per_second)?;
        encoder.set_blend_op(BlendOp::Over)?;
        encoder.set_dispose_op(DisposeOp::None)?;
        Ok(Clip {
            writer: encoder.write_header()?,
            last: Vec::new(),
            frame: Vec::new(),
        })
    }

    /// Adds the next frame.
    ///
    /// # Errors
    /// An error of the writer, or a picture of another size than the clip, or a frame too many.
    pub fn add(&mut self, picture: &RgbImage) -> Result<(), EncodingError> {
        let pixels = picture.as_raw();
        self.frame.clear();
        for (i, pixel) in pixels.chunks_exact(3).enumerate() {
            let same = self.last.get(3 * i..3 * i + 3) == Some(pixel);
            let [r, g, b] = [pixel[0], pixel[1], pixel[2]];
            // Transparent pixels keep the previous frame's colour.
            self.frame.extend(if same { [0; 4] } else { [r, g, b, 255] });
        }
        self.writer.write_image_data(&self.frame)?;
        self.last.clone_from(pixels);
        Ok(())
    }

    /// Finishes the file.
    ///
    /// # Errors
    /// An error of the writer, or missing frames.
    pub fn finish(self) -> Result<(), EncodingError> {
        self.writer.finish()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use image::Rgb;

    #[test]
    fn a_frame_shows_the_one_before_where_nothing_has_changed() {
        let mut picture = RgbImage::from_pixel(64, 48, Rgb([10, 120, 200]));
        let mut file = Vec::new();
        let mut clip = Clip::new(&mut file, [64, 48], 3, 12).expect("a clip");
        for x in [5, 25, 45] {
            picture.put_pixel(x, 20, Rgb([255, 255, 255]));
            clip.add(&picture).expect("a frame");
        }
        clip.finish().expect("three frames");
        let mut reader = png::Decoder::new(std::io::Cursor::new(&file))
            .read_info()
            .expect("a PNG");
        assert_eq!(
            reader.info().animation_control.map(|control| control.num_frames),
            Some(3)
        );
        let mut frame = vec![0; reader.output_buffer_size().expect("small")];
        let mut shown = vec![[0; 3]; 64 * 48];
        for _ in 0..3 {
            reader.next_frame(&mut frame).expect("a frame");
            for (pixel, new) in shown.iter_mut().zip(frame.chunks_exact(4)) {
                if new[3] > 0 {
                    *pixel = [new[0], new[1], new[2]];
                }
            }
        }
        let expected: Vec<[u8; 3]> = picture.pixels().map(|pixel| pixel.0).collect();
        assert_eq!(shown, expected);
        assert!(file.len() < 1500, "{}", file.len());
    }

    #[test]
    fn a_clip_without_all_its_frames_is_an_error() {
        let mut clip = Clip::new(Vec::new(), [4, 4], 2, 12).expect("a clip");
        clip.add(&RgbImage::new(4, 4)).expect("a frame");
        assert!(clip.finish().is_err());
        assert!(Clip::new(Vec::new(), [4, 4], 0, 12).is_err());
    }
}
