//! The flight drawn to pictures in place of a window.

use crate::{Arguments, Canvas, Flight, measure};
use bevy::{
    app::PluginsState,
    prelude::*,
    render::{
        diagnostic::RenderDiagnosticsPlugin,
        pipelined_rendering::PipelinedRenderingPlugin,
        render_resource::TextureFormat,
        view::screenshot::{Screenshot, ScreenshotCaptured},
    },
    window::ExitCondition,
    winit::WinitPlugin,
};
use bevy_tectonics::{
    prelude::*,
    render::{Drawn, TilesDrawn},
};
use core::{error::Error, time::Duration};
use indicatif::ProgressBar;
use std::{
    fs::{self, File},
    io::BufWriter,
    path::Path,
    sync::{Arc, Mutex, PoisonError},
    time::Instant,
};

/// Draws to an image in place of a window.
pub fn fly(arguments: &Arguments) -> Result<(), String> {
    let mut app = App::new();
    app.add_plugins(
        DefaultPlugins
            .build()
            .disable::<WinitPlugin>()
            .disable::<PipelinedRenderingPlugin>()
            .set(super::tasks())
            .set(WindowPlugin {
                primary_window: None,
                exit_condition: ExitCondition::DontExit,
                ..default()
            }),
    )
    .add_plugins((TectonicsPlugins, RenderDiagnosticsPlugin))
    .insert_resource(arguments.clone())
    .insert_resource(ClearColor(Color::BLACK))
    .add_systems(Update, (super::plan, super::fly).chain());
    while app.plugins_state() == PluginsState::Adding {
        bevy::tasks::tick_global_task_pools_on_main_thread();
    }
    app.finish();
    app.cleanup();
    let format = TextureFormat::Rgba8UnormSrgb;
    let (width, height) = (
        arguments.width.clamp(16, 8192),
        arguments.height.clamp(16, 8192),
    );
    let canvas = Image::new_target_texture(width, height, format, None);
    let canvas = app.world_mut().resource_mut::<Assets<Image>>().add(canvas);
    app.insert_resource(Canvas(canvas.clone()));
    let _ = app.world_mut().run_system_cached(super::setup);
    println!(
        "growing {} My of seed {}",
        arguments.duration, arguments.seed
    );
    let mut settled = false;
    while !settled {
        app.update();
        let world = app.world_mut();
        for growth in world.query::<&Growth>().iter(world) {
            if let GrowthState::Failed(failure) = &growth.state {
                return Err(failure.to_string());
            }
        }
        let mut drawn = world.query::<&Drawn>();
        settled =
            world.contains_resource::<Flight>() && drawn.iter(world).any(|drawn| drawn.settled);
    }
    match &arguments.record {
        Some(folder) => record(&mut app, arguments, folder, &canvas),
        None => {
            measure::measure(&mut app, arguments);
            Ok(())
        }
    }
}

/// Longest time for which a picture waits for tiles.
const PATIENCE: Duration = Duration::from_secs(60);
/// Time in which new tiles take on their shape.
const SETTLING: Duration = Duration::from_millis(500);

/// Pictures of the flight, each complete.
fn record(
    app: &mut App,
    arguments: &Arguments,
    folder: &Path,
    canvas: &Handle<Image>,
) -> Result<(), String> {
    fs::create_dir_all(folder).map_err(|error| format!("{}: {error}", folder.display()))?;
    let frames = (arguments.seconds * arguments.rate).clamp(2.0, 1e6) as u32;
    let bar = ProgressBar::new(u64::from(frames));
    for frame in 0..frames {
        app.world_mut().resource_mut::<Flight>().progress =
            f64::from(frame) / f64::from(frames - 1);
        let start = Instant::now();
        // A change is seen a frame later.
        app.update();
        let mut complete = Instant::now();
        while complete.elapsed() < SETTLING && start.elapsed() < PATIENCE {
            let before = tiles(app);
            app.update();
            let now = tiles(app);
            if now.missing_in_view > 0 || now.made > before.made || now.share != before.share {
                complete = Instant::now();
            }
        }
        let path = folder.join(format!("{frame:05}.png"));
        let taken = Arc::new(Mutex::new(None));
        let done = taken.clone();
        app.world_mut()
            .spawn(Screenshot::image(canvas.clone()))
            .observe(move |captured: On<ScreenshotCaptured>| {
                *done.lock().unwrap_or_else(PoisonError::into_inner) = Some(captured.image.clone());
            });
        let picture = loop {
            app.update();
            if let Some(picture) = taken.lock().unwrap_or_else(PoisonError::into_inner).take() {
                break picture;
            }
            if start.elapsed() > 2 * PATIENCE {
                return Err("nothing was drawn".into());
            }
        };
        save(&picture, &path).map_err(|error| format!("{}: {error}", path.display()))?;
        bar.inc(1);
    }
    bar.finish();
    println!("{frames} pictures in {}", folder.display());
    Ok(())
}

fn save(picture: &Image, path: &Path) -> Result<(), Box<dyn Error>> {
    let (width, height) = (picture.width(), picture.height());
    let mut encoder = png::Encoder::new(BufWriter::new(File::create(path)?), width, height);
    encoder.set_color(png::ColorType::Rgba);
    encoder.set_depth(png::BitDepth::Eight);
    let pixels = picture.data.as_deref().ok_or("a picture without pixels")?;
    encoder.write_header()?.write_image_data(pixels)?;
    Ok(())
}

pub fn tiles(app: &mut App) -> TilesDrawn {
    let world = app.world_mut();
    let mut drawn = world.query::<&TilesDrawn>();
    drawn.iter(world).next().copied().unwrap_or_default()
}
