//! Houses that stand on the ground and travel with their plates, and a walker to visit them.
//!
//! `cargo run --release --example walk`
//!
//! Arrow keys walk, P lets the continents rest.

use bevy::math::DVec3;
use bevy::prelude::*;
use bevy_tectonics::{planet::to_scene, prelude::*};

/// Radius of the planet in units of the game's world.
const RADIUS: f32 = 10.0;
/// Houses to build.
const HOUSES: usize = 400;
/// Speed of the walker in radians a second.
const STRIDE: f32 = 0.12;

fn main() -> AppExit {
    App::new()
        .add_plugins((DefaultPlugins, TectonicsPlugins))
        .insert_resource(ClearColor(Color::BLACK))
        .add_systems(Startup, setup)
        .add_systems(Update, (pause, walk, stand, look).chain())
        .add_observer(build_houses)
        .add_observer(travel)
        .run()
}

/// Something on the ground of its parent, a planet, at a place given by a direction.
#[derive(Component)]
struct Ground {
    direction: Dir3,
    /// When the ground was there, in My.
    time_my: f64,
}

#[derive(Component)]
struct House;

#[derive(Component)]
struct Walker {
    heading: Vec3,
}

fn setup(mut commands: Commands) {
    let recipe = Recipe::earth_like(5).with_duration(1000.0);
    commands.spawn(
        Planet::new(recipe)
            .with_radius(RADIUS)
            .with_pace(Pace::MyPerSecond(4.0)),
    );
    // The sun comes along: the walker lives in an eternal morning.
    commands.spawn((
        Camera3d::default(),
        Transform::from_xyz(0.0, 0.0, 3.0 * RADIUS),
        children![(
            DirectionalLight::default(),
            Transform::from_xyz(-3.0, 3.0, 1.0).looking_at(Vec3::ZERO, Vec3::Y),
        )],
    ));
}

/// Builds houses along the coasts of a new planet, and sends a walker there.
fn build_houses(
    changed: On<SurfaceChanged>,
    surfaces: Query<&PlanetSurface>,
    mut commands: Commands,
    mut meshes: ResMut<Assets<Mesh>>,
    mut materials: ResMut<Assets<StandardMaterial>>,
) -> Result {
    if !changed.first {
        return Ok(());
    }
    let surface = surfaces.get(changed.entity)?;
    let coasts: Vec<DVec3> = surface
        .coasts()
        .map(|sub_plate| surface.mesh.site(sub_plate))
        .collect();
    let ground = |place: DVec3| {
        Some(Ground {
            direction: Dir3::new(to_scene(place)).ok()?,
            time_my: surface.time_my,
        })
    };
    let house = meshes.add(Cuboid::new(0.12, 0.14, 0.12));
    let walls = materials.add(Color::srgb(0.95, 0.90, 0.80));
    for place in coasts.iter().step_by((coasts.len() / HOUSES).max(1)) {
        if let Some(ground) = ground(*place) {
            commands.spawn((
                House,
                ground,
                ChildOf(changed.entity),
                Mesh3d(house.clone()),
                MeshMaterial3d(walls.clone()),
            ));
        }
    }
    if let Some(ground) = coasts.first().and_then(|place| ground(*place)) {
        commands.spawn((
            Walker {
                heading: ground.direction.any_orthonormal_vector(),
            },
            ground,
            ChildOf(changed.entity),
            Mesh3d(meshes.add(Capsule3d::new(0.08, 0.2))),
            MeshMaterial3d(materials.add(Color::srgb(0.85, 0.15, 0.10))),
        ));
    }
    Ok(())
}

/// What stands on the ground travels with it. A house that has drifted into the sea is given up.
fn travel(
    changed: On<SurfaceChanged>,
    planets: Planets,
    surfaces: Query<&PlanetSurface>,
    mut things: Query<(Entity, &mut Ground, &ChildOf, Has<House>)>,
    mut commands: Commands,
) -> Result {
    let now_my = surfaces.get(changed.entity)?.time_my;
    for (entity, mut ground, child_of, is_house) in &mut things {
        let planet = child_of.parent();
        if planet != changed.entity {
            continue;
        }
        let passed = now_my - ground.time_my;
        if let Some(there) = planets.drift(planet, ground.direction, passed) {
            ground.direction = there;
            ground.time_my = now_my;
        }
        let drowned = planets
            .place(planet, ground.direction)
            .is_some_and(|place| place.elevation < 0.0);
        if is_house && drowned {
            commands.entity(entity).despawn();
        }
    }
    Ok(())
}

fn pause(keys: Res<ButtonInput<KeyCode>>, mut planets: Query<&mut Planet>) {
    if keys.just_pressed(KeyCode::KeyP) {
        for mut planet in &mut planets {
            planet.paused = !planet.paused;
        }
    }
}

/// Steps along a great circle, wherever that leads.
fn walk(
    time: Res<Time>,
    keys: Res<ButtonInput<KeyCode>>,
    mut walkers: Query<(&mut Walker, &mut Ground)>,
) {
    let held = |key, amount| if keys.pressed(key) { amount } else { 0.0 };
    let ahead = held(KeyCode::ArrowUp, 1.0) - held(KeyCode::ArrowDown, 1.0);
    let turn = held(KeyCode::ArrowLeft, 1.0) - held(KeyCode::ArrowRight, 1.0);
    for (mut walker, mut ground) in &mut walkers {
        let up = *ground.direction;
        let heading = walker
            .heading
            .reject_from(up)
            .normalize_or(ground.direction.any_orthonormal_vector());
        walker.heading = Quat::from_axis_angle(up, 2.0 * turn * time.delta_secs()) * heading;
        let step = walker.heading * (ahead * STRIDE * time.delta_secs());
        if let Ok(direction) = Dir3::new(up + step) {
            ground.direction = direction;
        }
    }
}

/// Everything stands where the ground is now.
fn stand(planets: Planets, mut things: Query<(&Ground, &ChildOf, &mut Transform)>) {
    for (ground, child_of, mut transform) in &mut things {
        if let Some(pose) = planets.stand(child_of.parent(), ground.direction) {
            *transform = pose;
        }
    }
}

/// The camera follows the walker, from above and behind.
fn look(
    time: Res<Time>,
    walkers: Query<(&Walker, &Ground, &Transform)>,
    mut cameras: Query<&mut Transform, (With<Camera3d>, Without<Walker>)>,
) {
    let Ok((walker, ground, place)) = walkers.single() else {
        return;
    };
    let up = *ground.direction;
    let from = place.translation + 3.0 * up - 5.0 * walker.heading;
    // The planet lies at the origin of the world, so its space is the world's.
    let aim = Transform::from_translation(from).looking_at(place.translation, up);
    for mut camera in &mut cameras {
        let share = (3.0 * time.delta_secs()).min(1.0);
        camera.translation = camera.translation.lerp(aim.translation, share);
        camera.rotation = camera.rotation.slerp(aim.rotation, share);
    }
}
