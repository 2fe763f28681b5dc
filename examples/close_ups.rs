//! From a continent to a hillside: places that the program picks by itself, each in four steps of distance.
//! `cargo run --release --example close_ups [-- --seed 206 close_ups.png]`
//!
//! A row each for the highest young range between continents, the highest over a trench, the highest old one, a
//! plain, a volcanic island, young sea floor, and a coast; from left to right 400, 60, 8 and 1 km across.

use bevy_tectonics::prelude::*;
use bevy_tectonics::simulation::{Crust, Orogeny, Surface};
use bevy_tectonics::surface::{Landmark, Terrain, east_north};
use clap::Parser;
use core::ops::ControlFlow;
use glam::{DVec3, Vec3};
use indicatif::ProgressBar;
use png::{BitDepth, ColorType, Encoder};
use std::{error::Error, fs::File, io::BufWriter, path::PathBuf};

/// Width of a picture in pixels.
const SIDE: usize = 480;
/// How far pictures reach, in km, and how much slopes are exaggerated in their shades.
const STEPS: [(f64, f32); 4] = [(400.0, 2.5), (60.0, 1.2), (8.0, 1.0), (1.0, 1.0)];

#[derive(Parser)]
struct Arguments {
    /// The planet's seed.
    #[arg(long, default_value_t = 206)]
    seed: u64,
    /// Number of sub-plates.
    #[arg(long, default_value_t = 40_000)]
    sub_plates: u32,
    /// Length of the history in My.
    #[arg(long, default_value_t = 300.0)]
    duration: f64,
    /// The picture.
    #[arg(default_value = "target/close_ups.png")]
    out: PathBuf,
}

/// Places worth a look, and what they are called.
fn places(surface: &Surface) -> Result<Vec<(&'static str, DVec3)>, Box<dyn Error>> {
    let highest = |is: &dyn Fn(usize) -> bool| {
        let rows = (0..surface.elevation.len()).filter(|&v| is(v));
        let best = rows.max_by(|&a, &b| surface.elevation[a].total_cmp(&surface.elevation[b]));
        best.map(|v| surface.mesh.site(v as u32))
    };
    let is_plain = |v: usize| {
        let flat = |v: usize| {
            (150.0..450.0).contains(&surface.elevation[v]) && surface.orogeny[v] == Orogeny::None
        };
        flat(v) && surface.mesh.neighbours(v as u32).all(|w| flat(w as usize))
    };
    let is_ridge = |v: usize| {
        surface.crust[v] == Crust::Oceanic
            && (2.0..12.0).contains(&surface.age[v])
            && surface.elevation[v] < -2400.0
    };
    let known = |landmark| surface.landmark(landmark).map(|(place, _)| place);
    let found = [
        ("range between continents", known(Landmark::HighestRange)),
        ("range over a trench", known(Landmark::Cordillera)),
        ("old range", known(Landmark::OldestRange)),
        ("plain", highest(&is_plain)),
        ("volcanic island", known(Landmark::VolcanicIsland)),
        ("young sea floor", highest(&is_ridge)),
    ];
    let found = found.into_iter();
    let mut places: Vec<_> = found
        .filter_map(|(name, place)| Some((name, place?)))
        .collect();
    let coast = surface
        .coasts()
        .find(|&v| surface.elevation[v as usize] > 60.0);
    places.extend(coast.map(|v| ("coast", surface.mesh.site(v))));
    // Terrain lies up to 150 km from the sub-plates that it follows.
    for (name, place) in &mut places {
        let mut terrain = Terrain::new(surface, 2000.0)?;
        let (east, north) = east_north(*place);
        let around = (-40..=40).flat_map(|y| (-40..=40).map(move |x| (f64::from(x), f64::from(y))));
        let around = around.map(|(x, y)| {
            let offset = (east * x + north * y) * (4.0 / surface.radius_km);
            (*place + offset).normalize()
        });
        let mut wish = |place: DVec3| match *name {
            "coast" => -terrain.elevation(place).abs(),
            _ => terrain.elevation(place),
        };
        if !["plain", "young sea floor"].contains(name) {
            let best = around.map(|place| (wish(place), place));
            let best = best.max_by(|a, b| a.0.total_cmp(&b.0));
            *place = best.map_or(*place, |(_, place)| place);
        }
    }
    Ok(places)
}

