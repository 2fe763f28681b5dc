//! Continents that have stopped closing become one plate, terranes change plates, and the sides of a
//! rift that failed join again.
//!
//! Once continents have interpenetrated by some 300 km, the smaller of the two that meet breaks off its
//! slab and goes over to the other plate (Cortial et al. 2019, section 4.2). The sea floor behind it stays
//! what it was: its margin is now a front, where it goes on sinking. Where the continent is large, or most
//! of its plate, the whole plate joins.

use super::{
    super::super::{
        boundaries::{Contact, Contacts},
        clock::Clock,
        columns::Columns,
        error::TectonicError,
        laws::CollisionLaw,
        ledger::Ledger,
        plate::{Plate, PlateBorn, PlateTable, Rotation},
        recipe::Recipe,
        sub_plate::*,
        topology::{EdgeState, Topology},
    },
    Splits, plate_areas,
    surge::{self, Uplands},
};
use crate::mesh::SphereMesh;
use bevy::prelude::*;

/// A collision at rest sutures after less interpenetration, in km, but with more contact.
const AT_REST_LENGTH: f64 = 100.0;
/// Share of continental contact that a collision at rest needs.
const AT_REST_SHARE: f64 = 0.35;
/// A continent that makes up more than this share of its plate takes the whole plate along.
const WHOLE_PLATE: f64 = 0.6;
/// No two plates become one larger than this share of the sphere (Earth's largest has 0.21): their continents
/// stay in collision, and can still slide round each other. Plates of a third of a planet hardly move, and
/// keep a supercontinent as sprawling as it met.
const LARGEST: f64 = 0.25;

type SutureColumns = (
    &'static mut PlateId,
    &'static Crust,
    &'static MaterialArea,
    &'static mut Slab,
    &'static mut Thickness,
    &'static mut Orogeny,
    &'static mut OrogenyBegan,
    &'static mut FoldDirection,
);

