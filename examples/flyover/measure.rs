//! What the flight costs.

use crate::{Arguments, Flight, off_screen::tiles};
use bevy::{
    diagnostic::DiagnosticsStore,
    prelude::*,
    render::{render_resource::PollType, renderer::RenderDevice},
};
use bevy_tectonics::render::TilesDrawn;
use std::{collections::BTreeMap, time::Instant};

/// Altitudes in m above which the flight's stretches are.
const STRETCHES: [(&str, f64); 4] = [
    ("above 1,000 km", 1e6),
    ("100 to 1,000 km", 1e5),
    ("1 to 100 km", 1e3),
    ("below 1 km", 0.0),
];

/// What one frame costs in ms, and what Bevy's diagnostics say of the GPU's part.
struct Cost {
    all: f64,
    submitted: f64,
    stretch: usize,
    gpu: Vec<(String, f64)>,
}

/// The flight in real time: what each frame costs, from its first system to its last pixel.
pub fn measure(app: &mut App, arguments: &Arguments) {
    let device = app.world().get_resource::<RenderDevice>().cloned();
    let start = Instant::now();
    let mut costs = Vec::new();
    let (mut late_s, mut most) = (0.0_f32, TilesDrawn::default());
    loop {
        let progress = start.elapsed().as_secs_f64() / arguments.seconds.max(1.0);
        if progress > 1.0 {
            break;
        }
        let mut flight = app.world_mut().resource_mut::<Flight>();
        flight.progress = progress;
        let altitude = flight.pose().map_or(0.0, |(.., altitude)| altitude);
        let frame = Instant::now();
        app.update();
        let submitted = 1000.0 * frame.elapsed().as_secs_f64();
        if let Some(device) = &device {
            // Frames would pile up on the GPU.
            let _ = device.poll(PollType::wait_indefinitely());
        }
        costs.push(Cost {
            all: 1000.0 * frame.elapsed().as_secs_f64(),
            submitted,
            stretch: STRETCHES
                .iter()
                .position(|&(_, least)| altitude >= least)
                .unwrap_or_default(),
            gpu: on_the_gpu(app),
        });
        let tiles = tiles(app);
        late_s = late_s.max(tiles.late_s);
        if tiles.drawn > most.drawn {
            most = tiles;
        }
    }
    let seconds = start.elapsed().as_secs_f64();
    let made = tiles(app).made;
    let frames = costs.len();
    println!(
        "| {} x {}, {frames} frames, ms | median | 95 % | 99 % | worst |",
        arguments.width, arguments.height
    );
    println!("|---|--:|--:|--:|--:|");
    row("in all", costs.iter().map(|cost| cost.all));
    row(
        "until handed to the GPU",
        costs.iter().map(|cost| cost.submitted),
    );
    for (stretch, (name, _)) in STRETCHES.iter().enumerate() {
        let there = costs.iter().filter(|cost| cost.stretch == stretch);
        row(name, there.map(|cost| cost.all));
    }
    for (stretch, (name, _)) in STRETCHES.iter().enumerate() {
        let mut passes = BTreeMap::<&str, Vec<f64>>::new();
        for cost in costs.iter().filter(|cost| cost.stretch == stretch) {
            for (pass, value) in &cost.gpu {
                passes.entry(pass).or_default().push(*value);
            }
        }
        let passes = passes.into_iter().map(|(pass, mut values)| {
            values.sort_by(f64::total_cmp);
            format!("{pass} {:.2}", values[values.len() / 2])
        });
        let passes: Vec<String> = passes.collect();
        if !passes.is_empty() {
            println!("{name}, medians on the GPU: {}", passes.join(", "));
        }
    }
    println!(
        "{:.1} frames a second, {made} tiles made, {:.0} a second",
        frames as f64 / seconds,
        f64::from(made) / seconds
    );
    println!(
        "at most {} tiles drawn, {:.1} million triangles, {} kept; in view, the latest came {late_s:.2} s late",
        most.drawn,
        f64::from(most.triangles) * 1e-6,
        most.kept
    );
}

/// A row of the table.
fn row(name: &str, times: impl Iterator<Item = f64>) {
    let mut times: Vec<f64> = times.collect();
    times.sort_by(f64::total_cmp);
    let Some(last) = times.len().checked_sub(1) else {
        return;
    };
    let at = |share: f64| times[((times.len() as f64 * share) as usize).min(last)];
    println!(
        "| {name} | {:.1} | {:.1} | {:.1} | {:.1} |",
        at(0.5),
        at(0.95),
        at(0.99),
        at(1.0)
    );
}

/// Milliseconds of passes, and millions of times that shaders ran in them, where the GPU counts.
fn on_the_gpu(app: &App) -> Vec<(String, f64)> {
    let Some(diagnostics) = app.world().get_resource::<DiagnosticsStore>() else {
        return Vec::new();
    };
    let mut found = BTreeMap::<String, f64>::new();
    for diagnostic in diagnostics.iter() {
        let (mut names, value) = (diagnostic.path().components(), diagnostic.value());
        let (Some("render"), Some(value)) = (names.next(), value) else {
            continue;
        };
        let names: Vec<&str> = names.collect();
        let [pass, .., what] = names[..] else {
            continue;
        };
        // One for each cascade of each sun.
        let pass = if pass.contains("shadow") {
            "shadows"
        } else {
            pass
        };
        let (unit, scale) = match what {
            "elapsed_gpu" => ("ms", 1.0),
            "vertex_shader_invocations" => ("million vertices", 1e-6),
            "fragment_shader_invocations" => ("million pixels", 1e-6),
            _ => continue,
        };
        *found.entry(format!("{pass} {unit}")).or_default() += scale * value;
    }
    found.into_iter().collect()
}
