//! An imported world as plain data, and what a recipe says of the files it comes from.

use crate::simulation::{error::TectonicError, recipe::within};
use bevy::prelude::*;
use core::ops::RangeInclusive;
use glam::DVec3;
use serde::{Deserialize, Serialize};

/// Where an imported start comes from. Paths are those of the program's working directory; relative ones
/// in a recipe that `generate` reads are looked for beside that recipe first.
///
/// For Earth, bring a relief such as ETOPO as a grey equirectangular picture, and the plates of Bird's
/// PB2002 as `GeoJSON` with a table of Euler poles (no-net-rotation ones are best, since plates are
/// dragged over the mantle):
///
/// ```json
/// {"start": {"image": {
///     "heights": "etopo.png", "lowest_m": -10900, "highest_m": 8600,
///     "plate_polygons": "PB2002_plates.json", "plate_rotations": "poles.json"}}}
/// ```
///
/// with `{"PA": {"lat": -63.6, "lon": 114.7, "deg_per_my": 0.65}, …}` in `poles.json`.
///
/// What lies above the shelf edge becomes continental crust as thick as isostasy wants, everything else
/// sea floor as old as its depth. The recipe's shares of continents and land are not read, nor is its
/// number of plates where polygons say more. Rotations are the first motions; forces take over
/// within a few My.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, Reflect)]
#[serde(default, deny_unknown_fields)]
pub struct ImageStart {
    /// Path of a PNG, grey with 8 or 16 bits, twice as wide as high: the left edge is 180° W, the top
    /// edge the north pole.
    pub heights: String,
    /// Height of black in m, −100,000 to 100,000. The default is that of `elevation.png`, which `generate`
    /// writes: black is −32,768 m.
    pub lowest_m: f64,
    /// Height of white in m, above that of black; by default 32,767 m.
    pub highest_m: f64,
    /// Height at which the sea stands in m, on the same scale.
    pub sea_level_m: f64,
    /// Height above the sea in m, −3,000 to 0, above which crust is continental. Earth's shelves break at
    /// 100 to 200 m of depth.
    pub shelf_edge_m: f64,
    /// Path of a `GeoJSON` file with a polygon, or several, for each plate. A feature is named by its
    /// property `plate`, `Code`, `code`, `name`, `PlateName` or `id`, or by its own id; features of one
    /// name are one plate. Without it plates are laid out as in a flood fill.
    pub plate_polygons: Option<String>,
    /// Path of a JSON file with the Euler rotations of named plates. A feature's own property `rotation`
    /// says the same for one plate.
    pub plate_rotations: Option<String>,
}

impl Default for ImageStart {
    fn default() -> Self {
        Self {
            heights: String::new(),
            lowest_m: -32_768.0,
            highest_m: 32_767.0,
            sea_level_m: 0.0,
            shelf_edge_m: -200.0,
            plate_polygons: None,
            plate_rotations: None,
        }
    }
}

impl ImageStart {
    /// Allowed heights of black, white and the sea in m.
    pub const HEIGHTS_M: RangeInclusive<f64> = -100_000.0..=100_000.0;
    /// Allowed heights of the shelf edge in m above the sea.
    pub const SHELF_EDGES_M: RangeInclusive<f64> = -3_000.0..=0.0;

    /// Says what is wrong with its figures, if something is; files are not looked at.
    ///
    /// # Errors
    /// [`TectonicError::Recipe`] with the first offending value.
    pub fn validate(&self) -> Result<(), TectonicError> {
        for (field, value) in [
            ("start.image.lowest_m", self.lowest_m),
            ("start.image.highest_m", self.highest_m),
            ("start.image.sea_level_m", self.sea_level_m),
        ] {
            within(field, value, Self::HEIGHTS_M, " m")?;
        }
        if self.highest_m <= self.lowest_m {
            return Err(TectonicError::Recipe {
                field: "start.image.highest_m".into(),
                value: self.highest_m.to_string(),
                allowed: format!("above lowest_m, {} m", self.lowest_m),
            });
        }
        let edge = self.shelf_edge_m;
        within("start.image.shelf_edge_m", edge, Self::SHELF_EDGES_M, " m")?;
        match &self.plate_rotations {
            Some(rotations) if self.plate_polygons.is_none() => Err(TectonicError::Recipe {
                field: "start.image.plate_rotations".into(),
                value: rotations.clone(),
                allowed: "left out where there are no plate_polygons".into(),
            }),
            _ => Ok(()),
        }
    }
}

