//! Grows a planet and takes pictures of it, without a window.
//!
//! ```sh
//! cargo run --release --example portrait -- --seed 11 --my 150 --out portrait.png
//! ```

use bevy::{
    app::ScheduleRunnerPlugin,
    asset::RenderAssetUsages,
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
    planet::to_scene, prelude::*, render::PlanetRenderPlugin, surface::direction,
};
use clap::Parser;
use std::{fs::File, io::BufWriter, path::PathBuf, time::Instant};

#[derive(Parser, Resource, Debug, Clone)]
struct Options {
    #[arg(long, default_value_t = 11)]
    seed: u64,
    #[arg(long, default_value_t = 10_000)]
    sub_plates: u32,
    /// Age of the planet in My.
    #[arg(long, default_value_t = 150.0)]
    my: f64,
    /// Width and height of the picture.
    #[arg(long, num_args = 2, default_values_t = [1280, 720])]
    size: Vec<u32>,
    /// A field that covers the natural colours, such as `plates` or `age`.
    #[arg(long)]
    overlay: Option<String>,
    #[arg(long, default_value_t = 12.0)]
    exaggeration: f32,
    /// Where the camera and the sun stand: longitude, latitude and distance in radii of the camera,
    /// longitude and latitude of the sun relative to the camera's, in degrees.
    #[arg(long, num_args = 5, allow_hyphen_values = true, default_values_t = [0.0, 15.0, 3.2, -38.0, 18.0])]
    view: Vec<f64>,
    #[arg(long, default_value = "portrait.png")]
    out: PathBuf,
    #[arg(long)]
    serve: Option<PathBuf>,
}

fn cpu() -> f64 {
    let stat = std::fs::read_to_string("/proc/self/stat").unwrap();
    let f: Vec<_> = stat
        .rsplit(')')
        .next()
        .unwrap()
        .split_whitespace()
        .map(String::from)
        .collect();
    (f[11].parse::<f64>().unwrap() + f[12].parse::<f64>().unwrap()) / 100.0
}
#[derive(Resource)]
struct Studio {
    cpu: f64,
    picture: Handle<Image>,
    grown: bool,
    frames: u32,
    asked: bool,
    begun: Instant,
}

