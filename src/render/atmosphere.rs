//! Bevy's atmosphere around planets, for those who prefer it to the air that comes with them.

use super::{Drawn, PlanetAir, PlanetRenderSystems, globe};
use crate::planet::{Planet, PlanetSurface, PlanetView};
use bevy::{
    asset::AssetEventSystems,
    light::{
        Atmosphere,
        atmosphere::{Falloff, PhaseFunction, ScatteringMedium, ScatteringTerm},
    },
    pbr::{ExtractedAtmosphere, GpuAtmosphereSettings, resources::GpuAtmosphere},
    prelude::*,
    render::{Render, RenderApp, RenderSystems, extract_component::DynamicUniformIndex},
    transform::TransformSystems,
};

/// Has Bevy draw the air of a planet, as an [`Atmosphere`] that follows the planet's place, size and [`PlanetAir`]:
/// put it on a [`Planet`], and Bevy's `AtmosphereSettings` on a camera.
///
/// That camera sees Bevy's sky, rim and haze in place of the planet's own, and sunlight on the ground that reddens
/// towards dusk; cameras without settings see what they always do. Of several planets Bevy draws the air of the
/// nearest one, and the others keep their own.
///
/// From orbit, and for mountains further away than 32 km, the settings want `AtmosphereMode::Raymarched`:
///
/// ```
/// use bevy::{pbr::{AtmosphereMode, AtmosphereSettings}, prelude::*};
/// use bevy_tectonics::{prelude::*, render::PlanetAtmosphere};
///
/// fn setup(mut commands: Commands) {
///     commands.spawn((Planet::new(Recipe::earth_like(7)), PlanetAtmosphere::default()));
///     let settings = AtmosphereSettings {
///         rendering_method: AtmosphereMode::Raymarched,
///         ..default()
///     };
///     commands.spawn((Camera3d::default(), Transform::from_xyz(0.0, 0.0, 3.0), settings));
/// }
/// ```
///
/// The air is as deep as [`PlanetAir`] says, and true to scale where heights are. Where [`PlanetView::exaggeration`]
/// makes mountains higher, it rises with them, up to a scale height of 0.0055 radii, so that they do not stand out of
/// it.
///
/// # Limits
///
/// * Clouds come after it, with a haze of their own.
/// * Bevy 0.19 tells materials of the atmosphere of one camera alone: have settings on one at a time.
#[derive(Component, Debug, Clone, Copy, PartialEq, Reflect)]
#[reflect(Component, Default)]
pub struct PlanetAtmosphere {
    /// Share of the light that the ground sends back into the air, for red, green and blue, 0 to 1.
    pub ground_albedo: Vec3,
}

impl Default for PlanetAtmosphere {
    fn default() -> Self {
        Self {
            // Earth's, as Bevy has it.
            ground_albedo: Vec3::splat(0.3),
        }
    }
}

/// Scale height in radii up to which the air rises with the ground: that of the planet's own air, seen from afar.
/// Mirrored in `air.wgsl`.
const RAISED: f32 = 0.0055;
/// Scale heights after which the air ends.
const TOP: f32 = 12.0;

/// What Bevy is told of an air.
#[derive(Debug, Clone, Copy, PartialEq)]
struct Shape {
    /// Of the planet and of the end of its air, in m.
    inner_radius: f32,
    outer_radius: f32,
    ground_albedo: Vec3,
    /// Share of the light scattered along a metre at sea level.
    scattering: Vec3,
}

impl Shape {
    fn new(
        atmosphere: &PlanetAtmosphere,
        air: &PlanetAir,
        view: &PlanetView,
        radius_km: f64,
    ) -> Self {
        let inner_radius = 1000.0 * radius_km.max(1.0) as f32;
        let air = air.uniform(radius_km);
        let raised = air.w * globe::exaggeration(view);
        let scale_m = inner_radius * raised.clamp(air.w, RAISED.max(air.w));
        let albedo = atmosphere.ground_albedo.to_array().map(|share| {
            if share.is_finite() {
                share.clamp(0.0, 1.0)
            } else {
                0.0
            }
        });
        Self {
            inner_radius,
            outer_radius: inner_radius + TOP * scale_m,
            ground_albedo: Vec3::from(albedo),
            scattering: air.truncate() / scale_m,
        }
    }

