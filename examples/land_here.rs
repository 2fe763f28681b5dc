//! Click on a planet, fly down to where you clicked, and walk there.
//!
//! `cargo run --release --example land_here`
//!
//! In orbit arrow keys turn the planet. On the ground they walk, Shift runs, Space jumps, Escape goes back to orbit.

use bevy::{
    light::{CascadeShadowConfig, CascadeShadowConfigBuilder},
    math::DVec3,
    prelude::*,
    tasks::{AsyncComputeTaskPool, Task, futures::check_ready},
    window::PrimaryWindow,
};
use bevy_tectonics::{
    planet::to_scene,
    prelude::*,
    render::{PlanetTiles, Viewpoint},
    surface::{HeightField, Terrain, direction_of},
};
use libm::{cos, exp, exp2, log, log2, sin};

/// Radius of the planet in m, and of the world.
const RADIUS: f64 = 6.371e6;
/// Altitude of the orbit in m.
const ORBIT: f64 = 2.2 * RADIUS;
/// Height of the camera behind the walker, and its distance, in m.
const BEHIND: (f64, f64) = (2.6, 7.0);
/// Seconds that the flight takes.
const FLIGHT: f64 = 14.0;
/// Sides of the collider in km, samples along them, and how far from its middle another is made, in m.
const COLLIDER: (f64, usize, f64) = (0.4, 201, 80.0);
/// Gravity, m/s², and how fast the walker leaves the ground, walks and runs, m/s.
const GRAVITY: f64 = 9.81;
const JUMP: f64 = 5.0;
const STRIDE: f64 = 3.0;
const RUN: f64 = 40.0;

fn main() -> AppExit {
    App::new()
        .add_plugins((DefaultPlugins, TectonicsPlugins))
        .insert_resource(ClearColor(Color::BLACK))
        .init_resource::<Journey>()
        .init_resource::<Collider>()
        .add_systems(Startup, setup)
        .add_systems(
            Update,
            (land, leave, orbit, descend, collide, walk, look).chain(),
        )
        .run()
}

/// Where the traveller is.
#[derive(Resource, Clone, Copy, PartialEq)]
enum Journey {
    /// Above a latitude and a longitude, in degrees.
    Orbit { latitude: f64, longitude: f64 },
    /// On the way down from one direction to another, 0 to 1.
    Descent {
        from: DVec3,
        to: DVec3,
        progress: f64,
    },
    /// On the ground, `height` m above the sea.
    Ground {
        up: DVec3,
        heading: DVec3,
        height: f64,
        rise: f64,
    },
}

impl Default for Journey {
    fn default() -> Self {
        Self::Orbit {
            latitude: 20.0,
            longitude: 20.0,
        }
    }
}

/// Ground around the walker as a grid of heights, which a physics engine would take as it is.
#[derive(Resource, Default)]
struct Collider {
    field: Option<HeightField>,
    /// The next one, in the making.
    task: Option<Task<Option<HeightField>>>,
}

impl Collider {
    /// Elevation in m between four samples; none outside of the grid.
    fn elevation(&self, direction: DVec3) -> Option<f64> {
        let field = self.field.as_ref()?;
        let cosine = direction.dot(field.centre);
        if cosine <= 0.0 {
            return None;
        }
        // Where the line from the centre meets the plane of the grid.
        let at = direction * (field.radius_m / cosine);
        let half = 0.5 * field.size_m;
        let column = (at.dot(field.east) + half) / field.spacing_m();
        let row = (half - at.dot(field.north)) / field.spacing_m();
        if !(column >= 0.0 && row >= 0.0) {
            return None;
        }
        let (x, y) = (column as usize, row as usize);
        let height = |dx: usize, dy: usize| field.height(y + dy, x + dx).map(f64::from);
        let (s, t) = (column.fract(), row.fract());
        let top = height(0, 0)? * (1.0 - s) + height(1, 0)? * s;
        let bottom = height(0, 1)? * (1.0 - s) + height(1, 1)? * s;
        Some(top * (1.0 - t) + bottom * t)
    }
}

#[derive(Component)]
struct Walker;

fn setup(
    mut commands: Commands,
    mut meshes: ResMut<Assets<Mesh>>,
    mut materials: ResMut<Assets<StandardMaterial>>,
) {
    let recipe = Recipe::earth_like(206).with_duration(150.0);
    let planet = commands
        .spawn((
            Planet::new(recipe).with_radius(RADIUS as f32),
            PlanetView {
                exaggeration: 1.0,
                ..default()
            },
            PlanetTiles::default(),
        ))
        .id();
    let place_m = DVec3::X * (RADIUS + ORBIT);
    commands.spawn((Camera3d::default(), Viewpoint { planet, place_m }));
    commands.spawn(DirectionalLight {
        shadow_maps_enabled: true,
        ..default()
    });
    commands.spawn((
        Walker,
        Mesh3d(meshes.add(Capsule3d::new(0.35, 1.1))),
        MeshMaterial3d(materials.add(Color::srgb(0.85, 0.25, 0.10))),
        Visibility::Hidden,
    ));
}

