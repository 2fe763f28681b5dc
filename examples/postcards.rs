//! Ten pictures of a planet, from orbit to eye level, of places that the program picks by itself.
//!
//! `cargo run --release --example postcards -- --seed 206 --out postcards`

#[expect(dead_code, reason = "each uses a part of it")]
#[path = "../tests/studio/mod.rs"]
mod studio;

use bevy_tectonics::{
    prelude::*,
    render::PlanetRenderSettings,
    surface::{Landmark, Terrain, east_north, lat_lon},
};
use clap::Parser;
use glam::DVec3;
use libm::{cos, sin};
use std::{fs, path::PathBuf, process::ExitCode};
use studio::{Look, Studio};

/// Radius of the planet in m.
const RADIUS: f64 = 6.371e6;

#[derive(Parser)]
struct Arguments {
    /// Seed of the planet.
    #[arg(long, default_value_t = 206)]
    seed: u64,
    /// Number of sub-plates, 200 to 2,000,000.
    #[arg(long, default_value_t = 40_000)]
    sub_plates: u32,
    /// Age of the planet in My.
    #[arg(long, default_value_t = 300.0)]
    duration: f64,
    /// Width of the pictures in pixels.
    #[arg(long, default_value_t = 1280)]
    width: u32,
    /// Height of the pictures in pixels.
    #[arg(long, default_value_t = 720)]
    height: u32,
    /// Has Bevy's atmosphere drawn in place of the planet's own air.
    #[arg(long)]
    bevy_air: bool,
    /// One picture alone, by its number.
    #[arg(long)]
    only: Option<usize>,
    /// The folder for the pictures.
    #[arg(long, default_value = "postcards")]
    out: PathBuf,
}

/// Where the camera stands before what it shows.
struct Card {
    title: &'static str,
    landmark: Landmark,
    /// What to look for around the landmark.
    aim: Aim,
    /// How far the camera stands back, and how high above the ground, in m.
    back_m: f64,
    height_m: f64,
    /// How high the sun stands, in degrees.
    sun: f64,
    /// Whether the sea is drawn, and the factor on heights.
    sea: bool,
    exaggeration: f32,
}

#[derive(Clone, Copy, PartialEq)]
enum Aim {
    Place,
    Summit,
    Valley,
    Shore,
}

const fn card(
    title: &'static str,
    landmark: Landmark,
    aim: Aim,
    back_km: f64,
    height_m: f64,
    sun: f64,
) -> Card {
    Card {
        title,
        landmark,
        aim,
        back_m: 1000.0 * back_km,
        height_m,
        sun,
        sea: true,
        exaggeration: 1.0,
    }
}

fn cards() -> [Card; 10] {
    use Landmark::*;
    let mut cards = [
        card("from orbit", PassiveMargin, Aim::Place, 1600.0, 2.6e6, 50.0),
        card(
            "passive margin",
            PassiveMargin,
            Aim::Shore,
            500.0,
            3.0e5,
            40.0,
        ),
        card(
            "longest ridge",
            LongestRidge,
            Aim::Place,
            450.0,
            3.0e5,
            25.0,
        ),
        card("island arc", IslandArc, Aim::Summit, 220.0, 9.0e4, 35.0),
        card("cordillera", Cordillera, Aim::Summit, 130.0, 3.0e4, 30.0),
        card("rift", Rift, Aim::Valley, 60.0, 1.2e4, 25.0),
        card(
            "highest range",
            HighestRange,
            Aim::Summit,
            24.0,
            2500.0,
            28.0,
        ),
        card("oldest range", OldestRange, Aim::Summit, 14.0, 900.0, 25.0),
        card("valley", HighestRange, Aim::Valley, 3.0, 30.0, 35.0),
        card("flat coast", FlatCoast, Aim::Shore, 0.25, 4.0, 20.0),
    ];
    // The floor of the sea is flat to the eye.
    (cards[2].sea, cards[2].exaggeration) = (false, 3.0);
    cards
}

fn main() -> ExitCode {
    match draw(&Arguments::parse()) {
        Ok(()) => ExitCode::SUCCESS,
        Err(error) => {
            eprintln!("error: {error}");
            ExitCode::FAILURE
        }
    }
}

