//! Directions, latitudes and longitudes.

use super::raster::direction;
use glam::DVec3;

/// The unit vector of a latitude (−90 south to 90 north) and longitude (−180 to 180, or any other turn),
/// in degrees. North is +Z, longitude 0 on the equator +X, longitude 90° east +Y.
///
/// Of what is not finite, the north pole.
#[must_use]
pub fn direction_of(latitude_deg: f64, longitude_deg: f64) -> DVec3 {
    if !(latitude_deg.is_finite() && longitude_deg.is_finite()) {
        return DVec3::Z;
    }
    direction(longitude_deg.to_radians(), latitude_deg.to_radians())
}

/// Latitude (−90 to 90) and longitude (−180 to 180) of a direction of any length, in degrees. The poles
/// have longitude 0, as has the north pole that stands for what is zero or not finite.
#[must_use]
pub fn lat_lon(direction: DVec3) -> (f64, f64) {
    let direction = unit(direction);
    let across = libm::hypot(direction.x, direction.y);
    // Adding zero turns −0 into 0: a pole has no back.
    let longitude = libm::atan2(direction.y + 0.0, direction.x + 0.0);
    (
        libm::atan2(direction.z, across).to_degrees(),
        longitude.to_degrees(),
    )
}

/// East and north at a direction of any length: unit vectors tangent there. At the poles as on
/// longitude 0.
#[must_use]
pub fn east_north(direction: DVec3) -> (DVec3, DVec3) {
    let up = unit(direction);
    let east = DVec3::Z.cross(up).normalize_or(DVec3::Y);
    (east, up.cross(east))
}

/// The unit vector along a direction; none if it is zero or not finite.
pub(super) fn try_unit(direction: DVec3) -> Option<DVec3> {
    let square = direction.length_squared();
    if (square - 1.0).abs() < 1e-15 {
        return Some(direction);
    }
    if square > 1e-200 && square < 1e200 {
        return Some(direction / square.sqrt());
    }
    // Scaled first, no square over- or underflows.
    let scaled = direction / direction.abs().max_element();
    scaled.is_finite().then(|| scaled.normalize())
}

/// The unit vector along a direction; north if it is zero or not finite.
pub(super) fn unit(direction: DVec3) -> DVec3 {
    try_unit(direction).unwrap_or(DVec3::Z)
}
