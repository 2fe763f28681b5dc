//! 500 My in a minute: continents drift, collide and part in the light of many days at once.
//!
//! `cargo run --release --example time_lapse`
//!
//! Drag to turn, scroll to come closer; the planet goes on to its end. `-- --record frames` writes numbered pictures in
//! place of opening a window, each of the whole surface of its time.

#[expect(dead_code, reason = "each uses a part of it")]
#[path = "../tests/studio/mod.rs"]
mod studio;

use bevy::prelude::*;
use bevy_panorbit_camera::{PanOrbitCamera, PanOrbitCameraPlugin};
use bevy_tectonics::{
    prelude::*,
    render::{MeanSun, Stars},
};
use clap::Parser;
use indicatif::ProgressBar;
use std::{fs, path::Path, path::PathBuf, process::ExitCode};
use studio::{Pose, Studio};

#[derive(Parser, Resource, Clone)]
struct Arguments {
    /// Seed of the planet.
    #[arg(long, default_value_t = 8)]
    seed: u64,
    /// Number of sub-plates, 200 to 2,000,000.
    #[arg(long, default_value_t = 10_000)]
    sub_plates: u32,
    /// Length of the history in My.
    #[arg(long, default_value_t = 500.0)]
    duration: f64,
    /// Length of the time lapse in s.
    #[arg(long, default_value_t = 60.0)]
    seconds: f64,
    /// How far the camera goes around the planet meanwhile, in degrees.
    #[arg(long, default_value_t = 180.0, allow_hyphen_values = true)]
    turn: f64,
    /// Pictures a second where they are written.
    #[arg(long, default_value_t = 10.0)]
    rate: f64,
    /// Width of the pictures in pixels.
    #[arg(long, default_value_t = 1280)]
    width: u32,
    /// Height of the pictures in pixels.
    #[arg(long, default_value_t = 720)]
    height: u32,
    /// A folder for numbered pictures.
    #[arg(long)]
    record: Option<PathBuf>,
}

impl Arguments {
    fn seconds(&self) -> f64 {
        self.seconds.clamp(1.0, 1e5)
    }

    /// The planet as it is at the start.
    fn planet(&self) -> Planet {
        let recipe = Recipe::earth_like(self.seed)
            .with_sub_plates(self.sub_plates)
            .with_duration(self.duration);
        Planet::new(recipe)
    }
}

fn main() -> ExitCode {
    let arguments = Arguments::parse();
    if let Err(error) = arguments.planet().recipe.validate() {
        eprintln!("error: {error}");
        return ExitCode::from(2);
    }
    if let Some(folder) = &arguments.record {
        return match record(&arguments, folder) {
            Ok(()) => ExitCode::SUCCESS,
            Err(error) => {
                eprintln!("error: {error}");
                ExitCode::FAILURE
            }
        };
    }
    App::new()
        .add_plugins((DefaultPlugins, TectonicsPlugins, PanOrbitCameraPlugin))
        .insert_resource(arguments)
        .insert_resource(ClearColor(Color::BLACK))
        .add_systems(Startup, setup)
        .add_systems(Update, (go_around, tell))
        .add_observer(|failed: On<GrowthFailed>| error!("{}", failed.failure))
        .run();
    ExitCode::SUCCESS
}

fn setup(mut commands: Commands, arguments: Res<Arguments>) {
    let pace = Pace::MyPerSecond(arguments.duration / arguments.seconds());
    commands.spawn(arguments.planet().with_pace(pace));
    commands.spawn(MeanSun::default());
    commands.spawn((
        PanOrbitCamera {
            radius: Some(3.0),
            zoom_lower_limit: 1.2,
            zoom_upper_limit: Some(20.0),
            ..default()
        },
        Transform::from_xyz(0.0, 0.8, 2.9),
        Stars::default(),
    ));
}

/// The camera goes around the planet, unless someone holds it.
fn go_around(
    time: Res<Time>,
    arguments: Res<Arguments>,
    buttons: Res<ButtonInput<MouseButton>>,
    mut cameras: Query<&mut PanOrbitCamera>,
) {
    if buttons.get_pressed().next().is_some() {
        return;
    }
    let turn = (arguments.turn / arguments.seconds()).to_radians() as f32;
    for mut camera in &mut cameras {
        camera.target_yaw += turn * time.delta_secs();
    }
}

/// Shows the time in the title of the window.
fn tell(growth: Query<&Growth, Changed<Growth>>, mut windows: Query<&mut Window>) {
    for growth in &growth {
        for mut window in &mut windows {
            window.title = format!("{:.0} My", growth.progress.time_my);
        }
    }
}

/// Writes pictures, each when its time has come and all of it is drawn.
fn record(arguments: &Arguments, folder: &Path) -> Result<(), String> {
    let problem =
        |error: &dyn core::fmt::Display, path: &Path| format!("{}: {error}", path.display());
    fs::create_dir_all(folder).map_err(|error| problem(&error, folder))?;
    let size = |side: u32| side.clamp(16, 8192);
    let mut studio = Studio::new(
        size(arguments.width),
        size(arguments.height),
        arguments.planet().with_end(0.0),
    )
    .ok_or("there is no graphics adapter to draw with")?;
    studio.dress((), Stars::default());
    studio.shine(MeanSun::default());
    let frames = (arguments.seconds() * arguments.rate).clamp(2.0, 1e6) as u32;
    let bar = ProgressBar::new(u64::from(frames));
    for frame in 0..frames {
        let share = f64::from(frame) / f64::from(frames - 1);
        studio.run_to(share * arguments.duration);
        studio.pose(Pose {
            longitude: -arguments.turn * share,
            ..Pose::default()
        });
        let path = folder.join(format!("{frame:05}.png"));
        studio
            .shoot()?
            .save(&path)
            .map_err(|error| problem(&error, &path))?;
        bar.inc(1);
    }
    bar.finish();
    println!("{frames} pictures in {}", folder.display());
    Ok(())
}
