//! A picture of a planet, drawn off screen: from afar, or from close above its ground.
//!
//! `cargo run --release --example portrait -- --seed 11 --duration 150 --out portrait.png`
//! `cargo run --release --example portrait -- --altitude 3000 --heading 90 --pitch -5 --shadows`
//! `cargo run --release --example portrait -- --bevy-air`, or any of these with it: the air is Bevy's

#[expect(dead_code, reason = "each uses a part of it")]
#[path = "../tests/studio/mod.rs"]
mod studio;

use bevy_tectonics::{
    prelude::*,
    render::{PlanetClouds, PlanetRenderSettings, Preset, Stars},
    surface::{direction_of, east_north},
};
use clap::Parser;
use libm::{cos, sin};
use std::{path::PathBuf, process::ExitCode};
use studio::{Look, Pose, Studio};

#[derive(Parser)]
struct Arguments {
    /// Seed of the planet.
    #[arg(long, default_value_t = 11)]
    seed: u64,
    /// What kind of planet: earth-like, young-hot or old-dry.
    #[arg(long, default_value = "earth-like")]
    preset: String,
    /// Draws clouds.
    #[arg(long)]
    clouds: bool,
    /// Draws stars.
    #[arg(long)]
    stars: bool,
    /// Has Bevy's atmosphere drawn in place of the planet's own air.
    #[arg(long)]
    bevy_air: bool,
    /// Number of sub-plates, 200 to 2,000,000.
    #[arg(long, default_value_t = 10_000)]
    sub_plates: u32,
    /// Age of the planet in My.
    #[arg(long, default_value_t = 150.0)]
    duration: f64,
    /// Width of the picture in pixels.
    #[arg(long, default_value_t = 1280)]
    width: u32,
    /// Height of the picture in pixels.
    #[arg(long, default_value_t = 720)]
    height: u32,
    /// A field that covers the natural colours: plates, crust, age, thickness, speed, elevation, orogeny.
    #[arg(long)]
    overlay: Option<String>,
    /// Draws boundaries of plates.
    #[arg(long)]
    boundaries: bool,
    /// Draws velocities as arrows.
    #[arg(long)]
    velocities: bool,
    /// Factor on heights.
    #[arg(long, default_value_t = 12.0)]
    exaggeration: f32,
    /// Latitude of the camera in degrees.
    #[arg(long, default_value_t = 15.0, allow_hyphen_values = true)]
    latitude: f64,
    /// Longitude of the camera in degrees.
    #[arg(long, default_value_t = 0.0, allow_hyphen_values = true)]
    longitude: f64,
    /// Distance of the camera from the planet's centre in radii.
    #[arg(long, default_value_t = 3.0)]
    distance: f64,
    /// Height of the camera above the ground or the sea in m, up to 3,000,000, in place of a distance.
    #[arg(long)]
    altitude: Option<f64>,
    /// Where a camera above the ground looks, in degrees clockwise from north.
    #[arg(long, default_value_t = 0.0, allow_hyphen_values = true)]
    heading: f64,
    /// How far above the horizon it looks, in degrees.
    #[arg(long, default_value_t = -10.0, allow_hyphen_values = true)]
    pitch: f64,
    /// How high the sun stands above its ground, in degrees. It is in the west.
    #[arg(long, default_value_t = 30.0, allow_hyphen_values = true)]
    sun_height: f64,
    /// Mountains cast shadows, where the camera is above the ground.
    #[arg(long)]
    shadows: bool,
    /// How far the sun stands to the east of the camera, in degrees.
    #[arg(long, default_value_t = -38.0, allow_hyphen_values = true)]
    sun_east: f64,
    /// Texels along an edge of the planet's cube maps, 64 to 2048.
    #[arg(long, default_value_t = 512)]
    face: u32,
    /// Where the picture goes.
    #[arg(long, default_value = "portrait.png")]
    out: PathBuf,
}

fn main() -> ExitCode {
    match portray(&Arguments::parse()) {
        Ok(()) => ExitCode::SUCCESS,
        Err(error) => {
            eprintln!("error: {error}");
            ExitCode::FAILURE
        }
    }
}

fn portray(arguments: &Arguments) -> Result<(), String> {
    let overlay = match &arguments.overlay {
        None => None,
        Some(name) => Some(
            Overlay::ALL
                .into_iter()
                .find(|overlay| format!("{overlay:?}").eq_ignore_ascii_case(name))
                .ok_or_else(|| format!("there is no overlay {name}; --help names them all"))?,
        ),
    };
    let preset = Preset::ALL
        .into_iter()
        .find(|preset| preset.name() == arguments.preset)
        .ok_or_else(|| {
            let names = Preset::ALL.map(Preset::name).join(", ");
            format!("there is no preset {}; there are {names}", arguments.preset)
        })?;
    let recipe = preset
        .recipe(arguments.seed)
        .with_sub_plates(arguments.sub_plates)
        .with_duration(arguments.duration);
    let (width, height) = (arguments.width, arguments.height);
    if ![width, height]
        .iter()
        .all(|side| (16..=8192).contains(side))
    {
        return Err(format!(
            "the picture is {width} × {height}, but must be 16 to 8192 pixels a side"
        ));
    }
    // In m, where the ground is to be seen.
    let radius = if arguments.altitude.is_some() {
        6.371e6
    } else {
        1.0
    };
    let mut studio = Studio::new(width, height, Planet::new(recipe).with_radius(radius))
        .ok_or("there is no graphics adapter to draw with")?;
    studio.settings(PlanetRenderSettings {
        face: arguments.face,
    });
    *studio.view() = PlanetView {
        overlay,
        boundaries: arguments.boundaries,
        velocities: arguments.velocities,
        exaggeration: arguments.exaggeration,
        ..PlanetView::default()
    };
    let (palette, air, clouds) = preset.look();
    studio.dress((palette, air), ());
    if arguments.clouds {
        studio.dress(
            PlanetClouds {
                drift: 0.0,
                ..clouds
            },
            (),
        );
    }
    if arguments.stars {
        studio.dress((), Stars::default());
    }
    if arguments.bevy_air {
        studio.bevy_air();
    }
    studio.pose(Pose {
        latitude: arguments.latitude,
        longitude: arguments.longitude,
        distance: arguments.distance,
        sun_east: arguments.sun_east,
        ..Pose::default()
    });
    if let Some(altitude_m) = arguments.altitude {
        studio.view().exaggeration = 1.0;
        let surface = studio.surface()?;
        let up = direction_of(arguments.latitude, arguments.longitude);
        let (east, north) = east_north(up);
        let toward = |bearing: f64, height: f64| {
            let (b, h) = (bearing.to_radians(), height.to_radians());
            (north * cos(b) + east * sin(b)) * cos(h) + up * sin(h)
        };
        let ground = surface
            .sample(up, 1.0)
            .map_err(|error| error.to_string())?
            .elevation
            .max(0.0);
        let altitude_m = altitude_m.clamp(1.0, 3e6);
        let height_m = f64::from(ground) + altitude_m;
        studio.shadows(arguments.shadows, altitude_m as f32);
        studio.look(Look {
            place_m: up * (1000.0 * surface.radius_km + height_m),
            forward: toward(arguments.heading, arguments.pitch.clamp(-89.0, 89.0)),
            sun: toward(-90.0, arguments.sun_height),
        });
    }
    studio
        .shoot()?
        .save(&arguments.out)
        .map_err(|error| format!("{}: {error}", arguments.out.display()))?;
    println!("{}", arguments.out.display());
    Ok(())
}
