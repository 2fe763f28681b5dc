//! Stage 1: cells split where detail is wanted, and merge where nothing happens.
//!
//! A cell's target grows from the nominal area at boundaries, coasts and mountains to
//! `contrast` times that in dull places. Splitting halves no quantity: the new sub-plate takes a
//! third of the two between which it lies, area and volume. Kinds of crust never mix.

use super::super::{
    clock::Clock,
    columns::Columns,
    error::TectonicError,
    reach::reach,
    recipe::Recipe,
    stages::{
        Splits,
        reorganize_plates::{Carried, cut_by_flips},
        resolve_collisions::edges_around,
    },
    sub_plate::*,
    topology::{EdgeState, Topology},
    workers::Workers,
};
use crate::mesh::SphereMesh;
use bevy::prelude::*;

/// Distance from the nearest feature at which a place is fully dull, in km.
const DULL: f64 = 1500.0;
/// Land higher than this counts as mountains, in m.
const MOUNTAINS: f32 = 1500.0;

type RefineColumns = (
    Entity,
    &'static PlateId,
    &'static Crust,
    &'static Elevation,
    &'static mut Thickness,
    &'static mut MaterialArea,
    &'static Created,
    &'static Velocity,
    &'static RidgeDirection,
    &'static FoldDirection,
    &'static Orogeny,
    &'static OrogenyBegan,
    &'static mut Volcanism,
);

/// Splits cells that are too large for where they lie and merges those that are too small.
pub(in crate::simulation) fn refine(
    mut commands: Commands,
    recipe: Res<Recipe>,
    clock: Res<Clock>,
    workers: Res<Workers>,
    mut topology: ResMut<Topology>,
    mut splits: ResMut<Splits>,
    mut sub_plates: Query<RefineColumns, With<SubPlate>>,
) -> Result<(), TectonicError> {
    if clock.refinement.due().is_none() {
        return Ok(());
    }
    let mesh = &mut topology.0;
    let (
        entity,
        plate,
        crust,
        elevation,
        mut thickness,
        mut area,
        created,
        velocity,
        ridge,
        fold,
        orogeny,
        began,
        mut volcanism,
    ) = sub_plates.columns(mesh.vertex_count())?;
    let thickness = thickness.bypass_change_detection();
    let area = area.bypass_change_detection();
    let volcanism = volcanism.bypass_change_detection();
    let constants = &recipe.constants.refine;
    let targets = targets(&recipe, &workers, mesh, plate, crust, elevation);
    let cells = shares_of_triangles(&workers, mesh, recipe.radius_km);
    let rows = cells.len();
    let mut newborn: Vec<PlateId> = Vec::new();
    let mut born = Vec::new();
    let mut touched = vec![false; rows];
    let interior = |mesh: &SphereMesh<EdgeState>, v: u32| {
        mesh.neighbours(v)
            .all(|w| (w as usize) < rows && plate[w as usize] == plate[v as usize])
    };

    // Merge first: what it frees need not be split.
    let mut gone: Vec<u32> = Vec::new();
    // Where the mesh has changed.
    let mut changed: Vec<u32> = Vec::new();
    for v in 0..rows as u32 {
        let i = v as usize;
        if touched[i] || cells[i] >= constants.merge_below * targets[i] || !interior(mesh, v) {
            continue;
        }
        let alike = |w: u32| crust[w as usize] == crust[i];
        let ring: Vec<u32> = mesh.neighbours(v).collect();
        if !ring.iter().all(|&w| alike(w) && !touched[w as usize]) || mesh.degree(v) <= 3 {
            continue;
        }
        let Some(h) = mesh.best_collapse(v, alike) else {
            continue;
        };
        let heir = mesh.dest(h) as usize;
        let volume = thickness[i].0 * area[i].0 + thickness[heir].0 * area[heir].0;
        volcanism[heir] = volcanism[heir].mixed(area[heir].0, volcanism[i], area[i].0);
        area[heir].0 += area[i].0;
        thickness[heir].0 = volume / area[heir].0;
        mesh.collapse(h);
        for &w in &ring {
            touched[w as usize] = true;
        }
        changed.extend(ring);
        touched[i] = true;
        gone.push(v);
    }
    // Split the longest edge of what is too large.
    for v in 0..rows as u32 {
        let i = v as usize;
        if touched[i] || cells[i] <= constants.split_above * targets[i] || !interior(mesh, v) {
            continue;
        }
        let longest = mesh
            .outgoing(v)
            .filter(|&h| {
                let w = mesh.dest(h) as usize;
                w < rows && !touched[w] && crust[w] == crust[i]
            })
            .max_by(|&a, &b| {
                let length = |h: u32| mesh.site(v).distance_squared(mesh.site(mesh.dest(h)));
                length(a).total_cmp(&length(b)).then(b.cmp(&a))
            });
        let Some(h) = longest else { continue };
        let j = mesh.dest(h) as usize;
        let site = (mesh.site(v) + mesh.site(j as u32)).normalize();
        let shares = [area[i].0 / 3.0, area[j].0 / 3.0];
        let volume = shares[0] * thickness[i].0 + shares[1] * thickness[j].0;
        area[i].0 -= shares[0];
        area[j].0 -= shares[1];
        changed.push(mesh.split_edge(h, site));
        touched[i] = true;
        touched[j] = true;
        let tangent = |w: glam::Vec3| {
            let n = site.as_vec3();
            w - n * n.dot(w)
        };
        newborn.push(plate[i]);
        born.push((
            (
                SubPlate,
                Position(site.as_vec3()),
                Velocity(tangent(0.5 * (velocity[i].0 + velocity[j].0))),
                plate[i],
                crust[i],
                Elevation(0.5 * (elevation[i].0 + elevation[j].0)),
                Thickness(volume / (shares[0] + shares[1])),
                MaterialArea(shares[0] + shares[1]),
            ),
            Created(0.5 * (created[i].0 + created[j].0)),
            RidgeDirection(tangent(ridge[i].0)),
            FoldDirection(tangent(fold[i].0)),
            orogeny[i],
            began[i],
            volcanism[i].mixed(shares[0], volcanism[j], shares[1]),
        ));
    }
    commands.spawn_batch(born);
    let queue = edges_around(mesh, &changed);
    let flips = mesh
        .repair_locally(queue)
        .map_err(|source| TectonicError::Repair {
            time_my: clock.time_my,
            source,
        })?;
    let plates = Carried {
        rows: plate,
        newborn: &newborn,
    };
    let cuts: Vec<[u32; 2]> = cut_by_flips(&flips, plates).collect();
    splits.note_cuts(mesh, plates, &cuts);
    gone.sort_unstable_by(|a, b| b.cmp(a));
    for v in gone {
        commands.entity(entity[v as usize]).despawn();
    }
    Ok(())
}

