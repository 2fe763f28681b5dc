//! A flight from deep space to a mountain valley.
//!
//! `cargo run --release --example flyover`
//!
//! `-- --record frames` writes numbered pictures in place of opening a window, `-- --measure` flies off screen as fast
//! as it can and says what frames cost. With `--bevy-air` the air is Bevy's, with `--no-shadows` mountains cast none.

mod measure;
mod off_screen;

use bevy::{
    app::{TaskPoolOptions, TaskPoolPlugin, TaskPoolThreadAssignmentPolicy},
    camera::RenderTarget,
    light::{CascadeShadowConfig, CascadeShadowConfigBuilder},
    math::DVec3,
    pbr::{AtmosphereMode, AtmosphereSettings},
    prelude::*,
};
use bevy_tectonics::{
    planet::to_scene,
    prelude::*,
    render::{Drawn, PlanetAtmosphere, PlanetTiles, Viewpoint},
    simulation::Orogeny,
    surface::{Terrain, east_north},
};
use clap::Parser;
use libm::{cos, exp, exp2, log, log2, sin};
use std::{path::PathBuf, process::ExitCode, sync::Arc};

/// Radius of the planet in m, and of the world.
const RADIUS: f64 = 6.371e6;
/// Altitudes in m between which the camera comes down.
const ALTITUDES: (f64, f64) = (9.0 * RADIUS, 60.0);
/// Share of the flight after which the camera glides along the valley.
const ARRIVAL: f64 = 0.8;
/// Length of the glide in m.
const GLIDE_M: f64 = 3000.0;

#[derive(Parser, Resource, Clone)]
struct Arguments {
    /// Seed of the planet.
    #[arg(long, default_value_t = 206)]
    seed: u64,
    /// Number of sub-plates, 200 to 2,000,000.
    #[arg(long, default_value_t = 10_000)]
    sub_plates: u32,
    /// Age of the planet in My.
    #[arg(long, default_value_t = 150.0)]
    duration: f64,
    /// Length of the flight in s.
    #[arg(long, default_value_t = 60.0)]
    seconds: f64,
    /// Pictures a second where they are written.
    #[arg(long, default_value_t = 30.0)]
    rate: f64,
    /// Width of the pictures in pixels.
    #[arg(long, default_value_t = 1920)]
    width: u32,
    /// Height of the pictures in pixels.
    #[arg(long, default_value_t = 1080)]
    height: u32,
    /// Has Bevy's atmosphere drawn in place of the planet's own air.
    #[arg(long)]
    bevy_air: bool,
    /// Has mountains cast no shadows.
    #[arg(long)]
    no_shadows: bool,
    /// A folder for numbered pictures.
    #[arg(long)]
    record: Option<PathBuf>,
    /// Flies off screen as fast as it can and says what frames cost.
    #[arg(long)]
    measure: bool,
}

/// Where the flight goes, once there is ground.
#[derive(Resource)]
struct Flight {
    surface: Arc<Surface>,
    /// The valley, and the way the camera comes from.
    valley: DVec3,
    from: DVec3,
    /// Where the sun stands.
    sun: DVec3,
    /// 0 to 1.
    progress: f64,
}

#[derive(Resource)]
struct Canvas(Handle<Image>);

fn main() -> ExitCode {
    let arguments = Arguments::parse();
    let result = if arguments.record.is_some() || arguments.measure {
        off_screen::fly(&arguments)
    } else {
        App::new()
            .add_plugins((DefaultPlugins.set(tasks()), TectonicsPlugins))
            .insert_resource(arguments)
            .insert_resource(ClearColor(Color::BLACK))
            .add_systems(Startup, setup)
            .add_systems(Update, (plan, advance, fly).chain())
            .run();
        Ok(())
    };
    match result {
        Ok(()) => ExitCode::SUCCESS,
        Err(error) => {
            eprintln!("error: {error}");
            ExitCode::FAILURE
        }
    }
}

/// Half of all cores make tiles; Bevy would give them four at most.
fn tasks() -> TaskPoolPlugin {
    let half = TaskPoolThreadAssignmentPolicy {
        min_threads: 1,
        max_threads: usize::MAX,
        percent: 0.5,
        on_thread_spawn: None,
        on_thread_destroy: None,
    };
    TaskPoolPlugin {
        task_pool_options: TaskPoolOptions {
            async_compute: half,
            ..default()
        },
    }
}

