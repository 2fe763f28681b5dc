//! All that a step reads of the planet, as plain data: to go back to a moment, to branch off, to store it.

use super::{
    boundaries::{Contact, Contacts},
    clock::Clock,
    columns::Columns,
    error::TectonicError,
    events::{EventLog, EventRecord, HeldMotion},
    hot_spot::HotSpot,
    ledger::Ledger,
    plate::{DrivingTorque, NextPlateId, Plate, PlateArea, PlateBorn, Rotation},
    recipe::Recipe,
    sea::Sea,
    stages::{Mantle, Splits},
    statistics::StatisticsHistory,
    sub_plate::*,
    topology::{EdgeState, Topology},
};
use crate::mesh::SphereMesh;
use bevy::prelude::*;
use serde::{Deserialize, Serialize};

/// A moment of a history. [`History::checkpoint`](super::History::checkpoint) takes one,
/// [`History::resume`](super::History::resume) goes on from it, to the same bits as if nothing had come
/// between; the cargo feature `save` makes bytes of it.
///
/// Components and resources of your own are no part of it.
#[derive(Debug, Clone, PartialEq)]
pub struct Checkpoint {
    pub(crate) record: Record,
    pub(crate) rows: Rows,
    pub(crate) mesh: SphereMesh<EdgeState>,
}

/// What is not counted by sub-plates.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub(crate) struct Record {
    pub recipe: Recipe,
    pub clock: Clock,
    pub sea: Sea,
    pub ledger: Ledger,
    pub mantle: Mantle,
    pub next_plate: u16,
    pub plates: Vec<PlateRecord>,
    pub contacts: Vec<(PlateId, PlateId, Contact)>,
    pub hot_spots: Vec<HotSpot>,
    pub events: Vec<EventRecord>,
    pub splits: Splits,
    pub statistics: StatisticsHistory,
}

/// A plate with all its components.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub(crate) struct PlateRecord {
    pub id: PlateId,
    pub rotation: Rotation,
    pub area: PlateArea,
    pub born: PlateBorn,
    pub torque: DrivingTorque,
    pub held: Option<HeldMotion>,
}

/// Declares the columns of the sub-plates that are stored: all but the position, which the mesh has.
macro_rules! rows {
    ($($name:ident: $component:ident),+ $(,)?) => {
        /// The sub-plates, by column.
        #[derive(Debug, Clone, Default, PartialEq)]
        pub(crate) struct Rows {
            $(pub $name: Vec<$component>,)+
        }

        impl Rows {
            fn take(world: &mut World, expected: usize) -> Result<Self, TectonicError> {
                Ok(Self {
                    $($name: {
                        let mut query = world.query_filtered::<&$component, With<SubPlate>>();
                        let mut query = query.query_mut(world);
                        query.columns(expected)?.to_vec()
                    },)+
                })
            }
        }
    };
}

rows! {
    velocity: Velocity,
    deviation: Deviation,
    plate: PlateId,
    crust: Crust,
    elevation: Elevation,
    thickness: Thickness,
    area: MaterialArea,
    created: Created,
    orogeny: Orogeny,
    orogeny_began: OrogenyBegan,
    fold: FoldDirection,
    ridge: RidgeDirection,
    slab: Slab,
    trench: Trench,
    volcanism: Volcanism,
}

impl Checkpoint {
    /// The recipe the planet grows from.
    #[must_use]
    pub fn recipe(&self) -> &Recipe {
        &self.record.recipe
    }

    /// Time since the start in My.
    #[must_use]
    pub fn time_my(&self) -> f64 {
        self.record.clock.time_my
    }

    /// Steps since the start.
    #[must_use]
    pub fn steps(&self) -> u64 {
        self.record.clock.steps
    }

    /// Number of sub-plates.
    #[must_use]
    pub fn sub_plates(&self) -> usize {
        self.mesh.vertex_count()
    }

