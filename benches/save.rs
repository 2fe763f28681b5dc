//! What saves cost: bytes for each sub-plate, seconds to write and to read.
//!
//! ```text
//! cargo bench --no-default-features --features save --bench save -- 10000 40000
//! ```
//!
//! Grows planets of so many sub-plates for `--after` My (by default 500) on two threads, then saves and loads
//! them eight times over the 32 steps between two sortings of their rows, as saves grow from one to the next.

use bevy_tectonics::{prelude::*, save};
use clap::Parser;
use core::ops::ControlFlow;
use std::{error::Error, time::Instant};

#[derive(Parser)]
struct Flags {
    /// Numbers of sub-plates
    #[arg(default_values_t = [10_000, 40_000, 160_000, 500_000])]
    sub_plates: Vec<u32>,

    /// Age of the planets, in My
    #[arg(long, default_value_t = 500.0)]
    after: f64,

    /// What `cargo bench` passes on
    #[arg(long, hide = true)]
    bench: bool,
}

fn main() -> Result<(), Box<dyn Error>> {
    let flags = Flags::parse();
    println!("| sub-plates | bytes for each | s to save | s to load |");
    println!("|--:|--:|--:|--:|");
    for sub_plates in flags.sub_plates {
        let recipe = Recipe::earth_like(3)
            .with_sub_plates(sub_plates)
            .with_duration(10_000.0);
        let mut history = History::with_threads(recipe, 2)?;
        history.run_until(flags.after, |_| ControlFlow::Continue(()))?;
        let (mut sizes, mut saving, mut loading) = (Vec::new(), Vec::new(), Vec::new());
        for _ in 0..8 {
            for _ in 0..4 {
                history.step()?;
            }
            let start = Instant::now();
            let bytes = save::to_bytes(&mut history)?;
            saving.push(start.elapsed().as_secs_f64());
            let start = Instant::now();
            let mut loaded = save::from_bytes(&bytes, SimulationPlugins)?;
            loading.push(start.elapsed().as_secs_f64());
            sizes.push(bytes.len() as f64 / loaded.checkpoint()?.sub_plates() as f64);
        }
        for series in [&mut sizes, &mut saving, &mut loading] {
            series.sort_by(f64::total_cmp);
        }
        println!(
            "| {sub_plates} | {:.1} to {:.1} | {:.2} | {:.2} |",
            sizes[0], sizes[7], saving[4], loading[4]
        );
    }
    Ok(())
}
