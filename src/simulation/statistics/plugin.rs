//! Measuring while a history runs.

use super::{Instruments, Statistics, StatisticsHistory};
use crate::simulation::{
    error::TectonicError,
    schedule::{TectonicStep, TectonicSystems, going, record_failure},
};
use bevy::prelude::*;

/// How often a history is measured, in My. Infinite by default, which is never: a measurement costs
/// about as much as two or three steps, so that one every 10 My would slow a history of 10,000
/// sub-plates by a sixth, and one every 100 My by a sixtieth.
///
/// The first step that reaches a multiple of the interval is measured at its end. It changes nothing
/// about the planet, so it is no part of the recipe: set it on [`StatisticsPlugin`], or in the world of
/// a history at any time. What is no positive number is never, too.
#[derive(Resource, Debug, Clone, Copy, PartialEq, Reflect)]
#[reflect(Resource, Default)]
pub struct StatisticsInterval(pub f64);

impl Default for StatisticsInterval {
    fn default() -> Self {
        Self(f64::INFINITY)
    }
}

impl StatisticsInterval {
    /// Whether anything is to be measured at all.
    pub(in crate::simulation) fn is_set(self) -> bool {
        self.0 > 0.0 && self.0.is_finite()
    }
}

/// Keeps [`Statistics`] and [`StatisticsHistory`] as resources of the simulation's world, measured
/// every [`StatisticsInterval`] after the step's last set.
///
/// ```
/// use bevy::prelude::*;
/// use bevy_tectonics::prelude::*;
/// use bevy_tectonics::simulation::StatisticsPlugin;
///
/// // Planets that keep their figures for every 10 My of their history.
/// let planets = PlanetPlugin::default().with_simulation(|| {
///     SimulationPlugins.build().set(StatisticsPlugin { interval_my: 10.0 })
/// });
/// App::new().add_plugins((MinimalPlugins, planets));
/// ```
#[derive(Debug, Clone, Copy)]
pub struct StatisticsPlugin {
    /// See [`StatisticsInterval`].
    pub interval_my: f64,
}

impl Default for StatisticsPlugin {
    fn default() -> Self {
        Self {
            interval_my: f64::INFINITY,
        }
    }
}

impl Plugin for StatisticsPlugin {
    fn build(&self, app: &mut App) {
        app.register_type::<Statistics>()
            .register_type::<StatisticsHistory>()
            .register_type::<StatisticsInterval>()
            .init_resource::<Statistics>()
            .init_resource::<StatisticsHistory>()
            .insert_resource(StatisticsInterval(self.interval_my))
            .add_systems(
                TectonicStep,
                measure_when_due
                    .pipe(record_failure)
                    .run_if(going)
                    .after(TectonicSystems::Last)
                    // Whatever a game runs without saying when may be seen or not.
                    .ambiguous_with_all(),
            );
    }
}

fn measure_when_due(
    mut instruments: Instruments,
    interval: Res<StatisticsInterval>,
    mut latest: ResMut<Statistics>,
    mut history: ResMut<StatisticsHistory>,
) -> Result<(), TectonicError> {
    let now = instruments.clock.time_my;
    if interval.is_set() && history.is_due(now, interval.0) {
        *latest = instruments.measure(history.before(now))?;
        history.push(&latest);
    }
    Ok(())
}
