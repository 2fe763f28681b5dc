//! Stage 8: Delaunay by flips, slivers, Delaunay again.

use super::super::{
    clock::Clock,
    columns::Columns,
    error::TectonicError,
    stages::{
        reorganize_plates::{Splits, cut_by_flips},
        resolve_collisions::edges_around,
    },
    sub_plate::{Deviation, PlateId, Position, SubPlate, Velocity},
    topology::Topology,
    workers::Workers,
};
use bevy::prelude::*;

/// Triangles flatter than this share of their longest side are slivers.
const FLATTEST: f64 = 0.04;

/// Restores the Delaunay property of the whole mesh, by exact predicates.
pub(in crate::simulation) fn repair_mesh(
    clock: Res<Clock>,
    workers: Res<Workers>,
    mut topology: ResMut<Topology>,
    mut splits: ResMut<Splits>,
    mut sub_plates: Query<(&mut Position, &mut Velocity, &PlateId, &mut Deviation), With<SubPlate>>,
) -> Result<(), TectonicError> {
    let mesh = &mut topology.0;
    let (mut position, mut velocity, plate, mut deviation) =
        sub_plates.columns(mesh.vertex_count())?;
    let failed = |source| TectonicError::Repair {
        time_my: clock.time_my,
        source,
    };
    // The sweep is the work; what it finds is next to nothing. Slivers arise only where plates meet
    // or bend.
    let found = workers.map(mesh.edge_slots(), |slots| {
        let fronts: Vec<u32> = (slots.start as u32..slots.end as u32)
            .filter(|&edge| mesh.is_edge(edge))
            .map(|edge| mesh.endpoints(edge))
            .filter(|&(u, v)| plate[u as usize] != plate[v as usize])
            .flat_map(|(u, v)| [u, v])
            .collect();
        (mesh.edges_to_repair(slots), fronts)
    });
    let (suspects, fronts): (Vec<_>, Vec<_>) = found.into_iter().unzip();
    let mut flips = mesh.repair_from(suspects.concat()).map_err(failed)?;
    let mut restless = fronts.concat();
    restless.extend(
        (0..deviation.len() as u32).filter(|&v| deviation[v as usize].0 != glam::Vec3::ZERO),
    );
    restless.sort_unstable();
    restless.dedup();
    let moved = mesh
        .repair_slivers_among(restless, FLATTEST, |_| true)
        .map_err(failed)?;
    if !moved.moved.is_empty() {
        let position = position.bypass_change_detection();
        let velocity = velocity.bypass_change_detection();
        let deviation = deviation.bypass_change_detection();
        for &v in &moved.moved {
            position[v as usize].0 = mesh.site(v).as_vec3();
            // The column is what counts: the mesh takes the rounded place.
            let site = position[v as usize].0.as_dvec3().normalize();
            mesh.set_site(v, site);
            for motion in [&mut velocity[v as usize].0, &mut deviation[v as usize].0] {
                let along = motion.as_dvec3();
                *motion = (along - site * site.dot(along)).as_vec3();
            }
        }
        flips.extend(moved.flips);
        let rounded = edges_around(mesh, &moved.moved);
        flips.extend(mesh.repair_from(rounded).map_err(failed)?);
    }
    let cuts: Vec<[u32; 2]> = cut_by_flips(&flips, plate).collect();
    splits.note_cuts(mesh, plate, &cuts);
    Ok(())
}