    /// Copies the planet of a world between two steps.
    pub(super) fn take(world: &mut World) -> Result<Self, TectonicError> {
        let mesh = world.resource::<Topology>().0.clone();
        let rows = Rows::take(world, mesh.vertex_count())?;
        let mut plates: Vec<PlateRecord> = world
            .query::<(
                &Plate,
                &Rotation,
                &PlateArea,
                &PlateBorn,
                &DrivingTorque,
                Option<&HeldMotion>,
            )>()
            .iter(world)
            .map(|(plate, rotation, area, born, torque, held)| PlateRecord {
                id: plate.id,
                rotation: *rotation,
                area: *area,
                born: *born,
                torque: *torque,
                held: held.copied(),
            })
            .collect();
        plates.sort_by_key(|plate| plate.id);
        let mut hot_spots: Vec<HotSpot> = world.query::<&HotSpot>().iter(world).copied().collect();
        hot_spots.sort_by_key(|hot_spot| hot_spot.id);
        let contacts = &world.resource::<Contacts>().0;
        let record = Record {
            recipe: world.resource::<Recipe>().clone(),
            clock: world.resource::<Clock>().clone(),
            sea: *world.resource::<Sea>(),
            ledger: *world.resource::<Ledger>(),
            mantle: *world.resource::<Mantle>(),
            next_plate: world.resource::<NextPlateId>().0,
            plates,
            contacts: contacts.iter().map(|(&(a, b), &c)| (a, b, c)).collect(),
            hot_spots,
            events: world.resource::<EventLog>().0.clone(),
            splits: world.resource::<Splits>().clone(),
            statistics: world
                .get_resource::<StatisticsHistory>()
                .cloned()
                .unwrap_or_default(),
        };
        Ok(Self { record, rows, mesh })
    }

    /// Fills an empty world.
    pub(super) fn fill(self, world: &mut World) {
        let Self { record, rows, mesh } = self;
        for plate in record.plates {
            let mut entity = world.spawn((
                Plate { id: plate.id },
                plate.rotation,
                plate.area,
                plate.born,
                plate.torque,
            ));
            if let Some(held) = plate.held {
                entity.insert(held);
            }
        }
        world.spawn_batch(record.hot_spots);
        let sub_plates = (0..mesh.vertex_count()).map(|v| {
            (
                SubPlate,
                Position(mesh.site(v as u32).as_vec3()),
                (rows.velocity[v], rows.deviation[v], rows.plate[v]),
                (rows.crust[v], rows.elevation[v], rows.thickness[v]),
                (rows.area[v], rows.created[v]),
                (rows.orogeny[v], rows.orogeny_began[v]),
                (rows.fold[v], rows.ridge[v]),
                (rows.slab[v], rows.trench[v], rows.volcanism[v]),
            )
        });
        world.spawn_batch(sub_plates.collect::<Vec<_>>());
        world.insert_resource(Topology(mesh));
        world.insert_resource(record.recipe);
        world.insert_resource(record.clock);
        world.insert_resource(record.sea);
        world.insert_resource(record.ledger);
        world.insert_resource(record.mantle);
        world.insert_resource(NextPlateId(record.next_plate));
        let contacts = record.contacts.into_iter();
        world.insert_resource(Contacts(contacts.map(|(a, b, c)| ((a, b), c)).collect()));
        world.insert_resource(EventLog(record.events));
        world.insert_resource(record.splits);
        world.insert_resource(record.statistics);
    }
}

#[cfg(test)]
mod tests {
    use super::super::History;
    use super::*;
    use crate::simulation::{SimulationPlugins, TectonicStep, TectonicSystems};

    #[test]
    fn half_a_step_is_no_checkpoint() {
        let mut history = History::new(Recipe::earth_like(5).with_sub_plates(300)).unwrap();
        history.step().unwrap();
        let cancellation = history.cancellation();
        let cancel = move || cancellation.cancel();
        history
            .world_mut()
            .schedule_scope(TectonicStep, |_, schedule| {
                schedule.add_systems(cancel.in_set(TectonicSystems::Move));
            });
        history.checkpoint().unwrap();
        history.step().unwrap();
        assert!(matches!(
            history.checkpoint(),
            Err(TectonicError::Interrupted { .. })
        ));
    }

    #[test]
    fn a_resumed_history_is_the_one_that_was_never_stopped() {
        let recipe = Recipe::earth_like(5).with_sub_plates(600);
        let mut whole = History::new(recipe).unwrap();
        // Before and beyond sortings.
        for stop in [0, 1, 40, 97, 200] {
            while whole.steps() < stop {
                whole.step().unwrap();
            }
            let checkpoint = whole.checkpoint().unwrap();
            let mut resumed = History::resume(checkpoint.clone(), SimulationPlugins).unwrap();
            assert_eq!(resumed.checkpoint().unwrap(), checkpoint);
            let mut on = History::resume(checkpoint, SimulationPlugins).unwrap();
            for _ in 0..30 {
                on.step().unwrap();
                resumed.step().unwrap();
            }
            while whole.steps() < on.steps() {
                whole.step().unwrap();
            }
            let hash = whole.state_hash().unwrap();
            assert_eq!(on.state_hash().unwrap(), hash);
            assert_eq!(resumed.state_hash().unwrap(), hash);
            assert_eq!(on.checkpoint().unwrap(), whole.checkpoint().unwrap());
        }
    }
}
