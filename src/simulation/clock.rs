//! Simulated time. Never the clock on the wall.

use super::{constants::StepConstants, events::TectonicEvent, recipe::Recipe};
use bevy::prelude::*;
use serde::{Deserialize, Serialize};

/// Intervals that follow from how far crust moves in them are stated for this spacing, in km.
const SPACING: f64 = 226.0;

/// Where the history stands.
#[derive(Resource, Debug, Clone, Default, PartialEq, Serialize, Deserialize, Reflect)]
#[reflect(Resource)]
pub struct Clock {
    /// Time since the start in My.
    pub time_my: f64,
    /// When the present step began, in My.
    pub began_my: f64,
    /// Length of the present step in My.
    pub step_my: f64,
    /// Steps begun.
    pub steps: u64,
    /// Fastest sub-plate of the last step in km/My; the next step's length follows from it.
    pub fastest: f64,
    /// A step does not pass this time, in My, while it lies ahead.
    pub stop_at_my: f64,
    /// How many of the recipe's events have had their time.
    pub events_done: usize,
    /// Slow stages that are due in this step, with the time since they last ran.
    pub geology: Tick,
    /// Reorganisation of plates.
    pub reorganisation: Tick,
    /// Refinement.
    pub refinement: Tick,
    /// Bending of the margins.
    pub margins: Tick,
}

/// Steps between two sortings of the rows. In one, fronts cross a third of a cell: in 32, ten rows of cells
/// along every ridge are new. Three times as long costs 7 % at 500,000 sub-plates.
pub(super) const SORTING: u64 = 32;

/// How late slow work may come because it makes way for other slow work, as a share of its interval: steps on
/// fine meshes are a fraction of that, and none does everything.
const PATIENCE: f64 = 0.25;

/// A slow clock: runs once its interval has gone by.
#[derive(Debug, Clone, Copy, Default, PartialEq, Serialize, Deserialize, Reflect)]
pub struct Tick {
    waited: f64,
    due: Option<f64>,
}

impl Tick {
    /// A clock that has already waited for a part of its interval.
    pub(super) fn after(waited: f64) -> Self {
        Self { waited, due: None }
    }

    fn advance(&mut self, step: f64, interval: f64, last: bool) {
        self.waited += step;
        self.due = (self.waited >= interval || last).then_some(self.waited);
        if self.due.is_some() {
            self.waited = 0.0;
        }
    }

    /// Like [`advance`](Self::advance), but makes way in a step that is `busy` if the next, as long as this one, is
    /// early enough.
    fn advance_unless(&mut self, busy: bool, step: f64, interval: f64) {
        let latest = (1.0 + PATIENCE) * interval;
        let waits = busy && self.waited + 2.0 * step <= latest;
        let interval = if waits { f64::INFINITY } else { interval };
        self.advance(step, interval, false);
    }

    /// Time in My since the stage was last due.
    #[cfg(feature = "save")]
    pub(crate) fn waited(&self) -> f64 {
        self.waited
    }

    /// Time in My that the stage has to make up for in this step, if it is due.
    #[must_use]
    pub fn due(&self) -> Option<f64> {
        self.due
    }
}

impl Clock {
    /// Whether rows are sorted in this step.
    pub(super) fn is_sorting(&self) -> bool {
        self.steps.is_multiple_of(SORTING)
    }

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
        let due = recipe
            .events
            .iter()
            .skip(self.events_done)
            .take_while(|event| event.at_my <= self.time_my);
        let (events, fastest) = due.fold((0, self.fastest), |(count, fastest), event| {
            (count + 1, fastest.max(event.what.speed(recipe.radius_km)))
        });
        let free = (reach / fastest.max(1.0)).min(longest);
        let stop = recipe
            .events
            .iter()
            .flat_map(TectonicEvent::stops)
            .chain([self.stop_at_my])
            .filter(|&stop| stop > self.time_my)
            .fold(f64::INFINITY, f64::min);
        let left = stop - self.time_my;
        // Land on the end exactly, without a last step of almost nothing.
        let last = left <= free * 1.000_001;
        self.step_my = if last {
            left
        } else if left < 2.0 * free {
            0.5 * left
        } else {
            free
        };
        self.began_my = self.time_my;
        self.time_my = if last {
            stop
        } else {
            self.time_my + self.step_my
        };
        self.steps += 1;
        // The finished planet shows the heights of its last moment.
        let end = self.time_my >= recipe.duration_my && self.time_my == self.stop_at_my;
        // What events did shows at once.
        self.geology
            .advance(self.step_my, geology, end || events > 0);
        let is_next_free = self.geology.waited + self.step_my < geology;
        let busy = is_next_free && (self.geology.due.is_some() || self.is_sorting());
        self.reorganisation
            .advance_unless(busy, self.step_my, reorganisation);
        let scale = (recipe.spacing_km() / SPACING).min(1.0);
        let bending = recipe.constants.margins.interval * scale;
        self.margins.advance(self.step_my, bending, false);
        let refinement = recipe.constants.refine.interval * scale;
        self.refinement.advance(self.step_my, refinement, false);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Times at which work with an interval of 4 My is due where others are in every second step.
    fn due(step: f64) -> Vec<f64> {
        let mut tick = Tick::default();
        let steps = (1..=(24.0 / step) as u32).filter(|&i| {
            tick.advance_unless(i % 2 == 0, step, 4.0);
            tick.due().is_some()
        });
        steps.map(|i| f64::from(i) * step).collect()
    }

    #[test]
    fn slow_work_makes_way_but_is_never_late_by_more_than_a_quarter() {
        assert_eq!(due(0.5), [4.5, 8.5, 12.5, 16.5, 20.5]);
        assert_eq!(due(1.0), [5.0, 9.0, 13.0, 17.0, 21.0]);
        // The next step would come too late.
        assert_eq!(due(2.0), [4.0, 8.0, 12.0, 16.0, 20.0, 24.0]);
    }
}
