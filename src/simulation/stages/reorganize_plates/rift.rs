//! Large plates break, continents first (Cortial et al. 2019: a Poisson process).
//!
//! A plate breaks into two to four pieces, cells of random places on its continents under
//! noise-warped distance. The pieces are plates at once, but stay welded wherever the tear has not
//! passed yet: it runs from one end of the cut, or outwards from the place where three pieces meet,
//! and some rifts in two stall. What stalls becomes one plate again in [`suture`](super::suture), with
//! a basin of stretched crust where it had begun to part.

use super::{
    super::super::{
        boundaries::{Contact, Contacts, Rift},
        clock::Clock,
        columns::Columns,
        error::TectonicError,
        plate::{NextPlateId, Plate, PlateBorn, PlateRow, PlateTable, Rotation},
        recipe::Recipe,
        stages::Mantle,
        streams::{self, Purpose},
        sub_plate::{Crust, MaterialArea, PlateId, SubPlate},
        topology::{EdgeState, Topology},
    },
    Outline, Splits, plate_areas,
};
use crate::mesh::SphereMesh;
use bevy::prelude::*;
use glam::DVec3;
use rand_chacha::ChaCha8Rng;

/// Places among which each further centre of a piece is chosen, the farthest from those before.
const TRIES: usize = 6;
/// Amplitude of the rift's wriggle, as a share of the distance between the first two centres.
const WARP: f64 = 0.25;
/// A tenth of the sphere, for which the rate is stated.
const NOMINAL_SHARE: f64 = 0.1;
/// The rate grows at most this much when there are few plates.
const MOST_URGENT: f64 = 4.0;
/// Chances of three and of four pieces: plumes break continents in three arms, rarely more.
const THREE_PIECES: f64 = 0.22;
const FOUR_PIECES: f64 = 0.08;
/// Share of its cut after which a failing rift stalls.
const STALLS: core::ops::Range<f64> = 0.3..0.7;

