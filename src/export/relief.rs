//! `map.png`: the planet as an atlas draws it.

mod boundary;
mod window;

use std::{f32::consts::FRAC_1_SQRT_2, f64::consts::PI};

use glam::{Vec2, Vec3};

use super::grid::{Grid, share_rows};
use crate::simulation::Surface;
use crate::surface::{
    Pixel, direction,
    ground::ramp,
    tint::{Climate, Wander},
};
use boundary::Boundaries;
use window::Window;

/// Directions the light comes from, east and north, with their shares. Mostly north-west, as maps have
/// it; the others keep ridges that run along the light visible.
const LIGHTS: [(Vec2, f32); 3] = [
    (Vec2::new(-FRAC_1_SQRT_2, FRAC_1_SQRT_2), 0.6),
    (Vec2::new(-1.0, 0.0), 0.2),
    (Vec2::new(0.2588, 0.9659), 0.2),
];
/// Shading of slopes at a pixel of this size is exaggerated by [`EXAGGERATION`].
const REFERENCE_PIXEL_KM: f32 = 20.0;
const EXAGGERATION: f32 = 26.0;
/// Terrain detail in the shading beyond what the elevation has, as a share of the height.
const FLOURISH: f32 = 0.10;

/// Paints rows as they arrive, from north to south.
pub(super) struct Painter {
    grid: Grid,
    window: Window,
    wander: Wander,
    boundaries: Boundaries,
    /// Pixels over which the broad component of the shading is measured.
    broad: i64,
    metres_per_pixel: f32,
    exaggeration: f32,
    painted: u32,
}

impl Painter {
    pub(super) fn new(grid: Grid, surface: &Surface) -> Self {
        let metres_per_pixel = (surface.radius_km * 1000.0 * PI / f64::from(grid.height)) as f32;
        let pixel_km = metres_per_pixel / 1000.0;
        let spacing =
            (4.0 * PI / surface.mesh.sites().len() as f64).sqrt() * f64::from(grid.height) / PI;
        Self {
            grid,
            window: Window::new(grid),
            wander: Wander::new(surface.seed),
            boundaries: Boundaries::new(grid, 0.9 * spacing),
            broad: (i64::from(grid.width) / 512).max(2),
            metres_per_pixel,
            // Slopes grow as pixels shrink, roughly with the root: terrain is fractal.
            exaggeration: EXAGGERATION * (pixel_km / REFERENCE_PIXEL_KM).clamp(0.05, 6.0).sqrt(),
            painted: 0,
        }
    }

    /// Takes the next rows and returns all that can be painted now, 3 bytes a pixel.
    pub(super) fn paint(&mut self, pixels: Vec<Pixel>, threads: usize) -> Vec<u8> {
        self.window.push(pixels);
        let halo = self.boundaries.reach().max(self.broad as u32);
        let ready = self.window.end();
        let end = if ready == self.grid.height {
            ready
        } else {
            ready.saturating_sub(halo)
        };
        let rows = self.painted..end.max(self.painted);
        let width = self.grid.width as usize;
        let mut colours = vec![0; 3 * width * rows.len()];
        share_rows(
            threads,
            rows.start,
            3 * width,
            &mut colours,
            |first, rows| {
                self.strip(first, rows);
            },
        );
        self.painted = rows.end;
        self.window.forget_before(self.painted.saturating_sub(halo));
        colours
    }

    fn strip(&self, first: u32, colours: &mut [u8]) {
        let width = self.grid.width as usize;
        let count = (colours.len() / (3 * width)) as u32;
        let lines = self.boundaries.draw(&self.window, first..first + count);
        for ((y, row), lines) in (first..)
            .zip(colours.chunks_mut(3 * width))
            .zip(lines.chunks(width))
        {
            for ((x, bytes), line) in (0..).zip(row.chunks_mut(3)).zip(lines) {
                let (ground, land) = self.ground(x, y);
                let colour = line.over(ground, land).clamp(Vec3::ZERO, Vec3::ONE);
                for (byte, component) in bytes.iter_mut().zip(colour.to_array()) {
                    *byte = (component * 255.0 + 0.5) as u8;
                }
            }
        }
    }

    /// The colour of a pixel, and which share of it is land.
    fn ground(&self, x: u32, y: u32) -> (Vec3, f32) {
        let (column, line) = (i64::from(x), i64::from(y));
        let latitude = self.grid.latitude(y);
        let place = direction(self.grid.longitude(x), latitude).as_vec3();
        let climate = Climate::at(latitude.to_degrees() as f32, self.wander.at(place));
        let elevation = self.window.at(column, line).elevation;

        let fine = self.slope(column, line, 1, latitude);
        let broad = self.slope(column, line, self.broad, latitude);
        let land = self.coverage(column, line, elevation);
        let sea = climate.sea(elevation.min(-1.0)) * self.shade(fine * 0.35 + broad * 0.35, 0.75);
        let ground = climate.land(elevation.max(1.0)) * self.shade(fine * 0.75 + broad * 0.45, 1.0);
        let shore = sea.lerp(ground, land);
        // A thin darker line where land meets sea, as engraved coasts have.
        (shore * (1.0 - 0.9 * land * (1.0 - land)), land)
    }

    /// Slope to the east and north over `step` pixels, in metres per metre of ground.
    fn slope(&self, x: i64, y: i64, step: i64, latitude: f64) -> Vec2 {
        let height = |x, y| {
            let pixel = self.window.at(x, y);
            // The sea bed does not shade the coast: the two are lit apart.
            let above = pixel
                .elevation
                .max(-400.0 + 0.35 * pixel.elevation.min(0.0));
            above + FLOURISH * pixel.elevation.max(0.0) * pixel.grain
        };
        let distance = 2.0 * step as f32 * self.metres_per_pixel;
        let squeeze = (libm::cos(latitude) as f32).max(0.12);
        Vec2::new(
            (height(x + step, y) - height(x - step, y)) / (distance * squeeze),
            (height(x, y - step) - height(x, y + step)) / distance,
        )
    }

    /// Brightness of a slope, 1 on a plain.
    fn shade(&self, slope: Vec2, strength: f32) -> f32 {
        let tilt = slope * self.exaggeration;
        // Lambert's cosine law under a light 45 degrees high, relative to level ground.
        let steep = (1.0 + tilt.length_squared()).sqrt();
        let lit: f32 = LIGHTS
            .iter()
            .map(|&(light, share)| share * (1.0 - tilt.dot(light)).max(0.0))
            .sum();
        (1.0 + strength * (lit / steep - 1.0)).clamp(0.42, 1.35)
    }

    /// Share of a pixel that is land: antialiases the coast.
    fn coverage(&self, x: i64, y: i64, elevation: f32) -> f32 {
        let rise = |dx, dy| self.window.at(x + dx, y + dy).elevation - elevation;
        let steepest = [(1, 0), (-1, 0), (0, 1), (0, -1)]
            .into_iter()
            .map(|(dx, dy)| rise(dx, dy).abs())
            .fold(1.0_f32, f32::max);
        ramp(-0.5, 0.5, elevation / steepest)
    }
}
