//! The map files.

use std::{
    num::NonZero,
    ops::{Range, RangeInclusive},
    path::{Path, PathBuf},
};

use png::{BitDepth, ColorType};

use super::{
    ExportError,
    draft::{self, Draft},
    grid::{Grid, east_north, sample_rows},
    relief::Painter,
    sheet::{Format, Sheet, metres, quantise},
};
use crate::simulation::{Crust, Surface};
use crate::surface::{Pixel, Raster};

/// Format of `map.png`.
pub(super) const PICTURE: Format = (ColorType::Rgb, BitDepth::Eight);

/// How large to draw maps, and with how many threads.
///
/// ```no_run
/// # use bevy_tectonics::{export::{ExportError, Maps}, simulation::Surface};
/// # fn example(surface: &Surface) -> Result<(), ExportError> {
/// Maps::new(2048).write(surface, "planet".as_ref())?;
/// # Ok(()) }
/// ```
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Maps {
    /// Pixels from west to east, even, within [`Self::WIDTHS`]. The height is half of it.
    pub width: u32,
    /// Threads to sample with, within [`Self::THREADS`]. The maps do not depend on it.
    pub threads: usize,
}

impl Maps {
    /// Allowed widths, pixels; only even ones.
    pub const WIDTHS: RangeInclusive<u32> = 16..=16384;
    /// Allowed numbers of threads.
    pub const THREADS: RangeInclusive<usize> = 1..=256;

    /// Maps of a width, with one thread per core.
    #[must_use]
    pub fn new(width: u32) -> Self {
        let cores = std::thread::available_parallelism().map_or(1, NonZero::get);
        Self {
            width,
            threads: cores.min(*Self::THREADS.end()),
        }
    }

    /// Says whether the settings can be used.
    ///
    /// # Errors
    /// [`ExportError::Width`] or [`ExportError::Threads`].
    pub fn validate(&self) -> Result<(), ExportError> {
        if !Self::WIDTHS.contains(&self.width) || !self.width.is_multiple_of(2) {
            return Err(ExportError::Width(self.width));
        }
        if !Self::THREADS.contains(&self.threads) {
            return Err(ExportError::Threads(self.threads));
        }
        Ok(())
    }

    /// Writes the seven maps into `folder`, which is created where it does not exist, and returns their
    /// paths.
    ///
    /// # Errors
    /// [`ExportError`] names the file and the cause; nothing half-written is left behind.
    pub fn write(&self, surface: &Surface, folder: &Path) -> Result<Vec<PathBuf>, ExportError> {
        self.write_with_progress(surface, folder, |_| ())
    }

    /// As [`write`](Self::write), telling `progress` now and then which fraction is done, 0 to 1.
    ///
    /// # Errors
    /// As [`write`](Self::write).
    pub fn write_with_progress(
        &self,
        surface: &Surface,
        folder: &Path,
        mut progress: impl FnMut(f64),
    ) -> Result<Vec<PathBuf>, ExportError> {
        draft::publish(self.draft(surface, folder, &mut progress)?)
    }

    pub(super) fn draft(
        &self,
        surface: &Surface,
        folder: &Path,
        progress: &mut dyn FnMut(f64),
    ) -> Result<Vec<Draft>, ExportError> {
        self.validate()?;
        let grid = Grid::new(self.width);
        let mut data = Data::ALL
            .into_iter()
            .map(|map| {
                let sheet = Sheet::create(folder, map.name(), grid.size(), map.format())?;
                Ok((map, sheet))
            })
            .collect::<Result<Vec<_>, ExportError>>()?;
        let mut picture = Sheet::create(folder, "map.png", grid.size(), PICTURE)?;
        let mut painter = Painter::new(grid, surface);
        self.sample(surface, &mut |rows, pixels| {
            std::thread::scope(|scope| {
                let share = data.len().div_ceil(self.threads);
                let writers: Vec<_> = data
                    .chunks_mut(share)
                    .map(|maps| {
                        let (rows, pixels) = (rows.clone(), &pixels);
                        scope.spawn(move || {
                            maps.iter_mut().try_for_each(|(map, sheet)| {
                                sheet.append(&map.encode(grid, rows.clone(), pixels))
                            })
                        })
                    })
                    .collect();
                writers
                    .into_iter()
                    .try_for_each(|writer| match writer.join() {
                        Ok(result) => result,
                        Err(panic) => std::panic::resume_unwind(panic),
                    })
            })?;
            picture.append(&painter.paint(pixels, self.threads))?;
            progress(f64::from(rows.end) / f64::from(grid.height));
            Ok(())
        })?;
        let sheets = data.into_iter().map(|(_, sheet)| sheet).chain([picture]);
        sheets.map(Sheet::finish).collect()
    }