fn setup(mut commands: Commands, arguments: Res<Arguments>, canvas: Option<Res<Canvas>>) {
    let recipe = Recipe::earth_like(arguments.seed)
        .with_sub_plates(arguments.sub_plates)
        .with_duration(arguments.duration);
    let planet = commands.spawn((
        Planet::new(recipe).with_radius(RADIUS as f32),
        PlanetView {
            exaggeration: 1.0,
            ..default()
        },
        PlanetTiles::default(),
    ));
    let planet = planet.id();
    let place_m = DVec3::X * (RADIUS + ALTITUDES.0);
    let mut camera = commands.spawn((Camera3d::default(), Viewpoint { planet, place_m }));
    if let Some(canvas) = canvas {
        camera.insert(RenderTarget::from(canvas.0.clone()));
    }
    if arguments.bevy_air {
        camera.insert(AtmosphereSettings {
            rendering_method: AtmosphereMode::Raymarched,
            sky_max_samples: 32,
            ..default()
        });
        commands.entity(planet).insert(PlanetAtmosphere::default());
    }
    commands.spawn(DirectionalLight {
        shadow_maps_enabled: !arguments.no_shadows,
        ..default()
    });
}

/// How far shadows reach for a camera at an altitude in m above the ground.
fn cascades(altitude: f64) -> CascadeShadowConfig {
    // By steps of two, or shadows would shimmer all the way down.
    let altitude = exp2(log2(altitude.max(1.0)).floor()) as f32;
    CascadeShadowConfigBuilder {
        // The ground nearest below the picture is about twice as far away as the ground below the camera.
        first_cascade_far_bound: (4.0 * altitude).max(150.0),
        // In the valley to the ranges around it, from above to where the air hides shadows.
        maximum_distance: 60_000.0 + 20.0 * altitude,
        ..default()
    }
    .build()
}

/// Looks for a valley below high mountains as soon as there are any.
fn plan(
    mut commands: Commands,
    flight: Option<Res<Flight>>,
    planets: Query<(&Growth, &PlanetSurface)>,
) -> Result {
    let Ok((growth, surface)) = planets.single() else {
        return Ok(());
    };
    if flight.is_some() || !matches!(growth.state, GrowthState::Finished) {
        return Ok(());
    }
    let surface = surface.share();
    let (valley, from) = find_valley(&surface)?;
    let (east, _) = east_north(valley);
    commands.insert_resource(Flight {
        surface,
        valley,
        from,
        // In the morning.
        sun: (valley * 0.45 + east).normalize(),
        progress: 0.0,
    });
    Ok(())
}

/// The lowest ground near the highest young range, and the flattest way there.
fn find_valley(surface: &Surface) -> Result<(DVec3, DVec3)> {
    let young = |v: &usize| surface.orogeny[*v] != Orogeny::None && surface.orogeny_age[*v] < 60.0;
    let rows = 0..surface.elevation.len();
    let highest = |rows: &mut dyn Iterator<Item = usize>| {
        rows.max_by(|&a, &b| surface.elevation[a].total_cmp(&surface.elevation[b]))
    };
    // Neither desert nor ice, if there is a choice.
    let is_green = |v: &usize| (0.5..0.85).contains(&surface.mesh.site(*v as u32).z.abs());
    let summit = highest(&mut rows.clone().filter(young).filter(is_green))
        .or_else(|| highest(&mut rows.clone().filter(young)))
        .or_else(|| highest(&mut rows.clone()));
    let summit = surface
        .mesh
        .site(summit.ok_or("a planet without ground")? as u32);
    let mut terrain = Terrain::new(surface, 200.0)?;
    let near = |at: DVec3, x: f64, y: f64| {
        let (east, north) = east_north(at);
        (at + (east * x + north * y) / RADIUS).normalize()
    };
    let steps = || (-30..=30).flat_map(|x| (-30..=30).map(move |y| (f64::from(x), f64::from(y))));
    let lowest = steps()
        .map(|(x, y)| near(summit, 600.0 * x, 600.0 * y))
        .map(|place| (place, terrain.elevation(place)))
        .min_by(|a, b| a.1.total_cmp(&b.1));
    let (valley, _) = lowest.ok_or("no ground near the summit")?;
    // The way along the valley: where the ground rises least.
    let mut rise = |turn: f64| {
        let mut sum = 0.0;
        for step in 1..=20 {
            let reach = 250.0 * f64::from(step);
            sum += terrain.elevation(near(valley, reach * cos(turn), reach * sin(turn)));
        }
        sum
    };
    let turns = (0..36).map(|turn| f64::from(turn) * 10_f64.to_radians());
    let best = turns
        .map(|turn| (turn, rise(turn)))
        .min_by(|a, b| a.1.total_cmp(&b.1));
    let (turn, _) = best.ok_or("no way out of the valley")?;
    let (east, north) = east_north(valley);
    Ok((valley, east * cos(turn) + north * sin(turn)))
}

