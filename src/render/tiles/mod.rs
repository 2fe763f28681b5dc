//! Ground up close: tiles of terrain, finer where a camera is near, from orbit down to where a player stands.
//!
//! From afar a planet is one sphere with cube maps. As a camera comes closer than a radius, tiles take over: squares
//! of 64 × 64 quads on the faces of a cube, split into four where they are near ([`choice`]). They are made on
//! background tasks ([`tile`]). Towards the distance at which a parent takes its place, each vertex glides to
//! where the parent's flat triangles are, so it does not pop; walls along the rims hide cracks.
//!
//! Vertices are relative to the origin of their tile, and tiles are placed relative to the camera in double
//! precision: see [`Viewpoint`].

mod address;
mod choice;
mod forest;
mod tile;

use super::globe::{Close, Globe};
use crate::{
    planet::{Planet, PlanetSurface, PlanetView},
    surface::cube,
};
use bevy::{
    asset::AssetEventSystems,
    camera::{primitives::Aabb, visibility::VisibilitySystems},
    light::NotShadowCaster,
    math::{DQuat, DVec3},
    mesh::MeshTag,
    prelude::*,
    time::Real,
    transform::{TransformSystems, helper::TransformHelper},
};
use forest::{Forest, Scene};
use std::sync::Arc;
pub(super) use tile::{HEIGHTS, SLOPES, UP};

/// Draws a planet's ground in detail where a camera is near: put it on a [`Planet`].
///
/// Heights are drawn as [`PlanetView::exaggeration`] says; only 1 is true to scale. While a history goes on, the
/// planet is drawn without tiles; they come back when it rests.
///
/// ```
/// use bevy::prelude::*;
/// use bevy_tectonics::{prelude::*, render::PlanetTiles};
///
/// fn setup(mut commands: Commands) {
///     commands.spawn((
///         Planet::new(Recipe::earth_like(7)).with_radius(6.371e6),
///         PlanetView { exaggeration: 1.0, ..default() },
///         PlanetTiles::default(),
///     ));
/// }
/// ```
///
/// # Shadows
///
/// Mountains shadow valleys as soon as a sun has [`DirectionalLight::shadow_maps_enabled`]. How far and how finely
/// says its [`CascadeShadowConfig`](bevy::light::CascadeShadowConfig), in units of the world. Bevy's default ends
/// after 150 units; over ground to scale, shadows have to reach as far as mountains are seen:
///
/// ```
/// use bevy::{light::CascadeShadowConfigBuilder, prelude::*};
///
/// /// A sun for a camera so many m above the ground, in a world of metres.
/// fn sun(height_m: f32) -> impl Bundle {
///     let cascades = CascadeShadowConfigBuilder {
///         // What is seen nearest below the camera, a few times as far as the ground.
///         first_cascade_far_bound: (4.0 * height_m).max(150.0),
///         // To the mountains on the horizon.
///         maximum_distance: 60_000.0 + 20.0 * height_m,
///         ..default()
///     };
///     let light = DirectionalLight { shadow_maps_enabled: true, ..default() };
///     (light, cascades.build())
/// }
/// # let _ = sun(2.0);
/// ```
///
/// Where a camera comes down from orbit, set the cascades anew as it does, by steps of two: `examples/flyover/main.rs`.
/// Bevy's biases suit ground to scale. In a smaller world, `shadow_depth_bias`, 0.02 units, may be kilometres: set it
/// to 0. Cascades are whole units wide, so shadows on a planet of radius 1 are coarser than its mountains; give it a
/// radius of 1,000 at least. Where several cameras look, shadows have the shapes of tiles that one of them sees: the
/// nearest, or one with a [`Viewpoint`]. Ground that is no steeper than the beams of every such sun is left out
/// of shadow maps, those of lamps included.
#[derive(Component, Debug, Clone, Copy, PartialEq, Reflect)]
#[reflect(Component, Default)]
#[require(Tiling, TilesDrawn)]
pub struct PlanetTiles {
    /// How many times its own length a tile is away when it is drawn as a whole, 2.6 to 10. Twice as much has
    /// four times as many triangles. At 2.6, quads of 4 to 8 pixels fill a picture 1080 pixels high.
    pub reach: f32,
    /// Length of the finest quads in m, at least 1.
    pub finest_m: f32,
    /// Tiles that enter the scene in one frame at most.
    pub per_frame: u32,
    /// Tiles that are kept, unless more are needed: up to 1,500 are, close to the ground. Each takes 0.3 MB of the
    /// GPU's memory.
    pub kept: u32,
}