    /// Hands the rows of `map.png` to `take`, from north to south.
    pub(super) fn paint(
        &self,
        surface: &Surface,
        take: &mut dyn FnMut(&[u8]) -> Result<(), ExportError>,
    ) -> Result<(), ExportError> {
        let mut painter = Painter::new(Grid::new(self.width), surface);
        self.sample(surface, &mut |_, pixels| {
            take(&painter.paint(pixels, self.threads))
        })
    }

    /// Hands bands of rows to `take`, from north to south.
    fn sample(
        &self,
        surface: &Surface,
        take: &mut dyn FnMut(Range<u32>, Vec<Pixel>) -> Result<(), ExportError>,
    ) -> Result<(), ExportError> {
        self.validate()?;
        let raster = Raster::new(surface)?;
        let grid = Grid::new(self.width);
        // Bands keep the memory of the widest map at some hundred megabytes.
        let band = (1_u32 << 20).div_ceil(self.width).clamp(8, grid.height);
        for first in (0..grid.height).step_by(band as usize) {
            let rows = first..grid.height.min(first + band);
            take(rows.clone(), sample_rows(&raster, grid, rows, self.threads))?;
        }
        Ok(())
    }
}

/// The maps that programs read.
#[derive(Clone, Copy)]
enum Data {
    Elevation,
    Crust,
    Age,
    Plate,
    VelocityEast,
    VelocityNorth,
}

impl Data {
    const ALL: [Self; 6] = [
        Self::Elevation,
        Self::Crust,
        Self::Age,
        Self::Plate,
        Self::VelocityEast,
        Self::VelocityNorth,
    ];

    fn name(self) -> &'static str {
        match self {
            Self::Elevation => "elevation.png",
            Self::Crust => "crust.png",
            Self::Age => "age.png",
            Self::Plate => "plate.png",
            Self::VelocityEast => "velocity_east.png",
            Self::VelocityNorth => "velocity_north.png",
        }
    }

    fn format(self) -> Format {
        let depth = if matches!(self, Self::Crust) {
            BitDepth::Eight
        } else {
            BitDepth::Sixteen
        };
        (ColorType::Grayscale, depth)
    }

    fn encode(self, grid: Grid, rows: Range<u32>, pixels: &[Pixel]) -> Vec<u8> {
        if matches!(self, Self::Crust) {
            let shade = |pixel: &Pixel| {
                if pixel.crust == Crust::Continental {
                    255
                } else {
                    0
                }
            };
            return pixels.iter().map(shade).collect();
        }
        let mut bytes = Vec::with_capacity(2 * pixels.len());
        for (y, row) in rows.zip(pixels.chunks(grid.width as usize)) {
            let latitude = grid.latitude(y);
            for (x, pixel) in (0..).zip(row) {
                let value = match self {
                    Self::Elevation => metres(pixel.elevation),
                    Self::Age => quantise(pixel.age * 10.0),
                    Self::Plate => pixel.plate,
                    Self::VelocityEast | Self::VelocityNorth => {
                        let (east, north) = east_north(grid.longitude(x), latitude);
                        let axis = if matches!(self, Self::VelocityEast) {
                            east
                        } else {
                            north
                        };
                        quantise(pixel.velocity.dot(axis) * 100.0 + 32768.0)
                    }
                    Self::Crust => 0,
                };
                bytes.extend(value.to_be_bytes());
            }
        }
        bytes
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn widths_and_threads_are_checked() {
        for width in [0, 14, 15, 17, 16386, u32::MAX] {
            let message = Maps { width, threads: 1 }
                .validate()
                .unwrap_err()
                .to_string();
            assert!(message.contains("16 to 16384"), "{message}");
        }
        assert!(
            Maps {
                width: 16,
                threads: 1
            }
            .validate()
            .is_ok()
        );
        assert!(
            Maps {
                width: 16384,
                threads: 256
            }
            .validate()
            .is_ok()
        );
        assert!(
            Maps {
                width: 512,
                threads: 0
            }
            .validate()
            .is_err()
        );
        assert!(Maps::new(512).validate().is_ok());
    }
}
