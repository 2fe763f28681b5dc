//! Stage 8: Delaunay by flips, slivers, Delaunay again.

use super::super::{
    clock::Clock,
    columns::Columns,
    error::TectonicError,
    stages::reorganize_plates::Splits,
    sub_plate::{PlateId, Position, SubPlate},
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
    mut sub_plates: Query<(&mut Position, &PlateId), With<SubPlate>>,
) -> Result<(), TectonicError> {
    let mesh = &mut topology.0;
    let (mut position, plate) = sub_plates.columns(mesh.vertex_count())?;
    let failed = |source| TectonicError::Repair {
        time_my: clock.time_my,
        source,
    };
    // The sweep is the work; what it finds is next to nothing.
    let suspects = workers.map(mesh.edge_slots(), |slots| mesh.non_delaunay_edges(slots));
    let mut flips = mesh.repair_from(suspects.concat()).map_err(failed)?;
    let moved = mesh.repair_slivers(FLATTEST, |_| true).map_err(failed)?;
    if !moved.moved.is_empty() {
        let position = position.bypass_change_detection();
        for v in moved.moved {
            position[v as usize].0 = mesh.site(v).as_vec3();
            // The column is what counts: the mesh takes the rounded place.
            mesh.set_site(v, position[v as usize].0.as_dvec3().normalize());
        }
        flips.extend(moved.flips);
        flips.extend(mesh.repair_delaunay().map_err(failed)?);
    }
    splits.note_flips(&flips, plate);
    Ok(())
}
