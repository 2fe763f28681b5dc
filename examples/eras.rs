//! One planet's history in eight maps, from its first moment to 1,500 My.
//!
//! `cargo run --release --no-default-features --features export --example eras -- [SEED] [FOLDER]`
//!
//! Writes the maps of each moment to FOLDER (`target/eras` by default) and all eight on one sheet,
//! `eras.png`, in rows from the top left. Prints how gathered the continents are: 0 where they lie
//! evenly around the planet, about 0.6 where they form one round supercontinent.

use bevy_tectonics::{export::Maps, prelude::*};
use core::ops::ControlFlow;
use png::{BitDepth, ColorType, Decoder, Encoder};
use std::{
    error::Error,
    fs::File,
    io::{BufReader, BufWriter},
    path::{Path, PathBuf},
};

/// The moments in My.
const MOMENTS: [f64; 8] = [0.0, 150.0, 300.0, 500.0, 750.0, 1_000.0, 1_250.0, 1_500.0];
/// Width of a map in pixels; maps on the sheet are half as wide.
const WIDTH: u32 = 2048;
const COLUMNS: usize = 2;

fn main() -> Result<(), Box<dyn Error>> {
    let mut arguments = std::env::args().skip(1);
    let seed = match arguments.next() {
        Some(seed) => seed.parse()?,
        None => 7,
    };
    let folder = arguments.next();
    let folder = Path::new(folder.as_deref().unwrap_or("target/eras"));
    let last = MOMENTS[MOMENTS.len() - 1];
    let mut history = History::new(Recipe::earth_like(seed).with_duration(last))?;
    let mut sheet = Sheet::new(WIDTH / 2);
    for moment in MOMENTS {
        history.run_until(moment, |_| ControlFlow::Continue(()))?;
        let era = folder.join(format!("{moment:04.0}-my"));
        Maps::new(WIDTH).write(&history.surface()?, &era)?;
        sheet.add(&era.join("map.png"))?;
        let now = history.statistics()?;
        println!(
            "{moment:6.0} My  continents gathered to {:.2}, {:2} plates, {:4.1} % land, {}",
            now.continental_concentration,
            now.plates,
            100.0 * now.land_share,
            era.display(),
        );
    }
    println!("{}", sheet.write(folder)?.display());
    Ok(())
}

/// Maps side by side.
struct Sheet {
    /// Width of one in pixels.
    width: usize,
    maps: Vec<Vec<[u8; 3]>>,
}

impl Sheet {
    fn new(width: u32) -> Self {
        Self {
            width: width as usize,
            maps: Vec::new(),
        }
    }

    /// Adds the map in a file, at half its size.
    fn add(&mut self, path: &Path) -> Result<(), Box<dyn Error>> {
        let mut reader = Decoder::new(BufReader::new(File::open(path)?)).read_info()?;
        let mut bytes = vec![0; reader.output_buffer_size().ok_or("the map is too large")?];
        reader.next_frame(&mut bytes)?;
        let pixel =
            |x: usize, y: usize, c: usize| u32::from(bytes[3 * (2 * self.width * y + x) + c]);
        let half = |i: usize, c: usize| {
            let (x, y) = (2 * (i % self.width), 2 * (i / self.width));
            let sum =
                pixel(x, y, c) + pixel(x + 1, y, c) + pixel(x, y + 1, c) + pixel(x + 1, y + 1, c);
            (sum / 4) as u8
        };
        let size = self.width * self.width / 2;
        self.maps
            .push((0..size).map(|i| [0, 1, 2].map(|c| half(i, c))).collect());
        Ok(())
    }

    fn write(&self, folder: &Path) -> Result<PathBuf, Box<dyn Error>> {
        let height = self.width / 2;
        let rows = self.maps.len().div_ceil(COLUMNS);
        let mut bytes = Vec::with_capacity(3 * self.width * height * COLUMNS * rows);
        for y in 0..rows * height {
            for column in 0..COLUMNS {
                let map = &self.maps[y / height * COLUMNS + column];
                let line = &map[y % height * self.width..][..self.width];
                bytes.extend(line.iter().flatten());
            }
        }
        let path = folder.join("eras.png");
        // Whole or not at all.
        let draft = tempfile::NamedTempFile::new_in(folder)?;
        let mut encoder = Encoder::new(
            BufWriter::new(&draft),
            (self.width * COLUMNS) as u32,
            (rows * height) as u32,
        );
        encoder.set_color(ColorType::Rgb);
        encoder.set_depth(BitDepth::Eight);
        let mut writer = encoder.write_header()?;
        writer.write_image_data(&bytes)?;
        writer.finish()?;
        draft.persist(&path)?;
        Ok(path)
    }
}
