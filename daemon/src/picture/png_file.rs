//! A picture as a PNG file.

use std::fs::File;
use std::io::{self, BufWriter, Write};
use std::path::Path;

use super::Canvas;

/// Writes a picture.
///
/// # Errors
/// What the system says of the file.
pub fn write_png(path: &Path, canvas: &Canvas) -> io::Result<()> {
    let mut file = BufWriter::new(File::create(path)?);
    encode(&mut file, canvas)?;
    file.flush()
}

fn encode(out: &mut impl Write, canvas: &Canvas) -> io::Result<()> {
    let size = |pixels: usize| u32::try_from(pixels).map_err(io::Error::other);
    let mut encoder = png::Encoder::new(out, size(canvas.width())?, size(canvas.height())?);
    encoder.set_color(png::ColorType::Rgb);
    encoder.set_depth(png::BitDepth::Eight);
    encoder.set_source_srgb(png::SrgbRenderingIntent::Perceptual);
    encoder.set_compression(png::Compression::High);
    let mut writer = encoder.write_header().map_err(io::Error::other)?;
    writer.write_image_data(&canvas.to_rgb()).map_err(io::Error::other)?;
    writer.finish().map_err(io::Error::other)
}

#[cfg(test)]
mod tests {
    use super::super::canvas::linear;
    use super::*;
    use glam::Vec2;

    #[test]
    fn a_decoder_reads_back_what_was_drawn() {
        // Given a picture with one red disc
        let mut canvas = Canvas::new(30, 20, linear([10, 20, 30]));
        canvas.disc(Vec2::new(15.0, 10.0), 4.0, (linear([255, 0, 0]), 1.0));
        // When it is written and read
        let mut bytes = Vec::new();
        encode(&mut bytes, &canvas).unwrap();
        let mut reader = png::Decoder::new(io::Cursor::new(bytes)).read_info().unwrap();
        let mut pixels = vec![0; reader.output_buffer_size().unwrap()];
        let info = reader.next_frame(&mut pixels).unwrap();
        // Then size and colours are the same
        assert_eq!((info.width, info.height, info.color_type), (30, 20, png::ColorType::Rgb));
        assert_eq!(pixels[..3], [10, 20, 30]);
        assert_eq!(pixels[(10 * 30 + 15) * 3..][..3], [255, 0, 0]);
    }
}
