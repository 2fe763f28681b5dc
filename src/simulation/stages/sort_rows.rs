//! End of stage 1: sub-plates lie in memory as they lie on the planet.
//!
//! Sea floor is born and goes under at the ends of the table, so that neighbours drift apart in memory
//! until a step waits for it most of the time. Now and then all rows are put along a Hilbert curve. Every
//! component comes along, those of users too: a marker moves each entity to another table, in the wanted
//! order, and the next sorting takes it away again, which moves them back.

use super::super::{
    clock::Clock,
    stages::Splits,
    sub_plate::{Sorted, SortedTable, SubPlate},
    topology::Topology,
    workers::Workers,
};
use crate::mesh::{hilbert_key, order_by_keys};
use bevy::prelude::*;

/// Steps between two sortings. In one, fronts cross a third of a cell: in 96, thirty rows of cells along
/// every ridge are new.
const INTERVAL: u64 = 96;

/// Sorts the rows of the sub-plates and the vertices of the mesh with them.
pub(in crate::simulation) fn sort_rows(world: &mut World) {
    if !world.resource::<Clock>().steps.is_multiple_of(INTERVAL) {
        return;
    }
    let rows: Vec<Entity> = world
        .query_filtered::<Entity, With<SubPlate>>()
        .iter(world)
        .collect();
    let sites = world.resource::<Topology>().0.sites();
    if rows.len() != sites.len() {
        // The next stage that reads the columns says so.
        return;
    }
    let keys = world.resource::<Workers>().map(sites.len(), |rows| {
        let keys = sites[rows].iter().map(|&site| hilbert_key(site));
        keys.collect::<Vec<u32>>()
    });
    let mut order = order_by_keys(keys.into_iter().flatten());
    // A table fills the hole of a row that leaves with its last one, so leaving is cheap at its end: each
    // sorting runs along the curve against the one before.
    let away = !world.resource::<SortedTable>().0;
    if away {
        order.reverse();
    }
    if away {
        let entities = order.iter().map(|&vertex| rows[vertex as usize]);
        let marked: Vec<(Entity, Sorted)> = entities.map(|entity| (entity, Sorted)).collect();
        drop(rows);
        world.insert_batch(marked);
    } else {
        for &vertex in &order {
            world.entity_mut(rows[vertex as usize]).remove::<Sorted>();
        }
        drop(rows);
    }
    world.resource_mut::<SortedTable>().0 = away;
    world.resource_mut::<Topology>().0.renumber(&order);
    // What refinement cut was known by number.
    let mut splits = world.resource_mut::<Splits>();
    splits.suspected |= !splits.cuts.is_empty();
    splits.cuts.clear();
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
        let order = |world: &World| world.resource::<Topology>().0.spatial_order();
        assert!(!order(history.world()).is_sorted());
        let world = history.world_mut();
        let mut query = world.query_filtered::<(Entity, &Position), With<SubPlate>>();
        let homes: Vec<(Entity, Home)> = query
            .iter(world)
            .map(|(entity, position)| (entity, Home(position.0)))
            .collect();
        world.insert_batch(homes);
        // There and back again: the second time against the first.
        for back in [true, false] {
            let world = history.world_mut();
            world.resource_mut::<Clock>().steps = INTERVAL;
            sort_rows(world);
            let mut rows = order(world);
            if back {
                rows.reverse();
            }
            assert!(rows.is_sorted());
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

    #[test]
    fn what_is_born_joins_the_sorted_table() {
        let recipe = Recipe::earth_like(1).with_sub_plates(1000);
        let mut history = History::new(recipe).unwrap();
        while history.steps() < 2 * INTERVAL + 10 {
            history.step().unwrap();
            history.check().unwrap();
        }
        assert!(history.ledger().area_created_km2 > 0.0);
    }
}
