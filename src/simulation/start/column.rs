//! Columns of crust by the height at which they stand.

use super::hypsometry::interpolate;
use crate::simulation::sub_plate::Crust;

/// Elevation in m and thickness in m of a column (Tectonics.js).
const THICKNESS: [(f64, f64); 6] = [
    (-11_000.0, 3_000.0),
    (-6_000.0, 6_300.0),
    (-3_680.0, 7_900.0),
    (-200.0, 17_000.0),
    (840.0, 36_900.0),
    (8_848.0, 70_000.0),
];
/// Elevation in m and density in kg/m³ of a column (Tectonics.js).
const DENSITY: [(f64, f64); 6] = [
    (-11_000.0, 3_000.0),
    (-6_000.0, 3_000.0),
    (-3_680.0, 2_890.0),
    (-200.0, 2_700.0),
    (840.0, 2_700.0),
    (8_848.0, 2_700.0),
];
/// Density of fresh basaltic crust, and of granitic crust, in kg/m³.
const BASALTIC: f64 = 2_890.0;
const GRANITIC: f64 = 2_700.0;

/// A column of crust.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Column {
    /// Thickness in km, 3 to 70.
    pub thickness_km: f64,
    /// Density in kg/m³, 2,700 to 3,000.
    pub density: f64,
}

impl Column {
    /// The column that stands at an elevation in m above the sea: straight lines between the control
    /// points of Tectonics.js, constant beyond −11,000 and 8,848 m.
    #[must_use]
    pub fn at(elevation_m: f64) -> Self {
        Self {
            thickness_km: 1e-3 * interpolate(&THICKNESS, elevation_m),
            density: interpolate(&DENSITY, elevation_m),
        }
    }

    /// Kind of crust: continental where the column is more granite than basalt, lighter than
    /// 2,795 kg/m³ and so thicker than 12.45 km.
    ///
    /// That is so above −1,940 m, at the foot of the margin: continental slopes are thinned continental
    /// crust and on Earth end at 2,000 m or somewhat below, so that Earth's curve gets its 40 % of
    /// continental crust. Normal sea floor stands at 2,600 m and below.
    #[must_use]
    pub fn crust(&self) -> Crust {
        if self.density < 0.5 * (BASALTIC + GRANITIC) {
            Crust::Continental
        } else {
            Crust::Oceanic
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn columns_follow_the_control_points() {
        for (elevation, thickness, density) in [
            (-11_000.0, 3.0, 3_000.0),
            (-6_000.0, 6.3, 3_000.0),
            (-3_680.0, 7.9, 2_890.0),
            (-200.0, 17.0, 2_700.0),
            (840.0, 36.9, 2_700.0),
            (8_848.0, 70.0, 2_700.0),
            // Half-way between two of them.
            (-8_500.0, 4.65, 3_000.0),
            (-4_840.0, 7.1, 2_945.0),
            (-1_940.0, 12.45, 2_795.0),
            (320.0, 26.95, 2_700.0),
            (4_844.0, 53.45, 2_700.0),
            // Beyond the ends.
            (-20_000.0, 3.0, 3_000.0),
            (20_000.0, 70.0, 2_700.0),
        ] {
            let column = Column::at(elevation);
            assert!(
                (column.thickness_km - thickness).abs() < 1e-9,
                "{elevation}"
            );
            assert!((column.density - density).abs() < 1e-9, "{elevation}");
        }
    }

    #[test]
    fn thick_and_light_columns_are_continental() {
        assert_eq!(Column::at(-1_941.0).crust(), Crust::Oceanic);
        assert_eq!(Column::at(-1_939.0).crust(), Crust::Continental);
        assert_eq!(Column::at(-11_000.0).crust(), Crust::Oceanic);
        assert_eq!(Column::at(8_848.0).crust(), Crust::Continental);
    }
}