/// Welds at most one pair, a failed rift or else the pair that has interpenetrated furthest, and lets
/// at most one terrane go over.
pub(in crate::simulation) fn suture(
    recipe: Res<Recipe>,
    clock: Res<Clock>,
    topology: Res<Topology>,
    mut contacts: ResMut<Contacts>,
    mut splits: ResMut<Splits>,
    mut ledger: ResMut<Ledger>,
    mut plates: Query<(Entity, &Plate, &mut Rotation, &PlateBorn)>,
    mut sub_plates: Query<SutureColumns, With<SubPlate>>,
) -> Result<(), TectonicError> {
    if clock.reorganisation.due().is_none() {
        return Ok(());
    }
    let constants = &recipe.constants.plates;
    let table = PlateTable::gather(plates.iter());
    if table.rows().len() <= 2 {
        return Ok(());
    }
    let mesh = &topology.0;
    let (mut plate, crust, area, mut slab, mut thickness, mut orogeny, mut began, mut fold) =
        sub_plates.columns(mesh.vertex_count())?;
    let plate = plate.bypass_change_detection();
    let mut dock = |terrane: &[u32], speed: f64| {
        if recipe.laws.collision == CollisionLaw::Cortial {
            let mut uplands = Uplands {
                thickness: thickness.bypass_change_detection(),
                orogeny: orogeny.bypass_change_detection(),
                began: began.bypass_change_detection(),
                fold: fold.bypass_change_detection(),
            };
            surge::raise(
                &recipe,
                mesh,
                terrane,
                speed,
                clock.time_my,
                crust,
                area,
                &mut uplands,
                &mut ledger,
            );
        }
    };
    let areas = plate_areas(&table, plate, area);
    let sphere = 4.0 * core::f64::consts::PI * recipe.radius_km * recipe.radius_km;
    let too_large = |&(a, b): &(PlateId, PlateId)| {
        let of = |id| table.row(id).map_or(0.0, |row| areas[row]);
        of(a) + of(b) > LARGEST * sphere
    };
    let touching = |contact: &Contact| contact.last_my >= clock.time_my;
    let by_depth = |a: &(&(PlateId, PlateId), &Contact), b: &(&(PlateId, PlateId), &Contact)| {
        a.1.interpenetration.total_cmp(&b.1.interpenetration)
    };

    let colliding = contacts
        .0
        .iter()
        .filter(|(_, contact)| {
            touching(contact) && contact.interpenetration > constants.terrane_length
        })
        .max_by(by_depth)
        .map(|(&pair, _)| pair);
    if let Some((a, b)) = colliding {
        let (terrane, own, other) = Terrane::smaller_at_front(mesh, plate, crust, area, a, b);
        let whole = table.row(own).map_or(0.0, |row| areas[row]);
        let apart = terrane.area < WHOLE_PLATE * whole
            && terrane.area <= constants.terrane_largest * sphere;
        if terrane.area > 0.0 && apart {
            dock(&terrane.members, contacts.0[&(a, b)].closing);
            for &v in &terrane.members {
                plate[v as usize] = other;
                // The slab that pulled it in has broken off.
                for w in mesh.neighbours(v) {
                    slab.bypass_change_detection()[w as usize].0 = 0.0;
                }
            }
            splits.suspected = true;
            if let Some(contact) = contacts.0.get_mut(&(a, b)) {
                *contact = Contact {
                    last_my: contact.last_my,
                    subducting: Some(own),
                    ..default()
                };
            }
            return Ok(());
        }
    }

    let ready = contacts
        .0
        .iter()
        .filter(|(pair, contact)| {
            let deep = contact.interpenetration > constants.suture_length
                && contact.continental_share > constants.suture_share;
            let at_rest = contact.interpenetration > AT_REST_LENGTH
                && contact.closing < constants.suture_speed
                && contact.continental_share > AT_REST_SHARE;
            touching(contact) && (deep || at_rest) && !too_large(pair)
        })
        .max_by(by_depth);
    let push = recipe.constants.motion.rift_push_time;
    let failed = contacts.0.iter().find(|(_, contact)| {
        touching(contact)
            && contact.untorn_km > 0.0
            && contact.rift.is_some_and(|rift| {
                rift.stops_km.is_finite() && clock.time_my - rift.began_my > push
            })
    });
    let Some((&(a, b), contact)) = failed.or(ready) else {
        return Ok(());
    };
    if failed.is_none() {
        let (terrane, ..) = Terrane::smaller_at_front(mesh, plate, crust, area, a, b);
        dock(&terrane.members, contact.closing);
    }
    let (Some(i), Some(j)) = (table.row(a), table.row(b)) else {
        return Ok(());
    };
    // The smaller joins the larger, and their angular momentum is kept.
    let (gone, heir) = if areas[i] < areas[j] { (i, j) } else { (j, i) };
    let (gone_id, heir_id) = (table.rows()[gone].id, table.rows()[heir].id);
    let mean = (table.rows()[gone].rotation * areas[gone]
        + table.rows()[heir].rotation * areas[heir])
        / (areas[gone] + areas[heir]).max(1.0);
    if let Ok((_, _, mut rotation, _)) = plates.get_mut(table.rows()[heir].entity) {
        rotation.0 = mean;
    }
    for plate in plate.iter_mut().filter(|plate| **plate == gone_id) {
        *plate = heir_id;
    }
    contacts.inherit(gone_id, heir_id);
    // They met when fronts were drawn; smoothing may have taken away the only place where they did.
    splits.suspected = true;
    Ok(())
}

/// A connected continental region of one plate.
#[derive(Default)]
struct Terrane {
    members: Vec<u32>,
    /// Area in km².
    area: f64,
}

impl Terrane {
    /// The smaller of the two continents that meet at the front of two plates, its plate and the other.
    fn smaller_at_front(
        mesh: &SphereMesh<EdgeState>,
        plate: &[PlateId],
        crust: &[Crust],
        area: &[MaterialArea],
        a: PlateId,
        b: PlateId,
    ) -> (Self, PlateId, PlateId) {
        let first = Self::at_front(mesh, plate, crust, area, a, b);
        let second = Self::at_front(mesh, plate, crust, area, b, a);
        if first.area <= second.area {
            (first, a, b)
        } else {
            (second, b, a)
        }
    }

