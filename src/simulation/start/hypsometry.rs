//! Hypsometric curves: how much of a surface lies how high.

use crate::simulation::{error::TectonicError, recipe::within};
use bevy::prelude::*;
use core::ops::RangeInclusive;
use serde::{Deserialize, Serialize};

/// How much of a planet's surface lies how high at the start, in m above the sea.
///
/// The default is Earth. In a recipe:
///
/// ```json
/// {"start": {"hypsometric": {"normals": {"ocean_share": 0.5}}}}
/// {"start": {"hypsometric": {"curve": [[0, -6000], [0.6, -2500], [0.7, 0], [0.95, 1200], [1, 5000]]}}}
/// ```
///
/// The laws of crust decide what of it can be shown: sea floor stands between −5,800 and −1,900 m,
/// continental crust up to 5,300 m.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, Reflect)]
#[serde(rename_all = "kebab-case")]
pub enum Hypsometry {
    /// Two normal distributions, one for deep sea floor and one for continents.
    Normals(Normals),
    /// Points `[share, elevation]` with straight lines between them: the share of the surface that
    /// lies lower, rising from 0 to 1, and the elevation in m, −12,000 to 12,000, never falling.
    Curve(Vec<(f64, f64)>),
}

impl Default for Hypsometry {
    fn default() -> Self {
        Self::Normals(Normals::default())
    }
}

/// Two normal distributions, and where the sea stands between them. The default is Earth
/// (Tectonics.js).
///
/// The continents' distribution reaches below the sea: its lower end are shelves and slopes. How the
/// two are mixed follows from the share that is wet.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize, Reflect)]
#[serde(default, deny_unknown_fields)]
pub struct Normals {
    /// Sea floor; its mean −11,000 to −100 m.
    pub ocean: Normal,
    /// Continents; their mean 0 to 9,000 m.
    pub land: Normal,
    /// Share of the surface that is wet, 0.1 to 1. Earth's is 0.71.
    pub ocean_share: f64,
}

impl Default for Normals {
    fn default() -> Self {
        Self {
            ocean: Normal {
                mean_m: -4019.0,
                deviation_m: 1113.0,
            },
            land: Normal {
                mean_m: 797.0,
                deviation_m: 1169.0,
            },
            ocean_share: 0.71,
        }
    }
}

/// A normal distribution of elevations.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize, Reflect)]
#[serde(deny_unknown_fields)]
pub struct Normal {
    /// Mean in m above the sea.
    pub mean_m: f64,
    /// Standard deviation in m, 1 to 5,000.
    pub deviation_m: f64,
}

impl Normal {
    /// Share that lies below an elevation.
    fn below(&self, elevation_m: f64) -> f64 {
        let z = (elevation_m - self.mean_m) / self.deviation_m;
        0.5 * libm::erfc(-z * core::f64::consts::FRAC_1_SQRT_2)
    }
}

impl Normals {
    /// Allowed means of the sea floor in m.
    pub const OCEAN_MEANS_M: RangeInclusive<f64> = -11_000.0..=-100.0;
    /// Allowed means of the continents in m.
    pub const LAND_MEANS_M: RangeInclusive<f64> = 0.0..=9_000.0;
    /// Allowed standard deviations in m.
    pub const DEVIATIONS_M: RangeInclusive<f64> = 1.0..=5_000.0;
    /// Allowed shares of the ocean.
    pub const OCEAN_SHARES: RangeInclusive<f64> = 0.1..=1.0;

    /// Share of the surface that belongs to the sea floor's distribution: the one with which the
    /// wanted share lies below the sea. 0 or 1 where none does it.
    #[must_use]
    pub fn ocean_weight(&self) -> f64 {
        let (ocean, land) = (self.ocean.below(0.0), self.land.below(0.0));
        ((self.ocean_share - land) / (ocean - land)).clamp(0.0, 1.0)
    }

    fn below(&self, weight: f64, elevation_m: f64) -> f64 {
        weight * self.ocean.below(elevation_m) + (1.0 - weight) * self.land.below(elevation_m)
    }

    /// The elevation below which a share of the surface lies.
    fn elevation(&self, share: f64) -> f64 {
        let weight = self.ocean_weight();
        // Where no mixture has the wanted share of ocean, each side of the coast keeps its shape.
        let wet = self.below(weight, 0.0);
        let sea = self.ocean_share;
        let target = if share <= sea {
            share / sea * wet
        } else {
            wet + (share - sea) / (1.0 - sea) * (1.0 - wet)
        };
        let reach = 9.0 * self.ocean.deviation_m.max(self.land.deviation_m);
        let (mut low, mut high) = if share <= sea {
            (self.ocean.mean_m - reach, 0.0)
        } else {
            (0.0, self.land.mean_m + reach)
        };
        // To less than a micrometre.
        for _ in 0..40 {
            let middle = 0.5 * (low + high);
            if self.below(weight, middle) < target {
                low = middle;
            } else {
                high = middle;
            }
        }
        if share <= sea { low } else { high }
    }

