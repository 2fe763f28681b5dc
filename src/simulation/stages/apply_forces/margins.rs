//! Soft margins: what pushes them, and what it makes of their crust.
//!
//! Where continents collide, their fronts yield by a share of the closing speed (Yggdrasill's
//! response, with its falloff over the distance of the two ends); where a continent advances on a trench,
//! its margin is shortened into a cordillera. Springs carry that inland ([`springs`](super::springs)), and what a
//! cell loses or gains in area thickens or thins its crust. What is shortened is a mountain belt for as long as it
//! is: its thick crust does not flow away.

use super::{
    super::super::{
        boundaries::Boundaries,
        clock::Clock,
        columns::Columns,
        error::TectonicError,
        ledger::Ledger,
        plate::{Plate, PlateBorn, PlateTable, Rotation},
        precision::{THICKNESS_STEPS, round, round_area},
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
    let (plate, crust, mut deviation, mut thickness, mut area, mut orogeny, mut began, mut fold) =
        sub_plates.columns(mesh.vertex_count())?;
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
    pushes.extend(cordillera_pushes(
        &recipe,
        &boundaries,
        &table,
        crust,
        thickness.bypass_change_detection(),
    ));
    pushes.sort_by(|a, b| {
        a.0.cmp(&b.0)
            .then(b.1.length_squared().total_cmp(&a.1.length_squared()))
    });
    pushes.dedup_by_key(|(vertex, _)| *vertex);
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

/// Speeds in km/My with which continents yield over a trench that they advance on, inward, by vertex
/// (Heuret & Lallemand 2005: what strains an overriding plate is its own motion towards the trench).
fn cordillera_pushes(
    recipe: &Recipe,
    boundaries: &Boundaries,
    table: &PlateTable,
    crust: &[Crust],
    thickness: &[Thickness],
) -> Vec<(u32, DVec3)> {
    let constants = &recipe.constants.margins;
    let highest = recipe.constants.uplift.plateau_thickness;
    let mut pushes = Vec::new();
    for front in &boundaries.fronts {
        let (Some(under), true) = (front.under, front.opening < 0.0) else {
            continue;
        };
        let over = 1 - under;
        let vertex = front.vertices[over] as usize;
        if front.continental || !crust[vertex].is_continental() {
            continue;
        }
        // From the overriding plate to the trench.
        let seaward = if over == 0 {
            front.direction
        } else {
            -front.direction
        };
        let motion = table.rotation(front.plates[over]).cross(front.midpoint) * recipe.radius_km;
        let advance = motion.dot(seaward).min(-front.opening);
        // A plateau that has grown as high as it can stand passes the push on, and it dies out.
        let room = ((highest - thickness[vertex].0) / ROOM).clamp(0.0, 1.0);
        let speed = constants.cordillera * advance * room;
        if speed >= LEAST_PUSH {
            pushes.push((vertex as u32, -seaward * speed));
        }
    }
    pushes
}
