//! Height maps.

use crate::simulation::{HeightMap, ImageStart, TectonicError};
use png::{BitDepth, ColorType, Decoder, DecodingError, Limits};
use std::io::{self, BufRead, Seek};

/// Widest map of interlaced rows, in pixels: those must be held as a whole.
const WIDEST_INTERLACED: usize = 10_800;

/// What a height map must be.
const ALLOWED: &str = "a PNG, grey with 8 or 16 bits, twice as wide as high";

/// Reads a height map, in m above the sea.
pub(super) fn read<R: BufRead + Seek>(
    image: &ImageStart,
    open: &mut impl FnMut(&str) -> io::Result<R>,
) -> Result<HeightMap, TectonicError> {
    let path = image.heights.as_str();
    if path.is_empty() {
        return Err(TectonicError::Recipe {
            field: "start.image.heights".into(),
            value: "empty".into(),
            allowed: format!("the path of {ALLOWED}"),
        });
    }
    let refuse = |found: String, allowed: String| TectonicError::import(path, found, allowed);
    let broken = |error: DecodingError| {
        let found = match &error {
            DecodingError::IoError(error) if error.kind() == io::ErrorKind::UnexpectedEof => {
                "it ends too early".into()
            }
            _ => format!("it cannot be read ({error})"),
        };
        refuse(found, ALLOWED.into())
    };
    let file = open(path)
        .map_err(|error| refuse(format!("it cannot be opened ({error})"), ALLOWED.into()))?;
    let rows = 2 * HeightMap::WIDTHS.end();
    let limits = Limits { bytes: 2 * rows };
    let decoder = Decoder::new_with_limits(file, limits);
    let mut reader = decoder.read_info().map_err(broken)?;
    let info = reader.info();
    let (width, height) = (info.width as usize, info.height as usize);
    let wide = match (info.color_type, info.bit_depth) {
        (ColorType::Grayscale, BitDepth::Eight) => false,
        (ColorType::Grayscale, BitDepth::Sixteen) => true,
        (color, depth) => {
            let found = format!("it is {color:?} with {} bits", depth as u8);
            return Err(refuse(found, ALLOWED.into()));
        }
    };
    HeightMap::check_size(width, height)
        .map_err(|allowed| refuse(format!("it is {width} × {height} pixels"), allowed))?;
    if reader.info().interlaced && width > WIDEST_INTERLACED {
        let found = format!("it is interlaced and {width} pixels wide");
        let allowed = format!("at most {WIDEST_INTERLACED} pixels where rows are interlaced");
        return Err(refuse(found, allowed));
    }
    let scale = (image.highest_m - image.lowest_m) / if wide { 65_535.0 } else { 255.0 };
    let black = image.lowest_m - image.sea_level_m;
    let height_of = |grey: u16| (black + scale * f64::from(grey)) as f32;
    let mut metres = vec![0.0_f32; width * height];
    if reader.info().interlaced {
        let mut pixels = vec![0; width * height * if wide { 2 } else { 1 }];
        reader.next_frame(&mut pixels).map_err(broken)?;
        fill(&mut metres, &pixels, wide, height_of);
    } else {
        for row in metres.chunks_exact_mut(width) {
            let Some(pixels) = reader.next_row().map_err(broken)? else {
                return Err(refuse("it ends too early".into(), ALLOWED.into()));
            };
            fill(row, pixels.data(), wide, height_of);
        }
    }
    HeightMap::new(width, metres)
}

/// Turns greys into heights.
fn fill(heights: &mut [f32], pixels: &[u8], wide: bool, height_of: impl Fn(u16) -> f32) {
    if wide {
        for (height, grey) in heights.iter_mut().zip(pixels.chunks_exact(2)) {
            *height = height_of(u16::from_be_bytes([grey[0], grey[1]]));
        }
    } else {
        for (height, grey) in heights.iter_mut().zip(pixels) {
            *height = height_of(u16::from(*grey));
        }
    }
}
