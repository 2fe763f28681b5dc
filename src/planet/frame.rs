//! The two frames of reference: north is `+Z` in the simulation and `+Y` in a scene.

use bevy::math::{DVec3, Vec3};

/// A direction (or tangent vector) of the simulation in the space of a planet's `Transform`. Longitude 0
/// on the equator is `+X` in both; 90° east is `-Z` in the scene.
#[must_use]
pub fn to_scene(direction: DVec3) -> Vec3 {
    DVec3::new(direction.x, direction.z, -direction.y).as_vec3()
}

/// A direction in the space of a planet's `Transform` as one of the simulation.
#[must_use]
pub fn from_scene(direction: Vec3) -> DVec3 {
    DVec3::new(
        f64::from(direction.x),
        f64::from(-direction.z),
        f64::from(direction.y),
    )
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn north_is_up_and_nothing_is_mirrored() {
        assert_eq!(to_scene(DVec3::Z), Vec3::Y);
        let (x, y, z) = (to_scene(DVec3::X), to_scene(DVec3::Y), to_scene(DVec3::Z));
        assert_eq!(x.cross(y), z);
        let direction = DVec3::new(0.25, -0.5, 0.75);
        assert_eq!(from_scene(to_scene(direction)), direction);
    }
}
