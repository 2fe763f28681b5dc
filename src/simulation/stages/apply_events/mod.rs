//! Scripted events, before stage 1: see [`events`](super::super::events).
//!
//! One file per kind. Events are rare and may build upon each other, so each runs as a system by itself
//! and its commands are applied before the next one.

mod crust;
mod hot_spot;
mod motion;
mod rift;

pub(in crate::simulation) use motion::hold_motions;

use super::super::{
    clock::Clock,
    error::TectonicError,
    events::{EventFailure, EventLog, EventRecord, Intervention, PlateChoice},
    plate::PlateTable,
    recipe::Recipe,
    sub_plate::PlateId,
};
use crate::mesh::{EdgePayload, SphereMesh};
use bevy::ecs::system::RunSystemOnce;
use bevy::prelude::*;

/// What a kind of event reports: done, or why not; or an error that ends the step.
type Verdict = Result<Result<(), EventFailure>, TectonicError>;

/// Applies the events of the recipe whose time has come.
pub(in crate::simulation) fn apply_events(world: &mut World) -> Result<(), TectonicError> {
    loop {
        let clock = world.resource::<Clock>();
        let (time_my, next) = (clock.began_my, clock.events_done);
        let events = &world.resource::<Recipe>().events;
        let Some(event) = events
            .get(next)
            .filter(|event| event.at_my <= time_my)
            .cloned()
        else {
            return Ok(());
        };
        world.resource_mut::<Clock>().events_done += 1;
        let verdict = match event.what.clone() {
            Intervention::SetMotion {
                plate,
                pole,
                deg_per_my,
                hold_my,
            } => {
                let rotation = pole.direction() * deg_per_my.to_radians();
                once(world, motion::set_motion, (plate, rotation, hold_my))
            }
            Intervention::Rift { line } => once(world, rift::rift_along, line),
            Intervention::SetCrust {
                centre,
                radius_km,
                crust,
            } => once(world, crust::set_crust, (centre, radius_km, crust)),
            Intervention::StartHotSpot { place, strength } => {
                once(world, hot_spot::start_hot_spot, (place, strength))
            }
            Intervention::StopHotSpot { place } => once(world, hot_spot::stop_hot_spot, place),
            Intervention::BreakUp { plate, pieces } => {
                once(world, rift::break_up, (plate, usize::from(pieces)))
            }
        };
        let failure = verdict?.err();
        world.resource_mut::<EventLog>().0.push(EventRecord {
            time_my,
            event,
            failure,
        });
    }
}

/// Runs a system by itself, with its input, and applies its commands.
fn once<I, M>(
    world: &mut World,
    system: impl IntoSystem<In<I>, Verdict, M> + 'static,
    input: I,
) -> Verdict
where
    I: Send + 'static,
{
    world
        .run_system_once_with(system, input)
        .unwrap_or(Err(TectonicError::Archetype {
            found: 0,
            expected: 0,
        }))
}

/// The plate that is meant.
fn choose<E: EdgePayload>(
    choice: PlateChoice,
    mesh: &SphereMesh<E>,
    plate: &[PlateId],
    table: &PlateTable,
) -> Result<PlateId, EventFailure> {
    let id = match choice {
        PlateChoice::At(place) => plate[mesh.nearest(place.direction(), 0) as usize],
        PlateChoice::Id(id) => PlateId(id),
    };
    table
        .row(id)
        .map(|_| id)
        .ok_or(EventFailure::NoPlate { id: id.0 })
}