/// Area around every vertex in km²: a third of each triangle. Close to that of its cell, at a tenth
/// of the cost.
fn shares_of_triangles(workers: &Workers, mesh: &SphereMesh<EdgeState>, radius: f64) -> Vec<f64> {
    let share = |v: u32| {
        let site = mesh.site(v);
        let mut ring = mesh.neighbours(v).map(|w| mesh.site(w) - site);
        let first = ring.next().unwrap_or_default();
        let (mut last, mut doubled) = (first, 0.0);
        for spoke in ring.chain([first]) {
            doubled += last.cross(spoke).length();
            last = spoke;
        }
        doubled * radius * radius / 6.0
    };
    let parts = workers.map(mesh.vertex_count(), |rows| {
        let rows = rows.start as u32..rows.end as u32;
        rows.map(share).collect::<Vec<f64>>()
    });
    parts.concat()
}

/// Wanted area of every cell in km².
fn targets(
    recipe: &Recipe,
    workers: &Workers,
    mesh: &SphereMesh<EdgeState>,
    plate: &[PlateId],
    crust: &[Crust],
    elevation: &[Elevation],
) -> Vec<f64> {
    let cell = recipe.cell_area_km2();
    let contrast = recipe.constants.refine.contrast;
    if contrast <= 1.0 {
        return vec![cell; plate.len()];
    }
    let sources: Vec<(u32, f64)> = (0..plate.len() as u32)
        .filter(|&v| {
            let i = v as usize;
            elevation[i].0 > MOUNTAINS
                || mesh.neighbours(v).any(|w| {
                    plate[w as usize] != plate[i]
                        || (elevation[w as usize].0 > 0.0) != (elevation[i].0 > 0.0)
                        || crust[w as usize] != crust[i]
                })
        })
        .map(|v| (v, 0.0))
        .collect();
    let mut targets = vec![cell * contrast; plate.len()];
    for (v, distance, _) in reach(workers, mesh, recipe.radius_km, &sources, DULL, |_| true).found {
        targets[v as usize] = cell * (1.0 + (contrast - 1.0) * distance / DULL);
    }
    targets
}
