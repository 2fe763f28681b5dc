//! PNG files under construction.

use super::{
    ExportError,
    draft::{Draft, Pen},
};
use png::{BitDepth, ColorType, Encoder, SrgbRenderingIntent, StreamWriter};
use std::{io::Write, path::Path};

/// What a pixel is: 8-bit RGB is colour in sRGB, everything else are numbers.
pub(super) type Format = (ColorType, BitDepth);

/// A PNG file that takes its rows as they come.
pub(super) struct Sheet {
    draft: Draft,
    writer: StreamWriter<'static, Pen>,
}

impl Sheet {
    /// Starts a file of so many pixels in width and height.
    pub(super) fn create(
        folder: &Path,
        name: &str,
        size: (u32, u32),
        format: Format,
    ) -> Result<Self, ExportError> {
        let draft = Draft::create(folder, name)?;
        let writer = encoder(draft.pen(), size, format)
            .write_header()
            .and_then(png::Writer::into_stream_writer)
            .map_err(|error| draft.error(error))?;
        Ok(Self { draft, writer })
    }

    pub(super) fn append(&mut self, bytes: &[u8]) -> Result<(), ExportError> {
        self.writer
            .write_all(bytes)
            .map_err(|error| self.draft.error(error))
    }

    pub(super) fn finish(self) -> Result<Draft, ExportError> {
        self.writer
            .finish()
            .map_err(|error| self.draft.error(error))?;
        Ok(self.draft)
    }
}

/// An encoder that says of colours that they are sRGB.
pub(super) fn encoder<W: Write>(
    writer: W,
    (width, height): (u32, u32),
    (color, depth): Format,
) -> Encoder<'static, W> {
    let mut encoder = Encoder::new(writer, width, height);
    encoder.set_color(color);
    encoder.set_depth(depth);
    if (color, depth) == (ColorType::Rgb, BitDepth::Eight) {
        encoder.set_source_srgb(SrgbRenderingIntent::Perceptual);
    }
    encoder
}

/// The nearest 16-bit value; the cast saturates.
pub(super) fn quantise(value: f32) -> u16 {
    (value + 0.5).floor() as u16
}

/// Metres above the sea as pixels of `elevation.png` hold them.
pub(super) fn metres(elevation: f32) -> u16 {
    quantise(elevation + 32768.0)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn values_round_and_saturate() {
        assert_eq!(quantise(0.4), 0);
        assert_eq!(quantise(0.5), 1);
        assert_eq!(quantise(-3.0), 0);
        assert_eq!(quantise(1e9), u16::MAX);
        assert_eq!(quantise(f32::NAN), 0);
    }
}
