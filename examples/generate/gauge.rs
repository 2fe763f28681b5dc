//! How far a long run has come.

use bevy_tectonics::simulation::Progress;
use indicatif::{ProgressBar, ProgressStyle};
use std::io::{IsTerminal, stderr};

/// Progress on stderr: a bar in a terminal, otherwise a line every tenth.
pub enum Gauge {
    Nothing,
    Bar(ProgressBar),
    Lines { tenths: u32 },
}

impl Gauge {
    pub fn new(quiet: bool, duration_my: f64) -> Self {
        if quiet {
            return Self::Nothing;
        }
        if !stderr().is_terminal() {
            return Self::Lines { tenths: 0 };
        }
        let template = "{bar:40} {percent:>3} %  {msg}  {elapsed} gone, {eta} to go";
        let style =
            ProgressStyle::with_template(template).unwrap_or_else(|_| ProgressStyle::default_bar());
        let bar = ProgressBar::new(1000).with_style(style);
        bar.set_message(format!("0 of {duration_my:.0} My"));
        Self::Bar(bar)
    }

    pub fn show(&mut self, progress: &Progress) {
        let place = || {
            format!(
                "{:.0} of {:.0} My, step {}",
                progress.time_my, progress.end_my, progress.steps
            )
        };
        match self {
            Self::Nothing => {}
            Self::Bar(bar) => {
                bar.set_message(place());
                bar.set_position((progress.fraction * 1000.0) as u64);
            }
            Self::Lines { tenths } => {
                let reached = (progress.fraction * 10.0) as u32;
                if reached > *tenths {
                    *tenths = reached;
                    eprintln!("{} %: {}", reached * 10, place());
                }
            }
        }
    }

    pub fn finish(&self) {
        if let Self::Bar(bar) = self {
            bar.finish_and_clear();
        }
    }
}