fn main() -> AppExit {
    let options = Options::parse();
    let mut app = App::new();
    app.add_plugins((
        DefaultPlugins
            .build()
            .disable::<WinitPlugin>()
            // Leaving while the other thread renders crashes software renderers.
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
    .insert_resource(options)
    .add_systems(Startup, set_up)
    .add_systems(Update, (serve, shoot).chain());
    if let Some(render) = app.get_sub_app_mut(bevy::render::RenderApp) {
        render.add_systems(
            bevy::render::Render,
            (|device: Res<bevy::render::renderer::RenderDevice>| {
                let _ = device.poll(bevy::render::render_resource::PollType::wait_indefinitely());
            })
            .in_set(bevy::render::RenderSystems::Cleanup),
        );
    }
    app.run()
}

fn set_up(mut commands: Commands, options: Res<Options>, mut images: ResMut<Assets<Image>>) {
    let mut picture = Image::new_target_texture(
        options.size[0],
        options.size[1],
        TextureFormat::Rgba8UnormSrgb,
        None,
    );
    picture.asset_usage = RenderAssetUsages::default();
    let picture = images.add(picture);
    let recipe = Recipe {
        sub_plates: options.sub_plates,
        ..Recipe::earth_like(options.seed)
    };
    commands
        .spawn((
            Planet::new(recipe).with_end(options.my),
            PlanetView {
                overlay: options.overlay.as_ref().and_then(|name| overlay(name)),
                exaggeration: options.exaggeration,
                ..default()
            },
        ))
        .observe(|_: On<GrowthFinished>, mut studio: ResMut<Studio>| {
            println!("grown after {:.1} s", studio.begun.elapsed().as_secs_f32());
            studio.grown = true;
        })
        .observe(|_: On<GrowthFailed>, mut exit: MessageWriter<AppExit>| {
            exit.write(AppExit::error());
        });
    commands.spawn((
        Camera3d::default(),
        if std::env::var("NOMSAA").is_ok() {
            Msaa::Off
        } else {
            Msaa::Sample4
        },
        RenderTarget::from(picture.clone()),
    ));
    commands.spawn(DirectionalLight {
        illuminance: 10_000.0,
        ..default()
    });
    commands.insert_resource(Studio {
        picture,
        grown: false,
        frames: 0,
        asked: false,
        begun: Instant::now(),
        cpu: 0.0,
    });
}

fn overlay(name: &str) -> Option<Overlay> {
    Overlay::ALL
        .into_iter()
        .find(|overlay| format!("{overlay:?}").eq_ignore_ascii_case(name))
}

fn serve(
    mut options: ResMut<Options>,
    mut studio: ResMut<Studio>,
    mut shaders: ResMut<Assets<bevy::shader::Shader>>,
    mut views: Query<&mut PlanetView>,
    mut exit: MessageWriter<AppExit>,
    time: Res<Time>,
) {
    let Some(path) = options.serve.clone() else {
        return;
    };
    if !studio.grown || (studio.asked && studio.frames != u32::MAX) {
        return;
    }
    if studio.frames != u32::MAX && studio.frames != 0 {
        return;
    }
    let Ok(text) = std::fs::read_to_string(&path) else {
        std::thread::sleep(std::time::Duration::from_millis(100));
        if studio.begun.elapsed().as_secs() > 3000 {
            exit.write(AppExit::Success);
        }
        return;
    };
    let mut lines = text.lines();
    let Some(line) = lines.next() else {
        let _ = std::fs::remove_file(&path);
        return;
    };
    let rest: Vec<_> = lines.collect();
    if rest.is_empty() {
        let _ = std::fs::remove_file(&path);
    } else {
        std::fs::write(&path, rest.join("\n")).unwrap();
    }
    let words: Vec<_> = line.split_whitespace().collect();
    match words[0] {
        "quit" => {
            exit.write(AppExit::Success);
        }
        "reload" => {
            let ids: Vec<_> = shaders.iter().map(|(id, s)| (id, s.path.clone())).collect();
            for (id, path) in ids {
                if let Some(name) = path.strip_prefix("embedded://bevy_tectonics/render/") {
                    let disk = format!("/work/wt-render/src/render/{name}");
                    if let Ok(source) = std::fs::read_to_string(&disk) {
                        println!("reload {name}");
                        let shader = bevy::shader::Shader::from_wgsl(source, path.clone());
                        let _ = shaders.insert(id, shader);
                    }
                }
            }
        }
        out => {
            let n: Vec<f64> = words[1..6].iter().map(|w| w.parse().unwrap()).collect();
            options.view = n;
            options.out = out.into();
            for mut view in &mut views {
                view.exaggeration = words.get(6).and_then(|w| w.parse().ok()).unwrap_or(12.0);
                view.overlay = words.get(7).and_then(|w| overlay(w));
                view.sea_level_m = words.get(8).and_then(|w| w.parse().ok()).unwrap_or(0.0);
                view.sea = words.get(9).is_none();
            }
            studio.frames = 0;
            studio.asked = false;
        }
    }
    let _ = time;
}

/// Waits until the planet is grown and its last surface is drawn, then takes the picture.
fn shoot(
    mut commands: Commands,
    options: Res<Options>,
    mut studio: ResMut<Studio>,
    camera: Single<&mut Transform, With<Camera3d>>,
    sun: Single<&mut Transform, (With<DirectionalLight>, Without<Camera3d>)>,
    time: Res<Time<Real>>,
) {
    let [longitude, latitude, distance, east, north] = options.view[..] else {
        return;
    };
    let at = |longitude: f64, latitude: f64| {
        to_scene(direction(longitude.to_radians(), latitude.to_radians()))
    };
    *camera.into_inner() = Transform::from_translation(at(longitude, latitude) * distance as f32)
        .looking_at(Vec3::ZERO, Vec3::Y);
    *sun.into_inner() = Transform::from_translation(at(longitude + east, latitude + north))
        .looking_at(Vec3::ZERO, Vec3::Y);
    if !studio.grown || studio.asked {
        return;
    }
    if studio.frames == 0 {
        studio.begun = Instant::now();
        studio.cpu = cpu();
    }
    studio.frames += 1;
    let _ = time;
    if studio.begun.elapsed().as_secs_f32() < if options.serve.is_some() { 4.0 } else { 6.0 } {
        return;
    }
    studio.asked = true;
    println!(
        "{} frames in {:.2} s, cpu {:.0} ms each",
        studio.frames - 1,
        studio.begun.elapsed().as_secs_f32(),
        1000.0 * (cpu() - studio.cpu) / f64::from(studio.frames - 1)
    );
    commands
        .spawn(Screenshot::image(studio.picture.clone()))
        .observe(develop);
}

/// Saves the picture.
fn develop(
    captured: On<ScreenshotCaptured>,
    options: Res<Options>,
    mut studio: ResMut<Studio>,
    mut exit: MessageWriter<AppExit>,
) {
    println!(
        "captured {} {:.2}",
        options.out.display(),
        studio.begun.elapsed().as_secs_f32()
    );
    if options.serve.is_some() {
        studio.frames = u32::MAX;
    } else {
        exit.write(match save(&captured.image, &options.out) {
            Ok(()) => AppExit::Success,
            Err(error) => {
                eprintln!("{}: {error}", options.out.display());
                AppExit::error()
            }
        });
        return;
    }
    save(&captured.image, &options.out).unwrap();
}

fn save(image: &Image, path: &PathBuf) -> Result<(), Box<dyn std::error::Error>> {
    let pixels = image.data.as_ref().ok_or("no pixels")?;
    let size = image.texture_descriptor.format.pixel_size()?;
    let mut encoder = png::Encoder::new(
        BufWriter::new(File::create(path)?),
        image.width(),
        image.height(),
    );
    encoder.set_color(png::ColorType::Rgb);
    encoder.set_depth(png::BitDepth::Eight);
    let rgb: Vec<u8> = pixels
        .chunks(size)
        .flat_map(|pixel| [pixel[0], pixel[1], pixel[2]])
        .collect();
    encoder.write_header()?.write_image_data(&rgb)?;
    Ok(())
}
