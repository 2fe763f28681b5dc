//! Grows a planet and takes a picture of it, without a window.
//!
//! `cargo run --release --example portrait -- --seed 11 --age 150 --out portrait.png`

use bevy::{
    app::ScheduleRunnerPlugin,
    camera::RenderTarget,
    image::TextureFormatPixelInfo,
    prelude::*,
    render::{
        RenderPlugin,
        pipelined_rendering::PipelinedRenderingPlugin,
        render_resource::TextureFormat,
        view::screenshot::{Screenshot, ScreenshotCaptured},
    },
    window::ExitCondition,
    winit::WinitPlugin,
};
use bevy_tectonics::{
    planet::to_scene,
    prelude::*,
    render::{PlanetRenderPlugin, SurfaceDrawn},
    surface::direction,
};
use clap::Parser;
use core::error::Error;
use std::{
    fs::File,
    io::BufWriter,
    path::{Path, PathBuf},
};

/// Grows a planet and takes a picture of it.
#[derive(Parser, Resource)]
struct Arguments {
    /// Seed of the planet.
    #[arg(long, default_value_t = 11)]
    seed: u64,
    /// Number of sub-plates, 200 to 2,000,000.
    #[arg(long, default_value_t = 10_000)]
    sub_plates: u32,
    /// Age of the planet in My.
    #[arg(long, default_value_t = 150.0)]
    age: f64,
    /// Width and height of the picture.
    #[arg(long, num_args = 2, default_values_t = [1280, 720])]
    size: Vec<u32>,
    /// A field that covers the natural colours, such as `plates` or `age`.
    #[arg(long, value_parser = overlay)]
    overlay: Option<Overlay>,
    /// Heights are drawn this many times larger than they are.
    #[arg(long, default_value_t = 12.0)]
    exaggeration: f32,
    /// Longitude and latitude in degrees where the camera stands, and its distance in radii.
    #[arg(long, num_args = 3, allow_negative_numbers = true, default_values_t = [0.0, 15.0, 3.2])]
    camera: Vec<f64>,
    /// Longitude and latitude of the sun in degrees, as seen from the camera's.
    #[arg(long, num_args = 2, allow_negative_numbers = true, default_values_t = [-38.0, 18.0])]
    sun: Vec<f64>,
    /// The file to write.
    #[arg(long, default_value = "portrait.png")]
    out: PathBuf,
}

fn overlay(name: &str) -> Result<Overlay, String> {
    Overlay::ALL
        .into_iter()
        .find(|overlay| format!("{overlay:?}").eq_ignore_ascii_case(name))
        .ok_or_else(|| format!("overlays are {:?}", Overlay::ALL))
}

fn main() -> AppExit {
    App::new()
        .insert_resource(Arguments::parse())
        .add_plugins((
            DefaultPlugins
                .build()
                .disable::<WinitPlugin>()
                // Software renderers crash when an app ends while another thread renders.
                .disable::<PipelinedRenderingPlugin>()
                .set(RenderPlugin {
                    synchronous_pipeline_compilation: true,
                    ..default()
                })
                .set(WindowPlugin {
                    primary_window: None,
                    exit_condition: ExitCondition::DontExit,
                    ..default()
                }),
            ScheduleRunnerPlugin::default(),
            PlanetPlugin::default(),
            PlanetRenderPlugin,
        ))
        .insert_resource(ClearColor(Color::BLACK))
        .insert_resource(GlobalAmbientLight {
            brightness: 12.0,
            ..default()
        })
        .add_systems(Startup, set_up)
        .run()
}

#[derive(Resource)]
struct Picture(Handle<Image>);

fn set_up(mut commands: Commands, arguments: Res<Arguments>, mut images: ResMut<Assets<Image>>) {
    let (width, height) = (arguments.size[0].max(1), arguments.size[1].max(1));
    let picture = images.add(Image::new_target_texture(
        width,
        height,
        TextureFormat::Rgba8UnormSrgb,
        None,
    ));
    let recipe = Recipe::earth_like(arguments.seed).with_sub_plates(arguments.sub_plates);
    commands
        .spawn((
            Planet::new(recipe).with_end(arguments.age),
            PlanetView {
                overlay: arguments.overlay,
                exaggeration: arguments.exaggeration,
                ..default()
            },
        ))
        .observe(expose)
        .observe(
            |failed: On<GrowthFailed>, mut exit: MessageWriter<AppExit>| {
                error!("{}", failed.failure);
                exit.write(AppExit::error());
            },
        );
    let at = |longitude: f64, latitude: f64| {
        to_scene(direction(longitude.to_radians(), latitude.to_radians()))
    };
    let [longitude, latitude, distance] = [0, 1, 2].map(|i| arguments.camera[i]);
    commands.spawn((
        Camera3d::default(),
        RenderTarget::from(picture.clone()),
        Transform::from_translation(at(longitude, latitude) * distance as f32)
            .looking_at(Vec3::ZERO, Vec3::Y),
    ));
    let [east, north] = [0, 1].map(|i| arguments.sun[i]);
    commands.spawn((
        DirectionalLight::default(),
        Transform::from_translation(at(longitude + east, latitude + north))
            .looking_at(Vec3::ZERO, Vec3::Y),
    ));
    commands.insert_resource(Picture(picture));
}

/// Takes the picture when the last surface is on screen.
fn expose(
    drawn: On<SurfaceDrawn>,
    mut commands: Commands,
    planets: Query<&Growth>,
    picture: Res<Picture>,
) {
    let grown = planets.get(drawn.entity).is_ok_and(|growth| {
        growth.state == GrowthState::Finished && growth.progress.time_my == drawn.time_my
    });
    if grown && drawn.finest {
        commands
            .spawn(Screenshot::image(picture.0.clone()))
            .observe(develop);
    }
}

fn develop(
    captured: On<ScreenshotCaptured>,
    arguments: Res<Arguments>,
    mut exit: MessageWriter<AppExit>,
) {
    exit.write(match save(&captured.image, &arguments.out) {
        Ok(()) => AppExit::Success,
        Err(error) => {
            error!("{}: {error}", arguments.out.display());
            AppExit::error()
        }
    });
}

fn save(image: &Image, path: &Path) -> Result<(), Box<dyn Error>> {
    let pixels = image.data.as_ref().ok_or("the picture is empty")?;
    let size = image.texture_descriptor.format.pixel_size()?;
    let colours: Vec<u8> = pixels
        .chunks(size)
        .flat_map(|pixel| pixel.iter().take(3))
        .copied()
        .collect();
    let file = BufWriter::new(File::create(path)?);
    let mut encoder = png::Encoder::new(file, image.width(), image.height());
    encoder.set_color(png::ColorType::Rgb);
    encoder.set_depth(png::BitDepth::Eight);
    encoder.write_header()?.write_image_data(&colours)?;
    Ok(())
}