impl Default for PlanetTiles {
    fn default() -> Self {
        Self {
            reach: 2.6,
            finest_m: 1.0,
            per_frame: 24,
            kept: 1600,
        }
    }
}

/// Where a camera is, more finely than its `Transform` can say: put it on the camera.
///
/// A `Transform` counts in 32 bits, which on a planet like Earth are steps of half a metre. With a viewpoint, tiles
/// are placed around the camera as if it were exactly there; the rotation of planet and camera still come from
/// their transforms. Keep the camera near the origin of its world and move the planet around it, as games with a
/// floating origin do.
///
/// Without one, tiles go by the transforms alone, which is enough for planets of the size of a toy seen from
/// above.
#[derive(Component, Debug, Clone, Copy, PartialEq, Reflect)]
#[reflect(Component)]
pub struct Viewpoint {
    /// The planet.
    pub planet: Entity,
    /// From the planet's centre to the camera, in m, in the frame of queries: north is +Z.
    pub place_m: DVec3,
}

/// What of a planet's tiles is on the screen. Written by the renderer alone, on planets with [`PlanetTiles`].
#[derive(Component, Debug, Clone, Copy, Default, PartialEq, Reflect)]
#[reflect(Component, Default)]
pub struct TilesDrawn {
    /// Tiles that are drawn now.
    pub drawn: u32,
    /// Triangles of the ground that are drawn now, before what lies beside the picture is left out.
    pub triangles: u32,
    /// Tiles in memory.
    pub kept: u32,
    /// Tiles that would be drawn if they were there.
    pub missing: u32,
    /// Those of them in the direction of a camera.
    pub missing_in_view: u32,
    /// Longest time in s that one of these has been missing.
    pub late_s: f32,
    /// Tiles made since the planet's tiles appeared.
    pub made: u32,
    /// Share of the picture's pixels that tiles have taken over from the sphere.
    pub share: f32,
}

/// Altitudes in radii at which tiles take over from the sphere, and beyond which there are none.
const TAKE_OVER: (f64, f64) = (0.8, 1.1);
const FORGET: f64 = 1.6;
/// Seconds for which a surface has to stay the same before tiles are made of it.
const REST_S: f32 = 1.0;
/// Bit of a tile's tag that says that it is sea. Mirrored in `lift.wgsl`.
const SEA: u32 = 1 << 31;

pub(super) fn plugin(app: &mut App) {
    app.register_type::<PlanetTiles>()
        .register_type::<Viewpoint>()
        .register_type::<TilesDrawn>()
        .add_observer(stop)
        .add_observer(disappear)
        .add_systems(
            PostUpdate,
            (
                (look, tend)
                    .chain()
                    .after(super::appear)
                    .before(super::tend),
                place.after(super::tend),
            )
                .in_set(super::PlanetRenderSystems::Tend)
                .before(TransformSystems::Propagate)
                .before(VisibilitySystems::VisibilityPropagate)
                .before(VisibilitySystems::CheckVisibility)
                .before(AssetEventSystems),
        );
}

/// The tiles of a planet, beside its [`PlanetTiles`].
#[derive(Component, Default)]
pub(super) struct Tiling {
    outlook: Option<Outlook>,
    forest: Option<Forest>,
    /// Seconds since the surface last changed.
    rest: f32,
}

/// The planet and the cameras of this frame.
struct Outlook {
    /// Where cameras are and look, in the space of the planet's `Transform`, in radii.
    places: Vec<DVec3>,
    gazes: Vec<DVec3>,
    /// The camera around which tiles are placed: in the world, and in the planet's space.
    anchor: (Vec3, DVec3),
    rotation: DQuat,
    /// Radius in the world.
    radius: f32,
}

impl Outlook {
    /// Distance of the nearest camera from the sphere, in radii.
    fn altitude(&self) -> f64 {
        let altitudes = self.places.iter().map(|place| place.length() - 1.0);
        altitudes.fold(f64::INFINITY, f64::min)
    }

    /// Where a tile with this origin is drawn.
    fn transform(&self, origin: DVec3) -> Transform {
        let (world, eye) = self.anchor;
        let offset = self.rotation * ((origin - eye) * f64::from(self.radius));
        Transform {
            translation: (world.as_dvec3() + offset).as_vec3(),
            rotation: self.rotation.as_quat(),
            scale: Vec3::splat(self.radius),
        }
    }
}

