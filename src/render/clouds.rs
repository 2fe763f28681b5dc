//! Clouds over a planet: a thin shell that shows where a planet like this has them.
//!
//! How many clouds a place has follows from its latitude (rain near the equator, clear skies where air sinks, storms
//! between the westerlies and the cold, grey poles) and from the ground below: fewer over deserts, more where the wind
//! climbs a range, fewer behind it, low ones on the cold seas off western coasts. The vertex shader sums that up. Their
//! shapes are noise that winds have bent, in as many octaves as pixels can show, down to 150 m.
//!
//! # Limits
//!
//! * The shell has no thickness, casts no shadows, and knows directional and ambient light only.
//! * It is drawn after the air, which has the same middle: the blue of the sky lies behind clouds, the haze before them
//!   is their own.

use super::{
    PlanetRenderSystems, Shared,
    globe::Globe,
    material::{PlanetMaterial, PlanetUniform},
};
use crate::planet::Planet;
use bevy::{
    asset::{AssetEventSystems, embedded_asset},
    camera::{
        primitives::Aabb,
        visibility::{NoAutoAabb, VisibilitySystems},
    },
    light::NotShadowCaster,
    mesh::MeshVertexBufferLayoutRef,
    pbr::{Material, MaterialPipeline, MaterialPipelineKey, MaterialPlugin},
    prelude::*,
    render::render_resource::{
        AsBindGroup, RenderPipelineDescriptor, ShaderType, SpecializedMeshPipelineError,
    },
    shader::ShaderRef,
    transform::TransformSystems,
};

/// Draws clouds over a planet: put it on a [`Planet`]. Planets without it have none.
///
/// The deck stands at its height times [`PlanetView::exaggeration`](crate::planet::PlanetView::exaggeration), as the
/// ground does, so that high mountains rise above it. Cameras may be above and below.
///
/// ```
/// use bevy::prelude::*;
/// use bevy_tectonics::{prelude::*, render::PlanetClouds};
///
/// fn setup(mut commands: Commands) {
///     commands.spawn((Planet::new(Recipe::earth_like(7)), PlanetClouds::default()));
/// }
/// ```
#[derive(Component, Debug, Clone, Copy, PartialEq, Reflect)]
#[reflect(Component, Default)]
pub struct PlanetClouds {
    /// Share of the sky that clouds fill on average, 0 to 1. Earth's is about 0.6; at less there is more to see.
    pub cover: f32,
    /// Height of the deck above the sea in m, 1,000 to 20,000.
    pub height_m: f32,
    /// How many times faster than real ones they move, 0 to 10,000: winds of 10 m/s. At 0 they stand still. They go
    /// by the app's `Time`, whose clock for shaders begins anew every hour, and so does the weather.
    pub drift: f32,
    /// Their colour in white light; its alpha is the opacity of the thickest.
    pub color: Color,
}

impl Default for PlanetClouds {
    fn default() -> Self {
        Self {
            cover: 0.45,
            height_m: 5000.0,
            drift: 1.0,
            color: Color::linear_rgb(0.83, 0.84, 0.86),
        }
    }
}

/// Standard deviations of the noise per unit of the cover's logit: 0.59 if weather were the same everywhere, more
/// because belts differ.
const CONTRAST: f32 = 0.82;
/// Lowest that the shell may stand in radii, with heights drawn flat: clear of its own facets.
const LOWEST: f32 = 3e-4;
/// Distance in km from a camera within which the shell is not drawn.
const NEAR_KM: f32 = 0.3;
/// Speed of the wind in km/s.
const WIND_KM_S: f32 = 0.01;
/// Radians that winds carry weather before other weather follows: further, and belts would shear it to threads.
const FURTHEST: f32 = 0.1;
/// Seconds after which the clock of shaders begins anew.
const HOUR_S: f32 = 3600.0;

impl PlanetClouds {
    fn cover(&self) -> f32 {
        within(self.cover, 0.0, 1.0, 0.0)
    }

