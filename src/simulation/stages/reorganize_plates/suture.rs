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
    use crate::simulation::fixtures::random_mesh;

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