/// Finds out where the cameras are.
fn look(
    transforms: TransformHelper,
    cameras: Query<(Entity, &Camera, Option<&Viewpoint>), With<Camera3d>>,
    mut planets: Query<(Entity, &Planet, &PlanetSurface, &mut Tiling)>,
) {
    for (entity, planet, surface, mut tiling) in &mut planets {
        tiling.outlook = None;
        let Ok(to_world) = transforms.compute_global_transform(entity) else {
            continue;
        };
        let (scale, rotation, centre) = to_world.to_scale_rotation_translation();
        let radius = planet.radius * scale.x;
        if !(radius > 0.0 && radius.is_finite() && centre.is_finite()) {
            continue;
        }
        let rotation = rotation.as_dquat().normalize();
        let to_planet = rotation.inverse();
        let mut outlook = Outlook {
            places: Vec::new(),
            gazes: Vec::new(),
            anchor: default(),
            rotation,
            radius,
        };
        let mut exact = false;
        for (camera, settings, viewpoint) in &cameras {
            let Ok(seen_from) = transforms.compute_global_transform(camera) else {
                continue;
            };
            let place = match viewpoint.filter(|viewpoint| viewpoint.planet == entity) {
                Some(viewpoint) => {
                    cube::from_simulation(viewpoint.place_m / (1000.0 * surface.radius_km))
                }
                None => {
                    let offset = seen_from.translation().as_dvec3() - centre.as_dvec3();
                    to_planet * offset / f64::from(radius)
                }
            };
            if !settings.is_active || !place.is_finite() || place.length() < 0.5 {
                continue;
            }
            let is_exact = viewpoint.is_some_and(|viewpoint| viewpoint.planet == entity);
            let is_nearest = outlook
                .places
                .iter()
                .all(|other| place.length() < other.length());
            if is_exact && !exact || is_exact == exact && is_nearest {
                outlook.anchor = (seen_from.translation(), place);
                exact = is_exact;
            }
            outlook.places.push(place);
            outlook
                .gazes
                .push(to_planet * seen_from.forward().as_dvec3());
        }
        if !outlook.places.is_empty() {
            tiling.outlook = Some(outlook);
        }
    }
}

type Tended = (
    Ref<'static, PlanetSurface>,
    &'static PlanetView,
    &'static PlanetTiles,
    &'static mut Globe,
    &'static mut Tiling,
    &'static mut TilesDrawn,
);

/// Decides which tiles are drawn, and has the missing ones made.
fn tend(
    mut commands: Commands,
    time: Option<Res<Time<Real>>>,
    mut meshes: ResMut<Assets<Mesh>>,
    mut planets: Query<Tended, With<Planet>>,
) {
    let seconds = time.map_or(0.0, |time| time.delta_secs());
    for (surface, view, tiles, mut globe, mut tiling, mut drawn) in &mut planets {
        let globe = globe.bypass_change_detection();
        let tiling = &mut *tiling;
        tiling.rest += seconds;
        if surface.is_changed() {
            tiling.rest = 0.0;
        }
        let Some(outlook) = &tiling.outlook else {
            // Nobody looks.
            if let Some(forest) = tiling.forest.take() {
                forest.fell(&mut commands);
            }
            globe.close = Close::default();
            drawn.set_if_neq(TilesDrawn::default());
            continue;
        };
        let altitude = outlook.altitude();
        let newest = surface.share();
        let is_old = |forest: &Forest| !Arc::ptr_eq(&forest.surface, &newest);
        let is_over = tiling
            .forest
            .as_ref()
            .is_some_and(|forest| forest.share == 0.0 && (is_old(forest) || altitude > FORGET));
        if is_over && let Some(forest) = tiling.forest.take() {
            forest.fell(&mut commands);
        }
        let rests = tiling.rest >= REST_S && globe.drawn().is_some_and(|drawn| drawn.settled);
        if tiling.forest.is_none() && rests && altitude < FORGET {
            tiling.forest = Some(Forest::new(newest.clone()));
        }
        let Some(forest) = &mut tiling.forest else {
            globe.close = Close::default();
            drawn.set_if_neq(TilesDrawn::default());
            continue;
        };
        let wanted = if is_old(forest) || !rests {
            0.0
        } else {
            let (near, far) = TAKE_OVER;
            ((far - altitude) / (far - near)).clamp(0.0, 1.0) as f32
        };
        let scene = Scene {
            outlook,
            view,
            tiles,
            material: &globe.material,
        };
        let now = forest.tend(&scene, wanted, seconds, &mut meshes, &mut commands);
        globe.close = Close {
            share: forest.share,
            reach: scene.reach() as f32,
            eye: outlook.anchor.0,
        };
        drawn.set_if_neq(now);
    }
}

