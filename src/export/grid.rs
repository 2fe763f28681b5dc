//! Equirectangular grids of pixels, and surfaces sampled on them.

use std::{f64::consts::PI, ops::Range};

use glam::{DVec3, Vec3};

use crate::surface::{Pixel, Raster, direction, raster::Hints};

/// Unit vectors to the east and north at a longitude and latitude.
pub(super) fn east_north(longitude: f64, latitude: f64) -> (Vec3, Vec3) {
    let (sin_lon, cos_lon) = libm::sincos(longitude);
    let (sin_lat, cos_lat) = libm::sincos(latitude);
    let east = DVec3::new(-sin_lon, cos_lon, 0.0);
    let north = DVec3::new(-sin_lat * cos_lon, -sin_lat * sin_lon, cos_lat);
    (east.as_vec3(), north.as_vec3())
}

/// Pixel centres of an equirectangular map, in radians.
#[derive(Clone, Copy, Debug)]
pub(super) struct Grid {
    pub(super) width: u32,
    pub(super) height: u32,
}

impl Grid {
    pub(super) fn new(width: u32) -> Self {
        Self {
            width,
            height: width / 2,
        }
    }

    pub(super) fn size(self) -> (u32, u32) {
        (self.width, self.height)
    }

    /// West and east of the map longitudes go on.
    pub(super) fn longitude(self, x: impl Into<f64>) -> f64 {
        -PI + (x.into() + 0.5) * 2.0 * PI / f64::from(self.width)
    }

    /// Beyond the poles latitudes go on, down the other side.
    pub(super) fn latitude(self, y: impl Into<f64>) -> f64 {
        PI / 2.0 - (y.into() + 0.5) * PI / f64::from(self.height)
    }
}

/// One map row from west to east. Every row starts from the same place, so that rows do not depend
/// on the order in which threads take them.
fn sample_row(raster: &Raster, grid: Grid, y: u32, row: &mut [Pixel]) {
    let mut hints = Hints::default();
    let latitude = grid.latitude(y);
    for (x, pixel) in (0..).zip(row) {
        *pixel = raster.look(direction(grid.longitude(x), latitude), &mut hints);
    }
}

/// Several rows, shared out over `threads`.
pub(super) fn sample_rows(
    raster: &Raster,
    grid: Grid,
    rows: Range<u32>,
    threads: usize,
) -> Vec<Pixel> {
    let width = grid.width as usize;
    let mut pixels = vec![Pixel::default(); rows.len() * width];
    share_rows(threads, rows.start, width, &mut pixels, |first, rows| {
        for (y, row) in (first..).zip(rows.chunks_mut(width)) {
            sample_row(raster, grid, y, row);
        }
    });
    pixels
}

/// Shares rows of a width out over threads; `work` gets the number of its first row with its rows.
pub(super) fn share_rows<T: Send>(
    threads: usize,
    first: u32,
    width: usize,
    all: &mut [T],
    work: impl Fn(u32, &mut [T]) + Sync,
) {
    let share = (all.len() / width).div_ceil(threads.max(1)).max(1);
    std::thread::scope(|scope| {
        for (first, rows) in (first..).step_by(share).zip(all.chunks_mut(share * width)) {
            let work = &work;
            scope.spawn(move || work(first, rows));
        }
    });
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn pixel_centres_follow_the_promise() {
        let grid = Grid::new(16);
        assert!((grid.longitude(0).to_degrees() + 168.75).abs() < 1e-12);
        assert!((grid.longitude(15).to_degrees() - 168.75).abs() < 1e-12);
        assert!((grid.latitude(0).to_degrees() - 78.75).abs() < 1e-12);
        assert!((grid.latitude(7).to_degrees() + 78.75).abs() < 1e-12);
    }

    #[test]
    fn east_and_north_are_derivatives_of_direction() {
        let (lon, lat, step) = (0.7, -0.4, 1e-6);
        let (east, north) = east_north(lon, lat);
        let numeric_north =
            (direction(lon, lat + step) - direction(lon, lat - step)) / (2.0 * step);
        let numeric_east = (direction(lon + step, lat) - direction(lon - step, lat)).normalize();
        assert!((north.as_dvec3() - numeric_north).length() < 1e-6);
        assert!((east.as_dvec3() - numeric_east).length() < 1e-6);
    }
}