    fn medium(&self) -> ScatteringMedium {
        let gas = ScatteringTerm {
            absorption: Vec3::ZERO,
            scattering: self.scattering,
            falloff: Falloff::Exponential { scale: 1.0 / TOP },
            phase: PhaseFunction::Rayleigh,
        };
        ScatteringMedium::new(256, 64, [gas]).with_label("planet air")
    }

    fn atmosphere(&self, medium: Handle<ScatteringMedium>) -> Atmosphere {
        Atmosphere {
            inner_radius: self.inner_radius,
            outer_radius: self.outer_radius,
            ground_albedo: self.ground_albedo,
            medium,
        }
    }
}

/// Bevy's side of a [`PlanetAtmosphere`]: an entity of its own, a child of the planet, because Bevy counts in m.
#[derive(Component)]
struct Shell {
    entity: Entity,
    shape: Shape,
}

pub(super) fn plugin(app: &mut App) {
    app.add_observer(stop).add_observer(disappear).add_systems(
        PostUpdate,
        tend.after(super::tend)
            .in_set(PlanetRenderSystems::Tend)
            .before(TransformSystems::Propagate)
            .before(AssetEventSystems),
    );
    if let Some(render) = app.get_sub_app_mut(RenderApp) {
        render.add_systems(
            Render,
            forget
                .after(RenderSystems::ExtractCommands)
                .before(RenderSystems::PrepareAssets),
        );
    }
}

/// Takes what Bevy 0.19 leaves behind from cameras whose atmosphere or settings have gone: it would draw that air for
/// ever.
fn forget(
    mut commands: Commands,
    views: Query<Entity, (With<GpuAtmosphere>, Without<GpuAtmosphereSettings>)>,
) {
    for view in &views {
        commands.entity(view).remove::<(
            ExtractedAtmosphere,
            GpuAtmosphere,
            DynamicUniformIndex<GpuAtmosphere>,
        )>();
    }
}

type Tended = (
    Entity,
    &'static Planet,
    &'static PlanetSurface,
    &'static PlanetView,
    &'static PlanetAtmosphere,
    Option<&'static PlanetAir>,
    Option<&'static Shell>,
    Has<Drawn>,
    Option<&'static InheritedVisibility>,
);

/// Gives planets that are seen their atmosphere, and keeps it as they are.
fn tend(
    mut commands: Commands,
    mut media: ResMut<Assets<ScatteringMedium>>,
    planets: Query<Tended>,
    mut shells: Query<(&mut Atmosphere, &mut Transform), Without<Planet>>,
) {
    for (entity, planet, surface, view, atmosphere, air, shell, drawn, visible) in &planets {
        let is_seen = drawn && visible.is_none_or(|visible| visible.get());
        if !(is_seen && planet.radius > 0.0 && planet.radius.is_finite()) {
            if let Some(shell) = shell {
                clear(entity, shell, &mut commands);
            }
            continue;
        }
        let air = air.copied().unwrap_or_default();
        let shape = Shape::new(atmosphere, &air, view, surface.radius_km);
        let size = Transform::from_scale(Vec3::splat(planet.radius / shape.inner_radius));
        let Some(shell) = shell else {
            let atmosphere = shape.atmosphere(media.add(shape.medium()));
            // All or nothing: the planet may be gone by then, or prefer its own air.
            commands.queue(move |world: &mut World| {
                let planet = world.get_entity(entity);
                if !planet
                    .is_ok_and(|it| it.contains::<Planet>() && it.contains::<PlanetAtmosphere>())
                {
                    return;
                }
                let shell = (Name::new("Atmosphere"), atmosphere, size, ChildOf(entity));
                let shell = world.spawn(shell).id();
                world.entity_mut(entity).insert(Shell {
                    entity: shell,
                    shape,
                });
            });
            continue;
        };
        let Ok((mut atmosphere, mut transform)) = shells.get_mut(shell.entity) else {
            // Somebody took it away: it comes back with the next frame.
            commands.entity(entity).try_remove::<Shell>();
            continue;
        };
        transform.set_if_neq(size);
        if shell.shape != shape {
            if shell.shape.scattering != shape.scattering {
                atmosphere.medium = media.add(shape.medium());
            }
            *atmosphere = shape.atmosphere(atmosphere.medium.clone());
            commands
                .entity(entity)
                .try_insert(Shell { shape, ..*shell });
        }
    }
}