fn draw(arguments: &Arguments) -> Result<(), String> {
    let recipe = Recipe::earth_like(arguments.seed)
        .with_sub_plates(arguments.sub_plates)
        .with_duration(arguments.duration);
    let (width, height) = (arguments.width, arguments.height);
    if ![width, height]
        .iter()
        .all(|side| (16..=8192).contains(side))
    {
        return Err(format!(
            "pictures are {width} × {height}, but must be 16 to 8192 pixels a side"
        ));
    }
    let named = |error: std::io::Error| format!("{}: {error}", arguments.out.display());
    fs::create_dir_all(&arguments.out).map_err(named)?;
    let planet = Planet::new(recipe).with_radius(RADIUS as f32);
    let mut studio =
        Studio::new(width, height, planet).ok_or("there is no graphics adapter to draw with")?;
    studio.settings(PlanetRenderSettings { face: 1024 });
    if arguments.bevy_air {
        studio.bevy_air();
    }
    let surface = studio.surface()?;
    for (number, card) in (1..).zip(cards()) {
        if arguments.only.is_some_and(|only| only != number) {
            continue;
        }
        let Some((place, across)) = surface.landmark(card.landmark) else {
            println!("{number}: this planet has no {}", card.landmark.name());
            continue;
        };
        *studio.view() = PlanetView {
            exaggeration: card.exaggeration,
            sea: card.sea,
            ..PlanetView::default()
        };
        let (look, target) =
            stand(&surface, &card, place, across).map_err(|error| error.to_string())?;
        studio.look(look);
        let name = format!("{number:02}_{}.png", card.title.replace(' ', "_"));
        let path = arguments.out.join(name);
        let picture = studio.shoot()?;
        picture
            .save(&path)
            .map_err(|error| format!("{}: {error}", path.display()))?;
        let (latitude, longitude) = lat_lon(target);
        println!("{} at {latitude:.2}°, {longitude:.2}°", path.display());
    }
    Ok(())
}

/// Where the camera stands, and what it looks at.
fn stand(
    surface: &Surface,
    card: &Card,
    place: DVec3,
    across: DVec3,
) -> Result<(Look, DVec3), bevy_tectonics::surface::SurfaceError> {
    let mut terrain = Terrain::new(surface, (0.2 * card.height_m).clamp(10.0, 5000.0))?;
    let target = aim(&mut terrain, card, place);
    let turn = |from: DVec3, toward: DVec3, metres: f64| {
        let toward = (toward - from * toward.dot(from)).normalize();
        from * cos(metres / RADIUS) + toward * sin(metres / RADIUS)
    };
    // From the sea, from the outer side of a range; along valleys and shores, whichever way is lowest.
    let along = across.cross(target).normalize();
    let mut rise = |way: DVec3| {
        let steps = (1..=16).map(|step| f64::from(step) / 16.0);
        let ground = steps.map(|share| terrain.elevation(turn(target, way, share * card.back_m)));
        ground.map(|height| height.max(0.0)).fold(0.0, f32::max)
    };
    let ways = match card.aim {
        Aim::Valley | Aim::Place => [along, -along],
        // At eye level from the land.
        Aim::Shore if card.back_m < 1e4 => [-across, (along - across).normalize()],
        Aim::Shore => [across, (across + along).normalize()],
        Aim::Summit => [across, -across],
    };
    let back = if rise(ways[0]) <= rise(ways[1]) {
        ways[0]
    } else {
        ways[1]
    };
    let up = turn(target, back, card.back_m);
    let mut ground = f32::MIN;
    for share in [1.0, 0.97, 0.94, 0.9, 0.85] {
        ground = ground.max(terrain.elevation(turn(target, back, share * card.back_m)));
    }
    let sea_bed = if card.sea { 0.0 } else { -3000.0 };
    let place_m = up
        * (RADIUS + f64::from(card.exaggeration) * f64::from(ground).max(sea_bed) + card.height_m);
    let floor = f64::from(terrain.elevation(target)).max(sea_bed);
    let aimed = target * (RADIUS + f64::from(card.exaggeration) * floor) - place_m;
    let side = up.cross(aimed).normalize();
    let height = card.sun.to_radians();
    let behind = -(aimed - up * aimed.dot(up)).normalize();
    let sun = (side * 0.85 + behind * 0.5).normalize() * cos(height) + up * sin(height);
    let look = Look {
        place_m,
        forward: aimed.normalize(),
        sun,
    };
    Ok((look, target))
}

/// What a landmark has to show: its highest or lowest ground, or the shore.
fn aim(terrain: &mut Terrain, card: &Card, place: DVec3) -> DVec3 {
    let (step_m, wish): (f64, fn(f32) -> f32) = match card.aim {
        Aim::Place => return place,
        Aim::Summit => (3000.0, |height| height),
        Aim::Valley => (
            1500.0,
            |height| if height > 2.0 { -height } else { f32::MIN },
        ),
        Aim::Shore => (3000.0, |height| -height.abs()),
    };
    let mut best = place;
    // Coarse, then fine around what was found.
    for step_m in [step_m, 0.05 * step_m] {
        let (east, north) = east_north(best);
        let around = (-30..=30).flat_map(|y| (-30..=30).map(move |x| (f64::from(x), f64::from(y))));
        let found = around
            .map(|(x, y)| (best + (east * x + north * y) * (step_m / RADIUS)).normalize())
            .map(|place| (wish(terrain.elevation(place)), place))
            .max_by(|a, b| a.0.total_cmp(&b.0));
        best = found.map_or(best, |(_, place)| place);
    }
    best
}
