//! End of stage 1: sub-plates lie in memory as they lie on the planet.
//!
//! Sea floor is born and goes under at the ends of the table, so that neighbours drift apart in memory
//! until a step waits for it most of the time. Now and then all rows are put along a Hilbert curve: values
//! move from row to row, column by column. Where sub-plates carry components of users, entities move instead,
//! so that everything comes along: a marker takes each to another table, in the wanted order, and the next
//! sorting takes it away again, which moves them back. That is some four times slower; the order is the same.

use super::super::{
    clock::Clock,
    columns::Columns,
    stages::Splits,
    sub_plate::*,
    topology::Topology,
    workers::{CHUNK, Workers},
};
use crate::mesh::{hilbert_key, order_by_keys};
use bevy::ecs::component::{ComponentId, Mutable};
use bevy::prelude::*;

/// Sorts the rows of the sub-plates and the vertices of the mesh with them.
pub(in crate::simulation) fn sort_rows(world: &mut World) {
    if !world.resource::<Clock>().is_sorting() {
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
    let order = order_by_keys(keys.into_iter().flatten());
    if carry_foreign_components(world) {
        move_entities(world, &order, &rows);
    } else {
        world.resource_scope(|world, workers: Mut<Workers>| move_values(world, &workers, &order));
    }
    world.resource_mut::<Topology>().0.renumber(&order);
    // What was cut is known by number.
    let mut splits = world.resource_mut::<Splits>();
    if splits.suspected {
        splits.cuts.clear();
    } else if !splits.cuts.is_empty() {
        let mut place = vec![0; order.len()];
        for (&before, now) in order.iter().zip(0..) {
            place[before as usize] = now;
        }
        for v in splits.cuts.as_flattened_mut() {
            *v = place[*v as usize];
        }
    }
}

/// Lists what every sub-plate carries.
macro_rules! columns {
    ($($component:ty),+ $(,)?) => {
        /// Components that this crate gives to sub-plates; those without values need not move.
        fn own_components(world: &World) -> Vec<Option<ComponentId>> {
            vec![
                world.component_id::<SubPlate>(),
                world.component_id::<Sorted>(),
                $(world.component_id::<$component>(),)+
            ]
        }

        fn move_values(world: &mut World, workers: &Workers, order: &[u32]) {
            $(move_column::<$component>(world, workers, order);)+
        }
    };
}

columns!(
    Position,
    Velocity,
    Deviation,
    PlateId,
    Crust,
    Elevation,
    Thickness,
    MaterialArea,
    Created,
    Orogeny,
    OrogenyBegan,
    FoldDirection,
    RidgeDirection,
    Slab,
    Trench,
    Volcanism,
);

/// Whether any sub-plate carries a component that is not this crate's.
fn carry_foreign_components(world: &World) -> bool {
    let own = own_components(world);
    let sub_plate = world.component_id::<SubPlate>();
    let archetypes = world.archetypes().iter();
    archetypes
        .filter(|archetype| sub_plate.is_some_and(|id| archetype.contains(id)))
        .filter(|archetype| !archetype.is_empty())
        .flat_map(|archetype| archetype.components())
        .any(|&id| !own.contains(&Some(id)))
}

/// Puts the value of row `order[i]` into row `i`.
fn move_column<T: Component<Mutability = Mutable> + Copy>(
    world: &mut World,
    workers: &Workers,
    order: &[u32],
) {
    let mut query = world.query_filtered::<&mut T, With<SubPlate>>();
    let mut query = query.query_mut(world);
    // Rows were counted before. Should they not lie in one table, the next stage says so.
    let Ok(mut column) = query.columns(order.len()) else {
        return;
    };
    let column = column.bypass_change_detection();
    let before = column.to_vec();
    let parts = column.chunks_mut(CHUNK).zip(order.chunks(CHUNK));
    workers.run(parts, |(rows, from)| {
        for (row, &from) in rows.iter_mut().zip(from) {
            *row = before[from as usize];
        }
    });
}

/// Moves entities to another table, row `order[i]` as the `i`-th.
fn move_entities(world: &mut World, order: &[u32], rows: &[Entity]) {
    let is_marked = world.resource::<SortedTable>().0;
    let entities = order.iter().map(|&vertex| rows[vertex as usize]);
    if is_marked {
        for entity in entities {
            world.entity_mut(entity).remove::<Sorted>();
        }
    } else {
        let marked: Vec<(Entity, Sorted)> = entities.map(|entity| (entity, Sorted)).collect();
        world.insert_batch(marked);
    }
    world.resource_mut::<SortedTable>().0 = !is_marked;
}

#[cfg(test)]
mod tests {
    use super::{super::super::clock::SORTING, *};
    use crate::simulation::{History, Recipe, SimulationPlugins};

    #[derive(Component)]
    struct Home(Vec3);

    fn before_a_sorting() -> History {
        let recipe = Recipe::earth_like(1).with_sub_plates(1000);
        let mut history = History::new(recipe).unwrap();
        while history.steps() < SORTING - 1 {
            history.step().unwrap();
        }
        history
    }

    fn sort_now(history: &mut History) {
        let world = history.world_mut();
        world.resource_mut::<Clock>().steps = SORTING;
        sort_rows(world);
        assert!(world.resource::<Topology>().0.spatial_order().is_sorted());
    }

    /// What a place carries, in the order of places.
    fn places(history: &mut History) -> Vec<String> {
        let world = history.world_mut();
        let mut query = world.query::<EntityRef>();
        let all = query.iter(world).filter(|row| row.contains::<SubPlate>());
        let mut places: Vec<String> = all
            .map(|row| {
                format!(
                    "{:?}",
                    row.get_components::<(
                        &Position,
                        &Velocity,
                        &Deviation,
                        &PlateId,
                        &Crust,
                        &Elevation,
                        &Thickness,
                        &MaterialArea,
                        (&Created, &Orogeny, &OrogenyBegan, &FoldDirection),
                        (&RidgeDirection, &Slab, &Trench, &Volcanism),
                    )>()
                    .unwrap()
                )
            })
            .collect();
        places.sort_unstable();
        places
    }

    #[test]
    fn values_move_together_and_none_is_lost() {
        let mut history = before_a_sorting();
        let mesh = &history.world().resource::<Topology>().0;
        assert!(!mesh.spatial_order().is_sorted());
        assert!(!carry_foreign_components(history.world()));
        let before = places(&mut history);
        sort_now(&mut history);
        assert_eq!(places(&mut history), before);
        history.check().unwrap();
        assert!(!history.world().resource::<SortedTable>().0);
    }

    #[test]
    fn components_of_users_come_along_and_the_planet_is_the_same() {
        let mut history = before_a_sorting();
        let world = history.world_mut();
        let mut query = world.query_filtered::<(Entity, &Position), With<SubPlate>>();
        let homes: Vec<(Entity, Home)> = query
            .iter(world)
            .map(|(entity, position)| (entity, Home(position.0)))
            .collect();
        world.insert_batch(homes);
        assert!(carry_foreign_components(world));
        let mut plain = before_a_sorting();
        sort_now(&mut plain);
        // There and back again.
        for marked in [true, false] {
            sort_now(&mut history);
            assert_eq!(history.state_hash().unwrap(), plain.state_hash().unwrap());
            let world = history.world_mut();
            assert_eq!(world.resource::<SortedTable>().0, marked);
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
        #[derive(Component, Default)]
        struct Flag;
        fn flag(app: &mut App) {
            app.register_required_components::<SubPlate, Flag>();
        }
        let recipe = Recipe::earth_like(1).with_sub_plates(1000);
        let plugins = SimulationPlugins.build().add(flag);
        let mut history = History::with_plugins(recipe.clone(), plugins).unwrap();
        let mut plain = History::new(recipe).unwrap();
        let mut marked = Vec::new();
        while history.steps() < 2 * SORTING + 10 {
            history.step().unwrap();
            history.check().unwrap();
            marked.push(history.world().resource::<SortedTable>().0);
            plain.step().unwrap();
        }
        assert_eq!(history.state_hash().unwrap(), plain.state_hash().unwrap());
        assert_eq!(history.checkpoint().unwrap(), plain.checkpoint().unwrap());
        marked.dedup();
        assert_eq!(marked, [false, true, false]);
        assert!(history.ledger().area_created_km2 > 0.0);
    }
}
