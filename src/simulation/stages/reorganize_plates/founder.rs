//! Old sea floor starts to sink at its margin: a new trench, and a new plate behind it.

use super::{
    super::super::{
        boundaries::{Contact, Contacts},
        clock::Clock,
        columns::Columns,
        error::TectonicError,
        plate::{NextPlateId, Plate, PlateBorn, PlateTable, Rotation},
        reach::reach,
        recipe::Recipe,
        stages::Mantle,
        streams::{self, Purpose},
        sub_plate::{Created, Crust, MaterialArea, PlateId, Slab, SubPlate},
        topology::{EdgeState, Topology},
        workers::Workers,
    },
    Outline, Splits,
};
use crate::mesh::SphereMesh;
use bevy::prelude::*;

/// A passive margin is worth this many My of age: continents load the floor beside them.
const MARGIN_BONUS: f64 = 40.0;
/// An existing boundary counts against a new one.
const BOUNDARY_MALUS: f64 = 60.0;
/// Places that are tried before the attempt is put off.
const TRIES: usize = 8;
/// Share of old floor at which the rate is nominal, and by how much it can grow.
const OLD_SHARE: f64 = 0.01;
const MOST_URGENT: f64 = 3.0;
/// Age beyond the first at which any floor founders at the nominal rate, in My.
const OVERDUE: f64 = 20.0;
/// Slab that a new trench starts with where the floor is old, in km. It must overcome the friction
/// of a front that does not move yet.
const FIRST_SLAB: f32 = 600.0;
/// Smallest new plate in sphere shares.
const SMALLEST: f64 = 0.003;