/// Breaks plates, more often where they are large, continental and warmed from below.
pub(in crate::simulation) fn rift(
    mut commands: Commands,
    recipe: Res<Recipe>,
    clock: Res<Clock>,
    mantle: Res<Mantle>,
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
        let land_area = land.iter().map(|&v| area[v].0).sum::<f64>();
        let middle: DVec3 = land.iter().map(|&v| mesh.site(v as u32) * area[v].0).sum();
        let warm = 1.0 + constants.rift_warmth * mantle.warmth_at(middle.normalize_or_zero());
        let rate = constants.rift_rate
            * (0.3 + 2.0 * land_area / size.max(1.0))
            * (share / NOMINAL_SHARE)
            * urgency
            * warm.max(0.0);
        let mut rng = streams::stream(recipe.seed, Purpose::Rift, clock.steps, row.id.0.into());
        if streams::unit(&mut rng) >= 1.0 - libm::exp(-rate * time) {
            continue;
        }
        let places = if land.len() >= 2 { &land } else { &members };
        let cut = Cut::draw(mesh, &recipe, &mut rng, &members, places);
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

/// How a plate is to be broken.
pub(in crate::simulation) struct Cut {
    /// Sub-plates of each piece.
    pub pieces: Vec<Vec<usize>>,
    /// Where the tear begins.
    pub from: DVec3,
    /// Pace of the tear, in km/My.
    pub pace: f64,
    /// Distance from there at which it stops, in km.
    pub stops_km: f64,
}

impl Cut {
    /// A cut into two to four cells of random places.
    fn draw(
        mesh: &SphereMesh<EdgeState>,
        recipe: &Recipe,
        rng: &mut ChaCha8Rng,
        members: &[usize],
        places: &[usize],
    ) -> Self {
        let fate = streams::unit(rng);
        let count = if fate < FOUR_PIECES {
            4
        } else if fate < FOUR_PIECES + THREE_PIECES {
            3
        } else {
            2
        };
        let centres = centres(mesh, rng, places, count);
        let apart = centres[0].distance(centres[1]);
        let outlines: Vec<Outline> = centres.iter().map(|_| Outline::new(rng, 1.5)).collect();
        let mut pieces = vec![Vec::new(); count];
        for &v in members {
            let site = mesh.site(v as u32);
            let mut best = (f64::MAX, 0);
            for (i, (centre, outline)) in centres.iter().zip(&outlines).enumerate() {
                let far = site.distance(*centre) + WARP * apart * outline.at(site);
                if far < best.0 {
                    best = (far, i);
                }
            }
            pieces[best.1].push(v);
        }
        let mut cut = Self {
            pieces,
            from: centres.iter().sum::<DVec3>().normalize_or(centres[0]),
            pace: recipe.constants.plates.tear_pace,
            stops_km: f64::INFINITY,
        };
        let along = cut.places(mesh);
        let Some(&first) = along.first() else {
            return cut;
        };
        // In two: from the end that lies farthest from the middle. In more: from where they meet.
        let mut begin = first;
        for &place in &along {
            let nearer = place.distance(cut.from) < begin.distance(cut.from);
            if nearer == (count > 2) {
                begin = place;
            }
        }
        cut.from = begin;
        let length = along.iter().map(|p| p.distance(begin)).fold(0.0, f64::max) * recipe.radius_km;
        if count == 2 && streams::unit(rng) < recipe.constants.plates.rift_failure {
            let share = STALLS.start + (STALLS.end - STALLS.start) * streams::unit(rng);
            cut.stops_km = share * length;
        }
        cut
    }

    /// Places of the sub-plates along the cut.
    fn places(&self, mesh: &SphereMesh<EdgeState>) -> Vec<DVec3> {
        let mut piece = vec![usize::MAX; mesh.vertex_count()];
        for (i, members) in self.pieces.iter().enumerate() {
            for &v in members {
                piece[v] = i;
            }
        }
        let beside = |v: &usize| {
            mesh.neighbours(*v as u32)
                .any(|w| piece[w as usize] != piece[*v] && piece[w as usize] != usize::MAX)
        };
        let members = self.pieces.iter().flatten().copied();
        members
            .filter(beside)
            .map(|v| mesh.site(v as u32))
            .collect()
    }
}

/// Centres of the pieces: a random place, then each time the farthest of a few from those before.
fn centres(
    mesh: &SphereMesh<EdgeState>,
    rng: &mut ChaCha8Rng,
    places: &[usize],
    count: usize,
) -> Vec<DVec3> {
    let mut draw = || mesh.site(places[streams::below(rng, places.len())] as u32);
    let mut centres = vec![draw()];
    while centres.len() < count {
        let mut best = (-1.0, DVec3::ZERO);
        for _ in 0..TRIES {
            let place = draw();
            let near = centres
                .iter()
                .map(|centre| centre.distance_squared(place))
                .fold(f64::MAX, f64::min);
            if near > best.0 {
                best = (near, place);
            }
        }
        centres.push(best.1);
    }
    centres
}

/// Makes plates of the pieces of a cut; the largest stays what it was. Pieces below the smallest area
/// in km² stay with it. Whether anything was broken off.
#[expect(
    clippy::too_many_arguments,
    reason = "all that a plate's birth touches"
)]
pub(in crate::simulation) fn break_plate(
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
    use crate::simulation::fixtures::random_mesh;

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

    #[test]
    fn cuts_share_out_every_sub_plate_and_begin_at_the_cut() {
        let recipe = Recipe::earth_like(3).with_sub_plates(800);
        let mesh = random_mesh::<EdgeState>(800);
        let members: Vec<usize> = (0..800).filter(|&v| mesh.site(v as u32).z > 0.0).collect();
        let mut counts = [0; 5];
        for number in 0..60 {
            let mut rng = streams::stream(3, Purpose::Rift, 0, number);
            let cut = Cut::draw(&mesh, &recipe, &mut rng, &members, &members);
            counts[cut.pieces.len()] += 1;
            let mut all: Vec<usize> = cut.pieces.concat();
            all.sort_unstable();
            assert_eq!(all, members);
            let near = cut
                .places(&mesh)
                .iter()
                .map(|p| p.distance(cut.from))
                .fold(f64::MAX, f64::min);
            assert!(near < 1e-12, "{near}");
        }
        assert!(
            counts[2] > counts[3] && counts[3] > 0 && counts[4] > 0,
            "{counts:?}"
        );
    }
}
