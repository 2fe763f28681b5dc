//! Soft margins: what pushes them, and what it makes of their crust.
//!
//! Where continents collide, their fronts yield by a share of the closing speed (Yggdrasill's
//! response, with its falloff over the distance of the two ends); where a continent advances on a trench,
//! its margin is shortened into a cordillera. Old slabs roll back in place of pressing, and draw the margin above
//! them seaward and thin. Springs carry that inland ([`springs`](super::springs)), and what a
//! cell loses or gains in area thickens or thins its crust. What is shortened is a mountain belt for as long as it
//! is: its thick crust does not flow away.

use super::{
    super::super::{
        boundaries::Boundaries,
        clock::Clock,
        columns::Columns,
        constants::MarginConstants,
        error::TectonicError,
        ledger::Ledger,
        plate::{Plate, PlateBorn, PlateTable, Rotation},
        precision::{THICKNESS_STEPS, round, round_area},
        reach::reach,
        recipe::{Drive, Recipe},
        stages::uplift::folded,
        sub_plate::*,
        topology::{EdgeState, Topology},
        workers::Workers,
    },
    springs::{self, Ground, Margin, Places},
};
use crate::mesh::SphereMesh;
use bevy::prelude::*;
use core::cmp::Reverse;
use glam::{DVec3, Vec3};
use std::collections::{BTreeMap, BTreeSet};

/// Pushes below this bend nothing worth the work, in km/My.
const LEAST_PUSH: f64 = 1.0;
/// A cordillera yields less the nearer its margin comes to the thickness of a plateau, in km.
const ROOM: f64 = 10.0;
/// A cell that has shrunk to this share of the nominal one shrinks no further: it is about to be crushed.
const LEAST_AREA: f64 = 0.25;
/// Largest change of a cell's area at once.
const LARGEST_STRAIN: f64 = 0.5;

/// Rate at which a cell's ground shrinks beyond which it is a mountain belt, per My: 2 mm/yr over 600 km.
const PRESSING: f64 = 0.003;
/// Time after which a belt that is still pressed is noted as such again, in My.
const NOTED: f64 = 1.0;

