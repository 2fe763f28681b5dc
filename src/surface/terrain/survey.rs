//! Measured ground: tiles of real elevation that exemplars are cut from.

use super::exemplar::{Exemplar, ExemplarError, SIDE, TEXEL_M};
use glam::DVec2;

/// Height that stands for a hole in the data of a tile.
const VOID: i16 = -32_768;
/// Samples along the side of an SRTM tile, of one and of three seconds of arc.
const SRTM_SIDES: [usize; 2] = [3601, 1201];
/// Length of a degree of latitude in m.
const DEGREE_M: f64 = 111_195.0;
/// Texels over which a piece goes over into its own opposite side.
const SEAM: usize = 32;
/// Samples taken along each side of a texel, of which it is the mean.
const PER_TEXEL: usize = 5;

/// A rectangle of measured heights, from north to south and from west to east.
///
/// ```
/// use bevy_tectonics::surface::Survey;
///
/// // A tile as SRTM has them, 1201 × 1201 heights: here ridges 3 km apart that run north.
/// let height = |i: usize| (300.0 * libm::sin((i % 1201) as f64 * 0.15)) as i16;
/// let tile: Vec<u8> = (0..1201 * 1201).flat_map(|i| height(i).to_be_bytes()).collect();
/// let survey = Survey::from_hgt(&tile, 46.0)?;
/// let exemplar = survey.exemplar([0.5, 0.5], 0.0)?;
/// # let _ = exemplar;
/// # Ok::<(), bevy_tectonics::surface::ExemplarError>(())
/// ```
#[derive(Debug, Clone, PartialEq)]
pub struct Survey {
    heights: Vec<f32>,
    columns: usize,
    /// Distance of samples in m, eastwards and southwards.
    spacing_m: DVec2,
}

impl Survey {
    /// From heights in any unit, so many in a row, at these distances eastwards and southwards in m.
    ///
    /// # Errors
    /// [`ExemplarError::Survey`] if there are no two full rows of two, or if a distance is not above 0.
    pub fn new(
        heights: Vec<f32>,
        columns: usize,
        spacing_m: [f64; 2],
    ) -> Result<Self, ExemplarError> {
        let refused = |what: String| Err(ExemplarError::Survey(what));
        if columns < 2 || heights.len() / columns < 2 || !heights.len().is_multiple_of(columns) {
            let found = heights.len();
            return refused(format!(
                "{found} heights are not two or more full rows of {columns}, of 2 or more each"
            ));
        }
        if spacing_m.iter().any(|d| !(d.is_finite() && *d > 0.0)) {
            return refused(format!(
                "distances of {spacing_m:?} m between heights are not above 0"
            ));
        }
        Ok(Self {
            heights,
            columns,
            spacing_m: spacing_m.into(),
        })
    }

    /// From a tile of the Shuttle Radar Topography Mission (`.hgt`): a degree each way, 1201 × 1201 or
    /// 3601 × 3601 heights of 16 bits, the high byte first. Its name says at which latitude, in degrees, its
    /// southern edge lies.
    ///
    /// # Errors
    /// [`ExemplarError::Survey`] for any other size, or a latitude that is none. Holes are refused where an exemplar
    /// would have them.
    pub fn from_hgt(bytes: &[u8], latitude: f64) -> Result<Self, ExemplarError> {
        let size = |side: &&usize| 2 * **side * **side == bytes.len();
        let Some(&side) = SRTM_SIDES.iter().find(size) else {
            return Err(ExemplarError::Survey(format!(
                "{} bytes are no SRTM tile: it has 2,884,802 or 25,934,402",
                bytes.len()
            )));
        };
        if !(-90.0..=89.0).contains(&latitude) {
            return Err(ExemplarError::Survey(format!(
                "a tile's southern edge cannot lie at {latitude}°, but from -90° to 89°"
            )));
        }
        let (pairs, _) = bytes.as_chunks::<2>();
        let heights = pairs.iter().map(|pair| match i16::from_be_bytes(*pair) {
            VOID => f32::NAN,
            height => f32::from(height),
        });
        let south = DEGREE_M / (side - 1) as f64;
        let east = south * libm::cos((latitude + 0.5).to_radians());
        Self::new(heights.collect(), side, [east, south])
    }