/// What [`Start::Image`](crate::simulation::Start::Image) starts from. The feature `import` reads it from files;
/// [`History::imported`](crate::simulation::History::imported) takes one that was made otherwise.
/// [`populate`](crate::simulation::populate) takes it out of the world it fills.
#[derive(Resource, Debug, Clone, PartialEq)]
pub struct ImportedWorld {
    /// Heights above the sea.
    pub heights: HeightMap,
    /// Plates; none to have them laid out as in a flood fill. A place in several belongs to the first,
    /// one in none to the nearest.
    pub plates: Vec<ImportedPlate>,
}

/// An equirectangular map of heights: pixel centres at longitude −180 + (x + ½)·360/W and latitude
/// 90 − (y + ½)·180/H degrees.
#[derive(Debug, Clone, PartialEq)]
pub struct HeightMap {
    width: usize,
    metres: Vec<f32>,
}

impl HeightMap {
    /// Allowed widths in pixels; only even ones.
    pub const WIDTHS: RangeInclusive<usize> = 8..=21_600;

    /// A map from rows of heights in m above the sea, the northern row first, each from west to east.
    ///
    /// # Errors
    /// [`TectonicError::Import`] if it is not twice as wide as high, too small or too large, or holds what
    /// is not finite.
    pub fn new(width: usize, metres: Vec<f32>) -> Result<Self, TectonicError> {
        let height = metres.len() / width.max(1);
        Self::check_size(width, height).map_err(|allowed| {
            TectonicError::import(
                "the height map",
                format!("{width} pixels wide with {} heights", metres.len()),
                allowed,
            )
        })?;
        if metres.len() != width * height || !metres.iter().all(|height| height.is_finite()) {
            return Err(TectonicError::import(
                "the height map",
                "not whole",
                "full rows of finite heights",
            ));
        }
        Ok(Self { width, metres })
    }

    /// What is allowed, if a size is not.
    pub(crate) fn check_size(width: usize, height: usize) -> Result<(), String> {
        let fits = Self::WIDTHS.contains(&width) && width.is_multiple_of(2);
        if fits && width == 2 * height {
            return Ok(());
        }
        Err(format!(
            "equirectangular: twice as wide as high, with an even width from {} to {} pixels",
            Self::WIDTHS.start(),
            Self::WIDTHS.end()
        ))
    }

    /// Pixels from west to east.
    #[must_use]
    pub fn width(&self) -> usize {
        self.width
    }

    /// Pixels from north to south.
    #[must_use]
    pub fn height(&self) -> usize {
        self.width / 2
    }

    /// The height of a pixel in m above the sea; columns go round, rows stop at the poles.
    #[must_use]
    pub fn pixel(&self, column: usize, row: usize) -> f64 {
        let row = row.min(self.height() - 1);
        f64::from(self.metres[row * self.width + column % self.width])
    }

    /// The height between the four nearest pixels, by longitude and latitude in degrees.
    #[must_use]
    pub fn between(&self, lon: f64, lat: f64) -> f64 {
        let width = self.width as f64;
        let x = (lon + 180.0) / 360.0 * width - 0.5 + width;
        let y = ((90.0 - lat) / 180.0 * (0.5 * width) - 0.5).max(0.0);
        let (column, row) = (x.floor(), y.floor());
        let (east, south) = (x - column, y - row);
        let (column, row) = (column as usize, row as usize);
        let level =
            |row| self.pixel(column, row) * (1.0 - east) + self.pixel(column + 1, row) * east;
        level(row) * (1.0 - south) + level(row + 1) * south
    }
}

/// A plate by its outline.
#[derive(Debug, Clone, PartialEq)]
pub struct ImportedPlate {
    /// Its name.
    pub name: String,
    /// Its parts.
    pub polygons: Vec<PlatePolygon>,
    /// Its first motion. Where some plates have one, those without stand still; where none has, all are
    /// drawn by chance.
    pub rotation: Option<EulerRotation>,
}

/// An outline and its holes: closed rings of longitude and latitude in degrees, sides straight on an
/// equirectangular map, as in `GeoJSON`. What crosses 180° is cut there; what holds a pole follows the map's
/// edge.
#[derive(Debug, Clone, PartialEq)]
pub struct PlatePolygon(pub Vec<Vec<[f64; 2]>>);

