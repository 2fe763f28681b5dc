//! Rigid plates that keep their rotations, and slabs that turn the axes (Cortial et al. 2019).
//!
//! `w ← w + ε Σ (c × q)/|c × q| dt`, `c` the plate's centroid, `q` the points of its subducting
//! fronts, `w` the axis of unit length: the speed stays what it was, so that nothing runs away. The
//! paper sums over points; here the sum is over the length of the fronts, so that it does not grow
//! with the mesh. Whoever prescribes motions sets [`Rotation`] at any time.
//!
//! Events are what gives plates new motions: the halves of a rift diverge (section 4.4), and sea floor
//! that starts to founder, which the paper does not know, sets out for its trench. Without the latter
//! sea floor that no plate happens to run over would never end.

use super::super::super::{
    boundaries::{Boundaries, Contact, Contacts, Front},
    clock::Clock,
    columns::Columns,
    error::TectonicError,
    plate::{Plate, PlateBorn, PlateTable, Rotation},
    recipe::Recipe,
    streams::{self, Purpose},
    sub_plate::{Crust, MaterialArea, PlateId, SubPlate},
    topology::Topology,
};
use bevy::prelude::*;
use glam::DVec3;
use rand_chacha::ChaCha8Rng;

/// Largest angle in rad by which a random part turns the parting of a rift from the straight one.
const RIFT_OBLIQUITY: f64 = 0.5;

/// Sends the halves of new rifts apart and foundering plates to their trenches, and turns the axes of
/// all plates towards theirs.
pub(in crate::simulation) fn turn_axes(
    recipe: Res<Recipe>,
    clock: Res<Clock>,
    boundaries: Res<Boundaries>,
    contacts: Res<Contacts>,
    topology: Res<Topology>,
    mut plates: Query<(Entity, &Plate, &mut Rotation, &PlateBorn)>,
    mut sub_plates: Query<(&PlateId, &Crust, &MaterialArea), With<SubPlate>>,
) -> Result<(), TectonicError> {
    let mesh = &topology.0;
    let (plate, crust, area) = sub_plates.columns(mesh.vertex_count())?;
    let table = PlateTable::gather(plates.iter());
    let constants = &recipe.constants.prescribed;
    let mut centroids = vec![DVec3::ZERO; table.rows().len()];
    let mut oceanic = vec![true; table.rows().len()];
    for (v, id) in plate.iter().enumerate() {
        if let Some(row) = table.row(*id) {
            centroids[row] += mesh.site(v as u32) * area[v].0;
            oceanic[row] &= !crust[v].is_continental();
        }
    }
    let mut rotations: Vec<DVec3> = table.rows().iter().map(|row| row.rotation).collect();
    // What happens at the end of a step is met at the next.
    let fresh = |time_my: f64| clock.time_my - time_my < clock.step_my * 1.000_001;

    for (&(a, b), contact) in &contacts.0 {
        let rifted = contact.rift.is_some_and(|rift| fresh(rift.began_my));
        if let (true, Some(i), Some(j)) = (rifted, table.row(a), table.row(b)) {
            let number = u64::from(a.0) << 16 | u64::from(b.0);
            let mut rng = streams::stream(recipe.seed, Purpose::Rotations, clock.steps, number);
            let speed = first_speed(&recipe, &mut rng);
            let angle = RIFT_OBLIQUITY * (2.0 * streams::unit(&mut rng) - 1.0);
            let half = parting(centroids[i], centroids[j], angle) * (0.5 * speed);
            rotations[i] -= half;
            rotations[j] += half;
        }
    }

    // Plates of sea floor that were born with the polarity of their trench.
    let founders: Vec<bool> = table
        .rows()
        .iter()
        .zip(oceanic)
        .map(|(row, oceanic)| {
            let sinks = |(&(a, b), contact): (&(PlateId, PlateId), &Contact)| {
                (a == row.id || b == row.id)
                    && contact.subducting == Some(row.id)
                    && contact.rift.is_none()
            };
            oceanic && row.born > 0.0 && fresh(row.born) && contacts.0.iter().any(sinks)
        })
        .collect();
    let pulls = slab_pulls(&table, &boundaries.fronts, &centroids, &founders);
    for (row, plate) in table.rows().iter().enumerate() {
        if founders[row] {
            let mut rng = streams::stream(
                recipe.seed,
                Purpose::Rotations,
                clock.steps,
                plate.id.0.into(),
            );
            rotations[row] += pulls[row].normalize_or_zero() * first_speed(&recipe, &mut rng);
        }
    }
    let fastest = constants.fastest / recipe.radius_km;
    for (row, plate) in table.rows().iter().enumerate() {
        let turned = turned(
            rotations[row],
            pulls[row] * (constants.slab_turn * clock.step_my),
        );
        if let Ok((_, _, mut rotation, _)) = plates.get_mut(plate.entity) {
            rotation.0 = turned.clamp_length_max(fastest);
        }
    }
    Ok(())
}

/// `Σ (c × q)/|c × q|` over the length in km of the fronts at which each plate goes under. Founders are
/// pulled even where their fronts do not close yet.
fn slab_pulls(
    table: &PlateTable,
    fronts: &[Front],
    centroids: &[DVec3],
    founders: &[bool],
) -> Vec<DVec3> {
    let mut pulls = vec![DVec3::ZERO; table.rows().len()];
    for front in fronts {
        if let Some(under) = front.under
            && let Some(row) = table.row(front.plates[under])
            && (front.opening < 0.0 || founders[row])
        {
            let turn = centroids[row].cross(front.midpoint).normalize_or_zero();
            // The chord of the front, whose zigzag costs nothing.
            pulls[row] += turn * front.normal.dot(front.direction).abs();
        }
    }
    pulls
}

