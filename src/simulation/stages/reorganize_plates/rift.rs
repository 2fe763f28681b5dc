//! Large plates break, continents first (Cortial et al. 2019: a Poisson process).
//!
//! A plate breaks into two to four pieces ([`cut`](super::cut)), if all that acts on them would part
//! them ([`tension`](super::tension)): pieces that are pressed together stay one. They are plates at
//! once, but stay welded wherever the tear has not passed yet, and some rifts in two stall. What stalls
//! becomes one plate again in [`suture`](super::suture), with a basin of stretched crust where it had
//! begun to part.

use super::{
    super::super::{
        boundaries::{Contact, Contacts, FrontForces, Rift},
        clock::Clock,
        columns::Columns,
        constants::PlateConstants,
        error::TectonicError,
        plate::{NextPlateId, Plate, PlateBorn, PlateRow, PlateTable, Rotation},
        recipe::Recipe,
        stages::Mantle,
        streams::{self, Purpose},
        sub_plate::{Crust, MaterialArea, PlateId, SubPlate},
        topology::Topology,
        workers::Workers,
    },
    Splits,
    cut::Cut,
    plate_areas,
    tension::Tension,
};
use bevy::prelude::*;
use glam::DVec3;

/// A tenth of the sphere, for which the rate is stated.
const NOMINAL_SHARE: f64 = 0.1;
/// The rate grows at most this much when there are few plates.
const MOST_URGENT: f64 = 4.0;
/// Breaks plates, more often where they are large, continental and warmed from below.
pub(in crate::simulation) fn rift(
    mut commands: Commands,
    recipe: Res<Recipe>,
    clock: Res<Clock>,
    mantle: Res<Mantle>,
    forces: Res<FrontForces>,
    topology: Res<Topology>,
    workers: Res<Workers>,
    mut contacts: ResMut<Contacts>,
    mut next: ResMut<NextPlateId>,
    mut splits: ResMut<Splits>,
    mut plates: Query<(Entity, &Plate, &Rotation, &mut PlateBorn)>,
    mut sub_plates: Query<(&mut PlateId, &Crust, &MaterialArea), With<SubPlate>>,
) -> Result<(), TectonicError> {
    let Some(time) = clock.reorganisation.due() else {
        return Ok(());
    };
    let mesh = &topology.0;
    let (mut plate, crust, area) = sub_plates.columns(mesh.vertex_count())?;
    let plate = plate.bypass_change_detection();
    let constants = &recipe.constants.plates;
    let table = PlateTable::gather(plates.iter());
    let sphere = 4.0 * core::f64::consts::PI * recipe.radius_km * recipe.radius_km;
    let areas = plate_areas(&table, plate, area);
    let mut lands = vec![(0.0, DVec3::ZERO); table.rows().len()];
    for v in (0..plate.len()).filter(|&v| crust[v].is_continental()) {
        if let Some(row) = table.row(plate[v]) {
            lands[row].0 += area[v].0;
            lands[row].1 += mesh.site(v as u32) * area[v].0;
        }
    }

    for ((row, &size), (land_area, middle)) in table.rows().iter().zip(&areas).zip(lands) {
        let share = size / sphere;
        if share < constants.rift_smallest || clock.time_my - row.born < constants.rift_youngest {
            continue;
        }
        let warmth = mantle.warmth_at(middle.normalize_or_zero());
        let count = table.rows().len();
        let rate = rate_of_rifting(constants, [size, land_area, sphere], count, warmth);
        let mut rng = streams::stream(recipe.seed, Purpose::Rift, clock.steps, row.id.0.into());
        if streams::unit(&mut rng) >= 1.0 - libm::exp(-rate * time) {
            continue;
        }
        let members: Vec<usize> = (0..plate.len()).filter(|&v| plate[v] == row.id).collect();
        let is_land = |v: &usize| crust[*v].is_continental();
        let land: Vec<usize> = members.iter().copied().filter(is_land).collect();
        let places = if land.len() >= 2 { &land } else { &members };
        let mut cut = Cut::draw(mesh, &workers, &mut rng, &members, places);
        let tension = Tension {
            recipe: &recipe,
            mesh,
            mantle: &mantle,
            forces: &forces,
            crust,
            area,
        };
        tension.keep_what_opens(row, &mut cut);
        if cut.pieces.len() < 2 {
            continue;
        }
        cut.aim(mesh, &recipe, &mut rng);
        let broken = break_plate(
            &mut commands,
            row,
            &cut,
            plate,
            area,
            constants.smallest * sphere * 4.0,
            clock.time_my,
            &mut next,
            &mut contacts,
        );
        if broken {
            splits.suspected = true;
            if let Ok((.., mut born)) = plates.get_mut(row.entity) {
                born.0 = clock.time_my;
            }
        }
    }
    Ok(())
}

