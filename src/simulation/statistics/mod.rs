//! What a planet measures, in the terms in which Earth is measured.
//!
//! | file | measures |
//! |---|---|
//! | `ground.rs` | heights and crust |
//! | `coast.rs`, `spectrum.rs` | how rough the coast and the ground are |
//! | `floor.rs` | depth, age and turnover of the sea floor |
//! | `plates.rs` | sizes and speeds of plates |
//! | `boundaries.rs` | lengths, slip and turnover of boundaries |
//! | `table.rs` | all of them, with units and Earth's figures |
//! | `history.rs`, `plugin.rs` | over time, as resources |
//!
//! Nothing here is ever read by a decision: a planet is the same whether it is measured or not.

mod boundaries;
mod coast;
mod floor;
mod ground;
mod history;
mod plates;
mod plugin;
mod spectrum;
mod table;
#[cfg(test)]
mod tests;

pub use history::{Gathering, StatisticsHistory};
pub use plugin::{StatisticsInterval, StatisticsPlugin};
pub use table::{Measure, Statistics};

use super::{
    check::run,
    clock::Clock,
    columns::Columns,
    error::TectonicError,
    ledger::Ledger,
    plate::{Plate, PlateBorn, PlateTable, Rotation},
    recipe::Recipe,
    sea::Sea,
    sub_plate::*,
    topology::{EdgeState, Topology},
};
use crate::mesh::SphereMesh;
use bevy::ecs::system::SystemParam;
use bevy::prelude::*;

impl Statistics {
    /// Measures a simulation world. Rates are taken since the last moment in its
    /// [`StatisticsHistory`], or since the start.
    ///
    /// # Errors
    /// [`TectonicError::Archetype`] if the sub-plates no longer lie in one table.
    pub fn measure(world: &mut World) -> Result<Self, TectonicError> {
        run(
            world,
            |mut instruments: Instruments, history: Option<Res<StatisticsHistory>>| {
                let before =
                    history.and_then(|history| history.before(instruments.clock.time_my).cloned());
                instruments.measure(before.as_ref())
            },
        )
    }

    /// What [`MEASURES`](Self::MEASURES) say, in their order.
    #[must_use]
    pub fn figures(&self) -> Vec<f64> {
        Self::MEASURES
            .iter()
            .map(|measure| (measure.value)(self))
            .collect()
    }

    /// The single figures without the distributions, for long series.
    fn compact(&self) -> Self {
        Self {
            hypsometry_500_m: Vec::new(),
            ocean_age_histogram_10_my: Vec::new(),
            ..self.clone()
        }
    }
}

/// Measures at the present moment, keeps it as the world's [`Statistics`] and in its
/// [`StatisticsHistory`].
pub(super) fn record(world: &mut World) -> Result<Statistics, TectonicError> {
    let now = Statistics::measure(world)?;
    world.get_resource_or_init::<StatisticsHistory>().push(&now);
    world.insert_resource(now.clone());
    Ok(now)
}

type MeasuredColumns = (
    &'static PlateId,
    &'static Crust,
    &'static Elevation,
    &'static Created,
    &'static Velocity,
    &'static Thickness,
    &'static MaterialArea,
);

/// All that a measurement reads.
#[derive(SystemParam)]
pub(super) struct Instruments<'w, 's> {
    recipe: Res<'w, Recipe>,
    clock: Res<'w, Clock>,
    topology: Res<'w, Topology>,
    sea: Res<'w, Sea>,
    ledger: Res<'w, Ledger>,
    plates: Query<
        'w,
        's,
        (
            Entity,
            &'static Plate,
            &'static Rotation,
            &'static PlateBorn,
        ),
    >,
    sub_plates: Query<'w, 's, MeasuredColumns, With<SubPlate>>,
}

impl Instruments<'_, '_> {
    /// Measures everything; rates since the moment `before`.
    fn measure(&mut self, before: Option<&Statistics>) -> Result<Statistics, TectonicError> {
        let mesh = &self.topology.0;
        let (plate, crust, elevation, created, velocity, thickness, area) =
            self.sub_plates.columns(mesh.vertex_count())?;
        let mut share = mesh.cell_areas();
        let sphere: f64 = share.iter().sum();
        share.iter_mut().for_each(|cell| *cell /= sphere);
        let view = View {
            recipe: &self.recipe,
            time_my: self.clock.time_my,
            ledger: &self.ledger,
            mesh,
            share,
            plate,
            crust,
            elevation,
            created,
            velocity,
            thickness,
            area,
            plates: PlateTable::gather(self.plates.iter()),
        };
        let mut statistics = Statistics {
            time_my: self.clock.time_my,
            sea_level_m: self.sea.level,
            ..default()
        };
        ground::measure(&view, &mut statistics);
        statistics.coastline_dimension = coast::dimension(&view);
        statistics.power_slope = spectrum::slope(&view);
        floor::measure(&view, before, &mut statistics);
        plates::measure(&view, &mut statistics);
        boundaries::measure(&view, &mut statistics);
        Ok(statistics)
    }
}

/// The planet as the measures see it; columns are indexed by vertex.
struct View<'a> {
    recipe: &'a Recipe,
    time_my: f64,
    ledger: &'a Ledger,
    mesh: &'a SphereMesh<EdgeState>,
    /// Area of each cell as a share of the sphere.
    share: Vec<f64>,
    plate: &'a [PlateId],
    crust: &'a [Crust],
    elevation: &'a [Elevation],
    created: &'a [Created],
    velocity: &'a [Velocity],
    thickness: &'a [Thickness],
    area: &'a [MaterialArea],
    plates: PlateTable,
}

impl View<'_> {
    fn elevation(&self, v: usize) -> f64 {
        f64::from(self.elevation[v].0)
    }

    fn age(&self, v: usize) -> f64 {
        self.time_my - f64::from(self.created[v].0)
    }
}

/// A quotient that is 0 where there is nothing to divide by.
fn ratio(sum: f64, weight: f64) -> f64 {
    if weight > 0.0 { sum / weight } else { 0.0 }
}

/// Sorts values with their weights, for [`quantile`].
fn sort(values: &mut [(f64, f64)]) {
    values.sort_by(|a, b| a.0.total_cmp(&b.0));
}

/// The least of sorted values at or below which a share of their weight lies; 0 of none.
fn quantile(sorted: &[(f64, f64)], share: f64) -> f64 {
    let whole: f64 = sorted.iter().map(|(_, weight)| weight).sum();
    let mut below = 0.0;
    for &(value, weight) in sorted {
        below += weight;
        if below >= share * whole {
            return value;
        }
    }
    sorted.last().map_or(0.0, |last| last.0)
}

/// Slope of a straight line through weighted points by least squares; 0 if it has none.
fn line_slope(points: impl Iterator<Item = [f64; 3]> + Clone) -> f64 {
    let (mut weights, mut x_sum, mut y_sum) = (0.0, 0.0, 0.0);
    for [x, y, weight] in points.clone() {
        weights += weight;
        x_sum += x * weight;
        y_sum += y * weight;
    }
    let (x_mean, y_mean) = (ratio(x_sum, weights), ratio(y_sum, weights));
    let (mut across, mut along) = (0.0, 0.0);
    for [x, y, weight] in points {
        across += (x - x_mean) * (y - y_mean) * weight;
        along += (x - x_mean) * (x - x_mean) * weight;
    }
    if along > 1e-12 * weights {
        across / along
    } else {
        0.0
    }
}
