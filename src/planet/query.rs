//! Planets as things in a scene: what a ray meets, where something stands.

use super::{Planet, PlanetSurface, PlanetView, from_scene, to_scene};
use crate::surface::{Place, Raster, Relief};
use bevy::ecs::system::SystemParam;
use bevy::math::DVec3;
use bevy::prelude::*;

/// All planets that have a surface, for systems that pick, shoot, place and walk.
///
/// ```
/// use bevy::prelude::*;
/// use bevy_tectonics::prelude::*;
///
/// /// Puts a thing on the ground of its planet, which is its parent, at a place of the planet's.
/// #[derive(Component)]
/// struct Place(Dir3);
///
/// fn settle(planets: Planets, mut things: Query<(&Place, &ChildOf, &mut Transform)>) {
///     for (place, child_of, mut transform) in &mut things {
///         if let Some(ground) = planets.stand(child_of.parent(), place.0) {
///             *transform = ground;
///         }
///     }
/// }
/// ```
#[derive(SystemParam)]
pub struct Planets<'w, 's> {
    planets: Query<
        'w,
        's,
        (
            Entity,
            &'static Planet,
            &'static PlanetView,
            &'static GlobalTransform,
            &'static PlanetSurface,
        ),
    >,
}

/// Where a ray meets a planet.
#[derive(Debug, Clone, Copy)]
pub struct Pick {
    /// The planet.
    pub planet: Entity,
    /// The point, in the game's world.
    pub point: Vec3,
    /// Upward normal of the ground or the sea as it is drawn, in the game's world.
    pub normal: Vec3,
    /// Distance from the origin of the ray, in units of the game's world.
    pub distance: f32,
    /// The planet there.
    pub place: Place,
}

impl Planets<'_, '_> {
    /// The first planet that a ray of the game's world meets, as it is drawn: exaggerated, with its
    /// sea if that is shown.
    #[must_use]
    pub fn pick(&self, ray: Ray3d) -> Option<Pick> {
        self.planets
            .iter()
            .filter_map(|(entity, planet, view, transform, surface)| {
                let to_world = transform.affine();
                let to_planet = to_world.inverse();
                let scale = 1.0 / f64::from(planet.radius);
                let origin = from_scene(to_planet.transform_point3(ray.origin)) * scale;
                let direction = from_scene(to_planet.transform_vector3(*ray.direction));
                let hit = surface.ray(origin, direction, relief(view))?;
                let point = to_world.transform_point3(to_scene(hit.point) * planet.radius);
                // Normals turn by the inverse transpose, which matters where a scale is uneven.
                let normal = to_planet.matrix3.transpose() * to_scene(hit.normal);
                Some(Pick {
                    planet: entity,
                    point,
                    normal: normal.normalize_or_zero(),
                    distance: point.distance(ray.origin),
                    place: hit.place,
                })
            })
            .min_by(|a, b| a.distance.total_cmp(&b.distance))
    }

    /// Where something stands on a planet in a direction of the planet's own space: on the ground as it
    /// is drawn, terrain finer than sub-plates included, or on the sea; upright. The pose is that of a
    /// child of the planet.
    ///
    /// None as long as the planet has no surface.
    #[must_use]
    pub fn stand(&self, planet: Entity, direction: Dir3) -> Option<Transform> {
        let (_, planet, view, _, surface) = self.planets.get(planet).ok()?;
        let elevation = Raster::new(surface)
            .ok()?
            .sample(from_scene(*direction))
            .elevation;
        let height = height(view, elevation) / (1000.0 * surface.radius_km as f32);
        let away = direction.any_orthonormal_vector();
        Some(
            Transform::from_translation(planet.radius * (1.0 + height) * *direction)
                .looking_to(away, *direction),
        )
    }

    /// The planet in a direction of its own space.
    #[must_use]
    pub fn place(&self, planet: Entity, direction: Dir3) -> Option<Place> {
        let (.., surface) = self.planets.get(planet).ok()?;
        Some(surface.at(from_scene(*direction)))
    }

    /// The direction in which a point of the game's world lies, in the planet's own space.
    #[must_use]
    pub fn direction(&self, planet: Entity, point: Vec3) -> Option<Dir3> {
        let (_, _, _, transform, _) = self.planets.get(planet).ok()?;
        Dir3::new(transform.affine().inverse().transform_point3(point)).ok()
    }

    /// Where the ground of a direction drifts within a time, in My: the direction of the same ground
    /// later (or earlier, with a negative time), in the planet's own space.
    #[must_use]
    pub fn drift(&self, planet: Entity, direction: Dir3, time_my: f64) -> Option<Dir3> {
        let (.., surface) = self.planets.get(planet).ok()?;
        let here = from_scene(*direction);
        let velocity: DVec3 = surface.at(here).velocity.as_dvec3();
        let there = here + velocity * (time_my / surface.radius_km);
        Dir3::new(to_scene(there)).ok()
    }
}

/// How a view draws the ground.
fn relief(view: &PlanetView) -> Relief {
    Relief {
        exaggeration: f64::from(view.exaggeration),
        sea: view.sea,
    }
}

/// Height above the radius as it is drawn, in m.
fn height(view: &PlanetView, elevation: f32) -> f32 {
    let floor = if view.sea {
        view.sea_level_m
    } else {
        f32::NEG_INFINITY
    };
    view.exaggeration * elevation.max(floor)
}
