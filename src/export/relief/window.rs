//! The rows of a map that are needed at a time.

use crate::export::grid::Grid;
use crate::surface::Pixel;

/// A moving band of rows; columns wrap around, rows end at the poles.
pub(super) struct Window {
    grid: Grid,
    first: u32,
    pixels: Vec<Pixel>,
}

impl Window {
    pub(super) fn new(grid: Grid) -> Self {
        Self {
            grid,
            first: 0,
            pixels: Vec::new(),
        }
    }

    /// Appends rows at the southern end.
    pub(super) fn push(&mut self, rows: Vec<Pixel>) {
        self.pixels.extend(rows);
    }

    /// The row after the last.
    pub(super) fn end(&self) -> u32 {
        self.first + (self.pixels.len() / self.grid.width as usize) as u32
    }

    pub(super) fn forget_before(&mut self, row: u32) {
        let count = row.saturating_sub(self.first);
        self.pixels
            .drain(..count as usize * self.grid.width as usize);
        self.first += count;
    }

    /// The pixel, or the nearest row's that the window holds.
    pub(super) fn at(&self, x: i64, y: i64) -> &Pixel {
        let width = i64::from(self.grid.width);
        let row = y.clamp(i64::from(self.first), i64::from(self.end()) - 1) - i64::from(self.first);
        &self.pixels[(row * width + x.rem_euclid(width)) as usize]
    }
}
