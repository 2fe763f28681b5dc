//! Plates turn otherwise.

use super::{
    super::super::{
        clock::Clock,
        columns::Columns,
        events::{HeldMotion, PlateChoice},
        plate::{Plate, PlateBorn, PlateTable, Rotation},
        stages::Splits,
        sub_plate::{PlateId, SubPlate},
        topology::Topology,
    },
    Verdict, choose,
};
use bevy::prelude::*;
use glam::DVec3;

/// Gives a plate a rotation in rad/My, and holds it for a while in My.
pub(super) fn set_motion(
    In((choice, rotation, hold_my)): In<(PlateChoice, DVec3, f64)>,
    mut commands: Commands,
    clock: Res<Clock>,
    topology: Res<Topology>,
    mut splits: ResMut<Splits>,
    mut plates: Query<(Entity, &Plate, &mut Rotation, &PlateBorn)>,
    mut sub_plates: Query<&PlateId, With<SubPlate>>,
) -> Verdict {
    let mesh = &topology.0;
    let plate = sub_plates.columns(mesh.vertex_count())?;
    let table = PlateTable::gather(plates.iter());
    let id = match choose(choice, mesh, plate, &table) {
        Ok(id) => id,
        Err(failure) => return Ok(Err(failure)),
    };
    for (entity, plate, mut turn, _) in &mut plates {
        if plate.id != id {
            continue;
        }
        turn.0 = rotation;
        if hold_my > 0.0 {
            commands.entity(entity).insert(HeldMotion {
                rotation,
                until_my: clock.began_my + hold_my,
            });
        } else {
            commands.entity(entity).remove::<HeldMotion>();
        }
    }
    splits.regrouped = true;
    Ok(Ok(()))
}

/// Keeps plates to the motion that events hold them to, whatever the drive made of it.
pub(in crate::simulation) fn hold_motions(
    mut commands: Commands,
    clock: Res<Clock>,
    mut plates: Query<(Entity, &HeldMotion, &mut Rotation)>,
) {
    for (entity, held, mut rotation) in &mut plates {
        if clock.began_my < held.until_my {
            rotation.0 = held.rotation;
        } else {
            commands.entity(entity).remove::<HeldMotion>();
        }
    }
}
