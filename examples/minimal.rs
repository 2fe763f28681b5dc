//! A planet that grows on screen: `cargo run --release --example minimal`

use bevy::prelude::*;
use bevy_tectonics::prelude::*;

fn main() -> AppExit {
    App::new()
        .add_plugins((DefaultPlugins, TectonicsPlugins))
        .add_systems(Startup, |mut commands: Commands| {
            commands.spawn(Planet::new(Recipe::earth_like(42)));
            commands.spawn((Camera3d::default(), Transform::from_xyz(0.0, 0.0, 3.0)));
            let sun = Transform::from_xyz(-2.0, 1.5, 3.0).looking_at(Vec3::ZERO, Vec3::Y);
            commands.spawn((DirectionalLight::default(), sun));
        })
        .run()
}
