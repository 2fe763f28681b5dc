//! The main job: a planet that grows on screen, with a control panel.
//!
//! `cargo run --release --features editor --example planet` (without the feature: keys alone)
//!
//! Where there is no display, the same history runs without one and writes maps.

use bevy::prelude::*;
use bevy_panorbit_camera::{PanOrbitCamera, PanOrbitCameraPlugin};
use bevy_tectonics::{
    export::{FILES, Maps, check_folder, write_planet},
    prelude::*,
};
use clap::Parser;
use core::ops::ControlFlow;
use indicatif::{ProgressBar, ProgressStyle};
use std::{path::PathBuf, process::ExitCode, time::Instant};

/// Grows a planet by plate tectonics, on screen where there is one.
#[derive(Parser)]
struct Arguments {
    /// Seed of the planet.
    #[arg(long, default_value_t = 42)]
    seed: u64,
    /// Number of sub-plates, 200 to 2,000,000.
    #[arg(long, default_value_t = 10_000)]
    sub_plates: u32,
    /// Length of the history in My, 0 to 10,000.
    #[arg(long, default_value_t = 1_000.0)]
    duration: f64,
    /// My in a second; 0 is as fast as possible.
    #[arg(long, default_value_t = 10.0)]
    pace: f64,
    /// Folder for the maps that are written where there is no display.
    #[arg(long, default_value = "target/planet")]
    out: PathBuf,
    /// Runs without a display even where there is one.
    #[arg(long)]
    headless: bool,
}

impl Arguments {
    fn recipe(&self) -> Recipe {
        Recipe::earth_like(self.seed)
            .with_sub_plates(self.sub_plates)
            .with_duration(self.duration)
    }
}

fn main() -> ExitCode {
    let arguments = Arguments::parse();
    if let Err(error) = arguments.recipe().validate() {
        eprintln!("error: {error}");
        return ExitCode::from(2);
    }
    if arguments.headless || !has_display() {
        return match without_display(&arguments) {
            Ok(()) => ExitCode::SUCCESS,
            Err(error) => {
                eprintln!("error: {error}");
                ExitCode::FAILURE
            }
        };
    }
    match on_screen(&arguments) {
        AppExit::Success => ExitCode::SUCCESS,
        AppExit::Error(code) => ExitCode::from(code.get()),
    }
}

/// Unix desktops tell by a variable; others always have a display.
fn has_display() -> bool {
    !cfg!(all(unix, not(target_os = "macos")))
        || std::env::var_os("DISPLAY").is_some_and(|display| !display.is_empty())
}

fn without_display(arguments: &Arguments) -> Result<(), BevyError> {
    println!(
        "no display: the history runs without one, and its maps go to {}",
        arguments.out.display()
    );
    check_folder(&arguments.out, FILES)?;
    let start = Instant::now();
    let mut history = History::new(arguments.recipe())?;
    let bar = ProgressBar::new(1000).with_style(ProgressStyle::with_template(
        "{wide_bar} {msg} {elapsed_precise}",
    )?);
    history.run_until(arguments.duration, |progress| {
        bar.set_position((1000.0 * progress.fraction) as u64);
        bar.set_message(format!("{:.0} My", progress.time_my));
        ControlFlow::Continue(())
    })?;
    bar.finish();
    let seconds = start.elapsed().as_secs_f64();
    for file in write_planet(&mut history, seconds, &arguments.out, &Maps::new(2048))? {
        println!("{}", file.display());
    }
    Ok(())
}

fn on_screen(arguments: &Arguments) -> AppExit {
    let mut app = App::new();
    app.add_plugins((
        DefaultPlugins.set(WindowPlugin {
            primary_window: Some(Window {
                title: "bevy_tectonics".into(),
                resolution: (1600, 900).into(),
                ..default()
            }),
            ..default()
        }),
        TectonicsPlugins,
        PanOrbitCameraPlugin,
    ));
    app.add_systems(Update, keys.in_set(Keys));
    #[cfg(feature = "editor")]
    {
        use bevy_panorbit_camera::PanOrbitCameraSystemSet;
        use bevy_tectonics::editor::{
            EditorPlugin, egui_wants_any_keyboard_input, egui_wants_any_pointer_input,
        };
        // What is typed or dragged in the panel is not for the game.
        app.add_plugins(EditorPlugin)
            .configure_sets(
                PostUpdate,
                PanOrbitCameraSystemSet.run_if(not(egui_wants_any_pointer_input)),
            )
            .configure_sets(Update, Keys.run_if(not(egui_wants_any_keyboard_input)));
    }
    #[cfg(not(feature = "editor"))]
    info!("`--features editor` adds the control panel");
    info!(
        "keys: P pause, S step, N another planet, 1 to 7 overlays, 0 none, B boundaries, V velocities"
    );
    let planet = Planet::new(arguments.recipe()).with_pace(if arguments.pace > 0.0 {
        Pace::MyPerSecond(arguments.pace)
    } else {
        Pace::Fastest
    });
    app.insert_resource(ClearColor(Color::srgb(0.005, 0.006, 0.012)))
        .add_systems(Startup, move |mut commands: Commands| {
            commands.spawn((Name::new("Planet"), planet.clone()));
            commands.spawn((
                PanOrbitCamera {
                    zoom_lower_limit: 1.2,
                    zoom_upper_limit: Some(20.0),
                    ..default()
                },
                Transform::from_xyz(0.0, 0.9, 2.7),
            ));
            commands.spawn((
                DirectionalLight::default(),
                Transform::from_xyz(-2.0, 1.5, 3.0).looking_at(Vec3::ZERO, Vec3::Y),
            ));
        })
        .add_observer(|failed: On<GrowthFailed>| error!("{}", failed.failure))
        .run()
}

/// What listens to the keyboard.
#[derive(SystemSet, Debug, Clone, PartialEq, Eq, Hash)]
struct Keys;

fn keys(keys: Res<ButtonInput<KeyCode>>, mut planets: Query<(&mut Planet, &mut PlanetView)>) {
    const OVERLAYS: [(KeyCode, Option<Overlay>); 8] = [
        (KeyCode::Digit0, None),
        (KeyCode::Digit1, Some(Overlay::Plates)),
        (KeyCode::Digit2, Some(Overlay::Crust)),
        (KeyCode::Digit3, Some(Overlay::Age)),
        (KeyCode::Digit4, Some(Overlay::Thickness)),
        (KeyCode::Digit5, Some(Overlay::Speed)),
        (KeyCode::Digit6, Some(Overlay::Elevation)),
        (KeyCode::Digit7, Some(Overlay::Orogeny)),
    ];
    for (mut planet, mut view) in &mut planets {
        for (key, overlay) in OVERLAYS {
            if keys.just_pressed(key) {
                view.overlay = overlay;
            }
        }
        if keys.just_pressed(KeyCode::KeyB) {
            view.boundaries = !view.boundaries;
        }
        if keys.just_pressed(KeyCode::KeyV) {
            view.velocities = !view.velocities;
        }
        if keys.just_pressed(KeyCode::KeyP) {
            planet.paused = !planet.paused;
        }
        if keys.just_pressed(KeyCode::KeyS) {
            planet.step();
        }
        if keys.just_pressed(KeyCode::KeyN) {
            planet.recipe.seed = planet.recipe.seed.wrapping_add(1);
        }
    }
}
