//! Speed of a step by the number of sub-plates, by stage and by threads. Prints Markdown tables.
//!
//! A plain program rather than a statistical benchmark: a step costs milliseconds to seconds, and the
//! mean over many steps of one history is what a user waits for.

use bevy_tectonics::prelude::*;
use bevy_tectonics::simulation::TectonicSystems;
use std::time::Instant;

const SIZES: [u32; 4] = [2_500, 10_000, 40_000, 160_000];
const THREADS: [usize; 2] = [1, 2];
/// Steps before anything is measured: caches fill, first fronts settle.
const WARM_UP: u64 = 20;
/// At least this many steps are measured, so that every slow stage takes its turn several times ...
const STEPS: u64 = 40;
/// ... and at least this much simulated time, in My.
const TIME_MY: f64 = 8.0;
/// Measurements of all statistics.
const MEASUREMENTS: u32 = 10;

/// What one history cost.
struct Cost {
    sub_plates: u32,
    threads: usize,
    steps: u64,
    time_my: f64,
    seconds: f64,
    /// Of one measurement of all statistics.
    measurement: f64,
    stages: Vec<(&'static str, f64)>,
}

fn measure(sub_plates: u32, threads: usize) -> Result<Cost, TectonicError> {
    let recipe = Recipe::earth_like(1)
        .with_sub_plates(sub_plates)
        .with_duration(1_000.0);
    let mut history = History::with_threads(recipe, threads)?;
    while history.steps() < WARM_UP {
        history.step()?;
    }
    let (steps, time_my) = (history.steps(), history.time_my());
    let before = history.stage_seconds();
    let start = Instant::now();
    while history.steps() < steps + STEPS || history.time_my() < time_my + TIME_MY {
        history.step()?;
    }
    let seconds = start.elapsed().as_secs_f64();
    let stages = history.stage_seconds();
    let start = Instant::now();
    for _ in 0..MEASUREMENTS {
        history.statistics()?;
    }
    let measurement = start.elapsed().as_secs_f64() / f64::from(MEASUREMENTS);
    Ok(Cost {
        sub_plates,
        threads,
        steps: history.steps() - steps,
        time_my: history.time_my() - time_my,
        seconds,
        measurement,
        stages: stages
            .into_iter()
            .zip(before)
            .map(|((name, after), (_, before))| (name, after - before))
            .collect(),
    })
}

fn main() -> Result<(), TectonicError> {
    let largest = std::env::args()
        .filter_map(|argument| argument.parse().ok())
        .next_back()
        .unwrap_or(u32::MAX);
    let mut costs = Vec::new();
    for size in SIZES.into_iter().filter(|&size| size <= largest) {
        for threads in THREADS {
            eprintln!("{size} sub-plates on {threads} threads");
            costs.push(measure(size, threads)?);
        }
    }

    println!(
        "| sub-plates | threads | steps | My | ms per step | µs per sub-plate and step | s per 100 My | ms per statistics |"
    );
    println!("|--:|--:|--:|--:|--:|--:|--:|--:|");
    for cost in &costs {
        let step = cost.seconds / cost.steps as f64;
        println!(
            "| {} | {} | {} | {:.1} | {:.2} | {:.3} | {:.1} | {:.2} |",
            cost.sub_plates,
            cost.threads,
            cost.steps,
            cost.time_my,
            1e3 * step,
            1e6 * step / f64::from(cost.sub_plates),
            100.0 * cost.seconds / cost.time_my,
            1e3 * cost.measurement
        );
    }
    println!("\nMilliseconds per step by stage:\n");
    print!("| stage |");
    for cost in &costs {
        print!(" {} × {} |", cost.sub_plates, cost.threads);
    }
    println!("\n|---|{}", "--:|".repeat(costs.len()));
    for stage in TectonicSystems::ALL {
        let name = stage.name();
        print!("| {name} |");
        for cost in &costs {
            let seconds: f64 = cost
                .stages
                .iter()
                .filter(|(stage, _)| *stage == name)
                .map(|(_, seconds)| seconds)
                .sum();
            print!(" {:.3} |", 1e3 * seconds / cost.steps as f64);
        }
        println!();
    }
    Ok(())
}