    /// What shaders want to know of them, over this ground.
    fn uniform(&self, ground: &PlanetUniform) -> CloudUniform {
        let LinearRgba {
            red,
            green,
            blue,
            alpha,
        } = self.color.into();
        let color = [red, green, blue, alpha].map(|part| within(part, 0.0, 1.0, 0.0));
        let cover = self.cover().clamp(0.001, 0.999);
        let height_km = 0.001 * within(self.height_m, 1000.0, 20_000.0, 5000.0);
        let turn = within(self.drift, 0.0, 10_000.0, 0.0) * WIND_KM_S / ground.radius_km.max(1.0);
        // A whole number of times an hour, and never the same weather twice in a row.
        let periods = if turn > 0.0 {
            (HOUR_S * turn / FURTHEST).ceil().max(2.0)
        } else {
            1.0
        };
        CloudUniform {
            color: Vec4::from_array(color),
            threshold: -CONTRAST * libm::logf(cover / (1.0 - cover)),
            lift: (ground.height * (height_km + ground.datum)).max(LOWEST),
            near: (NEAR_KM * ground.height).max(0.1 * LOWEST),
            turn,
            period: HOUR_S / periods,
            periods,
        }
    }
}

/// A number as far as it makes sense.
fn within(value: f32, least: f32, most: f32, otherwise: f32) -> f32 {
    if value.is_finite() {
        value.clamp(least, most)
    } else {
        otherwise
    }
}

/// The order is that of `clouds.wgsl`.
#[derive(ShaderType, Debug, Clone, Copy, Default, PartialEq)]
pub(super) struct CloudUniform {
    color: Vec4,
    /// What noise has to exceed for a cloud where they are as common as on average, in standard deviations.
    threshold: f32,
    /// Height of the shell in radii.
    lift: f32,
    /// Distance from a camera within which it is not drawn, in radii.
    near: f32,
    /// Radians per second by which the winds turn their belts.
    turn: f32,
    /// Seconds until other weather follows.
    period: f32,
    /// How many times there is other weather.
    periods: f32,
}

/// Clouds over the ground that a [`PlanetMaterial`] shows. Bindings 0 to 10 are those of that material.
#[derive(Asset, AsBindGroup, TypePath, Debug, Clone, PartialEq)]
pub(super) struct CloudMaterial {
    /// Brings them before the air, in units of the world.
    bias: f32,
    #[uniform(0)]
    ground: PlanetUniform,
    #[texture(1, dimension = "cube")]
    #[sampler(2)]
    relief_a: Handle<Image>,
    #[texture(3, dimension = "cube")]
    relief_b: Handle<Image>,
    #[texture(4, dimension = "cube")]
    climate_a: Handle<Image>,
    #[texture(5, dimension = "cube")]
    climate_b: Handle<Image>,
    #[texture(6, dimension = "cube")]
    velocity_a: Handle<Image>,
    #[texture(7, dimension = "cube")]
    velocity_b: Handle<Image>,
    #[texture(8, dimension = "cube")]
    overlay_a: Option<Handle<Image>>,
    #[texture(9, dimension = "cube")]
    overlay_b: Option<Handle<Image>>,
    #[texture(10)]
    palette: Handle<Image>,
    #[uniform(11)]
    clouds: CloudUniform,
}

impl CloudMaterial {
    fn over(ground: &PlanetMaterial, clouds: &PlanetClouds, radius: f32) -> Self {
        Self {
            // Both have the same middle, and this much is still seen in numbers from 100,000 radii away.
            bias: 0.01 * radius,
            // What clouds do not look at shall not make them change.
            ground: PlanetUniform {
                overlay: Vec2::ZERO,
                tiles: 0.0,
                reach: 0.0,
                ..ground.uniform
            },
            relief_a: ground.relief_a.clone(),
            relief_b: ground.relief_b.clone(),
            climate_a: ground.climate_a.clone(),
            climate_b: ground.climate_b.clone(),
            velocity_a: ground.velocity_a.clone(),
            velocity_b: ground.velocity_b.clone(),
            overlay_a: None,
            overlay_b: None,
            palette: ground.palette.clone(),
            clouds: clouds.uniform(&ground.uniform),
        }
    }
}