    fn validate(&self) -> Result<(), TectonicError> {
        for (name, normal, means) in [
            ("ocean", self.ocean, Self::OCEAN_MEANS_M),
            ("land", self.land, Self::LAND_MEANS_M),
        ] {
            let field = |part: &str| format!("start.hypsometric.normals.{name}.{part}");
            within(&field("mean_m"), normal.mean_m, means, " m")?;
            let deviation = normal.deviation_m;
            within(&field("deviation_m"), deviation, Self::DEVIATIONS_M, " m")?;
        }
        let field = "start.hypsometric.normals.ocean_share";
        within(field, self.ocean_share, Self::OCEAN_SHARES, "")
    }
}

impl Hypsometry {
    /// Allowed elevations of a curve's points in m.
    pub const ELEVATIONS_M: RangeInclusive<f64> = -12_000.0..=12_000.0;
    /// Allowed numbers of a curve's points.
    pub const POINTS: RangeInclusive<usize> = 2..=1_000;

    /// The elevation in m above the sea below which a share of the surface lies, 0 to 1.
    #[must_use]
    pub fn elevation(&self, share: f64) -> f64 {
        match self {
            Self::Normals(normals) => normals.elevation(share.clamp(0.0, 1.0)),
            Self::Curve(points) => interpolate(points, share),
        }
    }

    /// Share of the surface that does not rise above the sea.
    #[must_use]
    pub fn ocean_share(&self) -> f64 {
        match self {
            Self::Normals(normals) => normals.ocean_share,
            Self::Curve(points) => {
                let dry = points.partition_point(|&(_, elevation)| elevation <= 0.0);
                match (dry.checked_sub(1).map(|wet| points[wet]), points.get(dry)) {
                    (Some(wet), Some(dry)) => wet.0 - (dry.0 - wet.0) * wet.1 / (dry.1 - wet.1),
                    (None, _) => 0.0,
                    (_, None) => 1.0,
                }
            }
        }
    }

    /// Says what is wrong with it, if something is.
    ///
    /// # Errors
    /// [`TectonicError::Recipe`] with the first offending value.
    pub fn validate(&self) -> Result<(), TectonicError> {
        match self {
            Self::Normals(normals) => normals.validate(),
            Self::Curve(points) => validate_curve(points),
        }
    }
}

fn validate_curve(points: &[(f64, f64)]) -> Result<(), TectonicError> {
    const FIELD: &str = "start.hypsometric.curve";
    within(
        &format!("{FIELD}.length"),
        points.len(),
        Hypsometry::POINTS,
        " points",
    )?;
    let refuse = |i: usize, part: &str, value: f64, allowed: String| TectonicError::Recipe {
        field: format!("{FIELD}[{i}].{part}"),
        value: value.to_string(),
        allowed,
    };
    let last = points.len() - 1;
    for (i, &(share, elevation)) in points.iter().enumerate() {
        let allowed = match i {
            0 => (share != 0.0).then(|| "0: a curve begins at share 0".to_owned()),
            _ if i == last && share != 1.0 => Some("1: a curve ends at share 1".to_owned()),
            _ if share > points[i - 1].0 && share <= 1.0 => None,
            _ => Some(format!("above {} and at most 1", points[i - 1].0)),
        };
        if let Some(allowed) = allowed {
            return Err(refuse(i, "share", share, allowed));
        }
        within(
            &format!("{FIELD}[{i}].elevation"),
            elevation,
            Hypsometry::ELEVATIONS_M,
            " m",
        )?;
        if i > 0 && elevation < points[i - 1].1 {
            let allowed = format!("{} m or more: a curve never falls", points[i - 1].1);
            return Err(refuse(i, "elevation", elevation, allowed));
        }
    }
    Ok(())
}