impl Flight {
    /// Place of the camera in m from the planet's centre, where it looks, and its altitude.
    fn pose(&self) -> Result<(DVec3, DVec3, f64)> {
        let down = (self.progress / ARRIVAL).min(1.0);
        // Slower at both ends.
        let eased = down * down * (3.0 - 2.0 * down);
        let (high, low) = ALTITUDES;
        let altitude = exp(log(high) + (log(low) - log(high)) * eased);
        // The camera comes along the valley, ever lower, and goes on along it.
        let glide = ((self.progress - ARRIVAL) / (1.0 - ARRIVAL)).max(0.0);
        let behind = (1.6 * altitude / RADIUS).min(0.9) + (1.0 - glide * glide) * GLIDE_M / RADIUS;
        let up = (self.valley * cos(behind) + self.from * sin(behind)).normalize();
        let forward = (self.valley - up * self.valley.dot(up)).normalize_or(-self.from);
        // Well above what is below, however rough.
        let mut terrain = Terrain::new(&self.surface, 0.3 * altitude)?;
        let mut below = f32::MIN;
        for ahead in [0.0, 0.5, 1.0, 2.0] {
            let place = (up + forward * (ahead * altitude / RADIUS)).normalize();
            below = below.max(terrain.elevation(place));
        }
        let place = up * (RADIUS + f64::from(below.max(0.0)) + altitude);
        // Down at the valley from afar, ahead when it is near.
        let level = ((log(40_000.0) - log(altitude)) / log(200.0)).clamp(0.0, 1.0);
        let ahead = forward - up * 0.05;
        let near = 1.0 - (0.4 * altitude / RADIUS).min(1.0);
        let target = self.valley * (RADIUS * near) - place;
        let look = target
            .normalize()
            .lerp(ahead, level * level * (3.0 - 2.0 * level));
        Ok((place, look.normalize(), altitude))
    }
}

/// Goes on as time does, as soon as the planet is to be seen; in the end from the start.
fn advance(
    time: Res<Time>,
    arguments: Res<Arguments>,
    flight: Option<ResMut<Flight>>,
    drawn: Query<&Drawn>,
) {
    let Some(mut flight) = flight else {
        return;
    };
    if drawn.iter().any(|drawn| drawn.settled) {
        flight.progress += time.delta_secs_f64() / arguments.seconds.max(1.0);
        if flight.progress > 1.1 && arguments.record.is_none() && !arguments.measure {
            flight.progress = 0.0;
        }
    }
}

/// Puts the camera where the flight is: it stays at the origin, and the planet moves around it.
fn fly(
    flight: Option<Res<Flight>>,
    mut cameras: Query<(&mut Viewpoint, &mut Transform), With<Camera3d>>,
    mut planets: Query<&mut Transform, (With<Planet>, Without<Camera3d>)>,
    mut suns: Query<
        (&mut Transform, &mut CascadeShadowConfig),
        (Without<Planet>, Without<Camera3d>),
    >,
) -> Result {
    let (place_m, look, altitude, sun) = match &flight {
        Some(flight) => {
            let (place, look, altitude) = flight.pose()?;
            (place, look, altitude, flight.sun)
        }
        None => {
            let place = DVec3::new(1.0, -0.4, 0.3).normalize() * (RADIUS + ALTITUDES.0);
            let sun = DVec3::new(0.6, 0.8, 0.2);
            (place, -place.normalize(), ALTITUDES.0, sun)
        }
    };
    // North is up from afar, up is up from near.
    let up = place_m.normalize();
    let lean = ((place_m.length() - RADIUS) / RADIUS).clamp(0.0, 1.0);
    let head = to_scene((up * (1.0 - lean) + DVec3::Z * lean).normalize_or(up));
    for (mut viewpoint, mut transform) in &mut cameras {
        viewpoint.place_m = place_m;
        *transform = Transform::default().looking_to(to_scene(look), head);
    }
    for mut transform in &mut planets {
        transform.translation = -to_scene(place_m);
    }
    for (mut transform, mut shadows) in &mut suns {
        *transform = Transform::default().looking_to(-to_scene(sun), Vec3::Y);
        *shadows = cascades(altitude);
    }
    Ok(())
}