/// How far shadows reach for a camera at an altitude in m above the ground.
fn cascades(altitude: f64) -> CascadeShadowConfig {
    // By steps of two, or shadows would shimmer all the way down.
    let altitude = exp2(log2(altitude.max(1.0)).floor()) as f32;
    CascadeShadowConfigBuilder {
        // Around the walker as finely as its own shadow wants.
        first_cascade_far_bound: (4.0 * altitude).max(40.0),
        // To the ranges on the horizon.
        maximum_distance: 60_000.0 + 20.0 * altitude,
        ..default()
    }
    .build()
}

/// A click in orbit begins the flight.
fn land(
    mut journey: ResMut<Journey>,
    buttons: Res<ButtonInput<MouseButton>>,
    windows: Query<&Window, With<PrimaryWindow>>,
    cameras: Query<(&Camera, &GlobalTransform)>,
    planets: Planets,
    names: Query<Entity, With<Planet>>,
) {
    let Journey::Orbit {
        latitude,
        longitude,
    } = *journey
    else {
        return;
    };
    if !buttons.just_pressed(MouseButton::Left) {
        return;
    }
    let (Ok(window), Ok((camera, transform)), Ok(planet)) =
        (windows.single(), cameras.single(), names.single())
    else {
        return;
    };
    let picked = window
        .cursor_position()
        .and_then(|cursor| camera.viewport_to_world(transform, cursor).ok())
        .and_then(|ray| planets.pick(ray))
        .and_then(|pick| planets.direction(planet, pick.point));
    if let Some(to) = picked {
        *journey = Journey::Descent {
            from: direction_of(latitude, longitude),
            to: bevy_tectonics::planet::from_scene(*to).normalize(),
            progress: 0.0,
        };
    }
}

fn leave(mut journey: ResMut<Journey>, keys: Res<ButtonInput<KeyCode>>) {
    if keys.just_pressed(KeyCode::Escape) {
        *journey = Journey::default();
    }
}

fn held(keys: &ButtonInput<KeyCode>, more: KeyCode, less: KeyCode) -> f64 {
    f64::from(i8::from(keys.pressed(more)) - i8::from(keys.pressed(less)))
}

fn orbit(mut journey: ResMut<Journey>, time: Res<Time>, keys: Res<ButtonInput<KeyCode>>) {
    if let Journey::Orbit {
        latitude,
        longitude,
    } = &mut *journey
    {
        let turn = 40.0 * time.delta_secs_f64();
        *longitude += turn * held(&keys, KeyCode::ArrowRight, KeyCode::ArrowLeft);
        *latitude += turn * held(&keys, KeyCode::ArrowUp, KeyCode::ArrowDown);
        *latitude = latitude.clamp(-75.0, 75.0);
    }
}

fn descend(
    mut journey: ResMut<Journey>,
    time: Res<Time>,
    surfaces: Query<&PlanetSurface>,
) -> Result {
    let Journey::Descent { from, to, progress } = &mut *journey else {
        return Ok(());
    };
    *progress += time.delta_secs_f64() / FLIGHT;
    if *progress >= 1.0 {
        let (from, up) = (*from, *to);
        let ground = match surfaces.single() {
            Ok(surface) => f64::from(surface.sample(up, 1.0)?.elevation).max(0.0),
            Err(_) => 0.0,
        };
        *journey = Journey::Ground {
            up,
            heading: (up - from)
                .reject_from(up)
                .normalize_or(up.any_orthonormal_vector()),
            height: ground,
            rise: 0.0,
        };
    }
    Ok(())
}

/// Has another collider made where the walker leaves the one at hand.
fn collide(journey: Res<Journey>, mut collider: ResMut<Collider>, surfaces: Query<&PlanetSurface>) {
    if let Some(task) = &mut collider.task
        && let Some(field) = check_ready(task)
    {
        collider.field = field;
        collider.task = None;
    }
    let place = match *journey {
        Journey::Descent { to, progress, .. } if progress > 0.5 => to,
        Journey::Ground { up, .. } => up,
        _ => return,
    };
    let (size_km, samples, margin_m) = COLLIDER;
    let is_near = |field: &HeightField| place.distance(field.centre) * field.radius_m < margin_m;
    if collider.task.is_some() || collider.field.as_ref().is_some_and(is_near) {
        return;
    }
    let Ok(surface) = surfaces.single() else {
        return;
    };
    let surface = surface.share();
    let spacing_m = 1000.0 * size_km / (samples - 1) as f64;
    collider.task = Some(AsyncComputeTaskPool::get().spawn(async move {
        let mut terrain = Terrain::new(&surface, spacing_m).ok()?;
        Some(terrain.patch(place, size_km, samples))
    }));
}

