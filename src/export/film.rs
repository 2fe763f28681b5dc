//! A history as pictures: numbered maps, or one that moves.

use super::{
    ExportError, Maps,
    draft::{self, Draft, Pen},
    grid::Grid,
    maps::PICTURE,
    sheet::{Sheet, encoder},
};
use crate::simulation::Surface;
use std::{
    ops::RangeInclusive,
    path::{Path, PathBuf},
};

/// Name of the file that a [`Film`] becomes.
pub const FILM_FILE: &str = "history.png";

impl Maps {
    /// Writes `map.png` alone, under a number of four digits or more: `map_0007.png`. What makes films
    /// of pictures takes them in that order.
    ///
    /// # Errors
    /// [`ExportError`] names the file and the cause; nothing half-written is left behind.
    pub fn write_frame(
        &self,
        surface: &Surface,
        folder: &Path,
        number: u32,
    ) -> Result<PathBuf, ExportError> {
        self.validate()?;
        let name = format!("map_{number:04}.png");
        let size = Grid::new(self.width).size();
        let mut sheet = Sheet::create(folder, &name, size, PICTURE)?;
        self.paint(surface, &mut |rows| sheet.append(rows))?;
        draft::publish(vec![sheet.finish()?])?;
        Ok(folder.join(name))
    }
}

/// `history.png`: the map of a history as it moves, an animated PNG for browsers and viewers.
///
/// Pictures are added one by one and go into a file under a temporary name, which [`finish`](Self::finish)
/// gives its own. A film that is dropped before leaves nothing.
///
/// ```no_run
/// use bevy_tectonics::export::{ExportError, Film, Maps};
/// use bevy_tectonics::prelude::*;
/// use core::ops::ControlFlow;
///
/// # fn example(mut history: History) -> Result<(), ExportError> {
/// let mut film = Film::create("planet".as_ref(), Maps::new(1024), 26)?;
/// for picture in 0..26 {
///     history.run_until(10.0 * f64::from(picture), |_| ControlFlow::Continue(()))?;
///     film.add(&history.surface()?)?;
/// }
/// film.finish()?;
/// # Ok(()) }
/// ```
pub struct Film {
    maps: Maps,
    draft: Draft,
    writer: png::Writer<Pen>,
    added: u32,
    pictures: u32,
}

impl Film {
    /// Allowed widths, pixels; only even ones.
    pub const WIDTHS: RangeInclusive<u32> = 16..=4096;
    /// Allowed numbers of pictures.
    pub const PICTURES: RangeInclusive<u32> = 1..=10_000;
    /// Pictures a second.
    pub const RATE: u16 = 12;

    /// Begins a film of so many pictures, within [`Self::PICTURES`]. The format wants to know beforehand.
    ///
    /// # Errors
    /// [`ExportError`] names the file and the cause, or what is allowed.
    pub fn create(folder: &Path, maps: Maps, pictures: u32) -> Result<Self, ExportError> {
        maps.validate()?;
        if !Self::WIDTHS.contains(&maps.width) {
            return Err(ExportError::FilmWidth(maps.width));
        }
        if !Self::PICTURES.contains(&pictures) {
            return Err(ExportError::Pictures(pictures));
        }
        let draft = Draft::create(folder, FILM_FILE)?;
        let mut encoder = encoder(draft.pen(), Grid::new(maps.width).size(), PICTURE);
        let writer = encoder
            .set_animated(pictures, 0)
            .and_then(|()| encoder.set_frame_delay(1, Self::RATE))
            .and_then(|()| encoder.write_header())
            .map_err(|error| draft.error(error))?;
        Ok(Self {
            maps,
            draft,
            writer,
            added: 0,
            pictures,
        })
    }

    /// Adds the next picture.
    ///
    /// # Errors
    /// [`ExportError`] names the file and the cause; [`ExportError::Pictures`] if there is one too many.
    pub fn add(&mut self, surface: &Surface) -> Result<(), ExportError> {
        if self.added == self.pictures {
            return Err(ExportError::Pictures(self.added + 1));
        }
        let mut picture = Vec::with_capacity(3 * (self.maps.width * self.maps.width / 2) as usize);
        self.maps.paint(surface, &mut |rows| {
            picture.extend(rows);
            Ok(())
        })?;
        self.writer
            .write_image_data(&picture)
            .map_err(|error| self.draft.error(error))?;
        self.added += 1;
        Ok(())
    }

    /// Number of pictures that are still missing.
    #[must_use]
    pub fn missing(&self) -> u32 {
        self.pictures - self.added
    }

    /// Completes the file and returns its path.
    ///
    /// # Errors
    /// [`ExportError`] names the file and the cause; [`ExportError::Pictures`] tells how many there are
    /// if some are missing. Then the file is neither written nor replaced.
    pub fn finish(self) -> Result<PathBuf, ExportError> {
        if self.missing() > 0 {
            return Err(ExportError::Pictures(self.added));
        }
        self.writer
            .finish()
            .map_err(|error| self.draft.error(error))?;
        let paths = draft::publish(vec![self.draft])?;
        Ok(paths.into_iter().next().unwrap_or_default())
    }
}
