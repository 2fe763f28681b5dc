//! End of stage 1: sub-plates lie in memory as they lie on the planet.
//!
//! Sea floor is born and goes under at the ends of the table, so that neighbours drift apart in memory
//! until a step waits for it most of the time. Now and then all rows are put along a Hilbert curve. Every
//! component comes along, those of users too: a marker moves each entity to another table, and
//! taking it away again moves them back in the wanted order.

use super::super::{clock::Clock, sub_plate::SubPlate, topology::Topology};
use bevy::prelude::*;

/// Steps between two sortings. In one, fronts cross a third of a cell: in 48, sixteen rows of cells along
/// every ridge are new.
const INTERVAL: u64 = 48;

/// Marks sub-plates that are on their way.
#[derive(Component)]
struct Unsorted;

/// Sorts the rows of the sub-plates and the vertices of the mesh with them.
pub(in crate::simulation) fn sort_rows(world: &mut World) {
    if !world.resource::<Clock>().steps.is_multiple_of(INTERVAL) {
        return;
    }
    let order = world.resource::<Topology>().0.spatial_order();
    let rows: Vec<Entity> = world
        .query_filtered::<Entity, With<SubPlate>>()
        .iter(world)
        .collect();
    if rows.len() != order.len() {
        // The next stage that reads the columns says so.
        return;
    }
    // From the back: a table fills the hole of a row that leaves with its last one.
    for &entity in rows.iter().rev() {
        world.entity_mut(entity).insert(Unsorted);
    }
    for &vertex in &order {
        world.entity_mut(rows[vertex as usize]).remove::<Unsorted>();
    }
    world.resource_mut::<Topology>().0.renumber(&order);
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::simulation::{History, Position, Recipe};

    #[derive(Component)]
    struct Home(Vec3);

    #[test]
    fn rows_follow_the_curve_and_take_every_component_along() {
        let recipe = Recipe::earth_like(1).with_sub_plates(1000);
        let mut history = History::new(recipe).unwrap();
        while history.steps() < INTERVAL - 1 {
            history.step().unwrap();
        }
        let world = history.world_mut();
        let sorted = |world: &World| world.resource::<Topology>().0.spatial_order().is_sorted();
        assert!(!sorted(world));
        let mut query = world.query_filtered::<(Entity, &Position), With<SubPlate>>();
        let homes: Vec<(Entity, Home)> = query
            .iter(world)
            .map(|(entity, position)| (entity, Home(position.0)))
            .collect();
        world.insert_batch(homes);
        world.resource_mut::<Clock>().steps = INTERVAL;
        sort_rows(world);
        assert!(sorted(world));
        let mut query = world.query_filtered::<(&Position, &Home), With<SubPlate>>();
        let rows: Vec<(Vec3, Vec3)> = query.iter(world).map(|(p, h)| (p.0, h.0)).collect();
        let mesh = &world.resource::<Topology>().0;
        assert_eq!(rows.len(), mesh.vertex_count());
        for (&(position, home), &site) in rows.iter().zip(mesh.sites()) {
            assert_eq!(position, home);
            assert!((position.as_dvec3() - site).length() < 1e-6);
        }
        history.check().unwrap();
    }
}
