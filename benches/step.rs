//! Speed of a step by the number of sub-plates, by stage and by threads: `cargo bench --bench step`
//!
//! Prints Markdown tables. A plain program rather than a statistical benchmark: a step costs milliseconds,
//! steps differ, and what a user waits for is many steps of one history. Every history runs in a process of its
//! own, so that its memory can be told.
//!
//! `-- 40000` leaves out all larger planets, `-- --after 500` measures planets of that age, and
//! `-- --whole` runs 250 My from start to end.

use bevy_tectonics::prelude::*;
use bevy_tectonics::simulation::TectonicSystems;
use clap::Parser;
use std::process::{Command, Stdio};
use std::time::Instant;

const SIZES: [u32; 5] = [2_500, 10_000, 40_000, 160_000, 500_000];
const THREADS: [usize; 2] = [1, 2];
/// Steps before anything is measured: caches fill, first fronts settle.
const WARM_UP: u64 = 20;
/// At least this many steps are measured, so that rows are sorted once ...
const STEPS: u64 = 96;
/// ... and at least this much simulated time in My, so that every slow stage takes its turn.
const TIME_MY: f64 = 8.0;
/// Length of whole histories, in My.
const WHOLE_MY: f64 = 250.0;
const STAGES: usize = TectonicSystems::ALL.len();

#[derive(Parser)]
struct Arguments {
    /// Sub-plates of the largest planet.
    #[arg(default_value_t = u32::MAX)]
    largest: u32,
    /// Age at which planets are measured, in My.
    #[arg(long, default_value_t = 0.0)]
    after: f64,
    /// Runs histories of 250 My from start to end instead, on two threads.
    #[arg(long)]
    whole: bool,
    /// Seed of the planets.
    #[arg(long, default_value_t = 1)]
    seed: u64,
    /// Measures one planet on so many threads and prints bare numbers.
    #[arg(long, hide = true)]
    threads: Option<usize>,
    /// Given by cargo.
    #[arg(long, hide = true)]
    bench: bool,
}

/// What one history cost.
#[derive(Default)]
struct Cost {
    sub_plates: u32,
    threads: usize,
    start_seconds: f64,
    /// Whole time but for the start.
    seconds: f64,
    steps: f64,
    time_my: f64,
    median_ms: f64,
    worst_ms: f64,
    /// Highest use of memory in bytes; 0 where the system does not tell.
    peak_bytes: f64,
    stage_seconds: [f64; STAGES],
}

impl Cost {
    fn measure(arguments: &Arguments, threads: usize) -> Result<Self, TectonicError> {
        let recipe = Recipe::earth_like(arguments.seed)
            .with_sub_plates(arguments.largest)
            .with_duration(10_000.0);
        let begin = Instant::now();
        let mut history = History::with_threads(recipe, threads)?;
        let start_seconds = begin.elapsed().as_secs_f64();
        let warm_up = if arguments.whole { 0 } else { WARM_UP };
        while history.steps() < warm_up || history.time_my() < arguments.after {
            history.step()?;
        }
        let (first, first_my) = (history.steps(), history.time_my());
        let before = history.stage_seconds();
        let mut steps_ms = Vec::new();
        loop {
            let (steps, time_my) = (history.steps() - first, history.time_my() - first_my);
            let done = if arguments.whole {
                time_my >= WHOLE_MY
            } else {
                steps >= STEPS && time_my >= TIME_MY
            };
            if done {
                break;
            }
            let begin = Instant::now();
            history.step()?;
            steps_ms.push(1e3 * begin.elapsed().as_secs_f64());
        }
        let mut stage_seconds = [0.0; STAGES];
        let stages = history.stage_seconds().into_iter().zip(before);
        for (seconds, ((_, after), (_, before))) in stage_seconds.iter_mut().zip(stages) {
            *seconds = after - before;
        }
        let seconds = steps_ms.iter().sum::<f64>() / 1e3;
        steps_ms.sort_by(f64::total_cmp);
        Ok(Self {
            sub_plates: arguments.largest,
            threads,
            start_seconds,
            seconds,
            steps: steps_ms.len() as f64,
            time_my: history.time_my() - first_my,
            median_ms: steps_ms[steps_ms.len() / 2],
            worst_ms: steps_ms[steps_ms.len() - 1],
            peak_bytes: peak_bytes().unwrap_or(0.0),
            stage_seconds,
        })
    }

