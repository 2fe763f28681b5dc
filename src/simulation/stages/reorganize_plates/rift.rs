//! Large plates break, continents first (Cortial et al. 2019: a Poisson process).

use super::{
    super::super::{
        boundaries::{Contact, Contacts},
        clock::Clock,
        columns::Columns,
        error::TectonicError,
        plate::{NextPlateId, Plate, PlateBorn, PlateTable, Rotation},
        recipe::Recipe,
        streams::{self, Purpose},
        sub_plate::{Crust, MaterialArea, PlateId, SubPlate},
        topology::Topology,
    },
    Outline, Splits, plate_areas,
};
use bevy::prelude::*;

/// Pairs of places from which the longest cut is chosen.
const TRIES: usize = 6;
/// Amplitude of the rift's wriggle, as a share of the distance between the two halves' centres.
const WARP: f64 = 0.25;
/// A tenth of the sphere, for which the rate is stated.
const NOMINAL_SHARE: f64 = 0.1;
/// The rate grows at most this much when there are few plates.
const MOST_URGENT: f64 = 4.0;

/// Breaks plates in two along a warped bisector between two far places on their continents.
pub(in crate::simulation) fn rift(
    mut commands: Commands,
    recipe: Res<Recipe>,
    clock: Res<Clock>,
    topology: Res<Topology>,
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
    let ratio = constants.plate_count / table.rows().len() as f64;
    let urgency = (ratio * ratio).min(MOST_URGENT);

    for (row, &size) in table.rows().iter().zip(&areas) {
        let share = size / sphere;
        if share < constants.rift_smallest || clock.time_my - row.born < constants.rift_youngest {
            continue;
        }
        let members: Vec<usize> = (0..plate.len()).filter(|&v| plate[v] == row.id).collect();
        let land: Vec<usize> = members
            .iter()
            .copied()
            .filter(|&v| crust[v].is_continental())
            .collect();
        let land_share = land.iter().map(|&v| area[v].0).sum::<f64>() / size.max(1.0);
        let rate =
            constants.rift_rate * (0.3 + 2.0 * land_share) * (share / NOMINAL_SHARE) * urgency;
        let mut rng = streams::stream(recipe.seed, Purpose::Rift, clock.steps, row.id.0.into());
        if streams::unit(&mut rng) >= 1.0 - libm::exp(-rate * time) {
            continue;
        }
        let places = if land.len() >= 2 { &land } else { &members };
        let mut ends = (
            0.0,
            mesh.site(places[0] as u32),
            mesh.site(places[0] as u32),
        );
        for _ in 0..TRIES {
            let a = mesh.site(places[streams::below(&mut rng, places.len())] as u32);
            let b = mesh.site(places[streams::below(&mut rng, places.len())] as u32);
            if a.distance_squared(b) > ends.0 {
                ends = (a.distance_squared(b), a, b);
            }
        }
        let (_, a, b) = ends;
        let outline = Outline::new(&mut rng, 1.5);
        let warp = WARP * a.distance(b);
        let side = |v: usize| {
            let site = mesh.site(v as u32);
            site.dot(b - a) + warp * a.distance(b) * outline.at(site) > (a + b).dot(b - a) * 0.5
        };
        let (far, near): (Vec<usize>, Vec<usize>) = members.iter().partition(|&&v| side(v));
        let smaller = if far.len() <= near.len() { far } else { near };
        let lost: f64 = smaller.iter().map(|&v| area[v].0).sum();
        if lost < constants.smallest * sphere * 4.0 {
            continue;
        }
        let Some(id) = next.take() else {
            return Ok(());
        };
        for v in smaller {
            plate[v] = id;
        }
        splits.suspected = true;
        commands.spawn((
            Plate { id },
            Rotation(row.rotation),
            PlateBorn(clock.time_my),
        ));
        if let Ok((.., mut born)) = plates.get_mut(row.entity) {
            born.0 = clock.time_my;
        }
        let contact = Contact {
            last_my: clock.time_my,
            rifted_my: Some(clock.time_my),
            ..default()
        };
        contacts.0.insert(Contacts::key(row.id, id), contact);
    }
    Ok(())
}
