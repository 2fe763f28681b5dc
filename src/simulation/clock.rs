//! Simulated time. Never the clock on the wall.

use super::{constants::StepConstants, recipe::Recipe};
use bevy::prelude::*;

/// Where the history stands.
#[derive(Resource, Debug, Clone, Default, PartialEq, Reflect)]
#[reflect(Resource)]
pub struct Clock {
    /// Time since the start in My.
    pub time_my: f64,
    /// Length of the present step in My.
    pub step_my: f64,
    /// Steps begun.
    pub steps: u64,
    /// Fastest sub-plate of the last step in km/My; the next step's length follows from it.
    pub fastest: f64,
    /// A step does not pass this time, in My, while it lies ahead.
    pub stop_at_my: f64,
    /// Slow stages that are due in this step, with the time since they last ran.
    pub geology: Tick,
    /// Reorganisation of plates.
    pub reorganisation: Tick,
    /// Refinement.
    pub refinement: Tick,
}

/// A slow clock: runs once its interval has gone by.
#[derive(Debug, Clone, Copy, Default, PartialEq, Reflect)]
pub struct Tick {
    waited: f64,
    due: Option<f64>,
}

impl Tick {
    fn advance(&mut self, step: f64, interval: f64, last: bool) {
        self.waited += step;
        self.due = (self.waited >= interval || last).then_some(self.waited);
        if self.due.is_some() {
            self.waited = 0.0;
        }
    }

    /// Time in My that the stage has to make up for in this step, if it is due.
    #[must_use]
    pub fn due(&self) -> Option<f64> {
        self.due
    }
}

impl Clock {
    /// Starts the next step: its length follows from the spacing and the fastest sub-plate.
    pub fn begin_step(&mut self, recipe: &Recipe) {
        let StepConstants {
            courant,
            longest,
            geology,
            reorganisation,
        } = recipe.constants.step;
        // The finest cells of an uneven mesh are the nominal ones; dull ones are coarser.
        let reach = courant * recipe.spacing_km();
        let free = (reach / self.fastest.max(1.0)).min(longest);
        let left = if self.stop_at_my > self.time_my {
            self.stop_at_my - self.time_my
        } else {
            f64::INFINITY
        };
        // Land on the end exactly, without a last step of almost nothing.
        let last = left <= free * 1.000_001;
        self.step_my = if last {
            left
        } else if left < 2.0 * free {
            0.5 * left
        } else {
            free
        };
        self.time_my = if last {
            self.stop_at_my
        } else {
            self.time_my + self.step_my
        };
        self.steps += 1;
        // The finished planet shows the heights of its last moment.
        let end = self.time_my >= recipe.duration_my && last;
        self.geology.advance(self.step_my, geology, end);
        self.reorganisation
            .advance(self.step_my, reorganisation, false);
        self.refinement
            .advance(self.step_my, recipe.constants.refine.interval, false);
    }
}
