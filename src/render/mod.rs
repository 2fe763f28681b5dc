//! Planets in a scene: land and sea with shaded relief, in the colours of a planet seen from space.
//!
//! With [`PlanetRenderPlugin`] every [`Planet`] is drawn as soon as it has a surface. It follows its
//! `Transform` and is lit by the lights of the scene; [`PlanetView`] says how it is drawn.
//!
//! # How it works
//!
//! A snapshot is baked into cube maps on background tasks, first coarsely, so that the planet is there
//! at once. The maps are written to the GPU a face at a time. From one snapshot to the next the picture
//! blends, and what the plates carry glides along. The vertex shader lifts one mesh, which all planets
//! share; everything else is decided per pixel, the coast too.
//!
//! # Limits
//!
//! * Only tiles cast shadows, on the ground around the camera: a planet casts none as a whole. Neither is in depth
//!   prepasses.
//! * The glow of the air knows directional lights only.
//! * The air is drawn round: a `Transform` that squashes the planet does not squash it.
//! * Tiles (`PlanetTiles`) follow the planet's `Transform`, but its scale must be even; they are in no render layers.

mod air;
mod arrows;
mod atmosphere;
mod bake;
mod blend;
mod boundaries;
mod chain;
mod climate;
mod clouds;
mod cube;
mod drape;
mod globe;
#[cfg(feature = "terrain")]
mod gpu_terrain;
mod grain;
mod lines;
mod material;
mod paint;
mod palette;
mod preset;
mod sphere;
mod stars;
mod suns;
#[cfg(feature = "terrain")]
mod tiles;
mod upload;
mod walk;

use crate::planet::{Planet, PlanetSurface, PlanetView};
use crate::surface::Overlay;
pub use air::PlanetAir;
pub use atmosphere::PlanetAtmosphere;
use bevy::{
    asset::AssetEventSystems,
    camera::{
        primitives::Aabb,
        visibility::{NoAutoAabb, VisibilitySystems},
    },
    light::NotShadowCaster,
    prelude::*,
    render::RenderApp,
    time::Real,
    transform::TransformSystems,
};
pub use clouds::PlanetClouds;
use globe::Globe;
#[cfg(feature = "terrain")]
pub use gpu_terrain::{GpuTerrain, GpuTerrainError};
use material::{Lighting, PlanetMaterial, SkyMaterial, SkyUniform};
pub use palette::{Gradient, Palette, PaletteError, PlanetPalette};
pub use preset::Preset;
pub use stars::Stars;
pub use suns::MeanSun;
#[cfg(feature = "terrain")]
pub use tiles::{PlanetTiles, TilesDrawn, Viewpoint};
use upload::Uploads;

/// Draws every planet. Does nothing in an app without a renderer.
///
/// Add it before the first planet is spawned: it makes `Planet` require `Visibility`.
#[derive(Debug, Clone, Copy, Default)]
pub struct PlanetRenderPlugin;

/// How finely planets are drawn. Applies to planets that appear later.
#[derive(Resource, Debug, Clone, PartialEq, Eq, Reflect)]
#[reflect(Resource, Default)]
pub struct PlanetRenderSettings {
    /// Texels along an edge of the cube map, 64 to 2048, a power of two. 512 are about 20 km on Earth
    /// and take 70 MB of the GPU's memory and 25 MB beside; each doubling takes four times as much.
    pub face: u32,
}

impl Default for PlanetRenderSettings {
    fn default() -> Self {
        Self { face: 512 }
    }
}

impl PlanetRenderSettings {
    fn texels(&self) -> u32 {
        self.face.clamp(64, 2048).next_power_of_two()
    }
}

/// What is seen of a planet, on its entity from the moment on which something is: for loading screens and
/// for pictures. Written by [`PlanetRenderPlugin`] alone.
#[derive(Component, Debug, Clone, Copy, PartialEq, Reflect)]
#[reflect(Component)]
pub struct Drawn {
    /// Time of the surface that is seen, or that the picture blends towards, in My.
    pub time_my: f64,
    /// Whether the newest surface is seen in all its detail, and nothing blends.
    pub settled: bool,
}

/// What [`PlanetRenderPlugin`] does in `PostUpdate`.
#[derive(SystemSet, Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum PlanetRenderSystems {
    /// New planets get what is drawn of them; snapshots go their way to the screen.
    Tend,
}

/// Radius of the mesh of the air, in radii of the planet.
const SKY: f32 = 1.08;

/// What all planets share.
#[derive(Resource)]
struct Shared {
    sphere: Handle<Mesh>,
}

impl Plugin for PlanetRenderPlugin {
    fn build(&self, app: &mut App) {
        app.register_type::<Drawn>()
            .register_type::<PlanetAir>()
            .register_type::<PlanetAtmosphere>()
            .register_type::<PlanetClouds>()
            .register_type::<PlanetPalette>()
            .register_type::<PlanetRenderSettings>()
            .init_resource::<PlanetRenderSettings>();
        // Another plugin may have done so.
        let _ = app.try_register_required_components::<Planet, Visibility>();
        if app.get_sub_app(RenderApp).is_none() {
            return;
        }
        app.add_plugins((
            material::plugin,
            palette::plugin,
            clouds::plugin,
            stars::plugin,
            suns::plugin,
            atmosphere::plugin,
            upload::plugin,
            lines::plugin,
        ));
        #[cfg(feature = "terrain")]
        app.add_plugins(tiles::plugin);
        app.add_observer(disappear).add_systems(
            PostUpdate,
            (appear, palette::dye, tend)
                .chain()
                .in_set(PlanetRenderSystems::Tend)
                .before(TransformSystems::Propagate)
                .before(VisibilitySystems::VisibilityPropagate)
                .before(VisibilitySystems::CheckVisibility)
                .before(AssetEventSystems),
        );
        let world = app.world_mut();
        let sphere = world.resource_mut::<Assets<Mesh>>().add(sphere::sphere());
        world.insert_resource(Shared { sphere });
    }
}