/// Bends the margins: sets the deviation of every sub-plate from its plate's rotation, and thickens
/// or thins the crust by what its cell loses or gains in area.
pub(in crate::simulation) fn bend_margins(
    recipe: Res<Recipe>,
    clock: Res<Clock>,
    workers: Res<Workers>,
    boundaries: Res<Boundaries>,
    mut topology: ResMut<Topology>,
    mut ledger: ResMut<Ledger>,
    plates: Query<(Entity, &Plate, &Rotation, &PlateBorn)>,
    mut sub_plates: Query<
        (
            &PlateId,
            &Crust,
            &Created,
            &mut Deviation,
            &mut Thickness,
            &mut MaterialArea,
            &mut Orogeny,
            &mut OrogenyBegan,
            &mut FoldDirection,
        ),
        With<SubPlate>,
    >,
) -> Result<(), TectonicError> {
    let mesh = &mut topology.0;
    let (
        plate,
        crust,
        created,
        mut deviation,
        mut thickness,
        mut area,
        mut orogeny,
        mut began,
        mut fold,
    ) = sub_plates.columns(mesh.vertex_count())?;
    let deviation = deviation.bypass_change_detection();
    let constants = &recipe.constants.margins;
    if recipe.drive != Drive::Soft || constants.rigidity >= 1.0 {
        return Ok(());
    }
    if let Some(time_my) = clock.reorganisation.due() {
        springs::relax(mesh, deviation, time_my, constants.flow);
    }
    let Some(time_my) = clock.margins.due() else {
        return Ok(());
    };

    let table = PlateTable::gather(plates.iter());
    let mut pushes = collision_pushes(&recipe, &boundaries, mesh, plate);
    let colliding: BTreeSet<u32> = pushes.iter().map(|(vertex, _)| *vertex).collect();
    let age = |v: u32| clock.time_my - f64::from(created[v as usize].0);
    let arcs = Arcs {
        workers: &workers,
        recipe: &recipe,
        mesh,
        plate,
        crust,
        thickness: thickness.bypass_change_detection(),
    };
    pushes.extend(arcs.pushes(&boundaries, &table, age));
    keep_strongest(&mut pushes);
    // What each plate has to bend: vertices that are pushed, and all that still moves.
    let mut seeds: BTreeMap<PlateId, (Vec<(u32, DVec3)>, Vec<u32>)> = BTreeMap::new();
    for push in pushes {
        seeds
            .entry(plate[push.0 as usize])
            .or_default()
            .0
            .push(push);
    }
    let moving = workers.map(deviation.len(), |rows| {
        let moves = |&v: &u32| deviation[v as usize].0 != Vec3::ZERO;
        (rows.start as u32..rows.end as u32)
            .filter(moves)
            .collect::<Vec<u32>>()
    });
    for v in moving.into_iter().flatten() {
        seeds.entry(plate[v as usize]).or_default().1.push(v);
    }
    // Springs hold one plate together and never two: plates bend side by side.
    let places = Places::new(mesh.vertex_count());
    let before = Ground {
        recipe: &recipe,
        mesh,
        plate,
        deviation,
        time: time_my,
    };
    // Large ones first: no thread is left with one at the end.
    let mut seeds: Vec<_> = seeds.into_iter().collect();
    seeds.sort_by_key(|(_, (pushes, moving))| Reverse(pushes.len() + moving.len()));
    let margins = workers.run(seeds.into_iter(), |seeds| {
        let (plate, (pushes, moving)) = seeds;
        Margin::around(&before, &places, plate, pushes, &moving)
    });
    let bent = workers.run(margins.iter(), |margin| margin.bend(&before, &places));

    let (thickness, area) = (
        thickness.bypass_change_detection(),
        area.bypass_change_detection(),
    );
    let orogeny = orogeny.bypass_change_detection();
    let began = began.bypass_change_detection();
    let fold = fold.bypass_change_detection();
    for (margin, bent) in margins.iter().zip(bent) {
        for (edge, rest) in bent.rests {
            mesh.payload_mut(edge).rest = rest;
        }
        for (edge, rest) in bent.cross_rests {
            mesh.payload_mut(edge).cross_rest = rest;
        }
        let bent = bent.deviation.into_iter().zip(bent.strain);
        for (place, (&v, (new, strain))) in margin.vertices.iter().zip(bent).enumerate() {
            let v = v as usize;
            deviation[v] = new;
            // Volume = thickness × area stays, to within rounding, which is booked.
            let ratio = 1.0 + strain.clamp(-LARGEST_STRAIN, LARGEST_STRAIN);
            let fits = thickness[v].0 / ratio <= recipe.constants.collisions.thickest
                && area[v].0 * ratio >= LEAST_AREA * recipe.cell_area_km2();
            if ratio > 1.0 || fits {
                let volume = thickness[v].0 * area[v].0;
                area[v].0 = round_area(area[v].0 * ratio);
                thickness[v].0 = round(volume / area[v].0, THICKNESS_STEPS);
                if crust[v].is_continental() {
                    ledger.rounded_km3 += thickness[v].0 * area[v].0 - volume;
                }
            }
            let since = clock.time_my - f64::from(began[v].0);
            let is_pressed = -strain > PRESSING * time_my && crust[v].is_continental();
            if is_pressed && (orogeny[v] == Orogeny::None || since > NOTED) {
                let site = mesh.site(v as u32);
                if orogeny[v] == Orogeny::None {
                    let Some(front) = margin.pushed_by(place) else {
                        continue;
                    };
                    orogeny[v] = if colliding.contains(&front) {
                        Orogeny::Himalayan
                    } else {
                        Orogeny::Andean
                    };
                }
                let slip = deviation[v].0.as_dvec3();
                fold[v].0 = folded(fold[v].0, slip, site, since.min(2.0 * NOTED).max(time_my));
                began[v].0 = clock.time_my as f32;
            }
        }
    }
    Ok(())
}

/// Speeds in km/My with which colliding fronts yield, inward, by vertex.
fn collision_pushes(
    recipe: &Recipe,
    boundaries: &Boundaries,
    mesh: &SphereMesh<EdgeState>,
    plate: &[PlateId],
) -> Vec<(u32, DVec3)> {
    let spacing = recipe.spacing_km();
    let mut pushes: Vec<(u32, DVec3)> = Vec::new();
    for front in &boundaries.fronts {
        if !front.continental || front.opening >= 0.0 {
            continue;
        }
        let [u, v] = front.vertices;
        let distance = mesh.site(u).distance(mesh.site(v)) * recipe.radius_km;
        // Yggdrasill: 1 / (1 + (max(0, d − d_min) / d_min)²), with d_min at the local scale.
        let far = (distance - 0.7 * spacing).max(0.0) / (0.7 * spacing);
        let falloff = 1.0 / (1.0 + far * far);
        let speed = 0.5 * recipe.constants.margins.shortening * -front.opening * falloff;
        if speed < LEAST_PUSH {
            continue;
        }
        for (vertex, inward) in [(u, -front.direction), (v, front.direction)] {
            if plate[vertex as usize].0 != 0 {
                pushes.push((vertex, inward * speed));
            }
        }
    }
    pushes
}