impl PlatePolygon {
    /// Whether a longitude and latitude in degrees lie inside (even–odd rule).
    #[must_use]
    pub fn contains(&self, lon: f64, lat: f64) -> bool {
        let mut inside = false;
        for ring in &self.0 {
            let before = ring.iter().cycle().skip(ring.len().saturating_sub(1));
            for (a, b) in before.zip(ring) {
                let crosses = (a[1] > lat) != (b[1] > lat);
                if crosses && lon < a[0] + (b[0] - a[0]) * (lat - a[1]) / (b[1] - a[1]) {
                    inside = !inside;
                }
            }
        }
        inside
    }

    /// What is wrong with it, and what is allowed.
    fn check(&self) -> Result<(), (String, &'static str)> {
        let ring = "closed rings of at least three corners";
        if self.0.is_empty() {
            return Err(("a polygon is empty".into(), ring));
        }
        for corners in &self.0 {
            if corners.len() < 3 {
                return Err((format!("a ring has {} corners", corners.len()), ring));
            }
            for [lon, lat] in corners {
                if !((-180.0..=180.0).contains(lon) && (-90.0..=90.0).contains(lat)) {
                    return Err((
                        format!("a corner lies at longitude {lon}, latitude {lat}"),
                        "within −180 to 180 and −90 to 90 degrees",
                    ));
                }
            }
        }
        Ok(())
    }
}

/// A rotation about a pole.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct EulerRotation {
    /// Latitude of the pole in degrees, −90 to 90.
    pub lat: f64,
    /// Longitude of the pole in degrees, −180 to 360.
    pub lon: f64,
    /// Angle, counter-clockwise seen from above the pole, in degrees per My, −100 to 100.
    pub deg_per_my: f64,
}

impl EulerRotation {
    /// Angular velocity in rad/My.
    #[must_use]
    pub fn vector(&self) -> DVec3 {
        let (sin_lat, cos_lat) = libm::sincos(self.lat.to_radians());
        let (sin_lon, cos_lon) = libm::sincos(self.lon.to_radians());
        DVec3::new(cos_lat * cos_lon, cos_lat * sin_lon, sin_lat) * self.deg_per_my.to_radians()
    }

    fn check(&self) -> Result<(), (String, &'static str)> {
        let Self {
            lat,
            lon,
            deg_per_my,
        } = *self;
        let fits = (-90.0..=90.0).contains(&lat)
            && (-180.0..=360.0).contains(&lon)
            && (-100.0..=100.0).contains(&deg_per_my);
        if fits {
            return Ok(());
        }
        Err((
            format!("its rotation is {deg_per_my}°/My about latitude {lat}, longitude {lon}"),
            "within ±100°/My, ±90 and −180 to 360 degrees",
        ))
    }
}

impl ImportedWorld {
    /// Allowed numbers of plates, where there are any.
    pub const PLATES: RangeInclusive<usize> = 2..=1_000;
    /// Most corners of all outlines together: some thirty times as many as Earth's take.
    pub const MOST_CORNERS: usize = 200_000;