const SHADER: &str = "embedded://bevy_tectonics/render/clouds.wgsl";

impl Material for CloudMaterial {
    fn vertex_shader() -> ShaderRef {
        SHADER.into()
    }

    fn fragment_shader() -> ShaderRef {
        SHADER.into()
    }

    fn alpha_mode(&self) -> AlphaMode {
        AlphaMode::Blend
    }

    fn depth_bias(&self) -> f32 {
        self.bias
    }

    fn enable_prepass() -> bool {
        false
    }

    fn enable_shadows() -> bool {
        false
    }

    fn specialize(
        _: &MaterialPipeline,
        descriptor: &mut RenderPipelineDescriptor,
        _: &MeshVertexBufferLayoutRef,
        _: MaterialPipelineKey<Self>,
    ) -> Result<(), SpecializedMeshPipelineError> {
        // Seen from above and from below: the shader leaves out the far side.
        descriptor.primitive.cull_mode = None;
        Ok(())
    }
}

/// Draws clouds in an app that draws planets.
pub(super) fn plugin(app: &mut App) {
    embedded_asset!(app, "clouds.wgsl");
    app.add_plugins(MaterialPlugin::<CloudMaterial>::default())
        .add_observer(stop)
        .add_observer(disappear)
        .add_systems(
            PostUpdate,
            (appear, tend)
                .chain()
                .after(super::tend)
                .in_set(PlanetRenderSystems::Tend)
                .before(TransformSystems::Propagate)
                .before(VisibilitySystems::VisibilityPropagate)
                .before(VisibilitySystems::CheckVisibility)
                .before(AssetEventSystems),
        );
}

/// What is drawn of a planet's clouds, beside its [`PlanetClouds`].
#[derive(Component)]
struct Deck {
    /// The entity of the shell, a child of the planet.
    shell: Entity,
    material: Handle<CloudMaterial>,
}

/// Gives planets their shell.
fn appear(
    mut commands: Commands,
    shared: Res<Shared>,
    grounds: Res<Assets<PlanetMaterial>>,
    mut materials: ResMut<Assets<CloudMaterial>>,
    planets: Query<(Entity, &Planet, &PlanetClouds, &Globe), Without<Deck>>,
) {
    for (entity, planet, clouds, globe) in &planets {
        let Some(ground) = grounds.get(&globe.material) else {
            continue;
        };
        let material = materials.add(CloudMaterial::over(ground, clouds, planet.radius));
        let sphere = shared.sphere.clone();
        // All or nothing: the planet may be gone by then, or its clouds.
        commands.queue(move |world: &mut World| {
            let planet = world.get_entity(entity);
            if !planet.is_ok_and(|it| it.contains::<PlanetClouds>() && it.contains::<Globe>()) {
                return;
            }
            let shell = (
                Name::new("Clouds"),
                Mesh3d(sphere),
                MeshMaterial3d(material.clone()),
                Visibility::Hidden,
                NotShadowCaster,
                NoAutoAabb,
                Aabb::from_min_max(Vec3::NEG_ONE, Vec3::ONE),
                ChildOf(entity),
            );
            let shell = world.spawn(shell).id();
            world.entity_mut(entity).insert(Deck { shell, material });
        });
    }
}