/// Speed of a plate's new motion in rad/My.
fn first_speed(recipe: &Recipe, rng: &mut ChaCha8Rng) -> f64 {
    let constants = &recipe.constants.prescribed;
    let range = (constants.first_fastest - constants.first_slowest).max(0.0);
    (constants.first_slowest + range * streams::unit(rng)) / recipe.radius_km
}

/// A rotation whose axis is drawn by `pull`; its speed stays. A plate at rest stays at rest.
fn turned(rotation: DVec3, pull: DVec3) -> DVec3 {
    let speed = rotation.length();
    (rotation.normalize_or_zero() + pull).normalize_or_zero() * speed
}

/// Axis that carries `b` away from `a`, turned about the place between them by an angle in rad.
fn parting(a: DVec3, b: DVec3, angle: f64) -> DVec3 {
    let (a, b) = (a.normalize_or_zero(), b.normalize_or_zero());
    let axis = a.cross(b).normalize_or_zero();
    let between = (a + b).normalize_or_zero();
    let (sin, cos) = libm::sincos(angle);
    axis * cos + between.cross(axis) * sin
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn slab_pull_turns_the_axis_towards_the_trench() {
        // Centroid x, front at y: (x × y)/|x × y| = z. From an axis along −x + 0 z, a pull of 0.75 z
        // gives (−1, 0, 0.75)/1.25 = (−0.8, 0, 0.6); the speed 0.01 stays.
        let pull = DVec3::X.cross(DVec3::Y).normalize() * 0.75;
        let after = turned(DVec3::NEG_X * 0.01, pull);
        assert!((after - DVec3::new(-0.008, 0.0, 0.006)).length() < 1e-15);
        // The plate at x now moves towards the front at y.
        assert!(after.cross(DVec3::X).dot(DVec3::Y) > 0.0);
        assert_eq!(turned(DVec3::ZERO, DVec3::ZERO), DVec3::ZERO);
    }

    #[test]
    fn halves_of_a_rift_part() {
        let (a, b) = (DVec3::X, DVec3::new(0.8, 0.6, 0.0));
        for angle in [-0.5, 0.0, 0.5] {
            let axis = parting(a, b, angle);
            assert!((axis.length() - 1.0).abs() < 1e-12);
            assert!(axis.cross(b).dot(b - a) > 0.0);
            assert!((-axis).cross(a).dot(a - b) > 0.0);
        }
    }

    /// A front that opens at a speed in km/My across a direction.
    fn front(
        plates: [u16; 2],
        midpoint: DVec3,
        normal: DVec3,
        direction: DVec3,
        under: Option<usize>,
        opening: f64,
    ) -> Front {
        Front {
            edge: 0,
            vertices: [0, 1],
            plates: plates.map(PlateId),
            normal,
            length: normal.length(),
            direction,
            midpoint,
            slip: direction * opening,
            opening,
            continental: false,
            under,
        }
    }

    #[test]
    fn each_front_pulls_the_plate_that_goes_under_by_its_length() {
        let plates = [Plate { id: PlateId(1) }, Plate { id: PlateId(2) }];
        let (rotation, born) = (Rotation::default(), PlateBorn::default());
        let rows = plates
            .iter()
            .map(|plate| (Entity::PLACEHOLDER, plate, &rotation, &born));
        let table = PlateTable::gather(rows);
        // Sums of sites by area: their lengths do not count.
        let centroids = [DVec3::X * 3e6, DVec3::NEG_X * 2e6];
        let [x, y, z] = DVec3::AXES;
        let near = DVec3::new(0.8, 0.6, 0.0);
        let across = DVec3::new(-0.6, 0.8, 0.0);
        let oblique = DVec3::new(-300.0, 0.0, 400.0);
        let fronts = [
            // (x × y)/|x × y| = z. Of 500 km, 300 lie along the front: 300 z.
            front([1, 2], y, oblique, -x, Some(0), -40.0),
            // x × z = −y, and the second plate goes under: −200 y.
            front([2, 1], z, x * 200.0, x, Some(1), -40.0),
            // x × (0.8, 0.6, 0) = 0.6 z, which counts as z: 100 z.
            front([1, 2], near, across * 100.0, across, Some(0), -40.0),
            // Neither goes under.
            front([1, 2], -y, -x * 700.0, -x, None, -40.0),
            // It opens: nothing, or for a founder x × −z = y: 50 y.
            front([1, 2], -z, -x * 50.0, -x, Some(0), 10.0),
        ];
        let pulls = slab_pulls(&table, &fronts, &centroids, &[false, false]);
        assert!((pulls[0] - DVec3::new(0.0, -200.0, 400.0)).length() < 1e-9);
        assert_eq!(pulls[1], DVec3::ZERO);
        // ε dt = 0.0025: from the axis x to (1, −0.5, 1), whose length is 1.5.
        let after = turned(x * 0.01, pulls[0] * 0.0025);
        assert!((after - DVec3::new(1.0, -0.5, 1.0) * (0.01 / 1.5)).length() < 1e-12);

        let pulls = slab_pulls(&table, &fronts, &centroids, &[true, false]);
        assert!((pulls[0] - DVec3::new(0.0, -150.0, 400.0)).length() < 1e-9);
        assert_eq!(pulls[1], DVec3::ZERO);
    }
}