/// A map of a square, lit from the north west.
fn draw(
    surface: &Surface,
    middle: DVec3,
    km: f64,
    exaggeration: f32,
) -> Result<Vec<[u8; 3]>, Box<dyn Error>> {
    let step_m = 1000.0 * km / SIDE as f64;
    let mut terrain = Terrain::new(surface, step_m)?;
    let (east, north) = east_north(middle);
    let pixels = (0..SIDE * SIDE).map(|i| {
        let across =
            |i: usize| (i as f64 + 0.5 - 0.5 * SIDE as f64) * step_m / (1000.0 * surface.radius_km);
        let place = (middle + east * across(i % SIDE) - north * across(i / SIDE)).normalize();
        let sample = terrain.sample(place);
        let slope = |axis: DVec3| {
            exaggeration * (sample.normal.dot(axis) / sample.normal.dot(place)) as f32
        };
        let normal = Vec3::new(slope(east), slope(north), 1.0).normalize();
        let light = normal.dot(Vec3::new(-0.5, 0.5, 0.7).normalize()).max(0.08) / 0.7;
        let height = sample.elevation;
        let colour = if height < 0.0 {
            Vec3::new(0.12, 0.27, 0.42).lerp(
                Vec3::new(0.48, 0.68, 0.78),
                (1.0 + height / 4500.0).clamp(0.0, 1.0),
            )
        } else {
            let green = Vec3::new(0.44, 0.55, 0.34)
                .lerp(Vec3::new(0.66, 0.58, 0.44), (height / 1800.0).min(1.0));
            green.lerp(
                Vec3::splat(0.88),
                ((height - 1800.0) / 3500.0).clamp(0.0, 1.0),
            )
        };
        (colour * light * 255.0)
            .to_array()
            .map(|channel| channel.clamp(0.0, 255.0) as u8)
    });
    Ok(pixels.collect())
}

fn main() -> Result<(), Box<dyn Error>> {
    let arguments = Arguments::parse();
    let recipe = Recipe::earth_like(arguments.seed)
        .with_sub_plates(arguments.sub_plates)
        .with_duration(arguments.duration);
    let mut history = History::new(recipe)?;
    let bar = ProgressBar::new(arguments.duration as u64);
    history.run_until(arguments.duration, |progress| {
        bar.set_position(progress.time_my as u64);
        ControlFlow::Continue(())
    })?;
    bar.finish_and_clear();
    let surface = history.surface()?;
    let places = places(&surface)?;
    let width = STEPS.len() * SIDE;
    let mut sheet = vec![0_u8; 3 * width * SIDE * places.len()];
    for (row, (name, middle)) in places.iter().enumerate() {
        let (latitude, longitude) = bevy_tectonics::surface::lat_lon(*middle);
        println!(
            "row {}: {name}, at {latitude:.1}°, {longitude:.1}°",
            row + 1
        );
        for (column, (km, exaggeration)) in STEPS.into_iter().enumerate() {
            for (i, pixel) in draw(&surface, *middle, km, exaggeration)?
                .into_iter()
                .enumerate()
            {
                let at = (row * SIDE + i / SIDE) * width + column * SIDE + i % SIDE;
                sheet[3 * at..3 * at + 3].copy_from_slice(&pixel);
            }
        }
    }
    if let Some(folder) = arguments.out.parent() {
        std::fs::create_dir_all(folder)?;
    }
    let file = BufWriter::new(File::create(&arguments.out)?);
    let mut encoder = Encoder::new(file, width as u32, (SIDE * places.len()) as u32);
    encoder.set_color(ColorType::Rgb);
    encoder.set_depth(BitDepth::Eight);
    encoder.write_header()?.write_image_data(&sheet)?;
    println!("{}", arguments.out.display());
    Ok(())
}