/// The value at `x` of the straight lines between points of rising `x`; outside, that of the nearest.
pub(super) fn interpolate(points: &[(f64, f64)], x: f64) -> f64 {
    let above = points.partition_point(|point| point.0 < x);
    match (
        above.checked_sub(1).map(|below| points[below]),
        points.get(above),
    ) {
        (Some(a), Some(b)) => a.1 + (b.1 - a.1) * (x - a.0) / (b.0 - a.0),
        (None, Some(end)) => end.1,
        (Some(end), None) => end.1,
        (None, None) => 0.0,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn earths_normals_give_the_wanted_share_of_ocean() {
        let earth = Normals::default();
        // Φ(4019/1113) = Φ(3.61096) = 0.999847, Φ(−797/1169) = Φ(−0.681779) = 0.247688:
        // w = (0.71 − 0.247688)/(0.999847 − 0.247688) = 0.614647.
        assert!((earth.ocean_weight() - 0.614_647).abs() < 2e-6);
        let curve = Hypsometry::Normals(earth);
        assert_eq!(curve.ocean_share(), 0.71);
        assert!(curve.elevation(0.71).abs() < 1e-3);
        assert!(curve.elevation(0.7099) < 0.0 && curve.elevation(0.7101) > 0.0);
        // At the land's mean: w·1 + (1 − w)/2 = 0.807315 of the surface lies lower, up to w·8e-6.
        assert!((curve.elevation(0.807_32) - 797.0).abs() < 0.5);
        // At the sea floor's: w/2 and (1 − w)·Φ(−4816/1169 = −4.12) = 0.3854·1.9e-5.
        assert!((curve.elevation(0.307_33) + 4019.0).abs() < 0.5);
        assert!(curve.elevation(0.0).is_finite() && curve.elevation(1.0).is_finite());
    }

    #[test]
    fn shares_beyond_any_mixture_keep_the_shape_of_each_side() {
        let dry = Normals {
            ocean_share: 0.1,
            ..Normals::default()
        };
        assert_eq!(dry.ocean_weight(), 0.0);
        let curve = Hypsometry::Normals(dry);
        assert!(curve.elevation(0.0999) < 0.0 && curve.elevation(0.1001) > 0.0);
        // Half of the land that rises above the sea lies below the median of that part:
        // Φ(x) = (1 + 0.247688)/2 = 0.623844 → x = 0.315596, 797 + 1169·0.315596 = 1165.93 m.
        assert!((curve.elevation(0.55) - 1165.93).abs() < 0.1);
        let drowned = Hypsometry::Normals(Normals {
            ocean_share: 1.0,
            ..dry
        });
        assert!(drowned.elevation(1.0) <= 0.0);
    }

    #[test]
    fn curves_are_straight_lines() {
        let curve = Hypsometry::Curve(vec![(0.0, -6000.0), (0.5, -1000.0), (1.0, 3000.0)]);
        assert_eq!(curve.validate(), Ok(()));
        assert_eq!(curve.elevation(0.25), -3500.0);
        assert_eq!(curve.elevation(0.75), 1000.0);
        assert_eq!(curve.elevation(-1.0), -6000.0);
        assert_eq!(curve.elevation(2.0), 3000.0);
        assert_eq!(curve.ocean_share(), 0.625);
        let flooded = Hypsometry::Curve(vec![(0.0, -5.0), (1.0, 0.0)]);
        assert_eq!(flooded.ocean_share(), 1.0);
        let desert = Hypsometry::Curve(vec![(0.0, 5.0), (1.0, 9.0)]);
        assert_eq!(desert.ocean_share(), 0.0);
    }

    #[test]
    fn what_is_wrong_is_named() {
        let curve = |points: &[(f64, f64)]| Hypsometry::Curve(points.to_vec());
        let normals = |change: fn(&mut Normals)| {
            let mut normals = Normals::default();
            change(&mut normals);
            Hypsometry::Normals(normals)
        };
        for (wrong, part, allowed) in [
            (curve(&[]), "curve.length", "between 2 and 1000 points"),
            (curve(&[(0.1, 0.0), (1.0, 1.0)]), "curve[0].share", "0:"),
            (curve(&[(0.0, 0.0), (0.9, 1.0)]), "curve[1].share", "1:"),
            (
                curve(&[(0.0, 0.0), (0.5, 1.0), (0.5, 2.0), (1.0, 3.0)]),
                "curve[2].share",
                "above 0.5 and at most 1",
            ),
            (
                curve(&[(0.0, 0.0), (f64::NAN, 1.0), (1.0, 3.0)]),
                "curve[1].share",
                "above 0",
            ),
            (
                curve(&[(0.0, 10.0), (1.0, 9.0)]),
                "curve[1].elevation",
                "10 m or more",
            ),
            (
                curve(&[(0.0, -1e9), (1.0, 9.0)]),
                "curve[0].elevation",
                "between -12000 and 12000 m",
            ),
            (
                normals(|n| n.ocean_share = 1.5),
                "normals.ocean_share",
                "between 0.1 and 1",
            ),
            (
                normals(|n| n.ocean.mean_m = 5.0),
                "normals.ocean.mean_m",
                "between -11000 and -100 m",
            ),
            (
                normals(|n| n.land.deviation_m = f64::NAN),
                "normals.land.deviation_m",
                "between 1 and 5000 m",
            ),
        ] {
            let text = wrong.validate().unwrap_err().to_string();
            assert!(text.contains(part) && text.contains(allowed), "{text}");
        }
    }
}