/// Keeps shells as large as their planets, over the ground that is seen.
fn tend(
    grounds: Res<Assets<PlanetMaterial>>,
    mut materials: ResMut<Assets<CloudMaterial>>,
    planets: Query<(&Planet, &PlanetClouds, &Globe, &Deck)>,
    mut parts: Query<(&mut Transform, &mut Visibility, &mut Aabb), Without<Planet>>,
    mut meshes: Query<(Ref<GlobalTransform>, &mut Mesh3d)>,
) {
    for (planet, clouds, globe, deck) in &planets {
        let Some(ground) = grounds.get(&globe.material) else {
            continue;
        };
        let wanted = CloudMaterial::over(ground, clouds, planet.radius);
        let reach = 1.0 + wanted.clouds.lift;
        if materials.get(&deck.material) != Some(&wanted)
            && let Some(mut material) = materials.get_mut(&deck.material)
        {
            *material = wanted;
        }
        if let Ok((mut transform, mut visibility, mut bounds)) = parts.get_mut(deck.shell) {
            transform.set_if_neq(Transform::from_scale(Vec3::splat(planet.radius)));
            bounds.set_if_neq(Aabb::from_min_max(Vec3::splat(-reach), Vec3::splat(reach)));
            // Not before there is ground below.
            let is_seen = globe.drawn().is_some() && clouds.cover() > 0.0;
            visibility.set_if_neq(if is_seen {
                Visibility::Inherited
            } else {
                Visibility::Hidden
            });
        }
        // Bevy 0.19 sorts what is transparent by where it was when it came into view or changed (bevy#24826): on a
        // planet that moves, the air could come to be drawn after the clouds.
        for part in [globe.sky, deck.shell] {
            if let Ok((place, mut mesh)) = meshes.get_mut(part)
                && place.is_changed()
            {
                mesh.set_changed();
            }
        }
    }
}

/// Clears up after a planet that has no clouds any more.
fn stop(gone: On<Remove, PlanetClouds>, decks: Query<&Deck>, commands: Commands) {
    clear(gone.entity, decks, commands);
}

/// Clears up after a planet that is none any more.
fn disappear(gone: On<Remove, Planet>, decks: Query<&Deck>, commands: Commands) {
    clear(gone.entity, decks, commands);
}