/// Gives new planets a ground and an air.
fn appear(
    mut commands: Commands,
    shared: Res<Shared>,
    settings: Res<PlanetRenderSettings>,
    mut images: ResMut<Assets<Image>>,
    mut materials: ResMut<Assets<PlanetMaterial>>,
    planets: Query<(Entity, &PlanetSurface, Has<Visibility>), (With<Planet>, Without<Globe>)>,
) {
    for (entity, surface, visible) in &planets {
        let (mut globe, material) = Globe::new(surface, &settings, &mut images, &mut materials);
        let sphere = shared.sphere.clone();
        // All or nothing: the planet may be gone by then.
        commands.queue(move |world: &mut World| {
            if world.get_entity(entity).is_err() {
                return;
            }
            let part = (
                Mesh3d(sphere),
                Visibility::Hidden,
                NotShadowCaster,
                NoAutoAabb,
                Aabb::from_min_max(Vec3::NEG_ONE, Vec3::ONE),
                ChildOf(entity),
            );
            let ground = (Name::new("Ground"), MeshMaterial3d(material), part.clone());
            globe.body = world.spawn(ground).id();
            globe.sky = world.spawn((Name::new("Air"), part)).id();
            let mut planet = world.entity_mut(entity);
            planet.insert(globe);
            if !visible {
                planet.insert(Visibility::default());
            }
        });
    }
}

type Tended = (
    Entity,
    &'static Planet,
    Ref<'static, PlanetSurface>,
    &'static PlanetView,
    Option<&'static PlanetAir>,
    &'static mut Globe,
    Option<&'static mut Drawn>,
);

/// Leads snapshots to the screen, and keeps the parts as large as the planet.
fn tend(
    mut commands: Commands,
    time: Option<Res<Time<Real>>>,
    mut images: ResMut<Assets<Image>>,
    mut materials: ResMut<Assets<PlanetMaterial>>,
    mut skies: ResMut<Assets<SkyMaterial>>,
    mut uploads: ResMut<Uploads>,
    suns: Query<&DirectionalLight>,
    lamps: Query<(), Or<(With<PointLight>, With<SpotLight>, With<RectLight>)>>,
    mut planets: Query<Tended>,
    mut parts: Query<(&mut Transform, &mut Visibility, &mut Aabb), Without<Planet>>,
) {
    let seconds = time.map_or(0.0, |time| time.delta_secs());
    let lighting = Lighting {
        lamps: !lamps.is_empty(),
        shadows: suns.iter().any(|sun| sun.shadow_maps_enabled),
    };
    for (entity, planet, surface, view, air, mut globe, drawn) in &mut planets {
        let globe = globe.bypass_change_detection();
        let overlay = view
            .overlay
            .filter(|overlay| !matches!(overlay, Overlay::Boundaries | Overlay::Velocity));
        let turned = globe.tend(
            &surface,
            surface.is_changed(),
            overlay,
            seconds,
            &mut images,
            &mut uploads,
        );
        let air = air.copied().unwrap_or_default();
        globe.show(view, &air, lighting, &mut materials);
        let sky = SkyUniform {
            air: air.uniform(surface.radius_km),
            extent: SKY,
        };
        if globe.air != Some(sky) {
            globe.air = Some(sky);
            let material = MeshMaterial3d(skies.add(SkyMaterial { uniform: sky }));
            if let Ok(mut part) = commands.get_entity(globe.sky) {
                part.try_insert(material);
            }
        }
        match (globe.drawn(), drawn) {
            (Some(now), Some(mut drawn)) => {
                drawn.set_if_neq(now);
            }
            (Some(now), None) => {
                commands.entity(entity).try_insert(now);
            }
            (None, _) => {}
        }
        let reach = globe.reach(view);
        for (part, scale, reach) in [(globe.body, 1.0, reach), (globe.sky, SKY, 1.0)] {
            let Ok((mut transform, mut visibility, mut bounds)) = parts.get_mut(part) else {
                continue;
            };
            transform.set_if_neq(Transform::from_scale(Vec3::splat(planet.radius * scale)));
            bounds.set_if_neq(Aabb::from_min_max(Vec3::splat(-reach), Vec3::splat(reach)));
            if turned {
                visibility.set_if_neq(Visibility::Inherited);
            }
        }
    }
}

/// Clears up after a planet that is none any more.
fn disappear(gone: On<Remove, Planet>, globes: Query<&Globe>, mut commands: Commands) {
    let Ok(globe) = globes.get(gone.entity) else {
        return;
    };
    for part in [globe.body, globe.sky] {
        if let Ok(mut part) = commands.get_entity(part) {
            part.try_despawn();
        }
    }
    if let Ok(mut planet) = commands.get_entity(gone.entity) {
        planet.try_remove::<(Globe, Drawn)>();
    }
}
