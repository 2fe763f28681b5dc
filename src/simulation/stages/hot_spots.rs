//! Hot spots, a part of stage 6: volcanic islands rise over them, age, and drown.
//!
//! Lava piles up on the crust above a hot spot, `flux / 2πrR · exp(−d²/2r²)` km of it in a My at the
//! distance d (R is the radius of the ground that is fed, r the same or half a spacing where that is more), the
//! less the higher the volcanoes stand already. Sub-plates are wider than volcanoes, so
//! the height of one that carries a pile is that of its summits (see
//! [`relief`](HotSpotConstants::relief)). All around, hot mantle lifts the plate to a swell. Carried off by
//! it, islands sink with the floor beneath them, which cools (the age–depth law) as does the swell (Detrick
//! & Crough 1978), while rain and waves plane what stands above the sea. What was planed and has sunk is a guyot.

use super::super::{
    clock::Clock,
    columns::Columns,
    constants::HotSpotConstants,
    error::TectonicError,
    hot_spot::HotSpot,
    ledger::Ledger,
    reach::reach,
    recipe::Recipe,
    sea::Sea,
    sub_plate::*,
    topology::{EdgeState, Topology},
    workers::Workers,
};
use super::sea_floor_depth;
use crate::mesh::{EdgePayload, SphereMesh};
use bevy::prelude::*;
use glam::DVec3;
use std::collections::BTreeSet;

/// Radii within which crust is fed; farther out less than a hundredth arrives.
const REACH: f64 = 3.0;

/// Height in m of the swells of hot mantle under young volcanoes, and so of the plates that they have passed
/// under. One that has cooled for a while is both lower and narrower: as a distance from the hot spot would
/// make it.
pub(in crate::simulation) fn plume_swells(
    recipe: &Recipe,
    workers: &Workers,
    mesh: &SphereMesh<EdgeState>,
    volcanism: &[Volcanism],
    now_my: f64,
) -> Vec<f64> {
    let constants = &recipe.constants.hot_spots;
    let radius = constants.swell_radius;
    let cooled = |volcanism: Volcanism| {
        let since = (now_my - f64::from(volcanism.last_my?)).max(0.0);
        let distance = radius * swell_distance(since / constants.swell_time);
        (distance < radius).then_some(distance)
    };
    let rows = (0..).zip(volcanism);
    let sources: Vec<(u32, f64)> = rows
        .filter_map(|(v, volcanism)| Some((v, cooled(*volcanism)?)))
        .collect();
    let mut swells = vec![0.0; volcanism.len()];
    let around = reach(workers, mesh, recipe.radius_km, &sources, radius, |_| true);
    for (v, distance, _) in around.found {
        swells[v as usize] = constants.swell * swell_profile(distance / radius);
    }
    swells
}

/// Height of a swell as a share of its middle's, by the distance from there in radii of it.
fn swell_profile(x: f64) -> f64 {
    let inside = (1.0 - x * x).max(0.0);
    inside * inside
}

/// Distance in radii at which a swell stands as high as its middle does after so many times in which it cools.
fn swell_distance(age: f64) -> f64 {
    (1.0 - libm::exp(-0.5 * age)).sqrt()
}

/// Lava in km that stays on a pile on floor of this depth, in m below the sea, where `fresh` would on none:
/// `dp = (1 − p/p_max) df`, integrated, as volcanoes approach their greatest height.
fn growth(constants: &HotSpotConstants, pile_km: f64, depth: f64, fresh: f64) -> f64 {
    let highest = (constants.highest + depth - constants.swell).max(0.0) / constants.relief;
    let room = (highest - pile_km).max(0.0);
    if room > 0.0 {
        room * (1.0 - libm::exp(-fresh / highest))
    } else {
        0.0
    }
}

/// Piles lava onto the crust above every hot spot.
pub(in crate::simulation) fn feed_islands(
    recipe: Res<Recipe>,
    clock: Res<Clock>,
    workers: Res<Workers>,
    topology: Res<Topology>,
    sea: Res<Sea>,
    mut ledger: ResMut<Ledger>,
    hot_spots: Query<&HotSpot>,
    mut sub_plates: Query<
        (
            &Crust,
            &Created,
            &MaterialArea,
            &mut Thickness,
            &mut Volcanism,
        ),
        With<SubPlate>,
    >,
) -> Result<(), TectonicError> {
    let hot_spots = HotSpot::in_order(&hot_spots);
    if hot_spots.is_empty() {
        return Ok(());
    }
    let mesh = &topology.0;
    let (crust, created, area, mut thickness, mut volcanism) =
        sub_plates.columns(mesh.vertex_count())?;
    let thickness = thickness.bypass_change_detection();
    let volcanism = volcanism.bypass_change_detection();
    let constants = &recipe.constants.hot_spots;
    let radius = constants.radius.max(0.5 * recipe.spacing_km());
    let thickest = recipe.constants.collisions.thickest;
    let fed = workers.run(hot_spots.iter(), |hot_spot| {
        let angle = REACH * radius / recipe.radius_km;
        around(mesh, hot_spot.place, angle)
    });
    for (hot_spot, fed) in hot_spots.into_iter().zip(fed) {
        // A wider spot feeds a passing plate for longer: so chains are as high whatever the spacing.
        let most =
            hot_spot.flux / (core::f64::consts::TAU * constants.radius * radius) * clock.step_my;
        for (v, distance) in fed {
            let v = v as usize;
            let far = distance * recipe.radius_km / radius;
            let fresh = most * libm::exp(-0.5 * far * far);
            if crust[v].is_continental() {
                let room = (thickest - thickness[v].0).max(0.0);
                let fresh = (fresh * constants.continental).min(room);
                thickness[v].0 += fresh;
                ledger.plume_magma_km3 += fresh * area[v].0;
            } else {
                let depth = sea_floor_depth(clock.time_my - f64::from(created[v].0)) + sea.level;
                let pile = f64::from(volcanism[v].pile_km);
                let fresh = growth(constants, pile, depth, fresh);
                thickness[v].0 += fresh;
                volcanism[v].pile_km += fresh as f32;
            }
            if far < 1.0 {
                volcanism[v].last_my = Some(clock.time_my as f32);
            }
        }
    }
    Ok(())
}