/// Leaves each vertex the strongest of its pushes, in the order of vertices.
fn keep_strongest(pushes: &mut Vec<(u32, DVec3)>) {
    pushes.sort_by(|a, b| {
        a.0.cmp(&b.0)
            .then(b.1.length_squared().total_cmp(&a.1.length_squared()))
    });
    pushes.dedup_by_key(|(vertex, _)| *vertex);
}

/// Continents above trenches.
struct Arcs<'a> {
    workers: &'a Workers,
    recipe: &'a Recipe,
    mesh: &'a SphereMesh<EdgeState>,
    plate: &'a [PlateId],
    crust: &'a [Crust],
    thickness: &'a [Thickness],
}

impl Arcs<'_> {
    /// Speeds in km/My with which continents yield over a trench, by vertex: inward where they advance on
    /// it (Heuret & Lallemand 2005: what strains an overriding plate is its own motion towards the trench),
    /// seaward where the slab is old and sinks away from them (Molnar & Atwater 1978, Sdrolias & Müller 2006).
    fn pushes(
        &self,
        boundaries: &Boundaries,
        table: &PlateTable,
        age: impl Fn(u32) -> f64,
    ) -> Vec<(u32, DVec3)> {
        let constants = &self.recipe.constants.margins;
        let highest = self.recipe.constants.uplift.plateau_thickness;
        let mut pushes = Vec::new();
        // Overriding vertex, and the speed with which its slab draws it seaward.
        let mut drawn: Vec<(u32, DVec3)> = Vec::new();
        for front in &boundaries.fronts {
            let (Some(under), true) = (front.under, front.opening < 0.0) else {
                continue;
            };
            let over = 1 - under;
            let vertex = front.vertices[over];
            if front.continental || !self.crust[vertex as usize].is_continental() {
                continue;
            }
            // From the overriding plate to the trench.
            let seaward = if over == 0 {
                front.direction
            } else {
                -front.direction
            };
            let motion =
                table.rotation(front.plates[over]).cross(front.midpoint) * self.recipe.radius_km;
            let advance = motion.dot(seaward).min(-front.opening);
            // A plateau that has grown as high as it can stand passes the push on, and it dies out.
            let room = ((highest - self.thickness[vertex as usize].0) / ROOM).clamp(0.0, 1.0);
            let old = rollback_share(constants, age(front.vertices[under]));
            let speed = constants.cordillera * advance * room * (1.0 - old);
            if speed >= LEAST_PUSH {
                pushes.push((vertex, -seaward * speed));
            }
            if old > 0.0 {
                drawn.push((vertex, seaward * (constants.rollback * old)));
            }
        }
        pushes.extend(self.stretched(drawn));
        pushes
    }

    /// Speeds in km/My with which what lies behind fronts that are drawn seaward follows them, by vertex: it is
    /// stretched evenly from the trench inland, until its crust is thin.
    fn stretched(&self, mut drawn: Vec<(u32, DVec3)>) -> Vec<(u32, DVec3)> {
        let constants = &self.recipe.constants.margins;
        if drawn.is_empty() {
            return Vec::new();
        }
        keep_strongest(&mut drawn);
        let half = 0.5 * self.recipe.spacing_km();
        let sources: Vec<(u32, f64)> = drawn.iter().map(|&(v, _)| (v, half)).collect();
        // On a coarse mesh at least the front itself.
        let limit = constants.rollback_reach.max(2.0 * half);
        let mut behind = reach(
            self.workers,
            self.mesh,
            self.recipe.radius_km,
            &sources,
            limit,
            |v| self.crust[v as usize].is_continental(),
        )
        .found;
        let front_of = |source: u32| drawn[source as usize].0 as usize;
        behind.retain(|&(v, _, source)| self.plate[v as usize] == self.plate[front_of(source)]);
        let mut means = vec![[0.0; 2]; drawn.len()];
        for &(v, _, source) in &behind {
            let [sum, count] = &mut means[source as usize];
            *sum += self.thickness[v as usize].0;
            *count += 1.0;
        }
        let speed = |(v, distance, source): (u32, f64, u32)| {
            let [sum, count] = means[source as usize];
            let thins = ((sum / count - constants.rollback_thinnest) / ROOM).clamp(0.0, 1.0);
            let along = 1.0 - distance / limit;
            (v, drawn[source as usize].1 * (thins * along))
        };
        let pushes = behind.into_iter().map(speed);
        pushes
            .filter(|(_, push)| push.length() >= LEAST_PUSH)
            .collect()
    }
}