    /// Measures in a process of its own.
    fn of(arguments: &Arguments, sub_plates: u32, threads: usize) -> Option<Self> {
        let mut command = Command::new(std::env::current_exe().ok()?);
        command
            .arg(sub_plates.to_string())
            .args(["--threads", &threads.to_string()])
            .args(["--seed", &arguments.seed.to_string()])
            .args(["--after", &arguments.after.to_string()])
            .stderr(Stdio::inherit());
        if arguments.whole {
            command.arg("--whole");
        }
        let output = command.output().ok()?;
        let text = String::from_utf8(output.stdout).ok()?;
        let numbers: Vec<f64> = text.split_whitespace().flat_map(str::parse).collect();
        let mut cost = Self {
            sub_plates,
            threads,
            ..Self::default()
        };
        let fields = cost.numbers();
        if fields.len() != numbers.len() {
            return None;
        }
        for (field, number) in fields.into_iter().zip(numbers) {
            *field = number;
        }
        Some(cost)
    }

    /// What one process tells another, in this order.
    fn numbers(&mut self) -> Vec<&mut f64> {
        let mut numbers = vec![
            &mut self.start_seconds,
            &mut self.seconds,
            &mut self.steps,
            &mut self.time_my,
            &mut self.median_ms,
            &mut self.worst_ms,
            &mut self.peak_bytes,
        ];
        numbers.extend(&mut self.stage_seconds);
        numbers
    }

    fn ns_per_sub_plate(&self, seconds: f64) -> f64 {
        1e9 * seconds / self.steps / f64::from(self.sub_plates)
    }

    fn print_row(&self) {
        println!(
            "| {} | {} | {:.2} | {} | {:.1} | {:.2} | {:.2} | {:.1} | {:.0} | {:.1} | {:.1} | {:.0} | {:.0} |",
            self.sub_plates,
            self.threads,
            self.start_seconds,
            self.steps,
            self.time_my,
            self.median_ms,
            1e3 * self.seconds / self.steps,
            self.worst_ms,
            self.ns_per_sub_plate(self.seconds),
            1e3 * self.seconds / self.time_my,
            self.start_seconds + self.seconds,
            self.peak_bytes / 1e6,
            self.peak_bytes / f64::from(self.sub_plates),
        );
    }
}

/// Highest use of memory of this process so far, where the system tells.
fn peak_bytes() -> Option<f64> {
    let status = std::fs::read_to_string("/proc/self/status").ok()?;
    let line = status.lines().find(|line| line.starts_with("VmHWM:"))?;
    let kib: f64 = line.split_whitespace().nth(1)?.parse().ok()?;
    Some(1024.0 * kib)
}

fn main() -> Result<(), TectonicError> {
    let arguments = Arguments::parse();
    if let Some(threads) = arguments.threads {
        for number in Cost::measure(&arguments, threads)?.numbers() {
            println!("{number}");
        }
        return Ok(());
    }
    let threads = if arguments.whole {
        &THREADS[1..]
    } else {
        &THREADS[..]
    };
    let mut costs = Vec::new();
    println!(
        "| sub-plates | threads | start, s | steps | My | median, ms a step | mean | worst | ns per sub-plate and step | ms per My | s in all | peak MB | bytes per sub-plate |\n|{}",
        "--:|".repeat(13)
    );
    for size in SIZES.into_iter().filter(|&size| size <= arguments.largest) {
        for &threads in threads {
            if let Some(cost) = Cost::of(&arguments, size, threads) {
                cost.print_row();
                costs.push(cost);
            }
        }
    }

    println!("\nNanoseconds per sub-plate and step by stage, and the stage's share:\n");
    print!("| stage |");
    for cost in &costs {
        print!(" {} × {} |", cost.sub_plates, cost.threads);
    }
    println!("\n|---|{}", "--:|".repeat(costs.len()));
    for (row, stage) in TectonicSystems::ALL.into_iter().enumerate() {
        // The first and the last are empty: they are the users'.
        if matches!(stage, TectonicSystems::First | TectonicSystems::Last) {
            continue;
        }
        print!("| {} |", stage.name());
        for cost in &costs {
            let seconds = cost.stage_seconds[row];
            print!(
                " {:.0} ({:.0} %) |",
                cost.ns_per_sub_plate(seconds),
                100.0 * seconds / cost.seconds
            );
        }
        println!();
    }
    Ok(())
}
