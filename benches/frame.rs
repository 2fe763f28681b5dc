//! What a growing planet costs the frames of a game: `cargo bench --bench frame`
//!
//! Prints how long the main schedule takes, without a planet, with one that grows, and while another
//! recipe replaces it. `-- --sub-plates N --frames N --rate HZ` change the defaults, and
//! `-- --rendering` draws the planet off screen as well.

use bevy::prelude::*;
use bevy_tectonics::prelude::*;
use clap::Parser;
use core::time::Duration;
use std::time::Instant;

#[derive(Parser, Clone)]
struct Arguments {
    /// Sub-plates of the planet.
    #[arg(long, default_value_t = 40_000)]
    sub_plates: u32,
    /// Frames of each phase.
    #[arg(long, default_value_t = 1200)]
    frames: usize,
    /// Frames a second.
    #[arg(long, default_value_t = 60.0)]
    rate: f64,
    /// Draws the planet off screen, 1280 × 720.
    #[arg(long)]
    rendering: bool,
    /// Given by cargo.
    #[arg(long, hide = true)]
    bench: bool,
}

fn main() {
    let arguments = Arguments::parse();
    println!(
        "| frames of the main schedule, ms | median | mean | 95 % | 99 % | 99.9 % | worst |\n|---|--:|--:|--:|--:|--:|--:|"
    );
    let mut app = game(&arguments);
    // Pipelines are compiled and pools are warm.
    run(&mut app, &arguments, 60);
    print("no planet", run(&mut app, &arguments, arguments.frames));

    let recipe = |seed| {
        Recipe::earth_like(seed)
            .with_sub_plates(arguments.sub_plates)
            .with_duration(10_000.0)
    };
    let planet = app
        .world_mut()
        .spawn(Planet::new(recipe(1)).with_regrowth(Regrowth::Shown))
        .id();
    run(&mut app, &arguments, 60);
    print(
        &format!("{} sub-plates growing", arguments.sub_plates),
        run(&mut app, &arguments, arguments.frames),
    );

    app.world_mut().get_mut::<Planet>(planet).unwrap().recipe = recipe(2);
    print(
        "regenerated, seen growing",
        run(&mut app, &arguments, arguments.frames),
    );
    let mut changed = app.world_mut().get_mut::<Planet>(planet).unwrap();
    changed.regrowth = Regrowth::Hidden;
    changed.recipe = recipe(3);
    print(
        "regenerated in secret",
        run(&mut app, &arguments, arguments.frames),
    );
    app.world_mut().despawn(planet);
    print("despawned", run(&mut app, &arguments, arguments.frames));
}

/// Runs frames at the game's rate and returns what each cost, in ms.
fn run(app: &mut App, arguments: &Arguments, frames: usize) -> Vec<f64> {
    let interval = Duration::from_secs_f64(1.0 / arguments.rate.max(1.0));
    let mut costs = Vec::with_capacity(frames);
    let mut next = Instant::now();
    for _ in 0..frames {
        next += interval;
        std::thread::sleep(next.saturating_duration_since(Instant::now()));
        let start = Instant::now();
        app.update();
        costs.push(start.elapsed().as_secs_f64() * 1e3);
        next = next.max(Instant::now() - interval);
    }
    costs
}

fn print(phase: &str, mut costs: Vec<f64>) {
    costs.sort_by(f64::total_cmp);
    let at = |share: f64| costs[((costs.len() - 1) as f64 * share) as usize];
    let mean = costs.iter().sum::<f64>() / costs.len() as f64;
    println!(
        "| {phase} | {:.3} | {mean:.3} | {:.3} | {:.3} | {:.3} | {:.3} |",
        at(0.5),
        at(0.95),
        at(0.99),
        at(0.999),
        at(1.0)
    );
}

fn game(arguments: &Arguments) -> App {
    let mut app = App::new();
    if arguments.rendering {
        off_screen(&mut app);
    } else {
        app.add_plugins((MinimalPlugins, PlanetPlugin::default()));
    }
    app.finish();
    app.cleanup();
    app
}

#[cfg(not(all(feature = "render", feature = "window")))]
fn off_screen(_: &mut App) {
    eprintln!("error: --rendering needs the features render and window");
    std::process::exit(2);
}

#[cfg(all(feature = "render", feature = "window"))]
fn off_screen(app: &mut App) {
    use bevy::camera::RenderTarget;
    use bevy::render::{RenderPlugin, render_resource::TextureFormat};
    use bevy::winit::WinitPlugin;

    app.add_plugins((
        DefaultPlugins
            .set(RenderPlugin {
                synchronous_pipeline_compilation: true,
                ..default()
            })
            .set(WindowPlugin {
                primary_window: None,
                exit_condition: bevy::window::ExitCondition::DontExit,
                ..default()
            })
            .disable::<WinitPlugin>(),
        TectonicsPlugins,
    ))
    .add_systems(
        Startup,
        |mut commands: Commands, mut images: ResMut<Assets<Image>>| {
            let target = Image::new_target_texture(1280, 720, TextureFormat::Rgba8UnormSrgb, None);
            commands.spawn((
                Camera3d::default(),
                RenderTarget::Image(images.add(target).into()),
                Transform::from_xyz(0.0, 0.8, 2.6).looking_at(Vec3::ZERO, Vec3::Y),
            ));
            commands.spawn((
                DirectionalLight::default(),
                Transform::from_xyz(-2.0, 1.5, 3.0).looking_at(Vec3::ZERO, Vec3::Y),
            ));
        },
    );
}