/// Puts tiles where the camera wants them, and hides what they replace.
fn place(
    planets: Query<(&Globe, &Tiling, Option<&InheritedVisibility>)>,
    suns: Query<(&DirectionalLight, &GlobalTransform)>,
    mut parts: Query<(
        &mut Transform,
        &mut Visibility,
        Option<(&mut MeshTag, &mut Aabb, Has<NotShadowCaster>)>,
    )>,
    mut commands: Commands,
) {
    let suns = suns.iter().filter(|(sun, _)| sun.shadow_maps_enabled);
    let suns: Vec<DVec3> = suns.map(|(_, at)| at.back().as_dvec3()).collect();
    for (globe, tiling, visible) in &planets {
        if globe.drawn().is_some()
            && let Ok((_, mut visibility, _)) = parts.get_mut(globe.body)
        {
            visibility.set_if_neq(if globe.close.share < 1.0 {
                Visibility::Inherited
            } else {
                Visibility::Hidden
            });
        }
        let (Some(outlook), Some(forest)) = (&tiling.outlook, &tiling.forest) else {
            continue;
        };
        let to_planet = outlook.rotation.inverse();
        let suns: Vec<DVec3> = suns.iter().map(|&sun| to_planet * sun).collect();
        let is_seen = forest.share > 0.0 && visible.is_none_or(|visible| visible.get());
        for (&address, node) in &forest.nodes {
            let is_drawn = is_seen && node.frame == forest.frame;
            let [ground, sea] = node.extent.shows;
            for (part, shows, flag) in [(node.ground, ground, 0), (node.sea, sea, SEA)] {
                let Some(part) = part else {
                    continue;
                };
                let Ok((mut transform, mut visibility, rest)) = parts.get_mut(part) else {
                    continue;
                };
                if !(is_drawn && shows) {
                    visibility.set_if_neq(Visibility::Hidden);
                    continue;
                }
                visibility.set_if_neq(Visibility::Visible);
                transform.set_if_neq(outlook.transform(node.extent.origin));
                let Some((mut tag, mut bounds, is_spared)) = rest else {
                    continue;
                };
                tag.set_if_neq(MeshTag(node.tag(address) | flag));
                bounds.set_if_neq(node.extent.drawn);
                // Shadow maps hold what looks away from the sun alone: most ground does not, most of the day.
                let has_shade = |sun: &DVec3| node.extent.has_shade(address, *sun);
                if flag == 0 && !suns.is_empty() && suns.iter().any(has_shade) == is_spared {
                    let mut part = commands.entity(part);
                    if is_spared {
                        part.try_remove::<NotShadowCaster>();
                    } else {
                        part.try_insert(NotShadowCaster);
                    }
                }
            }
        }
    }
}

/// Clears up after a planet that has no tiles any more.
fn stop(
    gone: On<Remove, PlanetTiles>,
    mut planets: Query<(&mut Tiling, Option<&mut Globe>)>,
    mut commands: Commands,
) {
    if let Ok((mut tiling, globe)) = planets.get_mut(gone.entity) {
        if let Some(forest) = tiling.forest.take() {
            forest.fell(&mut commands);
        }
        if let Some(mut globe) = globe {
            globe.close = Close::default();
            if globe.drawn().is_some()
                && let Ok(mut body) = commands.get_entity(globe.body)
            {
                body.try_insert(Visibility::Inherited);
            }
        }
        if let Ok(mut planet) = commands.get_entity(gone.entity) {
            planet.try_remove::<(Tiling, TilesDrawn)>();
        }
    }
}

/// Clears up after a planet that is none any more.
fn disappear(gone: On<Remove, Planet>, mut planets: Query<&mut Tiling>, mut commands: Commands) {
    if let Ok(mut tiling) = planets.get_mut(gone.entity)
        && let Some(forest) = tiling.forest.take()
    {
        forest.fell(&mut commands);
    }
}
