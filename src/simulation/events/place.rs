//! Places as people write them.

use super::super::error::TectonicError;
use bevy::reflect::Reflect;
use core::fmt;
use glam::DVec3;
use serde::{Deserialize, Serialize};

/// A place by latitude and longitude. In a recipe: `[latitude, longitude]`.
#[derive(Debug, Clone, Copy, Default, PartialEq, Serialize, Deserialize, Reflect)]
#[serde(from = "[f64; 2]", into = "[f64; 2]")]
pub struct LatLon {
    /// Latitude in degrees, −90 (south) to 90 (north).
    pub lat: f64,
    /// Longitude in degrees, −360 to 360, east positive.
    pub lon: f64,
}

impl LatLon {
    /// A place by latitude and longitude in degrees.
    #[must_use]
    pub const fn new(lat: f64, lon: f64) -> Self {
        Self { lat, lon }
    }

    /// The place in a direction, which may have any length but zero.
    #[must_use]
    pub fn of(direction: DVec3) -> Self {
        let across = libm::hypot(direction.x, direction.y);
        Self {
            lat: libm::atan2(direction.z, across).to_degrees(),
            lon: libm::atan2(direction.y, direction.x).to_degrees(),
        }
    }

    /// The place as a unit vector: north is +Z, longitude 0 on the equator +X, 90° east +Y.
    #[must_use]
    pub fn direction(self) -> DVec3 {
        let (sin_lat, cos_lat) = libm::sincos(self.lat.to_radians());
        let (sin_lon, cos_lon) = libm::sincos(self.lon.to_radians());
        DVec3::new(cos_lat * cos_lon, cos_lat * sin_lon, sin_lat)
    }

    /// Says whether it is a place.
    pub(super) fn validate(self, path: &str) -> Result<(), TectonicError> {
        for (name, value, most) in [("latitude", self.lat, 90.0), ("longitude", self.lon, 360.0)] {
            let fits = value.abs() <= most;
            if !fits {
                return Err(TectonicError::Recipe {
                    field: format!("{name} of {path}"),
                    value: value.to_string(),
                    allowed: format!("between -{most} and {most} degrees"),
                });
            }
        }
        Ok(())
    }
}

impl From<[f64; 2]> for LatLon {
    fn from([lat, lon]: [f64; 2]) -> Self {
        Self { lat, lon }
    }
}

impl From<LatLon> for [f64; 2] {
    fn from(place: LatLon) -> Self {
        [place.lat, place.lon]
    }
}

impl fmt::Display for LatLon {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "[{}, {}]", self.lat, self.lon)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn degrees_and_directions_agree() {
        assert!((LatLon::new(0.0, 90.0).direction() - DVec3::Y).length() < 1e-15);
        assert!((LatLon::new(-90.0, 17.0).direction() + DVec3::Z).length() < 1e-15);
        let place = LatLon::of(LatLon::new(-33.0, 151.0).direction());
        assert!((place.lat + 33.0).abs() < 1e-12 && (place.lon - 151.0).abs() < 1e-12);
    }
}
