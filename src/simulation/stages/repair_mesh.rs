//! Stage 8: Delaunay by flips, slivers, Delaunay again.

use super::super::{
    boundaries::Unsettled,
    clock::Clock,
    columns::Columns,
    error::TectonicError,
    stages::reorganize_plates::{Carried, Splits, cut_by_flips},
    sub_plate::{Deviation, PlateId, Position, SubPlate, Velocity},
    topology::Topology,
    workers::Workers,
};
use bevy::prelude::*;

/// Triangles flatter than this share of their longest side are slivers.
const FLATTEST: f64 = 0.04;

/// Restores the Delaunay property, by exact predicates, wherever plates meet or bend.
pub(in crate::simulation) fn repair_mesh(
    clock: Res<Clock>,
    workers: Res<Workers>,
    mut topology: ResMut<Topology>,
    mut splits: ResMut<Splits>,
    mut unsettled: ResMut<Unsettled>,
    mut sub_plates: Query<(&mut Position, &mut Velocity, &PlateId, &mut Deviation), With<SubPlate>>,
) -> Result<(), TectonicError> {
    let mesh = &mut topology.0;
    let (mut position, mut velocity, plate, mut deviation) =
        sub_plates.columns(mesh.vertex_count())?;
    let failed = |source| TectonicError::Repair {
        time_my: clock.time_my,
        source,
    };
    // What neither lies at a front nor bends has turned as one body and is Delaunay still, but for the
    // rounding of thousands of steps: all edges are looked at now and then.
    let bends = |deviation: &Deviation| deviation.0 != glam::Vec3::ZERO;
    let bent = workers.map(deviation.len(), |rows| {
        deviation[rows].iter().map(bends).collect::<Vec<bool>>()
    });
    let mut is_restless = bent.concat();
    for v in unsettled.0.drain(..) {
        is_restless[v as usize] = true;
    }
    let restless = workers.map(is_restless.len(), |rows| {
        let rows = rows.start as u32..rows.end as u32;
        rows.filter(|&v| is_restless[v as usize])
            .collect::<Vec<u32>>()
    });
    let restless = restless.concat();
    let found = workers.map(restless.len(), |part| {
        mesh.faults_around(&restless[part], |v| is_restless[v as usize], FLATTEST)
    });
    let mut suspects: Vec<u32> = Vec::new();
    let mut slivers: Vec<u32> = Vec::new();
    for faults in found {
        suspects.extend(faults.edges);
        slivers.extend(faults.slivers);
    }
    let repaired = if clock.reorganisation.due().is_some() {
        let found = workers.map(mesh.edge_slots(), |slots| mesh.edges_to_repair(slots));
        mesh.repair_from(found.concat())
    } else {
        mesh.repair_locally(suspects)
    };
    let mut flips = repaired.map_err(failed)?;
    let moved = mesh
        .repair_slivers_from(slivers, &flips, FLATTEST, |_| true)
        .map_err(failed)?;
    if !moved.moved.is_empty() {
        let position = position.bypass_change_detection();
        let velocity = velocity.bypass_change_detection();
        let deviation = deviation.bypass_change_detection();
        for &v in &moved.moved {
            let site = mesh.site(v);
            position[v as usize].0 = site.as_vec3();
            for motion in [&mut velocity[v as usize].0, &mut deviation[v as usize].0] {
                let along = motion.as_dvec3();
                *motion = (along - site * site.dot(along)).as_vec3();
            }
        }
        flips.extend(moved.flips);
    }
    let plates = Carried::by(plate);
    let cuts: Vec<[u32; 2]> = cut_by_flips(&flips, plates).collect();
    splits.note_cuts(mesh, plates, &cuts);
    Ok(())
}
