//! Enclosed seas: sea floor that no ridge feeds and no trench eats fills up from its rim.

use super::super::super::{
    clock::Clock, columns::Columns, error::TectonicError, ledger::Ledger, recipe::Recipe,
    sub_plate::*, topology::Topology,
};
use crate::mesh::NONE;
use bevy::prelude::*;

/// Speed of each shore of an enclosed sea, in km/My: a basin 1,000 km across is full within 100 My. No
/// source gives one; this is what a mesh of 10,000 sub-plates was calibrated with.
const FILL_SPEED: f64 = 5.0;

/// Thickens the rim of small enclosed seas until it becomes continental crust.
pub(in crate::simulation) fn fill_basins(
    recipe: Res<Recipe>,
    clock: Res<Clock>,
    topology: Res<Topology>,
    mut ledger: ResMut<Ledger>,
    mut sub_plates: Query<
        (&mut Crust, &mut Thickness, &MaterialArea, &mut Created),
        With<SubPlate>,
    >,
) -> Result<(), TectonicError> {
    let Some(time) = clock.reorganisation.due() else {
        return Ok(());
    };
    // What lies at the rim grows from floor to continent while the shore crosses one cell.
    let full = recipe.constants.uplift.arc_accretion;
    let missing = (full - recipe.constants.ridges.oceanic_thickness).max(0.0);
    let rate = missing * FILL_SPEED / recipe.spacing_km();
    let mesh = &topology.0;
    let (mut crust, mut thickness, area, mut created) = sub_plates.columns(mesh.vertex_count())?;
    let crust = crust.bypass_change_detection();
    let thickness = thickness.bypass_change_detection();
    let created = created.bypass_change_detection();

    let mut sea = vec![NONE; crust.len()];
    let mut stack = Vec::new();
    for first in 0..crust.len() as u32 {
        if crust[first as usize].is_continental() || sea[first as usize] != NONE {
            continue;
        }
        let mut members = vec![first];
        sea[first as usize] = first;
        stack.push(first);
        while let Some(v) = stack.pop() {
            for w in mesh.neighbours(v) {
                if !crust[w as usize].is_continental() && sea[w as usize] == NONE {
                    sea[w as usize] = first;
                    members.push(w);
                    stack.push(w);
                }
            }
        }
        let size: f64 = members.iter().map(|&v| area[v as usize].0).sum();
        if size >= recipe.constants.plates.basin {
            continue;
        }
        let rim: Vec<u32> = members
            .into_iter()
            .filter(|&v| {
                mesh.neighbours(v)
                    .any(|w| crust[w as usize].is_continental())
            })
            .collect();
        for v in rim.into_iter().map(|v| v as usize) {
            thickness[v].0 += rate * time;
            if thickness[v].0 >= full {
                crust[v] = Crust::Continental;
                created[v].0 = clock.time_my as f32;
                ledger.filled_seas_km3 += thickness[v].0 * area[v].0;
            }
        }
    }
    Ok(())
}
