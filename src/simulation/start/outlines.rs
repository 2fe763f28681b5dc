//! Which plate's outline holds a place: all outlines at once, by latitude.

use super::imported::ImportedPlate;

/// Bands of latitude. A side is looked at from the bands that it passes through.
const BANDS: usize = 128;

/// A side of an outline, from one corner to the next.
struct Side {
    ends: [[f64; 2]; 2],
    plate: u32,
    polygon: u32,
}

/// The outlines of plates.
pub(super) struct Outlines {
    sides: Vec<Side>,
    /// Numbers of sides, ascending: plate by plate, polygon by polygon.
    bands: Vec<Vec<u32>>,
}

impl Outlines {
    pub(super) fn new(plates: &[ImportedPlate]) -> Self {
        let mut outlines = Self {
            sides: Vec::new(),
            bands: vec![Vec::new(); BANDS],
        };
        let mut polygon = 0;
        for (plate, imported) in (0..).zip(plates) {
            for rings in &imported.polygons {
                for ring in &rings.0 {
                    let before = ring.iter().cycle().skip(ring.len().saturating_sub(1));
                    for (&a, &b) in before.zip(ring) {
                        outlines.add(Side {
                            ends: [a, b],
                            plate,
                            polygon,
                        });
                    }
                }
                polygon += 1;
            }
        }
        outlines
    }

    fn add(&mut self, side: Side) {
        let [a, b] = side.ends.map(|corner| band(corner[1]));
        let number = self.sides.len() as u32;
        for sides in &mut self.bands[a.min(b)..=a.max(b)] {
            sides.push(number);
        }
        self.sides.push(side);
    }

    /// Number of the first plate one of whose polygons
    /// [contains](super::PlatePolygon::contains) a place.
    pub(super) fn plate_at(&self, lon: f64, lat: f64) -> Option<usize> {
        let sides = self.bands[band(lat)].iter();
        let mut inside = None;
        for side in sides.map(|&number| &self.sides[number as usize]) {
            if inside.is_some_and(|(polygon, _)| polygon != side.polygon) {
                break;
            }
            let [a, b] = side.ends;
            let crosses = (a[1] > lat) != (b[1] > lat);
            if crosses && lon < a[0] + (b[0] - a[0]) * (lat - a[1]) / (b[1] - a[1]) {
                inside = match inside {
                    None => Some((side.polygon, side.plate as usize)),
                    Some(_) => None,
                };
            }
        }
        inside.map(|(_, plate)| plate)
    }
}

fn band(lat: f64) -> usize {
    let share = (lat + 90.0) / 180.0;
    ((share * BANDS as f64) as usize).min(BANDS - 1)
}

#[cfg(test)]
mod tests {
    use super::super::PlatePolygon;
    use super::*;
    use crate::simulation::streams::{Purpose, stream, unit};

    #[test]
    fn the_first_plate_that_holds_a_place_is_found() {
        let mut rng = stream(1, Purpose::Plates, 0, 0);
        let mut draw = || 2.0 * unit(&mut rng) - 1.0;
        let plates: Vec<ImportedPlate> = (0..12)
            .map(|_| ImportedPlate {
                name: "a plate".into(),
                polygons: (0..3)
                    .map(|_| {
                        let mut ring = || (0..9).map(|_| [180.0 * draw(), 90.0 * draw()]).collect();
                        PlatePolygon(vec![ring(), ring()])
                    })
                    .collect(),
                rotation: None,
            })
            .collect();
        let outlines = Outlines::new(&plates);
        let mut found = [0; 13];
        for _ in 0..4000 {
            let (lon, lat) = (180.0 * draw(), 90.0 * draw());
            let holds = |plate: &ImportedPlate| plate.polygons.iter().any(|p| p.contains(lon, lat));
            let expected = plates.iter().position(holds);
            assert_eq!(outlines.plate_at(lon, lat), expected);
            found[expected.map_or(12, |plate| plate)] += 1;
        }
        assert!(found[3] > 10 && found[12] > 0, "{found:?}");
    }
}
