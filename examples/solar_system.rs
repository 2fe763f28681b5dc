//! Three planets that grow at once, each around the same sun and each in its own way.
//!
//! `cargo run --release --example solar_system`

use bevy::prelude::*;
use bevy_panorbit_camera::{PanOrbitCamera, PanOrbitCameraPlugin};
use bevy_tectonics::{
    prelude::*,
    simulation::{Drive, Start},
};

fn main() -> AppExit {
    App::new()
        .add_plugins((DefaultPlugins, TectonicsPlugins, PanOrbitCameraPlugin))
        .insert_resource(ClearColor(Color::BLACK))
        .add_systems(Startup, setup)
        .add_systems(Update, revolve)
        .add_observer(announce)
        .run()
}

/// A circular orbit around the origin.
#[derive(Component)]
struct Orbit {
    /// In units of the game's world.
    distance: f32,
    /// Radians a second.
    speed: f32,
    /// Where it begins, radians.
    phase: f32,
    /// Tilt of the planet's axis, radians.
    tilt: f32,
}

fn setup(
    mut commands: Commands,
    mut meshes: ResMut<Assets<Mesh>>,
    mut materials: ResMut<Assets<StandardMaterial>>,
) {
    commands.spawn((
        PanOrbitCamera::default(),
        Transform::from_xyz(0.0, 7.0, 15.0),
    ));
    commands.spawn((
        Name::new("Sun"),
        Mesh3d(meshes.add(Sphere::new(0.8).mesh().ico(5).unwrap())),
        MeshMaterial3d(materials.add(StandardMaterial {
            emissive: LinearRgba::rgb(9.0, 6.5, 3.0),
            ..default()
        })),
        PointLight {
            intensity: 12_000_000.0,
            range: 100.0,
            ..default()
        },
    ));
    let earth = Recipe::earth_like(11);
    let planets = [
        (
            "Aqua",
            Recipe {
                seed: 3,
                radius_km: 5_200.0,
                land_share: 0.12,
                continental_share: 0.22,
                ..earth.clone()
            },
            Orbit {
                distance: 3.2,
                speed: 0.16,
                phase: 0.4,
                tilt: 0.1,
            },
        ),
        (
            "Terra",
            earth.clone(),
            Orbit {
                distance: 5.8,
                speed: 0.10,
                phase: 1.9,
                tilt: 0.41,
            },
        ),
        (
            "Rigida",
            Recipe {
                seed: 29,
                radius_km: 8_800.0,
                land_share: 0.45,
                continental_share: 0.55,
                start: Start::Voronoi,
                drive: Drive::Rigid,
                ..earth
            },
            Orbit {
                distance: 9.0,
                speed: 0.06,
                phase: 5.2,
                tilt: 0.25,
            },
        ),
    ];
    for (name, recipe, orbit) in planets {
        let radius = recipe.radius_km as f32 / 6_371.0;
        let planet = Planet::new(recipe)
            .with_radius(radius)
            .with_pace(Pace::MyPerSecond(10.0));
        commands.spawn((Name::new(name), planet, orbit));
    }
}

/// Planets go around the sun and turn about their axes; their surfaces follow their transforms.
fn revolve(time: Res<Time>, mut planets: Query<(&Orbit, &mut Transform)>) {
    for (orbit, mut transform) in &mut planets {
        let angle = orbit.phase + orbit.speed * time.elapsed_secs();
        transform.translation = Quat::from_rotation_y(angle) * (Vec3::X * orbit.distance);
        transform.rotation =
            Quat::from_rotation_z(orbit.tilt) * Quat::from_rotation_y(0.2 * time.elapsed_secs());
    }
}

fn announce(grown: On<GrowthFinished>, names: Query<&Name>) {
    if let Ok(name) = names.get(grown.entity) {
        info!("{name} has grown for {:.0} My", grown.time_my);
    }
}