fn walk(
    mut journey: ResMut<Journey>,
    time: Res<Time>,
    keys: Res<ButtonInput<KeyCode>>,
    collider: Res<Collider>,
) {
    let Journey::Ground {
        up,
        heading,
        height,
        rise,
    } = &mut *journey
    else {
        return;
    };
    let seconds = time.delta_secs_f64().min(0.1);
    let turn = 1.6 * seconds * held(&keys, KeyCode::ArrowLeft, KeyCode::ArrowRight);
    let speed = if keys.pressed(KeyCode::ShiftLeft) {
        RUN
    } else {
        STRIDE
    };
    let step = speed * seconds * held(&keys, KeyCode::ArrowUp, KeyCode::ArrowDown);
    let ahead = (*up + *heading * (step / RADIUS)).normalize();
    let aside = ahead.cross(*heading);
    *heading = (*heading * cos(turn) + aside * sin(turn))
        .reject_from(ahead)
        .normalize_or(*heading);
    *up = ahead;
    // Nobody sinks: the sea carries.
    let ground = collider.elevation(*up).unwrap_or(*height).max(0.0);
    *rise -= GRAVITY * seconds;
    *height += *rise * seconds;
    if *height <= ground {
        *height = ground;
        *rise = if keys.pressed(KeyCode::Space) {
            JUMP
        } else {
            0.0
        };
    }
}

/// Puts the camera where the journey is: it stays at the origin, and the planet moves around it.
fn look(
    journey: Res<Journey>,
    collider: Res<Collider>,
    growth: Query<&Growth>,
    mut cameras: Query<(&mut Viewpoint, &mut Transform), With<Camera3d>>,
    mut planets: Query<&mut Transform, (With<Planet>, Without<Camera3d>)>,
    mut suns: Query<
        (&mut Transform, &mut CascadeShadowConfig),
        (Without<Planet>, Without<Camera3d>),
    >,
    mut walkers: Query<
        (&mut Transform, &mut Visibility),
        (
            With<Walker>,
            Without<CascadeShadowConfig>,
            Without<Planet>,
            Without<Camera3d>,
        ),
    >,
    mut windows: Query<&mut Window>,
) {
    let (place_m, forward, head, feet, altitude) = match *journey {
        Journey::Orbit {
            latitude,
            longitude,
        } => {
            let up = direction_of(latitude, longitude);
            (up * (RADIUS + ORBIT), -up, DVec3::Z, None, ORBIT)
        }
        Journey::Descent { from, to, progress } => {
            let eased = progress * progress * (3.0 - 2.0 * progress);
            let altitude = exp(log(ORBIT) + (log(BEHIND.0) - log(ORBIT)) * eased);
            let up = from.lerp(to, (3.0 * eased).min(1.0)).normalize_or(to);
            let ground = collider
                .elevation(to)
                .unwrap_or(3000.0 * (1.0 - eased))
                .max(0.0);
            let heading = (to - from)
                .reject_from(up)
                .normalize_or(up.any_orthonormal_vector());
            let level = ((eased - 0.75) / 0.25).clamp(0.0, 1.0);
            let forward = (-up).lerp(heading - 0.2 * up, level * level * (3.0 - 2.0 * level));
            let place = up * (RADIUS + ground + altitude);
            (
                place,
                forward.normalize(),
                DVec3::Z.lerp(heading, (4.0 * eased).min(1.0)),
                None,
                altitude,
            )
        }
        Journey::Ground {
            up,
            heading,
            height,
            ..
        } => {
            let feet = up * (RADIUS + height);
            let back = (up - heading * (BEHIND.1 / RADIUS)).normalize();
            let below = collider.elevation(back).unwrap_or(height).max(0.0) + 0.8;
            let place = back * (RADIUS + (height + BEHIND.0).max(below));
            let forward = (feet + up * 1.2 - place).normalize();
            (place, forward, up, Some(feet), BEHIND.0)
        }
    };
    for (mut viewpoint, mut transform) in &mut cameras {
        viewpoint.place_m = place_m;
        *transform = Transform::default().looking_to(to_scene(forward), to_scene(head));
    }
    for mut transform in &mut planets {
        transform.translation = -to_scene(place_m);
    }
    for (mut transform, mut shadows) in &mut suns {
        *shadows = cascades(altitude);
        // An eternal forenoon wherever the traveller is.
        let up = place_m.normalize();
        let sun = up * 0.6 + DVec3::Z.cross(up).normalize_or(up.any_orthonormal_vector());
        *transform = Transform::default().looking_to(-to_scene(sun), Vec3::Y);
    }
    for (mut transform, mut visibility) in &mut walkers {
        *visibility = if feet.is_some() {
            Visibility::Visible
        } else {
            Visibility::Hidden
        };
        if let Some(feet) = feet {
            let up = feet.normalize();
            transform.translation = to_scene(feet + up * 0.9 - place_m);
            transform.rotation = Quat::from_rotation_arc(Vec3::Y, to_scene(up));
        }
    }
    for mut window in &mut windows {
        let grows = growth
            .iter()
            .any(|growth| growth.state != GrowthState::Finished);
        let title = match *journey {
            _ if grows => "The planet grows".into(),
            Journey::Orbit { .. } => "Click to land; arrow keys turn".into(),
            Journey::Descent { .. } => "Down".into(),
            Journey::Ground { height, .. } => {
                format!("{height:.0} m: arrow keys, Shift, Space; Escape to orbit")
            }
        };
        if window.title != title {
            window.title = title;
        }
    }
}
