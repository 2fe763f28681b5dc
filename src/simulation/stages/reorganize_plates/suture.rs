//! Continents that have stopped closing become one plate.

use super::{
    super::super::{
        boundaries::Contacts,
        clock::Clock,
        columns::Columns,
        error::TectonicError,
        plate::{Plate, PlateBorn, PlateTable, Rotation},
        recipe::Recipe,
        sub_plate::{MaterialArea, PlateId, SubPlate},
        topology::Topology,
    },
    plate_areas,
};
use bevy::prelude::*;

/// A collision at rest sutures after less interpenetration, in km, but with more contact.
const AT_REST_LENGTH: f64 = 100.0;
/// Share of continental contact that a collision at rest needs.
const AT_REST_SHARE: f64 = 0.35;

/// Welds at most one pair, the one that has interpenetrated furthest: the smaller plate joins the
/// larger, and their angular momentum is kept.
pub(in crate::simulation) fn suture(
    recipe: Res<Recipe>,
    clock: Res<Clock>,
    topology: Res<Topology>,
    mut contacts: ResMut<Contacts>,
    mut plates: Query<(Entity, &Plate, &mut Rotation, &PlateBorn)>,
    mut sub_plates: Query<(&mut PlateId, &MaterialArea), With<SubPlate>>,
) -> Result<(), TectonicError> {
    if clock.reorganisation.due().is_none() {
        return Ok(());
    }
    let constants = &recipe.constants.plates;
    let table = PlateTable::gather(plates.iter());
    if table.rows().len() <= 2 {
        return Ok(());
    }
    let ready = contacts
        .0
        .iter()
        .filter(|(_, contact)| {
            let deep = contact.interpenetration > constants.suture_length
                && contact.continental_share > constants.suture_share;
            let at_rest = contact.interpenetration > AT_REST_LENGTH
                && contact.closing < constants.suture_speed
                && contact.continental_share > AT_REST_SHARE;
            contact.last_my >= clock.time_my && (deep || at_rest)
        })
        .max_by(|a, b| a.1.interpenetration.total_cmp(&b.1.interpenetration));
    let Some((&(a, b), _)) = ready else {
        return Ok(());
    };
    let (mut plate, area) = sub_plates.columns(topology.0.vertex_count())?;
    let plate = plate.bypass_change_detection();
    let areas = plate_areas(&table, plate, area);
    let (Some(i), Some(j)) = (table.row(a), table.row(b)) else {
        return Ok(());
    };
    let (gone, heir) = if areas[i] < areas[j] { (i, j) } else { (j, i) };
    let (gone_id, heir_id) = (table.rows()[gone].id, table.rows()[heir].id);
    let mean = (table.rows()[gone].rotation * areas[gone]
        + table.rows()[heir].rotation * areas[heir])
        / (areas[gone] + areas[heir]).max(1.0);
    if let Ok((_, _, mut rotation, _)) = plates.get_mut(table.rows()[heir].entity) {
        rotation.0 = mean;
    }
    for plate in plate.iter_mut().filter(|plate| **plate == gone_id) {
        *plate = heir_id;
    }
    contacts.inherit(gone_id, heir_id);
    Ok(())
}