fn clear(planet: Entity, decks: Query<&Deck>, mut commands: Commands) {
    let Ok(deck) = decks.get(planet) else {
        return;
    };
    if let Ok(mut shell) = commands.get_entity(deck.shell) {
        shell.try_despawn();
    }
    if let Ok(mut planet) = commands.get_entity(planet) {
        planet.try_remove::<Deck>();
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{
        planet::PlanetPlugin,
        render::{self, PlanetRenderSettings, material::SkyMaterial, upload::Uploads},
        simulation::Recipe,
    };
    use core::time::Duration;

    /// Earth's ground as it is drawn by default.
    fn earth() -> PlanetUniform {
        PlanetUniform {
            height: 12.0 / 6371.0,
            radius_km: 6371.0,
            ..default()
        }
    }

    #[test]
    fn nonsense_is_no_cloud_and_no_panic() {
        let clouds = PlanetClouds {
            cover: f32::NAN,
            height_m: f32::INFINITY,
            drift: -3.0,
            color: Color::linear_rgba(2.0, -1.0, f32::NAN, 9.0),
        };
        assert_eq!(clouds.cover(), 0.0);
        let uniform = clouds.uniform(&earth());
        assert_eq!(uniform.color, Vec4::new(1.0, 0.0, 0.0, 1.0));
        assert_eq!((uniform.turn, uniform.periods), (0.0, 1.0));
        let five_km = PlanetClouds::default().uniform(&earth());
        assert_eq!(uniform.lift, five_km.lift);
        // Heights drawn flat, a radius that is not known yet, a sea drawn far too low.
        let ground = PlanetUniform {
            height: 0.0,
            radius_km: 0.0,
            datum: -1e6,
            ..default()
        };
        let uniform = PlanetClouds::default().uniform(&ground);
        assert!(uniform.lift > 0.0 && uniform.near > 0.0 && uniform.near < uniform.lift);
        assert!(uniform.turn.is_finite() && uniform.period > 0.0);
    }

    #[test]
    fn more_cover_asks_less_of_the_noise() {
        let threshold = |cover| {
            let clouds = PlanetClouds { cover, ..default() };
            clouds.uniform(&earth()).threshold
        };
        assert!(threshold(0.5).abs() < 1e-6);
        let all = [-1.0, 0.2, 0.55, 0.9, 2.0].map(threshold);
        assert!(all.is_sorted_by(|a, b| a > b), "{all:?}");
        // Hardly any noise is beyond.
        assert!(all[0] > 5.0 && all[4] < -5.0 && all.iter().all(|t| t.is_finite()));
    }

    #[test]
    fn weather_changes_before_winds_shear_it_and_with_the_clock() {
        for drift in [0.0, 1e-3, 1.0, 77.0, 1e9] {
            let clouds = PlanetClouds { drift, ..default() };
            let uniform = clouds.uniform(&earth());
            assert!(uniform.turn * uniform.period <= 1.001 * FURTHEST);
            assert_eq!(uniform.periods.fract(), 0.0);
            assert!((uniform.period * uniform.periods - HOUR_S).abs() < 0.01);
            assert_eq!(uniform.periods >= 2.0, drift > 0.0);
        }
    }

    #[test]
    fn clouds_go_with_the_winds_that_raise_the_waves() {
        for shared in [
            "smoothstep(0.42, 0.58,",
            "smoothstep(0.82, 0.92,",
            "(0.9 * east + 0.44 * poleward)",
            "const TURN: mat3x3<f32> = mat3x3(0.00, 0.80, 0.60, -0.80, 0.36, -0.48, -0.60, -0.48, 0.64);",
        ] {
            assert!(include_str!("tile.wgsl").contains(shared), "{shared}");
            assert!(include_str!("clouds.wgsl").contains(shared), "{shared}");
        }
    }

    /// What draws planets, without a GPU to draw on.
    fn game() -> App {
        let mut app = App::new();
        app.add_plugins((
            MinimalPlugins,
            AssetPlugin::default(),
            PlanetPlugin::default().with_threads(1),
        ))
        .init_asset::<Image>()
        .init_asset::<Mesh>()
        .init_asset::<PlanetMaterial>()
        .init_asset::<SkyMaterial>()
        .init_asset::<CloudMaterial>()
        .init_resource::<Uploads>()
        .insert_resource(PlanetRenderSettings { face: 64 })
        .insert_resource(Shared {
            sphere: Handle::default(),
        })
        .add_observer(render::disappear)
        .add_observer(stop)
        .add_observer(disappear)
        .add_systems(
            PostUpdate,
            (render::appear, render::tend, appear, tend).chain(),
        );
        app
    }

    /// Frames until there are so many shells.
    fn until(app: &mut App, count: usize) {
        for _ in 0..20_000 {
            app.update();
            if shells(app).len() == count {
                return;
            }
            std::thread::sleep(Duration::from_millis(1));
        }
        panic!("never {count}");
    }

    fn shells(app: &mut App) -> Vec<(Vec3, Visibility)> {
        let world = app.world_mut();
        let mut query = world.query::<(&Transform, &Visibility, &MeshMaterial3d<CloudMaterial>)>();
        let shells = query.iter(world);
        shells
            .map(|(transform, visibility, _)| (transform.scale, *visibility))
            .collect()
    }

    #[test]
    fn shells_come_and_go_with_the_clouds_of_a_planet() {
        let mut app = game();
        let planet = Planet::new(Recipe::earth_like(7).with_sub_plates(500));
        let planet = planet.with_radius(3.0).with_end(1.0);
        let planet = (planet, PlanetClouds::default());
        let planet = app.world_mut().spawn(planet).id();
        until(&mut app, 1);
        // Nothing has reached a GPU: there is no ground to be seen yet.
        app.update();
        let hidden = vec![(Vec3::splat(3.0), Visibility::Hidden)];
        assert_eq!(shells(&mut app), hidden);

        let deck = app.world().get::<Deck>(planet).unwrap().material.clone();
        app.world_mut()
            .get_mut::<PlanetClouds>(planet)
            .unwrap()
            .cover = 0.2;
        app.update();
        let materials = app.world().resource::<Assets<CloudMaterial>>();
        assert!(materials.get(&deck).unwrap().clouds.threshold > 1.0);

        let mut entity = app.world_mut().entity_mut(planet);
        let clouds = entity.take::<PlanetClouds>().unwrap();
        until(&mut app, 0);
        assert!(app.world().get::<Deck>(planet).is_none());
        app.world_mut().entity_mut(planet).insert(clouds);
        until(&mut app, 1);
        app.world_mut().entity_mut(planet).remove::<Planet>();
        until(&mut app, 0);
        app.update();
        assert!(app.world().get::<Deck>(planet).is_none());
    }
}