    /// A square of 46 km of it around a place, as shares of its width from the west and of its height from the
    /// north. Rows of an exemplar run along the fold: `strike` is the direction of that, in degrees from north
    /// towards east. The ground's tilt is taken away, and the far sides of the square go over into each other.
    ///
    /// # Errors
    /// [`ExemplarError::Survey`] if the square does not fit in; [`ExemplarError::Void`] where it has a hole; as
    /// [`Exemplar::new`].
    pub fn exemplar(&self, place: [f64; 2], strike: f64) -> Result<Exemplar, ExemplarError> {
        let rows = self.heights.len() / self.columns;
        let last = DVec2::new((self.columns - 1) as f64, (rows - 1) as f64);
        let middle = DVec2::from(place) * last;
        let (sin, cos) = libm::sincos(strike.to_radians());
        // Southwards counts up. Across the fold is to the left of it, as where exemplars are laid down.
        let (along, across) = (DVec2::new(sin, -cos), DVec2::new(-cos, -sin));
        let side = SIDE + SEAM;
        let half = 0.5 * side as f64;
        let at = |[x, y]: [f64; 2]| {
            let from_middle = (along * (x - half) + across * (y - half)) * f64::from(TEXEL_M);
            middle + from_middle / self.spacing_m
        };
        let full = side as f64;
        let corners = [[0.0, 0.0], [full, 0.0], [0.0, full], [full, full]].map(at);
        let fits = |corner: &DVec2| corner.cmpge(DVec2::ZERO).all() && corner.cmple(last).all();
        if !corners.iter().all(fits) {
            let size = last * self.spacing_m / 1e3;
            return Err(ExemplarError::Survey(format!(
                "a square of {:.0} km around {place:?}, turned by {strike}°, does not fit into {:.0} × {:.0} km",
                full * f64::from(TEXEL_M) / 1e3,
                size.x,
                size.y
            )));
        }
        let step = 1.0 / PER_TEXEL as f64;
        let mut heights = Vec::with_capacity(side * side);
        for i in 0..side * side {
            let mut sum = 0.0;
            for j in 0..PER_TEXEL * PER_TEXEL {
                let inside = [j % PER_TEXEL, j / PER_TEXEL].map(|k| (k as f64 + 0.5) * step);
                let place = at([(i % side) as f64 + inside[0], (i / side) as f64 + inside[1]]);
                sum += self.at(place)?;
            }
            heights.push(sum / (PER_TEXEL * PER_TEXEL) as f64);
        }
        level(&mut heights, side);
        Exemplar::new(&seamless(&heights, side))
    }

    /// Height between four samples, at a place in samples; the first hole among them is refused.
    fn at(&self, place: DVec2) -> Result<f64, ExemplarError> {
        let corner = place.floor();
        let share = place - corner;
        let (column, row) = (corner.x as usize, corner.y as usize);
        let mut sum = 0.0;
        for (i, j) in [(0, 0), (1, 0), (0, 1), (1, 1)] {
            let weight = (if i == 1 { share.x } else { 1.0 - share.x })
                * (if j == 1 { share.y } else { 1.0 - share.y });
            if weight <= 0.0 {
                continue;
            }
            let number = (row + j) * self.columns + column + i;
            let height = self.heights[number];
            if !height.is_finite() || height == f32::from(VOID) {
                return Err(ExemplarError::Void(number));
            }
            sum += weight * f64::from(height);
        }
        Ok(sum)
    }
}

/// Takes the plane away that lies nearest to a square of heights.
fn level(heights: &mut [f64], side: usize) {
    let middle = 0.5 * (side - 1) as f64;
    let place = |i: usize| DVec2::new((i % side) as f64 - middle, (i / side) as f64 - middle);
    let squares: f64 = (0..heights.len()).map(|i| place(i).x * place(i).x).sum();
    let moments: DVec2 = (0..heights.len()).map(|i| place(i) * heights[i]).sum();
    let tilt = moments / squares;
    for (i, height) in heights.iter_mut().enumerate() {
        *height -= tilt.dot(place(i));
    }
}

/// The first rows and columns blended with those after the last, so that the piece goes on at its opposite side.
/// What is blended keeps its deviation: it is scaled by as much as blending takes away.
fn seamless(heights: &[f64], side: usize) -> Vec<f32> {
    let mean = heights.iter().sum::<f64>() / heights.len() as f64;
    let across: Vec<f64> = blended(|i, j| heights[j * side + i] - mean, side);
    let both = blended(|j, i| across[j * SIDE + i], SIDE);
    // `both` is turned over: its rows are columns.
    (0..SIDE * SIDE)
        .map(|i| both[(i % SIDE) * SIDE + i / SIDE] as f32)
        .collect()
}

/// Blends the first [`SEAM`] of each of so many lines of heights with those after the last.
fn blended(height: impl Fn(usize, usize) -> f64, lines: usize) -> Vec<f64> {
    let mut blended = Vec::with_capacity(lines * SIDE);
    for line in 0..lines {
        for i in 0..SIDE {
            let near = height(i, line);
            if i >= SEAM {
                blended.push(near);
                continue;
            }
            let share = (i as f64 + 0.5) / SEAM as f64;
            let share = share * share * (3.0 - 2.0 * share);
            let far = height(i + SIDE, line);
            let kept = libm::hypot(share, 1.0 - share);
            blended.push((share * near + (1.0 - share) * far) / kept);
        }
    }
    blended
}