    /// Says what is wrong with its plates, if something is.
    ///
    /// # Errors
    /// [`TectonicError::Import`] with the plate, what is wrong and what is allowed.
    pub fn validate(&self) -> Result<(), TectonicError> {
        let count = self.plates.len();
        if count > 0 && !Self::PLATES.contains(&count) {
            return Err(TectonicError::import(
                "the plates",
                format!("{count} of them"),
                "between 2 and 1000",
            ));
        }
        let polygons = self.plates.iter().flat_map(|plate| &plate.polygons);
        let corners: usize = polygons.flat_map(|polygon| &polygon.0).map(Vec::len).sum();
        if corners > Self::MOST_CORNERS {
            return Err(TectonicError::import(
                "the plates",
                format!("they have {corners} corners"),
                format!("at most {} in all", Self::MOST_CORNERS),
            ));
        }
        for plate in &self.plates {
            let refuse = |(found, allowed)| {
                TectonicError::import(format!("plate {}", plate.name), found, allowed)
            };
            if plate.polygons.is_empty() {
                return Err(refuse(("it has no polygons".into(), "at least one")));
            }
            for polygon in &plate.polygons {
                polygon.check().map_err(refuse)?;
            }
            if let Some(rotation) = &plate.rotation {
                rotation.check().map_err(refuse)?;
            }
        }
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn polygons_hold_what_lies_inside() {
        let outer = vec![
            [-10.0, -10.0],
            [10.0, -10.0],
            [10.0, 10.0],
            [-10.0, 10.0],
            [-10.0, -10.0],
        ];
        let hole = vec![[-2.0, -2.0], [2.0, -2.0], [2.0, 2.0], [-2.0, 2.0]];
        let polygon = PlatePolygon(vec![outer, hole]);
        assert!(polygon.contains(5.0, 5.0) && polygon.contains(-9.9, 0.0));
        assert!(!polygon.contains(0.0, 0.0), "the hole, closed or not");
        assert!(!polygon.contains(10.1, 0.0) && !polygon.contains(0.0, -11.0));
    }

    #[test]
    fn heights_lie_between_pixels() {
        let mut metres = vec![0.0; 32];
        metres[8] = 100.0;
        let map = HeightMap::new(8, metres).unwrap();
        // Row 1, column 0: centre at longitude −157.5, latitude 22.5.
        assert_eq!(map.between(-157.5, 22.5), 100.0);
        assert_eq!(map.between(-180.0, 22.5), 50.0, "half-way over the seam");
        assert_eq!(map.between(180.0, 22.5), 50.0);
        assert_eq!(map.between(-157.5, 33.75), 75.0);
        assert_eq!(map.between(-157.5, 90.0), 0.0);
        assert_eq!(map.between(20.0, -90.0), 0.0);
    }

    #[test]
    fn rotations_turn_about_their_pole() {
        let quarter = EulerRotation {
            lat: 0.0,
            lon: 90.0,
            deg_per_my: 90.0,
        };
        let vector = quarter.vector();
        assert!((vector - DVec3::Y * core::f64::consts::FRAC_PI_2).length() < 1e-12);
    }

    #[test]
    fn what_is_wrong_is_named() {
        for (width, count) in [(8, 31), (8, 40), (7, 24), (6, 18)] {
            assert!(HeightMap::new(width, vec![0.0; count]).is_err());
        }
        assert!(HeightMap::new(8, vec![f32::NAN; 32]).is_err());
        let plate = |corner: [f64; 2], lat| ImportedPlate {
            name: "AF".into(),
            polygons: vec![PlatePolygon(vec![vec![[0.0, 0.0], [1.0, 0.0], corner]])],
            rotation: Some(EulerRotation {
                lat,
                lon: 0.0,
                deg_per_my: 1.0,
            }),
        };
        let mut world = ImportedWorld {
            heights: HeightMap::new(8, vec![0.0; 32]).unwrap(),
            plates: vec![plate([0.0, 1.0], 0.0), plate([200.0, 1.0], 0.0)],
        };
        let text = world.validate().unwrap_err().to_string();
        assert!(
            text.contains("AF") && text.contains("longitude 200"),
            "{text}"
        );
        world.plates[1] = plate([0.0, 1.0], 91.0);
        assert!(
            world
                .validate()
                .unwrap_err()
                .to_string()
                .contains("latitude 91")
        );
        world.plates[1] = plate([0.0, 1.0], 90.0);
        assert_eq!(world.validate(), Ok(()));
        world.plates[1].polygons.clear();
        assert!(world.validate().is_err());
        world.plates.truncate(1);
        assert!(
            world
                .validate()
                .unwrap_err()
                .to_string()
                .contains("between 2 and 1000")
        );

        for (wrong, part) in [
            (
                ImageStart {
                    lowest_m: f64::NAN,
                    ..ImageStart::default()
                },
                "lowest_m",
            ),
            (
                ImageStart {
                    highest_m: -40_000.0,
                    ..ImageStart::default()
                },
                "above lowest_m",
            ),
            (
                ImageStart {
                    shelf_edge_m: 10.0,
                    ..ImageStart::default()
                },
                "between -3000 and 0 m",
            ),
            (
                ImageStart {
                    plate_rotations: Some("x".into()),
                    ..ImageStart::default()
                },
                "plate_polygons",
            ),
        ] {
            let text = wrong.validate().unwrap_err().to_string();
            assert!(
                text.contains("start.image.") && text.contains(part),
                "{text}"
            );
        }
    }
}