/// Lets the oldest sea floor founder, at most one place at a time.
pub(in crate::simulation) fn founder(
    mut commands: Commands,
    recipe: Res<Recipe>,
    clock: Res<Clock>,
    mantle: Res<Mantle>,
    topology: Res<Topology>,
    workers: Res<Workers>,
    mut contacts: ResMut<Contacts>,
    mut next: ResMut<NextPlateId>,
    mut splits: ResMut<Splits>,
    plates: Query<(Entity, &Plate, &Rotation, &PlateBorn)>,
    mut sub_plates: Query<
        (&mut PlateId, &Crust, &Created, &MaterialArea, &mut Slab),
        With<SubPlate>,
    >,
) -> Result<(), TectonicError> {
    let Some(time) = clock.reorganisation.due() else {
        return Ok(());
    };
    let mesh = &topology.0;
    let (mut plate, crust, created, area, mut slab) = sub_plates.columns(mesh.vertex_count())?;
    let plate = plate.bypass_change_detection();
    let slab = slab.bypass_change_detection();
    let constants = &recipe.constants.plates;
    let sphere = 4.0 * core::f64::consts::PI * recipe.radius_km * recipe.radius_km;
    let age = |v: usize| clock.time_my - f64::from(created[v].0);
    // Where the mantle sinks, plates are pressed together and floor gives way younger.
    let ripeness = |v: usize| {
        let cold = (-mantle.warmth_at(mesh.site(v as u32))).max(0.0);
        age(v) * (1.0 + constants.founder_pressed * cold)
    };

    let score = |v: usize| {
        if crust[v].is_continental() {
            return None;
        }
        let ripeness = ripeness(v);
        let around = || mesh.neighbours(v as u32).map(|w| w as usize);
        (ripeness >= constants.founder_age).then(|| {
            let mut score = ripeness;
            if around().any(|w| plate[w] != plate[v]) {
                score -= BOUNDARY_MALUS;
            }
            if around().any(|w| crust[w].is_continental()) {
                score += MARGIN_BONUS;
            }
            (score, v)
        })
    };
    let candidates = workers.map(plate.len(), |rows| {
        rows.filter_map(score).collect::<Vec<(f64, usize)>>()
    });
    let mut candidates = candidates.concat();
    let old_area: f64 = candidates.iter().map(|&(_, v)| area[v].0).sum();
    // Much old floor, or a little that is very old.
    let oldest = candidates
        .iter()
        .map(|&(_, v)| ripeness(v))
        .fold(0.0, f64::max);
    let overdue = (oldest - constants.founder_age) / OVERDUE;
    let urgency = (old_area / sphere / OLD_SHARE)
        .max(overdue)
        .min(MOST_URGENT);
    let mut rng = streams::stream(recipe.seed, Purpose::Foundering, clock.steps, 0);
    let chance = 1.0 - libm::exp(-time / constants.founder_time * urgency);
    if candidates.is_empty() || streams::unit(&mut rng) >= chance {
        return Ok(());
    }
    candidates.sort_by(|a, b| b.0.total_cmp(&a.0).then(a.1.cmp(&b.1)));
    let table = PlateTable::gather(plates.iter());

    // Further tries look elsewhere, not at the next vertex.
    let mut tried: Vec<glam::DVec3> = Vec::new();
    for (_, v) in candidates {
        let site = mesh.site(v as u32);
        if tried.iter().any(|other| other.distance(site) < 0.15) {
            continue;
        }
        if tried.len() == TRIES {
            break;
        }
        tried.push(site);
        let far = constants.founder_near
            + (constants.founder_far - constants.founder_near).max(0.0) * streams::unit(&mut rng);
        let outline = Outline::new(&mut rng, 1.2);
        let piece = sinking_piece(mesh, &recipe, plate, crust, v, far, &outline);
        let size: f64 = piece.iter().map(|&w| area[w].0).sum();
        let left = plate.iter().zip(area).filter(|(id, _)| **id == plate[v]);
        let left = left.map(|(_, area)| area.0).sum::<f64>() - size;
        if size < SMALLEST * sphere || left < 0.25 * SMALLEST * sphere {
            continue;
        }
        let Some(id) = next.take() else {
            return Ok(());
        };
        let parent = plate[v];
        for &w in &piece {
            plate[w] = id;
        }
        for &w in &piece {
            let old = age(w) > 0.6 * constants.founder_age;
            for over in mesh.neighbours(w as u32).map(|over| over as usize) {
                if old && plate[over] == parent {
                    slab[over].0 = slab[over].0.max(FIRST_SLAB);
                }
            }
        }
        splits.suspected = true;
        commands.spawn((
            Plate { id },
            Rotation(table.rotation(parent)),
            PlateBorn(clock.time_my),
        ));
        let contact = Contact {
            last_my: clock.time_my,
            subducting: Some(id),
            ..default()
        };
        contacts.0.insert(Contacts::key(parent, id), contact);
        break;
    }
    Ok(())
}

