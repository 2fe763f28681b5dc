//! The ground as a material has it: heights, normals and colours without light.

use super::{ExportError, chart::Chart, check_surface, grid::share_rows};
use crate::simulation::Surface;
use crate::surface::{
    Raster, Relief,
    ground::ramp,
    raster::Hints,
    tint::{Climate, Wander},
};
use glam::{DVec3, Vec3};
use std::ops::Range;

/// Texels that are worked on at a time: memory stays below a hundred megabytes.
const BAND: u32 = 1 << 20;

/// The ground at the middle of a texel.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Texel {
    /// Metres above the sea.
    pub(super) elevation: f32,
    /// To the right of the picture, to its top, and away from the planet.
    pub(super) normal: Vec3,
    /// sRGB.
    pub(super) colour: [u8; 3],
}

/// A surface that is being painted on charts.
pub(super) struct Skin<'a> {
    raster: Raster<'a>,
    wander: Wander,
    relief: Relief,
    /// Radii of the planet per metre of elevation.
    scale: f64,
    threads: usize,
}

/// A place with its height.
#[derive(Clone, Copy, Default)]
struct Sample {
    place: DVec3,
    elevation: f32,
}

impl<'a> Skin<'a> {
    pub(super) fn new(
        surface: &'a Surface,
        relief: Relief,
        threads: usize,
    ) -> Result<Self, ExportError> {
        check_surface(surface)?;
        Ok(Self {
            raster: Raster::new(surface)?,
            wander: Wander::new(surface.seed),
            relief,
            scale: relief.scale(surface.radius_km),
            threads,
        })
    }

    /// Hands whole rows of a chart to `take`, from top to bottom, with the share that is done.
    pub(super) fn paint(
        &self,
        chart: Chart,
        take: &mut dyn FnMut(&[Texel], f64) -> Result<(), ExportError>,
    ) -> Result<(), ExportError> {
        let (width, height) = chart.size();
        let band = BAND.div_ceil(width).clamp(8, height.max(8));
        for first in (0..height).step_by(band as usize) {
            let rows = first..height.min(first + band);
            let texels = self.band(chart, rows.clone());
            take(&texels, f64::from(rows.end) / f64::from(height))?;
        }
        Ok(())
    }

    /// Height of the ground in a direction, metres.
    pub(super) fn elevation(&self, place: DVec3, hints: &mut Hints) -> f32 {
        self.raster.look(place, hints).elevation
    }

    /// Place of the drawn ground, in radii of the planet.
    pub(super) fn point(&self, place: DVec3, elevation: f32) -> DVec3 {
        place * (1.0 + self.scale * self.relief.height(f64::from(elevation)))
    }

    fn band(&self, chart: Chart, rows: Range<u32>) -> Vec<Texel> {
        let (width, wide) = (chart.size().0 as usize, chart.size().0 as usize + 2);
        // One row and one column more on each side: slopes need neighbours.
        let mut samples = vec![Sample::default(); wide * (rows.len() + 2)];
        self.rows(rows.start, wide, &mut samples, |y, row| {
            // Every row starts from the same place, so that rows do not depend on threads.
            let mut hints = Hints::default();
            for (x, sample) in (-1..).zip(row) {
                let place = chart.direction(x, y as i32 - 1);
                let elevation = self.elevation(place, &mut hints);
                *sample = Sample { place, elevation };
            }
        });
        let mut texels = vec![Texel::default(); width * rows.len()];
        self.rows(rows.start, width, &mut texels, |y, row| {
            let above = (y - rows.start) as usize * wide;
            let lines = [0, 1, 2].map(|line| &samples[above + line * wide..][..wide]);
            for (x, texel) in row.iter_mut().enumerate() {
                let [up, here, down] = lines.map(|line| &line[x..x + 3]);
                let across = [here[0], here[2], up[1], down[1]];
                let frame = chart.right_up(x as i32, y as i32, here[1].place);
                *texel = self.texel(here[1], across, frame);
            }
        });
        texels
    }

    /// Works on each row of pixels with its number.
    fn rows<T: Send>(
        &self,
        first: u32,
        width: usize,
        pixels: &mut [T],
        work: impl Fn(u32, &mut [T]) + Sync,
    ) {
        share_rows(self.threads, first, width, pixels, |first, rows| {
            for (y, row) in (first..).zip(rows.chunks_mut(width)) {
                work(y, row);
            }
        });
    }

    /// The ground at a sample between those to the left, right, top and bottom.
    fn texel(&self, here: Sample, around: [Sample; 4], [right, up]: [Vec3; 2]) -> Texel {
        let [west, east, north, south] =
            around.map(|sample| self.point(sample.place, sample.elevation));
        let out = here.place.as_vec3();
        let normal = (east - west)
            .cross(north - south)
            .normalize_or(here.place)
            .as_vec3();
        let climate = Climate::at(
            libm::asin(here.place.z.clamp(-1.0, 1.0)).to_degrees() as f32,
            self.wander.at(out),
        );
        // The share of the texel that is land: coasts are smooth.
        let steepest = around
            .into_iter()
            .map(|sample| (sample.elevation - here.elevation).abs())
            .fold(1.0_f32, f32::max);
        let land = ramp(-0.5, 0.5, here.elevation / steepest);
        let sea = climate.sea(here.elevation.min(-1.0));
        let ground = climate.land(here.elevation.max(1.0));
        let colour = sea.lerp(ground, land).clamp(Vec3::ZERO, Vec3::ONE);
        Texel {
            elevation: here.elevation,
            normal: Vec3::new(normal.dot(right), normal.dot(up), normal.dot(out)),
            colour: colour.to_array().map(|c| (c * 255.0 + 0.5) as u8),
        }
    }
}