/// How much a slab of this age in My at the trench rolls back: not at all while it is young and buoyant, fully once
/// it is old. Where rolling back is turned off, every slab presses.
fn rollback_share(constants: &MarginConstants, age: f64) -> f64 {
    if constants.rollback <= 0.0 {
        return 0.0;
    }
    let (from, to) = (constants.rollback_from, constants.rollback_full);
    ((age - from) / (to - from).max(1e-9)).clamp(0.0, 1.0)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::simulation::fixtures::even_mesh;

    #[test]
    fn young_slabs_press_and_old_ones_roll_back() {
        let none = MarginConstants {
            rollback: 0.0,
            ..MarginConstants::default()
        };
        assert_eq!(rollback_share(&none, 180.0), 0.0);
        let constants = MarginConstants {
            rollback_from: 50.0,
            rollback_full: 80.0,
            ..MarginConstants::default()
        };
        for (age, share) in [
            (0.0, 0.0),
            (50.0, 0.0),
            (65.0, 0.5),
            (80.0, 1.0),
            (180.0, 1.0),
        ] {
            assert!((rollback_share(&constants, age) - share).abs() < 1e-12);
        }
    }

    /// What a front on the equator, drawn southward at 20 km/My, does to a continent in the north, 30 or 36 km thick,
    /// of two plates.
    fn drawn(thickness: f64) -> (SphereMesh<EdgeState>, u32, Vec<(u32, DVec3)>) {
        let mesh = even_mesh::<EdgeState>(6000);
        let mut recipe = Recipe::earth_like(1).with_sub_plates(6000);
        recipe.constants.margins.rollback_reach = 2000.0;
        recipe.constants.margins.rollback_thinnest = 25.0;
        let sites = mesh.sites();
        let crust: Vec<Crust> = (sites.iter())
            .map(|site| {
                if site.z > 0.0 {
                    Crust::Continental
                } else {
                    Crust::Oceanic
                }
            })
            .collect();
        let plate: Vec<PlateId> = (sites.iter())
            .map(|site| PlateId(if site.y < 0.0 { 1 } else { 2 }))
            .collect();
        let thickness = vec![Thickness(thickness); sites.len()];
        let arcs = Arcs {
            workers: &Workers::default(),
            recipe: &recipe,
            mesh: &mesh,
            plate: &plate,
            crust: &crust,
            thickness: &thickness,
        };
        let of_first = |v: &u32| {
            let site = mesh.site(*v);
            site.z > 0.0 && site.y < -0.1
        };
        let front = (0..6000).filter(of_first);
        let front = front
            .min_by(|&a, &b| mesh.site(a).z.total_cmp(&mesh.site(b).z))
            .unwrap();
        let pushes = arcs.stretched(vec![
            (front, DVec3::NEG_Z * 20.0),
            (front, DVec3::NEG_Z * 5.0),
        ]);
        assert!(
            pushes
                .iter()
                .all(|&(v, _)| plate[v as usize].0 == 1 && crust[v as usize].is_continental())
        );
        (mesh, front, pushes)
    }

    #[test]
    fn a_margin_is_stretched_evenly_behind_its_front() {
        let (mesh, front, pushes) = drawn(36.0);
        let half = 0.5 * Recipe::earth_like(1).with_sub_plates(6000).spacing_km();
        assert!(pushes.len() > 30);
        for (v, push) in pushes {
            assert_eq!([push.x, push.y], [0.0; 2]);
            // Along edges of the mesh, the way is longer than the chord by the root of two at most.
            let chord = mesh.site(v).distance(mesh.site(front)) * 6371.0;
            let way = 2000.0 * (1.0 + push.z / 20.0) - half;
            assert!(
                way > 0.999 * chord - 1e-3 && way < 1.42 * chord + 1e-3,
                "{way} {chord}"
            );
        }
    }

    #[test]
    fn stretching_dies_out_as_the_crust_thins() {
        let fastest = |thickness: f64| {
            let pushes = drawn(thickness).2;
            pushes
                .iter()
                .map(|(_, push)| push.length())
                .fold(0.0, f64::max)
        };
        // (30 − 25)/10 of the speed over 36 km.
        assert!((fastest(30.0) / fastest(36.0) - 0.5).abs() < 1e-9);
        assert_eq!(fastest(25.0), 0.0);
    }
}