/// Rate in 1/My at which a plate is tried to be cut, from its area, that of its continents and that of the
/// sphere in km², the number of plates and the warmth under its continents, −1 to 1.
///
/// Cortial et al. 2019 have a Poisson law: a rate `λ = λ₀ f(x) A/A₀`, and `λ e^(−λ)`, the probability of exactly
/// one event, as the chance in a step. Here the chance in a time is `1 − e^(−rate · time)`, the probability of
/// at least one, whatever the length of the steps. The factors are `f(x) = 0.3 + 2x` of the continental share x,
/// the plate's share of the sphere over [`NOMINAL_SHARE`], the urgency where there are few plates, and warmth.
fn rate_of_rifting(
    constants: &PlateConstants,
    [size, land_area, sphere]: [f64; 3],
    plates: usize,
    warmth: f64,
) -> f64 {
    let ratio = constants.plate_count / plates as f64;
    let urgency = (ratio * ratio).min(MOST_URGENT);
    let warm = 1.0 + constants.rift_warmth * warmth;
    let share = size / sphere;
    constants.rift_rate
        * (0.3 + 2.0 * land_area / size.max(1.0))
        * (share / NOMINAL_SHARE)
        * urgency
        * warm.max(0.0)
}

/// Makes plates of the pieces of a cut; the largest stays what it was. Pieces below the smallest area
/// in km² stay with it. Whether anything was broken off.
#[expect(
    clippy::too_many_arguments,
    reason = "all that a plate's birth touches"
)]
fn break_plate(
    commands: &mut Commands,
    parent: &PlateRow,
    cut: &Cut,
    plate: &mut [PlateId],
    area: &[MaterialArea],
    smallest: f64,
    now: f64,
    next: &mut NextPlateId,
    contacts: &mut Contacts,
) -> bool {
    let size = |piece: &[usize]| piece.iter().map(|&v| area[v].0).sum::<f64>();
    let mut pieces: Vec<(f64, &[usize])> = cut
        .pieces
        .iter()
        .map(|piece| (size(piece), piece.as_slice()))
        .filter(|(size, _)| *size >= smallest)
        .collect();
    // Stable: equals keep the order in which they were drawn.
    pieces.sort_by(|a, b| b.0.total_cmp(&a.0));
    let mut ids = vec![parent.id];
    for (_, piece) in pieces.into_iter().skip(1) {
        let Some(id) = next.take() else {
            break;
        };
        for &v in piece {
            plate[v] = id;
        }
        commands.spawn((Plate { id }, Rotation(parent.rotation), PlateBorn(now)));
        for &other in &ids {
            let contact = Contact {
                last_my: now,
                rift: Some(Rift {
                    began_my: now,
                    from: cut.from,
                    pace: cut.pace,
                    stops_km: cut.stops_km,
                }),
                ..default()
            };
            contacts.0.insert(Contacts::key(other, id), contact);
        }
        ids.push(id);
    }
    ids.len() > 1
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_tear_runs_at_its_pace_until_it_stalls() {
        let mut rift = Rift {
            began_my: 100.0,
            from: DVec3::X,
            pace: 150.0,
            stops_km: f64::INFINITY,
        };
        assert_eq!(rift.reach_km(110.0), 1500.0);
        rift.stops_km = 1200.0;
        assert_eq!(rift.reach_km(110.0), 1200.0);
    }

    /// Rates by hand on a sphere of 5e8 km², of which a tenth is the nominal plate, at 14 plates.
    #[test]
    fn plates_rift_more_often_where_they_are_large_continental_few_and_warm() {
        let constants = PlateConstants {
            rift_rate: 0.05,
            rift_warmth: 0.8,
            plate_count: 14.0,
            ..default()
        };
        let rate = |size, land_area, plates, warmth| {
            rate_of_rifting(&constants, [size, land_area, 5e8], plates, warmth)
        };
        let near = |found: f64, expected: f64| {
            assert!((found - expected).abs() < 1e-12, "{found}, not {expected}");
        };
        // Half continental: 0.05 · (0.3 + 1).
        near(rate(5e7, 2.5e7, 14, 0.0), 0.065);
        near(rate(1e8, 5e7, 14, 0.0), 0.13);
        // Sea floor alone, and land alone: 0.05 · 0.3 and 0.05 · 2.3.
        near(rate(5e7, 0.0, 14, 0.0), 0.015);
        near(rate(5e7, 5e7, 14, 0.0), 0.115);
        // Twice as many plates: (1/2)². Half of them: 2² = 4, and no more with fewer.
        near(rate(5e7, 2.5e7, 28, 0.0), 0.065 / 4.0);
        near(rate(5e7, 2.5e7, 7, 0.0), 0.065 * MOST_URGENT);
        near(rate(5e7, 2.5e7, 2, 0.0), 0.065 * MOST_URGENT);
        // 1 ± 0.8.
        near(rate(5e7, 2.5e7, 14, 1.0), 0.065 * 1.8);
        near(rate(5e7, 2.5e7, 14, -1.0), 0.065 * 0.2);
    }

    #[test]
    fn no_cold_makes_the_rate_of_rifting_negative() {
        let constants = PlateConstants {
            rift_warmth: 2.0,
            ..default()
        };
        // 1 − 2 · 1 < 0.
        let rate = rate_of_rifting(&constants, [5e7, 2.5e7, 5e8], 14, -1.0);
        assert_eq!(rate, 0.0);
    }
}
