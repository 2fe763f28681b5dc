//! Sections across the passive margins of a planet: shelf, slope, rise and abyssal plain.
//!
//! `cargo run --release --no-default-features --features export --example passive_margin -- [FILE]`
//!
//! Grows a planet, draws the old margins from which no plate boundary lies near into FILE
//! (`target/passive_margin.svg` by default), and prints their median.

use bevy_tectonics::{prelude::*, simulation::Crust};
use core::ops::ControlFlow;
use glam::{DQuat, DVec3};
use plotters::prelude::*;
use std::{error::Error, io::Write, path::Path};

/// Time at the section in My, long enough for margins of all ages.
const TIME_MY: f64 = 500.0;
/// Reach of a section inland and offshore in km, and its pace.
const INLAND: i32 = 600;
const OFFSHORE: i32 = 1_400;
const PACE: usize = 20;
/// Least age of the floor beside a margin in My.
const OLD: f32 = 60.0;
/// The margin's own direction is that of its surroundings within this distance in km.
const SURROUNDINGS: f64 = 500.0;

fn main() -> Result<(), Box<dyn Error>> {
    let file = std::env::args().nth(1);
    let file = Path::new(file.as_deref().unwrap_or("target/passive_margin.svg"));
    let recipe = Recipe::earth_like(12)
        .with_sub_plates(40_000)
        .with_duration(TIME_MY);
    let mut history = History::new(recipe)?;
    history.run_until(TIME_MY, |_| ControlFlow::Continue(()))?;
    let surface = history.surface()?;
    let sections: Vec<Section> = (0..surface.mesh.vertex_count() as u32)
        .filter_map(|v| Section::across(&surface, v))
        .collect();
    if sections.is_empty() {
        return Err("no passive margin lies far enough from the plates' boundaries".into());
    }
    println!(
        "{} sections; from the edge of the continent, in km:",
        sections.len()
    );
    let bands: Vec<[f64; 3]> = (0..places().count())
        .map(|i| {
            let mut heights: Vec<f64> = sections.iter().map(|section| section.0[i]).collect();
            heights.sort_by(f64::total_cmp);
            [0.1, 0.5, 0.9].map(|share| heights[(share * (heights.len() - 1) as f64) as usize])
        })
        .collect();
    for (far, [_, median, _]) in places().zip(&bands).step_by(5) {
        println!("{far:6} km  {median:6.0} m");
    }
    draw(file, &sections, &bands)?;
    println!("{}", file.display());
    Ok(())
}

/// Distances from the edge in km.
fn places() -> impl Iterator<Item = i32> + Clone {
    (-INLAND..=OFFSHORE).step_by(PACE)
}

/// Elevation in m along a great circle across a margin, at [`places`].
struct Section(Vec<f64>);

impl Section {
    /// The section from a continental sub-plate at old floor of its own plate, if nothing but its continent
    /// lies behind it and nothing but its sea floor before it.
    fn across(surface: &Surface, vertex: u32) -> Option<Self> {
        let v = vertex as usize;
        let passive = surface.mesh.neighbours(vertex).any(|w| {
            let w = w as usize;
            surface.crust[w] == Crust::Oceanic
                && surface.plate[w] == surface.plate[v]
                && surface.age[w] > OLD
        });
        if surface.crust[v] != Crust::Continental || !passive {
            return None;
        }
        let edge = surface.mesh.site(vertex);
        let seaward = seaward(surface, edge)?;
        let axis = edge.cross(seaward);
        let mut heights = Vec::new();
        for far in places() {
            let angle = f64::from(far) / surface.radius_km;
            let place = surface.at(DQuat::from_axis_angle(axis, angle) * edge);
            let kind = if far < 0 {
                Crust::Continental
            } else {
                Crust::Oceanic
            };
            // The edge itself wanders by a cell.
            if place.plate != surface.plate[v] || (far.abs() > 100 && place.crust != kind) {
                return None;
            }
            heights.push(f64::from(place.elevation));
        }
        Some(Self(heights))
    }
}

/// The direction from the land to the sea around a place.
fn seaward(surface: &Surface, edge: DVec3) -> Option<DVec3> {
    let (east, _) = bevy_tectonics::surface::east_north(edge);
    let mut sum = DVec3::ZERO;
    for ring in 1..=5 {
        for spoke in 0..36 {
            let turn = f64::from(spoke * 10).to_radians();
            let towards = DQuat::from_axis_angle(edge, turn) * east;
            let angle = SURROUNDINGS * f64::from(ring) / 5.0 / surface.radius_km;
            let axis = edge.cross(towards);
            let place = surface.at(DQuat::from_axis_angle(axis, angle) * edge);
            if place.crust == Crust::Oceanic {
                sum += towards;
            }
        }
    }
    sum.try_normalize()
}

fn draw(file: &Path, sections: &[Section], bands: &[[f64; 3]]) -> Result<(), Box<dyn Error>> {
    let mut picture = String::new();
    let root = SVGBackend::with_string(&mut picture, (960, 480)).into_drawing_area();
    root.fill(&WHITE)?;
    let mut chart = ChartBuilder::on(&root)
        .caption(
            format!(
                "{} passive margins at {TIME_MY} My: median, and four of five",
                sections.len()
            ),
            ("sans-serif", 18),
        )
        .margin(12)
        .x_label_area_size(36)
        .y_label_area_size(56)
        .build_cartesian_2d(-INLAND..OFFSHORE, -6_000.0..2_000.0)?;
    chart
        .configure_mesh()
        .light_line_style(TRANSPARENT)
        .x_desc("from the edge of the continent, km")
        .y_desc("elevation, m")
        .draw()?;
    let sea = [(-INLAND, 0.0), (OFFSHORE, 0.0)];
    chart.draw_series(LineSeries::new(sea, BLUE.mix(0.4)))?;
    let lower = places().zip(bands).map(|(far, band)| (far, band[0]));
    let upper = places().zip(bands).map(|(far, band)| (far, band[2]));
    let outline: Vec<(i32, f64)> = lower
        .chain(upper.collect::<Vec<_>>().into_iter().rev())
        .collect();
    chart.draw_series([Polygon::new(outline, BLACK.mix(0.12))])?;
    let median = places().zip(bands).map(|(far, band)| (far, band[1]));
    chart.draw_series(LineSeries::new(median, BLACK.stroke_width(2)))?;
    root.present()?;
    drop(chart);
    drop(root);
    // Whole or not at all.
    let folder = file.parent().unwrap_or(Path::new(""));
    std::fs::create_dir_all(folder)?;
    let mut draft = tempfile::NamedTempFile::new_in(folder)?;
    draft.write_all(picture.as_bytes())?;
    draft.persist(file)?;
    Ok(())
}
