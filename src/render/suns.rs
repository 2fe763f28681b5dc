//! Sunlight averaged over many days and years, for time lapses.

use bevy::{prelude::*, transform::TransformSystems};
use core::f32::consts::TAU;

/// Light of a sun as it is on average while a planet turns under it and goes around it: in a time lapse millions of
/// days pass between two frames. It is light from several suns (as Tectonics.js has them), which stand around the
/// entity's +Y axis; their air and their glint are averaged with them.
///
/// Spawn it on its own, or as a child of the planet; its `Transform` turns the axis. Each sun is a
/// [`DirectionalLight`] of its own, a child: Bevy has at most 10 of them in a scene.
///
/// ```
/// use bevy::prelude::*;
/// use bevy_tectonics::{prelude::*, render::MeanSun};
///
/// fn setup(mut commands: Commands) {
///     commands.spawn(Planet::new(Recipe::earth_like(7)).with_pace(Pace::MyPerSecond(8.0)));
///     commands.spawn(MeanSun::default());
/// }
/// ```
#[derive(Component, Debug, Clone, Copy, PartialEq, Reflect)]
#[reflect(Component, Default)]
#[require(Transform, Visibility)]
pub struct MeanSun {
    /// How many suns there are, 1 to 10. Fewer than 5 leave stripes of shadow.
    pub suns: u32,
    /// Light of them all in lux. Half of a planet has night, and mornings are dim: π times the light of noon is as
    /// bright along the equator as noon.
    pub illuminance: f32,
    /// Its colour.
    pub color: Color,
    /// How far the planet's axis is tilted against its orbit, 0 to 90 degrees: suns stand north and south of the
    /// equator in turn, as far as seasons take them on average.
    pub obliquity_degrees: f32,
}

impl Default for MeanSun {
    fn default() -> Self {
        Self {
            suns: 8,
            illuminance: core::f32::consts::PI * bevy::light::light_consts::lux::AMBIENT_DAYLIGHT,
            color: Color::WHITE,
            obliquity_degrees: 23.4,
        }
    }
}

/// Bevy's limit for directional lights.
const MOST: u32 = 10;

/// The lights of a [`MeanSun`].
#[derive(Component)]
struct Lights(Vec<Entity>);

pub(super) fn plugin(app: &mut App) {
    app.register_type::<MeanSun>()
        .add_observer(go_down)
        .add_systems(PostUpdate, rise.before(TransformSystems::Propagate));
}

impl MeanSun {
    /// From where the suns shine, as rotations of lights.
    fn rotations(&self) -> impl Iterator<Item = Quat> {
        let suns = self.suns.clamp(1, MOST);
        let obliquity = if self.obliquity_degrees.is_finite() {
            self.obliquity_degrees.clamp(0.0, 90.0)
        } else {
            0.0
        };
        // The root mean square of a sine.
        let season = obliquity.to_radians() * core::f32::consts::FRAC_1_SQRT_2;
        (0..suns).map(move |i| {
            // An odd one out stands over the equator.
            let north = match i {
                _ if i + 1 == suns && suns % 2 == 1 => 0.0,
                _ if i % 2 == 0 => season,
                _ => -season,
            };
            Quat::from_rotation_y(TAU * i as f32 / suns as f32) * Quat::from_rotation_x(-north)
        })
    }
}

/// Makes the lights anew where a mean sun is new or has changed.
fn rise(
    mut commands: Commands,
    suns: Query<(Entity, &MeanSun, Option<&Lights>), Changed<MeanSun>>,
) {
    for (entity, sun, lights) in &suns {
        for &light in lights.iter().flat_map(|lights| &lights.0) {
            if let Ok(mut light) = commands.get_entity(light) {
                light.try_despawn();
            }
        }
        let illuminance = if sun.illuminance.is_finite() {
            sun.illuminance.max(0.0)
        } else {
            0.0
        };
        let sun = *sun;
        // All or nothing: it may be gone by then.
        commands.queue(move |world: &mut World| {
            if world.get_entity(entity).is_err() {
                return;
            }
            let mut lights = Vec::new();
            for rotation in sun.rotations() {
                let light = DirectionalLight {
                    color: sun.color,
                    illuminance: illuminance / sun.suns.clamp(1, MOST) as f32,
                    ..default()
                };
                let light = (light, Transform::from_rotation(rotation), ChildOf(entity));
                lights.push(world.spawn(light).id());
            }
            world.entity_mut(entity).insert(Lights(lights));
        });
    }
}

/// Takes the lights away with the mean sun.
fn go_down(gone: On<Remove, MeanSun>, suns: Query<&Lights>, mut commands: Commands) {
    let Ok(lights) = suns.get(gone.entity) else {
        return;
    };
    for &light in &lights.0 {
        if let Ok(mut light) = commands.get_entity(light) {
            light.try_despawn();
        }
    }
    if let Ok(mut sun) = commands.get_entity(gone.entity) {
        sun.try_remove::<Lights>();
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn lights(app: &mut App) -> Vec<(f32, Vec3)> {
        let world = app.world_mut();
        let mut lights = world.query::<(&DirectionalLight, &Transform)>();
        let lights = lights.iter(world);
        lights
            .map(|(light, transform)| (light.illuminance, *transform.back()))
            .collect()
    }

    #[test]
    fn light_is_shared_evenly_around_the_axis() {
        let mut app = App::new();
        app.add_plugins(MinimalPlugins).add_plugins(plugin);
        let sun = app.world_mut().spawn(MeanSun::default()).id();
        app.update();
        let all = lights(&mut app);
        assert_eq!(all.len(), 8);
        let sum: f32 = all.iter().map(|(lux, _)| lux).sum();
        assert!((sum / MeanSun::default().illuminance - 1.0).abs() < 1e-5);
        let mean = all.iter().map(|(_, towards)| *towards).sum::<Vec3>();
        assert!(mean.length() < 1e-4, "{mean}");
        // As far north and south as the seasons are on average.
        let north = libm::sinf(23.4_f32.to_radians() / core::f32::consts::SQRT_2);
        assert!(
            all.iter()
                .all(|(_, towards)| (towards.y.abs() - north).abs() < 1e-5)
        );

        // Any number, and nonsense, and its end.
        for (suns, count) in [(0, 1), (3, 3), (99, 10)] {
            *app.world_mut().get_mut::<MeanSun>(sun).unwrap() = MeanSun {
                suns,
                illuminance: f32::NAN,
                obliquity_degrees: f32::NAN,
                ..default()
            };
            app.update();
            let all = lights(&mut app);
            assert_eq!(all.len(), count);
            assert!(
                all.iter()
                    .all(|(lux, towards)| *lux == 0.0 && towards.y.abs() < 1e-6)
            );
        }
        app.world_mut().entity_mut(sun).remove::<MeanSun>();
        app.update();
        assert!(lights(&mut app).is_empty());
        app.world_mut().entity_mut(sun).insert(MeanSun::default());
        app.update();
        app.world_mut().despawn(sun);
        assert!(lights(&mut app).is_empty());
    }
}
