//! Plates follow the mean flow of the mantle beneath them (Tectonics.js).
//!
//! Which ground is a plate is decided every 150 My by
//! [`segment`](super::super::reorganize_plates::segment); here the rotations of those plates are kept
//! up to date while the sea floor grows old and founders. What the source leaves open is the scale of
//! the speed: the mantle's mobility is a constant, so that much old floor makes fast plates, fast
//! plates make young floor, and the age of the sea floor keeps itself.
//!
//! The source has nothing that holds colliding continents apart: they would be crushed for as long as
//! the flow beneath them converges. Here plates whose continents close hold each other, more firmly the
//! deeper they are in each other.

use super::{
    super::super::{
        boundaries::{Contact, Contacts},
        clock::Clock,
        columns::Columns,
        error::TectonicError,
        plate::{Plate, PlateBorn, PlateTable, Rotation},
        recipe::Recipe,
        sub_plate::{Created, Crust, MaterialArea, PlateId, SubPlate},
        topology::Topology,
    },
    super::reorganize_plates::plate_areas,
    foundering_flow::{mantle_flow, mean_rotations},
};
use bevy::prelude::*;
use glam::DVec3;

/// Turns each plate with the mantle under it, at the pace of the reorganisation clock.
pub(in crate::simulation) fn follow_mantle(
    recipe: Res<Recipe>,
    clock: Res<Clock>,
    contacts: Res<Contacts>,
    topology: Res<Topology>,
    mut plates: Query<(Entity, &Plate, &mut Rotation, &PlateBorn)>,
    mut sub_plates: Query<(&PlateId, &Crust, &Created, &MaterialArea), With<SubPlate>>,
) -> Result<(), TectonicError> {
    if clock.reorganisation.due().is_none() && clock.steps > 1 {
        return Ok(());
    }
    let mesh = &topology.0;
    let (plate, crust, created, area) = sub_plates.columns(mesh.vertex_count())?;
    let table = PlateTable::gather(plates.iter());
    let areas = plate_areas(&table, plate, area);
    let flow = mantle_flow(&recipe, &clock, mesh, crust, created);
    let mut rotations = mean_rotations(
        &flow,
        |v| area[v].0,
        |v| table.row(plate[v]),
        table.rows().len(),
    );
    for rotation in &mut rotations {
        *rotation = bounded(&recipe, *rotation);
    }
    for (&(a, b), contact) in &contacts.0 {
        let touching = contact.last_my >= clock.time_my && contact.closing > 0.0;
        if let (true, Some(i), Some(j)) = (touching, table.row(a), table.row(b)) {
            let held = hold(&recipe, contact);
            let (x, y) = (rotations[i], rotations[j]);
            let mean = (x * areas[i] + y * areas[j]) / (areas[i] + areas[j]).max(1.0);
            rotations[i] = x.lerp(mean, held);
            rotations[j] = y.lerp(mean, held);
        }
    }
    for (row, turned) in table.rows().iter().zip(rotations) {
        if let Ok((_, _, mut rotation, _)) = plates.get_mut(row.entity) {
            rotation.0 = turned;
        }
    }
    Ok(())
}

/// Share, 0 to 1, by which two plates take up their common motion where their continents collide.
fn hold(recipe: &Recipe, contact: &Contact) -> f64 {
    let depth = contact.interpenetration / recipe.constants.motion.collision_length;
    let strength = recipe.constants.foundering.resistance * contact.continental_share * depth;
    strength / (1.0 + strength)
}

/// Bounds a rotation smoothly: slow ones stay as they are, no speed exceeds the fastest.
pub(in crate::simulation) fn bounded(recipe: &Recipe, rotation: DVec3) -> DVec3 {
    let speed = rotation.length() * recipe.radius_km / recipe.constants.foundering.fastest;
    rotation / (1.0 + speed * speed).sqrt()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn collisions_hold_plates_together() {
        let recipe = Recipe::default();
        let contact = |interpenetration, continental_share| Contact {
            interpenetration,
            continental_share,
            ..default()
        };
        assert_eq!(hold(&recipe, &contact(0.0, 1.0)), 0.0);
        assert_eq!(hold(&recipe, &contact(300.0, 0.0)), 0.0);
        // 300 km over 300 km, half of the front, resistance 5: 2.5/(1 + 2.5).
        assert!((hold(&recipe, &contact(300.0, 0.5)) - 2.5 / 3.5).abs() < 1e-12);
    }

    #[test]
    fn speeds_are_bounded_smoothly() {
        let recipe = Recipe::default();
        let fastest = recipe.constants.foundering.fastest;
        let speed = |v: f64| bounded(&recipe, DVec3::Z * (v / recipe.radius_km)).length();
        let speed = |v: f64| speed(v) * recipe.radius_km;
        assert!((speed(1.0) - 1.0).abs() < 1e-4);
        // At the fastest itself: 1/√2 of it.
        assert!((speed(fastest) - fastest / 2.0_f64.sqrt()).abs() < 1e-9);
        assert!(speed(1e6) <= fastest);
    }
}