/// The connected sea floor of a plate around a vertex, within a warped distance. Where the whole
/// plate is sea floor it is cut at the vertex.
fn sinking_piece(
    mesh: &SphereMesh<EdgeState>,
    recipe: &Recipe,
    plate: &[PlateId],
    crust: &[Crust],
    v: usize,
    far: f64,
    outline: &Outline,
) -> Vec<usize> {
    let site = mesh.site(v as u32);
    let beside_land = mesh
        .neighbours(v as u32)
        .any(|w| crust[w as usize].is_continental());
    // In the open sea the front must run through the vertex: one side of a line stays.
    let normal = if beside_land {
        glam::DVec3::ZERO
    } else {
        let members = (0..plate.len()).filter(|&w| plate[w] == plate[v]);
        let centre: glam::DVec3 = members.map(|w| mesh.site(w as u32)).sum();
        (centre - site * site.dot(centre)).normalize_or_zero()
    };
    let inside = |w: u32| {
        let place = mesh.site(w);
        let behind = normal == glam::DVec3::ZERO
            || (place - site).dot(normal) + 0.08 * outline.at(place) >= -1e-9
            || w as usize == v;
        behind
            && plate[w as usize] == plate[v]
            && !crust[w as usize].is_continental()
            && place.distance(site) * recipe.radius_km < far * (1.0 + 0.35 * outline.at(place))
    };
    reach(
        &Workers::default(),
        mesh,
        recipe.radius_km,
        &[(v as u32, 0.0)],
        2.0 * far,
        inside,
    )
    .found
    .into_iter()
    .map(|(w, ..)| w as usize)
    .collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::simulation::{clock::Tick, fixtures::random_mesh};
    use bevy::ecs::system::RunSystemOnce;
    use glam::DVec3;

    /// What becomes of floor of an age in My round a continent at X, both of plate 1, where the mantle sinks at
    /// `downwelling`. The other hemisphere, plate 2, is floor that has just been made. Floor founders from 150 My on.
    fn foundered(age: f32, downwelling: DVec3) -> World {
        let mut recipe = Recipe::earth_like(1).with_sub_plates(2000);
        recipe.constants.plates.founder_age = 150.0;
        // After so long the chance is 1.
        let mut clock = Clock {
            time_my: 99.0,
            reorganisation: Tick::after(1e6),
            ..default()
        };
        clock.begin_step(&recipe);
        let mesh = random_mesh::<EdgeState>(2000);
        let rows: Vec<_> = mesh
            .sites()
            .iter()
            .map(|&site| {
                let (plate, age) = if site.x > 0.0 { (1, age) } else { (2, 0.0) };
                let crust = if site.distance(DVec3::X) < 0.5 {
                    Crust::Continental
                } else {
                    Crust::Oceanic
                };
                let created = Created(clock.time_my as f32 - age);
                let area = MaterialArea(recipe.cell_area_km2());
                (SubPlate, PlateId(plate), crust, created, area)
            })
            .collect();
        let mut world = World::new();
        world.spawn_batch(rows);
        for id in [1, 2] {
            world.spawn(Plate { id: PlateId(id) });
        }
        world.insert_resource(recipe);
        world.insert_resource(clock);
        world.insert_resource(Mantle {
            downwelling,
            ..default()
        });
        world.insert_resource(Topology(mesh));
        world.insert_resource(Workers::default());
        world.insert_resource(Contacts::default());
        world.insert_resource(NextPlateId(3));
        world.insert_resource(Splits::default());
        let done: Result<(), TectonicError> = world.run_system_once(founder).unwrap();
        done.unwrap();
        world
    }

    #[test]
    fn floor_founders_once_it_is_old_enough_or_pressed() {
        let plates = |age, downwelling| {
            let mut world = foundered(age, downwelling);
            world.query::<&Plate>().iter(&world).count()
        };
        assert_eq!(plates(149.0, DVec3::ZERO), 2);
        assert_eq!(plates(151.0, DVec3::ZERO), 3);
        // Beside the continent, at x = 0.87, floor of 100 My counts 1 + 0.8 · 0.87 times as much: 170 My.
        assert_eq!(plates(100.0, DVec3::X), 3);
        assert_eq!(plates(100.0, DVec3::NEG_X), 2);
    }

    #[test]
    fn what_founders_is_the_floor_in_front_of_a_continent() {
        let mut world = foundered(151.0, DVec3::ZERO);
        let mut rows = world.query::<(&PlateId, &Crust, &Slab)>();
        let rows: Vec<_> = rows.iter(&world).collect();
        let mesh = &world.resource::<Topology>().0;
        let sinks = |v: u32| *rows[v as usize].0 == PlateId(3);
        for (&(plate, crust, slab), v) in rows.iter().zip(0..) {
            // No land, and nothing of the other plate.
            assert!(!sinks(v) || (!crust.is_continental() && mesh.site(v).x > 0.0));
            let is_over = *plate == PlateId(1) && mesh.neighbours(v).any(sinks);
            assert_eq!(slab.0, if is_over { FIRST_SLAB } else { 0.0 });
        }
        let mut over = rows.iter().filter(|(_, _, slab)| slab.0 > 0.0);
        assert!(over.any(|(_, crust, _)| crust.is_continental()));
        let contacts = world.resource::<Contacts>();
        let contact = contacts.get(PlateId(1), PlateId(3)).unwrap();
        assert_eq!(contact.subducting, Some(PlateId(3)));
        assert!(world.resource::<Splits>().suspected);
    }
}