/// Planes what stands above the sea: a pile loses its top.
pub(in crate::simulation) fn wear_islands(
    recipe: Res<Recipe>,
    clock: Res<Clock>,
    topology: Res<Topology>,
    mut sub_plates: Query<(&Crust, &Elevation, &mut Thickness, &mut Volcanism), With<SubPlate>>,
) -> Result<(), TectonicError> {
    let Some(time) = clock.geology.due() else {
        return Ok(());
    };
    let (crust, elevation, mut thickness, mut volcanism) =
        sub_plates.columns(topology.0.vertex_count())?;
    let thickness = thickness.bypass_change_detection();
    let volcanism = volcanism.bypass_change_detection();
    let constants = &recipe.constants.hot_spots;
    let share = 1.0 - libm::exp(-time / constants.wear_time);
    for v in 0..crust.len() {
        let above = f64::from(elevation[v].0);
        if crust[v].is_continental() || above <= 0.0 || volcanism[v].pile_km <= 0.0 {
            continue;
        }
        // Where what lay beneath has gone since, the pile is thicker than all of the crust.
        let pile = f64::from(volcanism[v].pile_km).min(thickness[v].0);
        let worn = (above * share / constants.relief).min(pile);
        volcanism[v].pile_km -= worn as f32;
        thickness[v].0 -= worn;
    }
    Ok(())
}

/// Places asked before a search for the nearest one starts.
const SAMPLES: usize = 256;

/// Vertices within an angle (rad) of a place, with their distances (rad), each once.
pub(in crate::simulation) fn around<E: EdgePayload>(
    mesh: &SphereMesh<E>,
    place: DVec3,
    angle: f64,
) -> Vec<(u32, f64)> {
    let chord = |v: u32| mesh.site(v).distance(place);
    let angle_of = |chord: f64| 2.0 * libm::asin((0.5 * chord).min(1.0));
    let longest = 2.0 * libm::sin(0.5 * angle.clamp(0.0, core::f64::consts::PI));
    // A hint that is remembered would be hidden state: the nearest of some that lie everywhere.
    let near = |&v: &u32| mesh.site(v).distance_squared(place).to_bits();
    let every = (mesh.vertex_count() / SAMPLES).max(1);
    let hint = (0..mesh.vertex_count() as u32)
        .step_by(every)
        .min_by_key(near);
    let nearest = mesh.nearest(place, hint.unwrap_or(0));
    let mut found = vec![(nearest, angle_of(chord(nearest)))];
    // Few of many: marks on all of them would be dear.
    let mut met = BTreeSet::from([nearest]);
    let mut next = 0;
    while let Some(&(v, _)) = found.get(next) {
        next += 1;
        for w in mesh.neighbours(v) {
            let far = chord(w);
            if far <= longest && met.insert(w) {
                found.push((w, angle_of(far)));
            }
        }
    }
    found
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::simulation::fixtures::random_mesh;

    /// A hot spot under one cell now, and under another 20 My ago.
    #[test]
    fn swells_are_wide_and_fade() {
        let mesh = random_mesh::<EdgeState>(8000);
        let recipe = Recipe::earth_like(1).with_sub_plates(8000);
        let constants = &recipe.constants.hot_spots;
        let mut volcanism = vec![Volcanism::default(); 8000];
        volcanism[5].last_my = Some(100.0);
        let far = (0..8000_u32)
            .find(|&v| mesh.site(v).dot(mesh.site(5)) < -0.9)
            .unwrap();
        volcanism[far as usize].last_my = Some(80.0);
        let swells = plume_swells(&recipe, &Workers::default(), &mesh, &volcanism, 100.0);
        assert!((swells[5] - constants.swell).abs() < 1e-9);
        // 1000 m / e = 367.88 m.
        assert!((swells[far as usize] - 367.88).abs() < 0.01);
        let next = mesh.neighbours(5).next().unwrap();
        let x = mesh.site(5).distance(mesh.site(next)) * 6371.0 / 600.0;
        let share = (1.0 - x * x) * (1.0 - x * x);
        // Edges are measured to 10 cm.
        assert!((swells[next as usize] - 1000.0 * share).abs() < 1e-3);
        let wide = |v: u32| {
            let near = |w: &u32| mesh.site(*w).distance(mesh.site(v)) * 6371.0 < 700.0;
            (0..8000_u32)
                .filter(near)
                .filter(|&w| swells[w as usize] > 0.0)
                .count()
        };
        assert!(wide(5) > wide(far) && wide(far) > 0);
    }

    #[test]
    fn the_higher_the_volcano_the_less_lava() {
        let constants = HotSpotConstants::default();
        // (3000 + 5500 − 1000) m / 750 m/km = 10 km at most. 10 km · (1 − 1/e) = 6.3212 km.
        assert!((growth(&constants, 0.0, 5500.0, 10.0) - 6.3212).abs() < 1e-4);
        // Whether in one step or in two.
        let half = growth(&constants, 0.0, 5500.0, 5.0);
        let other = growth(&constants, half, 5500.0, 5.0);
        assert!((half + other - 6.3212).abs() < 1e-4);
        assert_eq!(growth(&constants, 12.0, 5500.0, 1.0), 0.0);
    }
}