#[cfg(test)]
mod tests {
    use super::{super::exemplar::Level, *};

    /// Height in m of an SRTM tile of three seconds with ridges 4 km apart that run so many degrees east of north, at
    /// 60° north, where a degree of longitude is half of one of latitude, on ground that tilts.
    fn ridged_tile(strike: f64) -> Vec<u8> {
        let spacing =
            [DEGREE_M * libm::cos(60.5_f64.to_radians()), DEGREE_M].map(|degree| degree / 1200.0);
        let (sin, cos) = libm::sincos(strike.to_radians());
        let height = |i: usize| {
            let east = (i % 1201) as f64 * spacing[0];
            let north = -((i / 1201) as f64) * spacing[1];
            let across = east * cos - north * sin;
            2000.0 + 0.02 * east + 300.0 * libm::sin(across * core::f64::consts::TAU / 4000.0)
        };
        (0..1201 * 1201)
            .flat_map(|i| (height(i).round() as i16).to_be_bytes())
            .collect()
    }

    #[test]
    fn measured_ground_becomes_an_exemplar_along_its_folds() {
        // A degree is 55 km wide there, the square 46, or 61 where it is turned by 25°: only upright ones fit.
        for strike in [0.0_f64, 180.0] {
            let survey = Survey::from_hgt(&ridged_tile(strike), 60.0).unwrap();
            let along = survey.exemplar([0.5, 0.5], strike).unwrap();
            let across = survey.exemplar([0.5, 0.5], strike + 90.0).unwrap();
            // Steep across its rows, level along them: as where it is laid down.
            let roughness = |exemplar: &Exemplar| {
                let mut sum = [0.0_f64; 2];
                for i in 0..4096 {
                    let place = [(i % 64) as f32 * 4.0, (i / 64) as f32 * 4.0];
                    let (_, slope) = exemplar.at(place, Level::of(f64::from(TEXEL_M)));
                    sum[0] += f64::from(slope[0] * slope[0]);
                    sum[1] += f64::from(slope[1] * slope[1]);
                }
                sum
            };
            let [level, steep] = roughness(&along);
            assert!(steep > 30.0 * level, "{strike} {steep} {level}");
            let [steep, level] = roughness(&across);
            assert!(steep > 30.0 * level, "{strike} {steep} {level}");
        }
        let survey = Survey::from_hgt(&ridged_tile(25.0), 0.0).unwrap();
        survey.exemplar([0.5, 0.5], 25.0).unwrap();
    }

    #[test]
    fn surveys_are_refused_that_are_none() {
        let text = |error: ExemplarError| error.to_string();
        let tile = ridged_tile(0.0);
        let cut = Survey::from_hgt(&tile[1..], 60.0).unwrap_err();
        assert!(text(cut).contains("2884801 bytes are no SRTM tile"));
        let pole = Survey::from_hgt(&tile, 90.0).unwrap_err();
        assert!(text(pole).contains("from -90° to 89°"));
        let survey = Survey::from_hgt(&tile, 60.0).unwrap();
        for (place, strike) in [
            ([0.2, 0.5], 0.0),
            ([0.5, 0.5], 25.0),
            ([f64::NAN, 0.5], 0.0),
        ] {
            let outside = survey.exemplar(place, strike).unwrap_err();
            assert!(text(outside).contains("does not fit into 55 × 111 km"));
        }
        // A hole in the middle is named; one outside of the square is none of its business.
        let mut holed = tile;
        let middle = 2 * (600 * 1201 + 600);
        holed[..2].copy_from_slice(&i16::MIN.to_be_bytes());
        let survey = Survey::from_hgt(&holed, 60.0).unwrap();
        survey.exemplar([0.5, 0.5], 0.0).unwrap();
        holed[middle..middle + 2].copy_from_slice(&i16::MIN.to_be_bytes());
        let survey = Survey::from_hgt(&holed, 60.0).unwrap();
        let hole = survey.exemplar([0.5, 0.5], 0.0).unwrap_err();
        assert_eq!(hole, ExemplarError::Void(middle / 2));
        for (heights, columns, spacing) in
            [(9, 2, 30.0), (2, 1, 30.0), (4, 2, 0.0), (4, 2, f64::NAN)]
        {
            Survey::new(vec![1.0; heights], columns, [spacing; 2]).unwrap_err();
        }
    }
}