    /// The continent of a plate that touches most of another plate's continents. Empty if none does.
    fn at_front(
        mesh: &SphereMesh<EdgeState>,
        plate: &[PlateId],
        crust: &[Crust],
        area: &[MaterialArea],
        own: PlateId,
        other: PlateId,
    ) -> Self {
        let is =
            |v: u32, id: PlateId| plate[v as usize] == id && crust[v as usize].is_continental();
        let mut seen = vec![false; plate.len()];
        let mut best = (0, Self::default());
        for first in 0..plate.len() as u32 {
            if seen[first as usize] || !is(first, own) {
                continue;
            }
            let mut terrane = Self {
                members: vec![first],
                area: 0.0,
            };
            seen[first as usize] = true;
            let (mut next, mut touches) = (0, 0);
            while next < terrane.members.len() {
                let v = terrane.members[next];
                next += 1;
                terrane.area += area[v as usize].0;
                for w in mesh.neighbours(v) {
                    touches += u32::from(is(w, other));
                    if is(w, own) && !seen[w as usize] {
                        seen[w as usize] = true;
                        terrane.members.push(w);
                    }
                }
            }
            if touches > best.0 {
                best = (touches, terrane);
            }
        }
        best.1
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::simulation::{clock::Tick, fixtures::random_mesh};
    use bevy::ecs::system::RunSystemOnce;
    use glam::DVec3;

    /// A cap of some 20 of 2,000 cells.
    fn is_terrane(site: DVec3) -> bool {
        site.distance(DVec3::X) < 0.2
    }

    /// Plates 1 and 2 share a cap of a fifth of the sphere about the terrane; plate 3 has the rest.
    fn plate_at(site: DVec3) -> PlateId {
        PlateId(if site.x < 0.6 {
            3
        } else if site.y > 0.0 || is_terrane(site) {
            1
        } else {
            2
        })
    }

    /// What becomes of the terrane of plate 1 in front of a continent of plate 2 after they have closed by
    /// so many km, at 20 km/My; the largest terrane is a share of the sphere.
    fn collide(closed_km: f64, terrane_largest: f64) -> World {
        let mut recipe = Recipe::earth_like(1).with_sub_plates(2000);
        recipe.constants.plates.terrane_largest = terrane_largest;
        let mut clock = Clock {
            time_my: 99.0,
            reorganisation: Tick::after(recipe.constants.step.reorganisation),
            ..default()
        };
        clock.begin_step(&recipe);
        let mesh = random_mesh::<EdgeState>(2000);
        let rows: Vec<_> = mesh
            .sites()
            .iter()
            .map(|&site| {
                let plate = plate_at(site);
                let is_facing = plate == PlateId(2) && site.distance(DVec3::X) < 0.6;
                let crust = if is_facing || is_terrane(site) {
                    Crust::Continental
                } else {
                    Crust::Oceanic
                };
                let area = MaterialArea(recipe.cell_area_km2());
                (SubPlate, plate, crust, area, Slab(400.0))
            })
            .collect();
        let mut world = World::new();
        world.spawn_batch(rows);
        for (id, turn) in [(1, 0.02), (2, 0.0), (3, 0.0)] {
            world.spawn((Plate { id: PlateId(id) }, Rotation(DVec3::Z * turn)));
        }
        let mut contacts = Contacts::default();
        contacts.0.insert(
            (PlateId(1), PlateId(2)),
            Contact {
                last_my: clock.time_my,
                interpenetration: closed_km,
                closing: 20.0,
                continental_share: 0.5,
                ..default()
            },
        );
        world.insert_resource(contacts);
        world.insert_resource(recipe);
        world.insert_resource(clock);
        world.insert_resource(Topology(mesh));
        world.insert_resource(Splits::default());
        world.insert_resource(Ledger::default());
        let done: Result<(), TectonicError> = world.run_system_once(suture).unwrap();
        done.unwrap();
        world
    }

    #[test]
    fn a_terrane_goes_over_and_loses_its_slab_beyond_300_km() {
        for (closed_km, goes) in [(290.0, false), (310.0, true)] {
            let mut world = collide(closed_km, 0.02);
            let mut rows = world.query::<(&PlateId, &Slab)>();
            let mesh = &world.resource::<Topology>().0;
            let gone = |v: u32| goes && is_terrane(mesh.site(v));
            for ((plate, slab), v) in rows.iter(&world).zip(0..) {
                let expected = if gone(v) {
                    PlateId(2)
                } else {
                    plate_at(mesh.site(v))
                };
                assert_eq!(*plate, expected, "{v} after {closed_km} km");
                let is_broken = mesh.neighbours(v).any(gone);
                assert_eq!(slab.0, if is_broken { 0.0 } else { 400.0 }, "{v}");
            }
            assert_eq!(world.resource::<Splits>().suspected, goes);
            let contacts = world.resource::<Contacts>();
            let contact = contacts.get(PlateId(1), PlateId(2)).unwrap();
            // The sea floor behind the terrane goes on sinking, and the count begins anew.
            assert_eq!(contact.subducting, goes.then_some(PlateId(1)));
            let left = if goes { 0.0 } else { closed_km };
            assert_eq!(contact.interpenetration, left);
        }
    }

    #[test]
    fn plates_join_where_the_continent_is_too_large_to_go_over() {
        // 2 cells at most, and deeper than 350 km.
        let mut world = collide(400.0, 0.001);
        let mesh = &world.resource::<Topology>().0;
        let size = |id| {
            let sites = mesh.sites().iter();
            sites.filter(|&&site| plate_at(site) == PlateId(id)).count()
        };
        let (first, second) = (size(1), size(2));
        let heir = PlateId(if first < second { 2 } else { 1 });
        // Plate 1 turned at 0.02 rad/My, plate 2 rested.
        let mean = 0.02 * first as f64 / (first + second) as f64;
        let mut rows = world.query::<&PlateId>();
        let count = rows.iter(&world).filter(|id| **id == heir).count();
        assert_eq!(count, first + second);
        let mut plates = world.query::<(&Plate, &Rotation)>();
        let mut plates = plates.iter(&world);
        let (_, rotation) = plates.find(|(plate, _)| plate.id == heir).unwrap();
        assert!((rotation.0 - DVec3::Z * mean).length() < 1e-12);
        assert!(world.resource::<Contacts>().0.is_empty());
    }

    #[test]
    fn the_terrane_is_the_continent_at_the_front() {
        let mesh = random_mesh::<EdgeState>(2000);
        // Two plates, east and west of the plane y = 0. The eastern one has a continent at the front
        // and another far from it; the western one is all continent.
        let plate: Vec<PlateId> = mesh
            .sites()
            .iter()
            .map(|s| PlateId(if s.y > 0.0 { 1 } else { 2 }))
            .collect();
        let near = |s: &glam::DVec3| s.y > 0.0 && s.distance(glam::DVec3::X) < 0.5;
        let far = |s: &glam::DVec3| s.distance(glam::DVec3::Y) < 0.3;
        let crust: Vec<Crust> = mesh
            .sites()
            .iter()
            .map(|s| {
                if s.y <= 0.0 || near(s) || far(s) {
                    Crust::Continental
                } else {
                    Crust::Oceanic
                }
            })
            .collect();
        let area = vec![MaterialArea(2.0); 2000];
        let terrane = Terrane::at_front(&mesh, &plate, &crust, &area, PlateId(1), PlateId(2));
        let expected = mesh.sites().iter().filter(|s| near(s)).count();
        assert!(expected > 30 && terrane.members.len() == expected);
        assert_eq!(terrane.area, 2.0 * expected as f64);
        assert!(terrane.members.iter().all(|&v| near(&mesh.site(v))));
        let none = Terrane::at_front(&mesh, &plate, &crust, &area, PlateId(1), PlateId(3));
        assert!(none.members.is_empty());
    }
}