/// Takes the atmosphere away from a planet that shall have its own air.
fn stop(gone: On<Remove, PlanetAtmosphere>, shells: Query<&Shell>, mut commands: Commands) {
    if let Ok(shell) = shells.get(gone.entity) {
        clear(gone.entity, shell, &mut commands);
    }
}

/// Clears up after a planet that is none any more.
fn disappear(gone: On<Remove, Planet>, shells: Query<&Shell>, mut commands: Commands) {
    if let Ok(shell) = shells.get(gone.entity) {
        clear(gone.entity, shell, &mut commands);
    }
}

fn clear(planet: Entity, shell: &Shell, commands: &mut Commands) {
    if let Ok(mut shell) = commands.get_entity(shell.entity) {
        shell.try_despawn();
    }
    if let Ok(mut planet) = commands.get_entity(planet) {
        planet.try_remove::<Shell>();
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{planet::PlanetPlugin, simulation::Recipe};
    use core::time::Duration;

    fn view(exaggeration: f32) -> PlanetView {
        PlanetView {
            exaggeration,
            ..default()
        }
    }

    #[test]
    fn the_medium_scatters_as_much_as_the_air() {
        for (scale_height_m, radius_km) in [(8000.0, 6371.0), (400.0, 3000.0), (30_000.0, 2000.0)] {
            let air = PlanetAir {
                scale_height_m,
                ..default()
            };
            let atmosphere = PlanetAtmosphere::default();
            let shape = Shape::new(&atmosphere, &air, &view(1.0), radius_km);
            let medium = shape.medium();
            let gas = &medium.terms[0];
            // Straight down, by the middles of small steps.
            let steps = 100_000;
            let sum: f64 = (0..steps)
                .map(|i| (f64::from(i) + 0.5) / f64::from(steps))
                .map(|falloff| f64::from(gas.falloff.sample(falloff as f32)))
                .sum();
            let height_m = f64::from(shape.outer_radius - shape.inner_radius);
            let depth = gas.scattering.as_dvec3() * (sum / f64::from(steps) * height_m);
            assert!((depth / air.depth.as_dvec3() - 1.0).abs().max_element() < 1e-3);
            assert_eq!(gas.absorption, Vec3::ZERO);
        }
    }

    #[test]
    fn nonsense_is_no_air_and_no_panic() {
        let air = PlanetAir {
            depth: Vec3::new(f32::NAN, -1.0, f32::INFINITY),
            scale_height_m: f32::NAN,
        };
        let atmosphere = PlanetAtmosphere {
            ground_albedo: Vec3::new(f32::NAN, -1.0, f32::INFINITY),
        };
        for radius_km in [0.0, f64::NAN, -5.0, 6371.0] {
            let shape = Shape::new(&atmosphere, &air, &view(f32::NAN), radius_km);
            assert_eq!(shape.scattering, Vec3::ZERO);
            assert_eq!(shape.ground_albedo, Vec3::ZERO);
            assert!(shape.inner_radius >= 1000.0 && shape.outer_radius > shape.inner_radius);
            assert!(shape.outer_radius.is_finite());
        }
    }

    #[test]
    fn the_air_rises_with_the_mountains_up_to_a_point() {
        assert!(include_str!("air.wgsl").contains("const SCALE_HEIGHT: f32 = 0.0055;"));
        let shape = |exaggeration| {
            let (atmosphere, air) = (PlanetAtmosphere::default(), PlanetAir::default());
            Shape::new(&atmosphere, &air, &view(exaggeration), 6371.0)
        };
        for (exaggeration, scale_m) in [
            (0.0, 8e3),
            (1.0, 8e3),
            (2.0, 16e3),
            (12.0, 35e3),
            (200.0, 35e3),
        ] {
            let shape = shape(exaggeration);
            let height = shape.outer_radius - shape.inner_radius;
            assert!((height / TOP / scale_m - 1.0_f32).abs() < 2e-3);
            // No more air than before.
            let depth = shape.scattering * height / TOP;
            assert!(depth.abs_diff_eq(PlanetAir::default().depth, 1e-4));
        }
    }

    fn atmospheres(app: &mut App) -> Vec<(Atmosphere, GlobalTransform)> {
        let world = app.world_mut();
        let mut query = world.query::<(&Atmosphere, &GlobalTransform)>();
        let all = query.iter(world);
        all.map(|(air, place)| (air.clone(), *place)).collect()
    }

    #[test]
    fn atmospheres_come_follow_and_go() {
        let mut app = App::new();
        app.add_plugins((
            MinimalPlugins,
            AssetPlugin::default(),
            TransformPlugin,
            PlanetPlugin::default().with_threads(1),
            plugin,
        ))
        .init_asset::<ScatteringMedium>();
        let planet = Planet::new(Recipe::earth_like(7).with_sub_plates(500));
        let planet = planet.with_radius(3.0).with_end(1.0);
        let at = Transform::from_xyz(1.0, 2.0, 3.0).with_scale(Vec3::splat(2.0));
        let planet = (planet, PlanetAtmosphere::default(), view(1.0), at);
        let planet = app.world_mut().spawn(planet).id();
        for _ in 0..20_000 {
            app.update();
            if app.world().get::<PlanetSurface>(planet).is_some() {
                break;
            }
            std::thread::sleep(Duration::from_millis(1));
        }
        // Not before there is ground to be seen.
        assert!(atmospheres(&mut app).is_empty());
        let drawn = Drawn {
            time_my: 1.0,
            settled: true,
        };
        app.world_mut().entity_mut(planet).insert(drawn);
        app.update();
        let radius_m = 1000.0 * app.world().get::<PlanetSurface>(planet).unwrap().radius_km as f32;
        let size = |place: &GlobalTransform| place.scale() * radius_m;
        {
            let [(drawn, place)] = &atmospheres(&mut app)[..] else {
                panic!("one planet, one atmosphere");
            };
            assert_eq!(drawn.inner_radius, radius_m);
            assert!((drawn.outer_radius - radius_m - 96_000.0).abs() < 2.0);
            // As large in the world as the planet.
            assert_eq!(place.translation(), at.translation);
            assert!((size(place) - 6.0).abs().max_element() < 1e-5);
        }

        // Another air, another size, out of sight and back.
        let air = PlanetAir {
            scale_height_m: 20_000.0,
            ..default()
        };
        app.world_mut().entity_mut(planet).insert(air);
        app.world_mut().get_mut::<Planet>(planet).unwrap().radius = 1.0;
        app.update();
        {
            let (drawn, place) = &atmospheres(&mut app)[0];
            assert!((drawn.outer_radius - radius_m - 240_000.0).abs() < 2.0);
            assert!((size(place) - 2.0).abs().max_element() < 1e-5);
            let media = app.world().resource::<Assets<ScatteringMedium>>();
            let scattering = media.get(&drawn.medium).unwrap().terms[0].scattering;
            let share = scattering / (air.depth / 20_000.0);
            assert!((share - 1.0).abs().max_element() < 1e-5);
        }
        for (visible, count) in [
            (InheritedVisibility::HIDDEN, 0),
            (InheritedVisibility::VISIBLE, 1),
        ] {
            app.world_mut().entity_mut(planet).insert(visible);
            app.update();
            assert_eq!(atmospheres(&mut app).len(), count);
        }

        let mut entity = app.world_mut().entity_mut(planet);
        let preference = entity.take::<PlanetAtmosphere>().unwrap();
        app.update();
        assert!(atmospheres(&mut app).is_empty());
        app.world_mut().entity_mut(planet).insert(preference);
        app.update();
        assert_eq!(atmospheres(&mut app).len(), 1);
        app.world_mut().entity_mut(planet).remove::<Planet>();
        app.update();
        assert!(atmospheres(&mut app).is_empty() && app.world().get::<Shell>(planet).is_none());
        app.world_mut().despawn(planet);
        app.update();
        assert!(
            app.world()
                .resource::<Assets<ScatteringMedium>>()
                .is_empty()
        );
    }
}
